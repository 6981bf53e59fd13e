"""A recorded motion replayed by the identified axis."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import inf
from typing import Annotated

from fric.circles.validation import Validation, validate_closed_loop, validate_inverse, validate_open_loop
from fric.documents.comparison import ValidationDocument
from fric.documents.plant import PlantDocument
from fric.drive.plant import hold_delay
from fric.errors import FricError
from fric.estimate import Estimate
from fric.flaws.prediction import INVERSE_LEFT_OUT, T_D_BELOW_HOLD
from fric.log import Log
from fric.notice import Notice, once
from fric.records.timing import even_sampling as sampling_of
from fric.results.base import DataFrame, Result
from fric.results.given import in_si, logs_of
from fric.results.given_models import cascade_of, document_of, friction_of
from fric.results.kinds import ControllerLike, FrictionLike, LogLike, PlantLike, Quantity
from fric.results.text import Piece, Table
from fric.units import readable, si_unit
from fric.verb import Kind, verb


@dataclass(frozen=True, eq=False, repr=False)
class ValidationResult(Result, schema=ValidationDocument):
    """Records, and their replay by the identified axis."""

    validations: Sequence[Validation]  # A validation for each record and loop
    logs: Sequence[Log]  # The records
    notices: Sequence[Notice] = ()  # Warnings of the files

    @property
    def warnings(self) -> Sequence[Notice]:
        """Warnings of the files, and of the recorded controller and voltage."""
        return once([*self.notices, *(text for validation in self.validations for text in validation.warnings)])

    def report(self) -> list[Piece]:
        """Return relative and rms error of each signal."""
        rows = [
            (
                f"{found.log.name}, {found.loop} loop, {found.friction.name}",
                name,
                f"{100 * signal.relative:.4g} %" if signal.relative < inf else "at rest",
                readable(signal.rms, si_unit(name, found.log.motion)),
            )
            for found in self.validations
            for name, signal in found.signals.items()
        ]
        return [Table(("", "signal", "relative error", "rms error"), rows)]

    def to_frame(self) -> DataFrame:
        """Return the errors by record, loop and signal, in SI."""
        import pandas as pd

        rows = [
            {"record": found["record"], "loop": found["loop"], "signal": name, **signal}
            for found in self.document["validations"]
            for name, signal in found["signals"].items()
        ]
        return pd.DataFrame(rows).set_index(["record", "loop", "signal"])


@verb
def validate(
    *logs: LogLike,
    plant: PlantLike,
    controller: ControllerLike | None = None,
    friction: FrictionLike | None = None,
    model: Annotated[str | None, Kind(metavar="NAME")] = None,
    load: Annotated[Quantity | None, "force"] = None,
) -> ValidationResult:
    """Replay a recorded motion in closed loop, in open loop and inversely, and score it against the record.

    Parameters
    ----------
    plant
        The identified plant. Its file or its result.
    controller
        The drive's controller; without it, only the open loop. A `Cascade`, its file or its result.
    friction
        The identified friction; by default Coulomb friction of the plant's fit. Its file or its result.
    model
        The friction file's model, if it contains several.
    load
        Constant load, as "-3.2 N"; by default the identified offset.

    Raises
    ------
    FricError
        When a channel is missing, a file is of another axis, or several friction models leave the choice open.
    """
    records = logs_of(logs)
    axis, motion = records[0].axis, records[0].motion
    if model and friction is None:
        raise FricError("`model=` names a model of a friction file", hint="Give that file with `friction=`.")
    document = document_of(PlantDocument, plant, (axis, motion))
    identified = document.plant(motion)
    cascade = cascade_of(controller, axis, motion)
    text = friction_of(friction, axis, motion)
    done, short = list[Validation](), list[Notice]()
    measured = replace(identified, T_d=0.0) if document.T_d.assumed else identified
    for log in records:
        law, offset = text.found_with(model, log.name) if text else document.coulomb()
        weight = offset if load is None else in_si(load, "force", motion)
        if cascade:
            done.append(validate_closed_loop(log, identified, cascade, law, weight))
        done.append(validate_open_loop(log, identified, law, weight))
        try:
            done.append(validate_inverse(log, measured, law, weight))
        except FricError as error:
            short.append(INVERSE_LEFT_OUT.found(log.name, why=error.what))
        if identified.T_d < hold_delay(sampling_of(log)):
            short.append(T_D_BELOW_HOLD.found(log.where, T_d=Estimate(identified.T_d, "s")))
    return ValidationResult(done, records, (*document.passed_on(), *short))
