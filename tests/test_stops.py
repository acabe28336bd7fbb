"""Capsules whose inner mass strikes stops: values of independent computations, closed forms, and the edge of a stop."""

import collections
import math

import numpy as np
import pytest

import vibrocap as vc
from exact_stops import ExactCapsule
from thinned import exhaustive_but, slow_but
from vibrocap.motion.simulate import within_room

pytestmark = pytest.mark.plain

# Capsule of Liu, Wiercigroch, Pavlovskaia and Yu 2013; orbit and drifts of an explicit method with events, at two
# tolerances near 3e-13 that agree to the digits shown. State (x1 - x2, x1', x2').
ORBIT = {"displacement": 0.528979080608, "displacement_rate": 1.358200939510 - 0.198433035833}
ORBIT |= {"velocity": 0.198433035833}
DRIFTS = {0.95: 1.094851234224, 0.90: 1.0631859624, 0.87: 0.2780241279, 0.85: -0.3078969820}


IMPACTS = {
    "external": {"gap": 0.3, "restitution": 0.6, "actuation": "external", "normal_load": 0.4, "mass_ratio": 5.0},
    "two-sided": {"gap": 0.3, "back_gap": 0.4, "restitution": 0.8},
    "plastic": {"gap": 0.1, "restitution": 0.0},  # the masses stay together and part again
}


def capsule(frequency=0.95, **machine):
    friction = vc.Coulomb(coulomb_coefficient=1.0, static_coefficient=1.0)
    return vc.System(vc.VibroImpactCapsule(**machine), friction, vc.Harmonic(amplitude=1.6, frequency=frequency))


def counts(motion):
    """How often each kind of event occurs."""
    return collections.Counter(motion.event_kinds.tolist())


@pytest.mark.slow
@pytest.mark.parametrize("number", exhaustive_but(range(2), range(100)))
def test_events_of_random_capsules_are_those_in_closed_form(number):
    """At every tolerance, over twelve periods, alone and (impacts) in an ensemble; times as good as the tolerance."""
    draw = np.random.default_rng(1000 + number)
    machine = {"mass_ratio": draw.uniform(0.3, 8.0), "stiffness": draw.uniform(0.3, 2.0), "normal_load": 1.0}
    machine |= {"damping": draw.uniform(0.02, 0.4), "gap": draw.uniform(0.0, 0.6)}
    machine |= {"stop_stiffness": np.exp(draw.uniform(1.0, 4.6))}
    level = draw.uniform(0.1, 1.2)
    friction = {"coulomb_coefficient": level, "static_coefficient": level * draw.uniform(1.0, 1.5)}
    drive = {"amplitude": draw.uniform(0.8, 3.0), "frequency": draw.uniform(0.6, 1.5)}
    system = vc.System(vc.VibroImpactCapsule(**machine), vc.Coulomb(**friction), vc.Harmonic(**drive))
    start = {"displacement": -0.2, "displacement_rate": draw.uniform(-1.0, 1.0), "velocity": draw.choice([-0.5, 0.4])}
    exact = ExactCapsule(machine | friction | drive, [], int(np.sign(start["velocity"])), 0)
    expected = exact.events(list(start.values()), 12)
    for tolerance in (1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12):
        options = {"initial": start, "periods": 12, "tolerance": tolerance}
        motion = vc.simulate(system, **options)
        assert motion.event_kinds.tolist() == [kind for _, kind in expected]
        lanes = vc.ensemble(system, {"machine.gap": [machine["gap"]]}, measures=["impacts"], window=12, **options)
        assert lanes["impacts"][0] * 12.0 == pytest.approx(counts(motion)["impact"], abs=1e-9)
    assert motion.event_times == pytest.approx([time for time, _ in expected], abs=1e-8)


@pytest.mark.parametrize("tolerance", [1e-6, 1e-7])
def test_a_wall_that_opens_is_not_struck_again(tolerance):
    """Where the wall carries nothing to the tolerance only, the mass would go on by a force of that size."""
    machine = vc.RigidStopCapsule(gap=0.1, back_gap=0.1, restitution=0.0, mass_ratio=2.5)
    system = vc.System(machine, vc.Coulomb(0.3, 0.36), vc.Harmonic(amplitude=0.8, frequency=0.7))
    options = {"periods": 3, "tolerance": tolerance}
    motion = vc.simulate(system, **options)
    at_stops = motion.event_kinds[np.isin(motion.event_kinds, ["impact", "stop_opened"])]
    assert at_stops.tolist() == ["impact", "stop_opened"] * 6 + ["impact"]
    lanes = vc.ensemble(system, {"machine.gap": [0.1]}, measures=["impacts"], window=3, **options)
    assert lanes["impacts"][0] * 3.0 == pytest.approx(7.0, abs=1e-12)


@pytest.mark.slow
def test_an_impact_counts_once_with_stiff_bristles():
    """An implicit step that ends at the stop is made again until the guard vanishes at its end."""
    law = vc.LuGre(coulomb_coefficient=0.3, static_coefficient=0.36, bristle_stiffness=1e5, bristle_damping=300.0)
    system = vc.System(vc.VibroImpactCapsule(mass_ratio=2.4, gap=0.2), law, vc.Harmonic(amplitude=1.6, frequency=0.95))
    motions = [vc.simulate(system, periods=8, tolerance=tolerance) for tolerance in (1e-6, 1e-7, 1e-8)]
    assert all(counts(motion) == counts(motions[-1]) for motion in motions)
    assert all(motion.piece_implicit.any() for motion in motions[:2])
    for run in motions:
        met = run.event_times[np.isin(run.event_kinds, ["impact", "stop_opened"])]
        assert np.diff(met).min() > 1e-3


@pytest.mark.slow
def test_orbit_of_the_vibro_impact_capsule():
    orbit = vc.orbit(capsule(), initial=ORBIT)
    for name, value in ORBIT.items():
        assert orbit.state[name] == pytest.approx(value, abs=2e-12)
    assert orbit.drift == pytest.approx(DRIFTS[0.95], abs=2e-12)
    multipliers = sorted(orbit.multipliers, key=lambda each: (abs(each), each.imag))
    assert np.abs(multipliers - np.array([0.0, -0.5601396 - 0.2332569j, -0.5601396 + 0.2332569j])).max() < 1e-7
    motion = orbit.motion()
    contact = [event for event in motion.events if event.kind not in ("impact", "stop_opened")]
    assert [event.kind for event in contact] == ["stick", "slip_back", "stick", "slip_forward"]
    times = [2.725821033604, 4.218539347500, 6.358066283753, 6.366473540435]
    assert [event.time for event in contact] == pytest.approx(times, abs=2e-12)
    stop = [event for event in motion.events if event not in contact]
    assert [event.kind for event in stop] == ["stop_opened", "impact"]
    assert [event.state["displacement"] for event in stop] == pytest.approx([0.02, 0.02], abs=1e-15)
    assert motion.certificate.ok


@pytest.mark.slow
def test_a_start_inside_a_stop_chooses_its_branch_in_silence():
    """It is pressed in, and leaves the stop: nothing happens before; so it is counted in an ensemble, too."""
    inside = {"displacement": 0.5, "displacement_rate": -1.0, "velocity": 0.2}
    motion = vc.simulate(capsule(), periods=2, initial=inside)
    assert motion.state_names[4] == "touching"
    assert motion.piece_states(np.array([0]), np.array([0.0]))[4, 0] == 1.0
    assert "switch" not in motion.event_kinds
    assert motion.events[0].kind == "stop_opened"
    assert motion.events[0].time > 0.1
    struck = (motion.event_kinds == "impact").sum()
    options = {"measures": ["impacts"], "initial": inside, "periods": 2, "window": 2, "tolerance": 1e-11}
    assert vc.ensemble(capsule(), {"machine.gap": [0.02]}, **options)["impacts"] == struck / 2.0


@pytest.mark.slow
@pytest.mark.parametrize(("level", "rate", "kinds"), [(0.3, 0.0, ["impact"]), (-0.3, 0.0, []), (0.0, 0.3, ["impact"])])
def test_a_start_exactly_at_the_stop_is_decided_by_what_follows(level, rate, kinds):
    """At rest at the stop: pushed on, it touches; pulled away, it does not; at neither, the next derivative decides."""
    machine = vc.VibroImpactCapsule(gap=0.0, damping=0.0, normal_load=5.0)
    friction = vc.Coulomb(coulomb_coefficient=1.0, static_coefficient=1.0)
    motion = vc.simulate(vc.System(machine, friction, vc.Ramp(rate=rate, start=level)), periods=0.3)
    assert [event.kind for event in motion.events if event.time < 1e-9] == kinds
    pressed = motion.state["displacement"]
    assert pressed > 0.0 if kinds else pressed < 0.0
    # a mass on the springs 1 and, at the stop, 15, in a capsule that rests
    omega = np.sqrt(16.0) if kinds else 1.0
    t = motion.end
    expected = level * (1.0 - np.cos(omega * t)) / omega**2 + rate * (t - np.sin(omega * t) / omega) / omega**2
    assert pressed == pytest.approx(expected, abs=1e-9)


def test_a_mass_leaves_its_wall_though_a_stiff_law_makes_steps_short():
    """The capsule creeps, at a rate of 2e6: within its first steps the mass leaves the wall by rounding only."""
    law = vc.RateAndStateAgeing(0.3, 0.03, 0.06, 0.01, 0.1)
    drive = vc.Square(amplitude=1.2, frequency=1.3)
    motion = vc.simulate(
        vc.System(vc.RigidStopCapsule(), law, drive), periods=1, initial={"displacement": 0.2, "touching": 1}
    )
    assert [event.kind for event in motion.events] == ["stop_opened", "reversal"]
    assert motion.events[0].time == pytest.approx(0.5 * drive.period, rel=1e-14)
    assert motion.certificate.ok


def test_starts_of_basins_lie_between_the_stops():
    system = vc.System(vc.RigidStopCapsule(**IMPACTS["external"]), vc.Coulomb(0.3, 0.4), vc.Harmonic(1.6, 0.95))
    with pytest.raises(ValueError, match=r"plane: displacement should lie between the stops, -inf to 0.3, got"):
        vc.basins(system, {"displacement": (-1.0, 0.6), "displacement_rate": (-2.0, 2.0)}, 4)
    with pytest.raises(ValueError, match=r"ranges: displacement should lie between the stops"):
        vc.attractors(system, ranges={"displacement": (-1.0, 0.6)})


def test_a_case_that_starts_beyond_a_stop_is_refused_in_its_own_units(tmp_path, capsys):
    from vibrocap.cli import main as cli

    case = tmp_path / "case.toml"
    parts = '[friction]\nlaw = "coulomb"\n[drive]\nwaveform = "harmonic"\n'
    case.write_text(
        '[machine]\nkind = "rigid-stop-capsule"\ngap = 0.1\n[initial]\ndisplacement = 0.5\n' + parts, "utf-8"
    )
    assert cli.main(["simulate", str(case)]) == 2
    assert "initial.displacement: should be at most 0.1, where a stop stands, got 0.5" in capsys.readouterr().err
    scales = "inner_mass_kg = 0.1\nlength_unit_m = 0.01\ntime_unit_s = 0.02\n"
    machine = "capsule_mass_kg = 0.3\nstiffness_N_per_m = 250.0\ndamping_N_s_per_m = 0.5\nnormal_load_N = 1.0\n"
    start = '[machine]\nkind = "rigid-stop-capsule"\ngap_m = 0.002\n[initial]\ndisplacement_m = 0.003\n'
    drive = '[drive]\nwaveform = "harmonic"\namplitude_N = 1.0\nfrequency_Hz = 8.0\n'
    text = 'units = "SI"\n' + start.replace("[initial]", scales + machine + "restitution = 0.5\n[initial]")
    case.write_text(text + '[friction]\nlaw = "coulomb"\n' + drive, "utf-8")
    assert cli.main(["simulate", str(case)]) == 2
    words = "initial.displacement_m: should be at most 0.002 m, where a stop stands, got 0.003 m"
    assert words in capsys.readouterr().err


def bouncing(restitution):
    """A mass that a constant force drives against the wall of a free capsule: a ball that falls to the ground."""
    machine = vc.RigidStopCapsule(
        mass_ratio=2.0, restitution=restitution, gap=0.2, stiffness=0.0, damping=0.0, normal_load=0.0
    )
    return vc.System(machine, vc.Coulomb(0.0, 0.0), vc.Constant(force=0.3, duration=10.0))


@pytest.mark.parametrize("restitution", [0.0, 0.5, 0.95])
def test_bouncing_mass_has_its_closed_form(restitution):
    """Impact n at t_1 (1 + 2 (e + ... + e^n)), and rest at the wall from t_1 (1 + 2 e/(1 - e)) on."""
    speed = 2.0 if restitution > 0.9 else 0.0  # of both: no event of the contact then stands between two impacts
    motion = vc.simulate(bouncing(restitution), periods=8, tolerance=1e-11, initial={"velocity": speed})
    acceleration = 0.3 * (1.0 + 1.0 / 2.0)
    first = np.sqrt(2.0 * 0.2 / acceleration)
    times = motion.event_times[motion.event_kinds == "impact"]
    n = np.arange(len(times))
    expected = first * (1.0 + 2.0 * np.cumsum(restitution**n) - 2.0)
    fast = restitution**n > 1e-6  # the time to a slow impact is the rounding of its place over its speed
    assert np.abs(times - expected)[fast].max() < 1e-9
    assert abs(times[-1] - first * (1.0 + 2.0 * restitution / (1.0 - restitution))) < 1e-4
    assert motion.state == pytest.approx(
        {
            "displacement": 0.2,
            "displacement_rate": 0.0,
            "velocity": speed,
            "touching": 1.0,
            "position": speed * motion.end - 0.2 / 3.0,
        },
        abs=1e-13 * (1.0 + 80.0 * speed),
    )
    # of every impact: (1 - e^2) of the energy of the relative motion, here all of it in the end
    taken = motion.at(0.5 * (times[0] + (times[1] if len(times) > 1 else motion.end)), "impact_work")[0]
    energy = 0.5 * (2.0 / 3.0) * (acceleration * first) ** 2
    assert taken == pytest.approx(-(1.0 - restitution**2) * energy, rel=1e-12)
    assert vc.energy_balance(motion, (0.0, motion.end)).impact == pytest.approx(-energy, rel=1e-12)
    assert motion.certificate.ok
    assert max(motion.certificate.energy_residual, motion.certificate.momentum_residual) < 1e-13


def test_elastic_bouncing_keeps_all_energy():
    motion = vc.simulate(bouncing(1.0), periods=1.0, tolerance=1e-11)
    assert (motion.event_kinds == "impact").sum() == 5
    assert vc.energy_balance(motion, (0.0, motion.end)).impact == pytest.approx(0.0, abs=1e-14)


def test_a_start_beyond_a_rigid_stop_is_refused():
    system = vc.System(vc.RigidStopCapsule(gap=0.2, back_gap=0.1), vc.Coulomb(), vc.Harmonic())
    with pytest.raises(ValueError, match=r"initial.displacement should be at most 0.2, where a stop stands, got 0.3"):
        vc.simulate(system, initial={"displacement": 0.3})
    with pytest.raises(ValueError, match=r"initial.displacement should be at least -0.1, where a stop stands"):
        vc.simulate(system, initial={"displacement": -0.3})
    for over in ({"initial.displacement": [0.0, 0.3]}, {"machine.gap": [0.2, -0.1]}):
        with pytest.raises(ValueError, match=r"displacement should be at most 0.2|gap: should be at least 0"):
            vc.ensemble(system, over)
    with pytest.raises(ValueError, match=r"displacement should be at most 0.05, where a stop stands, got 0.1"):
        vc.ensemble(system, {"machine.gap": [0.2, 0.05]}, initial={"displacement": 0.1})


@pytest.mark.parametrize(
    ("given", "complaint"),
    [
        ({"touching": 2.0}, "initial.touching should be -1, 0 or 1, got 2"),
        ({"touching": 1.0}, "initial.displacement should be 0.2, as touching is 1, got 0"),
        ({"touching": -1.0}, "initial.touching should not be -1, as there is no stop"),
        (
            {"touching": 1.0, "displacement": 0.2, "displacement_rate": 0.5},
            "initial.displacement_rate should be 0, as touching is 1, got 0.5",
        ),
    ],
)
def test_a_start_that_says_it_touches_a_rigid_stop_is_at_rest_there(given, complaint):
    system = vc.System(vc.RigidStopCapsule(gap=0.2), vc.Coulomb(), vc.Constant(force=1.8))
    with pytest.raises(ValueError, match=complaint.replace(".", r"\.")):
        vc.simulate(system, initial=given)
    with pytest.raises(ValueError, match=complaint.replace(".", r"\.")):
        vc.ensemble(system, {f"initial.{name}": [value] for name, value in given.items()})
    there = {"touching": 1.0, "displacement": 0.2 + 1e-12}
    assert vc.simulate(system, initial=there, periods=0.01).state["touching"] == 1.0
    wider = system.with_parameters({"machine.gap": 0.3})
    assert within_room(wider, dict.fromkeys(system.state_names, 0.0) | there)["displacement"] == 0.3


@pytest.mark.parametrize("load", slow_but([0], ["weight", "dynamic"]))
def test_a_run_ends_where_the_pendulum_reaches_its_stop(load):
    """At the angle, exactly; up to there it is the motion without stops."""
    values = vc.Exponential(), vc.Harmonic(amplitude=1.8)
    stopped = vc.System(vc.PendulumCapsuleWithStops(limit_angle=0.8, normal_load=load), *values)
    motion = vc.simulate(stopped, periods=3, initial={"angle": 0.5})
    assert motion.status is vc.Status.STOP_REACHED
    assert motion.events[-1].kind == "stop_reached"
    assert motion.state["angle"] == pytest.approx(0.8, abs=1e-14)
    free = vc.simulate(vc.System(vc.PendulumCapsule(normal_load=load), *values), periods=3, initial={"angle": 0.5})
    assert motion.state["velocity"] == pytest.approx(free.at(motion.end, "velocity")[0], abs=1e-9)
    with pytest.raises(ValueError, match=r"initial.angle should be at least -0.8, where a stop stands, got -0.9"):
        vc.simulate(stopped, initial={"angle": -0.9})


@pytest.mark.slow
def test_a_pendulum_bounces_off_its_capsule():
    """Each impact keeps the momentum, turns the angular velocity to -e times it, and takes its share of energy."""
    machine = vc.PendulumCapsuleWithStops(limit_angle=0.8, restitution=0.6)
    system = vc.System(machine, vc.Exponential(), vc.Harmonic(amplitude=1.8))
    motion = vc.simulate(system, periods=4, initial={"angle": 0.5}, tolerance=1e-11)
    assert motion.certificate.ok
    times = motion.event_times[motion.event_kinds == "impact"]
    assert len(times) >= 6
    for time in times:
        border = int(np.argmin(np.abs(motion.piece_start - time)))
        ends = np.array([border - 1, border]), np.array([motion.piece_length[border - 1], 0.0])
        (_, before_rate, _, _, _), (_, after_rate, _, _, _) = motion.piece_states(*ends).T
        momentum, energy = motion.piece_observables(("momentum", "energy"), *ends)
        assert after_rate == pytest.approx(-0.6 * before_rate, rel=1e-12)
        assert momentum[1] == pytest.approx(momentum[0], abs=1e-13)
        share = (3.5 - np.cos(0.8) ** 2) / (2.0 * 3.5)
        assert energy[1] - energy[0] == pytest.approx(-(1.0 - 0.6**2) * share * before_rate**2, rel=1e-9)


def test_shapes_of_the_scene_move():
    """The mass is at X + z, the stop where the mass touches it."""
    from vibrocap.motion.shapes import moving_shapes

    motion = vc.simulate(capsule(), periods=2, initial=ORBIT)
    times = np.array([0.0, 1.0, motion.event_times[motion.event_kinds == "impact"][0]])
    table = {shape.shape.name: shape for shape in moving_shapes(motion, times)}
    mass, stop = table["inner mass"], table["stop in front"]
    expected = motion.at(times, "position") + motion.at(times, "displacement")
    assert mass.points[0, 0] == pytest.approx(expected, abs=1e-14)
    assert mass.points[0, 0, 2] + 0.5 * mass.shape.size[0] == pytest.approx(stop.points[0, 0, 2], abs=1e-12)


@pytest.mark.parametrize("limit", [0.3, 0.8, math.pi / 2, 2.0])
@pytest.mark.parametrize(("name", "side"), [("stop behind", 1.0), ("stop in front", -1.0)])
def test_the_bob_is_drawn_at_its_stop_where_it_touches_it(name, side, limit):
    """The line of the stop touches the disc of the bob, beside the middle of the stop; before that it lies free."""

    def gap(angle):
        shapes = vc.PendulumCapsuleWithStops(limit_angle=limit).scene(0.0, (side * angle, 0.0, 0.7, 0.0, 0.0))
        drawn = {shape.name: shape for shape in shapes}
        bob, (first, last) = np.array(drawn["bob"].places()[0]), np.array(drawn[name].places())
        along = (last - first) / np.linalg.norm(last - first)
        away = bob - first
        assert drawn["rod of bob"].places()[0] == (0.7, 0.5)
        assert 0.0 < away @ along < np.linalg.norm(last - first)
        return abs(away[0] * along[1] - away[1] * along[0]) - 0.5 * drawn["bob"].size[0]

    assert gap(limit) == pytest.approx(0.0, abs=1e-14)
    assert gap(limit - 0.1) == pytest.approx(math.sin(0.1 + math.asin(0.15)) - 0.15, abs=1e-14)


def test_actuation_and_gaps_are_refused_by_name():
    with pytest.raises(ValueError, match=r"actuation: should be \"internal\" .* got 'both'"):
        vc.TwoMassCapsule(actuation="both")
    with pytest.raises(ValueError, match=r"initial.touching should be a whole number, .* got 0.5"):
        vc.simulate(capsule(), periods=1, initial={"touching": 0.5})
    with pytest.raises(ValueError, match=r"gap: should be at least 0, got -0.1"):
        vc.VibroImpactCapsule(gap=-0.1)
    with pytest.raises(ValueError, match=r"back_gap: should be a number >= 0, .* got -0.1"):
        vc.VibroImpactCapsule(back_gap=-0.1)
    with pytest.raises(ValueError, match=r"restitution: should be at most 1, got 1.5"):
        vc.RigidStopCapsule(restitution=1.5)
    with pytest.raises(ValueError, match=r"restitution: should be at least 0, got -0.5"):
        vc.RigidStopCapsule(restitution=-0.5)
    with pytest.raises(ValueError, match=r"restitution: should be a number from 0 to 1, .* got 2.0"):
        vc.PendulumCapsuleWithStops(restitution=2.0)
    with pytest.raises(ValueError, match=r'restitution: should be left out with normal_load = "dynamic"'):
        vc.PendulumCapsuleWithStops(restitution=0.5, normal_load="dynamic")
