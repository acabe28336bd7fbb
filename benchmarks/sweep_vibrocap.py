"""This engine on the named sweeps."""

import numpy as np

import vibrocap as vc
from benchmarks.named_sweeps import INITIAL, PERIODS, SWEEP_SET, Sweep
from vibrocap.motion.recording.equations import equations, parameter_values
from vibrocap.numerics.run.budget import Budget, EnsembleStart
from vibrocap.numerics.run.ensemble import ensemble_run

# The largest with two digits at which 99 % of the runs end within the error asked.
TOLERANCE = {"exponential": 5.9e-8, "lugre": 2.0e-7}
LAWS = {"exponential": vc.Exponential, "lugre": vc.LuGre}


def problem(law: str, masses: np.ndarray) -> tuple:
    """(equations, parameters, initial) of a named sweep."""
    machine = vc.PendulumCapsule(stiffness=SWEEP_SET.stiffness, damping=SWEEP_SET.damping)
    drive = vc.Harmonic(amplitude=SWEEP_SET.amplitude, frequency=SWEEP_SET.frequency)
    system = vc.System(machine, LAWS[law](), drive)
    recorded = equations(system)
    parameters = np.tile(parameter_values(system), (len(masses), 1))
    parameters[:, recorded.parameter_paths.index("machine.mass_ratio")] = masses
    return recorded, parameters, np.tile(INITIAL[law], (len(masses), 1))


def budget(law: str) -> Budget:
    """Every run to its end; only its states are kept, as the peers do."""
    return Budget(PERIODS, TOLERANCE[law], 10_000, 50_000_000, window=1)


def prepare_sweep(law: str, masses: np.ndarray, threads: int = 1) -> Sweep:
    """The sweep, compiled and warm."""
    arguments = problem(law, masses)

    def run() -> np.ndarray:
        return ensemble_run(EnsembleStart(*arguments), budget(law), threads=threads).state

    run()
    return run
