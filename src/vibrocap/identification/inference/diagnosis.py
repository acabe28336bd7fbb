"""Diagnosis: the faults of the measurement or of the law that the errors of a fit point to, the largest first.

First come faults that the columns show by themselves (`errors`), then causes compete that add a known
pattern to the force (`patterns`).
"""

import dataclasses
import functools
from collections.abc import Callable, Sequence

import numpy as np

from vibrocap.identification.inference import patterns
from vibrocap.identification.inference.errors import (
    REMAINING,
    Cause,
    RecordErrors,
    noise_level,
    of,
    outliers,
    quantisation,
    sampled,
    saturation,
    squares,
    together,
)
from vibrocap.identification.inference.patterns import Pattern, basis_of, explained, probability, without

FALSE_ALARMS = 1e-3  # share of fits with nothing but noise in which some pattern may be named, all tests together
SHARE = 0.02  # of the squared errors that a pattern explains, from which on it matters
MAIN = 0.1  # of the squares that are no white noise, which the first cause explains at least
SECOND = 0.1  # of the first cause's share: a lesser one is told once the first has been put right
GENERAL = 0.9  # of its share that counts for a pattern of many bins, against one of few columns
SAME_WAVE = 0.5  # waves along the path by which ripples differ that are told apart


@dataclasses.dataclass(frozen=True, eq=False)
class Diagnosis:
    """causes: the largest first; rest [n]: what of the errors of the samples that count they leave, over the units."""

    causes: tuple[Cause, ...]
    rest: np.ndarray
    counts: tuple[np.ndarray, ...]


Refit = Callable[[Sequence[np.ndarray]], tuple[Sequence[RecordErrors], np.ndarray]]


def diagnosis(
    records: Sequence[RecordErrors], slopes: np.ndarray | None = None, refit: Refit | None = None, timed: bool = True
) -> Diagnosis:
    """What is wrong with the data or with the law.

    slopes [n, p]: how the prediction over the units changes with what the fit adapts, all records in a row; none where
    the parameters are known. refit: the fit anew without given samples of each record, for a saturated force; else its
    parameters follow the slopes. timed: whether force and motion follow each other in time, so that a delay shows.
    """
    whole = len(np.concatenate([record.time for record in records]))
    slopes = np.empty((whole, 0)) if slopes is None else slopes
    causes: list[Cause] = []
    cut, touched = saturation(records)
    if cut is not None:
        causes.append(cut)
        kept = [~samples for samples in touched]
        if np.mean(np.concatenate(kept)) < REMAINING:
            return Diagnosis((cut,), together(records, "error"), tuple(record.counts for record in records))
        if refit is not None:
            records, slopes = refit(kept)
        pairs = zip(records, kept, strict=True)
        records = [dataclasses.replace(record, counts=record.counts & samples) for record, samples in pairs]
    coarse = quantisation(records)
    if coarse is not None:
        causes.append(coarse)
    largest, timed = 0.0 if cut is None else 1.0, timed and coarse is None
    errors, counts = [record.error for record in records], tuple(record.counts for record in records)
    named, rest = _patterns(records, errors, slopes, largest, timed)
    single, cleaned = outliers(records, rest)
    if single is not None and single.share * squares(rest, counts) > SHARE * squares(errors, counts):
        smooth = [error + clean - left for error, clean, left in zip(errors, cleaned, rest, strict=True)]
        again, rest = _patterns(records, smooth, slopes, largest, timed)
        known = {cause.kind for cause in named}
        named = [single, *(cause for cause in again if cause.kind in known)]
    if coarse is None:  # errors of the motion go with everything that the force goes with
        causes += named
    if not any(cause.kind in WITH_CONSTANT for cause in causes):
        causes += _offset(records, slopes)
    return Diagnosis(tuple(causes), np.concatenate(of(rest, counts)), counts)


def _offset(records: Sequence[RecordErrors], slopes: np.ndarray) -> list[Cause]:
    """A constant in the force, where errors of the motion hide other patterns: these are no reason for one.

    They blur an odd law to another odd one, whatever the motion. So the constant has to be there beside means over
    bins of the speed, times the direction; and it counts from the share that matters on, whatever else there is.
    """
    some = sampled(records)
    error, absorbed, cuts = _counted(some, [record.error for record in some], slopes)
    total = float(error @ error)
    odd = basis_of(np.concatenate([absorbed, patterns.odd_in_velocity(some)], axis=1))
    left, pattern = without(error, odd), patterns.constant(some)
    _, rest = explained(left, odd, pattern)
    share = float(left @ left - rest @ rest) / max(total, 1e-300)
    if share < SHARE or probability(left, odd, pattern, rest, cuts) >= CHANCE:
        return []
    return _named("direction", 0.0, share, pattern, error, absorbed, some)


def _patterns(
    records: Sequence[RecordErrors], errors: Sequence[np.ndarray], slopes: np.ndarray, largest: float, timed: bool
) -> tuple[list[Cause], list[np.ndarray]]:
    """Causes that add a pattern to the force, and what they leave of the errors [n] of each record.

    One after the other: what one explains is no more the others'.
    """
    some = sampled(records)
    causes, columns = _found(some, *_counted(some, errors, slopes), largest, timed)
    error, absorbed, cuts = _counted(records, errors, slopes)
    rest = without(error, basis_of(np.concatenate([absorbed, *(make(records) for make in columns)], axis=1)))
    whole = [error.copy() for error in errors]
    for left, record, part in zip(whole, records, np.split(rest, cuts), strict=True):
        left[record.counts] = part
    return causes, whole


def _counted(
    records: Sequence[RecordErrors], errors: Sequence[np.ndarray], slopes: np.ndarray
) -> tuple[np.ndarray, np.ndarray, list[int]]:
    """(errors without what the fit can absorb, a basis of that, where records begin), of the samples that count."""
    counts = [record.counts for record in records]
    absorbed = basis_of(np.nan_to_num(slopes[np.concatenate(counts)]))
    error = without(np.concatenate(of(errors, counts)), absorbed)
    return error, absorbed, np.cumsum([int(count.sum()) for count in counts])[:-1].tolist()


Columns = Callable[[Sequence[RecordErrors]], np.ndarray]


def _found(
    records: Sequence[RecordErrors],
    error: np.ndarray,
    absorbed: np.ndarray,
    cuts: list[int],
    largest: float,
    timed: bool,
) -> tuple[list[Cause], list[Columns]]:
    """The causes, the largest first, and how each makes its columns."""
    fixed = {name: make(records) for name, make in MAKERS.items()}
    turns = float(np.ptp(together(records, "place"))) / (2 * np.pi) if any(record.rotary for record in records) else 0.0
    loss = BROAD | {"restoring": 1.0} if turns else BROAD  # one wave in a turn is no general pattern
    total, causes, columns = float(error @ error), [], []
    noise = sum(noise_level(piece) ** 2 * len(piece) for piece in np.split(error, cuts))
    least = MAIN * max(1.0 - noise / max(total, 1e-300), 0.0)
    while total > 0:  # each that is named explains a share of its own
        tried: dict[str, tuple[Pattern, float, Columns]]
        tried = {name: (x, 0.0, lambda some, name=name: MAKERS[name](some).columns) for name, x in fixed.items()}
        length, directed, sines = patterns.ripple(records, error)
        tried["ripple"] = (sines, length, functools.partial(patterns.waves, length=length, directed=directed))
        if timed and all(cause.kind != "delay" for cause in causes):
            delay, lateness = patterns.shift(records, error, absorbed)
            tried["delay"] = (lateness, delay, functools.partial(patterns.about, delay=delay))
        now = float(error @ error)
        shares = {name: explained(error, absorbed, pattern) for name, (pattern, *_) in tried.items()}
        for name in POSITIVE:
            if name in tried and min(_coefficients(tried[name][0], error, absorbed)[: 1 + (name == SWINGING)]) < 0:
                shares[name] = (0.0, error)
        if turns and length > 0.0 and not directed and abs(turns * (2 * np.pi / length - 1)) < SAME_WAVE:
            shares["ripple"] = (0.0, error)  # it is gravity
        weights = {name: share * loss.get(name, 1.0) for name, (share, _) in shares.items()}
        for name in sorted(weights, key=lambda name: -weights[name]):
            pattern, amount, make = tried[name]
            share = shares[name][0] * now / total
            if share < max(SHARE, SECOND * largest, least if not causes else 0.0):
                return causes, columns
            if probability(error, absorbed, pattern, shares[name][1], cuts) < CHANCE:
                break
        else:
            return causes, columns
        largest = max(largest, share)
        if all(cause.kind != name for cause in causes):
            causes += _named(name, amount, share, pattern, error, absorbed, records)
        columns.append(make)
        absorbed = basis_of(np.concatenate([absorbed, make(records)], axis=1))
        error = without(error, absorbed)
        fixed.pop(name, None)
    return causes, columns


SWINGING = "swinging"  # told as inertia and restoring: where they nearly cancel, none of both shows alone
MAKERS: dict[str, Callable[[Sequence[RecordErrors]], Pattern]] = {
    "direction": patterns.direction,
    "inertia": patterns.inertia,
    "restoring": patterns.restoring,
    SWINGING: patterns.swinging,
    "drift": patterns.drift,
    "speed": patterns.speed,
    "position": patterns.position,
    "presliding": patterns.presliding,
}
CHANCE = FALSE_ALARMS / (len(MAKERS) + 3)  # of one test
POSITIVE = ("inertia", "restoring", SWINGING)  # no mass and no stiffness is negative
WITH_CONSTANT = ("direction", "restoring", "drift")
BROAD = dict.fromkeys(("speed", "position", "presliding", "drift", "restoring"), GENERAL) | {SWINGING: GENERAL**2}


def _coefficients(pattern: Pattern, error: np.ndarray, absorbed: np.ndarray) -> np.ndarray:
    """The coefficients of a pattern's columns; those of a sine and a cosine, after which a constant comes, by size."""
    left = without(pattern.columns, absorbed)
    coefficients = np.linalg.lstsq(left.T @ left, left.T @ error, rcond=None)[0]
    if pattern.waves:
        coefficients[-3:-1] = float(np.hypot(*coefficients[-3:-1])), 0.0
    return coefficients


def _named(
    name: str,
    amount: float,
    share: float,
    pattern: Pattern,
    error: np.ndarray,
    absorbed: np.ndarray,
    records: Sequence[RecordErrors],
) -> list[Cause]:
    """The causes with their size: a delay in s, a wavelength in m, a mass in kg, a stiffness in N/m, else its share."""
    turning = any(record.rotary for record in records)
    if name == "delay":
        return [delay_cause(amount, share, float(np.median(np.diff(records[0].time))))]
    if name == "ripple":
        return [Cause(name, amount, share, (f"{amount:.3g} {'rad' if turning else 'm'}", f"{share:.0%}"))]
    if name not in POSITIVE:
        return [Cause(name, share, share, (f"{share:.0%}",))]
    units = {"inertia": ("kg", "kg m^2"), "restoring": ("N/m", "N m")}
    kinds = [*units] if name == SWINGING else [name]  # each by a column, the first ones
    sizes = _coefficients(pattern, error, absorbed)[: len(kinds)]
    parts = (sizes * np.linalg.norm(pattern.columns[:, : len(kinds)], axis=0)) ** 2
    causes = []
    for kind, size, own in zip(kinds, sizes.tolist(), (share * (parts / sum(parts))).tolist(), strict=True):
        causes.append(Cause(kind, size, own, (f"{size:.3g} {units[kind][turning]}", f"{own:.0%}")))
    return causes


def delay_cause(delay: float, share: float, interval: float) -> Cause:
    """A delay of the force behind the motion, s; interval: between samples, s."""
    how, size = "lags" if delay > 0 else "leads", abs(delay)
    return Cause("delay", delay, share, (how, f"{size:.3g}", f"{size / interval:.2g}", f"{share:.0%}"))
