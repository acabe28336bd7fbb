"""The oscillator with stops: a block on the ground, with or without a spring, that strikes a stop or is between two."""

import math
from typing import Annotated, ClassVar

from pydantic import Field, model_validator

from hand_machines.oscillator import Oscillator
from hand_machines.stops import (
    BackGap,
    ElasticStops,
    StopDamping,
    StopStiffness,
    stop_shapes,
    which_stop,
)
from vibrocap.physics.elementary import sqrt
from vibrocap.physics.machines.machine import IMPACT, Machine, Positive, Shape, parameter, parameters, rebounds

LEAST_PULL = 1e-12  # of the load: with this acceleration the block leaves a wall, so that its direction is no rounding
Restitution = Annotated[float, Field(strict=True, allow_inf_nan=False, ge=0, le=1)]


@parameters
class OscillatorWithStops(Oscillator):
    """Oscillator that strikes a stop on the ground: in front at x = delta, and behind at x = -delta_b if given.

    Energy harvesters, impact absorbers, spool valves: a block between two stops, with dry friction. Without
    `stop_stiffness` the stops are rigid walls, off which it bounces,

        x' := -e x',     (1 - e^2) m x'^2/2 is lost,     (1 + e) m x' goes into the ground

    with no impulse of friction, which is finite. A block that is pushed against a wall rests there after its rebounds,
    of which those slower than 1e-7 sqrt(N delta/m) are left out (`rebounds`):

        at the wall   x' = 0,     until   drive - k x - c x' - R = 0,

    the force W with which the wall then pushes back (`wall_force`). While the block is at rest the wall takes all of
    that force and friction none: how they share it is open, the motion is not, as friction would hold what is left.
    On a running belt friction slides at the wall. With `stop_stiffness` the stops are springs (`ElasticStops`), whose
    force counts as one from outside.

    Units: any consistent ones, see `Oscillator`.
    """

    gap: Positive = parameter(0.8, "delta", "way of the block to the stop in front", "gap")
    back_gap: BackGap = parameter(
        None, "delta_b", "way of the block to the stop behind; none where there is no such stop", "gap"
    )
    restitution: Restitution = parameter(0.7, "e", "coefficient of restitution of rigid stops, 0 to 1", "fraction")
    stop_stiffness: StopStiffness = parameter(
        None, "k_s", "spring of an elastic stop; none where the stops are rigid", "stiffness"
    )
    stop_damping: StopDamping = parameter(
        None, "c_s", "damper of an elastic stop; none where it has none", "viscous damping"
    )
    back_stop_stiffness: StopStiffness = parameter(
        None, "k_b", "spring of the stop behind; none where it is that of the one in front", "stiffness"
    )
    back_stop_damping: StopDamping = parameter(
        None, "c_b", "damper of the stop behind; none where it is that of the one in front", "viscous damping"
    )

    source: ClassVar[str] = "denhartog1931; shaw1983"
    name: ClassVar[str] = "oscillator-with-stops"
    mechanism = Machine.mechanism  # stops have no part there
    states: ClassVar = (*Oscillator.states, "touching")
    symmetry: ClassVar = (-1, -1, -1)
    switched: ClassVar = ("touching",)
    switch_events: ClassVar = ("impact", "stop_opened", "impact")
    strikes_ground: ClassVar = ("impact",)
    channels: ClassVar = (*Oscillator.channels, IMPACT)

    @model_validator(mode="after")
    def _told_of_stops_that_there_are(self):
        behind = ("back_stop_stiffness", "back_stop_damping")
        for name in ("stop_damping", *behind):
            missing = "back_gap" if name in behind and self.back_gap is None else ""
            missing = missing or ("stop_stiffness" if self.stop_stiffness is None else "")
            if getattr(self, name) is not None and missing:
                raise ValueError(f"{name} should be left out without {missing}, got {getattr(self, name)}")
        return self

    @property
    def _rigid(self) -> bool:
        return self.stop_stiffness is None

    @property
    def _stops(self) -> ElasticStops:
        """Both stops, where they are elastic."""
        back = self.back_stop_stiffness, self.stop_damping, self.back_stop_damping
        return ElasticStops(self.gap, self.back_gap, self.stop_stiffness, *back)

    @property
    def locked(self):  # type: ignore[override]
        """At a rigid stop it stays where it is."""
        return {"touching": ("position", "sliding_velocity")} if self._rigid else {}

    @property
    def symmetric(self) -> bool:
        """Only on a belt at rest, with stops on both sides that are alike, at the same distance."""
        return super().symmetric and self._stops.symmetric

    def scales(self, time=1.0):
        """As of the oscillator; which stop is touched is a number."""
        return *super().scales(time), 1.0

    def room(self):
        """Between rigid stops."""
        return {"position": (-math.inf if self.back_gap is None else -self.back_gap, self.gap)} if self._rigid else {}

    def _free(self, y):
        """1; 0 at a rigid stop."""
        return 1.0 - y[2] * y[2] if self._rigid else 1.0

    def outer_force(self, t, y, drive):
        """drive - k x - c x', less F of an elastic stop; that of a rigid one is `wall_force`."""
        own = super().outer_force(t, y, drive)
        return own if self._rigid else own - self._stops.force(y[0], y[1] + self.belt_speed, y[2])

    def wall_force(self, t, y, drive, frictions):
        """-W of a rigid stop: what would else move the block."""
        return (1.0 - self._free(y)) * (frictions[0] - self.outer_force(t, y, drive)) if self._rigid else 0.0

    def _held(self, t, y, drive):
        """R that keeps v' = 0: all other forces; none at a rigid stop, which takes them."""
        return self._free(y) * self.outer_force(t, y, drive)

    def rates(self, t, y, drive, frictions):
        """y' = (x', v', 0); at a rigid stop v' = 0."""
        return y[1] + self.belt_speed, (self._held(t, y, drive) - self._free(y) * frictions[0]) / self.mass, 0.0

    def energy(self, t, y):
        """H, with that of an elastic stop."""
        own = super().energy(t, y)
        return own if self._rigid else own + self._stops.energy(y[0], y[2])

    def powers(self, t, y, drive, frictions):
        """Powers of drive, damper, with that of an elastic stop, and belt; impacts take their energy at one instant."""
        drives, damper, belt = super().powers(t, y, drive, frictions)
        taken = None if self._rigid else self._stops.damper_power(y[1] + self.belt_speed, y[2])
        return drives, damper if taken is None else damper + taken, belt, 0.0

    def switches(self, t, y, drive, frictions):
        """The block reaches the stop in front; it leaves, or the wall would have to pull; it reaches the one behind."""
        if not self._rigid:
            return self._stops.guards(y[0], y[2], self.gap, self.back_gap)
        free = self._free(y)
        reaches = 1.0 - free + free * (self.gap - y[0]) / self.gap
        pressed = (
            free + y[2] * (self.outer_force(t, y, drive) - frictions[0]) / self.normal_load + (1.0 - free) * LEAST_PULL
        )
        if self.back_gap is None:
            return reaches, pressed
        return reaches, pressed, 1.0 - free + free * (y[0] + self.back_gap) / self.back_gap

    def after_switch(self, which, t, y, drive, frictions):
        """It bounces, or stays at the wall; it leaves the wall, from rest. At an elastic stop nothing jumps."""
        if not self._rigid:
            return *y[:2], (1.0, 0.0, -1.0)[which]
        if which == 1:
            (front, back), free = which_stop(y[2]), self._free(y)
            wall = front * self.gap if self.back_gap is None else front * self.gap - back * self.back_gap
            return wall + free * y[0], free * y[1] - (1.0 - free) * self.belt_speed, 0.0  # exactly at rest at the wall
        side, speed = 1.0 if which == 0 else -1.0, y[1] + self.belt_speed
        bounces = rebounds(side * self.restitution * speed / sqrt(self.normal_load * self.gap / self.mass))
        wall = self.gap if which == 0 else -self.back_gap  # so that rounding does not add up over many rebounds
        return wall, -bounces * self.restitution * speed - self.belt_speed, side * (1.0 - bounces)

    def scene(self, t, y) -> tuple[Shape, ...]:
        """With the stops: the nearest sides of the block touch them where it has gone its way."""
        return *super().scene(t, y), *stop_shapes(0.0, self.gap, self.back_gap, 0.5)
