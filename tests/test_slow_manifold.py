"""Stiff bristles that have relaxed, in lanes: their series satisfy the equations, and few steps end where many do."""

import dataclasses
import itertools

import numpy as np
import pytest

import vibrocap as vc
from thinned import exhaustive_but, slow_but
from vibrocap.motion.recording.equations import equations, parameter_values
from vibrocap.numerics.expressions.structure import slow_bristles, slow_states
from vibrocap.numerics.kernel.arithmetic.plain_vectors import lane_count
from vibrocap.numerics.kernel.codes import DONE
from vibrocap.numerics.run.budget import Budget, EnsembleStart, Form
from vibrocap.numerics.run.ensemble import ensemble_kernel, ensemble_order, ensemble_run, prepared_lanes

LANES, PERIODS = lane_count(), 3
BRISTLES = vc.LuGre(coulomb_coefficient=0.1, static_coefficient=0.2)
STIFF = vc.LuGre(2e3, 12.0, coulomb_coefficient=0.12, static_coefficient=0.18, stribeck_velocity=0.05)
BLOCKS = vc.TwoBodyCrawler(mass_2=1.6, normal_load_2=1.4)
HEAVY = vc.LuGre(3e4, 1500.0, coulomb_coefficient=0.12, static_coefficient=0.18, stribeck_velocity=0.05)
# system, start: on the manifold from rest; off it, where nothing has relaxed; with another law; at corners; uneven;
# with damping that makes much of the error of a bristle
SYSTEMS = {
    "blocks": (vc.System(BLOCKS, BRISTLES, vc.Harmonic(1.5)), {}),
    "thrown": (vc.System(BLOCKS, BRISTLES, vc.Harmonic(1.5)), {"velocity": 1.2, "velocity_2": -0.9, "bristle": 1e-3}),
    "worm": (vc.System(vc.TwoBodyWorm(mass_2=1.6), STIFF, vc.Harmonic(1.5)), {"centre_velocity": 0.3}),
    "beside Coulomb": (vc.System(BLOCKS, [STIFF, vc.Coulomb(0.1, 0.2)], vc.Triangle(1.2, 0.3)), {}),
    "Dahl": (vc.System(BLOCKS, [vc.anisotropic(vc.LuGre)(2e3, 12.0), vc.Dahl(2e3)], vc.Harmonic(1.5)), {}),
    "jumps": (vc.System(BLOCKS, STIFF, vc.Square(1.2)), {}),
    "heavy": (vc.System(BLOCKS, HEAVY, vc.Harmonic(1.5)), {}),
}
# at the end of the third period, and what a shift of the first velocity has grown to, by `tight_end`
THROWN = [3.716707060740, 0.088503634018, -3.334108777114, -0.321386593614, 0.001803359079, -0.001000022204], 4.4855
TOLERANCES = [
    ("thrown", [1e-8]),
    ("thrown", [1e-6, 1e-10]),
    *((name, [1e-6, 1e-9]) for name in SYSTEMS if name != "thrown"),
]


def start_of(system, given):
    """All states, in order."""
    return [given.get(name, 0.0) for name in system.state_names]


def runs(system, given, tolerance, amplitudes):
    """An ensemble over the amplitude of the drive, whose ends are kept."""
    values = [
        parameter_values(dataclasses.replace(system, drive=dataclasses.replace(system.drive, amplitude=amplitude)))
        for amplitude in amplitudes
    ]
    budget = Budget(PERIODS, tolerance, 10_000, 10**6, window=1)
    starts = np.array([start_of(system, given)] * len(values))
    return ensemble_run(EnsembleStart(equations(system), np.array(values), starts), budget, threads=1)


def tight_end(name):
    """(the end of a tight motion, what a shift of a velocity at its start has grown to by then)."""
    system, given = SYSTEMS[name]
    pushed = system.machine.contact_states[0]
    starts = given, given | {pushed: given.get(pushed, 0.0) + 1e-7}
    tight = [vc.simulate(system, periods=PERIODS, initial=start, tolerance=1e-12) for start in starts]
    end, shifted = (np.array([run.state[key] for key in system.state_names]) for run in tight)
    return end, max(1.0, np.max(np.abs(shifted - end)) / 1e-7)


@pytest.mark.parametrize(("name", "tolerances"), slow_but([0], exhaustive_but([0, 2], TOLERANCES)))
def test_ends_are_those_of_a_tight_motion(name, tolerances):
    """Within half a tolerance times what a shift of the start grows to, at any tolerance; it was 0.05 at most."""
    system, given = SYSTEMS[name]
    end, growth = THROWN if name == "thrown" else tight_end(name)
    for tolerance in tolerances:
        found = runs(system, given, tolerance, [system.drive.amplitude] * 3)
        assert set(found.status) == {DONE}
        assert np.max(np.abs(found.state - end)) <= 0.5 * tolerance * growth


@pytest.mark.slow  # its kernel
def test_stability_bounds_no_step_where_bristles_have_relaxed(monkeypatch):
    """The same runs take less than half of the steps; tighter tolerances never take fewer."""
    amplitudes = np.linspace(0.8, 2.0, 2 * LANES)
    taken = [np.sum(runs(*SYSTEMS["blocks"], value, amplitudes).head("taylor_steps")) for value in (1e-6, 1e-8, 1e-9)]
    assert sorted(taken) == taken
    monkeypatch.setattr("vibrocap.numerics.expressions.structure.slow_bristles", lambda _: ())
    monkeypatch.setattr("vibrocap.numerics.run.ensemble.ensemble_kernel", ensemble_kernel.__wrapped__)
    assert taken[1] < 0.45 * np.sum(runs(*SYSTEMS["blocks"], 1e-8, amplitudes).head("taylor_steps"))


def test_the_same_bits_in_any_company():
    """Lanes enter and leave manifolds at instants of their own."""
    amplitudes = np.linspace(0.4, 2.0, 2 * LANES + 3)
    together = runs(*SYSTEMS["blocks"], 1e-8, amplitudes).numbers
    assert np.array_equal(together[::-1], runs(*SYSTEMS["blocks"], 1e-8, amplitudes[::-1]).numbers)
    assert np.array_equal(together[5], runs(*SYSTEMS["blocks"], 1e-8, amplitudes[5:6]).numbers[0])


def lanes_on_the_manifold(tolerance=1e-10):
    """(kernel, floats): the plain kernel, with both blocks fast and on their manifolds, no sweep made yet."""
    system, _ = SYSTEMS["blocks"]
    form = Form(order=ensemble_order(tolerance), lanes=LANES, plain=True)
    layout, entry = ensemble_kernel(equations(system), form, False)
    kernel, budget = entry.__globals__, Budget(1, tolerance, 100, 100)
    floats, ints = prepared_lanes(layout, budget, LANES)
    starts = np.array([start_of(system, {"velocity": 0.35 + 0.01 * i, "velocity_2": -0.4}) for i in range(LANES)])
    trace = np.zeros((LANES, layout.run_size))
    EnsembleStart(equations(system), np.array([parameter_values(system)] * LANES), starts).write(trace)
    for lane in range(LANES):
        kernel["begin_run"](floats, ints, trace.ravel(), lane, lane)
    floats[kernel["SLOW"] :][: 2 * LANES] = 1.0
    floats[kernel["GUESS"] :][: 2 * (layout.order + 1) * LANES] = 0.0
    return kernel, floats


def sweep(kernel, floats):
    """One series, kept as the guess of the next; returns the largest change of a coefficient k, times 0.05^k."""
    kernel["jet"](floats)
    changes = []
    for contact, state in enumerate(kernel["SLOW_STATE"]):
        size = (kernel["ORDER"] + 1) * LANES
        series = floats[kernel["SERIES"] + state * size :][:size]
        guess = floats[kernel["GUESS"] + contact * size :][:size]
        powers = 0.05 ** np.arange(kernel["ORDER"] + 1)[:, None]
        changes.append(np.max((np.abs(series - guess).reshape(-1, LANES) * powers)[1:]))
        guess[:] = series
    return max(changes)


def defect(kernel, floats, s):
    """Largest |y' - f(t, y)| of a lane at time s of its series; of bristles over their rate of decay."""
    order, states = kernel["ORDER"], kernel["STATES"]
    series = floats[kernel["SERIES"] :][: states * (order + 1) * LANES].reshape(states, order + 1, LANES)
    number = 0.0
    for lane in range(LANES):
        values = [np.polynomial.Polynomial(row) for row in series[:, :, lane]]
        point, out = np.zeros(states), np.zeros(kernel["STATES"])
        point[:] = [value(s) for value in values]
        room = np.concatenate([floats, point, out])
        kernel["rates"](room, s, len(floats), lane, len(floats) + states)
        rest = np.abs([value.deriv()(s) for value in values] - room[len(floats) + states :][:states])
        for contact, state in enumerate(kernel["SLOW_STATE"]):
            rest[state] /= floats[kernel["OWN_DECAY"] + contact * LANES + lane]
        number = max(number, np.max(rest))
    return number


def test_sweeps_find_a_motion_of_the_equations():
    """Each sweep comes nearer; in the end the series satisfies all equations."""
    kernel, floats = lanes_on_the_manifold()
    changes = [sweep(kernel, floats)]
    early = defect(kernel, floats, 0.02)
    changes += [sweep(kernel, floats) for _ in range(kernel["ORDER"] + 2)]
    assert all(later < 0.5 * before or later < 1e-15 for before, later in itertools.pairwise(changes[1:]))
    assert changes[-1] < 1e-12
    late = defect(kernel, floats, 0.02)
    assert late < 1e-10
    assert early > 1e3 * late


def test_what_has_not_relaxed_is_not_on_the_manifold():
    kernel, floats = lanes_on_the_manifold()
    for _ in range(kernel["ORDER"] + 2):
        sweep(kernel, floats)
    h = np.full(LANES, 0.02)
    for contact, state in enumerate(kernel["SLOW_STATE"]):
        floats[kernel["STATE"] + state * LANES :][:LANES] = floats[
            kernel["GUESS"] + contact * (kernel["ORDER"] + 1) * LANES :
        ][:LANES]
    kernel["jet"](floats)
    settled, near, far = kernel["settled_lanes"](floats, h, 5.0 * h)
    assert np.all(settled & near & ~far)
    scale = floats[kernel["SCALE"] + kernel["SLOW_STATE"][0] * LANES]
    floats[kernel["STATE"] + kernel["SLOW_STATE"][0] * LANES] += 2.0 * 1e-10 * scale
    kernel["jet"](floats)
    settled, near, far = kernel["settled_lanes"](floats, h, 5.0 * h)
    assert not near[0]
    assert np.all(near[1:])
    assert np.all(settled)


def test_which_states_may_be_slow():
    """One internal state of a kinked contact; laws that can stick, and those of several elements, have none."""
    table = {}
    for law in (vc.Coulomb(), vc.LuGre(), vc.Dahl(), vc.MaxwellSlip(), vc.ElastoPlastic()):
        system = vc.System(BLOCKS, [vc.LuGre(), law], vc.Harmonic())
        slow = dict(slow_bristles(equations(system)))
        assert 0 not in slow or system.state_names[slow[0]] == "bristle"
        alone = {system.state_names[state] for _, state in slow_states(equations(system))}
        wanted = {"coulomb": ("",), "lugre": ("", "_2"), "dahl": ("", "_2")}.get(law.name, ())  # else none is slaved
        assert alone == {f"{name}{end}" for name in ("bristle", "velocity") for end in wanted}
        table[law.name] = 1 in slow
    assert table == {"coulomb": False, "lugre": True, "dahl": True, "maxwell-slip": False, "elasto-plastic": False}
