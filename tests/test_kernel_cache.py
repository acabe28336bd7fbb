"""Object files on disk: nothing that others can have written is run, what is damaged is a miss and mends itself."""

import hashlib
import os
import stat
import subprocess
import sys
import time
import warnings

import numpy as np
import pytest

from vibrocap.numerics import compiler
from vibrocap.numerics.compiler import __name__ as compiler_name
from vibrocap.numerics.compiler import cache, compiled

TEXT = "def advance(floats, ints, trace, rounds):\n    trace[0] = floats[0] + 41.5\n"
posix = pytest.mark.skipif(not hasattr(os, "geteuid"), reason="rights are kept in another way here")


def forget():
    """As in a new process."""
    cache.folder.cache_clear()
    cache._temporary_folder.cache_clear()
    sys.modules[compiler_name]._compiled.cache_clear()


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A cache of its own."""
    path = tmp_path / "cache"
    monkeypatch.setenv("VIBROCAP_CACHE", str(path))
    forget()
    yield path
    forget()


def answer():
    """What the kernel gives, compiled or loaded as in a new process."""
    sys.modules[compiler_name]._compiled.cache_clear()
    trace = np.zeros(1)
    compiled(TEXT, "advance")(np.ones(1), np.zeros(1, dtype=np.int64), trace, 0)
    return trace[0]


def files(folder):
    return sorted(path for path in folder.iterdir() if path.suffix == ".kernel")


def counting(monkeypatch):
    """How often machine code has been made."""
    values = []
    module = sys.modules[compiler_name]
    original = module.object_code
    monkeypatch.setattr(module, "object_code", lambda *arguments: values.append(1) or original(*arguments))
    return values


def test_a_kernel_is_made_once_and_kept_in_a_private_folder(folder, monkeypatch):
    made = counting(monkeypatch)
    assert [answer(), answer()] == [42.5, 42.5]
    assert len(made) == 1
    assert len(files(folder)) == 1
    assert not [path for path in folder.iterdir() if path.suffix == ".tmp"]
    if hasattr(os, "geteuid"):
        assert stat.S_IMODE(folder.stat().st_mode) == 0o700
        assert stat.S_IMODE(files(folder)[0].stat().st_mode) == 0o600


def test_what_decides_the_code_is_in_the_name(folder, monkeypatch):
    """Another text, another processor, another compiler."""
    module = sys.modules[compiler_name]
    answer()
    compiled(TEXT.replace("41.5", "41.25"), "advance")
    assert len(files(folder)) == 2
    monkeypatch.setattr(module, "own_source", lambda: "another compiler")
    answer()
    assert len(files(folder)) == 3


def damage(content, name):
    if name == "empty":
        return b""
    if name == "cut":
        return content[:-7]
    if name == "head only":
        return content[:40]
    if name == "foreign":
        return b"something else altogether" * 100
    flipped = bytearray(content)
    flipped[{"head": 3, "hash": 30, "code": len(content) // 2, "end": len(content) - 1}[name]] ^= 1
    return bytes(flipped)


@pytest.mark.parametrize("name", ["empty", "cut", "head only", "foreign", "head", "hash", "code", "end"])
def test_a_damaged_file_is_a_miss_and_is_written_anew(folder, name, monkeypatch):
    answer()
    (path,) = files(folder)
    ints = path.read_bytes()
    path.write_bytes(damage(ints, name))
    made = counting(monkeypatch)
    assert answer() == 42.5
    assert len(made) == 1
    assert path.read_bytes() == ints


def test_an_edited_file_with_a_hash_of_its_own_does_not_pass_for_another_kernel(folder, monkeypatch):
    """A whole file of one kernel under the name of another: its hash covers the name."""
    answer()
    (path,) = files(folder)
    compiled(TEXT.replace("41.5", "1.5"), "advance")
    (other,) = set(files(folder)) - {path}
    path.write_bytes(other.read_bytes())
    assert answer() == 42.5
    code = b"not the code"
    other.write_bytes(cache.HEAD + hashlib.sha256(code).digest() + code)
    assert cache.kept(other.stem) is None


@posix
@pytest.mark.parametrize("mode", [0o770, 0o707, 0o777])
def test_a_folder_that_others_can_write_is_not_used(folder, mode, monkeypatch):
    answer()
    forget()
    folder.chmod(mode)
    made = counting(monkeypatch)
    with pytest.warns(RuntimeWarning, match=r"kernels are not kept in .*can be written by others.*chmod go-w"):
        assert answer() == 42.5
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert answer() == 42.5  # said once; kept for this process
    assert len(made) == 1
    assert cache.folder() != folder
    assert stat.S_IMODE(cache.folder().stat().st_mode) == 0o700
    assert len(files(folder)) == 1


@posix
def test_a_folder_of_another_user_is_not_used(folder, monkeypatch):
    folder.mkdir(mode=0o700)
    own = os.geteuid()
    monkeypatch.setattr(os, "geteuid", lambda: own + 1)
    with pytest.warns(RuntimeWarning, match=f"belongs to user {own}"):
        assert cache.folder() != folder


@posix
def test_links_are_not_followed(folder, tmp_path):
    """Neither in the place of the folder, nor of a file, nor of the lock, whose target stays as it is."""
    answer()
    (path,) = files(folder)
    elsewhere = tmp_path / "elsewhere.kernel"
    elsewhere.write_bytes(path.read_bytes())
    path.unlink()
    path.symlink_to(elsewhere)
    assert cache.kept(path.stem) is None
    assert answer() == 42.5
    assert not path.is_symlink()  # written anew, in the place of the link
    precious = tmp_path / "precious"
    precious.write_text("as it was")
    for lock in folder.glob(".lock-*"):
        lock.unlink()
        lock.symlink_to(precious)
    path.unlink()
    assert answer() == 42.5
    assert precious.read_text() == "as it was"
    forget()
    (tmp_path / "link").symlink_to(folder)
    os.environ["VIBROCAP_CACHE"] = str(tmp_path / "link")
    with pytest.warns(RuntimeWarning, match="is a symbolic link"):
        assert cache.folder() not in (folder, tmp_path / "link")


@posix
def test_a_file_that_others_can_write_is_not_used(folder):
    answer()
    (path,) = files(folder)
    path.chmod(0o666)
    assert cache.kept(path.stem) is None
    assert answer() == 42.5
    assert stat.S_IMODE(path.stat().st_mode) == 0o600


@posix
def test_a_filled_cache_that_cannot_be_written_is_used(folder, monkeypatch):
    answer()
    made = counting(monkeypatch)
    forget()
    folder.chmod(0o500)
    try:
        assert answer() == 42.5
        assert made == []

        def refused(*_, **__):
            raise PermissionError

        # Whoever may do everything is not kept from it by the rights of a folder.
        floats = os.open

        def opened(path, flags, *more):
            return (refused if flags & os.O_CREAT else floats)(path, flags, *more)

        monkeypatch.setattr(os, "open", opened)
        compiled(TEXT.replace("41.5", "7.5"), "advance")  # made, and not kept
        assert len(made) == 1
    finally:
        monkeypatch.undo()
        folder.chmod(0o700)
    assert len(files(folder)) == 1


def test_a_full_disk_leaves_no_half_file(folder, monkeypatch):
    folder.mkdir(mode=0o700)

    def full(_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    assert answer() == 42.5
    assert [path for path in folder.iterdir() if not path.name.startswith(".lock")] == []


def test_beyond_its_limit_what_was_used_longest_ago_goes(folder, monkeypatch):
    folder.mkdir(mode=0o700)
    monkeypatch.setattr(cache, "LIMIT", 3500)
    for i in range(3):
        cache.keep(f"{i:040}", bytes(1000))
        os.utime(folder / f"{i:040}.kernel", (1000.0 + i, 1000.0 + i))
    left = folder / f".{0:040}.{0:016}.tmp"
    others = [folder / ".notes.tmp", folder / "popcorn.kernel"]  # of the user, whose folder it is
    for path in (left, *others):
        path.write_bytes(b"of a process that died")
        os.utime(path, (1000.0, 1000.0))
    assert cache.kept(f"{0:040}") == bytes(1000)  # used just now
    cache.keep(f"{3:040}", bytes(1000))
    assert [path.stem[-1] for path in files(folder)] == ["0", "2", "3", "n"]
    assert not left.exists()
    assert all(path.exists() for path in others)
    assert time.time() - files(folder)[0].stat().st_mtime < 100.0


@posix
def test_without_a_home_kernels_are_kept_for_the_process(folder, monkeypatch, tmp_path):
    for name in ("VIBROCAP_CACHE", "XDG_CACHE_HOME", "HOME"):
        monkeypatch.delenv(name, raising=False)

    def nobody(_):
        raise KeyError("uid not found")

    import pwd

    monkeypatch.setattr(pwd, "getpwuid", nobody)
    forget()
    assert answer() == 42.5
    assert cache.folder() == cache._temporary_folder()
    forget()
    monkeypatch.setenv("HOME", str(tmp_path / "no" / "such"))
    monkeypatch.setenv("XDG_CACHE_HOME", "/proc/nowhere")  # cannot be made
    assert cache.folder() == cache._temporary_folder()


def test_the_users_cache_folder_is_the_default(monkeypatch, tmp_path):
    monkeypatch.delenv("VIBROCAP_CACHE", raising=False)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    forget()
    assert cache.folder() == tmp_path / "vibrocap"
    forget()


@pytest.mark.slow
def test_two_processes_at_once_make_a_kernel_once(folder):
    """The second waits for the first, and takes what it has made."""
    script = f"""
import sys
import numpy as np
import vibrocap.numerics.compiler as compiler
made = compiler.object_code
compiler.object_code = lambda *a: print("made", flush=True) or __import__("time").sleep(1.0) or made(*a)
trace = np.zeros(1)
compiler.compiled({TEXT!r}, "advance")(np.ones(1), np.zeros(1, dtype=np.int64), trace, 0)
print(trace[0])
"""
    both = [
        subprocess.Popen([sys.executable, "-c", script], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        for _ in range(2)
    ]
    outputs = [process.communicate(timeout=60) for process in both]
    assert sorted(out for out, _ in outputs) == ["42.5\n", "made\n42.5\n"], outputs
    assert len(files(folder)) == 1


@posix
def test_a_pipe_in_the_place_of_a_kernel_or_its_lock_is_not_waited_for(folder):
    folder.mkdir(mode=0o700)
    name = f"{0:040}"
    os.mkfifo(folder / f"{name}.kernel", 0o600)
    os.mkfifo(folder / ".lock-0", 0o600)
    with cache.one_process_at_a_time(name):
        assert cache.kept(name) is None
        cache.keep(name, b"code")
    assert cache.kept(name) == b"code"


@posix
def test_the_lock_of_a_process_that_does_nothing_is_waited_for_a_while(folder, monkeypatch):
    """Of this one, by another handle; where it is stopped the wait is shorter, and either way its number is said."""
    import fcntl

    folder.mkdir(mode=0o700)
    monkeypatch.setattr(cache, "PATIENCE", 0.05)
    handle = os.open(folder / ".lock-0", os.O_RDWR | os.O_CREAT, 0o600)
    fcntl.flock(handle, fcntl.LOCK_EX)
    text = rf"process {os.getpid()} .*has kept its lock" if sys.platform == "linux" else "has kept its lock"
    with pytest.warns(RuntimeWarning, match=text), cache.one_process_at_a_time(f"{0:040}"):
        pass
    monkeypatch.setattr(cache, "PATIENCE", 60.0)
    monkeypatch.setattr(cache, "STOPPED", 0.05)
    monkeypatch.setattr(cache.locks, "is_stopped", lambda process: True)
    with pytest.warns(RuntimeWarning, match="which is stopped"), cache.one_process_at_a_time(f"{0:040}"):
        pass
    os.close(handle)


@posix
@pytest.mark.parametrize("code", [b"", b"no object", bytes(50)])
def test_a_whole_file_that_is_no_object_is_made_anew(folder, code):
    folder.mkdir(mode=0o700)
    compiler._compiled.cache_clear()
    name = compiler._name(TEXT, "advance", False)
    cache.keep(name, code)
    assert cache.kept(name) == code
    assert compiler.compiled(TEXT, "advance") is not None
    assert len(cache.kept(name)) > 100
    compiler._compiled.cache_clear()
