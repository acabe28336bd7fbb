"""The equations at one instant as C, for integrators that are not ours."""

import dataclasses
from typing import Any

from vibrocap.numerics.codegen.instant_source import Instant, instant_source
from vibrocap.numerics.compiler import c_source
from vibrocap.numerics.linker.link import linked_source
from vibrocap.numerics.linker.recipes import INSTANT

ENTRY = """
void {0}_equations(double *values) {{
  int64_t none = 0;
  double nothing = 0.0;
  {0}_instant(values, &none, &nothing, 0);
}}
"""


def exported_instant(equations: Any, prefix: str) -> Instant:
    """The equations at an instant, of one contact that can rest, as the C of `PREFIX_equations(values)`.

    It computes what they say of what is given; `Instant` says what stands where.
    """
    instant = instant_source(equations)
    text = linked_source(instant.text, INSTANT)
    text.check()
    made = c_source(text, ("instant",), prefix) + ENTRY.format(prefix)
    return dataclasses.replace(instant, text=made)
