"""What a user's own script may look like; tests/test_installed.py has type checkers read it in their strict mode."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

import vibrocap as vc


def travelled(mass_ratio: float, periods: int = 40) -> tuple[float, bool]:
    """Mean velocity and whether the motion had settled."""
    system = vc.System(
        machine=vc.PendulumCapsule(mass_ratio=mass_ratio, stiffness=2.0, damping=1.0),
        friction=vc.Exponential(),
        drive=vc.Harmonic(amplitude=1.8, frequency=1.0),
    )
    motion: vc.Trajectory = vc.simulate(system, periods=periods, initial={"angle": np.pi / 3}, tolerance=1e-10)
    if not motion.status.ok or not motion.certificate.ok:
        raise RuntimeError(motion.status.text)
    slips = [event.time for event in motion.events if event.kind.startswith("slip")]
    velocity: vc.MeanVelocity = vc.mean_velocity(motion, periods=10)
    print(motion["position"][-1], len(slips), vc.drift(motion), vc.mode_sequence(motion), vc.settling(motion).settled)
    print(
        vc.energy_balance(motion).residual,
        vc.measured(motion, ["drift", "mode_sequence"]),
        vc.response_class(motion).kind,
    )
    return velocity.value, velocity.settled


def in_si() -> vc.System:
    """A machine given in kilograms and metres."""
    bench = vc.System(
        machine=vc.PendulumCapsule.in_si(
            capsule_mass_kg=0.5,
            pendulum_mass_kg=0.2,
            pendulum_length_m=0.1,
            stiffness_N_m_per_rad=0.4,
            damping_N_m_s_per_rad=0.02,
            normal_load="weight",
        ),
        friction=vc.Exponential.in_si(decay_rate_s_per_m=10.0),
        drive=vc.Harmonic.in_si(amplitude_N_m=0.35, frequency_Hz=1.6),
    )
    motion = vc.simulate(bench, periods=2)
    print(bench.si.factor("position"), motion["position"][-1], motion.unit_of("position"))
    return bench


def steady_motions(system: vc.System) -> list[str]:
    """Orbits, branches and basins."""
    orbit = vc.orbit(system.with_parameters({"machine.mass_ratio": 4.0, "machine.normal_load": "weight"}))
    branch = vc.branch(system, "drive.amplitude", (1.0, 2.0))
    basins = vc.basins(system, {"angle": (-1.0, 1.0), "angle_rate": (-1.0, 1.0)}, 10)
    places = vc.crossing(system, "drift", "machine.mass_ratio", (1.0, 3.0))
    print(orbit.drift, orbit.multipliers, branch.parameter, basins.label, [place.at for place in places.found])
    return [orbit.status.advice, *(end.advice for end in branch.ends)]


def sweeps(system: vc.System, folder: Path) -> Path:
    """Many motions."""
    study = vc.sweep(
        system,
        {"machine.mass_ratio": np.linspace(1.0, 3.0, 5)},
        measures=["mean_velocity"],
        out=folder,
        periods=60,
        tolerance=1e-8,
        settle=0,
    )
    design = vc.Design("sobol", runs=16)
    spread = vc.sweep(
        system, {"machine.mass_ratio": (1.0, 3.0)}, design=design, settle=1e-5, periods=60, tolerance=1e-8
    )
    results = vc.ensemble(system, {"machine.mass_ratio": [1.0, 2.0]}, periods=3)
    print(
        study["mean_velocity"].values,
        spread.sizes,
        results["mean_velocity"].mean(),
        vc.measure_table()["mode_sequence"].meaning,
    )
    return vc.write_study(vc.open_study(folder), "study.nc")


def friction(law: vc.LuGre, files: Sequence[Path]) -> dict[str, float]:
    """Canonical tests, limits and a fit."""
    sheet, limits = vc.test_sheet(law), vc.frictional_limits(law)
    wrapped = vc.anisotropic(vc.Coulomb)(forward_ratio=1.0, back_ratio=1.3)
    fitted = vc.fit([vc.prepared(record) for path in files for record in vc.read_records(path)], "lugre")
    print(vc.__version__, sheet.creep.creeps, limits.breakaway_force, wrapped, fitted.summary(), fitted.ok)
    return {parameter.name: parameter.value for parameter in fitted.parameters}
