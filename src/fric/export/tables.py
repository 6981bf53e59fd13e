"""The targets ``csv``, ``mat`` and ``xlsx``: parameters and tables for manual entry."""

import csv
import io
import re
import zipfile
from collections.abc import Sequence
from typing import Any

import numpy as np

from fric.errors import FricError
from fric.export.base import ExportedPart, Files, Target, archived, axis_values, friction_values
from fric.export.c import name_of
from fric.units import si_unit

SPEEDS = 61  # Speeds of the table of steady friction, both directions and rest
SECTIONS = {"axis": ("K_f", "A", "B"), "feedforward": ("gain", "lead"), "controller": ("sampling", "limit")}
"""Sections of the table of parameters, besides those of friction."""


def parameter_rows(part: ExportedPart) -> list[tuple[str, str, float, str]]:
    """Return section, name, value and unit of each parameter, with a row for each block."""
    known = axis_values(part)
    sections = {section: {name: known[name] for name in names} for section, names in SECTIONS.items()}
    sections |= friction_values(part.model, part.motion)
    rows: list[tuple[str, str, float, str]] = []
    for section, values in sections.items():
        for name, quantity in values.items():
            many = isinstance(quantity["value"], tuple)
            for n, value in enumerate(quantity["value"] if many else [quantity["value"]], 1):
                number = float("inf") if value is None else float(value)
                rows.append((section, f"{name}_{n}" if many else name, number, quantity["unit"]))
    return rows


def steady_table(part: ExportedPart) -> np.ndarray[Any, Any]:
    """Return velocity [m/s], friction [N] and feedforward [V] in steady motion, shape (n, 3)."""
    fast = np.geomspace(1e-5, 0.5, SPEEDS // 2)
    v = np.concatenate([-fast[::-1], [0.0], fast])
    force = np.asarray(part.model.steady_state(v), float)
    return np.column_stack([v, force, part.gain * force / part.K_f])


def sheets(part: ExportedPart) -> dict[str, list[Sequence[Any]]]:
    """Return the rows of both tables with their heads: the parameters, and friction over velocity.

    A value that is open, as a voltage without a limit, is an empty cell.
    """
    unit, force = (si_unit(name, part.motion) for name in ("position", "force"))
    head = (f"velocity [{unit}/s]", f"friction [{force}]", f"feedforward [{si_unit('input', part.motion)}]")
    rows = [(*name, None if value == np.inf else value, unit) for *name, value, unit in parameter_rows(part)]
    parameters = [("section", "parameter", "value", "unit"), *rows]
    return {"parameters": parameters, "steady friction": [head, *steady_table(part).tolist()]}


def csv_files(part: ExportedPart) -> Files:
    """Return a text for each table."""
    files = {}
    for title, rows in sheets(part).items():
        text = io.StringIO()
        csv.writer(text, lineterminator="\n").writerows(rows)
        files[f"{name_of(part)}-{title.partition(' ')[0]}.csv"] = text.getvalue()
    return files


def mat_files(part: ExportedPart) -> Files:
    """Return a MATLAB v5 file: a struct of parameters in SI, and the table of steady friction."""
    from scipy.io import savemat

    sections: dict[str, dict[str, Any]] = {}
    for section, name, value, _ in parameter_rows(part):
        sections.setdefault(section, {})[name] = value
    for section, values in friction_values(part.model, part.motion).items():
        for name, quantity in values.items():
            if isinstance(quantity["value"], tuple):
                sections[section][name] = np.asarray(quantity["value"], float)
    packed: Any = io.BytesIO()
    savemat(packed, {"fric": sections | {"steady": steady_table(part)}}, long_field_names=True)
    head = b"MATLAB 5.0 MAT-file, made by fric".ljust(116)  # the date is not of the content
    return {f"{name_of(part)}.mat": head + packed.getvalue()[116:]}


def xlsx_files(part: ExportedPart) -> Files:
    """Return a workbook with a sheet for each table."""
    try:
        from openpyxl import Workbook
    except ImportError:
        raise FricError("a workbook needs openpyxl", hint="pip install 'fric[xlsx]'.") from None
    book = Workbook()
    for sheet in book.worksheets:
        book.remove(sheet)
    for title, rows in sheets(part).items():
        sheet = book.create_sheet(title)
        for row in rows:
            sheet.append(row)
    packed = io.BytesIO()
    book.save(packed)
    with zipfile.ZipFile(packed) as dated:
        stamp, none = rb"\d{4}-\d\d-\d\dT\d\d:\d\d:\d\dZ", b"1980-01-01T00:00:00Z"
        content = {name: re.sub(stamp, none, dated.read(name)) for name in dated.namelist()}
    return {f"{name_of(part)}.xlsx": archived(content)}


CSV = Target("csv", "parameters and a table of steady friction as text", csv_files)
MAT = Target("mat", "parameters and a table of steady friction for MATLAB", mat_files)
XLSX = Target("xlsx", "parameters and a table of steady friction as a workbook", xlsx_files)
