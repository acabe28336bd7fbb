"""`python -m torture [--share 0.02] [--seed 1] [--only kills]`: the attacks, and a table of what they found.

Each attack makes all of its trials, however long they take here. The exit code is 1 where a promise was broken.
"""

import argparse
import contextlib
import importlib
import os
import pickle
import sys
import tempfile
import time
from pathlib import Path

from torture.outcome import Outcome

# attack: its module and function, trials
ATTACKS = {
    "kills": ("kills", 1000),
    "links": ("links", 400),
    "settings": ("settings", 42),
    "waits": ("waits", 149),
    "fuzzed commands": ("fuzz_commands", 3000),
    "fuzzed cases": ("fuzz_cases", 10_000),
    "full disk": ("full_disk", 50),
    "damage": ("damage", 31),
    "pairs": ("pairs", 600),
}
PROCESSES = 2  # at a time


def attack(name: str, folder: Path, trials: int, seed: int) -> Outcome:
    """Carry out an attack; what it could not carry out is a fault too."""
    module = ATTACKS[name][0]
    began = time.monotonic()
    try:
        outcome = getattr(importlib.import_module(f"torture.{module}"), module)(folder, trials, seed)
    except BaseException as error:
        outcome = Outcome(name, faults=[f"the attack itself failed: {type(error).__name__}: {error}"])
    if outcome.trials < trials:
        outcome.faults.append(f"only {outcome.trials:,} of {trials:,} trials")
    outcome.words += f"; {time.monotonic() - began:.0f} s"
    return outcome


def main() -> int:
    """Run the attacks, some at a time, each in a process of its own."""
    parser = argparse.ArgumentParser(prog="python -m torture", description=__doc__)
    parser.add_argument("--share", type=float, default=1.0, help="of the trials")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", choices=ATTACKS, action="append", help="this attack; may be repeated")
    given = parser.parse_args()
    waiting, running, found = list(given.only or ATTACKS), {}, {}
    with tempfile.TemporaryDirectory(prefix="torture-") as place:
        while waiting or running:
            while waiting and len(running) < PROCESSES:
                name = waiting.pop(0)
                folder = Path(place, name.replace(" ", "-"))
                folder.mkdir()
                trials = max(1, round(ATTACKS[name][1] * given.share))
                running[start(name, folder, trials, given.seed)] = (name, folder)
            process, _ = os.wait()
            name, folder = running.pop(process)
            answer = Outcome(name, faults=["the attack itself died"])
            with contextlib.suppress(OSError, EOFError):
                answer = pickle.loads((folder / "outcome").read_bytes())
            found[name] = answer
            print(line(name, answer), flush=True)
            for fault in answer.faults[:20]:
                print(f"  {name}: {fault}", file=sys.stderr, flush=True)
    return 1 if any(outcome.faults for outcome in found.values()) else 0


def start(name: str, folder: Path, trials: int, seed: int) -> int:
    """Begin an attack; the id of its process."""
    process = os.fork()
    if not process:
        with (folder / "said").open("w") as said:
            os.dup2(said.fileno(), 1)
            os.dup2(said.fileno(), 2)
            outcome = attack(name, folder, trials, seed)
            (folder / "outcome").write_bytes(pickle.dumps(outcome))
            os._exit(0)
    return process


def line(name: str, outcome: Outcome) -> str:
    """A row of the table."""
    return f"{name:<16} {outcome.trials:>7,} trials {len(outcome.faults):>4} faults   {outcome.words}"


if __name__ == "__main__":
    sys.exit(main())
