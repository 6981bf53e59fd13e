"""What the build of the documentation adds: formulas as MathML, and the notebook with what its cells print.

Nothing is fetched by a page: MathML is drawn by the browser itself. `FRIC_NOTEBOOK=as-it-is` leaves the cells
alone; else they are run, in a kernel that is started in the checkout.
"""

from __future__ import annotations

import json
import os
import re
from html import escape, unescape
from pathlib import Path
from typing import Any

from latex2mathml.converter import convert

ROOT = Path(__file__).parents[1]
FORMULA = re.compile(r'<(span|div) class="arithmatex">\\([(\[])(.*?)\\[)\]]</\1>', re.DOTALL)


def on_page_content(html: str, **_: Any) -> str:
    """Return a page with its formulas as MathML."""
    return FORMULA.sub(
        lambda found: convert(unescape(found[3]), display="block" if found[2] == "[" else "inline"), html
    )


def on_page_read_source(page: Any, **_: Any) -> str | None:
    """Return the Markdown of a page that stands for a notebook; the plain page otherwise."""
    notebook = Path(page.file.abs_src_path).with_suffix(".ipynb")
    if not notebook.is_file():
        return None
    cells = json.loads(notebook.read_text(encoding="utf-8"))["cells"]
    if os.environ.get("FRIC_NOTEBOOK") != "as-it-is":
        cells = executed(notebook)
    return "\n\n".join(part for cell in cells for part in markdown(cell))


def executed(notebook: Path) -> list[Any]:
    """Return the cells of a notebook with their outputs; a cell that fails ends the build."""
    try:
        import nbformat
        from nbclient import NotebookClient
    except ImportError:
        what = "The notebook is run by nbclient: `make docs` installs it, and FRIC_NOTEBOOK=as-it-is leaves it out."
        raise SystemExit(what) from None

    given = nbformat.read(notebook, as_version=4)
    quiet = ["--log-level=40"]  # else the kernel warns of how it is reached, each time
    NotebookClient(given, timeout=300, extra_arguments=quiet, resources={"metadata": {"path": str(ROOT)}}).execute()
    return list(given["cells"])


def markdown(cell: Any) -> list[str]:
    """Return a cell, and what it printed, as parts of a Markdown page."""
    text = "".join(cell["source"])
    if cell["cell_type"] == "markdown":
        return [text]
    parts = [f"```python\n{text}\n```"]
    for output in cell["outputs"]:
        shown = output.get("data", {})
        if "image/png" in shown:
            parts.append(
                f'<img alt="Figure of the cell above" src="data:image/png;base64,{shown["image/png"].strip()}">'
            )
        elif "text/html" in shown:
            parts.append(re.sub(r"\n\s*\n", "\n", "".join(shown["text/html"])))
        else:
            printed = "".join(output.get("text", shown.get("text/plain", "")))
            parts.append(f'<pre class="output">{escape(printed)}</pre>')
    return parts
