"""Every face of every case: kinds of parts, units, optional numbers, commands and outputs meet in pairs.

A row of a covering array (`case_matrix.py`) is a case. No face may end in a traceback; what a face cannot show is
refused in words.
"""

import inspect
import itertools
import json
import re
from pathlib import Path
from typing import Any

import pytest

import case_matrix
import vibrocap as vc
from covering_array import covering_array
from mechanisms import BeltRow, Slider
from thinned import exhaustive_but, slow_but
from vibrocap.cli.commands.simulate import in_words
from vibrocap.cli.main import main
from vibrocap.mechanics import coordinate
from vibrocap.physics.catalogue import machines
from vibrocap.physics.symbols import machine_symbols
from vibrocap.plotting.look.labels import parts_in_si, parts_title, quantity_label, symbol_text

SYSTEM = vc.System(vc.PendulumCapsule(), vc.Exponential(), vc.Harmonic())
TRAVELS = Path(__file__).parents[1] / "examples" / "travels-by-stick-slip.toml"
FEW, ROWS, KINDS = 27, 91, 26
# what exports refuse of a case
REFUSED = re.compile("CASE: .*MuJoCo")


@pytest.fixture
def shown(tmp_path, monkeypatch, capsys):
    """A function that runs a command in a folder of its own and gives what it printed; films and pages are short."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("vibrocap.plotting.animation.FRAMES_PER_SECOND", 1)
    monkeypatch.setattr("vibrocap.numerics.api.browser_module", lambda forms: b"")  # test_lab.py compiles them

    def run(command, *options, refused=None):
        code = main([*command.split(), "case.toml", *options])
        told = capsys.readouterr()
        assert code in (0, 3) or (code == 2 and refused and refused.search(told.err)), (command, options, told.err)
        return told.out

    return run


def written(row, folder):
    """The case of a row, in a file."""
    (folder / "case.toml").write_text(case_matrix.text_of(row), encoding="utf-8")


def exported(shown, row, *kinds):
    """The exports of a case, and the case in the other form."""
    scales = ",".join(f"{name}={value}" for name, value in scales_of(row).items())
    shown("new --from", *(["--scales", scales] if scales and row["units"] == case_matrix.PLAIN else []))
    for kind in kinds:
        none = ["--platforms", "none"] if kind == "fmu" else []
        place = {"fmu": "case.fmu", "mjcf": "case.xml"}.get(kind, kind)
        shown("export", "--to", kind, "--out", place, *none, refused=REFUSED)


def scales_of(row):
    """What a case without units does not say of its units."""
    kind = type(case_matrix.system_of(row).machine).si_scales
    return {name: value for name, value in vars(case_matrix.part(kind, row["optional"])).items() if value is not None}


@pytest.mark.parametrize("first", ["system", "motion"])
def test_every_function_says_what_its_first_argument_should_be(first):
    """A machine in place of a system is what newcomers give first."""
    public = (getattr(vc, name) for name in dir(vc))
    asked = [
        each for each in public if inspect.isfunction(each) and [*inspect.signature(each).parameters][:1] == [first]
    ]
    assert len(asked) > 3
    for function in asked:
        needed = [p for p in inspect.signature(function).parameters.values() if p.default is p.empty]
        if needed and needed[0].annotation is not Any:
            with pytest.raises(ValueError, match=rf"(?i)^{first} should be a {first}, .* got PendulumCapsule\("):
                function(vc.PendulumCapsule(), *needed[1:])


@pytest.mark.parametrize(
    ("call", "said"),
    [
        (lambda: vc.simulate(SYSTEM, initial=[0.1, 0.2]), 'initial should be a mapping such as {"velocity": 0.1}, got'),
        (lambda: SYSTEM.with_parameters(3), 'values should be a mapping such as {"drive.amplitude": 2.0}, got 3'),
        (lambda: vc.ensemble(SYSTEM, {"drive.amplitude": [1.0]}, measures=3), "measures: there is no measure 3"),
        (lambda: vc.fit(3, "coulomb"), "records should be vc.Record(...) or of read_records(...), got 3"),
        (lambda: vc.fit_motion(SYSTEM, 3, {}), "records should be vc.Record(...) or of read_records(...), got 3"),
        (lambda: vc.System(3, vc.Coulomb(), vc.Harmonic()), "machine should be a machine, got 3"),
        (lambda: vc.orbit(SYSTEM, initial=3), 'initial should be a mapping such as {"velocity": 0.1}, got 3'),
        (lambda: vc.read_case(TRAVELS, 3), 'changes should be a mapping by name, {"name": value}, got 3'),
        (lambda: vc.frictional_limits(SYSTEM, velocities=3), "velocities should be a list, got 3"),
        (lambda: vc.read_records(3), "path should be a path or a list, got 3"),
    ],
)  # fmt: skip
def test_what_is_of_another_kind_is_named(call, said):
    with pytest.raises((TypeError, ValueError), match="^" + re.escape(said)):
        call()


def test_a_covering_array_covers_its_pairs():
    """Also where rows are refused; what no row can have is told."""
    factors = {"a": (1, 2, 3), "b": (1, 2), "c": (1, 2, 3), "d": (1, 2)}

    def possible(row):
        return not (row["a"] == 3 and row["b"] == 2) and row["c"] != row["d"]

    rows, never = covering_array(factors, possible, [("b", "d")])
    met = {(x, row[x], y, row[y]) for row in rows for x, y in itertools.combinations(factors, 2)}
    wanted = {(x, i, y, k) for x, y in itertools.combinations(factors, 2) for i in factors[x] for k in factors[y]}
    assert all(map(possible, rows))
    assert set(never) == {("a", 3, "b", 2), ("c", 1, "d", 1), ("c", 2, "d", 2)}
    assert {each for each in wanted - met if (each[0], each[2]) != ("b", "d")} == set(never)
    assert len(rows) <= 12
    assert covering_array(factors, possible, [("b", "d")]) == (rows, never)


def test_every_kind_of_part_is_put_into_words():
    """In tables and in titles of pictures, in SI and without units, with optional numbers and without."""
    for row in case_matrix.every_kind():
        for units, optional in itertools.product((case_matrix.PLAIN, case_matrix.SI), case_matrix.FACES["optional"]):
            system = case_matrix.system_of(row | {"units": units, "optional": optional})
            parts = {} if system is None else system.parts
            words = " ".join(in_words(part, system) for part in parts)
            words += "" if system is None else parts_title(parts.values(), 7.0)
            words += "" if system is None or system.units is None else parts_in_si(system, 7.0)
            assert "None" not in words


def test_labels_of_states_have_the_symbols_of_their_machine():
    """Sheets drew the speed of a stage on a rod that shakes as X', zero while X changed, and every place as X."""
    for machine in (*(kind() for kind in machines().values()), Slider()):
        system = vc.System(machine, vc.Coulomb(), vc.Harmonic())
        for name, (symbol, _) in machine_symbols(type(machine)).items():
            assert quantity_label(name, system).endswith(f" {symbol_text(symbol)}")
    assert quantity_label("velocity", system) == "sliding velocity $v$"

    @vc.parameters
    class Lifted(Slider):
        position = coordinate("v", "place of the stage", "m")

    assert quantity_label("position", vc.System(Lifted(), vc.Coulomb(), vc.Harmonic())).endswith("position $v$")


@pytest.mark.parametrize("path", ["drives.belt.amplitude", 'frictions."block 2".static_coefficient', "friction_2.law"])
def test_what_a_mechanism_names_is_swept_stored_and_resumed(cheap, tmp_path, path):
    """A store took paths of two words alone: no study over a signal could be stored."""
    system = vc.System(BeltRow(), [vc.Coulomb(0.3), vc.Coulomb(0.3)], vc.Harmonic())
    values = ["coulomb", "lugre"] if path.endswith("law") else [0.4, 0.5]
    for resume in (False, True):
        vc.sweep(system, {path: values}, measures=["peak_friction"], out=tmp_path / "study", resume=resume)
    assert vc.verify_study(tmp_path / "study").ok


@pytest.mark.parametrize("number", slow_but(range(0, 12, 4), exhaustive_but(range(0, 12, 2), range(12))))
def test_a_case_is_exported(shown, tmp_path, number):
    """What needs no motion: every kind of part in SI, with the least that a case has to say."""
    row = case_matrix.every_kind()[number]
    written(row, tmp_path)
    exported(shown, row, "c", "fmu", "mjcf")
    for command in ("list measures", "friction", "simulate --cite text"):
        shown(command, refused=re.compile("law"))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("rows", "number"),
    exhaustive_but(range(0, FEW, 20), [*(("few_rows", i) for i in range(FEW)), *(("rows", i) for i in range(ROWS))]),
)
def test_a_case_is_shown(shown, tmp_path, rows, number):
    row = getattr(case_matrix, rows)()[number]
    written(row, tmp_path)
    json_ = ["--json"] if row["printed"] == "json" else []
    picture, out = row["picture"], row["out"]
    told = shown("simulate", *json_, "--plot", f"run{picture}", "--out", f"run{out[0]}")
    shown("simulate", "--out", f"run{out[1]}", *(["--animate", "run.gif"] if row["further"] == "film" else []))
    assert not json_ or json.loads(told)["status"]
    assert all((tmp_path / f"run{ending}").is_file() for ending in out) or "stopped at time 0 " in told
    exported(shown, row, *row["exported"])
    if row["further"] == "sweep":
        system = case_matrix.system_of(row)
        start = next(name for name in system.state_names if name not in system.placed.room())
        stored = ["--out", "map", "--export", f"map{out[0]}"]
        shown("sweep", "--over", f"initial.{start}=0,1e-3", "--measure", "peak_friction", *stored)
        assert main(["plot", "map", "--out", f"map{picture}"]) == 0
        assert (tmp_path / f"map{picture}").is_file()
    elif row["further"] == "lab":
        shown("lab", "--laws", row["friction"], "--drives", row["drive"], "--out", "page.html")


@pytest.mark.slow
@pytest.mark.parametrize("number", exhaustive_but((5,), range(KINDS)))
def test_the_steady_motion_of_a_case_is_shown(shown, tmp_path, number):
    """Also of one that does not settle; `orbit` compiles seconds of kernels, so that few rows are looked at."""
    written(case_matrix.every_kind()[number], tmp_path)
    shown("orbit", "--settle-periods", "3", *(["--json"] if number % 2 else []))


@pytest.mark.exhaustive
def test_all_rows_are_run():
    matrices = case_matrix.few_rows, case_matrix.rows, case_matrix.every_kind
    assert [len(made()) for made in matrices] == [FEW, ROWS, KINDS]
