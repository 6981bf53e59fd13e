"""What designs share: the axis that they are for, their file, and a table of margins."""

from abc import abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from fric.design.perturbation import Perturbation, measured_perturbation
from fric.documents.plant import PlantDocument
from fric.log import FrequencyResponse, Log, Record
from fric.notice import Notice, once
from fric.results.base import Figure, Result
from fric.results.text import Table
from fric.units import Motion

MARGINS = (
    ("phase_margin", "phase margin", "°", 1),
    ("gain_margin", "gain margin", " dB", 1),
    ("peak_sensitivity", "Ms", " dB", 1),
    ("crossover", "crossover", " Hz", 4),
    ("bandwidth", "bandwidth", " Hz", 4),
)


def perturbation_of(
    record: Log | FrequencyResponse, document: PlantDocument, averages: int = 1
) -> tuple[Perturbation, tuple[Notice, ...]]:
    """Return the perturbation of a plant from a measured response or a record, and its warnings.

    Frequencies below the lowest line that the plant was identified from are left out: there friction hides the plant.
    """
    from fric.identify.plant.frequency_response import measure_response  # with SciPy's signal processing

    plant, lowest = document.linear(document.motion), document.lowest(record.name)
    if isinstance(record, FrequencyResponse):
        return measured_perturbation(record, plant, averages=averages, lowest=lowest), ()
    response = measure_response(record)
    found = measured_perturbation(response.table, plant, sampling=response.sampling, lowest=lowest)
    return found, tuple(response.warnings)


@dataclass(frozen=True, eq=False, repr=False)
class Design(Result):
    """A design of one axis, with its loops and their margins; `document` is its file."""

    design: Any  # What was designed, with its loops
    axis: str  # Name of the axis
    motion: Motion  # Whether it is linear or rotary
    description: Sequence[Notice] = ()  # What else the user should know, and what the plant's file warns of
    logs: Sequence[Record] = ()  # The record of the response, where there is one
    view: str = "bode"  # What the figure shows: ``bode``, ``nyquist`` or ``nichols``; of an observer also ``q``, Fig. 7

    @abstractmethod
    def parts(self) -> dict[str, Any]:
        """Return what was designed, by key of the file."""

    @property
    def content(self) -> dict[str, Any]:
        """The content of the file."""
        margins = {name: loop.margins.as_dict() for name, loop in self.design.loops().items()}
        return {"axis": self.axis, "motion": self.motion, **self.parts(), "margins": margins}

    @property
    def warnings(self) -> Sequence[Notice]:
        """What the plant's file and the response cannot tell."""
        return once(self.description)

    def margins(self) -> Table:
        """Return the margins, a line for each loop."""
        titles = {name: loop.title for name, loop in self.design.loops().items()}
        rows = [
            [titles[name], *(_described(found.get(key), unit, digits) for key, _, unit, digits in MARGINS)]
            for name, found in self.document["margins"].items()
        ]
        return Table(["loop", *(title for _, title, _, _ in MARGINS)], rows)

    def loops_figure(self, nyquist: float) -> Figure:
        """Return the figure of the loops up to half the sampling rate [Hz]: Bode, Nyquist or Nichols."""
        from fric.figures.loops import bode_figure, nichols_figure, nyquist_figure

        draw = {"bode": bode_figure, "nyquist": nyquist_figure, "nichols": nichols_figure}[self.view]
        return draw(self.design.loops().values(), nyquist)

    def by_row(self) -> dict[str, dict[str, Any]]:
        """Return the margins by loop: °, dB and Hz, as in the file."""
        return {
            name: {key: found[key]["value"] if found.get(key) else float("nan") for key, *_ in MARGINS}
            for name, found in self.document["margins"].items()
        }


def _described(quantity: Mapping[str, Any] | None, unit: str, digits: int) -> str:
    if quantity is None:
        return "–"
    value = quantity["value"]
    return f"{value:.{digits}g}{unit}" if digits > 1 else f"{value:.1f}{unit}"
