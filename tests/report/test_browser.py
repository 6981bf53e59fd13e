"""The page in a browser: it draws without an error, its controls work, in light, in dark and on paper."""

from __future__ import annotations

import base64
import shutil
from collections.abc import Iterator
from io import BytesIO
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from matplotlib import image

import fric
from fric.io.report import write_report
from fric.io.run import read_runs
from fric.report.collect import collect
from fric.report.page import render_report
from fric.report.summary import Report

from .conftest import LOGS

webdriver = pytest.importorskip("selenium.webdriver", reason="selenium is not installed")
BROWSER = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
DRIVER = shutil.which("chromedriver")
pytestmark = pytest.mark.skipif(not (BROWSER and DRIVER), reason="there is no Chromium with its driver here")

SWITCHES = (
    "--headless --no-sandbox --disable-gpu --disable-quic --no-first-run --disable-background-networking "
    "--disable-component-update --disable-sync --window-size=1280,1400"
)
LINES = """
const plot = Bokeh.documents.map((d) => d.roots()[0]).find((one) => one.renderers?.some((r) => r.name === "now:a"));
const line = (name) => plot.renderers.find((r) => r.name === name);
"""


@pytest.fixture(scope="module")
def page(files: SimpleNamespace, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Any]:
    folder = tmp_path_factory.mktemp("browser")
    given = [files.march, files.september, files.observer, files.plant, files.run, files.later_run]
    write_report(folder / "report.html", render_report(collect([*given, LOGS / "presliding-sine.h5"])))
    options = webdriver.ChromeOptions()
    options.binary_location = BROWSER
    for switch in SWITCHES.split():
        options.add_argument(switch)
    options.add_argument(f"--user-data-dir={folder / 'profile'}")
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    driver = webdriver.Chrome(options=options, service=webdriver.ChromeService(DRIVER))
    try:
        driver.set_script_timeout(600)
        yield opened(driver, folder / "report.html")
    finally:
        driver.quit()


def opened(driver: Any, path: Path) -> Any:
    """Open a page, and wait until it has drawn."""
    driver.get(path.as_uri())
    driver.execute_async_script(
        "const done = arguments[0]; const wait = () => document.documentElement.dataset.ready ? done() : "
        "setTimeout(wait, 50); wait();"
    )
    return driver


@pytest.fixture(scope="module")
def judged(tmp_path_factory: pytest.TempPathFactory) -> tuple[dict[str, Report], Path]:
    """A report of a run and of a measured circle that is as predicted, and of one that is not, with a tolerance."""
    folder = tmp_path_factory.mktemp("judged")
    fric.circle("xy-table", "a,c,f").save(folder / "run.h5")
    fric.circle("xy-table", "a", revolutions=3).save(folder / "same.h5")
    fric.circle("virtual-rig", "a", revolutions=3).save(folder / "other.h5")
    made = {}
    for name in ("same", "other"):
        made[name] = fric.make_report(folder / "run.h5", circles=[folder / f"{name}.h5"], tolerance="8 um")
        made[name].save(folder / f"{name}.html")
    return made, folder


def test_it_draws_everything_and_the_console_is_silent(page: Any) -> None:
    drawn = page.execute_script("return [...document.querySelectorAll('div.drawn')].map((d) => d.children.length)")
    assert len(drawn) >= 7
    assert all(drawn)
    assert [entry for entry in page.get_log("browser") if entry["level"] in {"SEVERE", "WARNING"}] == []


def test_it_loads_nothing(page: Any) -> None:
    loaded = page.execute_script("return performance.getEntriesByType('resource').map((one) => one.name)")
    assert [name for name in loaded if not name.startswith("data:")] == []


def test_a_switch_takes_its_scheme_away_and_brings_it_back(page: Any) -> None:
    box = page.find_element("css selector", ".scheme[value=a]")
    visible = LINES + "return [line('now:a').visible, line('now:c').visible]"
    assert page.execute_script(visible) == [True, True]
    box.send_keys(" ")  # by keyboard
    assert page.execute_script(visible) == [False, True]
    box.click()
    assert page.execute_script(visible) == [True, True]
    page.find_element("css selector", "button.none").click()
    assert page.execute_script(visible) == [False, False]
    page.find_element("css selector", "button.all").click()
    assert page.execute_script(visible) == [True, True]


def test_the_earlier_run_is_shown_when_asked_for(page: Any) -> None:
    visible = LINES + "return line('earlier:a').visible"
    assert page.execute_script(visible) is False
    page.find_element("css selector", ".earlier").click()
    assert page.execute_script(visible) is True
    page.find_element("css selector", ".earlier").click()


def test_the_drawn_line_is_the_run_magnified(page: Any, files: SimpleNamespace) -> None:
    """What is drawn, taken back through the magnification, has the radial errors of the run file."""
    field = page.find_element("css selector", "input.magnification")
    run = next(run for run in read_runs(files.later_run) if run.scheme.name == "a")
    error = run.circularity.error
    for factor in (100, 1000):
        field.clear()
        field.send_keys(str(factor))
        x, y = np.array(
            page.execute_script(LINES + "const d = line('now:a').data_source.data; return [[...d.x], [...d.y]]")
        )
        drawn = (np.hypot(x, y) - 30.0) / factor * 1e-3
        assert drawn.max() == pytest.approx(error.max(), abs=2e-8)
        assert drawn.min() == pytest.approx(error.min(), abs=2e-8)
        assert page.execute_script("return document.querySelector('.contour').dataset.magnification") == str(factor)
    slider = page.find_element("css selector", "input.slider")
    before = float(slider.get_attribute("value"))
    slider.send_keys("\ue014" * 10)  # arrow right, by keyboard
    assert float(slider.get_attribute("value")) == pytest.approx(before + 0.1, abs=0.02)
    assert float(field.get_attribute("value")) == pytest.approx(10 ** (before + 0.1), rel=0.06)


def test_a_zoom_goes_to_its_reversal_and_keeps_circles_round(page: Any) -> None:
    seen = LINES + (
        "const [x, y] = [plot.x_range, plot.y_range];"
        "return [(x.start + x.end) / 2, (y.start + y.end) / 2, (x.end - x.start) / plot.inner_width,"
        " (y.end - y.start) / plot.inner_height]"
    )
    page.find_element("css selector", ".zoom[data-quadrant='1']").click()
    x, y, mm_a_pixel_x, mm_a_pixel_y = page.execute_script(seen)
    assert (x, y) == (pytest.approx(0, abs=1e-6), pytest.approx(33))
    assert mm_a_pixel_x == pytest.approx(mm_a_pixel_y, rel=0.03)  # other tick labels take other room
    page.find_element("css selector", ".zoom[data-quadrant=all]").click()
    assert page.execute_script(seen)[:2] == [pytest.approx(0), pytest.approx(0)]


def luminance(page: Any) -> float:
    """Return the mean lightness of what is seen, 0 to 1."""
    return float(image.imread(BytesIO(page.get_screenshot_as_png()))[..., :3].mean())


def test_light_dark_and_paper(page: Any) -> None:
    def media(scheme: str, kind: str = "") -> float:
        features = [{"name": "prefers-color-scheme", "value": scheme}]
        page.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": kind, "features": features})
        page.execute_script("document.querySelector('.contour').scrollIntoView()")
        return luminance(page)

    assert media("light") > 0.85
    assert media("dark") < 0.2
    assert media("dark", "print") > 0.85
    assert media("light") > 0.85
    page.find_element("id", "theme").click()
    assert luminance(page) < 0.2
    page.find_element("id", "theme").click()
    pdf = base64.b64decode(page.execute_cdp_cmd("Page.printToPDF", {"printBackground": True})["data"])
    assert pdf.startswith(b"%PDF")
    assert page.execute_script("return [...document.querySelectorAll('details')].every((one) => one.open)")


def test_the_keyboard_reaches_every_control(page: Any) -> None:
    order = page.execute_script(
        "const all = [...document.querySelectorAll('a[href], button, input, summary')];"
        "return all.filter((one) => one.tabIndex < 0).length"
    )
    assert order == 0
    unnamed = page.execute_script(
        "return [...document.querySelectorAll('button, input')].filter((one) => !(one.getAttribute('aria-label') || "
        "one.textContent.trim() || one.closest('label')?.textContent.trim())).length"
    )
    assert unnamed == 0


CUT_OFF = """
const shown = [...document.querySelectorAll("main th, main td, main p, main li, main img, main canvas")];
const right = (one) => one.getBoundingClientRect().right;
return [document.documentElement.scrollWidth,
        shown.filter((one) => one.offsetParent && right(one) > innerWidth + 1).map((one) => one.textContent)];
"""


@pytest.mark.parametrize("width", [390, 1280])
def test_nothing_is_cut_off_at_the_right(page: Any, width: int) -> None:
    page.execute_cdp_cmd(
        "Emulation.setDeviceMetricsOverride", {"width": width, "height": 800, "deviceScaleFactor": 1, "mobile": False}
    )
    wide, beyond = page.execute_script(CUT_OFF)
    page.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})
    assert wide <= width
    assert beyond == []


def test_a_switch_reaches_the_curves_over_time_too(page: Any) -> None:
    visible = (
        "const at = Bokeh.documents.map((d) => d.roots()[0]).filter((one) => one.renderers?.some((r) => "
        "r.name === 'now:a') && !one.renderers.some((r) => r.data_source?.name === 'grid'));"
        "return at.map((one) => one.renderers.find((r) => r.name === 'now:a').visible)"
    )
    assert page.execute_script(visible) == [True, True]
    page.find_element("css selector", ".scheme[value=a]").click()
    assert page.execute_script(visible) == [False, False]
    page.find_element("css selector", ".scheme[value=a]").click()


def test_symbols_have_their_plain_names_beside_them(page: Any) -> None:
    rows = page.execute_script(
        "return [...document.querySelectorAll('.numbers th .named')].map((one) => one.innerText)"
    )
    told = {row.split()[0]: " ".join(row.split()[1:]) for row in rows}
    assert told["F_s"] == "static friction"
    assert told["T_d"] == "delay of the drive"
    assert (told["k_1"], told["k_2"]) == ("stiffness of the block", "")


def test_the_decision_is_first_and_prints_on_one_sheet(page: Any, judged: tuple[dict[str, Report], Path]) -> None:
    """What is read first is what --json says; its section fits an A4 sheet and ends it."""
    made, folder = judged
    opened(page, folder / "same.html")
    first = page.find_element("css selector", "main section")
    told = made["same"].document["advice"][0]
    assert told["passes"] is True
    assert told["trusted"] is True
    assert told["headline"] in first.text
    assert "PASS" in first.text
    assert "glitch within 8 µm" in first.text
    assert "run.h5, same.h5" in first.text
    assert f"--scheme {told['scheme']}" in first.text
    page.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": "print"})
    page.execute_cdp_cmd(
        "Emulation.setDeviceMetricsOverride", {"width": 688, "height": 1000, "deviceScaleFactor": 1, "mobile": False}
    )
    end = page.execute_script("return document.getElementById('advice').getBoundingClientRect().bottom + scrollY")
    breaks = page.execute_script("return getComputedStyle(document.getElementById('advice')).breakAfter")
    page.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": ""})
    page.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})
    assert end < 297 / 25.4 * 96 - 2 * 16 / 25.4 * 96
    assert breaks == "page"


def test_against_a_measured_circle_nothing_is_recommended(page: Any, judged: tuple[dict[str, Report], Path]) -> None:
    reports, folder = judged
    made = reports["other"]
    opened(page, folder / "other.html")
    first = page.find_element("css selector", "main section").text
    assert "No scheme is recommended" in first
    assert "NOT DECIDED" in first
    assert "fric tune xy-table other.h5" in first
    assert made.document["advice"][0]["scheme"] is None
    assert page.find_elements("css selector", "tr.best") == []
    table = page.find_element("css selector", "#measured table").text
    shown = made.inputs.circles[0].result.found.glitches["+x"]
    assert f"{shown.value * 1e6:.1f}" in table
    assert "no: level" in table
    picture = page.find_element("css selector", "#measured img")
    assert page.execute_script("return arguments[0].naturalWidth", picture) > 300
