"""Where planned records sample friction: speeds on the static map, sines on the virgin curve, half-widths expected."""

import numpy as np
from matplotlib.figure import Figure

from fric.figures.style import BLACK, BLUE, GREY, VERMILION, new_figure, view
from fric.friction.directed import Directed
from fric.simulate.experiment import Plan
from fric.units import prefixed, si_unit


@view("plan", of="Plan", usual=True)
def draw_plan(plan: Plan) -> Figure:
    """Draw the speeds of a plan on the known map, its sines on the virgin curve, and the expected intervals."""
    axis = plan.axis
    model = axis.friction.model if isinstance(axis.friction, Directed) else axis.friction
    asked = {record.kind: record.settings for record in plan.planned}
    with new_figure(9.0, 3.4) as figure:
        left, middle, right = figure.subplots(1, 3, width_ratios=(1, 1, 1.1))
        speeds = np.array(asked.get("constant-velocity", {}).get("speeds", (1e-3,)))
        v = np.geomspace(speeds.min() / 2, speeds.max() * 1.2, 300)
        top, force = prefixed(float(np.max(model.steady_state(v))), si_unit("force", axis.motion))
        speed, named = prefixed(float(speeds.max()), si_unit("velocity", axis.motion))
        left.semilogx(v * speed, np.asarray(model.steady_state(v)) * top, color=BLACK, label="known before")
        left.plot(speeds * speed, np.asarray(model.steady_state(speeds)) * top, "o", color=BLUE, label="strokes")
        if (sliding := asked.get("sliding-sine")) is not None:
            mean, swing = float(sliding["mean"]), float(sliding["swing"])  # type: ignore[arg-type]
            ends = (mean - swing) * speed, (mean + swing) * speed
            left.axvspan(*ends, color=VERMILION, alpha=0.2, label="sliding sine")
        left.set(xlabel=f"velocity [{named}]", ylabel=f"friction [{force}]", title="speeds")
        left.legend()
        amplitudes = np.array(asked.get("presliding-sine", {}).get("amplitudes", (1e-4,)))
        z = np.geomspace(1e-3 * amplitudes.max() / 8, 1.2 * amplitudes.max(), 300)
        length, metre = prefixed(0.1 * float(amplitudes.max()), si_unit("position", axis.motion))
        if hasattr(model, "virgin_curve"):
            middle.semilogx(z * length, model.virgin_curve(z) * top, color=BLACK, label="virgin curve")
        for n, amplitude in enumerate(amplitudes):
            colour, label = (BLUE, VERMILION)[n % 2], "" if n else "amplitudes of the sines"
            middle.axvline(amplitude * length, color=colour, linestyle="--", label=label)
        middle.set(xlabel=f"displacement [{metre}]", ylabel=f"friction [{force}]", title="sines before sliding")
        middle.legend()
        shown = [(name, expected) for name, expected in plan.expected.items() if expected.value]
        shares = np.array([100 * expected.half_width / abs(expected.value) for _, expected in shown])
        kept = np.isfinite(shares) & (shares < 200)
        names = [name for (name, _), good in zip(shown, kept, strict=True) if good]
        right.barh(np.arange(len(names)), shares[kept], color=GREY)
        right.set_yticks(np.arange(len(names)), names)
        right.invert_yaxis()
        right.set(xscale="log", xlabel="half-width over value [%]", title="95 % to be expected")
    return figure
