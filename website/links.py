"""Links of the built site: every page, file and anchor that one of its pages points to is there."""

import urllib.parse
from html.parser import HTMLParser
from pathlib import Path


class LinkedPage(HTMLParser):
    """Targets of the links of a page, its anchors, and what it loads from elsewhere."""

    def __init__(self, path: Path):
        super().__init__()
        self.path, self.targets, self.anchors = path, set[str](), set[str]()
        self.loaded = set[str]()
        self.feed(path.read_text(encoding="utf-8"))

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        for name, value in attrs:
            if not value:
                continue
            if name == "id" or (name == "name" and tag == "a"):
                self.anchors.add(value)
            elif name == "src" or (name == "href" and tag == "link"):
                self.loaded.add(value)
            elif name == "href":
                self.targets.add(value)


def dead_links(folder: Path) -> list[str]:
    """Links of the pages of a folder that lead nowhere within it, and what they would load from another host."""
    files = (path for path in sorted(folder.rglob("*.html")) if "_static" not in path.parts)  # templates of the theme
    pages = {path.resolve(): LinkedPage(path) for path in files}
    found = []
    for page in pages.values():
        shown = page.path.relative_to(folder)
        found += [f"{shown} loads {url}" for url in page.loaded if elsewhere(url) and not url.startswith("data:")]
        for target in page.targets | {url for url in page.loaded if not elsewhere(url)}:
            if elsewhere(target):
                continue
            parts = urllib.parse.urlsplit(target)
            there = (
                (page.path.parent / urllib.parse.unquote(parts.path)).resolve() if parts.path else page.path.resolve()
            )
            anchor = urllib.parse.unquote(parts.fragment)
            if not there.exists():
                found.append(f"{shown}: {target}")
            elif "=" in anchor:  # the state of an application, such as the lab
                continue
            elif anchor and there in pages and anchor not in pages[there].anchors:
                found.append(f"{shown}: {target} (no such anchor)")
    return sorted(found)


def elsewhere(url: str) -> bool:
    """Whether a link leaves the folder of its page and those beside it: it names a host or a scheme."""
    parts = urllib.parse.urlsplit(url)
    return bool(parts.scheme or parts.netloc)
