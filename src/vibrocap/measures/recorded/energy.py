"""Where the energy goes: the work of every channel over a window, and what the balance leaves over."""

import dataclasses
from collections.abc import Mapping
from typing import Annotated, Any, ClassVar

from vibrocap.measures.recorded.windows import window_times
from vibrocap.motion.trajectory import Trajectory
from vibrocap.physics.names import name_and_number
from vibrocap.quantities.declared import Context, Declared, Number, Time
from vibrocap.quantities.dimensional import Dimensional


class OfBalance(Declared):
    """A work, or a power where the balance is one of powers."""

    def unit(self, context: Context) -> str:
        return context.around[0].work_unit


class OfChannels(OfBalance):
    """The same by channel."""

    def seen(self, value: Any, context: Context) -> Any:
        return {name: super(OfChannels, self).seen(work, context) for name, work in value.items()}

    def converted(self, value: Any, context: Context, back: bool = False) -> Any:
        return {name: super(OfChannels, self).converted(work, context, back) for name, work in value.items()}


Work = Annotated[float, OfBalance()]
Works = Annotated[Mapping[str, float], OfChannels()]


@dataclasses.dataclass(frozen=True)
class EnergyBalance(Dimensional):
    """Work over a window, positive into the system, and the change of the stored energy.

    drive, damper, belt, impact: work of the machine's channels (0 for a channel that it does not have)
    controller: work of the command of a controller, in place of that of the drive
    drag, outer_force, gravity: work of the environment's, gravity's along a slope (0 without an environment)
    own: work of channels that a machine of one's own names otherwise, by name
    contact_sliding, bristle_loss: work of friction at all contacts, split at the bristles
    contact_storage: what bristles gave back less what they took, under a load that follows the motion (otherwise 0: it
    is in `stored`)
    stored: change of the energy of machine and contact (bristles); 0 over a period of a steady motion
    residual: stored less all works, 0 but for the error of the motion
    window: (start, end) in time; periods: its length in drive periods
    channels: works that the system has, which its views show
    """

    drive: Work
    damper: Work
    contact_sliding: Work
    bristle_loss: Work
    stored: Work
    residual: Work
    window: tuple[Time, Time]
    periods: Number
    belt: Work = 0.0
    impact: Work = 0.0
    controller: Work = 0.0
    contact_storage: Work = 0.0
    drag: Work = 0.0
    outer_force: Work = 0.0
    gravity: Work = 0.0
    own: Works = dataclasses.field(default_factory=dict)
    channels: tuple[str, ...] = ()

    work_unit: ClassVar[str] = "J"

    @property
    def in_record(self) -> str:  # type: ignore[override]
        """Works of the system's own channels, and what they sum up to."""
        return " ".join([*self.channels, "own" * bool(self.own), "contact_storage stored residual window periods"])

    @property
    def per_period(self) -> "EnergyBalance":
        """The same, per drive period."""
        return self._over(self.periods)

    @property
    def mean_power(self) -> "MeanPower":
        """The same, per unit of time."""
        return MeanPower(**vars(self._over(self.window[1] - self.window[0])))

    @property
    def friction(self) -> Work:
        """Work of friction at all contacts, `contact_storage` included."""
        return self.contact_sliding + self.bristle_loss + self.contact_storage

    def _over(self, divisor: float) -> "EnergyBalance":
        kept = ("window", "periods", "own", "channels")
        works = {name: work / divisor for name, work in vars(self).items() if name not in kept}
        own = {name: work / divisor for name, work in self.own.items()}
        return dataclasses.replace(self, **works, own=own)


@dataclasses.dataclass(frozen=True)
class MeanPower(EnergyBalance):
    """The mean power of each channel over a window, under the names of an `EnergyBalance`."""

    work_unit: ClassVar[str] = "W"


def energy_balance(
    motion: Trajectory, window: tuple[Time, Time] | None = None, *, periods: int | None = None
) -> EnergyBalance:
    """Work by channel over a window (`windows.window_times`).

    What the drive puts in is stored or lost in the damper and in the contact:

        d(stored)/dt = drive theta' - nu theta'^2 - R X'

    The works are integrals of the powers along the motion, the stored energy is a closed form of its states at both
    ends: their difference, the residual, is the error of the motion itself.
    """
    start, end = window_times(motion, window, periods)
    before, after = motion.integrals([start, end]).T
    works, known = {"drive": 0.0, "damper": 0.0}, {field.name for field in dataclasses.fields(EnergyBalance)}
    for i, channel in enumerate(motion.system.channels):  # that of a further contact ends in its number
        name, _ = name_and_number(channel)
        works[name] = works.get(name, 0.0) + float(after[i] - before[i])
    stored = motion.at([start, end], "energy") + motion.at([start, end], "contact_energy")
    gained = float(stored[1] - stored[0])
    left_out = ("contact_storage", "drive") if "controller" in works else ("contact_storage",)
    return EnergyBalance(
        **{name: work for name, work in works.items() if name in known},
        own={name: work for name, work in works.items() if name not in known},
        channels=tuple(name for name in works if name in known and name not in left_out),
        stored=gained,
        residual=gained - sum(works.values()),
        window=(start, end),
        periods=(end - start) / motion.period if periods is None else float(periods),
    )
