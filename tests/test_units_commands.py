"""Commands on a case in SI: changes of it, limits, steady motions, branches, crossings, basins and their pictures.

Their numbers are those without units, times the unit. The units of the machine are its pendulum's, by hand:
0.2 kg, 0.25 m, and sqrt(l/g).
"""

import json
import math
import pickle
from pathlib import Path

import numpy as np
import pytest

import vibrocap as vc
from test_units import CASE, PRESSED
from vibrocap.case.case import CaseError, case_from_text
from vibrocap.cli import main as cli

METRE, SECOND = 0.25, math.sqrt(0.25 / 9.80665)
BENCH = PRESSED.replace("frequency_Hz = 1.1", "frequency_Hz = 1.0").replace(
    "decay_rate", "coulomb_coefficient = 0.05\nstatic_coefficient = 0.15\ndecay_rate"
)


@pytest.fixture
def place(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("si.toml").write_text(BENCH, encoding="utf-8")
    return tmp_path


# --- tables -----------------------------------------------------------------------------------------------------------
TABLES = {
    "friction si.toml": ("N = 6.864655 N", " m/s ", "N s/m"),
    "orbit si.toml": (" m per period", " m/s\n", "period        1 s", " rad/s, position"),
    "basins si.toml --plane angle_deg=-20:20,velocity_m_per_s=-1:1 --resolution 2": (" m per drive period",),
    "crossing si.toml --over drive.frequency_Hz=0.95:1.05 --value 0.047 --points 3": (
        "drift = 0.047 m over drive.frequency_Hz",
    ),
}


@pytest.mark.parametrize("command", TABLES)
def test_tables_of_commands_say_their_units(place, capsys, command):
    """Their numbers are those of --json (test_views.py)."""
    assert cli.main(command.split()) == 0
    printed = capsys.readouterr().out
    assert all(table in printed for table in TABLES[command])


# --- steady motions ---------------------------------------------------------------------------------------------------
def test_twins_and_what_an_orbit_gives_way_to_are_in_si():
    """Every motion within the record of another is converted as that is."""
    from vibrocap.cli.commands.orbit import orbit_view
    from vibrocap.orbits.attractors.classification import MotionClass
    from vibrocap.orbits.closing.orbit import orbit

    case = case_from_text(BENCH)
    steady = orbit(case.system, initial=case.initial)
    what = MotionClass("chaotic", "made up", 2.0, 0.1, None, steady.state)
    view = orbit_view(steady, steady, (steady,), what)
    (inner,) = view["unstable_orbit"]["gives_way_to"]
    assert (inner["period"].value, inner["period"].unit) == (steady.period * SECOND, "s")
    for each in (view, view["unstable_orbit"], inner):
        assert each["drift"].value == each["drift"].dimensionless * METRE != 0.0
        assert each["state"]["velocity"].value == pytest.approx(steady.state["velocity"] * METRE / SECOND, rel=1e-14)
    assert view["mirrored_state"]["velocity"].dimensionless == steady.mirrored_state["velocity"]
    assert view["class"]["drift"].value == 2.0 * METRE
    assert "unstable_orbit" not in orbit_view(steady, None, None, None)


# --- over a parameter -------------------------------------------------------------------------------------------------
def test_the_plane_of_basins_is_given_in_si():
    from vibrocap.cli.commands.basins import _axis

    system = case_from_text(BENCH).system
    asked, ends = _axis("velocity_m_per_s=-1:2", system)
    assert asked.plain == "initial.velocity"
    assert ends == pytest.approx((-SECOND / METRE, 2 * SECOND / METRE), rel=1e-14)
    asked, ends = _axis("angle_deg=-90:180", system)
    assert (asked.plain, ends) == ("initial.angle", pytest.approx((-math.pi / 2, math.pi), rel=1e-14))
    for text in ("angle=-1:1", "phase=-1:1"):
        asked, ends = _axis(text, system)
        assert (asked.plain, ends) == (f"initial.{text[:5]}", (-1.0, 1.0))


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("basins", "si.toml", "--plane", "angle,velocity=-1:1"),
         "--plane velocity: has no unit in a case in SI; give velocity_m_per_s"),
        (("basins", "plain.toml", "--plane", "angle,velocity_m_per_s=-1:1"),
         "--plane velocity_m_per_s: the case does not give its units; add velocity, or a case in SI"),
        (("branch", "plain.toml", "--over", "drive.frequency_Hz=1:2"),
         "--over drive.frequency_Hz: the case does not give its units; add drive.frequency, or a case in SI"),
        (("simulate", "si.toml", "--set", "machine.mass_ratio=2"),
         "--set machine.mass_ratio: has no unit in a case in SI; give capsule_mass_kg"),
        (("simulate", "si.toml", "--initial", "velocity=0.2"),
         "--initial velocity: has no unit in a case in SI; give velocity_m_per_s"),
        (("simulate", "si.toml", "--set", "drive.frequency=1"),
         "--set drive.frequency: has no unit in a case in SI; give frequency_Hz or frequency_rad_per_s"),
    ],
)  # fmt: skip
def test_units_that_are_missing_or_not_known_are_named(place, capsys, words, said):
    Path("plain.toml").write_text('[machine]\nkind="pendulum-capsule"\n[friction]\nlaw="exponential"\n'
                                  '[drive]\nwaveform="harmonic"\n', encoding="utf-8")  # fmt: skip
    assert cli.main([*words]) == 2
    assert said in " ".join(capsys.readouterr().err.split())


# --- pictures ---------------------------------------------------------------------------------------------------------
def test_pictures_of_branches_are_in_si():
    from vibrocap.orbits.continuation.branch import branch
    from vibrocap.plotting.steady.branches import branch_figure

    system = case_from_text(BENCH).system
    curve = branch(system, "drive.frequency", (6.0, 6.6), initial={"angle": 1.0}, points=4)
    (ax,) = branch_figure(curve).axes
    hertz = 1.0 / (2.0 * math.pi * SECOND)
    assert ax.get_xlabel() == "drive frequency [Hz]"
    assert ax.get_ylabel().endswith("[m/s]")
    assert ax.get_xlim() == pytest.approx((6.0 * hertz, 6.6 * hertz), rel=1e-14)
    line = max(ax.lines, key=lambda each: np.size(each.get_xdata()))
    assert line.get_xdata() == pytest.approx(curve.parameter * hertz, rel=1e-14)
    assert line.get_ydata() == pytest.approx(curve.mean_velocity * METRE / SECOND, rel=1e-14)
    (other,) = branch_figure(curve, over="drive.frequency_rad_per_s").axes
    assert other.get_xlabel() == "drive frequency [rad/s]"
    assert other.get_xlim() == pytest.approx((6.0 / SECOND, 6.6 / SECOND), rel=1e-14)


def test_pictures_of_basins_are_in_si():
    from vibrocap.orbits.attractors.basins import basins
    from vibrocap.plotting.steady.basins import basin_figure

    system = case_from_text(BENCH).system
    cells = basins(system, {"angle": (-1, 1), "velocity": (-1, 1)}, 2)
    figure = basin_figure(cells)
    ax = figure.axes[0]
    assert ax.get_ylabel().endswith("[m/s]")
    assert ax.get_ylim() == pytest.approx((-METRE / SECOND, METRE / SECOND), rel=1e-12)
    assert ax.get_xlim() == pytest.approx((-1, 1), rel=1e-12)
    (legend,) = figure.legends
    words = [text.get_text() for text in legend.get_texts()]
    twins = np.unique(cells.drift.round(9))
    assert len(twins) == len(words) == 2
    for drift in twins:
        said = f"{drift * METRE:+.4g} m".replace("-", "\N{MINUS SIGN}")
        assert sum(word.endswith(said) for word in words) == 1


def test_basins_remember_the_keys_of_their_plane():
    """In Python too, in a sheet and in a panel, and after pickling; bare keys are drawn in the units of results."""
    cells = vc.basins(case_from_text(BENCH).system, {"angle_deg": (-60, 60), "velocity": (-1, 1)}, 2)
    assert cells.keys == ("angle_deg", "velocity")
    for each in (cells, pickle.loads(pickle.dumps(cells))):
        for axes in (vc.plot(each), vc.figure(each).axes[0]):
            assert axes.get_xlabel() == r"initial angle $\theta$ [deg]"
            assert axes.get_xlim() == pytest.approx((-60.0, 60.0), rel=1e-12)
    bare = vc.basins(case_from_text(BENCH).system, {"angle": (-1, 1), "velocity": (-1, 1)}, 2)
    assert vc.plot(bare).get_xlabel() == r"initial angle $\theta$ [rad]"


# --- changes of a case ------------------------------------------------------------------------------------------------
def test_changes_on_the_command_line_are_in_si(place, capsys):
    Path("case.toml").write_text(CASE, encoding="utf-8")
    words = ("--set", "machine.capsule_mass_kg=0.4", "--initial", "angle_deg=20,velocity_m_per_s=0")
    assert cli.main(["simulate", "case.toml", "--periods", "1", "--json", *words]) == 0
    content = json.loads(capsys.readouterr().out)
    text = CASE.replace("capsule_mass_kg = 0.5", "capsule_mass_kg = 0.4").replace("angle = 1.0", "angle_deg = 20")
    text = text.replace("velocity_m_per_s = 0.1", "velocity_m_per_s = 0").replace("periods = 12", "periods = 1")
    assert {key: x["dimensionless"] for key, x in content["state"].items()} == case_from_text(
        text
    ).simulate().dimensionless.state


def test_a_change_in_another_unit_replaces_what_the_case_says():
    for path, value in (("drive.frequency_rad_per_s", 7.0), ("initial.angle_deg", 20.0)):
        case = case_from_text(CASE, changes={path: value})
        if path.startswith("drive"):
            assert case.system.parameter("drive.frequency") / SECOND == pytest.approx(7.0, rel=1e-14)
        else:
            assert case.initial["angle"] == pytest.approx(math.radians(20.0), rel=1e-14)
    with pytest.raises(CaseError, match=r"drive\.frequency_rad_per_s: is frequency_Hz once more; give one of them"):
        case_from_text(CASE, changes={"drive.frequency_rad_per_s": 7.0, "drive.frequency_Hz": 1.0})
