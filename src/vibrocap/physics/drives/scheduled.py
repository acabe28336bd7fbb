"""A drive on a schedule: the same waves one phase after another, reversed, weaker or paused."""

import functools
import itertools
import math
from typing import Any, ClassVar

from pydantic import model_validator

from vibrocap.physics.drives.drive import ROUNDING, Drive, Piecewise, Segment, segment_table
from vibrocap.physics.parameters import NonNegative, Number, inner_part, parameter, wrapped_class

PHASES = range(1, 8)
MOST_SEGMENTS = 100_000  # of a schedule, of a drive that has corners itself
COMPARED = 16  # points between any two corners at which the halves of a period are compared


class _Schedule(Piecewise):
    """What scheduled drives have in common."""

    @property
    def phases(self) -> tuple:
        """(periods of the drive, factor) of each of the seven phases."""
        return tuple((getattr(self, f"periods_{k}"), getattr(self, f"factor_{k}")) for k in PHASES)

    @property
    def wave(self) -> Any:
        return inner_part(self.wrapped, self)

    @property
    def period(self) -> float:
        return self.wave.period * sum(count for count, _ in self.phases)

    @property
    def time_scale(self) -> float:
        return self.wave.time_scale

    @property
    def continuous(self) -> bool:
        """Whether the drive never jumps, nor where one phase ends and the next begins, to rounding."""
        wave = self.wave
        last = [0.0 if isinstance(wave, Piecewise) else count * wave.period for count, _ in self.phases]
        phases = zip(self.phases, last, strict=True)
        ends = [(f * wave.value(0.0), f * wave.value(end)) for (count, f), end in phases if count > 0.0]
        bound = ROUNDING * max(abs(phase) for pair in ends for phase in pair)
        joined = all(abs(last - ends[i][0]) <= bound for i, (_, last) in enumerate(ends, 1 - len(ends)))
        return wave.continuous and joined


class _OfCorners(_Schedule):
    """A schedule of a drive that has corners or jumps of its own."""

    def segments(self) -> tuple[Segment, ...]:
        """Those of the drive, once for each of its periods."""
        whole = sum(count for count, _ in self.phases)
        segments = []
        for count, factor in self.phases:
            scaled = [
                Segment(
                    segment.length / whole, tuple(factor * c * whole**k for k, c in enumerate(segment.coefficients))
                )
                for segment in (self.wave.segments() if count else ())
            ]
            segments += scaled * int(count)
        return tuple(segments)

    @property
    def degree(self) -> int:
        return self.wave.degree

    @property
    def odd(self) -> bool:
        factors = [factor for count, factor in self.phases for _ in range(int(count))]
        half, rest = divmod(len(factors), 2)
        if self.wave.size() == 0.0 or not any(factors):
            return True
        if rest:  # half a period of the schedule is some periods of the drive and a half
            return self.wave.odd and all(factor == factors[0] for factor in factors)
        return all(one == -other for one, other in zip(factors[:half], factors[half:], strict=True))


def _in_phase(name: str) -> Any:
    """A function of the drive at time t, by the factor of the phase."""

    def function(self, t):
        present = vars(self).get("_present")
        if present is None:
            t = t - self.period * math.floor(t / self.period)
            present = self._phase_at(t)
        start, (factor, *_) = present
        return factor * getattr(self.wave, name)(t - start)

    return function


class _OfWaves(_Schedule):
    """A schedule of a drive that is smooth: the numbers of a segment are no polynomial but the factor alone."""

    def segments(self) -> tuple[Segment, ...]:
        whole = sum(count for count, _ in self.phases)
        return tuple(Segment(count / whole, (factor,)) for count, factor in self.phases)

    @property
    def degree(self) -> int:
        return 0

    def _phase_at(self, t) -> tuple[float, tuple]:
        """(start, (factor,)) of the phase that holds at a time within the first period of the schedule."""
        length, start = self.wave.period, 0.0
        phases = [phase for phase in self.phases if phase[0] > 0.0]
        for count, factor in phases[:-1]:
            if t < (start + count) * length:
                return start * length, (factor,)
            start += count
        return start * length, (phases[-1][1],)

    value, slope, curvature = map(_in_phase, ("value", "slope", "curvature"))

    @property
    def odd(self) -> bool:
        """Whether the second half of the schedule is the first one with the other sign, to rounding."""
        shares = sorted({0.0, 0.5, *((row[0] % 0.5) for row in segment_table(self))})
        pairs = [(a, b) for a, b in itertools.pairwise(shares) if b - a > ROUNDING]
        points = (a + (b - a) * (i + 0.5) / COMPARED for a, b in pairs for i in range(COMPARED))
        wave, period, length = self.wave, self.period, self.wave.period
        size = max(abs(wave.value(i * length / COMPARED)) for i in range(COMPARED))
        size *= max(abs(factor) for count, factor in self.phases if count > 0.0)
        bound = ROUNDING * size * max(1.0, period / length)  # the rounding of the time counts once for each wave
        return all(abs(self.value(x * period) + self.value((x + 0.5) * period)) <= bound for x in points)


@functools.cache
def scheduled(drive: type[Drive]) -> Any:
    """The class of a drive on a schedule: its fields, and of up to seven phases how long each lasts and by what factor.

    A gait, a pause, the same gait the other way: in phase k, which begins at t_k and lasts n_k periods T of the drive,

        u(t) = f_k u_drive(t - t_k),    t_k = T (n_1 + ... + n_(k-1))

    Each phase begins the wave anew. The factor 0 is a pause; -1 reverses the drive, with which a capsule without a
    preferred direction makes the mirror image of its motion. A phase of 0 periods is none; of a drive with corners or
    jumps phases last whole periods. All n_k periods together are one period of the schedule, after which it repeats.

    drive: a drive that is not scheduled yet
    Returns the class, the same one each time: `scheduled(Harmonic)(amplitude=1.8, periods_1=20.0, periods_2=5.0)`.
    Raises ValueError for a drive that begins anew with its period without a corner there (a ramp).
    """
    if scheduled in drive.wrappers:
        raise ValueError(f"the {drive.name} drive is scheduled already")
    if "rate" in getattr(drive, "__dataclass_fields__", ()):
        raise ValueError(f"only a drive that is a function of time alone can be scheduled, got the {drive.name} drive")
    cornered = issubclass(drive, Piecewise)
    kind: Any = _OfCorners if cornered else _OfWaves
    base: Any = drive

    class Scheduled(kind, base):
        periods_1: NonNegative = parameter(10.0, "n1", "length of phase 1 in periods of the drive", "convention")
        factor_1: Number = parameter(1.0, "f1", "factor of the drive in phase 1", "convention")
        periods_2: NonNegative = parameter(5.0, "n2", "length of phase 2 in periods of the drive", "convention")
        factor_2: Number = parameter(0.0, "f2", "factor of the drive in phase 2", "convention")
        periods_3: NonNegative = parameter(0.0, "n3", "length of phase 3 in periods of the drive", "convention")
        factor_3: Number = parameter(0.0, "f3", "factor of the drive in phase 3", "convention")
        periods_4: NonNegative = parameter(0.0, "n4", "length of phase 4 in periods of the drive", "convention")
        factor_4: Number = parameter(0.0, "f4", "factor of the drive in phase 4", "convention")
        periods_5: NonNegative = parameter(0.0, "n5", "length of phase 5 in periods of the drive", "convention")
        factor_5: Number = parameter(0.0, "f5", "factor of the drive in phase 5", "convention")
        periods_6: NonNegative = parameter(0.0, "n6", "length of phase 6 in periods of the drive", "convention")
        factor_6: Number = parameter(0.0, "f6", "factor of the drive in phase 6", "convention")
        periods_7: NonNegative = parameter(0.0, "n7", "length of phase 7 in periods of the drive", "convention")
        factor_7: Number = parameter(0.0, "f7", "factor of the drive in phase 7", "convention")

        shape_parameters: ClassVar = (
            *getattr(drive, "shape_parameters", ()),
            *(f"periods_{k}" for k in PHASES if cornered),
        )

        @model_validator(mode="after")
        def _some_phase(self):
            phases = [count for count, _ in self.phases]
            if not sum(phases) > 0.0:
                raise ValueError("periods_1 should be greater than 0, or that of another phase, got no phase at all")
            if cornered:
                for k, count in enumerate(phases, 1):
                    if count != math.floor(count):
                        why = f"as the {drive.name} drive has corners of its own"
                        raise ValueError(f"periods_{k} should be a whole number, {why}, got {count:g}")
                count_of_segments = len(self.wave.segments())
                if sum(phases) * count_of_segments > MOST_SEGMENTS:
                    most = f"at most {MOST_SEGMENTS // count_of_segments} periods in all"
                    raise ValueError(f"periods_1 should leave the schedule {most}, got {sum(phases):g}")
            return self

    if drive.slope is Drive.slope:
        Scheduled.slope, Scheduled.curvature = Drive.slope, Drive.curvature
    return wrapped_class(scheduled, Scheduled, drive)
