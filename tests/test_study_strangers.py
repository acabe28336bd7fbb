"""A study may come from a stranger: nothing in it runs, and what this package does not write is refused."""

import json
import os
import shutil
from pathlib import Path

import pytest

from cases import refused
from systems import capsule
from test_study_integrity import stored
from vibrocap import Measure, open_study, verify_study, write_study
from vibrocap.case.case import CaseError, case_from_text
from vibrocap.cli.main import main
from vibrocap.studies.store import places
from vibrocap.studies.store.chunks import unpacked_size
from vibrocap.studies.store.places import Lock
from vibrocap.studies.store.record import checksum, chunk_place, mark_text, record_text, sealed
from vibrocap.studies.store.zarr_form import first_places
from vibrocap.studies.sweep import sweep

IN_SI = Path(__file__).parents[1] / "examples" / "bench-in-si.toml"


pytestmark = pytest.mark.usefixtures("cheap")


@pytest.fixture
def study(tmp_path, tmp_path_factory):
    getbasetemp = tmp_path_factory.getbasetemp() / "study-of-strangers"
    if not getbasetemp.exists():
        stored(getbasetemp, tile_runs=20)
    return Path(shutil.copytree(getbasetemp, tmp_path / "study"))


def record_of(study):
    record = json.loads((study / "study.json").read_text())
    del record["checksum"]
    return record


def rewrite(study, record):
    """What a stranger can do: all checksums fit what he wrote."""
    for place in first_places(record):
        if (study / "results.zarr" / place).is_file():
            data = (study / "results.zarr" / place).read_bytes()
            record["files"][place] = checksum(record["identity"], place, data)
    (study / "study.json").write_bytes(record_text(record))


def rechunk(study, name, data):
    """Put a chunk of one's own in the first tile, with a mark that fits it."""
    record, index = record_of(study), (0, 0)
    (study / "results.zarr" / chunk_place(name, index)).write_bytes(data)
    names = json.loads((study / "done" / "0.0").read_text())["chunks"]
    chunks = {
        chunk_place(name, index): (study / "results.zarr" / chunk_place(name, index)).read_bytes() for name in names
    }
    (study / "done" / "0.0").write_bytes(mark_text(record["identity"], index, chunks, None))


def refused_everywhere(study, capsys, said):
    """Reading, plotting, verifying, exporting and resuming all refuse, without a traceback."""
    for read in (open_study, verify_study, lambda path: write_study(path, path.with_suffix(".csv"))):
        with pytest.raises(CaseError, match=said):
            read(study)
    with pytest.raises(CaseError, match=said):
        stored(study, tile_runs=20, resume=True)
    assert main(["plot", str(study)]) == 2
    assert main(["sweep", str(study), "--verify"]) == 2
    assert "Traceback" not in capsys.readouterr().err


def changed(name, **entries):
    """An alteration of an array's metadata."""

    def alter(study):
        path = study / "results.zarr" / name / "zarr.json"
        path.write_text(json.dumps(json.loads(path.read_text()) | entries))

    return alter


BYTES = {"name": "bytes", "configuration": {"endian": "little"}}
GZIP = {"name": "gzip", "configuration": {"level": 5}}
WILD = {"name": "zstd", "configuration": {"level": 3000, "checksum": True}}
HUGE = {"name": "regular", "configuration": {"chunk_shape": [2, 10**15]}}
METADATA = {
    "another codec": (changed("mean_velocity", codecs=[BYTES, GZIP]), "codecs"),
    "a wild setting": (changed("mean_velocity", codecs=[BYTES, WILD]), "codecs"),
    "another type": (changed("mean_velocity", data_type="object"), "data_type"),
    "a type that is not its own": (changed("settled", data_type="int8", fill_value=0), "data_type"),
    "enormous chunks": (changed("mode_sequence", chunk_grid=HUGE), "chunk_shape"),
    "an enormous array": (changed("mode_sequence", shape=[2, 10**15]), "shape"),
    "other dimensions": (changed("mode_sequence", dimension_names=["x", "y"]), "dimension_names"),
    "an unknown key": (changed("mode_sequence", must_understand=True), "must_understand"),
    "an attribute that changes values": (changed("mean_velocity", attributes={"scale_factor": 2.0}), "scale_factor"),
    "an attribute that is made up": (changed("mean_velocity", attributes={"add_offset": 2.0}), "add_offset"),
    "a factor of what has none": (changed("status", attributes={"scale_factor": 2.0}), "scale_factor"),
    "another unit": (changed("mean_velocity", attributes={"units": "mm/s"}), "units should be '1'"),
    "an infinite filling": (changed("status", fill_value=10**9), "fill_value"),
    "deep nesting": (
        lambda study: (study / "results.zarr/mode_sequence/zarr.json").write_text('{"a":' * 20_000 + "}" * 20_000),
        "zarr.json",
    ),
    "an array more": (
        lambda study: shutil.copytree(study / "results.zarr/mode_sequence", study / "results.zarr/more"),
        "results.zarr/more does not belong",
    ),
    "format 2 beside it": (lambda study: (study / "results.zarr/.zmetadata").write_text("{}"), "does not belong"),
}


@pytest.mark.parametrize("what", METADATA)
def test_metadata_that_this_package_does_not_write_are_refused(study, what, capsys):
    alter, said = METADATA[what]
    alter(study)
    rewrite(study, record_of(study))
    refused_everywhere(study, capsys, said)


@pytest.fixture
def in_si(tmp_path):
    """A stored study of a case in SI, with a measure of its own."""
    power = Measure.largest("power", "largest power of friction", lambda now: now.velocity, "1", "m/s")
    system = case_from_text(IN_SI.read_text(encoding="utf-8")).system
    over = {"friction.coulomb_coefficient": [0.05, 0.1]}
    sweep(system, over=over, measures=("mean_velocity", "mode_sequence", power), out=tmp_path / "si")
    return tmp_path / "si"


def test_factors_that_follow_from_the_scales_of_the_case_are_read(in_si):
    content = open_study(in_si).load()
    speed = 9.80665**0.5 * 0.25**0.5
    for name in ("mean_velocity", "power"):
        assert content[name].attrs["units"] == "m/s"
        assert content[name].attrs["dimensionless_unit"] == pytest.approx(speed, rel=1e-15)
    assert verify_study(in_si).ok


@pytest.mark.parametrize("name", ["mean_velocity", "power"])
@pytest.mark.parametrize(
    ("key", "value"), [("scale_factor", 2.0), ("scale_factor", None), ("dimensionless_unit", 1.5), ("units", "mm/s")]
)
def test_factors_and_units_of_another_case_are_refused(in_si, capsys, name, key, value):
    path = in_si / "results.zarr" / name / "zarr.json"
    array = json.loads(path.read_text())
    attributes = {k: v for k, v in (array["attributes"] | {key: value}).items() if v is not None}
    path.write_text(json.dumps(array | {"attributes": attributes}))
    rewrite(in_si, record_of(in_si))
    for read in (open_study, verify_study):
        with pytest.raises(CaseError, match=f"{name}/zarr.json: {key} should be .* by the case of the study, got"):
            read(in_si)
    refused(capsys, "plot", in_si)


def test_factors_are_refused_where_the_case_cannot_be_read(in_si):
    """As that of a law which is not loaded."""
    record = record_of(in_si)
    record["study"]["case"] = record["study"]["case"].replace('law = "exponential"', 'law = "elsewhere"')
    assert "elsewhere" in record["study"]["case"]
    rewrite(in_si, record)
    with pytest.raises(CaseError, match=r"scale_factor cannot be compared with the case of the study: .*elsewhere"):
        open_study(in_si)


def in_record(path, value):
    """An alteration of study.json."""

    def alter(record):
        *way, last = path
        for step in way:
            record = record[step]
        record[last] = value

    return alter


RECORDS = {
    "a name that leaves the folder": in_record(("study", "measures"), ["mean_velocity", "../../mode_sequence"]),
    "a path that leaves the folder": in_record(("study", "plan", "axes", 0, "path"), "../x.y"),
    "a name twice": in_record(("study", "measures"), ["mode_sequence", "mode_sequence"]),
    "no axes": in_record(("study", "plan", "axes"), []),
    "an unknown plan": in_record(("study", "plan"), {"kind": "pickle"}),
    "a word for a number": in_record(("tile",), ["x", 1]),
    "tiles of another shape": in_record(("tile",), [2]),
    "enormous tiles": in_record(("tile",), [2, 10**12]),
    "no tiles": in_record(("tile",), [0, 0]),
    "a truth for a number": in_record(("study", "plan", "axes", 1, "values", 0), True),
    "a further entry": in_record(("study", "more"), 1),
    "endless runs": in_record(
        ("study", "plan"),
        {
            "kind": "design",
            "design": {"kind": "sobol", "runs": 2**60, "seed": 0},
            "ranges": [{"path": "machine.mass_ratio", "low": 1.0, "high": 2.0, "logarithmic": False}],
        },
    ),
}


@pytest.mark.parametrize("what", RECORDS)
def test_a_record_that_this_package_does_not_write_is_refused(study, what, capsys):
    record = record_of(study)
    RECORDS[what](record)
    (study / "study.json").write_bytes(sealed(record, record["identity"], "study.json"))
    refused_everywhere(study, capsys, r"study\.json: |tiles")


def zstd_frame(size):
    """A Zstandard frame that says it holds so many zeros, and does so in one block of repetition."""
    head = b"\x28\xb5\x2f\xfd\xe0" + size.to_bytes(8, "little")
    return head + (1 | 1 << 1 | min(size, 2**17) << 3).to_bytes(3, "little") + b"\0"


@pytest.mark.parametrize("name", ["mean_velocity", "mode_sequence"])
@pytest.mark.parametrize("data", [b"", b"no frame", zstd_frame(2**40), zstd_frame(8)])
def test_a_chunk_that_unpacks_to_something_else_is_refused_before_it_is_unpacked(study, name, data, capsys):
    rechunk(study, name, data)
    with pytest.raises(OSError, match=rf"{name} is no array of 12 values"):
        open_study(study).load()
    assert main(["plot", str(study), "--measure", name]) == 3
    said = capsys.readouterr().err
    assert "Traceback" not in said
    assert "is no array of 12 values" in said


def test_the_size_in_a_frame():
    from numcodecs.zstd import Zstd

    for size in (0, 1, 255, 256, 257, 65_791, 65_792, 10**6):
        assert unpacked_size(Zstd(level=3, checksum=True).encode(bytes(size))) == size
    assert unpacked_size(zstd_frame(2**40)) == 2**40


@pytest.mark.parametrize("name", ["a\0b", "a\ud800b"])
def test_a_name_that_no_file_can_have_is_an_error_of_the_file_system(name, tmp_path):
    for way in (places.kind, places.names, places.make_folder, places.remove):
        for root, place in ((tmp_path, f"{name}/x"), (tmp_path, name), (tmp_path / name, "x")):
            with pytest.raises(OSError, match="no name of a file") as caught:
                way(root, place)
            assert caught.value.errno in places.STRANGE
    with pytest.raises(places.StoreError, match="no name of a file"):
        sweep(capsule(), {"machine.mass_ratio": [1.0, 2.0]}, periods=2, out=tmp_path / name)


@pytest.mark.skipif(not places._BY_HANDLE, reason="folders are not reached by handles here")
@pytest.mark.parametrize("work", ["read", "read below", "write below", "names", "remove below", "lock"])
def test_a_link_that_comes_between_a_look_and_the_opening_is_not_followed(work, tmp_path, monkeypatch):
    """Who may write the folder puts it there at the worst instant: just before the file, or its folder, is opened."""
    study, mine = tmp_path / "study", tmp_path / "mine"
    (study / "done").mkdir(parents=True)
    mine.mkdir()
    for folder in (study / "done", mine):
        (folder / "0.0").write_bytes(b"mine" if folder == mine else b"theirs")
    (study / "lock").touch()
    name, target = {"read": ("0.0", mine / "0.0"), "lock": ("lock", mine / "new")}.get(work, ("done", mine))
    place = study / "done" / "0.0" if name == "0.0" else study / name
    opened = os.open

    def raced(path, *given, **others):
        if os.path.basename(path) == name and not place.is_symlink():
            place.rename(tmp_path / "away")
            place.symlink_to(target)
        return opened(path, *given, **others)

    monkeypatch.setattr(os, "open", raced)
    with pytest.raises(OSError, match=r"symbolic|directory") as caught:
        {
            "read": lambda: places.read_plain(study, "done/0.0", 100),
            "read below": lambda: places.read_plain(study, "done/0.0", 100),
            "write below": lambda: places.write(study, {"done/0.0": b"overwritten"}),
            "names": lambda: places.names(study, "done"),
            "remove below": lambda: places.remove(study, "done/0.0"),
            "lock": lambda: Lock(study / "lock"),
        }[work]()
    assert caught.value.errno in places.STRANGE
    assert place.is_symlink()
    assert {path.name: path.read_bytes() for path in mine.iterdir()} == {"0.0": b"mine"}
