"""Links of the built site: every page, file and anchor that one of its pages points to is there."""

import concurrent.futures
import urllib.error
import urllib.parse
import urllib.request
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
    faults = []
    for page in pages.values():
        shown = page.path.relative_to(folder)
        faults += [f"{shown} loads {url}" for url in page.loaded if elsewhere(url) and not url.startswith("data:")]
        for target in page.targets | {url for url in page.loaded if not elsewhere(url)}:
            if elsewhere(target):
                continue
            parts = urllib.parse.urlsplit(target)
            there = (
                (page.path.parent / urllib.parse.unquote(parts.path)).resolve() if parts.path else page.path.resolve()
            )
            anchor = urllib.parse.unquote(parts.fragment)
            if not there.exists():
                faults.append(f"{shown}: {target}")
            elif "=" in anchor:  # the state of an application, such as the lab
                continue
            elif anchor and there in pages and anchor not in pages[there].anchors:
                faults.append(f"{shown}: {target} (no such anchor)")
    return sorted(faults)


def overwritten(extra: Path, folder: Path) -> list[str]:
    """Files that a site takes in as they are, in whose place something else stands in its folder."""
    files = [path for path in sorted(extra.rglob("*")) if path.is_file()]
    places = [(path, folder / path.relative_to(extra)) for path in files]
    return [str(place.relative_to(folder)) for path, place in places if path.read_bytes() != place.read_bytes()]


def links_elsewhere(folder: Path) -> dict[str, list[str]]:
    """Addresses of the web that the pages of a folder point to, each with the pages that do, without anchors."""
    links: dict[str, list[str]] = {}
    for path in sorted(folder.rglob("*.html")):
        if "_static" in path.parts:
            continue
        for target in LinkedPage(path).targets:
            if urllib.parse.urlsplit(target).scheme in ("http", "https"):
                links.setdefault(urllib.parse.urldefrag(target).url, []).append(str(path.relative_to(folder)))
    return links


def dead_elsewhere(folder: Path, seconds: float = 20.0) -> list[str]:
    """What of it does not answer, or says that there is no such page; it asks the network."""
    links = links_elsewhere(folder)
    with concurrent.futures.ThreadPoolExecutor(8) as pool:
        answers = pool.map(lambda url: _answer(url, seconds), links)
    dead = [(url, answer) for url, answer in zip(links, answers, strict=True) if answer]
    return [f"{url}: {answer} (in {', '.join(links[url][:3])})" for url, answer in dead]


def _answer(url: str, seconds: float) -> str:
    """What is wrong with an address; a host that answers, but not to programs, is taken at its word."""
    request = urllib.request.Request(url, headers={"User-Agent": "Mozilla/5.0 (links of a documentation)"})
    try:
        with urllib.request.urlopen(request, timeout=seconds):
            return ""
    except urllib.error.HTTPError as error:
        error.close()  # an answer too: Python 3.14 warns of one that is left open
        return f"{error.code} {error.reason}" if error.code in (404, 410) or error.code >= 500 else ""
    except (OSError, ValueError) as error:
        return str(error)


def elsewhere(url: str) -> bool:
    """Whether a link leaves the folder of its page and those beside it: it names a host or a scheme."""
    parts = urllib.parse.urlsplit(url)
    return bool(parts.scheme or parts.netloc)
