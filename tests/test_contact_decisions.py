"""Which contacts rest and which slide where: against an independent solver, mirror images, and all modes tried."""

import collections
import dataclasses
import functools
from unittest import mock

import numpy as np
import pytest

import vibrocap as vc
from independent import decided, random_problem
from independent import motion as independent_motion
from plain_kernels import kernel_of
from thinned import exhaustive_but
from vibrocap.numerics.kernel.events.transitions import ARRIVED

TOLERANCE = 1e-10
TRAPEZOID = vc.Trapezoid(amplitude=0.4, rise=0.2, hold=0.3, fall=0.2)


def named(name, values):
    """Parameters or states of all bodies or gaps."""
    return {name if i == 1 else f"{name}_{i}": float(value) for i, value in enumerate(values, start=1)}


def on_laws(machine, laws, drive):
    """A system with a law for each contact."""
    return vc.System(machine, list(laws), drive)


# --- the same motion seen otherwise -----------------------------------------------------------------------------------


@dataclasses.dataclass(frozen=True)
class Row:
    """A crawler or a worm by its bodies, from behind; reach: of a worm, by how much of the drive each is ahead."""

    kind: str
    masses: tuple
    loads: tuple
    laws: tuple
    drive: vc.Harmonic | vc.Trapezoid
    velocities: tuple
    reach: tuple = ()
    springs: tuple = ()  # (stiffness, damping, actuation, opening) of each gap

    @property
    def system(self):
        bodies = named("mass", self.masses) | named("normal_load", self.loads)
        if self.kind == "worm":
            machine = vc.worm(len(self.masses))(**bodies, **named("actuation", np.diff(self.reach)))
        else:
            words = ("stiffness", "damping", "actuation")
            gaps = [named(word, column) for word, column in zip(words, zip(*self.springs, strict=True), strict=False)]
            machine = vc.crawler(len(self.masses))(**bodies, **gaps[0], **gaps[1], **gaps[2])
        return on_laws(machine, self.laws, self.drive)

    @property
    def start(self):
        if self.kind == "worm":
            return {"centre_velocity": self.velocities[0]}
        return named("displacement", [gap[3] for gap in self.springs]) | named("velocity", self.velocities)

    def reordered(self, order):
        """A worm whose bodies have other numbers: at imposed distances they may stand anywhere."""
        picked = {name: tuple(getattr(self, name)[i] for i in order) for name in ("masses", "loads", "laws", "reach")}
        return dataclasses.replace(self, **picked)

    @property
    def mirrored(self):
        """Seen from the other side."""
        table = {name: getattr(self, name)[::-1] for name in ("masses", "loads", "springs")}
        table["laws"] = tuple(turned(law) for law in self.laws[::-1])
        table["velocities"] = tuple(-v for v in self.velocities[::-1])
        table["reach"] = tuple(-ahead for ahead in self.reach[::-1])
        return dataclasses.replace(self, **table)


def turned(law):
    """A law with its directions exchanged."""
    if not law.wrappers:
        return law
    return dataclasses.replace(law, forward_ratio=law.back_ratio, back_ratio=law.forward_ratio)


def drawn(kind, laws, seed, drives=("harmonic", "trapezoid")):
    """A row of three to five bodies at random, half of them from joint rest."""
    draw = np.random.default_rng([seed, len(laws), len(kind)])
    bodies = int(draw.integers(3, 6)) if kind == "worm" else 3
    levels = draw.uniform(0.05, 0.2, bodies)

    def law(i):
        name = laws[i % len(laws)]
        static = float(levels[i] + (draw.uniform(0.02, 0.2) if seed % 4 else 0.0))
        settings = {"coulomb_coefficient": float(levels[i]), "static_coefficient": static}
        if name == "uneven":
            return vc.anisotropic(vc.Coulomb)(**settings, forward_ratio=0.8, back_ratio=float(draw.uniform(0.9, 1.6)))
        if name == "lugre":
            return vc.LuGre(**settings, bristle_stiffness=40.0, bristle_damping=1.0)
        return vc.Stribeck(**settings) if name == "stribeck" else vc.Coulomb(**settings)

    drive = TRAPEZOID
    if drives[seed % len(drives)] == "harmonic":
        drive = vc.Harmonic(float(draw.uniform(0.3, 0.6)), float(draw.uniform(0.5, 1.5)))
    still = seed % 2 == 0
    velocities = np.zeros(bodies) if still else draw.uniform(-0.2, 0.2, bodies)
    gaps = [draw.uniform(0.5, 2.0, bodies - 1), draw.uniform(0.05, 0.3, bodies - 1), draw.uniform(0.5, 1.5, bodies - 1)]
    return Row(
        kind,
        tuple(draw.uniform(0.3, 2.0, bodies).tolist()),
        tuple(draw.uniform(0.5, 1.5, bodies).tolist()),
        tuple(map(law, range(bodies))),
        drive,
        tuple(velocities.tolist()) if kind == "crawler" else (float(velocities[0]),) * bodies,
        tuple(np.cumsum(draw.uniform(-1.0, 1.0, bodies)).tolist()),
        tuple(zip(*(each.tolist() for each in (*gaps, np.zeros(bodies - 1))), strict=True)),
    )


def turns(run, numbers=None, mirrored=False):
    """{(contact, what it does): its instants}, but where something cancels within an instant."""
    table: dict = {}
    for event in run.events:
        word, _, number = event.kind.rpartition("_")
        contact, word = (int(number), word) if number.isdigit() else (1, event.kind)
        if word in ("graze", "switch"):
            continue
        if mirrored:
            word = {"slip_forward": "slip_back", "slip_back": "slip_forward"}.get(word, word)
        table.setdefault((contact if numbers is None else numbers[contact - 1], word), []).append(event.time)
    return table


def assert_same_turns(ours, theirs, within):
    """Of the same contacts, at the same instants."""
    assert ours.keys() == theirs.keys()
    for what, times in ours.items():
        assert times == pytest.approx(theirs[what], abs=within), what


def growth(row, run):
    """What a small shift of the start grows to: a factor, not a reference."""
    name = "centre_velocity" if row.kind == "worm" else "velocity"
    start = row.start | {name: row.start[name] + 1e-7}
    shifted = vc.simulate(row.system, initial=start, periods=2.1, tolerance=TOLERANCE)
    return max(1.0, *(abs(shifted.state[state] - run.state[state]) / 1e-7 for state in row.system.machine.states))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("kind", "laws"),
    exhaustive_but([1], [("crawler", ("coulomb", "uneven")), ("worm", ("coulomb", "uneven")), ("worm", ("stribeck",))]),
)
@pytest.mark.parametrize("seed", exhaustive_but([1], list(range(24))))
def test_the_mirror_image_of_a_row_moves_as_its_mirror_image(seed, kind, laws):
    """Bodies in reverse order, velocities and directions exchanged: of crawlers and worms under four kinds of laws."""
    row = drawn(kind, laws, seed)
    runs = [
        vc.simulate(each.system, initial=each.start, periods=2.1, tolerance=TOLERANCE) for each in (row, row.mirrored)
    ]
    assert [run.status for run in runs] == [vc.Status.FINISHED] * 2
    bodies, allowed = len(row.masses), 10.0 * TOLERANCE * growth(row, runs[0])
    speeds = [[float(run.at(run.end, name)[0]) for name in velocity_names(bodies)] for run in runs]
    assert speeds[1][::-1] == pytest.approx([-v for v in speeds[0]], abs=allowed)
    numbers = list(range(bodies, 0, -1))
    assert_same_turns(turns(runs[0]), turns(runs[1], numbers, mirrored=True), 1e4 * allowed)


def velocity_names(bodies):
    """Observables of all contacts."""
    return ["contact_velocity", *(f"contact_velocity_{i}" for i in range(2, bodies + 1))]


@pytest.mark.slow
@pytest.mark.parametrize("laws", exhaustive_but([1], [("coulomb",), ("coulomb", "uneven", "stribeck")]))
@pytest.mark.parametrize("seed", exhaustive_but([0], list(range(24))))
def test_the_numbers_of_the_bodies_of_a_worm_do_not_matter(seed, laws):
    """Nor from joint rest, from which several of them may break loose at one instant."""
    row = drawn("worm", laws, seed)
    order = np.random.default_rng(seed).permutation(len(row.masses)).tolist()
    other = row.reordered(order)
    runs = [vc.simulate(each.system, initial=each.start, periods=2.1, tolerance=TOLERANCE) for each in (row, other)]
    assert [run.status for run in runs] == [vc.Status.FINISHED] * 2
    allowed = 10.0 * TOLERANCE * growth(row, runs[0])
    assert runs[1].state["centre_velocity"] == pytest.approx(runs[0].state["centre_velocity"], abs=allowed)
    assert_same_turns(turns(runs[0]), turns(runs[1], [i + 1 for i in order]), 1e4 * allowed)


# --- two faults that were found --------------------------------------------------------------------------------------


@pytest.mark.slow
def test_a_linkage_does_not_lift_off_at_a_mode_that_is_only_tried():
    """Its one consistent mode has the loads 0.69 and 1.18; a run said "lift off"."""
    machine = vc.LinkageCrawler(
        0.7390469690451256, 0.6378975579718758, 3.748193676517796, 0.15251608496499786, 1.0338485014112793
    )
    laws = vc.Coulomb(0.1317464388578602, 0.19534951279671986), vc.Coulomb(0.23665875866094122, 0.40745976085955493)
    system = on_laws(machine, laws, vc.Square(amplitude=0.49717137376395265, frequency=2.4522025270561825))
    start = {
        "displacement": -0.08592786490476095,
        "velocity_2": 0.08587628822090053,
        "position": -0.149425812111275,
        "velocity": -0.09232250209287096,
    }
    run = vc.simulate(system, initial=start, periods=4, tolerance=TOLERANCE)
    assert run.status is vc.Status.FINISHED
    assert run.certificate.ok, run.certificate.failures
    theirs = independent_motion(system, start, 4)
    assert theirs.status == "finished"
    for name in system.machine.states:
        assert run.state[name] == pytest.approx(theirs.state[name], abs=10.0 * TOLERANCE * 10.0)


# --- ramps and long worms --------------------------------------------------------------------------------------------


RAMPED = [vc.TwoBodyCrawler(mass_2=1.4), vc.ThreeBodyCrawler(normal_load_3=1.3), vc.LinkageCrawler(stiffness=4.0)]


RAMPED_ON = [vc.Coulomb(0.1, 0.15), vc.LuGre(coulomb_coefficient=0.1, static_coefficient=0.15)]


@pytest.mark.slow
@pytest.mark.parametrize("machine", exhaustive_but([0], RAMPED), ids=lambda machine: machine.name)
@pytest.mark.parametrize("law", exhaustive_but([0], RAMPED_ON))
def test_a_ramp_on_several_contacts_is_certified(machine, law):
    """A saw-tooth, whose force jumps where a period ends."""
    system = vc.System(machine, law, vc.Ramp(rate=0.15, start=-0.1, duration=5.0))
    run = vc.simulate(system, periods=3, initial={"velocity": 0.1}, tolerance=TOLERANCE)
    assert run.status is vc.Status.FINISHED
    assert len(run.events) > 3
    assert run.certificate.ok, run.certificate.failures
    theirs = independent_motion(system, {"velocity": 0.1}, 3)
    for name in machine.states:
        assert run.state[name] == pytest.approx(theirs.state[name], abs=100.0 * TOLERANCE)


# --- decisions by themselves ------------------------------------------------------------------------------------------


@functools.cache
def contacts_of(n):
    """A plain kernel with so many contacts, which are told what accelerates them and what they hold."""
    return kernel_of(vc.System(vc.crawler(n)(), vc.Coulomb(), vc.Harmonic()), order=8)


def groups(response):
    """Of each contact the first that friction, at whatever remove, has to do with it."""
    reach = np.linalg.matrix_power(np.abs(response) + np.eye(len(response)), len(response)) > 0.0
    return tuple(int(np.argmax(row)) for row in reach)


def kernel_decision(problem, asked, came, sides):
    """Sides of all contacts as the kernel decides them; () where it finds none, or several."""
    n = len(sides)
    kernel = contacts_of(n)
    names = kernel.names

    def rows(floats, _t, _point, _lane, out):
        values = [*problem.free, *problem.response.ravel(), *problem.loads]
        for each in zip(problem.sliding, problem.least, problem.most, problem.down, problem.up, strict=True):
            values += [each[0], 0.0, 0.0, *each[1:]]
        values += [*problem.raised.ravel()]
        floats[out : out + len(values)] = values

    likes = [next(j for j in range(n) if np.array_equal(problem.response[j], problem.response[i])) for i in range(n)]
    settings = {"contact_rows": rows, "DYNAMIC": bool(problem.raised.any()), "ROW_LIKE": tuple(likes)}
    settings |= {"GROUP": (0,) * n} if problem.raised.any() else {"GROUP": groups(problem.response)}
    settings |= {"SHARED": len(set(likes)) < n, "STICKS": (1,) * n}
    with mock.patch.dict(names, settings):
        kernel.fill("STATUS", 0)
        kernel.fill("SIDE", [0.0 if i in asked else float(sides[i]) for i in range(n)])
        kernel.fill("CAME_FROM", [float(sides[i]) if i in came else 0.0 for i in range(n)])
        kernel.fill("GAVE_WAY", [0] * n)
        kernel.fill("TRANSITION", [ARRIVED if i in asked else 0 for i in range(n)])
        names["decide_together"](kernel.floats, kernel.ints, 0)
        if kernel.ints[kernel.place("STATUS")]:
            return ()
        return tuple(int(kernel.floats[kernel.place("SIDE") + i]) for i in range(n))


def assert_decided_as_by_enumeration(seeds):
    """Of each of two to six contacts; returns how many rest in how many of them."""
    counter = collections.Counter()
    for seed in seeds:
        problem, asked, came, sides = random_problem(np.random.default_rng(seed))
        asked = [i for i in asked if problem.most[i] > problem.least[i]]
        if len(sides) == 1 or not asked:
            continue
        theirs = decided(problem, asked, came & {*asked}, sides)
        expected = tuple(theirs.get(i, side) for i, side in sides.items())
        assert kernel_decision(problem, asked, came & {*asked}, sides) == expected, seed
        counter[sum(side == 0 for side in expected)] += 1
    return counter


PASSED = (881, 1001)  # seeds in which it matters who slid until now


@pytest.mark.slow
def test_decisions_are_those_of_all_modes_tried():
    """Independent contacts, coupled ones, imposed distances, loads that follow friction; joint rests and drops."""
    assert set(assert_decided_as_by_enumeration([*range(150), *PASSED])) >= {0, 1, 2, 3}
