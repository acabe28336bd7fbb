"""Forms of systems as a page has them: two kernels, what their numbers are called, and what a page can measure."""

import dataclasses
import math
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from vibrocap.lab.controls import exponents
from vibrocap.lab.written import Ways, Written, chosen, mirrored, parts_of_period, rules, text_of
from vibrocap.measures.during_run import asked_groups, measure_table, resolved, values
from vibrocap.measures.gathered import Gathered
from vibrocap.measures.measure import Measure, Reduction, Standard, own_integrands
from vibrocap.measures.recorded.settling import MIRROR_SHARE
from vibrocap.motion.recording.equations import equations
from vibrocap.motion.recording.recorded_machine import drawn_length, recorded_room, recorded_scene
from vibrocap.motion.simulate import STATUSES, event_kinds
from vibrocap.motion.status import Status
from vibrocap.numerics.api import BrowserKernel, Integrands, RunResults, browser_kernels, codes, series_order
from vibrocap.numerics.expressions.equations import Corners
from vibrocap.physics.dimensions.units import DRIVE_UNITS, QUANTITIES, state_units
from vibrocap.physics.drives.drive import ROUNDING
from vibrocap.physics.names import split_path
from vibrocap.physics.parameters import dimension_of_unit, parameter_table
from vibrocap.physics.system import System

TOLERANCE = 1e-9  # of motions: from 1e-11 on and below 1e-7 they are those of the kernel of `simulate`
# Of maps: below 1e-9, where `ensemble` has the order of a motion too, no slower here than order 10 at 1e-8, and a page
# is smaller by a quarter; of motions at order 10 also 10.
ENSEMBLE_TOLERANCES = {10: 1e-7, 12: 5e-10, 16: 5e-10}
OBSERVED = ("friction", "holding_force", "drive", "energy", "contact_energy", "contact_velocity")
# Places that the page's engine fills or reads; the rest is the kernels' own affair.
PLACES = (
    *("STATUS", "PERIOD_COUNT", "WHOLE_PERIODS", "TAYLOR_STEPS", "IMPLICIT_STEPS", "EVENT_LIMIT", "STEP_LIMIT"),
    *("PIECES", "PIECE_LIMIT", "RECORDED_EVENTS", "RECORDED_EVENT_LIMIT", "PIECE_START", "RECORDED_EVENT_START"),
    *("RUN", "WINDOW", "PERIOD_BUDGET", "ASKED", "RESULT_START", "NEXT_RUN", "LAST_RUN", "MORE"),
    *("PERIOD", "TAIL", "TOLERANCE", "THRESHOLD", "CONTACT_RESIDUAL", "MARKS"),
    *("SEGMENT_COUNT", "TABLE_START", "TABLE_STRIDE", "STATE", "PARAMETER", "SCALE"),
)


@dataclasses.dataclass(frozen=True)
class Form:
    """A form of system of a page.

    record: what the page knows of it, without its code; motion, ensemble: its kernels
    """

    record: dict[str, Any]
    motion: BrowserKernel
    ensemble: BrowserKernel


def form_of(system: System, tolerance: float = TOLERANCE) -> Form:
    """The form of a system, its kernels translated; tolerance: of its motions, which decides their order."""
    recording = equations(system)
    shapes, drifts, load = recorded_scene(system)
    observed = {name: recording.observables[name] for name in OBSERVED}
    follows = "reaction" in recording.observables and system.machine.follows_load
    observed["load"] = recording.observables["reaction"] if follows else load
    observed |= {f"{name}_power": power for name, power in zip(recording.channels, recording.powers, strict=True)}
    drawn = [coordinate for shape in shapes for point in shape.points for coordinate in point]
    # all on the graph of the load, which begins with the nodes of their own
    functions = [type(expression)(load.graph, expression.index) for expression in observed.values()]
    functions += [*drawn, *drifts.values()]
    looser = ENSEMBLE_TOLERANCES[series_order(tolerance)]
    room = recorded_room(system)
    bounds = [bound for place in room.values() for bound in place]
    own = gathered_functions(system)
    motion, ensemble = browser_kernels(recording, functions, tolerance, looser, bounds, own)
    fixed = {
        f"{part}.{info.name}": getattr(record, info.name)
        for part, record in system.parts.items()
        for info in parameter_table(record)
        if f"{part}.{info.name}" not in recording.parameter_paths
    }
    paths = tuple(path for path in recording.parameter_paths if split_path(path)[0] in system.parts)
    record = {
        "sections": list(system.parts),
        **{part: record.name for part, record in system.parts.items()},
        "states": list(system.state_names),
        "mechanical": len(system.machine.states),
        "events": event_kinds(system.placed.switch_events).tolist(),
        "switched": list(system.switched),
        "symmetry": list(system.symmetry),
        "cyclic": recording.cyclic_state,
        "rests": [contact.sticks for contact in recording.contacts],
        "channels": list(system.channels),
        "observed": list(observed),
        "parameters": list(paths),
        "rules": rules(system, paths),
        "mirrored": mirrored(system, paths),
        "room": list(room),
        "corners": _corners(recording.corners, system, paths),
        "fixed": fixed,
        "length": drawn_length(system),
        "scene": [
            {"kind": x.kind, "name": x.name, "points": len(x.points), "size": list(x.size), "box": x.box}
            for x in shapes
        ],
        "drifts": list(drifts),  # of which coordinates stand behind them, by how much they are farther every period
        "tolerance": looser,
        "motion": _places(motion),
        "ensemble": _places(ensemble) | result_record(system, ensemble),
        "units": _units(system, (*system.state_names, *observed)),
        "measures": measure_records(system, ensemble),
    }
    return Form(record, motion, ensemble)


def _corners(corners: Corners | None, system: System, paths: tuple[str, ...]) -> dict[str, Any] | None:
    """Of a drive with corners: segments in a part of its period, coefficients of each; what rounding is; how many parts
    there are, in JavaScript. None without corners."""
    if corners is None:
        return None
    counts = {"segments": len(corners.lengths), "coefficients": corners.coefficients}
    return {**counts, "rounding": ROUNDING, "parts": parts_of_period(system, paths)}


def _units(system: System, names: Iterable[str]) -> dict[str, Any]:
    """SI unit of quantities, and their exponents of mass, length and time."""
    known = QUANTITIES | {"drive": DRIVE_UNITS[system.machine.effort]} | state_units(system.parts)
    known |= {} if system.controller is None else {"reference": DRIVE_UNITS[system.controller.reference]}
    units = {}
    for name in names:
        unit = known.get(name) or ("N" if name == "load" else "W" if name.endswith("_power") else None)
        if unit is not None:
            units[name] = [unit, exponents(dimension_of_unit(unit))]
    return units


def _places(kernel: BrowserKernel) -> dict[str, Any]:
    layout, constants = kernel.layout, kernel.layout.constants()
    sizes = {"rows": layout.states, "order": layout.order}
    sizes |= {name: getattr(layout, f"{name}_size") for name in ("piece", "event", "run", "result")}
    sizes |= {"marks": layout.marks, "ints": layout.whole_size, "floats": layout.real_size}
    return {"sizes": sizes, "at": {name: constants[name] for name in PLACES}}


def statuses() -> list[dict[str, Any]]:
    """How a run may end, by the number that a kernel gives: name and what to do."""
    known: list[dict[str, Any]] = [{"name": "", "text": ""} for _ in range(max(STATUSES) + 1)]
    for number, status in STATUSES.items():
        known[number] = {"name": status.value, "text": status.text, "ok": status is Status.FINISHED}
    return known


ASKED = codes.ASK_SYMMETRY | codes.ASK_MODES  # of a motion on show: what the readouts say


def gathered_functions(system: System) -> Integrands | None:
    """The functions of the instant of all measures of a system that need some of their own; None where none does.

    One kernel has them all: it gathers them where works or peaks are asked for.
    """
    return own_integrands(_reductions(system), equations(system))


def _reductions(system: System) -> tuple[Measure, ...]:
    _, needed = resolved(list(measure_table(system)), system)
    return tuple(measure for measure in needed if isinstance(measure.how, Reduction))


def measure_records(system: System, kernel: BrowserKernel) -> list[dict[str, Any]]:
    """The measures of a system that are numbers: name, meaning, groups that have to be gathered, and how to read it.

    si: the SI unit of one that has one, and its exponents of mass, length and time

    read: an expression in JavaScript of the result r of the kernel, the drive period T, the threshold of settling h and
    of whether the system has the half-period symmetry, m. It is what the measure itself does, written down; a measure
    that this system does not have is left out.
    """
    records = []
    for name, measure in measure_table(system).items():
        _, needed = resolved(name, system)
        if any(isinstance(part.how, Standard) and part.how.text for part in needed):
            continue
        read = _read(system, kernel, needed, name)
        if read != "NaN":
            si = None if measure.si_unit == "1" else [measure.si_unit, exponents(dimension_of_unit(measure.si_unit))]
            record = {"name": name, "meaning": measure.meaning, "asked": asked_groups(needed), "read": read}
            records.append(record if si is None else record | {"si": si})
    return records


def _read(system: System, kernel: BrowserKernel, needed: Sequence[Measure], name: str) -> str:
    ways, layout = Ways(), kernel.layout
    own = _reductions(system)  # whose numbers stand in the order of the kernel
    ordered = (*own, *(measure for measure in needed if measure not in own))
    numbers = np.array([[Written(1.0, f"r[{i}]", ways) for i in range(layout.result_size)]], dtype=object)
    period = np.array([Written(1.0, "T", ways)], dtype=object)
    threshold: Any = np.array([Written(1.0, "h", ways)], dtype=object)  # a number alone would lose its text

    def asked() -> Any:
        mirrored = np.array([ways.answer("m")])
        gathered = Gathered(system, RunResults(layout, numbers), period, lambda: mirrored, threshold)
        return values(ordered, gathered)[name][0]

    ends = ways.through(asked)
    texts = [(condition, text_of(value if isinstance(value, float) else math.nan)) for condition, value in ends]
    return ways.whole(chosen(texts))


def result_record(system: System, kernel: BrowserKernel) -> dict[str, Any]:
    """Where the rest of a result stands: its head by name, the mode sequences of contacts, its distance from its mirror
    image."""
    layout = kernel.layout
    letters, counts = (layout.gathered_slice(name).start for name in ("LETTERS", "LETTER_COUNT"))
    places = [(letters + k * codes.MODE_PLACES, counts + k) for k in range(len(system.laws))]
    return {
        "head": kernel.result_head,
        "letters": [None if law.kind == "smooth" else at for law, at in zip(system.laws, places, strict=True)],
        "letter_places": [codes.MODE_PLACES, codes.LETTERS_PER_PLACE],
        "asymmetry": layout.gathered_slice("ASYMMETRY").start,
        "mirrored": MIRROR_SHARE,
        "asked": ASKED,
    }
