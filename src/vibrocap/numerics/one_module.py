"""A kernel is compiled as one module: no function of it is optimised, or made machine code, on the way to the whole.

Numba by itself makes a module of every function, optimises it together with all that it calls, turns it into machine
code, and links a copy of it into its callers, where the same happens again. There its functions stay visible from
outside, so that every call passes the seven fields of every array, used or not.

Here a function that is a part of a kernel waits until its kernel is compiled. All are then private to one module, which
is optimised once: LLVM inlines a function that is called from one place, and passes only what is used.
"""

from typing import Any

from llvmlite.binding import Linkage
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import CompilerBase, DefaultPassBuilder


class NoMachineCode:
    """Stands for Numba's code generator where no machine code is made."""

    def set_env(self, name: str, environment: Any) -> None:
        """Nothing to set: no code of a part ever runs but as what has been linked into a kernel."""


class Part(JITCodeLibrary):
    """The code of one function, which waits to be linked."""

    @property
    def codegen(self) -> Any:
        """No code generator."""
        return NoMachineCode()

    def finalize(self) -> None:
        """Nothing more to come."""
        self._finalized = True

    def get_pointer_to_function(self, name: str) -> int:
        """0: there is none."""
        return 0


class Whole(JITCodeLibrary):
    """The code of a kernel's entry, into which all parts are linked."""

    def finalize(self) -> None:
        """Link all parts, optimise the whole, make machine code."""
        self._linking_libraries = users_first(self)
        super().finalize()

    def _optimize_final_module(self) -> None:
        for function in self._final_module.functions:
            if not function.is_declaration and function.linkage == Linkage.linkonce_odr:
                function.linkage = Linkage.internal
        super()._optimize_final_module()


class PartCompiler(CompilerBase):
    """Numba's compiler for a part of a kernel."""

    library_class = Part

    def define_pipelines(self) -> list:
        """Numba's own passes, with the code in a library of ours."""
        state = self.state
        state.library = self.library_class(state.targetctx.codegen(), state.func_id.func_qualname)
        state.library.enable_object_caching()
        state.flags.noalias = True  # the arrays of a kernel are three different ones
        return [DefaultPassBuilder.define_nopython_pipeline(state)]


class WholeCompiler(PartCompiler):
    """Numba's compiler for the entry of a kernel."""

    library_class = Whole


def users_first(whole: Whole) -> list[Any]:
    """The libraries that a kernel needs, each behind all that use it: LLVM drops what none has asked for yet."""
    found: dict[Any, None] = {}

    def visit(library: Any) -> None:
        for needed in library._linking_libraries:
            if needed not in found:
                if isinstance(needed, Part):
                    visit(needed)
                found[needed] = None

    visit(whole)
    return list(reversed(found))
