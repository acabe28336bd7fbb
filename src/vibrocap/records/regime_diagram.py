"""The regimes of many records over stiffness and pulling speed."""

import dataclasses
from collections.abc import Sequence
from typing import Any

import numpy as np

from vibrocap.arguments import ArgumentError
from vibrocap.records.slips.regimes import HALF_STICK_X, STICK_SLIP
from vibrocap.records.stick_slip import StickSlip

NUMBERS = ("stiffness", "pulling_speed", "period", "period_ratio", "stick_fraction", "slip")


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
        rows = []
        for at in order:
            numbers = {name: float(getattr(self, name)[at]) for name in NUMBERS}
            rows.append({"name": self.names[at], "regime": self.regimes[at], **numbers})
        return rows


def regime_diagram(analyses: Sequence[StickSlip]) -> RegimeDiagram:
    """The regimes of many records over stiffness and pulling speed, which each of them has to know. ValueError else."""
    records = list(analyses)
    if not records:
        raise ArgumentError("analyses", "should be at least one StickSlip, got none")
    for at, record in enumerate(records):
        if record.stiffness is None or record.pulling_speed is None:
            what = "stiffness and pulling_speed are needed for its place in the diagram; give them to stick_slip"
            raise ArgumentError(f"analyses[{at}] ({record.name})", what)
    borders, rows = [], []
    for record in records:
        kind = record.regime
        if kind.name == STICK_SLIP and record.release and record.mass and record.stiffness:
            borders.append(record.release.mean * record.stiffness / (2.0 * HALF_STICK_X * record.mass**0.5))
        period, slip = (spread.mean if spread else None for spread in (record.period, record.slip))
        rows.append((record.stiffness, record.pulling_speed, period, kind.period_ratio, kind.stick_fraction, slip))
    return RegimeDiagram(
        names=tuple(record.name for record in records),
        regimes=tuple(record.regime.name for record in records),
        border=float(np.median(borders)) if borders else float("nan"),
        **dict(zip(NUMBERS, np.array(rows, dtype=float).T, strict=True)),
    )
