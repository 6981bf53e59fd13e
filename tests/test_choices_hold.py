"""Choices do not hang on the last bit: blocks, forms, orders and winners are the same in logs that differ by rounding.

A difference of 1e-13 in B becomes one of whole counts, so that these are draws of a random quantity. With six blocks
the criterion was 186 ± 5 on `base`, 292 ± 14 with five: the chance that their order turns is below 1e-9, and so is that
of a second mass. Samples moved by one unit in the last place move scores by 1e-9, and no two here are that near.
"""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import fric

ROOT = Path(__file__).parents[1]


def moved(log, rng):
    """Return a log whose samples are each moved by one unit in the last place, or by none."""

    def by_one(values):
        return None if values is None else np.nextafter(values, values + rng.choice([-1.0, 0.0, 1.0], len(values)))

    return replace(log, position=by_one(log.position), force=by_one(log.force), input=by_one(log.input))


def choices(logs):
    """Return what was chosen in the identification of one axis' records: the plant's order, the map's form, blocks."""
    of = {kind: [log for log in logs if log.kind == kind] for kind in {log.kind for log in logs}}
    plant = fric.identify_plant(*of["frequency-response"])
    static = fric.identify_static(*of["constant-velocity"], plant=plant)
    gms = fric.identify_gms(*of["presliding-sine"], static=static, plant=plant)
    told = static.document["static"]
    return (
        sorted(plant.document.keys()), {name: bool(one.get("fixed")) for name, one in told.items()},
        static.document["fit"]["method"].partition("(errors")[0], "static_negative" in static.document,
        len(gms.document["gms"]["k"]["value"]),
    )  # fmt: skip


def bundled():
    kinds = ("frequency-response", "constant-velocity", "presliding-sine")
    return [log for kind in kinds for log in fric.read(ROOT / "data" / f"{kind}.h5")]


@pytest.mark.long(40)
def test_choices_on_the_bundled_logs_stay_where_samples_differ_by_one_ulp():
    logs, rng = bundled(), np.random.default_rng(5)
    expected = choices(logs)
    for _ in range(2):
        assert choices([moved(log, rng) for log in logs]) == expected


@pytest.mark.long(150)
@pytest.mark.parametrize("name", ["base", "filter"])
def test_choices_on_simulated_machines_stay_where_their_B_differs_by_rounding(name):
    machine = fric.read_machine(ROOT / f"configs/reality/{name}.yaml")
    axis = machine.axes["x"]
    found = []
    for n in range(6):
        again = replace(axis, plant=replace(axis.plant, B=axis.plant.B * (1 + 1e-13 * n)))
        subject = replace(machine, axes={**machine.axes, "x": again})
        kinds = ("frequency-response", "constant-velocity", "presliding-sine")
        found.append(choices([log for kind in kinds for log in fric.experiment(subject, kind, seed=1)]))
    assert found[1:] == found[:-1]


@pytest.mark.long(60)
def test_the_winner_on_the_bundled_sines_stays_where_samples_differ_by_one_ulp():
    logs, rng = fric.read(ROOT / "data/presliding-sine.h5"), np.random.default_rng(6)
    small = [log for log in logs if log.name.endswith("01")]
    found = [fric.compare(*one, models=["gms", "dahl"]) for one in (small, [moved(log, rng) for log in small])]
    first, again = (one.document for one in found)
    assert first["winner"] == again["winner"]
