"""Laws with any power of the speed that change within a small speed, against an independent solver.

Yardstick: `sharp_powers.py`, whose motions are stored. A contact that leaves rest has v = c t^2, and |v|^alpha has a
Taylor series there for few alpha, whose terms are few and far between; what is lost in the first of steps grows by all
that friction falls later.
"""

import json
from pathlib import Path

import numpy as np
import pytest

import vibrocap as vc
from thinned import exhaustive_but, slow_but
from vibrocap.motion.recording.equations import equations, parameter_values
from vibrocap.numerics.codegen.resolution import system_sharpness
from vibrocap.numerics.expressions.structure import gaps, no_series_at_rest
from vibrocap.numerics.run.ensemble import Budget, ensemble_run
from vibrocap.physics.friction.smoothed import smoothed

TABLE = json.loads(Path(__file__).with_name("sharp_powers.json").read_text(encoding="utf-8"))
TOLERANCES = (1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11)
STEPS = 30.0  # tolerances, times what a shift of the start grows to
SHARE = 1.0 / 3.0  # of the error that an estimate of it has at least
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
        given = {"mass": 1.0, "stiffness": 1.0, "normal_load": 1.0, "belt_speed": row["belt"]}
        machine = vc.Oscillator(**given, damping=row["damping"])
    else:
        given = {name: row[name] for name in ("mass_ratio", "stiffness", "damping")}
        machine = vc.PendulumCapsule(**given, normal_load=1.0)
    drive = vc.Harmonic(amplitude=row["amplitude"], frequency=row["frequency"])
    return vc.System(machine, laws[row["law"]](), drive)


def error_and_estimate(row: dict, tolerance: float) -> tuple[float, float]:
    """(error of the states at the marks, what the certificate says of it), of a motion with the right events."""
    system = system_of(row)
    start = dict(zip(system.state_names, row["marks"][0], strict=True))
    motion = vc.simulate(system, periods=TABLE["periods"], initial=start, tolerance=tolerance)
    certificate = motion.certificate
    assert certificate.ok, certificate.failures
    events = [(event.time, event.kind) for event in motion.events]
    assert [kind for _, kind in events] == [kind for _, kind in row["events"]]  # and no graze
    error = np.abs(motion.sections - row["marks"])
    assert error[-1].max() <= STEPS * tolerance * row["growth"] + KNOWN
    scales = np.ones(error.shape[1])
    if row["law"] == "lugre":  # the natural size of a bristle is its largest deflection
        scales[-1] = row["static"] / row["bristle_stiffness"]
    return float((error / scales).max()), certificate.estimated_error


def is_honest(row: dict, error: float, estimate: float) -> bool:
    return estimate >= SHARE * (error - KNOWN * row["growth"])


@pytest.mark.parametrize(("number", "tolerance"), slow_but([0, 1], [(0, 1e-10), (1, 1e-8), (2, 1e-10), (1, 1e-6)]))
def test_examples(number, tolerance):
    """Powers of 1.5, 3 and 6: before, off by 35, 6,700 and 10^8 tolerances, the first certified with five grazes."""
    row = TABLE["examples"][number]
    assert is_honest(row, *error_and_estimate(row, tolerance))


def is_quick(row: dict) -> bool:
    """Few forms of equations, so that few kernels are compiled: the others run before a release."""
    rough_power = row["exponent"] != round(row["exponent"])
    return (row["law"] == "stribeck" and (rough_power or row["machine"] == "oscillator")) or (
        row["law"] in ("tanh", "smoothed") and rough_power and row["machine"] == "oscillator"
    )


@pytest.mark.slow
@pytest.mark.parametrize("fifth", range(5))
def test_thirty_motions(fifth):
    rows = [row for row in TABLE["systems"] if is_quick(row)][:30]
    assert len(rows) == 30
    for row in rows[fifth::5]:
        for tolerance in (1e-6, 1e-9, 1e-11):
            assert is_honest(row, *error_and_estimate(row, tolerance)), (row["seed"], tolerance)


@pytest.mark.exhaustive
@pytest.mark.parametrize("tenth", range(10))
def test_two_hundred_motions(tenth):
    """The errors of all, and of the estimates 19 in 20."""
    assert len(TABLE["systems"]) == 200
    found = [
        is_honest(row, *error_and_estimate(row, tolerance))
        for row in TABLE["systems"][tenth::10]
        for tolerance in TOLERANCES
    ]
    assert sum(found) >= 0.95 * len(found)


@pytest.mark.slow
@pytest.mark.parametrize("whole", slow_but([], exhaustive_but([0], [False, True])))
def test_lanes_see_what_single_motions_see(whole):
    """The same systems side by side end where the yardstick ends."""
    rows = [row for row in TABLE["systems"] if row["law"] == "stribeck" and row["machine"] == "oscillator"]
    rows = [row for row in rows if (row["exponent"] == 6.0 if whole else row["exponent"] != round(row["exponent"]))]
    systems = [system_of(row) for row in rows]
    budget = Budget(TABLE["periods"], 1, 0.0, 1e-9, 10_000, 10_000_000)
    values = np.array([parameter_values(system) for system in systems])
    results = ensemble_run(equations(systems[0]), values, np.array([row["marks"][0] for row in rows]), budget)
    assert np.all(results.finished)
    for final, row in zip(results.state, rows, strict=True):
        assert np.abs(final - row["marks"][-1]).max() <= STEPS * 1e-9 * row["growth"]


def test_powers_without_a_whole_series_at_rest_are_found_in_the_recorded_graph():
    """Of the contact velocity; the third power has few terms from rest, 1.7 has no series, the first two are quick."""

    def found(law):
        recorded = equations(vc.System(vc.PendulumCapsule(), law, vc.Harmonic()))
        sharp = system_sharpness(recorded).nodes
        powers = sorted(power for _, power in gaps(recorded, sharp).values())
        return powers, no_series_at_rest(recorded.contact_velocity, recorded.rates)

    def stribeck(exponent):
        return vc.Stribeck(stribeck_exponent=exponent, viscous_damping=0.0)

    assert found(vc.Coulomb()) == ([], False)
    assert found(vc.Exponential()) == ([], False)
    assert found(vc.HyperbolicStribeck()) == ([], False)
    assert found(stribeck(2.0)) == ([], False)
    assert found(stribeck(3.0)) == ([3], False)
    assert found(stribeck(8.0)) == ([8], False)
    assert found(vc.anisotropic(vc.Stribeck)(stribeck_exponent=5.0, viscous_damping=0.0)) == ([5], False)
    assert found(stribeck(1.7)) == ([], True)
    assert found(vc.LuGre(stribeck_exponent=3.0))[0][0] == 3
    assert found(vc.SmoothedTanh(stribeck_exponent=2.7)) == ([], True)
    assert found(vc.RateAndStateAgeing()) == ([], False)
