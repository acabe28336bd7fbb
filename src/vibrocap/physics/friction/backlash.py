"""Backlash in series: any law with deflections behind a joint that has play."""

import functools
from typing import Any, ClassVar

from vibrocap.physics.friction.law import Law, NonNegative, parameter
from vibrocap.physics.parameters import inner_part, wrapped_class

MARGIN = 1e-9  # of the load, to which the force is negative before the joint opens


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
