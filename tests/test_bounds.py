"""Bounds of any drive hold for what a machine says of itself: its ground, what gives it energy, its stroke."""

import math

import pytest

import vibrocap as vc
from mechanisms import Slider
from vibrocap.mechanics import (
    Contact,
    Damper,
    Drive,
    Machine,
    Mass,
    Number,
    Positive,
    Potential,
    Spring,
    Support,
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
    """The two-mass crawler with both masses of one's own, on a belt."""

    body: Positive = parameter(1.0, "M", "body", "mass")
    inner: Positive = parameter(1.0, "m", "inner mass", "mass")
    speed: Number = parameter(0.0, "v", "speed of the belt", "speed")
    position = coordinate("X", "place of the body", "m")
    name, effort = "crawler", "displacement"

    def parts(self, q):
        belt, body = Support("belt", x=self.speed * q.time), Mass("body", self.body, x=q.position)
        inner = Mass("inner mass", self.inner, on=body, x=q.imposed(q.drive))
        return belt, body, inner, Contact(body, on=belt, load=1.0)


@parameters
class Excited(Machine):
    """A capsule with a damper that drives its inner mass."""

    position = coordinate("X", "place of the capsule", "m")
    shift = coordinate("z", "inner mass from the capsule", "m")
    name = "excited"

    def parts(self, q):
        body = Mass("body", 1.0, x=q.position)
        inner = Mass("inner mass", 1.0, on=body, x=q.shift)
        return body, inner, Spring(1.0, q.shift), Damper(-0.1, q.shift), Drive(q.shift), Contact(body, load=1.0)


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
    ("machine", "reason"),
    [
        (Slider(), "ground"),
        (Plates(), "not all contacts are with the ground"),
        (Pulled(), "outside"),
        (Excited(), "damper"),
        (Crawler(speed=0.5), "ground"),
        (vc.Oscillator(stiffness=0.0, belt_speed=0.1), "ground"),
        (vc.Oscillator(), "does not travel"),
    ],
)
def test_machines_that_something_else_moves_have_no_least_cost(machine, reason):
    """The slider's steady motion was 0 times the least cost of all."""
    with pytest.raises(ValueError, match=f"cost of transport: [^;]*{reason}"):
        vc.performance_bounds(vc.System(machine, vc.Coulomb(), vc.Harmonic()))


def test_a_belt_at_rest_and_dampers_leave_the_least_cost():
    """Neither gives energy: a block that never slides back pays friction and damper alone."""
    block = vc.Oscillator(stiffness=0.0, damping=0.1, belt_speed=0.0)
    (cost,) = vc.performance_bounds(vc.System(block, vc.Coulomb(0.2, 0.2), vc.Harmonic()))
    assert (cost.measure, cost.value) == ("cost_of_transport", 0.2)
