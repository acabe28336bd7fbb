"""Names of the states of a system, in the order of the state vector: of its parts, or of their classes."""

from typing import Any


def further_laws(machine: Any, law: Any, *others: Any) -> tuple[Any, ...]:
    """The law of each further contact of a machine; others: by contact, None where it is that of the first."""
    given = (*others, *(None,) * len(machine.contacts))[: len(machine.contacts)]
    return tuple(law if each is None else each for each in given)


def contact_states(number: int, law: Any) -> tuple[str, ...]:
    """The states of a further contact: to which side it slides, then those of its law."""
    own = () if law.kind == "smooth" else (f"side_{number}",)
    return (*own, *(f"{name}_{number}" for name in law.internal))


def state_names(machine: Any, law: Any, *others: Any) -> tuple[str, ...]:
    """All states: of the machine, of its further contacts, and of the law of its first contact."""
    laws = enumerate(further_laws(machine, law, *others), start=2)
    return (*machine.states, *(name for i, each in laws for name in contact_states(i, each)), *law.internal)
