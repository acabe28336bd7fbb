"""Planted faults: small changes of the source, drawn over its rooms, and which tests notice each.

`make mutants` (`python tests/mutants.py --out FILE.json [TEST FILES]`) changes one place of a copy of `src` at a time,
a constant, a sign, an operator, a comparison or a condition, and runs the tests against the copy. Each room has equally
many faults. The file lists each fault with the first test that failed; with `--all`, every test that failed. With
`--compare FILE.json` no fault is planted: of the faults of that file it prints those that the tests of now, a part of
the tests of then, no longer notice. No test notices a fault that changes no result, as in a bound that nobody reaches.
"""

import argparse
import ast
import dataclasses
import json
import os
import random
import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
PACKAGE = Path("src/vibrocap")
SIGNS = {ast.Add: ("+", "-"), ast.Sub: ("-", "+"), ast.Mult: ("*", "/"), ast.Div: ("/", "*")}
COMPARISONS = {ast.Lt: ("<", ">="), ast.LtE: ("<=", ">"), ast.Gt: (">", "<="), ast.GtE: (">=", "<")}
COMPARISONS |= {ast.Eq: ("==", "!="), ast.NotEq: ("!=", "=="), ast.Is: ("is", "is not"), ast.IsNot: ("is not", "is")}
WORDS = {ast.And: ("and", "or"), ast.Or: ("or", "and")}
LONGEST = 900  # seconds, after which tests that hang have noticed


@dataclasses.dataclass(frozen=True)
class Fault:
    """A change of the text of a file between two places (counted in characters)."""

    path: str
    line: int
    start: int
    end: int
    text: str

    def planted(self, source: str) -> str:
        """The source with the fault."""
        return source[: self.start] + self.text + source[self.end :]


def faults_of(path: Path) -> Iterator[Fault]:
    """All faults that a file can have."""
    source = (ROOT / path).read_text(encoding="utf-8")
    lines = [0]
    for line in source.splitlines(keepends=True):
        lines.append(lines[-1] + len(line.encode()))
    raw, tree = source.encode(), ast.parse(source)
    annotations = {id(part) for node in ast.walk(tree) for part in _annotations(node)}

    def place(line: int, column: int) -> int:
        return len(raw[: lines[line - 1] + column].decode())

    def begin(node: ast.expr) -> int:
        return place(node.lineno, node.col_offset)

    def end(node: ast.expr) -> int:
        return place(node.end_lineno or 0, node.end_col_offset or 0)

    def between(left: ast.expr, right: ast.expr, change: tuple[str, str]) -> Iterator[Fault]:
        gap = source[end(left) : begin(right)]
        if (match := re.search(rf"(?<![\w*/<>=]){re.escape(change[0])}(?![\w*/<>=])", gap)) is not None:
            start = end(left) + match.start()
            yield Fault(str(path), left.end_lineno or 0, start, start + len(change[0]), change[1])

    for node in ast.walk(tree):
        if id(node) in annotations:
            continue
        if isinstance(node, ast.Constant) and type(node.value) in (int, float, bool):
            value: Any = node.value
            text = str(not value) if isinstance(value, bool) else repr(value + 1 if value in (0, 1) else 1.5 * value)
            text = repr(2 * value) if type(value) is int and value not in (0, 1) else text
            yield Fault(str(path), node.lineno, begin(node), end(node), text)
        elif isinstance(node, ast.BinOp) and type(node.op) in SIGNS:
            yield from between(node.left, node.right, SIGNS[type(node.op)])
        elif isinstance(node, ast.Compare) and type(node.ops[0]) in COMPARISONS:
            yield from between(node.left, node.comparators[0], COMPARISONS[type(node.ops[0])])
        elif isinstance(node, ast.BoolOp):
            yield from between(node.values[0], node.values[1], WORDS[type(node.op)])
        elif isinstance(node, ast.UnaryOp) and isinstance(node.op, (ast.USub, ast.Not)):
            sign = "-" if isinstance(node.op, ast.USub) else "not"
            yield Fault(str(path), node.lineno, begin(node), begin(node) + len(sign), "")


def _annotations(node: ast.AST) -> Iterator[ast.AST]:
    """All that stands in the annotations of a node."""
    for part in (getattr(node, "annotation", None), getattr(node, "returns", None)):
        if isinstance(part, ast.AST):
            yield from ast.walk(part)


def drawn(count: int, seed: int, rooms: list[str]) -> list[Fault]:
    """So many faults, in turn of each room."""
    chance, pops = random.Random(seed), []
    known = {room: sorted((ROOT / PACKAGE / room).rglob("*.py")) for room in rooms}
    choices = {
        room: [fault for path in paths for fault in faults_of(path.relative_to(ROOT))] for room, paths in known.items()
    }
    while len(pops) < count and any(choices.values()):
        for room in rooms:
            if choices[room] and len(pops) < count:
                pops.append(choices[room].pop(chance.randrange(len(choices[room]))))
    return pops


def noticed(fault: Fault | None, source: Path, tests: list[str], every: bool) -> list[str]:
    """The tests that fail with the fault in a copy of the source, which is restored; None: with no fault."""
    file = source.parent / (fault.path if fault else PACKAGE / "__init__.py")
    whole = file.read_text(encoding="utf-8")
    file.write_text(fault.planted(whole) if fault else whole, encoding="utf-8")
    command = [sys.executable, "-m", "pytest", "-q", "-rfE", "--tb=no", "-p", "no:cacheprovider", *tests]
    try:
        done = subprocess.run(
            command if every else [*command, "-x"],
            cwd=ROOT,
            env=os.environ | {"PYTHONPATH": str(source), "PYTHONDONTWRITEBYTECODE": "1"},
            capture_output=True,
            text=True,
            timeout=LONGEST,
            check=False,
        )
    except subprocess.TimeoutExpired:
        return ["timeout"]
    finally:
        file.write_text(whole, encoding="utf-8")
    failed = re.findall(r"^(?:FAILED|ERROR) (.*?)(?: - .*)?$", done.stdout, re.MULTILINE)
    return failed or (["no start"] if done.returncode not in (0, 5) else [])


def collected(tests: list[str]) -> set[str]:
    """The names of the tests that run now."""
    command = [sys.executable, "-m", "pytest", "-q", "--collect-only", *tests]
    text = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False).stdout
    return {line for line in text.splitlines() if "::" in line}


def compare(rows: list[dict], tests: list[str]) -> int:
    """Print the faults that the tests of now no longer notice; how many."""
    now = collected(tests)
    lost = [
        row for row in rows if row["noticed"] and not any(name in now or "::" not in name for name in row["noticed"])
    ]
    for row in lost:
        print(f"no longer noticed: {row['path']}:{row['line']} {row['change']} ({len(row['noticed'])} tests before)")
    before = sum(bool(row["noticed"]) for row in rows)
    print(f"{before} of {len(rows)} faults noticed before, {before - len(lost)} now, by {len(now)} tests")
    return len(lost)


def main() -> int:
    """Plant faults and write who notices them."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("tests", nargs="*", help="test files; all by default")
    parser.add_argument("--count", type=int, default=200)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--rooms", default="", help="folders of src/vibrocap, with commas between; all by default")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--all", action="store_true", help="all tests that fail, not the first alone")
    parser.add_argument("--out", type=Path)
    parser.add_argument("--compare", type=Path)
    asked = parser.parse_args()
    if asked.compare:
        return 1 if compare(json.loads(asked.compare.read_text(encoding="utf-8")), asked.tests) else 0
    rooms = asked.rooms.split(",") if asked.rooms else []
    rooms = rooms or sorted(path.name for path in (ROOT / PACKAGE).iterdir() if (path / "__init__.py").is_file())
    rows: list[dict] = []
    with tempfile.TemporaryDirectory() as folder, ThreadPoolExecutor(asked.jobs) as pool:
        copies = [Path(folder) / str(i) / "src" for i in range(asked.jobs)]
        for copy in copies:
            shutil.copytree(ROOT / "src", copy, ignore=shutil.ignore_patterns("__pycache__"))
            for beside in {*ROOT.iterdir()} - {ROOT / "src"}:
                (copy.parent / beside.name).symlink_to(beside)
        if failed := noticed(None, copies[0], asked.tests, every=True):
            print("these tests fail without a fault:", *failed)
            return 1

        def run(fault: Fault) -> None:
            copy = copies.pop()
            names = noticed(fault, copy, asked.tests, asked.all)
            copies.append(copy)
            before = (ROOT / fault.path).read_text(encoding="utf-8")[fault.start : fault.end]
            rows.append(
                {"path": fault.path, "line": fault.line, "change": f"{before!r} -> {fault.text!r}", "noticed": names}
            )
            print(f"{fault.path}:{fault.line} {rows[-1]['change']}: {names[0] if names else 'NOT NOTICED'}", flush=True)
            if asked.out:
                asked.out.write_text(json.dumps(rows, indent=1) + "\n", encoding="utf-8")

        list(pool.map(run, drawn(asked.count, asked.seed, rooms)))
    print(f"{sum(bool(row['noticed']) for row in rows)} of {len(rows)} faults noticed")
    return 0


if __name__ == "__main__":
    sys.exit(main())
