"""What of a machine is drawn: its spreads, and the intervals of what was identified, from their files."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from fric.documents.discrepancy import discrepancies
from fric.documents.friction import FrictionDocument
from fric.documents.machine import spring_of, true_friction
from fric.documents.machine_files import read_machine, read_machine_document
from fric.documents.plant import PlantDocument, PlantPart
from fric.errors import FricError
from fric.estimate import Covariance, Estimate
from fric.flaws.prediction import NOT_DRAWN
from fric.notice import Notice
from fric.simulate.intervals import Intervals, closed_intervals, friction_intervals
from fric.simulate.machine import Machine
from fric.simulate.reality.flaws import NONE
from fric.simulate.spread import Spread
from fric.verb import verb

NO_INTERVAL = "no parameter has a 95 % interval"


@dataclass(frozen=True)
class Identified:
    """A machine as it was identified."""

    machine: Machine  # The machine, true to the estimates
    # By axis and parameter, the 95 % intervals that hold their estimate and are closed
    intervals: Mapping[str, Intervals]
    covariances: Mapping[str, Sequence[Covariance]]  # By axis, how these parameters err together, where the files tell
    # By axis, by what factors it may differ besides, as misfit and warnings of the files say
    discrepancies: Mapping[str, Mapping[str, Spread]]
    widened: Mapping[str, tuple[Notice, ...]]  # By axis, why
    warnings: tuple[Notice, ...]  # Which parameters cannot be drawn from their interval

    def drawn(self) -> dict[str, Any]:
        """Return what a study draws its machines from."""
        return {
            "intervals": self.intervals, "covariances": self.covariances, "discrepancies": self.discrepancies
        }  # fmt: skip


@verb
def read_identified(
    path: Path | str,
    *,
    nominal_files: Iterable[str] = (),
    gain: float | None = None,
    lead: float | str | None = None,
    friction_model: str | None = None,
) -> Identified:
    """Read a machine file with the intervals of what was identified of it.

    What is identified of an axis is what its controller believes: the friction file given in ``nominal_files``, or that
    of its feedforward, and the nominal plant; what these do not tell, and an axis without them, is as the machine file
    says that it is. Flaws of the machine file are never taken for known; a second mass is, where the response shows it.

    Parameters
    ----------
    path, nominal_files, gain, lead, friction_model
        As in `fric.documents.machine_files.read_machine`.

    Raises
    ------
    FricError
        As `read_machine`; and when no parameter has an interval.
    """
    nominal_files = tuple(nominal_files)
    machine = read_machine(path, nominal_files=nominal_files, gain=gain, lead=lead, friction_model=friction_model)
    intervals: dict[str, Intervals] = {}
    covariances: dict[str, Sequence[Covariance]] = {}
    beyond: dict[str, Mapping[str, Spread]] = {}
    widened: dict[str, tuple[Notice, ...]] = {}
    axes, warnings = dict(machine.axes), []
    for name, part in read_machine_document(path, nominal_files).axes.items():
        own = part.feedforward.friction
        friction = _merged(part.friction, own) if own else part.friction
        model, axis = true_friction(friction), machine.axes[name]
        sections = {key: friction.estimates(key) for key in friction.sections()}
        found, refused = friction_intervals(model, sections)
        known = (part.nominal or part.plant).estimates(part.motion)
        plant: dict[str, Estimate] = {symbol: known[symbol] for symbol in ("A", "B", "T_d", "K_f") if symbol in known}
        if "offset" in sections.get("static", {}):
            plant["offset"] = sections["static"]["offset"]
        for symbol, estimate in plant.items():
            closed, open_ended = closed_intervals(symbol, estimate)
            found |= closed
            refused += open_ended
        if refused:
            warnings.append(NOT_DRAWN.found(f"axis {name}", names=refused))
        if found:
            intervals[name] = found
            covariances[name] = [*_together(own or part.friction), *_of_plant(part.nominal or part.plant)]
        spreads, why = discrepancies(own or part.friction, part.nominal or part.plant, refused)
        if found:
            beyond[name], widened[name] = spreads, why
        load = float(plant["offset"]) if "offset" in plant else axis.load
        spring = axis.second_mass if part.nominal is None else spring_of(part.nominal, model, part.motion)
        axes[name] = replace(
            axis, plant=axis.nominal or axis.plant, friction=model, load=load, reality=NONE, second_mass=spring
        )
    if not intervals:
        raise FricError(
            NO_INTERVAL,
            where=str(path),
            hint="Give files that `fric identify` wrote: `nominal_files='x=FRICTION.yaml'`, or in the machine file.",
        )
    return Identified(replace(machine, axes=axes), intervals, covariances, beyond, widened, tuple(warnings))


def machine_to_predict(path: Path) -> tuple[Machine, Identified | None]:
    """Read a machine file as what is known of the machine: as identified, where it has intervals.

    Raises FricError: As `read_machine`.
    """
    try:
        found = read_identified(path)
    except FricError as error:
        if error.what != NO_INTERVAL:
            raise
        return read_machine(path), None
    return found.machine, found


def _merged(of_machine: FrictionDocument, identified: FrictionDocument) -> FrictionDocument:
    """Return the friction that was identified, and what it does not tell as the machine has it."""
    return FrictionDocument.made(
        {"axis": of_machine.axis, "motion": of_machine.motion}
        | of_machine.content()
        | identified.content(*identified.sections())
    )


def _together(friction: FrictionDocument) -> Iterator[Covariance]:
    """Yield how the parameters of each section err together, by the names that they are drawn by."""
    for section in friction.sections():
        block = friction.fit_of(section).covariance if section != "at_speed" else None
        if block is not None:
            found = block.covariance()
            prefix = "negative." if section == "static_negative" else ""
            yield replace(found, names=tuple(prefix + name for name in found.names))


def _of_plant(plant: PlantPart) -> Iterator[Covariance]:
    if isinstance(plant, PlantDocument) and plant.fit is not None and plant.fit.covariance is not None:
        yield plant.fit.covariance.covariance()
