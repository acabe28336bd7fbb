"""How long a first call takes, in a process of its own: with no kernel kept, with all kept, for new numbers.

The package and its libraries have their bytecode, as where pip has put them: it is kept in a folder of this benchmark,
also where PYTHONDONTWRITEBYTECODE is set, and one call of everything that is measured fills it before.
Beside it what the peers take from their import to the end of their first motion or sweep, where they are installed.
Processor seconds are those of the process; on a busy machine they say more than the clock.
"""

import importlib.util
import os
import pathlib
import resource
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
SHORT = ("--help", "new", "--completion bash")  # commands that compute nothing
BYTECODE = tempfile.TemporaryDirectory()
SWEEP = ("--tolerance", "1e-8", "--over", "drive.amplitude=1:2:8", "--out")
PEERS = {
    "heyoka": ("heyoka", "from benchmarks.peers_heyoka import prepare_{law}; prepare_{law}()()"),
    "Numba": (
        "numba",
        "import numpy; from benchmarks.sweep_peers_numba import prepare_sweep; "
        "prepare_sweep('{law}', numpy.array([2.5]), 1)()",
    ),
}


def main() -> None:
    """Print seconds per call, each in a process of its own."""
    print("\nThe first call of a new process, seconds: by the clock, of the processor")
    with tempfile.TemporaryDirectory() as folder:
        _warm(folder)
        _row("import vibrocap", "", _seconds(folder, "-c", "import vibrocap"))
        for words in SHORT:
            _row(f"vibrocap {words}", "", _seconds(folder, "-m", "vibrocap", *words.split()))
        for law in ("exponential", "lugre"):
            for command in ("simulate", "orbit", "sweep"):
                kept = str(pathlib.Path(folder, f"kernels-{law}-{command}"))
                for label, mass_ratio in (("nothing kept", 2.5), ("second call", 2.5), ("new numbers", 3.7)):
                    case = pathlib.Path(folder, "case.toml")
                    case.write_text(CASE.format(law=law, mass_ratio=mass_ratio))
                    more = (*SWEEP, str(pathlib.Path(folder, f"{law} {label}"))) if command == "sweep" else ("--json",)
                    seconds = _seconds(kept, "-m", "vibrocap", command, str(case), *more)
                    _row(f"{command}, {law}", label, seconds)
            for peer, (module, code) in PEERS.items():
                if importlib.util.find_spec(module) is not None:
                    _row(f"{peer}, {law}", "its first call", _seconds(folder, "-c", code.format(law=law)))


def _warm(folder: str) -> None:
    """Let Python keep its bytecode."""
    case = pathlib.Path(folder, "warm.toml")
    case.write_text(CASE.format(law="exponential", mass_ratio=2.5))
    for command in ("simulate", "orbit", "sweep"):
        more = (*SWEEP, str(pathlib.Path(folder, "warm"))) if command == "sweep" else ("--json",)
        _seconds(str(pathlib.Path(folder, "kernels-warm")), "-m", "vibrocap", command, str(case), *more)
    for words in SHORT:
        _seconds(folder, "-m", "vibrocap", *words.split())


def _seconds(kernels: str, *arguments: str) -> tuple[float, float]:
    """(by the clock, of the processor) of a process of Python that keeps its kernels there."""
    before, used = time.perf_counter(), resource.getrusage(resource.RUSAGE_CHILDREN)
    environment = os.environ | {"VIBROCAP_CACHE": kernels, "PYTHONPYCACHEPREFIX": BYTECODE.name}
    environment.pop("PYTHONDONTWRITEBYTECODE", None)
    subprocess.run([sys.executable, *arguments], check=True, capture_output=True, env=environment)
    now = resource.getrusage(resource.RUSAGE_CHILDREN)
    return time.perf_counter() - before, now.ru_utime + now.ru_stime - used.ru_utime - used.ru_stime


def _row(name: str, label: str, found: tuple[float, float]) -> None:
    print(f"  {name:24s}{label:16s}{found[0]:8.2f}{found[1]:8.2f}")


if __name__ == "__main__":
    main()
