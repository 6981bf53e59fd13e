"""The map over feed and radius is what the circles are, one by one, on any number of processes."""

import json
from dataclasses import replace

import numpy as np
import pytest

import fric
from fric.documents import document_types
from fric.results.simulate import values_of

FEEDS, RADII = [0.05, 0.2], [0.004, 0.02]


@pytest.fixture(scope="module")
def found():
    return fric.circle_map("xy-table", "a,b,c,f", feeds=FEEDS, radii=RADII, workers=1)


def test_every_cell_is_that_circle(found):
    for row, radius in enumerate(RADII):
        own = fric.circle("xy-table", "a,c", velocity=0.05, radius=radius, revolutions=1, accuracy=0)
        for run in own.runs:
            assert found.found.of(run.scheme.name)[row, 0] == pytest.approx(run.circularity.glitch, abs=0.1e-6)


def test_processes_change_no_digit(found):
    again = fric.circle_map("xy-table", "a,b,c,f", feeds=FEEDS, radii=RADII, workers=2)
    np.testing.assert_array_equal(again.found.glitches, found.found.glitches)


def test_a_machine_of_one_axis_has_a_map():
    """The memory of its second axis was asked for, which it does not have."""
    whole = fric.read_machine("xy-table")
    alone = replace(whole, axes={"x": whole.axes["x"]})
    mapped = fric.circle_map(alone, "a", feeds=[0.2], radii=[0.004], workers=1)
    own = fric.circle(alone, "a", velocity=0.2, radius=0.004, revolutions=1, accuracy=0).runs[0]
    assert mapped.found.of("a")[0, 0] == pytest.approx(own.circularity.glitch, abs=0.1e-6)


def test_what_cannot_run_is_left_out_and_said():
    over = fric.circle_map("xy-table", "a", feeds=[0.05, 3.0], radii=[0.005], workers=1)
    assert np.isnan(over.found.glitches[0, 0, 1])
    assert np.isfinite(over.found.glitches[0, 0, 0])
    assert over.document["schemes"]["a"]["glitch"][0][1] is None
    assert any("could not run on 1 of 2 circles" in text for text in over.warnings)


def test_what_is_done_when_it_is_interrupted_is_kept(found):
    asked = iter([False, True])
    part = fric.circle_map(
        "xy-table", "a,c", feeds=FEEDS, radii=RADII, workers=1, interrupted=lambda: next(asked)
    )  # fmt: skip
    assert part.cut_short
    assert np.isfinite(part.found.glitches[:, 0]).all()
    assert np.isnan(part.found.glitches[:, 1]).all()
    np.testing.assert_array_equal(part.found.of("c")[0], found.found.of("c")[0])
    assert [why.code for why in part.warnings] == ["interrupted"]
    assert part.document["schemes"]["c"]["glitch"][1] == [None, None]
    part.report()
    part.figure()


def test_the_document_is_typed_and_tells_what_blocks_gain(found):
    tree = found.document
    read = document_types()["circle-map"].model_validate(json.loads(json.dumps(tree)))
    assert (read.feeds, read.radii) == (FEEDS, RADII)
    gain = tree["differences"]["gms over static (c against b)"]
    by_hand = np.array(tree["schemes"]["b"]["glitch"]) - np.array(tree["schemes"]["c"]["glitch"])
    np.testing.assert_allclose(gain["less"], by_hand)
    told = [line for line in found.report() if isinstance(line, str)]
    assert any(line.startswith("gms over static (c against b): less on") for line in told)


def test_the_figure_shows_the_glitches_and_frames_where_the_observer_spoils(found):
    figure = found.figure()
    panels = [axes for axes in figure.axes if axes.images]
    for panel, glitch in zip(panels, found.found.glitches, strict=True):
        np.testing.assert_allclose(panel.images[0].get_array(), glitch * 1e6)
        assert panel.get_xlabel() == "feed [mm/s]"
    spoiled = found.found.less(*found.found.pairs()["observer (f against c)"]) < 0
    assert len(panels[-1].patches) == np.count_nonzero(spoiled)


def test_ranges_and_lists_are_read():
    assert values_of("5 … 80 mm/s", "velocity", 3) == pytest.approx((0.005, 0.02, 0.08))
    assert values_of("5 mm/s ... 80 mm/s", "velocity", 2) == pytest.approx((0.005, 0.08))
    assert values_of("5, 10, 50 mm", "position") == pytest.approx((0.005, 0.01, 0.05))
    assert values_of(0.1, "velocity") == (0.1,)
    for wrong in ("0 … 5 mm", "5 … 80 kg", "-3 mm"):
        with pytest.raises(fric.FricError):
            values_of(wrong, "position")


def test_the_report_shows_a_map_where_it_was_made(found, tmp_path):
    found.save(tmp_path / "map.yaml")
    page = fric.make_report(tmp_path / "map.yaml")._repr_html_()
    assert "Glitch over feed and radius" in page
    shown = f"{found.found.of('f')[1, 0] * 1e6:.1f}"
    assert f"<td>{shown}</td>" in page
    assert all(line.split(":")[0] in page for line in found.report() if isinstance(line, str))
