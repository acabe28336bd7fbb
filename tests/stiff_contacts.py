"""Stiff contacts of several bodies by a solver of their own: SciPy's Radau between located events.

Nothing is shared with the package: laws, bodies and modes are written here once more. Every contact slides to a side or
sticks (Coulomb's law alone, with one level); bodies are pulled by springs (`Crawler`) or held at distances (`Worm`).

`python tests/stiff_contacts.py` computes the ends and the events of all motions, minutes each, and stores them in
stiff_contacts.json.
"""

import json
import math
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import vibrocap as vc

STORE = Path(__file__).with_name("stiff_contacts.json")
RELATIVE, ABSOLUTE, LONGEST, POLISHING = 1e-12, 1e-14, 0.5, 2
Force = Callable[[float, Sequence[float], float, float], tuple[float, list[float]]]


def coulomb(level: float) -> tuple[float, list[float]]:
    """A set-valued law: (largest friction, starts of its internal states)."""
    return level, []


def lugre(stiffness: float, damping: float, low: float, high: float, speed: float) -> tuple[Force, list[float]]:
    """Eqs 6, 7 and 10 of Liu et al. 2019, from relaxed bristles."""

    def force(v: float, inner: Sequence[float], side: float, load: float) -> tuple[float, list[float]]:
        level = load * (low + (high - low) * math.exp(-((v / speed) ** 2)))
        rate = v - side * v * stiffness * inner[0] / level
        return stiffness * inner[0] + damping * rate, [rate]

    return force, [0.0]


def ageing(level: float, direct: float, evolution: float, distance: float, speed: float) -> tuple[Force, list[float]]:
    """Rate and state with Dieterich's age, regularised by the asinh of Rice and Ben-Zion."""

    def force(v: float, inner: Sequence[float], side: float, load: float) -> tuple[float, list[float]]:
        jumps = v / (2.0 * speed) * math.exp((level + evolution * inner[0]) / direct)
        return load * direct * math.asinh(jumps), [(speed * math.exp(-inner[0]) - side * v) / distance]

    return force, [0.0]


class Row:
    """Two or three bodies on contacts; subclasses say how they move.

    The state is a number of states of the bodies, then the internal states of the laws in turn.
    """

    bodies_states: int

    def __init__(self, masses: Sequence[float], loads: Sequence[float], laws: Sequence[tuple[Any, list[float]]]):
        self.masses, self.loads, self.laws = masses, loads, laws
        self.count = len(masses)

    def velocities(self, t: float, y: np.ndarray) -> np.ndarray:
        """Of each contact."""
        raise NotImplementedError

    def moved(self, t: float, y: np.ndarray, friction: list, modes: tuple) -> tuple[list, np.ndarray, list]:
        """(rates of the bodies' states, accelerations of the contacts, all friction); None in `friction`: it rests."""
        raise NotImplementedError

    def everything(self, t: float, y: np.ndarray, modes: tuple) -> tuple[list, np.ndarray, list]:
        """(y', accelerations, friction) in given modes."""
        friction, inner_rates, place = [], [], self.bodies_states
        velocities = self.velocities(t, y)
        for (law, start), load, v, mode in zip(self.laws, self.loads, velocities, modes, strict=True):
            if not callable(law):
                friction.append(mode * law * load if mode else None)
                continue
            force, rates = law(v, y[place : place + len(start)], mode, load)
            place += len(start)
            friction.append(force)
            inner_rates += rates
        rates, accelerations, friction = self.moved(t, y, friction, modes)
        return [*rates, *inner_rates], accelerations, friction

    def guards(self, t: float, y: np.ndarray, modes: tuple) -> list[float]:
        """Positive while the modes last: velocities to their sides, and what a contact at rest may hold more."""
        friction, sizes = self.everything(t, y, modes)[2], []
        for (law, _), load, v, mode, held in zip(
            self.laws, self.loads, self.velocities(t, y), modes, friction, strict=True
        ):
            sizes.append(mode * v if mode else law * load - abs(held))
        return sizes

    def after(self, t: float, y: np.ndarray, modes: tuple, which: int) -> tuple:
        """The modes behind an event of one contact."""
        items, (law, _) = list(modes), self.laws[which]
        if callable(law):
            items[which] = -modes[which]
        elif modes[which] == 0:
            items[which] = int(np.sign(self.everything(t, y, modes)[2][which]))
        else:
            items[which] = 0
            held = self.everything(t, y, tuple(items))[2][which]
            if abs(held) > law * self.loads[which]:
                items[which] = int(np.sign(held))
        return tuple(items)

    def motion(self, start: Sequence[float], modes: tuple, end: float) -> tuple[np.ndarray, list]:
        """(state at the end, [(time, contact)] of all events), from these modes."""
        t, events = 0.0, []
        y: Any = np.array(start, float)
        first: Any
        found: Any
        fresh: int | None = None
        while t < end - 1e-13:
            until, started = min(end, t + LONGEST), fresh

            def run(a: float, start: np.ndarray, b: float, modes: tuple = modes) -> Any:
                return solve_ivp(
                    lambda s, x: self.everything(s, x, modes)[0],
                    (a, b),
                    start,
                    method="Radau",
                    rtol=RELATIVE,
                    atol=ABSOLUTE,
                    dense_output=True,
                )

            found = run(t, y, until)
            first, which = until, -1
            for i in range(self.count):
                for a, b in zip(found.t[:-1], found.t[1:], strict=True):
                    if i == started and a == t:
                        continue

                    def guard(s: float, i: int = i, found: Any = found, modes: Any = modes) -> float:
                        return self.guards(s, found.sol(s), modes)[i]

                    if guard(b) <= 0.0 and b - t > 1e-12:
                        root: Any = brentq(guard, a, b, xtol=1e-15) if guard(a) > 0.0 else a
                        if root < first:
                            first, which = root, i
                        break
            fresh = None
            if which >= 0:
                for _ in range(POLISHING):  # the dense output is less exact than the steps
                    at = run(t, y, first).y[:, -1]
                    value = self.guards(first, at, modes)[which]
                    ahead = first + 1e-7
                    slope = (self.guards(ahead, run(first, at, ahead).y[:, -1], modes)[which] - value) / 1e-7
                    first -= value / slope
                found = run(t, y, first)
                fresh = which
            t, y = first, found.y[:, -1].copy()
            if which >= 0:
                y = self.at_rest(t, y, which) if modes[which] else y
                events.append((t, which + 1))
                modes = self.after(t, y, modes, which)
        return y, events

    def at_rest(self, t: float, y: np.ndarray, which: int) -> np.ndarray:
        """The state with the velocity of a contact exactly zero."""
        return y


class Crawler(Row):
    """y = (z_1, ..., v_1, v_2, ...): springs and dampers, and the drive that pushes the gaps apart."""

    def __init__(self, masses, loads, laws, stiffness, damping, drive):
        super().__init__(masses, loads, laws)
        self.stiffness, self.damping, self.drive = stiffness, damping, drive
        self.bodies_states = 2 * self.count - 1

    def velocities(self, t, y):
        """v_1, v_2, ..."""
        return y[self.count - 1 : self.bodies_states]

    def moved(self, t, y, friction, modes):
        """Newton's law for each body; one at rest holds all that pushes it."""
        v = self.velocities(t, y)
        pulls = self.stiffness * y[: self.count - 1] + self.damping * np.diff(v) - self.drive(t)
        pushes = np.append(pulls, 0.0) - np.append(0.0, pulls)
        friction = [push if force is None else force for push, force in zip(pushes, friction, strict=True)]
        accelerations = (pushes - friction) / self.masses
        return [*np.diff(v), *accelerations], accelerations, friction

    def at_rest(self, t, y, which):
        """As of any."""
        y[self.count - 1 + which] = 0.0
        return y


class Worm(Row):
    """y = (v of the last contact), which may creep, so that its v is the state: distances follow a drive (z', z'')."""

    bodies_states = 1

    def __init__(self, masses, loads, laws, drive):
        super().__init__(masses, loads, laws)
        ahead, masses = np.arange(len(masses), dtype=float), np.array(masses)
        self.shares, self.drive = ahead - masses @ ahead / masses.sum(), drive

    def velocities(self, t, y):
        """v_i = v_n + (u_i - u_n) z'."""
        return y[0] + (self.shares - self.shares[-1]) * self.drive(t)[0]

    def moved(self, t, y, friction, modes):
        """The common centre; one at rest holds what all others leave."""
        mass, curvature = sum(self.masses), self.drive(t)[1]
        if None in friction:
            at = friction.index(None)
            friction[at] = mass * self.shares[at] * curvature - sum(force for force in friction if force is not None)
        accelerations = -sum(friction) / mass + self.shares * curvature
        return [accelerations[-1]], accelerations, friction

    def at_rest(self, t, y, which):
        """Its velocity taken off that of the last."""
        y[0] -= self.velocities(t, y)[which]
        return y


MASSES, LOADS, SPEEDS = (1.0, 1.5, 0.8), (1.0, 1.2, 0.9), (0.1, -0.05, 0.07)
FREQUENCY, STROKE = 0.8, 0.5
LAWS: dict[str, tuple[Any, tuple[Any, list[float]]]] = {
    "coulomb": (vc.Coulomb(0.25, 0.25), coulomb(0.25)),
    "lugre": (
        vc.LuGre(bristle_stiffness=1e4, bristle_damping=100.0, coulomb_coefficient=0.15, static_coefficient=0.3),
        lugre(1e4, 100.0, 0.15, 0.3, 0.1),
    ),
    "ageing": (vc.RateAndStateAgeing(), ageing(0.3, 0.03, 0.06, 0.01, 0.1)),
}
MOTIONS = {
    "crawler coulomb lugre": 1.0,
    "crawler lugre lugre": 1.0,
    "crawler ageing ageing": 1.0,
    "worm coulomb ageing": 1.0,
    "worm ageing ageing": 1.0,
    "worm coulomb lugre": 0.6,
    "worm lugre lugre": 0.3,
}  # machine and laws, and for how many periods


def system_of(name: str) -> tuple[vc.System, dict[str, float]]:
    """(system, start) of a motion."""
    kind, *laws = name.split()
    count = len(laws)
    table = {f"mass_{i}": mass for i, mass in enumerate(MASSES[1:count], 2)}
    table |= {f"normal_load_{i}": load for i, load in enumerate(LOADS[1:count], 2)}
    friction = [LAWS[law][0] for law in laws]
    if kind == "worm":
        drive = vc.Harmonic(amplitude=STROKE, frequency=FREQUENCY)
        return vc.System(vc.worm(count)(**table), friction, drive), {"centre_velocity": 0.05}
    drive = vc.Biharmonic(amplitude=1.5, frequency=FREQUENCY, second_amplitude=0.7, second_phase=0.5)
    names = ["velocity", "velocity_2", "velocity_3"][:count]
    system = vc.System(vc.crawler(count)(**table), friction, drive)
    return system, dict(zip(names, SPEEDS, strict=False))


def reference(name: str, periods: float) -> tuple[dict[str, float], list]:
    """(states at the end by their names, events) by the solver of this file."""
    kind, *laws = name.split()
    own, count, end = [LAWS[law][1] for law in laws], len(laws), periods * 2.0 * math.pi / FREQUENCY
    inner = [value for _, starts in own for value in starts]
    row: Row
    if kind == "worm":
        row = Worm(MASSES[:count], LOADS[:count], own, _imposed)
        y, events = row.motion([0.05, *inner], (1,) * count, end)
        settings = {"centre_velocity": y[0] - row.shares[-1] * _imposed(end)[0]}
    else:
        row = Crawler(np.array(MASSES[:count]), LOADS[:count], own, 1.0, 0.1, _push)
        y, events = row.motion([*[0.0] * (count - 1), *SPEEDS[:count], *inner], tuple(np.sign(SPEEDS[:count])), end)
        names = ["displacement", "displacement_2"][: count - 1] + ["velocity", "velocity_2", "velocity_3"][:count]
        settings = dict(zip(names, y, strict=False))
    place = row.bodies_states
    for number, law in enumerate(laws, 1):
        for state in LAWS[law][0].internal:
            settings[state if number == 1 else f"{state}_{number}"] = y[place]
            place += 1
    return {state: float(value) for state, value in settings.items()}, [(float(t), int(number)) for t, number in events]


def _imposed(t: float) -> tuple[float, float]:
    """(z', z'') of the distances."""
    along = FREQUENCY * t
    return -STROKE * FREQUENCY * math.sin(along), -STROKE * FREQUENCY**2 * math.cos(along)


def _push(t: float) -> float:
    """The drive of crawlers."""
    return 1.5 * math.cos(FREQUENCY * t) + 0.7 * math.cos(2.0 * FREQUENCY * t + 0.5)


def stored() -> dict[str, Any]:
    """What has been computed, by name."""
    content: dict[str, Any] = json.loads(STORE.read_text(encoding="utf-8")) if STORE.is_file() else {}
    return content


if __name__ == "__main__":
    for each, periods in MOTIONS.items():
        if each not in stored():
            state, events = reference(each, periods)
            STORE.write_text(json.dumps(stored() | {each: {"state": state, "events": events}}, indent=1) + "\n")
            print(each, len(events), flush=True)
