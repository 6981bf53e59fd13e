"""Half-widths that a plan from an identified friction expects, against those achieved: geometric means of nine runs."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from fric.documents.machine_files import read_machine
from fric.planning.choose import DRAWS, choose, expected, prior_axis, typical
from fric.results.base import silent
from fric.simulate.experiment import Limits, runs_of
from fric.simulate.spread import draw_machine
from tests.planning.test_expected import SUBJECTS, achieved, anywhere, identified


def run() -> Iterator[tuple[str, str, str]]:
    for name, axis, draw in SUBJECTS:
        machine = read_machine(Path(name))
        if draw is not None:
            machine, _ = draw_machine(machine, draw, seed=0)
        truth, limits = machine.axis(axis), Limits(0.3, 0.1, 5.0)
        trials = anywhere(truth, [trial for one in choose(truth, limits) for trial in one.trials(truth)], 77)
        logs = [trial.log(truth, made, 77) for trial, made in runs_of(truth, trials)]
        plant, *_, friction = identified(logs)
        prior, _ = prior_axis(machine, axis, friction, plant)
        planned = choose(prior, limits)
        found = expected(prior, planned, silent, DRAWS, friction, plant)
        got = achieved(truth, planned, found.blocks, range(201, 201 + DRAWS))
        ratios = {
            key: np.array([one[key] for one in got]) / expectation.half_width
            for key, expectation in found.parameters.items()
        }
        middle = {key: typical(one) for key, one in ratios.items()}
        worst = max(middle, key=lambda key: abs(np.log(middle[key])))
        inside = np.mean([
            (one.between[0] <= run[key]) & (run[key] <= one.between[1])
            for key, one in found.parameters.items() for run in got
        ])  # fmt: skip
        about = f"{name} {axis}" + (f" drawn {draw}" if draw is not None else "")
        yield (
            f"{about}: mean achieved over expected, the worst of {len(middle)}: {worst}",
            f"{middle[worst]:.2f}",
            "1.5",
        )
        single = np.mean([(one < 1.5) & (one > 1 / 1.5) for one in ratios.values()])
        yield f"{about}: single runs within 1.5", f"{single:.0%}", ""
        yield f"{about}: single runs in the range shown", f"{inside:.0%}", "80 %"
