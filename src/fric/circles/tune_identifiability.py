"""What recorded circles cannot tell of friction and plant, and what in them is not as it should be."""

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from fric.circles.measured import MeasuredCircle
from fric.circles.tune_bootstrap import SHAPE, explained
from fric.circles.tune_fit import Fitted, at
from fric.circles.tune_instruments import Instruments
from fric.circles.tuned import TunedEstimates
from fric.circles.voltage import COMPARED
from fric.estimate import Estimate
from fric.flaws import circle
from fric.identify.plant.covariance import hac_covariance
from fric.notice import Notice
from fric.records.energy import CHANGES
from fric.simulate.machine import Axis

APART = 3.0
"""Ratio of the feeds of two circles from which they tell different things."""
LATE = 0.25
"""Relative distance of the delay from the nominal value, from which it is told; its interval must not hold that."""
ALIKE = 0.5
"""Distance of two blocks' slip displacements, in the logarithm, below which they are not told apart: what is left has
several least points there, whose alpha and k differ by up to 20 %."""
HALF_WIDTH = 2.31
"""Half-width of a 95 % interval in standard deviations that a bootstrap of eight draws tells (Student's t)."""
MISFIT = 3.0
"""Times the noise that a result may leave."""


def identifiability_warnings(
    axis: Axis, tests: Sequence[MeasuredCircle], before: Fitted, found: Fitted
) -> Iterator[Notice]:
    """Yield what the circles leave open, and what the fit shows of them.

    axis: The axis as it was nominally.
    tests: The circle tests.
    before, found: What nominal and tuned parameters leave of the voltages.
    """
    where, feeds = f"axis {axis.name}", sorted(test.feed for test in tests)
    if feeds[-1] < APART * feeds[0]:
        missing = (
            "delay, inertia and how friction falls with speed above it (T_d may be off by half)"
            if feeds[-1] < 0.03
            else "v_s, delta, C and the weakest blocks, which show where a reversal is slow"
        )
        yield circle.ONE_FEED.found(where, feed=Estimate(feeds[-1], "m/s"), missing=missing)
    noise = found.noise()
    # what the encoder's counts add repeats from turn to turn, and is no misfit
    if noise is not None and found.rms > MISFIT * noise and found.rms > SHAPE * explained(found):
        yield circle.CIRCLE_MISFIT.found(where, left=Estimate(found.rms, "V"), noise=Estimate(noise, "V"))
    yield from _drifts(axis, found)
    side = found.balance.coordinates.sides(found.x)
    if "side" in found.balance.coordinates.names:
        yield circle.DIRECTION.found(where, side=abs(side), positive=side > 0)
    bounds = found.balance.coordinates.bounds
    at_end = [
        name
        for name, value, bound in zip(found.balance.coordinates.names, found.x, bounds, strict=True)
        if abs(value) > 0.97 * bound
    ]
    if at_end:
        yield circle.TUNED_AT_BOUND.found(where, names=at_end)


def timing_warnings(axis: Axis, found: Fitted, T_d: Estimate) -> Iterator[Notice]:
    """Yield that position and voltage are shifted against each other, where the interval of the delay says so too."""
    nominal = found.balance.coordinates.T_d
    low, high = (float(limit) for limit in np.ravel(T_d.ci95 or (T_d.value, T_d.value)))
    if abs(float(T_d) - nominal) > LATE * nominal and not low <= nominal <= high:
        flaw = circle.POSITION_LATE if float(T_d) > nominal else circle.POSITION_EARLY
        delay, least, most, believed = (Estimate(one, "s") for one in (float(T_d), low, high, nominal))
        yield flaw.found(f"axis {axis.name}", delay=delay, low=least, high=most, nominal=believed)


def _drifts(axis: Axis, found: Fitted) -> Iterator[Notice]:
    """Yield the circles in which the level of friction changes with time: by its line, the fit's parameters apart."""
    instruments = Instruments.of(found)
    level, start = instruments.J[:, found.balance.coordinates.names.index("level")], 0
    for record, part in zip(found.balance.records, found.parts(), strict=True):
        own = slice(start, start + len(part))
        start += len(part)
        time = record.time[record.used]
        along = np.zeros(len(level))
        along[own] = level[own] * (time - time.mean()) / np.ptp(time)
        apart = along - instruments.J @ np.linalg.lstsq(instruments.J, along, rcond=1e-9)[0]
        every = max(int(record.rate / (8 * COMPARED)), 1)
        thin, rest = apart[own][::every, None], (instruments.weights * found.residual)[own][::every]
        change = -float(apart @ (instruments.weights * found.residual) / (apart @ apart))
        half = 2.0 * float(np.sqrt(hac_covariance(thin, rest)[0, 0]))
        if abs(change) > max(half, CHANGES):
            feed = Estimate(record.feed, "m/s")
            yield circle.CIRCLE_DRIFTS.found(f"axis {axis.name}", change=change, size=abs(change), half=half, feed=feed)


def groups_alike(found: Fitted) -> list[list[int]]:
    """Return the blocks that slip at about one displacement, group by group, counted from 0."""
    if not any(name.startswith("alpha") for name in found.balance.coordinates.names):
        return []
    model = found.balance.coordinates.friction(found.x)
    slips = np.log(np.array(model.alpha) / np.array(model.k))
    groups: list[list[int]] = []
    for n in map(int, np.argsort(slips)):
        if groups and slips[n] - slips[groups[-1][-1]] < ALIKE:
            groups[-1].append(n)
        else:
            groups.append([n])
    return [sorted(group) for group in groups if len(group) > 1]


def merged(found: Fitted) -> Fitted | None:
    """Return a fit with what it leaves, and the derivatives where blocks that slip alike slip at one displacement.

    There nothing tells one of them from the other, and neither does the fit: the distance that it found is the noise's.
    None where no blocks slip alike.
    """
    groups = groups_alike(found)
    if not groups:
        return None
    names, x = found.balance.coordinates.names, found.x.copy()
    model = found.balance.coordinates.friction(found.x)
    for group in groups:
        slip = sum(model.alpha[n] for n in group) / sum(model.k[n] for n in group)
        for n in group:
            x[names.index(f"k_{n + 1}")] += np.log(model.alpha[n] / model.k[n] / slip)
    return replace(at(found.balance, x), residual=found.residual)


def alike_warnings(axis: Axis, found: Fitted, estimates: TunedEstimates) -> Iterator[Notice]:
    """Yield which blocks slip alike, and what holds of all of them together."""
    groups = groups_alike(found)
    if not groups:
        return
    coordinates, covariance = found.balance.coordinates, estimates.coordinates
    model = coordinates.friction(found.x)
    together = []
    for group in groups:
        texts = []
        for name, unit, values in (("alpha", "", model.alpha), ("k", " N/m", model.k)):
            total, slope = sum(values[n] for n in group), np.zeros(len(coordinates.names))
            for n in group:
                slope[coordinates.names.index(f"{name}_{n + 1}")] = values[n] / total
            if name == "alpha":  # shares of all
                own = [coordinates.names.index(f"alpha_{n + 1}") for n in range(len(values))]
                slope[own] -= np.array(values)
            half = HALF_WIDTH * max(float(slope @ covariance @ slope), 0.0) ** 0.5
            texts.append(f"{name} = {total:.4g} ({total * np.exp(-half):.4g} to {total * np.exp(half):.4g}){unit}")
        together.append(f"{', '.join(str(n + 1) for n in group)} together have {' and '.join(texts)}")
    yield circle.BLOCKS_ALIKE.found(f"axis {axis.name}", together="; ".join(together))
