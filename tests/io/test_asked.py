"""What is asked about, proposed, cut and told together, from files as drives and tribometers write them."""

import json
from contextlib import ExitStack
from pathlib import Path

import h5py
import numpy as np
import pytest
from typer.testing import CliRunner

from fric.cli.main import app
from fric.documents.mapping import MappingDocument
from fric.documents.yaml import read_document
from fric.errors import FricError
from fric.io.hdf5 import read_logs
from fric.io.ingest import ingest
from fric.io.propose import NO_FORCE, guesses, proposal
from fric.io.questions import _written
from fric.io.readers.base import Column, named
from fric.io.words import named_as

RUN = CliRunner()
TRIBOMETER = "Time [s]\tNormal [uN]\tPosition [mm]\tFriction [uN]\n" + "".join(
    f"{0.01 * n:.2f}\t{500 + n % 7}\t{0.1 * np.sin(0.1 * n):.4f}\t{200 * np.sign(np.cos(0.1 * n)) + n % 5}\n"
    for n in range(200)
)
PLAIN = "time [s], position [um], force [N]\n" + "".join(f"{0.01 * n:.2f}, {n}, {5 + n % 3}\n" for n in range(1, 200))


def written(folder: Path, **files: str) -> list[Path]:
    for name, text in files.items():
        (folder / f"{name}.csv").write_text(text)
    return [folder / f"{name}.csv" for name in files]


def fric(*words):
    done = RUN.invoke(app, list(map(str, words)))
    if done.exception is not None:
        raise done.exception
    return done


def test_a_force_of_unknown_name_is_asked_about_and_not_left_out(tmp_path: Path) -> None:
    (file,) = written(tmp_path, tribometer=TRIBOMETER)
    with pytest.raises(FricError) as error:
        ingest(file, tmp_path / "log.h5")
    assert "'Friction [uN]' and 'Normal [uN]' look like it" in error.value.what
    assert "--propose" in error.value.hint
    assert not (tmp_path / "log.h5").exists()


@pytest.mark.parametrize(
    ("header", "asked"),
    [
        ("time [s], position [um], Kraft [N]", "force"),
        ("time [s], position [um], torque sensor", "force"),
        ("time [s], force [N], Weg [mm]", "position"),
        ("time [s], force [N], Drehzahl [rpm]", "position"),
        ("time [s], velocity [mm/s], load cell [mN]", "force"),
    ],
)
def test_what_looks_like_a_channel_is_told_by_name_or_unit(tmp_path: Path, header: str, asked: str) -> None:
    (file,) = written(tmp_path, log=header + "\n" + "".join(f"{n}, {n}, {n % 3}\n" for n in range(50)))
    with pytest.raises(FricError) as error:
        ingest(file, tmp_path / "log.h5")
    assert "look" in error.value.what or "no column is position or velocity" in error.value.what


@pytest.mark.parametrize("more", ["temperature [degC]", "following error [um]", "status", "reference velocity [um/s]"])
def test_what_is_no_channel_is_left_out_as_before(tmp_path: Path, more: str) -> None:
    text = PLAIN.replace("force [N]\n", f"force [N], {more}\n").replace("\n", ", 1\n").replace(f"{more}, 1", more)
    (file,) = written(tmp_path, log=text)
    done = ingest(file, tmp_path / "log.h5")
    assert done.records[0].channels.keys() == {"time", "position", "force"}


def test_a_proposal_reads_and_ingests_once_it_is_looked_at(tmp_path: Path) -> None:
    (file,) = written(tmp_path, tribometer=TRIBOMETER)
    text = fric("ingest", file, "--propose", tmp_path / "map.yaml").stdout
    assert "or 'Normal'" in text
    assert "# not read: Normal" in text
    mapping = read_document(tmp_path / "map.yaml", MappingDocument)
    done = ingest(file, tmp_path / "log.h5", mapping=mapping)
    assert done.records[0].channels == {"time": "Time", "position": "Position", "force": "Friction"}
    with pytest.raises(FricError, match="exists"):
        fric("ingest", file, "--propose", tmp_path / "map.yaml")


def test_a_proposal_reads_a_file_of_matlab_7_3_while_it_is_open(tmp_path: Path) -> None:
    """No name is a time: the values are asked, and that was after the file had been closed."""
    file = tmp_path / "log.mat"
    with h5py.File(file, "w", userblock_size=512) as content:
        for name, values in (("a", np.arange(50) * 1e-3), ("b", np.sin(np.arange(50.0))), ("c", np.ones(50))):
            content.create_dataset(name, data=values[None, :])
    content = bytearray(file.read_bytes())
    content[:128] = b"MATLAB 7.3 MAT-file".ljust(124) + b"\0\2IM"
    file.write_bytes(content)
    assert "time: {column: " in proposal([file])
    with ExitStack() as opened:
        assert not all(guess.sure for guess in guesses([file], opened))


def test_the_mapping_of_answers_is_written_elsewhere_where_the_folder_of_logs_is_read_only(tmp_path: Path) -> None:
    (tmp_path / "logs").write_text("no folder lets itself be made here")
    written = _written("fric: mapping/1\n", tmp_path / "logs" / "of", tmp_path / "found" / "mappings")
    assert written == tmp_path / "found" / "mappings" / "fric-mapping.yaml"


def test_a_unit_of_revolutions_is_known() -> None:
    assert named("angle (rev)") == Column("angle", "rev")


def test_a_proposal_says_what_it_does_not_know(tmp_path: Path) -> None:
    rows = "".join(f"{n * 0.5}; {n}; {n % 4}\n" for n in range(50))
    (file,) = written(tmp_path, drive="t; Speed [rpm]; Torque [%]\n" + rows)
    text = proposal([file])
    assert "motion: rotary/%" in text
    assert 'unit: "%"' in text
    assert 'unit: "?"' in text
    other, *_ = written(tmp_path, other="a; b\n1; 2\n2; 3\n3; 4\n")
    both = proposal([file, other])
    assert both.count("    columns:") == 2
    assert 'files: "drive.csv"' in both


def test_a_window_takes_the_samples_between_two_times(tmp_path: Path) -> None:
    (file,) = written(tmp_path, log=PLAIN)
    ingest(file, tmp_path / "log.h5", window=(0.5, 1.0))
    (log,) = read_logs(tmp_path / "log.h5")
    np.testing.assert_allclose([log.time[0], log.time[-1]], [0.5, 1.0])
    assert len(log) == 51
    with pytest.raises(FricError, match=r"has 0 samples between `begin=` and `end=`, of 0\.01 to 1\.99 s"):
        ingest(file, tmp_path / "none.h5", window=(50.0, 60.0))


def test_all_files_that_cannot_be_read_are_told_at_once(tmp_path: Path) -> None:
    bad = PLAIN.replace("0.50, 50, 7", "0.50, oops, 7")
    first, fine, second, third = written(tmp_path, first="nothing\n", fine=PLAIN, second=bad, third=TRIBOMETER)
    with pytest.raises(FricError) as error:
        ingest([first, fine, second, third], tmp_path / "log.h5")
    lines = error.value.what.splitlines()
    assert lines[0] == "3 of 4 files cannot be read:"
    assert [name in line for name, line in zip(("first", "second", "third"), lines[1:], strict=True)] == [True] * 3
    assert not (tmp_path / "log.h5").exists()


def test_the_command_proposes_and_cuts(tmp_path: Path) -> None:
    (file,) = written(tmp_path, tribometer=TRIBOMETER)
    fric("ingest", file, "--propose", tmp_path / "map.yaml")
    log = tmp_path / "log.h5"
    told = fric(
        "ingest", file, "--map", tmp_path / "map.yaml", "--from", "500 ms", "--to", "1.5 s", "-o", log, "--json"
    )
    assert json.loads(told.stdout)["samples"] == 101


@pytest.mark.parametrize(
    ("name", "channel"),
    [
        ("PosAct", "position"), ("Axis 1.NcToPlc.ActPos", "position"), ("LageIst", "position"), ("Istlage", "position"),
        ("TrqAct", "force"), ("Motorkraft", "force"), ("ActVelo", "velocity"), ("Drehzahl", "velocity"),
        ("SetPos", "reference"), ("u_cmd", "reference"), ("Lage-Sollwert", "reference"), ("Preset", None),
        ("Momentanwert", None), ("Offset", None), ("Following error", "error"), ("position error", "error"),
        ("Tempo", "time"), ("Posizione asse", "position"), ("Riferimento", "reference"), ("Coppia", "force"),
        ("Position de consigne", "reference"), ("Vitesse", "velocity"), ("Thermocouple", None), ("Belt tension", None),
    ],
)  # fmt: skip
def test_what_names_of_columns_tell(name, channel):
    assert named_as(Column(name, "mm")) == channel


@pytest.mark.parametrize(
    ("header", "channel", "unit"),
    [
        ("t_ms", "time", "ms"), ("time_s", "time", "s"), ("PosAct_mm", "position", "mm"), ("FrcAct_N", "force", "N"),
        ("PosCmd_mm", "reference", "mm"), ("u_V", "input", "V"), ("F_N", None, None), ("x_m", None, None),
        ("q_rad", "position", "rad"), ("Trq_Nm", "force", "Nm"),
    ],
)  # fmt: skip
def test_names_that_end_in_their_unit(header, channel, unit):
    """F_N is a normal force, and x_m the position of a motor, or a mean."""
    column = named(header)
    assert (named_as(column), column.unit) == (channel, unit)


def test_a_file_with_names_that_end_in_their_units_needs_no_mapping_by_hand(tmp_path: Path) -> None:
    rows = "\n".join(f"{k},{k / 100},{np.sin(k / 9):.4f},{0.5 * np.cos(k / 9):.4f},{k / 100}" for k in range(60))
    (file,) = written(tmp_path, a="t_ms,PosAct_mm,FrcAct_N,Ctrl_V,PosCmd_mm\n" + rows)
    mapping = tmp_path / "map.yaml"
    mapping.write_text(proposal([file]))
    fric("ingest", file, "--map", mapping, "-o", tmp_path / "log.h5")
    (log,) = read_logs(tmp_path / "log.h5")
    assert log.time[-1] == pytest.approx(0.059)
    assert log.position[-1] == pytest.approx(0.59e-3)
    assert set(log.channels()) == {"time", "position", "force", "input", "reference"}


def test_where_nothing_is_asked_it_is_said_what_no_column_is(tmp_path):
    """A force in kg, which is none, was left out, and "0 questions" were open."""
    t = np.arange(4000) / 1000
    turn = np.where(t % 2 < 1, 1.0, -1.0)
    rows = np.c_[t, np.cumsum(0.02 * turn), 6 * turn + 0.1 * np.random.default_rng(2).normal(size=len(t))]
    head = "time [s],position [mm],force [kg]"
    np.savetxt(tmp_path / "a.csv", rows, delimiter=",", header=head, comments="", fmt="%.6g")
    with pytest.raises(FricError) as refused:
        fric("ingest", tmp_path / "a.csv", "-o", tmp_path / "a.h5")
    assert NO_FORCE in str(refused.value)
    assert "# not read: force" in str(refused.value)
