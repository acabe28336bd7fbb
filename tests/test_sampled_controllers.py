"""Sampled controllers: numbers at 1 kHz, exact parabolas between samples, sweeps over time, what is refused."""

import math
import re

import numpy as np
import pytest

import vibrocap as vc
from thinned import slow_but

GAINS = {"proportional_gain": 3.0, "integral_gain": 4.0, "derivative_gain": 6.0}
START = {"position": -1.0}
ROUNDING = 1e-12
TRACKED = vc.Harmonic(0.3, 2.0 * math.pi)


def servo(drive=None, machine=None, **controller):
    position = vc.SampledPositionPID(**(GAINS | {"sample_time": 0.02} | controller))
    return vc.System(
        machine or vc.Oscillator(stiffness=0.0), vc.Coulomb(1.0, 1.5), drive or vc.Constant(), controller=position
    )


# --- an independent loop: exact parabolas ----------------------------------------------------------------------------


def moved(x, v, u, length, time):
    """(x, v, times of coming to rest) of a block under a constant force u, kinetic level 1, static level 1.5."""
    stops, left = [], length
    while left > 0.0:
        if v == 0.0 and abs(u) <= 1.5:
            break
        side = math.copysign(1.0, v if v != 0.0 else u)
        a = u - side
        rest = -v / a if v != 0.0 and v * a < 0.0 else math.inf
        h = min(rest, left)
        x, v = x + v * h + 0.5 * a * h * h, 0.0 if h == rest else v + a * h
        left -= h
        if h == rest:
            stops.append((time + length - left, x))
    return x, v, stops


def sampled_loop(periods, h, delay=0.0, limit=math.inf, quantum=None, anti_windup=0.0, reference=None):
    """((x, v, u, S) at the end, every coming to rest) of the law in a processor, e = r - x.

    A sample at the last instant is taken.
    """
    reference = reference or (lambda t: (0.0, 0.0))
    x, v, u, integral, stops = -1.0, 0.0, 0.0, 0.0, []
    samples = round(periods / h)
    for k in range(samples + 1):
        seen = x if quantum is None else quantum * round(x / quantum)
        r, slope = reference(k * h)
        raw = 3.0 * (r - seen) + 6.0 * (slope - v) + integral
        new = min(max(raw, -limit), limit)
        integral += 4.0 * h * (r - seen + anti_windup * (new - raw))
        if k == samples:
            return (x, v, u if delay else new, integral), stops
        for force, start, length in ((u, k * h, delay), (new, k * h + delay, h - delay)):
            x, v, found = moved(x, v, force, length, start)
            stops += found
        u = new
    raise AssertionError


# --- values ----------------------------------------------------------------------------------------------------------


@pytest.mark.plain
@pytest.mark.parametrize(
    "given",
    slow_but(
        [3],
        [
            {"sample_time": 0.02},
            {"sample_time": 0.05, "delay": 0.013},
            {"sample_time": 0.02, "limit": 2.2},
            {"sample_time": 0.1, "limit": 1.8, "anti_windup": 0.5, "delay": 0.06},
            {"sample_time": 0.02, "quantum": 0.05, "delay": 0.005},
        ],
    ),
)
def test_between_samples_motions_are_the_parabolas_of_an_independent_loop(given):
    motion = vc.simulate(servo(**given), periods=8, initial=START, tolerance=1e-13)
    named = dict(given)
    (x, v, u, integral), stops = sampled_loop(8, named.pop("sample_time"), **named)
    states = [motion.state[name] for name in ("position", "sliding_velocity", "held_command", "integral_command")]
    assert states == pytest.approx([x, v, u, integral], abs=ROUNDING)
    at_rest = [event for event in motion.events if event.kind in ("stick", "reversal")]
    assert [each.time for each in at_rest] == pytest.approx([time for time, _ in stops], abs=ROUNDING)
    assert np.max(np.abs(motion["drive"])) <= given.get("limit", math.inf) * (1.0 + 4e-16)


def test_samples_and_actions_are_at_whole_multiples_exactly():
    """k h and k h + d to the last bit or so, without a clock that drifts."""
    motion = vc.simulate(servo(sample_time=1e-3, delay=3e-4, drive=vc.Constant(duration=2.0)), periods=4, initial=START)
    times = np.array([event.time for event in motion.events if event.kind == "sample"])
    expected = np.sort(np.concatenate((np.arange(1, 8001) * 1e-3, np.arange(8000) * 1e-3 + 3e-4)))
    assert times == pytest.approx(expected, abs=4e-15)  # four roundings at 8


@pytest.mark.plain
def test_a_reference_in_motion_is_taken_at_the_samples():
    motion = vc.simulate(servo(sample_time=0.05, drive=TRACKED), periods=3, initial=START, tolerance=1e-13)

    def reference(t):
        return 0.3 * math.cos(2.0 * math.pi * t), -0.6 * math.pi * math.sin(2.0 * math.pi * t)

    (x, v, *_), _ = sampled_loop(3, 0.05, reference=reference)
    assert [motion.state["position"], motion.state["sliding_velocity"]] == pytest.approx([x, v], abs=1e-11)
    expected = [reference(0.05 * math.floor(t / 0.05))[0] for t in (0.02, 0.12, 0.61)]
    assert motion.at([0.02, 0.12, 0.61], "reference") == pytest.approx(expected, abs=ROUNDING)
    first = vc.simulate(motion.system, periods=1.52, initial=START, tolerance=1e-13)  # and on, within a sample
    rest = vc.simulate(motion.system, start=first, periods=1.48, tolerance=1e-13)
    assert rest.state == pytest.approx(motion.state, abs=1e-11)


@pytest.mark.slow  # its kernel
def test_a_stepper_takes_a_reference_in_motion_at_the_samples():
    """Its table is written by the kernel, one sample after another; sines are rounded otherwise there."""
    system = servo(sample_time=0.05, drive=TRACKED, delay=0.013)
    motion = vc.stepper(system, initial=START, tolerance=1e-13)
    motion.step(3.0)
    known = vc.simulate(system, periods=3, initial=START, tolerance=1e-13)
    assert motion.states[:2] == pytest.approx([*known.state.values()][:2], abs=1e-12)


@pytest.mark.plain
def test_a_fast_loop_tends_to_the_continuous_one():
    """Their distance is of the first order in h."""
    exact = vc.System(
        vc.Oscillator(stiffness=0.0), vc.Coulomb(1.0, 1.5), vc.Constant(), controller=vc.PositionPID(3.0, 4.0, 6.0)
    )
    there = vc.simulate(exact, periods=3, initial=START, tolerance=1e-12).state["position"]
    off = [
        abs(vc.simulate(servo(sample_time=h), periods=3, initial=START).state["position"] - there)
        for h in (0.02, 0.01, 0.005)
    ]
    assert off[0] / off[1] == pytest.approx(2.0, abs=0.2)
    assert off[1] / off[2] == pytest.approx(2.0, abs=0.1)


# --- its place in the house ------------------------------------------------------------------------------------------


def test_a_case_in_si_has_its_times_in_seconds(tmp_path):
    system = servo(sample_time=0.01, delay=0.002, quantum=0.001, limit=2.0)
    path = vc.save_case(system, tmp_path / "servo.toml", initial=START, periods=2)
    assert vc.read_case(path).system == system
    scaled = vc.System(system.machine, system.friction, system.drive, vc.SIScales(), controller=system.controller)
    text = vc.save_case(scaled, tmp_path / "si.toml").read_text()
    assert all(key in text for key in ("sample_time_s", "delay_s", "quantum_m", "limit_N"))
    assert vc.read_case(tmp_path / "si.toml").system == scaled


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda: vc.SampledPositionPID(sample_time=0.0), "sample_time: should be greater than 0, got 0.0"),
        (lambda: servo(sample_time=0.3), "controller.sample_time should be a whole part of the period 1 of the drive"),
        (lambda: servo(delay=0.02), "controller.delay should be less than the sample time 0.02, got 0.02"),
        (lambda: vc.orbit(servo(quantum=0.01)), "controller.quantum should be left out: with rounded measurements"),
        (
            lambda: vc.branch(servo(drive=TRACKED), "drive.frequency", (6.0, 7.0)),
            "over: drive.frequency decides how many samples a period has",
        ),
        (
            lambda: vc.bifurcation_diagram(servo(drive=TRACKED), "controller.sample_time", (0.01, 0.02)),
            "over: controller.sample_time decides how many samples a period has",
        ),
        (lambda: vc.equilibria(servo()), "should not be driven in time"),
        (lambda: vc.stepper(vc.Case(servo()), input="drive"), "input should be None with a sampled-position-pid"),
        (lambda: servo(drive=vc.Square(0.5, 2.0 * math.pi)), "drive should have no corners"),
    ],
)
def test_what_makes_no_sense_is_refused_by_name(make, said):
    with pytest.raises(ValueError, match=re.escape(said)):
        make()
