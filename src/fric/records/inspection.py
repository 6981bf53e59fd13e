"""What a record holds, and what it is good for."""

from dataclasses import replace

import numpy as np

from fric.arrays import Real
from fric.log import ForceVelocity, FrequencyResponse, Log, Record
from fric.records.clipping import STUCK, clipped_samples, counts
from fric.records.energy import cycle_energies, energy_per_cycle, energy_warnings
from fric.records.flaws import clock_flaws, stroke_flaws
from fric.records.inspected import (
    Channel,
    Gap,
    Inspection,
    ResponseInspection,
    TableInspection,
    Use,
    inspect_response,
    inspect_table,
)
from fric.records.judgement import RISES, SAMPLES, STEPS, branch_slope, excites, resolved_travel
from fric.records.over_strokes import over_place
from fric.records.recognition import LOOP_SHARE, fitted_sine, force_rise, recognised_kind
from fric.records.resolution import encoder_step
from fric.records.reversals import find_reversals
from fric.records.segments import Segment, segments_and_rests

GAP = 1.5
"""Sampling intervals from which on samples are missing."""
ALIKE = 0.03
"""Relative difference up to which two segments have one speed."""


Inspected = Inspection | ResponseInspection | TableInspection


BRANCH = 20
"""Samples that a branch between reversals has at least."""


def inspect(record: Record) -> Inspected:
    """Return what a record holds and what it is good for.

    Parameters
    ----------
    record
        A record in time or in frequency, or a table of forces and velocities.
    """
    if isinstance(record, FrequencyResponse):
        return inspect_response(record)
    if isinstance(record, ForceVelocity):
        return inspect_table(record)
    log = record
    channels = {name: _channel(log, name, values) for name, values in log.channels().items()}
    sampling, jitter, gaps = _clock(log.time)
    found = Inspection.of(
        record, dropped=record.dropped, kind=record.kind or "motion", stated=record.kind is not None,
        samples=len(log), duration=float(log.time[-1] - log.time[0]),
        sampling=sampling, jitter=jitter, channels=channels, gaps=gaps,
    )  # fmt: skip
    if len(log) < STUCK:
        return replace(found, uses=(Use("identification", False, f"{len(log)} samples are too few"),))
    segments, rests = segments_and_rests(replace(log, kind=None))
    sine, reversals = None, np.zeros(0, dtype=np.intp)
    if log.position is not None:
        sine, reversals = fitted_sine(log.time, log.position), find_reversals(log.position)
    rise = force_rise(log, reversals)
    warnings = clock_flaws([log], "inspect")
    if log.force is not None:
        pairs = [(log, segment) for segment in segments]
        warnings += stroke_flaws(pairs, over_place(pairs))
    kind = record.kind or recognised_kind(log, segments, rests, sine, rise, len(reversals))
    if kind not in {"constant-velocity", "motion"}:
        segments = []
    if kind not in {"presliding-sine", "sliding-sine"}:
        sine = None
    if log.position is not None:
        found = replace(found, excites=excites(log.time, log.position))
    if log.position is not None and log.force is not None and len(reversals) > 1:
        energies = cycle_energies(log.position, log.force, reversals)
        lost = energy_per_cycle(energies)
        strokes = np.abs(np.diff(log.position[reversals]))
        if kind in {"presliding-sine", "motion"} and np.ptp(strokes) < ALIKE * float(np.median(strokes)):
            warnings += energy_warnings(energies, log.time[reversals[::2]])
        found = replace(found, slope=branch_slope(log.position, log.force, reversals), energy=lost)
    found = replace(
        found, kind=kind, stretches=tuple(segments), speeds=distinct_speeds(segments), sine=sine,
        reversals=tuple(map(int, reversals)), rise=rise, warnings=tuple(warnings),
    )  # fmt: skip
    seen = 0.0
    if log.position is not None and len(reversals) > 2:
        seen = resolved_travel(log.position, reversals) / float(np.median(np.abs(np.diff(log.position[reversals]))))
    return replace(found, uses=(_static_use(found), _gms_use(found, seen), _plant_use(found)))


def distinct_speeds(segments: list[Segment]) -> tuple[float, ...]:
    """Return the velocities of segments in ascending order, those of one speed as their mean, by length."""
    speeds: list[list[Segment]] = []
    for segment in sorted(segments, key=lambda s: s.velocity):
        if speeds and abs(segment.velocity - speeds[-1][0].velocity) <= max(
            ALIKE * abs(segment.velocity), 3.0 * np.hypot(segment.velocity_se, speeds[-1][0].velocity_se)
        ):
            speeds[-1].append(segment)
        else:
            speeds.append([segment])
    return tuple(float(np.average([s.velocity for s in one], weights=[len(s) for s in one])) for one in speeds)


def _channel(log: Log, name: str, values: Real) -> Channel:
    step = (
        encoder_step(values) or None
        if name == "position"
        else None
        if name in {"time", "reference"}
        else counts(values)
    )
    clipped = clipped_samples(values) if name in {"force", "input"} else 0
    return Channel(log.unit(name), float(values.min()), float(values.max()), step, clipped)


def _clock(time: Real) -> tuple[float, float, tuple[Gap, ...]]:
    """Return the sampling rate [Hz], the standard deviation of the intervals [s], and the gaps."""
    intervals = np.diff(time)
    usual = float(np.median(intervals))
    wide = intervals > GAP * usual
    gaps = tuple(Gap(float(time[k]), float(intervals[k] / usual)) for k in np.flatnonzero(wide))
    return 1.0 / float(intervals[~wide].mean()), float(intervals[~wide].std()), gaps


def _static_use(found: Inspection) -> Use:
    purpose = "static"
    if "force" not in found.channels:
        return Use(purpose, False, "no force was logged")
    if not found.stretches:
        return Use(purpose, False, "no segment at constant velocity")
    if found.channels["force"].clipped:
        return Use(purpose, False, f"the force is clipped in {found.channels['force'].clipped} samples")
    settled = [s for s in found.stretches if s.settled]
    if not settled:
        return Use(purpose, False, "the force settles nowhere: longer strokes are needed")
    unsettled = len(found.stretches) - len(settled)
    text = f"{len(found.speeds)} speeds" if len(found.speeds) > 1 else "one speed: a map takes records at others too"
    text += f", {unsettled} of {len(found.stretches)} segments not settled" if unsettled else ""
    return Use(purpose, True, text)


def _gms_use(found: Inspection, seen: float) -> Use:
    """Return whether pre-sliding is seen; ``seen`` is the share of a stroke within `SAMPLES` behind a reversal."""
    purpose = "gms"
    if missing := [name for name in ("position", "force") if name not in found.channels]:
        return Use(purpose, False, f"no {' and no '.join(missing)} was logged")
    if found.channels["force"].clipped:
        return Use(purpose, False, f"the force is clipped in {found.channels['force'].clipped} samples")
    position, step = found.channels["position"], found.encoder_step
    half = 0.5 * (position.high - position.low) if position.high is not None and position.low is not None else 0.0
    amplitude = found.sine.amplitude if found.sine else half
    if found.kind == "sliding-sine" and len(found.reversals) < 3:
        return Use(purpose, True, "for the attraction parameter C; knots take a sine in pre-sliding")
    if len(found.reversals) < 3:
        return Use(purpose, False, f"{len(found.reversals)} reversals: whole branches take three")
    if step and amplitude < STEPS * step:
        return Use(purpose, False, f"the amplitude is {amplitude / step:.1f} steps of the encoder: three are needed")
    branch = (found.reversals[-1] - found.reversals[0]) / (len(found.reversals) - 1)
    if branch < BRANCH:
        return Use(purpose, False, f"{branch:.0f} samples a branch are too few")
    if found.rise and seen > found.rise:
        return Use(
            purpose, False, f"{SAMPLES} samples behind a reversal go through pre-sliding: log faster, or move slower"
        )
    if found.kind != "presliding-sine" and (found.rise is None or found.rise <= LOOP_SHARE):
        return Use(purpose, False, f"pre-sliding is over in {100 * (found.rise or 0.0):.1f} % of a stroke")
    text = f"{len(found.reversals) - 1} branches" + (
        f" of {2 * amplitude / step:.0f} steps of the encoder" if step else ""
    )
    if found.slope is not None and found.slope > RISES:
        text += "; none of them slides: F_s takes --static, or a larger amplitude"
    return Use(purpose, True, text)


def _plant_use(found: Inspection) -> Use:
    purpose = "plant"
    if "position" not in found.channels:
        return Use(purpose, False, "no position was logged")
    by_motion = found.kind == "motion" and found.excites and not found.gaps  # a motion is filtered: evenly sampled
    if "input" not in found.channels:
        if by_motion and "force" in found.channels:
            return Use(purpose, True, "a motion in both directions; B and K_f take an input too")
        return Use(purpose, False, "no input was logged")
    if found.channels["input"].clipped:
        return Use(purpose, False, f"the input is clipped in {found.channels['input'].clipped} samples")
    if found.kind == "frequency-response":
        return Use(purpose, True, "the excitation is broad-band")
    if by_motion:
        return Use(purpose, True, "a motion in both directions, with changing speed and acceleration")
    return Use(purpose, False, "the excitation is not broad-band")
