"""Ensembles and sweeps that settle by returns: cycles without a clock, over whole turns, each by its name."""

import math

import numpy as np
import pytest

import vibrocap as vc
from cases import printed
from systems import two_blocks
from vibrocap.arguments import ArgumentError
from vibrocap.motion.recording.equations import equations, parameter_values
from vibrocap.numerics.api import Budget, EnsembleStart, Form, ensemble_run

SETTLE = 1e-6
RESPONSE = ("period", "outcome", "mode_sequence", "stick_fraction")
BELT = vc.System(vc.Oscillator(damping=0.1, belt_speed=1.5), vc.Exponential(0.5, 1.0, 2.0), vc.Constant(duration=6.0))
# Two blocks on a belt, by `orbit` and by the reference of issue 27: periods.
TWO_BLOCKS = {0.15: 12.3929518, 0.2: 11.8962162, 0.3: 10.0706235}


def undamped(duration=1.0):
    machine = vc.Oscillator(mass=1.0, stiffness=2.0, damping=0.0, belt_speed=0.1)
    law = vc.Coulomb(static_coefficient=1.5, coulomb_coefficient=1.0)
    return vc.System(machine, law, vc.Constant(duration=duration))


def closed_form(speed):
    """(period, time at rest) of the undamped block: 2 D/v + (2/w) (pi - atan(w D/v)), D = 0.5/2, w^2 = 2."""
    held, omega = 0.25, math.sqrt(2.0)
    stuck = 2.0 * held / speed
    return stuck + 2.0 / omega * (math.pi - np.arctan(omega * held / speed)), stuck


def test_cycles_are_measured_over_whole_turns():
    """400 belts with starts by chance, each over one turn of its own: period and share of sticking in closed form."""
    draw, count = np.random.default_rng(1), 400
    speeds = np.geomspace(0.05, 2.0, count)
    over = {"machine.belt_speed": speeds, "initial.position": draw.uniform(-1.0, 1.0, count)}
    results = vc.ensemble(undamped(), over, measures=RESPONSE, periods=1000, settle=SETTLE, tolerance=1e-9)
    cycles = results["outcome"] == "cycle"
    # A start within the conservative slip about steady sliding never sticks: as the equations have it.
    assert cycles.mean() > 0.9
    assert results["settled"].all()
    sticking = results["stick_fraction"] > 0.0
    period, stuck = closed_form(speeds)
    assert sticking.sum() > count / 2
    assert results["period"][sticking] == pytest.approx(period[sticking], rel=1e-8)
    assert results["stick_fraction"][sticking] == pytest.approx((stuck / period)[sticking], rel=1e-7)
    assert set(results["mode_sequence"][sticking]) == {"BS"}
    smooth = cycles & ~sticking  # harmonic motion about steady sliding
    assert results["period"][smooth] == pytest.approx(math.sqrt(2.0) * math.pi, rel=1e-7)


@pytest.mark.parametrize("duration", [0.37, 6.316306357891377])
def test_the_idle_drive_is_nothing_to_a_cycle(duration):
    """Also where its duration is the period of the cycle, and marks at equal distances seem to stand still."""
    system = BELT.with_parameters({"drive.duration": duration})
    over = {"initial.position": [2.0, 0.55], "initial.sliding_velocity": [0.0, -1.5]}
    results = vc.ensemble(system, over, measures=RESPONSE, periods=int(2000 / duration), settle=SETTLE, tolerance=1e-9)
    assert results["outcome"].tolist() == ["cycle", "equilibrium"]
    assert results["period"] == pytest.approx([6.316306357891, 0.0], abs=1e-8)
    assert results["response_period"].tolist() == [1, 1]


@pytest.mark.slow
def test_what_did_not_settle_is_said_by_name():
    over = {"machine.belt_speed": [0.2, 0.1, 0.2], "initial.position": [1.0, 0.6, 1.0]}
    chaotic = vc.ensemble(two_blocks(), over, measures=["outcome", "period"], periods=200, settle=SETTLE)
    assert chaotic["outcome"].tolist() == ["cycle", "not settled: no repetition", "cycle"]
    assert np.isnan(chaotic["period"]).tolist() == [False, True, False]
    assert chaotic["response_period"].tolist() == [5, 0, 5]
    still = vc.ensemble(
        BELT, {"machine.belt_speed": [0.0, 1e-3]}, measures=["outcome", "period"], initial={"position": 0.3},
        periods=20, settle=SETTLE,
    )  # fmt: skip
    assert still["outcome"].tolist() == ["equilibrium", "not settled: no returns"]  # the other sticks all the while
    assert (still["period"][0], still["response_period"].tolist()) == (0.0, [1, 0])


def test_a_stored_motion_is_not_settled_by_an_idle_drive():
    motion = vc.simulate(BELT, periods=20, initial={"position": 2.0})
    with pytest.raises(ArgumentError, match="settle should be None, as nothing drives the system in time"):
        vc.measured(motion, "mean_friction", settle=SETTLE)


@pytest.mark.slow
def test_cycles_of_two_blocks_are_those_that_close():
    """Five and four returns a turn; one alternates as it settles, and is not taken for one of twice its period."""
    over = {"machine.belt_speed": list(TWO_BLOCKS)}
    start = {"position": 1.0, "position_2": 1.0}
    results = vc.ensemble(two_blocks(), over, measures=RESPONSE, initial=start, periods=400, settle=SETTLE)
    assert results["response_period"].tolist() == [4, 5, 5]
    assert results["period"] == pytest.approx(list(TWO_BLOCKS.values()), abs=1e-5)
    sharp = vc.ensemble(two_blocks(), over, measures=RESPONSE, initial=start, periods=600, settle=1e-8, tolerance=1e-11)
    assert sharp["period"] == pytest.approx(list(TWO_BLOCKS.values()), abs=1e-7)


@pytest.mark.exhaustive
def test_what_comes_to_rest_nowhere_returns_where_it_is_largest_or_has_turned():
    """A law without rest, and a rotor: periods of LSODA, DOP853 and `orbit`."""
    smooth = vc.System(vc.Oscillator(damping=0.1), vc.SmoothedTanh(), vc.Constant(duration=6.0))
    rotor = vc.System(vc.RotorCapsule(), vc.Coulomb(0.1, 0.15), vc.Constant(force=1.5))
    asked = {"measures": ("period", "drift"), "periods": 300, "settle": SETTLE, "tolerance": 1e-10}
    results = vc.ensemble(smooth, {"machine.belt_speed": [0.1, 0.5]}, initial={"position": 2.0}, **asked)
    assert results["period"] == pytest.approx([10.490282331, 6.466362473], rel=1e-6)
    moving = vc.ensemble(rotor, {"drive.force": [1.5]}, initial={"angle": 0.1}, **asked)
    assert (moving["period"][0], moving["drift"][0]) == pytest.approx((3.41235843634, -0.32074253582), abs=1e-6)


@pytest.mark.slow
def test_one_lane_as_plain_python_and_all_of_them_settle_alike():
    recorded = equations(BELT)
    states = np.array([[2.0, 0.0], [0.55, -1.5], [-1.0, 0.3]])
    parameters = np.tile(parameter_values(BELT), (3, 1))
    budget = Budget(40, 1e-8, 1000, 10**6, window=10, threshold=1e-4, asked=16, evidence=1, returns=True)
    plain = ensemble_run(EnsembleStart(recorded, parameters, states), budget, Form(lanes=1, plain=True))
    for threads in (1, 2):
        whole = ensemble_run(EnsembleStart(recorded, parameters, states), budget, threads=threads)
        assert whole.head("response_period") == pytest.approx(plain.head("response_period"))
        for name in ("RETURNS", "CYCLE_TIME", "SETTLED_TIME", "STICK_TIME"):
            assert whole.entry(name) == pytest.approx(plain.entry(name), abs=1e-7), name


@pytest.mark.slow
def test_a_sweep_counts_what_runs_became(tmp_path, capsys):
    case = "examples/slides-or-sticks-by-its-start.toml"
    over = ["--over", "machine.belt_speed=0.5:2:4", "--over", "initial.position=0.53,2", "--periods", "400"]
    said = printed(capsys, "sweep", case, *over, "--measure", "period", "--out", tmp_path / "map")
    assert "5: cycle" in said
    assert "3: equilibrium" in said
    study = vc.open_study(tmp_path / "map")
    assert study.period.attrs["long_name"].startswith("time after which the settled motion repeats")
    assert study["outcome"].values.tolist() == [["cycle"] * 2] * 2 + [["equilibrium", "cycle"], ["equilibrium"] * 2]
