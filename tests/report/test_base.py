"""The base of every page: it stands alone, and it escapes."""

from __future__ import annotations

import re
from math import inf

from fric.report.view import embedded, environment, micrometres, minus


def test_a_page_that_extends_the_base_loads_nothing() -> None:
    blocks = "".join(f"{{% block {block} %}}{{{{ name }}}}{{% endblock %}}" for block in ("title", "content"))
    page = environment().from_string(f'{{% extends "base.html.j2" %}}{blocks}')
    html = page.render(name="<b>x & y</b>")
    assert "<b>x" not in html
    assert html.count("&lt;b&gt;x &amp; y&lt;/b&gt;") == 3  # title, heading, content
    assert not re.findall(r"""(?:src|href)=["'](?!#|data:)""", html)
    assert not re.search(r"@import|url\(", html)


def test_a_command_in_a_sentence_is_set_as_code() -> None:
    """The page showed the marks of Markdown."""
    page = environment().from_string("{{ text }}").render(text="`fric tune` & <b>`x`; a ` alone").strip()
    assert page == "`fric tune` &amp; &lt;b&gt;`x`; a ` alone"
    page = environment().from_string("{{ text }}").render(text="Run `fric tune` & <b>.")
    assert page == "Run <code>fric tune</code> &amp; &lt;b&gt;."


def test_numbers_of_a_page_carry_a_true_minus_and_one_decimal() -> None:
    assert micrometres(-9.13e-6) == "−9.1"
    assert micrometres(21.94e-6, sign=True) == "+21.9"
    assert micrometres(inf) == micrometres(None) == "–"  # no limit, where a scheme cannot run on every machine
    assert minus("-46 … -3") == "−46 … −3"
    assert minus("-x") == "−x"
    assert minus("low-pass, 3-2") == "low-pass, 3-2"
    assert embedded(b"<svg/>") == "data:image/svg+xml;base64,PHN2Zy8+"
