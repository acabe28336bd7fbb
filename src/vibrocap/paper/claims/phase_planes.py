"""Claims about the phase planes of Fig. 7."""

import math

import numpy as np

from vibrocap.measures.recorded.settling import response_class, settling
from vibrocap.measures.recorded.sticking import stick_phases
from vibrocap.measures.recorded.travel import drift
from vibrocap.motion.trajectory import Trajectory
from vibrocap.paper.claims.claim import RUN_ERROR, Finding, claim, decided, restricted
from vibrocap.paper.claims.vibration import both, larger
from vibrocap.paper.presets import SHORT
from vibrocap.paper.runs import Runs, return_residual


def _cycle(x: np.ndarray, y: np.ndarray) -> dict[str, float]:
    """Sizes of a closed curve; its area by the trapezoidal rule (periodic: spectrally accurate where smooth)."""
    area = float(abs(np.sum(0.5 * (y[1:] + y[:-1]) * np.diff(x))))
    return {"width": float(np.ptp(x)), "height": float(np.ptp(y)), "area": area}


def _compared_cycles(lm: dict[str, float], em: dict[str, float]) -> tuple[dict[str, float], list[float]]:
    numbers = {f"{short} {what}": size[what] for what in lm for short, size in (("LM", lm), ("EM", em))}
    return numbers, [larger(em[what], lm[what]) for what in lm]


@claim("sec. 3.1, Fig. 7(a)", "The limit cycle of the pendulum is larger with EM.")
def larger_cycle_of_pendulum(runs: Runs, tolerance: float) -> Finding:
    """Width, height and area of the settled theta-theta' cycle."""
    lm, em = (_cycle(p["angle"], p["angle_rate"]) for p in both(runs))
    numbers, excess = _compared_cycles(lm, em)
    return Finding(
        decided(max(excess) > tolerance),
        numbers,
        f"The cycles agree to {max(map(abs, excess)):.2%}, less than a drawing shows, and LM's has the larger area.",
        nearest="Equal in every drawing.",
    )


@claim("sec. 3.1, Fig. 7(b)", "The limit cycle of the capsule is larger with EM.")
def larger_cycle_of_capsule(runs: Runs, tolerance: float) -> Finding:
    """Width, height and area of the settled X-X' cycle, X less its drift; largest forward velocity."""
    lm, em = (_cycle(p.wave, p["velocity"]) | {"forward peak": float(p["velocity"].max())} for p in both(runs))
    numbers, excess = _compared_cycles(lm, em)
    return Finding(
        restricted(min(excess) > tolerance, max(excess) > tolerance),
        numbers,
        f"With EM width, height and area grow by {max(excess[:3]):.1%} at most; only the forward peak stands out.",
        "the largest forward velocity",
    )


@claim("sec. 3.1, Fig. 7", "There are steps in the phase planes where the velocity passes zero: a quasi-static phase.")
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
    "sec. 3.1, Fig. 7", "The motion is not strictly periodic: beginning and end of the cycle do not overlap.", RUN_ERROR
)
def not_strictly_periodic(runs: Runs, tolerance: float) -> Finding:
    """Change over the last of 200 periods, of X and of all other states."""
    numbers = {}
    for name, short in SHORT.items():
        motion = runs.steady(name).motion
        numbers[f"{short}: gap in X"] = drift(motion)
        numbers[f"{short}: largest change of the other states"] = return_residual(motion)
    rest = max(value for what, value in numbers.items() if "other" in what)
    return Finding(
        restricted(rest > tolerance, min(abs(numbers["LM: gap in X"]), abs(numbers["EM: gap in X"])) > tolerance),
        numbers,
        "Nothing depends on X; in all other states the motion returns exactly, and the gap in X is the drift.",
        "X, whose gap is the travel of one period",
        "Periodic modulo X, with the period of the drive.",
    )


@claim("sec. 3.1, Fig. 7", "The motions of Fig. 7 are quasi-periodic.", RUN_ERROR)
def quasi_periodic(runs: Runs, tolerance: float) -> Finding:
    """Response class modulo X of the settled motions, and the return residual after one period."""
    motions = {short: runs.steady(name).motion for name, short in SHORT.items()}
    classes = {short: response_class(motion) for short, motion in motions.items()}
    numbers = {f"{short}: period found": float(c.period or 0) for short, c in classes.items()}
    numbers |= {f"{short}: settled since period": _since(motion) for short, motion in motions.items()}
    numbers |= {f"{short}: return residual": return_residual(motion) for short, motion in motions.items()}
    return Finding(
        decided(all(c.kind == "other" for c in classes.values())),
        numbers,
        "A quasi-periodic motion never returns; these return modulo X after one period.",
        nearest="Relative periodic orbits of period 1; LM takes long to settle, which may look like not returning.",
    )


def _since(motion: Trajectory) -> float:
    """Period mark from which on the motion stays within the threshold of its steady motion."""
    since = settling(motion).since
    return math.nan if since is None else float(since)


@claim("sec. 3.1, Fig. 7", "The imperfect overlap is due to the hysteretic characteristic of the friction.")
def gap_from_hysteresis(runs: Runs, tolerance: float) -> Finding:
    """The gap in X per settled period with hysteresis (LM) and without (EM)."""
    lm, em = (abs(p.drift) for p in both(runs))
    return Finding(
        decided(em <= tolerance * lm),
        {"LM: gap": lm, "EM: gap": em},
        "EM has no hysteresis and the larger gap.",
        nearest="The gap is the drift of a motion that has lost the half-period symmetry.",
    )


@claim("sec. 3.1, Fig. 7", "The dynamics stay within finite boundaries.")
def bounded(runs: Runs, tolerance: float) -> Finding:
    """Largest |theta|, |theta'|, |X'| and |X| over the first 40 and over all 200 periods (LM)."""
    long = runs.steady("lugre").motion
    numbers, growth = {}, {}
    for name, symbol in (("angle", "theta"), ("angle_rate", "theta'"), ("velocity", "X'"), ("position", "X")):
        values = np.abs(long.at(long.time, name))
        early = float(values[long.time <= 40 * long.period].max())
        numbers[f"|{symbol}| to 40T"], numbers[f"|{symbol}| to 200T"] = early, float(values.max())
        growth[name] = values.max() / early - 1.0
    rest = all(growth[name] <= tolerance for name in growth if name != "position")
    return Finding(
        restricted(rest and growth["position"] <= tolerance, rest),
        numbers,
        "X grows by the drift in every period; it is cyclic, so that no force bounds it.",
        "theta, theta' and X' (and xi)",
    )
