"""`vibrocap sweep`: many runs, measured on the way, and the check of a stored study."""

import dataclasses
import shlex
import time
from collections import Counter
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from vibrocap.arguments import Refusal
from vibrocap.case.case import CaseError
from vibrocap.cli.command import Answer, command
from vibrocap.cli.options import needs
from vibrocap.cli.sweep_request import SweepRequest
from vibrocap.cli.terminal import Page, TimeLeft, duration, notes, progress
from vibrocap.files import WriteError

if TYPE_CHECKING:
    from vibrocap.studies.plan.study import Study
    from vibrocap.studies.sweep import Completed


@command(
    "run",
    "vibrocap sweep case.toml --over drive.amplitude=1:3:20 --out line",
    "vibrocap sweep case.toml --over machine.mass_ratio=log:0.2:8:20"
    " --over drive.amplitude=1:3:10 --measure mean_velocity,mode_sequence --out map",
    "vibrocap sweep case.toml --over friction.law=lugre,dahl --export laws.csv",
    "vibrocap sweep map --verify",
)
def sweep(request: SweepRequest) -> Answer:
    """Many runs over axes, a table of cases or a design.

    A path names each axis: a parameter (machine.mass_ratio), an initial state (initial.angle), or a kind of part
    (friction.law=exponential,lugre). An adaptive map goes to --export. --verify names every file that is missing, cut
    short, altered or in place of another one; with --resume, the sweep computes damaged tiles again.

    Exit codes: 0 done, also if some runs failed: they have their status, and the summary counts them. 2 wrong input,
    all of it named before any work. 3 the work could not be completed (a full disk, for example), or a study is
    damaged. 130 stopped by Ctrl-C. After 3 and 130, with --resume, the command continues where it stopped.
    """
    from vibrocap.studies.sweep import MAX_RUNS, size_in_words

    if request.verify:
        return _verified(request.case)
    study = request.study()
    if study.plan.count > MAX_RUNS and not request.yes:
        size = size_in_words(study, request.threads)
        raise Refusal(f"The study is large: {size}. Say --yes if that is meant, or give fewer values to --over.")
    begun = time.monotonic()
    try:
        result: Any = _adaptive(study, request) if request.adaptive else _run(study, request)
        seconds = time.monotonic() - begun
        if request.export is not None:
            from vibrocap.io.study_file import write_study

            write_study(request.out or result.dataset(), request.export, unit_headings=request.unit_headings)
    except OSError as error:
        if isinstance(error, BrokenPipeError):
            raise
        return Answer(incomplete=_disk_failure(error, request))
    return Answer(text=lambda page: print_study(page, result, seconds, request.out, request.export))


def _verified(study: Path) -> Answer:
    """Whether a stored study is as it was written: every file is compared with its checksum."""
    needs("--verify", "xarray", "zarr")
    from vibrocap.studies.store.verification import verify_study

    result = verify_study(study)
    lines = [f"  damaged    {line}" for line in result.lines()]
    if result.mixed:
        lines.append(f"  mixed      {len(result.mixed):,} tiles of other sources, libraries or processor")
    state = f"{result.stored:,} of {result.tiles:,} tiles are stored"
    if not result.ok:
        lines.append(f"{study}: damaged; {state}.")
        return Answer(text="\n".join(lines), incomplete="With --resume, the sweep computes damaged tiles again.")
    return Answer(text="\n".join([*lines, f"{study}: whole; {state}."]))


def _run(study: "Study", request: "SweepRequest") -> "Outcome":
    from vibrocap.studies.sweep import Stopped, carried_out

    left = TimeLeft()
    try:
        with notes(), progress("Sweeping") as report:
            completed = carried_out(study, request.how, lambda x: report(x, f"Sweeping {left.words(x)}".strip()))
    except CaseError as error:
        if request.out is None or error.source != str(request.out):
            raise
        raise Refusal(*(f"--out: {request.out} {complaint}" for complaint in error.complaints)) from None
    except Stopped as stopped:
        done = str(stopped).partition(";")[0]
        raise KeyboardInterrupt(f"{done}. With --resume the same command continues.") from None
    return _outcome(completed)


def _adaptive(study: "Study", request: "SweepRequest") -> "Outcome":
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
    computed_runs = int(dataset.attrs["runs_computed"])
    return Outcome(sizes, Counter(status.ravel().tolist()), settled, lambda: dataset, computed_runs)


def _disk_failure(error: OSError, request: "SweepRequest") -> str:
    """One paragraph about a disk that did not take the results."""
    from vibrocap.studies.store.places import StoreError

    if isinstance(error, StoreError):
        return f"The study could not be completed: {str(error).replace(' (resume=True)', '')}."
    kept = "" if request.out is None else f" {_kept(request.out)}"
    if isinstance(error, WriteError):
        return f"The study could not be exported: {error}.{kept}"
    return f"The study could not be completed: {error.filename or request.export}: {error.strerror or error}.{kept}"


def _kept(out: Path) -> str:
    """What is left of the results, looked at now."""
    from vibrocap.studies.store.verification import verify_study

    try:
        result = verify_study(out)
    except (CaseError, OSError):
        return f"The results in {out} are lost."
    if result.finished:
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
    computed: int | None = None
    became: Mapping[str, int] = dataclasses.field(default_factory=dict)


def _outcome(outcome: "Completed") -> Outcome:
    """That of a study, looked at in parts, in memory that does not grow with a study in a store but for words."""
    from vibrocap.measures.standard import OUTCOME

    statuses: Counter[int] = Counter()
    became: Counter[str] = Counter()
    settled, study = 0, outcome.study
    for status, settling in outcome.numbers("status", "settled"):
        statuses.update({int(code): int((status == code).sum()) for code in np.unique(status)})
        settled += int((settling & (status == 0)).sum())
    sizes = dict(zip(study.plan.dims, study.plan.shape, strict=True))
    if OUTCOME in study.measures:
        dataset = outcome.dataset()
        became.update(map(str, dataset[OUTCOME].values[dataset["status"].values == 0].tolist()))
    return Outcome(sizes, statuses, None if study.settle is None else settled, outcome.dataset, became=became)


def print_study(page: Page, outcome: Outcome, seconds: float, out: Path | None, export: Path | None) -> None:
    """The summary of a study: its runs, how they ended, where the results are and what to do next."""
    from vibrocap.plotting.studies.view import status_label

    statuses, sizes = Counter(outcome.statuses), ", ".join(f"{dim} {size:,}" for dim, size in outcome.sizes.items())
    runs, finished = sum(statuses.values()), statuses.pop(0, 0)
    page.say(f"{runs:,} runs ({sizes}) in {duration(seconds)}")
    if outcome.computed is not None:
        page.say(f"  made       {outcome.computed:,} ({outcome.computed / runs:.1%}); the others are filled in between")
    page.print(f"  finished   {finished:,}")
    for code, count in statuses.most_common():
        page.say(f"  failed     {count:,}: {status_label(code)}")
    if outcome.settled is not None:
        unsettled = finished - outcome.settled
        more = f"; {unsettled:,} did not, and may with more --periods" if unsettled else ""
        page.say(f"  settled    {outcome.settled / max(1, finished):.1%} of these{more}")
    for name, count in sorted(outcome.became.items(), key=lambda pair: -pair[1]):
        page.say(f"             {count:,}: {name}")
    for place in (out, export):
        if place is not None:
            page.say(f"  stored in  {place}")
    drawn = out or (export if export is not None and export.suffix.lower() == ".nc" else None)
    if drawn is not None:
        page.say(f"Next: vibrocap plot {shlex.quote(str(drawn))}")
