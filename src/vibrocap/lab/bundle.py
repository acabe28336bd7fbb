"""The data of a page, as plain data for JSON: forms with their kernels, records of parts, and presets.

A preset is a case with a name and a few words, and the numbers by which the page is checked.
"""

import base64
import contextlib
import dataclasses
import itertools
import re
import zlib
from collections.abc import Callable, Iterable, Mapping, Sequence
from importlib.metadata import version
from pathlib import Path
from typing import Any

from vibrocap.arguments import ArgumentError
from vibrocap.case.case import RUN_DEFAULTS, Case, read_case
from vibrocap.case.sections import kind_key
from vibrocap.lab.controls import part_record
from vibrocap.lab.forms import TOLERANCE, Form, form_of, statuses
from vibrocap.motion.recording.equations import equations, parameter_values
from vibrocap.motion.simulate import initial_state
from vibrocap.numerics import api
from vibrocap.paper.presets import figures_5_to_8, figures_9_to_11, start
from vibrocap.physics.catalogue import drives, laws, machines
from vibrocap.physics.dimensions.carry_over import carried, carried_names
from vibrocap.physics.dimensions.units import effort_of
from vibrocap.physics.parameters import ParameterError, parameter_table
from vibrocap.physics.system import OPTIONAL, System

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
    begin = api.MotionStart(equations(system), parameter_values(system), list(start.values()), system.drive.period)
    motion = api.recorded_run(begin, api.Budget(**case.run), api.Form(literal=True))
    counts = {"events": len(motion.events), "pieces": len(motion.pieces), "status": motion.status}
    return {"state": motion.final.tolist()} | counts


MACHINES, LAWS, DRIVES = ("pendulum-capsule",), ("exponential", "lugre"), ("harmonic", "biharmonic")
SMOOTHED = "smoothed-"  # before the name of a set-valued law: what a smoothed contact would say, beside the exact one
LAYOUT = 1  # of the data: a page refuses an address that was made for another


@dataclasses.dataclass(frozen=True)
class Contents:
    """What a page is to hold.

    forms: one system of each form, the parameters that are no numbers as in the system; presets: the first one is shown
    tolerance: of motions, which decides the order of their series
    """

    forms: tuple[System, ...]
    presets: tuple[Preset, ...]
    tolerance: float = TOLERANCE


def contents(
    opened: Preset | None = None,
    *,
    machine_names: Sequence[str] = (),
    law_names: Sequence[str] = (),
    drive_names: Sequence[str] = (),
    examples: Path | None = None,
) -> Contents:
    """The forms and presets of a page; by default the pendulum capsule, both laws of the paper and two drives.

    opened: a case to begin with, whose parts are there in any case; examples: folder of the gallery
    Raises ArgumentError for a case that is too long for a page.
    """
    if opened is not None and opened.case.periods > LONGEST:
        raise ArgumentError("run.periods", f"should be at most {LONGEST} for a page, got {opened.case.periods:g}")
    own = None if opened is None else opened.case.system
    kinds = [
        _names(machine_names, own and own.machine.name, () if own else MACHINES),
        [*_names(law_names, own and own.friction.name, LAWS)],
        _names(drive_names, own and own.drive.name, DRIVES),
    ]
    smoothed = [f"{SMOOTHED}{name}" for name in kinds[1] if laws()[name].kind == "set-valued"]
    kinds[1] += [name for name in smoothed if name not in kinds[1]]
    systems = [] if own is None else [own]
    for names in itertools.product(*kinds):
        if names[1] in smoothed and names[2] != kinds[2][0]:
            continue  # with the first drive only: a page is to stay small
        if own is not None and names == (own.machine.name, own.friction.name, own.drive.name):
            continue
        machine = type(own.machine) if own is not None and names[0] == own.machine.name else machines()[names[0]]
        classes = machine, laws()[names[1]], drives()[names[2]]
        with contextlib.suppress(ArgumentError):  # a law that the machine of the case does not take
            kept: Any = {} if own is None else {part: getattr(own, part) for part in OPTIONAL}
            before = (None,) * 3 if own is None else (own.machine, own.friction, own.drive)
            systems.append(System(*map(_in_place_of, before, classes), **kept))
    offered = [*([] if opened is None else [opened]), *paper_presets()]
    offered += [] if examples is None else [preset for preset in gallery(examples) if preset.key != offered[0].key]
    forms, tolerance = {_key(system) for system in systems}, TOLERANCE if opened is None else opened.case.tolerance
    order = api.series_order(tolerance)
    known = [form for form in offered if _key(form.case.system) in forms]
    presets = [preset for preset in known if api.series_order(preset.case.tolerance) == order]
    for system in systems:
        if all(preset.parts[0] != system.machine.name for preset in presets):  # it begins with its defaults
            presets.append(defaults(system, tolerance))
    return Contents(tuple(systems), tuple(presets), tolerance)


def _in_place_of(part: Any, kind: type) -> Any:
    """A part of that kind with what it takes over from another, as far as its own rules let it."""
    if type(part) is kind:
        return part
    try:
        return kind(**({} if part is None else carried(part, kind)))
    except ParameterError:  # numbers, which the page has from the case itself; they decide no form
        return kind()


def _carried(parts: Mapping[str, Mapping[str, type]]) -> dict[str, Any]:
    """By section and kind, from which other kind it takes what: {parameter: the other's parameter}."""
    return {
        section: {a: {b: dict(carried_names(x, y)) for b, x in kinds.items() if b != a} for a, y in kinds.items()}
        for section, kinds in parts.items()
    }


def _names(asked: Iterable[str], own: str | None, usual: Iterable[str]) -> list[str]:
    """Names without repetition: the case's own first, then those asked for, or the usual ones where none were."""
    return list(dict.fromkeys([*([own] if own else []), *(list(asked) or usual)]))


def _key(system: System) -> tuple:
    from vibrocap.motion.recording.equations import form

    return form(system)


def bundle(contents: Contents, tell: Callable[[float], None] = lambda share: None) -> dict[str, Any]:
    """The data of a page, for JSON. tell: is called with the share done."""
    forms: list[Form] = []
    work = 2 * (len(contents.forms) + len(contents.presets))  # the code of all forms takes as long as all else
    for i, system in enumerate(contents.forms, 1):
        forms.append(form_of(system, contents.tolerance))
        tell(i / work)
    keys, presets = [_key(system) for system in contents.forms], []
    for i, preset in enumerate(contents.presets, 1):
        presets.append(preset_record(preset) | {"form": keys.index(_key(preset.case.system))})
        tell((len(contents.forms) + i) / work)
    parts: dict[str, dict[str, Any]] = {}
    kinds: dict[str, dict[str, type]] = {}
    for system in contents.forms:
        for name, record in system.parts.items():
            part = type(record)
            parts.setdefault(name, {}).setdefault(part.name, part_record(part, effort_of(name, system.parts)))
            kinds.setdefault(name, {})[part.name] = part
    code = zlib.compress(api.browser_module([(form.motion, form.ensemble) for form in forms]), 9)
    tell(1.0)
    return {
        "layout": LAYOUT,
        "version": version("vibrocap"),
        "parts": parts,
        "carried": _carried(kinds),
        "keys": {name: key for name in parts if (key := kind_key(name))},
        "run": {"periods": RUN_DEFAULTS["periods"], "tolerance": RUN_DEFAULTS["tolerance"]},
        "limits": {"events": RUN_DEFAULTS["max_events_per_period"], "steps": RUN_DEFAULTS["max_steps"]},
        "forms": [form.record | {"number": number} for number, form in enumerate(forms)],
        "presets": presets,
        "statuses": statuses(),
        "smoothed": SMOOTHED,
        "code": base64.b64encode(code).decode("ascii"),
    }
