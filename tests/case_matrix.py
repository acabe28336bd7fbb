"""The cases and faces of the matrix of `test_faces.py`: which there are, and the case file of a row."""

import functools
import itertools
from typing import Any

import vibrocap as vc
from covering_array import Row, covering_array
from vibrocap.case.case import Case, case_text
from vibrocap.cli.commands.new import BENCH
from vibrocap.physics.catalogue import controllers, drives, law, laws, machines
from vibrocap.physics.parameters import parameter_table

PLAIN, SI = "dimensionless", "SI"
GIVEN, LEFT_OUT = "given", "left out"
PARTS = {
    "machine": tuple(machines()),
    "friction": (*laws(), "anisotropic-stribeck", "backlash-lugre", "viscous-coulomb", "smoothed-exponential"),
    "drive": (*drives(), "scheduled-harmonic"),
    "controller": ("", *controllers()),
}
FACES = {
    "units": (PLAIN, SI),
    "optional": (GIVEN, LEFT_OUT),
    "printed": ("table", "json"),
    "picture": (".png", ".svg", ".pdf"),
    "out": ((".nc", ".csv"), (".xlsx", ".mat")),
    "exported": (("c",), ("fmu", "mjcf")),
    "further": ("film", "sweep", "lab"),
}
# what a parameter that may be left out is where it is given; others are 0.5
VALUES = {"limit": 40.0, "command_limit": 60.0, "stop_stiffness": 25.0, "back_stop_stiffness": 30.0}
VALUES |= {"delay": 0.005, "quantum": 1e-3, "gravity": 1.0, **BENCH}  # less lifts the part off its feeder


def part(kind: Any, optional: str) -> Any:
    """A part, or scales, with the numbers that it needs, and those that may be left out given or not."""
    wanted = [each for each in parameter_table(kind) if not isinstance(each.default, int | float | str | tuple)]
    names = [each.name for each in wanted if each.default is not None or optional == GIVEN]
    return kind(**{name: VALUES.get(name, 0.5) for name in names})


@functools.cache
def system(machine: str, friction: str, drive: str, controller: str, units: str, optional: str) -> vc.System | None:
    """The system of a row; None where its parts refuse each other. With all that is optional also its surroundings."""
    kinds = {"machine": machines()[machine], "friction": law(friction), "drive": drives()[drive]}
    kinds |= {"controller": controllers()[controller]} if controller else {}
    scales = part(kinds["machine"].si_scales, optional) if units == SI else None
    try:
        variant = vc.System(**{name: part(kind, optional) for name, kind in kinds.items()}, units=scales)
    except ValueError:
        return None
    for name, kind in {"environment": vc.Environment, "actuator": vc.Actuator}.items() if optional == GIVEN else ():
        try:
            variant = vc.System.of_parts({**variant.parts, name: part(kind, optional)}, scales)
        except ValueError:  # a machine that knows no weight, a motion that is imposed
            continue
    return variant


def system_of(row: Row) -> vc.System | None:
    """That of a row."""
    return system(*(row[name] for name in (*PARTS, "units", "optional")))


def covering(faces: dict[str, tuple], apart: tuple[tuple[str, str], ...] = ()) -> tuple[Row, ...]:
    """Rows in which every kind of part meets every way to write it and every face, and these meet each other.

    Two kinds of parts need not meet: that is the matter of tests of motions; nor two factors of `apart`.
    """
    apart = (*itertools.combinations(PARTS, 2), *apart)
    found, never = covering_array(PARTS | faces, lambda row: system_of(row) is not None, apart)
    assert not never
    return tuple(found)


@functools.cache
def rows() -> tuple[Row, ...]:
    """The rows of the matrix."""
    return covering(FACES)


@functools.cache
def few_rows() -> tuple[Row, ...]:
    """Rows in which each kind of part stands, and faces meet each other, but not every kind every face."""
    return covering(FACES | {"shown": (True,)}, tuple(itertools.product(PARTS, FACES)))


@functools.cache
def every_kind() -> tuple[Row, ...]:
    """Each kind of part once, in SI, with what may be left out left out."""
    return covering({"units": (SI,), "optional": (LEFT_OUT,), "printed": ("json",)})


def text_of(row: Row) -> str:
    """The case file of a row, which runs for some periods."""
    found = system_of(row)
    assert found is not None
    return case_text(Case(found, periods=3, tolerance=1e-7), row["units"])
