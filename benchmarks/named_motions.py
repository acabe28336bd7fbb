"""The motions that the benchmarks run, as bare numbers for every competitor, with final states known to 1e-11.

First set of docs/model.md. The final states come from tests/independent.py, which finds the same ones at two
tolerances a factor of 20 apart.
"""

import math
from dataclasses import dataclass
from types import SimpleNamespace

import numpy as np

FIRST_SET = SimpleNamespace(
    mass_ratio=2.5,
    stiffness=2.0,
    damping=1.0,
    normal_load=1.0,
    amplitude=1.8,
    frequency=1.0,
    coulomb_coefficient=0.15,
    static_coefficient=0.45,
    decay_rate=10.0,
    bristle_stiffness=100.0,
    bristle_damping=10.0,
    viscous_damping=0.0,
    stribeck_velocity=0.1,
    stribeck_exponent=2.0,
)


@dataclass(frozen=True)
class NamedMotion:
    """A start, a number of drive periods, the state at their end, and the error within which it is to be reached."""

    initial: tuple[float, ...]
    periods: int
    final: tuple[float, ...]
    error_asked: float

    @property
    def end(self) -> float:
        """Time at the end of the last period."""
        return 2.0 * math.pi / FIRST_SET.frequency * self.periods

    def error(self, state) -> float:
        """Largest error of a final state."""
        return float(np.max(np.abs(np.asarray(state) - np.asarray(self.final))))


EXPONENTIAL_40 = NamedMotion(
    initial=(math.pi / 3, 0.0, 0.0, 0.0),
    periods=40,
    final=(0.6105521873752603, 1.505929535828451, 6.859739901117709, 0.2974614023154033),
    error_asked=1e-9,
)
LUGRE_100 = NamedMotion(
    initial=(math.pi / 3, 0.0, 0.0, 0.0, 0.0026),
    periods=100,
    final=(0.6128545486769591, 1.5053087547287374, 10.755925482908458, 0.28565160057383016, 0.0015007242030981797),
    error_asked=1e-6,
)
