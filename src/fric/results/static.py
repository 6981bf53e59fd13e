"""An identified static map."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Annotated, Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from fric.arrays import Real
from fric.documents.friction import static_tree
from fric.documents.plant import PlantDocument
from fric.drive.plant import Plant
from fric.errors import FricError
from fric.identify.static_map.identify import StaticFit
from fric.identify.static_map.identify import identify_static as fit_static
from fric.identify.static_map.strokes import ShapeFactor
from fric.log import ForceVelocity, FrequencyResponse, Log
from fric.plausibility import Finding, of_friction, of_logs, of_strokes, settled
from fric.results.friction import IdentifiedFriction
from fric.results.given import in_si, records_of, several
from fric.results.given_models import document_of, plant_of
from fric.results.kinds import EncoderName, LogLike, PlantLike, Quantity
from fric.results.text import Piece, parameters
from fric.units import readable, si_unit
from fric.verb import Kind, verb


@dataclass(frozen=True, eq=False, repr=False)
class StaticResult(IdentifiedFriction):
    """An identified static map, eq. (2)."""

    fit: StaticFit  # The fit: points, map, intervals
    logs: Sequence[Log | ForceVelocity]  # The records that it was identified from

    @cached_property
    def document(self) -> dict[str, Any]:
        """The friction file."""
        return static_tree(self.fit, self.logs)

    def predict(self, velocity: ArrayLike | str) -> tuple[Real, Real]:
        """Return the force [N] at velocities [m/s] including the offset, and the half-width of its 95 % band.

        velocity: Numbers, or a text as "1 mm/s, 10 mm/s".

        Raises
        ------
        FricError
            When only one speed was logged.
        """
        fit = self.fit
        given = several(velocity, "velocity", fit.motion) if isinstance(velocity, str) else velocity
        v = np.atleast_1d(np.asarray(given, float))
        if fit.static is None:
            raise FricError("only one speed was logged, which gives no map", hint="Log strokes at ten speeds.")
        force, half = fit.static.predict(v)
        if fit.negative is not None:
            mirrored, wide = fit.negative.predict(-v)
            force, half = np.where(v < 0, -mirrored, force), np.where(v < 0, wide, half)
        return force, half

    def report(self) -> list[Piece]:
        """Return the map, and how well it fits."""
        fit, unit = self.fit, si_unit("force", self.fit.motion)
        maps = {"": fit.static, "negative direction": fit.negative}
        text: list[Piece] = [
            parameters(fit.estimates, title, self.warnings) for title, fit in maps.items() if fit is not None
        ]
        text += [parameters(fit.at_speed, "at one speed")] if fit.at_speed else []
        quality = f", rmse {readable(fit.static.rmse, unit)}, R² {fit.static.r2:.4f}" if fit.static else ""
        return [*text, f"{len(fit.points)} strokes{quality}"]


@verb
def identify_static(
    *logs: LogLike,
    plant: PlantLike | None = None,
    delta: Annotated[float | str, Kind(metavar="VALUE|free|auto")] = "auto",
    direction: Literal["auto", "both", "each"] = "auto",
    over_position: Literal["auto", "off", "on"] = "auto",
    weights: Literal["error", "equal"] = "error",
    average: Literal["robust", "median"] = "robust",
    form: Literal["auto", "coulomb", "stribeck"] = "auto",
    load: Annotated[Quantity | None, "force"] = None,
    encoder: EncoderName = "motor",
) -> StaticResult:
    """Identify the static friction map F_c, F_s, v_s, delta, sigma (eq. 2) from constant-velocity strokes.

    Parameters
    ----------
    logs
        Log files of one axis. Or records: strokes, one or many a record, and tables of mean forces at velocities.
    plant
        The plant, whose linear damping is subtracted. Its file or its result: ``K_f·(A/B)·v`` is subtracted first.
    delta
        Stribeck shape factor, fixed or free; auto: free if that predicts held-out strokes better than 1.
    direction
        Common map and offset, a map for each direction, or whichever predicts held-out strokes better.
    over_position
        Whether to subtract forces that depend on position; auto: if that predicts better.
    weights
        Weigh strokes by their errors and scatter, or all equally.
    average
        Force of a stroke: Huber's robust mean, or the median.
    form
        Coulomb plus viscous friction, eq. (2), or whichever predicts held-out strokes better.
    load
        Constant load if known, as "60 N" or "0 N": the offset is then equal to it. As the weight of a vertical axis.

    Raises
    ------
    FricError
        When there is no steady stroke, or there are too few speeds for the parameters.
    """
    records = [log for log in records_of(logs, encoder=encoder) if not isinstance(log, FrequencyResponse)]
    if not records:
        raise FricError("there is neither a record in time nor a table of forces and velocities")
    given = None if plant is None or isinstance(plant, Plant) else document_of(PlantDocument, plant)
    known = plant_of(plant, records[0].axis, records[0].motion)
    in_time = [record for record in records if isinstance(record, Log)]
    doubtful = settled([*of_logs(in_time, known), *of_strokes(in_time)])
    found = fit_static(
        records,
        plant=known,
        delta=_shape_factor(delta),
        direction=direction,
        over_position=over_position,
        weights=weights,
        average=average,
        form=form,
        load=None if load is None else in_si(load, "force", records[0].motion),
        damping_error=0.0 if given is None else given.damping_error(records[0].motion),
    )
    if known is not None:
        fastest = max(found.points, key=lambda point: abs(point.velocity))
        taken_off = known.damping * fastest.velocity
        share = abs(taken_off / (fastest.force + taken_off or 1e-300))
        doubtful += settled([Finding("damping", share, found.motion, records[0].source)])
    for fit in (found.static, found.negative):
        mass = known.M if known else None
        doubtful += settled(of_friction(fit.static_map, found.motion, mass, records[0].source)) if fit else []
    return StaticResult(replace(found, warnings=(*found.warnings, *doubtful)), records)


def _shape_factor(given: float | str) -> ShapeFactor:
    if given in {"free", "auto"}:
        return given  # type: ignore[return-value]
    try:
        value = float(given)
    except (TypeError, ValueError):
        value = 0.0
    if not 0.1 <= value <= 4.0:
        raise FricError(f"delta '{given}' is not a shape factor", hint="Give a number from 0.1 to 4, 'free' or 'auto'.")
    return value
