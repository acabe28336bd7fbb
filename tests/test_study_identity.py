"""What makes a study this study: its identity changes with all that can change a result, and with nothing else."""

import ast
import dataclasses
import json
from pathlib import Path

import pytest

import vibrocap
from vibrocap import Exponential, Harmonic, LuGre, Measure, PendulumCapsule, System
from vibrocap.case.case import CaseError
from vibrocap.studies.plan.designs import Design
from vibrocap.studies.plan.planning import planned_study
from vibrocap.studies.plan.study import (
    Study,
    code_differences,
    code_version,
    differences,
    imported_files,
    source_fingerprint,
)

SYSTEM = System(PendulumCapsule(), Exponential(), Harmonic())
SETTINGS = {
    "periods": 60,
    "window": 10,
    "settle": 0,
    "extrapolate": False,
    "tolerance": 1e-8,
    "max_events_per_period": 10_000,
    "max_steps": 50_000_000,
}
OVER = {"machine.mass_ratio": "1:2:3", "initial.angle": [0.1, 0.2]}


def study(
    system=SYSTEM, over=OVER, measures=("mean_velocity", "drift"), cases=None, design=None, initial=None, **settings
):
    return planned_study(
        system,
        None if cases else over,
        measures=measures,
        cases=cases,
        design=design,
        initial=initial,
        settings=SETTINGS | settings,
    )


RANGES = {"machine.mass_ratio": (1, 2)}
CHANGES = {
    "machine.stiffness": {"system": System(PendulumCapsule(stiffness=3.0), Exponential(), Harmonic())},
    "friction.law": {"system": System(PendulumCapsule(), LuGre(), Harmonic())},
    "drive.amplitude": {"system": System(PendulumCapsule(), Exponential(), Harmonic(amplitude=1.25))},
    "initial.velocity": {"initial": {"velocity": 0.5}},
    "periods": {"periods": 61},
    "window": {"window": 9},
    "settle": {"settle": 1e-6},
    "tolerance": {"tolerance": 1e-9},
    "max_events_per_period": {"max_events_per_period": 9},
    "max_steps": {"max_steps": 9},
    "measures": {"measures": ("drift",)},
    "values of initial.angle": {"over": OVER | {"initial.angle": [0.1, 0.3]}},
    "values of machine.mass_ratio": {"over": OVER | {"machine.mass_ratio": "1:2:4"}},
    "plan": {"over": dict(reversed(OVER.items()))},
    "design.seed": {"over": RANGES, "design": Design("sobol", 8, 1)},
    "design.kind": {"over": RANGES, "design": Design("halton", 8)},
    "design.runs": {"over": RANGES, "design": Design("sobol", 9)},
    "range of machine.mass_ratio": {"over": {"machine.mass_ratio": "log:1:2"}, "design": Design("sobol", 8)},
}


def test_extrapolation_is_part_of_a_study_whose_runs_settle():
    """Where they do not it means nothing; a record from before has none, and its runs waited."""
    waiting, other = study(settle=1e-6), study(settle=1e-6, extrapolate=True)
    assert waiting.identity != other.identity
    assert differences(waiting.record(), other.record()) == ["extrapolate: stored False, asked True"]
    assert study(extrapolate=True).identity == study().identity
    old = other.record()
    del old["extrapolate"]
    assert not Study.from_record(old).extrapolate


@pytest.mark.parametrize("what", CHANGES)
def test_whatever_changes_a_result_changes_the_identity_and_is_said(what):
    designed = "design" in CHANGES[what]
    before = study(over=RANGES, design=Design("sobol", 8)) if designed else study()
    after = study(**CHANGES[what])
    assert before.identity != after.identity
    said = differences(before.record(), after.record())
    assert any(text.startswith(f"{what}: stored ") and ", asked " in text for text in said), said
    assert differences(before.record(), before.record()) == []


def test_what_does_not_change_a_result_does_not_change_the_identity():
    same = study(
        over={"machine.mass_ratio": [1, 1.5, 2.0], "initial.angle": "0.1,0.2"}, measures=["drift", "mean_velocity"]
    )
    assert same.identity == study().identity
    assert study(periods=60.0, initial={}).identity == study().identity


def test_edited_code_is_another_study(tmp_path):
    sources = {
        "numerics/kernel/loop/one_step.py": "a = 1\n",
        "physics/friction/law.py": "b = 1\n",
        "measures/ensemble.py": "def run():\n    from vibrocap.motion import simulate\n",
        "motion/simulate.py": "from vibrocap.physics.system import System\n",
        "physics/system.py": "",
        "cli/main.py": "from vibrocap.measures.ensemble import run\n",
        "studies/s.py": "",
    }
    for name, text in sources.items():
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(text)
    first = source_fingerprint(tmp_path)
    for name in sources:
        source_fingerprint.cache_clear()
        (tmp_path / name).write_text(sources[name] + "c = 2\n")
        assert (source_fingerprint(tmp_path) == first) == name.startswith(("cli", "studies")), name
        (tmp_path / name).write_text(sources[name])
    source_fingerprint.cache_clear()
    assert source_fingerprint(tmp_path) == first
    mine = study()
    edited = dataclasses.replace(mine, code=code_version() | {"sources": "f" * 64})
    assert edited.identity != mine.identity
    assert code_differences(mine.code, edited.code)[0].startswith("code: stored vibrocap ")


@pytest.mark.slow
def test_imports_are_found_as_python_finds_them():
    """The sources that count are found by their import statements, which a pattern reads as Python's parser does."""
    package = Path(vibrocap.__file__).parent
    for path in package.rglob("*.py"):
        names: set[str] = set()
        for node in ast.walk(ast.parse(path.read_bytes())):
            if isinstance(node, ast.Import):
                names |= {alias.name for alias in node.names}
            elif isinstance(node, ast.ImportFrom) and node.module:
                names |= {node.module, *(f"{node.module}.{alias.name}" for alias in node.names)}
        wanted = {package.parent.joinpath(*name.split(".")).with_suffix(".py") for name in names}
        files = imported_files(path, package)
        assert {each for each in wanted if each.is_file()} == {file for file in files if file.is_file()}, path


def test_what_decides_the_bits_is_part_of_a_study():
    """The processor, LLVM, the system and NumPy; SciPy where it draws the runs, and only there."""
    drawn = {
        kind: study(over=RANGES, design=Design(kind, 8)) for kind in ("sobol", "halton", "latin-hypercube", "random")
    }
    mine, keys = study(), {"version", "sources", "processor", "features", "llvm", "system", "numpy"}
    assert set(mine.code) == set(drawn.pop("random").code) == keys
    assert all(set(each.code) == keys | {"scipy"} for each in drawn.values())
    assert all(mine.code.values())
    for name in keys:
        other = dataclasses.replace(mine, code=dict(mine.code) | {name: "another"})
        assert other.identity != mine.identity
        (said,) = code_differences(mine.code, other.code)
        assert said.startswith("code: " if name in ("version", "sources") else f"{name}: ")
    fewer = dict(mine.code) | {"features": mine.code["features"].partition(" ")[2]}
    assert code_differences(mine.code, fewer) == [f"features: stored {mine.code['features'].split()[0]}, here fewer"]


@pytest.mark.parametrize(
    "one",
    [
        study(settle=1e-6, initial={"angle": 0.25}),
        study(over={"friction.law": "exponential,lugre", "machine.normal_load": "weight,1"}),
        study(over=RANGES, design=Design("halton", 100, 7)),
        study(cases=[{"machine.mass_ratio": 3}, {"friction.law": "lugre"}]),
    ],
    ids=["grid", "words", "design", "cases"],
)
def test_a_study_is_read_back_from_its_record(one):
    again = Study.from_record(json.loads(json.dumps(one.record())))
    assert again == one
    assert again.identity == one.identity


FACTOR = 2.0


def _sign(m):
    return m.velocity


def test_a_measure_of_ones_own_is_known_by_its_function(monkeypatch):
    """By what it computes, with what it closes over and what it finds in its module."""

    def identity(of):
        return study(measures=[Measure.largest("peak", "largest |X'|", of), "drift"]).identity

    def scaled():
        return identity(lambda m: FACTOR * _sign(m))

    assert identity(lambda m: m.velocity) == identity(lambda m: m.velocity)
    one, two = (identity(lambda m, k=k: k * m.velocity) for k in (1.0, 2.0))
    others = [identity(of) for of in (lambda m: m.velocity, lambda m: m.angle + 1.0, lambda m: m.angle + 2.0)]
    assert len({one, two, *others}) == 5
    before = scaled()
    for name, value in (("FACTOR", 3.0), ("_sign", lambda m: -m.velocity)):
        with monkeypatch.context() as changed:
            changed.setitem(globals(), name, value)
            assert scaled() != before
    assert scaled() == before
    first = study(measures=[Measure.largest("peak", "largest |X'|", lambda m: m.velocity)])
    with pytest.raises(CaseError, match="'peak' is a measure of one's own"):
        Study.from_record(first.record())


def test_every_complaint_at_once():
    over = {"machine.mass_rato": "1:2:3", "machine.stiffness": "2:1:3"}
    wrong = {"measures": ["mean_velocty"], "initial": {"angel": 1.0}, "periods": 2.5, "tolerance": 1.0, "settle": -1.0}
    with pytest.raises(CaseError) as caught:
        study(over=over, **wrong)
    said = "\n".join(caught.value.complaints)
    for part in ("mass_ratio'", "is reversed", "'mean_velocity'", "'angle'", "got 2.5", "tolerance: ", "settle: "):
        assert part in said
    for arguments, part in (
        ({"window": 61}, "from 1 to the 60 periods"),
        ({"window": 2.0}, "window"),
        ({"measures": []}, "at least one"),
        ({"over": {}}, "at least one quantity"),
        ({"design": "sobol"}, "should be a Design"),
        ({"cases": [{"machine.mass_ratio": 1}], "design": Design("sobol", 8)}, "stand alone"),
        ({"over": RANGES, "design": Design("sobl", 8)}, "did you mean 'sobol'"),
    ):
        with pytest.raises(CaseError, match=part):
            study(**arguments)
