"""`vibrocap orbit`: the steady motion of a case."""

import itertools
import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from vibrocap.arguments import ArgumentError
from vibrocap.cli.options import refusing
from vibrocap.cli.terminal import INCOMPLETE, OK, Page, complain, progress, said, table
from vibrocap.io.json_text import in_both, json_text
from vibrocap.io.motion_file import read_source
from vibrocap.physics.system import System
from vibrocap.quantities.dimensional import in_si, units_of

if TYPE_CHECKING:
    from vibrocap.orbits.closing.gradients import Gradients
    from vibrocap.orbits.closing.orbit import Orbit
    from vibrocap.orbits.closing.returns import Section

LEAST_SETTLING = 10  # drive periods for which a motion that has not settled is simulated on to tell its class


def orbit(
    case: Path,
    /,
    *,
    response_period: int | None = None,
    half: bool = False,
    settle_periods: int = 2000,
    section: str | None = None,
    returns: int = 64,
    tolerance: float = 1e-12,
    gradients: bool = False,
    json: bool = False,
) -> int:
    """The steady motion of a case: period, drift, stability, symmetry, mirror twin and mode sequence.

    The case is simulated until it settles; then the periodic motion is computed
    by shooting, to rounding. A motion that settles near an unstable orbit is
    followed on to the orbit that it ends on. With --response-period or --half an
    unstable orbit can be asked for; the motions that replace it are printed too.
    Without a drive that changes in time the motion is a cycle: it returns to a
    section, once or several times, before it repeats. --section chooses another.

    Exit code 3: the motion did not settle, or no periodic motion was found.

    Parameters
    ----------
    case
        a case file (.toml), or a motion exported before (.nc, .csv)
    response_period
        find an orbit that repeats after so many drive periods, stable or not, near the start
    half
        find an orbit that is its own mirror image, stable or not, near the start
    settle_periods
        drive periods simulated, at most
    section
        of a system that nothing drives in time: an event such as stick_2, or NAME=VALUE, NAME=VALUE:down
    returns
        most returns to the section in one cycle
    tolerance
        error per step, relative to the states' natural size
    gradients
        how mean velocity and cost of transport change with each parameter, exactly, and their elasticities
    json
        print one JSON object in full precision instead of a table
    """
    from vibrocap.orbits.attractors.classification import classify
    from vibrocap.orbits.closing.gradients import check_gradients
    from vibrocap.orbits.closing.orbit import orbit as steady_motion
    from vibrocap.orbits.closing.periodic_solution import OrbitStatus

    given = read_source(case)
    if gradients:
        with refusing(system="--gradients"):
            check_gradients(given.system)
    with (
        progress("Closing the steady motion"),
        refusing("response_period", "half", "settle_periods", "section", "returns", "tolerance"),
    ):
        found = steady_motion(
            given.system,
            initial=given.initial,
            response_period=response_period,
            half=half,
            settle_periods=settle_periods,
            section=_section(given.system, section),
            returns=returns,
            tolerance=tolerance,
        )
    left = found.passed or (found if found.closes and found.unstable else None)
    ways = left.pushed_off(settle_periods=settle_periods) if left is not None and left.response_period else None
    what = None
    if found.status is OrbitStatus.NOT_SETTLED and found.response_period:
        what = classify(given.system, found.state, settle_periods=max(settle_periods, LEAST_SETTLING))
    record = whole_record(found, left, ways, what)
    slopes, lacking = (None, "") if not gradients or found.failed else gradients_of(found)
    if slopes is not None:
        record["gradients"] = slopes.table()
    if json:
        print(json_text(record))
    else:
        _print_orbit(record, str(case))
        if slopes is not None:
            print_gradients(slopes)
    if lacking:
        complain(f"No gradients: {lacking}.")
        return INCOMPLETE
    if found.status is OrbitStatus.CONVERGED:
        return OK
    what = {
        OrbitStatus.NOT_CERTIFIED: "The steady motion is not certified.",
        OrbitStatus.CONTRADICTED: "The stability of the steady motion is not known.",
    }
    complain(f"{what.get(found.status, f'No closed steady motion ({found.status.value}).')} {found.status.advice}")
    return INCOMPLETE


def whole_record(found: Any, left: Any, ways: Any, what: Any) -> dict[str, Any]:
    """What is known of an orbit, of one that is unstable and what it gives way to, and of a motion that is no orbit.

    In SI where the system knows its scales, and the numbers without units beside it.
    """
    record = _whole_record(found, left, ways, what)
    if (shown := in_si(found)) is found:
        return record
    seen = (in_si(each, found.system) for each in (left, ways, what))
    units = {name: unit for name, unit in _whole_units(shown).items() if record.get(name) is not None}
    return in_both(_whole_record(shown, *seen), units, record)


def _whole_record(found: Any, left: Any, ways: Any, what: Any) -> dict[str, Any]:
    record = orbit_record(found)
    if ways is not None:
        record["unstable_orbit"] = {
            "drift": left.drift,
            "state": left.state,
            "largest_multiplier": float(np.max(np.abs(left.multipliers))),
            "gives_way_to": [orbit_record(each) for each in ways],
        }
    if what is not None:
        record["class"] = {"kind": what.kind, "reason": what.reason, "drift": what.drift}
    return record


def _whole_units(found: Any) -> dict[str, Any]:
    """The units of the record of an orbit in SI, in its form."""
    travel = units_of(found, "drift", "state")
    return orbit_units(found) | {
        "unstable_orbit": {**travel, "gives_way_to": orbit_units(found)},
        "class": units_of(found, "drift"),
    }


def orbit_units(found: Any) -> dict[str, Any]:
    """The units of `orbit_record` of an orbit in SI."""
    units = units_of(found, "period", "mean_velocity", "drift", "state")
    return units | {"twin": {name: units[name] for name in ("drift", "state") if name in units}}


def _section(system: System, text: str | None) -> "Section | None":
    """The section asked for, its value without units."""
    from vibrocap.orbits.closing.returns import OfSection, checked_section

    found, context = checked_section(system, text), system.si_context()
    return found if context is None else OfSection().converted(found, context, back=True)


def orbit_record(found: Any) -> dict[str, Any]:
    """What is known of an orbit, by name."""
    from vibrocap.orbits.closing.periodic_solution import OrbitStatus

    known = found.status is OrbitStatus.CONVERGED
    closed = found.closes or found.status is OrbitStatus.CONTRADICTED
    twin = None
    if closed and found.mirrored_state is not None and not found.symmetric:
        twin = {"state": found.mirrored_state, "drift": None if found.drift is None else -found.drift}
    return {
        "status": found.status.value,
        "closed": closed,
        "residual": found.residual,
        "period": found.period if closed else None,
        "response_period": found.response_period if closed else None,
        "drift": found.drift,
        "mean_velocity": found.mean_velocity,
        **({"winding": found.winding} if found.system.turns else {}),
        "returns": found.returns if closed else None,
        "stable": found.stable if known else None,
        "stability": _stability(found) if known else "not known",
        "multipliers": [
            {"real": float(np.real(m)), "imaginary": float(np.imag(m))} for m in (found.multipliers if known else ())
        ],
        "continuum": found.continuum,
        "symmetric": found.symmetric,
        "mode_sequence": found.mode_sequence if closed else None,
        "state": found.state,
        "twin": twin,
    }


def _print_orbit(record: dict[str, Any], title: str) -> None:
    """The table of an orbit."""
    page = Page()
    units: dict[str, Any] = record.get("units") or {}
    closed = record["closed"]
    page.say(f"{'Steady motion' if closed else 'No closed steady motion'} of {title}", style="bold")
    state = _state(record["state"], units)
    length, speed, second = (units.get(name, "") for name in ("drift", "mean_velocity", "period"))
    if not closed:
        tried = f"; what was tried last does not close by {record['residual']:.2g}"
        rows = [("status", record["status"] + (tried if math.isfinite(record["residual"]) else ""))]
        rows += [("last state", state)]
        if "class" in record:
            rows += [("class", f"{record['class']['kind']}: {record['class']['reason']}")]
        page.rows(rows, 14)
        return
    own = f" (its own, {record['returns']} returns)" if record["returns"] > 1 else " (its own)"
    periods = f" ({record['response_period']} of the drive)" if record["response_period"] else own
    sizes = ", ".join(_multiplier(m) for m in record["multipliers"])
    symmetric = {True: "its own mirror image", False: "not symmetric", None: "the system has no such symmetry"}
    rows = [
        ("status", f"{record['status']}, residual {record['residual']:.2g}"),
        ("period", said(record["period"], second, 12) + periods),
        ("drift", "none" if record["drift"] is None else f"{said(record['drift'], length, 12)} per period"),
        ("mean velocity", "none" if record["mean_velocity"] is None else said(record["mean_velocity"], speed, 12)),
        *(("winding", f"{turns} turn(s) of {name} per period") for name, turns in record.get("winding", {}).items()),
        ("stable", record["stability"]),
        *([("multipliers", sizes)] if sizes else []),
        *([("continuum", "neighbours are steady too: the drift is not determined")] if record["continuum"] else []),
        ("symmetry", symmetric[record["symmetric"]]),
        ("mode_sequence", record["mode_sequence"]),
        ("state", state),
    ]
    if record["twin"] is not None:
        drift = "" if record["twin"]["drift"] is None else f"drift {said(record['twin']['drift'], length, 12)}, "
        rows.append(("mirror twin", f"{drift}state {_state(record['twin']['state'], units)}"))
    if "unstable_orbit" in record:
        rows += _unstable_rows(record["unstable_orbit"], record["stable"], units)
    page.rows(rows, 14)


def _stability(found: Any) -> str:
    """Whether a simulation keeps a closed orbit."""
    if found.stable:
        return "yes"
    return "no" if found.unstable else "neither: a multiplier is 1, as where a whole range of motions is steady"


def _state(state: dict[str, float], units: dict[str, Any]) -> str:
    """A state in a line; a zero with a sign, as of a mirrored motion, is a zero."""
    own = units.get("state", {})
    return ", ".join(f"{name} {said(number + 0.0, own.get(name, ''), 12)}" for name, number in state.items())


def _unstable_rows(left: dict[str, Any], kept: bool | None, units: dict[str, Any]) -> list[tuple[str, str]]:
    """What is to be said of an unstable orbit: that no simulation keeps it, and what it gives way to."""
    length = units.get("unstable_orbit", {}).get("drift", "")
    growth = f"pushes grow {left['largest_multiplier']:.4g} times per response"
    rows = [("unstable", f"no motion stays on this orbit: {growth}")]
    if kept:
        drift = "" if left["drift"] is None else f" of drift {said(left['drift'], length, 12)}"
        text = f"the start leads close to an orbit{drift} on which no motion stays ({growth}); which of these follows"
        rows = [("passed", f"{text} may be a matter of rounding")]
    for each in left["gives_way_to"]:
        travel = "no drift" if each["drift"] is None else f"drift {said(each['drift'], length, 12)}"
        start = _state(each["state"], units)
        periods = f"period {each['response_period']} of the drive"
        rows.append(
            ("gives way to", f"{travel}, {periods}, stable {each['stability']}, modes {each['mode_sequence']}, {start}")
        )
    if not left["gives_way_to"]:
        rows.append(("gives way to", "nothing that settles: it may be chaotic, see `classify` in Python"))
    return rows


def _multiplier(multiplier: dict[str, float]) -> str:
    """A multiplier in words: exactly zero where sticking, or an actuator at its limit, forgets a direction."""
    real, imaginary = multiplier["real"], multiplier["imaginary"]
    if real == 0.0 and imaginary == 0.0:
        return "0 (forgotten while it sticks, or at a limit)"
    return f"{real:.9g}" if imaginary == 0.0 else f"{real:.9g} {'+' if imaginary > 0 else '-'} {abs(imaginary):.9g}i"


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
