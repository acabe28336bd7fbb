"""performance_bounds(system): known bounds for any drive on a given machine and ground."""

import dataclasses
import itertools
import math
from collections.abc import Callable
from typing import Any

import numpy as np

from vibrocap.arguments import ArgumentError
from vibrocap.design.search.problem import measure_unit
from vibrocap.measures.during_run import measured
from vibrocap.orbits.closing.orbit import Orbit
from vibrocap.physics.drives.drive import Drive, Piecewise, Wave, segment_table
from vibrocap.physics.system import System
from vibrocap.quantities.declared import Number, NumberInUnit
from vibrocap.results import Result

SPEEDS = np.logspace(-12.0, 12.0, 481)  # at which the least friction is looked for, then between the best three
INSTANTS = 4096  # of a period, at which a smooth drive is looked at for its turning points


@dataclasses.dataclass(frozen=True, eq=False, repr=False)
class PerformanceBound(Result):
    """What a measure cannot be better than.

    measure: its name; kind: "least" where no motion has less, "largest" where none has more; value: of the bound, in
    `unit`; scale: one dimensionless unit in it
    holds_for: the motions for which it holds; source: where it comes from
    """

    measure: str
    kind: str
    value: NumberInUnit
    unit: str
    scale: Number
    holds_for: str
    source: str

    in_record = "measure kind value holds_for source"

    @property
    def heading(self) -> str:
        return f"{self.kind} {self.measure.replace('_', ' ')} of {self.holds_for}"

    @property
    def facts(self) -> dict[str, str]:
        return {self.kind: f"{self.value:.12g}{'' if self.unit == '1' else f' {self.unit}'}", "source": self.source}

    def of(self, orbit: Orbit) -> NumberInUnit:
        """The measure of a steady motion, in the unit of the bound; its size where it has a direction."""
        motion = orbit.motion()
        values = measured(motion, self.measure, window=len(motion.sections) - 1)[self.measure]
        return abs(values) * self.scale

    def holds(self, orbit: Orbit) -> bool:
        """Whether a steady motion is one of those for which the bound holds."""
        if self.measure != "mean_velocity":
            return True
        motion = orbit.motion()
        names = ["least_centre_velocity", "largest_centre_velocity"]
        least, largest = measured(motion, names, window=len(motion.sections) - 1).values()
        rounding = 1e-9 * max(abs(least), abs(largest))
        return least <= rounding and largest >= -rounding


def performance_bounds(system: System) -> tuple[PerformanceBound, ...]:
    """The known bounds of a system under any drive.

    Cost of transport: a sliding contact i takes at least R_i |v_i| of power, R_i being its least friction at any speed;
    over a period all bodies travel by D, so that the drive gives at least the sum of R_i |D|. It holds for set-valued
    laws under constant loads on level ground that does not move, where no force pulls from outside.

    Mean velocity: of a body with an inner mass whose stroke L is imposed, mu = m/(M + m) and isotropic Coulomb friction
    that slows both masses together by k, sqrt(mu k L/2), for motions whose common centre of mass stops once in each
    stroke (Chernousko 2002). Motions that never let it stop may be faster.

    Raises ValueError where no bound of the system is known, with the reason for each.
    """
    bounds = [_least_cost(system), _largest_velocity(system)]
    known = tuple(bound for bound in bounds if not isinstance(bound, str))
    if not known:
        raise ArgumentError("system", f"no bound is known of this system: {'; '.join(map(str, bounds))}")
    return known


def _least_cost(system: System) -> PerformanceBound | str:
    """The least cost of transport, or why it is not known."""
    name = "cost of transport"
    if any(law.kind != "set-valued" for law in system.laws):
        return f"{name}: of laws with a memory the force at a speed may be less than their steady one"
    if system.machine.follows_load:
        return f"{name}: where the load follows the motion, a body may slide while it is light"
    if system.machine.ground_speed() != 0.0:
        return f"{name}: the ground moves, and gives energy"
    around = system.environment
    if around is not None and (around.inclination != 0.0 or around.force != 0.0):
        return f"{name}: gravity or a force from outside may give energy"
    if system.cyclic is None:
        return f"{name}: the machine does not travel"
    least = sum(_least_friction(law, load) for law, load in zip(system.laws, system.law_loads, strict=True))
    unit, scale = measure_unit(system, "cost_of_transport")
    source = "friction times distance; reached by a body that never slides back"
    return PerformanceBound("cost_of_transport", "least", least * scale, unit, scale, "all steady motions", source)


def _least_friction(law: Any, load: float) -> float:
    """The least |R| of a set-valued law at any speed, in either direction."""
    least = math.inf
    for side in (1.0, -1.0):

        def force(speed: float, side: float = side) -> float:
            return side * float(law.force(side * speed, (), side, load)[0])

        forces = np.array([force(speed) for speed in SPEEDS])
        k = int(np.argmin(forces))
        least = min(least, forces[k])
        if 0 < k < len(SPEEDS) - 1 and forces[k] < min(forces[0], forces[-1]):
            least = min(least, _least_between(force, SPEEDS[k - 1], SPEEDS[k + 1], 1e-12 * SPEEDS[k]))
    return least


def _least_between(function: Callable[[float], float], low: float, high: float, accuracy: float) -> float:
    from scipy.optimize import minimize_scalar

    minimum: Any = minimize_scalar(function, bounds=(low, high), options={"xatol": accuracy})
    return float(minimum.fun)


def _largest_velocity(system: System) -> PerformanceBound | str:
    """The largest mean velocity at a stroke, or why it is not known."""
    name = "mean velocity"
    machine, law = system.machine, system.friction
    if not machine.imposes_motion or len(system.laws) > 1:
        return f"{name}: no stroke is imposed on one inner mass"
    if system.environment is not None:
        return f"{name}: something besides level ground acts on the machine"
    if law.kind != "set-valued" or machine.follows_load:
        return f"{name}: friction is not that of a set-valued law under a constant load"
    load = system.law_loads[0]
    kinetic = _least_friction(law, load)
    fast = [abs(law.force(side * speed, (), side, load)[0]) for side in (1.0, -1.0) for speed in (1e-12, 1.0, 1e12)]
    if max(*fast, law.holding_limit(load)) - kinetic > 1e-12 * kinetic or law.holding_centre(load) != 0.0:
        return f"{name}: friction is not the same at all speeds, at rest and in both directions"
    stroke = _stroke(system.drive)
    if isinstance(stroke, str):
        return f"{name}: {stroke}"
    total = machine.momentum(0.0, (0.0, 1.0))  # at the speed 1 of the common centre
    value = math.sqrt(stroke * kinetic / (2.0 * total * total))  # mu = 1/total, as masses are in units of the inner one
    unit, scale = measure_unit(system, "mean_velocity")
    words = "motions whose centre of mass stops once in each stroke", "Chernousko 2002: sqrt(mu k L/2)"
    return PerformanceBound("mean_velocity", "largest", value * scale, unit, scale, *words)


def _stroke(drive: Drive) -> float | str:
    """From the least to the largest displacement of a drive that rises and falls once in a period."""
    if isinstance(drive, Piecewise):
        ends = itertools.pairwise([0.0, *(row[0] for row in segment_table(drive))])
        times = np.concatenate([np.linspace(start, end, 65)[:-1] for start, end in ends]) * drive.period
    elif isinstance(drive, Wave):
        times = np.linspace(0.0, drive.period, INSTANTS, endpoint=False)
    else:
        return "the drive has no period of its own"
    values = np.array([drive.value(t) for t in times])
    steps = np.sign(np.diff(np.append(values, values[0])))
    steps = steps[steps != 0.0]
    if np.count_nonzero(steps != np.roll(steps, 1)) != 2:
        return "the drive has more than one stroke in a period"
    length, step = 0.0, drive.period / len(times)
    for sign in (1.0, -1.0):
        near = float(times[int(np.argmax(sign * values))])
        least = _least_between(lambda t, sign=sign: -sign * drive.value(t), near - step, near + step, 1e-12 * step)
        length += max(sign * drive.value(near), -least)
    return length
