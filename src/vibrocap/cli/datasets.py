"""`vibrocap datasets`: the published measurements, which there are and where, and fetching them."""

import difflib
from pathlib import Path

from cyclopts import App

from vibrocap.cli.exits import INCOMPLETE, OK, complain
from vibrocap.cli.terminal import Page, Refusal, needs, progress, writable_folder

datasets = App(
    name="datasets",
    help="Published measurements of friction: which there are, and fetching their originals.",
    help_epilogue="Example: vibrocap datasets fetch basalt-velocity-step",
)


@datasets.command(name="list")
def list_data_sets() -> int:
    """The data sets that can be fetched: what was measured, by whom, the licence, and whether it is here.

    Example: vibrocap datasets list
    """
    from vibrocap.records.fetching import DATA_SETS
    from vibrocap.records.published import FOLDERS, data_root

    page = Page()
    for each in DATA_SETS.values():
        folder = data_root() / FOLDERS[each.name]
        count = len(each.originals)
        here = f"here, in {folder}" if folder.is_dir() else f"not here; {count} file{'s' * (count != 1)}"
        page.print(f"{each.name}", style="bold")
        for line in (each.title, f"{each.authors}; {each.licence}", each.page, here):
            page.print(f"  {line}", soft_wrap=True)
    return OK


@datasets.command
def fetch(name: str, /, *, to: Path | None = None) -> int:
    """Fetch the published originals of a data set, checked; what is there already is not fetched again.

    Where the checksum of an original is known, the file must have it. Where it is
    not, the checksum of the first fetch is kept in SHA256SUMS, and must be the
    same when it is fetched again.

    Example: vibrocap datasets fetch rotary-damper --to data

    Exit codes: 0 done; 2 wrong input; 3 the files could not be had (no network) or
    are not what they should be.

    Parameters
    ----------
    name
        a data set, as `vibrocap datasets list` shows them
    to
        folder for data sets [default: VIBROCAP_DATA, else a folder in the user's cache]
    """
    from vibrocap.records.fetching import DATA_SETS, FetchError
    from vibrocap.records.fetching import fetch as fetched
    from vibrocap.records.published import data_root

    if name not in DATA_SETS:
        near = [each for each in DATA_SETS if name and each.startswith(name)]
        near += difflib.get_close_matches(name, DATA_SETS, n=1)
        hint = f"did you mean {near[0]!r}?" if near else f"there is {', '.join(DATA_SETS)}"
        raise Refusal(f"no data set is called {name!r}; {hint}")
    needs("datasets fetch", "fit", "pooch")
    writable_folder("--to", to if to is not None else data_root())
    try:
        with progress(f"Fetching {name}") as report:
            came = fetched(DATA_SETS[name], to, lambda share: report(share, None))
    except FetchError as error:
        complain(str(error))
        return INCOMPLETE
    page = Page()
    samples = sum(map(len, came.records))
    page.print(f"{name}: {len(came.records)} records, {samples:,} samples, in {came.folder}", soft_wrap=True)
    if came.known:
        page.print(f"  checked    {came.known} against the published checksum")
    if came.recorded:
        page.print(f"  checked    {came.recorded} against the checksum of the first fetch")
    if came.first:
        page.print(f"  trusted    {came.first} on first use; checksums in SHA256SUMS there", soft_wrap=True)
    page.print(f"  by         {DATA_SETS[name].authors}; {DATA_SETS[name].licence}", soft_wrap=True)
    if to is not None:
        page.print(f"To use it: VIBROCAP_DATA={to}", soft_wrap=True)
    return OK
