from typing import Annotated, Any, ClassVar

from pydantic import Field

from vibrocap.physics.elementary import sqrt
from vibrocap.physics.machines.machine import Machine, NonNegative, Positive, parameter, parameters
from vibrocap.physics.mechanics.parts import Contact, Damper, Drive, Mass, Spring, Stop, coordinate
from vibrocap.physics.mechanics.pictures import Shape

NARROWEST, LOWEST = 0.3, 0.2  # distance at which the bodies meet, and height at which the mass lies on them
WIDEST = 2.0 * (1.0 - LOWEST * LOWEST) ** 0.5
Stance = Annotated[float, Field(strict=True, allow_inf_nan=False, gt=NARROWEST, lt=WIDEST)]


@parameters
class LinkageCrawler(Machine):
    """Two bodies, both rubbing, with an actuator between them; two rods of the length l, hinged, carry a mass m on top.

    Pushed apart, to the distance w = w_0 + z, the bodies let the mass down to the height h = sqrt(1 - w^2/4), drawn
    together they lift it: motion and loads of the contacts are coupled. Mass is counted in m, length in l, time in
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
    first_case: ClassVar = {"drive.amplitude": 1.0, "drive.frequency": 2.0}
    source: ClassVar[str] = "vibrocap"
    displacement = coordinate("z", "opening of the bodies", "m")
    position = coordinate("X", "place of body 1", "m")

    def parts(self, q):
        width = self.stance + q.displacement
        rear = Mass("body 1", self.mass_ratio, x=q.position)
        front = Mass("body 2", self.mass_ratio_2, x=q.position + width)
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
        (behind, _), (ahead, _), (middle, height) = self.evaluated("places", t, y)
        top, shapes = (middle, 0.1 + height), []
        for i, x in (1, behind), (2, ahead):
            shapes += [Shape("box", f"body {i}", ((x, 0.1),), (0.3, 0.2)), Shape("hinge", f"hinge {i}", ((x, 0.1),))]
            shapes.append(Shape("rod", f"rod {i}", ((x, 0.1), top)))
            shapes.append(Shape("contact", f"contact {i}", ((x, 0.0),), (0.27, 0.0)))
        spring = Shape("spring", "spring", ((behind + 0.15, 0.1), (ahead - 0.15, 0.1)))
        return *shapes, spring, Shape("disc", "mass", (top,), (0.25, 0.25))
