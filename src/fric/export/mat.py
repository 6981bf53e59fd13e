"""The target ``mat``: parameters, and friction over velocity, for MATLAB."""

from fric.export.base import Target
from fric.export.tables import mat_files

TARGET = Target("mat", "parameters and a table of steady friction for MATLAB", mat_files)
