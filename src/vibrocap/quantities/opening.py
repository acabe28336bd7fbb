"""The public functions: functions that take what is in SI, and answer in SI where what they are given is.

The rooms compute without units. A public function is given records in SI, and numbers in SI of a system that knows its
scales; what it returns is shown in SI. Where nothing given is in SI, the function is called as it stands.

A case is taken wherever a system is: with its start and its run, where the function takes them and they are not given.
"""

import functools
import inspect
import types
import typing
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, TypeVar

from vibrocap.arguments import ArgumentError, complaints_of, listed, shown
from vibrocap.quantities.declared import Context
from vibrocap.quantities.dimensional import walked
from vibrocap.quantities.hints import call_hints

# What the first argument of a function is, by its name.
WANTED = {
    "system": "a System, vc.System(machine, friction, drive), or a case, vc.read_case(...)",
    "motion": "a motion, as vc.simulate gives it",
}
# Kinds of arguments that are nothing else.
KINDS = {Mapping: 'a mapping by name, {"name": value}', Path: "a path", Iterable: "a list"}
Function = TypeVar("Function", bound=Callable[..., Any])


def opened_in_si(function: Function) -> Function:
    """A function as users call it."""
    signature = inspect.signature(function)
    defaults = {
        name: parameter.default
        for name, parameter in signature.parameters.items()
        if parameter.default is not parameter.empty
    }

    first, parameter = next(iter(signature.parameters.items()))
    wanted = None if parameter.annotation in (Any, parameter.empty) else WANTED.get(first)

    @functools.wraps(function)
    def opened(*args: Any, **kwargs: Any) -> Any:
        given = args[0] if args else kwargs.get(first)
        if wanted and given is not None and not hasattr(type(given), "si_context"):
            raise ArgumentError(first, f"should be {wanted}, got {shown(given)}")
        try:
            return answered(args, kwargs)
        except (TypeError, AttributeError):
            _check_kinds(signature, {**dict(zip(signature.parameters, args, strict=False)), **kwargs})
            raise

    def answered(args: tuple[Any, ...], kwargs: dict[str, Any]) -> Any:
        context = _context((*args, *kwargs.values()))
        cases = any(hasattr(type(argument), "is_case") for argument in (*args, *kwargs.values()))
        if context is None and not cases:
            return function(*args, **kwargs)
        try:
            bound = signature.bind(*args, **kwargs)
        except TypeError:
            return function(*args, **kwargs)  # which says what is wrong
        hints = call_hints(function)
        if cases:
            _take_cases(bound, hints)
        if context is None:
            return function(*bound.args, **bound.kwargs)
        originals, inside = dict(bound.arguments), context.within(defaults | bound.arguments)
        for name, value in originals.items():
            bound.arguments[name] = walked(value, hints.get(name, Any), inside, back=True)
        with complaints_of(originals, bound.arguments):
            result = function(*bound.args, **bound.kwargs)
        return walked(result, hints.get("return", Any), inside)

    opened.__module__ = "vibrocap"  # where it is found, also by pickle
    return opened  # type: ignore[return-value]


def _check_kinds(signature: inspect.Signature, given: Mapping[str, Any]) -> None:
    """ArgumentError for what is no mapping or no list where nothing else may be."""
    for name, value in given.items():
        hint = signature.parameters[name].annotation if name in signature.parameters else Any
        members = typing.get_args(hint) if typing.get_origin(hint) in (typing.Union, types.UnionType) else (hint,)
        plain = [typing.get_args(each)[0] if typing.get_origin(each) is typing.Annotated else each for each in members]
        origins = [typing.get_origin(each) or each for each in plain]
        kinds: Any = tuple(Iterable if each is Sequence else each for each in origins)  # such as an array
        what = listed([words for kind, words in KINDS.items() if kind in kinds], " or ")
        if what and {*kinds} <= {*KINDS, str, types.NoneType} and not isinstance(value, kinds):
            raise ArgumentError(name, f"should be {what}, got {shown(value)}")


def _take_cases(bound: inspect.BoundArguments, hints: Mapping[str, Any]) -> None:
    """Put the system of a case in its place where a system is meant, and its start and run where none are given."""
    names = bound.signature.parameters
    others = next((name.name for name in names.values() if name.kind is name.VAR_KEYWORD), None)  # such as **settings
    for name, case in tuple(bound.arguments.items()):
        kinds = typing.get_args(hints.get(name)) or (hints.get(name),)
        if hasattr(type(case), "is_case") and type(case.system) in kinds and type(case) not in kinds:
            goes_on = hasattr(bound.arguments.get("start"), "state")  # a motion, from its end
            own = ({} if goes_on else {"initial": case.initial}) | case.run
            if others is None and not all(key in names for key in case.run):  # what it means by some is another thing
                own = {key: x for key, x in own.items() if key == "initial" and key in names}
            bound.arguments |= {name: case.system}
            bound.arguments |= {key: x for key, x in own.items() if key in names and key not in bound.arguments}
            if others is not None:
                rest = {key: x for key, x in own.items() if key not in names}
                bound.arguments[others] = rest | bound.arguments.get(others, {})


def _context(arguments: tuple[Any, ...]) -> Context | None:
    """Where the numbers of a call stand in SI; None where nothing that is given is in SI."""
    for argument in arguments:
        if hasattr(type(argument), "si_context"):
            context = argument.si_context()
        elif isinstance(argument, Mapping):
            context = _context(tuple(argument.values()))
        elif isinstance(argument, (tuple, list)) and argument and not isinstance(argument[0], (int, float, str)):
            context = _context(tuple(argument))
        else:
            continue
        if context is not None:
            return Context(context.system)
    return None
