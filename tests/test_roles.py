"""Roles of parameters: declared with them, so that fits and units know any law, whatever its parameters are called."""

from typing import ClassVar

import numpy as np
import pytest

from vibrocap.identification.experiments.experiment_design import joined, ramp, synthetic_record
from vibrocap.identification.fit import fit
from vibrocap.identification.fit_result import dimensionless
from vibrocap.identification.problem.parametrisation import EXPECTED, UNKNOWN, parametrisation, role
from vibrocap.identification.problem.samples import data_scales, samples
from vibrocap.physics.catalogue import drives, laws, machines, wrappers
from vibrocap.physics.dimensions.scales import PendulumScales
from vibrocap.physics.friction.bristles import LuGre
from vibrocap.physics.friction.curves import HyperbolicStribeck
from vibrocap.physics.friction.law import Law, NonNegative, Positive, parameter, parameters
from vibrocap.physics.parameters import (
    COEFFICIENT,
    FORCE,
    LENGTH,
    MASS,
    NUMBER,
    ROLES,
    SPEED,
    TIME,
    TORQUE,
    dimension_of_unit,
    parameter_table,
)

WRAPPED = [wrappers()[wrapper](laws()["lugre"]) for wrapper in ("anisotropic", "backlash")]
PARTS = [
    *laws().values(),
    *WRAPPED,
    wrappers()["smoothed"](laws()["coulomb"]),
    *machines().values(),
    *drives().values(),
]


@parameters
class Own(Law):
    """The hyperbolic law under names that say nothing."""

    low: NonNegative = parameter(0.9, "c", "level at high speed", "level")
    high: NonNegative = parameter(0.95, "s", "level at rest", "static level")
    knee: Positive = parameter(3.0, "q", "half of the drop", "Stribeck velocity")

    name: ClassVar[str] = "own"
    kind: ClassVar = "set-valued"

    def steady_force(self, speed, load):
        return load * (self.low + (self.high - self.low) / (1.0 + speed / self.knee))

    def force(self, velocity, internal, side, load):
        return side * self.steady_force(side * velocity, load), ()

    def holding_limit(self, load):
        return load * self.high


@parameters
class WithoutRoles(Own):
    """The same, of someone who declares nothing."""

    low: NonNegative = parameter(0.2, "c", "level at high speed")
    high: NonNegative = parameter(0.4, "s", "level at rest")
    knee: Positive = parameter(0.08, "q", "half of the drop")


@pytest.fixture(scope="module")
def record():
    truth = HyperbolicStribeck(coulomb_coefficient=0.15, static_coefficient=0.45, stribeck_velocity=0.05)
    motion = joined([ramp(0.4, 6.0, 200), ramp(0.1, 6.0, 200)], "sweeps")
    return synthetic_record(truth, motion, noise=0.01, seed=0)


@pytest.mark.parametrize("part", PARTS, ids=lambda part: part.name)
def test_every_number_of_a_part_declares_what_it_is(part):
    for info in parameter_table(part):
        assert info.dimension is not None or isinstance(info.default, str), info.name
        assert info.role in ROLES or isinstance(info.default, str), info.name
        assert not issubclass(part, Law) or info.role in EXPECTED or isinstance(info.default, str), info.name


def test_every_role_that_fits_know_is_one_that_can_be_declared():
    assert set(EXPECTED) <= set(ROLES)


def test_a_law_with_names_of_its_own_is_fitted_by_its_roles(record):
    """It starts where the data are, not at its own values, and its static level stays above the other."""
    chosen = parametrisation(Own, data_scales([samples(record)]))
    assert {coordinate.name: coordinate.partner for coordinate in chosen.space.coordinates} == {
        "low": "",
        "knee": "",
        "high": "low",
    }
    assert chosen.template.low < 0.5
    assert chosen.template.knee < 0.5
    fitted = fit(record, Own, starts=2, intervals="covariance")
    for name, true in (("low", 0.15), ("high", 0.45), ("knee", 0.05)):
        assert true in fitted[name], name
    assert [fitted[name].unit for name in ("low", "high", "knee")] == ["N", "N", "m/s"]


def test_a_law_that_declares_nothing_is_fitted_from_its_own_values(record):
    assert role(WithoutRoles, "knee") is UNKNOWN
    fitted = fit(record, WithoutRoles, starts=2, intervals="covariance")
    assert fitted["knee"].unit == ""
    assert fitted.law.low == pytest.approx(0.15, rel=0.1)


def test_what_has_no_known_dimension_is_not_converted():
    scales = PendulumScales(0.2, 0.1)
    assert dimensionless(Own(), scales, True).knee == 3.0 / scales.of(SPEED)
    with pytest.raises(ValueError, match=r"low: has no known dimension.*declare its role or its unit.*in WithoutRoles"):
        dimensionless(WithoutRoles(), scales, True)


def test_the_speed_at_which_damping_fades_is_a_speed_for_a_fit():
    """By its name it was once taken for a damping."""
    assert role(LuGre, "damping_velocity").dimension == SPEED


def test_dimensions_and_units():
    assert dimension_of_unit("N s/m") == FORCE / SPEED == FORCE * TIME / LENGTH
    assert dimension_of_unit("kg") == dimension_of_unit("N s^2/m") == MASS
    assert dimension_of_unit("1/s^0.5") == NUMBER / TIME**0.5
    assert dimension_of_unit("1") == NUMBER
    assert dimension_of_unit("J") == TORQUE
    assert MASS.unit() == "N s^2/m"
    assert (NUMBER / TIME).unit() == "1/s"
    assert NUMBER.unit() == "1"
    assert COEFFICIENT.unit() == "1"
    assert COEFFICIENT.unit(known_load=False) == "N"
    assert ROLES["effort rate"].unit() == "N/s"
    assert ROLES["effort"].resolved(TORQUE) == TORQUE


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"role": "levl"}, r"role: there is no role 'levl'.*level"),
        ({"unit": "furlong"}, r"unit: 'furlong' in 'furlong' is none of 1, rad, N, m"),
        ({"unit": "N/m/s"}, r'one "/" at most'),
        ({"unit": "N/"}, r'one "/" at most'),
        ({"role": "level", "unit": "N"}, "not both"),
    ],
)
def test_a_role_or_unit_that_there_is_not_is_refused(given, said):
    with pytest.raises(ValueError, match=said):
        parameter(1.0, "x", "meaning", **given)


def test_natural_sizes_are_those_of_the_record(record):
    scales = data_scales([samples(record)])
    assert scales.natural(SPEED) == pytest.approx(scales.speed)
    assert scales.natural(COEFFICIENT) * scales.load == pytest.approx(scales.level)
    assert np.isfinite(scales.natural(ROLES["bristle damping"]))
