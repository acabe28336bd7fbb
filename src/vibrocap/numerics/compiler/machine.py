"""The processor for which machine code is made, and LLVM's way there: passes, then an object file.

Which passes was measured (AVX-512, LLVM 22, CPU seconds of passes + code, then the time of a run over that by O2; the
noise of the latter is about 0.02), beside LLVM's pipelines O1 and O2:

    kernel           few passes         O1                 O2
    EM, one motion   0.10 + 0.12, 1.00  0.29 + 0.19, 1.00
    LM, one motion   0.18 + 0.23, 1.00  0.46 + 0.30, 1.00
    EM, lanes        0.30 + 0.22, 1.01  0.58 + 0.33, 1.00  0.68 + 0.30, 1.00
    LM, lanes        0.45 + 0.34, 1.01  0.87 + 0.48, 1.01  1.09 + 0.46, 1.00
    LM, tangents     0.51 + 0.62, 0.99  0.93 + 0.72, 1.00  1.17 + 0.66, 1.00

The few passes are functions put in the place of their calls at once, where O1 weighs each with what was made of it so
far, and then O1's passes over one function, each of them once. Left out are those over functions before they are put
together, and those for loops that nothing has unrolled. O1 and O2 give the same bits, and so do the few passes where
they were compared: LLVM fuses a product with a sum of the same block, and chooses by the order of operands, which the
pass `reassociate` decides. Only tangents, whose block structure differs a little, were seen to differ in the last
place; their kernels take O1.
"""

import contextlib
import dataclasses
import functools
import os
import re
import threading
from collections import Counter
from collections.abc import Iterator
from typing import Any

import llvmlite.binding as llvm

BUSY = threading.RLock()  # LLVM's options are those of the whole process
SHORT = "; by few passes\n"  # first line of a text that is to be made so; others take O1
SMALL = 32  # lines of a function that is put in the place of its calls however many there are
_FUNCTION = re.compile(r"^define internal ([^@\n]*(@[\w.]+)\([^\n]*)\{\n(?:.*\n)*?\}", re.MULTILINE)
_CALL = re.compile(r"call [^@\n]*(@[\w.]+)\(")


@dataclasses.dataclass(frozen=True)
class Target:
    """What machine code is made for."""

    triple: str
    processor: str
    features: str

    @property
    def lanes(self) -> int:
        """8 where registers hold eight doubles (AVX-512), else 4."""
        return 8 if "+avx512f" in self.features.split(",") else 4

    @property
    def name(self) -> str:
        """All that decides which machine code is made, LLVM's version included."""
        version = ".".join(str(part) for part in llvm.llvm_version_info)
        return f"{self.triple} {self.processor} {self.features} LLVM {version} llvmlite {_llvmlite_version()}"


def _llvmlite_version() -> str:
    import llvmlite

    return llvmlite.__version__


@functools.cache
def host() -> Target:
    """This computer, or what VIBROCAP_CPU_NAME and VIBROCAP_CPU_FEATURES say of it."""
    name, features = os.environ.get("VIBROCAP_CPU_NAME"), os.environ.get("VIBROCAP_CPU_FEATURES")
    if features is None:
        features = "" if name else llvm.get_host_cpu_features().flatten()
    return Target(llvm.get_process_triple(), name or llvm.get_host_cpu_name(), features)


def code_made_for() -> dict[str, str]:
    """What decides, beside its text, which machine code a kernel becomes here: the processor and LLVM."""
    target = host()
    there = sorted(feature[1:] for feature in target.features.split(",") if feature.startswith("+"))
    version = ".".join(str(part) for part in llvm.llvm_version_info)
    return {
        "processor": f"{target.processor} ({target.triple})",
        "features": " ".join(there),
        "llvm": f"{version} of llvmlite {_llvmlite_version()}",
    }


@functools.cache
def _initialised(all_targets: bool) -> None:
    if all_targets:
        llvm.initialize_all_targets()
        llvm.initialize_all_asmprinters()
    else:
        llvm.initialize_native_target()
        llvm.initialize_native_asmprinter()


def _machine(target: Target) -> Any:
    """LLVM's target machine."""
    _initialised(target.triple != llvm.get_process_triple())
    made = llvm.Target.from_triple(target.triple)
    return made.create_target_machine(
        cpu=target.processor, features=target.features, opt=3, reloc="pic", codemodel="default"
    )


@contextlib.contextmanager
def instructions_in_the_order_written() -> Iterator[None]:
    """Within this context LLVM leaves the instructions of a block in the order of the source.

    The series are written in an order in which few numbers wait; LLVM's scheduler of machine instructions, which counts
    latencies, makes more of them wait, in memory, and the series cost an eighth more. LLVM knows this as an option of
    the whole process only, so it is set for as long as machine code is made, by one thread at a time.
    """
    with BUSY:
        llvm.set_option("", "-enable-misched=false")
        try:
            yield
        finally:
            llvm.set_option("", "-enable-misched=true")  # as without


def optimised(text: str, target: Target) -> tuple[Any, Any]:
    """(module, machine): LLVM's text after all passes. To be called within `instructions_in_the_order_written`."""
    machine = _machine(target)
    head = f'target datalayout = "{machine.target_data}"\ntarget triple = "{target.triple}"\n'
    short = text.startswith(SHORT)
    module = llvm.parse_assembly(head + (_put_in_place(text) if short else text), llvm.create_context())
    options = llvm.create_pipeline_tuning_options(speed_level=1)
    options.loop_vectorization = True
    options.slp_vectorization = False
    builder = llvm.create_pass_builder(machine, options)
    if not short:
        builder.getModulePassManager().run(module, builder)
        return module, machine
    passes = llvm.create_new_module_pass_manager()
    passes.add_always_inliner_pass()
    passes.add_global_dead_code_eliminate_pass()
    passes.run(module, builder)
    of_one_function = builder.getFunctionPassManager()
    for function in module.functions:
        if not function.is_declaration:
            of_one_function.run(function, builder)
    return module, machine


def _put_in_place(text: str) -> str:
    """The same, in which functions are marked that LLVM puts in the place of their calls: called once, or small."""
    calls = Counter(_CALL.findall(text))

    def marked(found: re.Match[str]) -> str:
        small = calls[found[2]] == 1 or found[0].count("\n") < SMALL
        if not small or "noinline" in found[1]:
            return found[0]
        return found[0].replace(f"{found[1]}{{", f"{found[1]}alwaysinline {{", 1)

    return _FUNCTION.sub(marked, text)


def object_code(text: str, target: Target) -> bytes:
    """The object file of a module in LLVM's language."""
    with instructions_in_the_order_written():
        module, machine = optimised(text, target)
        return machine.emit_object(module)


def assembly(text: str, target: Target) -> str:
    """The same as text in the language of the processor's assembler."""
    with instructions_in_the_order_written():
        module, machine = optimised(text, target)
        return machine.emit_assembly(module)
