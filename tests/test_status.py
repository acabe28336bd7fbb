"""Runs that cannot go on, and runs that are refused: a status or a message that says what to do, never a traceback;
and kinds of events, which have the numbers of the kernel."""

import math

import numpy as np
import pytest

import vibrocap as vc
from test_contact_modes import TOLERANCE, stick_slip
from vibrocap.numerics.api import codes
from vibrocap.physics import events
from vibrocap.physics.catalogue import laws
from vibrocap.physics.parameters import parameter_table


def test_event_limit():
    whole = vc.simulate(stick_slip(), periods=3, initial={"angle": 1.0})
    motion = vc.simulate(stick_slip(), periods=3, initial={"angle": 1.0}, max_events_per_period=2)
    assert motion.status is vc.Status.TOO_MANY_EVENTS
    assert 0.0 < motion.end < whole.end
    assert motion.events == whole.events[: len(motion.events)]
    assert motion.certificate.energy_residual <= 100 * TOLERANCE
    assert "max_events_per_period" in motion.status.text


def test_step_limit():
    whole = vc.simulate(stick_slip(), periods=3, initial={"angle": 1.0})
    motion = vc.simulate(stick_slip(), periods=3, initial={"angle": 1.0}, max_steps=10)
    assert motion.status is vc.Status.TOO_MANY_STEPS
    assert len(motion.piece_start) == 10
    assert np.array_equal(motion.coefficients, whole.coefficients[:10])
    assert "max_steps" in motion.status.text


@pytest.mark.parametrize("law", [vc.Exponential(), vc.LuGre()], ids=lambda law: law.name)
def test_runaway_ends_with_a_status(law):
    """A drive of 1e200: the very first series is not finite, and what there is of the motion can still be asked for."""
    system = vc.System(vc.PendulumCapsule(), law, vc.Harmonic(amplitude=1e200))
    motion = vc.simulate(system, periods=1, initial={"angle": 0.1})
    assert not motion.status.ok
    assert motion.status.text
    assert motion.end < motion.period
    assert motion.state["angle"] == pytest.approx(0.1)


def test_every_status_says_what_to_do():
    assert all(status.text.endswith(".") for status in vc.Status)
    assert [status for status in vc.Status if status.ok] == [vc.Status.FINISHED]


@pytest.mark.parametrize(
    ("argument", "value"),
    [
        ("periods", 0),
        ("periods", math.nan),
        ("tolerance", 0.0),
        ("tolerance", 1.0),
        ("max_steps", 1.5),
        ("max_events_per_period", True),
    ],
)
def test_run_settings_without_sense_are_refused(argument, value):
    with pytest.raises(ValueError, match=argument):
        vc.simulate(stick_slip(), **{"periods": 1, argument: value})


def test_every_law_with_both_levels_refuses_them_in_the_wrong_order():
    for law in laws().values():
        fields = {info.name for info in parameter_table(law)}
        if {"static_coefficient", "coulomb_coefficient"} <= fields:
            with pytest.raises(ValueError, match="static_coefficient"):
                law(static_coefficient=0.1, coulomb_coefficient=0.2)


def test_kinds_of_events_stand_in_the_order_of_the_kernels_numbers():
    numbers = {"stick": codes.STICK, "slip_forward": codes.SLIP_FORWARD, "slip_back": codes.SLIP_BACK}
    numbers |= {"reversal": codes.REVERSAL, "graze": codes.GRAZE, "switch": codes.SWITCHED}
    assert {kind: events.KINDS.index(kind) for kind in numbers} == numbers
    assert events.KINDS[codes.BOUND_REACHED :] == events.BOUNDS
    assert events.BOUNDS[codes.AMBIGUOUS_CONTACTS] == events.AMBIGUOUS
    assert len(events.KINDS) <= codes.MACHINE_SWITCHED
    assert set(events.KINDS) <= set(events.MEANINGS)
