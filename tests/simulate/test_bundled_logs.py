"""The logs in data/ are what the code makes of configs/virtual-rig.yaml now."""

from pathlib import Path

import numpy as np
import pytest

from fric.documents.machine_files import read_machine
from fric.friction.directed import Directed
from fric.friction.rolling import Rolling
from fric.io.hdf5 import read_logs
from fric.simulate.experiment import experiment

RIG = read_machine(Path("configs/virtual-rig.yaml"))


@pytest.mark.parametrize(
    ("kind", "seed", "settings"),
    [
        pytest.param("constant-velocity", 1, {"samples": 600, "speeds": [1e-5, 4e-5]}, marks=pytest.mark.long(7)),
        pytest.param("presliding-sine", 2, {"samples": 2500}, marks=pytest.mark.long(6)),
        ("sliding-sine", 3, {"samples": 3500}),
        ("frequency-response", 4, {}),
    ],
)
def test_bundled_logs_are_made_again(kind: str, seed: int, settings: dict[str, object]) -> None:
    """The same to the last digit on one machine; elsewhere the last digit of an exp moves an encoder count, and that
    every later one: a slow axis hunts within some counts, and its force within what a count is worth before sliding."""
    axis = RIG.axis("x")
    bundled = {log.name: log.channels() for log in read_logs(Path(f"data/{kind}.h5"))}
    for log in experiment(axis, kind, seed=seed, **settings):
        off = {channel: values - bundled[log.name][channel] for channel, values in log.channels().items()}
        np.testing.assert_array_equal(off["time"], 0.0)
        np.testing.assert_allclose(off["reference"], 0.0, atol=1e-15)
        assert np.abs(off["position"]).max() < 10 * axis.encoder.resolution
        assert off["force"].std() < sum(axis.friction.model.k) * axis.encoder.resolution


def test_the_rig_is_richer_than_the_models_that_are_identified() -> None:
    for axis in RIG.axes.values():
        assert isinstance(axis.friction, Directed)
        friction = axis.friction.model
        assert isinstance(friction, Rolling)
        assert len(friction.alpha) >= 10
        assert abs(axis.load) > 1.0
        forward, back = (float(axis.friction.steady_state(v)) for v in (0.01, -0.01))
        assert 0.02 < abs(forward + back) / forward < 0.08
        assert len(friction.amplitude) == 3
        assert friction.C != 1e4


def test_friction_of_the_rig_varies_along_its_stroke() -> None:
    friction = RIG.axis("x").friction
    time = np.arange(0, 10.0, 1e-3)
    force = friction.replay(time, 0.01 * time)[2000:]
    assert 0.02 < np.ptp(force) / force.mean() < 0.12
