"""The branch of cycles that is born at a Hopf point, followed from there."""

import dataclasses

import numpy as np

from vibrocap.arguments import ArgumentError
from vibrocap.orbits.continuation.branch import Branch, check_options, joined
from vibrocap.orbits.continuation.cycle_following import cycles_followed
from vibrocap.orbits.equilibria.equilibrium_branch import EquilibriumBranch
from vibrocap.orbits.maps.cycle_map import CycleMap
from vibrocap.orbits.parameter_range import system_at
from vibrocap.orbits.walk.kinds import BranchEnd, SpecialKind
from vibrocap.orbits.walk.residual import BranchPoint, corrected, null_tangent
from vibrocap.orbits.walk.special_points import Found, SpecialPoint
from vibrocap.physics.dimensions.conversion import value_in_words

FIRST = 1e-2  # amplitude of the first cycle, over the one that would bring a contact to rest


def hopf_cycles(
    branch: EquilibriumBranch,
    at: SpecialPoint | None = None,
    *,
    points: int = 1000,
    step: float = 0.01,
    tolerance: float = 1e-12,
) -> Branch:
    """The cycles born at a Hopf point of a branch of equilibria, followed over its parameter from amplitude zero.

        y(t) = y_H + A Re(v exp(i omega t)),     period 2 pi/omega          of a small amplitude A

    The first cycle has a hundredth of the amplitude at which a contact would come to rest; Newton's method closes it at
    that amplitude, with the parameter and the period as unknowns. From there the branch is followed as `branch` follows
    any other, with the amplitude growing.

    at: one of `found.hopf_points`; by default the only one. points, step, tolerance: as for `branch`

    Returns a `Branch`, whose first special point is the Hopf point. Raises ArgumentError for a point that is no Hopf
    point of the branch, and where no cycle closes beside it (a degenerate one, as without nonlinear terms).
    """
    if at is None:
        if len(branch.hopf_points) != 1:
            raise ArgumentError("at", f"should be given: the branch has {len(branch.hopf_points)} Hopf points")
        at = branch.hopf_points[0]
    if not isinstance(at, SpecialPoint) or at.kind is not SpecialKind.HOPF or at not in branch.hopf_points:
        raise ArgumentError("at", "should be one of the Hopf points of the branch, `found.hopf_points`")
    check_options("up", points, step)
    if at.criticality == "degenerate":
        text = "is degenerate: without nonlinear terms, cycles of all amplitudes stand at this one parameter"
        raise ArgumentError("at", text)
    closure, first = _first_cycle(branch, at, tolerance)
    walk = cycles_followed(closure, first, 1.0, points, step)
    text = f"cycles are born; {at.criticality}"
    born = Found.at_end(SpecialKind.HOPF, 0.0, first, at.error, text, at.parameter, frequency=at.frequency)
    result = joined(closure, None, dataclasses.replace(walk, special=[(0, born), *walk.special]))
    return dataclasses.replace(result, ends=(BranchEnd.HOPF, result.ends[1]))


def _first_cycle(branch: EquilibriumBranch, at: SpecialPoint, tolerance: float) -> tuple[CycleMap, BranchPoint]:
    """(the map, the cycle of a small amplitude with the tangent along which the amplitude grows)."""
    system, frequency = system_at(branch.system, branch.over, at.parameter), at.frequency
    assert frequency is not None
    assert at.vector is not None
    state = np.array([at.state[name] for name in system.state_names])
    sizes = _sizes(branch, at, state)
    shape = at.vector / sizes
    shape = shape * np.exp(-0.5j * np.angle(np.sum(shape * shape)))  # its parts at right angles
    shape = shape / np.linalg.norm(shape.real)
    start = state + FIRST * sizes * shape.real
    closure = CycleMap(system, branch.over, branch.between, start, 2.0 * np.pi / frequency, tolerance, sizes=sizes)
    x = closure.point(start, at.parameter, 2.0 * np.pi / frequency)
    outward = np.concatenate((shape.real[closure.unknowns], (0.0, 0.0)))
    closed, _ = corrected(closure, x, outward, float(outward @ x))
    if closed is None or np.linalg.norm((closed.x - x)[:-2]) > 0.5 * FIRST:
        place = value_in_words(branch.over, at.parameter, branch.system, 10)
        where = f"no cycle of a small amplitude closes beside the Hopf point at {place}"
        raise ArgumentError("at", f"{where}, which is {at.criticality}")
    along = null_tangent(closed)
    return closure, BranchPoint(closed, along if along @ outward > 0.0 else -along)


def _sizes(branch: EquilibriumBranch, at: SpecialPoint, state: np.ndarray) -> np.ndarray:
    """Size of each state in a cycle of the shape of the eigenvector that would bring the first contact to rest."""
    problem, shape = branch.mode.problem, np.abs(np.asarray(at.vector))
    places = [contact.state for contact in problem.recording.contacts if contact.state in problem.unknowns]
    ratios = [abs(state[place]) / shape[place] for place in places if shape[place] > 0.0]
    reach = min(ratios, default=0.0) * shape
    return np.where(reach > 0.0, reach, problem.sizes)
