"""The vibro-impact capsule: its inner mass strikes an elastic stop, on one side or on both."""

from typing import ClassVar

from vibrocap.physics.machines.machine import NonNegative, Positive, Shape, parameter, parameters
from vibrocap.physics.machines.two_mass_capsule import Actuation, BackGap, TwoMassCapsule, stop_shapes


@parameters
class VibroImpactCapsule(TwoMassCapsule):
    """Two-mass capsule in which the inner mass strikes a spring: forward, and back too where `back_gap` is given.

    The stop is a spring without mass at the distance delta, which the mass touches and leaves without a jump:

        F = rho z + nu z' + beta max(0, z - delta)  [- beta max(0, -z - delta_b)]

    With actuation = "external", rho = 1 and the friction level N eta = 1 it is the capsule of Liu, Wiercigroch,
    Pavlovskaia and Yu (Int. J. Mech. Sci. 66, 2013, 2-11): time in 1/sqrt(k_1/m_1), length in P_f/k_1, force in P_f,
    nu = 2 xi and lambda = gamma.
    """

    mass_ratio: Positive = parameter(5.0, "gamma", "capsule mass over inner mass, m_2/m_1", "mass")
    stop_stiffness: NonNegative = parameter(15.0, "beta", "spring of the stop, k_2/(m_1 omega_0^2)", "stiffness")
    gap: NonNegative = parameter(0.02, "delta", "way of the mass to the stop in front", "gap")
    back_gap: BackGap = parameter(
        None, "delta_b", "way of the mass to the stop behind; none where there is no such stop", "gap"
    )
    actuation: Actuation = parameter(
        "external", "a", 'where the drive acts: "internal", between the masses, or "external", on the mass alone'
    )

    name: ClassVar[str] = "vibro-impact-capsule"
    states: ClassVar = (*TwoMassCapsule.states, "touching")
    symmetry: ClassVar = (-1, -1, -1, -1, -1)
    switched: ClassVar = ("touching",)
    switch_events: ClassVar = ("impact", "stop_opened", "impact")

    @property
    def symmetric(self) -> bool:
        """Only with stops on both sides at the same distance."""
        return self.back_gap is not None and self.back_gap == self.gap

    def _closed(self, y):
        """(forward, back): 1 where that stop is touched."""
        if self.back_gap is None:
            return y[4], 0.0
        return 0.5 * y[4] * (y[4] + 1.0), 0.5 * y[4] * (y[4] - 1.0)

    def _pressed(self, y):
        """Way of the mass into the stops: into that in front, less that into the one behind."""
        front, back = self._closed(y)
        pressed = front * (y[0] - self.gap)
        return pressed if self.back_gap is None else pressed + back * (y[0] + self.back_gap)

    def pull(self, y):
        """F, of spring, damper and stop."""
        return super().pull(y) + self.stop_stiffness * self._pressed(y)

    def rates(self, t, y, drive, force):
        """y' = (z', z'', X', X'', 0)."""
        return *super().rates(t, y, drive, force), 0.0

    def energy(self, t, y):
        """H, with beta (z - delta)^2/2 of the stop that is touched."""
        pressed = self._pressed(y)
        return super().energy(t, y) + 0.5 * self.stop_stiffness * (pressed * pressed)

    def switches(self, t, y, drive, force):
        """The mass reaches the stop in front; it leaves the stop; it reaches the one behind."""
        front, back = self._closed(y)
        width = 1.0 + self.gap
        reaches = front + back + (1.0 - front - back) * (self.gap - y[0]) / width
        leaves = 1.0 - front + front * (y[0] - self.gap) / width
        if self.back_gap is None:
            return reaches, leaves
        back_width = 1.0 + self.back_gap
        leaves = 1.0 - front - back + front * (y[0] - self.gap) / width - back * (y[0] + self.back_gap) / back_width
        return reaches, leaves, front + back + (1.0 - front - back) * (y[0] + self.back_gap) / back_width

    def after_switch(self, which, t, y, drive, force):
        """Another stop is touched, or none; nothing jumps."""
        return *y[:4], (1.0, 0.0, -1.0)[which]

    def scene(self, t, y) -> tuple[Shape, ...]:
        """With the stops: the nearest sides of the mass touch them where it has gone its way."""
        return *super().scene(t, y), *stop_shapes(y[2], self.gap, self.back_gap)
