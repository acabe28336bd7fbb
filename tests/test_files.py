"""Files are written whole or not at all, and an error of the file system says which file and why."""

import errno
import os
import shutil
import stat
import subprocess
import sys
import time

import pytest

from cases import SHORT as CASE
from cases import refused
from interrupts import heard
from vibrocap import files
from vibrocap.cli.main import main
from vibrocap.files import WriteError, made_folder, replacing, write_table, write_text

try:
    import resource
except ImportError:  # Windows
    resource = None


def names(folder):
    return sorted(path.name for path in folder.iterdir())


def test_a_file_is_replaced_at_the_end_and_not_before(tmp_path):
    path = write_text(tmp_path / "run.csv", "old\n")
    with replacing(path) as temporary:
        temporary.write_text("new\n")
        assert temporary.parent == path.parent
        assert temporary.suffix == path.suffix
        assert path.read_text() == "old\n"
    assert path.read_text() == "new\n"
    assert names(tmp_path) == ["run.csv"]


def _half_written(path, fault):
    with replacing(path) as temporary:
        temporary.write_text("half")
        raise fault


@pytest.mark.parametrize("fault", [OSError(errno.ENOSPC, "No space left on device"), KeyboardInterrupt(), KeyError()])
def test_what_ends_the_writing_leaves_the_old_file_alone(tmp_path, fault):
    path = write_text(tmp_path / "run.csv", "old\n")
    with pytest.raises(WriteError if isinstance(fault, OSError) else type(fault)):
        _half_written(path, fault)
    assert path.read_text() == "old\n"
    assert names(tmp_path) == ["run.csv"]


@pytest.mark.parametrize("call", ["fsync", "replace", "open"])
def test_an_error_of_the_file_system_names_the_file_and_the_reason(tmp_path, monkeypatch, call):
    def full(*arguments):
        raise OSError(errno.ENOSPC, "No space left on device", "elsewhere")

    monkeypatch.setattr(files.os, call, full)
    with pytest.raises(WriteError, match=r"run\.csv: cannot be written: No space left on device.*nothing was written"):
        write_text(tmp_path / "run.csv", "new")
    assert names(tmp_path) == []


def test_a_file_in_its_place_is_no_failure_though_its_name_cannot_be_forced(tmp_path, monkeypatch):
    def full_from_the_second_on(handle, calls=[]):  # noqa: B006
        calls.append(handle)
        if len(calls) > 1:
            raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(files.os, "fsync", full_from_the_second_on)
    assert write_text(tmp_path / "run.csv", "new").read_text() == "new"


def test_the_content_is_on_the_disk_before_the_name(tmp_path, monkeypatch):
    calls = []
    for name in ("fsync", "replace"):
        true = getattr(os, name)
        monkeypatch.setattr(files.os, name, lambda *given, n=name, true=true: (calls.append(n), true(*given))[1])
    write_text(tmp_path / "run.csv", "new")
    assert calls[:2] == ["fsync", "replace"]


def test_bytes_of_a_name_that_are_not_utf8_are_written_as_escapes(tmp_path):
    """Python holds them as half characters, which UTF-8 refuses."""
    write_text(tmp_path / "a.html", "c\udcff.toml")
    write_table(tmp_path / "a.csv", ["c\udcff"], [["d\udcfe"]])
    assert (tmp_path / "a.html").read_bytes() == rb"c\udcff.toml"
    assert (tmp_path / "a.csv").read_bytes() == b"c\\udcff\nd\\udcfe\n"


def test_rights_stay(tmp_path):
    path = tmp_path / "run.csv"
    path.write_text("old")
    path.chmod(0o640)
    assert write_text(path, "new").read_text() == "new"
    assert stat.S_IMODE(path.stat().st_mode) == 0o640


@pytest.mark.parametrize("there", [True, False])
def test_links_are_not_followed(tmp_path, capsys, there):
    """To a file, or to none; by the library, and by a command before any work."""
    path, link = tmp_path / "mine.csv", tmp_path / "link.csv"
    if there:
        path.write_text("old")
    link.symlink_to(path)
    with pytest.raises(WriteError, match=r"link\.csv: cannot be written: it is a link to .*mine\.csv"):
        write_text(link, "new")
    (tmp_path / "case.toml").write_text(CASE)
    assert "it is a link to" in refused(capsys, "simulate", tmp_path / "case.toml", "--out", link)
    assert path.exists() == there
    assert not there or path.read_text() == "old"
    assert link.is_symlink()
    (tmp_path / "elsewhere").mkdir()
    (tmp_path / "figures").symlink_to(tmp_path / "elsewhere")
    with pytest.raises(WriteError, match="figures: this folder cannot be made: it is a link to"):
        made_folder(tmp_path / "figures", own=True)


def test_a_pipe_from_which_nobody_reads_is_refused(tmp_path):
    os.mkfifo(tmp_path / "run.csv")
    with pytest.raises(WriteError, match=r"run\.csv: cannot be written: No such device or address"):
        write_text(tmp_path / "run.csv", "new")


def test_a_command_does_not_write_over_what_it_reads(tmp_path, capsys):
    case, same = tmp_path / "case.toml", tmp_path / "same.toml"
    case.write_text(CASE)
    os.link(case, same)
    for name in (case, same):
        assert main(["new", "--from", str(case), "--to", "dimensionless", "--out", str(name)]) == 2
        assert "it is read by this command" in capsys.readouterr().err
    assert case.read_text() == CASE
    assert write_text(case, CASE)  # a user of the package may


# what stands in the folder of an earlier run, where the command writes it: (the name, the command on it)
CONTINUED = {
    "optimise": ("best.toml", "--over", "drive.frequency=0.5:3"),
    "optimise front": ("cases/003.toml", "--over", "drive.frequency=0.5:3", "--against", "drift"),
    "calibrate": ("calibrated.toml", "--to", "rows.csv", "--over", "machine.damping=0.5:2"),
}


@pytest.mark.parametrize("what", CONTINUED)
def test_a_folder_is_refused_before_work_where_the_case_would_be_replaced(tmp_path, capsys, what):
    name, *options = CONTINUED[what]
    if "--against" in options:
        pytest.importorskip("pymoo")
    case = tmp_path / name
    case.parent.mkdir(exist_ok=True)
    case.write_text(CASE)
    assert main([what.split()[0], str(case), *options, "--out", str(tmp_path)]) == 2
    assert f"--out: {str(case)!r} cannot be written: it is read by this command" in capsys.readouterr().err
    assert names(case.parent) == [case.name]


def test_a_run_is_not_written_over_the_motion_that_it_is_read_from(tmp_path, capsys):
    pytest.importorskip("xarray")
    (tmp_path / "case.toml").write_text(CASE)
    run = str(tmp_path / "run.nc")
    assert main(["simulate", str(tmp_path / "case.toml"), "--out", run]) == 0
    assert main(["simulate", run, "--out", run]) == 2
    assert "--out: " in capsys.readouterr().err


def test_what_is_no_file_is_written_to_and_not_replaced(tmp_path):
    link = tmp_path / "full.csv"
    link.symlink_to("/dev/full")
    with pytest.raises(WriteError, match=r"full\.csv: cannot be written: No space left on device"):
        write_text(link, "new")
    assert stat.S_ISCHR(os.stat("/dev/full").st_mode)


def test_what_dead_processes_left_goes_with_the_next_writing(tmp_path):
    old, young = tmp_path / f".run-{1:012}{files.PART}.csv", tmp_path / f".run-{2:012}{files.PART}.csv"
    others = [tmp_path / f".run-notes{files.PART}ial.csv", tmp_path / f".run-{3:012}{files.PART}.nc"]
    for path in (old, young, *others):
        path.write_text("half")
    then = time.time() - 2 * files.ABANDONED
    for path in (old, *others):
        os.utime(path, (then, then))
    write_text(tmp_path / "run.csv", "new")
    assert names(tmp_path) == sorted([young.name, *(path.name for path in others), "run.csv"])


def test_a_missing_folder_and_one_that_cannot_be_made_are_named(tmp_path):
    with pytest.raises(WriteError, match=r"there is no folder .*missing"):
        write_text(tmp_path / "missing" / "run.csv", "new")
    write_text(tmp_path / "file", "")
    with pytest.raises(WriteError, match="file/below: this folder cannot be made"):
        made_folder(tmp_path / "file" / "below")
    with pytest.raises(WriteError, match="Is a directory"):
        write_text(tmp_path, "new")


# --- the command line ------------------------------------------------------------------------------------------------
@pytest.mark.skipif(resource is None, reason="this system limits no sizes of files")
@pytest.mark.parametrize(
    ("option", "name", "size"),
    [
        ("--out", "run.nc", 8000),
        ("--out", "run.csv", 20_000),
        ("--plot", "run.png", 30_000),
        pytest.param("--plot", "run.svg", 30_000, marks=pytest.mark.slow),
        pytest.param("--animate", "run.gif", 30_000, marks=pytest.mark.exhaustive),
        pytest.param("--animate", "run.mp4", 3000, marks=pytest.mark.exhaustive),
    ],
)
def test_a_full_disk_ends_with_code_3_and_leaves_the_old_file(tmp_path, monkeypatch, capfd, option, name, size):
    """A limit on the size of files stands for the full disk."""
    monkeypatch.setattr(sys, "dont_write_bytecode", True)  # Python would keep half of a module that it loads
    if name.endswith(".mp4") and shutil.which("ffmpeg") is None:
        pytest.skip("needs ffmpeg")
    case, path = tmp_path / "case.toml", tmp_path / name
    case.write_text(CASE)
    path.write_text("old")
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, before[1]))
    try:
        code = main(["simulate", str(case), option, str(path)])
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
    said = capfd.readouterr().err
    assert code == 3
    assert f"{path}: cannot be written: " in said
    assert "the file that is there is as before" in said
    assert path.read_text() == "old"
    assert names(tmp_path) == sorted(["case.toml", name])


@pytest.mark.slow
def test_a_full_standard_output_ends_with_code_3():
    """And not with a traceback when Python ends."""
    code = "import sys; from vibrocap.cli.main import main; sys.exit(main(['list', 'measures']))"
    with open("/dev/full", "w") as full:
        result = subprocess.run(
            [sys.executable, "-c", code], stdout=full, stderr=subprocess.PIPE, text=True, timeout=60
        )
    assert result.returncode == 3
    assert result.stderr == "standard output: No space left on device\n"


# --- interrupts ------------------------------------------------------------------------------------------------------
DURING_IMPORTS = """
class Interrupts:
    def find_spec(self, name, *given):
        if name == "vibrocap.cli.main":
            os.kill(os.getpid(), signal.SIGINT)
sys.meta_path.insert(0, Interrupts())
"""
TWICE = """
import types
def main():
    try:
        os.kill(os.getpid(), signal.SIGINT)
        time.sleep(30)
    except KeyboardInterrupt:
        print("in order", flush=True)
        os.kill(os.getpid(), signal.SIGINT)
        time.sleep(30)
sys.modules["vibrocap.cli.main"] = types.SimpleNamespace(main=main)
"""


@pytest.mark.parametrize(("what", "said"), [(DURING_IMPORTS, ""), (TWICE, "in order\n")])
def test_an_interrupt_during_imports_and_a_second_one_end_at_once(what, said):
    begin = "import os, signal, sys, time\nsys.argv.append('list')\nfrom vibrocap.__main__ import run\n"
    with heard():
        code = begin + what + "sys.exit(run())"
        result = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60)
    assert (result.returncode, result.stdout, result.stderr) == (130, said, "Interrupted.\n")
