"""Work in forked processes, which share the imports of this one and may die, hang or fill their disk.

Nothing may touch Zarr before a fork: that would start a thread, which a fork does not take along.
"""

import ast
import builtins
import contextlib
import errno
import faulthandler
import io
import os
import select
import signal
import time
import traceback
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

CALLS = ("mkdir", "open", "write", "replace", "rename", "unlink", "rmdir", "fsync", "link", "symlink")
HANGS = 120.0  # s, after which a child says where it is, and ends
HUNG = 124  # what `ended` gives for a process that had to be stopped


def patience(seconds: float) -> float:
    """So many seconds of an idle machine: as many times more as processes wait for each of its processors."""
    return seconds * max(1.0, os.getloadavg()[0] / (os.cpu_count() or 1))


def child(work: Callable[[], Any], said: Path | None = None, hangs: float | None = HANGS) -> int:
    """Do some work in a process of its own; its process id. said: a file for what it writes to stderr."""
    process = os.fork()
    if process:
        return process
    code = 1
    try:
        if said is not None:
            handle = os.open(said, os.O_WRONLY | os.O_CREAT | os.O_TRUNC, 0o600)
            os.dup2(handle, 2)
        if hangs is not None:
            faulthandler.dump_traceback_later(patience(hangs), exit=True)
        code = work() or 0
    except BaseException:
        traceback.print_exc()
    finally:
        os._exit(code)


def ended(process: int, seconds: float = 150.0) -> int:
    """How a process ended: its exit code, minus the signal that ended it, or HUNG where it took longer."""
    begun = time.monotonic()
    pause = 0.0005
    while True:
        done, status = os.waitpid(process, os.WNOHANG)
        if done:
            return os.waitstatus_to_exitcode(status)
        if time.monotonic() - begun > patience(seconds):
            os.kill(process, signal.SIGKILL)
            os.waitpid(process, 0)
            return HUNG
        time.sleep(pause)
        pause = min(2 * pause, 0.02)


def answers(work: Callable[[int], str], number: int, seconds: float) -> Iterator[tuple[int, str]]:
    """What `work(0)`, `work(1)`, ... answer, done one after the other in a process that is replaced where it dies.

    Answers are "" for all is well; "hung" where one took longer than so many seconds of the processor (or eight times
    as long, of which it was given less), "died: ..." where the process ended.
    """
    at = 0
    while at < number:
        reading, writing = os.pipe()

        def serve(begin: int = at, writing: int = writing) -> None:
            for index in range(begin, number):
                os.write(writing, f"{work(index)[:2000]!r}\n".encode())

        process = child(serve, hangs=None)
        os.close(writing)
        with os.fdopen(reading, "rb") as pipe:
            while at < number:
                begun, ready = processor_seconds(process), False
                for _ in range(8):
                    ready = bool(select.select([pipe], [], [], seconds)[0])
                    if ready or processor_seconds(process) - begun > seconds:
                        break
                line = pipe.readline() if ready else b""
                if not line:
                    break
                yield at, ast.literal_eval(line.decode())
                at += 1
        if at < number:
            os.kill(process, signal.SIGKILL)
            code = ended(process)
            yield at, "hung" if not ready else f"died: {code}"
            at += 1
        else:
            os.kill(process, signal.SIGKILL)
            ended(process)


def processor_seconds(process: int) -> float:
    """How long a process has been computing; beyond measure where the system does not say."""
    try:
        words = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()
        return (int(words[11]) + int(words[12])) / os.sysconf("SC_CLK_TCK")
    except (OSError, ValueError, AttributeError):
        return time.monotonic()


def die() -> None:
    """As by kill -9."""
    os.kill(os.getpid(), signal.SIGKILL)


def full() -> None:
    """As by a disk that is full."""
    raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))


@contextlib.contextmanager
def changes(step: int, then: Callable[[], None], for_ever: bool = False) -> Iterator[list[int]]:
    """Within it, do something before (or in the middle of) call number `step` of those that change the disk.

    for_ever: and before all later ones that need room, too. Gives a list with the number of calls so far.
    """
    count = [0]

    def reached() -> bool:
        count[0] += 1
        return count[0] == step or (for_ever and count[0] > step)

    def hooked(name: str, original: Callable) -> Callable:
        def call(*given: Any, **others: Any) -> Any:
            if name == "open" and not (given[1] & (os.O_CREAT | os.O_WRONLY | os.O_RDWR)):
                return original(*given, **others)
            if name in ("unlink", "rmdir") and for_ever:
                return original(*given, **others)
            if reached():
                if name == "write" and count[0] == step:
                    original(given[0], bytes(given[1])[: len(given[1]) // 2])
                then()
            return None if name == "fsync" else original(*given, **others)  # a killed process loses nothing written

        return call

    class Counted(io.FileIO):
        def write(self, data: Any) -> int:
            if reached():
                if count[0] == step:
                    super().write(bytes(data)[: len(data) // 2])
                then()
            return super().write(data)

    opened = builtins.open

    def counted_open(file: Any, mode: str = "r", buffering: int = -1, *given: Any, **others: Any) -> Any:
        if isinstance(file, int) or "opener" in others or not set(mode) & set("wxa"):
            return opened(file, mode, buffering, *given, **others)
        raw = Counted(file, mode.replace("b", "").replace("t", ""))
        if buffering == 0:
            return raw
        buffered = io.BufferedRandom(raw) if "+" in mode else io.BufferedWriter(raw)
        return buffered if "b" in mode else io.TextIOWrapper(buffered, *given, **others)

    before = {name: getattr(os, name) for name in CALLS}
    for name, original in before.items():
        setattr(os, name, hooked(name, original))
    builtins.open = io.open = counted_open
    try:
        yield count
    finally:
        for name, original in before.items():
            setattr(os, name, original)
        builtins.open = io.open = opened


def tree(folder: Path) -> dict[str, bytes]:
    """Every file with its bytes."""
    return {path.relative_to(folder).as_posix(): path.read_bytes() for path in folder.rglob("*") if path.is_file()}
