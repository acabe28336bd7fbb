from typing import ClassVar

from pydantic import model_validator

from vibrocap.physics.controllers.controller import CURVATURE, INTEGRAL, OWN, SATURATED, SIDE, Linear, anti_windup
from vibrocap.physics.elementary import bristle_slip, stribeck_curve
from vibrocap.physics.parameters import NonNegative, Positive, parameter, parameters

BRISTLE = "observed_bristle"


@parameters
class FrictionObserver(Linear):
    """PID controller of a place with an observer of LuGre friction, whose force it compensates.

        u    = K_P e + K_D e' + S + m r'' + F,     S' = K_I e,     e = r - x
        F    = s_0 z + s_1 z' + s_2 v
        z'   = v - s_0 |v| z/l(v) + k e,           l(v) = F_c + (F_s - F_c) exp(-(v/v_s)^2)

    (Canudas de Wit, Olsson, Astrom and Lischinsky 1995, section V). All of s_0, s_1, s_2, F_c, F_s, v_s and m are what
    the controller believes, forces and no coefficients; what acts is the law of the contact, of whatever kind. Where
    the beliefs are right the error dies out and a servo that would hunt does not. x is the place of the machine or any
    other state that is a length, v the sliding velocity at the first contact, whose body the command has to push.
    """

    proportional_gain: NonNegative = parameter(1.0, "K_P", "force per length of error", "position gain")
    integral_gain: NonNegative = parameter(
        0.0, "K_I", "rate of the command per length of error", "position integral gain"
    )
    derivative_gain: NonNegative = parameter(2.0, "K_D", "force per speed of error", "position rate gain")
    mass: NonNegative = parameter(0.0, "m", "mass that is believed, by which r'' is fed forward", "mass")
    bristle_stiffness: Positive = parameter(100.0, "s_0", "stiffness of the bristles that is believed", "stiffness")
    bristle_damping: NonNegative = parameter(10.0, "s_1", "their damping", "bristle damping")
    viscous_damping: NonNegative = parameter(0.0, "s_2", "viscous friction coefficient", "viscous damping")
    coulomb_force: Positive = parameter(0.15, "F_c", "friction force at high speed", unit="N")
    static_force: Positive = parameter(0.45, "F_s", "friction force at rest", unit="N")
    stribeck_velocity: Positive = parameter(
        0.1, "v_s", "speed over which friction drops from static to Coulomb force", "Stribeck velocity"
    )
    observer_gain: NonNegative = parameter(0.0, "k", "rate of the bristles' deflection per length of error", unit="1/s")
    anti_windup: NonNegative = anti_windup("position anti-windup")
    limit: Positive | None = parameter(None, "u_max", "largest command; none where there is no limit", "effort")
    measured: str = parameter(OWN, "x", "the state that is measured; own: the place of the machine")

    name: ClassVar[str] = "friction-observer"
    source: ClassVar[str] = "canudas1995; astrom2006"
    reference: ClassVar = "displacement"
    all_states: ClassVar = (INTEGRAL, SATURATED, BRISTLE)

    @model_validator(mode="after")
    def _levels(self):
        if self.static_force < self.coulomb_force:
            raise ValueError(f"static_force should be at least coulomb_force, got {self.static_force}")
        return self

    @property
    def states(self) -> tuple[str, ...]:
        return (*super().states, BRISTLE)

    def scales(self, effort) -> tuple:
        """That of the bristles is their largest deflection, F_s/s_0."""
        return (*super().scales(effort)[:-1], self.static_force / self.bristle_stiffness)

    def measures(self, machine) -> tuple[str, ...]:
        return (*super().measures(machine), CURVATURE, machine.contact_states[0], SIDE)

    def _bristle_rate(self, measured, own, reference):
        *_, velocity, side = measured
        speed = side * velocity
        level = stribeck_curve(speed, self.coulomb_force, self.static_force, self.stribeck_velocity, 2.0)
        slip = bristle_slip(speed, own[-1], self.bristle_stiffness, level)
        return velocity - slip + self.observer_gain * (reference - measured[0])

    def _raw(self, measured, own, reference, slope):
        _, _, curvature, velocity, _ = measured
        rate = self._bristle_rate(measured, own, reference)
        friction = self.bristle_stiffness * own[-1] + self.bristle_damping * rate + self.viscous_damping * velocity
        return super()._raw(measured, own, reference, slope) + self.mass * curvature + friction

    def rates(self, t, measured, own, reference, slope) -> tuple:
        return *super().rates(t, measured, own, reference, slope), self._bristle_rate(measured, own, reference)

    def after_switch(self, which, t, measured, own, reference, slope) -> tuple:
        return *super().after_switch(which, t, measured, own, reference, slope), own[-1]
