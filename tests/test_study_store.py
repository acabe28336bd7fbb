"""The store: whole tiles or none, the same bytes however it came about, and no harm to what is not its own."""

import dataclasses
import errno
import importlib
import json
import os
import re
import signal
import sys
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
import zarr

import interrupts
from stored_files import files
from vibrocap import Exponential, Harmonic, LuGre, Measure, PendulumCapsule, PendulumScales, System
from vibrocap.case.case import RUN_DEFAULTS, CaseError
from vibrocap.studies.dataset import open_study, stored_study
from vibrocap.studies.plan.planning import planned_study
from vibrocap.studies.plan.runs import tile_counts
from vibrocap.studies.store import places
from vibrocap.studies.store.places import StoreError
from vibrocap.studies.store.record import read_record
from vibrocap.studies.store.store import ZarrFiles, opened_for_writing
from vibrocap.studies.sweep import Stopped, sweep
from vibrocap.studies.tile import tile_block, tile_indices, tile_runs_by_time, tile_shape
from vibrocap.studies.variables import TEXT, axis_values, coordinate_attributes, study_attributes, variables

SYSTEM = System(PendulumCapsule(), Exponential(), Harmonic())
OVER = {"friction.law": "exponential,lugre", "machine.mass_ratio": "1:3:7", "machine.normal_load": "weight,1,2"}
MEASURES = ("mean_velocity", "mode_sequence")


pytestmark = pytest.mark.usefixtures("cheap")


def stored(out, **changes):
    return sweep(SYSTEM, **{"over": OVER, "measures": MEASURES, "out": out, "tile_runs": 9} | changes)


def test_tiles_cover_every_run_once_and_in_order():
    for shape, runs in (((5,), 2), ((400, 400), None), ((3, 5000), None), ((2, 3, 4), 5), ((7, 1, 3), 100), ((1,), 1)):
        tile, covered, before = tile_shape(shape, runs), np.zeros(shape, int), -1
        for index in tile_indices(shape, tile):
            block = tile_block(shape, tile, index)
            covered[block] += 1
            first = np.arange(covered.size).reshape(shape)[block].flat[0]
            assert 0 < covered[block].size <= (runs or 4096)
            assert first > before
            before = first
        assert np.all(covered == 1)
    assert tile_shape((400, 400)) == (10, 400)
    assert tile_shape((3, 5000)) == (1, 2500)
    assert tile_counts((10**9,), tile_shape((10**9,))) == (3815,)  # of the largest tiles


@pytest.mark.slow
@pytest.mark.parametrize(("seconds", "runs"), [(1e-5, None), (2e-3, 1024), (1.0, 64)])
def test_tiles_of_slow_runs_are_smaller(seconds, runs, cheap, tmp_path, monkeypatch):
    """By a clock on which a run takes so many seconds: some five seconds of work, but not too many tiles."""
    monkeypatch.setattr("time.perf_counter", lambda: seconds * sum(len(over["machine.mass_ratio"]) for over in cheap))
    settings = {**RUN_DEFAULTS, "window": None, "settle": 0, "extrapolate": True}
    study, small = (
        planned_study(
            SYSTEM, {"machine.mass_ratio": f"1:3:{size}"}, measures=["drift"], cases=None, design=None, initial=None,
            settings=settings,
        )
        for size in (9000, 8000)
    )  # fmt: skip
    assert tile_runs_by_time(small, tmp_path / "new") is None
    assert tile_runs_by_time(study, tmp_path / "new") == runs
    ratios = [x for over in cheap[1:] for x in over["machine.mass_ratio"]]
    assert len(ratios) == 16
    assert max(np.diff(ratios)) <= 2 / 15  # spread over all of the study
    monkeypatch.setattr(importlib.import_module("vibrocap.studies.tile"), "MOST_TILES", 20)
    assert (tile_runs_by_time(study, tmp_path / "new") or 4096) == max(runs or 4096, 9000 // 20)
    (tmp_path / "begun").write_text("")
    assert tile_runs_by_time(study, tmp_path) is None


def test_files_of_a_store_are_opened_as_bytes(tmp_path, monkeypatch):
    """Where the system knows text files (Windows), a chunk that holds the byte of a line end must not change."""
    flag, real, opened = 1 << 28, os.open, []

    def recording(path, flags, *rest, **options):
        opened.append((str(path), flags))
        return real(path, flags & ~flag, *rest, **options)

    monkeypatch.setattr(os, "O_BINARY", flag, raising=False)
    monkeypatch.setattr(os, "open", recording)
    stored(tmp_path / "a")
    written = [flags for path, flags in opened if flags & os.O_WRONLY and flags & os.O_EXCL]
    assert len(written) > 10
    assert all(flags & flag for flags in written)


def test_a_stored_study_has_tiles_by_time_unless_told(tmp_path, monkeypatch):
    monkeypatch.setattr("vibrocap.studies.sweep.tile_runs_by_time", lambda study, out, threads: 4)
    stored(tmp_path / "a", tile_runs=None)
    stored(tmp_path / "b", tile_runs=6)
    assert [read_record(tmp_path / name)["tile"] for name in "ab"] == [[1, 1, 3], [1, 2, 3]]
    xr.testing.assert_identical(open_study(tmp_path / "a").load(), open_study(tmp_path / "b").load())


def as_zarr_writes(study, tile, tiles):
    """The files that Zarr itself makes of a study."""
    held = {}
    attributes = study_attributes(study)
    if not study.plan.gridded:
        attributes["coordinates"] = " ".join(study.plan.paths)
    group = zarr.create_group(zarr.storage.MemoryStore(held), attributes=attributes)

    def array(name, dtype, fill, shape, chunk, dims, attributes):
        return group.create_array(
            name,
            shape=shape,
            chunks=chunk,
            dtype=str if dtype == TEXT else dtype,
            fill_value=fill,
            compressors=zarr.codecs.ZstdCodec(level=3, checksum=True),
            chunk_key_encoding={"name": "default", "separator": "."},
            dimension_names=dims,
            attributes=attributes,
            config={"write_empty_chunks": True},
        )

    for path, values in axis_values(study).items():
        fill = "" if values.dtype == TEXT else np.nan
        described = coordinate_attributes(path, study.case.system)
        array(path, values.dtype, fill, values.shape, values.shape, (path,), described)[:] = values
    shape, dims = study.plan.shape, study.plan.dims
    for variable in variables(study):
        numbers = array(variable.name, variable.dtype, variable.fill, shape, tile, dims, variable.stored_attributes)
        for index, values in tiles.items():
            numbers[tile_block(shape, tile, index)] = values[variable.name]
    return {place: buffer.to_bytes() for place, buffer in held.items()}


@pytest.mark.parametrize("over", [OVER, None], ids=["grid", "cases"])
def test_files_are_those_that_zarr_writes(over):
    """To the last byte: numbers and words, tiles cut by the edge, factors of units, signs beyond ASCII."""
    rng = np.random.default_rng(3)
    system = dataclasses.replace(SYSTEM, friction=LuGre(), units=PendulumScales(0.2, 0.25))
    over = over and over | {"friction.law": "lugre,stribeck"}
    own = Measure.mean("peak", "\N{GREEK SMALL LETTER OMEGA} of its own", lambda now: now.velocity, si_unit="m/s")
    cases = [{"friction.law": law, "machine.mass_ratio": 0.1 + i} for i, law in enumerate(("lugre", "stribeck") * 4)]
    study = planned_study(
        system,
        over,
        measures=(*MEASURES, own),
        cases=None if over else cases,
        design=None,
        initial=None,
        settings={"window": 10, "settle": None, "extrapolate": True, **RUN_DEFAULTS},
    )
    shape = study.plan.shape
    tile = tile_shape(shape, 9 if over else 3)
    assert any(length % variable for length, variable in zip(shape, tile, strict=True))
    tiles = {}
    for index in tile_indices(shape, tile):
        lengths = [block.stop - block.start for block in tile_block(shape, tile, index)]
        tiles[index] = {}
        for variable in variables(study):
            values = variable.empty(lengths)
            if variable.dtype == TEXT:
                values[...] = rng.choice(["", "FSB", "exponential", "naïve \N{GREEK SMALL LETTER OMEGA}"], lengths)
            else:
                values[...] = rng.integers(0, 2, lengths) if variable.dtype.kind in "ib" else rng.normal(size=lengths)
            tiles[index][variable.name] = values
    made = ZarrFiles(study, tile)
    first = made.first()
    for index, values in tiles.items():
        first |= made.chunks(index, values)
    assert first == as_zarr_writes(study, tile, tiles)


def test_what_is_missing_is_computed_and_nothing_else(tmp_path, cheap):
    stored(tmp_path / "a")
    before = files(tmp_path / "a")
    cheap.clear()
    stored(tmp_path / "a", resume=True, tile_runs=2)
    assert cheap == []
    for name in ("done/1.1.0", "finished"):
        (tmp_path / "a" / name).unlink()
    (tmp_path / "a" / "results.zarr" / "mean_velocity" / "c.1.1.0").write_bytes(b"torn")
    (tmp_path / "a" / "unfinished").mkdir()
    (tmp_path / "a" / "unfinished" / "host-1-2").write_bytes(b"left over")
    assert (open_study(tmp_path / "a")["status"] == 0).sum() > 0
    stored(tmp_path / "a", resume=True)
    assert sum(len(next(iter(over.values()))) for over in cheap) == 9
    assert files(tmp_path / "a") == before


def test_an_interrupted_study_says_how_it_goes_on(tmp_path):
    def stop(share):
        if share > 0.4:
            signal.raise_signal(signal.SIGINT)

    refused = pytest.raises(Stopped, match=r"Stopped: 2 of 6 tiles are stored in .*a; continue with --resume")
    with interrupts.heard(), refused:
        stored(tmp_path / "a", progress=stop)
    shares = []
    stored(tmp_path / "a", resume=True, progress=shares.append)
    stored(tmp_path / "b")
    assert files(tmp_path / "a") == files(tmp_path / "b")
    assert shares == sorted(shares)
    assert shares[0] == pytest.approx(2 / 6)
    assert shares[-1] == 1.0


def test_another_study_is_refused_and_its_store_untouched(tmp_path):
    stored(tmp_path / "a")
    before = files(tmp_path / "a")
    with pytest.raises(CaseError, match="--resume"):
        stored(tmp_path / "a")
    with pytest.raises(CaseError, match="periods: stored 40, asked 61") as caught:
        stored(tmp_path / "a", resume=True, measures=["drift"], periods=61)
    assert len(caught.value.complaints) == 2
    assert files(tmp_path / "a") == before


def test_folders_of_others_are_refused_and_untouched(tmp_path):
    notes, other = tmp_path / "notes.txt", tmp_path / "json"
    notes.write_text("mine")
    other.mkdir()
    (other / "study.json").write_text('{"format": "of something else"}')
    before = files(tmp_path)
    for out, said in ((tmp_path, "notes.txt"), (notes, "is a file"), (other, "another format")):
        for resume in (False, True):
            with pytest.raises(CaseError, match=said):
                stored(out, resume=resume)
    for path, said in ((tmp_path, "no study.json"), (tmp_path / "none", "no such folder"), (notes, "is a file")):
        with pytest.raises(CaseError, match=said):
            open_study(path)
    assert files(tmp_path) == before


def test_an_unfinished_beginning_is_begun_anew_and_nothing_else_is_removed(tmp_path, monkeypatch):
    stored(tmp_path / "a")
    with monkeypatch.context() as context:  # of another study, in the middle of its beginning
        context.setattr(places, "rename", lambda *_: (_ for _ in ()).throw(KeyboardInterrupt))
        with pytest.raises(KeyboardInterrupt):
            stored(tmp_path / "b", measures=("largest_angle",))
    assert (tmp_path / "b" / "results.zarr" / "largest_angle" / "zarr.json").exists()
    for name, said in (("results.zarr/notes", "notes"), ("results.zarr/status/zarr.json", "status/zarr.json")):
        before = (tmp_path / "b" / name).read_bytes() if name.endswith("json") else None
        (tmp_path / "b" / name).write_text("mine")
        there = files(tmp_path / "b")
        with pytest.raises(CaseError, match=rf"{said} does not belong to this study(.|\n)*nothing was touched"):
            stored(tmp_path / "b")
        assert files(tmp_path / "b") == there
        (tmp_path / "b" / name).unlink() if before is None else (tmp_path / "b" / name).write_bytes(before)
    stored(tmp_path / "b")
    (tmp_path / "empty").mkdir()
    stored(tmp_path / "empty", resume=True)
    assert files(tmp_path / "a") == files(tmp_path / "b") == files(tmp_path / "empty")
    assert not (tmp_path / "b" / "results.zarr" / "largest_angle").exists()


def test_a_folder_that_only_looks_like_a_beginning_is_left_alone(tmp_path):
    place = tmp_path / "results.zarr"
    place.mkdir()
    (place / "zarr.json").write_text("mine")
    for name in ("", "begun"):
        (tmp_path / "beginning").write_text(name)
        with pytest.raises(CaseError, match="its beginning is damaged"):
            stored(tmp_path)
        assert (place / "zarr.json").read_text() == "mine"


def test_one_writer_at_a_time(tmp_path):
    stored(tmp_path / "a")
    study = stored_study(tmp_path / "a")
    lock = opened_for_writing(tmp_path / "a", study, (1, 1, 1), resume=True).lock
    with pytest.raises(CaseError, match=rf"(process {os.getpid()} .*|another process) is writing there"):
        stored(tmp_path / "a", resume=True)
    assert len(open_study(tmp_path / "a")) == 8  # reading is free
    lock.release()
    stored(tmp_path / "a", resume=True)


class FullDisk:
    """A disk on which there is room for so many bytes."""

    def __init__(self, monkeypatch, room):
        self.room, self._write = room, os.write
        monkeypatch.setattr(os, "write", self.write)

    def write(self, handle, data):
        """Write what there is room for."""
        taken = bytes(data[: self.room])
        if data and not taken:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        self.room -= len(taken)
        return self._write(handle, taken)


@pytest.mark.parametrize(("start", "tiles"), [(0.01, 0), (0.5, 0), (0.99, 0), (1, 0.1), (1, 0.4), (1, 0.9)])
def test_a_full_disk_loses_nothing(tmp_path, monkeypatch, start, tiles):
    """Full while the store is begun, or while tiles are written."""
    stored(tmp_path / "a")
    whole = files(tmp_path / "a")
    of_a_tile = re.compile(r"results.zarr/\w+/c\.\d.*|done/.*")  # coordinates have a dot in their names
    of_tiles = sum(len(data) for name, data in whole.items() if of_a_tile.fullmatch(name))
    with monkeypatch.context() as context:
        FullDisk(context, int(start * (sum(map(len, whole.values())) - of_tiles) + tiles * of_tiles))
        with pytest.raises(StoreError, match=r"b: cannot be written: No space left on device.*--resume"):
            stored(tmp_path / "b")
    done = len(list((tmp_path / "b").glob("done/*")))
    assert 0 < done < 6 if tiles > 0.3 else done == 0
    if done:
        assert (open_study(tmp_path / "b").status != -1).sum() >= 3 * done
    stored(tmp_path / "b", resume=True)
    assert files(tmp_path / "b") == whole


def test_a_folder_that_cannot_be_written(tmp_path, monkeypatch):
    def refuse(path, *_, **__):
        raise PermissionError(errno.EACCES, os.strerror(errno.EACCES), str(path))

    monkeypatch.setattr(os, "mkdir", refuse)
    with pytest.raises(StoreError, match=r"a: cannot be written: Permission denied"):
        stored(tmp_path / "a")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.skipif(sys.platform != "linux", reason="looks into /proc")
def test_a_file_is_on_the_disk_before_it_has_its_name_and_a_mark_comes_last(tmp_path, monkeypatch):
    done = []
    replace = os.replace

    def path_of(handle, name=""):
        return f"{os.readlink(f'/proc/self/fd/{handle}')}{name and '/'}{name}"

    def replaced(old, new, **folders):
        done.append((path_of(folders["src_dir_fd"], old), path_of(folders["dst_dir_fd"], new)))
        replace(old, new, **folders)

    monkeypatch.setattr(os, "fsync", lambda handle: done.append(path_of(handle)))
    monkeypatch.setattr(os, "replace", replaced)
    stored(tmp_path / "a", tile_runs=1000)
    renamed = [i for i, what in enumerate(done) if isinstance(what, tuple)]
    assert all(done[i - 1] == done[i][0] for i in renamed if "unfinished" in done[i][0])  # forced, then renamed
    names = [str(Path(done[i][1]).relative_to(tmp_path / "a")) for i in renamed]
    last_chunk = max(i for i in renamed if "/c." in done[i][1])
    mark = next(i for i in renamed if "/done/" in done[i][1])
    begun = next(i for i in renamed if done[i][1].endswith("study.json"))
    folders = {str(Path(done[i][1]).parent) for i in renamed if "/c." in done[i][1] and i > begun}
    assert folders <= set(done[last_chunk + 1 : mark])
    assert names[-2].startswith("done/")
    assert names[-1] == "finished"
    assert len(folders) == 8
    beginning, *first = names[: names.index("study.json")]
    assert beginning == "beginning"
    assert first
    assert all(name.startswith("results.zarr/") for name in first)


def test_no_file_tells_the_time_or_the_machine(tmp_path):
    stored(tmp_path / "a")
    assert str(tmp_path).encode() not in b"".join(files(tmp_path / "a").values())
    record = read_record(tmp_path / "a")
    assert set(record) == {"format", "identity", "study", "tile", "files", "made_with"}
    assert set(record["made_with"]) == {"python", "zarr", "numcodecs"}
    text = json.loads((tmp_path / "a" / "study.json").read_text())
    assert text == record | {"checksum": text["checksum"]}
    passing = {places.UNFINISHED, places.BEGINNING, places.MIXED}
    assert {path.name for path in (tmp_path / "a").iterdir()} == places.FORM.keys() - passing
    assert (tmp_path / "a" / "lock").read_bytes() == b""
