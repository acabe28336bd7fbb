"""Patterns that faults add to a force: with place, with time, with direction, speed and acceleration."""

from collections.abc import Sequence

import numpy as np

from vibrocap.identification.inference.diagnosis.errors import RecordErrors, together
from vibrocap.identification.inference.diagnosis.pattern_test import Pattern

BINS = 10  # of a covariate, with as many samples each
DEGREE = 3  # of a drift's polynomials in time
LEAST_WAVES, MOST_WAVES, PER_WAVE = 1.5, 400, 3  # waves of a ripple along the path; samples of a wave at full speed
FEWEST_TURNS = 4  # reversals that tell of what comes after them
FINER = 4  # points of the spectrum for each wave along the path
REFINED = 12  # halvings about the spectrum's peak


def over_units(records: Sequence[RecordErrors], values: Sequence[np.ndarray]) -> np.ndarray:
    """Columns in newtons of each record, over its unit, of the samples that count."""
    return np.concatenate([(one / each.unit)[each.counts] for each, one in zip(records, values, strict=True)])


def inertia(records: Sequence[RecordErrors]) -> Pattern:
    """A mass that the sensor carries: the acceleration."""
    return Pattern(over_units(records, [each.acceleration for each in records])[:, None])


def restoring(records: Sequence[RecordErrors]) -> Pattern:
    """A spring, or gravity on what turns: the place, or its sine and cosine; and a constant, for its middle."""
    if any(each.rotary for each in records):
        waves = [over_units(records, [wave(each.place) for each in records]) for wave in (np.sin, np.cos)]
    else:
        waves = [over_units(records, [each.place - each.place.mean() for each in records])]
    return Pattern(np.stack([*waves, over_units(records, [np.ones_like(each.time) for each in records])], axis=1))


def drift(records: Sequence[RecordErrors]) -> Pattern:
    """A sensor's zero, or the level of friction, that changes in the course of a record: polynomials in time."""
    columns = [over_units(records, [np.ones_like(each.time) for each in records])]
    for power in range(1, DEGREE + 1):
        legendre = np.polynomial.legendre.Legendre.basis(power)
        of_time = [legendre(2 * each.time / each.time[-1] - 1) for each in records]
        columns.append(over_units(records, of_time))
        columns.append(over_units(records, [one * each.predicted for one, each in zip(of_time, records, strict=True)]))
    return Pattern(np.stack(columns, axis=1))


def direction(records: Sequence[RecordErrors]) -> Pattern:
    """Levels that differ by direction: a constant, and the direction."""
    ones = over_units(records, [np.ones_like(each.time) for each in records])
    return Pattern(np.stack([ones, over_units(records, [each.side for each in records])], axis=1))


def constant(records: Sequence[RecordErrors]) -> Pattern:
    """An offset of the force sensor: a constant."""
    return Pattern(over_units(records, [np.ones_like(each.time) for each in records])[:, None])


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
    ways, turns = [], 0
    for each in records:
        turns += int(np.sum(each.turned))
        begin = np.maximum.accumulate(np.where(each.turned, np.arange(len(each.time)), 0))
        ways.append(np.abs(each.place - each.place[begin])[each.counts])
    way = np.concatenate(ways)
    if turns < FEWEST_TURNS:
        return Pattern(np.empty((len(way), 0)))
    edges = float(way.max()) * 0.5 ** np.arange(BINS - 1, 0, -1)
    return Pattern(_indicators(np.searchsorted(edges, way)) * together(records, "side")[:, None])


def _bins(column: np.ndarray) -> Pattern:
    edges = np.quantile(column, np.linspace(0, 1, BINS + 1)[1:-1])
    return Pattern(_indicators(np.searchsorted(edges, column)))


def _indicators(bins: np.ndarray) -> np.ndarray:
    return (bins[:, None] == np.unique(bins)).astype(float)


def waves(records: Sequence[RecordErrors], length: float, directed: bool) -> np.ndarray:
    """Cosine and sine [n, 2] of a wavelength along the place, times the direction or not."""
    phases = [2 * np.pi / length * each.place[each.counts] for each in records]
    sizes = [(each.side[each.counts] if directed else 1.0) / each.unit for each in records]
    pair = [[wave(p) * size for p, size in zip(phases, sizes, strict=True)] for wave in (np.cos, np.sin)]
    return np.stack([np.concatenate(one) for one in pair], axis=1)


def ripple(records: Sequence[RecordErrors], error: np.ndarray) -> tuple[float, bool, Pattern]:
    """(wavelength m, whether it has the direction, pattern): the sine along the place of which an error has most.

    The spectrum of the error over the place, from one and a half waves along the whole path on, up to waves that have
    three samples at full speed; then about its peak. A length of 0 where the path is too short.
    """
    place, side = together(records, "place"), together(records, "side")
    units = np.concatenate([np.full(int(each.counts.sum()), each.unit) for each in records])
    path = float(np.ptp(place))
    steps = np.concatenate([np.abs(np.diff(each.place)) for each in records])
    fast = float(np.quantile(steps, 0.9))
    most = int(min(path / max(PER_WAVE * fast, 1e-300), MOST_WAVES, len(place) / 20))
    none = 0.0, False, Pattern(np.empty((len(error), 0)))
    if not path > 0 or most < 2 * LEAST_WAVES:
        return none
    bins = 8 * most
    which = np.minimum(((place - place.min()) / path * bins).astype(int), bins - 1)
    numbers = np.arange(FINER * most + 1) / FINER
    best = (-1.0, 0.0, False)
    for directed in (False, True):
        sign = side if directed else np.ones_like(side)
        weighted = error * sign / units
        spectrum = np.abs(np.fft.rfft(np.bincount(which, weighted, bins), FINER * bins)[: len(numbers)]) ** 2
        spectrum /= max(float(np.sum((sign / units) ** 2)), 1e-300)
        peak = int(np.argmax(np.where(numbers >= LEAST_WAVES, spectrum, -1.0)))
        if spectrum[peak] > best[0]:
            best = (float(spectrum[peak]), float(numbers[peak]), directed)
    number, width = best[1], 1.0 / FINER
    for _ in range(REFINED):
        tried = [max(number + width * each, LEAST_WAVES) for each in (-0.5, 0.0, 0.5)]
        number = max(tried, key=lambda each: _power(waves(records, path / each, best[2]), error))
        width *= 0.6
    length = path / number
    return length, best[2], Pattern(waves(records, length, best[2]), tries=2.0 * FINER * most)


def _power(columns: np.ndarray, error: np.ndarray) -> float:
    product = columns.T @ error
    return float(product @ np.linalg.lstsq(columns.T @ columns, product, rcond=None)[0])
