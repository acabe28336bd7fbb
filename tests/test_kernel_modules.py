"""A kernel is one module: private functions, each compiled once, and nothing of Numba's left changed."""

import re

import numba
import numpy as np
import pytest
from llvmlite.binding import Linkage
from numba.core.types.functions import BaseFunction

from vibrocap.numerics import link
from vibrocap.numerics.inference import asked_once
from vibrocap.numerics.one_module import Part, users_first
from vibrocap.numerics.registers import lane_count

WIDTH = lane_count()

# `leaf` is reached on ways of different lengths, and too long to be inlined there; powers with whole exponents bring
# functions of Numba's own.
LONG = "\n".join(f"    x = math.sin(x) + {i}.5 * real[k]" for i in range(60))
TEXT = f"""
import math

import numpy as np

def leaf(real, k):
    x = real[k] ** 3 + math.floor(real[k])
{LONG}
    return x

def branch(real, k):
    return leaf(real, k) - k ** 2 * max(real[k], 0.5)

def unused(real, k):
    return leaf(real, k)

def advance(real, whole, tape, rounds):
    for k in range(rounds):
        tape[k] = leaf(real, k) + branch(real, k) * 2.0
        whole[k] += 1
"""

ABREAST = """
from vibrocap.numerics.plain_vectors import align_stack, load, store

def doubled(real):
    align_stack()
    store(real, 0, 2.0 * load(real, 0))

def advance(real, whole, tape, rounds):
    for k in range(rounds):
        doubled(real)
"""


@pytest.fixture
def compiled(tmp_path, monkeypatch):
    """The kernel of TEXT, compiled anew."""
    monkeypatch.setattr(link, "_cache_folder", lambda: tmp_path)
    return link.compiled_kernel(TEXT)


def called(advance):
    real, whole, tape = np.linspace(-2.0, 3.0, 7), np.zeros(7, dtype=np.int64), np.zeros(7)
    advance(real, whole, tape, 7)
    return tape, whole


def test_a_compiled_kernel_does_what_its_text_says(compiled):
    for found, wanted in zip(called(compiled), called(link.plain_kernel(TEXT)["advance"]), strict=True):
        assert np.allclose(found, wanted, rtol=1e-15, atol=1e-15)


def test_only_the_entry_of_a_kernel_is_seen_from_outside(compiled):
    functions = list(compiled.overloads[compiled.signatures[0]].library.get_defined_functions())
    seen = [function.name for function in functions if function.linkage != Linkage.internal]
    assert len(functions) > len(seen)
    assert len(seen) == 3  # the entry itself, and the wrappers through which Python and C call it
    assert all("advance" in name for name in seen)


def test_vectors_on_the_stack_are_aligned_where_they_are(tmp_path, monkeypatch):
    """A function that aligns its stack is not inlined into one that does not."""
    monkeypatch.setattr(link, "_cache_folder", lambda: tmp_path)
    advance = link.compiled_kernel(ABREAST)
    functions = advance.overloads[advance.signatures[0]].library.get_defined_functions()
    (inner,) = (function for function in functions if "doubled" in function.name)
    assert re.search(rb"alignstack[(=]64", b" ".join(inner.attributes))  # versions of LLVM write it in two ways
    real = np.arange(float(2 * WIDTH))
    advance(real, np.zeros(1, dtype=np.int64), np.zeros(1), 3)
    assert np.array_equal(real[:WIDTH], 8.0 * np.arange(WIDTH))


def test_what_is_linked_stands_behind_all_that_use_it(compiled):
    order = users_first(compiled.overloads[compiled.signatures[0]].library)
    assert [library.name for library in order if isinstance(library, Part)] == ["branch", "leaf"]


def test_numba_is_left_as_it_was(compiled):
    asked = BaseFunction.get_call_type
    with asked_once():
        assert BaseFunction.get_call_type is not asked
    assert BaseFunction.get_call_type is asked
    assert numba.njit(lambda x, k: x**3 + k**2)(2.0, 3) == 17.0  # with functions that the kernel needed too
