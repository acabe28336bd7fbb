"""Drives given by tables and in pieces: what they are between their points, their symmetry, and what is refused."""

import itertools
import math
import textwrap

import numpy as np
import pytest

import vibrocap as vc
from cases import DEFAULTS
from vibrocap.arguments import ArgumentError
from vibrocap.case.case import CaseError, case_from_text, case_text, read_case
from vibrocap.physics.drives.drive import segment_table
from vibrocap.physics.parameters import ParameterError

TIMES, VALUES = (0.0, 0.3, 1.0, 1.6, 2.5), (0.2, 1.5, -0.4, 0.9, 0.2)


def test_a_cubic_goes_through_its_points_with_the_slopes_of_parabolas():
    """Value and slope agree from both sides of every point, the slope is that of the parabola through three points."""
    drive = vc.DriveTable(TIMES, VALUES, amplitude=2.0, stretch=3.0)
    for i, (time, value) in enumerate(zip(TIMES[:-1], VALUES[:-1], strict=True)):
        t = 3.0 * time
        assert drive.value(t) == pytest.approx(2.0 * value)
        assert drive.value(t - 1e-9) == pytest.approx(2.0 * value, abs=1e-7)
        assert drive.slope(t - 1e-9) == pytest.approx(drive.slope(t), abs=1e-6)
        around = [TIMES[i - 1] if i else TIMES[-2] - 2.5, time, TIMES[i + 1]]
        parabola = np.polyfit(around, [VALUES[i - 1] if i else VALUES[-2], value, VALUES[i + 1]], 2)
        assert drive.slope(t) == pytest.approx(2.0 / 3.0 * np.polyval(np.polyder(parabola), time), rel=1e-9)
    assert drive.period == 7.5
    assert drive.continuous


def test_lines_between_points():
    drive = vc.DriveTable(TIMES, VALUES, "linear")
    for t in (0.1, 0.65, 1.2, 2.0):
        assert drive.value(t) == pytest.approx(np.interp(t, TIMES, VALUES), abs=1e-15)


def test_pulses_follow_their_sine():
    """The mean over a cell is m h sin at its middle, to rounding."""
    drive = vc.PulseWidth(amplitude=2.0, modulation=0.7, pulses=8, frequency=1.3)
    start, area = 0.0, np.zeros(8)
    for end, level in segment_table(drive):
        marks = np.unique(np.clip([start, *np.linspace(0.0, 1.0, 9), end], start, end))
        for low, high in itertools.pairwise(marks):
            area[min(7, int(8 * 0.5 * (low + high)))] += 2.0 * level * (high - low)
        start = end
    expected = 0.7 * 2.0 * np.sin(2.0 * math.pi * (np.arange(8) + 0.5) / 8) / 8
    assert area == pytest.approx(expected, abs=1e-15)


@pytest.mark.parametrize(
    ("drive", "odd"),
    [
        (vc.Square(), True),
        (vc.Square(duty=0.5 + 1e-12), False),
        (vc.Square(amplitude=0.0, duty=0.3), True),
        (vc.Biharmonic(), True),
        (vc.Biharmonic(second_amplitude=1e-3), False),
        (vc.Triangle(), True),
        (vc.Triangle(rise=0.500001), False),
        (vc.Trapezoid(rise=0.1, hold=0.4, fall=0.1), True),
        (vc.Trapezoid(rise=0.1, hold=0.39, fall=0.1), False),
        (vc.OnOff(amplitude=2.0, offset=-1.0, duty=0.5, phase=0.8), True),
        (vc.OnOff(amplitude=2.0, offset=-1.0, duty=0.5000001), False),
        (vc.OnOff(amplitude=2.0, offset=-0.9, duty=0.5), False),
        (vc.OnOff(), False),
        (vc.PulseWidth(pulses=6), True),
        (vc.PulseWidth(pulses=5), False),
        (vc.Phases(1.0, 0.7, -2.0, 0.3, -1.0, 0.7, 2.0, 0.3), True),
        (vc.Phases(1.0, 0.7, -2.0, 0.3, -1.0, 0.7, 2.0, 0.4), False),
        (vc.Phases(1.0, 0.7, -2.0, 0.3, -1.0, 0.7, 2.0 + 1e-12, 0.3), False),
        (vc.DriveTable(), True),
        (vc.DriveTable((0.1, 0.3, 0.6, 0.8, 1.1), (0.0, 1.0, 0.0, -1.0, 0.0)), True),
        (vc.DriveTable((0.1, 0.3, 0.6, 0.8, 1.1), (0.0, 1.0, 0.0, -1.0 - 1e-12, 0.0)), False),
        (vc.ThreePhase(), False),
    ],
)
def test_oddness_is_read_off_the_segments(drive, odd):
    """To rounding: a twelfth digit that differs is a difference, one that addition leaves behind is not."""
    assert drive.odd is odd


@pytest.mark.parametrize(
    ("times", "values", "complaint"),
    [
        ((0, 1, 1, 2), (0, 1, 2, 0), r"times: should increase: number 3 is not after"),
        ((0, 2, 1, 3), (0, 1, 2, 0), r"times: should increase: number 3 is not after"),
        ((0, 1, 1.5, 2), (0, 1, 2, 0.5), "values: should end as they begin"),
        ((0, 1, 2, 3), (0, 1, 0), "values: should be one for each of the 4 times, got 3"),
        ((0, 1), (0, 0), "times: should be at least 4 instants, got 2"),
        ((0, math.nan, 2, 3), (0, 1, 2, 0), "times: should be finite numbers; number 2 is nan"),
        ((0, 1, 2, 3), (0, "x", 2, 0), "values: should be finite numbers; number 2 is 'x'"),
        (3.0, (0, 1), "times: should be a list of numbers"),
    ],
)
def test_tables_that_are_refused(times, values, complaint):
    with pytest.raises(ParameterError, match=complaint):
        vc.DriveTable(times=times, values=values)


def test_other_pieces_that_are_refused():
    with pytest.raises(ParameterError, match="hold: should leave rise"):
        vc.Trapezoid(rise=0.4, hold=0.4, fall=0.4)
    with pytest.raises(ParameterError, match="duration_1: should be greater than 0, or another"):
        vc.Phases(duration_1=0.0, duration_2=0.0)
    with pytest.raises(ParameterError, match="pulses: should be a whole number from 2"):
        vc.PulseWidth(pulses=2.5)
    assert vc.PulseWidth(pulses=4.0).pulses == 4
    for wrong in ({"duty": 0.0}, {"duty": 1.0}, {"phase": 1.0}, {"phase": -0.1}):
        with pytest.raises(ParameterError, match=f"{next(iter(wrong))}: should be"):
            vc.OnOff(**wrong)


@pytest.mark.parametrize("phase", [0.0, 0.2, 0.65, 0.7, 0.9, 0.999999])
@pytest.mark.parametrize("duty", [0.1, 0.35, 0.8])
def test_a_switch_is_on_for_its_share_from_its_phase_on(duty, phase):
    """h_0 + h where the share of the period since the phase is below the duty, whether or not that is over its end."""
    drive = vc.OnOff(amplitude=1.7, offset=-0.4, frequency=2.3, duty=duty, phase=phase)
    lengths = [segment.length for segment in drive.segments()]
    assert min(lengths) >= 0.0
    assert sum(lengths) == pytest.approx(1.0, abs=4e-16)
    for share in np.linspace(0.003, 2.997, 41):
        on = (share - phase) % 1.0 < duty
        assert drive.value(share * drive.period) == (-0.4 + 1.7 if on else -0.4)


CASE = DEFAULTS.replace('"harmonic"', '"table"\nfile = "current.csv"')
COLUMNS = "time, force\n# as measured\n0, 0.2\n0.3; 1.5\n\n1.0 -0.4\n1.6,0.9\n2.5,0.2\n"


def written(folder, case=CASE, columns=COLUMNS):
    (folder / "current.csv").write_text(columns)
    (folder / "case.toml").write_text(textwrap.dedent(case))
    return folder / "case.toml"


def test_a_table_from_a_file_is_the_numbers_of_the_file(tmp_path):
    """In a case, beside which the file stands, and in Python; the text of the case then holds them."""
    case = read_case(written(tmp_path))
    assert case.system.drive == vc.DriveTable(TIMES, VALUES)
    assert case_from_text(case_text(case)) == case
    read = vc.read_drive_table(tmp_path / "current.csv", interpolation="linear")
    assert read == vc.DriveTable(TIMES, VALUES, "linear")


@pytest.mark.parametrize("kind", [list, tuple, np.array])
def test_a_table_in_si_may_be_a_list_or_an_array(kind):
    """Whatever holds the numbers, they are divided by the unit of time, sqrt(l/g), and by that of torque, m g l."""
    sizes = {"pendulum_mass_kg": 0.1, "pendulum_length_m": 0.1, "capsule_mass_kg": 0.25, "normal_load": "weight"}
    machine = vc.PendulumCapsule.in_si(**sizes, stiffness_N_m_per_rad=0.2, damping_N_m_s_per_rad=0.01)
    times, values = [0.0, 1.0, 2.0, 3.0, 4.0], [0.0, 1.0, 0.0, -1.0, 0.0]
    numbers = {"times_s": kind(times), "values_N_m": kind(values), "amplitude": 1.0, "stretch": 1.0}
    drive = vc.System(machine, vc.Coulomb(), vc.DriveTable.in_si(**numbers)).drive
    np.testing.assert_allclose(drive.times, np.array(times) / math.sqrt(0.1 / 9.80665), rtol=1e-15)
    np.testing.assert_allclose(drive.values, np.array(values) / (0.1 * 9.80665 * 0.1), rtol=1e-15)


def test_a_file_of_a_case_in_si_is_in_si(tmp_path):
    si = """
    [machine]
    kind = "pendulum-capsule"
    capsule_mass_kg = 0.5
    pendulum_mass_kg = 0.2
    pendulum_length_m = 0.25
    stiffness_N_m_per_rad = 0.98
    damping_N_m_s_per_rad = 0.08
    normal_load = "weight"
    [friction]
    law = "coulomb"
    [drive]
    waveform = "table"
    """
    case = read_case(written(tmp_path, textwrap.dedent(si) + 'file = "current.csv"\n'))
    text = f"times_s = {list(TIMES)}\nvalues_N_m = {list(VALUES)}\n"
    assert case == case_from_text(textwrap.dedent(si) + text)
    assert case.system.drive.period * case.system.units.time_s == pytest.approx(2.5)
    assert case_from_text(case_text(case, units="SI")).system.drive == case.system.drive


@pytest.mark.parametrize(
    ("case", "columns", "complaint"),
    [
        (CASE, "0, 1\n1, 2, 3\n", "drive.file: line 2 of .*current.csv' should be a time and a value, got '1, 2, 3'"),
        (CASE, "a, b\n", "drive.file: .*current.csv' holds no numbers"),
        (CASE, "0,0\n2,1\n1,1\n3,0\n", r"drive.times: should increase: number 3 is not after"),
        (CASE.replace("current", "other"), COLUMNS, "drive.file: there is no file .*other.csv"),
        (CASE + "times = [0, 1]\n", COLUMNS, "drive.file: gives the table once more; give it or times"),
        (CASE.replace('"current.csv"', "3"), COLUMNS, "drive.file: should be the name of a file"),
    ],
)
def test_files_that_are_refused(case, columns, complaint, tmp_path):
    with pytest.raises(CaseError, match=complaint):
        read_case(written(tmp_path, case, columns))
    with pytest.raises(ArgumentError, match="file: there is no file"):
        vc.read_drive_table(tmp_path / "none.csv")
