"""performance_bounds(system): known bounds for any drive on a given machine and ground."""

import dataclasses
import itertools
import math
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from vibrocap.arguments import ArgumentError
from vibrocap.design.search.problem import measure_unit
from vibrocap.measures.during_run import measured
from vibrocap.motion.recording.equations import equations, parameters_at
from vibrocap.motion.trajectory import GAUSS_NODES, gauss
from vibrocap.numerics.expressions.graph import evaluate
from vibrocap.orbits.closing.orbit import Orbit
from vibrocap.physics.drives.drive import Piecewise, Wave, segment_table
from vibrocap.physics.system import System
from vibrocap.quantities.declared import Number, NumberInUnit
from vibrocap.results import Result

SPEEDS = np.logspace(-12.0, 12.0, 481)  # at which the least friction is looked for, then between the best three
CELLS = 512  # of a period, in each of which a stroke turns round once at most
SIZES = np.repeat((0.1, 1.0, 10.0), 8)  # of the states at which it is asked what else gives force or energy
ROUNDING = 1e-12  # of the largest move in a cell: less is none


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
    laws under constant loads, where all rub on level ground that does not move, and nothing but the drive gives energy.

    Mean velocity: of a body that an imposed motion moves by mu L past the common centre of mass (an inner mass of the
    stroke L, mu = m/(M + m)), and isotropic Coulomb friction that slows both masses together by k, sqrt(mu k L/2), for
    motions whose common centre stops once in each stroke (Chernousko 2002). Motions that never let it stop may be
    faster.

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
    if system.cyclic is None:
        return f"{name}: the machine does not travel"
    if not system.machine.over_ground:
        return f"{name}: not all contacts are with the ground"
    around = system.environment
    outside = around is not None and (around.inclination != 0.0 or around.force != 0.0)
    if outside or system.machine.ground_speed() != 0.0 or _fed(system):
        return f"{name}: the ground, gravity, a damper or a force from outside may give energy"
    least = sum(_least_friction(law, load) for law, load in zip(system.laws, system.law_loads, strict=True))
    unit, scale = measure_unit(system, "cost_of_transport")
    source = "friction times distance; reached by a body that never slides back"
    return PerformanceBound("cost_of_transport", "least", least * scale, unit, scale, "all steady motions", source)


def _places(system: System) -> Iterator[tuple[Any, float, tuple[float, ...], tuple[float, ...]]]:
    """(the machine under its drive, time, its states, friction at its contacts) at places like any other."""
    machine, draw = system.machine.driven_by(system.drive, system.drives), np.random.default_rng(0)
    for size in SIZES:
        y, frictions = (size * draw.normal(size=len(n)) for n in (machine.states, machine.contact_states))
        yield machine, system.drive.period * draw.uniform(), tuple(y), tuple(frictions)


def _pulled(system: System) -> bool:
    """Whether more than drive and friction acts along the line, on level ground."""
    still = (0.0,) * len(system.laws)
    return any(machine.outer_force(t, y, 0.0, still) != 0.0 for machine, t, y, _ in _places(system))


def _fed(system: System) -> bool:
    """Whether anything but the drive gives energy: through a channel, or as what is stored falls with travel."""
    states, channels = system.machine.states, system.machine.channels
    other = [i for i, name in enumerate(channels) if name != "drive"]
    for machine, t, y, frictions in _places(system):
        power, away = machine.powers(t, y, 0.0, frictions), dict(zip(states, y, strict=True)) | {system.cyclic: 0.0}
        if any(power[i] > 0.0 for i in other):
            return True
        here, there = machine.energy(t, y), machine.energy(t, tuple(away.values()))
        if abs(here - there) > ROUNDING * (abs(here) + abs(there)):
            return True
    return False


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
    if system.environment is not None or _pulled(system) or not machine.over_ground or machine.ground_speed() != 0.0:
        return f"{name}: something besides level ground at rest acts on the machine"
    if law.kind != "set-valued" or machine.follows_load:
        return f"{name}: friction is not that of a set-valued law under a constant load"
    load = system.law_loads[0]
    kinetic = _least_friction(law, load)
    fast = [abs(law.force(side * speed, (), side, load)[0]) for side in (1.0, -1.0) for speed in (1e-12, 1.0, 1e12)]
    if max(*fast, law.holding_limit(load)) - kinetic > 1e-12 * kinetic or law.holding_centre(load) != 0.0:
        return f"{name}: friction is not the same at all speeds, at rest and in both directions"
    stroke = _stroke(system)
    if isinstance(stroke, str):
        return f"{name}: {stroke}"
    value = math.sqrt(0.5 * stroke * kinetic / machine.momentum(0.0, (0.0, 1.0)))  # its speed 1: the mass of all
    unit, scale = measure_unit(system, "mean_velocity")
    words = "motions whose centre of mass stops once in each stroke", "Chernousko 2002: sqrt(mu k L/2)"
    return PerformanceBound("mean_velocity", "largest", value * scale, unit, scale, *words)


def _stroke(system: System) -> float | str:
    """How far an imposed motion moves the body past the common centre, where it turns round twice in a period."""
    if not isinstance(system.drive, (Wave, Piecewise)):
        return "the drive has no period of its own"
    recording, period, ends = equations(system), system.drive.period, [1.0]
    if isinstance(system.drive, Piecewise):
        ends = [row[0] for row in segment_table(system.drive)]
    count = 1 + CELLS // len(ends)
    cells = [np.linspace(*between, count)[:-1] for between in itertools.pairwise([0.0, *ends])]
    knots = period * np.append(np.concatenate(cells), 1.0)
    still = (0.0,) * len(system.state_names)

    def speed(times: np.ndarray, inside: np.ndarray) -> np.ndarray:
        """Of the body past the centre, in the segments in which these other times lie."""
        parameters = parameters_at(system, inside)
        return evaluate([recording.contacts[0].velocity], times, still, 1.0, parameters)[0] + 0.0 * times

    def turn(cell: int) -> Any:
        inside = middles[cell : cell + 1]
        return brentq(lambda t: speed(np.array([t]), inside)[0], knots[cell], knots[cell + 1])

    from scipy.optimize import brentq

    middles = 0.5 * (knots[1:] + knots[:-1])
    turns = [turn(int(i)) for i in np.flatnonzero(speed(knots[:-1], middles) * speed(knots[1:], middles) < 0.0)]
    knots = np.sort(np.append(knots, turns))
    nodes, weights = gauss(GAUSS_NODES)
    half, middles = 0.5 * np.diff(knots), 0.5 * (knots[1:] + knots[:-1])
    at = (middles[:, None] + np.outer(half, nodes)).ravel()
    steps = half * (speed(at, np.repeat(middles, len(nodes))).reshape(len(half), -1) @ weights)
    ways = np.sign(steps[np.abs(steps) > ROUNDING * np.max(np.abs(steps))])
    if np.count_nonzero(ways != np.roll(ways, 1)) != 2:
        return "the body has more than one stroke past the common centre in a period, or none"
    return float(np.ptp(np.cumsum(steps)))
