"""Worms whose distances change at another rate from one instant on: every contact takes its new side at a corner."""

import dataclasses
import itertools
import math

import numpy as np
import pytest

import vibrocap as vc
from vibrocap.orbits.maps.stroboscopic_map import StroboscopicMap
from vibrocap.physics.catalogue import law
from worm_motions import KINDS, Worm

BRISTLES = {"coulomb_coefficient": 0.1, "static_coefficient": 0.2}
TRIANGLE = vc.Triangle(amplitude=0.3, rise=0.6)
EXAMPLE = vc.System(vc.TwoBodyWorm(mass_2=0.5, actuation=-1.0), vc.LuGre(**BRISTLES), TRIANGLE)
START = {"centre_velocity": 0.1}
GROWN = 30.0  # tolerances, over what a small shift of the start grows to


def corners(shape, period, periods):
    """(instants, slopes from there on) of a drive through points (share of the period, height), without dwells of 0."""
    pieces = [
        (x, (after - before) / ((y - x) * period))
        for (x, before), (y, after) in itertools.pairwise(shape)
        if y - x > 1e-12
    ]
    found = [((number + share) * period, slope) for number in range(periods) for share, slope in pieces]
    return [t for t, _ in found], [slope for _, slope in found]


def bristles(given, load=1.0):
    """The example's law, as the solver takes it."""
    plain = {"bristle_stiffness": 100.0, "bristle_damping": 10.0, "stribeck_velocity": 0.1}
    return KINDS["lugre"](plain | given, load)


def assert_same_turns(motion, worm, within):
    """Of every contact, at the same instants, known worse than the velocity where that hardly changes."""
    for number in range(1, len(worm.contacts) + 1):
        kind = "reversal" if number == 1 else f"reversal_{number}"
        ours = [event.time for event in motion.events if event.kind == kind]
        assert ours == pytest.approx([time for time, turned in worm.turns if turned == number], abs=within)


def test_a_contact_with_bristles_keeps_its_velocity_at_a_corner():
    """Body 2 turns at the corner, body 1 some 0.08 later: a further contact was stopped there, and all with it."""
    motion = vc.simulate(EXAMPLE, initial=START, periods=3, tolerance=1e-10)
    worm = Worm((1.0, 0.5), (-1.0,), [bristles(BRISTLES), bristles(BRISTLES)])
    shape = ((0.0, -0.3), (0.6, 0.3), (1.0, -0.3))
    position, velocity = worm.end(*corners(shape, TRIANGLE.period, 3), 0.1, motion.end)
    assert position == pytest.approx(1.7692, abs=5e-5)
    bound = GROWN * 1e-10 * 2.0 / 1.5  # it forgets its start
    assert motion.state["position"] == pytest.approx(position, abs=bound)
    assert motion.state["centre_velocity"] == pytest.approx(velocity, abs=bound)
    assert_same_turns(motion, worm, 1e-5)
    assert motion.certificate.ok, motion.certificate.failures
    corner = 0.6 * TRIANGLE.period
    first, second = (min(t for t, turned in worm.turns if turned == number and t > corner - 1e-9) for number in (1, 2))
    assert (first, second) == pytest.approx((corner + 0.0785, corner), abs=1e-4)
    # a motion that ends at the corner goes on from there
    begun = vc.simulate(EXAMPLE, initial=START, periods=0.6, tolerance=1e-10)
    rest = vc.simulate(EXAMPLE, start=begun, periods=2.4, tolerance=1e-10)
    assert rest.state["position"] == pytest.approx(position, abs=bound)


def numbers(draw, name):
    """Of a law, at random."""
    level = float(draw.uniform(0.08, 0.4))
    found = {"coulomb_coefficient": level}
    if name == "maxwell-slip":  # of equal levels: its springs never give way for an instant only
        return found | {"static_coefficient": level, "stribeck_velocity": 0.1, "attraction_rate": 5.0}
    found["bristle_stiffness"] = float(10.0 ** draw.uniform(1.0, 2.0))
    if name in ("lugre", "elasto-plastic"):
        found |= {"static_coefficient": level * float(draw.uniform(1.0, 2.0)), "stribeck_velocity": 0.15}
        found["bristle_damping"] = float(draw.uniform(0.0, 3.0))
    return found | ({"elastic_share": float(draw.uniform(0.3, 0.9))} if name == "elasto-plastic" else {})


def drawn(laws, seed):
    """(system, start, `Worm`, points of its drive) of these laws, with numbers at random; half of them dwell."""
    draw, bodies = np.random.default_rng([seed, len(laws[-1])]), len(laws)
    lengths = draw.uniform(0.05, 1.0, 4) * (1.0, seed % 2, 1.0, seed % 2)
    rise, hold, fall, _ = (lengths / sum(lengths)).tolist()
    drive = vc.Trapezoid(float(draw.uniform(0.05, 0.5)), float(draw.uniform(0.5, 2.0)), rise, hold, fall)
    masses, loads = draw.uniform(0.3, 2.0, bodies).tolist(), draw.uniform(0.5, 1.5, bodies).tolist()
    actuation = (draw.uniform(0.4, 1.2, bodies - 1) * draw.choice([-1.0, 1.0], bodies - 1)).tolist()
    given = [numbers(draw, name) for name in laws]

    def named(name, values):
        return {name if i == 1 else f"{name}_{i}": value for i, value in enumerate(values, start=1)}

    machine = named("mass", masses) | named("actuation", actuation) | named("normal_load", loads)
    frictions = named("friction", [law(name)(**own) for name, own in zip(laws, given, strict=True)])
    contacts = [KINDS[name](own, load) for name, own, load in zip(laws, given, loads, strict=True)]
    high, low = drive.amplitude, -drive.amplitude
    shape = ((0.0, low), (rise, high), (rise + hold, high), (min(rise + hold + fall, 1.0), low), (1.0, low))
    system = vc.System(vc.worm(bodies)(**machine), drive=drive, **frictions)
    return system, float(draw.uniform(-0.3, 0.3)), Worm(masses, actuation, contacts), shape


LAWS = (
    ("lugre", "lugre"),
    ("dahl", "maxwell-slip"),
    ("maxwell-slip", "elasto-plastic"),
    ("bouc-wen", "dahl"),
    ("lugre", "dahl", "bouc-wen"),
)


@pytest.mark.slow  # their kernels
@pytest.mark.parametrize("laws", LAWS, ids=["-".join(laws) for laws in LAWS])
def test_worms_with_corners_against_an_independent_solver(laws):
    """Eight of each at random: ends within 30 tolerances of what a shift of the start grows to, turn by turn."""
    tolerance, shift = 1e-10, 1e-5
    for seed in range(8):
        system, start, worm, shape = drawn(laws, seed)
        motion = vc.simulate(system, initial={"centre_velocity": start}, periods=2, tolerance=tolerance)
        shifted = vc.simulate(system, initial={"centre_velocity": start + shift}, periods=2, tolerance=tolerance)
        assert motion.certificate.ok, motion.certificate.failures
        speed = sum(contact.load for contact in worm.contacts) / worm.mass * motion.period / (2.0 * math.pi)
        sizes = np.array([speed * motion.period / (2.0 * math.pi), speed])
        ends = [np.array([each.state["position"], each.state["centre_velocity"]]) / sizes for each in (motion, shifted)]
        growth = max(1.0, np.max(np.abs(ends[1] - ends[0])) / (shift / speed))
        theirs = worm.end(*corners(shape, motion.period, 2), start, motion.end) / sizes
        assert np.max(np.abs(ends[0] - theirs)) <= GROWN * tolerance * growth, seed
        assert_same_turns(motion, worm, 1e-4)


@pytest.mark.slow  # its kernels
def test_orbits_and_ensembles_of_worms_with_corners():
    """The example's drift, as in its fifth period, travel at other strokes, and derivatives through corners."""
    shape = ((0.0, -1.0), (0.6, 1.0), (1.0, -1.0))

    def travelled(amplitude, first, last):
        worm = Worm((1.0, 0.5), (-1.0,), [bristles(BRISTLES), bristles(BRISTLES)])
        points = [(share, amplitude * height) for share, height in shape]
        ends = [
            worm.end(*corners(points, TRIANGLE.period, periods), 0.1, periods * TRIANGLE.period)[0] if periods else 0.0
            for periods in (first, last)
        ]
        return ends[1] - ends[0]

    little = {"coulomb_coefficient": 0.02, "static_coefficient": 0.03}  # so that a period forgets not all
    map_ = StroboscopicMap(dataclasses.replace(EXAMPLE, friction=vc.LuGre(**little)))
    points = [(share, 0.3 * height) for share, height in shape]
    push = 1e-5
    for velocity in (-0.05, 0.02):
        ends = [
            Worm((1.0, 0.5), (-1.0,), [bristles(little), bristles(little)]).end(
                *corners(points, TRIANGLE.period, 1), start, TRIANGLE.period
            )
            for start in (velocity - push, velocity + push)
        ]
        images = map_.images(np.array([[0.0, velocity, 0.0, 0.0]]), map_.parameters()[None])
        assert images.jacobian[0][:2, 1] == pytest.approx((ends[1] - ends[0]) / (2.0 * push), abs=2e-6)
    found = vc.orbit(EXAMPLE, initial=START)
    assert found.drift == pytest.approx(0.5874, abs=5e-5)
    assert found.drift == pytest.approx(travelled(0.3, 4, 5), abs=1e-9)
    assert found.stable
    assert found.motion().certificate.ok
    amplitudes = [0.15, 0.3, 0.45]
    together = vc.ensemble(
        EXAMPLE, {"drive.amplitude": amplitudes}, initial=START, periods=3, window=3, tolerance=1e-10
    )
    travel = together["mean_velocity"] * 3.0 * TRIANGLE.period
    assert travel == pytest.approx([travelled(amplitude, 0, 3) for amplitude in amplitudes], abs=GROWN * 1e-10 * 2.0)


@pytest.mark.slow  # its kernel
def test_what_a_contact_at_rest_holds_is_asked_once_the_others_have_turned():
    """Body 1 does not move at the corner; with bodies 2 and 3 on their old sides it could not hold what they push.

    Before it, R_2 + R_3 = 0.4 (1.2 - 1), with forces of the bristles alone; after it, at ten times the speed, bristles
    as they were and their damping: 0.08 + 3 d_2 v - 3 d_3 v, which is 0, but 0.08 - d_2 v + d_3 v = 0.107 on their old
    sides. Body 1 holds 0.1.
    """
    period, rise, slow = 2.0 * math.pi, 0.95, 0.05
    given = {"bristle_stiffness": 50.0, "coulomb_coefficient": 0.2, "static_coefficient": 0.4, "stribeck_velocity": 0.3}
    system = vc.System(
        vc.ThreeBodyWorm(actuation=1.0, actuation_2=-2.0, normal_load_3=1.2),
        [
            vc.Coulomb(0.1, 0.1),
            vc.LuGre(bristle_damping=0.1, **given),
            vc.LuGre(bristle_damping=0.1 + 0.08 / (3.0 * slow * rise / (1.0 - rise)), **given),
        ],
        vc.Triangle(amplitude=-0.5 * slow * rise * period, rise=rise),
    )
    motion = vc.simulate(system, periods=1.2)
    assert motion.certificate.ok
    assert [(event.kind, event.time) for event in motion.events] == [
        ("reversal_2", pytest.approx(rise * period)),
        ("reversal_3", pytest.approx(rise * period)),
        ("reversal_2", pytest.approx(period)),
        ("reversal_3", pytest.approx(period)),
    ]
    assert motion.state["position"] == 0.0


@pytest.mark.slow  # its kernel
def test_contacts_that_turn_together_are_all_told():
    """While the distance dwells both bodies move alike, and turn at one instant."""
    system = vc.System(
        vc.TwoBodyWorm(mass_2=0.5), vc.LuGre(**BRISTLES), vc.Trapezoid(amplitude=0.3, rise=0.2, hold=0.4, fall=0.2)
    )
    motion = vc.simulate(system, periods=1)
    dwell = [(event.time, event.kind) for event in motion.events if 0.2 < event.time / motion.period % 1.0 < 0.6]
    times = [[time for time, kind in dwell if kind == wanted] for wanted in ("reversal", "reversal_2")]
    assert len(times[0]) > 2
    assert times[0] == pytest.approx(times[1], abs=1e-14)
