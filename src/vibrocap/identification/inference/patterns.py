"""Patterns that faults add to a force, with place, time, direction, speed and acceleration, and the test for one: least
squares beside what the fit can absorb, for coloured, uneven noise.

Errors are correlated in time and larger in some samples than in others. So error and columns are whitened by an
autoregressive model of what the pattern leaves (Cochrane and Orcutt 1949), of the order that Schwarz's criterion
chooses, and the pattern's coefficients b are compared with their covariance, once for errors of one size and once for
any (White 1980, with the leverage of MacKinnon and White 1985). The less sure of both counts:

    W = b^T V^-1 b,  F-distributed with k and n/tau - k degrees of freedom over k, where there is no pattern

with the correlation time tau of what the pattern leaves. The variance of the errors is taken over as many degrees of
freedom, too: that is safe rather than sharp in coloured noise, whose model is learnt from few independent samples.
"""

import dataclasses
from collections.abc import Callable, Sequence

import numpy as np

from vibrocap.identification.inference.errors import RecordErrors, together

ORDER = 30  # largest of the autoregressive model
KEPT = 1e-8  # of a column's square that others must leave for it to be a column of its own


@dataclasses.dataclass(frozen=True, eq=False)
class Pattern:
    """Columns [n, k] that a cause would add to the force; tries: how many such patterns were looked through for it.

    sparse: they are large in a few samples only, too few for their errors to tell how large errors are there.
    waves: whether the last three are a sine, a cosine and a constant.
    """

    columns: np.ndarray
    tries: float = 1.0
    sparse: bool = False
    waves: bool = False


def basis_of(columns: np.ndarray) -> np.ndarray:
    """Orthonormal columns [n, r] of the same span; none for what is rounding."""
    size = np.sqrt(np.sum(columns**2, axis=0))
    columns = columns[:, size > 0] / size[size > 0]
    if not columns.shape[1]:
        return columns
    values, vectors = np.linalg.eigh(columns.T @ columns)
    kept = values > KEPT * len(values)
    return columns @ (vectors[:, kept] / np.sqrt(values[kept]))


def without(values: np.ndarray, basis: np.ndarray) -> np.ndarray:
    """Values [n] or [n, k] less their projection."""
    return values - basis @ (basis.T @ values) if basis.shape[1] else values


def explained(error: np.ndarray, basis: np.ndarray, pattern: Pattern) -> tuple[float, np.ndarray]:
    """(share of an error's squares that a pattern explains, what it leaves); the error has no part in the basis."""
    rest = without(error, _own(pattern.columns, basis))
    return 1.0 - float(rest @ rest) / max(float(error @ error), 1e-300), rest


def _own(columns: np.ndarray, basis: np.ndarray) -> np.ndarray:
    """A basis of what columns have beside another one."""
    left = without(columns, basis)
    return basis_of(left[:, np.sum(left**2, axis=0) > KEPT * np.sum(columns**2, axis=0)])


def probability(
    error: np.ndarray, absorbed: np.ndarray, pattern: Pattern, rest: np.ndarray, cuts: Sequence[int]
) -> float:
    """Probability with which noise alone would show as much of a pattern; times the tries, at most 1.

    absorbed [n, p]: columns that the fit adapts; rest [n]: what the pattern leaves; cuts: where records begin.
    """
    from scipy.special import fdtrc

    model, time = autoregression(np.split(rest, cuts))
    white, fitted, columns = (filtered(column, model, cuts) for column in (error[:, None], absorbed, pattern.columns))
    basis = basis_of(fitted)
    own = _own(columns, basis)
    n, k = own.shape
    free = n / time - k - basis.shape[1]
    if k == 0 or free < 5:
        return 1.0
    target = without(white[:, 0], basis)
    coefficients = own.T @ target
    remaining = target - own @ coefficients
    sure = float(coefficients @ coefficients) / max(float(remaining @ remaining) / free, 1e-300)
    if not pattern.sparse:
        leverage = np.minimum(np.sum(own**2, axis=1), 0.9)
        uneven = own * (remaining / (1 - leverage))[:, None]
        of_any_size = coefficients @ np.linalg.lstsq(uneven.T @ uneven, coefficients, rcond=None)[0]
        sure = min(sure, float(of_any_size))
    return min(float(fdtrc(k, free, sure / k)) * pattern.tries, 1.0)


def autoregression(series: Sequence[np.ndarray]) -> tuple[np.ndarray, float]:
    """(coefficients a_1.. of e_i = a_1 e_i-1 + ... (Levinson and Durbin), its correlation time in samples, at least 1).

    The order is that with the least criterion; tau = s^2 / (1 - sum a)^2 with the share s^2 that the model leaves.
    """
    n = sum(len(piece) for piece in series)
    most = min(ORDER, n // 20)
    products = [[float(piece[k:] @ piece[: max(len(piece) - k, 0)]) for piece in series] for k in range(most + 1)]
    sums = np.array([sum(lag) for lag in products])
    if not sums[0] > 0:
        return np.empty(0), 1.0
    a, left, best, least, time = np.empty(0), 1.0, np.empty(0), 0.0, 1.0
    rho = sums / sums[0]
    for order in range(1, most + 1):
        reflection = (rho[order] - float(a @ rho[order - 1 : 0 : -1])) / left
        a = np.append(a - reflection * a[::-1], reflection)
        left *= 1 - reflection**2
        if not left > 1e-12:
            break
        criterion = n * np.log(left) + np.log(n) * order
        if criterion < least:
            best, least = a, criterion
            time = left / max(1 - float(np.sum(a)), 1e-6) ** 2
    return best, max(time, 1.0)


def filtered(columns: np.ndarray, model: np.ndarray, cuts: Sequence[int]) -> np.ndarray:
    """Columns [n, k] less what the model says of each sample, record by record."""
    if not len(model) or not columns.shape[1]:
        return columns
    less, pieces = np.concatenate(([1.0], -model)), []
    for piece in np.split(columns, cuts):
        left = np.transpose([np.convolve(column, less)[: len(piece)] for column in piece.T])
        pieces.append(left[min(len(model), len(piece) // 2) :])
    return np.concatenate(pieces)


BINS = 10  # of a covariate, with as many samples each
DEGREE = 3  # of a drift's polynomials in time
LEAST_WAVES, MOST_WAVES, PER_WAVE = 1.5, 400, 3  # waves of a ripple along the path; samples of a wave at full speed
FEWEST_TURNS = 4  # reversals that tell of what comes after them
FINER = 4  # points of the spectrum for each wave along the path
REFINED = 12  # halvings about the spectrum's peak


Column = Callable[[RecordErrors], np.ndarray]  # a force in N


def columns_of(records: Sequence[RecordErrors], *columns: Column) -> np.ndarray:
    """Forces [n, columns] of all records, over their units, of the samples that count."""
    parts = [[(column(record) / record.unit)[record.counts] for record in records] for column in columns]
    return np.stack([np.concatenate(part) for part in parts], axis=1)


def one(record: RecordErrors) -> np.ndarray:
    return np.ones_like(record.time)


def inertia(records: Sequence[RecordErrors]) -> Pattern:
    """A mass that the sensor carries: the acceleration."""
    return Pattern(columns_of(records, lambda x: x.acceleration))


def restoring(records: Sequence[RecordErrors]) -> Pattern:
    """A spring, or gravity on what turns: the place, or its sine and cosine; and a constant, for its middle."""
    if any(record.rotary for record in records):
        return Pattern(columns_of(records, lambda x: np.sin(x.place), lambda x: np.cos(x.place), one), waves=True)
    return Pattern(columns_of(records, lambda x: x.place - x.place.mean(), one))


def swinging(records: Sequence[RecordErrors]) -> Pattern:
    """A restoring force with inertia, as of a pendulum or a mass on a spring: both patterns at once."""
    place = restoring(records)
    return dataclasses.replace(place, columns=np.concatenate([inertia(records).columns, place.columns], axis=1))


def drift(records: Sequence[RecordErrors]) -> Pattern:
    """A sensor's zero, or the level of friction, that changes in the course of a record: polynomials in time."""
    columns: list[Column] = [one]
    for power in range(1, DEGREE + 1):
        legendre = np.polynomial.legendre.Legendre.basis(power)
        columns.append(lambda record, of=legendre: of(2 * record.time / record.time[-1] - 1))
        columns.append(lambda record, of=legendre: of(2 * record.time / record.time[-1] - 1) * record.predicted)
    return Pattern(columns_of(records, *columns))


def direction(records: Sequence[RecordErrors]) -> Pattern:
    """Levels that differ by direction: a constant, and the direction."""
    return Pattern(columns_of(records, one, lambda record: record.side))


def constant(records: Sequence[RecordErrors]) -> Pattern:
    """An offset of the force sensor: a constant."""
    return Pattern(columns_of(records, one))


def odd_in_velocity(records: Sequence[RecordErrors]) -> np.ndarray:
    """Means [n, bins] over bins of the speed, times the direction: any odd function of the velocity."""
    return _bins(np.abs(together(records, "velocity"))).columns * together(records, "side")[:, None]


def speed(records: Sequence[RecordErrors]) -> Pattern:
    """Another curve over the velocity: means over bins of it."""
    return _bins(together(records, "velocity"))


def position(records: Sequence[RecordErrors]) -> Pattern:
    """Another force at each place, or another friction: means over bins of the place, with and without direction."""
    bins, side = _bins(together(records, "place")).columns, together(records, "side")
    return Pattern(np.concatenate([bins, bins * side[:, None]], axis=1))


def presliding(records: Sequence[RecordErrors]) -> Pattern:
    """Another yielding after reversals: means over bins of the distance since the last one, times the direction.

    The bins end at doubling shares of the longest such distance.
    """
    paths, turns = [], 0
    for record in records:
        turns += int(np.sum(record.turned))
        begin = np.maximum.accumulate(np.where(record.turned, np.arange(len(record.time)), 0))
        paths.append(np.abs(record.place - record.place[begin])[record.counts])
    path = np.concatenate(paths)
    if turns < FEWEST_TURNS:
        return Pattern(np.empty((len(path), 0)))
    edges = float(path.max()) * 0.5 ** np.arange(BINS - 1, 0, -1)
    return Pattern(_indicators(np.searchsorted(edges, path)) * together(records, "side")[:, None])


def _bins(column: np.ndarray) -> Pattern:
    edges = np.quantile(column, np.linspace(0, 1, BINS + 1)[1:-1])
    return Pattern(_indicators(np.searchsorted(edges, column)))


def _indicators(bins: np.ndarray) -> np.ndarray:
    return (bins[:, None] == np.unique(bins)).astype(float)


def waves(records: Sequence[RecordErrors], length: float, directed: bool) -> np.ndarray:
    """Cosine and sine [n, 2] of a wavelength along the place, times the direction or not."""
    size = (together(records, "side") if directed else 1.0) / units_of(records)
    phase = 2 * np.pi / length * together(records, "place")
    return np.stack([np.cos(phase) * size, np.sin(phase) * size], axis=1)


def units_of(records: Sequence[RecordErrors]) -> np.ndarray:
    """Unit [n] of each sample that counts."""
    return np.concatenate([np.full(int(record.counts.sum()), record.unit) for record in records])


def ripple(
    records: Sequence[RecordErrors], error: np.ndarray, directions: Sequence[bool] = (False, True)
) -> tuple[float, bool, Pattern]:
    """(wavelength m, whether it has the direction, pattern): the sine along the place of which an error has most.

    The spectrum of the error over the place, from one and a half waves along the whole path on, up to waves that have
    three samples at full speed; then about its peak. A length of 0 where the path is too short.
    """
    place, side, units = together(records, "place"), together(records, "side"), units_of(records)
    path = float(np.ptp(place))
    steps = np.concatenate([np.abs(np.diff(record.place)) for record in records])
    fast = float(np.quantile(steps, 0.9))
    most = int(min(path / max(PER_WAVE * fast, 1e-300), MOST_WAVES, len(place) / 20))
    if not path > 0 or most < 2 * LEAST_WAVES:
        return 0.0, False, Pattern(np.empty((len(error), 0)))
    bins = 8 * most
    which = np.minimum(((place - place.min()) / path * bins).astype(int), bins - 1)
    numbers = np.arange(FINER * most + 1) / FINER
    best = (-1.0, 0.0, False)
    for directed in directions:
        sign = side if directed else np.ones_like(side)
        weighted = error * sign / units
        spectrum = np.abs(np.fft.rfft(np.bincount(which, weighted, bins), FINER * bins)[: len(numbers)]) ** 2
        spectrum /= max(float(np.sum((sign / units) ** 2)), 1e-300)
        peak = int(np.argmax(np.where(numbers >= LEAST_WAVES, spectrum, -1.0)))
        if spectrum[peak] > best[0]:
            best = (float(spectrum[peak]), float(numbers[peak]), directed)

    def power(periods: float) -> float:
        columns = waves(records, path / periods, best[2])
        product = columns.T @ error
        return float(product @ np.linalg.lstsq(columns.T @ columns, product, rcond=None)[0])

    number, width = best[1], 1.0 / FINER
    for _ in range(REFINED):
        tried = [max(number + width * share, LEAST_WAVES) for share in (-0.5, 0.0, 0.5)]
        number = max(tried, key=power)
        width *= 0.6
    length = path / number
    return length, best[2], Pattern(waves(records, length, best[2]), tries=2.0 * FINER * most)


FARTHEST = 20  # samples, by one
FURTHER = 1.5  # times as far each, up to
LONGEST = 0.02  # of a record
LOOKS, POINTS = 3, 9  # looks about the best delay, ever closer, and delays that each tries


def shift(records: Sequence[RecordErrors], error: np.ndarray, absorbed: np.ndarray) -> tuple[float, Pattern]:
    """(delay s of the force behind the motion that leaves the least error, what it adds to the force).

    The predicted force of a moment before, R(t - d) - R(t), is taken off the error for d of -20 to 20 samples and, by
    factors, up to 2 % of the record; what the fit could absorb is taken off both. Between samples R is linear: it has
    no noise that this would smooth. The error itself is not moved, so that white noise stays what it is.
    """
    interval = float(np.median(np.concatenate([np.diff(record.time) for record in records])))
    reach = max(FARTHEST, LONGEST * min(len(record.time) for record in records))
    steps = [0.25, 0.5, *range(1, FARTHEST + 1)]
    while steps[-1] * FURTHER < reach:
        steps.append(steps[-1] * FURTHER)
    tried = np.array([*(-step for step in reversed(steps)), 0.0, *steps])

    def left(samples: float) -> float:
        rest = error - without(late(records, samples * interval), absorbed)
        return float(rest @ rest)

    best = tried[int(np.argmin([left(lag) for lag in tried]))]
    beside = np.diff(tried)[np.clip(np.searchsorted(tried, best), 0, len(tried) - 2)]
    for _ in range(LOOKS):
        near = best + beside * np.linspace(-1, 1, POINTS)
        best = near[int(np.argmin([left(lag) for lag in near]))]
        beside *= 2.0 / (POINTS - 1)
    delay = float(best) * interval
    columns = late(records, delay if delay else 1e-3 * interval)[:, None]
    return delay, Pattern(columns, tries=float(len(tried)), sparse=True)


def about(records: Sequence[RecordErrors], delay: float) -> np.ndarray:
    """Columns [n, 3] of a delay that is known to about a part of a sample: its own, a sample more and a sample less."""
    interval = float(np.median(np.diff(records[0].time)))
    own, *others = (late(records, delay + share * interval) for share in (0.0, -1.0, 1.0))
    return np.stack([own, *(other - own for other in others)], axis=1)


def late(records: Sequence[RecordErrors], delay: float) -> np.ndarray:
    """What a delay adds to the measured force, over the units, of the samples that count."""
    added = [(_before(record, delay) - record.predicted[record.counts]) / record.unit for record in records]
    return np.concatenate(added)


def _before(record: RecordErrors, delay: float) -> np.ndarray:
    """The force predicted for a moment before: linear between samples, but where the motion turns it may jump.

    There it is that of the sample on the same side of the instant at which the velocity, linear between samples, is 0.
    """
    time, velocity, force = record.time, record.velocity, record.predicted
    moment = np.clip(time[record.counts] - delay, time[0], time[-1])
    shifted = np.interp(moment, time, force)
    i = np.clip(np.searchsorted(time, moment, side="right") - 1, 0, len(time) - 2)
    turns = velocity[i] * velocity[i + 1] < 0
    i, moment = i[turns], moment[turns]
    crossing = time[i] + (time[i + 1] - time[i]) * velocity[i] / (velocity[i] - velocity[i + 1])
    shifted[turns] = force[np.where(moment < crossing, i, i + 1)]
    return shifted
