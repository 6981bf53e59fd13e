"""The target ``st``: structured text of IEC 61131-3, functions and one function block."""

from fric.export.base import ExportedPart, Files, Target, render
from fric.export.c import values_of
from fric.export.translate.st_code import st_number, st_routines


def st_files(part: ExportedPart) -> Files:
    """Return the function block of a part, and the functions that it calls, in one file."""
    values = values_of(part, st_number)
    routines = st_routines(part.program, values["prefix"])
    return {f"{values['name']}.st": render("compensation.st.j2", **values, routines=routines)}


TARGET = Target("st", "structured text of IEC 61131-3: one function block", st_files)
