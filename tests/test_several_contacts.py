"""Systems of every kind of contact against an independent solver: ends, events and sides, with certified balances."""

from typing import ClassVar

import numpy as np
import pytest

import vibrocap as vc
from independent import motion as independent_motion
from mechanisms import MECHANISMS
from renumbered import counterpart, renumbered
from thinned import exhaustive_but
from vibrocap.io.motion_file import columns
from vibrocap.measures.recorded.energy import EnergyBalance
from vibrocap.mechanics import Contact, Drive, Machine, Mass, Spring, coordinate, cos, parameters, sin
from vibrocap.physics.names import numbered

pytestmark = pytest.mark.plain

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
KEPT = ["three blocks", "worm on bristles", "worm on a slope", "linkage that drops", "capsule under its load"]


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


# --- numbered either way: what is measured of a contact is what is measured of its new number -----------------------

STEPPED = vc.Coulomb(0.2, 0.3)
PAIRED = {
    "blocks": (BLOCKS, (STEPPED, vc.Stribeck(0.15, 0.45, 0.1, 2.0)), SHAKEN),
    "row": (vc.TwoBlockRow(belt_speed=0.3), (STEPPED, BRISTLES), vc.Harmonic(amplitude=1.0)),
    "worm": (TWO, (STEPPED, vc.Coulomb()), SHAKEN),
    "linkage": (LINKAGE, (STEPPED, vc.Coulomb()), SHAKEN),
    "robot": (vc.BristleRobot(), (STEPPED, BRISTLES), vc.Harmonic(amplitude=1.8)),
    "three blocks": (vc.ThreeBlockRow(), (STEPPED, vc.Coulomb(), BRISTLES), vc.Harmonic(amplitude=1.0)),
}
NONE_OF_CONTACTS = ("displacement", "drift", "mean_velocity", "cost_of_transport")  # of the place of contact 1


def both_ways(name):
    """A system, and the same with its contacts numbered the other way."""
    machine, laws, drive = PAIRED[name]
    return vc.System(machine, [*laws], drive), vc.System(renumbered(machine), [*laws[::-1]], drive)


@pytest.mark.slow
@pytest.mark.parametrize("name", exhaustive_but([1, 3], [*PAIRED]))
def test_contacts_may_be_numbered_either_way(name):
    """Measures of motions and of ensembles, columns of files, loops, energies and certificates."""
    one, other = both_ways(name)
    motions = [vc.simulate(system, periods=5) for system in (one, other)]
    names = {key: counterpart(key, one) for key in vc.measure_table(one) if key not in NONE_OF_CONTACTS}
    table = vc.measure_table(other)
    assert {*names.values()} <= {*table}
    assert sum(name != now for name, now in names.items()) >= 14 * (len(one.laws) // 2)
    taken = vc.measured(motions[0], [*names], window=3), vc.measured(motions[1], [*names.values()], window=3)
    for key, now in names.items():
        before, after = taken[0][key], taken[1][now]
        assert before == (after if isinstance(after, str) else pytest.approx(after, rel=1e-7, abs=1e-7, nan_ok=True)), (
            key
        )
    files = [columns(motion) for motion in motions]
    assert {*files[1]} == {counterpart(file, one) for file in files[0]}
    for key, values in files[0].items():
        assert values == pytest.approx(files[1][counterpart(key, one)], abs=1e-7), key
    for contact in range(1, 1 + len(one.laws)):
        loops = (
            vc.friction_loop(motions[0], contact=contact),
            vc.friction_loop(motions[1], contact=1 + len(one.laws) - contact),
        )
        assert loops[0].velocity_area == pytest.approx(loops[1].velocity_area, abs=1e-8)
        whole = vc.measured(motions[0], numbered("displacement_loop_area", contact), window=1)
        assert loops[0].displacement_area == pytest.approx(next(iter(whole.values())), abs=1e-9)
    balances: list[EnergyBalance] = [vc.energy_balance(motion) for motion in motions]
    assert balances[0].contact_sliding == pytest.approx(balances[1].contact_sliding, abs=1e-8)
    certificates = [motion.certificate for motion in motions]
    assert [certificate.ok for certificate in certificates] == [True, True]
    for field in ("stick_force_ratio", "slip_shortfall", "least_reaction", "defect", "estimated_error"):
        before, after = (getattr(certificate, field) for certificate in certificates)
        assert before == (None if after is None else pytest.approx(after, rel=0.1, abs=1e-10))


@pytest.mark.slow
@pytest.mark.parametrize("name", exhaustive_but([0], ["blocks", "linkage"]))
def test_orbits_of_contacts_that_are_numbered_either_way(name):
    """Drift, multipliers and mode sequences."""
    orbits = [vc.orbit(system) for system in both_ways(name)]
    sequences = [orbit.mode_sequence.split("|") for orbit in orbits]
    assert sequences[0] == sequences[1][::-1]
    assert sequences[0] == [vc.mode_sequence(orbits[0].motion(), contact=i) for i in (1, 2)]
    assert orbits[0].mean_velocity == pytest.approx(orbits[1].mean_velocity, abs=1e-8)
    sizes = [np.sort(np.abs(orbit.multipliers)) for orbit in orbits]
    assert sizes[0] == pytest.approx(sizes[1], abs=1e-6)


def test_what_would_hold_a_further_contact_is_told_while_it_slides():
    """At coupled contacts it was the friction itself at all but the first, and its limit that of the present load."""
    one, other = both_ways("linkage")
    y, sides = (0.05, -0.1, 0.08, 0.12, 0.1, -0.05)[: len(one.state_names)], (1, -1)
    before, after = (flow.contacts for flow in (one.flow(0.3, y, sides), other.flow(0.3, y, sides[::-1])))
    for each, now in zip(before, after[::-1], strict=True):
        found, expected = ((c.held, c.limit, c.middle, c.friction, c.normal) for c in (each, now))
        assert found == pytest.approx(expected, rel=1e-12, abs=1e-12)
        assert abs(each.held - each.friction) > 1e-3


@parameters
class Towed(Machine):
    """A block and a pendulum capsule on a rope: loads are constants, so that no friction tells when it lifts off."""

    angle = coordinate("theta", "angle of the pendulum from upright", "rad")
    position = coordinate("X", "place of the block", "m")
    ahead = coordinate("Y", "place of the capsule", "m")
    name: ClassVar = "towed"
    effort: ClassVar = "torque"

    def parts(self, q):
        """Block, capsule and bob."""
        block = Mass("block", 1.0, x=q.position)
        capsule = Mass("capsule", 1.0, x=q.ahead)
        bob = Mass("bob", 1.0, on=capsule, x=sin(q.angle), z=cos(q.angle))
        springs = Spring(2.0, q.angle), Spring(5.0, q.ahead - q.position)
        return block, capsule, bob, springs, Drive(q.angle), Contact(block, load=1.0), Contact(capsule, load=2.0)


def test_a_lift_off_is_seen_at_any_contact():
    """Certificates asked the first alone."""
    motion = vc.simulate(vc.System(Towed(), vc.Coulomb(), vc.Harmonic(amplitude=3.0)), periods=2, tolerance=1e-7)
    assert (motion.certificate.least_reaction or 0.0) < -0.5
    assert "load on contact 2 would be negative" in motion.certificate.warnings[0]


@pytest.mark.slow
@pytest.mark.parametrize("turned", exhaustive_but([0], [False, True]))
def test_a_lift_off_is_counted_at_any_contact(turned):
    """By ensembles, which watched the first alone."""
    machine = renumbered(Towed()) if turned else Towed()
    system = vc.System(machine, vc.Coulomb(), vc.Harmonic(amplitude=3.0))
    options = {"periods": 3, "window": 3, "measures": ["hidden_lift_off"], "tolerance": 1e-7}
    results = vc.ensemble(system, {"drive.amplitude": [0.1, 3.0]}, **options)
    assert results["hidden_lift_off"].tolist() == [0.0, 1.0]
    motion = vc.simulate(system, periods=3, tolerance=1e-7)
    assert vc.measured(motion, "hidden_lift_off", window=3)["hidden_lift_off"] == 1.0
