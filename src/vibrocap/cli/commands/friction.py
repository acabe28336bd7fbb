"""`vibrocap friction`: what a friction law is and does, its canonical tests, and the limits of a case's friction."""

import inspect
from pathlib import Path
from typing import Any

from rich.table import Table

from vibrocap.arguments import ArgumentError, Refusal, suggestion
from vibrocap.citations.bibliography import references
from vibrocap.cli import completers
from vibrocap.cli.command import Answer, Drawn, Report, WithParts, command
from vibrocap.cli.options import JSON, option, picture, required
from vibrocap.cli.terminal import Page, parameters_in_words, said, table
from vibrocap.io.motion_file import read_source
from vibrocap.physics.friction.law import Law
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
    listing = table("Limits", "limit", "value", "meaning")
    bristles = "" if limits.deflection_limit is None else ": approached, not reached, by bristles"
    for name, value, unit, meaning in (
        ("breakaway force", limits.breakaway_force, force, f"N eta_s{bristles}"),
        ("Coulomb force", limits.coulomb_force, force, "N eta_c"),
        ("deflection limit", limits.deflection_limit, length, "g(0), eq. 10: |xi| never exceeds it"),
        ("boundary velocity", limits.boundary_velocity, speed, BOUNDARY),
    ):
        if value is not None:
            listing.add_row(name, said(value, unit, 12), meaning)
    page.print(listing)
    damper = f"{force} s/m" if force else ""
    curve = table("Steady sliding (eqs 11, 12)", "velocity", "friction", "slope")
    for point in limits.curve:
        curve.add_row(said(point.velocity, speed, 6), said(point.friction, force), said(point.slope, damper))
    page.print(curve)
    if limits.offset is not None:
        page.print(_offset_table(limits.offset, speed, damper))


def _offset_table(offset: Any, speed: str, damper: str) -> Table:
    listing = table("Offset points, where the steady curve is level (eqs 13-15)", "point", "value", "meaning")
    if offset.exist:
        listing.add_row("lower, exact", said(offset.lower, speed, 15), "of eq. 13; for exponent 2 Lambert's W")
        listing.add_row("upper, exact", said(offset.upper, speed, 15), "likewise")
    else:
        listing.add_row("exact", "none", offset.reason)
    printed = {"lower, as printed": offset.printed_lower, "upper, as printed": offset.printed_upper.value}
    for (name, value), equation in zip(printed.items(), ("eq. 14", "eq. 15"), strict=True):
        listing.add_row(name, "none" if value is None else said(value, speed, 15), equation)
    upper = offset.corrected_upper.value
    corrected = "none" if upper is None else said(upper, speed, 15)
    listing.add_row("upper, eq. 15 corrected", corrected, "any exponent (erratum 4)")
    if offset.greatest_viscous_damping is not None:
        greatest = said(offset.greatest_viscous_damping, damper)
        listing.add_row("largest delta2", greatest, "above it there are no offset points")
    return listing


KINDS = {
    "set-valued": "sticks: at rest it holds any force up to its limit",
    "kinked": "dynamic: it remembers through internal states",
    "smooth": "smooth: a function of velocity that never sticks",
}
OF_CASE = (".toml", ".nc", ".csv")


class FrictionRequest(WithParts, Drawn):
    name: str = required(
        "a law, see `vibrocap list laws`, or a case file (.toml, .nc, .csv)",
        offers=completers.law_names,
        place=True,
    )
    tests: bool = option("run the canonical tests of the law", False)
    set_: list[str] | None = option(
        "NAME=VALUE in place of a default of the law; may be repeated", offers=completers.law_parameters
    )
    plot: Path | None = picture("steady curve and presliding loops of a law, or all its tests")
    json: bool = JSON
    load: float = option("normal force on the contact", 1.0, advanced=True)
    mass: float | None = option("of the block in the tests [default: from the law]", needs="tests", advanced=True)
    stiffness: float | None = option(
        "of the spring that pulls it [default: 0.01 of the contact's]", needs="tests", advanced=True
    )
    speed: float | None = option(
        "of the spring [default: 0.3 of the speed at which friction changes]", needs="tests", advanced=True
    )


@command(
    "data",
    "vibrocap friction lugre --plot lugre.png",
    "vibrocap friction dahl --set bristle_stiffness=1e3",
    "vibrocap friction coulomb --tests --plot tests.png",
    "vibrocap friction examples/bristles-lugre.toml",
    "vibrocap friction examples/bristles-with-offset-points.toml --json",
    doing="{name}",
)
def friction(request: FrictionRequest, report: Report) -> Answer:
    """A friction law, its tests, or the limits in a case.

    Of a law: its equations, parameters, source, passivity and time scales. With --tests: presliding, lag, break-away,
    stick-slip and creep, in any consistent units; where the coefficients are forces, with --load 1. Of a case: the
    limits of its friction (the paper's eqs 10-15), exact and as the paper prints them, or why there are none.
    """
    if request.name.endswith(OF_CASE):
        for option, value in (("--set", request.set_), ("--tests", request.tests), ("--plot", request.plot)):
            if value:
                raise Refusal(f"{option}: should be left out with a case; name a law")
        system = read_source(Path(request.name)).system
        result, record, notes = limits_of(system)
        units = ("N", "m/s", "m") if system.units is not None else ()

        def text(page: Page) -> None:
            for name, limits in result.items():
                print_limits(page, name, limits, *units)
            for note in notes:
                page.say(f"Note: {note}")

        return Answer(record, text)
    law = _law(request.name, request.set_)
    return _tests(request, law, report) if request.tests else _sheet(request, law)


def _sheet(request: FrictionRequest, law: Law) -> Answer:
    """What a law is, whether it is passive, and what it asks of a solver."""
    from vibrocap.laboratory.passivity import passivity
    from vibrocap.laboratory.stiffness import stiffness_report

    passive, scales = passivity(law), stiffness_report(law)
    source = [reference.text for reference in references(type(law).source, law.name)] or ["not recorded"]
    rows = [
        ("source", "\n           ".join(source)),
        ("passivity", f"{passive.verdict}. {passive.condition}"),
        ("stiffness", scales.method),
        ("creeps", f"{'yes' if law.creeps else 'no'}, under an oscillating force below break-away"),
    ]

    def text(page: Page) -> None:
        page.say(f"{request.name}: {KINDS[law.kind]}", style="bold")
        page.say("\n" + inspect.cleandoc(type(law).__doc__ or "") + "\n")
        page.print(parameters_in_words(law))
        page.say("\n" + "\n".join(f"{name:<11}{words}" for name, words in rows))

    record = {"law": request.name, "kind": law.kind, "parameters": given_parameters(law), "creeps": law.creeps}
    return Answer(record | {"source": source, "passive": str(passive.verdict), "stiffness": scales.method}, text, law)


def _tests(request: FrictionRequest, law: Law, report: Report) -> Answer:
    from vibrocap.laboratory.test_sheet import test_sheet

    settings = request.given("load", "mass", "stiffness", "speed")
    sheet = test_sheet(law, progress=lambda now: report(0.0, f"Testing {request.name}: {now}"), **settings)
    return Answer(sheet, lambda page: print_sheet(page, request.name, sheet), sheet)


def print_sheet(page: Page, name: str, sheet: Any) -> None:
    """The summary of a test sheet."""
    slip, creep = sheet.stick_slip, sheet.creep
    page.say(f"Canonical tests of {name}, load {sheet.load:g}, in the units of its parameters", style="bold")
    for loop in sheet.presliding:
        page.print(f"  presliding   amplitude {loop.amplitude:.6g}: area {loop.area:.6g}, peak {loop.peak_force:.6g}")
    for frequency, width in zip(sheet.lag.frequency, sheet.lag.width, strict=True):  # accelerating less decelerating
        page.print(f"  lag          frequency {frequency:.6g}: width {width:.6g}")
    parts = sheet.break_away.rate, sheet.break_away.force, sheet.break_away.peaked
    for rate, force, peaked in zip(*parts, strict=True):
        page.print(f"  break-away   rate {rate:.6g}: {force:.6g}{'' if peaked else ' (friction has no peak)'}")
    words = f"period {slip.period:.6g}, sticking {slip.stick_time:.6g}" if slip.regime == "stick-slip" else "no cycle"
    words = f"period {slip.period:.6g}" if slip.regime == "oscillation" else words
    page.say(f"  stick-slip   {slip.regime}: {words}; friction up to {slip.static_force:.6g}")
    drift = f"{creep.drift_per_cycle:.3g} per cycle" if creep.creeps else "none"
    page.say(f"  creep        {drift}, under {creep.bias:.4g} +- {creep.amplitude:.4g}")


def _law(name: str, settings: "list[str] | None") -> Law:
    """The law of that name with the parameters set; refused with the nearest name and every bad value."""
    from vibrocap.physics.catalogue import law, laws, wrappers
    from vibrocap.physics.parameters import ParameterError, parameter_table

    try:
        kind = law(name)
    except KeyError:
        plain = name
        for word in wrappers():
            plain = plain.replace(f"{word}-", "")
        raise Refusal(f"no friction law is called {name!r}; {suggestion(plain, laws(), cutoff=0.0)}") from None
    except ValueError as error:
        raise Refusal(f"NAME: {error}") from None
    known = [info.name for info in parameter_table(kind)]
    values: dict[str, float] = {}
    for setting in settings or ():
        path, equals, text = setting.partition("=")
        if not equals:
            raise Refusal(f"--set should be NAME=VALUE, such as {known[0]}=1.0, got {setting!r}")
        if path not in known:
            near = suggestion(path, known, cutoff=0.0)
            raise Refusal(f"--set {setting}: {name} has no parameter {path!r}; {near}")
        try:
            values[path] = float(text)
        except ValueError:
            raise Refusal(f"--set {setting}: {text!r} should be a number") from None
    try:
        return kind(**values)
    except ParameterError as error:
        raise Refusal(*(f"--set {complaint}" for complaint in error.complaints)) from None
