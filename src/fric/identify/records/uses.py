"""What a record is good for."""

from fric.identify.records.inspected import Inspection, Use
from fric.identify.records.judgement import RISES, STEPS
from fric.identify.records.recognition import LOOP_SHARE

BRANCH = 20
"""Samples that a branch between reversals has at least."""


def found_uses(found: Inspection) -> tuple[Use, ...]:
    """Return what a record is good for, judged by what was found in it."""
    return _static_use(found), _gms_use(found), _plant_use(found)


def _static_use(found: Inspection) -> Use:
    purpose = "static"
    if "force" not in found.channels:
        return Use(purpose, False, "no force was logged")
    if not found.segments:
        return Use(purpose, False, "no segment at constant velocity")
    if found.channels["force"].clipped:
        return Use(purpose, False, f"the force is clipped in {found.channels['force'].clipped} samples")
    settled = [s for s in found.segments if s.settled]
    if not settled:
        return Use(purpose, False, "the force settles nowhere: longer strokes are needed")
    unsettled = len(found.segments) - len(settled)
    text = f"{len(found.speeds)} speeds" if len(found.speeds) > 1 else "one speed: a map takes records at others too"
    text += f", {unsettled} of {len(found.segments)} stretches not settled" if unsettled else ""
    return Use(purpose, True, text)


def _gms_use(found: Inspection) -> Use:
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
