"""Claims about travel under variation of the mass ratio: Fig. 9."""

import numpy as np

from vibrocap.paper.claims.claim import RUN_ERROR, Finding, Tolerance, claim, decided, printed, restricted
from vibrocap.paper.presets import SHORT
from vibrocap.paper.runs import Runs
from vibrocap.paper.travel import (
    BOTH,
    PRINTED,
    SOFT,
    STEADY_WINDOW,
    averages,
    in_words,
    meetings,
    printed_range_in_numbers,
    steady_points,
    window_name,
    zeros,
)

TWINS = 9  # mass ratios at which the mirror-image solution is run as well
STEADY = (
    "A settled motion here is its own mirror image under the half-period symmetry, so that its drift is exactly zero; "
    "only the transient moves the capsule."
)
KEYS = {"O1": "lugre", "O2": "exponential", "P1": BOTH, "P2": BOTH}  # whose drift vanishes, or both drift alike
ZERO = "The steady mean velocity is zero at every mass ratio, for both laws."


@claim("sec. 3.2, Fig. 9", "The responses are periodic for all lambda considered.", RUN_ERROR)
def periodic_for_every_mass_ratio(runs: Runs, tolerance: float) -> Finding:
    """Largest change of the state modulo X over the last of 150 periods, over the mass ratios of Fig. 9."""
    numbers = {f"{short}: largest residual": float(runs.sweep(name).residual.max()) for name, short in SHORT.items()}
    numbers |= {"mass ratios": runs.sweep("lugre").mass_ratio.size}
    return Finding(
        decided(max(value for key, value in numbers.items() if "residual" in key) <= tolerance),
        numbers,
        "All have period 1, and return in X as well.",
    )


@claim(
    "sec. 3.2, Fig. 9",
    "In the steady state the capsule progresses from period to period (average velocity not zero).",
    RUN_ERROR,
)
def steady_progress(runs: Runs, tolerance: float) -> Finding:
    """Largest |mean velocity| over the last 10 of 150 periods, over all mass ratios, from the paper's start and from
    random ones; that of the first period, for scale."""
    numbers = {}
    for name, short in SHORT.items():
        curves = averages(runs, name)
        numbers[f"{short}: steady"] = float(np.max(np.abs(curves[STEADY_WINDOW])))
        numbers[f"{short}: steady, from random starts"] = float(np.max(np.abs(runs.random_starts(name))))
        numbers[f"{short}: first period"] = float(np.max(np.abs(curves[window_name(1)])))
    return Finding(
        decided(max(value for key, value in numbers.items() if "steady" in key) > tolerance),
        numbers,
        STEADY,
        nearest="Every velocity of Fig. 9 is the average of a transient and depends on the window it is taken over.",
    )


@claim("sec. 3.2", "The direction of travel is set by lambda.", RUN_ERROR, "fig09")
def direction_set_by_mass_ratio(runs: Runs, tolerance: float) -> Finding:
    """X after 150 periods plus X of the mirror-image solution (started mirrored, half a period later): largest sum."""
    numbers = {}
    for name, short in SHORT.items():
        here = runs.sweep(name, points=TWINS).sections[:, -1]
        there = runs.sweep(name, points=TWINS, twin=True).sections[:, -1]
        numbers[f"{short}: largest |X + X of the twin|"] = float(np.max(np.abs(here + there)))
        numbers[f"{short}: largest |X|"] = float(np.max(np.abs(here)))
    twins = max(value for key, value in numbers.items() if "+" in key) <= tolerance
    return Finding(
        decided(not twins),
        numbers,
        "Each motion has a mirror-image solution, which starts half a period later and travels exactly the other way.",
        nearest="The start chooses the direction.",
    )


def _monotone(runs: Runs, tolerance: float, friction: str) -> Finding:
    """Largest rise of the average velocity above an earlier minimum, over its range, for each averaging window."""
    curves = averages(runs, friction)
    transient = {window: curve for window, curve in curves.items() if window != STEADY_WINDOW}
    rises = {w: float(np.max(c - np.minimum.accumulate(c)) / np.ptp(c)) for w, c in transient.items()}
    good = [window for window, rise in rises.items() if rise <= tolerance]
    steady = float(np.max(np.abs(curves[STEADY_WINDOW])))
    early = runs.sweep(friction).mass_ratio <= 2.5
    falls_early = all(float(np.max(np.diff(curves[window][early]))) <= 0.0 for window in rises)
    return Finding(
        restricted(steady > RUN_ERROR.value and len(good) == len(rises), bool(good)),
        {f"rise / range, {window}": rise for window, rise in rises.items()} | {"largest |steady velocity|": steady},
        "Averages of a transient fall from light capsules to lambda of about 2.5 to 3, then rise towards zero again.",
        in_words(good),
        f"{ZERO} From 0.01 to 2.5 every transient average does fall." if falls_early else ZERO,
    )


for _name, _short in SHORT.items():
    _says = f"The average velocity of {_short} decreases monotonically with lambda on [0.01, 8.1]."
    _key = f"monotone-{_short.lower()}"
    claim("sec. 3.2, Fig. 9; sec. 4", _says, key=_key, friction=_name)(_monotone)


@claim("sec. 3.2, Fig. 9", "The curve of EM has the larger negative slope.", RUN_ERROR)
def em_falls_more_steeply(runs: Runs, tolerance: float) -> Finding:
    """Mean slope of the average velocity over [0.01, 8.1], by window."""
    lm, em = averages(runs, "lugre"), averages(runs, "exponential")
    width = float(np.ptp(runs.sweep("lugre").mass_ratio))
    numbers, steeper = {}, []
    for window in lm:
        slopes = [float((curve[window][-1] - curve[window][0]) / width) for curve in (lm, em)]
        numbers |= {f"LM, {window}": slopes[0], f"EM, {window}": slopes[1]}
        steeper.append(slopes[1] < slopes[0] - 1e-9)
    return Finding(
        restricted(all(steeper), any(steeper)),
        numbers,
        "LM's transient carries a light capsule further, so that its curve falls more steeply in every window.",
        nearest=f"The slope of LM is the larger one. {ZERO}",
    )


def _places(places: dict[str, float]) -> str:
    """Where the mass ratios found lie, in words."""
    values = [value for value in places.values() if np.isfinite(value)]
    return f"at lambda from {min(values):.2f} to {max(values):.2f}" if values else "nowhere"


def _crossing(runs: Runs, tolerance: float, point: str) -> Finding:
    """The verdict on a point: its place by averaging window, in the steady state, and at a soft spring."""
    if KEYS[point] == BOTH:
        windows = {window: places[point == "P2"] for window, places in meetings(runs).items()}
        nearest = f"Transient averages of EM rise above those of LM {_places(windows)}."
    else:
        windows = zeros(runs, KEYS[point])
        nearest = f"Transient averages of {SHORT[KEYS[point]]} vanish {_places(windows)}."
    if point == "P1":
        nearest = "In no window does EM fall below LM: LM is above from the start."
    hits = [window for window, value in windows.items() if abs(value - PRINTED[point]) <= tolerance]
    steady = printed_range_in_numbers(runs, KEYS[point])
    soft = steady_points(runs, SOFT)
    numbers = windows | steady | {f"rho = {SOFT:g}, steady: {point}": soft.at[point], "its error": soft.error[point]}
    law = "drifts of LM and EM are the same" if KEYS[point] == BOTH else f"drift of {SHORT[KEYS[point]]} is nothing"
    low, high = steady["steady: it is nothing from lambda"], steady["steady: it is nothing to lambda"]
    none = f"In the steady state there is no such point: the {law} from lambda = {low:g} to {high:g}."
    if np.isnan(low):
        none = "In the steady state it is not nothing throughout."
    some = f"With a softer spring, rho = {SOFT:g}, there is one, at lambda = {soft.at[point]:.10f}."
    outcome = restricted(len(hits) == len(windows), bool(hits))
    return Finding(outcome, numbers, STEADY, in_words(hits), f"{nearest} {none} {some}")


ZEROS = (
    "First zero of {}'s average velocity over lambda, for each averaging window (none: not a number). In the steady "
    "state: sign changes of the drift, bracketed by settled motions at 82 mass ratios; the same for a soft spring."
)
MEETS = (
    "Where EM's curve {}, for each averaging window (none: not a number). In the steady state: sign changes of the "
    "difference of both drifts, bracketed as for O1; the same for a soft spring."
)
for _point, _says, _number, _test in (
    ("O1", "Control point O1: the average velocity of LM is zero at", "4.0", ZEROS.format("LM")),
    ("O2", "Control point O2: the average velocity of EM is zero at", "2.2", ZEROS.format("EM")),
    ("P1", "Boundary point P1: the curves of LM and EM cross at", "1.18", MEETS.format("falls below LM's")),
    ("P2", "Boundary point P2: the curves of LM and EM cross again at", "4.36", MEETS.format("rises above LM's again")),
):
    _key = f"{_says.partition(' ')[0].lower()}-point-{_point.lower()}"
    _says = f"{_says} lambda = {_number}."
    claim("sec. 3.2, Fig. 9", _says, printed(_number), key=_key, test=_test, point=_point)(_crossing)


def _order(runs: Runs, tolerance: float, low: float, high: float, em_higher: bool) -> Finding:
    """Whether one law is the faster one throughout a range of mass ratios, by window."""
    lm, em = averages(runs, "lugre"), averages(runs, "exponential")
    ratios = runs.sweep("lugre").mass_ratio
    inside = (ratios > low) & (ratios < high)
    numbers, transient = {}, []
    for window in lm:
        gap = (em[window] - lm[window])[inside]
        gap = np.where(np.abs(gap) > 1e-9, gap, 0.0)
        numbers[f"share where EM is higher, {window}"] = float(np.mean(gap > 0))
        transient += [window] if np.all(gap > 0 if em_higher else gap < 0) else []
    return Finding(
        restricted(len(transient) == len(lm), bool(transient)),
        numbers,
        STEADY,
        in_words(transient),
        f"In the steady state they are equal. {ZERO}",
    )


ORDER = Tolerance(1e-9, "ten times the tolerance of the runs: a smaller difference is no difference")


for _key, _says, _low, _high, _higher in (
    ("em-faster-before-p1", "Before P1 (lambda < 1.18) EM is faster than LM.", 0.0, 1.18, True),
    ("em-slower-between", "Between P1 and P2 (1.18 to 4.36) EM is slower than LM.", 1.18, 4.36, False),
    ("em-overtakes-after-p2", "Beyond P2 (4.36 to 8.1) EM overtakes LM, near zero and negative.", 4.36, 9.0, True),
):
    _where = "below 1.18" if _low == 0.0 else "beyond 4.36" if _high > 8.1 else "between 1.18 and 4.36"
    _test = f"Share of the mass ratios {_where} at which EM's average velocity is the higher one, by window."
    _range = {"low": _low, "high": _high, "em_higher": _higher}
    claim("sec. 3.2, Fig. 9", _says, ORDER, key=_key, test=_test, **_range)(_order)


def _signs(runs: Runs, tolerance: float, friction: str, border: float) -> Finding:
    ratios, numbers, exact = runs.sweep(friction).mass_ratio, {}, []
    for window, curve in averages(runs, friction).items():
        curve = np.where(np.abs(curve) > 1e-9, curve, 0.0)
        expected = np.where(ratios < border, 1.0, -1.0)
        numbers[f"share with the printed sign, {window}"] = float(np.mean(np.sign(curve) == expected))
        exact += [window] if np.all(np.sign(curve) == expected) else []
    first_zero = zeros(runs, friction)[window_name(5)]
    return Finding(
        restricted(len(exact) == len(numbers), bool(exact)),
        numbers,
        STEADY,
        in_words(exact),
        f"Averages over the first 5 periods or more change sign at lambda = {first_zero:.2f}. {ZERO}",
    )


for (_name, _short), _border in zip(SHORT.items(), (4.0, 2.2), strict=True):
    _says = f"{_short} travels forward for lambda <= {_border} and backward beyond."
    _test = f"Share of the mass ratios at which {_short}'s average velocity has the printed sign, by window."
    _key, _law = f"signs-of-{_short.lower()}", {"friction": _name, "border": _border}
    claim("sec. 3.2, Fig. 9", _says, ORDER, key=_key, test=_test, **_law)(_signs)
