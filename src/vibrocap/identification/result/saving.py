"""Saving a fit: a JSON file with all that was found, and the law as a section of a case file."""

import json
import math
from pathlib import Path
from typing import Any

import numpy as np

from vibrocap.identification.result.case_units import dimensionless, heading
from vibrocap.identification.result.fit_result import Fit, FittedParameter
from vibrocap.parameters import parameter_table
from vibrocap.scales import Scales


def save(fit: Fit, folder: str | Path, scales: Scales | None = None) -> tuple[Path, Path]:
    """Write fit.json and friction.toml into a folder, which is made; their paths.

    scales: of the pendulum in whose units friction.toml is written, as a case wants it; None: in SI, as fitted.
    Raises ValueError where the fit found no law, and for scales where the normal force is not known.
    """
    if not fit.ok:
        raise ValueError(f"fit: has no law to save; {fit.status}")
    assert fit.law is not None
    law = fit.law if scales is None else dimensionless(fit.law, scales, bool(fit.options.get("known_load")))
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    paths = folder / "fit.json", folder / "friction.toml"
    paths[0].write_text(json.dumps(as_data(fit), indent=1, allow_nan=False) + "\n", encoding="utf-8")
    paths[1].write_text(heading(scales) + case_section(law), encoding="utf-8")
    return paths


def case_section(law: Any) -> str:
    """The section [friction] of a case file, every parameter written out."""
    lines = ["[friction]", f"law = {json.dumps(law.name)}"]
    for info in parameter_table(law):
        value = getattr(law, info.name)
        if value is None:  # a part of the law that is not there
            continue
        lines.append(f"{info.name} = {_toml(value)}")
    return "\n".join(lines) + "\n"


def as_data(fit: Fit) -> dict[str, Any]:
    """The fit as numbers, texts, lists and dictionaries; an open end of an interval is null, with its verdict."""
    report = fit.identifiability
    return {
        "law": fit.law_name,
        "status": str(fit.status),
        "values": {p.name: p.value for p in fit.parameters},
        "parameters": [_parameter(p) for p in fit.parameters],
        "nuisances": [_parameter(p) for p in fit.nuisances],
        "relative_rmse": _number(fit.relative_rmse),
        "rmse_N": _number(fit.rmse),
        "held_out_relative_rmse": _number(fit.held_out_relative_rmse),
        "relative_to": "standard deviation of the measured force",
        "samples": fit.samples,
        "effective_samples": _number(fit.effective_samples),
        "records": [
            {
                "name": r.name,
                "held_out": r.held_out,
                "samples": len(r.time),
                "rmse_N": _number(r.rmse),
                "relative_rmse": _number(r.relative_rmse),
                "correlation_time_samples": _number(r.correlation_time),
            }
            for r in fit.records
        ],
        "identifiability": None
        if report is None
        else {
            "verdicts": {name: str(verdict) for name, verdict in report.verdicts.items()},
            "sentences": list(report.sentences),
            "experiments": dict(report.experiments),
            "directions": [
                {"exponents": dict(each.exponents), "deviation": _number(each.deviation)} for each in report.directions
            ],
        },
        "starts": [_number(each.cost) for each in fit.starts],
        "options": {name: _plain(value) for name, value in fit.options.items()},
        "seconds": round(fit.seconds, 3),
        "provenance": _provenance(),
    }


def _parameter(p: FittedParameter) -> dict[str, Any]:
    texts = {"name": p.name, "symbol": p.symbol, "meaning": p.meaning, "unit": p.unit, "verdict": str(p.verdict)}
    numbers = {"value": p.value, "low": p.low, "high": p.high, "standard_error": p.standard_error}
    return texts | {name: _number(value) for name, value in numbers.items()}


def _provenance() -> dict[str, str]:
    import platform
    from importlib.metadata import version

    import scipy

    return {
        "vibrocap": version("vibrocap"),
        "numpy": np.__version__,
        "scipy": scipy.__version__,
        "python": platform.python_version(),
    }


def _number(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None


def _plain(value: Any) -> Any:
    if isinstance(value, dict):
        return {name: _plain(item) for name, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [_plain(item) for item in value]
    return _number(value) if isinstance(value, float) else value


def _toml(value: Any) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False)
    return str(value) if isinstance(value, int) else repr(float(value))
