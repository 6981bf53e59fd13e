"""`fric tune` from two circles, scheme (f) at 100 and 10 mm/s, on many machines that differ from what is believed.

Machines of `configs/spread.yaml`, of `configs/spread-shape.yaml` (both of seed 0), and those of `configs/reality` as
they are and with friction and plant drawn. Glitches in µm: median / 95th percentile / largest.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping
from dataclasses import replace
from itertools import permutations
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks._machines import run_on_machines, spread_of
from fric.control.scheme import PAPER_SCHEMES
from fric.documents.machine_files import read_machine
from fric.documents.spread import read_spreads
from fric.errors import FricError
from fric.estimate import Estimate
from fric.identify.circle.belief import parameters
from fric.identify.circle.measured import AxisTrace, MeasuredCircle
from fric.identify.circle.tune import Tuned, tune, with_belief
from fric.identify.circle.tune_loop import holding
from fric.identify.circle.tuned import TunedAxis
from fric.simulate.circle import Circle, CircleRun, run_circle
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
MACHINES = 4
"""Machines of each kind where nothing else is asked for; what is written down takes 200."""


def tuned(source: str, spread: str, seed: int, index: int) -> dict[str, Any]:
    """Tune one machine; index -1 of a reality machine is that machine as it is."""
    machine = read_machine(CONFIGS / source)
    if index >= 0:
        machine = draw_machine(machine, index, seed=seed, spreads=read_spreads(CONFIGS / spread))[0]
    flawed = source.startswith("reality")
    seen = [_run(machine, "f", test) for test in (FAST, SLOW)]
    before = _four(machine)
    try:
        found = tune(machine, [recorded(machine, run, index + 1 if flawed else None) for run in seen])
    except FricError as error:
        return {"before": before, "error": str(error)}
    new = found.machine
    held = replace(new, axes={**new.axes, **{name: holding(one).axis for name, one in found.axes.items()}})
    known = {name: with_belief(axis, axis.friction, axis.plant) for name, axis in machine.axes.items()}
    unseen = {} if flawed else {name: _glitch(_run(new, "f", test)) for name, test in UNSEEN.items()}
    return {
        "before": before, "after": _four(new), "unseen": unseen, "loop": _four(held),
        "known": {} if flawed else _four(replace(machine, axes=known)),
        "errors": {} if flawed else _errors(machine, found),
        "predicted": {f"{one.scheme}{one.feed * 1e3:g}": [one.glitch, *one.ci95] for one in found.predicted},
        "told": sorted({f"{warning.code}:{warning.severity}" for warning in found.warnings}),
        "improves": found.improves, "full": [one.full for one in found.axes.values()],
    }  # fmt: skip


def _four(machine: Machine) -> dict[str, float]:
    return {
        f"{scheme}{test.feed * 1e3:g}": _glitch(_run(machine, scheme, test)) for test in (FAST, SLOW) for scheme in "cf"
    }


def _run(machine: Machine, scheme: str, test: Circle) -> CircleRun:
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


def _errors(machine: Machine, found: Tuned) -> dict[str, float]:
    """Return by axis and parameter how far it is from the truth, in half-widths of its interval on that side.

    Blocks go by no number: those that slip at about one displacement may be found in another order.
    """
    errors = {}
    for name, one in found.axes.items():
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
            errors[label] = float((value - right) / (value - low if value > right else high - value))
    return errors


def truth(axis: Axis, one: TunedAxis) -> dict[str, Any]:
    """Return what a circle can tell of an axis: forces on the believed K_f, A with what sigma is not believed."""
    scale = one.nominal.K_f / axis.plant.K_f
    true = dict(parameters(axis.friction))  # type: ignore[arg-type]
    forces = {key: np.multiply(true[key], scale) for key in ("F_c", "F_s", "k", "C")}
    unbelieved = scale * float(np.ravel(true["sigma"])[0]) - float(one.friction.static.sigma)  # type: ignore[attr-defined]
    A = axis.plant.A + unbelieved * axis.plant.B / one.nominal.K_f
    return true | forces | {"A": A, "B": axis.plant.B, "T_d": axis.plant.T_d, "offset": axis.load * scale}


def run(machines: int = MACHINES, seed: int = 0) -> list[tuple[str, str, str]]:
    """Tune machines of each kind."""
    rows = []
    for spread, limits in (("spread.yaml", ("0.5", "1.1")), ("spread-shape.yaml", ("1.1", "2"))):
        found = run_on_machines(tuned, [("xy-table.yaml", spread, seed, n) for n in range(machines)])
        rows += _rows(spread.removesuffix(".yaml"), found, limits)
    flaws = sorted(f"reality/{path.name}" for path in (CONFIGS / "reality").glob("*.yaml"))
    drawn = range(-1, min(2, machines // 20))
    tasks = [(source, "spread.yaml", seed, n) for source in flaws for n in drawn]
    return rows + _flawed(tasks, run_on_machines(tuned, tasks))


def _rows(kind: str, found: list[dict[str, Any]], limits: tuple[str, str]) -> list[tuple[str, str, str]]:
    label = f"{kind}, {len(found)} machines"
    rows = []
    for feed, limit in (("100", limits[0]), ("10", limits[1])):
        for scheme in "cf":
            for when, told, target in (
                ("before", "before", ""), ("known", "all known, with lead", ""), ("after", "tuned", f"p95 ≤ {limit}"),
                ("loop", "tuned with --loop", f"p95 ≤ {limit}"),
            ):  # fmt: skip
                glitches = [one[when][f"{scheme}{feed}"] for one in found]
                rows.append((f"{label}: ({scheme}) at {feed} mm/s, {told}", spread_of(glitches), target))
    for name in UNSEEN:
        rows.append((f"{label}: (f) at {name}", spread_of([one["unseen"][name] for one in found]), "p95 ≤ 0.6"))
    anew = sum(one["after"] != one["loop"] for one in found)
    rows.append((f"{label}: with a loop that is designed anew", str(anew), ""))
    worse = {
        key: sum(one["after"][key] > one["before"][key] for one in found) for key in ("c100", "f100", "c10", "f10")
    }
    rows.append((f"{label}: worse than before", ", ".join(f"{k} {n}" for k, n in worse.items()), "f100 0, f10 0"))
    refused = sum(not one["improves"] for one in found)
    rows.append((f"{label}: refused", str(refused), ""))
    held: dict[str, list[bool]] = defaultdict(list)
    for one in found:
        for key, error in one["errors"].items():
            held[key.split()[1]].append(abs(error) <= 1)
    pooled = [inside for values in held.values() for inside in values]
    rows.append((f"{label}: all intervals hold the truth", f"{np.mean(pooled):.1%}", "90 to 98 %"))
    rows += [
        (f"{label}: {key} in its interval", f"{np.mean(inside):.1%} of {len(inside)}", "90 to 98 %")
        for key, inside in held.items()
    ]
    ahead = [low <= one["after"][key] <= high for one in found for key, (_, low, high) in one["predicted"].items()]
    rows.append(
        (f"{label}: next circle within its prediction", f"{np.mean(ahead):.1%} of {len(ahead)}", "at least 95 %")
    )
    return rows


def _flawed(tasks: list[tuple[str, str, int, int]], found: list[dict[str, Any]]) -> list[tuple[str, str, str]]:
    """Return the rows of the machines with flaws: before and after in (f), each session."""
    rows = []
    for (source, _, _, index), one in zip(tasks, found, strict=True):
        what = f"{source.removesuffix('.yaml')}, {'as it is' if index < 0 else f'drawn {index}'}: (f) at 100, 10 mm/s"
        if "error" in one:
            rows.append((what, f"error: {one['error'].splitlines()[0]}", "told"))
            continue
        pairs = [(one["before"][key], one["after"][key]) for key in ("f100", "f10")]
        told = [text.split(":")[0] for text in one["told"] if not text.endswith(":note")]
        glitches = ", ".join(f"{a * 1e6:.2f} → {b * 1e6:.2f}" for a, b in pairs)
        rows.append((what, f"{glitches}; {', '.join(told) or 'nothing told'}", "not worse, or told"))
    return rows
