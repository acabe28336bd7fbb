"""Studies as NetCDF and CSV: everything is in them, in full precision, and the case with it."""

import csv
import importlib
import tomllib

import numpy as np
import pytest
import xarray as xr

import cheap_ensemble
from vibrocap import Exponential, Harmonic, PendulumCapsule, System
from vibrocap.case.case import case_from_text
from vibrocap.io import study_file as export
from vibrocap.io.study_file import write_study
from vibrocap.studies.designs import Design
from vibrocap.studies.sweep import sweep

SYSTEM = System(PendulumCapsule(), Exponential(), Harmonic())
OVER = {"machine.mass_ratio": "1:3:7", "friction.law": "exponential,lugre", "machine.normal_load": "weight,1"}
RANGES = {"machine.mass_ratio": (1, 3), "initial.angle": (0, 1)}


@pytest.fixture(autouse=True)
def cheap(monkeypatch):
    monkeypatch.setattr(importlib.import_module("vibrocap.measures.ensemble"), "ensemble", cheap_ensemble.ensemble)
    monkeypatch.setattr(export, "ROWS", 5)


@pytest.fixture(params=["grid", "design", "cases"])
def found(request, tmp_path):
    """A study in its folder."""
    plan = {
        "grid": {"over": OVER},
        "design": {"over": RANGES, "design": Design("random", 20)},
        "cases": {"cases": [{"friction.law": "lugre"}, {"machine.mass_ratio": 3, "machine.normal_load": "weight"}]},
    }[request.param]
    return sweep(SYSTEM, **plan, measures=("mean_velocity", "word"), out=tmp_path / "study", settle=1e-6)


def rows(path):
    """(header without its marks, rows as dicts) of a CSV file."""
    lines = path.read_text(encoding="utf-8").splitlines()
    header = [line.removeprefix("#").removeprefix(" ") for line in lines if line.startswith("#")]
    return "\n".join(header), list(csv.DictReader(line for line in lines if not line.startswith("#")))


@pytest.mark.parametrize("whole", [False, True])
def test_a_table_has_one_row_per_run(found, tmp_path, whole):
    source = found.load() if whole else tmp_path / "study"
    header, table = rows(write_study(source, tmp_path / "study.csv"))
    flat = found.stack(run_number=found["status"].dims)
    assert len(table) == found["status"].size
    for name in (*found.coords, "mean_velocity"):
        for row, value in zip(table, flat[name].values.tolist(), strict=True):
            given = row[name]
            assert given == value if isinstance(value, str) else np.array_equal(float(given), value, equal_nan=True)
    words = dict(zip(found.status.attrs["flag_values"], found.status.attrs["flag_meanings"].split(), strict=True))
    assert [row["status"] for row in table] == [words[code] for code in flat["status"].values]
    assert [row["settled"] for row in table] == [str(value).lower() for value in flat["settled"].values]
    assert [row["word"] for row in table] == list(flat["word"].values)
    said = tomllib.loads(header)
    assert said["result"]["identity"] == found.attrs["identity"]
    assert set(said["result"]["meaning"]) == set(table[0])
    assert case_from_text(header.partition("\n[result]\n")[0]).system == SYSTEM


@pytest.mark.parametrize("whole", [False, True])
def test_netcdf_holds_the_same(found, tmp_path, whole):
    path = write_study(found.load() if whole else tmp_path / "study", tmp_path / "study.nc")
    with xr.open_dataset(path, engine="h5netcdf") as read:
        xr.testing.assert_equal(read, found)
        assert {name: read.attrs[name] for name in ("identity", "case")} == {
            name: found.attrs[name] for name in ("identity", "case")
        }
        assert read["status"].attrs["flag_values"].dtype == read["status"].dtype
        assert list(read["status"].attrs["flag_values"]) == found["status"].attrs["flag_values"]
        assert read["mean_velocity"].attrs == found["mean_velocity"].attrs


def test_other_kinds_of_file_are_refused(found, tmp_path):
    with pytest.raises(ValueError, match=r"\.nc or \.csv"):
        write_study(found, tmp_path / "study.xlsx")
