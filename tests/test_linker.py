"""A kernel is linked from a recipe: each slot is filled once, as its interface says, no name twice or nowhere."""

import ast
import inspect

import pytest

import vibrocap as vc
from vibrocap.motion.held_input import with_held_input
from vibrocap.motion.recording.equations import equations, parameter_values
from vibrocap.numerics.kernel import interface
from vibrocap.numerics.linker import link, recipes
from vibrocap.numerics.linker.link import LinkError, check, file_of, outline
from vibrocap.numerics.run import motion
from vibrocap.numerics.run.ensemble import ensemble_source
from vibrocap.numerics.run.stepper import stepper_kernel

SLOTS = (*recipes.MEASURED, recipes.PASSAGE)
SYSTEM = vc.System(vc.PendulumCapsule(), vc.Exponential(), vc.Harmonic())
INTERFACE = inspect.getsource(interface)


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
    """Every law, alone, one by one, all lanes at once, on a GPU and in a browser."""
    linked()
    for law in (vc.Exponential(), vc.LuGre(), vc.MaxwellSlip()):
        recorded = equations(vc.System(vc.PendulumCapsule(), law, vc.Harmonic()))
        for lanes, loop in ((1, None), (8, None), (1, "gpu"), (1, "browser")):
            ensemble_source(recorded, 10, lanes, loop=loop)[1].check()


@pytest.mark.parametrize("law", [vc.Exponential(), vc.LuGre(), vc.MaxwellSlip()], ids=lambda law: law.name)
def test_steppers_are_linked(law):
    for drive in (vc.Harmonic(), vc.Square()):
        system = vc.System(vc.PendulumCapsule(), law, drive)
        for held_input in (False, True):
            asked = with_held_input(system) if held_input else system
            recorded = equations(asked)
            given = recorded.observables, 1e-9, held_input, parameter_values(asked)
            stepper_kernel(recorded, *given).text.check()


@pytest.mark.parametrize("slot", SLOTS, ids=lambda slot: slot.name)
def test_modules_of_a_slot_define_what_its_interface_says(slot):
    wanted = outline(INTERFACE).functions
    for module in slot.offers:
        given = outline(link.kernel_source(module)).functions
        assert {name: given.get(name) for name in slot.functions} == {name: wanted[name] for name in slot.functions}


def test_the_interface_holds_the_slots_and_nothing_else():
    functions = [name for slot in SLOTS for name in slot.functions]
    assert sorted(functions) == sorted(outline(INTERFACE).functions)
    documented = [node for node in ast.parse(INTERFACE).body if isinstance(node, ast.FunctionDef)]
    assert all(ast.get_docstring(node) for node in documented)


@pytest.mark.parametrize("slot", SLOTS, ids=lambda slot: slot.name)
def test_a_slot_that_is_empty_or_filled_twice_is_refused(slot):
    recipe = recipes.ensemble_recipe("ensemble", maybe_stiff=True, branches=True)
    if slot is recipes.PASSAGE:
        recipe = recipes.stepper_recipe(maybe_stiff=True, branches=True)
    (filler,) = set(recipe.modules) & set(slot.offers)
    other = next(module for module in slot.offers if module != filler)
    for modules, found in (
        (tuple(name for name in recipe.modules if name != filler), "no module"),
        ((*recipe.modules, other), " and by "),
    ):
        parts = {name: link.kernel_source(name) for name in modules}
        with pytest.raises(LinkError, match=f"the slot `{slot.name}` is filled by .*{found}"):
            check(recipes.Recipe(recipe.entry, modules, (slot,)), parts, INTERFACE)


@pytest.mark.parametrize(
    ("module", "right", "wrong", "message"),
    [
        (  # another order of arguments would be a wrong number, not an error
            "events.one_branch",
            "def first_switch(floats, lane, event, h)",
            "def first_switch(floats, lane, h, event)",
            r"kernel/events/one_branch.py: `first_switch\(floats, lane, h, event\)` should be `.*lane, event, h\)`",
        ),
        (
            "observe.record",
            "def on_period(",
            "def at_period(",
            r"kernel/observe/record.py fills the slot `observer` without `on_period\(floats, ints, trace, lane\)`",
        ),
        (  # as two functions called `spread` once did
            "step.taylor",
            "def last_terms(",
            "def value(a):\n    return a\n\n\ndef last_terms(",
            r"`value` is defined in kernel/arithmetic/roots.py and in kernel/step/taylor.py",
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
            r"kernel/loop/one_step.py, in `turn`: `turn_period` is defined in no part",
        ),
        ("loop.one_by_one", "def advance(", "def go_on(", "loop over lanes` without `advance"),
    ],
)
def test_a_fault_is_refused_and_its_file_is_named(module, right, wrong, message, monkeypatch):
    edit(monkeypatch, module, right, wrong)
    with pytest.raises(LinkError, match=message):
        linked()


def test_a_primitive_of_the_compiler_is_no_name_for_a_function(monkeypatch):
    edit(monkeypatch, "step.taylor_simd", "def lesser(", "def floor(x):\n    return x\n\n\ndef lesser(")
    with pytest.raises(LinkError, match=r"`floor` is defined in the compiler's primitives and in .*taylor_simd.py"):
        ensemble_source(equations(SYSTEM), 10, 8)[1].check()


def test_a_fault_is_refused_before_it_is_compiled(monkeypatch):
    edit(monkeypatch, "events.contact", "JUMP = 1e-6", "LEAP = 1e-6")
    motion.kernel.cache_clear()
    with pytest.raises(LinkError, match="`JUMP` is defined in no part of this kernel"):
        motion.kernel(equations(SYSTEM), 12)


def test_a_kernel_is_a_file_without_its_head():
    for recipe in (recipes.DRIVEN, recipes.ensemble_recipe("simd", maybe_stiff=True, branches=True)):
        for module in recipe.modules:
            path = link.KERNEL / f"{module.replace('.', '/')}.py"
            heads = (ast.Import, ast.ImportFrom, ast.Expr)
            body = [node for node in ast.parse(path.read_text("utf-8")).body if not isinstance(node, heads)]
            assert ast.dump(ast.parse(link.kernel_source(module))) == ast.dump(ast.Module(body, []))


def test_modules_import_what_runs():
    """What a module of the kernel imports from another one is what a kernel with it holds, of that other one."""
    every = [recipes.DRIVEN]
    for stiff in (False, True):
        for branches in (False, True):
            every.append(recipes.motion_recipe(stiff, branches))
            for tangent in (False, True):
                every += [
                    recipes.ensemble_recipe(loop, stiff and not tangent, branches, tangent)
                    for loop in ("ensemble", "simd", "gpu")
                ]
    promised = {"codes", "memory_layout", "driven_generated", "interface", "arithmetic.plain_vectors"}
    imports, strays = {}, set()
    for module in {module for recipe in every for module in recipe.modules}:
        path = link.KERNEL / f"{module.replace('.', '/')}.py"
        imports[module] = [node for node in ast.parse(path.read_text("utf-8")).body if isinstance(node, ast.ImportFrom)]
    for recipe in every:
        for module in recipe.modules:
            for node in imports[module]:
                home = (node.module or "").removeprefix("vibrocap.numerics.kernel.")
                for alias in node.names:
                    held = home in promised or home in recipe.modules or home.startswith("generated.")
                    if not held or alias.asname:
                        strays.add(f"{file_of(module)}: {alias.name} from {node.module}")
    assert strays == set()
