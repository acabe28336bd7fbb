from typing import ClassVar

from vibrocap.physics.machines.inner_mass import Load, WithInnerMass
from vibrocap.physics.machines.machine import Positive, parameter, parameters
from vibrocap.physics.mechanics.parts import Contact, Mass, coordinate


@parameters
class TwoMassCrawler(WithInnerMass):
    """Body M with an inner mass m whose motion along it the drive imposes; friction alone acts from outside.

    The drive is the displacement z(t) of the inner mass relative to the body. The state is p, the velocity of the
    common centre of mass, which continues where the relative velocity z' jumps; the body moves with

        X' = p - mu z',     (lambda + 1) p' = -R,     mu = m/(M + m) = 1/(lambda + 1)

    With z' piecewise constant or piecewise linear these are the two-phase and three-phase crawlers of Chernousko
    (2002), whose progress is known in closed form. At rest the contact holds R = -z'', in units of m.

    The energy is that of the common centre, (lambda + 1) p^2/2, and the work of the drive what reaches it. The energy
    of the relative motion, (1 - mu) z'^2/2, goes from the drive into the inner mass and back within each period. Both
    powers, and the force between the masses, are in `actuator_power` and `actuator_force`; where z' jumps by d that
    force has the impulse (1 - mu) d besides.

    Mass is counted in m, length and time in units of one's choice; the load is a force in those.
    """

    mass_ratio: Positive = parameter(
        1.0, "lambda", "mass of the body over inner mass, M/m", "mass", in_si="mass of the body"
    )
    normal_load: Load = parameter(
        1.0,
        "N",
        'load on the contact: a number, or "weight" (lambda + 1, in units of m g)',
        "load",
        in_si='load on the contact: a force, or "weight"',
    )

    name: ClassVar[str] = "two-mass-crawler"
    source: ClassVar[str] = "chernousko2002"
    effort: ClassVar = "displacement"
    si_names: ClassVar = {"mass_ratio": "body_mass"}
    si_load: ClassVar = '"weight" for that of body and inner mass, (M + m) g'

    position = coordinate("X", "place of the body", "m", rate="centre_velocity")

    def parts(self, q):
        body = Mass("body", self.mass_ratio, x=q.position)
        return [body, Mass("inner mass", 1.0, on=body, x=q.imposed(q.drive)), Contact(body, load=self.normal_load)]
