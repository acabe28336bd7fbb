"""What can be special on a branch, and why one ends, whatever is followed."""

from vibrocap.results import Advised, Explained


class SpecialKind(Explained):
    """What a special point is; `meaning` says it in words."""

    FOLD = (
        "fold",
        "The branch turns back in the parameter (multiplier 1, eigenvalue 0); beyond it there are no such motions.",
    )
    PITCHFORK = "pitchfork", "The symmetry breaks (multiplier 1): a pair of mirror-image solutions begins or ends here."
    FLIP = "flip", "A multiplier is -1: an orbit of twice the period begins or ends here."
    NEIMARK_SACKER = (
        "Neimark-Sacker",
        "A pair of multipliers crosses the unit circle: quasi-periodic motion begins here.",
    )
    BRANCH_POINT = "branch point", "Another branch of the same kind crosses here (multiplier 1, eigenvalue 0)."
    HOPF = "Hopf", "A pair of eigenvalues passes the imaginary axis: cycles are born from the equilibrium here."
    MODE_COUPLING = "mode coupling", "Two frequencies without damping meet; beyond it one vibration grows."
    MODE_CHANGE = "change of mode sequence", "The phases of sliding and sticking change."
    GRAZING = "grazing of a stop", "A mass touches its stop without speed: an impact begins or ends here."
    CHATTER = (
        "accumulating impacts",
        "Impacts begin or cease to follow one another without end until the mass rests at its stop.",
    )
    JUMP = (
        "jump of multipliers",
        "The multipliers jump without a change of the mode sequence; the motion grazes something there.",
    )
    UNLOCATED = (
        "not located",
        "Something changes faster than it can be located: follow the branch with a smaller `step`, or from a motion "
        "near this parameter.",
    )


CORNERS = (SpecialKind.MODE_CHANGE, SpecialKind.GRAZING, SpecialKind.CHATTER)  # between which all is smooth


class BranchEnd(Advised):
    """Why a branch was not followed further; `advice` says what to try."""

    PARAMETER_BOUND = "parameter bound", "The end of the requested range."
    PITCHFORK = (
        "pitchfork",
        "The orbit has become symmetric: the branch is born here from that of symmetric orbits, and beyond it its "
        "mirror-image solutions come.",
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
    NOT_FOLLOWED = "not followed", "The branch was not to be followed in this direction."
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
