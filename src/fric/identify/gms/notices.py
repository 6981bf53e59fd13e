"""What pre-sliding data cannot tell, in the user's words."""

from collections.abc import Iterator

import numpy as np

from fric.arrays import Real
from fric.identify.gms.changes import changes
from fric.identify.gms.fit import GMSFit
from fric.identify.gms.knots import Blocks
from fric.identify.records.judgement import RESOLVED
from fric.notice import Notice
from fric.units import readable, si_unit

INERTIA = 0.1
"""Share of the force from which on the inertia makes a sine too fast."""

INSEPARABLE = 0.01
"""Two blocks are not told apart when one in their place changes the curve by less than this share of F_s."""

HOLLOW = 0.02
"""Share of F_s by which a virgin curve is below a concave one, beyond its error, from which on it is told."""

LEVEL = 0.03
"""Deviation of Σ alpha from 1 that is told."""


def notices_of(fit: GMSFit, *, sliding_logged: bool, plant_given: bool) -> Iterator[Notice]:
    """Yield the warnings of a fit.

    Parameters
    ----------
    fit
        The fit.
    sliding_logged
        Whether a record in sliding was among the logs.
    plant_given
        Whether inertia and damping were taken off.
    """
    axis = fit.motion
    length, newton = si_unit("position", axis), si_unit("force", axis)
    if not fit.static_given:
        yield Notice(
            f"no static map is given: F_c = F_s = {readable(fit.static.F_s, newton)} from the plateau; "
            "give --static for the Stribeck effect",
            "no-static-map", "doubt",
        )  # fmt: skip
    yield from _saturation(fit, length, newton)
    if fit.asked not in {None, len(fit.blocks)}:
        yield Notice(
            fit.reason,
            "fewer-blocks", "note",
        )  # fmt: skip
    step = max(one.motion.step for one in fit.hysteresis)
    first = float(fit.model.slip_displacements[0])
    if first < RESOLVED * step:
        yield Notice(
            f"the first block slips at {readable(first, length)}, under four steps of the encoder "
            f"({readable(step, length)}): k_1 is uncertain beyond its interval",
            "first-block-unresolved", "doubt",
        )  # fmt: skip
    displacement = fit.model.slip_displacements
    for n, gap in enumerate(pair_gaps(fit.blocks)):
        if gap < INSEPARABLE * fit.static.F_s and len(displacement) == len(fit.blocks):
            yield Notice(
                f"blocks {n + 1} and {n + 2} slip at {readable(float(displacement[n]), length)} and "
                f"{readable(float(displacement[n + 1]), length)}: one block in their place changes the virgin curve "
                f"by {readable(float(gap), newton, 2)} at most, so the data cannot separate them",
                "blocks-inseparable", "note",
            )  # fmt: skip
    for one in fit.hysteresis:
        share = one.record.done.inertia_share or 0.0
        if share > INERTIA:
            yield Notice(
                f"inertia is {share:.0%} of the force in record '{one.name}': the sine is too fast; "
                f"log it at a frequency lower by {np.sqrt(share / INERTIA):.2g} or more",
                "sine-too-fast", "doubt",
            )  # fmt: skip
    if fit.C.assumed:
        why = (
            "no static map is given"
            if sliding_logged and not fit.static_given
            else "the fit was not refined by replay"
            if sliding_logged and not fit.refined
            else "the sliding record does not tell it to a factor of ten (is the plant that of the log?)"
            if sliding_logged
            else "pre-sliding records do not tell it"
        )
        hint = "" if sliding_logged else "; log a sine in sliding (fric simulate experiment --kind sliding-sine)"
        yield Notice(
            f"C is assumed to be {readable(float(fit.C), si_unit('force rate', axis))}: {why}{hint}",
            "C-assumed", "doubt",
        )  # fmt: skip
    elif not plant_given:
        yield Notice(
            "C is identified without a plant: the inertia was fitted beside the frictional lag, and the drive's delay "
            "is not known, which widens its interval; give --plant",
            "C-without-plant", "doubt",
        )  # fmt: skip
    if fit.curve.saturates and abs(float(fit.alpha_sum) - 1.0) > LEVEL:
        yield Notice(
            f"the friction level of the pre-sliding records is {float(fit.alpha_sum):.3f} of the static map's F_s; "
            "alpha is normalised to sum to 1",
            "level-differs", "doubt",
        )  # fmt: skip
    if abs(fit.curve.mismatch) > max(LEVEL * fit.static.F_s, 0.0):
        between = readable(abs(fit.curve.mismatch), newton, 2)
        if fit.curve.mismatch > 0:
            yield Notice(
                f"where one record continues the other, the smaller and slower one ends {between} higher: friction "
                "grows with the time of rest (dwell), or it fell meanwhile; the curve is that of neither. Log both "
                "amplitudes at one mean speed, in turn, and the static map down to that speed",
                "friction-ages", "wrong",
            )  # fmt: skip
        else:
            yield Notice(
                f"the records differ by {between} where one continues the other: friction changed between them",
                "friction-differs", "doubt",
            )  # fmt: skip
    where, hollow = fit.curve.hollow
    fast = any(
        (one.record.done.inertia_share or 0.0) > INERTIA for one in fit.hysteresis
    )  # inertia makes it hollow too
    if hollow > HOLLOW * fit.static.F_s and not fast:
        yield Notice(
            f"after a reversal the force is flat about {readable(where, length, 2)} and rises again, "
            f"{readable(hollow, newton, 2)} below any friction: a play between what is driven and what is measured "
            "(motor and table, a coupling). The blocks hold that play. Take it out, or measure at the table",
            "lost-motion", "wrong",
        )  # fmt: skip
    if len(fit.curve.cycles) < 2:
        yield Notice(
            "there is one whole cycle: no intervals; log five cycles or more",
            "one-cycle", "doubt",
        )  # fmt: skip
    yield from changes(fit)


def _saturation(fit: GMSFit, length: str, newton: str) -> Iterator[Notice]:
    if fit.curve.saturates:
        return
    extent = float(fit.curve.displacement[-1])
    end = float(fit.curve.force[-1])
    if fit.static_given:
        missing = max(fit.static.F_s - end, 0.0)
        amplitude = max(1.5 * float(fit.model.slip_displacements[-1]), 2.0 * extent)
        yield Notice(
            f"the hysteresis cycles never saturate: at {readable(extent, length)} the virgin curve is at "
            f"{readable(end, newton)}, and {readable(missing, newton)} of F_s is missing, which the last block "
            f"is given; add a record of {readable(amplitude, length, 2)} amplitude or more",
            "never-slides", "doubt",
        )  # fmt: skip
    else:
        yield Notice(
            f"the hysteresis cycles never saturate and no static map tells F_s: {readable(end, newton)} at "
            f"{readable(extent, length)} is a lower bound of it; add a record of {readable(3.0 * extent, length, 2)} "
            "amplitude or more, or --static",
            "never-slides", "wrong",
        )  # fmt: skip


def pair_gaps(blocks: Blocks) -> Real:
    """Return by how much the virgin curve changes at most when two neighbours are made one [N], shape (N - 1,).

    The one has their stiffness and their limit; the greatest change is where it slips.
    """
    k, limit = blocks.k, blocks.limit
    merged = (limit[:-1] + limit[1:]) / (k[:-1] + k[1:])
    both = np.minimum(k[:-1] * merged, limit[:-1]) + np.minimum(k[1:] * merged, limit[1:])
    return np.asarray(limit[:-1] + limit[1:] - both)
