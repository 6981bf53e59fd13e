"""What a fit of eq. (1) to frequency responses cannot tell, or is off by, in words."""

from collections.abc import Iterator, Sequence

import numpy as np

from fric.drive.plant import hold_delay
from fric.estimate import Estimate
from fric.flaws import response
from fric.flaws.channel import K_F_MISSING
from fric.identify.plant.fit import FrictionInfluence, ResponseFit
from fric.identify.plant.response_fit import Solution
from fric.notice import Notice

SMALL = 0.03
"""Share of A that friction may be before A is wrong."""

QUIET = 20.0
"""Frequency up to which friction's harmonics are looked for [Hz]; above, an encoder's steps take more voltage."""


def described(
    fits: Sequence[ResponseFit], solution: Solution, friction: FrictionInfluence, estimates: dict[str, Estimate],
    hold: float | None,
) -> Iterator[Notice]:  # fmt: skip
    """Yield the warnings of a fit.

    fits: Each response with its own fit.
    solution: The fit of all.
    friction: What friction does to A.
    estimates: A, B, T_d, and K_f where it is known.
    hold: Sampling rate of the hold [Hz].
    """
    for fit in fits:
        name = fit.measured.table.name
        yield from (Notice.of(warning).at(name) for warning in fit.measured.warnings)
        yield from _of_lines(name, fit)
    yield from _of_mode(solution)
    yield from _of_friction(fits, friction, estimates)
    if float(estimates["A"]) <= float(solution.half_widths()[0]):
        lowest = min(float(fit.measured.table.frequency[fit.used].min()) for fit in fits)
        yield response.A_OPEN.found(lowest=lowest)
    edge = hold_delay(hold) if hold else 0.0
    if float(estimates["T_d"]) <= edge * (1 + 1e-6):
        yield response.T_D_AT_BOUND.found(hold=bool(hold))
    yield response.A_HOLDS_VISCOUS.found()
    if "K_f" not in estimates:
        yield K_F_MISSING.found()


def _of_lines(name: str, fit: ResponseFit) -> Iterator[Notice]:
    if fit.stand_off:
        yield response.LINES_STAND_OFF.found(name, count=len(fit.stand_off), lines=list(map(float, fit.stand_off)))
    if fit.solution.misfit > 0:
        f = fit.measured.table.frequency[fit.used]
        off = np.abs(np.log(fit.measured.response[fit.used] / fit.model(f)))
        worst, size = float(f[int(np.argmax(off))]), fit.solution.misfit
        yield response.RESPONSE_MISFIT.found(
            name, misfit=size, worst=worst, wrong=size >= response.FALSE, highest=0.5 * worst
        )


def _of_mode(solution: Solution) -> Iterator[Notice]:
    mode = solution.form.resonance(solution.values)
    if mode is None:
        return
    share = mode.ratio if mode.encoder == "motor" else 0.0
    yield response.SECOND_MASS.found(encoder=mode.encoder, frequency=Estimate(mode.frequency, "Hz"), share=share)
    if mode.encoder == "motor":
        yield response.SPRING_IN_SERIES.found()


def _of_friction(
    fits: Sequence[ResponseFit], friction: FrictionInfluence, estimates: dict[str, Estimate]
) -> Iterator[Notice]:
    gains = friction.gains
    if friction.differs and friction.coulomb is not None:
        if float(friction.coulomb) < 0:
            yield response.AMPLITUDES_DISAGREE.found()
            return
        low, high, A = friction.seen.min(), friction.seen.max(), float(estimates["A"])
        yield response.FRICTION_IN_RESPONSE.found(low=low, high=high, A=A, coulomb=friction.coulomb)
        return
    if friction.compared or not np.any(np.nan_to_num(gains) > 0):
        return
    gain = float(np.nanmax(gains))
    B = float(estimates["B"])
    each = f"each volt of Coulomb friction adds {gain * B:.3g} 1/s to it"
    if "K_f" in estimates:
        each = f"each {'N*m' if estimates['K_f'].unit.startswith('N*m') else 'N'} of Coulomb friction adds "
        each += f"{gain * B / float(estimates['K_f']):.3g} 1/s to it"
    added = [_friction_seen(fit) for fit in fits]
    small = all(one is not None and one < SMALL for one in added)
    yield response.A_HOLDS_FRICTION.found(each=each, small=small, limit=SMALL)


def _friction_seen(fit: ResponseFit) -> float | None:
    """Return the share of A that is Coulomb friction, at most, by the lines that are not driven; None without these.

    Along a motion that is about normally distributed, sign(v) is 2/π in power like v, which is in A; the rest of
    1 - 2/π is at all lines, and what it takes in voltage at those that are not driven, ``Z/G - U``, tells its level.
    It reaches to about three times the highest line that is looked at; the factor of 2 is for caution.
    """
    lines, gain = fit.measured.lines, fit.measured.reversing
    if lines is None or gain is None:
        return None
    f = fit.measured.table.frequency[fit.used]
    within = ~lines.driven & (lines.frequency >= f.min()) & (lines.frequency <= min(float(f.max()), QUIET))
    if np.count_nonzero(within) < 3:
        return None
    at = lines.frequency[within]
    voltage = lines.position[within] / fit.model(at) - lines.input[within]
    count = 3 * QUIET / float(lines.frequency[0])
    power = 2 * float(np.mean(np.abs(voltage) ** 2)) * count
    level = 2 * np.sqrt(power / (1 - 2 / np.pi))
    plant = fit.solution.plant()
    return float(level * plant.B * gain / max(plant.A, 1e-300))
