"""Motions as structured text for TwinCAT and CODESYS: points in time, and a function block that runs through them.

The block gives position, velocity and acceleration at each cycle by cubic pieces (Hermite), for an axis whose setpoints
come from outside: ``MC_ExtSetPointGenFeed`` in TwinCAT, ``SMC_FollowPositionVelocity`` in CODESYS.
"""

from collections.abc import Mapping

from fric.export.motion.base import Dialect, Move, shown_scale
from fric.export.rendering import identifier, wrapped

BLOCK = """\
FUNCTION_BLOCK FB_{name}
VAR_INPUT
    instant : LREAL;
END_VAR
VAR_OUTPUT
    position : LREAL;
    velocity : LREAL;
    acceleration : LREAL;
    done : BOOL;
END_VAR
VAR
    n : DINT := 0;
    h : LREAL;
    s : LREAL;
    rise : LREAL;
    times : ARRAY[0..{last}] OF LREAL := [{times}];
    positions : ARRAY[0..{last}] OF LREAL := [{positions}];
    velocities : ARRAY[0..{last}] OF LREAL := [{velocities}];
END_VAR
IF instant < times[n] THEN
    n := 0;
END_IF;
WHILE n < {before} AND instant >= times[n + 1] DO
    n := n + 1;
END_WHILE;
h := times[n + 1] - times[n];
s := MIN(MAX((instant - times[n]) / h, 0.0), 1.0);
rise := (positions[n + 1] - positions[n]) / h;
position := positions[n] + h * s * (velocities[n]
    + s * (3.0 * rise - 2.0 * velocities[n] - velocities[n + 1]
    + s * (velocities[n] + velocities[n + 1] - 2.0 * rise)));
velocity := velocities[n] + s * (2.0 * (3.0 * rise - 2.0 * velocities[n] - velocities[n + 1])
    + s * 3.0 * (velocities[n] + velocities[n + 1] - 2.0 * rise));
acceleration := (2.0 * (3.0 * rise - 2.0 * velocities[n] - velocities[n + 1])
    + 6.0 * s * (velocities[n] + velocities[n + 1] - 2.0 * rise)) / h;
done := instant >= times[{last}];
END_FUNCTION_BLOCK
"""


def table_files(move: Move) -> Mapping[str, str]:
    """Return a move's function block; time in seconds, positions in mm or degrees around the middle of the travel."""
    scale, unit = shown_scale(move.motion)
    points = move.points
    begin, end = move.log
    last = len(points.time) - 1
    head = (
        f"(* {move.name}, axis {move.axis}: position [{unit}] over time [s], around the middle of the travel.\n"
        f"   Log from {begin:.3f} to {end:.3f} s. *)\n"
    )
    columns = {
        "times": (points.time, "{:.6f}"), "positions": (scale * points.position, "{:.9f}"),
        "velocities": (scale * points.velocity, "{:.9f}"),
    }  # fmt: skip
    texts = {name: wrapped([form.format(value) for value in values], 8) for name, (values, form) in columns.items()}
    made = BLOCK.format(name=identifier(move.name), last=last, before=last - 1, **texts)
    return {f"{move.name}.st": head + made}


TABLE = Dialect("table", "function blocks for TwinCAT and CODESYS that run through points in time", table_files)
