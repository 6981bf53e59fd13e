"""What both design commands take and print."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any

import typer

from fric.cli.console import OUT, print_table

PlantArgument = Annotated[Path, typer.Argument(metavar="PLANT.yaml", help="The plant, eq. (1): A, B, T_d.")]

MARGINS = (
    ("phase_margin", "phase margin", "°", 1),
    ("gain_margin", "gain margin", " dB", 1),
    ("peak_sensitivity", "Ms", " dB", 1),
    ("crossover", "crossover", " Hz", 4),
    ("bandwidth", "bandwidth", " Hz", 4),
)


def print_margins(margins: Mapping[str, Mapping[str, Any]], titles: Mapping[str, str]) -> None:
    """Print the margins of a document, a loop a line."""
    print_table(
        ["loop", *(title for _, title, _, _ in MARGINS)],
        [
            [titles[name], *(_told(found.get(key), unit, digits) for key, _, unit, digits in MARGINS)]
            for name, found in margins.items()
        ],
    )


def _told(quantity: Mapping[str, Any] | None, unit: str, digits: int) -> str:
    if quantity is None:
        return "–"
    value = quantity["value"]
    return f"{value:.{digits}g}{unit}" if digits > 1 else f"{value:.1f}{unit}"


def print_written(*paths: Path | None) -> None:
    """Print which files were written."""
    written = [str(path) for path in paths if path is not None]
    if written:
        OUT.print(f"wrote {' and '.join(written)}")
