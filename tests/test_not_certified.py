"""What is derived from a motion that a certificate refuses says so: ensembles, studies, orbits, branches, basins.

The faults are planted in kernels as plain Python, so that no law or machine of the package has to be wrong.
"""

import contextlib
import dataclasses
from unittest import mock

import numpy as np
import pytest

import vibrocap as vc
from plain_kernels import kernel_of, running_on
from thinned import exhaustive_but
from vibrocap.motion import evidence
from vibrocap.motion.recording.equations import equations, parameter_values
from vibrocap.numerics.run.budget import Budget, EnsembleStart, Form
from vibrocap.numerics.run.ensemble import ensemble_kernel, ensemble_run
from vibrocap.physics.friction.law import Law
from vibrocap.physics.parameters import parameter_table, parameters
from vibrocap.plotting.studies.maps import study_figure
from vibrocap.plotting.studies.view import study_view

COULOMB = vc.System(vc.PendulumCapsule(), vc.Coulomb(), vc.Harmonic(amplitude=1.2))
BRISTLES = vc.System(vc.PendulumCapsule(), vc.LuGre(), vc.Harmonic(amplitude=1.2))
START = {"angle": 0.5}
# In which the speed dips near rest, where friction changes within 0.001; see `test_sharp.py`.
DIP = vc.System(
    vc.Oscillator(mass=1.0, stiffness=1.0, normal_load=1.0, damping=0.05, belt_speed=0.38586482190399185),
    vc.Stribeck(stribeck_velocity=0.001, stribeck_exponent=2.0, viscous_damping=0.0),
    vc.Harmonic(amplitude=0.4581420135847618, frequency=0.31840840659290537),
)
DIP_START = {"position": 0.26819494181804693, "sliding_velocity": 0.003696111015576209}
TOLERANCE, PERIODS = 1e-8, 2


def unseen(names):
    """No step is cut where a law may hide within it."""
    return {"resolved": lambda floats, lane, h: True}


def late(names):
    """The limit of what a contact can hold is taken 2 % too high, so that it slips late."""
    jet = names["jet"]

    def raised(floats):
        jet(floats)
        floats[names["LIMIT_OF"][0] : names["LIMIT_OF"][0] + names["ORDER"] + 1] *= 1.02

    return {"jet": raised}


def early(names):
    """Events are located a ten-thousandth of a step too early."""
    first_root = names["first_root"]

    def before(*given):
        root, touch = first_root(*given)
        return (0.9999 * root if root > 0.0 else root), touch

    return {"first_root": before}


def missed(names):
    """No root of a velocity is seen."""
    first_root = names["first_root"]

    def blind(floats, row, *given):
        return (-1.0, -1.0) if row == names["VELOCITY_OF"][0] else first_root(floats, row, *given)

    return {"first_root": blind}


def others(names):
    """The series are those of other equations: the third coefficient of the inner velocity is off by a thousandth."""
    jet = names["jet"]

    def bent(floats):
        jet(floats)
        floats[names["SERIES"] + (names["ORDER"] + 1) + 3] *= 1.001

    return {"jet": bent}


FAULTS = {
    unseen: (DIP, DIP_START, 8, {"defect"}),
    late: (COULOMB, START, PERIODS, {"stick_force_ratio"}),
    early: (COULOMB, START, PERIODS, {"event_velocity"}),
    missed: (BRISTLES, START, PERIODS, {"event_velocity", "least_velocity"}),
    others: (COULOMB, START, PERIODS, {"defect"}),
}


def seen(system, start, periods, fault=None, tolerance=TOLERANCE):
    """(result of a run as plain Python, whether it is certified), with evidence of all of its periods."""
    recorded, row = equations(system), np.array([parameter_values(system)])
    state = np.array([[start.get(name, 0.0) for name in system.state_names]])
    budget = Budget(periods, tolerance, 1000, 100_000, evidence=periods)
    form = Form(order=12, lanes=1, plain=True)
    names = ensemble_kernel(recorded, form, False)[1].__globals__
    with mock.patch.dict(names, fault(names) if fault else {}):
        results = ensemble_run(EnsembleStart(recorded, row, state), budget, form, threads=1)
    return results, bool(evidence.certified(recorded, results, row, tolerance)[0])


@pytest.mark.parametrize("fault", FAULTS, ids=[fault.__name__ for fault in FAULTS])
def test_what_a_certificate_refuses_an_ensemble_refuses(fault):
    """And it passes both without the fault. The certificate is that of the same run, recorded with the same fault."""
    system, start, periods, fields = FAULTS[fault]
    _, good = seen(system, start, periods)
    results, refused = seen(system, start, periods, fault)
    kernel = kernel_of(system)
    with running_on(kernel, **fault(kernel.names)):
        motion = vc.simulate(system, periods=periods, initial=start, tolerance=TOLERANCE)
        certificate = motion.certificate
    assert motion.run_status.ok
    assert results.finished[0]
    assert good
    assert not refused
    assert fields & {verdict.field for verdict in certificate.verdicts if not verdict.ok}
    if fault is unseen:  # the worst of it is in the dip, within a step
        assert results.entry("DEFECT")[0] == pytest.approx(certificate.defect, rel=0.1)


def test_evidence_is_that_of_the_certificate():
    """Of one run with sticks, at the points that are asked: below the certificate's own numbers, and near them."""
    results, good = seen(COULOMB, START, 4)
    with running_on(kernel_of(COULOMB)):
        certificate = vc.simulate(COULOMB, periods=4, initial=START, tolerance=TOLERANCE).certificate
    assert good
    assert certificate.ok
    assert 0.0 < results.entry("DEFECT")[0] <= 1.001 * certificate.defect
    assert results.entry("STICKING_SHARE")[0] == pytest.approx(certificate.stick_force_ratio, abs=1e-9)
    assert results.entry("LEAST_VELOCITY")[0] >= certificate.least_velocity - 1e-15


@pytest.mark.slow
def test_evidence_changes_no_bit_of_a_run_and_is_the_same_in_any_lane():
    recorded = equations(COULOMB)
    rows = np.tile(parameter_values(COULOMB), (21, 1))
    rows[:, recorded.parameter_paths.index("machine.mass_ratio")] = np.linspace(0.5, 5.0, 21)
    states = np.tile([0.5, 0.0, 0.0, 0.0], (21, 1))
    plain = Budget(6, TOLERANCE, 1000, 100_000, window=2)
    asked = dataclasses.replace(plain, evidence=1)
    first = ensemble_run(EnsembleStart(recorded, rows, states), asked, threads=1)
    assert np.array_equal(ensemble_run(EnsembleStart(recorded, rows, states), plain, threads=2).state, first.state)
    other = ensemble_run(EnsembleStart(recorded, rows[::-1].copy(), states), asked, threads=2)
    for name in ("DEFECT", "STICKING_SHARE", "LEAST_VELOCITY"):
        assert np.array_equal(other.entry(name)[::-1], first.entry(name))
    assert np.all(ensemble_run(EnsembleStart(recorded, rows, states), plain).entry("DEFECT") == 0.0)
    assert np.all(first.entry("DEFECT") > 0.0)


@pytest.fixture
def nothing_passes(monkeypatch):
    """The bound of the defect is taken away, of certificates and of runs: there is one number, in one place."""
    monkeypatch.setattr(evidence, "DEFECT_BOUND", 0.0)


CAPSULE = vc.System(vc.PendulumCapsule(), vc.Exponential(), vc.Harmonic(amplitude=1.8))


def test_ensembles_and_studies_say_so_and_keep_their_measures(nothing_passes):
    results = vc.ensemble(CAPSULE, {"machine.mass_ratio": [2.0, 3.0]}, periods=20, settle=1e-6)
    assert {list(vc.Status)[code] for code in results["status"]} == {vc.Status.NOT_CERTIFIED}
    assert np.all(np.isfinite(results["mean_velocity"]))
    dataset = vc.sweep(
        CAPSULE, {"machine.mass_ratio": [2.0, 3.0], "drive.amplitude": [1.0, 1.8]}, periods=4, tolerance=1e-8, settle=0
    )
    assert np.all(dataset["status"].values == list(vc.Status).index(vc.Status.NOT_CERTIFIED))
    assert np.all(np.isfinite(dataset["mean_velocity"].values))
    figure = study_figure(study_view(dataset))
    assert any("not certified 4" in text.get_text() for legend in figure.legends for text in legend.get_texts())


def test_orbits_and_branches_say_so(nothing_passes):
    orbit = vc.orbit(CAPSULE, initial=START)
    assert orbit.status.value == "not certified"
    assert orbit.closes
    assert orbit.residual < 1e-9
    assert "certificate" in orbit.status.advice
    branch = vc.branch(CAPSULE, "machine.mass_ratio", (2.4, 2.6), orbit=orbit, points=3, towards="up")
    assert len(branch) > 1
    assert not branch.certified.any()
    assert f"{len(branch)} points" in str(branch)
    assert "not certified" in str(branch)
    assert vc.lyapunov_exponent(CAPSULE, START, periods=20, transient=0).certified is False


def test_basins_and_diagrams_say_so(nothing_passes):
    cells = vc.basins(CAPSULE, {"angle": (-1.0, 1.0), "angle_rate": (-1.0, 1.0)}, 2, settle_periods=60)
    assert np.all(cells.label == -5)
    assert np.all(cells.direction == -5)
    assert cells.attractors == ()
    diagram = vc.bifurcation_diagram(CAPSULE, "machine.mass_ratio", (2.4, 2.5), 2, starts=1, settle_periods=60)
    assert np.all(diagram.response_period == -2)


@parameters
class Forgetful(vc.Coulomb):
    """A law of one's own that owns up to half of what it takes."""

    name = "forgetful-of-half"

    def losses(self, velocity, internal, side, load):
        sliding, bristle = vc.Coulomb.losses(self, velocity, internal, side, load)
        return 0.5 * sliding, bristle


@pytest.mark.plain
def test_works_that_contradict_the_forces_are_not_certified():
    """Of an orbit only the certificate of its recorded period tells, of an ensemble nothing unless works are asked."""
    orbit = vc.orbit(vc.System(vc.PendulumCapsule(), Forgetful(), vc.Harmonic(amplitude=1.2)), initial=START)
    assert orbit.status.value == "not certified"
    assert {verdict.field for verdict in orbit.motion().certificate.verdicts if not verdict.ok} == {"energy_residual"}
    for law, ending in ((vc.Coulomb(), vc.Status.FINISHED), (Forgetful(), vc.Status.NOT_CERTIFIED)):
        belt = vc.System(vc.Oscillator(damping=0.3, belt_speed=0.1), law, vc.Harmonic())
        for measure, status in (("drive_work", ending), ("largest_position", vc.Status.FINISHED)):
            results = vc.ensemble(belt, {"drive.amplitude": [0.8]}, measures=[measure], periods=5, window=3)
            assert list(vc.Status)[results["status"][0]] is status
            assert results[measure][0] > 0.0


def changed(kind: type[Law], draw: np.random.Generator) -> Law:
    """A law with every number but exponents changed by up to a factor of six, levels by half."""
    while True:
        values = {}
        for info in parameter_table(kind):
            if not isinstance(info.default, float) or "exponent" in info.name:
                continue
            level = info.name in ("coulomb_coefficient", "static_coefficient")
            values[info.name] = info.default * (draw.uniform(0.5, 1.5) if level else 10.0 ** draw.uniform(-0.8, 0.8))
        with contextlib.suppress(ValueError):
            return kind(**values)


@pytest.mark.slow
@pytest.mark.parametrize(
    "kind",
    exhaustive_but([1], [vc.Coulomb, vc.Exponential, vc.LuGre, vc.ElastoPlastic, vc.BoucWen, vc.MaxwellSlip]),
)
def test_no_false_alarm_in_a_thousand_plausible_runs(kind):
    draw = np.random.default_rng(7)
    system = vc.System(vc.PendulumCapsule(), kind(), vc.Harmonic())
    over = {}
    for _ in range(1000):
        law = changed(kind, draw)
        values = {f"friction.{info.name}": getattr(law, info.name) for info in parameter_table(kind)}
        values = {path: value for path, value in values.items() if isinstance(value, float)}
        values |= {"machine.mass_ratio": 10.0 ** draw.uniform(-0.5, 0.9), "drive.amplitude": draw.uniform(0.1, 2.0)}
        values |= {"initial.angle": draw.uniform(-1.0, 1.0)}
        for path, value in values.items():
            over.setdefault(path, []).append(value)
    assert not vc.ensemble(system, over, periods=10, window=1, tolerance=1e-7)["status"].any()
