"""Prediction and measurement of a circle by a machine file, and the causes of their difference."""

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass
from math import log
from typing import Any

import numpy as np

from fric.circles.diagnose import Diagnosis, diagnose
from fric.circles.glitches import Glitch, GlitchPulse, smoothed
from fric.circles.measured import measured_from_run
from fric.contour import QUADRANTS, of_axes
from fric.control.scheme import Scheme
from fric.flaws.circle import MODEL_DISAGREES, PREDICTION_WITHOUT_INTERVAL
from fric.notice import Notice
from fric.simulate.circle import Circle, run_circle
from fric.simulate.machine import Machine
from fric.simulate.monte_carlo import Study

DRAWS = 24  # Machines that are drawn from the intervals of a machine file
CAUSES = {
    "level": "the level: K_f, the level of friction or a gain differs",
    "width": "the width: the stiffness before sliding differs",
    "place": "the place: the delay differs",
    "sign": "the sign: gravity, or the direction of the axis",
}
"""The sentence of a disagreement, by what differs."""


@dataclass(frozen=True)
class Agreement:
    """A prediction compared with the measurement."""

    predicted: Diagnosis  # The diagnosis of the simulated circle
    # 95 % interval of the predicted glitch of each quadrant [m]; None where the machine file has no intervals
    intervals: Mapping[str, tuple[float, float]] | None
    agrees: Mapping[str, bool]  # By quadrant of an axis that is known, whether measured and predicted intervals meet
    causes: Mapping[str, str]  # By quadrant that does not agree, a key of `CAUSES`
    scheme: str  # The scheme that was simulated
    warnings: tuple[Notice, ...]  # Warnings

    @property
    def all_agree(self) -> bool:
        """Whether every quadrant agrees."""
        return all(self.agrees.values())


def predict(
    measured: Diagnosis,
    machine: Machine,
    scheme: Scheme,
    known: Mapping[str, Any] | None = None,
    done: Callable[[], object] = lambda: None,
) -> tuple[Diagnosis, dict[str, tuple[float, float]] | None]:
    """Return the prediction of a machine for the measured circle, with the range of its glitches.

    The interval is that of machines drawn from the uncertainty of the identified machine, widened by an encoder step.

    known: The distribution of machines, as arguments of `Study`; None if the machine file has no intervals.
    Raises FricError: When the machine cannot run the circle.
    """
    test = measured.test
    circle = Circle(test.radius, test.feed, 2, test.direction)
    run = run_circle(machine, scheme, circle)
    found = diagnose([measured_from_run(run)])
    done()
    if not known:
        return found, None
    study, drawn = Study(machine, (scheme,), circle, accuracy=1e-8, **known), []
    for n in range(DRAWS):
        quadrants = study(n).quadrants[0]
        if np.isfinite(quadrants).all():  # else it is not stable, or needs more voltage than there is
            drawn.append(quadrants)
        done()
    if len(drawn) < DRAWS // 2:
        return found, None
    around = np.quantile(np.array(drawn), [0.025, 0.975], axis=0) - np.array(run.circularity.quadrants)
    # quantiles of so few draws lie too near: a tenth of their distance is added to either side
    around += np.outer([-0.1, 0.1], np.ptp(around, axis=0))
    step = max(machine.axes[name].encoder.resolution for name in run.traces)
    limits = {
        name: (found.glitches[name].value + min(float(low), 0.0) - step,
               found.glitches[name].value + max(float(high), 0.0) + step)
        for name, low, high in zip(QUADRANTS, *around, strict=True)
    }  # fmt: skip
    return found, limits


def circles_to_predict(known: Mapping[str, Any] | None) -> int:
    """Return how many circles `predict` runs; for a progress bar."""
    return 1 + (DRAWS if known else 0)


def agreement(
    measured: Diagnosis, predicted: Diagnosis, intervals: Mapping[str, tuple[float, float]] | None, scheme: str,
    step: float = 0.0, known: Collection[str] = ("x", "y"),
) -> Agreement:  # fmt: skip
    """Compare a prediction with the measurement, quadrant by quadrant, and name the likely cause of a difference.

    intervals: Interval of each predicted glitch [m]; None where there is none.
    step: An encoder step [m], the tolerance of a prediction without interval.
    known: Names of the machine's axes: reversals of other axes are not predicted.
    """
    agrees, causes = {}, {}
    pulses, other = measured.pulses(), predicted.pulses()
    for name in of_axes(measured.test.names, known):
        found, said = measured.glitches[name], predicted.glitches[name]
        low, high = intervals[name] if intervals else (said.ci95[0] - step, said.ci95[1] + step)
        agrees[name] = found.ci95[0] <= high and found.ci95[1] >= low
        if not agrees[name]:
            causes[name] = _cause(found, said, pulses[name], other[name])
    warnings = []
    if intervals is None:
        warnings.append(PREDICTION_WITHOUT_INTERVAL.found())
    if causes:
        words = "; ".join(
            f"{name} {measured.glitches[name].value * 1e6:+.1f} µm measured, "
            f"{predicted.glitches[name].value * 1e6:+.1f} µm predicted ({CAUSES[cause]})"
            for name, cause in causes.items()
        )
        warnings.append(MODEL_DISAGREES.found(glitches=words))
    return Agreement(predicted, intervals, agrees, causes, scheme, tuple(warnings))


def _cause(found: Glitch, said: Glitch, pulse: GlitchPulse, other: GlitchPulse) -> str:
    """Return what differs most between two pulses: sign, level, width or place.

    The measured pulse is written as ``g·p((φ - d)/w)`` of the predicted p, and the largest of |ln g|, |ln w| and the
    shift in half widths is named.
    """
    small, large = sorted(map(abs, (found.value, said.value)))
    if found.value * said.value < 0 and small > 0.25 * large:
        return "sign"
    width = np.radians(0.5)
    grid = np.radians(np.arange(-10.0, 30.0, 0.25))
    seen, said_at = np.interp(grid, *smoothed(pulse, width)), smoothed(other, width)
    best = (np.inf, 1.0, 1.0, 0.0)
    phi, mean = said_at
    top = int(np.argmax(np.abs(mean)))
    below = np.flatnonzero(np.abs(mean) <= np.abs(mean[top]) / 2)
    left, right = below[below < top].max(initial=-1) + 1, below[below > top].min(initial=len(mean)) - 1
    half = max(np.radians(1.0), float(phi[right] - phi[left]))
    for w in np.geomspace(0.3, 3.0, 25):
        for d in np.linspace(-1.5, 1.5, 25) * half:
            p = np.interp((grid - d) / w, *said_at, left=0.0, right=0.0)
            power = float(p @ p)
            g = float(p @ seen) / power if power > 0 else 0.0
            cost = float(np.sum((seen - g * p) ** 2)) * (1 + 1e-3 * (log(w) ** 2 + (d / half) ** 2))
            best = min(best, (cost, g, w, d / half), key=lambda one: one[0])
    _, g, w, d = best
    sizes = {"level": abs(log(max(abs(g), 1e-3))), "width": abs(log(w)), "place": abs(d)}
    return max(sizes, key=lambda name: sizes[name])
