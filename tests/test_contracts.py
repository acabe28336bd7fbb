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
from thinned import exhaustive_but, slow_but
from vibrocap.contracts.drive_clauses import DRIVE_CLAUSES
from vibrocap.contracts.machine_clauses import MACHINE_CLAUSES
from vibrocap.contracts.samples import (
    ImposedSample,
    draws,
    instances,
    machine_draw,
    varied,
)
from vibrocap.contracts.system_clauses import recorded
from vibrocap.physics.catalogue import controllers, drives, laws, machines
from vibrocap.physics.catalogue import law as law_of
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
# with random values, in which every term counts, and every further one
TERMS = [part for i, part in enumerate([*MACHINES, *instances(MECHANISMS)]) if i % 3 == 1 or part in FURTHER]
# every machine with a law of its own and one drive, every drive with one machine
SYSTEMS = [
    *(
        vc.System(machine(), law(), vc.Biharmonic())
        for machine, law in zip(machines().values(), itertools.cycle(laws().values()))
    ),
    *(vc.System(vc.PendulumCapsule(), vc.Exponential(), drive()) for drive in drives().values()),
]


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


@pytest.mark.parametrize("kind", [vc.LuGre, vc.ElastoPlastic, vc.RateAndStateAgeing], ids=lambda kind: kind.name)
def test_the_mirror_image_of_a_state_half_a_period_later_has_that_of_its_rates(kind):
    """Each state by its own sign: those of laws at further contacts stand before those of the first."""
    laws_of_contacts = [vc.Exponential(), kind(), vc.Dahl()]
    system = vc.System(vc.ThreeBodyCrawler(), laws_of_contacts, vc.Harmonic())
    assert system.mirrored
    for draw in draws(SAMPLES // 4):
        y = [draw.uniform(-0.1, 0.1) if name not in system.switched else 1.0 for name in system.state_names]
        t, speeds = (
            draw.uniform(0.0, 6.0),
            [y[system.state_names.index(name)] for name in system.machine.contact_states],
        )
        sides = tuple(1 if speed > 0.0 else -1 for speed in speeds)
        rates = system.rates(t, tuple(y), sides)
        image = tuple(sign * value for sign, value in zip(system.symmetry, y, strict=True))
        found = system.rates(t + 0.5 * system.drive.period, image, tuple(-side for side in sides))
        assert found == pytest.approx(
            [s * rate for s, rate in zip(system.symmetry, rates, strict=True)], rel=1e-12, abs=1e-12
        )


@pytest.mark.slow
@pytest.mark.parametrize("part", exhaustive_but(range(0, len(CHECKED), 25), CHECKED), ids=lambda part: part.name)
def test_every_part_passes_the_whole_check_its_motion_included(part):
    """Balances and estimated error of a motion, over several reversals of the laws; one compilation each, of half a
    minute in all. Canonical tests of a law (tests/test_canonical.py) use the same kernel.
    """
    report = vc.check_part(part)
    assert report.ok, str(report)
    assert report.clauses[-1].clause.startswith("It moves for some periods")


@pytest.mark.parametrize("system", SYSTEMS, ids=lambda system: f"{system.machine.name} {system.drive.name}")
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
