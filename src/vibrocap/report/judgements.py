"""The claims with their verdicts, and the errata, as HTML."""

from collections.abc import Mapping, Sequence
from html import escape

from vibrocap.paper.claims.claim import Outcome, Verdict
from vibrocap.paper.errata import ERRATA, Erratum
from vibrocap.report.pieces import number, numbers, titled

BADGES = {Outcome.HOLDS: "holds", Outcome.ONLY_FOR: "only", Outcome.FAILS: "fails", Outcome.UNDECIDED: "open"}


def filters(verdicts: Sequence[Verdict]) -> str:
    """Buttons that show the claims of one verdict alone, with how many there are."""
    cells = [_button("all", "total", f"all {len(verdicts)}", True)]
    for outcome, badge in BADGES.items():
        if count := sum(verdict.finding.outcome is outcome for verdict in verdicts):
            dots = " …" if outcome is Outcome.ONLY_FOR else ""
            cells.append(_button(badge, badge, f"{count} {outcome.value}{dots}", False))
    return f'<div class="filters" role="group" aria-label="claims to show">{"".join(cells)}</div>'


def _button(name: str, badge: str, words: str, pressed: bool) -> str:
    return (
        f'<button type="button" class="badge {badge}" data-show="{name}" aria-pressed="{str(pressed).lower()}">'
        f"{words}</button>"
    )


def chapter_key(title: str) -> str:
    """The anchor of a chapter of claims."""
    return "claims-" + "-".join("".join(c if c.isalnum() else " " for c in title.lower()).split())


def chapter(title: str, verdicts: Sequence[Verdict], figures: Sequence[str]) -> str:
    """A chapter of claims. figures: keys of those on the page, which are linked."""
    claims = "".join(_claim(verdict, figures) for verdict in verdicts)
    heading = titled(3, chapter_key(title), title[0].upper() + title[1:])
    return f'<section class="chapter">{heading}{claims}</section>'


def _claim(verdict: Verdict, figures: Sequence[str]) -> str:
    claim, finding = verdict.claim, verdict.finding
    badge = BADGES[finding.outcome]
    links = [f'<a class="self" href="#{claim.key}"><code>{claim.key}</code></a>']
    links += [f'<a href="#{key}">Fig. {int(key[3:])}</a>' for key in claim.figures if key in figures]
    links += [
        f'<a href="#erratum-{each.number}">erratum {each.number}</a>' for each in ERRATA if claim.key in each.claims
    ]
    nearest = f'<p class="nearest"><b>Nearest true:</b> {escape(finding.nearest)}</p>' if finding.nearest else ""
    return (
        f'<article class="claim" id="{claim.key}" data-outcome="{badge}">'
        f'<div><p class="where">{escape(claim.where)}</p><p>{escape(claim.says)}</p>'
        f'<p class="small links">{" ".join(links)}</p></div>'
        f'<div><p class="badge {badge}">{escape(verdict.verdict)}</p><p>{escape(finding.why)}</p>{nearest}</div>'
        f'<div class="small"><p>{escape(claim.test)}</p>{numbers(finding.found)}'
        f"<p>Tolerance {number(claim.tolerance.value)}: {escape(claim.tolerance.origin)}.</p></div></article>"
    )


def errata(verdicts: Mapping[str, Sequence[Verdict]], only: str | None) -> str:
    """The errata; of a part of the paper those that its claims show."""
    keys = {verdict.claim.key for chapter in verdicts.values() for verdict in chapter}
    return "".join(_erratum(each, keys) for each in ERRATA if only is None or keys & set(each.claims))


def _erratum(erratum: Erratum, keys: set[str]) -> str:
    links = ", ".join(f'<a href="#{key}">{key}</a>' if key in keys else f"<span>{key}</span>" for key in erratum.claims)
    return (
        f'<section class="erratum">{titled(3, f"erratum-{erratum.number}", f"{erratum.number}. {erratum.title}")}'
        f'<p class="where">{escape(erratum.where)}</p>'
        f"<p><b>Printed.</b> {escape(erratum.printed)}</p><p><b>Right.</b> {escape(erratum.right)}</p>"
        f"<p class='small'>Claims: {links}.</p></section>"
    )
