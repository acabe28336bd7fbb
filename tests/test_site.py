"""The site of the documentation: its sources, made of the pages of the repository, and the site that Sphinx makes."""

import enum
import functools
import http.server
import importlib.util
import json
import re
import shutil
import subprocess
import sys
import threading
from pathlib import Path
from xml.etree import ElementTree

import pytest

import vibrocap as vc
from browser import CHROMIUM
from test_published import FAST
from vibrocap.cli.command import COMMANDS
from vibrocap.cli.main import app_of
from vibrocap.physics.catalogue import machines
from website.docstrings import as_rst, members
from website.embeds import SHEET, print_sheet, stage_hosted, stage_report, stage_sheet, with_lab
from website.gallery import description, title_of
from website.links import dead_elsewhere, dead_links, overwritten
from website.reference import rooms, stage_commands, stage_equations, stage_names
from website.staging import (
    INDEX,
    LINK,
    PRINTED,
    ROOT,
    places,
    published_page,
    relinked,
    sections,
    stage,
    stage_first_page,
    stage_sections,
)

QUICK = (*FAST, "code-aster-two-masses", "newmark-block")

# --- pages -----------------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def staged(tmp_path_factory):
    """The sources without what takes long: the gallery is empty, and a few of the published cases are run."""
    folder = tmp_path_factory.mktemp("sources")
    with pytest.MonkeyPatch.context() as patched:
        patched.setitem(PRINTED, "published.md", functools.partial(published_page, *QUICK))
        stage(folder)
        stage_first_page(folder, "# Head\n", stage_sections(folder, {}))
        yield folder


def test_notebooks_link_to_a_hosted_copy_where_the_repository_is_known(tmp_path, monkeypatch):
    original = ROOT / "docs" / "tutorials" / "first-motion.ipynb"
    copy = Path(shutil.copy(original, tmp_path))
    monkeypatch.delenv("GITHUB_REPOSITORY", raising=False)
    stage_hosted(tmp_path)
    assert copy.read_bytes() == original.read_bytes()
    monkeypatch.setenv("GITHUB_REPOSITORY", "owner/name")
    monkeypatch.setenv("GITHUB_REF_NAME", "v1")
    stage_hosted(tmp_path)
    first, *others = json.loads(copy.read_text(encoding="utf-8"))["cells"]
    link = "https://colab.research.google.com/github/owner/name/blob/v1/docs/tutorials/first-motion.ipynb"
    assert first["source"][-1] == f"\n\n[Open in Colab]({link})"
    assert others == json.loads(original.read_text(encoding="utf-8"))["cells"][1:]


def test_without_a_browser_the_cheat_sheet_is_a_page_only(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr("shutil.which", lambda name: None)
    assert stage_sheet(tmp_path) is None
    assert f"none of chromium, chromium-browser, google-chrome is installed to print {SHEET}" in capsys.readouterr().out


@pytest.mark.slow
@pytest.mark.skipif(CHROMIUM is None, reason="no chromium is installed")
def test_the_cheat_sheet_is_printed(tmp_path):
    (tmp_path / "cheat-sheet.html").write_text("<h1>Sheet</h1>")
    print_sheet(CHROMIUM, tmp_path)
    assert (tmp_path / SHEET).read_bytes().count(b"/Type /Page\n") == 1


def test_every_page_stands_in_one_section():
    entries = [entry.page for part in sections().values() for entry in part]
    assert len(entries) == len(set(entries))
    assert {page for page in places() if page.suffix != ".toml"} - {INDEX} == set(entries)
    assert list(sections()) == ["Tutorials", "How-to guides", "Explanations", "Reference", "Project"]


@pytest.mark.plain
def test_pages_that_the_package_prints_are_staged_whole(staged):
    for place, printed in PRINTED.items():
        assert places()[ROOT / "docs" / place] == place
        assert (staged / place).read_text(encoding="utf-8") == printed()
        assert len(printed()) > 5 * (ROOT / "docs" / place).stat().st_size


def test_links_of_the_sources_lead_to_sources(staged):
    known = {staged / place for place in places().values()}  # pages of the gallery are made later
    pages = [path for path in sorted(staged.rglob("*")) if path.suffix in (".md", ".ipynb")]
    assert len(pages) > 25
    count = 0
    for page in pages:
        text = re.sub(r"```.*?```", "", page.read_text(encoding="utf-8"), flags=re.DOTALL)
        for path, _ in LINK.findall(text):
            there = (page.parent / path).resolve() if path else page
            assert there in known or there.exists(), f"{page.name}: {path}"
            count += bool(path)
    assert count > 80


def test_cards_and_contents_name_pages(staged):
    for page in staged.glob("*.md"):
        text = page.read_text(encoding="utf-8")
        listed = [name for block in re.findall(r"```\{toctree\}\n:hidden:\n\n(.*?)\n```", text, re.DOTALL)
                  for name in block.splitlines()]  # fmt: skip
        for name in [*listed, *re.findall(r"^:link: (.+)$", text, re.MULTILINE)]:
            assert [*staged.glob(f"{name}.*")], f"{page.name}: {name}"


@pytest.mark.parametrize(
    ("text", "page", "shown"),
    [
        ("[a](../../README.md#start)", "docs/tutorials/README.md", "[a](../readme.md#start)"),
        ("[a](docs/sweeps.md)", "README.md", "[a](sweeps.md)"),
        ("[a](../examples/bench-in-si.toml)", "docs/tables.md", "[a](gallery/bench-in-si.md)"),
        ("![a](../docs/images/b.png)", "examples/README.md", "![a](../images/b.png)"),
        (
            "[a](sweeps.md) [b](#x) [c](https://d.e/f.md)",
            "docs/tables.md",
            "[a](sweeps.md) [b](#x) [c](https://d.e/f.md)",
        ),
        ("```python\nx[0](../README.md)\n```", "docs/tables.md", "```python\nx[0](../README.md)\n```"),
    ],
)
def test_links_follow_their_pages(text, page, shown):
    known = places()
    assert relinked(text, ROOT / page, known[ROOT / page], known) == shown


# --- what is read off the package ------------------------------------------------------------------------------------


def test_every_public_name_has_a_place_in_the_reference(tmp_path):
    stage_names(tmp_path)
    text = "".join(path.read_text(encoding="utf-8") for path in (tmp_path / "api").glob("*.rst"))
    assert sorted(re.findall(r"^\.\. auto\w+:: vibrocap\.(\w+)$", text, re.MULTILINE)) == sorted(vc.__all__)
    assert {"Exponential", "LuGre"} <= set(rooms()["physics.friction"])


def test_every_command_is_described_with_its_examples(tmp_path):
    stage_commands(tmp_path)
    text = next(tmp_path.glob("commands.*")).read_text(encoding="utf-8")
    assert set(re.findall(r"^```console\n(\w+) ", text, re.MULTILINE)) == {"vibrocap"}
    assert " -m " not in text
    assert "--empty" not in text
    app_of()
    for command, each in COMMANDS.items():
        (part,) = re.findall(rf"^##+ vibrocap {command}\n(.*?)(?=^#|\Z)", text, re.MULTILINE | re.DOTALL)
        assert all(line in part for line in each.examples), command


def test_docstrings_become_paragraphs_equations_and_fields():
    text = """Friction |R| at `side`, of `Exponential`s.

        R = N |v|

    It falls to the
    level: no further. Then

    velocity: sliding velocity [1]   side: +1 or -1
    load, mass: N of the contact,
        a number
    Returns (R, ()).
    """
    assert as_rst(text, {"Exponential"}) == [
        r"Friction \|R\| at ``side``, of :py:obj:`Exponential <vibrocap.Exponential>`\ s.", "",
        "::", "", "      R = N |v|", "",
        "It falls to the level: no further. Then", "",
        "- **velocity**: sliding velocity [1]", "",
        "- **side**: +1 or -1", "",
        "- **load, mass**: N of the contact, a number", "",
        "Returns (R, ()).", "",
    ]  # fmt: skip


def test_parts_show_their_parameters_and_enumerations_their_members():
    assert "- **decay\\_rate** (a): rate of the drop from static to Coulomb level over speed" in members(vc.Exponential)
    assert "- ``FINISHED``: finished" in members(vc.Status)
    assert members(enum.Enum) == members(vc.simulate) == members(vc.Event) == []


def test_an_example_is_introduced_by_its_own_words():
    text = (ROOT / "examples" / "bench-in-si.toml").read_text(encoding="utf-8")
    assert description(text).startswith("A capsule on the bench")
    assert "vibrocap simulate" not in description(text)
    assert title_of("bench-in-si") == "Bench in SI"
    assert title_of("bristles-lugre") == "Bristles LuGre"


def test_the_lab_stands_where_a_page_has_a_mark_for_it():
    marked = "before\n\n<!-- lab: mirror-twin -->\n\nafter\n"
    lab = with_lab(marked, "gallery/a.md", {"mirror-twin": "lab.html#v=1&preset=mirror-twin"})
    assert 'src="../lab.html#v=1&amp;preset=mirror-twin"' in lab
    assert with_lab(marked, "gallery/a.md", {}) == "before\n\n\n\nafter\n"
    more = with_lab("<!-- lab: mirror-twin&beside=twin -->", "gallery/a.md", {"mirror-twin": "lab.html#v=1"})
    assert 'src="../lab.html#v=1&amp;beside=twin"' in more


def test_the_report_comes_with_the_files_that_it_links_to(tmp_path):
    out, extra = tmp_path / "out", tmp_path / "extra"
    (out / "figures").mkdir(parents=True)
    assert stage_report(extra, out / "report.html") == ""
    (out / "report.html").write_text('<a href="figures/fig05.csv">data</a><a href="#top"></a><img src="data:,">')
    (out / "figures" / "fig05.csv").write_text("1")
    (out / "motion.nc").write_text("of the user")
    assert "report/report.html" in stage_report(extra, out / "report.html")
    copied = {path.relative_to(extra).as_posix() for path in extra.rglob("*.*")}
    assert copied == {"report/report.html", "report/figures/fig05.csv"}


def test_every_machine_shows_its_description_beside_its_equations(tmp_path):
    stage_equations(tmp_path)
    (made,) = tmp_path.glob("*.md")
    page = made.read_text(encoding="utf-8")
    assert re.findall(r"^## (.+)$", page, re.MULTILINE) == list(machines())
    own = page.partition("## feeder\n")[2].partition("\n## ")[0]
    assert 'Support("plate", x=moved * cos(angle)' in own
    assert "<mi>m</mi><mspace width='0.17em'/><msup><mi>p</mi><mo>\N{PRIME}</mo></msup><mo>=</mo>" in own
    for line in re.findall(r"^<math .*$", page, re.MULTILINE):
        ElementTree.fromstring(line)


# --- what Sphinx makes of it -----------------------------------------------------------------------------------------


def test_dead_links_are_found(tmp_path):
    (tmp_path / "a.html").write_text(
        '<p id="top"><a href="b.html#here"></a><a href="#top"></a><a href="b.html#v=1"></a>'
    )
    (tmp_path / "b.html").write_text('<a name="here"></a><img src="c.png"><a href="a.html?q=1#top">a</a>')
    (tmp_path / "c.png").touch()
    assert dead_links(tmp_path) == []
    extra = tmp_path / "extra"
    extra.mkdir()
    (extra / "c.png").touch()
    assert overwritten(extra, tmp_path) == []
    (extra / "b.html").write_text("a page that is taken in")
    assert overwritten(extra, tmp_path) == ["b.html"]
    shutil.rmtree(extra)
    (tmp_path / "b.html").write_text('<a href="gone.html"></a><a href="#gone"></a><script src="//cdn.x/y.js"></script>')
    assert dead_links(tmp_path) == [
        "a.html: b.html#here (no such anchor)",
        "b.html loads //cdn.x/y.js",
        "b.html: #gone (no such anchor)",
        "b.html: gone.html",
    ]


@pytest.mark.slow
@pytest.mark.skipif(
    any(importlib.util.find_spec(name) is None for name in ("sphinx", "myst_nb", "pydata_sphinx_theme")),
    reason="the extra `docs` is not installed (`make site` installs it)",
)
def test_the_site_is_built_without_a_warning_or_a_dead_link(tmp_path):
    """The tutorials are run by tests/test_docs.py, not here; of the examples, which are run, one is drawn."""
    words = [sys.executable, "-m", "website", "--out", str(tmp_path), "--no-notebooks", "--no-pictures"]
    done = subprocess.run(words, cwd=ROOT, capture_output=True, text=True, timeout=600)
    assert done.returncode == 0, done.stderr
    assert done.stderr == ""
    html = tmp_path / "html"
    for place in places().values():
        assert (html / place).with_suffix(".html").exists(), place
    page = (html / "gallery" / "travels-by-stick-slip.html").read_text(encoding="utf-8")
    assert "0.16434775" in page
    assert 'href="../live/lab.html#v=' in page
    assert 'id="worker"' in (html / "live" / "lab.html").read_text(encoding="utf-8")
    assert 'src="live/lab.html#v=' in (html / "index.html").read_text(encoding="utf-8")
    assert 'id="vibrocap.Exponential.steady_force"' in (html / "api" / "physics.friction.html").read_text("utf-8")
    assert Path(html / "objects.inv").stat().st_size > 0


def test_links_to_other_hosts_are_asked_when_wanted(tmp_path):
    """On a host of the test's own: a page that is there, one that is not, and no host at all."""

    class Host(http.server.BaseHTTPRequestHandler):
        def do_GET(self):
            self.send_response(200 if self.path == "/there" else 403 if self.path == "/shy" else 404)
            self.end_headers()

        def log_message(self, format, *args):
            pass

    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), Host) as host:
        threading.Thread(target=host.serve_forever, daemon=True).start()
        here = f"http://127.0.0.1:{host.server_port}"
        links = "".join(f'<a href="{here}/{name}">x</a>' for name in ("there#part", "shy", "gone"))
        (tmp_path / "page.html").write_text(f'{links}<a href="mailto:a@b.c">x</a>')
        elsewhere = dead_elsewhere(tmp_path, seconds=5.0)
        host.shutdown()
    assert len(elsewhere) == 1
    assert elsewhere[0] == f"{here}/gone: 404 Not Found (in page.html)"
