"""JSON in full precision."""

import json
import math
from typing import Any


def plain(value: Any) -> Any:
    """The same with JSON's own types only: tuples become lists, and numbers that JSON does not know become None."""
    if isinstance(value, dict):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain(item) for item in value]
    if value is None or isinstance(value, (bool, int, str)):
        return value
    return float(value) if math.isfinite(value) else None


def in_both(record: dict[str, Any], units: dict[str, Any], dimensionless: dict[str, Any]) -> dict[str, Any]:
    """A record in SI with the `units` of what has one and, under `dimensionless`, the same values without units."""
    return {**record, "units": units, "dimensionless": {name: dimensionless.get(name) for name in units}}


def json_text(record: Any) -> str:
    """One JSON object in full precision."""
    return json.dumps(plain(record), indent=2, ensure_ascii=False, allow_nan=False)
