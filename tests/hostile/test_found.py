"""What a fuzzer found that knows only the documentation: a sentence each, or what can be believed."""

import dataclasses
import gzip
import io
import json
import math
import os
import re
import sys
import tracemalloc
import warnings
from collections.abc import Callable
from functools import partial
from itertools import pairwise
from pathlib import Path
from threading import Thread
from types import SimpleNamespace
from typing import Any, cast

import h5py
import numpy as np
import pandas as pd
import pint
import pytest
from nptdms import ChannelObject, TdmsWriter
from pydantic import ValidationError
from ruamel.yaml import YAML
from scipy.io import savemat
from typer.testing import CliRunner

import fric
from fric import reference
from fric.circles.diagnose import minimum_zone
from fric.circles.measured import MeasuredCircle
from fric.cli.main import app, main
from fric.control.gain_scheduled import GainScheduled
from fric.control.scheme import NONE
from fric.control.sliding_mode import SlidingMode
from fric.design.blocks import BlockDesign
from fric.design.cascade import design_cascade
from fric.documents import machine_files
from fric.documents.base import CodedWarning, CovarianceBlock, Quantity, provenance
from fric.documents.contours import CircleMapDocument
from fric.documents.controller import ControllerDocument, ObserverDocument
from fric.documents.friction import FrictionDocument
from fric.documents.mapping import MappingDocument
from fric.documents.plan import PlanDocument
from fric.documents.schemes import read_schemes
from fric.documents.yaml import read_document
from fric.drive.plant import LinearPlant
from fric.errors import FricError
from fric.estimate import Covariance, Estimate, Scale
from fric.export.sinumerik import Pulse, as_block
from fric.figures.style import new_figure, save_figure
from fric.friction.directed import Directed
from fric.friction.gms import GMS
from fric.friction.maxwell_slip import MaxwellSlip
from fric.friction.stribeck import StaticMap
from fric.identify.gms.hunting import MEMORY, _left_over
from fric.identify.replay.replay_fit import covariance_of
from fric.identify.static_map.map_fit import aged
from fric.identify.static_map.stribeck_fit import StribeckProblem
from fric.io import roles
from fric.io.circle import FEEDFORWARD, read_feedforward, read_run_provenance
from fric.io.hdf5 import read_records
from fric.io.ingest import ingest
from fric.io.ingest_circle import StatedCircle, ingest_circles
from fric.io.readers import base, matlab, tables
from fric.io.readers.ball_bar import figures
from fric.io.safe_hdf5 import BLOCK, _heaps, open_file
from fric.log import ForceVelocity, FrequencyResponse, Log
from fric.plausibility import of_friction
from fric.process import run_python
from fric.records.flaws import _around_reversals
from fric.records.motion import thinned
from fric.records.recognition import force_rises
from fric.report.collect import Contour, ContourTest, contour_test
from fric.results.base import several
from fric.simulate import contour_run, processes
from fric.simulate.axis import setting_of
from fric.simulate.contour_run import Circle, run_circle
from fric.simulate.experiment import frequency_response
from fric.units import LARGEST_PEAK, parse_gain


def test_a_dataset_in_place_of_an_axis_of_a_feedforward(tmp_path: Path) -> None:
    with h5py.File(tmp_path / "table.h5", "w") as file:
        file.attrs["fric"] = FEEDFORWARD
        file["x"] = np.zeros(9)
    with pytest.raises(FricError, match="there is no such dataset"):
        read_feedforward(tmp_path / "table.h5")


def test_a_circle_of_one_row_without_a_header(tmp_path: Path) -> None:
    (tmp_path / "a.txt").write_text("0 1.0 2.0\n")
    with pytest.raises(FricError):
        ingest_circles([tmp_path / "a.txt"], tmp_path / "a.h5", stated=StatedCircle(sampling=1e3))


def test_a_trace_in_an_encoding_that_is_unknown(tmp_path: Path) -> None:
    for encoding in ("x", "shift_jis"):
        (tmp_path / "a.xml").write_text(f'<?xml version="1.0" encoding="{encoding}"?><traceSession><traceData/>')
        with pytest.raises(FricError, match="not complete XML"):
            ingest(tmp_path / "a.xml", tmp_path / "a.h5")


def test_a_position_in_a_table_of_means(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text("t,v,F\n" + "".join(f"{n},{n},{n}\n" for n in range(9)))
    columns = {"time": {"column": "t", "unit": "s"}, "position": {"column": "v", "unit": "m"}}
    columns["force"] = {"column": "F", "unit": "N"}
    mapping = MappingDocument.model_validate({"fric": "mapping/1", "columns": columns})
    with pytest.raises(FricError, match="such a record has no position"):
        ingest(tmp_path / "a.csv", tmp_path / "a.h5", mapping=mapping, kind="force-velocity")


def test_static_friction_of_zero_ages_nothing() -> None:
    v = np.array([-0.1, -0.01, -0.001, 0.001, 0.01, 0.1])
    theta = {"F_c": 0.0, "F_s": 0.0, "v_s": 0.001, "delta": 1.0, "sigma": 1.0, "offset": 0.0}
    found = aged(StribeckProblem(v, v.copy(), np.full(6, 0.01)), cast("Any", SimpleNamespace(theta=theta)))
    assert np.isfinite(found.residual).all()


def test_a_look_at_a_reversal_begins_after_the_one_before() -> None:
    t = np.arange(1000) * 1e-3
    spans = _around_reversals(t, np.sin(9 * t), np.array([50, 51, 52, 600]))
    assert all(before[0] < after[0] for before, after in pairwise(spans))


def test_strokes_between_reversals_at_one_place() -> None:
    log = Log(np.arange(90.0), np.repeat([1.0, 2.0, 1.0], 30), force=np.sin(np.arange(90.0)), name="a")
    assert force_rises(log, np.array([0, 5, 10])) == []


def test_a_report_has_one_result_of_a_scheme() -> None:
    contour = cast("Any", SimpleNamespace(scheme=SimpleNamespace(name="a")))
    with pytest.raises(FricError, match="two results of one scheme"):
        ContourTest("a.html", {}, 0.05, 0.03, 1, (), (contour, contour))


def test_no_name_is_a_formula_or_a_control_character_of_a_figure(tmp_path: Path) -> None:
    with new_figure() as figure:
        axes = figure.subplots()
        axes.loglog([1, 10, 100], label="$\\frac{ \x1b[2J \N{GRINNING FACE}\t")
        axes.set_title("$x_1$\u202e")
        axes.legend()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        save_figure(figure, tmp_path / "a.svg")
        warnings.filterwarnings("ignore", "Glyph 128512 ")  # which tells a user of Matplotlib that the font lacks it
        figure.savefig(tmp_path / "b.png")
    assert set("\x1b\u202e").isdisjoint((tmp_path / "a.svg").read_text(encoding="utf-8"))


def test_a_measurement_of_more_channels_than_any_has(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """As 1.1 MB of 20,000 channels that took over a minute."""
    monkeypatch.setattr(base, "MOST_COLUMNS", 8)
    with TdmsWriter(tmp_path / "a.tdms") as file:
        file.write_segment([ChannelObject("g", f"c{n}", np.zeros(2)) for n in range(9)])
    with pytest.raises(FricError, match="has 9 columns"):
        ingest(tmp_path / "a.tdms", tmp_path / "a.h5")


def test_a_table_of_more_axes_than_any_machine_has(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """As 300 columns that wander, of which minutes went into what they are."""
    monkeypatch.setattr(roles, "MOST_WEIGHED", 50)
    columns = np.cumsum(np.random.default_rng(1).normal(size=(99, 20)), axis=0)
    text = "\n".join(",".join(f"{value:.4g}" for value in row) for row in columns)
    (tmp_path / "a.csv").write_text(",".join(f"c{n}" for n in range(20)) + "\n" + text)
    with pytest.raises(FricError, match="too many columns that may be an axis\nSay in a mapping"):
        fric.ingest(tmp_path / "a.csv", output=tmp_path / "a.h5")


def test_a_matlab_file_that_unpacks_to_what_no_memory_holds(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """As 3.5 MB that took 3.5 GB of memory."""
    monkeypatch.setattr(matlab, "MOST_UNPACKED", 1 << 20)
    for packed in (False, True):
        savemat(tmp_path / "a.mat", {"time": np.zeros(100_000), "position": np.zeros(100_000)}, do_compression=packed)
        with pytest.raises(FricError, match="unpacks to 2 MB"):
            ingest(tmp_path / "a.mat", tmp_path / "a.h5")


def test_a_wrong_usage_is_told_without_what_does_not_print(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(sys, "argv", ["fric", "schema", "plant", "a\u202eb\x1b[2J"])
    with pytest.raises(SystemExit) as end:
        main()
    assert end.value.code == 2
    assert set("\x1b\u202e").isdisjoint(told := capsys.readouterr().err)
    assert "unexpected extra argument" in told


def test_a_record_that_is_simulated_again_and_then_rests_leaves_a_force() -> None:
    """As a sine on coarse counts whose simulated axis did not reverse."""
    n = 2 * MEMORY
    rest = SimpleNamespace(force=np.full(n, 2.0), fitted=lambda _: np.zeros(n), used=np.ones(n, bool), reversals=[])
    assert _left_over(cast("Any", None), [cast("Any", rest)])[0] == 4.0


@pytest.mark.parametrize(("column", "row", "value"), [
    ("frequency", 0, 0.0), ("frequency", 3, 1.0), ("magnitude", 2, -1.0), ("coherence", 1, 0.0), ("coherence", 1, 60.0),
    ("deviation", 4, -0.1),
])  # fmt: skip
def test_a_response_is_held_by_its_type_to_what_every_reader_of_it_bears(column: str, row: int, value: float) -> None:
    columns = {"frequency": np.arange(1.0, 9.0), "magnitude": np.ones(8), "phase": np.zeros(8)}
    columns |= {"coherence": np.full(8, 0.9), "deviation": np.full(8, 0.1)}
    FrequencyResponse(**columns)
    columns[column][row] = value
    with pytest.raises(FricError, match=r"row|increase"):
        FrequencyResponse(**columns)


def test_cells_that_name_one_another_many_times_end(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """As 60 kB whose twelve cells of thirty references each are 10^17 parts."""
    monkeypatch.setattr(matlab, "MOST_PARTS", 100)
    with h5py.File(tmp_path / "a.mat", "w", userblock_size=512) as file:
        last = file.create_dataset("time", data=np.arange(9.0)[None])
        for n in range(3):
            cell = file.create_dataset(f"c{n}", (9, 1), h5py.ref_dtype)
            cell[:, 0] = [last.ref] * 9
            last = cell
    with (tmp_path / "a.mat").open("r+b") as raw:
        raw.write(b"MATLAB 7.3 MAT-file")
    with pytest.raises(FricError, match="over 100 parts"):
        ingest(tmp_path / "a.mat", tmp_path / "a.h5")


def test_samples_of_a_file_that_is_read_as_a_whole_are_bounded_together(tmp_path: Path) -> None:
    """As 48 MB of 180 datasets that unpack to 248 MB each."""
    with h5py.File(tmp_path / "a.h5", "w") as file:
        for name in "abc":
            file[name] = np.zeros(99)
    with open_file(tmp_path / "a.h5", most=3 * 8 * 99):
        pass
    with pytest.raises(FricError, match="more samples than are read at once"), open_file(tmp_path / "a.h5", most=2000):
        pass


def test_heaps_are_found_at_and_across_the_ends_of_blocks() -> None:
    places, mark = [0, BLOCK - 8, 2 * BLOCK - 3, 2 * BLOCK + 50], b"GCOL\1\0\0\0"
    data = bytearray(2 * BLOCK + 99)
    for place in places:
        data[place : place + 8] = mark
    assert list(_heaps(io.BytesIO(bytes(data)))) == places


@pytest.mark.parametrize("given", ["0 dB", 1.0, 0.5, "-6 dB", math.inf, "nan dB", 1e16, "40 dB"])
def test_a_peak_sensitivity_is_above_one_and_leaves_a_margin(given: str | float) -> None:
    assert parse_gain("6 dB", 1.0, LARGEST_PEAK) > 1.9
    assert parse_gain("20 dB", 1.0, LARGEST_PEAK) == pytest.approx(10.0)
    with pytest.raises(FricError, match="is not a gain above 1"):
        parse_gain(given, 1.0, LARGEST_PEAK)


@pytest.mark.parametrize("given", ["7e300 dB", "0 dB", "1e16", "6 m", "40 dB"])
def test_a_peak_sensitivity_of_a_scheme_is_a_gain_of_a_loop(tmp_path: Path, given: str) -> None:
    """As 7e300 dB, whose ratio no number holds."""
    text = f"fric: schemes/1\nschemes:\n  k: {{title: t, observer: jamaludin, peak_sensitivity: {given}}}\n"
    (tmp_path / "s.yaml").write_text(text, encoding="utf-8")
    with pytest.raises(FricError, match=r"peak_sensitivity|gain"):
        read_schemes(tmp_path / "s.yaml")


def test_a_ball_bar_whose_deviation_is_as_large_as_its_circle() -> None:
    """As -0.53 m on 0.1 m throughout, whose least zone no programme found."""
    angle = np.linspace(0.0, 7.0, 99)
    assert minimum_zone(angle, np.full(99, -0.53439866)) < 1e-14
    with pytest.raises(FricError, match="deviation of the ball bar reaches"):
        MeasuredCircle(0.1, 0.02, 1, angle=angle, deviation=np.full(99, -0.53))


@pytest.mark.parametrize(
    "given",
    [
        7, {"origin": 1.0}, {"origin": {"speed": 2.0}}, {"axes": 5}, {"axes": "x"}, {"resolution": "fine"},
        {"resolution": -1.0}, {"logs": [{"time": "1 mm"}]}, {"warnings_coded": ["late"]}, {"machine": ["xy"]},
        {"command": None}, {"exact": {}},
    ],
)  # fmt: skip
def test_what_made_a_run_is_as_fric_writes_it_or_refused(tmp_path: Path, given: Any) -> None:
    with h5py.File(tmp_path / "run.h5", "w") as file:
        file.attrs.update({"fric": "run/1", "provenance": json.dumps(given)})
    with pytest.raises(FricError, match=r"run\.h5: provenance.* is not as fric writes it"):
        read_run_provenance(tmp_path / "run.h5")


def test_an_observer_has_a_filter_and_a_log_a_file() -> None:
    observer = {"fric": "observer/1", "axis": "x", "cutoff": "60 Hz"}
    assert ObserverDocument.model_validate(observer).q_filter().cutoff == 60.0
    for wrong in ({"cutoff": "0 Hz"}, {"cutoff": "60 mm"}, {"filter": "y"}):  # a page divided by the first
        (key,) = wrong
        with pytest.raises(ValidationError, match=f"{key}: "):
            ObserverDocument.model_validate(observer | wrong)
    with pytest.raises(ValidationError, match="file"):  # which a page names
        ObserverDocument.model_validate(observer | {"provenance": {"logs": [{"time": "1 mm"}]}})


def test_a_clock_that_stands_tells_no_velocity(tmp_path: Path) -> None:
    t = np.round(np.arange(400) * 1e-3, 1)
    rows = zip(t, np.sin(9 * t), np.cos(9 * t), strict=True)
    (tmp_path / "a.csv").write_text("a,b,c\n" + "".join(f"{a},{b},{c}\n" for a, b, c in rows))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with pytest.raises(FricError):
            ingest(tmp_path / "a.csv", tmp_path / "a.h5")


def test_a_number_of_a_document_that_no_double_holds() -> None:
    with pytest.raises(ValidationError, match="valid number"):
        Quantity.model_validate(10**400)


def test_units_and_numbers_that_python_alone_holds() -> None:
    frame: Any = {"time [s]": [0.0, 1.0, 2.0], "position": [0.0, 1.0, 0.0]}
    for units in (iter(["mm"]), np.array(["mm", "s"]), "mm"):
        with pytest.raises(FricError, match="takes units as a mapping"):
            Log.from_frame(frame, cast("Any", units))
    with pytest.raises(FricError):
        Log.from_frame(frame, cast("Any", {"position": 5}))
    for motion in (0.5, None, "sideways", np.zeros(2)):
        with pytest.raises(FricError, match="takes motion as"):
            Log.from_frame(frame, motion=cast("Any", motion))
    for huge in (10**400, -(10**400)):
        with pytest.raises(FricError, match="and was given an int"):
            fric.circle("xy-table", velocity=huge)


@pytest.mark.parametrize("given", [
    "1e300 N", {"value": [1.0, -1e300], "unit": "N"}, {"value": 1.0, "unit": "N", "ci95": [0.5, 1e300]},
    {"value": [1.0, 1.0], "unit": "N", "ci95": [[0.5, None], [-1e300, 2.0]]},
])  # fmt: skip
def test_a_limit_of_a_document_that_no_drive_reaches(given: Any) -> None:
    """As one of 1e300 in a static map, which `identify gms --static` handed on."""
    with pytest.raises(ValidationError, match="beyond all drives"):
        Quantity.model_validate(given)


def test_a_curve_of_an_earlier_report_has_an_error_at_each_place() -> None:
    given: dict[str, Any] = {"scheme": NONE, "glitches": (), "glitch": 0.0, "rms": 0.0, "range": 0.0}
    assert len(Contour(**given, place=[0.0, 1.0], error=[0.0, 1e-6]).place) == 2
    for place, error in (([0.0], [0.0, 1.0]), ([[0.0]], [[0.0]]), ([], []), ([0.0], [np.nan])):
        with pytest.raises(FricError):
            Contour(**given, place=place, error=error)
    curve = given | {"scheme": NONE.plain(), "place": [0.0], "error": [0.0, 1.0], "warnings": ()}
    test = {"source": "run.h5", "provenance": {}, "feed": 0.1, "radius": 0.1, "direction": 1, "labels": ()}
    told = r"^in.html: run.h5: .* differ in length \(place 1, error 2\)\nMake it again with `fric report`.$"
    with pytest.raises(FricError, match=told):
        contour_test(test | {"contours": [curve]}, "in.html: ")
    for size in ({"radius": -0.03}, {"feed": 0.0}, {"feed": float("nan")}):
        with pytest.raises(FricError, match="not above 0"):
            contour_test(test | {"contours": []} | size, "in.html: ")


@pytest.mark.parametrize(("time", "interval"), [("nan", "0.002"), ("1e300", "0.002"), ("-inf", "0"), ("1e9", "1e-300")])
def test_a_trace_of_times_that_no_machine_has(tmp_path: Path, time: str, interval: str) -> None:
    signals = "".join(f'<dataSignal id="f{n}" description="s{n}" interval="{interval}"/>' for n in (1, 2))
    rows = "".join(f'<rec time="{t}" f1="1" f2="2"/>' for t in ("0", "0.002", time))
    text = f"<?xml version='1.0'?><traceSession><frameHeader dropOuts='0'/>{signals}{rows}</traceSession>"
    (tmp_path / "a.xml").write_text(text)
    with warnings.catch_warnings(action="error"), pytest.raises(FricError):
        ingest(tmp_path / "a.xml", tmp_path / "a.h5")


@pytest.mark.parametrize(("verb", "name", "sizes"), [
    (fric.circle, "machines", (0, 10**9, 10**12, 10**400)), (fric.circle, "workers", (0, 10**6)),
    (fric.circle, "revolutions", (-1, 10**30)), (fric.circle_map, "points", (1, 1000)),
    (fric.learn, "rounds", (0, 1000)), (fric.compare, "blocks", (0, 10**6)), (fric.identify_model, "blocks", (10**6,)),
])  # fmt: skip
def test_a_size_that_no_computer_bears_is_refused_by_its_type(verb: Any, name: str, sizes: tuple[int, ...]) -> None:
    for size in sizes:
        with pytest.raises(FricError, match=f"takes {name} as a whole number from . to [0-9]+, and was given"):
            verb("xy-table", **{name: size})


def test_a_size_beyond_the_bound_is_told_with_what_it_costs(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(sys, "argv", ["fric", "simulate", "circle", "xy-table", "--monte-carlo", "1000000000000"])
    with pytest.raises(SystemExit):
        main()
    assert "100000: Run N machines" in (told := " ".join(capsys.readouterr().err.split()))
    assert "1000 take a minute of a core" in told


def test_an_interval_over_more_than_a_million_is_open() -> None:
    assert Estimate.around_log(48.0, "Hz", 425.0).as_dict()["ci95"] == [0.0, None]
    assert Estimate.around_log(48.0, "Hz", 1.0).ci95 == pytest.approx((48.0 / np.e, 48.0 * np.e))


def test_values_of_a_warning_are_those_of_a_drive() -> None:
    """A page and `--json` handed on a length of -1e300 m that an earlier document's warning held."""
    coded = {"text": "t", "values": {"length": {"value": -1e300, "unit": "m"}, "half": [1.0, 2]}}
    with pytest.raises(ValidationError, match="values: 1e\\+300 is beyond all drives"):
        CodedWarning.model_validate(coded)
    with pytest.raises(ValidationError, match="values: 1e\\+300 is beyond all drives"):
        CodedWarning.model_validate(coded | {"values": {"length": 10**400}})  # which no double holds
    assert CodedWarning.model_validate(coded | {"values": {"length": [1.0, 1e19]}}).values
    with pytest.raises(ValidationError, match="ci95: 1e\\+21 is beyond all drives"):
        Quantity.model_validate({"value": 1.0, "unit": "N", "ci95": [None, 1e21]})


def test_a_delay_of_thousands_of_states() -> None:
    """Eigenvalues of a loop take the cube of the samples of its delay: 0.6 s at 4 kHz took minutes."""
    with pytest.raises(FricError, match="samples at 4000 Hz"):
        design_cascade(LinearPlant(17.0, 2.4, 0.6))


def test_a_result_beyond_all_drives_ends_in_a_sentence() -> None:
    """A stiffness of 1e23 N/m, of a log of which half was no number, ended in a traceback of the schema."""
    found = {"sigma_0": Estimate(7.6e22, "N/m", assumed=True)}
    with pytest.raises(FricError, match=r"dahl\.sigma_0 comes out as no number"):
        FrictionDocument.made({"axis": "x", "motion": "linear", "dahl": found})


@pytest.mark.parametrize("verb", [fric.identify_controller, fric.identify_static])
def test_an_array_of_no_dimension_is_no_log(verb: Any) -> None:
    with pytest.raises(FricError, match="was given a ndarray"):
        verb([np.array("x")])


def test_a_filter_of_no_samples_is_refused() -> None:
    """Halves of 299 samples ended in a traceback of SciPy."""
    with pytest.raises(FricError, match="0 samples are too few for a filter"):
        thinned(np.zeros(0), 2)


def test_a_map_of_circles_whose_rows_do_not_fit_its_radii() -> None:
    """A page ended in a traceback of its template: a row was missing."""
    rows = {"a": {"title": "none", "glitch": [[1e-6, 2e-6]]}}
    about = {"fric": "circle-map/1", "machine": "m", "feeds": [0.1, 0.2], "differences": {}, "schemes": rows}
    assert CircleMapDocument.model_validate(about | {"radii": [0.03]}).schemes
    with pytest.raises(ValidationError, match="a row for each of 2 radii, of 2 feeds"):
        CircleMapDocument.model_validate(about | {"radii": [0.03, 0.1]})


def test_an_input_that_is_infinite_throughout_changes_nothing(tmp_path: Path) -> None:
    """NumPy warned of an infinity less another; the error of pytest's filter shows it."""
    rows = "".join(f"{n / 4000},1.0,-inf,{n * n}.0\n" for n in range(50))
    (tmp_path / "log.csv").write_text("time [s],force [N],input [V],.. [s]\n" + rows)
    with pytest.raises(FricError, match="no column is position or velocity"):
        fric.ingest(tmp_path / "log.csv", output=tmp_path / "log.h5")


def test_the_traces_of_a_circle_are_those_of_all_axes_and_schemes(monkeypatch: pytest.MonkeyPatch) -> None:
    """10 m at 10 mm/s took 7 GB and ended in a traceback, 10 m at 100 mm/s under all schemes 4 GB."""
    monkeypatch.setattr(reference, "MOST_BYTES", 1.5e7)
    assert fric.circle("xy-table", "a", radius=0.01).runs
    with pytest.raises(FricError, match=r"samples at 4000 Hz of 2 axes in 6 runs take .* GB, and 0.015 GB"):
        fric.circle("xy-table", radius=0.05)


def test_what_is_learned_is_tried_on_a_longer_circle(monkeypatch: pytest.MonkeyPatch) -> None:
    """At 1 mm/s two rounds took 2.2 GB: the learned table is carried to a circle at half the feed."""
    monkeypatch.setattr(reference, "MOST_BYTES", 1.5e7)
    with pytest.raises(FricError, match=r"of 2 axes in 6 runs take .* GB, and 0.015 GB"):
        fric.learn("virtual-rig", rounds=1, velocity="100 mm/s")


def test_the_run_of_the_median_is_the_same_where_the_others_are_not_kept(monkeypatch: pytest.MonkeyPatch) -> None:
    machine, test = fric.read_machine("xy-table"), Circle(0.003, 0.02)
    kept = run_circle(machine, NONE, test, only="x")
    monkeypatch.setattr(contour_run, "MOST_KEPT", 0)
    again = run_circle(machine, NONE, test, only="x")
    assert again.places == kept.places
    assert again.contour.glitch == kept.contour.glitch == float(np.median([place.glitch for place in kept.places]))
    np.testing.assert_array_equal(again.traces["x"].position, kept.traces["x"].position)


def test_an_argument_of_another_type_that_lacks_an_attribute() -> None:
    with pytest.raises(FricError, match="MeasuredCircle takes axes"):
        fric.MeasuredCircle(0.03, 0.1, 1, axes=cast("Any", "x"))


@pytest.mark.parametrize(
    ("value", "ci95"),
    [(1.0, 0.001), (1.0, (1.0,)), ((1.0, 2.0), (0.0, 3.0)), (1.0, ("a", "b")), (1.0, (2**53 + 1, 2.0))],
)
def test_an_interval_that_fits_no_value(value: Any, ci95: Any) -> None:
    with pytest.raises(FricError, match="ci95 does not fit the value"):
        Estimate(value, "N", ci95)
    with pytest.raises(FricError, match="Estimate takes value as a number"):
        Estimate(cast("Any", "x"), "N")


def test_a_plant_that_no_drive_has_is_refused_wherever_it_is_taken(tmp_path: Path) -> None:
    """`validate` replayed a B of 2.4e-30 m/(s^2*V), that is a mass of 6e31 kg, and printed an error of 7.5e18 GN.

    A cascade for a B of 1e-300 overflowed.
    """
    with pytest.raises(FricError, match="B of the plant is 1e-300"):
        LinearPlant(16.9, 1e-300, 6e-4)
    plant = LinearPlant(16.9, 2.4e-14, 6e-4)
    file = tmp_path / "plant.yaml"
    quantities = {"A": "1/s", "B": "m/(s^2*V)", "T_d": "s"}
    rows = [f"{name}: {{value: {getattr(plant, name)}, unit: '{unit}'}}" for name, unit in quantities.items()]
    file.write_text("\n".join(["fric: plant/1", "axis: x", "motion: linear", *rows, "K_f: {value: 150, unit: N/V}"]))
    t = np.arange(9e3) * 1e-3
    frame = pd.DataFrame({"time [s]": t, "position [m]": 1e-5 * np.sin(t), "force [N]": np.cos(t)})
    log = fric.Log.from_frame(frame, kind="presliding-sine")
    for call in (fric.validate, fric.identify_static, fric.identify_gms):
        with pytest.raises(FricError, match=r"B is 2\.4e-14|the moving mass"):
            call(log, plant=file)
    for verb in (fric.design_controller, fric.design_observer, partial(fric.design_block, "kalman")):
        with pytest.raises(FricError, match=r"B is 2\.4e-14|the moving mass"):
            verb(file)


def test_a_covariance_is_of_what_is_not_open() -> None:
    """A file held a variance of 5.7e18 of a logarithm, whose interval it called open."""
    rows = [[1.0, 1e9, 0.5], [1e9, 5.7e18, -1e9], [0.5, -1e9, 1e6]]
    scales: list[Scale] = ["log", "log", "linear"]
    kept = Covariance.of(["F_c", "k_3", "sigma"], rows, scales)
    assert kept == Covariance(("F_c", "sigma"), ("log", "linear"), ((1.0, 0.5), (0.5, 1e6)))
    assert CovarianceBlock(names=["F_c", "k_3", "sigma"], scales=scales, matrix=rows).covariance() == kept


def test_a_velocity_that_is_none_and_a_unit_that_is_empty_are_told(tmp_path: Path) -> None:
    for model in (fric.StaticMap(60.0, 90.0, 0.002), fric.Dahl(60.0, 1e7), fric.MaxwellSlip((60.0,), (1e7,))):
        with pytest.raises(FricError, match="takes v as numbers, and was given a str"):
            model.steady_state(cast("Any", "x"))
    with h5py.File(tmp_path / "log.h5", "w") as file:
        file.attrs.update({"fric": "log/1", "axis": "x", "motion": "linear"})
        file["records/one/time"] = file["records/one/position"] = np.arange(3.0)
        cast("Any", file["records/one/position"]).attrs["unit"] = ""
    with pytest.raises(FricError, match=r"log.h5, record 'one', position: position cannot be in ''"):
        fric.read(tmp_path / "log.h5")


@pytest.mark.parametrize("kind", ["log", "feedforward"])
def test_an_error_that_is_kept_blocks_no_other_thread(kind: str, tmp_path: Path) -> None:
    """As a notebook keeps the last: an ingest that packs chunks in a thread waited without end for h5py's lock."""
    with h5py.File(tmp_path / "bad.h5", "w") as file:
        if kind == "log":
            file.attrs.update({"fric": "log/1", "axis": "x", "motion": "linear"})
            file["records/one/time"] = file["records/one/position"] = np.arange(3.0)
            cast("Any", file["records/one/position"]).attrs["unit"] = ""
        else:
            file.attrs["fric"] = FEEDFORWARD
            file["x/voltage"] = "none"
    with pytest.raises(FricError, match=r"bad\.h5") as kept:
        read_records(tmp_path / "bad.h5") if kind == "log" else read_feedforward(tmp_path / "bad.h5")
    other = Thread(target=lambda: h5py.File(tmp_path / "other.h5", "w").close(), daemon=True)
    other.start()
    other.join(20.0)
    assert not other.is_alive()
    assert kept.value.__traceback__ is not None


def test_a_setting_of_a_plan_has_as_many_values_as_its_experiment_takes() -> None:
    limits = {"stroke": "0.3 m", "feed": "0.1 m/s", "acceleration": "5 m/s^2"}
    part = {"kind": "frequency-response", "settings": {"peaks": "5 mm/s", "lines": "3"}}
    plan = PlanDocument.model_validate({"fric": "plan/1", "axis": "x", "limits": limits, "experiments": [part]})
    assert plan.planned()[0].settings == {"peaks": (0.005,), "lines": 3}
    part["settings"] = {"ramp": {"value": [0.1, 0.2], "unit": "s"}}
    with pytest.raises(ValidationError, match="a list of 2 where one value is expected"):
        PlanDocument.model_validate({"fric": "plan/1", "axis": "x", "limits": limits, "experiments": [part]})


def test_a_count_that_is_no_number_drops_nothing(tmp_path: Path) -> None:
    with h5py.File(tmp_path / "log.h5", "w") as file:
        file.attrs.update({"fric": "log/1", "axis": "x", "motion": "linear"})
        for channel, unit in (("time", "s"), ("position", "m")):
            file[f"records/one/{channel}"] = np.arange(3.0)
            cast("Any", file[f"records/one/{channel}"]).attrs["unit"] = unit
        file["records/one"].attrs["dropped"] = True
    assert ingest([tmp_path / "log.h5"], tmp_path / "again.h5").records[0].dropped == 0


def test_an_angle_that_begins_again_after_more_counts_than_a_double_tells() -> None:
    x = np.arange(600.0) % 100
    assert roles._turn(x) == 100.0
    assert roles._turn(1e16 * x) == 0.0
    with pytest.raises(ValidationError, match="wraps"):
        MappingDocument.model_validate({"fric": "mapping/1", "columns": {"position": {"column": "a", "wraps": 1e18}}})


@pytest.mark.parametrize(("of", "what"), [
    ("{value: .nan, unit: 1/s}", "K_v.value: it should be a finite number"),
    ("{value: 1, unit: 1/s, ci95: 3}", "K_v.ci95: give a list"),
])  # fmt: skip
def test_an_error_of_a_document_names_its_keys_and_what_to_do(tmp_path: Path, of: str, what: str) -> None:
    """It named branches of the schema as keys, ``K_v.value.float``, and no mend."""
    (tmp_path / "a.yaml").write_text(f"fric: controller/1\naxis: x\nK_v: {of}\n")
    with pytest.raises(FricError, match=re.escape(f"line 3: {what}\n`fric schema controller`")):
        read_document(tmp_path / "a.yaml", ControllerDocument)


def test_records_of_a_fit_that_are_a_number() -> None:
    with pytest.raises(ValidationError, match="records"):
        FrictionDocument.model_validate({"fric": "friction/1", "axis": "x", "static_fit": {"records": 0.5}})


def test_two_positions_of_a_few_rows(tmp_path: Path) -> None:
    turn = np.arange(10) * 0.6 * np.pi
    x, v = 10.0 * np.sin(turn), 18850.0 * np.cos(turn)
    rows = np.column_stack([x, -35600.0 * x + v / 10, np.arange(10) * 1e-3, v, -237.0 * x + v / 1500, x])
    lines = (" ".join(map(repr, [n, *row])) for n, row in enumerate(rows.tolist()))
    (tmp_path / "a.txt").write_text("\n".join(lines) + "\n")
    assert roles.axes_of(list(tables(tmp_path / "a.txt")))


def test_a_figure_of_a_ball_bar_that_no_circle_shows(tmp_path: Path) -> None:
    feature = '<FEATURE DT="UT_SERVO_MISMATCH" NAME="AF_SERVO_MISMATCH">1e300</FEATURE>'
    (tmp_path / "a.b5r").write_text(f'<?xml version="1.0"?><B>{feature}<PLANE TEST_PLANE="XY"/></B>')
    with pytest.raises(FricError, match=r"servo_mismatch is .* which no circle shows"):
        figures(tmp_path / "a.b5r")


def test_joined_files_of_units_that_no_likelihood_tells(tmp_path: Path) -> None:
    """The mapping that was proposed held "?", and ended in a traceback."""
    (tmp_path / "a.tsv").write_text("Time_nm,position_kHz,force_N\n" + "".join(f"{n},{n * n},1\n" for n in range(300)))
    with pytest.raises(FricError, match="a unit is open"):
        fric.ingest(tmp_path / "a.tsv", output=tmp_path / "a.h5", join=True, assume=True)
    rows = (f"{n / 1e3},{np.sin(n / 50):.6f},{np.sign(np.cos(n / 50)):.0f}\n" for n in range(900))
    (tmp_path / "b.csv").write_text("t [s],x [mm],F [N]\n" + "".join(rows))
    done = fric.ingest(tmp_path / "b.csv", output=tmp_path / "b.h5", join=True, assume=True)
    assert any('position is "x' in warning for warning in done.warnings)
    with pytest.raises(FricError, match="Report takes inputs"):
        fric.Report(cast("Any", 100.0))


def test_a_response_that_is_said_to_be_a_map_of_holding_forces(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text("frequency [Hz],magnitude [m/V],phase [deg]\n1,1,0\n2,1,0\n")
    with pytest.raises(FricError, match="such a record has no frequency"):
        ingest(tmp_path / "a.csv", tmp_path / "a.h5", kind="holding-map")


def test_a_log_and_a_folder_behind_links_that_lead_to_themselves(tmp_path: Path) -> None:
    (tmp_path / "a").symlink_to("b")
    (tmp_path / "b").symlink_to("a")
    with pytest.raises(FricError, match="Too many levels of symbolic links"):
        fric.auto(tmp_path / "a/log.csv", output=tmp_path / "out")


def test_circles_side_by_side_share_the_memory() -> None:
    """Circles of 630 s in two processes at once took 2.3 GB; now 1.65 GB."""
    grid = contour_run.CircleGrid(fric.read_machine("xy-table"), (NONE,), (0.001,), (0.1,), 1e-8)
    assert grid.memory == pytest.approx(2 * 628.3 * 4000 * reference.SAMPLE_BYTES, rel=1e-3)
    assert grid.memory < reference.MOST_BYTES < 2 * grid.memory
    with processes.outcomes(lambda n: os.getpid(), 2, workers=2, memory=grid.memory) as found:
        assert list(found) == [os.getpid(), os.getpid()]


def test_a_map_of_the_negative_direction_has_bounds_too() -> None:
    """A machine with friction of 1e9 N backwards was read without a word."""
    axis = fric.read_machine("xy-table").axes["x"]
    forwards = axis.friction.static
    backwards = dataclasses.replace(forwards, F_c=1e9, F_s=1e9)
    found = machine_files._of_axis(dataclasses.replace(axis, friction=Directed(axis.friction, backwards)), "")
    assert [finding.value for finding in found if finding.name == "friction" and finding.beyond()] == [1e9]


@pytest.mark.parametrize(
    ("name", "value"),
    [("mass", "1e18 kg"), ("level", "1e16"), ("offset", "1e12 N"), ("level", "3 N"), ("mass", "-1 kg")],
)
def test_what_differs_between_records_has_bounds_and_a_unit(name: str, value: str) -> None:
    """A mass of 1e18 kg between the records of a fit was read, and so was a level in N."""
    head = {"fric": "friction/1", "axis": "x", "static": {"F_c": "90 N", "F_s": "100 N", "v_s": "1 mm/s"}}
    right = {"level": "0.05", "offset": "0.2 N", "mass": "0 kg"}
    assert FrictionDocument.model_validate(head | {"fit": {"between_records": right}}).fit is not None
    with pytest.raises(ValidationError, match="between"):
        FrictionDocument.model_validate(head | {"fit": {"between_records": right | {name: value}}})


def test_a_stribeck_velocity_is_one_that_an_axis_reaches() -> None:
    """v_s of 1e14 m/s was read without a word; where F_s is F_c it has no effect, and any is taken."""
    axis = fric.read_machine("xy-table").axes["x"]
    for F_s, beyond in ((100.0, ["stribeck"]), (90.0, [])):
        static = StaticMap(F_c=90.0, F_s=F_s, v_s=1e14)
        found = machine_files._of_axis(dataclasses.replace(axis, friction=static), "")
        assert [finding.name for finding in found if finding.beyond()] == beyond


def test_viscous_friction_has_a_bound_where_no_mass_is_known_too() -> None:
    """A sigma of 1e15 N·s/m in a friction file was handed on by a replay of GMS."""
    for sigma, beyond in ((1e15, True), (1e6, False)):
        found = of_friction(StaticMap(F_c=90.0, F_s=100.0, v_s=1e-3, sigma=sigma), "linear")
        assert ("viscous" in [finding.name for finding in found if finding.beyond()]) == beyond


def test_a_row_that_hardly_moves_is_at_rest() -> None:
    """A velocity of 5e-324 m/s in a table ended in NLopt's `invalid_argument`."""
    v = np.array([-2e-2, -8e-3, -2e-3, -1e-3, 5e-324, 1e-3, 2e-3, 8e-3, 2e-2])
    table = ForceVelocity(
        v, np.sign(v) * (90.0 + 30.0 * np.exp(-np.abs(v) / 2e-3)), error=np.full(9, 1.0), name="means"
    )
    assert "rows-at-rest" in [notice.code for notice in fric.identify_static(table, delta=4.0).warnings]


def test_the_lower_limit_of_an_interval_is_not_the_upper() -> None:
    """Limits of 0.8 mm/s … 4e-33 mm/s were read, and handed on to a friction file and a report."""
    with pytest.raises(FricError, match="ci95"):
        Estimate(2.5e-3, "m/s", (8e-4, 4e-36))
    with pytest.raises(ValidationError, match="ci95"):
        Quantity.model_validate({"value": [1.0, 2.0], "unit": "N", "ci95": [[0.0, 2.0], [3.0, 1.0]]})
    assert Quantity.model_validate({"value": 1.0, "unit": "N", "ci95": [1.0, None]}).ci95 == [1.0, None]
    assert Estimate.around(-2.0, "N", -0.5).ci95 == (-2.5, -1.5)  # a share of a negative value
    assert Estimate.around_log(-2.0, "N", math.log(2.0)).ci95 == pytest.approx((-4.0, -1.0))


@pytest.mark.parametrize("W", [(60.0, 30.0, 10.0), (60.0, 40.0, 0.0)])
def test_gains_follow_the_blocks_of_maxwell_slip_as_those_of_gms(W: tuple[float, ...]) -> None:
    """Maxwell-slip friction ended in an AttributeError; a block that takes no force divided by zero."""
    axis = fric.read_machine("xy-table").axes["x"]
    k = (1e8, 2e6, 2e5)
    static = StaticMap(F_c=100.0, F_s=100.0, v_s=1e-3)
    gms = GMS(static, tuple(force / 100.0 for force in W), k, C=1.0)
    maxwell = MaxwellSlip(W, k)
    setting = setting_of(axis, NONE, reference.circle(2e-3, 0.02, 3, 4000.0)[0])
    block = GainScheduled(1.0, 5.0, 0.85)
    found = [block.schedule(dataclasses.replace(setting, models={model.name: model})) for model in (gms, maxwell)]
    assert np.allclose(*found)
    assert np.all(found[0] > 0.0)
    assert len(found[0]) == np.count_nonzero(W)


@pytest.mark.parametrize(("samples", "read"), [(16, False), (72, False), (90, True), (360, True)])
def test_a_circle_sampled_too_coarsely_for_its_glitches_is_refused(samples: int, read: bool) -> None:
    """A table of a ball bar by 5° ended in the argmax of an empty sequence, one of 16 samples in a singular matrix."""
    angle = np.arange(samples + 1) * 2.0 * np.pi / samples
    behind = (angle + np.pi / 4) % (np.pi / 2) - np.pi / 4
    deviation = 8e-6 * np.exp(-np.abs(behind) / 0.1) * (behind >= 0.0)
    test = MeasuredCircle(radius=0.1, feed=0.05, direction=1, angle=angle, deviation=deviation)
    if read:
        assert fric.diagnose(test).report()
    else:
        with pytest.raises(FricError, match="apart, too far to show its glitch"):
            fric.diagnose(test)


def test_an_axis_that_rests_while_its_reference_makes_micro_steps_is_inspected() -> None:
    """A recorded position of 0 throughout ended in a division by zero."""
    samples = np.arange(400)
    step, part = np.divmod(samples, 8.3)
    levels = 1e-6 * np.abs((np.arange(50) + 5) % 12 - 6)
    asked = levels[step.astype(int)] + np.diff(levels)[step.astype(int)] * np.clip(part / 2.0, 0.0, 1.0)
    force = 40.0 * np.sign(np.gradient(asked)) + np.random.default_rng(0).normal(0.0, 5.0, 400)
    log = Log(time=0.06 * samples, position=np.zeros(400), reference=asked, force=force, kind="micro-steps")
    assert not next(use for use in fric.inspect(log).found[0].uses if use.purpose == "gms").good


@pytest.mark.parametrize("name", ["machine", "plant", "friction"])
def test_a_document_of_another_version_is_told_by_its_version(tmp_path: Path, name: str) -> None:
    """A machine/2 file was said to be a machine file where a machine file is asked for, of use in the same command."""
    path = tmp_path / "later.yaml"
    path.write_text(f"fric: {name}/2\naxis: x\n")
    of_kind: dict[str, Callable[[Path], Any]] = {
        "machine": fric.read_machine, "plant": fric.design_controller, "friction": fric.read_friction,
    }  # fmt: skip
    with pytest.raises(FricError, match=f"holds {name}/2, not {name}/1") as caught:
        of_kind[name](path)
    assert "later.yaml" not in (caught.value.hint or "")


def test_the_phases_of_a_long_multisine_are_drawn_in_little_memory() -> None:
    """A period of four minutes took 10 GB: a row a sample, and a column a line and a draw."""
    lines = 0.0100001 * np.array([1.0, 7.0, 300.0, 9000.0])
    tracemalloc.start()
    shaken = reference.multisine(lines, 0.01, 400_000, 4000.0, np.random.default_rng(0))
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 150e6
    assert np.abs(shaken.velocity).max() == pytest.approx(0.01)


def test_a_multisine_at_rest_is_as_long_as_other_motions_may_be() -> None:
    axis = fric.read_machine("virtual-rig").axes["x"]
    with pytest.raises(FricError, match="are simulated at most"):
        frequency_response(axis, mean=0.0, peaks=(0.01,), lowest=1e-4)


def test_a_circle_alone_is_no_log_to_identify_from(tmp_path: Path) -> None:
    """It ended with status 1 and not a word why, and with a file named that was not there."""
    (tmp_path / "logs").mkdir()
    (tmp_path / "logs" / "circle.h5").write_bytes(Path("data/circle.h5").read_bytes())
    with pytest.raises(FricError, match="there is no log of strokes"):
        fric.auto(tmp_path / "logs", output=tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_a_voltage_that_is_logged_twice_is_taken_once(tmp_path: Path) -> None:
    """As `KeyError: 5`: the copy was left out, and looked up."""
    t = np.arange(2000) * 1e-3
    z, v = 30.0 * np.sin(6.0 * t), np.cos(6.0 * t)
    u = 0.6 * np.sign(v) + 0.1 * v - 0.1 * np.sin(6.0 * t)
    head = "time [s],x actual position [mm],x CURRENT [V],y CURRENT [V]"
    np.savetxt(tmp_path / "a.csv", np.c_[t, z, u, u], delimiter=",", header=head, comments="", fmt="%.6f")
    fric.ingest(tmp_path / "a.csv", output=tmp_path / "a.h5", assume=True)
    assert np.allclose(fric.read(tmp_path / "a.h5")[0].input, u, atol=1e-6)


def test_a_scheme_chooses_no_measured_circle() -> None:
    """It was taken and said nothing: any text was a scheme."""
    circle, calls = "data/circle.h5", [fric.diagnose, fric.identify_controller, partial(fric.tune, "virtual-rig")]
    for call in [*calls, partial(fric.learn, machine="virtual-rig")]:
        with pytest.raises(FricError, match="no circle is of the scheme 'q'"):
            call(circle, scheme="q")
    assert fric.diagnose(circle, machine="virtual-rig", scheme="f").document  # which was on, for the prediction


@pytest.mark.parametrize(
    "words",
    [
        ["plan", "--stroke", "20 mm", "--feed", "20 mm/s", "--scheme", "f"],
        ["plan", "gms.yaml", "--micro-steps"],
        ["ingest", "x.csv", "-o", "o.h5", "--radius", "3 mm"],
        ["ingest", "x.csv", "-o", "o.h5", "--kind", "circle", "--from", "3 s"],
        ["learn", "data/circle.h5", "--machine", "virtual-rig", "--velocity", "50 mm/s"],
        ["learn", "data/circle.h5", "--machine", "virtual-rig", "--no-observer"],
    ],
)
def test_an_option_that_says_nothing_of_these_arguments_is_refused(words: list[str]) -> None:
    error = CliRunner().invoke(app, words).exception
    assert isinstance(error, FricError)
    assert re.search(" alone| go ", error.what)
    assert words[-2 if words[-1][0].isdigit() or words[-1] == "f" else -1].replace("no-", "") in error.what


@pytest.mark.parametrize("epoch", ["nan", "x", "1e9", "9" * 30])
def test_a_time_of_outputs_that_is_none(monkeypatch: pytest.MonkeyPatch, epoch: str) -> None:
    """A figure as PDF, and each document, ended in a ValueError."""
    monkeypatch.setenv("SOURCE_DATE_EPOCH", epoch)
    with pytest.raises(FricError, match="SOURCE_DATE_EPOCH"):
        provenance()


def test_arrays_that_carry_a_unit_are_not_taken_for_si() -> None:
    """Those of pint in mm were taken as m, with a warning of pint's."""
    mm = pint.UnitRegistry().mm
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with pytest.raises(FricError, match="takes velocity as an array of numbers"):
            fric.ForceVelocity(velocity=cast("Any", np.linspace(-20.0, 20.0, 9) * mm), force=np.ones(9))
        with pytest.raises(FricError, match="takes x as an array of numbers"):
            fric.PointPath(cast("Any", np.linspace(0.0, 20.0, 9) * mm), np.ones(9), 0.05)


def test_an_object_explains_its_arguments_though_its_class_was_not_named() -> None:
    code = "import fric\ntry: fric.read_machine('virtual-rig').axes['x'].plant.held('x')\n"
    found = run_python(code + "except fric.FricError as error: print(error.what)")
    assert b"Plant.held takes T as a number" in found.stdout, found.stderr


def test_an_argument_that_says_nothing_is_refused(rig_plant: fric.PlantResult) -> None:
    """Any text was taken: a name of a record without a log, schemes without a machine, a gain of another file."""
    calls: dict[str, Callable[[], Any]] = {
        "record": lambda: fric.design_block("kalman", rig_plant, record="q"),
        "`record": lambda: fric.design_observer(rig_plant, record="q"),
        "known": lambda: fric.diagnose("data/circle.h5", known="q.yaml"),
        "position_gain": lambda: fric.identify_controller("data/circle.h5", position_gain="3 furlong"),
        "before": lambda: fric.learn("virtual-rig", rounds=2, before="q.h5"),
    }
    for name, call in calls.items():
        with pytest.raises(FricError, match=f"{name}=` goes with"):
            call()


@pytest.mark.parametrize("given", [{"share": 0}, {"bandwidth": 0}])
def test_nothing_is_no_default_to_learn_with(given: dict[str, float]) -> None:
    """A share of 0 was taken for none given: the table was that of the default."""
    with pytest.raises(FricError):
        fric.learn("data/circle.h5", machine="virtual-rig", **cast("Any", given))


def test_a_glitch_is_integrated_within_its_size() -> None:
    """An accuracy of a furlong was taken."""
    with pytest.raises(FricError, match="accuracy of the integration"):
        fric.circle_map("virtual-rig", "a", feeds="100 mm/s", radii="10 mm", accuracy="1 furlong")
    with pytest.raises(FricError, match="corner ratio"):
        design_cascade(LinearPlant(14.0, 2.4, 6e-4), corner_ratio=1e308)


def test_a_model_whose_shares_are_none_is_refused_where_it_is_read(tmp_path: Path) -> None:
    """It was copied beside what was identified with its map, and that file could not be read."""
    bad = tmp_path / "bad.yaml"
    fric.identify_gms("data/presliding-sine.h5", blocks=2).save(bad)
    tree = YAML().load(bad)
    tree["gms"]["alpha"] = {"value": [0.5, 0.2], "unit": "1"}
    YAML().dump(tree, bad)
    with pytest.raises(FricError, match=r"sums to 0\.7"):
        fric.identify_model("dahl", "data/presliding-sine.h5", static=bad)


def test_no_more_is_fed_forward_than_the_controller_gives() -> None:
    """With a nominal plant that is too slow by a thousand, a table of kilovolts was written without a word."""
    machine = fric.read_machine("virtual-rig")
    x = machine.axes["x"]
    nominal = dataclasses.replace(x.plant, B=1e-3 * x.plant.B)
    slow = dataclasses.replace(machine, axes={**machine.axes, "x": dataclasses.replace(x, nominal=nominal)})
    with pytest.raises(FricError, match="its limit is 10 V"):
        fric.learn("data/circle.h5", machine=slow)


@pytest.mark.parametrize("mark", [",", ";", "\t"])
def test_a_minus_as_it_is_typeset_is_one(tmp_path: Path, mark: str) -> None:
    """Each negative position was no number: with ``assume`` they were left out, which is half of a motion."""
    t = 2e-3 * np.arange(400)
    z, u = -5.0 + 12.0 * np.sin(9.0 * t), 60.0 * np.sign(np.cos(9.0 * t))
    rows = [mark.join(f"{x:.4f}" for x in row) for row in zip(t, z, u, strict=True)]
    text = "\n".join([mark.join(["time [s]", "position [mm]", "force [N]"]), *rows])
    (tmp_path / "a.csv").write_text(text.replace("-", "\N{MINUS SIGN}") + "\n", encoding="utf-8")
    fric.ingest(tmp_path / "a.csv", output=tmp_path / "a.h5")
    assert fric.read(tmp_path / "a.h5")[0].position == pytest.approx(1e-3 * z, abs=1e-7)


def test_a_block_that_is_designed_beyond_its_bounds_is_refused() -> None:
    """A poor response left a sliding surface that no file may hold: a traceback of pydantic's when it was written."""
    block = SlidingMode(gain=5e-3, slope=2.7e-3, reach=1.0)
    with pytest.raises(FricError, match=r"slope of 'sliding-mode' is 0\.0027"):
        BlockDesign(block, None, "")


def test_numbers_of_half_precision_are_numbers() -> None:
    """NumPy warned of a bound that no such number reaches."""
    static = StaticMap(60.0, 90.0, 2e-3)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        alpha = cast("Any", np.array([0.5, 0.5], np.float16))
        assert GMS(static, alpha=alpha, k=cast("Any", np.array([1e8, 1e6], np.float32)), C=1e3).alpha == (0.5, 0.5)


@pytest.mark.parametrize("word", ["'", "''", '"', "a'b"])
def test_a_choice_of_quotes_is_wrong_usage(monkeypatch: pytest.MonkeyPatch, word: str) -> None:
    """An IndexError: the word was looked for between its quotes."""
    monkeypatch.setattr(sys, "argv", ["fric", "diagnose", "data/circle.h5", "--implausible", word])
    with pytest.raises(SystemExit) as ended:
        main()
    assert ended.value.code == 2


def failed(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, *arguments: str) -> str:
    """Return what a command that fails prints on standard error."""
    monkeypatch.setattr(sys, "argv", ["fric", *arguments])
    with pytest.raises(SystemExit) as ended:
        main()
    assert ended.value.code == 1
    return capsys.readouterr().err


def test_errors_name_the_file_that_is_cut_or_leads_nowhere(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    log = "time [s],position [mm],force [N]\n" + "".join(f"{n}e-3,{n},{n % 7}\n" for n in range(99))
    (tmp_path / "cut.csv.gz").write_bytes(gzip.compress(log.encode())[:-20])
    (tmp_path / "whole.csv").write_text(log)
    files = [str(tmp_path / name) for name in ("cut.csv.gz", "whole.csv")]
    assert "cut.csv.gz" in failed(capsys, monkeypatch, "ingest", *files, "-o", str(tmp_path / "o.h5"))
    (tmp_path / "link.h5").symlink_to("nowhere")
    assert "Is it link.h5" not in failed(capsys, monkeypatch, "inspect", str(tmp_path / "link.h5"))


def test_a_friction_file_with_an_impossible_number_is_named(tmp_path: Path) -> None:
    path = tmp_path / "negative.yaml"
    text = "fric: friction/1\naxis: x\nmotion: linear\nstatic:\n"
    path.write_text(text + "  F_c: {value: -1, unit: N}\n  F_s: {value: 9, unit: N}\n  v_s: {value: 1, unit: mm/s}\n")
    with pytest.raises(FricError, match=r"negative\.yaml"):
        fric.identify_gms("data/presliding-sine.h5", static=path)
    with pytest.raises(FricError, match="delta of 'static' is 1000"):
        fric.identify_gms("data/presliding-sine.h5", static=StaticMap(60.0, 90.0, 2e-3, delta=1e3, sigma=0.0))


def test_a_parameter_without_effect_is_no_singular_matrix() -> None:
    residual = np.random.default_rng(0).normal(size=400)
    with pytest.raises(FricError, match="no effect"):
        covariance_of(np.column_stack([np.ones(400), np.zeros(400)]), residual, [400])


def test_a_channel_of_no_numbers_is_said(tmp_path: Path) -> None:
    t = np.arange(300) * 1e-3
    with TdmsWriter(tmp_path / "complex.tdms") as file:
        columns = {"time": (t, "s"), "position": (np.sin(t), "mm"), "force": ((60 + t) + 0j, "N")}
        file.write_segment([
            ChannelObject("g", name, values, properties={"unit_string": unit})
            for name, (values, unit) in columns.items()
        ])  # fmt: skip
    found = ingest(tmp_path / "complex.tdms", tmp_path / "o.h5")
    assert any(notice.code == "channels-without-time" and "force" in notice for notice in found.warnings)


def test_a_name_of_thousands_of_letters_is_refused(tmp_path: Path) -> None:
    """To search it for words took minutes."""
    (tmp_path / "long.csv").write_text(f"time [s],{'x' * 30_000},force [N]\n" + "0,0,0\n1,1,1\n" * 50)
    with pytest.raises(FricError, match="30000 letters"):
        ingest(tmp_path / "long.csv", tmp_path / "o.h5")


def test_a_record_prints_no_escape() -> None:
    log = fric.Log(time=np.arange(9.0), position=np.arange(9.0), name="a\x1b[31mb")
    assert repr(log).isprintable()


def test_an_empty_element_of_a_list_is_passed_over() -> None:
    assert several("1 mm/s,, 2 mm/s", "velocity", "linear") == [1e-3, 2e-3]


def test_a_pulse_behind_a_controller_without_an_integral_has_none() -> None:
    part, pulse = SimpleNamespace(K_p=2.0, K_i=0.0), Pulse(1e-3, 1e-4, 0.1, 0.2, 0.3, 0.01)
    assert as_block(cast("Any", part), pulse)["integral"] == 0.0
