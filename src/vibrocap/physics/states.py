"""Names of the states of a system, in the order of the state vector: of its parts by name, or of their classes."""

from collections.abc import Mapping
from typing import Any

MOST_CONTACTS = 10
FURTHER = tuple(f"friction_{number}" for number in range(2, MOST_CONTACTS + 1))  # parts: laws of further contacts


OUTPUT, SATURATED, CLIPPED = "actuator_output", "saturated", "clipped"  # states of an actuator


def further_laws(parts: Mapping[str, Any]) -> tuple[Any, ...]:
    """The law of each further contact of a machine: its own where there is one, else that of the first contact."""
    own = FURTHER[: len(parts["machine"].contacts)]
    return tuple(parts.get(name, parts["friction"]) for name in own)


def state_names(parts: Mapping[str, Any]) -> tuple[str, ...]:
    """All states: of the machine and its actuator, of the laws of its further contacts, and of that of the first."""
    further = (f"{name}_{i}" for i, law in enumerate(further_laws(parts), start=2) for name in law.internal)
    machine = (*parts["machine"].states, *actuator_states(parts.get("actuator")))
    return (*machine, *further, *parts["friction"].internal)


def actuator_states(actuator: Any) -> tuple[str, ...]:
    """The states of an actuator; of the class all that one may have, of None none."""
    if actuator is None:
        return ()
    return (OUTPUT, SATURATED, CLIPPED) if isinstance(actuator, type) else actuator.states
