"""Newton shooting: from a state near a steady motion to the periodic solution itself, stable or not."""

import dataclasses

import numpy as np

from vibrocap.motion.recording.section import brought_back, winding
from vibrocap.orbits.closing.periodic_solution import OrbitStatus, PeriodicSolution, floquet_multipliers, judged
from vibrocap.orbits.maps.differences import contradicted
from vibrocap.orbits.maps.stroboscopic_map import Images, StroboscopicMap, named_states, state_vector

CLOSED = 1e-11  # residual at which an orbit is closed; Newton continues while it pays
ROUNDING = 1e-9  # residual that counts as closed where no step of Newton's method makes it smaller
MOST_STEPS = 25
LONGEST_STRIDE = 1.0  # of a Newton step, in natural sizes of a state
SAME_STATE = 1e-7  # distance over natural sizes within which an image of a closed state is that state


@dataclasses.dataclass
class _Try:
    """A state of Newton's method: where it is, what the map makes of it, and by how much it does not close."""

    state: np.ndarray
    image: np.ndarray
    jacobian: np.ndarray
    mismatch: np.ndarray  # over natural sizes
    residual: float
    finished: bool
    certified: bool


def closed(map_: StroboscopicMap, state: np.ndarray, response_period: int = 1, half: bool = False) -> PeriodicSolution:
    """The periodic solution near a state [states], by Newton's method on the stroboscopic map P over n drive periods.

        y without its cyclic coordinate:   P^n(y) = y,      or with `half` (n odd)   (S P_(T/2))^n (y) = y

    modulo whole turns. The fixed points of the second are exactly the symmetric orbits, also unstable ones among pairs
    of mirror twins. The velocity of a contact that sticks at the section is left out too. Derivatives come from the
    variational equations, through events. Steps are halved while they do not reduce the mismatch. A few runs beside the
    orbit have to agree with its derivative; where they contradict it, nothing is said of its stability.
    """
    state = brought_back(map_.system, state)
    closure = _Closure(map_, map_.parameters(), response_period, half)
    best, steps = closure.attempt(state), 0
    while best.finished and steps < MOST_STEPS and best.residual > 1e-3 * CLOSED:
        following = _newton_step(closure, best)
        if following is None:
            break
        best, steps = following, steps + 1
    status = OrbitStatus.CONVERGED if best.residual <= ROUNDING else OrbitStatus.NOT_CONVERGED
    return _solution(closure, best, status, steps)


def unclosed(map_: StroboscopicMap, state: np.ndarray, response_period: int, status: OrbitStatus) -> PeriodicSolution:
    """The record of a state as it is, without a step towards closing, under the status given."""
    closure = _Closure(map_, map_.parameters(), response_period, False)
    return _solution(closure, closure.attempt(state), status, 0)


def shortest(map_: StroboscopicMap, found: PeriodicSolution) -> PeriodicSolution:
    """The same solution over its shortest period: a motion that settles by turns may look longer than it is."""
    state = state_vector(found.system, found.state)
    for periods in range(1, found.response_period):
        divides = found.response_period % periods == 0 and found.closes
        if divides and unclosed(map_, state, periods, found.status).residual <= SAME_STATE:
            return closed(map_, state, periods)
    return found


@dataclasses.dataclass(frozen=True)
class _Closure:
    """What shall vanish: the mismatch of a state and its image, over natural sizes."""

    map_: StroboscopicMap
    parameters: np.ndarray
    response_period: int
    half: bool

    @property
    def scales(self) -> np.ndarray:
        return self.map_.scales(self.parameters)

    @property
    def kept(self) -> np.ndarray:
        """Which states count: all but the cyclic one."""
        return np.isin(np.arange(self.map_.states), self.map_.section_states)

    def attempt(self, state: np.ndarray) -> _Try:
        found = mapped(self.map_, state, self.parameters, self.response_period, self.half)
        image = found.state[0]
        mismatch = np.where(self.kept, self.map_.away(image, state) / self.scales, 0.0)
        residual = float(np.max(np.abs(mismatch)))
        finished = bool(found.finished[0]) and bool(np.isfinite(residual))
        assert found.jacobian is not None
        good = bool(found.certified[0])
        return _Try(state, image, found.jacobian[0], mismatch, residual if finished else np.inf, finished, good)


def mapped(
    map_: StroboscopicMap, state: np.ndarray, parameters: np.ndarray, response_period: int, half: bool
) -> Images:
    """Image and derivative over the whole response, or over the half of it with the mirror."""
    if not half:
        return map_.images(state[None], parameters[None], response_period)
    total, finished, good = np.eye(map_.states), True, True
    here = state[None]
    for _ in range(response_period):
        found = map_.mirrored_half(here, parameters[None])
        assert found.jacobian is not None
        here, total, finished = found.state, found.jacobian[0] @ total, finished and bool(found.finished[0])
        good = good and bool(found.certified[0])
    return Images(here, total[None], np.array([finished]), np.array([good]))


def _newton_step(closure: _Closure, best: _Try) -> _Try | None:
    """The next state, less mismatched than the last; None where no step along Newton's direction is."""
    map_, scales = closure.map_, closure.scales
    still = [place for place in map_.resting if best.image[place] == 0.0 and best.state[place] != 0.0]
    if still:
        stuck = best.state.copy()
        stuck[still] = 0.0
        return closure.attempt(stuck)  # contacts stick at the section: their velocities are no unknowns any more
    free = map_.free(best.state[None], map_.parameters()[None])[0] | np.any(best.jacobian != 0.0, axis=0)
    unknown = np.flatnonzero(closure.kept & free)
    if not unknown.size:
        return None  # the drive alone says where all contacts are
    size = scales[unknown]
    slope = best.jacobian[np.ix_(unknown, unknown)] * size / size[:, None] - np.eye(len(unknown))
    step = np.linalg.lstsq(slope, -best.mismatch[unknown], rcond=1e-13)[0]
    step *= min(1.0, LONGEST_STRIDE / max(float(np.max(np.abs(step))), 1e-300))
    share = 1.0
    for _ in range(12):
        state = best.state.copy()
        state[unknown] += share * step * size
        found = closure.attempt(state)
        if found.finished and found.residual < best.residual:
            return found
        if best.residual <= CLOSED:
            return None
        share *= 0.5
    return None


def _solution(closure: _Closure, found: _Try, status: OrbitStatus, steps: int) -> PeriodicSolution:
    """The record of a solution, with its whole map, its multipliers and its mirror image."""
    map_, parameters, response_period = closure.map_, closure.parameters, closure.response_period
    system = map_.system
    whole = map_.images(found.state[None], parameters[None], response_period)
    assert whole.jacobian is not None
    if status is OrbitStatus.CONVERGED and contradicted(map_, found.state, whole, parameters, response_period):
        status = OrbitStatus.CONTRADICTED
    symmetric, twin = None, None
    if system.mirrored:
        # With tangents that nobody asks for: the kernel that has them is compiled, one without them may not be.
        image = map_.mirrored_half(found.state[None], parameters[None]).state[0]
        symmetric = closure.half
        if not symmetric and response_period % 2 == 1:
            away = map_.away(mapped(map_, found.state, parameters, response_period, True).state[0], found.state)
            symmetric = bool(np.max(np.abs(away / closure.scales)[closure.kept]) <= SAME_STATE)
        twin = named_states(system, brought_back(system, image))
    gained, drift = whole.state[0] - found.state, None
    if map_.cyclic >= 0:
        drift = 0.0 if symmetric else float(gained[map_.cyclic])
    solution = PeriodicSolution(
        system=system,
        state=named_states(system, found.state),
        period=response_period * map_.period(parameters),
        response_period=response_period,
        drift=drift,
        multipliers=floquet_multipliers(map_, whole.jacobian[0]),
        residual=found.residual,
        symmetric=symmetric,
        derivative=whole.jacobian[0],
        status=status if found.finished else OrbitStatus.RUN_FAILED,
        iterations=steps,
        tolerance=map_.tolerance,
        mirrored_state=twin,
        winding=winding(system, gained),
    )
    return solution if found.certified else judged(solution)
