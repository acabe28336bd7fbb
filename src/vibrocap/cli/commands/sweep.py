"""`vibrocap sweep`, `measures`, `plot` and `verify`: many runs, measured on the way, their pictures, and a check."""

import dataclasses
import time
from collections import Counter
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from vibrocap.arguments import Complaints
from vibrocap.case.case import CaseError
from vibrocap.cli.options import Refusal, needs, pairs, writable_picture
from vibrocap.cli.terminal import INCOMPLETE, OK, Page, TimeLeft, complain, duration, notes, progress, table
from vibrocap.files import WriteError
from vibrocap.io.motion_file import read_source

if TYPE_CHECKING:
    from vibrocap.cli.commands.sweep_request import SweepRequest
    from vibrocap.studies.plan.study import Study
    from vibrocap.studies.sweep import Completed


def sweep(
    case: Path,
    /,
    *,
    over: list[str] | None = None,
    measure: list[str] | None = None,
    out: Path | None = None,
    resume: bool = False,
    mixed: bool = False,
    export: Path | None = None,
    unit_headings: bool = False,
    cases: Path | None = None,
    design: str | None = None,
    runs: int | None = None,
    seed: int | None = None,
    adaptive: bool = False,
    periods: float | None = None,
    window: int | None = None,
    settle: float | None = None,
    no_extrapolate: bool = False,
    tolerance: float | None = None,
    threads: int | None = None,
    workers: int | None = None,
    device: str = "cpu",
    tile_runs: int | None = None,
    yes: bool = False,
) -> int:
    """Many runs of a case with other values: a map, a list of cases or a design, measured during the run.

    What varies is named by its path: a parameter (machine.mass_ratio), an initial
    state (initial.angle), or a kind of part (friction.law=exponential,lugre).

    Exit codes: 0 done, also if some runs failed: they have their status, and the
    summary counts them. 2 wrong input, all of it named before any work. 3 the work
    could not be completed (a full disk, for example). 130 stopped by Ctrl-C. After
    3 and 130, with --resume, the command continues where it stopped.

    Parameters
    ----------
    case
        a case file (.toml), or a motion exported before (.nc, .csv)
    over
        what varies, PATH=LOW:HIGH:N, PATH=log:LOW:HIGH:N or PATH=1,2,3 for each axis; with --design PATH=LOW:HIGH
    measure
        what is measured, such as mean_velocity,mode_sequence; `vibrocap measures` lists them [default: mean_velocity]
    out
        folder for the results, stored as they come
    resume
        continue the study in --out, repairing it if it is damaged; start one if there is none
    mixed
        with --resume, continue even if the study was started by another version or processor; new tiles are marked
    export
        write the results to FILE.nc (NetCDF), FILE.csv, FILE.xlsx (Excel) or FILE.mat (MATLAB) too
    unit_headings
        of the columns of --export FILE.csv or .xlsx: name and unit, as in "drift [m]"
    cases
        instead of --over, a table FILE.csv: a row of paths, then a row of values for each run
    design
        spread --runs points over the ranges of --over: sobol, halton, latin-hypercube or random
    runs
        number of runs of a design
    seed
        seed of a design; the same seed gives the same runs [default: 0]
    adaptive
        run points only where the mode sequence, the travel or the response period changes; writes to --export
    periods
        drive periods of a run, at most; a whole number [default: the case's]
    window
        drive periods at the end of a run that are measured if it does not settle [default: 10, or all]
    settle
        end a run once it is this near to a steady motion, relative to the states' size; 0: never [default: 1e-6]
    no_extrapolate
        let each run wait until it settles; else it continues from the extrapolated limit of its states if that holds
    tolerance
        error per step, relative to the states' natural size [default: the case's]
    threads
        number of threads [default: one for each core]
    workers
        number of processes on this machine, each of one thread
    device
        cpu, or cuda: an NVIDIA GPU
    tile_runs
        runs that are computed and stored together; what Ctrl-C loses [default: some five seconds of work]
    yes
        allow more than ten million runs
    """
    options = dict(locals())
    from vibrocap.cli.commands.sweep_request import SweepRequest
    from vibrocap.studies.execution import MAX_RUNS
    from vibrocap.studies.sweep import size_in_words

    request = SweepRequest(**options)
    study = request.study()
    if study.plan.count > MAX_RUNS and not yes:
        size = size_in_words(study, threads)
        raise Refusal(f"The study is large: {size}. Say --yes if that is meant, or give fewer values to --over.")
    begun = time.monotonic()
    try:
        found: Any = _adaptive(study, request) if adaptive else _run(study, request)
        seconds = time.monotonic() - begun
        if export is not None:
            from vibrocap.io.study_file import write_study

            write_study(out or found.dataset(), export, unit_headings=unit_headings)
    except OSError as error:
        if isinstance(error, BrokenPipeError):
            raise
        complain(_disk_failure(error, request))
        return INCOMPLETE
    print_study(found, seconds, out, export)
    return OK


def measures(case: Path | None = None, /) -> int:
    """The measures that `vibrocap sweep --measure` takes, what they mean and their units in SI.

    Parameters
    ----------
    case
        only those that mean something for this case; without units for one that has none [default: all]
    """
    from vibrocap.measures.during_run import measure_table
    from vibrocap.measures.standard import undefined_measures

    system = None if case is None else read_source(case).system
    with_units = system is None or system.units is not None
    made = table(None, "measure", *(["unit"] if with_units else []), "meaning", no_wrap=1 + with_units)
    without = () if system is None else undefined_measures(system)
    for name, each in measure_table(system).items():
        if name not in without:
            made.add_row(name, *([each.si_unit.replace("1", "")] if with_units else []), each.meaning)
    page = Page()
    page.print(made)
    page.print("Of every run there are also status, settled, response_period, window_start and window_periods.")
    return OK


def _run(study: "Study", request: "SweepRequest") -> "Outcome":
    """How a study ended that is stored as it runs, or kept in memory."""
    from vibrocap.studies.sweep import Stopped, carried_out

    left = TimeLeft()
    try:
        with notes(), progress("Sweeping") as report:
            completed = carried_out(
                study, request, lambda share: report(share, " ".join(("Sweeping", left.words(share))).strip())
            )
    except CaseError as error:
        if request.out is None or error.source != str(request.out):
            raise
        raise Refusal(*(f"--out: {request.out} {complaint}" for complaint in error.complaints)) from None
    except Stopped as stopped:
        done = str(stopped).partition(";")[0]
        raise KeyboardInterrupt(f"{done}. With --resume the same command continues.") from None
    return _outcome(completed)


def _adaptive(study: "Study", request: "SweepRequest") -> "Outcome":
    """How an adaptive map of a study over two axes ended."""
    from vibrocap.studies.adaptive import adaptive_map

    with progress("Mapping") as report:
        dataset = adaptive_map(
            study.case.system,
            {axis.path: axis.array for axis in study.plan.axes},  # type: ignore[attr-defined]
            measures=[name for name in study.measures if isinstance(name, str)],
            initial=study.case.initial,
            threads=request.threads,
            progress=lambda done, wanted: report(done / wanted, f"Mapping, {done:,} runs so far"),
            **{name: value for name, value in study.settings.items() if name not in ("device", "settle")},
            settle=study.settle or 0.0,
        )
    status = dataset["status"].values
    settled = int((dataset["settled"].values.astype(bool) & (status == 0)).sum()) if "settle" in dataset.attrs else None
    sizes = {str(dim): size for dim, size in dataset.sizes.items()}
    made = int(dataset.attrs["runs_computed"])
    return Outcome(sizes, Counter(status.ravel().tolist()), settled, lambda: dataset, made)


def _disk_failure(error: OSError, request: "SweepRequest") -> str:
    """One paragraph about a disk that did not take the results."""
    from vibrocap.studies.store.writing import StoreError

    if isinstance(error, StoreError):
        return f"The study could not be completed: {str(error).replace(' (resume=True)', '')}."
    kept = "" if request.out is None else f" {_kept(request.out)}"
    if isinstance(error, WriteError):
        return f"The study could not be exported: {error}.{kept}"
    reason = error.strerror or str(error)
    return f"The study could not be completed: {error.filename or request.export}: {reason}.{kept}"


def _kept(out: Path) -> str:
    """What is left of the results, looked at now."""
    from vibrocap.studies.store.verification import verify_study

    try:
        found = verify_study(out)
    except (CaseError, OSError):
        return f"The results in {out} are lost."
    if found.finished:
        return f"The results are whole in {out}; with --resume nothing is run twice."
    return f"Of the results in {out} some are damaged or missing; --resume computes these again."


@dataclasses.dataclass(frozen=True)
class Outcome:
    """How the runs of a study ended: by status, and how many of the finished ones settled (None: it was not asked).

    dataset: gives the results, labelled; made: of an adaptive map, the runs that were made; the others are filled in
    became: how many of the finished ones became what, where the measure `outcome` was taken
    """

    sizes: Mapping[str, int]
    statuses: Counter[int]
    settled: int | None
    dataset: Callable[[], Any]
    made: int | None = None
    became: Mapping[str, int] = dataclasses.field(default_factory=dict)


def _outcome(found: "Completed") -> Outcome:
    """That of a study, looked at in parts, in memory that does not grow with a study in a store but for words."""
    from vibrocap.measures.standard import OUTCOME

    statuses: Counter[int] = Counter()
    settled = 0
    for status, settling in found.numbers("status", "settled"):
        statuses.update({int(code): int((status == code).sum()) for code in np.unique(status)})
        settled += int((settling & (status == 0)).sum())
    study = found.study
    sizes = dict(zip(study.plan.dims, study.plan.shape, strict=True))
    became: Counter[str] = Counter()
    if OUTCOME in study.measures:
        dataset = found.dataset()
        became.update(map(str, dataset[OUTCOME].values[dataset["status"].values == 0].tolist()))
    return Outcome(sizes, statuses, None if study.settle is None else settled, found.dataset, became=became)


def print_study(found: Outcome, seconds: float, out: Path | None, export: Path | None) -> None:
    """The summary of a study: its runs, how they ended, where the results are and what to do next."""
    from vibrocap.plotting.studies.view import status_label

    statuses = Counter(found.statuses)
    sizes = ", ".join(f"{dim} {size:,}" for dim, size in found.sizes.items())
    runs = sum(statuses.values())
    finished = statuses.pop(0, 0)
    page = Page()
    page.say(f"{runs:,} runs ({sizes}) in {duration(seconds)}")
    if found.made is not None:
        page.say(f"  made       {found.made:,} ({found.made / runs:.1%}); the others are filled in between")
    page.print(f"  finished   {finished:,}")
    for code, count in statuses.most_common():
        page.say(f"  failed     {count:,}: {status_label(code)}")
    if found.settled is not None:
        unsettled = finished - found.settled
        more = f"; {unsettled:,} did not, and may with more --periods" if unsettled else ""
        page.say(f"  settled    {found.settled / max(1, finished):.1%} of these{more}")
    for name, count in sorted(found.became.items(), key=lambda each: -each[1]):
        page.say(f"             {count:,}: {name}")
    for place in (out, export):
        if place is not None:
            page.say(f"  stored in  {place}")
    drawn = out or (export if export is not None and export.suffix.lower() == ".nc" else None)
    if drawn is not None:
        page.say(f"Next: vibrocap plot {drawn}")


def plot(
    source: Path,
    /,
    *,
    measure: str | None = None,
    out: Path | None = None,
    at: list[str] | None = None,
    border: list[str] | None = None,
    dead_band: float | None = None,
) -> int:
    """A picture of a study: a map over two axes, lines over one, panels for friction laws side by side.

    Failed, unsettled and missing runs are hatched and counted in the legend; runs
    without travel have a colour of their own.

    For --border mode_sequence the sweep must have had --measure mode_sequence. --border travel is where
    the way of travel turns round, --border impacts where a mass grazes its stop.

    Parameters
    ----------
    source
        the folder of a study (`vibrocap sweep --out`), or FILE.nc with an exported one
    measure
        the measure to draw, or status, settled, response_period [default: the first measure]
    out
        FILE.png, .svg or .pdf [default: a .png beside the study, named after it and the measure]
    at
        PATH=VALUE, where a further axis is fixed (at the nearest value); may be repeated
    border
        draw lines where this changes on a map, such as mode_sequence or travel; may be repeated
    dead_band
        smaller velocities count as no travel [default: the residue of runs that settled, or 1e-6]
    """
    needs("plot", "xarray", "zarr", "matplotlib")
    from vibrocap.plotting.studies.view import first_measure, study_view

    complaints = Complaints()
    fixed = pairs("at", at, complaints, "PATH=VALUE, such as drive.frequency=1.2")
    if dead_band is not None and not 0.0 <= dead_band < float("inf"):
        complaints.append(f"--dead-band: should be a number >= 0, got {dead_band:g}")
    with complaints.collected():
        writable_picture("--out", out)
    from vibrocap.studies.dataset import open_study

    try:
        dataset = open_study(source)
    except CaseError as error:
        raise Refusal(*complaints, *(f"{source}: {complaint}" for complaint in error.complaints)) from None
    path = out or picture_path(source, measure or first_measure(dataset))
    if out is None and path.is_file() and b"Matplotlib" not in path.read_bytes()[:1000]:
        complaints.add("--out", f"{str(path)!r} is there, and was not drawn by this command; name a picture")
    with complaints.collected():
        view = study_view(dataset, measure, fixed, dead_band)
        writable_picture("--out", path)
        if not complaints:
            from vibrocap.plotting.studies.maps import plot_view

            plot_view(view, path, border)
    if complaints:
        raise Refusal(*dict.fromkeys(complaints))
    Page().say(f"Picture: {path}")
    return OK


def picture_path(source: Path, measure: str) -> Path:
    """Where the picture of a study goes that is given no place: beside it."""
    place = source if source.name not in ("", "..") else source.resolve()
    word = "".join(c if c.isalnum() or c in "_.-" else "_" for c in measure)
    return place.with_name(f"{place.stem if place.is_file() else place.name}-{word}.png")


def verify(study: Path, /) -> int:
    """Whether a stored study is as it was written: every file is compared with its checksum.

    A file that is missing, cut short, altered or in place of another one is
    named. The sweep with --resume computes damaged tiles again.

    Exit codes: 0 all that is stored is whole, finished or not. 3 something is
    damaged. 2 there is no study, or none that vibrocap wrote.

    Parameters
    ----------
    study
        the folder of a study (`vibrocap sweep --out`)
    """
    needs("verify", "xarray", "zarr")
    from vibrocap.studies.store.verification import verify_study

    found = verify_study(study)
    page = Page()
    for line in found.lines():
        page.say(f"  damaged    {line}")
    if found.mixed:
        page.say(f"  mixed      {len(found.mixed):,} tiles were not computed with what the study was begun with")
    state = f"{found.stored:,} of {found.tiles:,} tiles are stored"
    if not found.ok:
        page.say(f"{study}: damaged; {state}. The sweep with --resume mends what it can.")
        return INCOMPLETE
    if not found.checked:
        state += "; this store of an earlier format has no checksums, nothing is missing"
    page.say(f"{study}: whole; {state}.")
    return OK
