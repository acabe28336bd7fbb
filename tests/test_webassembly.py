"""Kernels in WebAssembly, run by Node: the bits of plain Python, for every operator and for the motions of every law.

Plain Python here computes sin, exp and so on by the package's polynomials and whole powers by repeated squaring, as all
compiled kernels do.
"""

import ast
import json
import math
import shutil
import subprocess

import numpy as np
import pytest

import vibrocap as vc
from plain_kernels import kernel_of
from test_compiler import BODIES, Python, bits, body_text, operands
from thinned import exhaustive_but, slow_but
from vibrocap.motion.recording.equations import equations, parameter_values
from vibrocap.numerics.compiler import FLOATS, INT, INTS, Refused
from vibrocap.numerics.compiler.subset import LIBRARY, OWN
from vibrocap.numerics.compiler.webassembly import webassembly_module
from vibrocap.numerics.kernel.codes import DONE, MACHINE_SWITCHED
from vibrocap.numerics.linker import compiled_kernel, plain_kernel
from vibrocap.numerics.run import motion
from vibrocap.numerics.run.budget import Budget, Form, MotionStart
from vibrocap.numerics.run.motion import recorded_run
from vibrocap.physics.catalogue import laws

NODE = shutil.which("node")
pytestmark = pytest.mark.skipif(NODE is None, reason="Node, which runs WebAssembly, is not installed")
# Calls functions of a module one after the other; arrays come in files and go back into them.
RUN = """
const fs = require("fs");
const [module, ...calls] = process.argv.slice(1);
const { exports } = new WebAssembly.Instance(new WebAssembly.Module(fs.readFileSync(module)));
for (const [name, rounds, ...files] of calls.map(JSON.parse)) {
  const content = files.map((file) => fs.readFileSync(file));
  const size = content.reduce((sum, each) => sum + each.length, 65536) - exports.memory.buffer.byteLength;
  if (size > 0) exports.memory.grow(Math.ceil(size / 65536));
  let place = 65536;
  const addresses = content.map((each) => {
    new Uint8Array(exports.memory.buffer, place).set(each);
    place += each.length;
    return place - each.length;
  });
  console.log(exports[name](...addresses, rounds));
  files.forEach((file, i) => {
    fs.writeFileSync(file, new Uint8Array(exports.memory.buffer, addresses[i], content[i].length));
  });
}
"""
ARGUMENTS = (FLOATS, INTS, FLOATS, INT)
ADVANCE = {"advance": ("advance", ARGUMENTS)}


def in_node(folder, module, calls):
    """Call functions (name, floats, ints, trace, rounds) of a module in one process; what they return."""
    (folder / "kernel.wasm").write_bytes(module)
    dumps = []
    for number, (name, floats, ints, trace, rounds) in enumerate(calls):
        files = [folder / f"{number}-{i}" for i in range(3)]
        for file, array in zip(files, (floats, ints, trace), strict=True):
            file.write_bytes(array.tobytes())
        dumps.append(json.dumps([name, rounds, *map(str, files)]))
    command = [NODE, "-e", RUN, str(folder / "kernel.wasm"), *dumps]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=300)
    assert done.returncode == 0, done.stderr
    for number, (_, *arrays, _) in enumerate(calls):
        for i, array in enumerate(arrays):
            array[:] = np.frombuffer((folder / f"{number}-{i}").read_bytes(), dtype=array.dtype)
    return [int(line) for line in done.stdout.split()]


class InNode:
    """The function `advance` of a kernel, called as the plain one is; every call is a new process."""

    def __init__(self, text, folder):
        self.folder, self.module = folder, webassembly_module([(text, ADVANCE)])

    def __call__(self, *given):
        return in_node(self.folder, self.module, [("advance", *given)])[0]


class Meaning(ast.NodeTransformer):
    """Plain Python with the package's polynomials, and powers as all targets compute them."""

    def visit_Attribute(self, node):
        known = isinstance(node.value, ast.Name) and node.value.id == "math" and node.attr in LIBRARY
        return ast.Name(LIBRARY[node.attr], ast.Load()) if known else node

    def visit_BinOp(self, node):
        self.generic_visit(node)
        if not isinstance(node.op, ast.Pow):
            return node
        return ast.Call(ast.Name("any_power", ast.Load()), [node.left, node.right], [])


ANY_POWER = """
def any_power(x, k):
    if not isinstance(k, (int, np.integer)):
        return power(x, k)
    if isinstance(x, (int, np.integer)):
        return x**k
    product, left = 1.0, abs(k)
    while left:
        if left & 1:
            product = product * x
        left >>= 1
        x = x * x
    return 1.0 / product if k < 0 else product
"""


def plain_meaning(text):
    """The entry of a kernel as plain Python."""
    head, own = text.split("\n\n", 2)[:2], "\n".join(OWN.values())
    tree = Meaning().visit(ast.parse(text))
    assert head[0] == "import math"
    imports, body = tree.body[:2], tree.body[2:]
    added = ast.parse(own + ANY_POWER).body
    return plain_kernel(ast.unparse(ast.fix_missing_locations(ast.Module([*imports, *added, *body], []))))["advance"]


UNKNOWN = ("math.log", "math.sin", "abs(x) ** 0.3")  # functions of which these texts have no polynomials
OPERATORS = [name for name in BODIES if not any(each in BODIES[name] for each in UNKNOWN)]


@pytest.fixture(scope="module")
def found_in_node(tmp_path_factory):
    """What the functions of all operators give, by their names: one module, one process."""
    kernels, calls = [], []
    for number, name in enumerate(OPERATORS):
        floats, ints = operands(name)
        kernels.append((body_text(BODIES[name]), {f"advance{number}": ("advance", ARGUMENTS)}))
        ints, trace = np.concatenate(([0, 0], ints.ravel())), np.concatenate((np.zeros(len(floats)), floats.ravel()))
        calls.append((f"advance{number}", np.zeros(8), ints, trace, len(floats)))
    in_node(tmp_path_factory.mktemp("operators"), webassembly_module(kernels), calls)
    return {name: call[3][: call[4]] for name, call in zip(OPERATORS, calls, strict=True)}


@pytest.mark.parametrize("name", OPERATORS)
def test_every_operator_gives_the_bits_of_plain_python(name, found_in_node):
    floats, ints = operands(name)
    count = len(floats)
    with np.errstate(all="ignore"):
        plain_kernel(body_text(BODIES[name]))["advance"](
            Python(8), Python([0, 0, *ints.ravel().tolist()]), Python([*[0.0] * count, *floats.ravel()]), count
        )
    plain = np.array(Python.last[:count], dtype=float)
    assert np.array_equal(bits(plain), bits(found_in_node[name]))


WIDE = """
import math

import numpy as np

MANY = 2**40
ALL = 2**62 - 1

def both(i, j):
    return i + j, i * j - 1

def advance(floats, ints, trace, rounds):
    ints[0] = MANY + rounds
    ints[1] = ints[0] // 7 + ints[0] % 1000
    ints[2] = (ints[0] & 2**33 - 1) << 3
    ints[3] = (np.float64(floats[0]).view(np.int64) & ALL) >> 11
    ints[4] = -(MANY + 3) >> 1
    ints[5] = (np.float64(floats[0]).view(np.int64) + ALL) >> 12
    total, product = both(ints[0], 3)
    total, product = product, total
    ints[6] = total
    ints[7] = product // -(2**35)
    ints[8] = 4 * -5 % -rounds
    trace[0] = floats[1] / float(0 * -rounds)
    trace[1] = floats[1] / float(-(rounds - 5) + (rounds - 5) % -3)
    arguments = ints[0] ^ 1
    while arguments > 2**35 and arguments % -3 != -1:
        arguments = arguments // -3 * -1
    ints[9] = arguments
    return ints[0] > 2**39
"""


def test_ints_are_exact_beyond_32_bits(tmp_path):
    """To 64 bits, and no int is -0 when it becomes a float."""
    results = []
    for entry in (plain_kernel(WIDE)["advance"], InNode(WIDE, tmp_path)):
        floats, ints, trace = np.array([-1.7e-200, 1.0]), np.zeros(10, dtype=np.int64), np.zeros(2)
        with np.errstate(all="ignore"):
            number = int(entry(floats, ints, trace, 5))
        results.append([number, *ints.tolist(), *trace.tolist()])
    assert results[0] == results[1]
    assert results[0][0] == 1
    assert results[1][-2:] == [math.inf, math.inf]


ORDER = """
import math

import numpy as np

def moved(ints, k):
    ints[0] = ints[0] + 1
    return 10 * k + ints[0]

def raised(k):
    k += 1
    return k

def signed(x, k):
    if x < 0.0:
        return -1, k
    while k > 5:
        k -= 2
    return k, x

def advance(floats, ints, trace, rounds):
    ints[ints[0]] = moved(ints, 0)
    ints[ints[0] + 2] += moved(ints, 1)
    ints[5] = raised(0) + 10 * raised(0) + raised(rounds)
    for n in range(1):
        if rounds > n:
            continue
        ints[6] = 1
    for n in range(1):
        ints[7] = rounds
        if n == 0:
            break
        ints[7] = 0
    a, b = signed(floats[0], rounds)
    c, d = signed(-floats[0], 0)
    floats[1], floats[2], a = b, d, c
    ints[8] = a - c
    ints[9] = signed(floats[0], 9)[0]
"""


def test_what_is_done_first_is_done_first(tmp_path):
    """Values before places, an entry before what is added; functions in place and for 0, loops of one round."""
    results = []
    for entry in (plain_kernel(ORDER)["advance"], InNode(ORDER, tmp_path)):
        floats, ints = np.array([1.5, 0.0, 0.0]), np.arange(1, 11)
        entry(floats, ints, np.zeros(1), 5)
        results.append([*ints.tolist(), *floats.tolist()])
    assert results[0] == results[1]
    assert results[0][5:8] == [17, 7, 5]


# --- motions ---------------------------------------------------------------------------------------------------------

SLOPE = vc.Environment(inclination=0.1, linear_drag=0.2, quadratic_drag=0.3, force=0.05)
LIGHT = vc.PendulumCapsule(normal_load="dynamic", mass_ratio=4.0)
STOPS = {
    "stop": vc.VibroImpactCapsule(back_gap=0.1),
    "rigid": vc.RigidStopCapsule(gap=1.2, restitution=0.3),
    "bob": vc.PendulumCapsuleWithStops(limit_angle=1.1, restitution=0.6),
}
MACHINES = {"pendulum": vc.PendulumCapsule(), "oscillator": vc.Oscillator(), "slope": LIGHT, **STOPS}
# machine, law and periods: one of each kind slow, the others before a release; laws run in a browser too
MOTIONS = [("pendulum", "exponential", 0.7), ("pendulum", "lugre", 0.7)]
MOTIONS += [(machine, law, 1.6) for law in laws() for machine in ("pendulum", "oscillator")]
MOTIONS += [("slope", law, 1.6) for law in ("exponential", "lugre", "smoothed-tanh")]
MOTIONS += [(machine, law, 1.6) for machine in STOPS for law in ("coulomb", "lugre")]
SLOW = [MOTIONS.index(row) for row in (("pendulum", "lugre", 0.7), ("slope", "lugre", 1.6), ("bob", "coulomb", 1.6))]
SLOW.append(2 + 12)  # of the laws


def system_of(machine, law):
    outside = SLOPE if machine == "slope" else None
    return vc.System(MACHINES[machine], laws()[law](), vc.Harmonic(amplitude=1.8), environment=outside)


def motions(system, entries, monkeypatch, periods):
    """The runs of one motion by several entries of its kernel."""
    kernel, runs = kernel_of(system), []
    start = [1.0, *[0.0] * (len(system.state_names) - 1)]
    for make in entries:
        entry = make(kernel.text)
        monkeypatch.setattr(motion, "kernel", lambda *_, entry=entry: (kernel.layout, entry))
        numbers = equations(system), parameter_values(system), start, system.drive.period
        with np.errstate(all="ignore"):
            runs.append(recorded_run(MotionStart(*numbers), Budget(periods, 1e-9, 1000, 10**6), Form(order=12)))
    return runs


def assert_the_same(plain, found):
    assert plain.status == found.status == DONE
    assert plain.taylor_steps + plain.implicit_steps > 8
    assert (plain.taylor_steps, plain.implicit_steps) == (found.taylor_steps, found.implicit_steps)
    for name in ("pieces", "events", "final"):
        assert np.array_equal(getattr(plain, name), getattr(found, name), equal_nan=True), name


@pytest.mark.parametrize(("machine", "law", "periods"), slow_but([0], exhaustive_but({0, *SLOW}, MOTIONS)))
def test_motions_are_those_of_plain_python(machine, law, periods, tmp_path, monkeypatch):
    """Every piece and every event, to the last bit: of every law, on a slope, and where stops are struck."""
    system = system_of(machine, law)
    plain, node = motions(system, (plain_meaning, lambda text: InNode(text, tmp_path)), monkeypatch, periods)
    assert len(plain.events) > 0 or (periods == 1.6 and machine in ("pendulum", "oscillator"))  # smooth laws have none
    assert machine not in STOPS or {MACHINE_SWITCHED, MACHINE_SWITCHED + 2} & set(plain.events[:, 2])
    assert_the_same(plain, node)


@pytest.mark.parametrize(("machine", "law"), slow_but([0], [("pendulum", "exponential"), ("oscillator", "lugre")]))
def test_literal_machine_code_is_plain_python(machine, law, monkeypatch):
    """By it a page is checked: all sums and products rounded, the package's functions; Taylor and stiff steps."""
    system = system_of(machine, law)
    plain, found = motions(system, (plain_meaning, lambda text: compiled_kernel(text, literal=True)), monkeypatch, 0.7)
    assert_the_same(plain, found)


# --- refusals --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("line", "what"),
    [
        ("x = math.tan(1.0)", "of math it knows"),
        ("x = math.sin(floats[0])", "no polynomials for `sin`"),
        ("x = [1.0]", "`List`"),
        ("x = floats", "cannot stand for"),
        ("x = load(floats, 0)", "of lanes"),
    ],
)
def test_what_webassembly_cannot_say_is_refused_with_its_place(line, what):
    head = "# From numerics/some_file.py\nimport math\n\nimport numpy as np\n\n"
    imported = "from vibrocap.numerics.kernel.arithmetic.plain_vectors import load\n\n" if "load" in line else ""
    with pytest.raises(Refused, match=what) as refused:
        webassembly_module([(f"{head}{imported}def advance(floats, ints, trace, rounds):\n    {line}\n", ADVANCE)])
    assert "function `advance`" in str(refused.value)
