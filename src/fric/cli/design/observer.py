"""`fric design observer`: a disturbance observer as fast as the unmodelled dynamics and the whole loop allow."""

from pathlib import Path
from typing import Annotated, Literal

import fric
from fric.cli.console import finish
from fric.cli.options import (
    ControllerFile,
    Force,
    Implausible,
    Json,
    PeakSensitivity,
    PlantArgument,
    Plot,
    RecordName,
    argument,
    option,
)

Filter = Literal["binomial2", "binomial3", "binomial4", "butterworth2", "butterworth3", "umeno-hori"]


def observer(
    plant: PlantArgument,
    log: Annotated[
        Path | None,
        argument(
            "A frequency response, or a record to take it from; without it Q is held below --first-mode.",
            metavar="[LOG.h5]",
        ),
    ] = None,
    output: Annotated[
        Path | None, option("The observer file to write.", "-o", "--output", metavar="OBSERVER.yaml")
    ] = None,
    filter_name: Annotated[Filter, option("The shape of Q.", "--filter")] = "binomial2",
    controller: ControllerFile = None,
    cutoff: Annotated[
        str | None, option("Of Q, 1/(2πτ), where it is given; the largest allowed where not.", metavar="FREQUENCY")
    ] = None,
    bandwidth: Annotated[
        str | None, option("Of Q, −3 dB, where that is given instead of the cutoff.", metavar="FREQUENCY")
    ] = None,
    peak_sensitivity: PeakSensitivity = "6 dB",
    resonances: Annotated[
        list[str] | None,
        option(
            "A mode that the plant does not have, as in '280 Hz, 0.02, 0.1'; can be given more than once.",
            "--resonance",
            metavar="FREQUENCY,DAMPING[,SHARE]",
        ),
    ] = None,
    first_mode: Annotated[
        str | None,
        option("The lowest structural mode, as '80 Hz', where no response was measured.", metavar="FREQUENCY"),
    ] = None,
    record: RecordName = None,
    averages: Annotated[
        int, option("Records that a table's coherence was averaged over, for its confidence.", min=1)
    ] = 1,
    plot: Plot = None,
    view: Annotated[
        Literal["q", "bode", "nyquist", "nichols"], option("The figure that --plot draws; q is Fig. 7.")
    ] = "q",
    implausible: Implausible = "error",
    as_json: Json = False,
    force: Force = False,
) -> None:
    """Design the disturbance observer of an axis: how far its filter Q may reach.

    Two limits are told: |T·Delta| ≤ 1 at every frequency (eq. (8)), with the confidence of the response, and the
    peak sensitivity of the whole loop. The smaller is taken. Without a measured response no bandwidth is recommended: Q
    is held below the first mode, as --first-mode says or as it is assumed.
    """
    finish(
        lambda _: fric.design_observer(
            plant, log, filter=filter_name, controller=controller, cutoff=cutoff, bandwidth=bandwidth,
            peak_sensitivity=peak_sensitivity, resonances=resonances or (), first_mode=first_mode, record=record,
            averages=averages, view=view,
        ),
        output, plot, json=as_json, force=force,
    )  # fmt: skip
