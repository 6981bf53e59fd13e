"""The target ``csv``: parameters, and friction over velocity, as text."""

from fric.export.base import Target
from fric.export.tables import csv_files

TARGET = Target("csv", "parameters and a table of steady friction as text", csv_files)
