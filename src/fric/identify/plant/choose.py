"""Which way of identifying the plant the records of a file allow."""

from collections.abc import Sequence
from typing import Literal

from fric.errors import FricError
from fric.log import ForceVelocity, FrequencyResponse, Log, Record

Method = Literal["response", "motion"]


def plant_records(
    records: Sequence[Record], method: Method | None = None
) -> tuple[Method, list[Log | FrequencyResponse]]:
    """Return the method, and the records that serve it: frequency responses where there are any, or motions.

    Parameters
    ----------
    records
        Records of one axis.
    method
        The method, where the user asks for one; a record of any kind then serves.

    Raises
    ------
    FricError
        When no record serves, or the records are of different axes.
    """
    axes = {(record.axis, record.motion) for record in records}
    if len(axes) > 1:
        text = ", ".join(f"{axis} ({motion})" for axis, motion in sorted(axes))
        raise FricError(f"the logs are of different axes: {text}", hint="Identify one axis at a time.")
    dynamic = [r for r in records if not isinstance(r, ForceVelocity)]
    responses = [r for r in dynamic if isinstance(r, FrequencyResponse) or r.kind == "frequency-response"]
    in_time: list[Log | FrequencyResponse] = [r for r in records if isinstance(r, Log)]
    motions = [r for r in in_time if isinstance(r, Log) and r.kind in {"motion", None}]
    asked = method is not None
    method = method or ("response" if responses else "motion")
    chosen: list[Log | FrequencyResponse] = list(responses if method == "response" else motions)
    if asked and not chosen:
        chosen = in_time
    if not chosen:
        kinds = ", ".join(sorted({str(r.kind) for r in in_time if isinstance(r, Log)})) or "tables"
        raise FricError(
            f"no record is of kind frequency-response or motion (there are {kinds})",
            where=records[0].source,
            hint="Say --method response or --method motion to take them as such.",
        )
    return method, chosen
