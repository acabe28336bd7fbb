"""Writes the generated part of a kernel: series, rates and Jacobian of one system's equations, as Python source.

Series are those of all lanes or of a motion alone.
"""

import dataclasses
import math
from collections.abc import Sequence

from vibrocap.numerics.codegen.guard_polynomial import guard_source
from vibrocap.numerics.codegen.jets import JetWriter, shortest
from vibrocap.numerics.codegen.resolution import resolution_source, system_sharpness
from vibrocap.numerics.codegen.slow_manifold import (
    SlowWriter,
    bounding_decays,
    store_reach,
)
from vibrocap.numerics.codegen.straight_line import (
    ADDING,
    CALLING,
    ZERO,
    Code,
    Formula,
    ScalarWriter,
    branch_source,
    function_source,
    indented,
    literal,
    returned_source,
    stored_source,
)
from vibrocap.numerics.expressions.equations import DecisionRows, Equations
from vibrocap.numerics.expressions.graph import Expression, derivative, reachable
from vibrocap.numerics.expressions.structure import (
    Forms,
    decay_rates,
    gaps,
    no_series_at_rest,
    place_of_returns,
    record_slopes,
)
from vibrocap.numerics.kernel.memory_layout import Layout


def generated_source(equations: Equations, layout: Layout, loop: str = "single") -> str:
    """Source of all that `kernel/generated.py` promises, for these equations and a loop of `linker.py`."""
    functions = [
        constants_source(equations, layout),
        jet_source(equations, layout, loop),
        rates_source(equations),
        holding_source(equations),
        *([] if equations.rows is None else [decision_source(equations.rows)]),
        branches_source(equations),
        jacobian_source(equations),
        resolution_source(equations, layout.order, polynomials=loop != "ensemble"),
    ]
    return "\n".join([*functions, ""])


def stored_motion_source(equations: Equations, layout: Layout) -> str:
    """What is wanted of them where a stored motion is looked at: no series."""
    observed = (*equations.observables.values(), *equations.integrals)
    instants = instants_source(equations, observed, with_table=False)
    jacobian = [jacobian_source(equations)] if equations.maybe_stiff else []
    return "\n".join([constants_source(equations, layout), rates_source(equations), *jacobian, instants])


def constants_source(equations: Equations, layout: Layout) -> str:
    """Places and sizes of the memory, and what is known of the equations."""
    if equations.maybe_stiff:
        record_slopes(equations)
    series = layout.places["SERIES"]
    row_size = (layout.order + 1) * layout.lanes
    forms = Forms(equations.graph, equations.rates)
    constants = {
        **layout.constants(),
        "RATE_ROWS": layout.rates or (-1,) * layout.states,
        "WHOLE_ROWS": layout.whole_rows,
        "WHOLE_COUNT": len(layout.whole_rows),
        "MAYBE_STIFF": equations.maybe_stiff,
        "SEVERAL": equations.several,
        "STICKS": tuple(int(contact.sticks) for contact in equations.contacts),
        "KINKS": tuple(int(contact.kind == "kinked") for contact in equations.contacts),
        "STATE_OF": tuple(contact.state for contact in equations.contacts),
        "SHARED": len({contact.state for contact in equations.contacts}) < len(equations.contacts),
        "BASE": equations.base,
        "CYCLIC": equations.cyclic_state,
        "TURN_COUNT": len(equations.turns),
        "TURN_STATES": tuple(state for state, _ in equations.turns) or (-1,),
        "TURN_RADII": tuple(period / (2.0 * math.pi) for _, period in equations.turns) or (1.0,),
        **place_of_returns(equations),
        "RETURNING": layout.returns,
        "BRANCHES": len(equations.switches),
        "LAW_BRANCHES": equations.law_switches,
        "LOCATED": (*(1 for _ in equations.switches), *map(int, equations.located)) or (0,),
        "POLISHED": tuple(int(not forms.affine(guard.index)) for guard in equations.switches) or (0,),
        "BOUND_KINDS": equations.bound_kinds or (0,),
        "IMPACT": equations.impact,
        "LIMIT_CONSTANT": limits_are_constant(equations),
    }
    constants["GUARD"] = series + layout.states * row_size
    constants["SWITCH"] = constants["GUARD"] + row_size
    imposed = constants["SWITCH"] + layout.switches * row_size
    constants["SHIFT"] = imposed + layout.imposed * row_size
    held = constants["SHIFT"] + layout.shifts * row_size
    constants["REACTION"] = held + 2 * layout.held * row_size
    velocities, holds, limits = [], [], []
    for contact in equations.contacts:
        velocities.append(series + contact.state * row_size if contact.is_state else imposed)
        imposed += 0 if contact.is_state else row_size
        holds.append(held)
        limits.append(held + row_size)
        held += 2 * row_size if contact.sticks else 0
    constants |= {"VELOCITY_OF": tuple(velocities), "STICKING_FORCE_OF": tuple(holds), "LIMIT_OF": tuple(limits)}
    if not layout.coefficients:
        constants["UNTIL"] = constants["PERIOD"]
    constants |= {"VELOCITY_JUMPS": jumps(equations, layout), "FOLLOWS_LOAD": bool(equations.loads)}
    sharp, number = system_sharpness(equations)
    constants |= {"SHARP": bool(sharp.nodes), "SHARP_INTERNAL": sharp.internal, "SHARP_CONTACT": number}
    powers = [m for _, m in gaps(equations, sharp.nodes).values()]
    constants["LACUNARY"] = bool(powers) or (equations.several and bool(sharp.nodes))
    rough = (own.sticks and no_series_at_rest(own.velocity, equations.rates) for own in equations.contacts)
    constants["ROUGH"] = tuple(map(int, rough))
    constants["GAPS"] = max(powers, default=0) > 2
    if equations.guards and "OCCURRED" not in constants:
        constants["OCCURRED"] = -1
    slow = layout.slow or ((0, -1),)
    constants |= {"SLOWED": bool(layout.slow), "MANIFOLDS": len(slow), "PAIR": layout.pair}
    constants |= {"SLOW_CONTACT": tuple(contact for contact, _ in slow), "SLOW_STATE": tuple(own for _, own in slow)}
    constants |= {"WATCHED": layout.watched, "LIFTED": constants.get("LIFTED", -1)}
    return "\n".join([*(f"{name} = {value!r}" for name, value in constants.items()), ""])


def jumps(equations: Equations, layout: Layout) -> bool:
    """Whether the contact velocity depends on what changes at the corners of the drive."""
    graph = equations.graph
    needed = (graph.nodes[i] for i in reachable(graph, [contact.velocity.index for contact in equations.contacts]))
    numbers = [operands[0] for op, *operands in needed if op == "parameter"]
    return bool(layout.coefficients) and any(number >= layout.present for number in numbers)


def rates_source(equations: Equations) -> str:
    """`rates`, `contact_velocity`, `shifts` and, of loads that are watched, `reaction` of one lane."""
    graph = equations.graph
    lines = [stored_source("rates", graph, equations.rates)]
    if equations.true_loads:
        lines.append(_one_of("reaction(floats, t, point, which, lane)", "which", tuple(equations.true_loads.values())))
    velocities = [contact.velocity for contact in equations.contacts]
    lines.append(_one_of("contact_velocity(floats, t, point, contact, lane)", "contact", velocities))
    slopes = [(shift, derivative(shift, -1)) for shift in equations.shifts]
    values = [value for shift, slope in slopes for value in (shift, slope, derivative(slope, -1))]
    return "\n".join([*lines, stored_source("shifts", graph, values, "lane")])


def _one_of(head: str, number: str, values: Sequence[Expression]) -> str:
    """The source of a function of one lane that returns the value of a number."""
    lines = []
    for i, value in reversed(list(enumerate(values))):
        writer = ScalarWriter(value.graph)
        result = writer.name(value)
        own = [*writer.lines, f"return {result}"]
        lines += [f"if {number} == {i}:", *indented(own)] if i else own
    return function_source(head, lines)


def holding_source(equations: Equations, name: str = "holding", before: Sequence[Expression] = ()) -> str:
    """`holding` of one lane: of each contact the force that holds it over the middle, and its limit; 0 where it cannot
    rest. Or `evidence`: what `kernel/observe/evidence.py` asks, the rates before them."""
    zero = equations.graph.constant(0.0)
    asked = (value for contact in equations.contacts for value in (contact.hold, contact.limit))
    return stored_source(name, equations.graph, [*before, *(zero if value is None else value for value in asked)])


def decision_source(rows: DecisionRows) -> str:
    """`contact_rows` of one lane with several contacts, see `kernel/events/decision.py`."""
    graph, n = rows.b[0].graph, len(rows.b)
    zero = graph.constant(0.0)
    values = [*rows.b, *(entry for row in rows.response for entry in row)]
    values += rows.loads or [graph.constant(1.0)] * n
    for i in range(n):
        values += [rows.forces[i], *rows.pushes[i], *(rows.bounds[i] or (zero,) * 4)]
    values += [entry for row in rows.load_response for entry in row]
    constants = {"DYNAMIC": bool(rows.loads), "GROUP": rows.groups}
    lines = [f"{name} = {value!r}" for name, value in constants.items()]
    return "\n".join([*lines, "", stored_source("contact_rows", graph, values)])


def branches_source(equations: Equations) -> str:
    """`guard_tangents` with a tangent; `switches`, `after_switch`, `after_reversal` for a law of several pieces."""
    graph, lines = equations.graph, []
    if equations.guard_tangents:
        lines.append(stored_source("guard_tangents", graph, equations.guard_tangents))
    if equations.guards or equations.maybe_stiff:  # implicit steps know them
        lines.append(stored_source("switches", graph, equations.guards))
    if equations.guards:
        energy = equations.observables["energy"]
        lines.append(returned_source("machine_energy(floats, t, point, lane)", graph, energy))
        after = [ScalarWriter(graph).stores(outcome) for outcome in equations.after_switch]
        lines.append(branch_source("after_switch(floats, t, point, lane, which, out)", "which", after))
        turned = [ScalarWriter(graph).stores(contact.after_reversal) for contact in equations.contacts]
        head = "after_reversal(floats, t, point, lane, contact, out)"
        lines.append(branch_source(head, "contact", turned) if equations.several else function_source(head, turned[0]))
    return "\n".join(lines)


def jacobian_source(equations: Equations) -> str:
    """`jacobian` of one lane, exact."""
    states = range(len(equations.rates))
    slopes = [derivative(rate, state) for rate in equations.rates for state in (*states, -1)]
    return stored_source("jacobian", equations.graph, slopes)


@dataclasses.dataclass(frozen=True)
class Integrands:
    """The functions of the instant that an ensemble gathers: their source, and how many are summed and sought."""

    text: str
    summed: int
    own_extremes: int


def integrands_source(
    equations: Equations, own_integrals: Sequence[Expression] = (), own_extremes: Sequence[Expression] = ()
) -> Integrands:
    """`integrands` of one lane, with functions of one's own besides the standard ones.

    Those are recorded on the graph of the equations.
    """
    own = (*own_integrals, *own_extremes)
    writer = ScalarWriter(own[0].graph if own else equations.graph)
    values = [writer.name(power) for power in equations.powers]
    for contact in equations.contacts:
        friction = writer.name(contact.friction)
        # The last one is added to the acceleration of the piece, times friction, see `accumulators.look`.
        ahead = derivative(contact.velocity, -1)
        for i, rate in enumerate(equations.rates):
            ahead = ahead + (derivative(contact.velocity, i) * rate if i != contact.state else 0.0)
        values += [friction, f"{friction} * {writer.name(contact.velocity)}", writer.name(ahead)]
    values += [writer.name(function) for function in own]
    summed = len(values) - len(own_extremes)
    constants = {"INTEGRANDS": len(values), "SUMMED": summed, "FRICTION": len(equations.powers)}
    lines = [f"{name} = {value!r}" for name, value in (constants | {"MIRROR": tuple(equations.symmetry)}).items()]
    body = [*writer.lines, *(f"floats[out + {i}] = {value}" for i, value in enumerate(values))]
    text = "\n".join([*lines, "", "def integrands(floats, t, point, lane, out):", *indented(body), ""])
    return Integrands(text, summed, len(own_extremes))


def instants_source(
    equations: Equations, observed: Sequence[Expression], room: Sequence[Expression] = (), with_table: bool = True
) -> str:
    """`observables`, `beginning` and `drive_table` of one lane, for whoever looks at a motion as it runs.

    observed: may be recorded on a graph that begins with the nodes of the equations
    room: between which values some states may begin, on such a graph too
    with_table: whether the segments of the drive are wanted, where it has corners
    """
    corners = equations.corners if with_table else None
    table = () if corners is None else corners.numbers  # recorded on a graph of their own
    begun = (*room, *equations.scales, equations.period)
    lines = [f"OBSERVABLES = {len(observed)}", f"ROOM = {len(room)}", f"TABLE_NUMBERS = {len(table)}", ""]
    for name, values in (("observables", observed), ("beginning", begun), ("drive_table", table)):
        lines.append(stored_source(name, values[0].graph if values else equations.graph, values))
    return "\n".join(lines)


TAIL = 4.0  # times the last term of a load: a bound of it and all that follow, each at most 3/4 of the one before
NO_MANIFOLD = ["def slow_jet(floats, lane):", '    """There is none."""']


def jet_source(equations: Equations, layout: Layout, loop: str) -> str:
    """`jet`: Taylor coefficients of states, contact velocity and guards for all lanes.

    `slow_jet`: the same on a slow manifold, of a motion alone or of all lanes that are on one
    """
    if loop == "simd":
        sticks = any(contact.sticks for contact in equations.contacts)
        switched, constant = bool(equations.switches), limits_are_constant(equations)
        guard = guard_source(layout.order, sticks, constant, equations.several, switched)
        slow = range(len(layout.slow))
        body = _series(equations, layout, loop, slow if equations.several else ())
        one = ["def jet(floats):", "    align_stack()", "    lane = all_lanes()", *indented(body), ""]
        other = NO_MANIFOLD
        if layout.slow and not equations.several:
            other = ["def slow_jet(floats, lane):", "    align_stack()", "    slow = floats[SLOW + lane] > 0.0"]
            other += indented(_series(equations, layout, loop, slow))
        return "\n".join([*one, *other, "", guard])
    head = ["def jet(floats):", "    for lane in range(LANES):"]
    lines = [*head, *indented(_series(equations, layout, loop, ()), 8), ""]
    calls = []
    if equations.several and layout.slow:  # of which any may be on theirs, as lanes
        body = _series(equations, layout, loop, range(len(layout.slow)))
        return "\n".join([*lines, "def slow_jet(floats, lane):", *indented(body), ""])
    if layout.pair:
        body = _series(equations, layout, loop, (0, 1))
        lines += ["def slow_jet_pair(floats, lane):", *indented(body), ""]
        calls += ["    if floats[SLOW + lane] > 0.0 and floats[SLOW + LANES + lane] > 0.0:"]
        calls += ["        slow_jet_pair(floats, lane)", "        return"]
    for number in range(len(layout.slow)):
        body = _series(equations, layout, loop, (number,))
        lines += [f"def slow_jet_{number}(floats, lane):", *indented(body), ""]
        calls += [f"    if floats[SLOW + {number} * LANES + lane] > 0.0:", f"        slow_jet_{number}(floats, lane)"]
    return "\n".join([*lines, *(["def slow_jet(floats, lane):", *calls] if calls else NO_MANIFOLD), ""])


def _series(equations: Equations, layout: Layout, loop: str, slow: Sequence[int]) -> list[str]:
    """Lines of the series; slow: numbers of the manifolds on which lanes may be."""
    order = layout.order
    # All lanes share few registers, so that what is read is read late.
    simd = loop == "simd"
    lanes = "slow" if simd and slow and not equations.several else ""
    code = Code(CALLING + ADDING if simd else 0, polynomials=loop != "ensemble", lanes=lanes)
    if slow:
        writer = SlowWriter(equations, layout, code, slow)
    else:
        writer = JetWriter(equations.graph, list(equations.rates), code, shortest(equations))
    loads = [equations.by_momenta(load) for load in equations.true_loads.values()] if layout.watched else []
    writer.needed.update(reachable(equations.graph, [load.index for load in loads]))
    states = layout.states
    code.name("time", code.entry("TIME"))
    for i in range(layout.contacts):
        code.name(f"sliding_{i}", code.entry(f"SIDE + {i} * LANES"))
    imposed_from = states + 1 + layout.switches
    shifts_from = imposed_from + layout.imposed
    held_from = shifts_from + layout.shifts
    located = (*(True for _ in equations.switches), *equations.located)  # of the guards: those that need a series

    def keep(row: int, k: int, value: Formula) -> None:
        """Write a coefficient to its place in the series at once: values wait in registers, of which there are few."""
        code.store(f"SERIES + {row * (order + 1) + k} * LANES", value)

    for k in range(order + 1):
        for i in range(states):
            keep(i, k, writer.settled(i, k))
        for i, contact in enumerate(equations.imposed, start=imposed_from):
            keep(i, k, writer.settled(contact.state, k, contact.velocity))
        for i, shift in enumerate(equations.shifts[: layout.shifts], start=shifts_from):
            keep(i, k, writer.coefficient(shift.index, k))
        if k < order:
            for i, value in enumerate(equations.holding, start=held_from):
                keep(i, k, writer.coefficient(value.index, k))
        for i, load in enumerate(loads if k >= 2 else (), start=held_from + 2 * layout.held):
            value = writer.coefficient(load.index, k - 2)  # known with the coefficients k of the states
            keep(i, k - 2, value * literal(TAIL) if k == order else value)
        if k == 1 and equations.maybe_stiff:
            first, *others = bounding_decays(equations, layout, writer, decay_rates(equations))
            decay = code.name("decay", first)
            for i, other in enumerate(others):
                decay = code.larger(f"decay_{i}", other, decay)
            code.store("DECAY_RATE", decay)
            store_reach(writer)
        for i, guard in enumerate(equations.guards):
            moves = k == 0 or (located[i] and k < order + (equations.law_switches <= i < len(equations.switches)))
            slope = k == order and bool(equations.loads) and i == len(equations.switches)  # see `law_branches.py`
            if moves or slope or (located[i] and k == order):
                keep(states + 1 + i, k, writer.coefficient(guard.index, 1 if slope else k) if moves or slope else ZERO)
    return code.lines


def limits_are_constant(equations: Equations) -> bool:
    """Whether no contact's limit ever changes along a motion."""
    limits = [contact.limit for contact in equations.contacts if contact.limit is not None]
    return bool(limits) and all(equations.graph.is_constant_in_time(limit.index) for limit in limits)
