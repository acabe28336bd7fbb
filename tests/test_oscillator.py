"""The oscillator: closed forms of dry friction's oldest machine (docs/model.md); it does not travel."""

import math

import numpy as np
import pytest

import vibrocap as vc
from thinned import exhaustive_but
from vibrocap.physics.friction.curves import Coulomb
from vibrocap.physics.machines.oscillators import Oscillator

TOLERANCE = 1e-11
STICK, SLIP = 5.0, 2.6112592541013093  # 2 D/v and (2/w)(pi - atan(w D/v)) of the belt below


def at_rest(period):
    """No drive, and a period of one's choice, in the form that all tests here share."""
    return vc.Loading(level=0.0, rate=0.0, amplitude=0.0, frequency=2.0 * math.pi / period)


def belt(period=STICK + SLIP, speed=-0.1, **machine):
    """Fs 1.5, Fk 1, k 2, m 1, v 0.1: a block pulled from rest."""
    return vc.System(Oscillator(stiffness=2.0, belt_speed=speed, **machine), Coulomb(1.0, 1.5), at_rest(period))


@pytest.fixture(scope="module")
def pulled():
    return vc.simulate(belt(), periods=20, tolerance=TOLERANCE)


# --- closed forms ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("r", "beta"), [(0.8, 0.5), (0.9, 0.5), (1.5, 0.3), (1.5, 0.6), (2.0, 0.2)])
def test_den_hartog(r, beta):
    """x'' + x + beta sgn x' = cos(r tau): amplitude sqrt(V^2 - beta^2 U^2) while it never stops."""
    v, u = 1.0 / (1.0 - r * r), math.sin(math.pi / r) / (r * (1.0 + math.cos(math.pi / r)))
    t = np.linspace(0.0, math.pi, 100_001)[1:-1]
    s = np.max((r * np.sin(t / r) + u * r * r * (np.cos(t) - np.cos(t / r))) / np.sin(t))
    assert beta <= math.sqrt(v * v / (u * u + (s / r**2) ** 2))
    system = vc.System(Oscillator(), Coulomb(beta, beta), vc.Loading(0.0, 0.0, 1.0, r))
    motion = vc.simulate(system, periods=400, tolerance=TOLERANCE)
    last = motion.events[-4:]
    assert all(event.kind == "reversal" for event in last)
    amplitudes = [abs(event.state["position"]) for event in last]
    assert amplitudes == pytest.approx([math.sqrt(v * v - (beta * u) ** 2)] * 4, rel=1e-12)
    if (r, beta) == (0.8, 0.5):
        assert amplitudes[0] == pytest.approx(2.332235, abs=5e-7)
    found = vc.response_class(motion)
    assert (found.kind, found.symmetric) == ("period-1", True)


def test_belt_with_static_and_kinetic_friction(pulled):
    """Stick time 2D/v, slip time (2/w)(pi - atan(w D/v)), amplitude sqrt(D^2 + v^2/w^2)."""
    slips = [event.time for event in pulled.events if event.kind == "slip_forward"]
    sticks = [event.time for event in pulled.events if event.kind == "stick"]
    assert np.diff(slips) == pytest.approx(7.611259254101, abs=5e-12)
    count = min(len(slips) - 1, len(sticks))
    assert count > 10
    assert np.array(slips[1 : count + 1]) - sticks[:count] == pytest.approx(STICK, abs=5e-12)
    assert np.array(sticks[:count]) - slips[:count] == pytest.approx(SLIP, abs=5e-12)
    t = np.linspace(slips[-2], slips[-1], 20_001)
    stretch = pulled.at(t, "position")
    assert 0.5 * np.ptp(stretch) == pytest.approx(math.sqrt(0.25**2 + 0.1**2 / 2.0), rel=1e-7)  # of the grid
    certificate = pulled.certificate
    assert certificate.stick_force_ratio == pytest.approx(1.0, abs=1e-12)
    assert certificate.energy_residual <= 100 * TOLERANCE
    assert certificate.momentum_residual <= 100 * TOLERANCE


def test_work_and_settling_of_the_belt_cycle(pulled):
    """In a cycle the belt puts in Fk v T, and sliding takes it; the motion settles, in all its states."""
    balance = vc.energy_balance(pulled, periods=1)
    assert balance.belt == pytest.approx(0.1 * (STICK + SLIP), rel=1e-12)
    assert balance.contact_sliding == pytest.approx(-0.1 * (STICK + SLIP), rel=1e-12)
    assert balance.drive == balance.damper == 0.0
    assert abs(balance.stored) <= 1e-12
    assert vc.settling(pulled).period == 1
    assert vc.response_class(pulled).symmetric is None  # a running belt has a direction
    assert vc.mode_sequence(pulled) in ("SF", "FS", "SFS", "FSF")
    assert vc.stick_fraction(pulled, periods=1) == pytest.approx(STICK / (STICK + SLIP), rel=1e-12)


# --- the machine -----------------------------------------------------------------------------------------------------


def test_the_belt_that_runs_back_is_the_mirror_image(pulled):
    other = vc.simulate(belt(speed=0.1), periods=20, tolerance=TOLERANCE)
    assert np.array_equal(other.sections, -pulled.sections)
    assert np.array_equal(other.event_times, pulled.event_times)


def test_any_units_serve():
    """The same motion in units of mm, 10 ms and t: as many steps, and the same numbers to rounding."""
    length, time, mass = 1e3, 1e2, 1e-3
    force = mass * length / time**2
    drive = vc.Loading(level=0.3, rate=0.02, amplitude=1.4, frequency=0.7)
    one = vc.System(Oscillator(1.3, 2.0, 0.2, 0.15, 1.1), Coulomb(0.5, 0.8), drive)
    two = vc.System(
        Oscillator(1.3 * mass, 2.0 * force / length, 0.2 * mass / time, 0.15 * length / time, 1.1 * force),
        Coulomb(0.5, 0.8),
        vc.Loading(0.3 * force, 0.02 * force / time, 1.4 * force, 0.7 / time),
    )
    first, second = (vc.simulate(system, periods=10, tolerance=TOLERANCE) for system in (one, two))
    assert len(first.events) > 20
    assert second.sections == pytest.approx(first.sections * (length, length / time), rel=1e-10)
    assert second.event_times == pytest.approx(first.event_times * time, rel=1e-11)
    assert abs(len(second.piece_start) - len(first.piece_start)) <= 0.02 * len(first.piece_start)
    # Its energy and momentum are accounted for, with all forces and channels at work.
    assert first.certificate.energy_residual <= 1e-11
    assert first.certificate.momentum_residual <= 1e-11
    assert vc.energy_balance(first).belt != 0.0 != vc.energy_balance(first).damper


def test_scales_follow_from_the_parameters():
    """What a force of the size of the load does: statically with a soft drive, by inertia with a quick one."""
    assert Oscillator(4.0, 9.0, normal_load=3.0).scales(1e6) == pytest.approx((1.0 / 3.0, 0.5), rel=1e-6)
    place, speed = Oscillator(4.0, 0.0, normal_load=3.0).scales(2.0)
    assert place == pytest.approx(3.0 / (4.0 * math.pi**2))
    assert speed == pytest.approx(math.pi * place)


def test_pulled_is_a_belt_that_runs_back():
    assert Oscillator.pulled(0.1, stiffness=2.0) == Oscillator(stiffness=2.0, belt_speed=-0.1)


# --- drives ----------------------------------------------------------------------------------------------------------


def test_drives_of_a_test_rig():
    ramp = vc.Ramp(rate=0.3, start=0.1, duration=5.0)
    assert (ramp.value(0.0), ramp.value(2.0), ramp.period) == (0.1, 0.1 + 0.6, 5.0)
    assert vc.Constant(force=-0.2, duration=3.0).value(1.7) == -0.2
    loading = vc.Loading(level=0.1, rate=0.3, amplitude=0.5, frequency=2.0)
    assert loading.value(0.7) == pytest.approx(0.1 + 0.21 + 0.5 * math.cos(1.4))
    assert loading.period == pytest.approx(math.pi)
    assert [vc.Ramp().odd, vc.Constant().odd, vc.Constant(1.0).odd, loading.odd] == [False, True, False, False]
    assert vc.Loading(level=0.0).odd


# --- no travel -------------------------------------------------------------------------------------------------------


def test_travel_of_a_machine_in_its_place_is_refused(pulled):
    for measure in (vc.displacement, vc.drift, vc.mean_velocity):
        with pytest.raises(ValueError, match="oscillator does not travel: it has no drift"):
            measure(pulled)
    for name in ("mean_velocity", "drift", "displacement", "cost_of_transport"):
        with pytest.raises(ValueError, match=r"measures: .*oscillator does not travel"):
            vc.measured(pulled, name)
        with pytest.raises(ValueError, match=r"measures: .*oscillator does not travel"):
            vc.ensemble(belt(), {"machine.stiffness": [1.0, 2.0]}, measures=[name])


@pytest.mark.plain
def test_a_mass_without_a_spring_travels():
    """Nothing depends on its place."""
    drive = vc.Biharmonic(1.2, 1.0, 0.5)
    system = vc.System(vc.Oscillator(stiffness=0.0), vc.Coulomb(0.1, 0.2), drive)
    assert (system.cyclic, vc.System(vc.Oscillator(), vc.Coulomb(), drive).cyclic) == ("position", None)
    assert vc.System(vc.OscillatorWithStops(stiffness=0.0), vc.Coulomb(), drive).cyclic is None  # its stops hold it
    motion = vc.simulate(system, periods=2)
    assert vc.drift(motion) == pytest.approx(motion.sections[2, 0] - motion.sections[1, 0], rel=1e-12)


# --- others' reference values ----------------------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize(
    ("static", "frequency"), exhaustive_but([1], [(1.1, 0.748685731630635), (1.0, 0.722679194438216)])
)
def test_where_a_driven_block_begins_to_stick(static, frequency):
    """x'' + 0.1 x' + x = 1.5 cos(omega t) - friction: the orbit that never sticks ends at that frequency."""
    machine = Oscillator(stiffness=1.0, damping=0.1, belt_speed=0.0)
    system = vc.System(machine, Coulomb(1.0, static), vc.Harmonic(amplitude=1.5))
    branch = vc.branch(system, "drive.frequency", (0.7, 0.85), initial={"position": 2.0})
    (place,) = branch.special_points
    assert place.kind.value == "change of mode sequence"
    assert place.parameter == pytest.approx(frequency, abs=1e-9)
    if static == 1.0:
        free = system.with_parameters({"drive.frequency": frequency + 1e-9})
        motion = vc.orbit(free, initial={"position": 2.0}).motion()
        assert [event.kind for event in motion.events] == ["reversal"] * 2
        turns = [abs(event.state["position"]) for event in motion.events]
        assert turns == pytest.approx([2.012072952806] * 2, abs=1e-8)  # 1e-9 away, with a slope of about 1
