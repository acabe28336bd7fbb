"""Every machine of the package, derived from what it is made of, against the same derived by hand."""

import math
import random

import pytest

import vibrocap as vc
from hand_machines import block_row, crawler, worm
from hand_machines.linkage_crawler import LinkageCrawler
from hand_machines.mode_coupling_block import ModeCouplingBlock
from hand_machines.oscillator import Oscillator
from hand_machines.oscillator_with_stops import OscillatorWithStops
from hand_machines.pendulum_capsule import PendulumCapsule
from hand_machines.pendulum_capsule_with_stops import PendulumCapsuleWithStops
from hand_machines.pendulum_crawler import PendulumCrawler
from hand_machines.rigid_stop_capsule import RigidStopCapsule
from hand_machines.rotor_capsule import RotorCapsule
from hand_machines.two_mass_capsule import TwoMassCapsule
from hand_machines.two_mass_crawler import TwoMassCrawler
from hand_machines.vibro_impact_capsule import VibroImpactCapsule
from vibrocap.physics.catalogue import machines
from vibrocap.physics.parameters import parameter_table

BACK = {"back_gap": 0.5}
BOTH = {**BACK, "stop_damping": 0.3, "back_stop_stiffness": 7.0, "back_stop_damping": 0.2}
CASES = [
    (PendulumCapsule, {"normal_load": 1.0}),
    (PendulumCapsule, {"normal_load": "weight"}),
    (PendulumCapsule, {"normal_load": "dynamic"}),
    (RotorCapsule, {"normal_load": "weight"}),
    (RotorCapsule, {"normal_load": "dynamic"}),
    (PendulumCapsuleWithStops, {"normal_load": "dynamic"}),
    (PendulumCapsuleWithStops, {"restitution": 0.6}),
    (PendulumCapsuleWithStops, {"restitution": 0.0}),
    (TwoMassCapsule, {"actuation": "internal"}),
    (TwoMassCapsule, {"actuation": "external", "normal_load": "weight"}),
    (VibroImpactCapsule, {}),
    (VibroImpactCapsule, BACK),
    (VibroImpactCapsule, BOTH),
    (RigidStopCapsule, {}),
    (RigidStopCapsule, BACK),
    (RigidStopCapsule, {"actuation": "external"}),
    (Oscillator, {}),
    (Oscillator, {"belt_speed": 0.3}),
    (OscillatorWithStops, {}),
    (OscillatorWithStops, {**BACK, "belt_speed": 0.2}),
    (OscillatorWithStops, {**BOTH, "stop_stiffness": 9.0}),
    (OscillatorWithStops, {"stop_stiffness": 9.0, "stop_damping": 0.5}),
    (ModeCouplingBlock, {}),
    (LinkageCrawler, {}),
    *((block_row.block_row(n), {"belt_speed": speed}) for n, speed in ((2, 0.0), (3, 0.2), (6, 0.2))),
    *((crawler.crawler(n), {}) for n in (2, 3, 5)),
    *((worm.worm(n), {}) for n in (2, 3, 5)),
    (TwoMassCrawler, {}),
    (PendulumCrawler, {"motion": "angle"}),
    (PendulumCrawler, {"motion": "displacement"}),
]
FEW, MANY = 10, 200  # draws
ROUNDING = 1e-14
AROUND = {
    "slope": {"environment": vc.Environment(0.2, 0.1, 0.2, force=0.05, gravity=1.1)},
    "slope over a belt": {"environment": vc.Environment(0.2, 0.1, force=0.05, gravity=1.1)},
    "level": {"environment": vc.Environment(0.0, 0.1, force=0.05)},
    "actuator": {"actuator": vc.Actuator(limit=0.9)},
    "controller": {"controller": vc.PositionPID()},
}


def pair(by_hand, given, draw):
    """(by hand, described) of one kind, with the same random numbers."""
    made = type_of(by_hand)
    numbers = {}
    for info in parameter_table(by_hand):
        if isinstance(info.default, float) and info.name not in given:
            free = draw.uniform(0.0, 0.3) if info.name != "belt_speed" else 0.0
            numbers[info.name] = info.default * draw.uniform(0.6, 1.4) if info.default else free
    for name, value in given.items():
        number = isinstance(value, float) and name not in ("normal_load", "restitution", "back_gap")
        numbers[name] = value * draw.uniform(0.8, 1.1) if number else value
    if "limit_angle" in numbers:
        numbers["limit_angle"] = 0.4
    return by_hand(**numbers), made(**numbers)


def type_of(by_hand):
    """The machine of the package of the same name."""
    return machines()[by_hand.name]


def flat(x):
    """All numbers in tuples of tuples."""
    if isinstance(x, (tuple, list)):
        return [value for each in x for value in flat(each)]
    return [] if x is None else [float(x)]


def far(a, b):
    """The largest difference over the size of the numbers."""
    a, b = flat(a), flat(b)
    size = 1.0 + max(map(abs, a), default=0.0)
    return math.inf if len(a) != len(b) else max((abs(x - y) / size for x, y in zip(a, b, strict=True)), default=0.0)


def load(reaction, frictions):
    """N of b N = n + s R."""
    over, own, *slopes = reaction
    return (own + sum(s * r for s, r in zip(slopes, frictions, strict=True))) / over


def in_ways(machine, guards, y):
    """Guards of a machine with stops on the ground, whose way behind once had another natural size."""
    if (
        len(guards) == 3
        and "sliding_velocity" in machine.states
        and y[-1] <= (0.0 if not machine.locked or not y[-1] else -2.0)
    ):
        size = machine.back_gap / machine.gap if isinstance(machine, OscillatorWithStops) else 1.0
        way = guards[1] if y[-1] < 0.0 and not machine.locked else guards[2]
        return [way * size if each == way else each for each in guards]
    return guards


def at_stop(machine, y, side):
    """The state of a machine that rests at a rigid stop."""
    place, speed = machine.locked["touching"]
    low, high = machine.room()[place]
    rest = {
        place: high if side > 0 else low,
        speed: -machine.ground_speed() if speed in machine.contact_states else 0.0,
    }
    return [rest.get(name, value) for name, value in zip(machine.states, y, strict=True)]


@pytest.mark.parametrize("draws", [FEW, pytest.param(MANY, marks=pytest.mark.slow)])
@pytest.mark.parametrize(("by_hand", "given"), CASES, ids=lambda x: getattr(x, "name", None) or ",".join(x))
def test_described_machines_agree_with_those_derived_by_hand(by_hand, given, draws):
    draw, worst = random.Random(1), {}

    def compared(name, a, b):
        worst[name] = max(worst.get(name, 0.0), far(a, b))

    for _ in range(draws):
        old, new = pair(by_hand, given, draw)
        if new.imposes_motion:
            drive = vc.Biharmonic(draw.uniform(0.1, 0.5), 1.1)
            old, new = old.driven_by(drive), new.driven_by(drive)
        t, drive = draw.uniform(0.0, 3.0), draw.uniform(-1.0, 1.0)
        y = [draw.uniform(-0.3, 0.3) for _ in old.states]
        frictions = tuple(draw.uniform(-0.5, 0.5) for _ in old.contact_states)
        assert (new.states, new.contact_states, new.channels) == (old.states, old.contact_states, old.channels)
        assert (new.cyclic, new.place or new.cyclic, dict(new.turns)) == (
            old.cyclic,
            old.place or old.cyclic,
            old.turns,
        )
        assert (new.symmetric, new.follows_load) == (old.symmetric, old.follows_load)
        assert dict(new.locked) == (old.locked if old.switches(t, y, drive, frictions) else {})
        if "touching" in old.states:
            two = getattr(old, "back_gap", 0.0) is not None and getattr(old, "restitution", 0.0) is not None
            y[-1] = draw.choice(
                [-1.0, 0.0, 1.0] if two else [0.0, 1.0] if getattr(old, "restitution", 0.0) is not None else [0.0]
            )
            y = at_stop(old, y, y[-1]) if old.locked and y[-1] else y
        at = t, tuple(y)
        for name, more in (
            *(("rates", (drive, frictions)), ("energy", ()), ("momentum", ()), ("powers", (drive, frictions))),
            *(("outer_force", (drive,)), ("wall_force", (drive, frictions))),
        ):
            compared(name, getattr(old, name)(*at, *more), getattr(new, name)(*at, *more))
        compared("switches", *(in_ways(m, m.switches(*at, drive, frictions), y) for m in (old, new)))
        compared("bounds", sorted(old.bounds(*at)), sorted(new.bounds(*at)))
        if old.follows_load:
            compared("vertical_momentum", old.vertical_momentum(*at), new.vertical_momentum(*at))
        compared("actuator", list(old.actuator(*at, frictions).values()), list(new.actuator(*at, frictions).values()))
        compared("loads", old.loads(), new.loads())
        compared("ground_speed", old.ground_speed(), new.ground_speed())
        compared(
            "room",
            *([x for _, pair in sorted(m.room().items()) for x in pair if abs(x) < math.inf] for m in (old, new)),
        )
        for which in range(len(old.switches(*at, drive, frictions))):
            struck = y
            if old.locked:
                if (which == 1) != bool(y[-1]):
                    continue
                struck = (
                    y
                    if which == 1
                    else [
                        *at_stop(old, y, 1 - which),
                    ]
                )
                if which != 1:  # it strikes at a speed
                    place, _ = old.locked["touching"]
                    struck = [v if name != place else s for name, v, s in zip(old.states, y, struck, strict=True)]
            compared("after_switch", *(m.after_switch(which, t, tuple(struck), drive, frictions) for m in (old, new)))
        for a, b in zip(old.contacts(*at, drive), new.contacts(*at, drive), strict=True):
            compared("velocity", a.velocity, b.velocity)
            compared("holding force", a.holding_force, b.holding_force)
            compared("acceleration", (a.acceleration, a.response), (b.acceleration, b.response))
            assert (a.reaction is None) == (b.reaction is None)
            if a.reaction is not None:
                compared("load", load(a.reaction, frictions), load(b.reaction, frictions))
        shown = old.mechanism(*at), new.mechanism(*at)
        assert (shown[0] is None) == (shown[1] is None)
        if shown[0] is not None:
            compared("mechanism", *map(mechanical, shown))
            assert [(b.name, b.joint, b.carrier, b.contact) for b in shown[0].bodies] == [
                (b.name, b.joint, b.carrier, b.contact) for b in shown[1].bodies
            ]
    assert {name: each for name, each in worst.items() if not each <= ROUNDING} == {}


def mechanical(mechanism):
    """The numbers of bodies and links."""
    bodies = [(b.mass, b.place, b.rate, b.stiffness, b.damping, b.actuation) for b in mechanism.bodies]
    return bodies, [(link.stiffness, link.damping, link.actuation) for link in mechanism.links]


@pytest.mark.parametrize("around", AROUND)
@pytest.mark.parametrize("by_hand", dict.fromkeys(kind for kind, _ in CASES), ids=lambda kind: kind.name)
def test_they_agree_on_slopes_behind_actuators_and_under_controllers(by_hand, around):
    draw, worst = random.Random(3), {}
    given = dict(AROUND[around])
    if around == "controller":
        given["controller"] = (vc.AnglePID if "angle" in by_hand.states else vc.PositionPID)(measured=by_hand.states[0])
    imposed, belt = by_hand.imposes_motion, "belt_speed" in {info.name for info in parameter_table(by_hand)}
    sloped = around.startswith("slope") and not by_hand().masses()
    if (imposed and "environment" not in given) or sloped or (belt and around == "slope"):
        pytest.skip("there is no such system")
    for _ in range(5):
        old, new = (vc.System(m, vc.LuGre(), vc.Harmonic(0.8, 1.1), **given) for m in pair(by_hand, {}, draw))
        y = tuple(draw.uniform(-0.15, 0.15) if name not in old.switched else 0.0 for name in old.state_names)
        a, b = old.flow(0.7, y, 1), new.flow(0.7, y, 1)
        for name in ("rates", "outer_force"):
            worst[name] = max(worst.get(name, 0.0), far(getattr(a, name), getattr(b, name)))
        worst["friction"] = max(
            worst.get("friction", 0.0),
            far([each.friction for each in a.contacts], [each.friction for each in b.contacts]),
        )
    assert {name: each for name, each in worst.items() if not each <= 10 * ROUNDING} == {}
