"""Files of one record each are joined where names, clock and physics say so, and asked for where they nearly do."""

from pathlib import Path

import numpy as np
import pytest

import fric
from fric.automatic.sources import find_sources
from fric.errors import FricError
from fric.io.hdf5 import read_records
from fric.io.ingest import ingest
from fric.io.pairs import with_joined

T = np.arange(4000) * 2e-3


def path_of(seed: int) -> np.ndarray:
    rng = np.random.default_rng(seed)
    return sum(rng.normal() * np.sin(2 * np.pi * f * T + rng.uniform(0, 6)) for f in (0.2, 0.35, 0.7))


def force_of(x: np.ndarray) -> np.ndarray:
    v = np.gradient(x, T)
    return 20 * np.sign(v) + 3 * v + 0.5 * np.gradient(v, T)


def written(folder: Path, name: str, head: str, *columns: np.ndarray) -> Path:
    folder.mkdir(exist_ok=True)
    path = folder / f"{name}.csv"
    np.savetxt(path, np.column_stack(columns), delimiter=",", header=head, comments="", fmt="%.8g")
    return path


def pair(folder: Path, names: tuple[str, str], x: np.ndarray, force: np.ndarray, rate: int = 1) -> list[Path]:
    return [written(folder, names[0], "time [s],position [mm]", T, x),
            written(folder, names[1], "time [s],force [N]", T[::rate], force[::rate])]  # fmt: skip


def test_runs_in_two_files_each_are_joined_and_said(tmp_path):
    x, y = path_of(1), path_of(2)
    files = pair(tmp_path / "logs", ("run1_pos", "run1_force"), x, force_of(x), rate=2)
    files += pair(tmp_path / "logs", ("run2_pos", "run2_force"), y, force_of(y))
    (tmp_path / "logs/readme.txt").write_text("two runs")
    found = find_sources([tmp_path / "logs"], proposals=tmp_path / "out/mappings")
    assert {log.path.name for log in found.logs} == {"run1_force+run1_pos.h5", "run2_force+run2_pos.h5"}
    (told,) = (one for one in found.description if one.code == "files-joined")
    assert "and 1 more" in str(told)
    assert not found.refused
    ingest(next(log.path for log in found.logs if "run1" in log.path.name), tmp_path / "log.h5")
    (log,) = read_records(tmp_path / "log.h5")
    assert log.time == pytest.approx(T[::2])  # at the samples of the slower file
    assert log.force == pytest.approx(force_of(x)[::2], rel=1e-6)
    assert log.position == pytest.approx(1e-3 * x[::2], abs=1e-9)


@pytest.mark.parametrize("clear", [2, 3])
def test_a_record_whose_force_is_of_the_mass_is_joined_as_those_of_its_words(tmp_path, clear):
    """A response and a sine in sliding were left out, beside twelve records in files of the same words."""
    files = []
    for run in range(clear):
        files += pair(tmp_path, (f"run{run}_pos", f"run{run}_force"), path_of(run), force_of(path_of(run)))
    noise = np.random.default_rng(9).normal(size=len(T))
    files += pair(tmp_path, ("response_pos", "response_force"), path_of(7), noise)
    paths, (told, *_), _ = with_joined(files, tmp_path / "joined", None, assume=False)
    assert len([path for path in paths if path.suffix == ".h5"]) == (clear + 1 if clear == 3 else clear)
    assert f"and {clear if clear == 3 else 1} more" in str(told)


@pytest.mark.parametrize(("names", "other"), [
    (("x_pos", "y_force"), False), (("a_pos", "a_force"), True), (("run1", "run2"), False),
])  # fmt: skip
def test_files_of_other_names_or_another_motion_are_not_joined(tmp_path, names, other):
    """Not with `assume` either: a force of another run would give a friction that is wrong and sure."""
    files = pair(tmp_path, names, path_of(1), force_of(path_of(3 if other else 1)))
    assert with_joined(files, tmp_path / "joined", None, assume=True) == (files, [], 0)


def test_another_span_or_two_positions_are_not_joined(tmp_path):
    x = path_of(1)
    files = pair(tmp_path, ("pos", "force"), x, force_of(x))
    written(tmp_path, "force", "time [s],force [N]", T + 3.0, force_of(x))
    assert not with_joined(files, tmp_path / "joined", None, assume=True)[1]
    written(tmp_path, "force", "Zeit [s],force [N]", T, force_of(x))
    assert not with_joined(files, tmp_path / "joined", None, assume=True)[1]
    written(tmp_path, "force", "time [s],position [mm]", T, x)
    assert not with_joined(files, tmp_path / "joined", None, assume=True)[1]


@pytest.mark.parametrize("answer", ["1", "2"])
def test_what_is_less_sure_is_asked(tmp_path, answer):
    """A force beside much of another; without a terminal the files stay apart."""
    x = path_of(1)
    files = pair(tmp_path, ("pos", "force"), x, force_of(x) + 2.0 * force_of(path_of(5)))
    assert with_joined(files, tmp_path / "joined", None, assume=False) == (files, [], 0)
    asked = []

    def ask(question) -> None:
        asked.append(question.text)
        assert question.take(answer)

    paths, said, count = with_joined(files, tmp_path / "joined", ask, assume=False)
    assert (count, len(asked)) == (1, 1)
    assert "pos.csv + force.csv" in asked[0]
    assert [path.name for path in paths] == (["pos.csv", "force.csv"] if answer == "1" else ["pos+force.h5"])
    assert all("Look whether they are of one run" in str(one) for one in said)
    assert len(said) == (answer == "2")


@pytest.mark.parametrize("form", ["csv", "npy", "named"])
@pytest.mark.parametrize("timed", [True, False])
def test_files_of_a_variable_each_are_one_record(tmp_path, form, timed):
    """As robots' data are: q, dq, tau, and t or a rate; each was a log of its own, and none could be used."""
    x, y = path_of(1), path_of(2)
    variables = {"q": np.column_stack([x, y]), "dq": np.gradient(np.column_stack([x, y]), T, axis=0),
                 "tau": np.column_stack([force_of(x), force_of(y)])} | ({"t": T} if timed else {})  # fmt: skip
    names = {"q": "position", "dq": "velocity", "tau": "effort", "t": "time"} if form == "named" else {}
    for name, values in variables.items():
        if form == "npy":
            np.save(tmp_path / f"run1_{name}.npy", values)
        else:
            head = "joint1,joint2" if form == "named" and values.ndim > 1 else names.get(name, "")
            written(tmp_path, f"run1_{names.get(name, name)}", head, values)
            path = tmp_path / f"run1_{names.get(name, name)}.csv"
            path.write_text(path.read_text().lstrip("\n"))
    found = find_sources([tmp_path], proposals=tmp_path / "out/mappings", assume=True)
    first = "axis1" if form == "named" else "axis0"  # joint1
    assert sorted(log.axis for log in found.logs) == [first, f"axis{int(first[-1]) + 1}"]
    (path, mapping), *more = {(log.path, log.mapping) for log in found.logs}
    assert not more
    fric.ingest(path, output=tmp_path / "log.h5", mapping=mapping, axis=first)
    (log,) = read_records(tmp_path / "log.h5")
    assert np.diff(log.time) == pytest.approx(2e-3)
    assert log.position == pytest.approx(x, abs=1e-6)
    assert log.force == pytest.approx(force_of(x), rel=1e-6)


@pytest.mark.parametrize("names", [("q", "dq", "dq2"), ("q", "dq", "temperature"), ("run", "test", "tau")])
def test_files_without_motion_and_force_by_name_are_no_record(tmp_path, names):
    x = path_of(1)
    columns = zip(names, (x, np.gradient(x, T), force_of(x)), strict=True)
    files = [written(tmp_path, name, "", values) for name, values in columns]
    assert with_joined(files, tmp_path / "joined", None, assume=True) == (files, [], 0)


def test_variables_of_other_lengths_are_no_record(tmp_path):
    x = path_of(1)
    files = [written(tmp_path, "q", "", x), written(tmp_path, "tau", "", force_of(x)[:-1])]
    assert with_joined(files, tmp_path / "joined", None, assume=True) == (files, [], 0)


def test_short_names_of_files_with_one_column_are_known(tmp_path):
    x = path_of(1)
    for name, values in {"t": T, "theta": x, "omega": np.gradient(x, T), "tau": force_of(x)}.items():
        np.savetxt(tmp_path / f"{name}.txt", values, fmt="%.8g")
    (log,) = find_sources([tmp_path], proposals=tmp_path / "out/mappings", assume=True).logs
    assert log.path.name == "omega+t+tau+theta.h5"
    assert log.motion.startswith("rotary")


def test_an_error_about_joined_files_names_those_that_were_given(tmp_path):
    """It named `joined/omega+t+tau+theta.h5` in the output folder, which the user never made."""
    x = path_of(1)
    given = [tmp_path / f"{name}.txt" for name in ("omega", "t", "tau", "theta")]
    for path, values in zip(given, (np.gradient(x, T), T, force_of(x), x), strict=True):
        np.savetxt(path, values, fmt="%.8g")
    with pytest.raises(FricError) as raised:
        fric.auto(tmp_path, output=tmp_path.parent / f"{tmp_path.name}-out")
    assert raised.value.where == ", ".join(map(str, given))
    (assumed,) = find_sources([tmp_path], proposals=tmp_path.parent / "made/mappings", assume=True).description[-1:]
    assert str(given[0]) in str(assumed)


def test_a_folder_for_each_record_with_a_file_a_channel(tmp_path: Path) -> None:
    """Whose names differ in channel and unit: no log could be used, and two files at a time were asked to be joined."""
    logs, runs = tmp_path / "logs", {"slow": path_of(3), "fast": path_of(4), "third": path_of(5)}
    logs.mkdir()
    for run, x in runs.items():
        for name, values in (("position_mm", x), ("reference_mm", x + 1e-4), ("force_N", force_of(x))):
            written(logs / run, f"x_{name}", f"time [s],{name.replace('_', ' [')}]", T, values)
    found = find_sources([logs], proposals=tmp_path / "out/mappings")
    assert {log.path.name for log in found.logs} == {"slow.h5", "fast.h5", "third.h5"}
    ingest(next(log.path for log in found.logs if log.path.name == "slow.h5"), tmp_path / "log.h5")
    (log,) = read_records(tmp_path / "log.h5")
    assert log.force == pytest.approx(force_of(runs["slow"]), rel=1e-6)
    assert log.reference == pytest.approx(1e-3 * runs["slow"] + 1e-7, abs=1e-9)
