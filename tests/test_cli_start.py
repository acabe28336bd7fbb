"""The commands new and examples: what a user begins with."""

import itertools
from pathlib import Path

import numpy as np
import pytest

import vibrocap as vc
from cases import printed, refused
from thinned import covering, exhaustive_but
from vibrocap.case.case import RUN_DEFAULTS, case_from_text
from vibrocap.cli.examples import examples_folder
from vibrocap.cli.main import main
from vibrocap.cli.terminal import OK, WRONG_INPUT
from vibrocap.physics.catalogue import drives, laws, machines
from vibrocap.physics.dimensions.units import effort_of
from vibrocap.physics.drives.drive import Drive
from vibrocap.physics.parameters import parameter_table

EXAMPLES = Path(__file__).resolve().parents[1] / "examples"


@pytest.fixture(autouse=True)
def empty_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)


# --- new -------------------------------------------------------------------------------------------------------------


def fit_together(machine, drive):
    """Whether a machine with an imposed motion can take the drive; the others take all."""
    return not machine.imposes_motion or (drive.slope is not Drive.slope and drive().continuous)


PAIRS = [(m, d) for m, d in itertools.product(machines(), drives()) if fit_together(machines()[m], drives()[d])]


@pytest.mark.parametrize(("machine", "drive"), [PAIRS[i] for i in covering(PAIRS)])
def test_a_new_case_is_the_default_of_its_parts(machine, drive, capsys):
    """Or what its machine begins with, where it says so; of its law and its drive what these have."""
    law = "lugre" if drive == "harmonic" else "exponential"
    text = printed(capsys, "new", machine, "--law", law, "--drive", drive)
    case, plain = case_from_text(text), vc.System(machines()[machine](), laws()[law](), drives()[drive]())
    first = {path: x for path, x in machines()[machine].first_case.items() if path in plain.parameter_paths}
    assert case.system == plain.with_parameters(first)
    assert text.count("; default ") == len(first)
    command = ["new", machine, "--law", law, "--drive", drive, "--defaults"]
    assert case_from_text(printed(capsys, *command)).system == plain
    assert case.run == RUN_DEFAULTS
    assert set(case.initial) == set(case.system.state_names)
    assert not any(case.initial.values())
    values = [line for line in text.splitlines() if " = " in line and not line.startswith("#")]
    assert all(" # " in line and not line.endswith("# ") for line in values)


@pytest.mark.parametrize(("machine", "drive"), [PAIRS[i] for i in covering(PAIRS)])
def test_a_new_case_in_si_is_the_default_at_the_size_of_a_bench(machine, drive, capsys):
    """To three digits, and with the weight as load where that is known; every number has its unit."""
    law = "lugre" if drive == "harmonic" else "exponential"
    text = printed(capsys, "new", machine, "--law", law, "--drive", drive, "--si", "--defaults")
    assert "A bench of usual size" in text
    optional = [info.name for info in parameter_table(machines()[machine].si_scales) if info.default is None]
    assert not any(line.startswith((*optional, "gravity_m_per_s2")) for line in text.splitlines())
    case = case_from_text(text)
    assert case.system.units is not None
    plain = vc.System(machines()[machine](), laws()[law](), drives()[drive]())
    bench = (
        vc.FreeScales(0.1, 0.01, 0.03) if case.system.units == vc.SIScales() else None
    )  # of what has no units itself
    for path in plain.parameter_paths:
        value, known = case.system.parameter(path), plain.parameter(path)
        if path == "machine.normal_load" and "weight" in machines()[machine].si_load:
            assert value == "weight"
        elif isinstance(known, (float, tuple)):
            part, name = path.split(".")
            info = next(info for info in parameter_table(plain.parts[part]) if info.name == name)
            scale = bench.of(info.dimension, effort_of(part, plain.parts)) if bench and info.dimension else 1.0
            assert value == pytest.approx(np.multiply(known, scale), rel=5e-3), path
        else:
            assert value == known, path
    assert case.run == RUN_DEFAULTS


BEGINS = [i for i, machine in enumerate(machines().values()) if machine.first_case]  # with values of its own


@pytest.mark.slow
@pytest.mark.parametrize("machine", exhaustive_but(BEGINS, [*machines()]))
@pytest.mark.parametrize("form", exhaustive_but([0], ["", "--si"]), ids=["plain", "si"])
def test_a_new_case_shows_a_bounded_motion_in_which_a_contact_slides(machine, form, capsys):
    """To its end and certified; no place but one of travel moves by ten lengths, of a bench ten centimetres."""
    text = printed(capsys, "new", machine, *form.split())
    motion = case_from_text(text).simulate()
    assert motion.certificate.ok
    assert motion.piece_sides.any()
    for name, coordinate in machines()[machine].all_coordinates.items():
        if name != machines()[machine].cyclic and coordinate.unit == "m":
            assert np.ptp(motion[name]) < (0.16 if form else 16.0), name


def test_a_new_case_is_written_once(capsys):
    words = ["new", "oscillator", "--law", "backlash-dahl", "--out", "case.toml"]
    assert main(words) == OK
    first = Path("case.toml").read_text()
    assert "simulate case.toml" in first
    assert main([*words, "--drive", "ramp"]) == WRONG_INPUT
    assert "--out: 'case.toml' exists; name another file, or add --overwrite" in capsys.readouterr().err
    assert Path("case.toml").read_text() == first
    assert main([*words, "--drive", "ramp", "--overwrite"]) == OK
    assert case_from_text(Path("case.toml").read_text()).system.drive == vc.Ramp()


def test_unknown_kinds_are_named_at_once(capsys):
    message = refused(capsys, "new", "oscilator", "--law", "lugr", "--drive", "harmonc", "--out", "case")
    for part in ("KIND: there is no 'oscilator'; did you mean 'oscillator'?", "--law: there is no 'lugr'", "--drive: "):
        assert part in message
    assert "--out: should end in .toml" in message
    assert list(Path().iterdir()) == []


# --- examples --------------------------------------------------------------------------------------------------------


def test_examples_are_listed_with_what_they_show(capsys):
    text = printed(capsys, "examples")
    for path in EXAMPLES.glob("*.toml"):
        assert f"  {path.stem} " in text
    assert "A symmetric machine that travels" in text
    assert list(Path().iterdir()) == []


def test_examples_are_copied_and_what_is_there_is_left(capsys):
    assert examples_folder() == EXAMPLES
    assert main(["examples", "--to", "examples"]) == OK
    wanted = [path.name for path in EXAMPLES.iterdir() if path.suffix in (".toml", ".csv")]
    assert sorted(path.name for path in Path("examples").iterdir()) == sorted(wanted)
    Path("examples/mirror-twin.toml").write_text("mine")
    capsys.readouterr()
    text = printed(capsys, "examples", "mirror-twin", "weight-as-load.toml")
    assert f"{Path('examples/mirror-twin.toml')} is there already, and another; it is left as it is\n" in text
    assert f"{Path('examples/weight-as-load.toml')} is there already\n" in text
    assert Path("examples/mirror-twin.toml").read_text() == "mine"


def test_unknown_examples_are_named(capsys):
    assert main(["examples", "miror-twin", "--to", "a"]) == WRONG_INPUT
    assert "miror-twin: there is no such example; did you mean 'mirror-twin'?" in capsys.readouterr().err
    assert not Path("a").exists()
