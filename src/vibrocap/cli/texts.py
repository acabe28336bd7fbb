"""Texts of options: how pairs, settings, ranges and lists are read."""

from typing import Any

from vibrocap.arguments import ArgumentError, Complaints, Refusal, suggestion
from vibrocap.case.sections import SECTIONS, is_section
from vibrocap.physics.dimensions.conversion import Quantity, quantity
from vibrocap.physics.names import split_path
from vibrocap.physics.system import System


def split(texts: "list[str] | None") -> list[str]:
    """Texts, each of which may be several with commas between."""
    return [piece.strip() for text in texts or () for piece in text.split(",") if piece.strip()]


def pairs(option: str, texts: "list[str] | None", complaints: Complaints, wanted: str) -> dict[str, str]:
    """KEY=VALUE pairs; wanted: what a complaint says they should be."""
    texts_by_name: dict[str, str] = {}
    for text in texts or ():
        key, equals, value = (part.strip() for part in text.partition("="))
        if not (key and equals and value):
            complaints.add(f"--{option} {text}", f"should be {wanted}")
        elif key in texts_by_name:
            complaints.add(f"--{option} {key}", "is given twice")
        else:
            texts_by_name[key] = value
    return texts_by_name


def checked_pairs(option: str, texts: "list[str] | None", wanted: str) -> dict[str, str]:
    """The same, refused with every complaint."""
    complaints = Complaints()
    checked = pairs(option, texts, complaints, wanted)
    if complaints:
        raise Refusal(*complaints)
    return checked


def priors(texts: "list[str] | None", complaints: Complaints) -> dict[str, tuple[float, float]]:
    """What is known beforehand, by name: (mean, standard deviation)."""
    priors_by_name, wanted = {}, "NAME=MEAN+-DEVIATION, such as mass=95+-1"
    for name, text in pairs("prior", split(texts), complaints, wanted).items():
        mean, _, deviation = text.replace("\N{PLUS-MINUS SIGN}", "+-").partition("+-")
        try:
            priors_by_name[name] = float(mean), float(deviation)
        except ValueError:
            complaints.add(f"--prior {name}={text}", f"should be {wanted}")
    return priors_by_name


def changes(
    set_: "list[str] | None", initial: "list[str] | None", complaints: Complaints
) -> dict[str, tuple[str, Any]]:
    """What --set PATH=VALUE and --initial NAME=VALUE change in a case, by path: (the option, the value)."""
    replaced = {}
    for path, text in pairs("set", split(set_), complaints, "PATH=VALUE, such as machine.mass_ratio=2.0").items():
        section, name = split_path(path)
        if not name:
            like = section if is_section(section) else "machine"
            complaints.add(f"--set {path}", f"should be a path such as {like}.NAME")
        elif not is_section(section):
            complaints.add(f"--set {path}", f"no such section of a case; {suggestion(section, SECTIONS)}")
        else:
            replaced[path] = f"--set {path}", value_of(text)
    for name, text in pairs("initial", split(initial), complaints, "NAME=VALUE, such as angle=0.5").items():
        if f"initial.{name}" in replaced:
            complaints.add(f"--initial {name}", "is given by --set too")
        replaced[f"initial.{name}"] = f"--initial {name}", value_of(text)
    return replaced


def value_of(text: str, *kinds: type) -> Any:
    """A number, whole or not, or a word. kinds: of numbers"""
    for kind in kinds or (int, float):
        try:
            return kind(text)
        except ValueError:
            continue
    return text if kinds else text.strip("\"'")


def range_of(
    text: str, option: str = "--over", example: str = "machine.mass_ratio=0.2:8.1"
) -> tuple[str, float, float]:
    """PATH=LEAST:LARGEST."""
    path, _, ends = text.partition("=")
    try:
        low, high = (float(end) for end in ends.split(":"))
    except ValueError:
        raise Refusal(f"{option} should be PATH=LEAST:LARGEST, such as {example}, got {text!r}") from None
    return path, low, high


def quantity_range(text: str, system: System) -> tuple[Quantity, float, float]:
    """PATH=LEAST:LARGEST of a system, the path in SI or not: (the quantity, the range without units)."""
    path, low, high = range_of(text)
    try:
        varied = quantity(path, system)
    except ArgumentError as error:
        raise Refusal(f"--over {error}") from None
    return varied, low / varied.scale, high / varied.scale


def column_names(texts: "list[str] | None", complaints: Complaints) -> dict[str, str | int]:
    """The columns of records by quantity, as names or numbers."""
    named = pairs("columns", split(texts), complaints, "QUANTITY=NAME, such as force=F1")
    return {quantity: int(name) if name.isdigit() else name for quantity, name in named.items()}
