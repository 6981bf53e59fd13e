"""MATLAB files of both versions give the same table."""

import io
import pickle

import h5py
import numpy as np
import pytest
from scipy.io import savemat

import fric
from fric import FricError
from fric.automatic.sources import find_sources
from fric.documents.mapping import MappingDocument
from fric.documents.yaml import read_document
from fric.io.hdf5 import read_logs
from fric.io.ingest import ingest
from fric.io.readers import tables
from fric.io.readers.matlab import _Values

T = np.arange(200_000) / 1000
X = np.sin(T)


def table(path):
    (found,) = tables(path)
    return found


def v73(path, write):
    """An HDF5 file as MATLAB writes it: behind a block of 512 bytes, matrices transposed, structs as groups."""
    with h5py.File(path, "w", userblock_size=512) as file:
        write(file)
    with path.open("r+b") as file:
        file.write(b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(116) + b"\0" * 8 + b"\0\2IM")
    return path


def both(tmp_path):
    savemat(tmp_path / "v5.mat", {"t": T[:, None], "xy": np.stack([X, 2 * X], axis=1), "g": 35.0, "who": "me",
                                  "s": {"v": X[None, :], "k": np.int16([1, 2, 3])}})  # fmt: skip

    def write(file):
        file["t"] = T[None, :]
        file["xy"] = np.stack([X, 2 * X])
        file["g"] = np.array([[35.0]])
        file["who"] = np.array([[ord("m")], [ord("e")]], dtype="u2")
        file["who"].attrs["MATLAB_class"] = np.bytes_("char")
        file["s/v"] = X[:, None]
        file["s/k"] = np.array([[1], [2], [3]], dtype="i2")
        file["#refs#/a"] = [1.0]

    return tmp_path / "v5.mat", v73(tmp_path / "v73.mat", write)


def test_vectors_matrices_structs_and_scalars(tmp_path):
    for path in both(tmp_path):
        found = table(path)
        names = [column.name for column in found.columns]
        assert sorted(names) == ["s.k", "s.v", "t", "xy(:,1)", "xy(:,2)"]
        assert found.constants == {"g": "35.0", "who": "me"}


def test_long_vectors_come_in_blocks(tmp_path):
    document = tmp_path / "map.yaml"
    document.write_text(
        "fric: mapping/1\ncolumns:\n  time: {column: t, unit: s}\n  position: {column: 'xy(:,2)', unit: mm}\n"
        "  velocity: {column: s.v, unit: mm/s}\n  force: {column: s.v, scale: '{g} N'}\n"
    )
    for path in both(tmp_path):
        ingest(path, tmp_path / f"{path.stem}.h5", mapping=read_document(document, MappingDocument))
        (log,) = read_logs(tmp_path / f"{path.stem}.h5")
        np.testing.assert_array_equal(log.time, T)
        np.testing.assert_allclose(log.position, 2e-3 * X, rtol=1e-15)
        np.testing.assert_allclose(log.force, 35 * X, rtol=1e-15)


def test_columns_of_different_length_are_told(tmp_path):
    path, _ = both(tmp_path)
    document = tmp_path / "map.yaml"
    document.write_text("fric: mapping/1\ncolumns: {time: {column: t, unit: s}, position: {column: s.k, unit: mm}}\n")
    with pytest.raises(FricError, match=r"differ in length: 't' 200000, 's\.k' 3"):
        ingest(path, tmp_path / "log.h5", mapping=read_document(document, MappingDocument))


def test_signals_as_dspace_writes_them(tmp_path):
    signals = np.array([("x position", X), ("force", 2 * X)], dtype=[("Name", "O"), ("Data", "O")])
    savemat(tmp_path / "v5.mat", {"run1": {"X": {"Name": "time", "Data": T}, "Y": signals}})

    def write(file):
        def text(name, value):
            file[name] = np.array([[ord(c)] for c in value], dtype="u2")
            file[name].attrs["MATLAB_class"] = np.bytes_("char")
            return file[name].ref

        names = [text("#refs#/a", "x position"), text("#refs#/b", "force")]
        data = []
        for name, values in (("c", X), ("d", 2 * X)):
            file[f"#refs#/{name}"] = values[:, None]
            data.append(file[f"#refs#/{name}"].ref)
        file.create_dataset("run1/Y/Name", data=np.array([names]).T, dtype=h5py.ref_dtype)
        file.create_dataset("run1/Y/Data", data=np.array([data]).T, dtype=h5py.ref_dtype)
        text("run1/X/Name", "time")
        file["run1/X/Data"] = T[:, None]

    for path in (tmp_path / "v5.mat", v73(tmp_path / "v73.mat", write)):
        for found in tables(path):  # the file is open meanwhile
            assert sorted(column.name for column in found.columns) == ["force", "time", "x position"]
            columns = [block.columns[0] for block in found.blocks([found.find("force", "force")])]
            np.testing.assert_array_equal(np.concatenate(columns), 2 * X)


@pytest.mark.parametrize("version", [0, 1])
def test_a_file_that_is_cut_short(tmp_path, version):
    path = both(tmp_path)[version]
    path.write_bytes(path.read_bytes()[:5000])
    with pytest.raises(FricError, match="not a complete MATLAB file"):
        table(path)


def test_nothing_to_read(tmp_path):
    savemat(tmp_path / "empty.mat", {"note": "nothing", "g": 3.0})
    with pytest.raises(FricError, match="holds no vector of numbers"):
        table(tmp_path / "empty.mat")


def test_what_a_reading_process_gives_is_values_alone():
    for made in (np.arange(3.0), {"a": [np.float64(1.0), "text"]}, np.array([{"b": 2.0}], dtype=object)):
        again = _Values(io.BytesIO(pickle.dumps(made, protocol=5))).load()
        assert str(again) == str(made)
    with pytest.raises(pickle.UnpicklingError, match="is no value"):
        _Values(io.BytesIO(pickle.dumps(print))).load()


def stroke(n: int, seed: int) -> dict[str, np.ndarray]:
    t = np.arange(n) * 1e-3
    v = 0.05 * np.sign(np.sin(2 * np.pi * t / 0.4)) * (1.0 + 0.2 * seed)
    v = np.convolve(v, np.hanning(40) / np.hanning(40).sum(), "same")
    current = np.tanh(v / 1e-3) + 0.02 * np.random.default_rng(seed).standard_normal(n)
    return {"t": t, "pos": np.cumsum(v) * 1e-3, "vel": v, "cur": current}


@pytest.mark.parametrize("nest", ["structs", "cell", "matrices", "struct-array"])
def test_records_of_one_file_are_records(tmp_path, nest):
    """Strokes of different lengths as structs, in a cell, as a matrix each, in an array of structs; gains beside."""
    runs = [stroke(1500 + 100 * k, k) for k in range(3)]
    path = tmp_path / "runs.mat"
    if nest == "structs":
        found = {f"run{k}": one for k, one in enumerate(runs)}
    elif nest == "matrices":
        found = {f"run{k}": np.column_stack(list(one.values())) for k, one in enumerate(runs)}
    elif nest == "cell":
        cell = np.empty(3, dtype=object)
        cell[:] = runs
        found = {"runs": cell}
    else:
        array = np.empty(3, dtype=[(name, object) for name in runs[0]])
        for k, one in enumerate(runs):
            array[k] = tuple(one.values())
        found = {"runs": array}
    savemat(path, found | {"gain": np.array([1.0, 2.0, 3.0])})
    done = fric.ingest(path, output=tmp_path / "log.h5", assume=True)
    logs = read_logs(tmp_path / "log.h5")
    assert sorted(len(log) for log in logs) == [1500, 1600, 1700]
    assert len({log.name for log in logs}) == 3
    assert all(log.force is not None and log.position is not None for log in logs)
    assert done.done.motion.endswith("/A") or nest == "matrices"


@pytest.mark.parametrize("ending", ["h5", "mat"])
def test_strokes_in_groups_of_two_axes_are_of_two_axes(tmp_path, ending):
    """/X/stroke1, /X/stroke2, /Y/stroke1 and /Y/stroke2 were four strokes of one axis x, with the friction of both."""
    names, path = ("time_s", "position_m", "velocity_m_s", "current_A"), tmp_path / f"strokes.{ending}"
    runs = {
        axis: {f"stroke{k}": dict(zip(names, stroke(1500 + 100 * k + more, k).values(), strict=True)) for k in (1, 2)}
        for axis, more in (("X", 0), ("Y", 10))
    }
    if ending == "mat":
        savemat(path, runs)
    else:
        with h5py.File(path, "w") as file:
            for axis, of in runs.items():
                for name, one in of.items():
                    for key, values in one.items():
                        file[f"{axis}/{name}/{key}"] = values
    found = find_sources([path], proposals=tmp_path / "proposed")
    assert not found.refused
    assert {log.axis: log.strokes for log in found.logs} == {"x": 17, "y": 17}
    for axis, of in runs.items():
        fric.ingest(path, output=tmp_path / f"{axis}.h5", axis=axis.lower())
        logs = {log.name: log for log in read_logs(tmp_path / f"{axis}.h5")}
        assert logs.keys() == {f"strokes-{axis}.{name}" for name in of}
        for name, one in of.items():
            np.testing.assert_array_equal(logs[f"strokes-{axis}.{name}"].position, one["position_m"])


def test_structs_of_matrices_are_experiments(tmp_path):
    """Each matrix of two structs with the same fields passed for a record, of which none has a force."""
    one = {name: np.random.default_rng(n).normal(size=(300, 3)) for n, name in enumerate(("q", "dq", "tau"))}
    savemat(tmp_path / "a.mat", {"data": {"identification": one | {"Ts": 0.002}, "validation": one | {"Ts": 0.002}}})
    found = list(tables(tmp_path / "a.mat"))
    assert [[column.name for column in table.columns][::3] for table in found] == 2 * [
        ["q(:,1)", "dq(:,1)", "tau(:,1)"]
    ]
