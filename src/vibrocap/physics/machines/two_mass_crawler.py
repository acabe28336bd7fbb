from typing import ClassVar

from vibrocap.physics.machines.inner_mass import Load, WithInnerMass, load
from vibrocap.physics.machines.machine import Positive, parameter, parameters
from vibrocap.physics.mechanics.parts import Contact, Mass, coordinate


@parameters
class TwoMassCrawler(WithInnerMass):
    """Body M with an inner mass m whose motion along it the drive imposes; friction alone acts from outside.

    The drive is the displacement z(t) of the inner mass in the body. The state is p, the velocity of the common centre
    of mass, which continues where z' jumps; the body moves with X' = p - mu z', mu = m/(M + m) = 1/(lambda + 1). With
    z' piecewise constant or linear these are the two-phase and three-phase crawlers of Chernousko (2002), whose
    progress is known in closed form. At rest the contact holds R = -z'', in units of m.

    The energy is that of the common centre, (lambda + 1) p^2/2, and the work of the drive is its gain; that of the
    relative motion, (1 - mu) z'^2/2, goes into the inner mass and back in each period. `actuator_power` has both,
    `actuator_force` is the force between the masses; where z' jumps by d it has the impulse (1 - mu) d besides.

    Mass is counted in m, length and time in units of one's choice; the load is a force in those.
    """

    mass_ratio: Positive = parameter(1.0, "lambda", "mass of the body", "mass", over=" over inner mass, M/m")
    normal_load: Load = load("")

    name: ClassVar[str] = "two-mass-crawler"
    source: ClassVar[str] = "chernousko2002"
    effort: ClassVar = "displacement"
    si_names: ClassVar = {"mass_ratio": "body_mass"}
    si_load: ClassVar = '"weight" for that of body and inner mass, (M + m) g'

    position = coordinate("X", "place of the body", "m", rate="centre_velocity")

    def parts(self, q):
        body = Mass("body", self.mass_ratio, x=q.position)
        return [body, Mass("inner mass", 1.0, on=body, x=q.imposed(q.drive)), Contact(body, load=self.normal_load)]
