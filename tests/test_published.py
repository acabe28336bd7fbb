"""Published cases (examples/published/): every row of their table agrees, or differs as it says, and is right."""

import importlib.util
from pathlib import Path

import pytest

FOLDER = Path(__file__).resolve().parents[1] / "examples" / "published"
SPEC = importlib.util.spec_from_file_location("published", FOLDER / "published.py")
published = importlib.util.module_from_spec(SPEC)
SPEC.loader.exec_module(published)
pytestmark = pytest.mark.plain
ROWS = {row["case"]: row for row in published.rows()}
FAST = (  # they share three kernels
    "siconos-friction-oscillator",
    "siconos-impacts",
    "siconos-ball-between-walls",
    "modelica-elastogap",
    "code-aster-friction",
    "code-aster-shock",
    "code-aster-wall",
)


@pytest.mark.parametrize("case", [pytest.param(name, marks=() if name in FAST else pytest.mark.slow) for name in ROWS])
def test_row(case):
    for value in published.values(ROWS[case]):
        of = value.entry["of"]
        assert value.right, (of, value.ours)
        assert value.agrees is ("why" not in value.entry), (of, value.ours)
        if "motion" in value.run:
            assert value.run["motion"].certificate.ok, of


def test_table_has_every_file_and_the_page_every_value():
    assert len(ROWS) >= 25
    assert {f"{name}.toml" for name in ROWS} | {"table.toml"} == {path.name for path in FOLDER.glob("*.toml")}
    for row in ROWS.values():
        assert row["gives"] in ("number", "formula", "problem")
        assert all("published" in entry or "right" in entry for entry in row["value"])
    line = published.page(["code-aster-friction"]).splitlines()[-2]
    assert line.endswith("| place of rest, m | 0.00005 | 0.00005 | agrees |")


@pytest.mark.parametrize(
    ("printed", "ours", "agrees"),
    [("1.067", 1.0674, True), ("1.067", 1.0676, False), ("2500000", 2500000.4, True), ("0.5", 0.5 + 1e-15, True)],
)
def test_digits_that_are_printed_make_the_tolerance(printed, ours, agrees):
    assert published.Value({}, {"published": printed}, ours, {}).agrees is agrees
