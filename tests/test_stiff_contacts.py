"""Implicit steps where several contacts rub, of which one or more are stiff: against a solver of its own, and alone."""

import pytest

import vibrocap as vc
from stiff_contacts import MOTIONS, reference, stored, system_of
from thinned import exhaustive_but

# Steps at 1e-7 as they were when these steps were made: a term that is left out of them costs up to twice as many.
STEPS = {
    "crawler coulomb lugre": 788,
    "crawler lugre lugre": 1418,
    "crawler ageing ageing": 568,
    "worm coulomb ageing": 612,
    "worm ageing ageing": 705,
    "worm coulomb lugre": 427,
    "worm lugre lugre": 636,
}


def events_of(motion: vc.Trajectory) -> list[tuple[float, int]]:
    """(time, contact) of what happens at contacts; where the start finds a side, nothing does."""
    values = []
    for time, kind in zip(motion.event_times, motion.event_kinds, strict=True):
        name, number = (kind[:-2], int(kind[-1])) if kind[-2:-1] == "_" else (kind, 1)
        if name != "switch":
            values.append((float(time), number))
    return values


@pytest.mark.slow
@pytest.mark.parametrize("name", exhaustive_but([2], list(STEPS)))
def test_against_an_independent_stiff_solver(name):
    system, start = system_of(name)
    given = stored()[name]
    for tolerance, bound in ((1e-11, 1e-9), (1e-7, 1e-5)):
        motion = vc.simulate(system, initial=start, periods=MOTIONS[name], tolerance=tolerance)
        assert motion.certificate.ok
        state = motion.state
        assert {key: state[key] for key in given["state"]} == pytest.approx(given["state"], rel=bound, abs=bound)
    assert len(motion.piece_start) <= 1.3 * STEPS[name]
    found = events_of(vc.simulate(system, initial=start, periods=MOTIONS[name], tolerance=1e-11))
    assert [contact for _, contact in found] == [contact for _, contact in given["events"]]
    assert [time for time, _ in found] == pytest.approx([time for time, _ in given["events"]], abs=1e-8)


@pytest.mark.slow
def test_that_solver_itself():
    """What is stored is what it computes: the shortest of its motions again, for a while."""
    name = "worm coulomb ageing"
    state, events = reference(name, 0.15)
    system, start = system_of(name)
    motion = vc.simulate(system, initial=start, periods=0.15, tolerance=1e-12)
    assert {key: motion.state[key] for key in state} == pytest.approx(state, rel=1e-10, abs=1e-10)
    assert [contact for _, contact in events_of(motion)] == [contact for _, contact in events]
    assert [time for time, _ in events_of(motion)] == pytest.approx([time for time, _ in events], abs=1e-9)
