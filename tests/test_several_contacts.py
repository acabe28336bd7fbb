"""Systems of every kind of contact against an independent solver: ends, events and sides, with certified balances."""

import numpy as np
import pytest

import vibrocap as vc
from independent_contacts import motion as independent_motion
from mechanisms import MECHANISMS
from thinned import exhaustive_but

TOLERANCE, PERIODS = 1e-11, 3
EXACT = (1e-13, 1e-14)  # of the solver, whose slow turns are less sharp
UNEVEN = vc.anisotropic(vc.Coulomb)(0.1, 0.1, back_ratio=2.0)
DROPPING = vc.anisotropic(vc.Coulomb)(0.1, 0.18, back_ratio=1.4)
BRISTLES = vc.LuGre(coulomb_coefficient=0.1, static_coefficient=0.2)
DWELLING = vc.Trapezoid(amplitude=0.4, rise=0.2, hold=0.3, fall=0.2)
JAGGED = vc.Triangle(amplitude=0.3, rise=0.6)
THREE = vc.ThreeBodyWorm(mass_2=1.5, normal_load_2=1.2, normal_load_3=0.8, actuation_2=-0.6)
TWO = vc.TwoBodyWorm(mass_2=1.5, normal_load_2=1.2)
BLOCKS = vc.TwoBodyCrawler(mass_2=3.6, stiffness=3.9, damping=0.05, normal_load=1.0, normal_load_2=1.7)
LINKAGE = vc.LinkageCrawler(mass_ratio_2=1.7, stiffness=4.0)
SHAKEN = vc.Biharmonic(amplitude=0.5, frequency=1.3, second_amplitude=0.15, second_phase=0.5)
CAPSULE = vc.PendulumCapsule(mass_ratio=3.24, stiffness=1.89, damping=0.62, normal_load="dynamic")
AROUND = vc.Environment(inclination=0.03, linear_drag=0.05, quadratic_drag=0.1, force=0.02, gravity=1.0)
SPRINGS = vc.MaxwellSlip(coulomb_coefficient=0.2, static_coefficient=0.2, attraction_rate=5.0)

# machine, law of the first contact (others: of further ones, as the first where there is none), drive, start, the rest
SYSTEMS = {
    "two blocks": (BLOCKS, vc.Coulomb(0.1, 0.15), vc.Harmonic(0.7, 0.8), {"velocity": 0.6, "velocity_2": 0.8}, {}),
    "three blocks": (
        vc.ThreeBodyCrawler(mass_2=1.5, normal_load_3=2.0, actuation_2=-0.5),
        vc.LuGre(),
        vc.Square(1.2, 0.9, duty=0.4),
        {"velocity_2": 0.2},
        {"others": (vc.Coulomb(0.1, 0.15), DROPPING)},
    ),
    "block that its neighbours move": (
        vc.ThreeBodyCrawler(mass_2=2.7, normal_load_2=2.0, stiffness=0.6),
        vc.Coulomb(0.2, 0.4),
        vc.Trapezoid(amplitude=1.2),
        {},
        {"others": (BRISTLES, vc.Coulomb(0.2, 0.3))},
    ),
    "blocks on a slope": (
        BLOCKS,
        vc.Stribeck(),
        vc.Triangle(1.2, 0.6, 0.3),
        {"velocity": 0.2},
        {"environment": AROUND},
    ),
    "worm": (TWO, UNEVEN, vc.Harmonic(0.5, 0.9), {}, {}),
    "worm that drops": (TWO, DROPPING, vc.Harmonic(0.5, 0.9), {"centre_velocity": 0.1}, {}),
    "worm that dwells": (THREE, UNEVEN, DWELLING, {}, {}),
    "worm that dwells and drops": (THREE, DROPPING, DWELLING, {"centre_velocity": 0.2}, {}),
    "worm on bristles": (vc.TwoBodyWorm(mass_2=0.5, actuation=-1.0), BRISTLES, JAGGED, {"centre_velocity": 0.1}, {}),
    "worm on bristles that dwells": (vc.TwoBodyWorm(mass_2=0.5), BRISTLES, DWELLING, {}, {}),
    "worm on three kinds of bristles": (
        vc.ThreeBodyWorm(mass_2=0.6, actuation_2=-0.7),
        BRISTLES,
        DWELLING,
        {"centre_velocity": 0.2},
        {"others": (vc.Dahl(), vc.BoucWen())},
    ),
    "worm on springs": (TWO, vc.Dahl(), JAGGED, {"centre_velocity": 0.1}, {"others": (SPRINGS,)}),
    "worm on a slope": (THREE, vc.Coulomb(0.1, 0.15), JAGGED, {}, {"environment": AROUND, "others": (BRISTLES,)}),
    "five bodies": (vc.worm(5)(mass_2=0.7, normal_load_4=1.3, actuation_3=-1.2), DROPPING, DWELLING, {}, {}),
    "linkage": (LINKAGE, vc.Coulomb(0.1, 0.1), SHAKEN, {}, {}),
    "linkage that drops": (LINKAGE, DROPPING, vc.Square(0.4, 1.1), {"displacement": 0.05}, {"others": (UNEVEN,)}),
    "linkage on a slope": (LINKAGE, vc.Coulomb(0.1, 0.15), SHAKEN, {}, {"environment": AROUND, "others": (BRISTLES,)}),
    "capsule under its load": (
        CAPSULE,
        vc.anisotropic(vc.Coulomb)(0.1, 0.23, 0.83, 0.95),
        vc.Biharmonic(0.684, 1.118, 0.386),
        {"angle": 0.2},
        {},
    ),
    "block on a belt": (
        vc.ModeCouplingBlock(damping=0.1, belt_speed=0.2),
        DROPPING,
        vc.Biharmonic(0.5, 0.8, 0.2),
        {},
        {},
    ),
    "imposed mass": (vc.TwoMassCrawler(mass_ratio=1.5), DROPPING, DWELLING, {}, {}),
    "imposed angle": (vc.PendulumCrawler(mass_ratio=1.5), BRISTLES, vc.Biharmonic(1.0, 0.9, 0.3), {}, {}),
}
DESCRIBED = (vc.TwoPendulumCapsule, vc.DoublePendulumCapsule, vc.DrillString, vc.Clutch, vc.BristleRobot, *MECHANISMS)
AMPLITUDES = {"rod-robot": 0.5, "own-feeder": 0.5, "bristle-robot": 1.8}
FREQUENCIES = {"own-clutch": 2.0, "bristle-robot": 3.0}
STARTS = {"two-pendulum-capsule": {"angle": 0.6, "angle_2": -0.4}, "double-pendulum-capsule": {"angle": 0.3}}
SYSTEMS |= {
    kind.name: (
        kind(),
        vc.Exponential() if kind.name == "clutch" else vc.Exponential(0.05, 0.12),
        vc.Harmonic(AMPLITUDES.get(kind.name, 1.2), FREQUENCIES.get(kind.name, 1.0)),
        STARTS.get(kind.name, {}),
        {},
    )
    for kind in DESCRIBED
    if not kind.switched
}
KEPT = ["three blocks", "blocks on a slope", "worm on a slope", "linkage that drops", "capsule under its load"]
KEPT += ["block on a belt", "cubic-pendulum", "belt-row"]


def changes(events, end):
    """[(instant, kind)] in order of kinds, but what happens as the run ends."""
    return sorted((kind, float(time)) for time, kind in events if kind not in ("graze", "switch") and time < end - 1e-6)


@pytest.mark.slow
@pytest.mark.parametrize("name", exhaustive_but(map([*SYSTEMS].index, KEPT), [*SYSTEMS]))
def test_against_an_independent_solver(name):
    """Its end to ten tolerances times what a shift of the start grows to, the same events at the same instants."""
    machine, law, drive, start, given = SYSTEMS[name]
    laws = [law, *given.get("others", ())]
    laws += [None] * (len(machine.contact_states) - len(laws))
    system = vc.System(machine, laws, drive, environment=given.get("environment"))
    run = vc.simulate(system, periods=PERIODS, initial=start, tolerance=TOLERANCE)
    theirs = independent_motion(system, start, PERIODS, EXACT)
    assert run.status is vc.Status.FINISHED
    assert theirs.status == "finished"
    pushed = machine.contact_states[0]
    start = {pushed: start.get(pushed, 0.0) + 1e-7} | {key: value for key, value in start.items() if key != pushed}
    shifted = vc.simulate(system, periods=PERIODS, initial=start, tolerance=TOLERANCE)
    names = [each for each in theirs.state if each not in system.switched]
    ends = [np.array([each.state[key] for key in names]) for each in (run, shifted)]
    growth = max(1.0, float(np.max(np.abs(ends[1] - ends[0]))) / 1e-7)
    assert ends[0] == pytest.approx(np.array([theirs.state[key] for key in names]), abs=10.0 * TOLERANCE * growth)
    ours = changes([(event.time, event.kind) for event in run.events], run.end)
    expected = changes(theirs.events, run.end)
    assert [kind for kind, _ in ours] == [kind for kind, _ in expected]
    assert len(expected) > 3
    assert [time for _, time in ours] == pytest.approx([time for _, time in expected], abs=1e-5 * growth)
    assert run.certificate.ok, run.certificate.failures
    assert run.certificate.energy_residual < 100 * TOLERANCE
    assert run.certificate.momentum_residual < 100 * TOLERANCE
