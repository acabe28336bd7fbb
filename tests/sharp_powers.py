"""Motions with friction that changes sharply near rest like any power of the speed, by an independent solver.

The equations are typed again from docs/model.md. The method is Hairer's DOP853 (SciPy's tableau) with a local error of
at most 1e-15, without interpolation: an event is found by repeating the last step with other lengths, so that it is as
exact as the step, and the end of the step is the event. No step

- is longer than a quarter of sqrt(w), for which a dip of the speed to within the law's own speed w lasts,
- changes the velocity by more than half of itself, or of w where it is slower: |v|^alpha has no Taylor series at rest.

`python -m tests.sharp_powers` (from the root of the repository) writes tests/sharp_powers.json anew: of each system the
states at the start of each drive period and at the end, the events, and how sensitive it is: by how much a shift of any
state at the start by 1e-9 moves any state later, over 1e-9. It takes a minute with numba (`pip install -e '.[ref]'`),
half an hour without.
"""

from __future__ import annotations

import json
import math
import random
import sys
from pathlib import Path

import numpy as np
from scipy.integrate._ivp import dop853_coefficients as tableau

try:
    from numba import njit
except ImportError:

    def njit(function):
        """Plain Python."""
        return function


TABLE = Path(__file__).with_suffix(".json")
# Of issue 24: seeds of oscillators whose law is given another exponent and speed.
EXAMPLES = ((13, 1.5, 1.2e-4), (200004, 3.0, 2.5e-4), (100000, 6.0, 7e-4))
PERIODS = 4
SYSTEMS = 200
SHIFT = 1e-9
LAWS = ("stribeck", "exponential", "hyperbolic", "tanh", "arctan", "smoothed", "lugre")
STRIBECK, EXPONENTIAL, HYPERBOLIC, TANH, ARCTAN, SMOOTHED, LUGRE = range(7)
MACHINES = ("oscillator", "capsule")
NAMES = (
    *("law", "machine", "coulomb", "static", "width", "exponent", "stribeck", "bristle_stiffness", "bristle_damping"),
    *("mass_ratio", "stiffness", "damping", "amplitude", "frequency", "belt"),
)
LAW, MACHINE, COULOMB, STATIC, WIDTH, EXPONENT, DROOP, SIGMA0, SIGMA1 = range(9)
MASS_RATIO, STIFFNESS, DAMPING, AMPLITUDE, FREQUENCY, BELT = range(9, 15)
STATES = 5  # four of the machine (the oscillator has two), the bristle last
STAGES = 12
A, B, C = (np.ascontiguousarray(each[:STAGES]) for each in (tableau.A[:, :STAGES], tableau.B, tableau.C))
E3, E5 = np.ascontiguousarray(tableau.E3[:STAGES]), np.ascontiguousarray(tableau.E5[:STAGES])
LOCAL_ERROR = 1e-15
CLOSE = 2e-16
MOST_EVENTS = 2_000


def random_system(seed: int) -> tuple[np.ndarray, np.ndarray]:
    """(parameters by NAMES, state at the start)."""
    draw, p = random.Random(seed), np.zeros(len(NAMES))
    law = draw.choices(range(7), (80, 20, 16, 30, 20, 14, 20))[0]
    p[LAW], p[MACHINE] = law, float(draw.random() < 0.34)
    p[COULOMB] = draw.uniform(0.1, 0.3)
    p[STATIC] = p[COULOMB] + draw.uniform(0.05, 0.3)
    p[WIDTH] = 10 ** draw.uniform(-4.0, -2.0) if law != LUGRE else 1e-3
    p[DROOP] = 10 ** draw.uniform(-3.0, -1.0) if law in (TANH, ARCTAN, SMOOTHED) else p[WIDTH]
    p[EXPONENT] = draw.choice((draw.uniform(1.0, 8.0), draw.uniform(1.05, 3.0), draw.uniform(1.05, 3.0), 0.0))
    if law in (EXPONENTIAL, HYPERBOLIC):
        p[EXPONENT] = 1.0
    elif p[EXPONENT] == 0.0:
        p[EXPONENT] = float(draw.choice((1, 2, 3, 6) if law == STRIBECK else (2, 3)))
    if law == LUGRE:
        p[SIGMA0], p[SIGMA1] = 100.0, draw.uniform(0.5, 10.0)
    y = np.zeros(STATES)
    if p[MACHINE] == 0.0:
        p[DAMPING], p[BELT] = draw.uniform(0.0, 0.2), draw.uniform(0.2, 1.0)
        p[AMPLITUDE], p[FREQUENCY] = draw.uniform(0.0, 1.0), draw.uniform(0.3, 2.0)
        y[0], y[1] = draw.uniform(-0.5, 0.5), draw.uniform(-1.0, 0.5)
    else:
        p[MASS_RATIO], p[STIFFNESS] = draw.uniform(0.5, 5.0), draw.uniform(1.5, 4.0)
        p[DAMPING] = draw.uniform(0.5, 1.5)
        p[AMPLITUDE], p[FREQUENCY] = draw.uniform(1.0, 2.5), draw.uniform(0.6, 1.6)
        y[0], y[3] = draw.uniform(-1.0, 1.0), draw.uniform(-0.5, 0.5)
    return p, y


def kept(p: np.ndarray) -> list[int]:
    """Which of the STATES the system has."""
    return [*range(2 if p[MACHINE] == 0.0 else 4), *([4] if p[LAW] == LUGRE else [])]


@njit
def friction(p, v, side, bristle):
    """(friction force, rate of the bristle) while sliding."""
    law, low, drop = p[LAW], p[COULOMB], p[STATIC] - p[COULOMB]
    if law in (TANH, ARCTAN):
        sign = math.tanh(v / p[WIDTH]) if law == TANH else 2.0 / math.pi * math.atan(v / p[WIDTH])
        return sign * (low + drop * math.exp(-((v * sign / p[DROOP]) ** p[EXPONENT]))), 0.0
    if law == HYPERBOLIC:
        return side * (low + drop / (1.0 + abs(v) / p[WIDTH])), 0.0
    level = low + drop * math.exp(-((abs(v) / p[DROOP]) ** p[EXPONENT]))
    if law == SMOOTHED:
        return math.tanh(v / p[WIDTH]) * level, 0.0
    if law == LUGRE:
        rate = v - p[SIGMA0] * side * v * bristle / level
        return p[SIGMA0] * bristle + p[SIGMA1] * rate, rate
    return side * level, 0.0


@njit
def moment(p, t, y):
    """P of docs/model.md."""
    return p[AMPLITUDE] * math.cos(p[FREQUENCY] * t) + math.sin(y[0]) - p[STIFFNESS] * y[0] - p[DAMPING] * y[1]


@njit
def holding_force(p, t, y):
    """The friction force that would keep a resting contact at rest."""
    if p[MACHINE] == 0.0:
        return p[AMPLITUDE] * math.cos(p[FREQUENCY] * t) - y[0] - p[DAMPING] * (y[1] + p[BELT])
    return math.cos(y[0]) * moment(p, t, y) - math.sin(y[0]) * y[1] * y[1]


@njit
def rates(p, t, y, side, out):
    """y' of the oscillator (position, sliding velocity) or capsule (angle, angle rate, position, velocity), bristle."""
    place = 1 if p[MACHINE] == 0.0 else 3
    force, out[4] = friction(p, y[place], side, y[4])
    if p[MACHINE] == 0.0:
        out[0] = y[1] + p[BELT]
        out[1] = holding_force(p, t, y) - force if side != 0.0 else 0.0
        return
    turning, total = moment(p, t, y), p[MASS_RATIO] + 1.0
    out[0], out[1], out[2], out[3] = y[1], turning, y[3], 0.0
    if side != 0.0:
        sine, cosine = math.sin(y[0]), math.cos(y[0])
        inertia = total - cosine * cosine
        out[1] = (total * turning - sine * cosine * y[1] * y[1] - force * cosine) / inertia
        out[3] = (cosine * turning - sine * y[1] * y[1] - force) / inertia


@njit
def step(p, t, y, side, h, k, point, change):
    """Write the change of the state over a step of length h; returns its error, over LOCAL_ERROR."""
    k[:] = 0.0
    for stage in range(STAGES):
        for i in range(STATES):
            total = 0.0
            for j in range(stage):
                total += A[stage, j] * k[j, i]
            point[i] = y[i] + h * total
        rates(p, t + C[stage] * h, point, side, k[stage])
    five = three = 0.0
    for i in range(STATES):
        total = third = fifth = 0.0
        for stage in range(STAGES):
            total += B[stage] * k[stage, i]
            third += E3[stage] * k[stage, i]
            fifth += E5[stage] * k[stage, i]
        change[i] = h * total
        five += (fifth / LOCAL_ERROR) ** 2
        three += (third / LOCAL_ERROR) ** 2
    return h * five / math.sqrt((five + 0.01 * three) * STATES) if five + three > 0.0 else 0.0


@njit
def spare(p, t, y, side):
    """Positive while the contact slides to its side, or holds."""
    if side != 0.0:
        return side * y[1 if p[MACHINE] == 0.0 else 3]
    return p[STATIC] - abs(holding_force(p, t, y))


@njit
def falling(p, t, y, side, slope):
    """Slope of `spare`."""
    rates(p, t, y, side, slope)
    d = 1e-6
    return (spare(p, t + d, y + d * slope, side) - spare(p, t - d, y - d * slope, side)) / (2.0 * d)


@njit
def first_below(p, t, y, side, h, k, point, change, slope):
    """A time within the step at which `spare` is not positive, or -1: at its end, or at the least value within."""
    step(p, t, y, side, h, k, point, change)
    if spare(p, t + h, y + change, side) <= 0.0:
        return h
    steep = falling(p, t, y, side, slope)
    if steep >= 0.0 or falling(p, t + h, y + change, side, slope) <= 0.0:
        return -1.0
    low, high = 0.0, h
    while high - low > 1e-15:
        middle = 0.5 * (low + high)
        step(p, t, y, side, middle, k, point, change)
        value = spare(p, t + middle, y + change, side)
        if value <= 0.0:
            return middle
        if value > 10.0 * abs(steep) * (high - low) + 1e-18:
            return -1.0
        if falling(p, t + middle, y + change, side, slope) < 0.0:
            low = middle
        else:
            high = middle
    return -1.0


@njit
def event_time(p, t, y, side, below, k, point, change):
    """Where in the step `spare` falls to zero, by the Illinois method on steps; not positive at `below`."""
    low, high, least = 0.0, below, spare(p, t, y, side)
    while least <= 0.0:  # a step from rest
        low = 0.5 * (low if low > 0.0 else below)
        step(p, t, y, side, low, k, point, change)
        least = spare(p, t + low, y + change, side)
    step(p, t, y, side, high, k, point, change)
    most, kept_end = spare(p, t + high, y + change, side), 0
    for number in range(200):
        middle = (low * most - high * least) / (most - least) if most != least else 0.5 * (low + high)
        if number % 4 == 3 or not (low < middle < high):
            middle = 0.5 * (low + high)
        step(p, t, y, side, middle, k, point, change)
        value = spare(p, t + middle, y + change, side)
        if value > 0.0:
            low, least, most = middle, value, 0.5 * most if kept_end == 1 else most
            kept_end = 1
        else:
            high, most, least = middle, value, 0.5 * least if kept_end == -1 else least
            kept_end = -1
        if high - low <= CLOSE * max(1e-3, t):
            break
    return high


@njit
def sharp_motion(p, start):
    """(states at the start of each period and at the end, [time, side before, side after] of the events)."""
    place, law = 1 if p[MACHINE] == 0.0 else 3, p[LAW]
    sticks, smooth = law <= HYPERBOLIC, law in (TANH, ARCTAN, SMOOTHED)
    period = 2.0 * math.pi / p[FREQUENCY]
    marks, events, count = np.zeros((PERIODS + 1, STATES)), np.zeros((MOST_EVENTS, 3)), 0
    k, point, change, slope = np.zeros((STAGES, STATES)), np.zeros(STATES), np.zeros(STATES), np.zeros(STATES)
    y, lost, side, h = start.copy(), np.zeros(STATES), 0.0, 1e-6  # lost: what sums have rounded off (Kahan)
    marks[0] = y
    if y[place] != 0.0:
        side = math.copysign(1.0, y[place])
    for number in range(PERIODS):
        t = 0.0
        while period - t > 1e-14 * period:
            h = min(h, 0.25 * math.sqrt(p[WIDTH]) if side != 0.0 else period / 200.0, period - t)
            rates(p, t, y, side, slope)
            if slope[place] != 0.0:
                h = min(h, max(0.5 * max(abs(y[place]), p[WIDTH]) / abs(slope[place]), 1e-13))
            last, error = h >= period - t, step(p, t, y, side, h, k, point, change)
            if error > 1.0 and h > 1e-14:
                h *= max(0.2, 0.9 * error ** (-1.0 / 8.0))
                continue
            below = first_below(p, t, y, side, h, k, point, change, slope)
            if below > 0.0:
                h, last = event_time(p, t, y, side, below, k, point, change), False
            error = step(p, t, y, side, h, k, point, change)
            if below > 0.0 and error > 1.0 and h > 1e-12:
                h *= 0.5
                continue
            for i in range(STATES):
                moved = change[i] + lost[i]
                lost[i] = moved - ((y[i] + moved) - y[i])
                y[i] += moved
            t += h
            if below > 0.0:
                before = side
                hold = holding_force(p, t, y)
                if side == 0.0 or (sticks and abs(hold) >= p[STATIC]):
                    side = math.copysign(1.0, hold)
                else:
                    side = 0.0 if sticks else -before
                if before != 0.0:
                    y[place] = lost[place] = 0.0
                if not smooth or law == SMOOTHED:
                    events[count] = number * period + t, before, side
                    count += 1
                h = 1e-6
            elif last:
                break
            else:
                h *= min(5.0, 0.9 * max(error, 1e-10) ** (-1.0 / 8.0))
        marks[number + 1] = y
    return marks, events[:count]


def event_name(before: float, after: float) -> str:
    """The package's word."""
    if 0.0 not in (before, after):
        return "reversal"
    return {0.0: "stick", 1.0: "slip_forward", -1.0: "slip_back"}[after]


def table_row(seed: int, example: tuple[float, float] | None = None) -> dict | None:
    """A system with its motion and how sensitive that is; None where a small shift changes the events.

    example: exponent and speed of a Stribeck law that takes the place of the random one
    """
    p, start = random_system(seed)
    if example is not None:
        p[LAW], p[EXPONENT], p[WIDTH], p[DROOP] = STRIBECK, *example, example[1]
    states = kept(p)
    marks, events = sharp_motion(p, start)
    growth = 1.0
    for state in states:
        for shift in (-SHIFT, SHIFT):
            other = start.copy()
            other[state] += shift
            moved, others = sharp_motion(p, other)
            if len(others) != len(events):
                return None
            growth = max(growth, float(np.abs(moved - marks).max()) / SHIFT)
    values = dict(zip(NAMES, p.tolist(), strict=True))
    values |= {"law": LAWS[int(p[LAW])], "machine": MACHINES[int(p[MACHINE])]}
    found = [[time, event_name(before, after)] for time, before, after in events.tolist()]
    return {"seed": seed, **values, "marks": marks[:, states].tolist(), "events": found, "growth": growth}


if __name__ == "__main__":
    rows, seed = [], 0
    examples = ",\n".join(json.dumps(table_row(seed, tuple(example))) for seed, *example in EXAMPLES)
    while len(rows) < SYSTEMS:
        row = table_row(seed)
        if row is None:
            print(f"seed {seed} left out: a shift by {SHIFT} changes its events", file=sys.stderr)
        else:
            rows.append(json.dumps(row))
        seed += 1
    head = f'{{"periods": {PERIODS}, "examples": [\n{examples}\n], "systems": [\n'
    TABLE.write_text(head + ",\n".join(rows) + "\n]}\n")
