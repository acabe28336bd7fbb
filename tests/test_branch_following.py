"""Branches of maps in closed form: special points where they must be, ends for their reasons; words and refusals."""

import dataclasses
import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import vibrocap as vc
from plain_maps import OddMap, PlainMap, bent, delayed_logistic, henon, isola, odd_cubic, transcritical
from renumbered import renumbered
from thinned import exhaustive_but
from vibrocap.orbits.continuation import cycle_following
from vibrocap.orbits.maps.closing_map import ClosingMap, nudged_slope
from vibrocap.orbits.walk import segment
from vibrocap.orbits.walk.branch_switching import branches_at_corner, switched_point
from vibrocap.orbits.walk.following import Followed, followed, started
from vibrocap.orbits.walk.kinds import BranchEnd, ModeChange, SpecialKind, closed_sequence, mode_change, same_cycle
from vibrocap.orbits.walk.residual import Levels, newton

STEP = 0.02
LOCATED = 1e-8  # of the parameter, as asked; what follows is bracketed to rounding and checked a hundred times sharper


def way(map_, u, p, towards=1.0, points=2000, step=STEP):
    start = started(map_, map_.point(u, p))
    assert start is not None
    return followed(map_, start, towards, points, step)


def stretch(map_, *ends):
    """The segment between two values of the parameter, near u = 2 p."""
    points = [point for p in ends if (point := started(map_, map_.point((2.0 * p,), p))) is not None]
    return segment.Segment(map_, *points)


def places(map_, found, kind):
    return [map_.parameter(each.point.x) for _, each in found.special if each.kind is kind]


def pieces(u, p):
    return "FB" if u[0] < 0.0 else "FSB"


def test_fold_and_flip_of_henons_map():
    map_ = PlainMap(henon, (-1.0, 1.0))
    found = way(map_, (0.4, 0.4), 0.2, towards=-1.0)
    (fold,) = places(map_, found, SpecialKind.FOLD)
    assert abs(fold + 0.7**2 / 4.0) < 1e-2 * LOCATED
    assert found.end is BranchEnd.PARAMETER_BOUND
    assert abs(map_.parameter(found.points[-1].x) - 1.0) < 1e-12  # past the fold, by the other way round
    found = way(map_, (0.3, 0.3), 0.2)
    (flip,) = places(map_, found, SpecialKind.FLIP)
    assert abs(flip - 0.75 * 0.7**2) < 1e-2 * LOCATED


def test_a_fold_is_as_far_off_as_what_does_not_close_moves_it():
    """u' = u + (p - u^2)/1000: mismatches are accepted up to 3e-11, so that p is known to 3e-8."""
    map_ = PlainMap(lambda u, p: (u[0] + 1e-3 * (p - u[0] ** 2),), (-1.0, 1.0))
    (fold,) = [each for _, each in way(map_, (0.5,), 0.25, towards=-1.0).special]
    assert fold.kind is SpecialKind.FOLD
    assert abs(map_.parameter(fold.point.x)) <= fold.error
    assert fold.error == pytest.approx(2.0 * 3e-11 / 1e-3 / 2.0, rel=1e-2)


def test_doubled_branch_leaves_the_flip_and_meets_it_again():
    map_ = PlainMap(henon, (0.0, 1.2))
    (flip,) = [each for _, each in way(map_, (0.3, 0.3), 0.2).special if each.kind is SpecialKind.FLIP]
    finer, first = switched_point(map_, flip)
    doubled = followed(finer, first, 1.0, 2000, STEP, from_parent=True)
    for point in doubled.points[1:]:
        x, p = point.x[:2], finer.parameter(point.x)
        once = np.array(henon(x, p))
        assert abs(x[0] + once[0] - 0.7) < 1e-9  # of both points of the cycle: their sum is 1 - b
    (second,) = places(finer, doubled, SpecialKind.FLIP)
    assert abs(second - (0.7**2 + 1.3**2 / 4.0)) < 1e-2 * LOCATED
    back = followed(finer, doubled.points[20], -1.0, 2000, STEP)
    assert back.end is BranchEnd.FLIP
    assert abs(finer.parameter(back.points[-1].x) - 0.75 * 0.7**2) < 1e-2 * LOCATED


def test_neimark_sacker_point_of_the_delayed_logistic_map():
    map_ = PlainMap(delayed_logistic, (1.2, 2.6))
    found = way(map_, (1 / 3, 1 / 3), 1.5)
    (place,) = places(map_, found, SpecialKind.NEIMARK_SACKER)
    assert abs(place - 2.0) < 1e-2 * LOCATED
    (point,) = [each.point for _, each in found.special]
    assert np.allclose(np.sort_complex(point.closing.eigenvalues), np.exp(np.array([-1j, 1j]) * math.pi / 3), atol=1e-8)


def test_pitchfork_is_the_multiplier_minus_one_of_the_half_period_map():
    map_ = OddMap(odd_cubic, (0.5, 1.9), half=True)
    found = way(map_, (0.0,), 0.6)
    (pitchfork,) = [each for _, each in found.special]
    assert pitchfork.kind is SpecialKind.PITCHFORK
    assert abs(map_.parameter(pitchfork.point.x) - 1.0) < 1e-2 * LOCATED
    assert pitchfork.unstable == (0, 1)
    finer, first = switched_point(map_, pitchfork)
    twins = followed(finer, first, 1.0, 2000, STEP, from_parent=True)
    for point in twins.points[1:]:
        assert abs(point.x[0] ** 2 - (finer.parameter(point.x) - 1.0)) < 1e-9
    back = followed(finer, twins.points[-1], -1.0, 2000, STEP)
    assert back.end is BranchEnd.PITCHFORK
    assert abs(finer.parameter(back.points[-1].x) - 1.0) < 1e-2 * LOCATED


def test_branches_that_cross_are_found_where_they_do():
    """u' = (1 + p) u - u^2 has the branches u = 0 and u = p, which change stability where they cross."""
    map_ = PlainMap(transcritical, (-0.6, 0.6))
    for start, ways in (((0.0,), (0, 1)), ((-0.5,), (1, 0))):
        found = way(map_, start, -0.5)
        (crossing,) = [each for _, each in found.special]
        assert (crossing.kind, crossing.unstable) == (SpecialKind.BRANCH_POINT, ways)
        assert abs(map_.parameter(crossing.point.x)) < 1e-2 * LOCATED
        assert abs(map_.parameter(found.points[-1].x) - 0.6) < 1e-12  # straight across


def test_closed_branch_is_followed_once():
    map_ = PlainMap(isola)
    found = way(map_, (0.2,), 0.5)
    assert found.end is BranchEnd.CLOSED
    assert np.allclose(sorted(places(map_, found, SpecialKind.FOLD)), [0.4, 0.6], atol=1e-2 * LOCATED)


@pytest.mark.parametrize("right", [1.5, 40.0])  # turns of the branch by 53 degrees and by 115
def test_branch_turns_round_a_corner(right):
    map_ = PlainMap(bent(0.5, right), (-1.0, 1.0), mode_sequence=pieces)
    found = way(map_, (-1.0,), -0.5)
    (change,) = [each for _, each in found.special]
    assert change.kind is SpecialKind.MODE_CHANGE
    assert change.change is ModeChange.CROSSING
    assert change.passed is SpecialKind.FOLD
    assert change.unstable == (0, 1)
    assert abs(map_.parameter(change.point.x)) < LOCATED
    assert found.points[-1].x[0] > 0.9 / (right - 1.0)
    assert abs(found.points[-1].x[0] * (1.0 - right) - map_.parameter(found.points[-1].x)) < 1e-9


def test_stability_lost_by_a_jump_is_told_from_a_flip():
    map_ = PlainMap(bent(0.5, -3.0), (-1.0, 1.0), mode_sequence=pieces)
    (change,) = [each for _, each in way(map_, (-1.0,), -0.5).special]
    assert (change.kind, change.passed, change.unstable) == (SpecialKind.MODE_CHANGE, SpecialKind.FLIP, (0, 1))
    unseen = PlainMap(bent(0.5, -3.0), (-1.0, 1.0))  # the same without a word
    assert {each.kind for _, each in way(unseen, (-1.0,), -0.5).special} == {SpecialKind.JUMP}


def test_branch_that_leaves_at_an_angle_is_found():
    map_ = PlainMap(bent(0.5, -1.5), (-1.0, 1.0), mode_sequence=pieces)
    (change,) = [each for _, each in way(map_, (-1.0,), -0.5).special]
    finer, first = next(branches_at_corner(map_, change))
    p, u = finer.parameter(first.x), first.x[0]
    wanted = {p * 1.5 / 1.75, -p * 0.5 / 1.75}  # one point on each side of the corner
    assert min(abs(u - each) for each in wanted) < 1e-10
    back = followed(finer, first, -1.0 if first.tangent[-1] > 0.0 else 1.0, 2000, STEP)
    assert back.end is BranchEnd.FLIP
    assert abs(finer.parameter(back.points[-1].x)) < 1e-6


def test_a_bracket_ends_where_no_number_lies_between():
    asked = []
    root = segment.root(lambda at: asked.append(at) or (1.0 if at > 8.0031 else -1.0), 8.0, 8.02, 1e-17)
    assert 0.0 <= root.right - root.left <= 2.0 * np.spacing(8.0)
    assert len(asked) < 60  # bisections of 0.02 to the spacing, and one more
    assert root.jumps


@pytest.mark.parametrize(("share", "jumps"), [(3e-4, False), (3e-3, True)])
def test_a_function_jumps_over_zero_where_it_stays_a_thousandth_of_its_values_away(share, jumps):
    assert segment.root(lambda x: math.copysign(share + abs(x) * (1.0 - share), x), -1.0, 0.9, 1e-12).jumps == jumps


@pytest.mark.parametrize(("changes", "complaint"), [(10, ""), (14, segment.TOO_MANY)])
def test_a_dozen_changes_are_located_in_one_step(changes, complaint):
    """Of sequences that are longer by a phase from one stretch of equal length to the next."""
    map_ = PlainMap(lambda u, p: (0.5 * u[0] + p,), mode_sequence=lambda u, p: "FSB" + "SB" * int((changes + 1) * p))
    located, why = segment.mode_changes(stretch(map_, 1e-3, 0.999))
    assert why == complaint
    places = (np.arange(changes) + 1.0) / (changes + 1)
    assert why or [left for left, _ in located] == pytest.approx((places - 1e-3) / 0.998, abs=1e-9)


class Square:
    """A square root with a residual that rounds at 1e-6."""

    def __init__(self, x):
        self.x, self.value = x, np.round(x**2 - 2.0, 6)
        self.residual = float(np.abs(self.value[0]))

    def step(self):
        return -self.value / (2.0 * self.x)


class Creeping:
    """Seven tenths are left by each step: below the level of rounding that is no progress."""

    def __init__(self, x):
        self.x, self.residual = x, float(np.abs(x[0]))

    def step(self):
        return -0.3 * self.x


def test_newtons_method_stops_at_the_rounding_of_its_residual():
    """Two numbers: the solution, and that no step goes beyond the level of rounding."""
    found, steps = newton(Square, np.array([1.0]), Levels(0.0, 1e-5), 25)
    assert found.residual <= 1e-6
    assert steps <= 5
    far, _ = newton(Square, np.array([1e-6]), Levels(0.0, 1e-5), 25, halvings=12)
    assert not far.residual <= 1e-5 or abs(far.x[0] - 2.0**0.5) < 1e-5
    assert newton(Creeping, np.array([5e-3]), Levels(0.0, 1e-2), 25)[1] == 1
    assert newton(Creeping, np.array([1.0]), Levels(0.0, 1e-2), 25)[1] < 25
    lost, _ = newton(lambda x: Square(x * 0.0 + 1.0), np.array([1.0]), Levels(0.0, 1e-5), 25)
    assert lost.residual == 1.0


def test_why_a_branch_ends():
    torn = PlainMap(bent(0.5, 0.5, jump=1.0), (-1.0, 1.0), mode_sequence=pieces)
    ended = way(torn, (-1.0,), -0.5)
    assert ended.end is BranchEnd.ORBIT_CEASES
    assert abs(torn.parameter(ended.points[-1].x)) < 1e-6
    broken = PlainMap(lambda u, p: (0.5 * u[0] + p,), breaks=lambda p: p > 0.7)
    ended = way(broken, (0.4,), 0.2)
    assert ended.end is BranchEnd.NEWTON_FAILED
    assert abs(broken.parameter(ended.points[-1].x) - 0.7) < 1e-6
    assert way(broken, (0.4,), 0.2, points=5).end is BranchEnd.TOO_MANY_POINTS
    assert len(way(broken, (0.4,), 0.2, points=5).points) == 5
    assert all(end.advice for end in BranchEnd)
    assert all(kind.meaning for kind in SpecialKind)


def test_steps_grow_with_states_beyond_their_natural_sizes():
    """u = 1000 p, one decade after the other: a hundredth of u and of the range at a time, not of natural sizes."""
    map_ = PlainMap(lambda u, p: (0.5 * u[0] + 500.0 * p,), (0.0, 1.0))
    found = way(map_, (1.0,), 1e-3)
    assert found.end is BranchEnd.PARAMETER_BOUND
    assert len(found.points) <= math.log(1000.0) / math.log(1.0 + STEP) + 20


@pytest.mark.parametrize(("jump", "complaint"), [(0.3, ""), (3.0, segment.JUMPS)])
def test_orbits_jump_where_they_are_farther_apart_than_a_kink_may_hide(jump, complaint):
    """u = 2 p with a step back at p = 0, of shares of a thousandth of the segment."""
    back = jump * 1e-3 * math.hypot(0.4, 0.2)
    map_ = PlainMap(lambda u, p: (0.5 * u[0] + p - (0.5 * back if p > 0.0 else 0.0),), (-0.5, 0.5), mode_sequence=sides)
    changes, why = segment.mode_changes(stretch(map_, -0.1, 0.1))
    assert (why, len(changes)) == (complaint, 0 if complaint else 1)


def sides(u, p):
    return "FB" if p <= 0.0 else "FSB"


def test_word_that_changes_too_fast_is_said_to_do_so():
    def word(u, p):
        if p < 0.48 or p > 0.5:
            return "FSB" if p < 0.48 else "FB"
        return "FB" if math.sin(1.0 / (0.5 - p + 1e-9)) > 0.0 else "FSB"

    map_ = PlainMap(lambda u, p: (0.5 * u[0] + p,), (0.0, 1.0), mode_sequence=word)
    found = way(map_, (0.4,), 0.2, step=0.1)
    assert found.end is BranchEnd.PARAMETER_BOUND
    unlocated = [each for _, each in found.special if each.kind is SpecialKind.UNLOCATED]
    assert unlocated
    assert all(abs(map_.parameter(each.point.x) - 0.5) < 0.05 for each in unlocated)


STICK = "a stick phase vanishes"


@pytest.mark.parametrize(
    ("before", "after", "change", "text"),
    [
        ("FSB", "FB", ModeChange.CROSSING, STICK),
        ("FB", "FSBS", ModeChange.CROSSING, "two stick phases appear"),
        ("FBSB", "FB", ModeChange.GRAZING, STICK),
        ("FB", "FBFB", ModeChange.GRAZING, "a slip phase appears"),
        ("S", "SFSB", ModeChange.SPLITTING, "two slip phases appear"),
        ("FBSBFS", "FBFSBFBS", ModeChange.SWITCHING, "two slip phases appear"),
        ("FB", "S", ModeChange.UNNAMED, "several phases change at once"),
        # each contact's cycle begins at a section of its own
        ("FSB|FSBS", "SBF|FBS", ModeChange.CROSSING, f"{STICK} at contact 2"),
        ("FSB|", "FB|", ModeChange.CROSSING, f"{STICK} at contact 1"),
        ("FSB|FSB", "FB|FB", ModeChange.CROSSING, f"{STICK} at contact 1; {STICK} at contact 2"),
        ("FSB|SFS", "FB|S", ModeChange.UNNAMED, f"{STICK} at contact 1; a slip phase vanishes at contact 2"),
    ],
)
def test_changes_of_the_word_are_named(before, after, change, text):
    assert mode_change(before, after) == (change, text)


def test_words_are_cycles():
    assert [closed_sequence(word, half=True) for word in ("FSB", "S")] == ["FSBS", "S"]
    assert closed_sequence("FBFB") == "FBFB"
    for word, other, same in (
        ("FSBS", "SBSF", True), ("FSB", "FBS", False), ("FSB|SB", "SBF|BS", True), ("FSB|SB", "SBF|B", False)
    ):  # fmt: skip
        assert same_cycle(word, other) == same


def capsule(**parts):
    settings = {"machine": vc.PendulumCapsule(), "friction": vc.Exponential(), "drive": vc.Harmonic(), **parts}
    return vc.System(**settings)


@pytest.mark.parametrize(
    ("system", "arguments", "complaint"),
    [
        (capsule(), {"over": "drive.amplitud"}, "did you mean 'drive.amplitude'"),
        (capsule(), {"over": ("drive.amplitude", (1.0, 3.0))}, "should be a path such as"),
        (
            capsule(machine=vc.PendulumCapsule(normal_load="weight")),
            {"over": "machine.normal_load"},
            "should be a parameter that is a number",
        ),
        (capsule(), {"between": (3.0, 1.0)}, "finite with low < high"),
        (capsule(), {"between": (1.0, math.inf)}, "finite with low < high"),
        (capsule(), {"between": 3.0}, "two numbers"),
        (capsule(), {"over": "machine.mass_ratio", "between": (-1.0, 3.0)}, "machine.mass_ratio cannot be -1"),
        (capsule(), {"towards": "left"}, "towards should be one of"),
        (capsule(), {"points": 1}, "points should be a whole number"),
        (capsule(), {"step": 2.0}, "step should be a share"),
        (capsule(drive=vc.Biharmonic(second_amplitude=0.3)), {"half": True}, "no half-period symmetry"),
    ],
)
def test_bad_input_is_refused_before_any_work(system, arguments, complaint):
    with pytest.raises(ValueError, match=complaint):
        vc.branch(system, **{"over": "drive.amplitude", "between": (1.0, 3.0), **arguments})


def test_an_orbit_of_another_system_is_refused():
    zeros, system = np.zeros(3), capsule()
    orbit = vc.Orbit(
        system=system, state={}, period=1.0, response_period=1, drift=0.0, multipliers=zeros, residual=0.0,
        symmetric=True, derivative=np.eye(4), status=vc.OrbitStatus.CONVERGED, iterations=0, tolerance=1e-12,
    )  # fmt: skip
    away = dataclasses.replace(orbit, system=system.with_parameters({"drive.amplitude": 5.0}))
    for of, asked, said in (
        (system.with_parameters({"machine.mass_ratio": 3.0}), {"orbit": orbit}, "another parameter differs"),
        (system, {"orbit": orbit, "initial": {"angle": 1.0}}, "not both"),
        (system, {"orbit": away}, "orbit should have its drive.amplitude within 1 to 3, got 5"),
    ):
        with pytest.raises(ValueError, match=said):
            vc.branch(of, "drive.amplitude", (1.0, 3.0), **asked)


@pytest.mark.slow
@pytest.mark.parametrize("turned", exhaustive_but([0], [False, True]), ids=["as it is", "numbered the other way"])
def test_a_branch_ends_by_name_where_any_contact_stops_sticking(turned):
    """Contact 2 rests shortly, ever later, until it turns without. Before, Newton's method failed."""
    machine = vc.TwoBodyCrawler(mass_2=1.5, stiffness=1.3, damping=0.25)
    laws = [vc.Coulomb(0.3, 0.45), vc.Coulomb(0.15, 0.3)]
    machine, laws = (renumbered(machine), laws[::-1]) if turned else (machine, laws)
    system = vc.System(machine, laws, vc.Biharmonic(1.5, 0.8651952, 0.7, 0.5))
    start = {"displacement": 1.3363628, "velocity_2": 0.9220258, "velocity": -1.1215358}
    branch = vc.branch(system, "drive.frequency", (0.865, 0.866), initial=start)
    assert branch.ends[1] is BranchEnd.ORBIT_CEASES
    assert branch.parameter[-1] == pytest.approx(0.865219107, abs=1e-8)


def test_a_walk_along_cycles_ends_where_they_cross_their_section_at_less_than_thirty_degrees(monkeypatch):
    """Cosines of the flow with the normal from 0.9 down; what is special in the last step is left to the next one."""
    cosines = {0: 0.3, 1: 0.9, 2: 0.55, 3: 0.45, 4: 0.9}
    monkeypatch.setattr(cycle_following, "flow_across", lambda closure, point: (1.0, cosines[point]))
    special: list[Any] = [(0, "fold"), (1, "flip"), (3, "fold")]
    walk = Followed(list(cosines), special, BranchEnd.PARAMETER_BOUND)  # type: ignore[arg-type]
    ended = cycle_following._crossing(None, walk)  # type: ignore[arg-type]
    assert (ended.points, ended.special, ended.end) == ([0, 1, 2], special[:2], BranchEnd.TOO_MANY_POINTS)


def test_a_guess_beyond_a_stop_is_a_motion_from_the_stop():
    """Where no next point closes, the events along the last guess are compared; one past a wall ended the command."""
    system = vc.System(vc.RigidStopCapsule(gap=0.5, restitution=0.5), vc.Coulomb(0.2, 0.3), vc.Harmonic(1.2, 1.0))
    closing_map = ClosingMap(system, "drive.frequency", (0.9, 1.1))
    names = system.state_names
    at_wall, beyond = (np.array([place if name == "displacement" else 0.0 for name in names]) for place in (0.5, 0.51))
    guesses = [SimpleNamespace(x=closing_map.point(state, 1.0), image=0.0 * state) for state in (at_wall, beyond)]
    assert np.array_equal(*(closing_map.motion(guess).sections[-1] for guess in guesses))


def test_a_slope_that_differs_to_both_sides_is_asked_closer():
    """As near a grazing motion, whose image is a square root: a nudge of its distance is off by a quarter."""
    images = [np.array([math.sqrt(1.2e-6 + nudge)]) for nudge in (0.0, 1e-6, -1e-6)]
    assert nudged_slope(images, ["FB"] * 3, 1e-6)[1]
    assert not nudged_slope(images, ["FB", "FB", "FSB"], 1e-6)[1]  # a corner: there is one side
    images = [np.array([math.sqrt(1.2e-6 + nudge)]) for nudge in (0.0, 1e-8, -1e-8)]
    slope, apart = nudged_slope(images, ["FB"] * 3, 1e-8)
    assert not apart
    assert slope[0] == pytest.approx(0.5 / math.sqrt(1.2e-6), rel=1e-4)


@pytest.mark.slow
def test_a_branch_on_its_way_to_a_grazing_takes_few_points():
    """By a slope that was off by a quarter each point took ten steps, and none was longer than the one before."""
    system = vc.System(
        vc.RigidStopCapsule(restitution=0.6, gap=0.5, back_gap=0.5), vc.Coulomb(0.2, 0.3), vc.Harmonic(0.8, 0.8)
    )
    branch = vc.branch(system, "drive.frequency", (0.5, 1.1), points=150)
    assert BranchEnd.TOO_MANY_POINTS not in branch.ends
    assert np.max(np.abs(branch.multipliers)) > 1e5
