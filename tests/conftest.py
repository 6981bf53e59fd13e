"""Settings that all tests share, and how many of the long tests a session begins."""

from __future__ import annotations

import gc
import os
import time
from collections.abc import Iterator
from datetime import date
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

import pytest
from hypothesis import HealthCheck, settings
from hypothesis.internal.conjecture import providers

gc.set_threshold(100_000)  # as `fric` does: modules are no garbage
# A busy machine is no failure.
settings.register_profile(
    "fric", deadline=None, derandomize=True, database=None, suppress_health_check=[HealthCheck.too_slow]
)
settings.load_profile("fric")
if hasattr(providers, "_get_local_constants"):  # examples from the modules that are imported: those of a worker's turn
    providers._get_local_constants = providers.Constants

FIRST = {"test_docs.py", "test_mutation.py"}
"""Files with the longest single tests: at the end of a session one of them would run alone, on one core of several."""
NO_TIME = "no time left; run `make test-long`, or choose them by -m"


class Turn(NamedTuple):
    """Until when long tests are begun [s since 1970], and the day, which says whose turn it is first."""

    until: float
    day: int


TURN = pytest.StashKey[Turn | None]()


@pytest.fixture(scope="session")
def warm() -> Iterator[dict[str, str]]:
    """An environment in which a shell's `fric` and `python -c` need no start (`tests/warm.py`)."""
    from docs.examples import environment
    from tests.warm import on_path

    with TemporaryDirectory() as folder, on_path(Path(folder), environment()) as found:
        yield found


@pytest.fixture(scope="session", autouse=True)
def alone() -> Iterator[None]:
    """Give a study one process where a test asks for no more: the tests have the cores, and another starts cold."""
    from fric.simulate import processes

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(processes, "default_workers", lambda: 1)
        yield


def pytest_configure(config: pytest.Config) -> None:
    """Count from the start of the session FRIC_LONG_MINUTES (0); whoever selects by -m gets what was selected."""
    if os.environ.get("FRIC_NUDGE"):
        from tests.nudge import nudge

        nudge()
    if hasattr(config, "workerinput"):
        told = config.workerinput["fric_turn"]
        config.stash[TURN] = told and Turn(*told)
    elif any(word.startswith("-m") for word in config.invocation_params.args):
        config.stash[TURN] = None
    else:
        minutes = float(os.environ.get("FRIC_LONG_MINUTES", "0"))
        config.stash[TURN] = Turn(time.time() + 60 * minutes, date.today().toordinal())


@pytest.hookimpl(optionalhook=True)
def pytest_configure_node(node) -> None:
    """Hand the turn to a worker: one clock, and one order, which xdist asks for."""
    turn = node.config.stash[TURN]
    node.workerinput["fric_turn"] = turn and tuple(turn)


@pytest.hookimpl(trylast=True)
def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Put long tests behind all others, each day another file's first, and before all the files of `FIRST`."""
    turn = config.stash[TURN]
    if turn is not None:
        items[:] = in_turn(sorted(items, key=lambda item: item.path.name not in FIRST), turn.day)


def in_turn(items: list[pytest.Item], day: int) -> list[pytest.Item]:
    """Return tests with the long ones last, a file's together, the files rotated by the day."""
    late = [item for item in items if item.get_closest_marker("long")]
    files: list[Path] = list(dict.fromkeys(item.path for item in late))
    turned = {path: (place - day) % len(files) for place, path in enumerate(files)}
    return [item for item in items if item not in late] + sorted(late, key=lambda item: turned[item.path])


def pytest_collection_finish() -> None:
    """Keep what is there from the collector of garbage: it would look at a million things again and again."""
    gc.freeze()


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_setup(item: pytest.Item) -> None:
    """Begin a long test only where the time is enough for what its marker says that it takes."""
    turn, marker = item.config.stash[TURN], item.get_closest_marker("long")
    if turn is not None and marker is not None:
        (takes,) = marker.args or (60,)
        if time.time() + takes > turn.until:
            pytest.skip(NO_TIME)


def pytest_terminal_summary(terminalreporter) -> None:
    """Tell in a line how many long tests were begun, which first, and how many were not."""
    reports = [one for kind in terminalreporter.stats.values() for one in kind if isinstance(one, pytest.TestReport)]
    late = [one for one in reports if "long" in one.keywords]
    left = [one for one in late if one.skipped and NO_TIME in str(one.longrepr)]
    begun = sorted((one for one in late if one.when == "call"), key=lambda one: one.start)
    if left:
        first = f" ({begun[0].nodeid.partition('::')[0]} first today)" if begun else ""
        terminalreporter.write_line(f"long tests: {len(begun)} begun{first}, {len(left)} had {NO_TIME}")
