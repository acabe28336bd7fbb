"""Where a measure of the steady motion takes a value: control points, boundary points, and what is none."""

import itertools
import math
import types

import numpy as np
import pytest

import vibrocap as vc
from cases import printed, refused
from vibrocap.cli.commands.crossing import _other
from vibrocap.cli.terminal import INCOMPLETE
from vibrocap.motion.simulate import period_marks
from vibrocap.orbits.continuation import crossing_bracket
from vibrocap.orbits.continuation.crossing_bracket import CrossingKind
from vibrocap.orbits.walk import segment

START = {"angle": math.pi / 3}
LAWS = {"exponential": vc.Exponential(), "lugre": vc.LuGre()}
RATIO = "machine.mass_ratio"
# Zeros of the steady drift at rho = 0.58, nu = 1.2 by Newton shooting (the variational kernels, an integrator of
# another order): bracketed there to 8e-15, so that only the two integrations differ.
SHOT = {"exponential": 3.4562300486446, "lugre": 4.2152516212410}


def capsule(law, stiffness=0.58, damping=1.2, **parameters):
    machine = vc.PendulumCapsule(mass_ratio=2.5, stiffness=stiffness, damping=damping)
    return vc.System(machine, LAWS[law], vc.Harmonic()).with_parameters(parameters)


def drift(system, periods=400):
    """Travel in the last of many periods, by simulation alone."""
    _, marks = period_marks(system, periods=periods, initial=START, tolerance=1e-12)
    return float(marks[-1, 2] - marks[-2, 2])


def test_control_points_of_a_soft_spring_are_those_of_shooting():
    crossings = vc.crossing(capsule("exponential"), "drift", RATIO, (0.2, 8.1), initial=START, points=12)
    (place,) = crossings.found
    assert place.kind is CrossingKind.CROSSING
    assert place.at == pytest.approx(SHOT["exponential"], abs=1e-11)
    assert place.error < 1e-9
    assert place.bracket[0] <= place.at <= place.bracket[1]
    assert place.differences[0] * place.differences[1] <= 0.0
    assert crossings.equal == crossings.unsettled == ()
    assert abs(place.values[0]) < 1e-12
    beside = [drift(capsule("exponential", **{RATIO: place.at + step})) for step in (-1e-3, 1e-3)]
    assert (beside[1] - beside[0]) / 2e-3 == pytest.approx(place.slope, rel=1e-2)


@pytest.mark.slow
def test_boundary_points_of_a_soft_spring_are_where_both_laws_travel_alike():
    lm, em = capsule("lugre"), capsule("exponential")
    crossings = vc.crossing(lm, "mean_velocity", RATIO, (0.5, 6.5), against=em, initial=START, points=13)
    assert [place.kind for place in crossings.found] == [CrossingKind.CROSSING] * 2
    for place in crossings.found:
        drifts = [drift(capsule(law, **{RATIO: place.at})) for law in ("lugre", "exponential")]
        assert drifts[0] == pytest.approx(drifts[1], abs=1e-10)
        assert abs(drifts[0]) > 0.01
        assert place.error < 1e-9
        assert place.values[0] == pytest.approx(drifts[0] / lm.drive.period, abs=1e-11)
    assert crossings.places == pytest.approx((0.774946696147, 5.489362346569), abs=1e-9)


def test_the_error_is_that_of_the_integration():
    """At coarse tolerances the place moves, by less than the error says and not much less."""
    asked = {"initial": START, "points": 3}
    fine = vc.crossing(capsule("exponential"), "drift", RATIO, (3.0, 4.0), tolerance=1e-13, **asked)
    for tolerance in (1e-7, 1e-9):
        crossings = vc.crossing(capsule("exponential"), "drift", RATIO, (3.0, 4.0), tolerance=tolerance, **asked)
        off = abs(crossings.places[0] - fine.places[0])
        assert 0.0 < off <= crossings.found[0].error < 1e4 * tolerance


def twin_jump():
    """Over the amplitude the start leads to one of two mirror-image solutions, then to the other; no drift vanishes."""
    start = {"angle": 0.3}
    system = capsule("exponential", 2.0, 1.0)
    return vc.crossing(system, "drift", "drive.amplitude", (1.4, 1.8), initial=start, points=20)


def test_a_jump_to_the_mirror_twin_is_no_crossing():
    jump = twin_jump()
    assert jump.differences.min() < -0.1 < 0.1 < jump.differences.max()
    assert {place.kind for place in jump.found} == {CrossingKind.JUMP}
    assert jump.places == ()
    assert "mirror-image solution" in str(jump)
    assert "no crossing" in str(jump)


def test_a_jump_within_a_bracket_is_told_from_a_crossing(monkeypatch):
    """Planted: motions that are not followed but begun anew at each place jump, and a limit that is none hides it."""

    def anew(self, near, place, tolerance=None):
        systems = [each.system for each in near]
        return self.settled([s.with_parameters({self.over: place}) for s in systems], [{"angle": 0.3}] * len(systems))

    monkeypatch.setattr(crossing_bracket.Difference, "followed", anew)
    jump = twin_jump()
    assert {place.kind for place in jump.found} == {CrossingKind.JUMP}
    monkeypatch.setattr(segment, "LEAPS", 2.0)
    assert CrossingKind.CROSSING in {place.kind for place in twin_jump().found}


def test_what_does_not_settle_is_said():
    crossings = vc.crossing(capsule("exponential"), "drift", RATIO, (0.2, 8.1), initial=START, points=5, periods=8)
    assert len(crossings.unsettled) == 5
    assert crossings.found == crossings.equal == ()
    assert "unsettled 5 of 5 points" in str(crossings)
    assert np.all(np.isnan(crossings.differences))


def test_a_bracket_in_which_a_motion_is_lost_is_said(monkeypatch):
    real, calls = crossing_bracket.Difference.followed, itertools.count()
    monkeypatch.setattr(
        crossing_bracket.Difference, "followed", lambda *given: real(*given) if next(calls) < 3 else None
    )
    crossings = vc.crossing(capsule("exponential"), "drift", RATIO, (3.0, 4.0), initial=START, points=3)
    (place,) = crossings.found
    assert place.kind is CrossingKind.LOST
    assert place.bracket[0] < SHOT["exponential"] < place.bracket[1]
    assert place.error == pytest.approx(place.bracket[1] - place.bracket[0])
    assert "raise `periods`" in str(crossings)
    assert "no crossing" not in str(crossings)


@pytest.mark.slow
class Bent:
    """A difference 3 d + 2 10^4 d^3 of the distance d from a place, which ten times the tolerance moves by 1e-9."""

    measure, tolerance, lost = "drift", 1e-12, -1

    def __init__(self, place):
        self.place, self.asked = place, 0

    def followed(self, motions, at, tolerance=1e-12):
        self.asked += 1
        shift = 0.0 if tolerance == self.tolerance else 1e-9
        return (
            None
            if self.asked == self.lost
            else (types.SimpleNamespace(at=at + shift, certified=True, value=lambda measure: at),)
        )

    def of(self, motions):
        away = motions[0].at - self.place
        return 3.0 * away + 2e4 * away**3 + 1e-30  # nowhere exactly zero


def test_a_crossing_in_a_narrow_bracket_is_located_as_sharply_as_in_a_wide_one():
    """The bracket to rounding of its own width, and the slope from points as near as that width tells."""
    for width in (0.02, 3.0):
        bent = Bent(0.3 * width)
        ends = [(at, bent.followed((), at)) for at in (0.0, width)]
        located = crossing_bracket.located(bent, *ends)  # type: ignore[arg-type]
        assert (located.kind, located.values) == (CrossingKind.CROSSING, (located.at,))
        assert located.at == pytest.approx(0.3 * width, rel=1e-12)
        assert located.bracket[1] - located.bracket[0] <= 1.01 * crossing_bracket.NARROW * width
        assert located.slope == pytest.approx(3.0 + 2e4 * (1e-3 * width) ** 2, rel=1e-9)
        assert located.error == pytest.approx(located.bracket[1] - located.bracket[0] + 3e-9 / located.slope, rel=1e-5)
    for lost in range(1, 4):  # of the last motions, at the place itself and beside it
        again = Bent(0.3 * width)
        ends, again.lost = [(at, again.followed((), at)) for at in (0.0, width)], bent.asked + 1 - lost
        assert crossing_bracket.located(again, *ends).kind is CrossingKind.LOST  # type: ignore[arg-type]


BELT = vc.System(vc.Oscillator(belt_speed=0.1), vc.Coulomb(), vc.Constant())


@pytest.mark.parametrize(
    ("system", "arguments", "complaint"),
    [
        ("lugre", {"measure": "speed"}, "measure should be a number of the table of measures, got 'speed'"),
        ("lugre", {"measure": "mode_sequence"}, "measure should be a number"),
        ("lugre", {"over": "machine.mass"}, "over: .*did you mean"),
        ("si", {"over": ("drive.frequency_Hz", (0.9, 1.1))}, "should be a path such as"),
        ("si", {"between": (1.0, 2.0), "over": "drive.frequency_Hz", "initial": {1: 0.0}}, "initial.1: no such state"),
        ("lugre", {"between": (2.0, 1.0)}, "between should be"),
        ("lugre", {"between": (-1.0, 1.0)}, "between: machine.mass_ratio cannot be -1"),
        ("lugre", {"points": 1}, "points should be a whole number >= 2"),
        ("lugre", {"value": math.nan}, "value should be a finite number"),
        ("lugre", {"periods": 0}, "periods"),
        ("lugre", {"initial": {"angel": 1.0}}, "angle"),
        ("belt", {"over": "machine.stiffness", "measure": "stick_fraction"}, "drive should change in time"),
        ("belt", {"over": "machine.stiffness"}, "measures: drift"),
    ],
)
def test_bad_input_is_refused_before_any_work(system, arguments, complaint):
    known = {"belt": lambda: BELT, "si": lambda: vc.read_case("examples/bench-in-si.toml").system}
    given = known.get(system, lambda: capsule(system))()
    with pytest.raises(ValueError, match=complaint):
        vc.crossing(given, **arguments)


# --- along a branch --------------------------------------------------------------------------------------------------


@pytest.mark.slow
def test_crossings_along_a_branch_are_those_of_the_sweep():
    branch = vc.branch(capsule("exponential"), RATIO, (2.5, 4.5), initial=START)
    (place,) = branch.crossings("drift")
    assert place.kind is CrossingKind.CROSSING
    assert place.at == pytest.approx(SHOT["exponential"], abs=1e-11)
    assert abs(place.at - SHOT["exponential"]) <= place.error < 1e-8
    assert abs(place.orbit.drift) < 1e-11
    assert place.orbit.stable
    assert branch.parameter[place.after_point] <= place.at <= branch.parameter[place.after_point + 1]
    assert branch.crossings("drift", 100.0) == ()
    (own,) = branch.crossings(lambda orbit: orbit.drift)
    assert own.at == place.at


@pytest.mark.slow
def test_crossings_are_found_past_a_fold():
    """The travelling LuGre capsule: unstable twins between the pitchfork and the fold, stable ones beyond it."""
    system = capsule("lugre", 2.0, 1.0, **{"drive.amplitude": 1.88})
    folded = vc.branch(system, "drive.amplitude", (1.87, 1.95), initial=START)
    (fold,) = folded.kind(vc.SpecialKind.FOLD)
    for share, stable in ((0.5, False), (1.5, True)):
        (place,) = folded.crossings("drift", share * fold.drift)
        assert place.orbit.stable == stable
        assert place.orbit.drift == pytest.approx(share * fold.drift, abs=1e-12)
        assert place.at < fold.parameter


# --- on the command line ---------------------------------------------------------------------------------------------


@pytest.fixture
def case(tmp_path):
    vc.save_case(capsule("exponential"), tmp_path / "case.toml", initial=START)
    return tmp_path / "case.toml"


def test_command_finds_control_points_or_says_what_is_there(case, capsys):
    asked = ("crossing", case, "--over", f"{RATIO}=3:4", "--points", "3")
    text = printed(capsys, *asked)
    assert "crossing  3.45623004865" in text
    assert "between 3.4562300486" in text
    assert "no crossing: over the scan the difference is from" in printed(capsys, *asked[:3], f"{RATIO}=5:6")
    assert "unsettled 3 of 3" in printed(capsys, *asked, "--periods", "8", code=INCOMPLETE)


@pytest.mark.parametrize(
    ("arguments", "complaint"),
    [
        (["--over", f"{RATIO}=3-4"], "--over should be PATH=LEAST:LARGEST"),
        (["--over", f"{RATIO}=3:4", "--against", "lugre"], "--against should be friction.law=NAME or PATH=VALUE"),
        (["--over", f"{RATIO}=3:4", "--against", "friction.law=lugger"], "no friction law is called 'lugger'"),
        (["--over", f"{RATIO}=3:4", "--against", "friction.decay=1"], "did you mean"),
        (["--over", f"{RATIO}=3:4", "--measure", "speed"], "--measure: should be a number of the table of measures"),
    ],
)
def test_command_refuses_what_makes_no_sense(case, arguments, complaint, capsys):
    assert complaint in refused(capsys, "crossing", case, *arguments)


def test_another_law_takes_over_what_both_have():
    own = capsule("exponential", **{"friction.static_coefficient": 0.6})
    assert _other(own, "friction.law=lugre").friction == vc.LuGre(static_coefficient=0.6)
    assert _other(own, "friction.decay_rate=20").friction == vc.Exponential(static_coefficient=0.6, decay_rate=20.0)
