"""Any machine with its contacts numbered the other way: what belongs to the first belongs to the last."""

import dataclasses
import functools

from vibrocap.mechanics import Contact, Machine, parameters
from vibrocap.physics.names import name_and_number, numbered
from vibrocap.physics.system import System


@functools.cache
def _class(kind: type[Machine]) -> type[Machine]:
    def parts(self, q):
        results = []
        for part in kind.parts(self, q):
            results += part if isinstance(part, (list, tuple)) else [part]
        rubbing = [part for part in results if isinstance(part, Contact)]
        return [*(part for part in results if not isinstance(part, Contact)), *reversed(rubbing)]

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


# Measures of contact 1 whose names have no number, and what else a motion tells of it.
OF_CONTACT = (
    *("stick_fraction", "stick_phases", "mode_sequence", "peak_friction", "mean_friction", "velocity_loop_area"),
    *("displacement_loop_area", "mean_reaction", "least_reaction", "largest_reaction"),
    *("contact_sliding_work", "bristle_loss_work", "contact_storage_work"),
    *("friction", "side", "reaction", "impulse", "holding_force", "holding_limit", "holding_centre"),
    "contact_velocity",
)


def counterpart(name: str, system: System) -> str:
    """What a measure, or a quantity of a motion, is called once its contacts are numbered the other way."""
    if any(state in name for state in system.machine.states if not name.startswith(OF_CONTACT)):
        return name  # of a coordinate
    tail = next((key for key in ("_work", "_range") if name.endswith(key)), "")
    stem, number = name_and_number(name.removesuffix(tail))
    internal = [f"_{state}" for law in system.laws for state in law.internal]
    if number == 1 and stem + tail not in OF_CONTACT and not any(each in f"_{stem}" for each in internal):
        return name
    return numbered(stem, 1 + len(system.laws) - number) + tail
