"""Calibration: known parameters from synthetic laboratories, what a table does not tell, wrong columns, bad tables."""

import json
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import scipy.stats

import vibrocap as vc
from benchmarks.laboratories import UNKNOWN, known_system, laboratory
from cases import printed, refused
from thinned import exhaustive_but
from vibrocap.arguments import Complaints
from vibrocap.case.case import CaseError
from vibrocap.cli.main import main
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
def test_exact_table_gives_the_parameters_back(bench, speeds):
    """Without noise: to what runs that settle within 1e-7 leave."""
    exact = {"drive.frequency": FREQUENCIES, "mean_velocity": speeds}
    calibration = vc.calibrate(bench, exact, WITHIN, starts=16)
    for path, value in TRUTH.items():
        assert calibration[path].value == pytest.approx(value, rel=1e-4)
    assert calibration.case().system.parameter("machine.damping") == calibration["machine.damping"].value
    assert calibration.doubt is None


@pytest.mark.slow
def test_intervals_are_those_of_the_slopes(bench, table):
    """Least squares: covariance (J^T J)^-1 with slopes by runs of our own, Student's quantile for 10 spare values."""
    calibration = vc.calibrate(bench, table, WITHIN, starts=16)
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
    calibration = vc.calibrate(bench, table, {"machine.stiffness": (2.0, 2.0 + 1e-6)} | WITHIN, starts=16)
    spring = calibration["machine.stiffness"]
    assert spring.verdict is Verdict.UNDETERMINED
    assert (spring.low, spring.high) == (2.0, 2.0 + 1e-6)
    assert calibration["machine.damping"].verdict is Verdict.DETERMINED


@pytest.mark.slow
def test_rows_that_are_held_out_judge_the_fit(bench, table):
    calibration = vc.calibrate(bench, table, WITHIN, held_out=[0, 5, 11], starts=16)
    kept = {name: np.delete(column, [0, 5, 11]) for name, column in table.items()}
    alone = vc.calibrate(bench, kept, WITHIN, starts=16)
    assert [parameter.value for parameter in calibration.parameters] == [
        parameter.value for parameter in alone.parameters
    ]
    assert calibration.held_out_misfit == pytest.approx(
        np.mean(calibration.residuals["mean_velocity"][[0, 5, 11]] ** 2), rel=1e-9
    )
    assert 0.0 < calibration.held_out_misfit < 6.0  # chi^2 of 3 over 3: 6 with a probability of 4e-4


@pytest.mark.slow
@pytest.mark.parametrize(
    ("column", "factor", "tolerance"),
    [
        ("mean_velocity", 1.7, 0.1),
        ("mean_velocity", -1.0, 0.05),
        ("drive.frequency", 0.5 / np.pi, 0.1),
        ("drive.frequency", 2.0 * np.pi, 0.1),
    ],
    ids=["another unit", "turned about", "Hz", "rad/s"],
)
def test_wrong_column_is_named(bench, table, column, factor, tolerance):
    """No damping and friction within the bounds explain it, the factor does; no parameter is determined."""
    wrong = table | {column: factor * table[column]}
    if column == "mean_velocity":
        wrong["mean_velocity_error"] = abs(factor) * table["mean_velocity_error"]
    calibration = vc.calibrate(bench, wrong, WITHIN, starts=16)
    assert calibration.doubt is not None
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
@pytest.mark.parametrize("with_errors", [True, False])
def test_an_outlier_is_named_and_determines_nothing(bench, table, with_errors):
    wrong = table | {"mean_velocity": table["mean_velocity"] + 0.05 * (np.arange(12) == 3)}
    kept = wrong if with_errors else {name: wrong[name] for name in ("drive.frequency", "mean_velocity")}
    calibration = vc.calibrate(bench, kept, WITHIN, starts=16)
    assert calibration.rows_outlying == [4]
    assert calibration.facts["outlier"].startswith("row 4: ")
    assert not any(parameter.verdict is Verdict.DETERMINED for parameter in calibration.parameters)


@pytest.mark.slow
def test_verdicts_know_the_misfit(bench, table):
    """The same table with errors ten times too small: a misfit of a hundred is no noise."""
    calibration = vc.calibrate(bench, table | {"mean_velocity_error": np.full(12, 0.1 * ERROR)}, WITHIN, starts=16)
    assert calibration.misfit > 30.0
    assert [parameter.verdict for parameter in calibration.parameters] == [Verdict.DOUBTED] * 2
    assert all(
        TRUTH[parameter.path] in parameter for parameter in calibration.parameters
    )  # the intervals have widened by its root


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
def test_parameters_that_share_a_factor(bench):
    """Both levels of friction 30 % higher, as one unknown."""
    tied = "friction.coulomb_coefficient,friction.static_coefficient"
    truth = {"friction.coulomb_coefficient": 0.065, "friction.static_coefficient": 0.26, "machine.damping": 1.3}
    over = {"drive.frequency": FREQUENCIES}
    exact = vc.ensemble(bench.with_parameters(truth), over, periods=400, settle=1e-9, tolerance=1e-10)["mean_velocity"]
    table = over | {"mean_velocity": exact}
    calibration = vc.calibrate(bench, table, {tied: "factor:0.5:2", "machine.damping": (0.5, 3.0)}, starts=16)
    assert calibration[tied].value == pytest.approx(1.3, rel=1e-3)
    for path, value in truth.items():
        assert calibration.system.parameter(path) == pytest.approx(value, rel=1e-3)


@pytest.mark.slow
def test_levels_of_friction_that_meet_are_trusted(bench):
    """No law has a static level below the Coulomb level: differences are taken on the side where it has one."""
    block = vc.System(bench.machine, vc.Coulomb(0.07, 0.07), bench.drive)
    runs = {"drive.frequency": FREQUENCIES}
    speeds = vc.ensemble(block, runs, periods=400, settle=1e-9, tolerance=1e-10)["mean_velocity"]
    table = runs | {"mean_velocity": speeds, "mean_velocity_error": np.full(12, 1e-6)}
    levels = {"friction.coulomb_coefficient": (0.02, 0.15), "friction.static_coefficient": (0.02, 0.3)}
    calibration = vc.calibrate(block, table, levels, starts=8)
    assert not calibration.not_trusted
    coulomb, static = calibration.parameters
    assert (coulomb.verdict, static.verdict) == (Verdict.DETERMINED, Verdict.BOUNDED_ABOVE)
    assert 0.07 in coulomb
    assert static.low < 0.07 + 1e-6


@pytest.mark.slow
def test_intervals_end_where_a_part_refuses(bench, speeds):
    """Speeds with errors of a tenth say little of the static level; below the Coulomb level there is no such law."""
    table = {"drive.frequency": FREQUENCIES, "mean_velocity": speeds, "mean_velocity_error": np.full(12, 0.1)}
    calibration = vc.calibrate(
        bench.with_parameters(TRUTH), table, {"friction.static_coefficient": (0.01, 0.6)}, starts=16
    )
    static = calibration["friction.static_coefficient"]
    assert static.low == pytest.approx(TRUTH["friction.coulomb_coefficient"], rel=1e-6)
    assert static.verdict in (Verdict.BOUNDED_ABOVE, Verdict.UNDETERMINED)


@pytest.mark.slow
@pytest.mark.parametrize("seed", exhaustive_but([0], [1, 9]))
def test_synthetic_laboratories(seed):
    """The others are a benchmark of 100 (`benchmarks/laboratories.py`)."""
    table, truth, wrong = laboratory(seed)
    calibration = vc.calibrate(known_system(), table, UNKNOWN)
    if wrong is None:
        assert calibration.doubt is None
        held = [truth[parameter.path] in parameter for parameter in calibration.parameters]
        assert sum(held) >= 4  # of five at 95 %: fewer with a probability of 2 %
    else:
        assert calibration.doubt is not None
        assert calibration.doubt.column == wrong


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
    asked = ["calibrate", "examples/bench-in-si.toml", "--to", str(tmp_path / "speeds.csv")]
    assert main([*asked, "--over", "friction.coulomb_coefficient=0.02:0.2"]) == 2
    said = "drive.frequency: has no unit in a case in SI; give drive.frequency_Hz"
    assert said in " ".join(capsys.readouterr().err.split())


def test_picture_of_rows_residuals_and_intervals(bench):
    """Of rows in errors of 0.001; an untrusted row has no prediction, and the interval of a value below 0 its ends."""
    table = read_table(ANY_TABLE, bench, Complaints())
    predicted = np.linspace(0.099, 0.101, 12)
    predicted[2] = np.nan
    calibration = Calibration(
        system=bench,
        parameters=(
            CalibratedParameter("machine.damping", 1.0, 0.9, 1.3, 0.1, Verdict.DETERMINED),
            CalibratedParameter("drive.second_amplitude", -2.0, -2.2, -1.2, 0.3, Verdict.WIDE),
        ),
        correlation=np.eye(2),
        directions=(),
        measured=table,
        predicted={"mean_velocity": predicted},
        residuals={"mean_velocity": (0.1 - predicted) / ERROR},
        misfit=4.0,
        held_out_misfit=2.0,
        rms={},
        held_out=(1,),
        doubt=None,
        outliers=(4,),
        not_trusted={"not settled": (2,)},
        initial={},
    )
    rows, residuals, intervals = vc.figure(calibration).axes
    drawn = {line.get_label(): line.get_xydata() for line in rows.get_lines()}
    assert drawn["predicted (held out)"].tolist() == [[2.0, predicted[1]]]
    assert drawn["fitted"][:, 0].tolist() == [1.0, *range(3, 13)]
    assert np.array_equal(drawn["measured"][:, 1], ANY_TABLE["mean_velocity"])
    held_out = residuals.get_lines()[-1].get_xydata()
    assert held_out[:, 1] == pytest.approx([(0.1 - predicted[1]) / ERROR])
    ends = [line.get_xdata() for line in intervals.get_lines() if len(line.get_xdata()) == 2][:2]
    assert np.concatenate(ends) == pytest.approx([-10.0, 30.0, -10.0, 40.0])
    assert vc.plot(calibration).get_ylabel() == "mean velocity"
    figure = vc.figure(calibration)
    texts = (text.get_text() for part in (figure, *figure.subfigs) for text in part.texts)
    assert any("Row 5 is an outlier." in " ".join(text.split()) for text in texts)


@pytest.mark.slow
def test_command_writes_a_case_in_si(tmp_path, capsys):
    """The example's truth: 0.0575 and 0.095 N m s/rad."""
    asked = ["calibrate", "examples/bench-in-si.toml", "--to", "examples/bench-in-si-speeds.csv"]
    asked += ["--over", "friction.coulomb_coefficient=0.02:0.2", "--over", "machine.damping_N_m_s_per_rad=0.02:0.3"]
    asked += ["--starts", "32", "--periods", "400", "--json", "--out", str(tmp_path), "--plot", str(tmp_path / "a.svg")]
    assert main(asked) == 0
    assert "mean velocity [m/s]" in (tmp_path / "a.svg").read_text(encoding="utf-8").replace("\N{NO-BREAK SPACE}", " ")
    record = json.loads(capsys.readouterr().out)
    assert record["rows_not_trusted"] == {}
    assert 0.0 < record["rms"]["mean_velocity"]["value"] < 0.01
    numbers = {each["path"]: each for each in record["parameters"]}
    for path, truth in (("friction.coulomb_coefficient", 0.0575), ("machine.damping_N_m_s_per_rad", 0.095)):
        low, value, high = (numbers[path][end] for end in ("low", "value", "high"))
        if isinstance(low, dict):
            assert {each["unit"] for each in (low, value, high)} == {"N m s/rad"}
            low, value, high = (each["value"] for each in (low, value, high))
        assert low < truth < high
        case = vc.read_case(tmp_path / "calibrated.toml")
        assert case.system.parameter(path) == pytest.approx(value, rel=1e-12)
    rows = (tmp_path / "residuals.csv").read_text(encoding="utf-8").splitlines()
    assert len(rows) == 25
    measured, predicted, residual = map(float, rows[1].split(",")[2:])
    assert residual == pytest.approx((measured - predicted) / 0.00259, rel=1e-9)
    assert "--to" in refused(capsys, *asked[:2], "--to", "nothing.csv", *asked[4:])
