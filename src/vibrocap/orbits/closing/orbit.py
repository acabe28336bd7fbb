"""A steady motion: `Orbit`, and the two ways to it, `orbit` by simulation and `shoot` from a state near it."""

import dataclasses
from collections.abc import Callable, Iterable
from typing import Any

import numpy as np

from vibrocap.arguments import ArgumentError, check_whole
from vibrocap.measures.recorded.sticking import spelled_all
from vibrocap.motion.simulate import check_run, initial_state
from vibrocap.orbits.closing.autonomous_orbit import MOST_RETURNS, SectionAsked, autonomous_orbit, checked_section
from vibrocap.orbits.closing.gradients import Gradients, gradients
from vibrocap.orbits.closing.periodic_solution import OrbitStatus, PeriodicSolution, judged
from vibrocap.orbits.closing.settling_runs import SETTLED, orbits_reached, settling_runs
from vibrocap.orbits.closing.shooting import closed, shortest, unclosed
from vibrocap.orbits.maps.stroboscopic_map import StroboscopicMap, is_driven, state_vector
from vibrocap.orbits.walk.residual import CLOSE_TO_CIRCLE
from vibrocap.physics.system import System
from vibrocap.progress import Progress, shows_progress, told
from vibrocap.quantities.declared import ByName

CLOSED = 1e3  # tolerances, to which a neighbour closes that is steady too
PUSH = 1e-3  # in natural sizes: small beside the distance of attractors, large beside the errors of a run


def in_continuum(map_: StroboscopicMap, solution: PeriodicSolution) -> bool:
    """Whether a state a little way off along a multiplier of 1 closes as well, on at least one side.

    So it is of a two-phase crawler whose phases are equally long: friction takes in one what it gives in the other,
    whatever the velocity. At a fold, where a multiplier passes 1, the neighbours do not close.
    """
    if not solution.closes or np.all(np.abs(solution.multipliers - 1.0) > CLOSE_TO_CIRCLE):
        return False
    moving, row = map_.smooth_states, map_.parameters()
    push, _, _ = _push(map_, solution, lambda values: -np.abs(values - 1.0))
    starts = state_vector(solution.system, solution.state) + np.stack([push, -push])
    images = map_.images(starts, row, solution.response_period)
    away = np.max(np.abs(map_.away(images.state, starts)[:, moving]) / map_.scales(row)[moving], axis=1)
    return bool(np.any(images.finished & (away <= CLOSED * solution.tolerance)))


def _push(
    map_: StroboscopicMap, solution: PeriodicSolution, rank: Callable[[np.ndarray], np.ndarray]
) -> tuple[np.ndarray, np.ndarray, int]:
    """(push [states] along the eigenvector of the multiplier that ranks highest, all eigenvectors, number of that)."""
    moving, push = map_.smooth_states, np.zeros(map_.states)
    size = map_.scales(map_.parameters())[moving]
    values, right = np.linalg.eig(solution.derivative[np.ix_(moving, moving)] * size / size[:, None])
    place = int(np.argmax(rank(values)))
    along = np.real(right[:, place])
    push[moving] = PUSH * size * along / np.max(np.abs(along))
    return push, right, place


@dataclasses.dataclass(frozen=True, eq=False, repr=False)
class Orbit(PeriodicSolution):
    """A steady motion, periodic modulo its drift; the fields are those of `PeriodicSolution`.

    passed: the unstable orbit near which the motion from the start seemed to have settled before it went on to this
        one; None as a rule
    continuum: whether it is one of a continuum of orbits: what a start leads to depends on the start, and drift and
        mean velocity are those of this orbit alone
    """

    passed: "Orbit | None" = None
    continuum: bool = False

    in_record = (
        "status failed residual period response_period drift mean_velocity winding returns stable stability "
        "largest_multiplier multipliers continuum symmetric mode_sequence state mirrored_state"
    )

    @classmethod
    def of(cls, solution: PeriodicSolution, map_: StroboscopicMap | None = None) -> "Orbit":
        """The orbit of a periodic solution, judged by the certificate of the motion along it.

        map_: of which it is one, to be asked whether there are others beside
        """
        solution = judged(solution)
        known: dict[str, Any] = {**vars(solution), "continuum": map_ is not None and in_continuum(map_, solution)}
        return cls(**known)

    @property
    def facts(self) -> dict[str, str]:
        beside = {"beside": "one of a continuum of orbits: travel is not determined"} if self.continuum else {}
        return super().facts | beside

    @property
    def mode_sequence(self) -> str:
        """Phases of the motion over its whole period, read as a cycle: F forward, S stuck, B back.

        Of several contacts those of each, the first one first: "FSB|FB". Of a smooth law there are none, nor of an
        orbit that is not closed.
        """
        return "" if self.failed else spelled_all(self.motion())

    def gradients(
        self, over: Iterable[str] | str | None = None, measures: Iterable[str] | str | None = None
    ) -> Gradients:
        """How measures of the motion change with parameters, exactly: slopes with units, and elasticities.

        over: paths such as "machine.mass_ratio", of a system in SI also "drive.frequency_Hz"; None: all numbers
        measures: mean_velocity (unless told otherwise), drift, cost_of_transport, drive_work and other works
        Raises ValueError, see `gradients.gradients`.
        """
        return gradients(self, over, measures)

    def pushed_off(self, *, settle_periods: int = 2000) -> "tuple[Orbit, ...]":
        """The orbits that attract what is pushed off this unstable one, one way and the other, each once.

        For a pitchfork's symmetric orbit the two ways lead to the two mirror-image solutions. What does not settle
        (chaos, or a very slow way) is left out, so that nothing at all may be returned; `classify` tells more.

        settle_periods: most drive periods simulated
        Raises ValueError for an orbit that is not unstable or did not close, and for one that nothing drives in time.
        """
        return _pushed_off(self, settle_periods)

    def twin(self) -> "Orbit":
        """The mirror-image solution, which drifts the other way; the orbit itself where it is symmetric.

        Raises ValueError for a system without the half-period symmetry.
        """
        if self.mirrored_state is None:
            why = "the system has no half-period symmetry (an even drive, machine or law), so no mirror-image solutions"
            raise ValueError(why)
        if self.symmetric:
            return self
        return shoot(self.system, self.mirrored_state, self.response_period, tolerance=self.tolerance)


@shows_progress("Looking for the steady motion")
def orbit(
    system: System,
    *,
    initial: ByName | None = None,
    response_period: int | None = None,
    half: bool = False,
    settle_periods: int = 2000,
    section: SectionAsked = None,
    returns: int = MOST_RETURNS,
    tolerance: float = 1e-12,
    progress: Progress = None,
) -> Orbit:
    """The steady motion that a start leads to, closed to rounding.

    The long-term motion of a capsule is periodic modulo a shift of its position: a relative periodic orbit, whose shift
    per period is the drift; that of a rotor is so modulo whole turns too, whose number is `Orbit.winding`. The motion
    is simulated until its stroboscopic state has settled, which gives the response period, then closed by Newton's
    method (`shoot`), which also gives the Floquet multipliers. If the orbit is unstable the motion is pushed off it and
    followed to the orbit that it keeps; `Orbit.passed` is the one that it left, `passed.pushed_off()` are the orbits
    to both sides. The orbit of a system without a drive that changes in time (a block on a belt) has a period of its
    own, which is found too.

    initial: the start of the simulation, by state name (those not named are zero)
    response_period, half: look for an orbit of so many drive periods (half: for a symmetric one) straight from
        `initial`, and only if none closes from where a simulation leads; finds unstable orbits too
    settle_periods: most drive periods simulated before it counts as not settled
    section: of a system that nothing drives in time, where its turns are counted: a `Section`, or the name of an event
        such as "stick_2"; by default several are tried
    returns: most returns to the section in a cycle
    tolerance: of the runs, error per step over the natural size of each state
    progress: True for a bar, or a function that is called now and then
    Returns an `Orbit`; its `status` says whether it closed with a valid certificate, and what to try if not
    (`status.advice`). Raises ValueError, naming the argument, before any work.
    """
    start = np.array(list(initial_state(system, initial).values()))
    _check_response(system, 1 if response_period is None else response_period, half)
    check_run(periods=1, tolerance=tolerance, max_events_per_period=1, max_steps=1)
    check_whole("settle_periods", settle_periods, 1)
    check_whole("returns", returns, 1, 10**6)
    section = checked_section(system, section)
    if not is_driven(system):
        return Orbit.of(autonomous_orbit(system, start, settle_periods, tolerance, section, returns))
    if section is not None:
        raise ArgumentError("section", "should be None: the drive counts the turns of this system")
    map_ = StroboscopicMap(system, tolerance)
    asked = None
    if response_period is not None or half:
        asked = closed(map_, start, response_period or 1, half)
        if asked.closes:
            return Orbit.of(asked, map_)
    runs = settling_runs(map_, start[None], settle_periods, progress=told(progress))
    state, periods = runs.state[0], int(runs.response_period[0])
    if asked is not None:
        later = closed(map_, state, response_period or 1, half) if np.all(np.isfinite(state)) else asked
        return Orbit.of(later if later.closes else asked, map_)
    if periods == 0:
        return Orbit.of(unclosed(map_, state, 1, OrbitStatus.NOT_SETTLED))
    solution = shortest(map_, closed(map_, state, periods))
    if not solution.closes:
        return Orbit.of(solution)
    return _kept(map_, Orbit.of(solution, map_), state, periods, settle_periods)


def shoot(
    system: System,
    start: ByName,
    response_period: int = 1,
    *,
    half: bool = False,
    tolerance: float = 1e-12,
    map_: StroboscopicMap | None = None,
) -> Orbit:
    """The orbit near a state, stable or not, by Newton's method on the map over so many drive periods; see `closed`.

    start: values of all states but the cyclic one, by name (those not named are zero)
    half: look for a symmetric orbit, which is closed over half of its period and the mirror
    tolerance: of the runs, error per step over the natural size of each state
    map_: of a system of the same form, with a tolerance of its own
    Returns an `Orbit` whose status says how it ended. Raises ValueError for unknown names or a period < 1.
    """
    unknown = [name for name in start if name not in system.state_names]
    if unknown:
        why = f"should name states of the system ({', '.join(system.state_names)}), got {unknown[0]!r}"
        raise ArgumentError("start", why)
    _check_response(system, response_period, half)
    map_ = StroboscopicMap(system, tolerance) if map_ is None else map_.of(system)
    return Orbit.of(closed(map_, state_vector(system, start), response_period, half), map_)


def _pushed_off(orbit: Orbit, settle_periods: int, towards: np.ndarray | None = None) -> tuple[Orbit, ...]:
    """As `Orbit.pushed_off`; the way on which the state `towards` lies comes first."""
    if not orbit.closes or not orbit.unstable:
        why = "should be a closed one with a multiplier outside the unit circle: this one is kept"
        raise ArgumentError("orbit", why)
    if not is_driven(orbit.system):
        why = f"nothing drives it in time (the drive is {orbit.system.drive.name}), so there is no stroboscopic map"
        raise ArgumentError("system", f"{why} to look at; orbit(system, initial=...) finds its cycles")
    map_ = StroboscopicMap(orbit.system, orbit.tolerance)
    state, sizes, moving = state_vector(orbit.system, orbit.state), map_.scales(map_.parameters()), map_.smooth_states
    push, right, most = _push(map_, orbit, np.abs)
    if towards is not None:  # the left eigenvector measures along the largest multiplier's alone
        left, away = np.real(np.linalg.inv(right)[most]), (map_.away(towards, state) / sizes)[moving]
        push *= -1.0 if (left @ away) * (left @ (push / sizes)[moving]) < 0.0 else 1.0
    starts = state + np.stack([push, -push])
    orbits, which, _ = orbits_reached(map_, settling_runs(map_, starts, settle_periods), settle_periods, 2)
    ways = dict.fromkeys(int(k) for k in which if k >= 0)
    return tuple(Orbit.of(orbits[k].orbit) for k in ways if orbits[k].orbit.closes)


def _kept(map_: StroboscopicMap, settled: Orbit, state: np.ndarray, periods: int, settle_periods: int) -> Orbit:
    """The orbit that a simulation keeps, where it seemed to have settled: on from one that is unstable.

    A motion that passes close to an unstable orbit stands still for a while. Newton's method tells, which also may lead
    from a slow motion to an orbit that is elsewhere; then nothing is claimed.
    """
    away = np.max(np.abs(map_.section(state) - map_.section(state_vector(settled.system, settled.state))))
    if away > np.sqrt(SETTLED):
        return Orbit.of(unclosed(map_, state, periods, OrbitStatus.NOT_CONVERGED))
    if not settled.unstable:
        return settled
    reached = _pushed_off(settled, settle_periods, state)
    # what leaves the unstable orbit and does not settle has that orbit's numbers, as not closed
    onward = reached[0] if reached else dataclasses.replace(settled, status=OrbitStatus.NOT_SETTLED)
    return dataclasses.replace(onward, passed=settled)


def _check_response(system: System, response_period: int, half: bool) -> None:
    check_whole("response_period", response_period, 1)
    if half and not system.mirrored:
        raise ArgumentError("half", "should be False: the system has no half-period symmetry (drive, machine or law)")
    if half and response_period % 2 == 0:
        why = f"should be odd with half=True, got {response_period}: no other is symmetric"
        raise ArgumentError("response_period", why)
