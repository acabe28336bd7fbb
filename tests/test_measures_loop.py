"""Friction loops: made-up friction with loops in closed form, identities, and what the paper's loops do."""

import math

import numpy as np
import pytest
from scipy.integrate import quad

import vibrocap as vc
from signals import Signal, made_up_motion, paper_motion, paper_system

TOP = 0.8  # greatest speed of the made-up motions X' = TOP cos t
LAG = 0.05
SWING = Signal(((TOP, 1.0, -math.pi / 2),))
RESTS = math.pi / 2 + math.pi * np.arange(8)


def swinging(friction, law=None):
    """X' = TOP cos t against friction(v, v', side)."""
    return made_up_motion(
        law or vc.LuGre(),
        SWING,
        lambda t, side: friction(TOP * np.cos(t), -TOP * np.sin(t), side),
        rests=RESTS,
    )


def half_disc(low, high):
    """Integral of sqrt(TOP^2 - u^2) over speeds."""

    def primitive(u):
        return 0.5 * (u * math.sqrt(TOP**2 - u**2) + TOP**2 * math.asin(u / TOP))

    return primitive(high) - primitive(low)


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("boundary", [0.0, 0.3, 5.0])
def test_area_and_direction_of_a_loop_in_closed_form(sign, boundary):
    """R = 0.2 sgn v + LAG v': at speed u the branches are 2 LAG sqrt(TOP^2 - u^2) apart, the width of an ellipse."""
    loop = vc.friction_loop(swinging(lambda v, a, side: 0.2 * side + sign * LAG * a), boundary=boundary)
    assert loop.velocity_area == pytest.approx(sign * LAG * math.pi * TOP**2, rel=1e-12)
    assert loop.displacement_area == pytest.approx(0.2 * 4 * TOP, rel=1e-12)
    # |R| is largest at either end of a slide, where the acceleration is TOP.
    assert loop.peak_force == pytest.approx(0.2 + LAG * TOP, rel=1e-12)
    word = "accelerating above" if sign > 0 else "decelerating above"
    edge = min(boundary, TOP)
    for part in (loop.forward, loop.back):
        assert part.crossings == ()
        for branches, low, high in ((part.presliding, 0.0, edge), (part.pure_sliding, edge, TOP)):
            if high > low:
                assert branches.direction == word
                assert branches.area == pytest.approx(2 * sign * LAG * half_disc(low, high), rel=1e-11)
                assert branches.mean_difference == pytest.approx(branches.area / (high - low), rel=1e-12)
                assert branches.speeds == pytest.approx((low, high), rel=1e-12)
                lowest = low + (high - low) / 512  # the middle of the first of 256 intervals
                expected = 2 * sign * LAG * math.sqrt(TOP**2 - lowest**2)
                assert branches.largest_difference == pytest.approx(expected, rel=1e-11)
            else:
                assert branches is None


def test_crossing_of_the_branches():
    """R = LAG (0.37 - |v|) v': the branches change places at 0.37."""
    motion = swinging(lambda v, a, side: 0.2 * side + LAG * (0.37 - np.abs(v)) * a)
    loop = vc.friction_loop(motion, boundary=0.37)
    for part in (loop.forward, loop.back):
        assert part.crossings == pytest.approx((0.37,), abs=1e-12)
        assert part.presliding.direction == "accelerating above"
        assert part.pure_sliding.direction == "decelerating above"
    assert vc.friction_loop(motion, boundary=0.0).forward.pure_sliding.direction == "mixed"


def test_escape_and_offset_points():
    """side R = |v| (0.6 - |v|) has its greatest value 0.09 at speed 0.3, on the way up and on the way down."""
    loop = vc.friction_loop(swinging(lambda v, a, side: v * (0.6 - np.abs(v))))
    for part, side in ((loop.forward, 1), (loop.back, -1)):
        assert [point.accelerating for point in part.offset_points] == [True, False]
        for point in part.offset_points:
            # A greatest value: its place is known to the root of the rounding of its rate, its height to rounding.
            assert side * point.velocity == pytest.approx(0.3, abs=1e-9)
            assert side * point.friction == pytest.approx(0.09, abs=1e-15)
            assert point.velocity == pytest.approx(TOP * math.cos(point.time), abs=1e-14)
        assert part.escape == part.offset_points[0]
        assert part.pure_sliding.direction == part.presliding.direction == "coincide"
    assert loop.boundary == pytest.approx(0.3, abs=1e-9)


def test_a_dip_is_no_escape():
    """side R = |v| (|v| - 0.6) falls to -0.09 and rises from there: there is no first peak on the way up."""
    loop = vc.friction_loop(swinging(lambda v, a, side: v * (np.abs(v) - 0.6)))
    assert len(loop.forward.offset_points) == 2
    assert loop.forward.escape is None
    assert loop.boundary == pytest.approx(TOP, rel=1e-12)  # so all is presliding


def test_quasi_static_bristles():
    """Constant g and no bristle damping: xi depends on the way alone; PHYSICS section 5."""
    g, force, amplitude = 0.3, 0.25, 0.5

    def friction(t, side):
        cos = amplitude - side * amplitude * np.cos(t)  # from the last reversal; X = -A cos t here
        return side * force * (1.0 - (1.0 + math.tanh(amplitude / g)) * np.exp(-cos / g))

    position = Signal(((amplitude, 1.0, math.pi),))
    motion = made_up_motion(vc.LuGre(), position, friction, rests=math.pi * np.arange(9))
    loop = vc.friction_loop(motion)
    assert loop.peak_force == pytest.approx(force * math.tanh(amplitude / g), rel=1e-12)
    assert loop.displacement_area == pytest.approx(4 * force * (amplitude - g * math.tanh(amplitude / g)), rel=1e-12)
    turning, _ = quad(lambda t: float(friction(t, 1.0)) * amplitude * math.cos(t), 0.0, math.pi, epsabs=1e-13)
    assert loop.velocity_area == pytest.approx(2 * turning, rel=1e-11)
    # Friction rises all the way to the turning point: nothing escapes from presliding.
    assert loop.forward.escape is None
    assert loop.boundary == pytest.approx(amplitude, rel=1e-12)
    assert loop.forward.pure_sliding is None
    assert loop.forward.presliding.direction == "decelerating above"


def test_sliding_one_way_all_the_time():
    position = Signal(((0.1, 1.0, 0.0),), slope=1.0)  # X' = 1 - 0.1 sin t
    motion = made_up_motion(vc.LuGre(), position, lambda t, side: 0.2 - 0.3 * np.cos(t))  # R = 0.2 + 3 v'
    loop = vc.friction_loop(motion, boundary=0.5)
    assert loop.back is None
    assert loop.forward.presliding is None
    assert loop.forward.pure_sliding.speeds == pytest.approx((0.9, 1.1), rel=1e-12)
    assert loop.velocity_area == pytest.approx(3 * 0.01 * math.pi, rel=1e-12)
    assert loop.forward.pure_sliding.direction == "accelerating above"
    assert vc.mode_sequence(motion) == "F"


def test_a_capsule_at_rest_has_no_loop():
    motion = vc.simulate(paper_system(vc.Exponential(), 4.0, 1.2, amplitude=0.01), periods=2)
    loop = vc.friction_loop(motion)
    assert (loop.forward, loop.back, loop.velocity_area, loop.displacement_area) == (None, None, 0.0, 0.0)
    assert loop.peak_force == pytest.approx(float(np.max(np.abs(motion["friction"][-257:]))), rel=1e-3)


# ---------------------------------------------------------------------------------------------------------------------
# The paper's loops


LAWS = {"exponential": vc.Exponential(), "printed": vc.LuGre(), "slight": vc.LuGre(bristle_damping=1.0)}


@pytest.fixture(scope="module")
def loops():
    """Steady motions of the second set by law: (motion, loop)."""
    motions = {name: paper_motion(law, periods=80, stiffness=4.0, damping=1.2) for name, law in LAWS.items()}
    return {name: (motion, vc.friction_loop(motion)) for name, motion in motions.items()}


@pytest.mark.parametrize("name", LAWS)
def test_a_loop_against_a_dense_look_and_what_the_contact_loses(loops, name):
    motion, loop = loops[name]
    # Two quadratures of the same motion; a steady period stores nothing to within 1e-9 here.
    assert loop.displacement_area == pytest.approx(-vc.energy_balance(motion, periods=1).friction, abs=1e-11)
    assert loop.displacement_area > 0.09
    t = np.linspace(*loop.window, 20001)[1:-1]
    dense = float(np.max(np.abs(motion.at(t, "friction"))))
    # A smooth peak is missed by less than R'' dt^2/8 (R'' < 100); one at a jump by R' dt (R' < 1).
    assert 0.0 <= loop.peak_force - dense + 1e-12 < 4e-4
    curve = vc.friction_curve(motion)
    assert np.max(np.abs(curve.friction)) <= loop.peak_force + 1e-12
    borders = np.array([phase.end for phase in motion.phases])  # there the curve has both values, the motion one
    inner = np.min(np.abs(curve.time[:, None] - borders), axis=1) > 0.0
    assert curve.friction[inner] == pytest.approx(motion.at(curve.time[inner], "friction"), abs=1e-9)
    assert curve.displacement[-1] == pytest.approx(vc.drift(motion), abs=1e-10)


def test_slides_are_whole():
    """A slide that the end of the run cuts is not taken, though it belongs to the faster period of the transient."""
    motion = paper_motion(vc.LuGre(), periods=20)
    loop = vc.friction_loop(motion)
    for part in (loop.forward, loop.back):
        assert motion.at(part.excursion, "velocity") == pytest.approx([0.0, 0.0], abs=1e-12)


def test_the_exponential_law_has_one_branch(loops):
    loop = loops["exponential"][1]
    assert abs(loop.velocity_area) < 1e-10
    assert loop.boundary == 0.0
    for part in (loop.forward, loop.back):
        assert part.pure_sliding.direction == "coincide"
        assert (part.presliding, part.crossings, part.offset_points) == (None, (), ())
        assert abs(part.escape.friction) == pytest.approx(0.45, abs=1e-12)
        assert part.escape.velocity == 0.0
    assert loop.peak_force == pytest.approx(0.45, abs=1e-9)


def test_branches_cross_exactly_at_the_boundary_velocity(loops):
    """At v* friction does not depend on the bristles at all, so erratum 7 is exact there, not of first order."""
    motion, loop = loops["printed"]
    boundary = vc.boundary_velocity(motion.system.friction)
    for part in (loop.forward, loop.back):
        assert part.crossings[-1] == pytest.approx(boundary, abs=1e-11)
        assert part.excursion[0] < part.excursion[1] <= loop.window[1]


def test_loops_run_against_the_paper_at_its_printed_damping_and_with_it_at_one(loops):
    motion, printed = loops["printed"]
    above = vc.friction_loop(motion, boundary=vc.boundary_velocity(motion.system.friction))
    slight = loops["slight"][1]
    for side in ("forward", "back"):
        for loop, direction in ((above, "decelerating"), (printed, "decelerating"), (slight, "accelerating")):
            assert getattr(loop, side).pure_sliding.direction == f"{direction} above"
        assert getattr(slight, side).presliding.direction == "decelerating above"
        assert getattr(slight, side).pure_sliding.area == pytest.approx(1.377e-3, rel=1e-3)
    with pytest.raises(ValueError, match="boundary should be"):
        vc.friction_loop(motion, boundary=-1.0)


@pytest.mark.slow
def test_loops_of_a_velocity_that_is_imposed_in_part_are_over_that_velocity():
    """They were over that of the common centre: -0.0314 in place of 0.00027."""
    system = vc.System(vc.TwoMassCrawler(), vc.Coulomb(0.1, 0.2), vc.Harmonic(amplitude=0.5))
    motion = vc.simulate(system, periods=4)
    times = np.linspace(3.0, 4.0, 200_001) * motion.period
    velocity, friction = motion.at(times, "contact_velocity"), motion.at(times, "friction")
    expected = float(np.sum(0.5 * (friction[1:] + friction[:-1]) * np.diff(velocity)))
    assert vc.friction_loop(motion).velocity_area == pytest.approx(expected, abs=1e-5)
    values = vc.measured(motion, ["velocity_loop_area"], window=1)
    assert values["velocity_loop_area"] == pytest.approx(vc.friction_loop(motion).velocity_area, abs=1e-12)
    assert abs(expected) < 1e-3
