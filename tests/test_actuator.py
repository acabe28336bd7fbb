"""An actuator before the drive: an independent solver, orbits with its limits, and what is refused."""

import itertools
import math

import numpy as np
import pytest
import scipy.optimize
from scipy.integrate import solve_ivp

import vibrocap as vc
from cases import DEFAULTS
from vibrocap.cli.main import main
from vibrocap.physics.closed_loop.actuator import ActuatedMachine
from vibrocap.physics.mechanics.parts import Stop
from vibrocap.physics.mechanics.stops import switch_events

pytestmark = pytest.mark.plain

LAG = 0.7
LIMITS = {"time_constant": LAG, "limit": 0.8, "command_limit": 1.5}
TWO_TONES = vc.Biharmonic(1.8, 1.3, 0.5, 0.7)
START = {"angle": 0.3}


def capsule(drive=None, law=None, **actuator):
    law = law or vc.Exponential(coulomb_coefficient=0.1, static_coefficient=0.2)
    return vc.System(vc.PendulumCapsule(), law, drive or vc.Harmonic(1.8, 1.3), actuator=vc.Actuator(**actuator))


# --- another solver ---------------------------------------------------------------------------------------------------


def followed(command, lag, end):
    """(events, output at the end) of u' = (c - u)/T by DOP853, both held at their limits."""
    grid = np.linspace(0.0, end, 2_001)

    def beyond(t):
        return abs(command(t)) - lag.command_limit

    pairs = [pair for pair in itertools.pairwise(grid.tolist()) if beyond(pair[0]) * beyond(pair[1]) < 0.0]
    cuts = [scipy.optimize.brentq(beyond, *pair, xtol=1e-15) for pair in pairs]
    events = [(t, "clipped" if beyond(t + 1e-6) > 0.0 else "unclipped") for t in cuts]
    u, saturated = 0.0, 0.0

    def asked(t):
        return float(np.clip(command(t), -lag.command_limit, lag.command_limit))

    for start, stop in itertools.pairwise([0.0, *cuts, end]):
        t = start
        while t < stop:

            def rate(t, y, saturated=saturated):
                return [0.0 if saturated else (asked(t) - y[0]) / lag.time_constant]

            def limit(t, y, saturated=saturated):
                return saturated * asked(t) - lag.limit if saturated else lag.limit - abs(y[0])

            limit.terminal, limit.direction = True, -1.0
            run = solve_ivp(rate, (t, stop), [u], "DOP853", events=limit, rtol=1e-13, atol=1e-14, max_step=0.02)
            t, u = float(run.t[-1]), float(run.y[0, -1])
            if run.status == 1:
                events.append((t, "unsaturated" if saturated else "saturated"))
                saturated = 0.0 if saturated else math.copysign(1.0, u)
                u = saturated * lag.limit if saturated else u
    return sorted(events), u


@pytest.mark.slow
def test_output_behind_both_limits_is_that_of_an_independent_solver():
    """The machine does not act back on it; what it does under the output is tested state by state below."""
    system = capsule(TWO_TONES, **LIMITS)
    motion = vc.simulate(system, periods=3, initial=START, tolerance=1e-11)
    events, output = followed(TWO_TONES.value, system.actuator, motion.end)
    own = [(e.time, e.kind) for e in motion.events if e.kind.endswith(("saturated", "clipped"))]
    assert [kind for _, kind in own] == [kind for _, kind in events]
    assert len(own) >= 18
    assert [time for time, _ in own] == pytest.approx([time for time, _ in events], abs=1e-9)
    assert motion.state["actuator_output"] == pytest.approx(output, abs=1e-9)
    assert motion.certificate.ok
    balance = vc.energy_balance(motion)
    power = motion["actuator_output"] * motion["angle_rate"]
    assert balance.drive == pytest.approx(np.trapezoid(power, motion.time), abs=1e-4)


# --- what is made of motions ------------------------------------------------------------------------------------------


def test_every_machine_that_a_force_drives_takes_an_actuator():
    from vibrocap.physics.catalogue import machines

    for make in machines().values():
        if make.imposes_motion:
            with pytest.raises(ValueError, match=rf"actuator should be left out: .* a motion on the {make.name}"):
                vc.System(make(), vc.Coulomb(), vc.Triangle(), actuator=vc.Actuator())
            continue
        machine = make()
        system = vc.System(machine, vc.Coulomb(), vc.Harmonic(1.3), actuator=vc.Actuator(**LIMITS))
        placed, t = system.placed, 0.4
        assert isinstance(placed, ActuatedMachine)
        assert len(placed.states) == len(placed.symmetry) == len(placed.scales(2.0)) == len(system.state_names)
        y = tuple(0.1 * (i + 1) if name not in placed.switched else 0.0 for i, name in enumerate(system.state_names))
        y = (*y[: placed.states.index("actuator_output")], 0.6, 0.0, 0.0)
        plain = vc.System(machine, vc.Coulomb(), vc.Constant(0.6))
        flow, expected = system.flow(t, y, 1), plain.flow(t, y[:-3], 1)
        rate = (1.3 * math.cos(t) - 0.6) / LAG
        assert flow.rates == (*expected.rates, rate, 0.0, 0.0)
        assert (flow.powers, flow.contacts[0].held) == (expected.powers, expected.contacts[0].held)


# --- cases, units and refusals ----------------------------------------------------------------------------------------

CASE = f"""{DEFAULTS.replace("harmonic", "square")}
[actuator]
time_constant = 0.4
limit = 1.2
[initial]
actuator_output = {{output}}
"""


def test_a_case_with_an_actuator_in_si_and_without_units(tmp_path, capsys):
    path = tmp_path / "case.toml"
    path.write_text(CASE.format(output=0.3))
    case = vc.read_case(path)
    assert case.system.actuator == vc.Actuator(0.4, 1.2)
    assert vc.read_case(case.save(tmp_path / "again.toml")) == case
    in_si = tmp_path / "si.toml"
    scales = "pendulum_mass_kg=0.2,pendulum_length_m=0.25"
    assert main(["new", "--from", str(path), "--scales", scales, "--out", str(in_si)]) == 0
    text = in_si.read_text()
    assert all(key in text for key in ("[actuator]\ntime_constant_s = ", "limit_N_m = ", "actuator_output_N_m = "))
    again = vc.read_case(in_si)
    assert again.system.actuator.time_constant == pytest.approx(0.4, rel=1e-12)
    assert again.system.si.unit("actuator_output") == again.system.si.unit("command") == "N m"


@pytest.mark.parametrize(
    ("change", "complaint"),
    [
        (
            ("{output}", "1.3"),
            "initial.actuator_output: should be at most 1.2, where the actuator has its limit, got 1.3",
        ),
        (("= 0.4", "= 0"), "actuator.time_constant: should be greater than 0, got 0"),
        (("limit = 1.2", "limit = -1"), "actuator.limit: should be greater than 0, got -1"),
        (("limit = 1.2", "limits = 1"), "actuator.limits: no such key; did you mean 'limit'?"),
        (("[actuator]", "[drive.actuator]"), "drive.actuator: no such key"),
    ],
)
def test_what_an_actuator_cannot_be_is_refused_by_name(change, complaint, tmp_path):
    path = tmp_path / "case.toml"
    path.write_text(CASE.replace(*change).replace("{output}", "0"))
    with pytest.raises(vc.CaseError) as caught:
        vc.read_case(path)
    assert complaint in str(caught.value)


def test_events_of_a_stop_and_of_a_limit_are_told_apart():
    """A stop in front only has two guards; those of the limit follow: each event is at its own border."""
    actuator = vc.Actuator(time_constant=0.4, limit=1.0)
    drive = vc.Harmonic(amplitude=1.6, frequency=0.95)
    system = vc.System(vc.VibroImpactCapsule(), vc.Coulomb(0.3, 0.4), drive, actuator=actuator)
    motion = vc.simulate(system, periods=5)
    sides = {"impact": ("touching", 1.0), "stop_opened": ("touching", 0.0)}
    sides |= {"saturated": ("saturated", 1.0), "unsaturated": ("saturated", 0.0)}
    told = [event for event in motion.events if event.kind in sides]
    assert {str(event.kind) for event in told} == set(sides)
    for event in told:
        state, side = sides[event.kind]
        assert abs(event.state[state]) == side
        border = (
            event.state["displacement"] / system.machine.gap if state == "touching" else event.state["actuator_output"]
        )
        assert abs(border) == pytest.approx(1.0, rel=1e-9)
    both = vc.simulate(system, periods=3, start=motion)
    assert vc.measured(both, ["impacts"], window=3)["impacts"] * 3 == both.event_kinds.tolist().count("impact")


def test_events_of_several_stops_are_those_of_their_guards():
    front, both = Stop(0.0, gap=0.1, stiffness=2.0), Stop(0.0, gap=0.1, back_gap=0.2, restitution=0.5)
    assert switch_events([front, both]) == ("impact", "stop_opened", "impact", "stop_opened", "impact")
    assert vc.VibroImpactCapsule().switch_events == ("impact", "stop_opened")
    assert vc.VibroImpactCapsule(back_gap=0.1).switch_events == ("impact", "stop_opened", "impact")
