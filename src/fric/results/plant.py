"""An identified plant."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Annotated, Any, Literal

from fric.documents.plant import PlantDocument, plant_tree
from fric.drive.plant import Plant
from fric.estimate import estimate_rows
from fric.identify.plant.identify import identify_plant as fit_plant
from fric.identify.plant.identify import plant_records
from fric.identify.plant.response_fit import PlantFit
from fric.identify.plant.rigid_body import MotionFit, identify_motion
from fric.log import Log, Record
from fric.notice import Notice
from fric.plausibility import Finding, of_logs, settled
from fric.results.base import Identified
from fric.results.given import quantity, records_of
from fric.results.kinds import Count, EncoderName, LogLike, Quantity
from fric.results.text import Piece, named, parameters
from fric.units import readable
from fric.verb import Kind, verb


@dataclass(frozen=True, eq=False, repr=False)
class PlantResult(Identified):
    """An identified plant, eq. (1)."""

    fit: PlantFit | MotionFit  # The fit, to frequency responses or to motions
    records: Sequence[Record]  # The records that it was identified from

    @property
    def axis(self) -> str:
        """Name of the axis."""
        return self.fit.axis

    @property
    def belief(self) -> Plant:
        """The plant in SI; raises a `FricError` where B or K_f is not known."""
        return PlantDocument.model_validate(self.document).plant(self.fit.motion)

    @cached_property
    def document(self) -> dict[str, Any]:
        """The plant file."""
        return plant_tree(self.fit, self.records)

    def sections(self) -> dict[str, dict[str, dict[str, Any]]]:
        """Return A, B, T_d and K_f, and the further parameters of a motion."""
        given = self.document
        second = {name: entry for name, entry in given.get("second_mass", {}).items() if name != "encoder"}
        found = {"plant": {name: given[name] for name in PlantDocument.dimensions if name in given}}
        found |= {"second_mass": second} if second else {}
        return found | ({"motion": given["fit"]["parameters"]} if given["fit"].get("parameters") else {})

    def report(self) -> list[Piece]:
        """Return A, B, T_d and K_f, and their records."""
        fit, found = self.document["fit"], self.sections()
        pieces: list[Piece] = [parameters(found["plant"], notices=self.warnings)]
        if "second_mass" in found:
            pieces.append(parameters(found["second_mass"], "second mass"))
        if "parameters" in fit:
            rows = [(*row, f"{fit['parameters'][row[0]]['deviation']:.4g}") for row in estimate_rows(fit["parameters"])]
            pieces += [
                named(("", "value", "95 % interval", "unit", "deviation"), rows),
                f"{fit['points']} points, relative error {100 * fit['relative_error']['value']:.4f} %, "
                f"condition number {fit['condition_number']:.4f}",
            ]
            return pieces
        pieces += [
            f"{response['record']}: {response['estimate']}; {response['lines']} lines used, "
            f"{readable(response['lowest']['value'], 'Hz')} to {readable(response['highest']['value'], 'Hz')}"
            for response in fit["responses"]
        ]
        delay = f"transport delay {readable(fit['transport_delay']['value'], 's')}"
        if "hold_delay" in fit:
            delay += f", hold {readable(fit['hold_delay']['value'], 's')} (half a sample): together T_d"
        return [*pieces, delay]


@verb
def identify_plant(
    *logs: LogLike,
    method: Literal["auto", "response", "motion"] = "auto",
    force_constant: Annotated[Quantity | None, "force per input"] = None,
    mass: Annotated[Quantity | None, "mass"] = None,
    coherence: Annotated[float, Kind(least=0, most=1)] = 0.5,
    lowest: Annotated[Quantity | None, "frequency"] = None,
    highest: Annotated[Quantity | None, "frequency"] = None,
    period: Annotated[Quantity | None, "time"] = None,
    segment: Annotated[Quantity | None, "time"] = None,
    hold: Annotated[Quantity, Kind(metavar="RATE|auto|none")] = "auto",
    direction: Literal["both", "each"] = "both",
    delay: Annotated[Quantity | None, "time"] = None,
    cutoff: Annotated[Quantity | None, "frequency"] = None,
    decimation: Count | None = None,
    border: Annotated[int | None, Kind(least=0)] = None,
    encoder: EncoderName = "motor",
) -> PlantResult:
    """Identify the plant A, B, T_d (eq. 1) and K_f, from frequency responses or from an ordinary motion.

    Parameters
    ----------
    method
        Use frequency responses, or a motion. ``auto`` uses responses if there are any.
    force_constant
        Force constant, as "548 N/V", where no force was logged.
    mass
        Moving mass if known, as "85 kg": it is compared with K_f/B.
    coherence
        Least coherence of a frequency.
    lowest
        Lowest frequency, as "5 Hz".
    highest
        Highest frequency, as "300 Hz".
    period
        Period of the excitation; by default found from the data.
    segment
        Length of Welch's segments, without a period.
    hold
        Rate of the hold before the plant, as "4 kHz"; auto: the rate of a record, none for a table.
    direction
        Common friction and an offset, or friction for each direction.
    delay
        T_d, which a motion does not show, as "0.65 ms": delay of the force behind its log.
    cutoff
        Corner of the zero-phase filter.
    decimation
        Keep every N-th sample.
    border
        Samples left out at the start.

    Raises
    ------
    FricError
        When no record is usable, too few lines are certain, or a motion does not separate the terms.
    """
    given = records_of(logs, encoder=encoder)
    wanted, records = plant_records(given, None if method == "auto" else method)
    motion, in_time = records[0].motion, [record for record in records if isinstance(record, Log)]
    doubtful = settled(of_logs(in_time))
    K_f, weight = quantity(force_constant, "force per input", motion), quantity(mass, "mass", motion)
    if wanted == "motion":
        found = identify_motion(
            in_time,
            direction=direction,
            force_constant=K_f,
            delay=quantity(delay, "time"),
            cutoff=quantity(cutoff, "frequency"),
            decimation=decimation,
            border=border,
            mass=weight,
        )
        return _plausible(PlantResult(found, records), doubtful)
    fit = fit_plant(
        records,
        hold=None if hold in {"auto", "none"} else quantity(hold, "frequency"),
        continuous=hold == "none",
        coherence=coherence,
        band=(quantity(lowest, "frequency") or 0.0, quantity(highest, "frequency") or float("inf")),
        period=quantity(period, "time"),
        segment=quantity(segment, "time"),
        given_force_constant=K_f,
        mass=weight,
        strokes=[log for log in given if isinstance(log, Log) and log.kind == "constant-velocity"],
    )
    return _plausible(PlantResult(fit, records), doubtful)


def _plausible(result: PlantResult, doubtful: list[Notice]) -> PlantResult:
    """Return a result with plausible values, or with warnings where bounds are lifted."""
    document, motion = PlantDocument.model_validate(result.document), result.records[0].motion
    known = document.estimates(motion)
    values = {name: float(estimate) for name, estimate in known.items() if name in {"A", "B", "T_d"}}
    if {"B", "K_f"} <= known.keys():
        values["mass"] = float(known["K_f"]) / values["B"]
    found = settled(Finding(name, value, motion, result.records[0].where) for name, value in values.items())
    return replace(result, fit=replace(result.fit, warnings=(*result.fit.warnings, *doubtful, *found)))
