"""`vibrocap friction`: which laws there are, what each is, what it does and asks of a solver; `vibrocap limits`."""

import inspect
from pathlib import Path
from typing import Annotated, Any

from cyclopts import App, Parameter
from rich.table import Table

from vibrocap.arguments import suggestion
from vibrocap.case.case import CaseError
from vibrocap.citations.bibliography import references
from vibrocap.cli.command_examples import examples_of
from vibrocap.cli.completers import completing, law_names, law_parameters
from vibrocap.cli.options import Refusal, refusing, writable_picture
from vibrocap.cli.parts import taking_parts
from vibrocap.cli.pictures import taking_page
from vibrocap.cli.terminal import OK, Page, parameters_in_words, progress, said, table
from vibrocap.io.motion_file import read_source
from vibrocap.physics.friction.law import Law
from vibrocap.physics.parameters import given_parameters
from vibrocap.physics.system import System
from vibrocap.quantities.dimensional import in_si, view
from vibrocap.quantities.json_text import json_text

friction = App(
    name="friction",
    help="Friction laws: which there are, their equations, canonical tests and reports.",
    help_epilogue=examples_of("friction"),
    default_parameter=Parameter(negative=()),
)
KINDS = {
    "set-valued": "sticks: at rest it holds any force up to its limit",
    "kinked": "dynamic: it remembers through internal states",
    "smooth": "smooth: a function of velocity that never sticks",
}
Settings = Annotated[list[str], Parameter(name="--set")]


@friction.command(name="list", help_epilogue=examples_of("friction list"))
@taking_parts
def list_laws() -> int:
    """The friction laws, a line each, and what can be put around them."""
    from vibrocap.physics.catalogue import laws, wrappers

    page = Page()
    width = max(map(len, laws())) + 2
    for name, law in laws().items():
        creeps = "creeps" if law.creeps else "does not creep"
        page.say(f"{name:<{width}}{inspect.cleandoc(law.__doc__ or '').splitlines()[0]}")
        page.say(f"{'':<{width}}{law.kind}; {creeps} under an oscillating force below break-away", style="dim")
    words = " and ".join(f"{word}-" for word in wrappers())
    page.say(f"\nBefore a name may stand {words}, as in backlash-anisotropic-lugre.")
    page.say("Next: vibrocap friction show lugre")
    return OK


@friction.command(help_epilogue=examples_of("friction show"))
@taking_parts
@taking_page
@completing(name=law_names, set_=law_parameters)
def show(name: str, /, *, set_: Settings = [], plot: Path | None = None) -> int:  # noqa: B006 (never changed)
    """One friction law: equations, parameters, source, passivity and time scales, and its picture.

    Parameters
    ----------
    name
        a law, as `vibrocap friction list` shows them
    set_
        NAME=VALUE in place of a default, such as bristle_stiffness=1e5; may be repeated
    plot
        draw steady curve and presliding loops: FILE.png, .svg or .pdf
    """
    from vibrocap.laboratory.passivity import passivity
    from vibrocap.laboratory.stiffness import stiffness_report

    law = _law(name, set_)
    writable_picture("--plot", plot)
    page = Page()
    page.say(f"{name}: {KINDS[law.kind]}", style="bold")
    page.say("\n" + inspect.cleandoc(type(law).__doc__ or ""))
    page.print()
    page.print(parameters_in_words(law))
    with progress(f"Looking for cycles of {name} that create energy"):
        passive = passivity(law)
        scales = stiffness_report(law)
    said = [each.text for each in references(type(law).source, law.name)] or ["not recorded"]
    page.say("\nsource     " + "\n           ".join(said))
    page.say(f"passivity  {passive.verdict}. {passive.condition}")
    page.say(f"stiffness  {scales.method}")
    creeps = "yes" if law.creeps else "no"
    page.say(f"creeps     {creeps}, under an oscillating force below break-away")
    if plot is not None:
        from vibrocap.plotting.laboratory import law_figure
        from vibrocap.plotting.look.finishing import save

        with progress(f"Drawing {name}"):
            page.say(f"picture    {save(law_figure(law), plot)}")
    return OK


@friction.command(name="test", help_epilogue=examples_of("friction test"))
@taking_parts
@taking_page
@completing(name=law_names, set_=law_parameters)
def canonical_tests(
    name: str,
    /,
    *,
    set_: Settings = [],  # noqa: B006 (never changed)
    load: float = 1.0,
    mass: float | None = None,
    stiffness: float | None = None,
    speed: float | None = None,
    plot: Path | None = None,
    json: bool = False,
) -> int:
    """The canonical tests of a friction law: presliding, lag, break-away, stick-slip, creep.

    Any consistent units will do; where the coefficients are forces, take --load 1.

    Parameters
    ----------
    name
        a law, as `vibrocap friction list` shows them
    set_
        NAME=VALUE in place of a default, such as bristle_stiffness=1e5; may be repeated
    load
        normal force on the contact
    mass
        mass of the block in the tests of break-away and stick-slip [default: from the law]
    stiffness
        stiffness of the spring that pulls the block [default: a hundredth of the contact's]
    speed
        speed at which the spring is pulled [default: 0.3 of the speed at which friction changes]
    plot
        draw all tests on one sheet: FILE.png, .svg or .pdf
    json
        print the numbers as JSON, in full precision
    """
    from vibrocap.laboratory.test_sheet import test_sheet

    law = _law(name, set_)
    writable_picture("--plot", plot)
    with progress(f"Testing {name}") as report, refusing("load", "mass", "stiffness", "speed"):
        sheet = test_sheet(
            law,
            load=load,
            mass=mass,
            stiffness=stiffness,
            speed=speed,
            progress=lambda now: report(0.0, f"Testing {name}: {now}"),
        )
    page = Page()
    if json:
        page.say(json_text(sheet))
    else:
        print_sheet(page, name, sheet)
    if plot is not None:
        from vibrocap.plotting.laboratory import sheet_figure
        from vibrocap.plotting.look.finishing import save

        save(sheet_figure(sheet), plot)
        if not json:
            page.say(f"  picture      {plot}")
    return OK


def print_sheet(page: Page, name: str, sheet: Any) -> None:
    """The summary of a test sheet."""
    slip, creep = sheet.stick_slip, sheet.creep
    page.say(f"Canonical tests of {name}, load {sheet.load:g}, in the units of its parameters", style="bold")
    for loop in sheet.presliding:
        page.print(f"  presliding   amplitude {loop.amplitude:.6g}: area {loop.area:.6g}, peak {loop.peak_force:.6g}")
    lag = sheet.lag  # width: accelerating less decelerating
    for frequency, width in zip(lag.frequency, lag.width, strict=True):
        page.print(f"  lag          frequency {frequency:.6g}: width {width:.6g}")
    found = sheet.break_away
    for rate, force, peaked in zip(found.rate, found.force, found.peaked, strict=True):
        page.print(f"  break-away   rate {rate:.6g}: {force:.6g}{'' if peaked else ' (friction has no peak)'}")
    words = f"period {slip.period:.6g}, sticking {slip.stick_time:.6g}" if slip.regime == "stick-slip" else "no cycle"
    words = f"period {slip.period:.6g}" if slip.regime == "oscillation" else words
    page.say(f"  stick-slip   {slip.regime}: {words}; friction up to {slip.static_force:.6g}")
    drift = f"{creep.drift_per_cycle:.3g} per cycle" if creep.creeps else "none"
    page.say(f"  creep        {drift}, under {creep.bias:.4g} +- {creep.amplitude:.4g}")


def _law(name: str, settings: list[str]) -> Law:
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
        raise Refusal(str(error)) from None
    known = [info.name for info in parameter_table(kind)]
    values: dict[str, float] = {}
    for setting in settings:
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
        raise Refusal(*(f"--set {each}" for each in error.complaints)) from None


def limits(case: Path, /, *, json: bool = False) -> int:
    """Limits of the friction of a case (the paper's eqs 10-15): exact, as the paper prints them, or why there are none.

    Parameters
    ----------
    case
        a case file (.toml), or a motion exported before (.nc, .csv)
    json
        print one JSON object in full precision instead of tables
    """
    from vibrocap.measures.recorded.limits import frictional_limits

    system = read_source(case).system
    try:
        plain = frictional_limits(system.friction, float(system.placed.loads()[0]))
    except (TypeError, ValueError) as error:
        raise CaseError([f"friction: {error}"], str(case)) from None
    found = in_si(plain, system)
    notes = beyond_friction(system, found.breakaway_force)
    if json:
        print(json_text(view(found) | ({"notes": notes} if notes else {})))
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
    at_rest = environment.push_at_rest(system.placed)
    push, unit = at_rest * system.result_units.factor("friction"), system.result_units.unit("friction")
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
    if any(value for name, value in given_parameters(environment).items() if "drag" in name):
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
