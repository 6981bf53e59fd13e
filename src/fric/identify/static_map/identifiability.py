"""What the data cannot tell about a fitted static map, in words."""

from collections.abc import Iterator
from math import isinf, log

import numpy as np
from scipy.special import chdtrc, fdtrc

from fric.drive.plant import Plant
from fric.estimate import Interval
from fric.identify.plant.covariance import smoother_than_noise
from fric.identify.static_map.map_fit import MapFit
from fric.identify.static_map.scatter import REPEATED
from fric.notice import Notice
from fric.units import Motion, readable, si_unit

SCATTERED = 0.1
"""Scatter between strokes, as a share of their force, from which on a map of speed is doubted."""

TAKEN = 0.05
"""Share of the drive's damping that its plant may be off by, before the strokes contradict it."""

DIFFERENT = 1e-3
"""Probability under which directions that are alike are not taken for different."""

CORRELATED = 0.95
"""Correlation of two parameters from which on the data tell them apart badly."""

MISSED = 0.005
"""Share of the force by which strokes of both directions stand off a map alike (rms), from which on it is doubted."""

SEEN = 0.5
"""Share of the fall from F_s to F_c that lies above the slowest stroke at least, for F_s to be told by strokes."""


def _fall_left(fit: MapFit) -> float:
    """Return the share of the fall that is left at the slowest stroke, ``exp(-(v/v_s)^delta)``."""
    theta = fit.solution.theta
    return float(np.exp(-((float(np.abs(fit.problem.v).min()) / theta["v_s"]) ** theta["delta"])))


def identifiability_warnings(fit: MapFit, motion: Motion) -> Iterator[Notice]:
    """Say what the data cannot tell about a fitted map."""
    problem, theta = fit.problem, fit.solution.theta
    slowest = readable(float(np.abs(problem.v).min()), si_unit("velocity", motion))
    flat = not problem.fall or theta["F_s"] <= theta["F_c"] * (1 + 1e-9)
    if not problem.fall and "stribeck" in fit.held_out.errors:
        plain, falling = (readable(fit.held_out[form], si_unit("force", motion), 3) for form in ("coulomb", "stribeck"))
        yield Notice(
            f"friction is not seen to fall with speed down to {slowest}: Coulomb plus viscous friction predicts "
            f"strokes that are held out to {plain}, eq. (2) to {falling}. F_s = F_c and v_s are assumed; to see "
            "the fall log slower strokes, or force it with --form stribeck.", "fall-not-seen", "doubt",
        )  # fmt: skip
    elif flat and problem.fall:
        yield Notice(
            f"F_s sits at its bound F_c: friction does not fall with speed down to {slowest}; v_s means nothing "
            "here.",
            "fall-not-seen", "doubt",
        )  # fmt: skip
    elif not flat and any(isinf(limit) or limit == 0.0 for name in ("F_s", "v_s") for limit in _interval(fit, name)):
        yield Notice(
            f"the data do not reach the Stribeck range: F_s and v_s are not settled by strokes from {slowest} up. "
            "Log slower strokes.", "fall-open", "doubt",
        )  # fmt: skip
    elif not flat and (seen := _fall_left(fit)) < SEEN:
        lowest = readable(float(fit.static_map.level(np.abs(problem.v).min())), si_unit("force", motion))
        yield Notice(
            f"{1 - seen:.0%} of the fall lies below the slowest stroke that was used ({slowest}): F_s is no more "
            f"than how eq. (2) goes on from {lowest} there. Log slower strokes, or a finer encoder.",
            "F_s-extrapolated", "wrong",
        )  # fmt: skip
    if not flat and theta["F_c"] <= 0.0:
        yield Notice(
            "F_c ends at its bound of 0: the fall reaches beyond the fastest stroke. Log faster strokes, or take "
            "Coulomb plus viscous friction with --form coulomb.", "F_c-at-bound", "wrong",
        )  # fmt: skip
    if (rise := fit.held_out.ages) is not None:
        newton, slow = si_unit("force", motion), float(np.abs(problem.v).min())
        plain, ageing = (readable(fit.held_out[form], newton, 3) for form in ("stribeck", "ages"))
        yield Notice(
            f"static friction ages: it grows by {readable(rise * log(10.0), newton, 2)} with each tenfold of the "
            f"time of contact (errors at strokes held out: {ageing} so, {plain} by eq. (2)). F_s is that of "
            f"strokes down to {readable(slow, si_unit('velocity', motion))}, and too little for an axis that has "
            "rested: log strokes as slow as it moves at work, and look at break-away after rests.",
            "friction-ages", "wrong",
        )  # fmt: skip
    if fit.left_out:
        unit = si_unit("velocity", motion)
        strokes = ", ".join(f"{p.record} ({readable(p.velocity, unit)})" for p in fit.left_out)
        yield Notice(
            f"left out, because they stand off all others: the strokes at {strokes}. Look at their records.",
            "strokes-left-out", "doubt",
        )  # fmt: skip
    if fit.standing_off:
        unit, newton = si_unit("velocity", motion), si_unit("force", motion)
        strokes = ", ".join(f"{p.record} ({readable(p.velocity, unit)})" for p, _ in fit.standing_off)
        most = readable(max(by for _, by in fit.standing_off), newton, 2)
        yield Notice(
            f"the strokes at {strokes} stand off what all others show by up to {most}, and weigh by that: between "
            "two counts of its encoder a slow axis may stick and slip unseen. Look at their records.",
            "strokes-stand-off", "note",
        )  # fmt: skip
    yield from _correlations(fit, without=("v_s", "delta") if flat else ())
    own = problem.standard_error**2 - fit.between**2  # of each stroke's noise, which may be lost beside the scatter
    single_scatter = float(np.sum(fit.residual**2 / own)) if own.min() > 0 else np.inf
    if fit.between and chdtrc(problem.degrees_of_freedom, single_scatter) < 0.01:
        spread = readable(fit.between, si_unit("force", motion), 2)
        share = fit.between / float(np.median(np.abs(problem.F)))
        text = f"strokes scatter by {spread} beyond their own noise; weights and intervals allow for it."
        if share > SCATTERED:
            text += (
                f" It is {share:.0%} of the force: friction that does not repeat, a play or an axis that hunts, is "
                "no map of speed. Look at their records."
            )
        yield Notice(text, "strokes-scatter", "doubt" if share > SCATTERED else "note")
    yield from directions_differ(fit, motion)
    visible = fit.rmse > 1e-6 * float(np.abs(problem.F).max())
    smooth = smoother_than_noise((fit.residual / problem.standard_error)[np.argsort(problem.v)], -2.33)
    missed = 0.0 if smooth else _missed_both_ways(fit)
    if visible and (smooth or missed):
        shown, changed = "they follow the speed", ""
        if not smooth:
            by = readable(missed, si_unit("force", motion), 2)
            shown = f"both directions show the same at each speed, {by} (rms)"
            changed = ", or friction changed between them"
        yield Notice(
            f"the residuals are not noise, {shown}: eq. (2) does not describe these strokes wholly{changed}; "
            "`method` in the file tells which forms were tried. Look at the figure.",
            "residuals-follow-speed", "doubt",
        )  # fmt: skip


def _missed_both_ways(fit: MapFit) -> float:
    """Return by how much strokes of one speed stand off the map alike in both directions (rms) [N].

    It is 0 where that is little, or where they differ between the directions by as much.

    Half the sum of their residuals is what the map misses, half the difference what does not repeat. Few speeds show so
    what no test of neighbours does: of ten, a wave of the residuals has two or three.
    """
    problem = fit.problem
    r, forward = np.sign(problem.v) * fit.residual, problem.v > 0
    if forward.all() or not forward.any():
        return 0.0
    apart = np.abs(np.log(-problem.v[~forward] / problem.v[forward][:, None]))
    paired = apart.min(axis=1) < REPEATED
    there, back = r[forward][paired], r[~forward][apart.argmin(axis=1)[paired]]
    n = len(there) - len(problem.free)
    if n < 2:
        return 0.0
    missed, rest = (float(np.mean((there + sign * back) ** 2)) / 4 for sign in (1.0, -1.0))
    little = missed < (MISSED * float(np.median(np.abs(problem.F)))) ** 2
    return 0.0 if little or fdtrc(n, len(there) - 1, missed / max(rest, 1e-300)) > DIFFERENT else missed**0.5


def directions_differ(fit: MapFit, motion: Motion) -> list[Notice]:
    """Say where the directions differ by more than an offset: half their sum then changes with speed."""
    problem, v = fit.problem, np.abs(fit.problem.v)
    n = len(v) - len(problem.free) - 2
    if n < 4 or len(np.unique(np.sign(problem.v))) < 2:
        return []
    even = (
        np.column_stack([v, np.exp(-v / fit.solution.theta["v_s"]), np.ones_like(v)]) / problem.standard_error[:, None]
    )
    J = problem.jacobian(fit.solution.theta) / problem.standard_error[:, None]
    r = fit.residual / problem.standard_error
    size = np.linalg.norm(J, axis=0)
    Q, _ = np.linalg.qr(J[:, size > 0] / size[size > 0])
    rest = r - Q @ (Q.T @ r)
    even = even - Q @ (Q.T @ even)
    found = np.linalg.lstsq(even, rest, rcond=1e-6)[0]
    left = rest - even @ found
    ratio = 0.5 * float(rest @ rest - left @ left) / max(float(left @ left) / n, 1e-300)
    most = float(np.max(np.abs(even @ found * problem.standard_error)))
    if fdtrc(2, n, ratio) > DIFFERENT or most < 0.01 * float(np.median(np.abs(problem.F))):
        return []
    difference = readable(2 * most, si_unit("force", motion), 2)
    return [Notice(
        f"the directions differ by more than an offset, by up to {difference}: this map is that of neither. "
        "Identify again with --direction each, and with --load where you know the weight.",
        "directions-differ", "wrong",
    )]  # fmt: skip


def _interval(fit: MapFit, name: str) -> Interval:
    low, high = fit.estimates[name].ci95 or (0.0, 0.0)
    assert isinstance(low, float)
    assert isinstance(high, float)
    return low, high


def _correlations(fit: MapFit, without: tuple[str, ...]) -> list[Notice]:
    size = np.sqrt(np.diag(fit.covariance))
    free = fit.problem.free
    with np.errstate(invalid="ignore", divide="ignore"):
        correlation = fit.covariance / np.outer(size, size)
    pairs = [
        f"{free[j]} and {free[i]} ({correlation[i, j]:+.3f})"
        for i in range(len(free))
        for j in range(i)
        if not {free[i], free[j]}.intersection(without)
        and CORRELATED < abs(correlation[i, j]) <= 1.0 + 1e-9  # beyond 1 at a bound, where the curvature says nothing
    ]
    text = f"correlated, the data tell them apart badly: {', '.join(pairs)}."
    return [Notice(text, "correlated", "note")] if pairs else []


def damping_warning(fit: MapFit, plant: Plant, motion: Motion, off: float = 0.0) -> list[Notice]:
    """Say when more than the drive's own damping was taken off with a plant, or all viscous friction with it.

    A response shows the sum of both in A; sigma is then what is left of it, and 0 within its error. The plant's damping
    may be ``off`` by half its interval [N·s/m].
    """
    if fit.solution.theta["sigma"] > 0 or "sigma" not in fit.problem.free:
        return []
    J = fit.problem.jacobian(fit.solution.theta) / fit.problem.standard_error[:, None]
    size = np.linalg.norm(J, axis=0)
    used = size > 0
    inverse = np.linalg.pinv(J[:, used] / size[used], rcond=1e-7) / size[used][:, None]
    at = [name for name, one in zip(fit.problem.free, used, strict=True) if one].index("sigma")
    short = -fit.solution.theta["sigma"] - float(inverse[at] @ (fit.residual / fit.problem.standard_error))
    error = float(np.hypot(2 * np.linalg.norm(inverse[at]), off))
    words = readable(plant.damping, si_unit("viscous", motion))
    if short > max(error, TAKEN * plant.damping):
        beyond = readable(short, si_unit("viscous", motion))
        text = f"the drive's own damping of {words} that was taken off is {beyond} more than the strokes show: "
        return [Notice(text + "is the plant's A or K_f too large?", "damping-too-large", "wrong")]
    text = f"sigma is 0: the damping of {words} that was taken off with the plant's A holds the viscous friction too."
    return [Notice(text, "A-holds-viscous", "note")]
