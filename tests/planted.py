"""Machines with a fault planted in what follows from their parts: certificates should find it."""

from collections.abc import Callable
from typing import Any

from vibrocap.mechanics import Machine, parameters


def planted(kind: type[Machine]) -> Callable[[type], Any]:
    """A decorator: the machine of a kind with the functions and constants of a class."""

    def of(body: type) -> Any:
        own = {name: value for name, value in vars(body).items() if name not in ("__dict__", "__weakref__")}
        table = {name: own.pop(name) for name in ("name", "__doc__", "__module__")}
        made = parameters(type(body.__name__, (kind,), table))
        for name, value in own.items():
            if not name.startswith("__"):
                setattr(made, name, value)
        return made

    return of
