"""Texts of cases that several files of tests read, and how they run commands."""

import json

from vibrocap.cli.main import main
from vibrocap.cli.terminal import OK, WRONG_INPUT

DEFAULTS = """\
[machine]
kind = "pendulum-capsule"
[friction]
law = "exponential"
[drive]
waveform = "harmonic"
"""
SETTLED = f"{DEFAULTS}[initial]\nangle = 1.0471975511965976\n[run]\nperiods = 12\ntolerance = 1e-10\n"
SHORT = f"{DEFAULTS}[run]\nperiods = 2\n"


def command(*arguments) -> int:
    """The exit code."""
    return main([str(argument) for argument in arguments])


def printed(capsys, *arguments, code=OK) -> str:
    """What a command prints."""
    assert command(*arguments) == code
    return capsys.readouterr().out


def printed_json(capsys, *arguments, code=OK):
    """What a command prints with --json, and nothing else."""
    assert command(*arguments, "--json") == code
    output = capsys.readouterr()
    assert code or output.err == ""
    return json.loads(output.out, parse_constant=_no_json)


def _no_json(name):
    raise AssertionError(f"{name} is no JSON")


def refused(capsys, *arguments, code=WRONG_INPUT) -> str:
    """What stands on stderr of a command that was refused before any work."""
    assert command(*arguments) == code
    output = capsys.readouterr()
    assert output.out == ""
    assert "Traceback" not in output.err
    return output.err
