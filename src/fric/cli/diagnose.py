"""`fric diagnose`: a measured circle taken apart, and held against a machine file."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

import fric
from fric.cli.console import OUT, print_json, print_table, print_warnings, progress
from fric.cli.options import Force, Json, Plot, SchemesFile
from fric.estimate import in_digits
from fric.units import readable

CircleFiles = Annotated[
    list[Path], typer.Argument(metavar="CIRCLE.h5…", help="Circle tests, or run files of `fric simulate circle`.")
]


def diagnose(
    circles: CircleFiles,
    machine: Annotated[
        Path | None,
        typer.Option("--machine", metavar="MACHINE.yaml", help="Predict the circle beside it."),
    ] = None,
    scheme: Annotated[
        str | None, typer.Option("--scheme", help="Scheme of a run file; or the one that was on, for the prediction.")
    ] = None,
    schemes: SchemesFile = None,
    feed: Annotated[str | None, typer.Option(help="Of several tests in a file, those at this feed.")] = None,
    plot: Plot = None,
    force: Force = False,
    json: Json = False,
) -> None:
    """Take a measured circle apart: geometry, loops, backlash, friction glitches, and the figures of ISO 230-4.

    Both directions of one circle, in one file or two, tell more than one. With --machine the glitches that the machine
    file predicts stand beside those measured; a difference is told with its likely cause.
    """
    fric.refuse_existing(plot, force=force)
    tests = fric.both_directions(fric.choose_circles(circles, scheme), fric.parse(feed, "velocity") if feed else None)
    found = fric.diagnose(tests)
    held = None
    if machine is not None:
        known = fric.read_schemes(schemes) if schemes else None
        wanted = fric.choose_schemes(scheme or found.test.scheme or "a", known)[0]
        subject, intervals = fric.machine_to_predict(machine)
        with progress("predicting", total=fric.circles_to_predict(intervals)) as advance:
            predicted, limits = fric.predict(found, subject, wanted, intervals, done=advance)
        step = max(axis.encoder.resolution for axis in subject.axes.values())
        held = fric.agreement(found, predicted, limits, wanted.name, step)
    if plot is not None:
        fric.save_figure(fric.draw_diagnosis(found, held), plot, force=force)
    warnings = [*found.warnings, *(held.warnings if held else ())]
    print_warnings(warnings)
    document = fric.diagnosis_document(found)
    if held is not None:
        document["predicted"] = held.as_dict()
        document["scheme"] = held.scheme
        document["agrees"] = held.all_agree
        document["warnings"] = [str(warning) for warning in warnings]
        document["warnings_coded"] = [warning.as_dict() for warning in warnings]
    if json:
        print_json(document)
        return
    _print_glitches(found, held)
    _print_geometry(document, found)


def _print_glitches(found: fric.Diagnosis, held: fric.Agreement | None) -> None:
    columns = ["glitch", "µm", "95 %", "width mm", "place mm"]
    columns += ["predicted", "95 %", "agrees"] if held else []
    rows = []
    for name, glitch in found.glitches.items():
        shown, told = in_digits(glitch.value, glitch.ci95, 1e6)
        row = [name, shown, told, f"{glitch.width * 1e3:.2f}", f"{glitch.place * 1e3:.2f}"]
        if held:
            limits = held.intervals[name] if held.intervals else None
            shown, told = in_digits(held.predicted.glitches[name].value, limits, 1e6)
            row += [shown, told, "yes" if held.agrees[name] else f"no: {held.causes[name]}"]
        rows.append(row)
    test = found.test
    way = "both directions" if len(found.tests) > 1 else "counter-clockwise" if test.direction > 0 else "clockwise"
    revolutions = sum(one.count for one in found.tests)
    print_table(
        columns, rows,
        f"circle of {readable(test.radius, 'm')} at {readable(test.feed, 'm/s')}, {way}, {revolutions} revolutions",
    )  # fmt: skip


def _print_geometry(document: dict[str, Any], found: fric.Diagnosis) -> None:
    names = found.test.names
    rows = []
    for what, unit, scale, offset in (
        ("centre", "µm", 1e6, 0.0), ("scale", "ppm", 1e6, 1.0), ("backlash", "µm", 1e6, 0.0),
    ):  # fmt: skip
        for name in names:
            rows.append(_row(f"{what} {name}", document[what][name], unit, scale, offset))
    rows.append(_row("mismatch of the loops", document["mismatch"], "µm", 1e6))
    rows.append(_row("squareness", document["squareness"], "µrad", 1e6))
    rows += [[f"lag {name}", f"{lag * 1e3:.4f}", "", "ms"] for name, lag in found.lag.items()]
    for one in document["pitch"]:
        pitch = readable(one["pitch"]["value"], "m")
        rows.append(_row(f"repeats every {pitch} of {one['axis']}", one["amplitude"], "µm", 1e6))
    rows.append(["the rest, rms", f"{found.rest * 1e6:.3f}", "", "µm"])
    if found.scatter is not None:
        rows.append(["between revolutions", f"{found.scatter * 1e6:.3f}", "", "µm"])
    figures = found.figures
    rows += [[f"G {'ccw' if way > 0 else 'cw'}", f"{value * 1e6:.2f}", "", "µm"] for way, value in figures.G.items()]
    for name, value in (("G(b)", figures.G_b), ("F max", figures.F_max), ("F min", figures.F_min), ("D", figures.D)):
        if value is not None:
            rows.append([name, f"{value * 1e6:.2f}", "", "µm"])
    OUT.print()
    print_table(["", "value", "95 %", "unit"], rows)


def _row(label: str, quantity: dict[str, Any], unit: str, scale: float, offset: float = 0.0) -> list[str]:
    limits = quantity.get("ci95")
    if limits and None in limits:
        return [label, f"{(quantity['value'] - offset) * scale:.2f}", "not told", unit]
    moved = [limit - offset for limit in limits] if limits else None
    shown, told = in_digits(quantity["value"] - offset, moved, scale)
    return [label, shown, told, unit]
