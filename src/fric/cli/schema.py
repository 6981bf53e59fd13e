"""`fric schema`: the JSON Schema of a document type, for editors."""

from typing import Annotated

import fric
from fric.cli.completion import types
from fric.cli.console import print_json
from fric.cli.options import argument


def schema(
    type_name: Annotated[str, argument("friction, mapping, plant, machine, …", metavar="TYPE", autocompletion=types)],
) -> None:
    """Print the JSON Schema of a document type."""
    print_json(fric.document_schema(type_name))
