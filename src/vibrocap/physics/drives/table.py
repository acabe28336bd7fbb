import itertools
from typing import Annotated, Any, ClassVar, Literal

from pydantic import BeforeValidator, model_validator

from vibrocap.physics.drives.drive import ROUNDING, Piecewise, Segment
from vibrocap.physics.parameters import Number, Positive, parameter, parameters

FEWEST = {"linear": 2, "cubic": 3}  # points, besides the last one


def _numbers(values: Any) -> Any:
    if isinstance(values, (str, bytes)) or not hasattr(values, "__iter__"):
        raise ValueError("should be a list of numbers")
    numbers = []
    for i, value in enumerate(values, start=1):
        try:
            number = float("nan") if isinstance(value, (bool, str)) else float(value)
        except (TypeError, ValueError):
            number = float("nan")
        if not abs(number) < 1e300:
            raise ValueError(f"should be finite numbers; number {i} is {value!r}")
        numbers.append(number)
    return tuple(numbers)


Numbers = Annotated[Any, BeforeValidator(_numbers)]


@parameters
class DriveTable(Piecewise):
    """Values at instants of one period, with straight lines or cubics between them; nothing is resampled.

    The first and the last instant are one period apart and have the same value: a table that does not close would jump
    unseen. Between two points a cubic has the values and slopes of both, the slope being that of the parabola through
    a point and its two neighbours; so the drive and its slope are continuous. Of a wave that jumps make `Phases`.

    amplitude and stretch multiply the values and the times. Odd under half a period where the second half of the
    table is the first one with the other sign, point by point.
    """

    times: Numbers = parameter(
        (0.0, 1.0, 2.0, 3.0, 4.0), "t_i", "instants, the last one a period after the first", "duration"
    )
    values: Numbers = parameter((0.0, 1.0, 0.0, -1.0, 0.0), "h_i", "force or torque at these instants", "effort")
    interpolation: Literal["cubic", "linear"] = parameter("cubic", "interpolation", "cubic or linear between them")
    amplitude: Number = parameter(1.0, "a", "factor of the values", "convention")
    stretch: Positive = parameter(1.0, "s", "factor of the times", "convention")

    name: ClassVar[str] = "table"
    source: ClassVar[str] = "vibrocap"

    @model_validator(mode="after")
    def _closes(self):
        times, values = self.times, self.values
        fewest = FEWEST[self.interpolation] + 1
        if len(times) < fewest:
            raise ValueError(f"times should be at least {fewest} instants, got {len(times)}")
        if len(values) != len(times):
            raise ValueError(f"values should be one for each of the {len(times)} times, got {len(values)}")
        for i, (one, other) in enumerate(itertools.pairwise(times), start=2):
            if not other > one:
                raise ValueError(f"times should increase: number {i} is not after the one before")
        if abs(values[-1] - values[0]) > ROUNDING * max(map(abs, values)):
            raise ValueError("values should end as they begin, as the table is one period")
        return self

    def segments(self) -> tuple[Segment, ...]:
        whole = self.times[-1] - self.times[0]
        lengths = [(b - a) / whole for a, b in itertools.pairwise(self.times)]
        values = self.values
        secants = [(b - a) / length for (a, b), length in zip(itertools.pairwise(values), lengths, strict=True)]
        if self.interpolation == "linear":
            return tuple(map(Segment, lengths, zip(values, secants, strict=False)))
        slopes = [
            (secants[i - 1] * lengths[i] + secants[i] * lengths[i - 1]) / (lengths[i - 1] + lengths[i])
            for i in range(len(lengths))
        ]
        segments = []
        for i, (length, secant) in enumerate(zip(lengths, secants, strict=True)):
            before, after = slopes[i], slopes[(i + 1) % len(slopes)]
            square = (3.0 * secant - 2.0 * before - after) / length
            cube = (before + after - 2.0 * secant) / (length * length)
            segments.append(Segment(length, (values[i], before, square, cube)))
        return tuple(segments)

    def size(self):
        return self.amplitude

    @property
    def period(self) -> float:
        return self.stretch * (self.times[-1] - self.times[0])
