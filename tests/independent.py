"""An integrator of the pendulum capsule that shares nothing with the package: the yardstick of the reference tests.

A yardstick must not contain the faults it is to find, so the equations are typed again from docs/model.md, the method
is SciPy's DOP853 and stick and slip are switched by hand:

- between two events the direction of sliding is a constant `side` and the right-hand side is smooth;
- after every accepted step the watched quantity (side * velocity, or the force to spare while stuck) is sampled on the
  dense output; a sign change, or a dip below zero between two samples, is bracketed there and then polished on
  *real* steps from the start of that step: an event time carries the accuracy of the method, not of its interpolant;
- the motion restarts with the velocity exactly zero and in the mode that the holding force decides.

`python -m tests.independent` (from the root of the repository) prints the reference table of docs/model.md. It made
tests/reference_motions.json too: random systems with the final states on which two of its tolerances agree to 1e-10.

A system is a dict of numbers here, for the same reason (no class of the package is needed):
    law ("exponential" | "lugre"), mass_ratio, stiffness, damping, normal_load,
    amplitude, frequency, second_amplitude, second_phase (the last two may be left out),
    coulomb_coefficient, static_coefficient,
    decay_rate                                                                     exponential law
    bristle_stiffness, bristle_damping, viscous_damping, stribeck_velocity, stribeck_exponent      LuGre
A state is (angle, angle_rate, position, velocity) and, with LuGre, the bristle deflection.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.integrate import DOP853
from scipy.optimize import brentq, minimize_scalar

SAMPLES_PER_STEP = 8
STEPS_PER_PERIOD = 60  # at least: no step is longer than this part of a period, so that no pair of events hides in one

ANGLE, ANGLE_RATE, POSITION, VELOCITY, BRISTLE = range(5)
STICK, FORWARD, BACK, REVERSAL = "stick", "slip forward", "slip back", "reversal"


@dataclass(frozen=True)
class ReferenceMotion:
    """A motion: the state at every period boundary (first row: the start), the events, the time spent stuck."""

    final: tuple[float, ...]
    at_periods: tuple[tuple[float, ...], ...]
    stick_fraction: float
    stick_fraction_last_period: float
    events: tuple[tuple[float, str], ...]


def drive(t: float, p: dict) -> float:
    phase = p["frequency"] * t
    return p["amplitude"] * math.cos(phase) + p.get("second_amplitude", 0.0) * math.cos(
        2.0 * phase + p.get("second_phase", 0.0)
    )


def moment(t: float, y: Sequence[float], p: dict) -> float:
    """P of docs/model.md: all that turns the pendulum but the capsule's acceleration."""
    return drive(t, p) + math.sin(y[ANGLE]) - p["stiffness"] * y[ANGLE] - p["damping"] * y[ANGLE_RATE]


def holding_force(t: float, y: Sequence[float], p: dict) -> float:
    """The friction force that would keep a resting capsule at rest: cos(theta) P - sin(theta) theta'^2."""
    return math.cos(y[ANGLE]) * moment(t, y, p) - math.sin(y[ANGLE]) * y[ANGLE_RATE] ** 2


def exponential_rates(t: float, y: Sequence[float], p: dict, side: int) -> list[float]:
    """Equations (9) with (8); side 0 is the stuck capsule."""
    if side == 0:
        return [y[ANGLE_RATE], moment(t, y, p), 0.0, 0.0]
    eta_c, eta_s = p["coulomb_coefficient"], p["static_coefficient"]
    speed = side * y[VELOCITY]  # continued below zero without a kink: a trial step may look there, a motion never goes
    force = side * p["normal_load"] * (eta_c + (eta_s - eta_c) * math.exp(-p["decay_rate"] * speed))
    return accelerated(t, y, p, force)


def lugre_rates(t: float, y: Sequence[float], p: dict, side: int) -> list[float]:
    """Equations (9) with (6), (7), (10), |X'| written as side * X'."""
    eta_c, eta_s, alpha = p["coulomb_coefficient"], p["static_coefficient"], p["stribeck_exponent"]
    v, xi = y[VELOCITY], y[BRISTLE]
    ratio = side * v / p["stribeck_velocity"]
    power = ratio**3 if alpha == 3 else ratio if alpha == 1 else abs(ratio) ** alpha
    deflection = p["normal_load"] / p["bristle_stiffness"] * (eta_c + (eta_s - eta_c) * math.exp(-power))
    xi_rate = v - side * v * xi / deflection
    force = p["bristle_stiffness"] * xi + p["bristle_damping"] * xi_rate + p["viscous_damping"] * v
    return [*accelerated(t, y, p, force), xi_rate]


def accelerated(t: float, y: Sequence[float], p: dict, force: float) -> list[float]:
    sine, cosine, turning = math.sin(y[ANGLE]), math.cos(y[ANGLE]), moment(t, y, p)
    total, rate = p["mass_ratio"] + 1.0, y[ANGLE_RATE]
    inertia = total - cosine * cosine
    return [
        rate,
        (total * turning - sine * cosine * rate * rate - force * cosine) / inertia,
        y[VELOCITY],
        (cosine * turning - sine * rate * rate - force) / inertia,
    ]


def reference_motion(
    parameters: dict, initial: Sequence[float], periods: int, rtol: float = 1e-13, atol: float = 1e-14
) -> ReferenceMotion:
    """The motion from `initial` at time 0 over so many drive periods.

    Raises RuntimeError where the motion cannot be followed for certain (a step that fails, a velocity that leaves a
    switch on the wrong side, more than 1,000 events in one period).
    """
    p = parameters
    exponential = p["law"] == "exponential"
    rates = exponential_rates if exponential else lugre_rates
    limit = p["normal_load"] * p["static_coefficient"]
    period = 2.0 * math.pi / p["frequency"]
    t, y = 0.0, np.array(initial, float)
    if len(y) != (4 if exponential else 5):
        raise ValueError("initial: four numbers for the exponential law, five for LuGre")

    def side_at_rest() -> int:
        """The mode in which a capsule of zero velocity goes on: 0 stuck, +1 or -1."""
        if exponential:
            hold = holding_force(t, y, p)
            return 0 if abs(hold) < limit else int(math.copysign(1, hold))
        return int(math.copysign(1, lugre_rates(t, y, p, 1)[VELOCITY]))

    side = int(np.sign(y[VELOCITY])) or side_at_rest()
    boundaries, events, stuck, stuck_last = [tuple(y.tolist())], [], 0.0, 0.0
    for number in range(1, periods + 1):
        end, stuck_last = number * period, 0.0
        count = len(events)
        while t < end:
            before, was = t, side

            def watched(time: float, state: Sequence[float], side: int = side) -> float:
                """Positive within the mode."""
                return side * state[VELOCITY] if side else limit - abs(holding_force(time, state, p))

            def flow(time: float, state: Sequence[float], side: int = side) -> list[float]:
                return rates(time, state, p, side)

            t, y, switched = until_switch(flow, watched, t, y, end, period / STEPS_PER_PERIOD, rtol, atol)
            if was == 0:
                stuck_last += t - before
            if switched:
                if was == 0:
                    side = int(math.copysign(1, holding_force(t, y, p)))
                else:
                    y[VELOCITY] = 0.0
                    side = side_at_rest()
                kind = REVERSAL if not exponential else {0: STICK, 1: FORWARD, -1: BACK}[side]
                events.append((t, kind))
            if len(events) - count > 1000:
                raise RuntimeError(f"more than 1,000 events in period {number}")
        stuck += stuck_last
        boundaries.append(tuple(y.tolist()))
    return ReferenceMotion(
        final=boundaries[-1],
        at_periods=tuple(boundaries),
        stick_fraction=stuck / (periods * period),
        stick_fraction_last_period=stuck_last / period,
        events=tuple(events),
    )


def until_switch(
    flow: Callable, watched: Callable, t: float, y: np.ndarray, end: float, longest: float, rtol: float, atol: float
) -> tuple[float, np.ndarray, bool]:
    """Moves on in one mode until its switch or `end`. Returns the time, the state and whether it was the switch.

    flow: rates of this mode at a time and state; watched: positive within the mode; longest: of all steps
    """

    def stepper(start: float, state: np.ndarray, bound: float, first: float | None) -> DOP853:
        first = min(first, bound - start) if first else None
        return DOP853(flow, start, state, bound, longest, rtol, atol, first_step=first)

    # A mode starts with the watched quantity at zero, where rounding decides its sign. It counts only once it has been
    # clearly positive; where it turns clearly negative before that, the mode was wrong, and that is an error.
    clear = 1e-13
    armed = watched(t, y) > clear
    solver = stepper(t, y, end, 1e-5)
    while solver.status == "running":
        old_t, old_y = solver.t, solver.y.copy()
        if message := solver.step():
            raise RuntimeError(message)
        path = solver.dense_output()
        times = np.linspace(old_t, solver.t, SAMPLES_PER_STEP + 1)
        values = [watched(old_t, old_y), *(watched(s, path(s)) for s in times[1:-1]), watched(solver.t, solver.y)]
        for k in range(1, len(times)):
            low, high, value = times[k - 1], times[k], values[k]
            if not armed:
                if value < -clear:
                    raise RuntimeError(f"at time {t!r} the mode was left at once, the wrong way")
                armed = value > clear
                continue
            if value > 0.0:
                inside = 1 < k < len(times) - 1 and value < min(values[k - 1], values[k + 1])
                if not inside:
                    continue
                dip = minimize_scalar(
                    lambda s, path=path: watched(s, path(s)), bounds=(low, times[k + 1]), method="bounded"
                )
                if dip.fun > 0.0:
                    continue
                high = float(dip.x)

            def there(time: float, start: float = old_t, state: np.ndarray = old_y) -> np.ndarray:
                if time <= start:
                    return state
                short = stepper(start, state, time, time - start)
                while short.status == "running":
                    if message := short.step():
                        raise RuntimeError(message)
                return short.y

            def value_there(time: float) -> float:
                return watched(time, there(time))

            # The interpolant may misplace the root by its own error: widen the bracket by it, within the step.
            width = 1e-3 * (solver.t - old_t)
            while value_there(low) <= 0.0 and low > old_t:
                low = max(old_t, low - width)
            while value_there(high) > 0.0 and high < solver.t:
                high = min(solver.t, high + width)
            if value_there(high) > 0.0:
                continue  # a root of the interpolant alone, past the step's end: the next step finds it
            if value_there(low) <= 0.0:
                switch = low
            else:
                switch = float(brentq(value_there, low, high, xtol=1e-15, rtol=1e-15))
            return switch, np.array(there(switch)), True
    return end, solver.y, False


FRICTION_OF_THE_PAPER = {
    "normal_load": 1.0,
    "coulomb_coefficient": 0.15,
    "static_coefficient": 0.45,
    "decay_rate": 10.0,
    "bristle_stiffness": 100.0,
    "bristle_damping": 10.0,
    "viscous_damping": 0.0,
    "stribeck_velocity": 0.1,
    "stribeck_exponent": 2.0,
}


def section_4() -> list[tuple[str, float, ReferenceMotion]]:
    """The four motions of docs/model.md."""
    found = []
    for stiffness, damping in ((2.0, 1.0), (4.0, 1.2)):
        for law in ("lugre", "exponential"):
            p = {"law": law, "mass_ratio": 2.5, "stiffness": stiffness, "damping": damping}
            p |= {"amplitude": 1.8, "frequency": 1.0} | FRICTION_OF_THE_PAPER
            start = [math.pi / 3, 0.0, 0.0, 0.0, 0.0026][: 5 if law == "lugre" else 4]
            found.append((law, stiffness, reference_motion(p, start, 40)))
    return found


def main() -> None:
    for law, stiffness, motion in section_4():
        x = [state[POSITION] for state in motion.at_periods]
        print(f"rho {stiffness:g} {law:12s}", *(f"X({k}T) {x[k]:.10f}" for k in (1, 2, 5, 40)), end=" ")
        print(f"drift {x[40] - x[39]:+.10f} stuck {100 * motion.stick_fraction:.4f} %", end=" ")
        print(f"(last period {100 * motion.stick_fraction_last_period:.4f} %)\n    state", *motion.final)


if __name__ == "__main__":
    main()
