"""The intervals that planned experiments will give: the identification itself, on records simulated at the prior.

What the records tell is the Fisher information of the fits that will read them: the same records, residuals, weights
and models. They are simulated once on the axis as it is known beforehand, logged several times with noise of other
seeds, and identified each time; what is told is the geometric mean of the half-widths.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from fric.errors import FricError
from fric.notice import Notice
from fric.planning.choose import Expected, Planned
from fric.results.base import Identified
from fric.results.gms import identify_gms
from fric.results.plant import identify_plant
from fric.results.static import identify_static
from fric.simulate.trial import runs_of

if TYPE_CHECKING:
    from fric.log import Log
    from fric.results.given import Advance
    from fric.simulate.machine import Axis

DRAWS = 8
"""Logs of one run that are identified: the half-widths of single ones scatter by a quarter."""

SETTLED = 2.0
"""Quotient of the half-widths of draws, largest over smallest, from which on an expectation is called uncertain."""


@dataclass(frozen=True)
class Expectation:
    """What planned records tell of an axis.

    Parameters
    ----------
    parameters
        By name, ``k_2`` being that of the second block.
    blocks
        Number of slip blocks that the identification finds; None where there is no GMS model.
    notices
        What cannot be expected of these records.
    """

    parameters: Mapping[str, Expected]
    blocks: int | None
    notices: tuple[Notice, ...]


def identified(logs: Sequence[Log], blocks: int | str = "auto") -> Iterator[Identified]:
    """Yield plant, static map and GMS model of the records of one axis, each as far as there are records for it."""
    plant = static = None
    kinds = {log.kind for log in logs}
    if "frequency-response" in kinds:
        plant = identify_plant(*(log for log in logs if log.kind == "frequency-response"))
        yield plant
    if "constant-velocity" in kinds:
        static = identify_static(*(log for log in logs if log.kind == "constant-velocity"), plant=plant)
        yield static
    sines = [log for log in logs if log.kind in {"presliding-sine", "sliding-sine"}]
    if "presliding-sine" in kinds:
        yield identify_gms(*sines, static=static, plant=plant, blocks=blocks)


def half_widths(results: Sequence[Identified]) -> dict[str, tuple[float, float, str]]:
    """Return value, half the width of the 95 % interval (infinite where it is open) and unit by parameter, in SI."""
    found = {}
    for result in results:
        for (_, name), value, low, high, unit, _ in result.to_frame().itertuples():
            if not np.isnan(low):
                found[str(name)] = (float(value), 0.5 * float(high - low), str(unit))
    return found


def expected(axis: Axis, planned: Sequence[Planned], advance: Advance, draws: int = DRAWS) -> Expectation:
    """Return the intervals that planned records of an axis will give.

    Parameters
    ----------
    axis
        The axis as it is known beforehand, with the noise and the encoder of its logs.
    planned
        The experiments.
    advance
        Is told of each record that was simulated, and of each identification.
    draws
        Logs of the one run that are identified.
    """
    trials = [trial for one in planned for trial in one.trials(axis)]
    runs = []
    for pair in runs_of(axis, trials):
        runs.append(pair)
        advance()
    blocks: int | None = None
    found: list[dict[str, tuple[float, float, str]]] = []
    notices: list[Notice] = []
    for seed in range(1, draws + 1):
        logs = [trial.log(axis, run, seed) for trial, run in runs]
        results: list[Any] = []
        try:
            for result in identified(logs, blocks or "auto"):
                results.append(result)
        except FricError as error:
            notices.append(Notice(f"of these records no more can be identified: {error.what}", "plan-not-enough"))
        if blocks is None and results and "gms" in results[-1].document:
            blocks = len(results[-1].document["gms"]["k"]["value"])
        found.append(half_widths(results))
        advance()
    shared = [name for name in found[0] if all(name in one for one in found)]
    parameters, scattered = {}, []
    for name in shared:
        values, half, units = zip(*(one[name] for one in found), strict=True)
        parameters[name] = Expected(float(np.mean(values)), float(np.exp(np.mean(np.log(half)))), units[0])
        if max(half) > SETTLED * min(half):
            scattered.append(name)
    if scattered:
        text = (
            f"the intervals of {', '.join(scattered)} differ by more than a factor of {SETTLED:g} from draw to draw of "
            "the noise: what is expected is their geometric mean"
        )
        notices.append(Notice(text, "plan-uncertain", "note"))
    return Expectation(parameters, blocks, tuple(dict.fromkeys(notices)))
