"""Whether the loop of a tuned axis holds its falling friction, and one that does."""

from collections.abc import Iterator, Mapping
from dataclasses import replace

from fric.circles.tuned import TunedAxis
from fric.design.falling import falling_margin, hold_falling
from fric.flaws import circle
from fric.friction.directed import Directed
from fric.friction.gms import GMS
from fric.notice import Notice

GROWS = 0.8
"""Margin of the falling branch below which a loop is designed anew: with more, errors grow by less than e² as an axis
passes at 10 mm/s, and stiffer gains would cost as much in encoder counts."""

UNHELD, CAUTION, LEAST = 0.9, 0.09, 0.97
"""Margin below which less than the whole friction is fed forward, how much less for each margin that is missing, and
what is fed forward at least. An axis that is pushed ahead of its friction runs away from it, one that lags sticks: of
46 machines of 200 that lack margin, exact knowledge leaves 11 to 13 with more than 1.1 µm at 10 mm/s, and 4 to 6 with a
tenth less for each margin missing. That costs 0.1 µm at 100 mm/s with an observer, 0.3 without."""


def _margin(one: TunedAxis) -> float:
    axis = one.axis
    blocks = () if axis.observer is None else (axis.observer,)
    return falling_margin(one.nominal, axis.cascade, _gms(one), blocks)


def _gms(one: TunedAxis) -> GMS:
    model = one.friction.model if isinstance(one.friction, Directed) else one.friction
    assert isinstance(model, GMS)  # what circles tune
    return model


def holds(one: TunedAxis) -> bool:
    """Return whether the loop of a tuned axis holds its falling friction."""
    return _margin(one) >= GROWS


def cautious(one: TunedAxis) -> TunedAxis:
    """Return a tuned axis that is fed forward less than its friction where that falls more than the loop holds."""
    if not one.improves or (missing := UNHELD - _margin(one)) <= 0.0:
        return one
    fed = replace(one.axis.nominal_friction, gain=round(max(1.0 - CAUTION * missing, LEAST), 4))
    return replace(one, axis=replace(one.axis, nominal_friction=fed))


def holding(one: TunedAxis) -> TunedAxis:
    """Return a tuned axis whose cascade and observer hold its falling friction; as it is, where they do."""
    if not one.improves or holds(one):
        return one
    cascade, observer = hold_falling(one.nominal, one.axis.cascade, _gms(one), one.axis.observer)
    return replace(one, axis=replace(one.axis, cascade=cascade, observer=observer), loop=True)


def loop_warnings(axes: Mapping[str, TunedAxis]) -> Iterator[Notice]:
    """Yield which axes' loops do not hold their falling friction, and which were designed anew for it."""
    for name, one in axes.items():
        if not one.improves:
            continue
        cascade, margin, fed = one.axis.cascade, _margin(one), one.axis.nominal_friction.gain
        if one.loop:
            observer = None if one.axis.observer is None else one.axis.observer.q.cutoff
            gains = {"K_p": cascade.K_p, "K_i": cascade.K_i, "K_v": cascade.K_v, "filter": cascade.velocity_filter}
            share = 0.0 if fed == 1.0 else fed
            yield circle.LOOP_DESIGNED.found(f"axis {name}", margin=margin, observer=observer, fed=share, **gains)
        elif margin < UNHELD:
            yield circle.FALLING_FRICTION.found(f"axis {name}", margin=margin, fed=fed, design=margin < GROWS)
