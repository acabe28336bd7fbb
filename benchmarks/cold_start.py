"""How long `vibrocap simulate` takes in a new process: on a new machine, the second time, and for new numbers."""

import os
import pathlib
import subprocess
import sys
import tempfile
import time

CASE = """
[machine]
kind = "pendulum-capsule"
mass_ratio = {mass_ratio}
stiffness = 2.0
damping = 1.0
[friction]
law = "{law}"
[drive]
waveform = "harmonic"
amplitude = 1.8
frequency = 1.0
[initial]
angle = 1.0471975511965976
[run]
periods = 40
tolerance = 1e-10
"""


def main() -> None:
    """Print seconds per call, each in a process of its own."""
    print("\nA new process of `vibrocap simulate`, seconds")
    with tempfile.TemporaryDirectory() as folder:
        environment = os.environ | {"VIBROCAP_CACHE": folder}
        for law in ("exponential", "lugre"):
            for label, mass_ratio in (("new machine", 2.5), ("second call", 2.5), ("new numbers", 3.7)):
                case = pathlib.Path(folder) / "case.toml"
                case.write_text(CASE.format(law=law, mass_ratio=mass_ratio))
                before = time.perf_counter()
                command = [sys.executable, "-m", "vibrocap", "simulate", str(case), "--json"]
                subprocess.run(command, check=True, capture_output=True, env=environment)
                print(f"  {law:14s}{label:14s}{time.perf_counter() - before:8.2f}")
