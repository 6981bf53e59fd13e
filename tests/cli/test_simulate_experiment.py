import json
from pathlib import Path

import pytest
from typer.testing import CliRunner

from fric.cli.main import app
from fric.errors import FricError
from fric.identify.plant.identify import identify_plant
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
    records = {"presliding-sine-01": {"kind": "presliding-sine", "samples": len(log)}}
    wanted = {"fric": "records/1", "axis": "y", "records": records, "warnings": [], "warnings_coded": []}
    assert {key: told[key] for key in told if key != "provenance"} == wanted
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


@pytest.mark.long(7)  # tests/identify/test_plant.py has the same of records that are made faster
def test_two_amplitudes_around_rest_tell_what_friction_adds(tmp_path: Path) -> None:
    """The records hold A + F_c/M times friction's gain; that line, drawn back to gain 0, is the true A and viscous."""
    log, plant = str(tmp_path / "log.h5"), str(tmp_path / "plant.yaml")
    words = ["simulate", "experiment", MACHINE, "--kind", "frequency-response", "-o", log]
    assert RUN.invoke(app, [*words, "--mean", "0 mm/s", "--peaks", "15 mm/s, 60 mm/s"]).exit_code == 0
    assert all(abs(record.position.mean()) < 1e-3 for record in read_logs(log))
    done = RUN.invoke(app, ["identify", "plant", log, "-o", plant, "--json"])
    assert done.exit_code == 0, done.exception
    told = json.loads(done.stdout)
    assert told["fit"]["friction"]["seen"]
    small, large = (response["A"]["value"] for response in told["fit"]["responses"])
    true = 28.57 + 40 / 121
    assert small - true > 2 * (large - true) > true  # at a quarter of the speed friction adds more than twice as much
    low, high = told["A"]["ci95"]
    assert low < true < high
    assert told["A"]["value"] < large


@pytest.mark.parametrize("seed", ["3", pytest.param("6", marks=pytest.mark.long(5))])
def test_friction_around_rest_is_no_second_mass_and_has_the_sign_of_friction(tmp_path: Path, seed: str) -> None:
    """The spring of friction at 15 mm/s was taken for a second mass, and A was 10721 1/s to all digits told."""
    log = str(tmp_path / "log.h5")
    words = ["simulate", "experiment", MACHINE, "--kind", "frequency-response", "-o", log, "--seed", seed]
    assert RUN.invoke(app, [*words, "--mean", "0 mm/s", "--peaks", "15 mm/s, 60 mm/s"]).exit_code == 0
    fit = identify_plant(read_logs(log))
    assert fit.second_mass is None
    assert fit.friction.coulomb is not None
    assert float(fit.friction.coulomb) * 121 == pytest.approx(105, rel=0.6)
    low, high = fit.estimates["A"].ci95
    assert low < 28.57 + 40 / 121 < high


@pytest.mark.parametrize("words", [["--axis", "q"], ["--kind", "drop"], ["--noise", "3 V"]])
def test_what_cannot_be_simulated_leaves_no_file(tmp_path: Path, words: list[str]) -> None:
    out = tmp_path / "log.h5"
    kind = [] if "--kind" in words else ["--kind", "sliding-sine"]
    done = RUN.invoke(app, ["simulate", "experiment", MACHINE, *kind, "-o", str(out), *words])
    assert isinstance(done.exception, FricError)
    twice = RUN.invoke(app, ["simulate", "experiment", MACHINE, "--axis", "x", "--axis", "y", "-o", str(out)])
    assert (
        twice.exit_code == 2
    )  # the first was overwritten without a word: a second --map left the logs of the first out
    assert "--axis is given twice" in twice.output
    assert not list(tmp_path.iterdir())
