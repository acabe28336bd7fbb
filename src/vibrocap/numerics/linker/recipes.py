"""What a kernel is made of: modules of `kernel/` in the order in which they use each other.

What no module of a recipe answers, `kernel/interface.py` does.
"""

import dataclasses


@dataclasses.dataclass(frozen=True)
class Recipe:
    """Of what a kernel is made, besides generated code.

    entry: the function that is called from outside; primitives: names of `arithmetic.plain_vectors` that the compiler
    gives
    """

    entry: str
    modules: tuple[str, ...]
    primitives: tuple[str, ...] = ()


GATHERING = ("observe.accumulators", "observe.stick_statistics")
TURNING = ("observe.turning_points",)
POINT = TURNING, (*TURNING, "observe.stiff_point")  # where a law is asked: of laws that are never stiff, and of others
COMMON = ("arithmetic.roots", "step.taylor", "step.stabilised", "step.resolved")
RECORDING, MEASURING = ("observe.record",), ("observe.limit_of_marks", "observe.settle", "observe.window")
ALONE = ("arithmetic.one_number", "arithmetic.elementary_polynomials")
MOVING = ("events.contact", "loop.start", "loop.one_step")
SIMD = ("step.side_by_side", "step.slow_manifold", "loop.turning_simd", "loop.first_events", "loop.simd_step")
LANE_PRIMITIVES = (
    *("align_stack", "all_lanes", "bits", "exponent", "floor", "load", "mantissa", "max", "min", "power_of_two"),
    *("square_root", "store", "where", "whole_above", "whole_add", "whole_equal", "whole_reached", "whole_set"),
)
DRIVEN = Recipe("follow", ("driven",))  # of a law under an imposed motion


def motion_recipe(
    maybe_stiff: bool, branches: bool, corners: bool = False, several: bool = False, slow: bool = False
) -> Recipe:
    """One motion, of which everything is recorded.

    branches: whether the law has several on each side of rest; corners: whether the drive has any
    several: contacts; slow: whether all bristles may be on slow manifolds, so that no step need be implicit
    """
    before = _before(RECORDING, maybe_stiff, branches, corners, several, False, slow)
    return Recipe("advance", (*ALONE, *before, *MOVING, "loop.one_by_one"))


def shown_motion_recipe(
    maybe_stiff: bool, branches: bool, corners: bool = False, several: bool = False, slow: bool = False
) -> Recipe:
    """One motion in a browser, where it is also looked at: entries of `observe.instants` beside `advance`."""
    own = motion_recipe(maybe_stiff, branches, corners, several, slow)
    return Recipe(own.entry, (*own.modules, *POINT[maybe_stiff], "observe.drive_table", "observe.instants"))


def stepper_recipe(
    maybe_stiff: bool,
    branches: bool,
    corners: bool = False,
    several: bool = False,
    held_input: bool = False,
    slow: bool = False,
) -> Recipe:
    """One motion that its caller moves on; held_input: whether the drive is an input. See `kernel/stepper`."""
    before = _before(("stepper.event_counts",), maybe_stiff, branches, corners and not held_input, several, False, slow)
    passage = "stepper.held_input" if held_input else "stepper.own_drive"
    own = (*POINT[maybe_stiff], "stepper.clock", passage, "observe.drive_table", "stepper.take_step")
    return Recipe("take_step", (*ALONE, *before, *MOVING, "loop.one_by_one", *own))


def ensemble_recipe(
    loop: str,
    maybe_stiff: bool,
    branches: bool,
    corners: bool = False,
    several: bool = False,
    tangent: bool = False,
    watched: bool = False,
    returns: bool = False,
    extrapolates: bool = False,
    slow: bool = False,
) -> Recipe:
    """Many motions, of which measures are kept. tangent: whether each carries one along; watched: its true load.

    returns: whether returns tell that a motion has settled
    extrapolates: whether runs may go on from extrapolated limits of their marks
    slow: whether all bristles may be on slow manifolds; of lanes side by side some, beside implicit steps
    loop: "ensemble", one by one; "simd", all lanes at once; "gpu", one by one on a thread of a GPU;
        "browser", one by one with the elementary functions of the package, as a browser has its own
    """
    before = (
        *GATHERING,
        *_before(MEASURING, maybe_stiff, branches, corners, several, tangent, slow and loop != "simd"),
        *(("observe.returns",) if returns else ()),
        *POINT[maybe_stiff],
        *(("observe.evidence",) if loop != "browser" else ()),
        *(("observe.load_watch",) if watched else ()),
        *(("observe.extrapolation",) if extrapolates else ()),
    )
    if loop == "simd":
        modules = (*before, "arithmetic.elementary_polynomials", *MOVING, *SIMD, "loop.run_queue")
        return Recipe("advance_ensemble", modules, LANE_PRIMITIVES)
    if loop == "gpu":
        modules = (*ALONE, *before, *MOVING, "loop.one_by_one", "loop.run_queue", "loop.gpu_thread")
        return Recipe("run_thread", modules, ("take", "in_all_threads", "whole_equal"))
    own = ALONE if loop == "browser" else ALONE[:1]
    return Recipe("advance_ensemble", (*own, *before, *MOVING, "loop.one_by_one", "loop.run_queue"))


def _before(
    observer: tuple[str, ...],
    maybe_stiff: bool,
    branches: bool,
    corners: bool,
    several: bool,
    tangent: bool,
    slow: bool = False,
) -> tuple[str, ...]:
    """The modules before those of the loop."""
    steps = ("step.explicit",)
    if slow:
        steps = ("step.linear_system", "step.slow_manifold", "step.manifold_choice")
    elif maybe_stiff:
        steps = ("step.linear_system", "step.implicit", "step.method_choice")
    return (
        *COMMON,
        *steps,
        *observer,
        *(("events.law_branches",) if branches else ()),
        *(("events.tried_mode", "events.decision") if several else ()),
        *(("events.corners",) if corners else ()),
        *(("events.tangents",) if tangent else ()),
    )
