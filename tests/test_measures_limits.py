"""Frictional limits: closed forms, the paper's approximations beside them, and when there is nothing to find."""

import dataclasses
import json
import math

import pytest
from scipy.special import lambertw

import vibrocap as vc

ROUNDING = 1e-14  # relative: a few operations


def slope_by_difference(law, load, velocity):
    """Central differences with Richardson's extrapolation: error of the order of 1e-11."""

    def quotient(h):
        return (vc.steady_friction(law, load, velocity + h) - vc.steady_friction(law, load, velocity - h)) / (2 * h)

    h = 1e-3 * abs(velocity)
    return (4.0 * quotient(h) - quotient(2 * h)) / 3.0


def test_levels_of_the_paper():
    limits = vc.frictional_limits(vc.LuGre(), 2.0)
    assert limits.deflection_limit == pytest.approx(2.0 * 0.45 / 100.0, rel=ROUNDING)
    assert limits.breakaway_force == pytest.approx(0.9, rel=ROUNDING)
    assert limits.coulomb_force == pytest.approx(0.3, rel=ROUNDING)
    exponential = vc.frictional_limits(vc.Exponential(), 2.0)
    assert (exponential.deflection_limit, exponential.offset, exponential.boundary_velocity) == (None, None, None)
    assert exponential.breakaway_force == pytest.approx(0.9, rel=ROUNDING)


@pytest.mark.parametrize("velocity", [0.05, 0.3, -0.05, -0.3])
def test_steady_curve_is_odd_and_its_slope_even(velocity):
    law, load = vc.LuGre(viscous_damping=0.4, stribeck_exponent=1.7), 1.3
    x = abs(velocity) / 0.1
    expected = load * (0.15 + 0.3 * math.exp(-(x**1.7))) + 0.4 * abs(velocity)
    assert vc.steady_friction(law, load, velocity) == pytest.approx(math.copysign(expected, velocity), rel=1e-13)
    for any_law in (law, vc.Exponential(), vc.LuGre()):
        slope = vc.steady_slope(any_law, load, velocity)
        assert slope == pytest.approx(slope_by_difference(any_law, load, velocity), rel=1e-8)
        assert slope == vc.steady_slope(any_law, load, -velocity)


def test_boundary_velocity_of_the_paper():
    boundary = vc.boundary_velocity(vc.LuGre())
    assert boundary == pytest.approx(0.0405, abs=5e-5)
    assert 10.0 * boundary == pytest.approx(0.15 + 0.3 * math.exp(-((boundary / 0.1) ** 2)), rel=ROUNDING)
    # With delta1 = 1 it leaves the droop: 1 v = 0.15 + 0.3 exp(-(v/0.1)^2).
    slow = vc.boundary_velocity(vc.LuGre(bristle_damping=1.0))
    assert slow == pytest.approx(0.15 + 0.3 * math.exp(-((slow / 0.1) ** 2)), rel=ROUNDING)


@pytest.mark.parametrize("bristle", [-0.0045, -0.001, 0.0, 0.002, 0.0045])
@pytest.mark.parametrize("viscous", [0.0, 0.7])
def test_at_the_boundary_velocity_friction_forgets_its_bristles(bristle, viscous):
    law, load = vc.LuGre(viscous_damping=viscous), 1.0
    boundary = vc.boundary_velocity(law, load)
    force, _ = law.force(boundary, (bristle,), 1, load)
    assert force == pytest.approx(law.steady_force(boundary, load), rel=ROUNDING)
    above, _ = law.force(1.1 * boundary, (bristle,), 1, load)
    assert abs(above - law.steady_force(1.1 * boundary, load)) > 1e-3


def test_no_boundary_velocity_without_memory():
    assert vc.boundary_velocity(vc.LuGre(bristle_damping=0.0)) is None
    assert vc.boundary_velocity(vc.LuGre(static_coefficient=0.15)) is None
    assert vc.boundary_velocity(vc.Exponential()) is None


def test_offset_points_of_the_paper_with_viscous_friction():
    points = vc.offset_points(vc.LuGre(viscous_damping=0.4))
    assert points.exist
    assert points.lower == pytest.approx(0.006696630374612, rel=1e-12)  # digits of PHYSICS, erratum 4
    assert points.upper == pytest.approx(0.181821489161179, rel=1e-12)
    assert points.printed_lower == pytest.approx(1 / 150, rel=ROUNDING)
    assert points.ratio == pytest.approx(15.0, rel=ROUNDING)
    assert points.greatest_viscous_damping == pytest.approx(0.3 * math.sqrt(2 / math.e) / 0.1, rel=ROUNDING)
    assert points.greatest_viscous_damping == pytest.approx(2.5733, abs=5e-5)
    # For alpha = 2 the printed recursion is the right one.
    for recursion in (points.printed_upper, points.corrected_upper):
        assert recursion.converged
        assert recursion.value == pytest.approx(points.upper, rel=1e-14)


def test_no_offset_points_at_the_printed_values():
    offset = vc.frictional_limits(vc.LuGre()).offset
    assert (offset.exist, offset.lower, offset.upper, offset.ratio) == (False, None, None, None)
    assert offset.printed_lower == 0.0
    assert not offset.printed_upper.converged
    assert "falls at every speed" in offset.reason


@pytest.mark.parametrize("exponent", [1.05, 1.5, 2.0, 8.0])
def test_offset_points_have_slope_zero_and_the_closed_form(exponent):
    """For any alpha > 1, x^alpha = -m W(-C^(-1/m)/m) with m = (alpha-1)/alpha."""
    load = 3.5
    law = vc.LuGre(viscous_damping=0.4, stribeck_exponent=exponent)
    points = vc.offset_points(law, load)
    m = (exponent - 1.0) / exponent
    for value, branch in ((points.lower, 0), (points.upper, -1)):
        w = lambertw(-(points.ratio ** (-1.0 / m)) / m, branch).real
        # exp(y) of y = ln x^alpha near -100 loses two digits.
        assert value == pytest.approx(0.1 * (-m * w) ** (1.0 / exponent), rel=1e-12)
        assert vc.steady_slope(law, load, value) == pytest.approx(0.0, abs=1e-12)
    assert vc.steady_slope(law, load, 0.5 * points.lower) > 0.0 > vc.steady_slope(law, load, 2.0 * points.lower)
    assert vc.steady_slope(law, load, 0.9 * points.upper) < 0.0 < vc.steady_slope(law, load, 1.1 * points.upper)
    assert points.corrected_upper.value == pytest.approx(points.upper, rel=1e-13)
    if exponent != 2.0:
        assert points.printed_upper.value is None or abs(points.printed_upper.value / points.upper - 1.0) > 1e-2


@pytest.mark.parametrize("exponent", [1.0, 1.3, 2.0, 3.0])
def test_greatest_viscous_damping_is_where_offset_points_end(exponent):
    limit = vc.offset_points(vc.LuGre(stribeck_exponent=exponent)).greatest_viscous_damping
    below, above = (
        vc.offset_points(vc.LuGre(stribeck_exponent=exponent, viscous_damping=limit * factor))
        for factor in (1 - 1e-9, 1 + 1e-9)
    )
    assert below.exist
    assert not above.exist
    assert (above.lower, above.upper) == (None, None)
    assert "rises at every speed" in above.reason
    if exponent > 1.0:  # they meet like a square root: ln x^alpha is ln m +- sqrt(2e-9/m)
        apart = 2.0 * math.sqrt(2e-9 / ((exponent - 1.0) / exponent)) / exponent
        assert below.upper / below.lower - 1.0 == pytest.approx(apart, rel=1e-3)


@pytest.mark.parametrize("exponent", [0.4, 0.7, 1.0])
def test_up_to_exponent_one_there_is_no_lower_point(exponent):
    law = vc.LuGre(viscous_damping=0.4, stribeck_exponent=exponent)
    points = vc.offset_points(law)
    assert points.exist
    assert points.lower is None
    assert vc.steady_slope(law, 1.0, points.upper) == pytest.approx(0.0, abs=1e-13)
    if exponent == 1.0:
        assert points.upper == pytest.approx(0.1 * math.log(7.5), rel=ROUNDING)


def test_extreme_parameters_neither_overflow_nor_hang():
    """Exactly at the greatest viscous damping C is sqrt(2 e) to rounding: both points meet to the root of it."""
    for exponent in (0.01, 1.0001, 30.0):
        for viscous in (1e-12, 2.9, 1e12):
            limits = vc.frictional_limits(vc.LuGre(stribeck_exponent=exponent, viscous_damping=viscous))
            json.dumps(dataclasses.asdict(limits), allow_nan=False)
    points = vc.offset_points(vc.LuGre(viscous_damping=0.3 * math.sqrt(2 / math.e) / 0.1))
    assert (points.lower, points.upper) == pytest.approx((0.1 / math.sqrt(2), 0.1 / math.sqrt(2)), rel=1e-7)
    assert "rises" in vc.offset_points(vc.LuGre(static_coefficient=0.15, viscous_damping=0.4)).reason  # no droop
    assert "flat" in vc.offset_points(vc.LuGre(static_coefficient=0.15)).reason


def test_wrong_questions_are_refused():
    with pytest.raises(ValueError, match="velocity should be"):
        vc.steady_friction(vc.LuGre(), 1.0, 0.0)
    with pytest.raises(ValueError, match="velocity should be"):
        vc.steady_slope(vc.LuGre(), 1.0, math.nan)
    for load in (0.0, -1.0, math.inf, math.nan, "weight", True):
        with pytest.raises(ValueError, match="load should be"):
            vc.frictional_limits(vc.LuGre(), load)
    with pytest.raises(TypeError, match="LuGre or an exponential"):
        vc.frictional_limits(object(), 1.0)
