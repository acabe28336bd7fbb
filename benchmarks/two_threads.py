"""What two threads gain on the named sweeps, beside what this machine has to give: two processes that share nothing.

Two virtual cores are often less than two cores: they may share one, its caches or its clock. Two processes at once,
each with a sweep of its own on one thread, show how much; what threads gain of that is the engine's.
"""

import statistics
import subprocess
import sys
import time
from collections.abc import Callable

from benchmarks.named_sweeps import INITIAL, every

ROUNDS = 15
PROGRAM = """
import sys
from benchmarks.named_sweeps import every
from benchmarks.sweep_vibrocap import prepare_sweep
run = prepare_sweep(sys.argv[1], every(1))
for _ in sys.stdin:
    run()
    print("done", flush=True)
"""


def timed(run: Callable[[], object]) -> float:
    """Seconds of a call."""
    before = time.perf_counter()
    run()
    return time.perf_counter() - before


def main() -> None:
    """Print the gain of two threads and of two processes over one, per law: medians of alternating runs."""
    from benchmarks.sweep_vibrocap import prepare_sweep

    print("\nTwo threads on the named sweeps: gain over one thread, and what two separate processes gain here")
    print(f"  {'':14s}{'threads':>9s}{'processes':>11s}{'share':>8s}")
    for law in INITIAL:
        one, two = prepare_sweep(law, every(1)), prepare_sweep(law, every(1), 2)
        command = [sys.executable, "-c", PROGRAM, law]
        with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, bufsize=1) as other:
            assert other.stdin is not None
            assert other.stdout is not None
            ask, answer = other.stdin, other.stdout

            def side_by_side(ask=ask, answer=answer, one=one) -> None:
                ask.write("go\n")
                one()
                answer.readline()

            side_by_side()
            times: list[tuple[float, float, float]] = []
            for _ in range(ROUNDS):
                times.append((timed(one), timed(two), timed(side_by_side)))
            ask.close()
        alone, threads, processes = (statistics.median(column) for column in zip(*times, strict=True))
        gain, limit = alone / threads, 2.0 * alone / processes
        print(f"  {law:14s}{gain:9.2f}{limit:11.2f}{gain / limit:8.0%}")


if __name__ == "__main__":
    main()
