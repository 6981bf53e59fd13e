"""Cases of one test: a few in every session, all others in their turn."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import pytest


def in_turns(cases: Iterable[Any], quick: Iterable[Any], seconds: float = 1.0) -> list[Any]:
    """Return the cases, of which all but the ``quick`` ones are long; each takes so many seconds.

    For cases that hold one property of many kinds: what is quick goes through each way that the code takes.
    """
    kept = [*quick]
    late = pytest.mark.long(seconds)
    return [
        case if case in kept else pytest.param(*(case if isinstance(case, tuple) else (case,)), marks=late)
        for case in cases
    ]
