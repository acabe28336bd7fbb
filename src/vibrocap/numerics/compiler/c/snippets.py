"""Pieces of C around the functions of a kernel: what it refuses, what C has no operator for, and its numbers."""

GUARDS = """#include <float.h>
#include <math.h>
#include <stdint.h>
#include <string.h>

#if defined(__FAST_MATH__) || (defined(__FINITE_MATH_ONLY__) && __FINITE_MATH_ONLY__) || defined(_M_FP_FAST)
#error "Compile this file without -ffast-math: its contact decisions need IEEE arithmetic."
#endif
#if !defined(FLT_EVAL_METHOD) || FLT_EVAL_METHOD != 0
#error "This file needs doubles of 64 bits throughout; on 32-bit x86 compile with -msse2 -mfpmath=sse."
#endif
#if defined(__clang__)
#pragma STDC FP_CONTRACT OFF
#elif defined(__GNUC__)
#pragma GCC optimize("fp-contract=off")
#elif defined(_MSC_VER)
#pragma fp_contract(off)
#endif
#if defined(__GNUC__)
#pragma GCC diagnostic ignored "-Wunused-parameter"
#pragma GCC diagnostic ignored "-Wunused-but-set-variable"
#endif
"""
# What C has no operator for; its name in braces gets the prefix. An int divided by 0 gives 0.
HELPERS = {
    "add": "int64_t {add}(int64_t x, int64_t y) { return (int64_t)((uint64_t)x + (uint64_t)y); }",
    "sub": "int64_t {sub}(int64_t x, int64_t y) { return (int64_t)((uint64_t)x - (uint64_t)y); }",
    "mul": "int64_t {mul}(int64_t x, int64_t y) { return (int64_t)((uint64_t)x * (uint64_t)y); }",
    "shl": "int64_t {shl}(int64_t x, int64_t y) { return (int64_t)((uint64_t)x << y); }",
    "shr": "int64_t {shr}(int64_t x, int64_t y) { return x < 0 ? ~(~x >> y) : x >> y; }",
    "magnitude": "int64_t {magnitude}(int64_t x) { return x < 0 ? (int64_t)(0 - (uint64_t)x) : x; }",
    "bits": "int64_t {bits}(double x) { int64_t n; memcpy(&n, &x, sizeof n); return n; }",
    "float_of": "double {float_of}(int64_t n) { double x; memcpy(&x, &n, sizeof x); return x; }",
    # what no int64_t holds, such as the exponent of an infinite power, becomes what processors make of it
    "truncated": """int64_t {truncated}(double x) {
  return x >= -9223372036854775808.0 && x < 9223372036854775808.0 ? (int64_t)x : INT64_MIN;
}""",
    "floor_divided": """int64_t {floor_divided}(int64_t x, int64_t y) {
  if (y == 0) return 0;
  if (y == -1) return (int64_t)(0 - (uint64_t)x);
  return x / y - (x % y != 0 && (x % y < 0) != (y < 0));
}""",
    "floor_rest": """int64_t {floor_rest}(int64_t x, int64_t y) {
  int64_t r = y == 0 || y == -1 ? 0 : x % y;
  return r != 0 && (r < 0) != (y < 0) ? r + y : r;
}""",
}


def number_text(number: bool | int | float) -> str:
    """All bits of a number, as C reads them."""
    if isinstance(number, bool):
        return str(int(number))
    if isinstance(number, int):
        if number == -(2**63):
            return "INT64_MIN"
        return f"INT64_C({number})" if number >= 0 else f"(-INT64_C({-number}))"
    if number != number:
        return "NAN"
    if number in (float("inf"), float("-inf")):
        return "INFINITY" if number > 0 else "(-INFINITY)"
    return number.hex() if not number.hex().startswith("-") else f"({number.hex()})"
