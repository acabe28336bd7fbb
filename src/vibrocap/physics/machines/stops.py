"""What machines with stops share: their optional parameters."""

from typing import Annotated, Any

from vibrocap.physics.mechanics.parts import Stop
from vibrocap.physics.parameters import MOST, allowed, parameter

BackGap = Annotated[Any, allowed("a number >= 0, or be left out where there is no stop behind", (None,), MOST)]
StopStiffness = Annotated[Any, allowed("a number >= 0, or be left out", (None,), MOST)]
StopDamping = Annotated[Any, allowed("a number >= 0, or be left out where the stop has no damper", (None,), MOST)]
BACK_GAP = parameter(None, "delta_b", "gap between mass and rear stop; none: no rear stop", "gap")


def behind(symbol: str, what: str, role: str) -> Any:
    """The spring or the damper of the stop behind, as a parameter."""
    return parameter(None, symbol, f"{what} of the stop behind; none where it is that of the one in front", role)


def elastic_stop(machine: Any, stretch: Any, **more: Any) -> Stop:
    """The elastic stops of a machine that has their parameters, see `Stop`."""
    return Stop(
        stretch,
        machine.gap,
        machine.back_gap,
        stiffness=machine.stop_stiffness,
        back_stiffness=machine.back_stop_stiffness,
        damping=machine.stop_damping,
        back_damping=machine.back_stop_damping,
        **more,
    )
