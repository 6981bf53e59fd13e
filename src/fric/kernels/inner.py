"""A friction step that calls another step: the address of the inner step travels in the outer one's parameters.

A first-class function cannot lie in an array, but its address can: below 2^53 a float holds it exactly. So one wrapper
is compiled once for all models, as a loop is.
"""

from typing import Any

from numba import config, types
from numba.core import cgutils
from numba.extending import intrinsic

from fric.kernels.signatures import STEP_FUNCTION, Step

proxy: Any = cgutils.create_struct_proxy
null: Any = cgutils.get_null_value

_PLAINLY: bool = getattr(config, "DISABLE_JIT")  # noqa: B009 - numba makes its settings at import
_PLAIN: dict[float, Step] = {}  # Steps by their address, where the compiler is switched off by NUMBA_DISABLE_JIT


def address_of(step: Step) -> float:
    """Return the number that represents a compiled step in the parameters of another; valid in this process alone."""
    if _PLAINLY:
        _PLAIN[float(id(step))] = step
        return float(id(step))
    made: Any = step
    return float(made.__wrapper_address__())


@intrinsic
def _step_at(typing: Any, address: Any) -> Any:
    """Return the step at an address, as a first-class function of the C calling convention."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        made = proxy(STEP_FUNCTION)(context, builder)
        pointer = context.get_value_type(types.voidptr)
        number = builder.fptoui(arguments[0], cgutils.intp_t)
        made.c_addr = builder.inttoptr(number, pointer)
        made.py_addr = made.jit_addr = null(pointer)
        return made._getvalue()

    return STEP_FUNCTION(types.float64), generate


step_at: Any = _PLAIN.__getitem__ if _PLAINLY else _step_at  # ``step = step_at(address)`` inside a compiled step
