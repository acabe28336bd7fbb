"""The certificate of a motion: the evidence that it is what the equations say, and the verdict on each piece of it."""

import dataclasses

UNFINISHED = "the motion did not finish: the evidence covers its computed part"


@dataclasses.dataclass(frozen=True)
class Verdict:
    """One piece of evidence beside the bound that it is held to.

    field: of the certificate; text: where it is beyond its bound, what was found and what that probably means
    bound: the largest value that passes; None: the field has no bound
    """

    field: str
    value: float
    bound: float | None
    text: str = ""

    in_record = "field value bound ok"

    @property
    def ok(self) -> bool:
        """Whether the value is within its bound."""
        return self.bound is None or self.value <= self.bound


@dataclasses.dataclass(frozen=True, repr=False)
class Certificate:
    """Evidence that a motion is what the equations say.

    stick_force_ratio: largest |R|/(N eta_s) while stuck; at most 1 to rounding (None: the law cannot stick). Of several
    contacts the largest, and so for the least velocity.
    slip_shortfall: largest 1 - |R|/(N eta_s) where a contact began to slip; 0 to rounding (None: never).
    event_velocity: largest |contact velocity| at located events, before it was set to zero.
    sign_kept: whether the velocity kept its sign between events (least side * v, which may be negative by rounding).
    energy_residual: largest |energy - initial - work of all channels| over the motion; momentum_residual likewise.
    estimated_error: of the states (over their natural size) at the period marks and the end, from a second run at a
    tenth of the tolerance: their difference over 0.9. None where the two runs have no later instant in common.
    defect: largest h |y' - f(t, y)| over the natural size of a state, h the length of the step, at nine points of every
    step and of Taylor steps about where the contact is slowest. Of an implicit step it is the distance to the state
    that fits to the slopes (`linear_system.py`): the same but along the stiff directions, where friction multiplies it.
    least_reaction: least normal reaction that the ground would have to give (None: the machine does not say).
    verdicts: each of these beside its bound; `failures`: those beyond it, in words; `ok` without any.
    finished: whether the motion went to its end; one that did not is never certified.
    warnings: what the equations hide or an error covers: a lift-off under a constant load, states that hardly move.
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
    verdicts: tuple[Verdict, ...] = ()
    least_reaction: float | None = None
    warnings: tuple[str, ...] = ()
    slip_shortfall: float | None = None
    finished: bool = True

    @property
    def in_record(self) -> str:
        """What its views show: every field, and how it comes out."""
        return " ".join([*(field.name for field in dataclasses.fields(self)), "failures", "ok"])

    @property
    def ok(self) -> bool:
        """Whether the motion finished and all evidence is within its bounds."""
        return self.finished and all(verdict.ok for verdict in self.verdicts)

    @property
    def failures(self) -> tuple[str, ...]:
        """What is beyond its bound, in words."""
        unfinished = () if self.finished else (UNFINISHED,)
        return (*unfinished, *(verdict.text for verdict in self.verdicts if not verdict.ok))

    def verdict(self, field: str) -> Verdict | None:
        """The verdict on a field; None where there is nothing to judge."""
        return next((verdict for verdict in self.verdicts if verdict.field == field), None)

    def __repr__(self) -> str:
        """Passed or failed, and by what."""
        words = [
            f"{verdict.field} {verdict.value:.2g}"
            + ("" if verdict.bound is None else f" {'<=' if verdict.ok else '>'} {verdict.bound:.2g}")
            for verdict in self.verdicts
        ]
        steps = f"{self.taylor_steps} Taylor and {self.implicit_steps} implicit steps"
        word = "passed" if self.ok else "FAILED" if self.finished else "not finished"
        return f"Certificate({word}: {', '.join([*words, steps])})"
