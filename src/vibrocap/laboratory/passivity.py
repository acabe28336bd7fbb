"""Whether a friction law can create energy with given parameters, and a cycle that shows it.

Chatter is a velocity that switches so quickly that the internal states stand still. At a frozen internal state z,
shares tau_i of the time at velocities v_i keep it there if sum tau_i z'(v_i, z) = 0, and the contact takes the mean
power sum tau_i R(v_i, z) v_i. If that can be negative (a linear programme), the law creates energy.

With one internal state this is all there is to know: any cycle passes every z as often up as down, so the energy of a
cycle is a sum of such pairs (necessary and sufficient; for LuGre the theorem of Barabanov and Ortega 2000, that
delta2 >= delta1 (eta_s - eta_c)/eta_c is necessary too, comes out). With more it is only one way of creating energy.
"""

import bisect
import dataclasses
import inspect
import math
from typing import Literal

import numpy as np

from vibrocap.laboratory.contact_sizes import speed_scale
from vibrocap.laboratory.cycle import Cycle, closed_cycle, searched_cycle
from vibrocap.laboratory.driven import check_numbers
from vibrocap.laboratory.recorded_law import RecordedLaw, recorded_law, visited_states
from vibrocap.physics.friction.law import Law

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


def worst_chatter(table: Powers, sizes: np.ndarray) -> Chatter | None:
    """The chatter with the least share of energy, None where none is negative.

    sizes [continuous states]: natural sizes, over which rates are compared
    """
    if len(table.rates) == 0:
        return _constant(table)
    if len(table.rates) == 1:
        return _pair(table)
    return _programme(table, sizes)


def _constant(table: Powers) -> Chatter | None:
    """Without internal states: the velocity at which the contact gives most power."""
    i, j = np.unravel_index(int(np.argmin(table.power)), table.power.shape)
    if not table.power[i, j] < 0.0:
        return None
    return Chatter(table.states[:, j], table.velocities[i : i + 1], np.ones(1), -1.0)


def _pair(table: Powers) -> Chatter | None:
    """With one: at each state, the least power per rate upward and the least per rate downward together."""
    rate = table.rates[0]
    with np.errstate(divide="ignore", invalid="ignore"):
        cost = table.power / np.abs(rate)
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
    picked = np.array([i[n], j[n]])
    shares = 1.0 / np.abs(rate[picked, n])
    return Chatter(table.states[:, n], table.velocities[picked], shares / shares.sum(), float(share[n]))


def _programme(table: Powers, sizes: np.ndarray) -> Chatter | None:
    """With several: a linear programme at each state, for the shares times the mean of |R v|."""
    from scipy.optimize import linprog

    best = None
    for n in range(table.power.shape[1]):
        usable = np.flatnonzero(np.isfinite(table.power[:, n]))
        power, rates = table.power[usable, n], table.rates[:, usable, n] / sizes[:, None]
        size = np.abs(power) + np.abs(rates).sum(axis=0) + 1e-300
        if not np.any(power < 0.0):
            continue
        conditions = np.vstack((rates / size, np.abs(power) / size))
        right = np.append(np.zeros(len(rates)), 1.0)
        done = linprog(power / size, A_eq=conditions, b_eq=right, method="highs")
        if done.status == 0 and done.fun < -1e3 * ROUNDING and (best is None or done.fun < best.share):
            used = done.x > 1e-12 * done.x.max()
            shares = done.x[used] / size[used]
            best = Chatter(table.states[:, n], table.velocities[usable[used]], shares / shares.sum(), float(done.fun))
    return best


def least_speed(table: Powers, sizes: np.ndarray, worst: Chatter) -> float:
    """Least bound of the speed within which a chatter still creates energy, to the spacing of the velocities."""
    speeds = np.unique(np.abs(table.velocities))
    if len(table.rates) > 1:  # one state tells enough, and a programme takes its time
        here = np.flatnonzero(np.all(table.states == worst.state[:, None], axis=0))[:1]
        table = Powers(table.velocities, table.states[:, here], table.power[:, here], table.rates[:, :, here])

    def creates(k: int) -> bool:
        return worst_chatter(table.within(0.0, speeds[k]), sizes) is not None

    slower = range(int(np.searchsorted(speeds, worst.fastest)))
    return float(speeds[bisect.bisect_left(slower, True, key=creates)])


Verdict = Literal["passive, proven", "creates energy: cycle found", "no cycle found, not proven"]
DECADES = 4.0  # of speed, above and below the law's own, that are searched
PER_DECADE = 60
STATES, MANY = 201, 120  # internal states to look at, one or several
SHOWN = 2.0  # times the least speed that is needed: the bound of the cycle that is shown
SWING = 0.01  # of the natural size, the first choice for how far an internal state moves during a cycle
KEPT = 0.9  # share of the chatter's energy that a slower cycle should keep
COUNTS = 1e-6  # a share of energy of a cycle nearer to zero than this proves nothing


@dataclasses.dataclass(frozen=True)
class LeastLoss:
    """Where the law loses least power (or gains most) by its own storage function: R v less the rate of stored energy.

    rate: of loss, negative where the stored energy grows by more than is put in
    velocity, internal: there
    """

    rate: float
    velocity: float
    internal: tuple[float, ...]


@dataclasses.dataclass(frozen=True, eq=False)
class Passivity:
    """Whether a law can create energy.

    verdict: what is known
    condition: the law's own sufficient condition, in its words, and whether it holds with these parameters
    cycle: a cycle that gives more energy than it takes, or None
    speed_needed: the least bound of the speed within which chatter creates energy (to 1 %), None where it does not
    fastest: speeds up to here were searched
    least_loss: of the natural storage function, over the internal states visited, at speeds up to that of the cycle
    searched: what was looked through, in words
    """

    law: Law
    load: float
    verdict: Verdict
    condition: str
    cycle: Cycle | None
    speed_needed: float | None
    fastest: float
    least_loss: LeastLoss
    searched: str

    @property
    def text(self) -> str:
        """The report in words."""
        words, loss = f"{self.law.name}: {self.verdict}. {self.condition}", self.least_loss
        if self.cycle is not None:
            words += f" A cycle of period {self.cycle.period:.3g} with speeds up to {self.cycle.fastest:.3g} gives "
            words += f"{-self.cycle.energy:.3g} each time, {-100 * self.cycle.share:.3g} % of the power exchanged."
        if self.speed_needed is not None:
            words += f" Below a speed of {self.speed_needed:.3g} none was found."
        if loss.rate < 0.0:
            words += f" The loss by its own stored energy falls to {loss.rate:.3g}, at velocity {loss.velocity:.3g}."
        return f"{words} Searched: {self.searched}."


def passivity(law: Law, load: float = 1.0, *, fastest: float | None = None) -> Passivity:
    """Whether a law can create energy with these parameters.

    A contact is passive if no cycle that ends as it began (internal states included) gives energy: the integral of R v
    over it is never negative. Where the law is not proven passive, a cycle that gives energy is sought, first among
    velocities that switch infinitely fast (chatter; with one internal state that decides), then, for laws with several
    internal states or with pieces, among cycles of a few levels. It is made one of finite period and measured.

    fastest: the largest speed that the contact meets; by default four decades above the law's own speed. The worst
        cycle within it is returned; by default the one within twice the least speed needed.
    Raises ValueError for a load or a speed that is no positive number.
    """
    recorded = recorded_law(law, load)
    if fastest is not None:
        check_numbers(fastest=fastest)
    scale = speed_scale(law)
    top = float(fastest) if fastest is not None else scale * 10.0**DECADES
    bottom = min(scale, top) * 10.0**-DECADES
    speeds = np.geomspace(bottom, top, 1 + math.ceil(PER_DECADE * math.log10(top / bottom)))
    states, sides, sizes = _states(recorded, speeds)
    worst_powers = powers(recorded, states, sides, speeds)
    continuous = sizes[recorded.continuous]
    proven = type(law).passive is not Law.passive and law.passive  # one that says nothing is not proven
    cycle = needed = None
    verdict: Verdict = "passive, proven"
    if not proven:
        worst = worst_chatter(worst_powers, continuous)
        if worst is not None:
            needed = _speed_needed(recorded, worst_powers, continuous, worst, sides)
            bound = top if fastest is not None else SHOWN * needed
            cycle = _real_cycle(recorded, _brisk(worst_powers, bound, continuous) or worst, sizes)
        if cycle is None and (len(recorded.continuous) > 1 or law.switched):
            slow = min(10.0 * scale, top) if fastest is None else top
            cycle = _measured(closed_cycle(recorded, *searched_cycle(recorded, bottom, slow, sizes), sizes))
            needed = None
        verdict = "creates energy: cycle found" if cycle is not None else "no cycle found, not proven"
    return Passivity(
        law=law,
        load=float(load),
        verdict=verdict,
        condition=_condition(law),
        cycle=cycle,
        speed_needed=needed if cycle is not None else None,
        fastest=top,
        least_loss=_least_loss(recorded, states, sides, speeds[speeds <= 1.001 * (cycle.fastest if cycle else top)]),
        searched=_searched(recorded, bottom, top) if not proven else "nothing, for there is a proof",
    )


def _states(recorded: RecordedLaw, speeds: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(states [states, n] to look at, side [n] of each, natural sizes [states])."""
    if not recorded.rates:
        return np.empty((0, 1)), np.ones(1), np.empty(0)
    states, sides = visited_states(recorded, speeds)
    sizes = np.max(np.abs(states), axis=1)
    sizes[sizes == 0.0] = 1.0
    if len(states) == 1 and not recorded.law.switched:
        spread = np.linspace(states.min(), states.max(), STATES)[None]
        return spread, np.copysign(1.0, spread[0]), sizes
    picked = np.random.default_rng(20).choice(states.shape[1], min(MANY, states.shape[1]), replace=False)
    return states[:, picked], sides[picked], sizes


def _speed_needed(recorded: RecordedLaw, table: Powers, sizes: np.ndarray, worst: Chatter, sides: np.ndarray) -> float:
    """The least bound of the speed, first as coarsely as the speeds searched, then to 1 %."""
    coarse = least_speed(table, sizes, worst)
    slower = np.unique(np.abs(table.velocities))
    slower = slower[slower < coarse]
    between = np.geomspace(slower[-1], coarse, 6)[1:] if len(slower) else np.array([coarse])
    finer = powers(recorded, table.states, sides, np.concatenate((slower, between)))
    closer = worst_chatter(finer, sizes)
    return least_speed(finer, sizes, closer) if closer is not None else coarse


def _brisk(table: Powers, fastest: float, sizes: np.ndarray) -> Chatter | None:
    """The worst chatter within a speed, with no slower levels than it needs to keep most of its share of energy."""
    worst = worst_chatter(table.within(0.0, fastest), sizes)
    if worst is None:
        return None
    for slowest in fastest * np.geomspace(0.3, 1e-6, 23):
        brisk = worst_chatter(table.within(slowest, fastest), sizes)
        if brisk is not None and brisk.share <= KEPT * worst.share:
            return brisk
    return worst


def _real_cycle(recorded: RecordedLaw, chatter: Chatter, sizes: np.ndarray) -> Cycle | None:
    """A cycle of finite period near a chatter: the longest, by doublings, that keeps most of its share of energy."""
    levels, shares = chatter.levels, chatter.shares
    if len(recorded.rates) == 0:
        back = np.append(levels, -levels) if recorded.law.symmetric else levels
        return _measured(closed_cycle(recorded, back, np.ones(len(back)), (), ()))
    best, swing, quickest = None, SWING, 0.0
    for velocity, share in zip(levels, shares, strict=True):
        rates = recorded.values(recorded.rates, velocity, chatter.state, math.copysign(1.0, velocity))
        quickest = max(quickest, share * float(np.max(np.abs(rates) / sizes)))
    while swing < 10.0:
        period = swing / quickest if quickest > 0.0 else 1.0
        cycle = _measured(closed_cycle(recorded, levels, shares * period, chatter.state, sizes))
        if cycle is None or (best is not None and cycle.share > KEPT * chatter.share):
            break
        best, swing = cycle, 2.0 * swing
    return best


def _measured(cycle: Cycle | None) -> Cycle | None:
    """The cycle, if it gives energy for certain."""
    return cycle if cycle is not None and cycle.share < -COUNTS else None


def _least_loss(recorded: RecordedLaw, states: np.ndarray, sides: np.ndarray, speeds: np.ndarray) -> LeastLoss:
    """The least of R v less the rate of the stored energy."""
    least = LeastLoss(math.inf, math.nan, ())
    for side in (-1.0, 1.0):
        velocity = side * speeds[:, None]
        settled = recorded.settled_pieces(velocity, recorded.turned(states, sides, side)[:, None, :], side)
        force, storing = recorded.values((recorded.force, recorded.storing), velocity, settled, side)
        loss = force * velocity - storing
        loss[~np.isfinite(loss)] = math.inf
        i, j = np.unravel_index(int(np.argmin(loss)), loss.shape)
        if loss[i, j] < least.rate:
            least = LeastLoss(float(loss[i, j]), float(velocity[i, 0]), tuple(settled[:, i, j].tolist()))
    return least


def _condition(law: Law) -> str:
    """What the law says of itself."""
    words = " ".join((inspect.getdoc(type(law).passive) or "").split("\n\n")[0].split())
    if type(law).passive is Law.passive or not words:
        return "It states no condition for being passive."
    return f"Its condition {'holds' if law.passive else 'does not hold'}: {words}"


def _searched(recorded: RecordedLaw, bottom: float, top: float) -> str:
    states, speeds = len(recorded.continuous), f"speeds from {bottom:.2g} to {top:.2g}"
    if states == 0:
        return f"all {speeds}"
    if states == 1 and not recorded.law.switched:
        return f"all pairs of {speeds} at {STATES} internal states, which is exhaustive up to the spacing"
    return f"{speeds} at {MANY} visited internal states, and cycles of four levels; not exhaustive"
