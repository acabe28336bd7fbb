"""What targets without a library of `math` have instead: functions of the kernel itself, in its own language."""

from vibrocap.numerics.compiler.subset import defines

OWN = {
    "sine": "def sine(x):\n    return sine_cosine(x)[0]\n",
    "cosine": "def cosine(x):\n    return sine_cosine(x)[1]\n",
    "power": "def power(x, y):\n    return exponential(y * logarithm(x))\n",
}
# The rest of a division, towards zero, which LLVM asks of a library.
REST = """
import math


def rest(x, y):
    left, least = abs(x), abs(y)
    if not (least > 0.0 and left < math.inf):
        return math.nan
    while left >= least:  # each difference is exact
        times = least
        while left - times >= times:
            times = times * 2.0
        left = left - times
    return left if x > 0.0 else -left
"""


def with_own_functions(text: str) -> str:
    """A kernel that has polynomials, with all functions of `math` made of them."""
    missing = [own for name, own in OWN.items() if not defines(text, name) and defines(text, "sine_cosine")]
    return "\n\n".join([text, "# From compiler/own_functions", *missing]) if missing else text
