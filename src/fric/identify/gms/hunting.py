"""Error of a GMS model due to hunting between encoder counts, from simulated records.

A slow sine in closed loop goes from count to count: at each the drive is pushed back, and creeps on. The friction goes
through minor cycles below the virgin curve, which a log does not resolve in time or position. They recur in every
cycle, so the scatter of the residuals does not show them. But the identified motion, friction and plant can be
simulated in closed loop, with other offsets of the encoder: the intervals must cover the errors of a fit to those
records, whose truth is known.

The log does not show the controller. So the records are simulated once with a soft and once with a stiff cascade, both
with usual margins for this plant. If the measured records hunt less (`hunting_share`), their error is scaled down.
Without a known plant, a usual plant with a heavy mass is simulated, and the error is scaled up as well.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from math import inf, pi

import numpy as np
from scipy.special import stdtrit

from fric.arrays import Real
from fric.control.cascade import Cascade
from fric.drive.plant import Plant, hold_delay
from fric.drive.sensing import Encoder
from fric.estimate import as_filed
from fric.friction import FrictionModel
from fric.identify.replay.replay_fit import replay_covariance
from fric.identify.replay.replay_search import Search
from fric.records.prepared import Prepared, prepared
from fric.reference import Reference, cubic_spline
from fric.simulate.axis import run_axis
from fric.simulate.machine import Axis
from fric.simulate.reality.trace import logged

CYCLES = 2  # Number of whole cycles of a record to simulate
RATE, FILTER = 4000.0, 500.0  # Least sampling rate of the controller, and corner of the low-pass on its velocity [Hz]
PLACES = 3  # Number of places between two counts for the simulations with each cascade
FINEST = 1 / 4096  # Resolution of the reference in counts: the last bits of a smoothed record depend on the processor
LAGS = (20.0, 12.0)
"""Period of crossover over all lags, of soft and stiff cascade: phase margins 66° and 54°, gain margins 14, 10 dB."""
ACCURACY = 1e-10  # Largest error of the position by the integration [m]
RESONANCE = 50.0  # Frequency of a heavy mass on its contact before sliding, if the mass is not known [Hz]
DELAY = 2 / RATE  # Assumed delay of a drive without a known plant [s]
MOST_SIMULATED = 1_000_000  # Largest number of controller samples in a simulated record
MEMORY = 8  # Lags at which residuals are compared [samples]


def usual_cascade(plant: Plant, sampling: float, lags: float) -> Cascade:
    """Return a cascade by the usual rules: a crossover that suits the lags, K_v a third of it, K_i/K_p a tenth.

    sampling: Sampling of the controller [Hz].
    lags: Period of its crossover over all lags in its velocity loop.
    """
    crossover = 2 * pi / lags / (plant.T_d + 1 / (2 * pi * FILTER) + hold_delay(sampling))
    K_p = crossover / plant.B
    return Cascade(crossover / 3, K_p, K_p * crossover / 10, FILTER, sampling, inf)


@dataclass(frozen=True)
class Hunting:
    """Contribution of hunting between two counts to the covariance of a fit by replay."""

    plant: Plant | None  # The plant that drives the axis; None where it is not known, and a usual one does
    places: int = PLACES  # Places between two counts with each cascade
    _known: dict[int, Real] = field(default_factory=dict)

    def __call__(self, search: Search, x: Real, seen: Real) -> Real:
        """Return the increase of the covariance (s, s) in the directions that the records determine.

        The same blocks of the same records hunt in the same way, and are simulated once.

        seen: The determined directions, shape (p, s).
        """
        size = seen.shape[1]
        if not any(map(_counts, search.records)):
            return np.zeros((size, size))
        if size not in self._known:
            rng = np.random.default_rng(0)
            errors = np.array([self._error(search, x, seen, lags, rng) for lags in LAGS for _ in range(self.places)])
            self._known[size] = errors.T @ errors / len(errors)
        return self._known[size]

    def _error(self, search: Search, x: Real, seen: Real, lags: float, rng: np.random.Generator) -> Real:
        """Return the error of the fit to simulated records in the determined directions, shape (s,).

        It is one Gauss–Newton step from the truth. The scatter of these few records would be taken for a common
        error: the step is shrunk by James and Stein's rule, to 0 where it is within its covariance.
        """
        model = as_filed(search.coordinates.build(x))
        stiffness = float(np.sum(search.coordinates.values(x)["gms"]["k"]))
        usual = Plant(0.0, (2 * pi * RESONANCE) ** 2, DELAY, stiffness)  # a mass that swings on its contact
        plant = as_filed(self.plant or usual)
        pairs = {n: self._made_again(r, model, plant, lags, rng) for n, r in enumerate(search.records) if _counts(r)}
        # hunting is over between the samples of records too slow to be simulated for a cycle: their residuals hold it
        if not (pairs := {n: made for n, made in pairs.items() if len(made.reversals) > 1}):
            return np.zeros(seen.shape[1])
        hunting, again = [search.records[n] for n in pairs], list(pairs.values())
        rest = [record for n, record in enumerate(search.records) if n not in pairs]
        made = Search(search.coordinates, [*again, *rest]).weighed(x)
        residual, gradient = made.residual(x), made.gradient(x) @ seen
        of_again = sum(int(record.used.sum()) for record in again)
        whole = sum(int(record.used.sum()) for record in hunting)
        residual[of_again:] = 0.0  # the weight of the other records is kept
        gradient[of_again:] *= np.sqrt(of_again / whole)
        step = -np.linalg.lstsq(gradient, residual, rcond=None)[0]
        quantile = float(stdtrit(max(of_again - len(step), 1), 0.975))
        # hunting itself has a long memory, which is the error that is looked for
        covariance = replay_covariance(gradient, residual, made.records, quantile, most=1.0)
        distance = float(step @ np.linalg.pinv(covariance, hermitian=True) @ step)
        sure = max(1.0 - len(step) / distance, 0.0) if distance > 0.0 else 0.0
        hunts = hunting_share(_left_over(model, hunting), _left_over(model, again), whole)
        return np.asarray(sure * (min(hunts, 1.0) if self.plant else hunts) * step)

    def _made_again(
        self, record: Prepared, model: FrictionModel, plant: Plant, lags: float, rng: np.random.Generator
    ) -> Prepared:
        """Return some cycles of a record as the identified axis repeats them in closed loop."""
        m, first = record.motion, int(np.argmax(record.used))
        begin = int(before[-1]) if len(before := record.reversals[record.reversals < first]) else 0
        ends = record.reversals[record.reversals >= first][: 2 * CYCLES + 1]
        end = min(int(ends[-1]) + max((int(ends[-1]) - first) // 50, 2), len(m.time))
        interval = float(np.median(np.diff(m.time)))
        divider = max(round(RATE * interval), 1)
        sampling = divider / interval
        plant = replace(plant, T_d=max(plant.T_d, hold_delay(sampling)), force_lag=0.0)
        count = min(int((m.time[end - 1] - m.time[begin]) * sampling), MOST_SIMULATED)
        path = cubic_spline(m.time, np.round(m.position / (FINEST * m.step)) * (FINEST * m.step))
        t = m.time[begin] + np.arange(count) / sampling
        reference = Reference(sampling, path(t) + rng.uniform(0.0, m.step), path(t, 1), path(t, 2))
        cascade = usual_cascade(plant, sampling, lags)
        axis = Axis(record.log.axis, plant, cascade, model, encoder=Encoder(m.step), motion=record.log.motion)
        run = run_axis(axis, reference, accuracy=ACCURACY)
        log = logged(axis, run, (0, count), -(-count // divider), record.log.name, "presliding-sine", 0)
        again = prepared([log], self.plant and plant)[0].trimmed()
        return replace(again, done=replace(again.done, own=record.done.own))


def _counts(record: Prepared) -> bool:
    """Return whether a record moves back and forth on an encoder with visible counts."""
    return not record.slides and record.motion.step > 0 and len(record.reversals) > 2


def hunting_share(measured: Real, simulated: Real, count: int) -> float:
    """Return how much records may hunt, over what simulated ones do, by the autocovariances of residuals [N²].

    Noise of the force adds to lag 0 alone: the squared share is the least-squares ratio at the other lags, and two of
    its standard errors for white residuals, ``γ_0/√n``; it is at most the ratio at lag 0.
    """
    whole, size = measured[0] / max(simulated[0], 1e-300), max(float(np.linalg.norm(simulated[1:])), 1e-300)
    share = (measured[1:] @ simulated[1:] / size + 2.0 * measured[0] / np.sqrt(count)) / size
    return float(np.sqrt(np.clip(share, 0.0, whole)))


def _left_over(model: FrictionModel, records: Sequence[Prepared]) -> Real:
    """Return the autocovariance of the residual force of records at lags from 0 to `MEMORY` [N²]."""
    rest = [(record.force - record.fitted(model))[record.used] for record in records]
    sums = [sum(float(r[lag:] @ r[: len(r) - lag]) for r in rest) for lag in range(MEMORY + 1)]
    return np.array(sums) / sum(map(len, rest))
