"""The measures of one contact: how it sticks, its friction, and the ground's normal reaction."""

import functools
from collections.abc import Callable

import numpy as np

from vibrocap.measures.gathered import Gathered
from vibrocap.measures.measure import Measure, Standard
from vibrocap.numerics.api import codes
from vibrocap.physics.names import numbered


@functools.cache  # one and the same, by whichever table it is found
def sticking_measures(number: int) -> tuple[Measure, ...]:
    """How a contact sticks."""
    contact, which = number - 1, "the contact" if number == 1 else f"contact {number}"

    def kind(runs: Gathered) -> str:
        return runs.system.laws[contact].kind if contact < len(runs.system.laws) else "smooth"

    def of(name: str, meaning: str, entry: str, share: bool = False) -> Measure:
        def value(runs: Gathered) -> np.ndarray:
            if kind(runs) != "set-valued":
                return runs.nowhere
            entry_values = runs.results.entry(entry, contact)
            return entry_values / runs.time if share else entry_values

        meaning = f"{meaning} (NaN: the law cannot stick)"
        return Measure(numbered(name, number), meaning, Standard(value, codes.ASK_MODES))

    def sequences(runs: Gathered) -> np.ndarray:
        return np.full(len(runs.results), "") if kind(runs) == "smooth" else runs.mode_sequences(contact)

    meaning = f"mode sequence of {which} in the last period: F forward, S stuck, B back (empty: the law is smooth)"
    return (
        of("stick_fraction", f"share of the window in which {which} sticks", "STICK_TIME", share=True),
        of("stick_phases", f"number of rests of {which} in the window, parts of rests included", "STICK_PHASES"),
        Measure(numbered("mode_sequence", number), meaning, Standard(sequences, codes.ASK_MODES, text=True)),
    )


@functools.cache
def friction_measures(number: int) -> tuple[Measure, ...]:
    """Of the friction at a contact."""
    contact, which = number - 1, "" if number == 1 else f" at contact {number}"

    def of(name: str, meaning: str, unit: str, group: int, value: Callable[[Gathered], np.ndarray]) -> Measure:
        def known(runs: Gathered) -> np.ndarray:
            return value(runs) if contact < len(runs.system.laws) else runs.nowhere

        return Measure(numbered(name, number), meaning, Standard(known, group), si_unit=unit)

    def area(function: int) -> Callable[[Gathered], np.ndarray]:
        first = contact * codes.FUNCTIONS_PER_CONTACT + function
        return lambda runs: runs.results.entry("INTEGRAL", len(runs.system.channels) + first) / runs.periods

    def peak(runs: Gathered) -> np.ndarray:
        return runs.results.entry("PEAK", contact)

    def mean(runs: Gathered) -> np.ndarray:
        return runs.results.entry("MAGNITUDE", contact) / runs.time

    turned = f"area of the loop of friction against velocity{which} per drive period, positive clockwise"
    work = f"work against friction{which} per drive period, the area of the loop of friction against displacement"
    return (
        of("peak_friction", f"largest friction force |R|{which} in the window", "N", codes.ASK_PEAK, peak),
        of("mean_friction", f"mean of the friction force |R|{which} over the window", "N", codes.ASK_MAGNITUDE, mean),
        of("velocity_loop_area", turned, "N m/s", codes.ASK_INTEGRALS, area(2)),
        of("displacement_loop_area", work, "J", codes.ASK_INTEGRALS, area(1)),
    )


@functools.cache
def reaction_measures(number: int) -> tuple[Measure, ...]:
    """Of the normal reaction of the ground at a contact."""
    which, lifts = "" if number == 1 else f" at contact {number}", "below 0 the machine would have lifted off"

    def of(kind: str, make: Callable[..., Measure], ending: str) -> Measure:
        name, meaning = numbered("reaction", number), f"{kind} normal reaction of the ground{which} {ending}"
        return make(f"{kind}_{name}", meaning, lambda now: getattr(now, name), si_unit="N")

    return (
        of("mean", Measure.mean, "over the window"),
        of("least", Measure.least, f"in the window; {lifts}"),
        of("largest", Measure.largest, "in the window"),
    )
