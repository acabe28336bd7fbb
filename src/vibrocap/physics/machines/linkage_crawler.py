from typing import Annotated, Any, ClassVar

from pydantic import Field

from vibrocap.physics.bodies import Shape
from vibrocap.physics.elementary import sqrt
from vibrocap.physics.machines.machine import Machine, NonNegative, Positive, parameter, parameters
from vibrocap.physics.mechanics.parts import Contact, Damper, Drive, Mass, Spring, Stop, coordinate

NARROWEST, LOWEST = 0.3, 0.2  # distance at which the bodies meet, and height at which the mass lies on them
WIDEST = 2.0 * (1.0 - LOWEST * LOWEST) ** 0.5
Stance = Annotated[float, Field(strict=True, allow_inf_nan=False, gt=NARROWEST, lt=WIDEST)]


@parameters
class LinkageCrawler(Machine):
    """Two bodies, both rubbing, with an actuator between them; two rods of the length l, hinged, carry a mass m on top.

    Pushed apart the bodies let the mass down, drawn together they lift it: motion and loads of the contacts are
    coupled. With w = w_0 + z the distance of the bodies, h = sqrt(1 - w^2/4) the height of the mass and c = (w/2)/h the
    slope of the rods from the vertical:

        (lambda_1 + 1/4 + c^2/4) v_1' + (1/4 - c^2/4) v_2' =   F + J - R_1
        (lambda_2 + 1/4 + c^2/4) v_2' + (1/4 - c^2/4) v_1' = - F - J - R_2
        F = rho z + nu z' - c/2 - drive,     J = c (1 + c^2)/(8 h) z'^2,     z' = v_2 - v_1
        N_1 = lambda_1 + [1 + h'' + (v_1' + v_2')/(2 c)]/2,     N_2 = lambda_2 + [1 + h'' - (v_1' + v_2')/(2 c)]/2

    from Lagrange's equations and the balance of forces at the mass. Mass is counted in m, length in l, time in
    sqrt(l/g); a positive drive pushes the bodies apart. Loads always follow the motion.

    A rod that is steeper than the cone of friction cannot slide its foot away, however hard it is pressed: friction and
    load raise one another there, and a run ends as "ambiguous contacts" (`contacts.py`). It also ends where the bodies
    meet, at w = 0.3, and where the mass comes down on them, at h = 0.2.
    """

    mass_ratio: Positive = parameter(
        1.0, "lambda_1", "mass of body 1, the rear one", "mass", over=", over the mass on top"
    )
    mass_ratio_2: Positive = parameter(1.0, "lambda_2", "mass of body 2", "mass", over=" over the mass on top")
    stiffness: Positive = parameter(2.0, "rho", "spring between the bodies", "stiffness", over=", k l/(m g)")
    damping: NonNegative = parameter(0.5, "nu", "damper between the bodies", "viscous damping", over=", c sqrt(l/g)/m")
    stance: Stance = parameter(1.2, "w_0", "distance of the bodies at which the spring is not stretched", "distance")

    name: ClassVar[str] = "linkage-crawler"
    source: ClassVar[str] = "vibrocap"
    displacement = coordinate("z", "opening of the bodies", "m")
    position = coordinate("X", "place of body 1", "m")
    normal_load: ClassVar = "dynamic"

    def parts(self, q):
        width = self.stance + q.displacement
        rear, front = (
            Mass("body 1", self.mass_ratio, x=q.position),
            Mass("body 2", self.mass_ratio_2, x=q.position + width),
        )
        lean = (front.height - rear.height) / width
        unit, half = 1.0 / sqrt(1.0 + lean * lean), 0.5 * width
        height = sqrt(1.0 - half * half * (1.0 + lean * lean))
        top = {"x": rear.along + half - lean * (unit * height), "z": 0.5 * (rear.height + front.height) + unit * height}
        joint = Spring(self.stiffness, q.displacement), Damper(self.damping, q.displacement), Drive(q.displacement)
        stop = Stop(q.displacement, WIDEST - self.stance, self.stance - NARROWEST, size=1.0)
        rubs = Contact(rear), Contact(front, speed="velocity_2")
        return [rear, front, Mass("mass", 1.0, **top), *joint, stop, *rubs]

    def scales(self, time=1.0):
        """Half of what the rods may open until they lie flat; else one."""
        return 1.0 - 0.5 * self.stance, 1.0, 1.0, 1.0

    def scene(self, t, y) -> Any:
        height = sqrt(1.0 - 0.25 * (self.stance + y[0]) * (self.stance + y[0]))
        behind, ahead = y[2], y[2] + self.stance + y[0]
        top = (0.5 * (behind + ahead), 0.1 + height)
        feet = (1, behind), (2, ahead)
        return (
            *(Shape("box", f"body {i}", ((x, 0.1),), (0.3, 0.2)) for i, x in feet),
            Shape("spring", "spring", ((behind + 0.15, 0.1), (ahead - 0.15, 0.1))),
            *(Shape("rod", f"rod {i}", ((x, 0.1), top)) for i, x in feet),
            *(Shape("hinge", f"hinge {i}", ((x, 0.1),)) for i, x in feet),
            Shape("disc", "mass", (top,), (0.25, 0.25)),
            *(Shape("contact", f"contact {i}", ((x, 0.0),), (0.27, 0.0)) for i, x in feet),
        )
