"""Rows of two to twenty blocks on a belt, each on a spring from a wall and joined to the next one by another."""

import itertools
from collections.abc import Mapping
from typing import Any, ClassVar

from pydantic import model_validator

from vibrocap.physics.dimensions.scales import oscillation
from vibrocap.physics.machines.machine import NonNegative, Number, Positive
from vibrocap.physics.machines.row import Numbered, Row, row_of
from vibrocap.physics.mechanics.parts import Contact, Damper, Drive, Mass, Spring, Support, coordinate
from vibrocap.physics.names import numbered


@model_validator(mode="after")
def some_block_rubs(row):
    """Refuse a row without any load, which has no natural force; every class of `BlockRow` names this validator."""
    loads = [getattr(row, numbered("normal_load", i)) for i in range(1, row.bodies + 1)]
    if not any(loads):
        raise ValueError(f"normal_load should be > 0 of one block at least, got 0 for all {row.bodies}")
    return row


class BlockRow(Row):
    """Blocks 1, 2, ... in a row on a belt of the speed v_b, with springs and dampers to a wall and to each other.

    One block of it is the `Oscillator`; more are the models of chattering brakes and of earthquakes (Burridge and
    Knopoff 1967; Galvanetto and Bishop 1994; Pascal 2008). x_i is how far block i is from where no spring is stretched,
    v_i its velocity over the belt, exactly zero while it sticks:

        x_i' = v_i + v_b,     m_i v_i' = a_i drive - k_i x_i - c_i x_i' + F_i - F_(i-1) - R_i
        F_i = kappa_i (x_(i+1) - x_i) + gamma_i (x_(i+1)' - x_i')

    What has no number in its name belongs to block 1 or to the first gap. A row that is pulled over fixed ground by its
    wall springs, whose far ends move at the speed V, is the same system: v_b = -V. A block without load does not rub;
    it needs a law that is set-valued at rest. Any consistent units may be used; loads are forces.
    """

    called: ClassVar = ("block", "row")
    source: ClassVar[str] = "burridge1967; galvanetto1994; pascal2008"
    summary: ClassVar = "blocks in a row on a belt, on springs to a wall and to each other."
    belt_speed: Any
    row_parameters: ClassVar = (
        Numbered("mass", "body", Positive, Positive, 1.0, "m", "mass of block {}", "mass"),
        Numbered("stiffness", "body", NonNegative, NonNegative, 1.0, "k", "spring of block {} to a wall", "stiffness"),
        Numbered(
            "damping", "body", NonNegative, NonNegative, 0.0, "c", "damper of block {} to a wall", "viscous damping"
        ),
        Numbered("actuation", "body", Number, Number, 1.0, "a", "share of the drive that acts on block {}", "share"),
        Numbered(
            "normal_load", "body", NonNegative, NonNegative, 1.0, "N", "load on block {}; 0: it does not rub", "load"
        ),
        Numbered("coupling_stiffness", "gap", NonNegative, NonNegative, 1.0, "kappa", "spring in gap {}", "stiffness"),
        Numbered(
            "coupling_damping", "gap", NonNegative, NonNegative, 0.0, "gamma", "damper in gap {}", "viscous damping"
        ),
        Numbered("belt_speed", "row", Number, Number, 0.0, "v_b", "speed of the belt under the blocks", "speed"),
    )

    @classmethod
    def of_bodies(cls, bodies: int) -> Mapping[str, Any]:
        """The coordinates, block by block."""
        position = coordinate("x", "place of each block", "m", rate="sliding_velocity", count=bodies)
        return {"position": position, "_loads": some_block_rubs}

    def parts(self, q):
        belt = Support("belt", x=self.belt_speed * q.time)
        parts, blocks, gaps = [belt], [], [b - a for a, b in itertools.pairwise(q.position)]
        own = (self._all(name, self.bodies) for name in ("mass", "stiffness", "damping", "actuation", "normal_load"))
        for i, (x, mass, stiffness, damping, share, load) in enumerate(zip(q.position, *own, strict=True), start=1):
            blocks.append(Mass(f"body {i}", mass, x=x))
            parts += [blocks[-1], Spring(stiffness, x), Damper(damping, x), Drive(x, share)]
            parts += [Contact(blocks[-1], on=belt, load=load)]
        between = (self._all(name, len(gaps)) for name in ("coupling_stiffness", "coupling_damping"))
        for gap, stiffness, damping in zip(gaps, *between, strict=True):
            parts += [Spring(stiffness, gap), Damper(damping, gap)]
        return parts

    def scales(self, time=1.0):
        """Way and speed that a force of the size of all loads gives to all bodies together."""
        return oscillation(self._whole("mass"), self._whole("stiffness"), self.effort_scale(), time) * self.bodies


def block_row(blocks: int) -> Any:
    """The class of a row of two to twenty blocks, "two-block-row" and so on."""
    return row_of(BlockRow, blocks)


TwoBlockRow = block_row(2)
ThreeBlockRow = block_row(3)
