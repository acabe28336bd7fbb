"""Design: known optima from several seeds, unstable orbits that must not win, fronts, stores, bad input."""

import json
import re
import tracemalloc
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.stats import norm, sobol_indices

import vibrocap as vc
from cases import printed, printed_json, refused
from vibrocap.case.case import CaseError
from vibrocap.cli.main import main
from vibrocap.cli.terminal import INCOMPLETE
from vibrocap.design.optimise import judged, optimise
from vibrocap.design.robustness import _sobol_indices
from vibrocap.design.search.ascent import ascend
from vibrocap.design.search.population import evaluated
from vibrocap.design.search.problem import stated_problem
from vibrocap.design.search.refinement import STEP as REGION_STEP
from vibrocap.design.search.refinement import ClosedDesigns
from vibrocap.design.search.uncertainty import CRITERIA, Samples, sample_points
from vibrocap.design.search.variables import DesignSpace
from vibrocap.measures.measure import Derived
from vibrocap.motion.trust import residue
from vibrocap.studies.plan.designs import Range
from vibrocap.studies.plan.runs import Column
from vibrocap.studies.plan.study import part_fingerprint
from vibrocap.studies.plan.variation import residues, varied

START = [{"angle": np.pi / 3}]
SEARCH = {"periods": 300, "settle": 1e-6, "tolerance": 1e-8, "margin": 1e-3, "threads": None}
FREQUENCY_AND_PHASE = {"drive.frequency": (0.5, 3.0), "drive.second_phase": (0.0, 2.0 * np.pi)}
OWN = {"half": (0.25, 1.5), "phase": (0.0, np.sqrt(2.0 * np.pi))}
BOTH = "friction.coulomb_coefficient,friction.static_coefficient"


def doubled(half, phase):
    """Parameters of two variables of one's own, one of them not linear."""
    return {"drive.frequency": 2.0 * half, "drive.second_phase": phase**2}


@pytest.fixture(scope="module")
def biharmonic() -> vc.System:
    return vc.System(
        machine=vc.PendulumCapsule(mass_ratio=2.5, stiffness=2.0, damping=1.0, normal_load="dynamic"),
        friction=vc.Exponential(coulomb_coefficient=0.05, static_coefficient=0.1),
        drive=vc.Biharmonic(amplitude=1.2, second_amplitude=0.4),
    )


@pytest.mark.slow
def test_resumed_search_has_the_same_bits_on_any_threads(biharmonic, tmp_path):
    """With variables of one's own, and uncertain parameters, which are named by the parameters."""
    asked = {"over": OWN, "through": doubled, "starts": START, "refinement": 0, "robust": "cvar", "samples": 4}
    asked["uncertain"] = {BOTH: "factor:0.8:1.2", "drive.frequency": "factor:0.99:1.01"}
    whole = optimise(biharmonic, evaluations=64, threads=1, **asked)
    optimise(biharmonic, evaluations=32, store=tmp_path, threads=2, **asked)
    resumed = optimise(biharmonic, evaluations=64, store=tmp_path, resume=True, threads=2, **asked)
    assert resumed == whole
    assert np.array_equal(resumed.population.costs, whole.population.costs)
    asked |= {"evaluations": 32, "store": tmp_path, "resume": True}
    for change, said in (
        ({"seed": 1}, "another search"),
        ({"samples": 8}, "another uncertain"),
        ({"through": lambda half, phase: doubled(half, phase / 2.0)}, "another search"),
        ({"uncertain": {"drive.frequency": "0.9:1.1"}}, "is a design variable"),
    ):
        with pytest.raises(ValueError, match=said):
            optimise(biharmonic, **asked | change)


def test_record_of_a_search_holds_all_that_decides_it():
    """Functions, distributions, measures and parts of one's own too, in which two searches may look alike."""
    (law,) = vc.load_parts(Path(__file__).parents[1] / "examples/own_parts/friction/hyperbolic.py")

    def record(over=FREQUENCY_AND_PHASE, measure="mean_velocity", deviation=0.1, through=None, law=law):
        system = vc.System(vc.TwoMassCapsule(), law(), vc.Biharmonic(1.5, 0.8, 0.5))
        asked = {"periods": 300, "settle": 1e-6, "tolerance": 1e-8, "margin": 0.0, "threads": 1, "through": through}
        asked["uncertain"] = {"machine.damping": norm(0.3, deviation)}
        return stated_problem(system, over, [measure], [None], (), [{}], **asked).record(0)

    def differing(one, other):
        return [name for name in {**one, **other} if one.get(name) != other.get(name)]

    measures = [vc.Measure("turned", "its size", Derived(function, ("drift",))) for function in (abs, lambda x: -x)]
    names = ("drive.frequency", "machine.stiffness")
    functions = [lambda a, b: dict(zip(names, (a, b), strict=True)), lambda a, b: dict(zip(names, (b, a), strict=True))]
    own = [record({"a": (1.0, 2.0), "b": (1.0, 2.0)}, through=function) for function in functions]
    assert differing(record(), record()) == []
    assert differing(record(), record(deviation=0.2)) == ["uncertain"]
    assert set(differing(*own)) == {"through", "over"}
    assert differing(*(record(measure=measure) for measure in measures)) == ["measures"]
    assert record()["parts"] == {f"friction.law = {law.name}": part_fingerprint(law)}
    assert "parts" not in record(law=vc.Coulomb)


@pytest.mark.slow
def test_variables_of_ones_own_are_other_words_for_the_same_designs(biharmonic):
    """Slopes by the chain rule: dV/d(half) = 2 dV/d(frequency), dV/d(phase) = 2 phase dV/d(second_phase).

    Both searches begin with their guesses.
    """
    guess = {"drive.frequency": 0.92, "drive.second_phase": 2.25}
    asked = {"starts": START, "evaluations": 32, "refinement": 0, "spread_starts": 0}
    plain = optimise(biharmonic, FREQUENCY_AND_PHASE, guesses=[guess], **asked)
    for (path, (low, high)), share in zip(FREQUENCY_AND_PHASE.items(), plain.population.shares[0], strict=True):
        assert low + (high - low) * share == pytest.approx(guess[path], rel=1e-12)
    own = {"half": 0.46, "phase": 1.5}
    design = optimise(biharmonic, OWN, through=doubled, guesses=[own], **asked)
    assert design.design == pytest.approx(own, rel=1e-12)
    assert design.value == pytest.approx(plain.value, rel=1e-9)
    for name, path, rate in (("half", "drive.frequency", 2.0), ("phase", "drive.second_phase", 3.0)):
        assert design.slopes[name] == pytest.approx([rate * slope for slope in plain.slopes[path]], rel=1e-9)
        assert abs(plain.slopes[path][0]) > 1e-3


def test_shape_has_its_peak_exactly():
    """A third harmonic of -1/6 makes the largest part at omega of all shapes of one peak: 2/sqrt(3)."""
    flat = vc.drive_shape(1.0, (1.0, 0.0, -1.0 / 6.0))
    assert flat["drive.cosine_1"] == pytest.approx([2.0 / np.sqrt(3.0)], rel=1e-14)
    assert flat["drive.cosine_3"] == pytest.approx([-1.0 / np.sqrt(27.0)], rel=1e-14)
    generator = np.random.default_rng(0)
    times = np.linspace(0.0, 2.0 * np.pi, 2_001)
    for count in (1, 2, 3, 5, 7):
        cosines, sines = generator.normal(size=(2, count, 5))
        shape = vc.drive_shape(np.linspace(0.5, 2.0, 5), cosines, sines)
        for k, peak in enumerate(np.linspace(0.5, 2.0, 5)):
            drive = vc.FourierSeries(**{path.removeprefix("drive."): float(x[k]) for path, x in shape.items()})
            size = np.max(np.abs([drive.value(t) for t in times[:: 20 if k else 1]]))
            assert size <= peak * (1.0 + 1e-12)
            assert k or size == pytest.approx(peak, rel=(7 * np.pi / 2_000) ** 2)
    assert vc.drive_shape(1.0, (0.0, 0.0))["drive.cosine_1"] == 0.0
    with pytest.raises(ValueError, match="one to 7 harmonics, got 8"):
        vc.drive_shape(1.0, (1.0,) * 8)


@pytest.mark.slow
def test_designs_without_a_twin_of_a_system_that_has_one_keep_their_direction(biharmonic):
    """The drive of the system is odd, those of the designs are not; turned about, a drive travels the other way."""
    system = biharmonic.with_parameters({"drive.second_amplitude": 0.0})
    assert system.mirrored
    asked = {"starts": START, "evaluations": 32, "refinement": 0, "spread_starts": 0}
    for phase in (2.2, 2.2 + np.pi):
        turned = system.with_parameters({"drive.second_phase": phase})
        best = optimise(turned, {"drive.second_amplitude": (0.3, 0.4)}, **asked)
        assert np.sign(best.value) == (1.0 if phase < np.pi else -1.0)
        assert abs(best.value) > 0.02
        assert best.orbit.mean_velocity == best.value
        settled = vc.simulate(best.orbit.system, initial=best.orbit.state, periods=3)
        assert vc.mean_velocity(settled, periods=1).value == pytest.approx(best.value, abs=1e-9)


@pytest.mark.slow
def test_no_design_starts_beyond_its_rigid_stop():
    """From where another design has settled, or from a start of one's own, that lies beyond a nearer stop."""
    drive = vc.Biharmonic(1.2, 1.0, second_amplitude=0.5)
    system = vc.System(vc.RigidStopCapsule(restitution=0.5), vc.Coulomb(0.2, 0.3), drive)
    for starts in (None, [{"displacement": 0.19}]):
        problem = stated_problem(system, {"machine.gap": (0.1, 1.0)}, ["mean_velocity"], [None], (), starts, **SEARCH)
        far = evaluated(problem, np.array([[1.0]]))
        assert evaluated(problem, np.array([[0.0], [0.05]]), [far]).counts()["refused"] == 0


@pytest.mark.parametrize("friction", [vc.Exponential(), vc.Exponential(0.05, 0.05)])  # it sticks; slides to and fro
def test_a_machine_that_cannot_travel_has_no_best_design_no_front_and_no_cost(friction):
    pytest.importorskip("pymoo")
    system = vc.System(vc.PendulumCapsule(mass_ratio=4.0, stiffness=4.0), friction, vc.Harmonic(0.6, 1.0))
    over = {"drive.frequency": (0.9, 1.2), "machine.damping": (0.8, 1.2)}
    for objective in ("mean_velocity", "cost_of_transport"):
        design = vc.optimise(system, over, objective, evaluations=60, spread_starts=0)
        assert design.status is vc.OptimumStatus.NO_TRAVEL
        assert (design.design, design.value, design.slopes, design.nearest) == (None, None, {}, None)
        assert "no design travels" in str(design)
    for objectives in (("mean_velocity", "cost_of_transport"), ("drive_work", "mean_velocity")):
        front = vc.pareto_front(system, over, objectives, evaluations=100)
        assert (front.status, len(front)) == (vc.OptimumStatus.NO_TRAVEL, 0)
    spread = vc.robustness(system, over, "cost_of_transport", samples=8)
    assert (spread.nominal, spread.worst, spread.quantiles[0.05], spread.total) == (np.inf, np.inf, np.inf, None)


@pytest.mark.slow
def test_constraint_that_no_design_fulfils(biharmonic):
    best = optimise(biharmonic, FREQUENCY_AND_PHASE, subject_to="least_reaction > 100", starts=START, evaluations=32)
    assert (best.status.value, best.value) == ("no allowed design", None)
    assert best.counts["infeasible"] > 0
    design, lacking = best.nearest
    assert set(design) == set(FREQUENCY_AND_PHASE)
    assert lacking.endswith(", not least_reaction > 100")
    nearest = float(lacking.split()[1].rstrip(","))
    assert nearest == pytest.approx(np.nanmax(best.population.found["least_reaction"]), rel=1e-5)


@pytest.mark.parametrize(
    ("asked", "said"),
    [
        ({"objective": "speed"}, "mean_velocity"),
        ({"objective": "distance"}, "displacement"),
        ({"over": {"drive.frequency": (3.0, 0.5)}}, "reversed"),
        ({"over": {"drive.frequency": (-1.0, 0.5)}}, "drive.frequency"),
        ({"over": {"drive.frequenzy": (0.5, 3.0)}}, "drive.frequency"),
        ({"over": {}}, "over"),
        ({"subject_to": "least_reaction"}, "MEASURE > NUMBER"),
        ({"subject_to": "least_reaction > abc"}, "MEASURE > NUMBER"),
        ({"sense": "largest"}, "maximise, minimise"),
        ({"evaluations": 0}, "evaluations"),
        ({"guesses": [{"drive.frequency": 4.0, "drive.second_phase": 1.0}]}, r"guesses\[0\]: drive.frequency .* 4"),
        ({"guesses": [{"drive.frequency": 1.0}]}, r"guesses\[0\]: should give drive.second_phase"),
        # functions of one's own
        ({"over": {"half": (0.25, 1.5)}, "through": doubled}, "through: should take arrays of half and return arrays"),
        ({"over": OWN, "through": lambda half, phase: {"drive.frequenzy": half}}, "drive.frequency"),
        ({"over": OWN, "through": lambda half, phase: half}, "through"),
        ({"through": doubled}, "drive.frequency: should be a name"),
        ({"over": OWN | {"half": (1.5, 0.25)}, "through": doubled}, "reversed"),
        ({"over": OWN | {"half": ["slow", "fast"]}, "through": doubled}, "half: should be numbers"),
        # what is uncertain
        (
            {"uncertain": {"machine.damping": (0.9, 1.1)}, "robust": "best"},
            "robust: should be one of worst, mean, cvar",
        ),
        ({"uncertain": {"machine.damping": (0.9, 1.1)}, "samples": 1}, "samples"),
        ({"uncertain": {"drive.frequency": (0.9, 1.1)}}, "drive.frequency=factor:"),
    ],
)
def test_bad_input_is_named_before_any_work(biharmonic, asked, said):
    with pytest.raises(CaseError, match=said):
        optimise(biharmonic, **({"over": FREQUENCY_AND_PHASE} | asked))


def test_an_unstable_orbit_is_refused_by_its_multiplier():
    """The symmetric one between two that travel closes, and is no candidate."""
    system = vc.System(vc.PendulumCapsule(), vc.Exponential(), vc.Harmonic())
    orbit = vc.orbit(system, initial=START[0], half=True)
    assert orbit.closes
    problem = stated_problem(system, {"machine.damping": (0.5, 1.5)}, ["drive_work"], [None], (), START, **SEARCH)
    assert judged(problem, np.array([0.5]), orbit) == (None, f"largest multiplier {abs(orbit.multipliers[0]):.6g}")


@pytest.mark.slow
def test_a_command_without_an_allowed_design_says_what_came_nearest(tmp_path, capsys):
    case, out = tmp_path / "case.toml", tmp_path / "out"
    small = vc.System(vc.PendulumCapsule(mass_ratio=2.5, stiffness=2.0), vc.Exponential(), vc.Harmonic(0.02))
    vc.save_case(small, case, initial={"angle": 0.3})
    command = ["optimise", case, "--over", "drive.frequency=1.3:1.32", "--evaluations", "32", "--out", out]
    assert "there is no measure 'speed'" in refused(capsys, *command, "--subject-to", "speed > 1")
    assert not out.exists()
    said = printed(capsys, *command, "--over", "machine.damping=0.00001:0.00002", code=INCOMPLETE)
    assert "had not settled after 300 drive periods" in " ".join(said.split())
    record = json.loads((out / "design.json").read_text(encoding="utf-8"))
    assert (record["design"], record["counts"]["evaluated"]) == (None, 32)
    assert record["nearest"][1] in " ".join(said.split())
    assert len(list((out / "populations").iterdir())) == 1


FRONT = {"drive.frequency": (0.5, 3.0), "drive.second_phase": (0.0, 2.0 * np.pi), "machine.damping": (0.3, 3.0)}


@pytest.mark.slow
def test_front_has_no_point_that_another_betters(biharmonic):
    pytest.importorskip("pymoo")
    front = vc.pareto_front(biharmonic, FRONT, starts=START, evaluations=1500, points=20)
    assert 3 <= len(front) <= 20
    velocity, cost = front.values.T
    assert np.all(np.diff(velocity) < 0.0)
    assert np.all(np.diff(cost) < 0.0)
    assert np.all(front.multipliers <= 0.999)
    assert len(front.orbits) == len(front.designs) == len(front.to_pandas())
    # No motion that was evaluated betters a closed one by more than the threshold to which runs settle.
    for speed, energy in front.others():
        assert not np.any((speed > velocity * (1 + 1e-3)) & (energy < cost * (1 - 1e-3)))
    for design, orbit, values in zip(front.designs, front.orbits, front.values, strict=True):
        run = biharmonic.with_parameters(design)
        own = vc.orbit(run, initial=orbit.state)
        assert own.mean_velocity == pytest.approx(values[0], abs=1e-10)  # with its sign: there are no twins


@pytest.mark.slow
def test_resumed_front_has_the_same_bits(biharmonic, tmp_path):
    pytest.importorskip("pymoo")
    asked = {"over": FRONT, "starts": START, "points": 5, "seed": 3}
    whole = vc.pareto_front(biharmonic, evaluations=1200, threads=1, **asked)
    vc.pareto_front(biharmonic, evaluations=1200, threads=2, store=tmp_path, **asked)
    cut, poor, *rest = sorted((tmp_path / "populations").iterdir())[4:]
    cut.write_bytes(cut.read_bytes()[:-30])
    with np.load(poor) as stored:
        arrays = {name: array for name, array in stored.items() if name != "mean_velocity"}
    np.savez(poor, **arrays)
    for stored in rest:
        stored.unlink()
    resumed = vc.pareto_front(biharmonic, evaluations=1200, threads=2, store=tmp_path, resume=True, **asked)
    assert resumed == whole


@pytest.mark.parametrize(
    ("asked", "said"),
    [
        ({"objectives": ("mean_velocity", "speed")}, r"objectives\[1\]: .*mean_velocity"),
        ({"objectives": ("drift", "drift")}, "different measures"),
        ({"objectives": "drift"}, "two measures"),
        ({"senses": ("maximise", "most")}, r"senses\[1\]"),
        ({"points": 0}, "points"),
    ],
)
def test_bad_fronts_are_named_before_any_work(biharmonic, asked, said):
    with pytest.raises(ValueError, match=said):
        vc.pareto_front(biharmonic, FRONT, **asked)


def test_command_writes_the_front(tmp_path, capsys):
    pytest.importorskip("pymoo")
    case, out, picture = tmp_path / "case.toml", tmp_path / "front", tmp_path / "front.png"
    assert main(["new", "--out", str(case)]) == 0
    asked = ["optimise", case, "--over", "drive.frequency=0.5:3", "--over", "machine.damping=0.3:3"]
    printed(capsys, *asked, "--against", "cost_of_transport", "--evaluations", "600", "--out", out, "--plot", picture)
    points = json.loads((out / "front.json").read_text(encoding="utf-8"))["points"]
    heading, *rows = (out / "front.csv").read_text(encoding="utf-8").splitlines()
    assert heading.split(",") == [*points[0]["design"], *points[0]["measures"], "largest_multiplier"]
    assert len(rows) == len(points)
    motion = vc.read_case(out / "cases" / "000.toml").simulate()
    velocity = abs(vc.mean_velocity(motion, periods=1).value)
    assert velocity == pytest.approx(points[0]["measures"]["mean_velocity"], abs=1e-8)
    assert picture.stat().st_size > 10_000
    assert "--plot" in refused(capsys, *asked[:4], "--plot", picture)


SHARE, DECELERATION = 0.3, 0.2  # of the inner mass; by friction, of the whole


def crawler_under(drive):
    total = 1.0 / SHARE
    law = vc.Coulomb(DECELERATION * total, DECELERATION * total)
    return vc.System(vc.TwoMassCrawler(mass_ratio=total - 1.0), law, drive)


@pytest.mark.plain
def test_three_phases_reach_the_least_cost_and_come_near_the_largest_speed():
    """V/sqrt(mu k L/2) = ((s - 1)/s) sqrt(s/(s + 1)) for three phases with w1 = w3 = w* and w2 = s w*.

    Where the body slides back by D_back, energy per distance and total mass is k (1 + 2 D_back/D).
    """
    slow, factor = DECELERATION / SHARE, 1000.0
    steady = vc.orbit(crawler_under(vc.ThreePhase(1.0, slow, factor * slow, slow)))
    cost, speed = vc.performance_bounds(steady.system)
    assert cost.value == pytest.approx(DECELERATION / SHARE, abs=1e-15)
    assert cost.of(steady) == pytest.approx(cost.value, abs=1e-10)
    assert speed.holds(steady)
    share = (factor - 1.0) / factor * np.sqrt(factor / (factor + 1.0))
    assert speed.of(steady) / speed.value == pytest.approx(share, abs=1e-12)
    steady = vc.orbit(crawler_under(vc.ThreePhase(1.0, 1.3 * slow, 6.0 * slow, 1.3 * slow)))
    motion = steady.motion()
    back = sum(np.ptp(motion.at([phase.start, phase.end], "position")) for phase in motion.phases if phase.side < 0)
    assert back > 0.01
    assert cost.of(steady) == pytest.approx(cost.value * (1.0 + 2.0 * back / steady.drift), rel=1e-10)


@pytest.mark.plain
def test_centre_of_mass_that_never_stops_is_beyond_the_speed_of_strokes_from_rest():
    """Two phases, 0.1 forward in the capsule and 0.001 back: the closed form of Chernousko is 17 times the bound."""
    first, second = 0.1, 0.001
    steady = vc.orbit(crawler_under(vc.Triangle(0.5, 2.0 * np.pi / (first + second), rise=first / (first + second))))
    jump = SHARE * (1.0 / first + 1.0 / second)
    value = jump * second - DECELERATION * second**2
    _, speed = vc.performance_bounds(steady.system)
    assert speed.of(steady) == pytest.approx(value / (first + second), rel=1e-9)
    assert speed.of(steady) > 17.0 * speed.value
    assert not speed.holds(steady)


def test_least_friction_between_two_speeds():
    """A law with a valley, v + 5 + 10 exp(-2 v): the least force is at v = ln(20)/2."""
    law = vc.viscous(vc.Exponential)(5.0, 15.0, 2.0, linear_viscosity=1.0)
    system = vc.System(vc.TwoMassCapsule(normal_load=1.0), law, vc.Harmonic())
    (cost,) = vc.performance_bounds(system)
    assert cost.value == pytest.approx(5.5 + 0.5 * np.log(20.0), rel=1e-12)


@pytest.mark.parametrize(
    ("system", "said"),
    [
        (vc.System(vc.PendulumCapsule(), vc.LuGre(), vc.Harmonic()), "memory"),
        (vc.System(vc.PendulumCapsule(normal_load="dynamic"), vc.Coulomb(), vc.Harmonic()), "light"),
    ],
)
def test_systems_without_a_known_bound_say_why(system, said):
    with pytest.raises(ValueError, match=said):
        vc.performance_bounds(system)


# --- what is uncertain ------------------------------------------------------------------------------------------------

DRIVEN_BY_TWO = vc.System(vc.TwoMassCapsule(), vc.Coulomb(0.2, 0.3), vc.Biharmonic(1.5, 0.8, 0.5))
SYMMETRIC = DRIVEN_BY_TWO.with_parameters({"drive.second_amplitude": 0.0})


def test_sobol_indices_are_those_of_scipy_and_their_intervals_those_of_the_seed():
    values = np.random.default_rng(1).normal(3.0, 1.0, 4 * 64)
    first, second, *mixed = values.reshape(4, 64)
    known = {"f_A": first[None], "f_B": second[None], "f_AB": np.stack(mixed)[:, None]}
    expected = sobol_indices(func=known, n=64)
    quantities = [SimpleNamespace(name="a"), SimpleNamespace(name="b")]
    found, again, other = (_sobol_indices(values, 64, quantities, seed) for seed in (0, 0, 1))
    for table, one in zip(found, (expected.first_order, expected.total_order), strict=True):
        assert [table[name][0] for name in ("a", "b")] == pytest.approx(one, rel=1e-12)
        assert all(low < index < high for index, low, high in table.values())
    assert again == found != other


def test_quantities_of_ones_own_are_drawn_as_they_are_spread():
    """And go into the runs through the function of them."""
    spread = {"decay": "lognormal:0.8:0.1", "push": "normal:1.5:0.1"}

    def parameters(decay, push):
        return {"machine.damping": decay**2, "drive.amplitude": push}

    robustness = vc.robustness(DRIVEN_BY_TWO, spread, through=parameters, samples=64)
    decays, pushes = (robustness.parameters[name] for name in spread)
    assert (np.mean(np.log(decays)), np.std(np.log(decays))) == pytest.approx((np.log(0.8), 0.1), rel=0.03)
    assert (np.mean(pushes), np.std(pushes)) == pytest.approx((1.5, 0.1), rel=0.03)
    runs = vc.ensemble(DRIVEN_BY_TWO, parameters(decays, pushes), measures=["mean_velocity"], periods=500, settle=1e-6)
    assert robustness.values == pytest.approx(runs["mean_velocity"], abs=1e-5)


@pytest.fixture(scope="module")
def optimum() -> vc.Case:
    """The third known optimum: constant load, harmonic drive, from pi/3."""
    machine = vc.PendulumCapsule(mass_ratio=2.5, stiffness=0.88624890, damping=1.40524509)
    return vc.Case(vc.System(machine, vc.Exponential(), vc.Harmonic(1.8, 1.23974842)), START[0])


def test_factor_of_friction_is_a_run_at_that_friction(optimum):
    """At friction x 0.8 and x 1.2 the speeds are those of BEYOND's table."""
    spread = vc.robustness(optimum, {BOTH: "factor:0.8:1.2"}, samples=64)
    assert spread.nominal == pytest.approx(0.082456224884, abs=1e-6)
    factors = spread.parameters["friction.coulomb_coefficient"] / optimum.system.friction.coulomb_coefficient
    assert np.min(factors) >= 0.8
    assert np.max(factors) <= 1.2
    ends = [spread.values[np.argmin(factors)], spread.values[np.argmax(factors)]]
    assert ends == pytest.approx([0.0714693, 0.0870099], abs=2e-3)  # 64 samples come within 0.01 of the ends
    assert spread.wrong_way == 0.0
    assert spread.total == {BOTH: (1.0, 1.0, 1.0)}


@pytest.mark.slow
def test_runs_that_lift_off_count_as_no_travel(biharmonic):
    """A design on the edge of lifting off: at larger friction it does, in some samples; numbers hold them as 0."""
    lifting = biharmonic.with_parameters({"drive.amplitude": 2.6, "drive.second_amplitude": 1.2})
    spread = vc.robustness(lifting, {"drive.amplitude": (1.0, 2.6)}, initial=START[0], samples=64)
    share = spread.failed["lift off"]
    assert 0.0 < share < 1.0
    assert np.mean(spread.values == 0.0) >= share
    assert spread.worst <= 0.0
    assert spread.mean == pytest.approx(np.mean(spread.values), abs=0.0)
    cost = vc.robustness(lifting, {"drive.amplitude": (1.0, 2.6)}, "least_reaction", initial=START[0], samples=64)
    assert np.mean(np.isnan(cost.values)) == share  # of what is no travel nothing is made up
    assert cost.total is None


def test_travel_is_judged_by_the_period_and_size_of_each_run(monkeypatch):
    """The residue of settled runs under varied kinds, frequencies and sizes; a search and samples judge by theirs."""
    crawler = vc.System(vc.TwoBodyCrawler(), vc.Coulomb(0.2, 0.3), vc.Harmonic(1.0, 1.0))
    pairs = [("harmonic", 0.5, 1.0), ("square", 1.0, 2.0), ("harmonic", 4.0, 2.0), ("square", 0.1, 1.0)]
    values = dict(zip(("drive.waveform", "drive.frequency", "machine.mass"), zip(*pairs, strict=True), strict=True))
    own = [residue(varied(crawler, dict(zip(values, pair, strict=True))), "mean_velocity", 1e-6) for pair in pairs]
    columns = {path: np.array(column, dtype=object if "form" in path else float) for path, column in values.items()}
    assert residues(crawler, columns, len(pairs), "mean_velocity", 1e-6).tolist() == own
    assert len(set(own)) == len(own)
    constants = (vc.Constant(2.0, duration) for duration in (1e-4, 1e4))  # which is a mere step
    turning = [vc.System(vc.RotorCapsule(), vc.Coulomb(0.1, 0.2), constant) for constant in constants]
    assert [residue(system, "mean_velocity", 1e-6) for system in turning] == pytest.approx([1e-5, 1e-5])

    def crawling(system, over, **settings):  # back, by what is residue above a frequency of 2 pi; the nominal run ahead
        speed = np.full(len(over["drive.frequency"]), -1e-5)
        speed[-1] = 1.0
        return {"status": speed.astype(int) * 0, "settled": speed < 2.0, "mean_velocity": speed}

    monkeypatch.setattr("vibrocap.design.robustness.ensemble", crawling)
    spread = vc.robustness(DRIVEN_BY_TWO, {"drive.frequency": (1.0, 9.0)}, samples=64)
    assert spread.wrong_way == np.mean(spread.parameters["drive.frequency"] < 2.0 * np.pi)
    asked = {"periods": 300, "settle": 1e-6, "tolerance": 1e-8, "margin": 0.0, "threads": 1}
    ranges = {"drive.frequency": (1.0, 9.0)}
    problem = stated_problem(DRIVEN_BY_TWO, ranges, ["mean_velocity"], [None], (), [{}], **asked)
    shares = np.array([[0.1], [0.9]])
    assert problem.travels({"mean_velocity": np.full((2, 1), -1e-5)}, shares).tolist() == [[True], [False]]


def test_wrong_way_and_the_worst_tenth():
    """The phase of the second harmonic decides the direction: over all phases half go each way, by symmetry."""
    spread = vc.robustness(DRIVEN_BY_TWO, {"drive.second_phase": (0.0, 2.0 * np.pi)}, samples=256)
    assert spread.wrong_way == pytest.approx(0.5, abs=0.05)
    ordered = np.sort(spread.values)
    assert spread.tail_mean == pytest.approx(np.mean(ordered[: int(np.ceil(0.1 * len(ordered)))]))
    assert spread.quantiles[0.5] == pytest.approx(np.median(spread.values))
    assert len(spread.to_pandas()) == len(spread.values) == 512


HALF = {"half": (0.5, 0.6)}


@pytest.mark.parametrize(
    ("uncertain", "through", "said"),
    [
        ({}, None, "uncertain: should name"),
        ({"machine.dampin": (0.9, 1.1)}, None, "machine.damping"),
        ({"machine.damping": (1.1, 0.9)}, None, "machine.damping: should have its lower end first"),
        ({"machine.damping": "normal:1:0"}, None, "positive deviation"),
        ({"machine.damping": "lognormal:-1:0.1"}, None, "positive median"),
        ({"machine.damping": "about 1"}, None, "LOW:HIGH, normal"),
        ({"machine.damping,machine.stiffness": "0.9:1.1"}, None, "factor:0.9:1.1"),
        ({"friction.law": "0.9:1.1"}, None, "no uncertain quantity"),
        ({"machine.normal_load": (0.9, 1.1)}, None, "should be a number to be uncertain"),
        ({"machine.damping": "normal:0.5:0.5"}, None, "uncertain: machine.damping: should be at least 0, got -"),
        ({"friction.coulomb_coefficient": "0.1:0.6"}, None, "static_coefficient: should be at least coulomb"),
        (HALF, lambda half: half, "through: should take arrays of half and return arrays by path"),
        (HALF, lambda whole: {"machine.damping": whole}, "through: should take arrays of half"),
        (HALF, lambda half: {"machine.dampin": half}, "machine.damping"),
        (HALF, lambda half: {"machine.damping": half, "machine.stiffness": -1.0}, "uncertain: machine.stiffness: sho"),
    ],
)
def test_bad_uncertainties_are_named_before_any_work(biharmonic, uncertain, through, said):
    with pytest.raises(CaseError, match=said):
        vc.robustness(biharmonic, uncertain, through=through)
    with pytest.raises(CaseError, match="samples"):
        vc.robustness(biharmonic, {"machine.damping": "0.9:1.1"}, samples=20)


def test_sobol_indices_of_a_sum_in_memory_that_grows_as_its_samples():
    """f = x + 2 y + 0 z of uniform numbers: shares 1/5, 4/5 and 0, the last without doubt."""
    samples, names = 4096, ("x", "y", "z")
    first, second = np.split(sample_points(6, samples, 0), 2, axis=1)
    points = [first, second, *(np.where(np.arange(3) == i, second, first) for i in range(3))]
    values = np.concatenate(points) @ [1.0, 2.0, 0.0]
    tracemalloc.start()
    alone, total = _sobol_indices(values, samples, [SimpleNamespace(name=name) for name in names], 0)
    memory = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    for name, share in zip(names, (0.2, 0.8, 0.0), strict=True):
        for index in (alone[name], total[name]):
            assert index.share == pytest.approx(share, abs=2e-3)
            assert index.low <= share <= index.high
            assert index.high - index.low < 0.1
    assert memory < 100 * values.nbytes


def test_samples_that_a_part_refuses_or_that_newton_leads_astray_decide_as_their_runs_do():
    """Coulomb friction up to 0.4 with a static one from 0.35: impossible pairs are refused, the others run.

    Newton's method leads from the orbit of the design to an unstable one at the least static friction, where a run
    settles to the stable one.
    """
    system = vc.System(vc.PendulumCapsule(2.5, 2.0, 1.0), vc.Exponential(), vc.Harmonic(1.8, 1.0))
    asked = {"starts": START[:1], "samples": 4, "evaluations": 32, "refinement": 0, "spread_starts": 0}
    asked |= {"uncertain": {"friction.static_coefficient": (0.35, 0.5)}}
    best = optimise(system, {"friction.coulomb_coefficient": (0.1, 0.4)}, **asked)
    assert best.counts["refused"] == 6
    assert best.under == ("worst", 1.0)
    assert best.value == pytest.approx(-np.min(best.population.best_cost), rel=1e-6)


def numbers_of(page):
    """All numbers of a page, in full precision where it has it."""
    shown = re.findall(r'<(?:data|span) class="n"(?: value="([^"]*)")?[^>]*>([^<]*)<', page)
    return np.array([float(full or text.replace("\u2212", "-")) for full, text in shown])


@pytest.mark.slow
def test_the_page_of_a_design_holds_what_is_known_of_it(tmp_path):
    """In SI, with pictures and a film beside it: its numbers are those of the search without units, in their units."""
    case, out = "examples/bench-in-si.toml", tmp_path / "design"
    asked = ["optimise", case, "--over", "drive.frequency_Hz=0.6:2", "--evaluations", "64"]
    assert main([*asked, "--subject-to", "peak_drive < 1.2", "--out", str(out), "--report"]) == 0
    page, content = (out / "report.html").read_text("utf-8"), json.loads((out / "design.json").read_text("utf-8"))
    for said in ("drive.frequency_Hz", "peak_drive &lt; 1.2", *content["limits"], "best.toml", " ".join(asked[:4])):
        assert said in page
    assert page.count("data:image/png;base64,") == 2
    assert (out / "film.gif").stat().st_size > 10_000
    best = vc.mean_velocity(vc.read_case(out / "best.toml").simulate(), periods=1)
    assert best.value == pytest.approx(content["value"]["value"], rel=1e-6)
    system = vc.read_case(case).system
    hertz, torque = 1.0 / (2.0 * np.pi * system.si.scales.time_s), system.si.factor_of("N m")
    over = {"drive.frequency": (0.6 / hertz, 2.0 / hertz)}
    limit = f"peak_drive < {1.2 / torque!r}"
    starts = [{"angle": np.pi / 6}]
    plain = vc.optimise(system.dimensionless, over, subject_to=limit, starts=starts, evaluations=64)
    frequency, speed = plain.design["drive.frequency"], system.si.factor_of("m/s")
    slope = np.mean([side for side in plain.slopes["drive.frequency"] if side is not None])
    assert f"{plain.value * speed:.8g} m/s" in page
    shares = [100.0 * motion.share for motion in plain.attractors.attractors]
    peak = sum(system.parameter(f"drive.{name}_N_m") for name in ("amplitude", "second_amplitude"))
    for x in (frequency * hertz, slope * speed / hertz, slope * frequency / plain.value, peak, *shares):
        assert np.min(np.abs(numbers_of(page) / x - 1.0)) < 1e-6


@pytest.mark.slow
def test_the_page_of_a_front_has_the_numbers_of_its_table(tmp_path, capsys):
    """In page, table, JSON and terminal those of the search without units times their scales."""
    pytest.importorskip("pymoo")
    case, out = "examples/bench-in-si.toml", tmp_path / "front"
    asked = ["optimise", case, "--over", "drive.frequency_Hz=0.6:2", "--over", "drive.amplitude_N_m=0.3:0.7"]
    asked += ["--against", "cost_of_transport", "--evaluations", "160", "--report"]
    text = " ".join(printed(capsys, *asked, "--out", out).split())
    page, content = (out / "report.html").read_text("utf-8"), json.loads((out / "front.json").read_text("utf-8"))
    system = vc.read_case(case).system
    factors = np.array(
        [1.0 / (2.0 * np.pi * system.si.scales.time_s), *map(system.si.factor_of, ("N m", "m/s", "J/m"))]
    )
    over = {"drive.frequency": (0.6 / factors[0], 2.0 / factors[0])}
    over |= {"drive.amplitude": (0.3 / factors[1], 0.7 / factors[1])}
    plain = vc.pareto_front(system.dimensionless, over, starts=[{"angle": np.pi / 6}], evaluations=160)
    rows = np.column_stack([[[*design.values()] for design in plain.designs], plain.values]) * factors
    assert len(rows) > 1
    points = [[*each["design"].values(), *each["measures"].values()] for each in content["points"]]
    assert [point["unit"] for point in points[0]] == ["Hz", "N m", "m/s", "J/m"]
    assert np.array([[each["value"] for each in one] for one in points]) == pytest.approx(rows, rel=1e-6)
    assert np.loadtxt(out / "front.csv", delimiter=",", skiprows=1)[:, :4] == pytest.approx(rows, rel=1e-6)
    for unit, column in (("m/s", rows[:, 2]), ("J/m", rows[:, 3])):
        assert f"{np.min(column):.6g} to {np.max(column):.6g} {unit}" in text
    assert all(np.min(np.abs(numbers_of(page) / x - 1.0)) < 1e-6 for x in rows.ravel())
    assert main([*asked]) == 2


# --- the local stage, and what else starts lead to --------------------------------------------------------------------


def test_ascent_finds_the_top_of_a_hill_and_stays_within_bounds():
    """A curved ridge (Rosenbrock, turned over) in the unit square; then a slope that rises beyond a bound."""

    def ridge(x):
        a, b = 2.0 * x[0], 2.0 * x[1]
        rise = -np.array([-400.0 * a * (b - a * a) - 2.0 * (1.0 - a), 200.0 * (b - a * a)]) * 2.0
        return 1.0 - 100.0 * (b - a * a) ** 2 - (1.0 - a) ** 2, rise

    assert ascend(np.array([0.1, 0.4]), ridge, 200) == pytest.approx([0.5, 0.5], abs=1e-9)

    def beyond(x):
        return x[0] - (x[1] - 0.3) ** 2, np.array([1.0, 0.6 - 2.0 * x[1]])

    assert ascend(np.array([0.2, 0.9]), beyond, 50) == pytest.approx([1.0, 0.3], abs=1e-10)


def test_ascent_does_not_pass_what_is_not_allowed_and_does_not_claim_a_kink():
    kink = 0.6

    def roof(x):
        return 1.0 - abs(x[0] - kink), np.array([-np.sign(x[0] - kink)])

    assert ascend(np.array([0.2]), roof, 100) is None
    values = []

    def wall(x):
        values.append(float(x[0]))
        return (x[0], np.array([1.0])) if x[0] <= kink else None

    assert ascend(np.array([0.2]), wall, 100) is None
    assert max(x for x in values if x <= kink) == pytest.approx(kink, abs=1e-3)


@pytest.mark.slow
def test_slopes_vanish_at_a_smooth_optimum_and_are_those_of_differences(biharmonic):
    """At the known optimum they are at rounding; with a bound in the way they are those of closed orbits on both sides.

    Value and place are of an independent search; at a smooth optimum the place is known to the root of the value.
    """
    design = optimise(biharmonic, FREQUENCY_AND_PHASE, starts=START, evaluations=640, spread_starts=0)
    assert design.value == pytest.approx(0.104919431678, abs=1e-9)
    assert list(design.design.values()) == pytest.approx([0.90985583, 2.20068755], abs=3e-5)
    assert design.orbit.stable
    assert design.reached_from == (0,)
    assert design.limits == ("nothing: the slopes vanish",)
    assert all(abs(slope) < 1e-10 for pair in design.slopes.values() for slope in pair)
    forward = biharmonic.with_parameters({"drive.second_phase": 2.2})
    bounded = optimise(forward, {"drive.frequency": (0.6, 0.8)}, starts=START, evaluations=64, spread_starts=0)
    assert bounded.limits == ("upper bound of drive.frequency",)
    assert bounded.orbit is not None
    below, above = bounded.slopes["drive.frequency"]
    assert above is None
    step = 1e-4
    speeds = [
        abs(vc.shoot(forward.with_parameters({"drive.frequency": 0.8 + k * step}), bounded.orbit.state).mean_velocity)
        for k in (-1, 1)
    ]
    assert below == pytest.approx((speeds[1] - speeds[0]) / (2 * step), rel=1e-6)


@pytest.mark.parametrize(
    ("beyond", "above"),
    [
        (lambda d: 3.0 * d, 3.0),
        (lambda d: 3.0 * d - 1e3 * d**2, 3.0 - 1e3 * REGION_STEP),
        (lambda d: -7.0 * d, -7.0),  # a kink
        (lambda d: -0.2 * (d > 1e-9) + 3.0 * d, None),
        (lambda d: -0.2 * (d > 0.3 * REGION_STEP) + 3.0 * d, 3.0),
        (lambda d: -0.01 * d**0.5, None),
    ],
)
def test_slopes_across_a_jump_are_left_out_and_the_jump_is_named(beyond, above):
    """The measure is 0.4 + 3 d below the design and 0.4 + beyond(d) above it, d = x - 0.6."""

    def at(shares):
        d = float(shares[0]) - 0.6
        found = {"speed": 0.4 + (3.0 * d if d <= 0.0 else beyond(d))}
        orbit = {"solutions": (1,), "mode_sequence": "FB", "margins": (1.0,), "merit": 0.4}
        return SimpleNamespace(shares=shares, found=found, **orbit)

    near = ClosedDesigns.__new__(ClosedDesigns)
    goal = SimpleNamespace(measure="speed", constraints=(), maximise=True, size=False)
    near.problem = SimpleNamespace(goal=goal, space=DesignSpace((Range("x", 0.0, 1.0),)), samples=None)
    near.at, near.gradient, near.best = at, lambda _: None, at(np.array([0.6]))
    assert near.slopes()["x"] == (pytest.approx(3.0, rel=1e-6), above and pytest.approx(above, rel=1e-6))
    assert ("jump of speed over x" in near.limits()) == (above is None)
    assert ("a kink: speed is worse on both sides in each variable" in near.limits()) == ((above or 0.0) < 0.0)


def test_choices_alone_have_no_slopes():
    near = ClosedDesigns.__new__(ClosedDesigns)
    space = DesignSpace((Column("friction.law", ("coulomb", "lugre")),))
    near.problem = SimpleNamespace(goal=SimpleNamespace(constraints=()), space=space)
    near.best = SimpleNamespace(margins=(1.0,))
    assert (near.slopes(), near.limits()) == ({}, ("nothing: choices alone are compared",))


def test_other_motions_of_a_design_are_said():
    """A machine with mirror-image solutions: half of the starts lead to each, and the design is one of them."""
    machine = vc.PendulumCapsule(mass_ratio=2.5, stiffness=0.88624890, damping=1.40524509)
    system = vc.System(machine, vc.Exponential(), vc.Harmonic(1.8, 1.2))
    design = optimise(system, {"drive.frequency": (1.2, 1.3)}, starts=START, evaluations=32, refinement=20)
    assert design.attractors is not None
    assert design.attractor is not None
    own = design.attractors.attractors[design.attractor]
    assert own.motion.drift == pytest.approx(design.orbit.drift, abs=1e-9)
    twin = design.attractors.attractors[own.twin]
    assert twin.motion.drift == pytest.approx(-design.orbit.drift, abs=1e-9)
    assert own.share + twin.share <= 1.0
    assert f"its mirror-image solution from {100.0 * twin.share:.3g} %" in design.facts["reached"]
    rows = design.attractors.table()
    assert rows[design.attractor]["largest_multiplier"] < 1.0
    assert sum(row["starts"] for row in rows) + np.sum(design.attractors.label < 0) == 64


@pytest.mark.slow
def test_design_that_lifts_off_on_its_way_is_begun_from_where_its_neighbour_has_settled():
    """The neighbour of the trap's best lifts off in its first period from pi/3; its settled motion does not."""
    machine = vc.PendulumCapsule(mass_ratio=0.2, stiffness=1.112276, damping=0.260598, normal_load="dynamic")
    system = vc.System(machine, vc.Exponential(), vc.Harmonic(amplitude=0.852001, frequency=2.408566))
    lifting = vc.ensemble(system, {"initial.angle": [np.pi / 3]}, periods=300, settle=1e-6)
    assert list(vc.Status)[int(lifting["status"][0])].value == "lift off"
    over = {"machine.damping": (0.260598, 0.36)}
    problem = stated_problem(system, over, ["mean_velocity"], [None], (), START, **SEARCH)
    runs = evaluated(problem, np.array([[0.0], [1.0]]))
    assert runs.settled.tolist() == [[False, True], [True, False]]
    assert runs.best_start.tolist() == [1, 0]
    assert runs.best_cost[0] < runs.best_cost[1] < -0.38
    alone = evaluated(problem, np.array([[0.0]]))
    assert not alone.settled.any()
    again = evaluated(problem, np.array([[0.0]]), [evaluated(problem, np.array([[1.0]]))])
    assert again.costs[0, 0, 1] == runs.costs[0, 0, 1]


@pytest.fixture(scope="module")
def fitted():
    """(a fit of the law of the bench to a noisy steady curve, the bench with the fitted law)."""
    speeds = np.tile(np.linspace(0.02, 0.6, 30), 4)
    force = 7.0 * (0.05 + 0.10 * np.exp(-6.5 * speeds)) + np.random.default_rng(1).normal(0.0, 0.005, len(speeds))
    record = vc.Record("curve", np.arange(float(len(speeds))), force, velocity=speeds, normal_force=7.0)
    fit = vc.steady_fit(record, "exponential", starts=2, intervals="covariance")
    bench = vc.read_case("examples/bench-in-si.toml").system
    keys = {"coulomb_coefficient": "coulomb_coefficient", "static_coefficient": "static_coefficient"}
    keys["decay_rate"] = "decay_rate_s_per_m"
    values = {f"friction.{keys[parameter.name]}": parameter.value for parameter in fit.parameters}
    return fit, bench.with_parameters(values)


@pytest.mark.slow
def test_joint_uncertainty_of_a_fit_is_its_covariance(fitted):
    """Samples of the logarithms have the covariance sum_k s_k^2 e_k e_k^T of the fit, about its values."""
    fit, system = fitted
    robustness = vc.robustness(system, {"friction": fit}, samples=1024)
    names = [parameter.name for parameter in fit.parameters]
    paths = ["friction.coulomb_coefficient", "friction.static_coefficient", "friction.decay_rate_s_per_m"]
    assert names == ["coulomb_coefficient", "static_coefficient", "decay_rate"]
    logs = np.log([robustness.parameters[path] for path in paths])
    ways = np.array([[direction.exponents[name] for name in names] for direction in fit.identifiability.directions])
    spread = np.array([direction.deviation for direction in fit.identifiability.directions])
    expected = ways.T @ np.diag(spread**2) @ ways
    assert np.cov(logs) == pytest.approx(expected, rel=0.05, abs=0.02 * np.max(expected))
    assert np.mean(logs, axis=1) == pytest.approx(
        np.log([parameter.value for parameter in fit.parameters]), abs=1e-2 * max(spread)
    )
    assert len(robustness.total) == 3
    assert all(name.startswith("friction: ") for name in robustness.total)


@pytest.mark.slow
def test_fit_goes_into_robust_and_optimise_by_its_file(fitted, tmp_path, capsys):
    fit, system = fitted
    fit.save(tmp_path / "fit")
    case, path = tmp_path / "case.toml", tmp_path / "fit" / "fit.json"
    vc.save_case(system, case)
    content = printed_json(capsys, "robust", case, "--uncertain", f"friction=fit:{path}", "--samples", "16")
    own = vc.robustness(system, {"friction": fit}, samples=16)
    assert content["mean"]["value"] == pytest.approx(own.mean, rel=1e-9)
    search = ["optimise", case, "--over", "drive.frequency_Hz=0.8:1.2", "--evaluations", "32"]
    record = printed_json(capsys, *search, "--uncertain", f"friction=fit:{path}", "--samples", "4")
    assert record["under"][0] == "worst"
    for of, text, said in (
        ("examples/bench-in-si.toml", f"friction=fit:{path}", "put friction.toml of the fit into the case"),
        (case, "friction=fit:nowhere.json", "cannot be read"),
        (case, f"machine=fit:{path}", "has no fitted law; give the fit for friction"),
        (case, f"friction=fit:{case}", "is no fit.json"),
    ):
        assert said in refused(capsys, "robust", of, "--uncertain", text)


def test_what_counts_of_samples_is_the_worst_their_mean_or_the_mean_of_the_worst_tenth():
    for many, tenth in ((16, (1 + 4) / 2), (40, (1 + 4 + 9 + 16) / 4)):  # of 16, a tenth are two
        merits = np.random.default_rng(2).permuted(np.tile(np.arange(1.0, many + 1.0) ** 2, (3, 1)), axis=1)
        of = {"worst": 1.0, "mean": (many + 1) * (2 * many + 1) / 6, "cvar": tenth}
        assert of.keys() == {*CRITERIA}
        for criterion, value in of.items():
            samples = Samples((), np.zeros((many, 1)), criterion)
            assert samples.chosen(merits) == pytest.approx([value] * 3, rel=1e-14)
            spoilt = np.where((np.arange(3) == 1)[:, None] & (np.arange(many) == 5), np.nan, merits)
            assert np.isnan(samples.chosen(spoilt)).tolist() == [False, True, False]


@pytest.mark.parametrize(
    ("system", "uncertain", "settings", "doubt"),
    [
        (SYMMETRIC, {"machine.damping": "factor:0.9:1.1"}, {}, "no travel"),  # its travel is residue
        pytest.param(
            vc.System(vc.PendulumCapsule(0.9, 1.5, 0.3, "dynamic"), vc.Exponential(), vc.Harmonic(4.0, 1.0)),
            {"drive.amplitude": "factor:0.2:0.4"}, {"initial": START[0]}, "lift off",  # the nominal run
            marks=pytest.mark.plain,
        ),
        (DRIVEN_BY_TWO, {"machine.damping": "factor:0.9:1.1"}, {"periods": 4}, "not settled"),
    ],
)  # fmt: skip
def test_what_is_not_to_be_trusted_has_no_direction_and_no_index(system, uncertain, settings, doubt):
    """One rule (`motion.trust`): of residue, failures and transients neither a wrong way nor an index is derived."""
    spread = vc.robustness(system, uncertain, samples=16, **settings)
    assert spread.nominal_doubt == doubt
    assert spread.wrong_way is None
    assert (spread.first_order, spread.total) == (None, None) or doubt == "lift off"
    assert doubt in spread.facts["nominal"]
    if doubt == "not settled":
        assert spread.not_settled == 1.0
        assert np.isnan([spread.mean, *spread.values]).all()
