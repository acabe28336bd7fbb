"""Every example runs, shows what its name says, and stands in the table of examples/README.md with its drift."""

import re
from pathlib import Path

import numpy as np
import pytest

import vibrocap as vc
from thinned import exhaustive_but
from vibrocap.case.case import case_from_text, case_text, read_case
from vibrocap.cli import main as cli
from vibrocap.measures.recorded.response import response_class
from vibrocap.motion.recording.equations import equations
from vibrocap.physics.catalogue import machines

EXAMPLES = Path(__file__).resolve().parents[1] / "examples"
FILES = sorted(EXAMPLES.glob("*.toml"))
TABLE = dict(
    re.findall(
        r"^\| \[([\w-]+)\]\([\w-]+\.toml\) \|.*\| ([-+.\d]+(?: m)?) \|$",
        (EXAMPLES / "README.md").read_text("utf-8"),
        re.M,
    )
)

STILL = 1e-8  # a drift that is zero but for tolerance and the end of the transient


class Motions(dict):
    """The motions of the examples by name, each run when it is asked for."""

    def __missing__(self, name):
        self[name] = read_case(next(path for path in FILES if path.stem == name)).simulate()
        return self[name]


@pytest.fixture(scope="module")
def motions():
    return Motions()


def test_table_names_every_example():
    assert sorted(TABLE) == [path.stem for path in FILES]


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_example_says_what_to_see_and_reads_back_equal(path):
    head = path.read_text("utf-8").split("[machine]")[0].splitlines()
    assert all(line.startswith("#") or not line for line in head)
    assert any(line.startswith("# See: ") for line in head)
    assert any(f"examples/{path.name}" in line for line in head)
    case = read_case(path)
    assert case_from_text(case_text(case)) == case


@pytest.mark.slow  # the others are run where the site is built, by their pages
@pytest.mark.parametrize("path", exhaustive_but(range(0, len(FILES), 8), FILES), ids=lambda path: path.stem)
def test_example_runs_settles_and_has_the_drift_of_the_table(path, motions):
    motion = motions[path.stem]
    assert motion.status.ok
    if equations(motion.system).timed:  # else the end of a period is no clock: the cycle drifts past it
        assert vc.settling(motion).settled
    if motion.system.machine.cyclic is None:  # held to its place
        assert TABLE[path.stem] == "-"
        return
    number, _, unit = TABLE[path.stem].partition(" ")
    assert (unit or "1") == motion.unit_of("displacement")
    assert vc.drift(motion) == pytest.approx(float(number), abs=0.5e-5)


@pytest.mark.slow
def test_every_drift_named_in_a_header_is_right(motions):
    for path in FILES:
        for named in re.findall(r"drift ([-+]?\d+\.\d+)", path.read_text("utf-8").partition("[machine]")[0]):
            digits = len(named.partition(".")[2])
            assert vc.drift(motions[path.stem]) == pytest.approx(float(named), abs=0.51 * 10.0**-digits), path.name


def test_every_machine_has_an_example():
    shown = {read_case(path).system.machine.name for path in FILES}
    assert shown >= {*machines()}


@pytest.mark.slow
def test_blocks_on_belts_stick_once_in_each_cycle(motions):
    assert vc.stick_fraction(motions["sticks-and-slips-on-a-belt"], periods=1) == pytest.approx(0.4363, abs=1e-4)
    motion = motions["vibrates-by-mode-coupling"]
    assert vc.stick_fraction(motion, periods=1) == pytest.approx(0.4301, abs=1e-4)
    last = motion["reaction"][motion.time > motion.end - motion.period]
    assert [last.min(), last.max()] == pytest.approx([0.383, 1.445], abs=2e-3)
    calm = motion.system.with_parameters({"friction.coulomb_coefficient": 0.45, "friction.static_coefficient": 0.45})
    assert np.ptp(vc.simulate(calm, periods=800, initial={"approach": 0.05})["reaction"][-256:]) < 1e-3


@pytest.mark.slow
def test_twins_drift_the_same_way_up_to_sign(motions):
    one, other = motions["travels-by-stick-slip"], motions["mirror-twin"]
    assert vc.drift(one) == pytest.approx(-vc.drift(other), rel=1e-9)
    assert response_class(one).symmetric is False


@pytest.mark.slow
@pytest.mark.parametrize("name", ["symmetric-no-travel", "weight-as-load", "slow-drive-mostly-sticks"])
def test_symmetric_motions_slip_but_do_not_travel(name, motions):
    assert response_class(motions[name]).symmetric is True
    assert abs(vc.drift(motions[name])) < STILL
    assert {"slip_forward", "slip_back"} <= set(motions[name].event_kinds)


@pytest.mark.slow
def test_never_leaves_stick(motions):
    motion = motions["never-leaves-stick"]
    assert vc.stick_fraction(motion) == 1.0
    assert motion.events == ()
    assert np.all(motion["position"] == 0.0)
    assert 0.0 < motion.certificate.stick_force_ratio < 1.0


@pytest.mark.slow
def test_biharmonic_drive_walks_backward_only(motions):
    motion = motions["biharmonic-drive-travels"]
    assert sorted(vc.mode_sequence(motion)) == ["B", "S"]
    assert vc.stick_fraction(motion) == pytest.approx(0.5, abs=0.01)


@pytest.mark.slow
def test_phase_of_the_second_harmonic_reverses_travel(motions):
    case = read_case(EXAMPLES / "phase-reverses-travel.toml")
    other = vc.simulate(case.system.with_parameters({"drive.second_phase": 0.0}), initial=case.initial, periods=40)
    assert vc.drift(motions["phase-reverses-travel"]) > 0.2
    assert vc.drift(other) == pytest.approx(-0.221, abs=1e-3)


@pytest.mark.slow
def test_bristles_open_the_loop_and_exceed_static_friction(motions):
    loop = vc.friction_loop(motions["bristles-lugre"])
    assert loop.peak_force == pytest.approx(0.459, abs=1e-3)
    assert abs(loop.velocity_area) > 1e-3
    shorter = read_case(EXAMPLES / "bristles-lugre.toml", periods=40).simulate()
    assert not vc.mean_velocity(shorter).settled


def test_bristles_with_offset_points():
    case = read_case(EXAMPLES / "bristles-with-offset-points.toml")
    offset = vc.frictional_limits(case.system.friction).offset
    assert offset.lower == pytest.approx(0.006696630374612, rel=1e-12)
    assert offset.upper == pytest.approx(0.181821489161179, rel=1e-12)


@pytest.mark.slow
def test_without_friction_momentum_stays(motions):
    motion = motions["no-friction-no-travel"]
    assert np.all(motion["friction"] == 0.0)
    kept = 3.5 * motion["position"] - np.sin(motion["angle"])
    np.testing.assert_allclose(kept, kept[0], atol=1e-7)
    assert abs(vc.drift(motion)) < STILL


def test_light_capsule_travels_four_times_as_far(motions):
    assert vc.drift(motions["light-capsule-travels-fast"]) > 4 * vc.drift(motions["travels-by-stick-slip"])


def test_buckled_pendulum_leans_to_one_side(motions):
    motion = motions["buckled-pendulum-travels"]
    assert response_class(motion).symmetric is False
    assert vc.stick_fraction(motion, periods=10) == 0.0


@pytest.mark.slow
def test_slow_drive_mostly_sticks_and_weight_sticks_a_third(motions):
    assert vc.stick_fraction(motions["slow-drive-mostly-sticks"]) == pytest.approx(0.76, abs=0.01)
    assert vc.stick_fraction(motions["weight-as-load"]) == pytest.approx(1 / 3, abs=0.03)
    assert vc.mode_sequence(motions["weight-as-load"]).count("S") == 4


@pytest.mark.slow
def test_the_study_of_the_readme_finds_travel_and_none(tmp_path, monkeypatch):
    """The commands of examples/README.md on a coarser grid: the paper's machine (rho = 4) goes nowhere."""
    text = (EXAMPLES / "README.md").read_text("utf-8")
    sweep, plot = re.findall(r"^    vibrocap ((?:.*\\\n)*.*)$", text.partition("## A study")[2], re.MULTILINE)
    (tmp_path / "examples").symlink_to(EXAMPLES)
    monkeypatch.chdir(tmp_path)
    words = sweep.replace("\\\n", " ").replace(":400", ":4").split()
    assert cli.main(words) == 0
    assert cli.main(plot.split()) == 0
    assert (tmp_path / "steady-travel.png").stat().st_size > 10_000
    study = vc.open_study("steady-travel").load()
    stiff = study.sel({"machine.stiffness": 4.0}, method="nearest")
    assert float(stiff["machine.stiffness"]) > 3.0
    assert bool((abs(stiff.mean_velocity) < 1e-5).all())
    assert bool((stiff.symmetric == 1.0).all())
    soft = study.isel({"machine.mass_ratio": 0, "machine.stiffness": 1})
    assert bool((abs(soft.mean_velocity) > 0.05).all())
    assert bool((soft.symmetric == 0.0).all())
