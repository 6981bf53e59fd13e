"""What a report is made of, in one plain structure."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from fric.control.scheme import Scheme
from fric.documents import Document
from fric.documents.base import AxisDocument
from fric.documents.friction import FrictionDocument
from fric.notice import Notice

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from fric.estimate import Estimate
    from fric.log import FrequencyResponse, Log
    from fric.units import Motion

KINDS = ("friction", "plant", "controller", "observer")
"""The documents that a report tells of, in its order."""


@dataclass(frozen=True)
class Item:
    """One document: where it is from, its content as it stands in the file, and as it is understood.

    Parameters
    ----------
    source
        File that it was read from.
    kind
        ``friction``, ``plant``, ``controller`` or ``observer``.
    axis
        Name of its axis.
    tree
        The document as plain values.
    document
        The document, validated.
    """

    source: str
    kind: str
    axis: str
    tree: Mapping[str, Any]
    document: Document

    @property
    def motion(self) -> Motion:
        """Linear or rotary."""
        return "rotary" if self.tree.get("motion") == "rotary" else "linear"

    @property
    def provenance(self) -> Mapping[str, Any]:
        """What made it."""
        return self.tree.get("provenance") or {}

    @property
    def created(self) -> str:
        """When it was made, in ISO 8601; empty where it does not say."""
        return str(self.provenance.get("created", ""))

    @property
    def warnings(self) -> list[Notice]:
        """What the data could not tell."""
        return list(self.document.notices())

    def sections(self) -> dict[str, dict[str, Estimate]]:
        """Return its numbers in SI by section; a document without sections is one of its own name."""
        document = self.document
        if isinstance(document, AxisDocument):
            return {self.kind: document.estimates(self.motion)}
        assert isinstance(document, FrictionDocument)
        return {name: document.estimates(name) for name in document.sections()}


@dataclass(frozen=True, eq=False)
class Contour:
    """What one compensation scheme leaves of a contour.

    Parameters
    ----------
    scheme
        The scheme.
    glitches
        Signed glitch at each reversal [m], in the order of the test's labels.
    glitch
        The largest magnitude of them [m].
    rms, range
        Root mean square, and largest less smallest contour error [m].
    place
        Angle on the circle [rad], or station along the path [m], shape (n,); thinned.
    error
        Contour error there [m], outwards positive, shape (n,).
    warnings
        What the simulation told.
    glitch_ci95
        Between what the glitch lay on 95 % of the machines that were drawn [m], where the run tells.
    """

    scheme: Scheme
    glitches: tuple[float, ...]
    glitch: float
    rms: float
    range: float
    place: NDArray[np.float64]
    error: NDArray[np.float64]
    warnings: tuple[str, ...] = ()
    glitch_ci95: tuple[float, float] | None = None


@dataclass(frozen=True)
class ContourTest:
    """One contour followed under one or more schemes.

    Parameters
    ----------
    source
        File that it was read from.
    provenance
        What made the file.
    feed
        Speed along the contour [m/s].
    radius
        Radius of the circle [m]; None for a path.
    direction
        1 counter-clockwise, -1 clockwise.
    labels
        What each glitch stands at: the quadrants of a circle, the reversals of a path.
    contours
        One per scheme.
    """

    source: str
    provenance: Mapping[str, Any]
    feed: float
    radius: float | None
    direction: int
    labels: tuple[str, ...]
    contours: tuple[Contour, ...]

    @property
    def created(self) -> str:
        """When it was made, in ISO 8601; empty where the file does not say."""
        return str(self.provenance.get("created", ""))

    @property
    def same(self) -> tuple[Any, ...]:
        """What two tests share that can be compared."""
        return (self.radius, self.feed, self.direction, self.labels)


@dataclass(frozen=True)
class ReportInput:
    """All that was given for a report, the newest of each, and what it takes the place of.

    Parameters
    ----------
    items
        The newest document of each kind and axis.
    tests
        The newest run of each contour.
    records
        Records of logs, for measured points.
    pairs
        Earlier and newest document of one kind and axis.
    test_pairs
        Earlier and newest run of one contour.
    replaced
        Earlier documents that stand whole in a newer one, as a static map does in the file of the GMS model.
    """

    items: tuple[Item, ...] = ()
    tests: tuple[ContourTest, ...] = ()
    records: tuple[Log | FrequencyResponse, ...] = ()
    pairs: tuple[tuple[Item, Item], ...] = ()
    test_pairs: tuple[tuple[ContourTest, ContourTest], ...] = ()
    replaced: tuple[Item, ...] = ()

    def of(self, kind: str, axis: str) -> Item | None:
        """Return the document of a kind for an axis, or None."""
        return next((item for item in self.items if (item.kind, item.axis) == (kind, axis)), None)

    def axes(self) -> list[str]:
        """Return the axes that documents tell of."""
        return list(dict.fromkeys(item.axis for item in self.items))
