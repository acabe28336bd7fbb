"""`vibrocap simulate`: one motion of a case."""

import functools
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from rich.table import Table

from vibrocap.arguments import Complaints, Refusal, by_option
from vibrocap.case.case import Case, CaseError
from vibrocap.cli.command import Answer, Drawn, OfCase, Report, command
from vibrocap.cli.completers import paths_of_case, states_of_case
from vibrocap.cli.options import JSON, TOLERANCE, option, picture, with_headings, writable_film, writable_table
from vibrocap.cli.terminal import Page, progress, said, table
from vibrocap.cli.texts import changes, split
from vibrocap.io.motion_file import read_source, write_motion
from vibrocap.physics import events
from vibrocap.physics.dimensions.stated import brief, described, parameters_stated
from vibrocap.physics.names import name_and_number, numbered, owner_of
from vibrocap.physics.parameters import parameter_table
from vibrocap.physics.system import System
from vibrocap.quantities.declared import without_unit
from vibrocap.quantities.dimensional import computed, in_si, view

if TYPE_CHECKING:
    from vibrocap.motion.trajectory import Trajectory

# channel of energy: what it is
CHANNELS = {
    "drive": "work of the drive",
    "controller": "work of the controller",
    "damper": "work of the damper",
    "belt": "work of belts and of what else moves by itself",
    "impact": "loss in impacts",
    "drag": "work of the drag of the surroundings",
    "outer_force": "work of the force from outside",
    "gravity": "work of gravity along the slope",
    "contact_sliding": "work of sliding friction",
    "bristle_loss": "loss in the bristles",
    "contact_storage": "bristles under a changing load",
    "stored": "gained by machine and contact",
    "residual": "stored less all works: should vanish",
}


def print_motion(page: Page, motion: "Trajectory", record: dict[str, Any], title: str) -> None:
    """The summary of `vibrocap simulate`; record: the view of it."""
    page.say(title, style="bold")
    for name in motion.system.parts:
        owner = owner_of(name, motion.system.parts)
        page.say(f"  {owner}{': ' * bool(owner)}{in_words(name, motion.system)}", style="dim")
    page.print(_motion_table(motion, record))
    if record["energy"]:
        page.print(_energy_table(record["energy"]))
    if certificate := record["certificate"]:
        page.print(_certificate_table(certificate))
        for warning in certificate["warnings"]:
            page.say(f"Warning: {warning}", style="bold")
    units = "All quantities are dimensionless: lengths in l, time in sqrt(l/g), forces in mg."
    if motion.si_context() is not None:
        units = "Quantities are in SI; the certificate is of the motion as it was computed, without units."
    elif "pendulum_length_m" not in {info.name for info in parameter_table(motion.system.machine.si_scales)}:
        units = "All quantities are in the units of the parameters."
    page.say(units, style="dim")


def _motion_table(motion: "Trajectory", record: dict[str, Any]) -> Table:
    period, plain = motion.said("period", 8), computed(motion)
    listing = table("Motion", "quantity", "value", "basis")
    periods = f"{plain.end / plain.period:.6g} of {motion.periods:.6g} drive periods T = {period}"
    listing.add_row("time reached", f"{record['time']:.10g}", periods)
    for name, value in record["state"].items():
        listing.add_row(name.replace("_", " "), f"{value:.10g}", "at the end")
    listing.add_section()
    if record["drift"] is not None:
        listing.add_row("drift", f"{record['drift']:.10g}", "travel in the last whole period")
        velocity = record["mean_velocity"]
        start, end = (without_unit(mark) / motion.period for mark in velocity["window"])
        count = round(end - start)
        settled = "settled" if velocity["settled"] else "NOT settled: a longer run gives another value"
        window = f"mean over the last {count} periods, {start:.6g} T to {end:.6g} T; {settled}"
        listing.add_row("mean velocity", f"{velocity['value']:.10g}", window)
        if (cost := record["cost_of_transport"]) is not None:
            words = "work of the drive per distance travelled, over the same periods"
            listing.add_row("cost of transport", f"{cost:.10g}", words)
        for name, turns in (record["winding"] or {}).items():
            listing.add_row(f"turns of {name}", f"{turns:.9g}", "in the last whole period")
        listing.add_row("response", *_response(motion))
    if (least := record["least_reaction"]) is not None:
        words = "of the ground in the whole run; below 0 the machine would have lifted off"
        listing.add_row("least reaction", f"{least:.10g}", words)
    for i, law in enumerate(motion.system.laws, 1):
        name = numbered("stick_fraction", i)
        if record[name] is not None:
            listing.add_row(name.replace("_", " "), f"{record[name]:.6g}", "share of the whole run at rest")
        elif law.kind != "set-valued":
            listing.add_row(name.replace("_", " "), "none", f"the {law.name} law creeps instead of sticking")
    listing.add_section()
    for kind, count in record["events"].items():
        stem, number = name_and_number(kind)
        words = (events.MEANINGS | events.ADDED).get(kind, "this happens")
        if number > 1 and stem in events.MEANINGS:
            words = events.MEANINGS[stem].replace("the contact", f"contact {number}")
        if count:
            listing.add_row(kind.replace("_", " "), str(count), f"times {words}")
    return listing


def _response(motion: "Trajectory") -> tuple[str, str]:
    """(class of the response, what that rests on)."""
    from vibrocap.measures.recorded.settling import response_class

    response = response_class(computed(motion))
    if response.residual is None:
        return response.kind, "fewer than two whole periods"
    symmetry = {True: "; its own mirror image, so it cannot travel", False: "; differs from its mirror image", None: ""}
    return response.kind, f"modulo travel, to {response.residual:.1e}{symmetry[response.symmetric]}"


def _energy_table(energy: dict[str, Any]) -> Table:
    start, end = (f"{mark:.6g}" for mark in energy["window"])
    listing = table(f"Energy from {start} to {end}", "channel", "value", "meaning")
    own = energy.get("own", {})
    for name, text in ({name: f"work of {name.replace('_', ' ')}" for name in own} | CHANNELS).items():
        work = (energy | own).get(name)
        if work is None or (name in ("damper", "belt", "impact", "contact_storage") and without_unit(work) == 0.0):
            continue
        listing.add_row(name.replace("_", " "), f"{work:{'.1e' if name == 'residual' else '.10g'}}", text)
    return listing


CERTIFICATE = {
    "stick_force_ratio": "|R|/(N eta_s) while stuck",
    "slip_shortfall": "missing of N eta_s at a slip",
    "event_velocity": "|v| at a located event",
    "least_velocity": "v against its side",
    "energy_residual": "energy less all works",
    "momentum_residual": "momentum less impulses",
    "defect": "residual of the equations",
    "estimated_error": "of states: a tighter run",
}


def _certificate_table(certificate: dict[str, Any]) -> Table:
    listing = table("Certificate", "evidence", "value", "at most", "verdict", "meaning")
    verdicts = {verdict["field"]: verdict for verdict in certificate["verdicts"]}
    for field, meaning in CERTIFICATE.items():
        if (verdict := verdicts.get(field)) is None:
            continue
        bound = "" if verdict["bound"] is None else f"{verdict['bound']:.1e}"
        word = "" if verdict["bound"] is None else "pass" if verdict["ok"] else "FAIL"
        value = verdict["value"]
        if field == "stick_force_ratio":
            value, bound = f"{value:.6g}", "1"
        listing.add_row(
            field.replace("_", " "), value if isinstance(value, str) else f"{value:.1e}", bound, word, meaning
        )
    listing.add_section()
    verdict = ("passed", "") if certificate["ok"] else ("FAILED", "see below")
    listing.add_row("all of it", "", "", *verdict)
    steps = f"{certificate['taylor_steps']} + {certificate['implicit_steps']}"
    listing.add_row("steps", steps, "", "", "Taylor + implicit")
    return listing


def in_words(name: str, system: System, digits: int = 6) -> str:
    """A part in a line, in SI where the system knows its scales: its name, and each parameter with its unit."""
    part = system.parts[name]
    if system.units is None:
        return described(part, digits)
    words = [
        " ".join((parameter.stem, brief(parameter.value, digits), *([parameter.unit] if parameter.unit != "1" else [])))
        for parameter in parameters_stated(name, system)
    ]
    return f"{part.name}: {', '.join(words)}"


class SimulateRequest(OfCase, Drawn):
    out: Path | None = option(
        "export the motion, with its case, to FILE.nc (NetCDF), FILE.csv, FILE.xlsx (Excel) or FILE.mat (MATLAB)",
        check=lambda name, path: writable_table(name, path, "xarray"),
    )
    plot: Path | None = picture("time histories, phase planes and the friction loop")
    animate: Path | None = option(
        "a film of the last periods: FILE.mp4 (needs ffmpeg) or FILE.gif", check=writable_film
    )
    set_: list[str] | None = option(
        "PATH=VALUE in place of the case's, such as machine.mass_ratio=2 or friction.law=lugre; may be repeated",
        offers=paths_of_case,
    )
    initial: list[str] | None = option(
        "NAME=VALUE in place of the case's initial condition, such as angle=0.5; may be repeated", offers=states_of_case
    )
    periods: float | None = option("drive periods to run [default: the case's]")
    json: bool = JSON
    cite: Literal["text", "bibtex"] | None = option("print the works to cite for the case, instead of a motion")
    tolerance: float | None = TOLERANCE()
    unit_headings: bool = option(
        'name and unit in the headings of .csv and .xlsx, as in "position [m]"', False, advanced=True
    )
    analyses: list[str] | None = option(
        "with --cite, commands that were used too, such as orbit,fit", needs="cite", advanced=True
    )

    @functools.cached_property
    def changes(self) -> tuple[dict[str, tuple[str, Any]], Complaints]:
        """The values that the options replace in the case, by path with the option, and complaints about them."""
        refused = Complaints()
        changed = changes(self.set_, self.initial, refused)
        settings = self.given("periods", "tolerance")
        return changed | {f"run.{name}": (f"--{name}", value) for name, value in settings.items()}, refused

    @functools.cached_property
    def setup(self) -> Case:
        """The case with the values that the options replace."""
        changed, refused = self.changes
        try:
            setup = read_source(self.case, {path: value for path, (_, value) in changed.items()})
        except CaseError as error:
            named = by_option(error.complaints, {path: option for path, (option, _) in changed.items()})
            raise CaseError([*named, *refused], error.source) from None
        if refused:
            raise Refusal(*refused)
        return setup

    def plan(self, refused: Complaints) -> None:
        """Units stand in headings of files that have some."""
        with_headings(self.out, self.unit_headings, "--out")


@command(
    "run",
    "vibrocap simulate case.toml --initial angle=0.5",
    "vibrocap simulate examples/travels-by-stick-slip.toml --plot run.png",
    "vibrocap simulate examples/bristles-lugre.toml --json --out run.nc",
    "vibrocap simulate run.nc --set machine.mass_ratio=1.5 --periods 20",
    "vibrocap simulate examples/bristles-lugre.toml --cite bibtex --analyses orbit,fit",
    doing="Simulating",
)
def simulate(request: SimulateRequest, report: Report) -> Answer:
    """One motion: travel, events, energy and certificate.

    The report has the end of the run, its travel, events, energy balance and certificate.

    Exit code 3: the run could not be completed, or its certificate failed.
    """
    from vibrocap.measures.recorded.summary import motion_summary

    setup = request.setup
    if request.cite is not None:
        from vibrocap.citations.cite import cite

        works = cite(setup, analyses=split(request.analyses))
        return Answer({"cite": str(works)}, str(works) if request.cite == "text" else works.bibtex.rstrip())
    motion = setup.simulate(report)
    record: dict[str, Any] = {}
    for name, value in view(in_si(motion_summary(computed(motion)), motion.system)).items():
        record |= value if name == "sticking" else {name: value}
    written = []
    if request.out is not None:
        write_motion(motion, request.out, setup, unit_headings=request.unit_headings)
        written.append(("motion", request.out))
    moved = len(motion.piece_start) > 0
    if request.animate is not None and moved:
        from vibrocap.plotting.animation import animate_motion

        with progress("Filming") as share:
            animate_motion(computed(motion), request.animate, progress=share)
        written.append(("film", request.animate))
    incomplete = ""
    if not motion.status.ok and motion.run_status.ok:
        incomplete = "\n".join([motion.status.text, *motion.certificate.failures])
    elif not motion.status.ok:
        end = said(motion.periods * motion.period, motion.unit_of("period"))
        state = f", {motion.facts['end']}" if "last state" in motion.status.text else ""
        where = f"it stopped at time {motion.said('end')} of {end}{state}.\n{motion.status.text}"
        incomplete = f"The run could not be completed ({motion.status.value}): {where}"
        incomplete += "" if moved or not (request.plot or request.animate) else "\nThere is nothing to draw."
    drawn = computed(motion) if moved else None
    title = str(request.case)
    text = functools.partial(print_motion, motion=motion, record=record, title=title)
    return Answer(record, text, drawn, written=tuple(written), incomplete=incomplete)
