"""Machines on several contacts: orbits, cases and sweeps, travel of unequal bodies, what is refused."""

import dataclasses
import pickle

import pytest

import vibrocap as vc
from vibrocap.motion.recording.equations import equations
from vibrocap.studies.plan.planning import planned_study
from vibrocap.studies.plan.variation import varied

pytestmark = pytest.mark.plain


def crawler(*further, **given):
    """Two unequal blocks under a drive that is not odd: they stick and slip, and travel."""
    machine = vc.TwoBodyCrawler(mass_2=2.4, damping=0.05, normal_load_2=1.2)
    drive = vc.Biharmonic(amplitude=1.0, frequency=0.4, second_amplitude=0.5, second_phase=0.4)
    return vc.System(machine, [vc.Coulomb(0.06, 0.09), *further], drive, **given)


def test_equal_contacts_of_one_body_and_two_are_the_same_motion():
    """Without a spring, damper and drive between them, two bodies know nothing of each other."""
    machine = vc.TwoBodyCrawler(stiffness=1e-300, damping=0.0, mass_2=2.0, normal_load_2=3.0, actuation=0.0)
    motion = vc.simulate(
        vc.System(machine, vc.Coulomb(0.2, 0.3), vc.Harmonic()),
        initial={"velocity_2": 1.5, "velocity": -0.4},
        periods=2,
    )
    # v^2/(2 mu N/m)
    assert motion.state["position"] == pytest.approx(-(0.4**2) / (2 * 0.2), abs=1e-12)
    assert motion.state["displacement"] - 0.4 == pytest.approx(1.5**2 / (2 * 0.2 * 1.5), abs=1e-12)
    stops = {str(event.kind): event.time for event in motion.events if "stick" in event.kind}
    assert stops == {"stick": pytest.approx(0.4 / 0.2, abs=1e-12), "stick_2": pytest.approx(1.5 / 0.3, abs=1e-12)}


def test_a_start_at_which_a_body_moves_away_from_its_side_is_no_stop():
    """As of a motion that goes on with another velocity: the second body slides 1.5^2/(2 mu N/m), whatever its side."""
    machine = vc.TwoBodyCrawler(stiffness=1e-300, damping=0.0, mass_2=2.0, normal_load_2=3.0, actuation=0.0)
    system = vc.System(machine, vc.Coulomb(0.2, 0.3), vc.Harmonic())
    before = vc.simulate(system, initial={"velocity_2": -1.5}, periods=0.1)
    motion = vc.simulate(system, start=before, initial={"displacement": 0.0, "velocity_2": 1.5}, periods=2)
    assert motion.state["displacement"] == pytest.approx(1.5**2 / (2 * 0.2 * 1.5), abs=1e-12)
    assert [event.kind for event in motion.events] == ["stick_2"]


def test_a_case_with_a_law_for_each_contact(tmp_path):
    system = crawler(vc.LuGre(bristle_stiffness=80.0))
    path = vc.save_case(system, tmp_path / "case.toml", initial={"velocity_2": 0.2})
    assert "[friction_2]" in path.read_text()
    assert vc.read_case(path).system == system
    assert system.state_names == ("displacement", "velocity_2", "position", "velocity", "bristle_2")
    in_si = dataclasses.replace(system, units=vc.SIScales())
    path = vc.save_case(in_si, tmp_path / "si.toml")
    assert "bristle_stiffness_N_per_m = 80" in path.read_text()
    assert vc.read_case(path).system == in_si
    assert in_si.si.unit("velocity_2") == in_si.si.unit("contact_velocity_2") == "m/s"
    assert in_si.si.unit("friction_2") == "N"
    assert in_si.si.unit("bristle_2") == "m"


def planned(system, changes):
    """The system of a run of a sweep over these paths."""
    run = {"periods": 60, "tolerance": 1e-8, "max_events_per_period": 100, "max_steps": 1000}
    settings = {
        "cases": None,
        "design": None,
        "initial": None,
        "settings": run | {"window": 1, "settle": 0, "extrapolate": True},
    }
    study = planned_study(system, {path: [value] for path, value in changes.items()}, measures=["drift"], **settings)
    return varied(study.case.system, changes)


def test_a_sweep_over_what_the_case_leaves_out(tmp_path):
    """The law of the second contact and an environment: as if the case had them."""
    system = crawler()
    own = system.friction
    levels = {name: getattr(own, name) for name in ("coulomb_coefficient", "static_coefficient")}  # both laws have them
    changes = {"friction_2.law": "lugre", "environment.force": 0.02}
    wanted = dataclasses.replace(system, friction=[own, vc.LuGre(**levels)], environment=vc.Environment(force=0.02))
    assert planned(system, changes) == wanted
    settings = {"out": tmp_path / "none", "periods": 60, "tolerance": 1e-8, "settle": 0}
    for over, said in (
        ({"friction_3.law": ["coulomb"]}, r"friction_3\.law: there is no such quantity here"),
        ({"environment.inclination": [0.0, 1.6]}, r"environment\.inclination: should be less steep than 90 degrees"),
        ({"actuator.limit": [0.5, 1.6]}, r"actuator\.limit: the system has no actuator; give the case a section"),
    ):
        with pytest.raises(vc.CaseError, match=said):
            vc.sweep(system, over, **settings)


def test_laws_of_contacts_stand_in_a_list():
    """None and what is missing stand for the law of the first contact, whatever becomes of it."""
    machine, drive = vc.ThreeBodyCrawler(), vc.Harmonic()
    first, second, third = vc.Coulomb(0.1, 0.2), vc.Coulomb(0.3, 0.3), vc.LuGre()
    alone, every = vc.System(machine, first, drive), vc.System(machine, [first, second, third], drive)
    gap = vc.System(machine, (first, None, third), drive)
    assert vc.System(machine, [first, None, None], drive) == vc.System(machine, [first], drive) == alone
    assert len({alone, every, gap, vc.System(machine, [first, second], drive)}) == 4
    assert equations(gap) is not equations(vc.System(machine, [first, third], drive))  # as many laws of the same kinds
    assert (every.friction, every.further) == (first, (second, third))
    assert [each.laws[1:] for each in (alone, every, gap)] == [(first, first), (second, third), (first, third)]
    assert list(every.parts) == ["machine", "friction", "drive", "friction_2", "friction_3"]
    assert gap.parts == {"machine": machine, "friction": first, "drive": drive, "friction_3": third}
    for system in (alone, every, gap):
        assert vc.System.of_parts(dict(reversed(system.parts.items()))) == system
        assert pickle.loads(pickle.dumps(system)) == system
        assert hash(pickle.loads(pickle.dumps(system))) == hash(system)
    assert dataclasses.replace(gap, friction=second).laws[1:] == (second, third)
    assert dataclasses.replace(gap, friction=[second, first]).laws[1:] == (first, second)
    assert dataclasses.replace(every, drive=vc.Square()).further == every.further
    changed = gap.with_parameters({"friction.static_coefficient": 0.4, "friction_3.bristle_stiffness": 7.0})
    assert changed.further == (None, vc.LuGre(bristle_stiffness=7.0))
    assert changed.laws[1] == vc.Coulomb(0.1, 0.4)
    assert changed.parameter("friction_3.bristle_stiffness") == 7.0
    stiff = vc.Dahl.in_si(coulomb_coefficient=0.2, bristle_stiffness_N_per_m=8.0)
    in_si = vc.System(machine, [first, None, stiff], drive, units=vc.SIScales())
    assert in_si.further == (None, vc.Dahl(8.0, 0.2))


def test_more_than_ten_contacts(tmp_path):
    """Cases, paths, measures and studies take the last of twelve as they take the second."""
    drive, rear, front = vc.Biharmonic(1.5, 0.8, 0.7, 0.5), vc.Coulomb(0.3, 0.45), vc.Coulomb(0.1, 0.15)
    alone = vc.System(vc.crawler(12)(), rear, drive)
    system = vc.System(alone.machine, [rear, *[None] * 10, front], drive)
    path = vc.save_case(alone, tmp_path / "case.toml", periods=2)
    changes = {"friction_12.coulomb_coefficient": 0.1, "friction_12.static_coefficient": 0.15}
    assert vc.read_case(path, changes).system == planned(alone, changes) == system
    assert vc.read_case(vc.save_case(system, tmp_path / "own.toml")).system == system
    assert planned(alone, {"machine.mass_12": 2.0}).machine.mass_12 == 2.0
    assert {"stick_fraction_12", "contact_sliding_12_work"} <= {*vc.measure_table(alone)}
    assert equations(system).contacts[11].state == system.state_names.index("velocity_12")
    with pytest.raises(vc.CaseError, match=r"friction_13: should be left out: the twelve-body-crawler has 12 contacts"):
        vc.read_case(path, {"friction_13.coulomb_coefficient": 0.1})
    with pytest.raises(vc.CaseError, match="friction_999999999: should be left out"):
        vc.read_case(path, {"friction_999999999.coulomb_coefficient": 0.1})
    for name in ("friction_1", "friction_02", "friction_", "friction_2_3"):
        with pytest.raises(vc.CaseError, match=f"{name}: no such section; did you mean 'friction'"):
            vc.read_case(path, {f"{name}.law": "coulomb"})


def test_what_contacts_there_are_not_is_refused_by_name():
    with pytest.raises(ValueError, match=r"^friction_2: there is no such argument; give the laws of all contacts"):
        vc.System(vc.TwoBodyCrawler(), vc.Coulomb(), vc.Harmonic(), friction_2=vc.Coulomb())
    with pytest.raises(ValueError, match=r"^friction_2: there is no such argument; give the laws of all contacts"):
        dataclasses.replace(crawler(), friction_2=vc.Coulomb())
    with pytest.raises(TypeError, match="unexpected keyword argument 'frictoin'"):
        vc.System(vc.TwoBodyCrawler(), vc.Coulomb(), vc.Harmonic(), frictoin=vc.Coulomb())
    for nothing in ([], [None, vc.Coulomb()]):
        with pytest.raises(TypeError, match=r"^friction should be a law, got (\[\]|None)"):
            vc.System(vc.TwoBodyCrawler(), nothing, vc.Harmonic())
    with pytest.raises(ValueError, match=r"friction_3 should be left out: the two-body-crawler has 2 contacts"):
        crawler(None, vc.Coulomb())
    with pytest.raises(ValueError, match=r"friction_2 should be left out: the pendulum-capsule has one contact"):
        vc.System(vc.PendulumCapsule(), [vc.Coulomb(), vc.Coulomb()], vc.Harmonic())
    with pytest.raises(TypeError, match=r"friction_2 should be a law"):
        crawler(vc.Harmonic())
    with pytest.raises(ValueError, match=r"friction_2.coulomb_coefficient: this contact has the law of the first"):
        crawler().parameter("friction_2.coulomb_coefficient")
    with pytest.raises(ValueError, match=r"machine.normal_load_2 should be > 0 with the lugre law, got 0"):
        vc.System(vc.TwoBodyCrawler(normal_load_2=0.0), vc.LuGre(), vc.Harmonic())
    with pytest.raises(ValueError, match=r"bodies should be a whole number from 2 to 20, got 21"):
        vc.crawler(21)
    motion = vc.simulate(vc.System(vc.TwoBodyCrawler(), vc.Coulomb(), vc.Harmonic()), periods=0.1)
    with pytest.raises(ValueError, match=r"contact should be a whole number from 1 to 2, got 3"):
        vc.stick_fraction(motion, contact=3)
