"""Killed at any instant and resumed: the same bytes, file by file, as a study that was never interrupted."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

pytestmark = pytest.mark.skipif(not hasattr(os, "fork"), reason="forks")
PROGRAM = Path(__file__).with_name("crashing_sweep.py")


def killed(folder, how, count, seed):
    """What `crashing_sweep.py` found."""
    command = [sys.executable, str(PROGRAM), str(folder), how, str(count), str(seed)]
    return json.loads(subprocess.run(command, capture_output=True, text=True, check=True, timeout=900).stdout)


@pytest.mark.slow
def test_killed_at_many_calls_that_change_the_disk(tmp_path):
    """Each of them before it happens, or halfway through a file, from the first folder made to the last mark."""
    found = killed(tmp_path, "steps", 40, 2)
    assert found["calls"] > 150
    assert found["different"] == []


@pytest.mark.exhaustive
@pytest.mark.slow
def test_killed_at_fifty_random_moments(tmp_path):
    found = killed(tmp_path, "moments", 50, 3)
    assert found["instants"] >= 50
    assert found["studies"] >= 3
    assert found["different"] == []
