"""Presets of a page: cases with a name and a few words, and the numbers by which the page is checked."""

import dataclasses
import re
from pathlib import Path
from typing import Any

from vibrocap.case.case import Case, read_case
from vibrocap.motion.recording.equations import equations, parameter_values
from vibrocap.motion.simulate import initial_state
from vibrocap.numerics.api import Budget, Form, MotionStart, recorded_run
from vibrocap.paper.presets import figures_5_to_8, figures_9_to_11, start
from vibrocap.physics.parameters import parameter_table
from vibrocap.physics.system import System

GALLERY = (
    *("travels-by-stick-slip", "mirror-twin", "biharmonic-drive-travels", "phase-reverses-travel"),
    *("symmetric-no-travel", "light-capsule-travels-fast", "slow-drive-mostly-sticks", "never-leaves-stick"),
    *("buckled-pendulum-travels", "bristles-with-offset-points"),
)
LONGEST = 2000  # periods of a preset: a page keeps every piece of a motion


@dataclasses.dataclass(frozen=True)
class Preset:
    """A case of a page. key: in its address; title: in its list; note: what to look at."""

    key: str
    title: str
    note: str
    case: Case

    @property
    def parts(self) -> tuple[str, str, str]:
        """Names of machine, law and drive."""
        system = self.case.system
        return system.machine.name, system.friction.name, system.drive.name


def paper_presets() -> list[Preset]:
    """The systems of the paper's figures of motion, on both laws."""
    presets = []
    for key, figures, figures_of in (("5-8", "Figs 5-8", figures_5_to_8), ("9-11", "Figs 9-11", figures_9_to_11)):
        for law, words in (("exponential", "exponential law (EM)"), ("lugre", "LuGre law (LM)")):
            system = figures_of(law)
            note = f"The machine of the paper's {figures} on the {words}, from the paper's start."
            case = Case(system, start(system), periods=40)
            presets.append(Preset(f"paper-{key}-{law}", f"Paper, {figures}, {law}", note, case))
    return presets


def gallery(folder: Path) -> list[Preset]:
    """Cases of the gallery of examples, by their files; those that are not there are left out."""
    return [file_preset(folder / f"{name}.toml") for name in GALLERY if (folder / f"{name}.toml").is_file()]


def defaults(system: System, tolerance: float) -> Preset:
    """A system with its default numbers, from a small push where there is room for one."""
    state = system.state_names[0]
    start = {} if state in system.placed.room() else {state: 0.5}
    title = f"{system.machine.name}, defaults".replace("-", " ").capitalize()
    return Preset(f"defaults-{system.machine.name}", title, "", Case(system, start, tolerance=tolerance))


def file_preset(path: Path) -> Preset:
    """The case in a file, with the first words of its comment. Raises CaseError for what is no case."""
    case = read_case(path)
    text = path.read_text(encoding="utf-8-sig") if path.is_file() else ""  # of a pipe all was read
    head = re.match(r"(?:#[^\n]*\n)*", text.replace("\r\n", "\n"))
    lines = [line[1:].strip().replace("`", "") for line in (head[0] if head else "").splitlines()]
    paragraphs = [" ".join(paragraph.split()) for paragraph in "\n".join(lines).split("\n\n")]
    sentences = (re.sub(r"[^.]*$", "", paragraph) for paragraph in paragraphs if not paragraph.startswith("vibrocap "))
    note = " ".join(filter(None, sentences))  # without how it is run
    return Preset(path.stem, path.stem.replace("-", " ").capitalize(), note, case)


def preset_record(preset: Preset) -> dict[str, Any]:
    """A preset as a page has it: the values that are numbers, how it runs, and its checked end."""
    case = preset.case
    values, words = {}, {}
    for part, record in case.system.parts.items():
        for info in parameter_table(record):
            value = getattr(record, info.name)
            number = isinstance(value, (int, float)) and not isinstance(value, bool)
            (values if number else words)[f"{part}.{info.name}"] = value
    scales = case.system.units or case.scales
    return {
        "key": preset.key,
        "title": preset.title,
        "note": preset.note,
        "parts": list(preset.parts),
        "values": values,
        "words": words,
        "initial": {name: float(case.initial.get(name, 0.0)) for name in case.system.state_names},
        "periods": case.periods,
        "tolerance": case.tolerance,
        "units": "none" if case.system.units is None else "SI",
        "scales": None if scales is None else list(scales.units),
        "check": end_of(case),
    }


def end_of(case: Case) -> dict[str, Any]:
    """The end of the motion to the last bit of the plain kernel, which is what a page computes."""
    system, start = case.system, initial_state(case.system, case.initial)
    begin = MotionStart(equations(system), parameter_values(system), list(start.values()), system.drive.period)
    motion = recorded_run(begin, Budget(**case.run), Form(literal=True))
    counts = {"events": len(motion.events), "pieces": len(motion.pieces), "status": motion.status}
    return {"state": motion.final.tolist()} | counts
