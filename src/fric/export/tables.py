"""The targets ``csv``, ``mat`` and ``xlsx``: parameters and tables for manual entry."""

import csv
import io
import re
import zipfile
from typing import Any

import numpy as np

from fric.errors import FricError
from fric.export.base import ExportedPart, Files, Target, friction_values
from fric.export.c import name_of
from fric.units import si_unit

SPEEDS = 61
"""Speeds of the table of steady friction, both directions and rest."""


def parameter_rows(part: ExportedPart) -> list[tuple[str, str, float, str]]:
    """Return section, name, value and unit of each parameter, with a row for each block."""
    rows: list[tuple[str, str, float, str]] = [
        ("axis", "K_f", part.K_f, "N/V"), ("axis", "A", part.A, "1/s"), ("axis", "B", part.B, "m/(s^2*V)"),
        ("feedforward", "gain", part.gain, "1"), ("feedforward", "lead", part.lead, "s"),
        ("controller", "sampling", part.sampling, "Hz"), ("controller", "limit", part.limit, "V"),
    ]  # fmt: skip
    for section, values in friction_values(part.model, part.motion).items():
        for name, quantity in values.items() if isinstance(values, dict) else ():
            listed = quantity["value"] if isinstance(quantity["value"], list) else [quantity["value"]]
            for n, value in enumerate(listed):
                label = f"{name}_{n + 1}" if isinstance(quantity["value"], list) else name
                rows.append((section, label, float(value), quantity["unit"]))
    return rows


def steady_table(part: ExportedPart) -> np.ndarray[Any, Any]:
    """Return velocity [m/s], friction [N] and feedforward [V] in steady motion, shape (n, 3)."""
    fast = np.geomspace(1e-5, 0.5, SPEEDS // 2)
    v = np.concatenate([-fast[::-1], [0.0], fast])
    force = np.asarray(part.model.steady_state(v), float)
    return np.column_stack([v, force, part.gain * force / part.K_f])


def csv_files(part: ExportedPart) -> Files:
    """Return two texts: the parameters, and friction over velocity."""
    parameters, table = io.StringIO(), io.StringIO()
    writer = csv.writer(parameters, lineterminator="\n")
    writer.writerow(["section", "parameter", "value", "unit"])
    writer.writerows([section, name, repr(value), unit] for section, name, value, unit in parameter_rows(part))
    writer = csv.writer(table, lineterminator="\n")
    unit, force = (si_unit(name, part.motion) for name in ("position", "force"))
    writer.writerow([f"velocity [{unit}/s]", f"friction [{force}]", "feedforward [V]"])
    writer.writerows([repr(float(value)) for value in row] for row in steady_table(part))
    return {f"{name_of(part)}-parameters.csv": parameters.getvalue(), f"{name_of(part)}-steady.csv": table.getvalue()}


def mat_files(part: ExportedPart) -> Files:
    """Return a MATLAB v5 file: a struct of parameters in SI, and the table of steady friction."""
    from scipy.io import savemat

    sections: dict[str, dict[str, Any]] = {}
    for section, name, value, _ in parameter_rows(part):
        sections.setdefault(section, {})[name] = value
    for section, values in friction_values(part.model, part.motion).items():
        for name, quantity in values.items() if isinstance(values, dict) else ():
            if isinstance(quantity["value"], list):
                sections[section][name] = np.asarray(quantity["value"], float)
    packed = io.BytesIO()
    writable: Any = packed
    savemat(writable, {"fric": sections | {"steady": steady_table(part)}}, long_field_names=True)
    data = packed.getvalue()
    head = b"MATLAB 5.0 MAT-file, made by fric"
    return {f"{name_of(part)}.mat": head + b" " * (116 - len(head)) + data[116:]}  # the date is not of the content


def xlsx_files(part: ExportedPart) -> Files:
    """Return a workbook of two sheets: the parameters, and friction over velocity.

    Raises FricError: When openpyxl is not installed.
    """
    try:
        from openpyxl import Workbook
    except ImportError:
        raise FricError("a workbook needs openpyxl", hint="pip install 'fric[xlsx]'.") from None
    book = Workbook()
    sheet = book.active
    assert sheet is not None
    sheet.title = "parameters"
    sheet.append(["section", "parameter", "value", "unit"])
    for row in parameter_rows(part):
        sheet.append(list(row))
    steady = book.create_sheet("steady friction")
    steady.append(["velocity [m/s]", "friction [N]", "feedforward [V]"])
    for values in steady_table(part).tolist():
        steady.append(values)
    packed = io.BytesIO()
    book.save(packed)
    return {f"{name_of(part)}.xlsx": _undated(packed)}


def _undated(workbook: io.BytesIO) -> bytes:
    """Return a workbook without a time stamp: equal content gives equal bytes."""
    made = io.BytesIO()
    with zipfile.ZipFile(workbook) as dated, zipfile.ZipFile(made, "w", zipfile.ZIP_DEFLATED) as archive:
        for name in dated.namelist():
            content = re.sub(rb"\d{4}-\d\d-\d\dT\d\d:\d\d:\d\dZ", b"1980-01-01T00:00:00Z", dated.read(name))
            archive.writestr(zipfile.ZipInfo(name, (1980, 1, 1, 0, 0, 0)), content)
    return made.getvalue()


CSV = Target("csv", "parameters and a table of steady friction as text", csv_files)
MAT = Target("mat", "parameters and a table of steady friction for MATLAB", mat_files)
XLSX = Target("xlsx", "parameters and a table of steady friction as a workbook", xlsx_files)
