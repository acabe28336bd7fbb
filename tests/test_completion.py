"""Completion as bash, zsh and fish do it: commands, options, names of parts, measures, examples, paths of the case.

Each shell is the real one, driven as a user would; without it its tests are skipped. What is offered is also asked
directly, as the shells ask: by the hidden command of cyclopts.
"""

import os
import pty
import select
import shlex
import shutil
import subprocess
import sys
import time
from pathlib import Path

import pytest

from cases import printed, refused
from thinned import exhaustive_but
from vibrocap.cli.completers import script
from vibrocap.cli.main import app_of, main
from vibrocap.cli.terminal import OK
from vibrocap.physics.catalogue import drives, laws, machines

EXAMPLES = Path(__file__).parents[1] / "examples"
SHELLS = [shell for shell in ("bash", "zsh", "fish") if shutil.which(shell)]
COMMANDS = [name for name in app_of() if not name.startswith("-")]
CASE, IN_SI = str(EXAMPLES / "travels-by-stick-slip.toml"), str(EXAMPLES / "bench-in-si.toml")


@pytest.fixture(autouse=True)
def _own_folder(tmp_path, monkeypatch):
    """A folder with nothing but `bin/vibrocap`, the command that a shell asks."""
    command = tmp_path / "bin" / "vibrocap"
    command.parent.mkdir()
    command.write_text(f'#!/bin/sh\nexec {shlex.quote(sys.executable)} -m vibrocap "$@"\n')
    command.chmod(0o755)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("PATH", f"{command.parent}:{os.environ['PATH']}")


def offered(capsys, *words: str) -> dict[str, str]:
    """What the hidden command offers for the last of the words, with its meaning."""
    app_of()(["__complete", *words], exit_on_error=False, print_error=False)
    lines = capsys.readouterr().out.splitlines()
    return dict((*line.split("\t"), "")[:2] for line in lines if line and line[0] != "\x1f")


# --- what is offered --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "words",
    [
        ("friction",),
        ("fit", "data.csv", "--law"),
        ("fit", "data.csv", "--compare"),
        ("new", "--law"),
        ("lab", "--laws"),
        ("list",),
    ],
)
def test_laws_are_offered_with_what_they_are(words, capsys):
    found = offered(capsys, *words, "")
    assert set(laws()) <= set(found)
    assert found["lugre"].startswith("LuGre law")


def test_machines_drives_and_examples_are_offered(capsys):
    assert set(offered(capsys, "new", "")) == set(machines())
    assert set(offered(capsys, "lab", "--machines", "")) == set(machines())
    assert set(offered(capsys, "new", "--drive", "")) == set(drives())
    assert {*machines(), *drives()} < set(offered(capsys, "list", ""))
    assert set(offered(capsys, "examples", "")) == {path.stem for path in EXAMPLES.glob("*.toml")}
    assert "emps" in offered(capsys, "list", "datasets", "--fetch", "")


@pytest.mark.parametrize(
    "words",
    [
        ("sweep", CASE, "--over"),
        ("simulate", CASE, "--set"),
        ("branch", CASE, "--over"),
        ("crossing", CASE, "--over"),
        ("crossing", CASE, "--against"),
        ("optimise", CASE, "--over"),
        ("robust", CASE, "--uncertain"),
        ("calibrate", CASE, "--over"),
    ],
)
def test_paths_are_those_of_the_case_on_the_line(words, capsys):
    found = offered(capsys, *words, "")
    assert {"machine.mass_ratio=", "drive.frequency=", "friction.decay_rate=", "initial.angle=", "friction.law="} <= {
        *found
    }
    assert "friction.bristle_stiffness=" not in found  # of another law
    assert found["machine.mass_ratio="] == "capsule mass over pendulum mass, M/m"


def test_paths_of_a_case_in_si_have_units(capsys):
    said = offered(capsys, "sweep", IN_SI, "--over", "")
    assert said["drive.frequency_Hz="] == "drive frequency"  # in SI it is no ratio
    members = set(said)
    assert {
        "drive.frequency_Hz=",
        "machine.capsule_mass_kg=",
        "friction.static_coefficient=",
        "drive.waveform=",
    } <= members
    assert not {"drive.frequency=", "machine.mass_ratio="} & members
    states = set(offered(capsys, "simulate", IN_SI, "--initial", ""))
    assert states == {"angle_rad=", "angle_deg=", "angle_rate_rad_per_s=", "position_m=", "velocity_m_per_s="}


def test_behind_the_path_of_a_kind_stand_its_names(capsys):
    assert set(offered(capsys, "sweep", CASE, "--over", "friction.law=")) == {f"friction.law={name}" for name in laws()}
    assert "drive.waveform=square,ramp" in offered(capsys, "sweep", CASE, "--over", "drive.waveform=square,")
    assert offered(capsys, "sweep", CASE, "--over", "machine.mass_ratio=") == {}


def test_measures_are_those_of_the_case_and_no_name_is_offered_twice(capsys):
    every = offered(capsys, "sweep", "--measure", "")
    own = offered(capsys, "sweep", CASE, "--measure", "")
    assert {"mean_velocity", "cost_of_transport", "mode_sequence"} <= set(own) < set(every)
    assert own["mean_velocity"] == "travel per time"
    assert set(offered(capsys, "sweep", CASE, "--measure", "mode_sequence,")) == {
        f"mode_sequence,{name}" for name in own if name != "mode_sequence"
    }
    for option in ("--for", "--against", "--subject-to"):
        assert set(offered(capsys, "optimise", CASE, option, "")) == set(own)


@pytest.mark.parametrize("case", ["missing.toml", "broken.toml", "folder"])
def test_a_case_that_cannot_be_read_offers_nothing_and_says_nothing(case, capsys):
    Path("broken.toml").write_text("machine = [")
    Path("folder").mkdir()
    assert offered(capsys, "sweep", case, "--over", "") == {}
    assert capsys.readouterr().err == ""


# --- the shells themselves --------------------------------------------------------------------------------------------


def completed(shell: str, line: str) -> list[str]:
    """What a shell makes of a line as its TAB is pressed: the words that it offers, or the line where it is one."""
    Path("script").write_text(script(app_of(), shell))
    if shell == "bash":
        *first, last = line.split(" ")
        words = " ".join(map(shlex.quote, [*first, last]))
        ask = f"COMP_WORDS=({words}); COMP_CWORD={len(first)}; _vibrocap_open; printf '%s\\n' ${{COMPREPLY[@]}}"
        return _output("bash", "-c", f"source ./script; {ask}")
    if shell == "fish":
        output = _output("fish", "--no-config", "-c", f"source script; complete -C {shlex.quote(line)}")
        return [each.partition("\t")[0] for each in output]
    return [_typed_in_zsh(line).rstrip(" \b").rpartition(" ")[2]]


def _output(*command: str) -> list[str]:
    run = subprocess.run(command, capture_output=True, text=True, timeout=60, check=True)
    return run.stdout.split("\n")[:-1]


def _typed_in_zsh(line: str) -> str:
    """The line as zsh shows it after TAB; it completes only where a terminal listens."""
    child, terminal = pty.fork()
    if child == 0:
        os.environ.update(TERM="dumb", COLUMNS="300")
        os.execvp("zsh", ["zsh", "-f", "-i"])
    try:
        setup = "autoload -Uz compinit; compinit -u -D; source ./script; PS1='rea''dy> '\n"
        os.write(terminal, setup.encode())
        _read(terminal, until="ready> ")
        os.write(terminal, line.encode() + b"\t@")  # what comes behind TAB is shown behind what TAB made
        return _read(terminal, until="@").partition("@")[0]
    finally:
        os.close(terminal)
        os.kill(child, 9)
        os.waitpid(child, 0)


def _read(terminal: int, until: str) -> str:
    text, end = "", time.monotonic() + 30.0
    while until not in text:
        assert time.monotonic() < end, f"zsh did not show {until!r}: {text!r}"
        if select.select([terminal], [], [], 0.1)[0]:
            text += os.read(terminal, 65536).decode(errors="replace")
    return text


@pytest.mark.slow
@pytest.mark.parametrize("shell", SHELLS)
@pytest.mark.parametrize(
    ("line", "expected"),
    exhaustive_but(
        [1, 2, 4, 6],
        [
            ("vibrocap simu", "simulate"),
            ("vibrocap orbit --ha", "--half"),
            (f"vibrocap sweep {CASE} --over machine.ma", "machine.mass_ratio="),
            (f"vibrocap sweep {IN_SI} --over drive.frequency_H", "drive.frequency_Hz="),
            (f"vibrocap sweep {CASE} --measure mean_v", "mean_velocity"),
            ("vibrocap friction lug", "lugre"),
            ("vibrocap lab --machines rotor-c", "rotor-capsule"),
            ("vibrocap examples mirror", "mirror-twin"),
        ],
    ),
)
def test_a_shell_completes(shell, line, expected):
    assert completed(shell, line) == [expected]


# --- the scripts ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish", "powershell"])
def test_the_script_knows_commands_and_options(shell, capsys):
    text = printed(capsys, "--completion", shell)
    for word in (*COMMANDS, "tolerance", "response-period"):
        assert word in text
    if shutil.which(shell) and shell != "powershell":
        Path("script").write_text(text)
        subprocess.run([shell, "-n", "script"], check=True, timeout=60)


def test_what_is_installed_is_the_script_that_is_printed(tmp_path, monkeypatch, capsys):
    monkeypatch.setenv("HOME", str(tmp_path))
    assert main(["--completion", "bash", "--install"]) == OK
    path = tmp_path / ".local/share/bash-completion/completions/vibrocap"
    assert str(path) in capsys.readouterr().out.replace("\n", "")
    assert path.read_text() == script(app_of(), "bash")


def test_an_unknown_shell_is_refused(capsys):
    assert "zsh" in refused(capsys, "--completion", "tcsh")
