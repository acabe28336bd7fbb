"""Records with one fault each: is it named, and no other? And is nothing named where there is none?

`python -m benchmarks.faulty_records [records] [largest]` makes that many records of each kind, of 1,000 samples up to
the largest number (a million), each of a law, numbers, motion, noise and size of the fault drawn at random, fits them
and prints how many diagnoses name the fault and no other. Seeded: the same table each time.
"""

import dataclasses
import sys
import time as clock
from collections.abc import Callable
from typing import Any

import numpy as np

from vibrocap.identification.fit import fit
from vibrocap.identification.inference.diagnosis import diagnosis
from vibrocap.identification.inference.errors import RecordErrors
from vibrocap.identification.inference.patterns import basis_of, without
from vibrocap.laboratory.driven import driven_force
from vibrocap.physics import catalogue
from vibrocap.physics.friction.law import Law
from vibrocap.records.record import Record

LAWS = ("exponential", "stribeck", "hyperbolic-stribeck", "dahl", "lugre")
EFFECT = (0.7, 8.0)  # root mean square of a fault's effect on the force, over the noise
STEP = 1e-4
PARAMETERS = (
    "coulomb_coefficient",
    "static_coefficient",
    "stribeck_velocity",
    "decay_rate",
    "viscous_damping",
    "bristle_stiffness",
    "bristle_damping",
)
FAULTS = {  # kind of record: what is to be named
    "white": "", "coloured": "", "growing": "", "fine encoder": "",
    "late": "delay", "early": "delay", "clipped": "saturation", "quantised position": "quantisation",
    "quantised velocity": "quantisation", "ripple": "ripple", "ripple of friction": "ripple",
    "wear": "drift", "drift of the zero": "drift", "glitches": "outliers",
    "inertia": "inertia", "spring": "restoring", "asymmetric": "direction",
}  # fmt: skip


@dataclasses.dataclass(frozen=True, eq=False)
class Bench:
    """A contact under a motion: velocity etc. are functions of time; noise: N; mass: kg, which the sensor carries."""

    law: Law
    time: np.ndarray
    amplitudes: np.ndarray
    frequencies: np.ndarray
    phases: np.ndarray
    mass: float
    noise: float

    def motion(self, time: np.ndarray, derivative: int) -> np.ndarray:
        """Displacement (0), velocity (1) or acceleration (2) [n]."""
        omega = 2 * np.pi * self.frequencies
        like = np.zeros_like(time)
        for a, w, phase in zip(self.amplitudes, omega, self.phases, strict=True):
            like += a * w**derivative * np.sin(w * time + phase + 0.5 * np.pi * derivative)
        return like

    def force(self, time: np.ndarray) -> np.ndarray:
        """What the sensor shows without noise at times that may be shifted."""
        found = driven_force(self.law, self.time, self.motion(time, 1)).force
        return found + self.mass * self.motion(time, 2)


def bench(seed: int, largest: int = 1_000_000, laws: tuple[str, ...] = LAWS) -> tuple[Bench, np.random.Generator]:
    """A contact, a motion and a level of noise, drawn at random."""
    rng = np.random.default_rng(seed)

    def between(low: float, high: float) -> float:
        return float(np.exp(rng.uniform(np.log(low), np.log(high))))

    count = round(between(1_000, largest))
    base = between(0.2, 5.0)
    span = between(4.0, min(30.0, count / 100)) / base
    number = int(rng.integers(1, 5))
    frequencies = base * np.cumprod([1.0, *rng.uniform(1.3, 2.2, number - 1)])
    amplitudes = between(1e-3, 0.05) * np.cumprod([1.0, *rng.uniform(0.2, 0.6, number - 1)])
    reach, fastest = float(np.sum(amplitudes)), float(np.sum(2 * np.pi * frequencies * amplitudes))
    level = between(1.0, 100.0)
    kind = catalogue.law(laws[int(rng.integers(len(laws)))])
    slow = between(0.03, 0.3) * fastest
    all_values = {
        "coulomb_coefficient": level,
        "static_coefficient": level * rng.uniform(1.1, 1.8),
        "stribeck_velocity": slow,
        "decay_rate": 1.0 / slow,
        "viscous_damping": level / fastest * rng.uniform(0.05, 0.5),
        "bristle_stiffness": level / (reach * between(0.01, 0.1)),
        "bristle_damping": level / fastest * rng.uniform(0.05, 0.5),
    }
    law = kind(**{name: value for name, value in all_values.items() if hasattr(kind(), name)})
    time = np.linspace(0.0, span, count)
    phases = rng.uniform(0, 2 * np.pi, number)
    made = Bench(law, time, amplitudes, frequencies, phases, 0.0, 0.0)
    if rng.random() < 0.3:
        mass = rng.uniform(0.1, 0.6) * level / float(np.max(np.abs(made.motion(time, 2))))
        made = dataclasses.replace(made, mass=mass)
    return dataclasses.replace(made, noise=between(0.01, 0.05) * float(np.std(made.force(time)))), rng


def coloured(rng: np.random.Generator, count: int, memory: float) -> np.ndarray:
    """Noise of unit size of which neighbouring samples are correlated."""
    from scipy.signal import lfilter

    white = rng.standard_normal(count + 200)
    return lfilter([(1 - memory**2) ** 0.5], [1.0, -memory], white)[200:]


def faulty(kind: str, seed: int, largest: int = 1_000_000, laws: tuple[str, ...] = LAWS) -> tuple[Bench, Record]:
    """A record of one kind, and the bench that it was made on."""
    made, rng = bench(seed, largest, laws)
    if kind in ("inertia", "spring"):  # a mass that is searched would take it
        made = dataclasses.replace(made, mass=0.0)
    time, count = made.time, len(made.time)
    place, velocity, acceleration = (made.motion(time, derivative) for derivative in range(3))
    clean = made.force(time)
    effect = float(np.exp(rng.uniform(*np.log(EFFECT)))) * made.noise
    noise = made.noise * rng.standard_normal(count)
    path = float(np.ptp(place))
    columns: dict[str, Any] = {"velocity": velocity, "displacement": place, "acceleration": acceleration}

    def sized(added: np.ndarray) -> np.ndarray:
        return added * effect / float(np.sqrt(np.mean(added**2)))

    force = clean + noise
    if kind == "coloured":
        force = clean + made.noise * coloured(rng, count, rng.uniform(0.3, 0.95))
    elif kind == "growing":
        force = clean + noise * (0.2 + 3 * np.abs(velocity) / np.abs(velocity).max())
    elif kind in ("late", "early"):
        sign = 1.0 if kind == "late" else -1.0
        interval = time[1] - time[0]
        basis = basis_of(slopes_of(made, time, velocity, acceleration))
        low, high = 0.25 * interval, 0.05 / made.frequencies[0]  # less strikes single samples of a law that jumps

        def left(d: float) -> np.ndarray:  # what the law's parameters cannot take up, as damping does a lead
            return without(made.force(time - sign * d) - clean, basis)

        delay = _sized(left, effect, low, high)
        force = made.force(time - sign * delay) + noise
    elif kind == "clipped":
        low, high = np.quantile(force, [rng.uniform(0.01, 0.2), 1 - rng.uniform(0.01, 0.2)])
        force = np.clip(force, low if rng.random() < 0.5 else -np.inf, high)
    elif kind == "quantised position":
        step = _sized(lambda q: _driven(made, q * np.round(place / q)) - clean, effect, 1e-5 * path, 0.05 * path)
        columns = {"displacement": step * np.round(place / step)}
    elif kind == "fine encoder":
        step = 1e-9 * path
        columns = {"displacement": step * np.round(place / step)}
    elif kind == "quantised velocity":
        top = float(np.abs(velocity).max())

        def answer(q: float) -> np.ndarray:
            return driven_force(made.law, time, q * np.round(velocity / q)).force + made.mass * acceleration - clean

        step = _sized(answer, effect, 1e-5 * top, 0.1 * top)
        columns = {"velocity": step * np.round(velocity / step), "acceleration": acceleration}
    elif kind.startswith("ripple"):
        finest = 4 * float(np.quantile(np.abs(np.diff(place)), 0.9))
        length = np.exp(rng.uniform(np.log(max(path / 60, finest)), np.log(path / 3)))
        wave = np.sin(2 * np.pi * place / length + rng.uniform(0, 2 * np.pi))
        force = force + sized(wave * (np.sign(velocity) if kind == "ripple of friction" else 1.0))
    elif kind in ("wear", "drift of the zero"):
        way = time / time[-1]
        way = way if rng.random() < 0.5 else (1 - np.exp(-way / rng.uniform(0.2, 0.6)))
        scale = -(clean - made.mass * acceleration) if kind == "wear" else rng.choice([-1.0, 1.0])
        force = force + sized(scale * (way - way.mean()))
    elif kind == "glitches":
        struck = rng.random(count) < rng.uniform(0.005, 0.02)
        force = force + struck * made.noise * rng.choice([-1, 1], count) * rng.uniform(12, 60, count)
    elif kind == "inertia":
        force = force + sized(acceleration)
    elif kind == "spring":
        force = force + sized(place)
    elif kind == "asymmetric":
        force = force + effect
    return made, Record(kind, time, force, **columns).replaced()


def _driven(made: Bench, place: np.ndarray) -> np.ndarray:
    """The force that the law answers with to the motion made from a place."""
    from scipy.interpolate import CubicSpline

    return driven_force(made.law, made.time, CubicSpline(made.time, place)(made.time, nu=1)).force + (
        made.mass * made.motion(made.time, 2)
    )


def _sized(effect: Callable[[float], np.ndarray], wanted: float, low: float, high: float) -> float:
    """The size of a fault, between two ends, with the wanted root mean square effect."""
    for _ in range(12):
        middle = float(np.sqrt(low * high))
        if float(np.sqrt(np.mean(effect(middle) ** 2))) < wanted:
            low = middle
        else:
            high = middle
    return high


def _searched(made: Bench) -> tuple[list[str], np.ndarray]:
    """Names of the law's parameters and their values, with the mass as the last one where there is one."""
    names = [name for name in PARAMETERS if hasattr(made.law, name)]
    return names, np.array([getattr(made.law, name) for name in names] + [made.mass] * (made.mass > 0))


def _answer(
    made: Bench, names: list[str], values: np.ndarray, time: np.ndarray, velocity: np.ndarray, acceleration: np.ndarray
) -> np.ndarray:
    law = dataclasses.replace(made.law, **dict(zip(names, values.tolist(), strict=False)))
    return driven_force(law, time, velocity).force + (values[-1] if made.mass else 0.0) * acceleration


def slopes_of(
    made: Bench, time: np.ndarray, velocity: np.ndarray, acceleration: np.ndarray, values: np.ndarray | None = None
) -> np.ndarray:
    """Changes of the force [n, p] per e-fold of each parameter."""
    names, own = _searched(made)
    values = own if values is None else values
    base = _answer(made, names, values, time, velocity, acceleration)
    moved = [values * (1 + STEP * one) for one in np.eye(len(values))]
    return np.stack(
        [(_answer(made, names, each, time, velocity, acceleration) - base) / STEP for each in moved], axis=1
    )


def errors_of(made: Bench, record: Record, fitted: bool = False) -> tuple[RecordErrors, np.ndarray]:
    """(errors of the true law under the measured motion, or of the law after two steps of Gauss and Newton; slopes)."""
    from vibrocap.identification.problem.samples import samples

    one = samples(record)
    unit = one.deviation
    names, values = _searched(made)
    slopes = np.empty((len(one), 0))
    base = _answer(made, names, values, one.time, one.velocity, one.acceleration)
    for _ in range(3 if fitted else 0):
        slopes = slopes_of(made, one.time, one.velocity, one.acceleration, values)
        step = np.linalg.lstsq(slopes, one.force - base, rcond=None)[0]
        values = values * np.exp(np.clip(step, -0.3, 0.3))
        if "static_coefficient" in names:
            values[1] = max(values[1], 1.001 * values[0])
        base = _answer(made, names, values, one.time, one.velocity, one.acceleration)
    columns = (one.time, one.velocity, one.acceleration, one.position, one.force, base)
    return RecordErrors(*columns, unit, np.ones(len(one), bool), one.velocity_made), slopes / unit


def named(
    kind: str, seed: int, how: str = "fit", largest: int = 1_000_000, laws: tuple[str, ...] = LAWS
) -> tuple[str, ...]:
    """What is named of one record.

    how: "true" (the errors of the true law), "steps" (those after steps of Gauss and Newton), or "fit".
    """
    made, record = faulty(kind, seed, largest, laws)
    if how != "fit":
        errors, slopes = errors_of(made, record, how == "steps")
        return tuple(cause.kind for cause in diagnosis([errors], slopes if how == "steps" else None).causes)
    settings = {"starts": 1, "start": "relaxed", "intervals": "covariance", "terms": ["mass"] if made.mass > 0 else []}
    fitted = fit(record, made.law, **settings)
    assert fitted.residuals is not None
    ignored = ("coloured", "growing", *(("limit",) if FAULTS[kind] else ()))
    return tuple(kind for kind in fitted.residuals.kinds if kind not in ignored)


def rates(kind: str, seeds: range, how: str = "fit", largest: int = 1_000_000) -> tuple[int, dict[str, int]]:
    """(records of which the fault is named and no other, how often each set of causes was named)."""
    right, table = 0, {}
    for seed in seeds:
        found = named(kind, seed, how, largest)
        right += found == ((FAULTS[kind],) if FAULTS[kind] else ())
        table[" + ".join(found) or "nothing"] = table.get(" + ".join(found) or "nothing", 0) + 1
    return right, table


def report(count: int = 100, largest: int = 1_000_000, how: str = "fit") -> None:
    """The table, kind by kind."""
    for number, kind in enumerate(FAULTS):
        begin = clock.perf_counter()
        right, told = rates(kind, range(1000 * number, 1000 * number + count), how, largest)
        print(f"{kind:20s} {right:4d} of {count}   {told}   {clock.perf_counter() - begin:.0f} s", flush=True)


if __name__ == "__main__":
    numbers = [int(each) for each in sys.argv[1:3]]
    report(*(numbers or [100]), *sys.argv[3:4])
