"""`fric identify plant`: eq. (1) from frequency responses, or from an ordinary motion."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, Literal

import typer

import fric
from fric.cli.console import OUT, print_json, print_table, print_warnings
from fric.cli.options import Force, Json, LogFiles, Plot
from fric.errors import FricError
from fric.units import Motion, parse, readable

RESPONSE, MOTION = "Frequency responses", "Motion"


def plant(
    logs: LogFiles,
    output: Annotated[Path, typer.Option("-o", "--output", metavar="PLANT.yaml", help="Plant file to write.")],
    method: Annotated[
        Literal["auto", "response", "motion"], typer.Option(help="From frequency responses, or from a motion.")
    ] = "auto",
    force_constant: Annotated[
        str | None, typer.Option(metavar="K_F", help='Force constant, as "548 N/V", where no force was logged.')
    ] = None,
    mass: Annotated[
        str | None,
        typer.Option(metavar="MASS", help='Moving mass where you know it, as "85 kg": K_f/B is held against it.'),
    ] = None,
    coherence: Annotated[
        float, typer.Option(min=0, max=1, help="Least coherence of a frequency.", rich_help_panel=RESPONSE)
    ] = 0.5,
    lowest: Annotated[
        str | None, typer.Option(metavar="FREQUENCY", help='Lowest frequency, as "5 Hz".', rich_help_panel=RESPONSE)
    ] = None,
    highest: Annotated[
        str | None, typer.Option(metavar="FREQUENCY", help='Highest frequency, as "300 Hz".', rich_help_panel=RESPONSE)
    ] = None,
    period: Annotated[
        str | None,
        typer.Option(metavar="TIME", help="Period of the excitation; found if not given.", rich_help_panel=RESPONSE),
    ] = None,
    segment: Annotated[
        str | None,
        typer.Option(metavar="TIME", help="Length of Welch's segments, for no period.", rich_help_panel=RESPONSE),
    ] = None,
    hold: Annotated[
        str,
        typer.Option(
            metavar="RATE|auto|none",
            help='Rate of the hold before the plant, as "4 kHz"; auto: that of a record, none for a table.',
            rich_help_panel=RESPONSE,
        ),
    ] = "auto",
    direction: Annotated[
        Literal["both", "each"],
        typer.Option(help="One friction and an offset, or friction of each direction.", rich_help_panel=MOTION),
    ] = "both",
    delay: Annotated[
        str | None,
        typer.Option(metavar="TIME", help='T_d, which no motion shows, as "0.65 ms".', rich_help_panel=MOTION),
    ] = None,
    cutoff: Annotated[
        str | None,
        typer.Option(metavar="FREQUENCY", help="Corner of the zero-phase filter.", rich_help_panel=MOTION),
    ] = None,
    decimation: Annotated[
        int | None, typer.Option(min=1, help="One sample of so many is kept.", rich_help_panel=MOTION)
    ] = None,
    border: Annotated[
        int | None, typer.Option(min=0, help="Samples left out at the start.", rich_help_panel=MOTION)
    ] = None,
    plot: Plot = None,
    json: Json = False,
    force: Force = False,
) -> None:
    """Identify the plant A, B, T_d (eq. 1) and K_f, from frequency responses or from an ordinary motion."""
    fric.refuse_existing(output, plot, force=force)
    wanted, records = fric.plant_records(
        [record for path in logs for record in fric.read_records(path)], None if method == "auto" else method
    )
    motion = records[0].motion
    K_f = _given(force_constant, "force per input", motion)
    fit: Any
    if wanted == "response":
        fit = fric.identify_plant(
            records,
            hold=None if hold in {"auto", "none"} else _given(hold, "frequency", motion),
            continuous=hold == "none",
            coherence=coherence,
            band=(_given(lowest, "frequency", motion) or 0.0, _given(highest, "frequency", motion) or float("inf")),
            period=_given(period, "time", motion),
            segment=_given(segment, "time", motion),
            given_force_constant=K_f,
            mass=_given(mass, "mass", motion),
        )
    else:
        fit = fric.identify_motion(
            [record for record in records if isinstance(record, fric.Log)],
            direction=direction,
            force_constant=K_f,
            delay=_given(delay, "time", motion),
            cutoff=_given(cutoff, "frequency", motion),
            decimation=decimation,
            border=border,
            mass=_given(mass, "mass", motion),
        )
    document = fric.plant_tree(fit, records)
    if plot:
        drawn = fric.draw_plant(fit) if wanted == "response" else fric.draw_motion(fit)
        fric.save_figure(drawn, plot, force=force)
    fric.write_document(output, document, force=force)
    if json:
        print_json(document)
    else:
        _print(document, output, plot)
    print_warnings(document["warnings"])


def _given(text: str | None, dimension: str, motion: Motion) -> float | None:
    if text is None:
        return None
    value = parse(text, dimension, motion)
    if not value > 0:
        raise FricError(f"'{text}' is not positive", mend="Give a positive value.")
    return value


def _print(document: dict[str, Any], output: Path, plot: Path | None) -> None:
    fit = document["fit"]
    columns = ("", "value", "95 % interval", "unit")
    print_table(columns, fric.estimate_rows({key: document[key] for key in _VALUES if key in document}))
    if "second_mass" in document:
        second = {name: entry for name, entry in document["second_mass"].items() if name != "encoder"}
        print_table(columns, fric.estimate_rows(second), title="second mass")
    if "parameters" in fit:
        print_table(
            (*columns, "deviation"),
            [(*row, f"{fit['parameters'][row[0]]['deviation']:.4g}") for row in fric.estimate_rows(fit["parameters"])],
        )
        OUT.print(
            f"{fit['points']} points, relative error {100 * fit['relative_error']['value']:.4f} %, "
            f"condition number {fit['condition_number']:.4f}"
        )
    else:
        for response in fit["responses"]:
            OUT.print(
                f"{response['record']}: {response['estimate']}; {response['lines']} lines used, "
                f"{readable(response['lowest']['value'], 'Hz')} to {readable(response['highest']['value'], 'Hz')}"
            )
        delay = f"transport delay {readable(fit['transport_delay']['value'], 's')}"
        if "hold_delay" in fit:
            delay += f", hold {readable(fit['hold_delay']['value'], 's')} (half a sample): together T_d"
        OUT.print(delay)
    OUT.print(f"wrote {output}" + (f" and {plot}" if plot else ""))


_VALUES = ("A", "B", "T_d", "K_f", "force_lag", "force_filter")
