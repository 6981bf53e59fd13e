"""`fric diagnose`: a measured circle taken apart, and held against a machine file."""

from pathlib import Path
from typing import Annotated

import fric
from fric.cli.console import finish
from fric.cli.options import Force, Implausible, Json, Plot, SchemesFile, argument, option

CircleFiles = Annotated[
    list[Path], argument("Circle tests, or run files of `fric simulate circle`.", metavar="CIRCLE.h5…")
]


def diagnose(
    circles: CircleFiles,
    machine: Annotated[Path | None, option("Predict the circle beside it.", metavar="MACHINE.yaml")] = None,
    scheme: Annotated[str | None, option("Scheme of a run file; or the one that was on, for the prediction.")] = None,
    schemes: SchemesFile = None,
    feed: Annotated[str | None, option("Of several tests in a file, those at this feed.")] = None,
    plot: Plot = None,
    force: Force = False,
    implausible: Implausible = "error",
    json: Json = False,
) -> None:
    """Take a measured circle apart: geometry, control loops, backlash, friction glitches, and the figures of ISO 230-4.

    Both directions of one circle, in one file or two, tell more than one. With --machine the glitches that the machine
    file predicts stand beside those measured; a difference is told with its likely cause.
    """
    finish(
        lambda advance: fric.diagnose(
            *circles, machine=machine, scheme=scheme, known=schemes, feed=feed, advance=advance
        ),
        None, plot, json=json, force=force, doing="predicting",
    )  # fmt: skip
