"""A machine that is to travel, as an environment of Gymnasium: a policy sets the drive, held from decision to decision.

    python examples/travel_environment.py examples/bench-in-si.toml

The motion between two decisions is exact, with located events, so that a policy cannot exploit a simulator's smoothed
friction. Needs `python -m pip install gymnasium`. All numbers are in SI if the case is.
"""

import contextlib
import dataclasses
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, ClassVar

import gymnasium
import numpy as np

import vibrocap as vc
from vibrocap.physics.drives.drive import Piecewise, Segment

RUN = {"tolerance": 1e-10, "max_events_per_period": 10**6}


@vc.parameters
class Decisions(Piecewise):
    """The drive of a whole episode: one level after another, each of the same length."""

    levels: Any = vc.parameter((1.0, -1.0), "u_k", "drive after each decision", "effort")
    length: Any = vc.parameter(1.0, "h", "time between decisions", "duration")
    name: ClassVar[str] = "decisions"
    source: ClassVar[str] = "vibrocap"

    def segments(self) -> tuple[Segment, ...]:
        return tuple(Segment(1.0 / len(self.levels), (level,)) for level in self.levels)

    @property
    def period(self) -> float:
        return self.length * len(self.levels)


class TravelEnvironment(gymnasium.Env):
    """Travel under a held drive: the reward is the distance gained, less the price of the drive.

        reward = X(t + h) - X(t) - effort_cost u^2 h

    Actions: one number from -1 to 1, times `limit` the drive u that is held for the time h. Observations: all states
    but the position, on which nothing depends, then the mode of each contact (+1, -1 it slides, 0 it sticks).

    path: a case file, whose drive gives way to the policy
    length: time h between two decisions; limit: largest drive; effort_cost: price of u^2 per time
    steps: decisions after which an episode is cut off (`truncated`)
    spread: by name of a state, how far from its initial value an episode may begin, uniformly to both sides
    measures: names of `vibrocap list measures`; info["measures"] holds them for an episode that was cut off
    An episode ends (`terminated`) where the motion cannot continue, as at a lift-off: info["status"] names the cause.
    """

    def __init__(
        self,
        path: str | Path,
        *,
        length: float,
        limit: float,
        effort_cost: float = 0.0,
        steps: int = 500,
        spread: Mapping[str, float] | None = None,
        measures: Sequence[str] = (),
    ):
        self.case, self.length, self.limit, self.effort_cost = vc.read_case(path), length, limit, effort_cost
        self.steps, self.spread, self.measures, system = steps, dict(spread or {}), tuple(measures), self.case.system
        if system.cyclic is None or system.controller is not None or system.machine.effort not in ("force", "torque"):
            raise ValueError(f"{path}: should have a machine that travels, driven by a force or torque, uncontrolled")
        self._kept = [name for name in system.state_names if name != system.cyclic]
        size = len(self._kept) + len(vc.stepper(self.case, input="drive").sides)
        self.action_space = gymnasium.spaces.Box(-1.0, 1.0, (1,), np.float64)
        self.observation_space = gymnasium.spaces.Box(-np.inf, np.inf, (size,), np.float64)

    def reset(self, *, seed: int | None = None, options: Mapping[str, Any] | None = None):
        """(observation, info) at the start; options: {"initial": {...}} replaces initial states."""
        super().reset(seed=seed)
        self._initial = {**self.case.initial, **(options or {}).get("initial", {})}
        for name, reach in self.spread.items():
            self._initial[name] = self._initial.get(name, 0.0) + float(self.np_random.uniform(-reach, reach))
        self._motion = vc.stepper(self.case, input="drive", initial=self._initial, tolerance=RUN["tolerance"])
        self._levels: list[float] = []
        return self._seen()

    def step(self, action: Any):
        """(observation, reward, terminated, truncated, info) after an action was held for the length."""
        drive, position = self.limit * float(np.clip(action, -1.0, 1.0)[0]), self._motion[self.case.system.cyclic]
        with contextlib.suppress(vc.MotionEnded):  # the status names the cause
            self._motion.step(drive, self.length)
        self._levels.append(self._motion.dimensionless["drive"])
        observation, info = self._seen()
        terminated = self._motion.status is not None
        truncated = not terminated and len(self._levels) >= self.steps
        if truncated and self.measures:
            info["measures"] = self._measured()
        reward = info["position"] - position - self.effort_cost * drive * drive * self.length
        return observation, reward, terminated, truncated, info

    def _seen(self) -> tuple[np.ndarray, dict[str, Any]]:
        now = self._motion.look()
        info = {"time": now.time, "position": now.states[self.case.system.cyclic], "events": now.events}
        observation = np.array([*(now.states[name] for name in self._kept), *now.sides], dtype=float)
        return observation, info | {"status": "running" if now.status is None else now.status.value}

    def _measured(self) -> dict[str, Any]:
        """The measures of the episode, as of a motion whose drive is its decisions."""
        drive = Decisions(tuple(self._levels), self._motion.dimensionless.time / len(self._levels))
        system = dataclasses.replace(self.case.system, drive=drive)
        return vc.measured(vc.simulate(system, periods=1, initial=self._initial, **RUN), self.measures, window=1)


if __name__ == "__main__":
    environment = TravelEnvironment(sys.argv[1], length=0.1, limit=0.7, measures=["mean_velocity", "drive_work"])
    observation, info = environment.reset(seed=1)
    while "measures" not in info:  # pump
        observation, reward, terminated, truncated, info = environment.step([1.0 if observation[1] >= 0.0 else -1.0])
    print(info)
