"""What the data cannot tell about a fitted static map, in words: one function a flaw."""

from collections.abc import Iterator, Sequence
from math import isinf, log

import numpy as np
from scipy.special import chdtrc, fdtrc

from fric.estimate import Interval
from fric.identify.plant.covariance import smoother_than_noise
from fric.identify.static_map.map_fit import MapFit
from fric.identify.static_map.scatter import REPEATED
from fric.notice import Notice

SCATTERED = 0.1
"""Scatter between strokes, as a share of their force, from which on a map of speed is doubted."""
TAKEN = 0.05
"""Share of the drive's damping that its plant may be off by, before the strokes contradict it."""
DIFFERENT = 1e-3
"""Probability under which directions that are alike are not taken for different."""
CORRELATED = 0.95
"""Correlation of two parameters from which on the data tell them apart badly."""
MISSED = 0.005
"""Share of the force by which a map misses the strokes of both directions at one speed (rms), from which on it is
doubted."""
SEEN = 0.5
"""Share of the fall from F_s to F_c that lies above the slowest stroke at least, for F_s to be told by strokes."""


def map_notices(fit: MapFit) -> Iterator[Notice]:
    """Say what the data cannot tell about a fitted map."""
    for look in (_fall, _ageing, _strokes, _correlated, _scatter, directions_differ, _misfit):
        yield from look(fit)


def _slowest(fit: MapFit) -> str:
    return fit.asked.says(float(np.abs(fit.problem.v).min()), "velocity")


def _is_flat(fit: MapFit) -> bool:
    theta = fit.solution.theta
    return not fit.problem.fall or theta["F_s"] <= theta["F_c"] * (1 + 1e-9)


def _fall(fit: MapFit) -> Iterator[Notice]:
    """Say where strokes do not show how friction falls with speed."""
    says, slowest, theta = fit.asked.says, _slowest(fit), fit.solution.theta
    speed = np.abs(fit.problem.v).min()
    if not fit.problem.fall:
        if "stribeck" in fit.held_out.errors:
            plain, falling = (says(fit.held_out[form], "force") for form in ("coulomb", "stribeck"))
            yield Notice(
                f"friction is not seen to fall with speed down to {slowest}: Coulomb plus viscous friction predicts "
                f"strokes that are held out to {plain}, eq. (2) to {falling}. F_s = F_c and v_s are assumed; to see "
                "the fall log slower strokes, or force it with --form stribeck.", "fall-not-seen", "doubt",
            )  # fmt: skip
    elif _is_flat(fit):
        yield Notice(
            f"F_s sits at its bound F_c: friction does not fall with speed down to {slowest}; v_s means nothing here.",
            "fall-not-seen", "doubt",
        )  # fmt: skip
    elif any(isinf(limit) or limit == 0.0 for name in ("F_s", "v_s") for limit in _interval(fit, name)):
        yield Notice(
            f"the data do not reach the Stribeck range: F_s and v_s are not settled by strokes from {slowest} up. "
            "Log slower strokes.", "fall-open", "doubt",
        )  # fmt: skip
    elif (seen := float(np.exp(-((float(speed) / theta["v_s"]) ** theta["delta"])))) < SEEN:
        yield Notice(
            f"{1 - seen:.0%} of the fall lies below the slowest stroke that was used ({slowest}): F_s is no more than "
            f"how eq. (2) goes on from {says(float(fit.static_map.level(speed)), 'force')} there. Log slower strokes, "
            "or a finer encoder.", "F_s-extrapolated", "wrong",
        )  # fmt: skip
    if not _is_flat(fit) and theta["F_c"] <= 0.0:
        yield Notice(
            "F_c ends at its bound of 0: the fall reaches beyond the fastest stroke. Log faster strokes, or take "
            "Coulomb plus viscous friction with --form coulomb.", "F_c-at-bound", "wrong",
        )  # fmt: skip


def _interval(fit: MapFit, name: str) -> Interval:
    return fit.estimates[name].ci95 or (0.0, 0.0)  # type: ignore[return-value]


def _ageing(fit: MapFit) -> Iterator[Notice]:
    """Say that F_s grows with the time of contact."""
    if (rise := fit.held_out.ages) is not None:
        says = fit.asked.says
        plain, ageing = (says(fit.held_out[form], "force") for form in ("stribeck", "ages"))
        yield Notice(
            f"static friction ages: it grows by {says(rise * log(10.0), 'force', 2)} with each tenfold of the "
            f"time of contact (errors at strokes held out: {ageing} so, {plain} by eq. (2)). F_s is that of "
            f"strokes down to {_slowest(fit)}, and too little for an axis that has "
            "rested: log strokes as slow as it moves at work, and look at break-away after rests.",
            "friction-ages", "wrong",
        )  # fmt: skip


def _strokes(fit: MapFit) -> Iterator[Notice]:
    """Say which strokes were left out, and which weigh less."""
    says = fit.asked.says
    if fit.left_out:
        strokes = ", ".join(f"{p.record} ({says(p.velocity, 'velocity')})" for p in fit.left_out)
        yield Notice(
            f"left out, because they stand off all others: the strokes at {strokes}. Look at their records.",
            "strokes-left-out", "doubt",
        )  # fmt: skip
    if fit.standing_off:
        strokes = ", ".join(f"{p.record} ({says(p.velocity, 'velocity')})" for p, _ in fit.standing_off)
        most = says(max(by for _, by in fit.standing_off), "force", 2)
        yield Notice(
            f"the strokes at {strokes} stand off what all others show by up to {most}, and weigh by that: between "
            "two counts of its encoder a slow axis may stick and slip unseen. Look at their records.",
            "strokes-stand-off", "note",
        )  # fmt: skip


def _correlated(fit: MapFit) -> Iterator[Notice]:
    """Say which parameters the data tell apart badly; beyond 1 is at a bound, where the curvature says nothing."""
    without = {"v_s", "delta"} if _is_flat(fit) else set()
    size, free = np.sqrt(np.diag(fit.covariance)), fit.problem.free
    with np.errstate(invalid="ignore", divide="ignore"):
        correlation = fit.covariance / np.outer(size, size)
    pairs = [
        f"{free[j]} and {free[i]} ({correlation[i, j]:+.3f})"
        for i in range(len(free)) for j in range(i)
        if not {free[i], free[j]} & without and CORRELATED < abs(correlation[i, j]) <= 1.0 + 1e-9
    ]  # fmt: skip
    if pairs:
        yield Notice(f"correlated, the data tell them apart badly: {', '.join(pairs)}.", "correlated", "note")


def _scatter(fit: MapFit) -> Iterator[Notice]:
    """Say how strokes scatter beyond their noise, unless single ones of them explain it."""
    problem = fit.problem
    own = problem.standard_error**2 - fit.between**2  # of each stroke's noise, which may be lost beside the scatter
    single = float(np.sum(fit.residual**2 / own)) if own.min() > 0 else np.inf
    if fit.between and chdtrc(problem.degrees_of_freedom, single) < 0.01:
        share = fit.between / float(np.median(np.abs(problem.F)))
        text = (
            f"strokes scatter by {fit.asked.says(fit.between, 'force', 2)} beyond their own noise; weights and "
            "intervals allow for it."
        )
        if share > SCATTERED:
            text += (
                f" It is {share:.0%} of the force: friction that does not repeat, a play or an axis that hunts, is "
                "no map of speed. Look at their records."
            )
        yield Notice(text, "strokes-scatter", "doubt" if share > SCATTERED else "note")


def _misfit(fit: MapFit) -> Iterator[Notice]:
    """Say where the residuals are no noise."""
    problem = fit.problem
    smooth = smoother_than_noise((fit.residual / problem.standard_error)[np.argsort(problem.v)], -2.33)
    missed = 0.0 if smooth else _missed_both_ways(fit)
    if fit.rmse > 1e-6 * float(np.abs(problem.F).max()) and (smooth or missed):
        by = fit.asked.says(missed, "force", 2)
        shown = "they follow the speed" if smooth else f"both directions show the same at each speed, {by} (rms)"
        changed = "" if smooth else ", or friction changed between them"
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


def directions_differ(fit: MapFit) -> Sequence[Notice]:
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
    return [Notice(
        f"the directions differ by more than an offset, by up to {fit.asked.says(2 * most, 'force', 2)}: this map is "
        "that of neither. Identify again with --direction each, and with --load where you know the weight.",
        "directions-differ", "wrong",
    )]  # fmt: skip


def damping_notices(fit: MapFit) -> Sequence[Notice]:
    """Say when more than the drive's own damping was taken off with a plant, or all viscous friction with it.

    A response shows the sum of both in A; sigma is then what is left of it, and 0 within its error and the plant's.
    """
    problem, theta, asked = fit.problem, fit.solution.theta, fit.asked
    if asked.plant is None or theta["sigma"] > 0 or "sigma" not in problem.free:
        return []
    J = problem.jacobian(theta) / problem.standard_error[:, None]
    size = np.linalg.norm(J, axis=0)
    used = size > 0
    inverse = np.linalg.pinv(J[:, used] / size[used], rcond=1e-7) / size[used][:, None]
    at = [name for name, one in zip(problem.free, used, strict=True) if one].index("sigma")
    short = -theta["sigma"] - float(inverse[at] @ (fit.residual / problem.standard_error))
    error = float(np.hypot(2 * np.linalg.norm(inverse[at]), asked.damping_error))
    words = asked.says(asked.damping, "viscous")
    if short > max(error, TAKEN * asked.damping):
        beyond = asked.says(short, "viscous")
        text = f"the drive's own damping of {words} that was taken off is {beyond} more than the strokes show: "
        return [Notice(text + "is the plant's A or K_f too large?", "damping-too-large", "wrong")]
    text = f"sigma is 0: the damping of {words} that was taken off with the plant's A holds the viscous friction too."
    return [Notice(text, "A-holds-viscous", "note")]
