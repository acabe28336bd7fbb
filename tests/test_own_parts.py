"""Parts outside the package: a file of one's own goes through every command; what is wrong with one is said by name."""

import contextlib
import json
import pickle
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import vibrocap as vc
from cases import printed, printed_json, refused
from vibrocap.case.case import Case, CaseError, case_from_text, case_text
from vibrocap.cli.main import main
from vibrocap.cli.terminal import OK, WRONG_INPUT
from vibrocap.identification.experiments.experiment_design import ramp, synthetic_record
from vibrocap.physics import catalogue
from vibrocap.physics.drives.drive import Drive
from vibrocap.physics.friction.curves import Exponential
from vibrocap.physics.friction.law import Law, Positive, parameter, parameters
from vibrocap.physics.part_files import file_of, load_parts
from vibrocap.studies.plan import runs
from vibrocap.studies.plan.study import Study, part_fingerprint
from vibrocap.studies.store.places import StoreError
from vibrocap.studies.workers import receive, sources_of

FILE = Path(__file__).with_name("own_laws.py")
CASE = """
[machine]
kind = "pendulum-capsule"
[friction]
law = "long-tail"
[drive]
waveform = "third-harmonic"
[initial]
angle = 1.0
[run]
periods = 12
"""
SWEEP = ["sweep", "case.toml", "--over", "friction.law=long-tail,exponential", "--over", "drive.amplitude=1:2:2"]


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A folder of a user, with a file of parts and a case."""
    shutil.copy(FILE, tmp_path / "mylaws.py")
    (tmp_path / "case.toml").write_text(CASE, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def law_text(body="", name="bad", extends="Law", head="@parameters", first="import math"):
    """The text of a file with one law."""
    lines = [
        first,
        "from typing import ClassVar",
        "from vibrocap.physics.friction.law import Law, Positive, parameter, parameters",
        head,
        f"class Bad({extends}):",
        '    """A law."""',
        '    level: Positive = parameter(0.3, "mu", "level", "level")',
        f"    name: ClassVar[str] = {name!r}",
        '    kind: ClassVar = "smooth"',
        *(f"    {line}" for line in body.splitlines()),
    ]
    return "\n".join(lines) + "\n"


GOOD = """
passive = True
def steady_force(self, speed, load): return self.level * speed
def force(self, velocity, internal, side, load): return self.level * velocity, ()
"""


MAGNET = """
from typing import ClassVar

from vibrocap.physics.machines.oscillators import Oscillator
from vibrocap.physics.machines.machine import parameters


@parameters
class Harvester(Oscillator):
    \"\"\"A block whose damper is a coil around a magnet; there is no other.\"\"\"

    name: ClassVar[str] = "harvester"
    channels: ClassVar = ("drive", "coil", "belt")
"""
HARVESTER = """
[machine]
kind = "harvester"
damping = 0.2
[friction]
law = "coulomb"
[drive]
waveform = "harmonic"
[run]
periods = 10
"""


@pytest.mark.slow
def test_a_machine_has_channels_of_its_own_and_no_damper(folder, capsys):
    Path("magnet.py").write_text(MAGNET, encoding="utf-8")
    Path("case.toml").write_text(HARVESTER, encoding="utf-8")
    assert main(["list", "harvester", "--check", "--parts", "magnet.py"]) == OK
    capsys.readouterr()
    plot = ["--plot", "run.png"]
    energy = printed_json(capsys, "simulate", "case.toml", "--parts", "magnet.py", *plot)["energy"]
    (made,) = load_parts("magnet.py")
    alike = vc.System(vc.Oscillator(damping=0.2), vc.Coulomb(), vc.Harmonic())
    expected = vc.energy_balance(vc.simulate(alike, periods=10, tolerance=1e-9))
    assert energy["own"]["coil"] == pytest.approx(expected.damper)
    assert energy["damper"] == 0.0
    assert abs(energy["residual"]) < 1e-8
    assert "work of coil" in printed(capsys, "simulate", "case.toml", "--parts", "magnet.py")
    system = vc.System(made(damping=0.2), vc.Coulomb(), vc.Harmonic())
    balance = vc.energy_balance(vc.simulate(system, periods=10), periods=2)
    assert balance.per_period.own == {"coil": pytest.approx(0.5 * balance.own["coil"])}
    assert "coil_work" in vc.measure_table(system)
    vc.plot(vc.simulate(system, periods=2))
    sweep = ["sweep", "case.toml", "--over", "drive.amplitude=1:2:2", "--measure", "coil_work", "--out", "s"]
    assert main([*sweep, "--parts", "magnet.py"]) == OK


def test_a_case_alone_makes_no_code_run(folder, capsys):
    (folder / "mylaws.py").write_text("raise SystemExit('ran')\n")
    said = refused(capsys, "simulate", "case.toml")
    assert "no law is called 'long-tail'" in said
    assert "no waveform is called 'third-harmonic'" in said


def test_a_law_of_ones_own_is_fitted_from_the_command_line(folder, capsys):
    law, _ = load_parts("mylaws.py")
    record = synthetic_record(law(low=0.2, high=0.5, knee=0.05), ramp(0.4, 6.0, 300), noise=0.01, seed=0)
    rows = "\n".join(f"{t},{v},{f}" for t, v, f in zip(record.time, record.velocity, record.force, strict=True))
    (folder / "data.csv").write_text("time,velocity,force\n" + rows + "\n")
    vc.unregister(law)
    command = ["fit", "data.csv", "--law", "long-tail", "--steady", "--json", "--intervals", "covariance"]
    assert main(command) == WRONG_INPUT
    assert "no law is called 'long-tail'" in capsys.readouterr().err
    found = json.loads(printed(capsys, *command, "--parts", "mylaws.py"))["parameters"]
    values = {each["name"]: each["value"] for each in found}
    assert values["knee"] == {"value": pytest.approx(0.05, rel=0.2), "unit": "m/s"}
    assert (values["low"]["unit"], values["high"]["unit"]) == ("N", "N")


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (None, "no.py: cannot be read: No such file"),
        ("x = 1\n", "no.py: defines no part: no class that extends Law, Machine, Drive or Controller"),
        ("x = (\n", "no.py: line 1: '(' was never closed"),
        ("\n\n1 / 0\n", "no.py, line 3: ZeroDivisionError: division by zero"),
        ("import nowhere\n", "no.py, line 1: ModuleNotFoundError: No module named 'nowhere'"),
        ("raise SystemExit(1)\n", "no.py, line 1: SystemExit: 1"),
        (law_text(), "Bad cannot be registered: force: is missing, which every law defines; see the contract, "),
        (law_text(GOOD, name="lugre"), "Bad: the law 'lugre' exists already, vibrocap.physics.friction.bristles.LuGre"),
        (law_text(GOOD, name="My Law"), "name: should be a ClassVar of small letters, digits and hyphens"),
        (law_text(GOOD, name="backlash-lugre"), "Bad: the law 'backlash-lugre' exists already"),
        (law_text(GOOD, head=""), "is no record of parameters; write @parameters above the class"),
        (law_text(GOOD.replace("smooth", "")).replace('"smooth"', '"rough"'), "kind: should be 'set-valued', 'kinked'"),
        (law_text(GOOD).replace('"smooth"', '"set-valued"'), "holding_limit: is missing, which every law defines"),
        (law_text(GOOD).replace("0.3,", "...,"), "level: every parameter needs a default"),
        (law_text(GOOD).replace('"level")', '"levl")'), "role: there is no role 'levl'; did you mean 'level'?"),
    ],
)
def test_a_file_that_cannot_be_used_is_refused_by_name(folder, capsys, text, said):
    if text is not None:
        (folder / "no.py").write_text(text)
    found = refused(capsys, "simulate", "case.toml", "--parts", "no.py", "--parts", "case.toml")
    assert said in found
    assert found.startswith("--parts: ")
    assert "case.toml: should be a Python file" in found
    assert "Traceback" not in found


def test_a_fault_in_a_part_is_said_with_its_line(folder, capsys):
    text = law_text(GOOD.replace("return self.level * velocity, ()", "return self.levl * velocity, ()"), name="typo")
    (folder / "typo.py").write_text(text)
    (folder / "case.toml").write_text(CASE.replace("long-tail", "typo"))
    assert main(["simulate", "case.toml", "--parts", "typo.py", "--parts", "mylaws.py"]) == WRONG_INPUT
    line = next(number for number, line in enumerate(text.splitlines(), 1) if "levl" in line)
    assert f"typo.py, line {line}, in force: AttributeError: 'Bad' object has no" in capsys.readouterr().err


def test_what_cannot_be_recorded_is_said_with_what_to_write_instead(folder, capsys):
    text = law_text(GOOD.replace("return self.level * velocity, ()", "return self.level * abs(velocity), ()"), "kink")
    (folder / "kink.py").write_text(text)
    (folder / "case.toml").write_text(CASE.replace("long-tail", "kink"))
    found = refused(capsys, "simulate", "case.toml", "--parts", "kink.py", "--parts", "mylaws.py")
    assert found.startswith("kink.py, line ")
    assert ", in force: a recorded formula cannot hold a kink: write side * velocity for |velocity|" in found


def test_a_number_for_each_channel_and_state_is_asked_for(folder, capsys):
    Path("magnet.py").write_text(MAGNET.replace('"coil", "belt"', '"coil"'), encoding="utf-8")
    Path("case.toml").write_text(HARVESTER, encoding="utf-8")
    assert main(["simulate", "case.toml", "--parts", "magnet.py"]) == WRONG_INPUT
    text = "harvester: powers: should be 2 numbers, one for each of channels (drive, coil), got 3"
    assert text in capsys.readouterr().err


# --- Python -----------------------------------------------------------------------------------------------------------
def test_registering_makes_a_part_known_and_again_changes_nothing():
    @vc.register
    @parameters
    class Own(Exponential):
        name = "own"

    assert vc.register(Own) is Own
    text = CASE.replace("long-tail", "own").replace("third-harmonic", "harmonic")
    assert type(case_from_text(text).system.friction) is Own
    assert catalogue.law("anisotropic-own")(back_ratio=2.0).name == "anisotropic-own"
    assert case_from_text(case_text(case_from_text(text))) == case_from_text(text)
    vc.unregister(Own)
    with pytest.raises(CaseError, match="no law is called 'own'"):
        case_from_text(text)


def test_a_part_is_sought_in_the_files_of_the_package_once(monkeypatch):
    """A search reads its case anew for each of a thousand designs; the files were read for each name of each."""
    kinds = catalogue.Parts(catalogue.Law)
    kinds["coulomb"]
    monkeypatch.setattr(catalogue, "_modules", None)
    assert kinds["coulomb"] is vc.Coulomb


def test_a_class_defined_anew_takes_the_place_of_the_old_one_and_another_is_refused():
    def defined(low):
        @parameters
        class Own(Exponential):
            name = "own"
            coulomb_coefficient: Positive = parameter(low, "c", "level", "level")

        return Own

    vc.register(defined(0.1))
    vc.register(defined(0.2))  # as when a cell of a notebook is run again
    assert catalogue.law("own")().coulomb_coefficient == 0.2

    @parameters
    class Other(Exponential):
        name = "own"

    with pytest.raises(ValueError, match=r"Other: the law 'own' exists already, .*Own; give it another name"):
        vc.register(Other)


@pytest.mark.parametrize("given", [vc.LuGre(), 3, Law, Drive, vc.System])
def test_what_is_no_part_is_not_registered(given):
    with pytest.raises(TypeError, match="should be a class that extends Law, Machine, Drive or Controller, got "):
        vc.register(given)


def test_a_class_whose_parameters_are_not_declared_is_named():
    """One that adds none is as the class above it."""

    class Undeclared(vc.Oscillator):
        damper = vc.parameter(1.0, "c_2", "second damper", "viscous damping")

    class Same(vc.Oscillator):
        name = "same"

    for kind, said in ((Undeclared, "Undeclared should have @parameters"), (Same, "")):
        with pytest.raises(TypeError, match=said) if said else contextlib.nullcontext():
            vc.System(kind(), vc.Coulomb(0.1, 0.2), vc.Harmonic())


def test_a_file_is_run_once_and_again_after_a_change(folder):
    path = folder / "mylaws.py"
    law, drive = load_parts(path)
    assert load_parts(path) == (law, drive)
    path.write_text(path.read_text().replace("0.45", "0.5"))
    changed, _ = load_parts(path)
    assert changed().high == 0.5
    assert catalogue.law("long-tail") is changed
    assert file_of(changed) != file_of(law)


def test_a_part_of_a_file_goes_through_pickle_to_another_process(folder):
    law, _ = load_parts("mylaws.py")
    sent = pickle.dumps(vc.System(vc.PendulumCapsule(), law(knee=0.07), vc.Harmonic()))
    assert pickle.loads(sent).friction == law(knee=0.07)
    load_parts(shutil.copy("mylaws.py", "again.py"))  # the first class is no longer the registered one
    assert pickle.dumps(law()) == pickle.dumps(law())
    code = "import pickle, sys; print(pickle.load(sys.stdin.buffer).friction.knee)"
    done = subprocess.run([sys.executable, "-c", code], input=sent, capture_output=True)
    assert done.stdout.strip() == b"0.07", done.stderr.decode()


# --- installed packages -----------------------------------------------------------------------------------------------
def package(folder, name, module, text, value):
    """An installed package with an entry point."""
    (folder / f"{module}.py").write_text(text)
    info = folder / f"{name}-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}\nVersion: 1.0\n")
    (info / "entry_points.txt").write_text(f"[vibrocap.parts]\n{module} = {value}\n")


@pytest.fixture
def installed(tmp_path, monkeypatch):
    """A folder on the path of Python; the catalogue looks anew."""

    def forget():
        for cached in (catalogue._announced, catalogue._installed, catalogue.laws, catalogue.drives):
            cached.cache_clear()

    monkeypatch.syspath_prepend(tmp_path)
    forget()
    yield tmp_path
    forget()


def test_parts_of_installed_packages_are_known_and_a_broken_one_is_a_warning(installed):
    package(installed, "good-laws", "good_laws", FILE.read_text(), "good_laws")
    package(installed, "broken-laws", "broken_laws", "import nowhere\n", "broken_laws:Law")
    package(installed, "odd-laws", "odd_laws", law_text(), "odd_laws:Bad")
    package(installed, "greedy-laws", "greedy_laws", law_text(GOOD, name="lugre"), "greedy_laws")
    with pytest.warns(RuntimeWarning, match="parts of the package") as caught:
        known = dict(catalogue.laws())
    ordered = sorted(str(each.message) for each in caught)
    assert len(ordered) == 3
    assert "package broken-laws: the entry point 'broken_laws' cannot be loaded: ModuleNotFoundError" in ordered[0]
    assert "package greedy-laws: greedy_laws.Bad is left out: its name 'lugre' is taken" in ordered[1]
    assert "package odd-laws: the entry point 'odd_laws' is left out: Bad: force: is missing" in ordered[2]
    assert known["lugre"] is vc.LuGre
    assert case_from_text(CASE).system.friction.low == 0.15
    with pytest.raises(ValueError, match="'long-tail' exists already, good_laws"):
        load_parts(FILE)


def test_packages_are_looked_at_when_the_first_part_is_asked_for():
    code = "import sys, vibrocap as vc; vc.Exponential(); print(sys.modules.get('vibrocap.physics.catalogue'))"
    assert subprocess.run([sys.executable, "-c", code], capture_output=True, text=True).stdout.strip() == "None"


# --- studies ----------------------------------------------------------------------------------------------------------
def test_a_study_goes_on_only_with_the_same_file(folder, capsys, cheap):
    own = ["--parts", "mylaws.py", "--out", "map"]
    assert main([*SWEEP, *own]) == OK
    assert main([*SWEEP, *own, "--resume"]) == OK
    record = json.loads((folder / "map" / "study.json").read_text())["study"]
    assert list(record["parts"]) == ["friction.law = long-tail", "drive.waveform = third-harmonic"]
    assert set(record["parts"].values()) == {file_of(catalogue.law("long-tail"))[1]}
    (folder / "mylaws.py").write_text((folder / "mylaws.py").read_text() + "# edited\n")
    capsys.readouterr()
    assert main([*SWEEP, *own, "--resume"]) == WRONG_INPUT
    assert "map holds another study: the code of friction.law = long-tail: stored" in capsys.readouterr().err
    assert main(["plot", "map", "--out", "map.png"]) == OK  # what is stored is read without its parts


def test_a_study_of_the_packages_own_parts_does_not_mention_them():
    """So that studies stored before there were others keep their identity."""
    system = vc.System(vc.PendulumCapsule(), catalogue.law("anisotropic-lugre")(), vc.Harmonic())
    study = Study(Case(system), runs.Grid((runs.Column("friction.law", ("lugre", "exponential")),)), ("mean_velocity",))
    assert "parts" not in study.record()


def test_workers_load_the_file_and_refuse_another(folder, monkeypatch):
    law, drive = load_parts("mylaws.py")
    sources = sources_of([law, drive])
    assert sources == ((str(folder / "mylaws.py"), file_of(law)[1]),)
    vc.unregister(law)
    receive(sources)
    assert catalogue.law("long-tail") is law
    (folder / "mylaws.py").write_text("\n")
    with pytest.raises(StoreError, match=r"a worker on .* lacks parts of the study: .*mylaws.py: has changed"):
        receive(sources)
    (folder / "mylaws.py").unlink()
    with pytest.raises(StoreError, match=r"a worker on .* lacks parts of the study: .*cannot be read"):
        receive(sources)


def test_workers_are_not_sent_a_part_that_they_cannot_find():
    @parameters
    class Own(Exponential):
        name = "own"

    with pytest.raises(CaseError, match=r"Own stands in .*where workers cannot find it; put it in a file of its own"):
        sources_of([Own])
    assert sources_of([vc.LuGre]) == (("vibrocap.physics.friction.bristles", "LuGre"),)
    receive(sources_of([vc.LuGre]))


def test_the_fingerprint_of_a_part_changes_with_its_functions_and_with_nothing_else():
    def defined(factor, limit):
        @parameters
        class Own(Exponential):
            name = "own"
            reach = limit

            def steady_force(self, speed, load):
                return factor * super().steady_force(speed, load)

        return Own

    assert part_fingerprint(defined(1.0, 2.0)) == part_fingerprint(defined(1.0, 2.0))
    prints = {part_fingerprint(defined(*values)) for values in ((1.0, 2.0), (1.5, 2.0), (1.0, 3.0))}
    assert len(prints) == 3
