"""Implicit steps where several contacts rub, of which one or more are stiff: against independent solvers, and alone.

`stiff_contacts.json` comes from SciPy's Radau between located events, with laws, bodies and modes typed again.
"""

import json
from pathlib import Path

import pytest

import vibrocap as vc
from thinned import exhaustive_but

MOTIONS = json.loads(Path(__file__).with_name("stiff_contacts.json").read_text(encoding="utf-8"))
LAWS = {
    "coulomb": vc.Coulomb(0.25, 0.25),
    "lugre": vc.LuGre(bristle_stiffness=1e4, bristle_damping=100.0, coulomb_coefficient=0.15, static_coefficient=0.3),
    "ageing": vc.RateAndStateAgeing(),
}
BODIES = {"mass_2": 1.5, "normal_load_2": 1.2}
# for how many periods, and steps at 1e-7 as they were when these steps were made: a term that is left out of them costs
# up to twice as many
TABLE = {
    "crawler coulomb lugre": (1.0, 788),
    "crawler lugre lugre": (1.0, 1418),
    "crawler ageing ageing": (1.0, 568),
    "worm coulomb ageing": (1.0, 612),
    "worm ageing ageing": (1.0, 705),
    "worm coulomb lugre": (0.6, 427),
    "worm lugre lugre": (0.3, 636),
}


def system_of(name: str) -> tuple[vc.System, dict[str, float]]:
    """(system, start) of a motion."""
    kind, *laws = name.split()
    friction = [LAWS[law] for law in laws]
    if kind == "worm":
        drive = vc.Harmonic(amplitude=0.5, frequency=0.8)
        return vc.System(vc.TwoBodyWorm(**BODIES), friction, drive), {"centre_velocity": 0.05}
    drive = vc.Biharmonic(amplitude=1.5, frequency=0.8, second_amplitude=0.7, second_phase=0.5)
    return vc.System(vc.TwoBodyCrawler(**BODIES), friction, drive), {"velocity": 0.1, "velocity_2": -0.05}


def events_of(events) -> list[tuple[float, int]]:
    """(time, contact) of what happens at contacts; where the start finds a side, nothing does."""
    return [(float(t), int(kind[-1]) if kind[-2:-1] == "_" else 1) for t, kind in events if "switch" not in kind]


@pytest.mark.slow
@pytest.mark.parametrize("name", exhaustive_but([2], list(TABLE)))
def test_against_an_independent_stiff_solver(name):
    (system, start), (periods, steps), wanted = system_of(name), TABLE[name], MOTIONS[name]
    motions = []
    for tolerance, bound in ((1e-11, 1e-9), (1e-7, 1e-5)):
        motion = vc.simulate(system, initial=start, periods=periods, tolerance=tolerance)
        assert motion.certificate.ok
        state = motion.state
        assert {key: state[key] for key in wanted["state"]} == pytest.approx(wanted["state"], rel=bound, abs=bound)
        motions.append(motion)
    assert len(motions[1].piece_start) <= 1.3 * steps
    events = events_of((event.time, event.kind) for event in motions[0].events)
    assert [contact for _, contact in events] == [contact for _, contact in wanted["events"]]
    assert [time for time, _ in events] == pytest.approx([time for time, _ in wanted["events"]], abs=1e-8)


@pytest.mark.slow
def test_feet_that_creep_after_a_reversal_take_implicit_steps():
    """Next to rest their summed rates of decay bound a step below what stability of one of them asks."""
    law = vc.RateAndStateAgeing(0.3, 0.03, 0.06, 0.01, 0.1)
    system = vc.System(vc.BristleRobot(), law, vc.Square(amplitude=1.2, frequency=1.3))
    motion = vc.simulate(system, periods=1, tolerance=1e-9)
    assert motion.certificate.ok
    assert len(motion.piece_start) < 2000  # 51,000 where explicit steps go on
