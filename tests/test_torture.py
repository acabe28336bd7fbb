"""A short form of `make torture`: every attack, with few trials. What each of them tests stands in docs/trust.md."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
ATTACKS = ("kills", "links", "settings", "waits", "damage", "full disk", "fuzzed cases", "fuzzed commands", "pairs")
pytestmark = pytest.mark.skipif(not hasattr(os, "fork"), reason="forks")


@pytest.mark.slow
def test_no_attack_breaks_a_promise():
    command = [sys.executable, "-m", "torture", "--share", "0.003", "--seed", "5"]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=900)
    assert done.returncode == 0, done.stdout + done.stderr
    assert sorted(re.findall(r"^([a-z ]+?) +[\d,]+ trials    0 faults", done.stdout, re.MULTILINE)) == sorted(ATTACKS)


@pytest.mark.parametrize("attack", ATTACKS)
def test_the_page_of_promises_keeps_the_figures_of_every_attack(attack):
    rows = re.findall(r"^\| ([a-z ]+) \| ([\d,]+) \| ", (ROOT / "docs/trust.md").read_text("utf-8"), re.MULTILINE)
    wanted = {
        name.replace("_", " "): trials for name, trials in re.findall(r'"([a-z ]+)": \("\w+", ([\d_]+)\)', text())
    }
    assert dict(rows)[attack].replace(",", "") == wanted[attack].replace("_", "")


def text():
    return (ROOT / "torture/__main__.py").read_text(encoding="utf-8")


def test_every_command_is_among_the_fuzzed_ones():
    """With what it cannot do without, so that it works there: `reproduce` alone is always refused."""
    from torture.fuzz_commands import COMMANDS, NEEDS
    from vibrocap.cli.overview import names

    assert {*names()} == {*COMMANDS} - {"sweeep"}
    idle = {name for name, options in NEEDS.items() for option in options if not COMMANDS[name][1][option][0]}
    assert not idle
