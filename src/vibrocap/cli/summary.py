"""What the commands print for people: tables that say what they rest on."""

import collections
from typing import Any

from rich.box import SIMPLE_HEAD
from rich.table import Table
from rich.text import Text

from vibrocap.case import CHOICES
from vibrocap.cli.terminal import Page
from vibrocap.io.record import EVENT_KINDS
from vibrocap.measures.response import response_class
from vibrocap.parameters import given_parameters
from vibrocap.trajectory import Trajectory

WIDE = 120  # columns of a terminal
EVENT_WORDS = {
    "stick": "comes to rest and sticks",
    "slip_forward": "leaves stick forward",
    "slip_back": "leaves stick backward",
    "reversal": "reverses without sticking",
    "graze": "touches its limit and stays",
    "switch": "goes over to another piece of its law",
}


def print_motion(motion: Trajectory, record: dict[str, Any], title: str) -> None:
    """The summary of `vibrocap simulate`."""
    console = Page()
    console.print(Text(title, style="bold"))
    for line in system_lines(motion.system):
        console.print(Text("  " + line, style="dim"))
    console.print(_motion_table(motion, record))
    if record["energy"]:
        console.print(_energy_table(record["energy"]))
    if record["certificate"]:
        console.print(_certificate_table(record["certificate"], motion))
    units = "All quantities are dimensionless: lengths in l, time in sqrt(l/g), forces in mg."
    if motion.system.machine.cyclic is None:
        units = "All quantities are in the units of the parameters."
    console.print(Text(units, style="dim"))


def system_lines(system: Any) -> list[str]:
    """The parts of a system with their parameters, a line each."""
    lines = []
    for section in CHOICES:
        part = getattr(system, section)
        values = ", ".join(f"{name} {_short(value)}" for name, value in given_parameters(part).items())
        lines.append(f"{part.name}: {values}")
    return lines


def _short(value: Any) -> str:
    return value if isinstance(value, str) else f"{value:.6g}"


def _table(title: str, *columns: str) -> Table:
    table = Table(title=title, title_justify="left", title_style="bold", header_style="dim", box=SIMPLE_HEAD)
    for index, column in enumerate(columns):
        table.add_column(column, justify="right" if column == "value" else "left", no_wrap=index < 2)
    return table


def _motion_table(motion: Trajectory, record: dict[str, Any]) -> Table:
    done = record["time"] / motion.period
    table = _table("Motion", "quantity", "value", "what it rests on")
    table.add_row(
        "time reached",
        f"{record['time']:.10g}",
        f"{done:.6g} of {motion.periods:.6g} drive periods T = {motion.period:.8g}",
    )
    for name, value in record["state"].items():
        table.add_row(name.replace("_", " "), f"{value:.10g}", "at the end")
    table.add_section()
    if record["drift"] is not None:
        table.add_row("drift", f"{record['drift']:.10g}", "travel in the last whole period")
        velocity = record["mean_velocity"]
        start, end = (mark / motion.period for mark in velocity["window"])
        count = round(end - start)
        settled = "settled" if velocity["settled"] else "NOT settled: a longer run gives another value"
        window = f"mean over the last {count} periods, {start:.6g} T to {end:.6g} T; {settled}"
        table.add_row("mean velocity", f"{velocity['value']:.10g}", window)
        table.add_row("response", response_class(motion).kind, _response_words(motion))
    if record["stick_fraction"] is not None:
        table.add_row("stick fraction", f"{record['stick_fraction']:.6g}", "share of the whole run at rest")
    elif motion.system.friction.kind != "set-valued":
        table.add_row("stick fraction", "none", f"the {motion.system.friction.name} law creeps instead of sticking")
    table.add_section()
    for kind in EVENT_KINDS:
        if record["events"][kind]:
            table.add_row(kind.replace("_", " "), str(record["events"][kind]), f"times the contact {EVENT_WORDS[kind]}")
    return table


def _response_words(motion: Trajectory) -> str:
    response = response_class(motion)
    if response.residual is None:
        return "fewer than two whole periods"
    symmetry = {True: "; its own mirror image, so it cannot travel", False: "; differs from its mirror image", None: ""}
    return f"modulo the drift, to {response.residual:.1e}{symmetry[response.symmetric]}"


def _energy_table(energy: dict[str, Any]) -> Table:
    table = _table(f"Energy from {energy['window'][0]:.6g} to {energy['window'][1]:.6g}", "channel", "value", "meaning")
    meaning = {
        "drive": "work of the drive",
        "damper": "work of the damper",
        "belt": "work of the belt under the block",
        "contact_sliding": "work of sliding friction",
        "bristle_loss": "loss in the bristles",
        "stored": "gained by machine and contact",
        "residual": "stored less all works: should vanish",
    }
    for name, text in meaning.items():
        if name == "belt" and energy[name] == 0.0:
            continue
        number = f"{energy[name]:.10g}" if name != "residual" else f"{energy[name]:.1e}"
        table.add_row(name.replace("_", " "), number, text)
    return table


def _certificate_table(certificate: dict[str, Any], motion: Trajectory) -> Table:
    table = _table("Certificate", "evidence", "value", "meaning")
    if certificate["stick_force_ratio"] is not None:
        ratio = certificate["stick_force_ratio"]
        table.add_row("stick force ratio", f"{ratio:.6g}", "largest |R|/(N eta_s) while stuck: at most 1")
    table.add_row(
        "event velocity", f"{certificate['event_velocity']:.1e}", "largest contact velocity at a located event"
    )
    kept = "yes" if certificate["sign_kept"] else "NO"
    table.add_row("sign kept", kept, "sliding keeps its direction between events")
    table.add_row("energy residual", f"{certificate['energy_residual']:.1e}", "largest over the run")
    table.add_row("momentum residual", f"{certificate['momentum_residual']:.1e}", "largest over the run")
    error = f"of the states, by a second run at ten times the tolerance {motion.tolerance:.1e}"
    estimate = certificate["estimated_error"]
    table.add_row("estimated error", "none" if estimate is None else f"{estimate:.1e}", error)
    steps = f"{certificate['taylor_steps']} + {certificate['implicit_steps']}"
    table.add_row("steps", steps, "Taylor + implicit (where the law is stiff)")
    return table


def print_limits(limits: Any, law: Any) -> None:
    """The summary of `vibrocap limits`."""
    console = Page()
    console.print(Text(f"{limits.law} friction at normal load N = {limits.load:.10g}", style="bold"))
    table = _table("Limits", "limit", "value", "meaning")
    table.add_row("breakaway force", f"{limits.breakaway_force:.12g}", "N eta_s: approached, not reached, by bristles")
    table.add_row("Coulomb force", f"{limits.coulomb_force:.12g}", "N eta_c")
    if limits.deflection_limit is not None:
        table.add_row("deflection limit", f"{limits.deflection_limit:.12g}", "g(0), eq. 10: |xi| never exceeds it")
    if limits.boundary_velocity is not None:
        words = "v*: below it friction is larger while accelerating, above it while decelerating (erratum 7)"
        table.add_row("boundary velocity", f"{limits.boundary_velocity:.12g}", words)
    console.print(table)
    curve = _table("Steady sliding (eqs 11, 12)", "velocity", "friction", "slope")
    for point in limits.curve:
        curve.add_row(f"{point.velocity:.6g}", f"{point.friction:.10g}", f"{point.slope:.10g}")
    console.print(curve)
    if limits.offset is not None:
        console.print(_offset_table(limits.offset))


def _offset_table(offset: Any) -> Table:
    table = _table("Offset points, where the steady curve is level (eqs 13-15)", "point", "value", "meaning")
    if offset.exist:
        table.add_row("lower, exact", f"{offset.lower:.15g}", "of eq. 13; for exponent 2 Lambert's W")
        table.add_row("upper, exact", f"{offset.upper:.15g}", "likewise")
    else:
        table.add_row("exact", "none", offset.reason)
    printed = {"lower, as printed": offset.printed_lower, "upper, as printed": offset.printed_upper.value}
    for (name, value), equation in zip(printed.items(), ("eq. 14", "eq. 15"), strict=True):
        table.add_row(name, "none" if value is None else f"{value:.15g}", equation)
    upper = offset.corrected_upper
    table.add_row(
        "upper, eq. 15 corrected", "none" if upper.value is None else f"{upper.value:.15g}", "any exponent (erratum 4)"
    )
    if offset.greatest_viscous_damping is not None:
        table.add_row(
            "largest delta2", f"{offset.greatest_viscous_damping:.10g}", "above it there are no offset points"
        )
    return table


def print_claims(result: Any) -> None:
    """The summary of `vibrocap reproduce`: every claim with its verdict, and where the report lies.

    The numbers found stand beside it where the terminal is wide enough; the report has them all.
    """
    page = Page()
    wide = page.width >= WIDE
    table = _table("Claims of the paper", "claim", "where", "verdict", *(["found"] if wide else []))
    table.columns[1].no_wrap = False
    for verdict in result.claims:
        found = ", ".join(f"{name} {value:.5g}" for name, value in verdict.finding.found.items())
        table.add_row(verdict.claim.key, verdict.claim.where, verdict.verdict, *([found] if wide else []))
    page.print(table)
    counts = collections.Counter(verdict.finding.outcome.value for verdict in result.claims)
    tally = ", ".join(f"{outcome} {count}" for outcome, count in counts.most_common())
    page.print(f"{len(result.claims)} claims in {result.seconds:.0f} s: {tally}.")
    page.print(f"Report: {result.report}", soft_wrap=True)
