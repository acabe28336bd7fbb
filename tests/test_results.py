"""Results as objects: they pickle, copy, compare by value, show themselves in a line, and come as tables."""

import copy
import dataclasses
import importlib.util
import pickle
import subprocess
import sys

import numpy as np
import pytest

import vibrocap as vc
from vibrocap.results import Rows

SYSTEM = vc.System(vc.PendulumCapsule(), vc.Exponential(), vc.Harmonic())
RESULTS = ("motion", "orbit", "branch", "fit")


@pytest.fixture(scope="module")
def results():
    orbit = vc.orbit(SYSTEM, initial={"angle": 1.0})
    time = np.linspace(0.0, 10.0, 400)
    velocity = 0.3 * np.sin(time)
    force = vc.driven_force(vc.Coulomb(coulomb_coefficient=0.2, static_coefficient=0.2), time, velocity).force
    record = vc.Record(name="one", time=time, velocity=velocity, force=force + 0.01 * np.sin(40.0 * time))
    return {
        "motion": vc.simulate(SYSTEM, periods=3, initial={"angle": 1.0}),
        "orbit": orbit,
        "branch": vc.branch(SYSTEM, "machine.mass_ratio", (2.3, 2.6), orbit=orbit, points=6, step=0.05),
        "fit": vc.fit(record, vc.Coulomb(), starts=1, intervals="covariance"),
    }


@pytest.mark.parametrize("kind", RESULTS)
def test_results_come_through_pickle_and_deepcopy_equal(results, kind):
    result = results[kind]
    for again in (pickle.loads(pickle.dumps(result)), copy.deepcopy(result)):
        assert again is not result
        assert again == result
        assert hash(again) == hash(result)


def test_branch_gives_the_same_orbit_after_pickling(results):
    branch = results["branch"]
    again = pickle.loads(pickle.dumps(branch))
    assert again.orbit(1) == branch.orbit(1)


def test_motion_goes_to_another_process_and_back(results, tmp_path):
    """As joblib sends it: by pickle, to a process that has not seen the system."""
    (tmp_path / "motion").write_bytes(pickle.dumps(results["motion"]))
    script = (
        "import pickle, sys; path = sys.argv[1]; motion = pickle.load(open(path, 'rb'));"
        "pickle.dump((motion, motion['friction']), open(path, 'wb'))"
    )
    subprocess.run([sys.executable, "-c", script, str(tmp_path / "motion")], check=True, timeout=120)
    motion, friction = pickle.loads((tmp_path / "motion").read_bytes())
    assert motion == results["motion"]
    np.testing.assert_array_equal(friction, results["motion"]["friction"])


def test_results_that_differ_are_not_equal(results):
    motion = results["motion"]
    assert motion == vc.simulate(SYSTEM, periods=3, initial={"angle": 1.0})
    for other in (
        vc.simulate(SYSTEM, periods=3, initial={"angle": 1.0}, tolerance=1e-8),
        vc.simulate(SYSTEM, periods=3, initial={"angle": np.nextafter(1.0, 2.0)}),
        vc.simulate(SYSTEM, periods=2, initial={"angle": 1.0}),
        vc.simulate(SYSTEM, periods=3, initial={"angle": 1.0}, start=0.0001),
    ):
        assert motion != other
    assert motion != "motion"
    orbit = results["orbit"]
    assert orbit != dataclasses.replace(orbit, residual=0.5)
    assert results["fit"] == dataclasses.replace(results["fit"], seconds=1e6)
    assert results["fit"] != dataclasses.replace(results["fit"], cost=1e6)
    assert results["branch"] != vc.branch(SYSTEM, "machine.mass_ratio", (2.3, 2.6), orbit=orbit, points=5, step=0.05)


@pytest.mark.parametrize("kind", RESULTS)
def test_a_result_says_what_it_is_in_a_line(results, kind):
    text = repr(results[kind])
    assert text.startswith(f"<{type(results[kind]).__name__}: ")
    assert "\n" not in text
    assert len(text) < 300
    if kind == "motion":
        assert "3 periods" in text
        assert "finished" in text


@pytest.mark.parametrize("kind", RESULTS)
def test_a_result_shows_itself_in_a_notebook(results, kind):
    page = results[kind]._repr_html_()
    assert page.count("<table>") == page.count("</table>") == 1
    assert page.count('src="data:image/png;base64,') == 1
    assert len(page) < 60_000


def test_results_without_a_picture_show_themselves_too():
    """Citations, designs and their like: a heading and a table, where there was a TypeError."""
    pytest.importorskip("pymoo")
    values = (
        vc.cite(SYSTEM),
        vc.robustness(SYSTEM, {"machine.damping": (0.9, 1.1)}, samples=8, initial={"angle": 1.0}),
        vc.optimise(SYSTEM, {"machine.damping": (0.9, 1.1)}, starts=[{"angle": 1.0}], evaluations=8, refinement=4),
        vc.pareto_front(SYSTEM, {"drive.amplitude": (0.01, 0.02)}, evaluations=4),  # it only sticks: no design
        *vc.performance_bounds(SYSTEM),
    )
    for value in values:
        page = value._repr_html_()
        assert page.count("<table>") == 1
        assert "<img" not in page
        assert pickle.loads(pickle.dumps(value)) == value


def test_a_result_shows_itself_without_matplotlib(results, monkeypatch):
    for name in [name for name in sys.modules if name.startswith(("matplotlib", "vibrocap.plotting"))]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    monkeypatch.delitem(vars(vc), "thumbnail", raising=False)
    page = results["motion"]._repr_html_()
    assert "<img" not in page
    assert "<table>" in page


def test_events_and_phases_are_tables(results):
    motion = results["motion"]
    rows = motion.events.table()
    assert len(rows) == len(motion.events) > 0
    assert list(rows[0]) == ["time", "kind", *motion.state_names, "contact"]
    assert rows[0]["velocity"] == motion.events[0].state["velocity"]
    frame = motion.phases.to_pandas()
    assert list(frame.columns) == ["start", "end", "side"]
    assert frame["end"].iloc[-1] == motion.end
    assert isinstance(motion.events, tuple)
    assert motion.events._repr_html_().count("<tr>") == len(rows) + 1
    assert Rows()._repr_html_() == "<p>none</p>"


def test_motion_as_labelled_arrays_and_as_a_table(results):
    motion = results["motion"]
    dataset = motion.to_xarray()
    np.testing.assert_array_equal(dataset["position"].values, motion["position"])
    np.testing.assert_array_equal(dataset["event_time"].values, motion.event_times)
    assert dataset.attrs["status"] == "finished"
    table = motion.to_pandas()
    np.testing.assert_array_equal(table.index, motion.time)
    np.testing.assert_array_equal(table["friction"], motion["friction"])


def test_other_results_as_tables(results):
    branch = results["branch"]
    np.testing.assert_array_equal(branch.to_pandas()["machine.mass_ratio"], branch.parameter)
    np.testing.assert_array_equal(branch.to_xarray()["drift"].values, branch.drift)
    parameters = results["fit"].to_pandas()
    assert parameters.loc["coulomb_coefficient", "value"] == results["fit"]["coulomb_coefficient"].value
    np.testing.assert_array_equal(results["orbit"].to_pandas()["angle"], results["orbit"].motion()["angle"])
    with pytest.raises(TypeError, match="result should be a motion"):
        vc.to_xarray(results["fit"])


@pytest.mark.parametrize(
    ("library", "ask", "brought_by"),
    [("xarray", vc.to_xarray, r'"vibrocap\[export\]"'), ("pandas", vc.to_pandas, "pandas")],
)
def test_missing_library_is_named_with_the_extra_that_brings_it(results, monkeypatch, library, ask, brought_by):
    find = importlib.util.find_spec
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None if name == library else find(name))
    with pytest.raises(ImportError, match=f"to_{library} needs {library}; install with: .*pip install {brought_by}$"):
        ask(results["motion"])
