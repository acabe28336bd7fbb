"""Grazing of stops: special points and ends of branches, crossings and borders of maps, against exact solutions.

The digits are those of `exact_stops.py`, in which nothing is stepped: `test_digits_are_those_of_exact_solutions`.
"""

import dataclasses

import numpy as np
import pytest

import vibrocap as vc
from exact_stops import ExactCapsule
from thinned import slow_but
from vibrocap.orbits.walk.kinds import BranchEnd
from vibrocap.studies.adaptive import border

COULOMB = vc.Coulomb(coulomb_coefficient=1.0, static_coefficient=1.0)
GAP = 1.585569343351221  # of the elastic stop, at frequency 0.65: the second of two impacts is grazed
FREQUENCY = 1.340611648028771  # at gap 2.2, near a fold: the only impact ends
FREE_GAP = 0.3307229673872138  # of the rigid stop at amplitude 0.1: the motion without impacts ends
AMPLITUDE = 0.7218940787103  # of the rigid stop at gap 1.2: a second impact in two periods
FLIP = 0.99623822467202370


def elastic(frequency, gap=0.02, **parameters):
    return vc.System(
        vc.VibroImpactCapsule(gap=gap, **parameters), COULOMB, vc.Harmonic(amplitude=1.6, frequency=frequency)
    )


def rigid(amplitude, **parameters):
    settings = {"gap": 1.2, "restitution": 0.6, "normal_load": 0.4, "mass_ratio": 5.0, "actuation": "external"}
    machine = vc.RigidStopCapsule(**(settings | parameters))
    return vc.System(machine, vc.Coulomb(0.3, 0.4), vc.Harmonic(amplitude=amplitude, frequency=0.95))


def grazing(branch):
    (found,) = branch.kind(vc.SpecialKind.GRAZING)
    return found


@pytest.mark.slow
def test_branch_crossing_and_map_find_the_same_grazing():
    system = elastic(0.65, gap=1.55)
    found = grazing(vc.branch(system, "machine.gap", (1.55, 1.6), step=0.05))
    assert found.parameter == pytest.approx(GAP, abs=1e-11)
    assert found.text == "impacts 2 -> 1"
    assert found.unstable_before == found.unstable_after == 0
    places = vc.crossing(system, "impacts", "machine.gap", (1.55, 1.6), value=1.5, points=3).found
    assert [place.kind for place in places] == [vc.CrossingKind.GRAZING]
    assert places[0].at == pytest.approx(GAP, abs=1e-11)
    over = {"machine.gap": [GAP - 1e-6, GAP + 1e-6]}
    counted = vc.ensemble(system, over, measures=["impacts"], periods=400, settle=1e-9, tolerance=1e-11)
    assert counted["impacts"].tolist() == [2.0, 1.0]


@pytest.mark.slow
def test_grazing_of_a_rigid_stop_ends_the_branch_without_impacts():
    branch = vc.branch(rigid(0.1), "machine.gap", (0.1, 2.0), step=0.05)
    assert branch.ends[0] is BranchEnd.GRAZING
    assert grazing(branch).parameter == pytest.approx(FREE_GAP, abs=1e-11)
    assert abs(branch.parameter[0] - FREE_GAP) < 1e-7
    assert "grazes" in branch.ends[0].advice


@pytest.mark.slow
def test_grazing_behind_a_fold_and_after_an_impact():
    folded = vc.branch(elastic(1.5, gap=2.2), "drive.frequency", (1.3, 1.6), step=0.05)
    kinds = [point.kind for point in folded.special_points]
    assert kinds.index(vc.SpecialKind.GRAZING) == kinds.index(vc.SpecialKind.FOLD) + 2
    assert grazing(folded).parameter == pytest.approx(FREQUENCY, abs=1e-11)
    assert grazing(folded).text == "impacts 1 -> 0"
    assert_exact(folded.orbit(grazing(folded).after_point + 1), "drive.frequency", FREQUENCY)
    struck = vc.branch(rigid(0.6), "drive.amplitude", (0.55, 0.8), step=0.05, towards="up")
    assert struck.ends[1] is BranchEnd.GRAZING
    assert grazing(struck).parameter == pytest.approx(AMPLITUDE, abs=1e-11)
    assert_exact(struck.orbit(len(struck) - 1), "drive.amplitude", AMPLITUDE)


@pytest.mark.plain
@pytest.mark.parametrize(
    "system", slow_but([0], [elastic(0.7, gap=0.1), rigid(1.2), elastic(0.7, gap=0.1, back_gap=0.3)])
)
def test_impacts_are_those_of_the_events(system):
    """During a run, of a stored motion, and counted by hand."""
    motion = vc.simulate(system, periods=8, tolerance=1e-11)
    last = motion.event_times > 3 * motion.period
    struck = (motion.event_kinds[last] == "impact").sum()
    assert struck >= 3
    assert vc.measured(motion, "impacts", window=5)["impacts"] == struck / 5.0
    options = {"measures": ["impacts"], "periods": 8, "window": 5, "tolerance": 1e-11}
    frequency = system.drive.frequency
    assert vc.ensemble(system, {"drive.frequency": [frequency]}, **options)["impacts"] == struck / 5.0


@pytest.mark.plain
def test_impacts_accumulate_where_a_mass_comes_to_rest_at_its_stop():
    """Not where it leaves the stop at which it began, and bounces; but also where it stays to the end of the window."""
    machine, law = vc.RigidStopCapsule(gap=0.1, back_gap=0.2, restitution=0.9), vc.Coulomb(0.3, 0.36)
    bounces = vc.System(machine, law, vc.Harmonic(amplitude=1.4, frequency=0.9))
    motion = vc.simulate(bounces, periods=3, initial={"displacement": 0.1, "touching": 1.0})
    kinds = [kind for kind in motion.event_kinds.tolist() if kind in ("impact", "stop_opened")]
    assert kinds[0] == "stop_opened" not in kinds[1:]
    assert vc.measured(motion, "impacts", window=3)["impacts"] == kinds.count("impact") / 3.0
    stays = vc.System(dataclasses.replace(machine, restitution=0.5), law, vc.Constant(force=1.0, duration=10.0))
    motion = vc.simulate(stays, periods=1)
    assert "stop_opened" not in motion.event_kinds
    assert vc.measured(motion, "impacts", window=1)["impacts"] == np.inf


@pytest.mark.slow
def test_impacts_that_accumulate_are_infinite_and_machines_without_stops_have_none():
    chatters = vc.RigidStopCapsule(gap=0.1, restitution=0.3)
    drive, options = vc.Harmonic(amplitude=1.6, frequency=0.95), {"measures": ["impacts"], "periods": 30}
    over = {"drive.frequency": [0.95]}
    law = vc.Coulomb(0.3, 0.4)
    assert vc.ensemble(vc.System(chatters, law, drive), over, **options)["impacts"] == np.inf
    plastic = dataclasses.replace(chatters, restitution=0.0)  # it stays at the wall from the first impact on
    assert vc.ensemble(vc.System(plastic, law, drive), over, **options)["impacts"] == 1.0
    assert np.isnan(vc.ensemble(vc.System(vc.TwoMassCapsule(), law, drive), over, **options)["impacts"])


@pytest.mark.slow
def test_borders_of_a_map_are_the_curves_of_grazing_and_of_zero_progression():
    """Half a step of the grid from what `branch` and `crossing` find on two of its lines."""
    from vibrocap.plotting.studies.maps import study_figure
    from vibrocap.plotting.studies.view import study_view

    over = {"drive.frequency": (0.6, 0.7, 3), "machine.gap": (1.5, 1.65, 16)}
    found = vc.adaptive_map(elastic(0.65), over, by=("impacts", "travel"), coarse=1, periods=400)
    lines = border(found, "impacts").points
    assert np.min(np.abs(lines[np.isclose(lines[:, 0], 0.65)][:, 1] - GAP)) <= 0.5 * 0.01
    assert len(study_figure(study_view(found, "mean_velocity"), ["travel", "impacts"]).axes[0].collections) >= 4


def exact_capsule(orbit):
    """(`ExactCapsule` of an orbit, times of its events)."""
    system, motion = orbit.system, orbit.motion()
    values = {}
    for part in (system.machine, system.friction, system.drive):
        values |= {name: value for name, value in dataclasses.asdict(part).items() if isinstance(value, float)}
    struck = set(motion.event_times[motion.event_kinds == "impact"].tolist()) if "restitution" in values else set()
    events = [event for event in motion.events if event.kind != "reversal" or event.time not in struck]
    side, touch = int(np.sign(orbit.state["velocity"])), int(orbit.state["touching"])
    capsule = ExactCapsule(values, [event.kind for event in events], side, touch, orbit.response_period)
    return capsule, [event.time for event in events]


def exact(orbit, path, dip=None):
    """What `ExactCapsule` finds from an orbit: (state and parameter, error)."""
    capsule, times = exact_capsule(orbit)
    start = [orbit.state[name] for name in ("displacement", "displacement_rate", "velocity")]
    return capsule.solved(start, path, times, dip)


def dip_of(motion):
    """When the mass turns back nearest to its stop without touching it, about."""
    time = np.linspace(0.0, motion.end, 20_001)
    way = motion.at(time, "displacement")
    turns = np.flatnonzero((way[1:-1] > way[:-2]) & (way[1:-1] > way[2:])) + 1
    distance = motion.system.machine.gap - way[turns]
    return float(time[turns[np.argmin(np.where(distance > 0.0, distance, np.inf))]])


def assert_exact(orbit, over, digits):
    """That an exact solution near an orbit grazes (or flips) where the digits say."""
    dip = None if digits == FLIP else dip_of(orbit.motion())
    (*_, found), error = exact(orbit, over.partition(".")[2], dip)
    assert error < 1e-12
    assert found == pytest.approx(digits, abs=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("system", "over", "digits"),
    [
        (elastic(0.65, gap=1.59), "machine.gap", GAP),
        (rigid(0.1, gap=0.34), "machine.gap", FREE_GAP),
        (elastic(0.996), "drive.frequency", FLIP),
    ],
)
def test_digits_are_those_of_exact_solutions(system, over, digits):
    assert_exact(vc.orbit(system), over, digits)


@pytest.mark.slow
def test_both_directions_at_one_set_of_parameters():
    """Each of the two attractors closes under exact solutions too; that back has some three fifths of the plane."""
    system = elastic(0.79, gap=0.5)
    cells = vc.basins(system, {"displacement": (-3.0, 3.0), "displacement_rate": (-3.0, 3.0)}, 40)
    back, forward = sorted(cells.attractors, key=lambda each: each.motion.drift)
    assert len(cells.attractors) == 2
    assert back.motion.drift == pytest.approx(-0.571574672951, abs=1e-10)
    assert forward.motion.drift == pytest.approx(0.782493207665, abs=1e-10)
    assert back.share + forward.share == 1.0
    assert back.share == pytest.approx(0.62, abs=0.02)  # on 100 x 100 starts 0.6221; a border is known to a cell
    for attractor in (back, forward):
        orbit = attractor.motion.orbit
        assert orbit.stable
        start = np.array([orbit.state[name] for name in ("displacement", "displacement_rate", "velocity")])
        capsule, times = exact_capsule(orbit)
        assert np.abs(capsule.image(start, capsule.values, times)[0] - start).max() < 1e-11
