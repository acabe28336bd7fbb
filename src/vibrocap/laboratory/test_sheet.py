"""The test sheet: all canonical tests of one law, with defaults that its own sizes give."""
# ruff: noqa: PT028 (a test of friction, not of code)

import dataclasses
from collections.abc import Callable, Sequence
from typing import Any

from vibrocap.laboratory.contact_sizes import ContactSizes, contact_sizes
from vibrocap.laboratory.driven import check_numbers
from vibrocap.laboratory.loops import Creep, FrictionalLag, PreslidingLoop, creep, frictional_lag, presliding_loop
from vibrocap.laboratory.pulled_block import BreakAway, StickSlipCycle, break_away, stick_slip_test
from vibrocap.physics.friction.law import Law
from vibrocap.physics.parameters import parameter_table

REACHES = (0.3, 0.8, 1.6, 3.2)  # amplitudes of the presliding loops, over the displacement of the contact
SOFT = 0.01  # stiffness of the spring over that of the contact
PULLED = 0.3  # pulling speed over the speed at which friction changes
CREEP_CYCLES = 1000


@dataclasses.dataclass(frozen=True, eq=False)
class TestSheet:
    """Results of all canonical tests of one law at one load, in the units of the law; see the functions of their names.

    presliding: loops of growing amplitude; mass, stiffness, speed: of the block, the spring and its pulled end
    """

    __test__ = False  # for pytest: this is no class of tests
    in_record = "law_name parameters load mass stiffness speed presliding lag break_away stick_slip creep"

    law: Law
    load: float
    sizes: ContactSizes
    mass: float
    stiffness: float
    speed: float
    presliding: tuple[PreslidingLoop, ...]
    lag: FrictionalLag
    break_away: BreakAway
    stick_slip: StickSlipCycle
    creep: Creep

    @property
    def law_name(self) -> str:
        return self.law.name

    @property
    def parameters(self) -> dict[str, Any]:
        """Of the law, by name."""
        return {info.name: getattr(self.law, info.name) for info in parameter_table(self.law)}


def test_sheet(
    law: Law,
    *,
    load: float = 1.0,
    mass: float | None = None,
    stiffness: float | None = None,
    speed: float | None = None,
    rates: Sequence[float] | None = None,
    progress: Callable[[str], None] | None = None,
) -> TestSheet:
    """All canonical tests of a law: presliding, frictional lag, break-away, stick-slip and creep.

    mass: of the block in the tests of break-away and stick-slip, by default F D/V^2, with the sizes F, D and V of the
        contact: one that the contact moves by D in about the time in which V does
    stiffness: of the spring in the test of stick-slip, by default a hundredth of the contact's, F/D
    speed: of its pulled end, by default 0.3 V      rates: of the break-away test
    progress: called with the name of each test before it begins

    Any units serve (`contact_sizes`). The first run for a law compiles it, which takes some seconds.
    """
    check_numbers(load=load)
    sizes = contact_sizes(law, load)
    mass = sizes.force * sizes.displacement / sizes.speed**2 if mass is None else mass
    stiffness = SOFT * sizes.stiffness if stiffness is None else stiffness
    speed = PULLED * sizes.speed if speed is None else speed
    tests: dict[str, Callable] = {
        "presliding": lambda: tuple(presliding_loop(law, reach * sizes.displacement, load=load) for reach in REACHES),
        "lag": lambda: frictional_lag(law, load=load),
        "break_away": lambda: break_away(law, rates, mass=mass, load=load),
        "stick_slip": lambda: stick_slip_test(law, stiffness, speed, mass=mass, load=load),
        "creep": lambda: creep(law, cycles=CREEP_CYCLES, load=load),
    }
    results = {}
    for name, run in tests.items():
        if progress is not None:
            progress(name.replace("_", " "))
        results[name] = run()
    return TestSheet(law, load, sizes, mass, stiffness, speed, **results)


test_sheet.__test__ = False  # type: ignore[attr-defined]
