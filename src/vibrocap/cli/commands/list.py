"""`vibrocap list`: machines, friction laws, drives, controllers, measures and data sets, what each is, and a check."""

import dataclasses
import inspect
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from vibrocap.arguments import Refusal, suggestion
from vibrocap.citations.bibliography import references
from vibrocap.cli import completers
from vibrocap.cli.command import Answer, WithParts, command
from vibrocap.cli.options import JSON, needs, option, writable_folder
from vibrocap.cli.terminal import WRONG_INPUT, Page, parameters_in_words, progress, table
from vibrocap.io.motion_file import read_source
from vibrocap.physics import catalogue
from vibrocap.physics.system import System

OF_SYSTEM = {"machines": "machine", "laws": "friction", "drives": "drive", "controllers": "controller"}
PARTS: dict[str, Callable[[], Mapping[str, Any]]] = {kind: getattr(catalogue, kind) for kind in OF_SYSTEM}


class ListRequest(WithParts):
    names: tuple[str, ...] = option(
        f"{', '.join(completers.LISTED)}; a machine, law, drive or controller; with a case file those of the case",
        (),
        place=True,
        offers=completers.listed_names,
    )
    check: bool = option("test whether a part, or those of --parts, keep their contracts", False)
    fetch: str | None = option("of datasets: fetch this one and compare its checksums", offers=completers.data_sets)
    json: bool = JSON
    quick: bool = option("check without a motion", False, needs="check", advanced=True)
    latex: bool = option("print the equations of a machine alone, as LaTeX", False, advanced=True)
    to: Path | None = option(
        "folder for data sets [default: VIBROCAP_DATA, else a cache]", needs="fetch", advanced=True
    )


@command(
    "start",
    "vibrocap list",
    "vibrocap list laws",
    "vibrocap list measures examples/bristles-lugre.toml",
    "vibrocap list pendulum-capsule",
    "vibrocap list drill-string --latex",
    "vibrocap list lugre --check --quick",
    "vibrocap list --parts mylaws.py --check",
    "vibrocap list datasets",
    "vibrocap list datasets --fetch rotary-damper --to data",
)
def list_(request: ListRequest) -> Answer:
    """Machines, laws, drives, measures, data sets.

    The text of a machine has its parameters, its source and its equations of motion, derived from its
    description: a prime is a rate, R friction, N a load, H the energy, d an imposed motion, s the touched stop (1 in
    front, -1 behind, 0 none). --check tests a part with its defaults and with other numbers: sampled, recorded, and
    simulated for some periods. A fetched data set must have the checksums of its publisher, or those of the first
    fetch.

    Exit codes: 2 a part does not keep its contract. 3 a data set could not be fetched.
    """
    if request.check:
        return _check(request)
    if request.fetch is not None:
        return _fetched(request.fetch, request.to)
    cases = [name for name in request.names if name.endswith((".toml", ".nc", ".csv"))]
    if len(cases) > 1:
        raise Refusal(f"NAMES: should hold one case, got {', '.join(cases)}")
    system = read_source(Path(cases[0])).system if cases else None
    what, *more = [name for name in request.names if name not in cases] or [""]
    if not what and system is None:
        return _overview()
    if what in ("measures", "datasets"):
        return _measures(system) if what == "measures" else _data_sets()
    if system is not None and (what in PARTS or not what):
        own = {name: part for name, part in system.parts.items() if name.startswith(OF_SYSTEM.get(what, ""))}
        return _sheets(own, request.latex, system)
    if what in PARTS:
        return _kind(what)
    return _sheets({part.name: part() for part in _named([what, *more])}, request.latex)


def _overview() -> Answer:
    record = {kind: list(known()) for kind, known in PARTS.items()}
    lines = [f"{kind:<13}{', '.join(names)}" for kind, names in record.items()]
    lines += [f"{kind:<13}see `vibrocap list {kind}`" for kind in ("measures", "datasets")]
    return Answer(record, "\n".join(lines))


def _kind(kind: str) -> Answer:
    """The parts of a kind, a line each; laws with whether they stick and creep."""
    known = PARTS[kind]()
    words = completers.described(known)
    width, lines = max(map(len, words), default=0) + 2, []
    for name, meaning in words.items():
        lines.append(f"{name:<{width}}{meaning}")
        if kind == "laws":
            creeps = "creeps" if known[name].creeps else "does not creep"
            lines.append(f"{'':<{width}}{known[name].kind}; {creeps} under an oscillating force below break-away")
    if kind == "laws":
        wrappers = " and ".join(f"{word}-" for word in catalogue.wrappers())
        lines.append(f"\nBefore a name may stand {wrappers}, as in backlash-anisotropic-lugre.")
    shown = "vibrocap friction lugre" if kind == "laws" else f"vibrocap list {next(iter(known))}"
    return Answer({kind: words}, "\n".join([*lines, f"\nNext: {shown}"]))


def _named(names: Sequence[str]) -> list[Any]:
    """The classes of parts by name; Refusal, with the nearest name, for what there is not."""
    catalogues = [known() for known in PARTS.values()]
    near = [*completers.LISTED, *(name for known in catalogues for name in known)]
    complaints = [
        f"{name!r} is no part; `vibrocap list {name}` lists what there is"
        if name in completers.LISTED
        else f"no machine, law, drive or controller is called {name!r}; {suggestion(name, near, cutoff=0.0)}"
        for name in names
        if not any(name in known for known in catalogues)
    ]
    if complaints:
        raise Refusal(*complaints)
    return [known[name] for name in names for known in catalogues if name in known]


def _sheets(named: dict[str, Any], latex: bool, system: System | None = None) -> Answer:
    """Parts with their words, parameters, in SI those of a system, sources, and the equations of a machine."""
    from vibrocap.physics.dimensions.scales import SIScales
    from vibrocap.physics.equations import equations_of
    from vibrocap.physics.machines.machine import Machine

    form, parts = "latex" if latex else "text", list(named.values())
    scaled = system is not None and system.units is not None and not isinstance(system.units, SIScales)
    bare = ", without units" if scaled else ""
    equations = {part.name: equations_of(part, form).lines for part in parts if isinstance(part, Machine)}
    if latex and not equations:
        raise Refusal(f"--latex: shows the equations of a machine, got {', '.join(part.name for part in parts)}")
    if latex:
        lines = [line for equation in equations.values() for line in equation]
        return Answer({"equations": lines}, "\n".join(lines))
    record = [{"name": part.name, "equations": list(equations.get(part.name, ()))} for part in parts]

    def text(page: Page) -> None:
        for name, part in named.items():
            page.say(inspect.cleandoc(type(part).__doc__ or part.name) + "\n")
            page.print(parameters_in_words(part, name, system))
            if part.name in PARTS["machines"]() or part.name in equations:
                page.say(f"\nEquations of motion, derived from its description{bare}:\n")
                own = equations.get(part.name) or ["none: it is not described by its parts"]
                page.say("\n".join(f"    {line}" for line in own))
            source = [reference.text for reference in references(type(part).source, part.name)] or ["not recorded"]
            page.say("\nsource     " + "\n           ".join(source))

    return Answer(record[0] if len(record) == 1 else {"parts": record}, text)


def _measures(system: System | None) -> Answer:
    """The measures of a sweep, with their units in SI; of a system those that it has."""
    from vibrocap.measures.during_run import measure_table
    from vibrocap.measures.standard import undefined_measures

    with_units = system is None or system.units is not None
    without = () if system is None else undefined_measures(system)
    known = {name: measure for name, measure in measure_table(system).items() if name not in without}

    def text(page: Page) -> None:
        listing = table(None, "measure", *(["unit"] if with_units else []), "meaning", no_wrap=1 + with_units)
        for name, measure in known.items():
            listing.add_row(name, *([measure.si_unit.replace("1", "")] if with_units else []), measure.meaning)
        page.print(listing)
        page.print("Every run also has status, settled, response_period, window_start and window_periods.")

    record = {name: {"si_unit": x.si_unit if with_units else "1", "meaning": x.meaning} for name, x in known.items()}
    return Answer({"measures": record}, text)


def _data_sets() -> Answer:
    """The published measurements: authors, licence, and whether they are here."""
    from vibrocap.records.published import DATA_SETS, FOLDERS, data_root

    lines, record = [], {}
    for data_set in DATA_SETS.values():
        folder = data_root() / FOLDERS[data_set.name]
        count = len(data_set.originals)
        here = f"here, in {folder}" if folder.is_dir() else f"not here; {count} file{'s' * (count != 1)}"
        about = (data_set.title, f"{data_set.authors}; {data_set.licence}", data_set.page, here)
        lines += [data_set.name, *(f"  {line}" for line in about)]
        record[data_set.name] = {name: getattr(data_set, name) for name in ("title", "authors", "licence", "page")}
    return Answer({"datasets": record}, "\n".join(lines))


def _fetched(name: str, to: Path | None) -> Answer:
    """Fetch the published files of a data set, and check them; files that exist are not fetched again."""
    from vibrocap.records.published import DATA_SETS, FetchError, data_root
    from vibrocap.records.published import fetch as fetched

    if name not in DATA_SETS:
        begun = next((data_set for data_set in DATA_SETS if name and data_set.startswith(name)), name)
        raise Refusal(f"--fetch: no data set is called {name!r}; {suggestion(begun, DATA_SETS)}")
    needs("--fetch", "pooch")
    writable_folder("--to", to if to is not None else data_root())
    try:
        with progress(f"Fetching {name}") as report:
            came = fetched(DATA_SETS[name], to, lambda share: report(share, None))
    except FetchError as error:
        return Answer(incomplete=str(error))
    samples = sum(map(len, came.records))
    lines = [f"{name}: {len(came.records)} records, {samples:,} samples, in {came.folder}"]
    lines += [f"  checked    {came.known} against the published checksum"] * bool(came.known)
    lines += [f"  checked    {came.recorded} against the checksum of the first fetch"] * bool(came.recorded)
    lines += [f"  trusted    {came.first} on first use; checksums in SHA256SUMS there"] * bool(came.first)
    lines += [f"  by         {DATA_SETS[name].authors}; {DATA_SETS[name].licence}"]
    lines += [f"To use it: VIBROCAP_DATA={to}"] * (to is not None)
    return Answer({"dataset": name, "records": len(came.records), "samples": samples}, "\n".join(lines))


def _check(request: ListRequest) -> Answer:
    """Whether parts keep their contracts: the one that is named, or those of --parts."""
    from vibrocap.contracts.check_part import check_part

    parts = _named(request.names) if request.names else list(catalogue.registered())
    if not parts:
        raise Refusal("--check: name a part, such as `vibrocap list lugre --check`, or a file: --parts mylaws.py")
    reports = []
    for part in parts:
        with progress(f"Checking {part.name}"):
            reports.append(check_part(part, motion=not request.quick))
    record = {"parts": [dataclasses.asdict(report) | {"ok": report.ok} for report in reports]}
    incomplete = "" if all(report.ok for report in reports) else "A part does not keep its contract."
    return Answer(record, "\n\n".join(map(str, reports)), incomplete=incomplete, code=WRONG_INPUT)
