"""Experiments before they are made: which records tell an axis's friction, inside stroke, speed and acceleration."""
