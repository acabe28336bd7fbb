"""The report as a page, in a browser: claims by verdict, contents, digits, narrow and dark screens, and paper."""

import collections

import pytest

from browser import CHROMIUM, browser
from thinned import exhaustive_but
from vibrocap.report.page import BADGES
from vibrocap.report.reproduce import reproduce

pytestmark = [pytest.mark.slow, pytest.mark.skipif(CHROMIUM is None, reason="needs Chromium")]
VISIBLE = "(each) => each.offsetParent !== null"
# Least contrast of text against what is behind it, over everything that has text of its own (WCAG 2.1, 1.4.3: 4.5).
CONTRAST = """(() => {
  const channels = (text) => text.match(/[\\d.]+/g).map(Number);
  const light = ([r, g, b]) => [r, g, b].map((c) => c / 255)
    .map((c) => (c <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4))
    .reduce((sum, c, i) => sum + c * [0.2126, 0.7152, 0.0722][i], 0);
  const behind = (each) => {
    for (let at = each; at; at = at.parentElement) {
      const colour = channels(getComputedStyle(at).backgroundColor);
      if (colour.length < 4 || colour[3] > 0) return colour;
    }
    return [255, 255, 255];
  };
  let worst = [99, ""];
  for (const each of document.querySelectorAll("body *")) {
    if (each.offsetParent === null || ![...each.childNodes].some((n) => n.nodeType === 3 && n.data.trim())) continue;
    const [a, b] = [light(channels(getComputedStyle(each).color)), light(behind(each))];
    const ratio = (Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05);
    if (ratio < worst[0]) worst = [ratio, each.outerHTML.slice(0, 120)];
  }
  return worst;
})()"""


@pytest.fixture(scope="module")
def report(tmp_path_factory):
    """The report on one figure, which has claims of three verdicts."""
    made = reproduce(tmp_path_factory.mktemp("report"), "fig08")
    with browser() as shown:
        yield shown, made, made.report.as_uri()
        assert shown.complaints() == []


def claims(shown):
    return shown.js(f"[...document.querySelectorAll('.claim')].filter({VISIBLE}).map((each) => each.id)")


def test_claims_are_shown_by_verdict(report):
    shown, made, url = report
    shown.open(url)
    shown.wait("document.readyState === 'complete' && document.querySelectorAll('.claim').length > 0")
    counts = collections.Counter(BADGES[verdict.finding.outcome] for verdict in made.claims)
    assert len(counts) > 1
    assert len(claims(shown)) == len(made.claims)
    for outcome, count in counts.items():
        shown.js(f"document.querySelector('[data-show={outcome}]').click()")
        assert len(claims(shown)) == count
        pressed = "[...document.querySelectorAll('[aria-pressed=true]')].map((each) => each.dataset.show)"
        assert shown.js(pressed) == [outcome]
        empty = "[...document.querySelectorAll('.chapter:not(:has(.claim:not([hidden])))')]"
        assert not shown.js(f"{empty}.some({VISIBLE})")
    hidden = next(verdict.claim.key for verdict in made.claims if verdict.claim.key not in claims(shown))
    shown.js(f"location.hash = '#{hidden}'")  # a link to what is not shown shows it
    shown.wait(f"document.getElementById('{hidden}').offsetParent !== null")
    assert len(claims(shown)) == len(made.claims)


def test_contents_stay_in_sight_and_numbers_have_all_their_digits(report):
    shown, _, url = report
    shown.open(url)
    shown.wait("document.readyState === 'complete'")
    shown.js("document.getElementById('errata').scrollIntoView()")
    assert shown.js("document.querySelector('nav').getBoundingClientRect().top") == 0
    shown.wait("document.querySelector('nav [aria-current]').hash === '#errata'")
    number = "document.querySelector('.claim data[title]')"
    short, full = shown.js(f"[{number}.textContent, {number}.title]")
    assert len(short) < len(full)
    shown.js(f"{number}.click()")
    assert shown.js(f"{number}.textContent") == full
    shown.js(f"{number}.click()")
    assert shown.js(f"{number}.textContent") == short


@pytest.mark.parametrize(
    ("width", "dark"), exhaustive_but([1, 2], [(390, False), (390, True), (1280, False), (1280, True)])
)
def test_nothing_is_cut_off_or_faint(report, width, dark):
    shown, _, url = report
    shown.open(url, width, 844, dark)
    shown.wait("document.readyState === 'complete'")
    assert shown.js("document.documentElement.scrollWidth") == width
    assert shown.js("document.querySelector('nav details').open") is (width > 1000)
    contrast, where = shown.js(CONTRAST)
    assert contrast >= 4.5, where


def test_paper_has_everything_open(report):
    shown, made, url = report
    shown.open(url)
    shown.wait("document.readyState === 'complete'")
    shown.js("document.querySelector('[data-show=holds]').click()")
    shown("Emulation.setEmulatedMedia", media="print")
    assert len(claims(shown)) == len(made.claims)
    assert not shown.js(f"[...document.querySelectorAll('nav, .filters')].some({VISIBLE})")
    folded = "[...document.querySelectorAll('.claim details .numbers')]"
    assert shown.js(f"{folded}.length") > 0
    assert shown.js(f"{folded}.every((each) => each.checkVisibility({{contentVisibilityAuto: true}}))")
    assert shown.js(f"{folded}.every((each) => each.getBoundingClientRect().height > 20)")
    broken = "[...document.querySelectorAll('figure, .claim, tr, .before')]"
    assert set(shown.js(f"{broken}.map((each) => getComputedStyle(each).breakInside)")) == {"avoid"}
    headings = "[...document.querySelectorAll('h2, h3')].map((each) => getComputedStyle(each).breakAfter)"
    assert set(shown.js(headings)) == {"avoid"}
    assert shown.js("getComputedStyle(document.getElementById('claims')).breakBefore") == "page"
    shown("Emulation.setEmulatedMedia", media="")
