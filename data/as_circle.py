"""Write a circle of a machine as its controller records it: python data/as_circle.py MACHINE.yaml CIRCLE.h5."""

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np

import fric
from fric.circles.measured import AxisTrace, measured_from_run
from fric.io.circle import write_circles

DIGITS = {"time": 9, "reference": 10, "position": 10, "input": 6}
"""Digits behind the point that are recorded of each channel [SI]."""

(run,) = fric.circle(sys.argv[1], "a", revolutions=2).runs
test = measured_from_run(run)
axes = {
    name: AxisTrace(**{key: np.round(one, DIGITS[key]) for key, one in trace.channels().items()})
    for name, trace in test.axes.items()
}
write_circles(Path(sys.argv[2]), [replace(test, name="circle", axes=axes)], force=True)
