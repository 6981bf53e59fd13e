"""The HAL component in LinuxCNC's own thread, fed row by row: parity, limit, enable, fault."""

from __future__ import annotations

import os
import shutil
import subprocess
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from fric.export.base import ExportedPart
from fric.export.linuxcnc import linuxcnc_files
from tests.export.parts import EXPORTED, InC, exportable, part, scheme_part, typical
from tests.linuxcnc.bench import apart

pytestmark = pytest.mark.skipif(
    not (shutil.which("halrun") and shutil.which("halcompile") and shutil.which("cc") and os.geteuid() == 0),
    reason="LinuxCNC is not installed, or this is not root",
)
ROWS = 8000
NOBODY = 65534
COLUMNS = ["position-cmd", "velocity-cmd", "acceleration-cmd", "position-fb", "control-in", "output-prev"]
COLUMNS += ["enable", "gain", "reset"]
SAMPLED = ["output", "friction-ff", "observer-estimate", "at-limit", "faulted"]
SCRIPT = """
loadrt threads name1=servo period1=250000
loadrt streamer depth={depth} cfg=ffffffbfb
loadrt sampler depth={depth} cfg={cfg}
{loads}
addf streamer.0 servo
{adds}
addf sampler.0 servo
{nets}
loadusr -w halstreamer rows.txt
start
loadusr -w halsampler -n {rows} trace.txt
"""
"""The session ends when the sampler has all rows, however late the thread is: its buffer holds them all."""


def _run(rows: np.ndarray, folder: Path, parts: dict[str, ExportedPart], sampled: list[tuple[str, str]]) -> np.ndarray:
    """Feed rows to the components of parts by axis, one a period, and return sampled pins, one row a period."""
    for axis, one in parts.items():
        for name, text in linuxcnc_files(replace(one, axis=axis)).items():
            (folder / name).write_text(str(text))
        words = ["halcompile", "--compile", f"fric_{axis}_ff.comp"]
        subprocess.run(words, cwd=folder, check=True, capture_output=True)
    nets = [
        f"net in{n} streamer.0.pin.{n} => {' '.join(f'{axis}.{name}' for axis in parts)}"
        for n, name in enumerate(COLUMNS)
    ]
    nets += [f"net out{n} {axis}.{name} => sampler.0.pin.{n}" for n, (axis, name) in enumerate(sampled)]
    # 17 digits: what is read is what was computed here
    lines = [" ".join(f"{int(v)}" if n in (6, 8) else f"{v:.17g}" for n, v in enumerate(row)) for row in rows]
    (folder / "rows.txt").write_text("\n".join(lines) + "\n")
    script = SCRIPT.format(
        depth=len(rows) + 10, nets="\n".join(nets), rows=len(rows),
        cfg="".join("b" if name in ("at-limit", "faulted") else "f" for _, name in sampled),
        loads="\n".join(f"loadrt fric_{axis}_ff names={axis}" for axis in parts),
        adds="\n".join(f"addf {axis} servo" for axis in parts),
    )  # fmt: skip
    (folder / "run.hal").write_text(script)
    for one in [folder, *folder.iterdir()]:
        os.chown(one, NOBODY, NOBODY)
    words = apart(folder, folder, "env", "HOME=/mnt", "halrun", "-f", "run.hal")
    done = subprocess.run(words, capture_output=True, text=True, timeout=600)
    trace = folder / "trace.txt"
    assert trace.exists(), done.stderr[-400:]
    return np.loadtxt(trace)


def _rows() -> np.ndarray:
    """A circle in mm with what a drive would do, a stretch in which the voltage is cut, one in which enable falls."""
    t = np.arange(ROWS) / 4000
    r, v, a = 30 * np.sin(3.3 * t), 99 * np.cos(3.3 * t), -326.7 * np.sin(3.3 * t)
    rows = np.column_stack([r, v, a, r + 1e-3 * np.sin(40 * t), 0.2 * np.sin(7 * t), np.zeros(ROWS)])
    rows[3000:3200, 4] = 9.9  # with the inverse model this is beyond 10 V
    enable = np.ones(ROWS)
    enable[4000:4400] = 0
    rows[:, 5] = np.append(0.0, np.clip(rows[:-1, 4], -10, 10))
    rows[6000, 0] = 1e12  # absurd
    reset = np.zeros(ROWS)
    reset[6500] = 1
    return np.column_stack([rows, enable, np.ones(ROWS), reset])


def _in_c(one: ExportedPart, rows: np.ndarray, folder: Path) -> np.ndarray:
    """What the component should give, by the exported C."""
    made = InC(one, folder)
    made.reset()
    wanted = np.empty(len(rows))
    for n, (r, v, a, fb, control, before, enable, _, reset) in enumerate(rows):
        if reset:
            made.reset()
            wanted[n] = 0.0
            continue
        added = made.step(
            position=1e-3 * r, velocity=1e-3 * v, acceleration=1e-3 * a, measured=1e-3 * fb, control=control,
            input=before, share=enable,
        )  # fmt: skip
        wanted[n] = np.clip(control + (added if enable else 0.0), -10, 10)
    return wanted


@pytest.mark.long
def test_the_components_of_every_model_and_block_give_what_the_exported_c_gives(tmp_path: Path) -> None:
    parts = {f"m{n}": part(typical(name)) for n, name in enumerate(exportable())}
    parts |= {f"s{n}": scheme_part(scheme) for n, scheme in enumerate(EXPORTED)}
    folder = tmp_path / "hal"
    folder.mkdir()
    rows = _rows()
    trace = _run(rows, folder, parts, [(axis, "output") for axis in parts])
    for n, (axis, one) in enumerate(parts.items()):
        own = tmp_path / axis
        own.mkdir()
        assert np.abs(trace[:, n] - _in_c(one, rows, own)).max() < 1e-6, axis


def test_the_component_gives_what_the_exported_c_gives_and_obeys_its_pins(tmp_path: Path) -> None:
    folder = tmp_path / "hal"
    folder.mkdir()
    rows = _rows()
    trace = _run(rows, folder, {"x": scheme_part("f")}, [("x", name) for name in SAMPLED])
    assert len(trace) == ROWS
    own = tmp_path / "c"
    own.mkdir()
    wanted = _in_c(scheme_part("f"), rows, own)
    assert np.abs(trace[:, 0] - wanted).max() < 1e-6  # the recorder prints six decimals
    assert trace[3010:3200, 3].all()
    assert np.abs(trace[3010:3200, 0]).min() == 10.0
    assert not trace[3300:4000, 3].any()
    np.testing.assert_allclose(trace[4000:4400, 0], rows[4000:4400, 4], atol=1e-6)
    assert trace[6000:6500, 4].all()
    np.testing.assert_allclose(trace[6000:6500, 0], rows[6000:6500, 4], atol=1e-6)
    assert not trace[6500:, 4].any()
    assert np.abs(trace[6600:, 1]).max() > 0.1  # it works again
