"""One harness over all laws, machines and drives, found by looking into their folders: a new file is tested by itself.

Every part is taken with its defaults and with random values in which no parameter is zero, so that each term counts.
"""

import dataclasses
import inspect
import itertools
import math
import pickle
import pkgutil
import re
from importlib import import_module

import numpy as np
import pytest
from pydantic_core import PydanticUndefined

import vibrocap as vc
from growth import growth_terms
from law_instances import LAWS
from mechanisms import MECHANISMS
from thinned import covering, exhaustive_but, slow_but
from vibrocap.arguments import ArgumentError
from vibrocap.contracts.drive_clauses import DRIVE_CLAUSES
from vibrocap.contracts.machine_clauses import MACHINE_CLAUSES
from vibrocap.contracts.samples import (
    ImposedSample,
    draws,
    instances,
    machine_draw,
    random_internal,
    random_state,
    settled_branch,
    varied,
    within_room,
)
from vibrocap.contracts.system_clauses import recorded
from vibrocap.physics.catalogue import controllers, drives, laws, machines
from vibrocap.physics.catalogue import law as law_of
from vibrocap.physics.drives.drive import Drive, Piecewise, half_points, segment_table
from vibrocap.physics.friction.law import Law
from vibrocap.physics.parameters import ParameterError, parameter_table

EPSILON = float(np.finfo(float).eps)
CLASSES = [*laws().values(), *machines().values(), *drives().values(), *controllers().values()]
SAMPLES = 20
# the contracts, wrappers of laws and drives, and what machines share
NO_PARTS = {"law", "machine", "drive", "controller", "wrappers", "scheduled", "stops"}


WRAPPED = ("anisotropic-stribeck", "anisotropic-lugre", "backlash-dahl")
CHECKED = [*CLASSES, *map(law_of, WRAPPED)]
MACHINES, DRIVES = instances(machines().values()), instances(drives().values())
FURTHER = [
    dataclasses.replace(varied(vc.PendulumCapsule, 1), normal_load="weight"),
    dataclasses.replace(varied(vc.VibroImpactCapsule, 1), back_gap=0.3, actuation="internal"),
    dataclasses.replace(varied(vc.PendulumCapsuleWithStops, 1), restitution=0.4),
    dataclasses.replace(varied(vc.RigidStopCapsule, 1), back_gap=0.3, actuation="external"),
    dataclasses.replace(
        varied(vc.VibroImpactCapsule, 1), back_gap=0.3, stop_damping=0.2, back_stop_stiffness=7.0, back_stop_damping=0.4
    ),
    dataclasses.replace(varied(vc.OscillatorWithStops, 1), back_gap=0.5),
    dataclasses.replace(varied(vc.OscillatorWithStops, 2), belt_speed=0.0, gap=0.5, back_gap=0.5),
    dataclasses.replace(
        varied(vc.OscillatorWithStops, 1), back_gap=0.5, stop_stiffness=9.0, back_stop_stiffness=4.0, stop_damping=0.3
    ),
    dataclasses.replace(varied(vc.OscillatorWithStops, 1), stop_stiffness=9.0, belt_speed=0.0, gap=0.5, back_gap=0.5),
]
MACHINES += FURTHER
# with its defaults and one set of random values, and every further one; the second set is slow
each_machine = pytest.mark.parametrize(
    "machine",
    slow_but([i for i, part in enumerate(MACHINES) if i % 3 < 2 or part in FURTHER], MACHINES),
    ids=[f"{part.name} {i}" for i, part in enumerate(MACHINES)],
)
each_drive = pytest.mark.parametrize("drive", DRIVES, ids=[f"{part.name} {i}" for i, part in enumerate(DRIVES)])
LAWS_IN_SYSTEMS = [varied(law_of(name), 1) for name in (*laws(), "anisotropic-stribeck", "backlash-anisotropic-lugre")]
# with random values, in which every term counts, and every further one
TERMS = [part for i, part in enumerate([*MACHINES, *instances(MECHANISMS)]) if i % 3 == 1 or part in FURTHER]
# every machine with every drive that it can take, the laws in turn
PAIRS = [
    (machine, drive)
    for machine, drive in itertools.product([*instances(machines().values())[1::3], *FURTHER], DRIVES[1::3])
    if not machine.imposes_motion or (type(drive).slope is not Drive.slope and drive.continuous)
]
ALL_SYSTEMS = [
    vc.System(machine, law, drive)
    for law, (machine, drive) in zip(itertools.cycle(LAWS_IN_SYSTEMS), PAIRS, strict=False)
]
# of these, so many that every machine and every drive meets every kind of law, and every machine every kind of drive
MEETINGS = [
    (id(s.machine), s.drive.name, s.friction.name, (s.machine.name, s.friction.kind), (s.drive.name, s.friction.kind))
    for s in ALL_SYSTEMS
]
KINDS = [(s.machine.name, isinstance(s.drive, Piecewise), s.drive.odd) for s in ALL_SYSTEMS]
SYSTEMS = [ALL_SYSTEMS[i] for i in covering([(*row, kind) for row, kind in zip(MEETINGS, KINDS, strict=True)])]
# every machine with one drive, every drive with one machine
MOVING_SYSTEMS = [
    *(vc.System(machine(), vc.Exponential(), vc.Biharmonic()) for machine in machines().values()),
    *(vc.System(vc.PendulumCapsule(), vc.Exponential(), drive()) for drive in drives().values()),
]
QUICK = covering([(id(s.machine), s.drive.name, s.friction.name) for s in SYSTEMS])
KEPT = (0, 4, 11, 19, 27)  # a machine of each kind, drives without and with corners
each_system = pytest.mark.parametrize(
    "system",
    exhaustive_but(QUICK, SYSTEMS),
    ids=[f"{s.machine.name} {s.friction.name} {s.drive.name} {i}" for i, s in enumerate(SYSTEMS)],
)


# --- documentation ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("folder", ["friction", "machines", "drives", "controllers"])
def test_every_file_but_the_contract_holds_parts(folder):
    found = {"friction": laws, "machines": machines, "drives": drives, "controllers": controllers}[folder]()
    package = import_module(f"vibrocap.physics.{folder}")
    modules = {module.name for module in pkgutil.iter_modules(package.__path__)} - NO_PARTS
    assert {part.__module__.rsplit(".", 1)[1] for part in found.values()} == modules
    assert all(name == part.name and re.fullmatch(r"[a-z]+(-[a-z]+)*", name) for name, part in found.items())


@pytest.mark.parametrize("part", CLASSES, ids=lambda part: part.name)
def test_documented(part):
    assert len((part.__doc__ or "").splitlines()) >= 1
    assert part.__doc__[0].isupper()
    own = {name: value for name, value in vars(part).items() if not name.startswith("_")}
    for name, value in own.items():
        if inspect.isfunction(value) or isinstance(value, property):
            assert inspect.getdoc(getattr(part, name)), f"{part.__name__}.{name}"
    for info in parameter_table(part):
        assert info.symbol, info.name
        assert info.meaning, info.name
        assert info.name == info.name.lower()
    parameters = [info.symbol for info in parameter_table(part)]
    assert len(set(parameters)) == len(parameters)


def test_a_part_is_a_value():
    """Equal and of the same class after pickling: classes that wrappers or a number of bodies make, too."""
    values = [vc.block_row(5)(belt_speed=0.3), vc.worm(5)(mass_4=2.0), vc.crawler(5)(mass_4=2.0)]
    values += [vc.scheduled(type(drive))(periods_3=2.0) for drive in (vc.Harmonic(), vc.Square(), vc.Phases())]
    for part in (*LAWS, *MACHINES, *DRIVES, *values):
        again = pickle.loads(pickle.dumps(part))
        assert (again, type(again), hash(again)) == (part, type(part), hash(part)), part.name


# --- machines and drives, clause by clause ---------------------------------------------------------------------------


def complaints(part, *clauses):
    """What the clauses say against a part, by their names."""
    table = {clause.__name__: clause(part) for clause in clauses}
    return {name: words for name, words in table.items() if words is not None}


@each_machine
def test_machine_keeps_its_contract(machine):
    assert complaints(machine, *MACHINE_CLAUSES, recorded) == {}


def loads_of(machine, *at):
    """The load on each contact that the motion makes, under the frictions that stand last."""
    reactions = (contact.reaction for contact in machine.contacts(*at[:3]))
    return [n + sum(s * r for s, r in zip(more, at[3], strict=True)) for n, *more in reactions]


@pytest.mark.parametrize("machine", TERMS, ids=lambda machine: machine.name)
@pytest.mark.parametrize("slope", [0.0, 0.3])
def test_a_machine_keeps_its_balances_on_any_slope(machine, slope):
    """Energy and momentum along the line; equations of motion as they are told, with loads; a contact is held."""
    machine = machine.driven_by(ImposedSample()).tilted(math.cos(slope), math.sin(slope))
    count, still = len(machine.states), (0.0,) * len(machine.states)
    stored = {n: growth_terms(getattr(machine, n), count) for n in ("energy", "momentum", "line_momentum")}

    def velocities(t, y):
        told = machine.equations_of_motion(t, y) or ((), ())
        return [velocity for row in itertools.chain(*told) if row for _, velocity in row[1]]

    places = range(len(velocities(0.0, still)))
    moved = [growth_terms(lambda t, y, place=place: velocities(t, y)[place], count) for place in places]
    for draw in draws(SAMPLES // 2):
        at = t, y, drive, frictions = machine_draw(machine, draw)
        rates, contacts = machine.rates(*at), machine.contacts(t, y, drive)
        grows = {name: sum(terms(t, y, rates)) for name, terms in stored.items()}
        lost = sum(r * contact.velocity for r, contact in zip(frictions, contacts, strict=True))
        weighs = machine.gravity[1] * machine.line_momentum(t, y)
        flows = {"energy": sum(machine.powers(*at)) - lost - weighs}
        flows["momentum"] = machine.outer_force(t, y, drive) + machine.wall_force(*at) - sum(frictions)
        size = max(map(abs, (*rates, *machine.powers(*at), *flows.values(), 1.0))) ** 2
        assert {n: grows[n] for n in flows} == pytest.approx(flows, rel=0.0, abs=64 * EPSILON * size)
        rows, lifts = machine.equations_of_motion(*at) or ((), ())
        growing = (sum(terms(t, y, rates)) for terms in moved)
        names = [machine.derived.rates[each] for each in machine.derived.order][: len(rows)]
        taken = dict(zip(machine.contact_states, frictions, strict=True))
        for name, (force, pairs, share) in zip(names, rows, strict=True):
            left = force - sum(factor * next(growing) for factor, _ in pairs)
            left -= share * rates[machine.states.index(name)]
            assert left == pytest.approx((1.0 - share) * taken.get(name, 0.0), abs=64 * EPSILON * size)
        for c, lift in enumerate(lifts):
            if lift is not None:
                load = sum(factor * next(growing) for factor, _ in lift[1]) - lift[0]
                assert load == pytest.approx(loads_of(machine, *at)[c], abs=64 * EPSILON * size)
        for state, each in zip(machine.contact_states, contacts, strict=True):
            if each.response or machine.imposes_motion:
                continue
            pairs = zip(machine.contact_states, frictions, strict=True)
            held = tuple(each.holding_force if name == state else r for name, r in pairs)
            rate = machine.rates(t, y, drive, held)[machine.states.index(state)]
            assert abs(rate) <= 64 * EPSILON * size


def account_of(parts, normal, drive):
    """(energy, momentum, power without friction) of the bodies and links of a mechanism."""
    places, velocities = {"": 0.0}, {"": 0.0}
    energy = momentum = power = 0.0
    for body in parts.bodies:
        turns, sine, cosine = body.joint == "hinge", math.sin(body.place), math.cos(body.place)
        velocity = velocities[body.carrier] + (-cosine * body.rate if turns else body.rate)
        places[body.name], velocities[body.name] = body.place, velocity
        rise = -sine * body.rate if turns else 0.0
        energy += 0.5 * body.mass * (velocity * velocity + rise * rise) + 0.5 * body.stiffness * body.place**2
        energy += body.mass * normal * cosine if turns else 0.0
        momentum += body.mass * velocity
        power += (body.actuation * drive - body.damping * body.rate) * body.rate
    for link in parts.links:
        opening, rate = (found[link.ahead] - found[link.behind] for found in (places, velocities))
        energy += 0.5 * link.stiffness * opening * opening
        power += (link.actuation * drive - link.damping * rate) * rate
    return energy, momentum, power


@pytest.mark.parametrize("machine", TERMS, ids=lambda machine: machine.name)
def test_a_mechanism_has_the_energy_the_momentum_and_the_powers_of_the_machine(machine):
    for draw in draws(SAMPLES // 2):
        t, y, drive, frictions = machine_draw(machine, draw)
        if (parts := machine.mechanism(t, y)) is None:
            return
        normal = 0.0 if machine.gravity is None else machine.gravity[0]
        power = sum(machine.powers(t, y, drive, (0.0,) * len(frictions)))
        wanted = machine.energy(t, y), machine.line_momentum(t, y), power
        size = (1.0 + max(map(abs, (*y, drive, *wanted)))) ** 2
        assert account_of(parts, normal, drive) == pytest.approx(wanted, rel=0.0, abs=64 * EPSILON * size)


@pytest.mark.parametrize("machine", [*MACHINES, *instances(MECHANISMS)], ids=lambda machine: machine.name)
def test_a_machine_says_whether_it_is_its_own_mirror_image(machine):
    """The conditions on its numbers hold where rates, loads and guards of the mirrored state are the mirror image."""
    values = []
    for draw in draws(SAMPLES // 2):
        t, y, drive, frictions = machine_draw(machine.driven_by(ImposedSample()), draw)
        y = tuple(0.1 * x if name not in machine.switched else x for name, x in zip(machine.states, y, strict=True))
        for sign in (1.0, -1.0):
            made, later = machine.driven_by(ImposedSample(sign)), 0.0 if machine.imposes_motion else 0.2 * sign
            at = t + later, tuple(sign * x for x in y), sign * drive, tuple(sign * friction for friction in frictions)
            loads = loads_of(made, *at) if machine.follows_load else []
            values.append([*(sign * rate for rate in made.rates(*at)), *loads, *sorted(made.switches(*at))])
    pairs = [pair for i in range(0, len(values), 2) for pair in zip(*values[i : i + 2], strict=True)]
    same = all(abs(a - b) <= 1e3 * EPSILON * (1.0 + abs(a)) for a, b in pairs)
    assert machine.symmetric == same


@each_drive
def test_drive_keeps_its_contract(drive):
    assert complaints(drive, *DRIVE_CLAUSES, recorded) == {}


# --- systems ---------------------------------------------------------------------------------------------------------


def system_draw(system, draw):
    """(t, y, sides of all contacts), the velocities agreeing with the sides."""
    machine = system.placed
    mechanical, t = list(within_room(machine, random_state(machine.states, draw))), draw.uniform(0, 9)
    contact, count = machine.states.index(machine.contact_states[0]), len(machine.contact_states)
    side = draw.choice((1, -1))
    mechanical = list(settled_branch(machine, t, tuple(mechanical), 0.0, (0.0,) * count))
    speed = abs(mechanical[contact])
    mechanical[contact] += side * speed - machine.contacts(t, mechanical, 0.0)[0].velocity
    internal = random_internal(system.friction, side * speed, side, system.machine.loads()[0], draw)
    sides, further = [side], []
    for law, each in zip(system.laws[1:], machine.contacts(t, mechanical, 0.0)[1:], strict=True):
        sides.append(1 if each.velocity > 0.0 else -1)
        further += random_internal(law, each.velocity, sides[-1], 1.0, draw)
    return t, (*mechanical, *further, *internal), tuple(sides)


def opposite(sides):
    """The sides of the mirror image."""
    return tuple(-side for side in sides)


UNEVEN = {"second_amplitude", "level", "rate", "start", "force"}  # parameters of drives that are odd only without them
UNEVEN |= {f"level_{i}" for i in range(1, 8)} | {f"{wave}_{n}" for wave in ("cosine", "sine") for n in (2, 4, 6)}
EVEN = {  # parameters of drives that are odd only with these; no stroke from 0 to its end is ever odd
    "square": {"duty": 0.5},
    "on-off": {"amplitude": 1.2, "offset": -0.6, "duty": 0.5},
    "triangle": {"rise": 0.5},
    "trapezoid": {"rise": 0.2, "hold": 0.3, "fall": 0.2},
    "three-phase": None,
    "seven-phase": None,
}


@each_system
def test_half_period_symmetry(system):
    """S: (y, side, t) -> (-y, -side, t + T/2) maps rates to their mirror image for an odd drive, to rounding."""
    even = EVEN.get(system.drive.name, {})
    if even is None:
        assert not system.mirrored
        return
    names = {info.name for info in parameter_table(system.drive)}
    drive = dataclasses.replace(system.drive, **{**dict.fromkeys(names & UNEVEN, 0.0), **even})
    machine = system.machine
    if not machine.symmetric:
        names = {info.name for info in parameter_table(machine)}
        others = {"back_gap": machine.gap} if "back_gap" in names else {}
        others |= dict.fromkeys(names & {"back_stop_stiffness", "back_stop_damping"})
        level = names & {"belt_speed", "track_angle", "contact_stiffness", "table_speed", "motor_speed"}
        machine = dataclasses.replace(machine, **others, **dict.fromkeys(level, 0.0))
    friction = system.friction
    if not friction.symmetric:
        friction = dataclasses.replace(friction, back_ratio=friction.forward_ratio)
    odd = dataclasses.replace(system, machine=machine, drive=drive, friction=friction)
    if not machine.symmetric:  # whatever its parameters: its mirror image has its bodies in the other order
        assert machine.name in ("linkage-crawler", "bristle-robot", "clutch", "feeder")
        return
    assert odd.mirrored
    harmonic = 7 if drive.name == "fourier-series" else 1  # the highest: its phase n w t is rounded n times as much
    for draw in draws(SAMPLES):
        t, y, side = system_draw(odd, draw)
        rates = odd.rates(t, y, side)
        mirror = tuple(sign * v for sign, v in zip(odd.symmetry, y, strict=True))
        mirrored = odd.rates(t + odd.drive.period / 2, mirror, opposite(side))
        size = 1.0 + max(map(abs, rates))
        for sign, rate, found in zip(odd.symmetry, rates, mirrored, strict=True):
            assert abs(found - sign * rate) <= 64 * EPSILON * size * (1.0 + harmonic * t)


@each_system
def test_asymmetric_drive_breaks_the_symmetry(system):
    if system.drive.odd or (system.machine.imposes_motion and system.drive.name == "constant"):
        return  # a displacement that stays is no motion
    t, y, side = system_draw(system, draws(1)[0])
    times = [t]
    if isinstance(system.drive, Piecewise):  # which may be odd but for a short while
        times = [share * system.drive.period for share in half_points(segment_table(system.drive))]
    mirror = tuple(sign * v for sign, v in zip(system.symmetry, y, strict=True))
    pairs = [
        (system.rates(t + system.drive.period / 2, mirror, opposite(side)), system.rates(t, y, side)) for t in times
    ]
    driven = 0, 1, system.machine.states.index(system.machine.contact_states[0])
    assert max(abs(mirrored[i] + rates[i]) for mirrored, rates in pairs for i in driven) > 1e-3


@each_system
def test_energy_of_a_system(system):
    """d(machine + contact)/dt = sum of the powers of all channels, sliding and stuck."""
    count, internal = len(system.placed.states), len(system.state_names) - len(system.placed.states)
    gained = growth_terms(system.placed.energy, count)

    def stored_by_laws(t, z):
        total = 0.0
        for law in (*system.laws[1:], system.friction):
            own, z = z[: len(law.internal)], z[len(law.internal) :]
            total = total + (0.0 if system.machine.follows_load else law.stored_energy(own))
        return total

    stored = growth_terms(stored_by_laws, internal)
    for draw in draws(SAMPLES // 3):
        t, y, side = system_draw(system, draw)
        contact = system.machine.states.index(system.machine.contact_states[0])
        for mode in (side, (0, *side[1:])) if system.friction.kind == "set-valued" else (side,):
            if mode[0] == 0:
                # 0 but where the drive imposes a motion
                rest = y[contact] - system.placed.contacts(t, y, 0.0)[0].velocity
                y = tuple(rest if i == contact else v for i, v in enumerate(y))
            flow = system.flow(t, y, mode)
            growth = sum((*gained(t, y[:count], flow.rates[:count]), *stored(t, y[count:], flow.rates[count:])))
            size = max(map(abs, (*flow.rates, *flow.powers, flow.drive, 1.0))) ** 2
            assert abs(growth - sum(flow.powers)) <= 32 * EPSILON * size
            assert len(flow.powers) == len(system.channels)
            if mode[0] == 0:
                assert system.machine.imposes_motion or flow.rates[contact] == 0.0
                assert flow.contacts[0].friction == flow.contacts[0].held


@pytest.mark.parametrize(
    "system",
    slow_but([list(machines()).index("pendulum-capsule")], exhaustive_but(KEPT, MOVING_SYSTEMS)),  # a compilation each
    ids=lambda system: f"{system.machine.name} {system.drive.name}",
)
def test_motions_from_random_starts_are_finite(system):
    for draw in draws(3):
        _, y, _ = system_draw(system, draw)
        motion = None
        while motion is None:  # from nearer to rest where the machine would lift off at once
            try:
                start = dict(zip(system.state_names, y, strict=True))
                motion = vc.simulate(system, periods=2, initial=start, samples=16)
            except ArgumentError as error:
                if "would lift off at once" not in str(error):
                    raise
                y = [0.5 * each for each in y]
        ended = {vc.Status.LIFT_OFF} if system.machine.follows_load else set()
        ended |= {vc.Status.STOP_REACHED} if system.machine.bound_kinds else set()
        ended |= {vc.Status.AMBIGUOUS_CONTACTS} if system.machine.name == "linkage-crawler" else set()
        assert motion.status.ok or motion.status in ended
        assert all(np.all(np.isfinite(motion[name])) for name in motion.names)


@pytest.mark.slow
@pytest.mark.parametrize("part", exhaustive_but(range(0, len(CHECKED), 10), CHECKED), ids=lambda part: part.name)
def test_every_part_passes_the_whole_check_its_motion_included(part):
    """Balances and estimated error of a motion, over several reversals of the laws; one compilation each, of half a
    minute in all. Canonical tests of a law (tests/test_canonical.py) use the same kernel.
    """
    report = vc.check_part(part)
    assert report.ok, str(report)
    assert report.clauses[-1].clause.startswith("It moves for some periods")


@each_system
def test_parameters_can_be_read_and_changed_by_path(system):
    for path in system.parameter_paths:
        value = system.parameter(path)
        if isinstance(value, float):
            changed = system.with_parameters({path: 1.01 * value})
            assert changed.parameter(path) == 1.01 * value
            assert changed.with_parameters({path: value}) == system
    near = system.parameter_paths[0]
    with pytest.raises(ValueError, match=f"no such parameter in this system; did you mean {near!r}"):
        system.parameter(near + "s")


RECORDS = [*CLASSES, law_of("anisotropic-lugre"), vc.PendulumScales, vc.InnerMassScales, vc.FreeScales]


@pytest.mark.parametrize("part", RECORDS, ids=lambda part: part.__name__)
def test_names_and_values_that_a_part_does_not_take_are_refused_in_our_words(part):
    """Of every part: the field, what would be right, and nothing of the library that looks at them."""
    table = {info.name: info.default for info in parameter_table(part)}
    table = {name: 1.0 if value is PydanticUndefined else value for name, value in table.items()}
    name = next(name for name, value in table.items() if isinstance(value, float))
    with pytest.raises(ParameterError) as caught:
        part(**{**{key: value for key, value in table.items() if key != name}, f"{name}s": 1.0})
    assert f"{name}s: there is no such parameter; did you mean '{name}'?" in caught.value.complaints
    with pytest.raises(ParameterError) as caught:
        part(**{**table, name: "much"})
    assert str(caught.value) == f"{part.__name__}: {name}: should be a number, got 'much'"
    assert caught.value.__context__ is None
    assert str(pickle.loads(pickle.dumps(caught.value))) == str(caught.value)


def test_all_that_a_part_refuses_is_named_at_once():
    with pytest.raises(ValueError, match="mas_ratio: there is no such parameter; did you mean 'mass_ratio'") as caught:
        vc.PendulumCapsule(mas_ratio=1, damping=-1.0)  # type: ignore[call-arg]
    assert "damping: should be at least 0, got -1.0" in str(caught.value)
    system = vc.System(vc.PendulumCapsule(), vc.Exponential(), vc.Harmonic())
    with pytest.raises(ValueError, match=r"^the system: machine.mass_ratio: should be greater than 0, got -1.0$"):
        system.with_parameters({"machine.mass_ratio": -1.0})


def test_a_part_in_the_wrong_place_is_refused():
    with pytest.raises(TypeError, match="friction should be a law"):
        vc.System(vc.PendulumCapsule(), vc.Harmonic(), vc.Harmonic())  # type: ignore[arg-type]
    assert not isinstance(vc.Harmonic(), Law)
