"""The measures of one contact: how it sticks, its friction, and the ground's normal reaction."""

import functools

import numpy as np

from vibrocap.measures.gathered import Gathered
from vibrocap.measures.measure import Measure, Standard
from vibrocap.numerics.api import codes
from vibrocap.physics.names import numbered


def _of_contact(number: int) -> str:
    """Which contact, in the meaning of a measure; the first is that of most machines."""
    return "the contact" if number == 1 else f"contact {number}"


@functools.cache  # one and the same, by whichever table it is found
def sticking_measures(number: int) -> tuple[Measure, Measure, Measure]:
    """How a contact sticks."""
    contact, which = number - 1, _of_contact(number)

    def kind(runs: Gathered) -> str | None:
        laws = runs.system.laws
        return laws[contact].kind if contact < len(laws) else None

    def counted(name: str, runs: Gathered) -> np.ndarray:
        return runs.results.entry(name, contact) if kind(runs) == "set-valued" else runs.nowhere

    def sequences(runs: Gathered) -> np.ndarray:
        return np.full(len(runs.results), "") if kind(runs) in (None, "smooth") else runs.mode_sequences(contact)

    return (
        Measure(
            numbered("stick_fraction", number),
            f"share of the window in which {which} sticks (NaN: the law cannot stick)",
            Standard(lambda runs: counted("STICK_TIME", runs) / runs.time, codes.ASK_MODES),
        ),
        Measure(
            numbered("stick_phases", number),
            f"number of rests of {which} in the window, parts of rests included (NaN: the law cannot stick)",
            Standard(lambda runs: counted("STICK_PHASES", runs), codes.ASK_MODES),
        ),
        Measure(
            numbered("mode_sequence", number),
            f"mode sequence of {which} in the last period: F forward, S stuck, B back (empty: the law is smooth)",
            Standard(sequences, codes.ASK_MODES, text=True),
        ),
    )


@functools.cache
def friction_measures(number: int) -> tuple[Measure, ...]:
    """Of the friction at a contact."""
    contact, which = number - 1, "" if number == 1 else f" at contact {number}"

    def entry(name: str, runs: Gathered) -> np.ndarray:
        return runs.results.entry(name, contact) if contact < len(runs.system.laws) else runs.nowhere

    def area(of_contact: int, runs: Gathered) -> np.ndarray:
        place = len(runs.system.channels) + contact * codes.FUNCTIONS_PER_CONTACT + of_contact
        return runs.results.entry("INTEGRAL", place) / runs.periods if contact < len(runs.system.laws) else runs.nowhere

    return (
        Measure(
            numbered("peak_friction", number),
            f"largest friction force |R|{which} in the window",
            Standard(lambda runs: entry("PEAK", runs), codes.ASK_PEAK),
            si_unit="N",
        ),
        Measure(
            numbered("mean_friction", number),
            f"mean of the friction force |R|{which} over the window",
            Standard(lambda runs: entry("MAGNITUDE", runs) / runs.time, codes.ASK_MAGNITUDE),
            si_unit="N",
        ),
        Measure(
            numbered("velocity_loop_area", number),
            f"area of the loop of friction against velocity{which} per drive period, positive clockwise",
            Standard(lambda runs: area(2, runs), codes.ASK_INTEGRALS),
            si_unit="N m/s",
        ),
        Measure(
            numbered("displacement_loop_area", number),
            f"work against friction{which} per drive period, the area of the loop of friction against displacement",
            Standard(lambda runs: area(1, runs), codes.ASK_INTEGRALS),
            si_unit="J",
        ),
    )


@functools.cache
def reaction_measures(number: int) -> tuple[Measure, ...]:
    """Of the normal reaction of the ground at a contact."""
    which = "" if number == 1 else f" at contact {number}"

    def reaction(now):
        return getattr(now, numbered("reaction", number))

    return (
        Measure.mean(
            numbered("mean_reaction", number),
            f"mean normal reaction of the ground{which} over the window",
            reaction,
            si_unit="N",
        ),
        Measure.least(
            numbered("least_reaction", number),
            f"least normal reaction of the ground{which} in the window; below 0 the machine would have lifted off",
            reaction,
            si_unit="N",
        ),
        Measure.largest(
            numbered("largest_reaction", number),
            f"largest normal reaction of the ground{which} in the window",
            reaction,
            si_unit="N",
        ),
    )
