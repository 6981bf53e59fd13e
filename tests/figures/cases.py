"""Every figure of the package with what must be seen in it, computed apart from the figure."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from fric.circles.diagnose import diagnose
from fric.circles.learn import learn
from fric.circles.measured import measured_from_run
from fric.circles.tune import tune_axis
from fric.circles.validation import validate_closed_loop
from fric.control.cascade import Cascade
from fric.control.q_filter import QFilter
from fric.control.scheme import PAPER_SCHEMES
from fric.design.cascade import design_cascade
from fric.design.observer import design_observer
from fric.documents.machine_files import read_machine
from fric.drive.plant import LinearPlant, Plant
from fric.figures.circle import (
    AROUND,
    SchemeContour,
    after_reversal_figure,
    along_figure,
    draw_drift,
    last_reversal,
    monte_carlo_figure,
    overlay_figure,
    path_figure,
    polar_figure,
    reversal_figure,
)
from fric.figures.diagnosis import draw_diagnosis, draw_learned, draw_tuned
from fric.figures.gms import (
    FrictionMap,
    MapBranches,
    ReplayedCycle,
    Virgin,
    cycles_figure,
    draw_gms,
    draw_static_map,
    map_figure,
    virgin_figure,
)
from fric.figures.loops import QReach, bode_figure, nichols_figure, nyquist_figure, q_filter_figure, reach_figure
from fric.figures.plant import draw_motion, draw_plant, motion_figure
from fric.figures.record import draw_comparison, draw_plan, draw_record, draw_replay, draw_validation
from fric.figures.style import Band
from fric.friction import models
from fric.friction.stribeck import StaticMap
from fric.identify.gms.identify import identify_gms
from fric.identify.plant.identify import identify_motion, identify_plant
from fric.identify.replay.compare import compare_models, split_by_folds
from fric.identify.replay.replay_fit import identify_by_replay
from fric.identify.static_map.identify import identify_static
from fric.identify.static_map.points import Asked
from fric.io.hdf5 import read_logs, read_records
from fric.log import Log
from fric.planning.choose import choose
from fric.records.inspection import inspect
from fric.records.prepared import prepared
from fric.simulate.contour_run import Circle, PointPath, run_circle, run_path
from fric.simulate.experiment import Expected, Limits, Plan
from fric.simulate.processes import Study
from tests.figures.drawn import Panel, Wanted, curve, edges, function, near, part
from tests.identify.virtual_logs import logs_of
from tests.studies import monte_carlo

ROOT = Path(__file__).parents[2]
Case = tuple[Figure, list[Panel]]
CASES: dict[str, Callable[[], Case]] = {}
SUBJECTS: dict[str, Callable[[], Any]] = {}


def case(make: Callable[[], Case]) -> Callable[[], Case]:
    CASES[make.__name__] = make
    return make


@cache
def machine() -> Any:
    return read_machine(ROOT / "configs/xy-table.yaml")


def subject(make: Callable[[], Any]) -> Callable[[], Any]:
    """Enter what figures are of, by its type: a figure that is new is drawn of it without a case of its own."""
    made = cache(make)
    SUBJECTS[make.__name__] = made
    return made


@subject
def circles() -> Any:
    return [run_circle(machine(), PAPER_SCHEMES[name], Circle(5e-3, 50e-3, 1)) for name in "af"]


def decibel(ratio: Any) -> Any:
    return 20 * np.log10(np.abs(ratio))


@cache
def cascade_loops() -> Any:
    return list(design_cascade(LinearPlant(28.57, 4.526, 0.65e-3)).loops().values())


@case
def bode() -> Case:
    figure = bode_figure(cascade_loops(), 2000.0)
    gain, phase = figure.axes

    def lag(loop: Any) -> Wanted:
        def right(x: Any, y: Any) -> bool:
            reversals = (y - np.degrees(np.angle(loop.response(x)))) / 360
            return near(reversals, np.round(reversals)) and np.abs(np.diff(y)).max() < 90 and -360 <= y[0] <= 0

        return right

    gains = [function(lambda f, loop=loop: decibel(loop.response(f)), 0.5, 2000.0) for loop in cascade_loops()]
    return figure, [Panel(gain, gains), Panel(phase, [lag(loop) for loop in cascade_loops()])]


@case
def nyquist() -> Case:
    figure = nyquist_figure(cascade_loops(), 2000.0)
    (axes,) = figure.axes

    def around(x_0: float, radius: float) -> Wanted:
        return lambda x, y: bool(len(x) > 50 and np.allclose(np.hypot(x - x_0, y), radius) and np.ptp(y) > 0.1 * radius)

    curves = [around(0.0, 1.0)]
    for loop in cascade_loops():
        L = loop.response(np.geomspace(0.2, 2000.0, 6000))
        curves += [curve(L.real, L.imag), around(-1.0, 1 / loop.margins.peak_sensitivity), around(0.0, 1.0)]
    return figure, [Panel(axes, curves)]


@case
def nichols() -> Case:
    figure = nichols_figure(cascade_loops(), 2000.0)
    curves = []
    for loop in cascade_loops():
        L = loop.response(np.geomspace(0.2, 2000.0, 6000))

        def right(x: Any, y: Any, L: Any = L) -> bool:
            return near(y, decibel(L)) and near(np.exp(1j * np.radians(x)).real, np.cos(np.angle(L)))

        curves.append(right)
    return figure, [Panel(figure.axes[0], curves)]


@case
def q_filter() -> Case:
    plant = LinearPlant(28.57, 4.526, 0.65e-3)
    design = design_observer(plant, machine().axis("x").cascade, cutoff=40.0)
    figure = q_filter_figure(design)
    shown = [design.observer.q, design.robust.q, design.sensitive]
    curves = [function(lambda f, q=q: decibel(q.response(f)), 1.0, 2000.0) for q in shown]
    f = design.perturbation.frequency
    curves.append(curve(f, -decibel(np.exp(-2j * np.pi * f * 0.65e-3) - 1)))  # the delay alone
    return figure, [Panel(figure.axes[0], curves)]


@case
def circle() -> Case:
    figure = polar_figure(circles())
    panels = []
    for axes, run in zip(figure.axes, circles(), strict=True):
        x, y = (trace.position for trace in run.traces.values())
        n = len(run.circularity.angle)
        radius = np.hypot(x, y)[-n:] * 1e6 - 5000.0
        panels.append(Panel(axes, [curve(np.unwrap(np.arctan2(y, x))[-n:], radius)]))
        written = {text.get_text() for text in axes.texts}
        assert {f"{glitch * 1e6:+.1f}" for glitch in run.circularity.quadrants} <= written
    return figure, panels


@case
def diagnosis() -> Case:
    run = run_circle(machine(), PAPER_SCHEMES["a"], Circle(5e-3, 50e-3, 2))
    figure = draw_diagnosis(diagnose([measured_from_run(run)]))
    polar, *reversals = figure.axes
    place, error = run.circularity.angle % (2 * np.pi), run.circularity.error * 1e6
    order = np.argsort(place)

    def deviation(x: Any, y: Any) -> bool:
        there = np.interp(x % (2 * np.pi), place[order], error[order], period=2 * np.pi)
        return len(x) > 500 and bool(np.abs(y - there).max() < 1.0) and np.ptp(y) > 15

    def geometry(x: Any, y: Any) -> bool:
        return len(x) > 500 and bool(np.abs(y).max() < 3.0)

    def around(glitch: float) -> Wanted:
        def right(t: Any, y: Any) -> bool:
            top = np.argmax(np.abs(y))  # within 25° of the reversal, which the glitch comes after
            late = t.max() < 1e3 * np.radians(25.1) * 0.1 and 0 < t[top] < 40
            return bool(late and abs(y[top] - glitch * 1e6) < 2.0 and abs(y[0]) < 1.5)

        return right

    panels = [Panel(axes, [around(one)]) for axes, one in zip(reversals, run.circularity.quadrants, strict=True)]
    return figure, [Panel(polar, [deviation, geometry]), *panels]


@case
def reversal() -> Case:
    figure = reversal_figure(circles())
    panels = []
    for n, run in enumerate(circles()):
        trace, half = run.traces["x"], AROUND * 0.1
        t = (trace.time - last_reversal(trace, half)) * 1e3
        seen = np.abs(t) <= half * 1e3
        error = (trace.position - trace.reference) * 1e6
        voltages = [trace.input]
        if run.scheme.name == "f":
            K_f, model = machine().axis("x").plant.K_f, machine().axis("x").nominal_friction.models["gms"]
            reference = trace.reference
            velocity = np.gradient(reference, trace.time)
            force = 0.73 * model.replay(trace.time, reference, velocity)
            assert np.corrcoef(force[seen] / K_f, trace.feedforward[seen])[0, 1] > 0.99
            voltages += [trace.feedforward, -trace.disturbance]
        panels.append(Panel(figure.axes[n], [curve(t[seen], error[seen])]))
        panels.append(Panel(figure.axes[2 + n], [curve(t[seen], one[seen]) for one in voltages]))
    return figure, panels


@case
def tuned() -> Case:
    feeds, axis = (0.1, 0.03), machine().axis("x")
    runs = [run_circle(machine(), PAPER_SCHEMES["f"], Circle(10e-3, feed), accuracy=1e-8) for feed in feeds]
    one = tune_axis(axis, [measured_from_run(run) for run in runs])
    figure = draw_tuned(one)
    panels = []
    for n, feed in enumerate(feeds):
        record, before, after = one.after.balance.records[n], one.before.parts()[n], one.after.parts()[n]
        replayed = record.friction(one.friction) / axis.plant.K_f
        t, r = record.raw[:2]
        forward = np.gradient(r, t) > 0
        turns = t[1:][forward[1:] != forward[:-1]]
        half = np.radians(25) * 10e-3 / feed
        middle = turns[turns < record.time[record.used][-1] - half][-1] - 0.5 * record.sampled
        near_it = np.abs(record.time[record.used] - middle) <= half + record.sampled

        def drawn(values: Any, near_it: Any = near_it, middle: float = middle, record: Any = record) -> Wanted:
            x_wanted, y_wanted = (record.time[record.used] - middle)[near_it] * 1e3, values[near_it]

            def right(x: Any, y: Any) -> bool:
                place = np.abs(x_wanted[:, None] - x).argmin(axis=0)
                return (
                    len(x) > len(x_wanted) - 3
                    and np.allclose(x_wanted[place], x, atol=0.2)
                    and near(y, y_wanted[place])
                )

            return right

        measured = replayed + after
        panels.append(Panel(figure.axes[n], [drawn(measured), drawn(measured - before), drawn(replayed)]))
        panels.append(Panel(figure.axes[2 + n], [drawn(1e3 * before), drawn(1e3 * after)]))
    return figure, panels


@case
def learned() -> Case:
    test = Circle(5e-3, 50e-3, 1)
    found = learn(machine(), test, 2)
    figure = draw_learned(found)
    rounds, around = figure.axes
    glitches = [np.median([np.abs(place.glitches).max() for place in one.places]) * 1e6 for one in found.rounds]

    def deviation(run: Any) -> Wanted:
        def right(x: Any, y: Any) -> bool:
            at, up = (trace.position[-len(x) :] for trace in run.traces.values())
            angle = np.degrees(np.arctan2(up, at)) % 360
            order = np.argsort(angle)
            return len(x) > 2000 and near(x, angle[order]) and near(y, (np.hypot(at, up) - test.radius)[order] * 1e6)

        return right

    runs = (found.rounds[0], found.rounds[-1])
    assert [line.get_ydata()[0] for line in rounds.lines[1:]] == [glitch * 1e6 for _, _, glitch in found.carried]
    return figure, [
        Panel(rounds, [curve([0, 1, 2], glitches)]),
        Panel(around, [deviation(run) for run in runs]),
    ]


@case
def path() -> Case:
    s = np.linspace(0, 2 * np.pi, 120)
    points = PointPath(0.01 * np.cos(s), 0.006 * np.sin(s), 0.05)
    runs = [run_path(machine(), PAPER_SCHEMES[name], points) for name in "af"]
    figure = path_figure(runs)
    plan, along = figure.axes
    ticks = along.get_yticks()
    curves = [
        curve(run.contour.station * 1e3, run.contour.error * 1e6 + tick) for run, tick in zip(runs, ticks, strict=True)
    ]
    x, y = (1e3 * trace.reference for trace in runs[0].traces.values())
    for run, tick in zip(runs, along.get_yticklabels(), strict=True):
        assert f"{run.contour.glitch * 1e6:.1f} µm" in tick.get_text()
    return figure, [Panel(plan, [curve(x, y)]), Panel(along, curves)]


@case
def many_machines() -> Case:
    found = monte_carlo(
        Study(machine(), (PAPER_SCHEMES["a"], PAPER_SCHEMES["f"]), Circle(5e-3, 50e-3, 1)), 12, workers=1
    )
    figure = monte_carlo_figure(found, {"a": 20e-6, "f": 3e-6})
    left, right = figure.axes
    curves = []
    for place, column in enumerate(np.abs(found.quadrants).max(axis=2).T * 1e6):
        curves.append(lambda x, y, c=column, p=place: near(x, c) and np.all(np.abs(y - p) <= 0.36) and np.ptp(y) > 0.2)
    share = [100 * float(np.mean(found.glitches.argmin(axis=1) == n)) for n in (0, 1)]
    for place, column in enumerate(found.glitches.T * 1e6):
        drawn = [line.get_xdata() for line in left.get_lines() if max(abs(y - place) for y in line.get_ydata()) < 0.4]
        marks = [np.quantile(column, q) for q in ((0.05, 0.95), (0.25, 0.75), (0.5,))] + [[(20.0, 3.0)[place]]]
        assert all(any(near(x, mark) for x in drawn) for mark in marks)
    return figure, [Panel(left, curves), Panel(right, bars=share)]


@subject
def static_fit() -> Any:
    return identify_static(read_logs(ROOT / "data/constant-velocity.h5"), Asked())


@case
def static_map() -> Case:
    fit = static_fit()
    figure = draw_static_map(fit)
    v, F = (np.array([getattr(point, name) for point in fit.points]) for name in ("velocity", "force"))
    error = 1.96 * np.hypot([point.standard_error for point in fit.points], fit.static.between)
    found = {name: float(value) for name, value in fit.static.estimates.items()}
    offset = found.pop("offset")
    friction = StaticMap(**found)
    half = lambda x: fit.static.predict(x * 1e-3)[1]  # noqa: E731
    both = lambda x: friction.steady_state(x * 1e-3) + offset  # noqa: E731
    branch = function(both)
    points = [curve(v * 1e3, F + k * error) for k in (-1, 0, 1)]
    along = [
        curve(sign * v[chosen] * 1e3, (F[chosen] - offset) * sign + k * error[chosen])
        for sign, chosen in ((1, v > 0), (-1, v < 0))
        for k in (-1, 0, 1)
    ]
    band = (lambda x: both(x) - half(x), lambda x: both(x) + half(x))
    speed = (lambda x: both(x) - offset - half(x), lambda x: both(x) - offset + half(x))
    return figure, [
        Panel(figure.axes[0], [*points, branch, branch], [band, band]),
        Panel(figure.axes[1], [*along, function(lambda x: both(x) - offset)], [speed]),
    ]


@subject
def gms_fit() -> Any:
    logs = read_logs(ROOT / "data/presliding-sine.h5")
    return identify_gms(logs, static=StaticMap(105.0, 165.0, 1e-3), refined=False)


@case
def gms() -> Case:
    fit = gms_fit()
    figure = draw_gms(fit)
    panels = []
    loops = sorted(fit.hysteresis, key=lambda one: one.amplitude)
    for axes, one in zip(figure.axes, loops, strict=False):
        z = one.record.motion.position * 1e6
        middle = 0.5 * (z.max() + z.min())
        z = z - middle * (abs(middle) > 2e6 * one.amplitude)
        panels.append(Panel(axes, [part(z, one.record.force)], several=True))
    knots = np.sort(fit.model.slip_displacements) * float(fit.alpha_sum)

    def virgin(x: Any) -> Any:
        return float(fit.alpha_sum) * fit.model.virgin_curve(x * 1e-6 / float(fit.alpha_sum))

    for axes, far in ((figure.axes[len(loops)], 2e6 * knots[-1]), (figure.axes[len(loops) + 1], np.inf)):
        z = fit.curve.displacement * 1e6
        seen = z <= far
        at = knots[knots * 1e6 <= max(far, z.max())] * 1e6
        force, band = fit.curve.force[seen], np.nan_to_num(fit.curve.band)[seen]
        limits = ((lambda _, y=force - band: y), (lambda _, y=force + band: y))
        panels.append(Panel(axes, [curve(z[seen], force), function(virgin), curve(at, virgin(at))], [limits]))
    for axes, record in zip(figure.axes[len(loops) + 2 :], fit.records, strict=True):
        time, measured = record.record.motion.time, record.record.force
        rest = np.where(record.record.used | record.held_out, measured - record.replayed, np.nan)
        panels.append(Panel(axes, [curve(time, y) for y in (measured, record.replayed, rest)]))
    return figure, panels


@subject
def plant_fit() -> Any:
    return identify_plant(read_records(ROOT / "data/frequency-response.h5"))


@case
def plant() -> Case:
    fit = plant_fit()
    figure = draw_plant(fit)
    (response,) = fit.responses
    table, used = response.measured.table, response.used
    f, measured = table.frequency, response.measured.response
    plain = LinearPlant(*(float(fit.estimates[name]) for name in ("A", "B", "T_d")))
    s = 2j * np.pi

    def Z(x: Any) -> Any:  # eq. (1), with the hold in front of it apart from its delay
        G = plain.B * np.exp(-s * x * plain.T_d) / (s * x * (s * x + plain.A))
        return G * np.sinc(x / response.hold) if response.hold else G

    def gain(x: Any, y: Any) -> bool:
        return len(x) == 400 and bool(np.abs(y - decibel(Z(x))).max() < 0.05)

    def phase(x: Any, y: Any) -> bool:
        return len(x) == 400 and bool(np.abs(np.angle(np.exp(1j * np.radians(y)) / Z(x), deg=True)).max() < 0.5)

    deviation = 1.96 * np.nan_to_num(table.deviation, posinf=0.0)

    def lag(x: Any, y: Any) -> bool:
        return near(x, f[used]) and near(np.cos(np.radians(y)), np.cos(np.angle(measured[used])))

    out = [curve(f[~used], decibel(measured)[~used])] if (~used).sum() > 1 else []
    out_phase = [lambda x, y: near(x, f[~used])] if (~used).sum() > 1 else []
    ratio = np.log(measured[used] / response.of(fit.solution, f[used]))
    top, middle, bottom = figure.axes
    for axes, unit in ((top, 20 / np.log(10)), (middle, 180 / np.pi)):
        bars = [np.ptp(bar[:, 1]) for group in axes.collections if hasattr(group, "get_segments")
                for bar in group.get_segments()]  # fmt: skip
        assert near(bars, 2 * unit * deviation[used])
    return figure, [
        Panel(top, [curve(f[used], decibel(measured[used])), *out, gain], _drawn_bands(top, gain)),
        Panel(middle, [lag, *out_phase, phase], _drawn_bands(middle, phase)),
        Panel(bottom, [curve(f[used], 100 * ratio.real), curve(f[used], np.degrees(ratio.imag))]),
    ]


def _drawn_bands(axes: Any, inside: Wanted) -> Any:
    """Return the band as it is drawn, once it is seen to lie around a curve, and to be narrow."""
    ((x, low, high),) = edges(axes)
    assert inside(x, (low + high) / 2)
    assert np.all(high > low)
    return [(lambda _: low, lambda _: high)]


@subject
def planned() -> Any:
    axis, limits = machine().axis("x"), Limits(0.3, 0.1, 5.0)
    chosen = choose(axis, limits)
    return Plan(axis, limits, chosen, [1.0] * len(chosen), {"F_c": Expected(105.0, 1.05, "N", (0.9, 1.3))})


@case
def plan() -> Case:
    figure = draw_plan(planned())
    speeds = np.array(planned().planned[0].settings["speeds"])
    left, middle, right = figure.axes

    def level(v: Any) -> Any:
        return 105 + 60 * np.exp(-1e-3 * v / 1e-3) + 40 * 1e-3 * v

    known = function(level)
    virgin = function(lambda z: planned().axis.friction.virgin_curve(1e-6 * np.asarray(z)))
    swing = 2e3 * planned().planned[2].settings["swing"]
    speeds_drawn = [curve(1e3 * speeds, level(1e3 * speeds)), known]
    return figure, [
        Panel(left, speeds_drawn, bars=(swing,)), Panel(middle, [virgin]), Panel(right, [], bars=(1.0,))
    ]  # fmt: skip


@case
def motion() -> Case:
    t = np.arange(4000) / 1000.0
    w = 2 * np.pi * 0.5
    rng = np.random.default_rng(3)
    force = (
        -61 * 0.05 * w**2 * np.sin(w * t) + 53 * np.sign(np.cos(w * t)) + 60 * np.cos(w * t) * w + rng.normal(size=4000)
    )
    fit = identify_motion([Log(t, position=0.05 * np.sin(w * t), force=force)])
    figure = draw_motion(fit)
    top, bottom = figure.axes
    measured, fitted = curve(fit.time, fit.measured), curve(fit.time, fit.fitted)
    assert np.abs(fit.measured - fit.fitted).std() < 0.2 * fit.measured.std()
    return figure, [Panel(top, [measured, fitted]), Panel(bottom, [curve(fit.time, fit.measured - fit.fitted)])]


@case
def record() -> Case:
    t = np.arange(3000) / 1000.0
    z = 1e-3 * np.abs(t % 2 - 1)
    log = Log(
        t, position=z, velocity=-1e-3 * np.sign(1 - t % 2), force=np.where(t % 2 < 1, -3.0, 3.0) + 0.1 * np.sin(90 * t)
    )
    found = inspect(log)
    figure = draw_record([log], [found])
    position, velocity, force, relation = figure.findobj(lambda artist: hasattr(artist, "get_xlabel"))
    reversals = np.array(found.reversals)
    v = np.array([s.velocity for s in found.stretches]) * 1e3
    F = [np.median(log.force[s.start : s.stop]) for s in found.stretches]
    marks = [curve(t[reversals], z[reversals] * 1e3)] if len(reversals) > 1 else []
    return figure, [
        Panel(position, [curve(t, z * 1e3), *marks], bars=_spans(position)),
        Panel(velocity, [curve(t, log.velocity * 1e3)], bars=_spans(velocity)),
        Panel(force, [curve(t, log.force)], bars=_spans(force)),
        Panel(relation, [curve(log.velocity * 1e3, log.force), curve(v, F)]),
    ]


def _spans(axes: Any) -> list[float]:
    return [patch.get_width() for patch in axes.patches]


@cache
def lugre_records() -> Any:
    return prepared(logs_of(models()["lugre"].typical(), 11, motions=("small", "large")))


@subject
def replay_fit() -> Any:
    return identify_by_replay("lugre", lugre_records(), start=models()["lugre"].typical())


@case
def replay() -> Case:
    fit = replay_fit()
    figure = draw_replay(fit)
    panels = []
    for n, (record, own) in enumerate(zip(fit.records, fit.own, strict=True)):
        again = fit.model.replay(record.motion.time, record.motion.position, record.motion.velocity) + own[0]
        used, z = record.used, record.motion.position * 1e6
        rest = np.where(used, record.force - again, np.nan)
        panels.append(Panel(figure.axes[2 * n], [curve(z[used], record.force[used]), curve(z[used], again[used])]))
        panels.append(Panel(figure.axes[2 * n + 1], [curve(record.motion.time, rest)]))
    return figure, panels


@case
def comparison() -> Case:
    found = compare_models(["static", "dahl"], lugre_records(), split_by_folds(lugre_records(), 2))
    figure = draw_comparison(found)
    bars, loops = figure.axes
    lengths = [score.rms for score in found.scores] + [score.rms_near for score in found.scores]
    record, z = found.records[0], found.records[0].motion.position * 1e6

    def pieces(y: Any) -> Wanted:
        def right(drawn_x: Any, drawn_y: Any) -> bool:
            n, middle = len(drawn_x), drawn_x - drawn_x[0]
            starts = range(len(z) - n + 1)
            return any(near(middle, z[s : s + n] - z[s]) and near(drawn_y, y[s : s + n]) for s in starts)

        return right

    curves = [pieces(record.force), *(pieces(record.force - score.residual[0]) for score in found.scores)]
    return figure, [Panel(bars, bars=lengths), Panel(loops, curves)]


@case
def validation() -> Case:
    axis = Plant(A=2.0, B=0.4, T_d=0.5e-3, K_f=35.0)
    friction = StaticMap(20.0, 25.0, 5e-3, 1.0, 5.0)
    cascade = Cascade(K_v=160.0, K_p=240.0, K_i=0.0, velocity_filter=500.0, sampling=1000.0)
    time = np.arange(3000) * 1e-3
    asked = 0.05 * (1 - np.cos(np.pi * time))
    log = Log(time=time, position=asked, reference=asked, input=np.zeros_like(time))
    made = validate_closed_loop(log, axis, cascade, StaticMap(15.0, 18.0, 5e-3)).signals
    log = replace(log, position=made["position"].simulated, input=made["force"].simulated / axis.K_f)
    found = validate_closed_loop(log, axis, cascade, friction)
    figure = draw_validation([found])
    first, stop = found.worst
    t = time[first:stop]
    panels = []
    for n, (name, factor) in enumerate((("position", 1e3), ("velocity", 1e3), ("force", 1.0))):
        signal = found.signals[name]
        measured, simulated = signal.measured[first:stop], signal.simulated[first:stop]
        unit = figure.axes[2 * n].get_ylabel().split("[")[1][:-1]
        factor = {"mm": 1e3, "mm/s": 1e3, "m/s": 1.0, "N": 1.0, "µm": 1e6}.get(unit, factor)
        size = np.abs(measured).max() * factor
        assert 1.0 <= size < 1000.0 or size == 0.0
        panels.append(Panel(figure.axes[2 * n], [curve(t, factor * y) for y in (measured, simulated)]))
        unit = figure.axes[2 * n + 1].get_ylabel().split("[")[1][:-1]
        factor = {"m": 1e3, "µ": 1e6, "n": 1e9}.get(unit[0], 1.0) if unit not in {"m", "m/s"} else 1.0
        panels.append(Panel(figure.axes[2 * n + 1], [curve(t, factor * (measured - simulated))]))
    return figure, panels


def schemed() -> list[SchemeContour]:
    return [SchemeContour(run.scheme, run.circularity.angle, run.circularity.error) for run in circles()]


@case
def overlay() -> Case:
    found, earlier = schemed(), [replace(one, error=0.5 * one.error) for one in schemed()]
    figure = overlay_figure(found, 5e-3, 1, 100.0, earlier)
    return figure, [Panel(figure.axes[0], [curve(one.place, one.error * 1e6) for one in (*earlier, *found)])]


@case
def after_reversal() -> Case:
    figure = after_reversal_figure(schemed(), 5e-3, 50e-3, 1, np.pi / 2)
    wanted = []
    for one in schemed():
        off = (np.degrees(one.place) - 90 + 180) % 360 - 180
        near_ = (off >= -5) & (off <= 25)
        order = np.argsort(off[near_])
        time = np.radians(off[near_][order]) * 5e-3 / 50e-3
        wanted.append(curve(time * 1e3, (one.error[near_][order] - np.median(one.error)) * 1e6))
    return figure, [Panel(figure.axes[0], wanted)]


@case
def along() -> Case:
    figure = along_figure(schemed())
    return figure, [Panel(figure.axes[0], [curve(one.place * 1e3, one.error * 1e6) for one in schemed()])]


@case
def drift() -> Case:
    figure = draw_drift(["F_c", "F_s"], np.array([[-9.0, -10.5, -7.5], [1.0, -2.0, 4.0]]), [True, False])
    (axes,) = figure.axes
    drawn = [tuple(np.ravel(line.get_xdata())) for line in axes.get_lines()[1:]]
    assert drawn == [(-10.5, -7.5), (-9.0,), (-2.0, 4.0), (1.0,)]
    axes.plot([-1.0, 1.0], [0.0, 1.0])  # all else in it is level, and held above
    return figure, [Panel(axes, [curve([-1.0, 1.0], [0.0, 1.0])])]


def band_of(f: Callable[[Any], Any], first: float, last: float) -> Band:
    x = np.geomspace(first, last, 100)
    return Band(x, f(x), f(x) - 2.0, f(x) + 2.0)


def map_alone(logarithmic: bool) -> Case:
    friction = StaticMap(105.0, 165.0, 1e-3).steady_state
    size = band_of(friction, 1e-5, 1e-2)
    found = FrictionMap("linear", [MapBranches(1, [size], size)], *np.array([[1e-3, 5e-3], [130.0, 110.0], [1.0, 2.0]]))
    figure = map_figure(found, logarithmic=logarithmic)
    points = [curve([1.0, 5.0], np.array([130.0, 110.0]) + k * np.array([1.0, 2.0])) for k in (-1, 0, 1)]
    shown = lambda x: friction(x * 1e-3)  # noqa: E731
    limits = (lambda x: shown(x) - 2, lambda x: shown(x) + 2)
    return figure, [Panel(figure.axes[0], [*points, function(shown)], [limits])]


@case
def map_over_velocity() -> Case:
    return map_alone(False)


@case
def map_over_speed() -> Case:
    return map_alone(True)


@case
def virgin_alone() -> Case:
    knots = np.array([1e-6, 1e-5])
    force = lambda x: np.minimum(x[:, None], knots) @ np.array([5e7, 5e6])  # noqa: E731
    figure = virgin_figure(Virgin("linear", 100.0, band_of(force, 1e-7, 1.9e-5), knots, force(knots)), logarithmic=True)
    shown = lambda x: force(x * 1e-6)  # noqa: E731
    limits = (lambda x: shown(x) - 2, lambda x: shown(x) + 2)
    return figure, [Panel(figure.axes[0], [function(shown), curve(knots * 1e6, force(knots))], [limits])]


@case
def cycles_alone() -> Case:
    t = np.linspace(0, 2 * np.pi, 200)
    one = ReplayedCycle("slow", 1e-5 * np.sin(t), 50 * np.sin(t + 0.3), 49 * np.sin(t + 0.31))
    figure = cycles_figure([one], "linear")
    z = one.position * 1e6
    return figure, [Panel(figure.axes[0], [curve(z, one.measured), curve(z, one.model)])]


@case
def motion_alone() -> Case:
    t = np.linspace(0, 1, 200)
    measured, fitted = 5 * np.sin(9 * t), 5 * np.sin(9 * t + 0.1)
    figure = motion_figure(t, measured, fitted, "force [N]")
    top, bottom = figure.axes
    return figure, [Panel(top, [curve(t, measured), curve(t, fitted)]), Panel(bottom, [curve(t, measured - fitted)])]


@case
def reach() -> Case:
    q, robust = QFilter("binomial2", 60.0), QFilter("binomial2", 372.0)
    figure = reach_figure(QReach(q, robust, None, [(300.0, 1.2)], None, 2000.0))
    (mark,) = [line for line in figure.axes[0].get_lines() if line.get_marker() == "o"]
    assert near(np.ravel(mark.get_data()), [300.0, -20 * np.log10(1.2)])
    curves = [function(lambda f, one=one: decibel(one.response(f))) for one in (q, robust)]
    return figure, [Panel(figure.axes[0], curves)]
