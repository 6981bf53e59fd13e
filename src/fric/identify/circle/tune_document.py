"""What was tuned from circles as a plain document."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from fric.identify.circle.next_circle import measured_glitch

if TYPE_CHECKING:
    from fric.identify.circle.tune import Tuned


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
