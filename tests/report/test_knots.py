"""Knots moved by hand: the page in a browser, and what a stranger may ask of it."""

from __future__ import annotations

import http.client
import json
import re
import subprocess
from threading import Thread
from typing import Any

import pytest

import fric
from fric.documents.yaml import plain, read_tree
from fric.report.served import HOST, MOST_REQUEST, KnotPage

from .conftest import LOGS
from .test_browser import BROWSER, DRIVER, started

LOG = LOGS / "presliding-sine.h5"
KNOTS = [0.9e-6, 26e-6, 80e-6]


@pytest.fixture(scope="module")
def records() -> Any:
    return fric.read(LOG)


@pytest.fixture
def page(records: Any) -> KnotPage:
    def fit(knots: Any) -> Any:
        return fric.identify_gms(records, knots=list(knots), refine=False)

    return KnotPage(fit(KNOTS), fit)


def asked(page: KnotPage, method: str, path: str, body: Any = None, **headers: str) -> tuple[int, Any]:
    connection = http.client.HTTPConnection(HOST, page.port, timeout=600)
    content = json.dumps(body).encode() if body is not None else b""
    given = {"Content-Type": "application/json", "Host": f"{HOST}:{page.port}", "Content-Length": str(len(content))}
    connection.putrequest(method, path, skip_host=True)
    for name, value in (given | {name.replace("_", "-"): value for name, value in headers.items()}).items():
        connection.putheader(name, value)
    connection.endheaders(content)
    answer = connection.getresponse()
    return answer.status, answer.read()


def test_it_answers_this_computer_alone_behind_its_token_and_names_no_file(page: KnotPage) -> None:
    assert page._server.server_address[0] == "127.0.0.1"
    assert len(page.token) >= 32
    right = f"/{page.token}/"
    saved: list[list[float]] = []
    serving = Thread(target=lambda: saved.append(page.serve()), daemon=True)
    serving.start()
    status, text = asked(page, "GET", right)
    assert status == 200
    assert b"://" not in text.replace(b"http://www.w3.org/2000/svg", b"")
    for method, path in [
        ("GET", "/"), ("GET", "/wrong/"), ("GET", f"{right}../../etc/passwd"), ("GET", f"{right}try"),
        ("GET", f"/{page.token}"), ("POST", "/wrong/try"), ("POST", f"{right}other"),
    ]:  # fmt: skip
        assert asked(page, method, path, {"knots": KNOTS})[0] == 404, path
    assert asked(page, "GET", right, Host="evil.example")[0] == 404
    assert asked(page, "POST", f"{right}try", {"knots": KNOTS}, Content_Type="text/plain")[0] == 404
    assert asked(page, "POST", f"{right}try", {"knots": KNOTS}, Content_Length=str(MOST_REQUEST + 1))[0] == 404
    for wrong in ({"knots": []}, {"knots": ["x"]}, {"knots": [-1.0]}, [1], {"knots": [1e-6] * 13}, {"knots": [5.0]}):
        assert "error" in json.loads(asked(page, "POST", f"{right}try", wrong)[1])
    status, text = asked(page, "POST", f"{right}save", {"knots": [80e-6, 0.9e-6, 26e-6]})
    serving.join(600)
    assert saved == [KNOTS]
    found, once = json.loads(text), fric.identify_gms(LOG, knots=KNOTS, refine=False).document
    assert found["alpha"] == once["gms"]["alpha"]["value"]
    assert found["k"] == once["gms"]["k"]["value"]
    assert found["rmse"] == once["gms_fit"]["rmse"]["value"]


@pytest.mark.skipif(not (BROWSER and DRIVER), reason="there is no Chromium with its driver here")
@pytest.mark.long(4)
def test_a_knot_is_dragged_tried_and_saved_as_knots_would_be(tmp_path: Any, warm: dict[str, str]) -> None:
    webdriver = pytest.importorskip("selenium.webdriver", reason="selenium is not installed")
    words = ["fric", "identify", "gms", str(LOG), "--no-refine", "-o"]
    command = subprocess.Popen(
        [*words, str(tmp_path / "by-hand.yaml"), "--interactive", "--knots", "0.9 um, 26 um, 80 um"],
        env=warm, stderr=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
    )  # fmt: skip
    driver = None
    try:
        assert command.stderr is not None
        (address,) = re.findall(r"http://127\.0\.0\.1:\d+/\S+", command.stderr.readline())
        driver = started(tmp_path)
        driver.get(address)
        knots = driver.find_elements("css selector", ".knot")
        assert len(knots) == 3
        before = driver.find_element("css selector", "#blocks tbody").text
        webdriver.ActionChains(driver).click_and_hold(knots[1]).move_by_offset(30, 0).release().perform()
        wait = "const done = arguments[0]; const wait = () => document.documentElement.dataset.asked ? done() : "
        driver.set_script_timeout(600)
        driver.execute_async_script(wait + "setTimeout(wait, 50); wait();")
        after = driver.find_element("css selector", "#blocks tbody").text
        assert after.split()[0] == before.split()[0]  # the first knot stays
        assert after != before
        assert "presliding-sine-01" in driver.find_element("css selector", "#records tbody").text
        driver.save_screenshot(str(tmp_path / "page.png"))
        driver.find_element("css selector", "#save").click()
        assert [entry for entry in driver.get_log("browser") if entry["level"] in {"SEVERE", "WARNING"}] == []
        _, told = command.communicate(timeout=600)
        assert command.returncode == 0, told
        (given,) = re.findall(r"--knots '([^']+)'", told)
    finally:
        command.kill()
        if driver is not None:
            driver.quit()
    assert 26 < float(given.split(",")[1].split()[0]) < 60
    subprocess.run(
        [*words, str(tmp_path / "knots.yaml"), "--knots", given], env=warm, check=True, stdout=subprocess.DEVNULL
    )
    one, other = (plain(read_tree(tmp_path / name)) for name in ("by-hand.yaml", "knots.yaml"))
    for tree in (one, other):
        for name in ("created", "command"):
            tree["provenance"].pop(name)
    assert one == other


def test_ctrl_c_on_the_page_ends_with_130_and_writes_nothing(tmp_path: Any, warm: dict[str, str]) -> None:
    import signal

    words = ["fric", "identify", "gms", str(LOG), "-o", str(tmp_path / "a.yaml"), "--interactive"]
    command = subprocess.Popen(words, env=warm, stderr=subprocess.PIPE, text=True)
    assert command.stderr is not None
    assert "move the knots at" in command.stderr.readline()
    command.send_signal(signal.SIGINT)
    command.communicate(timeout=600)
    assert command.returncode == 130
    assert not list(tmp_path.iterdir())
