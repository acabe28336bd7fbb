"""Residuals: whether what a fit leaves is noise, and if not, what it goes with and what that points to.

Errors that are noise leave nothing to find. Where they go with speed, direction, position or time the law lacks
something; where force and motion are not at the same time, where the motion itself is noisy or where friction does
negative work, it is the data that are wrong. Each of these is looked for, and what is found is said.
"""

import dataclasses
import itertools
import math
from collections.abc import Sequence

import numpy as np

from vibrocap.identification.inference.limits import ReachedLimit
from vibrocap.identification.inference.uncertainty import Uncertainty, correlation_time, inverse, uncertainty
from vibrocap.identification.problem.data_scales import DataScales, data_scales
from vibrocap.identification.problem.prediction import DELAY, LATEST, Prediction, delay_coordinate
from vibrocap.identification.problem.samples import Samples
from vibrocap.identification.search.descent import descent
from vibrocap.identification.search.loss import Loss, Minimum

CHANCE = 1e-3  # probability with which noise alone would show what is reported, test by test
LAGS = 20  # correlations that the test for whiteness sums
BINS = 10  # of a covariate, with as many samples each
SHARE = 0.02  # of the squared errors, from which on it matters what they go with
GROWTH = 1.5  # ratio of the errors between the fastest and the slowest third of the samples
FAR = 5.0  # error over the noise of the samples
NEGATIVE = 0.05  # of the work without signs: friction that gives back so much
LATE, LEAST_DELAY = 4.0, 0.02  # standard errors of a delay, and share of a sampling interval
MOVED = 0.5  # of half an interval, by which noise of the motion may move a parameter
SURROGATES = 2  # motions with noise of their own that are tried
ROUGH = 5e-4  # of the velocity (root mean square), below which it counts as smooth
LONGEST = 40_000  # samples of these
SIMPLER = 0.9  # of the largest share: a simpler covariate that explains so much goes first
DELAYED = 25  # evaluations of the search for a delay
REST = 1e-3  # of the typical speed


@dataclasses.dataclass(frozen=True)
class Finding:
    """One thing that errors tell. kind: a word for it; text: in words; amount: its size, as the text says."""

    kind: str
    text: str
    amount: float


@dataclasses.dataclass(frozen=True)
class ResidualReport:
    """What a fit leaves.

    white: whether neighbouring errors are independent (Ljung and Box 1978); correlation_time: of the errors, in samples
    noise_ratio: error over the noise of the samples, which second differences of the force tell
    shares: of the squared errors, by what they go with: speed, direction, position, time
    phases: root mean square error over that of all samples, by phase of the motion; largest: the phase of the largest
    delay_s: by which the force seems to lag the motion, with its standard error
    work_ratio: work of the measured force over that without signs, the least of the records
    findings: what is not as noise would be
    """

    white: bool
    correlation_time: float
    noise_ratio: float
    shares: dict[str, float]
    phases: dict[str, float]
    largest: str
    delay_s: float
    delay_error_s: float
    work_ratio: float
    findings: tuple[Finding, ...]

    @property
    def kinds(self) -> tuple[str, ...]:
        """The kinds of the findings."""
        return tuple(each.kind for each in self.findings)

    @property
    def doubtful(self) -> bool:
        """Whether intervals may not hold: for more than that errors are correlated or grow, which they allow for."""
        return any(kind not in ("coloured", "growing") for kind in self.kinds)

    def sentences(self) -> tuple[str, ...]:
        """The report in words."""
        phase = f"largest {self.largest}, {self.phases[self.largest]:.2g} times the mean" if self.phases else ""
        if not self.findings:
            return (f"They are as white noise would be ({phase})." if phase else "They are as white noise would be.",)
        return (*(each.text for each in self.findings), *((f"They are {phase}.",) if phase else ()))


def residual_report(
    prediction: Prediction,
    draft: Prediction,
    best: Minimum,
    spread: Uncertainty,
    loss: Loss,
    limits: Sequence[ReachedLimit] = (),
) -> ResidualReport:
    """What the errors of a minimum tell; samples that do not count are left out of the tests.

    draft: the same for few samples; limits: that were reached.
    """
    records, scales = prediction.records, data_scales(prediction.records)
    counts = prediction.counts
    cuts = np.cumsum([len(each) for each in records])[:-1]
    whole = np.split(best.errors, cuts)
    units = [np.where(np.isfinite(u), u, 0.0) for u in prediction.units]
    errors = [each[count] for each, count in zip(whole, counts, strict=True)]
    together = np.concatenate(errors)
    square = float(np.mean(together**2))
    limits = [each for each in limits if each.pressed and each.whose == "law"]
    tau = max(1.0, float(np.mean([correlation_time(each) for each in errors])))
    white = _white(errors)
    newtons = np.concatenate([(e * u)[c] for e, u, c in zip(whole, units, counts, strict=True)])
    ratio = float(np.sqrt(np.mean(newtons**2)) / max(scales.noise, 1e-300))
    shares = _shares(records, counts, errors, scales)
    phases = _phases(records, counts, errors, scales) if square > 0 else {}
    growth, sure = _growth(records, counts, errors, tau)
    delay, error, explained = _delay(draft if prediction.size > LONGEST else prediction, best, loss)
    work = min(_work_ratio(each) for each in records)
    moved = _moved_by_noise(prediction, best, spread)
    found = []
    if work < -NEGATIVE:
        found.append(_finding("work", work, f"{work:.0%}"))
    if not white:
        found.append(_finding("coloured", tau, f"{tau:.3g}"))
    if sure and not 1 / GROWTH < growth < GROWTH:
        found.append(_finding("growing", growth, "grow" if growth > 1 else "shrink", f"{growth:.2g}"))
    found += [
        Finding(name, f"They go with {name}: it explains {share:.0%} of their squares, {LACKS[name]}.", share)
        for name, share in shares.items()
        if share > SHARE
    ]
    if not white and ratio > FAR:
        found.append(_finding("far from noise", ratio, f"{ratio:.2g}"))
    if explained > (0.0 if white else SHARE):
        how = "lags" if delay > 0 else "leads"
        words = (how, f"{abs(delay):.3g}", f"{abs(delay) / scales.interval:.2g}", f"{explained:.0%}")
        found.append(_finding("delay", delay, *words))
    if moved:
        names = ", ".join(f"{name} ({change:+.1%})" for name, change in moved.items())
        found.append(_finding("noisy motion", max(map(abs, moved.values())), names))
    found += [_finding("limit", each.value, each.text) for each in limits]
    largest = max(phases, key=lambda name: phases[name]) if phases else ""
    return ResidualReport(white, tau, ratio, shares, phases, largest, delay, error, work, tuple(found))


SAID = {
    "work": "Friction does negative work (force times velocity sums to {} of its size): the sign of the force or of "
    "the motion looks swapped, or a drive acts along.",
    "coloured": "They are not white: errors are correlated over {} samples, which the intervals allow for.",
    "growing": "They {} with speed: {} times as large in the fastest third of the samples as in the slowest, which the "
    "intervals allow for.",
    "far from noise": "They are {} times what changes from sample to sample: slow noise, or what the law or the "
    "motion lacks.",
    "delay": "The force looks as if it {} the motion by {} s ({} samples), which would explain {} of the squares; no "
    "interval holds with a delay: search it along, shift one of both, or filter them alike.",
    "noisy motion": "The motion is noisy: another draw of its noise would move {}, out of the intervals or nearly; "
    "filter the motion (cutoff) or measure it finer.",
    "limit": "{}, and the data pull beyond it: the law or the data are wrong (a delay does so).",
}
LACKS = {
    "speed": "so the law's curve over speed is not that of the data",
    "direction": "so the two directions differ by more than the law knows (an anisotropic law, or offset)",
    "position": "as if friction depended on the place, or on the distance since a reversal otherwise than in the law",
    "time": "so the contact changes in the course of the record: warming, wear, or a drift of the sensor",
}


def _finding(kind: str, amount: float, *words: str) -> Finding:
    return Finding(kind, SAID[kind].format(*words), amount)


def _white(errors: Sequence[np.ndarray]) -> bool:
    """Whether the first correlations are as small as chance makes them, over all records (Ljung and Box)."""
    from scipy.special import chdtrc

    total, degrees = 0.0, 0
    for each in errors:
        n, lags = len(each), min(LAGS, len(each) // 5)
        power = float(each @ each)
        if lags < 1 or not power > 0:
            continue
        rho = np.array([float(each[k:] @ each[:-k]) for k in range(1, lags + 1)]) / power
        total += n * (n + 2) * float(np.sum(rho**2 / (n - np.arange(1, lags + 1))))
        degrees += lags
    return bool(degrees == 0 or float(chdtrc(degrees, total)) > CHANCE)


def _shares(
    records: Sequence[Samples], counts: Sequence[np.ndarray], errors: Sequence[np.ndarray], scales: DataScales
) -> dict[str, float]:
    """Share of the squared errors that means over bins of each covariate explain; 0 where chance would do as much.

    One after the other, the best first: what an earlier one explains is no more of the others'.
    """
    together = np.concatenate(counts)
    speed = np.concatenate([np.abs(each.velocity) for each in records])
    side = np.sign(np.where(speed > REST * scales.speed, np.concatenate([each.velocity for each in records]), 0.0))
    covariates = {
        "direction": side[together],
        "speed": speed[together],
        "position": np.concatenate([each.displacement for each in records])[together],
        "time": np.concatenate([each.time for each in records])[together],
    }
    cuts = np.cumsum([len(each) for each in errors])[:-1]
    rest, found = np.concatenate(errors), dict.fromkeys(covariates, 0.0)
    total = max(float(rest @ rest), 1e-300)
    left = dict(covariates)
    while left:
        shares = {name: _share(column, rest, cuts) for name, column in left.items()}
        most = max(share for share, _ in shares.values())
        # of those that explain as much, the one with the fewest bins, which stands first
        name = next(name for name, (share, _) in shares.items() if share >= SIMPLER * most)
        if not most > 0:
            break
        found[name] = shares[name][0] * float(rest @ rest) / total
        rest = rest - shares[name][1]
        left.pop(name)
    return found


def _share(column: np.ndarray, error: np.ndarray, cuts: np.ndarray) -> tuple[float, np.ndarray]:
    """(share of the squares that the means over bins explain, or 0; these means [n])."""
    from scipy.special import fdtrc

    total, none = float(error @ error), (0.0, np.zeros_like(error))
    if not total > 0 or np.ptp(column) == 0:
        return none
    distinct = np.unique(column)
    edges = distinct if len(distinct) <= 3 else np.quantile(column, np.linspace(0, 1, BINS + 1)[1:-1])
    bins = np.searchsorted(edges, column)
    number = np.bincount(bins)
    means = np.bincount(bins, error) / np.maximum(number, 1)
    rest = error - means[bins]
    tau = float(np.mean([correlation_time(each) for each in np.split(rest, cuts)]))
    between, within = float(number @ means**2), float(rest @ rest)
    groups = int(np.sum(number > 0))
    free = len(error) / tau - groups
    if free < 1 or groups < 2 or not within > 0:
        return none
    ratio = between / tau / groups / (within / tau / free)
    return (between / total, means[bins]) if float(fdtrc(groups, free, ratio)) < CHANCE else none


def _growth(
    records: Sequence[Samples], counts: Sequence[np.ndarray], errors: Sequence[np.ndarray], tau: float
) -> tuple[float, bool]:
    """Ratio of the errors at the fastest third of the samples to the slowest, and whether chance is ruled out."""
    speed = np.concatenate([np.abs(each.velocity)[count] for each, count in zip(records, counts, strict=True)])
    error = np.concatenate(errors)
    low, high = np.quantile(speed, [1 / 3, 2 / 3])
    slow, fast = error[speed <= low], error[speed >= high]
    if min(len(slow), len(fast)) < 10 or not slow.any():
        return 1.0, False
    growth = float(np.sqrt(np.mean(fast**2) / np.mean(slow**2)))
    spread = math.sqrt(0.5 * tau * (1 / len(slow) + 1 / len(fast)))  # of the logarithm, for normal errors
    return growth, bool(growth > 0 and abs(math.log(growth)) > 4 * spread)


def _phases(
    records: Sequence[Samples], counts: Sequence[np.ndarray], errors: Sequence[np.ndarray], scales: DataScales
) -> dict[str, float]:
    """Root mean square error over that of all samples, by phase of the motion."""
    labels = np.concatenate([_phase(each, scales)[count] for each, count in zip(records, counts, strict=True)])
    error = np.concatenate(errors)
    mean = float(np.sqrt(np.mean(error**2)))
    found = {}
    for number, name in enumerate(("at rest", "just after reversals", "in slow sliding", "in fast sliding")):
        mine = error[labels == number]
        if len(mine) >= 0.01 * len(error):
            found[name] = float(np.sqrt(np.mean(mine**2))) / mean
    return found


def _phase(record: Samples, scales: DataScales) -> np.ndarray:
    """0 at rest, 1 until the contact has gone twice the distance to break-away after a reversal, 2 slow, 3 fast."""
    speed = np.abs(record.velocity)
    side = np.sign(np.where(speed > REST * scales.speed, record.velocity, 0.0))
    place = record.displacement
    turning = np.zeros(len(record), bool)
    reach = 2 * scales.level / scales.stiffness if scales.stiffness else 0.02 * scales.length
    moving = np.flatnonzero(side)
    turns = moving[1:][side[moving][1:] != side[moving][:-1]]
    for begin, end in itertools.pairwise([*turns, len(record)]):
        turning[begin:end] = np.abs(place[begin:end] - place[begin]) < reach
    return np.where(side == 0, 0, np.where(turning, 1, np.where(speed < 0.3 * scales.speed, 2, 3)))


def _work_ratio(record: Samples) -> float:
    power = record.force * record.velocity
    steps = np.diff(record.time)
    signed = float(0.5 * (power[1:] + power[:-1]) @ steps)
    size = float(0.5 * (np.abs(power[1:]) + np.abs(power[:-1])) @ steps)
    return signed / max(size, 1e-300)


def _delay(prediction: Prediction, best: Minimum, loss: Loss) -> tuple[float, float, float]:
    """(delay of the force behind the motion, its standard error, share of the squares that it explains), s.

    A short descent from the minimum; a force that is early or late looks like damping and bends the drop of friction.
    """
    if type(prediction) is not Prediction or DELAY in prediction.space.names:
        return 0.0, math.inf, 0.0
    space = prediction.space.with_more((delay_coordinate(prediction.records),))
    late = dataclasses.replace(prediction, space=space)
    begins = [np.append(best.u, 0.0)]
    pinned = np.array([each.at_limit(u) != 0 for each, u in zip(space.coordinates, begins[0], strict=True)])
    if pinned.any():  # a damping that a delay has driven to zero is far from where it belongs
        begins.append(np.where(pinned, 0.3 * space.low + 0.7 * space.high, begins[0]))
    ends = [descent(late, u, loss, evaluations=DELAYED, stop=1e-5) for u in begins]
    found = min(ends, key=lambda each: each.cost)
    cuts = np.cumsum([len(each) for each in prediction.records])[:-1]
    spread = uncertainty(np.split(found.errors, cuts), found.slopes, space.slopes(found.u), loss)
    delay, error = float(space.values(found.u)[-1]), float(np.sqrt(spread.covariance[-1, -1]))
    gain = 2.0 * (best.cost - found.cost) / (spread.unit * float(spread.inflation[-1]))  # of -2 log(likelihood)
    there = gain > LATE**2 and LEAST_DELAY < abs(found.u[-1]) < LATEST
    return delay, error, 1.0 - found.cost / max(best.cost, 1e-300) if there else 0.0


def _moved_by_noise(prediction: Prediction, best: Minimum, spread: Uncertainty) -> dict[str, float]:
    """Parameters, with their relative change, that noise of the motion of the size that is there would move too far.

    The law is driven by the measured motion with further noise of the same spectrum, and the parameters that would best
    give the force of the measured motion back are found by one step of Gauss and Newton.
    """
    if type(prediction) is not Prediction or prediction.size > LONGEST:
        return {}
    rough = [_roughness(each.velocity) for each in prediction.records]
    if all(not each.any() for each in rough):
        return {}
    base = prediction.errors(best.u)
    half = spread.threshold * np.sqrt(np.diag(spread.covariance) / spread.inflation)
    to_parameters, values = prediction.space.slopes(best.u), prediction.space.values(best.u)
    rng, moves = np.random.default_rng(0), []
    for _ in range(SURROGATES):
        noises = [_redrawn(noise, rng) for noise in rough]
        pairs = zip(prediction.records, noises, strict=True)
        records = [dataclasses.replace(record, velocity=record.velocity + noise) for record, noise in pairs]
        noisy = prediction.of(records, prediction.units)
        errors = noisy.errors(best.u)
        change = errors - base
        counted = np.isfinite(change)
        slopes = noisy.slopes(best.u, errors)
        slopes, change = np.nan_to_num(slopes[counted]), change[counted]
        moves.append(to_parameters @ -(inverse(slopes.T @ slopes) @ (slopes.T @ change)))
    moved = np.mean(moves, axis=0)
    return {
        name: float(moved[i] / values[i])
        for i, name in enumerate(prediction.space.names)
        if name in prediction.law_names and abs(moved[i]) > MOVED * half[i] and 0 < half[i] < abs(values[i])
    }


def _roughness(velocity: np.ndarray) -> np.ndarray:
    """What of a velocity is noise: what cubics over nine samples leave; zero where that is rounding."""
    from scipy.signal import savgol_filter

    if len(velocity) < 16:
        return np.zeros_like(velocity)
    rough = velocity - savgol_filter(velocity, 9, 3)
    usual = float(np.median(np.abs(rough))) / 0.6745
    if usual < ROUGH * float(np.sqrt(np.mean(velocity**2))):
        return np.zeros_like(velocity)
    return np.clip(rough, -4 * usual, 4 * usual)  # corners of the motion are no noise


def _redrawn(noise: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Noise of the same spectrum with random phases."""
    spectrum = np.fft.rfft(noise)
    turned = np.abs(spectrum) * np.exp(2j * np.pi * rng.random(len(spectrum)))
    return np.fft.irfft(turned, len(noise))
