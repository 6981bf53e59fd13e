"""Reference motions: constant-velocity strokes, sines, circles, multisines; all start at rest."""

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from math import ceil, pi

import numpy as np

from fric.arrays import Real
from fric.errors import FricError
from fric.kernels.elementary import cos_sin
from fric.kernels.spline import Ends, spline_slopes

SAMPLE_BYTES, TRACE_BYTES = 180, 56  # Memory of a sample of an axis while it is simulated, and of its trace [byte]
MOST_BYTES = 1.25e9  # Largest memory of what is simulated together [byte]: 14 minutes of two axes at 4 kHz
MOST_LEAD = 1.0  # Largest lead [s]: four times the longest delay of a loop


def instants(duration: float, sampling: float, *, more: int = 0, axes: int = 1) -> Real:
    """Return the instants of a motion [s] of a number of axes at a sampling rate [Hz], shape (n,)."""
    refuse_long(duration, sampling, axes)
    return np.arange(ceil(duration * sampling) + more) / sampling


def refuse_long(duration: float, sampling: float, axes: int = 1, runs: int = 1, longest: float = 1.0) -> None:
    """Raise a `FricError` where the traces along a motion [s], at a sampling rate [Hz], take too much memory.

    longest: Duration of the longest of the runs, each of which is simulated alone, in those of the motion.
    """
    samples = duration * sampling
    if not (size := samples * axes * (SAMPLE_BYTES * longest + TRACE_BYTES * (runs - 1))) < MOST_BYTES:
        of = f" of {axes} axes in {runs} runs" * (runs > 1)
        takes = f"{samples:.3g} samples at {sampling:g} Hz{of} take {size / 1e9:.3g} GB"
        what = f"the motion takes {duration:.3g} s: {takes}, and {MOST_BYTES / 1e9:g} GB are simulated at most"
        hint = f"Move faster, less far{', with fewer schemes or rounds' * (runs > 1)}, or sample less often."
        raise FricError(what, hint=hint)


@dataclass(frozen=True, eq=False)
class Reference:
    """A motion of one axis, sampled at the controller's rate, with exact derivatives."""

    sampling: float  # Samples a second [Hz]
    position: Real  # position, velocity, acceleration: the motion [m], [m/s], [m/s²], each of shape (n,)
    velocity: Real
    acceleration: Real
    period: float = field(default=0.0, kw_only=True)  # After what time it repeats [s]; 0 where it does not
    begins: float = field(default=0.0, kw_only=True)  # From when on it does [s]

    def __len__(self) -> int:
        return len(self.position)

    @cached_property
    def time(self) -> Real:
        """Sample instants [s], from 0, shape (n,)."""
        return np.arange(len(self)) / self.sampling

    def ahead(self, lead: float) -> "Reference":
        """Return the motion a lead later, at the same instants.

        Between samples the position is the cubic of its values and velocities (Hermite), velocity and acceleration are
        linear; beyond the end the acceleration is constant.

        lead: The lead [s], 0 or more.
        """
        if lead == 0.0:
            return self
        if not lead <= MOST_LEAD:
            what = f"a lead of {lead:.3g} s is more than the {MOST_LEAD:g} s that a motion is known ahead"
            raise FricError(what, hint="Look at its unit.")
        whole, s = divmod(lead * self.sampling, 1.0)
        if s > 1.0 - 1e-9:  # the rounding of a whole number of samples
            whole, s = whole + 1.0, 0.0
        T, further = 1.0 / self.sampling, np.arange(1, int(whole) + 2) / self.sampling
        z_end, v_end, a_end = (values[-1] for values in (self.position, self.velocity, self.acceleration))
        z = np.append(self.position, z_end + further * (v_end + 0.5 * a_end * further))[int(whole) :]
        v = np.append(self.velocity, v_end + a_end * further)[int(whole) :]
        a = np.append(self.acceleration, np.full(further.size, a_end))[int(whole) :]
        position = (
            (1 + 2 * s) * (1 - s) ** 2 * z[:-1] + s**2 * (3 - 2 * s) * z[1:]
            + T * s * (1 - s) * ((1 - s) * v[:-1] - s * v[1:])
        )  # fmt: skip
        return Reference(self.sampling, position, v[:-1] + s * (v[1:] - v[:-1]), a[:-1] + s * (a[1:] - a[:-1]))


def smooth_step(x: Real) -> tuple[Real, ...]:
    """Return S(x), its integral, and its first two derivatives.

    S is 0 for x ≤ 0, 1 for x ≥ 1, and ``10x³ - 15x⁴ + 6x⁵`` between.
    Speed that follows S has a continuous jerk, so that a run-in excites the loop little.
    """
    inside, beyond = np.clip(x, 0.0, 1.0), np.maximum(x - 1.0, 0.0)
    cube = inside * inside * inside  # a product: powers are rounded otherwise on other processors
    return (
        cube * (10 - inside * (15 - 6 * inside)),
        cube * inside * (2.5 - inside * (3 - inside)) + beyond,
        30 * inside**2 * (1 - inside) ** 2,
        60 * inside * (1 - inside) * (1 - 2 * inside),
    )


def cubic_spline(x: Real, y: Real, ends: Ends = "not-a-knot") -> Callable[..., Real]:
    """Return the cubic spline through points, a function of x and of the order of the derivative.

    x, y: Strictly increasing, shape (n,), and the values, shape (n,) or (n, 2).
    ends: As in `spline_slopes`.
    """
    from scipy.interpolate import CubicHermiteSpline  # not at the start, which circles share: it takes 0.1 s

    columns = np.ascontiguousarray(y, float).reshape(len(x), -1).T
    slopes = np.column_stack([spline_slopes(x, column, ends) for column in columns])
    return CubicHermiteSpline(x, y, slopes.reshape(y.shape))


def strokes(speed: float, distance: float, sampling: float, *, ramp: float = 0.1, dwell: float = 0.1) -> Reference:
    """Return a stroke at constant velocity, a rest, and the same stroke back.

    speed: Speed of each stroke [m/s]; a negative speed starts in negative direction.
    distance: Length that is travelled at that speed [m].
    sampling: Samples a second [Hz].
    ramp: Time in which the speed rises smoothly from 0, and falls to it [s].
    dwell: Rest before, between and after the strokes [s].
    """
    if speed == 0 or not distance > 0:
        raise FricError("a stroke has neither speed nor length", hint="Give a speed and a positive distance.")
    cruise = distance / abs(speed)
    starts = dwell + np.array([0.0, ramp + cruise, 2 * ramp + cruise + dwell, 3 * ramp + 2 * cruise + dwell])
    t = instants(starts[-1] + ramp + dwell, sampling)
    position, velocity, acceleration = (np.zeros_like(t) for _ in range(3))
    for start, change in zip(starts, (speed, -speed, -speed, speed), strict=True):
        S, integral, slope, _ = smooth_step((t - start) / ramp)
        position += change * ramp * integral
        velocity += change * S
        acceleration += change / ramp * slope
    return Reference(sampling, position, velocity, acceleration)


def _refuse_fast(frequency: float, sampling: float) -> None:
    if not 0 < frequency < sampling / 2:
        raise FricError(f"{frequency:g} Hz are not below half the sampling of {sampling:g} Hz", hint="Move slower.")


def sine(amplitude: float, frequency: float, cycles: float, sampling: float, *, run_in: float = 1.0) -> Reference:
    """Return a sine, preceded by ``run_in`` cycles in which its amplitude grows smoothly from rest.

    amplitude: Amplitude [m].
    frequency: Frequency [Hz].
    cycles, run_in: Cycles at full amplitude, and cycles before them in which it grows.
    sampling: Samples a second [Hz].
    """
    if not (amplitude > 0 and cycles > 0):
        raise FricError("a sine has no amplitude or cycles", hint="Give positive values.")
    _refuse_fast(frequency, sampling)
    omega, rise = 2 * pi * frequency, run_in / frequency
    t = instants((cycles + run_in) / frequency, sampling)
    S, _, slope, curve = smooth_step(t / rise)
    cos, sin = cos_sin(omega * (t - rise))
    return Reference(
        sampling,
        amplitude * S * sin,
        amplitude * (S * omega * cos + slope / rise * sin),
        amplitude * ((curve / rise**2 - S * omega**2) * sin + 2 * slope / rise * omega * cos),
    )


def staircase(
    step: float, steps: int, loops: int, sampling: float, *, ramp: float = 0.1, dwell: float = 0.1
) -> Reference:
    """Return small steps up, as many down, and so on, with a rest after each.

    step: Size of a step [m]; a negative one begins the other way.
    steps, loops: Steps from end to end, and number of round trips.
    sampling: Samples a second [Hz].
    ramp, dwell: Time that a step takes, its speed rising and falling smoothly, and rest after it [s].
    """
    if step == 0 or steps < 1 or loops < 1 or not (ramp > 0 and dwell >= 0):
        raise FricError("a staircase has no step", hint="Give a step, a number of steps and of loops.")
    senses = np.tile(np.repeat([1.0, -1.0], steps), loops)
    t = instants(dwell + len(senses) * (ramp + dwell), sampling)
    last = np.minimum(np.floor(np.maximum(t - dwell, 0.0) / (ramp + dwell)).astype(int), len(senses) - 1)
    S, _, slope, curve = smooth_step((t - dwell - last * (ramp + dwell)) / ramp)
    sense, begin = step * senses[last], step * np.append(0.0, np.cumsum(senses))[last]
    return Reference(sampling, begin + sense * S, sense / ramp * slope, sense / ramp**2 * curve)


def sliding_sine(mean: float, swing: float, frequency: float, cycles: int, sampling: float) -> Reference:
    """Return a stroke whose velocity is ``mean + swing·sin(2π·frequency·t)`` once it has run in.

    mean, swing: Mean velocity and amplitude of the velocity [m/s], swing below mean: the motion never reverses.
    frequency: Frequency of the velocity [Hz].
    cycles: Whole cycles at full amplitude; two more lie before and two behind.
    sampling: Samples a second [Hz].
    """
    if not 0 < swing < abs(mean):
        hint = "Sliding needs an amplitude below the mean velocity."
        raise FricError(f"a velocity of {mean:g} m/s with an amplitude of {swing:g} m/s reverses the motion", hint=hint)
    _refuse_fast(frequency, sampling)
    ramp = 2.0 / frequency
    t = instants(cycles / frequency + 2 * ramp, sampling)
    up, up_integral, up_slope, up_curve = smooth_step(t / ramp)
    down, down_integral, down_slope, down_curve = smooth_step((t - t[-1] + ramp) / ramp)
    level, slope, curve = up - down, (up_slope - down_slope) / ramp, (up_curve - down_curve) / ramp**2
    omega = 2 * pi * frequency
    radius, (cos, sin) = swing / omega, cos_sin(omega * t)
    return Reference(
        sampling,
        mean * ramp * (up_integral - down_integral) - radius * level * cos,
        mean * level + swing * level * sin - radius * slope * cos,
        mean * slope + swing * (level * omega * cos + 2 * slope * sin) - radius * curve * cos,
    )


def circle(
    radius: float, feed: float, revolutions: int, sampling: float, *, direction: int = 1
) -> tuple[Reference, Reference]:
    """Return the motion of both axes on a circle around the origin.

    The feed grows smoothly from rest over a quarter turn that begins 45° before the +x axis; so the whole
    revolutions begin and end at 45°, halfway between two reversals (135° for the other direction of turning).

    radius, feed: Radius [m], and speed along the circle [m/s].
    revolutions: Revolutions at full feed.
    sampling: Samples a second [Hz].
    direction: 1 counter-clockwise, -1 clockwise.
    """
    omega = direction * feed / radius
    ramp = pi / abs(omega)  # a quarter turn: half the feed on average
    t = instants(ramp + revolutions * 2 * pi / abs(omega), sampling, more=1, axes=2)
    S, integral, slope, _ = smooth_step(t / ramp)
    rate, change = omega * S, omega * slope / ramp
    cos, sin = (radius * part for part in cos_sin(-direction * pi / 4 + omega * ramp * integral))
    period = 2 * pi / abs(omega)
    return (
        Reference(sampling, cos, -sin * rate, -cos * rate**2 - sin * change, period=period, begins=ramp),
        Reference(sampling, sin, cos * rate, -sin * rate**2 + cos * change, period=period, begins=ramp),
    )


def multisine(frequencies: Real, peak: float, samples: int, sampling: float, rng: np.random.Generator) -> Reference:
    """Return a motion that is a sum of sines with equal velocity amplitudes and random phases.

    Of 64 draws of phases, the one with the lowest peak velocity is used.

    frequencies: Frequencies [Hz], shape (m,).
    peak: Largest velocity of the sum [m/s].
    samples, sampling: Length, and samples a second [Hz].
    """
    every = np.append(sampling, frequencies) / np.min(frequencies)
    repeats = every[0] <= samples and bool(np.all(np.abs(every - np.rint(every)) < 1e-9))
    length = round(every[0]) if repeats else samples  # one period determines the others
    t, omega = np.arange(length) / sampling, 2 * pi * np.asarray(frequencies, float)
    phases = 2 * pi * rng.uniform(size=(len(omega), 64))
    parts = np.array_split(t, 1 + length * (len(omega) + 64) // 2**22)  # of 64 MB at most
    tall = [np.abs((np.exp(1j * np.outer(part, omega)) @ np.exp(1j * phases)).real).max(axis=0) for part in parts]
    position, velocity, acceleration = np.zeros((3, length))
    for w, phase in zip(omega, phases[:, np.argmin(np.max(tall, axis=0))], strict=True):
        cos, sin = cos_sin(w * t + phase)
        position += sin / w
        velocity += cos
        acceleration -= w * sin
    scale = peak / np.abs(velocity).max()
    return Reference(sampling, *(np.resize(scale * motion, samples) for motion in (position, velocity, acceleration)))
