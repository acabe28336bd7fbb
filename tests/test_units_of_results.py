"""What is computed in SI answers in SI: arrays, tables, cards, measures, orbits, branches, crossings and basins.

Each number of a motion is that of the same system without units times its scale, written out here by hand (of other
results see `test_counting_units.py` and `test_views.py`); `dimensionless` gives the numbers without units, to the last
bit; and every number of every public result declares what it is.
"""

import dataclasses
import inspect
import math
import pickle
import re
from pathlib import Path

import numpy as np
import pytest

import vibrocap as vc
from vibrocap.arguments import ArgumentError
from vibrocap.measures import standard
from vibrocap.quantities.dimensional import Dimensional, InSI, computed
from vibrocap.quantities.hints import call_hints, field_hints, undeclared

METRE, KILOGRAM, GRAVITY = 0.25, 0.2, 9.80665
SECOND = math.sqrt(METRE / GRAVITY)
NEWTON, SPEED = KILOGRAM * GRAVITY, METRE / SECOND
STATES = {"angle": 1.0, "angle_rate": 1 / SECOND, "position": METRE, "velocity": SPEED}
SCALED = vc.FreeScales(2.0, 0.1, 0.5)
CLOSE = {"rel": 1e-13, "abs": 1e-15}  # a few roundings of scales that are products of powers


def bench() -> vc.System:
    """A bench in SI, under two tones, so that there is one steady motion, which travels."""
    return vc.System(
        machine=vc.PendulumCapsule.in_si(
            capsule_mass_kg=0.5,
            pendulum_mass_kg=KILOGRAM,
            pendulum_length_m=METRE,
            stiffness_N_m_per_rad=0.98,
            damping_N_m_s_per_rad=0.08,
            normal_load="weight",
        ),
        friction=vc.Exponential.in_si(decay_rate_s_per_m=6.5),
        drive=vc.Biharmonic.in_si(amplitude_N_m=0.9, second_amplitude_N_m=0.4, frequency_Hz=1.0),
    )


@pytest.fixture(scope="module")
def motions():
    """A motion in SI, and the same of the system without units."""
    system = bench()
    start = {"position_m": 0.1, "angle": 0.5}
    return vc.simulate(system, periods=12, initial=start), vc.simulate(
        system.dimensionless, periods=12, initial={"position": 0.1 / METRE, "angle": 0.5}
    )


# --- motions ----------------------------------------------------------------------------------------------------------
def test_arrays_tables_and_labelled_arrays_of_a_motion_are_the_same_numbers(motions):
    found, plain = motions
    table = found.to_pandas()
    for name, scale in STATES.items():
        assert found[name] == pytest.approx(plain[name] * scale, **CLOSE)
        assert found.state[name] == pytest.approx(plain.state[name] * scale, **CLOSE)
        assert table[name].iloc[-1] == found[name][-1]
        assert found.to_xarray()[name].values[-1] == found[name][-1]
        assert found.states(found.end)[found.state_names.index(name), 0] == pytest.approx(found.state[name], **CLOSE)
    assert found.time == pytest.approx(plain.time * SECOND, **CLOSE)
    assert table.index[-1] == found.time[-1]
    assert found.at(1.5, "velocity") == pytest.approx(plain.at(1.5 / SECOND, "velocity") * SPEED, rel=1e-11)
    assert found.crossings("position", 0.05) == pytest.approx(plain.crossings("position", 0.2) * SECOND, rel=1e-12)
    assert found["drive_work"][-1] == pytest.approx(plain["drive_work"][-1] * NEWTON * METRE, **CLOSE)
    names = ("time", "period", "position", "velocity", "friction", "drive", "drive_work", "side")
    assert [found.unit_of(name) for name in names] == ["s", "s", "m", "m/s", "N", "N m", "J", "1"]
    assert {plain.unit_of(name) for name in names} == {"1"}


def test_events_and_phases_are_in_si(motions):
    found, plain = motions
    assert len(found.events) == len(plain.events) > 0
    assert [phase.length for phase in found.phases] == pytest.approx([x.length * SECOND for x in plain.phases], **CLOSE)
    assert found.events.to_pandas()["position"].iloc[0] == found.events[0].state["position"]
    assert "<th>time [s]</th>" in found.events._repr_html_()
    assert "<th>position [m]</th>" in found.events._repr_html_()
    assert "<th>time</th>" in plain.events._repr_html_()
    assert re.match(r"Event\(time=[\d.]+ s, kind='stick', state=\{'angle': [\d.]+ rad, ", repr(found.events[0]))


def test_the_numbers_without_units_are_asked_for_by_name(motions):
    found, plain = motions
    assert found.dimensionless == plain
    assert plain.dimensionless is plain
    assert found.dimensionless.system.units is None
    table = found.dimensionless.to_pandas()
    assert np.array_equal(table["position"], plain["position"])
    assert vc.mean_velocity(found.dimensionless) == vc.mean_velocity(plain)
    for known, unit in ((found, " [m]"), (found.dimensionless, "")):
        label = vc.plot(known).get_ylabel()
        assert label.endswith(unit)
        assert unit or "[" not in label


def test_cards_and_words_say_their_units(motions):
    found, plain = motions
    assert f"position = {found.state['position']:.5g} m" in found._repr_html_()
    assert f"time 0 to {found.end:.6g} s" in repr(found)
    assert " m" not in plain.facts["end"]


def test_what_a_motion_in_si_says_goes_into_another(motions):
    """The states of a result have the units of the result, wherever they are given."""
    found, _ = motions
    again = vc.simulate(found.system, periods=1, initial=found.state)
    assert again["position"][0] == found.state["position"]
    onward = vc.simulate(found.system, periods=1, start=found)
    assert onward.time[0] == found.end
    assert onward["position"][0] == pytest.approx(found.state["position"], rel=1e-15)
    later = vc.simulate(found.system, periods=0.1, start=vc.Start(time=3.0))
    assert later.start_time == pytest.approx(3.0, rel=1e-15)
    assert vc.simulate(found.system, periods=0.1, start=3.0).start_time == later.start_time


def test_a_motion_in_si_is_a_result_like_any_other(motions):
    found, plain = motions
    assert isinstance(found, vc.Trajectory)
    back = pickle.loads(pickle.dumps(found))
    assert back == found
    assert back.state == found.state
    assert found != plain
    for name in ("coefficients", "series"):
        with pytest.raises(AttributeError, match=rf"{name} of a Trajectory is known without units only"):
            getattr(found, name)
    with pytest.raises(TypeError, match="make another one of its `dimensionless`"):
        dataclasses.replace(vc.mean_velocity(found), value=1.0)


# --- measures ---------------------------------------------------------------------------------------------------------


def test_a_measure_of_ones_own_is_in_the_unit_that_it_declares(motions):
    found, plain = motions
    declared = vc.Measure.largest("largest_push", "largest friction", lambda now: now.friction, si_unit="N")
    bare = vc.Measure.largest("largest_bare", "the same without a unit", lambda now: now.friction)
    taken, same = vc.measured(found, [declared, bare]), vc.measured(plain, [declared, bare])
    assert taken["largest_push"] == pytest.approx(same["largest_push"] * NEWTON, **CLOSE)
    assert taken["largest_bare"] == same["largest_bare"]


def test_to_know_one_unit_no_other_measure_is_made(monkeypatch):
    """Of the measures of one system only: those of every machine are for lists and for names that it does not have."""

    def asked():
        raise AssertionError("every machine was asked")

    monkeypatch.setattr(standard, "machines", asked)
    standard._standard_measures.cache_clear()
    assert vc.measured(vc.simulate(bench(), periods=2), ["drive_work"])["drive_work"] != 0.0


# --- further results --------------------------------------------------------------------------------------------------


@pytest.mark.plain
def test_rates_of_the_bristles_of_further_contacts_are_speeds():
    law = vc.LuGre(bristle_stiffness=20.0, bristle_damping=2.0)
    plain = vc.System(vc.ThreeBodyCrawler(), law, vc.Harmonic(amplitude=0.5))
    found, same = (vc.simulate(one, periods=1) for one in (dataclasses.replace(plain, units=SCALED), plain))
    for name in ("bristle_rate", "bristle_rate_2", "bristle_rate_3"):
        assert found.unit_of(name) == "m/s"
        assert found[name] == pytest.approx(same[name] * 0.1 / 0.5, **CLOSE)


@pytest.mark.plain
def test_words_of_branches_and_certificates_are_in_si():
    """A block on a belt beside its Hopf point, and a light capsule that its constant load keeps down."""
    block = vc.read_case("examples/slides-or-sticks-by-its-start.toml").system
    sliding = vc.equilibrium_branch(dataclasses.replace(block, units=SCALED), "machine.belt_speed_m_per_s", (0.05, 0.8))
    born = vc.hopf_cycles(sliding, points=4).special_points[0]
    assert born.frequency == pytest.approx(1.0 / 0.5, rel=1e-9)
    assert born.remarks == "omega 2 rad/s; cycles are born; subcritical"
    still = sliding.system.with_parameters({"machine.belt_speed": 0.0})
    with pytest.raises(ArgumentError, match="belt_speed = 0 m/s, but no such state was found"):
        vc.equilibrium_branch(still, "machine.belt_speed", (0.0, 0.1))
    light = bench().with_parameters({"machine.capsule_mass_kg": 0.02, "drive.amplitude_N_m": 3.0})
    motion = vc.simulate(light, periods=1)
    (words,) = motion.certificate.warnings
    time, force = re.search(r"about time (\S+) s, down to (\S+) N", words).groups()
    assert float(force) == pytest.approx(motion.certificate.least_reaction * NEWTON, rel=1e-3)
    assert 0.0 <= float(time) < motion.end


def test_what_holds_quantities_of_several_units_refuses_one_unit(motions):
    with pytest.raises(ArgumentError, match="holds several, each with its own unit"):
        motions[0].events[0].unit_of("state")


def test_no_record_has_members_of_those_in_si():
    taken = set(InSI.__annotations__)
    for record in (var for var in vars(vc).values() if inspect.isclass(var) and issubclass(var, Dimensional)):
        assert not taken & set(dir(record)), record


# --- the rule ---------------------------------------------------------------------------------------------------------
KNOWN_WITHOUT_UNITS = {  # which a result in SI refuses to give: they belong to the equations as they were integrated
    ("Trajectory", "coefficients"),
    ("Trajectory", "series"),
    ("Trajectory", "observe"),
}
OF_NO_SYSTEM = {  # records of the computation itself, and of shares
    "Certificate",
    "ZeroOneTest",
    "Section",
}


def public_records():
    """The public results of the rooms that are given systems and motions."""
    rooms = ("motion", "measures", "orbits", "design")
    names = (getattr(vc, name) for name in vc.__all__)
    return [
        name
        for name in names
        if inspect.isclass(name) and dataclasses.is_dataclass(name) and name.__module__.split(".")[1] in rooms
    ]


@pytest.mark.parametrize("record", public_records(), ids=lambda each: each.__name__)
def test_every_number_of_a_result_declares_what_it_is(record):
    numbers = [name for name, hint in field_hints(record).items() if undeclared(hint)]
    if not issubclass(record, Dimensional):
        assert not numbers or record.__name__ in OF_NO_SYSTEM
        return
    assert {(record.__name__, name) for name in numbers} <= KNOWN_WITHOUT_UNITS
    for name, member in inspect.getmembers_static(record, lambda each: isinstance(each, property)):
        without = (record.__name__, name) in KNOWN_WITHOUT_UNITS
        assert without or not undeclared(call_hints(member.fget).get("return")), name


def test_no_room_goes_through_the_public_functions():
    """They answer in SI; inside, all is computed without units."""
    package = Path(vc.__file__).parent
    through = re.compile(r"^\s*(?:from vibrocap import (.*)|import (vibrocap)\s*)$", re.MULTILINE)
    values = {
        (str(path.relative_to(package)), name)
        for path in package.rglob("*.py")
        for names in through.findall(path.read_text(encoding="utf-8"))
        for name in "".join(names).split(", ")
        if not (package / name).is_dir() and not (package / f"{name}.py").exists() and name != "__version__"
    }
    # one asks it for pictures and tables of what the user holds, the other where the package stands
    assert values == {("results.py", "vibrocap"), ("lab/controls.py", "vibrocap")}


def test_without_units_nothing_is_shown_otherwise(motions):
    for plain in (motions[1], vc.mean_velocity(motions[1])):
        assert computed(plain) is plain
        assert plain.si_context() is None
