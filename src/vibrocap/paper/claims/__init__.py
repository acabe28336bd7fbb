"""The claims of the paper, each judged by a computation, in the order of the paper.

A claim is a function that is given the runs and a tolerance and gives back what it found; the files are the chapters of
the paper, and enter their claims as they are imported here.
"""

import importlib
from collections.abc import Callable, Iterator

from vibrocap.paper.claims.claim import CLAIMS, Claim, Verdict, judged
from vibrocap.paper.runs import Runs

CHAPTERS = {  # and their modules
    "equations and friction laws": "equations",
    "frictional limits": "limits",
    "motion, Fig. 5": "vibration",
    "phase planes, Fig. 7": "phase_planes",
    "friction force, Fig. 6": "friction",
    "friction loops, Fig. 8": "loops",
    "travel, Fig. 9": "travel",
    "velocities and displacements, Figs 10 and 11": "displacement",
    "abstract and conclusions": "conclusions",
}
MODULES = {title: f"{__name__}.{name}" for title, name in CHAPTERS.items()}
for _name in MODULES.values():
    importlib.import_module(_name)


def chapters(only: str | None = None) -> dict[str, tuple[Claim, ...]]:
    """The claims by chapter; those of one figure if it is named."""
    wanted = [one for one in CLAIMS.values() if only is None or only in one.figures]
    known = {title: tuple(c for c in wanted if c.module == module) for title, module in MODULES.items()}
    return {title: claims for title, claims in known.items() if claims}


def verdicts(
    runs: Runs, only: str | None = None, progress: Callable[[str, float], None] | None = None
) -> Iterator[tuple[str, Verdict]]:
    """Judge the claims one by one: (chapter, verdict)."""
    listed = [(title, claim) for title, claims in chapters(only).items() for claim in claims]
    for i, (title, claim) in enumerate(listed):
        if progress is not None:
            progress(f"claim {claim.key}", i / len(listed))
        yield title, judged(claim, runs)
