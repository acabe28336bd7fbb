"""Hysteresis of one deflection that yields towards the Coulomb level at any speed: Dahl, and Bouc-Wen."""

import math
from typing import ClassVar

from pydantic import model_validator

from vibrocap.physics.elementary import exp, log, power, sqrt
from vibrocap.physics.friction.law import AtLeastOne, Law, NonNegative, Number, Positive, parameter, parameters

ROUNDING = 1e-10  # of 1 - r, within which |1 - r|^(i-1) is rounded off
MARGIN = 1e-8  # of the yield deflection, by which the deflection passes zero before its sign is changed


@parameters
class Dahl(Law):
    """Dahl's law: the force follows the displacement like the stress of a metal follows its strain.

    Near reversal the contact is a spring; it yields gradually towards the Coulomb level, at any speed.

        R  = delta0 xi,   dR/dx = delta0 |1 - r|^i sgn(1 - r),   r = R sgn(v)/(N eta_c)    Dahl 1968, 1976
        xi' = v |1 - r|^(i-1) (1 - r);   for i = 1   xi' = v - delta0 |v| xi/(N eta_c)

    The exponent i is 1 or somewhat more for ductile materials (below 1, for brittle ones, the level would be reached at
    a corner, which is not offered). |xi| <= N eta_c/delta0 is invariant.

    Limits: no static level, no Stribeck droop and no lag. The law creeps: loading is softer than unloading, so an
    oscillating force below the level ratchets. |1 - r|^(i-1) is rounded off within 1e-10 of r = 1 where i is not an odd
    whole number.
    """

    bristle_stiffness: Positive = parameter(100.0, "delta0", "stiffness of the contact at reversal", "stiffness")
    coulomb_coefficient: Positive = parameter(0.15, "eta_c", "friction coefficient of sliding", "level")
    shape_exponent: AtLeastOne = parameter(1.0, "i", "shape of the approach to Coulomb level", "exponent")

    name: ClassVar[str] = "dahl"
    kind: ClassVar = "kinked"
    internal: ClassVar = ("bristle",)
    shape_parameters: ClassVar = ("shape_exponent",)
    source: ClassVar[str] = "dahl1968; dahl1976"
    creeps: ClassVar[bool] = True

    def steady_force(self, speed, load):
        return load * self.coulomb_coefficient

    def _yielding(self, rest):
        """|rest|^(i-1), for any sign of rest = 1 - r."""
        exponent = self.shape_exponent
        if isinstance(exponent, (int, float)) and exponent == 1.0:
            return 1.0
        if isinstance(exponent, (int, float)) and exponent in (3, 5, 7):
            return power(rest, exponent - 1.0)
        return exp(0.5 * (exponent - 1.0) * log(rest * rest + ROUNDING**2))  # rest may have either sign

    def force(self, velocity, internal, side, load):
        (bristle,) = internal
        force = self.bristle_stiffness * bristle
        rest = 1.0 - side * force / (load * self.coulomb_coefficient)
        return force, (velocity * (rest * self._yielding(rest)),)

    def internal_scales(self, load):
        return (load * self.coulomb_coefficient / self.bristle_stiffness,)

    def losses(self, velocity, internal, side, load):
        """R v less the rate of the stored energy, R (v - xi'): all of it is lost by sliding."""
        force, (rate,) = self.force(velocity, internal, side, load)
        return force * (velocity - rate), 0.0

    def stored_energy(self, internal):
        (bristle,) = internal
        return 0.5 * self.bristle_stiffness * bristle * bristle

    @property
    def passive(self) -> bool:
        """Always: R (v - xi') = N eta_c |v| r (1 - |1 - r|^(i-1) (1 - r)), of which both factors have the sign of r."""
        return True


@model_validator(mode="after")
def yields_or_hardens(law):
    """Refuse a law that does neither, whose deflection has no natural size."""
    if law.dissipative_shape + law.elastic_shape == 0.0:
        raise ValueError(f"elastic_shape should not be -dissipative_shape, got {law.elastic_shape}")
    return law


@parameters
class BoucWen(Law):
    """Bouc-Wen law: an elastic contact that yields over a deflection Y, with a smooth knee of chosen sharpness.

    Wen's hysteresis as Constantinou et al. use it for sliding bearings, with the deflection xi = Y z in place of z:

        R   = delta0 xi,   z = xi/Y,   Y = N eta_c/delta0                                  Constantinou et al. 1990
        xi' = A v - beta |v| |z|^(n-1) z - gamma v |z|^n                                   Bouc 1967, Wen 1976

    Steady sliding gives the largest force, R = N eta_c (A/(beta + gamma))^(1/n), and |z| <= (A/(beta + gamma))^(1/n) is
    invariant. With beta + gamma < 0 the law hardens, as joints of structures do: there is no steady sliding, and the
    stiffness has doubled at |z| = (A/|beta + gamma|)^(1/n). The stiffness at z = 0 is A delta0. n = 1 with gamma = 0 is
    Dahl's law; a large n is an elastic, perfectly plastic contact. The sign of z is a switched state, 0 at the start,
    which changes where z has passed zero by 1e-8; |z|^n is off by at most 2e-8 until then, which leaves 1e-16 in z.

    Limits: no static level, no Stribeck droop and no lag. The law creeps, and more so for small n: unloading and
    reloading over a short way does not close the loop (Thyagarajan and Iwan 1990).
    """

    bristle_stiffness: Positive = parameter(100.0, "delta0", "stiffness of the contact, for A = 1", "stiffness")
    coulomb_coefficient: Positive = parameter(
        0.15, "eta_c", "friction coefficient of sliding, for A = beta + gamma", "level"
    )
    amplitude: Positive = parameter(
        1.0, "A", "rate of the deflection over that of the displacement at no force", "convention"
    )
    dissipative_shape: NonNegative = parameter(
        0.5, "beta", "yielding against the force in either direction: it dissipates", "convention"
    )
    elastic_shape: Number = parameter(
        0.5, "gamma", "softening (< 0: hardening) on the way in, undone on the way out", "softening"
    )
    knee_exponent: AtLeastOne = parameter(2.0, "n", "sharpness of the knee", "exponent")

    name: ClassVar[str] = "bouc-wen"
    kind: ClassVar = "kinked"
    internal: ClassVar = ("bristle", "bristle_sign")
    switched: ClassVar = ("bristle_sign",)
    shape_parameters: ClassVar = ("knee_exponent",)
    source: ClassVar[str] = "bouc1967; wen1976; constantinou1990"
    creeps: ClassVar[bool] = True

    _yields_or_hardens = yields_or_hardens

    def _yield_deflection(self, load):
        return load * self.coulomb_coefficient / self.bristle_stiffness

    def _size(self):
        """(A/|beta + gamma|)^(1/n), the largest |z|, or that at which a law that hardens is twice as stiff."""
        ratio = self.amplitude / (self.dissipative_shape + self.elastic_shape)
        return power(sqrt(ratio * ratio), 1.0 / self.knee_exponent)

    def steady_force(self, speed, load):
        """Infinite of a law that hardens."""
        shape = self.dissipative_shape + self.elastic_shape
        return math.inf if isinstance(shape, float) and shape < 0.0 else load * self.coulomb_coefficient * self._size()

    def force(self, velocity, internal, side, load):
        bristle, sign = internal
        share = power(sign * bristle / self._yield_deflection(load), self.knee_exponent)
        shape = self.elastic_shape + side * sign * self.dissipative_shape
        return self.bristle_stiffness * bristle, (velocity * (self.amplitude - shape * share), 0.0)

    def switches(self, velocity, internal, side, load):
        """z falls below zero where its sign is not -1; z rises above zero where its sign is not 1."""
        bristle, sign = internal
        z = bristle / self._yield_deflection(load)
        below, above = 0.5 * sign * (sign - 1.0), 0.5 * sign * (sign + 1.0)
        return below + (1.0 - below) * (MARGIN + z), above + (1.0 - above) * (MARGIN - z)

    def after_switch(self, which, velocity, internal, side, load):
        """The sign is the one to which z has changed."""
        return internal[0], (-1.0, 1.0)[which]

    def internal_scales(self, load):
        return self._yield_deflection(load) * self._size(), 1.0

    def losses(self, velocity, internal, side, load):
        """R v less the rate of the stored energy, R (v - xi'/A): all of it counts as lost by sliding."""
        force, rates = self.force(velocity, internal, side, load)
        return force * (velocity - rates[0] / self.amplitude), 0.0

    def stored_energy(self, internal):
        return 0.5 * self.bristle_stiffness / self.amplitude * internal[0] * internal[0]

    @property
    def passive(self) -> bool:
        """Always: from z = 0, no motion takes out more than it put in.

        With W, W' = R xi'/(A - gamma |z|^n), for the stored energy, R v - W' = beta |R v| |z|^n/(A - gamma |z|^n),
        which is not negative while |z|^n <= A/(beta + gamma). W needs the load; with `stored_energy` in place of it,

            R v - d(stored)/dt = (|R v|/A) |z|^n [beta + gamma sgn(z v)],

        which for |gamma| > beta is negative for one sign of z v: what is lost there is given back for the other.
        """
        return True
