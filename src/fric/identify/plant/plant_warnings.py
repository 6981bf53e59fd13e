"""What a fit of eq. (1) to frequency responses cannot tell, or is off by, in words."""

from collections.abc import Iterator, Sequence

import numpy as np

from fric.drive.plant import hold_delay
from fric.estimate import Estimate
from fric.identify.plant.fit import FrictionInfluence, ResponseFit
from fric.identify.plant.response_fit import Solution
from fric.notice import Notice, Severity
from fric.units import readable

UNSURE, FALSE = 0.02, 0.1
"""Misfit from which on a fit is in doubt, and from which on it is wrong [1]."""

SMALL = 0.03
"""Share of A that friction may be before A is wrong."""

QUIET = 20.0
"""Frequency up to which friction's harmonics are looked for [Hz]; above, an encoder's steps take more voltage."""


def described(
    fits: Sequence[ResponseFit], solution: Solution, friction: FrictionInfluence, estimates: dict[str, Estimate],
    hold: float | None,
) -> Iterator[Notice]:  # fmt: skip
    """Yield the warnings of a fit.

    Parameters
    ----------
    fits
        Each response with its own fit.
    solution
        The fit of all.
    friction
        What friction does to A.
    estimates
        A, B, T_d, and K_f where it is known.
    hold
        Sampling rate of the hold [Hz].
    """
    for fit in fits:
        name = fit.measured.table.name
        yield from (_named(name, warning) for warning in fit.measured.warnings)
        yield from _of_lines(name, fit)
    yield from _of_mode(solution)
    yield from _of_friction(fits, friction, estimates)
    if float(estimates["A"]) <= float(solution.half_widths()[0]):
        lowest = min(float(fit.measured.table.frequency[fit.used].min()) for fit in fits)
        yield Notice(
            "A is not told from 0: excite below its corner (the lowest frequency used is "
            f"{lowest:.3g} Hz), and harder; where friction is in it too, 0 is assumed, and strokes tell what is "
            "viscous as sigma", "A-open", "doubt",
        )  # fmt: skip
    edge = hold_delay(hold) if hold else 0.0
    if float(estimates["T_d"]) <= edge * (1 + 1e-6):
        yield Notice(
            f"T_d ended at its bound, {'the hold alone' if hold else 'zero'}: input and position are not logged at "
            "one instant, or the response is not behind the hold that is assumed (--hold)", "T_d-at-bound", "doubt",
        )  # fmt: skip
    yield Notice(
        "A holds the guideway's viscous friction, over the moving mass, besides the drive's own damping",
        "A-holds-viscous", "note",
    )  # fmt: skip
    if "K_f" not in estimates:
        yield Notice(
            "K_f is not known: no record has force and input both; give strokes beside it that have, or "
            "--force-constant",
            "K_f-missing", "note",
        )  # fmt: skip


def _named(name: str, warning: str) -> Notice:
    notice = Notice.of(warning)
    return Notice(f"{name}: {notice}", notice.code, notice.severity)


def _of_lines(name: str, fit: ResponseFit) -> Iterator[Notice]:
    if fit.stand_off:
        lines = ", ".join(f"{f:.4g}" for f in fit.stand_off[:8]) + (", …" if len(fit.stand_off) > 8 else "")
        yield Notice(
            f"{name}: {len(fit.stand_off)} lines stand off all others and are left out, as friction's harmonics at "
            f"lines that are not driven do ({lines} Hz)", "lines-stand-off", "note",
        )  # fmt: skip
    if fit.solution.misfit > 0:
        f = fit.measured.table.frequency[fit.used]
        off = np.abs(np.log(fit.measured.response[fit.used] / fit.model(f)))
        worst, size = float(f[int(np.argmax(off))]), fit.solution.misfit
        severity: Severity = "wrong" if size >= FALSE else "doubt" if size >= UNSURE else "note"
        hint = (
            f"; look at the figure, and keep to where it fits (--highest '{0.5 * worst:.2g} Hz')"
            if size >= FALSE
            else ""
        )
        yield Notice(
            f"{name}: eq. (1) leaves {100 * size:.2g} % that noise does not explain, most at {worst:.4g} Hz; the "
            f"intervals allow for it{hint}", "response-misfit", severity,
        )  # fmt: skip


def _of_mode(solution: Solution) -> Iterator[Notice]:
    mode = solution.form.resonance(solution.values)
    if mode is None:
        return
    where = f"with {mode.ratio:.0%} of the moving mass " if mode.encoder == "motor" else ""
    yield Notice(
        f"a second mass is seen from the {mode.encoder}: a resonance at {readable(mode.frequency, 'Hz')} {where}"
        f"on a spring; A and B are those of the rigid axis below it", "second-mass", "note",
    )  # fmt: skip
    if mode.encoder == "motor":
        yield Notice(
            "the encoder on the motor does not see the spring stretch: stiffnesses and C that it shows in "
            "pre-sliding hold the spring in series with friction. Measure at the table for friction alone",
            "spring-in-series", "wrong",
        )  # fmt: skip


def _of_friction(
    fits: Sequence[ResponseFit], friction: FrictionInfluence, estimates: dict[str, Estimate]
) -> Iterator[Notice]:
    gains = friction.gains
    if friction.differs and friction.coulomb is not None:
        if float(friction.coulomb) < 0:
            text = "A rises with the amplitude, which Coulomb friction does not do; the records differ in another way"
            yield Notice(text, "amplitudes-disagree", "doubt")
            return
        yield Notice(
            f"friction is seen: A is {friction.seen.min():.4g} to {friction.seen.max():.4g} 1/s at these amplitudes; "
            f"without the describing function of a Coulomb friction of {float(friction.coulomb):.3g} "
            f"{friction.coulomb.unit} times the moving mass it is {float(estimates['A']):.4g} 1/s",
            "friction-in-response", "note",
        )  # fmt: skip
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
    hint = (
        f"by the lines between the driven ones it is less than {SMALL:.0%} of A"
        if small
        else "log a second amplitude, or excite around a steady motion"
    )
    yield Notice(
        f"the axis reverses while it is excited, and A holds friction: {each}; {hint}",
        "A-holds-friction", "note" if small else "wrong",
    )  # fmt: skip


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
