"""Parts of one's own in a study: what tells them apart in its identity.

A part from outside the package can be edited while a study is stored, so the study remembers it by its file's digest,
or, for one that was registered by a script, by a fingerprint of its functions.
"""

import hashlib
from collections.abc import Mapping
from typing import Any

from vibrocap.case.case import CATALOGUES, KEYS, Case
from vibrocap.physics.part_files import file_of
from vibrocap.studies.plan.fingerprint import function_fingerprint

OWN_FUNCTIONS = ("__post_init__",)  # with two underscores; all others of these are made by Python


def own_parts(case: Case, plan: Mapping[str, Any]) -> dict[str, type]:
    """The parts of a study that are not of this package, such as {"friction.law = own": Own}; plan: its record."""
    entries = {entry["path"]: entry for entry in plan.get("axes") or plan.get("columns") or ()}
    found: dict[str, type] = {}
    for section in (part for part in case.system.parts if part in KEYS):
        path, catalogue = f"{section}.{KEYS[section]}", CATALOGUES[section]
        kinds = [type(getattr(case.system, section))]
        kinds += [catalogue()[name] for name in entries.get(path, {}).get("values", ()) if isinstance(name, str)]
        for kind in kinds:
            part = getattr(kind, "wrapped", None) or kind
            if not part.__module__.startswith("vibrocap."):
                found[f"{path} = {part.name}"] = part
    return found


def part_fingerprint(part: type) -> str:
    """SHA-256 of the file that a part was loaded from; else of its functions and constants."""
    if (place := file_of(part)) is not None:
        return place[1]
    own = [each for each in part.__mro__ if not each.__module__.startswith(("vibrocap.", "builtins"))]
    described = [(each.__qualname__, sorted(_described(each).items())) for each in own]
    return hashlib.sha256(repr(described).encode()).hexdigest()


def _described(part: type) -> dict[str, str]:
    found = {}
    for name, value in vars(part).items():
        if name.startswith("__") and name not in OWN_FUNCTIONS:
            continue
        inner = (getattr(value, holder, None) for holder in ("fget", "func", "__func__", "wrapped"))
        function = next((each for each in inner if each is not None), value)
        if hasattr(function, "__code__"):
            found[name] = function_fingerprint(function)
        elif isinstance(value, (int, float, str, tuple, type(None))):
            found[name] = repr(value)
    return found
