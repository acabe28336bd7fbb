"""Noise of the motion: what it would do to the parameters, from motions with as much noise again."""

import dataclasses

import numpy as np

from vibrocap.identification.inference.uncertainty import Uncertainty, inverse
from vibrocap.identification.problem.prediction import Prediction
from vibrocap.identification.search.loss import Minimum

MOVED = 0.5  # of half an interval, by which noise of the motion may move a parameter
SURROGATES = 2  # motions with noise of their own that are tried
ROUGH = 5e-4  # of the velocity (root mean square), below which it counts as smooth
SIXTH = 924**0.5  # standard deviation of sixth differences of white noise
LONGEST = 40_000  # samples of these


def moved_by_noise(prediction: Prediction, best: Minimum, spread: Uncertainty) -> dict[str, float]:
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
    # what a smooth motion with few samples in a period leaves, too, has small sixth differences
    sixth = float(np.median(np.abs(np.diff(velocity, 6)))) / 0.6745 / SIXTH
    if min(usual, sixth) < ROUGH * float(np.sqrt(np.mean(velocity**2))):
        return np.zeros_like(velocity)
    return np.clip(rough, -4 * usual, 4 * usual)  # corners of the motion are no noise


def _redrawn(noise: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Noise of the same spectrum with random phases."""
    spectrum = np.fft.rfft(noise)
    turned = np.abs(spectrum) * np.exp(2j * np.pi * rng.random(len(spectrum)))
    return np.fft.irfft(turned, len(noise))
