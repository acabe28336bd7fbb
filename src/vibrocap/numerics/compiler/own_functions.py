"""Functions in the language of kernels: what it has no operator for; what targets without a library of `math` have."""

from vibrocap.numerics.compiler.subset import defines

OWN = {
    "sine": "def sine(x):\n    return sine_cosine(x)[0]\n",
    "cosine": "def cosine(x):\n    return sine_cosine(x)[1]\n",
    "power": "def power(x, y):\n    return exponential(y * logarithm(x))\n",
}
# A power whose exponent is not known: repeated squaring, in the order in which a known one is written out.
WHOLE_POWER = """
def whole_power(x, k):
    power, left = 1.0, abs(k)
    while left != 0:
        if left & 1:
            power = power * x
        x = x * x
        left >>= 1
    return 1.0 / power if k < 0 else power
"""


def with_own_functions(text: str) -> str:
    """A kernel that has polynomials, with all functions of `math` made of them."""
    missing = [own for name, own in OWN.items() if not defines(text, name) and defines(text, "sine_cosine")]
    return "\n\n".join([text, "# From compiler/own_functions", *missing]) if missing else text
