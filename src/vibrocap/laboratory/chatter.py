"""The worst that a velocity can do which switches so quickly that the internal states stand still.

At a frozen internal state z, shares tau_i of the time at velocities v_i keep it there if sum tau_i z'(v_i, z) = 0, and
the contact takes the mean power sum tau_i R(v_i, z) v_i. If that can be negative, the law creates energy: the limit of
real cycles of ever shorter period. The shares solve a linear programme.

With one internal state this is all there is to know: any cycle passes every z as often up as down, so the energy of a
cycle is a sum of such pairs (necessary and sufficient; for LuGre the theorem of Barabanov and Ortega 2000, that
delta2 >= delta1 (eta_s - eta_c)/eta_c is necessary too, comes out). With more it is only one way of creating energy.
"""

import dataclasses

import numpy as np

from vibrocap.laboratory.recorded_law import RecordedLaw

ROUNDING = 1e-9  # a share of energy nearer to zero than this is zero


@dataclasses.dataclass(frozen=True, eq=False)
class Chatter:
    """Velocities between which to switch at one internal state, with their shares of time.

    share: mean of R v over mean of |R v|, in [-1, 1]
    """

    state: np.ndarray  # [states]
    levels: np.ndarray  # [levels]
    shares: np.ndarray  # [levels]
    share: float

    @property
    def fastest(self) -> float:
        """Largest speed."""
        return float(np.max(np.abs(self.levels)))


@dataclasses.dataclass(frozen=True, eq=False)
class Powers:
    """Power R v [velocities, n] and rates [continuous states, velocities, n] at velocities and frozen states [n]."""

    velocities: np.ndarray
    states: np.ndarray  # [states, n]
    power: np.ndarray
    rates: np.ndarray

    def within(self, slowest: float, fastest: float) -> "Powers":
        """The same with speeds between these only."""
        kept = (np.abs(self.velocities) >= slowest) & (np.abs(self.velocities) <= fastest)
        return Powers(self.velocities[kept], self.states, self.power[kept], self.rates[:, kept])


def powers(recorded: RecordedLaw, states: np.ndarray, sides: np.ndarray, speeds: np.ndarray) -> Powers:
    """Power and rates at all speeds [n], forward and backward, at states [states, m] visited on sides [m]."""
    power, rates = [], []
    for side in (-1.0, 1.0):
        velocity = (side * (speeds[::-1] if side < 0 else speeds))[:, None]
        turned = recorded.turned(states, sides, side)[:, None, :]
        settled = recorded.settled_pieces(velocity, turned, side)
        force, *rate = recorded.values((recorded.force, *recorded.rates), velocity, settled, side)
        power.append(force * velocity)
        rates.append(np.array([rate[i] for i in recorded.continuous]).reshape(-1, *force.shape))
    velocities = np.concatenate((-speeds[::-1], speeds))
    power, rates = np.concatenate(power), np.concatenate(rates, axis=1)
    bad = ~(np.isfinite(power) & np.all(np.isfinite(rates), axis=0))
    return Powers(velocities, states, np.where(bad, np.inf, power), np.where(bad, 0.0, rates))


def worst_chatter(found: Powers, sizes: np.ndarray) -> Chatter | None:
    """The chatter with the least share of energy, None where none is negative.

    sizes [continuous states]: natural sizes, over which rates are compared
    """
    if len(found.rates) == 0:
        return _constant(found)
    if len(found.rates) == 1:
        return _pair(found)
    return _programme(found, sizes)


def _constant(found: Powers) -> Chatter | None:
    """Without internal states: the velocity at which the contact gives most power."""
    i, j = np.unravel_index(int(np.argmin(found.power)), found.power.shape)
    if not found.power[i, j] < 0.0:
        return None
    return Chatter(found.states[:, j], found.velocities[i : i + 1], np.ones(1), -1.0)


def _pair(found: Powers) -> Chatter | None:
    """With one: at each state, the least power per rate upward and the least per rate downward together."""
    rate = found.rates[0]
    with np.errstate(divide="ignore", invalid="ignore"):
        cost = found.power / np.abs(rate)
    up, down = np.where(rate > 0.0, cost, np.inf), np.where(rate < 0.0, cost, np.inf)
    i, j = np.argmin(up, axis=0), np.argmin(down, axis=0)
    every = np.arange(rate.shape[1])
    least_up, least_down = up[i, every], down[j, every]
    usable = np.isfinite(least_up) & np.isfinite(least_down)
    with np.errstate(invalid="ignore", divide="ignore"):
        share = np.where(usable, (least_up + least_down) / (np.abs(least_up) + np.abs(least_down)), np.inf)
    n = int(np.argmin(share))
    if not share[n] < -ROUNDING:
        return None
    chosen = np.array([i[n], j[n]])
    shares = 1.0 / np.abs(rate[chosen, n])
    return Chatter(found.states[:, n], found.velocities[chosen], shares / shares.sum(), float(share[n]))


def _programme(found: Powers, sizes: np.ndarray) -> Chatter | None:
    """With several: a linear programme at each state, for the shares times the mean of |R v|."""
    from scipy.optimize import linprog

    best = None
    for n in range(found.power.shape[1]):
        usable = np.flatnonzero(np.isfinite(found.power[:, n]))
        power, rates = found.power[usable, n], found.rates[:, usable, n] / sizes[:, None]
        size = np.abs(power) + np.abs(rates).sum(axis=0) + 1e-300
        if not np.any(power < 0.0):
            continue
        conditions = np.vstack((rates / size, np.abs(power) / size))
        right = np.append(np.zeros(len(rates)), 1.0)
        done = linprog(power / size, A_eq=conditions, b_eq=right, method="highs")
        if done.status == 0 and done.fun < -1e3 * ROUNDING and (best is None or done.fun < best.share):
            used = done.x > 1e-12 * done.x.max()
            shares = done.x[used] / size[used]
            best = Chatter(found.states[:, n], found.velocities[usable[used]], shares / shares.sum(), float(done.fun))
    return best


def least_speed(found: Powers, sizes: np.ndarray, worst: Chatter) -> float:
    """Least bound of the speed within which a chatter still creates energy, to the spacing of the velocities."""
    speeds = np.unique(np.abs(found.velocities))
    if len(found.rates) > 1:  # one state tells enough, and a programme takes its time
        here = np.flatnonzero(np.all(found.states == worst.state[:, None], axis=0))[:1]
        found = Powers(found.velocities, found.states[:, here], found.power[:, here], found.rates[:, :, here])
    low, high = -1, int(np.searchsorted(speeds, worst.fastest))
    while high - low > 1:
        middle = (low + high) // 2
        if worst_chatter(found.within(0.0, speeds[middle]), sizes) is None:
            low = middle
        else:
            high = middle
    return float(speeds[high])
