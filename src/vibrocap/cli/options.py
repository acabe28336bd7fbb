"""Options: each is declared once, in the annotation of a request's field; those that several commands share."""

import dataclasses
from collections.abc import Callable
from pathlib import Path
from typing import Annotated, Any

from vibrocap.cli import completers, destinations
from vibrocap.cli.completers import Offered


@dataclasses.dataclass(frozen=True)
class Option:
    """An option of a command, in the annotation of a field: `points: Annotated[int, Option("of a branch")] = 100`.

    words: its help; place: it is given by its place on the line, without a name
    sets: arguments of functions that it sets, besides that of the field's own name: complaints name the option instead
    offers: what a shell completes; check: complains of (option, value) before any work
    needs: the field of the option without which it means nothing; advanced: few need it
    """

    words: str
    place: bool = False
    sets: tuple[str, ...] = ()
    offers: Callable[[Any], Offered] | None = None
    check: Callable[[str, Any], Any] | None = None
    needs: str = ""
    advanced: bool = False


def flag(field: str, option: Option | None = None) -> str:
    """The name of an option on the command line: --settle-periods, or CASE for one that is given by its place."""
    name = field.strip("_").replace("_", "-")
    return name.upper() if option is not None and option.place else f"--{name}"


def picture(words: str, **more: Any) -> Option:
    """A picture to draw; words: what it shows."""
    return Option(f"FILE.png, .svg or .pdf: {words}", check=destinations.writable_picture, **more)


def file(words: str, *kinds: str, **more: Any) -> Option:
    """A file to write, with one of these endings."""
    return Option(words, check=lambda name, path: destinations.writable_file(name, path, kinds), **more)


def folder(words: str, *names: str, **more: Any) -> Option:
    """A folder to write into; names: of files in it that are written anew."""
    return Option(words, check=lambda name, path: destinations.writable_folder(name, path, *names), **more)


CASE = Option("a case file (.toml), or an exported motion (.nc, .csv)", place=True, sets=("system",))
CaseOption = Annotated[Path, CASE]
Json = Annotated[bool, Option("print one JSON object in full precision")]
Parts = Annotated[
    list[Path] | None, Option("a Python file with your own laws, machines, drives or controllers; may be repeated")
]
Over = Annotated[
    str,
    Option(
        "PATH=LEAST:LARGEST, such as drive.amplitude=1:3, or drive.frequency_Hz=0.5:2 of a case in SI",
        sets=("between",),
        offers=completers.paths_of_case,
    ),
]
For = Annotated[
    str,
    Option(
        "the measure; `vibrocap list measures` lists them",
        sets=("measure", "objective", "objectives[0]"),
        offers=completers.measure_names,
    ),
]
Uncertain = Option(
    "PATH=LOW:HIGH, PATH=normal:MEAN:DEVIATION or PATH=lognormal:MEDIAN:SIGMA; PATH,PATH=factor:LOW:HIGH for one factor"
    " of the values of the case; friction=fit:FOLDER/fit.json for the uncertainty of a fit; may be repeated",
    offers=completers.paths_of_case,
)
Settings = Annotated[
    list[str] | None,
    Option(
        "PATH=VALUE in place of the case's, such as machine.mass_ratio=2 or friction.law=lugre; may be repeated",
        offers=completers.paths_of_case,
    ),
]
Law = Annotated[str | None, Option("a law, see `vibrocap list laws`", offers=completers.law_names)]
Columns = Annotated[
    list[str] | None, Option("QUANTITY=NAME, such as force=F1,velocity=v, for columns with unusual names")
]
ColumnUnits = Annotated[list[str] | None, Option("QUANTITY=UNIT, such as force=kN or 'force=35.15 N' (of one volt)")]
SamplingRate = Annotated[
    float | None, Option("samples per second (Hz), where there is no column of time", sets=("dt, sampling_rate",))
]
Seed = Annotated[int, Option("of random numbers; the same seed gives the same results", advanced=True)]
SettlePeriods = Annotated[int, Option("drive periods in which a motion has to settle", advanced=True)]
Tolerance = Option("error per step, relative to the states' natural size [default: the case's]", advanced=True)
