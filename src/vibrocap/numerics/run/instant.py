"""The equations at one instant as C, for integrators that are not ours."""

import dataclasses
from typing import Any

from vibrocap.numerics.codegen.instant_source import Instant, instant_source
from vibrocap.numerics.compiler import c_source
from vibrocap.numerics.linker.link import linked_source
from vibrocap.numerics.linker.recipes import INSTANT


def exported_instant(equations: Any, prefix: str) -> Instant:
    """The equations at an instant, of one contact that can rest, as the C of `PREFIX_instant(floats, ints, trace, 0)`.

    Of the arrays only `floats` is used; see `Instant` for what stands where.
    """
    instant = instant_source(equations)
    text = linked_source(instant.text, INSTANT)
    text.check()
    return dataclasses.replace(instant, text=c_source(text, "instant", prefix))
