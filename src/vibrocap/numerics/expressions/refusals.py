"""What cannot be recorded, and what to write instead: a kink, a jump or a branch is no one formula.

The messages name the line of the law that asked for it, for it is the user's own law whose author reads them.
"""

import operator
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any, NoReturn

FUNCTIONS = ("sin", "cos", "exp", "log", "sqrt", "tanh", "atan")
OUR_OWN = (str(Path(__file__).parent), str(Path(__file__).parents[2] / "physics" / "elementary.py"))
BRANCH = (
    "cannot branch on a value (if, max, min, a comparison): write `side` for the sign of the velocity and "
    "side * velocity for the speed; a law of several formulas names a switched state, with its guards in `switches`"
)
KINK = (
    "cannot hold a kink: write side * velocity for |velocity|; the sign of any other value is a switched state of the "
    "law, with its guard in `switches`"
)
JUMP = "cannot hold a jump: a law of several formulas names a switched state, with its guards in `switches`"
ELSEWHERE = (
    f"takes no functions of `math`, nor float() or int(): write {', '.join(FUNCTIONS)} or power of "
    "vibrocap.physics.elementary, or those of numpy"
)
# what numpy calls an operation: how it is recorded
UFUNCS: dict[str, Callable] = {
    "add": operator.add,
    "subtract": operator.sub,
    "multiply": operator.mul,
    "divide": operator.truediv,
    "true_divide": operator.truediv,
    "negative": operator.neg,
    "positive": operator.pos,
    "power": operator.pow,
    "float_power": operator.pow,
    "square": lambda x: x * x,
    "reciprocal": lambda x: 1.0 / x,
    "tan": lambda x: x.sin() / x.cos(),
    "arctan": lambda x: x.atan(),
    **{name: operator.methodcaller(name) for name in FUNCTIONS if name != "atan"},
}
KINKS, BRANCHES = ("absolute", "fabs"), ("maximum", "minimum", "fmax", "fmin", "sign", "heaviside", "clip")


class RecordingError(TypeError):
    """A formula that cannot be recorded, or too few of them: where, and what to write instead."""


class Recordable:
    """What a recorded expression says to the operations that it does not have, and to those of numpy."""

    __slots__ = ()

    def __array_ufunc__(self, ufunc: Any, method: str, *inputs: Any, **options: Any) -> Any:
        name = ufunc.__name__
        if name in KINKS:
            refuse(KINK)
        if name in BRANCHES or name.startswith(("greater", "less", "equal", "not_equal", "logical", "is")):
            refuse(BRANCH)
        if method != "__call__" or options or name not in UFUNCS:
            known = ", ".join(name for name in UFUNCS if name not in ("true_divide", "float_power"))
            refuse(f"does not know numpy's {name}: of numpy's functions there are {known}")
        if any(getattr(operand, "shape", ()) for operand in inputs):
            refuse("takes single numbers, no arrays: a law is recorded as one scalar formula")
        return UFUNCS[name](*(operand if isinstance(operand, Recordable) else float(operand) for operand in inputs))

    def __pos__(self):
        return self

    def __abs__(self):
        refuse(KINK)

    def __bool__(self):
        refuse(BRANCH)

    def _branch(self, _: Any):
        refuse(BRANCH)

    __eq__ = __ne__ = __lt__ = __le__ = __gt__ = __ge__ = _branch  # type: ignore[assignment]
    __hash__ = object.__hash__

    def _jump(self, _: Any = None):
        refuse(JUMP)

    __mod__ = __rmod__ = __floordiv__ = __rfloordiv__ = __divmod__ = __rdivmod__ = _jump
    __floor__ = __ceil__ = __trunc__ = __round__ = _jump

    def _elsewhere(self):
        refuse(ELSEWHERE)

    __float__ = __int__ = __index__ = __complex__ = _elsewhere


def refuse(reason: str) -> NoReturn:
    """Raise a RecordingError with the line that asked."""
    frame = sys._getframe(1)
    while frame.f_back is not None and (
        frame.f_code.co_filename.startswith(OUR_OWN) or frame.f_globals.get("__name__", "").startswith("numpy")
    ):
        frame = frame.f_back
    name = frame.f_code.co_name
    where = f"{Path(frame.f_code.co_filename).name}, line {frame.f_lineno}" + (f", in {name}" if name[0] != "<" else "")
    raise RecordingError(f"{where}: a recorded formula {reason}") from None
