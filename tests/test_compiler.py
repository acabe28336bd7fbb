"""The compiler of kernels: compiled is plain Python to the last bit, what it does not know it refuses, by name.

Without fused operations (`exactly`) nothing may differ from plain Python: functions of every operator on random and
special numbers, and whole motions.
"""

import concurrent.futures
import itertools
import math
import struct

import numpy as np
import pytest

import vibrocap as vc
from plain_kernels import kernel_of
from thinned import exhaustive_but
from vibrocap.motion.recording.equations import equations, parameter_values
from vibrocap.numerics.compiler import Compiled, Refused, compiled, host, ir, object_code
from vibrocap.numerics.compiler.kinds import FLOATS, INT, INTS
from vibrocap.numerics.compiler.lowering import lowered
from vibrocap.numerics.compiler.subset import parsed
from vibrocap.numerics.compiler.typed.program import Program
from vibrocap.numerics.linker import plain_kernel
from vibrocap.numerics.run import ensemble, motion
from vibrocap.numerics.run.budget import Budget, EnsembleStart, Form, MotionStart
from vibrocap.numerics.run.ensemble import ensemble_run
from vibrocap.numerics.run.motion import recorded_run


def exactly(text, entry):
    """A kernel compiled without fused operations."""
    return Compiled(object_code(ir(text, entry).replace(" contract", ""), host()))


# --- every operator --------------------------------------------------------------------------------------------------

HEAD = """
import math

import numpy as np

LINE = np.array([0.5, -1.25, 3.0, 1e-3])
GRID = np.array([[1.0, 2.0, 3.0], [-4.0, 5.5, 0.0]])
WHOLES = np.array([3, -1, 4])
SIGNS = (-1, 1, -1)
KNOWN = True
UNKNOWN = 1.0 if KNOWN else None
"""
# Each is the body of a function of two floats and two ints.
BODIES = {
    "sum": "return x + y",
    "difference": "return x - y",
    "product": "return x * y",
    "quotient": "return x / y",
    "sum of ints": "return i + j * 3 - i",
    "quotient of ints": "return i / j",
    "floor quotient of ints": "return i // j",
    "rest of ints": "return i % j",
    "by constants": "return i // 3 * 100 + i % 3 * 10 + i // -4 + i % -4",
    "square": "return x**2 if abs(x) < 1e150 else x",
    "cube": "return (i * 1.0) ** 3",
    "inverse square": "return float(j) ** -2 if j in (1, 2, 4, -4) else 0.0",
    "no power": "return x**0 + y**1",
    "power of an int": "return i**4",
    "varying power": "return 2.0 ** (i - j)",
    "broken power": "return abs(x) ** 0.3 if abs(x) < 1e200 else 0.0",
    "less": "return x < y",
    "chain": "return 0.0 < x <= y < 10.0",
    "chain of ints": "return i < j < 5 and not i == -j",
    "unequal": "return x != y",
    "equal": "return x == y or i == j",
    "least": "return min(x, y)",
    "greatest": "return max(x, y)",
    "least of three": "return min(x, 1.0, y)",
    "greatest of three": "return max(i, 0.5, y)",
    "greatest of ints": "return max(i, j, -3)",
    "magnitude": "return abs(x) + abs(i)",
    "negative": "return -x",
    "negative zero": "return 0.0 * x if x == x and abs(x) < 1e308 else -0.0",
    "int of a float": "return int(x) if abs(x) < 1e15 else 0",
    "float of an int": "return float(i) / 7",
    "floor": "return math.floor(x) if abs(x) < 1e15 else 0",
    "floor as float": "return np.floor(x)",
    "bits": "return np.float64(x).view(np.int64) >> 52 & 2047",
    "from bits": "return np.int64((np.float64(abs(x)).view(np.int64) & (2**52 - 1)) | 1023 * 2**52).view(np.float64)",
    "shifts": "return (i << 5 ^ j) & ~3 | i >> 1",
    "choice": "return x if x > y else i",
    "nested choice": "return (1 if i > j else 2) if x > 0.0 else -3.5 if y > 0.0 else j",
    "within": "return i in (1, 2, j) or x in (0.0, 1.0)",
    "both": "return x > 0.0 and y > 0.0 and i > j",
    "either": "return x > 0.0 or y > 0.0 or not i > j",
    "truth of ints": "if i & 1 and not j or x:\n        return 1\n    return 2",
    "table": "return LINE[i % 4] + LINE[2] + GRID[j % 2, i % 3] + GRID[1, 1]",
    "table of ints": "return WHOLES[i % 3] + SIGNS[j % 3] + SIGNS[0]",
    "functions": "return math.sin(y0) + math.cos(y0) * math.exp(y0) - math.tanh(y0) + math.atan(y0)",
    "log and root": "return math.log(y0) - math.sqrt(y0)",
    "known condition": "if KNOWN:\n        return x\n    return nothing_of_this_is_defined(x)",
    "joined": "k = 1\n    if x > y:\n        k = 0.5\n    return k * i",
    "joined in a loop": "k = 0\n    for _ in range(3):\n        k += 0.25 if i > 0 else 1\n    return k",
    "backwards": "k = 0\n    for n in range(j + 5, -3, -2):\n        k = k * 3 + n\n    return k",
    "no rounds": "n = 7\n    for n in range(i, i):\n        n = 8\n    return n",
    "the last value stays": "n = -1\n    for n in range(2, 2 + abs(j)):\n        if n == 6:\n            break\n"
    "    return n",
    "own variable": "k = 0\n    for n in range(4):\n        n = n * i\n        k += n\n    return k",
    "while": "k = abs(i)\n    n = 0\n    while k > 0:\n        k -= 2\n        if k == 3:\n            continue\n"
    "        if n > 100:\n            break\n        n += k\n    return n",
    "for ever": "k = i\n    while True:\n        k += 3\n        if k > 20:\n            return k",
    "swap": "a, b = x, y\n    a, b = b, a\n    c, (d, e) = i, (a, b)\n    return c + d if e > 0.0 else d",
    "parts": "return part(x, i)[0] - part(i, j)[1] * 2",
    "array": "floats[3] = x\n    floats[4] = i\n    floats[3] *= 2\n    ints[1] = j\n    ints[1] -= i\n"
    "    return floats[3] if ints[1] > 0 else floats[4]",
    "half round": "k, a = 0, 0\n    for n in range(3):\n        if n == 1 and i > 0:\n            continue\n"
    "        a += n\n        for m in range(n):\n            if m == j:\n                break\n"
    "            k += 10 * m + 1\n    return a - k",
}
SPECIAL = [0.0, -0.0, math.inf, -math.inf, math.nan, 1.0, -1.0, 2.0, -3.5, 1e300, -1e-300, 5e-324, 7.25, 0.5]


def body_text(body):
    """A kernel that applies a function to rows of four numbers, and writes what it returns as a float."""
    setting = "y0 = abs(y) if 1e-3 < abs(y) < 20.0 else 0.5\n    " if "y0" in body else ""
    loop = """
def part(x, i):
    return x - i, 2 * i

def advance(floats, ints, trace, rounds):
    for k in range(rounds):
        at = rounds + 2 * k
        trace[k] = body(floats, ints, trace[at], trace[at + 1], ints[2 + 2 * k], ints[3 + 2 * k])
"""
    return f"{HEAD}\ndef body(floats, ints, x, y, i, j):\n    {setting}{body}\n{loop}"


def operands(name):
    """Rows of random and special floats, and of ints."""
    draw = np.random.default_rng(sum(name.encode()))
    floats = [*itertools.product(SPECIAL, SPECIAL), *draw.normal(0.0, 5.0, (60, 2)).tolist()]
    ints = draw.integers(-9, 10, (len(floats), 2))
    if "/ j" in BODIES[name] or "% j" in BODIES[name] or "** -2" in BODIES[name]:
        ints[ints[:, 1] == 0, 1] = 1  # an error in plain Python
    if "x / y" in BODIES[name]:
        floats = [(x, y or 0.25) for x, y in floats]
    return np.array(floats), ints


@pytest.mark.parametrize("name", BODIES)
def test_every_operator_gives_the_bits_of_plain_python(name):
    text = body_text(BODIES[name])
    floats, ints = operands(name)
    results = []
    for entry in (plain_kernel(text)["advance"], exactly(text, "advance")):
        trace = np.concatenate((np.zeros(len(floats)), floats.ravel()))
        numbers = np.concatenate(([0, 0], ints.ravel()))
        if entry.__class__.__name__ == "function":  # Python's own numbers raise where those of a kernel do not
            with np.errstate(all="ignore"):
                entry(Python(8), Python(numbers.tolist()), Python(trace), len(floats))
            continue_with = Python.last
            results.append(np.array(continue_with[: len(floats)], dtype=float))
        else:
            entry(np.zeros(8), numbers, trace, len(floats))
            results.append(trace[: len(floats)].copy())
    assert np.array_equal(*map(bits, results))


class Python(list):
    """A flat array of Python's own numbers."""

    last: "Python"

    def __init__(self, content):
        super().__init__([0.0] * content if isinstance(content, int) else [*map(_own, content)])
        Python.last = self


def _own(number):
    return number if isinstance(number, int) else float(number)


def bits(numbers):
    """Bits of floats, all NaN alike."""
    return np.where(np.isnan(numbers), 0x7FF8000000000000, numbers.view(np.int64))


def test_a_division_by_zero_is_no_error():
    text = """
def advance(floats, ints, trace, rounds):
    trace[0] = floats[0] / floats[1]
    trace[1] = -floats[0] / floats[1]
    trace[2] = floats[1] / floats[1]
    ints[0] = ints[1] // ints[2]
    ints[3] = ints[1] % ints[2]
"""
    floats, ints, trace = np.array([2.0, 0.0]), np.array([9, 5, 0, 9]), np.zeros(3)
    compiled(text, "advance")(floats, ints, trace, 0)
    assert np.array_equal(trace, [math.inf, -math.inf, math.nan], equal_nan=True)
    assert ints.tolist() == [0, 5, 0, 0]


def test_sums_of_products_are_fused():
    text = "def advance(floats, ints, trace, rounds):\n    trace[0] = floats[0] * floats[0] - floats[1]\n"
    x = 1.0 + 2.0**-30
    floats, results = np.array([x, x * x]), []
    for entry in (compiled(text, "advance"), exactly(text, "advance")):
        trace = np.zeros(1)
        entry(floats, np.zeros(1, dtype=np.int64), trace, 0)
        results.append(trace[0])
    assert results == [2.0**-60, 0.0] or "+fma" not in host().features


# --- lanes -----------------------------------------------------------------------------------------------------------

ABREAST = """
import math

from vibrocap.numerics.kernel.arithmetic.plain_vectors import (
    align_stack, bits, exponent, floor, load, mantissa, power_of_two, square_root, store, where
)

LANES = {width}

def several(x, y):
    return x * y, where(x < y, x, 2), ~(x <= y) | (y == 1.0)

def advance(floats, ints, trace, rounds):
    align_stack()
    x, y = load(floats, 0), load(floats, LANES)
    product, least, chosen = several(x, y)
    place = 0
    store(trace, place, x + y)
    store(trace, LANES, x - y)
    store(trace, 2 * LANES, product)
    store(trace, 3 * LANES, x / (y * y + 1))
    store(trace, 4 * LANES, least)
    store(trace, 5 * LANES, where(chosen & (x > 0.0), -x, abs(y)))
    store(trace, 6 * LANES, where((x >= y) ^ chosen, 1, floats[0]))
    store(trace, 7 * LANES, floor(x) + square_root(abs(y)))
    store(trace, 8 * LANES, 3.5)
    store(trace, 9 * LANES, exponent(abs(x) + 1.0) * mantissa(abs(y) + 1.0) + power_of_two(floor(x)))
    odd = load(ints, 0) == 3
    store(ints, 0, where(odd, 50 + rounds, load(ints, 0)))
    second = load(ints, LANES)
    store(ints, LANES, where((second > 0) & ~odd, second + 7, second))
    reached = load(ints, 0) + load(ints, LANES) - 1 >= load(ints, 2 * LANES) - 1
    total = x
    for k in range(rounds):
        total = total + where(reached, y, 0.0)
        if bits(total > 5.0) != 0:
            total = total - 1.0
    store(trace, 10 * LANES, total)
    return bits(reached) + 1000 * bits(odd)
"""


@pytest.mark.parametrize("seed", range(6))
def test_lanes_give_the_bits_of_numpy(seed):
    width = host().lanes
    text = ABREAST.replace("{width}", str(width))
    draw = np.random.default_rng(seed)
    floats = draw.normal(0.0, 3.0, 2 * width)
    floats[draw.integers(0, 2 * width, 3)] = [0.0, -0.0, 1.0]
    ints = draw.integers(-2, 5, 3 * width)
    values = []
    for entry in (plain_kernel(text)["advance"], exactly(text, "advance")):
        trace, own = np.zeros(11 * width), ints.copy()
        values.append((entry(floats.copy(), own, trace, 4), own, trace))
    (plain, plain_ints, plain_trace), (exact, exact_ints, exact_trace) = values
    assert plain == exact
    assert np.array_equal(plain_ints, exact_ints)
    assert np.array_equal(bits(plain_trace), bits(exact_trace))


ONE_OR_ALL = """
import math

from vibrocap.numerics.kernel.arithmetic.plain_vectors import (
    all_lanes, exponent, floor, mantissa, max, min, power_of_two, square_root, where
)

LANES = {width}

def worked(floats, ints, row):
    x, y = floats[row], floats[LANES + row]
    most, least = max(x, y, 0.25), min(y, 0.5 * x)
    chosen = (x > y) & (x > -5.0) | (y == 1.0)
    floats[2 * LANES + row] *= where(chosen, most, -1.0)
    floats[row + 3 * LANES] = floor(x) + square_root(abs(y)) + 2
    floats[row + 4 * LANES] = exponent(most) * mantissa(most) + power_of_two(floor(y))
    return where(chosen | (least < -1.0), least, most)

def advance(floats, ints, trace, rounds):
    every = all_lanes()
    floats[5 * LANES + every] = worked(floats, ints, every)
    for lane in range(LANES):
        floats[11 * LANES + lane] = worked(floats, ints, 6 * LANES + lane)
    return 0
"""


def test_one_text_gives_one_lane_the_bits_of_all():
    width = host().lanes
    text, block = ONE_OR_ALL.replace("{width}", str(width)), np.random.default_rng(3).normal(0.0, 3.0, 6 * width)
    block[:3], block[width : width + 3] = [0.0, -0.0, math.nan], [-0.0, 0.0, 1.0]
    results = []
    for entry in (plain_kernel(text)["advance"], exactly(text, "advance")):
        floats = np.tile(block, 2)
        entry(floats, np.zeros(1, np.int64), np.zeros(1), 1)
        assert np.array_equal(bits(floats[: 6 * width]), bits(floats[6 * width :]))
        results.append(floats)
    assert np.array_equal(*map(bits, results))


@pytest.mark.parametrize(
    ("right", "wrong", "message"),
    [
        ("floats[LANES + row]", "floats[row * 2]", "an int is added"),
        ("floats[LANES + row]", "floats[row + row]", "an int is added"),
        ("floor(x)", "float(row)", "places of all lanes"),
        ("floats[LANES + row]", "ints[row]", "a place in an array is an int, not places of all lanes"),
        ("+ 2\n", "+ chosen\n", "write where"),
    ],
)
def test_places_of_all_lanes_are_for_entries_alone(right, wrong, message):
    text = ONE_OR_ALL.replace(right, wrong).replace("{width}", str(host().lanes))
    with pytest.raises(Refused, match=message):
        ir(text, "advance")


def test_vectors_on_the_stack_are_aligned_where_they_are():
    text = ABREAST.replace("{width}", str(host().lanes)).replace("def advance", "def inner")
    text += "\ndef advance(floats, ints, trace, rounds):\n    return inner(floats, ints, trace, rounds)\n"
    (head,) = [line for line in ir(text, "advance").splitlines() if line.startswith("define internal i64 @inner(")]
    assert "noinline alignstack(64)" in head
    assert len(object_code(ir(text, "advance"), host())) > 500


# --- whole kernels ---------------------------------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize("law", exhaustive_but([0], [vc.Dahl(), vc.LuGre()]), ids=lambda law: law.name)
def test_the_quick_way_gives_the_bits_of_the_long_one(law, monkeypatch):
    """Which product of a sum is fused follows from how the passes leave blocks and operands; Dahl's law shows it."""
    system = vc.System(vc.PendulumCapsule(mass_ratio=2.5), law, vc.Harmonic(amplitude=1.8))
    start = [math.pi / 3, *[0.0] * (len(system.state_names) - 1)]
    begin = MotionStart(equations(system), parameter_values(system), start, system.drive.period)
    values = []
    for short in (True, False):
        motion.kernel.cache_clear()

        def made(text, *_, short=short, **__):
            return Compiled(object_code(lowered(text(), "advance", host().lanes, short), host()))

        monkeypatch.setattr(motion, "kept_kernel", made)
        run = recorded_run(begin, Budget(20, 1e-9, 1000, 10**6), Form(order=12))
        values.append((run.pieces, run.events, run.final))
    motion.kernel.cache_clear()
    assert all(np.array_equal(one, other, equal_nan=True) for one, other in zip(*values, strict=True))
    assert np.isfinite(values[0][0]).any()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("law", "lanes"),
    exhaustive_but([3], [(vc.Exponential(), 1), (vc.Exponential(), 0), (vc.LuGre(), 1), (vc.LuGre(), 0)]),
    ids=["exponential-one by one", "exponential-simd", "lugre-one by one", "lugre-simd"],
)
def test_an_ensemble_without_fused_operations_is_that_of_plain_python(law, lanes, monkeypatch):
    system = vc.System(vc.PendulumCapsule(), law, vc.Harmonic())
    recorded = equations(system)
    runs = 5
    parameters = np.tile(parameter_values(system), (runs, 1))
    parameters[:, recorded.parameter_paths.index("machine.mass_ratio")] = np.linspace(0.5, 6.0, runs)
    initial = np.zeros((runs, len(recorded.rates)))
    initial[:, 0] = np.linspace(0.4, 1.2, runs)
    budget = Budget(1, 1e-6, 1000, 10**6, window=1, asked=63)
    results = []
    for make in (lambda text: plain_kernel(text)["advance_ensemble"], lambda text: exactly(text, "advance_ensemble")):
        ensemble.ensemble_kernel.cache_clear()
        monkeypatch.setattr(ensemble, "kept_kernel", lambda text, *_, make=make: make(text()))
        with np.errstate(all="ignore"):
            results.append(
                ensemble_run(EnsembleStart(recorded, parameters, initial), budget, Form(lanes=lanes), threads=1).numbers
            )
    ensemble.ensemble_kernel.cache_clear()
    assert np.array_equal(*results, equal_nan=True)


# --- refusals --------------------------------------------------------------------------------------------------------

REFUSED = {
    "    for k in range(3):\n        pass\n    else:\n        pass": "no else",
    "    while rounds > 0:\n        rounds -= 1\n    else:\n        pass": "no else",
    "    for k in (1, 2):\n        pass": r"range\(\.\.\.\)",
    "    for k in range(0, 3, rounds):\n        pass": "step of a range is a constant",
    "    x = y = 1.0": "one target at a time",
    "    x: float = 1.0": "`AnnAssign`",
    "    x = [1.0]": "`List`",
    "    x = 'text'": "a constant in a kernel",
    "    try:\n        pass\n    finally:\n        pass": "`Try`",
    "    with floats:\n        pass": "`With`",
    "    import math": "`Import`",
    "    assert rounds": "`Assert`",
    "    x = lambda: 1": "`Lambda`",
    "    def inner():\n        pass": "`FunctionDef`",
    "    advance(floats, ints, trace, 1)": "calls itself",
    "    helper(floats, x=1)": "positional",
    "    helper(floats)": "`helper` takes 2 arguments, not 1",
    "    helper(floats, floats)": "different ones",
    "    missing(floats)": "no kernel can call `missing`",
    "    x = math.gamma(1.0)": "of math it knows",
    "    x = nothing": "is not known",
    "    trace[0] = x\n    x = 1.0\n    x = 2.0": "read where",
    "    x = floats": "cannot stand for",
    "    floats = 1.0": "cannot be given another value",
    "    x = floats[0.5]": "a place in an array is an int",
    "    x = floats[0:2]": "`Slice`|one place at a time",
    "    ints[0] = 1.5": "takes no float",
    "    x = (1.0, 2.0)[rounds]\n    x = (floats[0], 2.0)[rounds]": "constant within it",
    "    a, b = 1.0, 2.0, 3.0": "2 names cannot take",
    "    x = 1.0\n    x = (1.0, 2.0)": "use two names",
    "    x = (rounds > 0) + 1.0": "yes and no are no numbers",
    "    x = 1.5 & 2": "of floats",
    "    x = floats[0] // 2": "of ints",
    "    x = floats[0] % 1.0": "of ints",
    "    x = floats[0] if (1.0, 2.0) else 1.0": "neither yes nor no",
    "    x = rounds and 2": "join yes and no",
    "    x = min(floats[0])": "with 1 arguments",
    "    x = sum(floats)": "no kernel can call `sum`",
    "    x = floats[0] is None": "a constant|no kernel has",
    "    x = TABLE[0]": "dimensions",
    "    if rounds > 1:\n        return 2": "end can be reached",
    "    return 1.5": "returns an int or nothing",
    "    global x": "`Global`",
    "    x = f'{rounds}'": "`JoinedStr`",
    "    del rounds": "`Delete`",
    "    x = rounds ** rounds": "constant exponent",
    "    x = rounds ** -1": "no int",
    "    x = no_result(rounds)": "returns nothing",
}
AROUND = """# From numerics/some_file.py
import math

import numpy as np

TABLE = np.array([[1.0, 2.0]])

def helper(a, b):
    return 1.0

def no_result(k):
    pass

def advance(floats, ints, trace, rounds):
    trace[0] = 1.0
"""


@pytest.mark.parametrize("lines", REFUSED)
def test_what_is_outside_the_language_is_refused_with_its_place(lines):
    with pytest.raises(Refused, match=REFUSED[lines]) as refused:
        ir(AROUND + lines + "\n", "advance")
    message = str(refused.value)
    assert message.startswith("numerics/some_file.py, function `advance`, line ")
    of_the_function = "    floats = 1.0", "    return 1.5", "    if rounds > 1:\n        return 2"
    assert ("line 1 of it" in message) == (lines in of_the_function)


@pytest.mark.parametrize(
    ("text", "what"),
    [
        ("def advance(floats, ints, trace, rounds=1):\n    pass\n", "no defaults"),
        ("def advance(*arrays):\n    pass\n", "positional"),
        ("@staticmethod\ndef advance(floats, ints, trace, rounds):\n    pass\n", "no decorator"),
        ("import os\ndef advance(floats, ints, trace, rounds):\n    pass\n", "imports math, numpy as np"),
        ("def f():\n    pass\n\ndef f():\n    pass\n", "defined twice"),
        ("def f():\n    pass\n", "no function `advance`"),
        (ABREAST.replace("{width}", "4").replace("x + y", "max(x, y)"), "import `max` of lanes"),
        (ABREAST.replace("{width}", "4").replace("x + y", "chosen + y"), "write where"),
        (ABREAST.replace("{width}", "4").replace("chosen &", "chosen and"), "joined by &|join yes and no"),
        (ABREAST.replace("{width}", "4").replace("-x, abs", "-x, ~abs"), "lanes have"),
        (ABREAST.replace("{width}", "4").replace("load(floats, 0)", "load(rounds, 0)"), "takes an array of floats"),
        (ABREAST.replace("{width}", "4").replace("load(floats, 0)", "load(ints, 0)"), "ints of lanes have"),
    ],
)
def test_whole_texts_are_refused(text, what):
    with pytest.raises(Refused, match=what):
        ir(text, "advance")


def test_files_are_named_where_a_text_says_what_came_from_where():
    system = vc.System(vc.PendulumCapsule(), vc.Exponential(), vc.Harmonic())
    text = kernel_of(system).text.replace("    changes = 0\n", "    changes = []\n", 1)
    with pytest.raises(
        Refused, match=r"kernel/arithmetic/roots.py, function `sign_changes`, line 3 of it .*`changes = \[\]`"
    ):
        ir(text, "advance")


# --- machine code ----------------------------------------------------------------------------------------------------


def test_only_the_entry_of_a_kernel_is_seen_from_outside():
    system = vc.System(vc.PendulumCapsule(), vc.Exponential(), vc.Harmonic())
    heads = [line for line in ir(kernel_of(system).text, "advance").splitlines() if line.startswith("define")]
    values = [head for head in heads if not head.startswith("define internal ")]
    assert len(heads) > 30
    assert len(values) == 1
    assert "@kernel_entry(" in values[0]
    assert values[0].count("noalias") == 3


def test_a_function_is_made_once_for_each_combination_of_kinds():
    text = """
def twice(x):
    return x + x

def advance(floats, ints, trace, rounds):
    trace[0] = twice(floats[0]) + twice(1.5) + twice(rounds) + twice(2) + twice(twice(floats[1]))
"""
    assert ir(text, "advance").count("define internal") == 3


def test_the_memory_is_checked_where_a_kernel_is_called():
    advance = compiled("def advance(floats, ints, trace, rounds):\n    trace[0] = floats[0]\n", "advance")
    floats, ints = np.ones(4), np.zeros(4, dtype=np.int64)
    with pytest.raises(TypeError, match="flat arrays of float64, not 1-D int64"):
        advance(floats, ints, ints, 1)
    with pytest.raises(TypeError, match="flat arrays of int64"):
        advance(floats, ints.astype(np.int32), floats, 1)
    with pytest.raises(TypeError, match="flat arrays"):
        advance(floats[::2], ints, np.ones(4), 1)
    with pytest.raises(TypeError, match="2-D"):
        advance(floats.reshape(2, 2), ints, np.ones(4), 1)
    with pytest.raises(TypeError, match="4 arguments"):
        advance(floats, ints)


@pytest.mark.slow
def test_threads_compile_and_run_at_once():
    """As many kernels as threads, each compiled by two of them; none is made twice or mixed up with another."""

    def work(k):
        head = "def advance(floats, ints, trace, rounds):"
        text = f"{head}\n    for i in range(rounds):\n        trace[i] = floats[i] + {k}\n"
        trace = np.zeros(3)
        advance = compiled(text, "advance")
        advance(np.zeros(3), np.zeros(1, dtype=np.int64), trace, 3)
        return advance, trace

    with concurrent.futures.ThreadPoolExecutor(8) as pool:
        items = list(pool.map(work, [1, 2, 3, 4, 4, 3, 2, 1]))
    assert [trace.tolist() for _, trace in items] == [[float(k)] * 3 for k in (1, 2, 3, 4, 4, 3, 2, 1)]
    assert all(items[i][0] is items[7 - i][0] for i in range(4))


def test_floats_keep_all_their_bits():
    numbers = [0.1, -0.0, 5e-324, math.inf, -math.inf, 1.7976931348623157e308, math.nan]
    lines = "\n".join(f"    trace[{i}] = {_spelled(x)}" for i, x in enumerate(numbers))
    trace = np.zeros(len(numbers))
    text = f"import math\n\ndef advance(floats, ints, trace, rounds):\n{lines}\n"
    compiled(text, "advance")(np.zeros(1), np.zeros(1, dtype=np.int64), trace, 0)
    assert [struct.pack("d", x) for x in trace[:-1]] == [struct.pack("d", x) for x in numbers[:-1]]
    assert math.isnan(trace[-1])


def _spelled(x):
    return f"{'-' if x < 0 else ''}math.inf" if math.isinf(x) else "math.nan" if math.isnan(x) else repr(x)


def test_what_kernels_share_is_the_same_in_both():
    """A page had the step of another kernel: what watches it names the step in its words, which made a circle."""
    text = '''
def a_watch(x):
    """As `moves` asks."""
    return x + {number}

def moves(x):
    return a_watch(x)

def advance(floats, ints, trace, rounds):
    floats[0] = a_watch(moves(floats[0]))
'''
    shared: dict = {}
    for number in (1.0, 2.0, 1.0):
        Program(parsed(text.format(number=number)), 0, shared=shared).entry("advance", (FLOATS, INTS, FLOATS, INT))
    assert len(shared) == 6
