"""Laws with any power of the speed that change within a small speed, against an independent solver.

`sharp_powers.json` holds motions of 203 systems, by DOP853 from event to event with a local error of 1e-15 and steps no
longer than a quarter of the root of the law's own speed: the states at the start of each drive period and at the end,
the events, and what a shift of any state grows to. A contact that leaves rest has v = c t^2, and |v|^alpha
has a Taylor series there for few alpha, whose terms are few and far between; what is lost in the first of steps grows
by all that friction falls later.
"""

import dataclasses
import json
from collections import Counter
from pathlib import Path

import numpy as np
import pytest

import vibrocap as vc
from independent import motion as independent_motion
from thinned import exhaustive_but, slow_but
from vibrocap.measures.gathered import loses_at_switches
from vibrocap.motion.recording.equations import equations, parameter_values
from vibrocap.numerics.codegen.resolution import system_sharpness
from vibrocap.numerics.expressions.structure import gaps, no_series_at_rest
from vibrocap.numerics.run.budget import Budget, EnsembleStart
from vibrocap.numerics.run.ensemble import ensemble_run
from vibrocap.physics.friction.wrappers import smoothed

TABLE = json.loads(Path(__file__).with_name("sharp_powers.json").read_text(encoding="utf-8"))
STEPS = 30.0  # tolerances, times what a shift of the start grows to
SHARE = 1.0 / 3.0  # of the error that an estimate of it has at least
EXACT = (1e-13, 1e-14)  # of the independent solver
KNOWN = 2e-12  # to which the yardstick is, times the growth: the largest change with other steps of its own


def system_of(row: dict) -> vc.System:
    """The system of a row of the table."""
    levels = {"coulomb_coefficient": row["coulomb"], "static_coefficient": row["static"]}
    drop = {"stribeck_velocity": row["stribeck"], "stribeck_exponent": row["exponent"], "viscous_damping": 0.0}
    width = {"smoothing_velocity": row["width"]}
    laws = {
        "stribeck": lambda: vc.Stribeck(**levels, **drop),
        "exponential": lambda: vc.Exponential(**levels, decay_rate=1.0 / row["width"]),
        "hyperbolic": lambda: vc.HyperbolicStribeck(**levels, stribeck_velocity=row["width"], viscous_damping=0.0),
        "tanh": lambda: vc.SmoothedTanh(**levels, **drop, **width),
        "arctan": lambda: vc.SmoothedArctan(**levels, **drop, **width),
        "smoothed": lambda: smoothed(vc.Stribeck)(**levels, **drop, **width),
        "lugre": lambda: vc.LuGre(
            **levels, **drop, bristle_stiffness=row["bristle_stiffness"], bristle_damping=row["bristle_damping"]
        ),
    }
    if row["machine"] == "oscillator":
        settings = {"mass": 1.0, "stiffness": 1.0, "normal_load": 1.0, "belt_speed": row["belt"]}
        machine = vc.Oscillator(**settings, damping=row["damping"])
    else:
        settings = {name: row[name] for name in ("mass_ratio", "stiffness", "damping")}
        machine = vc.PendulumCapsule(**settings, normal_load=1.0)
    drive = vc.Harmonic(amplitude=row["amplitude"], frequency=row["frequency"])
    return vc.System(machine, laws[row["law"]](), drive)


def error_and_estimate(row: dict, tolerance: float) -> tuple[float, float]:
    """(error of the states at the marks, what the certificate says of it), of a motion with the right events."""
    system = system_of(row)
    start = dict(zip(system.state_names, row["marks"][0], strict=True))
    motion = vc.simulate(system, periods=TABLE["periods"], initial=start, tolerance=tolerance)
    certificate = motion.certificate
    assert certificate.ok, certificate.failures
    kinds = [event.kind for event in motion.events]
    if row["law"] in ("tanh", "arctan"):  # split where it turns if its power has no series there; the yardstick is not
        assert set(kinds) <= {"reversal"}
    else:
        assert kinds == [kind for _, kind in row["events"]]  # and no graze
    error = np.abs(motion.sections - row["marks"])
    assert error[-1].max() <= STEPS * tolerance * row["growth"] + KNOWN
    scales = np.ones(error.shape[1])
    if row["law"] == "lugre":  # the natural size of a bristle is its largest deflection
        scales[-1] = row["static"] / row["bristle_stiffness"]
    return float((error / scales).max()), certificate.estimated_error


def is_honest(row: dict, error: float, estimate: float) -> bool:
    return estimate >= SHARE * (error - KNOWN * row["growth"])


@pytest.mark.plain
@pytest.mark.parametrize(("number", "tolerance"), slow_but([0, 1], [(0, 1e-10), (1, 1e-8), (2, 1e-10), (1, 1e-6)]))
def test_examples(number, tolerance):
    """Powers of 1.5, 3 and 6: before, off by 35, 6,700 and 10^8 tolerances, the first certified with five grazes."""
    row = TABLE["examples"][number]
    assert is_honest(row, *error_and_estimate(row, tolerance))


KINDS = sorted({(row["law"], row["machine"]) for row in TABLE["systems"]})
FIRST = KINDS.index(("exponential", "oscillator"))


@pytest.mark.parametrize(
    ("law", "machine"), slow_but([FIRST], exhaustive_but({FIRST, *range(0, len(KINDS), 3)}, KINDS))
)
def test_a_motion_of_every_law_on_every_machine(law, machine):
    row = next(row for row in TABLE["systems"] if (row["law"], row["machine"]) == (law, machine))
    for tolerance in (1e-6, 1e-9, 1e-11):
        assert is_honest(row, *error_and_estimate(row, tolerance)), tolerance


LANES = [("stribeck", lambda power: power % 1.0), ("stribeck", lambda power: power == 6.0)]
LANES += [("exponential", lambda power: True), ("lugre", lambda power: power % 1.0)]


@pytest.mark.slow
@pytest.mark.parametrize(("law", "kept"), slow_but([], exhaustive_but([0, 2], LANES)))
def test_lanes_see_what_single_motions_see(law, kept):
    """The same systems side by side end where the yardstick ends."""
    rows = [row for row in TABLE["systems"] if row["law"] == law and row["machine"] == "oscillator"]
    rows = [row for row in rows if kept(row["exponent"])]
    systems = [system_of(row) for row in rows]
    budget = Budget(TABLE["periods"], 1e-9, 10_000, 10_000_000, window=1)
    values = np.array([parameter_values(system) for system in systems])
    results = ensemble_run(
        EnsembleStart(equations(systems[0]), values, np.array([row["marks"][0] for row in rows])), budget
    )
    assert np.all(results.finished)
    for final, row in zip(results.state, rows, strict=True):
        assert np.abs(final - row["marks"][-1]).max() <= STEPS * 1e-9 * row["growth"]


def test_powers_without_a_whole_series_at_rest_are_found_in_the_recorded_graph():
    """Of the contact velocity; from the second on a whole power has few terms from rest, 1.7 has no series."""

    def found(law, kind=vc.PendulumCapsule):
        recorded = equations(vc.System(kind(), law, vc.Harmonic()))
        sharp = system_sharpness(recorded)[0].nodes
        powers = sorted(power for _, power in gaps(recorded, sharp).values())
        return powers, no_series_at_rest(recorded.contacts[0].velocity, recorded.rates)

    def stribeck(exponent):
        return vc.Stribeck(stribeck_exponent=exponent, viscous_damping=0.0)

    assert found(vc.Coulomb()) == ([], False)
    assert found(vc.Exponential()) == ([], False)
    assert found(vc.HyperbolicStribeck()) == ([], False)
    assert found(stribeck(2.0)) == ([2], False)
    assert found(stribeck(3.0)) == ([3], False)
    assert found(stribeck(8.0)) == ([8], False)
    assert found(vc.anisotropic(vc.Stribeck)(stribeck_exponent=5.0, viscous_damping=0.0)) == ([5], False)
    assert found(stribeck(1.7)) == ([], True)
    assert found(vc.LuGre(stribeck_exponent=3.0))[0][0] == 3
    assert found(vc.SmoothedTanh(stribeck_exponent=2.7)) == ([], True)
    assert found(vc.RateAndStateAgeing()) == ([2], False)
    for laws in ([stribeck(3.0), vc.Coulomb()], [vc.Coulomb(), stribeck(3.0)]):  # at whichever contact
        assert found(laws, vc.TwoBodyCrawler)[0] == [3]


# --- several contacts -------------------------------------------------------------------------------------------------

SHAKEN = vc.Biharmonic(amplitude=1.5, frequency=0.8, second_amplitude=0.7, second_phase=0.5)
GAIT = vc.Biharmonic(amplitude=0.5, frequency=0.8, second_amplitude=0.4, second_phase=0.5)
MACHINES = {
    "row": (vc.TwoBlockRow(belt_speed=0.3), vc.Harmonic(amplitude=1.0)),
    "crawler": (vc.TwoBodyCrawler(mass_2=2.0), SHAKEN),
    "worm": (vc.TwoBodyWorm(mass_2=2.0), GAIT),
    "three bodies": (vc.ThreeBodyCrawler(mass_2=1.5, normal_load_3=2.0, actuation_2=-0.5), vc.Harmonic(amplitude=1.0)),
    "linkage": (vc.LinkageCrawler(mass_ratio_2=1.7, stiffness=4.0), vc.Biharmonic(0.5, 1.3, 0.15, 0.5)),
    "oscillator": (vc.Oscillator(belt_speed=0.3), vc.Harmonic(amplitude=1.0)),
    "capsule": (vc.PendulumCapsule(), vc.Harmonic()),
    "capsule under its load": (vc.PendulumCapsule(normal_load="dynamic"), vc.Harmonic()),
}


def droop(exponent: float) -> vc.Stribeck:
    return vc.Stribeck(0.15, 0.45, 0.1, exponent)


def run(machine, laws, drive, tolerance, periods=5):
    """A certified motion."""
    law = laws if len(machine.contact_states) > 1 else laws[0]
    motion = vc.simulate(vc.System(machine, law, drive), periods=periods, tolerance=tolerance)
    assert motion.status is vc.Status.FINISHED
    assert motion.certificate.ok, motion.certificate.failures
    return motion


PLACES = [(name, contact) for name, (one, _) in MACHINES.items() for contact in range(min(2, len(one.contact_states)))]


@pytest.mark.slow
@pytest.mark.parametrize(("name", "first"), exhaustive_but([1, 12], PLACES))
@pytest.mark.parametrize("exponent", exhaustive_but([0], [1.1, 1.5, 2.9]))
def test_a_power_costs_little_more_than_a_square_at_any_contact(name, first, exponent):
    """Before, it did not finish at a second contact in sweeps, and took 3 to 10 times the steps elsewhere."""
    machine, drive = MACHINES[name]
    count = len(machine.contact_states)
    for tolerance in (1e-6, 1e-9):
        steps = []
        for alpha in (exponent, 2.0):
            laws = [vc.Coulomb()] * count
            laws[first] = droop(alpha)
            steps.append(run(machine, laws, drive, tolerance).certificate.taylor_steps)
        assert steps[0] <= 4.0 * steps[1]


# Laws that stick and smooth ones, exponents from 1.1 to 2.9 at either contact.
POWERS = {
    "row": [droop(1.2), vc.Stribeck(0.12, 0.3, 0.02, 2.7)],
    "crawler": [vc.SmoothedTanh(0.15, 0.3, 0.05, 1.4, 0.02), droop(2.3)],
    "worm": [droop(1.5), vc.Stribeck(0.2, 0.3, 0.03, 1.1)],
    "oscillator": [vc.SmoothedTanh(0.15, 0.35, 0.03, 1.1, 0.01)],  # |v|^2.2 at rest
}


@pytest.mark.plain
@pytest.mark.parametrize("name", slow_but([3], exhaustive_but([1, 3], [*POWERS])))
def test_powers_at_any_contact_against_an_independent_solver(name):
    """Ends and events of three periods."""
    machine, drive = MACHINES[name]
    laws = POWERS[name]
    system = vc.System(machine, laws, drive)
    expected = independent_motion(system, {}, 3, EXACT)
    sticks = [law.kind == "set-valued" for law in laws]
    for tolerance in (1e-6, 1e-9):
        found = run(machine, laws, drive, tolerance, periods=3)
        off = [abs(found.state[key] - value) for key, value in expected.state.items()]
        assert max(off) <= STEPS * tolerance, tolerance
        turns = {event.kind for event in found.events if event.contact == 1}
        assert sticks[0] or turns == {"reversal"}  # where a smooth law is split, as its power has no series there
        kinds = Counter(str(event.kind) for event in found.events if sticks[event.contact - 1])
        assert kinds == Counter(kind for kind, contact in map(numbered_kind, expected.events) if sticks[contact - 1])


def numbered_kind(event):
    """(kind, contact) of an event of the independent solver."""
    kind = event[1]
    return kind, int(kind[-1]) if kind[-2:-1] == "_" else 1


def test_answers_of_two_tolerances_agree_to_what_they_promise():
    """A contact that sticks shortly: before, certified answers were off by 27 times the estimate of their error."""
    right = -41.64967992
    for tolerance in (1e-8, 1e-9):
        result = run(MACHINES["crawler"][0], [droop(1.5)] * 2, SHAKEN, tolerance, periods=40)
        assert abs(result.sections[-1, 2] - right) <= result.certificate.estimated_error + 3e-9


def test_a_power_below_one_is_kept_at_rest_only_while_it_is_negligible():
    """Its slope is infinite there: before, such ends were up to 2e-2 off at tight tolerances, and not certified."""
    right = (1.9818659404131, 0.5381036722169, -2.0665635114011, -1.2743417423905)  # by independent.py
    result = run(MACHINES["crawler"][0], [vc.Coulomb(), droop(0.7)], SHAKEN, 1e-11, periods=3)
    assert np.abs(result.sections[-1] - right).max() <= STEPS * 1e-11
    assert len(result.events) == 17


def test_what_a_law_stores_and_forgets_is_known_of_any_contact():
    """A branch that begins unloaded loses what the contact stored, at whichever contact; before, at the first only."""
    law = vc.backlash(vc.Dahl)()
    for laws in ([law, vc.Coulomb()], [vc.Coulomb(), law]):
        recording = equations(vc.System(vc.TwoBlockRow(), laws, vc.Harmonic()))
        assert loses_at_switches(recording)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "step"), exhaustive_but([0], [("stribeck_exponent", 1e-4), ("stribeck_velocity", 1e-5)])
)
def test_gradients_over_the_numbers_of_a_power(name, step):
    """A tangent starts from rest as the motion does: |v|^(alpha - 1) and |v|^alpha log|v| have no series there."""

    def orbit(shift):
        return vc.orbit(
            vc.System(vc.PendulumCapsule(), dataclasses.replace(law, **{name: value + shift}), vc.Harmonic())
        )

    law = droop(1.5)
    value = getattr(law, name)
    (slope,) = orbit(0.0).gradients([f"friction.{name}"]).slopes
    difference = (orbit(step).mean_velocity - orbit(-step).mean_velocity) / (2.0 * step)
    assert slope.slope == pytest.approx(difference, rel=1e-6)
