"""Numbers and choices of all lanes as LLVM's own vectors: operators, and the primitives of `plain_vectors.py`.

Those that act on each lane alone are also of one number.

Whether LLVM turns a loop over lanes into vector instructions is a matter of luck with its aliasing checks; so lanes are
values. Additions and products may be contracted to fused ones, as everywhere in a kernel; nothing else is reordered, so
what a lane gets does not depend on its neighbours.
"""

from collections.abc import Callable
from typing import TYPE_CHECKING

from vibrocap.numerics.compiler.kinds import INT, NOTHING, PLACES, Kind, Value, choices, float_text, ints, of_lanes

if TYPE_CHECKING:
    from vibrocap.numerics.compiler.code import Code

ALIGNED_STACK = "noinline alignstack(64)"
ARITHMETIC = {"Add": "fadd", "Sub": "fsub", "Mult": "fmul", "Div": "fdiv"}
LOGICAL = {"BitAnd": "and", "BitOr": "or", "BitXor": "xor"}
FLIPPED = {"lt": "olt", "le": "ole", "gt": "ogt", "ge": "oge", "eq": "oeq", "ne": "une"}
OF_INTS = {"lt": "slt", "le": "sle", "gt": "sgt", "ge": "sge", "eq": "eq", "ne": "ne"}


def binary(code: "Code", op: str, left: Value, right: Value) -> Value:
    """left op right, of numbers, ints or choices of all lanes."""
    code_of = LOGICAL.get(op) or (op.lower() if _is_ints(left) else f"{ARITHMETIC[op]} contract")
    return code.emit(left.kind, f"{code_of} {left.kind.llvm} {left.text}, {right.text}")


def _is_ints(value: Value) -> bool:
    return value.kind is ints(value.kind.lanes)


def unary(code: "Code", op: str, value: Value) -> Value:
    """Minus of numbers, not of choices."""
    if op == "USub":
        return code.emit(value.kind, f"fneg contract {value.kind.llvm} {value.text}")
    ones = f"<{', '.join(['i1 true'] * value.kind.lanes)}>"
    return code.emit(value.kind, f"xor {value.kind.llvm} {value.text}, {ones}")


def compared(code: "Code", name: str, left: Value, right: Value) -> Value:
    """Where a comparison of numbers or ints holds."""
    condition = f"icmp {OF_INTS[name]}" if _is_ints(left) else f"fcmp {FLIPPED[name]}"
    return code.emit(choices(left.kind.lanes), f"{condition} {left.kind.llvm} {left.text}, {right.text}")


def intrinsic(code: "Code", name: str, value: Value) -> Value:
    """One of LLVM's own functions, of one number or of each lane."""
    kind, called = value.kind, f"@llvm.{name}.{f'v{value.kind.lanes}' if value.kind.lanes else ''}f64"
    code.need(f"declare {kind.llvm} {called}({kind.llvm})")
    return code.emit(kind, f"call {kind.llvm} {called}({kind.llvm} {value.text})")


def _same(kind: str, number: str, width: int) -> str:
    """A number in every lane; width 0: one number."""
    return f"<{', '.join([f'{kind} {number}'] * width)}>" if width else number


def _of_bits(x: Value) -> tuple[int, Kind]:
    """(lanes, kind) of the bits of a number, or of one per lane, seen as ints."""
    return x.kind.lanes, ints(x.kind.lanes) if x.kind.lanes else INT


def _align_stack(code: "Code") -> Value:
    """The stack of this function begins a cache line, and no vector on it straddles two.

    LLVM aligns to sixteen bytes; where the stack of a process happens to begin would decide what a step costs. The
    function is not inlined: its caller's stack would not be aligned.
    """
    code.attributes = f"nounwind {ALIGNED_STACK}"
    return Value(NOTHING, "")


def _all_lanes(code: "Code") -> Value:
    """Places of all lanes, of which the first is 0."""
    return Value(PLACES, "0")


def _load(code: "Code", array: Value, place: Value) -> Value:
    return code.read(of_lanes(array.kind, code.module.width), code.pointer(array, place))


def _store(code: "Code", array: Value, place: Value, value: Value) -> Value:
    code.do(f"store {value.kind.llvm} {value.text}, ptr {code.pointer(array, place)}, align 8")
    return Value(NOTHING, "")


def _where(code: "Code", choice: Value, yes: Value, no: Value) -> Value:
    kind = yes.kind.llvm
    return code.emit(yes.kind, f"select {choice.kind.llvm} {choice.text}, {kind} {yes.text}, {kind} {no.text}")


def _bits(code: "Code", choice: Value) -> Value:
    width = choice.kind.lanes
    if not width:
        return code.emit(INT, f"zext i1 {choice.text} to i64")
    packed = code.emit(INT, f"bitcast {choice.kind.llvm} {choice.text} to i{width}")
    return code.emit(INT, f"zext i{width} {packed.text} to i64")


def _exponent(code: "Code", x: Value) -> Value:
    width, whole = _of_bits(x)
    pattern = code.emit(whole, f"bitcast {x.kind.llvm} {x.text} to {whole.llvm}")
    shifted = code.emit(whole, f"lshr {whole.llvm} {pattern.text}, {_same('i64', '52', width)}")
    # As the last digits of 2^52 they are a float; a conversion costs processors without AVX-512 far more.
    digits = code.emit(whole, f"or {whole.llvm} {shifted.text}, {_same('i64', str((1023 + 52) << 52), width)}")
    number = code.emit(x.kind, f"bitcast {whole.llvm} {digits.text} to {x.kind.llvm}")
    offset = _same("double", float_text(2.0**52 + 1023.0), width)
    return code.emit(x.kind, f"fsub contract {x.kind.llvm} {number.text}, {offset}")


def _mantissa(code: "Code", x: Value) -> Value:
    width, whole = _of_bits(x)
    pattern = code.emit(whole, f"bitcast {x.kind.llvm} {x.text} to {whole.llvm}")
    kept = code.emit(whole, f"and {whole.llvm} {pattern.text}, {_same('i64', str(2**52 - 1), width)}")
    one = code.emit(whole, f"or {whole.llvm} {kept.text}, {_same('i64', str(1023 << 52), width)}")
    return code.emit(x.kind, f"bitcast {whole.llvm} {one.text} to {x.kind.llvm}")


def _power_of_two(code: "Code", k: Value) -> Value:
    width, whole = _of_bits(k)
    # The last binary digits of this sum are k + 1023, without a conversion.
    offset = _same("double", float_text(1.5 * 2.0**52 + 1023.0), width)
    digits = code.emit(k.kind, f"fadd contract {k.kind.llvm} {k.text}, {offset}")
    pattern = code.emit(whole, f"bitcast {k.kind.llvm} {digits.text} to {whole.llvm}")
    biased = code.emit(whole, f"shl {whole.llvm} {pattern.text}, {_same('i64', '52', width)}")
    return code.emit(k.kind, f"bitcast {whole.llvm} {biased.text} to {k.kind.llvm}")


PRIMITIVES: dict[str, Callable[..., Value]] = {
    "align_stack": _align_stack,
    "all_lanes": _all_lanes,
    "load": _load,
    "store": _store,
    "where": _where,
    "bits": _bits,
    "floor": lambda code, x: intrinsic(code, "floor", x),
    "square_root": lambda code, x: intrinsic(code, "sqrt", x),
    "exponent": _exponent,
    "mantissa": _mantissa,
    "power_of_two": _power_of_two,
}
