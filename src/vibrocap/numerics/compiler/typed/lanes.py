"""What can be done with the numbers and choices of all lanes, and which kind it gives."""

import ast
from typing import TYPE_CHECKING

from vibrocap.numerics.compiler import kinds
from vibrocap.numerics.compiler.kinds import BOOL, ELEMENTS, FLOAT, FLOATS, INT, INTS, NOTHING, PLACES, Kind
from vibrocap.numerics.compiler.typed import nodes
from vibrocap.numerics.compiler.typed.nodes import Typed

if TYPE_CHECKING:
    from vibrocap.numerics.compiler.typed.values import Values

ARITHMETIC, LOGICAL = (ast.Add, ast.Sub, ast.Mult, ast.Div), (ast.BitAnd, ast.BitOr, ast.BitXor)
# Kinds of the arguments of the functions of `plain_vectors.py`, and of what they give.
PRIMITIVES: dict[str, tuple[tuple, Kind | str]] = {
    "align_stack": ((), NOTHING),
    "all_lanes": ((), PLACES),
    "load": ((FLOATS, INT), "numbers"),
    "store": ((FLOATS, INT, "numbers"), NOTHING),
    "where": (("choices", "numbers", "numbers"), "numbers"),
    "bits": (("choices",), INT),
    "floor": (("numbers",), "numbers"),
    "square_root": (("numbers",), "numbers"),
    "exponent": (("numbers",), "numbers"),
    "mantissa": (("numbers",), "numbers"),
    "power_of_two": (("numbers",), "numbers"),
}
OF_INTS = ("load", "store", "where")  # those that are of ints too
# Those that are also of one number, in kernels of lanes.
OF_ONE = ("where", "bits", "floor", "square_root", "exponent", "mantissa", "power_of_two")


def is_numbers(value: Typed) -> bool:
    """Whether it is a float per lane."""
    return value.kind.lanes > 0 and value.kind is kinds.numbers(value.kind.lanes)


def is_choices(value: Typed) -> bool:
    """Whether it is a yes or no per lane."""
    return value.kind.lanes > 0 and value.kind is kinds.choices(value.kind.lanes)


def number_kind(within: "Values", *values: Typed) -> Kind:
    """The kind in which an operation of these is done, of which at least one is of all lanes."""
    width = within.program.width
    return kinds.ints(width) if any(value.kind is kinds.ints(width) for value in values) else kinds.numbers(width)


def binary(within: "Values", node: ast.AST, op: ast.operator, left: Typed, right: Typed) -> Typed:
    """left op right, of which at least one is of all lanes."""
    name = type(op).__name__
    if is_choices(left) and is_choices(right) and type(op) in LOGICAL:
        return nodes.Binary(left.kind, name, left.kind, left, right)
    if type(op) not in ARITHMETIC or is_choices(left) or is_choices(right):
        raise within.refusal(node, "lanes have + - * / of numbers and & | ^ of choices; write where(...) for a choice")
    kind = number_kind(within, left, right)
    if kind is kinds.ints(within.program.width) and not isinstance(op, (ast.Add, ast.Sub)):
        raise within.refusal(node, "ints of lanes have + and - alone")
    return nodes.Binary(kind, name, kind, within.fitting(node, left, kind), within.fitting(node, right, kind))


def moved(within: "Values", node: ast.AST, op: ast.operator, left: Typed, right: Typed) -> Typed:
    """Places of all lanes that are an int further on."""
    if not isinstance(op, ast.Add) or {left.kind, right.kind} != {PLACES, INT}:
        raise within.refusal(node, "to places of all lanes an int is added")
    return nodes.Binary(PLACES, "Add", INT, left, right)


def unary(within: "Values", node: ast.AST, op: ast.unaryop, value: Typed) -> Typed:
    """op value."""
    if (is_numbers(value) and isinstance(op, ast.USub)) or (is_choices(value) and isinstance(op, ast.Invert)):
        return nodes.Unary(value.kind, type(op).__name__, value)
    raise within.refusal(node, "lanes have - of numbers and ~ of choices")


def compared(within: "Values", node: ast.AST, op: ast.cmpop, left: Typed, right: Typed) -> Typed:
    """Where a comparison holds."""
    if is_choices(left) or is_choices(right):
        raise within.refusal(node, "choices are not compared; use ^")
    kind = number_kind(within, left, right)
    left, right = within.fitting(node, left, kind), within.fitting(node, right, kind)
    return nodes.Compared(kinds.choices(kind.lanes), type(op).__name__, kind, left, right)


def magnitude(within: "Values", node: ast.AST, value: Typed) -> Typed:
    """abs(value)."""
    if not is_numbers(value):
        raise within.refusal(node, "choices have no magnitude")
    return nodes.Magnitude(value.kind, value)


def primitive(within: "Values", node: ast.Call, name: str, arguments: list[Typed]) -> Typed:
    """A call of one of the functions of `plain_vectors.py`."""
    if not within.program.width:
        raise within.refusal(node, f"`{name}` is of lanes; this target runs one motion alone")
    if name not in PRIMITIVES:
        raise within.refusal(node, f"lanes have no `{name}`")
    wanted, result = PRIMITIVES[name]
    if len(arguments) != len(wanted):
        raise within.refusal(node, f"`{name}` takes {len(wanted)} arguments")
    own = {"numbers": kinds.numbers(within.program.width), "choices": kinds.choices(within.program.width)}
    if name in OF_ONE and not any(argument.kind.lanes for argument in arguments):
        own = {"numbers": FLOAT, "choices": BOOL}
    whole = kinds.ints(within.program.width)
    if name in OF_INTS and any(argument.kind in (INTS, whole) for argument in arguments):
        own["numbers"], wanted = whole, tuple(INTS if kind is FLOATS else kind for kind in wanted)
    taken: list[Kind] = []
    for argument, kind in zip(arguments, wanted, strict=True):
        if kind in ELEMENTS and argument.kind != kind:
            raise within.refusal(node, f"`{name}` of {argument.kind.name}; it takes an {kind.name}")
        kind = own[kind] if isinstance(kind, str) else kind
        taken.append(BOOL if name == "where" and argument.kind is BOOL else kind)
        within.fitting(node, argument, taken[-1])
    kind_of_result = own[result] if isinstance(result, str) else result
    return nodes.Primitive(kind_of_result, name, tuple(arguments), tuple(taken))
