"""Bounds of any drive hold for what a machine says of itself: its ground, what gives it energy, its stroke."""

import math

import pytest

import vibrocap as vc
from mechanisms import Slider
from vibrocap.mechanics import (
    Contact,
    Drive,
    Machine,
    Mass,
    Positive,
    Potential,
    Spring,
    coordinate,
    parameter,
    parameters,
)


@parameters
class Plates(Machine):
    """Two plates, the upper one on the lower one: it travels with it, and slides over nothing in the end."""

    position = coordinate("X", "place of the lower plate", "m")
    ahead = coordinate("z", "upper plate from the lower one", "m")
    name = "plates"

    def parts(self, q):
        lower = Mass("lower", 1.0, x=q.position)
        upper = Mass("upper", 1.0, on=lower, x=q.ahead)
        contacts = Contact(lower, load=1.0), Contact(upper, on=lower, load=1.0)
        return lower, upper, Spring(2.0, q.ahead), Drive(q.ahead), contacts


@parameters
class Pulled(Machine):
    """A block on the ground that a constant force pulls."""

    position = coordinate("X", "place of the block", "m")
    name = "pulled"

    def parts(self, q):
        block = Mass("block", 1.0, x=q.position)
        return block, Potential(-0.3 * q.position), Drive(q.position), Contact(block, load=1.0)


@parameters
class Crawler(Machine):
    """The two-mass crawler with both masses of one's own."""

    body: Positive = parameter(1.0, "M", "body", "mass")
    inner: Positive = parameter(1.0, "m", "inner mass", "mass")
    position = coordinate("X", "place of the body", "m")
    name, effort = "crawler", "displacement"

    def parts(self, q):
        body = Mass("body", self.body, x=q.position)
        return body, Mass("inner mass", self.inner, on=body, x=q.imposed(q.drive)), Contact(body, load=1.0)


def test_the_largest_speed_is_that_of_the_stroke_of_the_body():
    """It counted each inner mass as 1, and an imposed angle as a stroke along the line."""
    law = vc.Coulomb(0.2, 0.2)
    _, speed = vc.performance_bounds(vc.System(Crawler(body=3.0, inner=0.5), law, vc.Harmonic(0.5)))
    assert speed.value == pytest.approx(math.sqrt(0.5 / 3.5 * (0.2 / 3.5) / 2.0), rel=1e-12)
    _, speed = vc.performance_bounds(vc.System(vc.PendulumCrawler(2.5), law, vc.Harmonic(0.5)))
    assert speed.value == pytest.approx(math.sqrt(1.0 / 3.5 * (0.2 / 3.5) * 2.0 * math.sin(0.5) / 2.0), rel=1e-12)
    whole_turns = vc.performance_bounds(vc.System(vc.PendulumCrawler(2.5), law, vc.Harmonic(2.0)))
    assert [bound.measure for bound in whole_turns] == ["cost_of_transport"]


@pytest.mark.parametrize(
    ("machine", "said"),
    [(Slider(), "ground moves"), (Plates(), "not all contacts are with the ground"), (Pulled(), "outside")],
)
def test_machines_that_something_else_moves_have_no_least_cost(machine, said):
    """The slider's steady motion was 0 times the least cost of all."""
    with pytest.raises(ValueError, match=said):
        vc.performance_bounds(vc.System(machine, vc.Coulomb(), vc.Harmonic()))
