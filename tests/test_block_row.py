"""Rows of blocks on a belt: values of the literature, SciPy with events, and what a row is made of."""

import itertools

import pytest

import vibrocap as vc
from vibrocap.arguments import ArgumentError
from vibrocap.physics.catalogue import machines

pytestmark = pytest.mark.plain

STILL = vc.Constant(force=0.0, duration=10.0)


def test_a_row_without_joints_is_as_many_oscillators():
    """To rounding, with sticks and slips of their own; here the contacts know nothing of one another."""
    row = vc.TwoBlockRow(coupling_stiffness=0.0, belt_speed=0.1, stiffness=2.0, mass_2=0.5, damping_2=0.1)
    drive, law = vc.Harmonic(amplitude=0.7, frequency=0.9), vc.Coulomb(0.3, 0.45)
    both = vc.simulate(vc.System(row, law, drive), periods=6, tolerance=1e-12)
    for number, given in ((1, {"stiffness": 2.0}), (2, {"mass": 0.5, "damping": 0.1})):
        alone = vc.simulate(vc.System(vc.Oscillator(belt_speed=0.1, **given), law, drive), periods=6, tolerance=1e-12)
        ending = "" if number == 1 else "_2"
        for name, value in alone.state.items():
            assert both.state[name + ending] == pytest.approx(value, abs=1e-9)
        assert any(event.kind.startswith("stick") for event in alone.events)


@pytest.mark.parametrize("belt", [0.0, 0.2])
def test_drag_acts_on_every_block_at_its_velocity_over_the_ground(belt):
    """So it is a damper from each block to the ground."""
    drive, law = vc.Harmonic(amplitude=0.3, frequency=0.9), vc.Coulomb(0.2, 0.3)
    dragged = vc.System(vc.TwoBlockRow(belt_speed=belt), law, drive, environment=vc.Environment(linear_drag=0.3))
    damped = vc.System(vc.TwoBlockRow(belt_speed=belt, damping=0.3, damping_2=0.3), law, drive)
    start, motions = {"position_2": 0.7}, []
    for system in (dragged, damped):
        motions.append(vc.simulate(system, initial=start, periods=5, tolerance=1e-12))
        assert motions[-1].certificate.ok
        assert {"stick_2", "slip_back_2"} <= set(motions[-1].event_kinds)
    assert list(motions[0].state.values()) == pytest.approx(list(motions[1].state.values()), abs=1e-9)


@pytest.mark.parametrize("velocity", [0.0, 0.4])
def test_the_modes_of_all_blocks_know_their_drag_over_the_ground(velocity):
    """As of dampers to the ground, whether block 2 rests or slides."""
    drive, law, state = vc.Constant(0.1), vc.Coulomb(0.2, 0.3), {"sliding_velocity_2": velocity}
    dragged = vc.System(vc.TwoBlockRow(belt_speed=0.2), law, drive, environment=vc.Environment(linear_drag=0.3))
    damped = vc.System(vc.TwoBlockRow(belt_speed=0.2, damping=0.3, damping_2=0.3), law, drive)
    (found,), (expected,) = (vc.contact_modes(system, state) for system in (dragged, damped))
    assert found.sides == expected.sides == (0, 1 if velocity else 0)
    for name in ("friction", "accelerations"):
        assert getattr(found, name) == pytest.approx(getattr(expected, name), abs=1e-14)


def test_rows_have_names_and_refuse_what_is_none():
    row = vc.block_row(5)
    assert machines()["five-block-row"] is row
    assert list(itertools.islice(row.contact_states, 2)) == ["sliding_velocity", "sliding_velocity_2"]
    assert "five-block-crawler" not in machines()
    with pytest.raises(ValueError, match="bodies should be a whole number from 2 to 20, got 21"):
        vc.block_row(21)
    with pytest.raises(ValueError, match="normal_load: should be > 0 of one block at least, got 0 for all 2"):
        vc.TwoBlockRow(normal_load=0.0, normal_load_2=0.0)
    assert vc.TwoBlockRow(normal_load=0.0).normal_load_2 == 1.0
    with pytest.raises(ArgumentError, match=r"machine\.normal_load_2 should be > 0 with the lugre law, got 0"):
        vc.System(vc.TwoBlockRow(normal_load_2=0.0), vc.LuGre(), STILL)
