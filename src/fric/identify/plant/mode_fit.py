"""Eq. (1) alone or with a second mass: which of them a response shows, and which of its lines belong to neither."""

from typing import NamedTuple

import numpy as np

from fric.arrays import Complex, Mask, Real
from fric.choice import simplest
from fric.drive.resonance import Encoder, Resonance
from fric.errors import FricError
from fric.identify.plant.response_fit import UNDETERMINED, Solution, solve
from fric.identify.plant.response_lines import Lines, near
from fric.statistics import robust_deviation

UNLIKE = 0.02
"""Misfit of eq. (1) from which on a second mass is looked for [1]."""

OFF = 6.0
"""Usual residuals from which on a line stands off all others."""

VISIBLE = 0.01
"""Relative residual that a line which stands off has at least."""

MOST = 0.35
"""Share of the lines that may stand off: where more do, it is the model that is wrong."""

ROUGH = 0.03
"""Misfit that is allowed for while the best start is looked for [1]."""

GAIN = 40.0
"""How much less the sum of bounded squared residuals is with a second mass that is taken."""

BELOW = 3.0
"""A second mass's frequency over that of the lowest line, at least: below it, lines show the rigid axis."""


class Found(NamedTuple):
    """A fit and the lines that it was made of."""

    solution: Solution
    kept: Mask
    """Which lines belong to the fit, shape (n,)."""


def solve_with_modes(lines: Lines) -> Found:
    """Fit eq. (1), and with a second mass where the response shows one, without the lines that stand off.

    A line that is not driven, but moved by friction's harmonics, answers like the controller's inverse: it stands off
    what all others lie on. Such lines are left out one form at a time; a second mass is taken where it explains the
    lines better by far, each residual counted up to a bound.

    lines: Lines of one response.
    Raises FricError: When the sign of input or position is turned.
    """
    rigid = _without_outliers(lines, None)
    if rigid.solution.misfit < UNLIKE and np.all(rigid.kept):
        return rigid
    found = _best_mode(lines)
    if found is None:
        return rigid
    scale = max(robust_deviation(_off(lines, found.solution)[found.kept]), 1e-3)
    bounded = [float(np.sum(np.minimum(np.abs(_off(lines, one.solution)) / scale, OFF) ** 2)) for one in (rigid, found)]
    return found if bounded[0] - bounded[1] > GAIN and _is_determined(found.solution, at(lines, found.kept)) else rigid


def _is_determined(solution: Solution, lines: Lines) -> bool:
    """Say whether frequency and ratio of a second mass are told by the lines, and the rigid axis below it as well.

    Friction around rest is a spring, too: of its lowest lines a small motion makes a resonance, at or below them. A
    resonance above all lines is none that was seen: a filter, or a delay that is not whole, bends them alike.
    """
    half, values = solution.half_widths()[3:], solution.values[3:]
    ratio = len(values) < 3 or bool(half[2] < values[2] < 0.99)
    at = float(np.exp(values[0]))
    within = BELOW * float(lines.frequency.min()) <= at <= float(lines.frequency.max())
    return ratio and within and bool(half[0] < 0.1)


def _best_mode(lines: Lines) -> Found | None:
    """Return the best fit with a second mass, of motor and table encoder; None where there are too few lines."""
    if len(lines.frequency) < 10:
        return None
    low, high = float(lines.frequency.min()), float(lines.frequency.max())
    if high < 4 * low:
        return None
    encoders: tuple[Encoder, ...] = ("motor", "table")
    grid = np.geomspace(BELOW * low, 1.2 * high, 24)
    starts = [one for encoder in encoders for one in _starts(lines, encoder, grid)[:2]]
    rough = [solve([lines], resonance=resonance, start=start, misfits=[ROUGH]) for resonance, start in starts]
    if not rough:
        return None
    rough.sort(key=lambda solution: len(solution.values))
    best = rough[simplest(_score(lines, solution) for solution in rough)]
    return _without_outliers(lines, best.form.resonance(best.values), best.values[:3])


def _score(lines: Lines, solution: Solution) -> float:
    """Return the mean of log residuals, which no line that stands off can draw."""
    return float(np.mean(np.log(np.abs(_off(lines, solution)) + 1e-3)))


def _starts(lines: Lines, encoder: Encoder, frequencies: Real) -> list[tuple[Resonance, Real]]:
    """Return second masses by how well eq. (1) explains what they leave, the best first."""
    tried = []
    for frequency in frequencies:
        for ratio in (0.15, 0.4, 0.7) if encoder == "motor" else (UNDETERMINED,):
            resonance = Resonance(float(frequency), ratio, 0.03, encoder)
            without = lines._replace(response=lines.response / resonance.factor(0.0, lines.frequency))
            try:
                start, cost = near(without, 12, 60)
            except FricError:
                continue
            tried.append((cost, resonance, start))
    tried.sort(key=lambda one: one[0])
    return [(resonance, start) for _, resonance, start in tried]


def _without_outliers(lines: Lines, resonance: Resonance | None, start: Real | None = None) -> Found:
    kept = np.ones(len(lines.frequency), bool)
    solution = solve([lines], resonance=resonance, start=start)
    for _ in range(6):
        off = np.abs(_off(lines, solution))
        usual = robust_deviation(off[kept])
        stands = off > np.maximum(OFF * np.hypot(usual, lines.deviation), VISIBLE)
        if np.count_nonzero(stands) > MOST * len(stands) or np.array_equal(~stands, kept):
            break
        kept = ~stands
        start = solution.values[:3]
        again = solution.form.resonance(solution.values)
        solution = solve([at(lines, kept)], resonance=again, start=start)
    return Found(solution, kept)


def _off(lines: Lines, solution: Solution) -> Complex:
    return np.asarray(np.log(lines.response / solution.response(lines.frequency, lines.hold)))


def at(lines: Lines, kept: Mask) -> Lines:
    """Return some of the lines."""
    return lines._replace(
        frequency=lines.frequency[kept], response=lines.response[kept], deviation=lines.deviation[kept]
    )
