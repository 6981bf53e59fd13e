"""An identified GMS model."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Annotated, Any

import numpy as np

from fric.documents.friction import FrictionDocument, gms_tree
from fric.errors import FricError
from fric.estimate import estimate_rows
from fric.identify.gms.fit import GMSFit, Replay
from fric.identify.gms.identify import identify_gms as fit_gms
from fric.log import Log
from fric.plausibility import Finding, of_amplitudes, of_friction, of_level, of_logs, settled
from fric.results.friction import IdentifiedFriction
from fric.results.given import logs_of, several, where_of
from fric.results.given_models import friction_of, plant_of
from fric.results.kinds import EncoderName, FrictionLike, LogLike, PlantLike
from fric.results.text import Piece, Table, parameters
from fric.units import readable, si_unit
from fric.verb import Kind, verb


@dataclass(frozen=True, eq=False, repr=False)
class GMSResult(IdentifiedFriction):
    """An identified GMS model."""

    fit: GMSFit
    """What was found: parameters, virgin curve, replayed records."""
    logs: Sequence[Log]
    """The records that it was found from."""
    given: FrictionDocument | None = None
    """The file of the static map that it stands on, which is carried over."""

    @cached_property
    def document(self) -> dict[str, Any]:
        """The friction file, the static map carried over."""
        return gms_tree(self.fit, self.logs, self.given)

    def brief(self) -> str:
        """Return how many blocks there are, and C."""
        fit = self.fit
        count = len(fit.alpha.value) if isinstance(fit.alpha.value, tuple) else 1
        C = f"C {readable(float(fit.C), fit.C.unit)}{' (assumed)' if fit.C.assumed else ''}"
        return f"{count} block{'s' * (count != 1)}, {C}"

    def report(self) -> list[Piece]:
        """Return alpha, k and C, why there are so many blocks, and what a replay leaves of each record."""
        fit = self.fit
        pieces: list[Piece] = [parameters({"alpha": fit.alpha, "k": fit.k, "C": fit.C}), fit.reason]
        pieces += [_replayed(record, si_unit("force", fit.motion)) for record in fit.records]
        if "assumed" in self.document["static"]["F_c"]:
            plateau = parameters({"F_s": self.document["static"]["F_s"]})
            return [*pieces, Table(("plateau", *plateau.columns[1:]), plateau.rows)]
        return [*pieces, f"alpha summed to {float(fit.alpha_sum):.4f} before it was normalised"]


def _replayed(record: Replay, force: str) -> str:
    text = f"{record.name}: replayed force misses by {readable(record.rmse, force)}"
    if record.rmse_held_out is not None:
        text += f", {readable(record.rmse_held_out, force)} over the cycles held out"
    if record.energy is not None:
        ((_, value, interval, unit),) = estimate_rows({"": record.energy})
        text += f"; energy lost per cycle {value} ({interval}) {unit}"
    done = record.record.done
    if done.inertia_share is not None:
        text += f"; inertia {done.inertia_share:.1%}, damping {done.damping_share:.1%} of the force"
    return text


@verb
def identify_gms(
    *logs: LogLike,
    static: FrictionLike | None = None,
    blocks: Annotated[int | str, Kind(metavar="N|auto|auto:N")] = "auto",
    knots: Annotated[Sequence[float] | str, Kind(str, "LIST|auto")] = "auto",
    cycles: Annotated[tuple[int, int] | str | None, Kind(str, "FIRST:LAST")] = None,
    refine: bool = True,
    plant: PlantLike | None = None,
    encoder: EncoderName = "motor",
) -> GMSResult:
    """Identify alpha, k and C of the GMS model (eqs. 3 to 6) from pre-sliding cycles, and C from sliding.

    Parameters
    ----------
    logs
        Log files of one axis. Records of kind ``presliding-sine`` and, for C, ``sliding-sine``.
    static
        Static map, from `fric identify static`; carried over. Its F_s is the unit of alpha: a `StaticMap`, its
        file, or its result. Without it the plateau of the cycles gives F_c = F_s.
    blocks
        Slip blocks: N, or up to N (6) by an information criterion.
    knots
        Knots of the virgin curve, as in '0.9 um, 26 um, 54 um'. Or as numbers [m] (the paper's way).
    cycles
        Cycles to fit, from 1; the later ones are held out and replayed.
    refine
        Refine alpha, k and C by replay along the measured motion.
    plant
        The plant, whose own linear damping is taken off. Its file or its result; its inertia is taken off, too.
    encoder
        Of two encoders, the one whose position friction is identified on.

    Raises
    ------
    FricError
        When no record has whole cycles, an amplitude is under three encoder steps, or the knots do not suit the curve.
    """
    records = logs_of(logs, encoder)
    axis, motion = records[0].axis, records[0].motion
    kept = friction_of(static, axis, motion)
    forward, backward = (None, None) if kept is None else kept.maps()
    count, most = _blocks(blocks)
    known = plant_of(plant, axis, motion)
    doubtful = settled([*of_logs(records, known), *of_amplitudes(records)])
    if forward is not None:
        doubtful += settled(of_friction(forward, motion, known.M if known else None, where_of(static)))
        doubtful += settled(of_level(records, forward.F_s))
    at = None if knots == "auto" else several(knots, "position", motion)
    if at is not None and blocks not in {"auto", len(at), str(len(at))}:
        raise FricError(f"{len(at)} knots give {len(at)} blocks, not {blocks}", hint="Leave `blocks=` out.")
    found = fit_gms(
        records,
        static=forward,
        negative=backward,
        plant=known,
        blocks=count,
        knots=at,
        refined=refine,
        cycles=_cycles(cycles),
        **({"most_blocks": most} if most else {}),
    )
    doubtful += settled(of_gms(found))
    return GMSResult(replace(found, warnings=(*found.warnings, *doubtful)), records, kept)


def of_gms(fit: GMSFit) -> Iterator[Finding]:
    """Yield what can be held against physics in a fit: its level, the travel up to sliding, stiffness, inertia."""
    where = fit.hysteresis[0].record.log.where
    if fit.curve.saturates:
        yield Finding("level", float(fit.alpha_sum), fit.motion, where)
    yield Finding("slip", float(fit.model.slip_displacements.max()), fit.motion, where)
    yield Finding("stiffness", float(np.sum(fit.k.value)), fit.motion, where)
    yield from of_friction(fit.model.static, fit.motion, None, where)


def _blocks(given: int | str) -> tuple[int | None, int | None]:
    """Return the number of blocks, or None and the most that the criterion may choose."""
    word, colon, most = str(given).partition(":")
    number = most if word == "auto" else str(given)
    if word == "auto" and not colon:
        return None, None
    if not number.isdigit() or not 1 <= int(number) <= 12:
        raise FricError(f"'{given}' is not a number of blocks", hint="Give 1 to 12, auto, or auto:8 for 8 at most.")
    return (None, int(number)) if word == "auto" else (int(number), None)


def _cycles(given: tuple[int, int] | str | None) -> tuple[int, int] | None:
    if given is None:
        return None
    first, _, last = (given if isinstance(given, str) else ":".join(map(str, given))).partition(":")
    if not (first.isdigit() and last.isdigit() and 1 <= int(first) <= int(last)):
        raise FricError(f"'{given}' is no range of cycles", hint="Write the first and the last, as in 1:5.")
    return int(first), int(last)
