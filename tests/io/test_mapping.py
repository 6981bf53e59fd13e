"""Mapping files: what they say is done, and what does not fit is told with its line and its mend."""

import numpy as np
import pytest

from fric import FricError
from fric.documents.mapping import MappingDocument
from fric.documents.yaml import read_document, read_text
from fric.io.hdf5 import read_logs, read_records
from fric.io.ingest import ingest

LOG = "Zeit;Weg;Kraft;rest\n0;0;1;a\n1;2;1;b\n2;4;1;c\n3;6;1;d\n"


def mapping(tmp_path, text):
    (tmp_path / "map.yaml").write_text("fric: mapping/1\n" + text)
    return read_document(tmp_path / "map.yaml", MappingDocument)


def through(tmp_path, text, log=LOG, name="log.csv", **options):
    path = tmp_path / name
    path.parent.mkdir(exist_ok=True)
    path.write_text(log)
    done = ingest(path, tmp_path / "log.h5", mapping=mapping(tmp_path, text), force=True, **options)
    (record,) = read_records(tmp_path / "log.h5")
    return done, record


def test_columns_units_scales_and_signs(tmp_path):
    done, log = through(
        tmp_path,
        """
axis: z
motion: rotary
kind: motion
columns:
  time: {column: 0, unit: ms}
  position: {column: weg, unit: deg, sign: -1}
  force: {column: Kraft, scale: "-2 mN*m"}
""",
    )
    np.testing.assert_allclose(log.time, [0, 1e-3, 2e-3, 3e-3])
    np.testing.assert_allclose(log.position, -np.deg2rad([0, 2, 4, 6]))
    np.testing.assert_allclose(log.force, -2e-3)
    assert (log.axis, log.motion, log.kind, log.name) == ("z", "rotary", "motion", "log")
    assert done.records[0].left_out == ["rest"]
    assert done.records[0].channels == {"time": "Zeit", "position": "Weg", "force": "Kraft"}


def test_what_only_the_file_name_holds(tmp_path):
    _, log = through(tmp_path, """
axis: "{axis}"
record: "{parent}-{run}"
file: "{axis}_{speed}mmps_{run}"
columns:
  time: {rate: 2 kHz}
  velocity: {value: "{speed} mm/s"}
  force: {column: Kraft, unit: N}
""", name="monday/y_2.5mmps_7.csv")  # fmt: skip
    assert (log.axis, log.name) == ("y", "monday-7")
    np.testing.assert_allclose(log.velocity, 2.5e-3)
    np.testing.assert_allclose(log.time, np.arange(4) / 2000)
    with pytest.raises(FricError, match=r"'x-3' is not made like '\{axis\}_\{speed\}mmps_\{run\}'"):
        ingest(tmp_path / "x-3.csv", tmp_path / "new.h5", mapping=mapping(tmp_path, (
            'file: "{axis}_{speed}mmps_{run}"\ncolumns: {time: {rate: 1 kHz}, position: {column: Weg, unit: m}}\n'
        ))) if (tmp_path / "x-3.csv").write_text(LOG) else None  # fmt: skip


def test_a_sampling_period_from_the_preamble(tmp_path):
    _, log = through(tmp_path, """
columns:
  time: {period: "{Sampling period} ms"}
  position: {column: Weg, unit: mm}
""", log="Sampling period:;51.200\n" + LOG)  # fmt: skip
    np.testing.assert_allclose(log.time, np.arange(4) * 51.2e-3)


def test_dropped_samples_keep_a_time_that_was_not_logged(tmp_path):
    done, log = through(tmp_path, "columns: {time: {rate: 1 kHz}, position: {column: Weg, unit: mm}}\n",
                        log=LOG.replace("1;2", "1;x"), bad_cells="drop")  # fmt: skip
    np.testing.assert_allclose(log.time, [0, 2e-3, 3e-3])
    assert done.dropped == log.dropped == 1
    assert (done.warnings[0].code, done.warnings[0].values) == ("cells-dropped", {"dropped": 1, "samples": 4})


def test_a_frequency_response_in_decibel_and_degrees(tmp_path):
    _, response = through(tmp_path, """
kind: frequency-response
columns:
  frequency: {column: f, unit: Hz}
  magnitude: {column: mag, unit: "dB(um/V)"}
  phase: {column: ph, unit: deg}
""", log="f,mag,ph\n1,20,-170\n2,0,170\n4,-20,160\n")  # fmt: skip
    np.testing.assert_allclose(response.magnitude, [10e-6, 1e-6, 0.1e-6])
    np.testing.assert_allclose(np.rad2deg(response.phase), [-170, -190, -200])


@pytest.mark.parametrize(
    ("text", "line", "told", "hint"),
    [
        ("columns: {time: {column: 0, unit: s}, force: {column: 1, unit: mm}}", 2, "force cannot be in 'mm'", "N"),
        ("motion: rotary\ncolumns:\n  force: {column: 1, unit: N}", 4, "force cannot be in 'N'", "is it linear?"),
        ("columns:\n  power: {column: 1, unit: W}", 3, "'power' is not a channel", "Channels are time, position"),
        ("columns:\n  time: {column: 0, unit: s, sign: -1}", 3, "has no sign", "rate or period"),
        ("columns:\n  force: {column: 0, unit: N, scale: 2 N}", 3, "both unit and scale", "Keep one"),
        ("columns:\n  force: {unit: N}", 3, "neither column nor value", "Name its column"),
        ("columns:\n  force: {column: 1, scale: 0.0984}", 3, "give a text", ""),
        ("columns:\n  force: {column: 1, scale: '0.0984'}", 3, "has no unit", "0.0984 N"),
        ("columns:\n  force: {column: 1, sign: 2, unit: N}", 3, "it should be 1 or -1", ""),
        ("columns:\n  position: {column: 1, unit: furlongs/s}", 3, "position cannot be in", "converts to m"),
        ("columns:\n  position: {column: 1, unit: blub}", 3, "'blub' is not a unit", "converts to m"),
        ("motion: rotary\ncolumns:\n  position: {column: 1, unit: count}", 4, "what angle it is", "scale"),
        ("format: {decimal: ';'}\ncolumns: {}", 2, "it should be", ""),
        ("colums: {}", 2, "not a known key", "fric schema mapping"),
    ],
)
def test_a_mapping_that_does_not_fit(tmp_path, text, line, told, hint):
    with pytest.raises(FricError) as caught:
        mapping(tmp_path, text + "\n")
    message = str(caught.value)
    assert f"map.yaml, line {line}:" in message
    assert told in message
    assert hint in message
    assert len(message.splitlines()) <= 2


@pytest.mark.parametrize(
    ("columns", "told"),
    [
        ("time: {column: Zeit, unit: s}, position: {column: Ort, unit: m}", "The columns are 'Zeit', 'Weg', 'Kraft'"),
        ("time: {column: Zeit, unit: s}, position: {column: 9, unit: m}", "there are 4, counted from 0"),
        ("time: {column: Zeit, unit: s}, position: {column: Weg}", "column 'Weg' (position) has no unit"),
        ("time: {column: Zeit, unit: s}, position: {column: Weg, scale: '{pitch} mm'}", "there is no field '{pitch}'"),
        ("position: {column: Weg, unit: m}", "no column is time"),
        ("time: {column: Zeit, unit: s}, force: {column: Kraft, unit: N}", "no column is position or velocity"),
        ("time: {rate: 1 kHz}, velocity: {value: 1 m/s}", "no channel is read from a column"),
        ("time: {rate: 0 Hz}, position: {column: Weg, unit: m}", "a sampling period of 0 s is none"),
    ],
)
def test_a_mapping_that_does_not_fit_the_log(tmp_path, columns, told):
    with pytest.raises(FricError) as caught:
        through(tmp_path, f"columns: {{{columns}}}\n")
    assert told in str(caught.value)
    assert len(str(caught.value).splitlines()) <= 2
    assert not (tmp_path / "log.h5").exists()


@pytest.mark.parametrize(
    ("header", "motion"), [("position [deg],force [Nm]", "rotary"), ("position [um],force [N]", "linear")]
)
def test_the_units_tell_the_motion(tmp_path, header, motion):
    (tmp_path / "log.csv").write_text(f"time [s],{header}\n0,0,1\n1,1,1\n2,2,1\n")
    assert ingest(tmp_path / "log.csv", tmp_path / "log.h5").motion == motion


def test_a_stated_sign_is_taken_as_it_is(tmp_path):
    log = "t;x;F\n" + "".join(f"{n};{n};-9.81\n" for n in range(50))
    columns = "time: {{column: t, unit: s}}, position: {{column: x, unit: mm}}, force: {{column: F, unit: N{}}}"
    with pytest.raises(FricError, match="the force opposes the motion throughout"):
        through(tmp_path, f"columns: {{{columns.format('')}}}\n", log=log)
    _, record = through(tmp_path, f"columns: {{{columns.format(', sign: 1')}}}\n", log=log)  # a load going down
    np.testing.assert_array_equal(record.force, -9.81)


def test_velocity_against_position(tmp_path):
    log = "time [s];position [mm];velocity [mm/s]\n" + "".join(f"{n};{n};-1\n" for n in range(50))
    (tmp_path / "log.csv").write_text(log)
    with pytest.raises(FricError, match="velocity and position run against each other"):
        ingest(tmp_path / "log.csv", tmp_path / "log.h5")


def test_rpm_and_its_german_spellings(tmp_path):
    for unit in ("rpm", "1/min", "U/min", "min⁻¹"):
        (tmp_path / "log.csv").write_text(f"time [s];velocity [{unit}]\n0;60\n1;60\n2;60\n")
        ingest(tmp_path / "log.csv", tmp_path / "log.h5", motion="rotary", force=True)
        (log,) = read_logs(tmp_path / "log.h5")
        np.testing.assert_allclose(log.velocity, 2 * np.pi)


def test_a_mapping_that_is_proposed_and_does_not_fit_is_an_error_with_its_place():
    text = "fric: mapping/1\nmotion: linear\ncolumns:\n  position: {column: s, unit: deg}\n"
    with pytest.raises(FricError, match=r"the mapping proposed.*position cannot be in 'deg'"):
        read_text(text, MappingDocument)
