"""Whatever is damaged in a store is found and named, computed again to the same bytes, and never taken for results."""

import importlib
import json
import os
import shutil
from pathlib import Path

import pytest

from cases import printed, refused
from stored_files import files
from vibrocap import Exponential, Harmonic, PendulumCapsule, System, verify_study
from vibrocap.case.case import CaseError
from vibrocap.cli.main import main
from vibrocap.studies.dataset import open_study
from vibrocap.studies.store.places import DamageWarning, StoreError
from vibrocap.studies.store.record import checksum
from vibrocap.studies.sweep import sweep

SYSTEM = System(PendulumCapsule(), Exponential(), Harmonic())
OVER = {"friction.law": "exponential,lugre", "machine.mass_ratio": "1:3:6"}
TILES = 6


pytestmark = pytest.mark.usefixtures("cheap")


def stored(out, **changes):
    return sweep(
        SYSTEM, **{"over": OVER, "measures": ("mean_velocity", "mode_sequence"), "out": out, "tile_runs": 2} | changes
    )


@pytest.fixture
def whole(tmp_path, tmp_path_factory):
    getbasetemp = tmp_path_factory.getbasetemp() / "whole-study"
    if not getbasetemp.exists():
        stored(getbasetemp)
    return Path(shutil.copytree(getbasetemp, tmp_path / "whole"))


def flip(path, at=-1):
    data = bytearray(path.read_bytes())
    data[at] ^= 1
    path.write_bytes(data)


def swap(one, other):
    first, second = one.read_bytes(), other.read_bytes()
    assert first != second
    one.write_bytes(second)
    other.write_bytes(first)


CHUNK = "results.zarr/mean_velocity/c.1.0"


def removed(name):
    return lambda study: (study / name).unlink()


def flipped(name, at):
    return lambda study: flip(study / name, at)


def a_folder(name):
    return lambda study: ((study / name).unlink(), (study / name).mkdir())


def copied(source, name):
    return lambda study: shutil.copy(study / source, study / name)


def swapped_tiles(study):
    for mark in [study / "done/1.0", *study.glob("results.zarr/*/c.1.0")]:
        other = mark.with_name(mark.name.replace("1.0", "0.2"))
        if mark.read_bytes() != other.read_bytes():
            swap(mark, other)


METADATA = "results.zarr/mode_sequence/zarr.json"
DAMAGE = {  # what is done to a store, and the tiles that are then damaged; none where it belongs to no tile
    "a chunk is removed": (removed(CHUNK), ["1.0"]),
    "a chunk is empty": (lambda study: (study / CHUNK).write_bytes(b""), ["1.0"]),
    "a bit of a chunk is flipped": (flipped(CHUNK, 12), ["1.0"]),
    "a chunk is a folder": (a_folder(CHUNK), ["1.0"]),
    "a chunk is that of another array": (
        copied("results.zarr/window_start/c.1.0", "results.zarr/status/c.1.0"), ["1.0"],
    ),
    "two whole tiles are swapped": (swapped_tiles, ["0.2", "1.0"]),
    "a mark is a folder": (a_folder("done/1.0"), ["1.0"]),
    "a mark is removed": (removed("done/1.0"), ["1.0"]),
    "a bit of a mark is flipped": (flipped("done/1.0", 30), ["1.0"]),
    "a mark is that of another tile": (copied("done/0.0", "done/1.0"), ["1.0"]),
    "metadata are removed": (removed(METADATA), []),
    "metadata are altered": (copied("results.zarr/mean_velocity/zarr.json", METADATA), []),
    "metadata are a folder": (a_folder(METADATA), []),
    "a coordinate is altered": (flipped("results.zarr/machine.mass_ratio/c.0", 12), []),
    "a coordinate is removed": (removed("results.zarr/friction.law/c.0"), []),
    "an array is removed": (lambda study: shutil.rmtree(study / "results.zarr/settled"), []),
    "all results are removed": (lambda study: shutil.rmtree(study / "results.zarr"), []),
    "all marks are removed": (lambda study: shutil.rmtree(study / "done"), []),
    "what says that it is finished is altered": (flipped("finished", 12), []),
    "a mark is of no tile": (copied("done/0.0", "done/7.0"), []),
}  # fmt: skip


@pytest.mark.parametrize("what", DAMAGE)
def test_damage_is_found_named_and_mended(whole, cheap, what, capsys):
    before = files(whole)
    damage, tiles = DAMAGE[what]
    damage(whole)
    study = verify_study(whole)
    assert not study.ok
    said = printed(capsys, "sweep", whole, "--verify", code=3)
    assert "damaged" in said
    if tiles:
        assert (study.tiles, study.stored) == (TILES, TILES - (what == "a mark is removed"))
        assert [".".join(map(str, index)) for index in study.damaged] == tiles
        assert f"damaged    tile {tiles[0]}: " in said
        with pytest.raises(StoreError, match=r"is damaged: tile .*--resume"):
            open_study(whole).load()
    cheap.clear()
    with pytest.warns(DamageWarning, match="whole: is damaged, and mended: " + (f"tile {tiles[0]}: " if tiles else "")):
        stored(whole, resume=True)
    assert not tiles or sum(len(next(iter(over.values()))) for over in cheap) == 2 * len(tiles)
    assert files(whole) == before
    assert verify_study(whole).finished


@pytest.mark.parametrize(
    "damage",
    [
        removed("study.json"),
        flipped("study.json", 40),
        lambda study: os.truncate(study / "study.json", 200),
        lambda study: (study / "study.json").write_text((study / "study.json").read_text().replace("1.4, ", "1.5, ")),
    ],
)
def test_a_lost_or_damaged_study_is_found_and_nothing_is_wiped(whole, damage, capsys):
    damage(whole)
    before = files(whole)
    assert not verify_study(whole).ok
    assert "study.json is" in verify_study(whole).lines()[0]
    printed(capsys, "sweep", whole, "--verify", code=3)
    for read in (open_study, lambda path: stored(path, resume=True), stored):
        with pytest.raises(CaseError, match=r"study\.json"):
            read(whole)
    assert files(whole) == before


def test_a_whole_store_and_none(tmp_path, whole, capsys):
    study = verify_study(whole)
    assert (study.ok, study.finished, study.stored, study.damaged, study.others) == (True, True, TILES, {}, ())
    assert f"whole: whole; {TILES} of {TILES} tiles are stored." in printed(capsys, "sweep", whole, "--verify")
    for name in ("finished", "done/0.1"):  # as if the study had been stopped before
        (whole / name).unlink()
    study = verify_study(whole)
    assert (study.ok, study.finished, study.stored) == (True, False, TILES - 1)
    printed(capsys, "sweep", whole, "--verify")
    for none in (tmp_path, tmp_path / "none"):
        refused(capsys, "sweep", none, "--verify")


def test_a_tile_without_a_mark_is_not_there_even_if_some_of_its_chunks_are(whole):
    (whole / "finished").unlink()
    (whole / "done" / "1.0").unlink()
    (whole / "results.zarr" / "mode_sequence" / "c.1.0").unlink()
    content = open_study(whole).load()
    assert (content.status[1, :2] == -1).all()
    assert content.mean_velocity[1, :2].isnull().all()
    assert (content.status[0] != -1).all()


def test_a_tile_of_another_study_is_damage_though_it_is_whole_with_its_mark(tmp_path, whole):
    """All of its files: only the identity in their checksums says that they are of another study."""
    stored(tmp_path / "other", over=OVER | {"machine.mass_ratio": "1:4:6"})
    own = [name for name in files(tmp_path / "other") if name.endswith(("/c.0.1", "done/0.1"))]
    assert len(own) > 4
    for name in own:
        shutil.copy(tmp_path / "other" / name, whole / name)
    assert list(verify_study(whole).damaged) == [(0, 1)]
    with pytest.raises(StoreError, match="is damaged: tile"):
        open_study(whole).load()
    parts = ("identity", "place", b"data"), ("another", "place", b"data"), ("identity", "other", b"data")
    assert len({checksum(*each) for each in (*parts, ("identity", "place", b"dato"))}) == 4


def removed_in_midrun(monkeypatch, at, act):
    """Do something to the folder when so many tiles have been asked for."""
    inner = importlib.import_module("vibrocap.measures.ensemble").ensemble
    calls = []

    def interfering(system, over, **settings):
        calls.append(over)
        if len(calls) == at:
            act()
        return inner(system, over, **settings)

    monkeypatch.setattr(importlib.import_module("vibrocap.measures.ensemble"), "ensemble", interfering)
    return calls


@pytest.mark.parametrize("what", ["", "results.zarr", "done", "results.zarr/mode_sequence"])
def test_a_folder_that_goes_away_in_midrun_is_noticed_at_the_next_tile(tmp_path, monkeypatch, what):
    out = tmp_path / "out"
    calls = removed_in_midrun(monkeypatch, 3, lambda: (out / what).rename(tmp_path / "away"))
    with pytest.raises(StoreError, match=r"removed or (changed|replaced) .*while the study ran"):
        stored(out)
    assert len(calls) <= 4  # a tile is computed while another is stored
    assert out.exists() == bool(what)


def test_a_chunk_that_goes_away_in_midrun_is_noticed_at_the_end(tmp_path, monkeypatch, capsys):
    out = tmp_path / "out"
    case = Path(__file__).parents[1] / "examples" / "travels-by-stick-slip.toml"
    removed_in_midrun(monkeypatch, 6, (out / "results.zarr" / "status" / "c.0").unlink)
    monkeypatch.setattr(importlib.import_module("vibrocap.studies.sweep"), "tile_runs_by_time", lambda *_: 1)
    assert main(["sweep", str(case), "--over", "machine.mass_ratio=1:3:8", "--out", str(out)]) == 3
    said = capsys.readouterr().err
    assert "files of 1 tiles are gone (0)" in said
    assert "whole" not in said


OTHER = {"version": "0.0.9", "sources": "f" * 64, "llvm": "15.0 of another"}


def test_a_study_is_not_gone_on_with_by_another_version_unless_asked(tmp_path, whole, monkeypatch, capsys):
    """As on another machine, with another version."""
    before = files(whole)
    for name in ("finished", "done/1.0", "done/1.2"):
        (whole / name).unlink()
    code = importlib.import_module("vibrocap.studies.plan.study").code_of
    monkeypatch.setattr(importlib.import_module("vibrocap.studies.sweep"), "code_of", lambda *what: code(*what) | OTHER)
    with pytest.raises(CaseError) as refusal:
        stored(whole, resume=True)
    said = "\n".join(refusal.value.complaints)
    for part in ("sources ffffffffffff", "llvm: stored ", "here 15.0 of another", "--mixed (mixed=True)"):
        assert part in said
    assert len(list((whole / "done").iterdir())) == TILES - 2
    assert "computed with other sources" in stored(whole, resume=True, mixed=True).attrs["mixed"]
    study = verify_study(whole)
    assert (study.mixed, study.finished) == (((1, 0), (1, 2)), True)
    assert "mixed      2 tiles" in printed(capsys, "sweep", whole, "--verify")
    made_by = json.loads((whole / "done" / "1.0").read_text())["made_by"]
    assert {name: made_by[name] for name in OTHER} == OTHER
    changed = {name for name, data in files(whole).items() if data != before.get(name)}
    assert changed == {"mixed", "done/1.0", "done/1.2"}
    with pytest.raises(CaseError, match="mixed: continues a stored study"):
        stored(tmp_path / "new", mixed=True)


# --- what is not ours is left alone -----------------------------------------------------------------------------------
def mine(folder):
    """Files of the user's."""
    place = folder / "mine"
    (place / "deep").mkdir(parents=True)
    for name in ("1.0", "9.9", "zarr.json", "thesis.txt", "deep/c.1.0"):
        (place / name).write_text(f"mine: {name}")
    return place


def linked(path, target):
    if path.is_dir():
        shutil.rmtree(path)
    path.unlink(missing_ok=True)
    path.symlink_to(target)


PLACES = (
    "done",
    "results.zarr",
    "unfinished",
    "results.zarr/mode_sequence",
    CHUNK,
    "done/1.0",
    "results.zarr/zarr.json",
)
PLACES += ("finished", "mixed", "lock", "beginning", "unfinished/host-1-2", "done/9.9", "study.json")


@pytest.mark.parametrize("place", PLACES)
@pytest.mark.parametrize("target", ["a folder", "nothing"])
def test_a_link_in_a_study_is_refused_and_what_it_leads_to_is_as_before(tmp_path, whole, place, target, capsys):
    users = mine(tmp_path)
    (whole / place).parent.mkdir(exist_ok=True)
    linked(whole / place, users / {"a folder": "", "a file": "thesis.txt", "nothing": "none"}[target])
    before, there = files(users), files(whole)
    with pytest.raises((CaseError, StoreError), match=place.split("/")[-1]):
        stored(whole, resume=True)
    with pytest.raises(CaseError):
        stored(whole)
    assert main(["sweep", str(whole), "--verify"]) in (2, 3)
    assert place.split("/")[-1] in "".join(capsys.readouterr())
    assert files(users) == before
    assert files(whole) == there


@pytest.mark.parametrize("place", ["done/notes.txt", "unfinished/notes.txt"])
def test_a_file_of_the_users_in_a_study_is_not_removed(whole, place):
    (whole / place).parent.mkdir(exist_ok=True)
    (whole / place).write_text("mine")
    with pytest.raises(CaseError, match=rf"{place} does not belong to the study(.|\n)*nothing was touched"):
        stored(whole, resume=True)
    assert (whole / place).read_text() == "mine"


@pytest.mark.parametrize("place", [CHUNK, "done/1.0", "results.zarr/mode_sequence/zarr.json"])
def test_a_folder_with_something_in_it_is_refused_by_its_name(whole, place):
    (whole / place).unlink()
    (whole / place).mkdir()
    (whole / place / "thesis.txt").write_text("mine")
    with pytest.raises(CaseError, match=rf"{place} is a folder with something in it"):
        stored(whole, resume=True)
    assert (whole / place / "thesis.txt").read_text() == "mine"


def test_a_second_name_of_a_file_is_not_written_through(tmp_path, whole):
    """What is mended is a new file; the other name keeps what it had."""
    users = mine(tmp_path)
    for place in (CHUNK, "results.zarr/zarr.json"):
        (whole / place).unlink()
        os.link(users / "thesis.txt", whole / place)
    before = files(users)
    with pytest.warns(DamageWarning):
        stored(whole, resume=True)
    assert files(users) == before


# --- what says what the arrays are ------------------------------------------------------------------------------------
def test_no_flipped_bit_of_what_says_what_arrays_are_is_read(whole):
    for name in ("zarr.json", "status/zarr.json"):
        path = whole / "results.zarr" / name
        data = path.read_bytes()
        for at in range(0, len(data), 29):
            flip(path, at)
            with pytest.raises((CaseError, StoreError)):
                open_study(whole)
            path.write_bytes(data)
    assert open_study(whole).sizes


def test_runs_that_were_never_made_are_not_read_as_finished(whole, capsys):
    """Whatever stands there for a run that was not made, and whether or not the checksums fit."""
    path = whole / "results.zarr" / "status" / "zarr.json"
    for name in ("finished", "done/1.0"):
        (whole / name).unlink()
    assert '"fill_value": -1' in path.read_text()
    path.write_text(path.read_text().replace('"fill_value": -1', '"fill_value": -0'))
    with pytest.raises(CaseError, match=r"status/zarr.json: fill_value should be -1"):
        open_study(whole)
    assert "Traceback" not in refused(capsys, "plot", whole)
