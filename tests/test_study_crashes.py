"""Killed at any instant and resumed: the same bytes, file by file, as a study that was never interrupted."""

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from thinned import exhaustive_but
from vibrocap.cli.command import COMMANDS
from vibrocap.cli.main import app_of, main
from vibrocap.files import PART

pytestmark = pytest.mark.skipif(not hasattr(os, "fork"), reason="forks")
PROGRAM = Path(__file__).with_name("crashing_sweep.py")


def killed(folder, how, count, seed):
    """What `crashing_sweep.py` found."""
    command = [sys.executable, str(PROGRAM), str(folder), how, str(count), str(seed)]
    return json.loads(subprocess.run(command, capture_output=True, text=True, check=True, timeout=900).stdout)


@pytest.mark.slow
def test_killed_at_many_calls_that_change_the_disk(tmp_path):
    """Each of them before it happens, or halfway through a file, from the first folder made to the last mark."""
    found = killed(tmp_path, "steps", 20, 2)
    assert found["calls"] > 150
    assert found["different"] == []


# --- every --resume, from the command line ----------------------------------------------------------------------------
FREQUENCY = "drive.frequency=0.5:3"
# what is resumed: (its command, the files of which the first tells that something is stored)
RESUMED = {
    "sweep": (("sweep", "--over", f"{FREQUENCY}:4000", "--tile-runs", "200"), "done/*"),
    "optimise": (("optimise", "--over", FREQUENCY, "--evaluations", "128"), "populations/[0-9]*.npz"),
    "front": (
        ("optimise", "--over", FREQUENCY, "--against", "cost_of_transport", "--evaluations", "300"),
        "populations/[0-9]*.npz",
    ),
}


def vibrocap(*arguments):
    """The command in a process of its own, in a group of its own."""
    command = [sys.executable, "-m", "vibrocap", *map(str, arguments)]
    return subprocess.Popen(
        command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, text=True, start_new_session=True
    )


def test_every_command_that_resumes_is_killed_here():
    """So that a new --resume is tested from the command line too."""
    app_of()
    values = {name for name, command in COMMANDS.items() if "resume" in command.request.options()}
    assert values == {command[0] for command, _ in RESUMED.values()}


@pytest.mark.slow
@pytest.mark.parametrize("what", exhaustive_but([0], [*RESUMED]))
def test_a_killed_command_is_resumed_to_the_same_files(tmp_path, what):
    """Killed once something is stored; resumed, and resumed again when it was done: the files of an unbroken run."""
    if what == "front":
        pytest.importorskip("pymoo")
    asked, stored = RESUMED[what]
    assert main(["new", "--out", str(tmp_path / "case.toml")]) == 0
    command = (asked[0], tmp_path / "case.toml", *asked[1:])
    assert vibrocap(*command, "--out", tmp_path / "whole").wait(timeout=300) == 0
    killed = tmp_path / "killed"
    with vibrocap(*command, "--out", killed) as process:
        while not any(killed.glob(stored)):
            assert process.poll() is None
            time.sleep(0.01)
        os.killpg(process.pid, signal.SIGKILL)
        assert process.wait(timeout=60) == -signal.SIGKILL
    for _ in range(2):
        assert vibrocap(*command, "--out", killed, "--resume").wait(timeout=300) == 0
        assert tree(killed) == tree(tmp_path / "whole")


def tree(folder):
    """Every file with its bytes, but for temporary ones: those of a killed process go an hour later."""
    paths = (path for path in folder.rglob("*") if path.is_file() and PART not in path.name)
    return {path.relative_to(folder).as_posix(): path.read_bytes() for path in paths}
