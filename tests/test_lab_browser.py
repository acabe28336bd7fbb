"""The page of `vibrocap lab` in a browser: all laws and machines, sliders, files, addresses, maps, and readers."""

import gzip
import json
import math
import subprocess
import sys
from pathlib import Path

import pytest

import vibrocap as vc
from browser import CHROMIUM, browser
from lab_motions import KINDS, ending, motions_of_a_kind, plain, stored
from thinned import exhaustive_but
from vibrocap.cli.main import main
from vibrocap.lab.bundle import Contents, Preset, bundle, end_of
from vibrocap.lab.page import page
from vibrocap.motion.recording.equations import parameter_values
from vibrocap.numerics.api import browser_module
from vibrocap.paper.presets import figures_5_to_8
from vibrocap.physics.catalogue import drives, laws, machines

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(CHROMIUM is None, reason="no chromium is installed, in which the page is tested"),
]
SETTLED = "document.body.dataset.settled"
FRESH = "delete document.body.dataset.settled"
WHERE = """(() => {{
  const {{ x, y, width, height }} = document.querySelector({!r}).getBoundingClientRect();
  return [x, y, width, height];
}})()"""
READABLE = (Path(__file__).parent / "page_reader.js").read_text()


@pytest.fixture(scope="module")
def chromium():
    with browser() as found:
        yield found


@pytest.fixture(scope="module")
def usual(tmp_path_factory):
    """The page that the command writes, as an address."""
    out = tmp_path_factory.mktemp("page") / "lab.html"
    assert main(["lab", "--out", str(out)]) == 0
    assert out.stat().st_size < 298_000
    assert len(gzip.compress(out.read_bytes(), 9)) < 126 * 1024
    return out.as_uri()


@pytest.fixture
def shown(chromium, usual):
    """The page, open and settled; at the end nothing was complained of and nothing was asked of a network."""
    chromium.events.clear()
    chromium.open(usual)
    chromium.wait(SETTLED)
    yield chromium
    chromium.js("1")
    assert chromium.complaints() == []


def end(chromium, **keys):
    """The final state of the motion on show."""
    return chromium.js("[...lab.shown.final]")


def place(chromium, selector):
    """Middle and size of an element in the window, scrolled into it."""
    chromium.js(f"document.querySelector({selector!r}).scrollIntoView({{block: 'center'}})")
    x, y, width, height = chromium.js(WHERE.format(selector))
    return x + width / 2, y + height / 2, width, height


def changed(chromium, do):
    """Do something that asks for another motion, and wait until it is there and measured."""
    chromium.js(FRESH)
    do()
    chromium.wait(SETTLED)


def test_the_page_says_what_the_package_says(shown):
    """The motion of the first preset to the last bit of the plain kernel, and its drift as `simulate` has it."""
    shown.js("document.getElementById('check').click()")
    assert shown.wait("document.body.dataset.check") == "same"
    preset = shown.js("lab.model.preset")
    assert preset["key"] == "paper-5-8-exponential"
    motion = vc.simulate(figures_5_to_8("exponential"), initial={"angle": preset["initial"]["angle"]})
    drift = float(shown.js("document.getElementById('read-drift').firstChild.textContent").replace("−", "-"))
    assert drift == pytest.approx(vc.drift(motion), abs=1e-8)
    assert shown.js("document.getElementById('contact').textContent") in ("slips forward", "slips back", "sticks")


ALL = """(async () => {
  const found = [];
  for (const [form, { parameters, initial, periods, tolerance }] of GIVEN.entries()) {
    const request = { form, parameters, initial, periods, tolerance };
    const motion = await lab.asked.ask({ ask: "motion", side: 2, ...request, limits: {}, view: { periods: 1 } });
    const { final, pieces, events, status } = motion;
    found.push({ state: [...final].slice(0, initial.length), pieces, events: events.length / 2, status });
  }
  return found;
})()"""


@pytest.fixture
def ends_of(chromium, tmp_path, monkeypatch):
    """Runs cases in one page, opened at the first of each machine, with kernels of many motions for those alone.

    cases: by machine and law. The page of the very first finds its own end by itself. Returns the ends of all.
    """

    def run(cases):
        opened = {}
        for i, ((machine, _), case) in enumerate(cases.items()):
            opened.setdefault(machine, (i, case))
        places, (first, *_) = [i for i, _ in opened.values()], cases.values()
        monkeypatch.setattr(
            "vibrocap.numerics.api.browser_module",
            lambda pairs: browser_module([pair if i in places else pair[:1] for i, pair in enumerate(pairs)]),
        )
        monkeypatch.setattr("vibrocap.lab.bundle.end_of", lambda case: end_of(case) if case is first else None)
        presets = tuple(Preset(name, name, "", case) for name, (_, case) in opened.items())
        out = tmp_path / "all.html"
        out.write_text(page(bundle(Contents(tuple(case.system for case in cases.values()), presets))))
        chromium.events.clear()
        for preset in reversed(presets):
            chromium.open(f"{out.as_uri()}#v=1&preset={preset.key}", 1280, 700)
            chromium.wait(SETTLED)
            assert chromium.js("lab.model.form.machine") == preset.key
        chromium.js("checked(lab)")
        assert chromium.wait("document.body.dataset.check") == "same"
        settings = [
            {
                "parameters": list(parameter_values(case.system)),
                "initial": [float(case.initial.get(name, 0.0)) for name in case.system.state_names],
                "periods": case.periods,
                "tolerance": case.tolerance,
            }
            for case in cases.values()
        ]
        endings = [ending(**each) for each in chromium.js(ALL.replace("GIVEN", json.dumps(settings)))]
        assert chromium.complaints() == []
        return dict(zip(cases, endings, strict=True))

    return run


def known_ends(cases):
    """Ends as they are stored (`lab_motions.py`), or by the plain kernel."""
    known = stored()
    return {(machine, law): known.get(machine, {}).get(law) or plain(case) for (machine, law), case in cases.items()}


def test_every_machine_has_a_kind():
    assert sorted(name for names in KINDS.values() for name in names) == sorted(machines())


@pytest.mark.parametrize(("kind", "every"), exhaustive_but([0], [([*KINDS][1], 3), *((kind, 1) for kind in KINDS)]))
def test_every_law_on_every_kind_of_machine_runs_and_is_the_plain_kernel(ends_of, kind, every):
    """To the last bit; every machine is opened and drawn, and meets several laws. Daily a third of one kind."""
    cases = dict([*motions_of_a_kind(kind).items()][::every])
    assert every > 1 or {law for _, law in cases} == {*laws()}
    assert every > 1 or {machine for machine, _ in cases} == {*KINDS[kind]}
    assert ends_of(cases) == known_ends(cases)


def test_sliders_follow_the_mouse_and_the_keyboard(shown):
    before = end(shown)
    slider = "#n-machine-mass_ratio"
    x, y, _, _ = place(shown, f"{slider}")
    shown.js(f"document.querySelector('{slider}').closest('.row').querySelector('[type=range]').id = 'under-test'")
    x, y, width, _ = place(shown, "#under-test")
    changed(shown, lambda: shown.click(x + 0.2 * width, y))
    dragged = shown.js("lab.model.get('machine.mass_ratio')")
    assert dragged > 2.5
    assert end(shown) != before
    changed(shown, lambda: shown.key("ArrowLeft"))
    assert 0.9 * dragged < shown.js("lab.model.get('machine.mass_ratio')") < dragged
    said = shown.js("document.getElementById('under-test').getAttribute('aria-valuetext')")
    assert float(said) == pytest.approx(shown.js("lab.model.get('machine.mass_ratio')"))


def test_what_is_no_number_is_refused_beside_its_box(shown):
    """The last good motion stays."""
    before = end(shown)
    for text in ("", "abc", "NaN", "-1", "1,5", "1e999"):
        put = f"box.value = {text!r}; box.dispatchEvent(new Event('input'))"
        shown.js(f"(() => {{ const box = document.getElementById('n-machine-mass_ratio'); {put}; }})()")
        said = shown.js("document.getElementById('n-machine-mass_ratio-wrong').textContent")
        assert said.startswith("should be")
        assert (text or "nothing") in said
        assert shown.js("document.getElementById('n-machine-mass_ratio').getAttribute('aria-invalid')") == "true"
        assert shown.js("lab.model.get('machine.mass_ratio')") == 2.5
        assert end(shown) == before
        good = "box.value = '2.5'; box.dispatchEvent(new Event('input'))"
        shown.js(f"(() => {{ const box = document.getElementById('n-machine-mass_ratio'); {good}; }})()")
        assert shown.js("document.getElementById('n-machine-mass_ratio-wrong').textContent") == ""


def test_two_cases_stand_beside_each_other(shown):
    """The motion as it was, kept; a preset on another law; the mirror-image solution. Address and swap."""
    beside = """(() => {{
      const box = document.getElementById('beside');
      box.value = {!r};
      box.dispatchEvent(new Event('change'));
    }})()"""
    before = end(shown)
    changed(shown, lambda: shown.js(beside.format("=")))
    changed(shown, lambda: shown.js("lab.model.set('drive.amplitude', 1.37); lab.compute()"))
    assert shown.js("[...lab.other.final]") == before != end(shown)
    assert shown.js("lab.drawings.map(({ panel }) => panel.key)")[-1] == "difference"
    shown.wait("location.hash.includes('amplitude=1.37&beside=kept&kept=preset%3Dpaper-5-8-exponential')")
    after, address = end(shown), shown.js("location.href")
    shown.open(address)
    shown.wait(SETTLED)
    assert (end(shown), shown.js("[...lab.other.final]")) == (after, before)
    changed(shown, lambda: shown.js("[...document.querySelectorAll('#parts button')].at(-1).click()"))
    assert (end(shown), shown.js("[...lab.other.final]")) == (before, after)
    changed(shown, lambda: shown.js(beside.format("=preset=paper-9-11-lugre")))
    assert shown.js("lab.other.form.friction") == "lugre"
    changed(shown, lambda: shown.js(beside.format("twin")))
    drift, other = shown.js("[lab.shown.drift, lab.other.drift]")
    assert other == pytest.approx(-drift, rel=1e-6)
    assert abs(drift) > 0.1


def test_the_mirror_twin_is_shown_wherever_there_is_one(chromium, tmp_path):
    """Under drives of many pieces and on worms too: half a period later it is where the motion is, mirrored."""
    machine, law, worm = vc.PendulumCapsule(), vc.Exponential(), vc.TwoBodyWorm(mass_2=2.0)
    cases = [
        vc.Case(vc.System(machine, law, drives()["square"](amplitude=1.7)), {"angle": 0.5}, periods=2),
        vc.Case(vc.System(worm, law, drives()["triangle"]()), {"centre_velocity": 0.2}, periods=2),
    ]
    presets = tuple(Preset(f"twin-{i}", "twin", "", case) for i, case in enumerate(cases))
    out = tmp_path / "twins.html"
    out.write_text(page(bundle(Contents(tuple(case.system for case in cases), presets))))
    chromium.events.clear()
    for preset in presets:
        chromium.open(f"{out.as_uri()}#v=1&preset={preset.key}")
        chromium.wait(SETTLED)
        assert chromium.js("[...document.getElementById('beside').options].some(({ value }) => value === 'twin')")
        changed(chromium, lambda: chromium.js("lab.model.state.beside = 'twin'; lab.rebuilt()"))
        later = "lab.asked.ask({ ask: 'motion', side: 2, ...lab.model.request(), periods: 2.5 })"
        signs = preset.case.system.symmetry
        wanted = [
            sign * x for sign, x in zip(signs, chromium.js(f"{later}.then(({{ final }}) => [...final])"), strict=False)
        ]
        twin = chromium.js("[...lab.other.final]")[: len(signs)]
        assert twin == pytest.approx(wanted, rel=1e-6, abs=1e-8)
        assert twin != pytest.approx(end(chromium)[: len(signs)], rel=1e-2)
    chromium.open(f"{out.as_uri()}#v=1&preset=twin-0&drive.duty=0.4&beside=twin")
    chromium.wait(SETTLED)
    assert "no mirror-image solution" in chromium.js("document.getElementById('notice').textContent")
    assert chromium.js("[lab.shown.count > 0, lab.other]") == [True, None]
    changed(chromium, lambda: chromium.js("lab.model.set('drive.duty', 0.5); lab.compute()"))
    assert chromium.js("[document.getElementById('notice').textContent, lab.other.count > 0]") == ["", True]
    assert chromium.complaints() == []


def test_a_file_is_dropped_and_what_is_copied_runs(shown, tmp_path):
    """A case of the package goes in; the Python that comes out, run by another process, ends where the page does."""
    case = vc.Case(figures_5_to_8("lugre"), {"angle": 0.7}, periods=9)
    text = json.dumps(case.save(tmp_path / "case.toml").read_text())
    drop = """(() => {{ const data = new DataTransfer(); data.items.add(new File([{}], "case.toml"));
      window.dispatchEvent(new DragEvent("drop", {{ dataTransfer: data, cancelable: true }})); }})()"""
    changed(shown, lambda: shown.js(drop.format(text)))
    assert shown.js("[lab.model.form.friction, lab.model.state.periods]") == ["lugre", 9]
    python = shown.js("asPython(lab.model)")
    done = subprocess.run([sys.executable, "-c", python], capture_output=True, text=True, check=True, timeout=120)
    assert list(eval(done.stdout).values()) == pytest.approx(end(shown), rel=1e-9)  # but for fused products
    before = end(shown)
    shown.js(drop.format(json.dumps(case.save(tmp_path / "case.toml").read_text().replace("damping", "dampness", 1))))
    shown.wait("document.getElementById('notice').className === 'bad'")
    assert "machine.dampness: no such key" in shown.js("document.getElementById('notice').textContent")
    assert end(shown) == before
    svg = shown.js("pictureSvg(lab)")
    assert svg.startswith("<svg")
    assert "NaN" not in svg
    rows = shown.js("asCsv(lab.shown)").splitlines()
    assert rows[0].startswith("time,side,angle,angle_rate,position,velocity,bristle,friction")
    assert float(rows[-1].split(",")[4]) == pytest.approx(before[2], abs=1e-9)


def test_a_map_is_computed_and_a_click_shows_the_motion(shown):
    """With the settings of its address, and again in another one."""
    text = "preset=paper-5-8-exponential&machine.stiffness=2.1&run.periods=20&view=map&map.size=32"
    changed(shown, lambda: shown.js(f"location.hash = 'v=1&{text}'"))
    shown.wait("document.body.dataset.map", 120)
    assert shown.js("lab.fields.set.map.cells.size") == 32 * 32
    values = shown.js("[...lab.fields.set.map.cells.values()].filter((c) => c.found.response > 0).length")
    assert values > 700
    assert shown.js("lab.fields.setting('map.x')") == "machine.mass_ratio"
    box = "document.querySelector('#map-bar [name=\"map.x-from\"]')"
    shown.js(f"{box}.value = '200'; {box}.dispatchEvent(new Event('change'))")
    assert shown.js("document.querySelector('#map-bar output').textContent") == "the range should rise"
    shown.js(f"{box}.value = '0.2'; {box}.dispatchEvent(new Event('change'))")
    shown.wait("location.hash.includes('view=map&map.size=32&map.x=machine.mass_ratio%2C0.2%2C100')")
    shown.wait("lab.fields.finished.map === lab.fields.begunFor.map", 60)
    rows = shown.js("lab.fields.csv('map')").splitlines()
    assert rows[0] == "machine.mass_ratio,drive.amplitude,mean_velocity,response_period,status"
    assert len(rows) == 1 + 32 * 32
    assert shown.js("pictureSvg(lab)").count("<rect") > 32 * 32
    x, y, width, height = place(shown, "#map")
    changed(shown, lambda: shown.click(x + 0.1 * width, y - 0.1 * height))
    cell = shown.js("lab.fields.cell")
    wanted = shown.js("lab.fields.set.map.axes.map(({range}, i) => atShare(range, (lab.fields.cell[i] + 0.5) / 32))")
    assert cell is not None
    found = shown.js("['machine.mass_ratio', 'drive.amplitude'].map((path) => lab.model.get(path))")
    assert found == pytest.approx(wanted, rel=1e-12)
    assert shown.js("document.getElementById('map-view').hidden")
    shown.js("lab.model.state.fields['strip.x'] = 'machine.stiffness,1.9,2.1'; lab.mode('strip')")
    shown.wait("lab.fields.finished.strip", 60)
    shown.js("document.getElementById('strip').focus()")
    shown.key("ArrowRight")
    shown.wait("document.getElementById('strip-words').textContent.startsWith('stiffness 2.00')")
    changed(shown, lambda: shown.key("Enter"))
    assert shown.js("lab.model.get('machine.stiffness')") == pytest.approx(1.9 + 0.2 * 121.5 / 240, rel=1e-12)


def test_a_map_in_si_says_its_units(chromium, usual):
    """Its axes, its ranges and its measure; labels of controls speak of no ratios."""
    scales = 0.2, 0.25, 0.16
    words = "preset=paper-5-8-exponential&units=SI&scales=0.2,0.25,0.16&run.periods=20&view=map&map.size=16"
    chromium.open(f"{usual}#v=1&{words}&map.x=drive.frequency,0.8,1.2", 1280, 900)
    chromium.wait("document.body.dataset.map", 120)
    hertz, speed = 1 / (2 * math.pi * scales[2]), scales[1] / scales[2]
    torque = scales[0] * speed**2
    assert chromium.js("lab.fields.shownAs(lab.fields.set.map).labels") == ["frequency [Hz]", "amplitude [N m]"]
    ends = "['from', 'to'].map((end) => Number(document.querySelector(`#map-bar [name='map.x-${end}']`).value))"
    assert chromium.js(ends) == pytest.approx([0.8 * hertz, 1.2 * hertz], rel=1e-5)
    rows = [row.split(",") for row in chromium.js("lab.fields.csv('map')").splitlines()]
    assert rows[0] == [
        "drive.frequency [Hz]", "drive.amplitude [N m]", "mean_velocity [m/s]", "response_period", "status",
    ]  # fmt: skip
    first = chromium.js("lab.fields.set.map.cells.get(0).found.values.mean_velocity")
    low = chromium.js("lab.fields.set.map.axes.map(({ range }) => atShare(range, 0.5 / 16))")
    assert [float(x) for x in rows[1][:3]] == pytest.approx([low[0] * hertz, low[1] * torque, first * speed], rel=1e-12)
    drawn = chromium.js("lab.fields.svg('map')" if chromium.js("lab.fields.svg.length") < 2 else
                        "lab.fields.svg('map', themeOf(document.body))")  # fmt: skip
    assert "frequency [Hz]" in drawn
    assert " m/s<" in drawn
    box = "document.querySelector('#map-bar [name=\"map.x-from\"]')"
    chromium.js(f"{box}.value = '0.9'; {box}.dispatchEvent(new Event('change'))")
    chromium.wait("lab.fields.finished.map === lab.fields.begunFor.map", 60)
    assert chromium.js("lab.fields.set.map.axes[0].range[0]") == pytest.approx(0.9 / hertz, rel=1e-12)
    text = chromium.js("document.querySelector('label[for=\"n-drive-frequency\"]').textContent")
    assert "natural" not in text
    assert text.endswith("[Hz]")
    assert "without units" not in chromium.js("document.getElementById('map-bar').textContent")


@pytest.mark.parametrize(("width", "dark"), [(1280, False), (1280, True), (390, False)])
def test_a_reader_finds_names_and_contrast(chromium, usual, width, dark):
    for mode in ("motion", "map", "strip"):
        chromium.open(
            f"{usual}#v=1&preset=paper-5-8-exponential&beside=lugre&units=SI&scales=0.2,0.25,0.16", width, 800, dark
        )
        chromium.wait(SETTLED)
        chromium.js(f"lab.mode({mode!r})")
        assert chromium.js(READABLE) == []


def test_a_law_of_ones_own_is_in_its_page(chromium, tmp_path):
    """Of the worked parts, outside the package, named on the command line."""
    own = Path(__file__).parents[1] / "examples" / "own_parts" / "friction" / "hyperbolic.py"
    case = tmp_path / "own.toml"
    case.write_text(
        '[machine]\nkind = "pendulum-capsule"\n[friction]\nlaw = "hyperbolic"\n'
        '[drive]\nwaveform = "harmonic"\n[run]\nperiods = 8\n'
    )
    out = tmp_path / "own.html"
    values = ["--parts", str(own), "--laws", "hyperbolic", "--drives", "harmonic", "--out", str(out)]
    assert main(["lab", str(case), *values]) == 0
    chromium.events.clear()
    chromium.open(out.as_uri())
    chromium.wait(SETTLED)
    assert chromium.js("lab.model.form.friction") == "hyperbolic"
    chromium.js("checked(lab)")
    assert chromium.wait("document.body.dataset.check") == "same"
    changed(chromium, lambda: chromium.js("lab.model.set('friction.stribeck_velocity', 0.2); lab.compute()"))
    assert chromium.complaints() == []
