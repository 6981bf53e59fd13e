"""Intervals of friction and plant from circles, and warnings about undetermined parameters."""

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
from scipy.special import stdtrit

from fric.arrays import Real
from fric.circles.measured import MeasuredCircle
from fric.circles.tune_fit import (
    SHAPE,
    FittedBalance,
    Instruments,
    TunedEstimates,
    at,
    explained,
    parameters,
    recorded_again,
    whole,
)
from fric.drive.plant import Plant
from fric.estimate import Covariance, Estimate, Interval
from fric.flaws import circle
from fric.friction.stribeck import STATIC_PARAMETERS
from fric.notice import Notice
from fric.records.judgement import CHANGES
from fric.records.resolution import lattice_step
from fric.simulate.machine import Axis
from fric.statistics import hac_covariance, score_covariance

FEEDS_APART = 3.0
"""Ratio of the feeds of two circles above which they hold different information."""
LATE = 0.25
"""Relative deviation of the delay from the nominal value that gives a warning, where its interval excludes it."""
BLOCKS_ALIKE = 0.5
"""Distance of two blocks' slip displacements, in the logarithm, below which they are not separable: the residual has
several minima there, whose alpha and k differ by up to 20 %."""
HALF_WIDTH = 2.31
"""Half-width of a 95 % interval in standard deviations from a bootstrap of eight draws (Student's t)."""
MISFIT = 3.0
"""Largest residual of a result over the noise."""


def identifiability_warnings(
    axis: Axis, tests: Sequence[MeasuredCircle], before: FittedBalance, found: FittedBalance
) -> Iterator[Notice]:
    """Yield the warnings about undetermined parameters and about the fit.

    axis: The axis as it was nominally.
    before, found: Residual of the voltages with nominal and tuned parameters.
    """
    where, feeds = f"axis {axis.name}", sorted(test.feed for test in tests)
    if feeds[-1] < FEEDS_APART * feeds[0]:
        missing = (
            "delay, inertia and how friction falls with speed above it (T_d may be off by half)"
            if feeds[-1] < 0.03
            else "v_s, delta, C and the weakest blocks, which show where a reversal is slow"
        )
        yield circle.ONE_FEED.found(where, feed=Estimate(feeds[-1], "m/s"), missing=missing)
    noise = found.noise()
    # the effect of encoder counts repeats from turn to turn, and is no misfit
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


def timing_warnings(axis: Axis, found: FittedBalance, T_d: Estimate) -> Iterator[Notice]:
    """Yield the warning that position and voltage are shifted, if the interval of the delay shows it."""
    nominal = found.balance.coordinates.T_d
    low, high = (float(limit) for limit in np.ravel(T_d.ci95 or (T_d.value, T_d.value)))
    if abs(float(T_d) - nominal) > LATE * nominal and not low <= nominal <= high:
        flaw = circle.POSITION_LATE if float(T_d) > nominal else circle.POSITION_EARLY
        delay, least, most, believed = (Estimate(value, "s") for value in (float(T_d), low, high, nominal))
        yield flaw.found(f"axis {axis.name}", delay=delay, low=least, high=most, nominal=believed)


def _drifts(axis: Axis, found: FittedBalance) -> Iterator[Notice]:
    """Yield the circles in which the level of friction drifts: by a line in time besides the fit's parameters."""
    balance = found.balance
    J, residual = balance.weights[:, None] * found.gradient, balance.weights * found.residual
    level = J[:, balance.coordinates.names.index("level")]
    for record, part in zip(balance.records, balance.samples, strict=True):
        time, along = record.time[record.used], np.zeros(len(level))
        along[part] = level[part] * (time - time.mean()) / np.ptp(time)
        apart = along - J @ np.linalg.lstsq(J, along, rcond=1e-9)[0]
        change = -float(apart @ residual / (apart @ apart))
        thin = slice(part.start, part.stop, record.quarter)
        rest = residual + change * apart  # the drift itself is no error of it
        half = 2.0 * float(np.sqrt(hac_covariance(apart[thin, None], rest[thin])[0, 0]))
        if abs(change) > max(half, CHANGES):
            feed = Estimate(record.feed, "m/s")
            yield circle.CIRCLE_DRIFTS.found(f"axis {axis.name}", change=change, size=abs(change), half=half, feed=feed)


def groups_alike(found: FittedBalance) -> list[list[int]]:
    """Return groups of blocks that slip at about the same displacement, counted from 0."""
    if not any(name.startswith("alpha") for name in found.balance.coordinates.names):
        return []
    model = found.balance.coordinates.friction(found.x)
    slips = np.log(np.array(model.alpha) / np.array(model.k))
    groups: list[list[int]] = []
    for n in map(int, np.argsort(slips)):
        if groups and slips[n] - slips[groups[-1][-1]] < BLOCKS_ALIKE:
            groups[-1].append(n)
        else:
            groups.append([n])
    return [sorted(group) for group in groups if len(group) > 1]


def merged(found: FittedBalance) -> FittedBalance | None:
    """Return a fit with its residual, and its derivatives where blocks that slip together have the same displacement.

    There the blocks are not separable, and the distance that the fit found is noise. None where none slip together.
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


def alike_warnings(axis: Axis, found: FittedBalance, estimates: TunedEstimates) -> Iterator[Notice]:
    """Yield the warning about blocks that slip together, with their total share and stiffness."""
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
                indices = [coordinates.names.index(f"alpha_{n + 1}") for n in range(len(values))]
                slope[indices] -= np.array(values)
            half = HALF_WIDTH * max(float(slope @ covariance @ slope), 0.0) ** 0.5
            texts.append(f"{name} = {total:.4g} ({total * np.exp(-half):.4g} to {total * np.exp(half):.4g}){unit}")
        together.append(f"{', '.join(str(n + 1) for n in group)} together have {' and '.join(texts)}")
    yield circle.BLOCKS_ALIKE.found(f"axis {axis.name}", together="; ".join(together))


STEP = 1e-4
SEEN = 0.08
"""Uncertainty of a block's slip, as a share of an encoder step."""
OPEN = 20.0
"""Half of an interval of a logarithm above which the data set no limit."""
UNITS = {"F_c": "N", "F_s": "N", "v_s": "m/s", "delta": "1", "sigma": "N*s/m", "alpha": "1", "k": "N/m", "C": "N/s"}


def tuned_estimates(found: FittedBalance, plant: Plant) -> TunedEstimates:
    """Return the result with intervals due to noise, correlated in any way, and to the encoder.

    Where the shape was kept, an interval reaches from the value to the far end of that about a fit of the whole shape:
    a shape that is off by little moves F_c by several half-widths before it shows in the residual.

    found: The fit.
    plant: The plant that it found.
    """
    left = recorded_again(found)
    coordinates = _covariance(found, left)[: len(found.x), : len(found.x)]
    found, step = whole(found)
    covariance = _covariance(found, left)
    names = found.balance.coordinates.names
    p = len(names)
    quantile = float(stdtrit(len(left), 0.975))
    slope, labels = _logarithms(found)
    spread = slope @ covariance @ slope.T
    # blocks that slip together are separable only by where they were found: use the information on each where they do
    # not
    wide, at_one = spread, merged(found)
    if at_one is not None:
        wide = slope @ _covariance(at_one, left) @ slope.T
    half = quantile * np.sqrt(np.maximum(np.maximum(np.diag(spread), np.diag(wide)), 0.0))
    moved = slope @ step
    halves, moves = (dict(zip(labels, map(float, values), strict=True)) for values in (half, moved))

    def within(name: str, value: float) -> Interval:
        if halves[name] + abs(moves[name]) > OPEN:
            return 0.0, np.inf
        low, high = min(moves[name] - halves[name], 0.0), max(moves[name] + halves[name], 0.0)
        return value * float(np.exp(low)), value * float(np.exp(high))

    fitted = {name for name, width in halves.items() if width > 1e-9}
    sections: dict[str, Estimate] = {}
    for name, value in parameters(found.balance.coordinates.friction(found.x)).items():
        keys, known = _labels(name, value), not fitted.isdisjoint(_labels(name, value))
        limits = tuple(map(within, keys, value)) if isinstance(value, tuple) else within(name, value)
        sections[name] = Estimate(value, UNITS[name], limits if known else None, fixed=not known)
    offsets, K_f = found.plant[2:], found.balance.K_f
    error = quantile * float(np.sqrt(covariance[p + 2, p + 2] / len(offsets) + np.var(offsets))) * K_f
    load = float(np.mean(offsets)) * K_f
    static = {name: sections[name] for name in STATIC_PARAMETERS}
    negative = None
    if side := found.balance.coordinates.sides(found.x):
        variance = covariance[names.index("side"), names.index("side")] if "side" in names else 0.0
        wider = quantile * float(np.sqrt(variance)) / 2
        levels = {name: static[name] for name in ("F_c", "F_s")}
        static, negative = (
            static | {name: _scaled(level, sign * side / 2, wider) for name, level in levels.items()}
            for sign in (1, -1)
        )
    static["offset"] = Estimate.around(load, "N", error)
    gms = {name: sections[name] for name in ("alpha", "k", "C")}
    of_plant = {
        "A": Estimate(plant.A, "1/s", within("A", plant.A) if plant.A > 0 else None),
        "B": Estimate(plant.B, "m/(s^2*V)", within("B", plant.B)),
        "T_d": Estimate(plant.T_d, "s", within("T_d", plant.T_d)),
        "K_f": Estimate(plant.K_f, "N/V", fixed=True),
    }
    of_friction = [n for n, label in enumerate(labels) if label not in ("A", "B", "T_d") and label in fitted]
    spread += np.outer(moved, moved)
    joint = Covariance.of([labels[n] for n in of_friction], spread[np.ix_(of_friction, of_friction)], "log")
    return TunedEstimates(static, negative, gms, of_plant, joint, coordinates)


def _scaled(estimate: Estimate, shift: float, wider: float) -> Estimate:
    """Return an estimate times e to the power of a shift, its interval wider by a share."""
    value = float(estimate) * float(np.exp(shift))
    if estimate.ci95 is None:
        return replace(estimate, value=value)
    low, high = (float(limit) * float(np.exp(shift)) for limit in np.ravel(estimate.ci95))
    return replace(estimate, value=value, ci95=(low * (1 - wider), high * (1 + wider)))


def _covariance(about: FittedBalance, left: list[Real]) -> Real:
    """Return the covariance of coordinates and plant, shape (p + 2 + circles,) square.

    Samples are thinned to four a period of the filter's corner: samples between them add no information. Scores are
    correlated (autoregressions), and the priors add their variance. Delay, inertia and A take the memory of their own
    error, ``(ZᵀJ + P)⁻¹·z·r``: that of their scores, in which C and the level have a part, is three times as wide on
    poor logs. The error from the encoder is added.

    about: The fit, or a point beside it, whose derivatives count.
    left: Residuals of circles recorded again.
    """
    instruments, weights, p = Instruments.of(about), about.balance.weights, len(about.x)
    rows, residuals = [], []
    for record, part in zip(about.balance.records, about.balance.samples, strict=True):
        chosen, more = slice(part.start, part.stop, record.quarter), np.sqrt(record.quarter)  # fewer samples weigh more
        rows.append(more * instruments.Z[chosen])
        residuals.append(more * (weights * about.residual)[chosen])
    Z, lengths = np.vstack(rows), list(map(len, rows))

    def remembered(regressors: Real) -> Real:  # circles that are recorded again show what recurs in each turn
        scale = np.linalg.norm(regressors, axis=0)
        scale[scale == 0] = 1.0
        long_run = score_covariance(regressors / scale, np.concatenate(residuals), lengths, most=1.0)
        return np.asarray(np.outer(scale, scale) * long_run)

    covariance = instruments.solved(instruments.solved(remembered(Z)).T)
    plant = [about.balance.coordinates.names.index("T_d"), p, p + 1]
    ratio = np.ones(len(covariance))
    by_itself = np.diag(remembered(instruments.solved(Z.T).T[:, plant]))
    ratio[plant] = np.sqrt(np.minimum(by_itself / np.diag(covariance)[plant], 1.0))
    covariance = covariance * np.outer(ratio, ratio)
    covariance += instruments.solved(instruments.solved(np.diag(instruments.power * instruments.prior)).T)
    errors = _beyond(about, left) * np.array([instruments.error(weights * array) for array in left])
    covariance += errors.T @ errors / len(errors)
    covariance[:p, :p] += np.diag(_of_the_encoder(about))
    return np.asarray(covariance)


def _beyond(about: FittedBalance, left: list[Real]) -> float:
    """Return the ratio of the repeating part of the residual to that of circles recorded again.

    At least 1. A larger ratio is not due to the encoder step: the encoder ripples, or friction has another shape.
    """
    again = float(np.sqrt(np.mean([replace(about, residual=array).rms ** 2 for array in left])))
    repeats = max(about.rms**2 - (about.noise() or 0.0) ** 2, 0.0) ** 0.5
    return max(1.0, repeats / again) if again > 0 else 1.0


def _of_the_encoder(found: FittedBalance) -> Real:
    """Return variances of the stiffnesses' logarithms by the encoder's resolution of a slip, shape (p,)."""
    coordinates = found.balance.coordinates
    model = coordinates.friction(found.x)
    step = max(lattice_step(record.raw[2]) or 0.0 for record in found.balance.records)
    variances = np.zeros(len(coordinates.names))
    shares = [SEEN * step * k / (alpha * model.static.F_s) for alpha, k in zip(model.alpha, model.k, strict=True)]
    for n, name in enumerate(coordinates.names):
        if name == "stiffness":
            variances[n] = shares[int(np.argmax(model.k))] ** 2
        elif name.startswith("k_"):
            variances[n] = shares[int(name[2:]) - 1] ** 2
    return variances


def _logarithms(found: FittedBalance) -> tuple[Real, list[str]]:
    """Return derivatives of the parameters' logarithms by coordinates and plant, and the parameters' names."""
    coordinates, p = found.balance.coordinates, len(found.x)
    total = p + len(found.plant)

    def all_of(x: Real, linear: Real) -> Real:
        model = parameters(coordinates.friction(x))
        flat = np.concatenate([np.atleast_1d(np.asarray(value, float)) for value in model.values()])
        m, a = linear[:2]
        tail = [max(a / m, 1e-12), 1 / m, coordinates.delay(x)]
        return np.log(np.maximum(np.concatenate([flat, tail]), 1e-300))

    here = all_of(found.x, found.plant)
    slope = np.zeros((len(here), total))
    for n in range(p):
        moved = found.x.copy()
        moved[n] += STEP
        slope[:, n] = (all_of(moved, found.plant) - here) / STEP
    for n in range(2):
        step = STEP * max(abs(found.plant[n]), 1e-9)
        linear = found.plant.copy()
        linear[n] += step
        slope[:, p + n] = (all_of(found.x, linear) - here) / step
    named = parameters(coordinates.friction(found.x)).items()
    return slope, [*(label for name, value in named for label in _labels(name, value)), "A", "B", "T_d"]


def _labels(name: str, value: float | tuple[float, ...]) -> list[str]:
    """Return the name of a parameter, as ``k_1`` where each block has it."""
    return [f"{name}_{n}" for n in range(1, len(value) + 1)] if isinstance(value, tuple) else [name]
