"""An integrator of crawlers with an imposed inner motion that shares nothing with the package.

The equations are typed again from docs/machines.md and docs/friction.md, in the velocity v of the body; the state of
the package is p, the velocity of the common centre, with v = p - mu z' on the two-mass crawler and v = p + mu s',
s = sin(theta), on the pendulum crawler (here z = -s):

    v' = -mu z'' - R/(lambda + 1),     mu = 1/(lambda + 1);     at rest R = -z'' as long as the contact can hold that

Coulomb friction is constant within a slide, so that v is known in closed form; its zeros are bracketed on a fine grid
and polished. Other laws are integrated by DOP853 at 1e-12, each end of a slide polished on a step of its own.

A system is a dict of numbers: machine ("two-mass-crawler" | "pendulum-crawler"), mass_ratio; law ("coulomb" |
"exponential" | "lugre") with its coefficients, forward_ratio and back_ratio on Coulomb's; drive ("biharmonic" |
"three-phase" | "trapezoid") with its numbers. A state is (p,), and (p, xi) with LuGre bristles.
"""

import math

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

GRID = 400  # samples of a stretch between two corners, in which no two events may hide
AT_ONCE = 1e-14  # time in which nothing happens


def segments(p):
    """[(start, end, value, slope, curvature)]: the drive between two corners, as functions of time."""
    if p["drive"] == "biharmonic":
        h, w, h2, psi = p["amplitude"], p["frequency"], p["second_amplitude"], p["second_phase"]
        return [
            (
                0.0,
                2.0 * math.pi / w,
                lambda t: h * np.cos(w * t) + h2 * np.cos(2.0 * w * t + psi),
                lambda t: -h * w * np.sin(w * t) - 2.0 * h2 * w * np.sin(2.0 * w * t + psi),
                lambda t: -h * w * w * np.cos(w * t) - 4.0 * h2 * w * w * np.cos(2.0 * w * t + psi),
            )
        ]
    if p["drive"] == "trapezoid":
        h, period = p["amplitude"], 2.0 * math.pi / p["frequency"]
        rise, hold, fall = (p[name] * period for name in ("rise", "hold", "fall"))
        pieces = [(rise, -h, 2.0 * h / rise, 0.0), (hold, h, 0.0, 0.0), (fall, h, -2.0 * h / fall, 0.0)]
        pieces.append((period - rise - hold - fall, -h, 0.0, 0.0))
    else:
        stroke, first, second, third = (p[name] for name in ("stroke", "first", "second", "third"))
        forward = math.sqrt(2.0 * stroke / (1.0 / first + 1.0 / second))
        back = math.sqrt(2.0 * stroke / (1.0 / third + 1.0 / second))
        pieces = [
            (forward / first, 0.0, 0.0, first),
            ((forward + back) / second, 0.5 * forward**2 / first, forward, -second),
            (back / third, 0.5 * back**2 / third, -back, third),
        ]
    found, start = [], 0.0
    for length, value, slope, curvature in pieces:
        found.append((start, start + length, *_parabola(start, value, slope, curvature)))
        start += length
    return found


def _parabola(start, value, slope, curvature):
    return (
        lambda t: value + slope * (t - start) + 0.5 * curvature * (t - start) ** 2,
        lambda t: slope + curvature * (t - start),
        lambda t: curvature + 0.0 * t,
    )


def displacement(p, value, slope, curvature):
    """(z', z'') as functions of time."""
    if p["machine"] == "two-mass-crawler":
        return slope, curvature
    return (
        lambda t: -np.cos(value(t)) * slope(t),
        lambda t: np.sin(value(t)) * slope(t) ** 2 - np.cos(value(t)) * curvature(t),
    )


def level(p, side, speed):
    """Friction while sliding to a side at a speed."""
    if p["law"] == "coulomb":
        return p["coulomb_coefficient"] * p["forward_ratio" if side > 0 else "back_ratio"]
    drop = p["static_coefficient"] - p["coulomb_coefficient"]
    if p["law"] == "exponential":
        return p["coulomb_coefficient"] + drop * math.exp(-p["decay_rate"] * speed)
    return p["coulomb_coefficient"] + drop * math.exp(-((speed / p["stribeck_velocity"]) ** 2))


def rates(p, bend, side):
    """y' of (v,) or (v, xi), |v| written as side v."""
    total = p["mass_ratio"] + 1.0

    def of(t, y):
        if p["law"] != "lugre":
            return [-(bend(t) + side * level(p, side, side * y[0])) / total]
        v, xi = y
        stiffness, damping = p["bristle_stiffness"], p["bristle_damping"]
        slip = v - stiffness * side * v * xi / level(p, side, side * v)
        return [-(bend(t) + stiffness * xi + damping * slip) / total, slip]

    return of


def period_map(p, state):
    """The state a period later, and how often the contact turned or came to rest."""
    total, y, events = p["mass_ratio"] + 1.0, list(state), 0
    for start, end, *drive in segments(p):
        if end - start <= 0.0:
            continue
        speed, bend = displacement(p, *drive)
        y[0] -= speed(start) / total
        y, more = _segment(p, start, end, y, speed, bend)
        events += more
        y[0] += speed(end) / total
    return np.array(y), events


def _segment(p, t, end, y, speed, bend):
    events, side = 0, int(np.sign(y[0])) if abs(y[0]) > 1e-13 else None
    while True:
        if side is None:
            y = [0.0, *y[1:]]
            side = _from_rest(p, t, y, bend)
        if side == 0:
            t = _released(p, t, end, bend)
            if t >= end:
                return [0.0], events
            side = -1 if bend(t) > 0.0 else 1
        t, y = (_slide_closed if p["law"] == "coulomb" else _slide)(p, t, end, y, side, speed, bend)
        if t >= end:
            return y, events
        events += 1
        side = -side if p["law"] == "lugre" else None


def _from_rest(p, t, y, bend):
    """The side to which a contact at rest goes on, or 0."""
    if p["law"] == "lugre":
        return int(np.sign(rates(p, bend, 1)(t, y)[0]))
    hold, ratios = -bend(t), (p.get("forward_ratio", 1.0), p.get("back_ratio", 1.0))
    if -p["static_coefficient"] * ratios[1] <= hold <= p["static_coefficient"] * ratios[0]:
        return 0
    return int(np.sign(hold))


def _first_zero(function, t, end, skip):
    """The first instant at which a function falls through zero; `end` or more where it does not."""
    times = np.linspace(t, end, GRID)
    values = function(times)
    for i in range(skip, GRID):
        if values[i] < 0.0:
            return t if i == 0 else brentq(function, times[i - 1], times[i], xtol=1e-16, rtol=1e-15)
    return np.inf


def _released(p, t, end, bend):
    ahead = p["static_coefficient"] * p.get("forward_ratio", 1.0)
    behind = p["static_coefficient"] * p.get("back_ratio", 1.0)
    return min(_first_zero(lambda s: ahead + bend(s), t, end, 0), _first_zero(lambda s: behind - bend(s), t, end, 0))


def _slide_closed(p, t, end, y, side, speed, bend):
    """v = v_0 - mu (z' - z'_0) - side k (t - t_0), until it vanishes."""
    total, start, first, begun = p["mass_ratio"] + 1.0, y[0], speed(t), t

    def velocity(s):
        return side * (start - ((speed(s) - first) + side * level(p, side, 0.0) * (s - begun)) / total)

    stop = _first_zero(velocity, t, end, 1)
    return (end, [side * velocity(end)]) if stop >= end else (stop, [0.0])


def _slide(p, t, end, y, side, speed, bend):
    """By DOP853, until the velocity vanishes."""

    def stops(s, state):
        return state[0]

    stops.terminal, stops.direction = True, -side
    options = {"method": "DOP853", "rtol": 1e-12, "atol": 1e-14}
    of = rates(p, bend, side)
    found = solve_ivp(of, (t, end), y, events=stops, **options)
    if found.status == 0:
        return end, found.y[:, -1].tolist()
    stop = float(found.t[-1])  # to the error of the dense output: what is left is gone by the slope there
    there = solve_ivp(of, (t, stop), y, **options).y[:, -1]
    slope = np.array(of(stop, there))
    late = -there[0] / slope[0]
    return stop + late, [0.0, *(there + late * slope)[1:].tolist()]
