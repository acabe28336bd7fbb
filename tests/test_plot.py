"""plot and figure: one way to a picture of any result, into axes that are given, without a trace in the session."""

import matplotlib
import matplotlib.font_manager
import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.figure import Figure

import vibrocap as vc
from vibrocap.motion.status import Status
from vibrocap.plotting.animation import ARROW, CONTACT, EDGE, OUTLINE, Scene
from vibrocap.plotting.histories import Trace, hides_lift_off
from vibrocap.plotting.look.labels import filled, parts_title, quantity_label, symbol_text
from vibrocap.quantities.dimensional import computed

SYSTEM = vc.System(vc.PendulumCapsule(), vc.Exponential(), vc.Harmonic())
PANELS = [
    *(("motion", what) for what in (None, "velocity", "drive_work", "side", "phase plane", "friction loop", "load")),
    ("orbit", None),
    *(("branch", what) for what in (None, "drift", "period", "multipliers")),
    *(("fit", what) for what in (None, "intervals", "one")),
    *(("map", what) for what in (None, "mode_sequence")),
    ("line", None),
    *(("basins", what) for what in (None, "attractor")),
    *(("law", what) for what in (None, "presliding")),
]


@pytest.fixture(scope="module")
def results():
    orbit = vc.orbit(SYSTEM, initial={"angle": 1.0})
    time = np.linspace(0.0, 10.0, 300)
    velocity = 0.3 * np.sin(time)
    force = 0.2 * np.tanh(velocity / 0.01) + 0.01 * np.sin(40.0 * time)
    over = {"machine.mass_ratio": [1.0, 2.0, 3.0], "drive.amplitude": [1.0, 2.0]}
    study = vc.sweep(
        SYSTEM,
        over,
        measures=["mean_velocity", "mode_sequence"],
        periods=20,
        initial={"angle": 1.0},
        tolerance=1e-8,
        settle=0,
    )
    return {
        "motion": vc.simulate(SYSTEM, periods=6, initial={"angle": 1.0}),
        "orbit": orbit,
        "branch": vc.branch(SYSTEM, "machine.mass_ratio", (2.3, 2.6), orbit=orbit, points=6, step=0.05),
        "fit": vc.fit(vc.Record(name="one", time=time, velocity=velocity, force=force), vc.Coulomb(), starts=1),
        "map": study,
        "line": study.isel({"drive.amplitude": 0}),
        "basins": vc.basins(SYSTEM, ("angle", "velocity"), 4, settle_periods=60),
        "law": vc.LuGre(),
    }


@pytest.mark.parametrize(("kind", "what"), PANELS)
def test_a_panel_is_drawn_into_the_axes_that_are_given(results, kind, what):
    before = dict(matplotlib.rcParams)
    figure = Figure(figsize=(8, 4), layout="constrained")
    left, right = figure.subplots(1, 2)
    assert vc.plot(results[kind], what, ax=left) is left
    assert left.lines or left.collections or left.patches
    assert left.get_xlabel()
    assert not right.lines
    figure.canvas.draw()
    assert dict(matplotlib.rcParams) == before
    own = vc.plot(results[kind], what)
    assert isinstance(own, Axes)
    assert own.figure is not figure


def test_the_whole_sheet_is_what_the_command_line_writes(results, tmp_path):
    figure = vc.figure(results["branch"], tmp_path / "sheet.png")
    assert isinstance(figure, Figure)
    assert (tmp_path / "sheet.png").stat().st_size > 5000
    again = vc.figure(results["branch"], tmp_path / "again.png")
    assert again is not figure
    assert (tmp_path / "again.png").read_bytes() == (tmp_path / "sheet.png").read_bytes()


@pytest.mark.plain
def test_a_machine_without_a_position_is_drawn_by_the_place_of_what_rubs():
    """Gears, strings and clutches turn; `vc.plot(motion)` asked for a position that they have not."""
    clutch = vc.simulate(vc.System(vc.Clutch(), vc.Coulomb(), vc.Harmonic(0.3, 1.0)), periods=1)
    (line,) = [line for line in vc.plot(clutch).lines if len(line.get_xdata()) > 2]
    assert line.get_ydata()[-1] == clutch["slip"][-1]


@pytest.mark.slow
def test_pyplot_stays_out_of_it():
    import subprocess
    import sys

    script = "import sys, vibrocap as vc; vc.figure(vc.LuGre()); assert 'matplotlib.pyplot' not in sys.modules"
    subprocess.run([sys.executable, "-c", script], check=True, timeout=120)


def test_a_notebook_shows_what_is_returned(results):
    """A figure, and axes of its own, without being told of Matplotlib; axes that were given stay as they were."""
    pictures = {getattr(drawn(results["law"]), "_repr_png_")() for drawn in (vc.figure, vc.plot)}  # noqa: B009
    assert [picture[:4] for picture in pictures] == [b"\x89PNG", b"\x89PNG"]
    assert not hasattr(vc.plot(results["law"], ax=Figure().subplots()), "_repr_png_")


def test_what_cannot_be_drawn_is_refused_by_name(results):
    for kind, what, words in (
        ("motion", "velocty", "a motion has no 'velocty'; did you mean 'velocity'"),
        ("branch", "velocity", "what: 'velocity' cannot be drawn of it; did you mean 'mean_velocity'"),
        ("fit", "two", "the fit has no 'two'; did you mean|there is one"),
        ("basins", "area", "what should be direction or attractor, got 'area'"),
        ("law", "loop", "what: 'loop' cannot be drawn of it"),
    ):
        with pytest.raises(ValueError, match=words):
            vc.plot(results[kind], what)
    for function in (vc.plot, vc.figure):
        with pytest.raises(TypeError, match="result should be"):
            function(7)


def test_style_is_a_context():
    before = dict(matplotlib.rcParams)
    with vc.style({"font.size": 13}):
        assert matplotlib.rcParams["font.size"] == 13
        assert matplotlib.rcParams["axes.titlelocation"] == "left"
        assert matplotlib.rcParams["mathtext.fontset"] == "dejavusans"
    assert dict(matplotlib.rcParams) == before


# --- what is drawn ----------------------------------------------------------------------------------------------------
def test_friction_is_drawn_from_pieces_and_not_across_jumps(results):
    """Of a contact that sticks, no line leads from sliding one way to sliding the other."""
    motion = results["motion"]
    ax = vc.plot(motion, "friction loop")
    eta = SYSTEM.friction.static_coefficient
    for line in ax.lines:
        velocity, friction = np.asarray(line.get_xdata()), np.asarray(line.get_ydata())
        joined = np.isfinite(friction[1:]) & np.isfinite(friction[:-1])
        assert not np.any(joined & (np.abs(np.diff(friction)) > 0.5 * eta)), line.get_label()
        if line.get_label() == "stuck":
            assert np.all(velocity[np.isfinite(velocity)] == 0.0)
        else:
            sliding = np.abs(velocity) > 1e-12
            assert np.all((velocity * friction)[sliding & np.isfinite(friction)] > 0.0)


def test_a_trace_has_both_ends_of_every_piece(results):
    motion = results["motion"]
    trace = Trace(motion, 0.0, motion.end)
    for event, state in zip(motion.event_times, motion.event_states, strict=True):
        at = np.abs(trace.time - event) < 1e-9
        assert at.sum() >= 2
        np.testing.assert_allclose(trace["angle"][at], state[0], atol=1e-8)
    friction = trace["friction"]
    jumps = np.abs(np.diff(friction)) > 0.1
    assert jumps.any()
    assert np.all(np.diff(trace.time)[jumps] < 1e-9)  # jumps stand upright
    np.testing.assert_allclose(trace["drive_work"], motion.at(trace.time, "drive_work"), rtol=1e-12, atol=1e-12)


# --- the load ---------------------------------------------------------------------------------------------------------
@pytest.fixture(scope="module")
def loaded():
    """A load that follows the motion, one that ends it, and a constant one that hides that end."""

    def moved(load, ratio, periods):
        drive = vc.Biharmonic(amplitude=1.8, frequency=1.0, second_amplitude=0.4)
        system = vc.System(vc.PendulumCapsule(mass_ratio=ratio, normal_load=load), vc.Exponential(), drive)
        return vc.simulate(system, periods=periods, initial={"angle": 0.2})

    return {"dynamic": moved("dynamic", 2.5, 3), "ended": moved("dynamic", 0.5, 3), "hidden": moved("weight", 0.5, 3)}


def lines_of(ax):
    return {line.get_label(): np.asarray(line.get_xydata()) for line in ax.lines}


@pytest.mark.plain
def test_lift_off_is_marked_where_it_is(loaded):
    motion = loaded["ended"]
    assert motion.run_status is Status.LIFT_OFF
    for what in ("load", "position", "friction"):
        mark = lines_of(vc.plot(motion, what))["lift off"]
        assert np.all(mark[:, 0] == motion.end / motion.period)
    assert "lift off" not in lines_of(vc.plot(loaded["dynamic"], "load"))


@pytest.mark.plain
def test_a_constant_load_is_drawn_beside_the_true_one(loaded):
    motion = loaded["hidden"]
    ax = vc.plot(motion, "load")
    assert np.all(lines_of(ax)["constant load"][:, 1] == 1.5)
    true = lines_of(ax)["true load"][:, 1]
    assert true.min() < -2.0
    assert any(len(line) == 2 and np.all(line[:, 1] == 0.0) for line in lines_of(ax).values())
    (pulling,) = ax.collections
    heights = np.concatenate([path.vertices[:, 1] for path in pulling.get_paths()])
    assert heights.min() == true.min()
    assert heights.max() == 0.0


@pytest.mark.plain
def test_sheet_shows_the_load_where_it_matters(loaded):
    usual = vc.simulate(SYSTEM, periods=1)
    assert [hides_lift_off(motion) for motion in (*loaded.values(), usual)] == [False, False, True, False]
    for motion, there in ((loaded["hidden"], True), (usual, False)):
        titles = [ax.get_title(loc="left") for ax in vc.figure(motion).axes]
        assert ("Load" in titles) is there
        assert len(titles) == 7 + there


@pytest.mark.plain
def test_one_inner_coordinate_beside_several_contacts_keeps_its_own_symbol():
    motion = vc.simulate(vc.System(vc.TwoBodyCrawler(), vc.Coulomb(), vc.Harmonic(1.2, 1.3)), periods=2)
    labels = [ax.get_ylabel() for ax in vc.figure(motion).axes]
    assert labels[1:4] == ["displacement $z$", "velocity $v_i$", "friction force $R_i$"]


@pytest.mark.plain
def test_the_sheet_of_a_servo_shows_how_it_comes_to_rest():
    """Not the rest: from the start until a quarter after all states are within 1e-3 of their ranges of the end."""
    servo = vc.PositionPID(proportional_gain=20.0, derivative_gain=6.0, limit=5.0)
    system = vc.System(vc.Oscillator(stiffness=0.0), vc.Coulomb(0.2, 0.3), vc.Constant(1.0), controller=servo)
    motion = vc.simulate(system, periods=30)
    panels = {ax.get_title(loc="left"): ax for ax in vc.figure(motion).axes}
    assert [*panels] == [
        "Place over the whole run", "Block", "Contact", "Controller", "Actuator", "Friction, detail",
    ]  # fmt: skip
    assert panels["Actuator"].get_xlabel() == r"time $\tau$"  # nothing drives it in periods
    low, high = panels["Contact"].get_xlim()
    assert low == motion.start_time
    still = motion.time > low + (high - low) / 1.25 + motion.period / 128
    for name in motion.state_names:
        assert np.ptp(motion[name][still]) <= 1e-3 * np.ptp(motion[name])
    assert panels["Controller"].get_ylabel() == "error $r -$ $x$"
    error = panels["Controller"].lines[0].get_ydata()
    assert error[[0, -1]] == pytest.approx([1.0, 1.0 - motion.state["position"]], abs=1e-9)
    assert np.max(np.abs(panels["Actuator"].lines[0].get_ydata())) == pytest.approx(5.0, abs=1e-13)
    assert panels["Actuator"].get_legend_handles_labels()[1] == ["limit"]
    assert panels["Place over the whole run"].get_legend_handles_labels()[1] == ["reference", "detail"]
    assert {line.get_label() for line in panels["Friction, detail"].lines} >= {"stuck", "accelerating", "decelerating"}


@pytest.mark.slow
def test_impacts_are_marked_under_the_velocity():
    motion = vc.simulate(
        vc.System(vc.OscillatorWithStops(restitution=0.7), vc.Coulomb(0.3, 0.4), vc.Harmonic()), periods=8
    )
    struck = [event.time / motion.period for event in motion.events if event.kind == "impact"]
    (marks,) = [line for ax in vc.figure(motion).axes for line in ax.lines if line.get_label() == "impact"]
    assert marks.get_xdata() == pytest.approx([time for time in struck if time > 4])
    assert struck[-1] > 4


@pytest.mark.plain
def test_modes_are_explained_as_far_as_they_occur():
    motion = vc.simulate(vc.System(vc.TwoBodyCrawler(), vc.Coulomb(0.01, 0.01), vc.Harmonic(amplitude=3.0)), periods=3)
    (ax,) = [ax for ax in vc.figure(motion).axes if ax.get_title(loc="left") == "Modes"]
    numbers = {
        int(each.side) for contact in (1, 2) for each in motion.phases_of(contact) if each.end > motion.start_time
    }
    words = [text.get_text() for text in ax.get_legend().get_texts()]
    assert words == [word for side, word in ((1, "forward"), (0, "stuck"), (-1, "back")) if side in numbers]
    assert len(words) == 2


@pytest.mark.plain
def test_machine_without_a_known_load_is_refused():
    motion = vc.simulate(vc.System(vc.Oscillator(), vc.Exponential(), vc.Harmonic()), periods=1)
    with pytest.raises(ValueError, match="the oscillator does not define its load"):
        vc.plot(motion, "load")


@pytest.mark.plain
def test_film_shows_the_load(loaded):
    motion = loaded["hidden"]
    load = motion.at(motion.time, "reaction")
    times = motion.time[[int(np.argmax(load)), int(np.argmin(load))]]
    scene = Scene(motion, times)
    for number, (value, words) in enumerate(((load.max(), "true normal load"), (load.min(), "have to pull"))):
        scene.show(number)
        (x, start), (_, tip) = scene.arrows[1]._posA_posB
        assert x == pytest.approx(scene.position[number] - scene.camera[number])
        length = ARROW * value / np.abs(load).max()  # upwards to the ground, or down from it
        assert (start, tip) == pytest.approx((-length, 0.0) if value > 0.0 else (0.0, length))
        assert words in scene.load_words.get_text()
        assert f"{value:.3f}" in scene.load_words.get_text()
        assert "taken as 1.5" in scene.load_words.get_text()
    ended = loaded["ended"]
    scene = Scene(ended, np.array([0.0, ended.end]))
    scene.show(1)
    assert scene.state.get_text() == "ends: lift off"
    assert "= 0.000" in scene.load_words.get_text()


def colours_of_soles(scene):
    """The colours of the lines where shapes touch the ground, in the order of the contacts."""
    return [line.get_color() for line in scene.axes.lines if line.get_linewidth() == 6]


def test_a_film_colours_a_contact_by_its_mode(results):
    """Each mode in a frame of its own; colour and words agree."""
    motion = results["motion"]
    last = {phase.side: phase for phase in motion.phases_of(1)}
    assert set(last) == set(CONTACT)
    scene = Scene(motion, np.array([0.5 * (phase.start + phase.end) for phase in last.values()]))
    for number, side in enumerate(last):
        scene.show(number)
        colour, words = CONTACT[side]
        assert colours_of_soles(scene) == [colour]
        assert (scene.state.get_text(), scene.state.get_color()) == (words, colour)
    assert len({colour for colour, _ in CONTACT.values()}) == len(CONTACT)


SLOPE = 0.3


@pytest.fixture(scope="module")
def uphill():
    machine = vc.PendulumCapsule(normal_load="dynamic")
    system = vc.System(machine, vc.Exponential(), vc.Harmonic(), environment=vc.Environment(inclination=SLOPE))
    return vc.simulate(system, periods=2, initial={"angle": 0.5})


@pytest.mark.plain
def test_film_shows_a_slope_as_one(uphill):
    scene = Scene(uphill, np.linspace(0.2, 0.9, 4) * uphill.end)
    ground = scene.axes.lines[0]
    ends = scene.axes.transData.inverted().transform(ground.get_transform().transform(ground.get_xydata()))
    rise = np.diff(ends, axis=0)[0]
    assert np.arctan2(rise[1], rise[0]) == pytest.approx(SLOPE, rel=1e-12)  # uphill to the right, as it is forward
    assert f"inclined by {np.degrees(SLOPE):.3g}°" in [text.get_text() for text in scene.axes.texts][-1]


@pytest.mark.plain
def test_no_number_of_the_ground_stands_under_an_arrow(uphill):
    times = np.linspace(0.0, 0.99, 40) * uphill.end
    scene = Scene(uphill, times)
    hidden = 0
    for number in range(len(times)):
        scene.show(number)
        arrow = scene.arrows[1].get_window_extent()
        for label in scene.numbers:
            if label.get_visible():
                assert not label.get_window_extent().overlaps(arrow)
            elif abs(label.get_position()[0]) < EDGE * scene.half:
                hidden += 1
    assert 0 < hidden <= len(times)


@pytest.mark.plain
def test_what_a_film_draws_does_not_grow_with_the_travel():
    """Of a block that slides on and on: as many numbers of the ground as of one that stays, and the right ones."""
    system = vc.System(vc.Oscillator(), vc.Coulomb(0.1, 0.1), vc.Harmonic(amplitude=0.3))
    near = vc.simulate(system, periods=2)
    far = vc.simulate(system, periods=2, initial={"position": 1e5})
    wide = vc.simulate(system.with_parameters({"drive.amplitude": 30.0}), periods=2)
    scenes = [Scene(each, np.linspace(0.0, 0.99, 4) * each.end) for each in (near, far, wide)]
    assert len(scenes[1].numbers) < 200
    for scene in scenes:
        scene.show(1)
        labels = [(number.get_position()[0], number.get_text()) for number in scene.numbers]
        for place, text in labels:
            assert float(text) == pytest.approx(scene.length * (place + scene.camera[1]), rel=1e-3, abs=1e-9)
        extents = [number.get_window_extent() for number in scene.numbers if number.get_visible()]
        frame, words = scene.figure.bbox, scene.small_print.get_window_extent()
        assert not any(extent.overlaps(words) or extent.x0 < frame.x0 or extent.x1 > frame.x1 for extent in extents)


@pytest.mark.plain
def test_a_film_follows_a_bit_that_turns_with_its_table():
    """Ground and camera are those of the bit, whose angle is that of the table and both twists, period after period."""
    machine = vc.DrillString()
    motion = vc.simulate(vc.System(machine, vc.Coulomb(0.1, 0.1), vc.Harmonic(0.3, 0.5)), periods=3)
    times = np.linspace(0.2, 0.9, 9) * motion.end
    scene = Scene(motion, times)
    expected = machine.table_speed * times + motion.at(times, "twist") + motion.at(times, "twist_2")
    assert scene.soles[0] == pytest.approx(expected, rel=1e-12)
    scene.show(8)
    assert scene.clock.get_text().endswith(" rad")
    (left, right), x = scene.axes.get_xlim(), scene.soles[0] - scene.camera
    assert np.all((left < x) & (x < right))


@pytest.mark.plain
def test_film_of_a_case_in_si_is_in_seconds():
    scales = vc.PendulumScales(pendulum_mass_kg=0.2, pendulum_length_m=0.25)
    motion = vc.simulate(
        vc.System(SYSTEM.machine, SYSTEM.friction, SYSTEM.drive, units=scales), periods=2, initial={"angle": 0.5}
    )
    scene = Scene(computed(motion), np.array([0.5, 0.75]) * computed(motion).end)
    scene.show(1)
    time, place = scene.clock.get_text().splitlines()[:2]
    assert time == f"time $t$ = {0.75 * motion.end:.3f} s"  # a thousandth of the period is seen
    shown = float(place.removeprefix("position $X$ = ").removesuffix(" m"))
    assert abs(shown - scene.position[1] * 0.25) <= 0.5e-3 * 0.25 * np.ptp(scene.position)


@pytest.mark.slow
def test_loads_and_rests_of_every_contact_are_drawn():
    """Panels and films knew those of contact 1."""
    system = vc.System(vc.LinkageCrawler(stiffness=4.0), [vc.Coulomb(0.2, 0.3), vc.Coulomb()], vc.Harmonic(1.2, 1.3))
    motion = vc.simulate(system, periods=3)
    drawn = [line.get_ydata() for line in vc.draw_load(motion).lines if len(line.get_ydata()) > 2]
    names = ("reaction", "reaction_2")
    at = np.linspace(motion.start_time, motion.end, 20_001)  # loads jump, between the times of the grid
    assert [np.max(each) for each in drawn] == pytest.approx([np.max(motion.at(at, name)) for name in names], rel=1e-3)
    panels = [vc.draw_history(motion, name, periods=2) for name in ("friction", "friction_2", "velocity_2")]
    shaded = [sum(patch.get_width() for patch in panel.patches) * motion.period for panel in panels]
    start, rests = (
        motion.period,
        [[p for p in motion.phases_of(i) if p.side == 0 and p.end > motion.period] for i in (1, 2)],
    )
    lasted = [sum(phase.end - max(phase.start, start) for phase in rest) for rest in rests]
    assert shaded == pytest.approx([*lasted, lasted[1]], rel=1e-9)
    assert abs(lasted[0] - lasted[1]) > 0.01
    scene = Scene(motion, np.array([1.0, 2.0]))
    scene.show(1)
    sizes = [np.ptp([y for _, y in arrow._posA_posB]) / scene.load_size for arrow in scene.arrows.values()]
    assert sizes == pytest.approx([motion.at([2.0], name)[0] for name in names], rel=1e-12)
    assert "N_2" in scene.load_words.get_text()
    scene = Scene(motion, np.linspace(1.0, motion.end, 40))
    places = np.concatenate([(shape.points[:, 0] - scene.camera).ravel() for shape in scene.shapes])
    assert np.min(places) == pytest.approx(-np.max(places), abs=1e-12)  # bodies side by side are seen in the middle
    sides = np.array([scene.sides[0], scene.sides[1]]).astype(int)
    assert np.any(sides[0] != sides[1])
    for number in np.flatnonzero(sides[0] != sides[1]):
        scene.show(number)
        modes = [CONTACT[side] for side in sides[:, number]]
        assert colours_of_soles(scene) == [colour for colour, _ in modes]
        assert scene.state.get_text() == ", ".join(f"{i} {words}" for i, (_, words) in enumerate(modes, start=1))
        assert scene.state.get_color() == OUTLINE


def test_symbols_are_set_as_mathematics():
    for symbol, text in (
        ("eta_c", r"$\eta_{c}$"), ("delta0", r"$\delta_{0}$"), ("lambda", r"$\lambda$"), ("h", "$h$"),
        ("k_fwd", r"$k_{\mathrm{fwd}}$"), ("theta'", r"$\theta'$"), ("", ""), ("sgn v", "sgn v"),
    ):  # fmt: skip
        assert symbol_text(symbol) == text
    assert "\N{MINUS SIGN}0.4" in parts_title([vc.Constant(force=-0.4)], 8.0)
    assert "_c =" not in parts_title([vc.Exponential()], 8.0)


def test_lines_are_filled_by_what_is_seen():
    words = " ".join(["$\\eta_{c}$\N{NO-BREAK SPACE}=\N{NO-BREAK SPACE}0.15,"] * 8)
    assert len(filled(r"$\eta_{c}$ " * 30, 40).splitlines()) == 3  # 30 symbols of two letters
    assert filled("one two three", 7) == "one two\nthree"
    assert filled(words, 200) == words


def test_parameters_stand_above_branches_without_the_one_that_varies(results):
    title = vc.figure(results["branch"])._suptitle.get_text()
    assert r"\nu" in title
    assert r"\eta_{c}" in title
    assert r"\lambda" not in title


def test_presliding_loops_are_named_by_amplitude():
    ax = vc.plot(vc.LuGre(), "presliding")
    words = [text.get_text() for text in ax.get_legend().get_texts()]
    largest = max(np.max(line.get_xdata()) for line in ax.lines)
    assert float(words[0].removeprefix("$A$ = ")) == pytest.approx(largest, rel=0.01)
    assert len(words) == len({line.get_color() for line in ax.lines})


def test_narrow_intervals_are_seen_beside_wide_ones(results):
    ax = vc.plot(results["fit"], "intervals")
    left, right = ax.get_xlim()
    whole = ax.transData.transform([(left, 0.0), (right, 0.0)])[:, 0]
    for p in results["fit"].parameters:
        width = np.diff(ax.transData.transform([(100.0 * (end / p.value - 1.0), 0.0) for end in (p.low, p.high)])[:, 0])
        assert width > 0.05 * np.diff(whole), p.name


def test_cases_of_a_list_are_counted_in_whole_numbers():
    cases = [{"machine.mass_ratio": x} for x in (1.0, 2.0, 3.0)]
    study = vc.sweep(SYSTEM, cases=cases, periods=10, initial={"angle": 1.0}, tolerance=1e-8, settle=0)
    ax = vc.plot(study)
    ax.figure.canvas.draw()
    assert all(float(tick).is_integer() for tick in ax.get_xticks())


@pytest.mark.slow
def test_nothing_is_drawn_across_an_impact_in_the_friction_loop():
    machine = vc.PendulumCapsuleWithStops(limit_angle=0.8, restitution=0.6)
    motion = vc.simulate(vc.System(machine, vc.Exponential(), vc.Harmonic()), periods=6, initial={"angle": 0.5})
    assert any(event.kind == "impact" for event in motion.events if event.time > 5 * motion.period)
    lines = [line for line in vc.draw_friction_loop(motion).lines if line.get_label() != "stuck"]
    for line in lines:
        velocity = np.asarray(line.get_xdata(), dtype=float)
        assert not np.any(velocity[1:] * velocity[:-1] < -1e-12)  # friction jumps at rest: no line leads across


@pytest.mark.slow
def test_the_sheet_of_a_crawler_shows_every_contact():
    """As a line of its own each, with the modes of all in strips that change where its events are."""
    drive, front = vc.Biharmonic(1.5, 0.8, 0.7, 0.5), vc.Coulomb(0.1, 0.15)
    system = vc.System(vc.ThreeBodyCrawler(), [vc.Coulomb(0.3, 0.45), front, front], drive)
    motion = vc.simulate(system, periods=3)
    fig = vc.figure(motion)
    named = {title: ax for ax in fig.axes if (title := ax.get_title(loc="left"))}
    assert list(named)[:5] == ["Travel of body 1 over the whole run", "Displacements", "Bodies", "Contacts", "Modes"]
    for title, names in (("Bodies", ("velocity", "velocity_2", "velocity_3")), ("Displacements", ("displacement",))):
        for line, name in zip(named[title].lines, names, strict=False):
            time, value = np.asarray(line.get_xdata()) * motion.period, np.asarray(line.get_ydata())
            inside = np.min(abs(time[:, None] - np.append(motion.piece_start, motion.end)), axis=1) > 1e-6
            assert value[inside] == pytest.approx(motion.at(time[inside], name), abs=1e-12)
    assert "velocity $v_2$" not in [ax.get_ylabel() for ax in fig.axes]  # over a gap, of which it is not the rate
    for title in ("Contacts", "Friction, last period"):
        assert [line.get_label() for line in named[title].lines][:3] == ["1", "2", "3"]
    strips = named["Modes"].collections
    for contact in (1, 2, 3):
        own = [strip.get_paths()[0].get_extents() for strip in strips]
        starts = [box.x0 * motion.period for box in own if abs(0.5 * (box.y0 + box.y1) - contact) < 0.1]
        assert starts == pytest.approx([phase.start for phase in motion.phases_of(contact)], abs=1e-9)
    assert set(vc.mode_sequence(motion, contact=2)) <= set("FSB")
    velocity = np.concatenate([np.asarray(line.get_xdata()) for line in vc.draw_friction_loop(motion, contact=3).lines])
    at = motion.time > motion.end - motion.period
    assert np.nanmax(velocity) == pytest.approx(motion["velocity_3"][at].max(), abs=1e-3)
    for contact in (0, 4):
        with pytest.raises(ValueError, match=f"contact should be a whole number from 1 to 3, got {contact}"):
            vc.draw_friction_loop(motion, contact=contact)
        with pytest.raises(ValueError, match=f"contact should be a whole number from 1 to 3, got {contact}"):
            vc.mode_sequence(motion, contact=contact)


@pytest.mark.slow
def test_a_settled_sheet_says_so_and_shows_the_whole_response():
    """Of a motion that repeats after two periods the planes close; what does not settle is said not to."""
    row = vc.read_case("examples/three-blocks-shaken-on-a-belt.toml").simulate()
    fig = vc.figure(row)
    assert fig._supxlabel.get_text().endswith("Settled from period 20 on; it repeats every 2 periods.")
    panels = {ax.get_title(loc="left"): ax for ax in fig.axes}
    (mark,) = [line for line in panels["Place over the whole run"].lines if line.get_label() == "settled"]
    assert mark.get_xdata() == [20.0, 20.0]
    assert [line.get_label() for line in panels["Bodies"].lines][:3] == ["1", "2", "3"]
    for line in panels["Friction, last 2 periods"].lines[:3]:
        assert np.nanmax(line.get_xdata()) == pytest.approx(
            row["sliding_velocity"][row.time > 58 * row.period].max(), abs=1e-3
        )
    assert "ettled" not in vc.figure(vc.simulate(SYSTEM, periods=3))._supxlabel.get_text()


def test_an_angle_that_turns_without_end_is_drawn_within_a_turn():
    rotor = vc.read_case("examples/vibration-motor-travels.toml").simulate()
    assert abs(rotor["angle"][-1]) > 100.0
    angle = vc.plot(rotor, "angle").lines[0].get_ydata()
    assert np.nanmax(np.abs(angle)) <= np.pi
    assert np.nanmax(np.abs(np.diff(angle))) < np.pi


def test_the_waveform_of_a_signal_is_named_in_the_head():
    system = vc.read_case("examples/clutch-slips-twice.toml").system
    head = parts_title(system.parts, 10.0).replace("\xa0", " ")
    assert head.splitlines()[-1].startswith("Clamp, harmonic: $h$ = 0.3")


def test_a_velocity_over_what_moves_is_no_velocity_of_the_body():
    """A part on a feeder slides over its trough, under an imposed motion a capsule over the ground."""
    machines = vc.Feeder(), vc.PendulumCrawler()
    feeder, crawler = (vc.System(machine, vc.Coulomb(), vc.Harmonic()) for machine in machines)
    assert quantity_label("contact_velocity", feeder) == "sliding velocity $v$"
    assert quantity_label("contact_velocity", crawler) == "capsule velocity $X'$"
    imposed = vc.System(vc.TwoMassCrawler(), vc.Coulomb(), vc.Triangle())
    assert quantity_label("drive", imposed) == "imposed displacement $z$"


@pytest.mark.plain
def test_what_belongs_to_a_contact_has_the_name_of_its_body():
    """In the head, in legends and beside the strips of modes."""
    motion = vc.read_case("examples/plates-creep.toml", periods=6).simulate()
    lines = parts_title(motion.system.parts, 10.0).splitlines()
    assert [line.partition(":")[0] for line in lines] == [
        *("Stacked plates", "Lower plate, exponential", "Harmonic", "Upper plate, exponential")
    ]
    axes = {ax.get_title(loc="left"): ax for ax in vc.figure(motion).axes}
    both = ["lower plate", "upper plate"]
    for panel in ("Bodies", "Contacts", "Friction, last period"):
        assert [text.get_text() for text in axes[panel].get_legend().get_texts()] == both
    assert [label.get_text() for label in axes["Modes"].get_yticklabels()] == both
