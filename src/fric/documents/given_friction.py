"""What commands are given of friction: a static map of a file, a model with the load it was found with, NAME=VALUE."""

from collections.abc import Iterable
from dataclasses import dataclass

from fric.documents.friction import FrictionDocument
from fric.errors import FricError
from fric.friction import FrictionModel, models
from fric.friction.stribeck import StaticMap
from fric.units import Motion, parse


@dataclass(frozen=True)
class GivenStatic:
    """A static map from a friction file, and the file.

    Parameters
    ----------
    static
        The map; that of the positive direction where each has its own.
    negative
        That of the negative direction, where each has its own.
    document
        The file.
    """

    static: StaticMap
    negative: StaticMap | None
    document: FrictionDocument


def given_static(document: FrictionDocument) -> GivenStatic:
    """Return the static map of a friction document.

    Raises
    ------
    FricError
        When it holds none.
    """
    if not document.section("static"):
        raise FricError(
            f"the friction of axis {document.axis} holds no static map",
            hint="Make one with `fric identify static`, or leave --static out.",
        )
    try:
        forward = StaticMap.from_sections({"static": document.estimates("static")})
        return GivenStatic(forward, document.backward(), document)
    except (FricError, TypeError) as error:
        raise FricError(f"static: {error}") from None


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
