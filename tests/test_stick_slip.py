"""Stick-slip in force records: a Coulomb block in closed form with noise, other motions, bad data, paper on paper."""

import dataclasses
import json
import math
import os
import re
from pathlib import Path

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter1d
from scipy.signal import lfilter

from vibrocap.arguments import Refusal
from vibrocap.cli.command import COMMANDS, perform
from vibrocap.cli.commands.stick_slip import StickSlipRequest
from vibrocap.records.pull import read_pulls
from vibrocap.records.record import RecordError
from vibrocap.records.regimes import HALF_STICK_RATIO, HALF_STICK_X, recurrence
from vibrocap.records.stick_slip import regime_diagram, slider_velocity, stick_slip, stick_slip_of

SHARED = Path(os.environ.get("VIBROCAP_DATA", Path(__file__).resolve().parents[2] / "shared" / "data"))
PAPER = SHARED / "paper-stick-slip"
shared = pytest.mark.skipif(not PAPER.is_dir(), reason="needs ../shared/data/paper-stick-slip")


def command(source, **options):
    """The exit code of the command; Refusal for wrong input."""
    return perform(COMMANDS["stick-slip"], StickSlipRequest(source=source, **options))


@dataclasses.dataclass(frozen=True)
class Belt:
    """A block on a belt with static and kinetic Coulomb friction, x = w D/V (docs/model.md)."""

    x: float
    static: float = 1.5
    kinetic: float = 1.0
    stiffness: float = 2.0
    mass: float = 0.5
    D = property(lambda self: (self.static - self.kinetic) / self.stiffness)
    w = property(lambda self: math.sqrt(self.stiffness / self.mass))
    speed = property(lambda self: self.w * self.D / self.x)
    stick = property(lambda self: 2.0 * self.D / self.speed)
    slip = property(lambda self: 2.0 / self.w * (math.pi - math.atan(self.x)))
    period = property(lambda self: self.stick + self.slip)
    fall = property(lambda self: 2.0 * (self.static - self.kinetic))
    known = property(lambda self: {"stiffness": self.stiffness, "mass": self.mass, "pulling_speed": self.speed})

    def record(self, noise=0.0, samples=200, periods=12, seed=0):
        """(time, force) with noise as a share of the fall; it begins 0.7 of a stick time before the first slip."""
        time = np.arange(periods * samples) * self.period / samples
        phase = (time + 0.3 * self.stick) % self.period
        swing = self.w * (phase - self.stick)
        rising = 2.0 * self.kinetic - self.static + self.stiffness * self.speed * phase
        falling = (self.static - self.kinetic) * np.cos(swing) + self.stiffness * self.speed / self.w * np.sin(swing)
        force = np.where(phase < self.stick, rising, self.kinetic + falling)
        return time, force + noise * self.fall * np.random.default_rng(seed).standard_normal(len(time))

    def starts(self, end):
        """Times at which slips begin that end before `end`."""
        begins = 0.7 * self.stick + self.period * np.arange(1000)
        return begins[begins + self.slip < end]


# --- a Coulomb block -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("x", "noise"), [(3.0, 0.0), (3.0, 0.1), (10.0, 0.03), (100.0, 0.01), (100.0, 0.1)])
def test_phases_levels_and_slips_of_a_coulomb_block(x, noise):
    belt = Belt(x)
    time, force = belt.record(noise, samples=400)
    analysis = stick_slip(time, force, **belt.known)
    starts = belt.starts(time[-1])
    assert analysis.regime.name == "stick-slip"
    assert not analysis.notes
    # What smoothing over the last half period hides of the last slip is no error.
    assert len(starts) - 1 <= len(analysis.slips) <= len(starts)
    assert analysis.noise == pytest.approx(noise * belt.fall, rel=0.1, abs=0.01)
    shape = 0.03 * belt.slip  # a parabola is fitted where a cosine is
    for slip, start in zip(analysis.slips, starts, strict=False):
        assert abs(slip.start - start) <= 4.5 * slip.start_error + shape
        assert abs(slip.end - start - belt.slip) <= 4.5 * slip.end_error + shape
        assert max(slip.start_error, slip.end_error) < (0.03 + 2.5 * noise) * belt.slip + 4 * (time[1] - time[0])
        assert not slip.minor
    number = math.sqrt(len(analysis.slips))
    assert analysis.period.mean == pytest.approx(belt.period, rel=0.002 + 0.1 * noise)
    assert analysis.slip_duration.mean == pytest.approx(
        belt.slip, abs=2 * shape + 2 * (time[1] - time[0]) + noise * 0.5
    )
    assert analysis.static_level.mean == pytest.approx(belt.static, abs=(0.01 + 0.4 * noise / number) * belt.fall)
    assert analysis.slip_end_level.mean == pytest.approx(
        2 * belt.kinetic - belt.static, abs=(0.01 + 0.4 * noise / number) * belt.fall
    )
    assert analysis.kinetic_level == pytest.approx(belt.kinetic, abs=(0.005 + 0.3 * noise / number) * belt.fall)
    assert analysis.kinetic_from == "mean of the extreme levels"
    travelled = 2 * belt.D + belt.speed * belt.slip
    assert analysis.slip.mean == pytest.approx(travelled, rel=0.005 + 0.3 * noise)
    assert analysis.stick_fraction == pytest.approx(belt.stick / belt.period, abs=0.05)
    assert analysis.loading_ratio == pytest.approx(1.0, abs=0.01 + noise)
    assert analysis.regime.inertial_period == pytest.approx(2 * math.pi / belt.w)


def test_period_without_phases():
    belt = Belt(8.0)
    time, force = belt.record(0.1)
    wandering = 5.0 * belt.fall * np.sin(2 * math.pi * time / (9.0 * belt.period))
    for level in (0.0, wandering):
        found = recurrence(force + level, time[1], 7)
        assert found.spectral_period == pytest.approx(belt.period, rel=0.02)
    found = recurrence(force, time[1], 7)
    assert found.correlation_period == pytest.approx(belt.period, rel=0.005)
    assert 0.96 < found.correlation <= 1.01  # not less for the products that a later lag lacks


def test_uncertainty_of_corners_is_the_scatter():
    """The stated errors of sixty slips, where noise and not shape or sampling decides."""
    belt = Belt(5.0)
    time, force = belt.record(0.03, samples=800, periods=60, seed=3)
    analysis = stick_slip(time, force, **belt.known)
    starts = belt.starts(time[-1])[: len(analysis.slips)]
    for off, stated in (
        (np.array([slip.start for slip in analysis.slips]) - starts, [slip.start_error for slip in analysis.slips]),
        (
            np.array([slip.end for slip in analysis.slips]) - starts - belt.slip,
            [slip.end_error for slip in analysis.slips],
        ),
        ([slip.start_force - belt.static for slip in analysis.slips], [slip.force_error for slip in analysis.slips]),
    ):
        assert 0.4 * np.mean(stated) < np.std(off) < 1.6 * np.mean(stated)


def test_spikes_turned_signs_and_coefficients_change_nothing():
    belt = Belt(10.0)
    time, force = belt.record(0.01, samples=600)
    plain = stick_slip(time, force, **belt.known)
    spiked = force.copy()
    spiked[np.random.default_rng(1).choice(len(time), 60, replace=False)] += 3.0
    analysis = stick_slip(time, spiked, **belt.known)
    assert analysis.spikes > plain.spikes + 50
    starts = np.array([slip.start for slip in analysis.slips])
    off = [np.abs(starts - slip.start).min() for slip in plain.slips]
    assert sum(each > 0.1 * belt.slip for each in off) <= 1  # a spike on a corner may hide it
    assert analysis.slip.mean == pytest.approx(plain.slip.mean, rel=0.02)
    turned = stick_slip(time, -force, **belt.known)
    assert turned.slip == plain.slip
    assert any("sign was turned" in note for note in turned.notes)
    over = stick_slip(time, force / 4.0, **belt.known, normal_force=4.0, coefficient=True)
    assert over.slip.mean == pytest.approx(plain.slip.mean, rel=1e-9)
    assert over.velocity == pytest.approx(plain.velocity)
    assert over.static_coefficient == over.static_level.mean == pytest.approx(plain.static_level.mean / 4.0)
    assert stick_slip(time, force, **belt.known, normal_force=4.0).kinetic_coefficient == over.kinetic_level
    gravity = stick_slip(time, force / 4.0, **belt.known, coefficient=True)
    assert gravity.normal_force == pytest.approx(belt.mass * 9.80665)


def test_minor_slips_are_marked_and_left_out():
    """Every third slip releases a fifth: the mean fall is 11/15, so these are minor and the others are not."""
    time = np.arange(0, 66.0, 0.01)
    force = 3.0 + time - np.floor(time / 2.2) * 2.2 - np.where(time % 2.2 > 1.0, 0.2, 0) - np.where(
        time % 2.2 > 1.2, 1.0, 0
    )  # fmt: skip
    force += 0.01 * np.random.default_rng(0).standard_normal(len(time))
    analysis = stick_slip(time, force)
    every = stick_slip(time, force, minor=0.0)
    assert all((0.1 < slip.fall < 0.3) if slip.minor else (0.9 < slip.fall < 1.1) for slip in analysis.slips)
    assert len(analysis.slips) == len(every.slips) == len(every.main_slips) > 1.4 * len(analysis.main_slips)
    assert analysis.period.mean > 1.4 * every.period.mean
    assert analysis.stick_fraction == every.stick_fraction


def test_overdamped_slider_stops_at_the_kinetic_level():
    """Without inertia the force relaxes to F_k within b/k and stays above it."""
    time = np.arange(0, 50.0, 0.005)
    phase = time % 5.0
    level = np.where(phase < 4.0, 1.0 + 0.125 * phase, 1.0 + 0.5 * np.exp(-(phase - 4.0) / 0.2))
    known = {"stiffness": 2.0, "mass": 0.002, "pulling_speed": 0.0625}
    analysis = stick_slip(time, level + 0.002 * np.random.default_rng(0).standard_normal(len(time)), **known)
    assert analysis.regime.name == "stick-slip"
    assert analysis.kinetic_from == "level at the end of the slip"
    assert analysis.kinetic_level == pytest.approx(1.0, abs=0.02)
    assert analysis.static_level.mean == pytest.approx(1.5, abs=0.01)


def test_slider_velocity_is_nothing_in_stick_and_the_belts_on_average():
    belt = Belt(10.0)
    time, force = belt.record()
    velocity = slider_velocity(time, force, belt.stiffness, belt.speed)
    phase = (time + 0.3 * belt.stick) % belt.period
    inside = (phase > 5 * time[1]) & (phase < belt.stick - 5 * time[1])
    assert np.abs(velocity[inside][3:]).max() < 1e-9
    assert velocity[:200].mean() == pytest.approx(belt.speed, rel=0.01)
    assert velocity.max() == pytest.approx(belt.speed * (1 + math.hypot(belt.x, 1)), rel=0.02)
    assert stick_slip(time, force, **belt.known).velocity.shape == time.shape


def test_uneven_sampling_is_interpolated():
    belt = Belt(10.0)
    time, force = belt.record(samples=2000)
    kept = np.arange(0, len(time) - 10, 10) + np.random.default_rng(0).integers(0, 8, len(time) // 10 - 1)
    analysis = stick_slip(time[kept], force[kept], **belt.known)
    assert analysis.period.mean == pytest.approx(belt.period, rel=0.005)
    assert analysis.slip.mean == pytest.approx(belt.speed * belt.period, rel=0.02)
    assert any("interpolated" in note for note in analysis.notes)


# --- regimes ---------------------------------------------------------------------------------------------------------
TIME = np.arange(10000) / 1000.0


@pytest.mark.parametrize(
    "colour",
    [
        lambda white: white,
        lambda white: gaussian_filter1d(white, 10),
        lambda white: lfilter([1], [1, -0.95], white),
        lambda white: np.round(3 * white),
    ],
    ids=["white", "filtered", "first order", "digitised"],
)
def test_noise_of_any_colour_is_steady(colour):
    analysis = stick_slip(TIME, 100.0 + colour(np.random.default_rng(0).standard_normal(len(TIME))))
    assert analysis.regime.name == "steady"
    assert analysis.phases == ()
    assert (analysis.period, analysis.slip, analysis.stick_fraction, analysis.kinetic_level) == (None,) * 4
    assert analysis.recurrence.correlation_period is None


@pytest.mark.parametrize("noise", [0.0, 0.03, 0.1])
def test_sine_at_the_inertial_period_is_inertial(noise):
    force = 5.0 + np.sin(2 * math.pi * TIME / 0.5) + 2 * noise * np.random.default_rng(0).standard_normal(len(TIME))
    stiffness = 200.0
    mass = stiffness * (0.5 / (2 * math.pi)) ** 2
    analysis = stick_slip(TIME, force, stiffness=stiffness, mass=mass, pulling_speed=0.1)
    assert analysis.regime.name == "inertial"
    assert analysis.regime.period_ratio == pytest.approx(1.0, rel=0.02)
    assert analysis.period.mean == pytest.approx(0.5, rel=0.01)
    assert analysis.kinetic_level == pytest.approx(5.0, abs=0.03 + noise)
    assert analysis.static_level is None
    assert not any(slip.minor for slip in analysis.slips)
    unknown = stick_slip(TIME, force)
    assert unknown.regime.name == "inertial"
    assert unknown.regime.period_ratio is None
    assert "not compared" in unknown.regime.reason
    assert any(note.startswith("mass and stiffness: not given") for note in unknown.notes)
    slow = stick_slip(TIME, force, stiffness=stiffness, mass=mass / 100)
    assert slow.regime.name == "slow oscillation"


def test_half_stick_is_the_root_it_is_said_to_be():
    assert pytest.approx(math.pi - math.atan(HALF_STICK_X), abs=1e-4) == HALF_STICK_X
    assert pytest.approx(1 + (HALF_STICK_X - math.atan(HALF_STICK_X)) / math.pi, abs=0.002) == HALF_STICK_RATIO


def test_regime_diagram_parts_blocks_where_they_stick_for_half_of_the_time():
    blocks = [Belt(x, stiffness=k, mass=0.5) for k in (2.0, 50.0) for x in (0.5, 1.3, 2.6, 8.0, 40.0)]
    analysis = [
        stick_slip(*block.record(0.01), **block.known, name=f"k{block.stiffness:g}_x{block.x:g}") for block in blocks
    ]
    diagram = regime_diagram(analysis)
    assert diagram.regimes == tuple("stick-slip" if block.x > HALF_STICK_X else "inertial" for block in blocks)
    assert diagram.period == pytest.approx([block.period for block in blocks], rel=0.02)
    half = Belt(HALF_STICK_X, stiffness=50.0, mass=0.5)
    assert diagram.border == pytest.approx(half.speed * math.sqrt(half.stiffness), rel=0.02)
    rows = diagram.table()
    assert [row["stiffness"] for row in rows] == [2.0] * 5 + [50.0] * 5
    assert [row["name"] for row in rows[:2]] == ["k2_x40", "k2_x8"]
    with pytest.raises(ValueError, match=r"analyses\[0\] \(record\): stiffness and pulling_speed"):
        regime_diagram([stick_slip(*blocks[0].record())])
    with pytest.raises(ValueError, match="at least one"):
        regime_diagram([])


# --- what cannot be told, and bad data -------------------------------------------------------------------------------


def test_what_is_not_given_is_not_told_and_said():
    belt = Belt(10.0)
    record = belt.record(0.01)
    bare = stick_slip(*record)
    assert bare.regime.name == "stick-slip"
    assert (bare.slip, bare.release, bare.velocity, bare.kinetic_level, bare.loading_ratio) == (None,) * 5
    assert [note.partition(":")[0] for note in bare.notes] == ["stiffness", "mass and stiffness", "mass and stiffness"]
    spring = stick_slip(*record, stiffness=belt.stiffness)
    assert spring.slip is None
    assert spring.release.mean == pytest.approx(2 * belt.D, rel=0.02)
    assert any(note.startswith("pulling_speed: not given") for note in spring.notes)
    over = stick_slip(*record, stiffness=belt.stiffness, pulling_speed=belt.speed, coefficient=True)
    assert over.release is None
    assert any(note.startswith("normal_force: not given") for note in over.notes)


def test_wrong_units_are_noticed():
    belt = Belt(10.0)
    time, force = belt.record(0.01)
    wrong = stick_slip(time, force, **belt.known | {"pulling_speed": 1000 * belt.speed})
    assert any("stick phases rise at 0.001 times k V" in note for note in wrong.notes)
    heavy = stick_slip(time, force, **belt.known | {"mass": 1000 * belt.mass})
    assert any("slips take 0.0" in note for note in heavy.notes)
    light = stick_slip(time, force, **belt.known, normal_force=2e-3)
    assert any("implies a friction coefficient of" in note for note in light.notes)
    assert not any("implies" in note for note in stick_slip(time, force, **belt.known, normal_force=2.0).notes)


def without(values, *gone):
    return np.delete(values, list(gone))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda t, f: (t, np.where(t == t[7], np.nan, f)), "force: 1 NaN of 2,400 values, the first at index 7"),
        (lambda t, f: (t, 0 * f + 3), "force: is 3 at all 2,400 samples"),
        (lambda t, f: (t[:1], f[:1]), "time: should have at least 8 samples, got 1 sample"),
        (lambda t, f: (t[:40], f[:40]), "time: should have at least 64 samples, got 40"),
        (lambda t, f: (t[::-1], f), "time: runs backwards at index 1"),
        (lambda t, f: (t, f[:-1]), "should have one force for each time"),
        (lambda t, f: (t, ["a"] * len(f)), "force: should be numbers, got list"),
        (lambda t, f: (without(t, *range(100, 140)), without(f, *range(100, 140))), "time: has a gap of"),
    ],
)
def test_bad_data_gets_a_message(change, message):
    with pytest.raises(RecordError, match="record 'pull' cannot be used") as caught:
        stick_slip(*change(*Belt(5.0).record()), name="pull")
    assert message in str(caught.value)


def test_every_bad_number_is_named_at_once():
    with pytest.raises(RecordError) as caught:
        stick_slip(*Belt(5.0).record(), stiffness=-1, mass=math.nan, pulling_speed="fast", minor=1, coefficient=2)  # type: ignore[arg-type]
    assert [complaint.partition(":")[0] for complaint in caught.value.complaints] == [
        *("stiffness", "mass", "pulling_speed", "coefficient", "minor")
    ]


# --- files, command, pictures ----------------------------------------------------------------------------------------


@pytest.fixture
def csv(tmp_path):
    belt = Belt(10.0)
    time, force = belt.record(0.01)
    path = tmp_path / "pull.csv"
    np.savetxt(path, np.c_[time, 1e3 * force], delimiter=",", header="time (s),force (mN)", comments="")
    return path


def test_command_prints_draws_and_writes_json(csv, tmp_path, capsys):
    belt = Belt(10.0)
    known = {"stiffness": belt.stiffness, "speed": belt.speed, "mass": belt.mass}
    assert command(csv, **known, json=True) == 0
    printed = json.loads(capsys.readouterr().out)
    assert printed["regime"]["name"] == "stick-slip"
    assert printed["period"]["mean"] == {"value": pytest.approx(belt.period, rel=0.01), "unit": "s"}
    assert printed["static_level"]["mean"] == {"value": pytest.approx(belt.static, rel=0.02), "unit": "N"}  # of mN
    assert printed["phases"][0]["kind"] == "slip"
    assert "force" not in printed
    picture = tmp_path / "pull.png"
    assert command(csv, **known, plot=picture) == 0
    text = capsys.readouterr().out
    assert "pull: stick-slip" in text
    assert f"picture    {picture}" in " ".join(text.split("\n"))
    assert picture.stat().st_size > 30_000


def test_file_of_several_records_gets_a_table_and_a_diagram(tmp_path, capsys):
    blocks = {f"x{x:g}": Belt(x, stiffness=2.0) for x in (0.5, 8.0)}
    path = tmp_path / "many.npz"
    step = 0.01
    arrays = {}
    for name, block in blocks.items():
        time, force = block.record(samples=400)
        arrays[name] = np.interp(np.arange(0, time[-1], step), time, force)
    np.savez(path, fs=1 / step, mass_kg=0.5, stiffness_N_per_m=2.0, **arrays)
    assert [pull.name for pull in read_pulls(path)] == ["x0.5", "x8"]
    assert read_pulls(path, "x8")[0].settings["stiffness"] == 2.0
    assert command(path, speed=0.1, plot=tmp_path / "map.svg") == 0
    text = capsys.readouterr().out
    assert "inertial" in text
    assert "stick-slip" in text
    assert "a Coulomb block" in (tmp_path / "map.svg").read_text() or (tmp_path / "map.svg").stat().st_size > 10_000
    with pytest.raises(Refusal, match="pulling_speed are needed"):
        command(path, plot=tmp_path / "map.svg")
    with pytest.raises(Refusal, match=r"there is no record 'x9'; there is 'x0\.5', 'x8'"):
        command(path, record="x9")


def test_command_names_all_that_is_wrong(csv, tmp_path):
    with pytest.raises(Refusal) as caught:
        command(csv, plot=tmp_path / "a.bmp", columns=["force"])
    assert "--plot: should end in" in str(caught.value)
    assert "--columns force: should be QUANTITY=NAME" in str(caught.value)
    with pytest.raises(Refusal, match="stiffness: should be a number greater than 0"):
        command(csv, stiffness=-1.0)
    with pytest.raises(Refusal, match="speed: should be a number greater than 0"):
        command(csv, speed=0.0)
    with pytest.raises(Refusal, match="no such file"):
        command(tmp_path / "none.csv")
    with pytest.raises(Refusal, match="no column 'F9'"):
        command(csv, columns=["force=F9"])
    with pytest.raises(Refusal, match="a stress"):
        command(csv, units=["force=Pa"])


def test_pictures_show_phases_levels_and_units():
    from vibrocap.plotting.stick_slip import regime_figure, stick_slip_figure

    belt = Belt(10.0)
    analysis = stick_slip(*belt.record(0.02), **belt.known)
    fig = stick_slip_figure(analysis)
    whole, detail, velocity, periods = (axes for part in fig.subfigs for axes in _axes(part))
    words = [text.get_text() for text in whole.get_legend().get_texts()]
    assert words[0] == f"slip ({len(analysis.slips)})"
    assert any(re.match(r"static level 1\.[45]", word) for word in words)
    assert whole.get_ylabel() == "force [N]"
    left, right = detail.get_xlim()
    shaded = [patch for patch in detail.patches if patch.get_width() > 0]
    assert sum(patch.get_width() for patch in shaded) == pytest.approx(
        (right - left) * belt.stick / belt.period, rel=0.1
    )
    assert velocity.get_ylabel() == "velocity [mm/s]"
    assert any("0.3" in text.get_text() or "mean" in text.get_text() for text in periods.get_legend().get_texts())
    noise = np.random.default_rng(0).standard_normal(len(TIME))
    steady = stick_slip_figure(stick_slip(TIME, 10.0 + noise))
    assert [axes.get_title(loc="left") for part in steady.subfigs for axes in _axes(part)] == ["The record", "Detail"]
    diagram = regime_figure(regime_diagram([analysis]))
    assert diagram.axes[0].get_xlabel() == "stiffness k [N/m]"
    assert len(diagram.axes[0].texts) == 1


def _axes(part):
    return [*part.axes, *(axes for below in part.subfigs for axes in _axes(below) if axes not in part.axes)]


# --- paper on paper --------------------------------------------------------------------------------------------------
FOUND = {  # regime, slips, main slips, period s of these, period by the spectrum s
    "k168_v42": ("stick-slip", 22, 18, 2.239, 2.00),
    "k168_v1100": ("stick-slip", 111, 85, 0.165, 0.130),
    "k168_v4300": ("inertial", 53, 53, 0.0698, 0.0662),
    "k1002_v42": ("stick-slip", 56, 51, 0.772, 0.811),
    "k1002_v1100": ("inertial", 360, 360, 0.0398, 0.0385),
    "k1002_v4300": ("inertial", 131, 131, 0.0286, 0.0289),
}


@pytest.fixture(scope="module")
def paper():
    from vibrocap.records.published import paper_stick_slip

    return {record.name: stick_slip_of(record) for record in paper_stick_slip(PAPER)}


@shared
@pytest.mark.parametrize("name", FOUND)
def test_paper_record_is_what_was_found(paper, name):
    found = paper[name]
    regime, slips, main, period, spectral = FOUND[name]
    assert found.regime.name == regime
    assert len(found.slips) == pytest.approx(slips, rel=0.02)
    assert len(found.main_slips) == pytest.approx(main, rel=0.02)
    assert found.period.mean == pytest.approx(period, rel=0.02)
    assert found.recurrence.spectral_period == pytest.approx(spectral, rel=0.02)
    # notes: only that slips and spectrum differ, or that the period drifts
    assert all(note.startswith("period:") for note in found.notes)
    assert found.notes or name == "k1002_v4300"
    # The force rises at k V in stick, but for what spring and contact are softer; what it rises, it falls in slips.
    assert found.loading_ratio == pytest.approx(1.0, abs=0.15)
    pulled = found.pulling_speed * (1 + (found.loading_ratio - 1) * found.stick_fraction)
    slipped = sum(slip.fall / found.stiffness + found.pulling_speed * slip.duration for slip in found.slips)
    span = found.slips[-1].end - found.slips[0].start
    assert slipped / span == pytest.approx(pulled, rel=0.04 if regime == "stick-slip" else 0.08)
    rest = [np.median(found.velocity[(found.time > s.start) & (found.time < s.end)]) for s in found.sticks]
    if regime == "stick-slip":
        assert abs(np.median(rest)) < 0.15 * found.pulling_speed
        assert 0.25 < found.kinetic_coefficient < found.static_coefficient < 0.45


@shared
def test_border_from_the_slow_records_parts_all(paper):
    diagram = regime_diagram(list(paper.values()))
    above = diagram.pulling_speed * np.sqrt(diagram.stiffness) > diagram.border
    assert [regime == "inertial" for regime in diagram.regimes] == above.tolist()


# --- contradictions, spread and drift ---------------------------------------------------------------------------------


def swinging(depth, noise=0.1, period=0.0203, seconds=8.0, seed=0):
    """(time, force) of an oscillation whose amplitude wanders, so that parts of it drown in the noise."""
    rng = np.random.default_rng(seed)
    time = np.arange(0.0, seconds, 1 / 2000)
    slow = np.interp(time, np.arange(0.0, seconds + 0.1, 0.1), rng.standard_normal(int(seconds / 0.1) + 1))
    swing = 0.4 * np.maximum(1 + depth * slow, 0.1) * np.sin(2 * np.pi * time / period)
    return time, 10.0 + swing + noise * rng.standard_normal(len(time))


def test_falls_that_drown_in_noise_do_not_make_the_period_longer():
    """An inertial swing was called a slow oscillation, with a period that its own spectrum contradicted."""
    analysis = stick_slip(*swinging(0.8), stiffness=2254.0, mass=0.0307, pulling_speed=1.1e-3)
    assert len(analysis.slips) < 0.8 * 8.0 / 0.0203  # of the falls that there are
    assert analysis.regime.name == "inertial"
    assert analysis.regime.from_spectrum
    assert analysis.period is not None
    assert analysis.period.mean == pytest.approx(0.0203, rel=0.02)
    assert analysis.period.error is not None
    assert analysis.period.error < 0.001
    assert "the spectrum has a period" in analysis.regime.reason


def test_a_period_that_drifts_is_reported_with_its_error():
    """Steady sawteeth whose period grows from 0.2 to 0.4 s."""
    periods = np.linspace(0.2, 0.4, 30)
    starts = np.concatenate(([0.0], np.cumsum(periods)))
    time = np.arange(0.0, starts[-1], 1 / 1000)
    phase = (time - starts[np.searchsorted(starts, time, side="right") - 1]) / periods[
        np.searchsorted(starts, time, side="right") - 1
    ]
    force = 1.0 + np.where(phase < 0.9, phase / 0.9, (1 - phase) / 0.1)
    analysis = stick_slip(time, force + 0.01 * np.random.default_rng(0).standard_normal(len(time)))
    assert analysis.drift is not None
    assert analysis.drift.significant
    # means of the thirds of the periods: 0.2 + 0.2/6 and 0.4 - 0.2/6
    assert analysis.drift.first == pytest.approx(0.2333, rel=0.03)
    assert analysis.drift.last == pytest.approx(0.3667, rel=0.03)
    assert any("its mean depends on the stretch" in note for note in analysis.notes)
