"""The glitch of each scheme over feed and radius."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np

from fric.documents.contours import CircleMapDocument
from fric.errors import FricError
from fric.flaws.prediction import INTERRUPTED, SCHEME_FAILED
from fric.notice import Notice, once
from fric.results.base import DataFrame, Result
from fric.results.given import Advance, bounded, in_si, silent
from fric.results.given_models import machine_of, schemes_of
from fric.results.kinds import Address, Count, KnownSchemes, MachineLike, Quantities, Quantity, SchemesLike
from fric.results.text import Piece, Table
from fric.simulate.circle import CircleGrid, CircleMap
from fric.simulate.contour_run import pair
from fric.simulate.processes import run_all
from fric.units import readable
from fric.verb import Kind, verb

POINTS = 6
"""Number of feeds, and of radii, in a range."""


@dataclass(frozen=True, eq=False, repr=False)
class CircleMapResult(Result, schema=CircleMapDocument, of="found"):
    """The glitches that schemes leave on circles of many feeds and radii."""

    found: CircleMap  # The glitches
    done: int  # Circles that were run: the first ones, where it was interrupted

    @property
    def cut_short(self) -> bool:
        """Whether fewer circles were run than requested."""
        return self.done < len(self.found.cells)

    @property
    def warnings(self) -> Sequence[Notice]:
        """Warnings of the machine's files, and where schemes could not run."""
        notices: list[Notice] = []
        if self.cut_short:
            notices.append(INTERRUPTED.found(done=self.done, circles=len(self.found.cells)))
        for scheme in self.found.grid.schemes:
            failed = [cell for cell in self.found.cells[: self.done] if scheme.name in cell.failures]
            if failed:
                why = failed[0].failures[scheme.name]
                counts = {"failed": len(failed), "runs": len(self.found.cells), "of": "circles"}
                notices.append(SCHEME_FAILED.found(f"scheme {scheme.name}", **counts, why=why))
        return once([*self.found.grid.machine.warnings, *notices])

    def report(self) -> list[Piece]:
        """Return the glitch by circle and scheme, and where GMS improves it and the observer makes it worse."""
        grid = self.found.grid
        columns = ["radius", "feed", *(f"({scheme.name}) {scheme.title}" for scheme in grid.schemes)]
        rows = [
            [readable(cell.circle.radius, "m"), readable(cell.circle.feed, "m/s"),
             *("–" if np.isnan(glitch) else f"{glitch * 1e6:.2f}" for glitch in cell.glitches)]
            for cell in self.found.cells
        ]  # fmt: skip
        table = Table(columns, rows, f"{grid.machine.name}: glitch in µm")
        return [table, *CircleMapDocument.model_validate(self.document).describe()]

    def to_frame(self) -> DataFrame:
        """Return the glitch [m] by radius and feed, a column a scheme."""
        import pandas as pd

        names = [scheme.name for scheme in self.found.grid.schemes]
        index = pd.MultiIndex.from_tuples(
            [(cell.circle.radius, cell.circle.feed) for cell in self.found.cells], names=["radius", "feed"]
        )
        return pd.DataFrame([cell.glitches for cell in self.found.cells], index=index, columns=names)


def values_of(given: Any, dimension: str, points: int = POINTS) -> tuple[float, ...]:
    """Return quantities given as numbers in SI, as a list such as "5, 10, 50 mm/s", or as a range "5 … 200 mm/s".

    A range has ``points`` values in geometric progression. The last unit holds for values without a unit.

    Raises FricError: When a value is no quantity of this dimension, or not positive.
    """
    if not isinstance(given, str):
        found = tuple(in_si(item, dimension) for item in (given if isinstance(given, list | tuple) else [given]))
    else:
        text = given.replace("...", "…")
        ends = text.split("…")
        parts = [part.strip() for part in (ends if len(ends) == 2 else text.split(","))]
        unit = parts[-1].lstrip("0123456789.eE+- ")
        read = [in_si(part if part.lstrip("0123456789.eE+- ") else f"{part} {unit}", dimension) for part in parts]
        found = tuple(read)
        if len(ends) == 2 and min(read) > 0:
            found = tuple(float(item) for item in np.geomspace(read[0], read[1], points))
    if not found or min(found) <= 0:
        raise FricError(f"'{given}' is no range of positive values", hint="Write '5 … 200 mm/s', or '5, 10, 50 mm/s'.")
    return found


@verb
def circle_map(
    machine: MachineLike,
    schemes: SchemesLike = "a,b,c,f",
    *,
    feeds: Quantities = "5 … 200 mm/s",
    radii: Quantities = "5 … 100 mm",
    points: Annotated[int, Kind(least=2, most=1000)] = POINTS,
    known: KnownSchemes | None = None,
    accuracy: Annotated[Quantity, "position"] = "0.005 um",
    workers: Count | None = None,
    scheduler: Address | None = None,
    advance: Advance = silent,
    interrupted: Callable[[], bool] = lambda: False,
) -> CircleMapResult:
    """Run circles of many feeds and radii: where GMS beats the static map, and where the observer makes it worse.

    Parameters
    ----------
    feeds
        A range, or feeds with commas. As "5, 10, 50 mm/s", or numbers [m/s].
    radii
        A range, or radii with commas. As "5 … 100 mm", or numbers [m].
    points
        Number of values in a range.

    Raises
    ------
    FricError
        When the machine does not have two axes for a circle, or no circle was completed.
    """
    subject = machine_of(machine)
    pair(subject)
    chosen = tuple(schemes_of(schemes, known))
    over = values_of(feeds, "velocity", points), values_of(radii, "position", points)
    for name, values in zip(("speed", "radius"), over, strict=True):
        bounded(name, max(values))
    grid = CircleGrid(subject, chosen, *over, in_si(accuracy, "position"))
    advance(0, total=len(grid))
    cells = run_all(grid, len(grid), workers=workers, scheduler=scheduler, advance=advance, interrupted=interrupted)
    if not cells:
        raise FricError("no circle was done", hint="Nothing was written.")
    done = len(cells)
    cells += [grid.not_run(n) for n in range(done, len(grid))]
    return CircleMapResult(CircleMap(grid, cells), done)
