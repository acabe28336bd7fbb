"""Parts of one's own: `--parts FILE`, which every command takes that knows parts by name, and their check."""

import dataclasses
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from vibrocap.cli.refusal import Refusal
from vibrocap.cli.terminal import progress


def load(files: Iterable[Path]) -> None:
    """Register the parts of files; Refusal, with every file that cannot be used."""
    from vibrocap.physics.part_files import PartsError, load_parts

    complaints = []
    for path in files:
        try:
            load_parts(path)
        except PartsError as error:
            complaints.append(f"--parts: {error}")
    if complaints:
        raise Refusal(*complaints)


def checked(parts: Iterable[Any], motion: bool) -> tuple[dict[str, Any], str, bool]:
    """Whether parts keep their contracts: (record, text, whether all do). motion: with a short motion of each."""
    from vibrocap.contracts.check_part import check_part

    reports = []
    for part in parts:
        with progress(f"Checking {part.name}"):
            reports.append(check_part(part, motion=motion))
    record = {"parts": [dataclasses.asdict(report) | {"ok": report.ok} for report in reports]}
    return record, "\n\n".join(map(str, reports)), all(report.ok for report in reports)
