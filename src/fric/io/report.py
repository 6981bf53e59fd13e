"""Report files: HTML for people, with what they were made of as JSON in them, so that a later report can compare."""

import json
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

from fric.errors import FricError
from fric.input import MOST_TEXT, regular
from fric.output import staged

FORMAT = "report/1"
DATA_ID = "fric-report"
REPORT_MARK = f'<script type="application/json" id="{DATA_ID}">'
"""Opens the part of a report that is for programs; a page must write it letter by letter like this."""


class _Data(HTMLParser):
    """Keeps the text of the one script element that holds the data."""

    def __init__(self) -> None:
        super().__init__()
        self.text: list[str] = []
        self._inside = False

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self._inside = tag == "script" and dict(attrs).get("id") == DATA_ID

    def handle_endtag(self, tag: str) -> None:
        self._inside = False

    def handle_data(self, data: str) -> None:
        if self._inside:
            self.text.append(data)


def read_report(path: Path) -> dict[str, Any]:
    """Return the data that a report was made of.

    Raises FricError: When the file holds no such data, or it is damaged.
    """
    parser, text = _Data(), regular(path, MOST_TEXT).read_text(encoding="utf-8", errors="replace")
    try:
        parser.feed(text)
        data = json.loads("".join(parser.text))
    except (ValueError, RecursionError, AssertionError):  # the last of Python's parser, where a section has no name
        data = None
    if not isinstance(data, dict) or data.get("fric") != FORMAT:
        raise FricError("is no whole report", where=str(path), hint="Make it again with `fric report`.")
    return data


def write_report(path: Path, html: str, *, force: bool = False) -> None:
    """Write a report whole or not at all."""
    with staged(Path(path), force=force) as draft:
        draft.write_text(html, encoding="utf-8")
