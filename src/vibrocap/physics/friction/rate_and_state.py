"""Rate-and-state friction, with the ageing law or the slip law: contacts renewed over a sliding distance."""

from typing import ClassVar

from pydantic import model_validator

from vibrocap.physics.elementary import exp, log, sqrt
from vibrocap.physics.friction.law import Law, NonNegative, Positive, parameter, parameters

MOST_STRENGTH = 300.0  # of the exponent mu0/a, whose square must stay within the range of numbers


@parameters
class RateAndState(Law):
    """What both laws have in common: the friction that a state phi of the contact gives."""

    reference_coefficient: Positive = parameter(
        0.3, "mu0", "steady friction coefficient at the reference velocity", "level"
    )
    direct_effect: Positive = parameter(0.03, "a", "rise of friction at once, per factor e of speed", "direct effect")
    evolution_effect: NonNegative = parameter(
        0.06, "b", "fall of friction afterwards, per factor e of speed", "evolution effect"
    )
    critical_distance: Positive = parameter(
        0.01, "D_c", "sliding distance over which the contact is renewed", "distance"
    )
    reference_velocity: Positive = parameter(0.1, "v_0", "reference velocity", "reference velocity")

    kind: ClassVar = "kinked"
    internal: ClassVar = ("log_age",)
    internal_symmetry: ClassVar = (1,)
    source: ClassVar[str] = "dieterich1979; ruina1983; lapusta2000"
    creeps: ClassVar[bool] = True

    @model_validator(mode="after")
    def _resolved(self):
        """Refuse a direct effect so small that friction at rest leaves the range of numbers."""
        least = self.reference_coefficient / MOST_STRENGTH
        if self.direct_effect < least:
            raise ValueError(
                f"direct_effect should be at least reference_coefficient/{MOST_STRENGTH:g} = {least:g}, "
                f"got {self.direct_effect}"
            )
        return self

    def _force(self, velocity, state, side, load):
        """N a asinh{(v/2 v0) exp[(mu0 + b phi)/a]}, phi = ln(theta v0/Dc)."""
        strength = (self.reference_coefficient + self.evolution_effect * state) / self.direct_effect
        jumps = side * velocity * (0.5 / self.reference_velocity) * exp(strength)
        return side * load * self.direct_effect * log(jumps + sqrt(1.0 + jumps * jumps))

    def _steady_state(self, speed):
        raise NotImplementedError

    def _rate(self, velocity, state, side):
        raise NotImplementedError

    def steady_force(self, speed, load):
        return self._force(speed, self._steady_state(speed), 1.0, load)

    def force(self, velocity, internal, side, load):
        rate = self._rate(velocity, internal[0], side)
        return self._force(velocity, internal[0], side, load), (rate,)

    def internal_scales(self, load):
        """1: a change of the state by one is an age e times as great."""
        return (1.0,)

    @property
    def passive(self) -> bool:
        """Always: R v >= 0."""
        return True


@parameters
class RateAndStateAgeing(RateAndState):
    """Rate-and-state friction, ageing law: the contact ages while it rests and is renewed over a sliding distance.

    A step of speed is answered at once by a ln(v2/v1), then by -b ln(v2/v1) over the distance Dc. The state is phi =
    ln(theta v0/Dc) in place of the age theta:

        R = N a asinh{(v/2 v0) exp[(mu0 + b phi)/a]}                             Lapusta et al. 2000 (Rice, Ben-Zion)
        theta' = 1 - |v| theta/Dc      phi' = (v0 exp(-phi) - |v|)/Dc            Dieterich 1979, Ruina 1983

    For |v| well above v0 exp[-(mu0 + b phi)/a] the first is Dieterich's mu0 + a ln(|v|/v0) + b phi, which is infinite
    at rest; the asinh, from jumps both ways over a barrier, is zero there. In steady sliding phi = ln(v0/|v|) and
    R = N [mu0 + (a - b) ln(|v|/v0)].

    Limits: the contact never sticks, it creeps, however slowly, under any force. Friction turns over within
    v0 exp(-mu0/a), for rock some 1e-35 v0, which no step near rest resolves: such values serve for sliding that does
    not come to rest and for an imposed motion.
    """

    name: ClassVar[str] = "rate-and-state-ageing"

    def _steady_state(self, speed):
        return log(self.reference_velocity / speed)

    def _rate(self, velocity, state, side):
        return (self.reference_velocity * exp(-state) - side * velocity) / self.critical_distance


@parameters
class RateAndStateSlip(RateAndState):
    """Rate-and-state friction, slip law: the state of the contact moves to its steady value as the contact slips.

    A step of speed is answered at once by a ln(v2/v1), then by -b ln(v2/v1), exponentially over the distance Dc and
    alike for steps up and down. R, phi and steady sliding are those of the ageing law, with

        theta' = -(|v| theta/Dc) ln(|v| theta/Dc),     phi' = -(|v|/Dc) [phi + ln(|v|/v0)]         Ruina 1983

    The logarithm diverges at rest, so |v| in it is sqrt(v^2 + v_c^2): the state goes to ln(v0/v_c) at most. Well above
    the cut-off velocity v_c the law is Ruina's.

    Limits: no healing at rest; otherwise those of the ageing law.
    """

    cutoff_velocity: Positive = parameter(
        1e-4, "v_c", "velocity below which the state no longer follows the logarithm", "cutoff velocity"
    )

    name: ClassVar[str] = "rate-and-state-slip"

    def _steady_state(self, speed):
        """ln(v0/|v|), cut off below v_c."""
        share, least = speed / self.reference_velocity, self.cutoff_velocity / self.reference_velocity
        return -0.5 * log(share * share + least * least)

    def _rate(self, velocity, state, side):
        return side * velocity * (self._steady_state(velocity) - state) / self.critical_distance
