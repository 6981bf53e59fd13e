"""`fric design observer`: a disturbance observer as fast as the unmodelled dynamics and the whole loop allow."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, Literal

import typer

import fric
from fric.cli.console import OUT, print_json, print_table, print_warnings
from fric.cli.design.shared import PlantArgument, print_margins, print_written
from fric.cli.options import Force, Json, Plot
from fric.errors import FricError

Filter = Literal["binomial2", "binomial3", "binomial4", "butterworth2", "butterworth3", "umeno-hori"]


def observer(
    plant_file: PlantArgument,
    log: Annotated[
        Path | None,
        typer.Argument(
            metavar="[LOG.h5]",
            help="A frequency response, or a record to take it from; without it the plant's delay is all.",
        ),
    ] = None,
    output: Annotated[
        Path | None, typer.Option("-o", "--output", metavar="OBSERVER.yaml", help="The observer file to write.")
    ] = None,
    filter_name: Annotated[Filter, typer.Option("--filter", help="The shape of Q.")] = "binomial2",
    controller: Annotated[
        Path | None,
        typer.Option(metavar="CONTROLLER.yaml", help="The controller; by `fric design controller` where not given."),
    ] = None,
    cutoff: Annotated[
        str | None,
        typer.Option(metavar="FREQUENCY", help="Of Q, 1/(2πτ), where it is given; the largest allowed where not."),
    ] = None,
    bandwidth: Annotated[
        str | None, typer.Option(metavar="FREQUENCY", help="Of Q, −3 dB, where that is given instead of the cutoff.")
    ] = None,
    peak_sensitivity: Annotated[
        str, typer.Option(metavar="GAIN", help="Ms that the whole loop may have at most.")
    ] = "6 dB",
    resonances: Annotated[
        list[str] | None,
        typer.Option(
            "--resonance",
            metavar="FREQUENCY,DAMPING[,SHARE]",
            help="A mode that the plant does not have, as in '280 Hz, 0.02, 0.1'; can be given more than once.",
        ),
    ] = None,
    record: Annotated[str | None, typer.Option(metavar="NAME", help="The record of LOG.h5 that holds it.")] = None,
    averages: Annotated[
        int, typer.Option(min=1, help="Records that a table's coherence was averaged over, for its confidence.")
    ] = 1,
    plot: Plot = None,
    view: Annotated[
        Literal["q", "bode", "nyquist", "nichols"], typer.Option(help="The figure that --plot draws; q is Fig. 7.")
    ] = "q",
    as_json: Json = False,
    force: Force = False,
) -> None:
    """Design the disturbance observer of an axis: how far its filter Q may reach.

    Two limits are told: |T·Delta| ≤ 1 at every frequency (eq. (8)), with the confidence of the response, and the
    peak sensitivity of the whole loop. The smaller is taken.
    """
    fric.refuse_existing(output, plot, force=force)
    document = fric.read_document(plant_file, fric.PlantDocument)
    motion, plant = document.motion, document.linear(document.motion)
    warnings: list[str] = []
    logs: list[fric.Log | fric.FrequencyResponse] = []
    if controller is None:
        cascade = fric.design_cascade(plant).cascade
        warnings.append("no controller was given: taken is the one that `fric design controller` gives by default")
    else:
        given = fric.read_document(controller, fric.ControllerDocument)
        fric.refuse_other_axis("controller", (given.axis, given.motion), (document.axis, motion), str(controller))
        cascade = given.cascade(motion)
    if log is not None:
        if resonances:
            raise FricError("a measured response has its resonances", mend="Leave LOG.h5 or --resonance out.")
        measured = _record(log, record)
        fric.refuse_other_axis("log", (measured.axis, measured.motion), (document.axis, motion), str(log))
        logs.append(measured)
        if isinstance(measured, fric.FrequencyResponse):
            Delta = fric.measured_perturbation(measured, plant, averages=averages)
        else:
            response = fric.measure_response(measured)
            warnings += response.warnings
            Delta = fric.measured_perturbation(response.table, plant, sampling=response.sampling)
    else:
        Delta = fric.model_perturbation(plant, cascade.sampling / 2, [_resonance(text) for text in resonances or []])
    if cutoff and bandwidth:
        raise FricError("cutoff and bandwidth are two names of one choice", mend="Give one of them.")
    wanted = fric.parse(cutoff, "frequency") if cutoff else None
    if bandwidth:
        wanted = fric.QFilter.of_bandwidth(filter_name, fric.parse(bandwidth, "frequency")).cutoff
    design = fric.design_observer(
        plant,
        cascade,
        filter_name,
        cutoff=wanted,
        peak_sensitivity=fric.parse_gain(peak_sensitivity),
        perturbation=Delta,
    )
    tree = fric.observer_tree(design, document.axis, motion, logs)
    tree["warnings"] = [*warnings, *tree["warnings"]]
    loops = design.loops()
    if output:
        fric.write_document(output, tree, force=force)
    if plot:
        draw = {"bode": fric.bode_figure, "nyquist": fric.nyquist_figure, "nichols": fric.nichols_figure}
        nyquist = cascade.sampling / 2
        figure = fric.q_filter_figure(design) if view == "q" else draw[view](loops.values(), nyquist)
        fric.save_figure(figure, plot, force=force)
    print_warnings(tree["warnings"])
    if as_json:
        print_json(tree)
        return
    OUT.print(f"Q  {tree['filter']}, cutoff {_hertz(tree['cutoff'])}, −3 dB at {_hertz(tree['bandwidth'])}")
    OUT.print(f"   {tree['reason']}")
    titles = {"robust": "|T·Delta| ≤ 1, eq. (8)", "sensitive": f"Ms ≤ {peak_sensitivity} of the whole loop"}
    print_table(
        ["limit", "cutoff", "bandwidth"],
        [
            [titles[name], *(_hertz(found.get(key)) for key in ("cutoff", "bandwidth"))]
            for name, found in tree["limits"].items()
        ],
    )
    print_margins(tree["margins"], {name: loop.title for name, loop in loops.items()})
    print_written(output, plot)


def _hertz(quantity: dict[str, Any] | None) -> str:
    return "–" if quantity is None else f"{quantity['value']:.4g} Hz"


def _record(path: Path, name: str | None) -> fric.Log | fric.FrequencyResponse:
    """Return the record with the measured response or its excitation, by name where there are several."""
    found = [
        one
        for one in fric.read_records(path)
        if (one.name == name if name else isinstance(one, fric.FrequencyResponse) or one.kind == "frequency-response")
    ]
    if len(found) != 1:
        told = f"{len(found)} records " + (f"of the name '{name}'" if name else "of a frequency response")
        raise FricError(
            f"there are {told}, where one is asked", where=str(path), mend="Name the one with --record, or ingest it."
        )
    return found[0]


def _resonance(text: str) -> fric.Resonance:
    """Parse ``FREQUENCY,DAMPING[,SHARE]``."""
    frequency, *rest = (part.strip() for part in text.split(","))
    try:
        numbers = [float(part) for part in rest]
    except ValueError:
        numbers = []
    if not 1 <= len(numbers) <= 2:
        raise FricError(
            f"'{text}' is no resonance", mend="Write frequency, damping and share, as in '280 Hz, 0.02, 0.1'."
        )
    return fric.Resonance(fric.parse(frequency, "frequency"), *numbers)
