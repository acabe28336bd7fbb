"""What the equations of one form have: on this depend the modules of a kernel, its memory and its generated code."""

import dataclasses

from vibrocap.numerics.expressions.equations import Equations
from vibrocap.numerics.expressions.structure import slow_bristles, slow_states


@dataclasses.dataclass(frozen=True, kw_only=True)
class Traits:
    """Numbers of states, contacts and guards, and how the laws move."""

    states: int
    parameters: int
    tangent: bool = False  # whether the last states are a tangent
    switches: int = 0  # guards of the branches of law and machine, and bounds
    coefficients: int = 0  # per segment of a drive with corners; 0: it has none
    contacts: int = 1
    held: int = 0  # contacts that can rest, each with two rows: the force that holds it, and its limit
    imposed: int = 0  # contact velocities that are no states
    shifts: int = 0  # of contacts at imposed distances, where one may be stiff: how far each is ahead of their state
    turns: int = 0  # coordinates that turn, of which a mark keeps a second number
    stiff: bool = True  # whether a contact has a law with a force for every velocity
    slow: tuple[tuple[int, int], ...] = ()  # slow manifolds: (contact, state that may be slaved)
    rates: tuple[int, ...] = ()  # of each state the one that is its rate, whose series tells its own, else -1; (): none

    @property
    def several(self) -> bool:
        """Whether there are several contacts."""
        return self.contacts > 1

    @property
    def corners(self) -> bool:
        """Whether the drive has corners."""
        return self.coefficients > 0


def traits(equations: Equations, side_by_side: bool = False) -> Traits:
    """What these equations have; side_by_side: for motions in lanes, where each bristle may be slaved by itself."""
    corners, stiff = equations.corners, equations.maybe_stiff
    return Traits(
        states=len(equations.rates),
        parameters=len(equations.parameter_paths),
        tangent=len(equations.rates) > equations.base,
        switches=len(equations.guards),
        coefficients=0 if corners is None else corners.coefficients,
        contacts=len(equations.contacts),
        held=sum(contact.sticks for contact in equations.contacts),
        imposed=len(equations.imposed),
        shifts=len(equations.shifts) if stiff else 0,
        turns=len(equations.turns),
        stiff=stiff,
        slow=slow_bristles(equations) if side_by_side else slow_states(equations),
        rates=_kept_rates(equations),
    )


def _kept_rates(equations: Equations) -> tuple[int, ...]:
    """Of each state the state that is its rate, if that one is kept whole; none where a series may be damped."""
    kept: list[int] = []
    for state, rate in enumerate(own.state for own in equations.rates):
        follows = rate not in (-1, state) and state not in kept and (rate > state or kept[rate] < 0)
        kept.append(rate if follows and not equations.maybe_stiff else -1)
    return tuple(kept)
