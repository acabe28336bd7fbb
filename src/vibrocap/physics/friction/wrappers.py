"""Wrappers, which make a law of a law: for each direction its own, behind play, smoothed at rest, with viscosity."""

import functools
import math
from collections.abc import Callable
from typing import Any, ClassVar, Literal

from vibrocap.physics.elementary import atan, tanh
from vibrocap.physics.friction.law import Law, NonNegative, Positive, parameter
from vibrocap.physics.parameters import inner_part, wrapped_class

MARGIN = 1e-9  # of the load, to which the force is negative before the joint opens


@functools.cache
def anisotropic(law: type[Law]) -> Any:
    """The class of a law whose load is scaled by the direction of sliding: its fields and a ratio for each direction.

    Scales, bristles set at an angle, a skate with a stop: one way is smoother than the other. All levels of the law are
    scaled alike, by its load; its stiffness and its viscous part are not:

        R = R_law(v, z; k N),    k = k_fwd where sgn(v) = 1,  k_back where sgn(v) = -1

    A set-valued law holds any force from -k_back N eta_s to k_fwd N eta_s. A dynamic law turns with the internal states
    that it has: R is as continuous at a reversal as before, and the law as passive, for its states may exceed the level
    of one direction only while they act against the motion.

    law: a set-valued or kinked law that is not anisotropic yet
    Returns the class, the same one each time: `anisotropic(LuGre)(forward_ratio=1.0, back_ratio=1.3)`.
    Raises ValueError for a smooth law: it knows no direction, and scaled by one it would not be smooth.
    """
    if anisotropic in law.wrappers:
        raise ValueError(f"the {law.name} law is anisotropic already")
    if law.kind == "smooth":
        reason = f"got the {law.name} law, which is smooth"
        raise ValueError(f"only a set-valued or kinked law can be made anisotropic, {reason}")

    def in_direction(name: str) -> Callable:
        """The function of the law, whose arguments end in side and load."""

        def function(self, *arguments):
            *others, side, load = arguments
            return getattr(inner_part(law, self), name)(*others, side, self._ratio(side) * load)

        return function

    class Anisotropic(law):
        forward_ratio: Positive = parameter(
            1.0, "k_fwd", "load that counts in sliding forward, over the load", "convention"
        )
        back_ratio: Positive = parameter(1.5, "k_back", "load that counts in sliding back, over the load", "back ratio")

        special_cases: ClassVar = {law.name: {"forward_ratio": 1.0, "back_ratio": 1.0}}
        source: ClassVar[str] = f"{law.source}; zimmermann2009"

        def _ratio(self, side):
            """k of a side; their mean at rest (side 0)."""
            middle, half = 0.5 * (self.forward_ratio + self.back_ratio), 0.5 * (self.forward_ratio - self.back_ratio)
            return middle + side * half

        def steady_force(self, speed, load, side=1):
            return inner_part(law, self).steady_force(speed, self._ratio(side) * load)

        force, losses, switches, after_switch, after_reversal = map(
            in_direction, ("force", "losses", "switches", "after_switch", "after_reversal")
        )

        def internal_scales(self, load):
            """Those of the law, with the mean of both loads."""
            return inner_part(law, self).internal_scales(self._ratio(0.0) * load)

        def _held(self, load):
            """Largest forces that the contact can hold, forward and back."""
            inner = inner_part(law, self)
            return inner.holding_limit(self.forward_ratio * load), inner.holding_limit(self.back_ratio * load)

        def holding_limit(self, load):
            forward, back = self._held(load)
            return 0.5 * (forward + back)

        def holding_centre(self, load):
            if law.kind != "set-valued":
                return 0.0
            forward, back = self._held(load)
            return 0.5 * (forward - back)

        @property
        def symmetric(self) -> bool:
            return super().symmetric and self.forward_ratio == self.back_ratio

    return wrapped_class(anisotropic, Anisotropic, law)


@functools.cache
def backlash(law: type[Law]) -> Any:
    """The class of a law behind a joint with play: its fields, and the width of the gap.

    A pin in a hole, the seat of a friction pad: after a reversal the machine first crosses the gap, and no force acts.

        engaged e = +-1     R = R_law(v, z), the joint pushing the contact with e R > 0;    u = e gap/2
                            until e R falls to zero: the joint opens
        free e = 0          R = 0, the contact at rest and unloaded;    u' = v
                            until sgn(v) u = gap/2: the joint closes, e = sgn(v)

    The position u in the gap and e are internal states (`gap_position`, and `engaged`, switched) after those of the
    law; a run starts free, in the middle of the gap. With gap = 0 the joint opens and closes at once.

    When the joint opens, deflections (states with sign -1 under mirroring) and pieces of the law are put back to zero:
    the contact springs back, and energy that is still stored there is lost in it (with bristle damping or viscous
    friction R reaches zero before the deflection does). States of age (sign +1) go on at the velocity zero.

    Where the joint closes on a moving contact, viscous friction and bristle damping make R jump from zero. Only for
    kinked laws with internal states: a set-valued contact has no deflection to unload, so that the joint would be
    neither open nor closed at rest. Give it a stiffness first (Dahl's law, LuGre's).

    law: a kinked law with internal states that has no backlash yet, `anisotropic(...)` included
    Returns the class, the same one each time: `backlash(LuGre)(gap=0.01)`.   Raises ValueError for other laws.
    """
    if backlash in law.wrappers:
        raise ValueError(f"the {law.name} law has backlash already")
    if law.kind != "kinked" or not law.internal:
        raise ValueError(
            f"only a dynamic law (kinked, with internal states) can stand behind backlash, got the {law.name} law, "
            f"which is {law.kind} with {len(law.internal)} internal states"
        )
    signs = law.internal_symmetry or (-1,) * len(law.internal)
    kept = tuple(sign > 0 and name not in law.switched for sign, name in zip(signs, law.internal, strict=True))

    class Backlash(law):
        gap: NonNegative = parameter(0.01, "g_b", "width of the gap, the play from face to face", "gap")

        internal: ClassVar = (*law.internal, "gap_position", "engaged")
        switched: ClassVar = (*law.switched, "engaged")
        internal_symmetry: ClassVar = (*signs, -1, -1)
        special_cases: ClassVar = {law.name: {"gap": 0.0}}
        source: ClassVar[str] = f"{law.source}; nordin2002"

        def force(self, velocity, internal, side, load):
            """Friction force R and rates of the law while engaged; none, and the rates of its rest, while free."""
            *states, _, engaged = internal
            closed = engaged * engaged
            force, rates = inner_part(law, self).force(closed * velocity, tuple(states), side, load)
            return closed * force, (*rates, (1.0 - closed) * velocity, 0.0)

        def losses(self, velocity, internal, side, load):
            """Losses of the law while engaged; none while free."""
            *states, _, engaged = internal
            return inner_part(law, self).losses(engaged * engaged * velocity, tuple(states), side, load)

        def stored_energy(self, internal):
            return inner_part(law, self).stored_energy(internal[:-2])

        def switches(self, velocity, internal, side, load):
            """The joint opens; it closes; and the guards of the law while engaged."""
            *states, position, engaged = internal
            closed = engaged * engaged
            force, _ = inner_part(law, self).force(closed * velocity, tuple(states), side, load)
            half, width = 0.5 * self.gap, self.gap + 1e-9  # a gap of zero is crossed at once, and divides nothing
            opens = 1.0 - closed + closed * (MARGIN + engaged * force / load)
            closes = closed + (1.0 - closed) * (half - side * position) / width
            others = inner_part(law, self).switches(closed * velocity, tuple(states), side, load)
            return opens, closes, *(1.0 - closed + closed * guard for guard in others)

        def after_switch(self, which, velocity, internal, side, load):
            """Open, with the contact unloaded; closed on the side of the motion; the law's own pieces."""
            *states, position, engaged = internal
            if which == 0:
                unloaded = (state if keep else 0.0 for state, keep in zip(states, kept, strict=True))
                return *unloaded, 0.5 * self.gap * engaged, 0.0
            if which == 1:
                return *states, 0.5 * self.gap * side, 1.0 * side
            return (
                *inner_part(law, self).after_switch(which - 2, velocity, tuple(states), side, load),
                position,
                engaged,
            )

        def after_reversal(self, internal, side, load):
            """Internal states of the law; the joint is as it was."""
            return *inner_part(law, self).after_reversal(internal[:-2], side, load), *internal[-2:]

        def internal_scales(self, load):
            """Those of the law; half of the gap, with that of the first of the law's states; 1."""
            scales = inner_part(law, self).internal_scales(load)
            return *scales, 0.5 * self.gap + scales[0], 1.0

    return wrapped_class(backlash, Backlash, law)


@functools.cache
def smoothed(law: type[Law]) -> type[Law]:
    """The class of a set-valued law smoothed at rest: its fields, and the width and shape of the smoothing.

    The jump of the friction force becomes a steep rise, so that the contact cannot stick but creeps:

        R = S(|v|/epsilon) R_law(v),    S(x) = tanh(x)  or  (2/pi) arctan(x)

    with the law's own steady curve, viscous part included. As epsilon goes to zero it becomes the law; its slope at
    rest, N eta_s/epsilon over the mass (2/pi times that for arctan), is the rate that makes the equations stiff.
    Raises ValueError for a law that is not set-valued.
    """
    if law.kind != "set-valued":
        raise ValueError(f"only a set-valued law can be smoothed, got the {law.name} law, which is {law.kind}")

    class Smoothed(law):
        smoothing_velocity: Positive = parameter(
            1e-3, "epsilon", "speed over which friction changes its sign", "smoothing velocity"
        )
        shape: Literal["tanh", "arctan"] = parameter("tanh", "S", "function that takes the place of sgn")

        kind: ClassVar = "kinked"  # |v| in the steady curve
        special_cases: ClassVar = {}
        source: ClassVar[str] = f"{law.source}; andersson2007; leine1998"
        creeps: ClassVar[bool] = True

        def _smoothed_sign(self, speed):
            """S, the share of the friction force that is left at a speed."""
            if self.shape == "tanh":
                return tanh(speed / self.smoothing_velocity)
            return (2.0 / math.pi) * atan(speed / self.smoothing_velocity)

        def steady_force(self, speed, load, *side):
            return self._smoothed_sign(speed) * inner_part(law, self).steady_force(speed, load, *side)

        def force(self, velocity, internal, side, load):
            force, _ = inner_part(law, self).force(velocity, internal, side, load)
            return self._smoothed_sign(side * velocity) * force, ()

        def losses(self, velocity, internal, side, load):
            """All that the contact takes is lost by sliding."""
            return Law.losses(self, velocity, internal, side, load)

        def holding_limit(self, load):
            """None: the contact does not stick."""
            return Law.holding_limit(self, load)

        def holding_centre(self, load):
            return 0.0

    return wrapped_class(smoothed, Smoothed, law)


@functools.cache
def viscous(law: type[Law]) -> Any:
    """The class of a law with viscous friction beside it: its fields, and a coefficient for speed and speed squared.

    The film between the bodies, a seal, a fluid that is pushed aside: beside the dry friction of the law,

        R = R_law(v, z) + c_1 v + c_2 |v| v

    (Armstrong-Helouvry, Dupont and Canudas de Wit 1994 for c_1; the square is that of a turbulent flow). It vanishes at
    rest; its loss is one of sliding. It does not depend on the load, but grows with one that follows the motion, as all
    does that a law says there.

    law: a set-valued or kinked law that is not viscous yet
    Returns the class, the same one each time: `viscous(Coulomb)(linear_viscosity=1.0, quadratic_viscosity=0.1)`.
    Raises ValueError for a smooth law, whose |v| would have a kink, and for one with backlash: put the backlash around.
    """
    if viscous in law.wrappers:
        raise ValueError(f"the {law.name} law is viscous already")
    if "engaged" in law.internal:
        raise ValueError(f"put the backlash around, not into it: backlash(viscous(...)), got the {law.name} law")
    if law.kind == "smooth":
        raise ValueError(f"only a set-valued or kinked law can be viscous, got the {law.name} law, which is smooth")

    class Viscous(law):
        linear_viscosity: NonNegative = parameter(
            0.0, "c_1", "friction beside the law, over the speed", "viscous damping"
        )
        quadratic_viscosity: NonNegative = parameter(
            0.0, "c_2", "friction beside the law, over the square of the speed", "quadratic damping"
        )

        special_cases: ClassVar = {law.name: {"linear_viscosity": 0.0, "quadratic_viscosity": 0.0}}
        source: ClassVar[str] = f"{law.source}; armstrong1994"

        def _viscous(self, speed):
            """c_1 + c_2 |v|, over which the velocity is multiplied."""
            return self.linear_viscosity + self.quadratic_viscosity * speed

        def steady_force(self, speed, load, *side):
            return inner_part(law, self).steady_force(speed, load, *side) + self._viscous(speed) * speed

        def force(self, velocity, internal, side, load):
            force, rates = inner_part(law, self).force(velocity, internal, side, load)
            return force + self._viscous(side * velocity) * velocity, rates

        def losses(self, velocity, internal, side, load):
            """Losses of the law; that of the viscous part is one of sliding."""
            sliding, bristles = inner_part(law, self).losses(velocity, internal, side, load)
            return sliding + self._viscous(side * velocity) * velocity * velocity, bristles

    return wrapped_class(viscous, Viscous, law)
