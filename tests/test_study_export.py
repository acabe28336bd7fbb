"""Studies as files: everything is in them, in full precision, and the case with it."""

import csv
import datetime
import errno
import io
import sys
import time
import tomllib
import types

import numpy as np
import openpyxl
import pytest
import xarray as xr

import vibrocap as vc
from thinned import slow_but
from vibrocap import Exponential, Harmonic, PendulumCapsule, System
from vibrocap.case.case import CaseError, case_from_text
from vibrocap.files import WriteError, write_table
from vibrocap.io import netcdf, spreadsheets
from vibrocap.io import study_file as export
from vibrocap.io.motion_file import read_source, write_motion
from vibrocap.io.spreadsheets import beside
from vibrocap.io.study_file import write_study
from vibrocap.studies.dataset import open_study
from vibrocap.studies.plan.designs import Design
from vibrocap.studies.sweep import sweep

try:
    import resource
except ImportError:  # Windows
    resource = None

SYSTEM = System(PendulumCapsule(), Exponential(), Harmonic())
OVER = {"machine.mass_ratio": "1:3:7", "friction.law": "exponential,lugre", "machine.normal_load": "weight,1"}
RANGES = {"machine.mass_ratio": (1, 3), "initial.angle": (0, 1)}


@pytest.fixture(autouse=True)
def few_rows(cheap, monkeypatch):
    monkeypatch.setattr(export, "ROWS", 5)


PLANS = {
    "grid": {"over": OVER},
    "design": {"over": RANGES, "design": Design("random", 20)},
    "cases": {"cases": [{"friction.law": "lugre"}, {"machine.mass_ratio": 3, "machine.normal_load": "weight"}]},
}
ON_A_GRID = pytest.mark.parametrize("found", ["grid"], indirect=True)


@pytest.fixture(params=PLANS)
def found(request, tmp_path):
    """A study in its folder."""
    asked = {"measures": ("mean_velocity", "mode_sequence"), "out": tmp_path / "study", "settle": 1e-6}
    return sweep(SYSTEM, **PLANS[request.param], **asked)


def rows(path):
    """(what is beside it, rows as dicts) of a CSV file."""
    lines = path.read_text(encoding="utf-8").splitlines()
    return beside(path).read_text(encoding="utf-8"), list(csv.DictReader(lines))


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
    assert [row["mode_sequence"] for row in table] == list(flat["mode_sequence"].values)
    content = tomllib.loads(header)
    assert content["result"]["identity"] == found.attrs["identity"]
    assert set(content["result"]["meaning"]) == set(table[0])
    assert case_from_text(header.partition("\n[result]\n")[0]).system == SYSTEM


def test_workbooks_and_matlab_files_hold_the_same(found, tmp_path):
    pandas = pytest.importorskip("pandas")
    pytest.importorskip("openpyxl")
    scipy_io = pytest.importorskip("scipy.io")
    plain = pandas.read_csv(write_study(found, tmp_path / "study.csv"))
    book = pandas.read_excel(write_study(found, tmp_path / "study.xlsx"))
    assert list(book) == list(plain)
    for name in plain:  # programs that read decimal numbers may round them once
        one, other = book[name], plain[name]
        if one.dtype.kind in "fi":
            assert np.allclose(one, other, rtol=1e-15, atol=0.0, equal_nan=True), name
        else:
            assert one.dropna().tolist() == other.dropna().tolist(), name
    arrays = scipy_io.loadmat(write_study(found, tmp_path / "study.mat"), squeeze_me=True, simplify_cells=True)
    assert np.array_equal(arrays["mean_velocity"], found["mean_velocity"].values, equal_nan=True)
    assert list(np.atleast_1d(arrays["axes"])) == list(found["status"].dims)
    assert arrays["result"]["identity"] == found.attrs["identity"]


@ON_A_GRID
def test_more_runs_than_a_sheet_holds_are_refused(found, tmp_path, monkeypatch):
    pytest.importorskip("openpyxl")
    monkeypatch.setattr(spreadsheets, "ROWS", 2)
    with pytest.raises(ValueError, match="a sheet of Excel has at most 2 rows"):
        write_study(found, tmp_path / "study.xlsx")
    assert not (tmp_path / "study.xlsx").exists()


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


@ON_A_GRID
def test_damage_to_a_netcdf_file_is_an_error_and_no_number(found, tmp_path):
    path = write_study(found.load(), tmp_path / "study.nc")
    whole, part = path.read_bytes(), np.ascontiguousarray(found["mean_velocity"].values).tobytes()
    place = whole.index(part) + len(part) // 2
    path.write_bytes(whole[:place] + bytes([whole[place] ^ 1]) + whole[place + 1 :])
    with xr.open_dataset(path, engine="h5netcdf") as read, pytest.raises(OSError, match="filter returned failure"):
        read["mean_velocity"].load()
    with pytest.raises(CaseError, match="cannot be read as NetCDF, or is damaged"):
        open_study(path)


@ON_A_GRID
@pytest.mark.parametrize("ending", [".csv", ".nc"])
def test_exports_have_the_same_bytes_in_whatever_order_a_store_gives_its_variables(found, tmp_path, ending):
    """Zarr lists arrays as its threads find them."""
    coords = {name: found[name].variable for name in reversed(list(found.coords))}
    shuffled = xr.Dataset({name: found[name].variable for name in found.data_vars}, coords, found.attrs)
    assert list(shuffled.coords) != list(found.coords)
    first = write_study(found, tmp_path / f"first{ending}").read_bytes()
    assert write_study(shuffled, tmp_path / f"second{ending}").read_bytes() == first
    assert write_study(tmp_path / "study", tmp_path / f"third{ending}").read_bytes() == first


@ON_A_GRID
def test_large_exports_have_the_same_bytes_though_they_are_not_made_in_memory(found, tmp_path, monkeypatch):
    small = write_study(tmp_path / "study", tmp_path / "small.nc").read_bytes()
    monkeypatch.setattr(netcdf, "IN_MEMORY", 0)
    monkeypatch.setattr(netcdf.io, "BytesIO", lambda: pytest.fail("made in memory"))
    assert write_study(tmp_path / "study", tmp_path / "large.nc").read_bytes() == small


class Small:
    """A file on a disk that takes 3000 bytes."""

    def __init__(self, file):
        self.file, self.seek, self.read = file, file.seek, file.read

    def write(self, data):
        room = 3000 - self.file.tell()
        if room <= 0:
            raise OSError(errno.ENOSPC, "No space left on device")
        return self.file.write(bytes(data)[:room])


def test_hdf5_sees_no_error_of_the_disk(tmp_path):
    """Whatever it writes and reads after the disk is full, at random places, is as in a file in memory."""
    chance, memory = np.random.default_rng(1), io.BytesIO()
    with (tmp_path / "file").open("w+b", buffering=0) as file:
        disk = netcdf._Disk(Small(file))
        for _ in range(500):
            place, data = int(chance.integers(4000)), chance.bytes(int(chance.integers(1, 300)))
            assert {(each.seek(place), each.write(data)) for each in (disk, memory)} == {(place, len(data))}
            place, found, wanted = int(chance.integers(4500)), bytearray(200), bytearray(200)
            assert disk.seek(place) == memory.seek(place)
            assert disk.readinto(found) == memory.readinto(wanted)
            assert found == wanted
            assert disk.seek(0, io.SEEK_END) == memory.seek(0, io.SEEK_END)
    with pytest.raises(OSError, match="No space left"):
        disk.check()


@pytest.mark.skipif(resource is None, reason="this system limits no sizes of files")
@pytest.mark.parametrize("found", ["grid"], indirect=True)
@pytest.mark.parametrize(("ending", "in_memory"), slow_but([0], [(".csv", 0), (".nc", netcdf.IN_MEMORY), (".nc", 0)]))
def test_a_full_disk_leaves_the_old_export(found, tmp_path, monkeypatch, ending, in_memory):
    """At whatever byte: HDF5 would take the process down with it."""
    monkeypatch.setattr(netcdf, "IN_MEMORY", in_memory)
    monkeypatch.setattr(sys, "dont_write_bytecode", True)  # Python would keep half of a module that it loads
    path = write_study(found, tmp_path / f"study{ending}")
    whole = path.read_bytes()
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    for size in {0, 1, 512, len(whole) - 1, *range(97, len(whole), len(whole) // 3)}:
        resource.setrlimit(resource.RLIMIT_FSIZE, (size, before[1]))
        try:
            with pytest.raises(WriteError, match=rf"study{ending}(\.toml)?: cannot be written: File too large"):
                write_study(tmp_path / "study", path)
        finally:
            resource.setrlimit(resource.RLIMIT_FSIZE, before)
        assert path.read_bytes() == whole
    kept = {"study", path.name, f"{path.name}.toml"} if ending == ".csv" else {"study", path.name}
    assert {path.name for path in tmp_path.iterdir()} == kept


@ON_A_GRID
def test_other_kinds_of_file_are_refused(found, tmp_path):
    with pytest.raises(ValueError, match=r"\.nc, \.csv, \.xlsx or \.mat"):
        write_study(found, tmp_path / "study.ods")


@ON_A_GRID
def test_a_workbook_has_the_same_bytes_at_any_time(found, tmp_path, monkeypatch):
    first = write_study(found, tmp_path / "first.xlsx").read_bytes()
    monkeypatch.setattr("time.time", lambda: 2e9)
    monkeypatch.setattr("time.localtime", lambda *_: time.struct_time((2033, 5, 18, 3, 33, 20, 2, 138, 0)))
    monkeypatch.setattr("openpyxl.writer.excel.datetime", types.SimpleNamespace(
        datetime=types.SimpleNamespace(now=lambda **_: datetime.datetime(2033, 5, 18)), timezone=datetime.timezone
    ))  # fmt: skip
    assert write_study(found, tmp_path / "again.xlsx").read_bytes() == first
    assert openpyxl.load_workbook(tmp_path / "first.xlsx")["runs"].max_row == found["status"].size + 1


def test_no_text_of_a_table_is_run_by_a_spreadsheet(tmp_path):
    """Names in the files of strangers may be formulas. Numbers with a sign stay numbers."""
    headings, row = ("=A1", "force"), ("=cmd|' /C calc'!A0", "-1.5", "+x", "@y", "-inf", -2.5, "plain")
    shown = ["'=cmd|' /C calc'!A0", "-1.5", "'+x", "'@y", "-inf", "-2.5", "plain"]
    write_table(tmp_path / "a.csv", headings, [row])
    with (tmp_path / "a.csv").open(newline="") as file:
        assert list(csv.reader(file)) == [["'=A1", "force"], shown]
    spreadsheets.write_workbook(tmp_path / "a.xlsx", {"a": (headings, [(*row, "a\x01b")])}, 2)
    cells = list(openpyxl.load_workbook(tmp_path / "a.xlsx")["a"].values)[1]
    assert [*map(str, cells)] == [*shown, r"a\x01b"]


def test_a_damaged_netcdf_file_is_refused_or_read(tmp_path):
    """One flipped bit among its headers, or a lost end: a word about the file, never a traceback."""
    sweep(SYSTEM, over={"machine.mass_ratio": "1:3:4"}, measures=("mean_velocity",), out=tmp_path / "study")
    write_study(tmp_path / "study", tmp_path / "whole.nc")
    write_motion(vc.simulate(SYSTEM, periods=1), tmp_path / "motion.nc")
    chance, path, refused = np.random.default_rng(3), tmp_path / "damaged.nc", 0
    for number in range(32):
        name, read = (("whole.nc", open_study), ("motion.nc", read_source))[number % 2]
        content = bytearray((tmp_path / name).read_bytes())
        if number < 16:
            content[chance.integers(4000)] ^= 1 << int(chance.integers(8))
        else:
            del content[chance.integers(len(content)) :]
        path.write_bytes(content)
        try:
            read(path)
        except CaseError as error:
            refused += str(path) in str(error)
    assert refused >= 16  # the others are as they were to a reader
