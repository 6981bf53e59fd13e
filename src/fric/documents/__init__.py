"""The YAML documents, one type a file; `fric schema TYPE` prints each as JSON Schema."""

from functools import cache
from typing import Any

from fric.documents.base import Document, Part, Quantity
from fric.errors import require_known
from fric.family import files_of, named
from fric.verb import verb

__all__ = ["Document", "Part", "Quantity", "document_types"]


@cache
def document_types() -> dict[str, type[Document]]:
    """Return every document type by the value of ``fric:`` in its file, without the version."""
    files_of(__name__)
    return named(Document, "type")


@verb
def document_schema(type_name: str) -> dict[str, Any]:
    """Return the JSON Schema of a document type.

    Raises FricError: When there is no such type.
    """
    types = document_types()
    require_known(type_name, types, "there is no document type", "The types are")
    return types[type_name].json_schema()
