"""The glitch of each scheme over feed and radius: ``fric: circle-map/1``."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from pydantic import Field

from fric.documents.base import Document
from fric.documents.quantity import Known, Part
from fric.notice import Notice
from fric.units import readable

if TYPE_CHECKING:
    from fric.arrays import Real
    from fric.simulate.over_circles import CircleMap

Rows = list[list[Known]]


class MappedScheme(Part):
    """What one scheme leaves of every circle."""

    title: str
    glitch: Rows = Field(description="a row a radius, a column a feed [m]; null where it could not run")
    failures: list[str] = Field(default_factory=list, description="why it could not")


class MapDifference(Part):
    """By how much one scheme leaves less than another."""

    scheme: str
    against: str
    less: Rows = Field(description="a row a radius, a column a feed [m]; negative where it leaves more")


class CircleMapDocument(Document):
    """What schemes leave of circles of many feeds and radii."""

    type: ClassVar[str] = "circle-map"

    machine: str
    feeds: list[float] = Field(description="[m/s]")
    radii: list[float] = Field(description="[m]")
    schemes: dict[str, MappedScheme]
    differences: dict[str, MapDifference] = Field(
        default_factory=dict, description="what blocks gain on a static map, and an observer on a feedforward"
    )

    def describe(self) -> list[str]:
        """Return where and by how much each pair of schemes differs, a sentence a pair."""
        return [self._described(name, np.array(one.less, float)) for name, one in self.differences.items()]

    def _described(self, name: str, less: Real) -> str:
        ran = np.isfinite(less)
        if not ran.any():
            return f"{name}: no circle ran with both"

        def at(place: np.intp) -> str:
            row, column = np.unravel_index(int(place), less.shape)
            by = readable(abs(float(less[row, column])), "m")
            return f"{by} at {readable(self.radii[row], 'm')} and {readable(self.feeds[column], 'm/s')}"

        better, worse = less > 0, less < 0
        text = f"{name}: less on {np.count_nonzero(better)} of {np.count_nonzero(ran)} circles"
        text += f", at most by {at(np.nanargmax(less))}" if better.any() else ""
        return text + (f"; more on {np.count_nonzero(worse)}, by {at(np.nanargmin(less))}" if worse.any() else "")


def circle_map_tree(found: CircleMap, notices: Iterable[Notice]) -> dict[str, Any]:
    """Return what schemes leave of all circles, ready to be written or printed."""
    grid = found.grid
    schemes = {
        scheme.name: {
            "title": scheme.title,
            "glitch": found.glitches[n].tolist(),
            "failures": list(dict.fromkeys(why for one in found.cells if (why := one.failures.get(scheme.name)))),
        }
        for n, scheme in enumerate(grid.schemes)
    }
    differences = {
        name: {"scheme": one.name, "against": other.name, "less": found.less(one, other).tolist()}
        for name, (one, other) in found.pairs().items()
    }
    content = {"machine": grid.machine.name, "feeds": list(grid.feeds), "radii": list(grid.radii), "schemes": schemes}
    return CircleMapDocument.made(content | {"differences": differences}, notices=notices).tree()
