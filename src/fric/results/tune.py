"""Nominal parameters of a machine's controllers, refitted to recorded circles."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

from fric.circles.next_circle import measured_glitch
from fric.circles.tune import Tuned, steps_of_tuning
from fric.circles.tune import tune as refit
from fric.documents.circle_findings import TuningDocument, tuned_files, write_tuned
from fric.errors import FricError
from fric.estimate import estimate_rows
from fric.notice import Notice
from fric.output import refuse_existing, together
from fric.results.base import DataFrame, Figure, Result
from fric.results.given import Advance, silent
from fric.results.given_models import CIRCLES, circles_of, machine_of
from fric.results.kinds import CircleLike, MachineLike, SchemeName
from fric.results.text import Piece, Table, named
from fric.simulate.machine import Machine
from fric.threads import one_blas_thread
from fric.units import readable
from fric.verb import UnfitError, verb


@dataclass(frozen=True, eq=False, repr=False)
class TuneResult(Result, schema=TuningDocument):
    """A machine with nominal parameters from recorded circles."""

    found: Tuned  # The result of the fit
    source: str  # The machine file that it was tuned from; empty for a machine without a file: save its `machine`
    files: list[Path] = field(default_factory=list)  # The files written; empty until it is saved

    @property
    def machine(self) -> Machine:
        """The machine with its new nominal parameters."""
        return self.found.machine

    @property
    def warnings(self) -> Sequence[Notice]:
        """What the circles do not determine, and what was refused."""
        return self.found.warnings

    @property
    def measured(self) -> dict[str, float]:
        """Recorded glitch [m] by feed."""
        return {f"{test.feed:g}": measured_glitch(test) for test in self.found.tests}

    def brief(self) -> str:
        """Return the expected glitch of the next circle."""
        ahead = self.found.predicted
        best = min(ahead, key=lambda circle: circle.glitch) if ahead else None
        return "" if best is None else f"next circle with ({best.scheme}): {readable(best.glitch, 'm', 2)}"

    def report(self) -> list[Piece]:
        """Return the parameters by axis, and the next circles."""
        pieces: list[Piece] = []
        for name, axis in self.found.axes.items():
            before, after = (f"{fitted.rms * 1e3:.2f} mV" for fitted in (axis.before, axis.after))
            title = f"axis {name}: {before} left of the voltage, {after} when tuned"
            title += "" if axis.improves else "; refused"
            pieces += [named(["", "value", "95 %", "unit"], estimate_rows(axis.parameters), title), ""]
        rows = [
            [
                f"{circle.feed * 1e3:g} mm/s", f"({circle.scheme})", f"{self.measured[f'{circle.feed:g}'] * 1e6:.2f}",
                f"{circle.glitch * 1e6:.2f}", " … ".join(f"{limit * 1e6:.2f}" for limit in circle.ci95),
            ]
            for circle in self.found.predicted
        ]  # fmt: skip
        if rows:
            pieces.append(Table(["the next circle", "scheme", "recorded µm", "glitch µm", "95 %"], rows))
        if self.files:
            pieces.append(f"wrote {', '.join(map(str, self.files))}")
        return pieces

    def figure(self) -> Figure:
        """Return the voltage at the reversals of the first axis, before and after."""
        from fric.figures.tuned import draw_tuned

        return draw_tuned(next(iter(self.found.axes.values())))

    def to_frame(self) -> DataFrame:
        """Return the expected glitches of the next circles [m]."""
        import pandas as pd

        rows = [(circle.feed, circle.scheme, circle.glitch, *circle.ci95) for circle in self.found.predicted]
        return pd.DataFrame(rows, columns=["feed", "scheme", "glitch", "low", "high"])

    def save(self, path: Path | str, *, force: bool = False) -> None:
        """Write machine.yaml, friction and plant files of each axis, and a figure of its reversals, into a folder."""
        from fric.figures.style import save_figure
        from fric.figures.tuned import draw_tuned

        if not self.source:
            raise FricError("the tuned machine has no file", hint='`result.machine.save("machine.yaml")` writes it.')
        folder = Path(path)
        figures = {folder / f"{name}.png": axis for name, axis in self.found.axes.items()}
        if folder.is_dir():
            refuse_existing(*tuned_files(self.found, folder), *figures, force=force)
        with together(*tuned_files(self.found, folder), *figures) as made:
            written = write_tuned(self.found, Path(self.source), folder, force=force, done=made)
            for place, figure in figures.items():
                save_figure(draw_tuned(figure), place, force=force)
                made.append(place)
        self.files[:] = [*written, *figures]
        self.__dict__.pop("document", None)  # it names them


@verb
def tune(
    machine: MachineLike,
    *circles: CircleLike,
    scheme: SchemeName | None = None,
    loop: bool = False,
    advance: Advance = silent,
) -> TuneResult:
    """Refit the nominal parameters of a machine's controllers to recorded circles: friction, plant, delay and lead.

    Parameters
    ----------
    circles
        Circle tests, or run files of `fric simulate circle`. One fast and one slow, with reference, position and
        voltage of both axes; measured circles are taken, too.
    loop
        Design new gains if friction that falls with speed makes errors grow.

    Raises
    ------
    FricError
        When a test lacks a channel, or there is no nominal GMS model.
    """
    subject = machine_of(machine)
    if not (tests := circles_of(circles, scheme)):
        raise UnfitError(CIRCLES, None)
    advance(0, total=steps_of_tuning(tests))
    with one_blas_thread():  # products of small matrices between compiled replays
        found = refit(subject, tests, advance, loop=loop)
    return TuneResult(found, str(subject.origin.get("path", "")))
