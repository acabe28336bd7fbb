"""Axes, designs and lists of cases: what they give, and every complaint before any work."""

import math
import re

import numpy as np
import pytest
from scipy.stats import qmc

import vibrocap as vc
from vibrocap import Exponential, Harmonic, LuGre, PendulumCapsule, System
from vibrocap.case.case import CaseError
from vibrocap.ranges import cell_middles, values_between
from vibrocap.studies.plan import planning
from vibrocap.studies.plan.designs import Design, Drawn, Range, range_from
from vibrocap.studies.plan.planning import check_runs, plan_complaints
from vibrocap.studies.plan.runs import Grid, axis_of, case_list

SYSTEM = System(PendulumCapsule(), Exponential(), Harmonic())


def grid(**axes):
    """A grid of paths written with __ for the dot."""
    return Grid(tuple(axis_of(path.replace("__", "."), values)[0] for path, values in axes.items()))


def complaints(**axes):
    return plan_complaints(SYSTEM, grid(**axes))


@pytest.mark.parametrize(
    ("given", "values"),
    [
        ("0.01:8.1:5", [0.01, 2.0325, 4.055, 6.0775, 8.1]),
        ("-0.1:0.2:4", [-0.1, 0, 0.1, 0.2]),
        ("log:0.001:10:5", [0.001, 0.01, 0.1, 1, 10]),
        ("log:0.01:10:4", np.geomspace(0.01, 10, 4)),
        (" -1 : 1 : 3 ", [-1, 0, 1]),
        ("1,2e-3, 3", [1, 2e-3, 3]),
        ("2.5", [2.5]),
        (np.linspace(0, 1, 3, dtype=np.float32), [0, 0.5, 1]),
        ([1, np.int64(2), np.float64(3)], [1, 2, 3]),
        (range(1, 3), [1, 2]),
        (2, [2]),
    ],
)
def test_values_of_an_axis(given, values):
    axis, wrong = axis_of("machine.mass_ratio", given)
    assert wrong == []
    assert all(type(value) is float for value in axis.values)
    np.testing.assert_array_equal(axis.array, np.asarray(values, float))


@pytest.mark.parametrize("steps", [2, 3, 7, 10, 41])
def test_ranges_hold_the_decimals_that_are_meant(steps):
    """From low to high in steps of a tenth, and middles of cells: the numbers that are written so."""
    for low in range(-20, 21):
        wanted = [float(f"{low + i}e-1") for i in range(steps + 1)]
        assert values_between(low / 10, (low + steps) / 10, steps + 1).tolist() == wanted
        assert cell_middles((2 * low - 1) / 20, (2 * (low + steps) + 1) / 20, steps + 1).tolist() == wanted
    assert values_between(0.1, 1 / 3, 9)[-1] == 1 / 3
    assert values_between(math.pi, 7.0, 5, True)[0] == math.pi


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ("8:1:5", "reversed"), ("1:1:5", "empty"), ("1:2:1", "at least 2 values"), ("1:2", "should be LOW:HIGH:COUNT"),
        ("1:2:3:4", "should be LOW:HIGH:COUNT"), ("1:2:x", "should be LOW:HIGH:COUNT"),
        ("lg:1:2:3", "should be LOW:HIGH:COUNT"), ("log:0:1:5", "begin above 0"), ("1:inf:3", "finite"),
        ("1,nan", r"got nan \(value 2\)"), ([1.0, 10**400], r"got inf \(value 2\)"), ([1, 2, 1.0], "1.0 twice"),
        ("1,,2", "a list such as"), ([], "no values"), ([True], "numbers or words"), ([None], "numbers or words"),
        (np.ones((2, 2)), "shape"), ({"a": 1}, "list of values"), (None, "list of values"),
    ],
)  # fmt: skip
def test_values_that_are_none(given, said):
    (wrong,) = axis_of("machine.mass_ratio", given)[1]
    assert re.match(r"machine.mass_ratio: .*" + said, wrong, re.DOTALL)


def test_kinds_are_words_of_the_catalogue():
    assert axis_of("friction.law", "exponential,lugre")[1] == []
    assert "did you mean 'lugre'" in axis_of("friction.law", ["lugr"])[1][0]
    assert "there is bouc-wen, coulomb, dahl" in axis_of("friction.law", [1.0])[1][0]
    assert "should hold numbers, got 'up'" in axis_of("initial.angle", "0.1,up")[1][0]


def test_unknown_paths_and_the_nearest():
    assert "did you mean 'machine.mass_ratio'?" in complaints(machine__mass_rato="1:2:3")[0]
    assert "did you mean 'initial.angle'?" in complaints(initial__angel="1:2:3")[0]
    assert "there is machine.mass_ratio, " in complaints(xyz="1:2:3")[0]
    said = complaints(friction__law="exponential,lugre", friction__decay_rate="1:2:3", initial__bristle=[0.0])
    assert said[0].startswith("friction.decay_rate: 'lugre' has none")
    assert said[1].startswith("initial.bristle: 'exponential' has none")
    assert complaints(friction__law="lugre", friction__bristle_stiffness="1:2:3", initial__bristle=[0.0]) == []


def test_values_that_a_part_refuses_are_all_named():
    said = complaints(machine__mass_ratio="-1:2:4", drive__frequency=[0.0, 1.0], machine__normal_load="weigth,1")
    assert said[0] == "machine.mass_ratio: should be greater than 0, got -1.0 (and 1 more such)"
    assert any(text.startswith("drive.frequency: should be greater than 0, got 0.0") for text in said)
    assert any(text.startswith("machine.normal_load: ") and "'weigth'" in text for text in said)
    assert len(said) == 3


def test_values_that_refuse_one_another():
    """The static level should not be below the Coulomb level, whichever of the two varies and whatever the case has."""
    good = {"friction__coulomb_coefficient": [0.05, 0.1], "friction__static_coefficient": [0.1, 0.12]}
    assert complaints(**good) == []  # though 0.1 is below the Coulomb level of the case itself
    said = complaints(friction__coulomb_coefficient=[0.1, 0.5], friction__static_coefficient=[0.2, 0.6])
    assert said == ["friction.static_coefficient: should be at least coulomb_coefficient (0.5), got 0.2"]
    said = complaints(friction__law="exponential,lugre", machine__normal_load=[1.0, 0.0])
    assert said == ["machine.normal_load: should be > 0 with the lugre law, got 0"]


def test_a_long_axis_is_checked_at_its_extremes(monkeypatch):
    monkeypatch.setattr(planning, "LIMIT", 1000)
    values = np.linspace(1, 2, 3000)
    values[1001] = -1.0
    assert "got -1.0" in complaints(machine__mass_ratio=values)[0]
    levels = {"friction__coulomb_coefficient": "0.1:0.5:40", "friction__static_coefficient": "0.49:0.6:40"}
    assert "static_coefficient" in complaints(**levels)[0]  # values that refuse one another, at the corners
    assert complaints(**levels | {"friction__static_coefficient": "0.5:0.6:40"}) == []


def test_a_run_that_is_refused_later_is_named():
    values = {"friction.static_coefficient": np.array([0.5, 0.2]), "friction.coulomb_coefficient": np.array([0.3, 0.3])}
    with pytest.raises(CaseError, match=r"friction.static_coefficient = 0.2.*\n.*at least coulomb_coefficient"):
        check_runs(SYSTEM, values)


def test_blocks_of_a_grid_are_the_grid():
    plan = grid(machine__mass_ratio="1:2:5", friction__law="exponential,lugre", initial__angle="0:1:3")
    assert (plan.dims, plan.shape, plan.count) == (plan.paths, (5, 2, 3), 30)
    whole = plan.values((slice(0, 5), slice(0, 2), slice(0, 3)))
    part = plan.values((slice(2, 5), slice(1, 2), slice(0, 2)))
    for path, values in part.items():
        np.testing.assert_array_equal(values, whole[path].reshape(5, 2, 3)[2:5, 1:2, 0:2].ravel())
    assert Grid.from_record(plan.record()) == plan


@pytest.mark.parametrize("kind", ["sobol", "halton", "latin-hypercube", "random"])
def test_a_design_gives_each_run_the_same_values_in_any_block(kind):
    plan = Drawn(Design(kind, 100, seed=3), (Range("a", 1.0, 3.0), Range("b", 0.01, 10.0, True)))
    whole = plan.values((slice(0, 100),))
    for start, stop in ((0, 1), (1, 2), (0, 37), (37, 64), (64, 100), (99, 100)):
        for path, values in plan.values((slice(start, stop),)).items():
            np.testing.assert_array_equal(values, whole[path][start:stop])
    other = Drawn(Design(kind, 100, seed=4), plan.ranges).values((slice(0, 100),))
    assert np.all(whole["a"] != other["a"])
    assert 1.0 <= whole["a"].min() < 1.3
    assert 2.7 < whole["a"].max() <= 3.0
    assert 20 < np.sum(whole["b"] < 0.1) < 47  # a third of the logarithm
    if kind == "sobol":
        expected = qmc.Sobol(2, rng=np.random.default_rng(3)).random(128)[:100, 0]
        np.testing.assert_array_equal(whole["a"], 1.0 + 2.0 * expected)


def test_ranges_of_a_design():
    assert range_from("machine.mass_ratio", "0.1:8") == (Range("machine.mass_ratio", 0.1, 8.0), [])
    assert range_from("machine.mass_ratio", "log:0.1:8")[0].logarithmic
    assert range_from("machine.mass_ratio", (np.float64(0.1), 8)) == (Range("machine.mass_ratio", 0.1, 8.0), [])
    for given in ((2, 1), (1, 1), (1, math.nan), (1, 2, 3), "1:2:3", "2:1", "log:-1:1", 3, None, (True, 2), ("a", "b")):
        assert len(range_from("machine.mass_ratio", given)[1]) == 1, given
    assert "run a study for each" in range_from("friction.law", ("exponential", "lugre"))[1][0]
    assert Design("sobol", 8).complaints() == []
    assert len(Design("sobool", 0, -1).complaints()) == 3
    assert plan_complaints(SYSTEM, Drawn(Design("sobol", 8), (Range("machine.mass_ratio", -1, 1),)))


def test_cases_give_what_they_give():
    cases = [{"machine.mass_ratio": 3}, {"machine.normal_load": "weight", "initial.angle": np.float64(0.5)}]
    plan, wrong = case_list(cases)
    assert (wrong, plan.dims, plan.shape) == ([], ("case",), (2,))
    assert plan.case(1) == {"machine.normal_load": "weight", "initial.angle": 0.5}
    values = plan.values((slice(0, 2),))
    np.testing.assert_array_equal(values["machine.mass_ratio"], [3.0, np.nan])
    assert list(values["machine.normal_load"]) == [None, "weight"]


def test_cases_that_are_none():
    assert case_list([])[1] == ["cases: there are none"]
    assert (
        len(case_list([{}, 3, {"machine.mass_ratio": math.nan}, {"friction.law": "x"}, {"initial.angle": "x"}])[1]) == 5
    )
    plan, _ = case_list([{"friction.decay_rate": 1, "friction.law": "lugre"}, {"machine.damping": -1}, {"drive.f": 1}])
    said = plan_complaints(SYSTEM, plan)
    assert said[0].startswith("cases[0]: friction.decay_rate: there is no such quantity here")
    assert said[1] == "cases[1]: machine.damping: should be at least 0, got -1.0"
    assert said[2].startswith("cases[2]: drive.f: ")
    plan, _ = case_list([{"friction.law": "lugre", "friction.bristle_stiffness": 50}])
    assert plan_complaints(SYSTEM, plan) == []
    assert plan_complaints(System(PendulumCapsule(), LuGre(), Harmonic()), plan) == []


def test_an_axis_is_labelled_by_the_part_that_it_belongs_to():
    """Oscillators have a stiffness, too."""
    system = vc.System(vc.PendulumCapsule(), vc.Exponential(), vc.Harmonic())
    study = vc.sweep(system, {"machine.stiffness": [2.0, 2.1]}, periods=2, measures=["drift"], tolerance=1e-8, settle=0)
    assert study["machine.stiffness"].attrs["symbol"] == "rho"
    assert study["machine.stiffness"].attrs["long_name"].startswith("torsional spring")
