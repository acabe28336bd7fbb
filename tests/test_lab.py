"""The page of `vibrocap lab`, by Node: kernels with the bits of the plain one; files and addresses that read back."""

import base64
import dataclasses
import hashlib
import itertools
import json
import random
import re
import shutil
import subprocess
import tomllib
from pathlib import Path

import numpy as np
import pytest

import vibrocap as vc
from vibrocap.arguments import ArgumentError
from vibrocap.case.case import case_from_text, case_text
from vibrocap.cli.main import main
from vibrocap.lab.bundle import Contents, Preset, bundle, contents, file_preset
from vibrocap.lab.controls import part_record
from vibrocap.lab.forms import form_of
from vibrocap.lab.page import SCRIPTS, WORKER, functions, page, source
from vibrocap.lab.written import Ways, Written, mirrored, rules
from vibrocap.measures.during_run import measure_table
from vibrocap.motion.shapes import moving_shapes
from vibrocap.numerics.linker import plain_kernel
from vibrocap.paper.presets import figures_5_to_8, start
from vibrocap.physics.catalogue import drives, laws, machines
from vibrocap.physics.drives.drive import ROUNDING, Piecewise
from vibrocap.physics.parameters import ParameterError

NODE = shutil.which("node")
needs_node = pytest.mark.skipif(NODE is None, reason="Node, which runs JavaScript, is not installed")
PERIODS = 6.5
EXAMPLES = Path(__file__).resolve().parents[1] / "examples"
# The scripts of the page that need no page, then what a test says; `print` shows JSON.
HEAD = """
const fs = require("node:fs"), zlib = require("node:zlib");
const data = JSON.parse(fs.readFileSync(process.argv[2]));
const opened = ({ code, forms }) => {
  const engine = new Engine(new WebAssembly.Module(zlib.inflateSync(Buffer.from(code, "base64"))));
  return forms.map((record, i) => new Form(record, i, engine));
};
const print = (value) => console.log(JSON.stringify(value));
const forms = () => opened(data);
const limits = { events: 1e4, steps: 1e6, pieces: 1e5 };
const runOf = (model) => model.request();
"""
ALONE = (*WORKER[:2], "charts.js", "model.js", "share.js", "maps.js")


def paper(law, **given):
    system = figures_5_to_8(law)
    return Preset(f"paper-{law}", law, "", vc.Case(system, start(system), periods=PERIODS, **given))


def small_page():
    """The data of a small page: both laws of the paper."""
    presets = paper("exponential"), paper("lugre")
    return bundle(Contents(tuple(preset.case.system for preset in presets), presets))


@pytest.fixture(scope="module")
def data():
    """Those of a page whose motions are not asked for: without its kernels."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("vibrocap.numerics.api.browser_module", lambda forms: b"")
        return small_page()


@pytest.fixture(scope="module")
def node(data, tmp_path_factory):
    return scripts_of(data, tmp_path_factory.mktemp("lab"))


@pytest.fixture(scope="module")
def whole():
    return small_page()


@pytest.fixture(scope="module")
def engine(whole, tmp_path_factory):
    """The same with the kernels of the page."""
    return scripts_of(whole, tmp_path_factory.mktemp("engine"))


def scripts_of(data, folder):
    """Runs lines of JavaScript after the scripts of the page; what they print, read as JSON."""
    (folder / "data.json").write_text(json.dumps(data))

    def run(lines, given=None, forms=None):
        forms = forms or (given if isinstance(given, dict) and "forms" in given else data)["forms"]
        script = folder / "run.cjs"
        script.write_text("\n".join([HEAD, *functions(forms), *map(source, ALONE), lines]))
        (folder / "given.json").write_text(json.dumps(given))
        command = [NODE, str(script), str(folder / "data.json"), str(folder / "given.json")]
        done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=120)
        assert done.returncode == 0, done.stderr
        found = [json.loads(line) for line in done.stdout.splitlines()]
        return found[0] if len(found) == 1 else found

    return run


@needs_node
@pytest.mark.slow
def test_motions_of_the_page_are_those_of_the_plain_kernel(whole, engine):
    """The checked end of each preset to the last bit; and the pieces between, by what is seen of them."""
    found = engine("""
    print(data.presets.map((preset) => {
      const model = new Model(data); model.open(preset.key);
      const request = model.request(), form = forms()[request.form];
      const motion = recordedRun(form, request.parameters, request.initial, request.periods, request.tolerance, limits);
      const dense = new Dense(motion), rows = dense.rows(0, dense.end, 1e5), works = dense.works(0, dense.end);
      return { final: [...motion.final], pieces: dense.count, events: dense.events().length / 2, width: rows.width,
        data: [...rows.data], works: [...works.data.slice(-works.width)], residual: works.residual,
        period: motion.period, names: ["time", "side", ...form.states, ...form.observed] };
    }));
    """)
    for preset, one, chosen in zip(whole["presets"], found, (paper("exponential"), paper("lugre")), strict=True):
        assert one["final"] == preset["check"]["state"]
        assert (one["pieces"], one["events"]) == (preset["check"]["pieces"], preset["check"]["events"])
        motion = chosen.case.simulate()
        rows = np.array(one["data"]).reshape(-1, one["width"])
        borders = np.append(motion.piece_start, motion.end)  # where two pieces have a say
        inside = np.min(np.abs(rows[:, :1] - borders), axis=1) > 1e-6
        for name in ("angle", "velocity", "friction", "energy", "drive_power"):
            wanted = motion.at(rows[inside, 0], name.replace("drive_power", "drive_work"))
            row = rows[inside, one["names"].index(name)]
            if name == "drive_power":
                wanted = motion.at(rows[inside, 0], "drive") * motion.at(rows[inside, 0], "angle_rate")
            # the compiled kernel rounds otherwise: 1e-12 times the growth of errors over a few periods
            assert np.max(np.abs(row - wanted)) < 1e-9 * np.max(np.abs(wanted)), name
        balance = [motion.at(motion.end, f"{channel}_work")[0] for channel in motion.system.channels]
        assert one["works"][1:-1] == pytest.approx(balance, rel=1e-8, abs=1e-9)
        assert one["residual"] < 1e-7


@pytest.mark.slow  # a page of its own
@needs_node
def test_a_sampled_loop_in_the_page_is_that_of_the_plain_kernel(node):
    """1 kHz for 20 periods, 40,000 corners, to the last bit; and another sample time, set in the page."""
    servo = read_servo(sample_time=1e-3, delay=5e-4)
    cases = [vc.Case(servo, {"position": -1.0}, periods=20, tolerance=1e-12)]
    cases.append(dataclasses.replace(cases[0], system=read_servo(sample_time=0.02, delay=0.013), periods=12))
    presets = tuple(Preset(f"servo-{i}", "", "", case) for i, case in enumerate(cases))
    made = bundle(Contents((servo,), presets, tolerance=1e-12))
    found = node(
        f"""
    const made = {json.dumps(made)}, [form] = opened(made), model = new Model(made);
    print(made.presets.map((preset) => {{
      model.open(preset.key);
      const request = model.request(), start = [request.parameters, request.initial];
      const motion = recordedRun(form, ...start, request.periods, request.tolerance, limits);
      const refused = model.complaint("controller.sample_time", 0.03, made.forms[0]);
      const {{ asked }} = made.forms[0].measures.find(({{ name }}) => name === "largest_position");
      const all = [], keep = (_, result, begun) => all.push(measured(form, result, begun, 1e-6).values);
      ensembleRun(form, [{{ parameters: start[0], initial: start[1] }}], {{ ...model.budget(10), asked }}, keep);
      return {{ final: [...motion.final], status: motion.status, refused, values: all[0] }};
    }}));
    """,
        forms=made["forms"],
    )
    for one, preset, case in zip(found, made["presets"], cases, strict=True):
        assert (one["final"], one["status"]) == (preset["check"]["state"], preset["check"]["status"])
        assert one["final"][0] == pytest.approx(case.simulate().state["position"], abs=1e-13)
        assert one["refused"].startswith("should be a whole part of the period 1 of the drive")
        settings = {"initial": case.initial, "periods": case.periods, "settle": 1e-6}
        settings |= {"tolerance": made["forms"][0]["tolerance"], "measures": ["largest_position"], "window": 10}
        wanted = vc.ensemble(case.system, {"controller.proportional_gain": [3.0]}, **settings)["largest_position"][0]
        assert one["values"]["largest_position"] == pytest.approx(wanted, rel=1e-9)
    assert found[0]["final"][0] == pytest.approx(0.08388297959518, abs=2e-14)


def read_servo(**times):
    gains = {"proportional_gain": 3.0, "integral_gain": 4.0, "derivative_gain": 6.0}
    parts = vc.Oscillator(stiffness=0.0), vc.Coulomb(1.0, 1.5), vc.Constant()
    return vc.System(*parts, controller=vc.SampledPositionPID(**gains, **times))


@pytest.mark.slow
@needs_node
def test_a_drive_with_corners_is_that_of_the_plain_kernel(node):
    """No step crosses a corner; its segments follow from the parameters as they are set in the page. With an actuator
    that reaches its limit."""
    lag = vc.Actuator(time_constant=0.3, limit=1.5)
    system = vc.System(vc.PendulumCapsule(), vc.Exponential(), vc.Trapezoid(amplitude=1.7), actuator=lag)
    preset = Preset("corners", "corners", "", vc.Case(system, {"angle": 0.5}, periods=2.5))
    made = bundle(Contents((system,), (preset,)))
    found = node(
        f"""
    const made = {json.dumps(made)}, [form] = opened(made);
    const model = new Model(made), {{ parameters, initial }} = model.request();
    const motion = recordedRun(form, parameters, initial, 2.5, 1e-9, limits), dense = new Dense(motion);
    const rows = dense.rows(0, dense.end, 1e5), at = 2 + form.states.length + form.observed.indexOf("drive");
    const drive = [], all = [], budget = model.budget(200);
    for (let i = 0; i < rows.rows; i++) drive.push([rows.data[i * rows.width], rows.data[i * rows.width + at]]);
    const keep = (_, result, begun) => all.push(measured(form, result, begun, 1e-6));
    ensembleRun(form, [{{ parameters, initial }}], budget, keep);
    print({{ final: [...motion.final], drive, measured: all[0] }});
    """,
        forms=made["forms"],
    )
    assert found["final"] == made["presets"][0]["check"]["state"]
    motion = preset.case.simulate()
    times, drive = np.array(found["drive"]).T
    inside = np.min(np.abs(times[:, None] - np.append(motion.piece_start, motion.end)), axis=1) > 1e-6
    assert np.max(np.abs(drive - motion.at(times, "drive"))[inside]) < 1e-12
    settings = {"initial": {"angle": 0.5}, "periods": 200, "settle": 1e-6, "tolerance": made["forms"][0]["tolerance"]}
    wanted = vc.ensemble(system, {"drive.amplitude": [1.7]}, **settings)
    assert found["measured"]["response"] == wanted["response_period"][0] > 0
    assert found["measured"]["values"]["mean_velocity"] == pytest.approx(wanted["mean_velocity"][0], rel=1e-7, abs=1e-9)


@pytest.mark.slow
@needs_node
def test_a_page_draws_the_shapes_of_a_film(node):
    """Those that a table takes along too, which are farther in each period than in the one before."""
    system = vc.System(vc.DrillString(), vc.Coulomb(), vc.Harmonic(0.3, 0.5))
    case = vc.Case(system, periods=3)
    made = bundle(Contents((system,), (Preset("drill", "drill", "", case),)))
    found = node(
        """
    const made = JSON.parse(fs.readFileSync(process.argv[3])), [form] = opened(made), model = new Model(made);
    const { parameters, initial, tolerance } = model.request();
    const dense = new Dense(recordedRun(form, parameters, initial, 3, tolerance, limits));
    const { data: seen, width, rows } = dense.rows(0, dense.end, 200), drawn = width - dense.coordinates, all = [];
    for (let i = 0; i < rows * width; i += width) all.push([seen[i], ...seen.slice(i + drawn, i + width)]);
    print(all);
    """,
        made,
    )
    times, *coordinates = np.array(found).T
    motion = case.simulate()
    film = [x for shape in moving_shapes(motion, times) for point in shape.points for x in point]
    assert coordinates == pytest.approx(np.array(film), abs=1e-8)


@pytest.mark.slow
@needs_node
def test_a_machine_with_stops_in_a_page(node):
    """What impacts take is a work, so that the balance closes; a start beyond a stop is refused, by the bound that the
    parameters of the page make, not those of the case."""
    system = vc.System(vc.RigidStopCapsule(gap=0.2), vc.Exponential(), vc.Harmonic())
    case = vc.Case(system, periods=2)
    made = bundle(Contents((system,), (Preset("stop", "stop", "", case),)))
    found = node(
        """
    const made = JSON.parse(fs.readFileSync(process.argv[3])), [form] = opened(made), model = new Model(made);
    const { parameters, initial, tolerance } = model.request();
    const dense = new Dense(recordedRun(form, parameters, initial, 2, tolerance, limits));
    const { data: works, width, rows, residual } = dense.works(0, dense.end), taken = [];
    const place = 1 + form.channels.indexOf("impact");
    for (let i = 0; i < rows; i++) taken.push([works[i * width], works[i * width + place]]);
    const tried = (gap, displacement) => {
      model.set("machine.gap", gap);
      model.set("initial.displacement", displacement);
      const { parameters, initial } = model.request();
      try { form.beginning(parameters, initial); return ""; } catch (error) { return error.message; }
    };
    const inner = axesOf(form).includes("initial.touching");
    const half = [model.set("initial.touching", 0.5), usualFields(model)["strip.state"], inner];
    print([taken, residual, half, tried(0.2, 0.2), tried(0.2, 0.25), tried(0.3, 0.25)]);
    """,
        made,
    )
    taken, residual, half, *said = found
    assert half == ["should be a whole number, as it selects the branch of the equations", "displacement", False]
    motion = case.simulate()
    assert residual < 1e-8
    assert taken[-1][1] == pytest.approx(motion.at(motion.end, "impact_work")[0], rel=1e-6)
    assert taken[-1][1] < -0.01
    pairs = itertools.pairwise(taken)
    steps = {time for (time, work), (after, less) in pairs if after - time <= 1e-14 * after and less < work}
    impacts = motion.event_times[motion.event_kinds == "impact"]
    assert sorted(steps) == pytest.approx(impacts, abs=1e-7)  # and there the curve is vertical
    assert said == ["", "initial.displacement: should be at most 0.2, where a stop stands, got 0.25", ""]


def test_a_page_has_every_measure_that_is_a_number(data):
    for form, law in zip(data["forms"], ("exponential", "lugre"), strict=True):
        table = measure_table(paper(law).case.system)
        texts = {"mode_sequence", "outcome"}
        none = {"exponential": texts, "lugre": texts | {"stick_fraction", "stick_phases"}}[law]  # it cannot stick
        assert [each["name"] for each in form["measures"]] == [name for name in table if name not in none]
        assert {"least_reaction", "mean_reaction", "largest_reaction"} < set(table)


@pytest.mark.slow
@needs_node
def test_measures_of_the_page_are_those_of_an_ensemble(whole, engine):
    """Every measure of a settled run, its word and its response, beside `ensemble`; the same tolerance and order."""
    found = engine("""
    const model = new Model(data), form = forms()[0], { parameters, initial } = model.request();
    const place = form.parameters.indexOf("drive.amplitude"), all = [];
    const runs = [1.5, 1.8].map((h) => ({ parameters: parameters.map((x, i) => (i === place ? h : x)), initial }));
    const asked = data.forms[0].measures.reduce((all, each) => all | each.asked, 0) | data.forms[0].ensemble.asked;
    const budget = { ...model.budget(100), threshold: 1e-5, asked };
    ensembleRun(form, runs, budget, (_, result, begun) => all.push(measured(form, result, begun, 1e-5)));
    print(all);
    """)
    system = paper("exponential").case.system
    names = [row["name"] for row in whole["forms"][0]["measures"]]
    wanted = vc.ensemble(
        system,
        {"drive.amplitude": [1.5, 1.8]},
        measures=(*names, "mode_sequence", "symmetric"),
        initial=start(system),
        periods=100,
        settle=1e-5,
        tolerance=whole["forms"][0]["tolerance"],
    )
    for run, one in enumerate(found):
        assert one["response"] == wanted["response_period"][run] > 0
        assert one["windowStart"] == wanted["window_start"][run]
        assert one["mode_sequence"] == wanted["mode_sequence"][run]
        assert one["mirrored"] == bool(wanted["symmetric"][run])
        for name in names:
            # rounding grows over the transient; the measures lie between 1e-2 and 1e2
            assert one["values"][name] == pytest.approx(wanted[name][run], rel=1e-8, abs=1e-9), name


RULES = """
const cases = JSON.parse(fs.readFileSync(process.argv[3]));
print(cases.map(({ form, parts, tried, tables }) => {
  const preset = { key: "", form: 0, values: {}, initial: {}, units: "none" };
  const model = new Model({ presets: [preset], forms: [form], parts });
  return tried.map((given, i) => {
    const values = Object.fromEntries(form.parameters.map((path, i) => [path, given[i]]));
    const wrong = form.parameters.map((path) => [path, model.complaint(path, values[path], form, values)]);
    const drive = tables[i] && { table: Float64Array.from(tables[i]) };
    return [wrong.filter((each) => each[1]), tables[i] && isMirrored(form, { parameters: given, drive })];
  });
}));
"""


def systems():
    """One of every law, machine and drive, and of what else makes rules."""
    capsule, wave = vc.PendulumCapsule(), vc.Harmonic()
    for law in laws().values():
        yield vc.System(capsule, law(), wave)
    for machine in machines().values():
        yield vc.System(machine(), vc.LuGre(), wave)
    for drive in drives().values():
        yield vc.System(capsule, vc.Exponential(), drive())
    back = {"level_3": -1.0, "duration_3": 1.0, "level_4": -0.5, "duration_4": 2.0}
    yield vc.System(capsule, vc.Exponential(), drives()["phases"](level_2=0.5, **back))
    yield vc.System(vc.TwoBodyWorm(), vc.Exponential(), drives()["triangle"]())
    yield vc.System(
        capsule, vc.Exponential(), drives()["table"](times=(0.0, 1.0, 2.5, 3.0), values=(0.0, 1.0, 2.0, 0.0))
    )
    yield vc.System(vc.PendulumCapsuleWithStops(restitution=0.5), vc.Dahl(), wave)
    yield vc.System(vc.RigidStopCapsule(back_gap=0.5), vc.Dahl(), wave)
    yield vc.System(capsule, vc.Exponential(), wave, environment=vc.Environment(inclination=0.1, gravity=1.0))
    yield vc.System(vc.Oscillator(), vc.Exponential(), wave, environment=vc.Environment(quadratic_drag=0.1))


def test_rules_are_the_same_whatever_was_asked_before():
    """Whether a shape jumps is remembered of numbers, not of what stands for one."""
    system = vc.System(vc.TwoBodyWorm(), vc.Exponential(), vc.Square(amplitude=0.0))
    paths = tuple(path for path in system.parameter_paths if type(system.parameter(path)) is float)
    assert system.drive.continuous
    assert "jumps, while the two-body-worm" in rules(system, paths)


def test_what_stands_in_several_expressions_is_written_once():
    """Of a displacement of seven phases the page had 48 megabytes of rules."""
    ways = Ways()
    number = Written(1.5, "p[0]", ways)
    for _ in range(60):
        number = number * number + number
    assert len(ways.whole(number.text)) < 100 * 60
    assert ways.whole("p[0]") == "p[0]"
    for name in ("three-phase", "seven-phase", "trapezoid", "triangle"):
        system = vc.System(vc.TwoMassCrawler(), vc.Coulomb(), drives()[name]())
        assert len(rules(system, tuple(system.parameter_paths))) < 2000


def test_a_place_that_is_free_when_a_page_is_opened_stays_free():
    """Its kernels do not look at it where they ask whether a motion has settled."""
    for stiffness, refused in ((0.0, True), (1.0, False)):
        system = vc.System(vc.Oscillator(stiffness=stiffness), vc.Coulomb(0.1, 0.2), vc.Harmonic())
        paths = tuple(path for path in system.parameter_paths if type(system.parameter(path)) is float)
        place = paths.index("machine.stiffness")
        assert (f'(!((-p[{place}])===0.0))&&["position",`should stay free' in rules(system, paths)) is refused


@needs_node
@pytest.mark.slow
def test_rules_of_the_page_are_those_of_the_parts(node, tmp_path):
    """Refused there is what is refused here, in the same words, whatever the numbers; and alike forward and back."""
    draw, cases, wanted = random.Random(1), [], []
    odd = [-2.0, -1.0, -0.25, 0.0, 0.25, 0.25, 0.5, 0.5, 0.75, 1.0, 1.0, 1.5, 1.6, 1e-3, 1e6, 2e6, 2e300]
    for system in systems():
        values = {path: system.parameter(path) for path in system.parameter_paths}
        paths = tuple(path for path, value in values.items() if type(value) is float)
        parts = {
            name: {part.name: part_record(type(part), system.machine.effort)} for name, part in system.parts.items()
        }
        form = {name: part.name for name, part in system.parts.items()}
        form |= {"parameters": paths, "rules": rules(system, paths), "mirrored": mirrored(system, paths)}
        form |= {"corners": shape_of(system.drive)[0], "number": len(cases)}
        tried, numbers, tables = [], [], []
        for number in range(60):
            given = dict(values)
            for path in draw.sample(paths, min(len(paths), 1 + number % 4)):
                given[path] = draw.choice(odd)
            tried.append([given[path] for path in paths])
            tables.append(None)
            try:
                one = system.with_parameters(given)
                numbers.append(([], one.mirrored))
                tables[-1] = shape_of(one.drive)[1]
            except (ParameterError, ArgumentError) as error:
                numbers.append(([(complaint.field, complaint.text) for complaint in error.complaints], None))
        cases.append({"form": form, "parts": parts, "tried": tried, "tables": tables})
        wanted.append(numbers)
    found = node(RULES, cases, [case["form"] for case in cases])
    refused, answers = 0, []
    for case, one, other in zip(cases, found, wanted, strict=True):
        for given, (shown, twins), (package, mirrors) in zip(case["tried"], one, other, strict=True):
            where = dict(zip(case["form"]["parameters"], given, strict=True))
            assert bool(shown) == bool(package), (where, shown, package)
            refused += bool(package)
            answers += [mirrors] if case["form"]["corners"] else []
            overflows = any(abs(value) > 1e200 for value in given)  # symmetry is decided by numbers of the equations
            assert mirrors in (None, twins) or overflows, where
            words = {numberless(text) for _, text in package}
            words |= {"should be at least 0" for word in words if "finite number >= 0" in word}
            assert not shown or words & {numberless(text) for _, text in shown}, (shown, package)
    assert refused > 600
    assert min(map(answers.count, (True, False))) > 60  # of drives of many pieces


def shape_of(drive):
    """Of a drive of many pieces: its record as a page has it, and the numbers of its pieces."""
    if not isinstance(drive, Piecewise):
        return None, []
    segments, width = drive.segments(), drive.degree + 1
    record = {"segments": len(segments), "coefficients": width, "rounding": ROUNDING, "parts": "1"}
    ends = itertools.accumulate(segment.length for segment in segments)
    padded = [
        [end, *segment.coefficients, *[0.0] * (width - len(segment.coefficients))]
        for end, segment in zip(ends, segments, strict=True)
    ]
    return record, [number for row in padded for number in row]


def numberless(text):
    """Words without what was given, what they are about, and numbers, which are written in another way."""
    words = re.sub(r"^.*?(should|is missing)", r"\1", text.partition(", got ")[0])
    return re.sub(r"-?\d[\d.e+]*", "0", words)


SHARING = """
const model = new Model(data);
model.open("paper-lugre");
model.set("machine.mass_ratio", 3.25); model.set("friction.static_coefficient", 0.1 + 0.2);
model.set("initial.angle", -1e-7);
model.set("run.periods", 12.5); model.state.beside = "exponential";
const other = new Model(data), address = fragmentOf(model);
print({ address, wrong: readFragment(other, address), same: JSON.stringify(model.state) === JSON.stringify(other.state),
  plain: fragmentOf(new Model(data)), toml: asToml(model), python: asPython(model), command: asCommand(model) });
"""


@pytest.mark.slow
@needs_node
def test_what_is_shared_reads_back_the_same(data, node, capsys, tmp_path, monkeypatch):
    """The address in the page; the TOML, the Python and the commands in the package: one and the same motion."""
    found = node(SHARING)
    assert found["wrong"] == []
    assert found["same"]
    assert found["plain"] == "#v=1&preset=paper-exponential"
    wanted = paper("lugre").case.system.with_parameters(
        {"machine.mass_ratio": 3.25, "friction.static_coefficient": 0.1 + 0.2}
    )
    case = case_from_text(found["toml"])
    assert (case.system, case.periods, case.tolerance) == (wanted, 12.5, 1e-9)
    assert case.initial == {"angle": -1e-7, "bristle": 0.0026}
    names = {}
    exec(found["python"], names)
    assert names["motion"] == case.simulate()
    monkeypatch.chdir(tmp_path)
    new, simulate = found["command"].splitlines()
    assert main(new.split()[1:]) == 0
    capsys.readouterr()
    assert main([*simulate.split()[1:], "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["state"] == names["motion"].state


CRAWLER_LAWS = [vc.Coulomb(0.3, 0.45), None, vc.Coulomb(0.1, 0.15)]
CRAWLER = vc.System(vc.ThreeBodyCrawler(), CRAWLER_LAWS, vc.Biharmonic(1.5, 0.8, 0.7, 0.5))


@pytest.mark.slow
@needs_node
@pytest.mark.parametrize(
    ("opened", "path", "value"),
    [
        (lambda: vc.Case(CRAWLER, periods=2), "friction_3.coulomb_coefficient", 0.05),
        (lambda: vc.read_case(EXAMPLES / "clutch-slips-twice.toml", periods=2), "drives.clamp.amplitude", 0.5),
    ],
    ids=["laws of further contacts", "a mechanism"],
)
def test_what_has_sections_of_its_own_is_shared(opened, path, value, node, tmp_path, monkeypatch):
    """The TOML of the page is a case by itself, and the page reads it; the Python has its laws, and a class of it."""
    system = opened().system
    made = bundle(Contents((system,), (Preset("own", "own", "", opened()),)))
    text, python, again = node(
        f"""
    const made = JSON.parse(fs.readFileSync(process.argv[3])), model = new Model(made), other = new Model(made);
    model.set("{path}", {value});
    const text = asToml(model), wrong = readToml(other, text);
    print([text, asPython(model), [wrong, asToml(other) === text]]);
    """,
        made,
    )
    assert again == [[], True]
    shared, names = case_from_text(text), {}
    assert case_text(vc.Case(shared.system)) == case_text(vc.Case(system.with_parameters({path: value})))
    monkeypatch.chdir(tmp_path)
    Path("case.toml").write_text(text, encoding="utf-8")
    exec(python, names)
    assert names["system"] == shared.system
    assert names["motion"] == shared.simulate()


@needs_node
def test_what_is_beside_and_the_settings_of_maps_are_in_the_address(node):
    """Two cases and a view read back; a kept case swapped twice is the same; what is wrong of it is said."""
    found = node("""
    const model = new Model(data), read = (address) => {
      const other = new Model(data), wrong = readFragment(other, address);
      const same = JSON.stringify(other.state) === JSON.stringify(model.state);
      return { wrong, same, again: fragmentOf(other) === address };
    };
    model.set("machine.mass_ratio", 3.25);
    model.state.kept = caseOf(model);
    model.state.beside = "kept";
    model.set("drive.amplitude", 1.5);
    Object.assign(model.state, { view: "map", shown: 10, fields: {
      "map.x": "drive.frequency,0.5,2", "map.y": "initial.angle", "map.measure": "drift", "map.size": "32",
      "map.start": "mirrored", "strip.x": "machine.stiffness", "strip.state": "velocity" } });
    const address = fragmentOf(model), first = read(address), beside = model.requestBeside();
    model.swap();
    const got = model.get("drive.amplitude"), swapped = [model.get("machine.mass_ratio"), got];
    swapped.push(model.keptCase.get("drive.amplitude"));
    model.swap();
    const second = [fragmentOf(model) === address, axisOf(model, model.state.fields["map.x"])];
    const bad = ["view=maps", "map.x=drive.none", "map.y=drive.amplitude,2,1", "map.y=drive.amplitude,1,x",
      "map.size=65", "map.measure=speed", "map.depth=1", "kept=preset%3Dnone", "beside=glue", "beside=kept"];
    print([address, first, beside.parameters[0], model.request().parameters[0], swapped, second,
      bad.map((each) => readFragment(new Model(data), `#v=1&preset=paper-exponential&${each}`).join("; "))]);
    """)
    address, first, beside, present, swapped, second, bad = found
    assert first == {"wrong": [], "same": True, "again": True}
    assert address.startswith("#v=1&preset=paper-exponential&machine.mass_ratio=3.25&drive.amplitude=1.5&shown=10")
    assert "kept=preset%3Dpaper-exponential%26machine.mass_ratio%3D3.25&map.x=" in address
    assert (beside, present, swapped) == (3.25, 3.25, [3.25, 1.8, 1.5])
    assert second == [True, {"path": "drive.frequency", "range": [0.5, 2, True]}]
    words = ["view", "map.x: should be a number of", "the range should rise", "should be numbers", "one of 16, 32"]
    words += ["mean_velocity, stick_fraction", "map.depth", "kept: preset: this page has no none", "beside", ""]
    assert all(word in each and bool(word) == bool(each) for word, each in zip(words, bad, strict=True)), bad


@needs_node
def test_a_case_file_is_read_strictly(data, node):
    text = node("const model = new Model(data); model.open('paper-lugre'); print(asToml(model));")
    assert tomllib.loads(text)["friction"]["law"] == "lugre"
    bad = [
        text.replace("mass_ratio = 2.5", "mass_ratoi = 2.5"),
        text.replace("mass_ratio = 2.5", "mass_ratio = nan"),
        text.replace("mass_ratio = 2.5", "mass_ratio = -2.5"),
        text.replace("static_coefficient = 0.45", "static_coefficient = 0.05"),
        text.replace('"lugre"', '"dahl"'),
        text.replace("[run]", "[runs]"),
        text.replace("periods = 6.5", "periods ="),
        text.replace("stribeck_exponent = 2.0", "stribeck_exponent = 3.0"),
        text + "\n[run]\n",
    ]
    found = node(f"""
    const texts = {json.dumps([text, *bad])};
    print(texts.map((text) => {{
      const model = new Model(data), before = JSON.stringify(model.state), wrong = readToml(model, text);
      return {{ wrong, kept: JSON.stringify(model.state) === before, form: model.form.friction }};
    }}));
    """)
    assert found[0] == {"wrong": [], "kept": False, "form": "lugre"}
    words = [
        "machine.mass_ratoi: no such key",
        "mass_ratio should be a number",
        "machine.mass_ratio: should be greater than 0, got -2.5",
        "friction.static_coefficient: should be at least coulomb_coefficient (0.15), got 0.05",
        "friction.law: this page does not hold dahl",
        "runs: no such section",
        'is no "key = value"',
        "friction.stribeck_exponent: is 2 in this page, got 3",
        "stands twice",
    ]
    for one, word in zip(found[1:], words, strict=True):
        assert one["kept"]
        assert len(one["wrong"]) == 1
        assert word in one["wrong"][0]


@needs_node
def test_an_address_that_is_wrong_is_said_so(node):
    found = node("""
    print(["#v=9&preset=paper-lugre", "#v=1&preset=none", "#v=1&machine.mass_ratio=abc", "#v=1&machine.mass_ratio=0",
      "#v=1&machine.weight=3", "#v=1&friction=dahl",
      "#v=1&friction.coulomb_coefficient=0.6&friction.static_coefficient=0.7",
      "#v=1&shown=-1", "#v=1&machine.mass_ratio=%"].map((hash) => {
      const model = new Model(data); return readFragment(model, hash).join("; "); }));
    """)
    words = ["another version", "this page has no none", "finite number, got abc", "greater than 0, got 0"]
    words += ["there is no such number", "does not hold dahl", "", "should be another value", "got %"]
    for said, word in zip(found, words, strict=True):
        assert word in said
        assert bool(said) == bool(word)


@needs_node
def test_names_that_every_object_has_are_no_names_of_a_page(node):
    """In an address, as a key, a section or a kind of a case file."""
    names = ["constructor", "toString", "__proto__", "hasOwnProperty", "valueOf"]
    lines = r"""
    const told = (read, text) => { const model = new Model(data); return read(model, text).join("; "); };
    const keys = ["NAME=1", "beside.NAME=1", "NAME.NAME=1", "machine.NAME=1", "friction=NAME", "preset=NAME",
      "view=NAME", "kept=NAME%3D1", "units=NAME", "map.NAME=1", "initial.NAME=1", "run.NAME=1", "NAME"];
    const text = asToml(new Model(data));
    print([keys.map((key) => told(readFragment, "#v=1&" + key)),
      [text + "\n[NAME]\nx = 1\n", text.replace("[run]", "[run]\nNAME = 1"), "NAME = 1\n" + text,
       text.replace('"exponential"', '"NAME"')].map((each) => told(readToml, each))]);
    """
    found = node("\n".join(f"{{{lines.replace('NAME', name)}}}" for name in names))
    for name, (addresses, files) in zip(names, found, strict=True):
        for i, told in enumerate(addresses):
            assert name in told or i == 1, (i, told)  # what nothing beside has is left aside
        assert all(name in told for told in files)


SI_CASE = """
[machine]
kind = "pendulum-capsule"
capsule_mass_kg = 0.5
pendulum_mass_kg = 0.2
pendulum_length_m = 0.25
stiffness_N_m_per_rad = 0.98
damping_N_m_s_per_rad = 0.08
normal_load_N = 3.0
[friction]
law = "coulomb"
coulomb_coefficient = 0.05
static_coefficient = 0.15
[drive]
waveform = "harmonic"
amplitude_N_m = 0.7
frequency_Hz = 1.0
[run]
periods = 3
"""


@pytest.mark.slow
@needs_node
def test_a_page_of_a_case_in_si_takes_no_default_in_silence(tmp_path):
    """Another law has the case's levels; what the case does not say is NaN, and no motion is asked for until it is."""
    case = case_from_text(SI_CASE)
    opened = Preset("own", "own", "", case)
    two = dataclasses.replace(case.system, friction=vc.Exponential(), units=None)
    crawl = vc.System(vc.TwoMassCapsule(), vc.Coulomb(), vc.Harmonic())
    shares: list[float] = []
    made = bundle(Contents((case.system, two, crawl), (opened,)), shares.append)
    assert shares == [*(i / 8 for i in range(1, 5)), 1.0]  # half of the work is the code of all forms
    found = scripts_of(made, tmp_path)("""
    const model = new Model(data), before = fragmentOf(model), machine = model.choose("machine", "two-mass-capsule");
    model.choose("friction", "exponential");
    const values = { ...model.state.values }, lacking = model.lacking(), shared = fragmentOf(model);
    let asked = ""; try { model.request(); } catch (error) { asked = error.message; }
    const again = new Model(data), wrong = readFragment(again, shared);
    const set = model.set("friction.decay_rate", 2), now = fragmentOf(model);
    const third = new Model(data); readFragment(third, now);
    model.choose("friction", "coulomb");
    const wide = new Model(data), level = "friction.static_coefficient"; // which goes to 1, unless the case does
    wide.preset = { ...wide.preset, values: { ...wide.preset.values, [level]: 1 } };
    const range = rangeOfPath(wide, level);
    const levels = ["coulomb_coefficient", "static_coefficient"].map((each) => values[`friction.${each}`]);
    print([machine, ...levels, lacking, asked, shared,
      again.lacking(), wrong, set, now, third.state.values["friction.decay_rate"], fragmentOf(model) === before,
      ...range]);
    """)
    needed = "friction.decay_rate: should be given; in SI it has no default"
    shared = "#v=1&preset=own&friction=exponential"
    wanted = [False, 0.05, 0.15, needed, needed, shared, needed, [], "", shared + "&friction.decay_rate=2", 2, True]
    wanted += [0, 1.5, False]  # beyond the value of the case
    assert found == wanted


def test_a_page_has_room_for_a_drive_with_a_long_table():
    """In WebAssembly what is written beyond it would change other numbers in silence."""
    times = np.linspace(0.0, 6.0, 401)
    drive = vc.DriveTable(tuple(times), (0.5, *np.cos(times[1:-1]), 0.5), interpolation="linear")
    kernel = form_of(vc.System(vc.Oscillator(), vc.Coulomb(), drive)).motion
    floats, ints = kernel.layout.allocated()
    with np.errstate(all="ignore"):
        plain_kernel(kernel.text)["begin"](floats, ints, np.zeros(4 * len(times)), 0)


def test_a_page_asks_for_nothing_and_holds_every_script(data):
    text = page(data, title="a <b> & c")
    assert "<title>a &lt;b&gt; &amp; c</title>" in text
    for word in ("http://", "https://", "import(", "fetch(", "XMLHttpRequest", " src="):
        assert word not in text.replace("http://www.w3.org/2000/svg", ""), word
    for name in (*WORKER, *SCRIPTS):
        assert source(name).startswith("// ")


def test_the_policy_of_a_page_allows_its_own_scripts_alone(data):
    text = page(data)
    policy = dict(word.split(" ", 1) for word in re.search(r'Policy" content="([^"]*)"', text)[1].split("; "))
    assert policy["default-src"] == "'none'"
    assert "unsafe-inline" not in str(policy)
    assert "'unsafe-eval'" not in str(policy)
    for tag, name in (("script", "script-src"), ("style", "style-src")):
        (content,) = re.findall(rf"<{tag}>(.*?)</{tag}>", text, re.DOTALL)
        digest = base64.b64encode(hashlib.sha256(content.encode()).digest()).decode()
        assert policy[name].split()[0] == f"'sha256-{digest}'"
    assert {*policy["worker-src"].split(), *policy["img-src"].split()} == {"blob:", "data:"}  # no address at all
    refused = r"<[a-z]+ [^<>{}]*\b(on[a-z]+|style)=\"|new Function|\beval\("
    assert not re.search(refused, text)


def test_the_forms_of_a_page(tmp_path):
    """By default those of the paper; a case brings its own parts; laws by name come in their stead."""

    def parts(chosen):
        return [(form.machine.name, form.friction.name, form.drive.name) for form in chosen.forms]

    usual = parts(contents())
    assert usual[0] == ("pendulum-capsule", "exponential", "harmonic")
    assert {law for _, law, _ in usual} == {"exponential", "lugre", "smoothed-exponential"}
    assert {drive for _, _, drive in usual} == {"harmonic", "biharmonic"}
    own = Preset("own", "own", "", vc.Case(vc.System(vc.Oscillator(), vc.Dahl(), vc.Constant())))
    assert parts(contents(own))[0] == ("oscillator", "dahl", "constant")
    assert {machine for machine, _, _ in parts(contents(own))} == {"oscillator"}  # no other machine, unless asked for
    only = parts(contents(law_names=["coulomb"], drive_names=["harmonic"]))
    assert [law for _, law, _ in only] == ["coulomb", "smoothed-coulomb"]
    assert [preset.parts[0] for preset in contents(machine_names=["oscillator"]).presets] == ["oscillator"]
    keys = [preset.key for preset in contents(file_preset(EXAMPLES / "mirror-twin.toml"), examples=EXAMPLES).presets]
    assert keys[0] == "mirror-twin"
    assert len(keys) == len(set(keys)) > 5  # a case of the gallery stands there once


def test_the_page_opens_where_it_is_asked_to(tmp_path, monkeypatch, capsys):
    opened = []
    monkeypatch.setattr("webbrowser.open", opened.append)
    monkeypatch.setattr("vibrocap.lab.bundle.bundle", lambda *given: None)
    monkeypatch.setattr("vibrocap.lab.page.page", lambda bundled: "a page")
    out = tmp_path / "lab.html"
    assert main(["lab", "--out", str(out)]) == 0
    assert opened == []
    assert main(["lab", "--out", str(out), "--open"]) == 0
    assert opened == [out.as_uri()]


def test_wrong_input_of_the_command_is_refused_by_name(tmp_path, capsys):
    assert main(["lab", "--out", str(tmp_path / "page.txt"), "--laws", "lugra"]) == 2
    said = capsys.readouterr().err
    assert "--out" in said
    assert "--laws" in said
    assert "lugre" in said
    assert main(["lab", str(tmp_path / "none.toml")]) == 2
    long = tmp_path / "long.toml"
    vc.Case(paper("exponential").case.system, periods=2001).save(long)
    assert main(["lab", str(long), "--out", str(tmp_path / "page.html")]) == 2
    assert "run.periods" in capsys.readouterr().err
    assert not (tmp_path / "page.html").exists()
