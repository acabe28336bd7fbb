"""Thresholds of the diagnosis: witnesses of the values where the verdict changes."""

import dataclasses

import numpy as np
import pytest

from vibrocap.identification.inference.diagnosis import diagnosis
from vibrocap.identification.inference.errors import (
    RecordErrors,
    outliers,
    quantisation,
    resolution,
    saturation,
)
from vibrocap.identification.inference.patterns import speed

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


def swung(share):
    """Whether inertia is named that has such a share of errors that else are a swing in time, as of another machine."""
    made = record(0.0)
    wave = made.acceleration / np.sqrt(np.mean(made.acceleration**2))
    error = np.sqrt(share) * wave + np.sqrt(2.0 * (1.0 - share)) * np.sin(7.3 * TIME) + noise(0.01)
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


def patterned(share, count=4000):
    """Kinds of causes where inertia has such a share of the squared errors of so many samples, beside white noise."""
    counts = np.arange(len(TIME)) < count
    wave = np.where(counts, record(0.0).acceleration, 0.0)
    wave /= np.sqrt(np.mean(wave[counts] ** 2))
    white = np.where(counts, noise(1.0, 3), 0.0)
    white -= wave * (wave @ white) / (wave @ wave)
    white /= np.sqrt(np.mean(white[counts] ** 2))
    made = record(np.sqrt(share) * wave + np.sqrt(1.0 - share) * white)
    return tuple(cause.kind for cause in diagnosis([dataclasses.replace(made, counts=counts)]).causes)


def rough_near_a_turn(samples):
    """Whether a velocity in steps is called coarse whose prediction is rough so many samples from where it turns."""
    made = record(0.0)
    at = np.flatnonzero(made.turned)[:, None] + samples * np.array([-1, 1])
    predicted = np.zeros(len(TIME))
    predicted[at[(at > 0) & (at < len(TIME))]] = 1.0
    error = 0.5 * np.sqrt(np.mean(predicted**2)) * np.where(np.arange(len(TIME)) % 2, 1.0, -1.0)
    velocity = 1e-6 * np.round(made.velocity / 1e-6)
    return quantisation([dataclasses.replace(record(error, predicted), velocity=velocity)]) is not None


def struck_beside_a_jump(samples):
    """Whether samples far off, so many behind a jump of the force as large, are called outliers."""
    error, predicted = 1e-2 * np.where(np.arange(len(TIME)) % 2, 1.0, -1.0), np.zeros(len(TIME))
    for at in (500, 1500):
        predicted[at:] += 1.0
        error[at + samples] = 1.0
    made = record(error, predicted)
    return outliers([made], [error])[0] is not None


def general(ratio):
    """Whether means over bins of the speed are named first that explain so many times what inertia does."""
    made = record(0.0)
    wave = made.acceleration / np.linalg.norm(made.acceleration)
    bins = speed([made]).columns / np.sqrt(np.sum(speed([made]).columns, axis=0))
    among = bins.T @ wave
    other = np.where(np.arange(bins.shape[1]) % 2, 1.0, -1.0)
    other -= among * (among @ other) / (among @ among)
    error = wave + np.sqrt(ratio - among @ among) * bins @ other / np.linalg.norm(other)
    both = np.linalg.qr(np.column_stack((wave, bins)))[0]
    white = noise(0.08)
    return diagnosis([record(error + white - both @ (both.T @ white))]).causes[0].kind == "speed"


def jointly(stiffness):
    """Whether a mass of 1 kg is found as it is, beside a spring of such a stiffness."""
    made = record(0.0)
    causes = diagnosis([record(made.acceleration + stiffness * made.place + noise(0.001))]).causes
    return abs(next(cause.amount for cause in causes if cause.kind == "inertia") - 1.0) < 1e-2


def turned_beside_gravity(waves):
    """Whether a ripple alone is named that has so many waves more along four turns than one in each."""
    made = record(0.0)
    place = 8.0 * np.pi * (made.place - made.place.min()) / np.ptp(made.place)
    error = np.sin((1.0 + waves / 4.0) * place) + noise(0.001)
    turning = dataclasses.replace(record(error, 4.0 * np.tanh(made.velocity / 0.1)), place=place, rotary=True)
    return [cause.kind for cause in diagnosis([turning]).causes] == ["ripple"]


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
    "outliers: beside": (struck_beside_a_jump, (2,), (5,)),
    "outliers: around": (rough_near_a_turn, (15,), (25,)),
    "patterns: false alarms": (lambda share: patterned(share, 400) != (), (0.037,), (0.04,)),
    "patterns: general": (general, (1.05,), (1.2,)),
    "patterns: general, jointly": (jointly, (0.8,), (1.0,)),
    "patterns: same wave": (turned_beside_gravity, (0.4,), (0.6,)),
    "patterns: share": (lambda share: patterned(share) != (), (0.012,), (0.03,)),
    "patterns: main": (swung, (0.06,), (0.15,)),
    "patterns: second": (lambda share: "ripple" in beside(share), (0.06,), (0.15,)),
}


@pytest.mark.parametrize("name", WITNESSES)
def test_a_threshold_has_a_witness_on_both_sides(name):
    verdict, short, beyond = WITNESSES[name]
    assert [verdict(*short), verdict(*beyond)] == [False, True]
