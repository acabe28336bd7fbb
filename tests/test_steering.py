"""Steering: schedules arrive by an independent run, in every sample and in SI; what cannot be reached; phase jumps."""

import csv
import dataclasses
import json

import numpy as np
import pytest

import vibrocap as vc
from vibrocap.case.case import read_case
from vibrocap.cli.main import main
from vibrocap.design.steering.family import Family, periods_of, schedules_of, spread
from vibrocap.design.steering.search import Search
from vibrocap.design.steering.trials import Trials
from vibrocap.orbits.maps.settling_runs import settling_runs
from vibrocap.orbits.maps.stroboscopic_map import StroboscopicMap, at_next_section

MACHINE, FRICTION = vc.PendulumCapsule(mass_ratio=2.5, stiffness=2.0, damping=1.0), vc.Exponential()
CAPSULE = vc.System(MACHINE, FRICTION, vc.Harmonic(amplitude=1.8, frequency=1.0))
UNSURE = {"friction.coulomb_coefficient": (0.14, 0.16), "machine.damping": "factor:0.97:1.03"}
FEW = {"levels": 4}  # factors, for a quick search


def independent_end(found, system, sample=None):
    """The state in which a schedule leaves a system, by motions of its own drive, one for each segment.

    The amplitude of the drive is multiplied by the factor, and each segment is a motion that begins at the drive's
    phase 0 from where the last one ended; the hold is ten times as long.
    """
    if sample is not None:
        system = system.with_parameters({path: float(values[sample]) for path, values in found.samples.items()})
    state, h = dict(found.initial), system.drive.amplitude
    for each in found.segments:
        drive = dataclasses.replace(system.drive, amplitude=each.factor * h)
        part = vc.System(system.machine, system.friction, drive)
        periods = each.periods * (10.0 if each.kind == "hold" else 1.0)
        motion = vc.simulate(part, periods=periods, initial=state, tolerance=1e-12)
        assert motion.status.ok
        assert motion.certificate.ok
        state = motion.state
    return state


# --- the family ------------------------------------------------------------------------------------------------------


def test_the_family_has_both_signs_of_every_factor_and_whole_periods_where_the_drive_has_corners():
    smooth, cornered = Family.of(vc.Harmonic(), 4), Family.of(vc.Square(), 4)
    assert smooth.factors.tolist() == [-1.0, -0.75, -0.5, -0.25, 0.25, 0.5, 0.75, 1.0]
    assert np.unique(smooth.bursts(2)[..., 0]).tolist() == [0.25 * k for k in range(1, 9)]
    assert np.unique(cornered.bursts(2)[..., 0]).tolist() == [1.0, 2.0]


def test_every_burst_of_a_schedule_has_its_pause():
    bursts = np.array([[(0.0, 0.0), (2.0, 1.0)], [(3.0, -1.0), (0.5, 0.25)], [(0.0, 0.0), (0.0, 0.0)]])
    assert schedules_of(bursts, 4.0).tolist() == [
        [[0.0, 0.0], [0.0, 0.0], [2.0, 1.0], [4.0, 0.0]],
        [[3.0, -1.0], [4.0, 0.0], [0.5, 0.25], [4.0, 0.0]],
        [[0.0, 0.0], [0.0, 0.0], [0.0, 0.0], [4.0, 0.0]],
    ]
    assert periods_of(bursts, 4.0).tolist() == [6.0, 11.5, 0.0]


def test_the_worst_error_is_the_middle_of_their_range_and_half_of_it():
    errors = np.array([[-1.0, 3.0, 2.0], [-0.5, -0.25, np.nan]])
    middle, half = spread(errors)
    assert (abs(middle[0]) + half[0]) == 3.0
    assert np.isnan(middle[1] + half[1])


# --- what is refused -------------------------------------------------------------------------------------------------


def said(*arguments, **options):
    with pytest.raises(vc.CaseError) as raised:
        vc.steer(*arguments, **{"tolerance": 0.01, **options})
    return raised.value.complaints


def test_bad_input_is_named_before_any_work():
    found = said(
        CAPSULE,
        float("nan"),
        tolerance=-1.0,
        within=0.0,
        least="cost",
        hold=0,
        levels=65,
        samples=0,
        uncertain={"friction.coulomb": (0.1, 0.2)},
        initial={"place": 1.0},
    )
    named = [each.field for each in found]
    assert named == [
        "target", "tolerance", "within", "hold", "samples", "levels", "least", "friction.coulomb", "initial.place",
    ]  # fmt: skip
    assert "samples: should be a power of two, got 12" in said(CAPSULE, 1.0, uncertain=UNSURE, samples=12)


@pytest.mark.parametrize(
    ("system", "words"),
    [
        (vc.System(vc.Oscillator(), vc.Coulomb(), vc.Harmonic()), "free to travel"),
        (vc.System(MACHINE, FRICTION, vc.Constant(force=1.0)), "a drive that changes in time"),
        (vc.System(MACHINE, FRICTION, vc.Ramp(rate=0.1)), "can be scheduled: only a drive that is a function of time"),
        (vc.System(vc.TwoMassCrawler(), vc.Coulomb(), vc.Biharmonic()), "jumps, while the two-mass-crawler"),
        (vc.System(MACHINE, FRICTION, vc.Harmonic(), controller=vc.AnglePID()), "no controller"),
    ],
    ids=["held", "constant", "ramp", "displacement", "controlled"],
)
def test_a_system_that_cannot_be_steered_is_named(system, words):
    assert words in " ".join(said(system, 1.0))


@pytest.mark.slow
def test_what_cannot_be_reached_says_how_near_or_how_long():
    steep = vc.System(MACHINE, FRICTION, CAPSULE.drive, environment=vc.Environment(inclination=0.5))
    assert "system: should rest while its drive pauses" in said(steep, -3.0)[0]
    weak = vc.System(MACHINE, FRICTION, vc.Harmonic(amplitude=0.6))  # its settled motions are symmetric
    (words,) = said(weak, 5.0, **FEW)
    assert words.startswith("target: should be within reach: no settled motion of this drive travels there")
    (words,) = said(CAPSULE, 5.0, within=60.0)
    assert words.startswith("within: should be at least ")
    least = float(words.split()[5].rstrip(","))
    found = vc.steer(CAPSULE, 5.0, tolerance=0.01, within=1.0001 * least)
    assert found.status.value == "arrives"


# --- schedules that arrive -------------------------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize(
    ("target", "tolerance", "initial"),
    [(5.0, 0.01, {}), (0.05, 1e-3, {}), (5.0, 1e-5, {}), (3.0, 1e-3, {"angle": 1.0, "position": 2.0})],
    ids=["far", "near", "close", "moving"],
)
def test_a_schedule_arrives_and_holds_by_an_independent_run(target, tolerance, initial):
    found = vc.steer(CAPSULE, target, tolerance=tolerance, initial=initial)
    assert found.status is vc.SteeringStatus.ARRIVES
    state = independent_end(found, CAPSULE)
    assert state["position"] == pytest.approx(found.position, abs=1e-8)
    assert abs(state["position"] - target) <= tolerance
    assert state["velocity"] == 0.0
    assert found.creep <= 1e-9
    motion = found.motion()
    later = motion.at(np.linspace(found.arrival, motion.end, 2001), "position")
    assert np.max(np.abs(later - target)) <= tolerance * (1.0 + 1e-9)
    assert abs(motion.at([found.arrival - 1e-3], "position")[0] - target) > tolerance
    assert [each.start for each in found.segments[1:]] == [each.end for each in found.segments[:-1]]
    longest = max((each for each in found.segments if each.factor), key=lambda each: each.periods)
    orbit = vc.orbit(vc.System(MACHINE, FRICTION, vc.Harmonic(amplitude=1.8 * abs(longest.factor))))
    if abs(orbit.drift) > 1e-3:  # of either twin
        assert abs(found.drift) == pytest.approx(abs(orbit.drift), rel=1e-5)


@pytest.mark.slow
def test_a_target_behind_is_reached_by_the_mirror_image():
    ahead, behind = (vc.steer(CAPSULE, sign * 2.0, tolerance=1e-3, **FEW) for sign in (1.0, -1.0))
    assert [each.factor for each in ahead.segments] == [-each.factor for each in behind.segments]
    assert [each.end for each in ahead.segments] == [each.end for each in behind.segments]
    assert ahead.position == -behind.position


@pytest.mark.slow
def test_where_it_is_already_nothing_is_done():
    found = vc.steer(CAPSULE, 2.0, tolerance=0.01, initial={"position": 1.995}, **FEW)
    assert [each.kind for each in found.segments] == ["hold"]
    assert found.arrival == found.work == 0.0


@pytest.mark.slow
def test_the_least_work_is_no_more_than_that_of_the_soonest_and_the_soonest_no_later():
    soon, cheap = (vc.steer(CAPSULE, 1.5, tolerance=0.05, least=least) for least in ("time", "work"))
    assert soon.status is cheap.status is vc.SteeringStatus.ARRIVES
    assert cheap.work <= soon.work
    assert soon.segments[-1].start <= cheap.segments[-1].start


@pytest.mark.slow
def test_every_sample_arrives_by_a_run_of_its_own_or_what_is_attainable_is_said():
    found = vc.steer(CAPSULE, 3.0, tolerance=0.1, uncertain=UNSURE, samples=8)
    assert found.status is vc.SteeringStatus.ARRIVES
    assert found.share_within == 1.0
    assert len(found.positions) == 4 + 8 + found.checked  # the corners of the box, the samples seen, the others
    assert found.checked == 32
    for k in (0, 3, 7, len(found.positions) - 1):
        state = independent_end(found, CAPSULE, k)
        assert state["position"] == pytest.approx(found.positions[k], abs=1e-6)
        assert abs(state["position"] - 3.0) <= 0.1
    tight = vc.steer(CAPSULE, 3.0, tolerance=1e-3, uncertain=UNSURE, samples=8)
    assert tight.status is not vc.SteeringStatus.ARRIVES
    assert tight.worst_error > 1e-3
    assert tight.worst_error == pytest.approx(np.max(np.abs(tight.positions - 3.0)))
    again = vc.steer(CAPSULE, 3.0, tolerance=1.05 * tight.worst_error, uncertain=UNSURE, samples=8)
    assert again.status is vc.SteeringStatus.ARRIVES


@pytest.mark.slow
def test_in_si_it_is_the_plain_schedule_times_the_scales():
    case = read_case("examples/bench-in-si.toml")
    metre, second = case.system.si.factor("position"), case.system.si.factor_of("s")
    unsure = {"drive.frequency_Hz": (0.99, 1.01)}
    plain = {"drive.frequency": tuple(each / (0.5 * np.pi / np.pi / second) * np.pi for each in (0.99, 1.01))}
    assert plain["drive.frequency"][0] == pytest.approx(0.99 * case.system.parameter("drive.frequency"))
    found = vc.steer(case, 0.25, tolerance=0.02, initial={}, uncertain=unsure, samples=8, **FEW)
    bare = vc.steer(
        case.system.dimensionless, 0.25 / metre, tolerance=0.02 / metre, initial={}, uncertain=plain, samples=8, **FEW
    )
    assert found.status is bare.status is vc.SteeringStatus.ARRIVES
    assert found.unit_of("position") == "m"
    assert found.position == pytest.approx(metre * bare.position, rel=1e-9)
    assert found.arrival == pytest.approx(second * bare.arrival, rel=1e-9)
    assert found.positions == pytest.approx(metre * bare.positions, rel=1e-7)
    for one, other in zip(found.segments, bare.segments, strict=True):
        assert (one.kind, one.periods, one.factor) == (other.kind, other.periods, other.factor)
        assert one.end == pytest.approx(second * other.end, rel=1e-12)
    late = said(case, 0.25, tolerance=0.02, within=0.1, initial={}, **FEW)
    assert late[0].endswith("got 0.1 s")


@pytest.mark.slow
def test_a_drive_with_corners_and_an_imposed_stroke_are_steered_by_whole_periods():
    for system in (
        vc.System(vc.TwoMassCapsule(), vc.Coulomb(), vc.Square(amplitude=1.5, duty=0.4)),
        vc.System(vc.TwoMassCrawler(), vc.Coulomb(), vc.SevenPhase()),
    ):
        found = vc.steer(system, 1.0, tolerance=0.02, **FEW)
        assert found.status is vc.SteeringStatus.ARRIVES
        assert all(each.periods == int(each.periods) for each in found.segments)
        assert found.motion().state[system.cyclic] == pytest.approx(1.0, abs=0.02)


# --- planted faults --------------------------------------------------------------------------------------------------


@pytest.mark.slow
def test_a_fault_in_the_lanes_is_not_called_an_arrival(monkeypatch):
    ends = Trials.ends

    def shifted(self, *given, **options):
        found = ends(self, *given, **options)
        return dataclasses.replace(found, position=found.position + 0.05)

    monkeypatch.setattr(Trials, "ends", shifted)
    found = vc.steer(CAPSULE, 1.5, tolerance=0.01, **FEW)
    assert found.status is not vc.SteeringStatus.ARRIVES
    assert abs(found.error) > 0.01


@pytest.mark.slow
def test_a_fault_in_the_sums_is_found_by_runs_in_whole(monkeypatch):
    ends = Search.ends

    def longer(self, bursts, pause=None, at_rest=False):
        found = ends(self, bursts, pause, at_rest)
        return dataclasses.replace(found, position=1.2 * found.position) if at_rest else found

    monkeypatch.setattr(Search, "ends", longer)
    found = vc.steer(CAPSULE, 3.0, tolerance=0.01, **FEW)
    assert (found.status is vc.SteeringStatus.ARRIVES) == (abs(found.error) <= 0.01)
    assert independent_end(found, CAPSULE)["position"] == pytest.approx(found.position, abs=1e-8)


# --- phase jumps -----------------------------------------------------------------------------------------------------


@pytest.mark.slow
def test_one_phase_jump_turns_the_capsule_round_for_35_per_cent_of_all():
    """On a grid of 48 x 48 (instant, jump): of none below 1/16 of a period, of half a period for a third of instants.

    So a jump of the phase is no way to turn round for certain, and the family pauses before it turns.
    """
    cells = 48
    steady = vc.orbit(CAPSULE, initial={"angle": np.pi / 3})
    period = CAPSULE.drive.period
    states = vc.simulate(CAPSULE, periods=1, initial=steady.state, tolerance=1e-12).states(
        np.arange(cells) / cells * period
    )
    map_ = StroboscopicMap(CAPSULE, 1e-9)
    instant, jump = np.repeat(np.arange(cells), cells) / cells, np.tile(np.arange(cells), cells) / cells
    rows = np.tile(map_.parameters(), (cells * cells, 1))
    begun, _ = at_next_section(map_, np.repeat(states.T, cells, axis=0), rows, instant + jump)
    runs = settling_runs(map_, begun, rows, 2000)
    assert np.all(runs.response_period == 1)
    assert np.abs(runs.drift) == pytest.approx(abs(steady.drift), rel=1e-5)
    turned = (runs.drift * steady.drift < 0.0).reshape(cells, cells)
    assert turned.sum() == 814  # of 2304: 35.3 %
    turning = np.flatnonzero(turned.any(axis=0))
    assert (turning[0], turning[-1]) == (4, 45)  # +1/12 and -1/16 of a period
    assert turned[:, cells // 2].sum() == 16


# --- the command and the pictures ------------------------------------------------------------------------------------


@pytest.mark.slow
def test_the_command_writes_a_case_that_arrives(tmp_path, monkeypatch, capsys):
    out = tmp_path / "steer"
    picture = tmp_path / "steer.png"
    asked = ["steer", "examples/bench-in-si.toml", "--to", "25cm", "--tolerance", "0.02 m", "--levels", "4"]
    unsure = ["--uncertain", "friction.coulomb_coefficient=0.048:0.052", "--samples", "8"]
    assert main([*asked, *unsure, "--out", str(out), "--plot", str(picture), "--json"]) == 0
    record = json.loads(capsys.readouterr().out)
    assert record["status"] == "arrives"
    assert record["position"]["unit"] == "m"
    assert record == json.loads((out / "steering.json").read_text())
    with (out / "schedule.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert [float(row["factor"]) for row in rows] == [each["factor"] for each in record["segments"]]
    assert picture.stat().st_size > 10_000
    assert main(["simulate", str(out / "steered.toml"), "--json"]) == 0
    end = json.loads(capsys.readouterr().out)
    assert end["state"]["position"] == pytest.approx(record["position"], rel=1e-12)
    assert abs(end["state"]["position"] - 0.25) <= 0.02
    assert main([*asked, *unsure[:1], "friction.coulomb_coefficient=0.03:0.07", "--tolerance", "0.1mm"]) == 2
    capsys.readouterr()
    tight = [*asked[:4], "--tolerance", "0.05mm", *unsure, "--levels", "4"]
    assert main(tight) == 3
    assert "worst error is" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--to", "5kg", "--tolerance", "0.01"], "--to: should be a number, as the case is without units, got '5kg'"),
        (["--to", "5", "--tolerance", "much"], "--tolerance: should be a number, got 'much'"),
        (["--to", "5", "--tolerance", "-1"], "--tolerance: should be positive, got -1"),
        (["--to", "5", "--tolerance", "0.1", "--within", "0"], "--within: should be positive, got 0"),
        (["--to", "5", "--tolerance", "0.1", "--levels", "0"], "--levels: should be a whole number from 1 to 64"),
    ],
    ids=["unit", "word", "negative", "no time", "levels"],
)
def test_the_command_names_its_options(options, words, capsys):
    assert main(["steer", "examples/travels-by-stick-slip.toml", *options]) == 2
    assert words in capsys.readouterr().err
