"""What a compensation scheme is: a friction model to feed forward or none, an observer or none."""

from __future__ import annotations

from dataclasses import dataclass


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


NONE = Compensation("a", "no compensation")

PAPER_SCHEMES: dict[str, Compensation] = {
    scheme.name: scheme
    for scheme in (
        NONE,
        Compensation("b", "static feedforward", friction="static"),
        Compensation("c", "GMS feedforward", friction="gms"),
        Compensation("d", "disturbance observer", observer=True),
        Compensation("e", "static feedforward and observer", friction="static", observer=True),
        Compensation("f", "GMS feedforward and observer", friction="gms", observer=True),
    )
}
"""The six schemes of Table 2."""
