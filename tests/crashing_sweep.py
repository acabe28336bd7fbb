"""Kill sweeps at chosen instants, resume them, compare the bytes: a program, run by `test_study_crashes.py`.

It imports everything once and then forks, so that a sweep and its death cost a tenth of a second. It must not touch
Zarr before it forks, but for importing it (that would start a thread).

    crashing_sweep.py FOLDER steps COUNT SEED     die before, or in the middle of, one of the calls that change the disk
    crashing_sweep.py FOLDER moments COUNT SEED   kill -9 from outside after a random time, several times in a row
"""

import importlib
import json
import os
import random
import shutil
import signal
import sys
import time
import traceback
from pathlib import Path

import cheap_ensemble
import vibrocap as vc
import vibrocap.studies.plan.study
import vibrocap.studies.store.store
import vibrocap.studies.sweep
from stored_files import files
from vibrocap.physics.catalogue import drives, laws, machines

importlib.import_module("vibrocap.measures.ensemble").ensemble = cheap_ensemble.ensemble
vibrocap.studies.plan.study.source_fingerprint()  # once: someone may be editing the sources
for imported_by_a_sweep in (
    *(
        "zarr",
        "xarray",
        "xarray.backends.zarr",
        "dask.array",
        "h5netcdf",
        "psutil",
        "vibrocap.numerics.compiler",
    ),
    "vibrocap.studies.store.chunks",
):
    importlib.import_module(imported_by_a_sweep)
machines(), laws(), drives()
os.fsync = lambda handle: None  # a killed process loses nothing that it wrote; only a power failure does

SYSTEM = vc.System(vc.PendulumCapsule(), vc.Exponential(), vc.Harmonic())
OVER = {"machine.mass_ratio": "1:3:7", "friction.law": "exponential,lugre", "machine.stiffness": "1:2:4"}
CALLS = ("mkdir", "open", "write", "replace", "unlink", "rmdir")


def study(out, tick=0.0):
    """The sweep that is to die; each tile takes at least `tick` seconds."""
    vibrocap.studies.sweep.sweep(
        SYSTEM,
        OVER,
        measures=("mean_velocity", "mode_sequence"),
        out=out,
        resume=True,
        tile_runs=8,
        progress=lambda share: time.sleep(tick),
    )


def child(work):
    """Do some work in a process of its own; its process id."""
    process = os.fork()
    if process:
        return process
    code = 1
    try:
        work()
        code = 0
    except BaseException:
        traceback.print_exc()
    finally:
        os._exit(code)


def ended(process):
    """How a process ended: its exit code, or minus the signal that ended it."""
    return os.waitstatus_to_exitcode(os.waitpid(process, 0)[1])


def dying(out, step, counter=None):
    """The sweep, which dies at its call number `step`; with a counter it lives and reports how many there are."""
    calls = 0

    def hooked(name, original):
        def call(*arguments, **others):
            nonlocal calls
            calls += 1
            if calls == step:
                if name == "write":
                    original(arguments[0], bytes(arguments[1])[: len(arguments[1]) // 2])
                os.kill(os.getpid(), signal.SIGKILL)
            return original(*arguments, **others)

        return call

    for name in CALLS:
        setattr(os, name, hooked(name, getattr(os, name)))
    study(out)
    if counter:
        counter.write_text(str(calls))


def by_steps(folder, count, seed):
    """Die at `count` calls, spread over all of them by chance but each only once, and resume."""
    assert ended(child(lambda: dying(folder / "whole", 0, folder / "calls"))) == 0
    total = int((folder / "calls").read_text())
    whole = files(folder / "whole")
    settings = {"instants": 0, "calls": total, "different": []}
    for step in sorted(random.Random(seed).sample(range(1, total + 1), min(count, total))):
        out = folder / "killed"
        shutil.rmtree(out, ignore_errors=True)
        assert ended(child(lambda step=step, out=out: dying(out, step))) == -signal.SIGKILL
        again = ended(child(lambda out=out: study(out)))
        settings["instants"] += 1
        if again or files(out) != whole:
            settings["different"].append(step)
    return settings


def by_moments(folder, count, seed):
    """Kill `count` times at random moments; a study is resumed until it ends, then another is begun."""
    begun = time.monotonic()
    assert ended(child(lambda: study(folder / "whole", 0.01))) == 0
    usual = time.monotonic() - begun
    whole = files(folder / "whole")
    chance = random.Random(seed)
    settings = {"instants": 0, "studies": 0, "different": []}
    while settings["instants"] < count:
        out = folder / "killed"
        shutil.rmtree(out, ignore_errors=True)
        while True:
            process = child(lambda out=out: study(out, 0.01))
            time.sleep(chance.uniform(0.0, 1.2 * usual))
            os.kill(process, signal.SIGKILL)
            code = ended(process)
            if code == 0:
                break
            assert code == -signal.SIGKILL
            settings["instants"] += 1
        settings["studies"] += 1
        if files(out) != whole:
            settings["different"].append(settings["studies"])
    return settings


if __name__ == "__main__":
    place, how, instants, chance_seed = sys.argv[1:]
    done = {"steps": by_steps, "moments": by_moments}[how](Path(place), int(instants), int(chance_seed))
    print(json.dumps(done))
