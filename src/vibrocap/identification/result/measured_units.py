"""Names and SI units of what was measured: of a contact that slides, or of one that turns."""

import dataclasses
import re


@dataclasses.dataclass(frozen=True)
class MeasuredUnits:
    """What the columns of a fit's records are called and measured in."""

    force_name: str
    force: str
    displacement_name: str
    displacement: str
    velocity_name: str
    velocity: str
    heading: str  # of the force in tables and JSON

    def of_parameter(self, unit: str) -> str:
        """The unit of a parameter of which `unit` is that in N, m and s: N s/m is N m s/rad where the contact turns."""
        if self is SLIDING:
            return unit
        return re.sub(r"kg|N|m", lambda found: {"kg": "kg m^2", "N": "N m", "m": "rad"}[found[0]], unit)


SLIDING = MeasuredUnits("force", "N", "displacement", "m", "velocity", "m/s", "N")
TURNING = MeasuredUnits("torque", "N m", "angle", "rad", "angular velocity", "rad/s", "Nm")


def measured_units(rotary: bool) -> MeasuredUnits:
    """Those of a contact that turns, or of one that slides."""
    return TURNING if rotary else SLIDING
