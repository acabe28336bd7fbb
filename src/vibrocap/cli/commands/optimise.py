"""`vibrocap optimise`: the best settled, stable design of a case, with its orbit and a case file that runs."""

from pathlib import Path
from typing import Annotated, Any

from cyclopts import Parameter

from vibrocap.arguments import Complaints
from vibrocap.cli.commands.orbit import orbit_record, orbit_units
from vibrocap.cli.options import Refusal, pairs, refusing, writable_folder
from vibrocap.cli.terminal import INCOMPLETE, OK, Page, complain, progress, said
from vibrocap.files import made_folder, write_text
from vibrocap.io.json_text import in_both, json_text
from vibrocap.io.motion_file import read_source
from vibrocap.quantities.dimensional import in_si


def optimise(
    case: Path,
    /,
    *,
    over: list[str],
    for_: Annotated[str, Parameter(name="--for")] = "mean_velocity",
    subject_to: list[str] | None = None,
    evaluations: int = 10_000,
    seed: int = 0,
    out: Path | None = None,
    resume: bool = False,
    json: bool = False,
) -> int:
    """The design whose settled and stable motion has the best measure.

    Designs run in whole populations until they settle; the best are closed to
    periodic orbits, checked for stability and refined. What limits the best one is
    named: a bound, a constraint, stability, or a change of the mode sequence.

    Exit code 3: no design settles to a stable motion that fulfils the constraints.

    Parameters
    ----------
    case
        a case file (.toml), or a motion exported before (.nc, .csv)
    over
        PATH=LEAST:LARGEST or PATH=log:LEAST:LARGEST, or choices with commas between; once for each design variable
    for_
        the measure to make large, or small if it is a cost; `vibrocap measures` lists them
    subject_to
        a constraint such as "least_reaction > 0.1", in the unit of the measure; may be given several times
    evaluations
        designs to evaluate, about
    seed
        of the search; the same seed gives the same design
    out
        a folder for design.json, best.toml (a case that starts on the orbit) and all designs that were evaluated
    resume
        continue a search that was interrupted, from what `out` holds
    json
        print one JSON object in full precision instead of a table
    """
    from vibrocap.design.optimise import optimise as optimised

    given = read_source(case)
    complaints = Complaints()
    ranges: dict[str, Any] = dict(pairs("over", over, complaints, "PATH=LEAST:LARGEST, such as drive.frequency=0.5:3"))
    if complaints:
        raise Refusal(*complaints)
    if resume and out is None:
        raise Refusal("--resume: needs --out, the folder of the search")
    if out is not None:
        writable_folder("--out", out)
    with progress("Searching for the best design") as report, refusing("evaluations", "seed", store="--out"):
        found = optimised(
            given,
            ranges,
            for_,
            subject_to=subject_to or (),
            evaluations=evaluations,
            seed=seed,
            store=out,
            resume=resume,
            progress=report,
        )
    record = optimum_record(found)
    if out is not None:
        write_text(made_folder(out) / "design.json", json_text(record) + "\n")
        if found.orbit is not None:
            found.case().save(out / "best.toml")
    if json:
        print(json_text(record))
    else:
        page = Page()
        page.say(f"Best design of {case} for {found.measure}", style="bold")
        page.rows([(name, text) for name, text in found.facts.items()], 14)
        if found.orbit is not None:
            page.rows([("orbit", ", ".join(in_si(found.orbit).facts.values()))], 14)
        page.rows([("constraint", f"{words}: {said(value, '')}") for words, value in found.constraints.items()], 14)
        page.rows([("rejected", words) for words in found.rejected], 14)
        if out is not None and found.orbit is not None:
            page.rows([("case", str(out / "best.toml"))], 14)
    if found.orbit is None:
        complain(f"There is {found.status.value}. {found.status.advice}")
        return INCOMPLETE
    return OK


def optimum_record(found: Any) -> dict[str, Any]:
    """What is known of an optimum, by name."""
    steady = None
    if found.orbit is not None:
        steady = orbit_record(found.orbit)
        if (shown := in_si(found.orbit)) is not found.orbit:
            units = {name: unit for name, unit in orbit_units(shown).items() if steady.get(name) is not None}
            steady = in_both(orbit_record(shown), units, steady)
    names = ("design", "measure", "value", "unit", "constraints", "limits", "slopes", "starts", "reached_from")
    known = {name: getattr(found, name) for name in (*names, "counts", "rejected")}
    return {"status": found.status.value, **known, "orbit": steady}
