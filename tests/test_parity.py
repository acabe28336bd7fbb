"""One source, however it runs: plain Python = compiled, a lane among others = the same run alone, an edit is seen."""

import hashlib
import math

import numpy as np
import pytest

import vibrocap as vc
import vibrocap.motion.recording.equations as recordings
from plain_kernels import PlainKernel, kernel_of, set_lane
from vibrocap.motion.recording.equations import equations, parameter_values
from vibrocap.numerics.kernel.codes import DONE, RUNNING
from vibrocap.numerics.kernel.events.transitions import ARRIVED
from vibrocap.numerics.run.budget import Budget
from vibrocap.numerics.run.motion import kernel, recorded_run

LAWS = {"exponential": vc.Exponential(), "lugre": vc.LuGre(), "stiff lugre": vc.LuGre(bristle_stiffness=1e4)}


def system_with(law, mass_ratio=2.5, amplitude=1.8):
    return vc.System(vc.PendulumCapsule(mass_ratio=mass_ratio), law, vc.Harmonic(amplitude=amplitude))


def start_of(system, angle=math.pi / 3):
    return [angle, *[0.0] * (len(system.state_names) - 1)]


def run(system, periods, plain, tolerance=1e-9):
    return recorded_run(
        equations(system),
        parameter_values(system),
        start_of(system),
        system.drive.period,
        Budget(periods, tolerance, 10_000, 10**6),
        plain=plain,
    )


@pytest.mark.parametrize("law", LAWS)
def test_plain_python_is_the_compiled_kernel(law):
    """The same steps and events; numbers differ by fused multiply-adds and the compiler's sin, cos and exp.

    That is an ulp per operation, some 1e-13 in a state after half a period, and more where a step's length follows from
    the logarithm of a coefficient that nearly cancels: the tolerance of the run bounds it.
    """
    system = system_with(LAWS[law])
    periods = 0.6
    plain, compiled = run(system, periods, plain=True), run(system, periods, plain=False)
    assert plain.status == compiled.status == DONE
    assert np.array_equal(plain.events[:, 2], compiled.events[:, 2])
    assert plain.events[:, 1] == pytest.approx(compiled.events[:, 1], rel=1e-9)
    assert (plain.taylor_steps, plain.implicit_steps) == (compiled.taylor_steps, compiled.implicit_steps)
    assert plain.taylor_steps > 5
    if law == "stiff lugre":
        assert plain.implicit_steps > 0
    first_plain, first_compiled = plain.pieces[:3], compiled.pieces[:3]
    size = np.abs(first_plain).max(axis=0) + 1.0
    assert np.all(np.abs(first_plain - first_compiled) <= 1e-12 * size)
    assert final(plain) == pytest.approx(final(compiled), abs=1e-10)


def final(recorded):
    """State at the end of the last piece, which both runs put at the same time."""
    return np.polynomial.polynomial.polyval(recorded.piece_lengths[-1], recorded.series[-1:][0].T)


# --- lanes -----------------------------------------------------------------------------------------------------------

PERIODS = 1
EVENT_ROOM, PIECE_ROOM = 100, 1_500


def run_lanes(kernel: PlainKernel, systems, starts, event_limits=None):
    """Every lane runs a period of its own system, each with its own region of the trace: (statuses, regions)."""
    layout, rows = kernel.layout, kernel.layout.states
    marks = (PERIODS + 1) * rows
    region = EVENT_ROOM * layout.event_size + PIECE_ROOM * layout.piece_size
    trace = np.zeros(marks + layout.lanes * region)
    kernel.floats[:], kernel.ints[:] = 0.0, 0
    for lane, (system, start) in enumerate(zip(systems, starts, strict=True)):
        set_lane(kernel, system, lane)
        kernel.fill("STATE", start, lane)
        kernel.fill("TOLERANCE", 1e-9, lane)
        kernel.fill("WHOLE_PERIODS", PERIODS, lane)
        kernel.fill("STEP_LIMIT", 10_000, lane)
        kernel.fill("EVENT_LIMIT", event_limits[lane] if event_limits else 1000, lane)
        if kernel.equations.contacts[0].sticks:
            kernel.fill("TRANSITION", ARRIVED, lane)
        else:
            kernel.fill("SIDE", 1.0, lane)
            kernel.fill("TRANSITION", 1, lane)
        kernel.fill("RECORDED_EVENT_START", marks + lane * region, lane)
        kernel.fill("RECORDED_EVENT_LIMIT", EVENT_ROOM, lane)
        kernel.fill("PIECE_START", marks + lane * region + EVENT_ROOM * layout.event_size, lane)
        kernel.fill("PIECE_LIMIT", PIECE_ROOM, lane)
    status = kernel["STATUS"]
    while RUNNING in kernel.ints[status : status + layout.lanes]:  # it comes back whenever a lane stops
        kernel["advance"](kernel.floats, kernel.ints, trace, 10_000)
    statuses = kernel.ints[status : status + layout.lanes].tolist()
    return statuses, [trace[marks + lane * region : marks + (lane + 1) * region] for lane in range(layout.lanes)]


@pytest.mark.parametrize("law", ["exponential", "lugre"])
def test_a_lane_among_others_is_the_same_run_alone(law):
    """Each lane steps for itself: the very same bits on its trace, whoever runs beside it and in whatever order."""
    systems = [
        system_with(LAWS[law], mass_ratio, h) for mass_ratio, h in ((2.5, 1.8), (1.0, 1.2), (4.0, 0.3), (0.5, 2.2))
    ]
    starts = [start_of(system, angle) for system, angle in zip(systems, (1.0, -0.4, 0.2, 0.7), strict=True)]
    together, alone = kernel_of(systems[0], lanes=4), kernel_of(systems[0], lanes=1)
    statuses, traces = run_lanes(together, systems, starts)
    assert statuses == [DONE] * 4
    states = together.floats[together["STATE"] :][: together.layout.states * 4].reshape(-1, 4).copy()
    _, backwards = run_lanes(together, systems[::-1], starts[::-1])
    for lane in range(4):
        _, (single,) = run_lanes(alone, [systems[lane]], [starts[lane]])
        assert np.count_nonzero(single) > 100
        assert np.array_equal(traces[lane], single)
        assert np.array_equal(backwards[3 - lane], single)
        assert np.array_equal(states[:, lane], alone.floats[alone["STATE"] :][: alone.layout.states])


# --- the cache -------------------------------------------------------------------------------------------------------


def linked_text(law):
    return kernel_of(system_with(law)).text


def forget_recordings():
    """As in a new process: equations are recorded anew when next asked for."""
    for name in vars(recordings).values():
        if hasattr(name, "cache_clear"):
            name.cache_clear()


def hashed(text):
    return hashlib.sha256(text.encode()).hexdigest()


def test_an_edited_law_is_another_kernel(monkeypatch):
    """A term dropped from a law changes the linked text, and with it the name under which its kernel is kept."""
    before = hashed(linked_text(vc.LuGre()))
    forget_recordings()
    assert hashed(linked_text(vc.LuGre())) == before

    def edited(self, velocity, internal, side, load):
        (bristle,) = internal
        rate = velocity - self._slip_rate(velocity, internal, side, load)
        return self.bristle_stiffness * bristle + self.bristle_damping * rate, (rate,)

    monkeypatch.setattr(vc.LuGre, "force", edited)
    forget_recordings()
    try:
        assert hashed(linked_text(vc.LuGre())) != before
    finally:
        monkeypatch.undo()
        forget_recordings()


def test_parameters_do_not_ask_for_another_kernel():
    """New numbers reuse the compiled kernel; a whole exponent and a rounded one are two forms of the equations."""

    def entry(law):
        return kernel(equations(system_with(law, 0.3)), 12)[1]

    assert entry(vc.Exponential(decay_rate=3.0)) is entry(vc.Exponential())
    assert linked_text(vc.LuGre(bristle_stiffness=7.0)) == linked_text(vc.LuGre())
    assert linked_text(vc.LuGre(stribeck_exponent=1.4)) == linked_text(vc.LuGre(stribeck_exponent=1.6))
    assert linked_text(vc.LuGre(stribeck_exponent=1.0)) != linked_text(vc.LuGre())


def test_reordered_text_is_the_same_text():
    """Recording is deterministic: the text does not depend on what was recorded before, so the cache is met again."""
    first = linked_text(vc.LuGre())
    forget_recordings()
    linked_text(vc.Exponential())
    assert linked_text(vc.LuGre()) == first
