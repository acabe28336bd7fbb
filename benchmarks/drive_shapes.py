"""Which shape of the drive is fastest at equal peak torque: one, two, three and five harmonics; friction smoothed away.

`python -m benchmarks.drive_shapes OUT [EVALUATIONS] [LOAD LAW]` searches the fastest stable design of machine and drive
on four systems (exponential and LuGre friction, constant and dynamic load), and designs on friction smoothed by
tanh(v/0.01), which are then judged by the exact law. It writes OUT.csv and OUT.png; a search that OUT.csv holds is not
made again.
"""

import sys
from pathlib import Path

import numpy as np

import vibrocap as vc

PEAK = 1.0
START = [{"angle": np.pi / 3}]
MACHINE = {
    "machine.mass_ratio": (0.2, 6.0),
    "machine.stiffness": (0.1, 6.0),
    "machine.damping": (0.1, 3.0),
    "drive.frequency": (0.3, 3.0),
}
HARMONICS = (1, 2, 3, 5)
LAWS = {"exponential": vc.Exponential(), "LuGre": vc.LuGre(), "tanh": vc.SmoothedTanh(smoothing_velocity=0.01)}
LOADS = {"constant load": 1.0, "dynamic load": "dynamic"}


def shapes(harmonics: int) -> dict[str, tuple[float, float]]:
    """Bounds of the coefficients; the first sine stays 0, as it only moves the start of the period."""
    found = {"drive.cosine_1": (0.2, 1.6)}
    for n in range(2, harmonics + 1):
        found |= {f"drive.cosine_{n}": (-0.8, 0.8), f"drive.sine_{n}": (-0.8, 0.8)}
    return found


def fastest(law: str, load: str, harmonics: int, evaluations: int, fewer: dict[str, float] | None = None) -> vc.Optimum:
    """The fastest stable design of a system under a drive of so many harmonics within the peak.

    fewer: the best design with fewer harmonics, with which the search begins: so more of them are never worse
    """
    machine = vc.PendulumCapsule(mass_ratio=1.0, stiffness=1.2, damping=1.0, normal_load=LOADS[load])
    system = vc.System(machine, LAWS[law], vc.FourierSeries(cosine_1=1.0))
    subject_to = [f"peak_drive < {PEAK}", *(["least_reaction > 0.1"] if load == "dynamic load" else [])]
    over = MACHINE | shapes(harmonics)
    guesses = [] if fewer is None else [{path: fewer.get(path, 0.0) for path in over}]
    asked = {"subject_to": subject_to, "starts": START, "guesses": guesses, "evaluations": evaluations}
    return vc.optimise(system, over, progress=False, **asked)


def exactly(found: vc.Optimum) -> float:
    """The speed of a smoothed design under the exact law, from the same start; 0 where it does not run."""
    assert found.design is not None
    assert found.orbit is not None
    system = vc.System(found.orbit.system.machine, LAWS["exponential"], found.orbit.system.drive)
    steady = vc.orbit(system, initial=START[0])
    return abs(steady.mean_velocity) if steady.closes and steady.mean_velocity is not None else 0.0


def main(out: str = "drive-shapes", evaluations: int = 10_000, *loads_and_laws: str) -> None:
    """Search what the table lacks, write it line by line, and draw it.

    loads_and_laws: which of them to search, such as "dynamic load" "exponential"; by default all
    """
    table = Path(f"{out}.csv")
    heading = "load,law,harmonics,speed,exact_speed,design"
    lines = table.read_text(encoding="utf-8").splitlines() if table.exists() else [heading]
    done = {tuple(line.split(",")[:3]): line.split(",")[5] for line in lines}
    chosen = set(loads_and_laws)
    for load in LOADS:
        for law in LAWS:
            fewer = None
            for harmonics in HARMONICS:
                known = done.get((load, law, str(harmonics)))
                if known is not None:
                    fewer = _read(known) or fewer
                if known is not None or (chosen and not {load, law} <= chosen):
                    continue
                found = fastest(law, load, harmonics, evaluations, fewer)
                fewer = found.design or fewer  # type: ignore[assignment]
                speed = found.value or 0.0
                judged = exactly(found) if law == "tanh" and found.design else speed
                print(f"{load:14s} {law:12s} {harmonics} harmonics: {speed:.6f}, exactly {judged:.6f}", flush=True)
                design = " ".join(f"{path}={x!r}" for path, x in (found.design or {}).items())
                lines.append(f"{load},{law},{harmonics},{speed!r},{judged!r},{design}")
                table.write_text("\n".join(lines) + "\n", encoding="utf-8")
    rows = [(a, b, int(c), float(d), float(e)) for a, b, c, d, e, _ in (line.split(",") for line in lines[1:])]
    draw(rows, f"{out}.png")


def _read(design: str) -> dict[str, float]:
    """The design of a line of the table."""
    return {path: float(x) for path, _, x in (each.partition("=") for each in design.split())}


def draw(rows: list[tuple[str, str, int, float, float]], path: str) -> None:
    """Speeds over the number of harmonics, a panel for each load."""
    from vibrocap.plotting.colours import BLUE, ORANGE, VERMILION
    from vibrocap.plotting.style import figure, style

    inks = {"exponential": (BLUE, "o", "exponential"), "LuGre": (ORANGE, "s", "LuGre")}
    with style():
        fig, axes = figure(1, 2, size=(7.4, 3.6))
        for ax, load in zip(axes[0], LOADS, strict=True):
            for law, (ink, mark, words) in inks.items():
                own = [row for row in rows if row[:2] == (load, law)]
                ax.plot([r[2] for r in own], [r[3] for r in own], mark + "-", color=ink, label=words)
            own = [row for row in rows if row[:2] == (load, "tanh")]
            ax.plot([r[2] for r in own], [r[3] for r in own], "^:", color=VERMILION, label="tanh(v/0.01), as it says")
            ax.plot([r[2] for r in own], [r[4] for r in own], "v-", color=VERMILION, label="the same, judged exactly")
            ax.set(title=load, xlabel="harmonics of the drive", xticks=HARMONICS, ylim=(0.0, None))
        axes[0, 0].set_ylabel("mean velocity of the fastest stable design")
        fig.legend(*axes[0, 0].get_legend_handles_labels(), loc="outside lower center", ncols=2)
        fig.savefig(path, dpi=150)


if __name__ == "__main__":
    main(*sys.argv[1:2], *(int(each) for each in sys.argv[2:3]), *sys.argv[3:])
