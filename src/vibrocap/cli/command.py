"""A command: a request whose options are declared once, what it computes, and the views of the result.

`@command` on a function of a request enters the command: its name is the function's, its help the docstring, its
options the fields of the request. `perform` runs one from the words on the line to the exit code.
"""

import contextlib
import dataclasses
import functools
import inspect
import itertools
import shlex
import typing
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Annotated, Any

from cyclopts import Group, Parameter

from vibrocap.arguments import Complaints, Refusal, by_option
from vibrocap.case.case import Case, CaseError
from vibrocap.case.sections import SECTIONS
from vibrocap.cli.options import CASE, Option, flag, needs, option
from vibrocap.cli.terminal import INCOMPLETE, OK, Page, complain, progress
from vibrocap.io.motion_file import read_source
from vibrocap.plotting.look.page import on_page
from vibrocap.quantities.json_text import json_text

ADVANCED = Group("Advanced", sort_key=9)
Report = Callable[..., None]  # takes the share done and, where it changes, what is done


@typing.dataclass_transform(kw_only_default=True, frozen_default=True)
class Request:
    """The options of a command: a frozen record, each of whose fields is declared by its `Option`."""

    __dataclass_fields__: typing.ClassVar[dict[str, dataclasses.Field[Any]]]  # for type checkers

    def __init_subclass__(cls) -> None:
        """Make the class a record."""
        for name, declared in list(vars(cls).items()):
            if isinstance(declared, Option):
                setattr(cls, name, dataclasses.field(default=declared.default, metadata={"option": declared}))
        dataclasses.dataclass(frozen=True, kw_only=True)(cls)

    @classmethod
    @functools.cache
    def options(cls) -> Mapping[str, tuple[Any, Option]]:
        """By field, (its type, its option)."""
        hints = typing.get_type_hints(cls)
        return {field.name: (hints[field.name], field.metadata["option"]) for field in dataclasses.fields(cls)}

    @classmethod
    def flags(cls) -> dict[str, str]:
        """The option by every argument that it sets."""
        own = {name: flag(name, declared) for name, (_, declared) in cls.options().items()}
        return {
            argument: own[name] for name, (_, declared) in cls.options().items() for argument in declared.sets
        } | own

    def given(self, *names: str) -> dict[str, Any]:
        """Options by name, those that are None left out."""
        return {name: value for name in names if (value := getattr(self, name)) is not None}

    def again(self) -> str:
        """The line that gives the same answer, without what is only shown."""
        name = next(command.name for command in COMMANDS.values() if command.request is type(self))
        places, words = [], []
        for field in dataclasses.fields(self):
            value, declared = getattr(self, field.name), field.metadata["option"]
            if value == field.default or field.name in ("json", "plot", "resume"):
                continue
            values = list(map(str, value)) if isinstance(value, (list, tuple)) else [str(value)]
            if declared.place:
                places += values
            elif value is True:
                words.append(flag(field.name))
            else:
                words += itertools.chain.from_iterable((flag(field.name), word) for word in values)
        return shlex.join(["vibrocap", name, *places, *words])

    def plan(self, refused: Complaints) -> None:
        """Complain of options that do not go together, before any work."""

    def refuse(self) -> None:
        """Refusal for options that cannot be used, all of them, before any work."""
        refused = Complaints()
        for name, (_, declared) in self.options().items():
            value = getattr(self, name)
            if _is_left_out(value):
                continue
            if declared.needs and _is_left_out(getattr(self, declared.needs, True)):
                refused.add(flag(name), f"should be left out without {flag(declared.needs)}")
            elif declared.check is not None:
                with refused.collected():
                    declared.check(flag(name, declared), value)
        with refused.collected():
            self.plan(refused)
        if refused:
            raise Refusal(*refused)


def _is_left_out(value: Any) -> bool:
    return value is None or value is False or value in ([], ())


class WithParts(Request):
    """A request that names parts, which may be your own."""

    parts: list[Path] | None = option(
        "a Python file with your own laws, machines, drives or controllers; may be repeated"
    )

    def register(self) -> None:
        """Register the parts of files; Refusal, with every file that cannot be used."""
        from vibrocap.physics.part_files import PartsError, load_parts

        refused = []
        for path in self.parts or ():
            try:
                load_parts(path)
            except PartsError as error:
                refused.append(f"--parts: {error}")
        if refused:
            raise Refusal(*refused)


class OfCase(WithParts):
    """A request about a case."""

    case: Path = CASE

    @classmethod
    def flags(cls) -> dict[str, str]:
        """The option by every argument; sections of the case are named with it."""
        return {name: f"CASE: {name}" for name in SECTIONS} | super().flags()

    @functools.cached_property
    def setup(self) -> Case:
        """The case with what the options change in it."""
        return read_source(self.case)

    def refuse(self) -> None:
        """Refusal or CaseError; the case is read before its destinations are checked, so that it is not replaced."""
        try:
            _ = self.setup
        except CaseError as error:
            refused = Complaints(error.complaints)
            with refused.collected():
                super().refuse()
            raise CaseError(dict.fromkeys(refused), error.source) from None
        super().refuse()


class Drawn(Request):
    """A request that draws a picture, for a page."""

    width: str | None = option("of the picture: column (3.4 inches), page (7) or inches", advanced=True, needs="plot")
    no_header: bool = option("draw no title, parameters and small print", False, advanced=True, needs="plot")
    style: Path | None = option("a style sheet of Matplotlib (.mplstyle)", advanced=True, needs="plot")

    def page(self) -> contextlib.ExitStack:
        """A context in which pictures are drawn as the options say; Refusal for a file that is no style sheet."""
        context = contextlib.ExitStack()
        context.enter_context(on_page(self.width, not self.no_header))
        if self.style is not None:
            needs("--style", "matplotlib")
            from vibrocap.plotting.look.style import style_sheet

            if not self.style.is_file():
                raise Refusal(f"--style: {str(self.style)!r} is no file")
            try:
                context.enter_context(style_sheet(self.style))
            except ValueError as error:
                raise Refusal(f"--style: {error}") from None
        return context


@dataclasses.dataclass(frozen=True)
class Answer:
    """The result of a command and its views.

    record: what --json prints; text: what people read, lines or a function that prints them on a page
    drawn: the result of which --plot draws the sheet; drawing: options of that; written: files by what they are
    incomplete: why the work could not be completed, with the remedy; code: the exit code then
    """

    record: Any = None
    text: str | Callable[[Page], None] = ""
    drawn: Any = None
    drawing: Mapping[str, Any] = dataclasses.field(default_factory=dict)
    written: tuple[tuple[str, Any], ...] = ()
    incomplete: str = ""
    code: int = INCOMPLETE


@dataclasses.dataclass(frozen=True)
class Command:
    """A command of the command line."""

    run: Callable[..., Answer]
    group: str
    examples: tuple[str, ...]
    doing: str
    request: type[Request]

    @property
    def name(self) -> str:
        """As it stands on the line."""
        return self.run.__name__.strip("_").replace("_", "-")

    @property
    def words(self) -> str:
        """What it does, a line for each paragraph, so that the terminal wraps it."""
        paragraphs = inspect.cleandoc(self.run.__doc__ or "").split("\n\n")
        return "\n\n".join(" ".join(paragraph.split()) for paragraph in paragraphs)

    def entry(self) -> Callable[..., int]:
        """The function that cyclopts calls, whose signature follows from the request."""
        options, fields = self.request.options(), dataclasses.fields(self.request)
        ordered = sorted(fields, key=lambda field: not options[field.name][1].place)  # those by place first
        signature = inspect.Signature([_parameter(field, *options[field.name]) for field in ordered])

        def call(*places: Any, **named: Any) -> int:
            bound = signature.bind(*places, **named)
            return perform(self, self.request(**bound.arguments))

        call.__signature__ = signature  # type: ignore[attr-defined]
        call.__annotations__ = {name: parameter.annotation for name, parameter in signature.parameters.items()}
        call.__name__ = self.run.__name__
        return call


COMMANDS: dict[str, Command] = {}  # of the modules that are imported, by name


def command(group: str, *examples: str, doing: str = "") -> Callable[[Callable[..., Answer]], Callable[..., Answer]]:
    """A decorator: the function of a request is a command.

    group: of those of `overview`; examples: command lines, which the help shows and a test runs
    doing: what its bar of progress says, with fields of the request in braces; the function then takes what reports
    """

    def entered(run: Callable[..., Answer]) -> Callable[..., Answer]:
        request = next(iter(typing.get_type_hints(run).values()))
        entry = Command(run, group, examples, doing, request)
        COMMANDS[entry.name] = entry
        return run

    return entered


def _parameter(field: Any, kind: Any, declared: Option) -> inspect.Parameter:
    many = declared.place and typing.get_origin(kind) is tuple
    default = inspect.Parameter.empty if many or field.default is dataclasses.MISSING else field.default
    place = inspect.Parameter.VAR_POSITIONAL if many else inspect.Parameter.POSITIONAL_ONLY
    more: dict[str, Any] = {} if declared.place else {"name": flag(field.name)}
    more |= {"group": ADVANCED} if declared.advanced else {}
    settings = Parameter(help=declared.words, completer=declared.offers, **more)
    annotation = Annotated[typing.get_args(kind)[0] if many else kind, settings]
    place = place if declared.place else inspect.Parameter.KEYWORD_ONLY
    return inspect.Parameter(field.name, place, default=default, annotation=annotation)


def perform(entered: Command, request: Request) -> int:
    """Run a command: its options are checked, it computes, and its answer is shown; returns the exit code."""
    if isinstance(request, WithParts):
        request.register()
    request.refuse()
    with refusing(request), request.page() if isinstance(request, Drawn) else contextlib.nullcontext():
        if entered.doing:
            with progress(entered.doing.format_map(vars(request))) as report:
                answer = entered.run(request, report)
        else:
            answer = entered.run(request)
        return shown(answer, request)


@contextlib.contextmanager
def refusing(request: Request) -> Iterator[None]:
    """Complaints about arguments within it are refusals, which name the options that set them."""
    try:
        yield
    except Refusal:
        raise
    except ValueError as error:
        complaints = getattr(error, "complaints", ())
        named = by_option(complaints, request.flags())
        if not complaints or (isinstance(error, CaseError) and named == list(complaints)):
            raise
        raise Refusal(*named) from None


def shown(answer: Answer, request: Request) -> int:
    """Show an answer as the request wants it; returns the exit code."""
    page, in_json = Page(), getattr(request, "json", False)
    written = list(answer.written)
    plot = getattr(request, "plot", None)
    if plot is not None and answer.drawn is not None:  # before any text: nobody may be there to read that
        from vibrocap.plotting.plot import sheet

        sheet(answer.drawn, plot, **answer.drawing)
        written.append(("picture", plot))
    if in_json:
        print(json_text(answer.record))
    elif callable(answer.text):
        answer.text(page)
    elif answer.text:
        page.say(answer.text)
    if not in_json:
        for what, path in written:
            page.say(f"{what:<10} {path}")
    if answer.incomplete:
        complain(answer.incomplete)
    return answer.code if answer.incomplete else OK
