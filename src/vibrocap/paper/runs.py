"""The runs behind the paper's figures and claims, each made once."""

import dataclasses
import functools

import numpy as np

from vibrocap.laboratory.driven import driven_force
from vibrocap.measures.recorded.friction_loop import FrictionLoop, friction_loop
from vibrocap.measures.recorded.travel import mean_velocity
from vibrocap.motion.simulate import simulate
from vibrocap.motion.status import Status
from vibrocap.motion.trajectory import STUCK, Trajectory
from vibrocap.orbits.continuation.crossing import Crossings, crossing
from vibrocap.paper.presets import MASS_RATIOS, figures_5_to_8, figures_9_to_11, start, with_load
from vibrocap.physics.friction.bristles import LuGre
from vibrocap.physics.system import System

TOLERANCE = 1e-10
SHOWN_PERIODS = 40  # of the runs that start as the paper's do
SETTLING_PERIODS = 200  # after which every motion of the paper has settled, or is reported as not settled
WINDOWS = (1, 5, 10, 20, 40, 100)  # averaging windows from the start, in drive periods; the paper names none
LAST = 10  # periods of the window at the end, for the steady velocity
SWEEP_PERIODS = 150
RANDOM_RATIOS, RANDOM_STARTS = 9, 8  # mass ratios of Fig. 9, and random starts at each
SWEEP_POINTS = 82  # mass ratios of Fig. 9: about 0.1 apart
LIGHT_RATIOS = (0.01, 0.15)  # where a load that follows the motion can end it
LIGHT_POINTS = 29  # 0.005 apart
SAMPLES = 4000  # per cycle of an imposed velocity, that are returned
# samples for each of these that the law follows, so that the straight lines between them are a sine to 1e-10
FINER = 16
CYCLES = 2  # the last of which is kept
MEAN, AMPLITUDE = 0.1, 0.05  # of the velocity of pure sliding: where steady friction falls most steeply


@dataclasses.dataclass(frozen=True, eq=False)
class Period:
    """The last period of a settled motion, on a fine grid: time from its start, every state, and the friction."""

    motion: Trajectory
    time: np.ndarray
    values: dict[str, np.ndarray]
    drift: float

    def __getitem__(self, name: str) -> np.ndarray:
        return self.values[name]

    @functools.cached_property
    def loop(self) -> FrictionLoop:
        """The friction loop of this period."""
        return friction_loop(self.motion)

    @property
    def wave(self) -> np.ndarray:
        """The position less its drift: periodic."""
        return self.values["position"] - self.drift * self.time / self.motion.period


@dataclasses.dataclass(frozen=True, eq=False)
class Sweep:
    """Motions over the mass ratio: displacement at each period mark, and the peaks of the last period."""

    mass_ratio: np.ndarray  # [points]
    sections: np.ndarray  # position at the period marks [points, periods + 1]
    residual: np.ndarray  # largest change of the state modulo X over the last period [points]
    velocity_peaks: np.ndarray  # largest forward and backward velocity of the last period [points, 2]
    swing: np.ndarray  # largest less smallest position in the last period [points]

    def mean_velocity(self, period: float, window: int, last: bool = False) -> np.ndarray:
        """Average velocity over the first (or the last) `window` periods."""
        return _travelled(self.sections, window, last) / (window * period)


def _travelled(sections: np.ndarray, window: int, last: bool) -> np.ndarray:
    """How far the position gets in the first (or the last) `window` periods, of its values at the period marks."""
    first, second = (-1 - window, -1) if last else (0, window)
    return sections[..., second] - sections[..., first]


@dataclasses.dataclass(frozen=True, eq=False)
class LoadedRun:
    """A motion of Fig. 9 under the dynamic load, which may end it."""

    mass_ratio: float
    status: Status
    end: float  # time reached
    sections: np.ndarray  # position at the period marks that were reached
    at_rest: bool  # whether the capsule never left its place
    last_load: float
    last_coefficient: float  # |R|/N at the end

    def mean_velocity(self, period: float, window: int, last: bool = False) -> float:
        """Average velocity over the first (or the last) `window` periods, of a run that went to its end."""
        return float(_travelled(self.sections, window, last)) / (window * period)


class Runs:
    """Makes each run once and keeps it."""

    def __init__(self):
        self._motions: dict[tuple, Trajectory] = {}

    def motion(self, system: System, periods: float = SHOWN_PERIODS, twin: bool = False) -> Trajectory:
        """A motion from the paper's start, or its mirror-image solution."""
        key = (system, periods, twin)
        if key not in self._motions:
            self._motions[key] = run(system, periods, twin)
        return self._motions[key]

    @functools.cache  # noqa: B019
    def random_starts(self, friction: str) -> tuple[float, ...]:
        """Mean velocities at the end of motions of Fig. 9 from random starts, at mass ratios over the whole range."""
        random, starts = np.random.default_rng(9), []
        for ratio in np.linspace(*MASS_RATIOS, RANDOM_RATIOS):
            system = figures_9_to_11(friction, float(ratio))
            for angle, turn, velocity in random.uniform((-2.0, -3.0, -1.0), (2.0, 3.0, 1.0), (RANDOM_STARTS, 3)):
                begin = {"angle": float(angle), "angle_rate": float(turn), "velocity": float(velocity)}
                motion = simulate(system, periods=SWEEP_PERIODS, initial=begin, tolerance=TOLERANCE)
                starts.append(mean_velocity(motion, periods=LAST).value)
        return tuple(starts)

    def first_set(self, friction: str, twin: bool = False, **friction_changes: float) -> Trajectory:
        """The motion of Figs 5-8 from the start, as far as it is shown."""
        return self.motion(figures_5_to_8(friction, **friction_changes), twin=twin)

    @functools.cache  # noqa: B019 - a handful of runs, kept as long as their owner
    def steady(self, friction: str, twin: bool = False, load: float | str = 1.0, **friction_changes: float) -> Period:
        """The last period of the settled motion of Figs 5-8."""
        system = with_load(figures_5_to_8(friction, **friction_changes), load)
        return last_period(self.motion(system, SETTLING_PERIODS, twin=twin))

    @functools.cache  # noqa: B019
    def sweep(self, friction: str, stiffness: float = 4.0, points: int = SWEEP_POINTS, twin: bool = False) -> Sweep:
        """The motions of Fig. 9 over the mass ratio."""
        ratios = np.linspace(*MASS_RATIOS, points)
        rows = [self._sweep_row(figures_9_to_11(friction, ratio, stiffness), twin) for ratio in map(float, ratios)]
        return Sweep(ratios, *(np.array(column) for column in zip(*rows, strict=True)))

    @functools.cache  # noqa: B019
    def loaded_sweep(self, friction: str, light: bool = False) -> tuple[LoadedRun, ...]:
        """The motions of Fig. 9 under the dynamic load; light: of light capsules, on a finer grid."""
        ratios = np.linspace(*LIGHT_RATIOS, LIGHT_POINTS) if light else np.linspace(*MASS_RATIOS, SWEEP_POINTS)
        periods = SHOWN_PERIODS if light else SWEEP_PERIODS
        return tuple(self._loaded(friction, round(float(ratio), 6), periods) for ratio in ratios)

    def _loaded(self, friction: str, ratio: float, periods: int) -> LoadedRun:
        system = with_load(figures_9_to_11(friction, ratio), "dynamic")
        motion = run(system, periods, complete=False)
        at_rest = system.friction.kind == "set-valued" and bool(np.all(motion.piece_sides == STUCK))
        load, force = (float(motion.at(motion.end, name)[0]) for name in ("reaction", "friction"))
        coefficient = abs(force / load) if load > 0.0 else 0.0
        return LoadedRun(ratio, motion.run_status, motion.end, motion.sections[:, 2], at_rest, load, coefficient)

    @functools.cache  # noqa: B019
    def crossings(self, friction: str, stiffness: float = 4.0, against: str | None = None) -> Crossings:
        """Where the steady drift over the mass ratio of Fig. 9 is zero, or equals that of the other law."""
        other = None if against is None else figures_9_to_11(against, stiffness=stiffness)
        system = figures_9_to_11(friction, stiffness=stiffness)
        over, begin = ("machine.mass_ratio", MASS_RATIOS), start(system)
        return crossing(system, "drift", *over, against=other, initial=begin, points=SWEEP_POINTS)

    def _sweep_row(self, system: System, twin: bool) -> tuple:
        motion = run(system, SWEEP_PERIODS, twin)
        period = last_period(motion, samples=1024)
        velocity, position = period["velocity"], period["position"]
        peaks = (float(velocity.max()), float(-velocity.min()))
        return motion.sections[:, 2], return_residual(motion), peaks, float(np.ptp(position))


def run(system: System, periods: float, twin: bool = False, complete: bool = True) -> Trajectory:
    """A motion from the paper's start; or its mirror-image solution: started mirrored, half a period later.

    Half a period later the torque of an odd drive is reversed: that is how the twin is run here. complete: one that
    does not go to its end is an error.
    """
    if twin:
        system = system.with_parameters({"drive.amplitude": -system.parameter("drive.amplitude")})
    motion = simulate(system, periods=periods, initial=start(system, mirrored=twin), tolerance=TOLERANCE)
    if complete and not motion.status.ok:
        raise RuntimeError(f"{system}: {motion.status.text}")
    return motion


def last_period(motion: Trajectory, samples: int = 8192) -> Period:
    """The last period of a motion on a uniform grid, both ends included."""
    begin = motion.end - motion.period
    time = np.linspace(begin, motion.end, samples + 1)
    rows = motion.states(time)
    values = {name: rows[i] for i, name in enumerate(motion.state_names)}
    values["friction"] = motion.at(time, "friction")
    position = values["position"]
    return Period(motion, time - begin, values, float(position[-1] - position[0]))


def return_residual(motion: Trajectory) -> float:
    """Largest difference between the last two period marks, of all states but X: zero for a period-1 motion."""
    kept = [i for i, name in enumerate(motion.state_names) if name != motion.system.cyclic]
    return float(np.max(np.abs(motion.sections[-1, kept] - motion.sections[-2, kept])))


def imposed_cycle(friction: LuGre, mean: float, amplitude: float) -> tuple[np.ndarray, np.ndarray]:
    """Velocity and friction over a cycle of an imposed velocity, X' = mean + amplitude sin(tau), N = 1.

    One cycle has passed before, from bristles at rest.
    """
    time = np.linspace(0.0, 2.0 * np.pi * CYCLES, CYCLES * SAMPLES * FINER + 1)
    velocity = mean + amplitude * np.sin(time)
    forces = driven_force(friction, time, velocity, tolerance=1e-10)
    last = slice(-SAMPLES * FINER - 1, None, FINER)
    return velocity[last], forces.force[last]


def imposed_sliding(damping: float) -> dict[str, np.ndarray]:
    """Friction while accelerating and decelerating at equal speeds, for X' = 0.1 + 0.05 sin(tau): pure sliding."""
    velocity, force = imposed_cycle(LuGre(bristle_damping=damping), MEAN, AMPLITUDE)
    lowest = 3 * SAMPLES // 4
    velocity, force = np.roll(velocity[:-1], -lowest), np.roll(force[:-1], -lowest)
    half = SAMPLES // 2
    speeds = MEAN + AMPLITUDE * np.linspace(-0.95, 0.95, 96)
    return {
        "velocity": speeds,
        "accelerating": np.interp(speeds, velocity[:half], force[:half]),
        "decelerating": np.interp(speeds, velocity[half:][::-1], force[half:][::-1]),
    }
