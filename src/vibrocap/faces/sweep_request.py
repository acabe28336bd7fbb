"""What `vibrocap sweep` was asked for, as a study; or every complaint about it at once, named by option."""

import csv
import dataclasses
import re
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from vibrocap.case import Case, CaseError
from vibrocap.faces.terminal import Refusal, needs, writable_file, writable_folder

if TYPE_CHECKING:
    from vibrocap.studies.study import Study

WINDOW = 10
EXPORTS = (".nc", ".csv")
DEVICES = ("cpu", "cuda")
FROM_CASE = ("periods", "tolerance", "max_events_per_period", "max_steps")  # unless an option says otherwise


@dataclasses.dataclass(frozen=True)
class SweepRequest:
    """The options of `vibrocap sweep`, as they were given."""

    case: Path
    over: tuple[str, ...]
    measures: tuple[str, ...]
    out: Path | None
    export: Path | None
    resume: bool
    cases: Path | None
    design: str | None
    runs: int | None
    seed: int | None
    adaptive: bool
    periods: float | None
    window: int | None
    settle: float | None
    tolerance: float | None
    threads: int | None
    workers: int | None
    scheduler: str | None
    device: str

    def study(self) -> "Study":
        """The study; CaseError with every complaint, before any work."""
        from vibrocap.faces.export import read_source
        from vibrocap.studies.designs import Design
        from vibrocap.studies.planning import planned_study

        needs("sweep", "sweep", "xarray", "zarr")
        complaints = self._places() + self._ways()
        over, found = self._axes()
        complaints += found
        cases, lines, found = read_cases(self.cases) if self.cases else (None, [], [])
        complaints += found
        try:
            case = read_source(self.case)
        except CaseError as error:
            raise CaseError([*error.complaints, *complaints, *self._unknown_measures()], str(self.case)) from None
        unusable = bool(found) or (not over and (self.over or cases is None))  # said already
        design = None
        if self.design is not None and not unusable:
            design = Design(self.design, 1 if self.runs is None else self.runs, self.seed or 0)
        try:
            study = planned_study(
                case.system,
                {"drive.amplitude": "1:2:2"} if unusable else over or None,
                measures=self.measures,
                cases=None if unusable else cases,
                design=design,
                initial=case.initial,
                settings=self._settings(case),
            )
        except CaseError as error:
            complaints += [self._by_option(text, lines) for text in error.complaints]
        else:
            if self.adaptive and not complaints:
                complaints += _map_complaints(study)
            if not complaints:
                return study
        raise CaseError(complaints, "the study")

    def _axes(self) -> tuple[dict[str, str], list[str]]:
        """Values by path, and what is wrong with how they are given."""
        from vibrocap.studies.axes import parse_over

        found: dict[str, str] = {}
        complaints = []
        for text in self.over:
            try:
                new = parse_over([text])
            except CaseError as error:
                complaints += [f"--over {complaint}" for complaint in error.complaints]
                continue
            complaints += [f"--over {path}: is given twice" for path in new if path in found]
            found |= new
        if not self.over and self.cases is None:
            complaints.append("--over: is missing; name what varies, such as --over machine.mass_ratio=0.1:8:40")
        return found, complaints

    def _places(self) -> list[str]:
        """What is wrong with where results go."""
        found = []
        if self.adaptive and self.out is not None:
            found.append("--out: an adaptive map is made in one go; leave it out, and give --export FILE.nc")
        elif self.adaptive and self.export is None:
            found.append("--export: is missing; an adaptive map needs a file for its results, such as --export map.nc")
        elif self.out is None and self.export is None:
            found.append("--out: is missing; give a folder for the results, such as --out map")
        try:
            if self.out is not None:
                writable_folder("--out", self.out)
                if (self.out / "study.json").exists() and not self.resume:
                    found.append(
                        f"--out: {self.out} holds a study already; go on with --resume, or name another folder"
                    )
        except Refusal as refusal:
            found.append(str(refusal))
        try:
            if self.export is not None:
                writable_file("--export", self.export, EXPORTS)
                if self.export.suffix.lower() == ".nc":
                    needs("--export", "export", "h5netcdf")
        except Refusal as refusal:
            found.append(str(refusal))
        return found

    def _ways(self) -> list[str]:
        """Options that do not go together, and those on how the work is done."""
        given = {name: value for name, value in dataclasses.asdict(self).items() if value not in (None, False, ())}
        found = []
        alone = ("cases", "design", "resume", "workers", "scheduler")
        if self.adaptive:
            found += [
                f"--{name}: does not go with --adaptive; leave one of them out" for name in alone if name in given
            ]
        if self.cases is not None:
            found += [
                f"--{name}: does not go with --cases; leave one out" for name in ("over", "design") if name in given
            ]
        if self.design is None:
            found += [
                f"--{name}: belongs to --design, such as --design sobol" for name in ("runs", "seed") if name in given
            ]
        elif self.runs is None:
            found.append("--runs: is missing; a design needs to know how many runs, such as --runs 1000")
        for name in ("threads", "workers"):
            value = getattr(self, name)
            if value is not None and value < 1:
                found.append(f"--{name}: should be a whole number >= 1, got {value}")
        if self.workers is not None and self.scheduler is not None:
            found.append("--workers: are of a cluster on this machine; with --scheduler leave them out")
        for name in ("resume", "workers", "scheduler"):
            if name in given and self.out is None and not self.adaptive:
                found.append(f"--{name}: needs a folder for the results, --out DIR")
        return found + self._device_complaints()

    def _device_complaints(self) -> list[str]:
        from vibrocap.numerics.run.cuda import cuda_problem

        if self.device not in DEVICES:
            return [f"--device: should be {' or '.join(DEVICES)}, got {self.device!r}"]
        if self.device == "cpu":
            return []
        if self.adaptive:
            return ["--device: an adaptive map runs on the processor; leave it out"]
        problem = cuda_problem()
        return [f"--device: {problem.removeprefix('device: ')}"] if problem else []

    def _settings(self, case: Case) -> dict[str, Any]:
        """How the runs are made: as the options say, else as the case does; settling is on unless it is 0."""
        given: dict[str, Any] = {"periods": self.periods, "tolerance": self.tolerance}
        settings = {name: getattr(case, name) if given.get(name) is None else given[name] for name in FROM_CASE}
        periods = settings["periods"]
        if 1 <= periods < 1e9 and periods == int(periods):
            settings["periods"] = int(periods)
        settings["window"] = self.window
        if self.window is None:
            settings["window"] = int(min(WINDOW, max(1, periods))) if periods == periods else WINDOW
        settings["settle"] = self.settle or None
        if self.settle is None:
            settings["settle"] = default_threshold(settings["tolerance"])
        return settings

    def _unknown_measures(self) -> list[str]:
        """Complaints about measures where there is no system to plan with."""
        from vibrocap.measures.during_run import resolved

        found = []
        for name in self.measures:
            try:
                resolved(name)
            except ValueError as error:
                found.append(str(error).replace("measures:", "--measure:", 1))
        return found

    def _by_option(self, complaint: str, lines: list[int]) -> str:
        """A complaint of the study, with the option that it is about in front."""
        field, _, rest = complaint.partition(":")
        if field in ("periods", "tolerance", "window", "settle", *FROM_CASE):
            if field in FROM_CASE and getattr(self, field, None) is None:
                hint = f"; give --{field}" if field in ("periods", "tolerance") else ""
                return f"run.{field} of {self.case}:{rest}{hint}"
            return f"--{field}:{rest.replace('None or a positive', '0, for never, or a positive')}"
        options = {"measures": "--measure", "design.kind": "--design", "design.runs": "--runs", "design.seed": "--seed"}
        if field in options:
            return f"{options[field]}:{rest}"
        if row := re.fullmatch(r"cases\[(\d+)\]", field):
            return f"--cases {self.cases}, line {lines[int(row[1])]}:{rest}"
        return f"--over {complaint}" if self.cases is None else f"--cases {complaint}"


def default_threshold(tolerance: float) -> float:
    """The threshold to which runs settle unless one is given, as `measures.settling` has it."""
    from vibrocap.measures.settling import THRESHOLD, TOLERANCES

    return max(THRESHOLD, TOLERANCES * tolerance) if tolerance < 1.0 else THRESHOLD


def read_cases(path: Path) -> tuple[list[Mapping[str, Any]], list[int], list[str]]:
    """(cases, the line of each, complaints) of a table: paths in its first row, then a case in each; empty: as usual.

    Lines that begin with # are passed over.
    """
    try:
        text = path.read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        reason = getattr(error, "strerror", None) or "is not a text file in UTF-8"
        return [], [], [f"--cases: {path}: {reason}"]
    rows = [(number, line) for number, line in enumerate(text.splitlines(), 1) if line.strip() and line[0] != "#"]
    cells = [[cell.strip() for cell in row] for row in csv.reader(line for _, line in rows)]
    if len(cells) < 2:
        return (
            [],
            [],
            [f"--cases: {path}: should hold a row of paths, such as machine.mass_ratio, and a row for each case"],
        )
    paths = cells[0]
    complaints = [f"--cases: {path}: {name} heads two columns" for name in {n for n in paths if paths.count(n) > 1}]
    cases, lines = [], []
    for (number, _), row in zip(rows[1:], cells[1:], strict=True):
        if len(row) != len(paths):
            complaints.append(f"--cases: {path}, line {number}: has {len(row)} values under {len(paths)} paths")
        elif not any(row):
            complaints.append(f"--cases: {path}, line {number}: gives no value")
        else:
            cases.append({name: _number_or_word(cell) for name, cell in zip(paths, row, strict=True) if cell})
            lines.append(number)
    return cases, lines, complaints


def _number_or_word(text: str) -> float | str:
    try:
        return float(text)
    except ValueError:
        return text


def _map_complaints(study: "Study") -> list[str]:
    """What an adaptive map asks of a study beyond what any other does."""
    axes = getattr(study.plan, "axes", ())
    if len(axes) != 2:
        return [f"--adaptive: needs two axes, two times --over, got {len(axes)}"]
    found = []
    for axis in axes:
        numbers = not any(isinstance(value, str) for value in axis.values)
        if not numbers or len(axis.values) < 2 or (axis.array[1:] <= axis.array[:-1]).any():
            found.append(f"--over {axis.path}: --adaptive needs two or more numbers, each above the one before")
    return found
