"""What can be special on a branch, whatever is followed."""

from vibrocap.results import Explained


class SpecialKind(Explained):
    """What a special point is; `meaning` says it in words."""

    FOLD = (
        "fold",
        "The branch turns back in the parameter (multiplier 1, eigenvalue 0); beyond it there are no such motions.",
    )
    PITCHFORK = "pitchfork", "The symmetry breaks (multiplier 1): a pair of mirror twins begins or ends here."
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
