"""A case as rates, guards and decisions: for integrators that are not ours, in an FMU or in firmware.

Between events the integrator has rates; guards fall to zero where the contact stops, gives way or another branch of the
equations begins; a decision then says how it goes on. The error is that of the integrator.
"""

import dataclasses
import functools

import numpy as np

from vibrocap.arguments import ArgumentError
from vibrocap.exchange.stepped_case import SteppedCase
from vibrocap.motion.recording.equations import parameter_values
from vibrocap.numerics.api import codes, exported_instant
from vibrocap.physics.events import CONTACT


@dataclasses.dataclass(frozen=True)
class Rates:
    """A case in that form, and where everything stands in its memory. argument: which asks for it, in messages.

    Raises ArgumentError for a case whose equations nobody can integrate between such events.
    """

    stepped: SteppedCase
    name: str
    argument: str
    way_out: str

    def __post_init__(self):
        system, recorded = self.stepped.system, self.stepped.equations
        machine, law = system.machine.name, system.friction.name
        stay = [recorded.graph.node("state", i).index for i in range(len(recorded.rates))]
        turn = [each.index for each in recorded.contacts[0].after_reversal]
        jumps = recorded.corners is not None and system.machine.imposes_motion
        for refused, said in (
            (recorded.several, f"take one contact, the {machine} has several"),
            (not recorded.contacts[0].sticks, f"take set-valued laws of friction, {law} is none"),
            (turn != stay, f"take no states that a reversal changes, as those of {law}"),
            (jumps, f"take no velocities that jump with the drive, as those of the {machine}"),
        ):
            if refused:
                raise ArgumentError(self.argument, f"rates for another integrator {said}; {self.way_out}")

    @functools.cached_property
    def instant(self):
        """The equations at one instant."""
        return exported_instant(self.stepped.equations, self.name, own_drive=not self.stepped.inputs)

    @property
    def bounds(self) -> list[int]:
        """The status with which a motion ends at each bound of the equations."""
        return [codes.BEYOND_BOUND + kind for kind in self.stepped.equations.bound_kinds]

    @property
    def guards(self) -> int:
        """How many there are: two of the contact, then those of bounds and branches."""
        return 2 + len(self.bounds) + len(self.stepped.equations.switches)

    @functools.cached_property
    def switches(self) -> list[str]:
        """The kind of event of each branch."""
        recorded = self.stepped.equations
        switch, *own = self.stepped.event_kinds[self.stepped.contact_kinds :]  # of the laws, of the machine
        return [switch] * recorded.law_switches + own[: len(recorded.switches) - recorded.law_switches]

    @functools.cached_property
    def counted(self) -> list[str]:
        """Kinds of event that are counted."""
        return list(dict.fromkeys((*CONTACT, *self.switches)))

    @functools.cached_property
    def values(self) -> list[float]:
        """The memory at the start, guards last."""
        found, places = [0.0] * (self.instant.size + self.guards), self.instant.places
        for i, value in enumerate(parameter_values(self.stepped.system)):
            found[places["PARAMETER"] + i] = value
        for i, each in enumerate(self.stepped.states):
            found[places["STATE"] + i] = each.value
        return found

    @functools.cached_property
    def constants(self) -> dict[str, int]:
        """Of the C around it: places and numbers by name."""
        recorded = self.stepped.equations
        return {
            **self.instant.places,
            **_of_drive(self.stepped, self.instant.places["PARAMETER"], self.instant.sizes["TABLE"]),
            "INDICATOR": self.instant.size,
            "VALUES": len(self.values),
            "COUNTS": 1 + len(self.counted),
            "STATES": len(recorded.rates),
            "BOUNDS": len(self.bounds),
            "SWITCHES": len(recorded.switches),
            "CONTACT": recorded.contacts[0].state,
        }

    @property
    def lines(self) -> list[str]:
        """Declarations in C."""
        counts = [str(1 + self.counted.index(each)) for each in self.switches]
        return [
            f"void {self.name}_drive(double *values);",
            f"void {self.name}_equations(double *values);",
            f"void {self.name}_after(double *values, int guard);",
            f"#define DRIVE {self.name}_drive",
            f"#define EQUATIONS {self.name}_equations",
            f"#define AFTER {self.name}_after",
            f"static const int count_of_switch[] = {{{', '.join(counts) or '0'}}};",
            f"static const int bound_status[] = {{{', '.join(map(str, self.bounds)) or '0'}}};",
        ]


def _of_drive(stepped: SteppedCase, parameters: int, table: int) -> dict[str, int]:
    """Where the numbers of the present segment stand, and an input; into how many equal parts corners cut the period,
    and how many segments follow one another in each."""
    corners = stepped.equations.corners
    if corners is None:
        return {"SEGMENT": 0, "HELD": 0, "COEFFICIENTS": 0, "SEGMENTS": 0, "PARTS": 1}
    segment, row = parameters + corners.place, corners.row_size
    counts = {"SEGMENTS": table // row, "PARTS": corners.count(np.array(parameter_values(stepped.system)))}
    return {"SEGMENT": segment, "HELD": segment + 2, "COEFFICIENTS": row - 1, **counts}
