"""Every model fitted, seed by seed, to noisy logs that it made of itself: do its intervals hold the truth?"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.signal import lfilter

from fric.friction import models
from fric.identify.replay.replay_fit import identify_by_replay
from fric.identify.replay.replay_search import STEP, Search
from fric.records.prepared import prepared
from tests.identify.virtual_logs import logs_of

FITTED = [name for name, model in models().items() if model.identified]
BLOCKS = 3
QUANTILE = 1.959964

LEAST, MOST = 0.92, 0.98
"""Share of all intervals that hold the truth, without the luck of the draw."""
SLIMMEST, WIDEST = 0.87, 1.15
"""Size of the errors, in standard errors, over that of the linear ones."""
FARTHEST = 0.12
"""Mean of the errors less the linear ones, in standard errors."""


@dataclass(frozen=True)
class Recovery:
    """What a model's fits say of its own parameters, seed by seed.

    Parameters
    ----------
    labels
        The parameters that were fitted, p of them; of a vector, each number is one.
    errors
        Value minus truth over its standard error, shape (seeds, p): the distance from value to truth over the distance
        from value to the limit on that side, times 1.96. So it is beyond ±1.96 exactly where the interval misses.
    linear
        The errors that the same noise makes where the model is linear in its parameters and the noise's size is
        known, shape (seeds, p). They are normal: 95 % of them are within ±1.96, but for the draw of the seeds.
    """

    labels: tuple[str, ...]
    errors: np.ndarray
    linear: np.ndarray

    @property
    def shares(self):
        """Share of the intervals that hold the truth, shape (p,)."""
        return _within(self.errors).mean(axis=0)

    @property
    def without_luck(self):
        """That share, and its standard error, once the draw of the seeds is taken off (a control variate), (2, p)."""
        more = _within(self.errors).astype(float) - _within(self.linear)
        return np.array([0.95 + more.mean(axis=0), more.std(axis=0) / np.sqrt(len(more))])

    def check(self):
        """Raise an `AssertionError` where the intervals are too narrow, too wide, or lie to one side.

        The linear errors are normal with a deviation of 1 by construction, and the errors follow them with a
        correlation of 0.97 to 0.9995. So what the draw of the seeds does to both is taken off: of 32 seeds, the
        ratio of their sizes is sure to 0.04, and their mean difference to 0.04. Of the errors alone it would take 1600.
        """
        told = dict(zip(self.labels, zip(self.against_linear, self.shifts, strict=True), strict=True))
        assert LEAST <= self.without_luck[0].mean() <= MOST, self.without_luck
        assert ((self.against_linear > SLIMMEST) & (self.against_linear < WIDEST)).all(), told
        assert (np.abs(self.shifts) < FARTHEST).all(), told

    @property
    def against_linear(self):
        """Root mean square error over that of the linear one, shape (p,)."""
        return self.widths / np.sqrt(np.mean(self.linear**2, axis=0))

    @property
    def shifts(self):
        """Mean error less the linear one, in standard errors, shape (p,)."""
        return (self.errors - self.linear).mean(axis=0)

    @property
    def biases(self):
        """Mean error, in standard errors, shape (p,)."""
        return self.errors.mean(axis=0)

    @property
    def widths(self):
        """Root mean square error in standard errors, shape (p,): 1.25 where intervals are 0.8 of the right width."""
        return np.sqrt(np.mean(self.errors**2, axis=0))


def flattened(fit, model):
    """Return label, value, interval and truth of every number that was fitted."""
    rows = []
    for section, estimates in fit.estimates.items():
        owner = model if section == model.name else getattr(model, section)
        for name, estimate in estimates.items():
            if estimate.ci95 is None:
                continue
            truth = getattr(owner, name)
            if isinstance(estimate.value, tuple):
                label = [f"{name}_{n + 1}" for n in range(len(estimate.value))]
                rows += list(zip(label, estimate.value, estimate.ci95, truth, strict=True))
            else:
                rows.append((name, estimate.value, estimate.ci95, truth))
    return rows


def recover(name, seeds, memory=0.0):
    """Fit a model, from its true parameters, to its own logs with 1 N of noise of each of some seeds.

    The noise is white, or remembers a share of the sample before. Force and position are of one instant, and that is
    known; so are the shape factors that a fit supposes.
    """
    model = models()[name].typical()
    known = {p.name: float(p.typical) for section in model.declared().values() for p in section if p.held}
    clean = [
        replace(record, done=replace(record.done, timing=0.0)) for record in prepared(logs_of(model, 0, noise=0.0))
    ]
    exact = identify_by_replay(name, clean, blocks=BLOCKS, fix=known, start=model)
    weights, before = _weights(exact, model), Search(exact.coordinates, exact.records).residual(exact.x)
    labels, errors, linear = set(), [], []
    for seed in seeds:
        rng = np.random.default_rng(seed)
        records = [replace(record, force=record.force + _noise(rng, len(record.force), memory)) for record in clean]
        fit = identify_by_replay(name, records, blocks=BLOCKS, fix=known, start=model)
        rows = flattened(fit, model)
        labels.add(tuple(label for label, *_ in rows))
        errors.append(
            [QUANTILE * (value - truth) / ((value - low) if truth < value else (high - value))
             for _, value, (low, high), truth in rows]
        )  # fmt: skip
        linear.append(weights @ (Search(exact.coordinates, fit.records).residual(exact.x) - before))
    (same,) = labels  # every seed tells every parameter
    return Recovery(same, np.array(errors), np.array(linear))


def _noise(rng, n, memory):
    white = rng.normal(size=n)
    if not memory:
        return white
    white[1:] *= np.sqrt(1 - memory**2)
    return lfilter([1.0], [1.0, -memory], white)


def _weights(exact, model):
    """Return what white noise of 1 N on the samples adds to each number, over its standard error, shape (p, n)."""
    at = exact.coordinates

    def numbers(x):
        moved = replace(exact, estimates={
            section: {name: replace(exact.estimates[section][name], value=value) for name, value in values.items()}
            for section, values in at.values(x).items()
        })  # fmt: skip
        return np.array([value for _, value, *_ in flattened(moved, model)])

    steps = np.diag(STEP * (at.upper - at.lower))
    slopes = [(numbers(exact.x + step) - numbers(exact.x - step)) / (2 * step.sum()) for step in steps]
    gradient = Search(at, exact.records).at(exact.x).gradient
    weights = -np.column_stack(slopes) @ np.linalg.pinv(gradient)
    return weights / np.linalg.norm(weights, axis=1, keepdims=True)


def _within(errors):
    return np.abs(errors) <= QUANTILE
