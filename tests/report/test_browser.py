"""The page in a browser: it draws without an error, its controls work, in light, in dark and on paper."""

from __future__ import annotations

import base64
import re
import shutil
from collections.abc import Callable, Iterator
from functools import cache
from io import BytesIO
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from matplotlib import image

import fric
from fric.io.circle import read_runs
from fric.output import written
from fric.report.collect import collect
from fric.report.summary import LEAST_MACHINES, Report
from fric.report.view import render_report

from .conftest import LOGS

webdriver = pytest.importorskip("selenium.webdriver", reason="selenium is not installed")
BROWSER = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
DRIVER = shutil.which("chromedriver")
pytestmark = pytest.mark.skipif(not (BROWSER and DRIVER), reason="there is no Chromium with its driver here")

SWITCHES = (
    "--headless --no-sandbox --disable-gpu --disable-quic --no-first-run --disable-background-networking "
    "--disable-component-update --disable-sync --window-size=1280,1400"
)
VISIBLE = "return arguments[0].map((name) => [...document.querySelectorAll(`.contour [data-name='${name}']`)]"
VISIBLE += ".map((one) => getComputedStyle(one).display !== 'none'))"
"""Whether each curve of a name is seen, by name: in the circle and after the reversals of two axes."""
BOX = "const v = document.querySelector('.contour figure[id^=contour] svg').viewBox.baseVal;"
BOX += "return [v.x, v.y, v.width, v.height]"


def started(folder: Path, *switches: str) -> Any:
    """Return a browser with a profile of its own in a folder; the page's console is logged."""
    options = webdriver.ChromeOptions()
    options.binary_location = BROWSER
    for switch in [*SWITCHES.split(), f"--user-data-dir={folder / 'profile'}", *switches]:
        options.add_argument(switch)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    return webdriver.Chrome(options=options, service=webdriver.ChromeService(DRIVER))


@pytest.fixture(scope="module")
def browser(files: SimpleNamespace, tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[Any, Path]]:
    """A browser, and a page for it."""
    folder = tmp_path_factory.mktemp("browser")
    given = [files.march, files.september, files.observer, files.plant, files.run, files.later_run]
    written(folder / "report.html", render_report(collect([*given, LOGS / "presliding-sine.h5"])))
    driver = started(folder)
    try:
        driver.set_script_timeout(600)
        yield driver, folder / "report.html"
    finally:
        driver.quit()


@pytest.fixture
def page(browser: tuple[Any, Path]) -> Any:
    """The page as it opens, whatever a test before did to it."""
    return opened(*browser)


def opened(driver: Any, path: Path) -> Any:
    """Open a page, and wait until it has drawn."""
    driver.get(path.as_uri())
    driver.execute_async_script(
        "const done = arguments[0]; const wait = () => document.documentElement.dataset.ready ? done() : "
        "setTimeout(wait, 50); wait();"
    )
    return driver


@pytest.fixture(scope="module")
def judged(tmp_path_factory: pytest.TempPathFactory) -> tuple[Callable[[str], Report], Path]:
    """A report of a run and of a circle that a machine measured, with a tolerance, and the folder of the pages."""
    folder = tmp_path_factory.mktemp("judged")
    fric.circle("xy-table", "a,f").save(folder / "run.h5")

    @cache
    def of(machine: str) -> Report:
        fric.circle(machine, "a", revolutions=3).save(folder / f"{machine}.h5")
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr("fric.report.summary.MOST_MACHINES", LEAST_MACHINES)  # as around a slow circle
            made = fric.make_report(folder / "run.h5", circles=[folder / f"{machine}.h5"], tolerance="8 um")
            made.save(folder / f"{machine}.html")
        return made

    return of, folder


def test_it_draws_everything_and_the_console_is_silent(page: Any) -> None:
    drawn = page.execute_script(
        "return [...document.querySelectorAll('svg.plot')].map((one) => [one.getBoundingClientRect().height,"
        " one.querySelectorAll('path').length, one.querySelectorAll('text').length])"
    )
    assert len(drawn) >= 7
    assert all(height > 100 and paths > 5 and texts > 3 for height, paths, texts in drawn)
    assert [entry for entry in page.get_log("browser") if entry["level"] in {"SEVERE", "WARNING"}] == []


def test_it_loads_nothing(page: Any) -> None:
    loaded = page.execute_script("return performance.getEntriesByType('resource').map((one) => one.name)")
    assert [name for name in loaded if not name.startswith("data:")] == []


def test_a_switch_takes_its_scheme_away_and_brings_it_back(page: Any) -> None:
    def visible() -> list[list[bool]]:
        return page.execute_script(VISIBLE, ["now:a", "now:c"])

    box = page.find_element("css selector", ".scheme[value=a]")
    assert visible() == [[True] * 3, [True] * 3]
    box.send_keys(" ")  # by keyboard
    assert visible() == [[False] * 3, [True] * 3]
    box.click()
    assert visible() == [[True] * 3, [True] * 3]
    page.find_element("css selector", "button.none").click()
    assert visible() == [[False] * 3, [False] * 3]
    page.find_element("css selector", "button.all").click()
    assert visible() == [[True] * 3, [True] * 3]


def test_the_earlier_run_is_shown_when_asked_for(page: Any) -> None:
    assert page.execute_script(VISIBLE, ["earlier:a"]) == [[False]]
    page.find_element("css selector", ".earlier").click()
    assert page.execute_script(VISIBLE, ["earlier:a"]) == [[True]]
    page.find_element("css selector", ".earlier").click()


def test_the_drawn_line_is_the_run_magnified(page: Any, files: SimpleNamespace) -> None:
    """What is drawn, taken back through the magnification, has the radial errors of the run file."""
    field = page.find_element("css selector", "input.magnification")
    run = next(run for run in read_runs(files.later_run) if run.scheme.name == "a")
    error = run.circularity.error
    for factor in (100, 1000):
        field.clear()
        field.send_keys(str(factor))
        path, panels = page.execute_script(
            "const svg = document.querySelector('.contour figure[id^=contour] svg');"
            "return [svg.querySelector('[data-name=\"now:a\"] path').getAttribute('d'), JSON.parse(svg.dataset.panels)]"
        )
        x, y = (np.array(re.findall(r"-?[\d.]+", path), float).reshape(-1, 2) - panels[0]["centre"]).T
        (low, high), rim = panels[0]["r"], panels[0]["rim"]
        nominal = rim * -low / (high - low)  # the circle of 30 mm
        drawn = (np.hypot(x, y) / nominal - 1) * 30e-3 / factor
        assert drawn.max() == pytest.approx(error.max(), abs=2e-8)
        assert drawn.min() == pytest.approx(error.min(), abs=2e-8)
        assert page.execute_script("return document.querySelector('.contour').dataset.magnification") == str(factor)
    slider = page.find_element("css selector", "input.slider")
    before = float(slider.get_attribute("value"))
    slider.send_keys("\ue014" * 10)  # arrow right, by keyboard
    assert float(slider.get_attribute("value")) == pytest.approx(before + 0.1, abs=0.02)
    assert float(field.get_attribute("value")) == pytest.approx(10 ** (before + 0.1), rel=0.06)


def test_a_zoom_goes_to_its_reversal_and_keeps_circles_round(page: Any) -> None:
    whole = page.execute_script(BOX)
    centre = page.execute_script(
        "return JSON.parse(document.querySelector('.contour figure[id^=contour] svg').dataset.panels)[0].centre"
    )
    page.find_element("css selector", ".zoom[data-quadrant='1']").click()  # +y, which is up
    x, y, width, height = page.execute_script(BOX)
    assert x + width / 2 == pytest.approx(centre[0], abs=0.1)
    assert y + height / 2 < centre[1] - 50
    assert width < 0.5 * whole[2]
    assert width / height == pytest.approx(whole[2] / whole[3])
    page.find_element("css selector", ".zoom[data-quadrant=all]").click()
    assert page.execute_script(BOX) == whole


def test_a_figure_is_zoomed_moved_and_reset_by_mouse_and_by_keyboard(page: Any) -> None:
    svg = page.find_element("css selector", ".contour figure[id^=contour] svg")
    page.execute_script("arguments[0].scrollIntoView({block: 'center'}); arguments[0].blur()", svg)
    whole = page.execute_script(BOX)
    wheel = (
        "const at = arguments[0].getBoundingClientRect(); return arguments[0].dispatchEvent(new WheelEvent('wheel', "
        "{deltaY: -400, clientX: at.left + at.width / 4, clientY: at.top + at.height / 2, cancelable: true}))"
    )
    assert page.execute_script(wheel, svg) is True  # a page that is scrolled goes on scrolling
    assert page.execute_script(BOX) == whole
    webdriver.ActionChains(page).move_to_element(svg).click().perform()
    assert page.execute_script(wheel, svg) is False
    x, _, width, _ = page.execute_script(BOX)
    assert width == pytest.approx(whole[2] / 2)
    assert x + width / 4 == pytest.approx(whole[2] / 4, abs=0.5)  # what is under the pointer stays there
    webdriver.ActionChains(page).drag_and_drop_by_offset(svg, -60, 0).perform()
    moved = page.execute_script(BOX)
    scale = width / page.execute_script("return arguments[0].getBoundingClientRect().width", svg)
    assert moved[0] == pytest.approx(x + 60 * scale, abs=1.0)
    webdriver.ActionChains(page).double_click(svg).perform()
    assert page.execute_script(BOX) == whole
    for keys, share in (("++", 1.25**-2), ("-", 1.25**-1), ("0", 1.0)):
        svg.send_keys(keys)
        assert page.execute_script(BOX)[2] == pytest.approx(whole[2] * share)
    svg.send_keys("++\ue014")  # arrow right
    assert page.execute_script(BOX)[0] > 1.2 * (whole[2] - page.execute_script(BOX)[2]) / 2
    svg.send_keys("\ue00c")  # escape
    assert page.execute_script(BOX) == whole


def test_the_numbers_under_the_pointer_are_those_of_the_axes(page: Any) -> None:
    """In a panel with a logarithmic axis, and in a circle that is magnified: its rings are at their errors."""
    read = (
        "const [svg, x, y] = arguments, at = new DOMPoint(x, y).matrixTransform(svg.getScreenCTM());"
        "svg.dispatchEvent(new PointerEvent('pointermove', {clientX: at.x, clientY: at.y}));"
        "return svg.parentElement.querySelector('.read').textContent"
    )
    svg = page.find_element("css selector", "#map-log-x svg")
    ticks = page.execute_script(
        "return [...arguments[0].querySelectorAll('text')].map((one) => [one.textContent, one.getBBox().x + "
        "one.getBBox().width / 2])", svg,
    )  # fmt: skip
    panel = page.execute_script("return JSON.parse(arguments[0].dataset.panels)[0]", svg)
    (at,) = [x for text, x in ticks if text == "0.1"]
    text = page.execute_script(read, svg, at, (panel["frame"][1] + panel["frame"][3]) / 2)
    speed, size = re.fullmatch(r"speed ([\d.]+) mm/s, friction in the direction of motion ([\d.]+) N", text).groups()
    assert float(speed) == pytest.approx(0.1, rel=0.03)
    assert float(size) == pytest.approx((panel["y"][0] + panel["y"][1]) / 2, rel=1e-3)
    svg = page.find_element("css selector", ".contour figure[id^=contour] svg")
    field = page.find_element("css selector", "input.magnification")
    for factor in (200, 500):
        field.clear()
        field.send_keys(str(factor))
        rings = page.execute_script(
            "return [...arguments[0].querySelectorAll('[data-name^=\"ring:\"]')]"
            ".filter((one) => !('off' in one.dataset))"
            ".map((one) => one.querySelector('text')?.textContent ?? one.getBBox().width / 2)",
            svg,
        )
        sizes, names = rings[: len(rings) // 2], rings[len(rings) // 2 :]
        centre = page.execute_script("return JSON.parse(arguments[0].dataset.panels)[0].centre", svg)
        for ring, name in zip(sizes, names, strict=True):
            told = page.execute_script(read, svg, centre[0] + ring, centre[1])
            found = re.fullmatch(r"([\d.]+)°, error ([−\d.]+) µm", told).group(2)
            assert float(found.replace("−", "-")) == pytest.approx(float(name[:-3].replace("−", "-")), rel=0.03)


def test_a_click_on_an_entry_of_a_legend_hides_its_curve(page: Any) -> None:
    script = (
        "const svg = document.querySelector('#virgin-x svg');"
        "const entry = [...svg.querySelectorAll('[data-name^=\"legend:\"]')].find((one) => "
        "one.textContent.includes('measured'));"
        "const curves = [...svg.querySelectorAll(`[data-name='${entry.dataset.name.replace('legend', 'curve')}']`)];"
        "entry.dispatchEvent(new MouseEvent('click'));"
        "return curves.map((one) => getComputedStyle(one).display)"
    )
    hidden, shown = page.execute_script(script), page.execute_script(script)
    assert set(hidden) == {"none"}
    assert set(shown) == {"inline"}
    assert len(shown) == 1


def luminance(page: Any) -> float:
    """Return the mean lightness of what is seen, 0 to 1."""
    return float(image.imread(BytesIO(page.get_screenshot_as_png()))[..., :3].mean())


@pytest.mark.long(3)
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


def test_symbols_have_their_plain_names_beside_them(page: Any) -> None:
    rows = page.execute_script(
        "return [...document.querySelectorAll('.numbers th .named')].map((one) => one.innerText)"
    )
    told = {row.split()[0]: " ".join(row.split()[1:]) for row in rows}
    assert told["F_s"] == "static friction"
    assert told["T_d"] == "delay of the drive"
    assert (told["k_1"], told["k_2"]) == ("stiffness of the block", "")


@pytest.mark.long(3)
def test_the_decision_is_first_and_prints_on_one_sheet(
    browser: tuple[Any, Path], judged: tuple[Callable[[str], Report], Path]
) -> None:
    """What is read first is what --json says; its section fits an A4 sheet and ends it."""
    of, folder = judged
    made = of("xy-table")
    page = opened(browser[0], folder / "xy-table.html")
    first = page.find_element("css selector", "main section")
    told = made.document["advice"][0]
    assert told["passes"] is True
    assert told["trusted"] is True
    assert told["headline"] in first.text
    assert "PASS" in first.text
    assert "glitch within 8 µm" in first.text
    assert "run.h5, xy-table.h5" in first.text
    assert f"--scheme {told['scheme']}" in first.text
    sizes = [one.text.split("\n") for one in first.find_elements("css selector", ".sizes div")]
    assert [name for name, _ in sizes] == ["now", "with (f) GMS + observer", "at most"]
    assert all(size in told["headline"] for _, size in sizes)
    text, picture = (first.find_element("css selector", f".decision > {one}").rect for one in ("div", "figure"))
    assert picture["x"] >= text["x"] + text["width"]  # beside it, and within the first screen
    assert picture["y"] + picture["height"] < 1000
    assert "friction of x" in first.text
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


@pytest.mark.long(4)
def test_against_a_measured_circle_nothing_is_recommended(
    browser: tuple[Any, Path], judged: tuple[Callable[[str], Report], Path]
) -> None:
    of, folder = judged
    made = of("virtual-rig")
    page = opened(browser[0], folder / "virtual-rig.html")
    first = page.find_element("css selector", "main section").text
    assert "No scheme is recommended" in first
    assert "NOT DECIDED" in first
    assert re.search(r"fric tune xy-table \S*virtual-rig.h5", first)
    assert made.document["advice"][0]["scheme"] is None
    assert page.find_elements("css selector", "tr.best") == []
    table = page.find_element("css selector", "#measured table").text
    shown = made.inputs.circles[0].result.found.glitches["+x"]
    assert f"{shown.value * 1e6:.1f}" in table
    assert "no: level" in table
    assert page.find_element("css selector", "#measured svg.plot").size["width"] > 300
