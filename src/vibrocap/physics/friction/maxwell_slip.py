from typing import ClassVar

from pydantic import model_validator

from vibrocap.physics.friction.law import (
    STRIBECK_EXPONENT,
    STRIBECK_VELOCITY,
    Exponent,
    Law,
    levels_in_order,
    stribeck_level,
)
from vibrocap.physics.parameters import NonNegative, Positive, parameter, parameters

ELEMENTS = 4


@model_validator(mode="after")
def shares_within_one(law):
    """Refuse shares of the level that leave nothing to the last element."""
    total = law.share_1 + law.share_2 + law.share_3
    if not total < 1.0:
        raise ValueError(f"share_1, share_2 and share_3 should add up to less than 1, got {total:g}")
    return law


@parameters
class MaxwellSlip(Law):
    """Generalised Maxwell-slip law (GMS): four springs in parallel, each of which slips at its share of friction.

    The contact remembers where it turned (hysteresis with nonlocal memory) and does not drift below breakaway; while
    sliding its force lags the steady curve.

        R = F_1 + ... + F_4 + delta2 v                                        Lampaert, Al-Bender, Swevers 2003
        element i sticks   F_i' = k_i v                                until |F_i| = nu_i s(v)
        element i slips    F_i' = N C [nu_i sgn(v) - F_i/s(v)]         until v passes zero     Al-Bender et al. 2005
        s(v) = N [eta_c + (eta_s - eta_c) exp(-|v/v_s|^alpha)],        nu_4 = 1 - nu_1 - nu_2 - nu_3

    Whether an element slips is a switched state. With equal levels the law is Iwan's, rate-independent: its virgin
    curve is piecewise linear, its loops twice as large (Masing). The rate C is counted per unit of load, so that the
    time s(v)/(N C) in which a slipping element follows s(v) does not depend on the load.

    Limits: the elements' own damping is left out. As s(v) rises in a slowing contact, so does the force of a slipping
    element, without displacement: except for equal levels the law can give energy.
    """

    stiffness_1: Positive = parameter(40.0, "k_1", "stiffness of element 1", "stiffness")
    stiffness_2: Positive = parameter(30.0, "k_2", "stiffness of element 2", "stiffness")
    stiffness_3: Positive = parameter(20.0, "k_3", "stiffness of element 3", "stiffness")
    stiffness_4: Positive = parameter(10.0, "k_4", "stiffness of element 4", "stiffness")
    share_1: Positive = parameter(0.1, "nu_1", "share of element 1 in the level", "share")
    share_2: Positive = parameter(0.2, "nu_2", "share of element 2 in the level", "share")
    share_3: Positive = parameter(0.3, "nu_3", "share of element 3 in the level; element 4 has the rest", "share")
    coulomb_coefficient: Positive = parameter(0.15, "eta_c", "friction coefficient at high speed", "level")
    static_coefficient: Positive = parameter(0.45, "eta_s", "friction coefficient at rest", "static level")
    stribeck_velocity: Positive = STRIBECK_VELOCITY
    stribeck_exponent: Exponent = STRIBECK_EXPONENT
    attraction_rate: NonNegative = parameter(
        5.0, "C", "rate at which slipping elements follow the level, over N", "attraction rate"
    )
    viscous_damping: NonNegative = parameter(0.0, "delta2", "viscous friction coefficient", "viscous damping")

    name: ClassVar[str] = "maxwell-slip"
    kind: ClassVar = "kinked"
    internal: ClassVar = (
        *(f"element_force_{i + 1}" for i in range(ELEMENTS)),
        *(f"slipping_{i + 1}" for i in range(ELEMENTS)),
    )
    switched: ClassVar = internal[ELEMENTS:]
    internal_symmetry: ClassVar = (*(-1,) * ELEMENTS, *(1,) * ELEMENTS)
    shape_parameters: ClassVar = ("stribeck_exponent",)
    source: ClassVar[str] = "lampaert2003; albender2005"

    _levels = levels_in_order
    _shares = shares_within_one

    def _elements(self):
        rest = 1.0 - self.share_1 - self.share_2 - self.share_3
        stiffness = (self.stiffness_1, self.stiffness_2, self.stiffness_3, self.stiffness_4)
        return tuple(zip(stiffness, (self.share_1, self.share_2, self.share_3, rest), strict=True))

    def steady_force(self, speed, load):
        return stribeck_level(self, speed, load) + self.viscous_damping * speed

    def _element_rates(self, velocity, internal, side, load):
        """(rate while sticking, rate) of each element's force."""
        attraction = load * self.attraction_rate
        rate_of_following = attraction / stribeck_level(self, side * velocity, load)
        rates = []
        states = zip(self._elements(), internal[:ELEMENTS], internal[ELEMENTS:], strict=True)
        for (stiffness, share), force, slipping in states:
            sticking = stiffness * velocity
            following = side * (attraction * share) - rate_of_following * force
            rates.append((sticking, sticking + slipping * (following - sticking)))
        return rates

    def force(self, velocity, internal, side, load):
        rates = self._element_rates(velocity, internal, side, load)
        force = internal[0] + internal[1] + internal[2] + internal[3] + self.viscous_damping * velocity
        return force, (*(rate for _, rate in rates), *(0.0,) * ELEMENTS)

    def switches(self, velocity, internal, side, load):
        """The force of a sticking element reaches its share of the level; one that slips does so until the reversal."""
        level, unit = stribeck_level(self, side * velocity, load), 1.0 / (load * self.static_coefficient)
        states = zip(self._elements(), internal[:ELEMENTS], internal[ELEMENTS:], strict=True)
        return tuple(
            slipping + (1.0 - slipping) * (level - side * force / share) * unit
            for (_, share), force, slipping in states
        )

    def after_switch(self, which, velocity, internal, side, load):
        return tuple(1.0 if i == ELEMENTS + which else state for i, state in enumerate(internal))

    def after_reversal(self, internal, side, load):
        """All elements stick."""
        return (*internal[:ELEMENTS], *(0.0,) * ELEMENTS)

    def internal_scales(self, load):
        static = load * self.static_coefficient
        return (*(share * static for _, share in self._elements()), *(1.0,) * ELEMENTS)

    def losses(self, velocity, internal, side, load):
        """R v less the rate of the stored energy: sum of F_i (v - F_i'/k_i), and delta2 v^2; all of it is sliding."""
        lost = self.viscous_damping * velocity * velocity
        rates = self._element_rates(velocity, internal, side, load)
        for (stiffness, _), force, (sticking, rate) in zip(self._elements(), internal[:ELEMENTS], rates, strict=True):
            lost = lost + force * ((sticking - rate) / stiffness)
        return lost, 0.0

    def stored_energy(self, internal):
        stored = 0.0
        for (stiffness, _), force in zip(self._elements(), internal[:ELEMENTS], strict=True):
            stored = stored + 0.5 * force * force / stiffness
        return stored

    @property
    def passive(self) -> bool:
        """Equal levels: an element then sticks, or slips with F_i = nu_i s sgn(v) and loses F_i v.

        With a droop F_i grows while s(v) rises, however little the contact moves.
        """
        return self.static_coefficient == self.coulomb_coefficient
