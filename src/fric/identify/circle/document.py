"""A diagnosis as a plain document, for programs."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from fric.notice import Notice

if TYPE_CHECKING:
    from fric.identify.circle.diagnose import Diagnosis
    from fric.identify.circle.glitches import Glitch


def diagnosis_document(found: Diagnosis) -> dict[str, Any]:
    """Return a diagnosis as a plain document, for programs; every number in SI."""
    test, figures, geometry = found.test, found.figures, found.geometry
    names = test.names

    def plain(value: float | None, unit: str) -> dict[str, Any] | None:
        return None if value is None else {"value": value, "unit": unit}

    def per_axis(what: str) -> dict[str, Any]:
        return {name: geometry[f"{what}.{name}"].as_dict() for name in names}

    def glitches(of: Mapping[str, Glitch]) -> dict[str, Any]:
        return {
            name: {"value": g.value, "unit": "m", "ci95": list(g.ci95), "width": g.width, "place": g.place}
            for name, g in of.items()
        }

    directions = {1: "counter-clockwise", -1: "clockwise"}
    return {
        "radius": plain(test.radius, "m"),
        "feed": plain(test.feed, "m/s"),
        "direction": plain(float(test.direction), "1"),
        "revolutions": [one.count for one in found.tests],
        "centre": per_axis("centre"),
        "scale": per_axis("scale"),
        "squareness": geometry["squareness"].as_dict(),
        "backlash": per_axis("backlash"),
        "mismatch": geometry["mismatch"].as_dict(),
        "lag": {name: value.as_dict() for name, value in found.lag.items()},
        "glitch": glitches(found.glitches),
        "glitch_of": {
            directions[one.test.direction]: glitches(of)
            for one, of in zip(found.tests, found.all_glitches, strict=True)
        },
        "pitch": [
            {"axis": names[line.axis], "pitch": plain(line.pitch, "m"), "amplitude": amplitude.as_dict()}
            for line, amplitude in found.periodic
        ],
        "rest": plain(found.rest, "m"),
        "scatter": plain(found.scatter, "m"),
        "noise": plain(found.noise, "m"),
        "iso230": {
            "G": plain(max(figures.G.values()), "m"),
            "G_of": {directions[k]: plain(value, "m") for k, value in figures.G.items()},
            "G_b": plain(figures.G_b, "m"),
            "F_max": plain(figures.F_max, "m"),
            "F_min": plain(figures.F_min, "m"),
            "D": plain(figures.D, "m"),
        },
        "warnings": list(found.warnings),
        "warnings_coded": [Notice.of(warning).as_dict() for warning in found.warnings],
    }
