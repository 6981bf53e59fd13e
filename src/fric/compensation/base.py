"""What a compensation scheme is: a friction model to feed forward or none, an observer or none."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from fric.errors import FricError


@dataclass(frozen=True)
class Compensation:
    """A compensation scheme.

    Parameters
    ----------
    name
        What it is called for, as ``a`` to ``f`` of the paper.
    title
        What it is, in a few words.
    friction
        Name of the friction model that is fed forward (``static``, ``gms``, …); None for no feedforward.
    observer
        True where the axis' disturbance observer is on.
    gain
        Gain of the friction feedforward; None for that of the machine.
    """

    name: str
    title: str
    friction: str | None = None
    observer: bool = False
    gain: float | None = None


NONE = Compensation("a", "none")

PAPER_SCHEMES: dict[str, Compensation] = {
    scheme.name: scheme
    for scheme in (
        NONE,
        Compensation("b", "static", friction="static"),
        Compensation("c", "GMS", friction="gms"),
        Compensation("d", "observer", observer=True),
        Compensation("e", "static + observer", friction="static", observer=True),
        Compensation("f", "GMS + observer", friction="gms", observer=True),
    )
}
"""The six schemes of Table 2."""


def choose_schemes(asked: str, known: Mapping[str, Compensation] | None = None) -> list[Compensation]:
    """Return the schemes that are asked for, as ``f``, ``a,d,f`` or ``all``.

    Parameters
    ----------
    asked
        Names, separated by commas, or ``all``.
    known
        Schemes by name; those of the paper where not given.

    Raises
    ------
    FricError
        When a name is not known.
    """
    known = PAPER_SCHEMES if known is None else known
    names = list(known) if asked == "all" else [name.strip() for name in asked.split(",")]
    for name in names:
        if name not in known:
            raise FricError(f"there is no scheme '{name}'", mend=f"There are {', '.join(known)}, and all.")
    return [known[name] for name in names]
