"""Short cuts of the step of all lanes: where nothing is looked for, nothing is there."""

import numpy as np

from test_ensemble import LANES, ORDER, sliding_lanes


def test_a_slide_that_is_not_looked_at_goes_on():
    """Where the bound on a slide lets the search for its end be skipped, the velocity stays on its side."""
    kernel, floats, _, _ = sliding_lanes("lugre")
    draw = np.random.default_rng(6)
    never = np.zeros(LANES, bool)
    counts = np.zeros(3)
    for round_ in range(600):
        zeros = round_ % 3
        series = draw.normal(size=(ORDER + 1, LANES)) * 10 ** draw.uniform(-1.5, 0.5, LANES)
        series *= draw.random(series.shape) < 0.4  # so that a single term decides
        side = draw.choice([-1.0, 1.0], LANES)
        series[:zeros], series[zeros] = 0.0, side * draw.uniform(0.0, 1.0, LANES)
        floats[kernel["VELOCITY"] :][: series.size] = series.ravel()
        h = draw.uniform(0.1, 1.0, LANES)
        ahead, change = kernel["ahead_simd"](floats, 0, side, never, never | (zeros == 1), never | (zeros == 2), h)
        times = np.linspace(0.0, 1.0, 101)[:, None] * h
        velocity = sum(c * times ** (k - zeros) for k, c in enumerate(series) if k >= zeros)
        away = sum(c * times**k for k, c in enumerate(series) if k >= 1)
        assert np.all(np.abs(away) <= change * (1.0 + 1e-12))
        kept = np.all(side * velocity > 0.0, axis=0)
        assert np.all(kept[ahead])
        counts += [np.sum(ahead), np.sum(~kept), np.sum(kept & ~ahead)]
    assert min(counts) > 100
