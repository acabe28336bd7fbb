"""The order of both methods on forced problems with events, and faults that this must notice.

Steps are fixed here: the plain-Python kernel runs with another choice of step. For the Taylor method kernels of a low
order are generated, since the error of order 12 meets rounding after one halving. An unforced problem, or one without
events, would notice none of the planted faults.
"""

import numpy as np
import pytest

import vibrocap as vc
from plain_kernels import kernel_of, running_on
from thinned import slow_but
from vibrocap.motion.recording.equations import equations, parameter_values
from vibrocap.numerics.kernel.codes import DONE
from vibrocap.numerics.kernel.step import implicit
from vibrocap.numerics.run.budget import Budget, MotionStart
from vibrocap.numerics.run.motion import recorded_run

MACHINE = vc.PendulumCapsule(mass_ratio=2.5, stiffness=2.0, damping=1.0, normal_load=1.0)
DRIVE = vc.Biharmonic(amplitude=1.8, frequency=1.0, second_amplitude=0.5, second_phase=0.8)
STICK_SLIP = vc.System(MACHINE, vc.Exponential(), DRIVE)  # three reversals, a stick and a slip within the run
REVERSING = vc.System(  # three reversals; its friction is mild enough for steps that resolve it
    MACHINE, vc.LuGre(10.0, 4.0, 0.3, 0.15, 0.45, stribeck_velocity=0.5), DRIVE
)
START = {"angle": 1.0, "velocity": 0.2}
PERIODS = 1.3
WITHIN = 0.15


def slope(steps, errors):
    """Least-squares slope of log error over log step."""
    return -np.polyfit(np.log(steps), np.log(errors), 1)[0]


# --- Taylor ----------------------------------------------------------------------------------------------------------

STEPS = np.arange(120, 600, 48)  # per period
MIDDLE = np.linspace(0.013, PERIODS - 0.011, 97) * DRIVE.period  # within steps, for the dense output


@pytest.fixture(scope="module")
def exact():
    """A run at order 12 and tolerance 1e-11, whose error is some 1e-12; those below are 6e-11 at least."""
    motion = vc.simulate(STICK_SLIP, periods=PERIODS, initial=START, tolerance=1e-11)
    assert [event.kind for event in motion.events] == ["reversal"] * 3 + ["stick", "slip_back"]
    return motion


def errors_of(kernel, exact, fault=None):
    """Errors at the end and within the steps, for every number of steps per period."""
    ends, middles = [], []
    for count in STEPS:
        step = DRIVE.period / count
        replaced = {
            "step_length": lambda floats, ints, lane, remaining, step=step: step,
            "resolved": lambda floats, lane, h: True,  # a check that would halve steps
        }
        with running_on(kernel, **replaced, **(fault(kernel, step) if fault else {})):
            motion = vc.simulate(STICK_SLIP, periods=PERIODS, initial=START)
        assert motion.status.ok
        ends.append(np.abs(np.array(list(motion.state.values())) - list(exact.state.values())).max())
        middles.append(np.abs(motion.states(MIDDLE) - exact.states(MIDDLE)).max())
    return ends, middles


@pytest.mark.parametrize("order", slow_but([1], [3, 4, 5]))
def test_taylor_keeps_its_order_through_events(order, exact):
    ends, middles = errors_of(kernel_of(STICK_SLIP, order), exact)
    assert abs(slope(STEPS, ends) - order) <= WITHIN
    assert abs(slope(STEPS, middles) - order) <= WITHIN


def event_truncated(kernel, step):
    """The time of an event comes from the first two terms of its series."""
    first_root = kernel["first_root"]

    def truncated(floats, row, degree, sign, zeros, h):
        root, touch = first_root(floats, row, degree, sign, zeros, h)
        return (min(h, -floats[row] / floats[row + 1]) if root > 0.0 and zeros == 0 else root), touch

    return {"first_root": truncated}


def slip_late(kernel, step):
    """The hold gives way late by the order of a step; the friction force is continuous there, which hides one order."""
    first_event = kernel["first_event"]
    limit = kernel["LIMIT_OF"][0]

    def off(floats, *rest):
        floats[limit] *= 1.0 + step
        return first_event(floats, *rest)

    return {"first_event": off}


@pytest.mark.parametrize("fault", [event_truncated, slip_late])
def test_planted_faults_are_rejected(fault, exact):
    order = 4
    ends, _ = errors_of(kernel_of(STICK_SLIP, order), exact, fault)
    assert abs(slope(STEPS, ends) - order) > 4 * WITHIN


# --- Rodas5P ---------------------------------------------------------------------------------------------------------

IMPLICIT_STEPS = (450, 800, 1400)


def implicit_error(kernel, count, exact, fault=None):
    """Error at the end with so many implicit steps per period; a start from rest is a Taylor step, as in production."""
    step = DRIVE.period / count

    def step_length(floats, ints, lane, remaining):
        if ints[kernel["TRANSITION"] + lane] > 0:
            ints[kernel["STIFF"] + lane] = 0
            return min(step, kernel["taylor_step"](floats, ints, lane))
        ints[kernel["STIFF"] + lane] = 1
        floats[kernel["IMPLICIT_STEP"] + lane] = step
        return kernel["implicit_step"](floats, ints, lane, remaining)

    start = [START.get(name, 0.0) for name in REVERSING.state_names]
    recording, parameters = equations(REVERSING), parameter_values(REVERSING)
    with running_on(kernel, step_length=step_length, **(fault(kernel, step) if fault else {})):
        # at a tolerance of 1e6 no step is refused
        run = recorded_run(MotionStart(recording, parameters, start, DRIVE.period), Budget(PERIODS, 1e6, 1000, 100_000))
    assert run.status == DONE
    assert run.implicit_steps > 20 * run.taylor_steps
    assert len(run.events) == 3
    coefficients, length = run.series[-1:][0], run.piece_lengths[-1]
    return np.abs(np.polynomial.polynomial.polyval(length, coefficients.T) - exact).max()


@pytest.fixture(scope="module")
def exact_reversing():
    motion = vc.simulate(REVERSING, periods=PERIODS, initial=START, tolerance=1e-13)
    assert [event.kind for event in motion.events] == ["reversal"] * 3
    return np.array(list(motion.state.values()))


@pytest.mark.slow
def test_rodas_keeps_its_order_through_reversals(exact_reversing):
    kernel = kernel_of(REVERSING)
    errors = [implicit_error(kernel, count, exact_reversing) for count in IMPLICIT_STEPS]
    assert abs(slope(IMPLICIT_STEPS, errors) - 5.0) <= WITHIN


def stage_late(kernel, step):
    """Every stage sees the drive a hundredth of a step late."""
    rates = kernel["rates"]
    return {"rates": lambda floats, t, *rest: rates(floats, t + 0.01 * step, *rest)}


def time_derivative_lost(kernel, step):
    """df/dt is left out, as for an unforced problem."""
    jacobian, width = kernel["jacobian"], kernel["WIDTH"]

    def unforced(floats, t, point, lane, out):
        jacobian(floats, t, point, lane, out)
        floats[out + width - 1 : out + kernel["STATES"] * width : width] = 0.0

    return {"jacobian": unforced}


@pytest.mark.slow
@pytest.mark.parametrize("fault", [stage_late, time_derivative_lost])
def test_planted_faults_of_the_implicit_method_are_rejected(fault, exact_reversing):
    kernel = kernel_of(REVERSING)
    errors = [implicit_error(kernel, count, exact_reversing, fault) for count in IMPLICIT_STEPS[:2]]
    assert abs(slope(IMPLICIT_STEPS[:2], errors) - 5.0) > 4 * WITHIN


@pytest.mark.slow
def test_an_implicit_step_to_a_reversal_ends_at_rest(exact_reversing):
    """The step has the length at which its own end is at rest; its dense output is less exact, which shows."""
    kernel = kernel_of(REVERSING)
    polished_step = kernel["polished_step"]
    sizes, guessed = [], []

    def noted(floats, ints, lane, h, longest):
        event, length = polished_step(floats, ints, lane, h, longest)
        if event == 1 and ints[kernel["STIFF"] + lane] == 1:
            guessed.append(abs(kernel["end_velocity"](floats, ints, lane, h)))
            sizes.append(abs(kernel["end_velocity"](floats, ints, lane, length)))
        return event, length

    implicit_error(kernel, 60, exact_reversing, lambda *_: {"polished_step": noted})
    assert len(sizes) == 3
    assert max(sizes) <= 1e-15
    assert min(guessed) > 1e-12


class Tableau:
    """Rodas5P in its original form (Hairer and Wanner 1996, IV.7): from the transformed coefficients of `implicit.py`.

    Gamma = (I/gamma - C)^-1, alpha = A Gamma, b = m Gamma, beta = alpha + Gamma.
    """

    stages = implicit.STAGES
    gamma_matrix = np.linalg.inv(np.eye(stages) / implicit.GAMMA - implicit.COUPLING)
    alpha_matrix = implicit.STAGE_WEIGHTS @ gamma_matrix
    beta_matrix = alpha_matrix + gamma_matrix
    alpha, beta = alpha_matrix.sum(axis=1), beta_matrix.sum(axis=1)
    weights = implicit.STAGE_WEIGHTS[-1] + np.array([0.0] * 5 + [0.0, 0.0, 1.0])

    def conditions(self, weights, x=1.0):
        """(order, sum over the stages, what it should be) for every tree up to order 5, after a share x of the step."""
        b = weights @ self.gamma_matrix
        a1, b1, a2, b2 = self.alpha, self.beta, self.alpha_matrix, self.beta_matrix
        trees = [
            (1, np.ones(8), 1),
            (2, b1, 2),
            (3, a1**2, 3),
            (3, b2 @ b1, 6),
            (4, a1**3, 4),
            (4, a1 * (a2 @ b1), 8),
            (4, b2 @ a1**2, 12),
            (4, b2 @ b2 @ b1, 24),
            (5, a1**4, 5),
            (5, a1**2 * (a2 @ b1), 10),
            (5, (a2 @ b1) ** 2, 20),
            (5, a1 * (a2 @ a1**2), 15),
            (5, a1 * (a2 @ b2 @ b1), 30),
            (5, b2 @ a1**3, 20),
            (5, b2 @ (a1 * (a2 @ b1)), 40),
            (5, b2 @ b2 @ a1**2, 60),
            (5, b2 @ b2 @ b2 @ b1, 120),
        ]
        return [(order, float(b @ tree), x**order / density) for order, tree, density in trees]


TABLEAU = Tableau()
SIXTEEN_DIGITS = 1e-12  # coefficients up to 170 with 16 digits, through an inverse


def test_order_conditions():
    for order, value, wanted in TABLEAU.conditions(TABLEAU.weights):
        assert value == pytest.approx(wanted, abs=SIXTEEN_DIGITS), (order, wanted)


def test_nodes_and_time_weights_are_row_sums():
    assert pytest.approx(TABLEAU.alpha, abs=SIXTEEN_DIGITS) == implicit.NODES
    assert TABLEAU.gamma_matrix.sum(axis=1) == pytest.approx(implicit.TIME_WEIGHTS, abs=SIXTEEN_DIGITS)
    assert np.diag(TABLEAU.gamma_matrix) == pytest.approx([implicit.GAMMA] * 8, abs=SIXTEEN_DIGITS)


def test_error_estimate_is_of_order_four():
    """The last stage is the difference to an embedded solution that fulfils all conditions up to 4, and none of 5."""
    embedded = TABLEAU.weights - np.eye(8)[-1]
    for order, value, wanted in TABLEAU.conditions(embedded):
        if order <= 4:
            assert value == pytest.approx(wanted, abs=SIXTEEN_DIGITS), (order, wanted)
    assert max(abs(value - wanted) for order, value, wanted in TABLEAU.conditions(embedded) if order == 5) > 1e-4


def dense_weights(x):
    """y(x) = (1-x) y0 + x [y1 + (1-x) (K1 + x (K2 + x K3))]."""
    k1, k2, k3 = implicit.DENSE
    return x * (TABLEAU.weights + (1 - x) * (k1 + x * (k2 + x * k3)))


@pytest.mark.parametrize("x", [0.15, 0.4, 0.5, 0.85, 1.0])
def test_dense_output_is_of_order_four(x):
    for order, value, wanted in TABLEAU.conditions(dense_weights(x), x):
        if order <= 4:
            assert value == pytest.approx(wanted, abs=SIXTEEN_DIGITS), (order, wanted)


def test_stiff_decay_is_damped():
    """R(z) = 1 + z b (I - z beta)^-1 1 vanishes at infinity, also for the embedded solution and after every time."""
    for weights in (TABLEAU.weights, TABLEAU.weights - np.eye(8)[-1]):
        b = weights @ TABLEAU.gamma_matrix
        z = -1e7
        stability = 1 + z * b @ np.linalg.solve(np.eye(8) - z * TABLEAU.beta_matrix, np.ones(8))
        assert abs(stability) < 1e-5
    largest = 0.0
    for y in np.geomspace(1e-2, 1e4, 200):  # on the imaginary axis
        z = 1j * y
        b = TABLEAU.weights @ TABLEAU.gamma_matrix
        largest = max(largest, abs(1 + z * b @ np.linalg.solve(np.eye(8) - z * TABLEAU.beta_matrix, np.ones(8))))
    assert largest <= 1.0 + 1e-9
