"""The options of `vibrocap sweep`, as a study; or every complaint about them at once, named by option."""

import csv
import dataclasses
import functools
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from vibrocap.arguments import Complaint, Complaints, by_option
from vibrocap.case.case import Case, CaseError
from vibrocap.cli import completers
from vibrocap.cli.command import WithParts
from vibrocap.cli.options import CASE, TOLERANCE, flag, needs, option, with_headings, writable_folder, writable_table
from vibrocap.cli.texts import pairs, split, value_of
from vibrocap.inputs import read_input
from vibrocap.io.motion_file import read_source

if TYPE_CHECKING:
    from vibrocap.studies.plan.study import Study
    from vibrocap.studies.sweep import Execution

FROM_CASE = ("periods", "tolerance", "max_events_per_period", "max_steps")  # unless an option says otherwise
NOT_ADAPTIVE = ("cases", "design", "resume", "mixed", "workers", "tile_runs", "device")


class SweepRequest(WithParts):
    """The options of `vibrocap sweep`; some of them say how the study is carried out."""

    case: Path = dataclasses.replace(CASE, words=f"{CASE.words}; with --verify the folder of a study")
    over: list[str] | None = option(
        "PATH=LOW:HIGH:N, PATH=log:LOW:HIGH:N or PATH=1,2,3; with --design PATH=LOW:HIGH; may be repeated",
        offers=completers.paths_of_case,
    )
    measure: list[str] | None = option(
        "such as mean_velocity,mode_sequence; `vibrocap list measures` lists them [default: mean_velocity]",
        offers=completers.measure_names,
    )
    out: Path | None = option("folder for the results, stored as they come")
    resume: bool = option(
        "continue the study in --out, repairing it if it is damaged; start one if there is none", False
    )
    export: Path | None = option(
        "write the results to FILE.nc (NetCDF), FILE.csv, FILE.xlsx (Excel) or FILE.mat (MATLAB) too"
    )
    cases: Path | None = option(
        "instead of --over, a table FILE.csv: a row of paths, then a row of values for each run"
    )
    design: str | None = option("spread --runs points over the ranges: sobol, halton, latin-hypercube or random")
    runs: int | None = option("number of runs of a design")
    adaptive: bool = option("run points only where the mode sequence, the travel or the response period changes", False)
    periods: float | None = option("drive periods of a run, at most; a whole number [default: the case's]")
    verify: bool = option("compare a stored study with its checksums, and run nothing", False)
    device: str = option("cpu, or a device of another package: cuda of vibrocap-gpu", "cpu", advanced=True)
    mixed: bool = option("--resume a study of another version or processor; new tiles are marked", False, advanced=True)
    no_extrapolate: bool = option(
        "let each run settle, and do not extrapolate the limit of its states", False, advanced=True
    )
    seed: int | None = option("of a design; the same seed gives the same runs [default: 0]", advanced=True)
    settle: float | None = option(
        "end a run this near to a steady motion, relative to the states' size; 0: never [default: 1e-6]", advanced=True
    )
    threads: int | None = option("number of threads [default: one for each core]", advanced=True)
    tile_runs: int | None = option(
        "runs stored together, which Ctrl-C loses [default: some five seconds of work]", advanced=True
    )
    tolerance: float | None = TOLERANCE()
    unit_headings: bool = option(
        'name and unit in the headings of .csv and .xlsx, as in "drift [m]"', False, advanced=True
    )
    window: int | None = option(
        "drive periods at the end that are measured if a run does not settle [default: 10, or all]", advanced=True
    )
    workers: int | None = option("number of processes, each of one thread", advanced=True)
    yes: bool = option("allow more than ten million runs", False, advanced=True)

    @functools.cached_property
    def how(self) -> "Execution":
        """How the study is carried out."""
        from vibrocap.studies.sweep import Execution

        names = (field.name for field in dataclasses.fields(Execution))
        return Execution(**{name: getattr(self, name) for name in names if hasattr(self, name)})

    @property
    def measures(self) -> list[str]:
        """What is measured."""
        return split(self.measure) or ["mean_velocity"]

    def study(self) -> "Study":
        """The study; CaseError with every complaint, before any work."""
        from vibrocap.measures.during_run import resolved
        from vibrocap.studies.plan.designs import Design
        from vibrocap.studies.plan.planning import planned_study

        needs("sweep", "xarray", "zarr")
        complaints = Complaints([*self._destination_complaints(), *self._option_complaints()])
        over = pairs("over", self.over, complaints, "PATH=VALUES, such as machine.mass_ratio=0.01:8.1:400")
        if not self.over and self.cases is None:
            complaints.add("--over", "is missing; name a parameter to vary, such as --over machine.mass_ratio=0.1:8:40")
        cases, before = None, len(complaints)
        with complaints.collected():
            cases = read_cases(self.cases) if self.cases else None
        unreadable = len(complaints) > before
        try:
            case = read_source(self.case)
        except CaseError as error:
            unknown = Complaints()
            for name in self.measures:
                with unknown.collected():
                    resolved(name)
            unknown = by_option(unknown, {"measures": "--measure"})
            raise CaseError([*error.complaints, *complaints, *unknown], str(self.case)) from None
        unusable = unreadable or (not over and (self.over or cases is None))  # said already
        design = None
        if self.design is not None and cases is None and not unusable:
            design = Design(self.design, 1 if self.runs is None else self.runs, self.seed or 0)
        try:
            rows = None if unusable or cases is None else list(cases.values())
            axes = {"drive.amplitude": "1:2:2"} if unusable else None if cases is not None else over or None
            study = planned_study(
                case.system,
                axes,
                measures=self.measures,
                cases=rows,
                design=design,
                initial=case.initial,
                settings=self._settings(case),
            )
        except CaseError as error:
            complaints += self._by_option(error.complaints, cases)
        else:
            if self.adaptive and not complaints:
                complaints += _map_complaints(study)
            with complaints.collected():
                writable_table("--export", self.export, rows=0 if self.adaptive else study.plan.count)
            if not complaints:
                return study
        raise CaseError(complaints, "the study")

    def plan(self, refused: Complaints) -> None:
        """--verify runs nothing, so that it goes with no other option."""
        for name in sorted(self._options() - {"verify", "case", "parts"}) if self.verify else ():
            refused.add(flag(name), "does not go with --verify, which runs nothing; leave one of them out")

    def _options(self) -> set[str]:
        """The fields that are not as they are where nothing is asked."""
        defaults = {field.name: field.default for field in dataclasses.fields(self)}
        return {name for name, default in defaults.items() if getattr(self, name) not in (default, (), [])}

    def _destination_complaints(self) -> list[str]:
        complaints = Complaints()
        if self.adaptive and self.out is not None:
            complaints.add("--out", "an adaptive map is made in one go; leave it out, and give --export FILE.nc")
        elif self.adaptive and self.export is None:
            missing = "is missing; an adaptive map needs a file for its results, such as --export map.nc"
            complaints.add("--export", missing)
        elif self.out is None and self.export is None:
            complaints.add("--out", "is missing; give a folder for the results, such as --out map")
        with complaints.collected():
            if self.out is not None:
                writable_folder("--out", self.out)
                if (self.out / "study.json").exists() and not self.resume:
                    text = "holds a study already; continue with --resume, or name another folder"
                    complaints.add("--out", f"{self.out} {text}")
        with complaints.collected():
            writable_table("--export", self.export)
            with_headings(self.export, self.unit_headings, "--export")
        return complaints

    def _option_complaints(self) -> list[str]:
        """Options that do not go together, and those on how the work is done."""
        options, complaints, apart = self._options(), Complaints(), ()
        if self.adaptive:
            apart = tuple(name for name in NOT_ADAPTIVE if name in options)
            for name in apart:
                complaints.add(flag(name), "does not go with --adaptive; leave one of them out")
        for name in ("over", "design"):
            if self.cases is not None and name in options:
                complaints.add(flag(name), "does not go with --cases; leave one out")
        for name in ("runs", "seed"):
            if self.design is None and name in options:
                complaints.add(flag(name), "belongs to --design, such as --design sobol")
        if self.design is not None and self.runs is None:
            complaints.add("--runs", "is missing; a design needs to know how many runs, such as --runs 1000")
        complaints += [
            complaint.about(flag(complaint.field))
            for complaint in self.how.complaints()
            if complaint.field not in apart
        ]
        return complaints

    def _settings(self, case: Case) -> dict[str, Any]:
        """How the runs are made: as the options say, else as the case does."""
        settings = {name: getattr(case, name) for name in FROM_CASE} | self.given("periods", "tolerance")
        periods = settings["periods"]
        if 1 <= periods < 1e9 and periods == int(periods):
            settings["periods"] = int(periods)
        return settings | {"window": self.window, "settle": self.settle, "extrapolate": not self.no_extrapolate}

    def _by_option(self, complaints: "tuple[str, ...]", cases: "Mapping[int, Any] | None") -> list[str]:
        """The complaints of the study, with the option that each is about in front."""
        options = {"measures": "--measure", "design.kind": "--design", "design.runs": "--runs", "design.seed": "--seed"}
        for field in (*FROM_CASE, "window", "settle"):
            of_case = field in FROM_CASE and getattr(self, field, None) is None
            options[field] = f"run.{field} of {self.case}" if of_case else f"--{field}"
        options |= {f"cases[{i}]": f"--cases {self.cases}, line {line}" for i, line in enumerate(cases or ())}
        named = by_option(complaints, options)
        for i, (new, old) in enumerate(zip(named, complaints, strict=True)):
            field = old.field if isinstance(old, Complaint) else ""
            if field not in options:
                named[i] = f"--over {old}" if self.cases is None else f"--cases {old}"
            elif field in ("periods", "tolerance") and options[field].startswith("run."):
                named[i] += f"; give --{field}"
            elif field == "settle":
                named[i] = new.replace("None or a positive", "0, for never, or a positive")
        return named


def _map_complaints(study: "Study") -> list[str]:
    """What an adaptive map asks of a study beyond what any other does."""
    axes = getattr(study.plan, "axes", ())
    if len(axes) != 2:
        return [f"--adaptive: needs two axes, two times --over, got {len(axes)}"]
    complaints = []
    for axis in axes:
        numbers = not any(isinstance(value, str) for value in axis.values)
        if not numbers or len(axis.values) < 2 or (axis.array[1:] <= axis.array[:-1]).any():
            complaints.append(f"--over {axis.path}: --adaptive needs two or more numbers, each above the one before")
    return complaints


LARGEST = 2**28  # bytes


def read_cases(path: Path) -> dict[int, dict[str, Any]]:
    """The cases of a table, {path: value} by their lines: paths in its first row; what is empty is as usual.

    Lines that begin with # are passed over. Raises CaseError with every complaint at once.
    """
    try:
        raw = read_input(path, LARGEST + 1)
        text = raw.decode("utf-8-sig") if len(raw) <= LARGEST else ""
    except (OSError, UnicodeDecodeError) as error:
        reason = getattr(error, "strerror", None) or "is not a text file in UTF-8"
        raise CaseError([f"--cases: {path}: {reason}"], str(path)) from None
    if len(raw) > LARGEST:
        raise CaseError([f"--cases: {path}: should be at most {LARGEST // 2**20} MB"], str(path))
    numbered = [(number, line) for number, line in enumerate(text.splitlines(), 1) if line.strip() and line[0] != "#"]
    cells, reader = [], csv.reader(line for _, line in numbered)
    try:
        cells += [[cell.strip() for cell in row] for row in reader]
    except csv.Error as error:
        line = numbered[reader.line_num - 1][0]
        raise CaseError([f"--cases: {path}, line {line}: is no row of a table ({error})"], str(path)) from None
    complaints = Complaints()
    if len(cells) != len(numbered):
        raise CaseError([f"--cases: {path}: a quotation mark is not closed in its line"], str(path))
    if len(cells) < 2:
        wanted = "a row of paths, such as machine.mass_ratio, and a row for each case"
        raise CaseError([f"--cases: {path}: should hold {wanted}"], str(path))
    paths = cells[0]
    for name in dict.fromkeys(name for name in paths if paths.count(name) > 1):
        complaints.add("--cases", f"{path}: {name} heads two columns")
    cases = {}
    for (number, _), row in zip(numbered[1:], cells[1:], strict=True):
        if len(row) != len(paths):
            complaints.add("--cases", f"{path}, line {number}: has {len(row)} values under {len(paths)} paths")
        elif not any(row):
            complaints.add("--cases", f"{path}, line {number}: gives no value")
        else:
            cases[number] = {name: value_of(cell, float) for name, cell in zip(paths, row, strict=True) if cell}
    if complaints:
        raise CaseError(complaints, str(path))
    return cases
