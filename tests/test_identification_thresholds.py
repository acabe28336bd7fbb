"""Thresholds of the diagnosis: witnesses of the values where the verdict changes."""

import dataclasses

import numpy as np
import pytest

from vibrocap.identification.inference.diagnosis.causes import diagnosis
from vibrocap.identification.inference.diagnosis.errors import RecordErrors
from vibrocap.identification.inference.diagnosis.measurement_faults import (
    outliers,
    quantisation,
    resolution,
    saturation,
)

TIME = np.linspace(0.0, 40.0, 4000)


def record(error, predicted=None) -> RecordErrors:
    """A steady motion under a force of two sinusoids, unless another is predicted, with errors in newtons."""
    velocity = 0.3 * np.cos(1.1 * TIME) + 0.2 * np.sin(2.3 * TIME)
    place = 0.3 / 1.1 * np.sin(1.1 * TIME) - 0.2 / 2.3 * np.cos(2.3 * TIME)
    smooth = 4.0 * np.tanh(velocity / 0.1) if predicted is None else predicted
    whole = np.ones(len(TIME), bool)
    return RecordErrors(TIME, velocity, np.gradient(velocity, TIME), place, smooth + error, smooth, 1.0, whole)


def noise(size=0.01, seed=0):
    return size * np.random.default_rng(seed).standard_normal(len(TIME))


def cut_off(on, below=0, apart=0.0):
    """Whether a force is called cut off of which `on` samples lie near its largest, `below` just below.

    apart: distance of every second of them from it, in noises.
    """
    level = noise(0.001)
    force = np.sin(TIME) + level
    force[100 : 100 + on] = 3.0
    size = 0.001
    force[100 : 100 + on : 2] -= apart * size
    force[2000 : 2000 + below] = 3.0 - 0.03 * size
    made = dataclasses.replace(record(0.0), force=force, predicted=np.sin(TIME))
    return saturation([made])[0] is not None


def predicted_beyond(noises):
    """Whether a sample counts as touched that is predicted so many noises below the limit."""
    level = noise(0.001)
    force, predicted = np.sin(TIME) + level, np.sin(TIME)
    force[100:120] = 3.0
    predicted[3000] = 3.0 - noises * 0.001
    _, (touched,) = saturation([dataclasses.replace(record(0.0), force=force, predicted=predicted)])
    return bool(touched[3000])


def told_beside_a_limit(kept):
    """Whether inertia is told of a force that is cut off in all but such a share of the samples."""
    made = record(0.0)
    predicted = 3.0 / np.sin(0.5 * np.pi * kept) * np.sin(1.7 * TIME)
    force = np.clip(predicted + 0.2 * made.acceleration + noise(0.01), -3.0, 3.0)
    causes = diagnosis([dataclasses.replace(made, force=force, predicted=predicted)]).causes
    return [cause.kind for cause in causes[:1]] == ["saturation"] and len(causes) > 1


def coloured(share):
    """Whether inertia is named that has such a share of errors that else are coloured noise, as of a process."""
    made, white = record(0.0), noise(1.0, 8)
    wave = made.acceleration / np.sqrt(np.mean(made.acceleration**2))
    process = np.zeros(len(TIME))
    for i in range(1, len(TIME)):
        process[i] = 0.7 * process[i - 1] + white[i]
    process -= wave * (wave @ process) / (wave @ wave)
    process /= np.sqrt(np.mean(process**2))
    error = np.sqrt(share) * wave + np.sqrt(1.0 - share) * process
    return "inertia" in {cause.kind for cause in diagnosis([record(error)]).causes}


def whole_multiples(levels, off):
    """Whether values have a resolution, one of whose steps is off by a share."""
    values = np.arange(levels + 1.0)
    values[-1] += off
    return resolution(np.repeat(values, 3)) > 0.0


def coarse(share):
    """Whether a velocity in steps of which the force has such a share of the squared errors is called coarse.

    The law is linear, 10 v: its errors by steps q are 10 q/sqrt(12), and nothing jumps.
    """
    velocity = 1e-3 * np.round((0.3 + 0.1 * np.sin(TIME)) / 1e-3)
    predicted = 10.0 * (0.3 + 0.1 * np.sin(TIME))
    effect = 10.0 * 1e-3 / np.sqrt(12.0)
    error = np.where(np.arange(len(TIME)) % 2, 1.0, -1.0) * effect / np.sqrt(share)
    return quantisation([dataclasses.replace(record(error, predicted), velocity=velocity)]) is not None


def struck(times, count):
    """Whether samples so many deviations off, at the middle of a half wave, are called outliers.

    Errors change their sign from sample to sample, so that their deviation is known.
    """
    alternating = np.where(np.arange(len(TIME)) % 2, 1.0, -1.0)
    error = 1e-2 * alternating
    made = record(error, np.zeros(len(TIME)))
    # second differences of +-a are 2 a, robust deviation 2 a/(0.6745 sqrt(1.5))
    deviation = 2.0 * 1e-2 / (0.6745 * np.sqrt(1.5))
    at = 500 + 1000 * np.arange(count)
    error[at] = 1e-2 + times * deviation
    return outliers([made], [error])[0] is not None


def patterned(share, size=1.0, seed=3):
    """Kinds of causes where inertia has such a share of the squared errors, beside white noise."""
    made = record(0.0)
    wave = made.acceleration / np.sqrt(np.mean(made.acceleration**2))
    white = noise(1.0, seed)
    white -= wave * (wave @ white) / (wave @ wave)
    white /= np.sqrt(np.mean(white**2))
    error = size * (np.sqrt(share) * wave + np.sqrt(1.0 - share) * white)
    return tuple(cause.kind for cause in diagnosis([record(error)]).causes)


def beside(share):
    """Kinds of causes where a ripple has such a share of what inertia has."""
    made = record(0.0)
    wave = made.acceleration / np.sqrt(np.mean(made.acceleration**2))
    ripple = np.sqrt(2.0) * np.sin(2.0 * np.pi * made.place / 0.05)
    error = wave + np.sqrt(share / (1.0 + share)) * ripple + noise(0.01)
    return {cause.kind for cause in diagnosis([record(error)]).causes}


WITNESSES = {
    "saturation: samples on the limit": (cut_off, (5,), (7,)),
    "saturation: those below it": (cut_off, (25, 6), (26, 4)),
    "saturation: prediction below it": (predicted_beyond, (5.5,), (3.0,)),
    "saturation: what remains": (told_beside_a_limit, (0.15,), (0.3,)),
    "resolution: levels": (whole_multiples, (5, 0.0), (6, 0.0)),
    "resolution: whole multiples": (whole_multiples, (8, 0.013), (8, 0.008)),
    "resolution: effect": (coarse, (0.015,), (0.03,)),
    "outliers: deviations": (struck, (6.5, 2), (8.0, 2)),
    "outliers: number": (struck, (13.0, 1), (13.0, 2)),
    "outliers: one alone": (struck, (13.0, 1), (15.5, 1)),
    "patterns: share": (lambda share: patterned(share) != (), (0.012,), (0.03,)),
    "patterns: main": (coloured, (0.06,), (0.15,)),
    "patterns: second": (lambda share: "ripple" in beside(share), (0.06,), (0.15,)),
}


@pytest.mark.parametrize("name", WITNESSES)
def test_a_threshold_has_a_witness_on_both_sides(name):
    verdict, short, beyond = WITNESSES[name]
    assert [verdict(*short), verdict(*beyond)] == [False, True]
