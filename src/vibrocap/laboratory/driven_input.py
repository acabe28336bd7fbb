"""What is given to a driven law, checked: an imposed motion, states at its start, parameter sets."""

from typing import Any

import numpy as np

from vibrocap.arguments import ArgumentError, suggestion
from vibrocap.physics.friction.law import Law
from vibrocap.physics.parameters import parameter_table


def _numbers(name: str, values: Any) -> np.ndarray:
    """Finite numbers [n]."""
    try:
        found = np.asarray(values, dtype=float)
    except (TypeError, ValueError) as error:
        raise ValueError(f"{name} should be numbers, got {values!r}") from error
    if found.ndim != 1:
        raise ValueError(f"{name} should be a list of numbers, got an array of shape {found.shape}")
    if not np.isfinite(found).all():
        i = int(np.argmin(np.isfinite(found)))
        raise ValueError(f"{name} should be finite, got {found[i]} at sample {i}")
    return found


def imposed_motion(law: Law, time: Any, velocity: Any, load: Any, tolerance: float) -> np.ndarray:
    """Time, velocity and load: [3, n]."""
    if not isinstance(law, Law):
        raise ValueError(f"law should be a friction law such as LuGre(), got {law!r}")
    t, v = _numbers("time", time), _numbers("velocity", velocity)
    if len(t) < 2:
        raise ValueError(f"time should have at least 2 samples, got {len(t)}")
    if len(v) != len(t):
        raise ValueError(f"velocity should have as many samples as time ({len(t)}), got {len(v)}")
    if not (np.diff(t) > 0.0).all():
        i = int(np.argmin(np.diff(t) > 0.0)) + 1
        raise ValueError(f"time should increase from sample to sample, got {t[i]} after {t[i - 1]} at sample {i}")
    w = np.full(len(t), _numbers("load", [load])[0]) if np.ndim(load) == 0 else _numbers("load", load)
    if len(w) != len(t):
        raise ValueError(f"load should be a number or have as many samples as time ({len(t)}), got {len(w)}")
    if law.internal and not (w > 0.0).all():
        raise ValueError(f"load should be > 0 with the {law.name} law, got {w.min()} at sample {int(np.argmin(w))}")
    if not (w >= 0.0).all():
        raise ValueError(f"load should be >= 0, got {w.min()} at sample {int(np.argmin(w))}")
    if isinstance(tolerance, bool) or not isinstance(tolerance, (int, float)) or not 1e-14 <= tolerance < 1.0:
        raise ValueError(f"tolerance should be between 1e-14 and 1, got {tolerance!r}")
    return np.stack([t, v, w])


def start_states(law: Law, internal: Any, runs: int) -> np.ndarray:
    """Internal states at the start: [runs, k]."""
    k = len(law.internal)
    if internal is None:
        return np.zeros((runs, k))
    found = np.atleast_1d(np.asarray(internal, dtype=float))
    if found.shape not in ((k,), (runs, k)):
        raise ValueError(
            f"internal should have the {k} internal states of the {law.name} law "
            f"({', '.join(law.internal) or 'none'}), got an array of shape {found.shape}"
        )
    if not np.isfinite(found).all():
        raise ValueError(f"internal should be finite, got {internal!r}")
    return np.array(np.broadcast_to(found, (runs, k)))


def parameter_sets(law: Law, values: Any, names: tuple[str, ...]) -> np.ndarray:
    """Parameter sets: [m, p]."""
    known = [info.name for info in parameter_table(law) if isinstance(getattr(law, info.name), (int, float))]
    for name in names:
        if name not in known:
            near = suggestion(name, known, cutoff=0.0)
            raise ArgumentError("names", f"should be parameters of the {law.name} law, got {name!r}; {near}")
    if len(set(names)) != len(names):
        raise ValueError(f"names should differ, got {', '.join(names)}")
    table = np.asarray(values, dtype=float)
    if table.ndim != 2 or table.shape[1] != len(names) or len(table) == 0:
        raise ValueError(
            f"values should have one row per parameter set and one column per name ({len(names)}), "
            f"got an array of shape {table.shape}"
        )
    if not np.isfinite(table).all():
        row, column = np.argwhere(~np.isfinite(table))[0]
        raise ValueError(f"values should be finite, got {table[row, column]} for {names[column]} in row {row}")
    return table
