"""Roles: what a parameter does in its part, hence its dimension.

A parameter declares its role beside its value, `parameter(0.15, "eta_c", "friction coefficient at high speed",
"level")`. Fits know from it where to start and what to look for, conversions to SI by which scales to multiply. A
parameter that has none of these roles declares its unit, `unit="N s/m"`, or nothing: then it is fitted from the value
that the law starts with, and cannot be converted.
"""

import dataclasses
import functools
import re

from vibrocap.arguments import suggestion


@dataclasses.dataclass(frozen=True)
class Dimension:
    """Exponents of the kinds of quantity that make up a parameter.

    coefficient: a force over the normal load, which is a force itself where the load is not known. effort: what a drive
    exerts, a force or a torque, as the machine takes it (`Machine.effort`).
    """

    coefficient: float = 0.0
    force: float = 0.0
    length: float = 0.0
    time: float = 0.0
    effort: float = 0.0

    def __mul__(self, other: "Dimension") -> "Dimension":
        return Dimension(*(a + b for a, b in zip(self.exponents, other.exponents, strict=True)))

    def __truediv__(self, other: "Dimension") -> "Dimension":
        return Dimension(*(a - b for a, b in zip(self.exponents, other.exponents, strict=True)))

    def __pow__(self, exponent: float) -> "Dimension":
        return Dimension(*(exponent * a for a in self.exponents))

    @property
    def exponents(self) -> tuple[float, float, float, float, float]:
        """Of coefficient, force, length, time and effort."""
        return self.coefficient, self.force, self.length, self.time, self.effort

    def resolved(self, effort: "Dimension", known_load: bool = True) -> "Dimension":
        """The dimension in force, length and time alone: with what a drive exerts, and with or without a known load."""
        force = self.force + (0.0 if known_load else self.coefficient)
        return Dimension(force=force, length=self.length, time=self.time) * effort**self.effort

    def unit(self, known_load: bool = True) -> str:
        """The SI unit in N, m and s, "1" for a number; what a drive exerts counts as a force."""
        own = self.resolved(FORCE, known_load)
        powers = {"N": own.force, "m": own.length, "s": own.time}
        above = [unit + ("" if e == 1 else f"^{e:g}") for unit, e in powers.items() if e > 0]
        below = [unit + ("" if e == -1 else f"^{-e:g}") for unit, e in powers.items() if e < 0]
        return (" ".join(above) or "1") + ("/" + " ".join(below) if below else "")


NUMBER = Dimension()
COEFFICIENT, EFFORT = Dimension(coefficient=1.0), Dimension(effort=1.0)
FORCE, LENGTH, TIME = Dimension(force=1.0), Dimension(length=1.0), Dimension(time=1.0)
TORQUE, SPEED, MASS = FORCE * LENGTH, LENGTH / TIME, FORCE * TIME**2 / LENGTH

# Every role with its dimension.
ROLES = {
    # of friction laws
    "level": COEFFICIENT,  # friction coefficient at high speed, or the only one
    "static level": COEFFICIENT,  # friction coefficient at rest, not below the level
    "Stribeck velocity": SPEED,  # speed over which friction drops
    "fading velocity": SPEED,  # speed over which the damping of the contact fades
    "decay rate": NUMBER / SPEED,  # rate of that drop over speed
    "exponent": NUMBER,  # sharpness of a knee or a drop
    "viscous damping": FORCE / SPEED,
    "stiffness": FORCE / LENGTH,  # of the contact, or of a spring along the line of travel
    "bristle damping": FORCE / SPEED,
    "fraction": NUMBER,  # between 0 and 1
    "share": NUMBER,  # one of several shares of a whole, which are less than it together
    "softening": NUMBER,  # of the contact as it yields; below zero it hardens
    "attraction rate": COEFFICIENT / TIME,  # at which a force follows its level
    "direct effect": COEFFICIENT,  # of the speed on friction, at once
    "evolution effect": COEFFICIENT,  # of the speed on friction, as the contact is renewed
    "distance": LENGTH,  # of sliding, over which the contact is renewed
    "gap": LENGTH,  # play in which no force acts
    "back ratio": NUMBER,  # level in sliding back, over that in sliding forward
    "smoothing velocity": SPEED,  # speed over which friction changes its sign
    "reference velocity": SPEED,  # a convention: at which other parameters are given
    "cutoff velocity": SPEED,  # speed below which a law ceases to hold
    "convention": NUMBER,  # a number that is chosen, not measured
    # of machines
    "mass": MASS,
    "load": FORCE,
    "speed": SPEED,
    "torsional stiffness": TORQUE,
    "torsional damping": TORQUE * TIME,
    # of environments
    "quadratic damping": MASS / LENGTH,  # a force over the square of a speed
    # of controllers
    "position gain": EFFORT / LENGTH,  # also of the integral of a speed
    "position integral gain": EFFORT / (LENGTH * TIME),
    "position rate gain": EFFORT / SPEED,
    "position anti-windup": LENGTH / EFFORT,
    "velocity anti-windup": SPEED / EFFORT,
    "angle rate gain": EFFORT * TIME,
    "angle anti-windup": NUMBER / EFFORT,
    # of drives
    "effort": EFFORT,  # force or torque; of a reference, what it is
    "effort rate": EFFORT / TIME,
    "effort acceleration": EFFORT / TIME**2,
    "frequency": NUMBER / TIME,  # angular
    "phase": NUMBER,  # an angle in radians
    "duration": TIME,
}

_UNITS = {"1": NUMBER, "rad": NUMBER, "N": FORCE, "m": LENGTH, "s": TIME, "kg": MASS, "J": TORQUE, "W": TORQUE / TIME}


@functools.cache
def dimension_of_role(role: str) -> Dimension:
    """The dimension of a role. Raises ValueError with the nearest name for a role that there is not."""
    if role not in ROLES:
        raise ValueError(f"role: there is no role {role!r}; {suggestion(role, ROLES)}")
    return ROLES[role]


@functools.cache
def dimension_of_unit(unit: str) -> Dimension:
    """The dimension of a unit such as "N s/m" or "1/s": products, one division, powers as in "s^2".

    Raises ValueError for what is none.
    """
    above, *below = unit.split("/")
    found = NUMBER
    for text, sign in ((above, 1.0), *((part, -1.0) for part in below)):
        for factor in text.split():
            match = re.fullmatch(r"(\w+?)(?:\^(-?\d+(?:\.\d+)?))?", factor)
            if match is None or match[1] not in _UNITS:
                raise ValueError(f"unit: {factor!r} in {unit!r} is none of {', '.join(_UNITS)}, nor a power of one")
            found = found * _UNITS[match[1]] ** (sign * float(match[2] or 1))
    if len(below) > 1 or not all(part.strip() for part in (above, *below)):
        raise ValueError(f'unit: should be as "N s/m" or "1/s", with one "/" at most, got {unit!r}')
    return found
