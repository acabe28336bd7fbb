"""`vibrocap verify`: whether stored results are as they were written."""

from pathlib import Path

from vibrocap.cli.options import needs
from vibrocap.cli.terminal import INCOMPLETE, OK, Page


def verify(study: Path, /) -> int:
    """Whether a stored study is as it was written: every file is compared with its checksum.

    A file that is missing, cut short, altered or in the place of another one is
    named. The sweep with --resume computes damaged tiles again.

    Example: vibrocap verify map

    Exit codes: 0 all that is stored is whole, finished or not. 3 something is
    damaged. 2 there is no study, or none that vibrocap wrote.

    Parameters
    ----------
    study
        the folder of a study (`vibrocap sweep --out`)
    """
    needs("verify", "sweep", "xarray", "zarr")
    from vibrocap.studies.store.verification import verify_study

    found = verify_study(study)
    page = Page()
    for line in found.lines():
        page.say(f"  damaged    {line}")
    if found.mixed:
        page.say(f"  mixed      {len(found.mixed):,} tiles were not computed with what the study was begun with")
    state = f"{found.stored:,} of {found.tiles:,} tiles are stored"
    if not found.ok:
        page.say(f"{study}: damaged; {state}. The sweep with --resume mends what it can.")
        return INCOMPLETE
    if not found.checked:
        state += "; this store of an earlier format has no checksums, nothing is missing"
    page.say(f"{study}: whole; {state}.")
    return OK
