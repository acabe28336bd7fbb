"""Writes the series of accelerations from the equations of motion as they are told, see `Mechanics`.

Order by order they are one linear problem, with the same matrix M_0 at every order k,

    M_0 a_k = h_k - sum of M_l a_(k-l) over l = 1..k

which leaves few products where the solved equations have many. Contacts come last: what is left of the row of one is
the force that holds it at rest, and one at rest takes no part in the rows of the others. Friction under a load that
the motion makes contains accelerations, so that it belongs to the matrix.
"""

import functools
import operator
from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import Any

from vibrocap.numerics.codegen.straight_line import ONE, ZERO, Formula, Term, combined, literal, total
from vibrocap.numerics.expressions.equations import Mechanics, MotionRow
from vibrocap.numerics.expressions.graph import Expression, derivative, operands_of, sensitivity

LINEAR = ("add", "sub", "neg", "mul", "div")


class MechanicsWriter:
    """Writes the coefficients of the accelerations, on behalf of a `jets.JetWriter`.

    A node has the level 0 if its coefficient k contains any a_k, 1 if its coefficient k + 1 is the first that does.
    """

    def __init__(self, writer: Any, mechanics: Mechanics):
        self.writer, self.graph, self.rows = writer, writer.graph, mechanics.rows
        self.unknown = {node.index: i for i, row in enumerate(self.rows) for node in row.rates}
        outside = self._reached([row.left for row in self.rows], set())
        self.contacts = tuple(contact.without_load(outside) for contact in mechanics.contacts)
        self.inner = range(len(self.rows) - len(self.contacts))
        loads = ((c, contact.load) for c, contact in enumerate(self.contacts))
        self.loads = {c: load for c, load in loads if load is not None}
        self._loaded = {load.moving.index: c for c, load in self.loads.items()}
        recorded = (*(row.left for row in self.rows), *(load.value for load in self.loads.values()))
        self._told = (*recorded, *(contact.friction for contact in self.contacts))
        self._newest: dict[int, bool] = {}
        self._levels: dict[int, int | None] = {}
        self._simples: dict[int, bool] = {}
        self.formulas = self._formulas()

    def reduced(self) -> Mechanics:
        """Without the rows of accelerations that, as solved, are sums and products of the others."""
        kept = [row for row in map(self.rows.__getitem__, self.inner) if not self._follows(row)]
        return Mechanics((*kept, *self.rows[len(self.inner) :]), self.contacts)

    def _follows(self, row: MotionRow) -> bool:
        op, *operands = self.graph.nodes[row.rates[0].index]
        return op in LINEAR and self._made_simply(op, operands)

    def _formulas(self) -> dict[int, Callable[[int], Formula]]:
        """How nodes are written that the rows give: accelerations, loads, forces at contacts."""
        formulas: dict[int, Callable[[int], Formula]] = {}
        for c, contact in enumerate(self.contacts):
            pairs = [(contact.held, self._held), (contact.taken, self._taken)]
            if c in self.loads:
                pairs += [(self.loads[c].moving, self._load), (self.loads[c].at_rest, self._load_at_rest)]
            formulas |= {node.index: functools.partial(formula, c) for node, formula in pairs if node is not None}
        for index in self._reached(self._told, set(self._loaded)):
            formulas.pop(index, None)  # what the rows are made of is written as it stands
        for i, row in enumerate(self.rows):
            first, *same = (node.index for node in row.rates)
            formulas[first] = functools.partial(self._acceleration, i)
            formulas |= {index: functools.partial(self.writer.coefficient, first) for index in same}
        return formulas

    def _reached(self, roots: Sequence[Expression], known: set[int]) -> set[int]:
        """The nodes that these and the rates of their states need, but for accelerations and what is told."""
        visited: set[int] = set()
        waiting = [root.index for root in roots]
        while waiting:
            index = waiting.pop()
            if index not in visited and index not in known and index not in self.unknown:
                visited.add(index)
                op, *operands = self.graph.nodes[index]
                waiting.extend(operands_of(self.graph, index))
                waiting.extend(self.writer.rates[i].index for i in operands if op == "state")
        return visited

    @property
    def usable(self) -> bool:
        """Whether every acceleration stands in rows, loads and friction by sums and products only."""
        return all(self.level(row.index) != 0 or self._simple(row.index) for row in self._told)

    # --- where the accelerations stand -------------------------------------------------------------------------------

    def _is_told(self, index: int) -> bool:
        return index in self.unknown or index in self._loaded

    def _is_newest(self, index: int) -> bool:
        """Whether the coefficient k of a node contains any a_k."""
        if index not in self._newest:
            op, *operands = self.graph.nodes[index]
            own = self._is_told(index) or (op == "rate" and self.level(operands[0]) == 1)
            self._newest[index] = own or any(map(self._is_newest, operands_of(self.graph, index)))
        return self._newest[index]

    def level(self, index: int) -> int | None:
        """0, 1 or None: see above."""
        if index not in self._levels:
            op, *operands = self.graph.nodes[index]
            below = (self.level(i) for i in operands_of(self.graph, index))
            moved = self._is_newest(self.writer.rates[operands[0]].index) if op == "state" else any(below)
            self._levels[index] = 0 if self._is_newest(index) else 1 if moved else None
        return self._levels[index]

    def _simple(self, index: int) -> bool:
        """Whether the first accelerations that a coefficient contains stand there by sums and products only."""
        if index not in self._simples:
            op, *operands = self.graph.nodes[index]
            settled = self.level(index) is None or self._is_told(index)
            self._simples[index] = settled or self._made_simply(op, operands)
        return self._simples[index]

    def _made_simply(self, op: str, operands: list) -> bool:
        if op in ("state", "rate"):
            return self._simple(self.writer.rates[operands[0]].index if op == "state" else operands[0])
        levels = [self.level(i) for i in operands]
        first = min((level for level in levels if level is not None), default=None)
        newest = [i for i, level in zip(operands, levels, strict=True) if level == first]
        alone = op != "mul" or len(newest) == 1  # the other factor is known before a_k
        divided = op != "div" or self.writer.forms.degree(operands[1]) == 0
        return op in LINEAR and alone and divided and all(map(self._simple, newest))

    def is_open(self, index: int) -> bool:
        """Whether coefficient k of a node is c + the sum of d_i a_i,k, with the same d at every order."""
        return self.level(index) == 0 and self._simple(index)

    def slope(self, index: int, unknown: int) -> Expression:
        """The factor d of an acceleration in an open node."""
        op, *operands = self.graph.nodes[index]
        if index in self.unknown or self.level(index) != 0:
            return self.graph.constant(float(self.unknown.get(index) == unknown))
        if op in ("mul", "div"):
            fixed, open_ = self._sides(index)
            return Expression(self.graph, fixed) * self.slope(open_, unknown)
        if op == "rate":
            slopes = self._slopes_by_rates(Expression(self.graph, operands[0]), unknown)
            return functools.reduce(operator.add, slopes, self.graph.constant(0.0))
        slopes = [self.slope(i, unknown) for i in operands]
        return -slopes[0] if op == "neg" else slopes[0] - slopes[1] if op == "sub" else slopes[0] + slopes[1]

    def _slopes_by_rates(self, value: Expression, unknown: int) -> Iterator[Expression]:
        """What an acceleration adds to the rate of a value by that of each state."""
        for i, rate in enumerate(self.writer.rates):
            by = derivative(value, i) if self.level(rate.index) == 0 else self.graph.constant(0.0)
            if by.value != 0.0:
                yield by * self.slope(rate.index, unknown)

    # --- coefficients but for what the newest accelerations add ------------------------------------------------------

    def product(self, index: int, k: int) -> Formula | None:
        """The coefficient k of a product in which accelerations stand, where it shares terms with the rows."""
        levels = [self.level(i) for i in self.graph.nodes[index][1:]]
        if levels[0] == levels[1]:
            return None
        fixed, open_ = self._sides(index)
        return self._settled(index, k) + self.writer.products([((fixed, 0), (open_, k))])

    def _sides(self, index: int) -> tuple[int, int]:
        """The factor of a product or a quotient that is known first, and the one that contains accelerations."""
        op, a, b = self.graph.nodes[index]
        if op == "div":
            return (1.0 / Expression(self.graph, b)).index, a
        return (b, a) if self.level(a) == self.level(index) else (a, b)

    def _settled(self, index: int, k: int) -> Formula:
        """What coefficient k of a product is but for the newest one of the factor that contains accelerations."""
        fixed, open_ = self._sides(index)
        known = self.writer.products(((fixed, i), (open_, k - i)) for i in range(1, k + 1))
        return self.writer.named("o", known, index, k)

    def without(self, index: int, k: int) -> list[Term]:
        """The coefficient k of a node but for what the a_k add."""
        op, *operands = self.graph.nodes[index]
        if self.level(index) != 0:
            return self.writer.signed_terms(index, k, inner=True)
        if index in self.unknown:
            return []
        if index in self._loaded:
            return [(1, self._raised[self._loaded[index]].left(k))]
        if op in ("mul", "div"):
            return self._product_terms(index, self._settled(index, k), lambda i: self.without(i, k))
        if op == "rate":
            return self._rate_without(operands[0], k + 1)
        return combined(op, [self.without(i, k) for i in operands])

    def _rate_without(self, index: int, k: int) -> list[Term]:
        """k times the coefficient k of a node of level 1, but for what the a_(k-1) add."""
        op, *operands = self.graph.nodes[index]
        if self.level(index) is None:
            return [(1, _multiple(k, self.writer.coefficient(index, k)))]
        if op == "state":
            return self._rate(self.writer.rates[operands[0]].index, k - 1)
        if op in ("mul", "div"):
            settled = _multiple(k, self._settled(index, k))
            return self._product_terms(index, settled, lambda i: self._rate_without(i, k))
        return combined(op, [self._rate_without(i, k) for i in operands])

    def _product_terms(self, index: int, settled: Formula, terms: Callable[[int], list[Term]]) -> list[Term]:
        """What is settled of a product, and its first factor times terms: each, or their sum if some are products."""
        fixed, open_ = self._sides(index)
        start = self.writer.coefficient(fixed, 0)
        newest = [term for term in terms(open_) if term[1] is not ZERO]
        if all(size.is_name for _, size in newest):
            return [(1, settled), *((sign, start * size) for sign, size in newest)]
        return [(1, settled), (1, start * total(newest))]

    def _rate(self, index: int, k: int) -> list[Term]:
        """`without` of a rate, as one name if it has several terms, as the state and the rows need it."""
        terms = [term for term in self.without(index, k) if term[1] is not ZERO]
        return terms if len(terms) < 2 else [(1, self.writer.named("e", total(terms), index, k))]

    # --- the linear problem ------------------------------------------------------------------------------------------

    def newest(self, i: int, k: int) -> Formula:
        """a_k."""
        return self.writer.coefficient(self.rows[i].rates[0].index, k)

    @functools.cached_property
    def _inner_rows(self) -> list["Eliminated"]:
        """Of accelerations that are no contact's, each without those before it."""
        rows: list[Eliminated] = []
        for i in self.inner:
            rows.append(Eliminated(self, f"inner{i}", self.rows[i].left, tuple(rows)))
        return rows

    @functools.cached_property
    def _holds(self) -> list["Eliminated"]:
        """Of the forces that hold contacts."""
        names = ["hold", *(f"hold{c}_" for c in range(1, len(self.contacts)))]
        rows = zip(names, self.rows[len(self.inner) :], strict=True)
        return [Eliminated(self, name, row.left, tuple(self._inner_rows)) for name, row in rows]

    @functools.cached_property
    def _raised(self) -> dict[int, "Eliminated"]:
        """Of the loads on contacts that the motion makes."""
        inner = tuple(self._inner_rows)
        return {c: Eliminated(self, f"load{c}_", load.value, inner) for c, load in self.loads.items()}

    def _behind(self, *without: int) -> list[int]:
        """The accelerations of contacts but for some, by their rows."""
        return [i for i in range(len(self.inner), len(self.rows)) if i - len(self.inner) not in without]

    def _load(self, c: int, k: int) -> Formula:
        """Coefficient k of a load."""
        return total(self._raised[c].terms(self._behind(), k))

    def _load_at_rest(self, c: int, k: int) -> Formula:
        """The same as it would be if the contact did not accelerate."""
        return total(self._raised[c].terms(self._behind(c), k))

    def _held(self, c: int, k: int) -> Formula:
        """Coefficient k of the force that would hold a contact, if it rests."""
        return total(self._holds[c].terms(self._behind(c), k))

    def _taken(self, c: int, k: int) -> Formula:
        """Coefficient k of the force at a contact among others: what holds it, or friction."""
        contact, friction = self.contacts[c], self.writer.coefficient(self.contacts[c].friction.index, k)
        if contact.share.value == 1.0:
            return friction
        held = self.writer.code.name(f"held{c}_{k}", total(self._holds[c].terms(self._behind(), k)))
        return held + self.writer.coefficient(contact.share.index, 0) * (friction - held)

    @functools.cached_property
    def _block(self) -> tuple[list[list[Formula]], list[list[Formula]], list[Formula]]:
        """The rows of contacts with friction, each without those before it: (matrix, factors of these, 1 over pivots).

        The last are 0 of a contact at rest.
        """
        matrix, factors, mobilities = [], [], []
        for c, contact in enumerate(self.contacts):
            row = self._holds[c].entries[len(self.inner) :]
            if c in self.loads:
                ratio = self.writer.coefficient(sensitivity(contact.friction, self.loads[c].moving.index).index, 0)
                pairs = zip(row, self._raised[c].entries[len(self.inner) :], strict=True)
                row = [entry - ratio * less for entry, less in pairs]
            own = []
            for e in range(c):
                own.append(self.kept(f"contact{c}_by{e}", row[e] * mobilities[e]))
                for j in range(e + 1, len(row)):
                    row[j] = self.kept(f"contact{c}_{j}_{e}", row[j] - own[e] * matrix[e][j])
            share = self.writer.coefficient(contact.share.index, 0)
            name = "mobility" if c == len(self.contacts) - 1 else f"mobility_of{c}"
            mobilities.append(self.writer.code.name(name, share / row[c]))
            matrix.append(row)
            factors.append(own)
        return matrix, factors, mobilities

    def kept(self, name: str, formula: Formula) -> Formula:
        """A formula under a name, unless it is one or a number."""
        return formula if formula.is_name or formula.number is not None else self.writer.code.name(name, formula)

    def _force(self, c: int, k: int) -> Formula:
        """What accelerates a contact, the contacts before it put in, while those behind it do not accelerate."""
        contact, hold = self.contacts[c], self._holds[c]
        # Where the contact cannot rest the force that holds is not asked for itself.
        held = hold.left_terms(k) if contact.share.value == 1.0 else [(1, hold.left(k))]
        friction, level = contact.friction.index, self.level(contact.friction.index)
        friction = self.writer.signed_terms(friction, k) if level != 0 else self.without(friction, k)
        before = [(-1, factor * self._force(e, k)) for e, factor in enumerate(self._block[1][c]) if factor is not ZERO]
        name = f"force_{k}" if c == 0 else f"force{c}_{k}"
        return self.writer.code.name(name, total([*combined("sub", [held, friction]), *before]))

    def _acceleration(self, i: int, k: int) -> Formula:
        """a_k."""
        behind = range(i + 1, len(self.rows))
        if i in self.inner:
            return total(self._inner_rows[i].terms(behind, k)) * self._inner_rows[i].inverse
        c = i - len(self.inner)
        row = [*(ZERO for _ in self.inner), *self._block[0][c]]
        return total([(1, self._force(c, k)), *self.taken_off(row, behind, k)]) * self._block[2][c]

    def taken_off(self, entries: Sequence[Formula], unknown: Iterable[int], k: int) -> list[Term]:
        """What accelerations take off a row with these entries."""
        return [(-1, entries[i] * self.newest(i, k)) for i in unknown if entries[i] is not ZERO]

    def state(self, rate: int, k: int) -> Formula:
        """Coefficient k of a state whose rate is an open node, without waiting for the last a_(k-1) itself."""
        terms = [(sign, size * literal(1.0 / k)) for sign, size in self._rate(rate, k - 1)]
        for i in range(len(self.rows)):
            slope = self.writer.coefficient(self.slope(rate, i).index, 0)
            if slope is ZERO:
                continue
            if i == len(self.rows) - 1:
                value = self._force(len(self.contacts) - 1, k - 1)
                factor = self.writer.code.name(f"mobility_{k}", self._block[2][-1] * literal(1.0 / k))
            else:
                value, factor = self.newest(i, k - 1), literal(1.0 / k)
            if slope.number != 1.0:
                factor = self.writer.named(f"mobility{i}_", factor * slope, rate, k)
            terms.append((1, value * factor))
        return total(terms)


class Eliminated:
    """A value of level 0 in which the accelerations of some rows are put in.

    entries: what the newest accelerations take off it
    """

    def __init__(self, writer: MechanicsWriter, name: str, value: Expression, rows: tuple["Eliminated", ...]):
        self.writer, self.name, self.value, self.rows = writer, name, value, rows
        slopes = [-writer.slope(value.index, j) for j in range(len(writer.rows))]
        self.entries = [writer.writer.coefficient(slope.index, 0) for slope in slopes]
        self.factors = []
        for p, row in enumerate(rows):
            self.factors.append(writer.kept(f"{name}_by{p}", self.entries[p] * row.inverse))
            for j in range(p + 1, len(self.entries)):
                less = self.entries[j] - self.factors[p] * row.entries[j]
                self.entries[j] = writer.kept(f"{name}_{j}_less{p}", less)

    @functools.cached_property
    def inverse(self) -> Formula:
        """One over the pivot of a row."""
        return self.writer.writer.code.name(f"{self.name}_inverse", ONE / self.entries[len(self.rows)])

    def left_terms(self, k: int) -> list[Term]:
        """Its coefficient k, while no other accelerations are there."""
        put_in = [(-1, factor * row.left(k)) for factor, row in zip(self.factors, self.rows, strict=True)]
        return [*self.writer.without(self.value.index, k), *put_in]

    def left(self, k: int) -> Formula:
        """The same under a name."""
        return self.writer.writer.code.name(f"{self.name}_{k}", total(self.left_terms(k)))

    def terms(self, unknown: Iterable[int], k: int) -> list[Term]:
        """Its coefficient k with these accelerations."""
        return [(1, self.left(k)), *self.writer.taken_off(self.entries, unknown, k)]


def _multiple(k: int, value: Formula) -> Formula:
    return value if k == 1 else literal(float(k)) * value
