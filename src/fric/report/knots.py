"""A page, served to this computer only, to move the knots of the virgin curve by hand; and its requests."""

from collections.abc import Callable, Sequence
from typing import Any

from fric.errors import FricError
from fric.report.page import environment
from fric.report.served import LocalPage
from fric.results.identify import GMSResult
from fric.units import prefixed, si_unit

MOST_REQUEST = 16_384  # Largest size of a request [bytes]
MOST_KNOTS = 12

Fit = Callable[[Sequence[float]], "GMSResult"]  # Returns the blocks of knots [m]


class KnotPage(LocalPage):
    """A page with the virgin curve, its knots, the blocks by eq. (6), and the residual of a replay.

    start: The knots to begin with, fitted.
    fit: Fits other knots.
    """

    def __init__(self, start: GMSResult, fit: Fit) -> None:
        super().__init__(_rendered(start).encode(), MOST_REQUEST)
        self._fit = fit

    def answer(self, word: str, asked: Any) -> dict[str, Any]:
        """Return the answer to a request: ``try`` fits knots [m], ``save`` accepts them.

        Raises FricError: When the knots are not valid, or do not suit the curve.
        """
        knots = asked.get("knots") if isinstance(asked, dict) else None
        if not (
            isinstance(knots, list)
            and 0 < len(knots) <= MOST_KNOTS
            and all(isinstance(knot, int | float) and 0 < knot < 1e3 for knot in knots)
        ):
            raise FricError(f"that is no list of 1 to {MOST_KNOTS} displacements")
        ordered = sorted(float(knot) for knot in knots)
        with self.lock:
            found = _found(self._fit(ordered))
        if word == "save":
            self.end(ordered)
        return found


def _found(result: GMSResult) -> dict[str, Any]:
    """Return the content of the page about a fit: rows of blocks, and of records."""
    gms, fit = result.document["gms"], result.document["gms_fit"]
    ends = gms["alpha"].get("ci95"), gms["k"].get("ci95")
    return {
        "knots": result.fit.blocks.displacement.tolist(),
        "alpha": gms["alpha"]["value"],
        "k": gms["k"]["value"],
        "ci95": [list(pair) for pair in zip(*ends, strict=True)] if all(ends) else [],
        "records": [{"name": item["record"], "rmse": item["rmse"]["value"]} for item in fit["records"]],
        "rmse": fit["rmse"]["value"],
    }


def _rendered(start: GMSResult) -> str:
    curve, motion = start.fit.curve, start.fit.motion
    length, force, stiffness = (si_unit(name, motion) for name in ("position", "force", "stiffness"))
    units = {
        "length": prefixed(float(curve.displacement[-1]) / 10, length),
        "force": prefixed(float(curve.force.max()), force),
        "stiffness": prefixed(float(start.fit.blocks.k.max()), stiffness),
    }
    data = {
        "displacement": curve.displacement.tolist(),
        "force": curve.force.tolist(),
        "band": curve.band.tolist(),
        "units": {name: {"factor": factor, "unit": unit} for name, (factor, unit) in units.items()},
        "most": MOST_KNOTS,
        "found": _found(start),
    }
    return environment().get_template("knots.html.j2").render(axis=start.fit.axis, data=data)
