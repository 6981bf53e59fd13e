"""Compiled loops. This package sees numpy and numba alone."""
