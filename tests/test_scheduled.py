"""Drives on a schedule: their contract, motions against the phases run one by one, mirror images, what is refused."""

import dataclasses
import math

import numpy as np
import pytest

import vibrocap as vc
from thinned import exhaustive_but
from vibrocap.case.case import case_from_text, case_text
from vibrocap.contracts.drive_clauses import DRIVE_CLAUSES
from vibrocap.physics.catalogue import drives

CAPSULE = vc.PendulumCapsule(mass_ratio=2.5, stiffness=2.0, damping=1.0)
RAMPS = ("loading", "ramp")  # begin anew with their period
SCHEDULED = [drives()[f"scheduled-{name}"] for name in drives() if name not in RAMPS]


def system_of(drive):
    return vc.System(CAPSULE, vc.Exponential(), drive)


def phase_by_phase(drive, rows, initial, tolerance=1e-12):
    """The states at the end of each row (periods, factor), from motions of the drive itself, one after another."""
    results, state, names = [], initial, ("amplitude", "second_amplitude")
    for periods, factor in rows:
        scaled = {name: factor * getattr(drive, name) for name in names if hasattr(drive, name)}
        motion = vc.simulate(
            system_of(dataclasses.replace(drive, **scaled)), periods=periods, initial=state, tolerance=tolerance
        )
        assert motion.status.ok
        state = motion.state
        results.append(state)
    return results


SHORT = {"periods_1": 2.0, "factor_1": 0.5, "periods_2": 1.0}
ODD, ONCE = {"periods_1": 1.0, "periods_2": 1.0, "factor_2": -1.0}, {"periods_1": 3.0, "periods_2": 0.0}
KINDS = [
    *((kind, SHORT) for kind in SCHEDULED),
    *((drives()[f"scheduled-{name}"], phases) for name in ("square", "harmonic") for phases in (ODD, ONCE)),
]


@pytest.mark.parametrize(("kind", "phases"), KINDS, ids=lambda each: getattr(each, "name", ""))
def test_a_scheduled_drive_keeps_the_contract_of_a_drive(kind, phases):
    drive = kind(**phases)
    assert {clause.__name__: said for clause in DRIVE_CLAUSES if (said := clause(drive)) is not None} == {}
    assert drive.wave.period * sum(count for count, _ in drive.phases) == drive.period
    assert drive.time_scale == drive.wave.period


def test_its_value_is_the_factor_times_the_wave_begun_anew():
    drive = vc.scheduled(vc.Biharmonic)(
        amplitude=1.3, frequency=2.0, second_amplitude=0.4, periods_1=1.25, factor_1=-0.5, periods_2=0.5, periods_3=2.0,
        factor_3=0.75,
    )  # fmt: skip
    wave = vc.Biharmonic(amplitude=1.3, frequency=2.0, second_amplitude=0.4)
    for share in (0.1, 0.9, 1.3, 1.9, 3.0, 4.0):
        t = share * math.pi
        share %= 3.75
        start, factor = (0.0, -0.5) if share < 1.25 else (1.25, 0.0) if share < 1.75 else (1.75, 0.75)
        assert drive.value(t) == pytest.approx(factor * wave.value((share - start) * math.pi), abs=1e-13)
    assert not drive.continuous
    assert not drive.odd


def test_time_scales_and_tolerances_are_those_of_the_wave_however_long_the_schedule_is():
    block = vc.Oscillator(stiffness=0.0)
    plain = vc.System(block, vc.Coulomb(), vc.Harmonic())
    long = vc.System(block, vc.Coulomb(), vc.scheduled(vc.Harmonic)(periods_1=500.0))
    assert long.scales() == plain.scales()


def test_it_is_found_by_its_name_and_written_into_cases():
    kind = vc.scheduled(vc.Harmonic)
    assert drives()["scheduled-harmonic"] is kind is vc.scheduled(vc.Harmonic)
    assert "scheduled-harmonic" in drives()
    assert "scheduled-harmonic" not in list(drives())
    for name in ("scheduled-nothing", "scheduled-ramp", "scheduled-scheduled-square", "planned-square"):
        assert name not in drives()
    case = vc.Case(system_of(kind(periods_1=2.5, factor_1=-0.75)), {"angle": 0.5}, periods=1)
    assert case_from_text(case_text(case)) == case
    with pytest.raises(vc.CaseError, match=r"drive.factor_8: no such key"):
        case_from_text(case_text(case).replace("factor_7", "factor_8"))


def test_what_cannot_be_scheduled_is_refused():
    with pytest.raises(ValueError, match="scheduled already"):
        vc.scheduled(vc.scheduled(vc.Square))
    with pytest.raises(ValueError, match="function of time alone"):
        vc.scheduled(vc.Ramp)
    with pytest.raises(ValueError, match=r"periods_1 ?:? should be greater than 0.* no phase at all"):
        vc.scheduled(vc.Harmonic)(periods_1=0.0, periods_2=0.0)
    with pytest.raises(ValueError, match=r"periods_2.* whole number, as the square drive has corners.* got 2.5"):
        vc.scheduled(vc.Square)(periods_2=2.5)
    with pytest.raises(ValueError, match=r"at most 50000 periods in all"):
        vc.scheduled(vc.Square)(periods_2=1e5)
    with pytest.raises(ValueError, match="jumps"):
        vc.System(vc.TwoMassCrawler(), vc.Coulomb(), vc.scheduled(vc.Harmonic)())
    vc.System(vc.TwoMassCrawler(), vc.Coulomb(), vc.scheduled(vc.SevenPhase)(periods_1=70.0))  # begins and ends at 0


@pytest.mark.slow
@pytest.mark.parametrize(
    ("drive", "rows"),
    exhaustive_but(
        [2],
        [
            (vc.Harmonic(amplitude=1.8), [(6.3, 1.0), (2.0, 0.0), (1.75, -0.7), (3.0, 0.0)]),
            (vc.Biharmonic(amplitude=1.5, second_amplitude=0.4), [(0.4, -1.0), (4.0, 0.5), (1.0, 0.0)]),
            (vc.Square(amplitude=1.5, duty=0.3), [(3.0, 1.0), (1.0, 0.0), (2.0, -0.5), (2.0, 0.0)]),
        ],
    ),
    ids=["harmonic", "biharmonic", "square"],
)
def test_a_motion_over_the_schedule_is_that_of_its_phases_one_after_another(drive, rows):
    own = {field.name: getattr(drive, field.name) for field in dataclasses.fields(drive)}
    phases = {f"periods_{k}": periods for k, (periods, _) in enumerate(rows, 1)}
    phases |= {f"factor_{k}": factor for k, (_, factor) in enumerate(rows, 1)}
    system = system_of(vc.scheduled(type(drive))(**own, **phases))
    expected = phase_by_phase(drive, rows, {"angle": 0.4})
    motion = vc.simulate(system, periods=1, initial={"angle": 0.4}, tolerance=1e-12)
    assert motion.status.ok
    assert motion.certificate.ok
    ends = drive.period * np.cumsum([periods for periods, _ in rows])
    for end, state in zip(ends, expected, strict=True):
        for name, value in state.items():  # 1e-12 per step, over thousands of steps
            assert motion.at([min(end, motion.end)], name)[0] == pytest.approx(value, abs=1e-8), (end, name)
