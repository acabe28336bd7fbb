"""Adaptive maps, on labels that are known in closed form: what they find, what they cost, what they cannot see."""

import importlib
import inspect

import numpy as np
import pytest

import vibrocap as vc
from vibrocap.case.case import case_from_text
from vibrocap.measures.ensemble import ensemble
from vibrocap.motion.trust import ZERO
from vibrocap.studies import adaptive
from vibrocap.studies.adaptive import adaptive_map, border

BRIDGE = importlib.import_module("vibrocap.measures.ensemble")  # whose name in the package is the function's
SIDE = 385  # 12 coarse cells of 32 steps
ROUNDING = 4e-15  # a handful of roundings of numbers of the order of one


class Evaluator:
    """Runs points by label functions of the two axes; remembers its calls."""

    def __init__(self, **functions):
        self.functions = functions
        self.calls = []

    def __call__(self, x, y):
        self.calls.append((x.copy(), y.copy()))
        return {name: function(x, y) for name, function in self.functions.items()}

    def on_full_grid(self, dataset, name):
        x, y = (dataset[path].values for path in dataset["computed"].dims)
        return self.functions[name](*np.meshgrid(x, y, indexing="ij"))


def words(inside):
    return lambda x, y: np.where(inside(x, y), "FSBS", "FB")


def circle(x, y):
    return (x - 0.51) ** 2 + (y - 0.47) ** 2 < 0.3**2


def unit_square(points=SIDE, other=None):
    return {"a": (0.0, 1.0, points), "b": (0.0, 1.0, other or points)}


def mapped(evaluate, over=None, by=("mode_sequence",), **settings):
    return adaptive_map(None, over or unit_square(), by, evaluate=evaluate, **settings)


def assert_is_full_map(dataset, evaluate, name="mode_sequence"):
    """The label everywhere, and every edge of its border, as if the full grid had been run."""
    expected = evaluate.on_full_grid(dataset, name)
    assert np.array_equal(dataset[name].values, expected)
    full = dataset.assign({name: (dataset["computed"].dims, expected)})
    assert np.array_equal(border(dataset, name).points, border(full, name).points)
    assert border(dataset, name).computed.all()


def test_circle_is_sharp_at_a_tenth_of_the_runs():
    evaluate = Evaluator(mode_sequence=words(circle))
    dataset = mapped(evaluate, coarse=32)
    assert_is_full_map(dataset, evaluate)
    assert 13**2 < dataset["computed"].sum() < 0.1 * SIDE**2
    assert dataset.attrs["runs_computed"] == dataset["computed"].sum() == sum(len(x) for x, _ in evaluate.calls)
    assert dataset.attrs["runs_of_full_grid"] == SIDE**2
    assert dataset.attrs["share_computed"] == pytest.approx(dataset.attrs["runs_computed"] / SIDE**2, rel=1e-15)
    assert dataset["a"].attrs["coarse_steps"] == 32
    assert dataset["a"].attrs["coarse_spacing"] == pytest.approx(1 / 12, rel=1e-12)


def test_border_lines_have_the_length_of_a_circle():
    """Edges crossed along one axis: twice the diameter over the spacing, to the two edges that its ends may miss."""
    dataset = mapped(Evaluator(mode_sequence=words(circle)))
    found = border(dataset, "mode_sequence")
    lengths = np.abs(found.segments[:, 1] - found.segments[:, 0])
    upright = lengths[:, 0] == 0.0
    assert upright.sum() == pytest.approx(2 * 0.6 * (SIDE - 1), abs=2)
    assert (~upright).sum() == pytest.approx(2 * 0.6 * (SIDE - 1), abs=2)
    assert lengths.max(axis=1) == pytest.approx(1 / (SIDE - 1), rel=1e-9)
    assert found.segments.mean(axis=1) == pytest.approx(found.points, abs=1e-15)
    distance = np.hypot(found.points[:, 0] - 0.51, found.points[:, 1] - 0.47) - 0.3
    assert np.abs(distance).max() < 0.5 / (SIDE - 1)  # an end of the crossed edge is on either side


@pytest.mark.parametrize(("shape", "coarse"), [((31, 250), (5, 12)), ((3, 40), 16), ((2, 2), 1)])
def test_stripes_on_grids_of_any_size(shape, coarse):
    """Oblique stripes of four labels, each wider than a coarse cell's diagonal wherever it is cut."""
    evaluate = Evaluator(response_period=lambda x, y: np.floor(3.3 * (x + 0.21 * y)).astype(np.int16))
    dataset = mapped(evaluate, unit_square(*shape), ("response_period",), coarse=coarse)
    assert_is_full_map(dataset, evaluate, "response_period")


def test_tongue_is_followed_to_the_width_of_one_step():
    """From a broad root at the left a tongue winds through the map, 1.5 steps wide and far from coarse points."""

    def tongue(x, y):
        half = np.maximum(0.15 - x, 0.75 / (SIDE - 1))
        return np.abs(y - 0.45 - 0.03 * np.sin(9 * x)) < half

    evaluate = Evaluator(mode_sequence=words(tongue))
    dataset = mapped(evaluate, coarse=32, margin=0)
    assert_is_full_map(dataset, evaluate)
    root_only = Evaluator(mode_sequence=words(lambda x, y: tongue(x, y) & (x < 0.15)))
    assert dataset["computed"].sum() > mapped(root_only, coarse=32, margin=0)["computed"].sum() + 2 * SIDE


def test_each_point_is_run_once_and_keeps_its_value():
    functions = {"mode_sequence": words(circle), "mean_velocity": lambda x, y: np.sin(40 * x) * np.exp(y)}
    evaluate = Evaluator(**functions)
    values = []
    dataset = mapped(evaluate, progress=lambda done, wanted: values.append((done, wanted)))
    x, y = (np.concatenate(parts) for parts in zip(*evaluate.calls, strict=True))
    assert len(np.unique(np.stack((x, y)), axis=1).T) == len(x) == dataset["computed"].sum()
    ran = dataset["computed"].values
    for name in functions:
        assert np.array_equal(dataset[name].values[ran], evaluate.on_full_grid(dataset, name)[ran])
    assert len(evaluate.calls) == dataset.attrs["rounds"] == len(values)  # one call for each round
    assert values == [(done, done) for done in np.cumsum([len(x) for x, _ in evaluate.calls])]


def test_order_and_tiles_change_nothing():
    functions = {"mode_sequence": words(circle), "mean_velocity": lambda x, y: np.sin(9 * x) * np.exp(y) + x * y}
    over = {"a": (0.0, 1.0, 150), "b": (0.0, 1.0, 101)}
    whole = mapped(Evaluator(**functions), over)
    tiled = Evaluator(**functions)
    assert mapped(tiled, over, tile=7).identical(whole)
    assert max(len(x) for x, _ in tiled.calls) == 7
    turned = Evaluator(**{name: lambda y, x, f=f: f(x, y) for name, f in functions.items()})
    assert mapped(turned, dict(reversed(over.items()))).transpose("a", "b").identical(whole)
    renamed = Evaluator(**functions | {"mode_sequence": lambda x, y: np.where(circle(x, y), "A", "ZZZZZ")})
    assert np.array_equal(mapped(renamed, over)["computed"], whole["computed"])


def test_margin_sees_an_island_beside_a_border():
    """In the next coarse column, with no coarse point in it; without a margin it is missed, as the limits state."""

    def shapes(x, y):
        return (x < 0.26) | (np.hypot(x - 10 / 24, y - 11 / 24) < 0.03)

    evaluate = Evaluator(mode_sequence=words(shapes))
    assert_is_full_map(mapped(evaluate, coarse=32, margin=1), evaluate)
    blind = mapped(evaluate, coarse=32, margin=0)
    assert (blind["mode_sequence"].values != evaluate.on_full_grid(blind, "mode_sequence")).any()


def test_what_is_counted_is_filled_from_the_nearest_corner():
    """Of a cell of 4 x 2 steps whose four corners were run; in the middle from the lower one."""
    computed = np.zeros((5, 3), dtype=bool)
    computed[np.ix_([0, 4], [0, 2])] = True
    order, missing = np.flatnonzero(computed), int(np.sum(~computed))
    corners = np.repeat([[0], [4], [0], [2]], missing, axis=1)
    axes = np.linspace(1.0, 2.0, 5), np.linspace(0.0, 1.0, 3)
    full = adaptive.filled(np.array([1.0, 2.0, 3.0, 4.0]), order, computed, corners, axes)
    assert full.tolist() == 3 * [[1.0, 1.0, 2.0]] + 2 * [[3.0, 3.0, 4.0]]


def test_fillings_are_bilinear_and_log_axes_are_filled_in_their_logarithm():
    """a + b x + c y + d x y is what bilinear interpolation reproduces."""

    def velocity(x, y):
        return 0.3 + 0.2 * np.log(x) - 0.5 * y + 0.7 * np.log(x) * y

    evaluate = Evaluator(mode_sequence=words(lambda x, y: y > np.log(x)), mean_velocity=velocity)
    over = {"a": "log:1:10:120", "b": np.linspace(0, 1, 90) ** 2}
    dataset = mapped(evaluate, over)
    assert 0 < dataset["computed"].mean() < 0.5
    error = np.abs(dataset["mean_velocity"].values - evaluate.on_full_grid(dataset, "mean_velocity"))
    assert error.max() < ROUNDING
    assert_is_full_map(dataset, evaluate)
    middles = np.unique(border(dataset, "mode_sequence").points[:, 0])
    values = dataset["a"].values
    geometric = np.sqrt(values[1:] * values[:-1])
    assert np.abs(np.concatenate((values, geometric))[:, None] - middles).min(axis=0).max() < 10 * ROUNDING


def test_zero_travel_lies_apart_from_small_travel():
    """Failed runs are apart from both: their status is a label, their measures stay NaN, nothing fills them."""

    def velocity(x, y):
        travel = 0.1 * np.sign(y - 0.5) * np.maximum(abs(y - 0.5) - 0.1, 0)
        return np.where((x > 0.8) & (y > 0.8), np.nan, travel)

    evaluate = Evaluator(
        mean_velocity=velocity, status=lambda x, y: np.where(np.isnan(velocity(x, y)), 2, 0).astype(np.int8)
    )
    dataset = mapped(evaluate, unit_square(130), ("travel",), dead_band=1e-3)
    bad = evaluate.on_full_grid(dataset, "status") == 2
    y = dataset["b"].values
    expected = np.where(np.abs(y - 0.5) <= 0.11, 0, np.sign(y - 0.5))
    assert np.array_equal(dataset["travel"].values, np.where(bad, -128, expected))
    assert np.array_equal(dataset["status"].values == 2, bad)
    assert np.array_equal(np.isnan(dataset["mean_velocity"].values), bad)
    assert dataset.attrs["labels"] == "travel status"


def test_unsettled_runs_can_be_left_alone():
    """Words are noise where nothing settles: left alone, the edge of that stays sharp and its inside costs little."""
    evaluate = Evaluator(
        mode_sequence=lambda x, y: np.where(circle(x, y), np.where(np.sin(1e5 * (x + 3 * y)) > 0, "FB", "FSB"), "F"),
        response_period=lambda x, y: np.where(circle(x, y), 0, 1),
    )
    by = ("mode_sequence", "response_period")
    all_runs, few = mapped(evaluate, by=by), mapped(evaluate, by=by, refine_unsettled=False)
    assert_is_full_map(few, evaluate, "response_period")
    assert_is_full_map(all_runs, evaluate)
    assert few.attrs["share_computed"] < 0.1
    assert all_runs.attrs["share_computed"] > np.pi * 0.3**2


def test_discrete_values_are_copied_not_averaged():
    """Whole numbers in floats, NaN among them, are labels too; other counts come from the nearest corner."""
    evaluate = Evaluator(
        symmetric=lambda x, y: np.where(circle(x, y), 1.0, np.where(x < 0.1, np.nan, 0.0)),
        window_start=lambda x, y: np.rint(50 * x).astype(np.int32),
    )
    dataset = mapped(evaluate, unit_square(129), ("symmetric",))
    expected = evaluate.on_full_grid(dataset, "symmetric")
    assert np.array_equal(dataset["symmetric"].values, expected, equal_nan=True)
    numbered = Evaluator(symmetric=lambda x, y: np.nan_to_num(evaluate.functions["symmetric"](x, y), nan=2.0))
    assert np.array_equal(mapped(numbered, unit_square(129), ("symmetric",))["computed"], dataset["computed"])
    away = np.abs(dataset["window_start"].values - evaluate.on_full_grid(dataset, "window_start"))
    assert 0 < away.max() <= 50 * 8 / 128 + 1  # half a coarse cell, and a rounding at either end


@pytest.mark.parametrize(
    ("margin", "runs"),
    [
        # coarse; then columns x rows of the cells halved, less those that were there
        (0, 5 * 5 + (3 * 9 - 2 * 5) + (3 * 17 - 2 * 9) + (3 * 33 - 2 * 17) + (3 * 65 - 2 * 33)),
        (1, 5 * 5 + (7 * 9 - 4 * 5) + (7 * 17 - 4 * 9) + (7 * 33 - 4 * 17) + (3 * 65 - 2 * 33)),
    ],
)
def test_runs_along_a_straight_border(margin, runs):
    """A border between columns 24 and 25 of 65: each level halves the cells that it crosses and those beside them."""
    evaluate = Evaluator(mode_sequence=words(lambda x, y: x < 24.5 / 64))
    assert mapped(evaluate, unit_square(65), margin=margin).attrs["runs_computed"] == runs


def test_what_is_filled_in_beside_infinite_values_is_that_of_the_nearest_corner():
    """A cost is infinite where nothing travels, which need not be a label: 0 times that was no number."""
    evaluate = Evaluator(
        kind=lambda x, y: np.zeros(len(x), dtype=int), cost=lambda x, y: np.where(x < 0.3, np.inf, 1.0 + x)
    )
    dataset = mapped(evaluate, unit_square(17), ("kind",), coarse=8)
    expected = np.where(np.arange(17) <= 4, np.inf, np.where(np.arange(17) < 8, 1.5, 1.0 + np.arange(17) / 16))
    assert np.array_equal(dataset["cost"].values, np.repeat(expected[:, None], 17, axis=1))


SYSTEM = vc.System(vc.PendulumCapsule(), vc.Exponential(), vc.Harmonic())
GOOD = Evaluator(mode_sequence=words(circle), mean_velocity=lambda x, y: x - 0.3)


def signed_like_the_ensemble(function):
    """The function, with the signature of the ensemble, whose defaults are the map's."""
    function.__signature__ = inspect.signature(ensemble)
    return function


def test_no_travel_is_judged_by_the_residue_of_each_run(monkeypatch):
    """Which is more than this travel at high frequencies."""

    def crawling(system, over, **settings):
        velocity = np.full(len(over["drive.frequency"]), 3e-4)
        return {"status": velocity.astype(np.int8), "settled": velocity > 0.0, "mean_velocity": velocity}

    monkeypatch.setattr(BRIDGE, "ensemble", signed_like_the_ensemble(crawling))
    over = {"drive.frequency": (0.5, 4.0, 9), "initial.angle": (0.0, 1.0, 9)}
    travel = adaptive_map(SYSTEM, over, ("travel",), tolerance=1e-7)["travel"]
    assert np.array_equal(travel[:, 0] == 1, 1e-3 * travel["drive.frequency"] < 3e-4 * 2.0 * np.pi)


def test_points_go_to_the_ensemble(monkeypatch):
    """System, axes, labels and settings reach it; the dataset says how it was made and what its variables mean."""
    calls = []

    def runs(system, over, *, measures, **settings):
        calls.append((system, measures, settings))
        x, y = over["machine.mass_ratio"], over["initial.angle"]
        counts = {name: np.ones(len(x), dtype=np.int32) for name in ("window_start", "window_periods")}
        periods = {"response_period": np.where(circle(x, y), 2, 1).astype(np.int16), "settled": np.ones(len(x), bool)}
        return {"status": np.zeros(len(x), np.int8), **periods, **counts, "mean_velocity": y - 0.5, "drift": x}

    monkeypatch.setattr(BRIDGE, "ensemble", signed_like_the_ensemble(runs))
    over = {"machine.mass_ratio": (0.1, 1.0, 65), "initial.angle": (0.0, 1.0, 65)}
    by, asked = ("travel", "response_period"), {"initial": {"velocity": 0.2}, "tolerance": 1e-7, "threads": 1}
    dataset = adaptive_map(SYSTEM, over, by, measures=("drift",), **asked)
    system, measures, settings = calls[0]
    assert system is SYSTEM
    assert measures == ("drift", "mean_velocity", "hidden_lift_off")
    assert settings["settle"] == pytest.approx(1e-4, rel=1e-12)
    assert settings | asked == settings
    assert "dead_band" not in dataset.attrs  # the residue of each run
    assert dataset["machine.mass_ratio"].attrs["long_name"]
    assert dataset["initial.angle"].attrs["coarse_steps"] == 16
    assert dataset["drift"].attrs["units"] == "1"
    case = case_from_text(dataset.attrs["case"])
    assert (case.system, case.initial, case.tolerance) == (SYSTEM, {"velocity": 0.2}, 1e-7)
    assert adaptive_map(SYSTEM, over, by, settle=0).attrs["dead_band"] == ZERO
    assert calls[-1][2]["settle"] is None
    calls.clear()
    for change, message in (
        ({"measures": ["drfit"]}, "no measure 'drfit'; did you mean 'drift'"),
        ({"by": ["wrod"]}, "no measure 'wrod'"),
        ({"period": 4}, "period: there is no such setting; did you mean 'periods'"),
        ({"periods": -4}, "periods should be a positive number"),
        ({"initial": {"angel": 1.0}}, "initial.angel: no such state"),
    ):
        with pytest.raises(ValueError, match=message):
            adaptive_map(SYSTEM, over, **{"by": by} | change)
    assert not calls


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"over": {"a": (0, 1, 9)}}, "over should name two"),
        ({"over": {"a": (0, 1, 9), "b": (1, 0, 9)}}, "b: .*reversed"),
        ({"over": {"a": (0, 1, 9), "b": [0.0, np.nan]}}, "b: .*finite"),
        ({"over": {"a": (0, 1, 9), "b": [0.0, 2.0, 1.0]}}, "b: .*each above the one before"),
        ({"over": {"a": (0, 1, 9), "b": [0.0]}}, "b: .*two or more"),
        ({"over": {"a": (0, 1, 9), "b": "log:0:1:9"}}, "b: .*above 0"),
        ({"system": SYSTEM}, "a: there is no such quantity"),
        (
            {"system": SYSTEM, "over": {"machine.mass_ratio": [-1.0, 1.0], "drive.amplitude": [1.0, 2.0]}},
            "mass_ratio: ",
        ),
        ({"evaluate": None}, "system should be a System"),
        ({"by": "mode_sequence"}, "by should be a list"),
        ({"by": ()}, "by should be a list"),
        ({"coarse": 0}, "coarse should be a whole number >= 1, got 0"),
        ({"coarse": (4, 2.5)}, "coarse should be a whole number >= 1, got 2.5"),
        ({"margin": -1}, "margin should be"),
        ({"tile": 0}, "tile should be"),
        ({"dead_band": -1e-3}, "dead_band should be"),
        ({"dead_band": float("nan")}, "dead_band should be"),
        ({"refine_unsettled": False}, "by should hold 'response_period'"),
        ({"periods": 40}, "periods: settings of the ensemble"),
    ],
)
def test_bad_input_is_refused_before_any_work(change, message):
    arguments = {"system": None, "over": unit_square(9), "by": ("mode_sequence",), "evaluate": GOOD} | change
    GOOD.calls.clear()
    with pytest.raises(ValueError, match=message):
        adaptive_map(**arguments)
    assert not GOOD.calls


@pytest.mark.parametrize(
    ("functions", "by", "message"),
    [
        ({"mode_sequence": lambda x, y: np.array("F")}, "mode_sequence", r"one value per run, shape \(4,\), got \(\)"),
        (GOOD.functions, "response_period", "response_period should be among"),
        (GOOD.functions, "mean_velocity", "mean_velocity takes real values"),
    ],
)
def test_evaluator_that_returns_something_else(functions, by, message):
    with pytest.raises(ValueError, match=message):
        mapped(Evaluator(**functions), unit_square(9), (by,))


def test_borders_of_what_has_none():
    dataset = mapped(GOOD, unit_square(9))
    with pytest.raises(ValueError, match="mean_velocity takes real values"):
        border(dataset, "mean_velocity")
    with pytest.raises(ValueError, match=r"no variable 'wrod'; it has mode_sequence, mean_velocity, computed"):
        border(dataset, "wrod")
