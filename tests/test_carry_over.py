"""A part of another kind keeps what both kinds have, by role and in its unit; in SI it asks for what it lacks."""

import tomllib
from typing import ClassVar

import numpy as np
import pytest

import vibrocap as vc
from vibrocap.arguments import Refusal
from vibrocap.case.case import CaseError, case_from_text
from vibrocap.cli.commands.crossing import _other
from vibrocap.lab.bundle import Preset, contents
from vibrocap.physics.catalogue import drives, laws
from vibrocap.physics.dimensions.carry_over import carried_names
from vibrocap.physics.friction.law import Curve, NonNegative, parameter, parameters
from vibrocap.physics.parameters import parameter_table
from vibrocap.studies.plan.variation import refusal, varied

SI = """
[machine]
kind = "oscillator"
mass_kg = 1.0
stiffness_N_per_m = 100.0
damping_N_s_per_m = 0.1
belt_speed_m_per_s = 0.1
normal_load_N = 1.5
[friction]
law = "coulomb"
coulomb_coefficient = 0.20
static_coefficient = 0.25
[drive]
waveform = "harmonic"
amplitude_N = 0.3
frequency_Hz = 2.0
[initial]
position_m = 0.01
"""
PLAIN = """
[machine]
kind = "pendulum-capsule"
[friction]
law = "lugre"
coulomb_coefficient = 0.2
bristle_stiffness = 70
stribeck_exponent = 1.5
[drive]
waveform = "harmonic"
frequency = 1.7
[initial]
bristle = 0.001
"""
CHANGES = {
    "friction.law": [*laws(), "anisotropic-coulomb", "backlash-lugre"],
    "drive.waveform": [name for name in drives() if name != "table"],
}


@pytest.mark.parametrize("text", [SI, PLAIN], ids=["SI", "dimensionless"])
@pytest.mark.parametrize("path", CHANGES)
def test_set_and_sweeps_make_the_same_system_of_another_kind(text, path):
    """Or refuse it for the same fields."""
    case = case_from_text(text)
    for name in CHANGES[path]:
        try:
            by_set = case_from_text(text, changes={path: name}).system
        except CaseError as error:
            fields = {complaint.partition(":")[0] for complaint in error.complaints}
            assert {each.partition(":")[0] for each in refusal(case.system, {path: name})} == fields, name
        else:
            assert refusal(case.system, {path: name}) == ()
            assert varied(case.system, {path: name}) == by_set, name


def test_what_both_laws_have_carries_over_in_si_and_what_is_missing_is_asked_for():
    system = case_from_text(SI).system
    assert refusal(system, {"friction.law": "exponential"})[0].startswith("friction.decay_rate_s_per_m: is missing")
    settings = {"friction.law": "exponential", "friction.decay_rate_s_per_m": 50.0}
    for found in (varied(system, settings), case_from_text(SI, changes=settings).system):
        assert found.friction == vc.Exponential(0.2, 0.25, 50.0)
    found = case_from_text(SI, changes={"drive.waveform": "biharmonic"}).system
    assert (found.drive.amplitude, found.drive.second_amplitude) == (0.3, 0.0)
    assert found.drive.frequency == pytest.approx(4 * np.pi, rel=1e-15)
    turned = SI.replace("frequency_Hz = 2.0", "frequency_rad_per_s = 12.0")
    assert case_from_text(turned, changes={"drive.waveform": "square"}).system.drive.frequency == 12.0
    # by role: the level of one law is the level of another, whatever it is called; the rest has no default in SI
    said = " ".join(refusal(system, {"friction.law": "rate-and-state-ageing"}))
    assert "reference_coefficient" not in said
    for name in ("direct_effect", "evolution_effect", "critical_distance_m", "reference_velocity_m_per_s"):
        assert f"friction.{name}: is missing" in said
    dahl = case_from_text(SI, changes={"friction.law": "dahl", "friction.bristle_stiffness_N_per_m": 9.0}).system
    said = " ".join(refusal(dahl, {"friction.law": "coulomb"}))
    assert "friction.static_coefficient: is missing" in said


def test_without_units_the_numbers_of_the_case_carry_over_too():
    system = case_from_text(PLAIN).system
    found = varied(system, {"friction.law": "stribeck", "drive.waveform": "square"})
    assert found.friction == vc.Stribeck(coulomb_coefficient=0.2, stribeck_exponent=1.5)
    assert (found.drive.amplitude, found.drive.frequency) == (1.8, 1.7)
    changed = case_from_text(PLAIN, changes={"friction.law": "stribeck", "drive.waveform": "square"})
    assert changed.system == found
    assert changed.initial == {}  # no bristles there


def test_a_further_contact_that_is_spoken_of_has_the_law_of_the_first_as_yet():
    text = '[machine]\nkind = "two-body-crawler"\n[friction]\nlaw = "stribeck"\ncoulomb_coefficient = 0.2\n' \
           '[drive]\nwaveform = "harmonic"\n'  # fmt: skip
    system = case_from_text(text, changes={"friction_2.law": "coulomb", "friction_2.static_coefficient": 0.3}).system
    assert system.further == (vc.Coulomb(0.2, 0.3),)
    system = case_from_text(text, changes={"friction_2.coulomb_coefficient": 0.1}).system
    assert system.further == (vc.Stribeck(0.1),)


def test_against_another_law_in_si():
    system = case_from_text(SI).system
    with pytest.raises(Refusal, match=r"decay_rate_s_per_m: is missing.*give it too, --against friction.law=exp"):
        _other(system, "friction.law=exponential")
    found = _other(system, "friction.law=exponential,friction.decay_rate_s_per_m=50")
    assert found.friction == vc.Exponential(0.2, 0.25, 50.0)
    assert found.units == system.units


def test_forms_of_a_page_have_the_numbers_of_its_case():
    case = case_from_text(
        SI.replace('"coulomb"', '"stribeck"\nstribeck_velocity_m_per_s = 0.05\nstribeck_exponent = 1.5')
    )
    found = contents(Preset("own", "own", "", case), law_names=["lugre"], drive_names=["harmonic"])
    lugre = next(form.friction for form in found.forms if form.friction.name == "lugre")
    assert (lugre.coulomb_coefficient, lugre.stribeck_exponent) == (0.2, 1.5)


@parameters
class Other(Curve):
    """A law with names of its own.

    R = N mu_k
    """

    kinetic: NonNegative = parameter(0.9, "mu_k", "sliding", "level")
    breakaway: NonNegative = parameter(0.95, "mu_s", "at rest", "static level")
    knee: NonNegative = parameter(3.0, "p", "shape", "exponent")
    number: NonNegative = parameter(3.0, "q", "undeclared")
    name: ClassVar[str] = "other"

    def steady_force(self, speed, load):
        """Friction force at a constant speed."""
        return load * self.kinetic


def test_roles_carry_over_and_pure_numbers_keep_to_their_names():
    assert dict(carried_names(vc.Stribeck, Other)) == {
        "kinetic": "coulomb_coefficient",
        "breakaway": "static_coefficient",
    }
    assert dict(carried_names(vc.Harmonic, drives()["constant"])) == {}  # an amplitude is no constant force
    assert set(carried_names(drives()["triangle"], drives()["trapezoid"])) == {
        "amplitude",
        "frequency",
    }  # not one share
    for catalogue in (laws(), drives()):
        for kind in catalogue.values():
            names = {info.name for info in parameter_table(kind)}
            assert dict(carried_names(kind, kind)) == {name: name for name in names}


def test_a_number_without_a_dimension_cannot_stand_in_si_and_the_cure_is_said():
    vc.register(Other)
    try:
        text = SI.replace('"coulomb"', '"other"').replace("coulomb_coefficient", "kinetic")
        text = text.replace("static_coefficient", "breakaway")
        for changes, given in ((None, text), ({"friction.law": "other"}, SI)):
            with pytest.raises(CaseError, match=r'friction.number: declares neither a role .*unit="1"'):
                case_from_text(given, changes=changes)
        assert 'unit="1"' in refusal(case_from_text(SI).system, {"friction.law": "other"})[0]
    finally:
        vc.unregister(Other)


@pytest.mark.parametrize("section", ["machine", "friction", "drive"])
@pytest.mark.parametrize("said", [None, "3", "[1]", "{a = 1}", "true", '""'])
def test_a_kind_that_is_left_out_or_no_text_is_complained_of_whatever_is_changed(section, said):
    key = {"machine": "kind", "friction": "law", "drive": "waveform"}[section]
    data = tomllib.loads(PLAIN)
    lines = []
    for name, values in data.items():
        lines.append(f"[{name}]")
        for word, value in values.items():
            if name != section or word != key:
                lines.append(f"{word} = {value!r}".replace("'", '"'))
            elif said is not None:
                lines.append(f"{word} = {said}")
    text = "\n".join(lines)
    for changes in ({"run.periods": 3}, {"machine.mass_ratio": 2.0}, {"initial.angle": 0.1}, {"drive.waveform": 3}):
        with pytest.raises(CaseError) as caught:
            case_from_text(text, changes=changes)
        assert any(complaint.startswith(f"{section}.{key}: ") for complaint in caught.value.complaints)
