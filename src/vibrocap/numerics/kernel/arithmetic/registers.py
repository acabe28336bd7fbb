"""How many motions run side by side, in the vector registers of the processor for which kernels are compiled."""

import functools


@functools.cache
def lane_count() -> int:
    """8 where registers hold eight doubles (AVX-512), else 4.

    Eight in pairs of registers of four would wait in memory most of the time, as there are half as many registers too:
    with the LuGre law a sweep took a quarter longer. A run gives the same in eight lanes and in four.
    """
    from vibrocap.numerics.compiler.machine import host  # only here: plain kernels need no LLVM

    return host().lanes
