"""What controls write as text: TwinCAT's Scope, SINUMERIK's traces."""

import re
from contextlib import closing

import numpy as np
import pytest

from fric import FricError
from fric.documents.mapping import MappingDocument
from fric.io.hdf5 import read_logs
from fric.io.ingest import ingest
from fric.io.readers import tables

CONTROLLER, DRIVE = np.arange(2000) * 0.5, np.arange(500) * 2.0  # ms


def mapping(**columns):
    return MappingDocument.model_validate({"fric": "mapping/1", "columns": {"time": {"column": "time"}, **columns}})


def read(path, **given):
    done = ingest(path, path.with_suffix(".h5"), force=True, **given)
    return done, read_logs(path.with_suffix(".h5"))[0]


def scope(path, *, mark=",", delimiter="\t", fill=False, tail="", full=True, scale="1"):
    """Write an export as Scope View 3.4 does: groups of a time and its channels, rows cut where the slow ones end."""
    names = ["Name", "position", "velocity", "Name", "torque"]
    about = {
        "SymbolName": ["MAIN.pos", "MAIN.vel", "MAIN.trq"], "Data-Type": ["REAL64"] * 3,
        "Unit": ["mm (Length)", "(None)", "N (Force)"],
        "SampleTime[ms]": ["0.5", "0.5", "2"], "ScaleFactor": ["1", "1", scale], "Offset": ["0"] * 3,
    }  # fmt: skip

    def text(value):
        return f"{value:.7g}".replace(".", mark)

    lines = [
        "Name|scope",
        "File|a.svdx",
        "Starttime of export|132959733843760000|Montag|15:56:24",
        "Endtime of export|1",
        "",
        "",
    ]
    lines.append("|".join(names))
    for key, (a, b, c) in about.items() if full else ():
        lines.append("|".join([key, a.replace(".", mark), b.replace(".", mark), key, c.replace(".", mark)]))
    lines.append("")
    for n, t in enumerate(CONTROLLER):
        cells = [text(t), text(np.sin(t * 1e-3)), text(np.cos(t * 1e-3))]
        slow = n // 4 if fill else n
        if slow < len(DRIVE):
            cells += [text(DRIVE[slow]), text(7 * np.cos(DRIVE[slow] * 1e-3))]
        lines.append("|".join(cells))
    lines.append(text(CONTROLLER[-1] + 0.5) + "|")  # a last instant without values, as genuine files have it
    path.write_bytes(("\r\n".join([*lines, tail])).replace("|", delimiter).encode("utf-8"))
    return path


@pytest.mark.parametrize(("mark", "delimiter"), [(",", "\t"), (",", ";"), (".", "\t"), (".", ",")])
@pytest.mark.parametrize("fill", [False, True])
def test_scope(tmp_path, mark, delimiter, fill):
    path = scope(tmp_path / "scope.csv", mark=mark, delimiter=delimiter, fill=fill, tail="EOF" if fill else "")
    done, log = read(path, mapping=mapping(position={"column": "position"}, force={"column": "torque"}))
    np.testing.assert_allclose(log.time, DRIVE * 1e-3, rtol=1e-12)
    np.testing.assert_allclose(log.position, 1e-3 * np.sin(DRIVE * 1e-3), atol=1e-9)
    np.testing.assert_allclose(log.force, 7 * np.cos(DRIVE * 1e-3), atol=1e-5)
    assert any("one sample in 4 is taken" in warning for warning in done.warnings)
    velocity = {"column": "velocity", "unit": "mm/s"}
    assert len(read(path, mapping=mapping(velocity=velocity))[1]) == len(CONTROLLER)  # alone, at its own rate


def test_scope_with_names_alone_and_with_a_scale_that_the_file_leaves_open(tmp_path):
    position = {"column": "position", "unit": "mm"}
    done, log = read(scope(tmp_path / "names.csv", full=False), mapping=mapping(position=position))
    np.testing.assert_allclose(log.position, 1e-3 * np.sin(CONTROLLER * 1e-3), atol=1e-9)
    assert not done.warnings
    done, _ = read(scope(tmp_path / "scaled.csv", scale="-2"), mapping=mapping(position=position))
    assert [warning.code for warning in done.warnings] == ["scope-scale"]
    assert "'torque'" in done.warnings[0]


def test_scope_without_data(tmp_path):
    (tmp_path / "a.csv").write_text("Name;a\nFile;b\nStarttime of export;1\nEndtime of export;2\n\n\nName;x\n\n")
    with pytest.raises(FricError, match="a header and no data"):
        read(tmp_path / "a.csv")


def trace(path, *, body=None):
    """Write a trace with the elements that are known in public; a second signal is sampled every fourth time."""
    rows = [
        f'<rec time="{n * 0.002!r}" f1="{float(np.sin(n * 0.002))!r}"'
        + (f' f2="{3.0 + n}"' if n % 4 == 0 and n else "")
        + "/>"
        for n in range(3000)
    ]
    rows[0] = '<rec time="0.0" f1="9221120237041090560" f2="9221120237041090560"/>'
    signals = (
        '<dataSignal name="/Nck/Servo/posAct[1]" description="Position X"/>'
        '<dataSignal name="/Drive/torque" description="Torque X"/>'
    )
    frame = f"<dataFrame>{signals}{''.join(rows)}</dataFrame>"
    text = f'<?xml version="1.0" encoding="UTF-8"?><root><traceData>{frame}</traceData></root>'
    path.write_text(body if body is not None else text)
    return path


def test_trace(tmp_path):
    columns = {"position": {"column": "Position X", "unit": "mm"}, "force": {"column": "Torque X", "unit": "N"}}
    done, log = read(trace(tmp_path / "trace.xml"), mapping=mapping(**columns))
    np.testing.assert_allclose(np.diff(log.time), 0.008, rtol=1e-9)
    assert (log.time[0], log.time[-1]) == pytest.approx((0.008, 5.992), abs=1e-9)  # those of the force
    np.testing.assert_allclose(log.position, 1e-3 * np.sin(log.time), rtol=1e-12)
    np.testing.assert_allclose(log.force, 3.0 + log.time / 0.002, rtol=1e-12)
    assert any("2 samples hold no value" in warning for warning in done.warnings)


@pytest.mark.parametrize(
    ("body", "what"),
    [
        ("<root><traceData><dataSignal name='a'/><rec time='0' f1='1'/>", "not complete XML"),
        ("<root><traceData><dataSignal name='a'/><rec time='0' f7='1'/></traceData></root>", "does not read"),
        ("<root><traceData><dataSignal name='a'/><rec f1='1'/></traceData></root>", "does not read"),
        ("<root><traceData><dataSignal name='a'/></traceData></root>", "holds no samples"),
        ("<root><traceData/></root>", "names no signal"),
        ('<!DOCTYPE a [<!ENTITY b "c">]><root><traceData>&b;</traceData></root>', "declares a document type"),
    ],
)
def test_a_trace_that_is_none(tmp_path, body, what):
    with pytest.raises(FricError, match=what):
        read(trace(tmp_path / "trace.xml", body=body))


def halsampler(path, *, lose=(), clock=True):
    """Write a record as halsampler -t does: a blank behind each number, no header, floats with six decimals."""
    kept = [n for n in range(6000) if n not in lose]
    rows = [
        f"{k} {1_000_000 + 250_000 * n if clock else 7} {3e3 * np.sin(n * 25e-5):.6f} {np.cos(n * 25e-5):.6f} \n"
        for k, n in enumerate(kept)
    ]
    path.write_text("".join(rows))
    return path


HAL = {"position": {"column": 2, "unit": "mm"}, "input": {"column": 3, "unit": "V"}}


def test_halsampler(tmp_path):
    given = MappingDocument.model_validate({"fric": "mapping/1", "columns": {"time": {"rate": "4 kHz"}, **HAL}})
    _, log = read(halsampler(tmp_path / "trace.txt"), mapping=given)
    np.testing.assert_allclose(log.time, np.arange(6000) * 25e-5, rtol=1e-12)
    np.testing.assert_allclose(log.position, 3 * np.sin(np.arange(6000) * 25e-5), atol=6e-10)


@pytest.mark.parametrize("at", [5, 60, 4500])  # in what is looked at first, behind it, and in the middle
def test_rows_that_halsampler_lost_are_told_by_the_clock_though_its_own_count_goes_on(tmp_path, at):
    given = MappingDocument.model_validate({"fric": "mapping/1", "columns": {"time": {"rate": "4 kHz"}, **HAL}})
    path = halsampler(tmp_path / "trace.txt", lose=range(at, at + 3))
    with pytest.raises(FricError, match=rf"line {at + 1}, column 'column 1': 3 rows are lost") as refused:
        read(path, mapping=given)
    assert "deeper sampler" in str(refused.value)


def test_a_count_of_periods_that_jumps_is_a_lost_row(tmp_path):
    lines = halsampler(tmp_path / "whole.txt", clock=False).read_text().splitlines(keepends=True)
    (tmp_path / "trace.txt").write_text("".join(lines[:3000] + lines[3001:]))
    time = {"time": {"column": 0, "scale": "0.25 ms"}}
    given = MappingDocument.model_validate({"fric": "mapping/1", "columns": {**time, **HAL}})
    assert len(read(tmp_path / "whole.txt", mapping=given)[1]) == 6000
    with pytest.raises(FricError, match=r"line 3001.*1 rows are lost: the count jumps from 2999 to 3001"):
        read(tmp_path / "trace.txt", mapping=given)


@pytest.mark.parametrize("comma", [False, True])
@pytest.mark.parametrize("head", ["Sampling period is 100000 nSec", "Sampling period is 100000 ns",
                                  "# Sampling period is 100000 ns"])  # fmt: skip
def test_halscope_in_either_locale_without_its_last_zeros(tmp_path, head, comma):
    """Of the current form, which names the pins once, it was said that the sampling period is not in it."""
    t = np.arange(3000) * 1e-4
    v = np.convolve(np.sign(np.sin(40 * t)), np.hanning(80) / np.hanning(80).sum(), "same")
    z, output = np.cumsum(v) * 1e-4, np.tanh(v / 0.01) + 0.01 * np.random.default_rng(0).standard_normal(len(t))
    pins = ("joint.0.motor-pos-fb", "pid.x.output", "joint.0.motor-pos-fb")
    rows = [" ".join(f"{pin} {one:.6f}" for pin, one in zip(pins, (a, b, a), strict=True))
            for a, b in zip([*z, 0.0], [*output, 0.0], strict=True)]  # fmt: skip
    if head.startswith("#"):
        rows = [";".join(pins), "# Position: 0.5;0.5;0.5", *(";".join(row.split()[1::2]) + ";" for row in rows)]
    text = head + "\n" + "\n".join(rows) + "\n"
    path = tmp_path / "scope.log"
    path.write_text(re.sub(r"(\d)\.(\d{6})", r"\1,\2", text) if comma else text)
    with closing(tables(path)) as found:
        (table,) = found
        (block,) = table.read(range(4))
    assert [column.name for column in table.columns] == ["time", pins[0], pins[1], f"{pins[0]} (2)"]
    assert len(block.columns[0]) == 3000
    np.testing.assert_allclose(np.diff(block.columns[0]), 1e-4)
    np.testing.assert_allclose(block.columns[1], z, atol=1e-6)


def test_an_empty_cell_of_halscope_moves_no_other(tmp_path):
    (tmp_path / "scope.csv").write_text("# Sampling period is 1000000 ns\na;b;c\n1;2;3\n4;;6\n7;8\n")
    with closing(tables(tmp_path / "scope.csv")) as found:
        (block,) = next(found).read([1, 2, 3])
    np.testing.assert_array_equal(np.transpose(block.columns), [[1, 2, 3], [4, np.nan, 6], [7, 8, np.nan]])


@pytest.mark.parametrize("body", ["", "a 1 b 2\nb 2 a 1\n", "a 1 b\n"])
def test_a_halscope_record_that_is_none(tmp_path, body):
    path = tmp_path / "scope.log"
    path.write_text("Sampling period is 100000 nSec\n" + body)
    with pytest.raises(FricError), closing(tables(path)) as found:
        next(found)
