"""A Numba scalar loop on the named sweeps: what a good engineer writes in an afternoon.

One motion after another: Tsit5 (Tsitouras 2011) with an adaptive step, first-same-as-last; the mode ends where the
watched quantity (velocity to the side of sliding, or force to spare while stuck) turns negative in a step. The root is
found on the free interpolant of the pair, polished by a secant on steps done anew, and the motion restarts there in its
new mode. With two threads `prange` shares the runs out in chunks.

Or, with LuGre, as it is usually written: |v| in the equations and nothing located.

20 and 48 microseconds per trajectory and drive period (exponential, LuGre) on a shared x86-64 server with AVX-512.
Without the secant the interpolant's own error decides with the exponential law: 26 microseconds, and 99 % of the errors
were below 1.0e-6 to 1.8e-6 at tolerances from 8e-9 to 1.2e-8; at 1e-8 they are now below 8.2e-8.
"""

import math
from collections.abc import Callable

import numba
import numpy as np

from benchmarks.named_sweeps import END, INITIAL, SWEEP_SET

TOLERANCE = {"exponential": 1e-7, "lugre": 9e-9}
PLAIN_TOLERANCE = 5e-11
CHUNK = 8
CLOSE = 1e-10
MOST_STEPS = 2_000_000

# Plain numbers of this module are constants to the compiler.
STIFFNESS, DAMPING, LOAD = SWEEP_SET.stiffness, SWEEP_SET.damping, SWEEP_SET.normal_load
AMPLITUDE, FREQUENCY = SWEEP_SET.amplitude, SWEEP_SET.frequency
COULOMB, STATIC, DECAY = SWEEP_SET.coulomb_coefficient, SWEEP_SET.static_coefficient, SWEEP_SET.decay_rate
DROP, LIMIT = STATIC - COULOMB, LOAD * STATIC
DELTA0, DELTA1, DELTA2 = SWEEP_SET.bristle_stiffness, SWEEP_SET.bristle_damping, SWEEP_SET.viscous_damping
STRIBECK = SWEEP_SET.stribeck_velocity  # its exponent is 2

# Tsit5: nodes, coefficients, weights of the error estimate.
C2, C3, C4, C5 = 0.161, 0.327, 0.9, 0.9800255409045097
A21 = 0.161
A31, A32 = -0.008480655492356989, 0.335480655492357
A41, A42, A43 = 2.8971530571054935, -6.359448489975075, 4.3622954328695815
A51, A52, A53, A54 = 5.325864828439257, -11.748883564062828, 7.4955393428898365, -0.09249506636175525
A61, A62, A63, A64, A65 = (
    5.86145544294642,
    -12.92096931784711,
    8.159367898576159,
    -0.071584973281401,
    -0.028269050394068383,
)
B1, B2, B3 = 0.09646076681806523, 0.01, 0.4798896504144996
B4, B5, B6 = 1.379008574103742, -3.290069515436081, 2.324710524099774
E1, E2, E3 = -0.00178001105222577714, -0.0008164344596567469, 0.007880878010261995
E4, E5, E6, E7 = -0.1447110071732629, 0.5823571654525552, -0.45808210592918697, 1.0 / 66.0


@numba.njit(fastmath=True, inline="always")
def holding_force(t, y):
    """The friction force that keeps a resting capsule at rest."""
    sine, cosine = math.sin(y[0]), math.cos(y[0])
    moment = AMPLITUDE * math.cos(FREQUENCY * t) + sine - STIFFNESS * y[0] - DAMPING * y[1]
    return cosine * moment - sine * y[1] * y[1]


@numba.njit(fastmath=True)
def exponential_rates(t, y, side, mass_ratio, rates):
    """Equations (9) with (8); side 0 is the stuck capsule."""
    sine, cosine = math.sin(y[0]), math.cos(y[0])
    moment = AMPLITUDE * math.cos(FREQUENCY * t) + sine - STIFFNESS * y[0] - DAMPING * y[1]
    rates[0] = y[1]
    if side == 0.0:
        rates[1], rates[2], rates[3] = moment, 0.0, 0.0
        return
    force = side * LOAD * (COULOMB + DROP * math.exp(-DECAY * side * y[3]))
    push = (cosine * moment - sine * y[1] * y[1] - force) / (mass_ratio + 1.0 - cosine * cosine)
    rates[1], rates[2], rates[3] = moment + cosine * push, y[3], push


@numba.njit(fastmath=True)
def lugre_rates(t, y, side, mass_ratio, rates):
    """Equations (9) with (6), (7), (10)."""
    sine, cosine = math.sin(y[0]), math.cos(y[0])
    moment = AMPLITUDE * math.cos(FREQUENCY * t) + sine - STIFFNESS * y[0] - DAMPING * y[1]
    speed = abs(y[3]) if side == 0.0 else side * y[3]  # side 0: as written, reversals not located
    ratio = y[3] / STRIBECK
    level = LOAD / DELTA0 * (COULOMB + DROP * math.exp(-ratio * ratio))
    bristle_rate = y[3] - speed * y[4] / level
    force = DELTA0 * y[4] + DELTA1 * bristle_rate + DELTA2 * y[3]
    push = (cosine * moment - sine * y[1] * y[1] - force) / (mass_ratio + 1.0 - cosine * cosine)
    rates[0], rates[1], rates[2], rates[3], rates[4] = y[1], moment + cosine * push, y[3], push, bristle_rate


@numba.njit(fastmath=True)
def interpolated(s, h, y, k, i):
    """State i a fraction s into the step, by the free interpolant of the pair."""
    b1 = -1.0530884977290216 * s * (s - 1.3299890189751412) * (s * s - 1.4364028541716351 * s + 0.7139816917074209)
    b2 = 0.1017 * s * s * (s * s - 2.1966568338249754 * s + 1.2949852507374631)
    b3 = 2.490627285651252793 * s * s * (s * s - 2.38535645472061657 * s + 1.57803468208092486)
    b4 = -16.54810288924490272 * (s - 1.21712927295533244) * (s - 0.61620406037800089) * s * s
    b5 = 47.37952196281928122 * (s - 1.203071208372362603) * (s - 0.658047292653547382) * s * s
    b6 = -34.87065786149660974 * (s - 1.2) * (s - 0.666666666666666667) * s * s
    b7 = 2.5 * (s - 1.0) * (s - 0.6) * s * s
    slope = b1 * k[0, i] + b2 * k[1, i] + b3 * k[2, i] + b4 * k[3, i] + b5 * k[4, i] + b6 * k[5, i] + b7 * k[6, i]
    return y[i] + h * slope


def _motion(law: str, located: bool):
    """The compiled loop of one law: runs one motion and writes its final state."""
    states, bristles = len(INITIAL[law]), law == "lugre"
    rates = lugre_rates if bristles else exponential_rates
    initial = INITIAL[law]

    @numba.njit(fastmath=True)
    def tried(t, h, y, side, mass_ratio, k, work, new):
        """One step of Tsit5 from y (slope k[0] known) to `new`; slopes in k, returns the error in units of h."""
        for i in range(states):
            work[i] = y[i] + h * A21 * k[0, i]
        rates(t + C2 * h, work, side, mass_ratio, k[1])
        for i in range(states):
            work[i] = y[i] + h * (A31 * k[0, i] + A32 * k[1, i])
        rates(t + C3 * h, work, side, mass_ratio, k[2])
        for i in range(states):
            work[i] = y[i] + h * (A41 * k[0, i] + A42 * k[1, i] + A43 * k[2, i])
        rates(t + C4 * h, work, side, mass_ratio, k[3])
        for i in range(states):
            work[i] = y[i] + h * (A51 * k[0, i] + A52 * k[1, i] + A53 * k[2, i] + A54 * k[3, i])
        rates(t + C5 * h, work, side, mass_ratio, k[4])
        for i in range(states):
            slope = A61 * k[0, i] + A62 * k[1, i] + A63 * k[2, i] + A64 * k[3, i] + A65 * k[4, i]
            work[i] = y[i] + h * slope
        rates(t + h, work, side, mass_ratio, k[5])
        for i in range(states):
            slope = B1 * k[0, i] + B2 * k[1, i] + B3 * k[2, i] + B4 * k[3, i] + B5 * k[4, i] + B6 * k[5, i]
            new[i] = y[i] + h * slope
        rates(t + h, new, side, mass_ratio, k[6])

    @numba.njit(fastmath=True)
    def watched(t, y, side):
        """Positive within the mode."""
        if not located:
            return 1.0
        if side == 0.0:
            return LIMIT - abs(holding_force(t, y))
        return side * y[3]

    @numba.njit(fastmath=True)
    def mode_at_rest(t, y, k, may_stick):
        """The side to which a capsule of zero velocity goes on, 0: it sticks."""
        needed = holding_force(t, y)
        if bristles:
            needed -= DELTA0 * y[4]
        elif may_stick and abs(needed) < LIMIT:
            return 0.0
        return 1.0 if needed > 0.0 else -1.0

    @numba.njit(fastmath=True)
    def root(t, h, y, k, side, before, after, work):
        """The fraction of the step at which the mode ends: regula falsi (Illinois) on the interpolant."""
        low, high = 0.0, 1.0
        for _ in range(60):
            s = (low * after - high * before) / (after - before)
            for i in range(4):
                work[i] = interpolated(s, h, y, k, i)
            value = watched(t + s * h, work, side)
            if abs(value) < 1e-13 or high - low < 1e-13:
                break
            if value > 0.0:
                low, before, after = s, value, 0.5 * after
            else:
                high, after, before = s, value, 0.5 * before
        return s

    @numba.njit(fastmath=True, nogil=True)
    def motion(mass_ratio, tolerance, final):
        y, new, work, k = np.array(initial), np.empty(states), np.empty(states), np.empty((7, states))
        t, h, old_error = 0.0, 1e-3, 1e-4
        side = mode_at_rest(t, y, k, True) if located else 0.0
        rates(t, y, side, mass_ratio, k[0])
        margin = watched(t, y, side)
        for _ in range(MOST_STEPS):
            last = t + h >= END
            step = END - t if last else h
            tried(t, step, y, side, mass_ratio, k, work, new)
            error = 0.0
            for i in range(states):
                slope = E1 * k[0, i] + E2 * k[1, i] + E3 * k[2, i] + E4 * k[3, i] + E5 * k[4, i] + E6 * k[5, i]
                scale = tolerance * (1.0 + max(abs(y[i]), abs(new[i])))
                error = max(error, abs(step * (slope + E7 * k[6, i])) / scale)
            if not error <= 1.0:
                h = step * max(0.2, 0.9 * error**-0.2) if error < 1e10 else 0.2 * step
                continue
            error = max(error, 1e-4)
            if not last:
                h = step * min(5.0, max(0.2, 0.9 * error**-0.17 * old_error**0.04))
            old_error = error
            ahead = watched(t + step, new, side)
            if ahead < 0.0 and margin <= 0.0 and step > 1e-9:
                h = 0.5 * step  # the mode has just begun; what ended it again lies within this step
                continue
            if ahead < 0.0 and margin > 0.0:
                # The interpolant is less exact than a step: its root, then a secant on steps done anew.
                part = root(t, step, y, k, side, margin, ahead, work) * step
                other, other_margin = step, ahead
                for _ in range(8):
                    tried(t, part, y, side, mass_ratio, k, work, new)
                    found = watched(t + part, new, side)
                    if abs(found) < CLOSE or found == other_margin:
                        break
                    better = part - found * (part - other) / (found - other_margin)
                    other, other_margin, part = part, found, better
                t += part
                for i in range(states):
                    y[i] = new[i]
                y[3] = 0.0
                side = -side if bristles else mode_at_rest(t, y, k, side != 0.0)
                rates(t, y, side, mass_ratio, k[0])
                margin = 0.0
                continue
            t += step
            margin = ahead
            for i in range(states):
                y[i], k[0, i] = new[i], k[6, i]
            if last:
                final[:] = y
                return
        final[:] = np.nan

    return motion


def prepare_sweep(
    law: str, masses: np.ndarray, threads: int = 1, tolerance: float | None = None
) -> Callable[[], np.ndarray]:
    """Compiles; returns a function that runs the sweep and returns its final states [runs, states]."""
    return _prepared(_motion(law, located=True), law, masses, threads, tolerance or TOLERANCE[law])


def prepare_plain_sweep(
    law: str, masses: np.ndarray, threads: int = 1, tolerance: float | None = None
) -> Callable[[], np.ndarray] | None:
    """The same with |v| as it is written: no reversal is located, the step control gets over each by small steps.

    Only for LuGre: with the exponential law there is no such loop, as its force at rest is a set.
    """
    if law != "lugre":
        return None
    return _prepared(_motion(law, located=False), law, masses, threads, tolerance or PLAIN_TOLERANCE)


def _prepared(motion, law: str, masses: np.ndarray, threads: int, accuracy: float) -> Callable[[], np.ndarray]:
    final = np.empty((len(masses), len(INITIAL[law])))

    @numba.njit(parallel=threads > 1)
    def sweep(masses, accuracy, final):
        for run in numba.prange(len(masses)):
            motion(masses[run], accuracy, final[run])

    def run() -> np.ndarray:
        if threads > 1:
            numba.set_num_threads(threads)
            numba.set_parallel_chunksize(CHUNK)
        sweep(masses, accuracy, final, periods=60, tolerance=1e-8, settle=0)
        return final.copy()

    sweep(masses[:1], accuracy, final, periods=60, tolerance=1e-8, settle=0)
    return run
