"""Newton shooting: from a state near a steady motion to the periodic solution itself, stable or not."""

import dataclasses
from typing import Any

import numpy as np

from vibrocap.motion.recording.section import brought_back, winding
from vibrocap.orbits.closing.periodic_solution import OrbitStatus, PeriodicSolution, floquet_multipliers, judged
from vibrocap.orbits.maps.stroboscopic_map import (
    AGREE,
    BACKWARDS,
    Images,
    StroboscopicMap,
    named_states,
    state_vector,
)
from vibrocap.orbits.walk.residual import Levels, newton

CLOSED = Levels(1e-14, 1e-9)  # residuals over natural sizes, for Newton's method
MOST_STEPS = 25
HALVINGS = 12  # of a step
LONGEST_STRIDE = 1.0  # of a Newton step, in natural sizes of a state
CONTRADICTS = 10.0 * AGREE  # of a derivative, or of one where it is smaller
SAME_STATE = 1e-7  # distance over natural sizes within which an image of a closed state is that state


@dataclasses.dataclass(frozen=True)
class _Try:
    """A state of Newton's method, x: the states, and of a cycle its period; what the map makes of it, and the mismatch.

    mismatch: over natural sizes; images: those of this one state
    """

    closure: "Closure"
    x: np.ndarray
    image: np.ndarray
    jacobian: np.ndarray
    mismatch: np.ndarray
    residual: float
    images: Images

    @property
    def state(self) -> np.ndarray:
        return self.x[: len(self.image)]

    def step(self) -> np.ndarray | None:
        """Newton's step, which brings a contact that sticks at the section to rest; None where nothing varies."""
        closure, map_ = self.closure, self.closure.map_
        free = map_.free(self.state[None], closure.parameters[None])[0] | np.any(self.jacobian != 0.0, axis=0)
        unknown = np.flatnonzero(closure.kept & free)
        if not unknown.size:
            return None  # the drive alone says where all contacts are
        size = closure.scales[unknown]
        slope = self.jacobian[np.ix_(unknown, unknown)] * size / size[:, None] - np.eye(len(unknown))
        right = -self.mismatch[unknown]
        if closure.cycle:
            along, flow = (closure.flow(state)[unknown] / size for state in (self.image, closure.start))
            slope, right = np.block([[slope, along[:, None]], [flow, 0.0]]), np.append(right, 0.0)
        change = np.linalg.lstsq(slope, right, rcond=1e-13)[0]
        moved = change[: len(unknown)]
        share = min(1.0, LONGEST_STRIDE / max(float(np.max(np.abs(moved))), 1e-300))
        step = np.zeros(len(self.x))
        step[unknown] = share * moved * size
        step[len(self.image) :] = share * change[len(unknown) :]
        still = [place for place in map_.resting if self.image[place] == 0.0]
        step[still] = -self.x[still]
        return step


def closed(
    map_: StroboscopicMap,
    state: np.ndarray,
    response_period: int = 1,
    half: bool = False,
    period: float | None = None,
    side: Any = None,
) -> PeriodicSolution:
    """The periodic solution near a state [states], by Newton's method on the stroboscopic map P over n drive periods.

        y without its cyclic coordinate:   P^n(y) = y,      or with `half` (n odd)   (S P_(T/2))^n (y) = y

    modulo whole turns. The fixed points of the second are exactly the symmetric orbits, also unstable ones among pairs
    of mirror-image solutions. The velocity of a contact that sticks at the section is left out too. Derivatives come
    from the variational equations, through events; where a few runs beside the orbit contradict its derivative, nothing
    is said of its stability.

    period, side: a guess of the period of a cycle that nothing drives in time, and the sides of its contacts; then

        P_T(y) = y  for y and T,  y moving across the flow only:  f(y_0) . (y - y_0) = 0  (over natural sizes)
    """
    closure = Closure(map_, brought_back(map_.system, state), 0 if period else response_period, half, side)
    best, steps = closure.closed(np.append(closure.start, period or []))
    status = OrbitStatus.CONVERGED if best.residual <= CLOSED.rounding else OrbitStatus.NOT_CONVERGED
    return _solution(closure, best, status, steps)


def unclosed(map_: StroboscopicMap, state: np.ndarray, response_period: int, status: OrbitStatus) -> PeriodicSolution:
    """The record of a state as it is, without a step towards closing, under the status given."""
    closure = Closure(map_, state, response_period)
    return _solution(closure, closure.attempt(state), status, 0)


def shortest(map_: StroboscopicMap, solution: PeriodicSolution) -> PeriodicSolution:
    """The same solution over its shortest period: a motion that settles by turns may look longer than it is."""
    state = state_vector(solution.system, solution.state)
    for periods in range(1, solution.response_period):
        divides = solution.response_period % periods == 0 and solution.closes
        if divides and unclosed(map_, state, periods, solution.status).residual <= SAME_STATE:
            return closed(map_, state, periods)
    return solution


class Closure:
    """What shall vanish: the mismatch of a state and its image over natural sizes; a cycle's period is unknown too."""

    def __init__(
        self, map_: StroboscopicMap, start: np.ndarray, response_period: int, half: bool = False, side: Any = None
    ):
        """response_period: in drive periods; 0: of a cycle; side: of its contacts, amid the phase where it starts"""
        self.map_, self.start, self.response_period, self.half, self.side = map_, start, response_period, half, side
        self.shortest = 0.0  # period of a cycle
        self.parameters = map_.parameters()
        self.scales = map_.scales(self.parameters)
        self.kept = np.isin(np.arange(map_.states), map_.section_states)  # all states but the cyclic one count

    @property
    def cycle(self) -> bool:
        return self.response_period == 0

    def flow(self, state: np.ndarray) -> np.ndarray:
        """Rates of the states in the phase where a cycle starts."""
        return self.map_.rates(state, self.side, self.parameters)

    def closed(self, x: np.ndarray) -> tuple[_Try, int]:
        """(the best state that Newton's method meets, steps taken)."""
        self.shortest = 0.5 * x[-1] if self.cycle else 0.0  # towards no time every state closes by itself
        return newton(self.attempt, x, CLOSED, MOST_STEPS, halvings=HALVINGS)

    def attempt(self, x: np.ndarray) -> _Try:
        state = x[: self.map_.states]
        images = self.composed(state) if self.half else self.whole_images(x)
        image = images.state[0]
        mismatch = np.where(self.kept, self.map_.away(image, state) / self.scales, 0.0)
        residual = float(np.max(np.abs(mismatch)))
        assert images.jacobian is not None
        lasts = not self.cycle or x[-1] > self.shortest
        good = lasts and bool(images.finished[0]) and bool(np.isfinite(residual))
        return _Try(self, x, image, images.jacobian[0], mismatch, residual if good else np.inf, images)

    def length(self, x: np.ndarray) -> tuple[int, np.ndarray | None]:
        """(drive periods, length of the run in place of them) of the response."""
        return (1, x[-1:]) if self.cycle else (self.response_period, None)

    def whole_images(self, x: np.ndarray) -> Images:
        periods, length = self.length(x)
        return self.map_.images(x[None, : self.map_.states], self.parameters[None], periods, mark_distance=length)

    def half_images(self, state: np.ndarray, count: int) -> list[Images]:
        """Images of a state [states] under the half of the map with the mirror, applied once, twice, ..."""
        halves: list[Images] = []
        for _ in range(count):
            halves.append(self.map_.mirrored_half(halves[-1].state if halves else state[None], self.parameters[None]))
        return halves

    def composed(self, state: np.ndarray) -> Images:
        """Image and derivative over the half of the response with the mirror."""
        halves, total = self.half_images(state, self.response_period), np.eye(self.map_.states)
        for half in halves:
            assert half.jacobian is not None
            total = half.jacobian[0] @ total
        finished = np.all([half.finished for half in halves], axis=0)
        return Images(
            halves[-1].state, total[None], finished, lambda: np.all([half.certified for half in halves], axis=0)
        )


def _solution(closure: Closure, trial: _Try, status: OrbitStatus, steps: int) -> PeriodicSolution:
    """The record of a solution, with its whole map, its multipliers and its mirror image."""
    map_, system, response_period = closure.map_, closure.map_.system, closure.response_period
    whole = closure.whole_images(trial.x) if closure.half else trial.images
    assert whole.jacobian is not None
    beside = map_, trial.state, whole, closure.parameters, *closure.length(trial.x)
    if status is OrbitStatus.CONVERGED and contradicted(*beside):
        status = OrbitStatus.CONTRADICTED
    symmetric, twin = None, None
    if system.mirrored and not closure.cycle:
        # With tangents that nobody asks for: the kernel that has them is compiled, one without them may not be.
        asked = not closure.half and response_period % 2 == 1
        halves = closure.half_images(trial.state, response_period if asked else 1)
        away = map_.away(halves[-1].state[0], trial.state)
        symmetric = closure.half or (asked and bool(np.max(np.abs(away / closure.scales)[closure.kept]) <= SAME_STATE))
        twin = named_states(system, brought_back(system, halves[0].state[0]))
    gained, drift = whole.state[0] - trial.state, None
    if map_.cyclic >= 0:
        drift = 0.0 if symmetric else float(gained[map_.cyclic])
    solution = PeriodicSolution(
        system=system,
        state=named_states(system, trial.state),
        period=float(trial.x[-1]) if closure.cycle else response_period * map_.period(closure.parameters),
        response_period=response_period,
        drift=drift,
        multipliers=floquet_multipliers(map_, whole.jacobian[0], closure.cycle),
        residual=trial.residual,
        symmetric=symmetric,
        derivative=whole.jacobian[0],
        status=status if np.isfinite(trial.residual) else OrbitStatus.RUN_FAILED,
        iterations=steps,
        tolerance=map_.tolerance,
        mirrored_state=twin,
        winding=winding(system, gained),
    )
    return solution if closure.cycle or trial.images.certified[0] else judged(solution)


def contradicted(
    map_: StroboscopicMap,
    state: np.ndarray,
    images: Images,
    parameters: np.ndarray,
    periods: int = 1,
    mark_distance: np.ndarray | None = None,
) -> bool:
    """Whether the derivative at a state [states] is not that of the map: four runs beside it tell, in one direction.

    images: of the state, with its derivative. A direction in which all free states take part finds whatever is wrong,
    but for a set of errors of measure zero. Where the map keeps the order of motions, a negative slope contradicts it.
    """
    assert images.jacobian is not None
    sizes, free = map_.scales(parameters), map_.free(state[None], parameters[None])[0]
    direction = np.zeros(map_.states)
    moving = map_.smooth_states[free[map_.smooth_states]]
    direction[moving] = sizes[moving] * np.cos(1.0 + np.arange(len(moving)))
    slope = images.jacobian[0] @ direction / sizes
    if map_.keeps_order and slope[map_.smooth_states[0]] * direction[map_.smooth_states[0]] < BACKWARDS:
        return True
    at = state[None], direction[None], images.state, parameters[None]
    slopes, sure = map_.slopes_along(*at, periods, mark_distance)
    return bool(sure[0]) and differ(slope, slopes[0])


def differ(one: np.ndarray, other: np.ndarray) -> bool:
    size = max(1.0, float(np.max(np.abs(one))), float(np.max(np.abs(other))))
    return float(np.max(np.abs(one - other))) > CONTRADICTS * size
