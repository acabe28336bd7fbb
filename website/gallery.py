"""The gallery: every example, run anew, with its picture, its numbers and its file."""

import re
import shutil
from html import escape
from pathlib import Path

import vibrocap as vc
from vibrocap.case.case import read_case
from website.staging import ROOT, cards, toctree

EXAMPLES = ROOT / "examples"
DPI = 110
SPELLED = {"lugre": "LuGre", "si": "SI"}  # words of file names


def title_of(name: str) -> str:
    """The title of an example: "bench-in-si" is "Bench in SI"."""
    words = [SPELLED.get(word, word) for word in name.split("-")]
    return " ".join([words[0][0].upper() + words[0][1:], *words[1:]])


def description(text: str) -> str:
    """The comment at the head of an example, as paragraphs; what stands indented is left out (its command)."""
    head = text.split("[machine]")[0]
    lines = [line.removeprefix("#").removeprefix(" ") for line in head.splitlines()]
    return "\n".join(line for line in lines if not line.startswith("    ")).strip()


def numbers(motion: vc.Trajectory) -> list[tuple[str, str]]:
    """What a motion amounts to; travel in SI where its case is."""
    rows = [("status", motion.status.value)]
    if motion.system.machine.cyclic is not None:
        velocity = vc.mean_velocity(motion)
        settled = "settled" if velocity.settled else "not settled"
        rows.append(("drift in the last period", with_unit(motion, vc.drift(motion), "m")))
        rows.append(("mean velocity", f"{with_unit(motion, velocity.value, 'm/s')}, {settled}"))
    if motion.system.friction.kind == "set-valued":
        rows.append(("share of the time at rest", f"{vc.stick_fraction(motion):.2%}"))
    rows.append(("events", f"{len(motion.events)}"))
    if motion.certificate.estimated_error is not None:
        rows.append(("estimated error", f"{motion.certificate.estimated_error:.1e}"))
    return rows


def with_unit(motion: vc.Trajectory, value: float, unit: str) -> str:
    """A number of a motion as a page shows it, in this unit where its system has units."""
    system = motion.system
    return f"{value:.8f}" if system.units is None else f"{value * system.si.factor_of(unit):.8f} {unit}"


def draw(motion: vc.Trajectory, folder: Path, name: str) -> None:
    """The picture of a motion, and a small one of its travel."""
    sheet = vc.figure(motion)
    sheet.savefig(folder / f"{name}.png", dpi=DPI)
    small = vc.plot(motion)
    small.set_title("")
    small.figure.savefig(folder / f"{name}-small.png", dpi=DPI)


def stage_example(path: Path, folder: Path, lab: str | None, pictures_of: str | None = None) -> None:
    """Run an example; write its page, its picture and a small one of its travel.

    lab: its address in the lab; pictures_of: an example whose pictures are to stand here too, instead of its own
    """
    text = path.read_text(encoding="utf-8")
    motion = read_case(path).simulate()
    if pictures_of is None:
        draw(motion, folder, path.stem)
    else:
        for ending in (".png", "-small.png"):
            shutil.copy(folder / f"{pictures_of}{ending}", folder / f"{path.stem}{ending}")
    (folder / path.name).write_text(text, encoding="utf-8")
    title = title_of(path.stem)
    live = f'```{{raw}} html\n<p><a href="../{escape(lab)}">Open it in the lab</a></p>\n```\n\n' if lab else ""
    rows = "\n".join(f"| {name} | {value} |" for name, value in numbers(motion))
    page = (
        f"# {title}\n\n{description(text)}\n\n![{title}]({path.stem}.png)\n\n{live}"
        f"| measure | value |\n| --- | --- |\n{rows}\n\n"
        f"## The case\n\nThe file: {{download}}`{path.name}`. Run it with\n\n"
        f"```sh\nvibrocap simulate examples/{path.name} --plot run.png\n```\n\n"
        f'```{{literalinclude}} {path.name}\n:language: toml\n:start-at: "[machine]"\n```\n'
    )
    (folder / f"{path.stem}.md").write_text(page, encoding="utf-8")


def stage_gallery(folder: Path, addresses: dict[str, str], pictures: bool = True) -> None:
    """Write gallery/: a page for every example, and cards that lead to them above the table of `examples/README.md`.

    addresses: of examples in the lab, by name; pictures: of each; otherwise those of the first stand for all
    """
    gallery = folder / "gallery"
    index = gallery / "index.md"
    table = re.findall(r"^\| \[([\w-]+)\]\([^)]+\) \| (.+) \| [^|]+ \|$", index.read_text(encoding="utf-8"), re.M)
    for i, (name, _) in enumerate(table):
        shown = None if pictures or i == 0 else table[0][0]
        stage_example(EXAMPLES / f"{name}.toml", gallery, addresses.get(name), shown)
    rows = [(title_of(name), name, shows) for name, shows in table]
    grid = cards(rows, {name: f"{name}-small.png" for name, _ in table})
    text = index.read_text(encoding="utf-8")
    head, _, rest = text.partition("\n")
    names = [name for name, _ in table]
    index.write_text(f"{head}\n\n{grid}\n{rest}{toctree(names)}", encoding="utf-8")
