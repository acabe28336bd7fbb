"""What a controller measures of a machine, and what it asks of its reference: whether there is such a thing."""

from collections.abc import Mapping
from typing import Any

from vibrocap.arguments import ArgumentError, listed, suggestion
from vibrocap.physics.drives.drive import Drive
from vibrocap.physics.machines.machine import Imposed
from vibrocap.physics.units import DRIVE_UNITS, state_units


def check_controller(parts: Mapping[str, Any], placed: Any) -> None:
    """ArgumentError for a controller that does not fit the other parts of a system.

    placed: its machine as the controller moves it
    """
    machine, controller, drive = parts["machine"], parts["controller"], parts["drive"]
    if isinstance(machine, Imposed):
        what = f"imposes a motion on the {machine.name}, whatever force that takes"
        raise ArgumentError("controller", f"should be left out: the drive {what}")
    if controller.uses_slope and type(drive).slope is Drive.slope:
        what = f"does not say its slope, which the {controller.name} asks for"
        raise ArgumentError("drive", f"the waveform {drive.name} {what}")
    if "controller" in machine.channels:
        raise ArgumentError("controller", "is a channel of energy of the machine itself; give that another name")
    actuator = parts.get("actuator")
    taken = {*machine.states, *(() if actuator is None else actuator.states)}
    if shared := taken.intersection(controller.states):
        raise ArgumentError("controller", f"has the state {min(shared)}, as the {machine.name} has")
    _check_measured(parts, placed.machine)


def _check_measured(parts: Mapping[str, Any], behind: Any) -> None:
    """ArgumentError for what cannot be measured. behind: what the controller moves, the machine or its actuator"""
    machine, controller = parts["machine"], parts["controller"]
    wanted = "rad" if controller.reference == "number" else DRIVE_UNITS[controller.reference]
    units = state_units({**parts, "controller": None})
    own = [name for name in machine.states if name not in machine.switched]
    names = controller.measures(behind)
    for name in names:
        state = name.removesuffix("_rate")
        if name not in own and state not in own:
            useful = [each for each in own if units[each] in (wanted, "1")]
            what = f"the {machine.name} has no state {state!r} to be measured"
            raise ArgumentError("controller.measured", f"{what}; {suggestion(state, useful, cutoff=0.0)}")
    if getattr(controller, "measured", None) is not None and units[names[0]] not in (wanted, "1"):
        useful = [each for each in own if units[each] == wanted]
        what = f"should be a state in {wanted} with a {controller.name}, got {names[0]!r} in {units[names[0]]}"
        raise ArgumentError("controller.measured", f"{what}; there is {listed(useful, ' or ')}" if useful else what)
    still, at = (0.0,) * len(machine.contact_states), (0.0, (0.3,) * len(behind.states))
    low, high = (behind.rates(*at, u, still) for u in (0.0, 1.0))
    for name in (name for name in names if name not in own):
        place = behind.states.index(name.removesuffix("_rate"))
        if low[place] != high[place]:
            what = f"should not be a state whose rate the command decides, got {name.removesuffix('_rate')!r}"
            raise ArgumentError("controller.measured", f"{what}; leave out derivative_gain, or measure a place")
