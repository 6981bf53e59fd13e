"""One machine that is tuned from two circles, and the rows of many."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping
from dataclasses import replace
from itertools import permutations
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks._machines import Ran, spread_of
from fric.circles.measured import AxisTrace, MeasuredCircle
from fric.circles.tune import holds, tune, with_belief
from fric.circles.tune_fit import TunedAxis, parameters
from fric.control.scheme import PAPER_SCHEMES
from fric.documents.machine_files import read_machine, read_spreads
from fric.errors import FricError
from fric.estimate import Estimate
from fric.friction.directed import Directed
from fric.simulate.contour_run import Circle, CircleRun, run_circle
from fric.simulate.machine import Axis, Machine
from fric.simulate.reality.trace import logged
from fric.simulate.spread import draw_machine

CONFIGS = Path(__file__).parents[1] / "configs"
FAST, SLOW = Circle(feed=0.1), Circle(feed=0.01)
ACCURACY = 5e-9
UNSEEN = {
    "30 mm/s": Circle(feed=0.03),
    "50 mm/s": Circle(feed=0.05),
    "100 mm/s on 20 mm": Circle(radius=0.02),
    "200 mm/s on 100 mm": Circle(radius=0.1, feed=0.2),
    "100 mm/s clockwise": Circle(direction=-1),
}
BESIDE = 0.3 * 0.25e-6
"""By how much the radius is larger on a circle whose reversals lie elsewhere between two counts of the encoder [m]."""
MACHINES = 4
"""Machines of each kind where nothing else is asked for; what is written down takes 200."""


def tuned(source: str, spread: str, seed: int, index: int) -> dict[str, Any]:
    """Tune one machine; index -1 of a reality machine is that machine as it is."""
    machine = read_machine(CONFIGS / source)
    if index >= 0:
        machine = draw_machine(machine, index, seed=seed, spreads=read_spreads(CONFIGS / spread))[0]
    flawed = source.startswith("reality")
    seen = [driven(machine, "f", test) for test in (FAST, SLOW)]
    before = _four(machine)
    tests = [recorded(machine, run, index + 1 if flawed else None) for run in seen]
    try:
        found = tune(machine, tests)
        held = found if all(map(holds, found.axes.values())) else tune(machine, tests, loop=True)
    except FricError as error:
        return {"before": before, "error": str(error)}
    result = {
        "before": before, "after": _four(found.machine), "loop": _four(held.machine),
        "anew": any(one.loop for one in held.axes.values()),
        "told": sorted({f"{warning.code}:{warning.severity}" for warning in found.warnings}),
        "improves": found.improves,
    }  # fmt: skip
    if flawed:
        return result
    known = {name: with_belief(axis, axis.friction, axis.plant) for name, axis in machine.axes.items()}
    exact, beside = replace(machine, axes=known), replace(SLOW, radius=SLOW.radius + BESIDE)
    return result | {
        "known": _four(exact), "errors": errors_of(machine, found.axes),
        "unseen": {name: _glitch(driven(found.machine, "f", test)) for name, test in UNSEEN.items()},
        "beside": [_glitch(driven(one, "f", beside)) for one in (exact, found.machine, held.machine)],
        "predicted": {f"{one.scheme}{one.feed * 1e3:g}": [one.glitch, *one.ci95] for one in found.predicted},
        "full": [one.full for one in found.axes.values()],
    }  # fmt: skip


def _four(machine: Machine) -> dict[str, float]:
    return {
        f"{scheme}{test.feed * 1e3:g}": _glitch(driven(machine, scheme, test))
        for test in (FAST, SLOW)
        for scheme in "cf"
    }


def driven(machine: Machine, scheme: str, test: Circle) -> CircleRun:
    return run_circle(machine, PAPER_SCHEMES[scheme], test, accuracy=ACCURACY)


def _glitch(run: CircleRun) -> float:
    return float(run.circularity.glitch)


def recorded(machine: Machine, run: CircleRun, seed: int | None) -> MeasuredCircle:
    """Return a circle as it is recorded: as the controller has it, or with a seed as a drive's trace keeps it."""
    axes = {}
    for name, trace in run.traces.items():
        if seed is None:
            axes[name] = AxisTrace(trace.time, trace.measured, trace.reference, trace.input)
            continue
        log = logged(machine.axes[name], trace, (0, len(trace.time)), len(trace.time), "circle", "motion", seed)
        axes[name] = AxisTrace(log.time, log.position, log.reference, log.input)
    test = run.circle
    return MeasuredCircle(test.radius, test.feed, test.direction, axes, name=run.scheme.name)


def errors_of(machine: Machine, axes: Mapping[str, TunedAxis]) -> dict[str, float]:
    """Return by axis and parameter how far it is from the truth, in half-widths of its interval on that side.

    Blocks go by no number: those that slip at about one displacement may be found in another order.
    """
    errors = {}
    for name, one in axes.items():
        if one.estimates is None:
            continue
        true = truth(machine.axes[name], one)
        blocks = []
        for order in permutations(range(len(true["alpha"]))):
            own = true | {key: np.asarray(true[key])[list(order)] for key in ("alpha", "k")}
            blocks.append(_of_estimates({**one.estimates.static, **one.estimates.gms, **one.estimates.plant}, own))
        best = min(blocks, key=lambda errors: sum(min(error**2, 9.0) for error in errors.values()))
        errors |= {f"{name} {key}": error for key, error in best.items()}
    return errors


def _of_estimates(estimates: Mapping[str, Estimate], true: Mapping[str, Any]) -> dict[str, float]:
    errors = {}
    for key, estimate in estimates.items():
        if estimate.ci95 is None or key not in true:
            continue
        values = zip(np.ravel(true[key]), np.ravel(estimate.value), np.reshape(estimate.ci95, (-1, 2)), strict=True)
        for n, (right, value, (low, high)) in enumerate(values, start=1):
            label = f"{key}_{n}" if isinstance(estimate.value, tuple) else key
            side = value - low if value > right else high - value  # an interval may end at its value
            errors[label] = float((value - right) / side) if side > 0 else float(np.copysign(np.inf, value - right))
    return errors


def truth(axis: Axis, one: TunedAxis) -> dict[str, Any]:
    """Return what a circle can tell of an axis: forces on the believed K_f, A with what sigma is not believed."""
    scale = one.nominal.K_f / axis.plant.K_f
    true = dict(parameters(axis.friction))  # type: ignore[arg-type]
    forces = {key: np.multiply(true[key], scale) for key in ("F_c", "F_s", "k", "C")}
    believed = one.friction.model if isinstance(one.friction, Directed) else one.friction
    unbelieved = scale * float(np.ravel(true["sigma"])[0]) - float(believed.static.sigma)  # type: ignore[attr-defined]
    A = axis.plant.A + unbelieved * axis.plant.B / one.nominal.K_f
    return true | forces | {"A": A, "B": axis.plant.B, "T_d": axis.plant.T_d, "offset": axis.load * scale}


def rows(ran: Ran, limits: tuple[str, str]) -> list[tuple[str, str, str]]:
    """Return what tuning leaves of machines, with the limits at 100 and 10 mm/s, and how many intervals hold."""
    found, rows = ran.found, [ran.row()]
    if not found:
        return rows
    for feed, limit in (("100", limits[0]), ("10", limits[1])):
        for scheme in "cf":
            for when, told, target in (
                ("before", "before", ""), ("known", "all known, with lead", ""), ("after", "tuned", f"p95 ≤ {limit}"),
                ("loop", "tuned with `--loop`", f"p95 ≤ {limit}"),
            ):  # fmt: skip
                glitches = [one[when][f"{scheme}{feed}"] for one in found]
                rows.append((f"({scheme}) at {feed} mm/s, {told}", spread_of(glitches), target))
    for n, when in enumerate(("all known", "tuned", "tuned with `--loop`")):
        rows.append((f"(f) at 10 mm/s, {when}, 0.3 counts larger", spread_of([one["beside"][n] for one in found]), ""))
    rows.append(("with a loop that was designed anew", str(sum(one["anew"] for one in found)), ""))
    for name in UNSEEN:
        rows.append((f"(f) at {name}", spread_of([one["unseen"][name] for one in found]), "p95 ≤ 0.6"))
    for what, when in (("worse than before", "after"), ("worse than before, with `--loop`", "loop")):
        worse = {key: sum(one[when][key] > one["before"][key] for one in found) for key in found[0]["before"]}
        rows.append((what, ", ".join(f"{key} {number}" for key, number in worse.items()), "0"))
    rows.append(("refused", str(sum(not one["improves"] for one in found)), ""))
    taken = [one for one in found if one["improves"]]
    ahead = [low <= one["after"][key] <= high for one in taken for key, (_, low, high) in one["predicted"].items()]
    rows.append(("next circle within its prediction", f"{np.mean(ahead):.1%} of {len(ahead)}", "at least 95 %"))
    held: dict[str, list[bool]] = defaultdict(list)
    for one in found:
        for key, error in one["errors"].items():
            held[key.split()[1]].append(abs(error) <= 1)
    pooled = [inside for own in held.values() for inside in own]
    rows.append(("intervals that hold the truth: all", share(pooled), "90 to 98 %"))
    return rows + [(f"… {key}", share(own), "90 to 98 %") for key, own in held.items()]


def share(inside: list[bool]) -> str:
    return f"{np.mean(inside):.1%} of {len(inside)}"
