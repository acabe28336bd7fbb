"""Carry-over: what a part of another kind keeps of the part that it replaces, and what it has to be told.

Whatever changes the kind of a part asks here: `--set friction.law=...`, sweeps over kinds, `crossing --against`, the
lab.
"""

import functools
from collections.abc import Container, Iterator, Mapping
from types import MappingProxyType
from typing import Any

from vibrocap.arguments import Complaint
from vibrocap.physics.dimensions.units import UNDECLARED, one_way, parameter_keys, undeclared
from vibrocap.physics.parameters import NUMBER, ParameterInfo, parameter_table

# Roles that say of what kind a quantity is rather than what it does: under another name it is another thing.
BROAD = ("effort", "effort rate", "effort acceleration", "duration", "mass", "load", "speed")
# Pure numbers with these roles are chosen, not measured; their defaults are neutral: a Gaussian droop, equal halves.
CHOSEN = ("exponent", "convention", "share", "phase")


@functools.cache
def carried_names(old: type, new: type) -> Mapping[str, str]:
    """Which parameter of one kind of part each parameter of another takes its value from: {name in new: name in old}.

    Those of the same name, role and dimension; of what is left, those whose role each of the two has once: a friction
    law's level is its level, whatever it is called. A pure number, and what has a `BROAD` role, keeps to its name; a
    share of a whole goes over with all the others, or not at all.
    """
    names: tuple[Mapping[str, str], ...] = tuple(getattr(kind, "si_names", {}) for kind in (old, new))
    before = {info.name: info for info in parameter_table(old)}
    carried_over: dict[str, str] = {}
    for info in parameter_table(new):
        same = before.get(info.name)
        stems = [name.get(info.name, info.name) for name in names]
        if same is not None and _alike(same, info) and stems[0] == stems[1]:
            carried_over[info.name] = info.name
    shares = [info.name for info in parameter_table(new) if info.role == "share"]
    if any(name not in carried_over for name in shares):
        carried_over = {name: other for name, other in carried_over.items() if name not in shares}
    left = [_by_role(old, carried_over.values()), _by_role(new, carried_over)]
    carried_over |= {left[1][role]: left[0][role] for role in left[1] if role in left[0]}
    return MappingProxyType(carried_over)


def carried(part: Any, kind: type) -> dict[str, Any]:
    """The values, by name, that a part of another kind takes over from a part."""
    return {name: getattr(part, old) for name, old in carried_names(type(part), kind).items()}


def lacking(kind: type, effort: str, known: Container[str]) -> list[Complaint]:
    """What has to be said of a part in SI that took the place of another, field by field.

    A default without units is that of a certain paper's machine: only nothing, a word and a number that is `CHOSEN`
    stand for themselves. known: names of the parameters that were carried over or given; effort: of the machine
    """
    name = kind.name  # type: ignore[attr-defined]
    keys = parameter_keys(kind, effort)
    complaints = [Complaint(name, UNDECLARED) for name in undeclared(kind)]
    for info in needed(kind):
        key = one_way(keys, info.name)
        if info.name not in known and key is not None:
            complaints.append(Complaint(key.key, f"is missing; {name!r} needs it, and in SI it has no default"))
    return complaints


def lacking_per_load(law: Any, effort: str, known: Container[str]) -> list[Complaint]:
    """What has to be said of a law in SI whose load begins or ceases to follow the motion, field by field.

    Its stiffness and damping are over the load there, and have other units. effort: of the law then (`effort_of`);
    known: names of the parameters that were given
    """
    keys = parameter_keys(type(law), effort)
    forces = (info for info in parameter_table(law) if info.dimension and info.dimension.force)
    bare = [info for info in forces if getattr(law, info.name) and info.name not in known]
    units = {info.name: key.key for info in bare if (key := one_way(keys, info.name)) is not None}
    what = "is missing; it has another unit where the load follows the motion, as friction acts per load there"
    return [Complaint(units[info.name], what) for info in bare]


def needed(kind: type) -> Iterator[ParameterInfo]:
    """The parameters of a kind of part that have no default where it takes the place of another in SI."""
    for info in parameter_table(kind):
        neutral = info.role in CHOSEN and info.dimension == NUMBER
        if not (info.default in (None, 0.0) or isinstance(info.default, str) or info.dimension is None or neutral):
            yield info


def _alike(one: ParameterInfo, other: ParameterInfo) -> bool:
    """Whether two parameters of one name are the same quantity; a word is one that has a word for its default."""
    words = isinstance(one.default, str), isinstance(other.default, str)
    return one.role == other.role and one.dimension == other.dimension and words[0] == words[1]


def _by_role(kind: type, taken: Container[str]) -> dict[str, str]:
    """The parameters that are not taken yet, by the roles that but one of them has and that say what it does."""
    roles: dict[str, list[str]] = {}
    for info in parameter_table(kind):
        if info.role and info.role not in BROAD and info.dimension != NUMBER:
            roles.setdefault(info.role, []).append(info.name)
    return {role: names[0] for role, names in roles.items() if len(names) == 1 and names[0] not in taken}
