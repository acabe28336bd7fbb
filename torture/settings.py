"""A stranger's folder as the working folder: nothing in it runs, and no result is another than in an empty one.

Settings of every library that reads some where a command is begun, modules of Python with the names of those that are
imported, programs with the names of those that are looked for, and packages that announce themselves to libraries.
"""

import os
import random
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

from torture.children import patience, tree
from torture.full_disk import CASE
from torture.outcome import Outcome

MODULES = (  # but for those few that `python -m` imports before it finds the package: importlib, warnings
    *("ast", "asyncio", "copyreg", "csv", "ctypes", "dataclasses", "gc", "json", "logging", "multiprocessing"),
    *("pathlib", "random", "re", "signal", "socket", "sitecustomize", "tempfile", "tomllib", "typing", "usercustomize"),
    *("cyclopts", "dask", "distributed", "h5netcdf", "h5py", "llvmlite", "matplotlib", "numba", "numcodecs", "numpy"),
    *("pandas", "PIL", "pydantic", "rich", "scipy", "xarray", "zarr", "mylaws", "conftest"),
)
PROGRAMS = ("ffmpeg", "fc-list", "gs", "latex", "uname", "python", "python3", "cc", "xdg-open", "lscpu")
MATPLOTLIBRC = """animation.ffmpeg_path: ./picture.png
animation.convert_path: ./picture.png
backend: module://stranger
figure.facecolor: red
font.size: 40
lines.linewidth: 9
savefig.bbox: tight
text.usetex: True
axes.unicode_minus: nonsense
"""
YAML = "plugin: stranger\ncodec_pipeline:\n  path: stranger.It\ndistributed:\n  client:\n    preload: [stranger.py]\n"
RUNS = "#!{python}\nimport pathlib\npathlib.Path({ran!r}).write_text({name!r})\n"


def planted(kind: str) -> Callable[[Path], object]:
    """What a stranger's folder holds: a function that puts it into a folder."""
    return globals()[f"_{kind}"]


# --- folders of strangers, each by its name ---------------------------------------------------------------------------
def _matplotlibrc(folder: Path) -> None:
    (folder / "matplotlibrc").write_text(MATPLOTLIBRC)


def _matplotlibrc_of_bytes(folder: Path) -> None:
    (folder / "matplotlibrc").write_bytes(bytes(range(256)))


def _matplotlibrc_a_pipe(folder: Path) -> None:
    os.mkfifo(folder / "matplotlibrc")


def _modules(folder: Path) -> None:
    for name in (*MODULES, "stranger"):
        (folder / f"{name}.py").write_text(runs(folder, name))


def _programs(folder: Path) -> None:
    for name in PROGRAMS:
        (folder / name).write_text(runs(folder, name))
        (folder / name).chmod(0o755)


def _settings_of_others(folder: Path) -> None:
    """Of Dask, Zarr, Numba, Jupyter, pip, fontconfig and whatever reads such files."""
    for name in ("dask", "distributed", "zarr", ".numba_config"):
        (folder / f"{name}.yaml").write_text(YAML)
    for name in (".config/dask", ".dask", "dask", ".zarr", "zarr", ".config/matplotlib", "jupyter"):
        (folder / name).mkdir(parents=True)
        (folder / name / "settings.yaml").write_text(YAML)
        (folder / name / "matplotlibrc").write_text(MATPLOTLIBRC)
    (folder / ".env").write_text("PYTHONSTARTUP=stranger.py\nMATPLOTLIBRC=matplotlibrc\nHDF5_PLUGIN_PATH=.\n")
    (folder / "fonts.conf").write_text("<fontconfig><dir>.</dir></fontconfig>")
    (folder / "pyproject.toml").write_text("[tool.vibrocap]\nparts = ['stranger.py']\nperiods = 9\n")
    for name in (
        "vibrocap.toml",
        "setup.cfg",
        "numpy.cfg",
        "jupyter_config.py",
        ".pdbrc",
        "default_en.txt",
    ):
        (folder / name).write_text("periods = 9\n")
    (folder / "libh5plugin.so").write_bytes(b"\x7fELF")


def _packages_that_announce_themselves(folder: Path) -> None:
    """To libraries that import what is registered for them."""
    place = folder / "stranger-1.dist-info"
    place.mkdir()
    (place / "METADATA").write_text("Metadata-Version: 2.1\nName: stranger\nVersion: 1\n")
    groups = ("xarray.backends", "xarray.chunkmanagers", "zarr.codecs", "zarr.codec_pipeline", "dask.sizeof")
    groups += ("distributed.comm.backends", "pydantic", "matplotlib.backend", "numba_extensions", "numcodecs.codecs")
    (place / "entry_points.txt").write_text("".join(f"[{group}]\nstranger = stranger:it\n" for group in groups))
    (folder / "stranger.py").write_text(runs(folder, "stranger"))


# --- what is done in them ---------------------------------------------------------------------------------------------
KINDS = ("matplotlibrc", "matplotlibrc_of_bytes", "matplotlibrc_a_pipe", "modules", "programs", "settings_of_others")
KINDS += ("packages_that_announce_themselves",)
COMMANDS = {  # words, and what they write
    "plot": ("simulate", "case.toml", "--plot", "run.png", "--out", "run.nc"),
    "film": ("simulate", "case.toml", "--animate", "run.gif"),
    "sweep": ("sweep", "case.toml", "--over", "machine.mass_ratio=1:2:4", "--workers", "1", "--out", "map",
              "--export", "map.nc"),
}  # fmt: skip
WAYS = {"vibrocap": [str(Path(sys.executable).with_name("vibrocap"))], "python -m": [sys.executable, "-m", "vibrocap"]}


def runs(folder: Path, name: str) -> str:
    """A script that leaves a trace."""
    return RUNS.format(python=sys.executable, ran=str(folder / "ran"), name=name)


def done(folder: Path, way: str, words: tuple[str, ...]) -> tuple[int, str]:
    """(exit code, what was said) of a command in a folder, whose dots in the search path lead there."""
    environment = os.environ | {"PATH": f".{os.pathsep}{os.environ['PATH']}"}
    try:
        ended = subprocess.run(
            [*WAYS[way], *words], cwd=folder, env=environment, capture_output=True, timeout=patience(150.0)
        )
    except subprocess.TimeoutExpired:
        return 124, "hung"
    return ended.returncode, (ended.stdout + ended.stderr).decode(errors="replace")


def settings(folder: Path, trials: int, seed: int) -> Outcome:
    """So many of all folders, commands and ways to begin them, by chance."""
    outcome, chance = Outcome("settings"), random.Random(seed)
    every = [(kind, command, way) for kind in KINDS for command in COMMANDS for way in WAYS]
    pristine = {}
    for kind, command, way in chance.sample(every, min(trials, len(every))):
        if command not in pristine:
            pristine[command] = made(folder / f"empty {command}", "vibrocap", command, None)
        place = folder / f"{kind} {command} {way}"
        found = made(place, way, command, kind)
        ran = (place / "ran").read_text() if (place / "ran").exists() else ""
        fault = f"{ran} was run" if ran else "" if found == pristine[command] else f"other results: {str(found)[:400]}"
        outcome.check(not fault, f"{kind}, {command} by {way}: {fault}")
    outcome.words = f"of {len(every)} folders, commands and ways"
    return outcome


def made(folder: Path, way: str, command: str, kind: str | None) -> object:
    """The files that a command makes in such a folder, or what it said instead."""
    folder.mkdir(exist_ok=True)
    (folder / "case.toml").write_text(CASE)
    if kind is not None:
        planted(kind)(folder)
    code, words = done(folder, way, COMMANDS[command])
    if code:
        return words[-400:]
    return {name: data for name, data in tree(folder).items() if name.startswith(("run.", "map"))}
