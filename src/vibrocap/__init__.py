"""vibrocap: vibro-driven capsules and the friction dynamics under them."""

from importlib.metadata import version as _version

from vibrocap.drives.biharmonic import Biharmonic
from vibrocap.drives.harmonic import Harmonic
from vibrocap.friction.exponential import Exponential
from vibrocap.friction.lugre import LuGre
from vibrocap.machines.pendulum_capsule import PendulumCapsule
from vibrocap.simulate import simulate
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
]
