"""Contacts that act on one another: closed forms, all ways in which they can go on, and what is made of them."""

import itertools
import math

import numpy as np
import pytest

import vibrocap as vc
from plain_kernels import kernel_of, running_on
from thinned import exhaustive_but
from vibrocap.numerics.kernel.events.transitions import ARRIVED
from vibrocap.physics.catalogue import machines
from vibrocap.physics.contacts import determinant, solution
from vibrocap.physics.events import AMBIGUOUS, BOUNDS

pytestmark = pytest.mark.plain

COULOMB, UNEVEN = vc.Coulomb(0.1, 0.1), vc.anisotropic(vc.Coulomb)(0.1, 0.1, back_ratio=2.0)
LINKAGE_DRIVE = vc.Biharmonic(amplitude=0.5, frequency=1.3, second_amplitude=0.15, second_phase=0.5)
LINKAGE = vc.System(vc.LinkageCrawler(mass_ratio_2=1.7, stiffness=4.0), COULOMB, LINKAGE_DRIVE)


def worm(drive, friction=UNEVEN, **given):
    """Two unequal bodies."""
    return vc.System(vc.TwoBodyWorm(mass_2=1.5, normal_load_2=1.2), friction, drive, **given)


def sides_after(motion, time):
    """Modes of all contacts in the piece that holds after a time."""
    piece = int(np.searchsorted(motion.piece_start, time, side="right")) - 1
    return tuple(int(side) for side in motion.piece_sides[piece])


@pytest.mark.parametrize(
    "system",
    [
        pytest.param(LINKAGE, id="linkage", marks=pytest.mark.exhaustive),
        pytest.param(worm(vc.Harmonic(amplitude=0.5, frequency=0.9)), id="worm"),
    ],
)
def test_at_every_event_one_set_of_modes_can_go_on_and_it_is_the_one_that_is_taken(system):
    """Shortly after: a contact that has begun to slide moves then."""
    motion = vc.simulate(system, periods=6)
    times = [event.time for event in motion.events]
    assert len(times) > 20
    for time, following in itertools.pairwise([*times, motion.end]):
        if following - time < 1e-3:
            continue
        after = time + 1e-4
        state = {name: float(motion.at(np.array([after]), name)[0]) for name in motion.state_names}
        modes = vc.contact_modes(system, state, after, still=1e-11)
        assert [mode.sides for mode in modes] == [sides_after(motion, after)]


@pytest.mark.parametrize("law", [COULOMB, vc.anisotropic(vc.Coulomb)(0.1, 0.1, back_ratio=1.4)], ids=["even", "uneven"])
def test_contacts_that_come_to_rest_at_one_instant_take_the_only_set_of_modes(law):
    """Worms at random whose distances turn round while their centre stands, whatever the sides before: all meet."""
    draw, members = np.random.default_rng(8), set()
    for _ in range(25):
        bodies = int(draw.integers(2, 5))
        table = {name: float(draw.uniform(0.3, 2.0)) for name in vc.worm(bodies).__dataclass_fields__}
        drive = vc.Harmonic(amplitude=float(draw.uniform(0.02, 0.5)) * float(draw.choice([-1.0, 1.0])))
        system = vc.System(vc.worm(bodies)(**table), law, drive)
        sides = draw.choice([-1.0, 1.0], bodies)
        (found,) = vc.contact_modes(system)
        kernel = kernel_of(system)
        kernel.fill("SIDE", 0.0 * sides)
        kernel.fill("CAME_FROM", sides)
        kernel.fill("TRANSITION", [ARRIVED] * bodies)
        kernel["decide_together"](kernel.floats, kernel.ints, 0)
        taken = kernel.floats[kernel.place("SIDE") :][:bodies]
        assert tuple(taken) == found.sides
        members.add(sum(side == 0 for side in found.sides))
    assert members == {0, 1}


def assert_it_sways(motion, body, apart=0.0):
    """Its centre stands, and so it is known; all bodies turn at one instant, or at times so little apart."""
    machine, z = motion.system.machine, motion.system.drive
    times = np.linspace(0.0, motion.end, 200)
    ahead = [body * (z.value(float(t)) - z.value(0.0)) for t in times]
    assert motion.status is vc.Status.FINISHED
    assert motion.at(times, "position") == pytest.approx(ahead, abs=motion.tolerance)
    turns = [{other.kind for other in motion.events if abs(other.time - e.time) <= apart} for e in motion.events]
    ends = {"reversal", f"reversal_{machine.bodies}"}
    assert ends in turns or (apart > 0.0 and any(ends <= turn for turn in turns))
    assert motion.certificate.ok


def test_a_worm_that_is_its_own_mirror_image_sways_about_its_centre():
    even = vc.anisotropic(vc.Coulomb)(back_ratio=1.0)  # Coulomb's law, in the form of `worm`
    assert_it_sways(vc.simulate(vc.System(vc.TwoBodyWorm(), even, vc.Harmonic()), periods=40), -0.5)


@pytest.mark.slow
def test_the_first_contact_is_decided_though_it_is_said_to_move_by_rounding():
    """Of a slow symmetric worm the second contact comes to rest first, by rounding."""
    settings = {"mass": 1.386, "mass_2": 1.386, "actuation": -1.0, "normal_load": 1.394, "normal_load_2": 1.394}
    machine = vc.TwoBodyWorm(**settings)
    for friction, frequency in itertools.product((0.0757, 0.2), (0.113, 0.13)):
        law = vc.Stribeck(coulomb_coefficient=friction, static_coefficient=0.227)
        system = vc.System(machine, law, vc.Harmonic(amplitude=0.6813, frequency=frequency))
        assert vc.simulate(system, periods=2, tolerance=1e-13).status is vc.Status.FINISHED


# --- closed forms -----------------------------------------------------------------------------------------------------


@pytest.mark.slow
def test_a_slow_anisotropic_worm_gains_its_whole_stroke():
    """As long as M |u| z'' and friction forward are less than the body behind can hold, bodies go forward only."""
    slow = vc.Harmonic(amplitude=0.5, frequency=0.15)
    assert 2.5 * 0.6 * 0.5 * 0.15**2 + 0.12 < 0.2
    motion = vc.simulate(worm(slow), periods=4, tolerance=1e-13)
    assert motion.state["position"] == pytest.approx(4 * 2 * 0.5, abs=1e-12)
    assert vc.stick_fraction(motion, contact=1) == pytest.approx(0.5, abs=1e-12)
    assert vc.stick_fraction(motion, contact=2) == pytest.approx(0.5, abs=1e-12)
    assert motion.certificate.ok


@pytest.mark.slow
def test_bodies_at_a_distance_that_stays_are_one_block():
    """Stopped by both contacts after v^2/(2 mu (N_1 + N_2)/M); while they rest they share what is held."""
    machine = vc.TwoBodyWorm(mass_2=1.5, normal_load_2=1.2, actuation=0.0)
    system = vc.System(machine, COULOMB, vc.Harmonic(), environment=vc.Environment(force=0.1))
    motion = vc.simulate(system, periods=3, initial={"centre_velocity": 0.6})
    assert motion.state["position"] == pytest.approx(0.6**2 / (2 * (0.1 * 2.2 - 0.1) / 2.5), abs=1e-12)
    assert {"stick", "stick_2"} <= set(motion.event_kinds)
    assert motion["friction"][-1] == pytest.approx(0.1 / 2.2, abs=1e-15)
    assert motion["friction_2"][-1] == pytest.approx(0.1 * 1.2 / 2.2, abs=1e-15)
    assert "is open" in motion.certificate.warnings[0]
    (found,) = vc.contact_modes(system, motion.state)
    assert found.sides == (0, 0)
    assert not found.determined


@pytest.mark.parametrize("rotated", [0.0, 1.2])
def test_bodies_that_rest_together_part_however_slowly_their_distance_begins_to_change(rotated):
    """z' = z'' = 0 at the start: the body whose friction is larger stays, the other goes ahead by z."""
    waves: dict[str, float] = {}
    for k, amplitude in ((1, 0.4), (2, -0.2)):
        waves |= {f"cosine_{k}": amplitude * math.sin(k * rotated), f"sine_{k}": amplitude * math.cos(k * rotated)}
    system = worm(vc.FourierSeries(**waves))
    start = vc.Start(0.0, phase=-0.5 * rotated / math.pi)
    with running_on(kernel_of(system, order=8)):
        motion = vc.simulate(system, periods=0.05, tolerance=1e-8, start=start)
    assert sides_after(motion, 0.0) == (0, 1)
    assert motion.events[0].kind == "slip_back"
    assert motion.at([motion.events[0].time], "position") == pytest.approx(0.0, abs=1e-12)
    assert motion.certificate.ok


def test_a_load_that_is_negative_at_a_further_contact_is_refused_at_the_start():
    """Contact 2 would be pulled whatever contact 1 at rest does; where contact 1 slides, that decides its own load."""
    system = vc.System(vc.LinkageCrawler(), vc.Coulomb(0.2, 0.3), vc.Harmonic())
    with pytest.raises(ValueError, match=r"the normal load on contact 2 is negative at the start, -0\.4"):
        vc.simulate(system, initial={"displacement": 0.219, "velocity_2": -2.04})
    moving = {"displacement": 0.361009, "velocity_2": 1.79063}  # contact 1, at rest, slides at once
    assert len(vc.simulate(system, initial=moving, periods=1).piece_length)


# --- one way to go on, or several -------------------------------------------------------------------------------------


def least_determinant(system, state):
    """Of all modes of contacts at rest, as the run watches it."""
    flow = system.flow(0.0, tuple(state.values()), 0.0)
    ambiguous = 4  # see vibrocap.physics.events.BOUNDS
    return min(float(b) for b, kind in zip(flow.bounds, flow.bound_kinds, strict=True) if kind == ambiguous)


def ways(machine, friction, state, level, push=0.0):
    """How many sets of modes can go on from a state, under a force between the bodies and one from outside."""
    around = vc.Environment(force=push)
    system = vc.System(machine, vc.Coulomb(friction, friction), vc.Constant(level), environment=around)
    return len(vc.contact_modes(system, state))


def test_linear_problems_of_contacts_are_solved_and_their_pivots_told():
    draw = np.random.default_rng(3)
    for n in (1, 2, 3, 4):
        rows = draw.uniform(-0.4, 0.4, (n, n)) + np.eye(n)
        right = draw.uniform(-1.0, 1.0, n)
        found, pivots = solution(rows.tolist(), right.tolist())
        assert found == pytest.approx(np.linalg.solve(rows, right), rel=1e-12, abs=1e-14)
        minors = [determinant(rows[:i, :i].tolist()) for i in range(1, n + 1)]
        assert minors == pytest.approx(np.cumprod(pivots), rel=1e-12)
        assert minors[-1] == pytest.approx(np.linalg.det(rows), rel=1e-12)


def test_there_is_one_way_to_go_on_for_every_force_exactly_where_all_determinants_are_positive():
    """Linkages at random, at rest, under many forces: never two sets inside. Outside there are three somewhere.

    Far outside, that is: where several sets begin to hold the loads of some are not yet positive.
    """
    draw, inside = np.random.default_rng(4), 0
    while inside < 8:
        friction, stance, ratios = draw.uniform(0.1, 1.2), draw.uniform(0.4, 1.8), draw.uniform(0.3, 2.0, 2)
        machine = vc.LinkageCrawler(mass_ratio=ratios[0], mass_ratio_2=ratios[1], stance=stance)
        state = dict.fromkeys(machine.states, 0.0)
        if least_determinant(vc.System(machine, vc.Coulomb(friction, friction), vc.Constant(0.0)), state) > 0.0:
            inside += 1
            forces = draw.uniform(-4.0, 4.0, (20, 2)).tolist()
            assert all(ways(machine, friction, state, *force) <= 1 for force in forces)  # none: lift-off
    machine = vc.LinkageCrawler(mass_ratio=0.2, mass_ratio_2=0.2, stance=0.6)
    for friction in (0.5, 0.8, 1.5):
        state = dict.fromkeys(machine.states, 0.0)
        assert least_determinant(vc.System(machine, vc.Coulomb(friction, friction), vc.Constant(0.0)), state) < 0.0
        assert max(ways(machine, friction, state, level) for level in np.linspace(-3.0, 3.0, 61).tolist()) == 3


@pytest.mark.parametrize("sides", [(0, 0), (1, 0), (0, -1), (1, -1)])
@pytest.mark.parametrize("law_2", [vc.anisotropic(vc.Coulomb)(0.3, 0.5, back_ratio=1.4), vc.SmoothedTanh(0.3, 0.4)])
def test_the_determinants_that_a_run_watches_are_those_of_all_modes_within_reach(sides, law_2):
    """Of R = f N, N = n - C R where a contact slides, of A R/A_ii where it rests; f: both levels from rest."""
    laws = [vc.anisotropic(vc.Coulomb)(0.2, 0.6, back_ratio=1.7), law_2]
    system = vc.System(vc.LinkageCrawler(mass_ratio=0.7, mass_ratio_2=0.4, stance=0.8), laws, vc.Constant(0.2))
    state = dict.fromkeys(system.state_names, 0.1) | {"velocity": 0.3 * sides[0], "velocity_2": 0.3 * sides[1]}
    flow = system.flow(0.0, tuple(state.values()), sides)
    A, C = np.array(flow.rows.A, float), np.array(flow.rows.C, float)
    assert np.all(np.abs(C) > 1e-3)
    rows = []
    for i, (law, side) in enumerate(zip(laws, sides, strict=True)):
        velocity = state[("velocity", "velocity_2")[i]]
        if law.kind == "set-valued" and side == 0:
            middle, limit = law.holding_centre(1.0), law.holding_limit(1.0)
            levels, rest = (middle + limit, middle - limit), [A[i] / A[i, i]]
        else:
            levels, rest = (law.force(velocity, (), side, 1.0)[0],) * (3 if law.kind == "set-valued" else 1), []
        rows.append(rest + [np.eye(2)[i] + level * C[i] for level in levels])
    wanted = [np.linalg.det(choice) for choice in itertools.product(*rows)]
    ambiguous = [float(b) for b, kind in zip(flow.bounds, flow.bound_kinds, strict=True) if BOUNDS[kind] == AMBIGUOUS]
    assert ambiguous == pytest.approx(wanted, rel=1e-13)
    assert np.ptp(wanted) > 0.01 or not any(
        law.kind == "set-valued" and side == 0 for law, side in zip(laws, sides, strict=True)
    )


@pytest.mark.parametrize("way", [1.0, -1.0])
def test_loads_tell_nothing_where_the_mode_of_a_start_is_ambiguous(way):
    """Both feet slide one way, and the determinant of that mode is negative, as are the loads that solve it."""
    steep = vc.LinkageCrawler(mass_ratio=0.2, mass_ratio_2=0.2, stance=0.4)
    system = vc.System(steep, vc.Coulomb(1.2, 1.2), vc.Constant(0.35))
    start = {"velocity": 0.5 * way, "velocity_2": 0.5 * way}
    assert vc.simulate(system, periods=0.05, initial=start).status is vc.Status.AMBIGUOUS_CONTACTS


@pytest.mark.slow
def test_a_run_ends_where_the_way_to_go_on_is_no_longer_certain():
    """Steep rods on rough ground: both feet come to rest where, under other forces, three sets of modes could go on."""
    machine = vc.LinkageCrawler(mass_ratio=0.6, mass_ratio_2=0.6, stance=0.8, stiffness=1.0)
    system = vc.System(machine, vc.Coulomb(0.8, 0.8), vc.Harmonic(amplitude=1.2, frequency=0.5))
    motion = vc.simulate(system, periods=5, initial={"displacement": 0.2}, start=2.0)
    assert motion.status is vc.Status.AMBIGUOUS_CONTACTS
    assert "ways to continue" in motion.status.text
    event = motion.events[-1]
    assert event.kind == "ambiguous_contacts"
    assert event.time == motion.end
    forces = [vc.System(machine, system.friction, vc.Constant(float(f))) for f in np.linspace(-8, 8, 400)]
    assert max(len(vc.contact_modes(force, motion.state, still=1e-9)) for force in forces) == 3
    # on smoother ground the same motion goes on
    smooth = vc.System(machine, vc.Coulomb(0.3, 0.3), system.drive)
    assert vc.simulate(smooth, periods=2, initial={"displacement": 0.2}, start=2.0).status is not motion.status


# --- everything else works on them ------------------------------------------------------------------------------------


def test_machines_of_more_bodies_are_found_by_name_and_wrong_ones_refused():
    assert list(machines()) == sorted(machines())
    assert not {"hundred-body-worm", "hundred-body-crawler"}.intersection(machines())
    for machine in (vc.worm(5), vc.crawler(5)):
        assert machines()[machine.name] is machine
    with pytest.raises(ValueError, match=r"bodies should be a whole number from 2 to 20, got 21"):
        vc.worm(21)
    with pytest.raises(ValueError, match=r"normal_load_2: should be greater than 0, got 0"):
        vc.TwoBodyWorm(normal_load_2=0.0)
    with pytest.raises(ValueError, match=r"the waveform square jumps, while the two-body-worm takes it for a displace"):
        worm(vc.Square())
    with pytest.raises(ValueError, match=r"stance: should be less than 1\.9"):
        vc.LinkageCrawler(stance=2.0)
    with pytest.raises(ValueError, match=r"initial.displacement should be at most 0\.75"):
        vc.simulate(LINKAGE, periods=1, initial={"displacement": 0.9})
    with pytest.raises(ValueError, match=r"time should be a finite number, got 'now'"):
        vc.contact_modes(LINKAGE, time="now")  # type: ignore[arg-type]
    with pytest.raises(ValueError, match=r"initial.displacment: no such state; did you mean 'displacement'"):
        vc.contact_modes(LINKAGE, {"displacment": 0.1})


@pytest.mark.slow
@pytest.mark.parametrize(
    "drive",
    exhaustive_but([0], [vc.Harmonic(), vc.Biharmonic(amplitude=0.0, second_amplitude=1.0, second_phase=0.3)]),
)
def test_the_multiplier_of_an_orbit_whose_contacts_turn_at_one_instant(drive):
    """Through such a turn no tangent goes; with the harmonic drive it even falls on the section."""
    system = vc.System(vc.TwoBodyWorm(), vc.Coulomb(), drive)
    orbit = vc.orbit(system)
    assert orbit.status is vc.OrbitStatus.CONVERGED
    assert orbit.response_period == 1
    ends = []
    for push in (1e-3, -1e-3):
        start = orbit.state | {"centre_velocity": orbit.state["centre_velocity"] + push}
        ends.append(vc.simulate(system, periods=1, initial=start, tolerance=1e-12)["centre_velocity"][-1])
    slope = (ends[0] - ends[1]) / 2e-3
    assert 0.4 < slope < 0.6
    assert orbit.multipliers[0] == pytest.approx(slope, abs=1e-6)  # differences over 1e-3 and over 1e-5


@pytest.mark.slow
def test_an_orbit_whose_section_finds_a_further_contact_at_rest():
    """The one coordinate of a worm is then given by its drive: nothing is free, and no multiplier is left over."""
    system = worm(vc.Harmonic(amplitude=0.5, frequency=0.15), COULOMB)  # the second body rests for ever
    orbit = vc.orbit(system, initial=vc.simulate(system, periods=3).state)
    rests = vc.simulate(system, periods=1, initial=orbit.state)
    assert np.all(rests.piece_sides[:, 1] == 0.0)
    assert abs(orbit.drift) < 1e-10
    assert np.max(np.abs(orbit.multipliers), initial=0.0) == 0.0
