"""Plausible systems at random, laws x machines x drives, to be run at random tolerances: a seeded table.

`python tests/plausible_cases.py 0 440` runs that many and prints what their balances, states and works are off by, in
tolerances, the latter two against runs at a thousandth of the tolerance.
"""

import dataclasses
import functools
import random
import sys

import numpy as np

import vibrocap as vc
from vibrocap.motion.evidence import BALANCE_BOUND, BALANCE_PER_STEP
from vibrocap.physics.catalogue import law, laws
from vibrocap.physics.friction.law import Law
from vibrocap.physics.parameters import parameter_table

WRAPPED = (
    "anisotropic-stribeck",
    "anisotropic-lugre",
    "backlash-lugre",
    "backlash-bouc-wen",
    "smoothed-exponential",
    "smoothed-stribeck",
    "anisotropic-maxwell-slip",
)
TIGHT = 1e-3  # times the tolerance, but not below LEAST: of the run that is compared with
LEAST = 1e-13
SHIFT = 1e-7  # of the start, over the natural size of the velocity, by which it is seen how errors grow
MOST_STEPS = 300_000


def plausible_law(draw: random.Random) -> Law:
    """A law with every number changed by up to a factor of ten, but for those of which it refuses such values."""
    kind = law(draw.choice((*laws(), *WRAPPED)))
    while True:
        values = {}
        for info in parameter_table(kind):
            value = info.default
            if isinstance(value, float) and info.name in ("coulomb_coefficient", "static_coefficient"):
                values[info.name] = value * draw.uniform(0.5, 1.5)
            elif isinstance(value, float) and "exponent" in info.name:
                values[info.name] = draw.choice((value, 1.0, 2.0, draw.uniform(1.0, 3.0), draw.uniform(3.0, 20.0)))
            elif isinstance(value, float):
                values[info.name] = value * 10.0 ** draw.uniform(-1.0, 1.0) or draw.choice(
                    (0.0, draw.uniform(0.0, 0.3))
                )
        try:
            return kind(**values)
        except ValueError:
            continue


def plausible_case(seed: int) -> tuple[vc.System, dict[str, float], float, int]:
    """(system, start, tolerance, periods) of a number."""
    draw = random.Random(f"plausible {seed}")
    friction = plausible_law(draw)
    if draw.random() < 0.6:
        machine = vc.Oscillator(
            mass=10.0 ** draw.uniform(-1.0, 1.0),
            stiffness=10.0 ** draw.uniform(-1.0, 1.0),
            damping=draw.choice((0.0, 0.05, 0.3)),
            belt_speed=draw.choice((0.0, 0.01, 0.1, 0.3, -0.2)),
            normal_load=draw.choice((0.5, 1.0, 2.0, 10.0)),
        )
        force = machine.normal_load
        start = {
            "position": draw.uniform(-0.5, 0.5) * force / machine.stiffness,
            "sliding_velocity": draw.choice((0.0, draw.uniform(-0.5, 0.5))),
        }
    else:
        machine = vc.PendulumCapsule(
            mass_ratio=10.0 ** draw.uniform(-0.7, 0.9),
            stiffness=draw.uniform(0.5, 4.0),
            damping=draw.uniform(0.1, 1.5),
            normal_load=draw.choice(("weight", 0.3, 1.0, 3.0)),
        )
        force = 1.0
        start = {"angle": draw.uniform(-1.0, 1.0)}
    amplitude, frequency = force * draw.uniform(0.05, 1.5), 10.0 ** draw.uniform(-0.5, 0.5)
    drive = vc.Harmonic(amplitude=amplitude, frequency=frequency)
    if draw.random() < 0.25:
        drive = vc.Biharmonic(amplitude=amplitude, frequency=frequency)
    return vc.System(machine, friction, drive), start, 10.0 ** draw.uniform(-10.0, -4.0), draw.choice((2, 5, 10))


@dataclasses.dataclass(frozen=True)
class Comparison:
    """What a motion is off by, in tolerances: 100 of them are wrong.

    states, works: against a run at a tighter tolerance, over natural sizes and what a shift of the start grows to
    energy, momentum: largest residual of the balance over the run, over the natural size
    """

    number: int
    law: str
    machine: str
    tolerance: float
    status: str
    failures: tuple[str, ...] = ()
    growth: float = 1.0
    states: float = 0.0
    works: float = 0.0
    energy: float = 0.0
    momentum: float = 0.0

    @property
    def worst(self) -> float:
        """The largest of them."""
        return max(self.states, self.works, self.energy, self.momentum)


def compared(number: int) -> Comparison:
    """A plausible motion beside a tighter one."""
    system, start, tolerance, periods = plausible_case(number)
    moving = functools.partial(vc.simulate, system, periods=periods, max_steps=MOST_STEPS)
    motion = moving(initial=start, tolerance=tolerance)
    about = number, system.friction.name, system.machine.name, tolerance
    if not motion.run_status.ok:
        return Comparison(*about, motion.status.value)
    certificate = motion.certificate
    scales = np.array([float(scale) for scale in system.scales()])
    lasting = [i for i, name in enumerate(system.state_names) if name not in system.friction.switched]
    tight = moving(initial=start, tolerance=max(TIGHT * tolerance, LEAST))
    moved = system.machine.contact_states[0]
    aside = start.get(moved, 0.0) + SHIFT * scales[system.state_names.index(moved)]
    shifted = moving(initial={**start, moved: aside}, tolerance=tolerance)
    bounds = {verdict.field: verdict.bound or 0.0 for verdict in certificate.verdicts}
    errors = BALANCE_BOUND + BALANCE_PER_STEP * len(motion.piece_start)
    energy, momentum = (bounds[field] / errors for field in ("energy_residual", "momentum_residual"))
    comparison = Comparison(
        *about,
        motion.status.value,
        certificate.failures,
        energy=certificate.energy_residual / energy,
        momentum=certificate.momentum_residual / momentum,
    )
    if not (tight.run_status.ok and shifted.run_status.ok):
        return comparison

    def apart(one: vc.Trajectory, other: vc.Trajectory) -> float:
        return float(np.max((np.abs(one.sections - other.sections) / scales)[:, lasting]))

    growth = max(1.0, apart(shifted, motion) / SHIFT)
    one, other = (each.integrals([each.end])[:-1, 0] for each in (motion, tight))
    size = max(energy, tolerance * float(np.max(np.abs(other))))
    return dataclasses.replace(
        comparison,
        growth=growth,
        states=apart(motion, tight) / tolerance / growth,
        works=float(np.max(np.abs(one - other))) / size / growth,
    )


def main(first: int, last: int) -> None:
    """Print the table of these numbers, the worst at the end."""
    rows = []
    for number in range(first, last):
        row = compared(number)
        rows.append(row)
        off = (f"{name} {getattr(row, name):8.1e}" for name in ("growth", "states", "works", "energy", "momentum"))
        print(
            f"{row.number:4d} {row.law:30s} {row.machine:18s} {row.tolerance:8.1e} {row.status:16s}",
            *off,
            *row.failures,
            flush=True,
        )
    wrong = [row.number for row in rows if row.status == "finished" and row.worst > 100.0]
    counts = {status: sum(row.status == status for row in rows) for status in sorted({row.status for row in rows})}
    print(f"{len(rows)} motions: {counts}; above 100 tolerances and finished: {wrong or 'none'}")


if __name__ == "__main__":
    main(*map(int, sys.argv[1:3]))
