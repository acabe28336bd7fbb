"""What can be special on a branch and why one ends, and what happens where the modes of the contacts change.

A mode sequence is written in the letters F (forward), S (stuck) and B (back); `Orbit.mode_sequence` shows it.
"""

import enum
import itertools

from vibrocap.measures.recorded.sticking import BETWEEN, as_cycle, by_contact
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


MIRROR_LETTERS = str.maketrans("FB", "BF")
MOST_PHASES = 3  # that one change may take out of a sequence


class ModeChange(enum.Enum):
    """What happens where a mode sequence changes, after the phase that appears or vanishes and its neighbours."""

    CROSSING = "crossing"  # rest between sliding one way and the other: FSB, FB
    GRAZING = "grazing"  # the velocity touches zero within a slide: FSF or FBF, F
    SPLITTING = "splitting"  # a short slip within a rest: SFS, S
    SWITCHING = "switching"  # a rest is left the one way or the other: SFB, SB
    UNNAMED = "unnamed"  # more than one change at one place


def closed_sequence(sequence: str, half: bool = False) -> str:
    """The sequence of a whole response from that of a run over it, or over its first half before the mirror."""
    whole = sequence + sequence.translate(MIRROR_LETTERS) if half else sequence
    return as_cycle([letter for letter, _ in itertools.groupby(whole)])


def same_cycle(one: str, other: str) -> bool:
    """Whether two words are the same cycle of phases at each contact, begun at different sections."""
    pairs = zip(by_contact(one), by_contact(other), strict=True)
    return all(len(before) == len(after) and after in before + before for before, after in pairs)


def mode_change(before: str, after: str) -> tuple[ModeChange, str]:
    """(kind, in words) of the change from one cycle of phases to another; of several contacts, at that which changes.

    Where several change at once, it is unnamed unless all do alike.
    """
    pairs = enumerate(zip(by_contact(before), by_contact(after), strict=True), 1)
    changes = {i: _change(*pair) for i, pair in pairs if BETWEEN not in before or not same_cycle(*pair)}
    kinds = {kind for kind, _ in changes.values()}
    words = (f"{text} at contact {i}" if BETWEEN in before else text for i, (_, text) in changes.items())
    return kinds.pop() if len(kinds) == 1 else ModeChange.UNNAMED, "; ".join(words)


def _change(before: str, after: str) -> tuple[ModeChange, str]:
    """The same of one contact. A phase that vanishes takes one neighbour along where both are alike."""
    longer, shorter = (before, after) if len(before) >= len(after) else (after, before)
    verb, fewer = "vanish" if longer is before else "appear", len(longer) - len(shorter)
    alike: dict[tuple[ModeChange, bool], list[int]] = {}
    for i, letter in enumerate(longer):
        alike.setdefault((_kind(longer, i), letter == "S"), []).append(i)
    for count in range(max(1, (fewer + 1) // 2), min(fewer, MOST_PHASES) + 1):
        names = []
        for (kind, sticks), places in alike.items():
            choices = itertools.combinations(places, count)
            if phases := next((left for left in choices if same_cycle(_without(longer, left), shorter)), None):
                names.append((phases, kind, sticks))
        if names:
            _, kind, sticks = min(names, key=lambda change: change[0])
            phase = "stick phase" if sticks else "slip phase"
            if count == 1:
                return kind, f"a {phase} {verb}{'es' if verb == 'vanish' else 's'}"
            return kind, f"{('two', 'three')[count - 2]} {phase}s {verb}"
    return ModeChange.UNNAMED, "several phases change at once"


def _without(sequence: str, phases: tuple[int, ...]) -> str:
    """The cycle without these phases, whose neighbours become one where they are alike."""
    starts, ends = (0, *(i + 1 for i in phases)), (*phases, len(sequence))
    return closed_sequence("".join(sequence[start:end] for start, end in zip(starts, ends, strict=True)))


def _kind(sequence: str, i: int) -> ModeChange:
    before, phase, after = sequence[i - 1], sequence[i], sequence[(i + 1) % len(sequence)]
    if before != after:
        return ModeChange.CROSSING if phase == "S" else ModeChange.SWITCHING
    return ModeChange.SPLITTING if before == "S" else ModeChange.GRAZING
