"""Cases as rates, guards and decisions in C: with an integrator of another hand, the events and the end of the motion.

Runge-Kutta steps of a fixed length leave an error of their own, which falls with the fourth power of the length where
events are located; bits are the same with every optimisation; the memory of a motion is some hundred bytes.
"""

import dataclasses
import shutil
import subprocess
from collections import Counter
from pathlib import Path

import numpy as np
import pytest

import vibrocap as vc
from test_exchange import FUSED, GCC, built, needs_gcc, printed
from test_exchange_examples import BARE_GCC
from thinned import exhaustive_but
from vibrocap.arguments import ArgumentError
from vibrocap.case.case import read_case
from vibrocap.cli.main import main
from vibrocap.exchange.rates_library import export_rates, rates_files

EXAMPLES = sorted((Path(__file__).parents[1] / "examples").glob("*.toml"))
README = next(path for path in EXAMPLES if path.stem == "travels-by-stick-slip")
NAMES = ("square-wave-travels", "weight-as-load", "forward-or-back-by-its-start")
RUN = [i for i, path in enumerate(EXAMPLES) if path.stem in NAMES]
KINDS = ("stick", "slip_forward", "slip_back", "reversal")


def ended(rows, case):
    """(states at the end, how many events there are of each kind before it, where a drive with corners has another)."""
    states = [float(each) for each in rows[-1][3 : 3 + len(case.system.state_names)]]
    return np.array(states), Counter(row[1] for row in rows if float(row[0]) < 0.9999 * float(rows[-1][0]))


def counted(motion):
    return Counter(event.kind for event in motion.events if event.kind in KINDS and event.time < 0.9999 * motion.end)


def run(case, folder, *options, input=None):
    export_rates(case, folder, input=input)
    return printed(built(folder, *(options or ("-O2",))))


@needs_gcc
def test_an_integrator_of_its_own_finds_every_event(tmp_path):
    case = read_case(README)
    motion = case.simulate()
    code, rows = run(case, tmp_path)
    states, found = ended(rows, case)
    kinds = Counter(event.kind for event in motion.events)
    assert (code, rows[-1][1], sum(kinds.values())) == (0, "finished", 158)
    assert {kind: found[kind] for kind in kinds} == kinds
    off = np.abs(states - [*motion.state.values()]).max()
    assert off < 1e-6  # measured: 7e-9 of the position, 2e-8 of the angle rate
    times = [float(row[0]) for row in rows if row[1] in kinds]
    np.testing.assert_allclose(times, [event.time for event in motion.events], atol=1e-6)
    text = (tmp_path / "main.c").read_text()
    (tmp_path / "main.c").write_text(text.replace("#define STEPS 16", "#define STEPS 1"))
    coarse, _ = ended(printed(built(tmp_path, "-O2", out="coarse"))[1], case)
    assert 20.0 * off < np.abs(coarse - [*motion.state.values()]).max() < 0.1  # the integrator's error


@needs_gcc
def test_bits_are_the_same_with_every_optimisation(tmp_path):
    case = read_case(README, periods=5)
    rows = [run(case, tmp_path / option[0], *option)[1] for option in (("-O0",), FUSED)]
    assert rows[0] == rows[1]
    assert len(rows[0]) > 300


@needs_gcc
def test_an_input_that_jumps_is_an_event(tmp_path):
    """The square wave of main.c is that of a motion under `Square`."""
    case = read_case(README, periods=10)
    code, rows = run(case, tmp_path, input="drive")
    drive = vc.Square(amplitude=1.8, frequency=1.0)
    motion = dataclasses.replace(case, system=dataclasses.replace(case.system, drive=drive)).simulate()
    states, found = ended(rows, case)
    assert code == 0
    assert {kind: found[kind] for kind in KINDS} == counted(motion)
    np.testing.assert_allclose(states, [*motion.state.values()], atol=1e-5)


@pytest.mark.slow
@needs_gcc
def test_segments_of_a_drive_follow_one_another_at_its_corners(tmp_path):
    case = read_case(README, periods=5)
    system = dataclasses.replace(case.system, drive=vc.Triangle(amplitude=1.8))
    case = dataclasses.replace(case, system=system)
    _, rows = run(case, tmp_path)
    motion = case.simulate()
    states, found = ended(rows, case)
    assert {kind: found[kind] for kind in counted(motion)} == counted(motion)
    np.testing.assert_allclose(states, [*motion.state.values()], atol=1e-6)


@needs_gcc
@pytest.mark.slow
@pytest.mark.parametrize("path", exhaustive_but(RUN, EXAMPLES), ids=lambda path: path.stem)
def test_examples_have_the_events_of_their_motion(path, tmp_path):
    """Corners of drives, loads that follow, branches of laws and machines, SI (times and states are without units)."""
    case = read_case(path, periods=5)
    try:
        _, rows = run(case, tmp_path)
    except ArgumentError as error:
        pytest.skip(str(error))
    if path.stem == "bounces-and-rests-at-a-wall":  # by impacts that become ever smaller
        assert rows[-1][1] == "too many events"
        return
    motion = case.simulate().dimensionless
    states, found = ended(rows, case)
    assert rows[-1][1] == ("finished" if motion.status.ok else motion.status.value)
    assert {kind: found[kind] for kind in counted(motion)} == counted(motion)
    np.testing.assert_allclose(states, [*motion.state.values()], atol=1e-4)


@needs_gcc
def test_inexact_arithmetic_is_refused(tmp_path):
    export_rates(read_case(README), tmp_path)
    done = subprocess.run(
        [GCC, "-ffast-math", "-fsyntax-only", tmp_path / "capsule.c"], capture_output=True, check=False
    )
    assert done.returncode != 0
    assert b"without -ffast-math" in done.stderr


@pytest.mark.slow
def test_firmware_of_rates_takes_some_hundred_bytes(tmp_path):
    """The object for a Cortex-M7, and the struct."""
    if not BARE_GCC or not shutil.which("arm-none-eabi-size"):
        pytest.skip("no arm-none-eabi-gcc is installed")
    export_rates(read_case(README), tmp_path, input="drive")
    words = ["-mcpu=cortex-m7", "-mthumb", "-mfpu=fpv5-d16", "-mfloat-abi=hard", "-Os", "-std=gnu99", "-c"]
    (tmp_path / "one.c").write_text('#include "capsule.h"\ncapsule motion;\n')
    for name in ("capsule", "one"):
        subprocess.run([BARE_GCC, *words, "-o", tmp_path / f"{name}.o", tmp_path / f"{name}.c"], check=True)
    command = ["arm-none-eabi-size", tmp_path / "capsule.o", tmp_path / "one.o"]
    rows = subprocess.run(command, capture_output=True, text=True, check=True).stdout.splitlines()[1:]
    (text, data, bss, *_), (_, _, memory, *_) = ([int(each) for each in row.split()[:3]] for row in rows)
    print(f"{text} bytes of code, {memory} of memory")
    assert (data, bss) == (0, 0)
    assert text < 10_000
    assert memory < 512


@needs_gcc
def test_parameters_and_bad_values(tmp_path):
    case = read_case(README, periods=2)
    export_rates(case, tmp_path)
    text = (tmp_path / "main.c").read_text()
    begun = "  capsule_case(&motion);\n"
    assert begun in text
    given = """  if (capsule_set_parameter(&motion, 0, -1.0) || capsule_set_parameter(&motion, 0, 0.0 / 0.0)) return 9;
  if (capsule_set_parameter(&motion, CAPSULE_PARAMETERS, 1.0) || !capsule_set_parameter(&motion, 0, 3.5)) return 9;
  capsule_states(&motion)[1] = 0.25;
"""
    (tmp_path / "main.c").write_text(text.replace(begun, begun + given))
    code, rows = printed(built(tmp_path, "-O1", "-Wno-div-by-zero", "-fsanitize=address,undefined"))
    assert code == 0
    system = case.system.with_parameters({"machine.mass_ratio": 3.5})
    motion = vc.simulate(system, periods=2, initial={**case.initial, "angle_rate": 0.25}, tolerance=1e-10)
    np.testing.assert_allclose(ended(rows, case)[0], [*motion.state.values()], atol=1e-6)


def test_what_has_no_rates_is_named(tmp_path, capsys):
    for name, said in (
        ("bristles-lugre", "--to: rates for another integrator take set-valued laws of friction, lugre is none"),
        ("worm-of-three-bodies", "take one contact"),
    ):
        case = str(README.with_name(f"{name}.toml"))
        assert main(["export", case, "--to", "rates", "--out", str(tmp_path / "new")]) == 2
        assert said in capsys.readouterr().err
    assert main(["export", str(README), "--to", "rates", "--out", str(tmp_path / "new")]) == 0
    assert "capsule.c, capsule.h, main.c, README.txt" in capsys.readouterr().out
    with pytest.raises(ValueError, match="name should be up to 31"):
        rates_files(read_case(README), "Capsule-1")
