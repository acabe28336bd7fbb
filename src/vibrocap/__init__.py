"""vibrocap: vibro-driven capsules and the friction dynamics under them."""

from importlib.metadata import version as _version

from vibrocap.drives.biharmonic import Biharmonic
from vibrocap.drives.harmonic import Harmonic
from vibrocap.ensemble import ensemble
from vibrocap.friction.exponential import Exponential
from vibrocap.friction.lugre import LuGre
from vibrocap.machines.pendulum_capsule import PendulumCapsule
from vibrocap.measures.during_run import measure_table, measured
from vibrocap.measures.energy import EnergyBalance, energy_balance
from vibrocap.measures.friction_loop import FrictionCurve, FrictionLoop, friction_curve, friction_loop
from vibrocap.measures.limits import (
    FrictionalLimits,
    boundary_velocity,
    frictional_limits,
    offset_points,
    steady_friction,
    steady_slope,
)
from vibrocap.measures.measure import Measure
from vibrocap.measures.response import ResponseClass, response_class
from vibrocap.measures.settling import Settling, settling
from vibrocap.measures.sticking import StickPhases, stick_fraction, stick_phases, word
from vibrocap.measures.travel import MeanVelocity, displacement, drift, mean_velocity
from vibrocap.scaling import (
    BiharmonicInSI,
    ExponentialInSI,
    HarmonicInSI,
    LuGreInSI,
    PendulumCapsuleInSI,
    Scales,
    SystemInSI,
)
from vibrocap.simulate import simulate
from vibrocap.studies.adaptive import adaptive_map, border
from vibrocap.studies.dataset import open_study
from vibrocap.studies.designs import Design
from vibrocap.studies.export import write_study
from vibrocap.studies.sweep import sweep
from vibrocap.system import System
from vibrocap.trajectory import Certificate, Event, Phase, Status, Trajectory

__version__ = _version("vibrocap")
__all__ = [
    "Biharmonic",
    "Certificate",
    "Event",
    "Exponential",
    "Harmonic",
    "LuGre",
    "PendulumCapsule",
    "Phase",
    "Status",
    "System",
    "Trajectory",
    "simulate",
    "sweep",
    "Design",
    "open_study",
    "write_study",
    "adaptive_map",
    "border",
    "ensemble",
    "Measure",
    "measure_table",
    "measured",
    "displacement",
    "drift",
    "mean_velocity",
    "MeanVelocity",
    "settling",
    "Settling",
    "response_class",
    "ResponseClass",
    "energy_balance",
    "EnergyBalance",
    "stick_fraction",
    "stick_phases",
    "StickPhases",
    "word",
    "friction_loop",
    "FrictionLoop",
    "friction_curve",
    "FrictionCurve",
    "frictional_limits",
    "FrictionalLimits",
    "boundary_velocity",
    "offset_points",
    "steady_friction",
    "steady_slope",
    "Scales",
    "SystemInSI",
    "PendulumCapsuleInSI",
    "ExponentialInSI",
    "LuGreInSI",
    "HarmonicInSI",
    "BiharmonicInSI",
]
