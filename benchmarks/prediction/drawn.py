"""Machines that nobody has looked at: the base machine with two or three flaws, each as severe as is drawn."""

from __future__ import annotations

from dataclasses import replace
from math import pi
from typing import TYPE_CHECKING, Any

import numpy as np

from benchmarks.reality.session import MACHINES, machine_with
from fric.documents.machine_files import read_spreads
from fric.simulate.reality.flaws import (
    Clock,
    Cogging,
    Direction,
    Drift,
    Dwell,
    Excitation,
    ForceChannel,
    Interpolation,
    NoiseColour,
    Reality,
    SecondMass,
    Wave,
)
from fric.simulate.spread import draw_machine

if TYPE_CHECKING:
    from fric.simulate.machine import Machine

MILDEST, WORST = 0.4, 1.6
"""Of the severity of the machines of configs/reality."""


def _flaws(rng: np.random.Generator) -> dict[str, dict[str, Any]]:
    """Return by the name of its machine in configs/reality each flaw as fields of `Reality`, as severe as is drawn."""

    def size(value: float) -> float:
        return value * float(np.exp(rng.uniform(np.log(MILDEST), np.log(WORST))))

    def either(value: float) -> float:
        return size(value) * float(rng.choice([-1.0, 1.0]))

    def phase() -> float:
        return float(rng.uniform(0.0, 2 * pi))

    return {
        "lag": {"force": ForceChannel(lag=size(0.5e-3))},
        "filter": {"force": ForceChannel(filter=300.0 / size(1.0))},
        "step": {"force": ForceChannel(step=size(4.0))},
        "jitter": {"clock": Clock(jitter=size(80e-6), stamped=bool(rng.integers(2)))},
        "lost": {"clock": Clock(lost=size(0.01), stamped=bool(rng.integers(2)))},
        "skew": {"clock": Clock(position=size(0.4e-3))},
        "coloured-noise": {"noise": NoiseColour(size(2.0), size(2.0))},
        "interpolation": {"encoder": Interpolation(size(0.15e-6), 20e-6, phase())},
        "cogging": {"cogging": (Cogging(size(6.0), size(24e-3), phase()), Cogging(size(2.0), size(4e-3), phase()))},
        "waves": {"waves": (Wave(size(0.06), size(3.2e-3), phase()), Wave(size(0.04), size(41e-3), phase()))},
        "direction": {"direction": Direction(1 + either(0.15), 1 + either(0.3))},
        "gravity": {"gravity": either(60.0)},
        "dwell": {"dwell": Dwell(size(0.06), 0.1, 10e-6)},
        "drift": {"friction": Drift(either(0.15), size(60.0))},
        "force-constant": {"force_constant": Drift(either(0.08), size(60.0))},
        "sparse-lines": {"multisine": Excitation(10, 2.0, 300.0, 0.0, size(15e-3))},
        "second-mass": {"second": SecondMass(
            size(30.0), size(100e6), size(5000.0), float(rng.choice([0.0, size(3e-6)])),
            str(rng.choice(["motor", "table"])),
        )},
    }  # fmt: skip


def drawn_machine(seed: int, index: int) -> tuple[str, Machine]:
    """Return machine number ``index`` of a seed, and its name: its flaws are on x, as its friction is drawn.

    Parameters
    ----------
    seed
        Of all that is drawn.
    index
        Which of the machines, from 0.
    """
    rng = np.random.default_rng([seed, index])
    known = _flaws(rng)
    chosen = sorted(rng.choice(sorted(known), size=int(rng.integers(2, 4)), replace=False))
    base = machine_with("base")
    spreads = read_spreads(MACHINES.parent / "spread-shape.yaml")
    friction = draw_machine(base, index, seed=seed, spreads=spreads)[0].axis("x").friction
    fields: dict[str, Any] = {}
    for name in chosen:
        for key, flaw in known[name].items():
            fields[key] = _together(fields[key], flaw) if key in fields else flaw
    second = fields.pop("second", None)
    x = replace(base.axis("x"), friction=friction, reality=Reality(**fields), second_mass=second)
    return f"drawn-{seed}-{index}: {' + '.join(chosen)}", replace(base, axes={**base.axes, "x": x})


def _together(one: Any, other: Any) -> Any:
    """Return two flaws of one channel as one: what the second changes, changed in the first."""
    plain = type(other)()
    changed = {key: value for key, value in vars(other).items() if value != getattr(plain, key)}
    return replace(one, **changed)
