"""The stick-slip test: a block is pulled over the ground through a spring whose end moves at a constant speed."""

import dataclasses
import math
from collections.abc import Callable

import numpy as np

from vibrocap.arguments import check_whole
from vibrocap.laboratory.contact_sizes import contact_sizes
from vibrocap.laboratory.driven import check_motion, check_numbers
from vibrocap.measures.recorded.stretch import stretches
from vibrocap.motion.simulate import simulate
from vibrocap.motion.trajectory import STUCK, Trajectory
from vibrocap.physics.drives.loadings import Loading
from vibrocap.physics.friction.law import Law
from vibrocap.physics.machines.oscillators import Oscillator
from vibrocap.physics.system import System

STILL = 0.1  # of the pulling speed: a block that is slower sticks, with a law that never holds it quite at rest
REPEATS = 1e-4  # relative difference of the last two cycles below which the motion has settled
QUIET = 1e-3  # of the largest pull: the swing of a pull that is steady
RIPPLE = 0.5  # of the swing of the pull in the second half of the test: a lower peak is no cycle
TOLERANCE = 1e-10
NUMBERS = (
    "period", "stick_time", "slip_time", "amplitude", "largest_pull", "least_pull", "static_force", "kinetic_force",
)  # fmt: skip
POINTS = 6  # per piece of the motion


@dataclasses.dataclass(frozen=True, eq=False)
class StickSlipCycle:
    """A block pulled through a spring, in the units of the law; numbers are of the last whole cycle, NaN without one.

    regime: "stick-slip", "oscillation" (it swings but never sticks), "steady" (it slides at the pulling speed, or
        swings ever less about it) or "undecided" (the test was too short)
    period: between two largest pulls; stick_time, slip_time: the parts of it
    amplitude: half the difference of largest and least stretch of the spring
    largest_pull, least_pull: of the spring; static_force: largest friction; kinetic_force: its mean while slipping
    settled: whether the last two cycles agree to 1e-4
    still: speed below which the block counts as sticking; 0 with a law that holds it
    time, pull, friction, displacement, velocity: [n] of the whole run, of spring and block over the ground
    """

    regime: str
    period: float
    stick_time: float
    slip_time: float
    amplitude: float
    largest_pull: float
    least_pull: float
    static_force: float
    kinetic_force: float
    settled: bool
    still: float
    time: np.ndarray
    pull: np.ndarray
    friction: np.ndarray
    displacement: np.ndarray
    velocity: np.ndarray

    in_record = (
        "regime period stick_time slip_time amplitude largest_pull least_pull static_force kinetic_force settled"
    )

    @property
    def sticks(self) -> bool:
        """Whether the motion is one of stick and slip."""
        return self.regime == "stick-slip"


def stick_slip_test(
    law: Law,
    stiffness: float = 2.0,
    speed: float = 0.1,
    *,
    mass: float = 1.0,
    load: float = 1.0,
    cycles: int = 12,
    tolerance: float = TOLERANCE,
) -> StickSlipCycle:
    """Stick-slip of a block that is pulled through a spring (Canudas de Wit et al. 1995, section IV and Fig. 5).

    The block sticks while the spring is stretched, lets go, overshoots and sticks again, if friction drops when it
    slides and spring and speed are small enough. With static and kinetic friction alone, D = (Fs - Fk)/k,
    omega = sqrt(k/m) and the speed V:

        stick time 2 D/V,   slip time (2/omega) (pi - atan(omega D/V)),   amplitude sqrt(D^2 + V^2/omega^2)

    stiffness, speed: of the spring and of its pulled end; mass: of the block; load: on the contact
    cycles: for about how many the test lasts (each as long as loading the spring and swinging back)

    While the spring is loaded a block on bristles creeps at about k/K of the speed, where K is the stiffness of the
    contact. So the block sticks where a set-valued law holds it; with other laws where it is slower than a tenth of the
    speed.
    Raises ValueError for what is not a positive number, and RuntimeError where the motion cannot be completed.
    """
    check_numbers(stiffness=stiffness, speed=speed, mass=mass, load=load)
    check_whole("cycles", cycles, 1)
    sizes = contact_sizes(law, load)
    unit = sizes.force / (stiffness * speed) + 2.0 * math.pi * math.sqrt(mass / stiffness)
    machine = Oscillator.pulled(speed, mass=mass, stiffness=stiffness, normal_load=load)
    drive = Loading(level=0.0, rate=0.0, amplitude=0.0, frequency=2.0 * math.pi / unit)
    start = {"position": 0.0, "sliding_velocity": 0.0}
    motion = simulate(System(machine, law, drive), periods=cycles, initial=start, tolerance=tolerance)
    check_motion(motion.status, law)
    share = np.linspace(0.0, 1.0, POINTS)
    index = np.repeat(np.arange(len(motion.piece_start)), POINTS)
    local = (motion.piece_length[:, None] * share).ravel()
    time = motion.piece_start[index] + local  # both sides of every border: friction may jump there
    stretch, velocity = motion.piece_states(index, local)[:2]
    arrays = {
        "time": time,
        "pull": -stiffness * stretch,
        "friction": motion.piece_observables(("friction",), index, local)[0],
        "displacement": stretch + speed * time,
        "velocity": velocity,
    }
    still = 0.0 if law.kind == "set-valued" else STILL * speed
    return StickSlipCycle(**_cycle(motion, stiffness, speed, still, arrays), still=still, **arrays)


def _cycle(motion: Trajectory, stiffness: float, speed: float, still: float, arrays: dict[str, np.ndarray]) -> dict:
    """Numbers of the last whole cycle, between two largest pulls; smaller ripples of the pull are no cycles."""
    from scipy.signal import find_peaks

    turns = _roots(motion, lambda t: motion.states(t)[1] - speed)  # the spring is neither stretched nor released
    pulls = -stiffness * motion.states(turns)[0] if len(turns) else turns
    swing = float(np.ptp(arrays["pull"][arrays["time"] >= 0.5 * motion.end]))
    tops = turns[find_peaks(pulls, prominence=RIPPLE * swing)[0]]
    if len(tops) < 2:
        late = arrays["velocity"][arrays["time"] >= 0.75 * motion.end]
        steady = bool(np.max(np.abs(late - speed)) <= STILL * speed)
        nothing = dict.fromkeys(NUMBERS, math.nan)
        return {"regime": "steady" if steady else "undecided", "settled": steady, **nothing}
    start, end = float(tops[-2]), float(tops[-1])
    stuck = sum(b - a for a, b in _rests(motion, start, end, still))
    inside = (arrays["time"] >= start) & (arrays["time"] <= end)
    ends = -stiffness * motion.states(turns[(turns >= start) & (turns <= end)])[0]
    period, slipping, largest, least = end - start, end - start - stuck, float(ends.max()), float(ends.min())
    kinetic = _slip_impulse(motion, start, end, still) / slipping if slipping > 0.0 else math.nan
    forces = largest, least, float(np.max(arrays["friction"][inside])), kinetic
    times = period, stuck, slipping, 0.5 * float(np.ptp(ends)) / stiffness
    numbers = dict(zip(NUMBERS, (*times, *forces), strict=True))
    swing = largest - least
    steady = swing <= QUIET * largest
    before = float(tops[-2] - tops[-3]) if len(tops) > 2 else math.inf
    growth = -stiffness * float(np.diff(motion.states(tops[-2:])[0])[0])
    settled = abs(before - period) <= REPEATS * period and abs(growth) <= REPEATS * swing
    regime = "stick-slip" if stuck > 0.0 else "steady" if steady or growth < -REPEATS * swing else "oscillation"
    return {"regime": regime, "settled": settled or steady, **numbers}


def _roots(motion: Trajectory, function: Callable[[np.ndarray], np.ndarray]) -> np.ndarray:
    """Times at which a continuous function of time changes its sign."""
    roots = [part.roots(function) for part in stretches(motion, 0.0, motion.end)]
    return np.unique(np.concatenate(roots))


def _rests(motion: Trajectory, start: float, end: float, still: float) -> list[tuple[float, float]]:
    """(start, end) of the times of rest within a cycle."""
    if still == 0.0:
        rests = [(phase.start, phase.end) for phase in motion.phases if phase.side == STUCK]
    else:
        marks = _roots(motion, lambda t: np.abs(motion.states(t)[1]) - still)
        marks = np.concatenate(([0.0], marks, [motion.end]))
        slow = np.abs(motion.states(0.5 * (marks[1:] + marks[:-1]))[1]) < still
        rests = list(zip(marks[:-1][slow].tolist(), marks[1:][slow].tolist(), strict=True))
    cut = [(max(a, start), min(b, end)) for a, b in rests]
    return [(a, b) for a, b in cut if b > a]


def _slip_impulse(motion: Trajectory, start: float, end: float, still: float) -> float:
    """Impulse of friction over the slips of a cycle."""
    rests = _rests(motion, start, end, still)
    times = np.array([start, *(time for rest in rests for time in rest), end])
    impulse = motion.integrals(times)[motion.integral_names.index("impulse")]
    return float(np.sum(np.diff(impulse)[::2]))
