"""A disk that is full from one call on: the command ends with code 3 and says so, and what was there before is whole.

Where the first look at the folder finds it full, before any work, it is refused with code 2.
"""

import contextlib
import os
import random
import shutil
from pathlib import Path

from torture.children import changes, child, ended, full, tree
from torture.kills import prepare
from torture.outcome import Outcome
from vibrocap.cli.main import main
from vibrocap.cli.terminal import INCOMPLETE, WRONG_INPUT

CASE = """[machine]
kind = "pendulum-capsule"
[friction]
law = "exponential"
[drive]
waveform = "harmonic"
[run]
periods = 2
"""
SWEEP = ("sweep", "case.toml", "--over", "machine.mass_ratio=1:3:6", "--periods", "20")
COMMANDS = {
    "sweep": (*SWEEP, "--resume", "--out", "map"),
    "sweep.nc": (*SWEEP, "--export", "sweep.nc"),
    "sweep.csv": (*SWEEP, "--export", "sweep.csv"),
    "motion.nc": ("simulate", "case.toml", "--out", "motion.nc"),
    "motion.csv": ("simulate", "case.toml", "--out", "motion.csv"),
    "motion.svg": ("simulate", "case.toml", "--plot", "motion.svg"),
}


def full_disk(folder: Path, trials: int, seed: int) -> Outcome:
    """So many points at which the disk is full, over the commands that write."""
    prepare()
    os.chdir(folder)
    Path("case.toml").write_text(CASE)
    outcome, chance = Outcome("full disk"), random.Random(seed)
    with open(os.devnull, "w") as nowhere, contextlib.redirect_stdout(nowhere):
        main(COMMANDS["motion.svg"])  # what is dear and always the same
    whole, calls = {}, {}

    def run(name: str, step: int = 0) -> int:
        with (
            open(os.devnull, "w") as nowhere,
            contextlib.redirect_stdout(nowhere),
            changes(step or 10**9, full, for_ever=True) as count,
        ):
            code = main(COMMANDS[name])
        if not step:
            Path("calls").write_text(str(count[0]))
        return code

    for name in COMMANDS:
        assert ended(child(lambda name=name: run(name))) == 0, name
        calls[name] = int(Path("calls").read_text())
        whole[name] = content(Path("map" if name == "sweep" else name))
        remove(name)
    while outcome.trials < trials:
        name = list(COMMANDS)[outcome.trials % len(COMMANDS)]
        place = Path("map" if name == "sweep" else name)
        step = chance.randint(1, calls[name])
        if name != "sweep":
            place.write_bytes(b"old")
        code = ended(child(lambda name=name, step=step: run(name, step), Path("said")))
        words = Path("said").read_text()
        good = code in (INCOMPLETE, WRONG_INPUT) and "No space left" in words and "Traceback" not in words
        good |= code == 0 and name != "sweep" and content(place) == whole[name]  # full when no room was needed any more
        kept = code == 0 or name == "sweep" or place.read_bytes() == b"old"
        code_again = ended(child(lambda name=name: run(name)))
        again = code_again == 0 and content(place) == whole[name]
        outcome.check(good and kept and again, f"{name} at {step}: {code} {kept} {code_again} {again} {words[-300:]}")
        remove(name)
    outcome.words = f"of {sum(calls.values())} calls"
    return outcome


def content(place: Path) -> object:
    """The bytes of a file, or of all files in a folder."""
    return tree(place) if place.is_dir() else place.read_bytes()


def remove(name: str) -> None:
    """What a command wrote."""
    if name == "sweep":
        shutil.rmtree("map", ignore_errors=True)
    else:
        Path(name).unlink(missing_ok=True)
