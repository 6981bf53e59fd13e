"""Experiments before they are made: records that determine friction within limits of the axis."""
