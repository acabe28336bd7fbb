"""The canonical tests on laws of all kinds: what each kind of law must show, in any units, and their sheet."""

import dataclasses
import math

import numpy as np
import pytest

from thinned import exhaustive_but
from vibrocap.laboratory.contact_sizes import contact_sizes
from vibrocap.laboratory.loops import creep, frictional_lag, presliding_loop
from vibrocap.laboratory.pulled_block import break_away, stick_slip_test
from vibrocap.laboratory.test_sheet import test_sheet as canonical_sheet
from vibrocap.physics.catalogue import laws
from vibrocap.physics.friction.curves import Coulomb
from vibrocap.physics.friction.hysteresis import Dahl
from vibrocap.plotting import laboratory as laboratory_plots
from vibrocap.plotting.look.finishing import save

COULOMB = Coulomb(1.0, 1.5)
SET_VALUED = [law() for law in laws().values() if law.kind == "set-valued"]
each_set_valued = pytest.mark.parametrize("law", SET_VALUED, ids=lambda law: law.name)
DRAWN = ("coulomb", "stribeck", "dahl", "maxwell-slip", "rate-and-state-ageing")  # of each kind one
KINDS = [law() for law in laws().values()]


# --- set-valued laws -------------------------------------------------------------------------------------------------


@each_set_valued
def test_a_set_valued_law_yields_at_once_and_does_not_lag(law):
    loop = presliding_loop(law, 0.3, load=2.0)
    slow = float(law.steady_force(1e-6, 2.0))
    assert loop.area == pytest.approx(4.0 * slow * 0.3, rel=1e-4)
    assert loop.force[loop.velocity > 0.0] == pytest.approx(slow, rel=1e-4)
    assert loop.deflection is None
    lag = frictional_lag(law)
    assert np.abs(lag.width).max() <= 1e-12
    assert np.abs(lag.area).max() <= 1e-12
    sizes = contact_sizes(law, 2.0)
    assert sizes.force == pytest.approx(law.holding_limit(2.0))
    assert not sizes.elastic


def test_coulomb_breaks_away_at_its_static_level_at_any_rate():
    found = break_away(COULOMB, [0.1, 1.0, 100.0], mass=0.3)
    assert found.force == pytest.approx(1.5, rel=1e-12)
    assert found.applied == pytest.approx(1.5, rel=1e-12)
    assert found.peaked.all()
    assert found.velocity == pytest.approx(0.0, abs=1e-12)
    assert found.displacement == pytest.approx(0.0, abs=1e-12)


def test_coulomb_stick_slip_is_the_closed_form():
    """Fs 1.5, Fk 1, k 2, m 1, v 0.1 (docs/model.md)."""
    found = stick_slip_test(COULOMB, stiffness=2.0, speed=0.1)
    assert found.regime == "stick-slip"
    assert found.settled
    assert found.period == pytest.approx(7.611259254101, rel=1e-11)
    assert found.stick_time == pytest.approx(5.0, rel=1e-11)
    assert found.slip_time == pytest.approx(math.sqrt(2.0) * (math.pi - math.atan(math.sqrt(2.0) * 2.5)), rel=1e-11)
    assert found.amplitude == pytest.approx(math.sqrt(0.25**2 + 0.005), rel=1e-10)
    assert (found.static_force, found.kinetic_force) == pytest.approx((1.5, 1.0), rel=1e-9)
    assert found.largest_pull + found.least_pull == pytest.approx(2.0, rel=1e-9)  # about the kinetic level
    slower = stick_slip_test(COULOMB, stiffness=2.0, speed=0.05)
    assert slower.stick_time == pytest.approx(10.0, rel=1e-11)


def test_one_level_swings_without_sticking():
    """Fs = Fk: the block that is let go swings about the kinetic level with v/omega for ever."""
    found = stick_slip_test(Coulomb(1.0, 1.0), stiffness=2.0, speed=0.1)
    assert found.regime == "oscillation"
    assert found.period == pytest.approx(math.pi * math.sqrt(2.0), rel=1e-9)
    assert found.amplitude == pytest.approx(0.1 / math.sqrt(2.0), rel=1e-9)


def test_a_test_that_is_too_short_says_so():
    found = stick_slip_test(COULOMB, stiffness=2.0, speed=0.1, cycles=1)
    assert found.regime == "undecided"
    assert not found.settled
    assert math.isnan(found.period)


def test_coulomb_does_not_creep():
    found = creep(COULOMB, cycles=50)
    assert not found.creeps
    assert np.all(found.displacement == 0.0)


# --- any units, any law ----------------------------------------------------------------------------------------------


def test_dahl_has_no_maximum_and_no_lag():
    law = Dahl()
    assert np.abs(frictional_lag(law).width).max() <= 1e-9
    loop = presliding_loop(law, 3.0 * 0.0015, cycles=4)  # LuGre at a constant g is Dahl's law with i = 1
    g = 0.0015
    assert loop.area == pytest.approx(4.0 * 0.15 * (3.0 * g - g * math.tanh(3.0)), rel=1e-8)


@pytest.mark.parametrize(
    ("call", "field"),
    [
        (lambda: presliding_loop(COULOMB, -0.1), "amplitude should be a positive number, got -0.1"),
        (lambda: presliding_loop(COULOMB, load=0.0), "load should be a positive number, got 0.0"),
        (lambda: presliding_loop(COULOMB, cycles=0), "cycles should be a whole number >= 1, got 0"),
        (lambda: creep(COULOMB, amplitude=math.nan), "amplitude should be a positive number, got nan"),
        (lambda: creep(COULOMB, cycles=2.5), "cycles should be a whole number >= 1, got 2.5"),
        (lambda: frictional_lag(COULOMB, mean="fast"), "mean should be a positive number, got 'fast'"),
        (lambda: frictional_lag(COULOMB, frequencies=[1.0, -1.0]), "frequencies should be a list of positive numbers"),
        (lambda: break_away(COULOMB, []), "rates should be a list of positive numbers"),
        (lambda: break_away(COULOMB, mass=0), "mass should be a positive number, got 0"),
        (lambda: stick_slip_test(COULOMB, stiffness=0.0), "stiffness should be a positive number, got 0.0"),
        (lambda: stick_slip_test(COULOMB, speed=math.inf), "speed should be a positive number, got inf"),
        (lambda: canonical_sheet(COULOMB, mass=-1.0), "mass should be a positive number, got -1.0"),
    ],
)  # fmt: skip
def test_wrong_arguments_are_refused_by_name(call, field):
    with pytest.raises(ValueError, match="^" + field.replace("(", r"\(")):
        call()


# --- the sheet -------------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def sheet():
    asked = []
    found = canonical_sheet(COULOMB, stiffness=2.0, speed=0.1, mass=1.0, progress=asked.append)
    assert asked == ["presliding", "lag", "break away", "stick slip", "creep"]
    return found


def test_the_sheet_is_its_tests(sheet):
    assert sheet.stick_slip.period == stick_slip_test(COULOMB).period
    assert [loop.peak_force for loop in sheet.presliding] == [1.0] * 4
    assert sheet.break_away.force == pytest.approx(1.5)
    assert dataclasses.replace(sheet, mass=2.0).mass == 2.0


@pytest.mark.slow
@pytest.mark.parametrize(
    "law",
    exhaustive_but([i for i, law in enumerate(KINDS) if law.name in ("coulomb", "lugre")], KINDS),
    ids=lambda law: law.name,
)
def test_every_law_has_a_sheet(law, tmp_path):
    """All tests run to their end with numbers; the law creeps if and only if it says so; levels are in order."""
    found = canonical_sheet(law)
    assert found.creep.creeps == law.creeps
    assert np.isfinite(found.break_away.force).all()
    assert found.break_away.force[0] <= 1.001 * found.sizes.force
    assert np.isfinite(found.lag.force).all()
    areas = [loop.area for loop in found.presliding]
    assert np.all(np.diff(areas) > 0.0)
    stick_slip = found.stick_slip
    assert stick_slip.regime in ("stick-slip", "oscillation", "steady")
    if stick_slip.sticks:
        assert stick_slip.kinetic_force < stick_slip.static_force
        assert stick_slip.stick_time + stick_slip.slip_time == pytest.approx(stick_slip.period)
    if law.name in DRAWN:
        assert save(laboratory_plots.sheet_figure(found), tmp_path / "sheet.png").stat().st_size > 20_000
    assert save(laboratory_plots.law_figure(law), tmp_path / "card.png").stat().st_size > 10_000
