"""Any machine with its contacts numbered the other way: what belongs to the first belongs to the last."""

import dataclasses
import functools

from vibrocap.mechanics import Contact, Machine, parameters


@functools.cache
def _class(kind: type[Machine]) -> type[Machine]:
    def parts(self, q):
        found = []
        for each in kind.parts(self, q):
            found += each if isinstance(each, (list, tuple)) else [each]
        rubbing = [each for each in found if isinstance(each, Contact)]
        return [*(each for each in found if not isinstance(each, Contact)), *reversed(rubbing)]

    own = {
        "parts": parts,
        "name": f"renumbered-{kind.name}",
        "__doc__": kind.__doc__,
        "__module__": __name__,
    }
    return parameters(type(f"Renumbered{kind.__name__}", (kind,), own))


def renumbered(machine: Machine) -> Machine:
    """The same machine, whose contacts stand in the reverse order."""
    values = {field.name: getattr(machine, field.name) for field in dataclasses.fields(machine)}
    return _class(type(machine))(**values)
