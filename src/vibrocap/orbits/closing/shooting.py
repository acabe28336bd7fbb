"""Newton shooting: from a state near a steady motion to the orbit itself, stable or not."""

import dataclasses
from collections.abc import Mapping

import numpy as np

from vibrocap.orbits.closing.orbit import Orbit, OrbitStatus
from vibrocap.orbits.maps.stroboscopic_map import Images, StroboscopicMap
from vibrocap.system import System

CLOSED = 1e-11  # residual at which an orbit is closed; Newton goes on while it pays
ROUNDING = 1e-9  # residual that counts as closed where no step of Newton's method makes it smaller
MOST_STEPS = 25
LONGEST_STRIDE = 1.0  # of a Newton step, in natural sizes of a state
FORGOTTEN = 1e-13  # size of a multiplier below which, with a law that sticks, it is zero
SAME = 1e-7  # distance over natural sizes within which a mirrored orbit is the orbit itself


@dataclasses.dataclass
class _Try:
    """A state of Newton's method: where it is, what the map makes of it, and by how much it does not close."""

    state: np.ndarray
    image: np.ndarray
    jacobian: np.ndarray
    mismatch: np.ndarray  # over natural sizes
    residual: float
    finished: bool


def shoot(
    system: System,
    start: Mapping[str, float],
    response_period: int = 1,
    *,
    half: bool = False,
    tolerance: float = 1e-12,
    map_: StroboscopicMap | None = None,
) -> Orbit:
    """The orbit near a state, by Newton's method on the stroboscopic map P over n drive periods.

        y without its cyclic coordinate:   P^n(y) = y,      or with `half` (n odd)   (S P_(T/2))^n (y) = y

    The fixed points of the second are exactly the symmetric orbits, also unstable ones among pairs of mirror twins. The
    velocity of a contact that sticks at the section is left out too. Derivatives come from the variational equations,
    through events. Steps are halved while they do not reduce the mismatch.

    start: values of all states but the cyclic one, by name (those not named are zero)
    tolerance: of the runs, error per step over the natural size of each state
    Returns an `Orbit` whose status says how it ended. Raises ValueError for unknown names or a period < 1.
    """
    checked_start(system, start, response_period, half)
    map_ = map_ or StroboscopicMap(system, tolerance)
    state = np.array([float(start.get(name, 0.0)) for name in system.state_names])
    if map_.cyclic >= 0:
        state[map_.cyclic] = 0.0
    closure = _Closure(map_, map_.parameters(system), response_period, half)
    best, steps = closure.attempt(state), 0
    while best.finished and steps < MOST_STEPS and best.residual > 1e-3 * CLOSED:
        following = _newton_step(closure, best)
        if following is None:
            break
        best, steps = following, steps + 1
    status = OrbitStatus.CONVERGED if best.residual <= ROUNDING else OrbitStatus.NOT_CONVERGED
    return _orbit(closure, best, system, status if best.finished else OrbitStatus.RUN_FAILED, steps)


def closing(map_: StroboscopicMap, state: np.ndarray, response_period: int, status: OrbitStatus) -> Orbit:
    """The record of a state as it is, without a step towards closing, under the status given."""
    closure = _Closure(map_, map_.parameters(), response_period, False)
    found = closure.attempt(state)
    return _orbit(closure, found, map_.system, status if found.finished else OrbitStatus.RUN_FAILED, 0)


def checked_start(system: System, start: Mapping[str, float], response_period: int, half: bool) -> None:
    """Refuse a start, a period or a half-period search that the system has not."""
    unknown = [name for name in start if name not in system.state_names]
    if unknown:
        raise ValueError(
            f"start should name states of the system ({', '.join(system.state_names)}), got {unknown[0]!r}"
        )
    whole = isinstance(response_period, (int, np.integer)) and not isinstance(response_period, bool)
    if not whole or response_period < 1:
        raise ValueError(f"response_period should be a whole number of drive periods >= 1, got {response_period!r}")
    if half and not system.mirrored:
        raise ValueError("half should be False: the system has no half-period symmetry (drive, machine or law)")
    if half and response_period % 2 == 0:
        raise ValueError(f"response_period should be odd with half=True, got {response_period}: no other is symmetric")


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
        return np.arange(self.map_.states) != self.map_.cyclic

    def attempt(self, state: np.ndarray) -> _Try:
        found = mapped(self.map_, state, self.parameters, self.response_period, self.half)
        image = found.state[0]
        mismatch = np.where(self.kept, (image - state) / self.scales, 0.0)
        residual = float(np.max(np.abs(mismatch)))
        finished = bool(found.finished[0]) and bool(np.isfinite(residual))
        assert found.jacobian is not None
        return _Try(state, image, found.jacobian[0], mismatch, residual if finished else np.inf, finished)


def mapped(
    map_: StroboscopicMap, state: np.ndarray, parameters: np.ndarray, response_period: int, half: bool
) -> Images:
    """Image and derivative over the whole response, or over the half of it with the mirror."""
    if not half:
        return map_.images(state[None], parameters[None], response_period)
    total, finished = np.eye(map_.states), True
    here = state[None]
    for _ in range(response_period):
        found = map_.mirrored_half(here, parameters[None])
        assert found.jacobian is not None
        here, total, finished = found.state, found.jacobian[0] @ total, finished and bool(found.finished[0])
    return Images(here, total[None], np.array([finished]))


def _newton_step(closure: _Closure, best: _Try) -> _Try | None:
    """The next state, less mismatched than the last; None where no step along Newton's direction is."""
    map_, scales = closure.map_, closure.scales
    contact = map_.equations.contact_state
    if map_.equations.hold is not None and best.image[contact] == 0.0 and best.state[contact] != 0.0:
        stuck = best.state.copy()
        stuck[contact] = 0.0
        return closure.attempt(stuck)  # the contact sticks at the section: its velocity is no unknown any more
    unknown = np.flatnonzero(closure.kept & map_.free(best.state[None])[0])
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


def _orbit(closure: _Closure, found: _Try, system: System, status: OrbitStatus, steps: int) -> Orbit:
    """The record of an orbit, with its whole map, its multipliers and its mirror image."""
    map_, parameters, response_period = closure.map_, closure.parameters, closure.response_period
    whole = map_.images(found.state[None], parameters[None], response_period)
    assert whole.jacobian is not None
    symmetric, twin = None, None
    if system.mirrored:
        image = map_.mirrored_half(found.state[None], parameters[None], tangents=False).state[0]
        symmetric = closure.half
        if not symmetric and response_period % 2 == 1:
            away = mapped(map_, found.state, parameters, response_period, True).state[0] - found.state
            symmetric = bool(np.max(np.abs(away / closure.scales)[closure.kept]) <= SAME)
        twin = named_states(system, image)
        if map_.cyclic >= 0:
            twin[system.state_names[map_.cyclic]] = 0.0
    drift = None
    if map_.cyclic >= 0:
        drift = 0.0 if symmetric else float(whole.state[0][map_.cyclic] - found.state[map_.cyclic])
    return Orbit(
        system=system,
        state=named_states(system, found.state),
        period=response_period * map_.period(parameters),
        response_period=response_period,
        drift=drift,
        multipliers=floquet_multipliers(map_, whole.jacobian[0]),
        residual=found.residual,
        symmetric=symmetric,
        derivative=whole.jacobian[0],
        status=status,
        iterations=steps,
        tolerance=map_.tolerance,
        mirrored_state=twin,
    )


def named_states(system: System, state: np.ndarray) -> dict[str, float]:
    """A state vector by names."""
    return dict(zip(system.state_names, map(float, state), strict=True))


def floquet_multipliers(map_: StroboscopicMap, jacobian: np.ndarray) -> np.ndarray:
    """Eigenvalues of the map's derivative without the cyclic coordinate, largest first; switched states have none.

    A direction that the contact forgets while it sticks has the multiplier zero exactly. Rounding leaves some 1e-17 of
    it, so for a law that sticks a multiplier below FORGOTTEN is reported as 0.
    """
    moving = [
        i
        for i, name in enumerate(map_.system.state_names)
        if i != map_.cyclic and name not in map_.system.friction.switched
    ]
    values = np.linalg.eigvals(jacobian[np.ix_(moving, moving)]).astype(complex)
    if map_.equations.hold is not None:
        values[np.abs(values) <= FORGOTTEN] = 0.0
    return values[np.argsort(-np.abs(values), kind="stable")]
