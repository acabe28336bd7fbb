"""A closed cycle of a contact: a velocity that repeats, and internal states that return to where they began."""

import dataclasses
import math
from collections.abc import Sequence

import numpy as np

from vibrocap.laboratory.recorded_law import RecordedLaw

Numbers = Sequence[float] | np.ndarray
POINTS = 64  # per level of the velocity, of the arrays that are handed out
CLOSED = 1e-8  # over the natural size of an internal state: how exactly a cycle returns
PROBE = 1e-5  # over the natural size: of the differences that make the Jacobian of the map
MOST_SWITCHES = 100  # within one level
PLAIN, TURNS = 2, 12  # turns towards a cycle that closes: plain ones first, then Newton steps


@dataclasses.dataclass(frozen=True, eq=False)
class Cycle:
    """One period of a motion under piecewise constant velocity, after which the contact is as it was.

    time, velocity, force [n]; internal [n, states], with both sides of every jump of the velocity
    energy: taken by the contact over the cycle, the integral of R v; negative: given
    share: energy over the integral of |R v|, from -1 (all power comes out of the contact) to 1
    closure: largest difference of an internal state over the cycle, over its natural size
    """

    time: np.ndarray
    velocity: np.ndarray
    force: np.ndarray
    internal: np.ndarray
    energy: float
    share: float
    closure: float

    @property
    def period(self) -> float:
        """Duration."""
        return float(self.time[-1])

    @property
    def fastest(self) -> float:
        """Largest speed."""
        return float(np.max(np.abs(self.velocity)))


def closed_cycle(
    recorded: RecordedLaw,
    levels: Numbers,
    durations: Numbers,
    start: Numbers,
    scales: Numbers,
) -> Cycle | None:
    """The cycle of a law under levels of velocity held for the given durations, from a guess of its internal states.

    The internal states follow by SciPy's LSODA at 1e-10; those in which the cycle closes by repetition, then by
    Newton's method on the map over one period. None where it does not close, or is not finite.

    levels, durations [levels]   start, scales [states]: the guess, and the natural size of each internal state
    """
    state, size = np.array(start, dtype=float), np.asarray(scales, dtype=float)
    for attempt in range(TURNS):
        turned = _turn(recorded, levels, durations, state, size)
        if turned is None:
            return None
        miss = (turned[-1].internal[-1] - state) / size
        closure = float(np.max(np.abs(miss), initial=0.0))
        if closure <= CLOSED:
            return _cycle(turned, closure)
        step = miss * size if attempt < PLAIN else _newton_step(recorded, levels, durations, state, size, miss)
        state = state + step
    return None


@dataclasses.dataclass(frozen=True, eq=False)
class _Stretch:
    """What happens at one level: time [n], velocity, force [n], internal [n, states], energy and integral of |R v|."""

    time: np.ndarray
    velocity: float
    force: np.ndarray
    internal: np.ndarray
    energy: float
    magnitude: float


def _turn(recorded, levels, durations, state, size) -> list[_Stretch] | None:
    """One period from a state; None where something is not finite."""
    side = next((math.copysign(1.0, v) for v in reversed(levels) if v), 1.0)
    now, found = 0.0, []
    for velocity, duration in zip(levels, durations, strict=True):
        if velocity * side < 0.0:
            side = -side
            state = recorded.turned(state, -side, side)
        stretch = _stretch(recorded, velocity, side, state, size, now, duration)
        if stretch is None:
            return None
        found.append(stretch)
        state, now = stretch.internal[-1], now + duration
    return found


def _stretch(recorded, velocity, side, state, size, now, duration) -> _Stretch | None:
    """Internal states under a constant velocity, switch after switch."""
    from scipy.integrate import solve_ivp

    states, load, law = len(state), recorded.load, recorded.law

    def rates(_t, y):
        force, internal = law.force(velocity, tuple(y[:states].tolist()), side, load)
        return [*internal, force * velocity, abs(force * velocity)]

    def guard(which):
        def value(_t, y):
            return law.switches(velocity, tuple(y[:states].tolist()), side, load)[which]

        vars(value).update(terminal=True, direction=-1)
        return value

    guards = [guard(which) for which in range(len(recorded.switches))]
    forces = recorded.values([recorded.force], velocity, np.array([state, size, -size]).T, side)
    energy_size = np.nanmax(np.abs(forces), initial=1e-300) * abs(velocity) * duration + 1e-300
    small = 1e-12 * np.append(size, [energy_size] * 2)
    t, y = [], []
    start, before = 0.0, np.append(state, (0.0, 0.0))
    for _ in range(MOST_SWITCHES):
        before[:states] = recorded.settled_pieces(velocity, before[:states], side)
        if not np.all(np.isfinite(before)):
            return None
        grid = np.linspace(start, duration, POINTS)
        found = solve_ivp(rates, (start, duration), before, "LSODA", grid, events=guards, rtol=1e-10, atol=small)
        if found.status < 0 or not np.all(np.isfinite(found.y)):
            return None
        t.append(found.t)
        y.append(found.y.T)
        if found.status == 0:
            break
        which = next(i for i, times in enumerate(found.t_events) if len(times))
        start, before = float(found.t_events[which][0]), found.y_events[which][0].copy()
        before[:states] = recorded.values(recorded.after_switch[which], velocity, before[:states], side)
    else:
        return None
    times, values = np.concatenate(t), np.concatenate(y)
    internal = values[:, :states]
    force = recorded.values([recorded.force], velocity, internal.T, side)[0]
    energy, magnitude = map(float, values[-1, states:])
    return _Stretch(now + times, velocity, np.broadcast_to(force, times.shape), internal, energy, magnitude)


def _newton_step(recorded, levels, durations, state, size, miss) -> np.ndarray:
    """Step towards the state that the map over one period leaves as it is, from differences of that map."""
    moving = recorded.continuous
    matrix = np.empty((len(moving), len(moving)))
    for column, j in enumerate(moving):
        probe = state.copy()
        probe[j] += PROBE * size[j]
        turned = _turn(recorded, levels, durations, probe, size)
        if turned is None:
            return miss * size
        matrix[:, column] = (((turned[-1].internal[-1] - probe) / size - miss) / PROBE)[moving]
    step = miss * size
    step[moving] = size[moving] * np.clip(np.linalg.lstsq(matrix, -miss[moving], rcond=1e-9)[0], -0.5, 0.5)
    return step


def _cycle(turned: list[_Stretch], closure: float) -> Cycle:
    energy = sum(stretch.energy for stretch in turned)
    magnitude = sum(stretch.magnitude for stretch in turned)
    return Cycle(
        time=np.concatenate([stretch.time for stretch in turned]),
        velocity=np.concatenate([np.full(len(stretch.time), stretch.velocity) for stretch in turned]),
        force=np.concatenate([stretch.force for stretch in turned]),
        internal=np.concatenate([stretch.internal for stretch in turned]),
        energy=energy,
        share=energy / magnitude if magnitude > 0.0 else 0.0,
        closure=closure,
    )
