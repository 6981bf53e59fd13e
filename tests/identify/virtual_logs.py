"""Logs that a friction model made of itself, with noise on the force."""

import numpy as np

from fric.log import Log

MOTIONS = {"small": (5e-6, 0.2, 2, 2e-2), "large": (300e-6, 0.2, 2, 2e-2), "fast": (3e-3, 1.0, 1, 1e-3)}
"""Amplitude [m], frequency [Hz], cycles and sampling [s]: pre-sliding, into sliding, and fast sliding."""


def logs_of(model, seed, noise=1.0, motions=tuple(MOTIONS)):
    """Return a record for each motion, of two sines each, so that there are minor loops."""
    rng = np.random.default_rng(seed)
    logs = []
    for name in motions:
        amplitude, frequency, cycles, dt = MOTIONS[name]
        time, omega = np.arange(0.0, cycles / frequency, dt), 2 * np.pi * frequency
        position = amplitude * (np.sin(omega * time) + 0.3 * np.sin(3.1 * omega * time))
        velocity = amplitude * omega * (np.cos(omega * time) + 0.93 * np.cos(3.1 * omega * time))
        force = model.replay(time, position, velocity) + noise * rng.normal(size=time.size)
        logs.append(Log(time=time, position=position, force=force, name=name))
    return logs
