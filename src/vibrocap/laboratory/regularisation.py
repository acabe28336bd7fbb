"""What smoothing a set-valued contact would cost: the error of a measure against the width of the smoothing."""

import dataclasses
import math
from collections.abc import Sequence
from typing import Any, Literal

import numpy as np

from vibrocap.arguments import ArgumentError
from vibrocap.laboratory.driven import check_numbers, checked_list
from vibrocap.measures.during_run import measured
from vibrocap.measures.measure import Measure
from vibrocap.measures.of_measure import ManyOfMeasure, OneOfMeasure, OneWanted, measure_unit
from vibrocap.motion.simulate import simulate
from vibrocap.motion.status import Status
from vibrocap.physics.friction.wrappers import smoothed
from vibrocap.physics.names import numbered
from vibrocap.physics.parameters import parameter_table
from vibrocap.physics.system import System
from vibrocap.quantities.declared import ByName, Number, Numbers, Speed, Speeds
from vibrocap.quantities.dimensional import Dimensional, said

Shape = Literal["tanh", "arctan"]
LOOSER = 10.0  # times the tolerance: that of the run beside each, which tells the noise
DECADES, PER_DECADE = 6, 2  # of widths looked at by default, below a tenth of the fastest sliding
ABOVE_NOISE = 5.0  # times the error of integration: an error of smoothing that is known
EVEN = 0.1  # by which the slopes between neighbouring widths may differ within one order
POLISHED = 1.02  # ratio of the widths between which the one asked for is known to lie
SURE = 3  # widths in a row, half a decade apart, at which a wanted error is met
NARROWEST = 1e-12  # of the fastest sliding: where a search for a width ends


@dataclasses.dataclass(frozen=True)
class SmoothedRun(Dimensional):
    """One run with a smoothed contact (or, at width 0, with the exact one).

    value: of the measure, NaN where the run could not be completed; steps: of the integrator
    noise: difference of the measure from a run at ten times the tolerance, a bound of the error of integration
    """

    width: Speed
    value: OneOfMeasure
    noise: OneOfMeasure
    steps: int
    status: Status


@dataclasses.dataclass(frozen=True, eq=False)
class Regularisation(Dimensional):
    """Error of a measure when the contact is smoothed, at several widths.

    exact: the run with the contact solved exactly; runs: the smoothed ones, from wide to narrow
    speed: the fastest sliding of the exact motion, against which a width looks small or not
    order: exponent p of an error ~ width^p, fitted between the widths `order_range`; None where there is no such range
    smooth: whether the error keeps its sign and falls with the width throughout, where it is above the noise
    """

    system: System
    measure: str
    shape: Shape
    exact: SmoothedRun
    runs: tuple[SmoothedRun, ...]
    speed: Speed
    order: Number | None
    order_range: tuple[Speed, Speed] | None
    smooth: bool

    @property
    def widths(self) -> Speeds:
        return np.array([run.width for run in self.runs])

    @property
    def errors(self) -> ManyOfMeasure:
        """Value less the exact one [n]; NaN where a run could not be completed."""
        return np.array([run.value for run in self.runs]) - self.exact.value

    @property
    def relative_errors(self) -> Numbers:
        """Errors over the size of the exact value [n]; infinite or NaN where that is zero."""
        with np.errstate(divide="ignore", invalid="ignore"):
            return self.errors / abs(self.exact.value)

    @property
    def noise(self) -> ManyOfMeasure:
        """Bound of the error of integration in each error [n]."""
        return np.array([run.noise for run in self.runs]) + self.exact.noise

    @property
    def steps(self) -> Numbers:
        return np.array([run.steps for run in self.runs])

    @property
    def text(self) -> str:
        """The report in words."""
        widest, narrowest = self.runs[0], self.runs[-1]
        ends = f"{widest.value:.6g} at width {widest.width:.2g} and {narrowest.said('value', 6)} at"
        words = f"{self.measure} is {self.exact.said('value', 6)} exactly, in {self.exact.steps} steps; smoothed by "
        words += f"{self.shape} it is {ends} {narrowest.said('width', 2)}, in {narrowest.steps} steps."
        if self.order is not None and self.order_range is not None:
            low, high = self.order_range
            between = f"{low:.2g} and {said(high, narrowest.unit_of('width'), 2)}"
            words += f" Its error goes with the width to the power {self.order:.2f} between {between}."
        return words if self.smooth else f"{words} It is not smooth in the width: the error jumps or changes its sign."


@dataclasses.dataclass(frozen=True, eq=False)
class WidthNeeded(Dimensional):
    """The width of smoothing at which a measure has a wanted error.

    width: the largest below which all runs made had no larger error, to 2 % (but at most a tenth of the fastest
        sliding, the widest that is tried); None where none of them was narrow enough
    error: that was asked for, in the unit of the measure; run: the smoothed run at the width
    regularisation: all runs that were made, with order and smoothness; where that says not smooth, other widths between
        those of the runs may do as well or worse
    """

    width: Speed | None
    error: OneOfMeasure
    run: SmoothedRun | None
    regularisation: Regularisation


def regularisation_error(
    system: System,
    measure: str | Measure = "displacement",
    widths: Sequence[Speed] | None = None,
    *,
    shape: Shape = "tanh",
    periods: int = 40,
    window: int | None = None,
    settle: float | None = None,
    initial: ByName | None = None,
    tolerance: float = 1e-10,
) -> Regularisation:
    """Error that a smoothed contact of given width makes in a measure of a motion.

    The contact that sticks is replaced by one that creeps, R = S(v/width) |R(v)| with S = tanh or (2/pi) arctan, and
    both systems are run from the same start by the same integrator, each also at ten times the tolerance.

    system: with a set-valued law
    measure: a name of `measure_table()` or a measure of one's own, that is a number
    widths: by default from a tenth of the fastest sliding down by six decades
    window: last whole drive periods that are measured, by default all of them; settle: see `measured`

    Raises ValueError, naming the argument, before any work; RuntimeError where the exact motion cannot be completed.
    """
    meter = _Meter(system, measure, shape, periods, window, settle, initial, tolerance)
    usual = 0.1 * meter.speed * np.logspace(0, -DECADES, 1 + DECADES * PER_DECADE)
    own = usual if widths is None else np.unique(checked_list("widths", widths))[::-1]
    return meter.regularisation([meter.run(float(width)) for width in own])


def width_for(
    system: System,
    measure: str | Measure = "displacement",
    error: OneWanted = 0.01,
    *,
    relative: bool = True,
    shape: Shape = "tanh",
    periods: int = 40,
    window: int | None = None,
    settle: float | None = None,
    initial: ByName | None = None,
    tolerance: float = 1e-10,
) -> WidthNeeded:
    """The width that a smoothed contact needs for a wanted error in a measure.

    error: wanted, over the exact value; with relative=False in the unit of the measure
    The other arguments are those of `regularisation_error`.

    From a tenth of the fastest sliding down by decades until the error is met, and by half decades until it is met
    three times in a row; then between the widest of these and the one before it by false position on the logarithms.
    Raises ValueError also where the error asked for is within the error of integration.
    """
    check_numbers(error=error)
    meter = _Meter(system, measure, shape, periods, window, settle, initial, tolerance)
    wanted = error * abs(meter.exact.value) if relative else float(error)
    if wanted == 0.0:
        raise ArgumentError("relative", f"should be False: the exact {meter.name} is zero, got error {error!r}")
    if wanted <= (least := ABOVE_NOISE * meter.exact.noise):
        unit, scale = measure_unit(measure, system)
        above, got = (said(x * (scale or 1.0), unit, 2) for x in (least, wanted))
        what = f"should be above that of integration, {above}, got {got}; or choose a smaller tolerance"
        raise ArgumentError("error", what)
    runs: list[SmoothedRun] = []

    def excess(run: SmoothedRun) -> float:
        """ln of |error| over the wanted one; positive: too large."""
        difference = abs(run.value - meter.exact.value)
        return math.log(max(difference, 1e-300) / wanted) if math.isfinite(difference) else math.inf

    width = 0.1 * meter.speed
    met = 0
    while met < SURE:
        if width < NARROWEST * meter.speed:
            return WidthNeeded(None, wanted, None, meter.regularisation(runs))
        runs.append(meter.run(width))
        met = met + 1 if excess(runs[-1]) <= 0.0 else 0
        width *= 0.1 if met == 0 else math.sqrt(0.1)
    good, bad = runs[-SURE], runs[-SURE - 1] if len(runs) > SURE else None
    while bad is not None and bad.width > POLISHED * good.width:
        low, high = excess(good), excess(bad)
        share = -low / (high - low) if math.isfinite(high) else 0.5
        share = min(0.9, max(0.1, share))  # bisection where the secant would creep
        between = meter.run(good.width * (bad.width / good.width) ** share)
        runs.append(between)
        good, bad = (between, bad) if excess(between) <= 0.0 else (good, between)
    return WidthNeeded(good.width, wanted, good, meter.regularisation(runs))


class _Meter:
    """Runs of one system, exact and smoothed, with one measure of each."""

    shape: Shape

    def __init__(self, system, measure, shape, periods, window, settle, initial, tolerance):
        if not isinstance(system, System):
            raise ArgumentError("system", f"should be a System, got {system!r}")
        if shape not in ("tanh", "arctan"):
            raise ArgumentError("shape", f"should be 'tanh' or 'arctan', got {shape!r}")
        self.kinds = [smoothed(type(law)) for law in system.laws]  # refuses laws that are not set-valued
        self.system, self.shape, self._measure, self._tolerance = system, shape, measure, tolerance
        self.name = measure.name if isinstance(measure, Measure) else measure
        self._options = {"window": int(periods) if window is None else window, "settle": settle}
        self._run = {"periods": periods, "initial": initial}
        motion = simulate(system, tolerance=tolerance, **self._run)
        if not motion.status.ok:
            raise RuntimeError(f"the exact motion could not be completed ({motion.status.value}): {motion.status.text}")
        velocities = [motion[numbered("contact_velocity", i)] for i in range(1, 1 + len(self.kinds))]
        self.speed = float(np.max(np.abs(velocities)))
        if self.speed == 0.0:
            raise ArgumentError("system", "should move: no contact slides in this motion")
        self.exact = self._measured(system, 0.0, motion)

    def run(self, width: float) -> SmoothedRun:
        """The run with all contacts smoothed over a width."""
        laws = []
        for kind, law in zip(self.kinds, self.system.laws, strict=True):
            values = {info.name: getattr(law, info.name) for info in parameter_table(law)}
            laws.append(kind(**values | {"smoothing_velocity": width, "shape": self.shape}))
        smooth = dataclasses.replace(self.system, friction=laws, further=())
        return self._measured(smooth, width, simulate(smooth, tolerance=self._tolerance, **self._run))

    def _measured(self, system: System, width: float, motion: Any) -> SmoothedRun:
        values = []
        for run in (motion, simulate(system, tolerance=min(LOOSER * self._tolerance, 1e-2), **self._run)):
            value = measured(run, self._measure, **self._options)[self.name] if run.status.ok else math.nan
            if isinstance(value, str):
                raise ArgumentError("measure", f"should be a number, got {self.name!r}, which is a text")
            values.append(float(value))
        return SmoothedRun(width, values[0], abs(values[0] - values[1]), len(motion.piece_start), motion.status)

    def regularisation(self, runs: Sequence[SmoothedRun]) -> Regularisation:
        """All runs together, from wide to narrow."""
        ordered = tuple(sorted(runs, key=lambda run: -run.width))
        if all(run.status.ok and math.isnan(run.value) for run in ordered):
            raise ArgumentError("measure", f"should exist for a contact that cannot stick, got {self.name!r}")
        order, span, smooth = _fitted_order(ordered, self.exact)
        return Regularisation(self.system, self.name, self.shape, self.exact, ordered, self.speed, order, span, smooth)


def _fitted_order(
    runs: Sequence[SmoothedRun], exact: SmoothedRun
) -> tuple[float | None, tuple[float, float] | None, bool]:
    """(order, widths between which it holds, whether the error is smooth), of the errors above the noise.

    The range begins at the narrowest width and extends as long as the slope between neighbours stays even; it takes
    three widths over a decade to make an order.
    """
    known = [run for run in runs if abs(run.value - exact.value) > ABOVE_NOISE * (run.noise + exact.noise)][::-1]
    errors = np.array([run.value - exact.value for run in known])
    widths = np.array([run.width for run in known])
    growing = np.all(errors[1:] * errors[:-1] > 0.0) and np.all(np.diff(np.abs(errors)) > 0.0)
    smooth = all(math.isfinite(run.value) for run in runs) and bool(growing)
    apart = np.append(True, np.diff(np.log(widths)) > 0.1)  # the last steps of a search lie too close for a slope
    errors, widths = errors[apart[: len(errors)]], widths[apart[: len(widths)]]
    if len(widths) < 3:
        return None, None, smooth
    with np.errstate(divide="ignore"):
        slopes = np.diff(np.log(np.abs(errors))) / np.diff(np.log(widths))
    even = (np.abs(slopes - slopes[0]) <= EVEN) & (errors[1:] * errors[0] > 0.0)
    count = 1 + (len(even) if even.all() else int(np.argmin(even)))
    if count < 3 or widths[count - 1] < 10.0 * widths[0]:
        return None, None, smooth
    order = float(np.polyfit(np.log(widths[:count]), np.log(np.abs(errors[:count])), 1)[0])
    return order, (float(widths[0]), float(widths[count - 1])), smooth
