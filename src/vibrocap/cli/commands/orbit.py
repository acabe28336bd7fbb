"""`vibrocap orbit`: the steady motion of a case."""

import dataclasses
import itertools
import math
from typing import TYPE_CHECKING, Any

from vibrocap.arguments import ArgumentError, Refusal
from vibrocap.cli.command import Answer, OfCase, Report, command
from vibrocap.cli.options import JSON, SETTLE_PERIODS, option
from vibrocap.cli.terminal import Page, said, table
from vibrocap.physics.system import System
from vibrocap.quantities.declared import scaled, without_unit
from vibrocap.quantities.dimensional import in_si, view

if TYPE_CHECKING:
    from vibrocap.orbits.closing.gradients import Gradients
    from vibrocap.orbits.closing.orbit import Orbit

STABLE = {
    "stable": "yes",
    "unstable": "no",
    "neither": "neither: a multiplier is 1, as where a whole range of motions is steady",
    "not known": "not known",
}
LEAST_SETTLING = 10  # drive periods for which a motion that has not settled is simulated on to tell its class


class OrbitRequest(OfCase):
    response_period: int | None = option("find an orbit of this many drive periods near the start, stable or not")
    half: bool = option("find a symmetric orbit near the start, stable or not", False)
    gradients: bool = option("slopes and elasticities of mean velocity and cost of transport in each parameter", False)
    json: bool = JSON
    settle_periods: int = SETTLE_PERIODS(2000)
    section: str | None = option(
        "without a periodic drive: an event such as stick_2, or NAME=VALUE, NAME=VALUE:down", advanced=True
    )
    returns: int = option("most returns to the section in one cycle", 64, advanced=True)
    tolerance: float = option("error per step, relative to the states' natural size", 1e-12, advanced=True)


@command(
    "steady",
    "vibrocap orbit examples/travels-by-stick-slip.toml",
    "vibrocap orbit examples/travels-by-stick-slip.toml --half --json",
    "vibrocap orbit examples/bench-in-si.toml --gradients",
    doing="Closing the steady motion",
)
def orbit(request: OrbitRequest, report: Report) -> Answer:
    """The steady motion of a case and its stability.

    The command simulates the case until it settles and computes the periodic motion by shooting, to rounding: period,
    drift, stability, symmetry, mirror-image solution and mode sequence. From an unstable orbit it continues to the
    motion that replaces it. --response-period and --half find unstable orbits, with the motions that replace them.
    Without a drive that changes in time the motion is a cycle, which returns to a section. The table compares the
    motion with known bounds of speed and cost of transport.

    Exit code 3: the motion did not settle, or no periodic motion was found.
    """
    from vibrocap.orbits.attractors.classification import classify
    from vibrocap.orbits.closing.autonomous_orbit import OfSection, checked_section
    from vibrocap.orbits.closing.gradients import check_gradients
    from vibrocap.orbits.closing.orbit import orbit as steady_motion
    from vibrocap.orbits.closing.periodic_solution import OrbitStatus

    setup = request.setup
    if request.gradients:
        try:
            check_gradients(setup.system)
        except ArgumentError as error:
            raise Refusal(f"--gradients: {error.complaint.text}") from None
    section, context = checked_section(setup.system, request.section), setup.system.si_context()
    section = section if context is None else OfSection().converted(section, context, back=True)
    settings = request.given("response_period", "half", "settle_periods", "returns", "tolerance")
    result = steady_motion(setup.system, initial=setup.initial, section=section, **settings)
    left = result.passed or (result if result.closes and result.unstable else None)
    ways = left.pushed_off(settle_periods=request.settle_periods) if left and left.response_period else None
    what = None
    if result.status is OrbitStatus.NOT_SETTLED and result.response_period:
        what = classify(setup.system, result.state, settle_periods=max(request.settle_periods, LEAST_SETTLING))
    record = orbit_view(result, left, ways, what) | {"bounds": bounds_record(setup.system, result)}
    slopes, lacking = (None, "") if not request.gradients or result.failed else gradients_of(result)
    if slopes is not None:
        record["gradients"] = view(slopes)["slopes"]

    def text(page: Page) -> None:
        _print_orbit(page, record, str(request.case))
        if slopes is not None:
            print_gradients(page, slopes)

    incomplete = f"No gradients: {lacking}." if lacking else ""
    if not lacking and result.status is not OrbitStatus.CONVERGED:
        why = {
            OrbitStatus.NOT_CERTIFIED: "The steady motion is not certified.",
            OrbitStatus.CONTRADICTED: "The stability of the steady motion is not known.",
        }.get(result.status, f"No closed steady motion ({result.status.value}).")
        incomplete = f"{why} {result.status.advice}"
    return Answer(record, text, incomplete=incomplete)


def bounds_record(system: System, steady: Any) -> list[dict[str, Any]]:
    """The known bounds of a system, whatever drives it, and what a steady motion reaches of them."""
    from vibrocap.design.bounds import performance_bounds

    try:
        bounds = performance_bounds(system)
    except ArgumentError:  # none is known of it
        return []
    records = []
    for bound in bounds:
        known = {"reached": None, "holds": None}
        if steady.closes:
            same = dataclasses.replace(bound, value=bound.of(steady))
            known = {"reached": view(in_si(same, system))["value"], "holds": bound.holds(steady)}
        records.append(view(in_si(bound, system)) | known)
    return records


def bound_rows(bounds: list[dict[str, Any]]) -> list[tuple[str, str]]:
    """A line for each bound: its value, and how near the motion comes to it."""
    rows = []
    for row in bounds:
        words = f"{row['kind']} {row['measure'].replace('_', ' ')} of {row['holds_for']}: {row['value']:.10g}"
        if (reached := row["reached"]) is not None:
            ratio = without_unit(reached) / without_unit(row["value"])
            words += f"; this motion {reached:.10g}, "
            words += f"{ratio:.6g} times it" if row["holds"] else "to which it does not apply"
        rows.append(("bound", f"{words} ({row['source']})"))
    return rows


def orbit_view(closed: "Orbit", left: "Orbit | None", ways: Any, what: Any) -> dict[str, Any]:
    """An orbit; one that is unstable with what it gives way to; and the class of a motion that is no orbit."""
    record = view(in_si(closed))
    if left is not None and ways is not None:
        names = ("drift", "state", "largest_multiplier")
        unstable = {name: value for name, value in view(in_si(left)).items() if name in names}
        record["unstable_orbit"] = unstable | {"gives_way_to": view(in_si(ways, closed.system))}
    if what is not None:
        record["class"] = view(in_si(what, closed.system))
    return record


def _print_orbit(page: Page, record: dict[str, Any], title: str) -> None:
    closed = not record["failed"]
    page.say(f"{'Steady motion' if closed else 'No closed steady motion'} of {title}", style="bold")
    state = _state(record["state"])
    if not closed:
        tried = f"; the last attempt does not close by {record['residual']:.2g}"
        rows = [("status", record["status"] + (tried if math.isfinite(record["residual"]) else ""))]
        rows += [("last state", state)]
        if "class" in record:
            rows += [("class", f"{record['class']['kind']}: {record['class']['reason']}")]
        page.rows(rows, 14)
        return
    own = f" (its own, {record['returns']} returns)" if record["returns"] > 1 else " (its own)"
    periods = f" ({record['response_period']} of the drive)" if record["response_period"] else own
    sizes = ", ".join(map(_multiplier, record["multipliers"]))
    symmetric = {True: "its own mirror image", False: "not symmetric", None: "the system has no such symmetry"}
    drift, velocity, twin = record["drift"], record["mean_velocity"], record["mirrored_state"]
    rows = [
        ("status", f"{record['status']}, residual {record['residual']:.2g}"),
        ("period", f"{record['period']:.12g}" + periods),
        ("drift", "none" if drift is None else f"{drift:.12g} per period"),
        ("mean velocity", "none" if velocity is None else f"{velocity:.12g}"),
        *(("winding", f"{turns} turn(s) of {name} per period") for name, turns in record["winding"].items()),
        ("stable", STABLE[record["stability"]]),
        *([("multipliers", sizes)] if sizes else []),
        *([("continuum", "neighbours are steady too: travel is not determined")] if record["continuum"] else []),
        ("symmetry", symmetric[record["symmetric"]]),
        ("mode sequence", record["mode_sequence"]),
        ("state", state),
    ]
    if twin is not None and not record["symmetric"]:
        opposite = "" if drift is None else f"drift {scaled(drift, -1.0):.12g}, "
        rows.append(("mirror image", f"{opposite}state {_state(twin)}"))
    if "unstable_orbit" in record:
        rows += _unstable_rows(record["unstable_orbit"], record["stable"])
    rows += bound_rows(record["bounds"])
    page.rows(rows, 14)


def _state(state: dict[str, Any]) -> str:
    """A state in a line; a zero with a sign, as of a mirrored motion, is a zero."""
    return ", ".join(f"{name} {scaled(number, 1.0):.12g}" for name, number in state.items())


def _unstable_rows(left: dict[str, Any], kept: bool) -> list[tuple[str, str]]:
    """Rows of an unstable orbit, which no simulation keeps, and of its successors."""
    growth = f"pushes grow {left['largest_multiplier']:.4g} times per response"
    rows = [("unstable", f"no motion stays on this orbit: {growth}")]
    if kept:
        drift = "" if left["drift"] is None else f" of drift {left['drift']:.12g}"
        text = f"the start leads close to an orbit{drift} on which no motion stays ({growth}); which of these follows"
        rows = [("passed", f"{text} may be a matter of rounding")]
    for motion in left["gives_way_to"]:
        travel = "no drift" if motion["drift"] is None else f"drift {motion['drift']:.12g}"
        start = _state(motion["state"])
        periods = f"period {motion['response_period']} of the drive, stable {STABLE[motion['stability']]}"
        rows.append(("successor", f"{travel}, {periods}, modes {motion['mode_sequence']}, {start}"))
    if not left["gives_way_to"]:
        rows.append(("successor", "none that settles: it may be chaotic, see `classify` in Python"))
    return rows


def _multiplier(multiplier: complex) -> str:
    """A multiplier in words: exactly zero where sticking, or an actuator at its limit, forgets a direction."""
    real, imaginary = multiplier.real, multiplier.imag
    if real == 0.0 and imaginary == 0.0:
        return "0 (this direction vanishes in a stick phase, or at a limit)"
    return f"{real:.9g}" if imaginary == 0.0 else f"{real:.9g} {'+' if imaginary > 0 else '-'} {abs(imaginary):.9g}i"


SHOWN = ("mean_velocity", "cost_of_transport")


def gradients_of(closed: "Orbit") -> "tuple[Gradients | None, str]":
    """(slopes of mean velocity and cost of transport, of what cannot travel of the work of the drive; or None and why).

    They are over every parameter that has a slope.
    """
    from vibrocap.orbits.closing.gradients import measures_with_gradients

    known = measures_with_gradients(closed.system)
    try:
        return closed.gradients(measures=[name for name in SHOWN if name in known] or known[:1]), ""
    except ArgumentError as error:
        return None, str(error)


def print_gradients(page: Page, slopes: "Gradients") -> None:
    """Slope and elasticity by parameter, a table for each measure."""
    for measure, rows in itertools.groupby(slopes.slopes, lambda slope: slope.measure):
        listing = table(f"Gradient of {measure.replace('_', ' ')}", "parameter", "slope", "elasticity")
        listing.columns[-1].justify = "right"
        for row in rows:
            share = "" if math.isnan(row.elasticity) else f"{row.elasticity:.4g}"
            listing.add_row(row.parameter, said(row.slope, row.unit.removesuffix("1"), 8), share)
        page.print(listing)
    page.say("They hold for the present mode sequence. Elasticity: relative change for relative change.", "dim")
