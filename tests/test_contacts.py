"""Machines on several contacts: an event-driven solver of its own, closed balances, and travel of unequal bodies."""

import collections
import itertools

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import vibrocap as vc

TINY = 1e-13
SAMPLES = 100  # per step at which guards are looked at


class TwoBlocks:
    """Two blocks on a spring and a damper, both rubbing: an explicit method between events, the modes by hand.

    Modes (a, b) in {-1, 0, 1}; nothing of this is shared with the package. Coulomb friction with a static level.
    """

    masses, stiffness, damping = (1.0, 3.6), 3.9, 0.05
    kinetic, static = (0.04, 0.068), (0.05, 0.085)
    amplitude, frequency = 0.7, 0.8

    def pushes(self, t, y):
        """Forces on both blocks but friction; y = (z, v1, v2, x1)."""
        pull = self.stiffness * y[0] + self.damping * (y[2] - y[1]) - self.amplitude * np.cos(self.frequency * t)
        return pull, -pull

    def rates(self, t, y, modes):
        found = [
            0.0 if side == 0 else (push - side * level) / mass
            for side, push, level, mass in zip(modes, self.pushes(t, y), self.kinetic, self.masses, strict=True)
        ]
        return [y[2] - y[1], *found, y[1]]

    def guards(self, t, y, modes):
        """Two per block, the second infinite while it slides."""
        found = []
        for i, (side, push, limit) in enumerate(zip(modes, self.pushes(t, y), self.static, strict=True)):
            found += [side * y[1 + i], np.inf] if side else [limit - push, limit + push]
        return found

    def root(self, k, modes, states, low, high):
        """Where guard k falls to zero."""

        def guard(t):
            return self.guards(t, states(t), modes)[k]

        return low if guard(low) <= 0.0 else float(brentq(guard, low, high, xtol=1e-15))  # type: ignore[arg-type]

    def motion(self, y, end):
        """(state at the end, events as (time, block, side), mode pairs visited)."""
        t, y, events, visited = 0.0, np.array(y, float), [], collections.defaultdict(float)
        modes = [int(np.sign(v)) for v in y[1:3]]
        fresh = [False, False]  # blocks that have just begun to slide: zero velocity is no event
        while t < end:
            for i in (0, 1):  # a block that has stopped holds, or goes on to the side of the push
                push = self.pushes(t, y)[i]
                if modes[i] == 0 and abs(push) > self.static[i] + TINY:
                    modes[i], fresh[i] = int(np.sign(push)), True
                    events.append((t, i + 1, modes[i]))
            solution = solve_ivp(
                lambda t, y, m=tuple(modes): self.rates(t, y, m),
                (t, min(end, t + 0.25)),
                y,
                method="DOP853",
                rtol=3e-14,
                atol=1e-15,
                dense_output=True,
            )
            last = solution.t[-1]
            grid = np.linspace(t, last, SAMPLES + 1)
            values = np.array([each + 0.0 * grid for each in self.guards(grid, solution.sol(grid), modes)]).T
            first = (last, -1)
            for k in range(4):
                for j in range(3 if fresh[k // 2] else 0, SAMPLES):
                    if np.isfinite(values[j, k]) and values[j, k] > -TINY and values[j + 1, k] <= 0:
                        first = min(first, (self.root(k, modes, solution.sol, grid[j], grid[j + 1]), k))
                        break
            fresh = [False, False]
            visited[tuple(modes)] += first[0] - t
            t, k = first
            y = solution.sol(t)
            for i in (0, 1):
                if modes[i] == 0:
                    y[1 + i] = 0.0
            if k >= 0:
                i = k // 2
                if modes[i]:
                    modes[i], y[1 + i] = 0, 0.0
                    events.append((t, i + 1, 0))
                else:
                    modes[i] = 1 if k % 2 == 0 else -1
                    fresh[i] = True
                    events.append((t, i + 1, modes[i]))
        return y, events, visited


def test_two_blocks_against_an_independent_solver():
    """All nine pairs of modes, each for more than a whole unit of time."""
    machine = vc.TwoBodyCrawler(mass_2=3.6, stiffness=3.9, damping=0.05, normal_load=1.0, normal_load_2=1.7)
    system = vc.System(machine, vc.Coulomb(0.04, 0.05), vc.Harmonic(amplitude=0.7, frequency=0.8))
    motion = vc.simulate(system, periods=12, initial={"velocity": 0.6, "velocity_2": 0.8}, tolerance=1e-13)
    y, events, visited = TwoBlocks().motion((0.0, 0.6, 0.8, 0.0), motion.end)
    assert set(visited) == set(itertools.product((-1, 0, 1), repeat=2))
    assert min(visited.values()) > 1.0
    for name, value in zip(("displacement", "velocity", "velocity_2", "position"), y, strict=True):
        assert motion.state[name] == pytest.approx(value, abs=1e-9)
    for contact in (1, 2):
        ours = [(phase.start, phase.side) for phase in motion.phases_of(contact)][1:]
        theirs = [(t, side) for t, block, side in events if block == contact]
        # a block that turns without sticking rests for no time
        theirs = [
            each for each, following in zip(theirs, [*theirs[1:], (np.inf, 0)], strict=True) if each[0] != following[0]
        ]
        assert [side for _, side in ours] == [side for _, side in theirs]
        assert [t for t, _ in ours] == pytest.approx([t for t, _ in theirs], abs=1e-9)
    assert motion.certificate.ok
    assert motion.certificate.energy_residual < 100 * motion.tolerance
    assert motion.certificate.momentum_residual < 100 * motion.tolerance
