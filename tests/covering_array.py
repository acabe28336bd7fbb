"""A covering array: few rows in which every two values of two factors meet; a greedy, seeded generator."""

import itertools
import random
from collections.abc import Callable, Hashable, Mapping, Sequence
from typing import Any

Row = dict[str, Any]
TRIES = 8  # possible completions of a pair, of which the one is taken that covers most
DRAWS = 300  # completions after which a pair counts as impossible; the later half are drawn at random


def covering_array(
    factors: Mapping[str, Sequence[Hashable]], possible: Callable[[Row], bool], apart: Sequence[tuple[str, str]] = ()
) -> tuple[list[Row], list[tuple]]:
    """(rows, pairs that no possible row has): each pair of values of two factors stands in one row at least.

    possible: whether a row can be; apart: pairs of factors whose values need not meet. The same factors give the same
    rows. A pair is (factor, value, factor, value), factors in their order.
    """
    draw = random.Random("covering array")
    couples = [two for two in itertools.combinations(factors, 2) if two not in apart]
    open_pairs = dict.fromkeys((a, x, b, y) for a, b in couples for x in factors[a] for y in factors[b])
    order = list(factors)

    def pair_of(one: str, x: Any, two: str, y: Any) -> tuple:
        return (one, x, two, y) if order.index(one) < order.index(two) else (two, y, one, x)

    def completed(pair: tuple, by_chance: bool) -> Row:
        row = {pair[0]: pair[1], pair[2]: pair[3]}
        for name in draw.sample([name for name in order if name not in row], len(order) - 2):
            values = draw.sample(list(factors[name]), len(factors[name]))
            gain = {
                value: 0 if by_chance else sum(pair_of(name, value, *other) in open_pairs for other in row.items())
                for value in values
            }
            row[name] = max(values, key=lambda value, gain=gain: gain[value])
        return row

    rows, never = [], []
    while open_pairs:
        pair = next(iter(open_pairs))
        drawn = (completed(pair, 2 * number > DRAWS) for number in range(DRAWS))
        items = list(itertools.islice(filter(possible, drawn), TRIES))
        covered = [[(a, row[a], b, row[b]) for a, b in couples] for row in items]
        if not items:
            never.append(pair)
            del open_pairs[pair]
            continue
        best = max(range(len(items)), key=lambda i: sum(each in open_pairs for each in covered[i]))
        rows.append({name: items[best][name] for name in order})
        for each in covered[best]:
            open_pairs.pop(each, None)
    return rows, never
