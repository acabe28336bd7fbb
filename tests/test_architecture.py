"""The shape of the project: what a reader may rely on before opening a single module.

The import contracts themselves are checked by import-linter in `make lint`.
"""

import ast
import re
import subprocess
import sys
import tomllib
from importlib.metadata import version
from pathlib import Path

import pytest

import mutants

ROOT = Path(__file__).resolve().parents[1]
MODULES = sorted((ROOT / "src").rglob("*.py"))
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
LOCK = (ROOT / "requirements.lock").read_text(encoding="utf-8")
USERS = ["plot", "sweep"]  # extras of requirements.lock; the others, by the lock that holds them
LOCKED_APART = {
    "dev": ["dev", "ref", "plot", "export", "sweep", "fit", "excel", "design"],
    "site": ["docs"],
    "exchange": ["exchange", "mujoco"],
}
LOCKS = [ROOT / "requirements.lock", *sorted((ROOT / ".ci").glob("*.txt"))]

LONGEST_MODULE = 400
VAGUE_NAMES = {"utils", "util", "helpers", "helper", "common", "misc"}
HEAVY = {"llvmlite", "scipy", "matplotlib", "xarray", "zarr", "dask"}


def test_version_is_the_same_everywhere():
    import vibrocap

    declared = PROJECT["version"]
    citation = re.search(r"^version: (.+)$", (ROOT / "CITATION.cff").read_text(encoding="utf-8"), re.MULTILINE)
    assert version("vibrocap") == declared
    assert vibrocap.__version__ == declared
    assert citation is not None
    assert citation.group(1).strip('"') == declared


def test_every_python_that_is_supported_is_named_and_looked_for():
    least = int(PROJECT["requires-python"].removeprefix(">=3."))
    stem = "Programming Language :: Python :: 3."
    named = [int(each.removeprefix(stem)) for each in PROJECT["classifiers"] if each.startswith(stem)]
    assert named == list(range(least, named[-1] + 1))
    assert named[-1] >= 15
    environment = (ROOT / ".ci" / "environment").read_text()
    assert " ".join(f"python3.{minor}" for minor in reversed(named)) in environment


def test_make_venv_makes_the_environment_alone():
    stdout = subprocess.run(["make", "--dry-run", "venv"], cwd=ROOT, capture_output=True, text=True, check=True).stdout
    assert "pytest" not in stdout
    assert "venv: $(READY)" in (ROOT / "Makefile").read_text()


def test_doors_open_to_a_name_they_list_and_to_no_other():
    import vibrocap
    from vibrocap.numerics import api

    for public, name in ((vibrocap, "Harmonic"), (api, "codes")):  # a class, and a module
        assert len(set(public.__all__)) == len(public.__all__)
        assert name in public.__all__
        assert getattr(public, name).__name__.endswith(name)
        assert not hasattr(public, "nothing_of_the_kind")


def test_newest_release_in_the_changelog_is_this_version():
    releases = re.findall(r"^## \[(\d[^\]]*)\] - \d{4}-\d{2}-\d{2}$", (ROOT / "CHANGELOG.md").read_text("utf-8"), re.M)
    assert releases[:1] == [PROJECT["version"]]


@pytest.mark.parametrize("path", LOCKS, ids=lambda path: path.name)
def test_lock_holds_names_versions_and_hashes_only(path):
    requirement = re.compile(r"[a-z0-9][a-z0-9.-]*==[0-9][\w.+!]*( ; [^/\\]+)? \\")
    digest = re.compile(r"    --hash=sha256:[0-9a-f]{64}( \\)?")
    comment = re.compile(r" *#[^/\\:]*:?")
    strange = [
        line
        for line in path.read_text(encoding="utf-8").splitlines()
        if line and not (requirement.fullmatch(line) or digest.fullmatch(line) or comment.fullmatch(line))
    ]
    assert strange == []


def test_what_the_checks_install_is_checked_by_hash():
    for script in (".ci/run", ".ci/environment"):
        lines = (ROOT / script).read_text(encoding="utf-8").replace("\\\n", " ").splitlines()
        installs = [line for line in lines if re.search(r"(pip|quietly)\b.* install -", line)]
        assert installs
        assert all("--require-hashes -r" in line for line in installs), script


def declared(requirements) -> set[str]:
    """The packages that requirements name, but for this one."""
    return {re.match(r"[A-Za-z0-9._-]+", requirement).group().lower() for requirement in requirements} - {"vibrocap"}


def locked(text: str) -> dict[str, str]:
    """The versions of a lock file by package."""
    return dict(re.findall(r"^([a-z0-9.-]+)==(\S+)", text, re.MULTILINE))


def test_the_users_lock_has_what_a_user_needs_and_nothing_of_developers():
    """The build backend stands in it too, so that the package installs from the lock alone."""
    extras, names = PROJECT["optional-dependencies"], locked(LOCK).keys()
    users = declared([*PROJECT["dependencies"], *(extra for name in USERS for extra in extras[name])])
    backend = {"hatchling", "editables"}
    assert users | backend <= names
    others = declared(extra for name in extras.keys() - USERS for extra in extras[name])
    assert names & (others - users) == backend
    assert extras.keys() - {"peers"} == {*USERS}.union(*LOCKED_APART.values())


def test_the_recipe_of_conda_has_version_command_and_dependencies_of_the_package():
    text = (ROOT / "extras" / "conda" / "recipe.yaml").read_text(encoding="utf-8")
    run = re.search(r"  run:\n    - python .*\n((?:    - .*\n)+)", text)
    assert [each.replace(" ", "") for each in re.findall(r"- (.+)", run[1])] == PROJECT["dependencies"]
    assert f"version: {PROJECT['version']}\n" in text
    assert re.findall(r"- (vibrocap) = (\S+)", text) == [*PROJECT["scripts"].items()]


def test_make_reproduce_needs_the_users_packages_alone_and_make_test_the_developers():
    """The steps of make for a clone without .venv: which locks are installed, in which order."""
    for target, wanted in {"reproduce": [""], "test": ["", ".ci/dev-requirements.txt"]}.items():
        asked = ["make", "--dry-run", "--always-make", target]
        steps = subprocess.run(asked, cwd=ROOT, capture_output=True, text=True, check=True).stdout
        assert re.findall(r"sh \.ci/environment *(.*)$", steps, re.MULTILINE) == wanted


@pytest.mark.parametrize("name", LOCKED_APART)
def test_a_lock_apart_covers_its_extras_and_agrees_with_the_others(name):
    """They are installed into one environment."""
    files = [LOCK, *((ROOT / ".ci" / f"{each}-requirements.txt").read_text(encoding="utf-8") for each in LOCKED_APART)]
    this, others = locked((ROOT / ".ci" / f"{name}-requirements.txt").read_text(encoding="utf-8")), map(locked, files)
    for extra in LOCKED_APART[name]:
        assert declared(PROJECT["optional-dependencies"][extra]) <= this.keys()
    for other in others:
        both = this.keys() & other.keys()
        assert {name: this[name] for name in both} == {name: other[name] for name in both}


def test_modules_are_short_and_their_names_say_what_they_hold():
    for path in MODULES:
        name = path.relative_to(ROOT / "src")
        assert len(path.read_text(encoding="utf-8").splitlines()) <= LONGEST_MODULE, name
        assert not VAGUE_NAMES & {part.strip("_") for part in name.with_suffix("").parts}, name


def test_importing_vibrocap_is_quick():
    """Heavy imports happen where they are used: `import vibrocap` loads none of them."""
    script = "import sys, vibrocap; print(*sorted(set(sys.argv[1:]) & set(sys.modules)))"
    answer = subprocess.run(
        [sys.executable, "-c", script, *sorted(HEAVY)], capture_output=True, text=True, check=True, timeout=60
    )
    assert answer.stdout.split() == []


def test_of_a_part_that_is_asked_for_by_name_its_file_alone_is_imported():
    script = (
        "import sys; from vibrocap.physics import catalogue; catalogue.machines()['oscillator']; "
        "catalogue.laws()['dahl']; print(*(m.partition('.physics.')[2] for m in sys.modules))"
    )
    answer = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True, timeout=60)
    loaded = {name for name in answer.stdout.split() if name.startswith(("machines.", "friction."))}
    own = {"machines.machine", "machines.stops", "machines.oscillators", "friction.law"}
    assert loaded == own | {"friction.hysteresis"}


def test_planted_faults_are_valid_and_change_the_source():
    """Of `make mutants`: drawn from every room alike, each a program still, and the same ones from the same seed."""
    faults = mutants.drawn(40, 3, ["physics/friction", "numerics/kernel/step"])
    assert faults == mutants.drawn(40, 3, ["physics/friction", "numerics/kernel/step"])
    assert {fault.path.split("/")[2] for fault in faults} == {"physics", "numerics"}
    for fault in (*faults, *mutants.faults_of(Path("src/vibrocap/physics/drives/harmonics.py"))):  # -(a + b) in it
        source = (ROOT / fault.path).read_text(encoding="utf-8")
        assert ast.dump(ast.parse(fault.planted(source))) != ast.dump(ast.parse(source)), fault


def test_completion_offers_a_hundred_names_and_no_other():
    import vibrocap

    assert len(dir(vibrocap)) == len(set(dir(vibrocap))) <= 110
    assert {*dir(vibrocap)} <= {*vibrocap.__all__}
    assert all(getattr(vibrocap, name) is not None for name in vibrocap.__all__)
