"""Where a branch of cycles is born: the Hopf point to which small cycles shrink, and the cycles next to one."""

import numpy as np

from vibrocap.orbits.continuation.branch_point import BranchPoint
from vibrocap.orbits.continuation.special_points import Found, SpecialKind
from vibrocap.orbits.equilibria.bifurcations import Located, hopf
from vibrocap.orbits.equilibria.following import corrected
from vibrocap.orbits.equilibria.steady_equations import Mode, SteadyEquations
from vibrocap.orbits.maps.cycle_map import CycleMap

SMALL = 3e-3  # amplitude over that of the first cycle at which a Hopf point is looked for
CENTRE = 3.0  # amplitudes within which the equilibrium lies
SAME_FREQUENCY = 1e-2  # by how much that of the cycle may differ from that of the Hopf point


def is_smooth(point: BranchPoint) -> bool:
    """Whether nothing happens along the cycle: no stick, no reversal, no impact."""
    return len(point.closing.mode_sequence) <= 1 and point.closing.impacts <= 0.0


def flow_across(closure: CycleMap, point: BranchPoint) -> tuple[float, float]:
    """(amplitude of a small cycle, cosine between the flow and the normal of the section), over natural sizes."""
    state, row = closure.state(point.x, point.closing), closure.row.copy()
    row[closure.index] = closure.parameter(point.x)
    flow = closure.map.rates(state, closure.map.contact_side(state, row), row)[closure.unknowns]
    flow = flow / closure.sizes[closure.unknowns]
    speed = float(np.linalg.norm(flow))
    cosine = float(closure.normal @ flow) / speed if speed > 0.0 else 0.0
    return speed * closure.period(point.x) / (2.0 * np.pi), cosine


def hopf_at_end(closure: CycleMap, last: BranchPoint) -> Found | None:
    """The Hopf point at which a branch of cycles ends behind its last point; None where there is none."""
    if not is_smooth(last) or (amplitude := flow_across(closure, last)[0]) > SMALL:
        return None
    state, period = closure.state(last.x, last.closing), closure.period(last.x)
    mode = _mode(closure, last)
    guess = mode.point(state[mode.problem.unknowns], closure.parameter(last.x))
    centre = corrected(mode, guess, np.eye(len(guess))[-1])
    if centre is None:
        return None
    found = hopf(mode, centre, complex(0.0, 2.0 * np.pi / period))
    if found is None or not _belongs(closure, mode, found, state, period, amplitude):
        return None
    place, count = mode.parameter(found.x), last.unstable()
    words = last.closing.mode_sequence, last.closing.mode_sequence
    text = f"the cycles shrink to steady sliding; omega {found.frequency:.10g}"
    return Found(SpecialKind.HOPF, 1.0, last, found.error, (count, count), words, text=text, place=place)


def _mode(closure: CycleMap, point: BranchPoint) -> Mode:
    """The equations of equilibria in the mode of the contacts along a smooth cycle."""
    problem = SteadyEquations(closure.system, closure.path)
    state = closure.state(point.x, point.closing)
    switched = np.zeros(len(state))
    switched[closure.switched] = state[closure.switched]
    ones = np.ones(len(problem.velocities))
    row = problem.row.copy()
    row[problem.index] = closure.parameter(point.x)
    velocities = problem.values(problem.velocities, state[problem.unknowns], ones, switched, row)
    return Mode(problem, np.where(velocities < 0.0, -1.0, 1.0), switched, closure.between)


def _belongs(closure: CycleMap, mode: Mode, found: Located, state: np.ndarray, period: float, amplitude: float) -> bool:
    """Whether a cycle of an amplitude surrounds the equilibrium at a Hopf point, and turns as fast."""
    away = (mode.state(found.x) - state[mode.problem.unknowns]) / closure.sizes[mode.problem.unknowns]
    near = float(np.linalg.norm(away)) <= CENTRE * amplitude
    return near and abs(found.frequency * period / (2.0 * np.pi) - 1.0) <= SAME_FREQUENCY
