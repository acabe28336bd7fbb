"""Which shape of the drive is fastest at equal peak torque: one, two, three and five harmonics; friction smoothed away.

`python -m benchmarks.drive_shapes OUT [LOAD LAW ...]` searches the fastest stable design of machine and drive on four
systems (exponential and LuGre friction, constant and dynamic load), and designs on friction smoothed by tanh(v/0.01),
which are then judged by the exact law. It writes OUT.csv; a search that OUT.csv holds is not made again. The picture of
docs/design.md is drawn from that table by docs/images/drive-shapes.py.
"""

import sys
from pathlib import Path

import numpy as np

import vibrocap as vc

PEAK = 1.0
START = [{"angle": np.pi / 3}]
MACHINE = {"mass_ratio": (0.2, 6.0), "stiffness": (0.1, 6.0), "damping": (0.1, 3.0)}
DRIVE = {"frequency": (0.3, 3.0), "peak": (0.2, PEAK)}
HARMONICS = (1, 2, 3, 5)
HEADING = "load,law,harmonics,speed,exact_speed,design,state,designs,limits"
LAWS = {"exponential": vc.Exponential(), "LuGre": vc.LuGre(), "tanh": vc.SmoothedTanh(smoothing_velocity=0.01)}
LOADS = {"constant load": 1.0, "dynamic load": "dynamic"}
DESIGNS = {"exponential": 15_000, "LuGre": 6_000, "tanh": 6_000}  # for each harmonic
CLOSINGS = 60  # of the refinement of each candidate


def bounds(harmonics: int) -> dict[str, tuple[float, float]]:
    """Bounds of the variables: of the shape the cosines and sines over the first cosine; the first sine is 0."""
    parts = [f"{part}_{n}" for n in range(2, harmonics + 1) for part in ("cosine", "sine")]
    return MACHINE | DRIVE | dict.fromkeys(parts, (-1.0, 1.0))


def parameters(mass_ratio, stiffness, damping, frequency, peak, **shape) -> dict:
    """The parameters of a design: the shape is scaled to its peak exactly."""
    count = 1 + len(shape) // 2
    cosines = [1.0, *(shape[f"cosine_{n}"] for n in range(2, count + 1))]
    sines = [0.0, *(shape[f"sine_{n}"] for n in range(2, count + 1))]
    machine = {"machine.mass_ratio": mass_ratio, "machine.stiffness": stiffness, "machine.damping": damping}
    return machine | {"drive.frequency": frequency} | vc.drive_shape(peak, cosines, sines)


def fastest(
    law: str, load: str, harmonics: int, fewer: dict[str, float] | None = None, state: dict[str, float] | None = None
) -> vc.Optimum:
    """The fastest stable design of a system under a drive of so many harmonics within the peak.

    fewer: the best design with fewer harmonics, with which the search begins; state: a state of its motion, from which
        designs run as well as from START
    """
    machine = vc.PendulumCapsule(mass_ratio=1.0, stiffness=1.2, damping=1.0, normal_load=LOADS[load])
    system = vc.System(machine, LAWS[law], vc.FourierSeries(cosine_1=1.0))
    subject_to = ["least_reaction > 0.1"] if load == "dynamic load" else []
    over = bounds(harmonics)
    guesses = [{name: fewer.get(name, 0.0) for name in over}] if fewer else []
    starts = [*START, state] if state else START
    asked = {"subject_to": subject_to, "starts": starts, "guesses": guesses, "evaluations": DESIGNS[law] * harmonics}
    return vc.optimise(system, over, through=parameters, refinement=CLOSINGS, spread_starts=0, progress=False, **asked)


def exactly(found: vc.Optimum) -> float:
    """The speed of a smoothed design under the exact law, from the start or its smoothed orbit; 0: it lifts off."""
    assert found.orbit is not None
    system = vc.System(found.orbit.system.machine, LAWS["exponential"], found.orbit.system.drive)
    speeds = [0.0]
    for start in (START[0], found.orbit.state):
        motion = vc.simulate(system, initial=start, periods=400)
        if motion.status.ok:
            speeds.append(abs(vc.mean_velocity(motion, periods=100).value))
    return max(speeds)


def main(out: str = "drive-shapes", *loads_and_laws: str) -> None:
    """Search what the table lacks, and write it line by line.

    loads_and_laws: which of them to search, such as "dynamic load" "exponential"; by default all
    """
    table = Path(f"{out}.csv")
    lines = table.read_text(encoding="utf-8").splitlines() if table.exists() else [HEADING]
    done = {tuple(line.split(",")[:3]): line.split(",")[5:7] for line in lines[1:]}
    members = set(loads_and_laws)
    for load, law in ((load, law) for law in LAWS for load in LOADS):
        fewer, state = {}, {}
        for harmonics in HARMONICS:
            known = done.get((load, law, str(harmonics)))
            if known is not None:
                fewer, state = map(_read, known)
            if known is not None or (members and not {load, law} <= members):
                continue
            found = fastest(law, load, harmonics, fewer, state)
            if found.orbit is not None:
                fewer, state = found.design, found.orbit.state  # type: ignore[assignment]
            speed = abs(found.value or 0.0)  # a drive turned about travels the other way
            judged = exactly(found) if law == "tanh" and found.design else speed
            print(f"{load:14s} {law:12s} {harmonics} harmonics: {speed:.6f}, exactly {judged:.6f}", flush=True)
            design, begun = (" ".join(f"{name}={x!r}" for name, x in each.items()) for each in (fewer, state))
            counts = " ".join(f"{number} {what}" for what, number in found.counts.items() if number)
            limits = "; ".join(found.limits).replace(",", "")
            lines.append(f"{load},{law},{harmonics},{speed!r},{judged!r},{design},{begun},{counts},{limits}")
            table.write_text("\n".join(lines) + "\n", encoding="utf-8")


def _read(design: str) -> dict[str, float]:
    """A design, or a state, of a line of the table."""
    return {path: float(x) for path, _, x in (word.partition("=") for word in design.split())}


if __name__ == "__main__":
    main(*sys.argv[1:])
