"""Pre-sliding cycles, virgin curve, and replay: Figs. 4 and 5 of the paper."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from fric.arrays import Real
from fric.figures.style import BLACK, BLUE, GREY, ORANGE, VERMILION, new_figure
from fric.figures.views import view
from fric.identify.gms.cycles import HysteresisCycles
from fric.identify.gms.fit import GMSFit
from fric.identify.replay.measured import Replay
from fric.units import prefixed, si_unit

Scale = tuple[float, str]


@view("cycles", of="GMSFit", usual=True)
def draw_gms(fit: GMSFit) -> Figure:
    """Draw the hysteresis cycles, the virgin curve with knots and band, and the measured against the replayed force.

    The first row shows each record as the paper's Fig. 4, with the parts marked that the virgin curve is from; the
    second the virgin curve as Fig. 5, and again over a logarithmic axis, where the first knots are; the third each
    record over time.

    Parameters
    ----------
    fit
        What `fric.identify.gms.identify.identify_gms` found.
    """
    hysteresis = sorted(fit.hysteresis, key=lambda one: one.amplitude)
    rows = 2 + len(fit.records)
    with new_figure(7.4, 5.6 + 1.5 * len(fit.records)) as figure:
        grid = figure.add_gridspec(rows, 2 * len(hysteresis), height_ratios=[2.2, 2.2, *[1.2] * len(fit.records)])
        force = prefixed(fit.static.F_s, si_unit("force", fit.motion))
        for n, one in enumerate(hysteresis):
            _cycle(figure.add_subplot(grid[0, 2 * n : 2 * n + 2]), fit, one, force)
        middle = len(hysteresis)
        _curve(figure.add_subplot(grid[1, :middle]), fit, force, logarithmic=False)
        _curve(figure.add_subplot(grid[1, middle:]), fit, force, logarithmic=True)
        for n, record in enumerate(fit.records):
            _replay(figure.add_subplot(grid[2 + n, :]), record, force, legend=n == 0)
        return figure


def _cycle(axes: Axes, fit: GMSFit, hysteresis: HysteresisCycles, force: Scale) -> None:
    """Draw one record, with what is selected of it in colour."""
    length = prefixed(hysteresis.amplitude, si_unit("position", fit.motion))
    middle = 0.5 * (hysteresis.motion.position.max() + hysteresis.motion.position.min())
    far = abs(middle) > 2.0 * hysteresis.amplitude
    z, F = (hysteresis.motion.position - middle * far) * length[0], hysteresis.force * force[0]
    axes.plot(z, F, color=GREY, lw=0.6, label="record")
    ends = dict(fit.curve.record)
    start = max((end for end in ends.values() if end < 0.95 * ends.get(hysteresis.name, np.inf)), default=0.0)
    label: str | None = "selected"
    for first, reversal, last in hysteresis.chosen() if hysteresis.name in ends else []:
        for a, b in ((first, reversal), (reversal, last)):
            part = slice(a, b + 1)
            travel = 0.5 * np.abs(hysteresis.motion.position[part] - hysteresis.motion.position[a])
            chosen = travel >= start
            axes.plot(z[part][chosen], F[part][chosen], color=VERMILION, lw=0.9, label=label)
            label = None
    place = "position from the middle" if far else "position"
    axes.set(xlabel=f"{place} [{length[1]}]", ylabel=f"friction [{force[1]}]", title=hysteresis.name)
    axes.legend(loc="center")


def _curve(axes: Axes, fit: GMSFit, force: Scale, *, logarithmic: bool) -> None:
    """Draw the measured virgin curve with its band, the model's, and the knots."""
    curve, level = fit.curve, float(fit.alpha_sum) if fit.static_given else 1.0
    knots = fit.model.slip_displacements * level
    far = float(curve.displacement[-1])
    shown = far if logarithmic else min(far, 2.0 * float(knots[-1]))
    length = prefixed(float(np.median(knots)), si_unit("position", fit.motion))
    z, half = curve.displacement, np.nan_to_num(curve.band)
    inside = z <= shown
    axes.plot(z[inside] * length[0], curve.force[inside] * force[0], ".", ms=2.5, color=BLACK, label="measured")
    axes.fill_between(
        z[inside] * length[0], (curve.force - half)[inside] * force[0], (curve.force + half)[inside] * force[0],
        color=ORANGE, alpha=0.4, lw=0, label="95 % band",
    )  # fmt: skip
    at = np.unique(np.concatenate([np.geomspace(z[0], shown, 400), knots[knots <= shown]]))
    stiffness = np.asarray(fit.k.value)

    def model(x: Real) -> Real:
        return np.asarray(np.minimum(x[:, None], knots) @ stiffness)

    axes.plot(at * length[0], model(at) * force[0], color=BLUE, lw=1.0, label="GMS")
    seen = knots[knots <= shown]
    axes.plot(seen * length[0], model(seen) * force[0], "o", ms=5, mfc="white", mec=BLUE, label="knots")
    title = "the same, logarithmic" if logarithmic else f"virgin curve, {len(knots)} blocks"
    axes.set(xlabel=f"displacement [{length[1]}]", ylabel=f"friction [{force[1]}]", title=title)
    if logarithmic:
        axes.set(xscale="log", xlim=(max(float(z[0]), 0.02 * float(knots[0])) * length[0], None))
    axes.legend(loc="lower right")


def _replay(axes: Axes, record: Replay, force: Scale, *, legend: bool) -> None:
    """Draw measured and replayed force over time, and what is left."""
    t = record.time
    axes.plot(t, record.measured * force[0], color=GREY, lw=1.6, label="measured")
    axes.plot(t, record.replayed * force[0], color=BLUE, lw=0.8, label="replayed")
    seen = record.used | record.held_out
    difference = np.where(seen, record.measured - record.replayed, np.nan)
    axes.plot(t, difference * force[0], color=VERMILION, lw=0.5, label="difference")
    if record.held_out.any():
        axes.axvspan(t[record.held_out][0], t[-1], color=ORANGE, alpha=0.12, lw=0, label="held out")
    axes.set(xlabel="time [s]", ylabel=f"friction [{force[1]}]")
    axes.set_title(record.name, loc="left")
    axes.margins(x=0.01)
    if legend:
        axes.legend(loc="lower right", ncols=4, bbox_to_anchor=(1.0, 1.0))
