"""What commands are given of friction: a model of a file with the load it was found with, NAME=VALUE."""

from collections.abc import Iterable

from fric.documents.friction import FrictionDocument
from fric.errors import FricError
from fric.friction import FrictionModel, models
from fric.units import Motion, parse


def friction_and_load(document: FrictionDocument, model: str | None, record: str) -> tuple[FrictionModel, float]:
    """Return a model of a friction file, and the offset [N] that it was identified with.

    That of the record itself, where the model was fitted to it by replay; else that of the static map.

    Raises
    ------
    FricError
        When the file holds several models and none is named, or does not hold the one named.
    """
    found = document.model_names()
    if model is None:
        model = found[0] if len(found) == 1 else "static" if not found else None
    if model is None:
        raise FricError(f"the friction file holds {', '.join(found)}", hint="Name one with --model.")
    friction = document.friction(model)
    own = next((one.offset for one in document.fit_of(model).records or () if one.record == record), None)
    if own is not None:
        return friction, float(own.si("force", document.motion))
    static = document.estimates("static") if document.static else {}
    return friction, float(static["offset"]) if "offset" in static else 0.0


def parse_parameters(model: str, given: Iterable[str], motion: Motion) -> dict[str, float]:
    """Return parameters given as ``NAME=VALUE``, in SI.

    Raises
    ------
    FricError
        When there is no such parameter, or the unit does not fit.
    """
    declared = {p.name: p for parameters in models()[model].declared().values() for p in parameters}
    found = {}
    for text in given:
        name, _, value = text.partition("=")
        if name not in declared:
            raise FricError(f"{model} has no parameter '{name}'", hint=f"It has {', '.join(declared)}.")
        found[name] = parse(value, declared[name].dimension, motion)
    return found
