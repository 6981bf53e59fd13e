"""A circle test of one axis as a balance of voltages: prepared once, replayed many times."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from math import pi
from typing import TYPE_CHECKING

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.sparse import csr_array

from fric.arrays import Indices, Mask, Real
from fric.circles.measured import SLOWEST, MeasuredCircle, low_pass, smoothed
from fric.circles.revolutions import fit_circle, steady
from fric.errors import FricError

if TYPE_CHECKING:
    from fric.friction import FrictionModel

COMPARED = 70.0
"""Corner of the filter over all voltages that are compared [Hz]. With more, the noise that encoder counts are in an
acceleration weakens what is found of inertia, and the delay makes up for it: at 100 Hz B was 0.15 % high and T_d 4 to
10 % long, at 70 Hz neither was."""
RUN_IN = 0.15  # Share of a record that is left out: friction's state where it begins is not known
BREAK_AWAY = 0.5e-6  # The motion behind a reversal is sampled `FINE` times while it covers so much [m]
FINE = 8
ROWS = 400.0  # Least rate of the compared samples [Hz]: behind the filter, samples between them add no information
LEAST, TURNED = 32, 1.5 * pi  # Samples that are compared, and angle that they cover [rad], at least
SLIDING, COARSE = 0.35, 8
"""Where an axis moves faster than this share of the feed, friction is replayed from every n-th sample."""
TAPS = 3.0  # Half of the length of the filter, in periods of its corner: what is beyond is 1e-5 of it


@dataclass(frozen=True, eq=False)
class Filter:
    """The filter over what is compared, from nodes, between which friction is linear, to the samples used."""

    time: Real  # time, used, nodes: as those of a `VoltageRecord`
    used: Mask
    nodes: Indices

    @cached_property
    def matrix(self) -> csr_array:
        """Its weights, shape (samples used, nodes)."""
        from scipy.signal import sosfiltfilt

        n, rate = len(self.time), 1.0 / float(self.time[1] - self.time[0])
        half = min(int(TAPS * rate / COMPARED), (n - 1) // 2)
        pulse = np.zeros(2 * half + 1)
        pulse[half] = 1.0
        taps = sosfiltfilt(low_pass(COMPARED, rate), pulse, padtype=None)
        rows = np.flatnonzero(self.used)
        columns = np.clip(rows[:, None] + np.arange(-half, half + 1), 0, n - 1)
        ends = np.arange(len(rows) + 1) * len(taps)
        smoothing = csr_array((np.tile(taps / taps.sum(), len(rows)), columns.ravel(), ends), shape=(len(rows), n))
        before = np.clip(np.searchsorted(self.nodes, np.arange(n), side="right") - 1, 0, len(self.nodes) - 2)
        share = (np.arange(n) - self.nodes[before]) / (self.nodes[before + 1] - self.nodes[before])
        between = csr_array(
            (np.stack([1 - share, share], 1).ravel(), np.stack([before, before + 1], 1).ravel(), 2 * np.arange(n + 1)),
            shape=(n, len(self.nodes)),
        )
        return smoothing @ between


@dataclass(frozen=True)
class VoltageRecord:
    """One axis of one circle test, made ready to be replayed."""

    where: str  # File, test and axis, for messages
    feed: float  # feed, radius: of the circle [m/s], [m]
    radius: float
    time: Real  # Even sample instants [s], shape (n,)
    position: Real  # position, velocity: the motion [m], [m/s], without the encoder's steps, shape (n,)
    velocity: Real
    # inertia, damping: acceleration [m/s²] and velocity [m/s] behind the filter of what is compared, shape (n,)
    inertia: Real
    damping: Real
    voltage: CubicSpline  # The control voltage behind the same filter, as a function of time
    used: Mask  # Samples that are compared, evenly spaced, shape (n,)
    # Samples along which friction is replayed: all near a reversal, few where the axis slides, shape (k,)
    nodes: Indices
    # Number of the revolution that a sample is of; -1 outside whole revolutions at steady feed, shape (n,)
    revolution: Indices
    angle: Real  # Angle on the circle [rad], shape (n,)
    raw: tuple[Real, ...]  # What was recorded at even instants: time, reference, position, voltage, each of shape (N,)
    whole: Real  # The motion at these instants [m], shape (N,)
    test: MeasuredCircle  # test, axis: the circle test, and the name of the axis
    axis: str
    filter: Filter  # The filter over what is compared, which all records at these samples share

    @property
    def sampled(self) -> float:
        """Time between the samples as they were recorded [s]."""
        return float(self.raw[0][1] - self.raw[0][0])

    @property
    def rate(self) -> float:
        """Samples a second that are compared [Hz]."""
        first, second = np.flatnonzero(self.used)[:2]
        return 1.0 / float(self.time[second] - self.time[first])

    @property
    def quarter(self) -> int:
        """Of how many samples that are compared a quarter of a period of the filter's corner is."""
        return max(int(self.rate / (8 * COMPARED)), 1)

    @cached_property
    def _motion(self) -> tuple[Real, ...]:
        return tuple(np.ascontiguousarray(part[self.nodes]) for part in (self.time, self.position, self.velocity))

    def friction(self, model: FrictionModel) -> Real:
        """Return the friction of a model along the motion behind the filter [N], at the samples used."""
        return np.asarray(self.filter.matrix @ model.replay(*self._motion))

    def delayed(self, T_d: float) -> Real:
        """Return the control voltage as it acts, a delay later [V], at the samples used."""
        return np.asarray(self.voltage(self.time[self.used] - T_d))

    def repeating(self, rest: Real) -> float | None:
        """Return the root mean square of what does not repeat of a residual at the samples used; None of one turn."""
        revolution, angle = self.revolution[self.used], self.angle[self.used] % (2 * pi)
        complete = [n for n in np.unique(revolution) if n >= 0]
        if len(complete) < 2:
            return None
        bins = min(int(np.count_nonzero(revolution == complete[0])), 7200) // 2
        means = []
        for n in complete:
            cell = (angle[revolution == n] / (2 * pi) * bins).astype(int) % bins
            number = np.bincount(cell, minlength=bins)
            with np.errstate(invalid="ignore", divide="ignore"):
                means.append(np.bincount(cell, rest[revolution == n], bins) / number)
        apart = np.diff(np.array(means), axis=0)
        return float(np.sqrt(np.nanmean(apart**2) / 2))


def voltage_record(test: MeasuredCircle, name: str, like: VoltageRecord | None = None) -> VoltageRecord:
    """Return one axis of a circle test, ready to be replayed.

    The reference is exact, so only the tracking error is smoothed: ``z = r - LP(r - z_m)`` with a Butterworth filter
    of second order at 200 Hz, there and back.

    like: A record of this axis along the same reference at the same instants, whose samples and angles are then used.
    Raises FricError: When reference or voltage were not recorded, or the sampling is too slow.
    """
    from scipy.signal import decimate, sosfiltfilt

    t, r, z_m, u, sampling = test.driven(name, "tuning")
    where = f"{test.where}, axis {name}"
    # how fine the motion behind a reversal is: its time over the first half micrometre
    along = (2 * BREAK_AWAY * test.radius) ** 0.5 / test.feed
    every = max(1, int(min(sampling / SLOWEST, sampling * along / FINE)))
    rate = sampling / every
    thin = t[::every]
    angle, revolution, used = _seen(test, thin, where) if like is None else (like.angle, like.revolution, like.used)
    rate_of = np.gradient(z_m, t)  # behind the filter of the comparison, noise included: no motion is removed
    a = np.gradient(rate_of, t)
    a[1:-1] = (z_m[2:] - 2 * z_m[1:-1] + z_m[:-2]) * sampling**2
    sections = low_pass(COMPARED, rate)
    z, v = smoothed(t, r, r - z_m)

    def compared(values: Real) -> Real:
        thin = decimate(values, every, ftype="fir") if every > 1 else values
        return np.asarray(sosfiltfilt(sections, thin))

    inertia, damping, voltage = (compared(values)[: len(thin)] for values in (a, rate_of, u))
    smooth = np.ascontiguousarray(z[::every]), np.ascontiguousarray(v[::every])
    spline = CubicSpline(thin, voltage)
    if like is not None:
        return replace(
            like, position=smooth[0], velocity=smooth[1], inertia=inertia, damping=damping, voltage=spline,
            raw=(t, r, z_m, u), whole=z, test=test,
        )  # fmt: skip
    slides = np.abs(np.gradient(r, t))[::every] > SLIDING * test.feed
    nodes = np.flatnonzero(~slides | (np.arange(len(thin)) % COARSE == 0) | (np.arange(len(thin)) == len(thin) - 1))
    return VoltageRecord(
        where, test.feed, test.radius, thin, *smooth, inertia, damping, spline, used, nodes, revolution, angle,
        (t, r, z_m, u), z, test, name, Filter(thin, used, nodes),
    )  # fmt: skip


def refined(
    record: VoltageRecord, model: FrictionModel, T_d: float, plant: tuple[float, float, float], K_f: float
) -> VoltageRecord:
    """Return a record whose motion is known above the smoothing filter too, from the balance of the voltages.

    Smoothing removes the fast motion after a reversal, and friction replayed along the rest sets in late. What the
    filter removes is restored from ``z̈ = (u(t - T_d) - a·ż - o - F/K_f)/m``, twice integrated.

    model, T_d, plant, K_f: What was found so far; the plant as m [V·s²/m], a [V·s/m] and the offset [V].
    """
    t, r, z_m, u = record.raw
    every = round((record.time[1] - record.time[0]) / (t[1] - t[0]))
    velocity = np.gradient(record.whole, t)
    m, a, offset = plant
    late = np.interp(t - T_d, t, u)
    acceleration = (late - a * velocity - offset - model.replay(t, record.whole, velocity) / K_f) / m
    wanted = np.gradient(np.gradient(r, t), t)
    z, v = smoothed(t, r, r - z_m, wanted - acceleration)
    return replace(
        record, position=np.ascontiguousarray(z[::every]), velocity=np.ascontiguousarray(v[::every]), whole=z
    )


def _seen(test: MeasuredCircle, t: Real, where: str) -> tuple[Real, Indices, Mask]:
    """Return angle and revolution at even instants, and at which of them voltages are compared.

    Raises FricError: When these are less than most of a revolution.
    """
    first, second = test.together()
    x, y = first.asked, second.asked
    a, b, _ = fit_circle(x, y)
    whole = np.unwrap(np.arctan2(y - b, x - a))
    inside = steady(first.time, whole)
    began, ended = first.time[inside.start], first.time[inside.stop - 1]
    angle, end = np.interp(t, first.time, whole), whole[inside.stop - 1]
    back, count = np.abs(end - angle) / (2 * pi), int(np.abs(end - whole[inside.start]) / (2 * pi) + 1e-3)
    within = (t >= began) & (t <= ended) & (back < count)
    revolution = np.where(within, np.floor(back).astype(int), -1).astype(np.intp)
    rate = 1.0 / float(t[1] - t[0])
    edge = int(rate / COMPARED * 4)
    used = (t >= first.time[0]) & (t <= ended) & (t - t[0] >= RUN_IN * (t[-1] - t[0]))
    used[:edge] = used[-edge:] = False
    used &= np.arange(len(t)) % max(int(rate / ROWS), 1) == 0
    if np.count_nonzero(used) < LEAST or np.ptp(angle[used]) < TURNED:
        raise FricError(
            "too little of the circle is left behind its run-in to tune by", where=where,
            hint="Record two revolutions at steady feed.",
        )  # fmt: skip
    return angle, revolution, used
