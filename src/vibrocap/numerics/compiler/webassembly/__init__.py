"""WebAssembly: kernels as one module that a browser runs, with the bits of plain Python.

Its floats and ints are those of the language of kernels, and it neither fuses nor reorders: sums and products have the
bits of Python's. The functions of `math` are the kernel's own polynomials, since those of a browser are its own affair;
sqrt and floor are exact everywhere. The structure of the typed tree is that of WebAssembly: `expressions.py` and
`functions.py` write it in one walk, `encoding.py` is the binary format.

A module has one memory: constant tables at its beginning, up to 64 KiB, and behind them what the page puts there. An
array is an address in it. Functions that are the same in several kernels stand in it once.
"""

from collections.abc import Iterable, Mapping

from vibrocap.numerics.compiler.kinds import Kind
from vibrocap.numerics.compiler.subset import LIBRARY, defines, parsed, uncollected
from vibrocap.numerics.compiler.typed.program import Program
from vibrocap.numerics.compiler.webassembly.encoding import Assembly
from vibrocap.numerics.compiler.webassembly.functions import Kernel

# What a kernel of one motion does not define itself (`numerics/card.py` does so for a card).
OWN = {
    "sine": "def sine(x):\n    return sine_cosine(x)[0]\n",
    "cosine": "def cosine(x):\n    return sine_cosine(x)[1]\n",
    "power": "def power(x, y):\n    return exponential(y * logarithm(x))\n",
}
# What WebAssembly has no instruction for, as Python does it (`float_divmod` of its source).
OPERATORS = """
def whole_power(x, k):
    left, power, square = abs(k), 1.0, x
    while left != 0:
        if left & 1:
            power = power * square
        left = left >> 1
        square = square * square
    return 1.0 / power if k < 0 else power


def truncated_rest(x, y):
    rest, least = abs(x), abs(y)
    if not (least > 0.0 and rest < math.inf):
        return math.nan
    while rest >= least:  # each difference is exact
        times = least
        while rest - times >= times:
            times = times * 2.0
        rest = rest - times
    return rest if x > 0.0 else -rest


def float_rest(x, y):
    rest = truncated_rest(x, y)
    if rest == 0.0:
        return 0.0 if y > 0.0 else -0.0
    return rest + y if (rest < 0.0) != (y < 0.0) else rest


def float_floor_divided(x, y):
    if y == 0.0:
        return x / y
    rest = truncated_rest(x, y)
    times = (x - rest) / y
    if rest != 0.0 and (rest < 0.0) != (y < 0.0):
        times = times - 1.0
    if times == 0.0:
        return -0.0 if np.float64(x / y).view(np.int64) < 0 else 0.0
    whole = np.floor(times)
    return whole + 1.0 if times - whole > 0.5 else whole
"""


def module(kernels: Iterable[tuple[str, Mapping[str, tuple[str, tuple[Kind, ...]]]]]) -> bytes:
    """The module of several kernels, see `webassembly_module` of the room."""
    assembly = Assembly()
    with uncollected():
        for text, exports in kernels:
            program = Program(parsed(with_own_functions(text) + OPERATORS), 0, LIBRARY, without_lane=True)
            kernel = Kernel(assembly, program)
            for exported, (name, kinds) in exports.items():
                kernel.export(exported, program.entry(name, kinds))
        return assembly.binary()


def with_own_functions(text: str) -> str:
    """A kernel that has polynomials, with all functions of `math` made of them."""
    missing = [own for name, own in OWN.items() if not defines(text, name) and defines(text, "sine_cosine")]
    return "\n\n".join([text, "# From compiler/webassembly", *missing]) if missing else text
