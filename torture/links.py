"""Links, and whatever else leads elsewhere, in every place of a study: nothing that is not its own is harmed.

In the place of each file and folder of a finished and of an unfinished study, and where there may be some, stands a
link to a file or a folder of the user's, one to nothing, to itself or to the folder above, a second name of a file
of the user's, a pipe, or a folder with a file of the user's. Then the study is verified, read, resumed and begun anew.
All that is the user's must be as it was; each of these must end, in words or with the study that it was.
"""

import os
import random
import shutil
import sys
import traceback
import warnings
from collections.abc import Callable
from pathlib import Path

import vibrocap as vc
from torture.children import HUNG, child, ended, tree
from torture.damage import same_runs
from torture.kills import SYSTEM, prepare, study
from torture.outcome import Outcome

MORE = (  # places that are not there in a whole study
    *("beginning", "mixed", "unfinished", "unfinished/host-1-2", "unfinished/notes", "done/9.9", "done/notes"),
    *("results.zarr/strange", "results.zarr/.zgroup", "results.zarr/status/c.9.9", "results.zarr/status/notes"),
)
UNFINISHED = ("done/1.0", "finished")  # what is removed of a whole study to have one that was stopped
KINDS: dict[str, Callable[[Path, Path], object]] = {
    "link to a file": lambda place, mine: place.symlink_to(mine / "thesis.txt"),
    "link to a folder": lambda place, mine: place.symlink_to(mine / "data"),
    "link to another study": lambda place, mine: place.symlink_to(mine / "study" / place.name),
    "link to nothing": lambda place, mine: place.symlink_to(mine / "not-there"),
    "link to itself": lambda place, mine: place.symlink_to(place.name),
    "link to the folder above": lambda place, mine: place.symlink_to(".."),
    "second name of a file": lambda place, mine: os.link(mine / "thesis.txt", place),
    "pipe": lambda place, mine: os.mkfifo(place),
    "folder with a file": lambda place, mine: (place.mkdir(), (place / "thesis.txt").write_text("mine too")),
    "file": lambda place, mine: place.write_text("mine too"),
}
REFUSALS = (vc.CaseError, OSError)  # a StoreError is an OSError


def users(folder: Path) -> Path:
    """Files of a user's, among them another study."""
    mine = folder / "mine"
    (mine / "data" / "deep").mkdir(parents=True)
    (mine / "thesis.txt").write_text("years of work")
    for name in ("0.0", "1.0", "c.1.0", "zarr.json", "host-1-2", "notes.txt"):
        (mine / "data" / name).write_text(f"mine: {name}")
        (mine / "data" / "deep" / name).write_text(f"mine: {name}")
    return mine


def all_of(folder: Path) -> dict[str, object]:
    """Every name below a folder, with what it is and holds."""
    return {
        path.relative_to(folder).as_posix(): os.readlink(path)
        if path.is_symlink()
        else path.read_bytes()
        if path.is_file()
        else path.stat().st_mode
        for path in folder.rglob("*")
    }


def put(place: Path, kind: str, mine: Path) -> None:
    """Something else in a place of a study."""
    if place.is_dir() and not place.is_symlink():
        shutil.rmtree(place)
    place.unlink(missing_ok=True)
    place.parent.mkdir(parents=True, exist_ok=True)
    KINDS[kind](place, mine)


def used(out: Path, whole: Path) -> str:
    """What is wrong with how a study is verified, read, resumed and begun anew; "" for nothing."""
    true = vc.open_study(whole).load()

    def read() -> None:
        assert same_runs(vc.open_study(out).load(), true), "other numbers"

    def begun() -> None:
        vc.sweep(SYSTEM, {"machine.mass_ratio": [1.0, 2.0]}, out=out)

    for name, work in (
        ("verified", lambda: vc.verify_study(out)),
        ("read", read),
        ("resumed", lambda: study("grid", out)),
        ("begun anew", begun),
    ):
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                work()
        except REFUSALS as error:
            if not str(error).strip():
                return f"{name}: refused without a word"
        except BaseException:
            return f"{name}: {traceback.format_exc()[-600:]}"
    return ""


def say(words: str) -> None:
    """To whoever waits for this process."""
    sys.stderr.write(words)
    sys.stderr.flush()


def links(folder: Path, trials: int, seed: int) -> Outcome:
    """So many of all places and kinds, by chance."""
    prepare()
    outcome, chance = Outcome("links"), random.Random(seed)
    whole, mine = folder / "whole", users(folder)
    assert ended(child(lambda: study("grid", whole) and None)) == 0
    shutil.copytree(whole, mine / "study")
    pristine, before = tree(whole), all_of(mine)
    places = sorted({path.relative_to(whole).as_posix() for path in whole.rglob("*")} | set(MORE))
    every = [(place, kind, stopped) for place in places for kind in KINDS for stopped in (False, True)]
    count, mended = len(every), 0
    for place, kind, stopped in chance.sample(every, min(trials, count)):
        out = folder / "study"
        shutil.rmtree(out, ignore_errors=True)
        shutil.copytree(whole, out)
        for name in UNFINISHED if stopped else ():
            (out / name).unlink()
        put(out / place, kind, mine)
        code = ended(child(lambda out=out: say(used(out, whole)), folder / "said"))
        fault = (folder / "said").read_text().strip()
        if code == HUNG or code < 0:
            fault = f"ended with {code}"
        elif all_of(mine) != before:
            fault = "files of the user are not as they were"
        elif kind == "folder with a file" and not (out / place / "thesis.txt").is_file():
            fault = "the folder of the user is gone"
        outcome.check(not fault, f"{kind} at {place}{', unfinished' if stopped else ''}: {fault}")
        mended += tree(out) == pristine
        if fault and all_of(mine) != before:
            break
    outcome.words = f"of {count:,} places and kinds; {mended} mended"
    return outcome
