"""Files of parts: laws, machines, drives and controllers that stand in a Python file of one's own, outside any package.

Loading such a file runs it, so it is done only where someone names the file: a case alone never makes code run.
"""

import copyreg
import hashlib
import importlib.util
import os
import sys
import traceback
from collections.abc import Iterable
from pathlib import Path
from types import ModuleType
from typing import Any

from vibrocap.inputs import read_input
from vibrocap.physics.catalogue import parts_in, register, unregister
from vibrocap.physics.parameters import parameter_table

LARGEST = 2**24  # bytes of a file
PREFIX = "vibrocap_parts_"  # of the names of modules: the name of the file and the beginning of its digest follow


_files: dict[type, tuple[Path, str]] = {}  # that parts were loaded from, with their digests


class PartsError(ValueError):
    """A file of parts that cannot be used, in words; it begins with the file."""


def load_parts(path: str | Path, digest: str | None = None) -> tuple[type, ...]:
    """Run a Python file and register every law, machine, drive and controller that it defines; returns their classes.

    A file that was loaded before and has not changed is not run again; one that has changed replaces its parts.
    digest: SHA-256 that the file has to have, line ends aside, where only that very file will do.
    Raises PartsError: no such file, one that fails (with the line), that defines no part, or parts that cannot be used.
    """
    path = Path(os.path.realpath(path))
    if path.suffix != ".py":
        raise PartsError(f"{path}: should be a Python file, whose name ends in .py")
    try:
        text = read_input(path, LARGEST + 1)
    except OSError as error:
        raise PartsError(f"{path}: cannot be read: {error.strerror or error}") from None
    if len(text) > LARGEST:
        raise PartsError(f"{path}: should be at most {LARGEST // 2**20} MB")
    own_digest = _digest(text)
    if digest is not None and own_digest != digest:
        raise PartsError(f"{path}: has changed: its digest is {own_digest[:12]}, the one asked for is {digest[:12]}")
    name = f"{PREFIX}{path.stem}_{_digest(os.fsencode(path) + text)[:16]}"
    module = sys.modules.get(name)
    if module is None:
        for old in _loaded():  # what the file was before, or a copy of it elsewhere
            if old.__file__ == str(path) or old.__dict__["__digest__"] == own_digest:
                _drop(old)
        module = _run(name, path, text, own_digest)
    parts = tuple(parts_in(module))
    try:
        if not parts:
            raise PartsError(f"{path}: defines no part: no class that extends Law, Machine, Drive or Controller")
        for part in parts:
            register(part)
            _files[part] = path, own_digest
            part.__reduce__ = _reduced  # type: ignore[method-assign,assignment]
    except (TypeError, ValueError) as error:
        _drop(module)
        raise error if isinstance(error, PartsError) else PartsError(f"{path}: {error}") from None
    return parts


def file_of(part: type) -> tuple[Path, str] | None:
    """The file that a part was loaded from, and its digest; None for a part from elsewhere."""
    return _files.get(part)


def _reduced(part: Any) -> tuple:
    """How an instance is made again in another process, which loads the same file: its module has no home."""
    if (place := file_of(type(part))) is None:  # a class elsewhere that extends one of a file
        return copyreg.__newobj__, (type(part),), vars(part)  # type: ignore[attr-defined]
    values = {info.name: getattr(part, info.name) for info in parameter_table(part)}
    return _made_again, (str(place[0]), place[1], type(part).__qualname__, values)


def _made_again(path: str, digest: str, name: str, values: dict[str, Any]) -> Any:
    return next(part for part in load_parts(path, digest) if part.__qualname__ == name)(**values)


def place_in_parts(error: BaseException) -> str | None:
    """Where in a file of parts an error arose, such as "mylaws.py, line 12, in force"; None where it did not."""
    files = {str(module.__file__) for module in _loaded()}
    return _place(error, files)


def error_place(error: BaseException, part: type) -> str | None:
    """Where in the file of a part an error arose; None where it did not."""
    module = sys.modules.get(part.__module__)
    return _place(error, [str(getattr(module, "__file__", None))])


def _place(error: BaseException, files: Iterable[str]) -> str | None:
    frames = [frame for frame in traceback.extract_tb(error.__traceback__) if frame.filename in files]
    if not frames:
        return None
    last = frames[-1]
    where = f"{Path(last.filename).name}, line {last.lineno}"
    return where if last.name == "<module>" else f"{where}, in {last.name}"


def _digest(text: bytes) -> str:
    """SHA-256 of a source; line ends do not count."""
    return hashlib.sha256(text.replace(b"\r\n", b"\n")).hexdigest()


def _run(name: str, path: Path, text: bytes, digest: str) -> ModuleType:
    spec = importlib.util.spec_from_loader(name, loader=None, origin=str(path))
    assert spec is not None
    module = importlib.util.module_from_spec(spec)
    module.__file__, module.__dict__["__digest__"] = str(path), digest
    sys.modules[name] = module  # dataclasses look their module up while it runs
    try:
        exec(compile(text, str(path), "exec"), module.__dict__)
    except SyntaxError as error:
        del sys.modules[name]
        raise PartsError(f"{path}: line {error.lineno}: {error.msg}") from None
    except (Exception, SystemExit) as error:
        del sys.modules[name]
        words = f"{type(error).__name__}: {error}"
        raise PartsError(f"{_place(error, [str(path)]) or path}: {words}") from None
    except BaseException:
        del sys.modules[name]
        raise
    return module


def _loaded() -> list[ModuleType]:
    return [module for name, module in list(sys.modules.items()) if name.startswith(PREFIX)]


def _drop(module: ModuleType) -> None:
    for part in parts_in(module):
        unregister(part)
    del sys.modules[module.__name__]
