"""`vibrocap optimise`: the best settled, stable design of a case, with its orbit and a case file that runs."""

import shlex
from pathlib import Path
from typing import Annotated, Any

from cyclopts import Parameter

from vibrocap.arguments import Complaints
from vibrocap.cli.options import Refusal, needs, pairs, refusing, writable_folder, writable_picture
from vibrocap.cli.terminal import INCOMPLETE, OK, Page, complain, progress, said
from vibrocap.files import made_folder, write_table, write_text
from vibrocap.io.motion_file import read_source
from vibrocap.quantities.dimensional import in_si
from vibrocap.quantities.json_text import json_text

CASES = "cases"  # in the folder of a front


def optimise(
    case: Path,
    /,
    *,
    over: list[str],
    for_: Annotated[str, Parameter(name="--for")] = "mean_velocity",
    against: str | None = None,
    subject_to: list[str] | None = None,
    uncertain: list[str] | None = None,
    robust: str | None = None,
    samples: int | None = None,
    evaluations: int = 10_000,
    points: int | None = None,
    seed: int = 0,
    out: Path | None = None,
    resume: bool = False,
    plot: Path | None = None,
    report: bool = False,
    json: bool = False,
) -> int:
    """The design whose settled and stable motion has the best measure.

    Designs run in whole populations until they settle; the best are closed to
    periodic orbits, checked for stability and refined. What limits the best one is
    named: a bound, a constraint, stability, or a change of the mode sequence.
    With --against, the result is a Pareto front: the designs of which none is better
    than another in both measures.

    Exit code 3: no design settles to a stable motion that fulfils the constraints.

    Parameters
    ----------
    case
        a case file (.toml), or a motion exported before (.nc, .csv)
    over
        PATH=LEAST:LARGEST or PATH=log:LEAST:LARGEST, or choices with commas between; once for each design variable
    for_
        the measure to make large, or small if it is a cost; `vibrocap measures` lists them
    against
        a second measure, for a Pareto front (needs pymoo)
    subject_to
        a constraint such as "least_reaction > 0.1", in the unit of the measure; may be given several times
    uncertain
        what is not known exactly, as in `vibrocap robust`: PATH=LOW:HIGH, PATH=factor:LOW:HIGH, friction=fit:FILE
    robust
        what counts of the samples of what is uncertain: worst (the default), mean, or cvar, the mean of the worst tenth
    samples
        of what is uncertain, with which each design runs (default 16)
    evaluations
        designs to evaluate, about
    points
        of a Pareto front, at most (default 100)
    seed
        of the search; the same seed gives the same design
    out
        a folder for design.json, best.toml (a case that starts on the orbit) and all designs that were evaluated; of
        a front front.csv, front.json and a case for each point in cases/
    resume
        continue a search that was interrupted, from what `out` holds
    plot
        FILE.png, .svg or .pdf: the Pareto front
    report
        write report.html into `out`: the design, its motion as picture and film, what limits it, how to run it again
    json
        print one JSON object in full precision instead of a table
    """
    from vibrocap.design.optimise import optimise as optimised

    given = read_source(case)
    complaints = Complaints()
    unsure = dict(pairs("uncertain", uncertain, complaints, "PATH=LOW:HIGH, such as machine.damping=0.9:1.1"))
    ranges: dict[str, Any] = dict(pairs("over", over, complaints, "PATH=LEAST:LARGEST, such as drive.frequency=0.5:3"))
    if complaints:
        raise Refusal(*complaints)
    if resume and out is None:
        raise Refusal("--resume: needs --out, the folder of the search")
    if report:
        if out is None:
            raise Refusal("--report: needs --out, the folder that it is written to")
        needs("--report", "matplotlib")
    if out is not None:
        of_front = (f"{CASES}/{i:03d}.toml" for i in range(100 if points is None else points))
        writable_folder("--out", out, "design.json", "best.toml", *(of_front if against is not None else ()))
    writable_picture("--plot", plot)
    for option, value in (("--points", points), ("--plot", plot)):
        if value is not None and against is None:
            raise Refusal(f"{option}: should be left out without --against, which asks for a Pareto front")
    for option, value in (("--robust", robust), ("--samples", samples)):
        if value is not None and not unsure:
            raise Refusal(f"{option}: should be left out without --uncertain, which says what is not known exactly")
    if against is not None:
        if unsure:
            raise Refusal("--uncertain: should be left out with --against: fronts are of the case itself")
        asked = (for_, against), subject_to or (), evaluations, 100 if points is None else points, seed
        again = _asked(case, over, for_, subject_to, uncertain, evaluations, seed, against) if report else ""
        return _front(given, ranges, *asked, out, resume, plot, again, json)
    with (
        progress("Searching for the best design") as share,
        refusing("evaluations", "seed", "robust", "samples", "subject_to", objective="--for", store="--out"),
    ):
        found = optimised(
            given,
            ranges,
            for_,
            subject_to=subject_to or (),
            uncertain=unsure or None,
            robust=robust or "worst",
            samples=16 if samples is None else samples,
            evaluations=evaluations,
            seed=seed,
            store=out,
            resume=resume,
            progress=share,
        )
    record = in_si(found, given.system)
    if out is not None:
        write_text(made_folder(out) / "design.json", json_text(record) + "\n")
        if found.orbit is not None:
            found.case().save(out / "best.toml")
            if report:
                from vibrocap.report.design import write_design_page

                write_design_page(found, out, _asked(case, over, for_, subject_to, uncertain, evaluations, seed))
    if json:
        print(json_text(record))
    else:
        page = Page()
        page.say(f"Best design of {case} for {found.measure}", style="bold")
        page.rows([(name, text) for name, text in found.facts.items()], 14)
        if found.orbit is not None:
            page.rows([("orbit", ", ".join(in_si(found.orbit).facts.values()))], 14)
        page.rows([("constraint", f"{words}: {said(value, '')}") for words, value in found.constraints.items()], 14)
        page.rows([("motion", words) for words in _motions_in_words(found)], 14)
        page.rows([("rejected", words) for words in found.rejected], 14)
        if out is not None and found.orbit is not None:
            page.rows([("case", str(out / "best.toml"))], 14)
    if found.orbit is None:
        complain(f"There is {found.status.value}. {found.status.advice}")
        return INCOMPLETE
    return OK


def _asked(
    case: Path,
    over: list[str],
    for_: str,
    subject_to: list[str] | None,
    uncertain: list[str] | None,
    evaluations: int,
    seed: int,
    against: str | None = None,
) -> str:
    """The command that searches again."""
    words = ["vibrocap", "optimise", str(case)]
    for option, values in (("--over", over), ("--subject-to", subject_to or ()), ("--uncertain", uncertain or ())):
        words += [word for value in values for word in (option, value)]
    words += ["--for", for_, *(["--against", against] if against else [])]
    return shlex.join([*words, "--evaluations", str(evaluations), "--seed", str(seed), "--out", "design"])


def _front(
    given: Any,
    ranges: dict[str, Any],
    objectives: tuple[str, str],
    subject_to: Any,
    evaluations: int,
    points: int,
    seed: int,
    out: Path | None,
    resume: bool,
    plot: Path | None,
    again: str,
    json: bool,
) -> int:
    """The Pareto front of two measures."""
    from vibrocap.design.front import pareto_front

    needs("--against", "pymoo")
    options = {"store": "--out", "objectives[0]": "--for", "objectives[1]": "--against"}
    names = ("evaluations", "points", "seed", "subject_to")
    with progress("Searching for the Pareto front") as share, refusing(*names, **options):
        found = pareto_front(
            given,
            ranges,
            objectives,
            subject_to=subject_to,
            evaluations=evaluations,
            points=points,
            seed=seed,
            store=out,
            resume=resume,
            progress=share,
        )
    record = in_si(found, given.system)
    if out is not None:
        made_folder(out / CASES)
        write_text(out / "front.json", json_text(record) + "\n")
        rows = found.table()
        write_table(out / "front.csv", rows[0] if rows else (), (row.values() for row in rows))
        for i in range(len(found)):
            found.case(i).save(out / CASES / f"{i:03d}.toml")
        if again and len(found):
            from vibrocap.report.design import write_front_page

            write_front_page(found, out, again)
    if plot is not None and len(found):
        from vibrocap.plotting.fronts import front_figure
        from vibrocap.plotting.look.finishing import save

        save(front_figure(found), plot)
    if json:
        print(json_text(record))
    else:
        page = Page()
        page.say(f"Pareto front of {objectives[0]} and {objectives[1]}", style="bold")
        page.rows([(name, text) for name, text in found.facts.items()], 20)
        if out is not None and len(found):
            page.rows([("table", str(out / "front.csv")), ("cases", str(out / CASES))], 20)
        if plot is not None and len(found):
            page.rows([("picture", str(plot))], 20)
    if not len(found):
        complain(f"There is {found.status.value}. {found.status.advice}")
        return INCOMPLETE
    return OK


def _motions_in_words(found: Any) -> list[str]:
    """The motions besides that of the design to which spread starts lead, a line each."""
    if found.attractors is None:
        return []
    shown, lines = in_si(found.attractors), []
    for k, (each, row) in enumerate(zip(shown.attractors, shown.table(), strict=True)):
        if k == found.attractor:
            continue
        words = [f"{100.0 * row['share']:.3g} % of the starts lead to", row["kind"]]
        if found.attractor is not None and row["twin"] == found.attractor:
            words[-1] += " (the mirror twin)"
        words = [" ".join(words)]
        if row["drift"] is not None:
            words.append(f"drift {each.motion.said('drift', 6)} per drive period")
        if row["largest_multiplier"] is not None:
            words.append(f"largest multiplier {row['largest_multiplier']:.4g}")
        lines.append(", ".join(words))
    return lines
