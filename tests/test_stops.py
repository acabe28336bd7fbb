"""Capsules whose inner mass strikes stops: values of independent computations, closed forms, and the edge of a stop."""

import numpy as np
import pytest

import vibrocap as vc

# Capsule of Liu, Wiercigroch, Pavlovskaia and Yu 2013; orbit and drifts of an explicit method with events, at two
# tolerances near 3e-13 that agree to the digits shown. State (x1 - x2, x1', x2').
ORBIT = {"displacement": 0.528979080608, "displacement_rate": 1.358200939510 - 0.198433035833}
ORBIT |= {"velocity": 0.198433035833}
DRIFTS = {0.95: 1.094851234224, 0.90: 1.0631859624, 0.87: 0.2780241279, 0.85: -0.3078969820}


def capsule(frequency=0.95, **machine):
    friction = vc.Coulomb(coulomb_coefficient=1.0, static_coefficient=1.0)
    return vc.System(vc.VibroImpactCapsule(**machine), friction, vc.Harmonic(amplitude=1.6, frequency=frequency))


def test_orbit_of_the_vibro_impact_capsule():
    found = vc.orbit(capsule(), initial=ORBIT)
    for name, value in ORBIT.items():
        assert found.state[name] == pytest.approx(value, abs=2e-12)
    assert found.drift == pytest.approx(DRIFTS[0.95], abs=2e-12)
    multipliers = sorted(found.multipliers, key=lambda each: (abs(each), each.imag))
    assert np.abs(multipliers - np.array([0.0, -0.5601396 - 0.2332569j, -0.5601396 + 0.2332569j])).max() < 1e-7
    motion = found.motion()
    contact = [event for event in motion.events if event.kind not in ("impact", "stop_opened")]
    assert [event.kind for event in contact] == ["stick", "slip_back", "stick", "slip_forward"]
    times = [2.725821033604, 4.218539347500, 6.358066283753, 6.366473540435]
    assert [event.time for event in contact] == pytest.approx(times, abs=2e-12)
    stop = [event for event in motion.events if event not in contact]
    assert [event.kind for event in stop] == ["stop_opened", "impact"]
    assert [event.state["displacement"] for event in stop] == pytest.approx([0.02, 0.02], abs=1e-15)
    assert motion.certificate.ok


@pytest.mark.parametrize("frequency", [0.90, 0.87, 0.85])
def test_drift_of_the_vibro_impact_capsule(frequency):
    assert vc.orbit(capsule(frequency), initial=ORBIT).drift == pytest.approx(DRIFTS[frequency], abs=1e-10)


def test_period_doubling_of_the_vibro_impact_capsule():
    found = vc.branch(capsule(0.99), over="drive.frequency", between=(0.985, 1.0), initial=ORBIT)
    (flip,) = (each for each in found.special_points if each.kind.value == "flip")
    assert flip.parameter == pytest.approx(0.996238222, abs=1e-8)


@pytest.mark.parametrize(
    "machine",
    [
        {},
        pytest.param({"back_gap": 0.02, "actuation": "internal"}, marks=pytest.mark.slow),
        pytest.param({"back_gap": 0.3}, marks=pytest.mark.slow),
    ],
)
@pytest.mark.parametrize("law", [vc.Coulomb(1.0, 1.2), pytest.param(vc.LuGre(), marks=pytest.mark.slow)])
def test_measures_of_an_ensemble_are_those_of_single_motions(machine, law):
    """Over a few periods, before neighbouring motions part."""
    measures = ["drift", "drive_work", "damper_work", "contact_sliding_work", "mean_friction", "stick_fraction"]
    frequencies = np.linspace(0.8, 1.2, 5)
    system = vc.System(vc.VibroImpactCapsule(**machine), law, vc.Harmonic(amplitude=1.6, frequency=0.95))
    options = {"initial": ORBIT, "periods": 3, "tolerance": 1e-11}
    found = vc.ensemble(system, {"drive.frequency": frequencies}, measures=measures, window=3, **options)
    for i, frequency in enumerate(frequencies):
        motion = vc.simulate(system.with_parameters({"drive.frequency": float(frequency)}), **options)
        assert motion.certificate.ok
        assert (motion.event_kinds == "impact").sum() >= 2
        alone = vc.measured(motion, measures, window=3)
        for name in measures:
            assert found[name][i] == pytest.approx(alone[name], rel=1e-8, abs=1e-9)


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


def test_linear_capsule_without_friction_vibrates_in_closed_form():
    """z'' (lambda/(lambda+1)) = h cos(omega t) - rho z - nu z', and the common momentum stays."""
    machine = vc.TwoMassCapsule(mass_ratio=2.0, stiffness=1.3, damping=0.2, normal_load=0.0)
    system = vc.System(machine, vc.Coulomb(), vc.Harmonic(amplitude=0.7, frequency=1.1))
    response = 0.7 / (1.3 - (2.0 / 3.0) * 1.1**2 + 0.2j * 1.1)  # Re(response exp(i omega t))
    start = {"displacement": response.real, "displacement_rate": (1.1j * response).real}
    motion = vc.simulate(system, periods=3.3, initial=start | {"velocity": -start["displacement_rate"] / 3.0})
    assert motion.state["displacement"] == pytest.approx((response * np.exp(1.1j * motion.end)).real, abs=1e-9)
    assert np.abs(motion["momentum"]).max() < 1e-12


def test_linear_capsule_with_much_friction_is_an_oscillator():
    """The capsule holds, from outside and from inside alike: z'' = h cos(omega t) - rho z - nu z'."""
    ends = []
    for actuation in ("internal", "external"):
        machine = vc.TwoMassCapsule(normal_load=100.0, actuation=actuation)
        motion = vc.simulate(vc.System(machine, vc.Coulomb(), vc.Harmonic(amplitude=0.7, frequency=1.1)), periods=3)
        assert motion.state["velocity"] == 0.0
        ends.append(motion.state)
    assert ends[0] == ends[1]
    oscillator = vc.Oscillator(damping=0.1, normal_load=1.0)
    free = vc.simulate(
        vc.System(oscillator, vc.Coulomb(0.0, 0.0), vc.Harmonic(amplitude=0.7, frequency=1.1)), periods=3
    )
    assert ends[0]["displacement"] == pytest.approx(free.state["position"], abs=1e-8)


def test_actuation_and_gaps_are_refused_by_name():
    with pytest.raises(ValueError, match=r"actuation: should be \"internal\" .* got 'both'"):
        vc.TwoMassCapsule(actuation="both")
    with pytest.raises(ValueError, match=r"gap: should be at least 0, got -0.1"):
        vc.VibroImpactCapsule(gap=-0.1)
    with pytest.raises(ValueError, match=r"back_gap: should be a number >= 0, .* got -0.1"):
        vc.VibroImpactCapsule(back_gap=-0.1)
