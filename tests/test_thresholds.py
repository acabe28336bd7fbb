"""Thresholds of the engine: each has a witness on both sides, within a factor of ten or so."""

import dataclasses
from unittest import mock

import numpy as np
import pytest

import vibrocap as vc
from independent import Problem
from plain_kernels import kernel_of
from test_contact_decisions import contacts_of, kernel_decision
from vibrocap.arguments import ArgumentError
from vibrocap.motion import contradictions, evidence
from vibrocap.motion.recording.equations import equations
from vibrocap.motion.simulate import Start, begun
from vibrocap.numerics.api import Stroboscope
from vibrocap.numerics.kernel.codes import SLIVER
from vibrocap.numerics.kernel.events.transitions import ARRIVED, TIED
from vibrocap.numerics.linker import kernel_source

EPSILON = 2.0**-52
STOPS = vc.System(vc.RigidStopCapsule(gap=1.0), vc.Coulomb(0.2, 0.3), vc.Harmonic())


def test_a_phase_just_short_of_a_whole_period_is_none():
    """1e-12 of a period."""
    assert Start(phase=3.0 - 3e-13).phase_of(1.0) == 0.0
    assert Start(phase=3.0 - 3e-12).phase_of(1.0) == pytest.approx(1.0 - 3e-12, abs=1e-14)


def test_a_start_just_beyond_a_stop_is_at_the_stop():
    """1e-12 of 1 + |x|: a start that was printed with all digits is none beyond."""
    assert begun(STOPS, None, {"displacement": 1.0 + 1e-12})[0]["displacement"] == 1.0 + 1e-12
    with pytest.raises(ArgumentError, match="displacement"):
        begun(STOPS, None, {"displacement": 1.0 + 1e-11})


def test_ways_to_go_on_are_told_apart_by_a_billionth():
    """Of forces: a block whose holding force exceeds its limit by less than 1e-9 (1 + force) still rests."""
    system = vc.System(vc.Oscillator(), vc.Coulomb(1.0, 1.0), vc.Constant(0.0))
    sides = [[mode.sides for mode in vc.contact_modes(system, {"position": 1.0 + excess})] for excess in (6e-10, 6e-9)]
    assert sides == [[(0,)], [(-1,)]]


@pytest.fixture(scope="module")
def motion():
    return vc.simulate(vc.System(vc.PendulumCapsule(), vc.Exponential(), vc.Harmonic(1.8)), periods=4)


@pytest.mark.parametrize(("excess", "fails"), [(3e-10, False), (3e-9, True)])
def test_a_hold_beyond_its_limit_by_more_than_a_billionth_is_a_slip_that_was_missed(motion, excess, fails):
    shares = evidence._shares_held

    def grown(*given):
        found = shares(*given)
        return found * ((1.0 + excess) / np.max(np.abs(found), initial=0.1))

    with (
        mock.patch.object(evidence, "_shares_held", grown),
        mock.patch.object(evidence, "_slip_shortfall", return_value=None),
    ):
        assert any("a slip was missed" in failure for failure in motion.certify(motion).failures) == fails


@pytest.mark.parametrize(("share", "fails"), [(0.5, False), (2.0, True)])
def test_an_event_may_be_off_by_the_tolerance_of_a_velocity(motion, share, fails):
    """Of the natural size of the velocity of the capsule, which is one."""
    recorded = dataclasses.replace(motion.certify.recorded, contact_residual=share * motion.tolerance)
    failures = dataclasses.replace(motion.certify, recorded=recorded)(motion).failures
    assert any("an event was not located" in failure for failure in failures) == fails


def last_shifted(values, off):
    return values + off * (np.arange(len(values)) == len(values) - 1)


BEYOND = {  # what a certificate then says: (evidence, made wrong by a size, sizes on both sides of the threshold)
    # a billionth of the limit
    "began too early": ("_slip_shortfall", lambda real, lost: lost, (3e-10, 3e-9)),
    # 64 roundings of the largest velocity, or of 1: (share held, least velocity, fastest)
    "passes rest": ("_contact_evidence", lambda real, passed: (1.0, -passed, 0.5), (5e-15, 5e-14)),
    # a hundred tolerances of the natural size of energy, some 3 here, and a tenth of one more for each step
    "the balance of": ("_at_marks", last_shifted, (2e-8, 4e-6)),
}


@pytest.mark.parametrize("said", BEYOND)
def test_a_certificate_says_what_is_just_beyond_its_threshold(motion, said):
    name, wrong, sizes = BEYOND[said]
    real = getattr(evidence, name)
    for size, fails in zip(sizes, (False, True), strict=True):
        with mock.patch.object(evidence, name, lambda *given, size=size: wrong(real(*given), size)):
            assert any(said in failure for failure in motion.certify(motion).failures) == fails


@pytest.mark.parametrize(("off", "told"), [(3e-10, False), (1e-7, True)])
def test_powers_may_contradict_rates_by_rounding(motion, off, told):
    """A billionth of all that flows."""
    recorded = equations(motion.system)
    stored, inflow = recorded.observables["momentum"] * (1.0 + off), -recorded.observables["friction"]
    assert bool(contradictions._contradiction(motion, recorded, stored, [inflow])) == told


# --- decisions of contacts --------------------------------------------------------------------------------------------


def answer(excess, came=()):
    """(side, whether it is left to its series) of the first of two contacts, pushed beyond its limit by this share."""
    problem = Problem(
        free=np.array([1.0 + excess, 0.3]), response=np.eye(2), loads=np.ones(2), raised=np.zeros((2, 2)),
        sliding=np.ones(2), least=-np.ones(2), most=np.ones(2), down=-np.ones(2), up=np.ones(2),
    )  # fmt: skip
    sides = kernel_decision(problem, [0, 1], set(came), {0: 1, 1: 1})
    kernel = contacts_of(2)
    return sides[0], kernel.ints[kernel.place("TRANSITION")]


@pytest.mark.parametrize("came", [(), (0,)])
def test_a_force_within_a_billionth_of_its_limit_is_left_to_the_series(came):
    """On both sides of the limit; farther from it the forces decide at once."""
    assert [answer(excess, came) for excess in (-1e-8, -3e-10, 3e-10, 1e-8)] == [(0, 0), (0, TIED), (0, TIED), (1, 1)]


def test_what_holds_in_every_other_mode_may_be_off_by_a_hundredth_of_that():
    """1e-11 of its limits: a contact at rest whose force is beyond by less fits while modes are tried."""
    kernel = contacts_of(2)
    names = kernel.names
    for excess, misfit in ((-1e-9, -1), (1e-11, -1), (1e-10, 0)):
        for name, value in (("OPEN", 0.0), ("AT_REST", 1.0), ("TRIED", 0.0), ("FORCES", 1.0 + excess)):
            kernel.floats[names[name]] = value
        held = lambda floats, c: (-1.0, 1.0)  # noqa: E731
        with mock.patch.dict(names, {"sticking_range": held}):
            assert names["first_misfit"](kernel.floats, 1, 0.0) == misfit


@pytest.fixture(scope="module")
def block():
    return kernel_of(vc.System(vc.Oscillator(), vc.Coulomb(1.0, 1.5), vc.Harmonic()))


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_contact_that_stops_is_left_to_its_series_within_a_thousandth_of_its_limit(block, side):
    """Well within it rests, well beyond it turns; the force of the slide before is known to a thousandth or better."""
    texts = []
    for share in (0.998, 0.9995, -0.9995, -1.0005, -1.002, 1.002):

        def holding(floats, _t, _point, _lane, out, share=share):
            floats[out], floats[out + 1] = side * share * 1.5, 1.5

        block.fill("SIDE", side)
        block.fill("TRANSITION", 0)
        with mock.patch.dict(block.names, {"holding": holding}):
            block["rest"](block.floats, block.ints, 0)
        asked = block.ints[block.place("TRANSITION")] == ARRIVED
        texts.append("asked" if asked else block.floats[block.place("SIDE")] * side)
    assert texts == [0.0, "asked", "asked", "asked", -1.0, "asked"]


@pytest.mark.parametrize(("above", "vanish"), [(1e-14, True), (1e-13, False)])
def test_a_guard_of_a_hold_below_64_roundings_of_both_forces_is_none(block, above, vanish):
    for row, values in (("STICKING_FORCE_OF", [1.0, 0.0]), ("LIMIT_OF", [1.0 + above, 1.0])):
        place = block[row][0]
        block.floats[place : place + 13] = 0.0
        block.floats[place : place + 2] = values
    assert (block["guard_series"](block.floats, 0, 0, 1, 1.0) > 0) == vanish


@pytest.mark.parametrize(("slope", "leaves"), [(3e-7, True), (3e-6, False)])
def test_a_contact_leaves_with_an_acceleration_from_a_millionth_of_its_growth(block, slope, leaves):
    """A smaller one is rounding, as behind a hold that gave way at its limit: then the next term tells the side."""
    velocity = block["VELOCITY_OF"][0]
    block.floats[velocity : velocity + 13] = 0.0
    block.floats[velocity + 1 : velocity + 3] = -slope, 1.0
    block.floats[block["LIMIT_OF"][0]] = 1.0
    block.fill("SIDE", 1.0)
    block.fill("TRANSITION", 2)
    with mock.patch.dict(block.names, taylor_step=lambda floats, ints, lane: 1.0):
        assert block["leaves"](block.floats, block.ints, 0, 0) == leaves


@pytest.mark.parametrize(
    ("error", "end", "doubtful"), [(0.01, 1.0, False), (0.1, 1.0, True), (3e-15, 0.0, False), (3e-14, 0.0, True)]
)
def test_a_sign_is_in_doubt_from_three_hundredths_of_a_velocity_or_from_rounding(error, end, doubtful):
    kernel = kernel_of(vc.System(vc.Oscillator(), vc.LuGre(), vc.Harmonic()))
    state = kernel["STATE_OF"][0]
    kernel.floats[kernel["STAGE"] + (kernel["STAGES"] - 1) * kernel["STATES"] + state] = error
    assert (kernel["doubt_of_sign"](kernel.floats, state, 0, end, end) > 1.0) == doubtful


def test_contacts_give_way_together_within_rounding_of_their_limits():
    """64 rounding errors: what is at its limit at one instant, to the last digits of the series that say so."""
    kernel = contacts_of(2)
    names = kernel.names
    for gap, side in ((0.0, 1.0), (32.0 * EPSILON, 1.0), (500.0 * EPSILON, 0.0)):
        for row, value in ((names["STICKING_FORCE_OF"][0], 1.0 - gap), (names["LIMIT_OF"][0], 1.0)):
            kernel.floats[row : row + kernel.layout.order + 1] = 0.0
            kernel.floats[row] = value
        kernel.fill("SIDE", [0.0, 1.0])
        names["give_way_together"](kernel.floats, kernel.ints, 0, 0.1)
        assert kernel.floats[kernel.place("SIDE")] == side


def test_a_contact_that_gave_way_is_known_until_time_advances():
    """Its side, the order of vanishing of its velocity, and that it holds kinetic friction only."""
    kernel = contacts_of(2)
    kernel.fill("GAVE_WAY", [0, 0])
    kernel.fill("TRANSITION", [ARRIVED, ARRIVED])

    def entries(name):
        return [*kernel.ints[kernel.place(name) :][:2]]

    kernel["give_way"](kernel.floats, kernel.ints, 0, 1, -1.0, 2)
    assert kernel.floats[kernel.place("SIDE") + 1] == -1.0
    assert (entries("TRANSITION"), entries("GAVE_WAY")) == ([ARRIVED, 2], [0, 1])
    kernel["settle"](kernel.ints, 0)
    assert (entries("TRANSITION"), entries("GAVE_WAY")) == ([0, 0], [0, 0])


def test_a_force_that_has_jumped_beyond_its_limit_asks_again_who_rests():
    """A billionth beyond, which no step makes by itself."""
    kernel = contacts_of(2)
    names = kernel.names
    for excess, asked in ((-0.1, 0), (3e-10, 0), (3e-9, ARRIVED)):
        kernel.floats[names["STICKING_FORCE_OF"][0]], kernel.floats[names["LIMIT_OF"][0]] = -2.0 * (1.0 + excess), 2.0
        kernel.fill("SIDE", [0.0, 1.0])
        kernel.fill("TRANSITION", [0, 0])
        kernel.fill("GAVE_WAY", [0, 0])
        assert bool(names["open_still"](kernel.floats, kernel.ints, 0)) == bool(asked)
        assert kernel.ints[kernel.place("TRANSITION")] == asked


def test_what_is_shorter_than_a_sliver_of_a_period_is_no_rest():
    """1e-12 of a period, which the end of a window may cut off."""
    for length, counted in ((3e-13, 0.0), (3e-12, 1.0)):
        places = {name: i for i, name in enumerate(("PHASE_SIDE", "PHASE_LENGTH", "PERIOD", "STICK_TIME"))}
        floats = np.array([0.0, length * 7.0, 7.0, 0.0, 0.0])
        names = places | {"STICK_PHASES": 4, "LANES": 1, "SLIVER": SLIVER}
        exec(kernel_source("observe.window"), names)
        names["end_phase"](floats, 0, 0)
        assert floats[4] == counted
        assert floats[3] == counted * length * 7.0


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_of_two_dips_of_a_guard_close_together_the_one_that_is_below_zero_is_found(block, side):
    """At 1/500 of a step, by less than 1e-12 of the terms, which is still a hundred times rounding."""
    middle, half, deep = 0.4, 1e-3, 1e-13
    dips = np.polynomial.polynomial.polypow(np.polynomial.polynomial.polyfromroots([middle - half, middle + half]), 2)
    dips[:2] += side * deep / half * np.array([-middle, 1.0])  # the one falls by so much, the other rises
    row = block.series(0)
    row[:] = 0.0
    row[:5] = dips
    root, _ = block["first_root"](block.floats, block["SERIES"], 4, 1.0, 0, 1.0)
    assert root == pytest.approx(middle - side * half - np.sqrt(deep) / (2.0 * half), abs=5e-5)


# --- what settles -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("apart", "rank"), [(3e-10, 1), (3e-9, 2)])
def test_changes_of_steps_that_differ_by_a_billionth_are_two(apart, rank):
    steps = np.array([[-2.0, -apart], [-1.0, -apart], [0.0, 0.0], [1.0, 0.0]])
    assert Stroboscope(np.vstack([np.zeros(2), np.cumsum(steps, axis=0)]))._asked("weights_of", 1) == rank


def test_what_multipliers_leave_of_the_last_step_counts_tenfold():
    """Six states that shrink twentyfold, five of them by chance besides: three multipliers do not explain the steps."""
    directions = np.ones((14, 6))
    directions[:, 1:] = 0.3 * np.random.default_rng(1).standard_normal((14, 5))
    marks = 500.0 * 0.05 ** np.arange(14.0)[:, None] * directions
    steps = np.diff(marks[-5:], axis=0)
    changes = np.diff(steps, axis=0)[::-1].T
    left = steps[-1] - changes @ np.linalg.lstsq(changes, steps[-1], rcond=None)[0]
    _, remaining = Stroboscope(marks).distance_to_go(1, 1e-30)
    assert remaining is not None
    assert 9.0 < remaining / np.max(np.abs(left)) < 20.0


def asked(steps, question, *arguments, **shares):
    """Answer to a question about marks of one state, which take these steps from zero."""
    return Stroboscope(np.cumsum([0.0, *steps])[:, None])._asked(question, *arguments, **shares)


@pytest.mark.parametrize(("step", "may"), [(6e-3, True), (1.8e-2, False)])
def test_states_of_runs_that_may_settle_are_within_a_million_natural_sizes(step, may):
    """Two blocks before a last step d they would differ by d^3 over the square of the threshold."""
    assert asked([1e7, 0.0, step], "may_settle", 1, threshold=1e-6, tolerance=1e-12) == may


@pytest.mark.parametrize(("size", "ratio"), [(4.0, 0.0), (25.0, -1.0)])
def test_differences_of_ten_tolerances_are_a_standstill(size, ratio):
    """Larger ones that do not shrink are none."""
    steps = size * 1e-9 * (-1.0) ** np.arange(12)
    assert asked(steps, "distance_to_go", 1, tolerance=1e-9)[0] == ratio


def test_what_grew_within_a_block_while_blocks_shrink_contracts_by_a_hundredth():
    """Slower contraction is not believed from three differences, faster one would settle an oscillation too early."""
    ratio, _ = asked([4.0] * 6 + [1.0] * 3 + [1e-3, 2e-3, 2e-3], "distance_to_go", 1, tolerance=1e-9)
    assert ratio == pytest.approx(0.99, abs=2e-3)


@pytest.mark.parametrize(("apart", "period"), [(6.0, 1), (20.0, 2)])
def test_looking_back_a_motion_contracts_by_no_more_than_a_hundred(apart, period):
    """Over two periods: what is within the threshold was within ten a period earlier."""
    steps = apart * 1e-6 * (-1.0) ** np.arange(12)
    assert asked(steps, "shortest_period", 2, 1e-9, threshold=1e-6) == period


@pytest.mark.parametrize(("times", "rank"), [(40.0, 1), (250.0, 0)])
def test_steps_that_change_by_a_hundred_times_the_last_tell_no_multiplier(times, rank):
    assert asked([0.0, 0.0, 1.0 + times, 1.0], "weights_of", 1) == rank


@pytest.mark.slow  # its kernel
def test_the_error_of_an_implicit_step_is_held_to_the_tolerance():
    """Some 900 of them: the end is within five tolerances; fourteen where a hundredth of the error counts."""
    law = vc.RateAndStateAgeing(0.3, 0.03, 0.06, 1e-4, 0.1)
    system, start = vc.System(vc.Oscillator(belt_speed=0.5), law, vc.Harmonic(0.8)), {"log_age": 0.5}
    rough, fine = (vc.simulate(system, periods=4, tolerance=tolerance, initial=start) for tolerance in (1e-7, 1e-11))
    assert np.max(np.abs(rough.sections[-1] - fine.sections[-1])) <= 5e-7
