"""How many motions run side by side, in the vector registers of the processor for which kernels are compiled."""

import functools
import os


@functools.cache
def lane_count() -> int:
    """8 where registers hold eight doubles (AVX-512), else 4.

    Eight in pairs of registers of four would wait in memory most of the time, as there are half as many registers too:
    with the LuGre law a sweep took a quarter longer. A run gives the same in eight lanes and in four.
    """
    features = os.environ.get("NUMBA_CPU_FEATURES")
    if features is None and "NUMBA_CPU_NAME" not in os.environ:
        from llvmlite.binding import get_host_cpu_features  # only here: kernels from the cache are not compiled

        return 8 if get_host_cpu_features().get("avx512f") else 4
    return 8 if "+avx512f" in (features or "") else 4
