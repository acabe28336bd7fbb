"""Calibration: known parameters from synthetic laboratories, what a table does not tell, wrong columns, bad tables."""

import json

import numpy as np
import pytest

import vibrocap as vc
from benchmarks.laboratories import UNKNOWN, known_system, laboratory
from thinned import exhaustive_but
from vibrocap.case.case import CaseError
from vibrocap.cli.main import main
from vibrocap.design.calibration.calibration import calibrate
from vibrocap.identification.inference.identifiability import Verdict

FREQUENCIES = np.linspace(0.6, 1.6, 12)
TRUTH = {"machine.damping": 1.3, "friction.coulomb_coefficient": 0.07}
WITHIN = {"machine.damping": (0.5, 3.0), "friction.coulomb_coefficient": (0.02, 0.15)}
ERROR = 1e-3
ANY_TABLE = {
    "drive.frequency": FREQUENCIES,
    "mean_velocity": np.full(12, 0.1),
    "mean_velocity_error": np.full(12, ERROR),
}


@pytest.fixture(scope="module")
def bench() -> vc.System:
    machine = vc.PendulumCapsule(mass_ratio=2.5, stiffness=2.0, normal_load="dynamic")
    return vc.System(machine, vc.Exponential(0.05, 0.2), vc.Biharmonic(amplitude=1.2, second_amplitude=0.4))


@pytest.fixture(scope="module")
def speeds(bench) -> np.ndarray:
    runs = {"drive.frequency": FREQUENCIES}
    found = vc.ensemble(bench.with_parameters(TRUTH), runs, periods=400, settle=1e-9, tolerance=1e-10)
    assert not np.any(found["status"])
    return found["mean_velocity"]


@pytest.fixture(scope="module")
def table(speeds) -> dict:
    noise = ERROR * np.random.default_rng(5).standard_normal(len(speeds))
    errors = np.full(len(speeds), ERROR)
    return {"drive.frequency": FREQUENCIES, "mean_velocity": speeds + noise, "mean_velocity_error": errors}


@pytest.mark.slow
def test_exact_table_gives_the_parameters_back(bench, speeds):
    """Without noise: to what runs that settle within 1e-7 leave."""
    exact = {"drive.frequency": FREQUENCIES, "mean_velocity": speeds}
    found = vc.calibrate(bench, exact, WITHIN, starts=64)
    for path, value in TRUTH.items():
        assert found[path].value == pytest.approx(value, rel=1e-4)
    assert found.case().system.parameter("machine.damping") == found["machine.damping"].value
    assert found.doubt is None


@pytest.mark.slow
def test_intervals_are_those_of_the_slopes(bench, table):
    """Least squares: covariance (J^T J)^-1 with slopes by runs of our own, Student's quantile for 10 spare values."""
    found = vc.calibrate(bench, table, WITHIN, starts=64)
    centre, columns = {each.path: each.value for each in found.parameters}, []
    for path, value in centre.items():
        ends = []
        for factor in (0.999, 1.001):
            given = bench.with_parameters(centre | {path: factor * value})
            runs = vc.ensemble(given, {"drive.frequency": FREQUENCIES}, periods=400, settle=1e-9, tolerance=1e-10)
            ends.append(runs["mean_velocity"])
        columns.append((ends[1] - ends[0]) / (0.002 * value) / ERROR)
    slopes = np.stack(columns, axis=1)
    covariance = np.linalg.inv(slopes.T @ slopes) * max(found.misfit, 1.0)
    deviation = np.sqrt(np.diag(covariance))
    for each, expected in zip(found.parameters, deviation, strict=True):
        assert each.standard_error == pytest.approx(expected, rel=0.01)
        assert each.high - each.low == pytest.approx(2.0 * 2.2281388520 * expected, rel=0.01)  # t, 10, 97.5 %
        assert TRUTH[each.path] in each
        assert each.verdict is Verdict.DETERMINED
    assert found.correlation[0, 1] == pytest.approx(covariance[0, 1] / np.prod(deviation), abs=0.02)


@pytest.mark.slow
def test_what_the_table_does_not_tell(bench, table):
    """A spring whose bounds are so near each other that the speeds hardly differ: any value between them agrees."""
    found = vc.calibrate(bench, table, {"machine.stiffness": (2.0, 2.0 + 1e-6)} | WITHIN, starts=64)
    spring = found["machine.stiffness"]
    assert spring.verdict is Verdict.UNDETERMINED
    assert (spring.low, spring.high) == (2.0, 2.0 + 1e-6)
    assert found["machine.damping"].verdict is Verdict.DETERMINED


@pytest.mark.slow
def test_rows_that_are_held_out_judge_the_fit(bench, table):
    found = vc.calibrate(bench, table, WITHIN, held_out=[0, 5, 11], starts=64)
    kept = {name: np.delete(column, [0, 5, 11]) for name, column in table.items()}
    alone = vc.calibrate(bench, kept, WITHIN, starts=64)
    assert [each.value for each in found.parameters] == [each.value for each in alone.parameters]
    assert found.held_out_misfit == pytest.approx(np.mean(found.residuals["mean_velocity"][[0, 5, 11]] ** 2), rel=1e-9)
    assert 0.0 < found.held_out_misfit < 6.0  # chi^2 of 3 over 3: 6 with a probability of 4e-4


@pytest.mark.slow
def test_wrong_column_is_named(bench, table):
    """Speeds read in another unit: no damping and friction within the bounds explain them, the factor does."""
    wrong = table | {name: 1.7 * table[name] for name in ("mean_velocity", "mean_velocity_error")}
    found = vc.calibrate(bench, wrong, WITHIN, starts=64)
    assert found.doubt is not None
    assert (found.doubt.column, found.doubt.kind) == ("mean_velocity", "factor")
    assert found.doubt.size == pytest.approx(1.0 / 1.7, rel=0.1)


@pytest.mark.slow
@pytest.mark.parametrize("seed", exhaustive_but([0], [1, 9]))
def test_synthetic_laboratories(seed):
    """The others are a benchmark of 100 (`benchmarks/laboratories.py`)."""
    table, truth, wrong = laboratory(seed)
    found = vc.calibrate(known_system(), table, UNKNOWN)
    if wrong is None:
        assert found.doubt is None
        held = [truth[each.path] in each for each in found.parameters]
        assert sum(held) >= 4  # of five at 95 %: fewer with a probability of 2 %
    else:
        assert found.doubt is not None
        assert found.doubt.column == wrong


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"mean_velocity": ["a"] * 12}, "mean_velocity: should be finite numbers, got 'a' in row 1"),
        ({"speed": [0.1] * 12}, "speed: is no parameter and no measure"),
        ({"drive.frequenzy": [1.0] * 12}, "drive.frequency"),
        ({"drift_error": [1.0] * 12}, "drift_error: has no column drift"),
        ({"mean_velocity_error": [0.0] * 12}, "positive standard errors"),
        ({"mean_velocity": [0.1] * 11}, "columns of one length"),
        ({"machine.damping": [1.0] * 12}, "machine.damping: is a column of the table"),
    ],
)
def test_bad_tables_are_named_before_any_work(bench, change, said):
    with pytest.raises(CaseError, match=said):
        vc.calibrate(bench, ANY_TABLE | change, WITHIN)


@pytest.mark.parametrize(
    ("asked", "said"),
    [
        ({"over": {"friction.law": ["coulomb", "exponential"]}}, "friction.law"),
        ({"over": {}}, "over"),
        ({"held_out": [12]}, "held_out"),
        ({"held_out": range(10)}, "more than 2 measured values"),
    ],
)
def test_bad_questions_are_named_before_any_work(bench, asked, said):
    with pytest.raises(CaseError, match=said):
        vc.calibrate(bench, ANY_TABLE, **({"over": WITHIN} | asked))


@pytest.mark.slow
def test_command_writes_a_case_in_si(tmp_path, capsys):
    """The example's truth: 0.0575 and 0.095 N m s/rad."""
    asked = ["calibrate", "examples/bench-in-si.toml", "--to", "examples/bench-in-si-speeds.csv"]
    asked += ["--over", "friction.coulomb_coefficient=0.02:0.2", "--over", "machine.damping_N_m_s_per_rad=0.02:0.3"]
    asked += ["--starts", "32", "--json", "--out", str(tmp_path)]
    assert main(asked) == 0
    found = {each["path"]: each for each in json.loads(capsys.readouterr().out)["parameters"]}
    for path, truth in (("friction.coulomb_coefficient", 0.0575), ("machine.damping_N_m_s_per_rad", 0.095)):
        assert found[path]["low"] < truth < found[path]["high"]
        case = vc.read_case(tmp_path / "calibrated.toml")
        assert case.system.parameter(path) == pytest.approx(found[path]["value"], rel=1e-12)
    rows = (tmp_path / "residuals.csv").read_text(encoding="utf-8").splitlines()
    assert len(rows) == 25
    measured, predicted, residual = map(float, rows[1].split(",")[2:])
    assert residual == pytest.approx((measured - predicted) / 0.00259, rel=1e-9)
    assert main([*asked[:2], "--to", "nothing.csv", *asked[4:]]) == 2
    assert "--to" in capsys.readouterr().err


@pytest.mark.slow
def test_calibration_at_the_public_function_is_in_si_once():
    """What the public function answers of a case in SI is what the room computes, to the last bit, and explains it."""
    given = vc.read_case("examples/bench-in-si.toml")
    over = {"friction.coulomb_coefficient": "0.02:0.2", "machine.damping_N_m_s_per_rad": "0.02:0.3"}
    asked = {"starts": 64, "seed": 1}
    public = vc.calibrate(given, "examples/bench-in-si-speeds.csv", over, **asked)
    room = calibrate(given, "examples/bench-in-si-speeds.csv", over, **asked)
    assert [(each.path, each.value, each.low, each.high) for each in public.parameters] == [
        (each.path, each.value, each.low, each.high) for each in room.parameters
    ]
    for name in public.table.measures:
        assert np.array_equal(public.predicted[name], room.predicted[name])
        assert public.predicted[name] == pytest.approx(public.table.targets[name], rel=0.3, abs=0.01)
    damping = public.parameters[1].value
    assert public.case().system.parameter("machine.damping_N_m_s_per_rad") == pytest.approx(damping, rel=1e-12)
