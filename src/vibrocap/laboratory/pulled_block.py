"""A block that is pulled over the ground: by a force that grows until friction lets it go (break-away), or through a
spring whose end moves at a constant speed (stick-slip).
"""

import dataclasses
import math
from collections.abc import Callable, Sequence

import numpy as np

from vibrocap.arguments import check_whole
from vibrocap.laboratory.contact_sizes import contact_sizes
from vibrocap.laboratory.driven import check_motion, check_numbers, checked_list
from vibrocap.measures.recorded.stretch import stretches
from vibrocap.motion.simulate import simulate
from vibrocap.motion.trajectory import STUCK, Trajectory
from vibrocap.physics.drives.loadings import Loading
from vibrocap.physics.events import SLIP_FORWARD
from vibrocap.physics.friction.law import Law
from vibrocap.physics.machines.oscillators import Oscillator
from vibrocap.physics.system import System

RATES = (0.003, 0.01, 0.03, 0.1, 0.3, 1.0)  # times the rate at which the contact yields with its own speed
PAST = 1.2  # break-away forces that the ramp passes through at first, and how much longer it gets each time
LONGER = (1.0, 1.5, 3.0)
FALLEN = 1e-6  # share of a maximum by which friction falls after it, to be no ripple of rounding
LOOKED = 8  # points per piece of the motion


@dataclasses.dataclass(frozen=True, eq=False)
class Pull:
    """One pull: applied and friction force, displacement and velocity over time, all [n]."""

    rate: float
    time: np.ndarray
    applied: np.ndarray
    friction: np.ndarray
    displacement: np.ndarray
    velocity: np.ndarray


@dataclasses.dataclass(frozen=True, eq=False)
class BreakAway:
    """Break-away forces by loading rate, all [rates] in the units of the law.

    force: the largest friction force before the mass slides away; applied: the force of the ramp at that instant
    velocity, displacement: of the mass there
    peaked: whether friction falls after it; where it does not (no Stribeck drop) `force` is the largest of the whole
        pull, and the instant means nothing (NaN)
    pulls: the motions; mass: that was pulled
    """

    rate: np.ndarray
    force: np.ndarray
    applied: np.ndarray
    velocity: np.ndarray
    displacement: np.ndarray
    peaked: np.ndarray
    pulls: tuple[Pull, ...]
    mass: float

    in_record = "rate force applied peaked"


def break_away(
    law: Law,
    rates: Sequence[float] | None = None,
    *,
    mass: float = 1.0,
    load: float = 1.0,
    tolerance: float = 1e-11,
) -> BreakAway:
    """Break-away force against loading rate (Canudas de Wit et al. 1995, section IV and Fig. 4).

    A mass at rest is pulled by the force q t. It yields elastically at first; then velocity rises sharply, and friction
    falls. The break-away force is the first maximum of friction after which it falls; the applied force is larger by
    what accelerates the mass. A law that knows only velocity lets go at one force; with bristles it falls with the
    rate, since bristles that are stretched quickly have no time to follow the Stribeck drop.

    rates: of the force, per unit of time; by default 0.003 to 1 of the rate at which the contact yields with the speed
        over which its friction changes (`contact_sizes`)
    mass: that is pulled; load: on the contact     All in any one system of units.

    LuGre's own parameters (sigma0 1e5, sigma1 sqrt(1e5), sigma2 0.4, Fc 1, Fs 1.5, v_s 1e-3, m 1): 1.43242 N at 1 N/s,
    1.21995 N at 10 N/s. Raises ValueError for rates, mass or load that are not positive numbers, and RuntimeError where
    a motion cannot be completed.
    """
    check_numbers(mass=mass, load=load)
    sizes = contact_sizes(law, load)
    rate = sizes.stiffness * sizes.speed * np.array(RATES) if rates is None else checked_list("rates", rates)
    machine, rows, pulls = Oscillator(mass=mass, stiffness=0.0, normal_load=load), [], []
    for q in map(float, rate):
        # What the ramp needs to reach the break-away force, and the mass to move by the displacement of the contact.
        duration = PAST * sizes.force / q + 6.0 * math.sqrt(mass * sizes.displacement / sizes.force)
        row, pull = _pulled(machine, law, q, LONGER[0] * duration, tolerance)
        for longer in LONGER[1:]:
            if not row[-1]:  # friction has not fallen yet
                row, pull = _pulled(machine, law, q, longer * duration, tolerance)
        rows.append(row)
        pulls.append(pull)
    force, applied, velocity, displacement, peaked = np.array(rows).T
    return BreakAway(rate, force, applied, velocity, displacement, peaked > 0.0, tuple(pulls), mass)


def _pulled(
    machine: Oscillator, law: Law, rate: float, duration: float, tolerance: float
) -> tuple[tuple[float, ...], Pull]:
    """(force, applied, velocity, displacement, whether it peaked) of one pull, and its course."""
    drive = Loading(level=0.0, rate=rate, amplitude=0.0, frequency=2.0 * math.pi / duration)
    motion = simulate(System(machine, law, drive), periods=1, tolerance=tolerance)
    check_motion(motion.status, law)
    # Looked at within every piece, at both ends of it, and where friction turns.
    points = motion.piece_start[:, None] + motion.piece_length[:, None] * np.linspace(0.0, 1.0, LOOKED)
    turns = [part.roots(part.friction_rate) for part in stretches(motion, 0.0, motion.end) if part.side]
    time = np.unique(np.concatenate((points.ravel(), *turns)))
    # Where a contact lets go, friction is that of the contact at rest.
    index = np.maximum(np.searchsorted(motion.piece_start, time, side="left") - 1, 0)
    friction = motion.piece_observables(("friction",), index, time - motion.piece_start[index])[0]
    place, velocity = motion.states(time)[:2]
    slips = motion.event_times[motion.event_kinds == SLIP_FORWARD]
    # The first maximum after which friction falls before it rises beyond it.
    fallen = np.flatnonzero(friction < (1.0 - FALLEN) * np.maximum.accumulate(friction))
    at = int(np.argmax(friction[: fallen[0]] if len(fallen) else friction))
    if let_go := law.kind == "set-valued" and len(slips) > 0:
        at = int(np.searchsorted(time, slips[0]))
    peaked = let_go or len(fallen) > 0
    there = (rate * time[at], velocity[at], place[at]) if peaked else (math.nan,) * 3
    return (friction[at], *there, float(peaked)), Pull(rate, time, rate * time, friction, place, velocity)


STILL = 0.1  # of the pulling speed: a block that is slower sticks, with a law that never holds it quite at rest
REPEATS = 1e-4  # relative difference of the last two cycles below which the motion has settled
QUIET = 1e-3  # of the largest pull: the swing of a pull that is steady
RIPPLE = 0.5  # of the swing of the pull in the second half of the test: a lower peak is no cycle
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
    tolerance: float = 1e-10,
) -> StickSlipCycle:
    """Stick-slip of a block that is pulled through a spring (Canudas de Wit et al. 1995, section IV and Fig. 5).

    The block sticks while the spring is stretched, lets go, overshoots and sticks again, if friction drops when it
    slides and spring and speed are small enough. With static and kinetic friction alone, D = (Fs - Fk)/k,
    omega = sqrt(k/m) and the speed V:

        stick time 2 D/V,   slip time (2/omega) (pi - atan(omega D/V)),   amplitude sqrt(D^2 + V^2/omega^2)

    stiffness, speed: of the spring and of its pulled end; mass: of the block; load: on the contact
    cycles: for about how many the test lasts (each as long as loading the spring and swinging back)

    The block sticks where a set-valued law holds it; on bristles it creeps at about k/K of the speed, where K is the
    stiffness of the contact, so with other laws it sticks where it is slower than a tenth of the speed.
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
    rests = _rests(motion, start, end, still)
    stuck = sum(b - a for a, b in rests)
    inside = (arrays["time"] >= start) & (arrays["time"] <= end)
    ends = -stiffness * motion.states(turns[(turns >= start) & (turns <= end)])[0]
    period, slipping, largest, least = end - start, end - start - stuck, float(ends.max()), float(ends.min())
    times = np.array([start, *(time for rest in rests for time in rest), end])
    impulse = np.diff(motion.integrals(times)[motion.integral_names.index("impulse")])[::2]  # over the slips
    kinetic = float(np.sum(impulse)) / slipping if slipping > 0.0 else math.nan
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
