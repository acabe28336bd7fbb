"""Residuals: whether what a fit leaves is noise, and if not, what it goes with and what that points to.

Where errors go with speed, direction, place or time the law lacks something; where force and motion are not at the same
time, where one of them is cut off, coarse or struck, or where friction does negative work, it is the data that are
wrong. Each of these is looked for (`diagnosis`).
"""

import dataclasses
import itertools
import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from vibrocap.identification.inference.diagnosis import SECOND, SHARE, Diagnosis, delay_cause, diagnosis
from vibrocap.identification.inference.errors import Cause, RecordErrors, of
from vibrocap.identification.inference.intervals import ReachedLimit
from vibrocap.identification.inference.late_force import LateForce, late_force, moved_by_noise
from vibrocap.identification.inference.uncertainty import Problem, correlation_time
from vibrocap.identification.problem.prediction import DELAY, Prediction
from vibrocap.identification.problem.priors import MOST
from vibrocap.identification.problem.samples import DataScales, Samples, data_scales, turns
from vibrocap.identification.problem.terms import TERMS
from vibrocap.identification.search import Minimum, descent, finite

CHANCE = 1e-3  # probability with which white noise would not be called so
LAGS = 20  # correlations that the test for whiteness sums
GROWTH = 1.5  # ratio of the errors between the fastest and the slowest third of the samples
FAR = 10.0  # error over the noise of the samples
POOR = 0.5  # relative root mean square error from which on a law explains little
NEGATIVE = 0.05  # of the work without signs: friction that gives back so much
REFITTED = 25  # evaluations of the fit without samples that are cut off
LESS = 0.9  # of what patterns explain, which a delay must to be told in their place
REST = 1e-3  # of the typical speed
WITH_MOTION = ("speed", "position", "presliding")
BORNE = "outliers, borne"
ALLOWED_FOR = ("coloured", "growing", BORNE)  # findings that are no doubt


@dataclasses.dataclass(frozen=True)
class Finding:
    """One thing that errors tell. kind: a word for it; text: in words; amount: its size, as the text says."""

    kind: str
    text: str
    amount: float


@dataclasses.dataclass(frozen=True)
class ResidualReport:
    """What a fit leaves.

    white: whether neighbouring errors are independent (Ljung and Box 1978), once what is found has been taken off
    correlation_time: of these, in samples
    noise_ratio: error over the noise of the samples, which second differences of the force tell
    shares: of the squared errors, by the causes that they are put down to
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
        return tuple(finding.kind for finding in self.findings)

    @property
    def doubtful(self) -> bool:
        """Whether intervals may not hold: for more than what they, or a robust loss, allow for."""
        return any(kind not in ALLOWED_FOR for kind in self.kinds)

    def sentences(self) -> tuple[str, ...]:
        """The report in words."""
        above = self.phases.get(self.largest, 0.0)  # below 1 where a few samples of no phase have most of the errors
        phase = f"largest {self.largest}, {above:.2g} times the mean" if above >= 1.0 else ""
        if not self.findings:
            return ("They are as white noise would be" + (f" ({phase})." if phase else "."),)
        return (*(finding.text for finding in self.findings), *((f"They are {phase}.",) if phase else ()))


def residual_report(problem: Problem, limits: Sequence[ReachedLimit], held_out: float) -> ResidualReport:
    """What the errors of a minimum tell; samples that do not count are left out of the tests.

    limits: that were reached; held_out: error of the held-out records over their deviation: 1 is that of a constant.
    """
    prediction, best = problem.prediction, problem.best
    records, scales = prediction.records, data_scales(prediction.records)
    causes, rest, late = _causes(problem, any(limit.whose == "law" for limit in limits))
    faulty = any(cause.kind in ("saturation", "quantisation", "delay") for cause in causes)
    moved = {} if faulty else moved_by_noise(problem)
    if moved:  # such errors of the motion go with what the force goes with
        causes = tuple(cause for cause in causes if cause.kind not in WITH_MOTION)
    parts = np.split(rest.rest, np.cumsum([int(count.sum()) for count in rest.counts])[:-1])
    errors, counts = prediction.by_record(best.errors), prediction.counts
    limits = [limit for limit in limits if limit.pressed and limit.whose == "law"]
    tau = max(1.0, float(np.mean([correlation_time(part) for part in parts])))
    white = _white(parts)
    units = [np.where(np.isfinite(u), u, 0.0) for u in prediction.units]
    rms = float(
        np.sqrt(np.mean(np.concatenate([(e * u)[c] for e, u, c in zip(errors, units, counts, strict=True)]) ** 2))
    )
    ratio = rms / max(scales.noise, 1e-300)
    phases = _phases(records, counts, np.concatenate(of(errors, counts)), scales) if best.cost > 0 else {}
    growth, sure = _growth(records, rest.counts, parts, tau)
    work = min(_work_ratio(record) for record in records)
    pulls = [(prior.name, abs(prior.pull)) for prior in prediction.priors if abs(prior.pull) > MOST]
    rows = [_finding("prior", pull, name, f"{pull:.2g}") for name, pull in pulls]
    if held_out >= 1.0:
        rows.append(_finding("held out", held_out, f"{held_out:.0%}"))
    if work < -NEGATIVE:
        rows.append(_finding("work", work, f"{work:.0%}"))
    for cause in causes:
        kind = BORNE if cause.kind == "outliers" and problem.loss.kind != "linear" else cause.kind
        rows.append(_finding(kind, cause.amount, *cause.words))
    if not white:
        rows.append(_finding("coloured", tau, f"{tau:.3g}"))
    if sure and not 1 / GROWTH < growth < GROWTH:
        rows.append(_finding("growing", growth, "grow" if growth > 1 else "shrink", f"{growth:.2g}"))
    if not white and ratio > FAR and not (causes or moved):
        rows.append(_finding("far from noise", ratio, f"{ratio:.2g}"))
    force = np.concatenate([record.force - np.mean(record.force) for record in records])
    relative = rms / max(float(np.sqrt(np.mean(force**2))), 1e-300)
    if not white and relative > POOR:
        rows.append(_finding("poor", relative, f"{relative:.0%}"))
    if moved:
        names = ", ".join(f"{name} ({change:+.1%})" for name, change in moved.items())
        rows.append(_finding("noisy motion", max(map(abs, moved.values())), names))
    rows += [_finding("limit", limit.value, limit.text) for limit in limits]
    largest = max(phases, key=lambda name: phases[name]) if phases else ""
    shares = {cause.kind: cause.share for cause in causes}
    delay, error = (late.delay, late.error) if late is not None else (0.0, math.inf)
    return ResidualReport(white, tau, ratio, shares, phases, largest, delay, error, work, tuple(rows))


def _causes(problem: Problem, held: bool) -> tuple[tuple[Cause, ...], Diagnosis, LateForce | None]:
    """The causes that the errors of a minimum point to, with what they leave and with the fit that a delay makes.

    A delay changes what the fit makes of the law. So where the errors have a pattern, the fit with a delay competes
    with it; if it explains more, its own errors are looked through for what else there is. held: whether a parameter
    stands at a limit of the law, which a delay does without any pattern.
    """

    prediction, best = problem.prediction, problem.best

    def refit(left: Sequence[np.ndarray]) -> tuple[Sequence[RecordErrors], np.ndarray]:
        units = [np.where(kept, unit, np.inf) for kept, unit in zip(left, prediction.units, strict=True)]
        less = prediction.of(prediction.records, units)
        end = descent(less, best.u, problem.loss, evaluations=REFITTED, stop=1e-6)
        return record_errors(prediction, finite(prediction.errors(end.u))), _absorbed(prediction, end)

    timed = type(prediction) is Prediction and DELAY not in prediction.space.names
    first = diagnosis(record_errors(prediction, best.errors), _absorbed(prediction, best), refit, timed)
    causes = first.causes
    if not timed or not (causes or held) or any(cause.kind in ("saturation", "quantisation") for cause in causes):
        return causes, first, None
    hint = next((cause.amount for cause in causes if cause.kind == "delay"), 0.0)
    late = late_force(problem, hint)
    if late is None or late.explained < max(LESS * sum(cause.share for cause in causes), SHARE):
        return causes, first, None
    errors = record_errors(late.prediction, late.best.errors)
    second = diagnosis(errors, _absorbed(late.prediction, late.best), timed=False)
    left, least = 1.0 - late.explained, max(SHARE, SECOND * late.explained)
    others = [dataclasses.replace(cause, share=left * cause.share) for cause in second.causes]
    delay = delay_cause(late.delay, late.explained, data_scales(prediction.records).interval)
    return (delay, *(cause for cause in others if cause.share > least)), second, late


def record_errors(prediction: Prediction, errors: np.ndarray) -> list[RecordErrors]:
    """The records with the errors of a minimum, predicted less measured over the units, as a diagnosis reads them."""
    all_errors = []
    rows = zip(prediction.records, prediction.units, prediction.counts, prediction.by_record(errors), strict=True)
    for record, units, count, error in rows:
        same = ("time", "velocity", "acceleration", "force", "velocity_made", "rotary")
        columns: dict[str, Any] = {name: getattr(record, name) for name in same} | {"place": record.position}
        predicted = record.force + error * np.where(np.isfinite(units), units, 0.0)
        unit, counts = float(np.min(units)), np.array(count)
        all_errors.append(RecordErrors(predicted=predicted, unit=unit, counts=counts, **columns))
    return all_errors


def _absorbed(prediction: Prediction, best: Minimum) -> np.ndarray:
    """Slopes of the errors by what the fit adapts; a mass of zero would have to become negative, and does not."""
    coordinates = zip(prediction.space.coordinates, best.u, strict=True)
    kept = [c.name not in TERMS or TERMS[c.name].signed or not c.at_limit(u) for c, u in coordinates]
    return best.slopes[: prediction.size, kept]


SAID = {
    "held out": "On the held-out records they are {} of the variation of the force, worse than a constant: the "
    "law with these parameters does not hold there.",
    "prior": "The prior of {} and the data differ by {} standard deviations: one of both is wrong.",
    "work": "Friction does negative work (force times velocity sums to {} of its size): the sign of the force or of "
    "the motion looks swapped, or a drive acts along.",
    "saturation": "The force saturates: {} of the samples lie on its limit of {}, cut off there by a sensor or its "
    "amplifier; no interval holds: leave these samples out, or measure with a wider range.",
    "quantisation": "The {} is quantised in steps of {}, visible in the force of the law; no interval "
    "holds: filter the motion (cutoff), or measure it finer.",
    "outliers": "Outliers: {} of the samples stand alone, far from those beside them: glitches of the measurement, "
    "which a robust loss (soft_l1) bears.",
    BORNE: "Outliers: {} of the samples stand alone, far from those beside them, which the robust loss bears.",
    "delay": "The force looks as if it {} the motion by {} s ({} samples), which would explain {} of the squares; no "
    "interval holds with a delay: fit it too (term delay), shift one of both, or filter them alike.",
    "ripple": "The force has a ripple with position, of a wavelength of {}: it explains {} of the squares; cogging, an "
    "eccentric part or a wavy surface.",
    "drift": "The contact or the sensor drifts: changes in the course of the record explain {} of the squares; "
    "warming, wear, or a drift of the sensor's zero.",
    "inertia": "They go with acceleration, as if the sensor carried {} more: it explains {} of the squares; fit it "
    "too (term mass), or subtract it.",
    "restoring": "They go with position as those of a spring or gravity, of {}: it explains {} of the squares; "
    "fit it too (terms spring and offset, or gravity), or subtract it: no friction law has such a force.",
    "direction": "They go with direction: it explains {} of their squares, so the two directions differ by more than "
    "the law knows (an anisotropic law, or the term offset).",
    "speed": "They go with speed: it explains {} of their squares, so the law's curve over speed is not that of the "
    "data.",
    "position": "They go with position: it explains {} of their squares, as if friction depended on the place.",
    "presliding": "They go with the distance since a reversal: it explains {} of their squares, so the contact yields "
    "differently from the law.",
    "coloured": "They are not white: errors are correlated over {} samples, which the intervals allow for.",
    "growing": "They {} with speed: {} times as large in the fastest third of the samples as in the slowest, which the "
    "intervals allow for.",
    "far from noise": "They are {} times the change from sample to sample: slow noise, or a feature that the law or "
    "the motion lacks.",
    "poor": "They are {} of the variation of the force, and correlated: the law explains little of the force.",
    "noisy motion": "The motion is noisy: another draw of its noise would move {}, out of the intervals or nearly; "
    "filter the motion (cutoff) or measure it finer.",
    "limit": "{}, and the data pull beyond it: the law or the data are wrong (a delay does so).",
}


def _finding(kind: str, amount: float, *words: str) -> Finding:
    return Finding(kind, SAID[kind].format(*words), amount)


def _white(errors: Sequence[np.ndarray]) -> bool:
    """Whether the first correlations are as small as chance makes them, over all records (Ljung and Box)."""
    from scipy.special import chdtrc

    total, degrees = 0.0, 0
    for error in errors:
        n, lags = len(error), min(LAGS, len(error) // 5)
        power = float(error @ error)
        if lags < 1 or not power > 0:
            continue
        rho = np.array([float(error[k:] @ error[:-k]) for k in range(1, lags + 1)]) / power
        total += n * (n + 2) * float(np.sum(rho**2 / (n - np.arange(1, lags + 1))))
        degrees += lags
    return bool(degrees == 0 or float(chdtrc(degrees, total)) > CHANCE)


def _growth(
    records: Sequence[Samples], counts: Sequence[np.ndarray], errors: Sequence[np.ndarray], tau: float
) -> tuple[float, bool]:
    """Ratio of the errors at the fastest third of the samples to the slowest, and whether chance is ruled out."""
    speed, error = np.concatenate(of([np.abs(record.velocity) for record in records], counts)), np.concatenate(errors)
    low, high = np.quantile(speed, [1 / 3, 2 / 3])
    slow, fast = error[speed <= low], error[speed >= high]
    if min(len(slow), len(fast)) < 10 or not slow.any():
        return 1.0, False
    growth = float(np.sqrt(np.mean(fast**2) / np.mean(slow**2)))
    spread = math.sqrt(0.5 * tau * (1 / len(slow) + 1 / len(fast)))  # of the logarithm, for normal errors
    return growth, bool(growth > 0 and abs(math.log(growth)) > 4 * spread)


def _phases(
    records: Sequence[Samples], counts: Sequence[np.ndarray], error: np.ndarray, scales: DataScales
) -> dict[str, float]:
    """Root mean square error over that of all samples, by phase of the motion."""
    labels = np.concatenate(of([_phase(record, scales) for record in records], counts))
    mean = float(np.sqrt(np.mean(error**2)))
    phases = {}
    for number, name in enumerate(("at rest", "just after reversals", "in slow sliding", "in fast sliding")):
        own = error[labels == number]
        if len(own) >= 0.01 * len(error):
            phases[name] = float(np.sqrt(np.mean(own**2))) / mean
    return phases


def _phase(record: Samples, scales: DataScales) -> np.ndarray:
    """0 at rest, 1 until the contact has gone twice the distance to break-away after a reversal, 2 slow, 3 fast."""
    speed = np.abs(record.velocity)
    side = np.sign(np.where(speed > REST * scales.speed, record.velocity, 0.0))
    place = record.displacement
    turning = np.zeros(len(record), bool)
    reach = 2 * scales.level / scales.stiffness if scales.stiffness else 0.02 * scales.length
    for begin, end in itertools.pairwise([*turns(side), len(record)]):
        turning[begin:end] = np.abs(place[begin:end] - place[begin]) < reach
    return np.where(side == 0, 0, np.where(turning, 1, np.where(speed < 0.3 * scales.speed, 2, 3)))


def _work_ratio(record: Samples) -> float:
    power, steps = record.force * record.velocity, np.diff(record.time)
    signed, size = (float(0.5 * (p[1:] + p[:-1]) @ steps) for p in (power, np.abs(power)))
    return signed / max(size, 1e-300)
