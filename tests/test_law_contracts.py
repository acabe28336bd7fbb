"""One harness over all friction laws, plain and wrapped, found by looking into their folder: a new file is tested by
itself.

Every law is taken with its defaults and with random values in which no parameter is zero, so that each term counts.
"""

import numpy as np
import pytest

import vibrocap as vc
from imposed_motion import stroke
from law_instances import LAW_NAMES, LAWS, WRAPPED, without_viscosity
from vibrocap.contracts.law_clauses import LAW_CLAUSES
from vibrocap.contracts.samples import draws, random_internal, random_motion
from vibrocap.contracts.system_clauses import recorded
from vibrocap.physics.catalogue import law as law_of
from vibrocap.physics.catalogue import laws, wrappers
from vibrocap.physics.parameters import parameter_table

EPSILON = float(np.finfo(float).eps)
each_law = pytest.mark.parametrize("law", LAWS, ids=LAW_NAMES)
each_dynamic_law = pytest.mark.parametrize(
    "law",
    [law for law in LAWS if law.internal],
    ids=[name for law, name in zip(LAWS, LAW_NAMES, strict=True) if law.internal],
)


# --- what a law says of itself ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("law", [*laws().values(), *map(law_of, WRAPPED)], ids=lambda law: law.name)
def test_a_law_states_its_equation_and_is_found_by_its_name(law):
    assert " = " in law.__doc__
    assert law().symmetric == ("anisotropic" not in law.name)
    assert law.name in laws()
    assert law_of(law.name) is law


def test_wrapped_laws_have_the_fields_of_both():
    law = law_of("backlash-anisotropic-lugre")
    names = [info.name for info in parameter_table(law)]
    lugre = [info.name for info in parameter_table(vc.LuGre)]
    assert names == [*lugre, "forward_ratio", "back_ratio", "gap"]
    assert list(laws()) == sorted(laws())
    assert not any(name.startswith(("anisotropic", "backlash")) for name in laws())
    assert set(wrappers()) == {"anisotropic", "backlash", "smoothed", "viscous"}
    with pytest.raises(ValueError, match="static_coefficient: should be at least"):
        law(static_coefficient=0.1)
    with pytest.raises(ValueError, match="back_ratio"):
        law(back_ratio=0.0)


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("anisotropic-smoothed-tanh", "only a set-valued or kinked law can be made anisotropic, got the smoothed-tanh"),
        ("backlash-coulomb", "only a dynamic law .* got the coulomb law, which is set-valued with 0 internal states"),
        ("backlash-backlash-dahl", "has backlash already"),
        ("smoothed-dahl", "only a set-valued law can be smoothed, got the dahl law, which is kinked"),
        ("anisotropic-backlash-anisotropic-dahl", "is anisotropic already"),
    ],
)
def test_wrappers_refuse_what_they_do_not_fit(name, message):
    with pytest.raises(ValueError, match=message):
        law_of(name)
    assert name not in laws()


def test_an_unknown_law_is_refused():
    with pytest.raises(KeyError, match=r"no friction law is called 'lugree'; there is .*lugre"):
        law_of("backlash-lugree")
    assert "backlash-lugree" not in laws()


# --- its contract, clause by clause ----------------------------------------------------------------------------------


@each_law
def test_law_keeps_its_contract(law):
    table = {clause.__name__: clause(law) for clause in (*LAW_CLAUSES, recorded)}
    assert {name: words for name, words in table.items() if words is not None} == {}


# --- the equations ---------------------------------------------------------------------------------------------------


@each_law
def test_steady_force_is_the_force_that_a_constant_velocity_settles_to(law):
    for draw in draws(2):
        velocity, internal, side, load = random_motion(law, draw)
        velocity = velocity + 0.1 * side
        if not law.internal:
            force, _ = law.force(velocity, internal, side, load)
        else:
            force = stroke(law, velocity, 1e3, internal, load=load, samples=2, tolerance=1e-8).friction[-1]
        in_direction = (side,) if "forward_ratio" in law.__dataclass_fields__ else ()
        slow, exponent = 1e-7, getattr(law, "shape_exponent", 1.0)
        if exponent > 1.0:  # Dahl's approach 1 - r = [1 + (i - 1) x/Y]^(-1/(i - 1))
            value = 1e3 * abs(velocity) / law.internal_scales(load)[0]
            slow += 1.1 * (1.0 + (exponent - 1.0) * value) ** (-1.0 / (exponent - 1.0))
        expected = side * law.steady_force(abs(velocity), load, *in_direction)
        assert force == pytest.approx(expected, rel=slow)


@each_law
def test_friction_force_scales_with_the_load(law):
    """N once (erratum 1): with deflections in proportion, twice the load is twice the force of a dry contact."""
    for draw in draws(10):
        speed, _, _, load = random_motion(law, draw)
        dry, speed = without_viscosity(law), abs(speed) + 1e-3
        assert dry.steady_force(speed, 2 * load) == pytest.approx(2 * dry.steady_force(speed, load), rel=8 * EPSILON)


def test_every_law_that_can_be_passive_is_so_somewhere():
    assert {law.name for law in LAWS if law.passive} >= set(laws())


@each_dynamic_law
def test_only_a_joint_that_closes_makes_the_force_jump(law):
    """The force is continuous from piece to piece, but where the joint of a backlash closes on a damped contact."""
    members = set()
    for draw in draws(4):
        side, load = draw.choice((1, -1)), draw.uniform(0.5, 2.0)
        internal = random_internal(law, 0.0, -side, load, draw)
        found = stroke(law, 0.2 * side, 1.0, internal, load=load, samples=2, turned=True)
        for _time, which, before, after in found.switches:
            members.add(which)
            assert abs(law.switches(0.2 * side, before, side, load)[which]) <= 1e-6
            if "engaged" not in law.internal or which != 1:
                jump = law.force(0.2 * side, after, side, load)[0] - law.force(0.2 * side, before, side, load)[0]
                assert abs(jump) <= 1e-5 * load
    assert len(members) >= min(1, len(law.switched))
