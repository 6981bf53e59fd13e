import sys
from collections.abc import Iterator
from pathlib import Path

import distributed
import numpy as np
import pytest

from fric.control.scheme import PAPER_SCHEMES
from fric.documents.machine_files import read_machine
from fric.errors import FricError
from fric.simulate import processes
from fric.simulate.contour_run import Circle
from fric.simulate.processes import Study, cluster_outcomes
from tests.studies import monte_carlo

STUDY = Study(
    read_machine(Path("configs/xy-table.yaml")),
    (PAPER_SCHEMES["a"], PAPER_SCHEMES["f"]),
    Circle(0.005, 0.05, 1),
    seed=4,
)


@pytest.fixture(scope="module")
def scheduler() -> Iterator[str]:
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, processes=False, dashboard_address=":0", protocol="tcp"
    ) as found:
        yield found.scheduler_address


def test_a_cluster_runs_the_same_machines_to_the_same_digits(scheduler):
    here = monte_carlo(STUDY, 5)
    with cluster_outcomes(STUDY, 5, scheduler, timeout=600) as there:
        outcomes = list(there)
    assert [outcome.index for outcome in outcomes] == [0, 1, 2, 3, 4]
    assert np.array_equal(here.quadrants, [outcome.quadrants for outcome in outcomes])
    assert [outcome.drawn for outcome in here.outcomes] == [outcome.drawn for outcome in outcomes]


def test_a_block_that_ends_early_cancels_what_was_not_begun(scheduler):
    with cluster_outcomes(STUDY, 200, scheduler, timeout=600) as outcomes:
        first = next(outcomes)
    assert np.array_equal(first.quadrants, STUDY(0).quadrants)
    with cluster_outcomes(STUDY, 1, scheduler, timeout=600) as outcomes:  # the cluster is free for the next
        assert len(list(outcomes)) == 1


def test_an_address_that_does_not_answer_is_told():
    for address in ("tcp://127.0.0.1:9", "no address"):
        with (
            pytest.raises(FricError, match="does not answer"),
            cluster_outcomes(STUDY, 1, address, timeout=0.5),
        ):
            pass


def test_a_cluster_without_workers_or_with_another_fric_is_told(scheduler, monkeypatch):
    def none_comes(client, count, timeout):
        raise TimeoutError

    with (
        monkeypatch.context() as waiting,
        distributed.LocalCluster(n_workers=0, processes=False, dashboard_address=":0", protocol="tcp") as empty,
    ):
        waiting.setattr(distributed.Client, "wait_for_workers", none_comes)
        address = empty.scheduler_address
        with pytest.raises(FricError, match="has no workers"), cluster_outcomes(STUDY, 1, address, timeout=600):
            pass
    monkeypatch.setattr(processes, "_version", _other_version)
    with pytest.raises(FricError, match=r"has fric 0\.0"), cluster_outcomes(STUDY, 1, scheduler, timeout=600):
        pass


def _other_version() -> str:
    return "0.0"


def test_dask_that_is_not_installed_is_told(monkeypatch):
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(FricError, match=r"fric\[dask\]"), cluster_outcomes(STUDY, 1, "tcp://127.0.0.1:9"):
        pass


@pytest.mark.long(15)
def test_workers_in_processes_of_their_own_give_the_same_digits():
    with (
        distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=":0") as found,
        cluster_outcomes(STUDY, 4, found.scheduler_address, timeout=600) as there,
    ):
        assert np.array_equal(monte_carlo(STUDY, 4).quadrants, [outcome.quadrants for outcome in there])
