"""Bounds that physics sets to what a file holds, and what of a file is held against them."""
