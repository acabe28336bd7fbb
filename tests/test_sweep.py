"""Sweeps: the dataset that comes back, and that its numbers are those of single ensembles."""

import importlib

import numpy as np
import pytest
import xarray as xr

import cheap_ensemble
from vibrocap import Biharmonic, Exponential, Harmonic, LuGre, Measure, PendulumCapsule, System, verify_study
from vibrocap.case.case import CaseError
from vibrocap.motion.status import Status
from vibrocap.studies.dataset import stored_study
from vibrocap.studies.plan.designs import Design
from vibrocap.studies.sweep import Execution, carried_out, sweep

SYSTEM = System(PendulumCapsule(), Exponential(), Harmonic(amplitude=1.8))
BRISTLES = System(PendulumCapsule(), LuGre(), SYSTEM.drive)
ALWAYS = ["status", "settled", "response_period", "window_start", "window_periods"]
PLAIN = {"periods": 60, "tolerance": 1e-8, "settle": 0}


def test_the_dataset_is_labelled(cheap):
    study = sweep(
        SYSTEM,
        over={"machine.mass_ratio": "1:3:5", "drive.amplitude": [1.0, 2.0], "initial.angle": [0.0, 0.1, 0.2]},
        measures=["mean_velocity", "mode_sequence", "response_period"],
        settle=1e-6,
        window=7,
        periods=60,
        tolerance=1e-8,
    )
    assert list(study) == [*ALWAYS, "mean_velocity", "mode_sequence", "hidden_lift_off"]
    assert dict(study.sizes) == {"machine.mass_ratio": 5, "drive.amplitude": 2, "initial.angle": 3}
    assert study["machine.mass_ratio"].attrs["symbol"] == "lambda"
    assert study["machine.mass_ratio"].attrs["units"] == "1"
    assert study["initial.angle"].attrs["long_name"] == "initial angle of the pendulum from upright"
    assert all(study[name].attrs["long_name"] for name in study.variables)
    flags = study.status.attrs
    names = dict(zip(flags["flag_values"], flags["flag_meanings"].split(), strict=True))
    assert names == {-1: "not_run"} | {i: status.value.replace(" ", "_") for i, status in enumerate(Status)}
    assert (study.attrs["window"], study.attrs["settle"], study.attrs["periods"]) == (7, 1e-6, 60)
    assert study["mode_sequence"].sel({"machine.mass_ratio": 3.0, "drive.amplitude": 2.0}).shape == (3,)


def alone(case, **settings):
    """One run by itself."""
    system = System(*(case.pop(part, getattr(SYSTEM, part)) for part in ("machine", "friction", "drive")))
    over = {path: [value] for path, value in case.items()} or {"initial.angle": [0.0]}
    return cheap_ensemble.ensemble(system, over, **settings)["mean_velocity"][0]


def test_laws_side_by_side(cheap):
    """Parameters keep the values of the case for its own law; another has those that both have, and its own states."""
    slow, start = Exponential(decay_rate=20.0), {"bristle": 0.001, "angle": 0.5}
    over = {"friction.law": ["exponential", "lugre"], "drive.waveform": ["harmonic", "biharmonic"]}
    for system, initial in ((System(PendulumCapsule(), slow, SYSTEM.drive), {"angle": 0.5}), (BRISTLES, start)):
        study = sweep(system, over=over, initial=initial, **PLAIN)
        for law in (system.friction, LuGre() if system.friction is slow else Exponential()):
            begun = {name: x for name, x in initial.items() if name == "angle" or law.internal}
            for drive in (SYSTEM.drive, Biharmonic()):
                value = study.mean_velocity.sel({"friction.law": law.name, "drive.waveform": drive.name})
                expected = alone({"friction": law, "drive": drive, "initial.angle": 0.5}, initial=begun)
                np.testing.assert_array_equal(value, expected)


def test_cases_with_values_of_their_own(cheap, tmp_path):
    """A case without a value stands at the system's own; words and numbers beside one another are stored as text."""
    cases = [
        {"friction.law": "lugre", "friction.bristle_stiffness": 50},
        {"friction.decay_rate": 5, "initial.angle": 0.25},
        {"machine.normal_load": "weight"},
        {"friction.law": "lugre"},
    ]
    study = sweep(SYSTEM, cases=cases, initial={"angle": 0.125}, **PLAIN)
    assert study.mean_velocity.dims == ("case",)
    assert list(study.coords["friction.law"].values) == ["lugre", "exponential", "exponential", "lugre"]
    np.testing.assert_array_equal(study.coords["friction.bristle_stiffness"], [50, np.nan, np.nan, 100])
    np.testing.assert_array_equal(study.coords["friction.decay_rate"], [np.nan, 5, 10, np.nan])
    np.testing.assert_array_equal(study.coords["initial.angle"], [0.125, 0.25, 0.125, 0.125])
    assert list(study.coords["machine.normal_load"].values) == ["1.0", "1.0", "weight", "1.0"]
    start = {"initial": {"angle": 0.125}}
    expected = [
        alone({"friction": LuGre(), "friction.bristle_stiffness": 50.0}, **start),
        alone({"friction.decay_rate": 5.0, "initial.angle": 0.25}),
        alone({"machine.normal_load": "weight"}, **start),
        alone({"friction": LuGre(), "initial.angle": 0.125}),
    ]
    np.testing.assert_array_equal(study.mean_velocity, expected)
    stored = sweep(SYSTEM, cases=cases, initial={"angle": 0.125}, out=tmp_path / "a", **PLAIN)
    xr.testing.assert_identical(study, stored.load())
    assert verify_study(tmp_path / "a").finished
    heavy = System(PendulumCapsule(normal_load="weight"), Exponential(), Harmonic())
    words = sweep(heavy, cases=[{"machine.mass_ratio": 2.0}, {"machine.normal_load": 3.0}], **PLAIN)
    assert list(words.coords["machine.normal_load"].values) == ["weight", "3.0"]


@pytest.mark.parametrize("missing", ["xarray", "zarr"])
def test_missing_packages_are_named_before_any_work(missing, monkeypatch):
    found = importlib.util.find_spec
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None if name == missing else found(name))
    monkeypatch.setattr(
        importlib.import_module("vibrocap.measures.ensemble"), "ensemble", lambda *_, **__: pytest.fail("ran")
    )
    with pytest.raises(
        ModuleNotFoundError, match=rf"^a sweep needs {missing}; install with: .*pip install \"vibrocap\["
    ):
        sweep(SYSTEM, over={"machine.mass_ratio": [1.0, 2.0]})


def test_a_design_lies_along_its_runs(cheap, tmp_path):
    ranges = {"machine.mass_ratio": "log:0.1:8", "machine.stiffness": (1, 3)}
    study = sweep(SYSTEM, over=ranges, design=Design("sobol", 64, seed=2), **PLAIN)
    assert study.mean_velocity.dims == ("run",)
    assert 0.1 <= study["machine.mass_ratio"].min() < 0.2
    row = study.isel(run=17)
    expected = alone({path: row[path].item() for path in ranges})
    np.testing.assert_array_equal(row.mean_velocity, expected)
    stored = sweep(
        SYSTEM,
        over=ranges,
        design=Design("sobol", 64, seed=2),
        out=tmp_path / "a",
        tile_runs=9,
        **PLAIN,
    )
    xr.testing.assert_identical(study, stored.load())


def test_a_run_that_is_refused_on_the_way_stops_the_study(cheap, monkeypatch):
    """What the checks before any work cannot know, the ensemble refuses; the message names the run."""

    def refuse(*_, **__):
        raise ValueError("something is wrong")

    monkeypatch.setattr(importlib.import_module("vibrocap.measures.ensemble"), "ensemble", refuse)
    with pytest.raises(CaseError, match=r"tile 0 cannot be run:\n  something is wrong"):
        sweep(SYSTEM, over={"machine.mass_ratio": [1.0, 2.0]}, **PLAIN)


def test_more_runs_than_stated(cheap):
    over = {"machine.mass_ratio": "1:3:10000", "machine.stiffness": "1:3:10000"}
    with pytest.raises(CaseError, match=r"100,000,000 runs, 2.8 GB of results, roughly [\d.]+ \w+ on 4 threads"):
        sweep(SYSTEM, over=over, threads=4, **PLAIN)
    over = {"machine.mass_ratio": "1:3:11"}
    with pytest.raises(CaseError, match="11 runs"):
        sweep(SYSTEM, over=over, max_runs=10, **PLAIN)
    short = sweep(SYSTEM, over=over, max_runs=10, yes=True, **PLAIN | {"periods": 3})
    assert short.attrs["window"] == 3  # it is measured over all of it
    assert short.sizes["machine.mass_ratio"] == 11


# With the engine: the standard forms of the tests.


def test_the_engine_gives_what_single_ensembles_give(tmp_path):
    from vibrocap import ensemble

    settings = {"measures": ("mean_velocity", "stick_fraction", "mode_sequence"), "periods": 30, "settle": 1e-5}
    settings |= {"tolerance": 1e-8}
    over = {"friction.law": ["exponential", "lugre"], "machine.mass_ratio": "1:4:3", "initial.angle": [0.0, 0.5]}
    study = sweep(SYSTEM, over=over, tile_runs=4, out=tmp_path / "a", **settings)
    for law in (Exponential(), LuGre()):
        system = System(SYSTEM.machine, law, SYSTEM.drive)
        rows = {"machine.mass_ratio": np.repeat(np.linspace(1, 4, 3), 2), "initial.angle": np.tile([0.0, 0.5], 3)}
        expected = ensemble(system, rows, **settings)
        here = study.sel({"friction.law": law.name})
        for name in (*ALWAYS, *settings["measures"]):
            np.testing.assert_array_equal(here[name].values.ravel(), expected[name])
    assert study.settled.any()
    assert (np.abs(study.mean_velocity) > 1e-3).all()
    xr.testing.assert_identical(study.load(), sweep(SYSTEM, over=over, threads=1, **settings))


def test_the_engine_takes_a_measure_of_ones_own(tmp_path):
    speed = Measure.derived("speed", "travel per time, whichever way", np.abs, of=("mean_velocity",))
    over = {"machine.mass_ratio": "1:4:3"}
    study = sweep(
        SYSTEM, over=over, measures=[speed, "mean_velocity"], periods=20, out=tmp_path / "a", tolerance=1e-8, settle=0
    )
    np.testing.assert_array_equal(study.speed, np.abs(study.mean_velocity))
    assert study.speed.attrs["long_name"] == "travel per time, whichever way"
    again = stored_study(tmp_path / "a", measures=[speed])
    xr.testing.assert_identical(carried_out(again, Execution()).dataset(), study.load())
    with pytest.raises(CaseError, match="'speed' is a measure of one's own"):
        stored_study(tmp_path / "a")
