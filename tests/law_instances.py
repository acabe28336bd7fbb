"""Friction laws for the contract tests: every law, some of them wrapped, with defaults and with random values."""

import dataclasses

from vibrocap.contracts.samples import instances
from vibrocap.physics.catalogue import law, laws

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
    "viscous-coulomb",
    "viscous-lugre",
    "anisotropic-viscous-exponential",
    "backlash-viscous-dahl",
)


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
        law("viscous-stribeck")(viscous_damping=0.2, linear_viscosity=0.3, quadratic_viscosity=0.7),
    ]


LAWS = [*instances(laws().values(), 1), *instances(map(law, WRAPPED), 1), *special_laws()]
LAW_NAMES = [f"{part.name} {i}" for i, part in enumerate(LAWS)]


def without_viscosity(law):
    """The same law without its viscous parts, which do not scale with the load."""
    names = ("viscous_damping", "linear_viscosity", "quadratic_viscosity")
    return dataclasses.replace(law, **{name: 0.0 for name in names if hasattr(law, name)})
