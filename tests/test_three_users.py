"""`examples/three_users.py`: three users in SI, from a fresh folder to a figure, a table in three formats and a page.

The answers are those of the page `docs/three-users.md`, and they agree with one another: the speed of the orbit is that
of the study at the same point, the slope that of the line, the true friction is inside the fitted intervals.
"""

import importlib.util
import os
import re
from pathlib import Path

import numpy as np
import pytest

import vibrocap as vc

ROOT = Path(__file__).resolve().parents[1]
PAGE = (ROOT / "docs" / "three-users.md").read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def played(tmp_path_factory):
    """(folder, answers) of the script, run once."""
    specification = importlib.util.spec_from_file_location("three_users", ROOT / "examples" / "three_users.py")
    script = importlib.util.module_from_spec(specification)
    specification.loader.exec_module(script)
    folder = tmp_path_factory.mktemp("three") / "users"
    beside = Path(os.environ.get("VIBROCAP_DATA") or ROOT.parent / "shared" / "data") / "arts-rotary-damper"
    return folder, script.main(folder, beside if beside.is_dir() else None)


def printed(name):
    """The number that the page gives for an answer."""
    return float(re.search(rf"^\| {re.escape(name)} \| ([-+.\de]+)", PAGE, re.MULTILINE).group(1))


pytestmark = pytest.mark.slow


def test_the_answers_are_those_of_the_page(played):
    _, answers = played
    student, researcher = answers["doctoral student"], answers["friction researcher"]
    for name in ("speed [m/s]", "steepest slope [deg]", "energy per metre [J/m]", "least load on the ground [N]"):
        assert student[name] == pytest.approx(printed(name), rel=1e-3), name
    assert student["runs that lift off"] == printed("runs that lift off")
    assert student["stable"] is True
    assert researcher["truths inside their intervals"] == "6 of 6"
    assert researcher["errors are white noise"]
    name = "speed with the fitted law [m/s]"
    assert researcher[name] == pytest.approx(printed(name), rel=1e-2)  # as the noise has it


def test_orbit_study_and_line_agree(played):
    """Three ways to one speed and one slope, with units in their names."""
    folder, answers = played
    student = answers["doctoral student"]
    study, line = vc.open_study(folder / "map"), vc.open_study(folder / "slope")
    here = study.sel({"drive.frequency_Hz": 1.3, "drive.amplitude_N_m": 0.35}, method="nearest")
    assert float(here.mean_velocity) == pytest.approx(student["speed [m/s]"], rel=1e-5)
    angle, speed = line["environment.inclination_deg"].to_numpy(), line.mean_velocity.to_numpy()
    falls = np.flatnonzero((speed[:-1] > 0.0) & (speed[1:] <= 0.0))
    assert [angle[falls[0]], angle[falls[0] + 1]] == pytest.approx([3.2, 3.3])
    assert angle[falls[0]] < student["steepest slope [deg]"] < angle[falls[0] + 1]
    assert {"m/s", "N", "J/m"} <= {study[name].attrs.get("units") for name in study.data_vars}


def test_published_measurements_are_fitted_where_they_are(played):
    _, answers = played
    answer = answers["friction researcher"]
    if "published damper, error" not in answer:
        pytest.skip("no published measurements here")
    assert 0.2 < answer["published damper, error"] < 0.3
    assert answer["of its earthquake"] < 0.8
