"""Settings that all tests share, and how many of the long tests a session begins."""

from __future__ import annotations

import gc
import os
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from datetime import date
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

import numpy as np
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
DATA = Path(__file__).parents[1] / "data"
NOT_TODAY = "another day's turn; run `make test-long`, or choose them by -m"


class Turn(NamedTuple):
    """How many seconds of long tests are run, and the day, which says whose turn it is."""

    seconds: float
    day: int


TURN = pytest.StashKey[Turn | None]()
WARM = pytest.StashKey[str]()
"""The PATH on which commands are those of the warm fric."""


@contextmanager
def served() -> Iterator[dict[str, str]]:
    """Yield an environment in which a shell's `fric` and `python -c` need no start (`tests/warm.py`)."""
    from docs.examples import environment
    from tests.warm import on_path

    with TemporaryDirectory() as folder, on_path(Path(folder), environment()) as found:
        yield found


@pytest.fixture(scope="session")
def warm(request: pytest.FixtureRequest) -> Iterator[dict[str, str]]:
    """An environment in which commands need no start: all workers share the one of the process that began them."""
    if (path := getattr(request.config, "workerinput", {}).get("fric_path")) is None:
        with served() as found:
            yield found
    else:
        from docs.examples import environment

        yield environment() | {"PATH": path}


@pytest.fixture(scope="session", autouse=True)
def alone(request: pytest.FixtureRequest) -> Iterator[None]:
    """Give a study one process where a test asks for no more: the tests have the cores, and another starts cold.

    No command says how far it is, however long it takes on a busy machine. The process that opens a MATLAB file is the
    warm one where there is one; tests/hostile/test_apart.py starts the cold one.
    """
    from fric.cli import console
    from fric.io.readers import matlab
    from fric.simulate import processes

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(processes, "default_workers", lambda: 1)
        patch.setattr(console, "EVERY", 1e6)
        if path := getattr(request.config, "workerinput", {}).get("fric_path"):
            from tests.warm import run_python

            patch.setattr(matlab, "run_python", partial(run_python, path))
        yield


@pytest.fixture(scope="session")
def rig_plant() -> Any:
    """Return the plant that is identified from the bundled response: a result, which no test changes."""
    import fric

    return fric.identify_plant(DATA / "frequency-response.h5")


@pytest.fixture(scope="session")
def rig_static(rig_plant: Any) -> Any:
    """Return the static map that is identified from the bundled strokes, with the plant."""
    import fric

    return fric.identify_static(fric.read(DATA / "constant-velocity.h5"), plant=rig_plant)


STATES: dict[str, Any] = {}


@pytest.fixture(autouse=True)
def drawn_alike(request: pytest.FixtureRequest) -> None:
    """Let a module's generator draw the same for a test, whichever of its tests ran before in this process."""
    if (rng := getattr(request.module, "RNG", None)) is not None:
        rng.bit_generator.state = STATES.setdefault(request.module.__name__, rng.bit_generator.state)


def pytest_configure(config: pytest.Config) -> None:
    """Take FRIC_LONG_SECONDS (0) of the long tests today; whoever selects by -m gets what was selected."""
    if os.environ.get("FRIC_NUDGE"):
        from tests.nudge import nudge

        nudge()
    if hasattr(config, "workerinput"):
        told = config.workerinput["fric_turn"]
        config.stash[TURN] = told and Turn(*told)
    elif any(word.startswith("-m") for word in config.invocation_params.args):
        config.stash[TURN] = None
    else:
        config.stash[TURN] = Turn(float(os.environ.get("FRIC_LONG_SECONDS", "0")), date.today().toordinal())


@pytest.hookimpl(optionalhook=True)
def pytest_configure_node(node) -> None:
    """Hand the turn to a worker: one day, and one order, which xdist asks for; and the warm fric of all.

    What is compiled is compiled before the first worker begins, once.
    """
    config = node.config
    turn = config.stash[TURN]
    node.workerinput["fric_turn"] = turn and tuple(turn)
    if Path(__file__).parents[1] == config.rootpath:
        if WARM not in config.stash:
            stack = ExitStack()
            config.add_cleanup(stack.close)
            config.stash[WARM] = stack.enter_context(served())["PATH"]
        node.workerinput["fric_path"] = config.stash[WARM]


@pytest.hookimpl(trylast=True)
def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Put the files of `FIRST` and the long tests of today before all others, and skip the other long ones."""
    turn = config.stash[TURN]
    if turn is None:
        return
    late = [item for item in items if item.get_closest_marker("long")]
    today = in_turn([takes(item) for item in late], turn)
    chosen = {id(item) for item, own in zip(late, today, strict=True) if own}
    for item in late:
        if id(item) not in chosen:
            item.add_marker(pytest.mark.skip(NOT_TODAY))
    items.sort(key=lambda item: item.path.name not in FIRST and id(item) not in chosen)


def takes(item: pytest.Item) -> float:
    """Return how long a long test takes by its marker [s]."""
    marker = item.get_closest_marker("long")
    return float(marker.args[0]) if marker and marker.args else 60.0


def in_turn(seconds: Sequence[float], turn: Turn) -> list[bool]:
    """Return which tests of such lengths are run on a day: those that begin in its part of all, in their order.

    Each comes in its turn as often as any other; none that is longer than the part of a day comes.
    """
    fit = [length if length <= turn.seconds else 0.0 for length in seconds]
    total = sum(fit)
    begin = np.cumsum(fit) - fit
    return [
        bool(length and (at - turn.day * turn.seconds) % total < turn.seconds)
        for length, at in zip(fit, begin, strict=True)
    ]


def pytest_collection_finish() -> None:
    """Keep what is there from the collector of garbage: it would look at a million things again and again."""
    gc.freeze()


def pytest_terminal_summary(terminalreporter) -> None:
    """Say in a line how many long tests were run, and how many not."""
    reports = [one for kind in terminalreporter.stats.values() for one in kind if isinstance(one, pytest.TestReport)]
    late = [one for one in reports if "long" in one.keywords]
    left = [one for one in late if one.skipped and NOT_TODAY in str(one.longrepr)]
    if left:
        run = {one.nodeid for one in late} - {one.nodeid for one in left}
        terminalreporter.write_line(f"long tests: {len(run)} run, {len(left)} have {NOT_TODAY}")
