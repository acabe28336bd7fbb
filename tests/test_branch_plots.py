"""Pictures and datasets of branches, of one made by hand: what is drawn, where it is cut, what stands beside."""

import types

import numpy as np
import pytest

import vibrocap as vc
from vibrocap.orbits.continuation.branch import Branch
from vibrocap.orbits.continuation.branch_diagram import BranchDiagram
from vibrocap.orbits.walk.kinds import BranchEnd, ModeChange, SpecialKind
from vibrocap.orbits.walk.special_points import SpecialPoint
from vibrocap.physics.dimensions.conversion import quantity_in_si
from vibrocap.plotting.look.finishing import save
from vibrocap.plotting.look.style import figure
from vibrocap.plotting.steady import branches as branch_plots

SYSTEM = vc.System(vc.PendulumCapsule(), vc.Exponential(), vc.Harmonic())
OVER, BETWEEN = "drive.amplitude", (1.0, 3.0)
ALONG = quantity_in_si(OVER, SYSTEM)


def special(kind, parameter, drift, arclength, after, counts, **more):
    settings = {
        "modes_before": "FB", "modes_after": "FB", "change": None, "passed": None, "text": "", "found": None, **more,
    }  # fmt: skip
    return SpecialPoint(
        kind=kind, parameter=parameter, error=1e-9, state={}, drift=drift, multipliers=np.ones(3),
        arclength=arclength, after_point=after, unstable_before=counts[0], unstable_after=counts[1], **settings,
    )  # fmt: skip


def branch(parameter, drift, stable, special_points=(), symmetric=True, period=1):
    parameter, drift = np.array(parameter), np.array(drift)
    n = len(parameter)
    return Branch(
        system=SYSTEM, over=OVER, between=BETWEEN, response_period=period, symmetric=symmetric, parameter=parameter,
        period=np.full(n, 2.0 * np.pi * period),
        states=np.arange(4.0 * n).reshape(n, 4), drift=drift, mean_velocity=drift / (2.0 * np.pi * period),
        multipliers=np.where(np.array(stable), 0.5, 1.5)[:, None] * np.ones(3, dtype=complex), stable=np.array(stable),
        mode_sequence=np.array(["FB"] * n), arclength=np.arange(n, dtype=float), certified=np.ones(n, bool),
        winding=np.empty((n, 0), int),
        special_points=tuple(special_points), ends=(BranchEnd.PARAMETER_BOUND, BranchEnd.PARAMETER_BOUND), start=0,
        closing_map=types.SimpleNamespace(map=types.SimpleNamespace(cyclic=2)),  # type: ignore[arg-type]
    )  # fmt: skip


def symmetric_branch():
    pitchfork = special(SpecialKind.PITCHFORK, 1.4, 0.0, 0.8, 0, (0, 1))
    regained = special(
        SpecialKind.MODE_CHANGE, 2.6, 0.0, 2.6, 2, (1, 0), modes_after="FSBS", change=ModeChange.CROSSING,
        passed=SpecialKind.PITCHFORK, text="two stick phases appear",
    )  # fmt: skip
    return branch([1.0, 1.5, 2.0, 3.0], [0.0] * 4, [True, False, False, True], [pitchfork, regained])


def travelling_branch():
    fold = special(SpecialKind.FOLD, 2.7, 0.1, 2.2, 2, (0, 1))
    return branch([1.4, 2.0, 2.68, 2.6], [0.0, 0.3, 0.12, 0.0], [False, True, True, False], [fold], symmetric=False)


def diagram():
    return BranchDiagram(SYSTEM, OVER, BETWEEN, (symmetric_branch(), travelling_branch()), (), ())


def test_lines_are_cut_where_stability_changes():
    stretches = branch_plots.stretches(symmetric_branch(), "drift")
    assert [stable for _, _, stable in stretches] == [True, False, True]
    assert [x.tolist() for x, _, _ in stretches] == [[1.0, 1.4], [1.4, 1.5, 2.0, 2.6], [2.6, 3.0]]
    stretches = branch_plots.stretches(travelling_branch(), "drift")
    assert [(x.tolist(), stable) for x, _, stable in stretches] == [([1.4, 2.0, 2.68, 2.7], True), ([2.7, 2.6], False)]


def test_stable_is_solid_and_twins_are_drawn():
    _, axes = figure(1, 1)
    used = branch_plots.draw_branches(axes[0, 0], diagram(), "mean_velocity", ALONG)
    lines = [line for line in axes[0, 0].lines if len(line.get_xdata()) > 1 and line.get_xdata()[0] >= 1.0]
    styles = {(line.get_color(), line.get_linestyle()) for line in lines}
    black, blue = branch_plots.BLACK, branch_plots.BLUE
    assert styles == {(black, "-"), (black, "--"), (blue, "-"), (blue, "--")}
    peaks = [float(line.get_ydata()[1]) for line in lines if line.get_color() == blue and line.get_linestyle() == "-"]
    assert sorted(peaks) == pytest.approx([-0.3 / (2.0 * np.pi), 0.3 / (2.0 * np.pi)])
    assert {"stable", "unstable", "pitchfork", "fold", branch_plots.LOSS_WORDS} <= used
    marks = [(line.get_marker(), float(line.get_xdata()[0])) for line in axes[0, 0].lines if len(line.get_xdata()) == 1]
    assert sorted(marks) == [("D", 1.4), ("D", 2.6), ("o", 2.7), ("o", 2.7)]


def swept(over=OVER):
    values = np.array([1.2, 2.0])
    response = np.array([[[1, 1]], [[1, 0]]])  # the last has not settled
    drift = np.array([[[0.0, 0.3]], [[0.0, np.nan]]])
    states = np.zeros((2, 1, 2, 4, 4))
    return vc.BifurcationDiagram(SYSTEM, over, values, ("up", "down"), states, response, drift, SYSTEM.state_names)


def test_brute_force_is_marked_where_it_settled():
    _, axes = figure(1, 1)
    assert branch_plots.draw_swept(axes[0, 0], swept(), "mean_velocity", ALONG) == {"up", "down"}
    up, down = axes[0, 0].lines
    assert up.get_xdata().tolist() == [1.2, 2.0]
    assert up.get_ydata() == pytest.approx([0.0, 0.3 / (2.0 * np.pi)])
    assert down.get_xdata().tolist() == [1.2]
    assert (up.get_fillstyle(), down.get_fillstyle()) == ("right", "left")


def test_places_where_travel_begins_and_ends_bear_their_parameter():
    _, axes = figure(1, 1)
    branch_plots.draw_branches(axes[0, 0], diagram(), "mean_velocity", ALONG)
    assert [(text.get_text(), text.get_ha()) for text in axes[0, 0].texts] == [("1.4000", "right"), ("2.6000", "left")]


def test_what_cannot_be_drawn_is_refused(tmp_path):
    with pytest.raises(ValueError, match="swept should be a diagram for each panel"):
        save(branch_plots.branch_figure(diagram(), swept=[swept("machine.stiffness")]), tmp_path / "x.png")
    with pytest.raises(ValueError, match="swept should be a diagram for each panel"):
        save(branch_plots.branch_figure([diagram(), diagram()], swept=[swept()]), tmp_path / "x.png")
    with pytest.raises(ValueError, match="quantity should be one of mean_velocity, drift, period, got 'speed'"):
        save(branch_plots.branch_figure(diagram(), "speed"), tmp_path / "x.png")
    with pytest.raises(ValueError, match="at least one branch"):
        save(branch_plots.branch_figure([]), tmp_path / "x.png")
    with pytest.raises(ValueError, match="does not travel"):
        save(branch_plots.branch_figure(branch([1.0, 2.0], [np.nan] * 2, [True] * 2)), tmp_path / "x.png")


def test_branch_in_words_and_as_a_table():
    curve = symmetric_branch()
    (first, second) = curve.table()
    assert (first["kind"], first["parameter"], first["stability"]) == ("pitchfork", 1.4, "lost")
    assert second["remarks"] == (
        "crossing; two stick phases appear; FB -> FSBS; multipliers jump as over a pitchfork; stability gained"
    )
    assert curve.special_points[1].discontinuous
    assert not curve.special_points[0].discontinuous
    assert curve.parts == ((0, 0, True), (1, 2, False), (3, 3, True))
    assert curve.kind(SpecialKind.PITCHFORK) == (curve.special_points[0],)
    assert "symmetric orbits of 1 drive period(s) over drive.amplitude, 4 points" in str(curve)
    assert "[1] Branch of travelling orbits" in str(diagram())


def test_dataset_says_what_it_holds():
    pytest.importorskip("xarray")
    curve = symmetric_branch()
    data = curve.to_xarray()
    assert data["drift"].dims == ("point",)
    assert np.array_equal(data[OVER].values, curve.parameter)
    assert np.array_equal(data["velocity"].values, curve.states[:, 3])
    assert np.array_equal(data["multiplier_real"].values, curve.multipliers.real)
    assert data["special_kind"].values.tolist() == ["pitchfork", "change of mode sequence"]
    assert data["special_stability"].values.tolist() == ["lost", "gained"]
    assert data.attrs["ends"] == "parameter bound"
    assert "[machine]" in data.attrs["case"]
    assert data[OVER].attrs["symbol"] == "h"


def test_remarks_say_what_changes_and_nothing_else():
    jump = special(
        SpecialKind.MODE_CHANGE, 1.2, 0.1, 1.0, 1, (0, 1), modes_after="FSB", change=ModeChange.CROSSING,
        passed=SpecialKind.FLIP,
    )  # fmt: skip
    change, words, over, stability = jump.remarks.split("; ")
    assert (change, words) == (ModeChange.CROSSING.value, "FB -> FSB")
    assert (over, stability) == ("multipliers jump as over a flip", "stability lost")
    assert jump.discontinuous
    assert special(SpecialKind.FOLD, 1.2, 0.1, 1.0, 1, (1, 1)).remarks == ""
    assert not special(SpecialKind.FLIP, 1.2, 0.1, 1.0, 1, (0, 1)).discontinuous
