"""`vibrocap new`: a case to begin with, or a case in the other form."""

import dataclasses
from pathlib import Path
from typing import Literal

from vibrocap.arguments import Complaints, Refusal, by_option, suggestion
from vibrocap.case.case import case_text
from vibrocap.case.sections import CHOICES, DIMENSIONLESS, SI
from vibrocap.cli import completers
from vibrocap.cli.command import Answer, WithParts, command
from vibrocap.cli.new_case import new_case
from vibrocap.cli.options import file, option
from vibrocap.cli.texts import pairs, split
from vibrocap.files import write_text
from vibrocap.io.motion_file import read_source
from vibrocap.physics.dimensions.scales import Scales
from vibrocap.physics.dimensions.units import UNDECLARED, undeclared
from vibrocap.physics.parameters import ParameterError, parameter_table


class NewRequest(WithParts):
    kind: str = option(
        'of the machine, such as pendulum-capsule or oscillator; "mechanism" for one of your own',
        "pendulum-capsule",
        place=True,
        offers=completers.machine_names,
    )
    law: str = option("of friction, see `vibrocap list laws`", "exponential", offers=completers.law_names)
    drive: str = option("its waveform, see `vibrocap list drives`", "harmonic", offers=completers.drive_names)
    si: bool = option("a case in SI, of a bench of a usual size", False)
    from_: Path | None = option(
        "a case file (.toml) or exported motion to write in the other form, SI or without units"
    )
    out: Path | None = file("FILE.toml to write [default: print it]", ".toml")
    overwrite: bool = option("write it even if there is such a file", False)
    to: Literal["SI", "dimensionless"] | None = option(
        "the form of --from [default: the other form than that of the case]", needs="from_", advanced=True
    )
    scales: list[str] | None = option(
        "KEY=VALUE, the units of the machine of --from, where the case does not give them; replaces its own",
        needs="from_",
        advanced=True,
    )

    @property
    def chosen(self) -> dict[str, str]:
        """The names of machine, friction law and drive."""
        return {"machine": self.kind, "friction": self.law, "drive": self.drive}

    def refuse(self) -> None:
        """A case that is converted is read first, so that it is not replaced."""
        if self.from_ is not None:
            read_source(self.from_)
        super().refuse()

    def plan(self, refused: Complaints) -> None:
        """Known kinds of parts, and a file that does not exist."""
        options = {"machine": "KIND", "friction": "--law", "drive": "--drive"}
        for part, name in self.chosen.items():
            known = CHOICES[part][1]()
            if name not in known and (part, name) != ("machine", "mechanism"):
                refused.add(options[part], f"there is no {name!r}; {suggestion(name, known)}")
        if self.out is not None and self.out.exists() and not (self.overwrite or self.from_):
            refused.add("--out", f"{str(self.out)!r} is there already; name another file, or say --overwrite")


@command(
    "start",
    "vibrocap new --out case.toml",
    "vibrocap new --si --out bench.toml",
    "vibrocap new oscillator --law dahl --drive ramp",
    "vibrocap new --from bench.toml --out bench-without-units.toml",
    "vibrocap new --from examples/travels-by-stick-slip.toml --scales pendulum_mass_kg=0.2,pendulum_length_m=0.25",
)
def new(request: NewRequest) -> Answer:
    """A new case, or a case in SI or without units.

    A new case has every parameter of its parts with its default, its symbol and its meaning. With --from, a case is
    written in the other form: in SI, or without units; its comments are not kept. A case in SI knows its units, and so
    does the file without units that is made of it, in its section [scales]: the way back gives the same numbers. Of any
    other case --scales gives them.
    """
    converted = request.from_ is not None
    text = _converted(request) if converted else new_case(request.chosen, str(request.out or "case.toml"), request.si)
    if request.out is None:
        return Answer(text=text.removesuffix("\n"))
    write_text(request.out, text)
    next_ = "" if converted else f"\nNext: vibrocap simulate {request.out}"
    return Answer(text=f"Written: {request.out}{next_}")


def _converted(request: NewRequest) -> str:
    """A case in the other form."""
    refused = Complaints()
    assert request.from_ is not None
    given = pairs("scales", split(request.scales), refused, "KEY=VALUE, such as pendulum_mass_kg=0.2")
    setup = read_source(request.from_)
    known = setup.system.units or setup.scales
    wanted = request.to or (DIMENSIONLESS if setup.system.units is not None else SI)
    record = setup.system.machine.si_scales
    with refused.collected():
        if given:
            known = _scales(record, given)
    if known is None and parameter_table(record) and wanted == SI and not refused:
        infos = (info for info in parameter_table(record) if not isinstance(info.default, (float, type(None))))
        fields = ", ".join(f"{info.name} ({info.meaning})" for info in infos)
        refused.add("--scales", f"is missing; the case does not say what its units are; give {fields}")
    for name, part in setup.system.parts.items() if wanted == SI else ():
        for parameter in undeclared(type(part)):
            refused.add(f"{name}.{parameter}", UNDECLARED)
    if refused:
        raise Refusal(*refused)
    plain = dataclasses.replace(setup.system, units=None)  # the scales are kept beside; results stay without units
    return case_text(dataclasses.replace(setup, system=plain, scales=known), wanted)


def _scales(record: type, given: dict[str, str]) -> Scales:
    """The scales that an option gives; Refusal with every complaint."""
    known = {info.name: info for info in parameter_table(record)}
    complaints, values = Complaints(), {}
    for name, text in given.items():
        if name not in known:
            complaints.add(f"--scales {name}", f"no such key; {suggestion(name, known)}")
            continue
        try:
            values[name] = float(text)
        except ValueError:
            complaints.add(f"--scales {name}", f"should be a number, got {text!r}")
    for name, info in known.items():
        if name not in given and not isinstance(info.default, (float, type(None))):
            complaints.add("--scales", f"{name} is missing, the {info.meaning}")
    if not complaints:
        try:
            return record(**values)
        except ParameterError as error:
            complaints += by_option(error.complaints, {name: f"--scales {name}" for name in given})
    raise Refusal(*complaints)
