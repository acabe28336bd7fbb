"""Motions against independent solvers: the table of docs/model.md, and random systems.

`reference_motions.json` comes from DOP853 with the equations of docs/model.md typed again, stick and slip switched by
hand; two of its tolerances agree to 1e-10.
"""

import dataclasses
import itertools
import json
import math
from pathlib import Path

import numpy as np
import pytest

import vibrocap as vc
from test_contact_modes import assert_consistent

MOTIONS = json.loads(Path(__file__).with_name("reference_motions.json").read_text(encoding="utf-8"))["motions"]
LAWS = {"LM": vc.LuGre, "EM": vc.Exponential}
DRIVE = vc.Harmonic(amplitude=1.8, frequency=1.0)
FIRST = vc.PendulumCapsule(mass_ratio=2.5, stiffness=2.0, damping=1.0, normal_load=1.0)
SECOND = vc.PendulumCapsule(mass_ratio=2.5, stiffness=4.0, damping=1.2, normal_load=1.0)
MOTION_CACHE = {}

# As printed; a digit is met when the number rounds to it.
TABLE = [
    (FIRST, "LM", ("0.2891670", "0.4010999", "0.5727301", "4.3246962"), "+0.1071890"),
    (FIRST, "EM", ("0.3730564", "0.6110663", "1.1075689", "6.8597399"), "+0.1643477"),
    (SECOND, "LM", ("0.0796961", "-0.0357864", "-0.2178913", "-0.3312095"), None),
    (SECOND, "EM", ("0.0500031", "-0.0226120", "-0.0893616", "-0.1003616"), None),
]
FINAL = {
    "LM": ("0.612854564", "1.50530877", "4.32469625", "0.285652635", "0.00150072416"),
    "EM": ("0.61055219", "1.50592954", "6.8597399", "0.2974614"),
}


def paper_motion(machine, law):
    """40 periods from the paper's start at tolerance 1e-10."""
    key = (machine.stiffness, law)
    if key not in MOTION_CACHE:
        start = {"angle": math.pi / 3} | ({"bristle": 0.0026} if law == "LM" else {})
        system = vc.System(machine, LAWS[law](), DRIVE)
        MOTION_CACHE[key] = vc.simulate(system, periods=40, initial=start, tolerance=1e-10)
    return MOTION_CACHE[key]


def half_a_unit(printed):
    """Half a unit of the last digit, significant digits kept where zeros were dropped after it."""
    return 0.5 * 10.0 ** -len(printed.split(".")[1])


@pytest.mark.parametrize(("machine", "law", "positions", "drift"), TABLE)
def test_every_digit_of_the_table(machine, law, positions, drift):
    motion = paper_motion(machine, law)
    assert motion.status is vc.Status.FINISHED
    position = motion.sections[:, motion.state_names.index("position")]
    for period, printed in zip((1, 2, 5, 40), positions, strict=True):
        assert abs(position[period] - float(printed)) <= half_a_unit(printed), period
    if drift is not None:
        assert abs(position[40] - position[39] - float(drift)) <= half_a_unit(drift)


@pytest.mark.parametrize("law", LAWS)
def test_every_digit_of_the_final_state(law):
    motion = paper_motion(FIRST, law)
    for value, printed in zip(motion.state.values(), FINAL[law], strict=True):
        assert abs(value - float(printed)) <= half_a_unit(printed)


def test_symmetric_motions_come_to_no_drift():
    """Second set: 0 (EM) and about 0 (LM), where a transient is still dying geometrically in period 40."""
    position = paper_motion(SECOND, "EM").sections[:, 2]
    assert abs(position[40] - position[39]) <= 100 * 1e-10
    drift = np.diff(paper_motion(SECOND, "LM").sections[:, 2])
    ratio = drift[-1] / drift[-2]
    assert abs(drift[-1]) < 1e-6
    assert ratio == pytest.approx(drift[-2] / drift[-3], rel=1e-3)
    assert 0.0 < ratio < 0.8


def _case(row):
    """A row as a case of a test; slow or later where its equations are of a form that no other fast test compiles."""
    parameters = row["parameters"]
    common = parameters["law"] == "exponential" or (
        parameters["stribeck_exponent"] == 2.0 and not parameters["second_amplitude"]
    )
    kept = row["seed"] % 3 == 0
    rare = pytest.mark.slow if kept else pytest.mark.exhaustive
    return pytest.param(row, id=f"seed {row['seed']}", marks=[] if common else [rare])


CASES = [_case(row) for row in MOTIONS]


def system_of(row):
    """The system of a row of the table, built from its numbers."""
    p = row["parameters"]
    law = vc.Exponential if p["law"] == "exponential" else vc.LuGre
    machine = vc.PendulumCapsule(p["mass_ratio"], p["stiffness"], p["damping"], p["normal_load"])
    if p["second_amplitude"]:
        drive = vc.Biharmonic(p["amplitude"], p["frequency"], p["second_amplitude"], p["second_phase"])
    else:
        drive = vc.Harmonic(p["amplitude"], p["frequency"])
    values = {field.name: p[field.name] for field in dataclasses.fields(law) if field.name in p}
    return vc.System(machine, law(**values), drive)


def assert_phases_are_between_events(motion):
    """Pieces lie end to end, phases too, and every change of side is an event of its kind, at rest."""
    assert motion.piece_start[1:] == pytest.approx((motion.piece_start + motion.piece_length)[:-1], rel=1e-14)
    assert motion.end == pytest.approx(motion.periods * motion.period, rel=1e-14)
    expected = {(1, 0): "stick", (-1, 0): "stick", (0, 1): "slip_forward", (0, -1): "slip_back"}
    changes = [event for event in motion.events if event.kind != "graze"]
    pairs = list(itertools.pairwise(motion.phases))
    assert [after.start for _, after in pairs] == pytest.approx([event.time for event in changes], rel=1e-14)
    for event, (before, after) in zip(changes, pairs, strict=True):
        assert before.end == after.start
        assert event.kind == expected.get((before.side, after.side), "reversal")
        assert event.state["velocity"] == 0.0


@pytest.mark.parametrize("row", CASES)
def test_random_systems(row):
    """States within 1e-8 of the independent solver's, the same events, the same time spent stuck; certified."""
    system = system_of(row)
    start = dict(zip(system.state_names, row["initial"], strict=True))
    motion = vc.simulate(system, periods=row["periods"], initial=start, tolerance=1e-10)
    assert_consistent(motion)
    assert_phases_are_between_events(motion)
    assert motion.certificate.estimated_error <= 1e-6
    for name, expected in zip(system.state_names, row["final"], strict=True):
        assert abs(motion.state[name] - expected) <= 1e-8, name
    kinds = [event.kind for event in motion.events]
    counted = {kind: kinds.count(kind) for kind in ("stick", "slip_forward", "slip_back", "reversal") if kind in kinds}
    if system.friction.name == "lugre":
        assert counted == row["events"]
    else:  # the independent solver counts a velocity that changes sign without sticking as a slip
        phases = [phase.side for phase in motion.phases]
        assert phases[1:].count(1) == row["events"].get("slip forward", 0)
        assert phases[1:].count(-1) == row["events"].get("slip back", 0)
        assert phases[1:].count(0) == row["events"].get("stick", 0)
        stuck = sum(phase.length for phase in motion.phases if phase.side == 0)
        assert abs(stuck / motion.end - row["stick_fraction"]) <= 1e-8
