"""Motions that are moved on from outside: the bits of the literal kernel, inputs that are held, events, copies, ends.

With the case's own drive a stepper is the literal kernel (`recorded_run(..., literal=True)`) to the last bit wherever
it is looked at. Under an input it is compared with `simulate` under the same drive, whose segments are that input.
"""

import contextlib
import ctypes
import itertools
import math
import pickle
import shutil
import subprocess
import threading
from collections import Counter
from pathlib import Path

import numpy as np
import pytest

import vibrocap as vc
from thinned import covering, exhaustive_but, slow_but
from vibrocap.case.case import Case, read_case
from vibrocap.exchange.c_library import c_files, export_c
from vibrocap.exchange.stepped_case import SteppedCase
from vibrocap.motion.crossings import polynomial_values
from vibrocap.motion.recording.equations import equations, parameter_values
from vibrocap.motion.simulate import event_kinds
from vibrocap.numerics.api import Form, MotionStart, recorded_run
from vibrocap.numerics.run.budget import Budget
from vibrocap.physics.catalogue import laws, machines
from vibrocap.physics.drives.drive import segment_table
from vibrocap.physics.names import numbered

pytestmark = pytest.mark.plain

EXAMPLES = Path(__file__).parents[1] / "examples"
GCC = shutil.which("gcc") or ""
needs_gcc = pytest.mark.skipif(not GCC, reason="no gcc is installed")

CAPSULE = vc.PendulumCapsule(mass_ratio=2.5, stiffness=2.0, damping=1.0)
README = vc.System(CAPSULE, vc.Exponential(), vc.Harmonic(amplitude=1.8, frequency=1.0))
START = {"angle": math.pi / 3}
SQUARE = vc.Square(amplitude=1.8, frequency=math.pi / 3)  # of the period 6
TABLE = vc.DriveTable(times=(0.0, 1.0, 2.2, 3.0, 5.0), values=(0.0, 1.5, -0.5, -1.5, 0.0))

# Own drives: laws with branches, memory and stiff steps, several contacts, loads that follow, stops, corners.
OWN = {
    "readme": README,
    "lugre": vc.System(CAPSULE, vc.LuGre(), vc.Harmonic(1.8, 1.0)),
    "corners": vc.System(CAPSULE, vc.Exponential(), vc.Triangle(amplitude=1.8)),
    "cubic": vc.System(CAPSULE, vc.Stribeck(), TABLE),
    "several": vc.System(vc.TwoBodyCrawler(), vc.Coulomb(), vc.Square(amplitude=1.2, frequency=1.3)),
    "dynamic-load": vc.System(
        vc.PendulumCapsule(mass_ratio=4.0, normal_load="dynamic"), vc.Coulomb(), vc.Square(amplitude=1.2)
    ),
    "stops": vc.System(vc.RigidStopCapsule(), vc.Coulomb(), vc.Harmonic(amplitude=1.0)),
    "imposed": vc.System(vc.TwoMassCrawler(), vc.Coulomb(), vc.Trapezoid(amplitude=0.6, frequency=1.3)),
    "walls": vc.System(
        vc.OscillatorWithStops(gap=0.3, back_gap=0.3, restitution=0.6), vc.LuGre(), vc.Square(-1.2, 0.9)
    ),
}
# Under an input: the same, with drives of segments up to the second power.
HELD = {
    "readme": vc.System(CAPSULE, vc.Exponential(), SQUARE),
    "lugre": vc.System(CAPSULE, vc.LuGre(), SQUARE),
    "slopes": vc.System(CAPSULE, vc.Exponential(), vc.Triangle(amplitude=1.8)),
    "several": OWN["several"],
    "dynamic-load": OWN["dynamic-load"],
    "stops": vc.System(vc.RigidStopCapsule(), vc.Coulomb(), vc.Square(amplitude=1.0)),
    "imposed": OWN["imposed"],
    "imposed-curved": vc.System(vc.TwoMassCrawler(), vc.Coulomb(), vc.SevenPhase()),
    "actuator": vc.System(CAPSULE, vc.Exponential(), SQUARE, actuator=vc.Actuator(time_constant=0.3)),
}
FAST = ("readme", "several")
SLOW = ("lugre", "dynamic-load", "stops", "imposed", "actuator", "walls")


def cases(table):
    named = [pytest.param(each, id=name) for name, each in table.items()]
    fast, kept = ([i for i, name in enumerate(table) if name in names] for names in (FAST, (*FAST, *SLOW)))
    return slow_but(fast, exhaustive_but(kept, named))


def literal(system, initial, periods, tolerance):
    state = dict.fromkeys(system.state_names, 0.0) | initial
    values = equations(system), parameter_values(system), [*state.values()], system.drive.period
    return recorded_run(MotionStart(*values), Budget(periods, tolerance, 10_000, 10**7), Form(literal=True))


def initial_of(system):
    return START if "angle" in system.state_names else {}


@pytest.mark.slow
@pytest.mark.parametrize("system", cases(OWN))
def test_own_drives_have_the_bits_of_the_literal_kernel_wherever_one_looks(system):
    periods, tolerance, initial = 5, 1e-10, initial_of(system)
    record, period = literal(system, initial, periods, tolerance), system.drive.period
    assert record.status == 1
    begun = record.piece_instants[:, 0] * period + record.piece_instants[:, 1]
    instants = np.linspace(0.0, periods * period, 311)[1:-1]
    index = np.searchsorted(begun, instants, side="right") - 1
    wanted = polynomial_values(record.series, index, instants - begun[index]).T
    motion = vc.stepper(system, initial=initial, tolerance=tolerance)
    happened = record.event_instants[:, 0] * period + record.event_instants[:, 1]
    kinds = event_kinds(system.placed.switch_events)[record.event_kinds]
    named = [numbered(str(kind), max(1, int(c))) for kind, c in zip(kinds, record.event_contacts, strict=True)]
    assert named
    states, sides = [], []
    for instant, before in zip(instants, [0.0, *instants], strict=False):
        motion.step(instant - before)
        assert motion.time == instant
        states.append(motion.states)
        sides.append(motion.sides)
        until = happened <= instant
        counts = Counter(name for name, is_past in zip(named, until, strict=True) if is_past)
        assert {name: count for name, count in motion.events.items() if count} == counts
        assert (motion.last_event.time if counts else None) == (happened[until][-1] if counts else None)
    np.testing.assert_array_equal(states, wanted)
    np.testing.assert_array_equal(sides, record.piece_sides[index])


@pytest.mark.parametrize("system", cases(OWN))
def test_what_is_shown_at_the_start_is_decided(system):
    """Sides and friction before the first step, of contacts that start at rest too."""
    for initial in ({}, initial_of(system)):
        begun, first = vc.stepper(system, initial=initial), vc.simulate(system, periods=1e-3, initial=initial)
        assert begun.sides == tuple(first.piece_sides[0])
        assert begun.time == 0.0
        assert not any(begun.events.values())
        for name in ("friction", "friction_2")[: len(begun.sides)]:
            assert begun[name] == pytest.approx(first.at(0.0, name)[0], rel=1e-9, abs=1e-12), name


def follow(motion, drive, periods, parts=1, to_events=False):
    """Move a stepper on under what a drive of segments is, each in so many parts."""
    period = drive.period
    for _ in range(periods):
        start = 0.0
        for end, *coefficients in segment_table(drive):
            c = [drive.size() * coefficient / period**k for k, coefficient in enumerate(coefficients)] + [0.0, 0.0]
            length = (end - start) * period / parts
            for j in range(parts):
                gone, begun = 0.0, motion.time
                while length - gone > 1e-12:
                    t = j * length + gone
                    values = c[0] + c[1] * t + c[2] * t * t, length - gone, c[1] + 2.0 * c[2] * t, 2.0 * c[2]
                    if not (to_events and motion.step_to_event(*values)):
                        if not to_events:
                            motion.step(*values)
                        break
                    gone = motion.time - begun
            start = end


@pytest.mark.slow
@pytest.mark.parametrize("system", cases(HELD))
def test_a_held_input_is_the_drive_whose_segments_it_is(system):
    """Steps end where those of `simulate` do, so that rounding alone differs; in parts, the tolerance per step does."""
    initial, periods = initial_of(system), 5
    reference = vc.simulate(system, periods=periods, initial=initial, tolerance=1e-10)
    assert reference.status.ok
    size = 1.0 + max(map(abs, reference.state.values()))
    before = [event for event in reference.events if event.time < reference.end]  # at the end the drive jumps on
    counts = Counter(event.kind for event in before if not event.kind.startswith("graze"))
    for parts, to_events, bound in ((1, False, 1e-11), (1, True, 1e-9), (5, False, 1e-8), (5, True, 1e-8)):
        motion = vc.stepper(system, input="drive", initial=initial, tolerance=1e-10)
        follow(motion, system.drive, periods, parts, to_events)
        assert motion.time == pytest.approx(reference.end, rel=1e-14)
        assert np.abs(motion.states - [*reference.state.values()]).max() <= bound * size
        table = {name: count for name, count in motion.events.items() if count and not name.startswith("graze")}
        assert table == counts  # whether a velocity touches zero is a matter of rounding


@pytest.mark.parametrize("system", cases({name: HELD[name] for name in ("readme", "lugre", "several", "dynamic-load")}))
def test_what_is_seen_under_an_input_is_what_a_motion_is_asked_for(system):
    drive, initial = system.drive, initial_of(system)
    reference = vc.simulate(system, periods=3, initial=initial, tolerance=1e-10)
    motion = vc.stepper(system, input="drive", initial=initial, tolerance=1e-10)
    for k in range(30):
        motion.step(drive.amplitude if k % 10 < 5 else -drive.amplitude, drive.period / 10.0)
        if k % 5 < 4:  # not at its corners, where the drive of a motion has jumped already
            for name in motion.stepped.kernel.observed:
                wanted = reference.at(motion.time, name)[0]
                assert motion[name] == pytest.approx(wanted, rel=1e-8, abs=1e-8), name


def pairs():
    """Every law and every machine, and each kind of law on machines of each kind: imposed, of several contacts."""
    table = [*itertools.product(laws(), machines())]
    bodies = {name: machine() for name, machine in machines().items()}
    kinds = {name: (body.imposes_motion, len(body.contact_states) > 1) for name, body in bodies.items()}
    return [
        table[i]
        for i in covering(
            [(law, name, laws()[law].kind, kinds[name], (laws()[law].kind, kinds[name])) for law, name in table]
        )
    ]


PAIRS = [pytest.param(*pair, id="-".join(pair), marks=pytest.mark.slow) for pair in pairs()]


@pytest.mark.parametrize(("law", "machine"), exhaustive_but(range(0, len(PAIRS), 12), PAIRS))
def test_every_law_on_every_machine_takes_an_input(law, machine):
    """States, or when and why a motion cannot go on.

    How often a kinked law turns at rest, and which branch it is on there, is a matter of rounding.
    """
    body = machines()[machine]()
    imposed = body.imposes_motion
    drive = vc.Trapezoid(amplitude=0.6, frequency=1.3) if imposed else vc.Square(amplitude=1.2, frequency=1.3)
    system = vc.System(body, laws()[law](), drive)
    reference = vc.simulate(system, periods=3, tolerance=1e-9)
    for parts, to_events in ((1, True), (4, False)):
        motion = vc.stepper(system, input="drive", tolerance=1e-9)
        with contextlib.suppress(vc.MotionEnded):
            follow(motion, drive, 3, parts, to_events)
        assert (motion.status or vc.Status.FINISHED) is reference.status
        assert motion.time == pytest.approx(reference.end, abs=1e-7)
        plain = [name for name in system.state_names if name not in system.switched]
        np.testing.assert_allclose(
            [motion[name] for name in plain], [reference.state[name] for name in plain], atol=1e-6
        )


def test_events_end_a_step_where_they_are():
    reference = vc.simulate(README, periods=5, initial=START, tolerance=1e-10)
    motion, times = vc.stepper(README, initial=START, tolerance=1e-10), []
    while motion.time < 25.0:
        if motion.step_to_event(25.0 - motion.time + 1.0):
            times.append(motion.time)
            event = motion.last_event
            assert event.time == motion.time
            assert motion["contact_velocity"] == 0.0
            wanted = {"stick": 0, "slip_forward": 1, "slip_back": -1}.get(event.kind, motion.sides[0])
            assert motion.sides == (wanted,)
    wanted = [event.time for event in reference.events if event.time <= times[-1]]
    np.testing.assert_allclose(times, wanted, atol=1e-8)


@pytest.mark.plain(False)
def test_the_roundings_of_many_lengths_do_not_add_up():
    """A sum of a thousand tenths, each rounded, is off by 1e-12."""
    motion = vc.stepper(README, input="drive")
    for _ in range(1000):
        motion.step(0.0, 0.1)
    assert motion.time == math.fsum([0.1] * 1000)


def test_a_jump_of_the_input_asks_a_contact_at_rest_again():
    motion = vc.stepper(README, input="drive")
    assert not motion.step_to_event(0.0, 1.0)
    assert motion.sides == (0,)
    assert motion.step_to_event(5.0, 1.0)  # more than the static level holds
    assert (motion.time, motion.last_event.time) == (1.0, 1.0)
    assert motion.sides != (0,)
    assert not motion.step_to_event(5.0, 1e-3)  # that event is over
    assert motion.time == 1.001


@pytest.mark.parametrize("law", [vc.RateAndStateAgeing(), vc.LuGre()], ids=["rate-and-state", "lugre"])
def test_what_rests_for_good_is_asked_again_until_the_input_moves_it(law):
    """A contact with a force for every velocity rests with all its derivatives zero."""
    system = vc.System(vc.Oscillator(), law, vc.Constant(0.0))
    motion = vc.stepper(system, input="drive")
    for _ in range(3):
        motion.step(0.0, 0.1)
    rest = dict(zip(system.state_names, motion.states, strict=True))
    assert (rest["position"], rest["sliding_velocity"]) == (0.0, 0.0)
    motion.step(2.0, 0.3)
    moved = vc.simulate(vc.System(vc.Oscillator(), law, vc.Constant(2.0)), periods=0.3, initial=rest)
    np.testing.assert_allclose(motion.states, [*moved.state.values()], rtol=1e-9)


# --- keeping ----------------------------------------------------------------------------------------------------------


def wild(count=300):
    return np.random.default_rng(1).uniform(-1.8, 1.8, count).tolist()


def driven(motion, inputs):
    values = []
    for value in inputs:
        motion.step(value, 0.2)
        values.append(motion.values)
    return np.array(values)


@pytest.mark.plain(False)
def test_copies_restored_pickled_and_threaded_motions_have_equal_bits():
    motion, first, second = vc.stepper(README, input="drive", initial=START), wild(100), wild()
    driven(motion, first)
    kept, sent = motion.copy(), pickle.loads(pickle.dumps(motion))
    wanted = driven(motion, second)
    other = vc.stepper(README, input="drive", initial=START)  # a second instance, side by side with the others
    driven(other, first)
    for each in (kept.copy(), sent, other):
        np.testing.assert_array_equal(driven(each, second), wanted)
    motion.restore(kept)
    np.testing.assert_array_equal(driven(motion, second), wanted)
    table = {}
    motions = [kept.copy() for _ in range(4)]
    threads = [
        threading.Thread(target=lambda i=i: table.update({i: driven(motions[i], second)})) for i in range(len(motions))
    ]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    for i in range(len(motions)):
        np.testing.assert_array_equal(table[i], wanted)


@pytest.mark.slow
def test_looking_changes_nothing():
    system = vc.System(CAPSULE, vc.LuGre(), vc.Triangle(amplitude=1.8))
    one, other = (vc.stepper(system, initial=START) for _ in range(2))
    for _ in range(200):
        one.step(0.05)
        one.look()
    other.step(10.0 - 1.0)
    other.step(one.time - other.time)
    np.testing.assert_array_equal(one.values, other.values)
    assert one.events == other.events


@pytest.mark.plain(False)
def test_plain_python_is_the_compiled_stepper():
    stepped = SteppedCase(Case(README, START), "drive")
    kernel, places = stepped.kernel, stepped.kernel.places
    values = []
    for plain in (False, True):
        memory = stepped.memory()
        begin, take, look = (kernel.entry(n, memory, plain) for n in ("begin_motion", "take_step", "look_at"))
        begin(0)
        for value in (1.8, -1.8, 1.0):
            memory.floats[places["INPUT"]], memory.ints[places["NEW_INPUT"]] = value, 1
            memory.floats[places["LENGTH"]] = 1.5
            take(0)
        look(0)
        values.append((memory.trace[: kernel.layout.shown].copy(), memory.ints.copy()))
    np.testing.assert_array_equal(values[0][0], values[1][0])
    np.testing.assert_array_equal(values[0][1], values[1][1])


def test_many_motions_are_each_what_it_is_alone():
    angles, ratios = np.linspace(-1.0, 1.0, 5), np.linspace(1.0, 3.0, 5)
    settings = {"input": "drive", "tolerance": 1e-8}
    many = vc.stepper(README, **settings, count=5, initial={"angle": angles}, parameters={"machine.mass_ratio": ratios})
    alone = [
        vc.stepper(README, **settings, initial={"angle": angle}, parameters={"machine.mass_ratio": float(ratio)})
        for angle, ratio in zip(angles.tolist(), ratios, strict=True)
    ]
    inputs = np.random.default_rng(2).uniform(-1.8, 1.8, (60, 5))
    for k, row in enumerate(inputs):
        if k == 30:
            kept = many.copy()
        many.step(row, 0.2)
        for motion, value in zip(alone, row.tolist(), strict=True):
            motion.step(value, 0.2)
    np.testing.assert_array_equal(many.values, [motion.values for motion in alone])
    np.testing.assert_array_equal(many.sides, [motion.sides for motion in alone])
    many.restore(kept)
    again = pickle.loads(pickle.dumps(many))
    for row in inputs[30:]:
        many.step(row, 0.2)
        again.step(row, 0.2)
    np.testing.assert_array_equal(many.values, [motion.values for motion in alone])
    np.testing.assert_array_equal(again.values, many.values)
    assert not many.ended.any()


def test_many_motions_take_slopes_and_stop_at_their_own_events():
    """A machine whose inner motion is imposed feels nothing but slope and curvature."""
    system = OWN["imposed"]
    many = vc.stepper(system, input="drive", count=3)
    alone = [vc.stepper(system, input="drive") for _ in range(3)]
    for k in range(40):
        slopes, curvatures = np.array([0.5, 1.0, -1.5]) * (-1) ** k, [0.0, 0.2, -0.4]
        values = 0.0, 0.4, slopes, curvatures
        numbers = [(0.0, 0.4, *pair) for pair in zip(slopes.tolist(), curvatures, strict=True)]
        if k % 2:
            stopped = [motion.step_to_event(*one) for motion, one in zip(alone, numbers, strict=True)]
            assert many.step_to_event(*values).tolist() == stopped
        else:
            many.step(*values)
            for motion, one in zip(alone, numbers, strict=True):
                motion.step(*one)
    np.testing.assert_array_equal(many.values, [motion.values for motion in alone])
    assert np.ptp(many.values[:, 0]) > 0.01
    for name, counts in many.events.items():
        assert counts.tolist() == [motion.events[name] for motion in alone]
    assert sum(many.events["stick"]) > 3
    with pytest.raises(ValueError, match="slope should be finite"):
        many.step(0.0, 0.1, math.nan)


# --- ends and bad input -----------------------------------------------------------------------------------------------

LIGHT = vc.System(
    vc.PendulumCapsule(mass_ratio=0.3, normal_load="dynamic"), vc.Coulomb(), vc.Square(amplitude=3.0, frequency=0.5)
)


@pytest.mark.slow
def test_lift_off_within_a_step_is_told_with_its_time():
    reference = vc.simulate(LIGHT, periods=3, tolerance=1e-10)
    assert reference.status is vc.Status.LIFT_OFF
    assert reference.end < 0.5 * LIGHT.drive.period
    motion = vc.stepper(LIGHT, input="drive", tolerance=1e-10)
    with pytest.raises(vc.MotionEnded, match="lift off") as caught:
        motion.step(3.0, 100.0)
    assert caught.value.status is motion.status is motion.look().status is vc.Status.LIFT_OFF
    assert caught.value.time == motion.time == pytest.approx(reference.end, abs=1e-9)
    np.testing.assert_allclose(motion.states, [*reference.state.values()], atol=1e-8)
    with pytest.raises(vc.MotionEnded):
        motion.step(0.0, 1.0)
    assert motion.time == caught.value.time
    assert "lift off" in str(vc.MotionEnded(2.0, vc.Status.LIFT_OFF, "s"))
    assert "t = 2 s: " in str(vc.MotionEnded(2.0, vc.Status.LIFT_OFF, "s"))
    again = pickle.loads(pickle.dumps(caught.value))
    assert (again.time, again.status) == (caught.value.time, caught.value.status)
    many = vc.stepper(LIGHT, input="drive", tolerance=1e-10, count=2)
    many.step([0.0, 3.0], 100.0)
    assert many.ended.tolist() == [False, True]
    assert many.statuses == [None, vc.Status.LIFT_OFF]
    assert many.time.tolist() == [100.0, motion.time]


@pytest.mark.parametrize(
    ("call", "said"),
    [
        (lambda motion: motion.step(math.nan, 0.1), "value should be a finite number, got nan"),
        (lambda motion: motion.step(1.0, 0.1, math.inf), "slope should be a finite number, got inf"),
        (lambda motion: motion.step(1.0, 0.0), "length should be a finite length of time > 0, got 0"),
        (lambda motion: motion.step(1.0, -0.1), "length should be .* got -0.1"),
        (lambda motion: motion.step_to_event(1.0, math.inf), "length should be .* got inf"),
        (lambda motion: motion.step(1.0, math.nan), "length should be .* got nan"),
        (lambda motion: motion.step(1.0, "long"), "length should be .* got 'long'"),
        (lambda motion: motion.step(1.0, np.ones(2)), "length should be .* got array"),
        (lambda motion: motion.step("much", 0.1), "value should be a finite number, got 'much'"),
        (lambda motion: motion.step(np.ones(2), 0.1), "value should be a finite number, got array"),
        (lambda motion: motion["fricton"], "did you mean 'friction'"),
        (lambda motion: motion.restore(vc.stepper(README)), "kept should be a copy"),
    ],
)
def test_bad_steps_are_named_and_do_nothing(call, said):
    motion = vc.stepper(README, input="drive", initial=START)
    motion.step(1.0, 0.3)
    before = motion.look()
    with pytest.raises((ValueError, KeyError), match=said):
        call(motion)
    assert motion.look() == before


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"input": "torque"}, "input should be 'drive' or None, got 'torque'"),
        ({"initial": {"angel": 1.0}}, "initial.angel.*did you mean 'angle'"),
        ({"initial": {"angle": np.zeros(3)}}, "initial.angle should be a finite number, got array"),
        ({"tolerance": 1.0}, "tolerance should be a number from"),
        ({"parameters": {"machine.mass": 1.0}}, "machine.mass.*no such parameter.*machine.mass_ratio"),
        ({"parameters": {"machine.mass_ratio": -1.0}}, "mass_ratio.*greater than 0"),
        ({"count": 0}, "count should be a whole number"),
        ({"count": 3, "initial": {"angle": np.zeros(2)}}, "angle should be a number or 3 of them"),
        ({"count": 2, "initial": {"angel": np.zeros(2)}}, "angel: no such state or parameter"),
        (
            {"count": 2, "parameters": {"machine.mass_ratio": np.array([1.0, -1.0])}},
            "machine.mass_ratio should be from",
        ),
    ],
)
def test_bad_cases_are_named(given, said):
    with pytest.raises(ValueError, match=said):
        vc.stepper(README, **given)


def test_what_is_no_case_is_refused():
    with pytest.raises(ValueError, match="case should be a case or a system"):
        vc.stepper("case.toml")
    many = vc.stepper(README, input="drive", count=2)
    with pytest.raises(ValueError, match="value should be finite"):
        many.step([1.0, math.nan], 0.1)
    with pytest.raises(ValueError, match="length should be a finite length"):
        many.step(1.0, [0.1, -0.1])
    with pytest.raises(TypeError, match="step takes value and length"):
        many.step(0.1)


# --- in C -------------------------------------------------------------------------------------------------------------


class Library:
    """A library in C, built and called by `ctypes`."""

    def __init__(self, folder, case, input=None):
        export_c(case, folder, input=input)
        (folder / "size.c").write_text(
            '#include "capsule.h"\nsize_t capsule_size(void) { return sizeof(capsule); }\n'
            "double capsule_value(const double *seen, int i) { return seen[i]; }\n"
        )
        command = [GCC, "-std=c99", "-O1", "-fPIC", "-shared", "-Wall", "-Wextra", "-Werror"]
        out = folder / "capsule.so"
        subprocess.run([*command, "-o", out, folder / "capsule.c", folder / "size.c", "-lm"], check=True)
        self.call = ctypes.CDLL(str(out))
        for name, result, *arguments in (
            ("size", ctypes.c_size_t),
            ("look", ctypes.POINTER(ctypes.c_double), ctypes.c_void_p),
            ("time", ctypes.c_double, ctypes.c_void_p),
            ("status_text", ctypes.c_char_p, ctypes.c_int),
            ("set_parameter", ctypes.c_int, ctypes.c_void_p, ctypes.c_int, ctypes.c_double),
            ("set_initial", ctypes.c_int, ctypes.c_void_p, ctypes.c_int, ctypes.c_double),
            ("set_tolerance", ctypes.c_int, ctypes.c_void_p, ctypes.c_double),
            ("step", ctypes.c_int, ctypes.c_void_p, ctypes.c_double),
            ("step_to_event", ctypes.c_int, ctypes.c_void_p, ctypes.c_double),
            ("save", None, ctypes.c_void_p, ctypes.c_void_p),
            ("load", ctypes.c_int, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_size_t),
            ("event_count", ctypes.c_int64, ctypes.c_void_p, ctypes.c_int, ctypes.c_int),
        ):
            function = getattr(self.call, f"capsule_{name}")
            function.restype, function.argtypes = result, arguments
        if input:
            self.call.capsule_set_input.argtypes = [ctypes.c_void_p, *[ctypes.c_double] * 3]
        self.count = len(case.system.state_names) + len(SteppedCase(case, input).observables)

    def __getattr__(self, name):
        return getattr(self.call, f"capsule_{name}")

    def motion(self):
        buffer = ctypes.create_string_buffer(self.size())
        self.call.capsule_case(buffer)
        return buffer

    def values(self, motion):
        return np.array(self.look(motion)[: self.count])

    def driven(self, motion, inputs):
        values = []
        for value in inputs:
            assert self.set_input(motion, value, 0.0, 0.0) == 1
            assert self.step(motion, 0.2) == 0
            values.append(self.values(motion))
        return np.array(values)


@pytest.mark.plain(False)
@needs_gcc
def test_the_library_has_the_bits_of_the_stepper_and_keeps_motions(tmp_path):
    library = Library(tmp_path, Case(README, START), "drive")
    motion, first, second = library.motion(), wild(100), wild()
    assert library.step(motion, 0.2) == 2  # it has not begun
    assert library.begin(motion) == 0
    assert library.begin(motion) == 2
    reference = vc.stepper(README, input="drive", initial=START)
    np.testing.assert_array_equal(library.driven(motion, first), driven(reference, first))
    size = library.size() + 8
    saved = ctypes.create_string_buffer(size)
    library.save(motion, saved)
    copied = ctypes.create_string_buffer(motion.raw, library.size())
    wanted = driven(reference, second)
    np.testing.assert_array_equal(library.driven(motion, second), wanted)
    loaded = library.motion()
    assert library.load(loaded, saved, size) == 1
    np.testing.assert_array_equal(library.driven(loaded, second), wanted)
    np.testing.assert_array_equal(library.driven(copied, second), wanted)
    assert library.load(loaded, saved, size - 1) == 0
    saved[0] = bytes([saved.raw[0] ^ 1])
    assert library.load(loaded, saved, size) == 0
    states = [reference.events[kind] for kind in ("stick", "slip_forward", "slip_back", "reversal")]
    assert [library.event_count(motion, kind, 1) for kind in range(4)] == states
    for wrong in (0.0, -1.0, math.nan, math.inf):
        assert library.step(motion, wrong) == 2
    assert library.set_input(motion, math.nan, 0.0, 0.0) == 0
    assert library.set_parameter(motion, 0, 1.0) == 0  # it has begun
    v, w, c = 0.2, 0.9, -0.4  # an input that was set goes on from step to step
    library.set_input(motion, v, w, c)
    for k in range(5):
        assert library.step(motion, 0.3) == 0
        t = 0.3 * k
        reference.step(v + w * t + 0.5 * c * t * t, 0.3, w + c * t, c)
        wanted[-1] = reference.values
        np.testing.assert_allclose(library.values(motion), wanted[-1], atol=1e-12)
    wanted[-1] = library.values(motion)
    library.step(motion, -1.0)
    np.testing.assert_array_equal(library.values(motion), wanted[-1])


def test_quantities_cross_the_border_with_their_units():
    case = read_case(EXAMPLES / "bench-in-si.toml")
    stepped, si = SteppedCase(case, "drive"), case.system.si
    assert stepped.time.unit == "s"
    assert stepped.time.scale == si.factor("time")
    for port in (*stepped.states, *stepped.observables):
        assert (port.unit, port.scale) == (si.unit(port.name), si.factor(port.name))
    value, slope, _ = stepped.inputs
    assert (value.unit, slope.unit) == (si.unit("drive"), si.unit("drive") + ("/s" if "/" not in value.unit else " s"))
    assert slope.scale == value.scale / stepped.time.scale
    for port in SteppedCase(case).parameters:
        known = [path for path in (port.name,) if path in case.system.parameter_paths]
        assert known
        assert port.value == case.system.parameter(port.name)
        assert port.least <= port.value <= port.most
    text = c_files(case, input="drive")["capsule.c"]
    assert f'"{stepped.time.unit}", {stepped.time.scale.hex()}' in text


@pytest.mark.slow
def test_a_case_in_si_is_stepped_in_si():
    case = read_case(EXAMPLES / "bench-in-si.toml")
    si, state = case.system.si, {"angle": 0.4, "velocity": 0.2}
    motion = vc.stepper(case, input="drive", initial=state)
    plain = vc.stepper(
        case.system.dimensionless, input="drive", initial={"angle": 0.4, "velocity": 0.2 / si.factor("velocity")}
    )
    assert [motion.unit_of(name) for name in ("time", "position", "friction", "drive")] == ["s", "m", "N", "N m"]
    assert motion.unit_of("drive_slope") == "N m/s"
    assert {motion.dimensionless.unit_of(name) for name in ("time", "position", "drive")} == {"1"}
    for k in range(200):
        torque, slope = 0.9 * math.cos(0.3 * k), 0.4
        motion.step(torque, 0.05, slope)
        values = torque / si.factor("drive"), 0.05 / si.factor("time"), slope / si.factor("drive") * si.factor("time")
        plain.step(*values)
    scales = [si.factor(name) for name in motion.names]
    np.testing.assert_allclose(motion.values, plain.values * scales, rtol=1e-8, atol=1e-12)
    assert motion.time == pytest.approx(10.0, rel=1e-14)
    assert motion.events == plain.events
    assert motion.last_event.time == pytest.approx(plain.last_event.time * si.factor("time"), rel=1e-10)
    for again in (motion.copy(), pickle.loads(pickle.dumps(motion))):
        assert again.values.tolist() == motion.values.tolist()
        assert again.time == motion.time
    np.testing.assert_allclose(motion.dimensionless.states, motion.states / scales[:4], rtol=1e-15)
    motion.dimensionless.step(0.0, 1.0)  # the same motion
    assert motion.time == pytest.approx(10.0 + si.factor("time"), rel=1e-14)
    own = vc.stepper(case)
    own.step(2.5)
    assert own["position"] == pytest.approx(case.simulate().at(2.5, "position")[0], rel=1e-9)
