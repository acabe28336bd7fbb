"""All claims, in the order of the paper."""

from collections.abc import Callable, Iterator

from vibrocap.paper.claims import (
    conclusions,
    displacement,
    equations,
    friction,
    limits,
    loops,
    phase_planes,
    travel,
    vibration,
)
from vibrocap.paper.claims.claim import CLAIMS, Claim, Verdict, judged
from vibrocap.paper.runs import Runs

CHAPTERS = {
    "equations and friction laws": equations,
    "frictional limits": limits,
    "motion, Fig. 5": vibration,
    "phase planes, Fig. 7": phase_planes,
    "friction force, Fig. 6": friction,
    "friction loops, Fig. 8": loops,
    "travel, Fig. 9": travel,
    "velocities and displacements, Figs 10 and 11": displacement,
    "abstract and conclusions": conclusions,
}


def chapters(only: str | None = None) -> dict[str, tuple[Claim, ...]]:
    """The claims by chapter; those of one figure if it is named."""
    numbers = {}
    for title, module in CHAPTERS.items():
        own = [c for c in CLAIMS.values() if c.judge.__module__ == module.__name__]
        kept = tuple(c for c in own if only is None or only in c.figures)
        if kept:
            numbers[title] = kept
    return numbers


def verdicts(
    runs: Runs, only: str | None = None, progress: Callable[[str, float], None] | None = None
) -> Iterator[tuple[str, Verdict]]:
    """Judge the claims one by one: (chapter, verdict)."""
    listed = [(title, claim) for title, claims in chapters(only).items() for claim in claims]
    for i, (title, claim) in enumerate(listed):
        if progress is not None:
            progress(f"claim {claim.key}", i / len(listed))
        yield title, judged(claim, runs)
