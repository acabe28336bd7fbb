"""Lanes as one value: a number, or a yes or no, for each of WIDTH trajectories, kept in vector registers.

Numba knows no such type, and whether LLVM turns a loop over lanes into vector instructions is a matter of luck with its
aliasing checks. So the type is made here, of LLVM's own vector types, with the few operations that kernels need.
`plain_vectors.py` offers the same names on NumPy arrays, for kernels that run as plain Python.

Additions and products may be contracted to fused ones, like everywhere in a kernel; nothing else is reordered, so what
a lane gets does not depend on its neighbours.
"""

import operator

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.core.typing.templates import AbstractTemplate, infer_global, signature
from numba.extending import intrinsic, lower_builtin, models, register_model

from vibrocap.numerics.registers import lane_count

WIDTH = lane_count()
CONTRACT = ("contract",)


class Numbers(types.Type):
    """A double per lane."""

    def __init__(self):
        super().__init__(name=f"Numbers{WIDTH}")


class Choices(types.Type):
    """A yes or no per lane."""

    def __init__(self):
        super().__init__(name=f"Choices{WIDTH}")


numbers, choices = Numbers(), Choices()
DOUBLE, INTEGER, BIT = ir.DoubleType(), ir.IntType(64), ir.IntType(1)
DOUBLES, INTEGERS, BITS = (ir.VectorType(kind, WIDTH) for kind in (DOUBLE, INTEGER, BIT))


@register_model(Numbers)
class NumbersModel(models.PrimitiveModel):
    """Stored as an LLVM vector of doubles."""

    def __init__(self, manager, kind):
        super().__init__(manager, kind, DOUBLES)


@register_model(Choices)
class ChoicesModel(models.PrimitiveModel):
    """Stored as an LLVM vector of bits."""

    def __init__(self, manager, kind):
        super().__init__(manager, kind, BITS)


def _spread(builder, value, kind):
    """The same scalar in every lane."""
    empty = ir.Constant(kind, ir.Undefined)
    first = builder.insert_element(empty, value, ir.Constant(ir.IntType(32), 0))
    lanes = ir.Constant(ir.VectorType(ir.IntType(32), WIDTH), [0] * WIDTH)
    return builder.shuffle_vector(first, empty, lanes)


def _wide(context, builder, value, kind):
    """A number of the kernel as a vector."""
    if isinstance(kind, Numbers):
        return value
    return _spread(builder, context.cast(builder, value, kind, types.float64), DOUBLES)


def _operator(function, instruction, arguments, result) -> None:
    """Teach Numba one operator: its type, and the LLVM instruction that does it."""

    @infer_global(function)  # pyright: ignore[reportOptionalCall]
    class _Template(AbstractTemplate):
        def generic(self, args, kws):
            if not kws and any(isinstance(kind, arguments) for kind in args) and all(map(fits, args)):
                return signature(result, *args)
            return None

    def fits(kind):
        return isinstance(kind, (Numbers, types.Float, types.Integer) if arguments is Numbers else Choices)

    def lower(context, builder, sig, args):
        given = zip(args, sig.args, strict=True)
        wide = [_wide(context, builder, *pair) if arguments is Numbers else pair[0] for pair in given]
        return instruction(builder, *wide)

    if function in (operator.neg, operator.invert, abs):
        lower_builtin(function, arguments)(lower)
        return
    lower_builtin(function, arguments, arguments)(lower)
    for scalar in (types.Float, types.Integer) if arguments is Numbers else ():
        lower_builtin(function, arguments, scalar)(lower)
        lower_builtin(function, scalar, arguments)(lower)


def _call(builder, name, x):
    """One of LLVM's own functions of one double, on a vector."""
    kind = ir.FunctionType(DOUBLES, [DOUBLES])
    return builder.call(cgutils.get_or_insert_function(builder.module, kind, f"{name}.v{WIDTH}f64"), [x])


_operator(operator.add, lambda b, x, y: b.fadd(x, y, flags=CONTRACT), Numbers, numbers)
_operator(operator.sub, lambda b, x, y: b.fsub(x, y, flags=CONTRACT), Numbers, numbers)
_operator(operator.mul, lambda b, x, y: b.fmul(x, y, flags=CONTRACT), Numbers, numbers)
_operator(operator.truediv, lambda b, x, y: b.fdiv(x, y, flags=CONTRACT), Numbers, numbers)
_operator(operator.neg, lambda b, x: b.fneg(x, flags=CONTRACT), Numbers, numbers)
_operator(abs, lambda b, x: _call(b, "llvm.fabs", x), Numbers, numbers)
_operator(operator.lt, lambda b, x, y: b.fcmp_ordered("<", x, y), Numbers, choices)
_operator(operator.le, lambda b, x, y: b.fcmp_ordered("<=", x, y), Numbers, choices)
_operator(operator.gt, lambda b, x, y: b.fcmp_ordered(">", x, y), Numbers, choices)
_operator(operator.ge, lambda b, x, y: b.fcmp_ordered(">=", x, y), Numbers, choices)
_operator(operator.eq, lambda b, x, y: b.fcmp_ordered("==", x, y), Numbers, choices)
_operator(operator.and_, lambda b, x, y: b.and_(x, y), Choices, choices)
_operator(operator.or_, lambda b, x, y: b.or_(x, y), Choices, choices)
_operator(operator.xor, lambda b, x, y: b.xor(x, y), Choices, choices)
_operator(operator.invert, lambda b, x: b.not_(x), Choices, choices)


def _place(context, builder, array_kind, array, place, place_kind, kind):
    """Pointer to a vector within an array."""
    made = context.make_array(array_kind)(context, builder, array)
    offset = context.cast(builder, place, place_kind, types.uintp)
    return builder.bitcast(builder.gep(made.data, [offset]), kind.as_pointer())


@intrinsic
def load(typing, array, place):
    """load(real, place): the numbers of all lanes at a place."""

    def code(context, builder, sig, args):
        pointer = _place(context, builder, sig.args[0], args[0], args[1], sig.args[1], DOUBLES)
        return builder.load(pointer, align=8, typ=DOUBLES)

    return numbers(array, place), code


@intrinsic
def align_stack(typing):
    """align_stack(): the stack of the calling function begins a cache line, and no vector on it straddles two.

    LLVM aligns to sixteen bytes; where the stack of a process happens to begin would decide what a step costs. The
    function is not inlined: its caller's stack would not be aligned.
    """

    def code(context, builder, sig, args):
        builder.function.attributes.add("nounwind")  # true of all kernels: llvmlite drops an alignment that is alone
        builder.function.attributes.add("noinline")
        builder.function.attributes.alignstack = 64
        return context.get_dummy_value()

    return types.void(), code


@intrinsic
def store(typing, array, place, value):
    """store(real, place, numbers): write the numbers of all lanes."""

    def code(context, builder, sig, args):
        pointer = _place(context, builder, sig.args[0], args[0], args[1], sig.args[1], DOUBLES)
        builder.store(_wide(context, builder, args[2], sig.args[2]), pointer, align=8)
        return context.get_dummy_value()

    return types.void(array, place, value), code


def _integers(context, builder, kinds, args):
    """(pointer, numbers of all lanes there, the third argument as a scalar if there is one)."""
    pointer = _place(context, builder, kinds[0], args[0], args[1], kinds[1], INTEGERS)
    value = context.cast(builder, args[2], kinds[2], types.int64) if len(args) > 2 else None
    return pointer, builder.load(pointer, align=8, typ=INTEGERS), value


@intrinsic
def whole_equal(typing, array, place, value):
    """whole_equal(whole, place, value): in which lanes the entry of `whole` is the value."""

    def code(context, builder, sig, args):
        _, found, wanted = _integers(context, builder, sig.args, args)
        return builder.icmp_signed("==", found, _spread(builder, wanted, INTEGERS))

    return choices(array, place, value), code


@intrinsic
def whole_above(typing, array, place, value):
    """whole_above(whole, place, value): in which lanes the entry of `whole` is greater than the value."""

    def code(context, builder, sig, args):
        _, found, wanted = _integers(context, builder, sig.args, args)
        return builder.icmp_signed(">", found, _spread(builder, wanted, INTEGERS))

    return choices(array, place, value), code


@intrinsic
def whole_reached(typing, array, first, second, least):
    """whole_reached(whole, first, second, least): where the sum of two entries is at least a third."""

    def code(context, builder, sig, args):
        found = [_integers(context, builder, (sig.args[0], sig.args[i]), (args[0], args[i]))[1] for i in (1, 2, 3)]
        return builder.icmp_signed(">=", builder.add(found[0], found[1]), found[2])

    return choices(array, first, second, least), code


@intrinsic
def whole_add(typing, array, place, value, chosen):
    """whole_add(whole, place, value, choices): add the value to the entry of the chosen lanes."""

    def code(context, builder, sig, args):
        pointer, found, value = _integers(context, builder, sig.args, args)
        added = builder.add(found, _spread(builder, value, INTEGERS))
        builder.store(builder.select(args[3], added, found), pointer, align=8)
        return context.get_dummy_value()

    return types.void(array, place, value, chosen), code


@intrinsic
def whole_set(typing, array, place, value, chosen):
    """whole_set(whole, place, value, choices): put the value into the entry of the chosen lanes."""

    def code(context, builder, sig, args):
        pointer, found, value = _integers(context, builder, sig.args, args)
        builder.store(builder.select(args[3], _spread(builder, value, INTEGERS), found), pointer, align=8)
        return context.get_dummy_value()

    return types.void(array, place, value, chosen), code


@intrinsic
def where(typing, chosen, yes, no):
    """where(choices, yes, no): per lane one of two numbers."""

    def code(context, builder, sig, args):
        wide = [_wide(context, builder, args[i], sig.args[i]) for i in (1, 2)]
        return builder.select(args[0], *wide)

    return numbers(chosen, yes, no), code


@intrinsic
def bits(typing, chosen):
    """bits(choices): as an integer, bit i for lane i."""

    def code(context, builder, sig, args):
        packed = builder.bitcast(args[0], ir.IntType(WIDTH))
        return builder.zext(packed, INTEGER)

    return types.int64(chosen), code


@intrinsic
def floor(typing, x):
    """Largest whole number not above, per lane."""
    return numbers(x), lambda context, builder, sig, args: _call(builder, "llvm.floor", args[0])


@intrinsic
def square_root(typing, x):
    """Square root per lane."""
    return numbers(x), lambda context, builder, sig, args: _call(builder, "llvm.sqrt", args[0])


@intrinsic
def exponent(typing, x):
    """Exponent e of x = m 2^e with 1 <= m < 2, per lane, for normal x > 0."""

    def code(context, builder, sig, args):
        shifted = builder.lshr(builder.bitcast(args[0], INTEGERS), ir.Constant(INTEGERS, [52] * WIDTH))
        # As the last digits of 2^52 they are a float; a conversion costs processors without AVX-512 far more.
        digits = builder.or_(shifted, ir.Constant(INTEGERS, [(1023 + 52) << 52] * WIDTH))
        return builder.fsub(builder.bitcast(digits, DOUBLES), ir.Constant(DOUBLES, [2.0**52 + 1023.0] * WIDTH))

    return numbers(x), code


@intrinsic
def mantissa(typing, x):
    """m of x = m 2^e with 1 <= m < 2, per lane, for normal x > 0."""

    def code(context, builder, sig, args):
        kept = builder.and_(builder.bitcast(args[0], INTEGERS), ir.Constant(INTEGERS, [2**52 - 1] * WIDTH))
        return builder.bitcast(builder.or_(kept, ir.Constant(INTEGERS, [1023 << 52] * WIDTH)), DOUBLES)

    return numbers(x), code


@intrinsic
def power_of_two(typing, k):
    """2^k per lane, for whole numbers k from -1022 to 1023."""

    def code(context, builder, sig, args):
        # The last binary digits of this sum are k + 1023, without a conversion.
        digits = builder.fadd(args[0], ir.Constant(DOUBLES, [1.5 * 2.0**52 + 1023.0] * WIDTH))
        biased = builder.shl(builder.bitcast(digits, INTEGERS), ir.Constant(INTEGERS, [52] * WIDTH))
        return builder.bitcast(biased, DOUBLES)

    return numbers(k), code
