"""`fric identify gms` from the bundled logs to the friction file."""

import json
from pathlib import Path

import pytest
from typer.testing import CliRunner

from fric import FricError
from fric.cli.main import app
from fric.documents.friction import FrictionDocument
from fric.documents.yaml import read_document

DATA = Path(__file__).parents[2] / "data"
LOGS = [str(DATA / "presliding-sine.h5"), str(DATA / "sliding-sine.h5")]
RUN = CliRunner()


def run(*words):
    result = RUN.invoke(app, ["identify", "gms", *map(str, words)], catch_exceptions=True)
    if result.exception and not isinstance(result.exception, SystemExit):
        raise result.exception
    return result


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    folder = tmp_path_factory.mktemp("gms")
    static = folder / "static.yaml"
    words = ["identify", "static", str(DATA / "constant-velocity.h5"), "-o", str(static)]
    assert RUN.invoke(app, words).exit_code == 0
    output, figure = folder / "friction.yaml", folder / "loops.png"
    words = ["--static", static, "--blocks", "3"]  # how many there are is chosen in the session of the README
    result = run(*LOGS, *words, "-o", output, "--plot", figure, "--json")
    return static, output, figure, json.loads(result.stdout)


def test_the_document_reads_back_and_gives_the_model(made):
    static, output, figure, printed = made
    document = read_document(output, FrictionDocument)
    gms = document.friction("gms")
    assert sum(gms.alpha) == pytest.approx(1.0, abs=1e-9)
    assert (gms.slip_displacements[1:] > gms.slip_displacements[:-1]).all()
    assert document.friction("static") == read_document(static, FrictionDocument).friction("static")
    assert printed["gms"]["C"]["ci95"][0] < printed["gms"]["C"]["value"] < printed["gms"]["C"]["ci95"][1]
    assert len(printed["gms"]["alpha"]["ci95"]) == len(gms.alpha)
    assert printed["gms_fit"]["blocks"].startswith(f"{len(gms.alpha)} blocks")
    assert printed["provenance"]["static"]["logs"]
    assert figure.stat().st_size > 50_000


def test_outputs_that_exist_are_kept(made, tmp_path):
    _, output, _, _ = made
    before = output.read_bytes()
    with pytest.raises(FricError, match="exists"):
        run(*LOGS, "-o", output)
    assert output.read_bytes() == before


def test_knots_by_hand_without_refinement(made, tmp_path):
    static, *_ = made
    output = tmp_path / "f.yaml"
    run(LOGS[0], "--static", static, "-o", output, "--knots", "0.7 um, 3 um, 15 um, 60 um", "--no-refine")
    document = read_document(output, FrictionDocument)
    displacement = document.friction("gms").slip_displacements
    assert displacement * 1e6 == pytest.approx([0.7, 3, 15, 60], rel=0.05)
    assert document.estimates("gms")["C"].assumed


@pytest.mark.parametrize(
    ("words", "what"),
    [
        (["--blocks", "0"], "number of blocks"),
        (["--blocks", "many"], "number of blocks"),
        (["--cycles", "3"], "range of cycles"),
        (["--knots", "1, 2"], "no unit"),
        (["--knots", "1 um, 2 um", "--blocks", "3"], "2 knots give 2 blocks"),
        (["--knots", "2 um, 1 um"], "do not increase"),
    ],
)
def test_wrong_options_are_told(tmp_path, words, what):
    with pytest.raises(FricError, match=what):
        run(LOGS[0], "-o", tmp_path / "f.yaml", *words)
    assert not list(tmp_path.iterdir())
