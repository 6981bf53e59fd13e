"""What circles say as plain documents, for programs: a diagnosis, and what was tuned."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from fric.identify.circle.next_circle import measured_glitch
from fric.notice import Notice

if TYPE_CHECKING:
    from fric.identify.circle.diagnose import Diagnosis
    from fric.identify.circle.glitches import Glitch
    from fric.identify.circle.tune import Tuned


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


def tuned_document(found: Tuned) -> dict[str, Any]:
    """Return what was tuned as a plain document, for programs; every number in SI."""
    axes = {}
    for name, one in found.axes.items():
        estimates = one.estimates
        sections = {} if estimates is None else {**estimates.static, **estimates.gms, **estimates.plant}
        axes[name] = {
            "parameters": {key: value.as_dict() for key, value in sections.items()},
            "residual": {"before": one.before.rms, "after": one.after.rms, "noise": one.after.noise()},
            "full_shape": one.full,
            "improves": one.improves,
        }
    predicted: dict[str, dict[str, Any]] = {}
    for ahead in found.predicted:
        entry = {"glitch": ahead.glitch, "ci95": list(ahead.ci95), "radius": ahead.radius}
        predicted.setdefault(f"{ahead.feed:g}", {})[ahead.scheme] = entry
    measured = {f"{test.feed:g}": measured_glitch(test) for test in found.tests}
    return {
        "axes": axes,
        "predicted": predicted,
        "measured": measured,
        "warnings": list(found.warnings),
        "warnings_coded": [warning.as_dict() for warning in found.warnings],
    }
