"""`vibrocap robust`: how sure a measure of a case is where some of its quantities are not known exactly."""

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from vibrocap.arguments import Complaints
from vibrocap.cli.options import Refusal, pairs, refusing
from vibrocap.cli.terminal import OK, Page, progress
from vibrocap.io.motion_file import read_source
from vibrocap.quantities.dimensional import in_si
from vibrocap.quantities.json_text import json_text


def robust(
    case: Path,
    /,
    *,
    uncertain: list[str],
    for_: Annotated[str, Parameter(name="--for")] = "mean_velocity",
    samples: int = 256,
    seed: int = 0,
    json: bool = False,
) -> int:
    """How sure a measure of the settled motion is where friction, machine or ground are not known exactly.

    Samples of the uncertain quantities run until they settle. The spread of the
    measure, its worst values, the share that fails or travels the wrong way and the
    Sobol indices are printed: which quantity to know better.

    Parameters
    ----------
    case
        a case file (.toml), or a motion exported before (.nc, .csv)
    uncertain
        PATH=LOW:HIGH, PATH=normal:MEAN:DEVIATION or PATH=lognormal:MEDIAN:SIGMA; PATH,PATH=factor:LOW:HIGH for one
        factor of the values of the case; friction=fit:FOLDER/fit.json for what a fit leaves uncertain; once for
        each quantity
    for_
        the measure; `vibrocap measures` lists them
    samples
        a power of two
    seed
        of the samples; the same seed gives the same numbers
    json
        print one JSON object in full precision instead of a table
    """
    from vibrocap.design.robustness import robustness

    given = read_source(case)
    complaints = Complaints()
    quantities = dict(pairs("uncertain", uncertain, complaints, "PATH=LOW:HIGH, such as machine.damping=0.9:1.1"))
    if complaints:
        raise Refusal(*complaints)
    with progress("Sampling what is uncertain") as report, refusing("samples", "seed", measure="--for"):
        found = robustness(given, quantities, for_, samples=samples, seed=seed, progress=report)
    if json:
        print(json_text(in_si(found, given.system)))
        return OK
    page = Page()
    page.say(f"Robustness of {found.measure}", style="bold")
    page.rows(list(found.facts.items()), 16)
    if found.first_order and found.total:
        page.say("Sobol indices: alone, and with all that it takes part in")
        rows = ((name, found.first_order[name], found.total[name]) for name in found.total)
        width = max(16, 2 + max(map(len, found.total)))
        page.rows([(name, f"{alone[0]:.3f}, {total[0]:.3f}") for name, alone, total in rows], width)
    return OK
