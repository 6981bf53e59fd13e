"""The rooms of the code in the order of their imports, and the way of data from a log to a decision.

The floors are those of the import contract in pyproject.toml; run `python docs/house.py` after a change of it.
"""

import tomllib
from itertools import pairwise
from pathlib import Path

from matplotlib.patches import FancyBboxPatch

from fric.figures.style import BLUE, GREY, new_figure, save_figure

ROOT = Path(__file__).parents[1]
WAY = (
    ("io", "log files\n→ records"),
    ("records", "strokes, cycles,\nprepared records"),
    ("identify", "plant, map, GMS\nwith intervals"),
    ("documents", "friction.yaml,\nmachine.yaml"),
    ("simulate", "circles under\neach scheme"),
    ("circles", "prediction beside\na measured circle"),
    ("verdict", "what to\nswitch on"),
    ("results", "screen, JSON,\nfigures, page"),
)
"""Where data go: the room, and what they are there."""


def floors() -> list[list[str]]:
    """Return the rooms of each floor, from the top: a room imports from floors below alone."""
    contracts = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["importlinter"]["contracts"]
    return [[room.strip(" ()").removeprefix("fric.") for room in floor.split("|")] for floor in contracts[0]["layers"]]


def draw() -> None:
    """Draw the floors, and the way through them."""
    rows = floors()
    level = {room: len(rows) - n for n, rooms in enumerate(rows) for room in rooms}
    with new_figure(9.6, 7.6) as figure:
        axes = figure.subplots()
        for n, rooms in enumerate(rows):
            y = len(rows) - n
            axes.axhspan(y - 0.46, y + 0.46, color="#F1F4F7" if n % 2 else "#E6EBF0", linewidth=0)
            shown = ", ".join(rooms)
            half = shown.rfind(", ", 0, 44) + 2 if len(shown) > 44 else 0
            text = f"{shown[:half].rstrip()}\n{shown[half:]}" if half else shown
            axes.text(0.1, y, text, va="center", fontsize=7 if half else 8)
        stations = [(4.3 + 1.06 * n, level[room], text) for n, (room, text) in enumerate(WAY)]
        for (x, y, _), (x_next, y_next, _) in pairwise(stations):
            side = 0.42 if y_next > y else -0.42
            axes.annotate("", (x_next - 0.3, y_next - side), (x + 0.3, y + side), zorder=3,
                          arrowprops={"arrowstyle": "-|>", "color": BLUE, "shrinkA": 0, "shrinkB": 0})  # fmt: skip
        for x, y, text in stations:
            axes.add_patch(FancyBboxPatch((x - 0.46, y - 0.36), 0.92, 0.72, "round,pad=0.04", facecolor="white",
                                          edgecolor=BLUE, linewidth=1.0, zorder=4))  # fmt: skip
            axes.text(x, y, text, ha="center", va="center", fontsize=6, zorder=5)
        axes.annotate("imports run down", (3.5, 1.2), (3.5, len(rows) - 0.2), ha="center", fontsize=7, color=GREY,
                      arrowprops={"arrowstyle": "-|>", "color": GREY})  # fmt: skip
        axes.set(xlim=(0, 12.4), ylim=(0.4, len(rows) + 0.7))
        axes.axis("off")
        save_figure(figure, ROOT / "docs/figures/house.png", force=True)


if __name__ == "__main__":
    draw()
