"""A recorded motion and its replay by the identified axis, in the second where they differ most."""

from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure

from fric.circles.validation import Validation
from fric.figures.style import BLACK, BLUE, GREY, VERMILION, look, new_figure, view
from fric.identify.replay.compare import Comparison
from fric.identify.replay.replay_fit import ReplayFit
from fric.units import prefixed, si_unit


@view("validation", of="Validation", usual=True)
def draw_validation(validations: Sequence[Validation]) -> Figure:
    """Draw measured and simulated signals of the first replay, and their difference, over the worst second."""
    validation = validations[0]
    log, (first, stop) = validation.log, validation.worst
    time = log.time[first:stop]
    shown = [name for name in ("position", "velocity", "force") if name in validation.signals]
    with new_figure(7.0, 1.9 * len(shown)) as figure:
        axes = figure.subplots(len(shown), 2, sharex=True, squeeze=False)
        for (both, rest), name in zip(axes, shown, strict=True):
            signal, si = validation.signals[name], si_unit(name, log.motion)
            measured, simulated = signal.measured[first:stop], signal.simulated[first:stop]
            scale, unit = prefixed(float(abs(measured).max()), si)
            both.plot(time, scale * measured, color=GREY, lw=2.0, label="measured")
            both.plot(time, scale * simulated, color=VERMILION, lw=1.0, label="simulated")
            both.set(ylabel=f"{name} [{unit}]")
            difference = measured - simulated
            scale, unit = prefixed(float(abs(difference).max()), si)
            rest.plot(time, scale * difference, color=VERMILION, lw=0.8)
            rest.set(ylabel=f"difference [{unit}]", title=f"relative error, whole record: {signal.relative:.3%}")
        axes[0, 0].set_title(f"{validation.loop} loop, {validation.friction.name}: worst second")
        axes[0, 0].legend(loc="best")
        for axis in axes[-1]:
            axis.set_xlabel("time [s]")
        return figure


MOST_DRAWN = 4  # Records that are drawn


@view("replay", of="ReplayFit", usual=True)
def draw_replay(fit: ReplayFit) -> Figure:
    """Draw, for each record, measured and replayed force over position, and the residual over time."""
    records = fit.records[:MOST_DRAWN]
    with new_figure(6.3, 2.6 * len(records)) as figure:
        axes = figure.subplots(len(records), 2, squeeze=False)
        force, position = si_unit("force", fit.motion), si_unit("position", fit.motion)
        for (cycle, rest), record, values in zip(axes, records, fit.own, strict=False):
            z, used = record.motion.position, record.used
            scale, unit = prefixed(float(np.ptp(z)), position)
            replayed = record.replay(fit.model) + record.own @ np.asarray(values)
            cycle.plot(scale * z[used], record.force[used], color=GREY, lw=2.5, alpha=0.5, label="measured")
            cycle.plot(scale * z[used], replayed[used], color=BLUE, lw=1.0, label=fit.model.name)
            cycle.set(xlabel=f"position [{unit}]", ylabel=f"force [{force}]", title=record.log.name)
            cycle.legend(loc="best")
            residual = np.where(used, record.force - replayed, np.nan)
            rest.plot(record.motion.time, residual, color=BLACK, lw=0.6)
            text = float(np.sqrt(np.nanmean(residual**2)))
            rest.set(xlabel="time [s]", ylabel=f"measured - replayed [{force}]", title=f"rms {text:.3g} {force}")
        return figure


@view("scores", of="Comparison", usual=True)
def draw_comparison(comparison: Comparison) -> Figure:
    """Draw the rms of every model, and the first hysteresis cycle scored of the first record that is scored."""
    scores = comparison.scores
    motion = comparison.records[0].log.motion
    force, length = si_unit("force", motion), si_unit("position", motion)
    with new_figure(7.0, 3.6) as figure:
        bars, hysteresis = figure.subplots(1, 2, width_ratios=[1.0, 1.3])
        place = np.arange(len(scores))[::-1]
        whole, near = [s.rms for s in scores], [s.rms_near for s in scores]
        for at, rms, color, hatch, label in (
            (0.2, whole, BLUE, "", "all samples scored"), (-0.2, near, VERMILION, "////", "near reversals"),
        ):  # fmt: skip
            drawn = bars.barh(place + at, rms, 0.38, color=color, hatch=hatch, edgecolor="white", label=label)
            bars.bar_label(drawn, fmt="{:.3g}", padding=3)
        bars.margins(x=0.15)
        bars.set_yticks(place, [s.name for s in scores])
        bars.set(xlabel=f"rms force error [{force}]")
        bars.grid(visible=False, axis="y")
        figure.legend(*bars.get_legend_handles_labels(), loc="outside lower left", ncols=2)

        number = next(n for n, rest in enumerate(scores[0].residual) if np.isfinite(rest).any())
        record = comparison.records[number]
        shown = np.isfinite(scores[0].residual[number])
        reversals = record.reversals[shown[np.minimum(record.reversals, len(shown) - 1)]]
        if len(reversals) > 2:
            within = np.arange(len(shown))
            shown &= (within >= reversals[0]) & (within <= reversals[2])
        z = record.motion.position[shown]
        scale, unit = prefixed(float(np.ptp(z)), length)
        z = scale * (z - 0.5 * (z.min() + z.max()))
        hysteresis.plot(z, record.force[shown], color=GREY, lw=2.5, alpha=0.5, label="measured")
        for n, score in enumerate(scores):
            hysteresis.plot(z, (record.force - score.residual[number])[shown], **look(n), lw=0.9, label=score.name)
        hysteresis.set(xlabel=f"position about the middle [{unit}]", ylabel=f"force [{force}]", title=record.log.name)
        hysteresis.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0))
        return figure
