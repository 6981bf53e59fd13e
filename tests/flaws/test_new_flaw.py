"""The walk-through of docs/new-flaw.md is true: its entry, its function and its record make a flaw."""

import re
from pathlib import Path

import numpy as np

from fric.estimate import Estimate
from fric.flaws import entry
from fric.flaws.base import Flaw
from fric.log import Log
from fric.notice import Notice

from .test_catalogue import of_force

PAGE = (Path(__file__).parents[2] / "docs/new-flaw.md").read_text("utf-8")


def test_the_page_makes_a_flaw_that_is_found_at_its_threshold_and_has_a_page() -> None:
    names = {
        "Flaw": Flaw,
        "Log": Log,
        "Notice": Notice,
        "Estimate": Estimate,
        "np": np,
        "of_force": of_force,
        "SHOWN": {},
    }
    for block in re.findall(r"^```python\n(.*?)^```", PAGE, flags=re.MULTILINE | re.DOTALL):
        exec(block, names)
    show = names["SHOWN"]["force-stuck"]
    (found,) = show(1.5)
    assert found.code == "force-stuck"
    assert found.severity == "doubt"
    assert found.says.startswith("The force is 300 N in 30% of the samples: the channel hangs. Look")
    assert show(0.67) == []
    assert show(3.0)[0].severity == "wrong"
    assert "an error of 10% in the level of friction" in entry(names["FORCE_STUCK"])
