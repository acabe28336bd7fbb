"""Branches of capsules: the diagram over the drive's amplitude, checked by shooting, by bisection and by brute force.

Slow: each law's tangents need a kernel of their own.
"""

import json
import math

import numpy as np
import pytest

import vibrocap as vc
from cases import command
from thinned import exhaustive_but
from vibrocap.cli.terminal import INCOMPLETE
from vibrocap.orbits.walk.kinds import BranchEnd, ModeChange, SpecialKind, same_cycle

pytestmark = pytest.mark.slow
OVER, BETWEEN = "drive.amplitude", (1.0, 3.0)
START = {"angle": math.pi / 3}
LOCATED = 1e-8  # of the parameter, as the issue asks
LAWS = {"exponential": vc.Exponential(), "lugre": vc.LuGre()}
# (pitchfork at which travel begins, place where it ends) as found here by bisection of the multiplier of symmetric
# orbits that were shot one by one, see `bisected`
BEGINS = {"exponential": 1.283213153, "lugre": 1.424009009}
ENDS = {"exponential": 1.93024433, "lugre": 1.909639888}


def system_with(law, **parameters):
    return vc.System(vc.PendulumCapsule(), LAWS[law], vc.Harmonic()).with_parameters(parameters)


@pytest.fixture(scope="module", params=exhaustive_but([0], [*LAWS]))
def diagram(request):
    return vc.branches(system_with(request.param), OVER, BETWEEN, initial=START)


def symmetric_orbit(law, amplitude, state):
    orbit = vc.shoot(system_with(law, **{OVER: amplitude}), state, half=True)
    assert orbit.status is vc.OrbitStatus.CONVERGED
    return orbit


def bisected(law, low, high):
    """The amplitude at which symmetric orbits, each shot by itself, change their stability."""
    state = symmetric_orbit(law, low, vc.orbit(system_with(law), initial=START).state).state
    stable = symmetric_orbit(law, low, state).stable
    while high - low > 1e-11:
        middle = 0.5 * (low + high)
        orbit = symmetric_orbit(law, middle, state)
        low, high, state = (middle, high, orbit.state) if orbit.stable == stable else (low, middle, state)
    return 0.5 * (low + high)


def test_travel_begins_and_ends_where_symmetric_orbits_change_their_stability(diagram):
    law = diagram.system.friction.name
    symmetric, travelling = diagram.branches
    begin = symmetric.kind(SpecialKind.PITCHFORK)[0]
    assert begin.stability == "lost"
    assert abs(begin.parameter - BEGINS[law]) < 1e-9
    assert abs(begin.parameter - bisected(law, begin.parameter - 0.01, begin.parameter + 0.01)) < LOCATED
    end = next(point for point in symmetric.special_points if point.stability == "gained")
    assert abs(end.parameter - ENDS[law]) < 1e-8
    assert abs(end.parameter - bisected(law, end.parameter - 3e-5, end.parameter + 3e-5)) < LOCATED
    if law == "exponential":  # the contact grazes rest: multipliers jump, and nothing smooth happens
        assert (end.kind, end.change, end.passed) == (
            SpecialKind.MODE_CHANGE, ModeChange.GRAZING, SpecialKind.PITCHFORK,
        )  # fmt: skip
        assert end.discontinuous
    else:
        assert end.kind is SpecialKind.PITCHFORK
    assert not travelling.symmetric
    assert travelling.ends == (BranchEnd.PITCHFORK, BranchEnd.PITCHFORK)
    assert {(join.parent, join.child, join.end) for join in diagram.joins} == {(0, 1, 0), (0, 1, -1)}
    assert np.allclose(travelling.parameter[[0, -1]], [BEGINS[law], ENDS[law]], atol=1e-7)
    assert diagram.unfollowed == ()


def test_brute_force_agrees_with_every_stable_part(diagram):
    """From both sides and various starts a simulation settles on a stable orbit of the diagram, and on no other."""
    values = np.linspace(1.01, 2.99, 12)
    grid = np.stack(np.meshgrid(values, [-1.5, -0.4, 0.4, 1.5], [-1.0, 1.0], indexing="ij"), axis=-1).reshape(-1, 3)
    over = dict(zip((OVER, "initial.angle", "initial.angle_rate"), grid.T, strict=True))
    results = vc.ensemble(diagram.system, over, measures=["drift"], periods=5000, settle=1e-8, tolerance=1e-11)
    assert results["settled"].all()
    for value, drift in zip(values, results["drift"].reshape(len(values), -1), strict=True):
        (known,) = [orbit for branch in diagram.branches for orbit in branch.orbits_at(value) if orbit.stable]
        assert np.allclose(np.abs(drift), abs(known.drift), rtol=0.0, atol=1e-6)
        if known.drift != 0.0:
            assert {True, False} == set((drift > 0.0).tolist())  # both twins are reached


def test_points_are_orbits_with_their_own_multipliers_and_words(diagram):
    for branch in diagram.branches:
        assert np.all(np.diff(branch.arclength) > 0.0)
        for i in range(1, len(branch) - 1, 23):
            orbit = branch.orbit(i)
            assert orbit.residual < 1e-11
            error = 2e-11 / np.min(np.abs(branch.multipliers[i] - 1.0))  # what closes to 1e-12 is so near to an orbit
            moved = np.array(list(orbit.state.values())) - branch.states[i]
            assert np.max(np.abs(moved)) < error
            assert abs(orbit.drift - branch.drift[i]) < error
            assert np.allclose(orbit.multipliers, branch.multipliers[i], atol=1e-6)
            assert same_cycle(orbit.mode_sequence, str(branch.mode_sequence[i]))


def test_section_goes_from_sticking_to_sliding():
    """At small amplitudes the capsule never moves; then it slips, and slips at the section too."""
    branch = vc.branch(system_with("exponential", **{OVER: 0.3}), OVER, (0.1, 1.2), initial=START)
    assert branch.ends == (BranchEnd.PARAMETER_BOUND, BranchEnd.PARAMETER_BOUND)
    stuck = branch.mode_sequence == "S"
    velocity = branch.states[:, 3]
    assert np.all(velocity[stuck] == 0.0)
    assert velocity[-1] > 0.05
    assert [point.change for point in branch.special_points] == [ModeChange.SPLITTING, ModeChange.CROSSING]
    # a capsule that never moves first slips where |cos(theta) P - sin(theta) theta'^2| reaches N eta_s
    first = branch.special_points[0].parameter
    for away, word in ((-1e-8, "S"), (1e-8, "SBSF")):
        system = system_with("exponential", **{OVER: first + away})
        assert same_cycle(vc.shoot(system, branch.special_points[0].state, half=True).mode_sequence, word)


def test_a_branch_passes_where_a_reversal_crosses_the_section():
    """At 0.50047311: the branch has a kink there, and the derivative by the parameter is that of one of its sides."""
    law = vc.HyperbolicStribeck(0.3018538439870618, 0.5932115319400755, 0.3073151450176325, 0.029427512398926416)
    machine = vc.TwoMassCapsule(0.6629814888203218, 0.7016681199257911, 0.1723831738175682, 1.348964484060245)
    drive = vc.Biharmonic(1.1224056113871611, 0.5174874353429021, 0.6772087466335716, 0.5033026156599518)
    branch = vc.branch(vc.System(machine, law, drive), "drive.frequency", (0.46, 0.525), settle_periods=600)
    assert branch.ends == (BranchEnd.PARAMETER_BOUND, BranchEnd.PARAMETER_BOUND)
    exact = [0.4749744773332, 0.5191094756250]  # of an event solver of its own in long double
    for point, place in zip(branch.special_points, exact, strict=True):
        assert abs(point.parameter - place) <= point.error < 1e-10


WILD = system_with("exponential", **{"machine.stiffness": 0.6, "machine.damping": 0.3, OVER: 1.2})


def test_a_start_that_closes_nothing_is_an_empty_branch_that_says_so():
    branch = vc.branch(WILD, OVER, (1.1, 1.3), initial=START, settle_periods=30)
    assert len(branch) == 0
    assert branch.ends == (BranchEnd.START_FAILED, BranchEnd.START_FAILED)
    assert "Give an `orbit`" in str(branch)


def test_a_system_out_of_the_range_starts_at_its_nearer_end():
    branch = vc.branch(system_with("exponential"), OVER, (2.3, 2.5), initial=START)
    assert branch.ends == (BranchEnd.PARAMETER_BOUND, BranchEnd.PARAMETER_BOUND)
    assert branch.parameter[branch.start] == 2.3
    assert branch.symmetric


def test_command_says_why_a_branch_was_not_followed(tmp_path, capsys):
    case, lifts, chaos = (tmp_path / f"{name}.toml" for name in ("case", "lifts", "chaos"))
    vc.save_case(system_with("exponential"), case, initial=START)
    over = ("--over", "drive.amplitude=1.2:1.9", "--points", "10")
    record = json.loads(
        failed(capsys, "was not followed to its end (too many points)", "branch", case, *over, "--json")
    )
    first = record["branches"][0]
    assert len(first["parameter"]) == 19  # ten each way, what was computed until then
    assert first["ends"] == ["too many points", "too many points"]
    assert all("Raise `points`" in advice for advice in first["advice"])
    dynamic = {"machine.normal_load": "dynamic", OVER: 20.0}  # no orbit can close there, whatever the transient
    vc.save_case(system_with("exponential", **dynamic), lifts, initial=START)
    failed(capsys, "No steady motion closed at the start", "branch", lifts, "--over", "drive.amplitude=15:25")
    vc.save_case(WILD, chaos, initial=START)
    record = json.loads(failed(capsys, "", "orbit", chaos, "--settle-periods", "300", "--json"))
    assert (record["status"], record["class"]["kind"]) == ("not settled", "chaotic")
    assert "largest Lyapunov exponent" in record["class"]["reason"]


def failed(capsys, complaint, *arguments):
    """What a command prints whose work is incomplete."""
    assert command(*arguments) == INCOMPLETE
    output = capsys.readouterr()
    assert complaint in output.err
    return output.out


@pytest.mark.slow
def test_a_branch_under_a_dynamic_load_ends_where_it_lifts_off():
    machine = vc.PendulumCapsule(normal_load="dynamic", mass_ratio=2.5)
    system = vc.System(machine, vc.Exponential(), vc.Harmonic(amplitude=1.9))
    branch = vc.branch(system, "drive.amplitude", (1.8, 2.5), towards="up", settle_periods=300)
    assert branch.ends[1] is vc.BranchEnd.LIFT_OFF
    assert branch.parameter[-1] == pytest.approx(1.98138, abs=1e-4)
    assert 0.0 < branch.orbit(len(branch) - 1).motion().certificate.least_reaction < 1e-4
