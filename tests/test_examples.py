"""Every example runs, shows what its name says, and stands in the table of examples/README.md with its drift."""

import re
from pathlib import Path

import numpy as np
import pytest

import vibrocap as vc
from thinned import exhaustive_but, slow_but
from vibrocap.case.case import case_from_text, case_text, read_case
from vibrocap.cli import main as cli
from vibrocap.measures.recorded.settling import response_class
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


def test_every_drift_named_in_a_header_is_that_of_the_table():
    """To the digits of both."""
    for path in FILES:
        for named in re.findall(r"drift ([-+]?\d+\.\d+)", path.read_text("utf-8").partition("[machine]")[0]):
            (number,) = re.findall(r"^[-+.\d]+", TABLE[path.stem])
            within = sum(0.5 * 10.0 ** -len(each.partition(".")[2]) for each in (named, number))
            assert float(named) == pytest.approx(float(number), rel=0.0, abs=1.001 * within), path.name


def test_every_machine_has_an_example():
    shown = {read_case(path).system.machine.name for path in FILES}
    assert shown >= {*machines()}


def last_load(motion):
    return motion["reaction"][motion.time > motion.end - motion.period]


def is_symmetric(motion):
    return response_class(motion).symmetric


# example: what of its motion is what, to within how much
SHOWN = {
    "sticks-and-slips-on-a-belt": [(lambda motion: vc.stick_fraction(motion, periods=1), 0.4363, 1e-4)],
    "vibrates-by-mode-coupling": [
        (lambda motion: vc.stick_fraction(motion, periods=1), 0.4301, 1e-4),
        (lambda motion: last_load(motion).min(), 0.383, 2e-3),
        (lambda motion: last_load(motion).max(), 1.445, 2e-3),
    ],
    "travels-by-stick-slip": [(is_symmetric, False, 0)],
    "symmetric-no-travel": [(is_symmetric, True, 0), (vc.drift, 0.0, STILL)],
    "weight-as-load": [
        (is_symmetric, True, 0),
        (vc.drift, 0.0, STILL),
        (vc.stick_fraction, 1 / 3, 0.03),
        (lambda motion: vc.mode_sequence(motion).count("S"), 4, 0),
    ],
    "slow-drive-mostly-sticks": [(is_symmetric, True, 0), (vc.drift, 0.0, STILL), (vc.stick_fraction, 0.76, 0.01)],
    "never-leaves-stick": [(vc.stick_fraction, 1.0, 0), (lambda motion: np.ptp(motion["position"]), 0.0, 0)],
    "biharmonic-drive-travels": [
        (vc.stick_fraction, 0.5, 0.01),
        (lambda motion: sorted(vc.mode_sequence(motion)), ["B", "S"], None),
    ],
    "phase-reverses-travel": [(lambda motion: vc.drift(motion) > 0.2, True, 0)],
    "bristles-lugre": [(lambda motion: vc.friction_loop(motion).peak_force, 0.459, 1e-3)],
    "no-friction-no-travel": [
        (lambda motion: np.ptp(3.5 * motion["position"] - np.sin(motion["angle"])), 0.0, 1e-7),  # momentum
        (vc.drift, 0.0, STILL),
    ],
    "buckled-pendulum-travels": [
        (is_symmetric, False, 0),
        (lambda motion: vc.stick_fraction(motion, periods=10), 0, 0),
    ],
}
FAST = "buckled-pendulum-travels"


@pytest.mark.parametrize("name", slow_but([[*SHOWN].index(FAST)], [*SHOWN]))
def test_an_example_shows_what_its_name_says(name, motions):
    for found, expected, within in SHOWN[name]:
        assert found(motions[name]) == (expected if within is None else pytest.approx(expected, rel=0.0, abs=within))


@pytest.mark.slow
def test_what_is_changed_in_an_example_changes_its_motion(motions):
    """Less friction calms the block, the other phase turns the travel round, the mirror image drifts the other way."""
    calm = motions["vibrates-by-mode-coupling"].system.with_parameters(
        {"friction.coulomb_coefficient": 0.45, "friction.static_coefficient": 0.45}
    )
    assert np.ptp(vc.simulate(calm, periods=800, initial={"approach": 0.05})["reaction"][-256:]) < 1e-3
    other = read_case(EXAMPLES / "phase-reverses-travel.toml", {"drive.second_phase": 0.0}, periods=40).simulate()
    assert vc.drift(other) == pytest.approx(-0.221, abs=1e-3)
    assert vc.drift(motions["travels-by-stick-slip"]) == pytest.approx(-vc.drift(motions["mirror-twin"]), rel=1e-9)


def test_bristles_with_offset_points():
    case = read_case(EXAMPLES / "bristles-with-offset-points.toml")
    offset = vc.frictional_limits(case.system.friction).offset
    assert offset.lower == pytest.approx(0.006696630374612, rel=1e-12)
    assert offset.upper == pytest.approx(0.181821489161179, rel=1e-12)


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
