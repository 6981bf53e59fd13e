"""A recorded motion and its replay by the identified axis, in the second where they differ most."""

from collections.abc import Sequence

from matplotlib.figure import Figure

from fric.circles.validation import Validation
from fric.figures.style import GREY, VERMILION, new_figure
from fric.figures.views import view
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
