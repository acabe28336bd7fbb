"""Whether a law can create energy: closed forms, the theorem for LuGre, and laws made to create it."""

import math
import random
from typing import ClassVar

import numpy as np
import pytest
from scipy.optimize import minimize, minimize_scalar

import vibrocap as vc
from vibrocap.laboratory.cycle import closed_cycle
from vibrocap.laboratory.passivity import passivity, powers, worst_chatter
from vibrocap.laboratory.recorded_law import recorded_law
from vibrocap.physics.catalogue import laws
from vibrocap.physics.friction.law import Law, Positive, parameter, parameters

CREATES, NONE_FOUND, PROVEN = "creates energy: cycle found", "no cycle found, not proven", "passive, proven"


@parameters
class FallingBelowZero(Law):
    """R = N mu sgn(v) - c v: takes energy while slow, gives it beyond N mu/c."""

    level: Positive = parameter(0.3, "mu", "level")
    falling: Positive = parameter(0.6, "c", "negative damping")

    name: ClassVar[str] = "falling-below-zero"
    kind: ClassVar = "kinked"

    def force(self, velocity, internal, side, load):
        return side * load * self.level - self.falling * velocity, ()

    def steady_force(self, speed, load):
        return load * self.level - self.falling * speed


def steady_level(law, speed, load=1.0):
    return load * (
        law.coulomb_coefficient
        + (law.static_coefficient - law.coulomb_coefficient)
        * math.exp(-((speed / law.stribeck_velocity) ** law.stribeck_exponent))
    )


def lugre_energy(law, cycle, load=1.0):
    """Energy of a cycle of constant levels from the closed form of LuGre's bristles, and the bristles at its end."""
    bristle, energy = float(cycle.internal[0, 0]), 0.0
    jumps = np.flatnonzero(np.diff(cycle.velocity)) + 1
    for piece in np.split(np.arange(len(cycle.time)), jumps):
        v, duration = float(cycle.velocity[piece[0]]), float(cycle.time[piece[-1]] - cycle.time[piece[0]])
        target = math.copysign(steady_level(law, abs(v), load) / law.bristle_stiffness, v)
        length = abs(target)
        gone = -math.expm1(-abs(v) * duration / length)
        change = (target - bristle) * gone
        area = target * duration + (bristle - target) * length / abs(v) * gone
        energy += v * (law.bristle_stiffness * area + law.bristle_damping * change + law.viscous_damping * v * duration)
        bristle += change
    return energy, bristle


WITHOUT_A_DROP = vc.LuGre(static_coefficient=0.15)


@pytest.mark.parametrize("law", [vc.Coulomb(), vc.Stribeck(), vc.Exponential(), vc.Dahl(), WITHOUT_A_DROP])
def test_proven_laws_say_so_and_lose_energy(law):
    report = passivity(law)
    assert report.verdict == PROVEN
    assert report.cycle is None
    assert report.least_loss.rate >= 0.0
    assert "holds" in report.text


@pytest.mark.parametrize("load", [1.0, 2.5])
def test_negative_damping_creates_the_energy_of_its_closed_form(load):
    law = FallingBelowZero()
    report = passivity(law, load, fastest=3.0 * load)
    assert report.verdict == CREATES
    assert report.speed_needed == pytest.approx(load * 0.3 / 0.6, rel=0.02)
    v, period = report.cycle.fastest, report.cycle.period
    assert v == pytest.approx(3.0 * load)
    assert report.cycle.energy == pytest.approx((load * 0.3 * v - 0.6 * v**2) * period, rel=1e-9)
    assert report.cycle.share == pytest.approx(-1.0)
    assert report.least_loss.rate == pytest.approx(load * 0.3 * v - 0.6 * v**2, rel=1e-9)
    assert "states no condition" in report.condition


@pytest.mark.parametrize(
    ("law", "load"),
    [
        (vc.LuGre(), 1.0),
        (vc.LuGre(bristle_damping=2.0, viscous_damping=0.5, stribeck_exponent=1.0), 3.5),
        (vc.LuGre(bristle_stiffness=1e5, bristle_damping=316.2, viscous_damping=0.4, coulomb_coefficient=1.0,
                  static_coefficient=1.5, stribeck_velocity=1e-3), 1.0),
    ],
)  # fmt: skip
def test_lugre_gives_energy_over_a_closed_cycle(law, load):
    report = passivity(law, load)
    assert report.verdict == CREATES
    assert report.condition.startswith("Its condition does not hold: delta2 >= ")
    cycle = report.cycle
    energy, bristle = lugre_energy(law, cycle, load)
    assert energy < 0.0
    assert cycle.energy == pytest.approx(energy, rel=1e-6)
    assert bristle == pytest.approx(cycle.internal[0, 0], rel=1e-6)
    assert cycle.share < -0.25
    # The stored force is the law's, at every sample.
    samples = range(0, len(cycle.time), 17)
    forces = [
        law.force(cycle.velocity[i], tuple(cycle.internal[i]), math.copysign(1.0, cycle.velocity[i]), load)[0]
        for i in samples
    ]
    np.testing.assert_allclose(cycle.force[list(samples)], forces, rtol=1e-12)


def test_speed_needed_is_that_of_the_closed_form():
    """Between a crawl and a speed v, at bristle force s: s/(1 - s/F_s) + s/(s/F(v) - 1) < delta1 v."""
    law = vc.LuGre()

    def speed(force):
        def excess(v):
            level = steady_level(law, v)
            if force <= level:
                return 10.0
            return abs(law.bristle_damping * v - force / (1 - force / 0.45) - force / (force / level - 1))

        return minimize_scalar(excess, bounds=(0.05, 1.0), method="bounded", options={"xatol": 1e-10}).x

    best = min(speed(force) for force in np.linspace(0.17, 0.35, 400))
    assert passivity(law).speed_needed == pytest.approx(best, rel=0.02)  # 1 % of the grid and the grid of states


def test_lugre_condition_is_necessary_too():
    """Barabanov and Ortega 2000: below the sufficient bound of delta2 there is a cycle, however little below."""
    draw = random.Random(4)
    for _ in range(3):
        low = draw.uniform(0.1, 1.0)
        values = {
            "bristle_stiffness": 10 ** draw.uniform(1, 4),
            "bristle_damping": 10 ** draw.uniform(-0.5, 1.5),
            "coulomb_coefficient": low,
            "static_coefficient": low * draw.uniform(1.2, 3.0),
            "stribeck_velocity": 10 ** draw.uniform(-2, -1),
        }
        bound = values["bristle_damping"] * (values["static_coefficient"] / low - 1.0)
        for factor, exists in ((0.0, True), (0.9, True), (1.01, False)):
            law = vc.LuGre(**values, viscous_damping=factor * bound)
            recorded = recorded_law(law)
            deflection = np.linspace(-1, 1, 801)[None] * law.internal_scales(1.0)[0]
            speeds = law.stribeck_velocity * np.geomspace(1e-6, 1e8, 561)
            chatter = worst_chatter(powers(recorded, deflection, np.ones(801), speeds), np.ones(1))
            assert (chatter is not None) == exists, (values, factor)
            assert law.passive == (not exists)


def test_large_damping_of_bristles_gives_nearly_all_that_is_exchanged():
    report = passivity(vc.LuGre(bristle_damping=1e3, static_coefficient=1.5), fastest=1.0)
    assert report.verdict == CREATES
    assert report.cycle.share < -0.9
    assert report.cycle.fastest <= 1.0


def test_slow_contacts_are_not_accused():
    """Within a speed below the one needed there is no cycle, and the report does not claim a proof."""
    report = passivity(vc.LuGre(), fastest=0.1)
    assert report.verdict == NONE_FOUND
    assert report.cycle is None
    assert report.speed_needed is None
    assert report.fastest == 0.1


def test_least_loss_is_that_of_the_storage_function():
    law = vc.LuGre()
    report = passivity(law, fastest=0.3)
    loss = report.least_loss
    assert loss.rate < 0.0
    side = math.copysign(1.0, loss.velocity)
    assert loss.rate == pytest.approx(sum(law.losses(loss.velocity, loss.internal, side, 1.0)))

    def rate(x):
        v, share = 0.3 * math.tanh(x[0]) ** 2, math.tanh(x[1])
        return sum(law.losses(v, (share * 0.0045,), 1, 1.0))

    found = minimize(rate, [2.0, 2.0], method="Nelder-Mead", options={"xatol": 1e-9, "fatol": 1e-12, "maxiter": 4000})
    assert loss.rate == pytest.approx(found.fun, rel=1e-3)  # the states visited come that near to the largest


def test_cycle_of_the_dahl_law_is_its_loop():
    """xi = g tanh at the turns, and 4 F_c (A - g tanh(A/g)) of energy (docs/model.md); A is half the way."""
    law = laws()["dahl"]()
    half, length = 2e-3, 1.5e-3
    cycle = closed_cycle(recorded_law(law), [1.0, -1.0], [2 * half, 2 * half], [0.0], [length])
    assert cycle is not None
    assert cycle.closure <= 1e-8
    assert np.max(cycle.internal) == pytest.approx(length * math.tanh(half / length), rel=1e-7)
    assert cycle.energy == pytest.approx(4 * 0.15 * (half - length * math.tanh(half / length)), rel=1e-7)


def test_levels_that_never_close_are_no_cycle():
    """Steps of one direction under a spring that never yields lead ever further."""

    @parameters
    class Spring(Law):
        name: ClassVar[str] = "spring"
        kind: ClassVar = "smooth"
        internal: ClassVar = ("stretch",)

        def force(self, velocity, internal, side, load):
            return load * internal[0], (1.0 * velocity,)

    assert closed_cycle(recorded_law(Spring()), [1.0, 0.5], [1.0, 1.0], [0.0], [1.0]) is None


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"load": 0.0}, "load should be a positive number, got 0.0"),
        ({"load": True}, "load should be a positive number"),
        ({"fastest": -1.0}, "fastest should be a positive number, got -1.0"),
    ],
)
def test_wrong_arguments_are_named(arguments, words):
    with pytest.raises(ValueError, match=words):
        passivity(vc.LuGre(), **arguments)
    with pytest.raises(ValueError, match="law should be a friction law"):
        passivity("lugre")  # type: ignore[arg-type]


@pytest.mark.slow
def test_laws_of_several_states_and_pieces():
    slip = passivity(laws()["maxwell-slip"]())
    assert slip.verdict == CREATES
    assert slip.cycle.share < -0.2
    assert slip.speed_needed is None
    # It is back where it began, in place as in its states.
    travel = np.trapezoid(slip.cycle.velocity, slip.cycle.time)
    assert abs(travel) < 1e-2 * np.trapezoid(np.abs(slip.cycle.velocity), slip.cycle.time)
    assert passivity(laws()["maxwell-slip"](coulomb_coefficient=0.45)).verdict == PROVEN
    plastic = passivity(laws()["elasto-plastic"]())
    assert plastic.verdict == CREATES
    assert plastic.speed_needed == pytest.approx(passivity(vc.LuGre()).speed_needed, rel=0.2)
