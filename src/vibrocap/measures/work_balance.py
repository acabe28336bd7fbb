"""Whether the works of the runs of an ensemble add up: what a sweep can ask of every run at hardly any cost."""

import functools

import numpy as np

from vibrocap.measures.gathered import Gathered
from vibrocap.motion.evidence import BALANCE_BOUND, BALANCE_PER_STEP, LEAST_TOLERANCE
from vibrocap.numerics.expressions.equations import Equations
from vibrocap.numerics.expressions.graph import Expression, derivative, evaluated


def balanced(recording: Equations, gathered: Gathered, parameters: np.ndarray, tolerance: float) -> np.ndarray:
    """Whether the energy stored over the window of each run is the work of all channels: array [runs] of bool.

    The bound is that of a certificate: 100 tolerances, and a tenth for each step, of the natural size of the energy,
    here with all works added. Both states stand at the start of a drive period. True for laws that lose stored energy
    where a branch begins (`loses_at_switches`): there the works need not add up.

    parameters: [runs, parameters]
    """
    count = len(gathered.results)
    if not count or loses_at_switches(recording):
        return np.ones(count, dtype=bool)
    before, after = gathered.results.start.T, gathered.results.state.T
    energy, slopes = _energy(recording)
    values = parameters.T

    def at(expressions: tuple[Expression, ...], states: np.ndarray) -> np.ndarray:
        return evaluated(expressions, 0.0, states, 1.0, values, (count,))

    scales = at(recording.scales, before)
    reach = np.zeros(count)
    for states in (before, after, scales):
        reach = np.maximum(reach, np.sum(np.abs(at(slopes, states)) * scales, axis=0))
    works = np.array([gathered.results.entry("INTEGRAL", i) for i in range(len(recording.powers))])
    residual = at((energy,), after)[0] - at((energy,), before)[0] - works.sum(axis=0)
    steps = gathered.results.head("taylor_steps") + gathered.results.head("implicit_steps")
    errors = max(tolerance, LEAST_TOLERANCE) * (BALANCE_BOUND + BALANCE_PER_STEP * steps)
    return np.abs(residual) <= errors * (reach + np.abs(works).sum(axis=0))


@functools.lru_cache(maxsize=64)
def loses_at_switches(recording: Equations) -> bool:
    """Whether a change of branch may change what the contact stores, as where one begins unloaded."""
    stored = recording.observables["contact_energy"]
    outcomes = (*recording.after_switch, *(contact.after_reversal for contact in recording.contacts))
    return any(
        value.index != recording.graph.node("state", i).index and derivative(stored, i).value != 0.0
        for outcome in outcomes
        for i, value in enumerate(outcome)
    )


@functools.lru_cache(maxsize=64)
def _energy(recording: Equations) -> tuple[Expression, tuple[Expression, ...]]:
    """The stored energy, and its slope with every state."""
    energy = recording.observables["energy"] + recording.observables["contact_energy"]
    return energy, tuple(derivative(energy, i) for i in range(len(recording.rates)))
