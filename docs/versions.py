"""Puts a built site beside those of earlier versions, with a page that lists them, newest first.

``python docs/versions.py FOLDER``: what `make docs` built goes to FOLDER/VERSION, in place of an earlier build of that
version; FOLDER/index.html lists all, and FOLDER/newest/ leads to the newest release. A host serves FOLDER as it is.
"""

from __future__ import annotations

import re
import shutil
import sys
from pathlib import Path

ROOT = Path(__file__).parents[1]
PAGE = """<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8"><title>fric</title>{head}</head>
<body>{body}</body></html>
"""


def place(site: Path, folder: Path, version: str) -> list[str]:
    """Place a built site; return all versions that are in the folder, the newest first."""
    folder.mkdir(parents=True, exist_ok=True)
    if (folder / version).exists():
        shutil.rmtree(folder / version)
    shutil.copytree(site, folder / version)
    numbered = (path.name for path in folder.iterdir() if re.fullmatch(r"\d+(\.\d+)+\S*", path.name))
    versions = sorted(numbered, key=_order, reverse=True)
    links = "".join(f'<li><a href="{name}/index.html">{name}</a></li>' for name in versions)
    _write(folder / "index.html", body=f"<h1>Documentation of fric</h1><ul>{links}</ul>")
    released = next((name for name in versions if _order(name)[1]), versions[0])
    target = f"../{released}/index.html"
    head = f'<meta http-equiv="refresh" content="0; url={target}">'
    _write(folder / "newest" / "index.html", head=head, body=f'<a href="{target}">{released}</a>')
    return versions


def _order(version: str) -> tuple[list[int], bool, str]:
    """Return a key that sorts 0.10.0 behind 0.9.0, and 1.0.0 behind 1.0.0rc1."""
    number, rest = re.fullmatch(r"([\d.]*\d)(.*)", version).groups()  # type: ignore[union-attr]
    return [int(part) for part in number.split(".")], not rest, rest


def _write(path: Path, *, head: str = "", body: str) -> None:
    path.parent.mkdir(exist_ok=True)
    path.write_text(PAGE.format(head=head, body=body), encoding="utf-8")


if __name__ == "__main__":
    project = (ROOT / "pyproject.toml").read_text(encoding="utf-8")
    made = re.search(r'^version = "([^"]+)"', project, re.MULTILINE)
    assert made is not None
    print("\n".join(place(ROOT / "site", Path(sys.argv[1]), made[1])))
