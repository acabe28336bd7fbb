"""Results and records as JSON, in full precision."""

import enum
import json
import math
from typing import Any

import numpy as np

from vibrocap.quantities.declared import WithUnit
from vibrocap.quantities.dimensional import view


def plain(value: Any) -> Any:
    """The same with JSON's own types only.

    A number with a unit becomes {"value", "unit", "dimensionless"}, the last where scales are known; results become
    their records (`view`), arrays and tuples lists; complex numbers {"real", "imaginary"}, numbers that JSON does not
    know None.
    """
    if isinstance(value, WithUnit):
        bare = {} if value.dimensionless is None else {"dimensionless": plain(value.dimensionless)}
        return {"value": plain(value.value), "unit": value.unit} | bare
    if isinstance(value, dict):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain(item) for item in value]
    if isinstance(value, (np.ndarray, np.generic)):
        return plain(value.tolist())
    if isinstance(value, enum.Enum):
        return plain(value.value)
    if value is None or isinstance(value, (bool, int, str)):
        return value
    if isinstance(value, complex):
        return {"real": plain(value.real), "imaginary": plain(value.imag)}
    return (float(value) if math.isfinite(value) else None) if isinstance(value, float) else plain(view(value))


def json_text(record: Any) -> str:
    """A result, or what is known by name, as one JSON object in full precision."""
    return json.dumps(plain(record), indent=2, ensure_ascii=False, allow_nan=False)
