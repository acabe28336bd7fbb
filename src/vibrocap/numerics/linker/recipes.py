"""What a kernel is made of: modules of `kernel/` in the order in which they use each other, and the slots they fill."""

import dataclasses


@dataclasses.dataclass(frozen=True)
class Slot:
    """A place in a kernel that one of several modules fills.

    functions: of `kernel/interface.py`, which every one of the modules defines
    """

    name: str
    functions: tuple[str, ...]
    offers: tuple[str, ...]


STEP = Slot(
    "choice of step",
    ("chosen_step", "polished_step", "repeated_step", "shorter_step", "leave_implicit"),
    ("step.explicit", "step.method_choice"),
)
BRANCHES = Slot(
    "law branches",
    ("within_bounds", "branch_holds", "first_switch", "begin_branch", "turned", "guards_at", "interpolated_guards"),
    ("events.one_branch", "events.law_branches"),
)
DECISION = Slot("decision of contacts", ("decide_together",), ("events.one_contact", "events.decision"))
CORNERS = Slot(
    "corners of the drive",
    ("begin_drive", "at_corner", "begin_drive_period"),
    ("events.no_corners", "events.corners", "stepper.held_input"),
)
TANGENT = Slot(
    "tangent",
    ("tangent_waits", "leave_piece", "stay_in_piece", "enter_piece", "tangents_wait"),
    ("events.no_tangents", "events.tangents"),
)
OBSERVER = Slot(
    "observer",
    ("has_room", "on_piece", "on_event", "on_jump", "on_period"),
    ("observe.record", "observe.window", "stepper.event_counts"),
)
LOAD_WATCH = Slot("watch of the load", ("watch_load", "look_at_load"), ("observe.no_load_watch", "observe.load_watch"))
POINT_OF_LAW = Slot(
    "point of the law", ("fitting_point", "fit_to_slopes"), ("observe.taylor_point", "observe.stiff_point")
)
RETURNS = Slot(
    "returns",
    ("begin_returns", "quiet_since", "response_sought", "place_passed", "on_place", "on_return", "tell_returns"),
    ("observe.no_returns", "observe.returns"),
)
EXTRAPOLATION = Slot(
    "extrapolation",
    ("begin_marks", "note_event", "starts_trial", "trial_fails", "ends_trial"),
    ("observe.extrapolation", "observe.no_extrapolation"),
)
EVIDENCE = Slot("evidence", ("take_evidence",), ("observe.evidence", "observe.no_evidence"))
LOOP = Slot("loop over lanes", ("advance",), ("loop.one_by_one", "loop.simd_step"))
PASSAGE = Slot(
    "passage of a stepper",
    ("set_out", "under_way", "come_in", "keep_piece", "keep_event", "show_instant", "side_shown"),
    ("stepper.own_drive", "stepper.held_input"),
)
MOVED = (STEP, BRANCHES, DECISION, CORNERS, TANGENT, OBSERVER, RETURNS, EXTRAPOLATION, LOAD_WATCH, LOOP)
SHOWN = (*MOVED, POINT_OF_LAW)
MEASURED = (*SHOWN, EVIDENCE)
STEPPED = (*SHOWN, PASSAGE)


@dataclasses.dataclass(frozen=True)
class Recipe:
    """Of what a kernel is made, besides generated code.

    entry: the function that is called from outside; primitives: names of `arithmetic.plain_vectors` that the compiler
    gives; slots: those that modules have to fill
    """

    entry: str
    modules: tuple[str, ...]
    slots: tuple[Slot, ...] = MOVED
    primitives: tuple[str, ...] = ()


GATHERING = ("observe.turning_points", "observe.accumulators", "observe.stick_statistics")
COMMON = ("arithmetic.roots", "step.taylor", "step.stabilised", "step.resolved")
NO_WATCH, NO_RETURNS = ("observe.no_load_watch",), ("observe.no_returns",)
NO_EXTRAPOLATION = ("observe.no_extrapolation",)
UNSETTLED = (*NO_RETURNS, *NO_EXTRAPOLATION, *NO_WATCH)  # of a single motion
RECORDING, MEASURING = ("observe.record",), ("observe.settle", "observe.window")
ALONE = ("arithmetic.one_number", "arithmetic.elementary_polynomials")
MOVING = ("events.contact", "loop.one_step")
SIMD = (
    *("step.taylor_simd", "step.stabilised_simd", "step.resolved_simd", "step.slow_manifold"),
    *("loop.turning_simd", "loop.simd_step"),
)
LANE_PRIMITIVES = (
    *("align_stack", "bits", "exponent", "floor", "load", "mantissa", "power_of_two", "square_root", "store", "where"),
    *("whole_above", "whole_add", "whole_equal", "whole_reached", "whole_set"),
)
INSTANT = Recipe("instant", ALONE, slots=())  # the equations at an instant, alone
DRIVEN = Recipe("follow", ("driven",), slots=())  # of a law under an imposed motion


def motion_recipe(maybe_stiff: bool, branches: bool, corners: bool = False, several: bool = False) -> Recipe:
    """One motion, of which everything is recorded.

    branches: whether the law has several on each side of rest; corners: whether the drive has any
    several: contacts
    """
    before = _before(RECORDING, maybe_stiff, branches, corners, several, False)
    return Recipe("advance", (*before, *UNSETTLED, *ALONE, *MOVING, "loop.one_by_one"))


def shown_motion_recipe(maybe_stiff: bool, branches: bool, corners: bool = False, several: bool = False) -> Recipe:
    """One motion in a browser, where it is also looked at: entries of `observe.instants` beside `advance`."""
    own = motion_recipe(maybe_stiff, branches, corners, several)
    point = ("observe.turning_points", "observe.stiff_point") if maybe_stiff else ("observe.taylor_point",)
    return Recipe(own.entry, (*own.modules, *point, "observe.instants"), SHOWN)


def stepper_recipe(
    maybe_stiff: bool, branches: bool, corners: bool = False, several: bool = False, held_input: bool = False
) -> Recipe:
    """One motion that its caller moves on; held_input: whether the drive is an input. See `kernel/stepper`."""
    before = _before(("stepper.event_counts",), maybe_stiff, branches, corners, several, False)
    passage = ("stepper.own_drive",)
    if held_input:
        before = tuple(each for each in before if each not in CORNERS.offers)
        passage = ("stepper.held_input",)
    point = "observe.stiff_point" if maybe_stiff else "observe.taylor_point"
    own = ("observe.turning_points", point, "stepper.clock", *passage, "stepper.take_step")
    return Recipe("take_step", (*before, *UNSETTLED, *ALONE, *MOVING, "loop.one_by_one", *own), STEPPED)


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
) -> Recipe:
    """Many motions, of which measures are kept. tangent: whether each carries one along; watched: its true load.

    returns: whether returns tell that a motion has settled
    extrapolates: whether runs may go on from extrapolated limits of their marks
    loop: "ensemble", one by one; "simd", all lanes at once; "gpu", one by one on a thread of a GPU;
        "browser", one by one with the elementary functions of the package, as a browser has its own
    """
    point = "observe.stiff_point" if maybe_stiff else "observe.taylor_point"
    watch = ("observe.load_watch",) if watched else NO_WATCH
    evidence = "observe.no_evidence" if loop == "browser" else "observe.evidence"
    before = (
        *GATHERING,
        *_before(MEASURING, maybe_stiff, branches, corners, several, tangent),
        *(("observe.returns",) if returns else NO_RETURNS),
        point,
        evidence,
        *watch,
        *(("observe.extrapolation",) if extrapolates else NO_EXTRAPOLATION),
    )
    if loop == "simd":
        modules = (*before, "arithmetic.elementary_polynomials", *MOVING, *SIMD, "loop.run_queue")
        return Recipe("advance_ensemble", modules, MEASURED, LANE_PRIMITIVES)
    if loop == "gpu":
        modules = (*before, *ALONE, *MOVING, "loop.one_by_one", "loop.run_queue", "loop.gpu_thread")
        return Recipe("run_thread", modules, MEASURED, ("take", "whole_equal"))
    own = ALONE if loop == "browser" else ()
    return Recipe("advance_ensemble", (*before, *own, *MOVING, "loop.one_by_one", "loop.run_queue"), MEASURED)


def _before(
    observer: tuple[str, ...], maybe_stiff: bool, branches: bool, corners: bool, several: bool, tangent: bool
) -> tuple[str, ...]:
    """The modules before those of the loop."""
    return (
        *COMMON,
        *(("step.implicit", "step.method_choice") if maybe_stiff else ("step.explicit",)),
        *observer,
        "events.law_branches" if branches else "events.one_branch",
        "events.decision" if several else "events.one_contact",
        "events.corners" if corners else "events.no_corners",
        "events.tangents" if tangent else "events.no_tangents",
    )
