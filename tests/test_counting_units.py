"""The units in which a machine is counted are nobody's business: no result in SI depends on them.

A capsule with an inner mass is counted in a centimetre and sqrt(l/g), or in other lengths and times; every number that
comes back in SI is the same, to the errors of integration, which are measured over other sizes. A number that is not
scaled, or scaled twice, differs by a factor of the units.
"""

import dataclasses
import enum
from collections.abc import Mapping

import numpy as np
import pytest

import vibrocap as vc
from thinned import exhaustive_but

LIKE = 1e-5  # at tolerances of 1e-10 and less; the units differ by factors of 2.2 and more
COUNTED = ({"length_unit_m": 0.01}, {"length_unit_m": 0.023, "time_unit_s": 0.071})
OVER = "drive.frequency_Hz"
# numbers of the integration, and of how surely a number is known
OF_THE_RUN = {"certify", "certificate", "steps", "noise", "error", "residual", "reason", "ratio", "remaining"}
OF_THE_RUN |= {"population", "scale", "scales", "facts", "text", "system", "coefficients", "series", "observe"}
OF_THE_RUN |= {"slopes", "counts"}
# where a run or a branch made its steps, and how many a search took: rounding decides whether one more
STEPPED = {"arclength", "parts", "start", "taylor_steps", "iterations"}


def counted(units) -> vc.System:
    return vc.System(
        machine=vc.TwoMassCapsule.in_si(
            inner_mass_kg=0.1,
            capsule_mass_kg=0.3,
            stiffness_N_per_m=100.0,
            damping_N_s_per_m=0.3,
            normal_load_N=2.0,
            **units,
        ),
        friction=vc.Stribeck.in_si(coulomb_coefficient=0.2, static_coefficient=0.3, stribeck_velocity_m_per_s=0.02),
        drive=vc.Biharmonic.in_si(amplitude_N=1.0, second_amplitude_N=0.5, frequency_Hz=5.0),
        environment=vc.Environment.in_si(inclination_deg=0.0),
    )


@pytest.fixture(scope="module")
def systems():
    return [counted(units) for units in COUNTED]


@pytest.fixture(scope="module")
def motions(systems):
    return [vc.simulate(variant, periods=30, tolerance=1e-11) for variant in systems]


def differences(a, b, path=""):
    """Paths of the numbers of two results that differ."""
    if isinstance(a, (str, bool, enum.Enum, type(None), vc.System)):
        return []
    if isinstance(a, (int, float, complex, np.number, np.ndarray)):
        a, b = np.atleast_1d(np.asarray(a)), np.atleast_1d(np.asarray(b))
        if a.dtype.kind not in "fciu" or a.shape != b.shape:  # of other shapes: they were made in other steps
            return []
        size = max(np.max(np.abs(a[np.isfinite(a)]), initial=0.0), 1e-7)
        return [] if np.allclose(a, b, rtol=LIKE, atol=LIKE * size, equal_nan=True) else [(path, a, b)]
    if isinstance(a, Mapping):
        return [
            difference for key in a.keys() & b.keys() for difference in differences(a[key], b[key], f"{path}[{key!r}]")
        ]
    if isinstance(a, (tuple, list)):
        pairs = enumerate(zip(a, b, strict=True)) if len(a) == len(b) else ()
        return [difference for i, (x, y) in pairs for difference in differences(x, y, f"{path}[{i}]")]
    if not dataclasses.is_dataclass(a):
        return []
    members = {field.name for field in dataclasses.fields(a)} | {
        name for name in dir(type(a)) if isinstance(getattr(type(a), name), property)
    }
    names = sorted(member for member in members - OF_THE_RUN - STEPPED if not member.startswith(("_", "piece_")))
    own = [key for key in names if key not in ("dimensionless", "mean_power", "per_period", "peak")]
    return [
        difference for name in own for difference in differences(getattr(a, name), getattr(b, name), f"{path}.{name}")
    ]


def columns(dataset):
    return {str(name): variable.values for name, variable in dataset.variables.items() if variable.dtype.kind in "fc"}


OF_MOTIONS = {
    name: getattr(vc, name)
    for name in [
        "displacement",
        "drift",
        "mean_velocity",
        "winding",
        "settling",
        "response_class",
        "energy_balance",
        "stick_fraction",
        "stick_phases",
        "friction_loop",
    ]
} | {
    "the motion": lambda motion: motion,
    "its power": lambda motion: [vc.energy_balance(motion).mean_power, vc.energy_balance(motion).per_period],
    "all measures": lambda motion: vc.measured(motion, list(vc.measure_table(motion.system))),
    "a moment": lambda motion: [
        motion.at(0.5, "velocity"),
        motion.states([0.1, 0.2]),
        motion.crossings("velocity", 0.02),
    ],
    "a window": lambda motion: vc.energy_balance(motion, window=(1.0, 2.0)),
}
OF_SYSTEMS = {  # those of commands, in SI and without units, stand in `test_views.py`
    "contacts": lambda system: vc.contact_modes(system, {"velocity": 0.01}, time=0.02),
    "attractors": lambda system: vc.attractors(system, 20, ranges={"velocity": (-0.1, 0.1)}),
    "diagram": lambda system: vc.bifurcation_diagram(system, OVER, (4.5, 5.5), 3),
    "smoothing": lambda system: vc.regularisation_error(system, widths=(0.01,)),
    "width": lambda system: vc.width_for(system, error=0.2),
    "width for a speed": lambda system: vc.width_for(system, "mean_velocity", error=1e-3, relative=False),
    "ensemble": lambda system: vc.ensemble(system, {OVER: [4.9, 5.0]}, measures=["mean_velocity", "drive_work"]),
    "sweep": lambda system: columns(
        vc.sweep(
            system, {OVER: [4.9, 5.0]}, measures=["drift", "cost_of_transport"], periods=60, tolerance=1e-8, settle=0
        )
    ),
    "bounds": vc.performance_bounds,
    "gradients": lambda system: (
        vc.orbit(system)
        .gradients(
            [OVER, "machine.stiffness_N_per_m", "friction.stribeck_velocity_m_per_s"], ["drift", "cost_of_transport"]
        )
        .to_pandas()
        .select_dtypes("number")
        .to_dict("list")
    ),
    "front": lambda system: vc.pareto_front(system, {OVER: (4.0, 6.0)}, evaluations=40, points=3).values,
}


@pytest.mark.parametrize("name", OF_MOTIONS)
def test_what_a_motion_says_is_counted_in_no_units(motions, name):
    a, b = map(OF_MOTIONS[name], motions)
    assert differences(a, b) == []


KEPT = ("contacts", "attractors", "width for a speed", "ensemble", "gradients", "bounds")


@pytest.mark.slow
@pytest.mark.parametrize("name", exhaustive_but(map([*OF_SYSTEMS].index, KEPT), [*OF_SYSTEMS]))
def test_what_a_system_does_is_counted_in_no_units(systems, name):
    a, b = map(OF_SYSTEMS[name], systems)
    assert differences(a, b) == []
    assert "Error" not in repr(a)  # and it can be shown


def test_the_comparison_sees_a_number_that_is_not_scaled(motions):
    plain = [run.dimensionless for run in motions]
    assert {path for path, *_ in differences(*plain)} >= {".end", ".period"}
    assert [path for path, *_ in differences(*map(vc.mean_velocity, plain))]
