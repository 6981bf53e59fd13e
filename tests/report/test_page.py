"""The page: it stands alone, is small, and its numbers are those of the files."""

from __future__ import annotations

import re
from dataclasses import replace
from html.parser import HTMLParser
from math import nan
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from matplotlib.figure import Figure

import fric
from fric.documents.bundled import bundled
from fric.figures.diagnosis import _reversal
from fric.friction.gms import GMS
from fric.friction.stribeck import StaticMap
from fric.io.circle import read_runs
from fric.io.hdf5 import read_logs
from fric.notice import Notice
from fric.report.collect import ReportInput, collect
from fric.report.plots import _measured
from fric.report.view import _warnings, observations, render_report, summary_of
from fric.units import readable
from fric.verdict import Verdict

from .conftest import LOGS

DATA = Path(__file__).parents[2] / "data"


class Page(HTMLParser):
    """What of a page can load something, and what its tables and figures say."""

    def __init__(self, html: str) -> None:
        super().__init__()
        self.addresses: list[str] = []
        self.ids: list[str] = []
        self.numbers: dict[str, list[float]] = {}
        self.images: list[dict[str, str | None]] = []
        self.styles: list[str] = []
        self._row, self._tag = "", ""
        self.feed(html)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        given, self._tag = dict(attrs), tag
        names = ("src", "href", "action", "srcset", "poster", "data", "formaction", "xlink:href", "ping", "manifest")
        self.addresses += [str(given[name]) for name in names if name in given]
        self.ids += [str(given["id"])] if "id" in given else []
        if tag == "tr":
            self._row = str(given.get("data-scheme", ""))
        if tag == "data" and self._row:
            self.numbers.setdefault(self._row, []).append(float(str(given["value"])))
        if given.get("role") == "img" or tag == "img":
            self.images.append(given)

    def handle_data(self, data: str) -> None:
        if self._tag == "style":
            self.styles.append(data)


def test_the_next_step_names_the_axis_of_the_friction(files: SimpleNamespace) -> None:
    page = render_report(collect([files.static]))
    assert "plant and controller of axis x" in page
    assert "MACHINE.yaml" not in page  # there is none
    table = bundled("machine")["xy-table"]
    assert "fric simulate circle xy-table --friction x=" in render_report(collect([files.static, table]))
    text = files.static.read_text().replace("axis: x", "axis: screw")
    other = files.static.with_name("screw.yaml")
    other.write_text(text)
    assert "plant and controller of axis screw" in render_report(collect([other]))


@pytest.fixture(scope="module")
def html(files: SimpleNamespace) -> str:
    everything = [files.march, files.september, files.static, files.observer, files.plant, files.run, files.later_run]
    return render_report(collect([*everything, *sorted(LOGS.glob("*.h5"))]))


def test_it_is_one_small_file_that_names_no_address(html: str) -> None:
    page = Page(html)
    assert len(html.encode()) < 3_000_000
    assert all(address.startswith(("#", "data:")) for address in page.addresses)
    assert not any("url(" in style or "@import" in style for style in page.styles)
    assert "default-src 'none'" in html
    assert len(page.ids) == len(set(page.ids))
    assert {address[1:] for address in page.addresses if address.startswith("#")} <= set(page.ids)


def test_its_numbers_are_those_of_the_run_file(html: str, files: SimpleNamespace) -> None:
    numbers = Page(html).numbers
    for run in read_runs(files.later_run):
        found = run.circularity
        assert numbers[run.scheme.name] == [found.glitch, *found.quadrants, found.rms, found.range]


def test_a_scheme_has_the_same_glitch_in_table_headline_drift_and_words(files: SimpleNamespace) -> None:
    """The table held 0.8 µm of the machine as identified, above it 1.7, and a value above its "at most"."""
    inputs = collect([files.run])
    (test,) = inputs.tests
    shares = {"a": (0.95, 0.96, 0.97), "b": (2.0, 2.1, 2.2), "c": (2.0, 2.5, 3.0), "f": (nan, nan, nan)}
    drawn = replace(
        test,
        contours=tuple(
            replace(contour, drawn=tuple(contour.glitch * share for share in shares[contour.scheme.name]))
            for contour in test.contours
        ),
    )
    inputs = replace(inputs, tests=(drawn,))
    numbers = Page(render_report(inputs)).numbers
    for contour in drawn.contours:
        expected, most, *of_file = numbers[contour.scheme.name]
        assert expected == contour.middle
        assert most == contour.stays_under >= expected
        assert of_file == [*contour.glitches, contour.rms, contour.range]
    decided = inputs.verdict(drawn)
    assert decided.choice is not None
    assert readable(numbers[decided.choice.scheme.name][0], "m", 2) in decided.headline
    words = " ".join(observations(drawn))
    assert "(f)" not in words  # which ran on none of the machines
    for change in drawn.changes(drawn):
        assert change.after == numbers[change.name[1]][0]


@pytest.mark.parametrize("order", [1, -1])
def test_of_several_circles_the_one_that_was_simulated_judges(files: SimpleNamespace, order: int) -> None:
    """A page was headed by a circle at 10 mm/s, and gave the figures of another at 100 mm/s."""
    inputs = collect([files.run])
    (test,) = inputs.tests

    def circle(name: str, feed: float, glitch: float) -> Any:
        seen = SimpleNamespace(feed=feed, radius=test.radius, scheme="a")
        result = SimpleNamespace(
            held=SimpleNamespace(agrees={"+x": True}, scheme="a"), found=SimpleNamespace(test=seen, glitch=glitch),
            glitches=lambda: (glitch, glitch), unmodelled=dict, warnings=(), disagreements=lambda _: [],
        )  # fmt: skip
        return SimpleNamespace(source=name, path=Path(name), result=result)

    both = [circle("slow.h5", 0.1 * test.feed, 30e-6), circle("same.h5", test.feed, 60e-6)][::order]
    decided = replace(inputs, circles=tuple(both)).verdict(test)
    assert decided.compared == (60e-6, 60e-6)
    assert "slow.h5" not in " ".join(decided.next)


def test_every_figure_has_words_for_it(html: str) -> None:
    images = Page(html).images
    assert len(images) >= 8
    for image in images:
        assert len(str(image.get("aria-label") or image.get("alt"))) > 40
    assert "blocks slip at 0.934 µm" in html


def test_a_constant_force_is_no_error_of_the_replayed_cycle() -> None:
    """The page said 2.54 N rms of a cycle of which the fit said 1.82: the curves were apart by the offset."""
    (log, *_) = read_logs(DATA / "presliding-sine.h5")
    assert log.force is not None
    model = GMS(StaticMap(F_c=63.0, F_s=90.0, v_s=2e-3, delta=1.0, sigma=0.0), (0.5, 0.5), (3e7, 3e6))
    plain, shifted = (_measured([replace(log, force=log.force + more)], None, model)[0][0] for more in (0.0, 5.0))
    np.testing.assert_allclose(shifted.measured - shifted.model, plain.measured - plain.model, atol=1e-9)


def test_what_has_no_model_is_not_drawn_as_predicted() -> None:
    """Beside "no model" in the table a dashed line at 0 said that no glitch was predicted."""
    found, axes = fric.diagnose(DATA / "circle.h5").found, Figure().subplots()
    _reversal(axes, found, SimpleNamespace(agrees={"+x": True}), "+y")
    assert not any("predicted" in str(line.get_label()) for line in axes.lines)
    diagnosis = fric.diagnose(DATA / "circle.h5")
    assert diagnosis.unmodelled() == {}  # where nothing was predicted
    vars(diagnosis)["held"] = SimpleNamespace(agrees={"+x": True, "-x": True})
    (axis, glitch) = next(iter(diagnosis.unmodelled().items()))
    assert axis == "y"
    assert glitch == pytest.approx(38.6e-6, rel=0.01)
    decided = Verdict(choice=None, headline="", compared=(41e-6, 42e-6), unmodelled={axis: glitch})
    assert decided.checked == "Predicted 41 µm, measured 42 µm: trusted. Y was not identified: its 38.6 µm remain."


def test_it_says_whether_halves_of_the_strokes_agree(html: str, files: SimpleNamespace) -> None:
    """Nothing on the page said whether intervals are as wide as repeated measurements are apart."""
    assert "each half of the constant-velocity logs was identified alone: 13 of 14 values agree" in html
    assert "each half of" not in render_report(collect([files.static]))


def test_an_interval_has_minus_signs(html: str) -> None:
    """The page had −0.9 µm in its circles and -46 ns in the interval of force_lag."""
    assert not re.findall(r"<td[^>]*>[^<]*(?<![\w.])-\d", html)


def test_a_doubt_is_a_line_that_comes_once(html: str) -> None:
    assert html.count("strokes &lt;scatter&gt;") == 1
    assert '<details class="doubt' in html


def test_doubts_come_behind_what_was_found_and_are_escaped(html: str) -> None:
    """What is wrong stands with the decision."""
    assert html.index('id="advice"') < html.index('id="identified"') < html.index('id="warnings"')
    assert "strokes &lt;scatter&gt; by 2.1 N beyond their own noise &amp; more" in html


def test_a_page_of_a_run_alone_and_of_a_document_alone(files: SimpleNamespace) -> None:
    assert "xy feed table" in render_report(collect([files.run]))
    alone = render_report(collect([files.static]))
    assert "fric identify gms" in alone
    assert 'id="contours"' not in alone


def test_notes_are_no_doubts() -> None:
    """The page of a clean machine counted five doubts, of which each was a note."""
    notes = [("circle", Notice(f"{n}.", "", "note")) for n in "ab"]
    inputs = ReportInput()
    found = summary_of(inputs, [], notes)
    assert (found["further"], found["doubts"]) == ({"notes": 2}, "Notes")
    found = summary_of(inputs, [], [("plant", Notice("c.", "", "doubt")), *notes])
    assert (found["further"], found["doubts"]) == ({"doubts": 1, "notes": 2}, "Doubts and notes")


def test_a_reason_beside_the_decision_is_no_doubt_once_more() -> None:
    flaws = [Notice("The force is flat.", "", "wrong"), Notice("C is assumed.", "", "doubt")]
    inputs = SimpleNamespace(items=[SimpleNamespace(kind="plant", axis="x", warnings=flaws)], tests=(), circles=())
    decided = SimpleNamespace(why=(flaws[0].at("plant of axis x"),), settled=())
    assert [notice.says for _, notice in _warnings(inputs, [decided])] == ["C is assumed."]
