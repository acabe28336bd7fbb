"""The stretches of a record that are whole: between samples that a file does not have."""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from vibrocap.records.checks import FEWEST_SAMPLES, complaints

REGULAR = 0.9  # share of the intervals that are within a tenth of the usual one where samples follow a clock
GAP = 10.0  # usual intervals without a sample of a clock: across shorter ones the motion is nearly a straight line
MOST = 20  # records into which one is cut; each begins with a state of the contact that nobody knows


def whole_stretches(columns: Mapping[str, Any], place: Callable[[int], str]) -> tuple[list[slice], str]:
    """(samples of each usable stretch, what is left out, in words): all samples and "" where nothing is missing.

    A sample is missing where a column has NaN, and where a clock that ticks evenly otherwise skips ten samples.
    Friction remembers its motion, so a record ends where its motion is unknown, and another begins behind.

    columns: arrays of floats by field, time among them; place: names a sample, from its index
    """
    lengths = {len(values) for values in columns.values()}
    everything = [slice(None)]
    if len(lengths) != 1 or "time" not in columns or (count := lengths.pop()) < 2:
        return everything, ""
    there = ~np.any([np.isnan(values) for values in columns.values()], axis=0)
    steps = np.diff(columns["time"])
    usual = float(np.median(steps[there[1:] & there[:-1]])) if there.sum() > 1 else np.nan
    clock = np.mean(np.abs(steps - usual) <= 0.1 * usual) >= REGULAR
    skips = steps >= GAP * usual if clock else np.zeros(count - 1, bool)
    if there.all() and not skips.any():
        return everything, ""
    joined = there[1:] & there[:-1] & ~skips
    starts = np.flatnonzero(there & ~np.concatenate(([False], joined)))
    stops = np.flatnonzero(there & ~np.concatenate((joined, [False]))) + 1
    stretches = [slice(int(a), int(b)) for a, b in zip(starts, stops, strict=True) if b - a >= FEWEST_SAMPLES]
    pieces = [{name: values[stretch] for name, values in columns.items()} for stretch in stretches]
    stretches = [stretch for stretch, piece in zip(stretches, pieces, strict=True) if not complaints(piece)]
    if not 0 < len(stretches) <= MOST:
        return everything, ""
    kept = np.zeros(count, bool)
    for stretch in stretches:
        kept[stretch] = True
    words = []
    if not kept.all():
        first = place(int(np.argmin(kept)))
        words.append(f"{count - kept.sum():,} of {count:,} samples are left out, the first at {first}")
    if skips.any():
        words.append(f"no sample for {steps[skips].max():.4g} s, first behind {place(int(np.argmax(skips)))}")
    if len(stretches) > 1:
        words.append(f"it continues as {len(stretches)} records, each with a start of its own")
    return stretches, "; ".join(words)
