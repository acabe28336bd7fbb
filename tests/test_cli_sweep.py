"""The commands sweep, measures and plot: exit codes, what they refuse, what they print and write."""

import errno
import importlib
import importlib.util
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

import interrupts
from cases import SETTLED as CASE
from cases import command, refused
from vibrocap.case.case import read_case
from vibrocap.cli.terminal import INCOMPLETE, INTERRUPTED, OK, TimeLeft, duration
from vibrocap.measures.during_run import measure_table
from vibrocap.ranges import values_between
from vibrocap.studies.dataset import open_study
from vibrocap.studies.sweep import sweep

EXAMPLES = Path(__file__).resolve().parents[1] / "examples"
MASS, TORQUE = "machine.mass_ratio=1:3:3", "drive.amplitude=1:2:4"


@pytest.fixture
def case(tmp_path, monkeypatch):
    """A case file in an empty folder, which is the current one."""
    monkeypatch.chdir(tmp_path)
    path = tmp_path / "case.toml"
    path.write_text(CASE)
    return path


# --- a sweep, with the engine ----------------------------------------------------------------------------------------


@pytest.mark.slow
def test_sweep_stores_what_python_returns(case, capsys):
    options = ("--measure", "mean_velocity,mode_sequence", "--periods", "20", "--settle", "1e-5", "--window", "4")
    assert command("sweep", case, "--over", MASS, "--over", TORQUE, *options, "--out", "map") == OK
    setup = read_case(case)
    over = {"machine.mass_ratio": [1.0, 2.0, 3.0], "drive.amplitude": values_between(1.0, 2.0, 4)}
    expected = sweep(
        setup.system, over, initial=setup.initial, measures=["mean_velocity", "mode_sequence"],
        periods=20, window=4, settle=1e-5, tolerance=1e-10,
    )  # fmt: skip
    study = open_study("map")
    xr.testing.assert_identical(study.load(), expected)
    text = capsys.readouterr().out
    assert "12 runs (machine.mass_ratio 3, drive.amplitude 4)" in text
    assert "finished   12" in text
    assert f"settled    {float(expected['settled'].mean()):.1%}" in text
    assert "stored in  map" in text
    assert "Next: vibrocap plot map" in text
    assert command("plot", "map", "--border", "mode_sequence,travel") == OK
    assert capsys.readouterr().out == "Picture: map-mean_velocity.png\n"
    assert Path("map-mean_velocity.png").stat().st_size > 10_000


@pytest.mark.slow
def test_adaptive_map_goes_to_a_file(case, capsys):
    over = ("--over", "machine.mass_ratio=0.5:4:24", "--over", "drive.amplitude=0.3:2.6:24")
    assert command("sweep", case, *over, "--adaptive", "--export", "map.nc") == OK
    with xr.open_dataset("map.nc", engine="h5netcdf") as found:
        assert found.sizes == {"machine.mass_ratio": 24, "drive.amplitude": 24}
        number = int(found["computed"].sum())
        assert 0 < number < 576
        assert found.attrs["periods"] == 12
    assert f"made       {number:,} ({number / 576:.1%})" in capsys.readouterr().out


# --- settings --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("options", "expected"),
    [
        ((), {"periods": 12, "window": 10, "settle": 1e-6, "tolerance": 1e-10}),
        (("--tolerance", "1e-7"), {"settle": 1000.0 * 1e-7, "tolerance": 1e-7}),
        (("--periods", "8"), {"periods": 8, "window": 8}),
        (("--periods", "30", "--window", "3"), {"periods": 30, "window": 3}),
        (("--settle", "0"), {"settle": None}),
        (("--settle", "1e-4"), {"settle": 1e-4}),
        (("--no-extrapolate",), {"extrapolate": False}),
    ],
)
def test_case_gives_the_settings_unless_options_do(options, expected, case, cheap):
    assert command("sweep", case, "--over", TORQUE, "--out", "map", *options) == OK
    attrs = open_study("map").attrs
    assert {name: attrs.get(name) for name in expected} == expected


@pytest.mark.parametrize("measure", ["least_reaction", "mean_velocity", "cost_of_transport", "peak_actuator_force"])
def test_a_measure_that_the_machine_does_not_have_is_refused_before_any_work(capsys, tmp_path, monkeypatch, measure):
    """By sweeps, maps, designs and samples; where kinds vary, what one of them has is asked of all."""
    monkeypatch.chdir(tmp_path)
    assert command("new", "oscillator", "--out", "block.toml") == OK
    capsys.readouterr()
    over = ("--over", "drive.amplitude=1:2:3")
    assert f"--measure: {measure}" in refused(
        capsys, "sweep", "block.toml", *over, "--measure", measure, "--out", "map"
    )
    both = (*over, "--over", "drive.frequency=1:2:3", "--adaptive", "--export", "map.nc")
    assert "--measure: " in refused(capsys, "sweep", "block.toml", *both, "--measure", measure)
    design = ("--over", "drive.amplitude=1:2", "--for", measure, "--out", "design")
    assert "--for: " in refused(capsys, "optimise", "block.toml", *design)
    assert "--for: " in refused(capsys, "robust", "block.toml", "--uncertain", "drive.amplitude=1:2", "--for", measure)
    for wrong in ("friction=fit:nowhere.json", "drive.amplitud=1:2", "drive.amplitude=2:1"):
        message = f"--uncertain: {wrong.partition('=')[0]}: "
        assert message in refused(capsys, "robust", "block.toml", "--uncertain", wrong, "--for", "stick_fraction")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["block.toml"]


@pytest.mark.plain
def test_what_one_kind_of_machine_has_is_nothing_of_another(tmp_path, monkeypatch):
    import xarray

    monkeypatch.chdir(tmp_path)
    assert command("new", "oscillator", "--out", "block.toml") == OK
    kinds = "machine.kind=oscillator,pendulum-capsule"
    asked = ("--measure", "drift,least_reaction,peak_friction", "--periods", "12", "--export", "kinds.nc")
    assert command("sweep", "block.toml", "--over", kinds, *asked) == OK
    with xarray.open_dataset("kinds.nc") as found:
        assert np.isfinite(found["peak_friction"].values).all()
        for name in ("drift", "least_reaction"):
            assert np.isfinite(found[name].values).tolist() == [False, True]


def test_failed_runs_are_results_and_counted(case, cheap, capsys):
    assert command("sweep", case, "--over", "machine.mass_ratio=1:3:100", "--out", "map") == OK
    study = open_study("map")
    failed = int((study["status"] != 0).sum())
    assert failed > 0
    text = capsys.readouterr().out
    assert f"finished   {100 - failed}" in text
    assert f"failed     {failed}: too many events" in text
    settled = int((study["settled"] & (study["status"] == 0)).sum())
    unsettled = 100 - failed - settled
    assert f"settled    {settled / (100 - failed):.1%} of these; {unsettled} did not, and may with more" in text


def test_resumed_study_goes_on_and_a_complete_one_is_left_as_it_is(case, cheap, capsys):
    arguments = ("sweep", case, "--over", MASS, "--out", "map", "--resume")
    assert command(*arguments) == OK
    before = {path: path.read_bytes() for path in Path("map").rglob("*") if path.is_file()}
    assert command(*arguments) == OK
    assert {path: path.read_bytes() for path in Path("map").rglob("*") if path.is_file()} == before


def test_export_beside_or_instead_of_a_folder(case, cheap):
    for options in (("--out", "map", "--export", "map.csv"), ("--export", "other.csv")):
        assert command("sweep", case, "--over", MASS, *options) == OK
    assert Path("map.csv").read_bytes() == Path("other.csv").read_bytes()
    assert len([row for row in Path("map.csv").read_text().splitlines() if row[0] != "#"]) == 4
    assert command("sweep", case, "--over", MASS, "--export", "map.nc") == OK
    with xr.open_dataset("map.nc", engine="h5netcdf") as found:
        assert found.sizes == {"machine.mass_ratio": 3}


def test_design_and_cases(case, cheap):
    options = ("--over", "machine.mass_ratio=1:3", "--over", "drive.amplitude=log:0.1:3", "--design", "sobol")
    assert command("sweep", case, *options, "--runs", "16", "--seed", "3", "--out", "design") == OK
    assert open_study("design").sizes == {"run": 16}
    Path("cases.csv").write_text("# my cases\nmachine.mass_ratio, friction.law\n1,lugre\n\n,exponential\n")
    assert command("sweep", case, "--cases", "cases.csv", "--out", "cases", "--measure", "drift") == OK
    study = open_study("cases")
    np.testing.assert_array_equal(study["machine.mass_ratio"], [1.0, 2.5])
    assert study["friction.law"].values.tolist() == ["lugre", "exponential"]


# --- wrong input -----------------------------------------------------------------------------------------------------


WRONG = {
    "--over machine.mass_ratio": "--over machine.mass_ratio: should be PATH=VALUES",
    "--over machine.mass_ratio=1:3:3 --over machine.mass_ratio=1,2": "--over machine.mass_ratio: is given twice",
    "--over friction.law=exponential,lugr": "there is no 'lugr'; did you mean 'lugre'?",
    "": "--over: is missing",
    "--over machine.mass_ratio=1:3:3 --measure mean_velocty": "--measure: there is no measure 'mean_velocty'; did",
    "--over machine.mass_ratio=1:3:3 --measure speed": "--measure: there is no measure 'speed'; did you mean 'mean_vel",
    "--over machine.mass_ratio=1:3:3 --periods 2.5": "--periods: a study runs whole drive periods, got 2.5",
    "--over machine.mass_ratio=1:3:3 --window 13": "--window: should be a whole number of drive periods from 1 to",
    "--over machine.mass_ratio=1:3:3 --settle -1": "--settle: should be 0, for never, or a positive threshold",
    "--over machine.mass_ratio=1:3:3 --tolerance 1": "--tolerance: should be a number from 1e-14 to 0.01, got 1",
    "--over machine.mass_ratio=1:3:3 --threads 0": "--threads: should be a whole number >= 1, got 0",
    "--over machine.mass_ratio=1:3:3 --device gpu": "--device: should be one of: cpu; cuda needs the package vibro",
    "--over machine.mass_ratio=1:3 --design sobl --runs 4": "--design: there is no 'sobl'; did you mean 'sobol'?",
    "--over machine.mass_ratio=1:3 --design sobol": "--runs: is missing",
    "--over machine.mass_ratio=1:3:3 --seed 1": "--seed: belongs to --design",
    "--over machine.mass_ratio=1:3:3 --cases x.csv": "--over: does not go with --cases",
    "--cases x.csv": "--cases: x.csv: No such file",
    "--verify --over machine.mass_ratio=1:3:3": "--over: does not go with --verify, which runs nothing",
    "--verify --measure drift": "--measure: does not go with --verify, which runs nothing",
    "--over machine.mass_ratio=1:3:3 --adaptive": "--out: an adaptive map is made in one go",
}


@pytest.mark.parametrize(("options", "expected"), WRONG.items())
def test_wrong_options_are_refused_before_any_work(options, expected, case, capsys, monkeypatch):
    monkeypatch.setattr(
        importlib.import_module("vibrocap.measures.ensemble"), "ensemble", lambda *_, **__: pytest.fail("ran")
    )
    assert expected in refused(capsys, "sweep", case, *options.split(), "--out", "map")
    assert list(case.parent.iterdir()) == [case]


@pytest.mark.parametrize("other", ["--over machine.mass_ratio=1:3:3", "--design sobol --runs 4"])
def test_a_table_of_cases_beside_ranges_is_one_complaint(other, case, capsys):
    """The plan repeated it as "--cases cases: stand alone"."""
    case.with_name("x.csv").write_text("machine.mass_ratio\n1\n2\n")
    complaint = refused(capsys, "sweep", case, "--cases", case.with_name("x.csv"), *other.split(), "--out", "map")
    assert complaint.count("cases") == 1 + complaint.count("x.csv"), complaint


def test_every_complaint_is_made_at_once(case, capsys):
    over = ("--over", "machine.mas_ratio=1:3:3", "--over", "drive.amplitude=3:1:4", "--over", "x")
    rest = (
        "--measure",
        "drft,mode_sequence",
        "--periods",
        "0.5",
        "--threads",
        "-1",
        "--export",
        "a.xls",
        "--device",
        "tpu",
    )
    message = refused(capsys, "sweep", case, *over, *rest)
    for start in ("machine.mas_ratio:", "drive.amplitude:", "x:"):
        assert f"  --over {start}" in message
    for start in ("measure", "periods", "threads", "export", "device"):
        assert len(re.findall(rf"^  --{start}:", message, re.MULTILINE)) == 1


def test_case_whose_periods_are_not_whole_asks_for_the_option(case, capsys):
    case.write_text(CASE.replace("periods = 12", "periods = 12.5"))
    message = refused(capsys, "sweep", case, "--over", MASS, "--out", "map")
    assert f"run.periods of {case}: a study runs whole drive periods, got 12.5; give --periods" in message
    case.write_text(CASE.replace("periods = 12", "periods = 12.0"))
    assert "periods" not in refused(capsys, "sweep", case, "--over", "x", "--out", "map")


def test_wrong_cases_are_named_by_their_line(case, capsys):
    rows = ["machine.mass_ratio,friction.law", "# good", "2,exponential", "3,exponentia", "nan,lugre"]
    Path("cases.csv").write_text("\n".join(rows))
    message = refused(capsys, "sweep", case, "--cases", "cases.csv", "--out", "map")
    assert "--cases cases.csv, line 4: friction.law: there is no 'exponentia'; did you mean 'exponential'?" in message
    assert "--cases cases.csv, line 5: machine.mass_ratio: should be a finite number, got nan" in message
    Path("cases.csv").write_text("machine.mass_ratio,machine.mass_ratio\n1,2\n3\n,\n")
    message = refused(capsys, "sweep", case, "--cases", "cases.csv", "--out", "map")
    assert "machine.mass_ratio heads two columns" in message
    assert "line 3: has 1 values under 2 paths" in message
    assert "line 4: gives no value" in message
    Path("cases.csv").write_text("machine.mass_ratio\n")
    assert "a row for each case" in refused(capsys, "sweep", case, "--cases", "cases.csv", "--out", "map")


def test_large_study_says_how_large_and_asks_for_yes(case, capsys):
    over = ("--over", "machine.mass_ratio=1:3:4000", "--over", "drive.amplitude=1:3:4000")
    message = refused(capsys, "sweep", case, *over, "--out", "map")
    assert re.search(r"16,000,000 runs, .* GB of results, roughly .* Say --yes", message)
    assert not Path("map").exists()


def test_study_in_the_way(case, cheap, capsys):
    assert command("sweep", case, "--over", MASS, "--out", "map") == OK
    capsys.readouterr()
    again = refused(capsys, "sweep", case, "--over", MASS, "--out", "map")
    assert "--out: map holds a study already; continue with --resume, or name another folder" in again
    other = refused(capsys, "sweep", case, "--over", TORQUE, "--out", "map", "--periods", "13", "--resume")
    assert "--out: map holds another study: periods: stored 12, asked 13" in other
    assert "machine.mass_ratio" in other
    Path("mine").mkdir()
    Path("mine/letter.txt").write_text("dear")
    assert "holds letter.txt" in refused(capsys, "sweep", case, "--over", MASS, "--out", "mine")
    assert "is a file; give a folder" in refused(capsys, "sweep", case, "--over", MASS, "--out", case)


@pytest.mark.parametrize("command_name", ["sweep", "plot"])
def test_missing_extra_is_named(command_name, case, capsys, monkeypatch):
    found = importlib.util.find_spec
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None if name == "zarr" else found(name))
    assert "needs zarr; install with: " in refused(capsys, command_name, case)


# --- what may come between -------------------------------------------------------------------------------------------


def test_export_that_fails_leaves_the_study(case, cheap, capsys, monkeypatch):
    def full(*_, **_options):
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(importlib.import_module("vibrocap.io.study_file"), "write_study", full)
    message = refused(capsys, "sweep", case, "--over", MASS, "--out", "map", "--export", "m.csv", code=INCOMPLETE)
    assert "m.csv: No space left on device. The results are whole in map" in message


@pytest.mark.slow
def test_interrupted_sweep_says_how_it_goes_on(case):
    arguments = ["--over", "machine.mass_ratio=0.1:8:1000", "--over", "drive.amplitude=0.2:3:1000", "--settle", "0"]
    program = [sys.executable, "-m", "vibrocap", "sweep", str(case), *arguments, "--out", "map"]
    with interrupts.heard():
        run = subprocess.Popen(program, stderr=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
    limit = time.monotonic() + 120
    while not (done := Path("map/done")).exists() or not any(done.iterdir()):
        assert run.poll() is None
        assert time.monotonic() < limit
        time.sleep(0.1)
    run.send_signal(signal.SIGINT)
    out, err = run.communicate(timeout=60)
    assert run.returncode == INTERRUPTED
    assert out == ""
    match_ = re.fullmatch(
        r"Stopped: (\d+) of (\d+) tiles are stored in map\. With --resume the same command continues\.\n", err
    )
    assert match_
    assert 0 < int(match_[1]) < int(match_[2])


# --- measures, plot, help --------------------------------------------------------------------------------------------


def test_measures_are_listed_with_their_meaning(capsys):
    assert command("list", "measures") == OK
    text = " ".join(capsys.readouterr().out.split())
    for name, measure in measure_table().items():
        assert f"{name} " in text
        assert measure.meaning.split(",")[0].split(" (")[0] in text


def test_measures_of_a_case_are_those_of_its_machine_and_law(case, capsys):
    assert command("list", "measures", case) == OK
    listed = capsys.readouterr().out
    assert "largest_angle " in listed
    assert not any(name in listed for name in ("belt_work", "largest_bristle"))
    assert not {"largest_slipping_1", "largest_bristle_sign"} & set(measure_table())  # which piece holds: no size


def test_measures_of_a_case_in_si_have_their_units_and_mean_something(capsys):
    """The biharmonic drive breaks the symmetry that `symmetric` asks for, and a block on a belt does not travel."""
    assert command("list", "measures", EXAMPLES / "bench-in-si.toml") == OK
    rows = [line.split() for line in capsys.readouterr().out.splitlines()]
    units = {row[0]: row[1] for row in rows if len(row) > 2}
    wanted = {"mean_velocity": "m/s", "cost_of_transport": "J/m", "least_reaction": "N", "largest_angle": "rad"}
    assert {name: units.get(name) for name in wanted} == wanted
    assert not {"symmetric", "impacts"} & set(units)
    assert command("list", "measures", EXAMPLES / "slides-or-sticks-by-its-start.toml") == OK
    listed = capsys.readouterr().out
    assert "largest_position" in listed
    assert not any(f" {name} " in listed for name in ("drift", "mean_velocity", "cost_of_transport"))


def test_plot_names_what_it_cannot_draw(case, cheap, capsys):
    assert command("sweep", case, "--over", MASS, "--over", TORQUE, "--out", "map") == OK
    capsys.readouterr()
    message = refused(
        capsys, "plot", "map", "--measure", "drft", "--at", "drive.amplitude", "--at", "x=1", "--out", "a.doc",
        "--dead-band", "-1",
    )  # fmt: skip
    for text in (
        "--measure: the study has no 'drft'",
        "--at drive.amplitude: should be PATH=VALUE",
        "--at x: is no axis of the study; there is machine.mass_ratio, drive.amplitude",
        "--out: should end in .png or .svg or .pdf",
        "--dead-band: should be a number >= 0",
    ):
        assert text in message
    assert "--border: the map has no variable 'wrd'" in refused(capsys, "plot", "map", "--border", "wrd")
    assert "nowhere: no such folder" in refused(capsys, "plot", "nowhere")
    assert "holds no study" in refused(capsys, "plot", ".")
    assert command("plot", "map/", "--at", "drive.amplitude=1.4", "--out", "line.svg") == OK
    assert Path("line.svg").stat().st_size > 1000


# --- the time left ---------------------------------------------------------------------------------------------------


def test_time_left_counts_from_where_the_work_was_resumed():
    now = [100.0]
    left = TimeLeft(lambda: now[0])
    assert left.words(0.5) == ""
    now[0] = 100.5
    assert left.words(0.6) == ""  # too early to tell
    now[0] = 110.0
    assert left.words(0.6) == "about 40 s left"
    assert left.words(0.5) == ""


@pytest.mark.parametrize(
    ("seconds", "words"),
    [
        (0.04, "0.0 s"),
        (9.4, "9.4 s"),
        (9.6, "10 s"),
        (99.0, "99 s"),
        (100.0, "2 min"),
        (7200.0, "2 h"),
        (1e6, "11.6 days"),
    ],
)
def test_durations_in_words(seconds, words):
    assert duration(seconds) == words
