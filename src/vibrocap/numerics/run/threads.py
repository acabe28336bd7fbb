"""Work shared by threads: the one that calls takes part, so that two threads cost the start of one."""

import concurrent.futures
import os
import threading
from collections.abc import Callable


def available_threads() -> int:
    """Cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def share(work: Callable[[threading.Event], None], workers: int) -> None:
    """Call `work(stop)` on so many threads at once, this one among them, and return when all have ended.

    stop: set as soon as this thread is interrupted or its work has failed; work that sees it set returns early
    What a thread raises is raised here.
    """
    stop = threading.Event()
    if workers == 1:
        return work(stop)
    with concurrent.futures.ThreadPoolExecutor(workers) as pool:
        others = [pool.submit(work, stop) for _ in range(workers - 1)]
        try:
            work(stop)
            for other in others:
                other.result()
        finally:
            stop.set()
