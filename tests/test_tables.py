"""Tables for other programs: units in headings by choice, and the code of docs/tables.md in GNU Octave."""

import re
import shutil
import subprocess
import tomllib
from pathlib import Path

import numpy as np
import pytest

import vibrocap as vc
from vibrocap.arguments import ArgumentError
from vibrocap.case.case import case_from_text
from vibrocap.cli.main import main
from vibrocap.io.motion_file import read_source
from vibrocap.io.study_file import write_study

ROOT = Path(__file__).resolve().parents[1]
SI = (ROOT / "examples" / "bench-in-si.toml").read_text(encoding="utf-8")
PAGE = (ROOT / "docs" / "tables.md").read_text(encoding="utf-8")
HEADS = {
    "time": "time [s]", "angle": "angle [rad]", "angle_rate": "angle_rate [rad/s]", "position": "position [m]",
    "velocity": "velocity [m/s]", "friction": "friction [N]", "drive": "drive [N m]", "reaction": "reaction [N]",
    "side": "side", "impulse": "impulse [N s]",
}  # fmt: skip


@pytest.fixture(scope="module")
def motion():
    case = case_from_text(SI)
    return vc.simulate(case.system, periods=1, initial=case.initial)


def first_line(path):
    return path.read_text().split("\n", 1)[0].split(",")


def test_headings_of_a_motion_carry_their_units_by_choice(motion, tmp_path):
    plain = first_line(vc.write_motion(motion, tmp_path / "plain.csv"))
    heads = first_line(vc.write_motion(motion, tmp_path / "heads.csv", unit_headings=True))
    table = dict(zip(plain, heads, strict=True))
    assert {name: table[name] for name in HEADS} == HEADS
    assert all(table[name] == f"{name} [J]" for name in plain if name.endswith("_work"))
    assert (tmp_path / "plain.csv").read_text().split("\n", 1)[1] == (tmp_path / "heads.csv").read_text().split(
        "\n", 1
    )[1]
    assert read_source(tmp_path / "heads.csv").system == motion.system
    units = tomllib.loads((tmp_path / "heads.csv.toml").read_text())["result"]["units"]
    assert {name: units[name] for name in ("time", "drive")} == {"time": "s", "drive": "N m"}
    pandas = pytest.importorskip("pandas")
    pytest.importorskip("openpyxl")
    book = pandas.read_excel(vc.write_motion(motion, tmp_path / "heads.xlsx", unit_headings=True))
    assert list(book) == heads


def test_a_motion_without_units_has_none_in_its_headings(tmp_path):
    motion = vc.simulate(vc.System(vc.PendulumCapsule(), vc.Exponential(), vc.Harmonic()), periods=1)
    heads = first_line(vc.write_motion(motion, tmp_path / "heads.csv", unit_headings=True))
    assert heads == first_line(vc.write_motion(motion, tmp_path / "plain.csv"))


@pytest.mark.slow
def test_headings_of_a_study_carry_their_units_by_choice(tmp_path):
    case = case_from_text(SI)
    over = {"drive.frequency_Hz": [0.9, 1.0], "friction.coulomb_coefficient": [0.05, 0.1]}
    study = vc.sweep(
        case.system,
        over,
        initial=case.initial,
        periods=2,
        measures=["mean_velocity", "drift", "mode_sequence"],
        tolerance=1e-8,
        settle=0,
    )
    heads = first_line(write_study(study, tmp_path / "study.csv", unit_headings=True))
    assert heads[:2] == ["drive.frequency_Hz", "friction.coulomb_coefficient"]
    assert {"mean_velocity [m/s]", "drift [m]", "mode_sequence", "status"} <= {*heads}
    pandas = pytest.importorskip("pandas")
    pytest.importorskip("openpyxl")
    assert list(pandas.read_excel(write_study(study, tmp_path / "study.xlsx", unit_headings=True))) == heads
    units = tomllib.loads((tmp_path / "study.csv.toml").read_text())["result"]["units"]
    assert (units["drive.frequency_Hz"], units["mean_velocity"], units["mode_sequence"]) == ("Hz", "m/s", "1")
    arrays = pytest.importorskip("scipy.io").loadmat(
        write_study(study, tmp_path / "study.mat"), squeeze_me=True, simplify_cells=True
    )
    assert arrays["units"]["drift"] == "m"


def test_units_in_headings_are_for_tables_that_have_some(motion, tmp_path, capsys):
    for ending in (".mat", ".nc"):
        with pytest.raises(
            ArgumentError, match=rf"unit_headings: is for tables with headings \(.csv and .xlsx\); in a {ending}"
        ):
            vc.write_motion(motion, tmp_path / f"motion{ending}", unit_headings=True)
    (tmp_path / "case.toml").write_text(SI)
    case = str(tmp_path / "case.toml")
    over = ["--over", "drive.frequency_Hz=0.9:1:2"]
    for words in (
        ["simulate", case, "--unit-headings"],
        ["simulate", case, "--unit-headings", "--out", str(tmp_path / "a.mat")],
        ["sweep", case, *over, "--unit-headings", "--out", str(tmp_path / "study")],
    ):
        assert main(words) == 2
        assert "--unit-headings: is for --" in capsys.readouterr().err
    assert not [*tmp_path.glob("*.mat"), *tmp_path.glob("study")]
    assert main(["simulate", case, "--periods", "1", "--out", str(tmp_path / "a.csv"), "--unit-headings"]) == 0
    assert "position [m]" in first_line(tmp_path / "a.csv")
    words = [
        "sweep",
        case,
        *over,
        "--periods",
        "1",
        "--tolerance",
        "1e-8",
        "--export",
        str(tmp_path / "b.csv"),
        "--unit-headings",
    ]
    assert main(words) == 0
    assert "mean_velocity [m/s]" in first_line(tmp_path / "b.csv")


@pytest.mark.slow
@pytest.mark.skipif(shutil.which("octave-cli") is None, reason="needs GNU Octave")
def test_the_code_for_matlab_runs_in_octave_and_prints_what_is_said(tmp_path):
    case = vc.read_case(ROOT / "examples" / "bench-in-si.toml")
    motion = case.simulate()
    vc.write_motion(motion, tmp_path / "bench.mat")
    printing, drawing = re.findall(r"```matlab\n(.*?)```", PAGE, re.DOTALL)
    (printed,) = re.findall(r"```text printed by octave\n(.*?)```", PAGE, re.DOTALL)

    def octave(code):
        command = ["octave-cli", "--norc", "--quiet", "--eval", code]
        return subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=True, timeout=120).stdout

    assert octave(printing) == printed
    # of a picture that nobody sees: what is drawn, and what its axes are called
    names = "function plot(x, y), printf('%d %d\\n', numel(x), numel(y)), end, "
    names += "function xlabel(s), disp(s), end, function ylabel(s), disp(s), end, "
    count = len(motion.time)
    assert octave(names + drawing).split("\n")[:3] == [f"{count} {count}", "time [s]", "position [m]"]
    last = octave("m = load('bench.mat'); printf('%.17g', m.position(end))")
    assert float(last) == motion["position"][-1]
    assert np.isfinite(float(last))
