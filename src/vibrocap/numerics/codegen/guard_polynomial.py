"""Writes, for all lanes at once, the guards of contacts and branches as polynomials over the step, and their signs."""

import math

from vibrocap.numerics.codegen.straight_line import function_source


def guard_source(order: int, sticks: bool, limit_constant: bool, several: bool, branches: bool) -> str:
    """`guard_simd`: the guard of the step as a polynomial over it, of several contacts in the selected lanes.

    Where there are branches also `switch_simd`, the same of the guard of one. `signs_simd` says how often the Bernstein
    coefficients change their sign (see `roots.py`), `guard_at` is the value of the polynomial.
    """
    body = ["velocity = VELOCITY_OF[contact]"]
    if sticks:
        body += ["sticking_force = STICKING_FORCE_OF[contact]", "limit = LIMIT_OF[contact]"]
    body += [f"v{k} = load(floats, velocity + {k} * LANES)" for k in range(order + 1)]
    for k in range(order + 1):
        one, two = (f"v{k + i}" if k + i <= order else "0.0" for i in (1, 2))
        guard = f"side * where(two, {two}, where(one, {one}, v{k}))"
        if sticks:
            sticking_force, limit = (f"load(floats, {name} + {k} * LANES)" for name in ("sticking_force", "limit"))
            applied = f"direction * {sticking_force}"
            margin = f"-({applied})" if k and limit_constant else f"{limit} - {applied}"
            guard = f"where(stuck, {margin if k < order else '0.0'}, {guard})"
        body += _stored(k, guard, several)
    heads = {"guard_simd(floats, selected, contact, side, stuck, direction, one, two, h)": body}
    body = []
    if branches:
        body = [f"v{k} = load(floats, row + {k} * LANES)" for k in range(order + 1)]
        for k in range(order + 1):
            body += _stored(k, f"where(one, {f'v{k + 1}' if k < order else '0.0'}, v{k})", selected=False)
    heads["switch_simd(floats, row, one, h)"] = body
    loads = [f"a{k} = load(floats, WORK + {k} * LANES)" for k in range(order + 1)]
    heads["signs_simd(floats)"] = [*loads, *_signs(order)]
    value, slope = [f"a{k}" for k in range(order + 1)], [f"{k}.0 * a{k}" for k in range(1, order + 1)]
    heads["guard_at(floats, x)"] = [*loads, *_paired(value, "y"), *_paired(slope, "d"), "return y, d"]
    return "\n".join(function_source(head, body) for head, body in heads.items())


def _stored(k: int, coefficient: str, selected: bool) -> list[str]:
    """Lines that keep coefficient k of a guard, over the unit interval; of the lanes that are selected."""
    scaled = f"{coefficient}{'' if k == 0 else ' * p'}"
    kept = f"where(selected, {scaled}, load(floats, WORK + {k} * LANES))" if selected else scaled
    return [f"store(floats, WORK + {k} * LANES, {kept})", "p = h" if k == 0 else "p = p * h"]


def _signs(order: int) -> list[str]:
    """Lines that give the values of a guard at both ends and how often its Bernstein coefficients change their sign."""
    body = [f"b{k} = a{k} * {1.0 / math.comb(order, k)!r}" for k in range(order + 1)]
    body += [f"b{i} = b{i} + b{i - 1}" for level in range(1, order + 1) for i in range(order, level - 1, -1)]
    body.append("changes = where((b0 > 0.0) ^ (b1 > 0.0), 1.0, 0.0)")
    for k in range(2, order + 1):
        body.append(f"changes = changes + where((b{k - 1} > 0.0) ^ (b{k} > 0.0), 1.0, 0.0)")
    return [*body, f"return a0, b{order}, changes"]


def _paired(coefficients: list[str], name: str) -> list[str]:
    """Lines that evaluate a polynomial of x by pairs (Estrin), a chain of few dependent operations."""
    lines, power, level = [], "x", 0
    while len(coefficients) > 1:
        paired = []
        for i in range(0, len(coefficients) - 1, 2):
            paired.append(f"{name}{level}_{i // 2}")
            lines.append(f"{paired[-1]} = {coefficients[i]} + {coefficients[i + 1]} * {power}")
        coefficients = paired + coefficients[len(coefficients) - len(coefficients) % 2 :]
        if len(coefficients) > 1:
            lines.append(f"{name}x{level} = {power} * {power}")
            power, level = f"{name}x{level}", level + 1
    return [*lines, f"{name} = {coefficients[0]}"]
