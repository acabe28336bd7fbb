"""Records whose numbers say what they are, and the same records in SI.

A record in SI is the record as it was computed, seen through its declarations: each field and property, each argument
and result of a method is converted when it is asked for. It is of the record's own class, so that all that shows a
record shows it; `dimensionless` is the record without units.
"""

import dataclasses
import enum
import functools
from collections.abc import Mapping
from typing import Any, ClassVar, Self, TypeVar

from vibrocap.arguments import complaints_of
from vibrocap.quantities.declared import Context, WithUnit
from vibrocap.quantities.hints import call_hints, declared_anywhere, field_hints, fitting, of_elements, undeclared

Value = TypeVar("Value")


class Dimensional:
    """A record that declares what its numbers are; see `vibrocap.quantities`.

    in_words: names of properties and methods that only put into words what the record's other members say
    given: whether it is made by users to ask for something, in the units of the system that they ask of
    in_record: names of the fields and properties that its views show; by default its fields, but for systems
    """

    given: ClassVar[bool] = False
    in_record: ClassVar[str] = ""

    in_words: ClassVar[tuple[str, ...]] = ("heading", "facts", "remarks", "text", "table", "dimensionless", "said")

    @property
    def dimensionless(self) -> Self:
        """The numbers without units: the record itself, unless it is in SI."""
        return self

    def unit_of(self, name: str) -> str:
        """The SI unit of a field or property, "1" for one that has none; so is each where nothing is in SI."""
        return "1"

    def said(self, name: str, digits: int = 10) -> str:
        """A number of the record in words, with its unit."""
        return said(getattr(self, name), self.unit_of(name), digits)

    def si_context(self) -> Context | None:
        """Where its numbers stand in SI; None where they are without units."""
        return None


def said(value: Any, unit: str, digits: int = 10) -> str:
    """A number in words, with its unit if it has one."""
    return f"{value:.{digits}g}" + ("" if unit == "1" else f" {unit}")


class InSI:
    """What a record in SI adds to its class: the record as it was computed, and where it stands."""

    _computed: Any
    _context: Context
    _converted: dict[str, Any]

    def __init__(self, *_: Any, **__: Any):
        raise TypeError("a result in SI is only shown; make another one of its `dimensionless`")

    @property
    def dimensionless(self) -> Any:
        """The numbers without units, of a system without units."""
        if "dimensionless" not in self._converted:
            self._converted["dimensionless"] = detached(self._computed)
        return self._converted["dimensionless"]

    def si_context(self) -> Context:
        """Where its numbers stand."""
        return self._context

    def unit_of(self, name: str) -> str:
        """The SI unit of a field or property, or else of a quantity of a motion; "1" for one that has none."""
        hints = member_hints(type(self._computed))
        if name not in hints:
            return self._context.units.unit(name)
        declared = declared_anywhere(hints[name])
        return "1" if declared is None else declared.unit(self._context.within(self._computed))

    def __eq__(self, other: object) -> bool:
        return type(other) is type(self) and other._computed == self._computed  # type: ignore[attr-defined]

    def __hash__(self) -> int:
        return hash(self._computed)

    def __reduce__(self):
        return shown, (self._computed, self._context)

    def __repr__(self) -> str:
        fields = dataclasses.fields(self._computed)
        words = (f"{field.name}={_in_words(self, field.name)}" for field in fields if field.repr)
        return f"{type(self).__name__}({', '.join(words)})"


def _in_words(record: InSI, name: str) -> str:
    """A field with its unit, or with those of what it holds by name."""
    value = getattr(record._computed, name)
    if isinstance(value, Dimensional) or undeclared(member_hints(type(record._computed))[name]):
        return repr(getattr(record, name)) if isinstance(value, Dimensional) else repr(value)
    return _of_units(member_view(record._computed, name, record._context))


def _of_units(value: Any) -> str:
    if isinstance(value, WithUnit):
        return f"{value.value!r} {value.unit}"
    if isinstance(value, Mapping):
        return "{" + ", ".join(f"{key!r}: {_of_units(one)}" for key, one in value.items()) + "}"
    if isinstance(value, list):
        return f"[{', '.join(map(_of_units, value))}]"
    return repr(value)


@functools.cache
def member_hints(cls: type) -> dict[str, Any]:
    """The types of the fields and properties of a record by name."""
    hints = {}
    for base in reversed(cls.__mro__):
        for name, member in vars(base).items():
            getter = member.fget if isinstance(member, property) else getattr(member, "func", None)
            if callable(getter):
                hints[name] = call_hints(getter).get("return", Any)
    return hints | (field_hints(cls) if dataclasses.is_dataclass(cls) else {})


@functools.cache
def _face(cls: type) -> type:
    """The class of the records of a class that are in SI."""
    members: dict[str, Any] = {"__module__": cls.__module__, "__qualname__": cls.__qualname__, "__doc__": cls.__doc__}
    hints, fields = member_hints(cls), {field.name for field in dataclasses.fields(cls)}
    for name in hints:
        if name in fields or (name not in cls.in_words and name not in vars(InSI)):
            members[name] = _shown_property(cls, name, hints[name])
    for name in dir(cls):
        if name in members or name in cls.in_words or name in _KEPT or name in vars(InSI):
            continue
        function = getattr(cls, name)
        if isinstance(vars(_home(cls, name))[name], (classmethod, staticmethod)):
            continue
        if type(function).__name__ == "function" and (not name.startswith("_") or name in _SEQUENCE):
            members[name] = _shown_method(cls, name, function)
    words = {"__repr__": cls.__repr__} if "__repr__" in _own(cls) else {}
    return type(cls.__name__, (InSI, cls), members | words)


_SEQUENCE = ("__getitem__", "__len__")  # `__iter__` gives what the members in SI are
_KEPT = ("to_xarray", "to_pandas")  # which are asked of the record in SI


def _home(cls: type, name: str) -> type:
    return next(base for base in cls.__mro__ if name in vars(base))


def _own(cls: type) -> set[str]:
    """Names that a class and its bases define themselves, what `dataclass` makes apart."""
    parameters = getattr(cls, "__dataclass_params__", None)
    own = {name for base in cls.__mro__[:-1] for name in vars(base)}
    return own - {"__repr__"} if parameters is not None and parameters.repr else own


def _shown_property(cls: type, name: str, hint: Any) -> property:
    def get(self: Any) -> Any:
        if name not in self._converted:
            _refuse(cls, name, hint)
            value = getattr(self._computed, name)
            self._converted[name] = walked(value, hint, self._context.within(self._computed))
        return self._converted[name]

    return property(get, doc=getattr(getattr(cls, name, None), "__doc__", None))


def _shown_method(cls: type, name: str, function: Any) -> Any:
    @functools.wraps(function)
    def method(self: Any, *args: Any, **kwargs: Any) -> Any:
        hints = call_hints(function)
        _refuse(cls, name, hints.get("return", Any))
        names = function.__code__.co_varnames[1 : function.__code__.co_argcount]
        named = dict(zip(names, args, strict=False)) | kwargs
        context = self._context.within(self._computed).within({k: x for k, x in named.items() if isinstance(x, str)})
        plain = {key: walked(value, hints.get(key, Any), context, back=True) for key, value in named.items()}
        rest, own = args[len(names) :], dict(plain)
        with complaints_of(named, plain):
            value = getattr(self._computed, name)(*(own.pop(key) for key in names[: len(args)]), *rest, **own)
        return walked(value, hints.get("return", Any), context)

    return method


def _refuse(cls: type, name: str, hint: Any) -> None:
    if undeclared(hint):
        raise AttributeError(f"{name} of a {cls.__name__} is known without units only: ask for dimensionless.{name}")


def walked(value: Any, hint: Any, context: Context, back: bool = False) -> Any:
    """A value of a type in SI, records and what they are listed in included; back: what is in SI as it was computed."""
    declared, own = fitting(hint, value)
    if declared is not None:
        return declared.converted(value, context, back)
    if isinstance(value, Dimensional):
        if back and value.given:
            hints, inside = field_hints(type(value)), context.within(value)
            fields = {name: walked(getattr(value, name), its, inside, back) for name, its in hints.items()}
            return dataclasses.replace(value, **fields)  # type: ignore[type-var]
        return computed(value) if back else shown(value, context)
    if isinstance(value, (tuple, list)) and not hasattr(value, "_fields"):
        pairs = zip(value, of_elements(own, len(value)), strict=True)
        return type(value)(walked(one, its, context, back) for one, its in pairs)
    if isinstance(value, dict):
        its = of_elements(own, 2)[1]
        return {name: walked(one, its, context, back) for name, one in value.items()}
    return value


def shown(record: Value, context: Context) -> Value:
    """A record in SI; one that is so already, as it is."""
    if isinstance(record, InSI):
        return record
    face = object.__new__(_face(type(record)))
    face.__dict__.update(_computed=record, _context=context.kept(), _converted={})
    return face


def in_si(record: Value, system: Any = None, **words: str) -> Value:
    """A record in SI where its system knows its scales, else as it is.

    system: that it belongs to, by default its own; words: what was asked for, such as over="drive.frequency_Hz"
    """
    system = getattr(record, "system", None) if system is None else system
    context = None if system is None else system.si_context()
    return record if context is None else walked(record, Any, context.within(words))


def view(result: Any) -> Any:
    """A result as every view shows it: dictionaries by the names of its members, lists, words, numbers, quantities.

    Each number with a unit is a `WithUnit`; a matrix of several quantities, such as states, is split by their names.
    """
    return _view(result, Any, Context(None))


def _view(value: Any, hint: Any, context: Context) -> Any:
    if isinstance(value, InSI):
        value, context = value._computed, value._context
    declared, own = fitting(hint, value)
    if declared is not None:
        return _view(declared.seen(value, context), Any, context)
    if dataclasses.is_dataclass(value) and not isinstance(value, (type, WithUnit)):
        return {name: member_view(value, name, context) for name in names_in_record(value)}
    if isinstance(value, Mapping):
        its = of_elements(own, 2)[1]
        return {str(name): _view(element, its, context) for name, element in value.items()}
    if isinstance(value, (tuple, list)):
        if names := getattr(value, "_fields", None):  # a named tuple
            return dict(zip(names, value, strict=True))
        return [_view(one, its, context) for one, its in zip(value, of_elements(own, len(value)), strict=True)]
    return value.value if isinstance(value, enum.Enum) else value


def member_view(record: Any, name: str, context: Context) -> Any:
    """A field or property of a record as views show it."""
    hint = member_hints(type(record)).get(name, Any)
    if context.system is not None and isinstance(record, Dimensional):
        _refuse(type(record), name, hint)
    return _view(getattr(record, name), hint, context.within(record))


def names_in_record(record: Any) -> tuple[str, ...]:
    """The members of a record that views show: those that its class names, by default its fields but for systems."""
    own = tuple(getattr(record, "in_record", "").split())
    fields = (field.name for field in dataclasses.fields(record) if field.repr)
    return own or tuple(name for name in fields if not _is_system(getattr(record, name)))


def _is_system(value: Any) -> bool:
    return hasattr(type(value), "si_context") and not isinstance(value, Dimensional)


def computed(value: Value) -> Value:
    """The record of which one in SI is the face; what is no such record, as it is."""
    return value._computed if isinstance(value, InSI) else value  # type: ignore[return-value]


def detached(value: Any) -> Any:
    """The same without the units of its system, records in it included."""
    if isinstance(value, InSI):
        return value.dimensionless
    if _is_system(value):
        return value.dimensionless
    if isinstance(value, Dimensional):
        old = {field.name: getattr(value, field.name) for field in dataclasses.fields(value)}  # type: ignore[arg-type]
        new = {name: detached(element) for name, element in old.items()}
        if all(new[name] is old[name] for name in old):
            return value
        record = object.__new__(type(value))
        record.__dict__.update({**vars(value), **new})
        return record
    if isinstance(value, (tuple, list)) and not hasattr(value, "_fields"):
        elements = [detached(element) for element in value]
        return value if all(a is b for a, b in zip(elements, value, strict=True)) else type(value)(elements)
    if isinstance(value, Mapping) and type(value) is dict:
        items = {name: detached(element) for name, element in value.items()}
        return value if all(items[name] is value[name] for name in items) else items
    return value
