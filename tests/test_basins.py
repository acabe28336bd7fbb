"""Basins of direction: starts at any phase of the drive, the symmetry of the picture, what failed, and how it looks."""

import math
from typing import Any

import numpy as np
import pytest

import vibrocap as vc
from systems import capsule
from vibrocap.motion.simulate import period_marks
from vibrocap.orbits.attractors import basins as basins_module
from vibrocap.orbits.attractors.attractors import FAILED, NOT_SETTLED, NOT_TOLD, Attractor
from vibrocap.orbits.attractors.basins import Basins, at_next_section, basins, share_error
from vibrocap.orbits.attractors.classification import MotionClass
from vibrocap.orbits.closing import settling_runs
from vibrocap.orbits.maps.stroboscopic_map import StroboscopicMap
from vibrocap.plotting.steady.basins import UNVALUED_STYLES, basin_figure
from vibrocap.plotting.studies.cells import Cell
from vibrocap.plotting.studies.maps import CELL_STYLES, UNSETTLED
from vibrocap.ranges import cell_middles

PLANE = {"angle": (-3.0, 3.0), "angle_rate": (-3.0, 3.0)}


def drawn(count=12):
    """Basins as they might be, with every kind of cell: two ways, two attractors one way, and what has no value."""
    drifts = np.array([0.16, -0.16, 0.05])
    motions = [MotionClass(f"period-{k + 1}", "", drift, 0.0, False, {}) for k, drift in enumerate(drifts)]
    label = np.zeros((count, count), dtype=int)
    label[: count // 2] = 1
    label[:, :2] = 2
    label[:2, 4:6], label[4:6, 4:6], label[8:10, 4:6] = NOT_SETTLED, FAILED, NOT_TOLD
    drift = np.where(label >= 0, drifts[np.maximum(label, 0)], np.nan)
    direction = np.where(label >= 0, np.sign(np.nan_to_num(drift)), np.where(label == NOT_TOLD, 0, label))
    middles = np.linspace(-2.75, 2.75, count)
    return Basins(
        system=capsule(), axes=("angle", "angle_rate"), x=middles, y=middles, phase=0.25, label=label, drift=drift,
        initial={"position": 0.0, "velocity": 0.0}, direction=direction.astype(np.int8), settle_periods=500,
        attractors=tuple(
            Attractor(motion, int(np.sum(label == k)), float(np.mean(label == k)), 0.0, None)
            for k, motion in enumerate(motions)
        ),
    )  # fmt: skip


# --- phases of the drive ---------------------------------------------------------------------------------------------


def test_start_amid_a_period_goes_on_to_its_end():
    """In plain Python: a run cut at 0.3 of the period is at the mark where the run that was not cut is."""
    map_ = StroboscopicMap(capsule(), 1e-11, threads=1, plain=True)
    rows = np.tile(map_.parameters(), (3, 1))
    start = np.array([[1.0, 0.0, 0.0, 0.0], [-0.5, 1.0, 2.0, 0.1], [0.3, 0.2, 0.0, 0.0]])
    with np.errstate(all="ignore"):
        whole = map_.images(start, rows, tangents=False).state
        period = map_.period(map_.parameters())
        part = map_.images(start, rows, tangents=False, mark_distance=np.full(3, 0.3 * period)).state
        ends, _ = at_next_section(map_, np.array([part[0], part[1], start[2]]), np.array([0.3, -1.7, 2.0]))
    assert ends[:2] == pytest.approx(whole[:2], abs=1e-8)
    assert ends[2] == pytest.approx(start[2], abs=0.0)  # it is at a mark already


# --- what is refused -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("arguments", "complaint"),
    [
        ({"plane": {"angle": (-1, 1)}}, "should name two states"),
        ({"plane": ("angle",)}, "should name two states"),
        ({"plane": "angle"}, "should name two states"),
        ({"plane": ("angle", "spin")}, "'spin' is no state"),
        ({"plane": {"angle": (-1, 1), "position": (0, 1)}}, "nothing depends on 'position'"),
        ({"plane": {"angle": (-1, 1), "spin": (0, 1)}}, "'spin' is no state"),
        ({"plane": {"angle": (1, -1), "velocity": (0, 1)}}, "plane: angle should be finite with low < high"),
        ({"resolution": 0}, "resolution should be one or two whole numbers"),
        ({"resolution": (10, 2.5)}, "resolution should be one or two whole numbers"),
        ({"resolution": 10**5}, "are more than 10,000,000"),
        ({"phase": math.inf}, "phase should be a finite share"),
        ({"initial": {"angel": 1}}, "did you mean 'angle'"),
        ({"settle_periods": 0}, "settle_periods should be"),
    ],
)
def test_bad_input_is_refused(arguments, complaint):
    with pytest.raises(ValueError, match=complaint):
        basins(capsule(), **{"plane": PLANE, **arguments})


# --- basins ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("kind", "least", "most"),
    [
        ("along an axis", 0.8, 1.2),
        ("rectangle", 0.8, 1.2),
        ("disc", 0.7, 1.3),
        ("line", 0.2, 1.3),
        ("riddled", 0.8, 1.4),
    ],
)
def test_error_of_a_share_is_that_of_known_areas(kind, least, most):
    """Over shapes at places by chance, the errors of their shares spread as is stated."""
    draw, middles = np.random.default_rng(5), cell_middles(0.0, 1.0, 64)
    x, y = np.meshgrid(middles, middles, indexing="ij")
    errors, stated = [], []
    for _ in range(100):
        (a, c), (b, d), radius, slope = (
            draw.uniform(0.2, 0.4, 2),
            draw.uniform(0.6, 0.8, 2),
            0.3 * draw.uniform(0.6, 1),
            1.4,
        )
        inside, area = {
            "along an axis": (x < a, a),
            "rectangle": ((x > a) & (x < b) & (y > c) & (y < d), (b - a) * (d - c)),
            "disc": ((x - a - 0.15) ** 2 + (y - b + 0.2) ** 2 < radius**2, np.pi * radius**2),
            "line": (x + slope * (y - 0.5) * (c - 0.2) < b, b),
            "riddled": (draw.uniform(size=x.shape) < a, a),
        }[kind]
        errors.append(np.mean(inside) - area)
        stated.append(share_error(inside))
    assert least < np.sqrt(np.mean(np.square(errors)) / np.mean(np.square(stated))) < most


@pytest.mark.slow
def test_phase_as_an_axis_has_the_same_symmetry():
    """Without a range an axis spans what motions visit: mirror images of motions are motions."""
    cells = basins(capsule(), ("phase", "angle"), (20, 21))
    assert cells.y[-1] > 1.5  # two natural sizes at least, less half a cell
    assert cells.y == pytest.approx(-cells.y[::-1])
    assert np.array_equal(np.roll(cells.direction, 10, axis=0), -cells.direction[:, ::-1])
    width = cells.y[-1] * 21 / 20
    plane = {"angle": (-width, width), "velocity": (-1e-9, 1e-9)}
    column = basins(capsule(), plane, (21, 1), phase=cells.x[7])
    assert np.array_equal(column.direction[:, 0], cells.direction[7])


@pytest.mark.slow
def test_directions_are_those_of_single_runs():
    cells = basins(capsule(), PLANE, 12)
    for i, j in ((0, 0), (3, 8), (6, 6), (9, 2), (11, 11)):
        start = {"angle": cells.x[i], "angle_rate": cells.y[j]}
        _, path = period_marks(capsule(), periods=100, initial=start)
        assert path[-1][2] - path[-2][2] == pytest.approx(cells.drift[i, j], abs=1e-6)
        assert cells.direction[i, j] == np.sign(cells.drift[i, j])
    assert cells.x[0] == pytest.approx(-2.75)  # the middle of the first cell


# --- datasets and pictures -------------------------------------------------------------------------------------------


def test_dataset_says_what_it_holds():
    given = drawn()
    dataset = vc.to_xarray(given)
    assert dataset["direction"].dims == ("initial.angle", "initial.angle_rate")
    assert np.array_equal(dataset["label"].values, given.label)
    assert list(dataset["attractor_drift"].values) == [0.16, -0.16, 0.05]
    assert dataset.attrs["phase"] == 0.25
    assert "pendulum-capsule" in dataset.attrs["case"]
    flags = dict(
        zip(dataset["direction"].attrs["flag_meanings"].split(), dataset["direction"].attrs["flag_values"], strict=True)
    )
    assert (flags["failed"], flags["not_settled"], flags["forward"]) == (FAILED, NOT_SETTLED, 1)


def test_dataset_of_a_diagram_says_what_it_holds():
    values, shape = np.array([1.0, 1.5, 2.0]), (1, 2, 3)
    states = np.arange(2.0 * 3 * 16 * 4).reshape(*shape, 16, 4)
    diagram = vc.BifurcationDiagram(
        system=capsule(),
        over="drive.amplitude",
        values=values,
        directions=("down",),
        states=states,
        response_period=np.array([[[1, 0, 2], [1, -1, 2]]]),
        drift=np.ones(shape),
        state_names=("angle", "angle_rate", "position", "velocity"),
    )
    dataset = vc.to_xarray(diagram)
    assert dataset["velocity"].dims == ("direction", "start", "drive.amplitude", "mark")
    assert np.array_equal(dataset["velocity"].values, states[..., 3])
    assert dataset["response_period"].sel({"drive.amplitude": 1.5}).values.tolist() == [[0, -1]]
    assert dataset["drive.amplitude"].attrs["symbol"] == "h"


def test_drift_and_direction_of_every_kind_of_start():
    chaotic = MotionClass("chaotic", "", 0.01, 0.005, True, {})
    sure = MotionClass("chaotic", "", -0.1, 0.005, False, {})
    items = tuple(Attractor(each, 1, 0.2, 0.0, None) for each in (chaotic, sure))
    label = np.array([0, 1, NOT_SETTLED, FAILED, NOT_TOLD, NOT_TOLD])
    measured = np.array([math.nan, math.nan, 0.3, 0.3, 0.3, 1e-9])
    runs = settling_runs.SettlingRuns(np.zeros((6, 4)), np.ones(6), np.zeros(6), measured, np.ones(6, bool))
    drift = basins_module._drifts(items, label, runs)
    assert drift == pytest.approx([0.01, -0.1, math.nan, math.nan, 0.3, 1e-9], nan_ok=True)
    directions = basins_module._directions(capsule(), items, label, drift)
    assert list(directions) == [0, -1, NOT_SETTLED, FAILED, 1, 0]  # the first: within its error


def test_starts_without_a_value_are_hatched_as_runs_of_studies_are():
    """Each kind by its own pattern over its own cells, named with its share in the legend."""
    cells = drawn()
    fig = basin_figure(cells)
    handles: list[Any] = fig.legends[0].legend_handles
    legend = {handle.get_label(): handle.get_hatch() for handle in handles}
    middles = np.stack(np.meshgrid(cells.x, cells.y, indexing="ij"), axis=-1).reshape(-1, 2)
    for code, look in (
        (NOT_SETTLED, UNSETTLED),
        (FAILED, CELL_STYLES[Cell.FAILED][1]),
        (NOT_TOLD, CELL_STYLES[Cell.NO_VALUE][1]),
    ):
        assert legend[f"{UNVALUED_STYLES[code][0]}: 4 (3 %)"] == look
        for ax in fig.axes[:2]:
            patches = [patch for patch in ax.patches if patch.get_hatch() == look]
            assert patches
            for patch in patches:
                covered = patch.get_path().contains_points(middles).reshape(cells.label.shape)
                assert np.array_equal(covered, cells.label == code)
    assert None in legend.values()
