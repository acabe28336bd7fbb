"""Laws that change within a small speed: nothing of them is stepped over, and a motion that misses it says so.

Yardstick: `sharp_motions.py`, an independent solver with a small largest step. A motion counts as sensitive where a
shift of its start by 1e-9 changes its events or grows a thousandfold; none of the 300 does.
"""

import functools
import json
from pathlib import Path

import numpy as np
import pytest

import vibrocap as vc
from plain_kernels import kernel_of, running_on
from thinned import exhaustive_but, slow_but
from vibrocap.laboratory.driven import driven_equations
from vibrocap.motion.recording.equations import equations, parameter_values
from vibrocap.numerics.codegen.resolution import system_sharpness, visible_speed
from vibrocap.numerics.run.budget import Budget
from vibrocap.numerics.run.ensemble import ensemble_run
from vibrocap.physics.friction.smoothed import smoothed

TABLE = json.loads(Path(__file__).with_name("sharp_motions.json").read_text(encoding="utf-8"))
TOLERANCES = (1e-6, 1e-9, 1e-12)
# The error of a step is of the order of the tolerance; over the hundreds of steps of such a motion, whose errors grow
# by `growth` as a shift of the start does, 100 tolerances are ample. (Largest found: 14.)
STEPS = 100.0
SENSITIVE = 1e3


def oscillator(**given):
    return vc.Oscillator(mass=1, stiffness=1, normal_load=1, **given)


DIP = vc.System(
    oscillator(damping=0.05, belt_speed=0.38586482190399185),
    vc.Stribeck(
        coulomb_coefficient=0.15,
        static_coefficient=0.45,
        stribeck_velocity=0.001,
        stribeck_exponent=2,
        viscous_damping=0,
    ),
    vc.Harmonic(amplitude=0.4581420135847618, frequency=0.31840840659290537),
)
DIP_START = {"position": 0.26819494181804693, "sliding_velocity": 0.003696111015576209}
# By the method of `sharp_motions.py`, steps of at most 0.01 at a tolerance of 1e-13.
DIP_EVENTS = (
    ("stick", 0.17533400607752953),
    ("slip_back", 1.4778605400671239),
    ("stick", 12.709914981661978),
    ("slip_back", 15.23051481410349),
    ("stick", 33.164962506811314),
    ("slip_back", 34.49738473314487),
)


def system_of(p: dict) -> vc.System:
    """The system of a row of the table."""
    levels = {"coulomb_coefficient": p["coulomb"], "static_coefficient": p["static"]}
    if p["law"] == "exponential":
        law = vc.Exponential(**levels, decay_rate=1.0 / p["width"])
    elif p["law"] == "stribeck":
        law = vc.Stribeck(**levels, stribeck_velocity=p["width"], stribeck_exponent=p["exponent"], viscous_damping=0)
    elif p["law"] == "lugre":
        bristles = {name: p[name] for name in ("bristle_stiffness", "bristle_damping")}
        law = vc.LuGre(**levels, **bristles, viscous_damping=0, stribeck_velocity=p["width"], stribeck_exponent=2)
    else:
        kind = vc.SmoothedTanh if p["law"] == "tanh" else vc.SmoothedArctan
        law = kind(
            **levels,
            stribeck_velocity=p["stribeck"],
            stribeck_exponent=2,
            smoothing_velocity=p["width"],
            viscous_damping=0,
        )
    if p["machine"] == "oscillator":
        machine = oscillator(damping=p["damping"], belt_speed=p["belt"])
    else:
        machine = vc.PendulumCapsule(
            **{name: p[name] for name in ("mass_ratio", "stiffness", "damping", "normal_load")}
        )
    return vc.System(machine, law, vc.Harmonic(amplitude=p["amplitude"], frequency=p["frequency"]))


def assert_as_the_yardstick(row: dict, tolerances: tuple[float, ...] = TOLERANCES):
    system = system_of(row)
    assert row["growth"] is not None
    assert row["growth"] < SENSITIVE
    for tolerance in tolerances:
        start = dict(zip(system.state_names, row["start"], strict=True))
        motion = vc.simulate(system, periods=TABLE["periods"], initial=start, tolerance=tolerance)
        error = np.abs(np.array(list(motion.state.values())) - row["final"]).max()
        kinds = [event.kind for event in motion.events if event.kind != "graze"]
        assert kinds == [kind for _, kind in row["events"]]
        assert error <= STEPS * tolerance * max(1.0, row["growth"])
        assert error <= 1e-3 or motion.certificate.estimated_error >= 1e-5
        assert motion.certificate.ok
        assert motion.status.ok


SYSTEMS = [(24, TOLERANCES), (36, (1e-9,)), (36, (1e-6, 1e-12))]


@pytest.mark.parametrize(("number", "tolerances"), slow_but([1], exhaustive_but([1, 2], SYSTEMS)))
def test_motions_with_sharp_friction(number, tolerances):
    """A capsule with bristles, an oscillator with a law of exponentials; the others are in the slow test below."""
    assert_as_the_yardstick(TABLE["systems"][number], tolerances)


@pytest.mark.slow
@pytest.mark.parametrize("tenth", exhaustive_but([7], range(10)))
def test_three_hundred_motions_with_sharp_friction(tenth):
    assert len(TABLE["systems"]) == 300
    for row in TABLE["systems"][tenth::10]:
        assert_as_the_yardstick(row)


def dip(tolerance=1e-9):
    return vc.simulate(DIP, periods=8, initial=DIP_START, tolerance=tolerance)


@pytest.mark.parametrize(("tolerance", "within"), slow_but([0], [(1e-9, 1e-7), (1e-12, 1e-8)]))
def test_a_dip_of_the_speed_is_not_stepped_over(tolerance, within):
    """At 1e-9 the worst event, after a glancing approach to rest, is 2e-8 off."""
    motion = dip(tolerance)
    assert [event.kind for event in motion.events] == [kind for kind, _ in DIP_EVENTS]
    assert [event.time for event in motion.events] == pytest.approx([time for _, time in DIP_EVENTS], abs=within)
    assert motion.certificate.ok


def test_without_the_proof_the_dip_is_missed_and_the_certificate_says_so():
    """The planted fault: no step is cut. The status says `not certified` as soon as the certificate is asked for."""
    with running_on(kernel_of(DIP), resolved=lambda real, lane, h: True):
        motion = dip()
        times = [event.time for event in motion.events]
        assert (
            len(times) != len(DIP_EVENTS)
            or max(abs(t - time) for t, (_, time) in zip(times, DIP_EVENTS, strict=True)) > 1e-5
        )
        assert motion.status is vc.Status.FINISHED
        certificate = motion.certificate
    assert not certificate.ok
    assert certificate.defect > 1e3 * motion.tolerance
    assert "equations" in certificate.failures[0]
    assert motion.status is vc.Status.NOT_CERTIFIED
    assert not motion.status.ok


@pytest.mark.slow
@pytest.mark.parametrize("law", slow_but([1], ["stribeck", "exponential", "lugre"]))
def test_lanes_see_what_single_motions_see(law):
    """The same systems side by side end where the yardstick ends."""
    rows = [row for row in TABLE["systems"] if row["law"] == law and row["machine"] == "oscillator"]
    rows = [row for row in rows if row.get("exponent", 2.0) == 2.0][:40]
    systems = [system_of(row) for row in rows]
    recorded = equations(systems[0])
    budget = Budget(TABLE["periods"], 1e-9, 10_000, 10_000_000, window=1)
    values = np.array([parameter_values(system) for system in systems])
    results = ensemble_run(recorded, values, np.array([row["start"] for row in rows]), budget)
    assert np.all(results.finished)
    for final, row in zip(results.state, rows, strict=True):
        assert np.abs(final - row["final"]).max() <= STEPS * 1e-9 * max(1.0, row["growth"])


@functools.cache
def stepped(law, tolerance):
    """A motion whose steps far from rest are long against the law's own speeds."""
    drive = vc.Harmonic(amplitude=1.8, frequency=1.0)
    return vc.simulate(vc.System(oscillator(damping=0.05, belt_speed=0.3), law, drive), periods=3, tolerance=tolerance)


# each law at one of two tolerances, in turn: another order of the series, another kernel
@pytest.mark.parametrize(
    ("law", "tolerance"),
    slow_but(
        [],
        exhaustive_but(
            range(0, 10, 2),
            [
                (vc.BoucWen(knee_exponent=20.0), 1e-6),
                (vc.BoucWen(knee_exponent=2.5), 1e-9),
                (vc.Dahl(shape_exponent=1.5), 1e-6),
                (vc.Stribeck(stribeck_velocity=2e-3, stribeck_exponent=1.7, viscous_damping=0.0), 1e-9),
                (vc.ElastoPlastic(stribeck_velocity=2e-3), 1e-6),
                (vc.MaxwellSlip(stribeck_velocity=2e-3), 1e-9),
                (vc.RateAndStateAgeing(direct_effect=0.01), 1e-6),
                (vc.anisotropic(vc.Stribeck)(stribeck_velocity=2e-3, viscous_damping=0.0, back_ratio=2.0), 1e-9),
                (vc.backlash(vc.LuGre)(stribeck_velocity=2e-3, gap=0.01), 1e-6),
                (smoothed(vc.Exponential)(decay_rate=300.0, smoothing_velocity=1e-3), 1e-9),
            ],
        ),
    ),
    ids=lambda value: getattr(value, "name", None),
)
def test_every_law_keeps_the_equations_within_every_step(law, tolerance):
    motion = stepped(law, tolerance)
    assert motion.run_status.ok, (
        motion.run_status
    )  # an error within the tolerance made a contact near rest turn for ever
    assert motion.certificate.ok, motion.certificate.failures


def test_sharp_functions_are_found_in_the_recorded_graph():
    """Those of the contact velocity or of an internal state of the law; none of the machine, whatever its functions."""

    def found(law):
        recorded = equations(vc.System(vc.PendulumCapsule(), law, vc.Harmonic()))
        sharp, _ = system_sharpness(recorded)
        return [recorded.graph.nodes[node][0] for node in sharp.nodes], sharp.internal

    assert found(vc.Coulomb()) == ([], False)
    assert found(vc.Exponential()) == (["exp"], False)
    assert found(vc.LuGre()) == (["exp", "div"], False)
    assert found(vc.BoucWen(knee_exponent=2.0)) == ([], False)
    assert found(vc.BoucWen(knee_exponent=20.0)) == (["power"], True)
    assert found(vc.SmoothedTanh()) == (["tanh", "exp"], False)


@pytest.mark.parametrize(
    ("law", "speed"),
    [
        (vc.LuGre(stribeck_velocity=0.01, stribeck_exponent=2.0), 0.05),
        (vc.LuGre(stribeck_velocity=0.01, stribeck_exponent=1.0), 0.25),
        (vc.ElastoPlastic(stribeck_velocity=0.02, stribeck_exponent=1.5), 0.02 * 25.0 ** (1.0 / 1.5)),
        (vc.Dahl(), 0.0),
    ],
    ids=lambda value: getattr(value, "name", ""),
)
def test_visible_speed_of_driven_laws(law, speed):
    """Where the exponential of |v/v_s|^alpha is e^-25, found from the graph; 0 where friction knows no speed."""
    recorded = driven_equations(law, ())
    values = np.array([[float(getattr(law, name) or 0.1) for name in recorded.parameter_names]])
    assert visible_speed(recorded.sharp, recorded.states, values, 1.0) == pytest.approx([speed], rel=1e-3)
