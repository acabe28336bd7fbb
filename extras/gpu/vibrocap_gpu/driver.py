"""NVIDIA's driver, through its own bindings: memory, code and launches of the first GPU."""

import contextlib
import ctypes
import functools
import importlib
from collections.abc import Iterator
from typing import Any

import numpy as np


class Gpu:
    """The first GPU, through the driver; whatever it refuses is a RuntimeError with its own words.

    The context is the GPU's primary one, held until Python ends: to take it and give it back costs a third of a second.
    """

    def __init__(self) -> None:
        self.driver: Any = importlib.import_module("cuda.bindings.driver")
        self.ask("cuInit", 0)
        self.device = self.ask("cuDeviceGet", 0)
        self.context = self.ask("cuDevicePrimaryCtxRetain", self.device)

    def serve(self) -> None:
        """Serve the thread that calls this."""
        self.ask("cuCtxSetCurrent", self.context)

    def ask(self, name: str, *arguments: Any) -> Any:
        """Call a function of the driver; its result."""
        code, *found = getattr(self.driver, name)(*arguments)
        if code != self.driver.CUresult.CUDA_SUCCESS:
            raise RuntimeError(f"{name}: {getattr(code, 'name', code)}")
        return found[0] if len(found) == 1 else tuple(found)

    def attribute(self, name: str) -> int:
        """A property of the GPU."""
        kind = self.driver.CUdevice_attribute
        return int(self.ask("cuDeviceGetAttribute", getattr(kind, f"CU_DEVICE_ATTRIBUTE_{name}"), self.device))

    @property
    def name(self) -> str:
        """What the GPU is called."""
        return self.ask("cuDeviceGetName", 256, self.device).split(b"\0")[0].decode()

    @property
    def free(self) -> int:
        """Bytes of its memory that are free."""
        return int(self.ask("cuMemGetInfo")[0])

    @contextlib.contextmanager
    def function(self, code: str, name: str) -> Iterator[Any]:
        """A function of a text in PTX, which is unloaded afterwards."""
        module = self.ask("cuModuleLoadData", code.encode() + b"\0")
        try:
            yield self.ask("cuModuleGetFunction", module, name.encode())
        finally:
            self.ask("cuModuleUnload", module)

    @contextlib.contextmanager
    def arrays(self, *sizes: int) -> Iterator[list[int]]:
        """Addresses of so many bytes each in the GPU's memory, which is given back afterwards."""
        made: list[Any] = []
        try:
            for size in sizes:
                made.append(self.ask("cuMemAlloc", max(size, 8)))
            yield [int(address) for address in made]
        finally:
            for address in made:
                self.ask("cuMemFree", address)

    def send(self, address: int, values: np.ndarray) -> None:
        """Copy an array to the GPU."""
        self.ask("cuMemcpyHtoD", address, values.ctypes.data, values.nbytes)

    def fetch(self, values: np.ndarray, address: int) -> None:
        """Copy an array from the GPU, as soon as all that was launched has ended."""
        self.ask("cuMemcpyDtoH", values.ctypes.data, address, values.nbytes)

    def launch(self, function: Any, blocks: int, threads: int, addresses: list[int], numbers: list[int]) -> None:
        """Start a function in so many blocks of so many threads."""
        kinds = (*[ctypes.c_void_p] * len(addresses), *[ctypes.c_int64] * len(numbers))
        arguments = ((*addresses, *numbers), kinds)
        self.ask("cuLaunchKernel", function, blocks, 1, 1, threads, 1, 1, 0, 0, arguments, 0)


@functools.cache
def first_gpu() -> Gpu:
    """The GPU of this process."""
    return Gpu()


def gpu_problem() -> str | None:
    """Why ensembles cannot run on a GPU here, and what is here; None if they can."""
    try:
        first_gpu()
    except Exception as error:  # whatever is missing in a CUDA installation is reported, not raised
        reason = (" ".join(str(error).split()) or type(error).__name__).rstrip(".")
        needs = "cuda needs an NVIDIA GPU, its driver and the package cuda-bindings; here"
        return f"{needs}: {reason}. Install what is missing, or choose cpu"
    return None
