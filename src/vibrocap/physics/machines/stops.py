"""What machines with stops share: their optional parameters, pictures."""

from typing import Annotated, Any

from pydantic import BeforeValidator

from vibrocap.physics.bodies import Shape
from vibrocap.physics.mechanics.parts import Stop


def _optional(wanted: str, high: float) -> BeforeValidator:
    """The check of a number from 0 to `high`, or None where it is left out; wanted: what is said of another value."""

    def checked(given: Any) -> Any:
        if given is None or (isinstance(given, (int, float)) and not isinstance(given, bool) and 0 <= given <= high):
            return None if given is None else float(given)
        raise ValueError(f"should be {wanted}")

    return BeforeValidator(checked)


MOST = 1e300  # of a number that is finite
BackGap = Annotated[Any, _optional("a number >= 0, or be left out where there is no stop behind", MOST)]
StopStiffness = Annotated[Any, _optional("a number >= 0, or be left out", MOST)]
StopDamping = Annotated[Any, _optional("a number >= 0, or be left out where the stop has no damper", MOST)]
EndOrRestitution = Annotated[
    Any, _optional("a number from 0 to 1, or be left out where a run is to end at the stop", 1.0)
]


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


def stop_shapes(x, gap, back_gap, half=0.15) -> tuple[Shape, ...]:
    """The stops about a place x; a mass of this half width touches them where it has gone its way."""
    behind = () if back_gap is None else (_stop("stop behind", x - back_gap - half),)
    return _stop("stop in front", x + gap + half), *behind


def _stop(name, x):
    return Shape("rod", name, ((x, 0.2), (x, 0.6)))
