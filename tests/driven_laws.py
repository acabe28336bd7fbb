"""Laws whose response to an imposed motion is known, random records, and driven kernels as plain Python, for tests."""

import contextlib
import functools
from typing import ClassVar
from unittest import mock

import numpy as np

from vibrocap.laboratory.driven import driven_equations
from vibrocap.numerics.codegen.driven_source import driven_source
from vibrocap.numerics.linker import DRIVEN, linked_source, plain_kernel
from vibrocap.numerics.run import driven_run
from vibrocap.physics.friction.law import Law, Positive, parameter, parameters


@parameters
class Play(Law):
    """An elastic, perfectly plastic element: a spring that slips at its reach, a latch, and the distance slipped."""

    stiffness: Positive = parameter(3.0, "k", "stiffness")
    reach: Positive = parameter(0.2, "r", "greatest deflection")

    name: ClassVar[str] = "play"
    kind: ClassVar = "kinked"
    internal: ClassVar = ("slipping", "spring", "slipped")  # the switched state first: the engine sorts them
    switched: ClassVar = ("slipping",)

    def force(self, velocity, internal, side, load):
        slipping, spring, _ = internal
        return load * self.stiffness * spring, (0.0, (1.0 - slipping) * velocity, slipping * velocity)

    def switches(self, velocity, internal, side, load):
        slipping, spring, _ = internal
        return ((1.0 - slipping) * (self.reach - side * spring) + slipping,)

    def after_switch(self, which, velocity, internal, side, load):
        return (1.0, side * self.reach, internal[2])

    def after_reversal(self, internal, side, load):
        return (0.0, *internal[1:])

    def internal_scales(self, load):
        return (1.0, self.reach, self.reach)


@parameters
class Chatter(Play):
    """The same with a switch that leaves its guard where it was."""

    name: ClassVar[str] = "chatter"

    def after_switch(self, which, velocity, internal, side, load):
        return internal


@parameters
class Held(Play):
    """The same as if the contact could hold any force at rest."""

    name: ClassVar[str] = "held"
    kind: ClassVar = "set-valued"


@parameters
class Chain(Law):
    """Three coupled linear states: a full Jacobian with a hole that elimination fills."""

    rate: Positive = parameter(2.0, "c", "rate")

    name: ClassVar[str] = "chain"
    kind: ClassVar = "smooth"
    internal: ClassVar = ("first", "second", "third")
    matrix: ClassVar = np.array([[-1.0, 0.7, 0.4], [0.9, -2.0, 0.0], [-0.6, 0.0, -30.0]])

    def force(self, velocity, internal, side, load):
        x, y, z = internal
        a = self.matrix.tolist()
        rates = (
            velocity + self.rate * (a[0][0] * x + a[0][1] * y + a[0][2] * z),
            self.rate * (a[1][0] * x + a[1][1] * y) + load,
            self.rate * (a[2][0] * x + a[2][2] * z) - velocity,
        )
        return x + y + z, rates

    def internal_scales(self, load):
        return (1.0, 1.0, 1.0)


def uneven(rng, count, length):
    """Increasing times over [0, length]."""
    steps = rng.uniform(0.2, 1.8, count - 1)
    return np.concatenate(([0.0], np.cumsum(steps) * length / steps.sum()))


def wandering(rng, time, size):
    """A smooth random velocity."""
    tones = rng.normal(size=(2, 5)) / np.arange(1, 6)
    phases = 2.0 * np.pi * np.outer(np.arange(1, 6), time) / time[-1]
    return size * (tones[0] @ np.sin(phases) + tones[1] @ np.cos(phases))


@functools.cache
def plain_driven(equations):
    layout, generated = driven_source(equations)
    return layout, plain_kernel(linked_source(generated, DRIVEN))


@contextlib.contextmanager
def on_plain_python(law, free=()):
    """Within this context a law of this form runs on its plain kernel: some are not worth the time to compile."""
    layout, names = plain_driven(driven_equations(law, free))
    with mock.patch.object(driven_run, "driven_kernel", return_value=(layout, names["follow"])):
        yield names
