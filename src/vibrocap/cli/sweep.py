"""The commands `vibrocap sweep` and `vibrocap measures`: many runs, measured on the way, stored as they go."""

import math
import time
from collections import Counter
from pathlib import Path
from typing import TYPE_CHECKING, Any

from vibrocap.case import CaseError
from vibrocap.cli.exits import INCOMPLETE, OK, complain
from vibrocap.cli.terminal import Page, Refusal, progress

if TYPE_CHECKING:
    from vibrocap.cli.sweep_request import SweepRequest
    from vibrocap.studies.study import Study

BLOCK = 4_000_000  # runs whose status is counted at a time


def sweep(
    case: Path,
    /,
    *,
    over: list[str] | None = None,
    measure: list[str] | None = None,
    out: Path | None = None,
    resume: bool = False,
    export: Path | None = None,
    cases: Path | None = None,
    design: str | None = None,
    runs: int | None = None,
    seed: int | None = None,
    adaptive: bool = False,
    periods: float | None = None,
    window: int | None = None,
    settle: float | None = None,
    tolerance: float | None = None,
    threads: int | None = None,
    workers: int | None = None,
    scheduler: str | None = None,
    device: str = "cpu",
    yes: bool = False,
) -> int:
    """Many runs of a case with other values: a map, a list of cases or a design, measured during the run.

    What varies is named by its path: a parameter (machine.mass_ratio), a start
    (initial.angle), or a kind (friction.law=exponential,lugre).

    Example: vibrocap sweep examples/travels-by-stick-slip.toml --over drive.amplitude=1:3:40 --out map

    Exit codes: 0 done; runs that failed are results like others, with their
    status, and the summary counts them. 2 wrong input, all of it named before
    any work; a folder that holds another study; a study too large without
    --yes. 3 the work could not be completed, such as on a full disk: what was
    stored is whole, and --resume goes on. 130 stopped by Ctrl-C: likewise.

    Parameters
    ----------
    case
        a case file (.toml), or a motion exported before (.nc, .csv)
    over
        what varies, PATH=LOW:HIGH:N, PATH=log:LOW:HIGH:N or PATH=1,2,3 for each axis; with --design PATH=LOW:HIGH
    measure
        what is measured, such as mean_velocity,word; `vibrocap measures` lists them [default: mean_velocity]
    out
        folder for the results, stored as they come
    resume
        go on with the study that --out holds; begin where it holds none
    export
        write the results to FILE.nc (NetCDF) or FILE.csv, at the end
    cases
        instead of --over, a table FILE.csv: a row of paths, then a row of values for each run
    design
        spread --runs over the ranges of --over: sobol, halton, latin-hypercube or random
    runs
        how many runs a design has
    seed
        of a design; the same seed gives the same runs [default: 0]
    adaptive
        a map into --export whose points are run along borders of word, travel and response period only
    periods
        drive periods of a run at most, a whole number, instead of the case's
    window
        drive periods at the end over which a run is measured that does not settle [default: 10]
    settle
        how near to a steady motion a run ends, as a share of each state's size; 0: never [default: 1e-6]
    tolerance
        error per step relative to the states' natural size, instead of the case's
    threads
        of this process [default: all cores]
    workers
        so many processes on this machine, by Dask
    scheduler
        the address of a Dask cluster whose workers see the folder --out
    device
        cpu or cuda
    yes
        run a study that is larger than ten million runs
    """
    from vibrocap.cli.sweep_request import SweepRequest

    request = SweepRequest(
        case=case,
        over=tuple(over or ()),
        measures=tuple(name.strip() for text in measure or ["mean_velocity"] for name in text.split(",")),
        out=out,
        export=export,
        resume=resume,
        cases=cases,
        design=design,
        runs=runs,
        seed=seed,
        adaptive=adaptive,
        periods=periods,
        window=window,
        settle=settle,
        tolerance=tolerance,
        threads=threads,
        workers=workers,
        scheduler=scheduler,
        device=device,
    )
    study = request.study()
    _check_size(study, threads, yes)
    begun = time.monotonic()
    try:
        dataset = _adaptive(study, request) if adaptive else _run(study, request)
        seconds = time.monotonic() - begun
        if export is not None:
            _export(dataset if out is None else out, export)
    except OSError as error:
        if isinstance(error, BrokenPipeError):
            raise
        complain(_what_happened(error, request))
        return INCOMPLETE
    print_study(dataset, seconds, out, export)
    return OK


def measures(case: Path | None = None, /) -> int:
    """What `vibrocap sweep --measure` can ask for, with what it means.

    Example: vibrocap measures examples/bristles-lugre.toml

    Parameters
    ----------
    case
        list only what the machine and the law of this case file have; without it, those of all
    """
    from rich.box import SIMPLE_HEAD
    from rich.table import Table

    from vibrocap.io.motion_file import read_source
    from vibrocap.measures.during_run import measure_table

    system = None if case is None else read_source(case).system

    table = Table(box=SIMPLE_HEAD, header_style="dim")
    table.add_column("measure", no_wrap=True)
    table.add_column("meaning")
    for name, each in measure_table(system).items():
        table.add_row(name, each.meaning)
    page = Page()
    page.print(table)
    page.print("Of every run there are also status, settled, response_period, window_start and window_periods.")
    return OK


def _check_size(study: "Study", threads: int | None, yes: bool) -> None:
    from vibrocap.studies.sweep import MAX_RUNS, size_in_words

    if study.plan.count > MAX_RUNS and not yes:
        size = size_in_words(study, threads)
        raise Refusal(f"The study is large: {size}. Say --yes if that is meant, or give fewer values to --over.")


def _run(study: "Study", request: "SweepRequest") -> Any:
    """The results of a study that is stored as it runs, or kept in memory."""
    from vibrocap.cli.time_left import TimeLeft
    from vibrocap.studies.sweep import Stopped, run_study

    left = TimeLeft()
    try:
        with progress("Sweeping") as report:
            return run_study(
                study,
                out=request.out,
                resume=request.resume,
                yes=True,
                threads=request.threads,
                workers=request.workers,
                scheduler=request.scheduler,
                device=request.device,
                progress=lambda share: report(share, " ".join(("Sweeping", left.words(share))).strip()),
            )
    except CaseError as error:
        if request.out is None or error.source != str(request.out):
            raise
        raise Refusal("\n".join(f"--out: {request.out} {complaint}" for complaint in error.complaints)) from None
    except Stopped as stopped:
        done = str(stopped).partition(";")[0]
        raise KeyboardInterrupt(f"{done}. The same command with --resume goes on.") from None


def _adaptive(study: "Study", request: "SweepRequest") -> Any:
    """An adaptive map of a study over two axes."""
    from vibrocap.studies.adaptive import adaptive_map

    with progress("Mapping") as report:
        return adaptive_map(
            study.case.system,
            {axis.path: axis.array for axis in study.plan.axes},  # type: ignore[attr-defined]
            measures=[name for name in study.measures if isinstance(name, str)],
            initial=study.case.initial,
            threads=request.threads,
            progress=lambda done, wanted: report(done / wanted, f"Mapping, {done:,} runs so far"),
            **{name: value for name, value in study.settings.items() if name != "device"},
        )


def _export(source: Any, path: Path) -> None:
    from vibrocap.io.study_file import write_study

    path.parent.mkdir(parents=True, exist_ok=True)
    write_study(source, path)


def _what_happened(error: OSError, request: "SweepRequest") -> str:
    """One paragraph about a disk that did not take the results."""
    from vibrocap.studies.writing import StoreError

    if isinstance(error, StoreError):
        return f"The study could not be completed: {str(error).replace(' (resume=True)', '')}."
    reason = error.strerror or str(error)
    kept = f" The results are whole in {request.out}; with --resume nothing is run twice." if request.out else ""
    return f"The study could not be completed: {error.filename or request.export}: {reason}.{kept}"


def print_study(dataset: Any, seconds: float, out: Path | None, export: Path | None) -> None:
    """The summary of a study: its runs, how they ended, where the results are and what to do next."""
    from vibrocap.cli.time_left import duration
    from vibrocap.plotting.study_view import status_word

    statuses, settled = tally(dataset)
    sizes = ", ".join(f"{dim} {size:,}" for dim, size in dataset.sizes.items())
    runs = sum(statuses.values())
    finished = statuses.pop(0, 0)
    page = Page()
    page.print(f"{runs:,} runs ({sizes}) in {duration(seconds)}", soft_wrap=True)
    if "runs_computed" in dataset.attrs:
        made = int(dataset.attrs["runs_computed"])
        page.print(f"  made       {made:,} ({made / runs:.1%}); the others are filled in between", soft_wrap=True)
    page.print(f"  finished   {finished:,}")
    for code, count in statuses.most_common():
        page.print(f"  failed     {count:,}: {status_word(code)}", soft_wrap=True)
    if "settle" in dataset.attrs:
        unsettled = finished - settled
        more = f"; {unsettled:,} did not, and may with more --periods" if unsettled else ""
        page.print(f"  settled    {settled / max(1, finished):.1%} of these{more}", soft_wrap=True)
    for place in (out, export):
        if place is not None:
            page.print(f"  stored in  {place}", soft_wrap=True)
    drawn = out or (export if export is not None and export.suffix.lower() == ".nc" else None)
    if drawn is not None:
        page.print(f"Next: vibrocap plot {drawn}", soft_wrap=True)


def tally(dataset: Any) -> tuple[Counter[int], int]:
    """(runs by status, how many of the finished ones settled), in memory that does not grow with the study."""
    dims = [str(dim) for dim in dataset["status"].dims]
    rest = math.prod(dataset.sizes[dim] for dim in dims[1:])
    rows = max(1, BLOCK // max(1, rest))
    statuses: Counter[int] = Counter()
    settled = 0
    for start in range(0, dataset.sizes[dims[0]], rows):
        part = dataset.isel({dims[0]: slice(start, start + rows)})
        status = part["status"].values
        statuses.update({code: int((status == code).sum()) for code in set(status.ravel().tolist())})
        settled += int((part["settled"].values.astype(bool) & (status == 0)).sum())
    return statuses, settled
