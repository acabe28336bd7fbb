"""Names of the states of a system, in the order of the state vector: of its parts by name, or of their classes."""

from collections.abc import Mapping
from typing import Any

from vibrocap.physics.numbering import numbered

OUTPUT, SATURATED, CLIPPED = "actuator_output", "saturated", "clipped"  # states of an actuator


def laws_of(parts: Mapping[str, Any]) -> tuple[Any, ...]:
    """The law of each contact of a machine: its own where there is one, else that of the first contact."""
    numbers = range(1, 1 + len(parts["machine"].contact_states))
    return tuple(parts.get(numbered("friction", i), parts["friction"]) for i in numbers)


def laws_by_state(parts: Mapping[str, Any]) -> tuple[tuple[int, Any], ...]:
    """(number of the contact, its law), in the order in which their internal states stand: the first contact last."""
    first, *further = enumerate(laws_of(parts), start=1)
    return (*further, first)


def state_names(parts: Mapping[str, Any]) -> tuple[str, ...]:
    """All states: of machine, actuator and controller, of the laws of further contacts, and of that of the first."""
    internal = (numbered(name, i) for i, law in laws_by_state(parts) for name in law.internal)
    return (*parts["machine"].states, *between_states(parts), *internal)


def between_states(parts: Mapping[str, Any]) -> tuple[str, ...]:
    """The states of what stands between drive and machine: of the actuator, then of the controller."""
    return (*actuator_states(parts.get("actuator")), *controller_states(parts.get("controller")))


def controller_states(controller: Any) -> tuple[str, ...]:
    """The states of a controller; of the class all that one may have, of None none."""
    if controller is None:
        return ()
    return controller.all_states if isinstance(controller, type) else controller.states


def actuator_states(actuator: Any) -> tuple[str, ...]:
    """The states of an actuator; of the class all that one may have, of None none."""
    if actuator is None:
        return ()
    return (OUTPUT, SATURATED, CLIPPED) if isinstance(actuator, type) else actuator.states
