"""Prints a hash of the bits of each of 24 circles: two machines, six schemes, two feeds; and a GMS model as filed.

Run as a process. The intervals of the model hang on records that are made again in closed loop.
"""

from hashlib import sha256
from pathlib import Path

import numpy as np

import fric
from fric.control.scheme import PAPER_SCHEMES
from fric.estimate import as_filed
from fric.results.given_models import machine_of
from fric.simulate.circle import Circle, run_circle

for name in ("xy-table", "virtual-rig"):
    machine = machine_of(name)
    for feed in (0.1, 0.01):
        for scheme in PAPER_SCHEMES.values():
            run = run_circle(machine, scheme, Circle(feed=feed, revolutions=1))
            bits = b"".join(
                np.ascontiguousarray(values).tobytes()
                for trace in run.traces.values()
                for values in (trace.position, trace.measured, trace.input)
            )
            print(name, feed, scheme.name, sha256(bits).hexdigest())

data = Path(__file__).parents[2] / "data"
plant = fric.identify_plant(data / "frequency-response.h5")
static = fric.identify_static(data / "constant-velocity.h5", plant=plant)
print(as_filed(fric.identify_gms(data / "presliding-sine.h5", static=static, plant=plant, blocks=3).document["gms"]))
