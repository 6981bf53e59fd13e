"""What is printed as it is: the pages of the documentation, and the JSON Schema of a document type."""

import sys
from typing import Annotated

import typer

import fric
from fric.cli.completion import topics, types
from fric.cli.console import print_json
from fric.cli.signature import argument


def schema(
    type_name: Annotated[str, argument("friction, mapping, plant, machine, …", metavar="TYPE", autocompletion=types)],
) -> None:
    """Print the JSON Schema of a document type."""
    print_json(fric.document_schema(type_name))


def manual(
    topic: Annotated[
        str | None,
        argument("A page, or the code of a warning; the list of pages, else.", metavar="TOPIC", autocompletion=topics),
    ] = None,
) -> None:
    """Show a page of the documentation, or what the code of a warning means; `fric COMMAND -h` tells of a command."""
    from fric.documents import bundled

    if topic is None:
        pages = bundled.topics()
        wide = max(map(len, pages)) + 2
        for name, path in pages.items():
            with path.open(encoding="utf-8") as file:
                title = file.readline().removeprefix("# ")
            typer.echo(f"{name:{wide}}{title}", nl=False)
        return
    if sys.stdout.isatty():
        from pydoc import pager  # costs as much as all commands' own files

        pager(bundled.page(topic))
    else:
        typer.echo(bundled.page(topic), nl=False)
