"""Claims about the friction force of Figs 6 and 8."""

import math

import numpy as np

from vibrocap.measures.recorded.friction_loop import FrictionLoop
from vibrocap.paper.claims.claim import ROUNDING, Finding, Tolerance, claim, decided, restricted
from vibrocap.paper.claims.vibration import ALIKE, both
from vibrocap.paper.presets import law
from vibrocap.paper.runs import Period, Runs

LOW = 1.0  # a delta1 for which the paper's words about the loops hold
LIMIT = 0.45  # N eta_s


def loop(runs: Runs, friction: str = "lugre", **changes: float) -> FrictionLoop:
    """The friction loop of a settled period of Figs 5-8."""
    return runs.steady(friction, **changes).loop


@claim("sec. 3.1, Fig. 6", "The bristle deflection xi and the friction force f vary alike.", ALIKE)
def bristle_and_force_alike(runs: Runs, tolerance: float) -> Finding:
    """Correlation of xi with f (LM) over the settled period, at the printed delta1 = 10 and at 1."""
    numbers = {}
    for damping in (10.0, LOW):
        period = runs.steady("lugre", bristle_damping=damping)
        numbers[f"correlation, delta1 = {damping:g}"] = float(np.corrcoef(period["bristle"], period["friction"])[0, 1])
        elastic = period.motion.system.parameter("friction.bristle_stiffness") * period["bristle"]
        rest = np.std(period["friction"] - elastic) / np.std(elastic)
        numbers[f"rms of delta1 xi' / rms of delta0 xi, delta1 = {damping:g}"] = float(rest)
    return Finding(
        decided(numbers["correlation, delta1 = 10"] >= tolerance),
        numbers,
        "f = delta0 xi + delta1 xi', and the second term is the smaller one.",
    )


def _strokes(period: Period) -> list[tuple[int, float, float]]:
    """Side, largest speed and largest side * xi of each slide that begins within one settled period."""
    motion, numbers = period.motion, []
    begin = motion.end - 2 * motion.period
    for phase in motion.phases:
        if begin <= phase.start < begin + motion.period and phase.end <= begin + 2 * motion.period - 1e-9:
            t = np.linspace(phase.start, phase.end, 2001)
            bristle, velocity = phase.side * motion.at(t, "bristle"), phase.side * motion.at(t, "velocity")
            numbers.append((phase.side, float(velocity.max()), float(bristle.max())))
    return numbers


@claim(
    "sec. 3.1, Fig. 6(a)",
    "From the onset of sticking xi falls from a level and changes monotonically until the same level in the opposite "
    "direction.",
    Tolerance(0.1, "relative: nothing is printed for 'the same level'"),
)
def bristle_reaches_the_same_level(runs: Runs, tolerance: float) -> Finding:
    """Largest |xi| of each slide of the settled period, the long ones forward and back compared, and the shortest."""
    strokes = _strokes(runs.steady("lugre"))
    forward, back = (max((s for s in strokes if s[0] == side), key=lambda s: s[1])[2] for side in (1, -1))
    shortest = min(strokes, key=lambda s: s[1])[2]
    pair = abs(forward / back - 1.0) <= tolerance
    everywhere = pair and abs(shortest / back - 1.0) <= tolerance
    return Finding(
        restricted(everywhere, pair),
        {
            "longest forward": forward,
            "longest backward": back,
            "shortest slide": shortest,
            "slides per period": len(strokes),
        },
        "Each reversal turns xi round, but how far it comes depends on how long and how fast the slide is.",
        f"the long strokes, within {abs(forward / back - 1.0):.0%}",
        "On the shortest slide xi does not even change sign.",
    )


@claim(
    "sec. 3.1, Fig. 6(a)",
    "In pure sliding |xi| falls while the capsule accelerates (AS) and grows while it decelerates (DS).",
    Tolerance(0.95, "share of the time; 5 % is left for the lag of xi around the turning points"),
)
def bristle_follows_speed(runs: Runs, tolerance: float) -> Finding:
    """Share of the settled period with |X'| beyond M1 in which |xi| and |X'| change in opposite directions."""
    period = runs.steady("lugre")
    boundary = loop(runs).boundary
    speed, bristle = np.abs(period["velocity"]), np.abs(period["bristle"])
    sliding = speed[1:-1] > boundary
    opposite = (np.gradient(speed)[1:-1] * np.gradient(bristle)[1:-1] < 0.0)[sliding]
    return Finding(
        restricted(float(opposite.mean()) >= tolerance, float(opposite.mean()) > 0.5),
        {
            "share of opposite changes": float(opposite.mean()),
            "share of the period in pure sliding": float(sliding.mean()),
        },
        "xi relaxes towards g(X'), which falls with speed, and needs a displacement of some g to follow.",
        "most of pure sliding",
    )


@claim("sec. 3.1, Figs 6(b), 6(c)", "Sharp declines of the friction force mark the onset of the sticking regime.")
def sharp_fall_marks_sticking(runs: Runs, tolerance: float) -> Finding:
    """EM, settled period: jumps of the force by more than 1 % of N eta_s, and how many of them begin a stick."""
    motion = runs.steady("exponential").motion
    events = [event for event in motion.events if event.time > motion.end - motion.period]
    jumps = {}
    for event in events:
        before, after = motion.at([event.time - 1e-9, event.time + 1e-9], "friction")
        if abs(after - before) > tolerance * LIMIT:
            jumps[event.time] = event.kind
    sticking = sum(kind == "stick" for kind in jumps.values())
    return Finding(
        restricted(sticking == len(jumps), sticking > 0),
        {"jumps per period": len(jumps), "of these onsets of sticking": sticking},
        "The force also jumps, and further, where the capsule turns round without resting.",
        f"{sticking} of {len(jumps)} jumps per period",
        "A sharp change marks every reversal of the velocity.",
    )


@claim(
    "sec. 3.1, Fig. 6",
    "Friction rises monotonically while sticking until it reaches the boundary of static friction.",
    Tolerance(1e-7, "a thousand times the tolerance of the runs, 1e-10"),
)
def friction_rises_while_sticking(runs: Runs, tolerance: float) -> Finding:
    """EM, the settled stick: force at both ends, and the largest change against its direction. LM: force at M1."""
    motion = runs.steady("exponential").motion
    stick = [p for p in motion.phases if p.side == 0 and p.end < motion.end - 1e-9][-1]
    force = motion.at(np.linspace(stick.start + 1e-9, stick.end - 1e-12, 2001), "friction")
    direction = np.sign(force[-1] - force[0])
    fall = float(max(0.0, np.max(-direction * np.diff(force))))
    numbers = {"EM: force at the onset": float(force[0]), "EM: force at the end": float(force[-1])}
    numbers["EM: largest fall"], hysteresis = fall, loop(runs)
    for side_name, side in (("forward", hysteresis.forward), ("back", hysteresis.back)):
        numbers[f"LM: force at M1, {side_name}"] = side.escape.friction if side and side.escape else math.nan
    static = fall <= tolerance and abs(abs(force[-1]) - LIMIT) <= tolerance
    lm = [abs(value) for what, value in numbers.items() if what.startswith("LM")]
    return Finding(
        restricted(static and all(abs(force - LIMIT) <= tolerance for force in lm), static),
        numbers,
        "EM's force follows the pendulum, through zero, up to N eta_s; LM's bristles yield at another force each time.",
        "EM",
        f"LM's force rises to M1 as well, but to {min(lm):.3f} one way and {max(lm):.3f} the other.",
    )


@claim("sec. 3.1, Fig. 8", "The friction curve of EM shows no hysteresis.", ROUNDING)
def em_without_hysteresis(runs: Runs, tolerance: float) -> Finding:
    """Largest difference between EM's friction while sliding and (8) at the same velocity; area of its loop."""
    period = runs.steady("exponential")
    speed, force = np.abs(period["velocity"]), period["friction"]
    side = period.motion.at(period.motion.end - period.motion.period + period.time, "side")
    sliding = side != 0
    static = np.array([law("exponential").steady_force(float(v), 1.0) for v in speed[sliding]])
    off = float(np.max(np.abs(force[sliding] - side[sliding] * static)))
    area = loop(runs, "exponential").velocity_area
    return Finding(
        decided(off <= tolerance),
        {"largest difference": off, "oint R dX', EM": area, "oint R dX', LM": loop(runs).velocity_area},
        "EM is a function of velocity.",
    )


@claim("sec. 3.1, Fig. 8", "EM performs oscillations of a relatively higher frequency than LM.")
def higher_frequency_with_em(runs: Runs, tolerance: float) -> Finding:
    """Settled period: reversals, mean frequency rms(X'')/rms(X') and share of the harmonics from the fifth on."""
    numbers = {}
    for short, period in zip(("LM", "EM"), both(runs), strict=True):
        v = period["velocity"][:-1]
        amplitude = np.abs(np.fft.rfft(v - v.mean()))[:400] ** 2
        order = np.arange(amplitude.size)
        numbers[f"{short}: mean frequency / omega"] = float(np.sqrt(np.sum(order**2 * amplitude) / np.sum(amplitude)))
        numbers[f"{short}: share of harmonics >= 5"] = float(np.sum(amplitude[5:]) / np.sum(amplitude))
        side = np.sign(v[np.abs(v) > 1e-9])
        numbers[f"{short}: changes of direction per period"] = int(np.sum(side != np.roll(side, 1)))
    ratio = numbers["EM: mean frequency / omega"] / numbers["LM: mean frequency / omega"]
    return Finding(
        decided(ratio > 1.0 + tolerance),
        {**numbers, "EM / LM": ratio},
        "Both move with the frequency of the drive; LM turns more often and has the higher mean frequency.",
        nearest="The same frequency, that of the drive.",
    )


@claim("sec. 3.1, Fig. 8", "The largest friction force is lower with LM than with EM.")
def lower_peak_with_lm(runs: Runs, tolerance: float) -> Finding:
    """Largest |R| of the settled period, against EM's and against N eta_s; the same at delta1 = 1."""
    numbers = {
        "LM": loop(runs).peak_force,
        "LM, delta1 = 1": loop(runs, bristle_damping=LOW).peak_force,
        "EM": loop(runs, "exponential").peak_force,
        "N eta_s": LIMIT,
    }
    return Finding(
        decided(numbers["LM"] < numbers["EM"] * (1 - tolerance)),
        numbers,
        "delta1 xi' adds to the force of the bristles while they load up, and carries it beyond N eta_s.",
        nearest="It is lower at delta1 = 1.",
    )
