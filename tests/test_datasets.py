"""Fetching published originals: checksums known, recorded or wrong, no network, files that are something else."""

import contextlib
import dataclasses
import functools
import hashlib
import http.server
import io
import logging
import socket
import threading
import zipfile
from typing import ClassVar

import numpy as np
import pytest
from scipy.io import savemat

from cases import printed, refused
from published_data import published_folder
from vibrocap.cli.main import main
from vibrocap.cli.terminal import INCOMPLETE, OK, WRONG_INPUT
from vibrocap.records import published
from vibrocap.records.published import DATA_SETS, SUMS, DataSet, FetchError, Original, fetch

pytest.importorskip("pooch")

TIME = np.arange(2000) / 1000.0
TEXT = "Time(s)\tDispl(microns)\tFriction\tNormal_stress(MPa)\n" + "".join(
    f"{t:.3f}\t{5 * t:.4f}\t{0.6 + 0.01 * np.sin(t):.6f}\t20.0\n" for t in TIME
)


class Quiet(http.server.SimpleHTTPRequestHandler):
    """A server of files that keeps its log to itself."""

    asked: ClassVar[list[str]] = []

    def log_message(self, *arguments):
        self.asked.append(self.path)


@pytest.fixture
def server(tmp_path):
    """(folder that is served on this machine, its address); pooch says nothing."""
    folder = tmp_path / "served"
    folder.mkdir()
    Quiet.asked.clear()
    handler = functools.partial(Quiet, directory=str(folder))
    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler) as running:
        thread = threading.Thread(target=running.serve_forever, kwargs={"poll_interval": 0.01})
        thread.start()
        yield folder, f"http://127.0.0.1:{running.server_port}"
        running.shutdown()
        thread.join()


@pytest.fixture
def basalt(server):
    """The basalt set with a made file on the local server."""
    folder, address = server
    (folder / "basalt.txt").write_text(TEXT)
    original = Original(f"{address}/basalt.txt", "basalt.txt")
    return dataclasses.replace(DATA_SETS["basalt-velocity-step"], originals=(original,))


def with_sum(data_set: DataSet, digest: str) -> DataSet:
    return dataclasses.replace(data_set, originals=(dataclasses.replace(data_set.originals[0], sha256=digest),))


def test_without_a_home_folder_data_sets_are_looked_for_here(monkeypatch, capsys):
    def homeless():
        raise RuntimeError("Could not determine home directory.")

    monkeypatch.delenv("VIBROCAP_DATA", raising=False)
    monkeypatch.delenv("XDG_CACHE_HOME", raising=False)
    monkeypatch.setattr("pathlib.Path.home", homeless)
    assert "emps" in printed(capsys, "list", "datasets")


def test_a_known_checksum_is_checked(basalt, tmp_path):
    came = fetch(with_sum(basalt, hashlib.sha256(TEXT.encode()).hexdigest()), tmp_path)
    assert (came.known, came.recorded, came.first) == (1, 0, 0)
    assert came.folder == tmp_path / "basalt-velocity-step"
    assert len(came.records[0]) == len(TIME)
    assert not (came.folder / SUMS).exists()


def test_a_wrong_checksum_is_refused_and_nothing_is_kept(basalt, tmp_path):
    with pytest.raises(FetchError, match="its checksum is not the published file's"):
        fetch(with_sum(basalt, 64 * "0"), tmp_path)
    assert list((tmp_path / "basalt-velocity-step").iterdir()) == []


def test_trust_on_first_use(basalt, server, tmp_path):
    shares = []
    came = fetch(basalt, tmp_path, shares.append)
    assert (came.known, came.recorded, came.first) == (0, 0, 1)
    assert shares == [1.0]
    digest = hashlib.sha256(TEXT.encode()).hexdigest()
    assert (came.folder / SUMS).read_text() == f"{digest}  basalt.txt\n"
    assert len(Quiet.asked) == 1
    assert fetch(basalt, tmp_path).recorded == 1
    assert len(Quiet.asked) == 1  # nothing is fetched twice
    (came.folder / "basalt.txt").write_text(TEXT[:-30])  # damaged here: fetched again, and the same
    assert fetch(basalt, tmp_path).recorded == 1
    assert (came.folder / "basalt.txt").read_text() == TEXT
    (server[0] / "basalt.txt").write_text(TEXT + "3.0\t15.0\t0.6\t20.0\n")
    (came.folder / "basalt.txt").unlink()
    with pytest.raises(FetchError, match=r"of an earlier fetch.*If the authors changed the file, delete"):
        fetch(basalt, tmp_path)


def test_what_cannot_be_read_is_refused(basalt, server, tmp_path):
    (server[0] / "basalt.txt").write_text("<html>moved</html>")
    with pytest.raises(FetchError, match="cannot be read as records"):
        fetch(basalt, tmp_path)


def test_archives_are_unpacked(server, tmp_path):
    folder, address = server
    data = io.BytesIO()
    columns = {"t": TIME, "qm": np.sin(TIME), "qg": np.sin(TIME), "vir": np.cos(TIME), "gtau": 35.0}
    savemat(data, columns)
    with zipfile.ZipFile(folder / "EMPS.zip", "w") as archive:
        for name in ("DATA_EMPS.mat", "DATA_EMPS_PULSES.mat"):
            archive.writestr(f"EMPS/{name}", data.getvalue())
    original = dataclasses.replace(DATA_SETS["emps"].originals[0], url=f"{address}/EMPS.zip")
    emps = dataclasses.replace(DATA_SETS["emps"], originals=(original,))
    assert [record.name for record in fetch(emps, tmp_path / "a").records] == ["EMPS", "EMPS_PULSES"]
    with zipfile.ZipFile(folder / "EMPS.zip", "w") as archive:
        archive.writestr("DATA_EMPS.mat", data.getvalue())
    with pytest.raises(FetchError, match=r"EMPS.zip holds no DATA_EMPS_PULSES.mat; delete"):
        fetch(emps, tmp_path / "b")
    (folder / "EMPS.zip").write_text("<html>Too many downloads</html>")
    with pytest.raises(FetchError, match="the download is no zip archive"):
        fetch(emps, tmp_path / "c")


def test_the_known_checksum_is_that_of_the_basalt_here():
    (original,) = DATA_SETS["basalt-velocity-step"].originals
    (path,) = published_folder("basalt-velocity-step").glob("basalt_velocity_step.txt")
    assert hashlib.sha256(path.read_bytes()).hexdigest() == original.sha256


def test_addresses():
    for name, each in DATA_SETS.items():
        assert each.name == name
        paths = [original.path for original in each.originals]
        assert len(set(paths)) == len(paths)
        assert all(original.url.startswith("https://") and " " not in original.url for original in each.originals)
    assert len(DATA_SETS["rotary-damper"].originals) == 3 * 13 + 6


# --- the command ------------------------------------------------------------------------------------------------------


@pytest.fixture
def one_set(basalt, monkeypatch, tmp_path):
    monkeypatch.setattr(published, "DATA_SETS", {"basalt-velocity-step": basalt})
    monkeypatch.setenv("VIBROCAP_DATA", str(tmp_path / "data"))
    return tmp_path / "data"


def test_list_says_what_there_is_and_where(one_set, capsys):
    assert "not here; 1 file" in printed(capsys, "list", "datasets")
    (one_set / "basalt-velocity-step").mkdir(parents=True)
    said = printed(capsys, "list", "datasets")
    assert f"here, in {one_set / 'basalt-velocity-step'}" in said
    assert "10.1130/GES02739.1; MIT" in said


def test_fetch_says_what_came(one_set, capsys, tmp_path):
    said = printed(capsys, "list", "datasets", "--fetch", "basalt-velocity-step")
    assert f"basalt-velocity-step: 1 records, 2,000 samples, in {one_set / 'basalt-velocity-step'}" in said
    assert "trusted    1 on first use" in said
    assert main(["list", "datasets", "--fetch", "basalt-velocity-step"]) == OK
    assert "checked    1 against the checksum of the first fetch" in capsys.readouterr().out
    assert main(["list", "datasets", "--fetch", "basalt-velocity-step", "--to", str(tmp_path / "else")]) == OK
    assert f"To use it: VIBROCAP_DATA={tmp_path / 'else'}" in capsys.readouterr().out


def test_a_fetch_that_stopped_between_two_files_continues(one_set, basalt, server, monkeypatch, capsys):
    """The checksums that it wrote of the first it reads, and writes with that of the second."""
    folder, address = server
    second = Original(f"{address}/more.txt", "more.txt")
    both = dataclasses.replace(basalt, originals=(*basalt.originals, second))
    monkeypatch.setitem(published.DATA_SETS, basalt.name, both)
    assert main(["list", "datasets", "--fetch", basalt.name]) == INCOMPLETE
    assert "more.txt" in capsys.readouterr().err
    (folder / "more.txt").write_text(TEXT)
    assert main(["list", "datasets", "--fetch", basalt.name]) == OK
    sums = (one_set / basalt.name / SUMS).read_text().splitlines()
    assert [line.split()[1] for line in sums] == ["basalt.txt", "more.txt"]


def test_no_network_ends_with_code_3_and_a_sentence(one_set, basalt, monkeypatch, capsys):
    with contextlib.closing(socket.socket()) as free:
        free.bind(("127.0.0.1", 0))
        nowhere = dataclasses.replace(basalt.originals[0], url=f"http://127.0.0.1:{free.getsockname()[1]}/basalt.txt")
        monkeypatch.setitem(published.DATA_SETS, basalt.name, dataclasses.replace(basalt, originals=(nowhere,)))
        assert main(["list", "datasets", "--fetch", "basalt-velocity-step"]) == INCOMPLETE
    said = capsys.readouterr()
    assert said.out == ""
    assert "no answer; there may be no network" in said.err
    assert basalt.page in said.err
    assert "Traceback" not in said.err


def test_a_file_that_is_gone_ends_with_code_3(one_set, server, capsys):
    (server[0] / "basalt.txt").unlink()
    assert main(["list", "datasets", "--fetch", "basalt-velocity-step"]) == INCOMPLETE
    assert "404" in capsys.readouterr().err


def test_wrong_input_ends_with_code_2(one_set, monkeypatch, capsys, tmp_path):
    assert "did you mean 'basalt-velocity-step'?" in refused(capsys, "list", "datasets", "--fetch", "basalt")
    assert "there is basalt-velocity-step" in refused(capsys, "list", "datasets", "--fetch", "rubber")
    (tmp_path / "file").write_text("")
    assert main(["list", "datasets", "--fetch", "basalt-velocity-step", "--to", str(tmp_path / "file")]) == WRONG_INPUT
    assert "--to:" in capsys.readouterr().err
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    assert "needs pooch; install with: " in refused(capsys, "list", "datasets", "--fetch", "basalt-velocity-step")


def test_pooch_keeps_its_log_to_itself(one_set, caplog):
    caplog.set_level(logging.INFO)
    assert main(["list", "datasets", "--fetch", "basalt-velocity-step"]) == OK
    assert caplog.records == []
