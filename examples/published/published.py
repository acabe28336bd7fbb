"""Published cases, computed again: prints docs/published.md from table.toml, or from the rows that are named.

python examples/published/published.py
python examples/published/published.py newmark-block bouncing-ball
"""

import dataclasses
import functools
import math
import sys
import tomllib
from decimal import Decimal
from pathlib import Path
from typing import Any

import numpy as np

import vibrocap as vc

HERE = Path(__file__).resolve().parent
ROUNDING = 64 * sys.float_info.epsilon
HEAD = """# Published cases

Problems that others published, run by vibrocap. The source prints a *number*, or has a *formula*, evaluated here, or
states the *problem* only; then the number is that of a closed form or of an independent event-driven solver. A number
agrees to half a unit of its last digit. Every case is a file in `examples/published/` for any command; its table says
how each value is computed, and `python examples/published/published.py` computes them again.

| case | source | gives | value | published | vibrocap | verdict |
| --- | --- | --- | --- | ---: | ---: | --- |
"""
MAKERS = {"motion": lambda run: run["case"].simulate(), "orbit": lambda run: vc.orbit(run["case"])}


class Run(dict):
    """What the expressions of the table know: the case at once, its motion and its cycle when they are asked for."""

    def __missing__(self, name: str) -> Any:
        if name not in MAKERS:
            raise KeyError(name)
        self[name] = MAKERS[name](self)
        return self[name]


@functools.cache
def run_of(name: str, parts: str | None, changes: tuple[tuple[str, float], ...]) -> Run:
    """The run of a case file with changes."""
    if parts:
        vc.load_parts(HERE / parts)
    return Run(case=vc.read_case(HERE / f"{name}.toml", dict(changes)), vc=vc, np=np, math=math)


def half_unit(printed: str) -> float:
    """Half a unit of the last digit of a number as it is printed, or the rounding of doubles if that is more."""
    return max(0.5 * 10.0 ** int(Decimal(printed).as_tuple().exponent), ROUNDING * abs(float(printed)))


@dataclasses.dataclass(frozen=True)
class Value:
    """A value of the table, computed again.

    agrees: with the published number, or, where the source prints none, with the right one; right: with the right one
    """

    row: dict
    entry: dict
    ours: float
    run: dict

    @property
    def reference(self) -> str:
        return self.entry.get("published") or self.entry["right"]

    @property
    def agrees(self) -> bool:
        most = half_unit(self.reference) + self.entry.get("uncertainty", 0.0)
        return abs(self.ours - float(self.reference)) <= most

    @property
    def right(self) -> bool:
        known = self.entry.get("right")
        return known is None or abs(self.ours - float(known)) <= half_unit(known)

    @property
    def line(self) -> str:
        """The row of the page."""
        digits = max(-int(Decimal(self.entry.get("right") or self.reference).as_tuple().exponent), 0)
        gives = self.row["gives"] if "published" in self.entry else "problem"
        verdict = "agrees" if self.agrees else f"differs: {self.entry.get('why', 'not explained')}"
        cells = (self.row["title"], self.row["source"], gives, self.entry["of"], self.reference)
        return "| " + " | ".join((*cells, f"{self.ours:.{digits}f}", verdict)) + " |"


def rows(names: list[str] | None = None) -> list[dict]:
    """The rows of the table, or those of some cases."""
    table = tomllib.loads((HERE / "table.toml").read_text(encoding="utf-8"))["row"]
    unknown = set(names or ()) - {row["case"] for row in table}
    if unknown:
        sys.exit(f"no such case: {', '.join(sorted(unknown))}")
    return [row for row in table if not names or row["case"] in names]


def values(row: dict) -> list[Value]:
    """The values of a row, computed again."""
    values = []
    for entry in row["value"]:
        run = run_of(row["case"], row.get("parts"), tuple(sorted(entry.get("set", {}).items())))
        values.append(Value(row, entry, float(eval(entry["ours"], {}, run)), run))
    return values


def page(names: list[str] | None = None) -> str:
    """The page of the documentation."""
    return HEAD + "\n".join(value.line for row in rows(names) for value in values(row)) + "\n"


if __name__ == "__main__":
    print(page(sys.argv[1:]), end="")
