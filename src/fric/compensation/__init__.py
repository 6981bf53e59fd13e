"""Compensation schemes, one a file: friction feedforward and disturbance observer."""
