"""MuJoCo models of cases: what is lost is named, and what is said is the equations, by MuJoCo's own accelerations."""

import functools
import math
import re
import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import pytest

import cases
import vibrocap as vc
from benchmarks.mujoco_contact import contact_case, loss_case
from law_instances import LAW_NAMES, LAWS
from mechanisms import BeltRow, Washboard
from thinned import exhaustive_but
from vibrocap.case.case import Case, read_case
from vibrocap.cli.main import main
from vibrocap.contracts.samples import instances
from vibrocap.exchange.mjcf import mujoco_model
from vibrocap.measures.recorded.travel import drift
from vibrocap.mechanics import Contact
from vibrocap.motion.recording.recorded_machine import drawn_length
from vibrocap.physics.catalogue import machines
from vibrocap.physics.dimensions.scales import PendulumScales
from vibrocap.physics.environment import Environment

PAGE = (Path(__file__).parents[1] / "docs" / "exchange.md").read_text(encoding="utf-8")
TRAVELS = "examples/travels-by-stick-slip.toml"
COULOMB = vc.Coulomb(coulomb_coefficient=0.1, static_coefficient=0.1)
SCALES = PendulumScales(pendulum_mass_kg=0.02, pendulum_length_m=0.04)
needs_mujoco = "mujoco runs the model (.ci/exchange-requirements.txt)"

SAID = ("oscillator", "pendulum-capsule", "rotor-capsule", "two-mass-capsule", "two-body-crawler", "two-block-row",
        "three-body-crawler", "three-block-row")  # fmt: skip
OTHERS = sorted(set(machines()) - set(SAID))


def system_of(machine, law=COULOMB, **given):
    return vc.System(machine, law, vc.Harmonic(amplitude=1.3), **given)


def still(machine):
    """The machine on ground at rest."""
    return type(machine)(**(vars(machine) | {"belt_speed": 0.0})) if hasattr(machine, "belt_speed") else machine


def lost(system):
    return "\n".join(mujoco_model(Case(system)).lost)


@pytest.mark.parametrize(
    "machine", [*(machines()[name]() for name in SAID), vc.PendulumCapsule(normal_load="dynamic")], ids=lambda m: m.name
)
def test_every_body_stands_where_the_scene_has_it(machine):
    machine = still(machine)
    system = system_of(machine)
    start = dict.fromkeys(system.state_names, 0.3)
    root = ET.fromstring(mujoco_model(Case(system, start)).text)
    length, scene = drawn_length(system), machine.scene(0.0, (0.0,) * len(machine.states))
    drawn = {shape.name: length * np.array(shape.places(length)[0]) for shape in scene}
    for body in machine.mechanism(0.0, (0.0,) * len(machine.states)).bodies:
        place, arm, element = np.zeros(3), np.zeros(3), root.find(f".//body[@name='{body.name}']")
        while element is not None and element.tag == "body":
            place += np.array(element.get("pos").split(), float)
            element = next((letter for letter in root.iter("body") if element in list(letter)), None)
        arm += np.array(root.find(f".//body[@name='{body.name}']/geom").get("pos").split(), float)
        np.testing.assert_allclose((place + arm)[[0, 2]], drawn[body.name], atol=1e-15)
    start = root.find("keyframe/key")
    assert len(start.get("qpos").split()) == len(list(root.iter("joint"))) - 2 * len(list(root.iter("fixed")))


class Rough(Washboard):
    """Without the dampers, of which MuJoCo has no drag."""

    def parts(self, q):
        block, drive, _, _, contact = super().parts(q)
        return block, drive, contact


class Loaded(Rough):
    """Its load repeats along the ground, not its friction."""

    def contact(self, block, factor):
        return Contact(block, load=factor)


@pytest.mark.parametrize("machine", [*(machines()[name]() for name in OTHERS), BeltRow(), Rough(), Loaded()])
def test_a_machine_without_a_mechanism_is_refused_by_name(machine):
    """A belt of its own motion, friction by place and a load by place were left out without a word."""
    with pytest.raises(ValueError, match=f"^machine: the {machine.name} has no MuJoCo model"):
        mujoco_model(Case(system_of(machine, vc.Exponential())))


def test_what_else_cannot_be_said_is_refused_by_name():
    belt = vc.Oscillator(belt_speed=0.1)
    for given, said in (
        ({"system": system_of(belt)}, "machine.belt_speed should be 0"),
        (
            {"system": system_of(vc.Oscillator(), environment=Environment(linear_drag=0.1))},
            "environment should be",
        ),
        (
            {"system": system_of(vc.Oscillator(), actuator=vc.Actuator(time_constant=0.1))},
            "actuator should be left out",
        ),
    ):
        with pytest.raises(ValueError, match=f"^{said}"):
            mujoco_model(Case(**given))
    for step in (0.0, -1.0, math.inf, "1"):
        with pytest.raises(ValueError, match=r"^step should be a positive time"):
            mujoco_model(Case(system_of(vc.Oscillator())), step=step)


@pytest.mark.parametrize("law", LAWS, ids=LAW_NAMES)
def test_what_a_law_says_beyond_one_level_is_named(law):
    told = lost(system_of(vc.PendulumCapsule(), law))
    one_level = law.kind == "set-valued" and not law.internal and law.symmetric and law.wrapped is None
    one_level = one_level and law.holding_limit(1.0) == law.steady_force(1e-9, 1.0) == law.steady_force(1e6, 1.0)
    assert (f"cannot say the {law.name} law" in told) == (not one_level)
    assert ("memory" in told) == bool(law.internal)
    assert ("directions differ" in told) == (not law.symmetric)


def test_coulomb_with_one_level_is_said_whole():
    told = lost(system_of(vc.PendulumCapsule()))
    assert "law" not in told
    assert "holds up to 0.45" in lost(system_of(vc.PendulumCapsule(), vc.Coulomb()))
    assert "a soft contact" in lost(system_of(vc.PendulumCapsule(normal_load="dynamic")))
    two = lost(vc.System(vc.TwoBodyCrawler(), [COULOMB, vc.Dahl()], vc.Harmonic()))
    assert "friction_2: MuJoCo cannot say the dahl law" in two
    assert "friction:" not in two


def test_the_level_of_a_law_with_two_directions_is_the_mean_of_both():
    law = vc.anisotropic(vc.Coulomb)(0.3, 0.3, back_ratio=2.0)
    fromstring = ET.fromstring(mujoco_model(Case(system_of(vc.PendulumCapsule(normal_load=2.0), law))).text)
    assert float(fromstring.find(".//joint[@name='capsule']").get("frictionloss")) == pytest.approx(
        2.0 * 0.45, rel=1e-15
    )


def test_a_model_in_si_counts_in_si():
    machine, start = vc.PendulumCapsule(normal_load="weight"), {"angle": 0.5, "velocity": 0.2}
    plain, in_si = (
        ET.fromstring(mujoco_model(Case(system_of(machine, units=units), start)).text) for units in (None, SCALES)
    )
    mass, length, time = SCALES.units
    for path, key, scale in (
        ("option", "timestep", time),
        (".//body[@name='bob']/inertial", "mass", mass),
        (".//joint[@name='bob']", "stiffness", mass * length**2 / time**2),
        (".//joint[@name='bob']", "damping", mass * length**2 / time),
        (".//joint[@name='capsule']", "frictionloss", mass * length / time**2),
    ):
        found, wanted = (float(root.find(path).get(key)) for root in (in_si, plain))
        assert wanted != 0.0
        assert math.isclose(found, scale * wanted, rel_tol=1e-14), key
    gravity = float(in_si.find("option").get("gravity").split()[2])
    assert math.isclose(gravity, -9.80665, rel_tol=1e-14)
    velocity = float(in_si.find("keyframe/key").get("qvel").split()[0])
    assert math.isclose(velocity, 0.2 * length / time, rel_tol=1e-14)


@pytest.mark.parametrize("name", SAID)
def test_accelerations_of_mujoco_are_those_of_the_equations(name):
    """At random states under a drive, on level ground and on a slope, without friction."""
    mujoco = pytest.importorskip("mujoco", reason=needs_mujoco)
    random = np.random.default_rng(20261125)
    for machine in map(still, instances([machines()[name]])):
        if machine.follows_load:
            continue  # its body rises, too: see the motion below
        for environment in (None, Environment(inclination=0.3, gravity=1.3)):
            system = system_of(machine, vc.Coulomb(0.0, 0.0), environment=environment)
            y = random.normal(size=len(system.state_names))
            case = Case(system, dict(zip(system.state_names, y, strict=True)))
            model = mujoco.MjModel.from_xml_string(mujoco_model(case).text)
            model.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_CONSTRAINT)
            state = mujoco.MjData(model)
            mujoco.mj_resetDataKeyframe(model, state, 0)
            state.ctrl[:] = system.drive.value(0.7)
            mujoco.mj_forward(model, state)
            ahead, behind = (
                np.array([body.rate for body in system.placed.mechanism(0.7, y + way * np.array(rates)).bodies])
                for rates in [system.rates(0.7, tuple(y), 1)]
                for way in (0.5, -0.5)
            )  # rates are linear in the state
            # the inertia of a point mass is 1e-12 there, or 2e-15 of small numbers
            np.testing.assert_allclose(state.qacc, ahead - behind, rtol=1e-10, atol=1e-10 * abs(state.qacc).max())


def ending_errors(case, name, steps):
    """How far MuJoCo ends from the exact motion, for two steps."""
    from vibrocap.exchange.mjcf import mujoco_ending

    exact = case.simulate().dimensionless
    return [mujoco_ending(case, mujoco_model(case, h), exact.end, True).place - exact.state[name] for h in steps]


def test_friction_of_a_joint_comes_near_as_the_step_gets_short():
    """The method is of first order: half of the step leaves half of the error. A level that was late or wrong by 2 %
    would leave as much with both."""
    pytest.importorskip("mujoco", reason=needs_mujoco)
    case = read_case(TRAVELS, periods=3)
    coarse, fine = ending_errors(case, "position", (2e-3, 1e-3))
    assert abs(coarse) < 0.02
    assert 1.5 < coarse / fine < 2.5


@pytest.mark.slow
@pytest.mark.parametrize(("name", "machine"), [
    ("position", vc.PendulumCapsule(normal_load="dynamic")),
    ("position", vc.TwoMassCapsule(actuation="external", normal_load=0.7)),
    ("position", vc.TwoBodyCrawler(normal_load_2=2.0, mass_2=1.5)),
    ("position", vc.TwoBlockRow(stiffness_2=0.5)),
    ("position", vc.Oscillator()),
], ids=lambda value: getattr(value, "name", ""))  # fmt: skip
@pytest.mark.parametrize("units", exhaustive_but([1], [False, True]))
def test_every_kind_of_machine_comes_near(name, machine, units):
    pytest.importorskip("mujoco", reason=needs_mujoco)
    scales = None
    if units:
        fields = type(machine).si_scales.__dataclass_fields__
        scales = type(machine).si_scales(**dict(zip(fields, (0.02, 0.04, 0.05), strict=False)))
    law = vc.Exponential(static_coefficient=0.2, coulomb_coefficient=0.1, decay_rate=2.0)
    system = system_of(machine, law, units=scales)
    start = {name: 0.3 for name in system.state_names if name in ("displacement", "angle", "position", "position_2")}
    case = Case(system, start, periods=2, tolerance=1e-10)
    time = 1.0 if scales is None else scales.time_s
    (error,) = ending_errors(case, name, [5e-4 * time])
    size = np.ptp(case.simulate().dimensionless[name])
    assert size > 0.01
    # of first order, and a step is 5e-4 of the time in which it moves so far; a soft contact keeps an error of its own
    assert abs(error) < (6e-3 if machine.follows_load else 3e-3) * size


TABLE = re.findall(r"^\| (\S+) ms, (.+?) \| (\S+) \| (\S+) \|$", PAGE, re.MULTILINE)


def test_the_exact_row_of_the_documented_table():
    loss, contact = (case.simulate().dimensionless for case in (loss_case(), contact_case()))
    row = f"| exact | {loss.state['position']:.4f} | {drift(contact):.6f} |"
    assert row == "| exact | 6.8597 | -0.230592 |"
    assert row in PAGE


@pytest.mark.slow
@pytest.mark.parametrize(("step", "how", "position", "travel"), exhaustive_but([0], TABLE))
def test_the_documented_table_is_what_mujoco_does(step, how, position, travel):
    pytest.importorskip("mujoco", reason=needs_mujoco)
    from vibrocap.exchange.mjcf import mujoco_ending

    tight, endings = how == "tight", []
    for case in (loss_case(), contact_case()):
        model = mujoco_model(case, float(step) * 1e-3, tight)
        endings.append(mujoco_ending(case, model, case.simulate().dimensionless.end, rewritten=True))
    assert endings[0].place == pytest.approx(float(position), abs=2e-3)  # half of the last digit, thrice
    assert endings[1].drift == pytest.approx(float(travel), abs=2e-4)


def test_the_command_writes_the_model_and_says_what_is_lost(tmp_path, capsys):
    out = tmp_path / "capsule.xml"
    assert main(["export", TRAVELS, "--to", "mjcf", "--out", str(out)]) == 0
    said = capsys.readouterr().out
    assert "cannot say the exponential law" in said
    assert ET.parse(out).getroot().get("model") == "pendulum-capsule"
    assert "cannot say the exponential law" in out.read_text()


def test_the_command_judges(tmp_path, capsys):
    pytest.importorskip("mujoco", reason=needs_mujoco)
    case = tmp_path / "case.toml"
    read_case(TRAVELS, periods=2).save(case)
    assert main(["export", str(case), "--to", "mjcf", "--judge", "--out", str(tmp_path / "capsule.xml")]) == 0
    said = capsys.readouterr().out
    place = read_case(case).simulate().state["position"]
    assert f"{place:.6g}" in said
    assert "friction rewritten at each step" in said


def test_a_case_in_si_is_judged_in_si(tmp_path, capsys):
    pytest.importorskip("mujoco", reason=needs_mujoco)
    case = tmp_path / "case.toml"
    read_case("examples/bench-in-si.toml", periods=2).save(case)
    assert main(["export", str(case), "--to", "mjcf", "--judge", "--out", str(tmp_path / "capsule.xml")]) == 0
    rows = [row.split() for row in capsys.readouterr().out.splitlines() if " m" in row and "MuJoCo cannot" not in row]
    exact, rewritten = (next(row for row in rows if name in row) for name in ("exact", "rewritten"))
    motion = read_case(case).simulate()
    assert exact[1:3] == [f"{motion.state['position']:.6g}", "m"]
    place = float(rewritten[rewritten.index("m") - 1])
    assert abs(place - motion.state["position"]) < 0.05 * np.ptp(motion["position"])


def test_bad_input_is_named(tmp_path, capsys, monkeypatch):
    refused = functools.partial(cases.refused, capsys, "export")
    xml = str(tmp_path / "capsule.xml")
    assert "--judge: should be left out without --to mjcf" in refused(TRAVELS, "--judge", "--out", str(tmp_path / "c"))
    assert "--out: should end in .xml" in refused(TRAVELS, "--to", "mjcf", "--out", str(tmp_path / "capsule"))
    assert "there is no folder" in refused(TRAVELS, "--to", "mjcf", "--out", str(tmp_path / "none" / "capsule.xml"))
    assert "no MuJoCo model" in refused("examples/worm-of-two-bodies.toml", "--to", "mjcf", "--out", xml)
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    assert "--judge: needs mujoco; install with" in refused(TRAVELS, "--to", "mjcf", "--judge", "--out", xml)
    assert not (tmp_path / "capsule.xml").exists()
