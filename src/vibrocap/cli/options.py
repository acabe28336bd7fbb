"""Options: each is declared once, as the value of a request's field; those that several commands share."""

import dataclasses
import functools
from collections.abc import Callable
from typing import Any

from vibrocap.cli import completers, destinations
from vibrocap.cli.completers import Offered


@dataclasses.dataclass(frozen=True)
class Option:
    """An option of a command, as a request declares it: `points: int = option("of a branch", 100)`.

    words: its help; default: of the field; place: it is given by its place on the line, without a name
    sets: arguments of functions that it sets, besides that of the field's own name: complaints name the option instead
    offers: what a shell completes; check: complains of (option, value) before any work
    needs: the field of the option without which it means nothing, where the request has it; advanced: few need it
    """

    words: str
    default: Any = None
    place: bool = False
    sets: tuple[str, ...] = ()
    offers: Callable[[Any], Offered] | None = None
    check: Callable[[str, Any], Any] | None = None
    needs: str = ""
    advanced: bool = False


def option(words: str, default: Any = None, **more: Any) -> Any:
    """An `Option` as the value of the field that it declares."""
    return Option(words, default, **more)


REQUIRED: Any = dataclasses.MISSING  # as a default
required = functools.partial(option, default=REQUIRED)


def flag(field: str, option: Option | None = None) -> str:
    """The name of an option on the command line: --settle-periods, or CASE for one that is given by its place."""
    name = field.strip("_").replace("_", "-")
    return name.upper() if option is not None and option.place else f"--{name}"


def picture(words: str, **more: Any) -> Any:
    """A picture to draw; words: what it shows."""
    return option(f"FILE.png, .svg or .pdf: {words}", check=destinations.writable_picture, **more)


def file(words: str, *kinds: str, **more: Any) -> Any:
    """A file to write, with one of these endings."""
    return option(words, check=lambda name, path: destinations.writable_file(name, path, kinds), **more)


def folder(words: str, *names: str, **more: Any) -> Any:
    """A folder to write into; names: of files in it that are written anew."""
    return option(words, check=lambda name, path: destinations.writable_folder(name, path, *names), **more)


# The type of each stands in the requests.
CASE = required("a case file (.toml), or an exported motion (.nc, .csv)", place=True, sets=("system",))
JSON = option("print one JSON object in full precision", False)
OVER = required(
    "PATH=LEAST:LARGEST, such as drive.amplitude=1:3, or drive.frequency_Hz=0.5:2 of a case in SI",
    sets=("between",),
    offers=completers.paths_of_case,
)
FOR = option(
    "the measure; `vibrocap list measures` lists them",
    "mean_velocity",
    sets=("measure", "objective", "objectives[0]"),
    offers=completers.measure_names,
)
UNCERTAIN = functools.partial(
    option,
    "PATH=LOW:HIGH, PATH=normal:MEAN:DEVIATION or PATH=lognormal:MEDIAN:SIGMA; PATH,PATH=factor:LOW:HIGH for one factor"
    " of the values of the case; friction=fit:FOLDER/fit.json for the uncertainty of a fit; may be repeated",
    offers=completers.paths_of_case,
)
COLUMNS = option("QUANTITY=NAME, such as force=F1,velocity=v, for columns with unusual names")
COLUMN_UNITS = option("QUANTITY=UNIT, such as force=kN or 'force=35.15 N' (of one volt)")
SAMPLING_RATE = option("samples per second (Hz), where there is no column of time", sets=("dt, sampling_rate",))
SEED = option("of random numbers; the same seed gives the same results", 0, advanced=True)
SETTLE_PERIODS = functools.partial(option, "drive periods in which a motion has to settle", advanced=True)
TOLERANCE = functools.partial(
    option, "error per step, relative to the states' natural size [default: the case's]", advanced=True
)
