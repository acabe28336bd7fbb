"""Claims about the motion of Figs 5 and 7: time histories and phase planes."""

import math

import numpy as np

from vibrocap.measures.recorded.energy import energy_balance
from vibrocap.measures.recorded.sticking import stick_fraction
from vibrocap.measures.recorded.travel import drift, mean_velocity
from vibrocap.paper.claims.claim import DRAWN, ROUNDING, Finding, Tolerance, claim, decided, restricted
from vibrocap.paper.presets import LAWS, SHORT, law
from vibrocap.paper.runs import Period, Runs
from vibrocap.physics.friction.bristles import LuGre
from vibrocap.physics.friction.law import Law

ALIKE = Tolerance(0.9, "correlation; no digits are printed, and 0.9 still lets the eye see one pattern in two curves")


def both(runs: Runs) -> tuple[Period, Period]:
    """The settled periods of LM and EM."""
    return runs.steady("lugre"), runs.steady("exponential")


def larger(ours: float, theirs: float) -> float:
    """How much larger the first is than the second, relative to the second."""
    return ours / theirs - 1.0


@claim("sec. 3.1, Fig. 5", "LM and EM show similar patterns in theta, theta', X and X'.", ALIKE)
def similar_patterns(runs: Runs, tolerance: float) -> Finding:
    """Correlation of LM with EM over the settled period, X less its drift."""
    lm, em = both(runs)
    curves = {name: (lm[state], em[state]) for name, state in (("theta", "angle"), ("theta'", "angle_rate"))}
    curves |= {"X less drift": (lm.wave, em.wave), "X'": (lm["velocity"], em["velocity"])}
    numbers = {name: float(np.corrcoef(*pair)[0, 1]) for name, pair in curves.items()}
    return Finding(
        decided(min(numbers.values()) >= tolerance),
        numbers,
        "The pendulum, which the drive moves, is all but the same; the laws differ where the capsule turns round.",
    )


@claim("sec. 3.1, Fig. 5(d); sec. 4", "With LM the velocity does not drop to zero completely in the sticking regime.")
def velocity_while_sticking(runs: Runs, tolerance: float) -> Finding:
    """Largest |X'| of LM while EM sticks (settled, same phase of the drive), over LM's peak."""
    lm, em = both(runs)
    stuck = em.motion.at(em.motion.end - em.motion.period + em.time, "side") == 0
    creep = float(np.max(np.abs(lm["velocity"][stuck])) / np.max(np.abs(lm["velocity"])))
    return Finding(
        decided(creep > 1e-3 and stick_fraction(lm.motion, periods=1) is None),
        {
            "largest |X'| of LM while EM sticks / LM's peak": creep,
            "largest |X'| of EM meanwhile": float(np.max(np.abs(em["velocity"][stuck]))),
        },
        "LM has no state of rest: its velocity passes through zero at single instants while the bristles deflect.",
        nearest=f"It stays within {creep:.1%} of its peak there.",
    )


@claim("sec. 3.1, Fig. 5(d)", "The sticking regime has a greater influence on EM than on LM.")
def sticking_stronger_with_em(runs: Runs, tolerance: float) -> Finding:
    """Share of the settled period in which |X'| is below 0.001, and the exact stick fraction of EM."""
    lm, em = both(runs)
    slow = {SHORT[name]: float(np.mean(np.abs(p["velocity"]) < 1e-3)) for name, p in zip(LAWS, (lm, em), strict=True)}
    exact = stick_fraction(em.motion, periods=1)
    assert exact is not None
    return Finding(
        decided(slow["EM"] > slow["LM"] + tolerance),
        {"LM below 0.001": slow["LM"], "EM below 0.001": slow["EM"], "EM at rest": exact},
        "EM rests once per period, LM never.",
    )


@claim("sec. 3.1, Fig. 5(c)", "The displacement is larger with EM than with LM.")
def larger_displacement_with_em(runs: Runs, tolerance: float) -> Finding:
    """X after 40 periods from the printed start and from its mirror image, and the drift of the settled period."""
    numbers = {}
    for name, short in SHORT.items():
        numbers[f"{short}: X(40T)"] = runs.first_set(name).state["position"]
        numbers[f"{short}: X(40T) of the mirror-image solution"] = runs.first_set(name, twin=True).state["position"]
        numbers[f"{short}: settled drift per period"] = drift(runs.steady(name).motion)
    return Finding(
        decided(larger(numbers["EM: X(40T)"], numbers["LM: X(40T)"]) > tolerance),
        numbers,
        "Both settle on a motion without the half-period symmetry, and EM's drifts further.",
        nearest="In size; the start decides the direction: the mirror image travels exactly as far the other way.",
    )


@claim("sec. 3.1, Fig. 5(d)", "The velocity is higher with EM than with LM.")
def higher_velocity_with_em(runs: Runs, tolerance: float) -> Finding:
    """Mean velocity over the last 10 of 200 periods, and the peaks of the settled period, forward and back."""
    lm, em = both(runs)
    numbers, ratio = {}, {}
    for what, value in (
        ("mean velocity", lambda p: mean_velocity(p.motion, periods=10).value),
        ("forward peak", lambda p: float(p["velocity"].max())),
        ("backward peak", lambda p: float(-p["velocity"].min())),
    ):
        numbers[f"LM {what}"], numbers[f"EM {what}"] = value(lm), value(em)
        ratio[what] = larger(value(em), value(lm))
    return Finding(
        restricted(min(ratio.values()) > tolerance, ratio["mean velocity"] > tolerance),
        numbers,
        "EM slides faster on the stroke in the direction of travel and slower on the way back.",
        "the mean velocity and the stroke in the direction of travel",
        "Backwards LM is the faster one.",
    )


@claim("sec. 3.1", "EM travels further because it avoids the energy loss in the hysteretic loop.", DRAWN, "fig05")
def em_avoids_hysteretic_loss(runs: Runs, tolerance: float) -> Finding:
    """Energy lost in the contact per settled period: sliding and bristles."""
    numbers = {}
    for short, period in zip(("LM", "EM"), both(runs), strict=True):
        work = energy_balance(period.motion, periods=1)
        numbers[f"{short}: contact sliding"] = -work.contact_sliding
        numbers[f"{short}: bristle loss"] = -work.bristle_loss
    loss = {short: numbers[f"{short}: contact sliding"] + numbers[f"{short}: bristle loss"] for short in ("LM", "EM")}
    return Finding(
        decided(larger(loss["LM"], loss["EM"]) > tolerance),
        {**numbers, "loss of LM / loss of EM": loss["LM"] / loss["EM"]},
        "EM loses more energy in the contact than LM, bristles included; what EM lacks is not a loss.",
        nearest="Per distance travelled EM loses less, because it travels further per period.",
    )


def _growth(friction: Law, speed: float, inertia: float) -> float:
    """Largest growth rate of a small change of velocity while sliding at a constant speed."""
    step = 1e-6
    slope = (friction.steady_force(speed + step, 1.0) - friction.steady_force(speed - step, 1.0)) / (2 * step)
    if not isinstance(friction, LuGre):
        return -slope / inertia
    g = friction.steady_force(speed, 1.0) / friction.bristle_stiffness
    relaxation, lag = speed / g, speed * slope / (g * friction.bristle_stiffness)
    damping = friction.bristle_damping
    force = np.array([damping * lag, friction.bristle_stiffness - damping * relaxation])
    return float(np.linalg.eigvals(np.array([-force / inertia, [lag, -relaxation]])).real.max())


@claim(
    "sec. 3.1, Figs 5, 6",
    "The negative slope of the friction curve guarantees the stability of the system.",
    ROUNDING,
    "fig05",
)
def negative_slope_stabilises(runs: Runs, tolerance: float) -> Finding:
    """Growth rate of a small change of velocity of the capsule (mass lambda + 1) that slides steadily at X' = 0.1."""
    inertia = runs.steady("lugre").motion.system.machine.mass_ratio + 1.0
    numbers = {f"{short}: growth rate": _growth(law(name), 0.1, inertia) for name, short in SHORT.items()}
    return Finding(
        decided(all(rate < -tolerance for rate in numbers.values())),
        {**numbers, "EM: time to double": math.log(2.0) / numbers["EM: growth rate"]},
        "A force that falls as the capsule speeds up feeds the disturbance: it is the source of stick-slip.",
        nearest="A positive slope, such as viscous damping, stabilises; here the damper of the pendulum does.",
    )
