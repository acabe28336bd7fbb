"""As many motions side by side as registers hold; how many changes no bit of a run."""

import os
import subprocess
import sys

import pytest

from vibrocap.numerics.compiler import host
from vibrocap.numerics.kernel.arithmetic.plain_vectors import lane_count


@pytest.mark.parametrize(
    ("names", "lanes"),
    [
        ({"VIBROCAP_CPU_FEATURES": "+avx2,+avx512f"}, 8),
        ({"VIBROCAP_CPU_FEATURES": "+avx2,-avx512f"}, 4),
        ({"VIBROCAP_CPU_NAME": "haswell"}, 4),
        ({"VIBROCAP_CPU_NAME": "haswell", "VIBROCAP_CPU_FEATURES": "+avx512f"}, 8),
    ],
)
def test_lanes_follow_the_processor_that_kernels_are_compiled_for(monkeypatch, names, lanes):
    for name in ("VIBROCAP_CPU_NAME", "VIBROCAP_CPU_FEATURES"):
        monkeypatch.delenv(name, raising=False)
    for name, value in names.items():
        monkeypatch.setenv(name, value)
    host.cache_clear()
    lane_count.cache_clear()
    try:
        assert lane_count() == lanes
    finally:
        host.cache_clear()
        lane_count.cache_clear()


RUNS = """
import sys
import numpy as np
from vibrocap.numerics.kernel.arithmetic import plain_vectors
plain_vectors.lane_count = lambda: int(sys.argv[1])
import vibrocap as vc
assert len(plain_vectors.all_lanes()) == int(sys.argv[1])
over = {"machine.mass_ratio": np.linspace(0.05, 8.0, 61)}
settings = {"initial": {"angle": 1.0}, "periods": 8, "tolerance": 1e-6, "measures": ["mean_velocity", "mode_sequence"]}
found = vc.ensemble(vc.System(vc.PendulumCapsule(), vc.LuGre(), vc.Harmonic()), over, **settings)
print([value.hex() for value in found["mean_velocity"]], list(found["mode_sequence"]))
"""


@pytest.mark.slow
def test_four_lanes_give_the_bits_of_eight():
    environment = {name: value for name, value in os.environ.items() if not name.startswith("VIBROCAP_CPU")}
    four, eight = (
        subprocess.run(
            [sys.executable, "-c", RUNS, lanes], capture_output=True, text=True, check=True, env=environment
        ).stdout
        for lanes in ("4", "8")
    )
    assert len(four) > 1000
    assert four == eight
