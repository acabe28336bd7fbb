"""A short motion of every law on every machine, and how the plain kernel ends it: what a page has to compute.

`python tests/lab_motions.py` runs them all in plain Python, two minutes, and stores the ends in lab_motions.json; to be
done when the kernel rounds otherwise than before. What is not stored, such as a new machine, is run when it is asked.
"""

import hashlib
import itertools
import json
import struct
from pathlib import Path
from typing import Any

import vibrocap as vc
from vibrocap.arguments import ArgumentError
from vibrocap.lab.bundle import end_of
from vibrocap.physics.catalogue import laws, machines

STORE = Path(__file__).with_name("lab_motions.json")
# The kernels of machines of one row have the same statements besides the equations of each.
KINDS = {
    "one contact": (
        *("clutch", "double-pendulum-capsule", "drill-string", "mode-coupling-block", "oscillator"),
        *("pendulum-capsule", "rotor-capsule", "two-mass-capsule", "two-pendulum-capsule"),
    ),
    "stops": ("oscillator-with-stops", "pendulum-capsule-with-stops", "rigid-stop-capsule", "vibro-impact-capsule"),
    "several contacts": (
        "bristle-robot",
        "linkage-crawler",
        "three-block-row",
        "three-body-crawler",
        "two-block-row",
        "two-body-crawler",
    ),
    "imposed motion": ("feeder", "pendulum-crawler", "three-body-worm", "two-body-worm", "two-mass-crawler"),
}


def motions(kind: str) -> dict[str, vc.Case]:
    """A case of each law on a machine: two periods and a half, from a push where there is room for one."""
    machine = machines()[kind]()
    first = machine.states[0]
    push = {} if first in machine.room() or first == machine.cyclic else {first: 0.3}
    table = {}
    for name, law in laws().items():
        try:
            system = vc.System(machine, law(), vc.Harmonic(amplitude=1.8))
        except ArgumentError:  # a machine that does not take the law
            continue
        table[name] = vc.Case(system, push, periods=2.5)
    return table


def motions_of_a_kind(kind: str) -> dict[tuple[str, str], vc.Case]:
    """Each law on one machine of a kind, in turn; each machine meets a law that sticks and one with internal states."""
    order = ("set-valued", "kinked", "smooth")
    names = sorted(laws(), key=lambda name: order.index(laws()[name].kind))
    return {(machine, name): motions(machine)[name] for machine, name in zip(itertools.cycle(KINDS[kind]), names)}


def ending(state: list[float], pieces: int, events: int, status: int) -> str:
    """An end in a few signs, which differ where a bit of the state does."""
    bits = struct.pack(f"<{len(state)}d", *(value + 0.0 for value in state))
    return f"{pieces} pieces, {events} events, status {status}, {hashlib.sha256(bits).hexdigest()[:16]}"


def plain(case: vc.Case) -> str:
    """The end by the plain kernel."""
    return ending(**end_of(case))


def stored() -> dict[str, dict[str, str]]:
    """Ends by machine and law."""
    content: dict[str, Any] = json.loads(STORE.read_text(encoding="utf-8")) if STORE.is_file() else {}
    return content


if __name__ == "__main__":
    ends = {kind: {name: plain(case) for name, case in motions(kind).items()} for kind in machines()}
    STORE.write_text(json.dumps(ends, indent=1) + "\n", encoding="utf-8")
