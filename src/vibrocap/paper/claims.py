"""All claims, in the order of the paper."""

from collections.abc import Callable, Iterator

from vibrocap.paper import (
    claims_conclusions,
    claims_displacement,
    claims_equations,
    claims_friction,
    claims_limits,
    claims_loops,
    claims_phase_planes,
    claims_travel,
    claims_vibration,
)
from vibrocap.paper.claim import CLAIMS, Claim, Verdict, judged
from vibrocap.paper.runs import Runs

CHAPTERS = {
    "equations and friction laws": claims_equations,
    "frictional limits": claims_limits,
    "motion, Fig. 5": claims_vibration,
    "phase planes, Fig. 7": claims_phase_planes,
    "friction force, Fig. 6": claims_friction,
    "friction loops, Fig. 8": claims_loops,
    "travel, Fig. 9": claims_travel,
    "velocities and displacements, Figs 10 and 11": claims_displacement,
    "abstract and conclusions": claims_conclusions,
}


def chapters(only: str | None = None) -> dict[str, tuple[Claim, ...]]:
    """The claims by chapter; those of one figure if it is named."""
    found = {}
    for title, module in CHAPTERS.items():
        own = [c for c in CLAIMS.values() if c.judge.__module__ == module.__name__]
        kept = tuple(c for c in own if only is None or only in c.figures)
        if kept:
            found[title] = kept
    return found


def verdicts(
    runs: Runs, only: str | None = None, progress: Callable[[str, float], None] | None = None
) -> Iterator[tuple[str, Verdict]]:
    """Judge the claims one by one: (chapter, verdict)."""
    listed = [(title, claim) for title, claims in chapters(only).items() for claim in claims]
    for i, (title, claim) in enumerate(listed):
        if progress is not None:
            progress(f"claim {claim.key}", i / len(listed))
        yield title, judged(claim, runs)
