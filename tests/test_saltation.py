"""Tangents through events: multipliers against differences of maps that know no tangent.

Where a part of the contact velocity is imposed, a reversal leaves of a push what the imposed part makes of its delay.
"""

import dataclasses
import math

import numpy as np
import pytest

import vibrocap as vc
from thinned import exhaustive_but
from vibrocap.numerics import linker as link
from vibrocap.numerics.run import ensemble as numerics
from vibrocap.orbits.attractors.lyapunov import lyapunov_exponent
from vibrocap.orbits.closing import shooting
from vibrocap.orbits.maps.closing_map import ClosingMap
from vibrocap.orbits.maps.stroboscopic_map import StroboscopicMap, state_vector
from vibrocap.physics.catalogue import law as law_of

pytestmark = pytest.mark.plain

TURNING = vc.System(
    vc.TwoMassCrawler(mass_ratio=1.5), vc.anisotropic(vc.Coulomb)(0.05, 0.05, back_ratio=2.0), vc.Harmonic(1.0, 1.0)
)
MULTIPLIER = 0.70436105  # by differences of an independent map, at pushes of 1e-4 and 1e-5


@pytest.fixture
def plain():
    """The map of TURNING without a compiler; free lanes are computed along."""
    with np.errstate(all="ignore"):
        yield StroboscopicMap(TURNING, 1e-10, threads=1, plain=True)


# --- crawlers, whose contact velocity is that of the centre and an imposed part -------------------------------------


def test_a_crawler_that_turns_forgets_a_part_of_a_push(plain):
    """Two reversals in a period: the derivative is that of an independent map, and nothing else closes the orbit."""
    orbit = vc.shoot(TURNING, {"centre_velocity": 0.23}, map_=plain)
    assert orbit.status is vc.OrbitStatus.CONVERGED
    assert orbit.multipliers == pytest.approx([MULTIPLIER], abs=2e-8)
    assert orbit.iterations <= 4


def test_a_contradicted_multiplier_is_not_certified(plain, monkeypatch):
    """Planted: a derivative half as large, and one of the wrong sign where runs beside the orbit do not agree."""
    map_, sound = plain, StroboscopicMap.images
    state = np.array([0.0, 0.2275240469])
    images = map_.images(state[None], map_.parameters()[None])
    assert not shooting.contradicted(map_, state, images, map_.parameters())
    for factor, sure in ((0.5, True), (1.05, True), (-1.0, False)):
        wrong = dataclasses.replace(images, jacobian=factor * images.jacobian)
        with monkeypatch.context() as planted:
            if not sure:
                planted.setattr(StroboscopicMap, "slopes_along", lambda *_: (images.state, np.array([False])))
            assert shooting.contradicted(map_, state, wrong, map_.parameters())
    monkeypatch.setattr(
        StroboscopicMap,
        "images",
        lambda *given, **named: (
            (got := sound(*given, **named)) and dataclasses.replace(got, jacobian=0.5 * got.jacobian)
        ),
    )
    orbit = vc.shoot(TURNING, {"centre_velocity": 0.2275240469}, map_=map_)
    assert orbit.status is vc.OrbitStatus.CONTRADICTED
    assert "multipliers" in orbit.status.advice
    assert orbit.facts["stability"] == "stability not known"


def test_a_slope_against_the_order_of_motions_closes_nothing(monkeypatch):
    """Planted: a saltation that overdoes what follows a reversal, so that motions pass one another at one of two."""
    original, right = link.kernel_source, "-= rate * floats[DELAY + lane]"
    assert right in original("events.tangents")
    attempts = []
    for text in (right, "-= 12.0 * rate * floats[DELAY + lane]"):
        with monkeypatch.context() as planted, np.errstate(all="ignore"):
            planted.setattr(link, "kernel_source", lambda name, text=text: original(name).replace(right, text))
            numerics.ensemble_kernel.cache_clear()
            closing = ClosingMap(TURNING, "drive.amplitude", (0.5, 2.0), tolerance=1e-10, plain=True)
            attempts.append(closing.attempt(closing.point(np.array([0.0, 0.23]), 1.0)))
    numerics.ensemble_kernel.cache_clear()
    sound, faulty = attempts
    assert sound.finished
    assert sound.jacobian == pytest.approx(MULTIPLIER, abs=0.02)  # beside the orbit
    assert faulty.jacobian < -0.01
    assert not faulty.finished


def test_a_corner_that_brings_the_body_to_rest_forgets_a_push():
    """Two phases of one unit of time: p' = k until z' jumps to where the body just rests, and then stays."""
    system = vc.System(vc.TwoMassCrawler(), vc.Coulomb(0.5, 0.5), vc.Triangle(0.3, math.pi))
    map_ = StroboscopicMap(system, 1e-10, threads=1, plain=True)
    with np.errstate(all="ignore"):
        images = map_.images(np.array([[0.0, -0.3 - 0.25]]), map_.parameters()[None])
    assert images.state[0, 1] == pytest.approx(-0.3, abs=1e-14)
    assert images.jacobian[0, 1, 1] == 0.0


@pytest.mark.slow
def test_the_exponent_of_a_crawler_that_turns_and_its_error(monkeypatch):
    """log(multiplier)/T, within an error that is not nothing; with wrong tangents the error says so."""
    expected = math.log(MULTIPLIER) / (2.0 * math.pi)
    exponent = lyapunov_exponent(TURNING, periods=60, transient=60)
    assert exponent.value == pytest.approx(expected, abs=2e-9)
    assert 1e-11 < exponent.error < 1e-9
    sound = StroboscopicMap.images

    def planted(*given, **more):
        got = sound(*given, **more)
        return got if got.jacobian is None else dataclasses.replace(got, jacobian=0.1 * got.jacobian)

    monkeypatch.setattr(StroboscopicMap, "images", planted)
    wrong = lyapunov_exponent(TURNING, periods=60, transient=60)
    assert abs(wrong.value - expected) <= wrong.error


# --- machines against their own simulation, which knows no tangent ---------------------------------------------------

PUSH = 1e-4  # of the velocity, and of the bristles over their natural size
EXACT = 1e-12  # to which motions end


def differences_of(function, state, sizes):
    """(derivative of a map, how well it is known): central differences at two pushes, extrapolated.

    To their own difference, and to what the error of the ends is over the push.
    """
    values = np.empty((2, len(state), len(state)))
    for one, push in zip(values, (2.0 * PUSH, PUSH), strict=True):
        for j, step in enumerate(push * sizes):
            beside = step * np.eye(len(state))[j]
            one[:, j] = (function(state + beside) - function(state - beside)) / (2.0 * step)
    wide, narrow = values
    error = np.abs(narrow - wide).max() + 4.0 * EXACT * np.max(sizes[:, None] / sizes) / PUSH
    return narrow + (narrow - wide) / 3.0, error


UNEVEN = law_of("anisotropic-coulomb")(0.1, 0.1, back_ratio=2.0)
SLOPE = vc.Environment(inclination=0.05, linear_drag=0.1, quadratic_drag=0.1, force=0.02, gravity=1.0)
SYSTEMS = {
    "crawler of three phases": (
        vc.System(vc.TwoMassCrawler(1.5), vc.Exponential(0.3, 0.4, 6.0), vc.ThreePhase(0.8, 0.6, 2.0, 0.7)),
        {"centre_velocity": 0.1},
    ),
    "worm": (
        vc.System(vc.TwoBodyWorm(mass_2=0.6), UNEVEN, vc.Harmonic(0.8)),
        {"centre_velocity": 0.05},
    ),
    "pendulum crawler": (
        vc.System(vc.PendulumCrawler(1.3), vc.Exponential(0.1, 0.14, 6.0), vc.Trapezoid(0.8, 1.1, 0.2, 0.2, 0.2)),
        {"centre_velocity": 0.1},
    ),
    "crawler on a slope": (
        vc.System(vc.TwoMassCrawler(), vc.Coulomb(0.1, 0.12), vc.Harmonic(0.8), environment=SLOPE),
        {"centre_velocity": 0.1},
    ),
    "worm with bristles": (
        vc.System(vc.TwoBodyWorm(mass_2=0.6), vc.LuGre(20.0, 2.0, 0.0, 0.1, 0.15), vc.Biharmonic(0.8, 1.0, 0.3)),
        {"centre_velocity": 0.05},
    ),
    "bristles with play": (
        vc.System(vc.TwoMassCrawler(), law_of("backlash-lugre")(), vc.Harmonic(0.8)),
        {"centre_velocity": 0.05},
    ),
    "rigid stops": (
        vc.System(vc.RigidStopCapsule(), vc.Coulomb(0.1, 0.12), vc.Harmonic(1.0)),
        {"displacement_rate": 0.4, "velocity": 0.05},
    ),
    "belt": (
        vc.System(vc.Oscillator(belt_speed=0.5), vc.Exponential(0.1, 0.2), vc.Harmonic(0.7)),
        {"position": 0.3, "sliding_velocity": 0.1},
    ),
    "load that follows": (
        vc.System(vc.PendulumCapsule(normal_load="dynamic"), vc.Exponential(0.05, 0.1), vc.Harmonic(1.2)),
        {"angle": 0.2, "velocity": 0.1},
    ),
    "elastic link": (
        vc.System(vc.TwoBodyCrawler(), vc.Coulomb(0.1, 0.12), vc.Harmonic(1.0)),
        {"velocity": 0.1, "velocity_2": -0.05},
    ),
    "linkage": (
        vc.System(
            vc.LinkageCrawler(mass_ratio_2=1.7, stiffness=4.0),
            vc.Coulomb(0.1, 0.12),
            vc.Biharmonic(0.5, 1.3, 0.15, 0.5),
        ),
        {"velocity": 0.1},
    ),
    "actuator": (
        vc.System(vc.PendulumCapsule(), vc.Coulomb(0.1, 0.12), vc.Harmonic(1.2), actuator=vc.Actuator(0.2, 0.9, 1.1)),
        {"angle": 0.2, "velocity": 0.1},
    ),
    "sampled loop": (
        vc.System(
            vc.Oscillator(stiffness=0.0),
            vc.Coulomb(1.0, 1.5),
            vc.Harmonic(0.3, 2.0 * math.pi),
            controller=vc.SampledPositionPID(3.0, 4.0, 6.0, sample_time=0.05, delay=0.02),
        ),
        {"position": -1.0},
    ),
}


@pytest.mark.parametrize("name", exhaustive_but([0, 1, 2, 3, *range(6, 10), 11, 12], list(SYSTEMS)))
def test_derivatives_are_those_of_simulated_motions(name, monkeypatch):
    """Of the map over two periods, to what the differences of whole simulations are known to; of tangents alone."""
    monkeypatch.setattr(StroboscopicMap, "through_joint_turns", lambda *_: None)
    system, start = SYSTEMS[name]
    map_ = StroboscopicMap(system)
    parameters, state = map_.parameters(), state_vector(system, start)
    sizes, free = map_.scales(parameters), map_.free(state[None], parameters[None])[0]
    kept = [i for i in map_.smooth_states if free[i]]
    images = map_.images(state[None], parameters[None], 2)
    assert images.finished[0]

    def simulated(y):
        whole = state.copy()
        whole[kept] = y
        initial = dict(zip(system.state_names, whole.tolist(), strict=True))
        motion = vc.simulate(system, periods=2, initial=initial, tolerance=1e-12)
        assert motion.status.ok
        return np.array([motion.state[name] for name in system.state_names])[kept]

    derivative, error = differences_of(simulated, state[kept], sizes[kept])
    assert np.abs(images.jacobian[0][np.ix_(kept, kept)] - derivative).max() <= error
    assert error < 1e-3
