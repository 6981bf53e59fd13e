"""Friction models with memory: GMS by its virgin curve, others by replay."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Annotated, Any

import numpy as np

from fric.documents.friction import FrictionDocument, gms_tree, replay_tree
from fric.errors import FricError
from fric.estimate import estimate_rows
from fric.friction import models
from fric.identify.gms.fit import GMSFit, Replay
from fric.identify.gms.identify import identify_gms as fit_gms
from fric.identify.replay.replay_fit import ReplayFit, fitted_model, identify_by_replay
from fric.log import Log
from fric.plausibility import Finding, of_amplitudes, of_friction, of_level, of_logs, of_shares, settled
from fric.records.clipping import without_clipped
from fric.records.prepared import prepared, without_loaded
from fric.results.friction import IdentifiedFriction
from fric.results.given import logs_of, several, where_of
from fric.results.given_models import friction_of, plant_of
from fric.results.kinds import Count, EncoderName, FrictionLike, LogLike, PlantLike, Seed
from fric.results.text import Piece, Table, parameters
from fric.units import Motion, parse, readable, si_unit
from fric.verb import Kind, verb


@dataclass(frozen=True, eq=False, repr=False)
class GMSResult(IdentifiedFriction):
    """An identified GMS model."""

    fit: GMSFit  # The fit: parameters, virgin curve, replayed records
    logs: Sequence[Log]  # The records that it was identified from
    given: FrictionDocument | None = None  # The file of the static map that it builds upon, which is carried over

    @cached_property
    def document(self) -> dict[str, Any]:
        """The friction file, the static map carried over."""
        return gms_tree(self.fit, self.logs, self.given)

    def brief(self) -> str:
        """Return the number of blocks, and C."""
        fit = self.fit
        count = len(fit.alpha.value) if isinstance(fit.alpha.value, tuple) else 1
        C = f"C {readable(float(fit.C), fit.C.unit)}{' (assumed)' if fit.C.assumed else ''}"
        return f"{count} block{'s' * (count != 1)}, {C}"

    def report(self) -> list[Piece]:
        """Return alpha, k and C, the reason for the number of blocks, and the residual of each record in replay."""
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
        Knots of the virgin curve, as in '0.9 um, 26 um, 54 um'. Or as numbers [m]; the paper does so.
    cycles
        Cycles to fit, from 1; the later ones are held out and replayed.
    refine
        Refine alpha, k and C by replay along the measured motion.

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
    """Yield the quantities of a fit with physical bounds: level, travel up to sliding, stiffness, inertia."""
    where = fit.hysteresis[0].record.log.where
    if fit.curve.saturates:
        yield Finding("level", float(fit.alpha_sum), fit.motion, where)
    yield Finding("slip", float(fit.model.slip_displacements.max()), fit.motion, where)
    yield Finding("stiffness", float(np.sum(fit.k.value)), fit.motion, where)
    yield from of_friction(fit.model.static, fit.motion, None, where)


def _blocks(given: int | str) -> tuple[int | None, int | None]:
    """Return the number of blocks, or None and the largest number that the criterion may choose."""
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


CLIPPED = 0.1
"""Share of a record whose force may be clipped: those samples are not compared."""


@dataclass(frozen=True, eq=False, repr=False)
class ModelResult(IdentifiedFriction):
    """Any friction model, identified by replay."""

    fit: ReplayFit  # What was found
    kept: FrictionDocument | None = None  # The friction file whose static map was kept

    @cached_property
    def document(self) -> dict[str, Any]:
        """The friction file."""
        return replay_tree(self.fit, self.kept)

    def report(self) -> list[Piece]:
        """Return the parameters, and the residuals of a replay."""
        fit, sections = self.fit, self.sections()
        names = dict.fromkeys(("static", fit.model.name))
        text: list[Piece] = [parameters(sections[name], name) for name in names if name in sections]
        samples = sum(int(record.used.sum()) for record in fit.records)
        error = readable(fit.rmse, si_unit("force", fit.motion))
        return [*text, f"{samples} samples, rmse {error}, R² {fit.r2:.4f}"]


@verb
def identify_model(
    model: Annotated[str, Kind(metavar="NAME")],
    *logs: LogLike,
    static: FrictionLike | None = None,
    plant: PlantLike | None = None,
    blocks: Count = 4,
    fix: Annotated[Iterable[str] | Mapping[str, float | str], Kind(list[str], "NAME=VALUE")] = (),
    free: Annotated[Sequence[str], Kind(list[str], "NAME")] = (),
    seed: Seed = 0,
    encoder: EncoderName = "motor",
) -> ModelResult:
    """Fit any friction model to any records by replay along the measured motion.

    Parameters
    ----------
    model
        Name of the model: lugre, dahl, gms, ….
    fix
        A parameter that is not fitted: 'n=1'. Several in a list, or by name.
    free
        Fit a parameter that is held by default: delta.

    Raises
    ------
    FricError
        When there is no such model or parameter, or no sample to compare.
    """
    fitted_model(model)
    records = logs_of(logs, encoder)
    axis, motion = records[0].axis, records[0].motion
    kept = friction_of(static, axis, motion)
    taken_off = plant_of(plant, axis, motion)
    doubtful = settled([*of_logs(records, taken_off), *of_amplitudes(records)])
    records, cut = without_clipped(records, CLIPPED)
    doubtful += cut
    if kept is not None:
        doubtful += settled(of_level(records, float(kept.estimates("static")["F_s"])))
    ready, loaded = without_loaded(prepared(records, taken_off))
    doubtful += settled(
        of_shares((record.log, record.done.inertia_share, record.done.damping_share) for record in ready)
    )
    found = identify_by_replay(
        model,
        ready,
        static=kept.estimates("static") if kept else None,
        negative=kept.backward() if kept else None,
        blocks=blocks,
        fix=_fixed(model, fix, motion),
        free=free,
        seed=seed,
    )
    static = getattr(found.model, "static", None)
    if static is not None:
        doubtful += settled(of_friction(static, motion, taken_off.M if taken_off else None, records[0].where))
    return ModelResult(replace(found, warnings=(*found.warnings, *loaded, *doubtful)), kept)


def _fixed(model: str, given: Iterable[str] | Mapping[str, float | str], motion: Motion) -> dict[str, float]:
    """Return parameters given by name, or as ``NAME=VALUE``, in SI."""
    texts = given if not isinstance(given, Mapping) else [f"{k}={v}" for k, v in given.items() if isinstance(v, str)]
    numbers = {k: float(v) for k, v in given.items() if not isinstance(v, str)} if isinstance(given, Mapping) else {}
    declared = {p.name: p for parameters in models()[model].declared().values() for p in parameters}
    for text in texts:
        name, _, value = text.partition("=")
        if name not in declared:
            raise FricError(f"{model} has no parameter '{name}'", hint=f"It has {', '.join(declared)}.")
        numbers[name] = parse(value, declared[name].dimension, motion)
    return numbers
