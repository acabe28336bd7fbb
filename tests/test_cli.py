"""The command line: exit codes, what it prints, the files it writes and runs again."""

import csv
import dataclasses
import importlib
import importlib.util
import inspect
import json
import math
import os
import subprocess
import sys
import types
from pathlib import Path

import numpy as np
import pytest

import vibrocap as vc
from cases import SETTLED as CASE
from cases import printed, printed_json, refused
from thinned import exhaustive_but, slow_but
from vibrocap.case.case import RUN_DEFAULTS, Case, case_from_text, read_case
from vibrocap.cli.command import COMMANDS
from vibrocap.cli.main import MOVED, app_of, main
from vibrocap.cli.overview import GROUPS, names, overview
from vibrocap.cli.terminal import BROKEN_PIPE, INCOMPLETE, OK, WRONG_INPUT
from vibrocap.io.motion_file import read_source
from vibrocap.io.spreadsheets import beside
from vibrocap.numerics.compiler.machine import SettingError, host

EXAMPLES = Path(__file__).resolve().parents[1] / "examples"
KEYS = ["state", "time", "drift", "mean_velocity", "cost_of_transport", "winding", "events"]
KEYS += ["stick_fraction", "least_reaction", "energy", "certificate", "status"]


@pytest.fixture
def case(tmp_path):
    path = tmp_path / "case.toml"
    path.write_text(CASE)
    return path


@pytest.fixture
def lugre(tmp_path):
    path = tmp_path / "lugre.toml"
    path.write_text(CASE.replace("exponential", "lugre"))
    return path


def test_a_table_or_a_study_is_no_case(case, capsys):
    case.with_name("run.xlsx").write_bytes(b"PK\x03\x04\xff\xfe")
    assert "is no case file (.toml)" in refused(capsys, "simulate", case.with_name("run.xlsx"))


def test_a_list_is_of_one_case_and_equations_are_of_a_machine(case, capsys):
    """The parts of a case in SI stand in SI: a list of one said 6.28 for a frequency of 1 Hz."""
    assert main(["list", str(EXAMPLES / "bench-in-si.toml")]) == OK
    rows = [" ".join(line.split()) for line in capsys.readouterr().out.splitlines()]
    assert {"frequency ω 1 Hz drive frequency", "capsule_mass λ 0.5 kg mass of the capsule"} <= {*rows}
    assert "Equations of motion, derived from its description, without units:" in rows
    assert "NAMES: should hold one case" in refused(capsys, "list", case, case)
    assert "--latex: shows the equations of a machine, got lugre" in refused(capsys, "list", "lugre", "--latex")


@pytest.mark.parametrize("option", ["--width page", "--no-header", "--style x.mplstyle"])
def test_an_option_of_a_picture_is_refused_where_none_is_drawn(option, case, capsys):
    flag = option.split()[0]
    assert f"{flag}: should be left out without --plot" in refused(capsys, "simulate", case, *option.split())


# --- help, version, what cannot be understood ------------------------------------------------------------------------


@pytest.mark.parametrize("arguments", [[], ["--help"]])
def test_help_shows_every_command_in_its_group_on_one_screen(arguments, capsys):
    assert main(arguments) == OK
    lines = capsys.readouterr().out.splitlines()
    assert len(lines) <= 32
    assert max(map(len, lines)) <= 80
    assert [line.split()[0] for line in lines if line.split(" ")[0] in GROUPS] == list(GROUPS)
    for name, command in COMMANDS.items():
        summary = command.words.partition("\n")[0]
        assert sum(line[8:].startswith(f"{name} ") and line.endswith(summary) for line in lines) == 1


@pytest.mark.parametrize("words", [[], ["--help"], ["-h"]])
def test_the_overview_imports_no_command_and_no_library(words):
    script = "import sys; from vibrocap.__main__ import run; run(); print(*sys.modules, file=sys.stderr)"
    answer = subprocess.run(
        [sys.executable, "-c", script, *words], capture_output=True, text=True, check=True, timeout=60
    )
    assert answer.stdout == overview()
    assert not {"cyclopts", "numpy", "pydantic", "vibrocap.cli.main"} & {*answer.stderr.split()}


@pytest.mark.parametrize("old", MOVED)
def test_old_commands_answer_with_the_new_one(old, capsys):
    assert refused(capsys, *old.split()) == f"`vibrocap {old}` is now {MOVED[old]}.\n"
    new = MOVED[old].partition("`vibrocap ")[2].split()[0]
    assert new in {*names(), "--completion"}


def test_version(capsys):
    assert printed(capsys, "--version").strip() == vc.__version__


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        (["simulte"], 'Did you mean "simulate"?'),
        (["simulate"], "CASE"),
        (["simulate", "x.toml", "--jsn"], "Did you mean --json?"),
        (["simulate", "x.toml", "--kind", "crawler"], "Unknown option: --kind.\nvibrocap simulate --help explains"),
        (["simulate", "x.toml", "a b", "2"], "There is no place for 'a b' 2.\nvibrocap simulate --help explains"),
        (["simulate", "x.toml", "--periods", "many"], "--periods"),
        (["simulate", "x.toml", "--out"], "--out"),
        (["reproduce", "--only", "fig99"], "fig03"),
    ],
)
def test_words_that_are_not_understood(arguments, expected, capsys):
    assert expected in refused(capsys, *arguments)


# --- wrong input -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("change", "expected"),
    [
        (("[friction]", "mass_ratio = -1\n[friction]"), "machine.mass_ratio: should be greater than 0, got -1"),
        (("1.0471975511965976", "nan"), "initial.angle: should be a finite number, got nan"),
        (("exponential", "exponental"), "did you mean 'exponential'?"),
        (("periods = 12", "periods = 0"), "run.periods: should be a positive number, got 0"),
        (("[run]", "[run"), "line 9"),
    ],
)
@pytest.mark.parametrize("command", ["simulate", "friction"])
def test_wrong_case_is_refused(command, change, expected, case, capsys):
    case.write_text(CASE.replace(*change))
    message = refused(capsys, command, case)
    assert str(case) in message
    assert expected in message


def test_missing_file_and_folder_as_case(tmp_path, capsys):
    assert "no such file" in refused(capsys, "simulate", tmp_path / "nowhere.toml")
    assert "no such file" in refused(capsys, "simulate", tmp_path / "nowhere.csv")
    assert "is a folder" in refused(capsys, "simulate", tmp_path)


def test_everything_wrong_is_named_at_once_and_nothing_is_made(case, tmp_path, capsys):
    options = ("--out", tmp_path / "new" / "run.xls", "--plot", case / "run.png", "--animate", tmp_path / "run")
    message = refused(capsys, "simulate", case, "--periods", "0", "--tolerance", "nan", *options)
    for start in ("--periods: should be", "--tolerance: should be", "--out: should end in .nc or .csv", "--animate: "):
        assert start in message
    assert f"--plot: {str(case)!r} is a file; give a folder" in message
    assert list(tmp_path.iterdir()) == [case]


@pytest.mark.parametrize(
    "words",
    [
        "simulate CASE --out a/b/x.csv",
        "simulate CASE --plot a/b/x.png",
        "simulate CASE --animate a/b/x.gif",
        "sweep CASE --over drive.amplitude=1,2 --export a/b/x.csv",
        "branch CASE --over drive.amplitude=1:2 --plot a/b/x.png",
        "basins CASE --plane angle,angle_rate --plot a/b/x.png",
        "friction lugre --plot a/b/x.png",
        "friction lugre --tests --plot a/b/x.png",
        "fit CASE --law lugre --plot a/b/x.png",
        "stick-slip CASE --plot a/b/x.png",
    ],
)
def test_files_go_into_folders_that_are_there(words, case, capsys, monkeypatch):
    monkeypatch.chdir(case.parent)
    folder = str(Path("a") / "b")
    message = refused(capsys, *(str(case) if word == "CASE" else word for word in words.split()))
    assert f"{words.split()[-2]}: there is no folder {folder!r}; make it first, or give another name" in message
    assert list(case.parent.iterdir()) == [case]


@pytest.mark.parametrize("option", ["--out x.csv", "--plot x.png", "--animate x.gif"])
def test_folder_that_cannot_be_written(option, case, capsys, monkeypatch):
    name, file = option.split()

    def forbidden(**_):
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr("tempfile.TemporaryFile", forbidden)
    assert f"{name}: cannot write into" in refused(capsys, "simulate", case, name, case.parent / file)
    assert "--out: cannot write into" in refused(capsys, "reproduce", "--out", case.parent / "out")


def test_missing_extras_and_ffmpeg_are_named(case, capsys, monkeypatch):
    found = importlib.util.find_spec
    absent = {"xarray", "h5netcdf", "matplotlib"}
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None if name in absent else found(name))
    monkeypatch.setattr("shutil.which", lambda name: None)
    files = ("--out", case.parent / "a.nc", "--plot", case.parent / "a.png")
    message = refused(capsys, "simulate", case, *files)
    assert (
        f'--out: needs xarray and h5netcdf; install with: {sys.executable} -m pip install "vibrocap[export]"' in message
    )
    assert f'--plot: needs matplotlib; install with: {sys.executable} -m pip install "vibrocap[plot]"' in message
    monkeypatch.setattr("importlib.util.find_spec", found)
    assert "ffmpeg" in refused(capsys, "simulate", case, "--animate", case.parent / "a.mp4")


@pytest.mark.parametrize(
    ("name", "content", "expected"),
    [
        ("other.csv", b"time,position\n0,0\n", "carries no case"),
        ("binary.csv.toml", b"\xff\xfe\x00", "UTF-8"),
        ("note.csv.toml", b"[machine\n", "was not written by vibrocap"),
        ("other.nc", b"not NetCDF at all", "cannot be read as NetCDF, or is damaged"),
    ],
)
def test_exports_without_a_case(name, content, expected, tmp_path, capsys):
    (tmp_path / name).write_bytes(content)
    table = tmp_path / name.removesuffix(".toml")
    table.touch()
    assert expected in refused(capsys, "simulate", table)


# --- simulate --------------------------------------------------------------------------------------------------------


def test_json_is_the_motion_in_full_precision(case, capsys):
    record = printed_json(capsys, "simulate", case)
    motion = read_case(case).simulate()
    assert list(record) == KEYS
    assert record["state"] == motion.state
    assert record["time"] == motion.end
    assert record["drift"] == vc.drift(motion)
    velocity = vc.mean_velocity(motion, 10)
    assert record["mean_velocity"] == {
        "value": velocity.value,
        "window": list(velocity.window),
        "settled": velocity.settled,
    }
    assert sum(record["events"].values()) == len(motion.events)
    assert record["stick_fraction"] == vc.stick_fraction(motion)
    balance = vc.energy_balance(motion)
    for channel in ("drive", "damper", "contact_sliding", "bristle_loss", "stored", "residual"):
        assert record["energy"][channel] == getattr(balance, channel)
    assert record["certificate"]["estimated_error"] == motion.certificate.estimated_error
    # the measures of the last ten periods are read from sums over the same pieces: rounding of a few hundred sums
    expected = vc.measured(motion, "cost_of_transport", window=10)["cost_of_transport"]
    assert record["cost_of_transport"] == pytest.approx(expected, rel=1e-11)
    assert record["least_reaction"] == motion.certificate.least_reaction
    assert record["status"] == "finished"


@pytest.mark.plain
def test_json_of_a_law_that_cannot_stick_has_null_not_nan(lugre, capsys):
    record = printed_json(capsys, "simulate", lugre, "--periods", "2")
    assert record["stick_fraction"] is None
    assert record["certificate"]["stick_force_ratio"] is None
    assert list(record["state"])[-1] == "bristle"


@pytest.mark.plain
def test_every_contact_tells_how_long_it_rests(tmp_path, capsys):
    system = vc.System(vc.TwoBodyCrawler(), [vc.LuGre(), vc.Coulomb(0.1, 0.2)], vc.Harmonic())
    path = Case(system, periods=1).save(tmp_path / "case.toml")
    record = printed_json(capsys, "simulate", path)
    motion = vc.simulate(system, periods=1)
    shares = [record[name] for name in ("stick_fraction", "stick_fraction_2")]
    assert shares == [vc.stick_fraction(motion, contact=i) for i in (1, 2)]
    main(["simulate", str(path)])
    assert "stick fraction 2" in capsys.readouterr().out


def test_json_of_less_than_a_period(case, capsys):
    record = printed_json(capsys, "simulate", case, "--periods", "0.5")
    assert record["drift"] is None
    assert record["mean_velocity"] is None
    assert record["time"] == pytest.approx(math.pi, rel=1e-15)


@pytest.mark.plain
def test_options_replace_the_cases_settings(case, capsys):
    record = printed_json(capsys, "simulate", case, "--periods", "3", "--tolerance", "1e-6")
    motion = read_case(case, periods=3, tolerance=1e-6).simulate()
    assert record["state"] == motion.state
    assert record["mean_velocity"]["window"] == [0.0, motion.end]


def test_summary_names_window_settlement_and_evidence(case, capsys):
    text = " ".join(printed(capsys, "simulate", case).split())
    for words in ("mean over the last 10 periods", "settled", "Certificate", "energy residual", "estimated error"):
        assert words in text


@pytest.mark.plain
def test_summary_says_what_has_not_settled_and_why_a_law_never_sticks(lugre, capsys):
    text = " ".join(printed(capsys, "simulate", lugre, "--periods", "2").split())
    assert "NOT settled" in text
    assert "the lugre law creeps" in text


def test_summary_shows_energy_per_distance_and_least_reaction_with_their_units(capsys):
    record = printed_json(capsys, "simulate", EXAMPLES / "bench-in-si.toml")
    motion = read_case(EXAMPLES / "bench-in-si.toml").simulate()
    cost = vc.measured(motion, ["cost_of_transport"], window=10)["cost_of_transport"]
    least = motion.system.si.factor_of("N")
    spent, load = record["cost_of_transport"], record["least_reaction"]
    assert spent["value"] == pytest.approx(cost, rel=1e-11)
    assert load["value"] == pytest.approx(motion.certificate.least_reaction * least, rel=1e-15)
    assert (spent["unit"], load["unit"]) == ("J/m", "N")
    text = " ".join(printed(capsys, "simulate", EXAMPLES / "bench-in-si.toml").split())
    assert f"cost of transport {spent['value']:.10g} J/m work of the drive per distance" in text
    assert f"least reaction {load['value']:.10g} N of the ground in the whole run" in text


@pytest.mark.parametrize("name", ["symmetric-no-travel", "slides-or-sticks-by-its-start"])
def test_what_cannot_travel_has_no_energy_per_distance(name, capsys):
    assert printed_json(capsys, "simulate", EXAMPLES / f"{name}.toml")["cost_of_transport"] is None
    assert "cost of transport" not in printed(capsys, "simulate", EXAMPLES / f"{name}.toml")


def test_motion_that_never_moves_has_a_summary(case, capsys):
    case.write_text(
        CASE.replace("angle = 1.0471975511965976", "angle = 0.0").replace("[initial]", "amplitude = 0.1\n[initial]")
    )
    record = printed_json(capsys, "simulate", case)
    assert record["stick_fraction"] == 1.0
    assert record["state"]["position"] == 0.0
    assert main(["simulate", str(case)]) == OK


@pytest.mark.parametrize(
    ("setting", "status"),
    slow_but([], [("max_events_per_period = 1", "too many events"), ("max_steps = 30", "too many steps")]),
)
def test_run_that_cannot_be_completed(setting, status, case, capsys):
    case.write_text(CASE + setting + "\n")
    files = {option: case.parent / f"run.{kind}" for option, kind in (("--out", "csv"), ("--plot", "png"))}
    options = [str(word) for pair in files.items() for word in pair]
    assert main(["simulate", str(case), "--json", *options]) == INCOMPLETE
    output = capsys.readouterr()
    record = json.loads(output.out)
    assert record["status"] == status
    assert 0.0 < record["time"] < 6.0
    assert record["energy"]["residual"] == pytest.approx(0.0, abs=1e-8)
    assert status in output.err
    assert setting.partition(" ")[0] in output.err  # what to try
    assert all(path.stat().st_size > 0 for path in files.values())
    assert f"status = '''{status}'''" in beside(files["--out"]).read_text()
    assert "time reached" in printed(capsys, "simulate", case, code=INCOMPLETE)


@pytest.mark.parametrize("kind", ["csv", "nc"])
def test_run_that_fails_at_once_is_still_reported(kind, case, capsys):
    case.write_text(CASE.replace("[initial]", "amplitude = 1e200\n[initial]"))
    out = case.parent / f"run.{kind}"
    arguments = ["simulate", str(case), "--out", str(out), "--plot", str(case.parent / "run.png")]
    assert main([*arguments, "--json"]) == INCOMPLETE
    output = capsys.readouterr()
    assert json.loads(output.out)["status"] == "not finite"
    assert "nothing to draw" in output.err
    assert read_source(out) == read_case(case)
    assert main(arguments) == INCOMPLETE


# --- exports ---------------------------------------------------------------------------------------------------------


@pytest.mark.plain
@pytest.mark.parametrize(("kind", "law"), [("csv", "exponential"), ("nc", "lugre")])
def test_export_can_be_run_again_to_the_same_bits(kind, law, case, capsys):
    case.write_text(CASE.replace("exponential", law))
    out = case.parent / f"run.{kind}"
    first = printed_json(capsys, "simulate", case, "--periods", "2", "--out", out)
    assert read_source(out) == read_case(case, periods=2.0)
    assert printed_json(capsys, "simulate", out) == first
    assert printed_json(capsys, "friction", out)["law"] == law


def test_csv_holds_the_motion_in_full_precision(case, capsys):
    out = case.parent / "run.csv"
    printed_json(capsys, "simulate", case, "--out", out)
    rows = list(csv.reader(out.read_text().splitlines()))
    table = dict(zip(rows[0], np.array(rows[1:], dtype=float).T, strict=True))
    check_columns(table, read_case(case).simulate())
    for name in table:
        assert f'{name} = "dimensionless"' in beside(out).read_text()


@pytest.mark.slow
def test_tables_leave_for_pandas_excel_and_matlab(case, capsys):
    pandas = pytest.importorskip("pandas")
    pytest.importorskip("openpyxl")
    scipy_io = pytest.importorskip("scipy.io")
    motion, paths = read_case(case).simulate(), {}
    for kind in ("csv", "xlsx", "mat"):
        paths[kind] = case.parent / f"run.{kind}"
        printed_json(capsys, "simulate", case, "--out", paths[kind])
    plain = pandas.read_csv(paths["csv"])  # no option
    book = pandas.read_excel(paths["xlsx"], sheet_name=None)
    arrays = scipy_io.loadmat(paths["mat"], squeeze_me=True, simplify_cells=True)
    check_columns({name: np.asarray(arrays[name], dtype=float) for name in plain}, motion)
    assert np.array_equal(arrays["reaction"], motion["reaction"])
    for table in (plain, book["motion"]):  # programs that read decimal numbers may round them once
        for name in plain:
            assert np.allclose(table[name], arrays[name], rtol=1e-15, atol=1e-300), name
    assert book["events"]["time"].tolist() == pytest.approx(motion.event_times, rel=1e-15)
    assert list(arrays["events"]["kind"]) == book["events"]["kind"].tolist() == motion.event_kinds.tolist()
    assert arrays["units"]["position"] == "dimensionless"
    assert case_from_text(arrays["case_toml"], "").system == read_case(case).system
    assert dict(zip(book["columns"]["name"], book["columns"]["meaning"], strict=True))["status"] == "finished"
    first = paths["mat"].read_bytes()
    printed_json(capsys, "simulate", case, "--out", paths["mat"])
    assert paths["mat"].read_bytes() == first


def test_netcdf_holds_the_motion_with_its_metadata(case, capsys):
    xarray = pytest.importorskip("xarray")
    out = case.parent / "run.nc"
    record = printed_json(capsys, "simulate", case, "--out", out)
    with xarray.open_dataset(out, engine="h5netcdf") as dataset:
        motion = read_case(case).simulate()
        check_columns({name: dataset[name].values for name in (*dataset.data_vars, "time")}, motion)
        assert all(
            dataset[name].attrs["units"] == "dimensionless" for name in dataset.data_vars if name != "event_kind"
        )
        assert dataset.attrs["source"] == f"vibrocap {vc.__version__}"
        assert dataset.attrs["status"] == "finished"
        assert json.loads(dataset.attrs["certificate"]) == record["certificate"]
        assert dataset["event_kind"].values.tolist() == list(motion.event_kinds)
        np.testing.assert_array_equal(dataset["event_time"].values, motion.event_times)


def check_columns(table, motion):
    names = ("time", *motion.state_names, *motion.integral_names, "friction", "drive", "side")
    assert set(names) <= set(table)
    np.testing.assert_array_equal(table["time"], motion.time)
    for name in names[1:]:
        np.testing.assert_array_equal(table[name], motion[name], err_msg=name)


# --- pictures --------------------------------------------------------------------------------------------------------


def pixels_of(path):
    """Colours of a picture, [rows, columns, 3]."""
    with pytest.importorskip("PIL.Image").open(path) as picture:
        return np.asarray(picture.convert("RGB"), dtype=int)


@pytest.mark.parametrize(
    ("law", "arguments"), slow_but([], exhaustive_but([1], [("exponential", []), ("lugre", ["--periods", "0.3"])]))
)
def test_plot_is_not_blank_and_nothing_is_cut_off(law, arguments, case, capsys):
    case.write_text(CASE.replace("exponential", law))
    path = case.parent / "run.png"
    printed_json(capsys, "simulate", case, "--plot", path, *arguments)
    pixels = pixels_of(path)
    assert np.mean(np.any(pixels != 255, axis=2)) > 0.03
    blue = np.abs(pixels - [0x00, 0x72, 0xB2]).sum(axis=2) < 30
    assert blue.sum() > 2000  # the curves
    shaded = np.abs(pixels - 0xDF).max(axis=2) < 3  # 0.45 of #B8B8B8 on white
    assert (shaded.sum() > 10_000) == (law == "exponential")  # where the contact sticks
    border = np.concatenate((pixels[:3].ravel(), pixels[-3:].ravel(), pixels[:, :3].ravel(), pixels[:, -3:].ravel()))
    assert np.all(border == 255)


# --- limits ----------------------------------------------------------------------------------------------------------


def test_limits_exact_as_printed_and_when_they_do_not_exist(lugre, capsys):
    record = printed_json(capsys, "friction", lugre)
    assert record["offset"]["exist"] is False
    assert record["boundary_velocity"] == pytest.approx(0.0405, abs=5e-5)
    assert "viscous_damping is 0" in " ".join(printed(capsys, "friction", lugre).split())
    lugre.write_text(lugre.read_text().replace('"lugre"', '"lugre"\nviscous_damping = 0.4'))
    offset = printed_json(capsys, "friction", lugre)["offset"]
    assert offset["lower"] == pytest.approx(0.006696630374612, rel=1e-12)
    assert offset["upper"] == pytest.approx(0.181821489161179, rel=1e-12)
    assert offset["printed_lower"] == pytest.approx(0.0066667, abs=5e-8)
    text = printed(capsys, "friction", lugre)
    assert "0.00669663037461" in text
    assert "0.181821489161" in text


def test_limits_of_every_contact(tmp_path, capsys):
    laws = [vc.LuGre(coulomb_coefficient=0.1, static_coefficient=0.2), vc.Exponential(0.1, 0.3)]
    system = vc.System(vc.TwoBodyCrawler(normal_load=1.0, normal_load_2=2.0), laws, vc.Harmonic())
    path = vc.save_case(system, tmp_path / "case.toml")
    record = printed_json(capsys, "friction", path)
    assert {name: each["breakaway_force"] for name, each in record.items()} == {"friction": 0.2, "friction_2": 0.6}
    text = printed(capsys, "friction", path)
    assert "friction_2: exponential at normal load N = 2" in text
    assert text.count("not reached") == 1  # by bristles; without them the contact breaks away there


# --- reproduce -------------------------------------------------------------------------------------------------------


def test_reproduce_prints_the_claims_and_where_the_report_lies(tmp_path, capsys, monkeypatch):
    """The command around the work; the work itself has its own tests."""
    paper = pytest.importorskip("vibrocap.report.reproduce")
    called = {}

    def reproduced(out, only, progress):
        progress("half", 0.5)
        called.update(out=out, only=only)
        claim = types.SimpleNamespace(key="drift-is-zero", where="Fig. 9")
        outcome = types.SimpleNamespace(value="does not hold")
        finding = types.SimpleNamespace(found={"drift": 0.125}, outcome=outcome)
        verdict = types.SimpleNamespace(claim=claim, finding=finding, verdict="does not hold")
        return types.SimpleNamespace(claims=(verdict,), report=out / "report.html", seconds=1.0)

    monkeypatch.setattr(paper, "reproduce", reproduced)
    text = printed(capsys, "reproduce", "--only", "fig09", "--out", tmp_path)
    assert called == {"out": tmp_path, "only": "fig09"}
    assert "drift-is-zero" in text
    assert "does not hold 1" in text
    assert f"Report: {tmp_path / 'report.html'}" in text


# command: the functions behind it
BEHIND = {
    "orbit": "orbit",
    "branch": "branches",
    "basins": "basins",
    "crossing": "crossing",
    "robust": "robustness",
    "calibrate": "calibrate",
    "optimise": "optimise",
}
RUN = ("periods", "settle_periods", "settle", "tolerance", "max_steps", "max_events_per_period")


def test_commands_and_functions_have_one_set_of_defaults():
    """Of settling, periods and tolerance: those of a command, of the function behind it, and of a case."""
    app_of()
    for command, function in BEHIND.items():
        asked = {field.name: field for field in dataclasses.fields(COMMANDS[command].request)}
        known = inspect.signature(getattr(vc, function)).parameters
        assert {asked[name].default for name in RUN if name in asked} == {
            known[name].default for name in RUN if name in asked
        }, command
    for function in (vc.simulate, vc.sweep):
        known = inspect.signature(function).parameters
        assert {name: known[name].default for name in RUN_DEFAULTS} == RUN_DEFAULTS
    assert inspect.signature(vc.sweep).parameters["settle"].default is None


# --- in a process of its own -----------------------------------------------------------------------------------------


def run(*arguments, **options):
    command = [sys.executable, "-m", "vibrocap", *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, timeout=120, check=False, **options)


def test_values_of_a_case_are_replaced_by_options(case, lugre, capsys):
    """The run is that of a file that says so; another law has its defaults, and no start that it does not know."""
    text = lugre.read_text().replace('"lugre"', '"lugre"\nbristle_damping = 5.0')
    lugre.write_text(text.replace("[run]", "bristle = 1e-3\n[run]"))
    values = ("--set", "friction.decay_rate=5,run.periods=4", "--set", "friction.law=exponential")
    found = printed_json(capsys, "simulate", lugre, *values, "--initial", "angle=0.5")
    case.write_text(CASE.replace('"exponential"', '"exponential"\ndecay_rate = 5').replace("1.0471975511965976", "0.5"))
    assert found == printed_json(capsys, "simulate", case, "--periods", "4")


def test_values_that_do_not_fit_are_named_by_their_option(case, capsys):
    values = (
        "--set machine.mas_ratio=2 --set machine.damping=-1 --set machin.x=1 --set run=3 --set mass_ratio=2 --set x"
    )
    starts = "--initial angel=2 --initial angle=x --set initial.position=1 --initial position=1 --periods 0"
    message = refused(capsys, "simulate", case, *values.split(), *starts.split())
    for complaint in (
        "--set machine.mas_ratio: no such key for kind = 'pendulum-capsule'; did you mean 'mass_ratio'?",
        "--set machine.damping: should be at least 0, got -1",
        "--set machin.x: no such section of a case; did you mean 'machine'?",
        "--set run: should be a path such as run.NAME",
        "--set mass_ratio: should be a path such as machine.NAME",
        "--set x: should be PATH=VALUE, such as machine.mass_ratio=2.0",
        "--initial angel: no such state; did you mean 'angle'?",
        "--initial angle: should be a finite number, got 'x'",
        "--initial position: is given by --set too",
        "--periods: should be a positive number, got 0.0",
    ):
        assert f"{complaint}\n" in message


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        ("orbit CASE --response-period 0", "--response-period: should be a whole number >= 1, got 0"),
        ("orbit CASE --settle-periods 0", "--settle-periods: should be a whole number >= 1, got 0"),
        ("crossing CASE --over machine.mass_ratio=1:2 --measure sped", "--measure: should be a number of the table"),
        ("crossing CASE --over machine.mass_ratio=2:1", "--over: should be finite with low < high"),
        ("branch CASE --over drive.amplitud=1:2", "--over: drive.amplitud: there is no such parameter in this system"),
        ("branch CASE --over drive.amplitude=1:2 --points 1", "--points: should be a whole number >= 2, got 1"),
        ("branch CASE --over drive.amplitude=1:2 --depth -1", "--depth: should be a whole number >= 0, got -1"),
        ("basins CASE --plane angle,angle_rate --settle-periods 1", "--settle-periods: should be a whole number from"),
        ("friction lugre --tests --load -1", "--load: should be a positive number, got -1.0"),
    ],
)
def test_messages_name_the_option_and_not_the_argument(words, expected, case, capsys, monkeypatch):
    """Before any work: no kernel is made for what is refused."""
    monkeypatch.setattr("vibrocap.numerics.compiler.compiled", None)
    message = refused(capsys, *(case if word == "CASE" else word for word in words.split()))
    assert message.startswith(expected)


def test_exit_codes_reach_the_shell(case):
    wrong = run("simulate", case, "--periods", "-1")
    assert (wrong.returncode, wrong.stdout) == (WRONG_INPUT, "")
    assert "--periods: should be a positive number, got -1.0" in wrong.stderr


@pytest.mark.slow
def test_output_without_greek_letters_and_a_closed_pipe(case, lugre):
    environment = {"PYTHONIOENCODING": "ascii", "PATH": "/usr/bin:/bin", "HOME": str(Path.home())}
    assert run("friction", lugre, env=environment).returncode == OK
    files = [case.with_name(name) for name in ("run.png", "run.csv")]
    options = [word for option, path in zip(("--plot", "--out"), files, strict=True) for word in (option, path)]
    command = [sys.executable, "-m", "vibrocap", "simulate", case, *options]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        process.stdout.close()
        assert process.wait(timeout=60) == BROKEN_PIPE
        assert b"Traceback" not in process.stderr.read()
    assert all(path.is_file() for path in files)


ENGINE = {"llvmlite", "vibrocap.motion.simulate", "vibrocap.numerics.codegen.source", "vibrocap.studies.sweep"}
HEAVY = {"scipy", "matplotlib", "xarray", "zarr", "dask", "pandas", "h5netcdf", "numcodecs"}


@pytest.mark.parametrize(
    ("commands", "spared"),
    slow_but(
        [0],
        [
            (("--help", "new --out new.toml", "--completion bash"), HEAVY | ENGINE),
            (("orbit case.toml --settle-periods 30 --json",), HEAVY),
            (("sweep case.toml --over drive.amplitude=1:2:2 --periods 2 --out map",), HEAVY - {"numcodecs"}),
        ],
    ),
    ids=["without a motion", "orbit", "sweep"],
)
def test_a_command_loads_only_what_it_needs(commands, spared, case, tmp_path):
    """A first answer waits for all that is imported; sweeps are stored and counted without Zarr, xarray and pandas."""
    script = "import sys; from vibrocap.cli.main import main\nfor line in sys.argv[1:]:\n    main(line.split())\n"
    script += "print(*sys.modules, file=sys.stderr)"
    command = [sys.executable, "-c", script, *(line.replace("case.toml", str(case)) for line in commands)]
    answer = subprocess.run(command, capture_output=True, text=True, check=True, timeout=120, cwd=tmp_path)
    assert answer.stdout.strip()
    loaded = set(answer.stderr.splitlines()[-1].split())
    assert "vibrocap.cli.main" in loaded
    assert not spared & loaded


@pytest.mark.parametrize("name", ["stdout", "stderr"])
def test_a_standard_stream_that_is_closed_takes_nothing_and_ends_nothing(name, case, monkeypatch):
    """As by `>&-`: Python then has None in its place, and `print` writes to stdout what stderr should take."""
    monkeypatch.setattr(sys, name, None)
    assert main(["simulate", str(case), "--json"]) == OK
    assert main(["simulate", str(case), "--set", "friction.law=none"]) == WRONG_INPUT
    getattr(sys, name).close()


@pytest.mark.parametrize("given", ["log:0.5:3", "0.5:3", "1:3:4"])
@pytest.mark.parametrize("path", ["friction.law", "drive.waveform", "machine.kind"])
def test_a_range_of_names_is_refused(given, path, case, capsys):
    for command in ("optimise", "sweep"):
        assert f"{path}: should be a list of " in refused(capsys, command, case, "--over", f"{path}={given}")


@pytest.mark.parametrize("size", [1e300, 1e-300, 1e51])
def test_scales_of_which_no_unit_can_be_made_are_refused(size, case, capsys):
    scales = f"pendulum_mass_kg={size},pendulum_length_m={size}"
    for name in ("pendulum_mass_kg", "pendulum_length_m"):
        expected = f"--scales {name}: should be between 1e-50 and 1e50, got {size!r}"
        assert expected in refused(capsys, "new", "--from", case, "--scales", scales)
    largest = ("--scales", "pendulum_mass_kg=1e50,pendulum_length_m=1e50,gravity_m_per_s2=1e-50")
    assert main(["new", "--from", str(case), *largest, "--out", str(case.with_name("si.toml"))]) == OK
    capsys.readouterr()
    record = printed_json(capsys, "simulate", case.with_name("si.toml"), "--periods", "1")
    assert 0.0 < abs(record["energy"]["drive"]["value"]) < math.inf


def test_a_processor_that_llvm_does_not_know_is_refused(case, monkeypatch):
    """LLVM would print a line and end the process."""
    done = run("simulate", case, env=os.environ | {"VIBROCAP_CPU_NAME": "haswel"})
    said = "should name a processor in LLVM's words"
    assert (done.returncode, f"VIBROCAP_CPU_NAME=haswel: {said}" in done.stderr) == (WRONG_INPUT, True)
    monkeypatch.setenv("VIBROCAP_CPU_FEATURES", "+avx3")
    with pytest.raises(SettingError, match=f"VIBROCAP_CPU_FEATURES=.avx3 {said}"):
        host.__wrapped__()
