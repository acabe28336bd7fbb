"""Words of a picture: what a measure, an axis, a value and a case are called in titles, labels and legends."""

import re
from collections.abc import Mapping
from typing import Any

from vibrocap.case import CHOICES, CaseError, case_from_text
from vibrocap.parameters import parameter_table
from vibrocap.symbols import STATES, printed
from vibrocap.trajectory import Status

NOT_RUN = -1  # status of a run to come
NOTHING = re.compile(r" \((?:NaN|empty|infinite): (.*)\)")  # what a meaning says of missing values
EQUALS = "\N{NO-BREAK SPACE}=\N{NO-BREAK SPACE}"
SYMBOLS = {
    "mean_velocity": "⟨X′⟩",
    "drift": "ΔX",
    "displacement": "ΔX",
    "peak_friction": "max |R|",
    "mean_friction": "⟨|R|⟩",
    "velocity_loop_area": "∮R dv",
    "displacement_loop_area": "∮R dX",
    "cost_of_transport": "W/|ΔX|",
}
MEANS = {
    "symmetric": {0.0: "not its own mirror image", 1.0: "its own mirror image"},
    "travel": {-1.0: "back", 0.0: "none", 1.0: "forward"},
    "response_period": {0.0: "not settled"},
    "settled": {0.0: "not settled", 1.0: "settled"},
    "computed": {0.0: "filled in", 1.0: "run"},
}


def status_word(code: int) -> str:
    """A status in words."""
    return "not run yet" if code == NOT_RUN else list(Status)[code].value


def axis_label(path: str, attributes: Mapping[str, Any]) -> str:
    """What varies, with its symbol and unit."""
    unit = attributes.get("units", "1")
    meaning = str(attributes.get("long_name", path)).replace(" [rad]", "")
    for plain, nice in (("^2", "²"), ("omega_n", "ωₙ")):
        meaning = meaning.replace(plain, nice)
    words = [meaning, printed(str(attributes.get("symbol", "")))]
    unit = "rad" if "[rad]" in str(attributes.get("long_name", "")) else unit
    return "  ".join(word for word in (*words, "" if unit == "1" else f"[{unit}]") if word)


def setting_words(dataset: Any, fixed: Mapping[str, str]) -> str:
    """The case in brief: the kinds of its parts, and the parameters that the study left as they are."""
    try:
        case = case_from_text(str(dataset.attrs["case"]))
    except (KeyError, CaseError):
        return ", ".join(f"{path} = {value}" for path, value in fixed.items())
    varied = {str(name) for name in dataset.coords} - set(fixed)
    kinds, numbers = [], []
    for part, (key, _) in CHOICES.items():
        record = getattr(case.system, part)
        kind = fixed.get(f"{part}.{key}", record.name)
        if f"{part}.{key}" not in varied:
            kinds.append(f"{kind} friction" if part == "friction" else f"{kind} drive" if part == "drive" else kind)
        for info in parameter_table(record) if kind == record.name else ():
            path = f"{part}.{info.name}"
            value = fixed.get(path, getattr(record, info.name))
            usual = part == "friction" or info.name == "normal_load"  # named only where it is not as usual
            if path not in varied and not (usual and value == info.default):
                numbers.append(f"{printed(info.symbol)}{EQUALS}{value_text(value)}")
    for name, start in case.initial.items():
        value = float(fixed.get(f"initial.{name}", start))
        if value and f"initial.{name}" not in varied:
            numbers.append(f"{printed(STATES[name][0]) if name in STATES else name}(0){EQUALS}{value:.4g}")
    return f"{', '.join(kinds)}; {', '.join(numbers)}"


def note_words(dataset: Any) -> str:
    """How the runs were made."""
    runs, periods, settle = dataset["status"].size, dataset.attrs.get("periods"), dataset.attrs.get("settle")
    words = [f"{runs:,} runs"]
    if periods is not None:
        words[0] += (
            f" of at most {periods} periods, settled to {float(settle):g}" if settle else f" of {periods} periods"
        )
    if "runs_computed" in dataset.attrs:
        words.append(f"{float(dataset.attrs['share_computed']):.1%} of them made, the others filled in between")
    return "; ".join([*words, "all dimensionless"])


def value_text(value: Any) -> str:
    """A value as it stands in a title."""
    return value if isinstance(value, str) else f"{float(value):.4g}"


def facet_words(path: str, value: float | str) -> str:
    """The title of a panel that shows one value of a quantity."""
    return value if isinstance(value, str) else f"{path.partition('.')[2].replace('_', ' ')} {value_text(value)}"


def meant(measure: str, value: float | str) -> str:
    """A discrete value of a measure in words."""
    if isinstance(value, str):
        return value or "(no word)"
    if measure == "status":
        return status_word(int(value))
    return MEANS.get(measure, {}).get(float(value)) or f"{value:g}"


def why_none(meaning: str) -> str:
    """Why a run may have no value, as the meaning of its measure says."""
    found = NOTHING.search(meaning)
    return f"no value ({found[1]})" if found else "no value"
