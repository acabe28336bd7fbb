"""Calibration: known parameters from synthetic laboratories, what a table does not tell, wrong columns, bad tables."""

import json
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import scipy.stats

import vibrocap as vc
from cases import printed, printed_json, refused
from vibrocap.arguments import Complaints
from vibrocap.case.case import CaseError
from vibrocap.design.calibration.calibration import CalibratedParameter, Calibration
from vibrocap.design.calibration.table import read_table
from vibrocap.design.calibration.table_model import outlying
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
    results = vc.ensemble(bench.with_parameters(TRUTH), runs, periods=400, settle=1e-9, tolerance=1e-10)
    assert not np.any(results["status"])
    return results["mean_velocity"]


@pytest.fixture(scope="module")
def table(speeds) -> dict:
    noise = ERROR * np.random.default_rng(5).standard_normal(len(speeds))
    errors = np.full(len(speeds), ERROR)
    return {"drive.frequency": FREQUENCIES, "mean_velocity": speeds + noise, "mean_velocity_error": errors}


@pytest.mark.slow
def test_intervals_are_those_of_the_slopes(bench, table):
    """Least squares: covariance (J^T J)^-1 with slopes by runs of our own, Student's quantile for 10 spare values."""
    calibration = vc.calibrate(bench, table, WITHIN, starts=8)
    centre, columns = {parameter.path: parameter.value for parameter in calibration.parameters}, []
    for path, value in centre.items():
        ends = []
        for factor in (0.999, 1.001):
            parameters = bench.with_parameters(centre | {path: factor * value})
            runs = vc.ensemble(parameters, {"drive.frequency": FREQUENCIES}, periods=400, settle=1e-9, tolerance=1e-10)
            ends.append(runs["mean_velocity"])
        columns.append((ends[1] - ends[0]) / (0.002 * value) / ERROR)
    slopes = np.stack(columns, axis=1)
    covariance = np.linalg.inv(slopes.T @ slopes) * max(calibration.misfit, 1.0)
    deviation = np.sqrt(np.diag(covariance))
    for each, expected in zip(calibration.parameters, deviation, strict=True):
        assert each.standard_error == pytest.approx(expected, rel=0.01)
        assert each.high - each.low == pytest.approx(2.0 * 2.2281388520 * expected, rel=0.01)  # t, 10, 97.5 %
        assert TRUTH[each.path] in each
        assert each.verdict is Verdict.DETERMINED
    assert calibration.correlation[0, 1] == pytest.approx(covariance[0, 1] / np.prod(deviation), abs=0.02)
    assert calibration.facts["correlation"].startswith(f"{calibration.correlation[0, 1]:.3g} of")
    rms = ERROR * np.sqrt(np.mean(calibration.residuals["mean_velocity"] ** 2))
    assert calibration.rms["mean_velocity"] == pytest.approx(rms, rel=1e-9)


@pytest.mark.slow
def test_what_the_table_does_not_tell(bench, table):
    """A spring whose bounds are so near each other that the speeds hardly differ: any value between them agrees."""
    calibration = vc.calibrate(bench, table, {"machine.stiffness": (2.0, 2.0 + 1e-6)} | WITHIN, starts=8)
    spring = calibration["machine.stiffness"]
    assert (spring.verdict, spring.low, spring.high) == (Verdict.UNDETERMINED, 2.0, 2.0 + 1e-6)
    assert calibration["machine.damping"].verdict is Verdict.DETERMINED


@pytest.mark.slow
def test_rows_that_are_held_out_judge_the_fit(bench, table):
    out = [0, 5, 11]
    calibration = vc.calibrate(bench, table, WITHIN, held_out=out, starts=8)
    kept = {name: np.delete(column, out) for name, column in table.items()}
    alone = vc.calibrate(bench, kept, WITHIN, starts=8)
    assert [each.value for each in calibration.parameters] == [each.value for each in alone.parameters]
    misfit = np.mean(calibration.residuals["mean_velocity"][out] ** 2)
    assert calibration.held_out_misfit == pytest.approx(misfit, rel=1e-9)
    assert 0.0 < misfit < 6.0  # chi^2 of 3 over 3: 6 with a probability of 4e-4


@pytest.mark.slow
@pytest.mark.parametrize(
    ("column", "factor", "tolerance"), [("mean_velocity", -1.0, 0.05), ("drive.frequency", 0.5 / np.pi, 0.1)]
)
def test_wrong_column_is_named(bench, table, column, factor, tolerance):
    """Turned about, or in Hz: no damping and friction within the bounds explain it, the factor does."""
    calibration = vc.calibrate(bench, table | {column: factor * table[column]}, WITHIN, starts=8)
    assert (calibration.doubt.column, calibration.doubt.kind) == (column, "factor")
    assert calibration.doubt.size == pytest.approx(1.0 / factor, rel=tolerance)
    if factor < 0.0:
        assert calibration.doubt.gain > 0.9
        assert not any(parameter.verdict is Verdict.DETERMINED for parameter in calibration.parameters)


@pytest.mark.parametrize("row", [None, 0, 4, 9])
def test_rows_that_stand_out_are_those_that_a_fit_of_the_others_does_not_predict(row):
    """Each value of two columns is compared with a straight line through all the others, by Student's t."""
    generator, rows = np.random.default_rng(3), np.array([0, 1, 2, 4, 5, 6, 7, 9])
    slopes = np.column_stack([np.ones(16), np.tile(rows, 2) / 9.0])
    values = slopes @ [3.0, -2.0] + 0.1 * generator.standard_normal(16)
    if row is not None:
        values[8 + list(rows).index(row)] += 1.5
    residuals = values - slopes @ np.linalg.lstsq(slopes, values)[0]
    chances = []
    for k in range(16):
        others = np.delete(np.arange(16), k)
        line, (left,), *_ = np.linalg.lstsq(slopes[others], values[others])
        spread = 1.0 + slopes[k] @ np.linalg.inv(slopes[others].T @ slopes[others]) @ slopes[k]
        far = abs(values[k] - slopes[k] @ line) / np.sqrt(left / 13 * spread)
        chances.append(16 * 2 * scipy.stats.t.sf(far, 13))
    columns = {name: generator.standard_normal(10) for name in ("drift", "mean_velocity")}
    table = SimpleNamespace(targets=columns, errors=dict.fromkeys(columns, np.ones(10)), measures=tuple(columns))
    outliers = outlying(SimpleNamespace(table=table, rows=rows), residuals, slopes)
    assert outliers == tuple(rows[np.flatnonzero(np.array(chances) < 1e-3) % 8]) == (() if row is None else (row,))


@pytest.mark.slow
def test_an_outlier_is_named_and_determines_nothing(bench, table):
    wrong = {"drive.frequency": FREQUENCIES, "mean_velocity": table["mean_velocity"] + 0.05 * (np.arange(12) == 3)}
    calibration = vc.calibrate(bench, wrong, WITHIN, starts=8)
    assert calibration.rows_outlying == [4]
    assert calibration.facts["outlier"].startswith("row 4: ")
    assert not any(parameter.verdict is Verdict.DETERMINED for parameter in calibration.parameters)


@pytest.mark.slow
def test_verdicts_know_the_misfit(bench, table):
    """The same table with errors ten times too small: a misfit of a hundred is no noise, and widens the intervals."""
    calibration = vc.calibrate(bench, table | {"mean_velocity_error": np.full(12, 0.1 * ERROR)}, WITHIN, starts=8)
    assert calibration.misfit > 30.0
    for parameter in calibration.parameters:
        assert parameter.verdict is Verdict.DOUBTED
        assert TRUTH[parameter.path] in parameter


def test_the_command_names_rows_that_have_not_settled_and_the_cure(tmp_path, capsys):
    asked = ["calibrate", "examples/bench-in-si.toml", "--to", "examples/bench-in-si-speeds.csv", "--periods", "3"]
    asked += ["--over", "friction.coulomb_coefficient,friction.static_coefficient=factor:0.8:1.2", "--starts", "2"]
    assert "give more periods, or hold such rows out" in " ".join(printed(capsys, *asked, "--out", tmp_path).split())
    record = json.loads((tmp_path / "calibration.json").read_text(encoding="utf-8"))
    assert record["rows_not_trusted"] == {"not settled": list(range(1, 25))}
    (factor,) = record["parameters"]
    assert factor["verdict"] == "not determined: not all motions can be trusted"
    assert factor["low"] is factor["high"] is factor["standard_error"] is None
    assert record["directions"] == []


@pytest.mark.slow
def test_exact_table_gives_the_parameters_back(bench):
    """Both levels of friction 30 % higher, as one unknown; without noise, to what settling within 1e-7 leaves."""
    tied = "friction.coulomb_coefficient,friction.static_coefficient"
    truth = {"friction.coulomb_coefficient": 0.065, "friction.static_coefficient": 0.26, "machine.damping": 1.3}
    over = {"drive.frequency": FREQUENCIES}
    exact = vc.ensemble(bench.with_parameters(truth), over, periods=400, settle=1e-9, tolerance=1e-10)["mean_velocity"]
    table = over | {"mean_velocity": exact}
    calibration = vc.calibrate(bench, table, {tied: "factor:0.5:2", "machine.damping": (0.5, 3.0)}, starts=8)
    assert calibration[tied].value == pytest.approx(1.3, rel=1e-4)
    for path, value in truth.items():
        assert calibration.case().system.parameter(path) == pytest.approx(value, rel=1e-4)
    assert calibration.doubt is None


@pytest.mark.slow
def test_levels_of_friction_that_meet_are_trusted(bench):
    """No law has a static level below the Coulomb level: differences are taken on the side where it has one.

    A point that a part refuses is worse than any motion, however small the errors are.
    """
    block = bench.with_parameters({"friction.coulomb_coefficient": 0.07, "friction.static_coefficient": 0.07})
    runs = {"drive.frequency": FREQUENCIES}
    speeds = vc.ensemble(block, runs, periods=400, settle=1e-9, tolerance=1e-10)["mean_velocity"]
    table = runs | {"mean_velocity": speeds, "mean_velocity_error": np.full(12, 1e-6)}
    levels = {"friction.coulomb_coefficient": (0.02, 0.15), "friction.static_coefficient": (0.02, 0.3)}
    calibration = vc.calibrate(block, table, levels, starts=8)
    assert not calibration.not_trusted
    coulomb, static = calibration.parameters
    assert coulomb.value == pytest.approx(0.07, abs=1e-8)
    assert static.verdict is Verdict.BOUNDED_ABOVE
    assert static.low < 0.07 + 1e-6


@pytest.mark.slow
def test_intervals_end_where_a_part_refuses(bench, speeds):
    """Speeds with errors of a tenth say little of the static level; below the Coulomb level there is no such law."""
    table = {"drive.frequency": FREQUENCIES, "mean_velocity": speeds, "mean_velocity_error": np.full(12, 0.1)}
    within = {"friction.static_coefficient": (0.01, 0.6)}
    (static,) = vc.calibrate(bench.with_parameters(TRUTH), table, within, starts=8).parameters
    assert static.low == pytest.approx(TRUTH["friction.coulomb_coefficient"], rel=1e-6)
    assert static.verdict in (Verdict.BOUNDED_ABOVE, Verdict.UNDETERMINED)


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
        ({"drive.frequency": [*FREQUENCIES[:11], -1.0]}, r"greater than 0, got -1\.0 in row 12"),
        ({"friction.static_coefficient": [0.2, 0.01] * 6}, r"at least coulomb_coefficient .*, got 0\.01 in row 2"),
    ],
)
def test_bad_tables_are_named_before_any_work(bench, change, said):
    with pytest.raises(CaseError, match=said):
        vc.calibrate(bench, ANY_TABLE | change, WITHIN)


@pytest.mark.parametrize(
    "text",
    [
        "drive.period_ms;drive.amplitude_N_m;mean_velocity [mm/s]\n1000;0,7;-106,31\n800;0,7;-115,5\n800;0,7;-114,5\n",
        "# bench 2\ndrive.frequency_Hz,drive.amplitude [mN m],mean_velocity_m_per_s\n"
        "1.0,700,-0.10631\n1.25,700,-0.1155\n1.25,700,-0.1145\n",
        "drive.period\tdrive.amplitude\tmean_velocity\ns\tN m\tmm/s\n1\t0.7\t-106.31\n.8\t.7\t-115.5\n.8\t.7\t-114.5\n",
    ],
)
def test_tables_as_laboratories_write_them(tmp_path, text):
    """Periods in ms, other units in the heading or below it, semicolons, decimal commas; repeats tell the error."""
    (tmp_path / "table.csv").write_text(text, encoding="utf-8")
    complaints = Complaints()
    numbers = read_table(tmp_path / "table.csv", vc.read_case("examples/bench-in-si.toml").system, complaints)
    assert numbers is not None, complaints
    assert numbers.conditions["drive.frequency_Hz"] == pytest.approx([1.0, 1.25, 1.25], rel=1e-15)
    assert numbers.conditions["drive.amplitude_N_m"] == pytest.approx([0.7] * 3, rel=1e-15)
    assert numbers.targets["mean_velocity"] == pytest.approx([-0.10631, -0.1155, -0.1145], rel=1e-15)
    assert numbers.errors["mean_velocity"] == pytest.approx([1e-3 / np.sqrt(2.0)] * 3, rel=1e-9)
    assert numbers.scatter(np.arange(3)) == (pytest.approx(1.0, rel=1e-9), 1)
    assert numbers.alike.tolist() == [0, 1, 1]


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("drive.period [N],mean_velocity\n1,2\n2,3\n", "drive.period .N.: should be in s, got N"),
        ("drive.period,mean_velocity\n1,2\n2,3\n", "drive.period: should be positive, and in SI have its unit"),
        ("drive.frequency_Hz,drive.period_ms,mean_velocity\n1,2,3\n3,4,5\n", "drive.frequency_Hz once more"),
        ("drive.frequency_Hz,mean_velocity\n1,2\n2,a\n", "line 3, column 'mean_velocity': 'a' is no number"),
        ("1,2\n2,3\n", "line of headings"),
    ],
)
def test_files_that_are_no_such_table_are_named(tmp_path, text, said):
    (tmp_path / "table.csv").write_text(text, encoding="utf-8")
    with pytest.raises(CaseError, match=said):
        vc.calibrate(
            vc.read_case("examples/bench-in-si.toml"),
            tmp_path / "table.csv",
            {"friction.coulomb_coefficient": (0.02, 0.2)},
        )


@pytest.mark.parametrize(
    ("asked", "said"),
    [
        ({"over": {"machine.damping,machine.stiffness": (0.5, 2.0)}}, "share a factor of their own values"),
        (
            {"over": {"machine.damping": (1.0, 2.0), "machine.damping,machine.stiffness": "factor:0.5:2"}},
            "give it once",
        ),
        ({"over": {"machine.damping": "factor:-1:2"}}, "should be at least 0"),
        ({"over": {"drive.frequency,machine.damping": "factor:0.5:2"}}, "is a column of the table"),
        ({"over": {"friction.law": ["coulomb", "exponential"]}}, "friction.law"),
        ({"over": {}}, "over"),
        ({"held_out": [12]}, "held_out"),
        ({"held_out": range(10)}, "more than 2 measured values"),
    ],
)
def test_bad_questions_are_named_before_any_work(bench, asked, said):
    with pytest.raises(CaseError, match=said):
        vc.calibrate(bench, ANY_TABLE, **({"over": WITHIN} | asked))


def test_conditions_in_si_say_their_unit(capsys, tmp_path):
    text = Path("examples/bench-in-si-speeds.csv").read_text(encoding="utf-8")
    (tmp_path / "speeds.csv").write_text(text.replace("frequency_Hz", "frequency"), encoding="utf-8")
    asked = ["calibrate", "examples/bench-in-si.toml", "--to", tmp_path / "speeds.csv"]
    said = refused(capsys, *asked, "--over", "friction.coulomb_coefficient=0.02:0.2")
    assert "drive.frequency: has no unit in a case in SI; give drive.frequency_Hz" in " ".join(said.split())


def test_picture_of_rows_residuals_and_intervals(bench):
    """Of rows in errors of 0.001; an untrusted row has no prediction, and the interval of a value below 0 its ends."""
    predicted = np.where(np.arange(12) == 2, np.nan, np.linspace(0.099, 0.101, 12))
    parameters = (
        CalibratedParameter("machine.damping", 1.0, 0.9, 1.3, 0.1, Verdict.DETERMINED),
        CalibratedParameter("drive.second_amplitude", -2.0, -2.2, -1.2, 0.3, Verdict.WIDE),
    )
    calibration = Calibration(
        system=bench, parameters=parameters, correlation=np.eye(2), directions=(), initial={},
        measured=read_table(ANY_TABLE, bench, Complaints()), predicted={"mean_velocity": predicted},
        residuals={"mean_velocity": (0.1 - predicted) / ERROR}, misfit=4.0, held_out_misfit=2.0, rms={},
        held_out=(1,), doubt=None, outliers=(4,), not_trusted={"not settled": (2,)},
    )  # fmt: skip
    figure = vc.figure(calibration)
    rows, residuals, intervals = figure.axes
    drawn = {line.get_label(): line.get_xydata() for line in rows.get_lines()}
    assert drawn["predicted (held out)"].tolist() == [[2.0, predicted[1]]]
    assert drawn["fitted"][:, 0].tolist() == [1.0, *range(3, 13)]
    assert np.array_equal(drawn["measured"][:, 1], ANY_TABLE["mean_velocity"])
    held_out = residuals.get_lines()[-1].get_xydata()
    assert held_out[:, 1] == pytest.approx([(0.1 - predicted[1]) / ERROR])
    ends = [line.get_xdata() for line in intervals.get_lines() if len(line.get_xdata()) == 2][:2]
    assert np.concatenate(ends) == pytest.approx([-10.0, 30.0, -10.0, 40.0])
    assert vc.plot(calibration).get_ylabel() == "mean velocity"
    texts = (text.get_text() for part in (figure, *figure.subfigs) for text in part.texts)
    assert any("Row 5 is an outlier." in " ".join(text.split()) for text in texts)


@pytest.mark.slow
def test_command_writes_a_case_in_si(tmp_path, capsys):
    """The example's truth: 0.0575 and 0.095 N m s/rad."""
    asked = ["calibrate", "examples/bench-in-si.toml", "--to", "examples/bench-in-si-speeds.csv", "--starts", "8"]
    asked += ["--over", "friction.coulomb_coefficient=0.02:0.2", "--over", "machine.damping_N_m_s_per_rad=0.02:0.3"]
    record = printed_json(capsys, *asked, "--out", tmp_path, "--plot", tmp_path / "a.svg")
    assert "mean velocity [m/s]" in (tmp_path / "a.svg").read_text(encoding="utf-8").replace("\N{NO-BREAK SPACE}", " ")
    assert record["rows_not_trusted"] == {}
    assert 0.0 < record["rms"]["mean_velocity"]["value"] < 0.01
    friction, damping = record["parameters"]
    assert friction["low"] < 0.0575 < friction["high"]
    assert {damping[end]["unit"] for end in ("low", "value", "high")} == {"N m s/rad"}
    assert damping["low"]["value"] < 0.095 < damping["high"]["value"]
    calibrated = vc.read_case(tmp_path / "calibrated.toml").system
    for row, value in ((friction, friction["value"]), (damping, damping["value"]["value"])):
        assert calibrated.parameter(row["path"]) == pytest.approx(value, rel=1e-12)
    rows = (tmp_path / "residuals.csv").read_text(encoding="utf-8").splitlines()
    assert len(rows) == 25
    measured, predicted, residual = map(float, rows[1].split(",")[2:])
    assert residual == pytest.approx((measured - predicted) / 0.00259, rel=1e-9)
