"""Starts of many runs: spread evenly over ranges of the states, given ones or those that motions visit."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from vibrocap.arguments import ArgumentError
from vibrocap.numerics.api import Budget, codes
from vibrocap.orbits.closing.settling_runs import ROUGH
from vibrocap.orbits.maps.stroboscopic_map import MOST_EVENTS, MOST_STEPS, StroboscopicMap
from vibrocap.orbits.parameter_range import checked_pair
from vibrocap.physics.dimensions.conversion import INITIAL, value_in_words
from vibrocap.physics.system import System

PROBES, PROBE_PERIODS = 16, 20  # runs that look for what motions visit
PROBED = 2.0  # natural sizes from zero at which probes start

Ranges = Mapping[str, tuple[float, float]]


def checked_ranges(system: System, asked: Any) -> dict[str, tuple[float, float]]:
    """Ranges by state, (low, high) each; ValueError naming what is wrong with them."""
    if not isinstance(asked, Mapping) or not asked:
        raise ArgumentError("ranges", f"should give (low, high) for at least one state, got {asked!r}")
    for state in asked:
        check_state("ranges", system, state)
    return {state: checked_start_range(f"ranges: {state}", system, state, pair) for state, pair in asked.items()}


def checked_start_range(name: str, system: System, state: str, pair: Any) -> tuple[float, float]:
    """(low, high) of the starts of a state; ValueError for what is no range, or lies beyond a rigid stop."""
    low, high = checked_pair(name, system, INITIAL + state, pair)
    least, most = system.placed.room().get(state, (-np.inf, np.inf))
    if low < least or high > most:
        words = [value_in_words(INITIAL + state, end, system) for end in (least, most, low, high)]
        between, got = (" to ".join(ends) for ends in (words[:2], words[2:]))
        raise ArgumentError(name, f"should lie between the stops, {between}, got {got}")
    return low, high


def check_state(name: str, system: System, state: Any) -> None:
    """ValueError for what is no state of the system at which runs can start apart."""
    useful = [name for name in system.state_names if name not in (system.cyclic, *system.switched)]
    if state in useful:
        return
    why = f"{state!r} is no state of the system"
    if state == system.cyclic:
        why = f"nothing depends on {state!r}: a start shifted along it makes the same motion"
    elif state in system.switched:
        why = f"{state!r} is a mode of the law or the machine, no quantity"
    raise ArgumentError(name, f"{why}; there are {', '.join(useful)}")


def spread_starts(map_: StroboscopicMap, start: np.ndarray, ranges: Ranges, count: int) -> np.ndarray:
    """Starts [count, states]: spread over the ranges, all other states as in `start` [states]."""
    starts = np.tile(start, (count, 1))
    names = map_.system.state_names
    for (state, (low, high)), share in zip(ranges.items(), evenly_spread(count, len(ranges)).T, strict=True):
        starts[:, names.index(state)] = low + (high - low) * share
    return starts


def evenly_spread(count: int, dimensions: int) -> np.ndarray:
    """Points [count, dimensions] in the unit cube: Roberts' R sequence, of low discrepancy and without a seed.

    x_k = frac(1/2 + k phi^-j), where phi^(d+1) = phi + 1; the first points stay where they are when more are asked for.
    """
    phi = 2.0
    for _ in range(64):
        phi = (1.0 + phi) ** (1.0 / (dimensions + 1))
    steps = phi ** -np.arange(1.0, dimensions + 1)
    return np.mod(0.5 + np.arange(1, count + 1)[:, None] * steps, 1.0)


def visited_ranges(map_: StroboscopicMap, start: np.ndarray) -> dict[str, tuple[float, float]]:
    """Ranges that motions visit which start anywhere within two natural sizes of each mechanical state.

    Internal states of a law start as in `start`, since not all of their values are possible; symmetric about zero where
    mirror images of motions are motions.
    """
    system, parameters = map_.system, map_.parameters()
    mechanical = len(system.machine.states)
    sizes = map_.scales(parameters)
    free = [i for i in map_.smooth_states if i < mechanical]
    probes = np.tile(start, (PROBES, 1))
    probes[:, free] = PROBED * sizes[free] * (2.0 * evenly_spread(PROBES, len(free)) - 1.0)
    room = system.placed.room()
    for name, (least, most) in room.items():
        i = system.state_names.index(name)
        probes[:, i] = np.clip(probes[:, i], least, most)
    budget = Budget(PROBE_PERIODS, ROUGH, MOST_EVENTS, MOST_STEPS, asked=codes.ASK_EXTREMES)
    ends = map_.run(budget, probes, parameters)
    fine = ends[ends.finished]
    ranges = {}
    for i in map(int, map_.section_states):
        name = system.state_names[i]
        low, high = (-PROBED * sizes[i], PROBED * sizes[i]) if i < mechanical else (np.inf, -np.inf)
        if len(fine):
            low = min(low, float(fine.entry("LEAST", i).min()))
            high = max(high, float(fine.entry("LARGEST", i).max()))
        if system.mirrored and system.symmetry[i] < 0:
            low, high = -max(-low, high), max(-low, high)
        if name in system.turns and high - low > system.turns[name]:  # then all of its circle
            low, high = -0.5 * system.turns[name], 0.5 * system.turns[name]
        least, most = room.get(name, (-np.inf, np.inf))
        low, high = max(low, least), min(high, most)
        if name not in system.switched and np.isfinite(low) and low < high:
            ranges[name] = (float(low), float(high))
    return ranges
