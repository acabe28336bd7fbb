"""The sweeps that the benchmarks run, as bare numbers for every competitor, and how wrong their final states are.

Figs 9-11 of the paper: the capsule over its mass ratio, from a light to a heavy one, 50 drive periods each. A sweep
counts as accurate to 1e-6 when 99 % of its motions end within 1e-6 of the reference: some end near a fold of their
flow (a sliding capsule that just stops, or just does not), where no solver is right at the cost of the others.

`python -m benchmarks.named_sweeps [vibrocap heyoka numba diffrax scipy]` runs these alone, in turn.
"""

import functools
import importlib
import math
import statistics
import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from types import SimpleNamespace

import numpy as np

SWEEP_SET = SimpleNamespace(
    stiffness=4.0,
    damping=1.2,
    normal_load=1.0,
    amplitude=1.8,
    frequency=1.0,
    coulomb_coefficient=0.15,
    static_coefficient=0.45,
    decay_rate=10.0,
    bristle_stiffness=100.0,
    bristle_damping=10.0,
    viscous_damping=0.0,
    stribeck_velocity=0.1,
    stribeck_exponent=2.0,
)
MASS_RATIOS = np.linspace(0.01, 8.1, 1000)
PERIODS = 50
END = PERIODS * 2.0 * math.pi / SWEEP_SET.frequency
ERROR_ASKED = 1e-6
SHARE_ASKED = 0.99
INITIAL = {
    "exponential": (math.pi / 3, 0.0, 0.0, 0.0),
    "lugre": (math.pi / 3, 0.0, 0.0, 0.0, 0.0026),
}

Sweep = Callable[[], np.ndarray]


@dataclass(frozen=True)
class Peer:
    """A competitor: a module of this folder, its function that prepares a sweep, and every how many-th run it makes."""

    label: str
    module: str
    prepare: str = "prepare_sweep"
    every: int = 1

    def prepared(self, law: str, threads: int = 1) -> Sweep | None:
        """Compiled and warm; None where it has no version for so many threads. ImportError: it is missing."""
        module = importlib.import_module(f"benchmarks.{self.module}")
        return getattr(module, self.prepare)(law, every(self.every), threads)


PEERS = (
    Peer("vibrocap", "sweep_vibrocap"),
    Peer("heyoka, batch", "sweep_peers_heyoka"),
    Peer("heyoka, its ensemble", "sweep_peers_heyoka", prepare="prepare_ensemble"),
    Peer("Numba loop, events located", "sweep_peers_numba"),
    Peer("Numba loop, |v| as written", "sweep_peers_numba", prepare="prepare_plain_sweep"),
    Peer("diffrax, vmap (Tsit5)", "sweep_peers_diffrax", every=10),
    Peer("SciPy, DOP853", "sweep_peers_scipy", every=100),
)


def every(n: int) -> np.ndarray:
    """Every n-th mass ratio, for a peer too slow for all of them: it meets light and heavy capsules alike."""
    return MASS_RATIOS[n // 2 :: n].copy()


@functools.cache
def _reference(law: str) -> np.ndarray | None:
    """Final states [1000, states] from heyoka at the rounding level (3 to 5 s); None where heyoka is missing."""
    try:
        from benchmarks import sweep_peers_heyoka
    except ImportError:
        return None
    return sweep_peers_heyoka.reference_states(law, MASS_RATIOS)


def errors(law: str, masses: np.ndarray, final_states: np.ndarray) -> np.ndarray:
    """Largest error over the states of each run, NaN where there is no reference; `masses` come from MASS_RATIOS."""
    reference = _reference(law)
    if reference is None:
        return np.full(len(masses), np.nan)
    largest = np.max(np.abs(final_states - reference[np.searchsorted(MASS_RATIOS, masses)]), axis=1)
    return np.where(np.isfinite(largest), largest, np.inf)


def error_share(law: str, masses: np.ndarray, final_states: np.ndarray) -> float:
    """The error within which 99 % of the runs end (of less than a hundred: all)."""
    allowed = int(len(masses) * (1.0 - SHARE_ASKED))
    return float(np.sort(errors(law, masses, final_states))[-1 - allowed])


def nanoseconds(seconds: float, runs: int) -> float:
    """Time per trajectory and drive period."""
    return seconds / runs / PERIODS * 1e9


def compare(law: str, threads: int, peers: Sequence[Peer], rounds: int = 5) -> None:
    """Run the peers in turn and print for each the median time, its ratio to the first, the error and the runs."""
    print(f"\n{law}, {threads} thread{'s'[: threads - 1]}: error asked {ERROR_ASKED:g}")
    sweeps: dict[Peer, Sweep] = {}
    for peer in peers:
        try:
            sweep = peer.prepared(law, threads)
        except ImportError as error:
            print(f"  {peer.label}: missing ({error.name})")
            continue
        if sweep is not None:
            sweeps[peer] = sweep
    times: dict[Peer, list[float]] = {peer: [] for peer in sweeps}
    final = {}
    for _ in range(rounds):
        for peer, sweep in sweeps.items():
            before = time.perf_counter()
            final[peer] = sweep(periods=60, tolerance=1e-8, settle=0)
            times[peer].append(time.perf_counter() - before)
    first = None
    print(f"  {'':30s}{'ns/run/period':>14s}{'ratio':>9s}{'99 % error':>12s}{'runs':>7s}")
    for peer, measured in times.items():
        masses = every(peer.every)
        spent = nanoseconds(statistics.median(measured), len(masses))
        first = first or spent
        error = error_share(law, masses, final[peer])
        missed = "  above the error asked" if error > ERROR_ASKED else ""
        print(f"  {peer.label:30s}{spent:14,.0f}{spent / first:9.2f}{error:12.1e}{len(masses):7d}{missed}")


def main() -> None:
    """Compare all peers, or those whose label begins with a word of the command line."""
    words = tuple(word.lower() for word in sys.argv[1:])
    peers = [peer for peer in PEERS if not words or peer.label.lower().startswith(words)]
    for law in INITIAL:
        for threads in (1, 2):
            compare(law, threads, peers)


if __name__ == "__main__":
    main()
