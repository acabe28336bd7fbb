"""Gradients of a steady motion as `vibrocap orbit --gradients` shows them: a table for each measure."""

import itertools
import math
from typing import TYPE_CHECKING

from vibrocap.arguments import ArgumentError
from vibrocap.cli.terminal import Page, said, table

if TYPE_CHECKING:
    from vibrocap.orbits.closing.gradients import Gradients
    from vibrocap.orbits.closing.orbit import Orbit

SHOWN = ("mean_velocity", "cost_of_transport")


def gradients_of(found: "Orbit") -> "tuple[Gradients | None, str]":
    """(slopes of mean velocity and cost of transport, of what cannot travel of the work of the drive; or None and why).

    They are over every parameter that has a slope.
    """
    from vibrocap.orbits.closing.gradients import measures_with_gradients

    known = measures_with_gradients(found.system)
    try:
        return found.gradients(measures=[name for name in SHOWN if name in known] or known[:1]), ""
    except ArgumentError as error:
        return None, str(error)


def print_gradients(slopes: "Gradients") -> None:
    """Slope and elasticity by parameter, a table for each measure."""
    page = Page()
    for measure, rows in itertools.groupby(slopes.slopes, lambda each: each.measure):
        made = table(f"Gradient of {measure.replace('_', ' ')}", "parameter", "slope", "elasticity")
        made.columns[-1].justify = "right"
        for each in rows:
            share = "" if math.isnan(each.elasticity) else f"{each.elasticity:.4g}"
            made.add_row(each.parameter, said(each.slope, each.unit.removesuffix("1"), 8), share)
        page.print(made)
    page.say("They hold for the present mode sequence. Elasticity: relative change for relative change.", "dim")
