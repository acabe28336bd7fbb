"""Steers a machine along a path of waypoints by switching its drive, without feedback.

    python examples/steering.py examples/bench-in-si.toml 0.25 0.1 --tolerance 0.005 --out path.toml
    vibrocap simulate path.toml --plot path.png

From one waypoint to the next the drive runs for a whole number of periods, times a factor from -1 to 1 (a negative
factor mirrors the motion), then pauses until the contact sticks. A table of all factors and lengths is one ensemble;
where the error changes sign between two factors, smaller steps locate the factor that ends at the waypoint. The soonest
schedule is confirmed by a certified motion, which also holds its place ten times as long. Positions are in metres if
the case is in SI.
"""

import argparse
import dataclasses
from pathlib import Path

import numpy as np

import vibrocap as vc

LEVELS = 16  # factors of each sign
CUTS = 16  # of a step between two factors, in each of the rounds
ROUNDS = 4
LONGEST = 64  # periods of a burst
MOST_LEGS = 3  # a schedule has seven phases, and a leg takes two
HOLD = 10  # pauses through which the machine has to stay
EVENTS = 1_000_000  # in a schedule, whose whole length is one period of its drive


@dataclasses.dataclass(frozen=True)
class Leg:
    """The schedule from one waypoint to the next: `periods` of the drive times `factor`, then a pause."""

    waypoint: float
    periods: float
    factor: float


def scheduled(system: vc.System, legs: list[Leg], pause: float) -> vc.System:
    """A system whose drive follows the legs."""
    drive = {field.name: getattr(system.drive, field.name) for field in dataclasses.fields(system.drive)}
    phases = [phase for leg in legs for phase in ((leg.periods, leg.factor), (pause, 0.0))]
    phases += [(0.0, 0.0)] * (2 * MOST_LEGS - len(phases))
    for k, (periods, factor) in enumerate(phases, 1):
        drive |= {f"periods_{k}": float(periods), f"factor_{k}": float(factor)}
    return vc.System.of_parts({**system.parts, "drive": vc.scheduled(type(system.drive))(**drive)}, system.units)


def ends(system: vc.System, start: dict, factors: np.ndarray, periods: np.ndarray, pause: float) -> np.ndarray:
    """Positions [runs] at the end of the pause after each burst; NaN where a run failed."""
    one = scheduled(system, [Leg(0.0, 1.0, 1.0)], pause)
    over = {"drive.factor_1": factors, "drive.periods_1": periods}
    runs = vc.ensemble(
        one, over, initial=start, periods=1, window=1, final_states=True, max_events_per_period=EVENTS, tolerance=1e-10
    )
    return np.where(runs["status"] == 0, runs[f"final.{system.cyclic}"], np.nan)


def moved(system: vc.System, start: dict, legs: list[Leg], pause: float) -> vc.Trajectory:
    """The exact motion over a schedule."""
    motion = vc.simulate(
        scheduled(system, legs, pause), initial=start, periods=1, tolerance=1e-12, max_events_per_period=EVENTS
    )
    if not (motion.status.ok and motion.certificate.ok):
        raise SystemExit(f"the motion over the schedule ends early or is not certified: {motion.status.text}")
    return motion


def leg_to(system: vc.System, start: dict, waypoint: float, tolerance: float, pause: float) -> Leg:
    """The soonest leg that ends within the tolerance of a waypoint and stays there; SystemExit where there is none."""
    levels = np.concatenate([-np.linspace(1.0, 1.0 / LEVELS, LEVELS), np.linspace(1.0 / LEVELS, 1.0, LEVELS)])
    lengths = np.arange(1.0, LONGEST + 1.0)
    factors, periods = (grid.ravel() for grid in np.meshgrid(levels, lengths))
    errors = (ends(system, start, factors, periods, pause) - waypoint).reshape(len(lengths), len(levels))
    nearest = np.nanmin(np.abs(errors))
    for length, row in zip(lengths, errors, strict=True):
        for k in np.flatnonzero(row[:-1] * row[1:] <= 0.0):
            low, high = levels[k], levels[k + 1]
            for _ in range(ROUNDS):
                fine = np.linspace(low, high, CUTS + 1)
                error = ends(system, start, fine, np.full(len(fine), length), pause) - waypoint
                best = int(np.nanargmin(np.abs(error)))
                nearest = min(nearest, abs(error[best]))
                leg = Leg(waypoint, length, float(fine[best]))
                if abs(error[best]) <= tolerance and stays(system, start, leg, tolerance, pause):
                    return leg
                signs = np.flatnonzero(error[:-1] * error[1:] <= 0.0)
                if not len(signs):
                    break
                low, high = fine[signs[0]], fine[signs[0] + 1]
    what = f"no burst of at most {LONGEST} periods ends at {waypoint:g} and stays there within {tolerance:g}"
    raise SystemExit(f"{what}; the nearest end is {nearest:.3g} away")


def stays(system: vc.System, start: dict, leg: Leg, tolerance: float, pause: float) -> bool:
    """Whether the exact motion is within the tolerance at the end of the pause, and still after HOLD pauses."""
    places = [moved(system, start, [leg], times * pause).state[system.cyclic] for times in (1, HOLD)]
    return bool(np.all(np.abs(np.array(places) - leg.waypoint) <= tolerance))


def steered(case: vc.Case, waypoints: list[float], tolerance: float, pause: float = 4.0) -> tuple[list[Leg], vc.Case]:
    """The legs along the waypoints, and the case whose drive follows them."""
    if not 1 <= len(waypoints) <= MOST_LEGS:
        raise SystemExit(f"a path has one to {MOST_LEGS} waypoints, got {len(waypoints)}")
    system, state, legs = case.system, dict(case.initial), []
    for waypoint in waypoints:
        legs.append(leg_to(system, state, waypoint, tolerance, pause))
        state = dict(moved(system, state, legs[-1:], pause).state)
    whole = scheduled(system, legs, pause)
    return legs, vc.Case(whole, case.initial, periods=1, tolerance=1e-12, max_events_per_period=EVENTS)


def main(words: list[str] | None = None) -> list[Leg]:
    """Run the command line; the legs."""
    parser = argparse.ArgumentParser(description="Steer a machine along waypoints by switching its drive.")
    parser.add_argument("case", type=Path)
    parser.add_argument("waypoints", type=float, nargs="+", help=f"one to {MOST_LEGS} positions")
    parser.add_argument("--tolerance", type=float, required=True, help="largest error at a waypoint")
    parser.add_argument("--pause", type=float, default=4.0, help="drive periods after each burst")
    parser.add_argument("--out", type=Path, help="a case (.toml) that runs the schedule")
    asked = parser.parse_args(words)
    case = vc.read_case(asked.case)
    legs, path = steered(case, asked.waypoints, asked.tolerance, asked.pause)
    for leg in legs:
        print(f"{leg.factor:+.6f} x {leg.periods:g} periods, then a pause at {leg.waypoint:g}")
    if asked.out:
        path.save(asked.out)
    return legs


if __name__ == "__main__":
    main()
