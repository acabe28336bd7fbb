"""Killed before, or in the middle of, one of the calls that change the disk; then the same again, bit for bit.

Sweeps of a grid, of a design and of single cases are killed from the first folder made to the last mark, some of them
again while they resume; exports, also of adaptive maps, and pictures over an old file. A sweep must resume to the files
of one that was never interrupted; an export must be the old file or the new one at any time.
"""

import importlib
import random
import shutil
import signal
from collections.abc import Callable
from pathlib import Path

import cheap_ensemble
import vibrocap as vc
import vibrocap.io.motion_file
import vibrocap.io.netcdf
import vibrocap.io.study_file
import vibrocap.plotting.plot
import vibrocap.studies.adaptive
import vibrocap.studies.plan.study
import vibrocap.studies.sweep
from torture.children import changes, child, die, ended, tree
from torture.outcome import Outcome
from vibrocap.io.spreadsheets import beside
from vibrocap.physics.catalogue import drives, laws, machines

SYSTEM = vc.System(vc.PendulumCapsule(), vc.Exponential(), vc.Harmonic())
STUDIES = {
    "grid": {"over": {"machine.mass_ratio": "1:3:3", "friction.law": "exponential,lugre"}, "tile_runs": 2},
    "design": {
        "over": {"machine.mass_ratio": (1, 3), "initial.angle": (0, 1)},
        "design": vc.Design("random", 6),
        "tile_runs": 3,
    },
    "cases": {"cases": [{"friction.law": "lugre"}, {"machine.mass_ratio": 3.0}], "tile_runs": 1},
}
MEASURES = ("mean_velocity", "mode_sequence")


def prepare() -> None:
    """What all children share: the stand-in for the engine, and what is dear and always the same."""
    importlib.import_module("vibrocap.measures.ensemble").ensemble = cheap_ensemble.ensemble
    importlib.import_module("vibrocap.studies.adaptive").ensemble = cheap_ensemble.ensemble
    vibrocap.studies.plan.study.source_fingerprint()
    for name in (
        *("xarray", "xarray.backends.zarr", "h5netcdf", "zarr", "h5py", "scipy.stats.qmc", "dask.array", "psutil"),
        *("vibrocap.numerics.compiler", "vibrocap.studies.store.chunks"),
    ):
        importlib.import_module(name)
    machines(), laws(), drives()


def study(kind: str, out: Path | None):
    """A sweep into a folder, begun or resumed; without one, in memory."""
    stored = {} if out is None else {"out": out, "resume": True}
    asked = dict(STUDIES[kind]) if out is not None else {k: v for k, v in STUDIES[kind].items() if k != "tile_runs"}
    return vibrocap.studies.sweep.sweep(SYSTEM, measures=MEASURES, **asked, **stored)


def exports() -> dict[str, Callable[[Path], object]]:
    """What writes a file, by a name with its ending."""
    grid = study("grid", None)
    motion = vc.simulate(SYSTEM, periods=2)
    assert motion.certificate.ok  # made here: its threads do not come along to the children
    case = vibrocap.io.motion_file.Case(SYSTEM, periods=2)
    over = {"machine.mass_ratio": "1:3:5", "initial.angle": "0:1:5"}

    def mapped(path: Path) -> None:
        found = vibrocap.studies.adaptive.adaptive_map(SYSTEM, over, measures=MEASURES)
        vibrocap.io.study_file.write_study(found, path)

    def large(path: Path) -> None:
        """Not made in memory."""
        vibrocap.io.netcdf.IN_MEMORY = 0
        vibrocap.io.study_file.write_study(grid, path)

    return {
        "study.nc": lambda path: vibrocap.io.study_file.write_study(grid, path),
        "large.nc": large,
        "study.csv": lambda path: vibrocap.io.study_file.write_study(grid, path),
        "motion.nc": lambda path: vibrocap.io.motion_file.write_motion(motion, path, case),
        "motion.csv": lambda path: vibrocap.io.motion_file.write_motion(motion, path, case),
        "motion.png": lambda path: vibrocap.plotting.plot.figure(motion, path),
        "adaptive.nc": mapped,
        "adaptive.csv": mapped,
    }


def hurt(work: Callable[[], object], step: int, counter: Path | None = None) -> int:
    """Some work that dies at a call; with a counter it lives and says how many calls there are."""

    def run() -> None:
        with changes(step, die) as count:
            work()
        if counter is not None:
            counter.write_text(str(count[0]))

    return ended(child(run))


def kills(folder: Path, trials: int, seed: int) -> Outcome:
    """So many kills, two thirds of them of sweeps."""
    prepare()
    chance = random.Random(seed)
    outcome = Outcome("kills")
    found = exports()
    whole, calls = {}, {}
    for kind in STUDIES:
        out = folder / f"whole-{kind}"
        assert hurt(lambda kind=kind, out=out: study(kind, out), 0, folder / "calls") == 0
        whole[kind], calls[kind] = tree(out), int((folder / "calls").read_text())
    for name, write in found.items():
        path = folder / f"whole-{name}"
        assert hurt(lambda write=write, path=path: write(path), 0, folder / "calls") == 0
        whole[name], calls[name] = path.read_bytes(), int((folder / "calls").read_text())
    found["motion.png"](folder / "warm.png")  # fonts, once for all children
    while outcome.trials < trials:
        if chance.random() < 2 / 3:
            kill_sweep(folder / "killed", chance.choice(list(STUDIES)), chance, whole, calls, outcome)
        else:
            name = chance.choices(list(found), [1 if name.endswith(".png") else 6 for name in found])[0]
            kill_export(folder / "place" / name, found[name], chance.randint(1, calls[name]), whole[name], outcome)
    outcome.words = f"of {sum(calls.values())} calls that change the disk"
    return outcome


def kill_sweep(out: Path, kind: str, chance: random.Random, whole: dict, calls: dict, outcome: Outcome) -> None:
    """Kill a sweep, some of them twice, and resume it."""
    shutil.rmtree(out, ignore_errors=True)
    steps = [chance.randint(1, calls[kind])]
    if chance.random() < 0.3:
        steps.append(chance.randint(1, max(1, calls[kind] - steps[0])))
    for step in steps:
        code = hurt(lambda: study(kind, out), step)
        outcome.check(code in (0, -signal.SIGKILL), f"{kind} killed at {steps}: ended with {code}")
    code = ended(child(lambda: study(kind, out) and None))
    if code or tree(out) != whole[kind]:
        outcome.faults.append(f"{kind} killed at {steps}: resumed with {code} to other files")


def kill_export(path: Path, write: Callable[[Path], object], step: int, whole: bytes, outcome: Outcome) -> None:
    """Kill an export over an old file, and write it again."""
    shutil.rmtree(path.parent, ignore_errors=True)
    path.parent.mkdir()
    path.write_bytes(b"old")
    code = hurt(lambda: write(path), step)
    there = path.read_bytes()
    outcome.check(code == -signal.SIGKILL and there in (b"old", whole), f"{path.name} at {step}: {code}, half a file")
    shown = [each.name for each in path.parent.iterdir() if not each.name.startswith(".")]
    if not {path.name} <= {*shown} <= {path.name, beside(path).name}:
        outcome.faults.append(f"{path.name} at {step}: left {shown}")
    if ended(child(lambda: write(path) and None)) or path.read_bytes() != whole:
        outcome.faults.append(f"{path.name} at {step}: not the same when written again")
