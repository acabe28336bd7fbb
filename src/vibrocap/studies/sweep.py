"""sweep(system, over=...) -> Dataset: many runs, measured on the way, stored as they go, resumed after anything."""

import contextlib
import dataclasses
import math
import warnings
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import Executor, ThreadPoolExecutor
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from vibrocap.arguments import Complaint, Complaints, check_whole, require
from vibrocap.case.case import Case, CaseError
from vibrocap.measures.measure import Measure
from vibrocap.numerics import api as numerics
from vibrocap.physics.system import System
from vibrocap.progress import Progress, reporting
from vibrocap.quantities.declared import ByName
from vibrocap.resources import available_memory, free_disk, in_words
from vibrocap.studies.dataset import empty_results, labelled, open_study
from vibrocap.studies.plan.designs import Design
from vibrocap.studies.plan.planning import planned_study
from vibrocap.studies.plan.runs import tile_counts
from vibrocap.studies.plan.study import Study, code_of
from vibrocap.studies.store.chunks import stored_numbers
from vibrocap.studies.store.places import DamageWarning
from vibrocap.studies.store.record import read_record
from vibrocap.studies.store.store import Opened, opened_for_writing
from vibrocap.studies.store.zarr_form import checked_results
from vibrocap.studies.tile import run_tile, tile_block, tile_indices, tile_runs_by_time, tile_shape
from vibrocap.studies.variables import variables

if TYPE_CHECKING:
    import xarray

MAX_RUNS = 10_000_000


@dataclasses.dataclass(frozen=True, kw_only=True)
class Execution:
    """All that is said of how a study is carried out, see `sweep`; the results do not depend on it."""

    out: Path | None = None
    resume: bool = False
    mixed: bool = False
    max_runs: int = MAX_RUNS
    yes: bool = False
    tile_runs: int | None = None
    threads: int | None = None
    device: str = "cpu"
    workers: int | Executor | None = None

    def complaints(self) -> list[Complaint]:
        complaints = Complaints()
        for name in ("max_runs", "tile_runs", "threads", "workers"):
            with complaints.collected():
                number = getattr(self, name)
                check_whole(name, 1 if number is None or isinstance(number, Executor) else number, 1)
        if self.mixed and not self.resume:
            complaints.add("mixed", "continues a stored study, for which resume has to be given, too")
        for name in ("resume", "workers"):
            if getattr(self, name) and self.out is None:
                complaints.add(name, "needs a folder for the results (out)")
        with complaints.collected():
            numerics.device(self.device)
        return [complaint for complaint in complaints if isinstance(complaint, Complaint)]


STORED = 0.2  # bytes on a disk over bytes in memory, at least, of results that are not all the same
SECONDS = {"set-valued": 2e-6, "kinked": 4e-6, "smooth": 3e-6}  # per run and period on one core, by kind of law

Report = Callable[[float], None] | None


class Stopped(KeyboardInterrupt):
    """A study was interrupted; the message says how far it is and how to resume it."""


def sweep(
    system: System,
    over: Mapping[str, Any] | None = None,
    *,
    measures: Sequence[str | Measure] = ("mean_velocity",),
    cases: Iterable[Mapping[str, Any]] | None = None,
    design: Design | None = None,
    initial: ByName | None = None,
    periods: float = Case.periods,
    window: int | None = None,
    settle: float | None = None,
    extrapolate: bool = True,
    tolerance: float = Case.tolerance,
    max_events_per_period: int = Case.max_events_per_period,
    max_steps: int = Case.max_steps,
    out: str | Path | None = None,
    resume: bool = False,
    mixed: bool = False,
    max_runs: int = MAX_RUNS,
    yes: bool = False,
    tile_runs: int | None = None,
    threads: int | None = None,
    device: str = "cpu",
    workers: int | Executor | None = None,
    progress: Progress = None,
) -> "xarray.Dataset":
    """Run a system over every combination of values, over a list of cases, or over a design, and measure each run.

    over: {path: values}, each path a dimension of the result, such as {"machine.mass_ratio": np.linspace(0.1, 8, 400),
        "friction.law": ["exponential", "lugre"], "initial.angle": "log:0.01:1:20"}; with `design` {path: (low, high)}
    cases: instead of `over`, [{path: value, ...}, ...], along the dimension "case"; other values are those of `system`
        and `initial`
    design: spread `design.runs` runs over the ranges in `over`, along the dimension "run"
    measures: names from `measure_table(system)`, or measures of one's own
    initial: initial condition of all runs; others start at zero
    periods, window, settle, extrapolate, tolerance, max_events_per_period, max_steps: of each run, see `ensemble`;
        settle is max(1e-6, 1000 tolerance) by default, and with 0 no run settles
    out: a folder for the results, stored tile by tile; without it they stay in memory
    resume: continue the study in `out`, or begin one. Stored tiles are compared with their checksums, and damaged ones
        computed again, with a DamageWarning that names them
    mixed: resume a study of another version, processor or library, which is refused otherwise; new tiles are marked,
        and may differ in the last digits or, of chaotic motions, altogether
    max_runs, yes: more runs than this are refused, saying how large the study is, unless `yes`
    tile_runs: runs that are computed and stored together (about), and lost by an interruption; by default some five
        seconds of work, 4096 runs at most
    threads: of this process, all cores by default
    device: "cpu", or a device that another package brings, whose results agree with the processor's to rounding
    workers: so many processes of this machine (in a script, below `if __name__ == "__main__":`), or an executor of
        `concurrent.futures`, such as `client.get_executor()` of Dask; they need `out`, which this process writes
    progress: True for a bar, or a function that is called now and then with the share done

    Returns one variable per measure, with `status`, `settled`, `response_period`, `window_start` and `window_periods`
    of every run: a run that failed is NaN and its status gives the reason. The results depend neither on tiles or
    threads nor on interruptions, after which a store has the same bytes; on what else, see `plan.study.code_version`.

    Raises CaseError with every complaint at once, StoreError where `out` does not take the results, ModuleNotFoundError
    without xarray (for `out` zarr), all before any work; Stopped (a KeyboardInterrupt) when interrupted.
    """
    where: dict[str, Any] = {"out": None if out is None else Path(out), "resume": resume, "mixed": mixed}
    how = {"tile_runs": tile_runs, "threads": threads, "device": device, "workers": workers}
    execution = Execution(**where, **how, max_runs=max_runs, yes=yes)
    require("a sweep", "xarray", "zarr")
    settings: dict[str, Any] = {"window": window, "settle": settle, "extrapolate": extrapolate, "periods": periods}
    settings |= {"tolerance": tolerance, "max_events_per_period": max_events_per_period, "max_steps": max_steps}
    runs: dict[str, Any] = {"measures": measures, "cases": cases, "design": design, "initial": initial}
    study = planned_study(system, over, **runs, settings=settings, also=execution.complaints())
    return carried_out(study, execution, progress).dataset()


@dataclasses.dataclass(frozen=True)
class Completed:
    """A study of which all runs were made; its results are in a store, or in memory by name."""

    study: Study
    results: Path | Mapping[str, np.ndarray]

    def dataset(self) -> "xarray.Dataset":
        if isinstance(self.results, Path):
            return open_study(self.results)
        return labelled(self.study, self.results)

    def numbers(self, *names: str) -> Iterator[tuple[np.ndarray, ...]]:
        """Arrays of numbers as they are stored, by parts that fit into memory; read without Zarr and xarray."""
        if isinstance(self.results, Path):
            record = read_record(self.results)
            yield from stored_numbers(self.results, record, checked_results(self.results, record), names)
        else:
            yield tuple(self.results[name] for name in names)


def carried_out(study: Study, how: Execution, progress: Progress = None) -> Completed:
    """A study that is planned, or was stored (`stored_study`), run with the code as it is now; see `sweep`."""
    require("a sweep", "xarray", "zarr")
    study = dataclasses.replace(study, code=code_of(study.plan, how.device), device=how.device)
    if study.plan.count > how.max_runs and not how.yes:
        raise CaseError([f"{size_in_words(study, how.threads)}; add --yes (yes=True) to run it"], "the study")
    _check_room(study, how.out, how.yes)
    tile_runs = how.tile_runs or numerics.device(how.device).tile_runs
    if tile_runs is None and how.out is not None and not how.workers:
        tile_runs = tile_runs_by_time(study, how.out, how.threads)
    tile = tile_shape(study.plan.shape, tile_runs)
    with reporting(progress, "Sweeping") as report:
        report = report and _rising(report)
        if how.out is None:
            return Completed(study, _in_memory(study, tile, how.threads, report))
        _store(study, tile, how.out, how, report)
        return Completed(study, how.out)


def _check_room(study: Study, out: Path | None, yes: bool) -> None:
    """CaseError where the results fit neither into memory nor, as far as can be told before, onto the disk."""
    needed = _bytes(study)
    if out is None and needed > (free := available_memory()):
        size = f"{in_words(needed)} of memory, {in_words(free)} are free"
        raise CaseError([f"{study.plan.count:,} runs need {size}; give a folder for the results, out"], "the study")
    if out is not None and not yes and STORED * needed > (free := free_disk(out)):
        size = f"{study.plan.count:,} runs take roughly {in_words(STORED * needed)}, {in_words(free)} are free there"
        raise CaseError([f"{size}; give another folder, or add --yes (yes=True) to try"], str(out))


def _bytes(study: Study) -> float:
    """Of the results in memory."""
    return float(study.plan.count) * sum(np.dtype(variable.dtype).itemsize for variable in variables(study))


def spread(tiles: Sequence[tuple[int, ...]]) -> list[tuple[int, ...]]:
    """The same tiles in an order in which any number of the first ones is spread over all of them.

    Costs change slowly over a study, so that the first tiles tell the time of the others. The steps are of the golden
    ratio, made coprime.
    """
    count = len(tiles)
    step = max(1, round(count * (math.sqrt(5.0) - 1.0) / 2.0))
    while math.gcd(step, count) > 1:
        step += 1
    return [tiles[i * step % count] for i in range(count)]


def size_in_words(study: Study, threads: int | None = None) -> str:
    """How many runs, how many bytes before compression, and roughly how long."""
    runs, gigabytes, cores = study.plan.count, _bytes(study) / 1e9, threads or numerics.available_threads()
    seconds = runs * study.case.periods * max(SECONDS[law.kind] for law in study.case.system.laws) / cores
    return f"{runs:,} runs, {gigabytes:.3g} GB of results, roughly {_duration(seconds)} on {cores} threads"


def _rising(progress: Callable[[float], None]) -> Callable[[float], None]:
    """Progress without steps back, which threads that report side by side would make."""
    last = -1.0

    def report(share: float) -> None:
        nonlocal last
        if share > last:
            last = share
            progress(share)

    return report


def _duration(seconds: float) -> str:
    for unit, length in (("days", 86_400.0), ("hours", 3_600.0), ("minutes", 60.0)):
        if seconds >= 2 * length:
            return f"{seconds / length:.0f} {unit}"
    return f"{math.ceil(seconds)} seconds"


def _in_memory(study: Study, tile: tuple[int, ...], threads: int | None, progress: Report) -> dict[str, np.ndarray]:
    """All tiles, into arrays."""
    shape = study.plan.shape
    results = empty_results(study)
    total = math.prod(tile_counts(shape, tile))
    for done, index in enumerate(spread(list(tile_indices(shape, tile)))):
        share = progress and (lambda x, done=done: progress((done + x) / total))
        for name, part in run_tile(study, tile, index, threads=threads, progress=share).items():
            results[name][tile_block(shape, tile, index)] = part
    if progress:
        progress(1.0)
    return results


def _store(study: Study, tile: tuple[int, ...], out: Path, how: Execution, progress: Report) -> None:
    """All tiles that are not stored yet, into a store."""
    with contextlib.ExitStack() as stack:
        if isinstance(how.workers, Executor):  # of another machine, perhaps
            study = dataclasses.replace(study, code=how.workers.submit(code_of, study.plan, how.device).result())
        opened = opened_for_writing(out, study, tile, resume=how.resume, mixed=how.mixed)
        stack.callback(opened.lock.release)
        store = opened.store
        if opened.damage:
            words = "; ".join(opened.damage)
            warnings.warn(f"{out}: is damaged, and mended: {words}", DamageWarning, stacklevel=4)
        total = math.prod(tile_counts(study.plan.shape, store.tile))
        try:
            pending = spread(store.pending())
            report = progress and (lambda x: progress((total - len(pending) + x) / total))
            if report:
                report(0.0)
            if how.workers:
                from vibrocap.studies.workers import run_on_workers

                run_on_workers(store, pending, how.workers, how.mixed, report)
            else:
                _run_here(opened, pending, how.threads, report)
            if report:
                report(float(len(pending)))
            store.finish()
        except KeyboardInterrupt:
            stored = f"{total - len(store.pending())} of {total} tiles are stored in {out}"
            store.clean()
            raise Stopped(f"Stopped: {stored}; continue with --resume (resume=True)") from None


def _run_here(opened: Opened, pending: Sequence[tuple[int, ...]], threads: int | None, report: Report) -> None:
    """Compute and store tiles in this process; one is on its way to the disk while the next is computed."""
    with ThreadPoolExecutor(1) as writer:
        store, writing = opened.store, None
        for done, index in enumerate(pending):
            share = report and (lambda x, done=done: report(done + x))
            arrays = run_tile(store.study, store.tile, index, threads=threads, progress=share)
            if writing:
                writing.result()
            writing = writer.submit(store.write, index, arrays, opened.made_by)
        if writing:
            writing.result()
