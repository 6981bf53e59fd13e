"""What no drive can be, by physics: what lies beyond these bounds is most often a unit that was taken for another.

Each bound is generous: from a micro-tribometer (µN, or rad) to an axis of 10 t nothing real comes near it. What lies
beyond ends in an error, which `lifted` turns into a warning that a number is wrong until it is mended. Much passes that
is wrong all the same: where mass, force and force constant are wrong by one factor, no law of physics tells.
So force in kN that is taken for N passes where no plant, static map or frequency response stands beside it; but what
few machines have is told, for most often it is a unit.
"""

from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass
from math import isfinite

from fric.errors import FricError
from fric.notice import Notice
from fric.units import Motion, readable, si_unit

Limits = tuple[float, float]


@dataclass(frozen=True)
class Bound:
    """What a quantity of a real drive is not beyond.

    Parameters
    ----------
    what
        The quantity, in words.
    dimension
        What it measures, see `fric.units`.
    linear, rotary
        Least and greatest value in SI.
    reason
        Why nothing real is beyond.
    units
        What is to be looked at.
    """

    what: str
    dimension: str
    linear: Limits
    rotary: Limits
    reason: str
    units: str


BOUNDS: Mapping[str, Bound] = {
    "speed": Bound(
        "the speed", "velocity", (0.0, 25.0), (0.0, 2e5),
        "linear motors reach 10 m/s, the fastest spindles 1e5 rad/s", "position and time",
    ),
    "sampling": Bound(
        "the sampling rate", "frequency", (0.0, 5e5), (0.0, 5e5),
        "drives log and close their loops at 100 kHz at most", "the time",
    ),
    "travel": Bound(
        "the travel by the position over that by the velocity", "ratio", (0.2, 5.0), (0.2, 5.0),
        "both are of one motion", "position, velocity and time",
    ),
    "following": Bound(
        "the travel of the position over that of its reference", "ratio", (5e-3, 200.0), (5e-3, 200.0),
        "an axis goes where it is told to, more or less", "position and reference",
    ),
    "scale": Bound(
        "the slope of the position over its reference, which it follows,", "ratio", (0.2, 5.0), (0.2, 5.0),
        "an angle in degrees is 57 times one in rad, an inch 25 mm", "position and reference",
    ),
    "stroke": Bound(
        "the longest stroke", "position", (2e-6, 1e3), (1e-6, 1e9),
        "contacts, seals and belts yield by as much before they slide, and this is a map of sliding", "the position",
    ),
    "amplitude": Bound(
        "the amplitude of a pre-sliding sine", "position", (0.0, 5e-2), (0.0, 100.0),
        "contacts, seals and belts yield by 2 mm at most before they slide", "the position",
    ),
    "force-per-input": Bound(
        "force over input", "force per input", (0.0, 1e5), (0.0, 1e5),
        "10 V would make a force of 100 t", "force and input",
    ),
    "force-constant": Bound(
        "the force over K_f times the input", "ratio", (1 / 30, 30.0), (1 / 30, 30.0),
        "the plant's force constant says what force a voltage makes", "force, input and the plant's K_f",
    ),
    "friction": Bound(
        "the friction", "force", (0.0, 5e4), (0.0, 5e4),
        "10 t sliding dry on steel take 50 kN", "the force",
    ),
    "friction-over-mass": Bound(
        "friction over moving mass", "acceleration", (0.0, 500.0), (0.0, 3e6),
        "friction of 50 times its own weight holds no drive", "force, input and position",
    ),
    "viscous-over-mass": Bound(
        "viscous friction over moving mass", "rate", (0.0, 1e4), (0.0, 1e5),
        "no friction brings an axis to rest within 0.1 ms", "position and time, of the log or of the plant",
    ),
    "inertia": Bound(
        "inertia over the logged force", "ratio", (0.0, 10.0), (0.0, 10.0),
        "no force can give a mass ten times the acceleration that it has for it", "position, time, force and the plant",
    ),
    "damping": Bound(
        "the drive's own damping over the logged force", "ratio", (0.0, 10.0), (0.0, 10.0),
        "a drive cannot move against ten times its force", "position, time, force and the plant",
    ),
    "level": Bound(
        "the force of the records over F_s of the static map", "ratio", (5e-3, 20.0), (5e-3, 20.0),
        "both are of one axis", "the force of either log",
    ),
    "slip": Bound(
        "the travel up to sliding", "position", (0.0, 5e-3), (0.0, 10.0),
        "contacts, seals and belts yield by 2 mm at most before they slide", "the position",
    ),
    "stiffness": Bound(
        "the stiffness", "stiffness", (0.0, 5e10), (0.0, 1e10),
        "a guideway of 10 t yields by more than 50 N per nm, and so does a bar of steel", "force and position",
    ),
    "mass": Bound(
        "the moving mass K_f/B", "mass", (1e-7, 1e5), (1e-13, 1e5),
        "axes weigh from below a gram to 100 t, what turns with them included", "force, input and position",
    ),
    "B": Bound(
        "B", "acceleration per input", (1e-5, 1e5), (1e-4, 1e8),
        "1 V gives an axis between a millionth and ten thousand times the acceleration of gravity",
        "input, position and time",
    ),
    "A": Bound("A", "rate", (0.0, 1e5), (0.0, 1e5), "no mass comes to rest within 10 µs", "position and time"),
    "T_d": Bound("T_d", "time", (0.0, 0.25), (0.0, 0.25), "no servo loop closes over a quarter second", "the time"),
}  # fmt: skip

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
        low, high = bound.rotary if self.motion == "rotary" else bound.linear
        return isfinite(self.value) and not low <= self.value <= high

    def unusual(self) -> bool:
        """Say whether few machines have it."""
        return self.motion == "linear" and 0.0 < self.value < self.usual

    def notice(self) -> Notice:
        """Return what is told of it."""
        bound = BOUNDS[self.name]
        unit = si_unit(bound.dimension, self.motion)
        shown = readable(self.value, unit)
        if self.unusual():
            return Notice(
                f"{bound.what} is {shown}, and few machines are below {readable(self.usual, unit)}: is the unit of "
                f"{bound.units} right? Where it is, say --implausible ok.",
                f"unusual-{self.name}", "doubt",
            )  # fmt: skip
        return Notice(f"{bound.what} is {shown}: {bound.reason}", f"implausible-{self.name}", "wrong")


def settled(findings: Iterable[Finding]) -> list[Notice]:
    """Return what is unusual, or, where that is lifted, what is implausible, as warnings.

    Raises
    ------
    FricError
        When something is implausible, and that is not lifted.
    """
    known = list(findings)
    found = [finding for finding in known if finding.beyond()]
    if found and not _lifted.get():
        first, bound = found[0], BOUNDS[found[0].name]
        raise FricError(
            str(first.notice()), where=first.where,
            hint=f"Look at the units of {bound.units}; where it is so, say --implausible ok.",
        )  # fmt: skip
    unusual = [] if _lifted.get() else [finding for finding in known if finding.unusual()]
    return list(dict.fromkeys(finding.notice() for finding in found or unusual))
