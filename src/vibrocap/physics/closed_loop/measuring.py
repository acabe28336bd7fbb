"""What a controller measures of a machine, and what it asks of its reference: whether there is such a thing."""

from collections.abc import Mapping
from typing import Any

from vibrocap.arguments import ArgumentError, listed, suggestion
from vibrocap.physics.controllers.controller import CURVATURE, SIDE
from vibrocap.physics.dimensions.units import DRIVE_UNITS, state_units
from vibrocap.physics.drives.drive import Drive
from vibrocap.physics.names import laws_of

SAMPLE = 0.3  # every state, where it is tried what a command does
CANCELLED = 1e-12  # response of a contact to its own friction, below which that is gone


def check_controller(parts: Mapping[str, Any], placed: Any) -> None:
    """ArgumentError for a controller that does not fit the other parts of a system.

    placed: its machine as the controller moves it
    """
    machine, controller, drive = parts["machine"], parts["controller"], parts["drive"]
    if machine.imposes_motion:
        what = f"imposes a motion on the {machine.name}, whatever force that takes"
        raise ArgumentError("controller", f"should be left out: the drive {what}")
    bends = CURVATURE in controller.measures(placed.machine)
    for asked, name in ((controller.uses_slope, "slope"), (bends, "curvature")):
        if asked and getattr(type(drive), name) is getattr(Drive, name):
            what = f"does not say its {name}, which the {controller.name} asks for"
            raise ArgumentError("drive", f"the waveform {drive.name} {what}")
    if "controller" in machine.channels:
        raise ArgumentError("controller", "is a channel of energy of the machine itself; give that another name")
    actuator = parts.get("actuator")
    taken = {*machine.states, *(() if actuator is None else actuator.states)}
    if shared := taken.intersection(controller.states):
        raise ArgumentError("controller", f"has the state {min(shared)}, as the {machine.name} has")
    _check_measured(parts, placed.machine)
    if controller.orders == "acceleration":
        _check_accelerated(parts, placed)


def _check_measured(parts: Mapping[str, Any], behind: Any) -> None:
    """ArgumentError for what cannot be measured. behind: what the controller moves, the machine or its actuator"""
    machine, controller = parts["machine"], parts["controller"]
    wanted = DRIVE_UNITS[controller.reference]
    units = state_units({**parts, "controller": None})
    own = [name for name in machine.states if name not in machine.switched]
    names = [name for name in controller.measures(behind) if name not in (SIDE, CURVATURE)]
    for name in names:
        state = name.removesuffix("_rate")
        if name not in own and state not in own:
            useful = [own_state for own_state in own if units[own_state] in (wanted, "1")]
            what = f"the {machine.name} has no state {state!r} to be measured"
            raise ArgumentError("controller.measured", f"{what}; {suggestion(state, useful, cutoff=0.0)}")
    if getattr(controller, "measured", None) is not None and units[names[0]] not in (wanted, "1"):
        useful = [name for name in own if units[name] == wanted]
        what = f"should be a state in {wanted} with {_named(controller)}, got {names[0]!r} in {units[names[0]]}"
        raise ArgumentError("controller.measured", f"{what}; there is {listed(useful, ' or ')}" if useful else what)
    still, at = (0.0,) * len(machine.contact_states), (0.0, (SAMPLE,) * len(behind.states))
    low, high = (behind.rates(*at, u, still) for u in (0.0, 1.0))
    contact = behind.states.index(machine.contact_states[0])
    if SIDE in controller.measures(behind) and (machine.effort != "force" or not low[contact] < high[contact]):
        what = f"{_named(controller)}, which compensates the friction there; got the {machine.name}"
        raise ArgumentError("machine", f"should be one whose first contact is pushed by the command, with {what}")
    for name in (name for name in names if name not in own):
        place = behind.states.index(name.removesuffix("_rate"))
        if low[place] != high[place]:
            what = f"should not be a state whose rate the command decides, got {name.removesuffix('_rate')!r}"
            raise ArgumentError("controller.measured", f"{what}; leave out derivative_gain, or measure a place")


def _check_accelerated(parts: Mapping[str, Any], placed: Any) -> None:
    """ArgumentError for a controller that orders an acceleration which the command cannot give by itself."""
    machine, controller, behind = parts["machine"], parts["controller"], placed.machine
    if parts.get("actuator") is not None:
        what = f"with {_named(controller)}, whose command has to act on the acceleration at once"
        raise ArgumentError("actuator", f"should be left out {what}")
    state = controller.accelerated(behind)
    if state not in machine.states:
        what = f"the {machine.name} has no state {state!r} that the command accelerates"
        raise ArgumentError("controller.measured", f"should have a rate that is a state: {what}")
    if any({state, state.removesuffix("_rate")} & {*names} for names in machine.locked.values()):
        what = f"a stop of the {machine.name} holds it against any command"
        raise ArgumentError("controller.measured", f"should not be {state.removesuffix('_rate')!r}: {what}")
    y = (SAMPLE,) * len(behind.states)
    try:
        by_effort = behind.evaluated("effects", 0.0, y)[0][machine.states.index(state)][1]
    except TypeError as error:
        what = f"by {_named(controller)} should have rates that are affine in drive and friction forces: {error}"
        raise ArgumentError("machine", f"told its motion {what}") from None
    if by_effort == 0.0:
        raise ArgumentError("controller.measured", f"the command does not accelerate {state.removesuffix('_rate')!r}")
    contacts = placed.contacts(0.0, (*y, *(0.0 for _ in controller.states)), 0.0)
    rests = (law.kind == "set-valued" for law in laws_of(parts))
    own = [abs(contact.response[i]) for i, contact in enumerate(contacts)]
    if any(rest and response <= CANCELLED for rest, response in zip(rests, own, strict=True)):
        what = "the command would cancel the friction on its own body, at rest as well"
        raise ArgumentError("controller.measured", f"should not be the place of a body that comes to rest: {what}")


def _named(controller: Any) -> str:
    return f"{'an' if controller.name[0] in 'aeiou' else 'a'} {controller.name}"
