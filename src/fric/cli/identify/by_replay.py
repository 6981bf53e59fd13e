"""`fric identify MODEL`: any friction model fitted by replay, a subcommand for each that has none of its own.

The models are found by reading their files, not by importing them: `--help` needs no compiler.
"""

import re
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Annotated

import typer

import fric
from fric.cli.console import finish
from fric.cli.options import Force, Implausible, Json, LogFiles, PlantFile, Plot, option


def models_in(*folders: Path | str) -> dict[str, str]:
    """Return the models whose files are in folders: name, and the first sentence of the file's docstring."""
    found = {}
    for path in sorted(path for folder in folders for path in Path(folder).glob("*.py")):
        source = path.read_text(encoding="utf-8")
        name = re.search(r'^    name\b[^=\n]*= "(\w+)"', source, re.MULTILINE)
        if name and not re.search(r"^    identified\b[^=\n]*= False", source, re.MULTILINE):
            found[name[1]] = source.split('"""')[1].strip().splitlines()[0]
    return found


_ROOM = sys.modules.get("fric.friction")
MODELS = models_in(*(_ROOM.__path__ if _ROOM else [Path(fric.__file__).parent / "friction"]))
"""Every model that can be identified, and what it is."""


def command(name: str | None = None) -> Callable[..., None]:
    """Return the subcommand that fits one model; the one that takes its name as an option where none is given."""

    def identify(
        logs: LogFiles,
        output: Annotated[Path, option("Friction file to write.", "-o", "--output", metavar="FRICTION.yaml")],
        static: Annotated[
            Path | None, option("A friction file whose static map is kept.", metavar="FRICTION.yaml")
        ] = None,
        plant: PlantFile = None,
        blocks: Annotated[int, option("Slip blocks, for a model that has any.", min=1)] = 4,
        fix: Annotated[list[str] | None, option("A parameter that is not fitted: 'n=1'.", metavar="NAME=VALUE")] = None,
        free: Annotated[
            list[str] | None, option("Fit a parameter that is held by default: delta.", metavar="NAME")
        ] = None,
        seed: Annotated[int, option("Seed of the coarse search.", min=0)] = 0,
        model: str = typer.Option(
            ... if name is None else name, metavar="NAME", hidden=name is not None, help=f"One of {', '.join(MODELS)}."
        ),
        plot: Plot = None,
        implausible: Implausible = "error",
        json: Json = False,
        force: Force = False,
    ) -> None:
        finish(
            lambda _: fric.identify_model(
                model, *logs, static=static, plant=plant, blocks=blocks, fix=fix or (), free=free or (), seed=seed
            ),
            output, plot, json=json, force=force, doing=f"fitting {model}",
        )  # fmt: skip

    what = MODELS[name] if name else "Any friction model, to any records."
    identify.__doc__ = f"Fit by replay: {what[0].lower()}{what[1:]}"
    return identify
