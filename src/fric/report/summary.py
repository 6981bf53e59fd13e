"""The few words of a report that a command prints, for people and for programs."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from fric.report.advice import advise
from fric.report.curves import presliding
from fric.report.drift import document_changes, glitch_changes, told
from fric.units import readable

if TYPE_CHECKING:
    from fric.report.material import Material


def report_document(material: Material) -> dict[str, Any]:
    """Return axes, warnings, advice and drift of a report as a plain document."""
    reach = presliding(material)
    advice = []
    for test in material.tests:
        found = advise(test, reach)
        advice.append(
            {
                "velocity": test.feed,
                "radius": test.radius,
                "scheme": found.choice.name if found.choice else None,
                "headline": found.headline,
                "reasons": list(found.reasons),
            }
        )
    changes = [(f"{after.kind} {after.axis}", document_changes(before, after)) for before, after in material.pairs]
    changes += [
        (f"glitch at {readable(after.feed, 'm/s')}", glitch_changes(before, after))
        for before, after in material.test_pairs
    ]
    drift = [
        {
            "of": of,
            "told": told(found),
            "changes": [
                {
                    "name": one.name, "unit": one.unit, "before": one.before, "after": one.after,
                    "verdict": one.verdict,
                }
                for one in found
            ],
        }
        for of, found in changes
    ]  # fmt: skip
    warnings: list[str] = [text for item in material.items for text in item.warnings]
    warnings += [text for test in material.tests for one in test.contours for text in one.warnings]
    return {"axes": material.axes(), "warnings": list(dict.fromkeys(warnings)), "advice": advice, "drift": drift}
