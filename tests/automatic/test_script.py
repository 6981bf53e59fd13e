"""Words of the script that `auto` writes, as `sh` reads them."""

from __future__ import annotations

import subprocess

import pytest

from fric.automatic.steps import _quoted


@pytest.mark.parametrize(
    "word",
    [
        "plain",
        "two words",
        "it's",
        "",
        "100 %",
        "back\\slash",
        "a\x1b[1m",
        "x\ny%s\\n'q'",
        "µ\u200b\x07 $HOME",
        "\udcff",
    ],
)
def test_sh_reads_a_word_as_it_was_and_a_terminal_sees_no_control_character(word: str) -> None:
    text = _quoted(word)
    assert text.isprintable()
    said = subprocess.run(["sh", "-c", f"printf %s {text}"], capture_output=True, check=True).stdout
    assert said == word.encode("utf-8", "surrogateescape")
