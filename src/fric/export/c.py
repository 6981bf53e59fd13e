"""The target ``c``: C99, one header and one source, in double or in single precision."""

from __future__ import annotations

import inspect
from typing import TYPE_CHECKING, Any

from fric.export.base import LARGEST_ACCELERATION, LARGEST_POSITION, LARGEST_VELOCITY, Files, Part, Target
from fric.export.rendering import identifier, render
from fric.export.translate.c_code import Dialect, c_routines

if TYPE_CHECKING:
    from collections.abc import Callable


def dialect_of(part: Part, *, single: bool = False) -> Dialect:
    """Return how the C of a part is written: every name begins with ``fric_AXIS_``."""
    return Dialect(f"fric_{identifier(part.axis)}_", single)


def values_of(part: Part, number: Callable[[float], str]) -> dict[str, Any]:
    """Return what templates need to know of a part, with numbers as the language writes them."""
    model = part.model
    unit, force_unit = ("rad", "N*m") if part.motion == "rotary" else ("m", "N")
    limits = {"position": LARGEST_POSITION, "velocity": LARGEST_VELOCITY, "acceleration": LARGEST_ACCELERATION}
    return {
        "part": part,
        "model": model,
        "program": part.program,
        "first_line": plain_text(type(model)).partition(". ")[0].rstrip("."),
        "packed": plain_text(model.packed).removeprefix("Return "),
        "unit": unit,
        "force_unit": force_unit,
        "states": max(part.initial_state.size, 1),
        "initial": [number(value) for value in part.initial_state] or [number(0.0)],
        "parameters": [number(value) for value in part.parameters],
        "lead": number(part.lead),
        "T_s": number(1.0 / part.sampling),
        "volts_per_force": number(part.gain / part.K_f),
        "A": number(part.A),
        "B": number(part.B),
        "limits": {name: number(limit) for name, limit in limits.items()} | {"time": number(1.0), "force": number(1e9)},
    }


def plain_text(of: object) -> str:
    """Return the first paragraph of a docstring in one line of ASCII, as comments of any compiler may hold it."""
    first = (inspect.getdoc(of) or "").partition("\n\n")[0].replace("`", "").replace("…", "...")
    return " ".join(first.split()).encode("ascii", "ignore").decode()


def c_values(part: Part, dialect: Dialect) -> dict[str, Any]:
    """Return what the templates of C need to know of a part."""
    return values_of(part, dialect.number) | {
        "routines": c_routines(part.program, dialect),
        "name": dialect.prefix.rstrip("_"),
        "guard": f"{dialect.prefix}h".upper(),
        "prefix": dialect.prefix,
        "real": dialect.real,
        "zero": dialect.number(0.0),
        "half": dialect.number(0.5),
    }


def c_files(part: Part, *, single: bool = False) -> Files:
    """Return header and source of a part."""
    dialect = dialect_of(part, single=single)
    values = c_values(part, dialect)
    return {f"{values['name']}.h": render("axis.h.j2", **values), f"{values['name']}.c": render("axis.c.j2", **values)}


TARGET = Target("c", "C99: one header and one source", c_files, options=frozenset({"single"}))
