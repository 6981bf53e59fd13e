"""Candidates of a verdict, from runs and from the machines that were drawn."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from fric.verdict.evidence import Candidate

if TYPE_CHECKING:
    from fric.simulate.contour_run import ContourRun
    from fric.simulate.monte_carlo import MonteCarlo
    from fric.simulate.prediction import Prediction


def candidates_of(
    runs: Sequence[ContourRun[Any, Any]], many: MonteCarlo | None = None, prediction: Prediction | None = None
) -> list[Candidate]:
    """Return what schemes left of one machine, and on the machines that were drawn."""
    found = []
    for n, run in enumerate(runs):
        found.append(
            Candidate(
                scheme=run.scheme, glitches=tuple(one.median for one in run.glitches), glitch=run.chance().median,
                places=tuple(one.glitch for one in run.places), warnings=run.warnings,
                oscillation=run.chance("oscillation").median,
                drawn=tuple(map(float, many.glitches[:, n])) if many else (),
                swings=tuple(map(float, many.swings[:, n])) if many else (),
                predicted=prediction.schemes.get(run.scheme.name) if prediction else None,
            )
        )  # fmt: skip
    return found
