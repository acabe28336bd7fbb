"""What the site takes in besides its pages: the lab, the report on the paper, and the wheel of the package."""

import shutil
import subprocess
import sys
from pathlib import Path

from vibrocap.cli import main as cli
from website.staging import ROOT

CASE = ROOT / "examples" / "travels-by-stick-slip.toml"
HEAD = """# vibrocap

Simulation, analysis and design of vibro-driven capsules: machines without legs or wheels that travel by shaking an
inner mass against friction. The contact that sticks and slips is solved exactly, and every motion comes with a
certificate of how exact it is. [How to install and start it](readme.md).
"""
LAB = """```{raw} html
<iframe class="lab" src="FILE" title="The lab: drag a slider and the exact motion follows" loading="lazy"></iframe>
<p><a href="FILE">The lab on a page of its own</a>: it needs no network, and what it computes is what
<code>vibrocap simulate</code> computes.</p>
```
"""
REPORT = """```{raw} html
<p><a href="report.html">The report on the paper</a>: its figures from our own runs, every claim with its verdict.</p>
```
"""
WHEEL = """
## The wheel

```{raw} html
<p><a href="../FILE" download>FILE</a>, of the sources from which this site was made.</p>
```
"""
PICTURE = "![One drive period of a capsule, its velocity, and its travel](images/travel.png)\n"


def has_lab() -> bool:
    """Whether the package has the command `vibrocap lab`."""
    return "lab" in list(cli.app)


def stage_lab(extra: Path) -> str:
    """Write the lab beside the pages; returns the piece of a page that shows it, or a picture where there is no lab."""
    if has_lab() and cli.main(["lab", str(CASE), "--out", str(extra / "lab.html")]) == 0:
        return LAB.replace("FILE", "lab.html")
    return PICTURE


def stage_report(extra: Path) -> str:
    """Copy the report of `make reproduce`, with its data, where it has been made; returns a link to it."""
    report = ROOT / "out" / "report.html"
    if not report.exists():
        return ""
    shutil.copy(report, extra)
    if (report.parent / "figures").is_dir():
        shutil.copytree(report.parent / "figures", extra / "figures")
    return REPORT


def stage_wheel(extra: Path) -> str:
    """Make the wheel of the package, which hosted notebooks install; returns the piece of a page with its link."""
    pip = [sys.executable, "-m", "pip", "--disable-pip-version-check", "wheel", "--quiet", "--no-deps"]
    subprocess.run([*pip, "--no-build-isolation", "--wheel-dir", str(extra), str(ROOT)], check=True)
    (wheel,) = extra.glob("vibrocap-*.whl")
    return WHEEL.replace("FILE", wheel.name)
