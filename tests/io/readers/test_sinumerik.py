"""Traces in the form of genuine ones: sparse, late, slow, reordered; every value as the facts say."""

import re
from contextlib import closing
from pathlib import Path
from time import process_time

import numpy as np
import pytest

import fric
from fric.automatic.sources import find_sources
from fric.io.hdf5 import read_logs
from fric.io.readers import tables
from fric.io.readers.sinumerik import recognises

SIGNALS = (
    ("nckServoDataCmdPos2ndEnc64", "posn"), ("nckServoDataActPos2ndEnc64", "posn"),
    ("nckServoDataActPos1stEnc64", "posn"), ("nckServoDataActCurr", "current"),
    ("nckServoDataActVelMotorSide", "veloRot"),
    ("nckServoDataActVel", "velo"),
)  # fmt: skip
SETUP = "<traceCaptureSetup_V20>" + "<item name='x' value='1'/>" * 800 + "</traceCaptureSetup_V20>"


def trace(path: Path, values: np.ndarray, rng: np.random.Generator, *, axes: int = 1, slow: int = -1) -> Path:
    """Write a trace as SINUMERIK Operate does: what is as before is left out, and so are records; order is any."""
    n, k = values.shape
    attributes = []
    for m in range(k):
        name, units = SIGNALS[m % len(SIGNALS)]
        axis, interval = 1 + m // len(SIGNALS), 0.004 if m == slow else 0.002
        own = [f'id="f{m + 1}"', f'name="/Nck/!SD/{name} [u1, {axis}]"', f'description="Signal {m}"',
               f'interval="{interval:.6f}"', f'datapointCount="{n}"', f'unitsType="{units}"']  # fmt: skip
        attributes.append("<dataSignal " + " ".join(rng.permutation(own)) + "/>")
    rows, before = [], [None] * k
    for r in range(n):
        texts = [f"{one:.6f}" for one in values[r]]
        there = [m for m in range(k) if texts[m] != before[m] and (m != slow or r % 2 == 0)]
        for m in there:
            before[m] = texts[m]
        if there or r == n - 1:
            cells = [f'f{m + 1}="{texts[m]}"' for m in rng.permutation(there or [0])]
            rows.append(f'<rec time="{0.002 * r:.6f}" {" ".join(cells)}/>')
    frame = "<frameHeader dropOuts='0' startTime='2024-05-01T10:00:00Z' stopInc='0.002'/>" + "".join(attributes)
    body = f"{SETUP}<traceData dataFrames='1'><dataFrame>{frame}{''.join(rows)}</dataFrame></traceData>"
    path.write_text(
        f"<?xml version='1.0' encoding='utf-8'?>\n<traceSession version='01.00.03.02'>{body}</traceSession>"
    )
    return path


def motion(n: int, k: int, rng: np.random.Generator) -> np.ndarray:
    """Return values in which many samples are as before, whole instants among them."""
    values = np.round(np.cumsum(rng.normal(0, 1, (n, k)) * (rng.random((n, k)) < 0.3), axis=0), 6)
    still = rng.random(n) < 0.2
    for r in range(1, n):
        if still[r]:
            values[r] = values[r - 1]
    return values


@pytest.mark.parametrize("seed", range(12))
def test_every_value_is_as_the_facts_say(tmp_path: Path, seed: int) -> None:
    rng = np.random.default_rng(seed)
    n, k = int(rng.integers(40, 120)), int(rng.integers(1, 7))
    values = motion(n, k, rng)
    path = trace(tmp_path / "trace.xml", values, rng)
    with closing(tables(path)) as found:
        (table,) = found
        blocks = [np.column_stack(block.columns) for block in table.read(range(k + 1))]
    read = np.concatenate(blocks)
    np.testing.assert_allclose(read[:, 0], 0.002 * np.arange(n), atol=1e-9)
    for m in range(k):
        np.testing.assert_allclose(read[:, 1 + m], values[:, m], atol=1e-6)


def test_a_slower_signal_is_slower(tmp_path: Path) -> None:
    rng = np.random.default_rng(1)
    values = motion(80, 4, rng)
    with closing(tables(trace(tmp_path / "trace.xml", values, rng, slow=3))) as found:
        (table,) = found
        read = np.concatenate([np.column_stack(block.columns) for block in table.read(range(5))])
    np.testing.assert_allclose(np.diff(read[:, 0]), 0.004, atol=1e-9)
    np.testing.assert_allclose(read[:, 1:4], values[0::2][: len(read), :3], atol=1e-6)
    names = [column.name for column in table.columns]
    np.testing.assert_allclose(read[:, names.index("force")], values[0::2][: len(read), 3], atol=1e-6)


def test_a_slow_signal_at_odd_instants_is_read_at_these(tmp_path: Path) -> None:
    values = np.round(np.cumsum(np.random.default_rng(4).normal(0, 1, (81, 2)), axis=0), 6)
    path = trace(tmp_path / "trace.xml", np.vstack([values[:1], values]), np.random.default_rng(4), slow=1)
    text = path.read_text()
    for r in range(82):  # each value of the slow signal an instant later
        text = text.replace(f'time="{0.002 * r:.6f}"', f'time="{0.002 * (r - 1):.6f}"')
    path.write_text(re.sub(r'(<rec time="-0.002000".*?)/>', "", text))
    with closing(tables(path)) as found:
        (table,) = found
        read = np.concatenate([np.column_stack(block.columns) for block in table.read(range(3))])
    at = np.rint(read[:, 0] / 0.002).astype(int)
    assert set(at % 2) == {1}
    np.testing.assert_allclose(read[:, 1:], values[at], atol=1e-6)


def test_names_and_units_are_those_of_addresses_and_kind_of_axis(tmp_path: Path) -> None:
    rng = np.random.default_rng(2)
    t = 0.002 * np.arange(2000)
    v = np.convolve(50.0 * np.sign(np.sin(2 * np.pi * t)), np.hanning(60) / np.hanning(60).sum(), "same")
    z = np.cumsum(v) * 0.002
    current = 2.0 * np.tanh(v / 3.0) + 0.01 * np.gradient(v, t) + rng.normal(0, 0.02, len(t))
    own = np.column_stack([z, z, z, current, v, 60.0 * v])
    path = trace(tmp_path / "trace.xml", np.hstack([own, 2.0 * own]), rng, axes=2)
    assert b"<traceData" not in path.read_bytes()[:4096]
    assert recognises(path, path.read_bytes()[:4096]) > 0.5
    done = fric.ingest(path, output=tmp_path / "log.h5", axis="axis2")
    (log,) = read_logs(tmp_path / "log.h5")
    assert (log.axis, log.motion) == ("axis2", "linear/A")
    assert set(log.channels()) == {"time", "position", "load_position", "reference", "velocity", "force"}
    assert log.position is not None
    assert log.velocity is not None
    np.testing.assert_allclose(log.position, 2e-3 * z, atol=1e-8)
    np.testing.assert_allclose(log.velocity, 2e-3 * v, atol=1e-8)
    assert any("axis1" in one for one in done.warnings)
    assert [one.axis for one in find_sources([path]).logs] == ["axis1", "axis2"]


LONG = "<dataSignal id='f1' name='a' interval='1e-9'/><rec time='0' f1='1'/><rec time='9' f1='1'/>"
NO_TIME = "<dataSignal id='f1' name='a' interval='x'/><rec time='nan' f1='1'/>"


@pytest.mark.parametrize("body", ["", f"<traceData>{LONG}</traceData>", f"<traceData>{NO_TIME}</traceData>"])
def test_hostile_traces_end_in_a_sentence(tmp_path: Path, body: str) -> None:
    path = tmp_path / "trace.xml"
    path.write_text(f"<?xml version='1.0'?><traceSession>{body}</traceSession>")
    with pytest.raises(fric.FricError):
        fric.ingest(path, output=tmp_path / "log.h5")


def test_a_long_trace_takes_a_second(tmp_path: Path) -> None:
    rng = np.random.default_rng(3)
    path = trace(tmp_path / "trace.xml", motion(22_709, 6, rng), rng)
    begun = process_time()
    with closing(tables(path)) as found:
        (table,) = found
        samples = sum(len(block.columns[0]) for block in table.read(range(7)))
    assert samples == 22_709
    assert process_time() - begun < 10.0  # 0.4 s on one core
