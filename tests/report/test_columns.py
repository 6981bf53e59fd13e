"""Columns stated by hand: what the page answers, and the page in a browser."""

from __future__ import annotations

import re
import subprocess
from contextlib import ExitStack
from pathlib import Path
from threading import Thread
from typing import Any

import numpy as np
import pytest

import fric
from fric.documents.mapping import MappingDocument
from fric.documents.yaml import read_document
from fric.errors import FricError
from fric.io.hdf5 import read_logs
from fric.io.propose import guessed
from fric.io.questions import Review
from fric.report.served import ColumnsPage

from .test_browser import BROWSER, DRIVER, started
from .test_knots import asked


@pytest.fixture
def log(tmp_path: Path) -> Path:
    """A log without time and units: two encoders' counts, and a current."""
    t = np.arange(4000) * 1e-3
    speed = np.convolve(np.sign(np.sin(2 * np.pi * t / 1.3)), np.hanning(200) / np.hanning(200).sum(), "same")
    rows = np.column_stack(
        [1e4 * np.cumsum(speed) * 1e-3, 1e4 * speed, np.sign(speed) + 0.2 * speed + 0.1 * np.sin(t * 911)]
    )
    path = tmp_path / "run.csv"
    np.savetxt(path, np.round(rows, 3), delimiter=";", header="enc;rate;i", comments="", fmt="%.6g")
    return path


def stated(**changes: Any) -> dict[str, Any]:
    units = {"position": "0.1 um", "velocity": "0.1 um/s", "force": "A"}
    roles = [{"channel": channel, "column": n, "unit": unit} for n, (channel, unit) in enumerate(units.items())]
    return {"axes": [{"taken": True, "name": "x", "motion": "linear", "rate": "1 kHz", "roles": roles} | changes]}


def test_what_is_stated_becomes_the_mapping_and_what_follows_is_shown(log: Path, tmp_path: Path) -> None:
    def state(guess: Any) -> Any:
        page = ColumnsPage(guess)
        found = page.answer("try", stated())
        assert found["axes"][0]["lines"][0] == "4 s at 1 kHz"
        assert any("force from" in line and line.endswith(" A") for line in found["axes"][0]["lines"])
        for wrong, why in (
            ({"rate": ""}, "no column is marked as time"), ({"rate": "fast"}, "is not a sampling rate"),
            ({"roles": []}, "neither position"),
            ({"taken": False}, "no axis"), ({"roles": [{"channel": "time", "column": 9, "unit": "s"}]}, "channel"),
            ({"name": "\n" * 3}, "no name"), ({"roles": [{"channel": "position", "column": 0, "unit": ""}]}, "no unit"),
        ):  # fmt: skip
            with pytest.raises(FricError, match=why):
                page.answer("try", stated(**wrong))
        serving = Thread(target=page.serve, daemon=True)
        serving.start()
        status, text = asked(page, "GET", f"/{page.token}/")
        assert status == 200
        assert b"polyline" in text
        assert b"://" not in text.replace(b"http://www.w3.org/2000/svg", b"")
        assert asked(page, "POST", f"/{page.token}/save", stated())[0] == 200
        serving.join(60)
        return page.serve()

    done = fric.ingest(log, output=tmp_path / "log.h5", ask=Review(state))
    mapping = read_document(log.parent / "fric-mapping.yaml", MappingDocument)
    assert mapping.columns["position"].scale == "0.1 um"
    (record,) = read_logs(tmp_path / "log.h5")
    assert (record.motion, done.done.samples) == ("linear/A", 4000)
    np.testing.assert_allclose([np.ptp(record.time), np.abs(record.velocity).max()], [3.999, 1e-3], rtol=1e-3)
    assert fric.ingest(log, output=tmp_path / "again.h5").done.samples == 4000  # by the mapping beside it


def test_every_file_is_shown_that_is_asked_for(tmp_path: Path) -> None:
    """A header that says all is shown as well; a table of several axes by the axis."""
    t = np.arange(1000) * 1e-3
    (tmp_path / "log.csv").write_text(
        "time [s],position [mm],force [N]\n" + "".join(f"{a:.3f},{a:.3f},{1.0 + a:.3f}\n" for a in t)
    )
    with ExitStack() as files:
        assert not guessed([tmp_path / "log.csv"], files).found
        page = ColumnsPage(guessed([tmp_path / "log.csv"], files, every=True))
        page._server.server_close()
    assert b'"unit":"mm"' in page.content.replace(b"\\u0022", b'"')


@pytest.mark.long(20)
@pytest.mark.skipif(not (BROWSER and DRIVER), reason="there is no Chromium with its driver here")
def test_a_column_is_stated_and_saved_in_a_browser(log: Path, tmp_path: Path, warm: dict[str, str]) -> None:
    words = ["fric", "ingest", str(log), "--interactive", "-o", str(tmp_path / "log.h5")]
    command = subprocess.Popen(words, env=warm, stderr=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
    driver = None
    try:
        assert command.stderr is not None
        (address,) = re.findall(r"http://127\.0\.0\.1:\d+/\S+", command.stderr.readline())
        driver = started(tmp_path, "--window-size=1300,900")
        driver.get(address)
        for label, text in (("enc: unit", "0.1 um"), ("rate: unit", "0.1 um/s"), ("i: unit", "A")):
            (field,) = driver.find_elements("css selector", f"[aria-label$='{label}']")
            field.clear()
            field.send_keys(text)
        (motion,) = driver.find_elements("css selector", ".head select")
        motion.send_keys("linear")
        field = driver.find_elements("css selector", ".head input[type=text]")[1]
        field.clear()
        field.send_keys("1 kHz")
        for _ in range(200):
            if "at 1 kHz" in driver.find_element("css selector", "#preview").text:
                break
            driver.execute_async_script("setTimeout(arguments[0], 100)")
        driver.save_screenshot(str(tmp_path / "page.png"))
        driver.find_element("css selector", "#save").click()
        assert [entry for entry in driver.get_log("browser") if entry["level"] in {"SEVERE", "WARNING"}] == []
        _, told = command.communicate(timeout=600)
        assert command.returncode == 0, told
    finally:
        command.kill()
        if driver is not None:
            driver.quit()
    (record,) = read_logs(tmp_path / "log.h5")
    assert np.ptp(record.time) == pytest.approx(3.999)
    assert (log.parent / "fric-mapping.yaml").exists()
