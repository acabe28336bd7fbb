"""Claims about the frictional limits, (10)-(15), and Figs 3 and 4."""

import math

import numpy as np

from vibrocap.measures.recorded.limits import OffsetPoints, frictional_limits, steady_friction, steady_slope
from vibrocap.paper.claims.claim import DRAWN, ROUNDING, Finding, Tolerance, claim, decided, restricted
from vibrocap.paper.runs import Runs, imposed_sliding
from vibrocap.physics.friction.bristles import LuGre

VISCOUS = 0.4  # a delta2 for which offset points exist; the paper's own is 0
FIRST_ORDER = Tolerance(0.01, "1 %: the paper offers the formula as an approximation without saying how good")


def _offset(**changes: float) -> OffsetPoints:
    numbers = frictional_limits(LuGre(**changes)).offset
    assert numbers is not None  # the LuGre law has the formulas
    return numbers


def _real(number: float | None) -> float:
    """A number that may not exist, as NaN."""
    return math.nan if number is None else number


@claim(
    "sec. 2.3.3, (10)",
    "Breakaway is a point: the bristles break away, and xi changes sign, when xi = g(X').",
    DRAWN,
    "fig06",
)
def breakaway_point(runs: Runs, tolerance: float) -> Finding:
    """xi/g after a slow slide of 1, 2 and 5 g from rest (exact for constant g); least |xi|/g(0) in Fig. 6."""
    shares = {f"xi/g after a displacement of {k} g": -math.expm1(-k) for k in (1, 2, 5)}
    bristle = runs.steady("lugre")["bristle"]
    at_change = float(np.min(np.abs(bristle))) / _real(frictional_limits(LuGre()).deflection_limit)
    reached = any(share >= 1.0 for share in shares.values())
    return Finding(
        decided(reached and abs(at_change - 1.0) <= tolerance),
        {**shares, "least |xi|/g(0) over a period": at_change},
        "xi approaches g exponentially in displacement and never reaches it at rest speed; it changes sign at xi = 0.",
        nearest="(10) defines g; xi = g exactly where xi' = 0, that is at the extremes of xi.",
    )


@claim("sec. 2.3.3, Fig. 4(b)", "The presliding displacement is linear in the friction force.", DRAWN, "fig08")
def presliding_is_linear(runs: Runs, tolerance: float) -> Finding:
    """Displacement from rest to a share of the breakaway force, g ln[1/(1 - share)], over that of a linear spring."""
    ratio = {f"at {share:g} of breakaway": -math.log1p(-share) / share for share in (0.01, 0.1, 0.5, 0.9)}
    near = abs(ratio["at 0.01 of breakaway"] - 1.0) <= tolerance
    return Finding(
        restricted(all(abs(r - 1.0) <= tolerance for r in ratio.values()), near),
        ratio,
        "The bristles yield from the start, so the spring softens as breakaway comes near.",
        f"forces below {2 * tolerance:.0%} of breakaway",
        "The slope at zero deflection is delta0.",
    )


@claim("sec. 2.3.3, (11)", "Steady friction is N[eta_c + (eta_s - eta_c) exp(-(X'/v_s)^alpha)] + delta2 X'.", ROUNDING)
def steady_sliding(runs: Runs, tolerance: float) -> Finding:
    """(11) as printed against the law at xi' = 0, for X' = 0.1 and X' = -0.1 (delta2 = 0.4)."""
    law = LuGre(viscous_damping=VISCOUS)
    off = {}
    for v in (0.1, -0.1):
        plain = 0.15 + 0.3 * math.exp(-((v / 0.1) ** 2)) + VISCOUS * v
        off[f"(11) less the law at X' = {v:g}"] = plain - steady_friction(law, 1.0, v)
    forward, back = (abs(value) <= tolerance for value in off.values())
    return Finding(
        restricted(forward and back, forward),
        off,
        "Without sgn(X') the printed force pushes a capsule that slides back still further back.",
        "forward sliding",
        "N[...] sgn(X') + delta2 X'.",
    )


@claim("sec. 2.3.3, (12)", "The slope of steady friction is (12).", ROUNDING)
def steady_slope_formula(runs: Runs, tolerance: float) -> Finding:
    """(12) as printed against the slope of (11) by complex step, X' from 0.01 to 0.5 (alpha = 2, delta2 = 0.4)."""
    speeds = np.linspace(0.01, 0.5, 50)
    z = speeds + 1e-30j
    slope = np.imag(0.15 + 0.3 * np.exp(-((z / 0.1) ** 2)) + VISCOUS * z) / 1e-30
    ours = [steady_slope(LuGre(viscous_damping=VISCOUS), 1.0, float(v)) for v in speeds]
    formula = -2.0 * speeds / 0.1**2 * 0.3 * np.exp(-((speeds / 0.1) ** 2)) + VISCOUS
    worst = float(max(np.max(np.abs(slope - formula)), np.max(np.abs(slope - ours))))
    why = "(12) is the derivative of (11) for X' > 0."
    return Finding(decided(worst <= tolerance), {"largest difference": worst}, why)


@claim(
    "sec. 2.3.3, (13), sec. 3",
    "There are two offset points X'_l < X'_h with zero slope of the friction curve (section 3 uses delta2 = 0).",
    ROUNDING,
    "fig08",
)
def offset_points_exist(runs: Runs, tolerance: float) -> Finding:
    """Existence of solutions of (13) for the printed delta2 = 0 and for delta2 = 0.4; the largest such delta2."""
    none, some = _offset(), _offset(viscous_damping=VISCOUS)
    return Finding(
        restricted(none.exist, some.exist),
        {
            "offset points at delta2 = 0": 2.0 * none.exist,
            "X'_l at delta2 = 0.4": _real(some.lower),
            "X'_h at delta2 = 0.4": _real(some.upper),
            "largest delta2": _real(some.greatest_viscous_damping),
        },
        "With the printed delta2 = 0 steady friction falls at every speed: X'_l = 0 and X'_h is at infinity.",
        f"0 < delta2 <= {some.greatest_viscous_damping:.4f}",
        "Exactly, X'_l and X'_h = v_s sqrt(-W(-2/C^2)/2) with both branches of Lambert's W.",
    )


@claim("sec. 2.3.3", "Friction rises with velocity on (0, X'_l) and (X'_h, X'_max) and falls between.", ROUNDING)
def monotone_between_offsets(runs: Runs, tolerance: float) -> Finding:
    """Signs of the slope (12) below, between and above the offset points at delta2 = 0.4; its sign at delta2 = 0."""
    law, points = LuGre(viscous_damping=VISCOUS), _offset(viscous_damping=VISCOUS)
    slopes, ends = {}, (0.0, _real(points.lower), _real(points.upper), 1.0)
    for name, low, high in zip(("below X'_l", "between", "above X'_h"), ends[:-1], ends[1:], strict=True):
        slopes[name] = np.array([steady_slope(law, 1.0, float(v)) for v in np.linspace(low, high, 41)[1:-1]])
    below, between, above = slopes.values()
    rising = bool(np.all(below > 0) and np.all(between < 0) and np.all(above > 0))
    dry = max(steady_slope(LuGre(), 1.0, float(v)) for v in np.linspace(0.001, 0.5, 200))
    return Finding(
        restricted(rising and dry > 0, rising),
        {**{f"mean slope {name}": float(s.mean()) for name, s in slopes.items()}, "largest slope at delta2 = 0": dry},
        "The three stretches are there as soon as viscous friction is; with delta2 = 0 friction only falls.",
        f"0 < delta2 <= {points.greatest_viscous_damping:.4f}",
    )


@claim("sec. 2.3.3, (14)", "(14) gives the lower offset velocity.", FIRST_ORDER)
def lower_offset(runs: Runs, tolerance: float) -> Finding:
    """(14) against the exact root, over delta2: relative error."""
    errors = {}
    for viscous in (0.1, 0.4, 1.0, 2.0, 2.5):
        points = _offset(viscous_damping=viscous)
        errors[f"relative error at delta2 = {viscous:g}"] = _real(points.printed_lower) / _real(points.lower) - 1.0
    grid = np.linspace(0.05, 2.5, 246)
    off = [_offset(viscous_damping=float(d)) for d in grid]
    border = float(grid[int(np.argmax([abs(_real(o.printed_lower) / _real(o.lower) - 1.0) > tolerance for o in off]))])
    small = abs(errors["relative error at delta2 = 0.4"]) <= tolerance
    return Finding(
        restricted(all(abs(e) <= tolerance for e in errors.values()), small),
        {"X'_l exact at 0.4": _real(_offset(viscous_damping=0.4).lower), **errors},
        "(14) leaves out exp(-(X'/v_s)^2), which is near 1 only while X'_l is far below v_s.",
        f"delta2 up to {border:.2f} (to {tolerance:.0%})",
        "X'_l = v_s sqrt(-W_0(-2/C^2)/2).",
    )


@claim("sec. 2.3.3, (15)", "The recursion (15) gives the upper offset velocity.", ROUNDING)
def upper_offset(runs: Runs, tolerance: float) -> Finding:
    """The limit of (15) as printed against the root of (12), for alpha = 2 and alpha = 3 (delta2 = 0.4)."""
    numbers = {}
    for power in (2.0, 3.0):
        points = _offset(viscous_damping=VISCOUS, stribeck_exponent=power)
        numbers[f"slope (12) at the limit of (15), alpha = {power:g}"] = _slope(power, points.printed_upper.value)
        numbers[f"slope (12) at the corrected limit, alpha = {power:g}"] = _slope(power, points.corrected_upper.value)
    gaussian, _, cubic, _ = (abs(value) <= 1e3 * tolerance for value in numbers.values())
    return Finding(
        restricted(gaussian and cubic, gaussian),
        numbers,
        "The printed exponents 1/(alpha - 1) inside and 1/2 outside belong to alpha = 2 alone.",
        "alpha = 2",
        "x_(n+1) = {ln[C x_n^(alpha-1)]}^(1/alpha) with C = alpha N (eta_s - eta_c)/(delta2 v_s).",
    )


def _slope(power: float, velocity: float | None) -> float:
    if velocity is None or velocity <= 0.0:
        return math.nan
    return steady_slope(LuGre(viscous_damping=VISCOUS, stribeck_exponent=power), 1.0, velocity)


@claim(
    "sec. 2.3.3",
    "The higher offset velocity X'_h stays adjacent to the Stribeck velocity v_s.",
    Tolerance(0.5, "of v_s: nothing is printed for 'adjacent'"),
)
def upper_offset_near_stribeck(runs: Runs, tolerance: float) -> Finding:
    """X'_h/v_s over delta2, and the delta2 for which it is 1: C = e, that is 2 N (eta_s - eta_c)/(e v_s)."""
    at_one = 2.0 * 0.3 / (math.e * 0.1)
    dampings = (0.01, 0.4, at_one, 2.57)
    ratio = {f"X'_h/v_s at delta2 = {d:.4g}": _real(_offset(viscous_damping=d).upper) / 0.1 for d in dampings}
    near = [abs(r - 1.0) <= tolerance for r in ratio.values()]
    return Finding(
        restricted(all(near), any(near)),
        ratio,
        "X'_h grows without bound, though slowly, as delta2 goes to zero, the paper's own value.",
        f"delta2 near {at_one:.2f}",
    )


@claim(
    "sec. 2.3.1, Fig. 3",
    "While the velocity oscillates in pure sliding, friction is larger accelerating (AS) than decelerating (DS): a "
    "clockwise loop.",
)
def loop_of_imposed_sliding(runs: Runs, tolerance: float) -> Finding:
    """Mean of R(AS) - R(DS) for an imposed X' = 0.1 + 0.05 sin(tau) under LM, at the printed delta1 = 10 and at 1."""
    gaps = {}
    for damping in (10.0, 1.0):
        loop = imposed_sliding(damping)
        gaps[f"mean R(AS) - R(DS), delta1 = {damping:g}"] = float(np.mean(loop["accelerating"] - loop["decelerating"]))
    printed_value, low = gaps.values()
    return Finding(
        restricted(printed_value > tolerance * 0.3 and low > 0, low > tolerance * 0.3),
        gaps,
        "To first order the gap is (delta1 - delta0 g/v) g' v': above v* = 0.0405 a damping of 10 outweighs the lag.",
        "delta1 of about 1 or less",
    )
