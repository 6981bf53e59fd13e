"""Bode diagram of an identified plant, and a motion with what the rigid axis makes of it."""

from dataclasses import replace
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from fric.arrays import Complex, Real
from fric.figures.style import BLACK, BLUE, CYCLE, GREY, VERMILION, look, new_figure, view
from fric.identify.plant.identify import MotionFit, PlantFit, ResponseFit
from fric.units import si_unit

MARKERS = "osD^v"


@view("response", of="PlantFit", usual=True)
def draw_plant(fit: PlantFit) -> Figure:
    """Draw measured responses with 95 % bars and eq. (1) with its band; below, the residual of eq. (1).

    Where two amplitudes were compared, a further panel shows A over the gain of Coulomb friction.
    """
    compared = fit.friction.compared
    with new_figure(7.2 if compared else 6.3, 5.6) as figure:
        grid = figure.add_gridspec(3, 1 + compared, height_ratios=(3, 3, 2), width_ratios=(3, 2)[: 1 + compared])
        top = figure.add_subplot(grid[0, 0])
        middle = figure.add_subplot(grid[1, 0], sharex=top)
        bottom = figure.add_subplot(grid[2, 0], sharex=top)
        for n, response in enumerate(fit.responses):
            name = response.measured.table.name if len(fit.responses) > 1 else "measured, 95 %"
            _measured(top, middle, response, CYCLE[n % len(CYCLE)], MARKERS[n % len(MARKERS)], name)
        _model(top, middle, fit)
        for n, response in enumerate(fit.responses):
            _left(bottom, fit, response, CYCLE[n % len(CYCLE)], MARKERS[n % len(MARKERS)], label=n == 0)
        top.set(ylabel=f"|Z/U| [dB of {si_unit('position per input', fit.motion)}]", xscale="log")
        middle.set(ylabel="phase [°]")
        bottom.set(xlabel="frequency [Hz]", ylabel="measured / fit [%, °]")
        top.legend()
        bottom.legend(ncols=2, frameon=True, framealpha=0.9, edgecolor="none")
        for axes in (top, middle):
            axes.tick_params(labelbottom=False)
        if compared:
            _influence(figure.add_subplot(grid[:, 1]), fit)
        return figure


def _measured(top: Axes, middle: Axes, response: ResponseFit, colour: str, marker: str, name: str) -> None:
    table, used = response.measured.table, response.used
    f = table.frequency
    deviation = np.zeros_like(f) if response.measured.method == "table" else 1.96 * np.asarray(table.deviation)
    deviation = np.where(np.isfinite(deviation), deviation, 0.0)
    model = response.model(f)  # its branch of the phase, so that noise does not affect the unwrapping
    degrees = np.degrees(_phase(model) + np.angle(response.measured.response / model))
    decibel = 20 * np.log10(np.maximum(table.magnitude, 1e-300))
    look: dict[str, Any] = {"fmt": marker, "markersize": 3, "markerfacecolor": "white", "elinewidth": 0.7, "zorder": 3}
    dense = f.size > 300  # a Welch spectrum: points alone
    for axes, values, error in ((top, decibel, 20 / np.log(10) * deviation), (middle, degrees, np.degrees(deviation))):
        if dense:
            axes.plot(f[used], values[used], ".", markersize=2, color=colour, label=name, zorder=3)
        else:
            axes.errorbar(f[used], values[used], yerr=error[used], color=colour, label=name, **look)
        axes.plot(f[~used], values[~used], "x", markersize=3, color=GREY, zorder=2,
                  label="left out" if axes is top and np.any(~used) else None)  # fmt: skip


def _phase(G: Complex) -> Real:
    """Return an unwrapped phase [rad] that starts between -270° and -90°, as eq. (1) does."""
    phase = np.unwrap(np.angle(G))
    return phase - 2 * np.pi * np.ceil((phase[0] + np.pi / 4) / (2 * np.pi))


def _model(top: Axes, middle: Axes, fit: PlantFit) -> None:
    used = np.concatenate([response.measured.table.frequency[response.used] for response in fit.responses])
    f = np.geomspace(float(used.min()), float(used.max()), 400)
    first, solution = fit.responses[0], fit.solution
    G = first.of(solution, f, friction=False)
    drawn = np.random.default_rng(0).multivariate_normal(solution.values, solution.covariance, 200)
    draws = np.array([first.of(replace(solution, values=values), f, friction=False) for values in drawn])
    if fit.friction.differs:
        for n, response in enumerate(fit.responses):
            seen = response.of(fit.solution, f)
            top.plot(f, 20 * np.log10(np.abs(seen)), linewidth=0.8, **look(n))
            middle.plot(f, np.degrees(_phase(seen)), linewidth=0.8, **look(n))
    friction = " and friction's hysteresis" if solution.form.friction == "hysteresis" else ""
    label = f"eq. (1){friction}{' and a second mass' if fit.second_mass else ''}, 95 %"
    top.plot(f, 20 * np.log10(np.abs(G)), color=BLACK, label=label, zorder=4)
    A, B, T_d = (fit.estimates[name] for name in ("A", "B", "T_d"))
    unit = B.unit.replace("*", "·").replace("^2", "²")
    top.set_title(f"A {float(A):.4g} 1/s, B {float(B):.4g} {unit}, T_d {1e3 * float(T_d):.3g} ms")
    middle.plot(f, np.degrees(_phase(G)), color=BLACK, zorder=4)
    ratio = draws / G
    size = np.percentile(20 * np.log10(np.abs(ratio)), [2.5, 97.5], axis=0) + 20 * np.log10(np.abs(G))
    angle = np.degrees(np.percentile(np.angle(ratio), [2.5, 97.5], axis=0) + _phase(G))
    top.fill_between(f, *size, color=BLACK, alpha=0.15, linewidth=0)
    middle.fill_between(f, *angle, color=BLACK, alpha=0.15, linewidth=0)


def _left(axes: Axes, fit: PlantFit, response: ResponseFit, colour: str, marker: str, *, label: bool) -> None:
    f = response.measured.table.frequency[response.used]
    ratio = np.log(response.measured.response[response.used] / response.of(fit.solution, f))
    axes.plot(f, 100 * ratio.real, marker, markersize=2.5, color=colour, label="magnitude [%]" if label else None)
    axes.plot(
        f, np.degrees(ratio.imag), marker, markersize=2.5, color=colour, markerfacecolor="none", alpha=0.8,
        label="phase [°]" if label else None,
    )  # fmt: skip
    axes.axhline(0, color=BLACK, linewidth=0.6)


def _influence(axes: Axes, fit: PlantFit) -> None:
    """Show A as each response alone gives it over the gain of Coulomb friction, and the line to no friction."""
    friction = fit.friction
    for n, (gain, seen, half) in enumerate(zip(friction.gains, friction.seen, friction.half, strict=True)):
        axes.errorbar(gain, seen, yerr=half, fmt=MARKERS[n % len(MARKERS)], color=CYCLE[n % len(CYCLE)], capsize=2,
                      markerfacecolor="white")  # fmt: skip
    low, high = fit.estimates["A"].limits
    A = float(fit.estimates["A"])
    axes.errorbar(0, A, yerr=[[A - low], [high - A]], fmt="*", color=BLACK, markersize=9, capsize=2,
                  label="A without friction" if friction.differs else "A of all")  # fmt: skip
    if friction.differs and friction.coulomb is not None:
        g = np.array([0.0, float(np.max(friction.gains))])
        axes.plot(g, A + float(friction.coulomb) * g, color=BLACK, linewidth=0.8, label="A + F_c/M · gain")
    length = si_unit("position", fit.motion)
    axes.set(xlabel=f"friction's gain [s/{length}]", ylabel="A of each response [1/s]", title="friction's share in A")
    axes.legend()


@view("motion", of="MotionFit", usual=True)
def draw_motion(fit: MotionFit) -> Figure:
    """Draw the logged force with that of the fitted rigid axis, and what is left."""
    unit = si_unit("force", fit.motion) if fit.channel == "force" else "V"
    label = f"{'force' if fit.channel == 'force' else 'input'} [{unit.replace('*', '·')}]"
    figure = motion_figure(fit.time, fit.measured, fit.fitted, label)
    top, bottom = figure.axes
    names = ["M", "F_v", "F_c"] if "F_v" in fit.estimates else ["M", "F_c_positive", "F_c_negative"]
    found = ((name, fit.estimates[name]) for name in names)
    shown = (f"{name} {float(estimate):.4g} {estimate.unit.replace('*', '·')}" for name, estimate in found)
    top.set_title(", ".join(shown), loc="left")
    bottom.set_title(f"relative error {100 * fit.relative_error:.2f} %, autocorrelation {fit.autocorrelation:.2f}")
    return figure


def motion_figure(time: Real, measured: Real, fitted: Real, label: str) -> Figure:
    """Draw the logged force of motions, that of the rigid axis, and what is left.

    time: Instants [s], shape (n,); where they fall, another record begins.
    """
    with new_figure(6.3, 4.2) as figure:
        top, bottom = figure.subplots(2, 1, sharex=True, height_ratios=(3, 1.5))
        cuts = [0, *(np.flatnonzero(np.diff(time) <= 0) + 1).tolist(), len(time)]
        for part in map(slice, cuts, cuts[1:]):
            t, first = time[part], part.start == 0
            top.plot(t, measured[part], color=BLUE, linewidth=1.0, label="measured" if first else None)
            top.plot(t, fitted[part], color=VERMILION, linewidth=1.0, linestyle="--", label="fit" if first else None)
            bottom.plot(t, measured[part] - fitted[part], color=GREY, linewidth=0.8)
        top.set(ylabel=label)
        top.legend(ncols=2, loc="upper right", bbox_to_anchor=(1.0, 1.12), borderaxespad=0.0)
        bottom.set(xlabel="time [s]", ylabel=f"residual{label[label.index(' [') :]}")
        return figure
