"""Files that are meant to harm: small ones that unpack to any size, links to elsewhere, nesting without end, words that
a terminal would obey. Each is refused, or shown as what it is.
"""

import contextlib
import io
import itertools
import os
import struct
import subprocess
import sys
import threading
import zipfile
import zlib

import numpy as np
import pytest
from scipy.io import savemat

from cases import SHORT as CASE
from cases import printed, refused
from thinned import covering
from torture.waits import KINDS, PLACES
from vibrocap import inputs, working_folder
from vibrocap.case.case import CaseError, case_from_text, read_case
from vibrocap.cli.commands.plot import picture_path
from vibrocap.cli.main import main
from vibrocap.cli.sweep_request import read_cases
from vibrocap.cli.terminal import Page, table, visible
from vibrocap.records.reading import arrays, matlab, text
from vibrocap.records.reading.readers import read_records
from vibrocap.records.record import RecordError

h5py = pytest.importorskip("h5py")
SMALL = 2**20


def npy(shape, content):
    """A file of NumPy that says it is larger than it is."""
    file = io.BytesIO()
    np.lib.format.write_array_header_1_0(file, {"descr": "<f8", "fortran_order": False, "shape": shape})
    return file.getvalue() + content


def zipped(path, content, claimed=None):
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("time.npy", npy((claimed or len(content) // 8,), content))


def packed_mat(path, size):
    """A MATLAB file with one element of zeros, compressed."""
    savemat(path, {"time": np.arange(3.0)})
    packed = zlib.compress(bytes(size), 9)
    path.write_bytes(path.read_bytes()[:128] + struct.pack("<II", 15, len(packed)) + packed)


def hdf5(path, fill):
    """A MATLAB file of version 7.3."""
    with h5py.File(path, "w", userblock_size=512) as file:
        fill(file)
    with path.open("r+b") as file:
        file.write(b"MATLAB 7.3 MAT-file".ljust(124) + b"\x00\x02IM")


def looped(file):
    file.create_group("a")
    file["a/b"] = file["a"]


def linked(file):
    file["force"] = h5py.ExternalLink("/etc/passwd", "/x")


def elsewhere(file):
    file.create_dataset("force", shape=(10,), dtype="i1", external=[("/etc/passwd", 0, 10)])


@pytest.mark.parametrize(
    ("name", "make", "words"),
    [
        ("a.npz", lambda path: zipped(path, bytes(SMALL + 8)), "unpacks to more than 1 MB"),
        ("a.npz", lambda path: zipped(path, bytes(800), 10**14), "cannot be read as .npz"),
        ("a.mat", lambda path: packed_mat(path, SMALL + 8), "unpacks to more than 1 MB"),
        ("a.mat", lambda path: hdf5(path, lambda f: f.create_dataset("force", (10**12,), "f8", chunks=(10**5,))), "MB"),
        ("a.mat", lambda path: hdf5(path, looped), "should not be nested deeper than 8 structures"),
        ("a.mat", lambda path: hdf5(path, linked), "force: is a link to elsewhere"),
        ("a.mat", lambda path: hdf5(path, elsewhere), "force: should be stored in the file itself"),
        ("a.csv", lambda path: path.symlink_to("/dev/zero"), "has more than 1 MB"),
    ],
)
def test_records_that_unpack_to_any_size_or_lie_elsewhere_are_refused(tmp_path, monkeypatch, name, make, words):
    monkeypatch.setattr(arrays, "MOST_BYTES", SMALL)
    monkeypatch.setattr(text, "MOST_BYTES", SMALL)
    make(tmp_path / name)
    with pytest.raises(RecordError, match=words):
        read_records(tmp_path / name)


NESTED = "machine.kind: should be .* got dict nested too deeply|TOML: is nested too deeply"  # from Python 3.14 on


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ("[machine]\nkind." + 2000 * "a." + "b = 1", NESTED),
        ("[machine]\nkind = " + 6000 * "[" + 6000 * "]", "TOML: is nested too deeply"),
    ],
)
def test_a_case_nested_thousands_deep_is_refused(given, words):
    with pytest.raises(CaseError, match=words):
        case_from_text(given)


def test_a_case_without_end_is_refused(tmp_path):
    path = tmp_path / "case.toml"
    path.symlink_to("/dev/zero")
    with pytest.raises(CaseError, match="should be a case file of at most 16 MB"):
        read_case(path)


def test_the_picture_of_a_measure_lies_beside_its_study_whatever_the_measure_is_called(tmp_path):
    assert picture_path(tmp_path / "map", "../m[/x]") == tmp_path / "map-.._m__x_.png"


NAME = "m[/x] [red]\x1b[31m\x07\u202e:smile:"
SHOWN = "m[/x] [red]\\x1b[31m\\x07\\u202e:smile:"


def test_names_are_shown_and_not_obeyed(capsys):
    """Neither as markup nor by the terminal, in lines, tables and complaints."""
    numbers = table("title [/]", "column [/]")
    numbers.add_row(NAME)
    page = Page()
    page.print(numbers)
    page.say(NAME)
    said = capsys.readouterr().out
    assert said.count(SHOWN) == 2
    assert said.isprintable() or set(said) - {c for c in said if c.isprintable()} == {"\n"}
    assert visible("Größe µm\n\tθ") == "Größe µm\n\tθ"


def test_a_record_with_such_a_name_is_listed(tmp_path, capsys):
    lines = [f"{name},{0.01 * i},{np.sin(i)},{np.cos(i)}" for name in (NAME, "b") for i in range(200)]
    path = tmp_path / "records.csv"
    path.write_text("\n".join(("record,t,F,v", *lines)))
    assert "m[/x]" in printed(capsys, "stick-slip", path)
    assert "\x1b" not in refused(capsys, "stick-slip", path, "--record", "\x1b[2J")


# --- what would be waited for -----------------------------------------------------------------------------------------
TABLE = CASE.replace('"harmonic"', '"table"\nfile = "in.csv"')
PREFIXES = ("in.", "cases", "motion", "study.nc", "record", "example", "out.csv")
READS = {name: words for name, words in PLACES.items() if name.startswith(PREFIXES)}
posix = pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="has no pipes with names")


@pytest.fixture
def place(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(inputs, "PATIENCE", 0.05)
    (tmp_path / "case.toml").write_text(CASE)
    (tmp_path / "table.toml").write_text(TABLE)
    return tmp_path


WAITS = [*itertools.product(READS, ("pipe", "link to a pipe", "socket", "link to itself"))]


@posix
@pytest.mark.parametrize(("name", "what"), [WAITS[i] for i in covering(WAITS)])
def test_what_nobody_writes_into_is_not_waited_for(place, name, what, capsys):
    """Every place and every kind; all pairs are waited for by `python -m torture`."""
    path = place / name
    path.parent.mkdir(exist_ok=True)
    KINDS[what](path)
    code = main(READS[name])
    said = "".join(capsys.readouterr())
    assert code == 0 if name.startswith("examples") else code in (2, 3)
    assert path.stem in said
    assert "Traceback" not in said


@posix
def test_a_pipe_into_which_someone_writes_is_a_case(place):
    os.mkfifo(place / "in.toml")
    writer = threading.Thread(target=(place / "in.toml").write_text, args=(CASE,))
    writer.start()
    assert read_case(place / "in.toml").periods == 2
    writer.join()


# --- the working folder of a command ----------------------------------------------------------------------------------
def stranger(folder):
    """A folder in which everything runs that is looked for there; what it leaves when it does."""
    ran = folder / "ran"
    script = f"#!{sys.executable}\nimport os\nos.mkdir({str(ran)!r})\n"
    for name in ("ast.py", "numpy.py", "typing.py", "multiprocessing.py", "matplotlib.py", "picture.png", "ffmpeg"):
        (folder / name).write_text(script)
        (folder / name).chmod(0o755)
    (folder / "matplotlibrc").write_text("animation.ffmpeg_path: ./picture.png\nbackend: nonsense\nfont.size: 40\n")
    (folder / ".numba_config.yaml").write_text("[")
    (folder / "case.toml").write_text(CASE)
    return ran


@pytest.mark.slow
@pytest.mark.parametrize("way", [["-m", "vibrocap"], ["-P", "-m", "vibrocap"]])
def test_nothing_of_the_working_folder_runs_or_sets_anything(tmp_path, way):
    here, empty = tmp_path / "here", tmp_path / "empty"
    for folder in (here, empty):
        folder.mkdir()
        (folder / "case.toml").write_text(CASE)
    ran = stranger(here)
    for folder in (here, empty):
        words = [sys.executable, *way, "simulate", "case.toml", "--plot", "run.png"]
        environment = os.environ | {"PATH": f".{os.pathsep}{os.environ['PATH']}"}
        done = subprocess.run(words, cwd=folder, env=environment, capture_output=True, text=True, timeout=300)
        assert done.returncode == 0, done.stderr
    assert not ran.exists()
    assert (here / "run.png").read_bytes() == (empty / "run.png").read_bytes()


def test_programs_are_not_looked_for_in_the_working_folder(monkeypatch):
    monkeypatch.setattr(sys, "meta_path", list(sys.meta_path))
    for name in ("PYTHONSAFEPATH", "NODEFAULTCURRENTDIRECTORYINEXEPATH"):
        monkeypatch.setenv(name, "")
    monkeypatch.setenv("PATH", os.pathsep.join(("", ".", "bin", "/usr/bin")))
    monkeypatch.setenv("MPLCONFIGDIR", "mine")
    working_folder.leave_out()
    assert os.environ["PATH"] == "/usr/bin"
    assert os.environ["PYTHONSAFEPATH"] == "1"
    assert os.environ["MPLCONFIGDIR"] == os.path.abspath("mine")  # as the user said


@pytest.mark.parametrize(
    ("words", "given", "left_out"),
    [
        (["python", "-m", "vibrocap", "new"], ["-m"], True),
        (["python", "-m", "pytest"], ["-m"], False),
        (["python", "script.py", "vibrocap"], ["script.py", "vibrocap"], False),
    ],
)
def test_modules_of_the_working_folder_are_left_out_for_the_command(monkeypatch, tmp_path, words, given, left_out):
    if sys.flags.safe_path:
        pytest.skip("they are left out always")
    monkeypatch.setattr(sys, "orig_argv", words)
    monkeypatch.setattr(sys, "argv", given)
    monkeypatch.setattr(sys, "path", [str(tmp_path), *sys.path])
    working_folder.leave_out_its_modules()
    assert (str(tmp_path) not in sys.path) == left_out


DAMAGED = [  # read by a process of its own, whatever ends it
    "import os, signal; os.kill(os.getpid(), signal.SIGSEGV)",
    "import sys; sys.stdout.buffer.write(b'C' + (99).to_bytes(8, 'little') + b'half')",
    "raise SystemExit(0)",
]


@pytest.mark.parametrize("ends", DAMAGED)
def test_a_mat_file_that_ends_its_reader_is_refused(tmp_path, monkeypatch, ends):
    path = tmp_path / "a.mat"
    savemat(path, {"time": np.arange(9.0), "force": np.arange(9.0)})
    monkeypatch.setattr(matlab, "COMMAND", ("-c", ends))
    with pytest.raises(RecordError, match="ends the program that reads it, so it is damaged; write it anew"):
        read_records(path)


def test_a_mat_file_that_is_never_read_is_refused(tmp_path, monkeypatch):
    path = tmp_path / "a.mat"
    savemat(path, {"time": np.arange(9.0)})
    monkeypatch.setattr(matlab, "COMMAND", ("-c", "import time; time.sleep(60)"))
    monkeypatch.setattr(matlab, "LONGEST", 0.3)
    with pytest.raises(RecordError, match=r"was not read within 0.3 s"):
        read_records(path)


def test_a_mat_file_comes_back_as_scipy_reads_it(tmp_path):
    """Numbers, names and structures; by the modules of this package, whatever lies in the working folder."""
    path = tmp_path / "a.mat"
    run = {"force": np.arange(9.0), "velocity": np.arange(9.0, dtype=np.float32), "more": {"mass": 2.0}}
    savemat(
        path, {"time": np.arange(9.0), "run": run, "columns": np.array(["a", "b"]), "cells": np.array([1, "x"], object)}
    )
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(tmp_path)
        (tmp_path / "scipy.py").write_text("raise SystemExit('not this one')")
        found, again = matlab.mat_files([path, path])
    wanted = matlab.content_of(path)
    assert found.keys() == wanted.keys() == again.keys()
    for name in ("time", "columns"):
        np.testing.assert_array_equal(found[name], wanted[name])
    for name in ("force", "velocity"):
        np.testing.assert_array_equal(found["run"][name], run[name])
        assert found["run"][name].dtype == run[name].dtype
    assert found["run"]["more"]["mass"] == 2.0
    assert found["cells"] is None


@pytest.mark.parametrize("damage", ["\r", "9" * 140_000, '"', '"\n"', "\x0c"])
def test_tables_with_stray_signs_are_read_or_refused(tmp_path, damage):
    """A carriage return within a line, a cell beyond the limit of csv, a quotation mark that is not closed."""
    path = tmp_path / "a.csv"
    lines = [f"{i},{i},{i}" for i in range(12)]
    for line in ("5,5" + damage + ",5", damage + "5,5,5"):
        path.write_text("\n".join(["time,force,velocity", *lines[:5], line, *lines[6:]]), newline="")
        with contextlib.suppress(RecordError):
            read_records(path)
        path.write_text(
            "\n".join(["machine.mass_ratio,machine.damping,drive.amplitude", *lines[1:5], line]), newline=""
        )
        with contextlib.suppress(CaseError):
            read_cases(path)
