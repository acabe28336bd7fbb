"""`vibrocap limits`: what the friction of a case can do, exactly."""

import dataclasses
from pathlib import Path
from typing import Any

from rich.table import Table

from vibrocap.case.case import CaseError
from vibrocap.cli.terminal import OK, Page, said, table
from vibrocap.io.in_si import LIMIT_UNITS, limits_in_si
from vibrocap.io.json_text import json_text
from vibrocap.io.motion_file import read_source
from vibrocap.physics.system import System


def limits(case: Path, /, *, json: bool = False) -> int:
    """Limits of the friction of a case (the paper's eqs 10-15): exact, as the paper prints them, or why there are none.

    Parameters
    ----------
    case
        a case file (.toml), or a motion exported before (.nc, .csv)
    json
        print one JSON object in full precision instead of tables
    """
    from vibrocap.measures.limits import frictional_limits

    system = read_source(case).system
    try:
        found = plain = frictional_limits(system.friction, float(system.placed.load()))
    except (TypeError, ValueError) as error:
        raise CaseError([f"friction: {error}"], str(case)) from None
    if system.units is not None:
        found = limits_in_si(plain, system)
    notes = beyond_friction(system, found.breakaway_force)
    if json:
        record = dataclasses.asdict(found) | ({"notes": notes} if notes else {})
        if found is not plain:
            record |= {"units": LIMIT_UNITS, "dimensionless": dataclasses.asdict(plain)}
        print(json_text(record))
    else:
        print_limits(found, "N", "m/s", "m") if found is not plain else print_limits(found)
        for note in notes:
            Page().say(f"Note: {note}")
    return OK


def beyond_friction(system: System, breakaway: float) -> list[str]:
    """What the limits of friction alone leave out: a load that follows the motion, and what acts from outside.

    breakaway: the force at which the contact breaks away, in the units of the results
    """
    notes = []
    if system.machine.follows_load:
        notes.append("The load follows the motion; these are the limits at its mean.")
    if (environment := system.environment) is None:
        return notes
    at_rest = environment.outside(system.placed, 0.0, (0.0,) * len(system.machine.states), 0).push_at_rest
    factor, unit = (1.0, "") if system.units is None else (system.si.factor("friction"), "N")
    push = at_rest * factor
    if push:
        words = (
            f"Slope and outer force push with {said(push, unit)} at rest, positive forward, which friction holds too: "
        )
        if abs(push) > breakaway:
            words += f"more than it can, so the contact slides {'forward' if push > 0.0 else 'back'} by itself."
        else:
            ways = said(breakaway - push, unit), said(breakaway + push, unit)
            words += f"the machine itself breaks away with {ways[0]} forward and {ways[1]} back."
        notes.append(words)
    if environment.linear_drag or environment.quadratic_drag:
        notes.append("The steady curve and its offset points are those of friction, without drag.")
    return notes


def print_limits(limits: Any, force: str = "", speed: str = "", length: str = "") -> None:
    """The summary of `vibrocap limits`, with the units of its numbers."""
    page = Page()
    page.say(f"{limits.law} friction at normal load N = {said(limits.load, force)}", style="bold")
    made = table("Limits", "limit", "value", "meaning")
    breakaway = said(limits.breakaway_force, force, 12)
    made.add_row("breakaway force", breakaway, "N eta_s: approached, not reached, by bristles")
    made.add_row("Coulomb force", said(limits.coulomb_force, force, 12), "N eta_c")
    if limits.deflection_limit is not None:
        deflection = said(limits.deflection_limit, length, 12)
        made.add_row("deflection limit", deflection, "g(0), eq. 10: |xi| never exceeds it")
    if limits.boundary_velocity is not None:
        words = "v*: below it friction is larger while accelerating, above it while decelerating (erratum 7)"
        made.add_row("boundary velocity", said(limits.boundary_velocity, speed, 12), words)
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
