"""Settling, decided at every mark of a run: the same decision as on a stored motion, and what the run then does."""

import dataclasses
import math

import numpy as np
import pytest

import vibrocap as vc
from thinned import exhaustive_but
from vibrocap.numerics.kernel.observe.settle import (
    FASTEST,
    LINEAR,
    LONGEST_PERIOD,
    SLOWEST,
    STANDSTILL,
    UNSEEN,
)
from vibrocap.numerics.run.stroboscope import Stroboscope

TOLERANCE = 1e-9
THRESHOLD = 1e-6
EM = vc.System(vc.PendulumCapsule(), vc.Exponential(), vc.Harmonic())
START = {"angle": math.pi / 3}


# --- the criterion, written once more with arrays --------------------------------------------------------------------


def reference(states, threshold, tolerance):
    """(period, since, remaining) by the criterion of `measures.settling`, or (0, 0, 0.0)."""
    for n in range(1, LONGEST_PERIOD + 1):
        block = max(n, 3)
        if len(states) - 1 < n + 3 * block:
            break
        differences = np.max(np.abs(states[n:] - states[:-n]), axis=1)[-3 * block :]
        oldest, older, latest = differences.reshape(3, block).max(axis=1)
        phases = [states[len(states) - 1 - phase :: -n][: 3 * block // n + 1] for phase in range(n)]
        if max(float(np.max(np.ptp(phase, axis=0))) for phase in phases) <= STANDSTILL * tolerance:
            stride = min((len(states) - 1) // 4, LONGEST_PERIOD) // n * n
            ratio, remaining = 0.0, max(latest, distance_to_limit(states, stride)[0])
        else:
            per_block = max(latest / max(older, tolerance), older / max(oldest, tolerance))
            if not per_block < 1.0:
                continue
            within = (differences[-1] / max(differences[-block], tolerance)) ** (1.0 / (block - 1))
            ratio = max(per_block ** (n / block), min(within, SLOWEST) ** n)
            distance = np.max(differences[-block:] * ratio ** (np.arange(block - 1, -1, -1) / n))
            remaining = max(distance * ratio / (1.0 - ratio), *distance_to_limit(states, n))
        if remaining <= threshold:
            period = reference_period(states, n, ratio, threshold)
            return period, reference_since(states, period, threshold - remaining), remaining
    return 0, 0, 0.0


def distance_to_limit(states, n):
    """(distance from the last mark to the limit of the last five, n periods apart; UNSEEN times what is unexplained).

    By least squares; changes of steps of more than LINEAR times the last one do not count.
    """
    marks = states[len(states) - 1 - 4 * n :: n]
    steps = np.diff(marks, axis=0)
    changes = [steps[j] - steps[j - 1] for j in (3, 2, 1)]
    left_out = [not 0.0 < np.linalg.norm(change) <= LINEAR * np.linalg.norm(steps[3]) for change in changes]
    rank = left_out.index(True) if True in left_out else 3
    while rank and np.linalg.matrix_rank(np.array(changes[:rank]).T / np.linalg.norm(changes[:rank], axis=1)) < rank:
        rank -= 1
    if not rank:
        return 0.0, UNSEEN * float(np.max(np.abs(steps[3])))
    factors = np.linalg.lstsq(np.array(changes[:rank]).T, -steps[3], rcond=None)[0]
    left = steps[3] + np.array(changes[:rank]).T @ factors
    way = steps[3:0:-1][:rank].T @ factors
    return float(np.max(np.abs(way))), UNSEEN * float(np.max(np.abs(left)))


def reference_period(states, n, ratio, threshold):
    per_period = max(ratio, FASTEST) ** (1.0 / n)
    for divisor in range(1, n):
        earlier = 1.0 if ratio == 0.0 else per_period**-divisor  # on the other side, perhaps
        allowed = (1.0 + earlier) * threshold * per_period ** np.arange(1.0 - n, 1.0)
        differences = np.max(np.abs(states[-n:] - states[-n - divisor : -divisor]), axis=1)
        if n % divisor == 0 and np.all(differences <= allowed):
            return divisor
    return n


def reference_since(states, n, distance):
    phase = (np.arange(len(states)) - (len(states) - n)) % n
    away = np.flatnonzero(np.max(np.abs(states - states[len(states) - n :][phase]), axis=1) > distance)
    return int(away[-1]) + 1 if len(away) else 0


def made_up_states(rng):
    """Stroboscopic states on their way to a response of some period: monotone, alternating, spiralling, noisy."""
    marks, states = int(rng.integers(5, 120)), int(rng.integers(1, 4))
    steady = rng.normal(size=(int(rng.choice([1, 1, 2, 2, 3, 4, 6, 8, 16])), states))
    k = np.arange(marks)[:, None]
    contraction = rng.uniform(0.05, 0.999) * rng.choice([1, -1])
    turning = np.cos(rng.uniform(0, np.pi) * rng.choice([0, 1]) * k + rng.normal(size=states))
    noise = rng.choice([0.0, 1e-9, 1e-8, 1e-4]) * rng.normal(size=(marks, states))
    size = 10 ** rng.uniform(-7, 1)
    return steady[k[:, 0] % len(steady)] + size * np.sign(contraction) ** k * np.abs(contraction) ** k * turning + noise


def test_the_decision_is_the_criterion():
    """The scalar code with its shortcuts (`may_settle`) decides like the full criterion, on 400 made-up maps."""
    rng = np.random.default_rng(1)
    settled = 0
    for _ in range(400):
        states = made_up_states(rng)
        period, since, remaining = reference(states, THRESHOLD, TOLERANCE)
        response = Stroboscope(states).settled_response(THRESHOLD, TOLERANCE)
        assert response[:2] == (period, since)
        assert response[2] == pytest.approx(remaining, rel=1e-5)  # least squares of steps of many sizes, by two ways
        settled += period > 0
    assert 100 < settled < 300  # both answers are put to the test


def test_the_shortcuts_save_the_work():
    """Far from settled, nothing but two differences per n is looked at."""
    k = np.arange(72)[:, None]
    marks = Stroboscope(0.3 * 0.97**k * np.ones((1, 3)))

    def fail(*_):
        raise AssertionError("the full criterion was evaluated")

    marks.functions["distance_to_go"] = fail
    assert marks.settled_response(THRESHOLD, TOLERANCE) == (0, 0, 0.0)


# --- runs that stop when they have settled ---------------------------------------------------------------------------


@pytest.fixture(scope="module")
def runs():
    ratios = np.array([0.5, 1.0, 2.5, 4.0])
    results = vc.ensemble(
        EM,
        {"machine.mass_ratio": ratios},
        initial=START,
        measures=["drift", "time_to_settle", "symmetric"],
        periods=60,
        settle=THRESHOLD,
    )
    motions = [
        vc.simulate(EM.with_parameters({"machine.mass_ratio": float(ratio)}), initial=START, tolerance=1e-8, periods=60)
        for ratio in ratios
    ]
    return results, motions


def test_a_run_stops_at_the_first_mark_at_which_it_has_settled(runs):
    """As `settling` finds on the stored motion, cut at that mark and at every earlier one."""
    found, motions = runs
    assert found["settled"].all()
    for i, motion in enumerate(motions):
        start = found["window_start"][i]
        assert 9 < start < 50
        cuts = [dataclasses.replace(motion, sections=motion.sections[: mark + 1]) for mark in range(start + 1)]
        *before, cut = (vc.settling(cut, threshold=THRESHOLD) for cut in cuts)
        assert cut.settled
        assert not any(earlier.settled for earlier in before)
        assert cut.since is not None
        assert found["response_period"][i] == found["window_periods"][i] == cut.period
        assert found["time_to_settle"][i] == cut.since * motion.period


def test_settled_measures_are_those_of_the_steady_motion(runs):
    found, motions = runs
    for i, motion in enumerate(motions):
        assert found["drift"][i] == pytest.approx(vc.drift(motion), abs=2 * THRESHOLD)
        symmetric = vc.response_class(motion).symmetric
        assert found["symmetric"][i] == symmetric


def test_what_does_not_settle_says_so():
    """Too few periods to tell: the last ones of the budget are measured. It may yet settle within these."""
    asked = {"initial": START, "measures": ["drift", "time_to_settle", "symmetric"], "settle": THRESHOLD}
    results = vc.ensemble(EM, {"machine.mass_ratio": [2.5]}, periods=9, window=4, **asked)
    assert (results["settled"][0], results["response_period"][0]) == (False, 0)
    assert (results["window_start"][0], results["window_periods"][0]) == (5, 4)
    assert np.isfinite(results["drift"][0])
    assert np.isnan([results["time_to_settle"][0], results["symmetric"][0]]).all()
    ints = vc.ensemble(EM, {"machine.mass_ratio": [2.5]}, periods=60, **asked)
    settles = int(ints["window_start"][0])
    last = vc.ensemble(EM, {"machine.mass_ratio": [2.5]}, periods=settles, window=4, **asked)
    assert not last["settled"][0]  # it settles at the very end: no period is left to measure
    assert last["window_start"][0] == settles - 4
    room = vc.ensemble(EM, {"machine.mass_ratio": [2.5]}, periods=settles + 1, window=4, **asked)
    assert room["settled"][0]
    assert (room["window_start"][0], room["window_periods"][0]) == (settles, 1)
    assert room["drift"][0] == ints["drift"][0]


# --- close to bifurcations, where a mode is slow ----------------------------------------------------------------------

FLIP, PITCHFORK, FOLD = 0.9962382246720237, 1.283213153, 1.9096548981581978  # docs/orbits.md; BEYOND's table
NEAR = 1e-4  # of the parameter
KNOWN = 20.0  # thresholds by which a motion that is called settled may be off
CLOSE = {  # system, parameter, its value there, a state whose start varies, between
    "flip": (
        vc.System(vc.VibroImpactCapsule(), vc.Coulomb(1.0, 1.0), vc.Harmonic(1.6, FLIP)),
        "drive.frequency", FLIP, "displacement_rate", (-0.5, 0.5),
    ),
    "pitchfork": (EM, "drive.amplitude", PITCHFORK, "angle", (0.2, 1.2)),
    "fold": (
        vc.System(vc.PendulumCapsule(), vc.LuGre(), vc.Harmonic()), "drive.amplitude", FOLD, "angle", (0.2, 1.2),
    ),
}  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize(
    ("kind", "count", "periods", "least"),
    exhaustive_but([0], [("flip", 100, 3000, 20), ("fold", 100, 3000, 90), ("pitchfork", 30, 30000, 5)]),
)
def test_close_to_a_bifurcation_a_verdict_knows_the_slow_modes(kind, count, periods, least):
    """Of a flip, a fold, and a pitchfork, where transients take ten thousand periods and more.

    Two periods apart a mode near -1 hardly moves, so that faster ones hide it. What is called settled moves on by no
    more than so many thresholds in many periods more.
    """
    system, path, at, varied, between = CLOSE[kind]
    draw, asked = np.random.default_rng(count), {"measures": ["drift"], "final_states": True}
    values, starts = at + draw.uniform(-NEAR, NEAR, count), draw.uniform(*between, count)
    over = {path: values, f"initial.{varied}": starts}
    for extrapolate in (True, False):
        results = vc.ensemble(system, over, periods=periods, settle=THRESHOLD, extrapolate=extrapolate, **asked)
        settled = results["settled"]
        assert settled.sum() >= least
        ends = {f"initial.{name}": results[f"final.{name}"][settled] for name in system.state_names}
        on = vc.ensemble(system, {path: values[settled], **ends}, periods=4080, tolerance=1e-10, **asked)
        for name, scale in zip(system.state_names, system.scales(), strict=True):
            moved = np.abs(on[f"final.{name}"] - ends[f"initial.{name}"]) / scale
            assert name == system.cyclic or np.max(moved) < KNOWN * THRESHOLD
