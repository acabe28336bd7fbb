"""Why a branch ends, whatever is followed."""

from vibrocap.results import Advised


class BranchEnd(Advised):
    """Why a branch was not followed further; `advice` says what to try."""

    PARAMETER_BOUND = "parameter bound", "The end of the range asked for."
    PITCHFORK = (
        "pitchfork",
        "The orbit has become symmetric: the branch is born here from that of symmetric orbits, and beyond it its "
        "mirror twins come.",
    )
    FLIP = (
        "flip",
        "The orbit has become one of half its period: the branch is born here, and beyond it the same orbits come "
        "again, a period later.",
    )
    HOPF = (
        "Hopf point",
        "The cycles shrink to an equilibrium, at which they are born: `equilibrium_branch` follows that.",
    )
    CLOSED = "closed", "The branch has come back to its start."
    ORBIT_CEASES = (
        "orbit ceases",
        "The mode sequence would change here, and no orbit of the new one continues this one: such orbits cease to"
        " exist. Simulate beyond it (`orbit(system, initial=...)`) to see what follows.",
    )
    GRAZING = (
        "grazing",
        "The motion grazes a stop, which changes it like a square root: such orbits cease to exist here, or continue "
        "with another impact. Simulate beyond it (`orbit(system, initial=...)`) to see what follows.",
    )
    LIFT_OFF = (
        "lift off",
        "A contact loses its load here: beyond it the machine would lift off, and the equations end.",
    )
    REST = "contact comes to rest", "The sliding velocity of a contact vanishes: beyond it sticks or slides back."
    OTHER_BRANCH = "other branch of the equations", "A stop is met or left, or a law changes its piece; look beyond it."
    NO_LOAD = "load vanishes", "The machine would lift off, or its load does not follow from the forces any more."
    NEWTON_FAILED = (
        "Newton failed",
        "No next point closes however small the step: such motions cease to exist here, as where a motion grazes, or "
        "Newton's method cannot follow. Try another `tolerance`, or start from a motion beyond this parameter.",
    )
    TOO_MANY_POINTS = "too many points", "Raise `points`, or allow longer steps with `step`."
    NOT_FOLLOWED = "not followed", "It was not asked to follow the branch this way."
    START_FAILED = "start failed", "No orbit closes at the start. Give an `orbit`, or another `initial`."

    @property
    def early(self) -> bool:
        """Whether the branch continues, but was not followed so far."""
        return self in (BranchEnd.NEWTON_FAILED, BranchEnd.TOO_MANY_POINTS, BranchEnd.START_FAILED)

    @property
    def words(self) -> str:
        """The end, with its advice where the branch continues or something else begins there."""
        beyond = (BranchEnd.ORBIT_CEASES, BranchEnd.REST, BranchEnd.OTHER_BRANCH, BranchEnd.NO_LOAD)
        return f"{self.value}. {self.advice}" if self.early or self in beyond else self.value
