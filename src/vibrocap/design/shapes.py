"""Shapes of a Fourier drive at an exact peak, so that a search over shapes needs no constraint on the peak."""

from collections.abc import Sequence

import numpy as np

from vibrocap.arguments import ArgumentError
from vibrocap.physics.drives.harmonics import HARMONICS
from vibrocap.quantities.declared import Number, Numbers

FINE = 32  # points for each half wave of the highest harmonic, among which the peaks are looked for
POLISHED = 5  # Newton steps from there: errors of (1/32)^2 are squared at each


def drive_shape(
    peak: Number | Numbers, cosines: Sequence[Number | Numbers], sines: Sequence[Number | Numbers] = ()
) -> dict[str, Numbers]:
    """Coefficients of a `FourierSeries` by path, with the given proportions and the given peak of |drive|.

    The largest size of a_1 cos(s) + b_1 sin(s) + a_2 cos(2 s) + ... over a period is located where its slope vanishes,
    to rounding, and all are scaled with it. What is left over of a search are free proportions: fix a_1 = 1, b_1 = 0.

    peak: [n], or one for all; cosines, sines: of each harmonic [n] or one number, as many as the shape has; sines that
        are not given are 0
    Returns arrays [n] for "drive.cosine_1", "drive.sine_1" and so on. Raises ArgumentError for too many harmonics. A
    shape without any part has no peak: it stays 0.
    """
    count = max(len(cosines), len(sines))
    if not 1 <= count <= len(HARMONICS):
        raise ArgumentError("cosines", f"should be of one to {len(HARMONICS)} harmonics, got {count}")
    proportions = [*cosines, *(0.0,) * (count - len(cosines)), *sines, *(0.0,) * (count - len(sines))]
    *parts, wanted = np.broadcast_arrays(
        *(np.atleast_1d(np.asarray(number, dtype=float)) for number in (*proportions, peak))
    )
    shape = np.stack(parts)  # [cosines and sines, n]
    largest = _peaks(shape[:count], shape[count:])
    scaled = shape * np.divide(wanted, largest, out=np.zeros(len(largest)), where=largest > 0.0)
    names = [f"drive.{part}_{n}" for part in ("cosine", "sine") for n in range(1, count + 1)]
    return dict(zip(names, scaled, strict=True))


def _peaks(cosines: np.ndarray, sines: np.ndarray) -> np.ndarray:
    """The largest size [n] over a period of sums of harmonics, cosines and sines [harmonics, n]."""
    orders = np.arange(1.0, len(cosines) + 1.0)
    places = np.linspace(0.0, 2.0 * np.pi, 2 * FINE * len(orders), endpoint=False)
    angles = np.outer(places, orders)
    size = np.abs(np.cos(angles) @ cosines + np.sin(angles) @ sines)
    place, which = np.nonzero((size >= np.roll(size, 1, axis=0)) & (size >= np.roll(size, -1, axis=0)))
    a, b, s, step = cosines[:, which], sines[:, which], places[place], places[1]
    for _ in range(POLISHED):
        c, d = np.cos(orders[:, None] * s), np.sin(orders[:, None] * s)
        slope, curvature = orders @ (b * c - a * d), -(orders**2) @ (a * c + b * d)
        s = s - np.clip(np.divide(slope, curvature, out=np.zeros(len(s)), where=curvature != 0.0), -step, step)
    polished = np.abs(np.sum(a * np.cos(orders[:, None] * s) + b * np.sin(orders[:, None] * s), axis=0))
    peaks = np.max(size, axis=0)
    np.maximum.at(peaks, which, polished)
    return peaks
