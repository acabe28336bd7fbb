"""Friction laws for the contract tests: every law, some of them wrapped, with defaults and with random values."""

import dataclasses
import random

from imposed_motion import settled_pieces
from vibrocap.physics.catalogue import law, laws
from vibrocap.physics.parameters import ParameterError, parameter_table

WRAPPED = (
    "anisotropic-stribeck",
    "anisotropic-lugre",
    "anisotropic-maxwell-slip",
    "backlash-bouc-wen",
    "backlash-rate-and-state-ageing",
    "backlash-anisotropic-elasto-plastic",
    "anisotropic-backlash-dahl",
    "smoothed-exponential",
    "smoothed-anisotropic-hyperbolic-stribeck",
)


def varied(part, seed):
    """A part with every number changed at random by up to a fifth; a zero becomes a number too."""
    draw = random.Random(f"{part.name} {seed}")
    values = {info.name: info.default for info in parameter_table(part)}
    while True:
        try:
            return part(
                **{
                    name: (value * draw.uniform(0.8, 1.2) or draw.uniform(0.2, 0.5))
                    if isinstance(value, float)
                    else value
                    for name, value in values.items()
                }
            )
        except ParameterError:  # a number beyond its bounds
            continue


def instances(parts, sets=2):
    """Each part with its defaults and with some random sets of values."""
    return [make for part in parts for make in (part(), *(varied(part, 1 + i) for i in range(sets)))]


def special_laws():
    """Laws with values that choose another formula or another claim than the defaults do."""
    lugre, elasto_plastic = law("lugre"), law("elasto-plastic")
    return [
        lugre(damping_velocity=0.07, viscous_damping=0.3),
        lugre(viscous_damping=20.5),
        lugre(damping_velocity=0.05, viscous_damping=1.2),
        elasto_plastic(viscous_damping=20.5),
        *(law("dahl")(shape_exponent=exponent) for exponent in (1.5, 2.0, 3.0)),
        law("maxwell-slip")(static_coefficient=0.15),
        law("bouc-wen")(knee_exponent=1.0, elastic_shape=-0.3),
        law("bouc-wen")(knee_exponent=3.0, elastic_shape=0.2),
        law("stribeck")(stribeck_exponent=1.0, viscous_damping=0.2),
        law("smoothed-coulomb")(shape="arctan"),
    ]


LAWS = [*instances(laws().values(), 1), *instances(map(law, WRAPPED), 1), *special_laws()]
LAW_NAMES = [f"{part.name} {i}" for i, part in enumerate(LAWS)]


def draws(count, seed="contracts"):
    """As many random generators."""
    return [random.Random(f"{seed} {i}") for i in range(count)]


def random_internal(law, velocity, side, load, draw):
    """Internal states within their natural size, with the pieces that belong to them."""
    internal = tuple(
        0.0 if name in law.switched else draw.uniform(-1, 1) * scale
        for name, scale in zip(law.internal, law.internal_scales(load), strict=True)
    )
    if "engaged" in law.internal:
        internal = (*internal[:-1], draw.choice((-1.0, 0.0, 1.0)))
    return settled_pieces(law, velocity, internal, side, load)


def random_motion(law, draw):
    """(velocity, internal states, side, load) of a contact."""
    side, load = draw.choice((1, -1)), draw.uniform(0.3, 2.0)
    velocity = side * draw.uniform(0.0, 1.0) ** 3
    return velocity, random_internal(law, velocity, side, load, draw), side, load


def without_viscosity(law):
    """The same law without its viscous part, the part that does not scale with the load."""
    return dataclasses.replace(law, viscous_damping=0.0) if hasattr(law, "viscous_damping") else law


def mirrored(law, internal):
    """Internal states of the mirrored motion."""
    signs = law.internal_symmetry or (-1,) * len(law.internal)
    return tuple(sign * state for sign, state in zip(signs, internal, strict=True))
