"""Motions that are asked of a drive: circles, sines, constant-velocity strokes, multisines."""
