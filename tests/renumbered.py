"""Any machine with its contacts numbered the other way: what belongs to the first belongs to the last."""

import dataclasses
import functools

from vibrocap.physics.machines.machine import Machine, parameters

FRICTIONS = ("rates", "powers", "actuator", "switches", "after_switch", "wall_force")


@functools.cache
def _class(kind: type[Machine]) -> type[Machine]:
    def turned(name):
        return lambda self, *rest: getattr(kind, name)(self, *rest[:-1], tuple(rest[-1])[::-1])

    def contacts(self, t, y, drive):
        found = []
        for each in kind.contacts(self, t, y, drive)[::-1]:
            reaction = None if each.reaction is None else (*each.reaction[:2], *each.reaction[2:][::-1])
            found.append(dataclasses.replace(each, response=each.response[::-1], reaction=reaction))
        return tuple(found)

    own = {name: turned(name) for name in FRICTIONS} | {
        "contacts": contacts,
        "contact_states": kind.contact_states[::-1],
        "loads": lambda self: kind.loads(self)[::-1],
        "masses": lambda self: dict(reversed(kind.masses(self).items())),
        "name": f"renumbered-{kind.name}",
        "__doc__": kind.__doc__,
        "__module__": __name__,
    }
    return parameters(type(f"Renumbered{kind.__name__}", (kind,), own))


def renumbered(machine: Machine) -> Machine:
    """The same machine, whose contacts stand in the reverse order."""
    values = {field.name: getattr(machine, field.name) for field in dataclasses.fields(machine)}
    return _class(type(machine))(**values)
