"""Any friction model, identified by replay."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Annotated, Any

from fric.documents.friction import FrictionDocument, replay_tree
from fric.errors import FricError, near
from fric.friction import models
from fric.identify.replay.replay_fit import ReplayFit, identify_by_replay
from fric.plausibility import of_amplitudes, of_friction, of_level, of_logs, of_shares, settled
from fric.records.clipping import without_clipped
from fric.records.prepared import prepared
from fric.results.friction import IdentifiedFriction
from fric.results.given import logs_of
from fric.results.given_models import friction_of, plant_of
from fric.results.kinds import Count, EncoderName, FrictionLike, LogLike, PlantLike, Seed
from fric.results.text import Piece, parameters
from fric.units import Motion, parse, readable, si_unit
from fric.verb import Kind, verb

CLIPPED = 0.1
"""Share of a record whose force may be clipped: those samples are not compared."""


@dataclass(frozen=True, eq=False, repr=False)
class ModelResult(IdentifiedFriction):
    """Any friction model, identified by replay."""

    fit: ReplayFit
    """What was found."""
    kept: FrictionDocument | None = None
    """The friction file whose static map was kept."""

    @cached_property
    def document(self) -> dict[str, Any]:
        """The friction file."""
        return replay_tree(self.fit, self.kept)

    def report(self) -> list[Piece]:
        """Return the parameters, and what a replay leaves."""
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
    logs
        Log files of one axis. Records are taken, too.
    static
        A friction file whose static map is kept. Or its result; it is fitted too where it is not given.
    plant
        The plant, whose own linear damping is taken off. Its file or its result; its inertia is taken off, too.
    blocks
        Slip blocks, for a model that has any.
    fix
        A parameter that is not fitted: 'n=1'. Several in a list, or by name.
    free
        Fit a parameter that is held by default: delta.
    seed
        Seed of the coarse search.
    encoder
        Of two encoders, the one whose position friction is identified on.

    Raises
    ------
    FricError
        When there is no such model or parameter, or no sample to compare.
    """
    known = {name for name, model in models().items() if model.identified}
    if model not in known:
        raise FricError(
            f"there is no friction model '{model}' to fit",
            hint=f"{near(model, known)}There are {', '.join(sorted(known))}.",
        )
    records = logs_of(logs, encoder)
    axis, motion = records[0].axis, records[0].motion
    kept = friction_of(static, axis, motion)
    taken_off = plant_of(plant, axis, motion)
    doubtful = settled([*of_logs(records, taken_off), *of_amplitudes(records)])
    records, cut = without_clipped(records, CLIPPED)
    doubtful += cut
    if kept is not None:
        doubtful += settled(of_level(records, float(kept.estimates("static")["F_s"])))
    ready = prepared(records, taken_off)
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
    return ModelResult(replace(found, warnings=(*found.warnings, *doubtful)), kept)


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
