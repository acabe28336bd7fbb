"""Motions that come to rest in the limit alone: by stops that grow ever longer, each nearer to rest than the last."""

import numpy as np

from vibrocap.motion.trajectory import Trajectory
from vibrocap.physics.events import STICK
from vibrocap.physics.system import System

STOPS = 4  # the last ones, that have to go on alike
NEARER = 0.95  # share of the rates at a stop that is left at the next one, at most
ALIKE = 1e-3  # by which this share may change from stop to stop
EXCESS = 1e-12  # of what a contact can hold, that it may hold more than it rubs in the slowest slide


def comes_to_rest(motion: Trajectory) -> bool:
    """Whether a motion continues to rest by smaller and smaller stops, of which none is the last.

    So ends a linear loop with integral action around a contact that holds no more than it rubs: each slide is the one
    before on a smaller scale, turned round, so that stops shrink by one share, while the time that the integral needs
    to push the contact loose again grows by as much. Asked are the last stops of all contacts: their rates fall by one
    share below 1, and they grow longer. A contact that holds more than it rubs has a smallest slide: there is a cycle.
    """
    system = motion.system
    if not _rubs_as_it_holds(system):
        return False
    kinds = {f"{STICK}{number}" for number in ("", *(f"_{i}" for i in range(2, 1 + len(system.laws))))}
    stops = [event for event in motion.events if event.kind in kinds]
    at_rest = [not motion.piece_sides[motion.piece_at(np.array([stop.time]))[0]].any() for stop in stops]
    stops = [stop for stop, rests in zip(stops, at_rest, strict=True) if rests][-1 - STOPS :]
    if len(stops) <= STOPS:
        return False
    sizes = np.array(system.scales(), dtype=float)
    kept = [i for i, name in enumerate(system.state_names) if name != system.cyclic]
    rates = [system.rates(stop.time, tuple(stop.state.values()), (0,) * len(system.laws)) for stop in stops]
    speeds = np.max(np.abs(np.array(rates, dtype=float) / sizes)[:, kept], axis=1)
    lengths = np.diff([stop.time for stop in stops])
    if not np.all(speeds > 0.0):
        return False
    shares = speeds[1:] / speeds[:-1]
    return bool(np.all(shares <= NEARER) and np.ptp(shares) <= ALIKE * shares[-1] and np.all(np.diff(lengths) > 0.0))


def _rubs_as_it_holds(system: System) -> bool:
    """Whether contacts hold no more at rest than they rub in the slowest slide, which alone is set-valued then."""
    for law, load in zip(system.laws, system.law_loads, strict=True):
        if law.kind != "set-valued":
            return False
        limit, middle = law.holding_limit(load), law.holding_centre(load)
        slowest = [law.force(0.0, (0.0,) * len(law.internal), side, load)[0] for side in (1, -1)]
        if max(middle + limit - slowest[0], slowest[1] - (middle - limit)) > EXCESS * limit:
            return False
    return True
