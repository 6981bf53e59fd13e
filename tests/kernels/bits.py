"""Prints a hash of the bits of each of 24 circles: two machines, six schemes, two feeds; and a GMS model as filed.

Run as a process. The intervals of the model hang on records that are made again in closed loop. `bits.py few` prints
those of two circles alone.
"""

import sys
from collections.abc import Iterator
from hashlib import sha256
from pathlib import Path

import numpy as np

import fric
from fric.control.scheme import PAPER_SCHEMES
from fric.estimate import as_filed
from fric.results.given_models import machine_of
from fric.simulate.contour_run import Circle, run_circle

FEW = (("virtual-rig",), "f")
ALL = (("xy-table", "virtual-rig"), "abcdef")


def circles(machines: tuple[str, ...], schemes: str) -> Iterator[str]:
    """Yield machine, feed, scheme and hash of each circle."""
    for name in machines:
        machine = machine_of(name)
        for feed in (0.1, 0.01):
            for scheme in schemes:
                run = run_circle(machine, PAPER_SCHEMES[scheme], Circle(feed=feed, revolutions=1))
                bits = b"".join(
                    np.ascontiguousarray(values).tobytes()
                    for trace in run.traces.values()
                    for values in (trace.position, trace.measured, trace.input)
                )
                yield f"{name} {feed} {scheme} {sha256(bits).hexdigest()}"


def gms() -> str:
    """Return a GMS model as its file holds it."""
    data = Path(__file__).parents[2] / "data"
    plant = fric.identify_plant(data / "frequency-response.h5")
    static = fric.identify_static(data / "constant-velocity.h5", plant=plant)
    found = fric.identify_gms(data / "presliding-sine.h5", static=static, plant=plant, blocks=3)
    return str(as_filed(found.document["gms"]))


if __name__ == "__main__":
    few = sys.argv[1:] == ["few"]
    print(*circles(*(FEW if few else ALL)), sep="\n")
    if not few:
        print(gms())
