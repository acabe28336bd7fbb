"""The package as it is installed: a wheel, a source distribution, and what a user of either finds.

Everything is built and installed in temporary folders, outside the sources; pip must reach a package index.
"""

import json
import os
import re
import shutil
import subprocess
import sys
import tarfile
import tomllib
import zipfile
from pathlib import Path

import pytest

import vibrocap as vc
from thinned import exhaustive_but

ROOT = Path(__file__).resolve().parents[1]
VERSION = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["version"]
EXAMPLES = sorted(path.name for path in (ROOT / "examples").iterdir() if path.suffix in (".toml", ".csv"))
PYTHONS = ("3.11", "3.15 3.14 3.13 3.12")  # the oldest, and the newest that is there
CLEAN = {name: value for name, value in os.environ.items() if name not in ("PYTHONPATH", "VIRTUAL_ENV", "PYTHONHOME")}

pytestmark = pytest.mark.slow


def run(*words, **options) -> str:
    """What a command prints, its errors included; AssertionError with these where it fails."""
    done = subprocess.run(
        [str(word) for word in words], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, timeout=600,
        env=CLEAN | options.pop("env", {}), check=False, **options,
    )  # fmt: skip
    assert done.returncode == 0, f"{words}:\n{done.stdout[-4000:]}"
    return done.stdout


def build(sources: Path, folder: Path, *targets: str) -> list[Path]:
    """Distributions of a folder of sources."""
    options = [word for target in targets for word in ("-t", target)]
    run(sys.executable, "-m", "hatchling", "build", "-d", folder, *options, cwd=sources)
    return sorted(folder.iterdir())


@pytest.fixture(scope="module")
def distributions(tmp_path_factory) -> tuple[Path, Path]:
    """(source distribution, wheel) of the sources as they are."""
    sdist, wheel = sorted(build(ROOT, tmp_path_factory.mktemp("built"), "sdist", "wheel"), key=lambda path: path.suffix)
    return sdist, wheel


def python_of(version: str) -> str | None:
    """An interpreter of this version: on the path, or one that pyenv keeps."""
    kept = Path(os.environ.get("PYENV_ROOT", Path.home() / ".pyenv")) / "versions"
    for candidate in (shutil.which(f"python{version}"), *sorted(kept.glob(f"{version}.*/bin/python"))):
        ask = [str(candidate), "-c", "import sys, venv, ensurepip; print('%d.%d' % sys.version_info[:2])"]
        if candidate and subprocess.run(ask, capture_output=True, text=True, check=False).stdout.strip() == version:
            return str(candidate)
    return None


def test_the_wheel_holds_the_package_its_types_and_its_examples(distributions):
    with zipfile.ZipFile(distributions[1]) as wheel:
        names = set(wheel.namelist())
        metadata = next(wheel.read(name).decode() for name in names if name.endswith(".dist-info/METADATA"))
    sources = {path.relative_to(ROOT / "src").as_posix() for path in (ROOT / "src").rglob("*.py")}
    wanted = sources | {"vibrocap/py.typed"} | {f"vibrocap/examples/{name}" for name in EXAMPLES}
    assert wanted <= names
    assert not [name for name in names if name.startswith("tests") or "__pycache__" in name]
    assert f"\nVersion: {VERSION}\n" in metadata
    extras = re.findall(r"^Provides-Extra: (.+)$", metadata, re.MULTILINE)
    assert {"plot", "export", "sweep", "fit"} <= set(extras)


def test_the_source_distribution_makes_the_same_wheel(distributions, tmp_path):
    with tarfile.open(distributions[0]) as archive:
        archive.extraction_filter = getattr(tarfile, "data_filter", None)  # from 3.11.4 on
        archive.extractall(tmp_path)
    (sources,) = tmp_path.iterdir()
    for name in ("README.md", "LICENSE", "Makefile", "docs/index.md", "tests/test_installed.py", "requirements.lock"):
        assert (sources / name).is_file(), name
    (again,) = build(sources, tmp_path / "again", "wheel")
    with zipfile.ZipFile(distributions[1]) as one, zipfile.ZipFile(again) as other:
        assert {info.filename: info.CRC for info in one.infolist()} == {
            info.filename: info.CRC for info in other.infolist()
        }


def test_strict_type_checkers_accept_a_users_script(distributions, tmp_path):
    """Of the wheel: without its py.typed, or with a public name whose type is unknown, pyright complains."""
    pyright = shutil.which("pyright", path=str(Path(sys.executable).parent))
    if pyright is None:
        pytest.skip("pyright is not installed")
    run(sys.executable, "-m", "venv", "--without-pip", tmp_path / "venv")
    (packages,) = (tmp_path / "venv").rglob("site-packages")
    with zipfile.ZipFile(distributions[1]) as wheel:
        wheel.extractall(packages)
    own = next(Path(path) for path in sys.path if path.endswith("site-packages"))
    (packages / "dependencies.pth").write_text(f"{own}\n")
    shutil.copy(ROOT / "tests" / "user_script.py", tmp_path)
    settings = {"typeCheckingMode": "strict", "include": ["*.py"], "venvPath": ".", "venv": "venv"}
    (tmp_path / "pyrightconfig.json").write_text(json.dumps(settings))
    names = [name for name in vc.__all__ if name != "anisotropic"]
    (tmp_path / "names.py").write_text(
        "import vibrocap as vc\n\n" + "".join(f"name_{i} = vc.{name}\n" for i, name in enumerate(names))
    )
    quiet = {"PYRIGHT_PYTHON_IGNORE_WARNINGS": "1"}
    (tmp_path / "wrong.py").write_text("import vibrocap as vc\n\nvc.simulate(vc.LuGre())\nvc.no_such_name\n")
    with pytest.raises(AssertionError, match='"no_such_name" is not a known attribute') as refusal:
        run(pyright, "-p", tmp_path, cwd=tmp_path, env=quiet)
    matches = re.findall(r"^ *(\S+\.py):(\d+):\d+ - (error|warning)", str(refusal.value), re.MULTILINE)
    assert {Path(file).name for file, _, _ in matches} == {"wrong.py"}  # nothing in the others
    assert {line for _, line, kind in matches if kind == "error"} == {"3", "4"}


@pytest.mark.parametrize("versions", exhaustive_but([1], PYTHONS))
def test_a_user_installs_the_wheel_and_runs_an_example(versions, distributions, tmp_path):
    """In an empty folder: no sources, no make; the core alone, and what is missing is said."""
    python = next(filter(None, map(python_of, versions.split())), None)
    if python is None:
        pytest.skip(f"there is no Python {versions.replace(' ', ' or ')}")
    run(python, "-m", "venv", tmp_path / "venv")
    commands = tmp_path / "venv" / ("Scripts" if os.name == "nt" else "bin")
    pip = [commands / "python", "-m", "pip", "--disable-pip-version-check"]
    run(*pip, "install", "-q", "--no-compile", distributions[1])  # what is run is compiled then
    place = tmp_path / "work"
    place.mkdir()
    here = {"cwd": place, "env": {"VIBROCAP_CACHE": str(tmp_path / "cache")}}
    assert run(commands / "vibrocap", "--version", **here).strip() == VERSION
    run(commands / "vibrocap", "examples", "--to", "examples", **here)
    assert sorted(path.name for path in (place / "examples").iterdir()) == EXAMPLES
    run(commands / "vibrocap", "new", "--out", "case.toml", **here)
    for case in ("case.toml", "examples/never-leaves-stick.toml"):
        motion = json.loads(run(commands / "vibrocap", "simulate", case, "--json", "--periods", "4", **here))
        assert motion["status"] == "finished"
    asked = re.findall(r"^vibrocap (.+)$", (ROOT / "README.md").read_text(encoding="utf-8"), re.MULTILINE)
    refused = []
    for line in asked:
        if line.startswith(("lab", "orbit")):  # which take long, and nothing but the core
            continue
        result = subprocess.run(
            [str(commands / "vibrocap"), *line.split()],
            capture_output=True, text=True, check=False, cwd=place, env=CLEAN,
        )  # fmt: skip
        assert result.returncode == 2, line
        refused += re.findall(r"needs (.+); install with: .*venv.*python.* -m pip install (.+)", result.stderr)
    assert refused == [
        ("matplotlib", '"vibrocap[plot]"'),
        ("xarray and zarr", '"vibrocap[sweep]"'),
        ("xarray, zarr and matplotlib", '"vibrocap[plot,sweep]"'),
    ]
