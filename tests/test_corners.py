"""Drives with corners and jumps: no step crosses one, and what holds on either side is what the equations say there."""

import math

import numpy as np
import pytest

import vibrocap as vc
from independent import motion as independent_motion
from thinned import exhaustive_but, slow_but
from vibrocap.physics.drives.drive import segment_table

EPSILON = float(np.finfo(float).eps)
START = {"angle": 1.0, "angle_rate": -0.3, "velocity": 0.1}
DRIVES = [
    vc.Square(amplitude=1.5, duty=0.4),
    vc.Triangle(amplitude=2.0, rise=0.3),
    vc.Trapezoid(amplitude=1.6),
    vc.PulseWidth(amplitude=2.5),
    vc.OnOff(amplitude=2.4, offset=-0.9, duty=0.45, phase=0.7),
    vc.Phases(level_3=0.8, duration_3=1.5, duration_5=0.7, level_5=1.2),
    vc.ThreePhase(stroke=2.0),
    vc.SevenPhase(stroke=2.0, back_cruise=0.0),
    vc.DriveTable(amplitude=1.5, stretch=1.4),
    vc.DriveTable((0.0, 1.0, 2.5, 4.0), (0.0, 2.0, -1.0, 0.0), interpolation="linear"),
]
SQUARE = [each.name for each in DRIVES].index("square")
each_drive = pytest.mark.parametrize(  # each of the others is compiled anew
    "drive",
    slow_but([SQUARE], exhaustive_but({SQUARE, *range(0, len(DRIVES), 3)}, DRIVES)),
    ids=lambda drive: drive.name,
)


def system_of(drive=None):
    return vc.System(vc.PendulumCapsule(), vc.Exponential(), drive or vc.Square(amplitude=1.5, duty=0.4))


# --- an independent solver that stops at the corners ------------------------------------------------------------------


def test_square_wave_against_an_event_solver():
    """State and event times to 1e-9, with the contact sticking, slipping and turning."""
    system = system_of()
    motion = vc.simulate(system, periods=2, initial=START, tolerance=1e-11)
    expected = independent_motion(system, START, 2)
    assert motion.status.ok
    assert motion.state == pytest.approx(expected.state, abs=1e-9)
    assert [event.kind for event in motion.events] == [kind for _, kind in expected.events]
    assert [event.time for event in motion.events] == pytest.approx([time for time, _ in expected.events], abs=1e-9)
    assert len(expected.events) >= 5


# --- corners are the borders of steps ---------------------------------------------------------------------------------


def corner_times(drive, periods):
    """Every corner of a motion that begins with a period of the drive."""
    shares = [row[0] for row in segment_table(drive)[:-1]] + [1.0]
    return np.array([(number + share) * drive.period for number in range(periods) for share in shares])


@each_drive
def test_no_step_crosses_a_corner(drive):
    """Every corner is a border of two pieces to rounding, and the certificate of the motion finds no fault."""
    motion = vc.simulate(system_of(drive=drive), periods=3, initial=START)
    assert motion.status.ok, motion.certificate.failures
    assert motion.certificate.ok
    ends = motion.piece_start + motion.piece_length
    nearest = np.min(np.abs(corner_times(drive, 3)[:, None] - ends), axis=1)
    assert np.max(nearest) <= 8 * EPSILON * motion.end
    assert np.all(motion.piece_length > 4 * EPSILON * motion.end)  # none without length


def test_the_drive_is_known_from_both_sides_of_a_jump():
    """At the end of a piece it is that of the piece, and afterwards the other level; so are powers and forces."""
    drive = vc.Square(amplitude=1.5, duty=0.4)
    motion = vc.simulate(system_of(drive=drive), periods=2, initial=START)
    corner = 0.4 * drive.period
    before = int(motion.piece_at(np.array([corner - 1e-9]))[0])
    ends = motion.piece_observables(("drive",), np.array([before, before + 1]), motion.piece_length[[before, before]])
    assert ends[0, 0] == 1.5
    assert motion.at([0.0, corner - 1e-9, corner, drive.period], "drive") == pytest.approx([1.5, 1.5, -1.5, 1.5])
    last = motion.piece_observables(("drive",), np.array([len(motion.piece_start) - 1]), motion.piece_length[-1:])
    assert last[0, 0] == -1.5  # at the very end of the motion, which is the end of a period


def test_a_stuck_contact_breaks_loose_at_a_jump():
    """At rest under a small force; where the force jumps beyond the limit, it slides at that instant, that way."""
    for level, kind in ((3.0, "slip_forward"), (-3.0, "slip_back")):
        drive = vc.Phases(level_1=0.05, duration_1=1.0, level_2=level, duration_2=1.0)
        motion = vc.simulate(system_of(drive=drive), periods=1)
        first = motion.events[0]
        assert (first.time, first.kind) == (1.0, kind)
        assert all(first.state[name] == motion.at([1.0], name)[0] for name in motion.state_names)
        assert motion.phases[0].side == 0
        assert motion.phases[1].start == 1.0


@pytest.mark.parametrize("kind", ["slip_back", "reversal", "stick"])
def test_an_event_at_the_very_instant_of_a_corner(kind):
    """The corner is put where an event was, and some last digits beside: the motions stay neighbours."""

    def system(corner):
        levels = {"level_1": 2.0, "level_2": -2.0, "level_3": 2.0}
        durations = {"duration_1": 3.0, "duration_2": corner - 3.0, "duration_3": 12.0 - corner}
        return system_of(drive=vc.Phases(**levels, **durations))

    run = vc.simulate(system(9.0), periods=0.7, initial=START)
    instant = next(event.time for event in run.events if event.kind == kind and event.time > 3.1)
    ends = []
    for beside in (0, 1, -1, 2, -2, 5, -5, 40, -40, 10**4, -(10**4)):
        motion = vc.simulate(system(instant + beside * math.ulp(instant)), periods=0.9, initial=START)
        assert motion.status.ok
        assert motion.certificate.ok, motion.certificate.failures
        ends.append(list(motion.state.values()))
    assert np.max(np.abs(np.array(ends) - ends[0])) <= 1e-8


# --- starts, lanes, tangents ------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("drive", "field", "value"), [(vc.SevenPhase, "back_stop", 5e-324), (vc.Trapezoid, "rise", 1e-300)]
)
def test_a_piece_that_is_no_longer_than_rounding_is_refused(drive, field, value):
    with pytest.raises(ValueError, match=rf"{field}: should be more than .* of the period"):
        drive(**{field: value})
    assert drive(**{field: 1e-6}).continuous


def test_one_table_serves_all_runs_whose_corners_are_alike():
    from vibrocap.motion.recording.equations import equations, parameter_values

    corners = equations(system_of()).corners
    rows = np.tile(parameter_values(system_of()), (5, 1))
    rows[:, 0] = np.linspace(1.0, 2.0, 5)  # the mass ratio
    assert len(corners.tables(rows)) == 1
    rows[:, equations(system_of()).parameter_paths.index("drive.duty")] = np.linspace(0.2, 0.6, 5)
    assert len(corners.tables(rows)) == 5


# --- worms, whose distances change at another rate from one instant on ------------------------------------------------


@pytest.mark.slow  # its kernel
def test_what_a_contact_at_rest_holds_is_asked_once_the_others_have_turned():
    """Body 1 does not move at the corner; with bodies 2 and 3 on their old sides it could not hold what they push.

    Before it, R_2 + R_3 = 0.4 (1.2 - 1), with forces of the bristles alone; after it, at ten times the speed, bristles
    as they were and their damping: 0.08 + 3 d_2 v - 3 d_3 v, which is 0, but 0.08 - d_2 v + d_3 v = 0.107 on their old
    sides. Body 1 holds 0.1.
    """
    period, rise, slow = 2.0 * math.pi, 0.95, 0.05
    settings = {
        "bristle_stiffness": 50.0,
        "coulomb_coefficient": 0.2,
        "static_coefficient": 0.4,
        "stribeck_velocity": 0.3,
    }
    system = vc.System(
        vc.ThreeBodyWorm(actuation=1.0, actuation_2=-2.0, normal_load_3=1.2),
        [
            vc.Coulomb(0.1, 0.1),
            vc.LuGre(bristle_damping=0.1, **settings),
            vc.LuGre(bristle_damping=0.1 + 0.08 / (3.0 * slow * rise / (1.0 - rise)), **settings),
        ],
        vc.Triangle(amplitude=-0.5 * slow * rise * period, rise=rise),
    )
    motion = vc.simulate(system, periods=1.2)
    assert motion.certificate.ok
    assert [(event.kind, event.time) for event in motion.events] == [
        ("reversal_2", pytest.approx(rise * period)),
        ("reversal_3", pytest.approx(rise * period)),
        ("reversal_2", pytest.approx(period)),
        ("reversal_3", pytest.approx(period)),
    ]
    assert motion.state["position"] == 0.0


@pytest.mark.slow  # its kernel
def test_contacts_that_turn_together_are_all_told():
    """While the distance dwells both bodies move alike, and turn at one instant."""
    system = vc.System(
        vc.TwoBodyWorm(mass_2=0.5),
        vc.LuGre(coulomb_coefficient=0.1, static_coefficient=0.2),
        vc.Trapezoid(amplitude=0.3, rise=0.2, hold=0.4, fall=0.2),
    )
    motion = vc.simulate(system, periods=1)
    dwell = [(event.time, event.kind) for event in motion.events if 0.2 < event.time / motion.period % 1.0 < 0.6]
    times = [[time for time, kind in dwell if kind == wanted] for wanted in ("reversal", "reversal_2")]
    assert len(times[0]) > 2
    assert times[0] == pytest.approx(times[1], abs=1e-14)
