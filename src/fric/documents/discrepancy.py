"""What the files of an axis say of errors beyond their parameters' intervals, as spreads that widen a prediction."""

from collections.abc import Iterator, Mapping, Sequence
from math import inf, pi
from typing import Any

from fric.documents.friction import FrictionDocument
from fric.documents.plant import PlantDocument, PlantPart
from fric.documents.quantity import Quantity
from fric.flaws import flaw_of
from fric.flaws.prediction import INTERVAL_OPEN, PREDICTION_WIDENED
from fric.notice import Notice, once
from fric.simulate.spread import Spread

CROSSED = 50.0
"""Frequency at which a misfit of the response is taken for one of phase [Hz]: about that of a feed drive's loop."""
OPEN = 2.0
"""Factor to either side within which a parameter lies whose interval is open, or does not hold its estimate."""
AT_LEAST = 1e-3
"""Errors under this share are none to speak of."""
FORM: Mapping[str, float] = {"k": 0.1, "alpha": 0.05, "C": 0.2, "v_s": 0.1, "T_d": 0.05, "B": 0.01}
"""What a real axis differs by, at least, from a model of a few blocks and one mass, whatever the intervals."""


def discrepancies(
    friction: FrictionDocument, plant: PlantPart, refused: Sequence[str] = ()
) -> tuple[dict[str, Spread], tuple[Notice, ...]]:
    """Return by what factors the true axis may differ from the parameters of its files besides, and why.

    friction: Its friction file: strokes that scatter, sines at another level than strokes, blocks that miss the virgin
        curve.
    plant: Its plant file: what eq. (1) leaves of the response.
    refused: Parameters whose interval cannot be drawn from.
    """
    shares: dict[str, float] = {}
    reasons: list[Notice] = []
    delay = float(plant.estimates(friction.motion)["T_d"])
    found = [*_of_friction(friction), *_of_plant(plant, delay), *_of_warnings(friction, plant)]
    for name, share in FORM.items():
        shares[name] = share
    for name, share, why in found:
        if share >= AT_LEAST:
            shares[name] = (shares.get(name, 0.0) ** 2 + share**2) ** 0.5
            reasons.append(PREDICTION_WIDENED.found(name=name, share=share, why=why))
    spreads = {name: Spread(1 / (1 + share), 1 + share, "log-normal") for name, share in shares.items()}
    for name in refused:
        if name != "offset":
            spreads[name] = Spread(1 / OPEN, OPEN, "log-normal")
            reasons.append(INTERVAL_OPEN.found(name=name, low=1 / OPEN, high=OPEN))
    return spreads, once(reasons)


Found = Iterator[tuple[str, float, str]]


def _of_friction(friction: FrictionDocument) -> Found:
    static = friction.estimates("static") if friction.static else {}
    fit = friction.fit_of("static")
    level = float(static["F_c"]) if "F_c" in static else 0.0
    if level > 0 and fit.between_strokes is not None:
        why = "strokes of one speed scatter so much beyond their own noise"
        yield "level", 1.96 * _number(fit.between_strokes) / level, why
    elif level > 0 and fit.rmse is not None:
        yield "level", 1.96 * _number(fit.rmse) / level, "the static map misses the strokes by so much"
    if level > 0 and fit.between_records:
        why = "friction differs so much from record to record"
        yield "level", 1.96 * _number(fit.between_records.get("level")), why
    blocks = friction.fit_of("gms")
    if blocks.alpha_sum is not None:
        limits: Any = blocks.alpha_sum.ci95 or [blocks.alpha_sum.value]
        apart = max(abs(float(one) - 1.0) for one in limits if one is not None)
        yield "level", apart, "the sines show another level than the strokes"
    rise = float(static["F_s"]) if "F_s" in static else 0.0
    if rise > 0 and blocks.virgin_curve_rmse is not None:
        share = 1.96 * _number(blocks.virgin_curve_rmse) / rise
        count = max(len(friction.estimates("gms")["alpha"].value), 1) if "alpha" in friction.section("gms") else 1  # type: ignore[arg-type]
        yield "k", 2.0 * share * count, "the blocks miss the virgin curve"
        yield "alpha", share * count, "the blocks miss the virgin curve"


def _of_plant(plant: PlantPart, delay: float) -> Found:
    fit = plant.fit if isinstance(plant, PlantDocument) else None
    if fit is None:
        return
    if fit.misfit is not None:
        share = _number(fit.misfit)
        yield "B", share, "eq. (1) leaves so much of the measured response"
        yield (
            "T_d",
            min(share / (2 * pi * CROSSED * max(delay, 1e-4)), 1.0),
            "eq. (1) leaves so much of the response's phase",
        )
        yield "A", min(3.0 * share, 1.0), "eq. (1) leaves so much of the measured response"
    elif fit.relative_error is not None:
        share = _number(fit.relative_error)
        yield "B", share, "the rigid axis leaves so much of the force of an ordinary motion"
        yield "A", min(3.0 * share, 1.0), "the rigid axis leaves so much of the force of an ordinary motion"
        yield "T_d", 0.3, "an ordinary motion hardly shows the delay"


def _of_warnings(friction: FrictionDocument, plant: PlantPart) -> Found:
    parts = [friction, *([plant] if isinstance(plant, PlantDocument) else [])]
    coded = {notice.code: notice for part in parts for notice in part.notices() if notice.severity != "note"}
    for notice in coded.values():
        for name, share in flaw_of(notice).widens.items():
            yield name, share, str(notice)


def _number(given: Quantity | None) -> float:
    value: Any = None if given is None else given.value
    return float(value) if isinstance(value, int | float) and abs(value) < inf else 0.0
