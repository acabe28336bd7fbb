"""A kernel is linked from a recipe: what it calls is answered once, as its interface says, no name twice or nowhere."""

import ast
import inspect
import re

import pytest

import vibrocap as vc
from vibrocap.motion.recording.equations import equations
from vibrocap.numerics import linker as link
from vibrocap.numerics.codegen.source import Integrands
from vibrocap.numerics.expressions.structure import Traits
from vibrocap.numerics.kernel import hook
from vibrocap.numerics.kernel.lane import Gathered, with_places
from vibrocap.numerics.kernel.memory_layout import Layout, gathered_entries
from vibrocap.numerics.linker import LinkError, check, file_of, outline
from vibrocap.numerics.run import motion
from vibrocap.numerics.run.ensemble import ensemble_source

SYSTEM = vc.System(vc.PendulumCapsule(), vc.Exponential(), vc.Harmonic())
HOOKS = inspect.getsource(hook)
SECTIONS = [re.findall(r"^def (\w+)", section, re.MULTILINE) for section in re.split(r"^# ", HOOKS, flags=re.M)[1:]]
KERNEL_MODULES = sorted(
    ".".join(path.relative_to(link.KERNEL).with_suffix("").parts)
    for path in link.KERNEL.rglob("*.py")
    if path.stem not in ("hook", "generated")
)


def layout_with(switches=1, **traits):
    """The memory of a motion of four states with these traits and a guard of its law."""
    return Layout(states=4, parameters=1, order=10, switches=switches, **traits)


def linked():
    """Links a recorded motion anew, whatever was linked before."""
    motion.kernel.cache_clear()
    try:
        return motion.kernel(equations(SYSTEM), 12, plain=True)
    finally:
        motion.kernel.cache_clear()


def edit(monkeypatch, module, right, wrong):
    """From now on a module of the kernel reads otherwise."""
    original = link.kernel_source
    assert right in original(module)
    changed = original(module).replace(right, wrong)
    monkeypatch.setattr(link, "kernel_source", lambda name: changed if name == module else original(name))


def test_what_is_offered_is_linked():
    """Every law, alone, one by one, all lanes at once, on another device and in a browser."""
    linked()
    for law in (vc.Exponential(), vc.LuGre(), vc.MaxwellSlip()):
        recorded = equations(vc.System(vc.PendulumCapsule(), law, vc.Harmonic()))
        for lanes, loop in ((1, None), (8, None), (1, "portable"), (1, "browser")):
            ensemble_source(recorded, 10, lanes, loop=loop)[1].check()


def test_a_module_defines_all_of_a_section_or_none_as_the_interface_says():
    wanted, answers = outline(HOOKS).functions, set()
    for module in KERNEL_MODULES:
        functions = outline(link.kernel_source(module)).functions
        answers |= functions.keys()
        assert {name: functions[name] for name in functions if name in wanted} == {
            n: wanted[n] for n in wanted if n in functions
        }
        for section in SECTIONS:  # of which what has no answer of its own stands and falls together
            must = {name for name in section if name not in link._answers()}
            assert must <= functions.keys() or not set(section) & functions.keys(), (module, section)
    assert wanted.keys() <= answers
    assert sorted(wanted) == sorted(name for section in SECTIONS for name in section)
    documented = [node for node in ast.parse(HOOKS).body if isinstance(node, ast.FunctionDef)]
    assert all(ast.get_docstring(node) for node in documented)


@pytest.mark.parametrize("left_out", ["step.method_choice", "observe.window", "observe.settle", "loop.one_by_one"])
def test_what_must_be_answered_and_is_not_is_refused(left_out):
    recipe = link.ensemble_recipe(layout_with(stiff=True), "ensemble")
    _, text = ensemble_source(equations(vc.System(vc.PendulumCapsule(), vc.MaxwellSlip(), vc.Harmonic())), 10, 1)
    text.check()
    assert left_out in recipe.modules
    parts = {name: part for name, part in text.parts.items() if name != left_out}
    with pytest.raises(LinkError, match="is defined in no part of this kernel"):
        check(text.recipe, parts)


@pytest.mark.parametrize("other", ["step.method_choice", "events.corners", "observe.record", "loop.simd_step"])
def test_what_is_answered_twice_is_refused(other):
    recipe = link.ensemble_recipe(layout_with(stiff=False, coefficients=1), "ensemble")
    twice = recipe.modules if other in recipe.modules else (*recipe.modules, other)
    parts = {f"{name} ": link.kernel_source(name) for name in twice} | {other: link.kernel_source(other)}
    with pytest.raises(LinkError, match=r"` is defined in .* and in "):
        check(recipe, parts)


@pytest.mark.parametrize(
    ("module", "right", "wrong", "message"),
    [
        (  # another order of arguments would be a wrong number, not an error
            "observe.record",
            "def on_piece(floats, ints, trace, lane, h)",
            "def on_piece(floats, ints, trace, h, lane)",
            r"kernel/observe/record.py: `on_piece\(floats, ints, trace, h, lane\)` should be `.*trace, lane, h\)`",
        ),
        (
            "observe.record",
            "def on_period(",
            "def at_period(",
            r"in `\w+`: `on_period` is defined in no part of this kernel; .* answer kernel/hook.py",
        ),
        (  # as two functions called `spread` once did
            "step.taylor",
            "def last_terms(",
            "def sign_changes(a):\n    return a\n\n\ndef last_terms(",
            r"`sign_changes` is defined in kernel/arithmetic/roots.py and in kernel/step/taylor.py",
        ),
        (
            "step.taylor",
            "def last_terms(",
            "EPSILON = 1e-3\n\n\ndef last_terms(",
            r"`EPSILON` is defined in kernel/arithmetic/roots.py and in kernel/step/taylor.py",
        ),
        (
            "step.taylor",
            "def last_terms(",
            "def jet(floats):\n    pass\n\n\ndef last_terms(",
            "`jet` is defined in the gen",
        ),
        ("step.taylor", "def last_terms(", "def move_to(x):\n    return x\n\n\ndef last_terms(", "taylor.py, twice"),
        (
            "events.contact",
            "JUMP = 1e-6",
            "LEAP = 1e-6",
            r"kernel/events/contact.py, in `\w+`: `JUMP` is defined in no part of this kernel",
        ),
        (
            "loop.one_step",
            "def turn_period(",
            "def turn_the_period(",
            r"kernel/loop/one_step.py, in `step`: `turn_period` is defined in no part",
        ),
        ("loop.one_by_one", "def advance(", "def go_on(", "the entry `advance` is defined in no part"),
    ],
)
def test_a_fault_is_refused_and_its_file_is_named(module, right, wrong, message, monkeypatch):
    edit(monkeypatch, module, right, wrong)
    with pytest.raises(LinkError, match=message):
        linked()


def test_a_primitive_of_the_compiler_is_no_name_for_a_function(monkeypatch):
    edit(monkeypatch, "loop.side_by_side", "def taylor_steps(", "def floor(x):\n    return x\n\n\ndef taylor_steps(")
    with pytest.raises(LinkError, match=r"`floor` is defined in the compiler's primitives and in .*side_by_side.py"):
        ensemble_source(equations(SYSTEM), 10, 8)[1].check()


def test_a_fault_is_refused_before_it_is_compiled(monkeypatch):
    edit(monkeypatch, "events.contact", "JUMP = 1e-6", "LEAP = 1e-6")
    motion.kernel.cache_clear()
    with pytest.raises(LinkError, match="`JUMP` is defined in no part of this kernel"):
        motion.kernel(equations(SYSTEM), 12)


def test_a_kernel_is_a_file_without_its_head():
    for recipe in (link.DRIVEN, link.ensemble_recipe(layout_with(stiff=True), "simd")):
        for module in recipe.modules:
            path = link.KERNEL / f"{module.replace('.', '/')}.py"
            heads = (ast.Import, ast.ImportFrom, ast.Expr)
            text = with_places(path.read_text("utf-8"))
            body = [node for node in ast.parse(text).body if not isinstance(node, heads)]
            assert ast.dump(ast.parse(link.kernel_source(module))) == ast.dump(ast.Module(body, []))


def test_names_of_a_lane_become_places():
    """Line by line, indices within indices too; a name that no lane has is refused."""
    text = "lane.transition[lane.run + 1] += 1  # of one\nh = lane.side[c] * shared.asked - stepper.input[k]\n"
    wanted = "ints[TRANSITION + (ints[RUN + lane] + 1) * LANES + lane] += 1  # of one\n"
    wanted += "h = floats[SIDE + c * LANES + lane] * ints[ASKED] - floats[INPUT + k]\n"
    assert with_places(text) == wanted
    assert with_places("for lane in every_lane():") == "for lane in range(LANES):"
    assert with_places("lane.row[c], at.guard_row[c], alone.row[c + 1]") == (
        "SERIES + c * (ORDER + 1) * LANES + lane, SWITCH + c * (ORDER + 1) * LANES, SERIES + (c + 1) * (ORDER + 1)"
    )
    assert with_places("lanes.slow[m], at.slow[m], at.time") == "load(floats, SLOW + m * LANES), SLOW + m * LANES, TIME"
    assert with_places("hook.on_event(floats)") == "on_event(floats)"
    with pytest.raises(ValueError, match=r"`lane.tme`: vibrocap.numerics.kernel.lane has no entry"):
        with_places("lane.tme = 0.0")
    gathered = [name for name, _ in gathered_entries(Traits(states=4, parameters=1), Integrands("", 2, 1), 1, 1, True)]
    assert [name.upper() for name in Gathered.__annotations__] == gathered


def test_modules_import_what_runs():
    """What a module of the kernel imports from another one is what a kernel with it holds, of that other one."""
    every = [link.DRIVEN]
    for stiff in (False, True):
        for switches in (0, 1):
            every.append(link.motion_recipe(layout_with(stiff=stiff, switches=switches)))
            for tangent in (False, True):
                layout = layout_with(stiff=stiff, switches=switches, tangent=tangent, coefficients=int(tangent))
                every += [link.ensemble_recipe(layout, loop) for loop in ("ensemble", "simd", "portable")]
    promised = {"codes", "lane", "memory_layout", "generated", "driven_generated", "hook", "arithmetic.plain_vectors"}
    imports, strays = {}, set()
    for module in {module for recipe in every for module in recipe.modules}:
        path = link.KERNEL / f"{module.replace('.', '/')}.py"
        imports[module] = [node for node in ast.parse(path.read_text("utf-8")).body if isinstance(node, ast.ImportFrom)]
    for recipe in every:
        for module in recipe.modules:
            for node in imports[module]:
                for alias in node.names:
                    home = f"{node.module}.hook" if alias.name == "hook" else node.module or ""
                    home = home.removeprefix("vibrocap.numerics.kernel.")
                    held = home in promised or home in recipe.modules
                    if not held or alias.asname:
                        strays.add(f"{file_of(module)}: {alias.name} from {node.module}")
    assert strays == set()
