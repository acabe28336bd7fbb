"""The linkage crawler: two bodies on the ground, and a mass that two rods carry above them."""

from typing import Annotated, Any, ClassVar

from pydantic import Field

from vibrocap.physics.machines.machine import (
    Contact,
    Machine,
    NonNegative,
    Positive,
    Shape,
    parameter,
    parameters,
    sqrt,
)

NARROWEST, LOWEST = 0.3, 0.2  # distance at which the bodies meet, and height at which the mass lies on them
WIDEST = 2.0 * (1.0 - LOWEST * LOWEST) ** 0.5
Stance = Annotated[float, Field(strict=True, allow_inf_nan=False, gt=NARROWEST, lt=WIDEST)]


@parameters
class LinkageCrawler(Machine):
    """Two bodies, both rubbing, with an actuator between them; two rods of the length l, hinged, carry a mass m on top.

    Pushed apart the bodies let the mass down, drawn together they lift it, so that what moves one of them moves the
    other, and presses on both: motion and loads of the contacts are coupled. With w = w_0 + z the distance of the
    bodies, c = (w/2)/h the slope of the rods from the vertical, h = sqrt(1 - w^2/4) the height of the mass:

        (lambda_1 + 1/4 + c^2/4) v_1' + (1/4 - c^2/4) v_2' =   F + J - R_1
        (lambda_2 + 1/4 + c^2/4) v_2' + (1/4 - c^2/4) v_1' = - F - J - R_2
        F = rho z + nu z' - c/2 - drive,     J = c (1 + c^2)/(8 h) z'^2,     z' = v_2 - v_1
        N_1 = lambda_1 + [1 + h'' + (v_1' + v_2')/(2 c)]/2,     N_2 = lambda_2 + [1 + h'' - (v_1' + v_2')/(2 c)]/2

    from Lagrange's equations and the balance of forces at the mass. Mass is counted in m, length in l, time in
    sqrt(l/g); a positive drive pushes the bodies apart. Loads follow the motion always.

    A rod that stands steeper than the cone of friction cannot slide its foot away, however hard it is pressed: there
    friction and load raise one another, and for some forces there are several ways to go on, or none. A run that comes
    there ends as "ambiguous contacts" (see `contacts.py`). It ends, too, where the bodies meet, at w = 0.3, and
    where the mass comes down on them, at h = 0.2.
    """

    mass_ratio: Positive = parameter(
        1.0,
        "lambda_1",
        "mass of body 1, the rear one, over the mass on top",
        "mass",
        in_si="mass of body 1, the rear one",
    )
    mass_ratio_2: Positive = parameter(
        1.0, "lambda_2", "mass of body 2 over the mass on top", "mass", in_si="mass of body 2"
    )
    stiffness: Positive = parameter(
        2.0, "rho", "spring between the bodies, k l/(m g)", "stiffness", in_si="spring between the bodies"
    )
    damping: NonNegative = parameter(
        0.5, "nu", "damper between the bodies, c sqrt(l/g)/m", "viscous damping", in_si="damper between the bodies"
    )
    stance: Stance = parameter(1.2, "w_0", "distance of the bodies at which the spring is not stretched", "distance")

    name: ClassVar[str] = "linkage-crawler"
    source: ClassVar[str] = "vibrocap"
    states: ClassVar = ("displacement", "velocity_2", "position", "velocity")
    cyclic: ClassVar = "position"
    contact_states: ClassVar = ("velocity", "velocity_2")
    symmetry: ClassVar = (1, -1, -1, -1)
    channels: ClassVar = ("drive", "damper")
    bound_kinds: ClassVar = ("stop_reached", "stop_reached")
    gravity: ClassVar = (1.0, 0.0)
    normal_load: ClassVar = "dynamic"

    @property
    def symmetric(self) -> bool:
        """Never: its mirror image has the bodies in the other order."""
        return False

    @property
    def follows_load(self) -> bool:
        """Always."""
        return True

    def scales(self, time=1.0):
        """Half of what the rods may open until they lie flat; else one."""
        return 1.0 - 0.5 * self.stance, 1.0, 1.0, 1.0

    def loads(self):
        """What each body carries at rest."""
        return (self.mass_ratio + 0.5) * self.gravity[0], (self.mass_ratio_2 + 0.5) * self.gravity[0]

    def masses(self):
        """Of body 1, and of all else."""
        return {"velocity": self.mass_ratio, "velocity_2": self.mass_ratio_2 + 1.0}

    def bounds(self, t, y) -> tuple:
        """The bodies meet, or the mass comes down on them."""
        width = self.stance + y[0]
        return width - NARROWEST, WIDEST - width

    def room(self):
        """Between these two."""
        return {"displacement": (NARROWEST - self.stance, WIDEST - self.stance)}

    def _shape(self, y) -> tuple:
        """(c, h, dc/dw)."""
        half = 0.5 * (self.stance + y[0])
        height = sqrt(1.0 - half * half)
        slope = half / height
        return slope, height, 0.5 * (1.0 + slope * slope) / height

    def _inertia(self, slope) -> tuple:
        """(M_11, M_12, M_22)."""
        square = 0.25 * slope * slope
        return self.mass_ratio + 0.25 + square, 0.25 - square, self.mass_ratio_2 + 0.25 + square

    def _pushes(self, y, drive) -> tuple:
        """Generalised forces on both bodies but friction; along a slope the weight of all but body 1."""
        slope, _, bend = self._shape(y)
        rate = y[1] - y[3]
        pull = self.stiffness * y[0] + self.damping * rate - drive
        pull = pull - 0.5 * slope * self.gravity[0] + 0.25 * slope * bend * (rate * rate)
        if self.level:
            return pull, -pull
        along = self.gravity[1]
        return pull - 0.5 * along, -pull - (self.mass_ratio_2 + 0.5) * along

    def contacts(self, t, y, drive):
        """v_i, a = M^-1 (pushes - R), and the loads above."""
        own, other = self._pushes(y, drive)
        slope, _, bend = self._shape(y)
        inertia, shared, further = self._inertia(slope)
        over = 1.0 / (inertia * further - shared * shared)
        response = ((further * over, -shared * over), (-shared * over, inertia * over))
        free = tuple(row[0] * own + row[1] * other for row in response)
        rate, (normal, along) = y[1] - y[3], self.gravity
        lift = 0.5 * normal - 0.25 * bend * (rate * rate)
        steep = 1.0 / slope
        # N_i = weight + lift + (by_1, by_2) . a, of the mass on top with what holds it on a slope
        by = ((0.25 * (slope + steep), 0.25 * (steep - slope)), (0.25 * (slope - steep), -0.25 * (slope + steep)))
        found = []
        for i, (side, mass, row) in enumerate(zip((1.0, -1.0), (self.mass_ratio, self.mass_ratio_2), by, strict=True)):
            load = mass * normal + lift + side * (0.5 * along) * steep + row[0] * free[0] + row[1] * free[1]
            raised = (-(row[0] * response[0][k] + row[1] * response[1][k]) for k in (0, 1))
            reaction = (1.0, load, *raised)
            found.append(Contact((y[3], y[1])[i], acceleration=free[i], response=response[i], reaction=reaction))
        return tuple(found)

    def rates(self, t, y, drive, frictions):
        """y' = (z', v_2', X', v_1')."""
        (own, other), (force, other_force) = self._pushes(y, drive), frictions
        inertia, shared, further = self._inertia(self._shape(y)[0])
        over = 1.0 / (inertia * further - shared * shared)
        first = (own - shared / further * (other - other_force) - force) * (further * over)
        second = (other - shared / inertia * (own - force) - other_force) * (inertia * over)
        return y[1] - y[3], second, y[3], first

    def energy(self, t, y):
        """H = sum of lambda_i v_i^2/2, of the mass on top, its height, and of the spring."""
        slope, height, _ = self._shape(y)
        inertia, shared, further = self._inertia(slope)
        kinetic = 0.5 * inertia * y[3] * y[3] + shared * y[3] * y[1] + 0.5 * further * y[1] * y[1]
        return kinetic + height * self.gravity[0] + 0.5 * self.stiffness * y[0] * y[0]

    def momentum(self, t, y):
        """p = lambda_1 v_1 + lambda_2 v_2 + (v_1 + v_2)/2; its rate is minus the sum of the friction forces."""
        return (self.mass_ratio + 0.5) * y[3] + (self.mass_ratio_2 + 0.5) * y[1]

    def powers(self, t, y, drive, frictions):
        """Power of the drive, drive z', and of the damper, -nu z'^2."""
        rate = y[1] - y[3]
        return drive * rate, -self.damping * rate * rate

    def scene(self, t, y) -> Any:
        """Two blocks, two rods, a disc and a spring."""
        _, height, _ = self._shape(y)
        behind, ahead = y[2], y[2] + self.stance + y[0]
        top = (0.5 * (behind + ahead), 0.1 + height)
        return (
            Shape("box", "body 1", ((behind, 0.1),), (0.3, 0.2)),
            Shape("box", "body 2", ((ahead, 0.1),), (0.3, 0.2)),
            Shape("spring", "spring", ((behind + 0.15, 0.1), (ahead - 0.15, 0.1))),
            Shape("rod", "rod 1", ((behind, 0.1), top)),
            Shape("rod", "rod 2", ((ahead, 0.1), top)),
            Shape("hinge", "hinge 1", ((behind, 0.1),)),
            Shape("hinge", "hinge 2", ((ahead, 0.1),)),
            Shape("disc", "mass", (top,), (0.25, 0.25)),
            Shape("contact", "contact 1", ((behind, 0.0),), (0.27, 0.0)),
            Shape("contact", "contact 2", ((ahead, 0.0),), (0.27, 0.0)),
        )
