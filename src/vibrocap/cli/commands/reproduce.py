"""`vibrocap reproduce`: the paper, its figures and its claims, from our own runs."""

import collections
from pathlib import Path
from typing import Any

from vibrocap.arguments import Complaints
from vibrocap.cli.command import Answer, Report, Request, command
from vibrocap.cli.options import folder, needs, option, own_names
from vibrocap.cli.terminal import Page, table

OF_REPORT = (("claims", "json"), ("claims", "csv"), ("load", "json"), ("report", "html"))
WIDE = 120  # columns of a terminal


class ReproduceRequest(Request):
    out: Path = folder(
        "folder for report.html, the figures and their data; made where it is missing", default=Path("out")
    )
    only: str | None = option("one figure and its claims, such as fig09; the report is report-fig09.html then")

    def plan(self, refused: Complaints) -> None:
        """A figure of the paper, and a folder without files of others."""
        from vibrocap.paper.figures import KEYS

        if self.only is not None and self.only not in KEYS:
            refused.add("--only", f"should be one of {', '.join(KEYS)}, got {self.only!r}")
        needs("reproduce", "matplotlib")
        ending = "" if self.only is None else f"-{self.only}"
        own_names("--out", self.out, *(f"{name}{ending}.{kind}" for name, kind in OF_REPORT))


@command("out", "vibrocap reproduce --out out", "vibrocap reproduce --only fig09", doing="The paper")
def reproduce(request: ReproduceRequest, report: Report) -> Answer:
    """The paper: figures, claims with verdicts, a report.

    Its figures come from our own runs, its claims with their verdicts, in one HTML report.
    """
    from vibrocap.report.reproduce import reproduce as reproduced

    result = reproduced(request.out, request.only, lambda what, share: report(share, what))
    return Answer(text=lambda page: print_claims(page, result))


def print_claims(page: Page, result: Any) -> None:
    """The summary of `vibrocap reproduce`: every claim with its verdict, and where the report lies.

    The numbers found stand beside it where the terminal is wide enough; the report has them all.
    """
    wide = page.width >= WIDE
    listing = table("Claims of the paper", "claim", "where", "verdict", *(["found"] if wide else []))
    listing.columns[1].no_wrap = False
    for verdict in result.claims:
        numbers = ", ".join(f"{name} {value:.5g}" for name, value in verdict.finding.found.items())
        listing.add_row(verdict.claim.key, verdict.claim.where, verdict.verdict, *([numbers] if wide else []))
    page.print(listing)
    counts = collections.Counter(verdict.finding.outcome.value for verdict in result.claims)
    tally = ", ".join(f"{outcome} {count}" for outcome, count in counts.most_common())
    page.print(f"{len(result.claims)} claims in {result.seconds:.0f} s: {tally}.")
    page.say(f"Report: {result.report}")
