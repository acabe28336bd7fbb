"""Memory and disk space of this computer, checked before work that would need more."""

import math
import os
import shutil
from pathlib import Path

_GROUPS = (  # (limit, use) of the memory of a container, by version of control groups
    ("/sys/fs/cgroup/memory.max", "/sys/fs/cgroup/memory.current"),
    ("/sys/fs/cgroup/memory/memory.limit_in_bytes", "/sys/fs/cgroup/memory/memory.usage_in_bytes"),
)
NEGLIGIBLE = 2.0**20  # bytes that any machine has: to ask what is free takes longer than a short motion
TELLING = 0.01  # share of the free memory from which the rest is foreseen: work may begin with an unusual part
KEPT, KEPT_PER_PERIOD = 2.0**29, 2.0**21  # bytes of a motion that are kept: in any case, and for each of its periods
EARLY = 0.25  # share of that from which the rest is foreseen


class TooMuchMemory(MemoryError):
    """Work that would need more memory than there is, or than is kept of it; `needed` and `available` in bytes."""

    def __init__(self, needed: float, available: float, said: str = "are free"):
        super().__init__(f"needs {in_words(needed)} of memory, {in_words(available)} {said}")
        self.needed, self.available, self.said = needed, available, said


def available_memory() -> float:
    """Bytes that this process may still take; infinite where the system does not know it."""
    memory = [math.inf]
    try:
        with open("/proc/meminfo", encoding="ascii") as file:
            lines = dict(line.split(":", 1) for line in file)
        memory.append(1024.0 * int(lines["MemAvailable"].split()[0]))
    except (OSError, ValueError, KeyError):
        pass
    for limit, use in _GROUPS:
        try:
            memory.append(float(int(Path(limit).read_text()) - int(Path(use).read_text())))
        except (OSError, ValueError):  # "max": there is no limit
            continue
    return max(0.0, min(memory))


def check_memory(needed: float, known: float = math.inf) -> None:
    """TooMuchMemory for more bytes than this process may still take.

    known: the bytes from which the need was foreseen; while they are few against what is free, nothing is refused
    """
    if needed < NEGLIGIBLE:
        return
    available = available_memory()
    if needed > available and known > TELLING * available:
        raise TooMuchMemory(needed, available)


def check_kept(held: float, share: float, periods: float) -> None:
    """TooMuchMemory for a motion of which far more would be kept than of any that its steps follow.

    held: bytes of the share of it that was run. A thousand steps a period take about a megabyte, and few motions take
    more; one that takes a million has a time scale that its steps should not have to follow.
    """
    allowed = KEPT + KEPT_PER_PERIOD * periods
    if held > EARLY * allowed and held > share * allowed:
        raise TooMuchMemory(held / share, allowed, f"at most are kept of {periods:g} periods")


def free_disk(path: Path) -> float:
    """Free bytes on the disk of a path; infinite where the system does not know it."""
    there = next((place for place in (path, *path.absolute().parents) if place.exists()), Path(os.curdir))
    try:
        return float(shutil.disk_usage(there).free)
    except OSError:
        return math.inf


def in_words(size: float) -> str:
    """Bytes in the unit that suits them."""
    for unit, length in (("TB", 1e12), ("GB", 1e9), ("MB", 1e6)):
        if size >= length:
            return f"{size / length:.3g} {unit}"
    return f"{size / 1e3:.3g} kB"
