"""Damage to what is kept: a study, or compiled kernels. Each kind must be found, and mended or refused.

Of a study `verify` must say so, reading it must give the true numbers or none, and the sweep that resumes it must make
the files of one that was never damaged, or refuse and touch nothing. A damaged kernel must be made anew.
"""

import itertools
import json
import os
import pickle
import random
import shutil
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

import vibrocap as vc
from torture.children import HUNG, child, ended, tree
from torture.kills import prepare, study
from torture.outcome import Outcome
from vibrocap.numerics.compiler import cache

MEAN, WORD = "results.zarr/mean_velocity/c.1.0", "results.zarr/mode_sequence/c.1.0"
GROUP, ARRAY, MARK = "results.zarr/zarr.json", "results.zarr/mean_velocity/zarr.json", "done/1.0"


def cut(path: Path, chance: random.Random) -> None:
    """The end is lost, as on a disk that lied."""
    path.write_bytes(path.read_bytes()[: chance.randrange(path.stat().st_size)])


def flip(path: Path, chance: random.Random) -> None:
    """One bit is another."""
    data = bytearray(path.read_bytes())
    data[chance.randrange(len(data))] ^= 1 << chance.randrange(8)
    path.write_bytes(data)


def zeros(path: Path, chance: random.Random) -> None:
    """A block that was never written."""
    path.write_bytes(bytes(path.stat().st_size))


def swap(one: Path, other: Path) -> None:
    """Two files in each other's place."""
    data = one.read_bytes()
    one.write_bytes(other.read_bytes())
    other.write_bytes(data)


def edit(path: Path, change: Callable[[dict[str, Any]], Any]) -> None:
    """A file of JSON with another content."""
    record = json.loads(path.read_text())
    change(record)
    path.write_text(json.dumps(record))


class Runs:
    """An object whose pickle runs code."""

    def __reduce__(self):
        return os.mkdir, (os.environ["TORTURE_RAN"],)


def pickled(folder: Path) -> None:
    """Zarr format 2 with an object array that is unpickled, in place of the results."""
    place = folder / "results.zarr"
    shutil.rmtree(place)
    (place / "status").mkdir(parents=True)
    (place / ".zgroup").write_text('{"zarr_format": 2}')
    entries = {"zarr_format": 2, "shape": [1], "chunks": [1], "dtype": "|O", "compressor": None, "fill_value": None}
    entries |= {"order": "C", "filters": [{"id": "pickle", "protocol": 4}]}
    (place / "status" / ".zarray").write_text(json.dumps(entries))
    (place / "status" / "0").write_bytes(pickle.dumps(Runs()))


def to_link(path: Path) -> None:
    """A link to a file elsewhere that holds the same."""
    away = path.parents[3] / f"away-{path.name}"
    shutil.copy(path, away)
    path.unlink()
    path.symlink_to(away)


# what is damaged: how, given the folder of a study and chance
STUDY: dict[str, Callable[[Path, random.Random], Any]] = {
    "a chunk is removed": lambda d, c: (d / MEAN).unlink(),
    "a chunk is cut short": lambda d, c: cut(d / MEAN, c),
    "a chunk is empty": lambda d, c: (d / MEAN).write_bytes(b""),
    "a bit of a chunk is flipped": lambda d, c: flip(d / MEAN, c),
    "a bit of words is flipped": lambda d, c: flip(d / WORD, c),
    "a chunk is all zeros": lambda d, c: zeros(d / MEAN, c),
    "chunks of two tiles are swapped": lambda d, c: swap(d / MEAN, d / MEAN.replace("1.0", "2.0")),
    "chunks of two variables are swapped": lambda d, c: swap(
        d / MEAN.replace("mean_velocity", "window_start"), d / MEAN.replace("mean_velocity", "window_periods")
    ),
    "a chunk is a folder": lambda d, c: ((d / MEAN).unlink(), (d / MEAN).mkdir()),
    "a chunk is a link": lambda d, c: to_link(d / MEAN),
    "all chunks of a variable are removed": lambda d, c: [p.unlink() for p in (d / WORD).parent.glob("c.*")],
    "a mark is cut short": lambda d, c: cut(d / MARK, c),
    "a bit of a mark is flipped": lambda d, c: flip(d / MARK, c),
    "two marks are swapped": lambda d, c: swap(d / MARK, d / "done/2.0"),
    "a mark of no tile": lambda d, c: (d / "done/9.9").write_bytes((d / MARK).read_bytes()),
    "the marks are removed": lambda d, c: shutil.rmtree(d / "done"),
    "the results are removed": lambda d, c: shutil.rmtree(d / "results.zarr"),
    "the values of an axis are flipped": lambda d, c: flip(d / "results.zarr/machine.mass_ratio/c.0", c),
    "the group is cut short": lambda d, c: cut(d / GROUP, c),
    "an array says another type": lambda d, c: edit(d / ARRAY, lambda r: r.update(data_type="float32")),
    "an array says another shape": lambda d, c: edit(d / ARRAY, lambda r: r.update(shape=[10**9, 10**9])),
    "an array asks for a codec of its own": lambda d, c: edit(
        d / ARRAY, lambda r: r["codecs"].append({"name": "numcodecs.pickle", "configuration": {}})
    ),
    "a pickle that runs code": lambda d, c: pickled(d),
    "study.json is removed": lambda d, c: (d / "study.json").unlink(),
    "study.json is cut short": lambda d, c: cut(d / "study.json", c),
    "a bit of study.json is flipped": lambda d, c: flip(d / "study.json", c),
}
# of a compiled kernel, given its file
KERNEL: dict[str, Callable[[Path, random.Random], Any]] = {
    "a kernel is cut short": cut,
    "a bit of a kernel is flipped": flip,
    "code is added to a kernel": lambda path, c: path.write_bytes(path.read_bytes() + b"\x90" * 64),
    "a kernel is a link": lambda path, c: (
        path.rename(path.with_suffix(".away")),
        path.symlink_to(path.with_suffix(".away")),
    ),
    "others may write a kernel": lambda path, c: (flip(path, c), path.chmod(0o666)),
}
REFUSALS = ("CaseError", "StoreError", "DamagedRecord")


def damage(folder: Path, trials: int, seed: int) -> Outcome:
    """Each kind of damage, again and again with other bits while there are trials."""
    prepare()
    os.environ["TORTURE_RAN"] = str(folder / "ran")
    whole, outcome, chance = folder / "whole", Outcome("damage"), random.Random(seed)
    assert ended(child(lambda: study("grid", whole) and None)) == 0
    kinds = [*STUDY, *KERNEL]
    mended = refused = 0
    for kind in itertools.islice(itertools.cycle(kinds), 2 * trials):
        if outcome.trials >= trials:
            break
        if kind in KERNEL:
            good = kernel_mends(folder / "kernels", KERNEL[kind], chance)
            outcome.check(good, f"{kind}: was used")
            mended += good
            continue
        out = folder / "damaged"
        shutil.rmtree(out, ignore_errors=True)
        shutil.copytree(whole, out)
        STUDY[kind](out, chance)
        before, pristine = files_or_folders(out), tree(whole)
        if files_or_folders(out) == files_or_folders(whole):
            continue  # cut at its end: nothing was damaged
        seen = ended(child(lambda out=out: vc.verify_study(out).ok and 77, folder / "said"))
        read = ended(child(lambda out=out, whole=whole: reads_the_same(out, whole), folder / "said"))
        code = ended(child(lambda out=out: study("grid", out) and None, folder / "said"))
        words = (folder / "said").read_text()
        is_mended = code == 0 and tree(out) == pristine
        is_refused = code != 0 and any(error in words for error in REFUSALS) and keeps(before, files_or_folders(out))
        fault = ""
        if HUNG in (seen, read, code):
            fault = "hung"
        elif seen == 77:
            fault = "verify found it whole"
        elif read == 78:
            fault = "read as other numbers"
        elif not is_mended and not is_refused:
            fault = f"resumed with {code}, neither mended nor refused: {words[-200:]}"
        elif (folder / "ran").exists():
            fault = "code was run"
        outcome.check(not fault, f"{kind}: {fault}")
        mended, refused = mended + is_mended, refused + is_refused
    outcome.words = f"{len(kinds)} kinds; {mended} mended, {refused} refused"
    return outcome


def files_or_folders(folder: Path) -> dict[str, bytes]:
    """What a folder holds, but for the lock."""
    return {
        p.relative_to(folder).as_posix(): b"link" if p.is_symlink() else p.read_bytes() if p.is_file() else b"folder"
        for p in folder.rglob("*")
        if p.name not in ("lock", "unfinished")
    }


def keeps(before: dict[str, bytes], after: dict[str, bytes]) -> bool:
    """Whether all is as it was, but for marks of tiles that were let go."""
    return all(after.get(name) == data for name, data in before.items() if not name.startswith("done/"))


def reads_the_same(out: Path, whole: Path) -> int:
    """78 where a damaged study is read as whole, with other numbers; runs that are not stored are missing."""
    try:
        found = vc.open_study(out).load()
    except (ValueError, OSError):
        return 0
    return 0 if same_runs(found, vc.open_study(whole).load()) else 78


def same_runs(found: Any, true: Any) -> bool:
    """Whether the runs that are there are those of a whole study."""
    there = (found["status"] != -1).values
    return set(found.variables) == set(true.variables) and all(
        np.array_equal(found[name].values[there], true[name].values[there], equal_nan=true[name].dtype.kind == "f")
        for name in (*true.data_vars, "status")
    )


def kernel_mends(place: Path, hurt: Callable[[Path, random.Random], Any], chance: random.Random) -> bool:
    """Whether a damaged kernel is not used, and another stands in its place after it is made anew."""
    shutil.rmtree(place, ignore_errors=True)
    before = os.environ.get("VIBROCAP_CACHE")
    os.environ["VIBROCAP_CACHE"] = str(place)
    cache.folder.cache_clear()
    try:
        name, code = cache.key("torture"), bytes(range(256)) * 20
        cache.keep(name, code)
        assert cache.kept(name) == code
        hurt(place / (name + cache.SUFFIX), chance)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            found = cache.kept(name)
            cache.keep(name, code)
        return found is None and cache.kept(name) == code
    finally:
        if before is None:
            del os.environ["VIBROCAP_CACHE"]
        else:
            os.environ["VIBROCAP_CACHE"] = before
        cache.folder.cache_clear()
