"""Where ensembles run: on this processor, or on a device that another package brings.

Such a package has entry points of the group `vibrocap.devices`: the name of a device, and a function that returns it.
Its kernels have the text of all others (`ensemble.ensemble_source`, loop "portable").
"""

import dataclasses
import importlib.metadata
from collections.abc import Callable, Mapping

from vibrocap.arguments import ArgumentError
from vibrocap.numerics.run.ensemble import ensemble_run
from vibrocap.numerics.run.results import RunResults

GROUP = "vibrocap.devices"


@dataclasses.dataclass(frozen=True)
class Device:
    """What runs ensembles.

    run: has the contract of `ensemble_run`; chunk: runs that it takes at a time
    tile_runs: runs of a study that are stored together, unless these are given; None: as many as its time allows
    code: with what its results are made, by name, beside the package; see `studies.plan.code_version`
    """

    run: Callable[..., RunResults]
    chunk: int
    tile_runs: int | None = None
    code: Mapping[str, str] = dataclasses.field(default_factory=dict)


PROCESSOR = Device(ensemble_run, chunk=32_768)  # some 40 MB


def device(name: str) -> Device:
    """The device of this name: "cpu", or one of an installed package.

    Raises ArgumentError where there is none, with the reason that it gives where it cannot run here.
    """
    if name == "cpu":
        return PROCESSOR
    brought = {entry_point.name: entry_point for entry_point in importlib.metadata.entry_points(group=GROUP)}
    if name not in brought:
        known = ", ".join(["cpu", *sorted(brought)])
        raise ArgumentError("device", f"should be one of: {known}; cuda needs the package vibrocap-gpu, got {name!r}")
    return brought[name].load()()
