"""Claims about the motion of Figs 5 and 7: time histories and phase planes."""

import math

import numpy as np

from vibrocap.friction.law import Law
from vibrocap.friction.lugre import LuGre
from vibrocap.measures.energy import energy_balance
from vibrocap.measures.response import response_class
from vibrocap.measures.sticking import stick_fraction, stick_phases
from vibrocap.measures.travel import drift, mean_velocity
from vibrocap.paper.claim import DRAWN, ROUNDING, SETTLED, Finding, Outcome, Tolerance, claim, decided, restricted
from vibrocap.paper.presets import LAWS, SHORT, law
from vibrocap.paper.runs import Period, Runs, return_residual

ALIKE = Tolerance(0.9, "correlation; no digits are printed, and 0.9 still lets the eye see one pattern in two curves")


def both(runs: Runs) -> tuple[Period, Period]:
    """The settled periods of LM and EM."""
    return runs.steady("lugre"), runs.steady("exponential")


def loop_area(x: np.ndarray, y: np.ndarray) -> float:
    """Area enclosed by a closed curve, by the trapezoidal rule (periodic: spectrally accurate where smooth)."""
    return float(abs(np.sum(0.5 * (y[1:] + y[:-1]) * np.diff(x))))


def larger(ours: float, theirs: float) -> float:
    """How much larger the first is than the second, relative to the second."""
    return ours / theirs - 1.0


@claim(
    "sec. 3.1, Fig. 5",
    "LM and EM show similar patterns in theta, theta', X and X'.",
    ALIKE,
    "fig05",
)
def similar_patterns(runs: Runs, tolerance: float) -> Finding:
    """Correlation of LM with EM over the settled period, X less its drift."""
    lm, em = both(runs)
    found = {
        name: float(np.corrcoef(a, b)[0, 1])
        for name, a, b in (
            ("theta", lm["angle"], em["angle"]),
            ("theta'", lm["angle_rate"], em["angle_rate"]),
            ("X less drift", lm.wave, em.wave),
            ("X'", lm["velocity"], em["velocity"]),
        )
    }
    return Finding(
        decided(min(found.values()) >= tolerance),
        found,
        "The pendulum, which the drive moves, is all but the same; the laws differ where the capsule turns round.",
    )


@claim(
    "sec. 3.1, Fig. 5(d); sec. 4",
    "With LM the velocity does not drop to zero completely in the sticking regime.",
    DRAWN,
    "fig05",
)
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


@claim("sec. 3.1, Fig. 5(d)", "The sticking regime has a greater influence on EM than on LM.", DRAWN, "fig05")
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


@claim("sec. 3.1, Fig. 5(c)", "The displacement is larger with EM than with LM.", DRAWN, "fig05")
def larger_displacement_with_em(runs: Runs, tolerance: float) -> Finding:
    """X after 40 periods from the printed start and of its mirror twin, and the drift of the settled period."""
    found = {}
    for name, short in SHORT.items():
        found[f"{short}: X(40T)"] = runs.first_set(name).state["position"]
        found[f"{short}: X(40T) of the mirror twin"] = runs.first_set(name, twin=True).state["position"]
        found[f"{short}: settled drift per period"] = drift(runs.steady(name).motion)
    return Finding(
        decided(larger(found["EM: X(40T)"], found["LM: X(40T)"]) > tolerance),
        found,
        "Both settle on a motion without the half-period symmetry, and EM's drifts further.",
        nearest="In size; the direction belongs to the start: the mirror twin travels exactly as far the other way.",
    )


@claim("sec. 3.1, Fig. 5(d)", "The velocity is higher with EM than with LM.", DRAWN, "fig05")
def higher_velocity_with_em(runs: Runs, tolerance: float) -> Finding:
    """Mean velocity over the last 10 of 200 periods, and the peaks of the settled period, forward and back."""
    lm, em = both(runs)
    found, ratio = {}, {}
    for what, value in (
        ("mean velocity", lambda p: mean_velocity(p.motion, periods=10).value),
        ("forward peak", lambda p: float(p["velocity"].max())),
        ("backward peak", lambda p: float(-p["velocity"].min())),
    ):
        found[f"LM {what}"], found[f"EM {what}"] = value(lm), value(em)
        ratio[what] = larger(value(em), value(lm))
    return Finding(
        restricted(min(ratio.values()) > tolerance, ratio["mean velocity"] > tolerance),
        found,
        "EM slides faster on the stroke in the direction of travel and slower on the way back.",
        "the mean velocity and the stroke in the direction of travel",
        "Backwards LM is the faster one.",
    )


@claim("sec. 3.1", "EM travels further because it avoids the energy loss in the hysteretic loop.", DRAWN, "fig05")
def em_avoids_hysteretic_loss(runs: Runs, tolerance: float) -> Finding:
    """Energy lost in the contact per settled period: sliding and bristles."""
    found = {}
    for short, period in zip(("LM", "EM"), both(runs), strict=True):
        work = energy_balance(period.motion, periods=1)
        found[f"{short}: contact sliding"] = -work.contact_sliding
        found[f"{short}: bristle loss"] = -work.bristle_loss
    loss = {short: found[f"{short}: contact sliding"] + found[f"{short}: bristle loss"] for short in ("LM", "EM")}
    return Finding(
        decided(larger(loss["LM"], loss["EM"]) > tolerance),
        {**found, "loss of LM / loss of EM": loss["LM"] / loss["EM"]},
        "EM loses more energy in the contact than LM, bristles included; what EM lacks is not a loss.",
        nearest="Per distance travelled EM loses less, because it travels further per period.",
    )


def _cycle(period: Period, x: np.ndarray, y: np.ndarray) -> dict[str, float]:
    return {"width": float(np.ptp(x)), "height": float(np.ptp(y)), "area": loop_area(x, y)}


def _compared_cycles(lm: dict[str, float], em: dict[str, float]) -> tuple[dict[str, float], list[float]]:
    found = {f"{short} {what}": size[what] for what in lm for short, size in (("LM", lm), ("EM", em))}
    return found, [larger(em[what], lm[what]) for what in lm]


@claim("sec. 3.1, Fig. 7(a)", "The limit cycle of the pendulum is larger with EM.", DRAWN, "fig07")
def larger_cycle_of_pendulum(runs: Runs, tolerance: float) -> Finding:
    """Width, height and area of the settled theta-theta' cycle."""
    lm, em = (_cycle(p, p["angle"], p["angle_rate"]) for p in both(runs))
    found, excess = _compared_cycles(lm, em)
    return Finding(
        decided(max(excess) > tolerance),
        found,
        f"The cycles agree to {max(map(abs, excess)):.2%}, less than a drawing shows, and LM's has the larger area.",
        nearest="Equal in every drawing.",
    )


@claim("sec. 3.1, Fig. 7(b)", "The limit cycle of the capsule is larger with EM.", DRAWN, "fig07")
def larger_cycle_of_capsule(runs: Runs, tolerance: float) -> Finding:
    """Width, height and area of the settled X-X' cycle, X less its drift; largest forward velocity."""
    lm, em = (_cycle(p, p.wave, p["velocity"]) | {"forward peak": float(p["velocity"].max())} for p in both(runs))
    found, excess = _compared_cycles(lm, em)
    return Finding(
        restricted(min(excess) > tolerance, max(excess) > tolerance),
        found,
        f"With EM width, height and area grow by {max(excess[:3]):.1%} at most; only the forward peak stands out.",
        "the largest forward velocity",
    )


@claim(
    "sec. 3.1, Fig. 7",
    "There are steps in the phase planes where the velocity passes zero: a quasi-static phase.",
    DRAWN,
    "fig07",
)
def steps_at_zero_velocity(runs: Runs, tolerance: float) -> Finding:
    """EM, settled period: how often the velocity comes to zero, and how often the capsule rests there."""
    em = runs.steady("exponential").motion
    begin = em.end - em.period
    arrivals = [event for event in em.events if event.time > begin and event.kind in ("stick", "reversal")]
    rests = stick_phases(em, periods=1)
    assert rests is not None
    return Finding(
        restricted(rests.number == len(arrivals), rests.number > 0),
        {"arrivals at zero": len(arrivals), "rests": rests.number, "length of the rest / T": rests.longest / em.period},
        "At the other arrivals the force needed to stop exceeds N eta_s and the capsule turns at once.",
        f"{rests.number} of the {len(arrivals)} passages per period",
    )


@claim(
    "sec. 3.1, Fig. 7",
    "The motion is not strictly periodic: beginning and end of the cycle do not overlap.",
    SETTLED,
    "fig07",
)
def not_strictly_periodic(runs: Runs, tolerance: float) -> Finding:
    """Change over the last of 200 periods, of X and of all other states."""
    found = {}
    for name, short in SHORT.items():
        motion = runs.steady(name).motion
        found[f"{short}: gap in X"] = drift(motion)
        found[f"{short}: largest change of the other states"] = return_residual(motion)
    rest = max(value for what, value in found.items() if "other" in what)
    return Finding(
        restricted(rest > tolerance, min(abs(found["LM: gap in X"]), abs(found["EM: gap in X"])) > tolerance),
        found,
        "Nothing depends on X; in all other states the motion returns exactly, and the gap in X is the drift.",
        "X, whose gap is the travel of one period",
        "Periodic modulo X, with the period of the drive.",
    )


@claim("sec. 3.1, Fig. 7", "The motions of Fig. 7 are quasi-periodic.", SETTLED, "fig07")
def quasi_periodic(runs: Runs, tolerance: float) -> Finding:
    """Response class modulo X of the settled motions, and the return residual after one period."""
    classes = {short: response_class(runs.steady(name).motion) for name, short in SHORT.items()}
    return Finding(
        decided(all(c.kind == "other" for c in classes.values())),
        {
            **{f"{short}: period found": float(c.period or 0) for short, c in classes.items()},
            **{f"{short}: return residual": return_residual(runs.steady(name).motion) for name, short in SHORT.items()},
        },
        "A quasi-periodic motion never returns; these return modulo X after one period.",
        nearest="Relative periodic orbits of period 1; LM takes some 60 periods to settle on its own to eight digits.",
    )


@claim(
    "sec. 3.1, Fig. 7", "The imperfect overlap is due to the hysteretic characteristic of the friction.", DRAWN, "fig07"
)
def gap_from_hysteresis(runs: Runs, tolerance: float) -> Finding:
    """The gap in X per settled period with hysteresis (LM) and without (EM)."""
    lm, em = (abs(p.drift) for p in both(runs))
    return Finding(
        decided(em <= tolerance * lm),
        {"LM: gap": lm, "EM: gap": em},
        "EM has no hysteresis and the larger gap.",
        nearest="The gap is the drift of a motion that has lost the half-period symmetry.",
    )


@claim("sec. 3.1, Fig. 7", "The dynamics stay within finite boundaries.", DRAWN, "fig07")
def bounded(runs: Runs, tolerance: float) -> Finding:
    """Largest |theta|, |theta'|, |X'| and |X| over the first 40 and over all 200 periods (LM)."""
    long = runs.steady("lugre").motion
    found, growth = {}, {}
    for name, symbol in (("angle", "theta"), ("angle_rate", "theta'"), ("velocity", "X'"), ("position", "X")):
        values = np.abs(long.at(long.time, name))
        early = float(values[long.time <= 40 * long.period].max())
        found[f"|{symbol}| to 40T"], found[f"|{symbol}| to 200T"] = early, float(values.max())
        growth[name] = values.max() / early - 1.0
    rest = all(growth[name] <= tolerance for name in growth if name != "position")
    return Finding(
        restricted(rest and growth["position"] <= tolerance, rest),
        found,
        "X grows by the drift in every period; it is cyclic, so that no force bounds it.",
        "theta, theta' and X' (and xi)",
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
    found = {f"{short}: growth rate": _growth(law(name), 0.1, inertia) for name, short in SHORT.items()}
    stable = all(rate < -tolerance for rate in found.values())
    return Finding(
        Outcome.HOLDS if stable else Outcome.FAILS,
        {**found, "EM: time to double": math.log(2.0) / found["EM: growth rate"]},
        "A force that falls as the capsule speeds up feeds the disturbance: it is the source of stick-slip.",
        nearest="A positive slope, such as viscous damping, stabilises; here the damper of the pendulum does.",
    )
