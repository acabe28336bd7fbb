"""One harness over all laws, machines and drives, found by looking into their folders: a new file is tested by itself.

Every part is taken with its defaults and with random values in which no parameter is zero, so that each term counts.
"""

import dataclasses
import inspect
import itertools
import math
import pkgutil
import random
import re
from importlib import import_module

import numpy as np
import pytest

import vibrocap as vc
from vibrocap.catalogue import drives, laws, machines
from vibrocap.friction.law import Law
from vibrocap.numerics.graph import Graph, derivative, evaluate
from vibrocap.parameters import parameter_table

EPSILON = float(np.finfo(float).eps)
CLASSES = [*laws().values(), *machines().values(), *drives().values()]
SAMPLES = 60


def varied(part, seed):
    """A part with every number changed at random by up to a fifth; a zero becomes a number too."""
    draw = random.Random(f"{part.name} {seed}")
    values = {info.name: info.default for info in parameter_table(part)}
    return part(
        **{
            name: (value * draw.uniform(0.8, 1.2) or draw.uniform(0.2, 0.5)) if isinstance(value, float) else value
            for name, value in values.items()
        }
    )


def instances(parts):
    return [make for part in parts.values() for make in (part(), varied(part, 1), varied(part, 2))]


LAWS, MACHINES, DRIVES = instances(laws()), instances(machines()), instances(drives())
MACHINES += [dataclasses.replace(MACHINES[1], normal_load="weight")]
each_law = pytest.mark.parametrize("law", LAWS, ids=[f"{part.name} {i}" for i, part in enumerate(LAWS)])
each_machine = pytest.mark.parametrize("machine", MACHINES, ids=[f"{part.name} {i}" for i, part in enumerate(MACHINES)])
each_drive = pytest.mark.parametrize("drive", DRIVES, ids=[f"{part.name} {i}" for i, part in enumerate(DRIVES)])
SYSTEMS = [vc.System(*parts) for parts in itertools.product(MACHINES[1::2], LAWS[1::3], DRIVES[1::3])]
each_system = pytest.mark.parametrize(
    "system", SYSTEMS, ids=[f"{s.machine.name} {s.friction.name} {s.drive.name} {i}" for i, s in enumerate(SYSTEMS)]
)


def draws(count=SAMPLES, seed="contracts"):
    return [random.Random(f"{seed} {i}") for i in range(count)]


def random_motion(law, draw):
    """(velocity, internal states, side, load) of a contact, internal states within their natural size."""
    side, load = draw.choice((1, -1)), draw.uniform(0.3, 2.0)
    internal = tuple(draw.uniform(-1, 1) * scale for scale in law.internal_scales(load))
    return side * draw.uniform(0.0, 1.0) ** 3, internal, side, load


def random_state(names, draw):
    return tuple(draw.uniform(-1.2, 1.2) for _ in names)


# --- documentation ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("folder", ["friction", "machines", "drives"])
def test_every_file_but_the_contract_holds_one_part(folder):
    found = {"friction": laws, "machines": machines, "drives": drives}[folder]()
    package = import_module(f"vibrocap.{folder}")
    modules = {module.name for module in pkgutil.iter_modules(package.__path__)} - {"law", "machine", "drive"}
    assert {part.__module__.rsplit(".", 1)[1] for part in found.values()} == modules
    assert all(name == part.name and re.fullmatch(r"[a-z]+(-[a-z]+)*", name) for name, part in found.items())


@pytest.mark.parametrize("part", CLASSES, ids=lambda part: part.name)
def test_documented(part):
    assert len((part.__doc__ or "").splitlines()) >= 1
    assert part.__doc__[0].isupper()
    own = {name: value for name, value in vars(part).items() if not name.startswith("_")}
    for name, value in own.items():
        if inspect.isfunction(value) or isinstance(value, property):
            assert value.__doc__, f"{part.__name__}.{name}"
    for info in parameter_table(part):
        assert info.symbol, info.name
        assert info.meaning, info.name
        assert info.name == info.name.lower()
    parameters = [info.symbol for info in parameter_table(part)]
    assert len(set(parameters)) == len(parameters)


# --- friction laws ---------------------------------------------------------------------------------------------------


@each_law
def test_law_is_odd(law):
    """(-v, -z, -side) gives (-R, -z') and the same losses and stored energy, exactly."""
    for draw in draws():
        velocity, internal, side, load = random_motion(law, draw)
        mirrored = (-velocity, tuple(-z for z in internal), -side, load)
        force, rates = law.force(velocity, internal, side, load)
        assert law.force(*mirrored) == (-force, tuple(-rate for rate in rates))
        assert law.losses(*mirrored) == law.losses(velocity, internal, side, load)
        assert law.stored_energy(mirrored[1]) == law.stored_energy(internal)


@each_law
def test_law_is_finite(law):
    for draw in draws():
        velocity, internal, side, load = random_motion(law, draw)
        for speed in (velocity, 0.0, side * 1e-300, side * 1e3):
            force, rates = law.force(speed, internal, side, load)
            assert all(map(math.isfinite, (force, *rates, *law.losses(speed, internal, side, load))))
        assert math.isfinite(law.steady_force(abs(velocity), load))


@each_law
def test_steady_force_is_the_force_that_a_constant_velocity_settles_to(law):
    for draw in draws():
        velocity, internal, side, load = random_motion(law, draw)
        velocity = velocity or 0.1 * side
        for _ in range(3):  # internal rates are affine in the internal state here: Newton's method ends at once
            force, rates = law.force(velocity, internal, side, load)
            if not rates:
                break
            step = 0.5 * law.internal_scales(load)[0]
            slope = (law.force(velocity, (internal[0] + step,), side, load)[1][0] - rates[0]) / step
            internal = (internal[0] - rates[0] / slope,)
        force, rates = law.force(velocity, internal, side, load)
        assert all(abs(rate) <= 1e-12 * abs(velocity) for rate in rates)
        assert force == pytest.approx(side * law.steady_force(abs(velocity), load), rel=1e-10)


@each_law
def test_friction_force_scales_with_the_load(law):
    """N once (erratum 1): with deflections in proportion, twice the load is twice the force of a dry contact."""
    for draw in draws(10):
        speed, _, _, load = random_motion(law, draw)
        dry = dataclasses.replace(law, viscous_damping=0.0) if hasattr(law, "viscous_damping") else law
        twice, once = dry.steady_force(abs(speed), 2 * load), dry.steady_force(abs(speed), load)
        assert twice == pytest.approx(2 * once, rel=4 * EPSILON)


@each_law
def test_kind_of_law_is_what_it_claims(law):
    """Set-valued: a jump at rest, to no more than what it holds. Kinked: the force goes on, its rates do not."""
    internal = tuple(0.3 * scale for scale in law.internal_scales(1.3))
    forward, back = (law.force(0.0, internal, side, 1.3)[0] for side in (1, -1))
    if law.kind == "set-valued":
        assert law.internal == ()
        assert forward == -back > 0.0
        assert forward <= law.holding_limit(1.3) * (1 + 4 * EPSILON)
    else:
        assert forward == back
        with pytest.raises(NotImplementedError):
            law.holding_limit(1.3)
        ahead = [law.force(1e-6 * side, internal, side, 1.3)[0] - forward for side in (1, -1)]
        smooth = ahead[0] == pytest.approx(-ahead[1], rel=1e-3)
        assert smooth == (law.kind == "smooth")


@each_law
def test_energy_of_the_contact_is_accounted_for(law):
    """R v = d(stored)/dt + contact sliding + bristle loss."""
    for draw in draws():
        velocity, internal, side, load = random_motion(law, draw)
        graph = Graph()
        z = tuple(graph.node("state", i) for i in range(len(internal)))
        stored = graph.expression(law.stored_energy(z))
        slopes = evaluate([derivative(stored, i) for i in range(len(z))], 0.0, internal, side, ())
        force, rates = law.force(velocity, internal, side, load)
        growth = sum(slope * rate for slope, rate in zip(slopes, rates, strict=True))
        losses = law.losses(velocity, internal, side, load)
        size = abs(force * velocity) + abs(growth) + sum(map(abs, losses))
        assert abs(force * velocity - growth - sum(losses)) <= 8 * EPSILON * size


@each_law
def test_a_law_that_claims_to_be_passive_never_gives_energy(law):
    assert isinstance(law.passive, bool)
    losses = [sum(law.losses(*random_motion(law, draw))) for draw in draws(400)]
    if law.passive:
        assert min(losses) >= 0.0


def test_a_law_that_is_not_passive_gives_energy_somewhere():
    """The paper's LuGre values: the claim is no idle one. At its bound it is passive."""
    law = vc.LuGre()
    assert not law.passive
    assert min(sum(law.losses(*random_motion(law, draw))) for draw in draws(4000)) < 0.0
    assert dataclasses.replace(law, viscous_damping=1.001 * 10.0 * 0.3 / 0.15).passive
    assert not dataclasses.replace(law, viscous_damping=0.999 * 10.0 * 0.3 / 0.15).passive


# --- machines --------------------------------------------------------------------------------------------------------


def machine_draw(machine, draw):
    return draw.uniform(0, 9), random_state(machine.states, draw), draw.uniform(-2, 2), draw.uniform(-1, 1)


@each_machine
def test_holding_force_gives_exactly_zero_contact_acceleration(machine):
    """Not nearly: a stuck contact is integrated with it, and must not creep."""
    contact = machine.states.index(machine.contact_state)
    for draw in draws():
        t, y, drive, _ = machine_draw(machine, draw)
        hold = machine.holding_force(t, y, drive)
        assert machine.rates(t, y, drive, hold)[contact] == 0.0
        assert machine.rates(t, y, drive, hold + 0.1)[contact] < 0.0 < machine.rates(t, y, drive, hold - 0.1)[contact]


@each_machine
def test_contact_state_moves_one_to_one_with_the_contact_velocity(machine):
    contact = machine.states.index(machine.contact_state)
    for draw in draws(10):
        t, y, _, _ = machine_draw(machine, draw)
        moved = tuple(v + 0.25 if i == contact else v for i, v in enumerate(y))
        found = machine.contact_velocity(t, moved) - machine.contact_velocity(t, y)
        assert found == pytest.approx(0.25, rel=8 * EPSILON)


def along(machine, function, t, y, rates):
    """d/dt of a function of the mechanical state, by its recorded partial derivatives."""
    graph = Graph()
    recorded = function(t, tuple(graph.node("state", i) for i in range(len(y))))
    slopes = evaluate([derivative(recorded, i) for i in range(len(y))], t, y, 1.0, ())
    return sum(slope * rate for slope, rate in zip(slopes, rates, strict=True))


@each_machine
def test_energy_and_momentum_of_a_machine(machine):
    """dH/dt = sum of powers - R v, and p' = -R, at any state, drive and friction force."""
    for draw in draws():
        t, y, drive, force = machine_draw(machine, draw)
        rates = machine.rates(t, y, drive, force)
        powers = machine.powers(t, y, drive)
        assert len(powers) == len(machine.channels)
        expected = sum(powers) - force * machine.contact_velocity(t, y)
        size = max(map(abs, (*rates, *powers, 1.0))) ** 2
        assert abs(along(machine, machine.energy, t, y, rates) - expected) <= 16 * EPSILON * size
        assert abs(along(machine, machine.momentum, t, y, rates) + force) <= 16 * EPSILON * size


@each_machine
def test_symmetry_of_a_machine(machine):
    """Its signs turn a motion into a motion, for the reversed drive and friction, exactly."""
    for draw in draws():
        t, y, drive, force = machine_draw(machine, draw)
        mirror = tuple(sign * v for sign, v in zip(machine.symmetry, y, strict=True))
        rates = machine.rates(t, y, drive, force)
        expected = tuple(sign * rate for sign, rate in zip(machine.symmetry, rates, strict=True))
        assert machine.rates(t, mirror, -drive, -force) == expected
        assert machine.contact_velocity(t, mirror) == -machine.contact_velocity(t, y)
        assert machine.holding_force(t, mirror, -drive) == -machine.holding_force(t, y, drive)
        assert machine.energy(t, mirror) == machine.energy(t, y)


@each_machine
def test_nothing_depends_on_the_cyclic_state(machine):
    place = machine.states.index(machine.cyclic)
    for draw in draws(10):
        t, y, drive, force = machine_draw(machine, draw)
        moved = tuple(v + 7.0 if i == place else v for i, v in enumerate(y))
        assert machine.rates(t, moved, drive, force) == machine.rates(t, y, drive, force)
        assert machine.energy(t, moved) == machine.energy(t, y)


@each_machine
def test_load_and_scales_are_positive(machine):
    assert machine.load() > 0.0
    assert len(machine.scales()) == len(machine.states)
    assert min(machine.scales()) > 0.0


# --- drives ----------------------------------------------------------------------------------------------------------


@each_drive
def test_drive_is_periodic_and_as_odd_as_it_says(drive):
    times = [draw.uniform(0.0, 2.0) * drive.period for draw in draws()]
    size = max(abs(drive.value(t)) for t in times)
    assert size > 0.0
    for t in times:
        assert abs(drive.value(t + drive.period) - drive.value(t)) <= 64 * EPSILON * size
    asymmetry = max(abs(drive.value(t + drive.period / 2) + drive.value(t)) for t in times)
    assert (asymmetry <= 64 * EPSILON * size) == drive.odd
    assert len({round(drive.value(t * 0.37), 3) for t in times}) > 10  # no constant, which would be periodic too


def test_a_second_harmonic_breaks_the_symmetry():
    assert vc.Biharmonic().odd
    assert not vc.Biharmonic(second_amplitude=1e-3).odd


# --- systems ---------------------------------------------------------------------------------------------------------


def system_draw(system, draw):
    """(t, y, side), the velocity agreeing with the side."""
    mechanical = list(random_state(system.machine.states, draw))
    contact = system.machine.states.index(system.machine.contact_state)
    side = draw.choice((1, -1))
    mechanical[contact] = side * abs(mechanical[contact])
    scales = system.friction.internal_scales(system.machine.load())
    internal = [draw.uniform(-1, 1) * scale for scale in scales]
    return draw.uniform(0, 9), (*mechanical, *internal), side


@each_system
def test_half_period_symmetry(system):
    """S: (y, side, t) -> (-y, -side, t + T/2) maps rates to their mirror image for an odd drive, to rounding."""
    drive = dataclasses.replace(system.drive, second_amplitude=0.0) if not system.drive.odd else system.drive
    odd = dataclasses.replace(system, drive=drive)
    assert odd.drive.odd
    for draw in draws():
        t, y, side = system_draw(odd, draw)
        rates = odd.rates(t, y, side)
        mirror = tuple(sign * v for sign, v in zip(odd.symmetry, y, strict=True))
        mirrored = odd.rates(t + odd.drive.period / 2, mirror, -side)
        size = 1.0 + max(map(abs, rates))
        for sign, rate, found in zip(odd.symmetry, rates, mirrored, strict=True):
            assert abs(found - sign * rate) <= 64 * EPSILON * size


@each_system
def test_asymmetric_drive_breaks_the_symmetry(system):
    if system.drive.odd:
        return
    t, y, side = system_draw(system, draws(1)[0])
    mirror = tuple(sign * v for sign, v in zip(system.symmetry, y, strict=True))
    mirrored = system.rates(t + system.drive.period / 2, mirror, -side)
    assert abs(mirrored[1] + system.rates(t, y, side)[1]) > 1e-3


@each_system
def test_energy_of_a_system(system):
    """d(machine + contact)/dt = sum of the powers of all channels, sliding and stuck."""
    count = len(system.machine.states)
    for draw in draws():
        t, y, side = system_draw(system, draw)
        for mode in (side, 0) if system.friction.kind == "set-valued" else (side,):
            if mode == 0:
                y = tuple(0.0 if i == system.machine.states.index("velocity") else v for i, v in enumerate(y))
            flow = system.flow(t, y, mode)
            growth = along(system.machine, system.machine.energy, t, y[:count], flow.rates[:count])
            graph = Graph()
            z = tuple(graph.node("state", i) for i in range(len(y) - count))
            stored = graph.expression(system.friction.stored_energy(z))
            slopes = evaluate([derivative(stored, i) for i in range(len(z))], t, y[count:], 1.0, ())
            growth += sum(slope * rate for slope, rate in zip(slopes, flow.rates[count:], strict=True))
            size = max(map(abs, (*flow.rates, *flow.powers, 1.0))) ** 2
            assert abs(growth - sum(flow.powers)) <= 32 * EPSILON * size
            assert len(flow.powers) == len(system.channels)
            if mode == 0:
                assert flow.rates[system.machine.states.index(system.machine.contact_state)] == 0.0
                assert flow.friction == flow.holding_force


@pytest.mark.parametrize(
    "system", SYSTEMS[:5], ids=lambda s: f"{s.friction.name} {s.drive.name}"
)  # one compilation each
def test_motions_from_random_starts_are_finite(system):
    for draw in draws(3):
        _, y, _ = system_draw(system, draw)
        motion = vc.simulate(system, periods=2, initial=dict(zip(system.state_names, y, strict=True)), samples=16)
        assert motion.status.ok
        assert all(np.all(np.isfinite(motion[name])) for name in motion.names)


@each_system
def test_parameters_can_be_read_and_changed_by_path(system):
    for path in system.parameter_paths:
        value = system.parameter(path)
        if isinstance(value, float):
            changed = system.with_parameters({path: 1.01 * value})
            assert changed.parameter(path) == 1.01 * value
            assert changed.with_parameters({path: value}) == system
    near = system.parameter_paths[0]
    with pytest.raises(KeyError, match=re.escape(near)):
        system.parameter(near + "s")


def test_a_part_in_the_wrong_place_is_refused():
    with pytest.raises(TypeError, match="friction should be a law"):
        vc.System(vc.PendulumCapsule(), vc.Harmonic(), vc.Harmonic())  # type: ignore[arg-type]
    assert not isinstance(vc.Harmonic(), Law)
