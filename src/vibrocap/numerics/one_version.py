"""Functions of a kernel are compiled once each, whatever constants they are called with."""

from typing import Any

from numba.core import types


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
