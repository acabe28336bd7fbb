"""The example cases that come with vibrocap: where they are, and what each shows."""

from pathlib import Path


def examples_folder() -> Path:
    """The example cases: in the package where it was installed from a wheel, else in the folder of the sources."""
    package = Path(__file__).resolve().parents[1]
    inside = package / "examples"
    return inside if inside.is_dir() else package.parents[1] / "examples"


def tables_of(case: Path) -> list[Path]:
    """The measured tables of an example, whose names begin with its own."""
    return sorted(case.parent.glob(f"{case.stem}-*.csv"))


def shows(path: Path) -> str:
    """What an example shows: the first sentence of its head."""
    words = []
    for line in path.read_text(encoding="utf-8").splitlines():
        if not line.removeprefix("#").strip():
            break
        words.append(line.removeprefix("#").strip())
    return " ".join(words).partition(". ")[0].rstrip(".:")
