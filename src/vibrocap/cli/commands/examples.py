"""`vibrocap examples`: the example cases, and copies of them to work with."""

import os
from pathlib import Path

from vibrocap.arguments import Complaints, Refusal, suggestion
from vibrocap.cli.command import Answer, Request, command
from vibrocap.cli.completers import example_names
from vibrocap.cli.examples import examples_folder, shows, tables_of
from vibrocap.cli.options import folder, option
from vibrocap.cli.terminal import Page, table
from vibrocap.files import made_folder, write_text


class ExamplesRequest(Request):
    names: tuple[str, ...] = option("examples by name [default: all]", (), place=True, offers=example_names)
    to: Path | None = folder("folder for the copies [default: examples, with names]")


@command("start", "vibrocap examples", "vibrocap examples --to examples")
def examples(request: ExamplesRequest) -> Answer:
    """The example cases, and copies of them.

    Without names and --to the command lists them. Copies include the measured tables of a case. Existing files stay.
    """
    known = {path.stem: path for path in sorted(examples_folder().glob("*.toml"))}
    complaints = Complaints()
    for name in request.names:
        if name.removesuffix(".toml") not in known:
            complaints.add(name, f"there is no such example; {suggestion(name, known)}")
    if complaints:
        raise Refusal(*complaints)
    if request.to is None and not request.names:
        listed = table(None, "example", "subject", no_wrap=1)
        for name, path in known.items():
            listed.add_row(name, shows(path))

        def text(page: Page) -> None:
            page.print(listed)
            page.say("Next: vibrocap examples --to examples; vibrocap simulate examples/travels-by-stick-slip.toml")

        return Answer(text=text)
    folder, lines = made_folder(request.to or Path("examples")), []
    paths = [known[name.removesuffix(".toml")] for name in request.names or known]
    for source in (path for case in paths for path in (case, *tables_of(case))):
        target = folder / source.name
        if os.path.lexists(target):
            same = target.is_file() and target.read_bytes() == source.read_bytes()
            lines.append(f"{target} is there already" + ("" if same else ", and another; it is left as it is"))
            continue
        write_text(target, source.read_text(encoding="utf-8"))
        lines.append(f"Written: {target}")
    return Answer(text="\n".join(lines))
