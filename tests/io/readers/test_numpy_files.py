"""NumPy's archives and arrays: variables by name, fields of structured arrays, matrices; and what is not read."""

import pickle

import numpy as np
import pytest

from fric.errors import FricError
from fric.io.ingest import ingest
from fric.io.readers import structured, tables
from tests.io.readers.test_structured import read
from tests.io.test_roles import axis_of_a_drive, told

A = axis_of_a_drive(n=1500)
OTHER = {name: values[1500:3000] for name, values in axis_of_a_drive(n=3000, seed=1).items()}


@pytest.mark.parametrize("save", [np.savez, np.savez_compressed])
def test_arrays_of_joints_are_axes_of_a_record(tmp_path, save):
    both = {name: np.column_stack([A[of], OTHER[of]]) for name, of in
            (("q", "position"), ("dq", "velocity"), ("tau", "current"))}  # fmt: skip
    save(tmp_path / "run.npz", t=A["t"], note="a day", names=np.array(["a", "b", "c"]), **both)
    axes = told(tmp_path / "run.npz")
    assert [{channel: role.column for channel, role in axis.roles.items()} for axis in axes] == [
        {"time": 0, "position": 1, "velocity": 3, "force": 5}, {"time": 0, "position": 2, "velocity": 4, "force": 6}
    ]  # fmt: skip
    assert all(axis.roles["position"].unit == "rad" and axis.roles["position"].unit_likelihood > 0.95 for axis in axes)


def test_fields_of_a_structured_array_are_columns(tmp_path):
    log = np.zeros(1500, [("stamp", "M8[us]"), ("position [rad]", "f4"), ("torque [N*m]", "f8", (1,)), ("on", "?")])
    log["stamp"] = np.datetime64("2024-05-06T07:08:09") + np.arange(1500) * np.timedelta64(1000, "us")
    log["position [rad]"], log["torque [N*m]"] = A["position"], A["current"][:, None]
    np.save(tmp_path / "run.npy", log)
    found = read(tmp_path / "run.npy")
    assert np.diff(found["stamp"][1]) == pytest.approx(1e-3, abs=1e-6)
    assert found["position"] == ("rad", pytest.approx(A["position"], rel=1e-6))
    assert found["torque"] == ("N*m", pytest.approx(A["current"]))


@pytest.mark.parametrize("order", ["C", "F"])
def test_a_matrix_is_a_table(tmp_path, order):
    np.save(tmp_path / "run.npy", np.array(np.column_stack([A["t"], A["position"], A["current"]]), order=order))
    (axis,) = told(tmp_path / "run.npy")
    assert {of: role.column for of, role in axis.roles.items()} == {"time": 0, "position": 1, "force": 2}


class Trap:
    def __reduce__(self):
        return pytest.fail, ("a file was unpickled",)


def test_objects_are_not_unpickled(tmp_path):
    """Beside arrays they are left out; alone there is nothing to read."""
    trap = np.array([Trap(), None], object)
    np.savez(tmp_path / "run.npz", trap=trap, t=A["t"], x=A["position"])
    assert [*read(tmp_path / "run.npz")] == ["t", "x"]
    np.save(tmp_path / "dict.npy", trap, allow_pickle=True)
    np.save(tmp_path / "field.npy", np.array([(1.0, Trap())], [("t", "f8"), ("o", "O")]), allow_pickle=True)
    (tmp_path / "plain.npy").write_bytes(pickle.dumps(Trap()))
    for name in ("dict", "field", "plain"):
        with pytest.raises(FricError):
            next(tables(tmp_path / f"{name}.npy"))


def test_what_is_cut_lies_or_is_too_large_ends_in_a_sentence(tmp_path, monkeypatch):
    np.save(tmp_path / "cut.npy", A["t"])
    whole = (tmp_path / "cut.npy").read_bytes()
    (tmp_path / "cut.npy").write_bytes(whole[:-400])
    (tmp_path / "lies.npy").write_bytes(whole.replace(b"(1500,)", b"(10**9999,)"[:7]))
    (tmp_path / "huge.npy").write_bytes(whole.replace(b"(1500,), }        ", b"(99999999999999,),}"[:18]))
    np.savez(tmp_path / "large.npz", t=A["t"], x=A["position"])
    (tmp_path / "cut.npz").write_bytes((tmp_path / "large.npz").read_bytes()[:-40])
    monkeypatch.setattr(structured, "MOST_UNPACKED", 20_000)
    for name in ("cut.npy", "lies.npy", "huge.npy", "large.npz", "cut.npz"):
        with pytest.raises(FricError) as error:
            ingest(tmp_path / name, tmp_path / "log.h5")
        assert name in error.value.where
