"""The figures of README.md, docs/tutorial.md, docs/schemes.md and docs/data-quality.md: `python docs/figures.py`.

Those of the README and the tutorial are what their own commands draw. Those on data quality are drawn from the logs
that the commands of that page make. Each control block has a figure of its own, beside a scheme without it.
"""

from __future__ import annotations

import shutil
import tempfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes

import fric
from docs import examples
from fric.documents.schemes import read_schemes
from fric.figures.circle import reversal_figure
from fric.figures.style import BLACK, BLUE, GREY, VERMILION, new_figure, save_figure
from fric.identify.static_map.points import stroke_points
from fric.io.hdf5 import read_logs
from fric.log import Log
from fric.simulate.contour_run import Circle, run_circle
from fric.simulate.experiment import experiment

FIGURES = Path(__file__).parent / "figures"
BESIDE = {"pulse": "a", "repetitive": "a", "adaptive": "f"} | dict.fromkeys(
    ("kalman-gms", "two-dof", "sliding", "scheduled"), "c"
)
"""A scheme with each control block, and the scheme that it is shown beside."""


def run_page(page: Path, folder: Path) -> None:
    """Run the commands of a page in a folder."""
    examples.write_files(page, folder)
    for command, _ in examples.examples(page):
        if examples.is_make(command):
            continue
        status, printed = examples.run(command, folder)
        if status:
            raise SystemExit(f"{page.name}: $ {command}\n{printed}")


BROWSERS = ("chromium", "chromium-browser", "google-chrome")


def readme(folder: Path) -> None:
    """Draw Table 2's circles, and the first screen of the page of the README's session; that needs a browser."""
    browser = next(filter(None, map(shutil.which, BROWSERS)), None)
    shot = f"--hide-scrollbars --force-device-scale-factor=1 --window-size=1200,722 --screenshot={FIGURES / 'page.png'}"
    for command in (
        f"fric simulate circle configs/xy-table.yaml --plot {FIGURES / 'table-2.png'} --force",
        "fric auto data -o found",
        f"{browser} --headless --no-sandbox --disable-gpu {shot} file://{folder}/found/report.html",
    ):
        status, printed = examples.run(command, folder)
        if status:
            raise SystemExit(printed)


def tutorial(folder: Path) -> None:
    """Copy what the tutorial's commands draw."""
    run_page(FIGURES.parent / "tutorial.md", folder)
    for drawn in folder.glob("*.png"):
        shutil.copy(drawn, FIGURES / f"tutorial-{drawn.name}")


def schemes(_: Path) -> None:
    """Draw a reversal with each control block, beside one without it."""
    table = fric.read_machine("xy-table")
    named = read_schemes(FIGURES.parents[1] / "configs/literature.yaml")
    runs = {name: run_circle(table, named[name], Circle()) for name in {*BESIDE, *BESIDE.values()}}
    for name, other in BESIDE.items():
        save_figure(reversal_figure([runs[other], runs[name]]), FIGURES / f"scheme-{name}.png", force=True)


def data_quality(folder: Path) -> None:
    """Draw a good log beside a bad one, for each way to be bad."""
    run_page(FIGURES.parent / "data-quality.md", folder)

    def logs(name: str) -> list[Log]:
        return read_logs(folder / name)

    good = read_logs(folder / "data/constant-velocity.h5")
    paper = logs("strokes.h5")
    axis = fric.read_machine(folder / "configs/xy-table.yaml").axis("x")
    loops = list(experiment(axis, "presliding-sine", samples=2500))
    (slowest,) = experiment(axis, "constant-velocity", speeds=[10e-6], samples=50_000)  # both at some 500 Hz
    (slow,) = experiment(axis, "constant-velocity", speeds=[80e-6], samples=6_600)
    _beside(
        "quality-speeds", "velocity [mm/s]", "force [N]",
        ("good: down to 10 µm/s", lambda axes: _map(axes, paper)),
        ("bad: 10 mm/s and more", lambda axes: _map(axes, logs("fast.h5"), xlim=axes.get_xlim())),
    )  # fmt: skip
    _beside(
        "quality-stick-slip", "time [s]", "force [N]",
        ("good: 80 µm/s", lambda axes: _force(axes, slow, 3.0, 4.0, mean=9)),
        ("bad: 10 µm/s", lambda axes: _force(axes, slowest, 20.0, 21.0, mean=9)),
    )  # fmt: skip
    _beside(
        "quality-short", "time [s]", "force [N]",
        ("good: a stroke that settles", lambda axes: _force(axes, logs("whole.h5")[0])),
        ("bad: cut off while it settles", lambda axes: _force(axes, logs("short.h5")[0])),
    )  # fmt: skip
    _beside(
        "quality-amplitude", "position [µm]", "force [N]",
        ("good: 15 µm and 450 µm", lambda axes: _loops(axes, loops, reach=40.0)),
        ("bad: 0.5 µm, two counts", lambda axes: _loops(axes, logs("tiny.h5"))),
    )  # fmt: skip
    _beside(
        "quality-encoder", "position [µm]", "force [N]",
        ("good: 15 µm by counts of 0.25 µm", lambda axes: _loops(axes, loops[:1])),
        ("bad: 15 µm by counts of 5 µm", lambda axes: _loops(axes, logs("coarse.h5")[:1])),
    )  # fmt: skip
    _beside(
        "quality-inertia", "position [µm]", "force [N]",
        ("good: 450 µm at 0.1 Hz", lambda axes: _loops(axes, loops[1:])),
        ("bad: 450 µm at 5 Hz", lambda axes: _loops(axes, logs("quick.h5"))),
    )  # fmt: skip
    _beside(
        "quality-clipped", "time [s]", "force [N]",
        ("good", lambda axes: _force(axes, good[8])),
        ("bad: the amplifier's limit", lambda axes: _force(axes, logs("clipped.h5")[0])),
    )  # fmt: skip
    _beside(
        "quality-sign", "time [s]", "force [N], position [0.1 mm]",
        ("good: force with the motion", lambda axes: _signs(axes, good[8], 1.0)),
        ("bad: force against the motion", lambda axes: _signs(axes, good[8], -1.0)),
    )  # fmt: skip


def _beside(name: str, across: str, up: str, *panels: tuple[str, Callable[[Axes], None]]) -> None:
    with new_figure(6.3, 2.5) as figure:
        first: Axes | None = None
        for n, (title, draw) in enumerate(panels):
            axes = figure.add_subplot(1, 2, n + 1)
            if first is not None and name == "quality-speeds":
                axes.set_xlim(first.get_xlim())
                axes.set_ylim(first.get_ylim())
            draw(axes)
            if name == "quality-stick-slip":
                axes.set_ylim(154.0, 170.0)
            axes.set(title=title, xlabel=across, ylabel=up)
            for line in axes.get_lines():
                if n:
                    line.set_color(VERMILION if line.get_color() == BLUE else line.get_color())
            first = axes
        save_figure(figure, FIGURES / f"{name}.png", force=True)


def _map(axes: Axes, logs: list[Log], xlim: tuple[float, float] | None = None) -> None:
    points, _ = stroke_points(logs)
    axes.plot([1e3 * p.velocity for p in points], [p.force for p in points], "o", ms=4, color=BLUE)
    if xlim is not None:
        axes.set_xlim(xlim)


def _force(axes: Axes, log: Log, start: float = 0.0, stop: float = np.inf, mean: int = 0) -> None:
    assert log.force is not None
    shown = (log.time >= start) & (log.time <= stop)
    axes.plot(log.time[shown], log.force[shown], lw=0.8, color=BLUE, alpha=0.4 if mean else 1.0)
    if mean:
        smooth = np.convolve(log.force, np.full(mean, 1.0 / mean), "same")
        axes.plot(log.time[shown], smooth[shown], lw=1.2, color=BLACK, label=f"mean of {mean} samples")
        axes.legend(loc="upper right")


def _loops(axes: Axes, logs: list[Log], reach: float = np.inf) -> None:
    for log in logs:
        assert log.position is not None
        assert log.force is not None
        axes.plot(1e6 * log.position, log.force, lw=0.7, color=BLUE)
    if np.isfinite(reach):
        axes.set_xlim(-reach, reach)


def _signs(axes: Axes, log: Log, sign: float) -> None:
    assert log.position is not None
    assert log.force is not None
    axes.plot(log.time, sign * log.force, lw=0.7, color=BLUE, label="force")
    axes.plot(log.time, 1e4 * log.position, color=GREY, label="position")
    axes.legend(loc="lower left" if sign > 0 else "upper left")


if __name__ == "__main__":
    for draw in (readme, tutorial, schemes, data_quality):
        with tempfile.TemporaryDirectory() as scratch:
            draw(Path(scratch))
