"""What smoothing a contact costs: the smoothed laws, the meter, the fitted order."""

import dataclasses
import math

import numpy as np
import pytest

import vibrocap as vc
from vibrocap.laboratory import regularisation
from vibrocap.laboratory.regularisation import SmoothedRun, regularisation_error, width_for
from vibrocap.motion.status import Status
from vibrocap.numerics.expressions.graph import Graph, evaluate
from vibrocap.physics.catalogue import law as named
from vibrocap.physics.catalogue import laws
from vibrocap.physics.friction.wrappers import smoothed

START = {"angle": math.pi / 3}
SYSTEM = vc.System(vc.PendulumCapsule(), vc.Exponential(), vc.Harmonic())
SET_VALUED = [*(kind for kind in laws().values() if kind.kind == "set-valued"), named("anisotropic-coulomb")]


# --- the smoothed laws -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", SET_VALUED, ids=[kind.name for kind in SET_VALUED])
@pytest.mark.parametrize("shape", ["tanh", "arctan"])
def test_smoothed_law_is_the_law_times_a_smooth_sign(kind, shape):
    sharp, law = kind(), smoothed(kind)(smoothing_velocity=0.02, shape=shape)
    graph = Graph()
    recorded = graph.expression(law.force(graph.node("state", 0), (), graph.node("side", 0), 1.7)[0])
    for v in (0.001, 0.02, 0.3, 5.0):
        sign = math.tanh(v / 0.02) if shape == "tanh" else 2.0 / math.pi * math.atan(v / 0.02)
        for side in (1, -1):
            expected = sign * sharp.force(side * v, (), side, 1.7)[0]
            assert law.force(side * v, (), side, 1.7)[0] == pytest.approx(expected, rel=1e-14)
            assert evaluate([recorded], 0.0, [side * v], side, ())[0] == pytest.approx(expected, rel=1e-14)
        assert law.steady_force(v, 1.7) == pytest.approx(sign * sharp.steady_force(v, 1.7), rel=1e-14)
    assert law.force(0.0, (), 1, 1.7)[0] == 0.0
    assert (law.kind, law.name) == ("kinked", f"smoothed-{kind.name}")
    assert law.passive == sharp.passive
    assert law.symmetric == sharp.symmetric


def test_smoothed_laws_are_checked_like_others():
    assert smoothed(vc.Exponential) is smoothed(vc.Exponential)
    with pytest.raises(ValueError, match="only a set-valued law can be smoothed, got the lugre law, which is kinked"):
        smoothed(vc.LuGre)
    for values in ({"smoothing_velocity": 0.0}, {"shape": "sine"}, {"decay_rate": -1.0}, {"width": 1.0}):
        with pytest.raises(ValueError, match=next(iter(values))):
            smoothed(vc.Exponential)(**values)


# --- the meter, with runs that are made up ---------------------------------------------------------------------------


@pytest.fixture
def made_up(monkeypatch):
    """A function that lets the measure of smoothed runs be 5 plus an error of the width."""

    def install(error, noise=1e-12):
        def run(self, width):
            return SmoothedRun(width, 5.0 + error(width), noise, 100, Status.FINISHED)

        def start(self, system, measure, *rest):
            self.system, self.name, self.shape, self.speed = system, measure, "tanh", 0.5
            self.exact = SmoothedRun(0.0, 5.0, noise, 50, Status.FINISHED)

        monkeypatch.setattr(regularisation._Meter, "__init__", start)
        monkeypatch.setattr(regularisation._Meter, "run", run)

    return install


@pytest.mark.parametrize("order", [0.5, 1.0, 2.0])
def test_order_and_width_are_those_of_a_power(made_up, order):
    made_up(lambda width: -3.0 * width**order)
    report = regularisation_error(SYSTEM)
    assert len(report.runs) == 13
    np.testing.assert_allclose(report.widths, 0.05 * 10.0 ** (-0.5 * np.arange(13)))
    np.testing.assert_allclose(report.errors, -3.0 * report.widths**order, atol=1e-14)
    assert report.order == pytest.approx(order, abs=1e-6)
    assert report.smooth
    found = width_for(SYSTEM, error=0.01)
    exact = min((0.05 / 3.0) ** (1.0 / order), 0.05)  # the widest that is tried
    assert exact / 1.02 <= found.width <= exact * (1 + 1e-9)
    assert abs(found.run.value - 5.0) <= found.error == pytest.approx(0.05)
    absolute = width_for(SYSTEM, error=0.05, relative=False)
    assert absolute.width == found.width
    assert len(found.regularisation.runs) <= 18


def test_order_holds_where_the_slope_is_even(made_up):
    """First order below 1e-3, saturated above; below 1e-7 the errors drown in the noise of integration."""
    made_up(lambda width: width / (1.0 + width / 1e-3), noise=1e-8)
    report = regularisation_error(SYSTEM, widths=np.geomspace(1e-9, 1.0, 28))
    low, high = report.order_range
    assert 1e-7 / 2.2 < low < 2.2e-7  # ABOVE_NOISE times the noise of both runs is 1e-7
    assert 1e-5 <= high <= 1e-3
    assert report.order == pytest.approx(1.0, abs=0.1)
    assert report.smooth


def test_errors_that_jump_or_change_their_sign_are_not_smooth(made_up):
    made_up(lambda width: width * math.cos(3.0 * math.log(width)))
    report = regularisation_error(SYSTEM)
    assert not report.smooth
    assert "not smooth in the width" in report.text
    made_up(lambda width: 0.3 if width < 1e-2 else width)  # another steady motion, however narrow
    report = regularisation_error(SYSTEM)
    assert not report.smooth
    found = width_for(SYSTEM, error=0.01)
    assert found.width is None
    assert found.run is None


def test_a_width_counts_only_if_narrower_ones_are_as_good(made_up):
    """The error happens to vanish at 0.005, one of the widths tried first, and is too large again below it."""
    made_up(lambda width: 0.0 if abs(width - 0.005) < 1e-9 else width * 100.0)
    found = width_for(SYSTEM, error=0.01)
    assert found.width <= 5e-4


# --- the meter -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"shape": "sine"}, "shape should be 'tanh' or 'arctan', got 'sine'"),
        ({"widths": [1e-3, -1.0]}, "widths should be a list of positive numbers"),
        ({"measure": "travel_speed"}, "there is no measure 'travel_speed'"),
        ({"measure": "mode_sequence"}, "measure should be a number, got 'mode_sequence', which is a text"),
        ({"system": dataclasses.replace(SYSTEM, friction=vc.LuGre())}, "only a set-valued law can be smoothed"),
        ({"system": "EM"}, "system should be a System"),
        ({"periods": 0}, "periods should be a positive number"),
    ],
)
def test_wrong_arguments_are_named(arguments, words):
    settings = {"system": SYSTEM, "initial": START, "periods": 2} | arguments
    with pytest.raises(ValueError, match=words):
        regularisation_error(settings.pop("system"), **settings)


def test_errors_that_cannot_be_asked_for():
    with pytest.raises(ValueError, match="error should be a positive number, got -1"):
        width_for(SYSTEM, error=-1.0)
    with pytest.raises(ValueError, match="error should be above that of integration"):
        width_for(SYSTEM, error=1e-14, initial=START, periods=2)


@pytest.mark.slow
def test_travel_of_the_reference_motion():
    """docs/model.md: -62 % at 1e-2, -9.2 % at 1e-3, -1.3 % at 1e-4, -0.02 % at 1e-6."""
    report = regularisation_error(SYSTEM, "displacement", [1e-2, 1e-3, 1e-4, 1e-6], initial=START)
    assert report.exact.value == pytest.approx(6.8597399, abs=1e-7)
    np.testing.assert_allclose(100.0 * report.relative_errors, [-62.3, -9.16, -1.26, -0.0191], rtol=0.005)
    assert np.all(report.noise < 1e-6)
    assert np.all(np.diff(report.steps) > 0)
    assert report.exact.steps < report.steps[0]
    assert report.smooth
    assert 0.85 < report.order < 0.95
    assert report.speed == pytest.approx(0.5088, abs=1e-3)
    for shape, width in (("tanh", 7.7e-5), ("arctan", 5.6e-6)):  # as docs/why-not-solve-ivp.md says
        found = width_for(SYSTEM, "displacement", 0.01, shape=shape, initial=START)
        assert found.width == pytest.approx(width, rel=0.02)
        assert found.error == pytest.approx(0.068597, rel=1e-4)
        beyond = regularisation_error(SYSTEM, "displacement", [1.05 * found.width], shape=shape, initial=START)
        assert abs(beyond.errors[0]) > found.error >= abs(found.run.value - report.exact.value)
    with pytest.raises(ValueError, match="a contact that cannot stick, got 'stick_fraction'"):
        regularisation_error(SYSTEM, "stick_fraction", [1e-3], initial=START, periods=2)


@pytest.mark.slow
def test_all_contacts_are_smoothed():
    """Only the first was: its error was that of a machine of which one contact still sticks."""
    system = vc.System(vc.TwoBodyCrawler(), [vc.Coulomb(0.1, 0.1), vc.Coulomb(0.1, 0.1)], vc.Harmonic(amplitude=0.6))
    alike = vc.System(vc.TwoBodyCrawler(), vc.Coulomb(0.1, 0.1), vc.Harmonic(amplitude=0.6))
    errors = [regularisation_error(each, "largest_displacement", [1e-2], periods=2) for each in (system, alike)]
    assert errors[0].errors == pytest.approx(errors[1].errors, rel=1e-12)
    assert abs(errors[0].errors[0]) > 1e-5
