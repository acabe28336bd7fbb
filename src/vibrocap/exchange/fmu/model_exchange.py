"""Model exchange: a case as rates with the side of its contact as a discrete state, and guards as event indicators.

The importer integrates and locates the events, so that the error is the importer's.
"""

from vibrocap.arguments import ArgumentError
from vibrocap.exchange.fmu import variables as of
from vibrocap.exchange.fmu.description import Package
from vibrocap.exchange.fmu.package import header
from vibrocap.exchange.fmu.variables import Variable
from vibrocap.exchange.stepped_case import Port, SteppedCase
from vibrocap.motion.equations import Equations, parameter_values
from vibrocap.numerics.api import codes, exported_instant
from vibrocap.physics.machines.machine import Imposed

MEANING = (
    "Rates of a vibro-driven capsule, and event indicators at which its contact comes to rest, gives way or turns. "
    "The error is that of the importer's integrator: a fixed step without event location is wrong at every event."
)
COUNTED = ("stick", "slip_forward", "slip_back", "reversal")


def check_exchanged(stepped: SteppedCase) -> None:
    """Raise ArgumentError for a case whose equations an importer cannot integrate between such events."""
    system, recorded = stepped.system, stepped.equations
    machine, law = system.machine.name, system.friction.name
    stay = [recorded.graph.node("state", i).index for i in range(len(recorded.rates))]
    turn = [each.index for each in recorded.contacts[0].after_reversal]
    jumps = recorded.corners is not None and isinstance(system.machine, Imposed)
    for refused, said in (
        (recorded.several, f"takes one contact, the {machine} has several"),
        (not recorded.contacts[0].sticks, f"takes set-valued laws of friction, {law} is none"),
        (turn != stay, f"takes no states that a reversal changes, as those of {law}"),
        (jumps, f"takes no velocities that jump with the drive, as those of the {machine}"),
    ):
        if refused:
            raise ArgumentError("kind", f"model exchange {said}; export it for co-simulation")


def model_exchange(stepped: SteppedCase, name: str) -> Package:
    """What an FMU of a case for model exchange is made of; see `check_exchanged`."""
    check_exchanged(stepped)
    recorded = stepped.equations
    instant = exported_instant(recorded, name, own_drive=not stepped.inputs)
    places, kinds = instant.places, [codes.BEYOND_BOUND + kind for kind in recorded.bound_kinds]
    indicators = _indicators(len(kinds), len(recorded.switches))
    states, sides = of.states(stepped), of.sides(1)
    switch, *own = stepped.event_kinds[stepped.contact_kinds :]  # of the laws, of the machine
    switches = [switch] * recorded.law_switches + own[: len(recorded.switches) - recorded.law_switches]
    counted = list(dict.fromkeys((*COUNTED, *switches)))
    counts = [str(len(sides) + counted.index(each)) for each in switches]
    before = [of.time(stepped), *of.parameters(stepped, [each.place for each in stepped.parameters])]
    variables = (
        *before,
        *states,
        *of.rates(stepped),
        *of.inputs(stepped, segments=False),
        *of.observables(stepped),
        *indicators,
        *sides,
        *of.counts(counted, len(sides)),
        of.STATUS,
    )
    values = [0.0] * (instant.size + len(indicators))
    for i, value in enumerate(parameter_values(stepped.system)):
        values[places["PARAMETER"] + i] = value
    for i, each in enumerate(stepped.states):
        values[places["STATE"] + i] = each.value
    constants = {
        **places,
        **_of_drive(recorded, places["PARAMETER"], instant.sizes["TABLE"]),
        "INDICATOR": instant.size,
        "VALUES": len(values),
        "COUNTS": len(sides) + len(counted),
        "STATES": len(states),
        "BOUNDS": len(kinds),
        "SWITCHES": len(switches),
        "CONTACT": recorded.contacts[0].state,
        "STATE_VARIABLE": len(before),
        "RATE_VARIABLE": len(before) + len(states),
        "MODEL_EXCHANGE": 1,
    }
    own = [
        "typedef struct { double instant; int switches; } own_state;",
        f"void {name}_drive(double *values);",
        f"void {name}_equations(double *values);",
        f"void {name}_after(double *values, int guard);",
        f"#define DRIVE {name}_drive",
        f"#define AFTER {name}_after",
        f"static const int count_of_switch[] = {{{', '.join(counts) or '0'}}};",
        f"#define EQUATIONS {name}_equations",
        '#define TOLERANCES "greater than 0"',
        '#define STARTS "a finite number"',
        '#define KIND_OF_FMU "model exchange"',
        f"static const int bound_status[] = {{{', '.join(map(str, kinds)) or '0'}}};",
    ]
    return Package(
        name=name,
        kind="ModelExchange",
        meaning=MEANING,
        variables=variables,
        indicators=tuple(each.name for each in indicators),
        case=stepped.case,
        sources={f"{name}.c": instant.text},
        header=header(variables, constants, values, stepped, own),
    )


def _of_drive(recorded: Equations, parameters: int, table: int) -> dict[str, int]:
    """Where the numbers of the present segment stand, and an input; how many segments follow one another."""
    if recorded.corners is None:
        return {"SEGMENT": 0, "HELD": 0, "COEFFICIENTS": 0, "SEGMENTS": 0}
    segment, row = parameters + recorded.corners.place, recorded.corners.row_size
    return {"SEGMENT": segment, "HELD": segment + 2, "COEFFICIENTS": row - 1, "SEGMENTS": table // row}


def _indicators(bounds: int, switches: int) -> list[Variable]:
    meanings = [
        "positive while the contact slides to its side, or the holding force is below its upper limit",
        "positive while the holding force is above its lower limit",
        *(f"positive while the equations hold ({i + 1})" for i in range(bounds)),
        *(f"positive within the present branch of the equations ({i + 1})" for i in range(switches)),
    ]
    return [
        Variable(Port(f"guard_{i + 1}"), meaning, f"INDICATOR + {i}", causality="local")
        for i, meaning in enumerate(meanings)
    ]
