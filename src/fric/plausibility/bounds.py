"""What no drive can be, by physics: what lies beyond these bounds is most often a unit that was taken for another.

Each bound is generous: from a micro-tribometer (µN, or rad) to an axis of 10 t nothing real comes near it. What lies
beyond ends in an error, which `lifted` turns into a warning that a number is wrong until it is mended. Much passes that
is wrong all the same: where mass, force and force constant are wrong by one factor, no law of physics tells.
So force in kN that is taken for N passes where no plant, static map or frequency response stands beside it; but what
few machines have is told, for most often it is a unit.
"""

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass
from math import isfinite

from fric.errors import FricError
from fric.estimate import Estimate
from fric.flaws.unit import BOUNDS, IMPLAUSIBLE, UNUSUAL
from fric.notice import Notice, once
from fric.units import OF_FORCE, Motion, drive_unit, rotates, si_unit

_lifted: ContextVar[bool] = ContextVar("implausible", default=False)


def lift(allowed: bool) -> None:
    """Say whether what is implausible is taken as it is from here on."""
    _lifted.set(allowed)


@contextmanager
def lifted() -> Iterator[None]:
    """Take what is implausible as it is, with a warning, within the block."""
    before = _lifted.set(True)
    try:
        yield
    finally:
        _lifted.reset(before)


@dataclass(frozen=True)
class Finding:
    """A quantity that is to be held against its bound: the bound's name, the value in SI, and where it is from.

    Below what is ``usual`` for a linear axis of a machine nothing is impossible, but told.
    """

    name: str
    value: float
    motion: Motion
    where: str = ""
    usual: float = 0.0

    def beyond(self) -> bool:
        """Say whether it is beyond what a drive can be; a value that is not known is not."""
        bound = BOUNDS[self.name]
        low, high = bound.rotary if rotates(self.motion) else bound.linear
        return isfinite(self.value) and not low <= self.value <= high and not self._of_drive

    @property
    def _of_drive(self) -> bool:
        """Whether it is in a unit of the drive's own, of which nothing is known."""
        return bool(drive_unit(self.motion)) and BOUNDS[self.name].dimension in OF_FORCE

    def unusual(self) -> bool:
        """Say whether few machines have it."""
        return not rotates(self.motion) and not self._of_drive and 0.0 < self.value < self.usual

    def notice(self) -> Notice:
        """Return what is told of it."""
        unit = si_unit(BOUNDS[self.name].dimension, self.motion)
        flaw = UNUSUAL if self.unusual() else IMPLAUSIBLE
        return flaw[self.name].found(value=Estimate(self.value, unit), usual=Estimate(self.usual, unit))


def settled(findings: Iterable[Finding], hint: str = "") -> list[Notice]:
    """Return what is unusual, or, where that is lifted, what is implausible, as warnings.

    findings: What was found.
    hint: What to do about an error; by default to look at the units of the file.
    Raises FricError: When something is implausible, and that is not lifted.
    """
    known = list(findings)
    found = [finding for finding in known if finding.beyond()]
    if found and not _lifted.get():
        first, bound = found[0], BOUNDS[found[0].name]
        raise FricError(
            str(first.notice()), where=first.where,
            hint=f"{hint or f'Look at the units of {bound.units}'}; where it is so, say --implausible ok.",
        )  # fmt: skip
    unusual = [] if _lifted.get() else [finding for finding in known if finding.unusual()]
    return list(once(finding.notice() for finding in found or unusual))
