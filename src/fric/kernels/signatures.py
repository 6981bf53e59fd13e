"""The signature of every compiled friction step.

A step is compiled with this explicit signature and handed to the loops as a first-class function: a loop is
compiled once for all models, starts warm from the cache in a new process, and sees an edit of a model.
"""

import logging
import os
from collections.abc import Callable
from functools import cache
from types import FunctionType
from typing import Any, TypeVar

import numba
from numba import types
from numba.core.dispatcher import Dispatcher

from fric.arrays import Real

ARRAY, TABLE = types.float64[::1], types.float64[:, ::1]
STEP = types.float64(types.float64, types.float64, types.float64, ARRAY, ARRAY)
"""``force = step(dz, v, dt, state, parameters)``: advance by one increment, change ``state``, return the force.

dz [m] is the position increment of the step, v [m/s] the velocity at its end, dt [s] its length; ``state`` and
``parameters`` are as the model lays them out. The force is what friction exerts against the motion, positive
for v > 0."""

STEP_FUNCTION = types.FunctionType(STEP)

Step = Callable[[float, float, float, Real, Real], float]

Function = TypeVar("Function", bound=Callable[..., object])

_HERE = {entry.path for entry in os.scandir(os.path.dirname(__file__)) if entry.name.endswith(".py")}
"""The files of this room: a number that a function takes from one of them, as the place of a signal, is compiled in."""

_LOG = logging.getLogger("fric.kernels")


def _sources(function: FunctionType) -> set[str]:
    """Return the files that a compiled function depends on: its file, this room, and the files of what it calls."""
    called = (function.__globals__.get(name) for name in function.__code__.co_names)
    callees = [callee.py_func for callee in called if isinstance(callee, Dispatcher)]
    return {*_HERE, function.__code__.co_filename}.union(*map(_sources, callees))


@cache
def _link_runtime() -> None:
    """Let cached machine code find Numba's memory management, which `rtsys.initialize` would also compile again."""
    from llvmlite.binding import add_symbol
    from numba.core.runtime._nrt_python import c_helpers

    for name, address in c_helpers.items():
        add_symbol(name if name.startswith("_") else f"NRT_{name}", address)


def _load(dispatcher: Any, signature: object) -> bool:
    """Load a function from the cache alone, as Numba does but for what it takes to compile another.

    Numba prepares its compiler first (`refresh`: 0.3 s, and SciPy's linear algebra), which cached code does not need; a
    later compilation prepares it then. This uses private names of Numba: where another version lacks them, False is
    returned, and Numba loads the function in its usual, slower way.
    """
    try:
        from numba.core.compiler_lock import global_compiler_lock

        context, kept = dispatcher.targetctx, dispatcher._cache
        _link_runtime()
    except (ImportError, AttributeError):
        return False
    with global_compiler_lock:  # whoever else compiles needs the context whole
        context.refresh = lambda: None
        try:
            found = kept.load_overload(signature, context)
        finally:
            del context.refresh
    if found is not None:
        dispatcher._cache_hits[signature] += 1
        context.insert_user_function(found.entry_point, found.fndesc, [found.library])
        dispatcher.add_overload(found)
    return found is not None


def compiled(signature: object, *, makes_arrays: bool = True) -> Callable[[Function], Function]:
    """Return a decorator that compiles a function with an explicit signature, cached on disk.

    Division by zero gives inf or nan, as in NumPy. There is no fast-math: same input, same output.

    Numba checks only the file of the function to find whether its cache is stale. But the machine code also holds the
    functions that it calls, so that ``gms.py`` would miss an edit of ``stribeck.py``. Here the stamp covers all files.

    signature: The types of the result and of the arguments, as Numba writes them.
    makes_arrays: False where the function makes no arrays, and views only of its arguments. Then they are not counted,
        which in a GMS step would take a quarter of the time.
    Compiled functions are put into those that call them: a call with its arrays takes as long as two slip blocks.:
    """
    options: dict[str, Any] = {"error_model": "numpy", "nogil": True, "_nrt": makes_arrays, "forceinline": True}

    def decorate(function: Function) -> Function:
        dispatcher: Any = numba.njit(**options)(function)
        if dispatcher is function:  # the compiler is switched off by NUMBA_DISABLE_JIT
            return function
        try:
            dispatcher.enable_caching()
        except RuntimeError:  # a user without a home has no folder for the cache: compiled at each start
            pass
        else:
            stats = [(path, os.stat(path)) for path in sorted(_sources(dispatcher.py_func)) if os.path.exists(path)]
            dispatcher._cache._cache_file._source_stamp = [(path, s.st_mtime_ns, s.st_size) for path, s in stats]
        if not _load(dispatcher, signature):
            _LOG.info("compiling %s", function.__name__)
            dispatcher.compile(signature)
        dispatcher.disable_compile()
        return dispatcher

    return decorate


def first_class(function: Function, made: Function, signature: object) -> Function:
    """Return a compiled function that keeps its address, by Numba's protocol for first-class functions.

    A loop asks for both addresses of a step, that for C and that for compiled code, at each call: to keep them takes
    two thirds off a replay of a few samples.
    """
    step: Any = made
    if made is not function:  # it is where the compiler is switched off

        @cache
        def address() -> int:
            result = step.get_compile_result(signature)
            return int(result.library.get_pointer_to_function(result.fndesc.llvm_cfunc_wrapper_name))

        step.__wrapper_address__ = address
        step.get_compile_result = cache(step.get_compile_result)
        library = step.get_compile_result(signature).library
        library.get_pointer_to_function = cache(library.get_pointer_to_function)
    return made


def compiled_step(function: Step) -> Step:
    """Compile a friction step with the signature `STEP`, cached on disk; it makes no arrays."""
    return first_class(function, compiled(STEP, makes_arrays=False)(function), STEP)
