"""Runs that go on from the extrapolated limit of their marks: right limits are taken, wrong ones leave no trace.

The algebra (limit, multipliers, the test of Schur and Cohn) against NumPy; values against runs of many periods; a run
whose trials are all refused against one that tried nothing, to the last bit; a saddle that a run passes.
"""

import contextlib
import dataclasses
import math
from unittest import mock

import numpy as np
import pytest

import vibrocap as vc
from thinned import exhaustive_but, slow_but
from vibrocap.motion.recording.equations import equations, parameter_values
from vibrocap.numerics import api as numerics
from vibrocap.numerics.linker import compiled_kernel, kernel_source
from vibrocap.numerics.run import ensemble as runs_of

THRESHOLD = 1e-6
START = {"angle": math.pi / 3}
EM = vc.System(vc.PendulumCapsule(), vc.Exponential(), vc.Harmonic(amplitude=1.8))
LM = vc.System(vc.PendulumCapsule(), vc.LuGre(), vc.Harmonic(amplitude=1.8))


# --- the algebra -----------------------------------------------------------------------------------------------------


def functions(states):
    """Those of `observe/extrapolation.py` as plain Python, with memory for five marks of one lane."""
    marks, work = 5, 500
    names = dict.fromkeys(("SCALE", "SIDE", "KEPT", "PERIOD_BUDGET", "SEGMENT", "SEGMENT_COUNT"), 0)
    names |= {"math": math, "LANES": 1, "MARKS": 0, "MARK_COUNT": marks, "MARK_SIZE": states, "STATES": states}
    names |= {"STEADY": marks * states, "WORK": work, "CYCLIC": -1}
    for module in ("observe.settle", "observe.extrapolation"):
        exec(kernel_source(module), names)
    return names, np.zeros(work + 9 * states + 40)


@pytest.mark.parametrize(("states", "multipliers"), [(3, 1), (3, 3), (4, 2), (6, 3)])
def test_the_limit_of_a_linear_map_is_found(states, multipliers):
    """Marks with up to three multipliers give their limit, and a polynomial whose roots these are."""
    draw = np.random.default_rng(states)
    for _ in range(40):
        rates = np.sort(draw.uniform(0.3, 0.9, multipliers) * draw.choice([-1, 1], multipliers))
        if np.any(np.diff(rates) < 0.15):
            continue
        limit, modes = draw.normal(size=states), draw.normal(size=(multipliers, states))
        names, floats = functions(states)
        powers = rates[None, :] ** np.arange(5)[:, None]
        floats[: 5 * states] = (limit + 1e-2 * powers @ modes).ravel()
        rank, _, unexplained = names["next_limit"](floats, 0, 4)
        assert rank == multipliers
        assert unexplained < 1e-12
        found = floats[names["STEADY"] :][:states]
        assert np.max(np.abs(found - limit)) < 1e-9
        weights = floats[names["WEIGHTS"] :][: rank + 1]
        assert np.sum(weights) == pytest.approx(1.0, abs=1e-8)
        assert np.sort(np.roots(weights[::-1]).real) == pytest.approx(rates, abs=1e-6)
        largest = float(np.max(np.abs(rates)))
        assert names["multipliers_within"](floats, rank, 1.001 * largest)
        assert not names["multipliers_within"](floats, rank, 0.999 * largest)


def test_multipliers_are_within_a_circle_where_the_roots_are():
    """The test of Schur and Cohn, beside the roots of 2,000 drawn polynomials, complex and double ones among them."""
    draw = np.random.default_rng(2)
    names, floats = functions(3)
    answers = []
    for _ in range(2000):
        rank = int(draw.integers(0, 4))
        weights = draw.normal(size=rank + 1)
        floats[names["WEIGHTS"] :][: rank + 1] = weights
        radius = draw.uniform(0.1, 3.0)
        largest = float(np.max(np.abs(np.roots(weights[::-1])), initial=0.0))
        if abs(largest - radius) < 1e-9:
            continue
        assert names["multipliers_within"](floats, rank, radius) == (largest < radius)
        answers.append(largest < radius)
    assert 500 < sum(answers) < 1700


# --- runs ------------------------------------------------------------------------------------------------------------


def problem(system, over):
    """(equations, parameters, initial) of runs."""
    recorded, count = equations(system), len(next(iter(over.values())))
    parameters = np.tile(parameter_values(system), (count, 1))
    for path, column in over.items():
        parameters[:, recorded.parameter_paths.index(path)] = column
    begun = [START.get(name, 0.0) for name in system.state_names]
    return recorded, parameters, np.tile(begun, (count, 1))


BUDGET = numerics.Budget(
    60, 1e-8, 10_000, 10**9, window=10, threshold=THRESHOLD,
    asked=numerics.codes.ASK_MODES | numerics.codes.ASK_INTEGRALS, evidence=1,
)  # fmt: skip


def settled(given, extrapolate, periods=60, threads=1):
    """Results of runs that settle."""
    budget = dataclasses.replace(BUDGET, periods=periods, extrapolate=extrapolate)
    return numerics.ensemble_run(numerics.EnsembleStart(*given), budget, threads=threads)


@contextlib.contextmanager
def faulty(given, *faults):
    """While this lasts, the kernel of these equations has planted faults, each (text, what stands in its place)."""
    layout, text = runs_of.ensemble_source(given[0], runs_of.ensemble_order(1e-8), runs_of.lane_count())
    for before, after in faults:
        assert text.count(before) == 1
        text = text.replace(before, after)
    kernel = layout, compiled_kernel(text)
    with mock.patch.object(runs_of, "ensemble_kernel", return_value=kernel):
        yield


CHECK = "if multipliers_within(floats, rank, left / (away + left)):"
CONVERGES = (
    "if difference(floats, MARKS, lane, mark, mark - 1) "
    "> difference(floats, MARKS, lane, mark - RANK, mark - RANK - 1):"
)
UNSTABLE = "or not multipliers_within(floats, rank, SLOWEST):"


def grid(system, masses, amplitudes):
    first, second = np.meshgrid(masses, amplitudes)
    return problem(system, {"machine.mass_ratio": first.ravel(), "drive.amplitude": second.ravel()})


def distances(system, given, results, long):
    """Over natural sizes, from the ends of the runs to those of long ones, but for the cyclic coordinate."""
    away = np.abs(results.state - long.state) / np.array(system.scales(), dtype=float)
    away[:, system.state_names.index("position")] = 0.0
    return np.max(away, axis=1)


def read(name):
    return vc.read_case(f"examples/{name}.toml").system


STANDS = {
    "a set-valued law": (EM, {"drive.amplitude": np.linspace(1.0, 3.0, 24)}),
    "a kinked law": (LM, {"drive.amplitude": np.linspace(1.0, 3.0, 24)}),
    "a spring to strike": (read("strikes-its-stop-and-travels"), {"machine.mass_ratio": np.linspace(2.0, 6.0, 24)}),
    "three contacts": (read("three-bodies-of-unequal-friction"), {"drive.amplitude": np.linspace(1.0, 3.0, 24)}),
    "stiff bristles": (
        vc.System(vc.PendulumCapsule(), vc.LuGre(bristle_stiffness=3e3, bristle_damping=30.0), vc.Harmonic()),
        {"drive.amplitude": np.linspace(1.0, 2.5, 10)},
    ),
}


@pytest.fixture(params=slow_but([0], exhaustive_but([0, 2, 4], [*STANDS])))
def stand(request):
    return STANDS[request.param]


def test_a_map_settles_in_fewer_periods_to_the_same_motions():
    """In at most 0.65 of the periods, trials included, to within the threshold of runs of 600 periods.

    What is extrapolated and not checked is off by more: that is what the check is for.
    """
    given = grid(EM, np.linspace(0.1, 8.0, 12), np.linspace(1.0, 3.0, 12))
    waited, found = settled(given, False), settled(given, True)
    cost = found.head("periods") + found.head("refused_trials")
    assert np.sum(cost) <= 0.65 * np.sum(waited.head("periods"))
    taken = found.head("extrapolated") == 1
    assert np.mean(taken) > 0.9
    assert np.all(found.response_period[taken] == 1)
    assert not np.any(waited.finished & ~found.finished)
    some = tuple(each[taken] if isinstance(each, np.ndarray) else each for each in given)
    budget = numerics.Budget(600, 1e-8, 10_000, 10**9, window=1, asked=numerics.codes.ASK_MODES)
    long = numerics.ensemble_run(numerics.EnsembleStart(*some), budget, threads=1)
    assert np.max(distances(EM, some, found[taken], long)) <= THRESHOLD
    for name in ("LETTERS", "LETTER_COUNT"):
        assert np.array_equal(found[taken].entries(name), long.entries(name))


def test_no_refused_trial_leaves_a_trace(stand):
    """Where every trial is refused, runs are those that try nothing, to the last bit of all that they end with."""
    system, over = stand
    given = problem(system, over)
    waited = settled(given, False)
    with faulty(given, (CHECK, "if False:")):
        found = settled(given, True)
    refused = found.layout.start_place - 2
    assert found.head("refused_trials").sum() > len(found) // 2
    assert np.all(found.head("extrapolated") == 0)
    assert np.array_equal(np.delete(found.numbers, refused, 1), np.delete(waited.numbers, refused, 1))


def test_threads_order_and_cuts_change_nothing():
    """Of runs that extrapolate and are refused: the same bits with two threads, in another order, and one by one."""
    given = grid(EM, np.linspace(0.1, 8.0, 8), np.linspace(1.0, 3.0, 8))
    found = settled(given, True)
    assert found.head("refused_trials").max() >= 1
    assert found.head("extrapolated").sum() > 10
    for order in (np.random.default_rng(0).permutation(64), [0], [17], [40]):
        again = settled((given[0], given[1][order], given[2][order]), True, threads=2)
        assert np.array_equal(again.numbers, found.numbers[order])


@pytest.mark.slow
def test_a_saddle_that_a_run_passes_is_not_taken():
    """Beside an unstable orbit of one period runs come and go, and settle where those do that wait.

    Its multiplier is -1.13: what approaches it leaves it again. Without the three looks at whether the marks converge,
    at their multipliers and at what is left to go, most runs are taken for settled at the saddle.
    """
    system = vc.System(vc.PendulumCapsule(1.518), vc.LuGre(), vc.Harmonic(amplitude=1.923))
    saddle = np.array([7.23702528e-01, 1.48398437, 0.0, 3.16506701e-01, 1.50010399e-03])
    recorded, count, scales = equations(system), 40, np.array(system.scales(), dtype=float)
    begun = saddle + 1e-4 * scales * np.random.default_rng(0).normal(size=(count, 5))
    values = recorded, np.tile(parameter_values(system), (count, 1)), begun
    once = numerics.ensemble_run(
        numerics.EnsembleStart(values[0], values[1][:1], saddle[None]), numerics.Budget(1, 1e-10, 99, 9999)
    )
    moved = (once.state[0] - saddle) / scales
    assert np.max(np.abs(np.delete(moved, 2))) < 1e-7  # it is one
    found = settled(values, True, periods=300)
    assert np.all(found.response_period == 2)
    with faulty(values, (CONVERGES, "if False:"), (UNSTABLE, "or False:"), (CHECK, "if True:")):
        fooled = settled(values, True, periods=300)
    assert np.mean(fooled.response_period == 1) > 0.5


def test_what_asks_for_the_transient_waits():
    """`time_to_settle` is the run's own; `extrapolated` says which runs were not waited for."""
    over = {"machine.mass_ratio": np.linspace(0.5, 4.0, 16)}
    asked = {"initial": START, "settle": THRESHOLD}
    results = vc.ensemble(EM, over, measures=["drift", "extrapolated"], **asked)
    assert np.sum(results["extrapolated"]) > 8
    timed = vc.ensemble(EM, over, measures=["drift", "extrapolated", "time_to_settle"], **asked)
    waited = vc.ensemble(EM, over, measures=["drift", "extrapolated"], extrapolate=False, **asked)
    assert np.all(timed["extrapolated"] == 0)
    for name in ("drift", "extrapolated", "window_start"):
        assert np.array_equal(timed[name], waited[name], equal_nan=True)
    with pytest.raises(ValueError, match="extrapolate should be True or False, got 'no'"):
        vc.ensemble(EM, over, extrapolate="no", **asked)  # pyright: ignore[reportArgumentType]
