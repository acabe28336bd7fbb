"""The contract of a controller, clause by clause: each takes one with its numbers and returns its fault, or None."""

import math
import sys
from typing import Any

from vibrocap.contracts.samples import draws
from vibrocap.physics.catalogue import machines
from vibrocap.physics.controllers.controller import CURVATURE, SIDE

EPSILON = sys.float_info.epsilon
SAMPLES = 20
KINDS = ("displacement", "speed", "angle")  # of references
TRIED = ("oscillator", "two-mass-capsule", "pendulum-capsule")  # on the first that has what it measures


def machine_for(controller: Any) -> Any:
    """A machine of the package that has what a controller measures."""
    tried = [machines()[kind]() for kind in TRIED]
    return next((machine for machine in tried if not _unknown(controller, machine)), tried[0])


def _unknown(controller: Any, machine: Any) -> list[str]:
    names = [name for name in controller.measures(machine) if name.removesuffix("_rate") not in (SIDE, CURVATURE)]
    unknown_states = [name for name in names if name.removesuffix("_rate") not in machine.states]
    if controller.orders == "acceleration":  # not of a body that rubs, where rest would be cancelled
        told, rub = controller.accelerated(machine), machine.contact_states
        unknown_states += [told] if told not in machine.states or told in rub else []
    return unknown_states


def declarations(controller: Any) -> str | None:
    """Its states, its branches and what it measures are declared."""
    if controller.reference not in KINDS:
        return f"reference: should be one of {', '.join(KINDS)}, got {controller.reference!r}"
    states, switched = controller.states, controller.switched
    if not isinstance(states, tuple) or len({*states}) != len(states):
        return f"states: should be a tuple of names, each once, got {states!r}"
    if missing := [name for name in states if name not in (controller.all_states or states)]:
        return f"all_states: should have every state that one of the class may have; {missing[0]!r} is missing"
    if missing := [name for name in switched if name not in states]:
        return f"switched: should be named by states, got {missing[0]!r}"
    if missing := [name for name in controller.effort_states if name not in (controller.all_states or states)]:
        return f"effort_states: should be named by states, got {missing[0]!r}"
    machine = machine_for(controller)
    names = controller.measures(machine)
    unknown = _unknown(controller, machine)
    if unknown or not names:
        what = f"got {unknown[0]!r}" if unknown else "got none"
        return f"measures: should name states of the machine or their rates, {', '.join(machine.states)}, {what}"
    return None


def finite(controller: Any) -> str | None:
    """It gives a finite command, and a rate, a scale and what follows a switch for each of its states."""
    count, scales = len(controller.states), controller.scales(1.0)
    if len(scales) != count or not all(scale > 0.0 for scale in scales):
        return f"scales: should be {count} positive numbers, got {scales}"
    for arguments in _samples(controller):
        command, rates = controller.command(*arguments), controller.rates(*arguments)
        accelerates = controller.orders == "acceleration"
        guards = controller.effort_switches(0.7, *arguments) if accelerates else controller.switches(*arguments)
        if controller.sampled:
            values = controller.after_sample(*arguments), controller.after_action(arguments[2])
            if wrong := [value for value in values if len(value) != count - 1]:
                return f"after_sample, after_action: should be all {count} states but the last, got {len(wrong[0])}"
            guards = (1.0,)  # which every sampled one has
        if len(rates) != count:
            return f"rates: should be {count} numbers, one for each of states, got {len(rates)}"
        if len(guards) != len(controller.switch_events):
            return f"switch_events: should name the event at each of {len(guards)} guards of switches"
        if not all(map(math.isfinite, (command, *rates, *guards))):
            return f"command, rates, switches: should be finite, got {command}, {rates}, {guards}"
        for name, rate in zip(controller.states, rates, strict=True):
            if name in controller.switched and rate != 0.0:
                return f"rates: that of {name}, which says what branch holds, should be 0.0, got {rate:g}"
        for which in range(0 if controller.sampled else len(guards)):
            if len(after := controller.after_switch(which, *arguments)) != count:
                return f"after_switch: should be all {count} states, got {len(after)}"
    return None


def odd(controller: Any) -> str | None:
    """Its command changes its sign with all that it is given exactly where `odd` says so."""
    for t, measured, own, reference, slope in _samples(controller):
        there = controller.command(t, measured, own, reference, slope)
        turned = tuple(-number for number in measured), tuple(-number for number in own), -reference, -slope
        back = controller.command(t, *turned)
        if controller.odd and not abs(there + back) <= 64 * EPSILON * (1.0 + abs(there)):
            return f"odd: is True, but the command is {there:g}, and {back:g} with all signs changed"
    return None


def _samples(controller: Any) -> list[tuple]:
    """(time, measured, own states, reference, slope) at random, in every branch."""
    names, samples = controller.measures(machine_for(controller)), []
    for draw in draws(SAMPLES, "controllers"):
        own = tuple(
            draw.choice((-1.0, 0.0, 1.0)) if name in controller.switched else draw.uniform(-1.2, 1.2)
            for name in controller.states
        )
        measured = tuple(draw.uniform(-1.2, 1.2) for _ in names)
        slope = draw.uniform(-1.0, 1.0) if controller.uses_slope else 0.0
        samples.append((draw.uniform(0.0, 9.0), measured, own, draw.uniform(-1.0, 1.0), slope))
    return samples


CONTROLLER_CLAUSES = (declarations, finite, odd)
