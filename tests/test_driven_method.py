"""The step of a driven law: its linear algebra, its order through a turn, and one source however it runs."""

from unittest import mock

import numpy as np
import pytest

import vibrocap as vc
from driven_laws import Play, on_plain_python, uneven, wandering
from vibrocap.laboratory.driven import driven_equations
from vibrocap.numerics.codegen.driven_source import decomposition, solution
from vibrocap.numerics.run.driven_run import driven_runs


@pytest.mark.parametrize("holes", [(), ((1, 2), (2, 1)), ((0, 3), (1, 3), (2, 0), (2, 3), (3, 0))])
def test_linear_equations_are_solved_entry_by_entry(holes):
    """The written elimination against NumPy's, with entries that only fill in and with none at all."""
    size, rng = 4, np.random.default_rng(10)
    jacobian = rng.normal(size=(size, size))
    for hole in holes:
        jacobian[hole] = 0.0
    entries = {(i, j) for i in range(size) for j in range(size) if (i, j) not in holes}
    right, names = rng.normal(size=size), {"inverse": 5.0}
    names |= {f"j{i}_{j}": jacobian[i, j] for i, j in entries} | {f"r{i}": right[i] for i in range(size)}
    lines, filled = decomposition(entries, size)
    exec("\n".join(lines + solution(filled, size, 0)), names)
    expected = np.linalg.solve(5.0 * np.eye(size) - jacobian, right)
    assert [names[f"k0_{i}"] for i in range(size)] == pytest.approx(expected, rel=1e-12)


# --- the order of the method -----------------------------------------------------------------------------------------

MILD = vc.LuGre(10.0, 4.0, 0.3, 0.15, 0.45, stribeck_velocity=0.5)
RAMP = np.array([0.35, -0.45]), np.array([1.0, 1.6])  # velocity and load at both ends; it turns on the way
LENGTH = 3.0


def equal_steps(count, faults=None):
    """Bristle at the end of the ramp, by so many equal intervals without error control: each is one step."""
    equations = driven_equations(MILD, ())
    shares = np.linspace(0.0, 1.0, count + 1)
    velocity, load = (ends[0] + shares * (ends[1] - ends[0]) for ends in RAMP)
    signals = np.stack([shares * LENGTH, velocity, load])
    values = np.array([[getattr(MILD, name) for name in equations.parameter_names]])
    with on_plain_python(MILD) as names, mock.patch.dict(names, faults(names, LENGTH / count) if faults else {}):
        runs = driven_runs(equations, values, np.array([[0.01]]), signals, 1e9, threads=1, keep_internal=True)
    assert runs.internal is not None
    assert faults or runs.steps[0] == count + 1  # the turn cuts one
    return runs.internal[0, -1, 0]


COUNTS = (9, 13, 19, 27, 39)


def slope(faults=None):
    """Order from errors against many steps of the same kind."""
    exact = equal_steps(1001)
    errors = [abs(equal_steps(count, faults) - exact) for count in COUNTS]
    return -np.polyfit(np.log(COUNTS), np.log(errors), 1)[0]


def time_derivative_lost(names, step):
    def unforced(*point):
        *own, _ = names_slopes(*point)
        return (*own, 0.0)

    names_slopes = names["slopes"]
    return {"slopes": unforced}


def stage_late(names, step):
    rates, rate = names["rates"], (RAMP[0][1] - RAMP[0][0]) / LENGTH
    return {"rates": lambda z, v, *rest: rates(z, v + 0.01 * step * rate, *rest)}


def turn_missed(names, step):
    """The side changes where the interval ends."""
    sign = names["sign"]
    signs = []

    def late(v):
        signs.append(sign(v))
        return signs[-1] if len(signs) < 2 or signs[-1] == signs[-2] else signs[-2]

    return {"sign": late}


def test_order_through_a_turn():
    assert slope() == pytest.approx(5.0, abs=0.15)


@pytest.mark.parametrize("fault", [time_derivative_lost, stage_late, turn_missed])
def test_planted_faults_are_rejected(fault):
    assert abs(slope(fault) - 5.0) > 0.6


# --- one source -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("law", [vc.LuGre(bristle_stiffness=1e4), Play()])
def test_plain_python_is_the_compiled_kernel(law):
    """The same steps; numbers differ by fused multiply-adds and the compiler's exp."""
    rng = np.random.default_rng(6)
    time = uneven(rng, 60, 2.0)
    signals = np.stack([time, wandering(rng, time, 0.3), 1.0 + 0.2 * np.cos(time)])
    equations = driven_equations(law, ())
    values = np.array([[getattr(law, name) for name in equations.parameter_names]])
    start = np.zeros((1, len(law.internal)))
    plain, compiled = (
        driven_runs(equations, values, start, signals, 1e-8, 1, keep_internal=True, plain=plain)
        for plain in (True, False)
    )
    assert plain.steps == compiled.steps
    assert plain.steps[0] > 60
    assert plain.refused == compiled.refused
    size = np.abs(compiled.force).max()
    assert plain.force == pytest.approx(compiled.force, abs=1e-12 * size)
    assert plain.internal == pytest.approx(compiled.internal, abs=1e-12)
