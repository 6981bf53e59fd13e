"""The documentation builds strictly and without network, its pages fetch nothing from elsewhere, and it is searched."""

from __future__ import annotations

import json
import os
import re
import runpy
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import fric

ROOT = Path(__file__).parents[1]
FETCHED = re.compile(
    r"<(?:script|img|iframe|source)\b[^>]*\bsrc=[\"']?(?:https?:)?//|<link\b[^>]*\bhref=[\"']?(?:https?:)?//"
)

BUILT = pytest.mark.long(12)
"""What needs the built site."""


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    folder = tmp_path_factory.mktemp("site")
    nowhere = {name: "http://127.0.0.1:9" for name in ("http_proxy", "https_proxy", "HTTP_PROXY", "HTTPS_PROXY")}
    done = subprocess.run(
        [sys.executable, "-m", "mkdocs", "build", "--strict", "--quiet", "--site-dir", str(folder)],
        cwd=ROOT,
        env=os.environ | nowhere | {"NO_MKDOCS_2_WARNING": "1", "FRIC_NOTEBOOK": "as-it-is"},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return folder


@BUILT
def test_every_page_is_built_and_in_the_navigation(site):
    start = (site / "index.html").read_text()
    for page in (ROOT / "docs").glob("*.md"):
        assert (site / f"{page.stem}.html").is_file()
        assert f'href="{page.stem}.html"' in start, f"{page.name} is not in the nav of mkdocs.yml"


@BUILT
def test_pages_fetch_nothing_from_elsewhere(site):
    for page in site.rglob("*.html"):
        assert not FETCHED.search(page.read_text()), page.name
    for sheet in site.rglob("*.css"):
        assert not re.search(r"@import|url\((?:[\"']?)(?:https?:)?//", sheet.read_text()), sheet.name


def test_every_page_is_named_and_every_link_between_pages_leads_to_one():
    """In rough what a strict build tells."""
    named = (ROOT / "mkdocs.yml").read_text()
    for page in (ROOT / "docs").glob("*.md"):
        assert re.search(rf"[ :]{page.name}$", named, re.MULTILINE), f"{page.name} is not in the nav of mkdocs.yml"
        for target in re.findall(r"\]\((?!\w+:)([^)#\s]+\.\w+)[^)]*\)", page.read_text()):
            assert (page.parent / target).exists(), f"{page.name}: {target}"


def test_every_public_name_is_in_the_list_of_the_library_page():
    listed = (ROOT / "docs/api.md").read_text()
    assert [name for name in fric.__all__ if not re.search(rf"\b{name}\b", listed)] == []


def test_every_picture_is_there_and_says_what_it_shows():
    for page in (ROOT / "docs").glob("*.md"):
        for told, target in re.findall(r"!\[([^\]]*)\]\(([^)]+)\)", page.read_text()):
            assert (page.parent / target).is_file(), f"{page.name}: {target}"
            assert len(told) > 20, f"{page.name}: {target} has no words for those who do not see it"


def test_versions_lie_beside_each_other_and_the_newest_release_is_found(tmp_path):
    built = tmp_path / "site"
    built.mkdir()
    placed = runpy.run_path(str(ROOT / "docs/versions.py"))["place"]
    for version in ("0.9.0", "0.10.0", "0.11.0rc1", "0.9.0"):
        (built / "index.html").write_text(version)
        versions = placed(built, tmp_path / "published", version)
    assert versions == ["0.11.0rc1", "0.10.0", "0.9.0"]
    listed = (tmp_path / "published/index.html").read_text()
    assert [listed.index(f'href="{version}/index.html"') for version in versions] == sorted(
        listed.index(f'href="{version}/index.html"') for version in versions
    )
    assert "../0.10.0/index.html" in (tmp_path / "published/newest/index.html").read_text()
    assert (tmp_path / "published/0.9.0/index.html").read_text() == "0.9.0"


@BUILT
def test_every_public_name_is_on_the_library_page(site):
    page = (site / "api.html").read_text()
    for name in fric.__all__:
        assert re.search(rf'<h[2-5] id="fric\.[\w.]*\b{name}"', page), f"{name} is not in docs/api.md"
    assert page.count("Parameters:") > 40


@BUILT
def test_the_search_works_from_a_file(site, tmp_path):
    webdriver = pytest.importorskip("selenium.webdriver", reason="selenium is not installed")
    browser = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
    driver = shutil.which("chromedriver")
    if not (browser and driver):
        pytest.skip("there is no Chromium with its driver here")
    options = webdriver.ChromeOptions()
    options.binary_location = browser
    for switch in ("--headless", "--no-sandbox", "--disable-gpu", f"--user-data-dir={tmp_path}"):
        options.add_argument(switch)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    page = webdriver.Chrome(options=options, service=webdriver.ChromeService(driver))
    try:
        page.get((site / "api.html").as_uri())
        page.execute_script("document.querySelector('[data-md-toggle=search]').click()")
        page.find_element("css selector", "input.md-search__input").send_keys("with_belief")
        page.set_script_timeout(600)
        found = page.execute_async_script(
            "const done = arguments[0]; const wait = () => { const hits = [...document.querySelectorAll("
            "'.md-search-result__item')].map((hit) => hit.textContent); "
            "hits.length ? done(hits) : setTimeout(wait, 50); }; wait();"
        )
        assert any("with_belief" in hit for hit in found)
        assert not [line for line in page.get_log("browser") if line["level"] == "SEVERE"]
    finally:
        page.quit()


def cells(kind):
    notebook = json.loads((ROOT / "docs/session.ipynb").read_text(encoding="utf-8"))
    return [cell for cell in notebook["cells"] if cell["cell_type"] == kind]


@BUILT
def test_formulas_are_drawn_by_the_browser_itself(site):
    pages = {name: (site / f"{name}.html").read_text() for name in ("theory", "session")}
    assert pages["theory"].count('<math xmlns="http://www.w3.org/1998/Math/MathML" display="block">') == 8
    assert all("<math" in page and "arithmatex" not in page for page in pages.values())


@BUILT
def test_the_notebook_is_kept_without_outputs_and_shown_on_its_page(site):
    page = (site / "session.html").read_text()
    assert page.count('class="highlight"') == len(cells("code"))
    assert not any(cell["outputs"] or cell["execution_count"] for cell in cells("code"))


@pytest.mark.long(15)
def test_the_notebook_runs(monkeypatch, capsys):
    monkeypatch.chdir(ROOT)
    names = {}
    for cell in cells("code"):
        exec("".join(line for line in cell["source"] if not line.startswith("%")), names)
    assert "report.html" in capsys.readouterr().out
