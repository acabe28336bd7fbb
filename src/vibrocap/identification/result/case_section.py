"""The section [friction] of a case file for a fitted law, in SI or in the units of a case."""

import json
from typing import Any

from vibrocap.arguments import ArgumentError
from vibrocap.identification.problem.parametrisation import with_values
from vibrocap.physics.dimensions.scales import PendulumScales
from vibrocap.physics.dimensions.units import force_keys, one_way, parameter_keys
from vibrocap.physics.friction.law import Law
from vibrocap.physics.parameters import parameter_table

IN_SI = """\
# In SI, as fitted: it goes into a case in SI as it is. For a case without units of the pendulum give its mass and
# length (`--pendulum`, or `fit.save(folder, scales=...)`).
"""
FORCES = """\
# The normal force of the records is not known: the levels of the law are forces. A case makes coefficients of them by
# its constant normal_load_N; for other loads fit with the normal force of the records.
"""
TURNING_IN_SI = """\
# In the units of the records, which are SI for a contact that turns: N m, rad, s. No case has such a contact.
"""


def dimensionless(law: Law, scales: PendulumScales, known_load: bool) -> Law:
    """The law that was fitted in SI, in the dimensionless units of a case.

        stiffness l/(m g)     damping l/(m g sqrt(l/g))     velocity sqrt(g l)     length l     coefficients as they are

    known_load: whether coefficients are over the normal force; without it they are forces in N, from which no
    coefficient follows: raises ValueError, as for a parameter that declares neither a role nor a unit.
    """
    values = {}
    for info in parameter_table(law):
        value = getattr(law, info.name)
        if not isinstance(value, float):
            continue
        if info.dimension is None:
            declared = f'as in parameter(..., unit="N s/m"), unit="1" for a pure number, in {type(law).__name__}'
            unknown = "has no known dimension, so that it cannot be converted"
            raise ArgumentError(info.name, f"{unknown}; declare its role or its unit, {declared}")
        if info.dimension.coefficient and not known_load:
            advice = "give the normal force of the records for a law in the units of a case"
            raise ArgumentError("normal_force", f"is not known, so that {info.name} is a force in N; {advice}")
        values[info.name] = value / scales.of(info.dimension)
    return with_values(law, values)


def heading(scales: PendulumScales | None, rotary: bool = False, known_load: bool = True) -> str:
    """Lines of comment that say in which units a section of a case file stands."""
    if rotary:
        return TURNING_IN_SI
    if scales is None:
        return IN_SI + ("" if known_load else FORCES)
    return (
        f"# Dimensionless, for a pendulum of {scales.pendulum_mass_kg:g} kg and {scales.pendulum_length_m:g} m: "
        "forces over its weight, lengths over its length.\n"
    )


def case_section(law: Any, in_si: bool = False, known_load: bool = True) -> str:
    """The section [friction] of a case file, every parameter written out; in SI with its unit.

    known_load: whether coefficients are over the normal force; without it they stand as forces.
    """
    keys = parameter_keys(type(law), "force") if in_si else {}
    forces = {} if known_load or not in_si else {info.name: key for key, info in force_keys(type(law)).items()}
    lines = ["[friction]", f"law = {json.dumps(law.name)}"]
    for info in parameter_table(law):
        value = getattr(law, info.name)
        if value is None:  # a part of the law that is not there
            continue
        key = one_way(keys, info.name)
        text = json.dumps(value, ensure_ascii=False) if isinstance(value, (bool, int, str)) else repr(float(value))
        lines.append(f"{forces.get(info.name, info.name if key is None else key.key)} = {text}")
    return "\n".join(lines) + "\n"
