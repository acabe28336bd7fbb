"""Kernels in JavaScript, run by Node: the bits of plain Python, for every operator and for the motions of every law.

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
from thinned import slow_but
from vibrocap.motion.equations import equations, parameter_values
from vibrocap.numerics.compiler import Refused, javascript_text
from vibrocap.numerics.compiler.javascript import OWN
from vibrocap.numerics.compiler.subset import LIBRARY
from vibrocap.numerics.kernel.codes import DONE, MACHINE_SWITCHED
from vibrocap.numerics.linker.link import compiled_kernel, plain_kernel
from vibrocap.numerics.run import motion
from vibrocap.numerics.run.motion import recorded_run
from vibrocap.physics.catalogue import laws

NODE = shutil.which("node")
pytestmark = pytest.mark.skipif(NODE is None, reason="Node, which runs JavaScript, is not installed")
RUN = """
import fs from "node:fs";
import readline from "node:readline";
for await (const line of readline.createInterface({ input: process.stdin })) {
  try {
    const { module, rounds, files } = JSON.parse(line);
    const { advance } = await import(module);
    const arrays = files.map((name) => {
      const content = fs.readFileSync(name);
      return new Float64Array(content.buffer, content.byteOffset, content.byteLength / 8).slice();
    });
    const found = advance(...arrays, rounds);
    arrays.forEach((array, i) => fs.writeFileSync(files[i], Buffer.from(array.buffer)));
    console.log(JSON.stringify({ found: String(found) }));
  } catch (error) {
    console.log(JSON.stringify({ error: String(error.stack) }));
  }
}
"""
RUNNING = []  # the Node of this file, once it is asked for: one process runs every module


@pytest.fixture(autouse=True, scope="module")
def node_ends():
    yield
    while RUNNING:
        with RUNNING.pop() as process:  # closes its input, at which it ends, and waits
            pass
        assert process.returncode == 0


def in_node(**order):
    """What Node answers to an order."""
    if not RUNNING:
        command = [NODE, "--input-type=module", "--eval", RUN]
        RUNNING.append(subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True))
    process = RUNNING[0]
    process.stdin.write(json.dumps(order) + "\n")
    process.stdin.flush()
    answer = json.loads(process.stdout.readline())
    assert "error" not in answer, answer["error"]
    return answer["found"]


class InNode:
    """The function `advance` of a kernel, called as the plain one is."""

    def __init__(self, text, folder):
        self.folder = folder
        self.module = folder / f"kernel{len(list(folder.glob('*.mjs')))}.mjs"  # a module is read once by its name
        self.module.write_text(javascript_text(text, "advance"))

    def __call__(self, real, whole, tape, rounds):
        arrays = {"real": real, "whole": whole, "tape": tape}
        for name, array in arrays.items():
            (self.folder / name).write_bytes(array.astype(np.float64).tobytes())
        files = [str(self.folder / name) for name in arrays]
        found = in_node(module=str(self.module), rounds=int(rounds), files=files)
        for name, array in arrays.items():
            array[:] = np.frombuffer((self.folder / name).read_bytes())
        return int(float(found))


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


OPERATORS = [name for name in BODIES if "math.log" not in BODIES[name] and "math.sin" not in BODIES[name]]


@pytest.mark.parametrize("name", [name for name in OPERATORS if "abs(x) ** 0.3" not in BODIES[name]])
def test_every_operator_gives_the_bits_of_plain_python(name, tmp_path):
    text = body_text(BODIES[name])
    floats, ints = operands(name)
    count = len(floats)
    with np.errstate(all="ignore"):
        plain_kernel(text)["advance"](
            Python(8), Python([0, 0, *ints.ravel().tolist()]), Python([*[0.0] * count, *floats.ravel()]), count
        )
    plain = np.array(Python.last[:count], dtype=float)
    tape = np.concatenate((np.zeros(count), floats.ravel()))
    InNode(text, tmp_path)(np.zeros(8), np.concatenate(([0, 0], ints.ravel())), tape, count)
    assert np.array_equal(bits(plain), bits(tape[:count]))


WIDE = """
import math

import numpy as np

MANY = 2**40
ALL = 2**62 - 1

def both(i, j):
    return i + j, i * j - 1

def advance(real, whole, tape, rounds):
    whole[0] = MANY + rounds
    whole[1] = whole[0] // 7 + whole[0] % 1000
    whole[2] = (whole[0] & 2**33 - 1) << 3
    whole[3] = (np.float64(real[0]).view(np.int64) & ALL) >> 11
    whole[4] = -(MANY + 3) >> 1
    whole[5] = (np.float64(real[0]).view(np.int64) + ALL) >> 12
    total, product = both(whole[0], 3)
    total, product = product, total
    whole[6] = total
    whole[7] = product // -(2**35)
    whole[8] = 4 * -5 % -rounds
    tape[0] = real[1] / float(0 * -rounds)
    tape[1] = real[1] / float(-(rounds - 5) + (rounds - 5) % -3)
    arguments = whole[0] ^ 1
    while arguments > 2**35 and arguments % -3 != -1:
        arguments = arguments // -3 * -1
    whole[9] = arguments
    return whole[0] > 2**39
"""


def test_ints_are_exact_beyond_32_bits(tmp_path):
    """Counts up to 2^53, bits up to 2^63; no int is -0."""
    results = []
    for entry in (plain_kernel(WIDE)["advance"], InNode(WIDE, tmp_path)):
        real, whole, tape = np.array([-1.7e-200, 1.0]), np.zeros(10, dtype=np.int64), np.zeros(2)
        with np.errstate(all="ignore"):
            found = int(entry(real, whole, tape, 5))
        results.append([found, *whole.tolist(), *tape.tolist()])
    assert results[0] == results[1]
    assert results[0][0] == 1
    assert results[1][-2:] == [math.inf, math.inf]


# --- motions ---------------------------------------------------------------------------------------------------------

MACHINES = {"pendulum": vc.PendulumCapsule, "oscillator": vc.Oscillator}


def system_of(machine, law):
    return vc.System(MACHINES[machine](), law, vc.Harmonic(amplitude=1.8))


def motions(system, entries, monkeypatch, periods):
    """The runs of one motion by several entries of its kernel."""
    kernel, found = kernel_of(system), []
    start = [1.0, *[0.0] * (len(system.state_names) - 1)]
    for make in entries:
        entry = make(kernel.text)
        monkeypatch.setattr(motion, "kernel", lambda *_, entry=entry: (kernel.layout, entry))
        numbers = equations(system), parameter_values(system), start, system.drive.period
        with np.errstate(all="ignore"):
            found.append(recorded_run(*numbers, periods, 1e-9, 1000, 10**6, order=12))
    return found


def assert_the_same(plain, found):
    assert plain.status == found.status == DONE
    assert plain.taylor_steps + plain.implicit_steps > 8
    assert (plain.taylor_steps, plain.implicit_steps) == (found.taylor_steps, found.implicit_steps)
    for name in ("pieces", "events", "final"):
        assert np.array_equal(getattr(plain, name), getattr(found, name), equal_nan=True), name


@pytest.mark.parametrize("law", ["exponential", "lugre"])
def test_a_motion_is_that_of_plain_python(law, tmp_path, monkeypatch):
    """Every piece and every event of the named capsules, to the last bit."""
    system = system_of("pendulum", laws()[law]())
    plain, found = motions(system, (plain_meaning, lambda text: InNode(text, tmp_path)), monkeypatch, 0.7)
    assert len(plain.events) > 0
    assert_the_same(plain, found)


@pytest.mark.parametrize(("machine", "law"), slow_but([0], [("pendulum", "exponential"), ("oscillator", "lugre")]))
def test_literal_machine_code_is_plain_python(machine, law, monkeypatch):
    """By it a page is checked: all sums and products rounded, the package's functions; Taylor and stiff steps."""
    system = system_of(machine, laws()[law]())
    plain, found = motions(system, (plain_meaning, lambda text: compiled_kernel(text, literal=True)), monkeypatch, 0.7)
    assert_the_same(plain, found)


@pytest.mark.slow
@pytest.mark.parametrize("machine", MACHINES)
@pytest.mark.parametrize("law", laws())
def test_motions_of_all_laws_are_those_of_plain_python(law, machine, tmp_path, monkeypatch):
    system = system_of(machine, laws()[law]())
    plain, found = motions(system, (plain_meaning, lambda text: InNode(text, tmp_path)), monkeypatch, 1.6)
    assert_the_same(plain, found)


@pytest.mark.slow
@pytest.mark.parametrize("law", ["exponential", "lugre", "smoothed-tanh"])
def test_motions_on_a_slope_are_those_of_plain_python(law, tmp_path, monkeypatch):
    outside = vc.Environment(inclination=0.1, linear_drag=0.2, quadratic_drag=0.3, force=0.05)
    capsule = vc.PendulumCapsule(normal_load="dynamic", mass_ratio=4.0)
    system = vc.System(capsule, laws()[law](), vc.Harmonic(amplitude=1.8), environment=outside)
    plain, found = motions(system, (plain_meaning, lambda text: InNode(text, tmp_path)), monkeypatch, 1.6)
    assert len(plain.events) > 0
    assert_the_same(plain, found)


@pytest.mark.slow
@pytest.mark.parametrize("law", ["coulomb", "lugre"])
@pytest.mark.parametrize(
    "machine",
    [
        vc.VibroImpactCapsule(back_gap=0.1),
        vc.RigidStopCapsule(gap=1.2, restitution=0.3),
        vc.PendulumCapsuleWithStops(limit_angle=1.1, restitution=0.6),
    ],
    ids=lambda machine: machine.name,
)
def test_motions_with_stops_are_those_of_plain_python(machine, law, tmp_path, monkeypatch):
    system = vc.System(machine, laws()[law](), vc.Harmonic(amplitude=1.8))
    plain, found = motions(system, (plain_meaning, lambda text: InNode(text, tmp_path)), monkeypatch, 1.6)
    assert {MACHINE_SWITCHED, MACHINE_SWITCHED + 2} & set(plain.events[:, 2])  # it strikes a stop
    assert_the_same(plain, found)


def test_a_swapped_subtraction_is_noticed(tmp_path, monkeypatch):
    """A planted fault: one difference of the series the other way round."""
    system = system_of("pendulum", vc.Exponential())
    text = kernel_of(system).text
    place = text.index("def exponential_parts")
    swapped = text[:place] + text[place:].replace(
        "r = r - k * 1.9082149292705877e-10", "r = k * 1.9082149292705877e-10 - r"
    )
    assert swapped != text
    plain, found = motions(system, (plain_meaning, lambda _: InNode(swapped, tmp_path)), monkeypatch, 0.7)
    with pytest.raises(AssertionError):
        assert_the_same(plain, found)


# --- refusals --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("line", "what"),
    [
        ("x = math.tan(1.0)", "of math it knows"),
        ("x = math.sin(real[0])", "no polynomials for `sin`"),
        ("x = rounds + 2**62", r"beyond 2\^53"),
        ("x = [1.0]", "`List`"),
        ("x = real", "cannot stand for"),
        ("x = load(real, 0)", "of lanes"),
    ],
)
def test_what_javascript_cannot_say_is_refused_with_its_place(line, what):
    head = "# From numerics/some_file.py\nimport math\n\nimport numpy as np\n\n"
    imported = "from vibrocap.numerics.kernel.arithmetic.plain_vectors import load\n\n" if "load" in line else ""
    with pytest.raises(Refused, match=what) as refused:
        javascript_text(f"{head}{imported}def advance(real, whole, tape, rounds):\n    {line}\n", "advance")
    assert "function `advance`" in str(refused.value)
