"""The paper from end to end on one machine, every step a file: `fric reproduce`."""
