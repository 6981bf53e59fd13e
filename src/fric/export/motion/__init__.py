"""Planned motions as controllers run them: G-code in three dialects, tables in structured text and CSV."""

from fric.export.motion.base import Arc, Dialect, Move
from fric.export.motion.csv import CSV
from fric.export.motion.gcode import FANUC, LINUXCNC, SIEMENS
from fric.export.motion.table import TABLE

DIALECTS: dict[str, Dialect] = {one.name: one for one in (LINUXCNC, FANUC, SIEMENS, TABLE, CSV)}
"""The dialects by name."""

__all__ = ["DIALECTS", "Arc", "Dialect", "Move"]
