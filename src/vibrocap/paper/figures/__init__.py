"""The figures of the paper as data, by key: panels of curves from our own runs, which `report` draws.

Each is a function that is given the runs, and enters itself as its module is imported here.
"""

from vibrocap.paper.figures import figure, load, motion  # noqa: F401 (they enter theirs)

ORDER = "fig03 fig05 fig06 fig07 fig08 fig09 symmetry fig10 fig11 load05 load06 load07 load08 load09 load10 load11"
FIGURES = {key: figure.FIGURES[key] for key in ORDER.split()}
KEYS = tuple(key for key in FIGURES if key.startswith("fig"))  # those of the paper
LOADED = tuple(key for key in FIGURES if key.startswith("load"))  # the same under the dynamic load


def chosen_figures(only: str | None = None) -> tuple[str, ...]:
    """Keys of the figures to make: all, or one with what explains it. ValueError for a key that does not exist."""
    if only is None:
        return tuple(FIGURES)
    if only not in KEYS:
        raise ValueError(f"only should be one of {', '.join(KEYS)}, got {only!r}")
    beside = ("symmetry",) if only == "fig09" else ()
    return (only, *beside, *(key for key in LOADED if key[4:] == only[3:]))
