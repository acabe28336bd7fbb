"""The sources of `examples/exchange/` compile and run: firmware for a Cortex-M7, an S-function, a node of ROS 2.

MATLAB, ROS and a board are played by stand-ins (`exchange_stand_ins.py`); all of them must give the motion of the
library. The firmware is a program for the processor, run by qemu where that is installed, of limited size.
"""

import importlib.util
import shutil
import struct
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import exchange_stand_ins as stand_ins
from vibrocap.case.case import read_case
from vibrocap.exchange.c_library import export_c

ROOT = Path(__file__).resolve().parents[1]
SOURCES = ROOT / "examples" / "exchange"
GCC, GXX, QEMU, BARE_GCC = (shutil.which(name) or "" for name in ("gcc", "g++", "qemu-arm", "arm-none-eabi-gcc"))
ZIG = [sys.executable, "-m", "ziglang", "cc"] if importlib.util.find_spec("ziglang") else []

pytestmark = [pytest.mark.slow, pytest.mark.skipif(not GCC, reason="no gcc is installed")]

CODE, MEMORY = 30_000, 8 * 1024  # bytes of a Cortex-M7 that a capsule may take


@pytest.fixture(scope="module")
def library(tmp_path_factory):
    """The folder of the library, with the drive as an input."""
    folder = tmp_path_factory.mktemp("library")
    export_c(read_case(ROOT / "examples" / "travels-by-stick-slip.toml"), folder, input="drive")
    return folder


@pytest.fixture(scope="module")
def seen(library):
    """[steps + 1, columns] what the library shows of the motion: time, states, observables, side."""
    (library / "direct.c").write_text(stand_ins.DIRECT)
    program = built([GCC, "-O2", "-std=c99"], library, library / "direct", library / "direct.c", "-lm")
    reshape = doubles(program).reshape(stand_ins.STEPS + 1, -1)
    assert np.ptp(reshape[:, 3]) > 0.5  # it travels,
    assert set(reshape[:, -1]) == {-1.0, 0.0, 1.0}  # slides both ways and rests
    return reshape


def built(compiler, library, out, *words):
    strict = ["-Wall", "-Wextra", "-Werror"] if "ziglang" not in compiler else ["-w"]
    sources = [*words[:1], library / "capsule.c", *words[1:]]
    command = [*compiler, *strict, f"-I{library}", "-o", out, *sources]
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr[-3000:]
    return out


def doubles(program, *runner):
    done = subprocess.run([*runner, str(program)], capture_output=True, check=True, timeout=300)
    return np.frombuffer(done.stdout, float)


def written(folder, texts):
    for name, text in texts.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(text)
    return folder


def sizes(elf):
    """(bytes of code and constants, bytes of memory) of an ELF file of 32 bits, without what it links to unwind."""
    data = elf.read_bytes()
    table, count = struct.unpack_from("<I", data, 28)[0], struct.unpack_from("<H", data, 44)[0]
    segments = [struct.unpack_from("<8I", data, table + 32 * i) for i in range(count)]
    loaded = [(size, room, flags & 2) for kind, _, _, _, size, room, flags, _ in segments if kind == 1]
    return sum(size for size, _, writable in loaded if not writable), sum(
        room for _, room, writable in loaded if writable
    )


def bare_compiler(which, folder):
    """What compiles for a Cortex-M7 with a double precision unit, and links without an operating system."""
    common = ["-Os", "-std=gnu99", "-DBARE", f"-I{SOURCES}"]
    if which == "gcc":
        if not BARE_GCC:
            pytest.skip("no arm-none-eabi-gcc is installed")
        flags = ["-mcpu=cortex-m7", "-mthumb", "-mfpu=fpv5-d16", "-mfloat-abi=hard"]
        return [BARE_GCC, *flags, *common, "-nostartfiles"], ["-lm"]
    if not ZIG:
        pytest.skip("ziglang is not installed (.ci/exchange-requirements.txt)")
    headers = written(folder / "headers", stand_ins.BARE_HEADERS)
    flags = ["-target", "thumb-freestanding-eabihf", "-mcpu=cortex_m7+fp_armv8d16", "-isystem", str(headers)]
    return [*ZIG, *flags, *common, "-ffreestanding", "-nostartfiles", "-static"], ["-lcompiler_rt"]


@pytest.mark.parametrize("which", ["gcc", "zig"])
def test_firmware_for_a_cortex_m7_is_small_and_has_the_same_bits(which, library, seen, tmp_path):
    text = (SOURCES / "firmware.c").read_text()
    assert "#define LOOP_TIME 1e-3" in text
    (tmp_path / "firmware.c").write_text(text.replace("LOOP_TIME 1e-3", f"LOOP_TIME {stand_ins.STEP}"))
    (tmp_path / "board.c").write_text(stand_ins.BOARD)
    compiler, libraries = bare_compiler(which, tmp_path)
    words = (tmp_path / "firmware.c", tmp_path / "board.c", *libraries)
    program = built(compiler, library, tmp_path / "board", *words)
    code, memory = sizes(program)
    assert code <= CODE
    assert memory <= MEMORY
    if not QEMU:
        pytest.skip("no qemu-arm is installed: compiled, of the right size, not run")
    *poses, (stack, _, _) = doubles(program, QEMU).reshape(-1, 3)
    np.testing.assert_array_equal(poses, np.column_stack([seen[1:, 1], seen[1:, 3], seen[1:, -1] == 0.0]))
    assert memory + stack <= MEMORY
    print(f"{which}: {code} bytes of code, {memory} of memory, {stack:.0f} of stack")


def test_the_s_function_gives_the_bits_of_the_library(library, seen, tmp_path):
    headers = written(tmp_path, stand_ins.SIMULINK)
    compiler = [GCC, "-O2", "-std=c99", "-Wno-unused-value", f"-I{headers}"]
    program = built(compiler, library, tmp_path / "block", SOURCES / "capsule_sfunction.c", "-lm")
    done = subprocess.run([program], capture_output=True, check=False)
    assert done.returncode == 0
    assert done.stderr == b"refused"
    np.testing.assert_array_equal(np.frombuffer(done.stdout, float), seen[:, 1:].ravel())


def test_the_node_gives_the_motion_of_the_library_and_tells_of_events(library, seen, tmp_path):
    if not GXX:
        pytest.skip("no g++ is installed")
    headers = written(tmp_path, stand_ins.ROS)
    subprocess.run([GCC, "-O2", "-c", "-o", tmp_path / "capsule.o", library / "capsule.c"], check=True)
    command = [GXX, "-std=c++17", "-O1", "-Wall", "-Wextra", "-Werror", f"-I{library}", f"-I{headers}"]
    sources = [SOURCES / "capsule_node.cpp", tmp_path / "capsule.o"]
    done = subprocess.run([*command, "-o", tmp_path / "node", *sources], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    done = subprocess.run([tmp_path / "node"], capture_output=True, check=True)
    # it stops at events, after which what is left of a step is rounded
    np.testing.assert_allclose(np.frombuffer(done.stdout, float), seen[1:].ravel(), rtol=0.0, atol=1e-10)
    lines = done.stderr.decode().splitlines()
    assert {line.split(" of contact 1 at ")[0] for line in lines} == {"stick", "slip_forward", "slip_back", "reversal"}
