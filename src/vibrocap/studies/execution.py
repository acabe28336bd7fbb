"""How a study is carried out: where its results go, by what it is computed, and in which pieces."""

import dataclasses
from concurrent.futures import Executor
from pathlib import Path

from vibrocap.arguments import Complaint, Complaints, check_whole, require
from vibrocap.numerics import api as numerics

MAX_RUNS = 10_000_000


@dataclasses.dataclass(frozen=True, kw_only=True)
class Execution:
    """All that is said of how a study is carried out, see `sweep`; the results do not depend on it."""

    out: Path | None = None
    resume: bool = False
    mixed: bool = False
    max_runs: int = MAX_RUNS
    yes: bool = False
    tile_runs: int | None = None
    threads: int | None = None
    device: str = "cpu"
    workers: int | Executor | None = None

    def require_packages(self) -> None:
        """ModuleNotFoundError for what a study needs beyond the core."""
        require("a sweep", "xarray", "zarr")

    def complaints(self) -> list[Complaint]:
        complaints = Complaints()
        for name in ("max_runs", "tile_runs", "threads", "workers"):
            with complaints.collected():
                number = getattr(self, name)
                check_whole(name, 1 if number is None or isinstance(number, Executor) else number, 1)
        if self.mixed and not self.resume:
            complaints.add("mixed", "continues a stored study, for which resume has to be given, too")
        for name in ("resume", "workers"):
            if getattr(self, name) and self.out is None:
                complaints.add(name, "needs a folder for the results (out)")
        with complaints.collected():
            numerics.device(self.device)
        return [complaint for complaint in complaints if isinstance(complaint, Complaint)]
