"""Figures, one function each; all share the look of `fric.figures.style`."""
