"""Contacts that act on one another, by an event-driven solver of its own: DOP853 between events, all 3^n modes tried.

Nothing is shared with the package. Coulomb friction with one level per contact and direction, at rest as while sliding.
"""

import itertools

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

TINY, SAMPLES, LONGEST = 1e-12, 60, 0.2


class EventDriven:
    """Subclasses give `corners`, `velocities(t, y)` and `solved(t, y, modes)`.

    solved: (y', accelerations of the contacts, friction, largest friction back and forward of each contact)
    """

    corners: tuple[float, ...] = ()
    contacts = 2

    def velocities(self, t, y):
        """Sliding velocity of each contact."""
        raise NotImplementedError

    def solved(self, t, y, modes):
        """The equations in given modes."""
        raise NotImplementedError

    def margins(self, t, y, modes):
        """Of contacts that rest: by how much what they hold, one by one or together, may grow back and forward."""
        _, _, friction, low, high = self.solved(t, y, modes)
        each = zip(modes, friction, low, high, strict=True)
        return [(r - a, b - r) if m == 0 else (np.inf, np.inf) for m, r, a, b in each]

    def chosen(self, t, y, still):
        """The one consistent set of modes, of contacts that are at rest (`still`) and of others by their velocities."""
        moving = np.sign(self.velocities(t, y)).astype(int)
        found = []
        for modes in itertools.product(*[(0, 1, -1) if rest else (m,) for rest, m in zip(still, moving, strict=True)]):
            try:
                _, accelerations, *_ = self.solved(t, y, modes)
            except np.linalg.LinAlgError:
                continue
            # just after: what holds at its limit and grows beyond it gives way
            later = t + 1e-7
            shifted = y + 1e-7 * np.array(self.solved(t, y, modes)[0])
            held = all(min(pair) > -1e-11 for pair in self.margins(t, y, modes))
            held = held and all(min(pair) > -1e-13 for pair in self.margins(later, shifted, modes))
            after = self.solved(later, shifted, modes)[1]
            departs = all(
                m * a > TINY or (abs(a) <= 1e-9 and m * b > 0)
                for m, a, b, rest in zip(modes, accelerations, after, still, strict=True)
                if rest and m != 0
            )
            if held and departs:
                found.append(modes)
        assert len(found) == 1, (t, y, found)
        return found[0]

    def motion(self, y, end):
        """(state at the end, [(time, modes from there on)])."""
        t, y = 0.0, np.array(y, float)
        modes = self.chosen(t, y, np.abs(self.velocities(t, y)) < TINY)
        history, fresh = [(t, modes)], True
        stops = sorted({*[c for c in self.corners if 0 < c < end], end})
        while t < end:
            until = min(next(s for s in stops if s > t + TINY), t + LONGEST)
            run = solve_ivp(
                lambda t, y, m=modes, end=until: self.solved(min(t, end - 1e-13), y, m)[0],
                (t, until),
                y,
                method="DOP853",
                rtol=3e-14,
                atol=1e-15,
                dense_output=True,
            )
            state = run.sol

            def guard(s, k, modes=modes, state=state):
                i, which = divmod(k, 2)
                if modes[i] == 0:
                    return self.margins(s, state(s), modes)[i][which]
                return modes[i] * self.velocities(s, state(s))[i] if which == 0 else np.inf

            grid, first = np.linspace(t, until, SAMPLES + 1), until
            for k in range(2 * self.contacts):
                values = [guard(s, k) for s in grid]
                for j in range(2 if fresh else 0, SAMPLES):
                    if values[j] > 0 >= values[j + 1]:
                        first = min(first, float(brentq(guard, grid[j], grid[j + 1], args=(k,), xtol=1e-15)))
                        break
            t, y = first, state(first)
            jumped = any(abs(t - c) < TINY for c in self.corners)
            at = t + (1e-13 if jumped else 0.0)
            v = self.velocities(at, y)
            still = [abs(each) < 1e-10 or (m == 0 and not jumped) for each, m in zip(v, modes, strict=True)]
            fresh = first < until or jumped
            if fresh and t < end:
                modes = self.chosen(at, y, still)
                history.append((t, modes))
        return y, history


class WormMotion(EventDriven):
    """A row of bodies at imposed distances; y = (x_1, p). Friction falls between -back[i] and forward[i]."""

    def __init__(self, masses, shares, forward, back, drive, corners=()):
        self.masses, self.forward, self.back = map(np.array, (masses, forward, back))
        ahead = np.concatenate(([0.0], np.cumsum(shares)))
        self.shares = ahead - self.masses @ ahead / self.masses.sum()
        self.drive, self.corners, self.contacts = drive, corners, len(masses)

    def velocities(self, t, y):
        """x_i'."""
        return y[1] + self.shares * self.drive(t)[0]

    def solved(self, t, y, modes):
        """By the sum of all friction; of contacts that rest together the sum alone, in equal shares of their limits."""
        modes, mass = np.array(modes), self.masses.sum()
        imposed = self.shares * self.drive(t)[1]
        friction = np.where(modes > 0, self.forward, -self.back).astype(float)
        rests = modes == 0
        if rests.any():
            if np.ptp(imposed[rests]) > TINY:
                raise np.linalg.LinAlgError
            total = mass * imposed[rests][0] - friction[~rests].sum()
            middle, width = 0.5 * (self.forward - self.back), 0.5 * (self.forward + self.back)
            friction[rests] = middle[rests] + width[rests] * (total - middle[rests].sum()) / width[rests].sum()
        rate = -friction.sum() / mass
        v = self.velocities(t, y)
        return [v[0], rate], rate + imposed, friction, -self.back, self.forward


class LinkageMotion(EventDriven):
    """Two bodies and a mass on two rods, by Newton's law for each of the three; y = (z, v_2, X, v_1).

    Unknowns: both accelerations, the forces in both rods, friction and load of both contacts.
    """

    def __init__(self, masses, stiffness, damping, stance, levels, drive):
        self.masses, self.stiffness, self.damping, self.stance = masses, stiffness, damping, stance
        self.levels, self.drive = levels, drive

    def velocities(self, t, y):
        """v_1, v_2."""
        return np.array([y[3], y[1]])

    def solved(self, t, y, modes):
        """Eight equations: three masses along, one up, two loads, two contacts."""
        width, rate = self.stance + y[0], y[1] - y[3]
        sine = 0.5 * width
        cosine = np.sqrt(1.0 - sine * sine)
        pull = self.stiffness * y[0] + self.damping * rate - self.drive(t)
        # height h = cosine, h h' = -w w'/4, so h h'' = -(w w'' + w'^2)/4 - h'^2
        climb = -width * rate / (4.0 * cosine)
        rows, right = np.zeros((8, 8)), np.zeros(8)  # a1, a2, S1, S2, R1, R2, N1, N2
        rows[0, [0, 2, 4]], right[0] = (self.masses[0], sine, 1.0), pull
        rows[1, [1, 3, 5]], right[1] = (self.masses[1], -sine, 1.0), -pull
        rows[2, [0, 1, 2, 3]] = 0.5, 0.5, -sine, sine
        rise = -width / (4.0 * cosine)
        rows[3, [0, 1, 2, 3]] = -rise, rise, -cosine, -cosine
        right[3] = -1.0 - (-0.25 * rate * rate - climb * climb) / cosine
        rows[4, [6, 2]], right[4] = (1.0, -cosine), self.masses[0]
        rows[5, [7, 3]], right[5] = (1.0, -cosine), self.masses[1]
        for i, mode in enumerate(modes):
            if mode == 0:
                rows[6 + i, i] = 1.0
            else:
                rows[6 + i, [4 + i, 6 + i]] = 1.0, -mode * self.levels[i]
        a1, a2, _, _, r1, r2, n1, n2 = np.linalg.solve(rows, right)
        high = np.array(self.levels) * [n1, n2]
        return [rate, a2, y[3], a1], np.array([a1, a2]), np.array([r1, r2]), -high, high
