"""Why a branch ends, and what to try then."""

import enum


class BranchEnd(enum.Enum):
    """Why a branch was not followed further; `advice` says what to try."""

    PARAMETER_BOUND = "parameter bound"
    PITCHFORK = "pitchfork"
    FLIP = "flip"
    CLOSED = "closed"
    ORBIT_CEASES = "orbit ceases"
    NEWTON_FAILED = "Newton failed"
    TOO_MANY_POINTS = "too many points"
    NOT_FOLLOWED = "not followed"
    START_FAILED = "start failed"

    @property
    def early(self) -> bool:
        """Whether the branch goes on, but was not followed so far."""
        return self in (BranchEnd.NEWTON_FAILED, BranchEnd.TOO_MANY_POINTS, BranchEnd.START_FAILED)

    @property
    def advice(self) -> str:
        """What it means and what can be done."""
        return ADVICE[self]


ADVICE = {
    BranchEnd.PARAMETER_BOUND: "The end of the range asked for.",
    BranchEnd.PITCHFORK: "The orbit has become symmetric: the branch is born here from that of symmetric orbits, and "
    "beyond it its mirror twins come.",
    BranchEnd.FLIP: "The orbit has become one of half its period: the branch is born here, and beyond it the same "
    "orbits come again, a period later.",
    BranchEnd.CLOSED: "The branch has come back to its start.",
    BranchEnd.ORBIT_CEASES: "The word of the motion would change here, and no orbit of the new word continues this "
    "one: such orbits cease to exist. Simulate beyond it (`orbit(system, initial=...)`) to see what follows.",
    BranchEnd.NEWTON_FAILED: "No next point closes however small the step: such orbits cease to exist here, as "
    "where a motion grazes, or Newton's method cannot follow. Try another `tolerance`, or start from an orbit beyond "
    "this parameter.",
    BranchEnd.TOO_MANY_POINTS: "Raise `points`, or allow longer steps with `step`.",
    BranchEnd.NOT_FOLLOWED: "It was not asked to follow the branch this way.",
    BranchEnd.START_FAILED: "No orbit closes at the start. Give an `orbit`, or another `initial`.",
}
