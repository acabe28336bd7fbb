"""The vibro-impact capsule: its inner mass strikes an elastic stop, on one side or on both."""

from typing import ClassVar

from hand_machines.stops import BackGap, ElasticStops, StopDamping, StopStiffness, stop_shapes
from hand_machines.two_mass_capsule import Actuation, TwoMassCapsule
from vibrocap.physics.machines.machine import Machine, NonNegative, Positive, Shape, parameter, parameters


@parameters
class VibroImpactCapsule(TwoMassCapsule):
    """Two-mass capsule in which the inner mass strikes a spring: forward, and back too where `back_gap` is given.

    The stop is a spring without mass at the distance delta, which the mass touches and leaves without a jump:

        F = rho z + nu z' + beta max(0, z - delta)  [- beta max(0, -z - delta_b)]

    With actuation = "external", rho = 1 and the friction level N eta = 1 it is the capsule of Liu, Wiercigroch,
    Pavlovskaia and Yu (Int. J. Mech. Sci. 66, 2013, 2-11): time in 1/sqrt(k_1/m_1), length in P_f/k_1, force in P_f,
    nu = 2 xi and lambda = gamma. A stop may have a damper too, which acts while it is touched, and the stop behind a
    spring and a damper of its own (`ElasticStops`).
    """

    mass_ratio: Positive = parameter(
        5.0, "gamma", "capsule mass over inner mass, m_2/m_1", "mass", in_si="mass of the capsule"
    )
    stop_stiffness: NonNegative = parameter(
        15.0, "beta", "spring of the stop, k_2/(m_1 omega_0^2)", "stiffness", in_si="spring of the stop"
    )
    gap: NonNegative = parameter(0.02, "delta", "way of the mass to the stop in front", "gap")
    back_gap: BackGap = parameter(
        None, "delta_b", "way of the mass to the stop behind; none where there is no such stop", "gap"
    )
    stop_damping: StopDamping = parameter(
        None,
        "nu_s",
        "damper of the stop, c_2/(m_1 omega_0); none where it has none",
        "viscous damping",
        in_si="damper of the stop; none where it has none",
    )
    back_stop_stiffness: StopStiffness = parameter(
        None, "beta_b", "spring of the stop behind; none where it is that of the one in front", "stiffness"
    )
    back_stop_damping: StopDamping = parameter(
        None, "nu_b", "damper of the stop behind; none where it is that of the one in front", "viscous damping"
    )
    actuation: Actuation = parameter(
        "external", "a", 'where the drive acts: "internal", between the masses, or "external", on the mass alone'
    )

    source: ClassVar[str] = "liu2013"
    name: ClassVar[str] = "vibro-impact-capsule"
    mechanism = Machine.mechanism  # stops have no part there
    states: ClassVar = (*TwoMassCapsule.states, "touching")
    symmetry: ClassVar = (-1, -1, -1, -1, -1)
    switched: ClassVar = ("touching",)
    switch_events: ClassVar = ("impact", "stop_opened", "impact")

    @property
    def _stops(self) -> ElasticStops:
        """Both stops."""
        back = self.back_stop_stiffness, self.stop_damping, self.back_stop_damping
        return ElasticStops(self.gap, self.back_gap, self.stop_stiffness, *back)

    @property
    def symmetric(self) -> bool:
        """Only with stops on both sides that are alike, at the same distance."""
        return self._stops.symmetric

    def pull(self, y):
        """F, of spring, damper and stop."""
        return super().pull(y) + self._stops.force(y[0], y[1], y[4])

    def rates(self, t, y, drive, frictions):
        """y' = (z', z'', X', X'', 0)."""
        return *super().rates(t, y, drive, frictions), 0.0

    def energy(self, t, y):
        """H, with beta (z - delta)^2/2 of the stop that is touched."""
        return super().energy(t, y) + self._stops.energy(y[0], y[4])

    def powers(self, t, y, drive, frictions):
        """Power of the drive, and of the dampers, that of the stop that is touched with the other."""
        drives, damper = super().powers(t, y, drive, frictions)
        taken = self._stops.damper_power(y[1], y[4])
        return drives, damper if taken is None else damper + taken

    def switches(self, t, y, drive, frictions):
        """The mass reaches the stop in front; it leaves the stop; it reaches the one behind."""
        return self._stops.guards(y[0], y[4], 1.0 + self.gap, 1.0 if self.back_gap is None else 1.0 + self.back_gap)

    def after_switch(self, which, t, y, drive, frictions):
        """Another stop is touched, or none; nothing jumps."""
        return *y[:4], (1.0, 0.0, -1.0)[which]

    def scene(self, t, y) -> tuple[Shape, ...]:
        """With the stops: the nearest sides of the mass touch them where it has gone its way."""
        return *super().scene(t, y), *stop_shapes(y[2], self.gap, self.back_gap)
