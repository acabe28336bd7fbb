"""Claims about the friction loops of Fig. 8: their directions, the boundary point M1 and the offset points."""

import numpy as np

from vibrocap.measures.recorded.friction_loop import LoopSide
from vibrocap.measures.recorded.limits import boundary_velocity
from vibrocap.motion.trajectory import Trajectory
from vibrocap.paper.claims.claim import Finding, Tolerance, claim, decided, restricted
from vibrocap.paper.claims.friction import LIMIT, LOW, loop
from vibrocap.paper.presets import law
from vibrocap.paper.runs import Runs

ALMOST = Tolerance(0.05, "5 % of N eta_s: the paper says almost, and two drawn lines part at about 1 %")


def _difference(runs: Runs, direction: str, regime: str, damping: float) -> float:
    side = getattr(loop(runs, bristle_damping=damping), direction)
    branches = getattr(side, regime) if side is not None else None
    return float("nan") if branches is None else branches.mean_difference


def _direction(
    runs: Runs, tolerance: float, direction: str, regime: str, sign: float, why: str, nearest: str = ""
) -> Finding:
    """The direction of one branch pair at the printed delta1 and at 1, against what the paper says."""
    numbers = {
        f"mean |R|(AS) - |R|(DS), {direction}, delta1 = {damping:g}": _difference(runs, direction, regime, damping)
        for damping in (10.0, LOW)
    }
    numbers["v*"] = boundary_velocity(law("lugre")) or float("nan")
    margin = tolerance * 0.3  # of the range of the force, eta_s - eta_c
    at_printed, at_low = (sign * value > margin for value in list(numbers.values())[:2])
    return Finding(restricted(at_printed, at_low), numbers, why, "delta1 of about 1 or less (10 is printed)", nearest)


WAYS = {"forward": "forward", "backward": "back"}  # in words, and as a member of a loop
GAP = "Mean gap between the accelerating and decelerating branch {} M1, {}, at the printed delta1 and at 1."
for _way, _side in WAYS.items():
    claim(
        "sec. 3.1, Fig. 8",
        f"{_way.capitalize()}, in pure sliding, friction is smaller in the DS than in the AS.",
        key=f"{_way}-loop-in-sliding",
        test=GAP.format("beyond", _way),
        direction=_side,
        regime="pure_sliding",
        sign=1.0,
        nearest="The opposite, at delta1 = 10.",
        why="At v*, where delta1 v* = R_steady(v*), the force does not depend on xi; beyond it bristle damping, not "
        "lag, decides and turns the loop round.",
    )(_direction)
for _way, _side in WAYS.items():
    claim(
        "sec. 3.1, Fig. 8",
        f"Near zero velocity, {_way}, friction is smaller in the AS than in the DS.",
        key=f"{_way}-loop-in-presliding",
        test=GAP.format("below", _way),
        direction=_side,
        regime="presliding",
        sign=-1.0,
        why="After a reversal the bristles still push the old way, so the rising branch lies below.",
    )(_direction)


@claim(
    "sec. 3.1, Fig. 8",
    "M1 bounds presliding: from M1 to the terminal point friction is smaller in the DS, below M1 it is reversed.",
)
def order_reverses_at_m1(runs: Runs, tolerance: float) -> Finding:
    """Speeds at which the forward branches cross, beside the speed of M1, at the printed delta1 and at 1."""
    numbers, single = {}, {}
    for damping in (10.0, LOW):
        side = loop(runs, bristle_damping=damping).forward
        assert side is not None
        escape = side.escape.velocity if side.escape else float("nan")
        numbers[f"delta1 = {damping:g}: X' at M1"] = escape
        for i, speed in enumerate(side.crossings, 1):
            numbers[f"delta1 = {damping:g}: crossing {i}"] = speed
        above = [_difference(runs, "forward", regime, damping) for regime in ("presliding", "pure_sliding")]
        single[damping] = above[0] < 0.0 < above[1]
    return Finding(
        restricted(single[10.0], single[LOW]),
        numbers,
        "At delta1 = 10 the branches cross again close to M1, and from there on the order is the other one.",
        "delta1 of about 1 or less (10 is printed)",
        "At delta1 = 1 the branches cross below M1 and keep the printed order up to v*; beyond, they all but coincide.",
    )


@claim("sec. 3.1, Fig. 8", "Around M1 the friction of EM and of LM almost coincide.", ALMOST)
def laws_coincide_at_m1(runs: Runs, tolerance: float) -> Finding:
    """|R(LM) - R(EM)| over N eta_s at M1, forward and back, against the mean of that difference over all speeds."""
    hysteresis, numbers = loop(runs), {}
    for direction, side in (("forward", hysteresis.forward), ("back", hysteresis.back)):
        if side is not None and side.escape is not None:
            point = side.escape
            static = law("exponential").steady_force(abs(point.velocity), 1.0)
            numbers[f"{direction}: X' at M1"] = point.velocity
            numbers[f"{direction}: |R| of LM at M1"] = abs(point.friction)
            numbers[f"{direction}: difference / N eta_s"] = abs(abs(point.friction) - static) / LIMIT
    numbers["forward: X' where LM's rising branch meets EM's curve"] = _meeting(runs)
    gaps = [value for what, value in numbers.items() if "difference" in what]
    return Finding(
        restricted(max(gaps) <= tolerance, min(gaps) <= tolerance),
        numbers,
        "At M1 the bristles carry more than EM's curve: forward the force of LM is above even N eta_s.",
        "one direction",
        "LM's rising branch crosses EM's curve at a somewhat lower speed than that of M1.",
    )


def _meeting(runs: Runs) -> float:
    """Speed at which LM's friction, rising after a reversal to forward, first reaches EM's curve."""
    period = runs.steady("lugre")
    side = period.loop.forward
    assert side is not None
    t = np.linspace(side.excursion[0], side.excursion[1], 20001)
    velocity, force = period.motion.at(t, "velocity"), period.motion.at(t, "friction")
    static = np.array([law("exponential").steady_force(abs(float(v)), 1.0) for v in velocity])
    return float(velocity[int(np.argmax(force >= static))])


@claim(
    "sec. 3.1, Fig. 8",
    "At M1 friction has risen to a level within the maximum of EM, then declines monotonically with growing velocity.",
)
def decline_beyond_m1(runs: Runs, tolerance: float) -> Finding:
    """Accelerating branches beyond M1: largest rise of |R| with speed, over N eta_s, at the printed delta1 and at 1."""
    numbers, right = {}, {}
    for damping in (10.0, LOW):
        loops = loop(runs, bristle_damping=damping)
        motion = runs.steady("lugre", bristle_damping=damping).motion
        rise = max(_largest_rise(motion, side) for side in (loops.forward, loops.back) if side is not None) / LIMIT
        numbers[f"delta1 = {damping:g}: largest rise / N eta_s"] = rise
        numbers[f"delta1 = {damping:g}: largest |R|"] = loops.peak_force
        right[damping] = rise <= tolerance and loops.peak_force <= LIMIT
    return Finding(
        restricted(right[10.0], right[LOW]),
        numbers,
        "At delta1 = 10 the force peaks above N eta_s, then undershoots the Coulomb level and comes back up to it.",
        "delta1 of about 1 or less (10 is printed)",
    )


def _largest_rise(motion: Trajectory, side: LoopSide) -> float:
    """Largest rise of |R| on the way from M1 to the next turning point of the velocity."""
    if side.escape is None:
        return 0.0
    t = np.linspace(side.escape.time, side.excursion[1], 20001)
    speed, force = np.abs(motion.at(t, "velocity")), np.abs(motion.at(t, "friction"))
    turns = np.flatnonzero(np.diff(speed) <= 0.0)
    force = force[: turns[0] + 1] if turns.size else force
    return float(np.max(force - np.minimum.accumulate(force)))


@claim("sec. 3.1, Fig. 8", "The branches end in one terminal point, the largest velocity, where AS and DS overlap.")
def branches_meet_at_the_end(runs: Runs, tolerance: float) -> Finding:
    """|R - R_steady| over N eta_s at the largest forward and backward velocity (LM)."""
    period = runs.steady("lugre")
    v, force = period["velocity"], period["friction"]
    numbers = {}
    for direction, i in (("forward", int(np.argmax(v))), ("back", int(np.argmin(v)))):
        off = abs(force[i]) - law("lugre").steady_force(abs(float(v[i])), 1.0)
        numbers[f"{direction}: |R - R_steady| / N eta_s"] = float(abs(off) / LIMIT)
    return Finding(
        decided(max(numbers.values()) <= tolerance),
        numbers,
        "At these speeds xi settles within a displacement of 0.0015, long before the turning point.",
    )


@claim("sec. 3.1, Fig. 8", "The hysteretic curves have offset points near zero velocity.")
def offset_points_of_the_loop(runs: Runs, tolerance: float) -> Finding:
    """Points of the settled loop with dR/dX' = 0, and how many of them lie below v_s."""
    loops = loop(runs)
    points = [point for side in (loops.forward, loops.back) if side is not None for point in side.offset_points]
    near = [point for point in points if abs(point.velocity) < 0.1]
    return Finding(
        decided(len(near) > 0),
        {
            "points with dR/dX' = 0": len(points),
            "of these below v_s": len(near),
            "least |X'| among them": min((abs(p.velocity) for p in points), default=float("nan")),
        },
        "The loop has them although steady friction at delta2 = 0, by (13), has none: they are made by the lag.",
    )
