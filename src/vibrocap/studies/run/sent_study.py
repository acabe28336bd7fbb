"""A study with parts of one's own on its way to workers, which are sent no code: they load the same file or module."""

import dataclasses
import functools
import importlib
import socket
from collections.abc import Iterable
from typing import Any

from vibrocap.case.case import CaseError
from vibrocap.measures.measure import Measure
from vibrocap.physics.catalogue import register
from vibrocap.physics.part_files import PartsError, file_of, load_parts
from vibrocap.studies.plan.study import Study
from vibrocap.studies.store.writing import StoreError


@dataclasses.dataclass(frozen=True, eq=False)
class SentStudy:
    """A study on its way to workers that have to load its own parts first: its record, measures, and their sources."""

    record: dict[str, Any]
    measures: tuple[Measure, ...]
    sources: tuple[tuple[str, str], ...]

    @classmethod
    def of(cls, study: Study) -> "SentStudy":
        """The study as it is sent; CaseError for a part that workers could not find."""
        own = tuple(measure for measure in study.measures if isinstance(measure, Measure))
        return cls(study.record(), own, sources_of(study.own_parts.values()))

    def study(self) -> Study:
        """The study again; StoreError where this machine does not have its parts."""
        receive(self.sources)
        return Study.from_record(self.record, self.measures)


def sent(study: Study) -> Study | SentStudy:
    """A study as workers are sent it."""
    return SentStudy.of(study) if study.own_parts else study


def sources_of(parts: Iterable[type]) -> tuple[tuple[str, str], ...]:
    """Where workers find parts: (file, digest) or (module, name). CaseError for one that they cannot find."""
    found, complaints = [], []
    for part in parts:
        if (place := file_of(part)) is not None:
            found.append((str(place[0]), place[1]))
        elif part.__module__ == "__main__" or "<locals>" in part.__qualname__:
            complaints.append(
                f"{part.__qualname__} stands in {part.__module__}, where workers cannot find it; put it in a file of "
                "its own, and name that by --parts or load_parts"
            )
        else:
            found.append((part.__module__, part.__qualname__))
    if complaints:
        raise CaseError(complaints, "the study")
    return tuple(dict.fromkeys(found))


def receive(sources: Iterable[tuple[str, str]]) -> None:
    """Load the parts that a study needs; StoreError where this machine does not have them, or has others."""
    for place, what in sources:
        try:
            if place.endswith(".py"):
                load_parts(place, what)
            else:
                register(functools.reduce(getattr, what.split("."), importlib.import_module(place)))
        except (PartsError, ImportError, AttributeError) as error:
            raise StoreError(f"a worker on {socket.gethostname()} lacks parts of the study: {error}") from None
