"""Prints a hash of the bits of each of 24 circles: two machines, six schemes, two feeds. Run as a process."""

from hashlib import sha256

import numpy as np

from fric.control.scheme import PAPER_SCHEMES
from fric.results.machine import machine_of
from fric.simulate.circle import Circle, run_circle

for name in ("xy-table", "virtual-rig"):
    machine = machine_of("circle", name)
    for feed in (0.1, 0.01):
        for scheme in PAPER_SCHEMES.values():
            run = run_circle(machine, scheme, Circle(feed=feed, revolutions=1))
            bits = b"".join(
                np.ascontiguousarray(values).tobytes()
                for trace in run.traces.values()
                for values in (trace.position, trace.measured, trace.input)
            )
            print(name, feed, scheme.name, sha256(bits).hexdigest())
