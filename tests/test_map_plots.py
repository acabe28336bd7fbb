"""Pictures of studies, by what is in them: colours, hatches, limits and words; datasets of the layout of `sweep`."""

import itertools
import re

import matplotlib
import numpy as np
import pytest
from matplotlib.collections import LineCollection, QuadMesh
from matplotlib.colors import LogNorm
from matplotlib.patches import PathPatch

from crowding import crowded
from vibrocap.arguments import Refusal
from vibrocap.case.case import case_from_text, case_text, read_case
from vibrocap.measures.standard import LOAD_WATCH
from vibrocap.motion.status import Status
from vibrocap.plotting.look.style import blank_figure, logarithmic
from vibrocap.plotting.studies.cells import Cell, categories, cell_labels, cells, limits
from vibrocap.plotting.studies.maps import CELL_STYLES, HIDDEN, PRINT, UNSETTLED, plot_view, study_figure
from vibrocap.plotting.studies.view import study_view

xarray = pytest.importorskip("xarray")

MASS, TORQUE, LAW = "machine.mass_ratio", "drive.amplitude", "friction.law"
ATTRIBUTES = {
    MASS: {"long_name": "capsule mass over pendulum mass, M/m", "symbol": "lambda", "units": "1"},
    TORQUE: {"long_name": "drive torque", "symbol": "h", "units": "1"},
    LAW: {"long_name": "friction law"},
    "mean_velocity": {"long_name": "travel per time", "units": "1"},
    "stick_fraction": {"long_name": "share of the window stuck (NaN: the law cannot stick)", "units": "1"},
    "cost_of_transport": {"long_name": "work per distance (infinite: no travel)", "units": "1"},
    "mode_sequence": {"long_name": "phases of the last period", "units": "1"},
}
NOT_FINITE, TOO_MANY_EVENTS = (list(Status).index(s) for s in (Status.NOT_FINITE, Status.TOO_MANY_EVENTS))
NBSP = "\N{NO-BREAK SPACE}"
SI = """
[machine]
kind = "pendulum-capsule"
capsule_mass_kg = 0.5
pendulum_mass_kg = 0.2
pendulum_length_m = 0.25
stiffness_N_m_per_rad = 0.98
damping_N_m_s_per_rad = 0.08
normal_load = "weight"
[friction]
law = "exponential"
coulomb_coefficient = 0.05
static_coefficient = 0.15
decay_rate_s_per_m = 6.5
[drive]
waveform = "harmonic"
amplitude_N_m = 0.7
frequency_Hz = 1.0
[environment]
inclination_deg = 5
[initial]
angle_deg = 30
"""
FAILED, WAITING, TO_COME = (slice(5, 8), slice(5, 9)), (slice(0, 4), slice(0, 5)), (slice(-2, None), slice(-3, None))


def study(x=None, y=None, laws=None, **attributes):
    """A dataset over mass ratio and torque with every kind of run: 12 + 1 failed, 20 unsettled, 6 not run."""
    x, y = (np.linspace(0.5, 8.0, 16) if x is None else x), (np.linspace(0.2, 3.0, 12) if y is None else y)
    velocity = 0.1 * np.outer(np.sin(1.0 + np.arange(len(x))), np.cos(np.arange(len(y))))
    velocity[9] = 0.0
    velocity[10, 3] = 3e-4  # small travel
    status = np.zeros(velocity.shape, np.int8)
    status[FAILED], status[8, 0], status[TO_COME] = NOT_FINITE, TOO_MANY_EVENTS, -1
    settled = status == 0
    settled[WAITING] = False
    words = np.array(["FB", "FSB", "S", "FBFB", "B", "FBSB", "SB", "FS", "BS"])[np.arange(len(x)) % 9]
    with np.errstate(divide="ignore"):
        cost = 1.0 / np.abs(velocity)
    arrays = {
        "status": status,
        "settled": settled,
        "response_period": np.where(settled, 1 + (np.arange(len(x)) == 15)[:, None], 0).astype(np.int16),
        "mean_velocity": np.where(status == 0, velocity, np.nan),
        "stick_fraction": np.where((status == 0) & (velocity > -0.05), 0.5 + velocity, np.nan),
        "cost_of_transport": np.where(status == 0, cost, np.nan),
        "mode_sequence": np.where(status == 0, np.repeat(words[:, None], len(y), axis=1), ""),
    }
    dims, coords = [MASS, TORQUE], {MASS: x, TORQUE: y}
    if laws:
        dims = [LAW, *dims]
        coords = {LAW: np.array(laws, dtype=np.dtypes.StringDType()), **coords}
        arrays = {name: np.stack([values] * len(laws)) for name, values in arrays.items()}
    case = case_text(read_case("examples/travels-by-stick-slip.toml"))
    return xarray.Dataset(
        {name: (dims, values, ATTRIBUTES.get(name, {})) for name, values in arrays.items()},
        {name: (name, values, ATTRIBUTES[name]) for name, values in coords.items()},
        {"case": case, "periods": 60, "settle": 1e-6, **attributes},
    )


@pytest.fixture(autouse=True)
def at_the_root(monkeypatch, request):
    monkeypatch.chdir(request.config.rootpath)


def figure(dataset, measure=None, border=None, **options):
    return study_figure(study_view(dataset, measure, **options), border)


def legend_of(fig):
    return [re.sub(r"\s+", " ", text.get_text()) for legend in fig.legends for text in legend.get_texts()]


def meshes(ax):
    return {mesh.get_label(): mesh for mesh in ax.collections if isinstance(mesh, QuadMesh)}


def hatched_cells(ax, hatch):
    """How many cells lie under a hatching."""
    areas = {}
    for patch in (patch for patch in ax.patches if isinstance(patch, PathPatch) and patch.get_hatch() == hatch):
        x, y = (mesh := meshes(ax)["values"]).get_coordinates()[0, :, 0], mesh.get_coordinates()[:, 0, 1]
        middles = np.stack(np.meshgrid((x[1:] + x[:-1]) / 2, (y[1:] + y[:-1]) / 2), axis=-1).reshape(-1, 2)
        areas[patch.get_hatch_linewidth()] = int(patch.get_path().contains_points(middles).sum())
    return set(areas.values())


# --- maps ------------------------------------------------------------------------------------------------------------


def test_scale_of_travel_is_centred_on_zero_and_follows_the_values():
    dataset = study()
    mesh = meshes(figure(dataset).axes[0])["values"]
    top = float(np.nanmax(np.abs(dataset["mean_velocity"].where(dataset["settled"]))))
    assert (mesh.norm.vmin, mesh.norm.vmax) == (-top, top)
    assert mesh.norm(0.0) == 0.5
    np.testing.assert_array_equal(mesh.get_array().T.filled(np.nan)[10, 3], 3e-4)


def test_colours_are_masked_where_there_is_no_value_and_flat_ones_fill_the_gaps():
    dataset = study()
    found = meshes(figure(dataset).axes[0])
    values, flat = (found[name].get_array().T for name in ("values", "no values"))
    np.testing.assert_array_equal(values.mask, ~flat.mask)
    assert set(flat[FAILED].ravel()) == {Cell.FAILED}
    assert flat[8, 0] == Cell.FAILED
    assert set(flat[TO_COME].ravel()) == {Cell.NOT_RUN}
    assert set(flat[9]) == {Cell.NO_TRAVEL}
    assert not values.mask[10, 3]  # small travel is none of these
    assert not values.mask[WAITING][1:].any()  # unsettled runs keep their colour below the hatching


def test_passage_through_zero_is_a_value_and_a_band_of_rest_is_none():
    dataset = study()
    velocity = dataset["mean_velocity"].values
    velocity[11:14], velocity[14:], velocity[12, 3] = -0.02, 0.02, 1e-9  # the last amid travel back: no passage
    velocity[13, 6] = 1e-9  # between -0.02 and 0.02
    flat = meshes(figure(dataset).axes[0])["no values"].get_array().T
    assert flat.mask[13, 6]
    assert flat[12, 3] == Cell.NO_TRAVEL
    assert set(flat[9]) == {Cell.NO_TRAVEL}  # rest, with travel one way before it and the other way behind


def test_travel_one_way_only_takes_half_of_the_colours():
    dataset = study()
    for sign in (1.0, -1.0):
        one_way = dataset.assign(mean_velocity=sign * abs(dataset["mean_velocity"]))
        mesh = meshes(figure(one_way).axes[0])["values"]
        assert 0.0 in (mesh.norm.vmin, mesh.norm.vmax)
        whole = matplotlib.colormaps["RdBu_r"]
        np.testing.assert_allclose(mesh.cmap(mesh.norm(0.0)), whole(0.5), atol=0.02)
        np.testing.assert_allclose(mesh.cmap(mesh.norm(sign)), whole(1.0 if sign > 0.0 else 0.0), atol=0.02)


@pytest.mark.parametrize(
    ("measure", "value", "words"),
    [("mean_velocity", 1e-9, "no cell travels"), ("stick_fraction", np.nan, "no cell has a value")],
)
def test_a_map_without_a_value_has_no_colour_bar_and_says_why(measure, value, words):
    dataset = study()
    assert len(figure(dataset, measure).axes) == 2
    dataset[measure][:] = value
    if measure == "mean_velocity":
        dataset["status"][:] = list(Status).index(Status.FINISHED)
    without = figure(dataset, measure)
    assert len(without.axes) == 1
    assert words in " ".join(text.get_text() for text in without.axes[0].texts)
    assert not crowded(without)


def test_every_look_is_told_apart_from_every_other_and_from_the_scales():
    faces = [matplotlib.colors.to_rgb(face) for face, _, _ in CELL_STYLES.values()]
    for name in ("RdBu_r", "viridis"):
        colours = matplotlib.colormaps[name](np.linspace(0.0, 1.0, 256))[:, :3]
        for cell in (Cell.NO_TRAVEL, Cell.FAILED):
            assert np.abs(colours - faces[list(CELL_STYLES).index(cell)]).sum(axis=1).min() > 0.2, (name, cell)
    looks = [look[:2] for cell, look in CELL_STYLES.items() if cell not in (Cell.NO_TRAVEL, Cell.INFINITE)]
    assert len(set(looks)) == len(looks)


def test_runs_without_a_value_are_hatched_and_counted_in_the_legend():
    fig = figure(study())
    ax = fig.axes[0]
    assert hatched_cells(ax, CELL_STYLES[Cell.FAILED][1]) == {13}
    assert hatched_cells(ax, CELL_STYLES[Cell.NOT_RUN][1]) == {6}
    assert hatched_cells(ax, UNSETTLED) == {20}
    assert legend_of(fig) == [
        "no travel, |⟨X′⟩| ≤ 1.6e-06: 12 (6 %)",
        "failed: not finite 12, too many events 1",
        "not run yet: 6 (3 %)",
        "not settled: 20 (10 %)",
    ]
    hatches = [handle.get_hatch() for handle in fig.legends[0].legend_handles]
    assert hatches == [None, CELL_STYLES[Cell.FAILED][1], CELL_STYLES[Cell.NOT_RUN][1], UNSETTLED]


@pytest.mark.parametrize(("taken", "usual", "hidden"), [("least_reaction", 0.1, -0.1), (LOAD_WATCH, 0.0, 0.1)])
def test_a_constant_load_that_hides_a_lift_off_is_hatched(taken, usual, hidden):
    """Measured or only watched for: of runs that finished, for the others have an end of their own."""
    dataset = study()
    load = np.full(dataset["status"].shape, usual)
    load[4:7, 5] = hidden  # two of the three failed
    fig = figure(dataset.assign({taken: (dataset["status"].dims, load)}), "mean_velocity")
    assert hatched_cells(fig.axes[0], HIDDEN) == {1}
    assert legend_of(fig)[-1] == "the true load would be negative: 1 (<1 %)"
    assert fig.legends[0].legend_handles[-1].get_hatch() == HIDDEN
    assert not any("true load" in text for text in legend_of(figure(dataset, "mean_velocity")))


def test_dead_band_comes_from_the_option_the_map_or_the_threshold():
    assert study_view(study()).band == "1.6e-06"  # ten thresholds of the length over the period, 2 pi
    assert study_view(study(dead_band=1e-4)).band == "0.0001"
    assert study_view(study(dead_band=1e-4), dead_band=1e-3).band == "0.001"
    drifts = study(dead_band=1e-4).rename(mean_velocity="drift")
    assert study_view(drifts, "drift").band == "1e-05"  # the map's band is of velocities
    unasked = study()
    del unasked.attrs["settle"]
    assert study_view(unasked).band == "1e-06"
    frequencies = study(x=np.linspace(0.5, 8.0, 16)).rename({MASS: "drive.frequency"})
    view = study_view(frequencies)
    np.testing.assert_allclose(view.panels[0].dead_band[:, 0], 1e-5 * frequencies["drive.frequency"] / (2.0 * np.pi))
    assert view.band == f"8e-07{NBSP}to{NBSP}1.3e-05"
    assert not any("not settled" in text for text in legend_of(figure(unasked)))
    view = study_view(study(), dead_band=1e-3)
    assert cells(view, view.panels[0])[10, 3] == Cell.NO_TRAVEL


def test_plain_measure_has_its_own_scale_and_says_why_values_are_missing():
    dataset = study()
    fig = figure(dataset, "stick_fraction")
    mesh = meshes(fig.axes[0])["values"]
    settled = dataset["stick_fraction"].where(dataset["settled"])
    assert (mesh.norm.vmin, mesh.norm.vmax) == (float(settled.min()), float(settled.max()))
    assert mesh.cmap.name == "viridis"
    assert any(text.startswith("no value (the law cannot stick): ") for text in legend_of(fig))
    assert "NaN" not in "".join(text.get_text() for text in fig.texts)


def test_cost_of_transport_is_infinite_without_travel_and_logarithmic_over_decades():
    view = study_view(study(), "cost_of_transport")
    assert set(cells(view, view.panels[0])[9].tolist()) - {Cell.NOT_RUN} == {Cell.INFINITE}
    assert limits(view)[4]
    fig = study_figure(view)
    assert isinstance(meshes(fig.axes[0])["values"].norm, LogNorm)
    assert any(text.startswith("infinite: no travel: 12") for text in legend_of(fig))


def test_ten_cells_far_out_leave_the_colours_to_the_others():
    """Of 400 costs between 1 and 3 ten are 300: the scale ends near 3, its arrow stands for ten, as the bar says."""
    dataset = study(x=np.linspace(0.5, 8.0, 34))
    costs = np.random.default_rng(0).uniform(1.0, 3.0, dataset["cost_of_transport"].shape)
    costs.ravel()[::40] = 300.0
    dataset = dataset.assign(cost_of_transport=dataset["cost_of_transport"].copy(data=costs))
    view = study_view(dataset, "cost_of_transport", dead_band=0.0)
    low, high, below, above, logarithmic = limits(view)
    assert (below, above, logarithmic) == (False, True, False)
    assert 1.0 <= low < high <= 3.0
    out = int(sum((panel.values[cells(view, panel) == Cell.VALUE] > high).sum() for panel in view.panels))
    assert 0 < out <= 11
    assert study_figure(view).axes[-1].get_ylabel().splitlines()[-1].startswith(f"{out} (")


def test_words_have_colours_by_frequency_and_the_rest_is_grey():
    view = study_view(study(), "mode_sequence")
    groups = categories(view)
    assert len(groups.values) == 7
    counts = [int(re.search(r": (\d+)", text)[1]) for text in groups.words]
    assert counts[:-1] == sorted(counts[:-1], reverse=True)
    assert groups.words[-1].startswith("2 others: ")
    assert sum(counts) == int((study()["status"] == 0).sum())
    fig = study_figure(view)
    colours = [matplotlib.colors.to_hex(handle.get_facecolor()) for handle in fig.legends[0].legend_handles[:8]]
    assert len(set(colours)) == 8
    codes = meshes(fig.axes[0])["values"].get_array().T
    assert codes[0, 0] == groups.values.index("FB")
    assert len(fig.axes) == 1  # no scale beside words


def test_response_period_and_status_are_named():
    assert legend_of(figure(study(), "response_period")) == [
        "1: 144 (75 %)",
        "2: 9 (5 %)",
        "failed: not finite 12, too many events 1",
        "not run yet: 6 (3 %)",
        "not settled: 20 (10 %)",
    ]
    assert legend_of(figure(study(), "status"))[:4] == [
        "not run yet: 6 (3 %)",
        "finished: 173 (90 %)",
        "not finite: 12 (6 %)",
        "too many events: 1 (<1 %)",
    ]


def test_colours_are_logarithmic_only_where_all_numbers_are_positive():
    """One run of 384 is less than the half percent that a scale leaves out where it lies far out."""
    dataset = study(x=np.linspace(0.5, 8.0, 32))
    costs = np.geomspace(1.0, 1e4, dataset["cost_of_transport"].size).reshape(dataset["cost_of_transport"].shape)
    for least, expected in ((0.5, True), (0.0, False), (-0.5, False), (-1e5, False)):
        costs[0, 6] = least
        shown = dataset.assign(cost_of_transport=dataset["cost_of_transport"].copy(data=costs))
        assert limits(study_view(shown, "cost_of_transport"))[4] is expected


def test_a_line_explains_no_band_that_holds_no_run():
    line = study().isel({TORQUE: 0, MASS: [1, 2, 3]})
    words = lambda dataset: [text.get_text() for legend in figure(dataset).legends for text in legend.get_texts()]  # noqa: E731
    assert not any("no travel" in word for word in words(line))
    with_rest = line.assign(mean_velocity=line["mean_velocity"].copy(data=[0.1, 0.0, 0.1]))
    assert any("no travel" in word for word in words(with_rest))


@pytest.mark.slow
def test_the_title_of_a_map_in_si_names_all_that_is_fixed():
    import vibrocap as vc

    case = case_from_text(SI)
    over = {"drive.frequency_Hz": [0.9, 1.0], "machine.capsule_mass_kg": [0.4, 0.5]}
    dataset = vc.sweep(case.system, over, settle=1e-3, initial=case.initial, periods=3, tolerance=1e-8)
    view = study_view(dataset)
    fixed = (
        "stiffness = 0.98 N m/rad, damping = 0.08 N m s/rad, normal load = weight, pendulum mass = 0.2 kg, "
        "pendulum length = 0.25 m, gravity = 9.807 m/s^2, coulomb coefficient = 0.05, static coefficient = 0.15, "
        "decay rate = 6.5 s/m, amplitude = 0.7 N m, inclination = 0.08727 rad, initial angle = 0.5236 rad"
    )
    kinds, _, numbers = view.setting.partition("; ")
    assert kinds == "pendulum-capsule, exponential friction, harmonic drive"
    assert numbers.replace(NBSP, " ") == fixed
    assert numbers.count(" ") == fixed.count(", ")  # a line is broken between quantities, never within one
    assert cell_labels(study_view(dataset, dead_band=9.0))[Cell.NO_TRAVEL].startswith(f"no travel, |⟨X′⟩| ≤ 9{NBSP}m/s")
    assert view.label == "mean velocity ⟨X′⟩ [m/s]"


def test_cells_surround_the_values_and_axes_are_logarithmic_where_these_are():
    fig = figure(study(x=np.geomspace(0.01, 10.0, 16)))
    ax = fig.axes[0]
    assert (ax.get_xscale(), ax.get_yscale()) == ("log", "linear")
    edges = meshes(ax)["values"].get_coordinates()
    ratio = 1000.0 ** (1 / 15)
    np.testing.assert_allclose(edges[0, :, 0], 0.01 * ratio ** (np.arange(17) - 0.5), rtol=1e-12)
    step = 2.8 / 11
    np.testing.assert_allclose(edges[:, 0, 1], 0.2 + step * (np.arange(13) - 0.5), rtol=1e-12, atol=1e-15)
    np.testing.assert_allclose(ax.get_xlim(), edges[0, [0, -1], 0])


def test_values_that_were_not_given_in_order_are_drawn_in_order():
    dataset = study()
    shuffled = dataset.isel({MASS: np.random.default_rng(1).permutation(16)})
    first, second = (meshes(figure(each).axes[0])["values"].get_array() for each in (dataset, shuffled))
    np.testing.assert_array_equal(first.filled(9.0), second.filled(9.0))


def test_labels_have_symbols_and_the_title_says_the_case():
    fig = figure(study())
    assert fig.get_figwidth() == 3.54  # a column
    ax, bar = fig.axes
    assert ax.get_xlabel() == r"capsule mass over pendulum mass, M/m $\lambda$"
    assert ax.get_ylabel() == r"drive torque $h$"
    assert bar.get_ylabel() == "mean velocity ⟨X′⟩"
    title, setting = (text.get_text().replace("\n", " ").replace("\N{NO-BREAK SPACE}", " ") for text in fig.texts)
    assert title == "mean velocity: travel per time"
    assert setting.startswith(
        "pendulum-capsule, exponential friction, harmonic drive; "
        r"$\rho$ = 2, $\nu$ = 1, $N$ = 1, $\eta_{c}$ = 0.15, $\eta_{s}$ = 0.45, $a$ = 10, $\omega$ = 1, "
        r"$\theta$(0) = 1.047;"
    )
    assert "192 runs of at most 60 periods, settled to 1e-06; all dimensionless" in setting


def test_border_is_drawn_along_the_walls_of_cells():
    dataset = study(x=np.arange(1.0, 17.0), y=np.arange(12.0))
    dataset["mode_sequence"][:] = "FB"
    dataset["mode_sequence"][8:] = "S"
    ax = figure(dataset, border="mode_sequence").axes[0]
    lines = [collection for collection in ax.collections if isinstance(collection, LineCollection)]
    assert len(lines) == 2  # black with a white rim
    segments = np.array(lines[0].get_segments())
    assert set(segments[:, :, 0].ravel()) == {8.5}
    assert (segments[:, :, 1].min(), segments[:, :, 1].max(), len(segments)) == (-0.5, 11.5, 12)  # from wall to wall
    assert "border of mode sequence" in legend_of(figure(dataset, border="mode_sequence"))
    dataset["mean_velocity"][:] = 5e-6 * np.sign(8.5 - dataset[MASS])  # less than the dead band of drifts
    ax = figure(dataset.assign(drift=2.0 * np.pi * dataset["mean_velocity"]), "drift", "travel").axes[0]
    assert any(isinstance(lines, LineCollection) and len(lines.get_segments()) for lines in ax.collections)
    with pytest.raises(Refusal, match="--border: mean_velocity takes real values"):
        figure(dataset, border="mean_velocity")


@pytest.mark.parametrize(
    ("measure", "laws"),
    [
        ("mean_velocity", None),
        ("mode_sequence", ["exponential", "lugre"]),
        ("cost_of_transport", ["coulomb", "dahl", "lugre"]),
        pytest.param("response_period", ["exponential", "lugre"], marks=pytest.mark.slow),
    ],
)
def test_nothing_is_cut_off_and_no_words_overlap(measure, laws):
    fig = figure(study(laws=laws), measure)
    with matplotlib.rc_context(PRINT):
        assert [each for each in crowded(fig) if each[1] != "is flat"] == []  # as a colour bar is


def test_laws_stand_side_by_side_in_one_scale():
    dataset = study(laws=["exponential", "lugre"])
    dataset["mean_velocity"][1] *= 3.0
    fig = figure(dataset)
    first, second, _ = fig.axes
    assert [ax.get_title("left") for ax in (first, second)] == ["exponential", "lugre"]
    a, b = (meshes(ax)["values"] for ax in (first, second))
    assert (a.norm.vmin, a.norm.vmax) == (b.norm.vmin, b.norm.vmax)
    assert legend_of(fig)[1] == "failed: not finite 24, too many events 2"
    assert "exponential friction" not in fig.texts[1].get_text()


def test_further_axes_are_fixed_at_the_nearest_value():
    dataset = study(laws=["exponential", "lugre"])
    view = study_view(dataset, at={TORQUE: "1.5", LAW: "lugre"})
    assert [axis.path for axis in view.axes] == [MASS]
    assert len(view.panels) == 1
    np.testing.assert_array_equal(view.panels[0].values, dataset["mean_velocity"][1, :, 5])
    setting = view.setting.replace("\N{NO-BREAK SPACE}", " ")
    assert "lugre friction" in setting
    assert "$h$ = 1.473" in setting


@pytest.mark.parametrize(
    ("options", "expected"),
    [
        ({"measure": "mean_velocty"}, "--measure: the study has no 'mean_velocty'; did you mean 'mean_velocity'?"),
        (
            {"at": {"drive.amplitud": "1"}},
            "--at drive.amplitud: is no axis of the study; did you mean 'drive.amplitude'?",
        ),
        ({"at": {TORQUE: "7"}}, "--at drive.amplitude: should be a number from 0.2 to 3, got '7'"),
        ({"at": {TORQUE: "many"}}, "--at drive.amplitude: should be a number from 0.2 to 3, got 'many'"),
        ({"at": {TORQUE: "nan"}}, "--at drive.amplitude: should be a number from 0.2 to 3, got 'nan'"),
        ({"at": {LAW: "lugr"}}, "--at friction.law: has no 'lugr'; did you mean 'lugre'?"),
        ({"at": {TORQUE: "1", MASS: "1"}}, "--at: leaves no axis of numbers"),
    ],
)
def test_view_that_a_study_does_not_offer(options, expected):
    with pytest.raises(Refusal, match=re.escape(expected)):
        study_view(study(laws=["exponential", "lugre"]), **options)


def test_too_many_axes_are_asked_to_be_fixed():
    dataset = xarray.concat([study()] * 9, xarray.Variable("machine.damping", np.arange(9.0)))
    with pytest.raises(
        Refusal, match=r"machine\.damping: 9 values from 0 to 8; .*--at|--at.*machine\.damping: 9 values"
    ):
        study_view(dataset)
    few = study_view(dataset.isel({"machine.damping": [0, 4]}))
    assert [panel.title for panel in few.panels] == ["damping 0", "damping 4"]


def test_one_axis_gives_lines_with_open_marks_where_unsettled():
    dataset = study(laws=["exponential", "lugre"]).isel({TORQUE: 3})
    ax = figure(dataset).axes[0]
    lines = {line.get_label(): line for line in ax.lines}
    np.testing.assert_array_equal(lines["lugre"].get_ydata(), dataset["mean_velocity"][1])
    assert len(lines["exponential not settled"].get_xdata()) == 4
    assert lines["exponential not settled"].get_markerfacecolor() == "white"
    assert lines["exponential settled"].get_markerfacecolor() != "white"
    words = legend_of(figure(study().isel({TORQUE: 6})))
    assert any(text.startswith("failed: not finite 3") for text in words)
    assert any(text.startswith("no travel, |⟨X′⟩| ≤ 1.6e-06") for text in words)


def test_one_axis_with_words_names_them_upright():
    ax = figure(study().isel({TORQUE: 0}), "mode_sequence").axes[0]
    assert {label.get_text() for label in ax.get_yticklabels()} == set(
        np.unique(study()["mode_sequence"].values[:, 0][study()["status"].values[:, 0] == 0])
    )


def test_design_is_drawn_as_dots():
    flat = study().stack(run=(MASS, TORQUE)).reset_index("run")
    fig = figure(flat)
    dots = {collection.get_label(): collection for collection in fig.axes[0].collections}
    assert len(dots["failed"].get_offsets()) == 13
    assert len(dots["not settled"].get_offsets()) == 20
    assert len(dots["values"].get_offsets()) == 192 - 13 - 6 - 12
    assert legend_of(fig)[1] == "failed: not finite 12, too many events 1"


def test_picture_is_the_same_each_time(tmp_path):
    paths = [plot_view(study_view(study()), tmp_path / f"{number}.svg") for number in range(2)]
    assert paths[0].read_bytes() == paths[1].read_bytes()


@pytest.mark.parametrize(("low", "high"), [(0.2, 8.0), (1.1, 1.9), (0.3, 200.0), (1e-3, 1e4)])
def test_ticks_of_a_logarithmic_axis_do_not_run_into_each_other(low, high):
    fig = blank_figure((3.4, 3.0))
    ax = fig.add_subplot()
    ax.set_xlim(low, high)
    logarithmic(ax, "x")
    fig.canvas.draw()
    labels = [label for label in (*ax.get_xticklabels(), *ax.get_xticklabels(minor=True)) if label.get_text()]
    boxes = [label.get_window_extent() for label in labels if low <= label.get_position()[0] <= high]
    assert len(boxes) >= 3
    for one, other in itertools.pairwise(sorted(boxes, key=lambda box: box.x0)):
        assert one.x1 < other.x0
