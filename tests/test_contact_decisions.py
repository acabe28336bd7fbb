"""Which contacts rest and which slide where: against an independent solver, and all modes tried."""

import collections
import functools
from unittest import mock

import numpy as np
import pytest

import vibrocap as vc
from independent import decided, random_problem
from independent import motion as independent_motion
from plain_kernels import kernel_of
from thinned import exhaustive_but
from vibrocap.numerics.kernel.events.transitions import ARRIVED

TOLERANCE = 1e-10


@pytest.mark.slow
def test_a_linkage_does_not_lift_off_at_a_mode_that_is_only_tried():
    """Its one consistent mode has the loads 0.69 and 1.18; a run said "lift off"."""
    machine = vc.LinkageCrawler(
        0.7390469690451256, 0.6378975579718758, 3.748193676517796, 0.15251608496499786, 1.0338485014112793
    )
    laws = vc.Coulomb(0.1317464388578602, 0.19534951279671986), vc.Coulomb(0.23665875866094122, 0.40745976085955493)
    system = vc.System(machine, list(laws), vc.Square(amplitude=0.49717137376395265, frequency=2.4522025270561825))
    start = {
        "displacement": -0.08592786490476095,
        "velocity_2": 0.08587628822090053,
        "position": -0.149425812111275,
        "velocity": -0.09232250209287096,
    }
    run = vc.simulate(system, initial=start, periods=4, tolerance=TOLERANCE)
    assert run.status is vc.Status.FINISHED
    assert run.certificate.ok, run.certificate.failures


RAMPED = [vc.TwoBodyCrawler(mass_2=1.4), vc.ThreeBodyCrawler(normal_load_3=1.3), vc.LinkageCrawler(stiffness=4.0)]
RAMPED_ON = [vc.Coulomb(0.1, 0.15), vc.LuGre(coulomb_coefficient=0.1, static_coefficient=0.15)]


@pytest.mark.slow
@pytest.mark.parametrize("machine", exhaustive_but([0], RAMPED), ids=lambda machine: machine.name)
@pytest.mark.parametrize("law", exhaustive_but([0], RAMPED_ON))
def test_a_ramp_on_several_contacts_is_certified(machine, law):
    """A saw-tooth, whose force jumps where a period ends."""
    system = vc.System(machine, law, vc.Ramp(rate=0.15, start=-0.1, duration=5.0))
    run = vc.simulate(system, periods=3, initial={"velocity": 0.1}, tolerance=TOLERANCE)
    assert run.status is vc.Status.FINISHED
    assert len(run.events) > 3
    assert run.certificate.ok, run.certificate.failures
    theirs = independent_motion(system, {"velocity": 0.1}, 3)
    for name in machine.states:
        assert run.state[name] == pytest.approx(theirs.state[name], abs=100.0 * TOLERANCE)


# --- decisions by themselves ------------------------------------------------------------------------------------------


@functools.cache
def contacts_of(n):
    """A plain kernel with so many contacts, which are told what accelerates them and what they hold."""
    return kernel_of(vc.System(vc.crawler(n)(), vc.Coulomb(), vc.Harmonic()), order=8)


def groups(response):
    """Of each contact the first that friction, at whatever remove, has to do with it."""
    reach = np.linalg.matrix_power(np.abs(response) + np.eye(len(response)), len(response)) > 0.0
    return tuple(int(np.argmax(row)) for row in reach)


def kernel_decision(problem, asked, came, sides):
    """Sides of all contacts as the kernel decides them; () where it finds none, or several."""
    n = len(sides)
    kernel = contacts_of(n)
    names = kernel.names

    def rows(floats, _t, _point, _lane, out):
        values = [*problem.free, *problem.response.ravel(), *problem.loads]
        for each in zip(problem.sliding, problem.least, problem.most, problem.down, problem.up, strict=True):
            values += [each[0], 0.0, 0.0, *each[1:]]
        values += [*problem.raised.ravel()]
        floats[out : out + len(values)] = values

    likes = [next(j for j in range(n) if np.array_equal(problem.response[j], problem.response[i])) for i in range(n)]
    settings = {"contact_rows": rows, "DYNAMIC": bool(problem.raised.any())}
    settings |= {"GROUP": (0,) * n} if problem.raised.any() else {"GROUP": groups(problem.response)}
    settings |= {"SHARED": len(set(likes)) < n, "STICKS": (1,) * n}
    with mock.patch.dict(names, settings):
        kernel.fill("STATUS", 0)
        kernel.fill("SIDE", [0.0 if i in asked else float(sides[i]) for i in range(n)])
        kernel.fill("CAME_FROM", [float(sides[i]) if i in came else 0.0 for i in range(n)])
        kernel.fill("GAVE_WAY", [0] * n)
        kernel.fill("TRANSITION", [ARRIVED if i in asked else 0 for i in range(n)])
        names["decide_together"](kernel.floats, kernel.ints, 0)
        if kernel.ints[kernel.place("STATUS")]:
            return ()
        return tuple(int(kernel.floats[kernel.place("SIDE") + i]) for i in range(n))


def assert_decided_as_by_enumeration(seeds):
    """Of each of two to six contacts; returns how many rest in how many of them."""
    counter = collections.Counter()
    for seed in seeds:
        problem, asked, came, sides = random_problem(np.random.default_rng(seed))
        asked = [i for i in asked if problem.most[i] > problem.least[i]]
        if len(sides) == 1 or not asked:
            continue
        theirs = decided(problem, asked, came & {*asked}, sides)
        expected = tuple(theirs.get(i, side) for i, side in sides.items())
        assert kernel_decision(problem, asked, came & {*asked}, sides) == expected, seed
        counter[sum(side == 0 for side in expected)] += 1
    return counter


PASSED = (881, 1001)  # seeds in which it matters who slid until now


@pytest.mark.slow
def test_decisions_are_those_of_all_modes_tried():
    """Independent contacts, coupled ones, imposed distances, loads that follow friction; joint rests and drops."""
    assert set(assert_decided_as_by_enumeration([*range(150), *PASSED])) >= {0, 1, 2, 3}
