import json
from pathlib import Path

import pytest
from typer.testing import CliRunner

from fric.cli.main import app
from fric.errors import FricError
from fric.io.hdf5 import read_logs

RUN = CliRunner()
MACHINE = str(Path("configs/xy-table.yaml").resolve())


def test_an_experiment_is_a_log_file_that_names_its_machine(tmp_path: Path) -> None:
    out = tmp_path / "log.h5"
    words = ["simulate", "experiment", MACHINE, "--axis", "y", "--kind", "presliding-sine", "--amplitudes", "15 um"]
    done = RUN.invoke(app, [*words, "--samples", "400", "--seed", "2", "-o", str(out), "--json"])
    assert done.exit_code == 0, done.output
    told = json.loads(done.stdout)
    (log,) = read_logs(out)
    assert told == {"axis": "y", "records": {"presliding-sine-01": {"kind": "presliding-sine", "samples": len(log)}}}
    assert (log.axis, log.kind) == ("y", "presliding-sine")
    assert isinstance(RUN.invoke(app, [*words, "-o", str(out)]).exception, FricError)  # the output is kept


def test_noise_and_encoder_can_be_switched_off(tmp_path: Path) -> None:
    out = tmp_path / "log.h5"
    words = ["simulate", "experiment", MACHINE, "--kind", "constant-velocity", "--speeds", "10 mm/s", "-o", str(out)]
    assert RUN.invoke(app, [*words, "--encoder", "0 um", "--noise", "0 N"]).exit_code == 0
    (log,) = read_logs(out)
    assert log.force is not None
    still = log.force[len(log) // 4 : len(log) // 4 + 100]
    assert still.std() < 1e-3


@pytest.mark.parametrize("words", [["--axis", "q"], ["--kind", "drop"], ["--noise", "3 V"]])
def test_what_cannot_be_simulated_leaves_no_file(tmp_path: Path, words: list[str]) -> None:
    out = tmp_path / "log.h5"
    done = RUN.invoke(app, ["simulate", "experiment", MACHINE, "--kind", "sliding-sine", "-o", str(out), *words])
    assert isinstance(done.exception, FricError)
    assert not list(tmp_path.iterdir())
