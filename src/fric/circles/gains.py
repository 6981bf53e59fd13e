"""The controller behind a recorded voltage: whether it is as stated, and the gains of a cascade that produces it."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from itertools import pairwise
from math import pi
from typing import NamedTuple, Self

import numpy as np

from fric.arrays import Real
from fric.circles.measured import MeasuredCircle, even
from fric.control.base import Setting
from fric.control.cascade import Cascade
from fric.drive.plant import OF_EFFORT, LinearPlant
from fric.drive.sensing import low_pass_pole, low_passed
from fric.errors import FricError
from fric.estimate import Estimate
from fric.flaws.circle import ADDED_VOLTAGE_FOUND, CONTROLLER_DIFFERS, EFFORT_SMOOTHED, FEEDFORWARD_FOUND, LOOP_LAGS
from fric.kernels.block import Commands, Sample
from fric.log import Log
from fric.notice import Notice
from fric.records.resolution import clipped, noise_level
from fric.statistics import hac_covariance, memory, parameter_covariance, robust_deviation
from fric.units import Motion, is_effort, si_unit

FED = 0.7  # Largest share of the voltage's error that remains with feedforward, for a controller with feedforward
VOLTAGE_MISSED = 0.06  # Largest error of a stated controller, as a share of the fed back voltage
GAIN = 0.1  # Least difference of a gain [1] that counts, where another gain would explain the error
WINDOW = 0.01  # Time over which means of a recorded voltage and of the stated controller's are compared [s]
TRIED, CLEAR = tuple(np.geomspace(0.25, 4.0, 17)), 0.8
"""Trial gains over the stated gains, and the largest accepted share of their error."""
QUIET = 0.25  # Largest ratio of the median to the total error of a controller whose error is in pulses, and was added
ABOVE = 6.0  # Times the spread of quiet samples above which a voltage was added


@dataclass(frozen=True)
class StatedController:
    """A recorded voltage beside that of the stated controller."""

    # Both [V], shape (n,), without the constant in which they differ: an integral that had begun before
    recorded: Real
    given: Real
    added: Real | None  # What was added to the controller's output [V], shape (n,); None where none is seen
    apart: float  # What is left between them, without that, over the recorded voltage less what is fed forward [1]
    K_p: float  # K_p, K_i: gains that the recorded voltage shows, over the stated gains [1]; None of one stated as 0
    K_i: float | None
    explained: float  # What even these leave, over the same [1]
    missed: float  # Median difference of both [V], without what was added

    @property
    def as_stated(self) -> bool:
        """Whether the controller is as stated: its error is small, and no other gains would halve it."""
        other = max(abs(gain - 1.0) for gain in (self.K_p, self.K_i) if gain is not None) > GAIN
        return self.apart <= VOLTAGE_MISSED and not (other and self.explained < 0.5 * self.apart)

    def describe(self) -> str:
        """Return a sentence on the differences."""
        gains = f"K_p is {self.K_p:.2f} times" + ("" if self.K_i is None else f", K_i {self.K_i:.2f} times")
        differ = abs(self.K_p - (self.K_i or self.K_p)) > GAIN
        alike = "" if differ else " (as another K_v or a scaled voltage shows too)"
        alike = ": it counts the other way" if max(self.K_p, self.K_i or self.K_p) < 0 else alike
        why = f"; by that {gains} what is stated{alike}" if self.explained < 0.5 * self.apart else ""
        return f"The voltage of the controller's gains misses the recorded by {self.apart:.0%} of what is fed back{why}"


class StatedVoltage(NamedTuple):
    """The output of a stated controller along a recorded motion [V], each of shape (n,)."""

    given: Real  # All
    proportional: Real
    integral: Real


def stated_voltage(
    cascade: Cascade, plant: LinearPlant, reference: Real, measured: Real, rate: float, *, ahead: float | None = None
) -> StatedVoltage:
    """Return the output of a controller along a recorded motion.

    reference, measured: Reference, and position as the encoder measures it [m], shape (n,).
    ahead: Share of velocity and inverse model of the reference that is fed forward; by default that of the controller,
        all or none, as the motion agrees with: of another the controller would integrate the lag.
    """
    if ahead is None:
        shares = dict.fromkeys((cascade.velocity_feedforward, 1.0, 0.0))
        tried = [stated_voltage(cascade, plant, reference, measured, rate, ahead=share) for share in shares]
        return min(tried, key=lambda stated: float(np.std(stated.integral)))
    sampled = replace(cascade, sampling=rate, velocity_feedforward=1.0)
    velocity = ahead * np.gradient(reference, 1 / rate)
    acceleration = np.gradient(velocity, 1 / rate)
    seen = float(2 * measured[0] - measured[1])
    start = (float(measured[1]) - float(measured[0])) * rate
    ready = sampled.ready(Setting(plant, sampled, position=float(measured[0]), velocity=start, seen=seen))
    state, rows = ready.state.copy(), np.zeros((len(Commands._fields), 1))
    samples = zip(reference, velocity, acceleration, measured, strict=True)
    volts = np.array([ready.step(Sample(*now, *[0.0] * 4), 0, rows, state, ready.parameters) for now in samples])
    # volts[n] = K_p·e[n] + K_i·T·Σe: the error follows from the volts, and both parts from that
    each, inverse = sampled.K_i / rate, 1.0 / (sampled.K_p + sampled.K_i / rate)
    error, total = np.empty(len(volts)), 0.0
    for n, u in enumerate(volts):
        error[n] = (u - each * total) * inverse
        total += error[n]
    proportional = sampled.K_p * error
    model = cascade.acceleration_feedforward * (acceleration + plant.A * velocity) / plant.B
    return StatedVoltage(volts + model, proportional, volts - proportional)


def against_stated(cascade: Cascade, stated: StatedVoltage, voltage: Real, rate: float) -> StatedController:
    """Compare a recorded voltage with that of the stated controller, and find a voltage added to it.

    A wrong gain gives an error wherever its part acts; a voltage added to the output is in pulses that no gain makes,
    with the controller alone between them. Gains are those of both parts of the stated voltage that explain most of the
    recorded voltage.
    """
    given, proportional, integral = stated
    rest = voltage - (given - proportional - integral)
    parts = np.column_stack([proportional, *([integral] if cascade.K_i > 0 else [])])
    seen, seen_parts = _smooth(rest, rate), np.column_stack([_smooth(part, rate) for part in parts.T])
    size = max(float(np.std(seen)), 1e-12)
    gains, constant = _gains(seen, seen_parts, 1e-3 * size)
    difference = voltage - given
    difference = difference - float(np.median(difference))
    missed, left = robust_deviation(difference), seen - seen_parts @ gains - constant
    spread, swing, added = robust_deviation(left), float(np.std(left)), None
    if spread < QUIET * swing and spread < VOLTAGE_MISSED * size < swing:
        added = np.where(np.abs(left) > max(ABOVE * spread, 1e-3 * size), difference, 0.0)
        kept = added == 0.0
        difference, left = difference * kept, left * kept
    return StatedController(
        voltage, voltage - difference - (0.0 if added is None else added), added,
        float(np.std(_smooth(difference, rate))) / size, float(gains[0]),
        float(gains[1]) if cascade.K_i > 0 else None, float(np.std(left)) / size, missed,
    )  # fmt: skip


def _smooth(values: Real, rate: float) -> Real:
    """Return means over `WINDOW`, of fewer samples at the ends, which nearly remove the noise of the log."""
    window = np.ones(min(max(int(WINDOW * rate), 1), len(values)))
    return np.convolve(values, window, mode="same") / np.convolve(np.ones(len(values)), window, mode="same")


def _gains(rest: Real, parts: Real, least: float) -> tuple[Real, float]:
    """Return the factor of each part of a controller's output in the recorded voltage, and a constant [V].

    The voltage added to the output is in few samples, and where the controller reacts to it: least squares would take
    it for a gain. So the gains of `TRIED` with the most samples within `ABOVE` times the median residual are chosen, or
    the stated gains unless others have far more; least squares then use these samples.
    """
    each = [np.ones(parts.shape[1], bool), *np.eye(parts.shape[1], dtype=bool)]
    tried = [np.ones(parts.shape[1]), *(np.where(row, size, 1.0) for size in TRIED for row in each)]
    rests = [rest - parts @ gains for gains in tried]
    rests = [rest - np.median(rest) for rest in rests]
    scale = ABOVE * max(min(map(robust_deviation, rests)), least)
    losses = [float(np.mean(np.minimum((rest / scale) ** 2, 1.0))) for rest in rests]
    best = int(np.argmin(losses))
    near = np.abs(rests[best if losses[best] < CLEAR * losses[0] else 0]) < scale
    columns, found = np.column_stack([parts, np.ones(len(rest))]), np.append(tried[0], 0.0)
    for _ in range(3):
        if np.count_nonzero(near) < len(rest) // 2:
            near = np.ones(len(rest), bool)
        found, *_ = np.linalg.lstsq(columns[near], rest[near], rcond=None)
        near = np.abs(rest - columns @ found) < scale
    return found[:-1], float(found[-1])


def controller_behind(
    log: Log, plant: LinearPlant, cascade: Cascade, reference: Real, voltage: Real, rate: float
) -> tuple[bool, Real, tuple[Notice, ...]]:
    """Return whether a stated controller feeds forward, the voltage added to its output [V], and warnings about both.

    reference, voltage: Recorded reference [m] and voltage [V], each of shape (n,), at a rate [Hz].
    """
    measured = log.require("position", "a validation")
    added = np.zeros(len(voltage)) if log.added is None else log.added
    plain, fed = (
        against_stated(cascade, stated_voltage(cascade, plant, reference, measured, rate, ahead=ahead),
                       voltage - added, rate)
        for ahead in (False, True)
    )  # fmt: skip
    ahead = fed.missed < FED * plain.missed
    held, warnings = fed if ahead else plain, [FEEDFORWARD_FOUND.found(log.where)] if ahead else []
    if held.added is not None:
        added = added + held.added
        share, most = float(np.mean(held.added != 0.0)), float(np.abs(held.added).max())
        warnings.append(ADDED_VOLTAGE_FOUND.found(log.where, share=share, most=most))
    if not held.as_stated:
        warnings.append(CONTROLLER_DIFFERS.found(log.where, how=held.describe(), friction=True))
    return ahead, added, tuple(warnings)


RECORD = (
    "Record a stroke or circle with reference, position and voltage at the controller's rate, without compensation."
)
GAINS = {"K_v": "rate", "K_p": "velocity gain", "K_i": "position gain", "velocity_filter": "frequency"}
START = 0.1  # Share of a record that is left out, since the initial state of the filter is not known
CORNERS = tuple(np.geomspace(0.01, 0.5, 18))  # Velocity filter over the sampling rate: the best begins a search
REPRODUCED = 1.0 - 1e-6  # Share of a voltage at the controller's rate from which a fit is exact: 0.1 % of it is left
EXPLAINED, EXPLAINED_OF_LOG = 0.9, 0.98
"""Least share of the voltage beyond feedforward that gains must explain to be accepted. A log does not say that
compensation was off; a compensation is no sum of these gains."""
EXACT = 4.0
"""Least residual of a slower record's cascade, over that of one at the record's rate, by which the record has the rate
of its controller. Of simulated circles at that rate it is 25 to 150, of slower or late ones 1.0 to 1.9."""
SURE_ORDER = 1.05  # Least ratio of squared residuals by which a record tells one order of gains from the other
NO_INTEGRAL = 0.05  # Record over integral time below which a controller has no integral part
LAGS = 0.25  # Least lag that is said; without velocity feedforward it is 1 [1/K_v]
FED_ERROR = 0.05  # Error of the share of the reference velocity that is fed forward, by damping over gain [1]
NO_MODEL, FASTEST = 1e-4, 5e-4
"""Acceleration over velocity that is fed forward, up to which no inverse model is, and the least of one [s]: of a drive
it is 1/(K_p·B), and few velocity loops have 2000 rad/s."""
WIDEST = 0.25  # Largest relative half-width of gains that a log determines
USUAL = Cascade(1.0, 1.0, 1.0, velocity_filter=500.0, sampling=4000.0)
"""Velocity filter and sampling that are assumed where a log is too slow to show them: those of `design controller`."""
LAG = 0.5 / (pi * USUAL.velocity_filter) + 0.5 / USUAL.sampling
"""Delay of the velocity by both, and by its backward difference [s]."""
SMOOTHED = 100.0  # Corner [Hz] below which no drive filters the velocity: a loop with it would be as slow
CHANCE = 3.84  # 95 % of χ² of one degree of freedom: twice the difference of log-likelihoods
LEAST_LOG, MOST_LOGS = 200, 12  # Least number of samples of a log, and largest number of logs to try, the fastest first


@dataclass(frozen=True)
class FoundController:
    """A controller that a recorded voltage shows."""

    cascade: Cascade  # The controller
    estimates: Mapping[str, Estimate]  # Its gains with their 95 % intervals
    # Share of the voltage beyond what is fed forward that it explains [1]; None of gains that a file holds
    explained: float | None
    where: str = ""  # The circle or record
    late: float = 0.0  # Time from the measurement to its voltage [s], which belongs to T_d of the axis
    swapped: bool = False  # Whether K_v and K_i/K_p in each other's place explain it as well
    left: float = 0.0  # Relative error of the gains by what happens between the samples, where a single record shows it

    @property
    def lags(self) -> list[Notice]:
        """What a lag says: of want of velocity feedforward, and of an effort that was smoothed before it was logged."""
        found = lags(self.cascade, (1.0 - self.cascade.velocity_feedforward) / self.cascade.K_v)
        corner = self.estimates.get("velocity_filter")
        if self.explained is None or corner is None or corner.assumed or "V" in self.estimates["K_p"].unit:
            return found  # stated in a file, or not seen; and a voltage is what a controller puts out
        return found + [EFFORT_SMOOTHED.found(corner=Estimate(float(corner), "Hz"))] * (float(corner) < SMOOTHED)

    def at(self, sampling: float) -> Self:
        """Return it with the controller's rate [Hz], where its record is slower; without a filter if none was seen."""
        seen = self.cascade.velocity_filter < 0.999 * self.cascade.sampling
        cascade = replace(self.cascade, sampling=sampling, **({} if seen else {"velocity_filter": sampling}))
        estimates = {name: value for name, value in self.estimates.items() if name != "sampling"}
        estimates |= {} if seen else {"velocity_filter": Estimate(sampling, "Hz", assumed=True)}
        return replace(self, cascade=cascade, estimates=estimates)

    def beside(self, others: Iterable[Self]) -> Self:
        """Return it with intervals that hold how other slow records deviate; alone, by what it leaves.

        What happens between the samples shifts the gains of a record by more than its residuals show, and differently
        in each. (Of 149 sets of such logs 79, 82 and 75 % held K_v, K_p and K_i without it, and 99, 95 and 99 % do.)
        """
        wider, found = dict(self.estimates), [other.estimates for other in others]
        for name in ("K_v", "K_p", "K_i"):
            if not (value := float(wider[name])):
                continue
            apart = [np.log(gain / value) for other in found if (gain := float(other[name]))]
            by = robust_deviation(np.array(apart)) if apart else self.left
            low, high = (float(np.hypot(np.log(limit / value), by)) for limit in wider[name].limits)
            wider[name] = replace(wider[name], ci95=(value * float(np.exp(-low)), value * float(np.exp(high))))
        return replace(self, estimates=wider)

    def of_fit(self, fit: "_Fit", log_values: Real) -> Self:
        """Return it with what a fit shows of delay, order and velocity feedforward.

        An integral leaves the lag (1 - share)/K_v. Without one the voltage holds the share: the inverse model, damping
        over gain, is little beside it. Within its error of 1 it is full, within that of 0 none: then an integral leaves
        the lag 1/K_v, which shows K_v to within a sample. An acceleration feedforward that is not seen is 0 to 1.
        """
        found = replace(self, late=fit.late, swapped=fit.swapped)
        K_v, gain = self.cascade.K_v, self.estimates["K_v"]
        late = K_v * fit.velocity_lag if self.cascade.K_i else 1.0 - fit.fed_share(log_values)
        half = FED_ERROR + K_v / fit.rate + K_v * fit.lag_error * bool(self.cascade.K_i)
        least = gain.limits[0] / (1.0 + half)  # a K_v that no order has is none: friction holds what a sine lags by
        if half > 0.5 or (self.cascade.K_i and fit.velocity_lag * least > 1.0):  # the share is not seen
            unseen = Estimate(1.0, "1", assumed=True)
            return replace(found, estimates={**self.estimates, "velocity_feedforward": unseen})
        if abs(late) <= half:
            ahead, apart = fit.fed_acceleration(log_values)
            if not np.isfinite(apart):
                unseen = Estimate(1.0, "1", (0.0, 1.0), assumed=True)
                return replace(found, estimates={**self.estimates, "acceleration_feedforward": unseen})
            if max(abs(ahead), 1e-5) + apart > NO_MODEL:
                return found
            alone = Estimate(0.0, "1", (0.0, min((abs(ahead) + apart) / FASTEST, 1.0)))
            cascade = replace(self.cascade, acceleration_feedforward=0.0)
            return replace(found, cascade=cascade, estimates={**self.estimates, "acceleration_feedforward": alone})
        share = 0.0 if abs(1.0 - late) <= half else min(max(1.0 - late, 0.0), 2.0)
        half += abs(late) * gain.half_width / K_v
        if share == 0.0 and self.cascade.K_i:
            K_v = 1.0 / fit.velocity_lag
            gain = Estimate.around_log(K_v, gain.unit, K_v / fit.rate + K_v * fit.lag_error)
        within = max(share - half, 0.0), share + half
        estimates = {**self.estimates, "K_v": gain, "velocity_feedforward": Estimate(share, "1", within)}
        return replace(found, cascade=replace(self.cascade, K_v=K_v, velocity_feedforward=share), estimates=estimates)


def lags(cascade: Cascade, lag: float, where: str = "") -> list[Notice]:
    """Return the notice of a lag [s] for want of velocity feedforward, which is wrong where the controller has that."""
    share = lag * cascade.K_v
    differs = abs(share - (1.0 - cascade.velocity_feedforward)) > LAGS
    return [LOOP_LAGS.found(where, lag=Estimate(lag, "s"), differs=differs)] if differs or share > LAGS else []


def controller_of(test: MeasuredCircle, name: str, motion: Motion = "linear") -> FoundController:
    """Return the cascade that produces the recorded voltage of an axis.

    ``u = K_p·e + K_i·∫e`` with ``e = K_v·(r - z) - ż`` of the filtered velocity, beside what is fed forward: any sum of
    the reference, its velocity, its acceleration and a constant, which is fitted and subtracted. Position gain and
    integral time can be exchanged without a change of this sum; the order is chosen whose integral of the reference
    velocity, if that is fed forward, agrees with the record. Where both do, K_v is the larger rate, as usual, and the
    intervals hold both orders: the loop is the same. Where a cascade at the record's rate does not explain it exactly,
    and the residual is not noise, the circle is logged more slowly than the controller samples, or late: filter and
    sampling are then assumed. The intervals hold the gains with and without.

    test, name, motion: The circle, without compensation of friction; name and motion of the axis.
    Raises FricError: When reference or voltage were not recorded, compensation was on, or no cascade gives this
        voltage.
    """
    where = f"{test.where}, axis {name}"
    if test.scheme not in ("", "a"):
        raise FricError("the controller's gains take a circle without compensation", where=where, hint=RECORD)
    _, r, z, u, rate = test.of_effort({name: motion}).driven(name, "identifying gains")
    models = [_fitted(r, z, u, rate), _fitted(r, z, u, rate, LAG)]
    at_rate, slower = (float(np.linalg.norm(fit.rest(found))) for fit, found, *_ in models)
    times = max(slower, 1e-300) / max(at_rate, 1e-300)
    late = times < EXACT and models[0][0].structured(models[0][1])
    slow = late or times < 1.0
    (fit, found, half, other), (_, second, beside, _) = models[::-1] if slow else models
    if late or 2 * len(fit.u) * abs(np.log(times)) < CHANCE:
        held = np.maximum(_widened(fit, found, half)[:3], fit.difference(second, found)[:3] + beside[:3])
        half = np.append(held, half[3:])
    if (explained := fit.explained(found)) < EXPLAINED:
        what = f"no P-PI cascade gives the recorded voltage: the best explains {explained:.0%} of it"
        raise FricError(what, where=where, hint=RECORD)
    seen = None if slow else rate
    return _controller(found, half, other, explained, seen, test.where, motion, unused=False).of_fit(fit, found)


def controller_of_logs(logs: Iterable[Log]) -> FoundController:
    """Return the cascade that produces the voltage of a closed-loop record, of the record that determines it best.

    As `controller_of`. A log slower than the controller shows no velocity filter: the filter and the sampling are then
    assumed. The change of the gains without these, and with every other sample left out, widens their intervals.

    logs: Records of one axis; those without reference, position and voltage are passed over.
    """
    whole = [
        log for log in logs
        if log.reference is not None and log.position is not None and log.input is not None and len(log) >= LEAST_LOG
    ]  # fmt: skip
    if not whole:
        raise FricError("no record has reference, position and voltage", hint=RECORD)
    whole.sort(key=lambda log: log.time[-1] / len(log))
    if not (found := [fit for log in whole[:MOST_LOGS] if (fit := _of_log(log)) is not None]):
        raise FricError("no record in closed loop shows the gains", hint=RECORD)

    def width(fit: FoundController) -> float:
        gains = (fit.estimates[name] for name in ("K_v", "K_p", "K_i"))
        open_share = "velocity_feedforward" in fit.estimates and fit.estimates["velocity_feedforward"].assumed
        return sum(gain.half_width / float(gain) for gain in gains if float(gain)) + open_share

    best = min(found, key=width)
    return best if (best.explained or 0.0) > REPRODUCED else best.beside(fit for fit in found if fit is not best)


def _of_log(log: Log) -> FoundController | None:
    """Return the cascade behind a closed-loop record; None if the record does not show it."""
    channels = [log.require(name, "gains") for name in ("reference", "position", "input")]
    if log.added is not None:
        channels[2] = channels[2] - log.added
    t, (r, z, u) = even(log.time, *channels)
    rate = 1.0 / float(t[1] - t[0])
    if not np.ptp(r) > 0.0 or not np.ptp(u) > 0.0:
        return None
    best, most = None, EXPLAINED_OF_LOG
    for slow in (False, True):
        lag = LAG if slow else None
        try:
            fit, found, half, other = _fitted(r, z, u, rate, lag)
            explained = fit.explained(found)
            half = half if not slow and explained > REPRODUCED else _widened(fit, found, half)
        except (np.linalg.LinAlgError, ValueError):
            continue
        unused = np.exp(found[2] - found[1]) * len(r) / rate < NO_INTEGRAL
        if explained > most and (half[: 2 if unused else 3] < WIDEST).all():
            order = found if unused else other
            best = _controller(found, half, order, explained, None if slow else rate, log.where, log.motion, unused)
            left = 2.0 * (1.0 - explained) ** 0.5 if fit.structured(found) else 0.0  # noise leaves the gains alone
            best, most = replace(best.of_fit(fit, found), left=left), explained
    return best


def _widened(fit: "_Fit", found: Real, half: Real) -> Real:
    """Return half-widths that hold the change of the gains with every other sample, and without the assumed lag."""
    varied = [_Fit(fit.r[::2], fit.z[::2], fit.voltage[::2], fit.rate / 2, lag=fit.lag)]
    varied += [_Fit(fit.r, fit.z, fit.voltage, fit.rate, lag=0.0)] if fit.lag else []
    apart = [each.difference(each.best()[0], found)[: len(half)] for each in varied]
    return np.asarray(np.linalg.norm([half, *apart], axis=0))


def _controller(
    found: Real, half: Real, other: Real, explained: float, rate: float | None, where: str, motion: Motion, unused: bool
) -> FoundController:
    """Return the controller for logarithms of its gains, half-widths [1], and the other order; K_i is 0 if unused.

    A logged effort is behind its current loop and filter: it may be what was asked for, or later by up to ``2·T``,
    where T is the delay that is assumed of such a loop. K_p is in the middle, and its interval holds both. Behind a
    delay τ the filter of the velocity takes its part of it, and the rest, ``K_p·(K_v·e - ż)`` with the integral, lets
    K_p seem smaller by ``(K_v + K_i/K_p)·τ``.
    """  # fmt: skip
    off = OF_EFFORT * float(np.exp(found[0]) + np.exp(found[2] - found[1])) * is_effort(motion)
    behind, wide = np.array([0.0, off, 0.0, 0.0]), half.copy()
    wide[1] = np.hypot(half[1], off)
    values, others = (dict(zip(GAINS, np.exp(order + behind).tolist(), strict=True)) for order in (found, other))
    estimates = dict[str, Estimate]()
    for key, width in zip(GAINS, wide.tolist(), strict=False):
        both = [Estimate.around_log(order[key], "1", width).limits for order in (values, others)]
        ends = min(low for low, _ in both), max(high for _, high in both)
        estimates[key] = Estimate(values[key], si_unit(GAINS[key], motion), ends)
    if unused:
        most, values["K_i"] = values["K_i"] * (1.0 + float(wide[2])), 0.0
        estimates["K_i"] = Estimate(0.0, si_unit(GAINS["K_i"], motion), (0.0, most))
    estimates["sampling"] = Estimate(rate or USUAL.sampling, "Hz", assumed=True)
    if rate is None:
        estimates["velocity_filter"] = Estimate(USUAL.velocity_filter, "Hz", assumed=True)
    elif values["velocity_filter"] > 0.999 * rate:  # no filter is seen
        estimates["velocity_filter"] = Estimate(rate, "Hz", assumed=True)
    return FoundController(Cascade(**values, sampling=rate or USUAL.sampling), estimates, explained, where)


class _Fit:
    """The recorded voltage and that of a cascade, without feedforward.

    Where a record is slower than the controller, the velocity is the central difference of the position, delayed by the
    ``lag`` [s] that is assumed of the controller.
    """

    def __init__(self, r: Real, z: Real, u: Real, rate: float, *, lag: float | None = None, late: float = 0.0) -> None:
        self.lag, self.late, self.swapped = lag, late, False
        self.rate, self.r, self.z = rate, r, z
        start, stop = int(START * len(r)), len(r)
        edges = [start, *(n for n in np.flatnonzero(clipped(u)).tolist() if n > start), stop]
        longest = max(pairwise(edges), key=lambda ends: ends[1] - ends[0])  # at its limit it is no sum of gains
        self.used = slice(*(longest if 2 * (longest[1] - longest[0]) > stop - start else (start, stop)))
        velocity = np.gradient(r, 1 / rate)
        fed = np.column_stack([np.ones(len(r)), r, velocity, np.gradient(velocity, 1 / rate)])[self.used]
        size = np.abs(fed).max(axis=0)
        self.sized = fed / np.where(size > 0, size, 1.0)
        self.basis = np.linalg.qr(self.sized)[0]
        self.fed, self.u, self.voltage = fed, u[self.used], u
        self.without = self._off(self.u)
        self.velocity_lag, self.lag_error = _lag_of(velocity, r - z, rate) if velocity.any() else (0.0, np.inf)

    def _off(self, values: Real) -> Real:
        """Return values without their part of the feedforward."""
        return np.asarray(values - self.basis @ (self.basis.T @ values))

    def volts(self, log_values: Real) -> Real:
        """Return the output of a cascade without feedforward [V]."""
        K_v, K_p, K_i, corner = np.exp(log_values)
        error = K_v * (self.r - self.z) - self._velocity(float(corner))
        return np.asarray(K_p * error + K_i * self._integral(error))[self.used]

    def _velocity(self, corner: float) -> Real:
        """Return the velocity that the controller sees, behind its filter or the lag that is assumed of it [m/s]."""
        if self.lag is not None:
            velocity = np.gradient(self.z) * self.rate
            return np.asarray(velocity - self.lag * self.rate * np.gradient(velocity))
        return low_passed(np.diff(self.z, prepend=2 * self.z[0] - self.z[1]) * self.rate, corner, self.rate)

    def _integral(self, values: Real) -> Real:
        """Return the integral of values over time, as the controller sums them; by trapezoids in a slower record."""
        summed = np.cumsum(values)
        return np.asarray(summed if self.lag is None else summed - 0.5 * (values + values[0])) / self.rate

    def explained(self, log_values: Real) -> float:
        """Return the share of the voltage beyond what is fed forward that a cascade explains [1]."""
        return 1.0 - float(np.sum(self.rest(log_values) ** 2)) / max(float(np.sum(self.without**2)), 1e-300)

    def fed_share(self, log_values: Real) -> float:
        """Return the reference velocity that is fed forward, over K_p [1], of a controller without an integral."""
        shares = np.linalg.lstsq(self.fed, self.u - self.volts(log_values), rcond=None)[0]
        return float(shares[2] / np.exp(log_values[1]))

    def fed_acceleration(self, log_values: Real) -> tuple[float, float]:
        """Return the reference acceleration that is fed forward, over K_p, and its 95 % half-width [s].

        Along a circle acceleration follows position: only what differs from it shows the share, if that is more than
        the rounding of the reference, twice differentiated, has of it (in variance, half).
        """
        left, K_p = self.u - self.volts(log_values), float(np.exp(log_values[1]))
        size = np.maximum(np.abs(self.fed).max(axis=0), 1e-300)
        others, along = np.linalg.qr(self.sized[:, :3])[0], self.sized[:, 3]
        rounding = float(np.sqrt(6.0) / 4.0 * self.rate**2 * noise_level(self.r) / size[3])
        if np.mean((along - others @ (others.T @ along)) ** 2) < 2.0 * rounding**2:
            return 0.0, np.inf
        shares = np.linalg.lstsq(self.sized, left, rcond=None)[0]
        error = hac_covariance(self.sized, left - self.sized @ shares, [len(left)])[3, 3]
        return float(shares[3] / size[3]) / K_p, 1.96 * float(np.sqrt(error) / size[3]) / K_p

    def rest(self, log_values: Real) -> Real:
        """Return the residual of the recorded voltage [V] with a cascade and feedforward."""
        return self.without - self._off(self.volts(log_values))

    def structured(self, log_values: Real) -> bool:
        """Whether neighbouring residuals are correlated, by more than 4/√n: white noise is not."""
        rest = self.rest(log_values)
        rest = rest - rest.mean()
        return max(abs(float(rest[k:] @ rest[:-k])) for k in (1, 2)) > 4.0 * float(rest @ rest) / np.sqrt(len(rest))

    def best(self) -> tuple[Real, Real, Real]:
        """Return the logarithms of the gains, half-widths, and those of the other order if that fits too."""
        from scipy.optimize import least_squares

        filters = [float(np.log(USUAL.velocity_filter))] if self.lag is not None else []

        def rest_of(values: Real) -> Real:
            return self.rest(np.append(values, filters))

        starts = [self._linear(corner * self.rate) for corner in (CORNERS[-1:] if filters else CORNERS)]
        start = min(starts, key=lambda start: float(np.sum(self.rest(start) ** 2)))
        best = least_squares(rest_of, start[: len(start) - len(filters)], x_scale=0.1, max_nfev=30)
        found = np.append(best.x, filters)
        found[3] = min(found[3], np.log(self.rate))  # above it a filter is none
        other = self.exchanged(found)
        fed = [1.0 - float(np.exp(order[0])) * self.velocity_lag for order in (found, other)]
        least = [FED_ERROR + float(np.exp(order[0])) * self.lag_error for order in (found, other)]
        partly = all(by < share < 1.0 - by for share, by in zip(fed, least, strict=True))  # else all or none is fed
        shares = [(share,) if partly else (0.0, 1.0) for share in fed]
        apart, second = self._apart(found, shares[0]), self._apart(other, shares[1])
        full = not partly and all(self._apart(order, (1.0,)) < self._apart(order, (0.0,)) for order in (found, other))
        self.swapped = alike = full or max(apart, second) < SURE_ORDER * min(apart, second)
        first = found[0] >= other[0] if alike else apart <= second
        found, other = (found, other) if first else (other, found)
        rest = self.rest(found)
        variance = float(np.mean(rest**2)) * memory(rest - rest.mean())
        half = 1.96 * np.sqrt(variance * np.diag(parameter_covariance(np.asarray(best.jac))))
        half[:3] = np.minimum(half[:3], self._half_by_sums(found, variance))
        return found, half, other if alike else found

    def difference(self, order: Real, found: Real) -> Real:
        """Return by how much logarithms of gains differ from others, in the order that is nearer."""
        return np.asarray(min((np.abs(each - found) for each in (order, self.exchanged(order))), key=np.sum))

    def _settling(self, log_values: Real) -> float:
        """Return τ [s] of the velocity that the controller sees: its integral is ``z - τ·ż`` of that velocity."""
        if self.lag is not None:
            return self.lag
        pole = low_pass_pole(float(np.exp(log_values[3])), self.rate)
        return pole / (1.0 - pole) / self.rate

    def exchanged(self, order: Real) -> Real:
        """Return logarithms of the gains of the same voltage with K_v and K_i/(K_p - K_i·τ) in each other's place.

        With e = r - z the voltage is ``-(K_p - K_i·τ)·ż + (K_p·K_v + K_i)·e + K_v·K_i·∫e`` beside a part of r, which is
        taken off.
        """
        (K_v, K_p, K_i, _), tau = np.exp(order), self._settling(order)
        D = max(K_p - K_i * tau, 1e-3 * K_p)
        return np.array([*np.log([K_i / D, D + K_v * D * tau, K_v * D]), order[3]])

    def _half_by_sums(self, found: Real, variance: float) -> Real:
        """Return half-widths of the logarithms of K_v, K_p and K_i for residuals of a variance [V²], by `exchanged`.

        The voltage is linear in D = K_p - K_i·τ, P = K_p·K_v + K_i and I = K_v·K_i. With w = K_i/D, K_v and w are
        m·exp(±h) for m² = I/D and cosh h = (P - I·τ)/2mD: where both are alike no gradient shows their error, which is
        the root of that of the sum.
        """
        (K_v, K_p, K_i, corner), tau = np.exp(found), self._settling(found)
        error, D, P = self.r - self.z, max(K_p - K_i * tau, 1e-3 * K_p), K_p * K_v + K_i
        parts = [-D * self._velocity(float(corner)), P * error, K_v * K_i * self._integral(error)]
        columns = [self._off(part[self.used]) for part in parts]
        if self.lag is None:
            step = np.array([0.0, 0.0, 0.0, 1e-3])
            columns.append(self._off(self.volts(found + step) - self.volts(found - step)) / 2e-3)
        covariance, filtered = variance * parameter_covariance(np.column_stack(columns)), self.lag is None
        lost, share = K_v * K_i * tau / (P - K_v * K_i * tau), K_i * tau / K_p
        rows = [[-0.5, 0.0, 0.5, 0.0], [0.5, 0.0, 0.5, 0.0], [1.0 - share, 0.0, 0.0, -share],
                [-0.5, 1.0 + lost, -0.5 - lost, lost]]  # fmt: skip
        taken = np.array(rows)[:, : 3 + filtered]  # of log m, log m·D, log K_p without K_i, log cosh h
        variances = np.maximum(np.einsum("ij,jk,ik->i", taken, covariance, taken), 0.0)  # which rounding can undo
        of_m, of_product, of_gain, of_cosh = 1.96 * np.sqrt(variances)
        h = 0.5 * abs(float(np.log(K_v * D / K_i)))
        log_cosh = np.logaddexp(h, -h) - np.log(2.0)
        low, high = np.arccosh(np.exp(np.clip([log_cosh - of_cosh, log_cosh + of_cosh], 0.0, 99.0)))
        apart = max(high - h, h - low)
        return np.array([of_m + apart, of_gain + share * (of_product + apart), of_product + apart])

    def _linear(self, corner: float) -> Real:
        """Return start values of the logarithms of the gains for a filter, by a fit that is linear in sums of them."""
        error = self.r - self.z
        parts = (-self._velocity(corner), error, self._integral(error))
        columns = np.column_stack([self._off(part[self.used]) for part in parts])
        D, P, both = np.linalg.lstsq(columns, self.without, rcond=None)[0]
        D, tau = max(abs(float(D)), 1e-9), self._settling(np.log([1.0, 1.0, 1.0, corner]))
        roots = np.abs(np.roots([1.0, -(P - both * tau) / D, both / D]))
        high, low = max(float(roots.max()), 1e-3), max(float(roots.min()), 1e-3)
        return np.log([high, D * (1.0 + low * tau), low * D, corner])

    def _apart(self, log_values: Real, shares: tuple[float, ...]) -> float:
        """Return the least squared residual [V²] with a share of the reference velocity through the loop's integral."""
        K_i = np.exp(log_values[2])
        others = np.linalg.qr(self.sized[:, [0, 2, 3]])[0]
        rests = [self.u - self.volts(log_values) - share * K_i * self.fed[:, 1] for share in shares]
        return min(float(np.sum((rest - others @ (others.T @ rest)) ** 2)) for rest in rests)


def _lag_of(velocity: Real, late: Real, rate: float) -> tuple[float, float]:
    """Return the lag [s] of a position that is late [m], and its 95 % half-width.

    It is that in the second half of each way, when the integral has made good what friction adds behind a reversal.
    """
    turns = np.concatenate([[0], np.flatnonzero(np.diff(np.sign(velocity))) + 1, [len(velocity)]])
    n = np.arange(len(velocity))
    way = np.searchsorted(turns, n, "right")
    settled = 2 * n + 1 >= turns[way - 1] + turns[way]
    X: Real = np.column_stack([velocity, np.gradient(velocity, 1 / rate)])[settled]
    X, y = X[:, X.any(axis=0)], late[settled]
    slopes = np.asarray(np.linalg.lstsq(X, y, rcond=None)[0])
    return float(slopes[0]), 1.96 * float(np.sqrt(hac_covariance(X, y - X @ slopes, [len(y)])[0, 0]))


def _fitted(r: Real, z: Real, u: Real, rate: float, lag: float | None = None) -> tuple[_Fit, Real, Real, Real]:
    """Return a fit to a voltage of the same instants or a sample later, by what they explain, and what it gives.

    Many controllers give out a sample after they have measured. Where the likelihoods do not tell, the intervals hold
    both.
    """
    fits = [_Fit(r, z, u, rate, lag=lag)]
    fits += [_Fit(r[:-1], z[:-1], u[1:], rate, late=1 / rate)] if lag is None else []
    made = [(fit, *fit.best()) for fit in fits]
    rests = [fit.rest(found) for fit, found, *_ in made]
    (best, rest), *more = sorted(enumerate(rests), key=lambda item: float(np.mean(item[1] ** 2)))
    fit, found, half, order = made[best]
    for other, left in more:
        least, other_mean = (max(float(np.mean(item**2)), 1e-300) for item in (rest, left))
        if len(rest) * np.log(other_mean / least) < CHANCE * memory(rest - rest.mean()):
            half = np.hypot(half, made[other][0].difference(made[other][1], found)[: len(half)])
    return fit, found, half, order
