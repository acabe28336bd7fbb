"""A friction law under an imposed motion: the force that answers a measured or prescribed velocity."""

import dataclasses
import functools
from collections.abc import Sequence
from typing import Any

import numpy as np

from vibrocap.arguments import ArgumentError, check_whole, is_number, is_positive, suggestion
from vibrocap.motion.recording.equations import is_recorded
from vibrocap.motion.status import Status
from vibrocap.numerics.api import DrivenEquations, codes, driven_runs, sharpness
from vibrocap.numerics.expressions.graph import Graph, evaluated
from vibrocap.physics.friction.law import Law
from vibrocap.physics.parameters import parameter_table


def check_numbers(**numbers: Any) -> None:
    """ValueError for what is not a positive number, by name."""
    for name, value in numbers.items():
        if not is_positive(value):
            raise ArgumentError(name, f"should be a positive number, got {value!r}")


def checked_list(name: str, values: Any) -> np.ndarray:
    """Positive numbers [n]; ValueError for anything else."""
    try:
        numbers = np.asarray(values, dtype=float)
    except (TypeError, ValueError):
        numbers = np.zeros(0)
    if numbers.ndim != 1 or not len(numbers) or not np.all((numbers > 0.0) & np.isfinite(numbers)):
        raise ArgumentError(name, f"should be a list of positive numbers, got {values!r}")
    return numbers


def check_motion(status: Status, law: Law) -> None:
    """RuntimeError where a motion of a test could not be completed."""
    if not status.ok:
        raise RuntimeError(f"a test of the {law.name} law could not be completed ({status.value}): {status.text}")


def driven_equations(law: Law, free: tuple[str, ...]) -> DrivenEquations:
    """Recorded equations of a law; laws of one form share them. free: parameters that are recorded in any case."""
    values = {info.name: getattr(law, info.name) for info in parameter_table(law)}
    recorded = tuple(name for name, value in values.items() if name in free or is_recorded(law, name, value))
    return _recorded(type(law), recorded, tuple((name, x) for name, x in values.items() if name not in recorded))


@functools.lru_cache(maxsize=64)
def _recorded(kind: type[Law], names: tuple[str, ...], fixed: tuple) -> DrivenEquations:
    graph = Graph()
    law = object.__new__(kind)
    for i, name in enumerate(names):
        object.__setattr__(law, name, graph.node("parameter", i))
    for name, value in fixed:
        object.__setattr__(law, name, value)
    moving = [name for name in law.internal if name not in law.switched]
    sorted_names = moving + [name for name in law.internal if name in law.switched]
    order = [sorted_names.index(name) for name in law.internal]
    k = len(order)
    states = [graph.node("state", i) for i in range(k)]
    velocity, load, side = graph.node("state", k), graph.node("state", k + 1), graph.node("side")
    internal = tuple(states[i] for i in order)

    def in_order(values: Sequence[Any]) -> tuple:
        return tuple(graph.expression(values[order.index(i)]) for i in range(k))

    force, rates = law.force(velocity, internal, side, load)
    moved = in_order(rates)[: len(moving)]
    sharp = sharpness(graph, moved, velocity, states[: len(moving)])
    guards = law.switches(velocity, internal, side, load)
    return DrivenEquations(
        graph=graph,
        parameter_names=names,
        order=tuple(order),
        moving=len(moving),
        rates=moved,
        force=graph.expression(force),
        guards=tuple(graph.expression(guard) for guard in guards),
        after_switch=tuple(in_order(law.after_switch(i, velocity, internal, side, load)) for i in range(len(guards))),
        after_reversal=in_order(law.after_reversal(internal, side, load)),
        scales=in_order(law.internal_scales(load)),
        sharp=sharp.arguments,
        sharp_internal=sharp.internal,
        set_valued=law.kind == "set-valued",
    )


def _numbers(name: str, values: Any) -> np.ndarray:
    """Finite numbers [n]."""
    try:
        numbers = np.asarray(values, dtype=float)
    except (TypeError, ValueError) as error:
        raise ArgumentError(name, f"should be numbers, got {values!r}") from error
    if numbers.ndim != 1:
        raise ArgumentError(name, f"should be a list of numbers, got an array of shape {numbers.shape}")
    if not np.isfinite(numbers).all():
        i = int(np.argmin(np.isfinite(numbers)))
        raise ArgumentError(name, f"should be finite, got {numbers[i]} at sample {i}")
    return numbers


def imposed_motion(law: Law, time: Any, velocity: Any, load: Any, tolerance: float) -> np.ndarray:
    """Time, velocity and load: [3, n]."""
    if not isinstance(law, Law):
        raise ArgumentError("law", f"should be a friction law such as LuGre(), got {law!r}")
    t, v = _numbers("time", time), _numbers("velocity", velocity)
    if len(t) < 2:
        raise ArgumentError("time", f"should have at least 2 samples, got {len(t)}")
    if len(v) != len(t):
        raise ArgumentError("velocity", f"should have as many samples as time ({len(t)}), got {len(v)}")
    if not (np.diff(t) > 0.0).all():
        i = int(np.argmin(np.diff(t) > 0.0)) + 1
        raise ArgumentError("time", f"should increase from sample to sample, got {t[i]} after {t[i - 1]} at sample {i}")
    w = np.full(len(t), _numbers("load", [load])[0]) if np.ndim(load) == 0 else _numbers("load", load)
    if len(w) != len(t):
        raise ArgumentError("load", f"should be a number or have as many samples as time ({len(t)}), got {len(w)}")
    if not ((w > 0.0) if law.internal else (w >= 0.0)).all():
        wanted = f"> 0 with the {law.name} law" if law.internal else ">= 0"
        raise ArgumentError("load", f"should be {wanted}, got {w.min()} at sample {int(np.argmin(w))}")
    if not is_number(tolerance) or not 1e-14 <= tolerance < 1.0:
        raise ArgumentError("tolerance", f"should be between 1e-14 and 1, got {tolerance!r}")
    return np.stack([t, v, w])


def start_states(law: Law, internal: Any, runs: int) -> np.ndarray:
    """Internal states at the start: [runs, k]."""
    k = len(law.internal)
    if internal is None:
        return np.zeros((runs, k))
    states = np.atleast_1d(np.asarray(internal, dtype=float))
    if states.shape not in ((k,), (runs, k)):
        wanted = f"the {k} internal states of the {law.name} law ({', '.join(law.internal) or 'none'})"
        raise ArgumentError("internal", f"should have {wanted}, got an array of shape {states.shape}")
    if not np.isfinite(states).all():
        raise ArgumentError("internal", f"should be finite, got {internal!r}")
    return np.array(np.broadcast_to(states, (runs, k)))


def parameter_sets(law: Law, values: Any, names: tuple[str, ...]) -> np.ndarray:
    """Parameter sets: [m, p]."""
    known = [info.name for info in parameter_table(law) if isinstance(getattr(law, info.name), (int, float))]
    if strange := [name for name in names if name not in known]:
        near = f"got {strange[0]!r}; {suggestion(strange[0], known, cutoff=0.0)}"
        raise ArgumentError("names", f"should be parameters of the {law.name} law, {near}")
    if len(set(names)) != len(names):
        raise ArgumentError("names", f"should differ, got {', '.join(names)}")
    table = np.asarray(values, dtype=float)
    if table.ndim != 2 or table.shape[1] != len(names) or len(table) == 0:
        form = f"one row per parameter set and one column per name ({len(names)})"
        raise ArgumentError("values", f"should have {form}, got an array of shape {table.shape}")
    if not np.isfinite(table).all():
        row, column = np.argwhere(~np.isfinite(table))[0]
        raise ArgumentError("values", f"should be finite, got {table[row, column]} for {names[column]} in row {row}")
    return table


STATUSES = {
    codes.DONE: Status.FINISHED,
    codes.STEP_UNDERFLOW: Status.STEP_UNDERFLOW,
    codes.NOT_FINITE: Status.NOT_FINITE,
    codes.TOO_MANY_EVENTS: Status.TOO_MANY_EVENTS,
    codes.TOO_MANY_STEPS: Status.TOO_MANY_STEPS,
}


@dataclasses.dataclass(frozen=True, eq=False)
class Driven:
    """Response of a law to an imposed motion, sample by sample.

    force: [n], in the unit of load times coefficient; internal: [n, k] states of the law (k = 0 where it has none)
    status: `finished`, or why it could not be completed; force and states are NaN from there on
    """

    force: np.ndarray
    internal: np.ndarray
    status: Status


@dataclasses.dataclass(frozen=True, eq=False)
class DrivenSet:
    """Responses of a law with many parameter sets to one imposed motion.

    force: [m, n]; a row is NaN throughout where its run could not be completed; status: [m], how each run ended
    """

    force: np.ndarray
    status: tuple[Status, ...]

    @property
    def completed(self) -> np.ndarray:
        """[m] whether each run went to its end."""
        return np.array([status.ok for status in self.status])


def driven_force(
    law: Law, time: Any, velocity: Any, *, load: Any = 1.0, internal: Any = None, tolerance: float = 1e-8
) -> Driven:
    """Friction force of a law whose contact is moved at a given velocity, which is linear between the samples.

    The internal states follow z' = f(v(t), z, N(t)) by an L-stable method under error control within every interval;
    an interval in which the velocity changes sign is cut there, and a switch of the law's pieces is located.

    time: [n], strictly increasing, even or not [1, or s]      velocity: [n] [1, or m/s]
    load: normal load N, a number or [n], linear between the samples; 1 for a law whose coefficients are forces in N
    internal: [k] states at the first sample, 0 by default; tolerance: error per step over the natural size of a state

    At rest the force of a set-valued law is whatever balances the contact: given is that of the side of the last motion
    at vanishing speed, and 0 before the first motion. Other laws are on the side of the last motion, or of the first.
    Raises ValueError for what is not such an input. A run that cannot be completed says so in `status`.
    """
    motion = imposed_motion(law, time, velocity, load, tolerance)
    start = start_states(law, internal, 1)
    equations = driven_equations(law, ())
    parameters = np.array([_values(law, equations)])
    force, states, (status,) = _responses(law, equations, parameters, start, motion, tolerance, 1, keep_internal=True)
    return Driven(force[0], states[0], status)


def driven_forces(
    law: Law,
    values: Any,
    names: Sequence[str],
    time: Any,
    velocity: Any,
    *,
    load: Any = 1.0,
    internal: Any = None,
    tolerance: float = 1e-8,
    threads: int | None = None,
) -> DrivenSet:
    """`driven_force` for many parameter sets at once, as a fit asks for them; one kernel serves them all.

    values: [m, p] parameter sets; column j replaces the law's parameter names[j]. They are not checked against the
    bounds of the law: outside, a run may fail, which its status tells.      internal: [k] or [m, k]
    threads: how many share the work (by default all cores); the numbers do not depend on it.

    A parameter that chooses the formula when it is whole (`shape_parameters`) takes the general formula when it is one
    of `names`.
    """
    check_whole("threads", 1 if threads is None else threads, 1)
    motion = imposed_motion(law, time, velocity, load, tolerance)
    names = tuple(names)
    table = parameter_sets(law, values, names)
    start = start_states(law, internal, len(table))
    equations = driven_equations(law, names)
    parameters = np.tile(_values(law, equations), (len(table), 1))
    for j, name in enumerate(names):
        parameters[:, equations.parameter_names.index(name)] = table[:, j]
    force, _, status = _responses(law, equations, parameters, start, motion, tolerance, threads)
    force[[not ended.ok for ended in status]] = np.nan
    return DrivenSet(force, status)


def _responses(
    law: Law, equations: DrivenEquations, parameters: np.ndarray, start: np.ndarray, motion: np.ndarray, *run: Any,
    keep_internal: bool = False,
) -> tuple[np.ndarray, Any, tuple[Status, ...]]:  # fmt: skip
    """(force [m, n], internal states [m, n, k] if they are kept, how each run ended) at parameters [m, p]."""
    if law.internal:
        runs = driven_runs(equations, parameters, start, motion, *run, keep_internal=keep_internal)
        return runs.force, runs.internal, tuple(STATUSES[int(code)] for code in runs.status)
    force = _steady(equations, parameters, motion)
    status = tuple(Status.FINISHED if np.isfinite(row).all() else Status.NOT_FINITE for row in force)
    return force, np.empty((*force.shape, 0)), status


def _values(law: Law, equations: DrivenEquations) -> list[float]:
    return [float(getattr(law, name)) for name in equations.parameter_names]


def _steady(equations: DrivenEquations, parameters: np.ndarray, motion: np.ndarray) -> np.ndarray:
    """Force [m, n] of a law without internal states."""
    _, velocity, load = motion
    moving = velocity != 0.0
    last = np.maximum.accumulate(np.where(moving, np.arange(len(velocity)), -1))  # sample of the last motion
    side = np.sign(velocity[np.maximum(last, np.argmax(moving))]) if moving.any() else np.ones(len(velocity))
    with np.errstate(all="ignore"):
        asked = [equations.force], 0.0, [velocity, load, 0.0, 0.0], side, parameters.T[:, :, None]
        (force,) = evaluated(*asked, (len(parameters), len(velocity)))
    if equations.set_valued:
        force[:, last < 0] = 0.0
    return force
