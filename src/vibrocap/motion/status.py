"""How a run ended, and what to try where it ended early."""

from vibrocap.results import Advised


class Status(Advised):
    """How a run ended; `text` says what to do where it could not be completed."""

    FINISHED = "finished", "The run went to its end."
    STEP_UNDERFLOW = (
        "step underflow",
        "The step became smaller than the spacing of numbers: the equations are singular here, or stiffer than the "
        "tolerance allows. Try a larger tolerance, or less extreme parameters.",
    )
    NOT_FINITE = (
        "not finite",
        "A state grew beyond all numbers. Check the parameters: a negative effective stiffness or an enormous drive "
        "lets the pendulum run away.",
    )
    TOO_MANY_EVENTS = (
        "too many events",
        "The contact changed between sticking and sliding more often than allowed in one period. Raise "
        "max_events_per_period if that is real; otherwise look at the motion so far.",
    )
    UNDECIDED_CONTACT = (
        "undecided contact",
        "At one instant neither sticking nor sliding to either side is consistent to rounding level (a degenerate "
        "contact). Perturb the initial state or a parameter slightly.",
    )
    TOO_MANY_STEPS = "too many steps", "The run needed more steps than allowed. Raise max_steps, or the tolerance."
    NOT_CERTIFIED = (
        "not certified",
        "The run went to its end, but its certificate says that it is not the motion of the equations (see "
        "certificate.failures). Try a smaller tolerance; if that does not help, please report the case.",
    )
    LIFT_OFF = (
        "lift off",
        "The ground would have to pull from here on: the machine lifts off, and its equations end. Drive it less, or "
        "make the body on the ground heavier.",
    )
    PARADOX = (
        "paradox",
        "Friction and normal load raise one another without end: here the equations of rigid bodies have no answer, "
        "or two (Painleve's paradox). A pendulum capsule is safe from it while the largest friction coefficient is "
        "below 2 sqrt(lambda (lambda + 1)), lambda its mass ratio.",
    )
    STOP_REACHED = (
        "stop reached",
        "The machine has reached a stop at which a run ends. Drive it less, or give the stop a coefficient of "
        "restitution where it takes one.",
    )
    AMBIGUOUS_CONTACTS = (
        "ambiguous contacts",
        "Which contacts rest is no longer certain: some forces would leave two ways to continue from here, or none, as "
        "friction and loads of the contacts raise one another (contact_modes lists the ways). Lower the friction "
        "coefficients, or keep the machine away from this shape.",
    )

    RUNAWAY = (
        "runaway",
        "What the controller measures has grown beyond a million natural sizes: the loop is unstable. Look at the "
        "signs of its gains, raise the gain on the rate, or lower that on the integral.",
    )
    SINGULAR_COMMAND = (
        "singular command",
        "No finite command gives the motion that is ordered from here on: the pendulum of a stroke lies. Let the "
        "reference stay within the reach of the machine, or start nearer to it.",
    )

    SINGULAR_PATH = (
        "singular path",
        "The path of a contact turns back here: its sliding velocity no longer tells how the coordinates of the "
        "machine move (see the last state). Drive it less, or end its way by a stop.",
    )

    SINGULAR_MASS_MATRIX = (
        "singular mass matrix",
        "Some motion of the machine moves no mass here (see the last state), so that no acceleration follows from the "
        "forces: a body has no mass, or a linkage reaches a dead point. Give what moves a mass or an inertia, or end "
        "its way by a stop; `vibrocap list KIND --check` looks for such places.",
    )

    @property
    def ok(self) -> bool:
        """Whether the run went to its end."""
        return self is Status.FINISHED

    @property
    def text(self) -> str:
        """What happened and what to try."""
        return self.advice
