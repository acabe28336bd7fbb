"""Fits of rate-and-state friction to velocity steps that are imposed through a spring: the machine's own elasticity."""

import dataclasses
import itertools
import math
import time as clock
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from vibrocap.arguments import ArgumentError, is_positive
from vibrocap.identification.fit import split_records
from vibrocap.identification.fit_result import Fit
from vibrocap.identification.problem.coordinates import Coordinate
from vibrocap.identification.problem.parametrisation import law_class, parametrisation
from vibrocap.identification.problem.prediction import Column, Prediction, unchecked
from vibrocap.identification.problem.samples import Samples, data_scales
from vibrocap.identification.solution import Settings, solution
from vibrocap.progress import Progress, reporting

WINDOWS, FEWEST = (1.0, 0.2, 0.05, 0.02), 20  # windows over the record's length; samples on each side of a step


@dataclasses.dataclass(frozen=True)
class Step:
    """The load point's speed (m/s) from a time (s, on the record's clock from its first sample) on."""

    time: float
    speed: float


def found_step(samples: Samples, displacement: np.ndarray) -> tuple[Step, Step]:
    """The one step of speed in a displacement: two straight lines that meet where the errors are least.

    The meeting point is sought in ever narrower windows, and the speeds are medians over stretches, so that jumps of
    the sensor elsewhere move neither.
    """
    time = samples.time
    at = float(time[len(time) // 2])
    for share in WINDOWS:
        low, middle, high = np.searchsorted(time, [at - share * time[-1], at, at + share * time[-1]])
        if min(middle - low, high - middle) < FEWEST:
            break
        at = _meeting_point(time[low:high], displacement[low:high])
    speeds = []
    for side in (time < at, time > at):
        stretches = [part for part in np.array_split(np.flatnonzero(side), 20) if len(part) > 2]
        slopes = [np.polyfit(time[part] - time[part[0]], displacement[part], 1)[0] for part in stretches]
        speeds.append(float(np.median(slopes)))
    return Step(0.0, speeds[0]), Step(at, speeds[1])


def _meeting_point(time: np.ndarray, displacement: np.ndarray) -> float:
    """Where two lines meet that fit a displacement best."""
    from scipy.optimize import minimize_scalar

    def square(at: float) -> float:
        matrix = np.stack([np.ones_like(time), np.minimum(time - at, 0.0), np.maximum(time - at, 0.0)], axis=1)
        solution, *_ = np.linalg.lstsq(matrix, displacement, rcond=None)
        return float(np.sum((matrix @ solution - displacement) ** 2))

    places = np.linspace(time[0], time[-1], 102)[1:-1]
    least = places[int(np.argmin([square(at) for at in places]))]
    width = float(places[1] - places[0])
    how: Any = {"bounds": (least - width, least + width), "method": "bounded", "options": {"xatol": 1e-4 * width}}
    return float(minimize_scalar(square, **how).x)  # type: ignore[attr-defined]


def measured_stiffness(samples: Samples, steps: Sequence[Step]) -> float:
    """Stiffness (N/m) of what pulls the contact, as experimenters read it: the slope of the rise after the first step.

    The slope of the force over the load point's displacement until half of the peak, over 1 - V1/V2, for the contact
    goes on at V1 at first. It speeds up during the rise, so that this is rather too small: a lower bound.
    """
    first, step = steps[0], steps[1]
    before, after = samples.time < step.time, samples.time >= step.time
    level = float(np.median(samples.force[before][-400:]))
    time, force = samples.time[after], samples.force[after]
    width = max(int(np.searchsorted(time, time[0] + 0.002 * (time[-1] - time[0]))), 1)
    smooth = np.convolve(force, np.ones(width) / width, mode="valid") - level
    top = int(np.argmax(np.abs(smooth)))
    half = int(np.flatnonzero(np.abs(smooth) >= 0.5 * abs(smooth[top]))[0]) + width // 2
    rising = slice(0, max(half, 3) + 1)
    slope = np.polyfit(time[rising] - step.time, force[rising], 1)[0] / step.speed
    stiffness = float(slope / (1.0 - first.speed / step.speed))
    if not is_positive(stiffness):
        missing = "the record does not show it (the force does not rise with the step); give N/m"
        raise ArgumentError("machine_stiffness", missing)
    return stiffness


def check_program(steps: Sequence[Step], samples: Samples, stiffness: Any) -> None:
    times, speeds = [step.time for step in steps], [step.speed for step in steps]
    if len(steps) < 2:
        raise ArgumentError("program", f"should have at least two speeds, got {len(steps)}")
    if not all(map(is_positive, speeds)):
        raise ArgumentError("program", f"every speed should be > 0 m/s, got {', '.join(f'{v:.3g}' for v in speeds)}")
    if times[0] != 0 or any(b <= a for a, b in itertools.pairwise(times)) or times[-1] >= samples.time[-1]:
        raise ArgumentError("program", f"times should begin at 0, increase and end within the record, got {times}")
    if any(abs(math.log(b / a)) < 0.01 for a, b in itertools.pairwise(speeds)):
        raise ArgumentError("program", "the speed hardly changes; a step of it is needed")
    if stiffness is not None and not is_positive(stiffness):
        raise ArgumentError("machine_stiffness", f"should be > 0 N/m or 'measured', got {stiffness!r}")


def relaxation_distance(samples: Samples, steps: Sequence[Step]) -> float:
    """Distance over which the force falls from its extreme after the first step by two thirds: near D_c."""
    step = steps[1]
    after = samples.time > step.time
    time, force = samples.time[after], samples.force[after]
    width = min(max(len(force) // 400, 1), len(force) // 2)
    change = np.abs(np.convolve(force, np.ones(width) / width, mode="valid") - np.median(force))
    top = int(np.argmax(change[: max(len(change) // 2, 1)]))
    below = np.flatnonzero(change[top:] < change[top] / 3)
    span = time[top + below[0]] - step.time if len(below) else 0.1 * (time[-1] - step.time)
    return float(max(span, 1e-9) * step.speed)


def path_of(steps: Sequence[Step], end: float) -> tuple[np.ndarray, np.ndarray]:
    """Times and displacements of the load point at which its speed changes."""
    times = np.array([*(step.time for step in steps), end])
    return times, np.concatenate(([0.0], np.cumsum(np.diff(times) * [step.speed for step in steps])))


FIRST, STEPS = 1e-3, 2000  # first step, over the time of a critical distance; largest number of steps of a transient
ACCURACY = 1e-4  # error of ln V and of the state per step
IMAGINARY = 1e-30  # step of a derivative along the imaginary axis, exact to rounding
DIFFERENCE, UNITS = 1e-7, np.eye(2)[:, :, None]


@dataclasses.dataclass(frozen=True, eq=False)
class SpringPrediction(Prediction):
    """A contact that slides steadily, pulled through a spring whose far end changes its speed in steps.

        dR/dt = k (V_load - V),   R = R(V, phi),   phi' of the law: without inertia, from steady sliding at the first
        speed.

    "machine_stiffness" k (N/m), "drift" (N per m of the load point) are nuisance parameters, as is "offset".
    program: the load point's steps, the first at time 0. machine_stiffness: k where it is not searched.
    """

    program: tuple[Step, ...] = ()
    machine_stiffness: float | None = None

    def forces(self, table: np.ndarray, which: int) -> np.ndarray:
        """Force [m, n] of record number `which` at coordinates [m, p]."""
        record, names = self.records[which], self.space.names
        values = self.space.values(np.atleast_2d(table))
        columns = {name: values[:, names.index(name)].view(Column) for name in self.law_names}
        law = unchecked(self.template, columns)
        load = float(np.mean(record.load))
        stiffness = self._beside(values, "machine_stiffness", self.machine_stiffness)
        with np.errstate(all="ignore"):
            forces = _pulled(law, load, stiffness, self.program, record.time)
        pulled = np.interp(record.time, *path_of(self.program, record.time[-1]))
        if "drift" in names:
            forces = forces + values[:, [names.index("drift")]] * (pulled - pulled[-1] / 2)
        return forces

    def slopes(self, u: np.ndarray, errors: np.ndarray | None = None, held: Sequence[int] = ()) -> np.ndarray:
        """As of any prediction; the reference is computed along, for all columns of a table share their steps."""
        return super().slopes(u, None, held)


def _pulled(law: Any, load: float, stiffness: np.ndarray, steps: Sequence[Step], time: np.ndarray) -> np.ndarray:
    """Force [m, n] of a law whose parameters are columns [m]: transients after each step, steady before them."""
    first = np.full(len(stiffness), math.log(steps[0].speed)).view(Column)
    state = np.stack([first, -first + np.log(np.broadcast_to(law.reference_velocity, first.shape))])  # ln V, phi
    forces = np.empty((len(stiffness), len(time)))
    forces[:] = np.asarray(law.steady_force(np.exp(first), load))[:, None]
    for i, step in enumerate(steps[1:], 1):
        end = steps[i + 1].time if i + 1 < len(steps) else float(time[-1])
        grid, states = _transient(law, load, stiffness, step.speed, state, end - step.time)
        columns = ((speed.view(Column), phi.view(Column)) for speed, phi in states)
        values = np.stack([np.asarray(law.force(np.exp(speed), (phi,), 1.0, load)[0]) for speed, phi in columns])
        slopes = stiffness * (step.speed - np.exp(states[:, 0]))
        inside = (time >= step.time) & (time <= end)
        forces[:, inside] = _hermite(grid, values, slopes, time[inside] - step.time)
        state = states[-1]
    return forces


def _transient(
    law: Any, load: float, stiffness: np.ndarray, pulled: float, state: np.ndarray, span: float
) -> tuple[np.ndarray, np.ndarray]:
    """Times [t] since a step and states [t, 2, m] of a contact that is pulled at a new speed.

    Rodas3 (Sandu et al. 1997), of order 3 and L-stable, for a stiff spring relaxes fast; one step size for all columns.
    """

    def rates(y: np.ndarray) -> np.ndarray:
        speed, phi = np.exp(y[0]).view(Column), y[1].view(Column)
        _, (aging,) = law.force(speed, (phi,), 1.0, load)
        by_speed = np.imag(law.force((speed + IMAGINARY * speed * 1j).view(Column), (phi,), 1.0, load)[0]) / IMAGINARY
        by_state = np.imag(law.force(speed, ((phi + IMAGINARY * 1j).view(Column),), 1.0, load)[0]) / IMAGINARY
        return np.stack([(stiffness * (pulled - speed) - by_state * aging) / by_speed, aging]).view(np.ndarray)

    y = state.view(np.ndarray)
    time, times, states = 0.0, [0.0], [y]
    h = FIRST * float(np.nanmin(np.asarray(law.critical_distance))) / max(pulled, float(np.exp(np.nanmax(y[0]))))
    for _ in range(STEPS):
        if time >= span * (1 - 1e-12):
            break
        h = min(h, span - time)
        one = rates(y)
        slope = np.stack([(rates(y + DIFFERENCE * unit) - one) / DIFFERENCE for unit in UNITS], axis=1)
        k1 = _solved(slope, h, one)
        k2 = _solved(slope, h, one + 4.0 / h * k1)
        k3 = _solved(slope, h, rates(y + 2.0 * k1) + (k1 - k2) / h)
        k4 = _solved(slope, h, rates(y + 2.0 * k1 + k3) + (k1 - k2 - 8.0 / 3.0 * k3) / h)
        error = np.abs(k4).max(axis=0)
        good = np.isfinite(error)
        worst = float(error[good].max()) / ACCURACY if good.any() else 0.0
        if worst <= 1.0:
            time, y = time + h, y + 2.0 * k1 + k3 + k4
            times.append(time)
            states.append(y)
        h *= min(max(0.9 * max(worst, 1e-9) ** (-1 / 3), 0.2), 4.0)
    if times[-1] < span * (1 - 1e-9):
        y = np.full_like(y, np.nan)
        times.append(span)
        states.append(y)
    return np.array(times), np.array(states)


def _solved(slope: np.ndarray, h: float, right: np.ndarray) -> np.ndarray:
    """x [2, m] of (2/h - slope) x = right, for slopes [2, 2, m]."""
    a, b = 2.0 / h - slope[0, 0], -slope[0, 1]
    c, d = -slope[1, 0], 2.0 / h - slope[1, 1]
    determinant = a * d - b * c
    return np.stack([(d * right[0] - b * right[1]) / determinant, (a * right[1] - c * right[0]) / determinant])


def _hermite(grid: np.ndarray, values: np.ndarray, slopes: np.ndarray, at: np.ndarray) -> np.ndarray:
    """Cubic interpolation [m, n] of values [t, m] with slopes at times [n]."""
    i = np.clip(np.searchsorted(grid, at, side="right") - 1, 0, len(grid) - 2)
    h = (grid[i + 1] - grid[i])[:, None]
    s = ((at - grid[i]) / (grid[i + 1] - grid[i]))[:, None]
    first = (1 + 2 * s) * (1 - s) ** 2 * values[i] + s * (1 - s) ** 2 * h * slopes[i]
    return (first + s**2 * (3 - 2 * s) * values[i + 1] - s**2 * (1 - s) * h * slopes[i + 1]).T


def spring_fit(
    record: Any,
    law: Any = "rate-and-state-ageing",
    *,
    program: Sequence[Step] | None = None,
    machine_stiffness: float | str | None = None,
    drift: bool = True,
    free: Iterable[str] | None = None,
    fixed: Mapping[str, float] | None = None,
    bounds: Mapping[str, tuple[float, float]] | None = None,
    starts: int = 8,
    loss: str = "linear",
    loss_scale: float | None = None,
    intervals: str = "profile",
    load: float | None = None,
    seed: int = 0,
    progress: Progress = None,
) -> Fit:
    """Fit rate-and-state friction to a step of the sliding velocity: a, b, D_c, level and the machine's spring.

    Such a machine imposes and measures the motion of the load point. The contact lags behind it by the elastic
    shortening of machine and rock, F/k. So it is pulled through a spring, whose stiffness is searched with the law.

    record: friction force (or coefficient, for a load of 1) and displacement of the load point, sliding one way
    law: a law with one internal state, rate-and-state-ageing or rate-and-state-slip; its reference velocity is the
        first speed, so that the reference coefficient is the level before the step
    program: speeds of the load point; None: one step, found in the displacement
    machine_stiffness: N/m, where it is known; "measured": from the record, see `measured_stiffness`;
        None: searched. drift: search a level that changes with displacement.
    The other arguments, the result and the errors are those of `fit.fit`.
    """
    begin = clock.perf_counter()
    settings = Settings(starts, loss, loss_scale, intervals, seed)
    if law_class(law).internal != ("log_age",):
        raise ArgumentError("law", f"should be a rate-and-state law, got {law_class(law).name}")
    (samples,), _ = split_records(record, (), load)
    steps = tuple(program) if program is not None else found_step(samples, samples.position)
    if machine_stiffness == "measured":
        machine_stiffness = measured_stiffness(samples, steps)
    check_program(steps, samples, machine_stiffness)
    assert not isinstance(machine_stiffness, str)
    scales = data_scales([samples])
    held = {"reference_velocity": abs(steps[0].speed), **(fixed or {})}
    rise = abs(float(np.ptp(samples.force)))
    rates = [abs(math.log(after.speed / before.speed)) for before, after in itertools.pairwise(steps)]
    effect = 0.7 * rise / max(rates) / scales.load
    choice = parametrisation(law, scales, free, held, bounds)
    distance = relaxation_distance(samples, steps)
    guess = {"direct_effect": effect, "evolution_effect": effect, "critical_distance": distance}
    start = choice.space.named(choice.start)
    choice = dataclasses.replace(choice, start=choice.space.of(start | {k: v for k, v in guess.items() if k in start}))
    extra, of = [], {"nuisance": True, "unit": "N/m"}
    if machine_stiffness is None:
        spring = 2.0 * rise / distance
        own = of | {"start": math.log(spring), "meaning": "stiffness of the spring that pulls the contact"}
        extra.append(Coordinate("machine_stiffness", "log", 0.01 * spring, 100 * spring, **own))
    if drift:
        size = rise / float(np.ptp(path_of(steps, samples.time[-1])[1]))
        own = of | {"scale": size, "spread": 0.0, "meaning": "change of the force with the load point's displacement"}
        extra.append(Coordinate("drift", "linear", -10 * size, 10 * size, **own))
    space = choice.space.with_more(tuple(extra))
    choice = dataclasses.replace(choice, space=space, start=space.begun(choice.start), own_start=None)
    imposed: dict[str, Any] = {"program": steps, "machine_stiffness": machine_stiffness}
    prediction = SpringPrediction(choice.template, space, (samples,), (samples.deviation,), **imposed)
    options = {"method": "pulled through a spring", "program": [(step.time, step.speed) for step in steps]}
    options |= {"machine_stiffness": machine_stiffness, "drift": drift, "load": load, "fixed": held}
    with reporting(progress, f"Fitting {choice.template.name}") as report:
        return solution(prediction, prediction, choice, settings, (), options, begin, report)
