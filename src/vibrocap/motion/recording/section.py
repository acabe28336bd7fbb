"""Where a motion is at a mark of its drive: its state without the way it has travelled, and modulo whole turns.

A coordinate that turns stands in such a section as the point of its circle, so that neighbouring points are those of
neighbouring motions, however often each has turned. By how many turns a motion closes is its winding number.
"""

import math

import numpy as np

from vibrocap.motion.recording.equations import turning_states
from vibrocap.physics.system import System


def section_states(system: System, states: np.ndarray, scales: np.ndarray) -> np.ndarray:
    """States [..., states] over their natural sizes [states], all but the cyclic coordinate: [..., kept].

    The circle of a coordinate that turns with the period p has the radius p/2 pi, so that small distances on it are
    those of the coordinate; its abscissa stands in place of the coordinate, its ordinate behind all other states.
    """
    kept = [i for i, name in enumerate(system.state_names) if name != system.cyclic]
    scaled = states[..., kept] / scales[kept]
    ordinates = []
    for i, period in turning_states(system):
        radius = period / (2.0 * math.pi)
        angle = states[..., i] / radius
        scaled[..., kept.index(i)] = radius / scales[i] * np.cos(angle)
        ordinates.append(radius / scales[i] * np.sin(angle))
    return np.concatenate([scaled, np.stack(ordinates, axis=-1)], axis=-1) if ordinates else scaled


def whole_turns(system: System, gained: np.ndarray) -> np.ndarray:
    """What of a change of states [..., states] is whole turns, the nearest number of them; 0 of what does not turn."""
    turns = np.zeros_like(gained)
    for i, period in turning_states(system):
        turns[..., i] = period * np.round(gained[..., i] / period)
    return turns


def winding(system: System, gained: np.ndarray) -> dict[str, int]:
    """How many times each coordinate that turns has turned over a change of states [states] that closes."""
    turned = whole_turns(system, np.nan_to_num(gained))
    return {name: round(turned[system.state_names.index(name)] / p) for name, p in system.turns.items()}


def brought_back(system: System, states: np.ndarray) -> np.ndarray:
    """States [..., states] of the same motions at the origin: the cyclic coordinate 0, no more than half a turn."""
    states_brought_back = states - whole_turns(system, states)
    if system.cyclic is not None:
        states_brought_back[..., system.state_names.index(system.cyclic)] = 0.0
    return states_brought_back
