"""Claims about Figs 10 and 11: velocities and displacements at different mass ratios."""

import numpy as np

from vibrocap.paper.claims.claim import RUN_ERROR, Finding, claim, decided, restricted
from vibrocap.paper.claims.travel import STEADY, ZERO
from vibrocap.paper.presets import DISPLACEMENT_MASS_RATIOS, SHORT, figures_9_to_11
from vibrocap.paper.runs import SWEEP_PERIODS, Runs
from vibrocap.paper.travel import STEADY_WINDOW, averages


@claim(
    "sec. 3.2, Fig. 10",
    "For lambda <= 4.0 (LM) and <= 2.2 (EM) the positive velocities of each period are larger than the negative ones.",
)
def larger_positive_velocities(runs: Runs, tolerance: float) -> Finding:
    """Forward over backward velocity peak up to the border, settled and in the first period: least over lambda."""
    numbers, settled, first = {}, [], []
    for (name, short), border in zip(SHORT.items(), (4.0, 2.2), strict=True):
        sweep = runs.sweep(name)
        peaks = sweep.velocity_peaks[sweep.mass_ratio <= border]
        ratio = peaks[:, 0] / peaks[:, 1]
        settled.append(float(ratio.min()))
        first.append(min(_first_ratio(runs, name, lam) for lam in DISPLACEMENT_MASS_RATIOS if lam <= border))
        numbers[f"{short}: least forward/backward, settled"] = settled[-1]
        numbers[f"{short}: largest forward/backward, settled"] = float(ratio.max())
        numbers[f"{short}: least forward/backward, first period"] = first[-1]
    return Finding(
        restricted(min(settled) > 1 + tolerance, min(first) > 1 + tolerance),
        numbers,
        "The settled velocity is its own mirror image, so that both peaks are equal.",
        "the first period",
        "In the settled motion both peaks are equal.",
    )


def _first_ratio(runs: Runs, friction: str, mass_ratio: float) -> float:
    motion = runs.motion(figures_9_to_11(friction, mass_ratio))
    velocity = motion.at(np.linspace(0.0, motion.period, 4097), "velocity")
    return float(velocity.max()) / float(-velocity.min())


@claim("sec. 3.2, Fig. 10", "The magnitude of the velocity declines as lambda increases.", RUN_ERROR)
def velocity_declines_with_mass(runs: Runs, tolerance: float) -> Finding:
    """Peak velocity of the settled period over lambda: largest rise from one mass ratio to the next, and both ends."""
    numbers = {}
    for name, short in SHORT.items():
        peaks = runs.sweep(name).velocity_peaks[:, 0]
        numbers[f"{short}: largest rise"] = float(np.max(np.diff(peaks)))
        numbers[f"{short}: at 0.01"], numbers[f"{short}: at 8.1"] = float(peaks[0]), float(peaks[-1])
    return Finding(
        decided(max(value for key, value in numbers.items() if "rise" in key) <= tolerance),
        numbers,
        "A heavier capsule answers the same torque with less velocity, in steady motion too.",
    )


@claim("sec. 3.2, Figs 9, 10", "As lambda grows the average speeds drop below zero.", RUN_ERROR)
def averages_drop_below_zero(runs: Runs, tolerance: float) -> Finding:
    """Average velocity at the largest lambda, 8.1, by window."""
    numbers, below = {}, []
    for name, short in SHORT.items():
        for window, curve in averages(runs, name).items():
            numbers[f"{short}, {window}"] = float(curve[-1])
            below.append(curve[-1] < -tolerance)
    return Finding(
        restricted(all(below), any(below)),
        numbers,
        f"Averages from the start over five periods or more are negative there. {STEADY}",
        "transient averages over 5 periods or more",
        ZERO,
    )


@claim(
    "sec. 3.2; sec. 4",
    "The average velocity can be controlled by tuning lambda around O1 = 4.0 (LM) and O2 = 2.2 (EM).",
    RUN_ERROR,
    "fig09",
)
def control_by_mass_ratio(runs: Runs, tolerance: float) -> Finding:
    """Steady mean velocity at mass ratios on both sides of the control points: largest size."""
    numbers = {}
    for (name, short), point in zip(SHORT.items(), (4.0, 2.2), strict=True):
        near = np.abs(runs.sweep(name).mass_ratio - point) <= 1.0
        largest = float(np.max(np.abs(averages(runs, name)[STEADY_WINDOW][near])))
        numbers[f"{short}: largest |steady velocity| within 1 of {point:g}"] = largest
    return Finding(
        decided(min(numbers.values()) > tolerance),
        numbers,
        STEADY,
        nearest="A drive, slope or contact without the symmetry, or a softer spring (rho near 0.6), moves the capsule.",
    )


def _travel(runs: Runs, friction: str) -> dict[float, float]:
    """X after 40 periods at the mass ratios of Fig. 11."""
    motions = {ratio: runs.motion(figures_9_to_11(friction, ratio)) for ratio in DISPLACEMENT_MASS_RATIOS}
    return {ratio: motion.state["position"] for ratio, motion in motions.items()}


@claim(
    "sec. 3.2, Fig. 11", "The travelled distance decreases monotonically with lambda (0.8, 2.0, 4.0), for LM and EM."
)
def distance_decreases_with_mass(runs: Runs, tolerance: float) -> Finding:
    """X after 40 periods at lambda 0.8, 2.0 and 4.0."""
    numbers, good, sizes = {}, [], []
    for name, short in SHORT.items():
        travel = _travel(runs, name)
        numbers |= {f"{short}: X(40T) at {ratio:g}": x for ratio, x in travel.items()}
        values = np.array(list(travel.values()))
        good += [short] if np.all(np.diff(values) < 0.0) else []
        sizes += [short] if np.all(np.diff(np.abs(values)) < 0.0) else []
    return Finding(
        restricted(len(good) == len(SHORT), bool(good)),
        numbers,
        "These are the displacements of a transient, all gained within the first periods; then X only swings.",
        f"{' and '.join(good)}, and its signed displacement" if good else "",
        f"The distance |X| falls with lambda for {', '.join(sizes) or 'neither'}. {ZERO}",
    )


@claim("sec. 3.2, Fig. 11", "The amplitude of the displacement curves falls as lambda increases.", RUN_ERROR)
def swing_falls_with_mass(runs: Runs, tolerance: float) -> Finding:
    """Peak-to-peak X of the settled period over all mass ratios: largest rise, and the values near those of Fig. 11."""
    numbers, rise = {}, []
    for name, short in SHORT.items():
        sweep = runs.sweep(name)
        rise.append(float(np.max(np.diff(sweep.swing))))
        numbers[f"{short}: largest rise"] = rise[-1]
        for ratio in DISPLACEMENT_MASS_RATIOS:
            numbers[f"{short}: swing at {ratio:g}"] = float(np.interp(ratio, sweep.mass_ratio, sweep.swing))
    return Finding(decided(max(rise) <= tolerance), numbers, "The heavier capsule swings less, over the whole range.")


@claim("sec. 3.2, Fig. 11", "The travelled distance declines more with EM than with LM.")
def em_declines_more(runs: Runs, tolerance: float) -> Finding:
    """X(40T) at lambda 0.8 less X(40T) at 4.0, absolute and relative to the value at 0.8."""
    numbers = {}
    for name, short in SHORT.items():
        travel = list(_travel(runs, name).values())
        numbers[f"{short}: decline"] = travel[0] - travel[-1]
        numbers[f"{short}: decline / value at 0.8"] = (travel[0] - travel[-1]) / travel[0]
    return Finding(
        decided(numbers["EM: decline"] > numbers["LM: decline"] * (1 + tolerance)),
        numbers,
        "LM's transient is the longer one: it starts higher and ends lower.",
        nearest="LM declines more.",
    )


@claim("sec. 3.2, Fig. 11", "The capsule keeps travelling at lambda 0.8, 2.0 and 4.0.", RUN_ERROR)
def travel_goes_on(runs: Runs, tolerance: float) -> Finding:
    """Largest change of X over the last of 150 periods, and over their second half, over all mass ratios."""
    numbers = {}
    for name, short in SHORT.items():
        sections = runs.sweep(name).sections
        last, later = (np.abs(sections[:, mark] - sections[:, -1]) for mark in (-2, SWEEP_PERIODS // 2))
        numbers[f"{short}: largest change in the last period"] = float(last.max())
        numbers[f"{short}: largest gain after period {SWEEP_PERIODS // 2}"] = float(later.max())
    return Finding(
        decided(max(value for key, value in numbers.items() if "last" in key) > tolerance),
        numbers,
        STEADY,
        nearest="X comes to swing about a fixed place.",
    )
