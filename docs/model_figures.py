"""The figures of docs/models.md: `python docs/model_figures.py` draws them into docs/figures.

The first shows a minor loop on a branch, the second a mass under a load that vibrates below break-away, the third what
each model makes of the loops of the virtual rig.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from fric.figures.record import draw_comparison
from fric.figures.style import CYCLE, GREY, new_figure, save_figure
from fric.friction import FrictionModel
from fric.friction.dahl import Dahl
from fric.friction.gms import GMS
from fric.friction.leuven import Leuven
from fric.friction.lugre import LuGre
from fric.friction.maxwell_slip import MaxwellSlip
from fric.friction.stribeck import StaticMap
from fric.identify.replay.compare import compare_models, split_by_cycles
from fric.io.hdf5 import read_logs
from fric.records.prepared import prepared

ROOT = Path(__file__).parents[1]
STATIC = StaticMap(F_c=105.0, F_s=165.0, v_s=1e-3, delta=1.0, sigma=40.0)
ALPHA, K = (0.5, 0.3, 0.2), (2e7, 2.5e6, 8e5)
MODELS: tuple[FrictionModel, ...] = (
    GMS(STATIC, ALPHA, K),
    MaxwellSlip(tuple(a * STATIC.F_s for a in ALPHA), K, STATIC.sigma),
    Leuven(STATIC, ALPHA, K, n=20.0),
    LuGre(STATIC, 1.2e7, 300.0),
    Dahl(STATIC.F_s, 1.2e7, sigma=STATIC.sigma),
)
MASS = 121.0


def minor_loop(model: FrictionModel) -> tuple[np.ndarray, np.ndarray, float]:
    """Return path [m], force [N] and by how much the loop 20 → 12 → 20 µm fails to close [N]."""
    step = 20e-9
    legs = [np.arange(1, 1001), np.arange(999, 599, -1), np.arange(601, 1501)]
    path = step * np.concatenate([[0], *legs])
    force = model.replay(1e6 * np.arange(path.size), path)
    return path, force, float(force[1000 + 400 + 400] - force[1000])


def creep(model: FrictionModel, cycles: int = 60, dt: float = 5e-5) -> tuple[np.ndarray, np.ndarray]:
    """Return time [s] and position [m] of a mass under a load of (0.5 ± 0.25)·F_s that vibrates at 5 Hz."""
    time = np.arange(0.0, cycles / 5.0, dt)
    load = STATIC.F_s * (0.5 + 0.25 * np.sin(2 * np.pi * 5.0 * time)) * np.minimum(time, 1.0)
    state, parameters, step = model.initial_state(), model.packed(), type(model).step
    position, z, v, friction = np.empty_like(time), 0.0, 0.0, 0.0
    for n in range(time.size):
        v += dt * (load[n] - friction) / MASS
        z += dt * v
        friction = step(dt * v, v, dt, state, parameters)
        position[n] = z
    return time, position


def draw_minor_loops() -> None:
    """Draw the minor loop of every model, with its gap."""
    with new_figure(7.2, 2.3) as figure:
        for axis, model, color in zip(figure.subplots(1, len(MODELS), sharey=True), MODELS, CYCLE, strict=False):
            path, force, gap = minor_loop(model)
            axis.plot(1e6 * path, force, color=color)
            closes = f"gap {abs(gap):.2g} N" if abs(gap) > 0.01 else "closed"  # to rounding
            axis.set(title=f"{model.name}\n{closes}", xlabel="position [µm]")
        figure.axes[0].set_ylabel("force [N]")
        save_figure(figure, ROOT / "docs/figures/models-minor-loops.png", force=True)


def draw_creep() -> None:
    """Draw the position of a mass on every model under a load that vibrates below break-away."""
    with new_figure(6.3, 3.2) as figure:
        axis = figure.subplots()
        dashes = ("-", (0, (6, 6)), (6, (6, 6)), "-", "--")  # the first three lie on each other
        for model, color, dash in zip(MODELS, CYCLE, dashes, strict=False):
            time, position = creep(model)
            axis.plot(time[::200], 1e6 * position[::200], color=color, lw=1.2, ls=dash, label=model.name)
            late = (time > 4.0) & (time <= 12.0)
            print(model.name, "creep", np.polyfit(time[late], position[late], 1)[0], "m/s")
        axis.axvline(1.0, color=GREY, lw=0.6)
        axis.annotate("full load", (1.0, 780), (4, 0), textcoords="offset points", color=GREY)
        axis.annotate("gms, maxwell_slip, leuven: no creep", (4.5, 40), color=GREY)
        axis.set(xlabel="time [s]", ylabel="position [µm]", title="load of (0.5 ± 0.25) F_s at 5 Hz, below break-away")
        axis.legend(loc="center left", bbox_to_anchor=(0.1, 0.6))
        save_figure(figure, ROOT / "docs/figures/models-creep.png", force=True)


def draw_rig() -> None:
    """Draw the comparison on the bundled loops of the virtual rig."""
    records = prepared(read_logs([ROOT / "data/presliding-sine.h5"]))
    names = ["static", "dahl", "lugre", "leuven", "maxwell_slip", "gms"]
    comparison = compare_models(names, records, split_by_cycles(records, 2))
    save_figure(draw_comparison(comparison), ROOT / "docs/figures/models-rig.png", force=True)


if __name__ == "__main__":
    draw_minor_loops()
    draw_creep()
    draw_rig()
