"""The holder of a lock on a file, in words, where the system knows it."""

import os
import re
from pathlib import Path

STOPPED = "Tt"  # states of a process that was stopped, by a signal or a debugger


def holder(handle: int) -> int | None:
    """The number of the process that holds the lock (`flock`) of an open file; None where the system does not know
    it."""
    status = os.fstat(handle)
    device = f"{os.major(status.st_dev):02x}:{os.minor(status.st_dev):02x}" if hasattr(os, "major") else ""
    try:
        text = Path("/proc/locks").read_text(encoding="ascii")
    except (OSError, ValueError):
        return None
    for line in text.splitlines():
        match = re.match(r"\d+: FLOCK +\w+ +WRITE (\d+) ([0-9a-f]+:[0-9a-f]+):(\d+) ", line)
        if match and int(match[3]) == status.st_ino and match[2] == device and int(match[1]) > 0:
            return int(match[1])
    return None


def is_stopped(process: int | None) -> bool:
    """Whether a process was stopped, and waits until someone lets it continue."""
    try:
        return Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0] in STOPPED
    except (OSError, ValueError, IndexError):
        return False


def in_words(process: int | None) -> str:
    """A process with its command, and advice about a stopped one."""
    if process is None:
        return "another process"
    try:
        raw = Path(f"/proc/{process}/cmdline").read_bytes().replace(b"\0", b" ").strip()
    except OSError:
        raw = b""
    name = raw.decode(errors="replace")[:60]
    runs = f" ({name})" if name.isprintable() and name else ""
    stopped = f", which is stopped (`kill -CONT {process}` lets it continue)" if is_stopped(process) else ""
    return f"process {process}{runs}{stopped}"
