"""Model exchange: a case as rates with the side of its contact as a discrete state, and guards as event indicators.

The importer integrates and locates the events, so that the error is the importer's.
"""

from vibrocap.exchange.fmu import variables as of
from vibrocap.exchange.fmu.description import Package
from vibrocap.exchange.fmu.package import header
from vibrocap.exchange.fmu.variables import Variable
from vibrocap.exchange.rates import Rates
from vibrocap.exchange.stepped_case import Port, SteppedCase

MEANING = (
    "Rates of a vibro-driven capsule, and event indicators at which its contact comes to rest, gives way or turns. "
    "The error is that of the importer's integrator: a fixed step without event location is wrong at every event."
)


def model_exchange(stepped: SteppedCase, name: str) -> Package:
    """What an FMU of a case for model exchange is made of. Raises ArgumentError for what `Rates` refuses."""
    rates = Rates(stepped, name, "kind", "export it for co-simulation")
    indicators = _indicators(len(rates.bounds), len(rates.switches))
    states, sides = of.states(stepped), of.sides(1)
    before = [of.time(stepped), *of.parameters(stepped, [each.place for each in stepped.parameters])]
    variables = (
        *before,
        *states,
        *of.rates(stepped),
        *of.inputs(stepped, "continuous"),
        *of.observables(stepped),
        *indicators,
        *sides,
        *of.counts(rates.counted, len(sides)),
        of.STATUS,
    )
    constants = rates.constants | {
        "STATE_VARIABLE": len(before),
        "RATE_VARIABLE": len(before) + len(states),
        "MODEL_EXCHANGE": 1,
    }
    own = [
        *rates.lines,
        "typedef struct { double instant; int switches; } own_state;",
        '#define TOLERANCES "greater than 0"',
        '#define STARTS "a finite number"',
        '#define KIND_OF_FMU "model exchange"',
    ]
    return Package(
        name=name,
        kind="ModelExchange",
        meaning=MEANING,
        variables=variables,
        indicators=tuple(each.name for each in indicators),
        case=stepped.case,
        sources={f"{name}.c": rates.instant.text},
        header=header(variables, constants, rates.values, stepped, own),
    )


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
