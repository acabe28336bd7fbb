"""What a kernel is made of: modules of `kernel/` in the order in which they use each other.

What no module of a recipe answers, `kernel/hook.py` does.
"""

import dataclasses

from vibrocap.numerics.kernel.memory_layout import Layout


@dataclasses.dataclass(frozen=True)
class Recipe:
    """Of what a kernel is made, besides generated code.

    entry: the function that is called from outside; primitives: names of `arithmetic.plain_vectors` that the compiler
    gives
    """

    entry: str
    modules: tuple[str, ...]
    primitives: tuple[str, ...] = ()


COMMON = ("arithmetic.roots", "events.transitions", "step.taylor", "step.stabilised", "step.resolved")
RECORDING, MEASURING = ("observe.record",), ("observe.accumulators", "observe.settle", "observe.window")
ALONE = ("arithmetic.one_number", "arithmetic.elementary_polynomials")
MOVING = ("events.contact", "loop.start", "loop.one_step")
SIMD = ("step.slow_manifold", "loop.side_by_side", "loop.simd_step")
LANE_PRIMITIVES = (
    *("align_stack", "all_lanes", "bits", "exponent", "floor", "load", "mantissa", "max", "min", "power_of_two"),
    *("square_root", "store", "where"),
)
SHOWING = ("observe.one_instant", "observe.instants")
DRIVEN = Recipe("follow", ("driven",))  # of a law under an imposed motion


def motion_recipe(layout: Layout) -> Recipe:
    """One motion, of which everything is recorded."""
    return Recipe(
        "advance", (*ALONE, *_before(layout, RECORDING, layout.corners, bool(layout.slow)), *MOVING, "loop.one_by_one")
    )


def shown_motion_recipe(layout: Layout) -> Recipe:
    """One motion in a browser, where it is also looked at: entries of `observe.instants` beside `advance`."""
    own = motion_recipe(layout)
    return Recipe(own.entry, (*own.modules, *SHOWING))


def stored_motion_recipe(stiff: bool) -> Recipe:
    """A stored motion that is looked at at many instants; stiff: whether implicit steps may have made its pieces."""
    point = ("step.linear_system",) if stiff else ()
    return Recipe("look_along", (ALONE[0], "arithmetic.roots", "step.taylor", *point, *SHOWING))


def stepper_recipe(layout: Layout, held_input: bool = False) -> Recipe:
    """One motion that its caller moves on; held_input: whether the drive is an input. See `loop/stepper.py`."""
    before = _before(layout, (), layout.corners and not held_input, bool(layout.slow))
    passage = "loop.held_input" if held_input else "loop.own_drive"
    own = (*ALONE, *before, *MOVING, "loop.one_by_one", passage, SHOWING[0], "loop.stepper")
    return Recipe("take_step", own)


def ensemble_recipe(layout: Layout, loop: str) -> Recipe:
    """Many motions, of which measures are kept.

    loop: "ensemble", one by one; "simd", all lanes at once; "portable", one by one with the elementary functions of
        the package, for targets without these; "browser", the same without what takes evidence
    """
    before = (
        *_before(layout, MEASURING, layout.corners, bool(layout.slow) and loop != "simd"),
        *(("observe.returns",) if layout.returns else ()),
        *(("observe.evidence",) if loop != "browser" else ()),
        *(("observe.load_watch",) if layout.watched else ()),
        *(("observe.extrapolation",) if layout.extrapolates else ()),
    )
    if loop == "simd":
        modules = (*before, "arithmetic.elementary_polynomials", *MOVING, *SIMD, "loop.run_queue")
        return Recipe("advance_ensemble", modules, LANE_PRIMITIVES)
    own = ALONE[:1] if loop == "ensemble" else ALONE
    return Recipe("advance_ensemble", (*own, *before, *MOVING, "loop.one_by_one", "loop.run_queue"))


def _before(layout: Layout, observer: tuple[str, ...], corners: bool, slow: bool) -> tuple[str, ...]:
    """The modules before those of the loop.

    corners: of the drive that the kernel follows; slow: whether all bristles may be on slow manifolds, so that no step
    need be implicit; of lanes side by side some are, beside implicit steps
    """
    steps = ("step.explicit",)
    if slow:
        steps = ("step.linear_system", "step.slow_manifold", "step.manifold_choice")
    elif layout.stiff and not layout.tangent:
        steps = ("step.linear_system", "step.implicit", "step.method_choice")
    return (
        *COMMON,
        *steps,
        *observer,
        *(("events.law_branches",) if layout.switches else ()),
        *(("events.decision",) if layout.several else ()),
        *(("events.corners",) if corners else ()),
        *(("events.tangents",) if layout.tangent else ()),
    )
