"""Whatever a command could wait for without end: pipes and devices in each place of input, locks of stopped processes.

Each command must end soon, with a code and words that name the place; and with its results where only a cache or a
lock of another process was in the way.
"""

import contextlib
import fcntl
import io
import os
import random
import signal
import socket
import time
import warnings
from collections.abc import Callable, Iterator
from pathlib import Path

import vibrocap.inputs
from torture.children import HUNG, child, ended
from torture.full_disk import CASE
from torture.kills import prepare
from torture.outcome import Outcome
from vibrocap.cli.main import main
from vibrocap.numerics.compiler import cache

PATIENCE = 0.3  # s, in the place of those for which a pipe or a lock is waited for
TABLE = CASE.replace('"harmonic"', '"table"\nfile = "in.csv"')
LAW = ("fit", "--law", "coulomb")
PLACES: dict[str, tuple[str, ...]] = {  # a file that is read: a command that reads it
    "in.toml": ("simulate", "in.toml"),
    "in.csv": ("simulate", "table.toml"),
    "in.py": ("simulate", "case.toml", "--parts", "in.py"),
    "cases.csv": ("sweep", "case.toml", "--cases", "cases.csv", "--out", "map"),
    "motion.csv": ("simulate", "motion.csv"),
    "motion.nc": ("simulate", "motion.nc"),
    "study.nc": ("plot", "study.nc"),
    "record.csv": ("stick-slip", "record.csv"),
    "record.txt": (*LAW, "record.txt"),
    "record.npz": (*LAW, "record.npz"),
    "record.mat": (*LAW, "record.mat"),
    "in-orbit.toml": ("orbit", "in-orbit.toml"),
    "in-convert.toml": ("convert", "in-convert.toml"),
    "in-lab.toml": ("lab", "in-lab.toml", "--out", "lab.html"),
    "study.json": ("plot", "."),
    "study/lock": ("sweep", "case.toml", "--over", "machine.mass_ratio=1:2:2", "--out", "study"),
    "out.csv": ("simulate", "case.toml", "--out", "out.csv"),
    "out.nc": ("simulate", "case.toml", "--out", "out.nc"),
    "map": ("sweep", "case.toml", "--over", "machine.mass_ratio=1:2:2", "--out", "map"),
    "export.nc": ("sweep", "case.toml", "--over", "machine.mass_ratio=1:2:2", "--export", "export.nc"),
    "examples/mirror-twin.toml": ("examples", "mirror-twin", "--to", "examples"),
}
LOCKED = "held by a stopped process"


def _socket(path: Path) -> None:
    with contextlib.suppress(OSError), socket.socket(socket.AF_UNIX) as made:
        made.bind(path.name)


KINDS: dict[str, Callable[[Path], object]] = {
    "pipe": os.mkfifo,
    "link to a pipe": lambda path: (os.mkfifo(path.with_name("pipe")), path.symlink_to("pipe")),
    "device without end": lambda path: path.symlink_to("/dev/zero"),
    "empty device": lambda path: path.symlink_to("/dev/null"),
    "socket": _socket,
    "link to itself": lambda path: path.symlink_to(path.name),
    "folder": lambda path: (path.mkdir(), (path / "more").mkdir()),
}


def command(words: tuple[str, ...]) -> str:
    """Run one within the patience of this attack; "" or what is wrong with how it ended."""
    vibrocap.inputs.PATIENCE = PATIENCE
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err), warnings.catch_warnings():
        warnings.simplefilter("ignore")
        code = main(words)
    if code not in (0, 2, 3):
        return f"code {code}"
    return "" if code == 0 or err.getvalue().strip() else f"code {code} and no word"


def waits(folder: Path, trials: int, seed: int) -> Outcome:
    """So many of all places and kinds, by chance; and the locks."""
    prepare()
    outcome, chance = Outcome("waits"), random.Random(seed)
    every = [*((place, kind) for place in PLACES for kind in KINDS), *((name, LOCKED) for name in LOCKS)]
    for number, (place, kind) in enumerate(chance.sample(every, min(trials, len(every)))):
        there = folder / str(number)
        there.mkdir()
        (there / "case.toml").write_text(CASE)
        (there / "table.toml").write_text(TABLE)
        os.chdir(there)
        if kind == LOCKED:
            work = LOCKS[place]
        else:
            Path(place).parent.mkdir(exist_ok=True)
            KINDS[kind](Path(place))
            work = lambda place=place: command(PLACES[place])  # noqa: E731
        outcome.check(*judged(work, folder / "said", f"{kind} as {place}"))
    outcome.words = f"of {len(every)} places and kinds"
    return outcome


def judged(work: Callable[[], str], said: Path, what: str) -> tuple[bool, str]:
    """Whether some work ended soon and well, in a process of its own, and what is wrong otherwise."""

    def run() -> int:
        if fault := work():
            said.with_name("fault").write_text(fault)
        return 0

    said.with_name("fault").write_text("")
    code = ended(child(run, said), 60.0)
    fault = said.with_name("fault").read_text()
    if code == HUNG:
        fault = "hung"
    elif code:
        fault = f"ended with {code}: {said.read_text()[-400:]}"
    return not fault, f"{what}: {fault}"


@contextlib.contextmanager
def stopped(path: Path) -> Iterator[int]:
    """A process that holds the lock of a file and is stopped; its number."""

    def hold() -> None:
        handle = os.open(path, os.O_RDWR | os.O_CREAT, 0o600)
        fcntl.flock(handle, fcntl.LOCK_EX)
        path.with_name("held").touch()
        os.kill(os.getpid(), signal.SIGSTOP)

    process = child(hold, hangs=None)  # a watch over a child does not outlive another fork
    try:
        while not path.with_name("held").exists():
            time.sleep(0.01)
        os.waitpid(process, os.WUNTRACED)
        yield process
    finally:
        os.kill(process, signal.SIGKILL)
        os.waitpid(process, 0)


def study_locked() -> str:
    """The lock of a study: the sweep must say who holds it."""
    Path("map").mkdir()
    err = io.StringIO()
    with stopped(Path("map/lock").absolute()) as process, contextlib.redirect_stderr(err):
        Path("map/held").unlink()
        code = main(("sweep", "case.toml", "--over", "machine.mass_ratio=1:2:2", "--out", "map"))
    words = err.getvalue()
    return "" if code == 2 and f"process {process}" in words and "stopped" in words else f"code {code}: {words}"


def kernel_locked() -> str:
    """The lock of a kernel: it must be made anew, with a warning that says who holds it."""
    os.environ["VIBROCAP_CACHE"] = str(Path("cache").absolute())
    cache.folder.cache_clear()
    name = cache.key("torture")
    with stopped(cache.folder() / f".lock-{name[0]}") as process, warnings.catch_warnings(record=True) as found:
        warnings.simplefilter("always")
        with cache.one_process_at_a_time(name):
            pass
    words = " ".join(str(each.message) for each in found)
    return "" if f"process {process}" in words and "stopped" in words else f"no word of process {process}: {words}"


LOCKS = {"lock of a study": study_locked, "lock of a kernel": kernel_locked}
