"""Limits of the friction of a case: exact, as the paper prints them (its equations 10 to 15), and as tables."""

from typing import Any

from rich.table import Table

from vibrocap.arguments import ArgumentError
from vibrocap.cli.terminal import Page, said, table
from vibrocap.physics.names import numbered
from vibrocap.physics.parameters import given_parameters
from vibrocap.physics.system import System
from vibrocap.quantities.dimensional import in_si, view

BOUNDARY = "v*: below it friction is larger while accelerating, above it while decelerating (erratum 7)"


def limits_of(system: System) -> tuple[dict[str, Any], dict[str, Any], list[str]]:
    """The limits of friction at each contact by name, in SI where the system is; their record; notes.

    The record of one contact is that of its limits, of several it has one by name.
    """
    from vibrocap.measures.recorded.limits import frictional_limits

    limits: dict[str, Any] = {}
    for i, (law, load) in enumerate(zip(system.laws, system.placed.loads(), strict=True), 1):
        name = numbered("friction", i)
        try:
            limits[name] = in_si(frictional_limits(law, float(load)), system)
        except (TypeError, ValueError) as error:
            raise ArgumentError(name, str(error)) from None
    notes = beyond_friction(system, [limits.breakaway_force for limits in limits.values()])
    record = {name: view(limits) for name, limits in limits.items()}
    return limits, (record if len(record) > 1 else record["friction"]) | ({"notes": notes} if notes else {}), notes


def beyond_friction(system: System, breakaways: list[float]) -> list[str]:
    """What the limits of friction alone leave out: loads that follow the motion, and what acts from outside.

    breakaways: the force at which each contact breaks away, in the units of the results
    """
    notes = []
    if system.machine.follows_load:
        notes.append("The load follows the motion; these are the limits at its mean.")
    if (environment := system.environment) is None:
        return notes
    at_rest = environment.push_at_rest(system.placed)
    push, unit = at_rest * system.result_units.factor("friction"), system.result_units.unit("friction")
    if push and len(breakaways) == 1:
        (breakaway,) = breakaways
        words = (
            f"Slope and outer force push with {said(push, unit)} at rest, positive forward, which friction holds too: "
        )
        if abs(push) > breakaway:
            words += f"more than it can, so the contact slides {'forward' if push > 0.0 else 'back'} by itself."
        else:
            ways = said(breakaway - push, unit), said(breakaway + push, unit)
            words += f"the machine itself breaks away with {ways[0]} forward and {ways[1]} back."
        notes.append(words)
    if any(value for name, value in given_parameters(environment).items() if "drag" in name):
        notes.append("The steady curve and its offset points are those of friction, without drag.")
    return notes


def print_limits(page: Page, name: str, limits: Any, force: str = "", speed: str = "", length: str = "") -> None:
    """The limits of friction at a contact, with the units of their numbers."""
    page.say(f"{name}: {limits.law} at normal load N = {said(limits.load, force)}", style="bold")
    made = table("Limits", "limit", "value", "meaning")
    for name, value, unit, meaning in (
        ("breakaway force", limits.breakaway_force, force, "N eta_s: approached, not reached, by bristles"),
        ("Coulomb force", limits.coulomb_force, force, "N eta_c"),
        ("deflection limit", limits.deflection_limit, length, "g(0), eq. 10: |xi| never exceeds it"),
        ("boundary velocity", limits.boundary_velocity, speed, BOUNDARY),
    ):
        if value is not None:
            made.add_row(name, said(value, unit, 12), meaning)
    page.print(made)
    damper = f"{force} s/m" if force else ""
    curve = table("Steady sliding (eqs 11, 12)", "velocity", "friction", "slope")
    for point in limits.curve:
        curve.add_row(said(point.velocity, speed, 6), said(point.friction, force), said(point.slope, damper))
    page.print(curve)
    if limits.offset is not None:
        page.print(_offset_table(limits.offset, speed, damper))


def _offset_table(offset: Any, speed: str, damper: str) -> Table:
    made = table("Offset points, where the steady curve is level (eqs 13-15)", "point", "value", "meaning")
    if offset.exist:
        made.add_row("lower, exact", said(offset.lower, speed, 15), "of eq. 13; for exponent 2 Lambert's W")
        made.add_row("upper, exact", said(offset.upper, speed, 15), "likewise")
    else:
        made.add_row("exact", "none", offset.reason)
    printed = {"lower, as printed": offset.printed_lower, "upper, as printed": offset.printed_upper.value}
    for (name, value), equation in zip(printed.items(), ("eq. 14", "eq. 15"), strict=True):
        made.add_row(name, "none" if value is None else said(value, speed, 15), equation)
    upper = offset.corrected_upper.value
    corrected = "none" if upper is None else said(upper, speed, 15)
    made.add_row("upper, eq. 15 corrected", corrected, "any exponent (erratum 4)")
    if offset.greatest_viscous_damping is not None:
        greatest = said(offset.greatest_viscous_damping, damper)
        made.add_row("largest delta2", greatest, "above it there are no offset points")
    return made
