"""A record made ready for a fit: its motion completed and filtered without delay, inertia taken off its force."""

from typing import Literal

import numpy as np

from vibrocap.arguments import ArgumentError
from vibrocap.records.record import Record, integral, not_positive

ORDER = 4  # of the Butterworth filter, once forward and once backward
HIGHEST = 0.49  # of the sampling rate; at half of it nothing is left to filter
FEWEST_PERIODS = 1.0  # of the cut-off frequency that a record should last
FILTER_DECAY = 6.0  # periods of the cut-off in which the slowest pole decays, by exp(-6 (2 pi) sin(pi/8)) = 5e-7
MOST_SAMPLES = 20_000_000  # of the even grid of an uneven record


def prepared(
    record: Record,
    *,
    cutoff: float | None = None,
    mass: float | None = None,
    offset: float | Literal["mean"] | None = None,
    filter_force: bool = False,
) -> Record:
    """The record with velocity and displacement both, its motion filtered, and the friction force alone.

    Derivatives amplify noise, so the motion is filtered below `cutoff` first, forward and backward, which leaves no
    delay between force and motion (a delay would be fitted as hysteresis):

        gain(f) = 1 / (1 + (f/cutoff)^8)    a Butterworth filter of order 4, applied twice

    White noise of standard deviation s in a displacement sampled at the rate f_s gives a velocity with noise

        0.729 s (2 pi cutoff) sqrt(cutoff/f_s),    0.729^2 = 2 (integral of u^2/(1 + u^8)^2 du from 0 to infinity)

    Take the cut-off well above the frequencies of the motion itself, the reversals included: at half the cut-off a sine
    is lowered by 0.4 %.

    cutoff: Hz; without it nothing is filtered: a velocity is then the derivative of the cubic spline through the
        displacements, right for clean data only
    mass: kg; the inertia mass times acceleration is taken off the force. The acceleration is the record's own, else the
        derivative of the filtered motion, for which `cutoff` is needed
    offset: N, taken off the force; "mean" takes its mean, which is right only where both directions are sampled alike
    filter_force: filter the force like the motion

    An unevenly sampled record is filtered on an even grid, linear in between, and brought back to its own times. Within
    about a period of the cut-off from either end, filtered values rest on the record continued as its mirror image. The
    displacement made from a velocity begins at 0. Returns a new Record whose notes say what was done. Raises ValueError
    naming the setting.
    """
    from scipy.interpolate import CubicSpline

    _check(record, cutoff, mass, offset)
    notes = list(record.notes)
    velocity, displacement, acceleration = record.velocity, record.displacement, record.acceleration
    smooth = _Filter(record.time, cutoff) if cutoff is not None else None
    if smooth is not None:
        notes.append(f"motion: filtered below {cutoff:g} Hz, forward and backward (Butterworth, order {ORDER})")
    if displacement is None:
        assert velocity is not None
        displacement = integral(record.time, velocity)
        notes.append("displacement: integral of the velocity")
    if velocity is None:
        velocity = smooth(displacement, 1) if smooth else CubicSpline(record.time, displacement)(record.time, nu=1)
        notes.append("velocity: derivative of the displacement")
        if smooth and acceleration is None:
            acceleration = smooth(displacement, 2)
            notes.append("acceleration: second derivative of the displacement")
    elif smooth:
        if acceleration is None:
            acceleration = smooth(velocity, 1)
            notes.append("acceleration: derivative of the velocity")
        velocity = smooth(velocity, 0)
    if smooth:
        displacement = smooth(displacement, 0)
        if record.acceleration is not None:
            acceleration = smooth(record.acceleration, 0)
    force = record.force
    if smooth and filter_force:
        force = smooth(force, 0)
        notes.append("force: filtered like the motion")
    if offset is not None:
        taken = float(np.mean(force)) if offset == "mean" else float(offset)
        force = force - taken
        notes.append(f"force: less an offset of {taken:.6g} N")
    if mass is not None:
        assert acceleration is not None
        force = force - mass * acceleration
        notes.append(f"force: less the inertia of {mass:g} kg")
    motion = {"velocity": velocity, "displacement": displacement, "acceleration": acceleration}
    return record.replaced(force=force, **motion, notes=tuple(notes))


class _Filter:
    """Values and derivatives of a column below a cut-off frequency, at the record's own times."""

    def __init__(self, time: np.ndarray, cutoff: float):
        from scipy.signal import butter

        span = time[-1] - time[0]
        count, steps = len(time), np.diff(time)
        if np.max(steps) - np.min(steps) > 0.01 * np.mean(steps):
            # An even grid with the shorter intervals of the record, and at least 8 samples in a period of the cut-off.
            step = min(float(np.quantile(steps, 0.1)), 1.0 / (8.0 * cutoff))
            count = int(np.ceil(span / step)) + 1
            if count > MOST_SAMPLES:
                gaps = f"has gaps of up to {np.max(steps):.4g} s between samples {step:.4g} s apart"
                raise ArgumentError("time", f"{gaps}; should be split at the gaps into records (`between`)")
        self.time = time
        self.even = np.linspace(time[0], time[-1], count)
        self.step = span / (count - 1)
        self.sections = butter(ORDER, cutoff, fs=1.0 / self.step, output="sos")
        self.padding = int(min(count - 1, np.ceil(FILTER_DECAY / (cutoff * self.step))))

    def __call__(self, values: np.ndarray, derivative: int) -> np.ndarray:
        """The filtered values, or their first or second derivative."""
        from scipy.interpolate import make_interp_spline
        from scipy.signal import sosfiltfilt

        even = np.interp(self.even, self.time, values)
        # The straight line from the first sample to the last passes any such filter; taken off, it costs no digits.
        slope = (even[-1] - even[0]) / (self.even[-1] - self.even[0])
        line = even[0] + slope * (self.even - self.even[0])
        low = sosfiltfilt(self.sections, even - line, padtype="odd", padlen=self.padding)
        result = make_interp_spline(self.even, low, k=5)(self.time, nu=derivative)
        if derivative == 0:
            return result + even[0] + slope * (self.time - self.even[0])
        return result + slope if derivative == 1 else result


def _check(record: Record, cutoff: float | None, mass: float | None, offset: float | str | None) -> None:
    wrong = not_positive({"cutoff": cutoff, "mass": mass})
    lowest, highest = FEWEST_PERIODS / record.duration, HIGHEST * record.sampling_rate
    if isinstance(offset, str) and offset != "mean":
        wrong.append(f"offset: should be a number of newtons or 'mean', got {offset!r}")
    elif offset is not None and not isinstance(offset, str) and not np.isfinite(offset):
        wrong.append(f"offset: should be a finite number of newtons, got {offset!r}")
    if not wrong and cutoff is not None and not lowest <= cutoff < highest:
        wrong.append(
            f"cutoff: should be at least {lowest:.4g} Hz (a period in the record) and below {highest:.4g} Hz "
            f"(about half the sampling rate), got {cutoff:g}"
        )
    if not wrong and mass is not None and cutoff is None and record.acceleration is None:
        wrong.append(
            "cutoff: is missing; mass needs an acceleration, which the record does not have, and an unfiltered "
            "derivative would be noise; give the cut-off in Hz"
        )
    if wrong:
        raise ArgumentError(f"record {record.name!r}", "\n  ".join(["cannot be prepared:", *wrong]))
