"""Tables of a motion: how it ends, how far it travels, its events, energy balance and certificate."""

from typing import TYPE_CHECKING, Any

from rich.table import Table

from vibrocap.cli.terminal import Page, table
from vibrocap.physics import events
from vibrocap.physics.dimensions.stated import parameters_stated
from vibrocap.physics.names import SIGNAL, name_and_number, numbered
from vibrocap.physics.parameters import brief, described, parameter_table
from vibrocap.physics.system import System
from vibrocap.quantities.declared import without_unit
from vibrocap.quantities.dimensional import computed

if TYPE_CHECKING:
    from vibrocap.motion.trajectory import Trajectory

# channel of energy: what it is
CHANNELS = {
    "drive": "work of the drive",
    "controller": "work of the controller",
    "damper": "work of the damper",
    "belt": "work of the belt under the block",
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
        signal = f"{name.removeprefix(SIGNAL)}: " if name.startswith(SIGNAL) else ""
        page.say(f"  {signal}{in_words(name, motion.system)}", style="dim")
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
    made = table("Motion", "quantity", "value", "what it rests on")
    periods = f"{plain.end / plain.period:.6g} of {motion.periods:.6g} drive periods T = {period}"
    made.add_row("time reached", f"{record['time']:.10g}", periods)
    for name, value in record["state"].items():
        made.add_row(name.replace("_", " "), f"{value:.10g}", "at the end")
    made.add_section()
    if record["drift"] is not None:
        made.add_row("drift", f"{record['drift']:.10g}", "travel in the last whole period")
        velocity = record["mean_velocity"]
        start, end = (without_unit(mark) / motion.period for mark in velocity["window"])
        count = round(end - start)
        settled = "settled" if velocity["settled"] else "NOT settled: a longer run gives another value"
        window = f"mean over the last {count} periods, {start:.6g} T to {end:.6g} T; {settled}"
        made.add_row("mean velocity", f"{velocity['value']:.10g}", window)
        if (cost := record["cost_of_transport"]) is not None:
            words = "work of the drive per distance travelled, over the same periods"
            made.add_row("cost of transport", f"{cost:.10g}", words)
        for name, turns in (record["winding"] or {}).items():
            made.add_row(f"turns of {name}", f"{turns:.9g}", "in the last whole period")
        made.add_row("response", *_response(motion))
    if (least := record["least_reaction"]) is not None:
        words = "of the ground in the whole run; below 0 the machine would have lifted off"
        made.add_row("least reaction", f"{least:.10g}", words)
    for i, law in enumerate(motion.system.laws, 1):
        name = numbered("stick_fraction", i)
        if record[name] is not None:
            made.add_row(name.replace("_", " "), f"{record[name]:.6g}", "share of the whole run at rest")
        elif law.kind != "set-valued":
            made.add_row(name.replace("_", " "), "none", f"the {law.name} law creeps instead of sticking")
    made.add_section()
    for kind, count in record["events"].items():
        stem, number = name_and_number(kind)
        words = (events.MEANINGS | events.ADDED).get(kind, "this happens")
        if number > 1 and stem in events.MEANINGS:
            words = events.MEANINGS[stem].replace("the contact", f"contact {number}")
        if count:
            made.add_row(kind.replace("_", " "), str(count), f"times {words}")
    return made


def _response(motion: "Trajectory") -> tuple[str, str]:
    """(class of the response, what that rests on)."""
    from vibrocap.measures.recorded.response import response_class

    response = response_class(computed(motion))
    if response.residual is None:
        return response.kind, "fewer than two whole periods"
    symmetry = {True: "; its own mirror image, so it cannot travel", False: "; differs from its mirror image", None: ""}
    return response.kind, f"modulo the drift, to {response.residual:.1e}{symmetry[response.symmetric]}"


def _energy_table(energy: dict[str, Any]) -> Table:
    start, end = (f"{mark:.6g}" for mark in energy["window"])
    made = table(f"Energy from {start} to {end}", "channel", "value", "meaning")
    own = energy.get("own", {})
    for name, text in ({name: f"work of {name.replace('_', ' ')}" for name in own} | CHANNELS).items():
        work = (energy | own).get(name)
        if work is None or (name in ("damper", "belt", "impact", "contact_storage") and without_unit(work) == 0.0):
            continue
        made.add_row(name.replace("_", " "), f"{work:{'.1e' if name == 'residual' else '.10g'}}", text)
    return made


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
    made = table("Certificate", "evidence", "value", "at most", "verdict", "meaning")
    verdicts = {verdict["field"]: verdict for verdict in certificate["verdicts"]}
    for field, meaning in CERTIFICATE.items():
        if (verdict := verdicts.get(field)) is None:
            continue
        bound = "" if verdict["bound"] is None else f"{verdict['bound']:.1e}"
        word = "" if verdict["bound"] is None else "pass" if verdict["ok"] else "FAIL"
        value = verdict["value"]
        if field == "stick_force_ratio":
            value, bound = f"{value:.6g}", "1"
        made.add_row(field.replace("_", " "), value if isinstance(value, str) else f"{value:.1e}", bound, word, meaning)
    made.add_section()
    verdict = ("passed", "") if certificate["ok"] else ("FAILED", "see below")
    made.add_row("all of it", "", "", *verdict)
    steps = f"{certificate['taylor_steps']} + {certificate['implicit_steps']}"
    made.add_row("steps", steps, "", "", "Taylor + implicit")
    return made


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
