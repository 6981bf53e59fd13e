"""The YAML documents, one type a file; `fric schema TYPE` prints each as JSON Schema."""

from functools import cache
from importlib import import_module
from pkgutil import iter_modules
from typing import Any

from fric.documents.base import Document, Part, Quantity
from fric.errors import require_known
from fric.verb import verb

__all__ = ["Document", "Part", "Quantity", "document_types"]


@cache
def document_types() -> dict[str, type[Document]]:
    """Return every document type by the value of ``fric:`` in its file, without the version."""
    for module in iter_modules(__path__):
        import_module(f"{__name__}.{module.name}")
    pending: list[type[Document]] = [Document]
    found: dict[str, type[Document]] = {}
    while pending:
        document = pending.pop()
        pending += document.__subclasses__()
        if "type" in vars(document):
            found[document.type] = document
    return dict(sorted(found.items()))


@verb
def document_schema(type_name: str) -> dict[str, Any]:
    """Return the JSON Schema of a document type.

    Raises FricError: When there is no such type.
    """
    types = document_types()
    require_known(type_name, types, "there is no document type", "The types are")
    return types[type_name].json_schema()
