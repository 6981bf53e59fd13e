"""Points of the map from a table of mean forces at velocities, as `fric ingest` reads one."""

from collections.abc import Sequence

import numpy as np

from fric.arrays import Real
from fric.drive.plant import Plant
from fric.identify.static_map.map_fit import SpeedPoint
from fric.log import ForceVelocity
from fric.notice import Notice
from fric.units import readable


def standard_errors(table: ForceVelocity) -> Real:
    """Return the standard error of each mean [N], shape (n,).

    As the table says; else the deviation over √n; else the deviation itself, which is the most that it can be; 0 where
    nothing is known, and the scatter of the means about the map is then all their error.
    """
    if table.error is not None:
        return table.error
    if table.deviation is None:
        return np.zeros_like(table.force)
    return table.deviation if table.n is None else np.asarray(table.deviation / np.sqrt(table.n))


def table_points(tables: Sequence[ForceVelocity], plant: Plant | None = None) -> tuple[list[SpeedPoint], list[str]]:
    """Return a point for each row that moves, and what there is to say of the tables.

    Parameters
    ----------
    tables
        The tables.
    plant
        Where given, its linear damping ``K_f·(A/B)·v`` is taken off the force.
    """
    points: list[SpeedPoint] = []
    notices: list[str] = []
    damping = plant.damping if plant else 0.0
    for table in tables:
        errors = standard_errors(table)
        counts = np.ones_like(table.force) if table.n is None else table.n
        for row, (v, F, error, n) in enumerate(zip(table.velocity, table.force, errors, counts, strict=True)):
            if v != 0.0 and np.isfinite([v, F, error]).all():
                name = f"{table.name}, row {row + 1}"
                points.append(SpeedPoint(float(v), float(F - damping * v), float(error), int(n), name, 0.0, 0.0))
        if still := int(np.count_nonzero(table.velocity == 0.0)):
            text = f"{still} rows of '{table.name}' are at rest, where friction has no one value: they are left out"
            notices.append(Notice(text, "rows-at-rest", "note"))
        notices += _error_notices(table)
    return points, notices


def _error_notices(table: ForceVelocity) -> list[Notice]:
    if table.error is not None:
        return []
    if table.deviation is None:
        text = f"'{table.name}' tells no errors: the scatter of its means about the map is taken for them"
    elif table.n is None:
        text = f"'{table.name}' tells deviations and no n: each is taken for the error of its mean, the most it can be"
    else:
        most = readable(float(standard_errors(table).max()), table.unit("force"), 2)
        text = (
            f"'{table.name}': the errors of its means are deviation/√n, {most} at most, as if its samples were "
            "independent; what they scatter beyond that is allowed for"
        )
    return [Notice(text, "errors-of-means", "note")]
