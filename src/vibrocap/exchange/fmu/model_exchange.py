"""Model exchange: a case as rates with the side of its contact as a discrete state, and guards as event indicators.

The importer integrates and locates the events, so that the error is the importer's.
"""

from vibrocap.arguments import ArgumentError
from vibrocap.case.case import Case
from vibrocap.exchange.fmu import variables as of
from vibrocap.exchange.fmu.package import Package, header
from vibrocap.exchange.fmu.variables import InUnits, Variable
from vibrocap.motion.equations import Equations, equations, parameter_values
from vibrocap.motion.simulate import STATUSES
from vibrocap.motion.start import initial_state
from vibrocap.numerics.api import codes, exported_instant

MEANING = (
    "Rates of a vibro-driven capsule, and event indicators at which its contact comes to rest, gives way or turns. "
    "The error is that of the importer's integrator: a fixed step without event location is wrong at every event."
)
COUNTS = {
    "rests": "times at which the contact came to rest",
    "departures": "times at which it gave way",
    "reversals": "times at which it turned without a rest",
}


def check_exchanged(case: Case, recorded: Equations) -> None:
    """Raise ArgumentError for a case whose equations an importer cannot integrate between such events."""
    system = case.system
    instead = "export it for co-simulation"
    if recorded.several:
        raise ArgumentError("kind", f"model exchange takes one contact, the {system.machine.name} has several; {instead}")
    if not recorded.contacts[0].sticks:
        law = system.friction.name
        raise ArgumentError("kind", f"model exchange takes set-valued laws of friction, {law} is none; {instead}")
    if recorded.switches:
        part = system.friction.name if recorded.law_switches else system.machine.name
        raise ArgumentError("kind", f"model exchange takes no branches of equations, {part} has some; {instead}")
    if recorded.corners is not None:
        drive = system.drive.name
        raise ArgumentError("kind", f"model exchange takes no drives with corners, {drive} has some; {instead}")


def model_exchange(case: Case, name: str) -> Package:
    """What an FMU of a case for model exchange is made of; see `check_exchanged`."""
    system, recorded = case.system, equations(case.system)
    check_exchanged(case, recorded)
    initial = [*initial_state(system, case.initial).values()]
    instant = exported_instant(recorded, name)
    places = instant.places
    states, rates = of.states(case, initial), of.rates(case)
    indicators = _indicators(len(recorded.bounds))
    before = [of.time(case), *of.parameters(case, recorded)]
    variables = (
        *before,
        *states,
        *rates,
        *of.observables(case, instant.observed),
        *indicators,
        of.whole("side", "+1, -1: the contact slides forward, back; 0: it rests", 0, "Side"),
        *(of.whole(each, meaning, i) for i, (each, meaning) in enumerate(COUNTS.items(), start=1)),
        of.STATUS,
    )
    values = dict.fromkeys(range(instant.size + len(indicators)), 0.0)
    for i, value in enumerate(parameter_values(system)):
        values[places["PARAMETER"] + i] = value
    for i, value in enumerate(initial):
        values[places["STATE"] + i] = value
    kinds = [codes.BEYOND_BOUND + kind for kind in recorded.bound_kinds]
    statuses = {codes.RUNNING: "running", **{kind: STATUSES[kind].value for kind in kinds}}
    constants = {
        **places,
        "INDICATOR": instant.size,
        "VALUES": len(values),
        "COUNTS": 1 + len(COUNTS),
        "STATES": len(states),
        "BOUNDS": len(kinds),
        "CONTACT": recorded.contacts[0].state,
        "STATE_VARIABLE": len(before),
        "RATE_VARIABLE": len(before) + len(states),
        "MODEL_EXCHANGE": 1,
    }
    factor = InUnits.of(case).of_quantity("time").get("factor", 1.0)
    own = [
        "typedef struct { char none; } own_state;",
        f"void {name}_instant(double *restrict, int64_t *restrict, double *restrict, int64_t);",
        f"#define EQUATIONS {name}_instant",
        '#define TOLERANCES "greater than 0"',
        '#define STARTS "a finite number"',
        '#define KIND_OF_FMU "model exchange"',
        f"static const int bound_status[] = {{{', '.join(map(str, kinds)) or '0'}}};",
    ]
    return Package(
        name=name,
        kind="ModelExchange",
        meaning=MEANING,
        able={"canGetAndSetFMUState": "true", "canSerializeFMUState": "true"},
        variables=variables,
        indicators=tuple(each.name for each in indicators),
        experiment={
            "startTime": 0.0,
            "stopTime": case.periods * system.drive.period * factor,
            "tolerance": case.tolerance,
        },
        sources={f"{name}.c": instant.text},
        header=header(variables, constants, values, statuses, factor, own),
    )


def _indicators(bounds: int) -> list[Variable]:
    meanings = [
        "positive while the contact slides to its side, or the holding force is below its upper limit",
        "positive while the holding force is above its lower limit",
        *(f"positive while the equations hold ({i + 1})" for i in range(bounds)),
    ]
    return [
        Variable(f"guard_{i + 1}", meaning, f"INDICATOR + {i}", causality="local") for i, meaning in enumerate(meanings)
    ]
