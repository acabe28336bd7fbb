"""Made-up motions whose measures are known in closed form: trigonometric signals as pieces of Taylor series."""

import dataclasses
import math

import numpy as np

import vibrocap as vc
from vibrocap.motion.trajectory import Trajectory
from vibrocap.numerics.api import PieceSeries

ORDER = 16
PIECES = 40  # per period of 2 pi: terms beyond the order are 0.16^17/17!, far below rounding


@dataclasses.dataclass(frozen=True)
class Signal:
    """offset + slope t + sum of amplitude cos(frequency t + phase)."""

    waves: tuple[tuple[float, float, float], ...] = ()
    offset: float = 0.0
    slope: float = 0.0

    def __call__(self, t):
        return self.derivative(t, 0)

    def derivative(self, t, k):
        line = (self.offset + self.slope * t, self.slope + 0.0 * t)[k] if k < 2 else 0.0 * t
        return line + sum(a * w**k * np.cos(w * t + p + k * math.pi / 2) for a, w, p in self.waves)

    @property
    def rate(self):
        return Signal(tuple((a * w, w, p + math.pi / 2) for a, w, p in self.waves), self.slope)


def made_up_motion(law, position, friction, periods=4, rests=(), stuck=(), tolerance=1e-9) -> Trajectory:
    """A motion of period 2 pi with X = position(t), whose friction force is friction(t, side).

    rests: times at which the velocity is zero (pieces are cut there); stuck: (start, end) of phases of side 0
    """
    system = vc.System(machine=vc.PendulumCapsule(), friction=law, drive=vc.Harmonic())
    period = 2 * math.pi
    end = periods * period
    signals = dict.fromkeys(system.state_names, Signal()) | {"position": position, "velocity": position.rate}
    channels = tuple(f"{channel}_work" for channel in system.channels)
    marks = np.unique(np.concatenate((np.linspace(0.0, end, PIECES * periods + 1), rests, *stuck)))
    start, length = marks[:-1], np.diff(marks)
    middle = start + 0.5 * length
    side = np.sign(position.rate(middle))
    for first, last in stuck:
        side[(middle > first) & (middle < last)] = 0.0
    factors = [math.factorial(k) for k in range(ORDER + 1)]
    coefficients = np.array(
        [[signal.derivative(start, k) / factors[k] for k in range(ORDER + 1)] for signal in signals.values()]
    ).transpose(2, 0, 1)
    numbers = np.hstack([coefficients[:, :, 0], coefficients[:, :, 1:].reshape(len(start), -1)])
    marks = period * np.arange(periods + 1)

    def observe(names, t, states, side, drive):
        zero = np.zeros_like(t)
        known = {"friction": lambda: friction(t, side[0]), "contact_velocity": lambda: states[3]}
        known["contact_sliding_work"] = lambda: -friction(t, side[0]) * states[3]
        known["impulse"] = known["friction"]
        return np.array([np.broadcast_to(known.get(name, lambda: zero)(), t.shape) for name in names])

    return Trajectory(
        system=system,
        initial={},
        periods=periods,
        tolerance=tolerance,
        period=period,
        run_status=vc.Status.FINISHED,
        state_names=system.state_names,
        integral_names=(*channels, "impulse"),
        piece_start=start,
        piece_length=length,
        piece_sides=np.asarray(side, dtype=float)[:, None],
        piece_implicit=np.zeros(len(start), bool),
        piece_drive_time=start - period * np.floor(middle / period),
        series=PieceSeries(numbers, (-1,) * len(signals), ORDER),
        sections=np.array([signal(marks) for signal in signals.values()]).T,
        event_times=np.empty(0),
        event_kinds=(),
        event_contacts=np.empty(0, int),
        event_states=np.empty((0, len(signals))),
        observe=observe,
        observable_names=("friction", "contact_velocity", "energy", "contact_energy"),
        certify=lambda motion: None,  # type: ignore[arg-type, return-value]
    )


def paper_system(law, stiffness=2.0, damping=1.0, mass_ratio=2.5, amplitude=1.8, drive=None):
    """The system of the paper's Figs 5-8, or with stiffness 4 and damping 1.2 that of Figs 9-11."""
    machine = vc.PendulumCapsule(mass_ratio=mass_ratio, stiffness=stiffness, damping=damping)
    return vc.System(machine=machine, friction=law, drive=drive or vc.Harmonic(amplitude=amplitude, frequency=1.0))


def paper_motion(law, periods=40, tolerance=1e-10, **parameters):
    """A motion from the paper's start."""
    initial = {"angle": math.pi / 3} | ({"bristle": 0.0026} if law.internal else {})
    return vc.simulate(paper_system(law, **parameters), periods=periods, initial=initial, tolerance=tolerance)
