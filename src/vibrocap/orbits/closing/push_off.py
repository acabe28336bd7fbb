"""What becomes of a motion that is pushed off an unstable orbit: the orbits that a simulation does keep."""

from collections.abc import Mapping

import numpy as np

from vibrocap.orbits.closing.attractor_matching import orbits_reached
from vibrocap.orbits.closing.orbit import Orbit, OrbitStatus
from vibrocap.orbits.maps.settling_runs import kept_states, long_runs, map_of, moving_states

PUSH = 1e-3  # in natural sizes: small beside the distance of attractors, large beside the errors of a run


def pushed_off(
    orbit: Orbit, *, towards: Mapping[str, float] | None = None, settle_periods: int = 2000
) -> tuple[Orbit, ...]:
    """The orbits that attract what is pushed off an unstable orbit, one way and the other, each once.

    The push is along the eigenvector of the largest multiplier mu, y + PUSH v and y - PUSH v: for a pitchfork's
    symmetric orbit the two ways lead to the two mirror twins. What does not settle (chaos, or a very slow way) is left
    out, so that nothing at all may be returned; `classify` tells more.

    towards: a state; the way on which it lies comes first (by the left eigenvector, which measures along v alone)
    settle_periods: most drive periods simulated
    Raises ValueError for an orbit that is not unstable or did not close, and for one that nothing drives in time.
    """
    if orbit.status is not OrbitStatus.CONVERGED or not orbit.unstable:
        raise ValueError("orbit should be a closed one with a multiplier outside the unit circle: this one is kept")
    map_ = map_of(orbit.system, orbit.tolerance)
    state = np.array([orbit.state[name] for name in orbit.system.state_names])
    sizes = map_.scales(map_.parameters())
    moving = moving_states(map_)
    size = sizes[moving]
    slope = orbit.derivative[np.ix_(moving, moving)] * size / size[:, None]
    values, right = np.linalg.eig(slope)
    most = int(np.argmax(np.abs(values)))
    push = np.zeros(len(state))
    along = np.real(right[:, most])
    push[moving] = PUSH * size * along / np.max(np.abs(along))
    if towards is not None:
        there = np.array([towards.get(name, 0.0) for name in orbit.system.state_names])
        left = np.real(np.linalg.inv(right)[most])
        away = ((there - state) / sizes)[moving]
        push *= -1.0 if (left @ away) * (left @ (push / sizes)[moving]) < 0.0 else 1.0
    starts = state + np.stack([push, -push])
    rows = np.tile(map_.parameters(), (2, 1))
    runs = long_runs(map_, starts, rows, settle_periods)
    told, which, _ = orbits_reached(map_, runs, settle_periods, 2)
    ways = dict.fromkeys(int(k) for k in which if k >= 0)
    return tuple(told[k].orbit for k in ways if told[k].trusted)


def far_apart(orbit: Orbit, state: np.ndarray) -> float:
    """Distance of a state from an orbit at the section, over natural sizes."""
    map_ = map_of(orbit.system, orbit.tolerance)
    kept = kept_states(map_)
    there = np.array([orbit.state[name] for name in orbit.system.state_names])
    return float(np.max(np.abs(state - there)[kept] / map_.scales(map_.parameters())[kept]))
