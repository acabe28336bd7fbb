"""Corners between stick and slip in a force record: fitted, with their errors."""

import dataclasses

import numpy as np

CORNER_SHARE = 0.35  # of the fall, which the fit of a corner takes in: there a cosine is a parabola to 4 % of the fall
NOISE_SHARE, MOST_SHARE = 3.0, 0.5  # more of the fall is taken in where noise, over the fall, hides so little of it
LEVEL_ERROR = 0.01  # of the fall: so much of the stick is fitted that the level at the corner is as good as that
SLIP_LENGTHS = 1.5  # length of the stick beside a corner that is fitted at least, in lengths of the slip
LEAST_STICK = 12.0  # samples of the stick beside a corner, where it has so many
LEAST_SAMPLES = 3  # on either side of a corner; where there are fewer, it is located by its samples only
KINK, LET_GO = 1, 2  # powers of the bend: without inertia, and of a mass that is let go
CLEARLY, TOLD = 4.0, 8.0  # -2 log likelihood, for each slip
MOST_SAMPLES = 400  # of a fit; longer stretches are averaged in blocks


@dataclasses.dataclass(frozen=True)
class Corner:
    """Where a slip begins or ends: time [s] and force (unit of the record), with their standard errors."""

    time: float
    force: float
    time_error: float
    force_error: float


@dataclasses.dataclass(frozen=True)
class _Stretch:
    """A piece of a record that runs from the stick into the slip: places [s] from the record's start, forces."""

    places: np.ndarray
    force: np.ndarray
    sign: float  # +1: the force falls into the slip as time goes on (a start), -1: read backwards (an end)
    turning: float  # place of the turning point
    noise: float  # of the averaged force
    step: float  # of the record


def fitted_corners(
    time: np.ndarray, force: np.ndarray, noise: float, tops: np.ndarray, bottoms: np.ndarray
) -> tuple[list[Corner], list[Corner]]:
    """(starts, ends) of slips whose turning points are known, fitted to the record.

    Beside a start at t1 the force is F1 + s (t - t1) - c max(t - t1, 0)^p: straight while it sticks; in the slip a mass
    that is let go falls as p = 2 (m x'' = F_s - F_k at once), one without inertia as p = 1. Least squares decide over
    t1, F1, s, c, and, for all slips of the record together, over p. An end is the same read backwards, with a p of its
    own. A slip of few samples keeps its turning points, exact to the sampling.

    time: evenly spaced [n] s;  force: without spikes [n];  noise: its standard deviation
    tops, bottoms: indices of the turning points [m]
    """
    starts: list[_Stretch] = []
    ends: list[_Stretch] = []
    step = float(time[-1] - time[0]) / (len(time) - 1)
    place = np.arange(len(time)) * step
    for index, (top, bottom) in enumerate(zip(tops, bottoms, strict=True)):
        fall = float(force[top] - force[bottom])
        stick = max(SLIP_LENGTHS * (bottom - top), (2.0 * noise / (LEVEL_ERROR * max(fall, noise))) ** 2, LEAST_STICK)
        before = bottoms[index - 1] if index else 0
        after = tops[index + 1] if index + 1 < len(tops) else len(time) - 1
        inside = force[top : bottom + 1]
        share = min(MOST_SHARE, CORNER_SHARE + NOISE_SHARE * noise / max(fall, noise))
        # Samples above a level are counted: noise makes some cross it early, and as many late.
        down = top + int(np.sum(inside > inside[0] - share * fall))
        up = bottom - int(np.sum(inside < inside[-1] + share * fall))
        first = top - int(min(stick, 0.5 * (top - before)))
        last = bottom + int(min(stick, 0.5 * (after - bottom)))
        start, end = slice(first, down + 1), slice(up, last + 1)
        starts.append(_stretch(place[start], force[start], float(place[top]), noise, step))
        ends.append(_stretch(-place[end][::-1], -force[end][::-1], -float(place[bottom]), noise, step, sign=-1.0))
    begin = float(time[0])
    return [_corner(begin, fit) for fit in _best(starts)], [_corner(begin, fit) for fit in _best(ends)]


def _corner(begin: float, fit: tuple[_Stretch, float, float, float, float]) -> Corner:
    stretch, place, level, place_error, level_error = fit
    return Corner(begin + stretch.sign * place, stretch.sign * level, place_error, level_error)


def _stretch(
    places: np.ndarray, force: np.ndarray, turning: float, noise: float, step: float, sign: float = 1.0
) -> _Stretch:
    block = -(-len(places) // MOST_SAMPLES)
    if block > 1:
        number = len(places) // block * block
        places = places[-number:].reshape(-1, block).mean(axis=1)
        force = force[-number:].reshape(-1, block).mean(axis=1)
    return _Stretch(places, force, sign, turning, noise / block**0.5, step)


def _best(stretches: list[_Stretch]) -> list[tuple[_Stretch, float, float, float, float]]:
    """(stretch, place, level, their errors) of each, with the power that suits all of them best."""
    fits = {power: [_fit(stretch, power) for stretch in stretches] for power in (KINK, LET_GO)}
    # The likelihoods of all fits, each with a noise of its own, so that no single large slip decides.
    misfit = {power: sum(likelihood for likelihood, *_ in fits[power]) for power in fits}
    # Sliders have mass: that one falls as if it had none has to be clear.
    clear = (misfit[LET_GO] - misfit[KINK]) / max(1, len(stretches))
    power, other = (KINK, LET_GO) if clear > CLEARLY else (LET_GO, KINK)
    result = []
    for stretch, numbers, others in zip(stretches, fits[power], fits[other], strict=True):
        _, place, level, place_error, level_error = numbers
        if abs(clear) < TOLD:  # which of both forms it is adds to what is not known
            place_error = float(np.hypot(place_error, 0.5 * (place - others[1])))
            level_error = float(np.hypot(level_error, 0.5 * (level - others[2])))
        result.append((stretch, place, level, place_error, level_error))
    return result


def _fit(stretch: _Stretch, power: int) -> tuple[float, float, float, float, float]:
    """(-2 log likelihood, less that of a straight line, place, level, error of the place, error of the level).

    What the third term explains, beside level and slope, is known in closed form for every place of the corner, so all
    places are compared.
    """
    places, force = stretch.places, stretch.force
    number = len(places)
    nearest = int(np.argmin(np.abs(places - stretch.turning)))
    if min(number - nearest, nearest) < LEAST_SAMPLES:
        return _at_samples(stretch, nearest)
    unit = (places - places.mean()) / np.ptp(places)
    line = np.stack([np.full(number, number**-0.5), unit / np.linalg.norm(unit)], axis=1)
    rest = force - line @ (line.T @ force)
    spacing = float(places[1] - places[0])
    corners = places[0] + spacing * np.arange(LEAST_SAMPLES - 1, number - LEAST_SAMPLES + 0.5, 0.5)
    bends = (np.maximum(places[:, None] - corners, 0.0) / np.ptp(places)) ** power  # [n, corners]
    bends -= line @ (line.T @ bends)
    along = rest @ bends
    gain = np.where(along < 0, along**2 / np.einsum("ij,ij->j", bends, bends), 0.0)
    at = int(np.argmax(gain))
    if gain[at] <= 0.0:
        return _at_samples(stretch, nearest)
    place = float(corners[at]) + _vertex(gain, at) * 0.5 * spacing
    bend = np.maximum(places - place, 0.0)
    shape = np.stack([np.ones(number), places - place, bend**power], axis=1)
    values = np.linalg.lstsq(shape / np.linalg.norm(shape, axis=0), force, rcond=None)[0]
    values /= np.linalg.norm(shape, axis=0)
    # With the corner the whole line moves, and the bend begins later.
    moving = -values[1] - values[2] * power * bend ** (power - 1) * (bend > 0)
    level_error, place_error = _errors(np.column_stack([shape, moving]), stretch.noise)
    if place_error > places[-1] - stretch.turning:  # the bend does not tell the corner to better than the slip
        return _at_samples(stretch, nearest)
    place_error = float(np.hypot(place_error, stretch.step / 12.0**0.5))
    misfit = number * float(np.log(max(1.0 - gain[at] / (rest @ rest), 1e-12)))
    return misfit, place, float(values[0]), place_error, level_error


def _at_samples(stretch: _Stretch, nearest: int) -> tuple[float, float, float, float, float]:
    """What `_fit` returns where no bend tells the corner: the level of the stick at the turning point."""
    force, places = stretch.force[: nearest + 1], stretch.places[: nearest + 1]
    place_error = 0.5 * max(stretch.step, float(stretch.places[-1]) - stretch.turning)
    if len(force) < 2 * LEAST_SAMPLES:
        return 0.0, stretch.turning, float(force[-1]), place_error, stretch.noise
    level = float(np.polynomial.polynomial.polyfit(places - stretch.turning, force, 1)[0])
    return 0.0, stretch.turning, level, place_error, 2.0 * stretch.noise / len(force) ** 0.5


def _vertex(gain: np.ndarray, at: int) -> float:
    """Where the parabola through three neighbours is highest, in steps from the middle one."""
    if not 0 < at < len(gain) - 1:
        return 0.0
    left, middle, right = gain[at - 1 : at + 2]
    bend = left - 2.0 * middle + right
    return float(np.clip(0.5 * (left - right) / bend, -0.5, 0.5)) if bend < 0 else 0.0


def _errors(jacobian: np.ndarray, noise: float) -> tuple[float, float]:
    """Standard errors of the first and the last unknown of a least-squares fit, for white noise."""
    scale = np.linalg.norm(jacobian, axis=0)
    scale[scale == 0] = 1.0
    inverse = np.linalg.pinv((jacobian / scale).T @ (jacobian / scale))
    errors = noise * np.sqrt(np.maximum(np.diag(inverse), 0.0)) / scale
    return float(errors[0]), float(errors[-1])
