"""The standard measures of a run: what each is called, what it means, and how it is read from what was gathered."""

import functools
import re
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from vibrocap.measures.gathered import Gathered
from vibrocap.measures.measure import Measure, Standard
from vibrocap.measures.recorded.settling import MIRROR_SHARE
from vibrocap.motion.recording.equations import equations
from vibrocap.numerics.api import codes
from vibrocap.physics.catalogue import laws, machines
from vibrocap.physics.dimensions.units import DRIVE_UNITS, over_seconds, quantity_unit, state_units
from vibrocap.physics.environment import Environment
from vibrocap.physics.events import IMPACT
from vibrocap.physics.flow import CONTACT_CHANNELS
from vibrocap.physics.friction.law import Law
from vibrocap.physics.machines.machine import Machine
from vibrocap.physics.names import numbered
from vibrocap.physics.system import System


@functools.cache  # one and the same, by whichever table it is found
def sticking_measures(number: int) -> tuple[Measure, ...]:
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
    which, lifts = "" if number == 1 else f" at contact {number}", "below 0 the machine would have lifted off"

    def of(kind: str, make: Callable[..., Measure], ending: str) -> Measure:
        name, meaning = numbered("reaction", number), f"{kind} normal reaction of the ground{which} {ending}"
        return make(f"{kind}_{name}", meaning, lambda now: getattr(now, name), si_unit="N")

    return (
        of("mean", Measure.mean, "over the window"),
        of("least", Measure.least, f"in the window; {lifts}"),
        of("largest", Measure.largest, "in the window"),
    )


STANDING_CHANNELS = CONTACT_CHANNELS[:2]  # of every system


def standard_measures(system: System | None = None) -> Mapping[str, Measure]:
    """The standard measures by name: those of a system's states and energy channels, or (None) of all that there are.

    The switched states of machines and laws say which of their branches holds; their largest and least values
    mean nothing.
    """
    if system is None:
        return _standard_measures(None, tuple(machines().values()), tuple(laws().values()))
    return _standard_measures(system, (type(system.machine),), (type(system.friction),))


def undefined_measures(system: System) -> frozenset[str]:
    """Names of standard measures that mean nothing for any motion of a system: NaN, an empty text, or refused.

    A study over kinds of parts may ask for them all the same, for what another kind has.
    """
    nothing = {
        "symmetric": not (system.mirrored and equations(system).timed),
        LOAD_WATCH: system.machine.follows_load,
        **{f"{channel}_work": channel not in system.channels for channel in CONTACT_CHANNELS},
        **{value.name: system.cyclic is None for value in (*TRAVEL, _cost_of_transport("drive"))},
    }
    for i, law in enumerate(system.laws, 1):
        share, phases, sequence = sticking_measures(i)
        nothing |= {share.name: law.kind != "set-valued", phases.name: law.kind != "set-valued"}
        nothing[sequence.name] = law.kind == "smooth"
    return frozenset(name for name, undefined in nothing.items() if undefined)


def known_measure(name: str, system: System | None = None) -> Measure | None:
    """The measure of a name: one that a system has, one that there is of any, or one of any further contact."""
    return standard_measures(system).get(name) or standard_measures().get(name) or further_measure(name)


@functools.lru_cache(maxsize=16)
def _standard_measures(
    system: System | None, kinds: tuple[type[Machine], ...], contacts: tuple[type[Law], ...]
) -> Mapping[str, Measure]:
    lawful = [tuple(name for name in law.internal if name not in law.switched) for law in contacts]
    moving = (tuple(name for name in kind.states if name not in kind.switched) for kind in kinds)
    states = dict.fromkeys(state for names in (*moving, *lawful) for state in names)
    systems = [{"machine": kind, "friction": law} for kind in kinds for law in contacts]
    known = [state_units(parts) for parts in (systems if system is None else [system.parts])]
    units = {name: unit for value in known for name, unit in value.items()}
    surroundings = [Environment()] if system is None else [system.environment] if system.environment else []
    outside = (channel for surrounding in surroundings for kind in kinds for channel in surrounding.channels(kind()))
    channels = dict.fromkeys((*(channel for kind in kinds for channel in kind.channels), *outside))
    each_contact = range(1, 1 + max(len(kind.contact_states) for kind in kinds))
    channels |= dict.fromkeys(numbered(name, number) for number in each_contact[1:] for name in STANDING_CHANNELS)
    if system is not None:
        channels = dict.fromkeys(name for name in system.channels if name not in STANDING_CHANNELS)
        moving = [name for name in system.state_names if name not in system.switched]
        states |= dict.fromkeys(name for name in moving if name not in system.machine.states)
    imposed = [kind.effort == "displacement" for kind in kinds if kind.imposes_motion]
    source = "drive" if system is None or system.controller is None else "controller"  # of the power
    measures = [
        *TRAVEL,
        *(_winding(state) for state in dict.fromkeys(state for kind in kinds for state in kind.turns)),
        *(measure for i in each_contact for measure in sticking_measures(i)),
        *RESPONSE,
        *(_work(channel) for channel in (*channels, *STANDING_CHANNELS)),
        _cost_of_transport(source),
        *(measure for i in each_contact for measure in friction_measures(i)),
        *_drive_peaks(None if system is None else system.machine.effort, source),
        *(measure for state in states for measure in _extremes(state, units[state])),
        *(STOPS if any(IMPACT in kind.switch_events for kind in kinds) else ()),
        *(measure for displaces in dict.fromkeys(imposed) for measure in _actuation(displaces)),
        *(measure for i in each_contact if _has_reaction(system, i) for measure in reaction_measures(i)),
        *([_HIDDEN_LIFT_OFF] if any(_has_reaction(system, i) for i in each_contact) else ()),
    ]
    return {measure.name: measure for measure in measures}


def further_measure(name: str) -> Measure | None:
    """The measure of a further contact that has this name, with any law and on any machine; None where there is none.

    A study over kinds of parts asks all of them for what one has: it is NaN for the others.
    """
    match = re.search(r"_([1-9][0-9]{0,8})(?:_work)?$", name)
    return None if match is None else _of_further_contact(int(match[1]), tuple(laws().values())).get(name)


@functools.lru_cache(maxsize=64)
def _of_further_contact(number: int, contacts: tuple[type[Law], ...]) -> Mapping[str, Measure]:
    if number < 2:
        return {}
    works = (_work(numbered(channel, number)) for channel in CONTACT_CHANNELS)
    measures = [*sticking_measures(number), *friction_measures(number), *reaction_measures(number), *works]
    for law in contacts:
        for name in (name for name in law.internal if name not in law.switched):
            unit = quantity_unit(name, law.state_units) or "1"
            measures += _extremes(numbered(name, number), unit)
    return {measure.name: measure for measure in measures}


COST = "cost_of_transport"
TRAVEL = (
    Measure("displacement", "travel over the window", Standard(lambda runs: runs.displacement), si_unit="m"),
    Measure("drift", "travel per drive period", Standard(lambda runs: runs.drift), si_unit="m"),
    Measure("mean_velocity", "travel per time", Standard(lambda runs: runs.displacement / runs.time), si_unit="m/s"),
)


@functools.cache
def _winding(state: str) -> Measure:
    def winding(runs: Gathered) -> np.ndarray:
        turned = runs.turned(state)
        return np.where(runs.settled, np.round(turned), turned) / runs.periods

    meaning = f"turns of {state} per drive period, whole ones over the response of a settled motion"
    return Measure(f"winding_{state}", meaning, Standard(winding))


def _symmetric(runs: Gathered) -> np.ndarray:
    if runs.results.layout.returns:
        return runs.nowhere  # half the drive's period says nothing of a cycle
    mirrored = runs.results.entry("ASYMMETRY") <= MIRROR_SHARE * runs.threshold
    return np.where(runs.settled & runs.mirrored(), mirrored, np.nan)


def _period(runs: Gathered) -> np.ndarray:
    if not runs.results.layout.returns:
        return np.where(runs.settled, runs.results.head("response_period") * runs.period, np.nan)
    return np.where(runs.settled, np.where(runs.still, 0.0, runs.cycle_time), np.nan)


OUTCOME = "outcome"  # taken of every study of a system without a clock whose runs are to settle
RESPONSE = (
    Measure(
        "response_period",
        "drive periods after which the settled motion repeats up to a shift, of a cycle with a period of its own "
        "returns to rest; 0: not settled",
        Standard(lambda runs: runs.response_period),
    ),
    Measure(
        "time_to_settle",
        "time after which the motion stays within the threshold of where it goes (NaN: not settled)",
        Standard(lambda runs: np.where(runs.settled, runs.time_to_settle, np.nan), codes.ASK_TRANSIENT),
        si_unit="s",
    ),
    Measure(
        "extrapolated",
        "1: measured from the extrapolated limit of its stroboscopic states, 0: the run came there by itself",
        Standard(lambda runs: runs.results.head("extrapolated")),
    ),
    Measure(
        "period",
        "time after which the settled motion repeats (0: rest or steady sliding; NaN: not settled)",
        Standard(_period),
        si_unit="s",
    ),
    Measure(
        OUTCOME,
        "kind of the final motion: periodic, or not settled; without a drive in time cycle, equilibrium, or "
        "not settled: no returns, or no repetition",
        Standard(lambda runs: runs.outcome, text=True),
    ),
    Measure(
        "symmetric",
        "1: the settled motion is its own mirror image half a period later, 0: it is not (NaN: not settled, or no "
        "drive that is odd and changes in time)",
        Standard(_symmetric, codes.ASK_SYMMETRY),
    ),
)


@functools.cache
def _work(channel: str) -> Measure:
    def work(runs: Gathered) -> np.ndarray:
        names = runs.system.channels
        return runs.results.entry("INTEGRAL", names.index(channel)) / runs.periods if channel in names else runs.nowhere

    meaning = f"work of {channel.replace('_', ' ')} per drive period, positive into the system"
    return Measure(f"{channel}_work", meaning, Standard(work, codes.ASK_INTEGRALS), si_unit="J")


@functools.cache
def _cost_of_transport(source: str) -> Measure:
    """source: the channel whose work it is"""
    work = _work(source).how
    assert isinstance(work, Standard)

    def work_per_distance(runs: Gathered) -> np.ndarray:
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.where(runs.travels, work.value(runs) / np.abs(runs.drift), np.inf)

    meaning = f"work of the {source} per distance travelled (infinite: no travel)"
    return Measure(COST, meaning, Standard(work_per_distance, work.groups), si_unit="J/m")


@functools.cache
def _drive_peaks(effort: str | None, source: str) -> tuple[Measure, ...]:
    """What an actuator has to be able to do; effort: what the drive exerts, see `Units`; None where it is not known.

    source: the channel of its power
    """
    unit = "1" if effort is None else DRIVE_UNITS[effort]
    return (
        Measure.peak("peak_drive", "largest |drive| in the window", lambda now: now.drive, si_unit=unit),
        Measure.peak(
            "peak_drive_rate",
            "largest |rate of the drive| in the window, jumps aside",
            lambda now: now.drive_rate,
            si_unit="1" if effort is None else over_seconds(unit),
        ),
        Measure.peak(
            "peak_drive_power",
            f"largest |power of the {source}| in the window",
            lambda now: getattr(now, f"{source}_power"),
            si_unit="W",
        ),
    )


LOAD_WATCH = "hidden_lift_off"  # taken of every study of a machine whose constant load may hide a lift-off
STOPS = (
    Measure(
        "impacts",
        "impacts on stops per drive period (infinite: they accumulate at a rigid one; NaN: there are no stops)",
        Standard(lambda runs: runs.impacts / runs.periods),
    ),
)


@functools.cache
def _actuation(displaces: bool) -> tuple[Measure, ...]:
    """What an imposed motion takes; impulses, where its velocity jumps, are no part of it."""
    effort, unit = ("force", "N") if displaces else ("torque", "N m")
    name = f"actuator_{effort}"
    how: dict[str, Any] = {"function": lambda now: getattr(now, name), "si_unit": unit}
    return (
        Measure.largest(f"largest_{name}", f"largest {effort} of an imposed motion", **how),
        Measure.least(f"least_{name}", f"least {effort} of an imposed motion", **how),
        Measure.peak(f"peak_{name}", f"largest |{effort}| that an imposed motion takes, impulses aside", **how),
        *ACTUATOR_POWER,
    )


ACTUATOR_POWER = (
    Measure.mean("mean_actuator_power", "mean power of an imposed motion", lambda now: now.actuator_power, "1", "W"),
    Measure.largest(
        "peak_actuator_power", "largest power of an imposed motion", lambda at: at.actuator_power, "1", "W"
    ),
)


def _has_reaction(system: System | None, number: int) -> bool:
    """Whether the normal reaction of the ground at a contact is known; of no system: of machines with one contact."""
    return number == 1 if system is None else numbered("reaction", number) in equations(system).observables


_HIDDEN_LIFT_OFF = Measure(
    LOAD_WATCH,
    "1: under its constant load the machine would have lifted off in the window, 0: it would not (NaN: the load "
    "follows the motion)",
    Standard(lambda runs: runs.results.lifted),
)


@functools.cache
def _extremes(state: str, unit: str) -> tuple[Measure, ...]:
    words, bounds = state.replace("_", " "), (f"largest_{state}", f"least_{state}")

    def extreme(bound: str) -> Measure:
        value = Standard(lambda runs: runs.state_entry(bound.upper(), state), codes.ASK_EXTREMES)
        return Measure(f"{bound}_{state}", f"{bound} {words} in the window, with its sign", value, si_unit=unit)

    def peak(largest: np.ndarray, least: np.ndarray) -> np.ndarray:
        return np.maximum(np.abs(largest), np.abs(least))

    return (
        extreme("largest"),
        extreme("least"),
        Measure.derived(f"peak_{state}", f"largest |{words}| in the window", peak, of=bounds, si_unit=unit),
        Measure.derived(f"{state}_range", f"{words} from peak to peak", np.subtract, of=bounds, si_unit=unit),
    )
