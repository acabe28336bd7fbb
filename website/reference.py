"""Pages that are read off the package: the commands with their options, and the public names with their docstrings."""

import importlib
import inspect
import re
import textwrap
from pathlib import Path

import vibrocap as vc
from vibrocap.cli.command import COMMANDS
from vibrocap.cli.main import app_of
from vibrocap.physics.catalogue import machines
from vibrocap.physics.equations import equations_of
from vibrocap.physics.machines.machine import Machine
from website.staging import WIDE, toctree

# Rooms with public names, as a reader calls them. A room that is not named here stands under its own name.
TITLES = {
    "physics": "Systems",
    "physics.machines": "Machines",
    "physics.friction": "Friction laws",
    "physics.drives": "Drives",
    "physics.controllers": "Controllers",
    "motion": "Motions",
    "measures": "Measures",
    "studies": "Studies",
    "orbits": "Steady motions",
    "design": "Design",
    "laboratory": "The laboratory",
    "records": "Records",
    "identification": "Identification",
    "case": "Cases",
    "contracts": "Contracts",
    "plotting": "Pictures",
    "io": "Files and tables",
}


def stage_commands(folder: Path) -> None:
    """Write commands.md: every command with its arguments, options and examples."""
    text = app_of().generate_docs(output_format="markdown", usage_name="vibrocap")
    text = re.sub(
        r"(?<=^```console\n)(vibrocap[ \w-]*?) -m \w+", r"\1", text, flags=re.MULTILINE
    )  # how this Python runs
    head, *commands = re.split(r"^## (?=vibrocap )", text, flags=re.MULTILINE)
    summary = head.partition("**Commands**:")[2]
    parts = ["# Commands\n", "Every command explains itself: `vibrocap COMMAND --help`.\n", summary.strip() + "\n"]
    for command in commands:
        pieces = re.split(r"^### (?=vibrocap )", command, flags=re.MULTILINE)
        for level, piece in zip(["##", *["###"] * len(pieces)], pieces, strict=False):
            title, _, body = piece.partition("\n")
            command = COMMANDS.get(title.removeprefix("vibrocap "))
            examples = "\n".join(command.examples if command else ())
            fence = f"\n**Examples**:\n\n```sh\n{examples}\n```\n" if examples else ""
            parts.append(f"{level} {title}\n{body.rstrip()}\n{fence}")
    text = re.sub(r"(?m)^( *)\* ", r"\1- ", "\n".join(parts))
    (folder / "commands.md").write_text(text, encoding="utf-8")


def stage_equations(folder: Path) -> None:
    """Write equations.md: the description of every machine beside the equations of motion that follow from it."""
    text = (
        "# Equations of motion\n\nEach machine says what it is made of; the equations beside follow from that, derived "
        "when this page is made. A prime is a rate, R friction, N a load, H the energy, d a motion that the drive "
        "imposes, s a stop that is touched. `vibrocap list NAME` prints them, see [machines](machines.md).\n"
    )
    described = {name: kind for name, kind in machines().items() if issubclass(kind, Machine)}
    for name, kind in described.items():
        source = textwrap.dedent(inspect.getsource(kind.parts))
        lines = "".join(f"<math display='block'>{line}</math>\n" for line in equations_of(kind(), "mathml").lines)
        cards = f":::{{grid-item}}\n```python\n{source}```\n:::\n:::{{grid-item}}\n```{{raw}} html\n{lines}```\n:::\n"
        first = inspect.cleandoc(kind.__doc__ or "").partition("\n")[0]
        text += f"\n## {name}\n\n{first}\n\n::::{{grid}} 1 1 2 2\n{cards}::::\n"
    (folder / "equations.md").write_text(WIDE + text, encoding="utf-8")


def rooms() -> dict[str, list[str]]:
    """Public names by the room in which they stand, rooms as they are titled above."""
    names_of: dict[str, list[str]] = {room: [] for room in TITLES}
    for name in vc.__all__:
        _, room, below, *_ = inspect.unwrap(getattr(vc, name)).__module__.split(".")
        key = f"{room}.{below}"
        names_of.setdefault(key if key in TITLES else room, []).append(name)
    return {room: names for room, names in names_of.items() if names}


def first_sentence(module: str) -> str:
    """What a room says it is."""
    text = importlib.import_module(f"vibrocap.{module}").__doc__ or ""
    return " ".join(text.partition("\n\n")[0].split())


def stage_names(folder: Path) -> None:
    """Write api/: a page of public names for every room, in reStructuredText, and the index of them."""
    (folder / "api").mkdir()
    public, table = rooms(), []
    for room, names in public.items():
        title = TITLES.get(room, room.capitalize())
        page = f"{title}\n{'=' * len(title)}\n\n{first_sentence(room)}\n\n"
        for name in names:
            thing = getattr(vc, name)
            kind = "autoclass" if isinstance(thing, type) else "autofunction"
            page += f".. {kind}:: vibrocap.{name}\n" + ("   :members:\n\n" if kind == "autoclass" else "\n")
        (folder / "api" / f"{room}.rst").write_text(page, encoding="utf-8")
        shown = ", ".join(f"{{py:obj}}`{name} <vibrocap.{name}>`" for name in names)
        table.append(f"| [{title}]({room}.rst) | {shown} |\n")
    head = "# Python\n\nThe public names of `import vibrocap as vc`.\n\n| about | names |\n| --- | --- |\n"
    (folder / "api" / "index.md").write_text(head + "".join(table) + toctree(list(public)), encoding="utf-8")
