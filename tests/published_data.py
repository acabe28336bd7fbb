"""Where the tests find the published measurements: VIBROCAP_DATA, else shared/data beside the repository."""

import os
from pathlib import Path

import pytest

BESIDE = Path(__file__).resolve().parents[2] / "shared" / "data"


def published_folder(name: str) -> Path:
    """The folder of a data set; the test is skipped where there is none."""
    root = Path(os.environ.get("VIBROCAP_DATA") or BESIDE)
    if not (root / name).is_dir():
        pytest.skip(f"no measurements {name!r} here; set VIBROCAP_DATA to the folder that holds them")
    return root / name
