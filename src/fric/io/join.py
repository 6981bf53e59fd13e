"""Channels that were logged in separate files by one clock, as one table."""

from collections.abc import Sequence
from dataclasses import replace

from fric.columns import CHANNELS
from fric.errors import FricError
from fric.io.channels import Origin, Plan
from fric.io.readers.base import Table
from fric.io.readers.joined import Joined, Part


def joined(files: Sequence[tuple[Table, Plan]]) -> tuple[Joined, Plan]:
    """Return one table of the channels of several files, and what its columns mean.

    files: Table and plan of each file; each plan has a time and the channels that the file holds.
    Raises FricError: When a channel is in two files, none has a position or velocity, or a file logged no time.
    """
    parts: list[Part] = []
    origins = {"time": Origin(0, 1.0)}
    names, holders, stated = ["time"], dict[str, str](), frozenset[str]()
    for table, plan in files:
        own = {name: origin for name, origin in plan.origins.items() if name != "time"}
        time = plan.origins["time"].column
        if time is None or any(origin.column is None for origin in own.values()):
            raise FricError(
                "has no time of its own, and files are joined by the time that each logged", where=str(table.path),
                hint="Write the time into the file, or join files that have it.",
            )  # fmt: skip
        columns = tuple(dict.fromkeys(origin.column for origin in own.values() if origin.column is not None))
        parts.append(Part(table, time, columns, plan.origins["time"].factor, table.path.stem))
        for name, origin in own.items():
            if name in holders:
                raise FricError(
                    f"{name} is in {holders[name]} and in {table.path.name}", where="`join=True`",
                    hint=f"Say in a mapping which is meant, as in `{name}: {{column: …, file: \"NAME*\"}}`.",
                )  # fmt: skip
            holders[name] = table.path.name
            assert origin.column is not None
            origins[name] = replace(origin, column=len(names) + columns.index(origin.column))
        names += [f"{table.path.name}: {table.columns[column].name}" for column in columns]
        stated |= plan.stated
    if not {"position", "velocity"} & origins.keys():
        raise FricError(
            "no file holds position or velocity", where=", ".join(str(table.path) for table, _ in files),
            hint="Name the columns so, or map them.",
        )  # fmt: skip
    ranked = [origins[name].column for name in CHANNELS if name in origins]
    wanted = tuple(dict.fromkeys(column for column in ranked if column is not None))
    first = files[0][0]
    table = Joined(first.path, parts, first.constants, first.said)
    return table, Plan(files[0][1].motion, origins, wanted, tuple(names), "time", stated)
