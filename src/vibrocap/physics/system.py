"""A system: a machine on a friction law, moved by a drive. The one place where their equations meet."""

import dataclasses
from typing import Any

from vibrocap.arguments import ArgumentError, suggestion
from vibrocap.physics.drives.drive import Drive
from vibrocap.physics.friction.law import Law
from vibrocap.physics.machines.machine import Machine
from vibrocap.physics.parameters import ParameterError, parameter_table
from vibrocap.physics.part import PartInSI
from vibrocap.physics.scales import Scales
from vibrocap.physics.system_in_si import parts_without_units
from vibrocap.physics.units import Units, state_units

PARTS = ("machine", "friction", "drive")


@dataclasses.dataclass(frozen=True)
class Flow:
    """Everything that the equations say at one instant, as numbers or as recorded expressions."""

    rates: tuple  # y', one per state
    drive: Any
    contact_velocity: Any
    friction: Any  # friction force R
    sliding_friction: Any  # R where the contact slides
    outer_force: Any  # along the line of sliding, other than friction
    holding_force: Any  # R that would keep a resting contact at rest
    holding_middle: Any  # of the forces that the contact can hold at rest
    holding_limit: Any  # how far they reach from their middle; None where the law is not set-valued
    switches: tuple  # guards of the pieces of the law, positive within the present one
    after_switch: tuple  # internal states after each switch
    after_reversal: tuple  # internal states after the contact has turned to the side
    powers: tuple  # one per channel, positive into the system
    energy: Any  # of the machine
    contact_energy: Any  # stored in the contact


@dataclasses.dataclass(frozen=True)
class System:
    """Machine + friction + drive.

    The state vector holds the machine's states, then the internal states of the law. A set-valued law is given the
    force that holds the contact wherever it sticks (side 0), so that one set of equations serves sliding and sticking.

    units: what one unit of each quantity is in SI, None where that is left open. Computed is without units always; a
    system that knows its scales has results in SI as well (`motion.si`, the columns of a sweep, files and pictures).
    Parts in SI, `PendulumCapsule.in_si(...)` and so on, bring their scales with them.
    """

    machine: Machine
    friction: Law
    drive: Drive
    units: Scales | None = None

    def __post_init__(self):
        given = {part: getattr(self, part) for part in PARTS}
        if any(isinstance(part, PartInSI) for part in given.values()):
            found, scales = parts_without_units(given, self.units)
            for name, value in (found | {"units": scales}).items():
                object.__setattr__(self, name, value)
        if self.units is not None and not isinstance(self.units, Scales):
            wanted = self.machine.si_scales.__name__
            raise TypeError(f"units should be scales, {wanted}(...), got {self.units!r}")
        for part, contract in zip(PARTS, (Machine, Law, Drive), strict=True):
            given = getattr(self, part)
            if not isinstance(given, contract):
                raise TypeError(f"{part} should be a {contract.__name__.lower()}, got {given!r}")
        if self.friction.internal and self.machine.normal_load == 0:
            raise ArgumentError("machine.normal_load", f"should be > 0 with the {self.friction.name} law, got 0")

    @property
    def si(self) -> Units:
        """Factor and SI unit of every quantity. ValueError where the scales are not known."""
        if self.units is None:
            wanted = type(self.machine).si_scales.__name__
            raise ValueError(f"units: are not known; make the system of parts in SI, or give it units={wanted}(...)")
        return Units(self.units, self.machine.effort, state_units(self.machine, self.friction))

    @property
    def state_names(self) -> tuple[str, ...]:
        """Names of the states, in the order of the state vector."""
        return self.machine.states + self.friction.internal

    @property
    def channels(self) -> tuple[str, ...]:
        """Names of the energy channels, in the order of `Flow.powers`."""
        return (*self.machine.channels, "contact_sliding", "bristle_loss")

    @property
    def symmetry(self) -> tuple[int, ...]:
        """Sign of each state under the half-period symmetry."""
        internal = self.friction.internal_symmetry
        return self.machine.symmetry + ((-1,) * len(self.friction.internal) if internal is None else internal)

    def scales(self) -> tuple:
        """Natural size of each state, over which its error is measured."""
        return (*self.machine.scales(self.drive.period), *self.friction.internal_scales(self.machine.load()))

    @property
    def mirrored(self) -> bool:
        """Whether the half-period symmetry holds: the mirror image of a motion, half a period later, is a motion."""
        return self.drive.odd and self.machine.symmetric and self.friction.symmetric

    def flow(self, t, y, side) -> Flow:
        """The equations at time t and state y, sliding to `side` (+1, -1) or stuck (0, set-valued laws only)."""
        mechanical, internal = y[: len(self.machine.states)], y[len(self.machine.states) :]
        drive = self.drive.value(t)
        load = self.machine.load()
        velocity = self.machine.contact_velocity(t, mechanical)
        hold = self.machine.holding_force(t, mechanical, drive)
        force, internal_rates = self.friction.force(velocity, internal, side, load)
        sliding_friction = force
        sliding_loss, bristle_loss = self.friction.losses(velocity, internal, side, load)
        limit = None
        if self.friction.kind == "set-valued":
            slipping = side * side
            force = hold + slipping * (force - hold)
            sliding_loss = slipping * sliding_loss
            limit = self.friction.holding_limit(load)
        switches = self.friction.switches(velocity, internal, side, load)
        return Flow(
            rates=(*self.machine.rates(t, mechanical, drive, force), *internal_rates),
            drive=drive,
            contact_velocity=velocity,
            friction=force,
            sliding_friction=sliding_friction,
            outer_force=self.machine.outer_force(t, mechanical, drive),
            holding_force=hold,
            holding_middle=self.friction.holding_middle(load),
            holding_limit=limit,
            switches=switches,
            after_switch=tuple(
                self.friction.after_switch(which, velocity, internal, side, load) for which in range(len(switches))
            ),
            after_reversal=self.friction.after_reversal(internal, side, load),
            powers=(*self.machine.powers(t, mechanical, drive, force), -sliding_loss, -bristle_loss),
            energy=self.machine.energy(t, mechanical),
            contact_energy=self.friction.stored_energy(internal),
        )

    def rates(self, t, y, side) -> tuple:
        """y' at time t and state y, sliding to `side` or stuck (0)."""
        return self.flow(t, y, side).rates

    @property
    def parameter_paths(self) -> tuple[str, ...]:
        """Paths of all parameters, such as "machine.mass_ratio"."""
        return tuple(f"{part}.{info.name}" for part in PARTS for info in parameter_table(getattr(self, part)))

    def parameter(self, path: str) -> Any:
        """The value of the parameter at a path such as "machine.mass_ratio"; ValueError for a path that is none."""
        part, name = self._resolved(path)
        return getattr(getattr(self, part), name)

    def with_parameters(self, values: dict[str, Any]) -> "System":
        """The same system with other values at the given parameter paths; ValueError for what a part does not take."""
        changes: dict[str, dict[str, Any]] = {}
        for path, value in values.items():
            part, name = self._resolved(path)
            changes.setdefault(part, {})[name] = value
        parts: dict[str, Any] = {}
        for part, fields in changes.items():
            given: Any = getattr(self, part)
            try:
                parts[part] = dataclasses.replace(given, **fields)
            except ParameterError as error:
                raise error.within(part) from None
        return dataclasses.replace(self, **parts)

    def _resolved(self, path: str) -> tuple[str, str]:
        if path not in self.parameter_paths:
            near = suggestion(path, self.parameter_paths, cutoff=0.0)
            raise ArgumentError(str(path), f"there is no such parameter in this system; {near}")
        part, name = path.split(".", 1)
        return part, name
