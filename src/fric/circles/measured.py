"""A circle test as it was measured: traces of two axes, or angle and radial deviation of a ball bar."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from math import pi
from typing import TYPE_CHECKING, Any, Literal, get_args

import numpy as np

from fric.arrays import Complex, Real
from fric.columns import channel_dimension
from fric.contour import beside
from fric.errors import FricError, require_known, require_name
from fric.log import FromFile, Log
from fric.series import keep
from fric.units import Motion, is_effort, si_unit
from fric.verb import require_within

if TYPE_CHECKING:
    from fric.simulate.contour_run import CircleRun

MOST_MISSING = 4.0  # Average number of samples per recorded sample
SMOOTHED = 200.0  # Corner of the filter over the tracking error [Hz]


def smoothed(t: Real, r: Real, error: Real, acceleration: Real | None = None) -> tuple[Real, Real]:
    """Return position [m] and velocity [m/s] behind encoder counts: the reference less the error, smoothed.

    t, r, error: Even instants [s], reference [m], and tracking error as measured [m], shape (n,).
    acceleration: Acceleration of the error from the voltages [m/s²]; above the filter's corner it determines the error.
    """
    from scipy.fft import next_fast_len  # reading a circle does without

    n, dt = len(t), float(t[1] - t[0])
    length = next_fast_len(2 * n, real=True)
    f = np.fft.rfftfreq(length, dt)
    low = 1.0 / (1.0 + (f / SMOOTHED) ** 4)

    def spectrum_of(values: Real) -> Complex:
        """Return the spectrum of a signal, mirrored at its end and at its beginning so that it has no step."""
        return np.fft.rfft(np.concatenate([values, np.full(length - 2 * n, values[-1]), values[::-1]]))

    spectrum = low * spectrum_of(error)
    if acceleration is not None:
        spectrum -= (1 - low) / (2 * pi * np.maximum(f, f[1])) ** 2 * spectrum_of(acceleration)
    z = r - np.fft.irfft(spectrum, length)[:n]
    return np.ascontiguousarray(z), np.gradient(z, t)


def low_pass(corner: float, sampling: float) -> Real:
    """Return the second-order sections of a Butterworth low-pass of second order with a corner [Hz]."""
    from scipy.signal import butter

    return np.asarray(butter(2, min(corner / (sampling / 2), 0.95), output="sos"))


def even(time: Real, *channels: Real) -> tuple[Real, list[Real]]:
    """Return channels at even instants: unchanged, or interpolated where samples are missing or jitter."""
    period = float(np.median(np.diff(time)))
    if (samples := round((time[-1] - time[0]) / period) + 1) > MOST_MISSING * len(time):
        hint = "Record it again, without gaps in its time."
        raise FricError(f"{len(time)} samples cover the time of {samples:.3g}", hint=hint)
    if len(t := time[0] + period * np.arange(samples)) == len(time) and np.abs(t - time).max() < 0.02 * period:
        return time[0] + float(time[-1] - time[0]) / (len(time) - 1) * np.arange(len(time)), list(channels)
    return t, [np.interp(t, time, channel) for channel in channels]


Instrument = Literal["encoders", "grid", "ball-bar", ""]
"""Instrument that measured the position: encoders of the axes, grid encoder or ball bar; empty if not stated."""
LEAST = 16  # Least number of samples of a circle test
CIRCLE = "(0, 1e3]"  # Range of the radius [m] and of the feed [m/s] of a circle test
CHANNELS = ("time", "reference", "position", "input", "force")  # Channels of an axis in a circle test
STILL = 0.01  # Least travel of each axis of a circle, as a share of the radius
SLOWEST = 900.0  # Least sampling rate that resolves a reversal [Hz]


@dataclass(frozen=True)
class AxisTrace:
    """The recorded channels of an axis."""

    time: Real  # Sample instants [s], strictly increasing, shape (n,)
    position: Real  # Measured position [m], shape (n,)
    reference: Real | None = None  # Reference position [m], shape (n,)
    input: Real | None = None  # input, force: voltage as it left the controller [V], motor force, shape (n,)
    force: Real | None = None
    unit: str = "N"  # Unit of the force: N, or that of the drive

    @property
    def asked(self) -> Real:
        """The reference position [m], or else the measured position, shape (n,)."""
        return self.position if self.reference is None else self.reference

    def channels(self) -> dict[str, Real]:
        """Return the channels that were recorded, by name."""
        return {name: values for name in CHANNELS if (values := getattr(self, name)) is not None}

    def part(self, cut: slice) -> "AxisTrace":
        """Return a part of the samples."""
        return AxisTrace(**{name: values[cut] for name, values in self.channels().items()}, unit=self.unit)


@dataclass(frozen=True)
class MeasuredCircle(FromFile):
    """A circle test.

    radius, feed: Nominal radius [m], and speed along the circle [m/s].
    direction: 1 counter-clockwise, -1 clockwise.
    axes: Traces by name of the axis; the first two are x and y of the circle. None of a ball bar.
    angle, deviation: Angle from the +x axis [rad], unwrapped, and radial deviation [m] of a ball bar, shape (n,).
    instrument: What measured the position.
    name: Name of the test in its file.
    scheme: The compensation that was switched on, where it is known.
    source, sha256: File the test was read from, and the digest of what was read.
    Raises FricError: When radius or feed are not positive or beyond every machine, the direction is none, neither
        traces nor a deviation are there, an axis does not move, or `fric.series.keep` raises.
    """

    called = "test"

    radius: float
    feed: float
    direction: int
    axes: Mapping[str, AxisTrace] = field(default_factory=dict)
    angle: Real | None = None
    deviation: Real | None = None
    instrument: Instrument = ""
    name: str = "circle"
    scheme: str = ""
    source: str = ""
    sha256: str = ""

    def __post_init__(self) -> None:
        for name, trace in self.axes.items():
            keep(trace, {channel: channel_dimension(channel) for channel in CHANNELS}, self.where, least=LEAST)
            require_name(name, self.where)
        keep(self, {"angle": "angle", "deviation": "position"}, self.where, least=LEAST)
        require_within(self, "the circle", self.where, radius=CIRCLE, feed=CIRCLE)
        if self.direction not in (1, -1):
            raise FricError(f"the direction is {self.direction}", where=self.where, hint="Say 1 or -1.")
        if self.instrument:
            require_known(self.instrument, get_args(Instrument)[:3], "there is no instrument", where=self.where)
        if self.deviation is not None and np.abs(self.deviation).max() >= self.radius:
            raise FricError("the deviation of the ball bar reaches the circle's radius", where=self.where,
                            hint="Look at its unit.")  # fmt: skip
        if not self.is_ball_bar and len(self.axes) < 2:
            raise FricError(
                f"has traces of {', '.join(self.axes) or 'no axis'}, and a circle takes two axes", where=self.where,
                hint="Record both axes, or the angle and the deviation of a ball bar.",
            )  # fmt: skip
        for name in self.names if self.axes else ():
            if (travel := float(np.ptp(self.axes[name].position))) < STILL * self.radius:
                raise FricError(
                    f"axis {name} moves by {travel * 1e6:.3g} µm on a circle of {self.radius * 1e3:.3g} mm",
                    where=self.where, hint="Is it the column of the measured position, in the right unit?",
                )  # fmt: skip

    @property
    def is_slow(self) -> bool:
        """Whether a trace was recorded too slowly to resolve a reversal."""
        return any(SLOWEST * float(np.median(np.diff(trace.time))) > 1.0 for trace in self.axes.values())

    @property
    def is_ball_bar(self) -> bool:
        """Whether a radial deviation alone is known."""
        return self.angle is not None and self.deviation is not None

    @property
    def names(self) -> tuple[str, str]:
        """Names of the two axes, x and y of the circle."""
        if len(self.axes) < 2:
            return "x", "y"
        first, second = tuple(self.axes)[:2]
        return first, second

    def axis(self, name: str) -> AxisTrace:
        """Return the trace of an axis; raise a `FricError` that names the existing axes."""
        if name not in self.axes:
            text = ", ".join(self.axes) or "none: it is of a ball bar"
            raise FricError(f"there is no trace of axis '{name}'", where=self.where, hint=f"There are {text}.")
        return self.axes[name]

    def require(self, name: str, what: str) -> tuple[Real, Real, Real, Real]:
        """Return time, reference, position and voltage of an axis; a `FricError` names what is missing, and its use."""
        if (trace := self.axis(name)).reference is None or trace.input is None:
            both = {"reference": trace.reference, "voltage": trace.input}
            missing = " and ".join(text for text, values in both.items() if values is None)
            where, hint = f"{self.where}, axis {name}", "Record it beside the position."
            raise FricError(f"no {missing} was read, which {what} needs", where=where, hint=hint)
        return trace.time, trace.reference, trace.position, trace.input

    def driven(self, name: str, what: str) -> tuple[Real, Real, Real, Real, float]:
        """Return even instants [s], reference [m], position [m] and voltage [V] of an axis, and their rate [Hz].

        name, what: The axis, and what needs them.
        Raises FricError: When reference or voltage is missing, most samples are missing, or the rate is too low.
        """
        t, (r, z, u) = even(*self.require(name, what))
        if (rate := 1.0 / float(t[1] - t[0])) < SLOWEST:
            raise FricError(
                f"the circle was recorded at {rate:.3g} Hz", where=f"{self.where}, axis {name}",
                hint=f"{what.capitalize()} needs {SLOWEST:g} Hz at least: a reversal takes milliseconds.",
            )  # fmt: skip
        return t, r, z, u, rate

    def together(self) -> tuple[AxisTrace, AxisTrace]:
        """Return the traces of both axes at the instants of the first, interpolated if their clocks differ."""
        first, second = (self.axis(name) for name in self.names)
        t = first.time
        if np.array_equal(t, second.time):
            return first, second
        there: Any = {name: np.interp(t, second.time, values) for name, values in second.channels().items()}
        return first, replace(second, **there | {"time": t})

    def following(self, *names: str) -> "MeasuredCircle":
        """Return the test with axes that follow their reference exactly."""
        axes = {name: replace(trace, position=trace.asked) for name, trace in self.axes.items() if name in names}
        return replace(self, axes={**self.axes, **axes})

    def logs(self) -> list[Log]:
        """Return the traces as records, for the warnings common to all records."""
        return [
            Log(trace.time, position=trace.position, name=f"{self.name}, axis {name}", kind="motion", axis=name)
            for name, trace in self.axes.items()
        ]

    def of_effort(self, motions: Mapping[str, Motion]) -> "MeasuredCircle":
        """Return the test with the force of axes whose force is the drive's input as the input."""
        of = {name: trace for name, trace in self.axes.items() if is_effort(motions.get(name, ""))}
        for name, trace in of.items():
            unit = si_unit("force", motions[name])
            force = trace.force if trace.unit == unit else None
            of[name] = replace(trace, input=trace.input if force is None and unit == "V" else force)
        return replace(self, axes={**self.axes, **of})

    def stated(self, radius: float | None, feed: float | None) -> "MeasuredCircle":
        """Return the test with another nominal radius [m] and feed [m/s], where they are given."""
        return replace(self, radius=radius or self.radius, feed=feed or self.feed)


def measured_from_run(run: "CircleRun", source: str = "") -> MeasuredCircle:
    """Return the record of a simulated circle as a circle test, as measured by the encoders."""
    test = run.circle
    axes = {name: AxisTrace(seen.time, seen.measured, seen.reference, seen.input) for name, seen in run.traces.items()}
    if len(axes) == 1:  # the other follows its reference
        ((known, trace),) = axes.items()
        references = test.references(1.0 / float(trace.time[1] - trace.time[0]))
        axes = {
            name: axes.get(name, AxisTrace(trace.time, reference.position, reference.position))
            for name, reference in zip(beside(known), references, strict=True)
        }
    return MeasuredCircle(
        test.radius, test.feed, test.direction, axes, instrument="encoders", name=run.scheme.name,
        scheme=run.scheme.name, source=source,
    )  # fmt: skip
