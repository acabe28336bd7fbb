"""Motions of contacts whose load follows the motion, by a solver that shares nothing with the package.

The equations are typed again from docs/model.md (the capsule, its load, its environment) and from Hoffmann's model (the
mode-coupling block); stick and slip are switched by hand, with events located by `independent.until_switch`. A law is a
coefficient for each direction: while sliding R = N mu, at rest any R from least to most times the load at rest.

A system is a dict of numbers, as in `independent.py`; a machine is what `Machine` below asks for.
"""

import math
import random
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from independent import STEPS_PER_PERIOD, drive, until_switch


@dataclass(frozen=True)
class Law:
    """Coefficient by speed, times a ratio for each direction; kind: "coulomb", "exponential" or "stribeck"."""

    kind: str
    coulomb: float
    static: float
    forward: float = 1.0
    back: float = 1.0
    width: float = 0.1  # 1/a of the exponential law, v_s of the Stribeck curve

    def coefficient(self, velocity: float, side: int) -> float:
        speed = side * velocity
        share = {
            "coulomb": lambda: 0.0,
            "exponential": lambda: math.exp(-speed / self.width),
            "stribeck": lambda: math.exp(-((speed / self.width) ** 2)),
        }[self.kind]()
        return side * (self.forward if side > 0 else self.back) * (self.coulomb + (self.static - self.coulomb) * share)

    @property
    def held(self) -> tuple[float, float]:
        """Least and largest force at rest, per load."""
        return -self.back * self.static, self.forward * self.static


class Capsule:
    """State (theta, theta', X, X'). N is linear in R, N = a + b R, as theta'' is; R = mu N while it slides."""

    velocity = 3

    def __init__(self, p: dict, law: Law):
        self.p, self.law = p, law
        self.slope, self.drag, self.push = (p.get(name, 0.0) for name in ("inclination", "drag", "force"))

    def _moment(self, t: float, y: Sequence[float]) -> float:
        return drive(t, self.p) + math.sin(y[0] + self.slope) - self.p["stiffness"] * y[0] - self.p["damping"] * y[1]

    def rates(self, t: float, y: Sequence[float], side: int) -> list[float]:
        sine, cosine, turning = math.sin(y[0]), math.cos(y[0]), self._moment(t, y)
        if side == 0:
            return [y[1], turning, 0.0, 0.0]
        total = self.p["mass_ratio"] + 1.0
        inertia = total - cosine * cosine
        outside = self.push - self.drag * y[3] - total * math.sin(self.slope)

        def turned(force: float) -> float:
            return (total * turning - sine * cosine * y[1] ** 2 - force * cosine) / inertia

        alone = total * math.cos(self.slope) - sine * turned(-outside) - cosine * y[1] ** 2  # a of N = a + b R
        raised = sine * cosine / inertia  # b
        coefficient = self.law.coefficient(y[3], side)
        load = alone / (1.0 - raised * coefficient)
        if load <= 0.0 or raised * coefficient >= 1.0:
            raise ArithmeticError("the load ends")
        force = coefficient * load - outside
        return [y[1], turned(force), y[3], (cosine * turning - sine * y[1] ** 2 - force) / inertia]

    def spare(self, t: float, y: Sequence[float]) -> tuple[float, float]:
        """(most - R, R - least) of a contact at rest."""
        sine, cosine, turning = math.sin(y[0]), math.cos(y[0]), self._moment(t, y)
        total = self.p["mass_ratio"] + 1.0
        load = total * math.cos(self.slope) - sine * turning - cosine * y[1] ** 2
        if load <= 0.0:
            raise ArithmeticError("the load ends")
        force = cosine * turning - sine * y[1] ** 2 + self.push - total * math.sin(self.slope)
        least, most = self.law.held
        return most * load - force, force - least * load


class Block:
    """State (y, y', x, v), v = x' - v_b: m v' = drive - k11 x - k12 y - c x' - R, m y'' = -k12 x - k22 y - c y'."""

    velocity = 3

    def __init__(self, p: dict, law: Law):
        self.p, self.law = p, law

    def _pull(self, t: float, y: Sequence[float]) -> float:
        springs = self.p["sliding_stiffness"] * y[2] + self.p["coupling_stiffness"] * y[0]
        return drive(t, self.p) - springs - self.p["damping"] * (y[3] + self.p["belt_speed"])

    def _load(self, y: Sequence[float]) -> float:
        load = self.p["normal_load"] + self.p["contact_stiffness"] * y[0]
        if load <= 0.0:
            raise ArithmeticError("the load ends")
        return load

    def rates(self, t: float, y: Sequence[float], side: int) -> list[float]:
        mass = self.p["mass"]
        back = self.p["coupling_stiffness"] * y[2] + self.p["normal_stiffness"] * y[0] + self.p["damping"] * y[1]
        force = self._pull(t, y) if side == 0 else self.law.coefficient(y[3], side) * self._load(y)
        return [y[1], -back / mass, y[3] + self.p["belt_speed"], (self._pull(t, y) - force) / mass]

    def spare(self, t: float, y: Sequence[float]) -> tuple[float, float]:
        least, most = self.law.held
        return most * self._load(y) - self._pull(t, y), self._pull(t, y) - least * self._load(y)


def motion(machine: Capsule | Block, initial: Sequence[float], periods: int, rtol: float = 1e-12) -> tuple:
    """(state at the end, [(time, side from there on)]). ArithmeticError: the load ends; RuntimeError: in doubt."""
    period = 2.0 * math.pi / machine.p["frequency"]
    t, y, end = 0.0, np.array(initial, float), period * periods
    place, events = machine.velocity, []

    def at_rest() -> int:
        forward, back = machine.spare(t, y)
        return 1 if forward < 0.0 else -1 if back < 0.0 else 0

    side = int(np.sign(y[place])) or at_rest()
    while t < end:

        def watched(time: float, state: Sequence[float], side: int = side) -> float:
            return side * state[place] if side else min(machine.spare(time, state))

        def flow(time: float, state: Sequence[float], side: int = side) -> list[float]:
            return machine.rates(time, state, side)

        t, y, switched = until_switch(flow, watched, t, y, end, period / STEPS_PER_PERIOD, rtol, 0.1 * rtol)
        if switched:
            if side == 0:
                forward, back = machine.spare(t, y)
                side = 1 if forward < back else -1
            else:
                y[place] = 0.0
                side = at_rest()
            events.append((t, side))
        if len(events) > 200:
            raise RuntimeError("more than 200 events")
    return y, events


def random_law(draw: random.Random, kind: str) -> Law:
    coulomb = draw.uniform(0.05, 0.2)
    ratios = draw.uniform(0.6, 1.0), draw.uniform(0.8, 1.6)
    forward, back = ratios if draw.random() < 0.5 else ratios[::-1]
    return Law(kind, coulomb, coulomb + draw.uniform(0.02, 0.25), forward, back, draw.uniform(0.05, 0.4))


def random_capsule(seed: int, kind: str) -> tuple[Capsule, tuple[float, ...]]:
    draw = random.Random(f"capsule {seed}")
    p = {
        "mass_ratio": draw.uniform(1.5, 4.5),
        "stiffness": draw.uniform(1.3, 4.0),
        "damping": draw.uniform(0.3, 1.2),
        "amplitude": draw.uniform(0.5, 1.3),
        "frequency": draw.uniform(0.7, 1.5),
        "second_amplitude": draw.uniform(0.1, 0.5),
    }
    return Capsule(p, random_law(draw, kind)), (draw.uniform(-0.6, 0.6), 0.0, 0.0, 0.0)


def random_block(seed: int, kind: str) -> tuple[Block, tuple[float, ...]]:
    draw = random.Random(f"block {seed}")
    p = {
        "mass": draw.uniform(0.7, 1.5),
        "sliding_stiffness": draw.uniform(1.5, 3.0),
        "coupling_stiffness": draw.uniform(0.2, 0.7),
        "normal_stiffness": draw.uniform(1.5, 3.0),
        "contact_stiffness": draw.uniform(0.8, 1.4),
        "damping": draw.uniform(0.02, 0.2),
        "belt_speed": draw.uniform(-0.3, 0.3),
        "normal_load": 1.0,
        "amplitude": draw.uniform(0.3, 0.9),
        "frequency": draw.uniform(0.5, 1.5),
        "second_amplitude": draw.uniform(0.1, 0.4),
    }
    return Block(p, random_law(draw, kind)), (draw.uniform(-0.3, 0.3), 0.0, draw.uniform(-0.3, 0.3), 0.0)
