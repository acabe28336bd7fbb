"""A capsule that is to travel, as an environment of Gymnasium: a policy sets the drive, held from decision to decision.

The motion between two decisions is exact, with located events, so that a policy cannot live on the friction that a
simulator smooths. Needs the extra `gym`.
"""

import copy
import math
from collections.abc import Mapping
from typing import Any

import gymnasium  # pyright: ignore[reportMissingImports]  # the extra `gym`
import numpy as np

from vibrocap.arguments import ArgumentError, check_whole, is_positive, shown, suggestion
from vibrocap.case.case import Case
from vibrocap.exchange.stepped_case import SteppedCase
from vibrocap.exchange.stepper import InputStepper, MotionEnded
from vibrocap.physics.drives.harmonic import Harmonic
from vibrocap.physics.friction.exponential import Exponential
from vibrocap.physics.machines.pendulum_capsule import PendulumCapsule
from vibrocap.physics.system import System

ID = "vibrocap/Travel-v0"


class TravelEnvironment(gymnasium.Env):
    """Travel under a held drive: the reward is the distance gained, less the price of the drive.

        reward = X(t + h) - X(t) - effort_cost u^2 h

    Actions: one number from -1 to 1, times `limit` the drive u that is held for the length h. Observations: all states
    but the position, on which nothing depends, then the side of each contact (+1, -1 it slides, 0 it is at rest).
    Times and states are dimensionless.

    case: the machine and its friction, of which the drive gives way to the action; None: the paper's capsule with the
        exponential law. A machine whose motion the drive imposes feels slopes only, and is refused
    length: time h between two decisions; limit: largest drive; effort_cost: what u^2 costs per unit of time
    steps: decisions after which an episode is cut off (`truncated`)
    spread: by name of a state, how far from its initial value an episode may begin, uniformly to both sides
    Where the motion cannot continue, as its load has lifted off, the episode is over (`terminated`), and info["status"]
    says why. info holds time, position, sides and counts of events at any rate.
    """

    metadata = {"render_modes": []}  # noqa: RUF012  as Gymnasium has it

    def __init__(
        self,
        case: Case | System | None = None,
        *,
        length: float = 0.2,
        limit: float = 1.8,
        effort_cost: float = 0.0,
        steps: int = 500,
        spread: Mapping[str, float] | None = None,
    ):
        if case is None:
            case = System(PendulumCapsule(), Exponential(), Harmonic())
        if not isinstance(case, (Case, System)):
            raise ArgumentError("case", f"should be a case or a system, got {shown(case)}")
        case = Case(case) if isinstance(case, System) else case
        for name, value in (("length", length), ("limit", limit)):
            if not is_positive(value):
                raise ArgumentError(name, f"should be a finite number > 0, got {shown(value)}")
        if not (isinstance(effort_cost, (int, float)) and 0.0 <= effort_cost < math.inf):
            raise ArgumentError("effort_cost", f"should be a finite number >= 0, got {shown(effort_cost)}")
        check_whole("steps", steps, 1)
        if case.system.cyclic is None:
            raise ArgumentError("case", f"should have a machine that travels, got the {case.system.machine.name}")
        if case.system.machine.effort not in ("force", "torque"):
            what = f"a machine that a force or a torque drives, got the {case.system.machine.name}"
            raise ArgumentError("case", f"should have {what}")
        if case.system.controller is not None:
            raise ArgumentError("case", "should have no controller: the policy is to be one")
        names, spread = case.system.state_names, dict(spread or {})
        for name, value in spread.items():
            if name not in names:
                raise ArgumentError(f"spread.{name}", f"no such state; {suggestion(name, names)}")
            if not 0.0 <= value < math.inf:
                raise ArgumentError(f"spread.{name}", f"should be a finite number >= 0, got {shown(value)}")
        self.case, self.length, self.limit, self.effort_cost, self.steps = case, length, limit, effort_cost, steps
        self.spread = spread
        self._position = names.index(case.system.cyclic)
        self._stepped = SteppedCase(case, "drive")
        self._stepper, self._done, self._before = InputStepper(self._stepped), 0, 0.0
        size = len(names) - 1 + self._stepped.contacts
        self.action_space = gymnasium.spaces.Box(-1.0, 1.0, (1,), np.float64)
        self.observation_space = gymnasium.spaces.Box(-np.inf, np.inf, (size,), np.float64)

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None):
        """(observation, info) at the start of an episode.

        options: {"initial": {...}} gives initial states by name in place of those of the case
        """
        super().reset(seed=seed)
        given = dict(self.case.initial) | dict((options or {}).get("initial", {}))
        for name, reach in self.spread.items():
            given[name] = given.get(name, 0.0) + float(self.np_random.uniform(-reach, reach))
        stepped = copy.copy(self._stepped)  # with the kernel, which does not depend on where a motion begins
        object.__setattr__(stepped, "case", Case(self.case.system, given, **self.case.run))
        self._stepper, self._done = InputStepper(stepped), 0
        states = self._stepper.states
        self._before = float(states[self._position])
        return self._observation(states), self._info()

    def step(self, action: Any):
        """(observation, reward, terminated, truncated, info) after an action was held for the length."""
        share = np.asarray(action, dtype=float).reshape(-1)
        if share.shape != (1,) or not abs(share[0]) <= 1.0:
            raise ArgumentError("action", f"should be one number from -1 to 1, got {shown(action)}")
        drive, terminated = self.limit * float(share[0]), False
        try:
            self._stepper.step(drive, self.length)
        except MotionEnded:
            terminated = True
        self._done += 1
        states = self._stepper.states
        position, before = float(states[self._position]), self._before
        self._before = position
        reward = position - before - self.effort_cost * drive * drive * self.length
        truncated = not terminated and self._done >= self.steps
        return self._observation(states), reward, terminated, truncated, self._info()

    def _observation(self, states: np.ndarray) -> np.ndarray:
        return np.concatenate((np.delete(states, self._position), np.array(self._stepper.sides, dtype=float)))

    def _info(self) -> dict[str, Any]:
        stepper = self._stepper
        status = stepper.status
        return {
            "time": stepper.time,
            "position": self._before,
            "sides": stepper.sides,
            "events": stepper.events,
            "status": "running" if status is None else status.value,
        }


gymnasium.register(id=ID, entry_point=f"{__name__}:{TravelEnvironment.__name__}")
