"""What records hold: kinds, the names of channels and columns, and the dimension of each."""

from typing import Literal, get_args

Kind = Literal[
    "constant-velocity", "presliding-sine", "micro-steps", "sliding-sine", "frequency-response", "motion",
    "force-velocity", "holding-map",
]  # fmt: skip
KINDS: tuple[Kind, ...] = get_args(Kind)
PRESLIDING = frozenset({"presliding-sine", "micro-steps"})  # Kinds that go back and forth before sliding
CHANNELS = ("time", "position", "velocity", "force", "input", "reference", "added", "load_position", "mode")
"""What a record in time can hold; each is a dimension of `fric.units`, or has that of another channel."""
RESPONSE_DIMENSIONS = {  # The columns of a measured frequency response, and the dimension of each
    "frequency": "frequency", "magnitude": "position per input", "phase": "angle", "coherence": "ratio",
    "deviation": "ratio",
}  # fmt: skip
FORCE_VELOCITY: Kind = "force-velocity"  # The kind of a table of mean forces at constant velocities
FORCE_VELOCITY_DIMENSIONS = {  # The columns of such a table, and the dimension of each
    "velocity": "velocity", "force": "force", "deviation": "force", "error": "force", "n": "ratio",
}  # fmt: skip
CIRCLE = "circle"  # The kind of a circle test: of two axes, whose channels are named ``x.position``, or of a ball bar
CIRCLE_CHANNELS = ("reference", "position", "input", "force")  # Of each axis of a circle test, beside the time
LARGEST_TURN = 2.0**53  # Counts after which an angle begins again, at most: a double tells no more apart
BALL_BAR = {"angle": "rad", "deviation": "m"}  # What a ball bar measures: angle and radial deviation


def channel_dimension(channel: str) -> str:
    """Return the dimension (see `fric.units`) of a channel of a record, or of a column of a frequency response.

    A channel of one axis of a circle test is named with it, as ``x.position``; a ball bar's are `BALL_BAR`; a column of
    a table of forces and velocities is named with its kind, as ``force-velocity.deviation``.
    """
    if channel == "ball-bar.deviation":
        return "position"
    if channel.startswith(f"{FORCE_VELOCITY}."):
        return FORCE_VELOCITY_DIMENSIONS[channel.rpartition(".")[2]]
    channel = channel.rpartition(".")[2]
    alike = {"reference": "position", "added": "input", "load_position": "position", "mode": "ratio"}
    return alike.get(channel) or RESPONSE_DIMENSIONS.get(channel, channel)


def is_circle_channel(channel: str) -> bool:
    """Return whether a circle test can have a channel: ``time``, ``AXIS.position``, …, ``angle``, ``deviation``."""
    axis, dot, name = channel.partition(".")
    return channel in ("time", *BALL_BAR) or bool(axis and dot and name in CIRCLE_CHANNELS)
