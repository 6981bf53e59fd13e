"""Run files: HDF5 with ``fric = "run/1"``, a group per scheme, in it a group per axis and the metrics as attributes."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import fields
from pathlib import Path
from typing import TYPE_CHECKING, Any

import h5py
import numpy as np

from fric.compensation.base import Compensation
from fric.contour import Circularity
from fric.errors import FricError
from fric.io.hdf5 import open_file
from fric.io.output import staged
from fric.simulate.axis import Trace
from fric.simulate.circle import Circle, CircleRun

if TYPE_CHECKING:
    from numpy.typing import NDArray

FORMAT = "run/1"
UNITS = {
    "time": "s",
    "reference": "m",
    "position": "m",
    "measured": "m",
    "velocity": "m/s",
    "input": "V",
    "friction": "N",
    "feedforward": "V",
    "disturbance": "V",
}


def write_runs(path: Path, runs: Iterable[CircleRun], provenance: str = "", *, force: bool = False) -> None:
    """Write what schemes made of a circle to a run file, whole or not at all.

    Parameters
    ----------
    path
        The run file.
    runs
        One run per scheme.
    provenance
        What made the file, as JSON.
    force
        Replace a file that exists.
    """
    with staged(path, force=force) as draft, h5py.File(draft, "w") as file:
        file.attrs.update({"fric": FORMAT, "provenance": provenance})
        for run in runs:
            group = file.create_group(run.scheme.name)
            group.attrs.update({f"scheme_{key}": value for key, value in _told(run.scheme).items()})
            group.attrs.update(_told(run.circle))
            found = run.circularity
            group.attrs.update(
                {
                    "quadrants": found.quadrants,
                    "glitch": found.glitch,
                    "radial_rms": found.rms,
                    "radial_range": found.range,
                    "unit": "m",
                    "warnings": "\n".join(run.warnings),
                }
            )
            _write(group, "angle", found.angle, "rad")
            _write(group, "error", found.error, "m")
            for name, trace in run.traces.items():
                axis = group.create_group(f"axes/{name}")
                axis.attrs["saturated"] = trace.saturated
                for channel, unit in UNITS.items():
                    _write(axis, channel, getattr(trace, channel), unit)


def read_runs(path: Path) -> list[CircleRun]:
    """Read the runs of a run file, one per scheme.

    Raises
    ------
    FricError
        When it is no run file, or cut short.
    """
    with open_file(path) as file:
        found = file.attrs.get("fric", "nothing of fric's")
        if found != FORMAT:
            raise FricError(
                f"holds {found}, not {FORMAT}", where=str(path), mend="Give a file of `fric simulate circle`."
            )
        try:
            return [_read(name, group) for name, group in file.items()]
        except (OSError, KeyError) as error:
            raise FricError(f"is damaged ({error})", where=str(path), mend="Make it again.") from None


def _told(thing: Compensation | Circle) -> dict[str, Any]:
    values = {field.name: getattr(thing, field.name) for field in fields(thing)}
    return {key: value for key, value in values.items() if value is not None}


def _write(group: h5py.Group, name: str, values: NDArray[np.float64], unit: str) -> None:
    dataset = group.create_dataset(name, data=values, compression="gzip", compression_opts=1, shuffle=True)
    dataset.attrs["unit"] = unit


def _read(name: str, group: h5py.Group) -> CircleRun:
    attributes = dict(group.attrs)
    scheme = {
        field.name: _plain(attributes[f"scheme_{field.name}"])
        for field in fields(Compensation)
        if f"scheme_{field.name}" in attributes
    }
    circle = {field.name: _plain(attributes[field.name]) for field in fields(Circle)}
    first, second, third, fourth = (float(value) for value in attributes["quadrants"])
    traces = {
        axis: Trace(
            **{channel: recorded[channel][:] for channel in UNITS},
            saturated=int(recorded.attrs["saturated"]),
        )
        for axis, recorded in group["axes"].items()
    }
    return CircleRun(
        Compensation(**scheme),
        Circle(**circle),
        traces,
        Circularity(group["angle"][:], group["error"][:], (first, second, third, fourth)),
        tuple(line for line in str(attributes["warnings"]).splitlines() if line),
    )


def _plain(value: Any) -> Any:
    return value.item() if isinstance(value, np.generic) else value
