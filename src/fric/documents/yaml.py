"""YAML documents (``fric: TYPE/1``): read with line numbers for errors, validated, written for people."""

import io
import re
import warnings
from collections.abc import Mapping, Sequence
from functools import lru_cache
from pathlib import Path
from typing import Any, TypeVar

from pydantic import ValidationError
from ruamel.yaml import YAML
from ruamel.yaml.comments import CommentedMap, CommentedSeq
from ruamel.yaml.error import MantissaNoDotYAML1_1Warning, ReusedAnchorWarning, YAMLError

from fric.documents.base import Document
from fric.documents.bundled import located
from fric.errors import FricError, clean, near, printable, reworded
from fric.estimate import as_filed
from fric.input import foreign, other_kind, regular
from fric.output import refuse_ending, written

D = TypeVar("D", bound=Document)
MOST_BYTES, MOST_NODES, MOST_DEPTH = 2 << 20, 40_000, 40  # Most bytes, values and nested keys of a document
_HALF = re.compile(r"\\(u|U0000)[dD][89a-fA-F][0-9a-fA-F]{2}")  # of no encoding; in pairs neither
_DEEP = re.compile(rf"(?:[\[{{][^\[\]{{}}'\"#]{{0,200}}+){{{MOST_DEPTH + 1}}}")
"""Depth of nested lists or keys: the parser takes seconds to give up on more."""
KEYS = frozenset({"missing", "extra_forbidden"})  # Types of errors whose last place is a key
_KEYS = re.compile(r":\s|^\s*-\s", re.MULTILINE)


def _yaml() -> YAML:
    yaml = YAML(typ="rt")
    yaml.width = 140
    yaml.default_flow_style = False
    return yaml


def read_document(path: Path | str, model: type[D]) -> D:
    """Read a YAML document and validate it against its schema.

    A document may name other files, beside it or by a whole path: they are read too.
    """
    path = located(Path(path), model.type)
    if not isinstance(tree := read_tree(path, model.type), CommentedMap):
        raise FricError("is not a YAML document", where=str(path), hint=f"Start it with 'fric: {model.type_name()}'.")
    if (found := tree.get("fric")) is None:
        raise FricError("does not say what it is", where=str(path), hint=f"Start it with 'fric: {model.type_name()}'.")
    if found != model.type_name():
        raise other_kind(path, str(found), model.type_name())
    try:
        return model.model_validate(plain(tree), context={"folder": path.parent})
    except ValidationError as error:
        raise _described(error, tree, path, model) from None
    except FricError as error:
        raise error.at(str(path)) from None


def read_text(text: str, model: type[D]) -> D:
    """Return the document of a text that fric made; a `FricError` says what of it does not fit, as of a file."""
    try:
        return model.model_validate(plain(_tree(text)))
    except ValidationError as error:
        raise _described(error, _tree(text), Path(f"the {model.type} proposed"), model) from None


@lru_cache(maxsize=64)
def _tree(text: str) -> Any:
    """Return the content of a YAML text; a machine with its parts is read many times, and the parser is slow."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", MantissaNoDotYAML1_1Warning)  # 1e-3 is a number in YAML 1.1 too
        warnings.simplefilter("error", ReusedAnchorWarning)  # which of two values an alias then means is a guess
        return _yaml().load(text)


def read_tree(path: Path, wanted: str = "YAML") -> Any:
    """Read a YAML file of a type, with line numbers; the result is shared, and `plain` copies it."""
    path = regular(Path(path))
    with path.open("rb") as file:
        binary = file.read(4) == b"\x89HDF"
    if binary:
        hint = f"`fric inspect {path}` takes a log, `fric diagnose {path}` a circle or a run."
        raise FricError(f"is a log, a circle or a run, and a {wanted} file is needed", where=str(path), hint=hint)
    regular(path, MOST_BYTES)
    with foreign(path, "Mend it, or make it again."):
        try:
            text = path.read_text(encoding="utf-8")
            if _DEEP.search(text):
                raise FricError(f"nests deeper than {MOST_DEPTH}", hint="Write it flatter.")
            if max(len(_KEYS.findall(text)), text.count(",")) > MOST_NODES:  # the parser takes 0.1 ms a value
                raise FricError(f"holds over {MOST_NODES} values", hint="Is it a document of fric?")
            if _HALF.search(text):
                raise FricError("holds half of a character, as \\ud800", hint="Write it in UTF-8.")
            return _tree(text)
        except UnicodeDecodeError:
            raise FricError("is not a YAML document in UTF-8", hint="Save it as UTF-8.") from None
        except ReusedAnchorWarning as error:
            name = str(error).partition("anchor ")[2].partition("\n")[0]
            what = f"names two places with one anchor, {printable(name, 40)}"
            raise FricError(what, hint="Give each its name.") from None
        except YAMLError as error:
            mark = getattr(error, "problem_mark", None)
            where = f"{path}, line {mark.line + 1}, column {mark.column + 1}" if mark else ""
            what = f"is not YAML: {getattr(error, 'problem', None) or error}"
            hint = "Look there, and a line above: at spaces, brackets and quotes."
            raise FricError(what, where=where, hint=hint) from None


def dump(tree: Mapping[str, Any]) -> str:
    """Return a document as YAML text: a quantity on one line, everything else in blocks."""
    buffer = io.StringIO()
    _yaml().dump(_styled(tree), buffer)
    return buffer.getvalue()


def write_document(path: Path, tree: Mapping[str, Any], *, force: bool = False) -> None:
    """Write a document whole or not at all."""
    refuse_ending(Path(path), "YAML")
    written(Path(path), dump(tree), force=force)


def plain(tree: Any) -> Any:
    """Return a loaded tree as plain dicts, lists and scalars."""
    nodes = 0

    def taken(node: Any, depth: int) -> Any:
        nonlocal nodes
        nodes += 1
        if nodes > MOST_NODES or depth > MOST_DEPTH:
            hint = "Write it without aliases."
            raise FricError(f"holds over {MOST_NODES} values, or nests deeper than {MOST_DEPTH}", hint=hint)
        if isinstance(node, Mapping):
            return {str(key): taken(value, depth + 1) for key, value in node.items()}
        if isinstance(node, list | tuple):
            return [taken(value, depth + 1) for value in node]
        return next((scalar(node) for scalar in (bool, int, float, str) if isinstance(node, scalar)), node)

    return taken(tree, 0)


def _styled(tree: Any, depth: int = 0) -> Any:
    if isinstance(tree, Mapping):
        styled = CommentedMap({key: _styled(value, depth + 1) for key, value in tree.items()})
        if "value" in tree or (depth >= 3 and not any(isinstance(v, Mapping) for v in tree.values())):
            styled.fa.set_flow_style()
        return styled
    if isinstance(tree, str):
        return clean(tree)
    if isinstance(tree, Sequence):
        sequence = CommentedSeq([_styled(value, depth + 1) for value in tree])
        words = all(isinstance(value, str) and " " not in value for value in sequence)
        if words or all(isinstance(value, int | float | list) for value in sequence):
            sequence.fa.set_flow_style()
        return sequence
    return as_filed(tree)


def _described(error: ValidationError, tree: CommentedMap, path: Path, model: type[Document]) -> FricError:
    """Turn the first error of the schema into a line with its place in the file."""
    # a misspelled key is also a missing key: the first is what the user sees
    complaint = min(error.errors(), key=lambda item: item["type"] != "extra_forbidden")
    message = reworded(complaint["msg"])
    named, colon, rest = message.partition(": ")
    within: list[str] = []
    if colon and " " not in named:  # a check of the whole document names the place in its message
        within, message = named.split("."), rest
    place: list[str] = []
    node: Any = tree
    line: int | None = None
    for step in (*complaint["loc"], *within):
        try:
            key: Any = int(step) if isinstance(node, CommentedSeq) else step
            at = node.lc.key(key)[0] + 1 if isinstance(node, CommentedMap) else node.lc.item(key)[0] + 1
            node, line = node[key], at
            place.append(str(step))
        except (KeyError, IndexError, ValueError, AttributeError, TypeError):
            if step in within or (complaint["type"] in KEYS and step == complaint["loc"][-1]):
                place.append(str(step))  # others are types that a value may have, and no keys
    where = f"{path}, line {line}" if line else str(path)
    what, _, hint = message.partition("\n")
    schema = f"`fric schema {model.type}` lists the keys."
    if complaint["type"] == "extra_forbidden":
        what, hint = "is not a known key here", near(place[-1], _keys(model.model_json_schema())) + schema
    elif complaint["type"] == "missing":
        what, hint = "is missing", schema
    elif complaint["type"] in {"model_type", "dict_type"}:
        what, hint = "takes keys, as in {key: value}, and not one value", schema
    return FricError(f"{'.'.join(place)}: {what}" if place else what, where=where, hint=hint or schema)


def _keys(schema: Any) -> set[str]:
    """Return every key that a JSON Schema knows, at any depth."""
    if isinstance(schema, list):
        return set().union(*map(_keys, schema))
    if not isinstance(schema, dict):
        return set()
    keys = set(schema["properties"]) if isinstance(schema.get("properties"), dict) else set()
    return keys.union(*map(_keys, schema.values()))
