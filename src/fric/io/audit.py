"""What is checked of a record while it streams by: its clock, and the signs of its channels."""

from collections.abc import Callable, Mapping

import numpy as np
from numpy.typing import NDArray

from fric.arrays import Mask, Real
from fric.errors import FricError
from fric.flaws.files import SAMPLES_MISSING
from fric.notice import Notice

WINDOW = 32
"""Samples that a sampling period is taken over."""
RATES_DIFFER = 1.3
"""Two segments whose periods differ by more than this factor were sampled at two rates."""

ODD_SHARE = 0.1
"""A segment at another rate that is shorter than this, and inside the record, is missing samples."""


class Clock:
    """Checks that time runs forward, and at one rate.

    Missing samples and jitter are no second rate: that has the mean period of a window changed and four in five of its
    periods with it, for two windows one after the other. (A real log of 75 s at 200 Hz has 1.8 s in which every second
    sample is missing: that is told, and no error.)

    Parameters
    ----------
    place
        Tells where a sample is, by its row in the file.
    uneven
        Whether a record of two rates is told, and no error.
    """

    def __init__(self, place: Callable[[int], str], *, uneven: bool = False) -> None:
        self._place, self._uneven = place, uneven
        self._last: float | None = None
        self._left = np.empty(0)
        self._left_rows = np.empty(0, dtype=np.int64)
        self._periods: list[Real] = []
        self._rows: list[NDArray[np.int64]] = []
        self._window = 0
        self.samples = 0

    def tick(self, time: Real, rows: NDArray[np.int64]) -> None:
        """Take the next instants [s] and their rows in the file.

        Raises FricError: When a stamp is repeated or time runs backwards.
        """
        if not len(time):
            return
        steps = np.diff(time, prepend=time[0] if self._last is None else self._last)
        if self._last is None:
            steps, rows = steps[1:], rows[1:]
        if len(steps) and steps.min() <= 0:
            n = int(np.argmax(steps <= 0))
            now = float(time[len(time) - len(steps) + n])
            if steps[n] == 0:
                raise FricError(
                    f"the stamp {now:.9g} s is repeated", where=self._place(int(rows[n])),
                    hint="Log the time with more digits, or map it by its rate, as in `time: {rate: 4 kHz}`.",
                )  # fmt: skip
            raise FricError(
                f"time runs backwards, from {now - steps[n]:.9g} s to {now:.9g} s", where=self._place(int(rows[n])),
                hint="Split the file there, one record a file.",
            )  # fmt: skip
        self._last = float(time[-1])
        self.samples += len(time)
        self._gather(steps, rows)

    def rising(self, time: Real) -> Mask:
        """Return the samples whose stamps rise, shape (n,); the first one may be another run's last."""
        kept = np.ones(len(time), bool)
        if self._last is None and len(time) > 2 and time[0] > time[1]:
            kept[0] = False
        floor = -np.inf if self._last is None else self._last
        stamps = np.where(kept, time, -np.inf)
        before = np.maximum.accumulate(np.concatenate([[floor], stamps[:-1]]))
        return np.asarray(kept & (stamps > before))

    def _gather(self, steps: Real, rows: NDArray[np.int64]) -> None:
        if not self._window:
            self._window = int(np.clip(len(steps) // 8, 4, WINDOW))
        if len(self._left):
            steps, rows = np.concatenate([self._left, steps]), np.concatenate([self._left_rows, rows])
            self._left, self._left_rows = steps[:0], rows[:0]
        if len(steps) and steps.max() < RATES_DIFFER * steps.min():  # as nearly always: one entry for all of them
            mean = steps.mean()
            self._periods.append(np.array([[mean], [mean], [mean], [len(steps) / self._window]]))
            self._rows.append(rows[:1].copy())  # a view would keep all of the rows
            return
        count = len(steps) // self._window
        cut = count * self._window
        self._left, self._left_rows = steps[cut:], rows[cut:]
        if not count:
            return
        windows, fifth = np.sort(steps[:cut].reshape(count, self._window), axis=1), self._window // 5
        once = np.ones(count)
        self._periods.append(np.stack([windows.mean(axis=1), windows[:, fifth], windows[:, -1 - fifth], once]))
        self._rows.append(rows[: cut : self._window].copy())

    def stop(self) -> list[Notice]:
        """End the record; return what the user should know of its clock.

        Raises FricError: When the record was sampled at two rates: a tenth of it or more, or its beginning or end.
        """
        if not self._rows:
            return []
        mean, short, long, windows = np.concatenate(self._periods, axis=1)
        rows = np.concatenate(self._rows)
        if windows.sum() < 4:  # too short to tell
            return []
        order = np.argsort(mean)
        upto = np.cumsum(windows[order])
        usual = float(mean[order][np.searchsorted(upto, upto[-1] / 2)])
        slower = (mean > RATES_DIFFER * usual) & (short > RATES_DIFFER * usual)
        faster = (mean * RATES_DIFFER < usual) & (long * RATES_DIFFER < usual)
        for odd in (slower, faster):
            segment = odd & (np.append(odd[1:], False) | np.append(False, odd[:-1]) | (windows > 1))
            if not segment.any():
                continue
            n = int(np.argmax(segment))
            edge = int(rows[n if n else np.argmin(segment)])
            text = f"{1 / mean[n]:.4g} Hz there, {1 / usual:.4g} Hz elsewhere"
            spent = mean * windows
            share = float(spent[segment].sum() / spent.sum())
            if not self._uneven and (share > ODD_SHARE or segment[0] or segment[-1]):
                raise FricError(
                    f"two sampling rates in one record: {text}", where=f"{self._place(edge)} (about)",
                    hint="Split the file there, one record a rate.",
                )  # fmt: skip
            return [SAMPLES_MISSING.found(f"{self._place(edge)} (about)", rates=text)]
        return []


class Signs:
    """Weighs whether the channels agree in sign: friction takes work from the drive, and velocity is dx/dt.

    Work and agreement are summed over windows, so that the steps of an encoder and noise average out.
    """

    def __init__(self) -> None:
        self.work = np.zeros(2)
        self.agreement = np.zeros(2)

    def add(self, block: Mapping[str, Real]) -> None:
        """Take the next samples of each channel, in SI."""
        time, x, v, force = (block.get(name) for name in ("time", "position", "velocity", "force"))
        if time is None and v is not None and force is not None:  # a table of mean forces
            self.work += _weighed(force * v)
        if time is None or len(time) < 2:
            return
        moved = np.diff(x) if x is not None and v is None else None
        if v is not None:
            moved = (v[1:] + v[:-1]) * np.diff(time)  # twice the travel: factors do not matter here
            if x is not None:
                self.agreement += _weighed(np.diff(x[:-1:WINDOW], append=x[-1]) * _summed(moved))
        if force is not None and moved is not None:
            self.work += _weighed(_summed((force[1:] + force[:-1]) * moved))

    def against(self) -> str:
        """Return what runs against its meaning: ``force``, ``velocity``, or nothing."""
        for name, (total, size) in (("velocity", self.agreement), ("force", self.work)):
            if size > 0 and total < -0.5 * size:
                return name
        return ""


def _summed(values: Real) -> Real:
    return np.add.reduceat(values, np.arange(0, len(values), WINDOW))


def _weighed(values: Real) -> Real:
    return np.array([values.sum(), np.abs(values).sum()])
