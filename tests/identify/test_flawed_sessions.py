"""Sessions by a simulator without code of fric, each with one flaw: intervals hold the truth, or the flaw is said."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline
from scipy.signal import lfilter

import fric
from fric import FricError
from fric.log import Log
from tests.chance import fewest
from tests.identify import plain_session
from tests.identify.plain_session import Axis

Array = NDArray[np.float64]
LATE = 0.3e-3
Spoiled = Callable[[Log, Axis, np.random.Generator], Log]


def late(log: Log, axis: Axis, rng: np.random.Generator) -> Log:
    """Log the force half a millisecond late."""
    t = log.time
    return replace(log, force=np.interp(t - 0.5e-3, t, log.force), input=log.input)


def filtered(log: Log, axis: Axis, rng: np.random.Generator) -> Log:
    """Filter the force at 200 Hz, by a first order."""
    pole = float(np.exp(-2 * np.pi * 200.0 * np.median(np.diff(log.time))))
    return replace(log, force=lfilter([1 - pole], [1, -pole], log.force, zi=[pole * log.force[0]])[0])


def coarse(log: Log, axis: Axis, rng: np.random.Generator) -> Log:
    """Round the force to a twentieth of F_c."""
    step = axis.F_c / 20
    return replace(log, force=np.rint(log.force / step) * step)


def loud(log: Log, axis: Axis, rng: np.random.Generator) -> Log:
    """Add noise of 5 % of F_c, correlated over ten samples, to the force."""
    return replace(log, force=log.force + 0.05 * axis.F_c * lfilter([0.44], [1, -0.9], rng.standard_normal(len(log))))


def jittered(log: Log, axis: Axis, rng: np.random.Generator) -> Log:
    """Stamp samples with a jitter of a tenth of their interval."""
    dt = float(np.median(np.diff(log.time)))
    return replace(log, time=log.time + 0.1 * dt * rng.uniform(-1, 1, len(log)))


def lossy(log: Log, axis: Axis, rng: np.random.Generator) -> Log:
    """Lose a hundredth of the samples, as the time shows."""
    keep = rng.uniform(size=len(log)) > 0.01
    return replace(log, **{"time": log.time[keep]} | {name: one[keep] for name, one in log.channels().items()})


def skewed(log: Log, axis: Axis, rng: np.random.Generator) -> Log:
    """Log the position 0.3 ms late."""
    return replace(log, position=CubicSpline(log.time, log.position)(np.maximum(log.time - LATE, log.time[0])))


def interpolated(log: Log, axis: Axis, rng: np.random.Generator) -> Log:
    """Let the encoder interpolate a period of 20 µm to 0.1 µm."""
    return replace(log, position=log.position + 0.1e-6 * np.sin(2 * np.pi * log.position / 20e-6))


def scaled(log: Log, axis: Axis, rng: np.random.Generator) -> Log:
    """Let the force drift by 5 % within a record."""
    return replace(log, force=log.force * (1.0 + 0.05 * np.linspace(-1, 1, len(log))))


def varied(log: Log, axis: Axis, rng: np.random.Generator) -> Log:
    """Let friction have a level of each record, by 3 %."""
    return replace(log, force=log.force * (1.0 + 0.03 * rng.standard_normal()))


SPOILED: dict[str, Spoiled] = {
    one.__name__: one  # type: ignore[attr-defined]
    for one in (late, filtered, coarse, loud, jittered, lossy, skewed, interpolated, scaled, varied)
}
NEAR = 1e-3
"""Share within which an estimate counts as the truth, which is that of an axis in steps of a sixteenth of a sample."""
DRIFTS = {"ageing": 2e-3, "warming": -1e-3}
"""Changes of friction in strokes, by a second."""
FLAWS = (*SPOILED, *DRIFTS, *plain_session.LAWS[1:])


def judged(flaw: str, seed: int) -> dict[str, tuple[bool, bool]]:
    """Return of each parameter whether its interval holds the truth, and whether its result has a warning."""
    rng = np.random.default_rng([seed, 94])
    axis = plain_session.drawn(rng, flaw if flaw in plain_session.LAWS else "gms")
    records = dict(plain_session.session(axis, rng))
    if flaw in DRIFTS:
        records["static"] = plain_session.strokes(axis, rng, DRIFTS[flaw])
    if flaw in SPOILED:
        clean = "plant" if flaw == "varied" else ""  # of one record, no level is seen
        for part in {*records} - {clean}:
            records[part] = [SPOILED[flaw](log, axis, rng) for log in records[part]]
    truth = axis.truth
    truth["T_d"] += LATE if flaw == "skewed" else 0.0  # the response's delay is that of its log
    plant = fric.identify_plant(*records["plant"])
    static = fric.identify_static(*records["static"], plant=plant)
    results = [(plant, ("A", "T_d", "K_f")), (static, ("F_c", "F_s", "v_s"))]
    with suppress(FricError):  # as where the clock is too uneven to replay
        results.append((fric.identify_gms(*records["gms"], static=static, plant=plant), ("C",)))
    found: dict[str, tuple[bool, bool]] = {}
    for one, names in results:
        said = any(notice.severity != "note" for of in (plant, one) for notice in of.warnings)
        for name in names:
            interval = getattr(one, name).ci95 if name in truth else None
            if interval is not None:
                low, high = (x if x is not None else sign * np.inf for x, sign in zip(interval, (-1, 1), strict=True))
                near = abs(float(getattr(one, name)) / truth[name] - 1.0) < NEAR
                found[name] = bool(near or low <= truth[name] <= high), said
    return found


@pytest.mark.long(300)
@pytest.mark.parametrize("seeds", [range(2), range(2, 4), range(4, 6)])
def test_intervals_of_sessions_with_one_flaw_hold_or_the_flaw_is_said(seeds: range) -> None:
    """Of 94, A was held in 90 %, T_d in 89, F_c in 83, F_s in 74, v_s in 86, C in 72 %: those that miss are said.

    Fails in under one of a thousand for each parameter where 93 % are held or said (`tests/chance.py`).
    """
    good: dict[str, list[bool]] = {}
    for flaw in FLAWS:
        for seed in seeds:
            for name, (held, said) in judged(flaw, seed).items():
                good.setdefault(name, []).append(held or said)
    assert all(sum(one) >= fewest(len(one), 0.93) for one in good.values()), good
