"""Equilibria: closed forms of steady sliding and of rest, eigenvalues, folds and Hopf points with their errors."""

import math
import pickle

import mpmath
import numpy as np
import pytest

import vibrocap as vc
from cases import printed, refused
from thinned import exhaustive_but, slow_but
from vibrocap.arguments import ArgumentError
from vibrocap.orbits.equilibria import bifurcations
from vibrocap.orbits.equilibria.steady_states import SteadyEquations

ZERO_PROGRESS = vc.Constant()


def belt(law, drive=ZERO_PROGRESS, **machine):
    return vc.System(vc.Oscillator(**machine), law, drive)


def test_steady_sliding_on_a_belt():
    """k x = R(v_b), and lambda^2 + (c + R'(v)) lambda + k = 0 for mass 1, R the force against the sliding."""
    (found,) = vc.equilibria(belt(vc.Exponential(0.5, 1.0, 2.0), damping=0.1, belt_speed=1.5)).sliding
    force, slope = 0.5 + 0.5 * math.exp(-3.0), -math.exp(-3.0)
    assert found.state["position"] == pytest.approx(force - 0.1 * 0.0, abs=1e-14)
    assert found.state["sliding_velocity"] == -1.5
    assert found.sides == (-1,)
    roots = np.roots([1.0, 0.1 + slope, 1.0])
    assert sorted(found.eigenvalues, key=np.imag) == pytest.approx(sorted(roots, key=np.imag), abs=1e-14)
    assert found.stable is True
    assert found.frequency == pytest.approx(abs(roots[0].imag), abs=1e-14)
    assert len(vc.equilibria(found.system)) == 1  # what sticks on a moving belt is none


def crust(stiffness=5e5):
    """A system of the sizes of crustal friction, its steady state in closed form and the critical stiffness."""
    a, b, level = 0.015, 0.02, 0.6
    mass, load, length, reference, speed = 1e6, 50e6, 0.1, 1e-6, 1e-8
    law = vc.RateAndStateAgeing(level, a, b, length, reference)
    machine = {"mass": mass, "stiffness": stiffness, "normal_load": load, "belt_speed": -speed}
    system = belt(law, vc.Constant(0.0, duration=1e4), **machine)
    place = -load * (level + (a - b) * math.log(speed / reference)) / stiffness
    return system, place, speed, (b - a) * load / length * (1.0 + mass * speed**2 / (a * load * length))


def test_equilibria_of_sizes_that_differ_by_ten_decades():
    """One state of steady sliding, unstable below (b - a)(N/D_c)(1 + m v^2/(a N D_c)) (Rice and Ruina 1983).

    The first Lyapunov coefficient of the Hopf point is 3.4e-16 (80 digits), of terms of 5: it has no sign in doubles.
    """
    for stiffness in (5e5, 5e6):
        system, place, speed, critical = crust(stiffness)
        (found,) = vc.equilibria(system)
        assert found.state["position"] == pytest.approx(place, rel=1e-9)
        assert found.state["sliding_velocity"] == pytest.approx(speed, rel=1e-9)
        assert found.stable is bool(stiffness > critical)
    (hopf,) = vc.equilibrium_branch(system, "machine.stiffness", (1e5, 1e8)).special_points
    assert hopf.kind is vc.SpecialKind.HOPF
    assert abs(hopf.parameter - critical) <= hopf.error < 1e-12 * critical
    assert hopf.criticality == "degenerate"


def test_interval_of_rest():
    """|F - k x| <= static level."""
    (found,) = vc.equilibria(belt(vc.Coulomb(1.0, 1.5), vc.Constant(0.3), stiffness=2.0))
    assert found.kind == "rest"
    assert (found.dimension, found.stable) == (1, True)
    assert found.least["position"] == pytest.approx((0.3 - 1.5) / 2.0, abs=1e-12)
    assert found.most["position"] == pytest.approx((0.3 + 1.5) / 2.0, abs=1e-12)


def test_set_of_rest_of_several_contacts():
    """Two blocks in a row: |k x1 + k12 (x1 - x2)| <= F and so on: a polygon, whose extent along each block follows."""
    row = vc.TwoBlockRow(stiffness=1.0, coupling_stiffness=1.2, belt_speed=0.0)
    state = vc.equilibria(vc.System(row, vc.Coulomb(0.4, 0.4), ZERO_PROGRESS))[0]
    assert state.dimension == 2
    matrix = np.array([[2.2, -1.2], [-1.2, 2.2]])
    corners = np.array([np.linalg.solve(matrix, [a, b]) for a in (-0.4, 0.4) for b in (-0.4, 0.4)])
    assert state.most["position"] == pytest.approx(np.max(corners[:, 0]), abs=1e-12)
    assert state.least["position_2"] == pytest.approx(np.min(corners[:, 1]), abs=1e-12)


def test_bristles_at_rest_hold_what_friction_can_hold():
    (found,) = vc.equilibria(belt(vc.LuGre(), stiffness=2.0))
    level = vc.LuGre().static_coefficient
    assert found.most["position"] == pytest.approx(level / 2.0, rel=1e-9)
    assert found.most["bristle"] == pytest.approx(level / vc.LuGre().bristle_stiffness, rel=1e-9)
    assert found.stable is None  # the rates of bristles have a kink at rest


def test_equilibria_of_a_pendulum_are_those_of_its_spring():
    """sin(theta) = rho theta: three states, the middle one a saddle."""
    states = vc.equilibria(vc.System(vc.PendulumCapsule(stiffness=0.5), vc.Exponential(), ZERO_PROGRESS))
    angle = float(mpmath.findroot(lambda x: mpmath.sin(x) - x / 2, 1.9))
    assert [state.state["angle"] for state in states] == pytest.approx([-angle, 0.0, angle], abs=1e-12)
    assert [state.stable for state in states] == [True, False, True]


def test_steady_travel_down_a_slope_is_steady_up_to_the_drift():
    """With the load 1 and a force F forward: F = R(v); the position grows with v."""
    law = vc.viscous(vc.Coulomb)(0.2, 0.3, linear_viscosity=0.5)
    system = vc.System(vc.PendulumCapsule(), law, ZERO_PROGRESS, environment=vc.Environment(force=0.9))
    (found,) = vc.equilibria(system).sliding
    assert found.travel == pytest.approx((0.9 - 0.2) / 0.5, abs=1e-12)
    assert found.stable


@pytest.mark.plain
@pytest.mark.parametrize("law", [vc.LuGre(), pytest.param(vc.ElastoPlastic(), marks=pytest.mark.slow)])
def test_linearisation_is_that_of_the_motion(law):
    """A run from beside the equilibrium, all states of the law among them, moves as exp(J t) says."""
    system = belt(law, stiffness=2.0, damping=0.3, belt_speed=0.5)
    (found,) = vc.equilibria(system).sliding
    names = [name for name in system.state_names if name not in system.switched]
    nudge, end = 1e-6, 0.3
    start = {**found.state, "position": found.state["position"] + nudge}
    motion = vc.simulate(system, periods=end / system.drive.period, initial=start, tolerance=1e-13)
    moved = np.array([motion.state[name] - found.state[name] for name in names])
    problem = SteadyEquations(system)
    y = np.array([found.state[name] for name in names])[:, None]
    switched = np.array([[found.state[name]] for name in system.state_names])
    matrix = problem.jacobian(y, np.array([[-1.0]]), switched)[:, :, 0]
    assert sorted(np.linalg.eigvals(matrix), key=lambda z: (z.real, z.imag)) == pytest.approx(
        sorted(found.eigenvalues, key=lambda z: (z.real, z.imag)), rel=1e-9
    )
    values, vectors = np.linalg.eig(matrix)
    first = np.zeros(len(names))
    first[names.index("position")] = nudge
    expected = np.real(vectors @ (np.exp(values * end) * np.linalg.solve(vectors, first)))
    assert moved == pytest.approx(expected, abs=3e-5 * nudge)


# --- special points --------------------------------------------------------------------------------------------------


def hopf_of_belt(draw):
    low, drop, rate, load = draw.uniform(0.1, 1.0), draw.uniform(0.2, 1.0), draw.uniform(0.5, 5.0), draw.uniform(0.5, 2)
    damping = drop * rate * load * draw.uniform(0.05, 0.6)
    place = mpmath.log(mpmath.mpf(rate) * (mpmath.mpf(low + drop) - low) * load / damping) / rate
    law = vc.Exponential(low, low + drop, rate)
    machine = {"mass": draw.uniform(0.3, 3.0), "stiffness": draw.uniform(0.3, 3.0), "damping": damping}
    return belt(law, normal_load=load, **machine), "machine.belt_speed", place


def hopf_of_mode_coupling(draw):
    k11, k22, k12, k3 = (draw.uniform(*ends) for ends in ((1.5, 3.0), (1.0, 2.0), (0.2, 0.8), (0.8, 2.0)))
    mass, damping = draw.uniform(0.5, 2.0), draw.uniform(0.01, 0.2)
    a, b, c, d = (mpmath.mpf(each) for each in (k11, k22, k12, k3))
    place = ((a - b) ** 2 / 4 + c**2 + mpmath.mpf(damping) ** 2 * (a + b) / (2 * mpmath.mpf(mass))) / (c * d)
    machine = vc.ModeCouplingBlock(mass, k11, k12, k22, k3, damping)
    return vc.System(machine, vc.Coulomb(0.5, 20.0), ZERO_PROGRESS), "friction.coulomb_coefficient", place


def hopf_of_rock(draw):
    """The asinh of the law differs from a logarithm by exp(-2 (R/N)/a) here: not at all."""
    a, drop, length = draw.uniform(0.005, 0.01), draw.uniform(0.002, 0.01), 10.0 ** draw.uniform(-3.0, -1.0)
    law, speed = vc.RateAndStateAgeing(0.6, a, a + drop, length, 0.1), draw.uniform(0.05, 0.2)
    difference = mpmath.mpf(a + drop) - a
    place = difference / length * (1 + mpmath.mpf(speed) ** 2 / (mpmath.mpf(a) * length))
    return belt(law, belt_speed=speed), "machine.stiffness", place


def fold_of_a_capsule(draw):
    """A force holds the capsule at a speed where F = c + d exp(-a v) + b v, which has a least."""
    low, drop, rate = draw.uniform(0.1, 0.5), draw.uniform(0.2, 0.6), draw.uniform(1.0, 5.0)
    viscous = drop * rate * draw.uniform(0.05, 0.5)
    law = vc.viscous(vc.Exponential)(low, low + drop, rate, linear_viscosity=viscous)
    a, b, d = mpmath.mpf(rate), mpmath.mpf(viscous), mpmath.mpf(low + drop) - low
    place = low + b / a * (1 + mpmath.log(a * d / b))
    system = vc.System(vc.PendulumCapsule(), law, ZERO_PROGRESS, environment=vc.Environment(force=float(place) * 2.0))
    return system, "environment.force", place


KINDS = (hopf_of_belt, hopf_of_mode_coupling, hopf_of_rock, fold_of_a_capsule)


def special_at(made, seed):
    system, path, place = made(np.random.default_rng([seed, KINDS.index(made)]))
    near = float(place)
    if made is not fold_of_a_capsule:
        system = system.with_parameters({path: 1.2 * near})
    start = vc.equilibria(system).sliding[-1]
    branch = vc.equilibrium_branch(system, path, (0.7 * near, 2.5 * near), start=start)
    kind = vc.SpecialKind.FOLD if made is fold_of_a_capsule else vc.SpecialKind.HOPF
    (special,) = [point for point in branch.special_points if abs(point.parameter - near) < 1e-3 * near]
    return special, kind, place


@pytest.mark.parametrize("seed", slow_but([0], exhaustive_but(range(2), range(12))))
@pytest.mark.parametrize("made", KINDS, ids=lambda made: made.__name__)
def test_error_bars_of_special_points_hold_the_exact_place(made, seed):
    """Points whose places are known to 30 digits; the bars are of use, too."""
    with mpmath.workdps(30):
        special, kind, place = special_at(made, seed)
        off = abs(mpmath.mpf(special.parameter) - place)
    assert special.kind is kind
    assert off <= special.error < 1e-6 * float(place)


def test_frequencies_that_meet_without_damping():
    system = vc.System(vc.ModeCouplingBlock(), vc.Coulomb(0.3, 3.0), ZERO_PROGRESS)
    (special,) = vc.equilibrium_branch(system, "friction.coulomb_coefficient", (0.1, 1.0)).special_points
    assert special.kind is vc.SpecialKind.MODE_COUPLING
    assert abs(special.parameter - ((2.0 - 1.6) ** 2 / (4.0 * 0.5) + 0.5) / 1.2) <= special.error < 1e-12
    assert special.frequency == pytest.approx(math.sqrt(1.8), abs=1e-12)


def test_branch_ends_by_name_and_is_a_result():
    system = belt(vc.Exponential(0.5, 1.0, 2.0), damping=0.1, belt_speed=1.5)
    branch = vc.equilibrium_branch(system, "machine.belt_speed", (0.0, 2.0))
    assert branch.ends == (vc.BranchEnd.REST, vc.BranchEnd.PARAMETER_BOUND)
    assert branch.parameter[0] == pytest.approx(0.0, abs=1e-11)
    assert np.all(branch.stable == (branch.parameter > math.log(10.0) / 2.0))
    assert "subcritical" in str(branch)
    assert pickle.loads(pickle.dumps(branch)) == branch
    assert branch.equilibrium(0).state["position"] == pytest.approx(1.0, abs=1e-9)
    assert vc.equilibria(system) == vc.equilibria(system)


SLIDING = belt(vc.Coulomb(), belt_speed=1.0)


@pytest.mark.parametrize(
    ("asked", "field", "said"),
    [
        (lambda: vc.equilibria(3), "system", "should be a System"),
        (lambda: vc.equilibria(belt(vc.Coulomb(), vc.Harmonic())), "system", "should not be driven in time"),
        (lambda: vc.equilibrium_branch(belt(vc.Coulomb()), "machine.mass", (1.0, 2.0)), "system", "slide steadily"),
        (lambda: vc.equilibrium_branch(SLIDING, "machine.mass", (0.5, 2.0), points=1), "points", "whole number"),
        (
            lambda: vc.equilibrium_branch(
                SLIDING, "machine.belt_speed", (0.5, 2.0),
                start=vc.equilibria(SLIDING.with_parameters({"machine.stiffness": 3.0}))[0],
            ), "start", "another parameter differs",
        ),
    ],
)  # fmt: skip
def test_bad_input_is_refused_by_name(asked, field, said):
    with pytest.raises(ArgumentError, match=said) as caught:
        asked()
    assert caught.value.complaint.field == field


def test_the_command_in_si_and_its_picture(tmp_path, capsys):
    """k/m = 100: omega 10 rad/s; the Hopf point where R' = c, in m/s."""
    system = vc.System(
        vc.Oscillator.in_si(
            mass_kg=2.0, stiffness_N_per_m=200.0, damping_N_s_per_m=0.1, belt_speed_m_per_s=0.05, normal_load_N=10.0
        ),
        vc.Exponential.in_si(coulomb_coefficient=0.5, static_coefficient=1.0, decay_rate_s_per_m=20.0),
        vc.Constant.in_si(duration_s=1.0),
    )
    case, picture = tmp_path / "case.toml", tmp_path / "hopf.png"
    vc.save_case(system, case)
    over = ["--over", "machine.belt_speed_m_per_s=0.01:1"]
    said = printed(capsys, "equilibria", case, *over, "--plot", picture)
    assert f"{math.log(20.0 * 0.5 * 10.0 / 0.1) / 20.0:.12g} m/s" in said
    assert "omega 10 rad/s; subcritical; stability gained" in said
    assert picture.stat().st_size > 10_000
    for wrong, named in (
        (["--start", "0"], "--over"),
        ([*over, "--start", "4"], "--start"),
        (["--over", "x"], "--over"),
    ):
        assert named in refused(capsys, "equilibria", case, *wrong)


class NormalForm:
    """x' = -omega y + f, y' = omega x + g with all quadratic and cubic terms, as `first_lyapunov_coefficient` asks."""

    count = 2

    def __init__(self, omega, quadratic, cubic):
        self.linear = np.array([[0.0, -omega], [omega, 0.0]])
        self.quadratic, self.cubic = quadratic, cubic  # derivatives [2, 2, 2] and [2, 2, 2, 2], symmetric in the last

    def jacobian(self, x):
        return self.linear

    def curvature(self, x):
        values = np.zeros((2, 2, 3))
        values[:, :, :2] = self.quadratic + np.einsum("jklm,m->jkl", self.cubic, x[:2])
        return values


@pytest.mark.parametrize("seed", range(2))
def test_the_first_lyapunov_coefficient_has_the_size_of_the_textbook(seed):
    """16 a = f_xxx + f_xyy + g_xxy + g_yyy + (...)/omega (Guckenheimer and Holmes 1983, eq. 3.4.11); l_1 = 2 a/omega.

    For an eigenvector of length 1: r^2 is twice |z|^2.
    """
    draw = np.random.default_rng(seed)
    omega = draw.uniform(0.5, 3.0)
    second, third = draw.uniform(-1.0, 1.0, (2, 3)), draw.uniform(-1.0, 1.0, (2, 4))
    quadratic = np.array([[[row[k + m] for m in (0, 1)] for k in (0, 1)] for row in second])
    cubic = np.array([[[[row[k + m + n] for n in (0, 1)] for m in (0, 1)] for k in (0, 1)] for row in third])
    (fxx, fxy, fyy), (gxx, gxy, gyy) = second
    products = fxy * (fxx + fyy) - gxy * (gxx + gyy) - fxx * gxx + fyy * gyy
    a = (third[0, 0] + third[0, 2] + third[1, 1] + third[1, 3] + products / omega) / 16.0
    form, vector = NormalForm(omega, quadratic, cubic), np.array([3.0, -3.0j])
    coefficient = bifurcations.first_lyapunov_coefficient(form, np.zeros(3), omega, vector)
    assert coefficient == pytest.approx(2.0 * a / omega, rel=1e-9)
