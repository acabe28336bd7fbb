"""One harness over all friction laws, plain and wrapped, found by looking into their folder: a new file is tested by
itself.

Every law is taken with its defaults and with random values in which no parameter is zero, so that each term counts.
"""

import dataclasses
import math
import pickle
import re

import numpy as np
import pytest

import vibrocap as vc
from imposed_motion import settled_pieces, stroke
from law_instances import LAW_NAMES, LAWS, WRAPPED, draws, mirrored, random_internal, random_motion, without_viscosity
from vibrocap.numerics.expressions.graph import Graph, derivative, evaluate
from vibrocap.physics.catalogue import law as law_of
from vibrocap.physics.catalogue import laws, wrappers
from vibrocap.physics.parameters import parameter_table

EPSILON = float(np.finfo(float).eps)
SAMPLES = 25
each_law = pytest.mark.parametrize("law", LAWS, ids=LAW_NAMES)
each_dynamic_law = pytest.mark.parametrize(
    "law",
    [law for law in LAWS if law.internal],
    ids=[name for law, name in zip(LAWS, LAW_NAMES, strict=True) if law.internal],
)


def outcomes(law, velocity, internal, side, load, back=lambda states: states):
    """Every guard with the states after it, in an order that does not depend on their numbers."""
    guards = law.switches(velocity, internal, side, load)
    after = [law.after_switch(i, velocity, internal, side, load) for i in range(len(guards))]
    return sorted(zip(guards, map(back, after), strict=True))


# --- what a law says of itself ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("law", [*laws().values(), *map(law_of, WRAPPED)], ids=lambda law: law.name)
def test_declarations_fit_together(law):
    fields = {info.name for info in parameter_table(law)}
    assert re.search(r"\b1[789]\d\d|20\d\d", law.source), "the year in which it was published"
    assert " = " in law.__doc__, "its equation"
    assert isinstance(law.creeps, bool)
    assert set(law.shape_parameters) <= fields
    assert set(law.switched) <= set(law.internal)
    assert len(set(law.internal)) == len(law.internal)
    assert law.internal_symmetry is None or len(law.internal_symmetry) == len(law.internal)
    assert law().symmetric == ("anisotropic" not in law.name)
    if law.kind != "kinked":
        assert not law.internal
    assert law.name in laws()
    assert law_of(law.name) is law


@each_law
def test_law_is_a_value(law):
    again = pickle.loads(pickle.dumps(law))
    assert again == law
    assert type(again) is type(law)
    assert hash(again) == hash(law)


def test_wrapped_laws_have_the_fields_of_both():
    law = law_of("backlash-anisotropic-lugre")
    names = [info.name for info in parameter_table(law)]
    lugre = [info.name for info in parameter_table(vc.LuGre)]
    assert names == [*lugre, "forward_ratio", "back_ratio", "gap"]
    assert list(laws()) == sorted(laws())
    assert not any(name.startswith(("anisotropic", "backlash")) for name in laws())
    assert set(wrappers()) == {"anisotropic", "backlash", "smoothed"}
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


# --- the equations ---------------------------------------------------------------------------------------------------


@each_law
def test_law_is_as_symmetric_as_it_says(law):
    """(-v, -side) with mirrored states gives (-R, mirrored rates), the same losses, energy and pieces, exactly."""
    different = 0
    for draw in draws(SAMPLES):
        velocity, internal, side, load = random_motion(law, draw)
        there, back = (velocity, internal, side, load), (-velocity, mirrored(law, internal), -side, load)
        (force, rates), (mirror, mirror_rates) = law.force(*there), law.force(*back)
        assert law.stored_energy(back[1]) == law.stored_energy(internal)
        if not law.symmetric:
            different += mirror != -force or law.losses(*back) != law.losses(*there)
            continue
        assert (mirror, mirrored(law, mirror_rates)) == (-force, rates)
        assert law.losses(*back) == law.losses(*there)
        assert outcomes(law, *back, lambda states: mirrored(law, states)) == outcomes(law, *there)
        assert mirrored(law, law.after_reversal(back[1], side, load)) == law.after_reversal(internal, -side, load)
    assert (different > 0) == (not law.symmetric)


@each_law
def test_law_is_finite(law):
    for draw in draws(SAMPLES):
        velocity, internal, side, load = random_motion(law, draw)
        for speed in (velocity, 0.0, side * 1e-300, side * 1e3):
            force, rates = law.force(speed, internal, side, load)
            guards = law.switches(speed, internal, side, load)
            assert all(map(math.isfinite, (force, *rates, *guards, *law.losses(speed, internal, side, load))))
        assert math.isfinite(law.steady_force(abs(velocity), load))
        assert len(law.internal_scales(load)) == len(rates) == len(law.internal)
        assert all(scale > 0.0 for scale in law.internal_scales(load))


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
            way = 1e3 * abs(velocity) / law.internal_scales(load)[0]
            slow += 1.1 * (1.0 + (exponent - 1.0) * way) ** (-1.0 / (exponent - 1.0))
        expected = side * law.steady_force(abs(velocity), load, *in_direction)
        assert force == pytest.approx(expected, rel=slow)


@each_law
def test_friction_force_scales_with_the_load(law):
    """N once (erratum 1): with deflections in proportion, twice the load is twice the force of a dry contact."""
    for draw in draws(10):
        speed, _, _, load = random_motion(law, draw)
        dry, speed = without_viscosity(law), abs(speed) + 1e-3
        assert dry.steady_force(speed, 2 * load) == pytest.approx(2 * dry.steady_force(speed, load), rel=8 * EPSILON)


@each_law
def test_kind_of_law_is_what_it_claims(law):
    """Set-valued: a jump at rest, to no more than what it holds. Kinked: the force goes on, it or its rates bend."""
    if law.kind == "set-valued":
        forward, back = (law.force(0.0, (), side, 1.3)[0] for side in (1, -1))
        middle, limit = law.holding_middle(1.3), law.holding_limit(1.3)
        assert middle - limit - 4 * EPSILON <= back < 0.0 < forward <= middle + limit + 4 * EPSILON
        assert (middle == 0.0) == law.symmetric
        return
    with pytest.raises(NotImplementedError):
        law.holding_limit(1.3)
    bends = 0
    for draw in draws(10):
        _, internal, _, load = random_motion(law, draw)
        found = []
        for side in (1, -1):
            pieces = settled_pieces(law, 0.0, law.after_reversal(internal, side, load), side, load)
            at_rest, ahead = (
                np.array([force, *rates])
                for force, rates in (law.force(v, pieces, side, load) for v in (0.0, 1e-6 * side))
            )
            found.append((at_rest, ahead - at_rest))
        (forward, ahead), (back, behind) = found
        assert forward[0] == back[0]
        bends += not np.allclose(ahead, -behind, rtol=1e-3, atol=1e-14)
    if not law.name.startswith("smoothed-"):  # of a smoothed law at most the second derivative jumps, like v |v|
        assert (bends > 0 or law.switched != ()) == (law.kind == "kinked")


@each_law
def test_energy_of_the_contact_is_accounted_for(law):
    """R v = d(stored)/dt + contact sliding + bristle loss, in every piece."""
    for draw in draws(SAMPLES):
        velocity, internal, side, load = random_motion(law, draw)
        graph = Graph()
        z = tuple(graph.node("state", i) for i in range(len(internal)))
        stored = graph.expression(law.stored_energy(z))
        slopes = evaluate([derivative(stored, i) for i in range(len(z))], 0.0, internal, side, ())
        force, rates = law.force(velocity, internal, side, load)
        growth = [slope * rate for slope, rate in zip(slopes, rates, strict=True)]
        losses = law.losses(velocity, internal, side, load)
        size = abs(force * velocity) + sum(map(abs, growth)) + sum(map(abs, losses))
        assert abs(force * velocity - sum(growth) - sum(losses)) <= 16 * EPSILON * size


def losses_are_its_own(law):
    """Whether the claim of a law to be passive rests on its own split: see `BoucWen.passive`."""
    return getattr(law, "elastic_shape", 0.0) <= getattr(law, "dissipative_shape", 0.0)


@each_law
def test_a_law_that_claims_to_be_passive_never_gives_energy(law):
    assert isinstance(law.passive, bool)
    if law.passive and losses_are_its_own(law):
        for draw in draws(100):
            motion = random_motion(law, draw)
            assert sum(law.losses(*motion)) >= -4 * EPSILON * abs(law.force(*motion)[0] * motion[0])


def test_every_law_that_can_be_passive_is_so_somewhere():
    assert {law.name for law in LAWS if law.passive} >= set(laws())


def test_a_law_that_is_not_passive_gives_energy_somewhere():
    """The paper's LuGre values: the claim is no idle one. At its bound it is passive."""
    law = vc.LuGre()
    assert not law.passive
    assert min(sum(law.losses(*random_motion(law, draw))) for draw in draws(4000)) < 0.0
    assert dataclasses.replace(law, viscous_damping=1.001 * 10.0 * 0.3 / 0.15).passive
    assert not dataclasses.replace(law, viscous_damping=0.999 * 10.0 * 0.3 / 0.15).passive


# --- pieces ----------------------------------------------------------------------------------------------------------


@each_law
def test_pieces_change_whole_numbers_only_and_do_not_chatter(law):
    """Rates of switched states are 0.0; what a switch changes keeps its new piece, which `settled_pieces` asserts."""
    switched = [i for i, name in enumerate(law.internal) if name in law.switched]
    for draw in draws(SAMPLES):
        velocity, internal, side, load = random_motion(law, draw)
        _, rates = law.force(velocity, internal, side, load)
        assert all(type(rates[i]) is float and rates[i] == 0.0 for i in switched)
        assert all(internal[i] in (-1.0, 0.0, 1.0) for i in switched)
        for which, guard in enumerate(law.switches(velocity, internal, side, load)):
            assert guard > 0.0
            after = law.after_switch(which, velocity, internal, side, load)
            assert len(after) == len(internal)
            assert after != internal or guard == 1.0
        turned = settled_pieces(law, 0.0, law.after_reversal(internal, -side, load), -side, load)
        assert turned[: len(internal)] is not None
    if law.switched:
        assert law.switches(0.1, (0.0,) * len(law.internal), 1, 1.0)


@each_dynamic_law
def test_only_a_joint_that_closes_makes_the_force_jump(law):
    """The force is continuous from piece to piece, but where the joint of a backlash closes on a damped contact."""
    seen = set()
    for draw in draws(4):
        side, load = draw.choice((1, -1)), draw.uniform(0.5, 2.0)
        internal = random_internal(law, 0.0, -side, load, draw)
        found = stroke(law, 0.2 * side, 1.0, internal, load=load, samples=2, turned=True)
        for _time, which, before, after in found.switches:
            seen.add(which)
            assert abs(law.switches(0.2 * side, before, side, load)[which]) <= 1e-6
            if "engaged" not in law.internal or which != 1:
                jump = law.force(0.2 * side, after, side, load)[0] - law.force(0.2 * side, before, side, load)[0]
                assert abs(jump) <= 1e-5 * load
    assert len(seen) >= min(1, len(law.switched))
