"""The page of `vibrocap lab` in a lecture: on paper, on a full screen, on a slope, from a disk, closed to others."""

import base64
import functools
import json
import math
import re

import pytest

import vibrocap as vc
from browser import CHROMIUM, browser
from test_lab_browser import FRESH, SETTLED, changed, place
from thinned import exhaustive_but
from vibrocap.cli.main import main

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(CHROMIUM is None, reason="no chromium is installed, in which the page is tested"),
]
SLOPE = 0.2
PAGE = re.compile(rb"/Type\s*/Page\b")
ON_PAPER = "(dispatchEvent(new Event('beforeprint')), document.getElementById('paper'))"


def systems():
    """The paper's, one on a slope whose load is a word, and a crawler of three bodies with more numbers than most."""
    uphill = vc.PendulumCapsule(normal_load="dynamic"), vc.Exponential(), vc.Harmonic()
    laws = [vc.MaxwellSlip(), vc.LuGre(), vc.Coulomb(0.8, 0.9)]
    return {
        "usual": None,
        "slope": vc.System(*uphill, environment=vc.Environment(inclination=SLOPE)),
        "crawler": vc.System(vc.ThreeBodyCrawler(), laws, vc.Biharmonic(1.5, 0.8, 0.7, 0.5)),
    }


@pytest.fixture(scope="module")
def pages(tmp_path_factory):
    """Pages on a disk by name, made when they are first asked for; their addresses."""
    folder = tmp_path_factory.mktemp("pages")

    @functools.cache
    def made(name):
        out, case = folder / f"{name}.html", []
        if (system := systems()[name]) is not None:
            case = [str(vc.Case(system, periods=4).save(folder / f"{name}.toml")), "--laws", system.friction.name]
            case += ["--drives", system.drive.name]
        assert main(["lab", *case, "--out", str(out)]) == 0
        return out.as_uri()

    return made


@pytest.fixture(scope="module")
def chromium():
    with browser() as found:
        yield found


@pytest.fixture
def opened(chromium, pages):
    """Opens a page and waits until its motion is there and measured; at the end nothing was complained of."""

    def open_(name="usual", fragment="", **options):
        chromium.events.clear()
        chromium.open(pages(name) + fragment, **options)
        chromium.wait(SETTLED)
        return chromium

    yield open_
    chromium.js("1")
    assert chromium.complaints() == []


def printed(chromium, paper):
    """The page as a PDF file on paper of so many inches."""
    size = dict(zip(("paperWidth", "paperHeight"), paper, strict=True))
    return base64.b64decode(chromium("Page.printToPDF", preferCSSPageSize=True, **size)["data"])


@pytest.mark.parametrize(
    ("name", "fragment"),
    exhaustive_but(
        [1],
        [
            ("usual", ""),
            ("usual", "#v=1&preset=paper-5-8-exponential&beside=smoothed-exponential"),
            ("usual", "#v=1&preset=paper-5-8-exponential&view=strip"),
            ("crawler", ""),
        ],
    ),
)
def test_it_prints_on_one_page(opened, name, fragment):
    page = opened(name, fragment)
    for paper in ((8.5, 11.0), (8.27, 11.69)):  # Letter, A4
        assert len(PAGE.findall(printed(page, paper))) == 1


def test_paper_shows_the_motion_its_numbers_and_its_address(opened):
    page = opened(dark=True)
    page.js("lab.play(false)")
    words = page.js(f"{ON_PAPER}.textContent")
    for part in ("mass ratio λ = 2.5", "decay rate a = 10", "amplitude h = 1.8", "angle = 1.0472", "40 periods"):
        assert part in words
    assert f"Drift per period: {page.js('said(lab.shown.drift, 8)')}" in words
    assert "usual.html#v=1&preset=paper-5-8-exponential; vibrocap" in words
    drawn = page.js(f"{ON_PAPER}.innerHTML")  # while the page is dark
    assert "#ffffff" in drawn
    assert "#171b21" not in drawn
    page("Emulation.setEmulatedMedia", media="print")
    text = (
        "[...document.querySelectorAll('header, main, footer, nav, button, canvas')].filter((each) => each.offsetWidth)"
    )
    assert page.js(f"{text}.length") == 0
    width, height = page.js(
        f"(({{ width, height }}) => [width, height])({ON_PAPER}.querySelector('circle').getBoundingClientRect())"
    )
    # The bob is round. A browser keeps coordinates in single precision: two edges of up to 1,000 px, each rounded.
    assert width == pytest.approx(height, rel=0.0, abs=2 * 1000.0 * 2.0**-24)
    assert width > 10.0
    assert (
        page.js("getComputedStyle(document.querySelector('#paper p')).color") == "rgb(27, 31, 36)"
    )  # light, as paper is
    assert page.js("[...document.querySelectorAll('#paper svg')].every((each) => !each.outerHTML.includes('NaN'))")
    page("Emulation.setEmulatedMedia", media="")


def test_numbers_on_paper_have_units_in_si(opened):
    page = opened("usual", "#v=1&preset=paper-5-8-exponential&units=SI&scales=0.2,0.25,0.16")
    words = page.js(f"{ON_PAPER}.textContent")
    assert re.search(r"decay rate a = [\d.]+ s/m", words)
    assert re.search(r"frequency ω = [\d.]+ Hz", words)
    assert re.search(r"Drift per period: [\d.]+ m;", words)
    assert re.search(r"normal load N = [\d.]+ N", words)
    assert re.search(r"friction [\u2212\d.]+ N\s+ground in m", words)  # the scene on paper, as on the screen
    page.js("lab.moment()")
    assert re.search(r"friction [\u2212\d.]+ N", page.js("document.getElementById('clock').textContent"))
    ranges = "[[-0.19, 0.31], [-1.9, 1.4], [0.01, 0.99], [-7, 9]]"
    assert min(page.js(f"{ranges}.map(([low, high]) => ticks(low, high, 2).length)")) > 1  # every axis has a scale


def test_a_page_on_a_disk_gives_its_case_in_place_of_a_link(opened):
    page = opened("usual", "#v=1&preset=paper-5-8-exponential&drive.amplitude=2")
    page.js("document.getElementById('link').click()")
    wait = page.wait("document.getElementById('notice').textContent")
    assert "nobody else can follow a link. Send the file usual.html itself" in wait
    assert "#v=1&preset=paper-5-8-exponential&drive.amplitude=2 behind its name" in wait
    assert page.js("lab.copied") == page.js("asToml(lab.model)")
    assert "amplitude = 2.0" in page.js("lab.copied")


def test_each_contact_tells_how_long_it_sticks(opened):
    """The first creeps, the last rests: its share of the stretch on show is that of the motion."""
    page = opened("crawler")
    cards = "[...document.querySelectorAll('#readouts div')].map((each) => each.textContent)"
    table = {f"contact {i}": text for text in page.js(cards) for i in (1, 2, 3) if f"Stuck, contact {i}" in text}
    assert "never" in table["contact 1"]
    assert "never" in table["contact 2"]
    share = page.js("lab.shown.stuck[2]")
    motion = vc.simulate(systems()["crawler"], periods=4)
    window = page.js("lab.shown.from"), motion.end
    assert share == pytest.approx(vc.stick_fraction(motion, window=window, contact=3), abs=1e-6)
    assert share > 0.01
    assert f"{100 * share:.4g}"[:4] in table["contact 3"]


def test_what_smoothing_would_say_shows_its_width_and_offers_others(opened):
    page = opened("usual", "#v=1&preset=paper-5-8-exponential&beside=smoothed-exponential")
    cards = "[...document.querySelectorAll('#readouts div')]"
    card = f"{cards}.find((each) => each.textContent.includes('smoothed')).textContent"
    assert "smoothed-exponential (width 0.001)" in page.js(card)
    assert "9.58 % less" in page.js(card)
    widths = "[...document.querySelectorAll('#parts button')].filter((each) => Number(each.textContent))"
    assert page.js(f"{widths}.map((each) => each.textContent)") == ["0.1", "0.01", "0.001"]
    changed(page, lambda: page.js(f"{widths}[1].click()"))
    assert "smoothed-exponential (width 0.01)" in page.js(card)
    exact, smooth = (page.js(f"lab.{name}.drift") for name in ("shown", "other"))
    law = vc.Exponential()
    from vibrocap.physics.friction.wrappers import smoothed

    system = vc.System(vc.PendulumCapsule(), smoothed(type(law))(smoothing_velocity=0.01), vc.Harmonic())
    motion = vc.simulate(system, periods=40, initial={"angle": math.pi / 3})
    assert smooth == pytest.approx(vc.drift(motion), abs=1e-6)
    assert f"{100 * (1 - smooth / exact):.1f}"[:4] in page.js(card)  # of the travel that there is


def test_the_machine_fills_the_screen(opened):
    page = opened()
    x, y, *_ = place(page, "#full")
    page.click(x, y)
    page.wait("!!document.fullscreenElement")
    page.wait("document.getElementById('scene').getBoundingClientRect().height === innerHeight")
    page.js("lab.moment()")
    scene = "document.getElementById('scene')"
    assert page.js(f"{scene}.height") > 2 * 250
    sizes = "(({ width, height }) => [width, height])"
    wide, high = page.js(f"{sizes}({scene}.getBoundingClientRect())")
    across, down = page.js(f"{sizes}({scene})")
    assert across / wide == pytest.approx(down / high, rel=2e-3)  # the bob is round
    playing = page.js("lab.clock.playing")
    page.js(f"{scene}.click()")
    assert page.js("lab.clock.playing") is not playing
    page.js("document.exitFullscreen()")
    page.wait("!document.fullscreenElement")


def test_the_scene_of_a_slope_is_one(opened):
    page = opened("slope", "#v=1&preset=slope&units=SI&scales=0.2,0.25,0.16")
    words = page.js(f"{ON_PAPER}.textContent")
    assert "normal load N = dynamic" in words
    assert "dynamic N" not in words  # a word has no unit
    page.js("lab.play(false)")
    turns = re.findall(r"rotate\((-?[\d.]+) ", page.js("sceneOnPaper(lab, lab.theme, 800, 250)"))
    assert float(turns[0]) == pytest.approx(-math.degrees(SLOPE), rel=1e-9)  # uphill to the right
    assert f"ground inclined by {math.degrees(SLOPE):.3g}°" in page.js("document.getElementById('clock').textContent")
    drawn = json.dumps("environment.inclination")
    page.js(FRESH)
    page.js(f"lab.model.set({drawn}, 0), lab.compute()")
    page.wait(SETTLED)
    assert "rotate(0 " in page.js("sceneOnPaper(lab, lab.theme, 800, 250)").replace("rotate(-0 ", "rotate(0 ")
    assert "inclined" not in page.js("document.getElementById('clock').textContent")


def test_no_number_of_the_ground_stands_under_an_arrow(opened):
    page = opened()
    page.js("lab.play(false)")
    shown = page.js("""Array.from({ length: 60 }, (_, k) => {
      const { from, end, form } = lab.shown, pen = new SvgPen(800, 250);
      const row = lab.shown.at(from + (k / 60) * (end - from));
      drawScene(pen, lab.theme, form, lab.now(row));
      return pen.parts.filter((each) => each.startsWith("<text")).map((each) => {
        const [, x, text] = /x="([^"]*)".*>([^<]*)</.exec(each);
        return [Number(x), text];
      });
    })""")
    for texts in shown:
        letters = [x for x, text in texts if text in "RN"]
        numbers = [x for x, text in texts if text not in "RN"]
        assert len(letters) == 2
        assert len(numbers) >= 3
        assert min(abs(x - letter) for x in numbers for letter in letters) > 12.0
