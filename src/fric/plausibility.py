"""Bounds that physics sets on a drive: a value beyond them is most often in a wrong unit.

Each bound is generous: from a micro-tribometer (µN, or rad) to an axis of 10 t nothing real comes near it. A value
beyond a bound is an error, which `lifted` turns into a warning. Not every wrong unit is detected: where mass, force and
force constant are wrong by the same factor, no law of physics is violated. So force in kN that is read as N passes
where no plant, static map or frequency response is given. A value that few machines have gives a warning, for it is
most often in a wrong unit.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from contextlib import AbstractContextManager
from contextvars import ContextVar
from dataclasses import dataclass, replace
from math import isfinite, nan
from typing import TYPE_CHECKING

from fric.columns import PRESLIDING
from fric.errors import FricError
from fric.estimate import Estimate
from fric.flaws.unit import BOUNDS, IMPLAUSIBLE, LIFT, UNUSUAL
from fric.log import Log
from fric.notice import Notice, once
from fric.process import holding
from fric.units import OF_FORCE, Motion, drive_unit, rotates, si_unit

if TYPE_CHECKING:  # which compile
    from fric.drive.plant import LinearPlant, Plant
    from fric.friction.stribeck import StaticMap

TOGETHER = 0.99  # Correlation of position and reference above which the position follows the reference
_lifted: ContextVar[bool] = ContextVar("implausible", default=False)


def of_logs(logs: Sequence[Log], plant: Plant | None = None) -> Iterator[Finding]:
    """Yield the quantities of records with physical bounds: speed, rate, and agreement of their channels.

    plant: The plant, with whose force constant the force is compared.
    """
    import numpy as np  # `fric --help` need not

    squares = np.zeros(2)
    for log in logs:
        if len(log) < 16:
            continue
        motion, where = log.motion, log.where
        yield Finding("sampling", 1.0 / float(np.median(np.diff(log.time))), motion, where)
        yield Finding("speed", speed_of(log), motion, where)
        if log.velocity is not None and log.position is not None:
            between = np.append(0.0, np.cumsum(0.5 * (log.velocity[1:] + log.velocity[:-1]) * np.diff(log.time)))
            ratios = []  # over short and long windows, along the position: a velocity may be the noise of its counts
            for step in {min(8, len(log) // 4), len(log) // 16, len(log) // 4}:
                moved, travel = (x[step:] - x[:-step] for x in (log.position, between))
                size, along = float(moved @ moved), abs(float(moved @ travel))
                ratios += [size / along, float(np.sqrt(size / (travel @ travel)))] if size and along else []
            if ratios:
                yield Finding("travel", min(ratios, key=lambda ratio: abs(np.log(ratio))), motion, where)
        if log.position is not None and log.reference is not None and np.ptp(log.reference) and np.ptp(log.position):
            yield Finding("following", float(np.ptp(log.position) / np.ptp(log.reference)), motion, where)
            z, asked = (log.position - log.position.mean()), (log.reference - log.reference.mean())
            both, of_z, of_asked = z @ asked, z @ z, asked @ asked
            if both**2 > TOGETHER**2 * of_z * of_asked:
                yield Finding("scale", float(abs(both) / of_asked), motion, where)
        if log.force is not None and log.input is not None:
            squares += [float(log.force @ log.force), float(log.input @ log.input)]
    if squares.all():
        ratio = float(np.sqrt(squares[0] / squares[1]))
        yield Finding("force-per-input", ratio, logs[0].motion, logs[0].source)
        if plant is not None:
            yield Finding("force-constant", ratio / plant.K_f, logs[0].motion, logs[0].source)


def speed_of(log: Log) -> float:
    """Return the greatest speed of a record but for a hundredth of its samples; NaN without velocity and position."""
    import numpy as np

    if log.velocity is not None:
        return float(np.quantile(np.abs(log.velocity), 0.99))
    if log.position is None or len(log) < 4:
        return nan
    step = min(8, len(log) // 4)
    z, t = log.position, log.time
    return float(np.quantile(np.abs(z[step:] - z[:-step]) / (t[step:] - t[:-step]), 0.99))


def of_friction(static: StaticMap, motion: Motion, mass: float | None = None, where: str = "") -> Iterator[Finding]:
    """Yield the quantities of a static map with physical bounds, and its size relative to the mass that it moves."""
    level = max(abs(static.F_s), abs(static.F_c))
    yield Finding("friction", level, motion, where, usual=0.5)
    yield Finding("viscous", static.sigma, motion, where)
    if static.F_s > static.F_c:  # else v_s has no effect
        yield Finding("stribeck", static.v_s, motion, where)
    if mass:
        yield Finding("friction-over-mass", level / mass, motion, where)
        yield Finding("viscous-over-mass", abs(static.sigma) / mass, motion, where)


def of_strokes(logs: Sequence[Log]) -> Iterator[Finding]:
    """Yield the longest travel, and the greatest speed, of the records that sliding friction is identified from."""
    import numpy as np

    strokes = []
    for log in logs:
        if log.position is not None:
            strokes.append((float(np.ptp(log.position)), log))
        elif log.velocity is not None:
            strokes.append((float(np.abs(log.velocity[1:]) @ np.diff(log.time)), log))
    if strokes:
        travel, log = max(strokes, key=lambda pair: pair[0])
        yield Finding("stroke", travel, log.motion, log.where)
        yield Finding("speed", max(speed_of(log) for _, log in strokes), log.motion, log.where, usual=5e-4)


def of_amplitudes(logs: Sequence[Log]) -> Iterator[Finding]:
    """Yield the amplitudes of pre-sliding sines, and how often they were sampled."""
    import numpy as np

    for log in logs:
        if log.kind in PRESLIDING and log.position is not None:
            yield Finding("amplitude", 0.5 * float(log.position.max() - log.position.min()), log.motion, log.where)
            yield Finding("sampling", 1.0 / float(np.median(np.diff(log.time))), log.motion, log.where, usual=3.0)


def of_level(logs: Sequence[Log], F_s: float) -> Iterator[Finding]:
    """Yield the force of records over the break-away force [N] of the static map for their replay."""
    swings = [0.5 * float(log.force.max() - log.force.min()) for log in logs if log.force is not None]
    if swings and F_s > 0.0:
        yield Finding("level", max(swings) / F_s, logs[0].motion, logs[0].where)


def of_plant(plant: LinearPlant, motion: Motion, where: str = "") -> Iterator[Finding]:
    """Yield the quantities of a plant with physical bounds; the mass is known with the force constant alone."""
    for name, value in (("A", plant.A), ("B", plant.B), ("T_d", plant.T_d), ("mass", getattr(plant, "M", nan))):
        yield Finding(name, value, motion, where)


def lift(allowed: bool) -> None:
    """Set whether implausible values are accepted from here on."""
    _lifted.set(allowed)


def lifted() -> AbstractContextManager[None]:
    """Accept implausible values within the block, with a warning."""
    return holding(_lifted, True)


@dataclass(frozen=True)
class Finding:
    """A quantity that is compared with its bound: the bound's name, the value in SI, and where it is from.

    A value below what is ``usual`` for a linear axis of a machine is possible, but gives a warning.
    """

    name: str
    value: float
    motion: Motion
    where: str = ""
    usual: float = 0.0

    def beyond(self) -> bool:
        """Return whether it is beyond the range of real drives; an unknown value is not."""
        bound = BOUNDS[self.name]
        low, high = bound.rotary if rotates(self.motion) else bound.linear
        return isfinite(self.value) and not low <= self.value <= high and not self._of_drive

    @property
    def _of_drive(self) -> bool:
        """Whether it is in a unit of the drive, whose size is not known."""
        return bool(drive_unit(self.motion)) and BOUNDS[self.name].dimension in OF_FORCE

    def unusual(self) -> bool:
        """Return whether few machines have it."""
        return not rotates(self.motion) and not self._of_drive and 0.0 < self.value < self.usual

    def notice(self, mend: str = "") -> Notice:
        """Return the sentence of the error or warning, with what to do about an implausible value."""
        unit = si_unit(BOUNDS[self.name].dimension, self.motion)
        flaw = UNUSUAL[self.name] if self.unusual() else replace(IMPLAUSIBLE[self.name], mend=mend)
        return flaw.found(value=Estimate(self.value, unit), usual=Estimate(self.usual, unit), falls=self.value < 0.0)


def doubts(findings: Iterable[Finding]) -> list[Notice]:
    """Return implausible values as warnings, for records of which nothing is identified yet."""
    found = [finding for finding in findings if finding.beyond()]
    return list(once(finding.notice(f"Look at the units of {BOUNDS[finding.name].units}.") for finding in found))


def settled(findings: Iterable[Finding], hint: str = "") -> list[Notice]:
    """Return unusual values as warnings; implausible values, too, where `lifted`.

    hint: What to do about an error; by default to look at the units of the file.
    """
    known = list(findings)
    if (found := [finding for finding in known if finding.beyond()]) and not _lifted.get():
        first = found[0]
        mend = f"{hint}; where it is so, say {LIFT}." if hint else IMPLAUSIBLE[first.name].mend
        raise FricError(str(first.notice()).rstrip("."), where=first.where, hint=mend)
    unusual = [] if _lifted.get() else [finding for finding in known if finding.unusual()]
    return list(once(finding.notice() for finding in found or unusual))
