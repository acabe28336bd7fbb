"""The certificate of a motion: the evidence that it is what the equations say, and the verdict on each piece of it."""

import dataclasses
from typing import Any


@dataclasses.dataclass(frozen=True)
class Certificate:
    """Evidence that a motion is what the equations say.

    stick_force_ratio: largest |R|/(N eta_s) while stuck; at most 1 to rounding (None: the law cannot stick).
    event_velocity: largest |contact velocity| at located events, before it was set to zero.
    sign_kept: whether the velocity kept its sign between events (least side * v, which may be negative by rounding).
    energy_residual: largest |energy - initial - work of all channels| over the motion; momentum_residual likewise.
    estimated_error: of the states (over their natural size) at the period marks and the end, from a second run at ten
    times the tolerance: their difference over nine. None where the two runs have no later instant in common.
    defect: largest h |y' - f(t, y)| over the natural size of a state, h the length of the step: what the polynomials of
    the motion leave of the equations. Asked at nine points of every Taylor step, and about where the contact is
    slowest; of an implicit step the end is exact, not its polynomial.
    failures: what of this is beyond its bound, in words; `ok` where nothing is.
    """

    stick_force_ratio: float | None
    event_velocity: float
    sign_kept: bool
    least_velocity: float
    energy_residual: float
    momentum_residual: float
    estimated_error: float | None
    taylor_steps: int
    implicit_steps: int
    defect: float
    failures: tuple[str, ...] = ()

    @property
    def ok(self) -> bool:
        """Whether all that is known speaks for the motion."""
        return not self.failures

    def record(self) -> dict[str, Any]:
        """All of it by name, `ok` included."""
        return dataclasses.asdict(self) | {"ok": self.ok}
