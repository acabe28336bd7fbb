"""Objects for processors that need not be here, each written in a process of its own: LLVM ends it on some errors."""

import struct
import subprocess
import sys

import pytest

import vibrocap as vc
from thinned import slow_but
from vibrocap.motion.equations import equations
from vibrocap.numerics.run.ensemble import ensemble_source

EMIT = """
import sys
from vibrocap.numerics.compiler import Target, ir, object_code
text = sys.stdin.read()
target = Target(*sys.argv[1:4])
sys.stdout.buffer.write(object_code(ir(text, "advance_ensemble", target), target))
"""
X86_64, AARCH64 = 62, 183  # machines, in the head of an object file
TARGETS = {
    "x86-64": ("x86_64-unknown-linux-gnu", "x86-64", "", 4, X86_64),
    "AVX2": ("x86_64-unknown-linux-gnu", "haswell", "+avx2,+fma", 4, X86_64),
    "AVX-512": ("x86_64-unknown-linux-gnu", "skylake-avx512", "+avx512f", 8, X86_64),
    "aarch64": ("aarch64-unknown-linux-gnu", "neoverse-n1", "+neon", 4, AARCH64),
}


@pytest.mark.parametrize("name", slow_but([2], [*TARGETS]))
def test_objects_are_written_for_other_processors(name):
    """The exponential law abreast: an object file of that machine, with the entry in it."""
    triple, processor, features, lanes, machine = TARGETS[name]
    system = vc.System(vc.PendulumCapsule(), vc.Exponential(), vc.Harmonic())
    _, text = ensemble_source(equations(system), 10, lanes)
    command = [sys.executable, "-c", EMIT, triple, processor, features]
    done = subprocess.run(command, input=text.encode(), capture_output=True, check=True, timeout=120)
    found = done.stdout
    assert found[:6] == b"\x7fELF\x02\x01"  # 64 bits, little-endian
    kind, of = struct.unpack_from("<HH", found, 16)
    assert (kind, of) == (1, machine)  # a relocatable object
    assert b"kernel_entry\0" in found
    assert len(found) > 30_000
