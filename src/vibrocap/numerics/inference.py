"""Less work for Numba's type inference, which takes longer than LLVM does for a kernel."""

import contextlib
from collections.abc import Iterator
from typing import Any

from numba.core import types
from numba.core.types.functions import BaseFunction


def one_version(function: Any) -> Any:
    """The compiled function, with numbers that are known when it is compiled taken like any others.

    Numba makes a version of its own for every constant among the arguments (`on_event` of every kind of event). LLVM
    puts constants into what it inlines all the same, and those versions took a fifth of the time of a first use.
    """
    resolved = function.get_call_template

    def resolved_for_any(args: tuple, kws: dict) -> Any:
        return resolved(tuple(types.unliteral(kind) for kind in args), kws)

    function.get_call_template = resolved_for_any
    return function


@contextlib.contextmanager
def asked_once() -> Iterator[None]:
    """Within this context the type of an operation is asked for once per types of its arguments.

    Numba tries all that is known of an operator at every place where it stands, and a series is thousands of products
    and sums: a fifth to a third of the time of a first use. To be used by one thread at a time.
    """
    ask: Any = BaseFunction.get_call_type
    answers: dict[tuple, tuple] = {}

    def remembered(self: Any, context: Any, args: Any, kws: Any) -> Any:
        if kws:
            return ask(self, context, args, kws)
        key = (id(self), args)
        if key not in answers:
            answers[key] = self, ask(self, context, args, kws)  # with the operation, whose id is then no other's
        return answers[key][1]

    BaseFunction.get_call_type = remembered
    try:
        yield
    finally:
        BaseFunction.get_call_type = ask
