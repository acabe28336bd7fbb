"""What a motion keeps: of a state that is the integral of another one coefficient a piece, the rest to the last bit.

And that the memory which is lent to one motion after the other belongs to one at a time: in threads, in a function that
is told of the progress, in a signal handler, in a child process, after an error.
"""

import concurrent.futures
import gc
import os
import pickle
import signal
import threading

import numpy as np
import pytest

import vibrocap as vc
from vibrocap.motion.recording.equations import equations, parameter_values
from vibrocap.numerics.api import Form, MotionStart, recorded_run
from vibrocap.numerics.kernel.memory_layout import PIECE_HEAD
from vibrocap.numerics.run import motion as run
from vibrocap.numerics.run.budget import Budget
from vibrocap.numerics.run.motion import TRACES, kernel
from vibrocap.results import same

EM = vc.System(vc.PendulumCapsule(), vc.Exponential(), vc.Harmonic(amplitude=1.8))
LM = vc.System(vc.PendulumCapsule(), vc.LuGre(), vc.Harmonic(amplitude=1.8))
ROW = vc.System(vc.TwoBodyCrawler(), vc.Coulomb(), vc.Square())
STOPS = vc.System(vc.RigidStopCapsule(), vc.Coulomb(), vc.Harmonic())


def moved(system, periods=3, tolerance=1e-9, **given):
    initial = {system.state_names[0]: 0.15}
    return vc.simulate(system, periods=periods, initial=initial, tolerance=tolerance, **given)


# --- what is left out, and what it would have been --------------------------------------------------------------------


@pytest.mark.parametrize("system", [EM, LM, ROW, STOPS], ids=["EM", "LM", "row", "stops"])
@pytest.mark.parametrize("order", [10, 12, pytest.param(16, marks=pytest.mark.slow)])
def test_coefficients_are_those_of_the_step_to_the_last_bit(system, order, monkeypatch):
    """The plain kernel tells the series that stands in its memory when a piece is kept."""
    recorded = equations(system)
    values = recorded, parameter_values(system), [0.15, *[0.0] * (len(recorded.rates) - 1)], system.drive.period
    layout, advance = kernel(recorded, order, True, False)
    place, states, results = layout.places["SERIES"], layout.states, []
    names = advance.__globals__
    on_piece = names["on_piece"]

    def told(floats, *rest):
        results.append(floats[place : place + states * (order + 1)].reshape(states, -1).copy())
        on_piece(floats, *rest)

    monkeypatch.setitem(names, "on_piece", told)
    found = recorded_run(MotionStart(*values), Budget(0.6, 1e-9, 1000, 10**6), Form(plain=True, order=order))
    assert len(results) == len(found.pieces) >= 5
    assert np.array_equal(found.series[:], np.array(results))
    numbers = np.array([3, 3, 0, 4])
    assert np.array_equal(found.series[numbers], np.array(results)[numbers])
    assert any(rate >= 0 for rate in found.rates) is not recorded.maybe_stiff
    assert system is not EM or found.rates == (1, -1, 3, -1)


def test_a_motion_keeps_no_more_than_its_pieces():
    """264 bytes a piece (456 with all coefficients); the trace on which they were written is not kept."""
    motion = moved(EM, periods=10)
    numbers = motion.series.numbers
    assert numbers.shape[1] == 4 + 2 * 12
    whole = numbers if numbers.base is None else numbers.base
    assert whole.size == len(motion.piece_start) * (PIECE_HEAD + numbers.shape[1] + 1)
    assert len(pickle.dumps(motion)) < 0.8 * motion.coefficients.nbytes


def test_a_long_motion_is_the_same_in_parts(monkeypatch):
    """Pieces go out whenever the trace is full."""
    at_once = moved(EM, periods=5)
    monkeypatch.setattr(run, "PIECE_ROOM", 40)
    monkeypatch.setattr(run, "EVENT_ROOM", 12)
    assert same(moved(EM, periods=5), at_once)
    monkeypatch.setattr(run, "PIECE_ROOM", len(at_once.piece_start) + 1)  # nearly all of the trace is kept: as it is
    assert same(moved(EM, periods=5), at_once)


# --- one trace for one motion after the other -------------------------------------------------------------------------


def test_motions_that_are_kept_do_not_change_when_others_run():
    kept = [moved(system, periods) for system in (EM, LM) for periods in (2, 3)]
    stored = [pickle.dumps(motion) for motion in kept]
    for motion in kept:
        moved(motion.system, 4)
    assert all(same(pickle.loads(then), motion) for then, motion in zip(stored, kept, strict=True))


def test_motions_in_threads_are_those_of_one():
    systems = [EM.with_parameters({"machine.mass_ratio": 1.0 + 0.2 * i}) for i in range(8)]
    alone = [moved(system) for system in systems]
    ready = threading.Barrier(4)

    def several(first):
        ready.wait()
        return [moved(system) for system in systems[first:] + systems[:first]]

    with concurrent.futures.ThreadPoolExecutor(4) as pool:
        for first, found in enumerate(pool.map(several, range(4))):
            assert same(found, alone[first:] + alone[:first])


def test_a_motion_within_another_has_its_own_trace(monkeypatch):
    """In a function that is told of the progress, and in a signal handler that runs then."""
    monkeypatch.setattr(run, "ROUNDS", 50)
    outer, inner, within = moved(EM, 4), moved(LM, 2), []

    def handled(*_):
        within.append(moved(LM, 2))

    def told(share):
        within.append(moved(LM, 2))
        if hasattr(signal, "raise_signal") and len(within) < 4:
            signal.raise_signal(signal.SIGTERM)

    before = signal.signal(signal.SIGTERM, handled)
    try:
        assert same(moved(EM, 4, progress=told), outer)
    finally:
        signal.signal(signal.SIGTERM, before)
    assert len(within) > 5
    assert all(same(each, inner) for each in within)


def test_a_motion_that_is_given_up_leaves_the_next_as_it_is():
    wanted = moved(EM)

    def stopped(share):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        moved(EM, progress=stopped)
    assert same(moved(EM), wanted)
    assert not moved(EM, max_steps=20).status.ok
    assert same(moved(EM), wanted)


@pytest.mark.skipif(not hasattr(os, "fork"), reason="the system has no fork")
def test_a_child_process_has_a_trace_of_its_own():
    wanted = moved(EM)
    reader, writer = os.pipe()
    child = os.fork()
    if child == 0:
        os.write(writer, b"1" if same(moved(EM), wanted) and same(moved(EM), wanted) else b"0")
        os._exit(0)
    mine = moved(EM)
    os.waitpid(child, 0)
    assert os.read(reader, 1) == b"1"
    assert same(mine, wanted)
    os.close(reader)
    os.close(writer)


def test_the_trace_is_used_again_and_a_very_large_one_is_not_kept():
    moved(EM)
    (kept,) = TRACES._free
    moved(EM, 2)
    assert TRACES._free[0] is kept
    assert kept.size <= run.LARGEST_TRACE
    vc.simulate(EM, periods=run.LARGEST_TRACE // 4 + 1, max_steps=100)  # its period marks alone are more than that
    assert not TRACES._free
    gc.collect()
    moved(EM)
    assert TRACES._free
