"""The documentation is true: snippets and commands run, what they are said to print is printed, links lead somewhere.

The words after a fence say how a test treats it: `python` runs (the blocks of a page share their names), `python FILE`
and `toml FILE` are files of a user, at hand where blocks and commands run, `text printed` is the output of the block
before, `python PACKAGE` and `text PACKAGE` are the same on their own where an optional package is installed, `sh` holds
commands, `toml` a case, `toml wrong` a case that is refused with the `text complaints` after it; `matlab` is run by
`test_tables.py`. Commands run where the folder `examples/` is at hand, as in the root of the repository.
"""

import contextlib
import dataclasses
import importlib
import io
import json
import re
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import vibrocap as vc
from thinned import exhaustive_but
from vibrocap.case.case import RUN_DEFAULTS, CaseError, case_from_text, case_text
from vibrocap.cli import main as cli
from vibrocap.cli.command import COMMANDS
from vibrocap.cli.overview import BEGIN
from vibrocap.cli.terminal import OK, WRONG_INPUT
from vibrocap.physics import catalogue
from vibrocap.physics.parameters import parameter_table

ROOT = Path(__file__).resolve().parents[1]
PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").rglob("*.md"))]
TUTORIALS = sorted((ROOT / "docs" / "tutorials").glob("*.ipynb"))
# Of these the snippets and commands are fast; others run studies or fits, or compile kernels that no fast test needs.
FAST_PAGES = ("README.md", "CONTRIBUTING.md")
RARE_PAGES = ("why-not-solve-ivp.md", "identification.md")  # long, and what they use is used by other tests
# Commands that begin so take more than a few seconds.
SLOW = tuple(
    f"vibrocap {name}"
    for name in (
        "reproduce",
        "orbit",
        "crossing",
        "branch",
        "basins",
        "friction",
        "fit",
        "stick-slip",
        "list --check",
        "lab",
        "sweep own.toml",
    )
)


@dataclasses.dataclass(frozen=True)
class Fence:
    """A fenced block of a page: the words after the fence, the text within, and the line where it begins."""

    page: Path
    words: tuple[str, ...]
    text: str
    line: int

    @property
    def name(self) -> str:
        return f"{self.page.relative_to(ROOT)}:{self.line}"


def fences(page: Path) -> list[Fence]:
    found, text = [], page.read_text(encoding="utf-8")
    for match in re.finditer(r"^( *)```(\w[^\n]*)\n(.*?)^\1```$", text, re.MULTILINE | re.DOTALL):
        indent, words, body = match.groups()
        line = text.count("\n", 0, match.start()) + 1
        body = "".join(row.removeprefix(indent) for row in body.splitlines(keepends=True))
        found.append(Fence(page, tuple(words.split()), body, line))
    return found


def cells(notebook: Path) -> list[tuple[str, str]]:
    """The (kind, text) of the cells of a notebook."""
    plane = json.loads(notebook.read_text(encoding="utf-8"))["cells"]
    return [(cell["cell_type"], "".join(cell["source"])) for cell in plane]


FENCES = [fence for page in PAGES for fence in fences(page)]
OPTIONAL = ("gymnasium", "fmpy")  # packages that blocks on their own need
FILES = [fence for fence in FENCES if len(fence.words) == 2 and "." in fence.words[1]]
OWN = ROOT / "examples" / "own_parts"  # the worked parts of CONTRIBUTING.md, in folders as those of `physics/`
FOLDERS = ("friction", "machines", "drives", "controllers")
NEW_FILES = [path for folder in FOLDERS for path in sorted((OWN / folder).glob("*.py"))]


def slow_page(page: Path) -> list:
    """The marks of a test that runs what stands on a page."""
    if page.name in RARE_PAGES:
        return [pytest.mark.exhaustive]
    return [] if page.name in FAST_PAGES else [pytest.mark.slow]


def kept(*words: str, runs: bool = False) -> list:
    """Blocks with these words after the fence, as parameters of a test, which may run them."""
    values = [fence for fence in FENCES if fence.words == words]
    return [pytest.param(fence, id=fence.name, marks=slow_page(fence.page) if runs else []) for fence in values]


def commands(text: str) -> list[str]:
    """Commands of a block or of a help text: its lines without comments."""
    lines = (line.partition(" #")[0].strip() for line in text.splitlines())
    return [line for line in lines if line]


@pytest.fixture
def workplace(tmp_path, monkeypatch):
    """A folder with the examples and the files of the pages at hand, as the current one."""
    (tmp_path / "examples").symlink_to(ROOT / "examples")
    for fence in FILES:
        (tmp_path / fence.words[1]).write_text(fence.text, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    before = catalogue.registered()
    yield tmp_path
    for part in set(catalogue.registered()) - set(before):
        catalogue.unregister(part)


def test_there_are_pages_with_blocks_of_every_kind():
    assert {fence.words for fence in FENCES} >= {
        ("python",),
        ("sh",),
        ("toml",),
        ("toml", "wrong"),
        ("text", "printed"),
    }
    known = {"printed", "by", "octave", "wrong", "complaints", *OPTIONAL, *(fence.words[1] for fence in FILES)}
    for fence in FENCES:
        assert fence.words[0] in ("python", "sh", "toml", "text", "matlab"), fence.name
        assert set(fence.words[1:]) <= known, fence.name


# --- links -----------------------------------------------------------------------------------------------------------


def prose(page: Path) -> str:
    """The text of a page or a notebook, without its blocks of code."""
    text = page.read_text(encoding="utf-8")
    if page.suffix == ".ipynb":
        return "\n".join(text for kind, text in cells(page) if kind == "markdown")
    return re.sub(r"```.*?```", "", text, flags=re.DOTALL)


def anchors(page: Path) -> set[str]:
    """Anchors of the headings of a page."""
    heads = re.findall(r"^#+ (.+)$", page.read_text(encoding="utf-8"), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", head.lower()).replace(" ", "-") for head in heads}


LINKING = [*PAGES, *TUTORIALS, ROOT / "CHANGELOG.md", ROOT / "examples" / "README.md"]


@pytest.mark.parametrize("page", LINKING, ids=lambda page: str(page.relative_to(ROOT)))
def test_relative_links_lead_somewhere(page):
    for target in re.findall(r"\]\(([^)\s]+)\)", prose(page)):
        path, _, anchor = target.partition("#")
        if "://" in target:
            continue
        found = (page.parent / path).resolve() if path else page
        assert found.exists(), target
        assert found.is_relative_to(ROOT), target
        if anchor:
            assert anchor in anchors(found), target


def test_index_names_every_page():
    linked = set(re.findall(r"\]\(([^)#]+)\)", (ROOT / "docs" / "index.md").read_text(encoding="utf-8")))
    pages = (page for page in (*PAGES, *TUTORIALS) if page.is_relative_to(ROOT / "docs"))
    assert {page.relative_to(ROOT / "docs").as_posix() for page in pages} - {"index.md"} <= linked


def test_pages_that_the_sources_cite_are_there():
    sources = (path for folder in ("src", "tests", "benchmarks", "examples") for path in (ROOT / folder).rglob("*.py"))
    for path in sources:
        for cited in re.findall(r"(?<![\w{}*/-])((?:docs/)?[A-Za-z-]+\.md)\b", path.read_text(encoding="utf-8")):
            assert any((folder / cited).exists() for folder in (ROOT, ROOT / "docs")), f"{path}: {cited}"


@pytest.mark.parametrize(("name", "most"), [("travel.png", 200_000), ("travel.webp", 1_000_000)])
def test_pictures_are_small_enough_to_load_with_the_page(name, most):
    assert (ROOT / "docs" / "images" / name).stat().st_size < most


# --- snippets --------------------------------------------------------------------------------------------------------


def run_snippets(fences: list, code: tuple[str, ...], printed: tuple[str, ...]) -> None:
    """Runs the snippets, one after the other; each prints what the text behind it says."""
    names: dict = {}
    output = io.StringIO()
    for fence in fences:
        if fence.words == code:
            output = io.StringIO()
            # Blank lines in front give an error the line number of the page.
            program = compile("\n" * fence.line + fence.text, fence.name, "exec")
            with contextlib.redirect_stdout(output):
                exec(program, names)
        elif fence.words == printed:
            assert output.getvalue() == fence.text, fence.name


@pytest.mark.parametrize(
    "page",
    [
        pytest.param(page, id=str(page.relative_to(ROOT)), marks=slow_page(page))
        for page in PAGES
        if any(fence.words == ("python",) for fence in fences(page))
    ],
)
def test_snippets_run_and_print_what_they_are_said_to(page, workplace):
    run_snippets(fences(page), ("python",), ("text", "printed"))


@pytest.mark.slow
@pytest.mark.parametrize("package", OPTIONAL)
def test_snippets_that_need_a_package_run_where_it_is(package, workplace):
    pytest.importorskip(package, reason=f"{package} is not installed")
    run_snippets(FENCES, ("python", package), ("text", package))


def test_the_readme_snippet_is_the_agreed_one_and_ends_where_it_says(workplace):
    names: dict = {}
    readme = next(fence for fence in FENCES if fence.page.name == "README.md" and fence.words == ("python",))
    exec(readme.text, names)
    motion, text = names["motion"], " ".join(readme.page.read_text(encoding="utf-8").split())
    kinds = list(motion.event_kinds)
    assert f"ends at {motion.state['position']:.7f}" in text
    counts = f"sticks {kinds.count('stick')} times and reverses {kinds.count('reversal')} times without sticking"
    assert counts in text


# --- tutorials -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("notebook", TUTORIALS, ids=lambda path: path.stem)
def test_a_tutorial_is_kept_without_results_and_begins_by_installing(notebook):
    content = json.loads(notebook.read_text(encoding="utf-8"))
    code = [cell for cell in content["cells"] if cell["cell_type"] == "code"]
    assert all(cell["outputs"] == [] and cell["execution_count"] is None for cell in code)
    assert [cell["id"] for cell in content["cells"]] == [f"cell-{i:02}" for i in range(1, len(content["cells"]) + 1)]
    assert content["cells"][0]["source"][0].startswith("# ")
    assert code[0]["source"] == json.loads(TUTORIALS[0].read_text(encoding="utf-8"))["cells"][1]["source"]
    assert 'find_spec("vibrocap") is None' in "".join(code[0]["source"])


@pytest.mark.exhaustive
@pytest.mark.slow
@pytest.mark.parametrize("notebook", TUTORIALS, ids=lambda path: path.stem)
def test_a_tutorial_runs_from_top_to_bottom(notebook, workplace):
    names: dict = {}
    for number, (kind, text) in enumerate(cells(notebook), 1):
        if kind == "code":
            magics = re.compile(r"^%.*$", re.MULTILINE)  # commands of the notebook, such as %matplotlib
            exec(compile(magics.sub("", text), f"{notebook.name}, cell {number}", "exec"), names)
    if "plt" in names:
        names["plt"].close("all")


# --- commands --------------------------------------------------------------------------------------------------------


def run_command(command: str) -> None:
    words = shlex.split(command)
    assert words[0] == "vibrocap", command
    assert cli.main(words[1:]) == OK, command


@pytest.mark.parametrize("fence", kept("sh", runs=True))
def test_commands_run_word_for_word(fence, workplace, capsys):
    targets = set(re.findall(r"^([a-z-]+):", (ROOT / "Makefile").read_text(encoding="utf-8"), re.MULTILINE))
    for command in commands(fence.text):
        if command.startswith("make "):
            assert set(command.split()[1:]) <= targets, command
        elif not command.startswith(SLOW):
            run_command(command)


def test_every_command_has_examples_of_its_own(capsys):
    """Under its help, word for word, and of nothing else."""
    for name, each in COMMANDS.items():
        assert cli.main([name, "--help"]) == OK
        text = " ".join(capsys.readouterr().out.split())
        assert text.rpartition("Examples:")[2].strip() == " ".join(each.examples)
        assert all(line.startswith(f"vibrocap {name}") for line in each.examples)
        assert each.examples


SLOW_COMMANDS = sorted(
    {
        command
        for text in (BEGIN, *(fence.text for fence in FENCES if fence.words == ("sh",)))
        for command in commands(text)
        if command.startswith(SLOW)
    }
)
cli.app_of()
FIRST = ("examples", "new", "simulate", "sweep")  # they write what others read
HELP = [line for name in dict.fromkeys((*FIRST, *COMMANDS)) for line in COMMANDS[name].examples]
ELSEWHERE = ("vibrocap list datasets --fetch",)  # they need a network


def test_commands_of_the_cheat_sheet_are_those_that_the_help_shows_and_tests_run():
    sheet = (ROOT / "docs" / "cheat-sheet.md").read_text(encoding="utf-8")
    shown = re.findall(r"`(vibrocap [^`]+)`", sheet)
    assert len(shown) > 15
    assert set(shown) <= {*HELP}
    assert len(sheet.splitlines()) <= 70  # one page


@pytest.mark.slow
def test_quick_examples_of_the_help_run_word_for_word(workplace, capsys):
    (workplace / "examples").unlink()  # one of them makes this folder
    for command in HELP:
        if not command.startswith((*SLOW, *ELSEWHERE)):
            run_command(command)


@pytest.mark.slow
def test_slow_examples_of_the_help_run_word_for_word(workplace, capsys):
    run_command("vibrocap new --out case.toml")
    write_damper("damper.csv")
    write_axis("axis")
    write_pull("pull.csv")
    for command in set(HELP) - set(SLOW_COMMANDS):  # those are run below
        if command.startswith(SLOW) and not command.startswith(("vibrocap reproduce --out", *ELSEWHERE)):
            run_command(command)


def write_damper(path: str) -> None:
    """Force and motion of a LuGre contact that is shaken, with a header that needs no words."""
    time = np.linspace(0.0, 4.0, 801)
    velocity = 0.3 * np.sin(2 * np.pi * time) + 0.1 * np.sin(5 * time)
    driven = vc.driven_force(vc.Dahl(), time, velocity=velocity)
    rows = (
        f"{t!r},{f!r},{v!r}" for t, f, v in zip(*map(np.ndarray.tolist, (time, driven.force, velocity)), strict=True)
    )
    Path(path).write_text("time_s,force [N],velocity [m/s]\n" + "\n".join(rows) + "\n")


def write_axis(name: str) -> None:
    """A mass on friction under a force, as a case in SI and as its record."""
    system = vc.Oscillator.in_si(mass_kg=80.0, stiffness_N_per_m=0.0, normal_load_N=1.0), vc.Coulomb(20.0, 20.0)
    case = vc.System(*system, vc.Harmonic.in_si(amplitude_N=60.0, frequency_Hz=0.5))
    vc.save_case(case, f"{name}.toml")
    motion = vc.simulate(case, periods=2)
    columns = (motion.time, motion["drive"], motion["position"])
    rows = (",".join(map(repr, row)) for row in zip(*map(np.ndarray.tolist, columns), strict=True))
    Path(f"{name}.csv").write_text("time_s,force [N],displacement [m]\n" + "\n".join(rows) + "\n")


def write_pull(path: str) -> None:
    """The force on a slider that sticks and slips: a saw of ten teeth."""
    time = np.linspace(0.0, 100.0, 20_001)
    force = 0.06 + 0.02 * (time / 10.0 - np.floor(time / 10.0))
    np.savetxt(path, np.column_stack((time, force)), delimiter=",", header="time [s],force [N]", comments="")


# What these commands do is shown as a whole by tests/test_paper.py and tests/test_lab_browser.py, and the
# help has examples of the others.
SHOWN_ELSEWHERE = (
    "vibrocap reproduce",
    "vibrocap lab",
    "vibrocap basins",
    "vibrocap friction lugre --tests",
    "vibrocap orbit",
)


@pytest.mark.slow
@pytest.mark.parametrize(
    "command",
    exhaustive_but(
        [i for i, command in enumerate(SLOW_COMMANDS) if not command.startswith(SHOWN_ELSEWHERE)], SLOW_COMMANDS
    ),
)
def test_slow_commands_run_word_for_word(command, workplace, capsys):
    run_command(command)


def test_every_make_target_in_the_text_exists():
    targets = set(re.findall(r"^([a-z-]+):", (ROOT / "Makefile").read_text(encoding="utf-8"), re.MULTILINE))
    for page in PAGES:
        assert set(re.findall(r"`make ([a-z-]+)`", page.read_text(encoding="utf-8"))) <= targets, page.name


# --- case files ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("fence", kept("toml"))
def test_cases_are_complete(fence):
    case = case_from_text(fence.text)
    assert case_from_text(case_text(case)) == case


@pytest.mark.parametrize("fence", kept("toml", "wrong"))
def test_wrong_cases_get_the_answer_that_is_shown(fence):
    shown = next(f for f in FENCES if f.page == fence.page and f.line > fence.line and f.words[0] == "text")
    with pytest.raises(CaseError) as caught:
        case_from_text(fence.text)
    assert "\n".join(f"  {complaint}" for complaint in caught.value.complaints) + "\n" == shown.text


def test_page_of_case_files_has_every_key_with_its_default():
    text = (ROOT / "docs" / "case-files.md").read_text(encoding="utf-8")
    rows = {key: cells.split("|") for key, cells in re.findall(r"^\| `(\w+)` \|(.+)\|$", text, re.MULTILINE)}
    parts = [vc.PendulumCapsule, vc.Exponential, vc.LuGre, vc.Harmonic, vc.Biharmonic]  # the others: symbols.md
    parts += [vc.Environment, vc.Actuator, vc.PositionPID]
    for kinds in (catalogue.machines(), catalogue.laws(), catalogue.drives(), catalogue.controllers()):
        assert all(f'"{name}"' in text for name in kinds)
    for part in parts:
        for info in parameter_table(part):
            given = rows[info.name][1].strip()
            said = given.strip('`"') if isinstance(info.default, str) else None if given == "none" else float(given)
            assert said == info.default, info.name
    for name, default in RUN_DEFAULTS.items():
        assert float(rows[name][0]) == default, name
    known = {info.name for part in parts for info in parameter_table(part)}
    assert set(rows) == known | set(RUN_DEFAULTS)


# --- the worked parts of CONTRIBUTING.md -----------------------------------------------------------------------------


def test_contributing_links_to_every_worked_part():
    text = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
    linked = set(re.findall(r"\]\((examples/own_parts/[^)#]+\.\w+)\)", text))
    parts = {path.relative_to(ROOT).as_posix() for path in OWN.rglob("*.*") if path.suffix in (".py", ".toml")}
    assert linked == parts
    assert [path.parent.name for path in NEW_FILES] == ["friction", "machines", "machines", "drives", "controllers"]


@pytest.mark.slow
@pytest.mark.parametrize("path", sorted(OWN.glob("*.py")), ids=lambda path: path.stem)
def test_a_worked_script_runs_and_holds_what_it_asserts(path):
    done = subprocess.run([sys.executable, str(path)], cwd=ROOT, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr
    assert done.stdout
    if path.stem == "breaking_capsule":
        run_command(f"vibrocap list breaking-capsule --parts {path} --check")


@pytest.fixture
def new_parts(tmp_path):
    """The package as if the new files stood in it."""
    # a copy, whose bytecode harms nobody
    shutil.copytree(OWN, tmp_path, dirs_exist_ok=True, ignore=shutil.ignore_patterns("__pycache__"))
    packages = [importlib.import_module(f"vibrocap.physics.{folder}") for folder in FOLDERS]
    before = set(sys.modules)
    finders = (catalogue.laws, catalogue.machines, catalogue.drives, catalogue.controllers)
    for package in packages:
        package.__path__.append(str(tmp_path / package.__name__.rpartition(".")[2]))
    for find in finders:
        find.cache_clear()
    importlib.invalidate_caches()
    yield
    for package in packages:
        package.__path__.pop()
        for name in set(sys.modules) - before:
            if name.startswith(package.__name__ + "."):
                delattr(package, name.rpartition(".")[2])
                del sys.modules[name]
    for find in finders:
        find.cache_clear()


@pytest.mark.slow
def test_new_parts_are_found_compiled_and_certified(new_parts, workplace, capsys):
    text = (OWN / "case.toml").read_text(encoding="utf-8")
    case = case_from_text(text)
    assert case_from_text(case_text(case)) == case
    motion = case.simulate()
    assert motion.status.ok
    assert set(motion.event_kinds) >= {"stick", "slip_forward", "slip_back", "impact", "stop_opened"}
    assert motion.certificate.ok
    assert vc.response_class(motion).symmetric is None  # the load rises one way only: an odd drive, and it travels
    assert vc.drift(motion) > 0.05
    Path("case.toml").write_text(text, encoding="utf-8")
    run_command("vibrocap simulate case.toml --json --out run.nc --plot run.png")
    run_command("vibrocap simulate run.nc")
    for part in (case.system.machine, case.system.friction, case.system.drive):
        run_command(f"vibrocap list {part.name} --check")
    run_command("vibrocap list cubic --check")
    capsys.readouterr()
    assert cli.main(["friction", "case.toml"]) == WRONG_INPUT
    assert "Hyperbolic" in capsys.readouterr().err
    Path("case.toml").write_text(text.replace("hyperbolic", "hyperbolc"), encoding="utf-8")
    assert cli.main(["simulate", "case.toml"]) == WRONG_INPUT
    assert "did you mean 'hyperbolic'?" in capsys.readouterr().err


@pytest.mark.slow
def test_the_new_machine_with_two_contacts_is_found_compiled_and_certified(new_parts, workplace, capsys):
    """It moves as the row of two blocks does that has its parameters, under a law for each contact."""
    machine = catalogue.machines()["tandem"]()
    row = vc.TwoBlockRow(
        mass_2=machine.mass_ratio,
        stiffness_2=0.0,
        actuation_2=0.0,
        coupling_stiffness=machine.coupling_stiffness,
        belt_speed=machine.belt_speed,
    )
    laws, drive, ends = [vc.Coulomb(0.3, 0.5), vc.Stribeck()], vc.Harmonic(amplitude=0.6, frequency=0.8), []
    for each in (machine, row):
        motion = vc.simulate(vc.System(each, laws, drive), periods=20, tolerance=1e-12)
        assert motion.certificate.ok
        assert {"stick", "stick_2", "slip_back", "slip_back_2"} <= set(motion.event_kinds)
        assert vc.energy_balance(motion).belt > 0.0
        ends.append(motion.state)
    assert ends[0] == pytest.approx(ends[1], abs=1e-9)
    text = case_text(vc.Case(vc.System(machine, laws, drive), periods=20))
    assert "[friction_2]" in text
    run_command("vibrocap list tandem --check")


@pytest.fixture
def new_command(monkeypatch):
    """The command line as if the new file stood among the commands."""
    path = OWN / "commands" / "passes.py"
    assert len(path.read_text(encoding="utf-8").splitlines()) <= 40
    monkeypatch.setattr(cli.commands, "__path__", [*cli.commands.__path__, str(path.parent)])
    monkeypatch.setattr(sys, "dont_write_bytecode", True)
    cli.app_of.cache_clear()
    yield path.stem
    cli.app_of.cache_clear()
    COMMANDS.pop(path.stem)
    sys.modules.pop(f"{cli.commands.__name__}.{path.stem}")


def test_a_new_command_is_found_explained_and_refuses(new_command, workplace, capsys):
    case = ["examples/travels-by-stick-slip.toml"]
    assert cli.main([new_command, *case, "--state", "angle", "--value", "0.5", "--json"]) == OK
    times = json.loads(capsys.readouterr().out)["times"]
    motion = vc.read_case(case[0]).simulate()
    assert len(times) == 80  # there and back in each of the 40 periods
    assert motion.at(times[::20], "angle") == pytest.approx(0.5, abs=1e-9)
    assert cli.main([new_command, *case, "--state", "angel"]) == WRONG_INPUT
    assert "--state: no state is called 'angel'; did you mean 'angle'?" in capsys.readouterr().err
    assert cli.main([new_command, *case, "--state", "angle", "--value", "nan"]) == WRONG_INPUT
    assert "--value: should be a finite number" in capsys.readouterr().err
    with contextlib.suppress(SystemExit):
        cli.main([new_command, "--help"])
    said = capsys.readouterr().out
    assert "a state of the system, such as angle" in said
    assert f"vibrocap {new_command} examples/travels" in said


@pytest.mark.exhaustive
@pytest.mark.slow
def test_picture_and_film_are_drawn_by_their_scripts(tmp_path):
    """Not byte for byte, which fonts and libraries decide, but they are drawn."""
    for name in ("travel", "film"):
        shutil.copy(ROOT / "docs" / "images" / f"{name}.py", tmp_path)
        subprocess.run([sys.executable, str(tmp_path / f"{name}.py")], check=True, timeout=600)
    assert (tmp_path / "travel.png").stat().st_size > 50_000
    assert (tmp_path / "travel.webp").stat().st_size > 500_000
