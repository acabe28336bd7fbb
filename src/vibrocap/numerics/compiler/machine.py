"""The processor for which machine code is made, and LLVM's way there: passes, then an object file.

Which of LLVM's pipelines was measured (AVX-512, LLVM 20, CPU seconds of passes + code in a fresh process, then the time
of a run over that with Numba; the machine was busy, so that a few hundredths mean nothing), beside a short list of ten
passes (functions called once inlined, SROA, instcombine, simplifycfg, loops rotated and written out):

    kernel           short list         O1                 O2                 O3
    EM, one motion   0.08 + 0.17, 0.99  0.31 + 0.22, 0.98  0.46 + 0.23, 1.01  0.37 + 0.19, 1.03
    LM, one motion   0.16 + 0.31, 0.96  0.51 + 0.35, 1.03  0.69 + 0.32, 1.02  0.71 + 0.42, 0.98
    EM, lanes        0.15 + 0.31, 1.05  0.58 + 0.43, 0.93  0.71 + 0.35, 0.91  0.82 + 0.37, 0.96
    LM, lanes        0.25 + 0.40, 1.17  0.81 + 0.43, 1.04  1.10 + 0.50, 0.99  1.37 + 0.56, 1.05

O1 to O3 give the same bits, the short list others in the last place: it leaves the operands of sums in another order,
by which LLVM chooses the product that is fused. So one motion takes O1, an ensemble, worth longer thought, O2.
"""

import contextlib
import dataclasses
import functools
import os
import threading
from collections.abc import Iterator
from typing import Any

import llvmlite.binding as llvm

BUSY = threading.RLock()  # LLVM's options are those of the whole process
SHORT = "; by few passes\n"  # first line of a text that is to be made quickly, by O1; others take O2


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
    module = llvm.parse_assembly(head + text, llvm.create_context())
    options = llvm.create_pipeline_tuning_options(speed_level=1 if text.startswith(SHORT) else 2)
    options.loop_vectorization = True
    options.slp_vectorization = False
    builder = llvm.create_pass_builder(machine, options)
    passes = builder.getModulePassManager()
    passes.run(module, builder)
    return module, machine


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
