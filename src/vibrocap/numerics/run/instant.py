"""The equations at one instant as C, for integrators that are not ours."""

import dataclasses

from vibrocap.numerics.codegen.instant_source import Instant, instant_source
from vibrocap.numerics.compiler import c_source
from vibrocap.numerics.expressions.equations import Equations
from vibrocap.numerics.linker.link import linked_source
from vibrocap.numerics.linker.recipes import INSTANT

ENTRIES = ("period", "table", "instant", "after_switch")
CALLED = """
void {0}_drive(double *values) {{
  int64_t none = 0;
  double nothing = 0.0;
  {0}_period(values, &none, &nothing, 0);
  {0}_table(values, &none, &nothing, 0);
}}

void {0}_equations(double *values) {{
  int64_t none = 0;
  double nothing = 0.0;
  {0}_instant(values, &none, &nothing, 0);
}}

void {0}_after(double *values, int guard) {{
  int64_t none = 0;
  double nothing = 0.0;
  {0}_after_switch(values, &none, &nothing, guard);
}}
"""


def exported_instant(equations: Equations, prefix: str, own_drive: bool = True) -> Instant:
    """The equations at an instant, of one contact that can rest: C of `PREFIX_drive` and `PREFIX_equations(values)`.

    The first computes what of the drive follows from the parameters, the second what the equations say, and
    `PREFIX_after(values, guard)` the states after a guard has fallen; `Instant` says what stands where.

    own_drive: see `instant_source`
    """
    instant = instant_source(equations, own_drive)
    text = linked_source(instant.text, INSTANT)
    text.check()
    return dataclasses.replace(instant, text=c_source(text, ENTRIES, prefix) + CALLED.format(prefix))
