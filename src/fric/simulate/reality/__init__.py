"""Flaws that real drives have and the models do not: simulated in logs and circles, never believed by a controller."""
