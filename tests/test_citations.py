"""Citations: every law, machine, drive and method has a source that resolves; one bibliography, all of it used.

The page of references and the bibliography of the paper are what the bibliography makes of them; `CITATION.cff`, the
paper and the package name the same authors and title.
"""

import re
import unicodedata
from pathlib import Path

import numpy as np
import pytest

import vibrocap as vc
from vibrocap.citations import bibliography as made
from vibrocap.citations.bibliography import SOFTWARE, bibliography, bibliography_of, cited_keys, references
from vibrocap.citations.cite import ANALYSES, METHODS, SIMULATION
from vibrocap.cli import main as cli
from vibrocap.cli.terminal import OK, WRONG_INPUT
from vibrocap.physics.catalogue import controllers, drives, law, laws, machines, wrappers

ROOT = Path(__file__).resolve().parents[1]
PAPER = ROOT / "paper/paper.md"
WRAPPED = ("anisotropic-lugre", "backlash-dahl", "smoothed-coulomb", "viscous-stribeck")
PARTS = [*laws().values(), *machines().values(), *drives().values(), *controllers().values()]
PARTS += [*map(law, WRAPPED), vc.Actuator]
LUGRE = vc.System(vc.PendulumCapsule(), vc.LuGre(), vc.Harmonic())
REQUIRED = {
    "article": {"author", "title", "journal", "year"},
    "book": {"author", "title", "publisher", "year"},
    "incollection": {"author", "title", "booktitle", "publisher", "year"},
    "inproceedings": {"author", "title", "booktitle", "year"},
    "phdthesis": {"author", "title", "school", "year"},
    "software": {"author", "title", "year"},
    "techreport": {"author", "title", "institution", "year"},
}


def keys_of(source):
    return [reference.key for reference in references(source)]


# --- sources ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("part", PARTS, ids=lambda part: part.name)
def test_every_law_machine_and_drive_has_a_source_that_resolves(part):
    found = references(part.source)
    assert found
    assert all(each.key in bibliography() for each in found)


@pytest.mark.parametrize("method", METHODS, ids=lambda method: method.name)
def test_every_method_has_a_source_that_resolves(method):
    assert keys_of(method.source)
    assert set(keys_of(method.source)) <= set(bibliography())


def test_a_wrapped_law_has_the_sources_of_the_law_and_of_what_is_around_it():
    assert {name.partition("-")[0] for name in WRAPPED} == set(wrappers())
    for name in WRAPPED:
        inner = keys_of(law(name.partition("-")[2]).source)
        both = keys_of(law(name).source)
        assert both[: len(inner)] == inner
        assert len(both) > len(inner)


def test_every_entry_is_used():
    """By a part, a method or the paper; nothing is cited nowhere."""
    used = {each for part in PARTS for each in keys_of(part.source)}
    used |= {each for method in METHODS for each in keys_of(method.source)}
    used |= {SOFTWARE, *cited_keys(PAPER.read_text(encoding="utf-8"))}
    assert used == set(bibliography())


# --- the bibliography ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("reference", bibliography().values(), ids=lambda each: each.key)
def test_an_entry_has_what_its_kind_asks_for(reference):
    assert set(reference.fields) >= REQUIRED[reference.kind]
    assert all(value.strip() == value and value.count("{") == value.count("}") for value in reference.fields.values())
    if reference.key != SOFTWARE:  # the key is the first author's name and the year
        letters = unicodedata.normalize("NFKD", reference.authors[0].lower())
        name = re.fullmatch(rf"([a-z]+){reference.fields['year']}[a-z]?", reference.key)
        assert name is not None
        assert name.group(1) in re.sub(r"[^a-z]", "", letters)
    if "doi" in reference.fields:
        assert re.fullmatch(r"10\.\d{4,5}/\S+", reference.fields["doi"])
    if reference.kind == "article" and "pages" in reference.fields:
        first, _, last = reference.fields["pages"].partition("-")
        assert not last or int(first) < int(last)


def test_no_work_stands_there_twice():
    titles = [re.sub(r"\W", "", each.fields["title"].lower()) for each in bibliography().values()]
    dois = [each.fields["doi"].lower() for each in bibliography().values() if "doi" in each.fields]
    assert len(set(titles)) == len(titles)
    assert len(set(dois)) == len(dois)


def test_bibtex_is_read_again_as_it_was(tmp_path, monkeypatch):
    path = tmp_path / "again.bib"
    text = made.as_bibtex(bibliography().values())
    path.write_text(text.replace(f"  version = {{{vc.__version__}}},\n", ""), encoding="utf-8")
    before = dict(bibliography())
    monkeypatch.setattr(made, "FILE", path)
    again = made.bibliography.__wrapped__()
    assert {key: (each.kind, dict(each.fields)) for key, each in again.items()} == {
        key: (each.kind, dict(each.fields)) for key, each in before.items()
    }


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("@book{a1990,\n  title = {One},\n}\n\n@book{a1990,\n  title = {Two},\n}\n", "a1990 occurs twice"),
        ("@book{a1990,\n  title: {One},\n}\n", "should be '  name = {value},'"),
        ("@book{a1990,\n  title = {One},\n}\nstray\n", "belongs to no entry: 'stray'"),
    ],
)
def test_a_damaged_bibliography_is_refused(text, said, tmp_path, monkeypatch):
    path = tmp_path / "bad.bib"
    path.write_text(text, encoding="utf-8")
    monkeypatch.setattr(made, "FILE", path)
    with pytest.raises(ValueError, match=re.escape(said)):
        made.bibliography.__wrapped__()


def test_a_source_is_keys_or_words_and_a_mistyped_key_is_named():
    by_key, in_words = references("canudas1995; a report of our laboratory, 2026", name="own")
    assert by_key is bibliography()["canudas1995"]
    assert in_words.text == "a report of our laboratory, 2026"
    assert in_words.bibtex == "@misc{own,\n  note = {a report of our laboratory, 2026},\n}"
    assert [reference.key for reference in references("one; two", name="own")] == ["own", "own-2"]
    assert references("") == ()
    with pytest.raises(ValueError, match="'canudas1996' is no key of the bibliography; did you mean 'canudas1995'"):
        references("canudas1996")


def test_the_page_of_references_has_every_entry_with_its_doi():
    rows = re.findall(r"^- `(\w+)`: (.+)\.$", made.references_page(), re.MULTILINE)
    assert rows[0][0] == SOFTWARE
    assert sorted(key for key, _ in rows) == sorted(bibliography())
    for key, text in rows:
        doi = bibliography()[key].fields.get("doi")
        assert ("https://doi.org/" in text) == (doi is not None), key
        assert doi is None or f"[{doi}](" in text


# --- what is cited for a system --------------------------------------------------------------------------------------


def test_a_system_is_cited_by_its_parts_and_by_the_methods_that_simulate_it():
    cite = vc.cite(LUGRE)
    assert cite.facts["machine pendulum-capsule"] == cite.facts["drive harmonic"] == "liu2019"
    assert cite.facts["friction law lugre"] == "canudas1995, olsson1996"
    keys = [reference.key for reference in cite.references]
    assert len(set(keys)) == len(keys)
    assert keys[0] == SOFTWARE
    assert "steinebach2023" in keys
    assert "filippov1988" not in keys  # its contact has a force for every velocity
    sticks = vc.System(vc.PendulumCapsule(), vc.Coulomb(), vc.Harmonic())
    sticking = {reference.key for reference in vc.cite(sticks).references}
    assert "filippov1988" in sticking
    assert not sticking & {"steinebach2023", "ketcheson2012", "murty1974"}


def test_laws_of_further_contacts_and_impacts_have_their_methods():
    both = vc.cite(vc.System(vc.TwoBodyCrawler(), [vc.Coulomb(), vc.Dahl()], vc.Harmonic()))
    assert {"friction law coulomb", "friction law dahl"} <= set(both.facts)
    assert {"murty1974", "filippov1988", "steinebach2023"} <= {reference.key for reference in both.references}
    struck = vc.cite(vc.System(vc.RigidStopCapsule(), vc.Coulomb(), vc.Harmonic()), analyses=["branch"])
    assert {"brogliato2016", "nordmark1991"} <= {reference.key for reference in struck.references}
    assert "nordmark1991" not in vc.cite(LUGRE, analyses=["branch"]).bibtex


@pytest.mark.parametrize("analysis", ANALYSES)
def test_an_analysis_adds_its_methods(analysis):
    system = vc.System(vc.RigidStopCapsule(), vc.Coulomb(), vc.Harmonic())
    more = [method.name for method in METHODS if analysis in method.analyses]
    assert SIMULATION not in ANALYSES
    assert more
    assert set(more) <= set(vc.cite(system, analyses=[analysis]).facts)
    assert not set(more) & set(vc.cite(system).facts)


@pytest.mark.slow
def test_a_case_and_a_motion_are_cited_as_their_system_and_nothing_as_vibrocap():
    case = vc.Case(LUGRE, periods=1)
    assert vc.cite(case) == vc.cite(LUGRE) == vc.cite(case.simulate())
    assert [reference.key for reference in vc.cite().references] == [SOFTWARE, "liu2019"]
    assert f"version {vc.__version__} " in str(vc.cite())


@pytest.mark.exhaustive
def test_an_orbit_is_cited_as_its_system_and_a_fit_by_its_law_and_the_methods_of_fits():
    orbit = vc.orbit(LUGRE.with_parameters({"friction.bristle_stiffness": 50.0}))
    assert vc.cite(orbit).facts == vc.cite(LUGRE).facts
    assert vc.cite(vc.LuGre()).facts == {"vibrocap": "vibrocap", "friction law lugre": "canudas1995, olsson1996"}
    time = np.linspace(0.0, 4.0, 400)
    velocity = 0.3 * np.sin(2.0 * np.pi * time)
    record = vc.Record("shaken", time, vc.driven_force(vc.Dahl(), time, velocity).force, velocity=velocity)
    facts = vc.cite(vc.fit(record, "dahl", starts=1, intervals="covariance")).facts
    assert facts["friction law dahl"] == "dahl1968, dahl1976"
    assert {method.name for method in METHODS if "fit" in method.analyses} <= set(facts)
    assert "Taylor series of high order and their step" not in facts


@pytest.mark.parametrize(
    ("given", "options", "said"),
    [
        (3, {}, "of should be a system, a part, a case or a result that has a system or a law, got int"),
        (LUGRE, {"analyses": ["orbits"]}, "analyses: 'orbits' is none; did you mean 'orbit'?"),
        (None, {"analyses": ["orbit"]}, "of should be the system or case that is analysed, got none"),
    ],
)
def test_what_cannot_be_cited_is_refused(given, options, said):
    with pytest.raises(ValueError, match=re.escape(said)):
        vc.cite(given, **options)


def test_a_part_without_a_source_is_said_to_have_none():
    class Nameless(vc.Coulomb):
        """Coulomb's law under another name."""

        name = "nameless"
        source = ""

    text = str(vc.cite(vc.System(vc.Oscillator(), Nameless(), vc.Harmonic())))
    assert re.search(r"friction law nameless +no source: name it in `source` of the class", text)


def test_the_command_prints_text_or_bibtex(capsys, tmp_path):
    path = str(vc.Case(LUGRE, periods=1).save(tmp_path / "case.toml"))
    assert cli.main(["simulate", path, "--cite", "text", "--analyses", "orbit,fit"]) == OK
    assert capsys.readouterr().out == f"{vc.cite(LUGRE, analyses=['orbit', 'fit'])}\n"
    assert cli.main(["simulate", path, "--cite", "bibtex"]) == OK
    assert capsys.readouterr().out == vc.cite(LUGRE).bibtex
    assert cli.main(["simulate", path, "--cite", "text", "--analyses", "orbits"]) == WRONG_INPUT
    assert "--analyses: 'orbits' is none; did you mean 'orbit'?" in capsys.readouterr().err


# --- the paper and CITATION.cff --------------------------------------------------------------------------------------
SECTIONS = ["Summary", "Statement of need", "State of the field", "Software design", "Research impact statement"]
SECTIONS += ["AI usage disclosure", "Acknowledgements", "References"]


def test_the_bibliography_of_the_paper_holds_what_it_cites_and_nothing_else():
    """Written anew by `python -m vibrocap.citations.bibliography paper/paper.md > paper/paper.bib`."""
    written = (ROOT / "paper" / "paper.bib").read_text(encoding="utf-8")
    assert written == bibliography_of(PAPER.read_text(encoding="utf-8"))
    assert len(re.findall(r"^@", written, re.MULTILINE)) >= 15


def test_the_paper_has_the_form_of_the_journal():
    head, body = PAPER.read_text(encoding="utf-8").removeprefix("---\n").split("\n---\n", 1)
    assert set(re.findall(r"^(\w+):", head, re.MULTILINE)) >= {"title", "tags", "authors", "affiliations", "date"}
    assert "bibliography: paper.bib" in head
    assert re.search(r"^date: \d{1,2} [A-Z][a-z]+ \d{4}$", head, re.MULTILINE)
    assert re.findall(r"^# (.+)$", body, re.MULTILINE) == SECTIONS
    words = re.sub(r"<!--.*?-->|!\[|\]\(.*?\)|\[@.*?\]|[|*`#-]", " ", body, flags=re.DOTALL).split()
    assert 750 <= len(words) <= 1750


def test_the_paper_counts_machines_laws_and_drives_as_they_are():
    text = " ".join(PAPER.read_text(encoding="utf-8").split())
    counted = [int(re.search(rf"(\d+) {what}", text).group(1)) for what in ("machines", "friction laws", "drives")]
    assert counted == [len(machines()), len(laws()), len(drives())]


def test_pictures_of_the_paper_are_there_and_their_commands_are_said():
    text = PAPER.read_text(encoding="utf-8")
    pictures = re.findall(r"!\[[^\]]*\]\(([^)]+)\)", text)
    assert pictures
    for picture in pictures:
        assert (PAPER.parent / picture).is_file()
        assert (PAPER.parent / picture).stat().st_size < 300_000
        assert re.search(rf"<!-- .*{re.escape(Path(picture).name)}.* -->", text), "the command that makes it"


def test_cff_paper_and_bibliography_name_the_same_authors_and_title():
    cff = (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    own = bibliography()[SOFTWARE]
    authors = re.findall(r'^  - name: "(.+)"$', cff.partition("references:")[0], re.MULTILINE)
    assert tuple(authors) == own.authors
    assert re.search(r'^title: "(.+)"$', cff, re.MULTILINE).group(1) == own.fields["title"]
    head = PAPER.read_text(encoding="utf-8").split("\n---\n")[0]
    (name, *_) = re.findall(r"^  - name: (.+)$", head.partition("affiliations:")[0], re.MULTILINE)
    assert name.startswith("TO BE FILLED") is ("TO BE FILLED BY A PERSON" in head)  # the notice stands as long as it
    assert bibliography()["liu2019"].fields["title"] in cff
