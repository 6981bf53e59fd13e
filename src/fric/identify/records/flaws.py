"""What is amiss with records, judged once for `inspect` and every `identify`: clock, encoder, place and time.

Each flaw has its code: ``force-clipped``, ``input-clipped``, ``force-coarse``, ``samples-lost``, ``sampling-jitters``,
``encoder-errs``, ``force-over-position``, ``friction-over-position``, ``force-drifts``.
"""

from collections.abc import Iterable, Sequence
from math import inf, sqrt
from typing import Literal

import numpy as np

from fric.identify.records.clipping import clipped_among
from fric.identify.records.encoder_error import encoder_error
from fric.identify.records.over_strokes import OverPlace, over_time
from fric.identify.records.segments import Segment
from fric.identify.records.timing import timing
from fric.log import Log
from fric.notice import Notice, Severity
from fric.units import readable

Purpose = Literal["static", "gms", "plant", "inspect"]
Strokes = Sequence[tuple["Log", "Segment"]]

SMALL = 0.01
"""Share of the friction up to which what varies over place or time is no more than good to know."""
FASTER = 1.2
"""Ratio of speeds from which on a record shows the jitter that a slower one does."""
HALF_WIDTHS = 1.0
"""Half-widths of the tightest interval of a level from which on an estimate is wrong by what varies."""
COARSE = 12
"""Steps of the force's range up to which means over strokes and hysteresis cycles are off by the steps."""


def record_flaws(logs: Sequence[Log], purpose: Purpose) -> list[Notice]:
    """Return what is amiss with records whatever moves in them: forces and inputs that are clipped, and their clock.

    Parameters
    ----------
    logs
        The records.
    purpose
        What they are wanted for, as in `clock_flaws`.
    """
    channels = ("input", "force") if purpose == "plant" else ("force",)
    found = []
    for name in channels:
        had = [(log, values) for log in logs if (values := getattr(log, name)) is not None]
        counted = clipped_among([values for _, values in had])
        found += [(log, name, samples) for (log, _), samples in zip(had, counted, strict=True)]
    return [
        Notice(
            f"{log.where}: the {name} is clipped in {samples} samples: what lies beyond is missing. Log with a larger "
            "range of the trace.", f"{name}-clipped", "wrong",
        )
        for log, name, samples in found if samples
    ] + ([] if purpose == "static" else _coarse_force(logs)) + clock_flaws(logs, purpose)  # fmt: skip


def _coarse_force(logs: Sequence[Log]) -> list[Notice]:
    """Return that the force comes in steps which are no small part of it."""
    levels = [np.unique(log.force) for log in logs if log.force is not None]
    if not levels or sum(map(len, levels)) > COARSE * len(levels):  # noise of the channel itself is finer
        return []
    forces = np.unique(np.concatenate(levels))
    step = float(np.min(np.diff(forces))) if len(forces) > 1 else 0.0
    return coarse_force(step, logs[0]) if 0.0 < float(np.ptp(forces)) <= COARSE * step else []


def coarse_force(step: float, log: Log) -> list[Notice]:
    """Return what to say where the force of a record comes in such steps [N]."""
    return [Notice(
        f"the force comes in steps of {readable(step, log.unit('force'))}: what lies between them is lost, and "
        "forces are off by up to half a step. Log it finer.", "force-coarse", "doubt",
    )]  # fmt: skip


def clock_flaws(logs: Sequence[Log], purpose: Purpose) -> list[Notice]:
    """Return what the positions of records tell of their clock: samples lost unsaid, instants that jitter.

    Parameters
    ----------
    logs
        The records.
    purpose
        What they are wanted for: the mean of a stroke bears jitter, a response and an acceleration do not.
    """
    found = [(log, timing(log)) for log in logs]
    warnings = []
    if lost := [(log, one.lost) for log, one in found if one.lost]:
        worst = max(share for _, share in lost)
        warnings.append(Notice(
            f"{_records(log for log, _ in lost)}: {worst:.2g} of the samples were lost, and the time was counted on as "
            "if they were not: speeds and times are wrong by that. Log at a lower rate or fewer channels, or with the "
            "time of each sample.", "samples-lost", "wrong",
        ))  # fmt: skip
    # what jitters shows in every record that is as fast; a ripple of one speed is no jitter
    unmoved = [one.speed for _, one in found if one.speed and not (one.jitter or one.lost)]
    if jitters := [(log, one) for log, one in found if one.jitter and FASTER * one.speed > max(unmoved, default=0.0)]:
        log, worst_one = max(jitters, key=lambda pair: pair[1].displaced)
        size = readable(worst_one.jitter, "s")
        warnings.append(Notice(
            f"{_records(log for log, _ in jitters)}: the position has noise that grows with speed, as where samples "
            f"are taken {size} rms off the time that is logged: {readable(worst_one.displaced, log.unit('position'))} "
            "in the position. Log by the clock of the control, or the time of each sample.",
            "sampling-jitters", "doubt" if purpose in {"static", "inspect"} else "wrong",
        ))  # fmt: skip
    return warnings


def stroke_flaws(
    strokes: Strokes, place: OverPlace | None, *, force: float = inf, half_width: float = 0.0, taken_off: bool = False
) -> list[Notice]:
    """Return what strokes at constant velocity tell of the encoder, and of what the force does over place and time.

    Parameters
    ----------
    strokes
        Constant-velocity segments, each with its record.
    place
        What `over_place` gives of them.
    force, half_width
        Friction that was identified from them, and half of the tighter of the intervals of Coulomb friction and offset
        [N]; these say how much is too much.
    taken_off
        Whether what comes again at the same places was taken off the map.
    """
    if not strokes:
        return []
    warnings = []
    unit, length = (strokes[0][0].unit(channel) for channel in ("force", "position"))
    if (error := encoder_error(strokes)) is not None:
        warnings.append(Notice(
            f"the position ripples with a pitch of {readable(error.pitch, length)} at every speed, by "
            f"{readable(error.amplitude, length)}: a sub-divisional error of the encoder. Knots of that size are not "
            "of friction; adjust the reading head, or log a finer encoder.", "encoder-errs", "doubt",
        ))  # fmt: skip
    if place is not None:
        alike = place.cogging == place.friction  # the strokes of the two directions do not meet: it may be either
        for size, code, what, hint in (
            (place.cogging, "force-over-position", "a force over position (cogging, a cable, gravity of a balance)"
             + (" or friction over position" if alike else ""),
             "Log each speed over the same whole stroke, and take that force off"),
            (0.0 if alike else place.friction, "friction-over-position",
             "friction over position (rolling elements, alignment, preload)",
             "Log each speed over the same whole stroke"),
        ):  # fmt: skip
            if size > 0.0:
                means = (
                    "The map is the mean over all these places"
                    if taken_off
                    else "The map is that of the places where each speed was logged"
                )
                varies = sqrt(2.0) * size * (sqrt(2.0) if alike else 1.0)
                warnings.append(Notice(
                    f"at the same places of {readable(place.length, length)} strokes take the same force, which varies "
                    f"by {readable(varies, unit)}: {what}. {means}. {hint}.", code,
                    _severity(varies, force, half_width),
                ))  # fmt: skip
    if (time := over_time(strokes)) is not None:
        severity = _severity(abs(time.change) * force, force, half_width)
        pauses = "" if time.clocked else ", and more in the pauses between them"
        drifts = "drifts" if time.sure else "may drift"
        warnings.append(Notice(
            f"the force {'rises' if time.rate > 0 else 'falls'} within strokes by {100 * abs(time.rate) * 60:.2g} % "
            f"a minute at every speed, which is {100 * abs(time.change):.2g} % over these records{pauses}: friction or "
            f"force constant {drifts}. Run the axis warm first, and log the speeds in another order, each again.",
            "force-drifts", severity if time.sure and (time.clocked or severity != "note") else "doubt",
        ))  # fmt: skip
    return warnings


def _severity(size: float, force: float, half_width: float) -> Severity:
    """Return how bad it is that the force varies by a size [N]."""
    if force == inf:
        return "doubt"
    if size <= SMALL * abs(force):
        return "note"
    return "wrong" if size > HALF_WIDTHS * half_width else "doubt"


def _records(logs: Iterable[Log]) -> str:
    """Return the names of records, or how many they are."""
    names = [log.name for log in logs]
    return f"record '{names[0]}'" if len(names) == 1 else f"{len(names)} records (as '{names[0]}')"
