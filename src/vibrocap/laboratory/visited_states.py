"""Internal states that a law visits under all kinds of motion: where to look for what it can do."""

import numpy as np

from vibrocap.laboratory.recorded_law import RecordedLaw

MOTIONS, LEVELS, STEPS = 48, 24, 12  # side by side, levels of velocity of each, steps within a level


def visited_states(recorded: RecordedLaw, speeds: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """States [states, n] visited from rest under random levels of velocity, and the side [n] of each.

    speeds: the levels are drawn from these, forward and backward; each is held for a time that is drawn between a
    hundredth and thirty relaxation times of the internal states. The same draw every time.

    Steps are linearly implicit (L-stable, first order): enough to see where states go, not to measure by them.
    """
    states, draw = len(recorded.rates), np.random.default_rng(20)
    size = np.asarray([float(scale) for scale in recorded.law.internal_scales(recorded.load)])
    state, side = np.zeros((states, MOTIONS)), np.ones(MOTIONS)
    found, sides = [state], [side]
    for _ in range(LEVELS):
        turn = draw.choice([-1.0, 1.0], MOTIONS)
        velocity = turn * draw.choice(speeds, MOTIONS)
        state, side = recorded.turned(state, side, turn), turn
        state = recorded.settled_pieces(velocity, state, side)
        slope = recorded.values(recorded.rate_slopes, velocity, state, side).reshape(states, states + 1, -1)[:, 1:]
        rate = recorded.values(recorded.rates, velocity, state, side)
        quickness = np.max(np.abs(slope), axis=(0, 1), initial=0.0) + np.max(np.abs(rate) / size[:, None], axis=0)
        duration = 10.0 ** draw.uniform(-2.0, 1.5, MOTIONS) / np.maximum(quickness, 1e-300)
        for share in np.diff(np.geomspace(1e-3, 1.0, STEPS + 1), prepend=0.0):
            state = implicit_euler(recorded, velocity, state, side, share * duration)
            state = recorded.settled_pieces(velocity, state, side)
            found.append(state)
            sides.append(side)
    every, where = np.concatenate(found, axis=1), np.concatenate(sides)
    finite = np.all(np.isfinite(every), axis=0)
    return every[:, finite], where[finite]


def implicit_euler(recorded: RecordedLaw, velocity, state, side, step) -> np.ndarray:
    """Internal states [states, n] a step [n] later, at constant velocity, by (1 - h J) dz = h z'.

    Where that is not finite the state stays.
    """
    states, count = state.shape
    rate = recorded.values(recorded.rates, velocity, state, side)
    slopes = recorded.values(recorded.rate_slopes, velocity, state, side).reshape(states, states + 1, count)[:, 1:]
    matrix = np.eye(states)[:, :, None] - step * slopes
    good = np.all(np.isfinite(matrix), axis=(0, 1)) & np.all(np.isfinite(rate), axis=0)
    if states == 1:
        change = (step * rate[0] / np.where(good, matrix[0, 0], 1.0))[None]
    else:
        matrix = np.where(good, matrix, np.eye(states)[:, :, None])
        change = np.linalg.solve(np.moveaxis(matrix, 2, 0), (step * np.where(good, rate, 0.0)).T[:, :, None])[:, :, 0].T
    after = state + change
    return np.where(good & np.all(np.isfinite(after), axis=0), after, state)
