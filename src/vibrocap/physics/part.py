"""Parts in SI: a machine, a law or a drive whose parameters are given with their units."""

import dataclasses
from collections.abc import Mapping
from typing import Any, ClassVar


@dataclasses.dataclass(frozen=True)
class PartInSI:
    """A part whose parameters are given in SI; `System` makes the part of it, by the scales of its machine.

    part: its class. values: by keys that carry their unit, such as "bristle_stiffness_N_per_m".
    """

    part: type
    values: Mapping[str, Any]


class Part:
    """What every machine, law and drive offers besides its physics.

    source: where it was published: works separated by semicolons, each by its key in the bibliography of the package
        (`vibrocap/citations/bibliography.bib`) or in words; "vibrocap" where it was made here
    """

    source: ClassVar[str] = ""

    @classmethod
    def in_si(cls, **values: Any) -> Any:
        """This part with its parameters in SI, each with its unit in its name: `Harmonic.in_si(frequency_Hz=5, ...)`.

        The keys are those of a case file in SI; `System` takes it, if its other parts are in SI too.
        """
        return PartInSI(cls, values)
