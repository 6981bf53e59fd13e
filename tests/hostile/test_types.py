"""What comes from outside becomes one of few types, which no member that a consumer cannot bear can be of."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from contextlib import nullcontext
from dataclasses import replace
from pathlib import Path
from typing import Any, cast

import h5py
import numpy as np
import pandas as pd
import pytest
from pydantic import ValidationError

import fric
from fric.circles.measured import AxisTrace, MeasuredCircle
from fric.circles.revolutions import find_circles
from fric.circles.tune_fit import voltage_record
from fric.control.cascade import Cascade
from fric.control.q_filter import QFilter
from fric.documents.contours import ContourScheme
from fric.documents.machine_files import read_machine, read_spreads
from fric.drive.plant import LinearPlant
from fric.drive.sensing import Encoder
from fric.errors import FricError
from fric.friction.gms import GMS
from fric.friction.stribeck import StaticMap
from fric.input import foreign
from fric.io.circle import read_feedforward, read_runs
from fric.io.hdf5 import read_records, write_logs
from fric.io.ingest import ingest
from fric.log import ForceVelocity, FrequencyResponse, Log
from fric.notice import Notice
from fric.reference import circle as circular
from fric.simulate.contour_run import PointPath, RecordedPath
from fric.simulate.machine import Machine
from fric.simulate.reality.flaws import Clock, Excitation, NoiseColour
from tests.fuzz.whole import run_of_circles

N = 64
T = np.arange(N) * 1e-3
S = np.sin(T) * 1e-3

SPOILT: dict[str, Callable[[np.ndarray], Any]] = {
    "empty": lambda a: a[:0],
    "one sample": lambda a: a[:1],
    "shorter": lambda a: a[:-1],
    "a number": lambda a: 3.0,
    "rank 2": lambda a: np.stack([a, a]),
    "NaN": lambda a: np.where(np.arange(len(a)) == 5, np.nan, a),
    "all NaN": lambda a: a * np.nan,
    "infinite": lambda a: np.where(np.arange(len(a)) == 5, -np.inf, a),
    "1e300": lambda a: np.where(np.arange(len(a)) == 5, 1e300, a),
    "1e-300": lambda a: a * 1e-300,
    "complex": lambda a: a + 1j,
    "text": lambda a: ["a"] * len(a),
    "objects": lambda a: np.array([None, {}] * (len(a) // 2), object),
    "lists": lambda a: [[1.0], [1.0, 2.0]] * (len(a) // 2),
}
TIMES: dict[str, Callable[[np.ndarray], Any]] = {
    "equal": lambda a: 0.0 * a,
    "one equal": lambda a: np.where(np.arange(len(a)) == 9, a[8], a),
    "backwards": lambda a: a[::-1],
    "in 1e12 s": lambda a: a + 1e12,
}
MAP = StaticMap(60.0, 90.0, 2e-3)
BLOCKS = GMS(MAP, (0.6, 0.4), (1e8, 2e6))
FREQUENCY = np.geomspace(1.0, 100.0, N)


def circle(**changed: Any) -> MeasuredCircle:
    turn = np.linspace(0.0, 14.0, N)
    trace = {"time": T, "position": np.cos(turn), "reference": np.cos(turn), "input": S, "force": S} | changed
    return MeasuredCircle(1.0, 0.1, 1, {"x": AxisTrace(**trace), "y": AxisTrace(T, np.sin(turn))})


def ball_bar(**changed: Any) -> MeasuredCircle:
    return MeasuredCircle(1.0, 0.1, 1, **{"angle": np.linspace(0, 7, N), "deviation": S} | changed)


TYPES: dict[str, tuple[Callable[..., Any], dict[str, np.ndarray]]] = {
    "log": (Log, dict.fromkeys(("position", "velocity", "force", "input", "reference", "added"), S) | {"time": T}),
    "response": (
        FrequencyResponse,
        {"frequency": FREQUENCY, "magnitude": 1 / FREQUENCY, "phase": -FREQUENCY / 30, "coherence": FREQUENCY / 100},
    ),
    "table": (ForceVelocity, {"velocity": S, "force": S, "deviation": S**2, "error": S**2, "n": T + 9}),
    "circle": (circle, {"time": T, "position": np.cos(1e4 * S), "reference": S, "input": S, "force": S}),
    "ball bar": (ball_bar, {"angle": S, "deviation": S}),
    "points": (lambda **a: PointPath(**a, feed=0.1), {"x": T, "y": T**2}),
    "recorded": (RecordedPath, {"time": T, "x": T**2, "y": T**2}),
}
CASES = [
    pytest.param(make, whole | {name: spoil(whole[name])}, id=f"{kind}-{name}-{how}")
    for kind, (make, whole) in TYPES.items()
    for name in whole
    for how, spoil in (SPOILT | (TIMES if name == "time" else {})).items()
]


@pytest.mark.parametrize(("make", "series"), CASES)
def test_a_degenerate_member_is_refused_in_a_sentence(make: Callable[..., Any], series: dict[str, Any]) -> None:
    with pytest.raises(FricError) as told:
        make(**series)
    assert len(str(told.value).splitlines()) <= 2


ASKED = {  # Every method that takes numbers from a user
    "steady_state": MAP.steady_state, "level": MAP.level, "sliding_force": MAP.sliding_force,
    "virgin_curve": BLOCKS.virgin_curve, "response": LinearPlant(17.0, 2.4, 6e-4).response,
    "replay": lambda a: BLOCKS.replay(T, a), "replay with a velocity": lambda a: BLOCKS.replay(T, S, a),
}  # fmt: skip
NO_NUMBERS: dict[str, Callable[[np.ndarray], Any]] = {how: SPOILT[how] for how in ("complex", "text", "objects")} | {
    "masked": lambda a: np.ma.masked_array(a, a == a[5]),
    "dates": lambda a: a.astype("m8[s]"),
    "whole numbers beyond a double": lambda a: [10**400] * len(a),
}
OTHER_ARRAYS: dict[str, Callable[[np.ndarray], Any]] = {
    "Series": lambda a: pd.Series(a, index=np.arange(len(a))[::-1]),
    "read-only": lambda a: np.frombuffer(a.tobytes()),
    "with gaps": lambda a: np.repeat(a, 2)[::2],
    "big-endian": lambda a: a.astype(">f8"),
    "list": list,
}


@pytest.mark.parametrize("spoil", NO_NUMBERS.values(), ids=list(NO_NUMBERS))
@pytest.mark.parametrize("asked", ASKED.values(), ids=list(ASKED))
def test_what_is_no_number_is_refused_by_every_method(asked: Callable[[Any], Any], spoil: Callable[..., Any]) -> None:
    with pytest.raises(FricError, match="as numbers"):
        asked(spoil(S))
    with pytest.raises(FricError, match="as an array of numbers"):
        Log(T, position=spoil(S))


@pytest.mark.parametrize("other", OTHER_ARRAYS.values(), ids=list(OTHER_ARRAYS))
@pytest.mark.parametrize("asked", ASKED.values(), ids=list(ASKED))
def test_numbers_count_and_not_how_they_are_held(asked: Callable[[Any], Any], other: Callable[..., Any]) -> None:
    """A column of a data frame is read-only since pandas 3, which no compiled loop takes."""
    v = S + 1e-3
    assert np.array_equal(asked(other(v)), asked(v))
    log = Log(other(T), position=other(S))
    assert np.array_equal(BLOCKS.replay(log.time, log.require("position", "a replay")), BLOCKS.replay(T, S))


@pytest.mark.parametrize(
    "motion",
    [
        (T[:2], S[:2]), (T, S[:-1]), (T[:0], S[:0]), (np.stack([T, T]), np.stack([S, S])), (T * 0.0, S), (T[::-1], S),
        (T, S, 1.0), (T, S, S[:-1]), (T, S, S, np.zeros(2)), (T, S, S, "relaxed"), (T, S, S, [0.0] * 8),
    ],
)  # fmt: skip
def test_a_motion_that_is_none_is_replayed_by_no_model(motion: tuple[Any, ...]) -> None:
    """A state of another size was written beyond its end."""
    with pytest.raises(FricError):
        BLOCKS.replay(*motion)


@pytest.mark.parametrize(("make", "whole"), TYPES.values(), ids=list(TYPES))
def test_what_they_are_made_from_is_taken(make: Callable[..., Any], whole: dict[str, np.ndarray]) -> None:
    make(**whole)


@pytest.mark.parametrize("value", ["1e303", "-1e15", "inf"])
@pytest.mark.parametrize("column", [0, 1, 2])
def test_a_cell_beyond_every_machine_is_told_with_its_line(tmp_path: Path, value: str, column: int) -> None:
    """As 1e303 m from CSV, TDMS and .mat, taken without a word before."""
    rows = [[f"{t:.3f}", "1.0", "2.0"] for t in T]
    rows[-1][column] = value
    path = tmp_path / "log.csv"
    path.write_text("time [s],position [m],force [N]\n" + "\n".join(map(",".join, rows)))
    with pytest.raises(FricError, match=f"line {N + 1}"):
        ingest(path, tmp_path / "log.h5")
    if column:
        assert ingest(path, tmp_path / "log.h5", bad_cells="drop").dropped == 1


@pytest.mark.parametrize("values", [np.full(N, 1e303), np.where(T > 0.01, np.nan, S), np.zeros(N - 1)])
def test_a_log_file_of_others_is_held_to_the_same(tmp_path: Path, values: np.ndarray) -> None:
    path = tmp_path / "log.h5"
    write_logs(path, [Log(T, position=S, name="a", source="a")])
    with h5py.File(path, "a") as file:
        file["records/a"].create_dataset("force", data=values)
    with pytest.raises(FricError, match="record 'a'"):
        read_records(path)


def turning(seconds: float, rate: float = 2000.0, **gaps: float) -> MeasuredCircle:
    t = np.arange(seconds * rate) / rate
    t = np.where(np.arange(len(t)) < len(t) // 2, t, t + gaps.get("gap", 0.0))
    angle = 25.0 * t
    axes = {name: AxisTrace(t, z + 1e-7, z, z * 10) for name, z in (("x", np.cos(angle)), ("y", np.sin(angle)))}
    axes = {
        name: replace(one, position=one.position * 2e-3, reference=one.reference * 2e-3) for name, one in axes.items()
    }
    return MeasuredCircle(2e-3, 0.05, 1, axes)


def test_no_samples_hold_no_circle() -> None:
    assert find_circles(*np.empty((3, 0))) == []


def test_an_infinite_attribute_is_damage_of_the_file(tmp_path: Path) -> None:
    with pytest.raises(FricError, match="is damaged"), foreign(tmp_path / "a.h5", "Export it again.", lacking=True):
        int(np.inf)


def test_an_exception_without_words_is_damage_alone(tmp_path: Path) -> None:
    with pytest.raises(FricError, match="bag: is damaged\nMake"), foreign(tmp_path / "a.bag"):
        exec("raise AssertionError")  # as a library raises it


def test_an_axis_that_stands_still_on_a_circle_is_refused() -> None:
    with pytest.raises(FricError, match="axis x moves by 0 µm on a circle of 1e\\+03 mm"):
        circle(position=np.zeros(N))


@pytest.mark.parametrize(
    ("test", "match"),
    [
        (turning(0.01), "less|too little|a whole revolution"),
        (turning(0.1), "too little of the circle"),
        (turning(0.5, gap=1e6), "samples cover the time of"),
    ],
)
def test_a_circle_that_is_none_is_told_before_it_is_tuned_by(test: MeasuredCircle, match: str) -> None:
    """As a singular matrix, an empty filter, and an array of terabytes."""
    with pytest.raises(FricError, match=match):
        voltage_record(test, "x")


@pytest.mark.parametrize("value", [1.0, "a", [], None, True])
def test_what_is_in_place_of_a_part_that_fric_wrote_is_refused(value: Any) -> None:
    """As "'float' object has no attribute 'scheme'" in a report."""
    with pytest.raises(ValidationError):
        ContourScheme.model_validate(value)


@pytest.mark.parametrize("value", [np.nan, 1e300])
def test_a_feedforward_that_no_machine_had_is_refused(tmp_path: Path, value: float) -> None:
    path = tmp_path / "table.h5"
    with h5py.File(path, "w") as file:
        file.attrs["fric"] = "feedforward/1"
        file["x/voltage"] = np.where(T > 0.01, value, 0.0)
    with pytest.raises(FricError, match="axis x: the voltage"):
        read_feedforward(path)


@pytest.mark.parametrize("value", [np.inf, 1e300, np.nan])
def test_gains_that_no_drive_has(value: float) -> None:
    """As eigenvalues of infinity in `design`."""
    with pytest.raises(FricError, match="K_p of the controller is"):
        Cascade(100.0, value, 1.0, 500.0, 4000.0)
    with pytest.raises(FricError, match="B of the plant is"):
        LinearPlant(1.0, value, 1e-3)


def test_a_lead_that_asks_for_terabytes() -> None:
    with pytest.raises(FricError, match="a lead of 1e"):
        circular(0.01, 0.1, 1, 4000.0)[0].ahead(1e9)


@pytest.mark.parametrize("name", ["angle", "error", "axes/x/time", "axes/x/position", "axes/y/input"])
@pytest.mark.parametrize("how", ["empty", "shorter", "NaN", "1e300"])
def test_a_run_whose_series_no_report_can_bear_is_refused(tmp_path: Path, name: str, how: str) -> None:
    """As an index that did not match, deep in a report."""
    path = tmp_path / "run.h5"
    run_of_circles(path)
    with h5py.File(path, "a") as file:
        held = file[f"a/{name}"][()]
        del file[f"a/{name}"]
        file[f"a/{name}"] = SPOILT[how](held)
    with pytest.raises(FricError, match="scheme 'a'"):
        read_runs(path)


RIG = read_machine("virtual-rig")
AXIS = RIG.axis("x")
NOTHING = float("nan")


@pytest.mark.parametrize(
    "make",
    [
        lambda: Encoder(1e-7, cast("Any", "x")), lambda: Encoder(1e-7, NOTHING), lambda: Encoder(1e-7, 2.0),
        lambda: Encoder(cast("Any", np.timedelta64(5, "s"))),
        lambda: QFilter("binomial2", cast("Any", np.longdouble(1))),
        lambda: replace(AXIS, load=NOTHING), lambda: replace(AXIS, load=1e300), lambda: replace(AXIS, force_noise=-1.0),
        lambda: replace(AXIS, name="../x"), lambda: replace(AXIS, blocks={"kalman": cast("Any", 5)}),
        lambda: replace(AXIS.nominal_friction, gain=cast("Any", b"5")),
        lambda: replace(AXIS.nominal_friction, models={"gms": cast("Any", 5)}),
        lambda: Machine("m", {"x": cast("Any", 5)}),
        lambda: RIG.is_nominal(["gms"], ["z"]),
        lambda: replace(AXIS.reality, encoder=cast("Any", "x")), lambda: replace(AXIS.reality, gravity=NOTHING),
        lambda: replace(AXIS.reality, cogging=cast("Any", (1.0,))), lambda: NoiseColour(cast("Any", "x"), 2.0),
        lambda: Clock(jitter=np.inf),
        lambda: Excitation(20, cast("Any", b"x"), 300.0), lambda: Excitation(20, 2.0, -1.0),
        lambda: Log(T, position=S).require("__class__", "a test"), lambda: Notice.of({"text": "x"}),
        lambda: Log.from_frame({"time": T, "position": S + 1j}), lambda: replace(AXIS.reality, gravity=1e300),
        lambda: fric.identify_model("dahl", Log(T, position=S, force=S), fix={"x": 1.0}),
        lambda: fric.design_observer(AXIS.plant, resonances=["80 Hz, x"]),
        lambda: fric.design_observer(AXIS.plant, resonances=cast("Any", [[80.0, 0.02]])),
    ],
)  # fmt: skip
def test_what_no_machine_and_no_record_has_is_refused_where_it_is_given(make: Callable[[], Any]) -> None:
    with pytest.raises(FricError):
        make()


def test_the_version_of_a_document_is_of_that_document(tmp_path: Path, recwarn: pytest.WarningsRecorder) -> None:
    """The next document was read as YAML 1.1 too, in which 010 is 8 and a warning of the parser was printed."""
    text = "fric: spread/1\nspreads:\n  level: {distribution: uniform, factor: {value: [05e-1, 010], unit: '1'}}\n"
    (tmp_path / "old.yaml").write_text(f"%YAML 1.1\n---\n{text}")
    (tmp_path / "new.yaml").write_text(text)
    before, after = read_spreads(tmp_path / "old.yaml"), read_spreads(tmp_path / "new.yaml")
    assert (before["level"].high, after["level"].high) == (8.0, 10.0)
    assert not recwarn


@pytest.mark.parametrize("frequency", [0.0, [1.0, 0.0], NOTHING, np.inf, 1e300, 1e-300])
@pytest.mark.parametrize("hold", [None, 4000.0])
def test_an_axis_has_no_response_where_it_is_none(frequency: Any, hold: float | None) -> None:
    """As infinity and NaN, with a warning of NumPy."""
    with pytest.raises(FricError):
        AXIS.plant.response(frequency, hold)


@pytest.mark.parametrize("sampling", [0.0, -1.0, NOTHING, np.inf, 1e300])
def test_a_controller_samples_at_some_rate(sampling: float) -> None:
    with pytest.raises(FricError):
        replace(AXIS.plant, T_d=0.0).transport_delay(sampling)
    with pytest.raises(FricError):
        AXIS.plant.response(1.0, sampling)


JUNK: dict[str, Any] = {
    "nothing": None, "text": "x", "bytes": b"x", "list": [None], "object": object(), "complex": 1j,
    "beyond a double": 10**400, "texts": np.array(["a"]), "matrix": np.array([[1.0, 2.0]]), "odd keys": {1: 2},
}  # fmt: skip
NAMES = [getattr(fric, name) for name in fric.__all__]  # A class explains what it refuses once it was asked for
PUBLIC = [
    fric.Scheme.of, fric.Estimate.read, fric.Estimate.around, fric.Estimate.around_log, fric.Notice.of,
    fric.GMS.from_sections, fric.Cascade.check, fric.Cascade.designed, fric.DisturbanceObserver.designed, AXIS.placed,
    AXIS.plant.held, AXIS.plant.transport_delay, AXIS.plant.response, RIG.axis, RIG.placed, BLOCKS.fields_from,
    AXIS.encoder.read, Log(T, position=S).unit, Log(T, position=S).slice,
]  # fmt: skip
TAKEN = {  # By some, and rightly
    ("Notice.of", "text"), ("Machine.axis", "text"), ("Encoder.read", "matrix"), ("Encoder.read", "list"),
    ("LinearPlant.response", "matrix"), ("Log.slice", "nothing"),
}  # fmt: skip


@pytest.mark.parametrize("junk", JUNK)
@pytest.mark.parametrize("asked", PUBLIC, ids=lambda asked: asked.__qualname__)
def test_junk_is_refused_by_every_method_with_its_name(asked: Callable[..., Any], junk: str) -> None:
    """As a `TypeError` or `KeyError` from inside."""
    needed = [name for name, one in inspect.signature(asked).parameters.items() if one.default is one.empty]
    with nullcontext() if (asked.__qualname__, junk) in TAKEN else pytest.raises(FricError):
        asked(**dict.fromkeys(needed, JUNK[junk]))


@pytest.mark.parametrize(
    "make",
    [
        lambda: fric.Scheme.of({"name": "a", "title": "b", "blocks": 3}), lambda: fric.Scheme.of({"name": "a"}),
        lambda: fric.Scheme.of({"name": "a", "title": "b", "blocks": [None]}),
        lambda: fric.Estimate.read({}), lambda: fric.Estimate.read({"value": 1.0}),
        lambda: fric.Estimate.read({"value": [1.0, "x"], "unit": "N"}),
        lambda: fric.Estimate.read({"value": 1.0, "unit": "N", "fixed": "x"}), lambda: Log(T, position=S).unit("x"),
    ],
)  # fmt: skip
def test_what_is_in_a_mapping_is_refused_as_where_it_stands_alone(make: Callable[[], Any]) -> None:
    with pytest.raises(FricError):
        make()


def test_an_empty_list_in_place_of_a_choice_is_refused() -> None:
    """`models=[]` ended in "max() arg is an empty sequence"."""
    with pytest.raises(FricError, match="`models=` of compare is empty"):
        fric.compare("data/presliding-sine.h5", models=[])
    with pytest.raises(FricError, match="`schemes=` of circle is empty"):
        fric.circle("xy-table", ())
