"""What the site takes in besides its pages: the lab, the report on the paper, and the wheel of the package."""

import html
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from vibrocap.cli import main as cli
from website.links import LinkedPage, elsewhere
from website.staging import ROOT

PAGE = "live/lab.html"  # of the lab; docs/lab.md is another page
FIRST = "travels-by-stick-slip"  # the example with which the lab begins
# A place in a page for the lab, at an example, with what else its address is to say.
MARK = re.compile(r"^<!-- lab: ([\w-]+)((?:&[\w.-]+=[\w.,-]+)*) -->$", re.MULTILINE)
HEAD = """# vibrocap

Simulation, analysis and design of vibro-driven capsules: machines without legs or wheels that travel by shaking an
inner mass against friction. The contact that sticks and slips is solved exactly, and every motion comes with a
certificate of how exact it is. [How to install and start it](readme.md).
"""
LAB = """```{raw} html
<iframe class="lab" src="FILE" title="The lab: drag a slider and the exact motion follows" loading="lazy"
  allow="fullscreen"></iframe>
<p><a href="FILE">The lab on a page of its own</a></p>
```
"""
REPORT = """```{raw} html
<p><a href="report/report.html">The report on the paper</a>: our figures, every claim with its verdict.</p>
```
"""
DOWNLOADS = """
## The files

```{raw} html
<p>The wheel: <a href="../WHEEL" download>WHEEL</a></p>
```

The notebooks: NOTEBOOKS
"""
COLAB = "https://colab.research.google.com/github/{repository}/blob/{branch}/docs/tutorials/{name}"
SHEET = "cheat-sheet.pdf"
BROWSERS = ("chromium", "chromium-browser", "google-chrome")
PICTURE = "![One drive period of a capsule, its velocity, and its travel](images/travel.png)\n"


def lab_addresses(extra: Path) -> dict[str, str]:
    """Write the lab beside the pages; returns its address at each of its presets, {} where it fails."""
    (extra / PAGE).parent.mkdir(parents=True, exist_ok=True)
    if cli.main(["lab", "--out", str(extra / PAGE)]) != 0:
        return {}
    page = (extra / PAGE).read_text(encoding="utf-8")
    data = json.loads(re.search(r'<script[^>]* id="data">(.*?)</script>', page, re.DOTALL)[1])
    return {preset["key"]: f"{PAGE}#v={data['layout']}&preset={preset['key']}" for preset in data["presets"]}


def lab_frame(address: str, place: str = "") -> str:
    """The lab within a page that stands at a place among the sources."""
    return LAB.replace("FILE", html.escape(os.path.relpath(address, Path(place).parent)))


def with_lab(text: str, place: str, addresses: dict[str, str]) -> str:
    """The text of a page with the lab where the page has a mark for it."""
    return MARK.sub(lambda mark: lab_frame(addresses[mark[1]] + mark[2], place) if mark[1] in addresses else "", text)


def stage_lab_frames(folder: Path, addresses: dict[str, str]) -> None:
    """Put the lab into the pages that have marks for it."""
    for page in folder.rglob("*.md"):
        text = page.read_text(encoding="utf-8")
        shown = with_lab(text, page.relative_to(folder).as_posix(), addresses)
        if shown != text:
            page.write_text(shown, encoding="utf-8")


def stage_report(extra: Path, page: Path = ROOT / "out" / "report.html") -> str:
    """Copy the report of `make reproduce`, with the files that it links to, where it has been made; returns a link."""
    if not page.exists():
        return ""
    report = LinkedPage(page)
    for link in {url.partition("#")[0] for url in report.targets | report.loaded if not elsewhere(url)} | {page.name}:
        if (page.parent / link).is_file():
            copy = extra / "report" / link
            copy.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(page.parent / link, copy)
    return REPORT


def stage_hosted(tutorials: Path) -> None:
    """Give each notebook a link that opens it as a hosted one, where a workflow of GitHub makes the site."""
    if (repository := os.environ.get("GITHUB_REPOSITORY")) is None:
        return
    branch = os.environ.get("GITHUB_REF_NAME", "main")
    for path in tutorials.glob("*.ipynb"):
        notebook = json.loads(path.read_text(encoding="utf-8"))
        address = COLAB.format(repository=repository, branch=branch, name=path.name)
        notebook["cells"][0]["source"] += [f"\n\n[Open in Colab]({address})"]
        path.write_text(json.dumps(notebook), encoding="utf-8")


def stage_sheet(sources: Path) -> str | None:
    """Add to the cheat sheet a link to its PDF, where there is a browser that prints it; returns the browser."""
    browser = next(filter(None, map(shutil.which, BROWSERS)), None)
    if browser is None:
        print(f"The cheat sheet is a page only: none of {', '.join(BROWSERS)} is installed to print {SHEET}.")
    else:
        with (sources / "cheat-sheet.md").open("a", encoding="utf-8") as page:
            page.write(f'\n```{{raw}} html\n<p class="unprinted"><a href="{SHEET}">One page to print</a></p>\n```\n')
    return browser


def print_sheet(browser: str, html: Path) -> None:
    """Print the cheat sheet as a PDF beside its page."""
    quiet = ("--headless=new", "--no-sandbox", "--disable-gpu", "--no-pdf-header-footer", "--virtual-time-budget=2000")
    with tempfile.TemporaryDirectory() as profile:
        output = (f"--user-data-dir={profile}", f"--print-to-pdf={(html / SHEET).resolve()}")
        page = (html / "cheat-sheet.html").resolve().as_uri()
        subprocess.run([browser, *quiet, *output, page], check=True, capture_output=True, timeout=120)


def stage_downloads(extra: Path, tutorials: Path) -> None:
    """Make the wheel of the package beside the pages; add it and the notebooks to the page on how to run these."""
    pip = [sys.executable, "-m", "pip", "--disable-pip-version-check", "wheel", "--quiet", "--no-deps"]
    subprocess.run([*pip, "--no-build-isolation", "--wheel-dir", str(extra), str(ROOT)], check=True)
    (wheel,) = extra.glob("vibrocap-*.whl")
    notebooks = ", ".join(f"{{download}}`{path.name}`" for path in sorted(tutorials.glob("*.ipynb")))
    with (tutorials / "README.md").open("a", encoding="utf-8") as page:
        page.write(DOWNLOADS.replace("WHEEL", wheel.name).replace("NOTEBOOKS", notebooks))
