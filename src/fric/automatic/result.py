"""What came of a fleet: a table of machines, axes and dates, and what changed, the surest first."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from math import inf
from pathlib import Path
from typing import Any

from fric.automatic.change import LEVEL, Drift, drifts
from fric.automatic.fleet import Unit, UnitOutcome, run_fleet
from fric.automatic.session import Run
from fric.documents.fleet import FleetDocument
from fric.documents.yaml import write_document
from fric.estimate import Estimate
from fric.notice import Notice
from fric.output import staged, together
from fric.report.page import environment
from fric.results.base import Result
from fric.results.text import Piece, Table
from fric.units import readable

SHOWN = ("F_c", "F_s", "v_s", "sigma")
"""Numbers of an axis that the table of a fleet shows."""


@dataclass(frozen=True, eq=False, repr=False)
class FleetResult(Result):
    """What came of a fleet.

    Parameters
    ----------
    folder
        Where all files are.
    outcomes
        What came of each machine and date.
    drifts
        Each number at two following dates, the surest change first.
    """

    folder: Path
    outcomes: Sequence[UnitOutcome]
    drifts: Sequence[Drift]

    @property
    def changed(self) -> list[tuple[str, str]]:
        """Machine and axis of each that changed, the surest first."""
        return list(dict.fromkeys((one.machine, one.axis) for one in self.drifts if one.changed))

    @property
    def warnings(self) -> Sequence[Notice]:
        """What was guessed, left out, or could not be read, by machine and date."""
        return [notice.at(f"{one.unit.machine}/{one.unit.date}") for one in self.outcomes for notice in one.description]

    @cached_property
    def document(self) -> dict[str, Any]:
        """The fleet file."""
        return FleetDocument.made(
            {
                "page": str(self.folder / "fleet.html"), "level": LEVEL, "tests": len(self.drifts),
                "units": [
                    {
                        "machine": one.unit.machine, "date": one.unit.date, "notes": list(one.description),
                        "axes": {
                            name: {"done": axis["done"], "missing": axis["missing"]} for name, axis in one.axes.items()
                        },
                    }
                    for one in self.outcomes
                ],
                "changed": [list(one) for one in self.changed],
                "changes": [_entry(one) for one in self.drifts if one.change.verdict == "moved"],
            }
        ).tree()  # fmt: skip

    def report(self) -> list[Piece]:
        """Return what changed, and the numbers of every axis at every date."""
        rows = [
            (
                f"{one.machine} {one.axis}", " → ".join(one.dates), one.change.name,
                readable(one.change.before, one.change.unit), readable(one.change.after, one.change.unit),
                "" if one.change.relative is None else f"{one.change.relative:+.1%}", f"{one.adjusted:.2g}",
            )
            for one in self.drifts if one.changed
        ]  # fmt: skip
        machines = len({one.unit.machine for one in self.outcomes})
        count = len(self.changed)
        head = f"{count} {'axis' if count == 1 else 'axes'} of {machines} machines changed"
        head += f", at {LEVEL:.0%} for all {len(self.drifts)} numbers together"
        made, steps = sum(one.made for one in self.outcomes), sum(one.steps for one in self.outcomes)
        changes = Table(("changed", "dates", "", "before", "after", "", "by chance"), rows)
        every = Table(("axis", "date", *SHOWN, "glitch"), self.values())
        foot = f"{made} of {steps} steps were run, the rest was up to date"
        return [head, *([changes] if rows else []), every, foot, str(self.folder / "fleet.html")]

    def values(self) -> list[tuple[str, ...]]:
        """Return a row an axis and date: its name, the date, what was identified, its largest glitch, for people."""
        rank = {one: n for n, one in enumerate(self.changed)}
        rows = []
        for outcome in self.outcomes:
            for name, axis in outcome.axes.items():
                tree = axis["documents"].get("friction") or axis["documents"].get("static") or {}
                shown = tuple(_shown(tree.get("static", {}).get(symbol)) for symbol in SHOWN)
                place = rank.get((outcome.unit.machine, name), len(rank))
                glitch = max(axis.get("glitches", {}).values(), key=lambda one: abs(one["value"]), default=None)
                shown += (_shown(glitch),)
                rows.append((place, (f"{outcome.unit.machine} {name}", outcome.unit.date, *shown)))
        return [row for _, row in sorted(rows, key=lambda one: one[0])]

    def write(self) -> None:
        """Write the page and the fleet file into the folder."""
        document, target = self.folder / "fleet.yaml", self.folder / "fleet.html"
        page = environment().get_template("fleet.html.j2").render(
            fleet=self, level=LEVEL, shown=(*SHOWN, "glitch"), rows=self.values(),
            unchanged=[one for one in self.drifts if not one.changed and one.change.verdict == "moved"][:50],
        )  # fmt: skip
        with together(document) as made, staged(target, force=True) as draft:
            draft.write_text(page, encoding="utf-8")
            write_document(document, self.document, force=True)
            made.append(document)


def _shown(entry: Any) -> str:
    if entry is None:
        return "–"
    estimate = Estimate(float(entry["value"]), str(entry["unit"]))
    low, high = entry.get("ci95") or (None, None)
    half = "" if low is None or high is None else f" ± {readable(0.5 * (high - low), estimate.unit, 2)}"
    return readable(float(estimate), estimate.unit) + half


def _entry(one: Drift) -> dict[str, Any]:
    change = one.change
    return {
        "machine": one.machine, "axis": one.axis, "parameter": change.name, "unit": change.unit,
        "dates": list(one.dates), "before": change.before, "after": change.after, "relative": change.relative,
        "ci95": change.difference_ci95 or (inf, inf), "p": one.p, "adjusted": one.adjusted, "changed": one.changed,
    }  # fmt: skip


def fleet(
    units: Sequence[Unit],
    folder: Path,
    *,
    mapping: str | None,
    run: Run,
    workers: int | None,
    scheduler: str | None,
    advance: Callable[..., object],
) -> FleetResult:
    """Identify every machine at every date, and write the fleet's page; see `fric.automatic.fleet.run_fleet`."""
    folder.mkdir(parents=True, exist_ok=True)
    found = run_fleet(units, folder, mapping=mapping, run=run, workers=workers, scheduler=scheduler, advance=advance)
    made = FleetResult(folder, found, drifts(found))
    made.write()
    return made
