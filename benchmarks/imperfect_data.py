"""Fits of imperfect data: do the intervals hold, and if not, is it said what is wrong?

`python -m benchmarks.imperfect_data [records]` simulates LuGre contacts (100 of each kind take about 10 minutes on one
core), fits each from its data alone, and prints for each kind of data how many intervals of parameters that are called
determined hold the truth, and how many summaries say that something is wrong with the data or the law. Seeded: the same
table each time.
"""

import dataclasses
import sys
import time
from typing import Any

import numpy as np

from vibrocap.identification.experiments.experiment_design import Motion, joined, multisine, ramp, sinusoid
from vibrocap.identification.fit import fit
from vibrocap.laboratory.driven import driven_force
from vibrocap.physics import catalogue
from vibrocap.physics.friction.bristles import LuGre
from vibrocap.records.record import Record

CONTACT = LuGre(
    bristle_stiffness=2e5,  # N/m, with levels in N: breakaway after 30 um
    bristle_damping=300.0,
    viscous_damping=5.0,
    coulomb_coefficient=4.0,
    static_coefficient=6.0,
    stribeck_velocity=0.01,
)
NOISE = 0.02  # of the force's standard deviation
MEMORY = 0.9  # correlation of neighbouring errors of coloured noise
ENCODER = 1e-6  # m
SKEW = 1.1  # level backward over that forward
KINDS = ("white", "coloured", "growing", "delayed", "quantised", "asymmetric")


def motion() -> Motion:
    """Presliding loops, slides and a sweep of speed, 2,000 samples."""
    parts = [
        sinusoid(4e-5, 2.0, 2, 300),
        sinusoid(2e-4, 5.0, 5, 400),
        ramp(0.06, 3.0, 500),
        multisine(0.005, [1.0, 3.1], 800),
    ]
    uneven = joined(parts, "all of it")
    even = np.linspace(0.0, uneven.time[-1], 2000)
    return Motion("all of it", even, np.interp(even, uneven.time, uneven.velocity))


def record(kind: str, seed: int) -> Record:
    """The record of one kind with its own noise."""
    imposed = motion()
    contact = CONTACT
    if kind == "asymmetric":
        values = {field.name: getattr(CONTACT, field.name) for field in dataclasses.fields(CONTACT)}
        contact = catalogue.law("anisotropic-lugre")(**values, back_ratio=SKEW)
    fine = np.linspace(imposed.time[0], imposed.time[-1], 2 * len(imposed.time) - 1)
    force = driven_force(contact, fine, np.interp(fine, imposed.time, imposed.velocity)).force
    late = np.concatenate([force[:1], force[1::2]])  # half a sample
    force = late if kind == "delayed" else force[::2]
    rng = np.random.default_rng(seed)
    noise = rng.standard_normal(len(imposed.time))
    if kind == "coloured":
        for i in range(1, len(noise)):
            noise[i] = MEMORY * noise[i - 1] + (1 - MEMORY**2) ** 0.5 * noise[i]
    if kind == "growing":
        speed = np.abs(imposed.velocity)
        noise = noise * (0.2 + 3 * speed / speed.max())
    force = force + NOISE * np.std(force) * noise
    if kind == "quantised":
        place = ENCODER * np.round((imposed.displacement + 0.3 * ENCODER * seed) / ENCODER)
        return Record(kind, imposed.time, force, displacement=place)
    return Record(kind, imposed.time, force, velocity=imposed.velocity)


def rates(kind: str, count: int, first_seed: int = 0, law: Any = "lugre", **settings: Any) -> dict[str, Any]:
    """What `count` fits of one kind of data say.

    inside: by parameter whether each interval that is called determined holds; doubted: how many summaries say that
    data or law are wrong; silent: how many say nothing though one of their intervals misses; told: findings by kind
    """
    inside: dict[str, list[bool]] = {}
    table: dict[str, int] = {}
    doubted = silent = 0
    settings = {"starts": 2, "start": "relaxed", "intervals": "covariance", **settings}
    for seed in range(first_seed, first_seed + count):
        fitted = fit(record(kind, seed), law, seed=seed, **settings)
        assert fitted.residuals is not None
        doubted += fitted.residuals.doubtful
        held = {name: getattr(CONTACT, name) in fitted[name] for name in fitted.free if fitted[name].determined}
        silent += not (all(held.values()) or fitted.residuals.doubtful)
        for name, holds in held.items():
            inside.setdefault(name, []).append(holds)
        for each in fitted.residuals.kinds:
            table[each] = table.get(each, 0) + 1
    return {"inside": inside, "doubted": doubted, "silent": silent, "told": table}


def report(count: int = 100) -> None:
    """The table, kind by kind."""
    print(f"{count} records of each kind; per parameter: intervals that hold the truth, of those called determined")
    for kind in KINDS:
        begin = time.perf_counter()
        found = rates(kind, count)
        parts = [f"{name} {sum(held)}/{len(held)}" for name, held in found["inside"].items()]
        print(
            f"{kind:11s} doubted {found['doubted']:3d}   misses without doubt {found['silent']:3d}   {', '.join(parts)}"
        )
        print(f"{'':11s} told: {found['told']}   {time.perf_counter() - begin:.0f} s", flush=True)


if __name__ == "__main__":
    report(int(sys.argv[1]) if len(sys.argv) > 1 else 100)
