"""An event-driven integrator of machines of one and two contacts with |v|^alpha, which shares nothing with the package.

The equations are typed again from docs/machines.md and docs/friction.md, of machines whose friction is

    N [eta_c + (eta_s - eta_c) exp(-|v/v_s|^alpha)] sgn(v)     |friction| <= N eta_s at rest        "stribeck"
    N [eta_c + (eta_s - eta_c) exp(-|v S/v_s|^alpha)] S        S = tanh(v/eps)                      "tanh"

Every contact has a mode: its side, or 0 while it sticks. Between events DOP853 (SciPy's tableau) follows one mode with
a local error of at most 1e-14, no step changing a velocity by more than half of itself near rest, where |v|^alpha has
no Taylor series. An event is found by repeating the last step with other lengths, so that it is as exact as the step.
"""

import dataclasses
import math
import random

import numpy as np
from scipy.integrate._ivp import dop853_coefficients as tableau
from scipy.optimize import brentq

import vibrocap as vc

STAGES = 12
A, B, C = tableau.A[:STAGES, :STAGES], tableau.B, tableau.C[:STAGES]
E3, E5 = tableau.E3[:STAGES], tableau.E5[:STAGES]
LOCAL_ERROR = 1e-14
NEAR = 1e-4  # speed from which on a velocity may change by more than half of itself in a step
# The states that move with the velocities of the contacts.
PLACES = {"oscillator": (1,), "capsule": (3,), "row": (1, 3), "crawler": (3, 1), "worm": (1, 1)}
KINDS = {"oscillator": vc.Oscillator, "capsule": vc.PendulumCapsule, "row": vc.TwoBlockRow}
KINDS |= {"crawler": vc.TwoBodyCrawler, "worm": vc.TwoBodyWorm}


@dataclasses.dataclass(frozen=True)
class Contact:
    """Law of a contact: exponent 0 is Coulomb's; width 0: set-valued."""

    coulomb: float
    static: float
    droop: float
    exponent: float
    width: float
    load: float

    @property
    def law(self):
        """The package's."""
        if self.exponent == 0.0:
            return vc.Coulomb(self.coulomb, self.coulomb)
        values = {"coulomb_coefficient": self.coulomb, "static_coefficient": self.static}
        values |= {"stribeck_velocity": self.droop, "stribeck_exponent": self.exponent, "viscous_damping": 0.0}
        return vc.SmoothedTanh(**values, smoothing_velocity=self.width) if self.width else vc.Stribeck(**values)

    @property
    def limit(self) -> float:
        return self.load * (self.static if self.exponent else self.coulomb)

    def force(self, v, side):
        """Friction while sliding."""
        sign = math.tanh(v / self.width) if self.width else side
        level = self.coulomb
        if self.exponent:
            level += (self.static - self.coulomb) * math.exp(-(abs(v * sign / self.droop) ** self.exponent))
        return self.load * level * sign


@dataclasses.dataclass(frozen=True)
class Case:
    """A machine with its numbers, its contacts, the drive (amplitude, frequency, second, phase), the start."""

    machine: str
    numbers: dict[str, float]
    contacts: tuple[Contact, ...]
    drive: tuple[float, float, float, float]
    start: tuple[float, ...]

    @property
    def system(self) -> vc.System:
        loads = {f"normal_load{'' if i == 0 else '_2'}": each.load for i, each in enumerate(self.contacts)}
        names = ("amplitude", "frequency", "second_amplitude", "second_phase")
        drive = vc.Biharmonic(**dict(zip(names, self.drive, strict=True)))
        laws = [each.law for each in self.contacts]
        return vc.System(KINDS[self.machine](**self.numbers, **loads), laws if len(laws) > 1 else laws[0], drive)

    # --- equations: v of all contacts; rates given friction; what would hold each contact ---------------------------

    def drive_at(self, t):
        """(z, z', z'')."""
        h, w, k, psi = self.drive
        one, two = w * t, 2.0 * w * t + psi
        z = h * math.cos(one) + k * math.cos(two)
        slope = -h * w * math.sin(one) - 2.0 * k * w * math.sin(two)
        return z, slope, -h * w * w * math.cos(one) - 4.0 * k * w * w * math.cos(two)

    def velocities(self, t, y):
        if self.machine == "worm":
            return [y[1] + share * self.drive_at(t)[1] for share in self.shares]
        return [
            y[place] for place in {"oscillator": (1,), "capsule": (3,), "row": (1, 3), "crawler": (3, 1)}[self.machine]
        ]

    @property
    def shares(self):
        one, two = self.numbers["mass"], self.numbers["mass_2"]
        return -two / (one + two), one / (one + two)

    def pushes(self, t, y):
        """Forces on the bodies but friction."""
        n, z = self.numbers, self.drive_at(t)[0]
        if self.machine == "oscillator":
            return [z - n["stiffness"] * y[0] - n["damping"] * (y[1] + n["belt_speed"])]
        if self.machine == "capsule":  # along the ground, with the capsule at rest
            moment = z + math.sin(y[0]) - n["stiffness"] * y[0] - n["damping"] * y[1]
            return [math.cos(y[0]) * moment - math.sin(y[0]) * y[1] ** 2]
        if self.machine == "row":
            pull = n["coupling_stiffness"] * (y[2] - y[0]) + n["coupling_damping"] * (y[3] - y[1])
            belt = n["belt_speed"]
            one = z - n["stiffness"] * y[0] - n["damping"] * (y[1] + belt) + pull
            return [one, z - n["stiffness_2"] * y[2] - n["damping_2"] * (y[3] + belt) - pull]
        pull = n["stiffness"] * y[0] + n["damping"] * (y[1] - y[3]) - z
        return [pull, -pull]

    def rates(self, t, y, sides):
        v, n = self.velocities(t, y), self.numbers
        taken = [each.force(speed, side) for each, speed, side in zip(self.contacts, v, sides, strict=True)]
        if self.machine == "worm":
            total = n["mass"] + n["mass_2"]
            rest = [share for share, side in zip(self.shares, sides, strict=True) if side == 0]
            curvature = self.drive_at(t)[2]
            return np.array([v[0], -rest[0] * curvature if rest else -sum(taken) / total])
        push = self.pushes(t, y)
        if self.machine == "capsule":
            moment = self.drive_at(t)[0] + math.sin(y[0]) - n["stiffness"] * y[0] - n["damping"] * y[1]
            if sides[0] == 0:
                return np.array([y[1], moment, 0.0, 0.0])
            total, cosine = n["mass_ratio"] + 1.0, math.cos(y[0])
            inertia, sine = total - cosine**2, math.sin(y[0])
            turning = (total * moment - sine * cosine * y[1] ** 2 - taken[0] * cosine) / inertia
            return np.array([y[1], turning, y[3], (push[0] - taken[0]) / inertia])
        masses = [n["mass"], n.get("mass_2", 1.0)]
        a = [0.0 if s == 0 else (p - r) / m for p, r, m, s in zip(push, taken, masses, sides, strict=False)]
        if self.machine == "oscillator":
            return np.array([y[1] + n["belt_speed"], a[0]])
        if self.machine == "row":
            return np.array([y[1] + n["belt_speed"], a[0], y[3] + n["belt_speed"], a[1]])
        return np.array([y[1] - y[3], a[1], y[3], a[0]])

    def holds(self, t, y, sides):
        """Friction that would keep each contact at rest, in the modes of the others."""
        if self.machine != "worm":
            return self.pushes(t, y)
        v, total = self.velocities(t, y), self.numbers["mass"] + self.numbers["mass_2"]
        found = []
        for i, share in enumerate(self.shares):
            other = self.contacts[1 - i].force(v[1 - i], sides[1 - i])
            found.append(total * share * self.drive_at(t)[2] - other)
        return found

    def guards(self, t, y, sides):
        """Positive while each contact stays in its mode."""
        v, holds = self.velocities(t, y), self.holds(t, y, sides)
        return [
            1.0 if each.width else (side * speed if side else each.limit - abs(hold))
            for each, side, speed, hold in zip(self.contacts, sides, v, holds, strict=True)
        ]


def step(case, t, y, sides, h):
    """(change of the state over a step, its error over LOCAL_ERROR)."""
    k = np.zeros((STAGES, len(y)))
    for stage in range(STAGES):
        k[stage] = case.rates(t + C[stage] * h, y + h * (A[stage, :stage] @ k[:stage]), sides)
    five, three = np.sum((E5 @ k / LOCAL_ERROR) ** 2), np.sum((E3 @ k / LOCAL_ERROR) ** 2)
    error = h * five / math.sqrt((five + 0.01 * three) * len(y)) if five + three > 0.0 else 0.0
    return h * (B @ k), error


def settled(case, t, y, sides, contact):
    """Side of a contact at rest: it holds, or goes on to where it is pushed."""
    hold, limit = case.holds(t, y, sides)[contact], case.contacts[contact].limit
    if case.machine == "worm" and any(s == 0 for i, s in enumerate(sides) if i != contact):
        raise ValueError("two contacts of a worm at rest at once")
    return 0 if abs(hold) < limit else pushed(case, t, y, sides, contact)


def pushed(case, t, y, sides, contact):
    """To which side a contact at rest is pushed."""
    return int(math.copysign(1.0, case.holds(t, y, sides)[contact]))


def first_event(case, t, y, sides, h, change):
    """(contact, time) of the first guard that falls to zero within a step, or (None, h); seen at four points of it."""
    before = case.guards(t, y, sides)
    for share in (0.25, 0.5, 0.75, 1.0):
        moved = change if share == 1.0 else step(case, t, y, sides, share * h)[0]
        values = case.guards(t + share * h, y + moved, sides)
        leaves = [start <= 0.0 and share * h < 1e-5 for start in before]  # rest, within this step
        fallen = [i for i, value in enumerate(values) if value <= 0.0 and not leaves[i]]
        if fallen:
            break
    else:
        return None, h

    def spare(s):
        return case.guards(t + s, y + step(case, t, y, sides, s)[0], sides)[fallen[0]]

    low = high = share * h
    while low > 1e-3 * high and spare(low) <= 0.0:
        low *= 0.7
    return fallen[0], brentq(spare, low, high, xtol=1e-16, rtol=1e-15) if spare(low) > 0.0 else low


def longest_step(case, t, y, sides):
    """Over which no velocity near rest changes by more than half of itself, of laws with a power that is not whole."""
    longest, ahead = math.inf, case.velocities(t + 1e-9, y + 1e-9 * case.rates(t, y, sides))
    for v, w, side, each in zip(case.velocities(t, y), ahead, sides, case.contacts, strict=True):
        rate = abs(w - v) * 1e9
        if (side or each.width) and rate > 0.0 and each.exponent % 1.0 and abs(v) < NEAR:
            longest = min(longest, max(0.5 * max(abs(v), 1e-3 * NEAR) / rate, 1e-12))
    return longest


def motion(case, periods):
    """(states at the start of each period and at the end, [(contact, before, after)] of all events)."""
    y = np.array(case.start, float)
    period, events, marks = 2.0 * math.pi / case.drive[1], [], [y.copy()]
    sides = [0 if abs(v) < 1e-15 else int(math.copysign(1.0, v)) for v in case.velocities(0.0, y)]
    for i, each in enumerate(case.contacts):
        if sides[i] == 0 and not each.width:
            sides[i] = settled(case, 0.0, y, sides, i)
    h = 1e-6
    for _ in range(periods):
        t = 0.0
        while period - t > 1e-14 * period:
            h = min(h, longest_step(case, t, y, sides), period - t, period / 60.0)
            last = h >= period - t
            change, error = step(case, t, y, sides, h)
            if error > 1.0 and h > 1e-13:
                h *= max(0.2, 0.9 * error ** (-1.0 / 8.0))
                continue
            which, hit = first_event(case, t, y, sides, h, change)
            if which is None:
                y, t = y + change, t + h
                h *= min(4.0, 0.9 * max(error, 1e-10) ** (-1.0 / 8.0))
                if last:
                    break
                continue
            others = [guard for i, guard in enumerate(case.guards(t, y, sides)) if i != which]
            moved = y + step(case, t, y, sides, hit)[0]
            after = [guard for i, guard in enumerate(case.guards(t + hit, moved, sides)) if i != which]
            if any(guard <= 0.0 < start for guard, start in zip(after, others, strict=True)):
                h = 0.5 * hit  # of two contacts the first
                continue
            y, t, came, h = moved, t + hit, sides[which], 1e-6
            if came:
                y[PLACES[case.machine][which]] -= case.velocities(t, y)[which]
                sides[which] = 0
            sides[which] = settled(case, t, y, sides, which) if came else pushed(case, t, y, sides, which)
            events.append((which, came, sides[which]))
        marks.append(y.copy())
    return np.array(marks), events


def event_name(before: float, after: float) -> str:
    """The package's word."""
    if 0.0 not in (before, after):
        return "reversal"
    return {0.0: "stick", 1.0: "slip_forward", -1.0: "slip_back"}[after]


def random_case(seed):
    """A system whose exponents are between 1.1 and 2.9."""
    draw = random.Random(seed)
    machine = draw.choice(tuple(PLACES))
    count = 1 if machine in ("oscillator", "capsule") else 2
    contacts = []
    for _ in range(count):
        low, width = draw.uniform(0.1, 0.25), draw.uniform(0.005, 0.05) if draw.random() < 0.2 else 0.0
        exponent = draw.choice((draw.uniform(1.1, 2.9), draw.uniform(1.1, 2.9), 0.0 if count > 1 else 1.5))
        contacts.append(
            Contact(
                low,
                low + draw.uniform(0.05, 0.25),
                10 ** draw.uniform(-2.0, -0.7),
                exponent,
                width if exponent else 0.0,
                draw.uniform(0.7, 1.4),
            )
        )
    drive = (draw.uniform(0.5, 1.6), draw.uniform(0.5, 1.4), draw.uniform(0.1, 0.7), draw.uniform(0.0, 6.0))
    numbers = {"mass": 1.0, "stiffness": draw.uniform(0.5, 2.0), "damping": draw.uniform(0.05, 0.3)}
    start = (draw.uniform(-0.5, 0.5), draw.uniform(-0.5, 0.5))
    if machine == "capsule":
        numbers = {
            "mass_ratio": draw.uniform(0.5, 4.0),
            "stiffness": draw.uniform(1.5, 4.0),
            "damping": draw.uniform(0.5, 1.5),
        }
    if machine in ("oscillator", "row"):
        numbers["belt_speed"] = draw.uniform(0.2, 0.6)
    if machine == "row":
        numbers |= {"mass_2": draw.uniform(0.6, 2.0), "stiffness_2": draw.uniform(0.5, 2.0), "damping_2": 0.1}
        numbers |= {"coupling_stiffness": draw.uniform(0.3, 1.5), "coupling_damping": 0.05}
    if machine in ("crawler", "worm"):
        numbers["mass_2"] = draw.uniform(0.6, 2.5)
    if machine == "worm":
        del numbers["stiffness"], numbers["damping"]
        contacts = [dataclasses.replace(each, width=0.0) for each in contacts]
    if machine not in ("oscillator", "worm"):
        start = (*start, draw.uniform(-0.2, 0.2), draw.uniform(-0.5, 0.5))
    return Case(machine, numbers, tuple(contacts), drive, start)
