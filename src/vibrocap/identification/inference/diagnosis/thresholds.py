"""Thresholds of the diagnosis, each with its derivation where there is one.

`benchmarks/faulty_records.py` counts with them 100 records of each fault and of none: 95 of 100 are to be named, and
none else. `tests/test_identification_thresholds.py` has witnesses of each on both sides.
"""

import dataclasses


@dataclasses.dataclass(frozen=True)
class SaturationLimits:
    """A limit is named from n_0 >= fewest samples on it and ratio n_1 on, with n_1 samples just below it and beyond.

    Where a density falls towards its end, n_0 is binomial with a probability of at most one half of n_0 + n_1: by
    chance below 2^-6 at each end, and in noise there are not 6 samples so near to the largest one.

    width: of the band, in noises; beyond: noises below the limit up to which a predicted force counts as cut by it
    remaining: share of the samples that a saturated force must leave for other faults to be told
    """

    fewest: int = 6
    ratio: float = 5.0
    width: float = 0.05
    beyond: float = 4.0
    remaining: float = 0.2


@dataclasses.dataclass(frozen=True)
class ResolutionLimits:
    """`levels` or more differences are whole multiples of the least one, off by `whole` of it at most.

    Six others are so within 1 % with a probability below 10^-8. effect: share of the squared errors that the steps
    make, from which on they matter: as much as a pattern must explain.
    """

    levels: int = 6
    whole: float = 0.01
    effect: float = 0.02


@dataclasses.dataclass(frozen=True)
class OutlierLimits:
    """Outliers are `far` deviations away: of a million normal errors of one size none is.

    number: of them from which on they are told, or one that is twice as far; beside: samples on either side among which
    no difference of the force is as large; around: samples about a reversal, where a direction is uncertain
    """

    far: float = 7.0
    number: int = 2
    beside: int = 3
    around: int = 20


@dataclasses.dataclass(frozen=True)
class PatternLimits:
    """When a pattern of the errors is named.

    false_alarms: share of fits with nothing but noise in which some pattern may be named, all tests together
    share: of the squared errors that a pattern explains, from which on it matters
    main: of the squares that are no white noise, which the first cause explains at least
    second: of the first cause's share: a lesser one is told once the first has been put right
    general: of its share that counts for a pattern of many bins, against one of few columns
    same_wave: waves along the path by which ripples differ that are told apart
    """

    false_alarms: float = 1e-3
    share: float = 0.02
    main: float = 0.1
    second: float = 0.1
    general: float = 0.9
    same_wave: float = 0.5


SATURATION, RESOLUTION, OUTLIERS, PATTERNS = SaturationLimits(), ResolutionLimits(), OutlierLimits(), PatternLimits()
