"""When the values of straight-line code are known, so that a sum can wait for its latest term last.

Sums are computed in the order in which they are written. Half of a step passes in chains of operations that wait for
one another, and a term that is added too early makes all later ones wait for it.
"""

import ast
import functools
from collections.abc import Sequence

Term = tuple[int, str]  # sign, and text: a name, a number or a product
SUM, PRODUCT, QUOTIENT, CALL = 4, 4, 14, 40  # cycles, about those of an x86-64 processor; a product in a sum is free


class LatencyOrder:
    """Cycles after which each name is known, if nothing but its operands delays it; what is not written here, at 0."""

    def __init__(self) -> None:
        self._known: dict[str, int] = {}

    def write(self, name: str, formula: str) -> None:
        """Note the line name = formula."""
        self._known[name] = self.of(formula)

    def of(self, formula: str) -> int:
        """When the value of a formula is known."""
        if formula in self._known:
            return self._known[formula]
        return self._of(_tree(formula)) if "(" in formula or "[" in formula else self._of_flat(formula)

    def _of_flat(self, formula: str) -> int:
        """The same of names and numbers between + - * /, without the detour of a tree: most formulas are such."""
        known, words = self._known.get, formula.split(" ")
        total = factors = -1  # when the sum so far is known, and the factors of its only term, if that is a product
        latency, last, product = known(words[0].lstrip("-"), 0), 0, False  # of the term that is read
        for place in range(1, len(words) + 1, 2):
            operator, word = words[place : place + 2] if place < len(words) else ("", "")
            if operator in ("*", "/"):
                product = operator == "*"
                last = max(latency, known(word.lstrip("-"), 0))
                latency = last + (PRODUCT if product else QUOTIENT)
                continue
            if total < 0:
                total, factors = latency, last if product else -1
            else:  # a product is free in a sum, the left one of two
                total = (max(factors, latency) if factors >= 0 else max(total, last if product else latency)) + SUM
                factors = -1
            latency, product = known(word.lstrip("-"), 0), False
        return total

    def _of(self, node: ast.expr) -> int:
        if isinstance(node, ast.Name):
            return self._known.get(node.id, 0)
        if isinstance(node, ast.UnaryOp):
            return self._of(node.operand)
        if isinstance(node, ast.BinOp):
            operands = [node.left, node.right]
            if isinstance(node.op, (ast.Add, ast.Sub)):
                fused = next((side for side in operands if _is_product(side)), None)  # the left one of two
                if isinstance(fused, ast.BinOp):
                    operands = [*(side for side in operands if side is not fused), fused.left, fused.right]
                latency = SUM
            else:
                latency = PRODUCT if isinstance(node.op, ast.Mult) else QUOTIENT
            return max(map(self._of, operands)) + latency
        if isinstance(node, ast.Call):
            return max(map(self._of, node.args), default=0) + CALL
        return self._of(node.value) if isinstance(node, ast.Subscript) else 0

    def sum(self, terms: Sequence[Term]) -> str:
        """The sum of terms, the latest last; "0.0" of none."""
        ordered = sorted(terms, key=lambda term: self.of(term[1]))
        plus = [term for term in ordered if term[0] > 0]
        if not ordered:
            return "0.0"
        if not plus:
            negative = self.sum([(1, text) for _, text in ordered])
            return f"-({negative})" if len(ordered) > 1 else f"-{negative}"
        ordered.remove(plus[0])
        ordered.insert(0, plus[0])
        if len(ordered) > 1 and ordered[1][0] > 0 and all("*" in text for _, text in ordered[:2]):
            ordered[:2] = ordered[1::-1]  # of two products that are added the left one is free
        first, *others = ordered
        return first[1] + "".join(f" {'+' if sign > 0 else '-'} {text}" for sign, text in others)


@functools.lru_cache(maxsize=2**14)
def _tree(formula: str) -> ast.expr:
    """A formula, parsed once: each is asked for many times, and kernels of one system share most of theirs."""
    return ast.parse(formula, mode="eval").body


def combined(op: str, operands: Sequence[Sequence[Term]]) -> list[Term]:
    """The terms of a sum, a difference or a negative ("add", "sub", "neg") of operands that are given as terms."""
    signs = (-1,) if op == "neg" else (1, -1 if op == "sub" else 1)
    return [(sign * own, text) for sign, terms in zip(signs, operands, strict=True) for own, text in terms]


def _is_product(node: ast.expr) -> bool:
    return isinstance(node, ast.BinOp) and isinstance(node.op, ast.Mult)
