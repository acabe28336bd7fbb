"""Stabilised Taylor steps: their polynomials, what they save where bristles are stiff, and what they must not cost."""

import math

import numpy as np
import pytest

import vibrocap as vc
from plain_kernels import kernel_of, running_on
from stability_polynomials import DAMPED, damping, interval, longest_reach, smallest_filter, terms, undamped, wedge
from thinned import slow_but
from vibrocap.motion.recording.equations import equations, parameter_values
from vibrocap.numerics.expressions.graph import derivative, evaluate
from vibrocap.numerics.expressions.structure import decay_rates
from vibrocap.numerics.kernel.step.stabilised import POLYNOMIALS

ORDERS = sorted(POLYNOMIALS)
MACHINE = vc.PendulumCapsule(mass_ratio=0.3, stiffness=2.0, damping=1.0)
SYSTEM = vc.System(MACHINE, vc.LuGre(), vc.Harmonic(amplitude=1.8, frequency=1.0))
START = {"angle": math.pi / 3, "bristle": 0.0026}
PERIODS, TOLERANCE = 2, 1e-7
SYSTEM_ROWS = 5


def multiplied(z, order, factors):
    """R(z), by which a step multiplies a disturbance that decays like exp(z)."""
    return undamped(z, order) + terms(z, order) @ np.asarray(factors)


@pytest.mark.parametrize("order", ORDERS)
def test_fast_decays_are_damped_up_to_the_stated_reach(order):
    reach, factors, _ = POLYNOMIALS[order]
    x = np.linspace(-reach, -1e-3, 5000)
    size = np.abs(multiplied(x, order, factors))
    assert np.all(size <= np.where(x < -2.5, 0.9, 1.0) + 1e-3)
    assert np.all(np.abs(multiplied(wedge(reach, 2000), order, factors)) <= 1.0 + 1e-3)
    assert np.abs(multiplied(np.array([-1.1 * reach]), order, factors))[0] > 1.0
    plain = np.abs(multiplied(x, order, np.ones(DAMPED)))
    assert plain.max() > 1e3  # what the damping is for


@pytest.mark.parametrize("order", slow_but([0], ORDERS))
def test_polynomials_are_the_best_and_filters_the_smallest(order):
    reach, factors, filters = POLYNOMIALS[order]
    assert longest_reach(order) == pytest.approx(reach, rel=1e-3)
    assert damping(order, reach) == pytest.approx(factors, rel=3e-3)
    assert filters[0] == pytest.approx(1.0 - factors[0], rel=1e-12)
    expected, largest = smallest_filter(order, reach, filters[0])
    assert filters == pytest.approx(expected, rel=3e-3)
    assert np.abs(terms(interval(reach, 3000), order) @ filters).max() == pytest.approx(largest, rel=1e-2)
    assert largest < 12.0


@pytest.fixture(scope="module")
def kernel():
    return kernel_of(SYSTEM, 12)


@pytest.fixture(scope="module")
def expected():
    return final(vc.simulate(SYSTEM, periods=PERIODS, initial=START, tolerance=1e-12))


def final(motion):
    assert motion.status.ok
    return np.array(list(motion.state.values()))


def run(kernel, **replaced):
    """(error of the final state, Taylor steps) of a run on the plain kernel with functions replaced."""
    with np.errstate(all="ignore"), running_on(kernel, **replaced):
        motion = vc.simulate(SYSTEM, periods=PERIODS, initial=START, tolerance=TOLERANCE)
    return motion, motion.certificate.taylor_steps


@pytest.mark.slow
def test_fewer_steps_for_no_larger_error(kernel, expected):
    """A light capsule on bristles, where stability ends plain steps early: three steps of ten are saved at least."""
    motion, steps = run(kernel)
    plain_motion, plain_steps = run(kernel, stabilised_step=lambda *given: (given[3], False))
    assert steps < 0.7 * plain_steps
    error, plain_error = (np.abs(final(found) - expected).max() for found in (motion, plain_motion))
    assert error < 3.0 * plain_error
    assert motion.certificate.energy_residual <= 100.0 * TOLERANCE
    assert motion.certificate.event_velocity < 1e-13


def test_steps_without_stiffness_are_plain(kernel):
    """A slow decay, which stability does not bound: the length is the plain one and no coefficient is touched."""
    for row in range(SYSTEM_ROWS):
        kernel.series(row)[:] = [0.1 * (-0.5) ** k / math.factorial(k) for k in range(13)]
    kernel.fill("TOLERANCE", TOLERANCE)
    kernel.fill("TRANSITION", 0)
    kernel.fill("DECAY_RATE", 0.5)
    before = kernel.floats.copy()
    length, gentle = kernel["series_step"](kernel.floats, kernel.ints, 0, 100.0)
    assert gentle
    assert length == kernel["taylor_step"](kernel.floats, kernel.ints, 0)
    assert np.array_equal(kernel.floats, before)


def test_a_fast_decay_is_damped_for_a_longer_step(kernel):
    """Beside it a disturbance that decays 40 times as fast: the step goes on, and the last terms are damped."""
    for row in range(SYSTEM_ROWS):
        size = kernel.floats[kernel.place("SCALE") + row]
        decays = [(0.1 * (-0.5) ** k + 1e-3 * TOLERANCE * (-20.0) ** k) / math.factorial(k) for k in range(13)]
        kernel.series(row)[:] = np.multiply(size, decays)
    kernel.fill("TOLERANCE", TOLERANCE)
    kernel.fill("TRANSITION", 0)
    kernel.fill("DECAY_RATE", 20.0)
    plain, before = kernel["taylor_step"](kernel.floats, kernel.ints, 0), kernel.series(0).copy()
    length, gentle = kernel["series_step"](kernel.floats, kernel.ints, 0, 100.0)
    assert not gentle
    assert 1.1 * plain < length == pytest.approx(0.85 * POLYNOMIALS[12][0] / 20.0)
    assert np.array_equal(kernel.series(0)[:10], before[:10])
    assert kernel.series(0)[10:] == pytest.approx(before[10:] * POLYNOMIALS[12][1], rel=1e-15)


def test_the_rate_is_the_trace_of_the_jacobian(kernel):
    """With the other sign; for a fast contact it is the rate of the bristles, the eigenvalue of the fastest decay."""
    state = [0.5, 0.3, 0.0, 0.4, 0.0015]
    kernel.fill("STATE", state)
    kernel.fill("SIDE", 1.0)
    kernel["jet"](kernel.floats)
    point = kernel.names["WORK"] + 100
    kernel.floats[point : point + SYSTEM_ROWS] = state
    kernel["jacobian"](kernel.floats, 0.0, point, 0, point + SYSTEM_ROWS)
    size = SYSTEM_ROWS * (SYSTEM_ROWS + 1)
    slopes = kernel.floats[point + SYSTEM_ROWS :][:size].reshape(SYSTEM_ROWS, -1)[:, :SYSTEM_ROWS]
    rate = kernel.floats[kernel.place("DECAY_RATE")]
    assert rate == pytest.approx(-np.trace(slopes), rel=1e-13)
    assert rate == pytest.approx(-np.linalg.eigvals(slopes).real.min(), rel=0.02)


def test_bristles_of_two_contacts_do_not_add_their_rates():
    """The fastest decay is that of one contact: of two that slide alike, the trace would be twice as much."""
    system = vc.System(vc.TwoBodyCrawler(), vc.LuGre(), vc.Harmonic())
    recorded, parameters = equations(system), parameter_values(system)
    moving = {"velocity": 2.0, "velocity_2": -1.5, "bristle": 0.0015, "bristle_2": -0.0015}
    states = [moving.get(name, 0.1) for name in system.state_names]
    slopes = [derivative(rate, i) for rate in recorded.rates for i in range(len(states))]
    jacobian = np.reshape([float(value) for value in evaluate(slopes, 0.0, states, 1.0, parameters)], (len(states), -1))
    fastest = np.max(np.abs(np.linalg.eigvals(jacobian)))
    rates = evaluate(decay_rates(recorded), 0.0, states, 1.0, parameters)
    assert len(rates) == 2
    assert fastest > 1000.0
    assert max(rates) == pytest.approx(fastest, rel=0.05)  # dampers and springs, a hundredth of it
