"""Travel, settling and the class of a response: closed-form signals, made-up maps, and the paper's motions."""

import dataclasses
import math

import numpy as np
import pytest

import vibrocap as vc
from signals import Signal, made_up_motion, paper_motion, paper_system

PERIOD = 2 * math.pi
# X = 0.3 + 0.05 t + 0.4 cos(t + 0.7): whole periods leave the slope alone
TRAVEL = Signal(((0.4, 1.0, 0.7),), offset=0.3, slope=0.05)
ROUNDING = 1e-14  # a few sums of numbers of the order of one


def no_force(t, side):
    return np.zeros_like(t)


@pytest.fixture(scope="module")
def made_up():
    return made_up_motion(vc.Exponential(), TRAVEL, no_force, periods=12)


def with_map(states, tolerance=1e-9):
    """A motion whose stroboscopic angle and velocity are the given sequence and twice it; its position wanders."""
    states = np.asarray(states, dtype=float)
    motion = made_up_motion(vc.Exponential(), TRAVEL, no_force, periods=2, tolerance=tolerance)
    sections = np.zeros((len(states), len(motion.state_names)))
    sections[:, 0], sections[:, 3] = states, 2.0 * states
    sections[:, 2] = np.cumsum(1.0 + np.arange(len(states)))  # the cyclic coordinate must not matter
    return dataclasses.replace(motion, sections=sections)


def test_displacement_over_any_window(made_up):
    for start, end in ((0.0, 75.0), (1.3, 2.9), (70.1, 70.2)):
        expected = 0.05 * (end - start) + 0.4 * (math.cos(end + 0.7) - math.cos(start + 0.7))
        assert vc.displacement(made_up, (start, end)) == pytest.approx(expected, abs=ROUNDING * end)
    assert vc.displacement(made_up) == pytest.approx(0.05 * 12 * PERIOD, abs=1e-12)
    assert vc.displacement(made_up, periods=3) == pytest.approx(0.05 * 3 * PERIOD, abs=1e-12)


def test_drift_and_mean_velocity_leave_the_slope(made_up):
    for period in (-12, -1, 0, 7):
        assert vc.drift(made_up, period) == pytest.approx(0.05 * PERIOD, abs=1e-13)
    for periods in (1, 5, 12):
        mean = vc.mean_velocity(made_up, periods)
        assert mean.value == pytest.approx(0.05, abs=1e-13)
        assert mean.window == pytest.approx(((12 - periods) * PERIOD, 12 * PERIOD))


@pytest.mark.parametrize(
    ("call", "complaint"),
    [
        (lambda m: vc.mean_velocity(m, 13), "periods should be at most 12"),
        (lambda m: vc.mean_velocity(m, 2.5), "periods should be a whole number"),
        (lambda m: vc.drift(m, 12), "period should be a whole number from -12 to 11"),
        (lambda m: vc.displacement(m, (3.0, 2.0)), "window should be"),
        (lambda m: vc.displacement(m, (0.0, 1e3)), "window should be"),
        (lambda m: vc.displacement(m, (math.nan, 1.0)), "window should be"),
        (lambda m: vc.displacement(m, 5.0), "window should be a pair"),
        (lambda m: vc.displacement(m, (0.0, 1.0), periods=1), "not both"),
        (lambda m: vc.settling(m, threshold=0.0), "threshold should be > 0"),
    ],
)
def test_what_cannot_be_measured_is_refused(made_up, call, complaint):
    with pytest.raises(ValueError, match=complaint):
        call(made_up)


def test_a_short_run_cannot_tell():
    verdict = vc.settling(with_map(np.zeros(10)))
    assert (verdict.settled, verdict.residual, verdict.remaining) == (False, None, None)
    assert vc.settling(with_map(np.zeros(11))).settled


@pytest.mark.parametrize("multiplier", [0.3, 0.9, 0.999, -0.5, -0.99])
@pytest.mark.parametrize("distance", [1e-5, 4e-7])
def test_settled_means_a_small_distance_not_a_small_step(multiplier, distance):
    """s_k = s + distance at the end: the steps are distance (1/|r| - 1), a thousandth of it for r = 0.999."""
    k = np.arange(41)
    verdict = vc.settling(with_map(0.5 * distance * multiplier ** (k - 40.0), tolerance=1e-12))
    # `velocity` is twice the angle, so it is `distance` away from its limit. A geometric sequence is bounded exactly,
    # whether it alternates (by n = 2) or not (by n = 1); n = 1 bounds an alternating one by (1+|r|)/(1-|r|) as much.
    assert verdict.settled == (distance < 1e-6)
    assert verdict.remaining >= distance * (1 - 1e-9)
    if multiplier > 0 or not verdict.settled:
        assert verdict.remaining == pytest.approx(distance, rel=1e-9)
    ratios = [abs(multiplier) ** n for n in ((1,) if multiplier > 0 else (1, 2))]
    assert any(verdict.ratio == pytest.approx(ratio, rel=1e-9) for ratio in ratios)
    assert not verdict.settled or verdict.period == 1


def test_since_is_where_the_motion_came_within_the_threshold():
    k = np.arange(60)
    verdict = vc.settling(with_map(0.5 * 0.5**k, tolerance=1e-12))  # velocity at 0.5^k of its end
    assert verdict.since == 20  # 2^-20 = 9.5e-7 <= 1e-6 < 2^-19


def test_mean_velocity_is_settled_only_if_its_window_is():
    motion = with_map(0.5 * 0.5 ** np.arange(41.0), tolerance=1e-12)
    assert vc.mean_velocity(motion, 20).settled
    assert not vc.mean_velocity(motion, 21).settled


@pytest.mark.parametrize("n", [1, 2, 3, 4, 5, 8, 16])
def test_period_of_a_repeating_map(n):
    cycle = np.random.default_rng(n).normal(size=n)
    verdict = vc.settling(with_map(np.tile(cycle, 130)[:130]))
    assert (verdict.settled, verdict.period, verdict.since) == (True, n, 0)


def test_noise_of_the_integration_counts_as_rest_and_more_does_not():
    noise = np.random.default_rng(3).uniform(-1.0, 1.0, 41)
    assert vc.settling(with_map(0.1 + 1e-9 * noise, tolerance=1e-9)).settled
    assert not vc.settling(with_map(0.1 + 1e-4 * noise, tolerance=1e-9)).settled


def test_a_fast_transient_does_not_hide_a_slow_one():
    """1e-5 of a mode of multiplier 0.99 is left when one of 0.05 has just died: blocks alone would call it settled."""
    k = np.arange(14)
    slow = 1e-5 * 0.99 ** (k - 13.0)
    verdict = vc.settling(with_map(0.5 * (slow + 0.05**k), tolerance=1e-12))
    assert not verdict.settled


def logistic(count, parameter=4.0, x=0.3):
    values = []
    for _ in range(count):
        values.append(x)
        x = parameter * x * (1.0 - x)
    return np.array(values)


def test_classes_of_what_does_not_settle():
    assert vc.response_class(with_map(logistic(200))).kind == "other"
    assert vc.response_class(with_map(logistic(40))).kind == "not settled"  # too short to tell
    slow = vc.response_class(with_map(0.995 ** np.arange(200.0)))
    assert (slow.kind, slow.period, slow.symmetric) == ("not settled", None, None)
    falling = vc.response_class(with_map(0.99 ** np.arange(200.0) * logistic(200)))
    assert falling.kind == "not settled"  # never near itself, but nearer and nearer
    golden = np.cos(2 * math.pi * (math.sqrt(5) - 1) / 2 * np.arange(300))  # quasi-periodic in truth
    assert vc.response_class(with_map(golden)).kind in ("other", "not settled")
    assert not vc.settling(with_map(golden)).settled


# ---------------------------------------------------------------------------------------------------------------------
# The paper's motions (PHYSICS reference values)


def test_settling_of_the_paper_motions():
    assert vc.settling(paper_motion(vc.Exponential())).settled
    # Steps of 2.3e-6 to and fro, with a multiplier of -0.837: a little more than 1e-6 still to go after 40 periods.
    longer = paper_motion(vc.LuGre(), periods=90)
    short = vc.settling(dataclasses.replace(longer, sections=longer.sections[:41]))
    assert not short.settled
    assert short.ratio == pytest.approx(0.837, abs=1e-3)
    end = vc.settling(longer)
    assert end.settled
    # The bound of the short run held.
    scales = np.array([1.0, 1.0, 1.0, 0.0045])
    states = longer.sections[:, [0, 1, 3, 4]] / scales
    assert short.remaining >= np.max(np.abs(states[90] - states[40])) >= 0.5 * short.remaining
    # The mark named by `since` is within the threshold of the end, the one before is not.
    away = np.max(np.abs(states[90] - states), axis=1)
    assert away[end.since] <= end.threshold < away[end.since - 1]


def test_symmetric_orbits_do_not_drift_and_others_have_a_twin():
    law = vc.Exponential()
    still = paper_motion(law, stiffness=4.0, damping=1.2)
    symmetric = vc.response_class(still)
    assert (symmetric.kind, symmetric.symmetric) == ("period-1", True)
    assert abs(vc.drift(still)) < 1e-9  # within a few tolerances of the run
    runs = [
        vc.simulate(paper_system(law, amplitude=a), periods=40, initial={"angle": s}, tolerance=1e-10)
        for a, s in ((1.8, math.pi / 3), (-1.8, -math.pi / 3))
    ]
    assert [vc.response_class(run).symmetric for run in runs] == [False, False]
    assert vc.drift(runs[0]) == pytest.approx(-vc.drift(runs[1]), abs=1e-13)
    assert vc.drift(runs[0]) > 0.1


@pytest.mark.plain
def test_symmetry_is_not_asked_of_a_drive_without_it():
    drive = vc.Biharmonic(amplitude=1.8, frequency=1.0, second_amplitude=0.4, second_phase=0.5)
    motion = vc.simulate(paper_system(vc.Exponential(), 4.0, 1.2, drive=drive), periods=40, initial={"angle": 1.0})
    found = vc.response_class(motion)
    assert (found.kind, found.symmetric) == ("period-1", None)


def test_a_period_eight_response():
    """LuGre with delta1 = 1, else the paper's first set: three period doublings, found by its map repeating."""
    motion = paper_motion(vc.LuGre(bristle_damping=1.0), periods=330, tolerance=1e-9)
    found = vc.response_class(motion)
    assert (found.kind, found.symmetric) == ("period-8", False)
    velocities = motion.sections[-16:, 3]
    assert velocities[8:] == pytest.approx(velocities[:8], abs=1e-5)
    assert np.min(np.abs(np.diff(np.sort(velocities[8:])))) > 1e-4  # eight different ones
