"""`vibrocap optimise`: the best settled, stable design of a case, with its orbit and a case file that runs."""

from pathlib import Path
from typing import Any

from vibrocap.arguments import Complaints
from vibrocap.cli import completers
from vibrocap.cli.command import Answer, Drawn, OfCase, Report, command
from vibrocap.cli.commands.orbit import bound_rows, bounds_record
from vibrocap.cli.options import FOR, JSON, SEED, UNCERTAIN, folder, needs, option, picture, required, writable_folder
from vibrocap.cli.terminal import part, said
from vibrocap.cli.texts import checked_pairs
from vibrocap.files import made_folder, write_table, write_text
from vibrocap.quantities.dimensional import in_si, view
from vibrocap.quantities.json_text import json_text

CASES = "cases"  # in the folder of a front


class OptimiseRequest(OfCase, Drawn):
    over: list[str] = required(
        "PATH=LEAST:LARGEST, PATH=log:LEAST:LARGEST or PATH=CHOICE,CHOICE; once for each design variable",
        offers=completers.paths_of_case,
    )
    for_: str = FOR
    against: str | None = option(
        "a second measure, for a Pareto front (needs pymoo)", sets=("objectives[1]",), offers=completers.measure_names
    )
    subject_to: list[str] | None = option(
        'a constraint such as "least_reaction > 0.1", in the unit of the measure; may be repeated',
        offers=completers.measure_names,
    )
    uncertain: list[str] | None = UNCERTAIN()
    robust: str | None = option(
        "of the samples: worst (the default), mean, or cvar, the mean of the worst tenth", needs="uncertain"
    )
    evaluations: int = option("designs to evaluate, about", 10_000)
    out: Path | None = folder(
        "a folder for design.json, best.toml (a case that starts on the orbit) and all evaluated designs; "
        "of a front front.csv, front.json and a case for each point in cases/",
        *("design.json", "best.toml"),
        sets=("store",),
    )
    resume: bool = option("continue an interrupted search from its folder", False, needs="out")
    report: bool = option(
        "write report.html into the folder: the design, its motion as picture and film, its limits, how to run it",
        False,
        needs="out",
    )
    plot: Path | None = picture("the Pareto front", needs="against")
    json: bool = JSON
    samples: int | None = option(
        "of the uncertain quantities for each design (default 16)", needs="uncertain", advanced=True
    )
    points: int | None = option("of a Pareto front, at most (default 100)", needs="against", advanced=True)
    seed: int = SEED

    def plan(self, refused: Complaints) -> None:
        """A front is of the case itself; its cases are written anew."""
        if self.report:
            needs("--report", "matplotlib")
        if self.against is not None:
            if self.uncertain:
                refused.add("--uncertain", "should be left out with --against: fronts are of the case itself")
            needs("--against", "pymoo")
            if self.out is not None:
                writable_folder("--out", self.out, *(f"{CASES}/{i:03d}.toml" for i in range(self.points or 100)))


@command(
    "design",
    "vibrocap optimise case.toml --over drive.frequency=0.5:3 --evaluations 200 --out design",
    "vibrocap optimise case.toml --over drive.frequency=0.5:3 --over machine.damping=0.3:3 "
    "--against cost_of_transport --evaluations 400 --out front",
    doing="Searching",
)
def optimise(request: OptimiseRequest, report: Report) -> Answer:
    """The settled, stable design with the best measure.

    Populations of designs run until they settle; the best ones become periodic orbits, which must be stable, and are
    refined. The report names the limit of the best one: a bound, a constraint, stability, or a change of the mode
    sequence. The search maximises the measure, or minimises a cost. With --against, the result is a Pareto front:
    designs that cannot improve in one measure without a loss in the other.

    Exit code 3: no design settles to a stable motion that fulfils the constraints.
    """
    unsure = checked_pairs("uncertain", request.uncertain, "PATH=LOW:HIGH, such as machine.damping=0.9:1.1")
    ranges: dict[str, Any] = checked_pairs("over", request.over, "PATH=LEAST:LARGEST, such as drive.frequency=0.5:3")
    shared = {"subject_to": request.subject_to or (), "store": request.out, "progress": report}
    shared |= request.given("evaluations", "seed", "resume")
    if request.against is not None:
        return _front(request, ranges, shared)
    return _best(request, ranges, unsure, shared)


def _best(request: OptimiseRequest, ranges: dict[str, Any], unsure: dict[str, str], shared: dict[str, Any]) -> Answer:
    from vibrocap.design.optimise import optimise as optimised

    shared |= {"robust": "worst", "samples": 16} | request.given("robust", "samples")
    result = optimised(request.setup, ranges, request.for_, uncertain=unsure or None, **shared)
    record = view(in_si(result, request.setup.system))
    record["bounds"] = [] if result.orbit is None else bounds_record(result.orbit.system, result.orbit)
    written = []
    if request.out is not None:
        write_text(made_folder(request.out) / "design.json", json_text(record) + "\n")
        if result.orbit is not None:
            result.case().save(request.out / "best.toml")
            written.append(("case", request.out / "best.toml"))
            if request.report:
                from vibrocap.report.results import write_design_page

                write_design_page(result, request.out, request.again())

    rows = list(result.facts.items())
    rows += [] if result.orbit is None else [("orbit", ", ".join(in_si(result.orbit).facts.values()))]
    rows += [("constraint", f"{words}: {said(value, '')}") for words, value in result.constraints.items()]
    rows += [("motion", words) for words in _motions_in_words(result)]
    rows += [("rejected", words) for words in result.rejected] + bound_rows(record["bounds"])
    text = part(f"Best design of {request.case} for {result.measure}", rows, 14)
    incomplete = "" if result.orbit is not None else f"There is {result.status.value}. {result.status.advice}"
    return Answer(record, text, written=tuple(written), incomplete=incomplete)


def _front(request: OptimiseRequest, ranges: dict[str, Any], shared: dict[str, Any]) -> Answer:
    from vibrocap.design.front import pareto_front

    assert request.against is not None
    objectives = request.for_, request.against
    points = 100 if request.points is None else request.points
    result = pareto_front(request.setup, ranges, objectives, points=points, **shared)
    record = in_si(result, request.setup.system)
    written: list[tuple[str, Any]] = []
    if (out := request.out) is not None:
        made_folder(out / CASES)
        write_text(out / "front.json", json_text(record) + "\n")
        rows = result.table()
        write_table(out / "front.csv", rows[0] if rows else (), (row.values() for row in rows))
        for i in range(len(result)):
            result.case(i).save(out / CASES / f"{i:03d}.toml")
        written = [("table", out / "front.csv"), ("cases", out / CASES)] if len(result) else []
        if request.report and len(result):
            from vibrocap.report.results import write_front_page

            write_front_page(result, out, request.again())

    text = part(f"Pareto front of {objectives[0]} and {objectives[1]}", result.facts.items(), 20)
    incomplete = "" if len(result) else f"There is {result.status.value}. {result.status.advice}"
    return Answer(record, text, result if len(result) else None, written=tuple(written), incomplete=incomplete)


def _motions_in_words(optimum: Any) -> list[str]:
    """The motions besides that of the design to which spread starts lead, a line each."""
    if optimum.attractors is None:
        return []
    shown, lines = in_si(optimum.attractors), []
    for k, (attractor, row) in enumerate(zip(shown.attractors, shown.table(), strict=True)):
        if k == optimum.attractor:
            continue
        words = [f"{100.0 * row['share']:.3g} % of the starts lead to", row["kind"]]
        if optimum.attractor is not None and row["twin"] == optimum.attractor:
            words[-1] += " (the mirror-image solution)"
        words = [" ".join(words)]
        if row["drift"] is not None:
            words.append(f"drift {attractor.motion.said('drift', 6)} per drive period")
        if row["largest_multiplier"] is not None:
            words.append(f"largest multiplier {row['largest_multiplier']:.4g}")
        lines.append(", ".join(words))
    return lines
