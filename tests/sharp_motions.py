"""Motions with friction that changes sharply near rest, by an independent solver with a small largest step.

The equations are typed again here, the method is that of `independent.py`: SciPy's DOP853 with stick and slip switched
by hand. Where friction changes within a speed w, a dip of the speed towards zero lasts a time of about sqrt(w) over the
acceleration, so no step is longer than a quarter of that.

`python -m tests.sharp_motions` (from the root of the repository) writes tests/sharp_motions.json anew. Of each system
it keeps the state after PERIODS drive periods, the events, and how sensitive the motion is: what a shift of the start
by 1e-9 did to the final state, over 1e-9, or infinity where it changed the events.
"""

from __future__ import annotations

import json
import math
import random
from collections.abc import Callable
from pathlib import Path

import numpy as np

from tests.independent import accelerated, holding_force, moment, until_switch

TABLE = Path(__file__).with_suffix(".json")
PERIODS = 4
SYSTEMS = 300
LAWS = ("stribeck", "exponential", "tanh", "arctan", "lugre")
SHIFT = 1e-9


def random_system(seed: int) -> dict:
    """Laws by turns; two of three systems are oscillators on a belt, the others capsules."""
    draw = random.Random(seed)
    law = LAWS[seed % len(LAWS)]
    p: dict = {"law": law, "machine": "capsule" if seed // len(LAWS) % 3 == 2 else "oscillator"}
    p["coulomb"] = draw.uniform(0.1, 0.3)
    p["static"] = p["coulomb"] + draw.uniform(0.05, 0.3)
    if law == "stribeck":
        p["width"], p["exponent"] = 10 ** draw.uniform(-4.0, -2.0), draw.choice((1.0, 2.0, 2.0))
    elif law == "exponential":
        p["width"] = 10 ** draw.uniform(-4.0, -2.0)
    elif law in ("tanh", "arctan"):
        p["width"], p["stribeck"], p["exponent"] = 10 ** draw.uniform(-4.0, -2.0), draw.uniform(0.01, 0.1), 2.0
    else:
        p["width"], p["exponent"] = 1e-3, 2.0
        p["bristle_stiffness"], p["bristle_damping"] = 100.0, draw.uniform(0.5, 10.0)
    if p["machine"] == "oscillator":
        p |= {"damping": draw.uniform(0.0, 0.2), "belt": draw.uniform(0.2, 1.0)}
        p |= {"amplitude": draw.uniform(0.0, 1.0), "frequency": draw.uniform(0.3, 2.0)}
        start = [draw.uniform(-0.5, 0.5), draw.uniform(-1.0, 0.5)]
    else:
        p |= {
            "mass_ratio": draw.uniform(0.5, 5.0),
            "stiffness": draw.uniform(1.5, 4.0),
            "damping": draw.uniform(0.5, 1.5),
        }
        p |= {"normal_load": 1.0, "amplitude": draw.uniform(1.0, 2.5), "frequency": draw.uniform(0.6, 1.6)}
        start = [draw.uniform(-1.0, 1.0), 0.0, 0.0, draw.uniform(-0.5, 0.5)]
    return p | {"start": [*start, *([0.0] if law == "lugre" else [])]}


def friction(p: dict, v: float, side: int, bristle: float) -> tuple[float, float]:
    """(friction force, rate of the bristle) while sliding."""
    drop, w = p["static"] - p["coulomb"], p["width"]
    if p["law"] == "stribeck":
        return side * (p["coulomb"] + drop * math.exp(-((abs(v) / w) ** p["exponent"]))), 0.0
    if p["law"] == "exponential":
        beyond = min(50.0, -side * v / w)  # a trial step may look beyond rest, a motion never goes there
        return side * (p["coulomb"] + drop * math.exp(beyond)), 0.0
    if p["law"] in ("tanh", "arctan"):
        sign = math.tanh(v / w) if p["law"] == "tanh" else 2.0 / math.pi * math.atan(v / w)
        return sign * (p["coulomb"] + drop * math.exp(-((v * sign / p["stribeck"]) ** 2))), 0.0
    level = p["coulomb"] + drop * math.exp(-((v / w) ** 2))
    rate = v - p["bristle_stiffness"] * side * v * bristle / level
    return p["bristle_stiffness"] * bristle + p["bristle_damping"] * rate, rate


def rates(p: dict, t: float, y, side: int) -> list[float]:
    """y' of the oscillator (position, sliding velocity) or capsule (angle, angle rate, position, velocity), bristle."""
    mechanical = y[: 2 if p["machine"] == "oscillator" else 4]
    if side == 0:
        if p["machine"] == "oscillator":
            return [p["belt"], 0.0]
        return [y[1], moment(t, y, p), 0.0, 0.0]
    force, bristle_rate = friction(p, mechanical[-1], side, y[-1])
    if p["machine"] == "oscillator":
        found = [y[1] + p["belt"], outer(p, t, y) - force]
    else:
        found = accelerated(t, mechanical, p, force)
    return [*found, bristle_rate] if p["law"] == "lugre" else found


def outer(p: dict, t: float, y) -> float:
    """What holds a resting oscillator."""
    return p["amplitude"] * math.cos(p["frequency"] * t) - y[0] - p["damping"] * (y[1] + p["belt"])


def sharp_motion(p: dict, start: list[float], periods: int = PERIODS) -> tuple[list[float], list[tuple[float, str]]]:
    """(final state, events) of the motion from time 0."""
    place = 1 if p["machine"] == "oscillator" else 3
    sticks, smooth = p["law"] in ("stribeck", "exponential"), p["law"] in ("tanh", "arctan")
    hold: Callable = outer if p["machine"] == "oscillator" else lambda p, t, y: holding_force(t, y, p)
    end, longest = periods * 2.0 * math.pi / p["frequency"], 0.25 * math.sqrt(p["width"])
    t, y, events = 0.0, np.array(start, float), []

    def side_at_rest() -> int:
        force = hold(p, t, y)
        if sticks:
            return 0 if abs(force) < p["static"] else int(math.copysign(1, force))
        return int(math.copysign(1, rates(p, t, y, 1)[place]))

    side = int(math.copysign(1, y[place])) if y[place] != 0.0 else side_at_rest()
    while t < end:
        now = side

        def watched(time: float, state, side: int = now) -> float:
            if smooth:
                return 1.0
            return side * state[place] if side else p["static"] - abs(hold(p, time, state))

        t, y, switched = until_switch(
            lambda time, state, side=now: rates(p, time, state, side), watched, t, y, end, longest, 1e-13, 1e-14
        )
        if switched:
            if side == 0:
                side = int(math.copysign(1, hold(p, t, y)))
            else:
                y[place] = 0.0
                side = -side if not sticks else side_at_rest()
            kind = {0: "stick", 1: "slip_forward", -1: "slip_back"}[side]
            events.append((t, kind if sticks and 0 in (now, side) else "reversal"))
    return y.tolist(), events


def table_row(seed: int) -> dict:
    """A system with its motion and how sensitive that is."""
    p = random_system(seed)
    final, events = sharp_motion(p, p["start"])
    place = 1 if p["machine"] == "oscillator" else 3
    shifted = list(p["start"])
    shifted[place] += SHIFT
    shifted[0] += SHIFT
    other, other_events = sharp_motion(p, shifted)
    same = [kind for _, kind in events] == [kind for _, kind in other_events]
    growth = max(abs(a - b) for a, b in zip(final, other, strict=True)) / SHIFT
    return p | {"seed": seed, "final": final, "events": events, "growth": growth if same else None}


if __name__ == "__main__":
    import concurrent.futures
    import sys

    rows = {}
    with concurrent.futures.ProcessPoolExecutor(2) as pool:
        waiting = {pool.submit(table_row, seed): seed for seed in range(SYSTEMS)}
        for done in concurrent.futures.as_completed(waiting):
            try:
                rows[waiting[done]] = done.result()
            except (RuntimeError, OverflowError) as error:  # a motion that cannot be followed for certain
                print(f"seed {waiting[done]} left out: {error}", file=sys.stderr)
            lines = ",\n".join(json.dumps(rows[seed]) for seed in sorted(rows))
            TABLE.write_text(f'{{"periods": {PERIODS}, "systems": [\n{lines}\n]}}\n')
