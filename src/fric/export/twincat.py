"""The target ``twincat``: the velocity → current list of TF5200's friction compensation, and its error.

The compensation interpolates linearly between at most 20 points of velocity and current. The points are placed so that
the interpolation error of the steady friction is least: each point is as far from the previous one as an error bound
allows, and the bound is bisected until 20 points reach the largest velocity.
"""

import numpy as np

from fric.arrays import Real
from fric.export.base import ExportedPart, Files, Target, render
from fric.export.c import name_of
from fric.units import rotates, si_unit

POINTS = 20  # Largest number of points in the list
FASTEST = 0.5  # Largest velocity of the list [m/s, rad/s]


def list_of(part: ExportedPart) -> tuple[Real, Real, float]:
    """Return velocities, voltages, and the largest error of the interpolation [N].

    Returns shapes (n,), (n,), n of at most 20, symmetric where friction is; and the error.
    """
    v = np.concatenate([[0.0], np.geomspace(1e-7 * FASTEST, FASTEST, 4000)])
    half = POINTS // 2

    def side(sign: float) -> tuple[Real, Real, float]:
        force = np.asarray(part.model.steady_state(sign * np.maximum(v, 1e-9 * FASTEST)), float)

        def chosen(bound: float) -> list[int]:
            kept = [1]
            while kept[-1] < len(v) - 1:
                first = kept[-1]
                last = first + 1
                step = 1
                while step:
                    nearer = last
                    while nearer + step < len(v) and _error(v, force, first, nearer + step) <= bound:
                        nearer += step
                        step *= 2
                    last, step = nearer, step // 2
                kept.append(last)
            return kept

        low, high = 0.0, float(np.ptp(force)) + 1e-12
        for _ in range(40):
            middle = 0.5 * (low + high)
            low, high = (low, middle) if len(chosen(middle)) <= half else (middle, high)
        kept = chosen(high)
        return sign * v[kept], force[kept], high

    (v_minus, f_minus, e_minus), (v_plus, f_plus, e_plus) = side(-1.0), side(1.0)
    force = np.concatenate([f_minus[::-1], f_plus])
    return np.concatenate([v_minus[::-1], v_plus]), part.gain * force / part.K_f, max(e_minus, e_plus)


def _error(v: Real, force: Real, first: int, last: int) -> float:
    inside = slice(first, last + 1)
    return float(np.abs(np.interp(v[inside], [v[first], v[last]], [force[first], force[last]]) - force[inside]).max())


def twincat_files(part: ExportedPart) -> Files:
    """Return the list as text, and a page with its remaining error."""
    velocity, volts, error = list_of(part)
    unit, force = ("rad" if rotates(part.motion) else "mm"), si_unit("force", part.motion)
    per = 1.0 if rotates(part.motion) else 1e3
    lines = [f"velocity [{unit}/s];feedforward [{si_unit('input', part.motion)}]"]
    lines += [f"{per * v:.9g};{u:.9g}" for v, u in zip(velocity, volts, strict=True)]
    shown = {"unit": unit, "force": force, "count": len(velocity), "error": f"{error:.3g}", "axis": part.axis}
    page = render("twincat.md.j2", name=name_of(part), ends=[f"{per * velocity[n]:g}" for n in (0, -1)], **shown)
    return {f"{name_of(part)}-list.csv": "\n".join(lines) + "\n", "README.md": page}


TARGET = Target(
    "twincat", "the velocity → current list of TF5200's friction compensation", twincat_files, friction="static"
)
