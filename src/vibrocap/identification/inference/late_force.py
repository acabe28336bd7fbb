"""Refits that tell a fault of the data: with a late force, and with motions of as much noise again."""

import dataclasses
import math

import numpy as np

from vibrocap.identification.inference.errors import roughness
from vibrocap.identification.inference.uncertainty import Problem, inverse, uncertainty
from vibrocap.identification.problem.prediction import Prediction, delay_coordinate
from vibrocap.identification.search import Loss, Minimum, descent, finite

LATE, LEAST_DELAY = 4.0, 0.02  # standard errors of a delay, and share of a sampling interval
EVALUATIONS = 25  # of the search
LATENESS = (0.3, 1.0, 4.0, 16.0)  # samples, either way, from which a delay is sought
LOOKS, POINTS, SETTLED = 3, 21, 1e-3  # looks about the end; delays that each tries; share of the cost that ends them


@dataclasses.dataclass(frozen=True, eq=False)
class LateForce:
    """The fit with a delay, s, its standard error, the share of the cost that it explains, prediction and minimum."""

    delay: float
    error: float
    explained: float
    prediction: Prediction
    best: Minimum


def late_force(problem: Problem, hint: float) -> LateForce | None:
    """The fit with a delay, by a short descent; None where no delay can be told from none.

    A force that is early or late looks like damping and bends the drop of friction; so all parameters go along. hint:
    a delay in s that the errors suggest. Both costs are of the same samples.
    """
    prediction, best, loss = problem.prediction, problem.best, problem.loss
    coordinate = delay_coordinate(prediction.records)
    space = prediction.space.with_more((coordinate,))
    late = dataclasses.replace(prediction, space=space)
    pinned = np.array([c.at_limit(u) != 0 for c, u in zip(prediction.space.coordinates, best.u, strict=True)])
    # a damping that a delay has driven to zero is far from where it belongs
    inside = np.where(pinned, 0.3 * prediction.space.low + 0.7 * prediction.space.high, best.u)
    low, high = coordinate.range
    delays = np.clip([hint / coordinate.scale, *LATENESS, *(-lateness for lateness in LATENESS)], low, high)
    latest = None
    for u in [best.u, inside] if pinned.any() else [best.u]:
        end = _lowest(late, np.append(u, 0.0), delays, loss)
        for _ in range(LOOKS):  # a law that jumps has a cost that does so with the delay
            near = np.clip(end.u[-1] + np.linspace(-1, 1, POINTS), low, high)
            again = _lowest(late, end.u, near, loss)
            if not again.cost < (1 - SETTLED) * end.cost:
                break
            end = again
        latest = end if latest is None or end.cost < latest.cost else latest
    assert latest is not None
    own, known = np.split(latest.slopes, [late.size])
    spread = uncertainty(late.by_record(latest.errors), own, known, space.slopes(latest.u), loss)
    delay, error = float(space.values(latest.u)[-1]), float(np.sqrt(spread.covariance[-1, -1]))
    gain = 2.0 * (best.cost - latest.cost) / (spread.unit * float(spread.inflation[-1]))  # of -2 log(likelihood)
    if not (gain > LATE**2 and abs(latest.u[-1]) > LEAST_DELAY and not coordinate.at_limit(latest.u[-1])):
        return None
    explained = 1.0 - latest.cost / max(best.cost, 1e-300)
    return LateForce(delay, error if math.isfinite(error) else math.inf, explained, late, latest)


def _lowest(prediction: Prediction, u: np.ndarray, delays: np.ndarray, loss: Loss) -> Minimum:
    """The end of a descent from the best of several delays, the last coordinate."""
    table = np.tile(u, (len(delays), 1))
    table[:, -1] = delays
    costs = [float(loss.cost(finite(prediction.errors(row)))) for row in table]
    return descent(prediction, table[int(np.argmin(costs))], loss, evaluations=EVALUATIONS, stop=1e-5)


MOVED = 0.5  # of half an interval, by which noise of the motion may move a parameter
SURROGATES = 2  # motions with noise of their own that are tried
ROUGH = 5e-4  # of the velocity (root mean square), below which it counts as smooth
SIXTH = 924**0.5  # standard deviation of sixth differences of white noise
LONGEST = 40_000  # samples of these


def moved_by_noise(problem: Problem) -> dict[str, float]:
    """Parameters, with their relative change, that noise of the motion of the size that is there would move too far.

    The law is driven by the measured motion with further noise of the same spectrum, and the parameters that would best
    give the force of the measured motion back are found by one step of Gauss and Newton.
    """
    prediction, best, spread = problem.prediction, problem.best, problem.uncertainty
    if type(prediction) is not Prediction or prediction.size > LONGEST:
        return {}
    rough = [_noise_of_motion(record.velocity) for record in prediction.records]
    if not any(noise.any() for noise in rough):
        return {}
    base = prediction.errors(best.u)
    half = spread.threshold * np.sqrt(np.diag(spread.covariance) / spread.inflation)
    to_parameters, values = prediction.space.slopes(best.u), prediction.space.values(best.u)
    rng, moves = np.random.default_rng(0), []
    for _ in range(SURROGATES):
        pairs = zip(prediction.records, rough, strict=True)
        records = [dataclasses.replace(r, velocity=r.velocity + _redrawn(noise, rng)) for r, noise in pairs]
        noisy = prediction.of(records, prediction.units)
        errors = noisy.errors(best.u)
        counted = np.isfinite(errors - base)
        slopes, change = np.nan_to_num(noisy.slopes(best.u, errors)[counted]), (errors - base)[counted]
        moves.append(to_parameters @ -(inverse(slopes.T @ slopes) @ (slopes.T @ change)))
    moved = np.mean(moves, axis=0)
    return {
        name: float(moved[i] / values[i])
        for i, name in enumerate(prediction.space.names)
        if name in prediction.law_names and abs(moved[i]) > MOVED * half[i] and 0 < half[i] < abs(values[i])
    }


def _noise_of_motion(velocity: np.ndarray) -> np.ndarray:
    """What cubics over nine samples leave of a velocity; zero where that is rounding."""
    rough = roughness(velocity) if len(velocity) >= 16 else np.zeros(1)
    usual = float(np.median(np.abs(rough))) / 0.6745
    # what a smooth motion with few samples in a period leaves, too, has small sixth differences
    sixth = float(np.median(np.abs(np.diff(velocity, 6)))) / 0.6745 / SIXTH if usual else 0.0
    if min(usual, sixth) < ROUGH * float(np.sqrt(np.mean(velocity**2))):
        return np.zeros_like(velocity)
    return np.clip(rough, -4 * usual, 4 * usual)  # corners of the motion are no noise


def _redrawn(noise: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Noise of the same spectrum with random phases."""
    spectrum = np.fft.rfft(noise)
    turned = np.abs(spectrum) * np.exp(2j * np.pi * rng.random(len(spectrum)))
    return np.fft.irfft(turned, len(noise))
