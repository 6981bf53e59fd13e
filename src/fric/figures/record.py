"""Records: as logged, with what `fric inspect` found in them; as planned; and replayed by the identified axis."""

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from fric.arrays import Real
from fric.circles.validation import Validation
from fric.figures.style import BLACK, BLUE, GREY, ORANGE, VERMILION, look, new_figure, thinned, view
from fric.friction.directed import Directed
from fric.identify.replay.compare import Comparison
from fric.identify.replay.replay_fit import ReplayFit
from fric.identify.static_map.points import standard_errors
from fric.log import ForceVelocity, FrequencyResponse, Log, Record
from fric.records.inspection import Inspected, Inspection
from fric.simulate.experiment import Plan
from fric.units import prefixed, si_unit

POINTS = 4000  # Columns that a curve is drawn in: more samples than twice that are drawn as their least and greatest
MOST_ROWS = 6  # Largest number of records that each get a separate row of panels; more records are overlaid
MOST_DRAWN = 4  # Records that are drawn


def draw_record(records: Sequence[Record], found: Sequence[Inspected]) -> Figure:
    """Draw records with segments and reversals marked.

    A few records get a row each: the channels over time to the left; to the right force over position (a motion that
    reverses) or over velocity (strokes). Many are drawn as an overview: speeds and forces of all segments, and each
    record's path.
    """
    if len(pairs := list(zip(records, found, strict=True))) > MOST_ROWS:
        return _overview(pairs)
    height = sum(3.6 if isinstance(record, Log) else 2.6 for record in records)
    with new_figure(7.4, max(height, 3.0)) as figure:
        for row, (record, inspected) in zip(figure.subfigures(len(pairs), 1, squeeze=False)[:, 0], pairs, strict=True):
            row.suptitle(f"{inspected.name} – {inspected.kind}", fontsize=10, x=0.01, ha="left")
            if isinstance(record, FrequencyResponse):
                left, right = row.subplots(1, 2)
                left.loglog(record.frequency, record.magnitude, color=BLUE)
                left.set(xlabel="frequency [Hz]", ylabel=f"magnitude [{si_unit('position per input', record.motion)}]")
                right.semilogx(record.frequency, np.degrees(record.phase), color=BLUE)
                right.set(xlabel="frequency [Hz]", ylabel="phase [°]")
            elif isinstance(record, ForceVelocity):
                _draw_table(row.subplots(1, 2), record)
            else:
                _draw_log(row, record, inspected)  # type: ignore[arg-type]
        return figure


def _size(values: Real) -> float:
    return float(np.nanmax(np.abs(values), initial=0.0))


def _velocity(log: Log) -> Real:
    """Return the velocity; of a position log, its slope over about a hundredth part of a second or ten samples."""
    if log.velocity is not None:
        return log.velocity
    assert log.position is not None  # a Log holds one of them
    span = max(min(10, len(log) // 20), 1)
    ends = np.clip(np.arange(len(log))[:, None] + np.array([-span, span]), 0, len(log) - 1)
    return np.asarray(np.diff(log.position[ends])[:, 0] / np.diff(log.time[ends])[:, 0])


def _draw_log(row: Figure, log: Log, found: Inspection) -> None:
    force = log.force
    panels = [("position", log.position), ("velocity", _velocity(log)), ("force", force)]
    panels = [(name, values) for name, values in panels if values is not None]
    if force is None and log.input is not None:
        panels.append(("input", log.input))
    left, right = row.subfigures(1, 2, squeeze=False, width_ratios=[1.5, 1])[0]
    axes = np.atleast_1d(left.subplots(len(panels), 1, sharex=True))
    for axis, (name, values) in zip(axes, panels, strict=True):
        assert values is not None
        factor, unit = prefixed(_size(values), log.unit(name))
        axis.plot(*thinned(log.time, values * factor, POINTS), color=BLUE, linewidth=0.9)
        axis.set_ylabel(f"{name} [{unit}]")
        for segment in found.stretches:
            axis.axvspan(log.time[segment.start], log.time[segment.stop - 1], color=ORANGE, alpha=0.25, linewidth=0)
        if name == "position" and 0 < len(found.reversals) <= 400:
            reversals = np.array(found.reversals)
            axis.plot(log.time[reversals], values[reversals] * factor, ".", color=VERMILION, markersize=4)
    axes[-1].set_xlabel("time [s]")
    row_note = [f"orange: {len(found.stretches)} segments at constant velocity"] if found.stretches else []
    row_note += [f"dots: {len(found.reversals)} reversals"] if log.position is not None and found.reversals else []
    axes[0].set_title(", ".join(row_note), fontsize=8, loc="left", color=GREY)
    _draw_relation(right.subplots(1, 1), log, found)


def _draw_relation(axis: Axes, log: Log, found: Inspection) -> None:
    """Draw force over velocity where there are segments, else over position; position over velocity without force."""
    if log.force is None:
        names = ("velocity", "time" if log.position is None else "position")
    elif found.stretches or log.position is None or found.kind in {"sliding-sine", "frequency-response"}:
        names = ("velocity", "force")
    else:
        names = ("position", "force")
    values = log.channels() | {"velocity": _velocity(log)}
    x, y = (values[name] for name in names)
    fx, ux = prefixed(_size(x), log.unit(names[0]))
    fy, uy = (1.0, "s") if names[1] == "time" else prefixed(_size(y), log.unit(names[1]))
    thin = slice(None, None, max(len(x) // (4 * POINTS), 1))
    line = "." if len(x) > 2 * POINTS and names[0] == "velocity" else "-"
    axis.plot(x[thin] * fx, y[thin] * fy, line, color=GREY, linewidth=0.6, markersize=1)
    if names == ("velocity", "force"):
        v = np.array([s.velocity for s in found.stretches])
        F = np.array([np.median(y[s.start : s.stop]) for s in found.stretches])
        axis.plot(v * fx, F * fy, "o", color=VERMILION, markersize=4, label="median of a segment")
        if len(v):
            axis.legend(loc="best")
    axis.set(xlabel=f"{names[0]} [{ux}]", ylabel=f"{names[1]} [{uy}]")


def _draw_table(axes: NDArray[np.object_], table: ForceVelocity) -> None:
    """Draw mean forces with their 95 % errors over velocity, and the size of both over a logarithmic speed."""
    fv, uv = prefixed(_size(table.velocity), table.unit("velocity"))
    fF, uF = prefixed(_size(table.force), table.unit("force"))
    error = 1.96 * standard_errors(table)[0]
    forward = table.velocity > 0
    for axis, sign in ((axes[0], np.ones_like(table.velocity)), (axes[1], np.sign(table.velocity))):
        for chosen, colour, marker, label in (
            (forward, BLUE, "o", "positive direction"), (~forward, VERMILION, "s", "negative direction")
        ):  # fmt: skip
            if chosen.any():
                x, y = (sign * table.velocity)[chosen] * fv, (sign * table.force)[chosen] * fF
                axis.errorbar(x, y, error[chosen] * fF, fmt=marker, color=colour, markersize=4, label=label)
    axes[0].set(xlabel=f"velocity [{uv}]", ylabel=f"force [{uF}]")
    axes[1].set(xlabel=f"speed [{uv}]", ylabel=f"force along the motion [{uF}]", xscale="log")
    axes[0].legend(loc="best")


def _overview(pairs: list[tuple[Record, Inspected]]) -> Figure:
    """Draw many records: the median force of each segment over its velocity, and each record over its duration."""
    logs = [(log, found) for log, found in pairs if isinstance(log, Log)]
    with new_figure(7.4, 3.8) as figure:
        left, right = figure.subplots(1, 2)
        segments = [
            (s.velocity, float(np.median(log.force[s.start : s.stop])), s.settled) for log, found in logs
            if log.force is not None and isinstance(found, Inspection) for s in found.stretches
        ]  # fmt: skip
        means = [table for table, _ in pairs if isinstance(table, ForceVelocity)]
        segments += [(v, F, True) for table in means for v, F in zip(table.velocity, table.force, strict=True)]
        motion = pairs[0][0].motion
        v, F, settled = np.array(segments, float).reshape(-1, 3).T
        settled = settled > 0
        fv, uv = prefixed(_size(v), si_unit("velocity", motion))
        fF, uF = prefixed(_size(F), si_unit("force", motion))
        left.plot(v[settled] * fv, F[settled] * fF, "o", color=BLUE, markersize=4, label="settled")
        if (~settled).any():
            left.plot(v[~settled] * fv, F[~settled] * fF, "x", color=VERMILION, markersize=5, label="not settled")
            left.legend()
        left.set(xlabel=f"velocity [{uv}]", ylabel=f"force, median of a segment [{uF}]")
        left.set_title(f"{len(v)} segments of {len(pairs)} records", fontsize=9, loc="left")
        positions = all(log.position is not None for log, _ in logs)
        paths = [_velocity(log) if log.position is None or not positions else log.position - log.position[0]
                 for log, _ in logs]  # fmt: skip
        name = "position from the start" if positions else "velocity"
        largest = max((float(np.abs(path).max()) for path in paths), default=0.0)
        factor, unit = prefixed(largest, si_unit("position" if positions else "velocity", motion))
        for (log, _), path in zip(logs, paths, strict=True):
            share = (log.time - log.time[0]) / max(float(log.time[-1] - log.time[0]), 1e-12)
            right.plot(*thinned(share, path * factor, POINTS), color=BLUE, alpha=0.5, linewidth=0.7)
        right.set(xlabel="time / duration of the record", ylabel=f"{name} [{unit}]")
        right.set_title("all records", fontsize=9, loc="left")
        return figure


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
        amplitudes = np.unique(asked.get("presliding-sine", {}).get("amplitudes", (1e-4,)))
        z = np.geomspace(1e-3 * amplitudes.max() / 8, 1.2 * amplitudes.max(), 300)
        length, metre = prefixed(0.1 * float(amplitudes.max()), si_unit("position", axis.motion))
        if hasattr(model, "virgin_curve"):
            middle.semilogx(z * length, model.virgin_curve(z) * top, color=BLACK, label="virgin curve")
        for n, amplitude in enumerate(amplitudes):
            middle.axvline(amplitude * length, color=BLUE, linestyle="--", label="" if n else "amplitudes")
        middle.set(xlabel=f"displacement [{metre}]", ylabel=f"friction [{force}]", title="sines before sliding")
        middle.legend(loc="upper left")
        shown = [(name, expected) for name, expected in plan.expected.items() if expected.value]
        shares = np.array([100 * expected.half_width / abs(expected.value) for _, expected in shown])
        kept = np.isfinite(shares) & (shares < 200)
        names = [name for (name, _), good in zip(shown, kept, strict=True) if good]
        right.barh(np.arange(len(names)), shares[kept], color=GREY)
        right.set_yticks(np.arange(len(names)), names)
        right.invert_yaxis()
        right.set(xscale="log" if names else "linear", xlabel="half-width over value [%]", title="95 % to be expected")
    return figure


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
        if len(reversals := record.reversals[shown[np.minimum(record.reversals, len(shown) - 1)]]) > 2:
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
