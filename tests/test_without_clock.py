"""What motions become that nothing drives in time: attractors, basins, exponents and diagrams of blocks on belts."""

import math

import numpy as np
import pytest

import vibrocap as vc
from systems import two_blocks
from vibrocap.arguments import ArgumentError

ZERO_PROGRESS = vc.Constant(duration=2.0 * math.pi)
BLOCK = vc.System(vc.Oscillator(damping=0.1, belt_speed=1.5), vc.Exponential(0.5, 1.0, 2.0), ZERO_PROGRESS)
RESTS = vc.System(vc.Oscillator(), vc.Coulomb(0.1, 0.2), ZERO_PROGRESS)
RANGES = {"position": (-2.0, 2.0), "sliding_velocity": (-1.5, 0.5)}  # velocities of the block from 0 to 2


# --- attractors and basins -------------------------------------------------------------------------------------------


@pytest.mark.slow
def test_share_of_starts_that_come_to_slide_steadily():
    """A published table of 4,000 labelled starts gives 0.3165; both shares have their standard errors.

    The share itself is an area: inside the unstable cycle, as far as the block moves forward, over that of the ranges;
    by DOP853 at 1e-13 and the map of x' = 0.
    """
    count = 2000
    steady = vc.attractors(BLOCK, count, RANGES)
    kinds = {attractor.motion.kind: attractor for attractor in steady.attractors}
    assert set(kinds) == {"cycle", "steady sliding"}
    sliding = kinds["steady sliding"]
    assert sliding.error == pytest.approx(math.sqrt(0.3071 * 0.6929 / count), rel=2e-2)
    assert abs(sliding.share - 0.3071261377816) < sliding.error
    assert abs(sliding.share - 0.3165) < 2.0 * math.hypot(sliding.error, math.sqrt(0.3165 * 0.6835 / 4000))
    for label, start in list(zip(steady.label, steady.starts, strict=True))[:20]:
        motion = vc.simulate(BLOCK, periods=60, initial=dict(zip(BLOCK.state_names, start, strict=True)))
        sticks = any(event.kind == "stick" and event.time > 0.8 * motion.end for event in motion.events)
        assert (steady.attractors[label].motion.kind == "cycle") == sticks


@pytest.mark.slow
def test_a_set_of_rest_is_one_attractor():
    still = BLOCK.with_parameters({"machine.belt_speed": 0.0})
    steady = vc.attractors(still, 50)
    assert [attractor.motion.kind for attractor in steady.attractors] == ["rest"]
    assert np.all(steady.label == 0)


@pytest.mark.slow
def test_basins_of_what_does_not_travel_are_labels():
    cells = vc.basins(BLOCK, RANGES, 12)
    assert np.all(cells.direction == 0)
    for label, position, velocity in [(cells.label[6, 0], cells.x[6], cells.y[0]), (cells.label[0, 11], -2.0, 0.5)]:
        start = {"position": float(position), "sliding_velocity": float(velocity)}
        assert cells.attractors[label].motion.kind == vc.classify(BLOCK, start).kind
    assert cells.label[6, 0] != cells.label[0, 11]
    with pytest.raises(ArgumentError, match="phase: the system has no drive in time"):
        vc.basins(BLOCK, {"position": (-1, 1), "phase": (0, 1)}, 4)


# --- exponents -------------------------------------------------------------------------------------------------------


@pytest.mark.slow
def test_exponent_of_a_cycle_is_that_of_its_multiplier():
    system = two_blocks(0.3)
    cycle = vc.orbit(system, initial={"position": 1.0, "position_2": 1.0}, settle_periods=120)
    exponent = vc.lyapunov_exponent(system, cycle.state, periods=200, transient=0)
    assert len(exponent.spectrum) == 3  # of four: that along the motion is left out
    assert exponent.error < 0.005
    assert exponent.value == pytest.approx(math.log(abs(cycle.multipliers[0])) / cycle.period, abs=exponent.error)


@pytest.mark.slow
def test_exponents_at_an_equilibrium_are_its_eigenvalues():
    (sliding,) = vc.equilibria(BLOCK)
    exponent = vc.lyapunov_exponent(BLOCK, {"position": 0.6, "sliding_velocity": -1.5}, periods=200, transient=200)
    assert exponent.spectrum == pytest.approx(np.real(sliding.eigenvalues), abs=3.0 * exponent.error)
    assert exponent.error < 2e-3


@pytest.mark.slow
def test_chaos_is_told_whatever_the_length_of_the_idle_drive():
    kinds = [vc.classify(two_blocks(0.1, duration), {"position": 1.0}, periods=400) for duration in (10.0, 23.0)]
    assert [kind.kind for kind in kinds] == ["chaotic", "chaotic"]
    one, other = (kind.lyapunov for kind in kinds)
    assert one.value > 5 * one.error > 0
    assert one.value == pytest.approx(other.value, abs=3.0 * math.hypot(one.error, other.error))


# --- diagrams --------------------------------------------------------------------------------------------------------


@pytest.mark.slow
def test_a_diagram_records_the_returns_of_cycles():
    start, speed = {"position": 1.0, "position_2": 1.0}, 0.3
    diagram = vc.bifurcation_diagram(
        two_blocks(0.2), "machine.belt_speed", (0.2, speed), 2, starts=1, settle_periods=60, section="stick",
        initial=start, directions=("up",),
    )  # fmt: skip
    cycle = vc.orbit(two_blocks(speed), initial=start, settle_periods=120)
    motion = cycle.motion(1.5 * cycle.period / 10.0)
    expected = np.sort(motion.states(vc.Section("stick").times(motion)[:2])[0])
    assert diagram.response_period[0, 0, -1] == 2
    assert np.sort(diagram.states[0, 0, -1, :2, 0]) == pytest.approx(expected, abs=1e-5)
    driven = vc.System(vc.PendulumCapsule(), vc.Exponential(), vc.Harmonic())
    with pytest.raises(ArgumentError, match="section should be None"):
        vc.bifurcation_diagram(driven, "machine.mass_ratio", (1.0, 2.0), 2, section="stick")


def test_what_nothing_drives_has_a_period_of_its_own_for_robustness_and_none_at_its_marks():
    """Robustness refused it; `settling` looked for periods of the idle drive."""
    system = vc.System(vc.Oscillator(belt_speed=0.3), vc.Coulomb(0.1, 0.2), ZERO_PROGRESS)
    spread = vc.robustness(system, {"machine.stiffness": (0.8, 1.2)}, "period", samples=8)
    assert spread.nominal == pytest.approx(vc.orbit(system).period, rel=1e-6)
    assert np.all(np.diff(spread.values[np.argsort(spread.parameters["machine.stiffness"])]) < 0.0)
    for lacking in ("peak_velocity", "bristle_loss_2_work"):  # all values would be NaN
        with pytest.raises(ValueError, match="no motion of this system has it"):
            vc.robustness(system, {"machine.stiffness": (0.8, 1.2)}, lacking, samples=8)
    rest, cycle = (vc.settling(vc.simulate(each, periods=20)) for each in (RESTS, system))
    assert (rest.settled, rest.period, cycle.settled, cycle.period) == (True, 1, False, None)


def test_steady_sliding_is_one_point_of_a_diagram():
    start = {"position": 0.55, "sliding_velocity": -1.5}
    diagram = vc.bifurcation_diagram(
        BLOCK, "machine.belt_speed", (1.4, 1.5), 2, starts=1, initial=start, directions=("up",), settle_periods=300
    )
    assert diagram.response_period.tolist() == [[[1, 1]]]
    (sliding,) = vc.equilibria(BLOCK)
    assert diagram.states[0, 0, 1, 0] == pytest.approx(list(sliding.state.values()), abs=1e-5)
    assert np.all(np.isnan(diagram.states[0, 0, 1, 1:]))
