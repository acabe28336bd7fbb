"""The certificate and the bookkeeping of motions: ends within a period, shifts, planted faults; of random systems see
`test_simulate_reference.py`."""

import numpy as np
import pytest

import vibrocap as vc
from planted import planted
from test_contact_modes import EPSILON, TOLERANCE, stick_slip
from thinned import exhaustive_but
from vibrocap.mechanics import Contact, Drive, Machine, Mass, Spring, coordinate, cos, parameters, sin
from vibrocap.motion import evidence, trajectory
from vibrocap.motion.crossings import polynomial_slopes, polynomial_values
from vibrocap.quantities.dimensional import view

pytestmark = pytest.mark.plain


def test_a_run_may_end_within_a_period():
    system, start = stick_slip(), {"angle": 1.0}
    short, long = vc.simulate(system, periods=7.3, initial=start), vc.simulate(system, periods=8, initial=start)
    assert short.end == pytest.approx(7.3 * short.period, rel=4 * EPSILON)
    assert len(short.sections) == 8
    assert np.array_equal(short.sections, long.sections[:8])
    assert list(short.state.values()) == pytest.approx(long.states(short.end)[:, 0], abs=10 * TOLERANCE)
    assert vc.simulate(system, periods=0.25, initial=start).end == pytest.approx(0.25 * short.period, rel=4 * EPSILON)


def test_a_shift_of_position_changes_nothing_else():
    """X is cyclic: nothing depends on it."""
    here = vc.simulate(stick_slip(), periods=3, initial={"angle": 1.0})
    there = vc.simulate(stick_slip(), periods=3, initial={"angle": 1.0, "position": 4.0})
    others = [i for i, name in enumerate(here.state_names) if name != "position"]
    assert there.sections[:, others] == pytest.approx(here.sections[:, others], abs=10 * TOLERANCE)
    assert there.sections[:, 2] - 4.0 == pytest.approx(here.sections[:, 2], abs=10 * TOLERANCE)


def test_estimated_error_is_that_of_a_short_run_too_and_none_where_there_is_nothing_to_compare():
    """A run of less than a period is compared at its end; a run that stopped within its first period not at all."""
    system = vc.System(vc.PendulumCapsule(), vc.Exponential(), vc.Harmonic())
    short = vc.simulate(system, periods=0.4, initial={"angle": 1.0}, tolerance=1e-9)
    assert 0.0 < short.certificate.estimated_error < 1e-6
    stopped = vc.simulate(system, periods=3, initial={"angle": 1.0}, max_events_per_period=1)
    assert not stopped.status.ok
    assert stopped.certificate.estimated_error is None


# A block that creeps on a slow belt: friction changes by as much as the load within 1e-7 of the velocity.
CREEP = vc.System(vc.Oscillator(belt_speed=0.01, normal_load=2.0), vc.RateAndStateAgeing(), vc.Harmonic(amplitude=0.17))
CREEP_PERIODS = 5


@pytest.mark.slow
@pytest.mark.parametrize("tolerance", exhaustive_but([1], [1e-6, 1e-8, 1e-11]))
def test_works_and_impulse_are_as_exact_as_the_motion_on_implicit_steps(tolerance):
    """Friction is asked where the equations have the slopes of the dense output, not at its states.

    Before, the momentum was left by 1e-4 at any tolerance. The balances may be off by some tolerances at each of 700
    steps, over the natural sizes of momentum (2) and energy (0.5).
    """
    motion = vc.simulate(CREEP, periods=CREEP_PERIODS, tolerance=tolerance)
    certificate = motion.certificate
    assert certificate.implicit_steps > 100
    assert certificate.momentum_residual <= 2.0 * 10.0 * tolerance
    assert certificate.energy_residual <= 0.5 * 10.0 * tolerance


@planted(vc.PendulumCapsule)
class Leaking:
    """A machine of one's own, whose damper takes more than its channel says."""

    name = "leaking"

    def powers(self, t, y, drive, frictions):
        drive_power, damper = vc.PendulumCapsule.powers(self, t, y, drive, frictions)
        return drive_power, 0.5 * damper


@planted(vc.Oscillator)
class Lopsided:
    """A machine of one's own, of whose momentum a tenth is forgotten."""

    name = "lopsided"

    def momentum(self, t, y):
        return 0.9 * vc.Oscillator.momentum(self, t, y)


@parameters
class Forgetful(vc.Exponential):
    """A law of one's own that owns up to half of what it takes."""

    name = "forgetful"

    def losses(self, velocity, internal, side, load):
        sliding, bristle = vc.Exponential.losses(self, velocity, internal, side, load)
        return 0.5 * sliding, bristle


def capsule(machine=vc.PendulumCapsule, law=vc.Exponential):
    return vc.System(machine(), law(), vc.Harmonic())


BELT = vc.System(Lopsided(damping=0.3, belt_speed=0.1), vc.Coulomb(), vc.Harmonic(amplitude=0.8))


@pytest.mark.parametrize(
    ("system", "field", "words"),
    [
        (capsule(Leaking), "energy_residual", "`energy` and `powers` of the machine contradict its `rates`"),
        (BELT, "momentum_residual", "`momentum` of the machine contradicts its `rates`"),
        (capsule(law=Forgetful), "energy_residual", "`losses` and `stored_energy` of the law contradict its `force`"),
    ],
    ids=["leaking", "lopsided", "forgetful"],
)
def test_a_part_of_ones_own_whose_balance_does_not_close_is_told_so(system, field, words):
    motion = vc.simulate(system, periods=3, initial={system.state_names[0]: 0.5})
    assert motion.status is vc.Status.FINISHED
    certificate = motion.certificate
    assert motion.status is vc.Status.NOT_CERTIFIED
    assert not certificate.ok
    assert [verdict.field for verdict in certificate.verdicts if not verdict.ok] == [field]
    (failure,) = certificate.failures
    assert words in failure
    assert "flows in" in failure
    verdict = certificate.verdict(field)
    assert verdict.value == getattr(certificate, field) > 1e3 * verdict.bound
    assert not verdict.ok
    assert f"{field} " in repr(certificate)
    assert "FAILED" in repr(certificate)


@parameters
class Hoop(Machine):
    """A bead that rubs along the circle on which a carriage, which rubs on the ground, guides it."""

    name = "hoop"
    angle = coordinate("theta", "angle of the bead", "rad")
    position = coordinate("X", "place of the carriage", "m", rate="velocity")

    def parts(self, q):
        carriage = Mass("carriage", 2.0, x=q.position)
        bead = Mass("bead", 1.0, on=carriage, x=sin(q.angle), z=-cos(q.angle))
        springs = Spring(1.5, q.angle), Spring(1.0, q.position)
        rubs = Contact(carriage, load=1.0), Contact(bead, on=carriage, path=q.angle, load=0.7)
        return carriage, bead, springs, rubs, Drive(q.position)


@pytest.mark.parametrize("faulty", [None, 0, 1])
def test_a_wrong_friction_along_a_curved_path_is_noticed(faulty):
    """A hundredth of the friction at one contact is missing in the rates: it contradicts both balances."""

    @planted(Hoop)
    class Slack:
        """A hoop whose rates know less friction."""

        name = "slack"

        def equations_of_motion(self, t, y, drive, frictions):
            return None

        def rates(self, t, y, drive, frictions):
            shares = (0.99 if c == faulty else 1.0 for c in range(2))
            less = tuple(share * friction for share, friction in zip(shares, frictions, strict=True))
            return Hoop.rates(self, t, y, drive, less)

    laws = [vc.Coulomb(0.2, 0.3), vc.Coulomb(0.25, 0.3)]
    motion = vc.simulate(vc.System(Slack(), laws, vc.Harmonic(amplitude=1.2, frequency=0.8)), periods=3)
    assert {"reversal", "reversal_2", "stick_2"} <= {event.kind for event in motion.events}
    failed = [verdict.field for verdict in motion.certificate.verdicts if not verdict.ok]
    assert failed == ([] if faulty is None else ["energy_residual", "momentum_residual"])
    if faulty is not None:
        energy, momentum = motion.certificate.failures
        assert "`energy` and `powers` of the machine contradict its `rates`" in energy
        assert "`momentum` of the machine contradicts its `rates`" in momentum


def test_every_piece_of_evidence_has_a_bound_and_a_verdict():
    certificate = vc.simulate(stick_slip(), periods=3, initial={"angle": 1.0}).certificate
    judged = {verdict.field: verdict for verdict in certificate.verdicts}
    assert set(judged) == {
        *(
            "stick_force_ratio",
            "slip_shortfall",
            "event_velocity",
            "least_velocity",
            "energy_residual",
            "momentum_residual",
        ),
        *("defect", "estimated_error"),
    }
    assert [field for field, verdict in judged.items() if verdict.bound is None] == ["estimated_error"]
    assert certificate.ok
    assert all(verdict.ok for verdict in judged.values())
    record = view(certificate)
    assert record["ok"] is True
    assert record["sign_kept"] is True
    assert all(type(entry["value"]) is float for entry in record["verdicts"])


@pytest.mark.slow
@pytest.mark.parametrize(("amplitude", "names"), [(1e-6, []), (1e-12, ["displacement", "displacement rate"])])
def test_what_moves_by_little_more_than_its_error_is_named(amplitude, names):
    """A capsule that rests under a drive of the size of the tolerance; its inner mass moved by noise, certified."""
    system = vc.System(vc.TwoMassCapsule(), vc.Coulomb(0.2, 0.3), vc.Harmonic(amplitude, 0.8))
    warnings = vc.simulate(system, periods=20).certificate.warnings
    assert len(warnings) == len(names)
    assert all(f"the error of {name} is 0." in words for name, words in zip(names, warnings, strict=True))


@pytest.mark.plain(False)
def test_states_that_jump_at_events_are_not_compared():
    """The engagement of a bristle jumps by 1 where one of two runs is through an event and the other is not yet."""
    system = vc.System(vc.Oscillator(belt_speed=0.1), vc.ElastoPlastic(), vc.Harmonic(amplitude=0.7, frequency=0.9))
    motion = vc.simulate(system, periods=4, initial={"position": 0.2}, tolerance=1e-6)
    marks = [i for i, name in enumerate(motion.state_names) if name in system.friction.switched]
    assert marks
    assert (motion.certificate.estimated_error or 1.0) < 1e-3


@pytest.mark.slow
def test_what_creeps_along_a_border_of_a_law_passes_it_as_often_at_any_tolerance():
    """Errors of a step were larger than the margin of the border: 998 events in place of 163 at a tolerance of 1e-5."""
    law = vc.ElastoPlastic(bristle_stiffness=1e4, bristle_damping=100.0)
    system = vc.System(vc.Oscillator(belt_speed=0.2), law, vc.Harmonic(amplitude=0.3))
    counts = [len(vc.simulate(system, periods=20, tolerance=tolerance).events) for tolerance in (1e-5, 1e-6, 1e-9)]
    assert counts == [163] * 3


@pytest.mark.slow
def test_a_hold_is_followed_where_every_other_term_of_its_force_vanishes():
    """Stuck on a belt nothing but the drive bends the holding force, whose odd terms vanish at a crest of the drive.

    The step was one of half a period, and the contact held 1.0007 times what it can.
    """
    machine = vc.Oscillator(mass=2.1117975833816627, damping=0.05, belt_speed=0.3)
    drive = vc.Harmonic(amplitude=0.05850767505971692, frequency=2.3539289879123215)
    system, start = vc.System(machine, vc.Exponential(), drive), {"position": -0.3299267932914014}
    motion, exact = (vc.simulate(system, periods=6, initial=start, tolerance=t) for t in (1e-6, 1e-12))
    assert motion.certificate.ok
    assert motion.event_times == pytest.approx(exact.event_times, abs=1e-4)


def test_values_of_pieces_do_not_depend_on_how_they_are_asked():
    """In order, with as many points in each piece, or in any order: the same bits, and those of polynomials."""
    draw = np.random.default_rng(3)
    coefficients, points = draw.normal(size=(6, 3, 8)), 9
    index, s = np.repeat(np.arange(6), points), draw.uniform(size=6 * points)
    order = draw.permutation(len(index))
    for found, degree in ((polynomial_values, 0), (polynomial_slopes, 1)):
        inorder = found(coefficients, index, s)
        assert np.array_equal(found(coefficients, index[order], s[order]), inorder[:, order])
        for i, (piece, x) in enumerate(zip(index, s, strict=True)):
            known = [np.polyval(np.polyder(c[::-1], degree), x) for c in coefficients[piece]]
            assert inorder[:, i] == pytest.approx(known, rel=1e-13, abs=1e-13)
        assert found(coefficients, index[:0], s[:0]).shape == (3, 0)
        assert np.array_equal(found(coefficients, np.arange(6), s.reshape(6, points)).reshape(3, -1), inorder)
    uneven = np.array([0, 0, 1, 1, 1, 2])  # as many in all as would fit
    assert np.array_equal(
        polynomial_values(coefficients, uneven, s[:6]),
        np.hstack([polynomial_values(coefficients, uneven[i : i + 1], s[i : i + 1]) for i in range(6)]),
    )


@pytest.mark.parametrize("gravity", [1.0, 2.0])
def test_a_load_beyond_all_numbers_is_told_and_ends_nothing(gravity):
    """(lambda + 1) g overflows beyond 1.8e308; the motion does not ask for it under a constant load."""
    machine, around = vc.PendulumCapsule(mass_ratio=1e308), vc.Environment(gravity=gravity)
    motion = vc.simulate(vc.System(machine, vc.Exponential(), vc.Harmonic(), environment=around), periods=2)
    certificate = motion.certificate
    assert certificate.ok
    assert (certificate.least_reaction is None) == (gravity > 1.0)
    assert ("beyond all numbers" in " ".join(certificate.warnings)) == (gravity > 1.0)


CRUST = vc.RateAndStateAgeing(0.6, 0.015, 0.02, 0.1, 1e-6)  # rates of ten decades, as of crustal faults
CRUSTAL_START = {"position": -63.45, "sliding_velocity": 1e-9, "log_age": 6.9}


def crustal(damping: float, duration: float) -> vc.System:
    block = vc.Oscillator(mass=1e3, stiffness=5e5, damping=damping, belt_speed=-1e-8, normal_load=50e6)
    return vc.System(block, CRUST, vc.Constant(0.0, duration=duration))


@pytest.mark.parametrize("duration", [100.0, 1e4, 1e6])
def test_an_idle_drive_does_not_bound_the_first_step(duration):
    """The least step follows from the time at which it begins, not from the period of the drive."""
    motion = vc.simulate(crustal(0.0, duration), periods=1, initial=CRUSTAL_START)
    assert motion.status.ok
    assert motion.certificate.ok


def test_a_motion_that_did_not_finish_is_never_certified():
    runaway = vc.System(vc.PendulumCapsule(), vc.Exponential(), vc.Harmonic(1e200, 1.0))
    nothing = vc.simulate(runaway, periods=1)
    some = vc.simulate(stick_slip(), periods=5, max_steps=40, initial={"angle": 1.0})
    for motion in (nothing, some):
        assert not motion.status.ok
        assert not motion.certificate.ok
        assert "did not finish" in motion.certificate.failures[0]
        assert "passed" not in repr(motion.certificate)
    assert some.end > 0.0
    assert len(nothing.time) == len(nothing["position"]) == len(nothing["drive_work"]) == 0
    with pytest.raises(ValueError, match="ended where it began"):
        nothing.at(0.0, "position")


def test_creep_far_below_the_natural_speed_is_no_rest():
    """At 1.4e-11 m/s, beside a natural speed of 2,236, all of friction acts; a series leaves all numbers."""
    start = {"position": -60.8450348, "sliding_velocity": 1.4109896e-11, "log_age": 8.79899302}
    motion = vc.simulate(crustal(4.5e6, 1e7), periods=1, initial=start)
    assert motion.certificate.ok
    assert motion.state["sliding_velocity"] == pytest.approx(1.4e-11, rel=0.05)
    carried = (motion.state["sliding_velocity"] - 1e-8) * 1e7  # with the plate, but for its creep
    assert motion.state["position"] == pytest.approx(start["position"] + carried, abs=1e-5)


@pytest.mark.exhaustive
@pytest.mark.parametrize("duration", exhaustive_but([1], [1e7, 4.73e7]))
def test_a_crustal_cycle_closes_whatever_the_idle_drive_lasts(duration):
    start = {"position": -63.4539, "sliding_velocity": 1e-9, "log_age": 6.90776}
    cycle = vc.orbit(crustal(4.5e6, duration), initial=start)
    assert cycle.status is vc.OrbitStatus.CONVERGED
    assert cycle.period == pytest.approx(1356349683.6, rel=1e-9)


@pytest.mark.exhaustive
def test_the_impulse_of_a_long_motion_is_known_to_its_rounding():
    """An impulse of 1e17 balances to a share of 1e-14; a real gap of a share of 1e-9 is still found."""
    start = CRUSTAL_START | {"position": -63.4539, "log_age": 6.90776}
    motion = vc.simulate(crustal(4.5e6, 4.73e7), periods=100, initial=start)
    verdict = motion.certificate.verdict("momentum_residual")
    assert motion.status.ok
    assert motion.certificate.ok
    impulse = np.max(np.abs(motion.piece_marks[-1]))
    assert impulse > 1e16
    assert verdict.value < verdict.bound < 1e-9 * impulse


@pytest.mark.parametrize(
    ("machine", "law", "drive"),
    [
        pytest.param(
            *(vc.PendulumCapsule(), vc.LuGre(bristle_stiffness=1e6, bristle_damping=100.0), vc.Harmonic()),
            marks=pytest.mark.plain(False),  # ten thousand steps
        ),
        (vc.TwoBodyCrawler(), [vc.Exponential(), vc.Stribeck()], vc.Harmonic()),
    ],
    ids=["implicit steps", "two contacts"],
)
def test_many_instants_in_one_loop_are_what_few_are(machine, law, drive, monkeypatch):
    """The compiled loop gives the values and the certificate of NumPy, and notices a piece that is no motion."""
    motion = vc.simulate(vc.System(machine, law, drive), periods=3, initial={"velocity": 0.1})
    ordinary = np.flatnonzero(~motion.piece_implicit)
    s = motion.piece_length[ordinary, None] * np.linspace(0.0, 1.0, 5)
    names = (*motion.observable_names, *motion.integral_names)
    few = [motion.piece_observables(names, ordinary, s), motion.piece_states(ordinary, s)]
    monkeypatch.setattr(trajectory, "MANY", 1)
    monkeypatch.setattr(evidence, "MANY", 1)
    many = [motion.piece_observables(names, ordinary, s), motion.piece_states(ordinary, s)]
    for before, after in zip(few, many, strict=True):
        assert after == pytest.approx(before, rel=1e-12, abs=1e-12)
    again = vc.simulate(motion.system, periods=3, initial={"velocity": 0.1})
    looped = again.certificate
    monkeypatch.undo()
    assert motion.certificate.ok
    for mine, other in zip(motion.certificate.verdicts, looped.verdicts, strict=True):
        assert (mine.field, mine.ok) == (other.field, other.ok)
        assert other.value == pytest.approx(mine.value, rel=1e-6, abs=1e-13)
    spoiled = vc.simulate(motion.system, periods=3, initial={"velocity": 0.1})
    longest = ordinary[np.argmax(motion.piece_length[ordinary])]
    spoiled.series.numbers[longest, len(motion.state_names) + 1] += 1e-2  # of the second power
    monkeypatch.setattr(trajectory, "MANY", 1)
    monkeypatch.setattr(evidence, "MANY", 1)
    assert not spoiled.certificate.verdict("defect").ok
