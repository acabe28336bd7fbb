"""Names of the states of a system, in the order of the state vector: of its parts by name, or of their classes."""

from collections.abc import Mapping
from typing import Any

from vibrocap.physics.numbering import numbered

OUTPUT, SATURATED, CLIPPED = "actuator_output", "saturated", "clipped"  # states of an actuator


def further_laws(parts: Mapping[str, Any]) -> tuple[Any, ...]:
    """The law of each further contact of a machine: its own where there is one, else that of the first contact."""
    numbers = range(2, 2 + len(parts["machine"].contacts))
    return tuple(parts.get(numbered("friction", i), parts["friction"]) for i in numbers)


def turns(law: Any, surrounded: bool) -> bool:
    """Whether what acts on a further contact has a kink at rest: that of its law, or of the drag of an environment."""
    return law.kind != "smooth" or surrounded


def contact_states(number: int, law: Any, surrounded: bool = False) -> tuple[str, ...]:
    """The states of a further contact: to which side it slides, then those of its law."""
    own = ("side",) if turns(law, surrounded) else ()
    return tuple(numbered(name, number) for name in (*own, *law.internal))


def state_names(parts: Mapping[str, Any]) -> tuple[str, ...]:
    """All states: of the machine, of its further contacts, and of the law of its first contact."""
    machine, laws = parts["machine"], enumerate(further_laws(parts), start=2)
    surrounded = parts.get("environment") is not None
    further = (name for i, law in laws for name in contact_states(i, law, surrounded))
    return (*machine.states, *further, *actuator_states(parts.get("actuator")), *parts["friction"].internal)


def actuator_states(actuator: Any) -> tuple[str, ...]:
    """The states of an actuator; of the class all that one may have, of None none."""
    if actuator is None:
        return ()
    return (OUTPUT, SATURATED, CLIPPED) if isinstance(actuator, type) else actuator.states
