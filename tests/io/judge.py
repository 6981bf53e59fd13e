"""What `axes_of` says of a foreign log, held against what the log is."""

from contextlib import closing
from pathlib import Path

import numpy as np

from fric.io.readers import tables
from fric.io.roles import SURE, AxisColumns, Role, axes_of
from fric.units import converts, factor
from tests.io.foreign import foreign, write


def open_roles(axis: AxisColumns) -> list[Role]:
    """Return the roles of which the column or the unit is not sure."""
    return [role for role in axis.roles.values() if min(role.likelihood, role.unit_likelihood) < SURE]


def judged(seed: int, folder: Path) -> list[tuple[str, str]]:
    """Return of each role and unit of the log of a seed whether it is right, asked or wrong."""
    log = foreign(seed)
    path = write(log, folder, seed)
    with closing(tables(path)) as found:
        table = next(found)
        axes = axes_of([table])
        values = np.column_stack([np.concatenate(c) for c in zip(*(b.columns for b in table.read(range(
            len(table.columns)))), strict=True)])  # fmt: skip
    # a .mat may give its columns in another order
    at = [int(np.argmin([np.abs(values[:, k] - log.values[:, n]).max() for k in range(values.shape[1])]))
          for n in range(log.values.shape[1])]  # fmt: skip
    said: list[tuple[str, str]] = []
    clock = next((n for n, name in log.truth.units.items() if n == 0 and not log.truth.period), None)
    for truth, motion in zip(log.truth.axes, log.truth.motions, strict=True):
        channels = {channel: at[column] for channel, column in truth.items()}
        main = channels.get("position", channels.get("velocity"))
        axis = next((one for one in axes if main in {role.column for role in one.roles.values()}), None)
        for channel, column in channels.items():
            role = axis.roles.get(channel) if axis else None
            if role is None or role.column != column:
                sure = role is not None and role.likelihood >= SURE
                said.append(("role wrong" if sure else "role wrong asked", f"{channel} {table.columns[column].name}"))
                continue
            said.append(("role right", channel))
            unit = log.units[truth[channel]]
            said.append(
                (_unit(role.unit, unit, role.unit_likelihood, motion, channel), f"{channel} {role.unit} {unit}")
            )
        if clock is not None and axis:
            time = axis.roles["time"]
            right = time.column == at[0]
            said.append(("role right" if right else "role wrong" if time.likelihood >= SURE else "role wrong asked",
                         "time"))  # fmt: skip
            if right:
                said.append((_unit(time.unit, log.units[0], time.unit_likelihood, motion, "time"),
                             f"time {time.unit} {log.units[0]}"))  # fmt: skip
    return said


def _unit(given: str, true: str, sure: float, motion: str, channel: str) -> str:
    if sure < SURE:
        return "unit asked"
    drive = {"A", "mA", "%"}
    if given in drive or true in drive:
        return "unit right" if given == true else "unit wrong"
    dimension = "position" if channel == "reference" else channel
    same = converts(given, dimension, motion) and np.isclose(
        factor(given, dimension, motion), factor(true, dimension, motion)
    )
    return "unit right" if same else "unit wrong"
