"""Energy and sticking: identities of the equations, reference values, and phases laid down by hand."""

import math

import numpy as np
import pytest

import vibrocap as vc
from signals import Signal, made_up_motion, paper_motion, paper_system
from vibrocap.measures.gathered import Gathered, balanced
from vibrocap.motion.recording.equations import equations, parameter_values

PERIOD = 2 * math.pi


@pytest.fixture(scope="module", params=["exponential", "lugre"])
def steady(request):
    law = {"exponential": vc.Exponential(), "lugre": vc.LuGre()}[request.param]
    return paper_motion(law, periods=100)


def by_quadrature(motion, integrand, start, end):
    """An integral by 20 Gauss points on 400 equal panels, cut at the events: it shares nothing with the measures."""
    events = [t for t in motion.event_times if start < t < end]
    marks = np.unique(np.concatenate((np.linspace(start, end, 401), events)))
    points, weights = np.polynomial.legendre.leggauss(20)
    half = 0.5 * np.diff(marks)[:, None]
    t = 0.5 * (marks[1:] + marks[:-1])[:, None] + half * points
    return float(np.sum(half * weights * integrand(t.ravel()).reshape(t.shape)))


def test_channels_are_the_integrals_of_their_powers(steady):
    start, end = 98.3 * PERIOD, 99.6 * PERIOD
    balance = vc.energy_balance(steady, (start, end))

    def integral(power):
        return by_quadrature(steady, lambda t: power(lambda name: steady.at(t, name)), start, end)

    contact = steady.at([start, end], "contact_energy")
    # The pieces of the motion meet to within the tolerance of the run, 1e-10.
    assert balance.drive == pytest.approx(integral(lambda at: at("drive") * at("angle_rate")), abs=1e-9)
    assert balance.damper == pytest.approx(integral(lambda at: -1.0 * at("angle_rate") ** 2), abs=1e-9)
    # -R v is what the contact loses and what the bristles store.
    friction = integral(lambda at: -at("friction") * at("velocity"))
    assert balance.friction - (contact[1] - contact[0]) == pytest.approx(friction, abs=1e-9)
    if steady.system.friction.internal:
        bristle = integral(lambda at: -10.0 * at("bristle_rate") ** 2)
        assert balance.bristle_loss == pytest.approx(bristle, abs=1e-9)
        assert balance.bristle_loss < -1e-3
    else:
        assert balance.bristle_loss == 0.0


def test_what_goes_in_is_stored_or_lost(steady):
    for window in (None, (0.1, 5.0), (300.0, 301.0)):
        balance = vc.energy_balance(steady, window)
        total = balance.drive + balance.damper + balance.contact_sliding + balance.bristle_loss
        assert abs(balance.residual) <= 100 * steady.tolerance
        assert balance.residual == pytest.approx(balance.stored - total, abs=1e-13)
    assert abs(vc.energy_balance(steady, (0.1, 5.0)).stored) > 1e-2  # so the window is not a trivial one


def test_per_period_and_mean_power(steady):
    """A steady period stores nothing, and has no mean friction: momentum returns, and its rate is -R."""
    ten, one = vc.energy_balance(steady, periods=10), vc.energy_balance(steady, periods=1)
    assert abs(one.stored) < 1e-8
    assert one.periods == 1.0
    assert np.diff(steady.at([99 * PERIOD, 100 * PERIOD], "impulse")) == pytest.approx([0.0], abs=1e-8)
    assert ten.per_period.drive == pytest.approx(one.drive, rel=1e-7)
    assert ten.mean_power.drive == pytest.approx(one.drive / PERIOD, rel=1e-7)
    assert ten.per_period.window == ten.window
    assert ten.per_period.residual == ten.residual / 10


# ---------------------------------------------------------------------------------------------------------------------
# Sticking

RESTS = np.pi / 2 + np.pi * np.arange(8)  # of X' = cos t over 4 periods
STUCK = [(1.0, 2.0), (4.5, 4.75), (7.0, 7.5), (13.0, 14.0), (PERIOD * 3 - 0.25, PERIOD * 3 + 0.5)]


@pytest.fixture(scope="module")
def by_hand():
    cosine = Signal(((1.0, 1.0, -np.pi / 2),))
    return made_up_motion(vc.Exponential(), cosine, lambda t, side: 0.0 * t, rests=RESTS, stuck=STUCK)


def test_stick_phases_laid_down_by_hand(by_hand):
    phases = vc.stick_phases(by_hand)
    assert phases.number == 5
    assert phases.lengths == pytest.approx((1.0, 0.25, 0.5, 1.0, 0.75), abs=1e-13)
    assert phases.total == pytest.approx(3.5, abs=1e-13)
    assert phases.longest == pytest.approx(1.0, abs=1e-13)
    assert vc.stick_fraction(by_hand) == pytest.approx(3.5 / (4 * PERIOD), abs=1e-14)


def test_a_window_cuts_phases(by_hand):
    phases = vc.stick_phases(by_hand, (1.5, 4.6))
    assert phases.lengths == pytest.approx((0.5, 0.1), abs=1e-13)
    assert vc.stick_fraction(by_hand, (1.5, 4.6)) == pytest.approx(0.6 / 3.1, abs=1e-13)
    assert vc.stick_phases(by_hand, periods=1).lengths == pytest.approx((0.5,), abs=1e-12)
    assert vc.stick_phases(by_hand, (2.0, 4.5)).number == 0  # it only touches two
    assert vc.stick_phases(by_hand, (2.0, 4.5)).longest == 0.0
    assert vc.stick_fraction(by_hand, (1.2, 1.4)) == pytest.approx(1.0)


def test_words(by_hand):
    # cos t: forward up to pi/2 (stuck 1 to 2), back to 3 pi/2 = 4.712 (stuck 4.5 to 4.75), forward to 2 pi; of the
    # second period stuck 0.72 to 1.22 after its start, of the third 0.43 to 1.43 and from 0.25 before its end
    assert [vc.mode_sequence(by_hand, period) for period in range(4)] == ["FSBS", "FSFB", "FSFBFS", "SFBF"]


def test_share_of_time_below_a_stated_speed():
    """For a law that creeps and one that sticks: the share of a dense grid that is slower."""
    for law in (vc.LuGre(), vc.Exponential()):
        motion = vc.simulate(paper_system(law), periods=4, initial={"angle": 1.0})
        slow = np.abs(motion.at(np.linspace(0.0, motion.end, 40_001), "contact_velocity")) < 0.02
        assert 0.0 < np.mean(slow) < 1.0
        assert vc.stick_fraction(motion, below=0.02) == pytest.approx(np.mean(slow), abs=1e-3)
    assert vc.stick_fraction(motion, below=1e-13) == pytest.approx(vc.stick_fraction(motion), abs=1e-6)
    with pytest.raises(ValueError, match="below should be a sliding speed greater than 0, got 0"):
        vc.stick_fraction(motion, below=0)


def test_reference_stick_fraction(steady):
    first40 = (0.0, 40 * PERIOD)
    if steady.system.friction.kind == "set-valued":
        assert vc.stick_fraction(steady, first40) == pytest.approx(0.0487, abs=5e-5)
        assert vc.mode_sequence(steady) == "FBSB"
        # While it sticks the velocity is exactly zero.
        last = [phase for phase in steady.phases if phase.side == 0][-1]
        assert np.all(steady.at(np.linspace(last.start, last.end, 50)[1:-1], "velocity") == 0.0)
        assert vc.stick_phases(steady, periods=1).lengths == pytest.approx((last.length,), abs=1e-12)
    else:
        assert (vc.stick_fraction(steady, first40), vc.stick_phases(steady)) == (None, None)
        assert vc.mode_sequence(steady) == "FBFB"


class Zeros:
    """Results of two runs that begin and end at zero, in which the drive did some work all the same."""

    def __init__(self, states, works, steps):
        self.start = self.state = np.zeros((2, states))
        self.works, self.steps = works, steps

    def __len__(self):
        return 2

    def entry(self, name, i):
        return self.works if i == 0 else np.zeros(2)

    def head(self, name):
        return np.full(2, self.steps[name])


def test_works_of_an_ensemble_add_up_to_the_natural_size_of_the_energy():
    """k L^2 + m V^2 of an oscillator with L and V far from 1: 100 tolerances of it, and a tenth for each step."""
    system = vc.System(vc.Oscillator(mass=0.02, stiffness=300.0, belt_speed=0.0), vc.Coulomb(), vc.Harmonic())
    length, speed = system.scales()
    size = 1e-8 * (100 + 0.1 * 30) * (300.0 * length**2 + 0.02 * speed**2)
    results = Zeros(2, size * np.array([0.999, 1.001]), {"taylor_steps": 20.0, "implicit_steps": 10.0})
    gathered = Gathered(system, results, np.ones(2), np.zeros(2, bool), 0.0)  # type: ignore[arg-type]
    parameters = np.tile(parameter_values(system), (2, 1))
    assert balanced(equations(system), gathered, parameters, 1e-8).tolist() == [True, False]
