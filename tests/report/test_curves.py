"""Bands of curves from the intervals of a file; points and loops from logs."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import fric
from fric.documents.friction import static_tree
from fric.documents.plant import PlantDocument
from fric.documents.yaml import read_document, write_document
from fric.errors import FricError
from fric.estimate import Covariance, Estimate
from fric.friction.gms import GMS
from fric.identify.static_map.identify import identify_static
from fric.identify.static_map.points import Asked
from fric.io.hdf5 import read_logs, write_logs
from fric.report.collect import collect
from fric.report.plots import friction_curves, friction_map, map_band, presliding, virgin_band

from .conftest import LOGS

BEFORE = Path(__file__).parents[1] / "documents" / "before"


def test_a_band_ends_where_the_only_unsure_parameter_does(files: SimpleNamespace) -> None:
    static = collect([files.march]).items[0].sections()["static"]
    only = {name: (one if name == "F_s" else type(one)(one.value, one.unit)) for name, one in static.items()}
    band = map_band(only, np.array([1e-9, 1.0]))
    assert band.low[0] == pytest.approx(163, abs=1e-3)
    assert band.high[0] == pytest.approx(167, abs=1e-3)
    assert band.low[1] == band.y[1] == band.high[1] == pytest.approx(105 + 40)  # F_s is of no account at 1 m/s


def test_the_virgin_curve_ends_at_F_s_and_begins_with_all_springs(files: SimpleNamespace) -> None:
    sections = collect([files.march]).items[0].sections()
    band = virgin_band(sections, 2e-4)
    assert band.y[-1] == pytest.approx(165)
    assert (band.low[-1], band.high[-1]) == (pytest.approx(163), pytest.approx(167))
    assert band.y[0] / band.x[0] == pytest.approx(sum(sections["gms"]["k"].value))
    assert np.all((band.low <= band.y) & (band.y <= band.high))


def test_a_friction_file_alone_gives_the_loops_of_its_model(files: SimpleNamespace) -> None:
    inputs = collect([files.march])
    curves = friction_curves(inputs, inputs.items[0])
    model = GMS.from_sections(inputs.items[0].sections())
    for cycle in curves.hysteresis:  # Masing: a branch is the virgin curve stretched by two
        amplitude = cycle.position.max()
        assert cycle.model.max() == pytest.approx(float(model.virgin_curve(amplitude)), rel=2e-3)
        assert cycle.measured is None
    assert presliding(inputs) == pytest.approx(model.slip_displacements.max())
    assert not curves.points


def test_logs_give_points_and_loops(files: SimpleNamespace) -> None:
    inputs = collect([files.march, LOGS / "constant-velocity.h5", LOGS / "presliding-sine.h5"])
    curves = friction_curves(inputs, inputs.items[0])
    assert len(curves.points) == 34
    assert curves.virgin is not None
    assert curves.virgin.measured is not None
    assert [cycle.name for cycle in curves.hysteresis] == ["presliding-sine-01", "presliding-sine-02"]
    assert all(np.abs(cycle.measured).max() > 50 for cycle in curves.hysteresis)


def test_a_record_without_a_whole_cycle_is_named_and_the_others_are_drawn(
    files: SimpleNamespace, tmp_path: Path
) -> None:
    """`identify gms` left such a record out, and the page of `auto` ended in its error."""
    logs = read_logs(LOGS / "presliding-sine.h5")
    half, mute = replace(logs[0].slice(0, len(logs[0]) // 8), name="half"), replace(logs[0], force=None, name="mute")
    write_logs(tmp_path / "sines.h5", [*logs, half, mute])
    inputs = collect([files.march, tmp_path / "sines.h5"])
    curves = friction_curves(inputs, inputs.items[0])
    assert [cycle.name for cycle in curves.hysteresis] == ["presliding-sine-01", "presliding-sine-02"]
    for name in ("half", "mute"):
        assert [note for note in curves.notes if note.startswith(f"Record '{name}' is not drawn")]


@pytest.mark.long(2)
def test_logs_are_drawn_less_the_part_of_the_plant_that_stands_in_the_file(
    files: SimpleNamespace, tmp_path: Path
) -> None:
    log, path = LOGS / "constant-velocity.h5", tmp_path / "friction.yaml"
    plant = read_document(files.plant, PlantDocument).plant("linear")
    logs = read_logs(log)
    fit = identify_static(logs, Asked(plant=plant))
    write_document(path, static_tree(fit, logs))
    inputs = collect([path, log])
    curves = friction_curves(inputs, inputs.items[0])
    assert not curves.notes
    assert curves.fitted
    assert [p.force for p in curves.points] == pytest.approx(
        [p.force - float(fit.static.estimates["offset"]) for p in fit.points], abs=1e-3
    )


@pytest.mark.long(2)
def test_of_a_file_that_tells_the_plant_in_words_logs_are_drawn_with_the_plant_file_alone(
    files: SimpleNamespace,
) -> None:
    log, before = LOGS / "constant-velocity.h5", BEFORE / "static.yaml"
    alone = collect([before, log])
    curves = friction_curves(alone, alone.items[0])
    assert not curves.points
    assert "Give the plant file too" in curves.notes[0]
    whole = collect([before, log, BEFORE / "plant.yaml"])
    assert len(friction_curves(whole, whole.of("friction", "x")).points) == 34


def test_the_band_by_the_covariance_of_the_file_is_that_of_the_fit(tmp_path: Path) -> None:
    logs = read_logs(LOGS / "constant-velocity.h5")
    fit = identify_static(
        logs, Asked(delta=1.0, direction="both", over_position="off")
    )  # intervals of nothing but the fit
    path = tmp_path / "friction.yaml"
    write_document(path, static_tree(fit, logs))
    item = collect([path]).items[0]
    curves = friction_curves(collect([path]), item)
    assert curves.fitted
    band = curves.maps["both"]
    without_offset = replace(fit.static.problem, with_offset=False)
    J, n = without_offset.jacobian(fit.static.solution.theta, band.x), len(without_offset.free)
    told = np.sqrt(np.einsum("ij,jk,ik->i", J, np.array(fit.static.covariance.matrix)[:n, :n], J))
    half = (band.high - band.low) / 2
    assert half == pytest.approx(2.045 * told, rel=0.02)  # Student's t of 29
    alone = map_band(item.sections()["static"], band.x)
    assert band.y == pytest.approx(alone.y, rel=1e-4)
    assert np.mean(half) < 0.75 * np.mean(alone.high - alone.low) / 2
    old = collect([BEFORE / "static.yaml"])  # tells no covariance
    assert not friction_curves(old, old.items[0]).fitted


def test_an_axis_that_is_not_there_is_none(files: SimpleNamespace) -> None:
    assert collect([files.march]).of("friction", "z") is None
    with pytest.raises(FricError):
        collect([files.folder / "none.yaml"])


def test_the_points_are_those_that_the_map_was_fitted_to(rig_static: fric.StaticResult, tmp_path: Path) -> None:
    """They were the raw means of the strokes, and `--plot` had those without what comes again at the same places."""
    static = rig_static
    static.save(tmp_path / "static.yaml")
    inputs = collect([tmp_path / "static.yaml", Path("data/constant-velocity.h5")])
    points = friction_curves(inputs, inputs.items[0]).points
    assert any(point.over_position for point in static.fit.points)
    offset = static.document["static"]["offset"]["value"]
    found, fitted = ([point.force for point in ones] for ones in (points, static.fit.points))
    np.testing.assert_allclose(np.array(found) + offset, fitted, rtol=1e-3)


def test_a_band_by_the_covariance_of_logarithms_is_that_of_the_values() -> None:
    """A replay gives that of logarithms: the band was too narrow by the values, and without F_c it was an error."""
    values = np.array([50.0, 70.0, 2e-3])
    names, deviation = ("F_c", "F_s", "v_s"), 0.02 * values
    ends = np.column_stack([values - 2.0 * deviation, values + 2.0 * deviation])
    static = {
        name: Estimate(value, "1", tuple(limits))
        for name, value, limits in zip(names, values.tolist(), ends.tolist(), strict=True)
    } | {"sigma": Estimate(100.0, "1"), "delta": Estimate(1.0, "1")}
    related = np.array([[1.0, 0.3, -0.2], [0.3, 1.0, 0.4], [-0.2, 0.4, 1.0]])
    speed = np.geomspace(1e-4, 0.05, 50)
    linear, logarithmic = (
        map_band(static, speed, Covariance.of(names, related * np.outer(by, by), scale))
        for by, scale in ((deviation, "linear"), (deviation / values, "log"))
    )
    assert np.allclose(linear.high - linear.low, logarithmic.high - logarithmic.low, rtol=2e-3)
    assert float(linear.high[-1] - linear.low[-1]) == pytest.approx(4.0 * deviation[0], rel=1e-3)
    without = Covariance.of(names[1:], related[1:, 1:] * np.outer(deviation[1:], deviation[1:]), "linear")
    assert np.all(map_band(static, speed, without).high >= linear.y)


def test_the_page_says_that_an_open_limit_is_not_drawn(tmp_path: Path) -> None:
    """The upper edge of the band was the curve itself where F_s had no upper limit."""
    for high, said in (("110", False), ("null", True)):
        path = tmp_path / f"{high}.yaml"
        values = f"F_c: 90 N\n  F_s: {{value: 100, unit: N, ci95: [95, {high}]}}\n  v_s: 1 mm/s\n"
        path.write_text(f"fric: friction/1\naxis: x\nstatic:\n  {values}", encoding="utf-8")
        inputs = collect([path])
        wide, *_ = friction_map(inputs.items[0], friction_curves(inputs, inputs.items[0]))
        assert ("open is not drawn" in str(wide)) == said
