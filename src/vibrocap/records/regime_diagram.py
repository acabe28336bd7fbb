"""The regimes of many records over stiffness and pulling speed."""

import dataclasses
from collections.abc import Sequence
from typing import Any

import numpy as np

from vibrocap.arguments import ArgumentError
from vibrocap.records.slips.regimes import HALF_STICK_X, STICK_SLIP
from vibrocap.records.stick_slip import StickSlip


@dataclasses.dataclass(frozen=True, eq=False)
class RegimeDiagram:
    """Regimes of many records over stiffness and pulling speed: arrays [n] in the order of the records.

    stiffness [N/m], pulling_speed [m/s], names, regimes (words), period [s] and slip [m] (means of main
    slips), period_ratio (typical period over 2 pi sqrt(m/k)), stick_fraction; NaN where a record does not tell
    border: speed [m/s] times sqrt(stiffness) [N/m] at which a Coulomb block sticks for half of its period, from the
    falls of the records: V sqrt(k) = dF/(2 x sqrt(m)), x = w D/V = 1.808; NaN where no mass is known
    """

    names: tuple[str, ...]
    stiffness: np.ndarray
    pulling_speed: np.ndarray
    regimes: tuple[str, ...]
    period: np.ndarray
    period_ratio: np.ndarray
    stick_fraction: np.ndarray
    slip: np.ndarray
    border: float

    def table(self) -> list[dict[str, Any]]:
        """A row for each record, by column name, sorted by stiffness and speed."""
        order = np.lexsort((self.pulling_speed, self.stiffness))
        numbers = ("stiffness", "pulling_speed", "period", "period_ratio", "stick_fraction", "slip")
        return [
            {"name": self.names[at], "regime": self.regimes[at]}
            | {name: float(getattr(self, name)[at]) for name in numbers}
            for at in order
        ]


def regime_diagram(found: Sequence[StickSlip]) -> RegimeDiagram:
    """The regimes of many records over stiffness and pulling speed, which each of them has to know. ValueError else."""
    found = list(found)
    if not found:
        raise ArgumentError("found", "should be at least one StickSlip, got none")
    for at, each in enumerate(found):
        if each.stiffness is None or each.pulling_speed is None:
            what = "stiffness and pulling_speed are needed for its place in the diagram; give them to stick_slip"
            raise ArgumentError(f"found[{at}] ({each.name})", what)
    borders = [
        each.release.mean * each.stiffness / (2.0 * HALF_STICK_X * each.mass**0.5)
        for each in found
        if each.regime.name == STICK_SLIP and each.release and each.mass and each.stiffness
    ]
    return RegimeDiagram(
        names=tuple(each.name for each in found),
        stiffness=np.array([each.stiffness for each in found], dtype=float),
        pulling_speed=np.array([each.pulling_speed for each in found], dtype=float),
        regimes=tuple(each.regime.name for each in found),
        period=_column(each.period.mean if each.period else None for each in found),
        period_ratio=_column(each.regime.period_ratio for each in found),
        stick_fraction=_column(each.regime.stick_fraction for each in found),
        slip=_column(each.slip.mean if each.slip else None for each in found),
        border=float(np.median(borders)) if borders else float("nan"),
    )


def _column(values: Any) -> np.ndarray:
    return np.array([np.nan if value is None else value for value in values], dtype=float)
