"""What a fit by replay must not claim, since its records do not tell it: of break-away, and of stiffness."""

from collections.abc import Mapping, Sequence

import numpy as np

from fric.estimate import Estimate
from fric.flaws.blocks import NEVER_SLIDES
from fric.flaws.encoder import STIFFNESS_UNRESOLVED
from fric.identify.replay.coordinates import Coordinates
from fric.notice import Notice
from fric.records.judgement import identifiability_of, too_coarse
from fric.records.prepared import Prepared
from fric.units import si_unit

Limits = dict[tuple[str, str], tuple[tuple[float, float], ...]]


def opened(
    coordinates: Coordinates,
    values: Mapping[str, Mapping[str, float | tuple[float, ...]]],
    within: Limits,
    records: Sequence[Prepared],
) -> tuple[Limits, list[Notice]]:
    """Return intervals that are open where the records tell no upper limit, and what to say of them.

    Where no branch slides, the largest force seen is no more than a lower bound of F_c and F_s, and of v_s nothing is
    told. A stiffness whose spring gives way before the motion is seen again after a reversal is no less than what was
    found, and of records that are all a few steps of the encoder large nothing is told of it.

    coordinates: What was searched.
    values, within: Values and intervals by section and name.
    records: The records.
    """
    seen, motion, notices, found = identifiability_of(records), records[0].log.motion, [], dict(within)
    declared = {(s, p.name): p for s, parameters in coordinates.model.declared().items() for p in parameters}
    forces = [key for key in within if key in declared and declared[key].dimension == "force"]
    if not seen.slides and forces:
        for key in forces:
            found[key] = tuple((seen.peak if len(within[key]) == 1 else low, np.inf) for low, _ in within[key])
        for key in (key for key in within if key in declared and declared[key].dimension == "velocity"):
            found[key] = tuple((0.0, np.inf) for _ in within[key])  # how friction falls once it slides
        peak, names = Estimate(seen.peak, si_unit("force", motion)), " and ".join(name for _, name in forces)
        notices.append(NEVER_SLIDES.found(force=peak, names=names, slope=seen.slope, amplitude=None, static=False))
    if len(too_coarse(records)) == len(records):
        for key in (key for key in within if key in declared and declared[key].dimension == "stiffness"):
            found[key] = tuple((0.0, np.inf) for _ in within[key])
        return found, notices
    level, length = _level(values), si_unit("position", motion)
    for key, limits in within.items():
        if key not in declared or declared[key].dimension != "stiffness" or level is None:
            continue
        k = np.atleast_1d(np.asarray(values[key[0]][key[1]], float))
        slips = np.broadcast_to(level, k.shape) / k
        if (slips < seen.resolved).any():
            found[key] = tuple(
                (low, np.inf if slip < seen.resolved else high) for (low, high), slip in zip(limits, slips, strict=True)
            )
            slip, resolved = (Estimate(float(one), length) for one in (slips.min(), seen.resolved))
            notices.append(STIFFNESS_UNRESOLVED.found(name=key[1], slip=slip, resolved=resolved))
    return found, notices


def _level(
    values: Mapping[str, Mapping[str, float | tuple[float, ...]]],
) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]] | None:
    """Return the force at which the springs of a model give way [N]: of each block, or of the one there is."""
    every = {name: np.asarray(value, float) for section in values.values() for name, value in section.items()}
    if "W" in every:
        return every["W"]
    level = every.get("F_s", every.get("F_c"))
    return None if level is None else np.asarray(every["alpha"] * level) if "alpha" in every else level
