"""`python -m website [--out FOLDER]`: the site, in FOLDER/html (build/site/html); a warning or a dead link fails."""

import argparse
import importlib.util
import os
import shutil
import sys
import time
from pathlib import Path

from website.embeds import (
    FIRST,
    HEAD,
    PICTURE,
    lab_addresses,
    lab_frame,
    print_sheet,
    stage_downloads,
    stage_hosted,
    stage_lab_frames,
    stage_report,
    stage_sheet,
)
from website.gallery import stage_gallery
from website.links import dead_elsewhere, dead_links, overwritten
from website.reference import stage_commands, stage_equations, stage_names
from website.staging import Card, stage, stage_first_page, stage_sections

MADE: dict[str, list[Card]] = {
    "Reference": [
        ("Commands", "commands", "every command with its options and examples"),
        ("Python", "api/index", "every public name, by what it is about"),
        ("Equations of motion", "equations", "every machine: its description beside the equations derived from it"),
    ]
}
HERE = Path(__file__).resolve().parent


def main(words: list[str] | None = None) -> int:
    """Lay out the sources, have Sphinx build them, check the links; 0 where all went well."""
    parser = argparse.ArgumentParser(prog="python -m website", description=__doc__)
    parser.add_argument("--out", type=Path, default=Path("build/site"), help="folder for the site (build/site)")
    parser.add_argument("--no-notebooks", action="store_true", help="do not run the tutorials")
    parser.add_argument("--no-pictures", action="store_true", help="draw one example of the gallery only")
    parser.add_argument("--links", action="store_true", help="ask the network about links to elsewhere, too")
    options = parser.parse_args(words)
    for package in ("sphinx", "myst_nb", "pydata_sphinx_theme", "sphinx_design", "sphinx_copybutton"):
        if importlib.util.find_spec(package) is None:
            print(f"The site needs {package}: `make site` installs the extra docs.", file=sys.stderr)
            return 2
    began = time.monotonic()
    sources, extra, html = (options.out / name for name in ("sources", "extra", "html"))
    for folder in (sources, extra, html):
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir(parents=True)

    print("Running the examples ...")
    lab = lab_addresses(extra)
    stage(sources)
    stage_gallery(sources, lab, not options.no_pictures)
    stage_commands(sources)
    stage_equations(sources)
    stage_names(sources)
    stage_lab_frames(sources, lab)
    head = "\n".join((HEAD, lab_frame(lab[FIRST]) if FIRST in lab else PICTURE, stage_report(extra)))
    stage_first_page(sources, head, stage_sections(sources, MADE))
    stage_hosted(sources / "tutorials")
    stage_downloads(extra, sources / "tutorials")
    browser = stage_sheet(sources)

    # Kernels that know no settings of the user, and say nothing of how they are reached (over this machine alone).
    profile = (options.out / "ipython" / "profile_default").resolve()
    profile.mkdir(parents=True, exist_ok=True)
    (profile / "ipython_kernel_config.py").write_text("get_config().IPKernelApp.log_level = 40\n", encoding="utf-8")
    os.environ["IPYTHONDIR"] = str(profile.parent)

    from sphinx.cmd.build import build_main

    print("Making the pages ..." if options.no_notebooks else "Running the tutorials and making the pages ...")
    settings = {"html_extra_path": str(extra.resolve())}
    if options.no_notebooks:
        settings["nb_execution_mode"] = "off"
    definitions = [word for name, value in settings.items() for word in ("-D", f"{name}={value}")]
    if build_main(["-q", "-W", "--keep-going", "-j", "2", "-c", str(HERE), *definitions, str(sources), str(html)]):
        return 1
    if browser is not None:
        print_sheet(browser, html)
    for name in overwritten(extra, html):
        print(f"{name}: a page of the site has the name of a file that is taken in", file=sys.stderr)
        return 1
    dead = [*dead_links(html), *(dead_elsewhere(html) if options.links else [])]
    for link in dead:
        print(f"dead link: {link}", file=sys.stderr)
    if not dead:
        print(f"The site: {html / 'index.html'}, made in {time.monotonic() - began:.0f} s")
    return 1 if dead else 0


if __name__ == "__main__":
    sys.exit(main())
