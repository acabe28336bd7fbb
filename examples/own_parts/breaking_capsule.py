"""An event of one's own: a capsule whose spring breaks, as a file for `--parts`."""

from typing import ClassVar

import vibrocap as vc
from vibrocap.mechanics import Positive, Spring, parameter, parameters


@parameters
class BreakingCapsule(vc.TwoMassCapsule):
    """Two-mass capsule whose spring breaks at z = delta and loses its stored energy; the damper stays."""

    reach: Positive = parameter(1.5, "delta", "stretch at which the spring breaks", "gap")

    name: ClassVar[str] = "breaking-capsule"
    source: ClassVar[str] = "vibrocap"
    switched: ClassVar = ("broken",)
    switch_events: ClassVar = ("spring_breaks",)
    channels: ClassVar = (*vc.TwoMassCapsule.channels, "impact")

    def parts(self, q):
        """Parts of the two-mass capsule with another spring; q.broken is 0 or 1."""
        others = [part for part in super().parts(q) if not isinstance(part, Spring)]
        return [*others, Spring((1.0 - q.broken) * self.stiffness, q.displacement)]

    def switches(self, t, y, drive, frictions):
        """delta - z, positive until the spring breaks; then 1 for good."""
        return ((1.0 - y[4]) * (self.reach - y[0]) + y[4],)

    def after_switch(self, which, t, y, drive, frictions):
        """Only the switched state jumps; the channel `impact` counts the lost energy."""
        return *y[:4], 1.0


if __name__ == "__main__":
    system = vc.System(BreakingCapsule(), vc.Coulomb(), vc.Harmonic(amplitude=1.5))
    motion = vc.simulate(system, periods=10)
    (breaks,) = [event for event in motion.events if event.kind == "spring_breaks"]
    assert abs(breaks.time - motion.crossings("displacement", 1.5)[0]) < 1e-12
    assert motion.certificate.ok
    assert abs(vc.energy_balance(motion).impact + 0.5 * 1.5**2) < 1e-12  # the energy of the spring
    print(f"{breaks.kind} at {breaks.time:.6f}")
