"""The series from equations of motion as they are told are those of the solved equations, in exact arithmetic."""

import itertools
import math
import random
import types

import mpmath
import numpy as np
import pytest

import vibrocap as vc
from mechanisms import ElasticSkin, RodRobot
from thinned import exhaustive_but, slow_but
from vibrocap.motion.recording.equations import equations, parameter_values
from vibrocap.numerics.codegen.jets import JetWriter, shortest
from vibrocap.numerics.kernel.arithmetic.plain_vectors import where
from vibrocap.physics.catalogue import machines

EPSILON = 2.0**-52
ORDER = 6
LAWS = {"exponential": vc.Exponential(), "lugre": vc.LuGre(viscous_damping=0.1)}
MACHINES = {name: kind() for name, kind in machines().items()}
MACHINES |= {"capsule, dynamic": vc.PendulumCapsule(normal_load="dynamic"), "skin": ElasticSkin(), "rods": RodRobot()}
# Where the text of the equations as told is the shorter one: at most this share of the operations of the solved ones.
SHARES = {"pendulum-capsule": 0.93, "capsule, dynamic": 0.73, "two-pendulum-capsule": 0.7}
SHARES |= {"linkage-crawler": 0.35, "double-pendulum-capsule": 0.68, "bristle-robot": 0.98}  # of the solved text
MOST = {"linkage-crawler": 923, "bristle-robot": 1553}  # operations of the told text, whatever the solved one has
FAST = [[*MACHINES].index(name) for name in ("pendulum-capsule", "capsule, dynamic", "linkage-crawler")]


def coefficients(recorded, mechanics, roots, state, values, mode, exact):
    """[roots, order + 1] of the series at a state, in numbers of 40 digits or in those of a processor."""
    writer = JetWriter(recorded.graph, list(recorded.rates), mechanics=mechanics)
    texts = [[writer.coefficient(root.index, k).text for k in range(ORDER + 1)] for root in roots]
    number, library = (mpmath.mpf, mpmath) if exact else (float, math)
    functions = {name: getattr(library, name) for name in ("sin", "cos", "exp", "log", "sqrt", "tanh", "atan")}
    names = {"math": types.SimpleNamespace(**functions, inf=math.inf), "where": where, "time": number(0.3)}
    names |= {"STATE": 0, "PARAMETER": len(state), "LANES": 1, "lane": 0, "floats": [*map(number, (*state, *values))]}
    names |= {f"sliding_{i}": number(side) for i, side in enumerate(mode)}
    with mpmath.workdps(40):
        exec("\n".join(writer.code.lines), names)
        return [[eval(text, names) for text in row] for row in texts]


def ways(recorded):
    """How the series of these equations may be written besides solved."""
    whole = JetWriter(recorded.graph, list(recorded.rates), mechanics=recorded.mechanics).mechanics
    return [] if whole is None else [recorded.mechanics, whole.reduced()]


def largest_error(system, draw, mode):
    """Of all ways, over what the coefficients of a state have come to, at a random state in a mode."""
    recorded = equations(system)
    state = [draw.uniform(-0.3, 0.3) for _ in recorded.rates]
    for i, name in enumerate(system.state_names):
        if name in system.placed.switched:
            state[i] = float(draw.choice((-1, 0, 1)))
    for contact, side in zip(recorded.contacts, mode, strict=True):
        state[contact.state] = side * (0.05 + abs(state[contact.state]))
        for i in contact.internal:
            state[i] *= 0.01
    roots = [recorded.graph.node("state", i) for i in range(len(state))]
    roots += [recorded.contacts[0].friction, *recorded.true_loads.values()]
    rest = [contact for contact, side in zip(recorded.contacts, mode, strict=True) if side == 0]
    roots += [value for each in rest for value in (each.hold, each.limit)]
    at = state, parameter_values(system), mode
    exact = coefficients(recorded, None, roots, *at, exact=True)
    values = [*map(recorded.by_momenta, roots)]
    size = np.maximum.accumulate(np.abs(np.array(exact, dtype=float)).max(axis=0))
    return max(
        float(abs(value - wanted)) / over
        for way in (None, *ways(recorded))
        for own, right in zip(coefficients(recorded, way, values, *at, exact=False), exact, strict=True)
        for value, wanted, over in zip(own, right, size, strict=True)
    )


def systems(machine):
    """Of a machine with each law: alone, and, on the ground, pushed and behind an actuator."""
    for law in LAWS.values():
        yield vc.System(machine, law, vc.Harmonic())
        if machine.over_ground and not machine.imposes_motion:
            outside = vc.Environment(force=0.1, linear_drag=0.2)
            yield vc.System(machine, law, vc.Harmonic(), environment=outside, actuator=vc.Actuator(0.3))


def modes(system):
    """Of all contacts of a system."""
    sides = [(0, 1, -1) if contact.sticks else (1, -1) for contact in equations(system).contacts]
    return list(itertools.product(*sides))


@pytest.mark.parametrize("name", slow_but(FAST, exhaustive_but({*FAST, *range(0, len(MACHINES), 3)}, [*MACHINES])))
def test_told_and_solved_equations_give_one_series(name):
    """To rounding: states, impulse of friction, true load; of contacts at rest what holds them, what they can hold."""
    draw = random.Random(1)
    for system in systems(MACHINES[name]):
        if ways(equations(system)):
            for mode in draw.sample(modes(system), 2):
                assert largest_error(system, draw, mode) < 1e3 * EPSILON


def test_the_shorter_text_is_taken():
    """By its operations: told where bodies act on one another, solved where each moves by itself."""

    def operations(system, mechanics):
        recorded = equations(system)
        return JetWriter(recorded.graph, list(recorded.rates), mechanics=mechanics).operations()

    for name, share in SHARES.items():
        system = vc.System(MACHINES[name], LAWS["exponential"], vc.Harmonic())
        chosen = shortest(equations(system))
        assert chosen is not None
        assert operations(system, chosen) <= min(share * operations(system, None), MOST.get(name, math.inf))
    for name in ("vibro-impact-capsule", "two-body-worm"):
        assert shortest(equations(vc.System(MACHINES[name], LAWS["exponential"], vc.Harmonic()))) is None
