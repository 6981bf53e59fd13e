"""The target ``xlsx``: parameters, and friction over velocity, as a workbook."""

from fric.export.base import Target
from fric.export.tables import xlsx_files

TARGET = Target("xlsx", "parameters and a table of steady friction as a workbook", xlsx_files)
