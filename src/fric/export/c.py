"""The target ``c``: C99, one header and one source, in double or in single precision."""

import inspect
import re
from collections.abc import Callable
from math import ceil, pi
from typing import Any

from fric.errors import FricError
from fric.export.base import LARGEST, ROLES, ExportedPart, Files, Target, identifier, render
from fric.export.translate.c_code import Dialect, c_routines
from fric.series import CLOSEST
from fric.units import si_unit

SUB_STEPS = 50  # Steps of the exported axis in one period of its controller


def name_of(part: ExportedPart) -> str:
    """Return the names of the files of a part: ``fric_AXIS``, ``fric_AXIS_machine``."""
    return f"fric_{identifier(part.axis)}" + ("_machine" if part.role == "machine" else "")


def values_of(part: ExportedPart, number: Callable[[float], str]) -> dict[str, Any]:
    """Return the data of a part for templates, and `number`, which writes a number in the language's notation."""
    model = part.model
    unit, force_unit, of_input = (si_unit(name, part.motion) for name in ("position", "force", "input"))
    what = f"Friction compensation of axis {part.axis}, scheme {part.scheme}"
    title = what if part.role == "compensation" else f"Axis {part.axis} with its friction"
    first_line = re.split(r"\.(?: (?=[A-Z])|$)", plain_text(type(model)))[0]  # not at "eqs. (3)"
    head = {"title": title, "first_line": first_line, "packed": model.layout.replace("…", "...")}
    units = {"unit": unit, "force_unit": force_unit, "of_input": of_input}
    numbers = {"lead": part.lead, "T_s": 1.0 / part.sampling, "limit": min(part.limit, 1e6)}
    values = {"part": part, "model": model, "name": name_of(part), "prefix": f"{name_of(part)}_"} | head | units
    values |= {name: number(value) for name, value in numbers.items()}
    values |= {"limits": {name: number(limit) for name, limit in LARGEST.items()}, "number": number}
    return values | {"numbers": lambda of: list(map(number, of)), "states": max(part.initial_state.size, 1)}


def plain_text(of: object) -> str:
    """Return the first paragraph of a docstring as a line of ASCII, valid in comments of any compiler."""
    first = (inspect.getdoc(of) or "").partition("\n\n")[0].replace("`", "").replace("…", "...")
    return " ".join(first.split()).encode("ascii", "ignore").decode()


def c_values(part: ExportedPart, *, single: bool = False) -> dict[str, Any]:
    """Return the data of a part for the templates of C."""
    dialect = Dialect(f"{name_of(part)}_", single)
    number = dialect.number
    values = values_of(part, number) | {"routines": c_routines(part.program, dialect), "real": dialect.real}
    values |= {"guard": f"{dialect.prefix}h".upper(), "exp": dialect.function("exp")}
    # positions stay double: rounded, their differences are lost
    values |= {"narrow": f"({dialect.real})" * single, "widen": "(double)" * single}
    numbers = {"zero": 0.0, "half": 0.5, "one": 1.0, "corner": 2 * pi * part.velocity_filter, "shortest": CLOSEST}
    values |= {name: number(value) for name, value in numbers.items()}
    values |= {"sub_steps": SUB_STEPS, "ring": 4 + ceil(SUB_STEPS * (part.delay * part.sampling + 1))}
    pieces = ("declarations", "definitions")
    return values | {piece: render(f"{part.role}_{piece}.c.j2", **values).rstrip() for piece in pieces}


def c_files(part: ExportedPart, *, single: bool = False) -> Files:
    """Return header and source of a part.

    Raises FricError: When an observer is to be in single precision: the coefficients that difference a position twice
        sum to 0, and rounded they leave 0.7 to 7 % of its estimate.
    """
    if single and any(block.kind == "observer" for block in part.blocks):
        what = f"scheme {part.scheme} has an observer, which single precision puts off by 1 % and more"
        raise FricError(what, hint="Export it in double precision; or take a scheme without an observer, as c.")
    values = c_values(part, single=single)
    return {f"{values['name']}{end}": render(f"source{end}.j2", **values) for end in (".h", ".c")}


TARGET = Target("c", "C99: one header and one source", c_files, options=frozenset({"single"}), parts=ROLES)
