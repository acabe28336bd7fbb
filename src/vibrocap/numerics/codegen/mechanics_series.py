"""Writes the series of accelerations from the equations of motion as they are told, see `Mechanics`.

Order by order they are one linear problem, with the same matrix M_0 at every order k,

    M_0 a_k = h_k - sum of M_l a_(k-l) over l = 1..k

which leaves few products where the solved equations have many. Contacts come last: what is left of the row of one is
the force that holds it at rest, and one at rest takes no part in the rows of the others. Friction under a load that
follows the motion contains accelerations, so that it belongs to the matrix.
"""

import dataclasses
import functools
from collections.abc import Callable, Sequence
from typing import Any

from vibrocap.numerics.codegen.straight_line import ZERO, Formula, Term, combined, literal, total
from vibrocap.numerics.expressions.equations import ContactMechanics, Mechanics, MotionRow
from vibrocap.numerics.expressions.graph import Expression, derivative, operands_of, sensitivity

Writing = Callable[[int], Formula]  # the coefficient of an order
LINEAR = ("add", "sub", "neg", "mul", "div")


class MechanicsWriter:
    """Writes the coefficients of the accelerations, on behalf of a `jets.JetWriter`.

    A node has the level 0 if its coefficient k contains any a_k, 1 if its coefficient k + 1 is the first that does.
    """

    def __init__(self, writer: Any, mechanics: Mechanics):
        self.writer, self.graph, self.rows = writer, writer.graph, mechanics.rows
        self.unknown = {node.index: i for i, row in enumerate(self.rows) for node in row.rates}
        self._told = self._reached([row.left for row in self.rows], set())
        self.contacts = tuple(map(self._with_load, mechanics.contacts))
        self.inner = len(self.rows) - len(self.contacts)
        self._loads = {each.load.moving.index: c for c, each in enumerate(self.contacts) if each.load is not None}
        self._newest_known: dict[int, bool] = {}
        self._levels: dict[int, int | None] = {}
        self._simples: dict[int, bool] = {}
        self.formulas = self._formulas()

    def reduced(self) -> Mechanics:
        """Without the rows of accelerations that, as solved, are sums and products of the others."""
        kept = [row for row in self.rows[: self.inner] if not self._follows(row)]
        return Mechanics((*kept, *self.rows[self.inner :]), self.contacts)

    def _follows(self, row: MotionRow) -> bool:
        op, *operands = self.graph.nodes[row.rates[0].index]
        return op in LINEAR and self._made_simply(op, operands)

    def _with_load(self, contact: ContactMechanics) -> ContactMechanics:
        """A contact, whose load counts as one of the forces from outside where it is no more than these."""
        outside = contact.load is not None and contact.load.moving.index in self._told
        return dataclasses.replace(contact, load=None) if outside else contact

    def _formulas(self) -> dict[int, Writing]:
        """How nodes are written that the rows give: accelerations, loads, forces at contacts."""
        found: dict[int, Writing] = {}
        for c, each in enumerate(self.contacts):
            if each.load is not None:
                found[each.load.moving.index] = functools.partial(self._load, c)
            if each.load is not None and each.load.at_rest is not None:
                found[each.load.at_rest.index] = functools.partial(self._load, c, at_rest=True)
            for node, formula in ((each.held, self.holding), (each.taken, self._taken)):
                if node is not None:
                    found[node.index] = functools.partial(formula, c)
        needed = [*(row.left for row in self._all_rows()), *(each.friction for each in self.contacts)]
        for index in self._reached(needed, set(self._loads)):
            found.pop(index, None)  # a force that stands in the rows is written as it stands
        for i, row in enumerate(self.rows):
            first, *same = (node.index for node in row.rates)
            found[first] = functools.partial(self._acceleration, i)
            found |= {index: functools.partial(self.writer.coefficient, first) for index in same}
        return found

    def _all_rows(self) -> list[MotionRow]:
        return [*self.rows, *(each.load.row for each in self.contacts if each.load is not None)]

    def _reached(self, roots: Sequence[Expression], told: set[int]) -> set[int]:
        """The nodes that these and the rates of their states need, none of them an acceleration or behind what is told."""
        seen: set[int] = set()
        waiting = [root.index for root in roots]
        while waiting:
            index = waiting.pop()
            if index not in seen and index not in told and index not in self.unknown:
                seen.add(index)
                op, *operands = self.graph.nodes[index]
                waiting.extend(operands_of(self.graph, index))
                waiting.extend(self.writer.rates[i].index for i in operands if op == "state")
        return seen

    @property
    def usable(self) -> bool:
        """Whether every acceleration stands in rows, loads and friction by sums and products only."""
        asked = [*(row.left.index for row in self._all_rows()), *(each.friction.index for each in self.contacts)]
        return all(self.level(index) != 0 or self._simple(index) for index in asked)

    # --- where the accelerations stand -------------------------------------------------------------------------------

    def _is_newest(self, index: int) -> bool:
        """Whether the coefficient k of a node contains any a_k."""
        if index not in self._newest_known:
            op, *operands = self.graph.nodes[index]
            newest = index in self.unknown or index in self._loads or (op == "rate" and self.level(operands[0]) == 1)
            self._newest_known[index] = newest or any(map(self._is_newest, operands_of(self.graph, index)))
        return self._newest_known[index]

    def level(self, index: int) -> int | None:
        """0, 1 or None: see above."""
        if index not in self._levels:
            op, *operands = self.graph.nodes[index]
            if self._is_newest(index):
                level = 0
            elif op == "state":
                level = 1 if self._is_newest(self.writer.rates[operands[0]].index) else None
            else:
                level = 1 if any(self.level(i) for i in operands_of(self.graph, index)) else None
            self._levels[index] = level
        return self._levels[index]

    def _simple(self, index: int) -> bool:
        """Whether the first accelerations that a coefficient contains stand there by sums and products only."""
        if index not in self._simples:
            op, *operands = self.graph.nodes[index]
            told = self.level(index) is None or index in self.unknown or index in self._loads
            self._simples[index] = told or self._made_simply(op, operands)
        return self._simples[index]

    def _made_simply(self, op: str, operands: list) -> bool:
        if op == "state":
            return self._simple(self.writer.rates[operands[0]].index)
        if op == "rate":
            return self.level(operands[0]) == 1 and self._simple(operands[0])
        levels = [self.level(i) for i in operands]
        first = min((level for level in levels if level is not None), default=None)
        newest = [i for i, level in zip(operands, levels, strict=True) if level == first]
        alone = op != "mul" or len(newest) == 1  # the other factor is known before a_k
        divided = op != "div" or self.writer.forms.degree(operands[1]) == 0
        return op in LINEAR and alone and divided and all(self._simple(i) for i in newest)

    def is_open(self, index: int) -> bool:
        """Whether coefficient k of a node is c + the sum of d_i a_i,k, with the same d at every order."""
        return self.level(index) == 0 and self._simple(index)

    def slope(self, index: int, unknown: int) -> Expression:
        """The factor d of an acceleration in an open node."""
        op, *operands = self.graph.nodes[index]
        if index in self.unknown or self.level(index) != 0:
            return self.graph.constant(float(self.unknown.get(index) == unknown))
        if op == "mul":
            fixed, open_ = self._sides(index)
            return Expression(self.graph, fixed) * self.slope(open_, unknown)
        if op == "div":
            return self.slope(operands[0], unknown) / Expression(self.graph, operands[1])
        if op == "rate":
            return self._rate_slope(Expression(self.graph, operands[0]), unknown)
        slopes = [self.slope(i, unknown) for i in operands]
        return -slopes[0] if op == "neg" else slopes[0] - slopes[1] if op == "sub" else slopes[0] + slopes[1]

    def _rate_slope(self, value: Expression, unknown: int) -> Expression:
        """The factor of an acceleration in the rate of a node of level 1."""
        found = self.graph.constant(0.0)
        for i, rate in enumerate(self.writer.rates):
            if self.level(rate.index) == 0 and (by := derivative(value, i)).value != 0.0:
                found = found + by * self.slope(rate.index, unknown)
        return found

    # --- coefficients but for what the newest accelerations add ------------------------------------------------------

    def product(self, index: int, k: int) -> Formula | None:
        """The coefficient k of a product in which accelerations stand, where it shares terms with the rows."""
        _, *operands = self.graph.nodes[index]
        levels = [self.level(i) for i in operands]
        if self.level(index) is None or operands[0] == operands[1] or levels[0] == levels[1]:
            return None
        fixed, open_ = self._sides(index)
        return self._settled(index, k) + self.writer.products([((fixed, 0), (open_, k))])

    def _sides(self, index: int) -> tuple[int, int]:
        """The factor of a product that is known first, and the one that contains accelerations."""
        _, a, b = self.graph.nodes[index]
        return (b, a) if self.level(a) == self.level(index) else (a, b)

    def _settled(self, index: int, k: int) -> Formula:
        """What coefficient k of a product is but for the newest one of the factor that contains accelerations."""
        fixed, open_ = self._sides(index)
        known = self.writer.products(((fixed, i), (open_, k - i)) for i in range(1, k + 1))
        return self.writer.named("o", known, index, k)

    def _without(self, index: int, k: int) -> list[Term]:
        """The coefficient k of a node of level 0, but for what the a_k add."""
        if self.level(index) != 0:
            return self.writer.signed_terms(index, k, inner=True)
        op, *operands = self.graph.nodes[index]
        if index in self.unknown:
            return []
        if index in self._loads:
            return [(1, self._load_left(self._loads[index], k))]
        if op == "mul":
            fixed, open_ = self._sides(index)
            start = self.writer.coefficient(fixed, 0)
            return [(1, self._settled(index, k)), *_times(start, self._without(open_, k))]
        if op == "div":
            inverse = self.writer.named("i", literal(1.0) / self.writer.coefficient(operands[1], 0), operands[1])
            return _times(inverse, self._without(operands[0], k))
        if op == "rate":
            return self._rate_without(operands[0], k + 1)
        return combined(op, [self._without(i, k) for i in operands])

    def _rate_without(self, index: int, k: int) -> list[Term]:
        """k times the coefficient k of a node of level 1, but for what the a_(k-1) add."""
        op, *operands = self.graph.nodes[index]
        if self.level(index) is None:
            return [(1, _multiple(k, self.writer.coefficient(index, k)))]
        if op == "state":
            return self._rate(self.writer.rates[operands[0]].index, k - 1)
        if op == "mul":
            fixed, open_ = self._sides(index)
            start = self.writer.coefficient(fixed, 0)
            return [(1, _multiple(k, self._settled(index, k))), *_times(start, self._rate_without(open_, k))]
        if op == "div":
            inverse = self.writer.named("i", literal(1.0) / self.writer.coefficient(operands[1], 0), operands[1])
            return _times(inverse, self._rate_without(operands[0], k))
        return combined(op, [self._rate_without(i, k) for i in operands])

    def _rate(self, index: int, k: int) -> list[Term]:
        """`_without` of a rate, as one name if it has several terms, as state and momentum both need it."""
        terms = [term for term in self._without(index, k) if term[1] is not ZERO]
        return terms if len(terms) < 2 else [(1, self.writer.named("e", total(terms), index, k))]

    # --- the linear problem ------------------------------------------------------------------------------------------

    @functools.cached_property
    def _eliminated(self) -> tuple[list[list[Formula]], list[list[Formula]], list[Formula]]:
        """(rows of M_0, those of contacts without friction in them; factors of the rows before; 1 over pivots)."""
        matrix: list[list[Formula]] = []
        factors: list[list[Formula]] = []
        inverses: list[Formula] = []
        for i, row in enumerate(self.rows):
            entries, own = self._reduced(f"m{i}", row, matrix, inverses, min(i, self.inner))
            matrix.append(entries)
            factors.append(own)
            if i < self.inner:
                inverses.append(self.writer.code.name(f"inverse{i}", literal(1.0) / entries[i]))
        return matrix, factors, inverses

    def _reduced(
        self, name: str, row: MotionRow, matrix: list, inverses: list, pivots: int
    ) -> tuple[list[Formula], list[Formula]]:
        """(what accelerations take off a row where the first ones are put in, the factors of their rows in it)."""
        entries = [self.writer.coefficient((-self.slope(row.left.index, j)).index, 0) for j in range(len(self.rows))]
        factors = []
        for p in range(pivots):
            factor = self._kept(f"{name}_by{p}", entries[p] * inverses[p])
            factors.append(factor)
            for j in range(p + 1, len(entries)):
                entries[j] = self._kept(f"{name}_{j}_{p}", entries[j] - factor * matrix[p][j])
        return entries, factors

    def _kept(self, name: str, formula: Formula) -> Formula:
        """A formula under a name, unless it is one or a number."""
        return formula if formula.is_name or formula.number is not None else self.writer.code.name(name, formula)

    def _left(self, row: MotionRow, factors: Sequence[Formula], k: int) -> list[Term]:
        """Coefficient k of a row, without the a_k of contacts; the others are put in."""
        return [*self._without(row.left.index, k), *((-1, factor * self._inner_left(p, k)) for p, factor in enumerate(factors))]

    def _inner_left(self, p: int, k: int) -> Formula:
        return self.writer.code.name(f"left{p}_{k}", total(self._left(self.rows[p], self._eliminated[1][p], k)))

    def _hold_left(self, c: int, k: int) -> list[Term]:
        """Coefficient k of the force that would hold a contact, while no contact accelerates."""
        i = self.inner + c
        return self._left(self.rows[i], self._eliminated[1][i], k)

    def _named_hold(self, c: int, k: int) -> Formula:
        return self.writer.code.name(f"hold_{k}" if c == 0 else f"hold{c}_{k}", total(self._hold_left(c, k)))

    @functools.cached_property
    def _raised(self) -> dict[int, tuple[list[Formula], list[Formula]]]:
        """Of each contact under a load that follows the motion: what accelerations add to it, factors of inner rows."""
        matrix, _, inverses = self._eliminated
        loads = [(c, each.load) for c, each in enumerate(self.contacts) if each.load is not None]
        return {c: self._reduced(f"load{c}", load.row, matrix, inverses, self.inner) for c, load in loads}

    def _load_left(self, c: int, k: int) -> Formula:
        """Coefficient k of a load, while no contact accelerates."""
        load = self.contacts[c].load
        assert load is not None
        terms = self._left(load.row, self._raised[c][1], k)
        return self.writer.code.name(f"load{c}_{k}", total((-sign, size) for sign, size in terms))

    def _added(self, rows: Sequence[Formula], contacts: Sequence[int], k: int, sign: int) -> list[Term]:
        """What the accelerations of contacts add to what these are the entries of."""
        of = {c: self.inner + c for c in contacts}
        return [
            (sign, rows[i] * self.writer.coefficient(self.rows[i].rates[0].index, k))
            for i in of.values()
            if rows[i] is not ZERO
        ]

    def _others(self, c: int) -> list[int]:
        return [d for d in range(len(self.contacts)) if d != c]

    def _load(self, c: int, k: int, at_rest: bool = False) -> Formula:
        """Coefficient k of a load; as it would be if the contact did not accelerate."""
        contacts = self._others(c) if at_rest else range(len(self.contacts))
        return total([(1, self._load_left(c, k)), *self._added(self._raised[c][0], contacts, k, 1)])

    def holding(self, c: int, k: int) -> Formula:
        """Coefficient k of the force that would hold a contact, if it rests."""
        held = self._named_hold(c, k)
        return total([(1, held), *self._added(self._eliminated[0][self.inner + c], self._others(c), k, -1)])

    def _taken(self, c: int, k: int) -> Formula:
        """Coefficient k of the force at a contact among others: what holds it, or friction."""
        each, row = self.contacts[c], self._eliminated[0][self.inner + c]
        friction = self.writer.coefficient(each.friction.index, k)
        if each.share.value == 1.0:
            return friction
        held = total([(1, self._named_hold(c, k)), *self._added(row, range(len(self.contacts)), k, -1)])
        held = self.writer.code.name(f"held{c}_{k}", held)
        return held + self.writer.coefficient(each.share.index, 0) * (friction - held)

    @functools.cached_property
    def _block(self) -> tuple[list[list[Formula]], list[list[Formula]], list[Formula]]:
        """The rows of contacts, friction in them, eliminated: (matrix, factors, 1 over pivots, 0 of one at rest)."""
        matrix, factors, mobilities = [], [], []
        for c, each in enumerate(self.contacts):
            row = list(self._eliminated[0][self.inner + c][self.inner :])
            if each.load is not None:
                ratio = sensitivity(each.friction, each.load.moving.index)
                by = self.writer.coefficient(ratio.index, 0)
                raised = self._raised[c][0][self.inner :]
                row = [entry + by * more for entry, more in zip(row, raised, strict=True)]
            own = []
            for e in range(c):
                own.append(self._kept(f"contact{c}_by{e}", row[e] * mobilities[e]))
                row[e + 1 :] = [
                    self._kept(f"contact{c}_{j}_{e}", row[j] - own[e] * matrix[e][j]) for j in range(e + 1, len(row))
                ]
            share = self.writer.coefficient(each.share.index, 0)
            name = "mobility" if c == len(self.contacts) - 1 else f"mobility_of{c}"
            mobilities.append(self.writer.code.name(name, share / row[c]))
            matrix.append(row)
            factors.append(own)
        return matrix, factors, mobilities

    def _force(self, c: int, k: int) -> Formula:
        """What accelerates a contact, the contacts before it put in, while those behind it do not accelerate."""
        each = self.contacts[c]
        # Where the contact cannot rest the force that holds is not asked for itself.
        held = self._hold_left(c, k) if each.share.value == 1.0 else [(1, self._named_hold(c, k))]
        friction = each.friction.index
        friction = self.writer.signed_terms(friction, k) if self.level(friction) != 0 else self._without(friction, k)
        before = [(-1, factor * self._force(e, k)) for e, factor in enumerate(self._block[1][c]) if factor is not ZERO]
        name = f"force_{k}" if c == 0 else f"force{c}_{k}"
        return self.writer.code.name(name, total([*combined("sub", [held, friction]), *before]))

    def _acceleration(self, i: int, k: int) -> Formula:
        """a_k."""
        if i < self.inner:
            row, inverse, left = self._eliminated[0][i], self._eliminated[2][i], self._inner_left(i, k)
            behind = [(-1, row[j] * self._newest(j, k)) for j in range(i + 1, len(self.rows)) if row[j] is not ZERO]
        else:
            row, inverse, left = self._block[0][i - self.inner], self._block[2][i - self.inner], ZERO
            left, later = self._force(i - self.inner, k), range(i + 1, len(self.rows))
            behind = [(-1, row[j - self.inner] * self._newest(j, k)) for j in later if row[j - self.inner] is not ZERO]
        return total([(1, left), *behind]) * inverse

    def _newest(self, i: int, k: int) -> Formula:
        return self.writer.coefficient(self.rows[i].rates[0].index, k)

    def _mobility(self, k: int) -> Formula:
        """One over k times the inertia of the last contact."""
        mobility = self._block[2][-1]
        return mobility if k == 1 else self.writer.code.name(f"mobility_{k}", mobility * literal(1.0 / k))

    def state(self, rate: int, k: int) -> Formula:
        """Coefficient k of a state whose rate is an open node, without waiting for the newest a_(k-1) itself."""
        terms = [(sign, size * literal(1.0 / k)) for sign, size in self._rate(rate, k - 1)]
        *before, last = range(len(self.rows))
        slope = self.writer.coefficient(self.slope(rate, last).index, 0)
        if slope is not ZERO:
            force, factor = self._force(len(self.contacts) - 1, k - 1), self._mobility(k)
            if slope.number != 1.0:
                factor = self.writer.named("mobility_", factor * slope, rate, k)
            terms.append((1, force * factor))
        for i in before:
            slope = self.writer.coefficient(self.slope(rate, i).index, 0)
            if slope is not ZERO:
                share = slope * literal(1.0 / k) if slope.number != 1.0 else literal(1.0 / k)
                terms.append((1, self._newest(i, k - 1) * self._kept(f"share{self.writer.number(rate)}_{i}_{k}", share)))
        return total(terms)


def _times(start: Formula, terms: list[Term]) -> list[Term]:
    """Terms times a number: each, or their sum where some are products already."""
    terms = [term for term in terms if term[1] is not ZERO]
    if all(size.is_name for _, size in terms):
        return [(sign, start * size) for sign, size in terms]
    return [(1, start * total(terms))]


def _multiple(k: int, value: Formula) -> Formula:
    return value if k == 1 else literal(float(k)) * value
