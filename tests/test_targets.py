"""Objects for processors that need not be here, each written in a process of its own: LLVM ends it on some errors."""

import shutil
import struct
import subprocess
import sys

import numpy as np
import pytest

import vibrocap as vc
from thinned import exhaustive_but
from vibrocap.motion.recording.equations import equations, parameter_values
from vibrocap.numerics.kernel import codes
from vibrocap.numerics.run.budget import Budget, EnsembleStart
from vibrocap.numerics.run.ensemble import ensemble_order, ensemble_run, ensemble_source, prepared_lanes
from vibrocap.numerics.run.results import RunResults

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


@pytest.mark.slow
@pytest.mark.parametrize("name", exhaustive_but([2], [*TARGETS]))  # the others are run below
def test_objects_are_written_for_other_processors(name):
    """The exponential law, all lanes at once: an object file of that machine, with the entry in it."""
    triple, processor, features, lanes, machine = TARGETS[name]
    system = vc.System(vc.PendulumCapsule(), vc.Exponential(), vc.Harmonic())
    _, text = ensemble_source(equations(system), 10, lanes)
    command = [sys.executable, "-c", EMIT, triple, processor, features]
    done = subprocess.run(command, input=text.encode(), capture_output=True, check=True, timeout=120)
    stdout = done.stdout
    assert stdout[:6] == b"\x7fELF\x02\x01"  # 64 bits, little-endian
    kind, of = struct.unpack_from("<HH", stdout, 16)
    assert (kind, of) == (1, machine)  # a relocatable object
    assert b"kernel_entry\0" in stdout
    assert len(stdout) > 30_000


# What runs an object of another processor here: the compiler that links it, and the machine that plays the processor.
PLAYED = {
    "x86-64": ("gcc", ("qemu-x86_64", "-cpu", "Nehalem")),
    "AVX2": ("gcc", ("qemu-x86_64", "-cpu", "Haswell")),
    "aarch64": ("aarch64-linux-gnu-gcc", ("qemu-aarch64", "-cpu", "neoverse-n1")),
}
RUNNER = """
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

int64_t kernel_entry(double *floats, int64_t *ints, double *trace, int64_t rounds);

static void *numbers(long count) { /* eight bytes each, from the start of a cache line on, as the kernel expects */
    void *room = aligned_alloc(64, (8 * count + 63) / 64 * 64);
    if (fread(room, 8, count, stdin) != (size_t)count) exit(2);
    return room;
}

int main(int count, char **sizes) {
    long length = atol(sizes[3]);
    double *floats = numbers(atol(sizes[1]));
    int64_t *ints = numbers(atol(sizes[2]));
    double *trace = numbers(length);
    while (kernel_entry(floats, ints, trace, 500)) {}
    return fwrite(trace, 8, length, stdout) == (size_t)length ? 0 : 3;
}
"""


@pytest.mark.slow
@pytest.mark.parametrize("law", exhaustive_but([0], [vc.Exponential(), vc.LuGre()]), ids=["exponential", "lugre"])
@pytest.mark.parametrize("name", exhaustive_but([1], [*PLAYED]))
def test_objects_for_other_processors_do_what_this_one_does(name, law, tmp_path):
    """Nine runs on a played processor: the same steps, and states as near as fused products let them be."""
    linker, player = PLAYED[name]
    for tool in (linker, player[0]):
        if shutil.which(tool) is None:
            pytest.skip(f"needs {tool} (packages qemu-user, gcc, gcc-aarch64-linux-gnu)")
    system = vc.System(vc.PendulumCapsule(mass_ratio=2.5, stiffness=2.0, damping=1.0), law, vc.Harmonic())
    recorded, runs = equations(system), 9
    parameters = np.tile(parameter_values(system), (runs, 1))
    parameters[:, recorded.parameter_paths.index("drive.amplitude")] = np.linspace(0.5, 2.0, runs)
    start = np.zeros((runs, len(system.state_names)))
    start[:, 0] = 1.0
    budget = Budget(12, 1e-9, 10_000, 1_000_000, window=10, asked=codes.ASK_EXTREMES)
    here = ensemble_run(EnsembleStart(recorded, parameters, start), budget, threads=1)

    triple, processor, features, lanes, _ = TARGETS[name]
    layout, text = ensemble_source(recorded, ensemble_order(budget.tolerance), lanes)
    command = [sys.executable, "-c", EMIT, triple, processor, features]
    done = subprocess.run(command, input=text.encode(), capture_output=True, check=True, timeout=120)
    (tmp_path / "kernel.o").write_bytes(done.stdout)
    (tmp_path / "runner.c").write_text(RUNNER)
    files = [str(tmp_path / "runner.c"), str(tmp_path / "kernel.o")]
    subprocess.run([linker, "-static", "-o", str(tmp_path / "run"), *files, "-lm"], check=True, timeout=120)
    floats, ints = prepared_lanes(layout, budget, runs)
    ints[layout.places["LAST_RUN"]], ints[layout.places["MORE"]] = runs, 0
    trace = np.zeros(runs * (layout.run_size + layout.result_size))
    EnsembleStart(recorded, parameters, start).write(trace[: runs * layout.run_size].reshape(runs, -1))
    sizes = [str(part.size) for part in (floats, ints, trace)]
    sent = b"".join(part.tobytes() for part in (floats, ints, trace))
    done = subprocess.run([*player, str(tmp_path / "run"), *sizes], input=sent, capture_output=True, timeout=300)
    assert done.returncode == 0, done.stderr.decode()
    there = RunResults(layout, np.frombuffer(done.stdout)[runs * layout.run_size :].reshape(runs, -1))
    assert np.all(there.finished)
    assert np.array_equal(there.head("taylor_steps"), here.head("taylor_steps"))
    assert there.state == pytest.approx(here.state, rel=0.0, abs=1e-9)
