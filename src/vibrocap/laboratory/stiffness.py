"""The time scales that a friction law brings into a system, and what they ask of a method."""

import dataclasses
import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from vibrocap.laboratory.contact_sizes import speed_scale
from vibrocap.laboratory.driven import check_numbers, checked_list
from vibrocap.laboratory.recorded_law import RecordedLaw, implicit_euler, recorded_law
from vibrocap.numerics.expressions.graph import Expression, derivative
from vibrocap.physics.friction.law import Law

INTERVAL = 2.785  # of the negative real axis on which the classical Runge-Kutta method is stable
DECADES = (-3.0, 1.0)  # of the law's own speed, between which speeds are looked at by default
SPEEDS = 25
AFFORDABLE = 1000.0  # explicit steps within a time of interest that are no burden
SETTLING = 160  # implicit steps towards a steady internal state, each longer than the one before
MOST_STEP, RATE_LEFT = 1e4, 1e-9  # in relaxation times; rate that is left, over the relaxation rate
NEAR_REST = 1e-9  # of the law's own speed: where slopes at rest are taken


@dataclasses.dataclass(frozen=True, eq=False)
class StiffnessReport:
    """Time scales of a law, at speeds [n] of steady sliding and at rest. Rates are per unit of time.

    internal: steady internal states [n, states]; NaN where the law comes to none
    eigenvalues: of dz'/dz there [n, continuous states], complex: how internal states relax at that speed
    relaxation_rate: the quickest of them in size [n], 0 without internal states; relaxation_time: its inverse;
        relaxation_distance: slid meanwhile
    steady_slope: dR/dv of the steady curve [n]; contact_stiffness: dR/dx of presliding from unloaded bristles, 0 where
        the law has none; contact_damping: dR/dv there (for a smooth or smoothed law its slope at rest)
    mass: that slides on the contact, or None; the rest is for it, NaN without:
    natural_frequency, damping_ratio: of presliding, sqrt(k/m) and c/(2 sqrt(k m))
    growth_rate: -dR/dv/m of the least steady slope, at which steady sliding becomes unstable if the slope is all that
        counts (0: no slope is negative); growth_speed: there
    sliding_eigenvalues: of mass and internal states together, about steady sliding [n, 1 + continuous states]
    fastest_rate: the largest size of any eigenvalue [n]; explicit_step: the longest stable step of the classical
        Runge-Kutta method [n], 2.785/fastest_rate
    """

    law: Law
    load: float
    mass: float | None
    kind: str
    speeds: np.ndarray
    internal: np.ndarray
    eigenvalues: np.ndarray
    relaxation_rate: np.ndarray
    relaxation_time: np.ndarray
    relaxation_distance: np.ndarray
    steady_slope: np.ndarray
    contact_stiffness: float
    contact_damping: float
    natural_frequency: float
    damping_ratio: float
    growth_rate: float
    growth_speed: float
    sliding_eigenvalues: np.ndarray
    fastest_rate: np.ndarray
    explicit_step: np.ndarray
    method: str

    @property
    def text(self) -> str:
        """The report in words."""
        words = [f"{self.law.name} ({self.kind})."]
        if not self.eigenvalues.shape[1]:
            words.append("No internal states: the law brings no relaxation time.")
        else:
            for i in (0, len(self.speeds) - 1):
                relaxing = f"{self.relaxation_time[i]:.3g} (over {self.relaxation_distance[i]:.3g})"
                words.append(f"At speed {self.speeds[i]:.3g} its internal states relax in {relaxing};")
                words.append(f"explicit steps there up to {self.explicit_step[i]:.3g}.")
        if self.contact_stiffness > 0.0:
            own = f": {self.natural_frequency:.4g} rad per unit of time, damping ratio {self.damping_ratio:.3g}"
            contact = f"Presliding stiffness {self.contact_stiffness:.4g}, damping {self.contact_damping:.4g}"
            words.append(f"{contact}{'' if self.mass is None else own}.")
        if self.mass is not None and self.growth_rate > 0.0:
            growing = f"at up to {self.growth_rate:.3g}, at speed {self.growth_speed:.3g}."
            words.append(f"Its falling branch lets disturbances of steady sliding grow {growing}")
        return " ".join([*words, self.method])


def stiffness_report(
    law: Law,
    load: float = 1.0,
    speeds: Sequence[float] | None = None,
    *,
    mass: float | None = None,
    duration: float | None = None,
) -> StiffnessReport:
    """Time scales that a law brings, from exact derivatives of its formulas.

    The internal states of dynamic laws relax, z' = f(v, z), at rates that grow with speed and with the stiffness of the
    contact: for LuGre |v|/g(v). A method without implicit steps must resolve the quickest of these rates although
    nothing visible happens in it.

    speeds: of steady sliding, by default 25 from a thousandth to ten times the law's own speed
    mass: sliding on the contact; with it the frequency and damping of presliding, and the growth of steady sliding
    duration: a time of interest, such as the period of the drive; with it the suggested method is definite
    Raises ValueError for loads, masses, durations and speeds that are not positive numbers.
    """
    recorded = recorded_law(law, load)
    check_numbers(**{name: value for name, value in (("mass", mass), ("duration", duration)) if value is not None})
    v = speed_scale(law) * np.logspace(*DECADES, SPEEDS) if speeds is None else checked_list("speeds", speeds)
    states = _steady_states(recorded, v)
    force, rate = _jacobians(recorded, v, states)
    own = _eigenvalues(rate[:, :, 1:])
    quickest = np.max(np.abs(own), axis=1, initial=0.0)
    steady: Any = law.steady_force(recorded.graph.node("state", 0), recorded.load)
    falling = derivative(steady, 0) if isinstance(steady, Expression) else recorded.graph.constant(0.0)
    slope = recorded.values([falling], v, np.empty((0, len(v))), 1.0)[0]
    stiffness, damping = _presliding(recorded)
    sliding = np.full((len(v), 1 + own.shape[1]), np.nan + 0.0j)
    frequency = ratio = growth = growth_speed = math.nan
    fastest = quickest
    if mass is not None:
        sliding = _eigenvalues(np.concatenate((-force[:, None, :] / mass, rate), axis=1))
        fastest = np.max(np.abs(sliding), axis=1)
        frequency = math.sqrt(max(stiffness, 0.0) / mass)
        ratio = damping / (2.0 * math.sqrt(stiffness * mass)) if stiffness > 0.0 else math.nan
        least = int(np.nanargmin(slope))
        growth, growth_speed = max(0.0, -float(slope[least]) / mass), float(v[least])
    with np.errstate(divide="ignore"):
        time, step = 1.0 / quickest, INTERVAL / fastest
    return StiffnessReport(
        law=law,
        load=float(load),
        mass=mass,
        kind=law.kind,
        speeds=v,
        internal=states.T,
        eigenvalues=own,
        relaxation_rate=quickest,
        relaxation_time=time,
        relaxation_distance=v * time,
        steady_slope=slope,
        contact_stiffness=stiffness,
        contact_damping=damping,
        natural_frequency=frequency,
        damping_ratio=ratio,
        growth_rate=growth,
        growth_speed=growth_speed,
        sliding_eigenvalues=sliding,
        fastest_rate=fastest,
        explicit_step=step,
        method=_method(law, float(np.nanmax(fastest)), float(v[-1]), stiffness, damping, mass, duration),
    )


def _steady_states(recorded: RecordedLaw, speeds: np.ndarray) -> np.ndarray:
    """Internal states [states, n] after long sliding forward at each speed, NaN where they do not come to rest.

    Implicit Euler steps of growing length; where no rate is left, the state is exact whatever the steps were.
    """
    states, count = len(recorded.rates), len(speeds)
    state = recorded.settled_pieces(speeds, np.zeros((states, count)), 1.0)
    if not states:
        return state
    size = np.array([float(scale) for scale in recorded.law.internal_scales(recorded.load)])[:, None]
    rate = recorded.values(recorded.rates, speeds, state, 1.0)
    step = 0.01 / np.maximum(np.max(np.abs(rate) / size, axis=0), 1e-300)
    quickness = np.ones(count)
    for _ in range(SETTLING):
        state = recorded.settled_pieces(speeds, implicit_euler(recorded, speeds, state, 1.0, step), 1.0)
        slope = recorded.values(recorded.rate_slopes, speeds, state, 1.0)
        quickness = np.maximum(np.nanmax(np.abs(slope), axis=0), 1e-300)
        step = np.minimum(1.2 * step, MOST_STEP / quickness)
    rate = recorded.values(recorded.rates, speeds, state, 1.0)
    left = np.max(np.abs(rate) / size, axis=0)
    return np.where(left <= RATE_LEFT * quickness, state, np.nan)


def _jacobians(recorded: RecordedLaw, speeds: np.ndarray, states: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(dR/d(v, z) [n, 1 + k], dz'/d(v, z) [n, k, 1 + k]) with the k continuous internal states."""
    kept = recorded.continuous
    columns = np.append(0, 1 + kept)
    force = recorded.values(recorded.force_slopes, speeds, states, 1.0)[columns]
    return force.T, np.moveaxis(recorded.jacobian(speeds, states, 1.0)[np.ix_(kept, columns)], 2, 0)


def _eigenvalues(matrices: np.ndarray) -> np.ndarray:
    """Eigenvalues [n, k] of matrices [n, k, k], NaN where a matrix is not finite."""
    finite = np.all(np.isfinite(matrices), axis=(1, 2))
    eigenvalues = np.full(matrices.shape[:2], np.nan + 0.0j)
    eigenvalues[finite] = np.linalg.eigvals(matrices[finite])
    return eigenvalues


def _presliding(recorded: RecordedLaw) -> tuple[float, float]:
    """(dR/dx, dR/dv) at vanishing velocity from unloaded internal states; 0 and 0 where the law gives none.

    With z' = (dz'/dv) v near rest, displacement x changes R by the sum of dR/dz dz'/dv.
    """
    if recorded.law.kind == "set-valued":
        return 0.0, 0.0
    slow = np.array([NEAR_REST * speed_scale(recorded.law)])
    state = recorded.settled_pieces(slow, np.zeros((len(recorded.rates), 1)), 1.0)
    force, rate = _jacobians(recorded, slow, state)
    stiffness, damping = float(force[0, 1:] @ rate[0, :, 0]), float(force[0, 0])
    return stiffness if math.isfinite(stiffness) else 0.0, damping if math.isfinite(damping) else 0.0


def _method(law: Law, fastest: float, speed: float, stiffness: float, damping: float, mass, duration) -> str:
    """What to integrate the law with, in words."""
    if law.kind == "set-valued":
        return (
            "At rest friction balances the applied force: sticking is a mode of its own, and needs located events, not "
            "small steps. While sliding any explicit method serves."
        )
    at_rest = damping / mass if mass is not None else 0.0
    if mass is not None and stiffness > 0.0:
        at_rest = max(abs(root) for root in np.roots([mass, damping, stiffness]))
    quickest = max(fastest, at_rest)
    if not law.internal and mass is None:
        return f"Its slope at rest, {damping:.3g}, over a mass is a rate to resolve: give a mass to see the step."
    if quickest == 0.0:
        return "It brings no rate of its own: any explicit method serves."
    where = "near rest" if at_rest >= fastest else f"at speed {speed:.3g}"
    bound = f"An explicit method is bound to steps of {INTERVAL / quickest:.3g} {where}"
    if duration is None:
        return (
            f"{bound}; where the motion of interest lasts much longer than {AFFORDABLE:g} of them, use an L-stable "
            "method (Radau, or the Rosenbrock steps that this engine chooses by itself)."
        )
    steps = duration * quickest / INTERVAL
    if steps <= AFFORDABLE:
        return f"{bound}, at most {steps:.3g} within {duration:g}: an explicit method serves."
    return f"{bound}, {steps:.3g} within {duration:g}: use an L-stable method (this engine does so by itself)."
