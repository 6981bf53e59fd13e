"""The target ``st``: structured text of IEC 61131-3, functions and one function block."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, cast

from fric.export.base import Files, Part, Target
from fric.export.c import values_of
from fric.export.rendering import identifier, render
from fric.export.translate.st_code import st_number, st_routines

if TYPE_CHECKING:
    from collections.abc import Mapping


def st_files(part: Part) -> Files:
    """Return the function block of a part, and the functions that it calls, in one file."""
    name = f"fric_{identifier(part.axis)}"
    values: Mapping[str, Any] = values_of(part, st_number)
    routines = st_routines(part.program, f"{name}_")
    made = render("axis.st.j2", **values, name=name, prefix=f"{name}_", routines=routines)
    return {f"{name}.st": cast(str, made)}


TARGET = Target("st", "structured text of IEC 61131-3: one function block", st_files)
