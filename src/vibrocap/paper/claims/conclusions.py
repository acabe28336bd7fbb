"""Claims of the abstract and the conclusions: energy, vibration, and which law to prefer."""

import numpy as np

from vibrocap.measures.recorded.energy import energy_balance
from vibrocap.measures.recorded.settling import response_class
from vibrocap.paper.claims.claim import DRAWN, RUN_ERROR, Finding, Outcome, Tolerance, claim, decided, restricted
from vibrocap.paper.claims.vibration import both, larger
from vibrocap.paper.presets import SHORT, figures_5_to_8
from vibrocap.paper.runs import Period, Runs

NONE = Tolerance(0.0, "none: nothing is computed")


def energies(runs: Runs) -> dict[str, dict[str, float]]:
    """Work of the drive and losses per settled period of Figs 5-8, by law."""
    numbers = {}
    for short, period in zip(("LM", "EM"), both(runs), strict=True):
        work = energy_balance(period.motion, periods=1)
        contact = -work.contact_sliding - work.bristle_loss
        numbers[short] = {
            "drive work": work.drive,
            "damper loss": -work.damper,
            "contact loss": contact,
            "residual": work.residual,
            "drive work / distance": work.drive / abs(period.drift),
            "contact loss / distance": contact / abs(period.drift),
        }
    return numbers


def _flat(table: dict[str, dict[str, float]]) -> dict[str, float]:
    return {f"{short}: {what}": value for short, row in table.items() for what, value in row.items()}


@claim("abstract, sec. 4", "The energy requirements favour LM.")
def energy_requirements(runs: Runs, tolerance: float) -> Finding:
    """Work of the drive per settled period, and per distance travelled."""
    table = energies(runs)
    period = larger(table["EM"]["drive work"], table["LM"]["drive work"])
    distance = larger(table["EM"]["drive work / distance"], table["LM"]["drive work / distance"])
    share = table["LM"]["damper loss"] / table["LM"]["drive work"]
    contact = period > 0 and table["EM"]["contact loss"] > table["LM"]["contact loss"]
    return Finding(
        restricted(period > tolerance and distance > 0, contact),
        {**_flat(table), "EM over LM, work per period": period, "EM over LM, work per distance": distance},
        f"{share:.0%} of the work goes into the damper of the pendulum, which moves alike; LM travels less for it.",
        "the contact loss per period",
        f"Per distance travelled EM needs {-distance:.0%} less work.",
    )


@claim("sec. 3.1, Figs 7, 8; sec. 4", "LM loses energy in the hysteretic loop, which EM avoids.", DRAWN, "fig08")
def loss_in_hysteretic_loop(runs: Runs, tolerance: float) -> Finding:
    """Energy lost in the bristles per settled period, over the whole contact loss; oint R dX of both laws."""
    lm, em = both(runs)
    work = energy_balance(lm.motion, periods=1)
    share = work.bristle_loss / (work.bristle_loss + work.contact_sliding)
    areas = [period.loop.displacement_area for period in (lm, em)]
    return Finding(
        restricted(abs(areas[0]) > abs(areas[1]) and share > tolerance, share > tolerance),
        {"LM: loss in bristles / contact loss": share, "LM: oint R dX": areas[0], "EM: oint R dX": areas[1]},
        "The bristles do lose something that EM does not know, a small share; the whole loss is larger with EM.",
        "the damping of the bristles",
    )


def _unrest(period: Period) -> dict[str, float]:
    velocity = period["velocity"][:-1]
    spectrum = np.abs(np.fft.rfft(velocity))[:400] ** 2
    acceleration = np.gradient(period["velocity"], period.time)
    force = period["friction"]
    return {
        "rms X'": float(np.sqrt(np.mean(velocity**2))),
        "rms X''": float(np.sqrt(np.mean(acceleration**2))),
        "harmonics from the second, share": float(np.sum(spectrum[2:]) / np.sum(spectrum[1:])),
        "largest change of force within T/8192": float(np.max(np.abs(np.diff(force)))),
    }


@claim("abstract, sec. 4", "LM quenches the friction-induced vibrations better than EM.", DRAWN, "fig05")
def vibration_quenching(runs: Runs, tolerance: float) -> Finding:
    """Settled period: rms velocity and acceleration, share of higher harmonics, largest sudden change of the force."""
    table = {short: _unrest(period) for short, period in zip(("LM", "EM"), both(runs), strict=True)}
    excess = [larger(table["EM"][what], table["LM"][what]) for what in table["LM"]]
    return Finding(
        restricted(min(excess) > tolerance, max(excess) > tolerance),
        _flat(table),
        "With LM the force has no jumps; the vibration itself is all but the same.",
        "the suddenness of the force",
        f"The rms velocities differ by {max(excess[0], -excess[0]):.1%}.",
    )


@claim("sec. 4", "LM is to be preferred to EM in most of the evaluations.")
def lm_desirable(runs: Runs, tolerance: float) -> Finding:
    """The paper's own criteria, one by one: hysteresis, energy per period and per distance, vibration, travel."""
    table, (lm, em) = energies(runs), both(runs)
    unrest = {"LM": _unrest(lm), "EM": _unrest(em)}
    scores = {
        "hysteresis in the loop": abs(lm.loop.velocity_area) > tolerance * 0.3 * 0.4,
        "less work per period (by 1 %)": larger(table["EM"]["drive work"], table["LM"]["drive work"]) > tolerance,
        "less work per distance": table["LM"]["drive work / distance"] < table["EM"]["drive work / distance"],
        "less rms vibration (by 1 %)": larger(unrest["EM"]["rms X'"], unrest["LM"]["rms X'"]) > tolerance,
        "no sudden change of force": unrest["LM"]["largest change of force within T/8192"] < tolerance,
        "more travel": abs(lm.drift) > abs(em.drift),
    }
    most = sum(scores.values()) > len(scores) / 2
    return Finding(
        restricted(most, any(scores.values())),
        {f"LM wins: {what}": float(wins) for what, wins in scores.items()},
        "LM knows hysteresis and has a force without jumps; in energy and travel it does not come out ahead.",
        "describing hysteresis and a smooth reversal",
    )


@claim("sec. 4", "The models predict periodic responses.", RUN_ERROR, "fig05", "fig09")
def periodic_responses(runs: Runs, tolerance: float) -> Finding:
    """Response class modulo X of the settled motions of Figs 5-8, and the largest return residual over Fig. 9."""
    kinds = {name: response_class(runs.steady(name).motion) for name in SHORT}
    numbers = {f"{SHORT[name]}: period, Figs 5-8": float(kind.period or 0) for name, kind in kinds.items()}
    numbers |= {f"{SHORT[name]}: largest residual, Fig. 9": float(runs.sweep(name).residual.max()) for name in SHORT}
    returns = max(value for key, value in numbers.items() if "residual" in key) <= tolerance
    return Finding(
        decided(all(kind.kind == "period-1" for kind in kinds.values()) and returns),
        numbers,
        "Modulo X every motion settles on the period of the drive, against section 3.1 (quasi-periodic).",
    )


@claim("sec. 1, 2.1", "The pendulum drives the capsule in both directions.", RUN_ERROR, "fig05")
def bidirectional(runs: Runs, tolerance: float) -> Finding:
    """Settled drift per period of Figs 5-8, and that of the mirror-image solution."""
    numbers, mirrored = {}, True
    for name, short in SHORT.items():
        here, there = runs.steady(name).drift, runs.steady(name, twin=True).drift
        numbers[f"{short}: drift"], numbers[f"{short}: drift of the twin"] = here, there
        mirrored &= abs(here + there) <= tolerance
    return Finding(
        decided(mirrored and min(map(abs, numbers.values())) > tolerance),
        numbers,
        "Each travelling motion has a mirror-image solution with the opposite drift; the start decides between them.",
    )


@claim("sec. 3, Figs 5-8", "The parameters of Figs 5-8 are given.")
def parameters_of_figures_5_to_8(runs: Runs, tolerance: float) -> Finding:
    """Settled drift per period (LM) for h = 1.6, 1.8 and 2.0 at omega = 1: h and omega are not printed."""
    numbers = {}
    for amplitude in (1.6, 1.8, 2.0):
        system = figures_5_to_8("lugre").with_parameters({"drive.amplitude": amplitude})
        motion = runs.motion(system, 200)
        numbers[f"h = {amplitude:g}: drift"] = float(motion.sections[-1, 2] - motion.sections[-2, 2])
    return Finding(
        Outcome.UNDECIDED,
        numbers,
        "Neither h nor omega is printed, and the motion depends on them; h = 1.8 and omega = 1 of Figs 9-11 are used.",
    )


@claim("abstract, sec. 1", "The simulations agree well with experimentally observed frictional characteristics.", NONE)
def agreement_with_experiments(runs: Runs, tolerance: float) -> Finding:
    """Nothing: the paper prints no measured numbers to compare with."""
    return Finding(
        Outcome.UNDECIDED,
        {},
        "No measurement is printed, so there is no number to compare with.",
        nearest="Hysteresis below and above breakaway, as experiments report, is in LM and not in EM.",
    )
