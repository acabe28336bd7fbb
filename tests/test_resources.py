"""What would need more memory or disk than there is ends before the work, with what to do instead."""

import importlib
from pathlib import Path

import numpy as np
import pytest

from cases import refused
from vibrocap import Exponential, Harmonic, PendulumCapsule, System, simulate, sweep
from vibrocap.arguments import ArgumentError
from vibrocap.case.case import Case, CaseError
from vibrocap.resources import TooMuchMemory, available_memory, check_memory, free_disk, in_words
from vibrocap.studies.plan.runs import axis_of
from vibrocap.studies.sweep import spread

SWEEPS = importlib.import_module("vibrocap.studies.sweep")
SYSTEM = System(PendulumCapsule(), Exponential(), Harmonic(amplitude=1.8))
OVER = {"machine.mass_ratio": "1:2:100", "drive.amplitude": "1:2:100"}


def test_what_this_machine_has():
    assert available_memory() > 2**20
    assert free_disk(Path("/none/of/this")) > 0.0
    check_memory(1.0)
    with pytest.raises(TooMuchMemory, match="needs 1e\\+06 TB of memory"):
        check_memory(1e18)
    assert [in_words(size) for size in (500.0, 2e6, 3.5e9, 1.2e13)] == ["0.5 kB", "2 MB", "3.5 GB", "12 TB"]


def test_a_motion_that_cannot_be_kept_is_refused_at_once(capsys):
    case = Path(__file__).parents[1] / "examples" / "travels-by-stick-slip.toml"
    with pytest.raises(ArgumentError, match=r"periods: 1e\+09 drive periods .* of memory.*ensemble, sweep"):
        simulate(SYSTEM, periods=1e9)
    said = refused(capsys, "simulate", case, "--periods", "1e9")
    assert "periods" in said
    assert "Traceback" not in said


def test_a_motion_that_turns_out_too_large_is_given_up(monkeypatch):
    """What is known of it after its first pieces tells."""
    motion = importlib.import_module("vibrocap.numerics.run.motion")
    monkeypatch.setattr(motion, "PIECE_ROOM", 200)
    monkeypatch.setattr(importlib.import_module("vibrocap.resources"), "available_memory", lambda: 2e6)
    with pytest.raises(ArgumentError, match=r"ask for some .* at most"):
        simulate(SYSTEM, periods=150)
    assert simulate(SYSTEM, periods=20).status.ok


def test_a_motion_of_a_million_steps_a_period_is_given_up(monkeypatch, capsys, tmp_path):
    """It would end, after minutes and with gigabytes; one of as many periods in fewer steps goes on."""
    motion, resources = (importlib.import_module(f"vibrocap.{name}") for name in ("numerics.run.motion", "resources"))
    monkeypatch.setattr(motion, "PIECE_ROOM", 100)
    monkeypatch.setattr(resources, "KEPT", 1e5)
    monkeypatch.setattr(resources, "KEPT_PER_PERIOD", 1e4)
    stiff = System(PendulumCapsule(damping=3e3), Exponential(), Harmonic(amplitude=1.8))
    with pytest.raises(ArgumentError, match=r"kB at most are kept of 2 periods; ask for .* a stiffness far too large"):
        simulate(stiff, periods=2)
    assert simulate(SYSTEM, periods=2).status.ok
    case = tmp_path / "case.toml"
    Case(stiff, periods=2).save(case)
    assert "is a damping or a stiffness far too large?" in " ".join(refused(capsys, "simulate", case).split())


@pytest.mark.parametrize("samples", [-1, 0, 1.5, True, "many", float("nan"), 2**40])
def test_samples_are_a_whole_number(samples):
    with pytest.raises(ArgumentError, match="samples should be a whole number from 1 to"):
        simulate(SYSTEM, periods=1, samples=samples)


def test_an_axis_that_cannot_be_listed_is_refused_before_it_is():
    for given in ("1:3:2000000000", np.broadcast_to(1.0, (2_000_000_000,))):
        axis, (said,) = axis_of("machine.mass_ratio", given)
        assert axis.values == ()
        assert "has 2,000,000,000 values, 10,000,000 at most can be listed; a design" in said


def test_results_that_fit_nowhere_are_refused(tmp_path, monkeypatch):
    monkeypatch.setattr(SWEEPS, "available_memory", lambda: 1e5)
    with pytest.raises(CaseError, match=r"10,000 runs need 280 kB of memory, 100 kB are free; give a folder"):
        sweep(SYSTEM, OVER, measures=["mean_velocity"])
    monkeypatch.setattr(SWEEPS, "free_disk", lambda path: 1e4)
    with pytest.raises(CaseError, match=r"10,000 runs take roughly 56 kB, 10 kB are free there; .*--yes"):
        sweep(SYSTEM, OVER, measures=["mean_velocity"], out=tmp_path / "a")
    assert not (tmp_path / "a").exists()


def test_the_first_tiles_are_spread_over_a_study():
    """However many are done, they tell the cost of the others where that changes along the study."""
    for count in (1, 2, 3, 10, 97, 360):
        tiles = [(i,) for i in range(count)]
        robustness = spread(tiles)
        assert sorted(robustness) == tiles
        for done in range(5, count):
            share = sum(index[0] for index in robustness[:done]) / done / ((count - 1) / 2.0)
            assert abs(share - 1.0) < 0.45
    cost = np.exp(np.linspace(0.0, 4.0, 100))  # the last tiles cost fifty times the first
    order = [index[0] for index in spread([(i,) for i in range(100)])]
    for done in (5, 10, 20, 50):
        total = cost[order[:done]].sum() * 100 / done
        assert 0.6 < total / cost.sum() < 1.6
        assert cost[:done].sum() * 100 / done < 0.5 * cost.sum()  # as the order of storage would tell
