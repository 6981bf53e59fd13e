"""What a library logs of a file is told of the file, and never printed."""

import logging
from pathlib import Path

from fric.io.readers.base import Format, heard


def test_files_may_be_closed_in_any_order(capsys):
    log = logging.getLogger("chatty.part")
    log.handlers = [logging.StreamHandler()]
    form = Format("Chatty", (".c",), "chatty")
    first, second = heard(form, Path("a.c")), heard(form, Path("b.c"))
    told_a = first.__enter__()
    log.warning("of a")
    told_b = second.__enter__()
    first.__exit__(None, None, None)
    log.warning("of b")
    second.__exit__(None, None, None)
    assert ([str(one) for one in told_a], [str(one) for one in told_b]) == (["a.c: of a"], ["b.c: of b"])
    assert capsys.readouterr().err == ""
    assert len(log.handlers) == 1
