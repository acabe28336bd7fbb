"""A fit as text: parameters with intervals, errors by record, what the data do not determine."""

import math

from vibrocap.identification.inference.identifiability import Verdict
from vibrocap.identification.result.fit_result import Fit, FittedParameter

NOTHING = 1e-9  # of an interval's larger end: a number that is rounding


def number(value: float, digits: int) -> str:
    """A number to so many digits, without an exponent where it is of a common size."""
    return f"{float(f'{value:.{digits}g}'):.6g}"


def summary(fit: Fit) -> str:
    """The fit as lines of text."""
    if not fit.ok:
        return f"{fit.law_name}: {fit.status}"
    lines = [f"{fit.law_name}: {fit.status}, relative RMSE {_percent(fit.relative_rmse)} ({fit.rmse:.4g} N)"]
    if not math.isnan(fit.held_out_relative_rmse):
        lines[0] += f", held out {_percent(fit.held_out_relative_rmse)}"
    lines += ["", *table([("parameter", "value", "95 % interval", "unit", ""), *(_row(p) for p in fit.parameters)])]
    if fit.nuisances:
        lines += [
            "",
            *table([("of the measurement", "value", "95 % interval", "unit", ""), *map(_row, fit.nuisances)]),
        ]
    rows = [
        (r.name, f"{len(r.time):,} samples", _percent(r.relative_rmse), "held out" if r.held_out else "fitted")
        for r in fit.records
    ]
    lines += ["", *table([("record", "", "relative RMSE", ""), *rows])]
    report = fit.identifiability
    if report is not None and report.sentences:
        lines += ["", "What these data do not determine:", *(f"- {sentence}" for sentence in report.sentences)]
    if fit.options.get("not_shown"):
        names = ", ".join(fit.options["not_shown"])
        lines += ["", f"The steady curve does not show {names}: held at the values that the law came with."]
    if fit.options.get("machine_stiffness") is not None:
        lines += ["", f"Pulled through a spring of {number(fit.options['machine_stiffness'], 4)} N/m, which was held."]
    lines += [
        "",
        f"Relative to the standard deviation of the force. {fit.samples:,} samples, {len(fit.starts)} starts, "
        f"{fit.seconds:.1f} s.",
    ]
    return "\n".join(lines)


def _row(p: FittedParameter) -> tuple[str, ...]:
    if p.verdict == Verdict.HELD:
        return p.name, number(p.value, 5), "held", p.unit, ""
    note = "" if p.verdict == Verdict.DETERMINED else str(p.verdict)
    size = max((abs(end) for end in (p.low, p.high) if math.isfinite(end)), default=abs(p.value))
    value = 0.0 if abs(p.value) < NOTHING * size else p.value
    return p.name, number(value, 5), f"{_end(p.low, size)} to {_end(p.high, size)}", p.unit, note


def _end(value: float, size: float) -> str:
    if not math.isfinite(value):
        return "open"
    return number(value if abs(value) >= NOTHING * size else 0.0, 4)


def _percent(share: float) -> str:
    return f"{100 * share:.1f} %"


def table(rows: list[tuple[str, ...]]) -> list[str]:
    """Rows of cells as lines, in columns."""
    widths = [max(len(row[i]) for row in rows) for i in range(len(rows[0]))]
    return [("  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True))).rstrip() for row in rows]
