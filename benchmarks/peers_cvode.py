"""CVODE (SUNDIALS) on stiff LuGre motions, with the package's own compiled rates and Jacobian.

CVODE's BDF is what most engineers would take for stiff bristles. It gets tolerances by state, the exact Jacobian, and
reversals as events at which it starts anew with the other sign of |v|. scikit-sundae brings the library, but calls
Python for all of these: a motion then takes 144 ms instead of 6. So the library is called directly, and what it calls
is compiled (Numba) around the package's own machine code: no Python runs within a motion but at its events.
"""

import ctypes
import importlib.metadata
import math
from collections.abc import Callable

import numba
import numba.extending
import numpy as np
import sksundae  # noqa: F401  loads what the library needs
from numba import types

import vibrocap as vc
from vibrocap.motion.recording.equations import equations, parameter_values
from vibrocap.motion.simulate import initial_state
from vibrocap.numerics.linker import compiled_kernel, plain_kernel
from vibrocap.numerics.run.budget import Budget, MotionStart
from vibrocap.numerics.run.motion import linked_motion, motion_memory

BDF, NORMAL, ROOT_FOUND = 2, 1, 2  # of cvode.h
MOST_STEPS = 10**6
POINTER, DOUBLE, INT, LONG = ctypes.c_void_p, ctypes.c_double, ctypes.c_int, ctypes.c_long
ENTRIES = """

def peer_rates(floats, ints, trace, rounds):
    rates(floats, floats[TIME], POINT, 0, RATE)
    return rounds


def peer_jacobian(floats, ints, trace, rounds):
    jacobian(floats, floats[TIME], POINT, 0, JACOBIAN)
    return rounds
"""
SIGNATURES = {
    "SUNContext_Create": (INT, (INT, POINTER)),
    "N_VNew_Serial": (POINTER, (ctypes.c_int64, POINTER)),
    "N_VGetArrayPointer_Serial": (POINTER, (POINTER,)),
    "SUNDenseMatrix": (POINTER, (ctypes.c_int64, ctypes.c_int64, POINTER)),
    "SUNDenseMatrix_Data": (POINTER, (POINTER,)),
    "SUNLinSol_Dense": (POINTER, (POINTER, POINTER, POINTER)),
    "CVodeCreate": (POINTER, (INT, POINTER)),
    "CVodeInit": (INT, (POINTER, POINTER, DOUBLE, POINTER)),
    "CVodeReInit": (INT, (POINTER, DOUBLE, POINTER)),
    "CVodeSVtolerances": (INT, (POINTER, DOUBLE, POINTER)),
    "CVodeSetLinearSolver": (INT, (POINTER, POINTER, POINTER)),
    "CVodeSetJacFn": (INT, (POINTER, POINTER)),
    "CVodeRootInit": (INT, (POINTER, INT, POINTER)),
    "CVodeSetRootDirection": (INT, (POINTER, POINTER)),
    "CVodeSetMaxNumSteps": (INT, (POINTER, LONG)),
    "CVodeSetStopTime": (INT, (POINTER, DOUBLE)),
    "CVode": (INT, (POINTER, DOUBLE, POINTER, POINTER, INT)),
}


def library() -> dict[str, Callable]:
    """The functions of SUNDIALS that scikit-sundae brings along; ImportError where its files have other names."""
    loaded = []
    for part in ("libsundials_core", "libsundials_cvode"):
        values = [file for file in importlib.metadata.files("scikit-sundae") or () if file.name.startswith(part)]
        if len(values) != 1:
            raise ImportError(f"no {part} in scikit-sundae")
        loaded.append(ctypes.CDLL(str(values[0].locate())))
    functions = {}
    for name, (result, arguments) in SIGNATURES.items():
        function = next(getattr(each, name) for each in loaded if hasattr(each, name))
        function.restype, function.argtypes = result, arguments
        functions[name] = function
    return functions


C = library()


def callbacks(system: vc.System, data: Callable, matrix_data: Callable):
    """(rates, Jacobian, guard) as CVODE calls them, the memory of the first two, and where in it the side stands."""
    recorded = equations(system)
    layout, text = linked_motion(recorded, 12)
    names = plain_kernel(text)
    state = list(initial_state(system, {}).values())
    start = MotionStart(recorded, parameter_values(system), state, system.drive.period)
    arrays = motion_memory(start, layout, Budget(1, 1e-9, 1, 1), (8, 8))
    entries = [
        compiled_kernel(str(text) + ENTRIES, entry=f"peer_{name}").bound_to(*arrays) for name in ("rates", "jacobian")
    ]
    rates, jacobian = (entry.func for entry in entries)
    first, second, third = entries[0].args
    floats, size, velocity = arrays[0].ctypes.data, len(state), recorded.contacts[0].state
    point, rate, matrix, width = (names[name] for name in ("POINT", "RATE", "JACOBIAN", "WIDTH"))
    time, side = layout.places["TIME"], layout.places["SIDE"]
    length = len(arrays[0])

    @numba.cfunc(types.int32(types.float64, types.voidptr, types.voidptr, types.voidptr))
    def called_rates(t, y, out, _user):
        memory = numba.carray(address(floats), length)
        values, carray = numba.carray(address(data(y)), size), numba.carray(address(data(out)), size)
        memory[time] = t
        for i in range(size):
            memory[point + i] = values[i]
        rates(first, second, third, 1)
        for i in range(size):
            carray[i] = memory[rate + i]
        return 0

    @numba.cfunc(types.int32(types.float64, *[types.voidptr] * 7))
    def called_jacobian(t, y, _rates, out, _user, _one, _two, _three):
        memory = numba.carray(address(floats), length)
        values, carray = numba.carray(address(data(y)), size), numba.carray(address(matrix_data(out)), size * size)
        memory[time] = t
        for i in range(size):
            memory[point + i] = values[i]
        jacobian(first, second, third, 1)
        for i in range(size):
            for j in range(size):
                carray[j * size + i] = memory[matrix + i * width + j]
        return 0

    @numba.cfunc(types.int32(types.float64, types.voidptr, types.CPointer(types.float64), types.voidptr))
    def called_guard(_t, y, out, _user):
        out[0] = numba.carray(address(floats), length)[side] * numba.carray(address(data(y)), size)[velocity]
        return 0

    return (called_rates, called_jacobian, called_guard), arrays, side


@numba.extending.intrinsic
def address(_context, number):
    """A pointer to doubles from a number."""

    def codegen(context, builder, signature, arguments):
        kind = context.get_value_type(signature.return_type)
        (given,) = arguments
        return builder.inttoptr(given, kind) if number != types.voidptr else builder.bitcast(given, kind)

    return types.CPointer(types.float64)(number), codegen


def prepare(system: vc.System, start: dict, end: float, tolerance: float) -> Callable[[], tuple[np.ndarray, int]]:
    """A function that runs a motion to its final state, and says how often its contact turned."""
    functions, arrays, side = callbacks(system, C["N_VGetArrayPointer_Serial"], C["SUNDenseMatrix_Data"])
    floats = arrays[0]
    initial = np.array(list(initial_state(system, start).values()))
    size, velocity = len(initial), equations(system).contacts[0].state
    context, reached, falling = POINTER(), DOUBLE(), INT(-1)
    assert C["SUNContext_Create"](0, ctypes.byref(context)) == 0

    def vector(values):
        made = C["N_VNew_Serial"](size, context)
        array = np.ctypeslib.as_array(
            ctypes.cast(C["N_VGetArrayPointer_Serial"](made), ctypes.POINTER(DOUBLE)), (size,)
        )
        array[:] = values
        return made, array

    state, y = vector(initial)
    out, rate = vector(0.0)
    deflection = system.friction.static_coefficient / system.friction.bristle_stiffness
    allowed, _ = vector([tolerance] * (size - 1) + [tolerance * deflection])
    solver = C["CVodeCreate"](BDF, context)
    matrix = C["SUNDenseMatrix"](size, size, context)
    linear = C["SUNLinSol_Dense"](state, matrix, context)
    for name, *given in (
        ("CVodeInit", functions[0].address, 0.0, state),
        ("CVodeSVtolerances", tolerance, allowed),
        ("CVodeSetLinearSolver", linear, matrix),
        ("CVodeSetJacFn", functions[1].address),
        ("CVodeRootInit", 1, functions[2].address),
        ("CVodeSetRootDirection", ctypes.byref(falling)),
        ("CVodeSetMaxNumSteps", MOST_STEPS),
    ):
        assert C[name](solver, *given) == 0, name
    floats[side] = 1.0
    functions[0].ctypes(0.0, state, out, None)
    first = math.copysign(1.0, rate[velocity])

    def run() -> tuple[np.ndarray, int]:
        floats[side], turns, flag = first, 0, ROOT_FOUND
        y[:] = initial
        reached.value = 0.0
        while flag == ROOT_FOUND:
            assert C["CVodeReInit"](solver, reached.value, state) == 0
            C["CVodeSetStopTime"](solver, end)
            flag = C["CVode"](solver, end, state, ctypes.byref(reached), NORMAL)
            assert flag >= 0, flag
            if flag == ROOT_FOUND:
                y[velocity], floats[side], turns = 0.0, -floats[side], turns + 1
        return y.copy(), turns

    run.kept = functions, arrays
    return run
