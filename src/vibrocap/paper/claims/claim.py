"""What a claim is, how it is judged, and the list that every claim joins."""

import dataclasses
import enum
import functools
import inspect
import math
import re
from collections.abc import Callable, Mapping
from typing import Any

from vibrocap.paper.runs import Runs


class Outcome(enum.Enum):
    """The four possible verdicts."""

    HOLDS = "holds"
    ONLY_FOR = "holds only for"
    FAILS = "does not hold"
    UNDECIDED = "cannot be decided"


@dataclasses.dataclass(frozen=True)
class Tolerance:
    """How far a number may be off, and where that margin comes from."""

    value: float
    origin: str


@dataclasses.dataclass(frozen=True)
class Finding:
    """What a test found: the verdict, the numbers behind it, one sentence why, and the nearest true statement."""

    outcome: Outcome
    found: Mapping[str, float]  # a number that does not exist, such as a zero that a curve does not have, is NaN
    why: str
    only_for: str = ""  # completes "holds only for ..."
    nearest: str = ""


@dataclasses.dataclass(frozen=True)
class Claim:
    """A checkable statement of the paper.

    where: section, equation or figure   says: the statement, in our words   test: what is computed
    figures: keys of the figures it belongs to; empty for statements about the equations   module: of its chapter
    """

    key: str
    where: str
    says: str
    test: str
    tolerance: Tolerance
    figures: tuple[str, ...]
    module: str
    judge: Callable[[Runs, float], Finding] = dataclasses.field(repr=False, compare=False)


@dataclasses.dataclass(frozen=True)
class Verdict:
    """A claim, judged."""

    claim: Claim
    finding: Finding

    @property
    def verdict(self) -> str:
        """The verdict in words, with its restriction."""
        outcome, only_for = self.finding.outcome, self.finding.only_for
        return f"{outcome.value} {only_for}" if outcome is Outcome.ONLY_FOR else outcome.value

    @property
    def row(self) -> dict:
        """The verdict as plain values, for JSON and CSV."""
        return {
            "key": self.claim.key,
            "where": self.claim.where,
            "says": self.claim.says,
            "test": self.claim.test,
            "tolerance": self.claim.tolerance.value,
            "tolerance_origin": self.claim.tolerance.origin,
            "figures": list(self.claim.figures),
            "outcome": self.finding.outcome.value,
            "verdict": self.verdict,
            "found": {name: float(x) if math.isfinite(x) else None for name, x in self.finding.found.items()},
            "why": self.finding.why,
            "nearest": self.finding.nearest,
        }


CLAIMS: dict[str, Claim] = {}

ROUNDING = Tolerance(1e-11, "double precision after some hundred operations on numbers of order 10")
DRAWN = Tolerance(0.01, "1 % of the range: less cannot be read off a printed curve")
RUN_ERROR = Tolerance(1e-7, "a thousand times the tolerance of the runs, 1e-10")


def printed(number: str) -> Tolerance:
    """Half a unit of the last digit of a number as the paper prints it."""
    decimals = len(number.partition(".")[2])
    return Tolerance(0.5 * 10.0**-decimals, f"half a unit of the last digit of the printed {number}")


def claim(
    where: str, says: str, tolerance: Tolerance = DRAWN, *figures: str, key: str = "", test: str = "", **settings: Any
) -> Callable[[Callable[..., Finding]], Claim]:
    """Make a claim of the function that judges it and add it to the list.

    It is called with the runs, the tolerance and the settings. figures: by default those that `where` names;
    key: the function's name; test: its docstring
    """

    def register(judge: Callable[..., Finding]) -> Claim:
        own = key or judge.__name__.replace("_", "-")
        words = " ".join((test or inspect.getdoc(judge) or "").split())
        judging = functools.partial(judge, **settings)
        claim = Claim(own, where, says, words, tolerance, figures or _named(where), judge.__module__, judging)
        if own in CLAIMS:
            raise ValueError(f"two claims are called {own}")
        CLAIMS[own] = claim
        return claim

    return register


def _named(where: str) -> tuple[str, ...]:
    """Keys of the figures in a place of the paper, such as "sec. 3.1, Figs 6(b), 7" or "Figs 5-8"."""
    numbers: list[int] = []
    for listed in re.findall(r"Figs?\.? ([\d(),a-z -]+)", where):
        for first, last in re.findall(r"(\d+)(?:-(\d+))?", listed):
            numbers += range(int(first), int(last or first) + 1)
    return tuple(f"fig{number:02d}" for number in dict.fromkeys(numbers))


def judged(statement: Claim, runs: Runs) -> Verdict:
    """The verdict on one claim."""
    return Verdict(statement, statement.judge(runs, statement.tolerance.value))


def decided(condition: bool) -> Outcome:
    """Holds or does not."""
    return Outcome.HOLDS if condition else Outcome.FAILS


def restricted(everywhere: bool, somewhere: bool) -> Outcome:
    """Holds, holds only for some of it, or does not."""
    if everywhere:
        return Outcome.HOLDS
    return Outcome.ONLY_FOR if somewhere else Outcome.FAILS
